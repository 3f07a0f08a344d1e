!> The group &energy_release: its row in the table of groups, its keys, and their values in a scene.
module hampm_energy_release_group
   use hampm_kinds, only: dp, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, may, once, is_assumed, positive, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: energy_release_group, energy_release_keys, energy_release_t, fill_energy_release

   type(group_t), parameter :: energy_release_group = group_t('energy_release', once, is_assumed, &
      'which energy quantities are recorded')

   integer, parameter :: most_radii = 10           !! most radii of the domain integral

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: energy_release_keys(*) = [ &
      key_t('energy_release', 'estimators', type_name, 0, 5, may, '', &
            'nodal_force, stress_closure, domain_integral, energy_balance', '', &
            'nodal_force|stress_closure|domain_integral|energy_balance|crack_closure', &
            'what the history records of energy; none by default'), &
      key_t('energy_release', 'radii', type_real, 0, most_radii, may, '', '4.0e-3, 6.0e-3, 8.0e-3', 'm', &
            positive, 'of domain_integral: increasing; by default 0.4, 0.6, 0.8 of what fits, of two cells or more'), &
      key_t('energy_release', 'reference', type_name, 1, 1, may, 'none', 'dcb', '', &
            'none|dcb|value', 'where the reference value G_ref comes from: nowhere, double cantilever beam theory, or a key'), &
      key_t('energy_release', 'reference_value', type_real, 1, 1, may, '0.0', '', 'J/m2', &
            not_negative, 'G_ref where reference = ''value''; needed there')]

   !> &energy_release: what is recorded of energy.
   type :: energy_release_t
      logical :: nodal_force = .false.           !! which estimators
      logical :: stress_closure = .false.
      logical :: domain_integral = .false.
      logical :: energy_balance = .false.
      logical :: crack_closure = .false.
      real(dp), allocatable :: radii(:)          !! of the domain integral, ascending [m]
      character(name_len) :: reference = ''      !! 'none', 'dcb' or 'value'
      real(dp) :: reference_value = 0            !! G_ref where reference = 'value' [J/m2]
   contains
      procedure :: needs_crack
      procedure :: needs_radii
   end type energy_release_t

contains

   !> Whether an estimator is chosen that finds G or K at the tip of a crack.
   pure logical function needs_crack(self)
      class(energy_release_t), intent(in) :: self
      needs_crack = self%nodal_force .or. self%stress_closure .or. self%needs_radii()
   end function needs_crack

   !> Whether one is chosen that looks at the material within a radius of the tip.
   pure logical function needs_radii(self)
      class(energy_release_t), intent(in) :: self
      needs_radii = self%domain_integral .or. self%crack_closure
   end function needs_radii

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_energy_release(settings, energy_release)
      type(settings_t), intent(in) :: settings
      type(energy_release_t), intent(inout) :: energy_release
      integer :: entry
      entry = settings%find('energy_release', 1)
      energy_release%nodal_force = settings%texts(entry, 'estimators', 'nodal_force')
      energy_release%stress_closure = settings%texts(entry, 'estimators', 'stress_closure')
      energy_release%domain_integral = settings%texts(entry, 'estimators', 'domain_integral')
      energy_release%radii = settings%numbers(entry, 'radii')
      energy_release%energy_balance = settings%texts(entry, 'estimators', 'energy_balance')
      energy_release%crack_closure = settings%texts(entry, 'estimators', 'crack_closure')
      energy_release%reference = settings%text(entry, 'reference')
      energy_release%reference_value = settings%number(entry, 'reference_value')
   end subroutine fill_energy_release
end module hampm_energy_release_group
