!> Sets of choices that the tables of what can be chosen tell, by which the tables of keys and of rules mean them: in braces, as in
!> `&energy_release estimators = {estimators at nodes}`.
module hampm_choice_sets
   use hampm_kinds, only: name_len
   use hampm_estimators, only: estimators
   use hampm_growth_laws, only: growth_laws
   use hampm_indicators, only: indicators
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
      associate (law => laws(), estimator => estimators(), growth => growth_laws(), indicator => indicators())
         select case (set)
          case ('laws')
            names = law%name
          case ('laws with a history')
            names = pack(law%name, law%has_history)
          case ('laws of any strain')
            names = pack(law%name, law%is_finite)
          case ('growth laws')
            names = growth%name
          case ('growth laws at rest')
            names = pack(growth%name, growth%is_static)
          case ('growth laws in motion')
            names = pack(growth%name, .not. growth%is_static)
          case ('growth laws in motion by toughness')
            names = pack(growth%name, .not. (growth%is_static .or. growth%gives_speed()))
          case ('growth laws by speed')
            names = pack(growth%name, growth%gives_speed())
          case ('indicators')
            names = indicator%name
          case ('indicators of the motion')
            names = pack(indicator%name, .not. indicator%is_of_places)
          case ('indicators of one body')
            names = pack(indicator%name, indicator%is_of_one_body)
          case ('estimators')
            names = estimator%name
          case ('estimators at nodes')
            names = pack(estimator%name, estimator%needs_nodes)
          case ('estimators by radii')
            names = pack(estimator%name, estimator%needs_radii)
          case ('estimators of elastic material')
            names = pack(estimator%name, estimator%needs_elasticity)
          case ('estimators of isotropic material')
            names = pack(estimator%name, estimator%needs_isotropy)
          case ('estimators for traction-free faces')
            names = pack(estimator%name, estimator%needs_free_faces)
          case ('estimators for stationary tips')
            names = pack(estimator%name, estimator%needs_tip_at_rest)
         end select
      end associate
   end function names_of
end module hampm_choice_sets
