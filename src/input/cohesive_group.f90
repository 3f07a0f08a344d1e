!> The group &cohesive: the values of its keys in a model.
module hampm_cohesive_group
   use hampm_kinds, only: dp
   use hampm_cohesive_law, only: cohesive_law_t, new_cohesive_law
   use hampm_group_values, only: cohesive_keys_t, take_cohesive
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: cohesive_t, fill_cohesive

   !> &cohesive: how faces hold each other.
   type, extends(cohesive_keys_t) :: cohesive_t
      integer :: path = 0                        !! number of the path; 0: there is no such one
      real(dp), allocatable :: openings(:)       !! of the curve of mode I [m]
      real(dp), allocatable :: tractions(:)      !! there [Pa]
      real(dp) :: of_shear(2) = 0                !! strength [Pa] and toughness [J/m2] of mode II; 0: those of mode I
      logical :: by_power = .false.
   contains
      procedure :: law
   end type cohesive_t

contains

   !> The law of the group, whose keys are without errors.
   pure type(cohesive_law_t) function law(self)
      class(cohesive_t), intent(in) :: self
      law = new_cohesive_law(self%openings, self%tractions, self%of_shear, self%by_power, self%exponent)
   end function law

   !> Take all groups of this name: for the laws `linear` and `bilinear` the opening at complete separation is 2 G/strength.
   pure subroutine fill_cohesive(settings, cohesive)
      type(settings_t), intent(in) :: settings
      type(cohesive_t), allocatable, intent(out) :: cohesive(:)
      integer :: k, entry
      allocate (cohesive(settings%count_of('cohesive')))
      do k = 1, size(cohesive)
         entry = settings%find('cohesive', k)
         associate (strength => settings%number(entry, 'strength'))
            cohesive(k)%openings = settings%numbers(entry, 'openings')
            cohesive(k)%tractions = settings%numbers(entry, 'tractions')
            if (settings%text(entry, 'law') /= 'table') then
               cohesive(k)%openings = [settings%number(entry, 'opening'), &
                                       2*settings%number(entry, 'toughness')/merge(strength, 1.0_dp, strength > 1e-200_dp)]
               cohesive(k)%tractions = [strength, 0.0_dp]
            end if
         end associate
         call take_cohesive(settings, entry, cohesive(k))
         cohesive(k)%of_shear = [settings%number(entry, 'strength_shear'), settings%number(entry, 'toughness_shear')]
         cohesive(k)%by_power = settings%text(entry, 'mixed_mode') == 'power'
      end do
   end subroutine fill_cohesive
end module hampm_cohesive_group
