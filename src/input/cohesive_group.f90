!> The group &cohesive: its row in the table of groups, its keys, and their values in a model.
module hampm_cohesive_group
   use hampm_kinds, only: dp, name_len
   use hampm_cohesive_law, only: cohesive_law_t, new_cohesive_law, most_openings
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, type_text, may, repeats, is_optional, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: cohesive_group, cohesive_keys, cohesive_t, fill_cohesive

   type(group_t), parameter :: cohesive_group = group_t('cohesive', repeats, is_optional, &
      'how the faces of a crack hold each other by cohesion; without this group they do not', is_apart=.true.)

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: cohesive_keys(*) = [ &
      key_t('cohesive', 'crack', type_text, 1, 1, may, '', 'a', '', &
            '', 'name of the crack; may be left out where there is one crack'), &
      key_t('cohesive', 'from', type_real, 1, 1, may, '0.0', '', 'm', &
            not_negative, 'way along its points from which on faces hold each other; there its tip is at first'), &
      key_t('cohesive', 'law', type_name, 1, 1, may, 'linear', '', '', &
            'linear|bilinear|table', 'traction over opening: falling by a line, rising and falling by lines, or along points'), &
      key_t('cohesive', 'strength', type_real, 1, 1, may, '0.0', '30.0e6', 'Pa', &
            not_negative, 'largest traction across the faces, of the laws linear and bilinear'), &
      key_t('cohesive', 'toughness', type_real, 1, 1, may, '0.0', '300.0', 'J/m2', &
            not_negative, 'energy to part faces by opening, of these laws'), &
      key_t('cohesive', 'opening', type_real, 1, 1, may, '0.0', '1.0e-6', 'm', &
            not_negative, 'of law = bilinear: opening at the strength'), &
      key_t('cohesive', 'openings', type_real, 0, most_openings, may, '', '0.0, 5.0e-6, 4.0e-5', 'm', &
            not_negative, 'of law = table: ascending; before one above 0 the traction rises from 0 by a line, without damage'), &
      key_t('cohesive', 'tractions', type_real, 0, most_openings, may, '', '30.0e6, 8.0e6, 0.0', 'Pa', &
            not_negative, 'across the faces at these openings, the last 0'), &
      key_t('cohesive', 'strength_shear', type_real, 1, 1, may, '0.0', '', 'Pa', &
            not_negative, 'largest traction along the faces; 0: that across them'), &
      key_t('cohesive', 'toughness_shear', type_real, 1, 1, may, '0.0', '', 'J/m2', &
            not_negative, 'energy to part faces by sliding; 0: that by opening'), &
      key_t('cohesive', 'mixed_mode', type_name, 1, 1, may, 'benzeggagh_kenane', '', '', &
            'benzeggagh_kenane|power', 'how the toughness of both together is found'), &
      key_t('cohesive', 'exponent', type_real, 1, 1, may, '1.0', '', '', &
            '[1, inf)', 'of that')]

   !> &cohesive: how faces hold each other.
   type :: cohesive_t
      character(name_len) :: crack = ''          !! name of the crack; '' where there is one
      integer :: path = 0                        !! number of the path; 0: there is no such one
      real(dp) :: from = 0                       !! [m]
      real(dp), allocatable :: openings(:)       !! of the curve of mode I [m]
      real(dp), allocatable :: tractions(:)      !! there [Pa]
      real(dp) :: of_shear(2) = 0                !! strength [Pa] and toughness [J/m2] of mode II; 0: those of mode I
      logical :: by_power = .false.
      real(dp) :: exponent = 1
   contains
      procedure :: law
   end type cohesive_t

contains

   !> The law of the group, whose keys are without errors.
   pure type(cohesive_law_t) function law(self)
      class(cohesive_t), intent(in) :: self
      law = new_cohesive_law(self%openings, self%tractions, self%of_shear, self%by_power, self%exponent)
   end function law

   !> Take all groups of this name: of the laws `linear` and `bilinear` the opening at which the toughness has been taken is 2 G/strength.
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
                                       2*settings%number(entry, 'toughness')/merge(strength, 1.0_dp, strength > 1e-200_dp)] ! others are errors
               cohesive(k)%tractions = [strength, 0.0_dp]
            end if
         end associate
         cohesive(k)%crack = settings%text(entry, 'crack')
         cohesive(k)%from = settings%number(entry, 'from')
         cohesive(k)%of_shear = [settings%number(entry, 'strength_shear'), settings%number(entry, 'toughness_shear')]
         cohesive(k)%by_power = settings%text(entry, 'mixed_mode') == 'power'
         cohesive(k)%exponent = settings%number(entry, 'exponent')
      end do
   end subroutine fill_cohesive
end module hampm_cohesive_group
