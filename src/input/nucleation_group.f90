!> The group &nucleation: its row in the table of groups, its keys, and their values in a model.
module hampm_nucleation_group
   use hampm_kinds, only: dp, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_text, repeats, is_optional, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: nucleation_group, nucleation_keys, nucleation_t, fill_nucleations

   type(group_t), parameter :: nucleation_group = group_t('nucleation', repeats, is_optional, &
      'when a &crack appears at rest that is not there before: by strength and toughness together', &
      is_apart=.true.)

   type(key_t), parameter :: nucleation_keys(*) = [ &
      key_t('crack', type_text, 'name of the crack; may be left out where there is one crack', example='a'), &
      key_t('toughness', type_real, &
            'energy that it must release for its area, from the equilibrium before it to the one with it', &
            default='0.0', example='100.0', unit='J/m2', allowed=not_negative), &
      key_t('strength', type_real, &
            'stress across it that all of it must have before; 0: the energy tells, if stress opens it in the mean', &
            default='0.0', example='50.0e6', unit='Pa', allowed=not_negative), &
      key_t('increment', type_real, &
            'by which the lengths differ that are tried, from its first point on; 0: it appears as a whole', default='0.0', &
            unit='m', allowed=not_negative)]

   !> &nucleation: when a crack appears.
   type :: nucleation_t
      character(name_len) :: crack = ''          !! name of the crack; '' where there is one
      integer :: path = 0                        !! number of the path; 0: there is no such one
      real(dp) :: toughness = 0                  !! [J/m2]
      real(dp) :: strength = 0                   !! [Pa]
      real(dp) :: increment = 0                  !! 0: as a whole [m]
   end type nucleation_t

contains

   !> Take all groups of this name.
   pure subroutine fill_nucleations(settings, nucleations)
      type(settings_t), intent(in) :: settings
      type(nucleation_t), allocatable, intent(out) :: nucleations(:)
      integer :: k, entry
      allocate (nucleations(settings%count_of('nucleation')))
      do k = 1, size(nucleations)
         entry = settings%find('nucleation', k)
         nucleations(k)%crack = settings%text(entry, 'crack')
         nucleations(k)%toughness = settings%number(entry, 'toughness')
         nucleations(k)%strength = settings%number(entry, 'strength')
         nucleations(k)%increment = settings%number(entry, 'increment')
      end do
   end subroutine fill_nucleations
end module hampm_nucleation_group
