!> The group &probe: the values of its keys in a model.
module hampm_probe_group
   use hampm_kinds, only: dp, ndim
   use hampm_group_values, only: probe_keys_t, take_probe
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: probe_t, fill_probes

   !> &probe.
   type, extends(probe_keys_t) :: probe_t
      real(dp), allocatable :: at(:, :)          !! [m], (ndim, 0 to 2)
   contains
      procedure :: gives
   end type probe_t

contains

   !> Whether it records a quantity.
   pure logical function gives(self, quantity)
      class(probe_t), intent(in) :: self
      character(*), intent(in) :: quantity
      gives = any(self%quantity == quantity)
   end function gives

   !> Take all groups of this name. An odd number of coordinates leaves the last one out.
   pure subroutine fill_probes(settings, probes)
      type(settings_t), intent(in) :: settings
      type(probe_t), allocatable, intent(out) :: probes(:)
      real(dp), allocatable :: numbers(:)
      integer :: k, entry
      allocate (probes(settings%count_of('probe')))
      do k = 1, size(probes)
         entry = settings%find('probe', k)
         call take_probe(settings, entry, probes(k))
         numbers = settings%numbers(entry, 'at')
         probes(k)%at = reshape(numbers, [ndim, size(numbers)/ndim])
      end do
   end subroutine fill_probes
end module hampm_probe_group
