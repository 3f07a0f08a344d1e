!> Sets of choices from the tables of laws, indicators and estimators, named in braces by the tables of keys and of rules, as in
!> `&energy_release estimators = {estimators at nodes}`.
module hampm_choice_sets
   use hampm_kinds, only: name_len
   use hampm_estimators, only: estimators
   use hampm_growth_laws, only: growth_laws
   use hampm_indicators, only: indicators
   use hampm_laws, only: laws
   use hampm_text, only: joined
   implicit none
   private
   public :: expanded, is_among

contains

   !> A text with the names of each set in the place of its braces.
   pure function expanded(text, quote, separator)
      character(*), intent(in) :: text
      character(*), intent(in) :: quote          !! around each name
      character(*), intent(in) :: separator      !! between names
      character(:), allocatable :: expanded
      character(name_len), allocatable :: names(:)
      integer :: from, behind
      expanded = trim(text)
      do
         from = index(expanded, '{')
         if (from == 0) return
         behind = index(expanded, '}')
         allocate (names, source=names_of(expanded(from + 1:behind - 1)))
         expanded = expanded(:from - 1)//quote//joined(names, quote//separator//quote)//quote//expanded(behind + 1:)
         deallocate (names)
      end do
   end function expanded

   !> Whether a name is one of some, or of a set in braces among these.
   pure logical function is_among(name, names)
      character(*), intent(in) :: name, names(:)
      integer :: k
      is_among = any(names == name)
      do k = 1, size(names)
         if (names(k)(1:1) == '{') is_among = is_among .or. any(names_of(names(k)(2:len_trim(names(k)) - 1)) == name)
      end do
   end function is_among

   !> The names of a set.
   pure function names_of(set) result(names)
      character(*), intent(in) :: set
      character(name_len), allocatable :: names(:)
      select case (set(:index(set//' ', ' ') - 1))
       case ('laws')
         associate (of => laws())
            names = pack(of%name, set == 'laws' .or. &
                      set == 'laws with a history' .and. of%has_history .or. &
                      set == 'laws of any strain' .and. of%is_finite)
         end associate
       case ('growth')
         associate (of => growth_laws())
            names = pack(of%name, set == 'growth laws' .or. &
                      set == 'growth laws at rest' .and. of%is_static .or. &
                      set == 'growth laws in motion' .and. .not. of%is_static .or. &
                      set == 'growth laws in motion by toughness' .and. .not. (of%gives_speed() .or. of%is_static) .or. &
                      set == 'growth laws at rest by toughness' .and. of%is_static .and. .not. of%has_rate() .or. &
                      set == 'growth laws that scale loads' .and. of%scales_loads() .or. &
                      set == 'growth laws by a rate' .and. of%has_rate() .or. &
                      set == 'growth laws in time' .and. of%is_in_time .or. &
                      set == 'growth laws in cycles' .and. of%is_cyclic() .or. &
                      set == 'growth laws by speed' .and. of%gives_speed())
         end associate
       case ('indicators')
         associate (of => indicators())
            names = pack(of%name, set == 'indicators' .or. &
                      set == 'indicators of the motion' .and. .not. of%is_of_places .or. &
                      set == 'indicators of one body' .and. of%is_of_one_body)
         end associate
       case ('estimators')
         associate (of => estimators())
            names = pack(of%name, set == 'estimators' .or. &
                      set == 'estimators at nodes' .and. of%needs_nodes .or. &
                      set == 'estimators by radii' .and. of%needs_radii .or. &
                      set == 'estimators of elastic material' .and. of%needs_elasticity .or. &
                      set == 'estimators of isotropic material' .and. of%needs_isotropy .or. &
                      set == 'estimators for traction-free faces' .and. of%needs_free_faces .or. &
                      set == 'estimators for stationary tips' .and. of%needs_tip_at_rest)
         end associate
      end select
   end function names_of
end module hampm_choice_sets
