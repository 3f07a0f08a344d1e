!> Sets of choices that the tables of what can be chosen tell, by which the tables of keys and of rules mean them: in braces, as in
!> `&energy_release estimators = {estimators at nodes}`.
module hampm_choice_sets
   use hampm_kinds, only: name_len
   use hampm_estimators, only: estimators
   use hampm_laws, only: laws
   implicit none
   private
   public :: expanded

contains

   !> A text with the names of each set in the place of its braces.
   pure function expanded(text, quote, separator)
      character(*), intent(in) :: text
      character(*), intent(in) :: quote          !! around each name
      character(*), intent(in) :: separator      !! between names
      character(:), allocatable :: expanded, list
      character(name_len), allocatable :: names(:)
      integer :: from, behind, k
      expanded = trim(text)
      list = ''
      do
         from = index(expanded, '{')
         if (from == 0) return
         behind = index(expanded, '}')
         allocate (names, source=names_of(expanded(from + 1:behind - 1)))
         list = ''
         do k = 1, size(names)
            if (k > 1) list = list//separator
            list = list//quote//trim(names(k))//quote
         end do
         expanded = expanded(:from - 1)//list//expanded(behind + 1:)
         deallocate (names)
      end do
   end function expanded

   !> The names of a set.
   pure function names_of(set) result(names)
      character(*), intent(in) :: set
      character(name_len), allocatable :: names(:)
      logical, allocatable :: is_in(:)
      if (index(set, 'laws') == 1) then
         associate (rows => laws())
            allocate (is_in(size(rows)), source=.true.)
            if (set == 'laws with a history') is_in = rows%has_history
            if (set == 'laws of any strain') is_in = rows%is_finite
            allocate (names, source=pack(rows%name, is_in))
         end associate
         return
      end if
      associate (rows => estimators())
         allocate (is_in(size(rows)), source=.true.)
         select case (set)
          case ('estimators at nodes')
            is_in = rows%needs_nodes
          case ('estimators by radii')
            is_in = rows%needs_radii
          case ('estimators of elastic material')
            is_in = rows%needs_elasticity
          case ('estimators of isotropic material')
            is_in = rows%needs_isotropy
          case ('estimators for traction-free faces')
            is_in = rows%needs_free_faces
          case ('estimators for stationary tips')
            is_in = rows%needs_tip_at_rest
         end select
         allocate (names, source=pack(rows%name, is_in))
      end associate
   end function names_of
end module hampm_choice_sets
