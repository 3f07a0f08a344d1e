!> The group &nucleation: the values of its keys in a model.
module hampm_nucleation_group
   use hampm_group_values, only: nucleation_keys_t, take_nucleation
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: nucleation_t, fill_nucleations

   !> &nucleation: when a crack appears.
   type, extends(nucleation_keys_t) :: nucleation_t
      integer :: path = 0                        !! number of the path; 0: there is no such one
   end type nucleation_t

contains

   !> Take all groups of this name.
   pure subroutine fill_nucleations(settings, nucleations)
      type(settings_t), intent(in) :: settings
      type(nucleation_t), allocatable, intent(out) :: nucleations(:)
      integer :: k
      allocate (nucleations(settings%count_of('nucleation')))
      do k = 1, size(nucleations)
         call take_nucleation(settings, settings%find('nucleation', k), nucleations(k))
      end do
   end subroutine fill_nucleations
end module hampm_nucleation_group
