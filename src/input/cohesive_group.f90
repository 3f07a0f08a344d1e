!> The group &cohesive: its row in the table of groups, its keys, and their values in a model.
module hampm_cohesive_group
   use hampm_kinds, only: dp, name_len
   use hampm_cohesive_law, only: cohesive_law_t, new_cohesive_law, most_openings
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, type_text, repeats, is_optional, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: cohesive_group, cohesive_keys, cohesive_t, fill_cohesive

   type(group_t), parameter :: cohesive_group = group_t('cohesive', repeats, is_optional, &
      'how the faces of a crack hold each other by cohesion; without this group they do not', is_apart=.true.)

   type(key_t), parameter :: cohesive_keys(*) = [ &
      key_t('crack', type_text, 'name of the crack; may be left out where there is one crack', example='a'), &
      key_t('from', type_real, 'way along its points from which on faces hold each other; there its tip is at first', &
            default='0.0', unit='m', allowed=not_negative), &
      key_t('law', type_name, 'traction over opening: falling by a line, rising and falling by lines, or along points', &
            default='linear', allowed='linear|bilinear|table'), &
      key_t('strength', type_real, 'largest traction across the faces, of the laws linear and bilinear', default='0.0', &
            example='30.0e6', unit='Pa', allowed=not_negative), &
      key_t('toughness', type_real, 'energy to part faces by opening, of these laws', default='0.0', example='300.0', unit='J/m2', &
            allowed=not_negative), &
      key_t('opening', type_real, 'of law = bilinear: opening at the strength', default='0.0', example='1.0e-6', unit='m', &
            allowed=not_negative), &
      key_t('openings', type_real, &
            'of law = table: ascending; before one above 0 the traction rises from 0 by a line, without damage', &
            example='0.0, 5.0e-6, 4.0e-5', unit='m', allowed=not_negative, fewest=0, most=most_openings), &
      key_t('tractions', type_real, 'across the faces at these openings, the last 0', example='30.0e6, 8.0e6, 0.0', unit='Pa', &
            allowed=not_negative, fewest=0, most=most_openings), &
      key_t('strength_shear', type_real, 'largest traction along the faces; 0: that across them', default='0.0', unit='Pa', &
            allowed=not_negative), &
      key_t('toughness_shear', type_real, 'energy to part faces by sliding; 0: that by opening', default='0.0', unit='J/m2', &
            allowed=not_negative), &
      key_t('mixed_mode', type_name, 'how the toughness of both together is found', default='benzeggagh_kenane', &
            allowed='benzeggagh_kenane|power'), &
      key_t('exponent', type_real, 'of that', default='1.0', allowed='[1, 1000]')]

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
