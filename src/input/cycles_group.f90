!> The group &cycles: the values of its keys in a model.
module hampm_cycles_group
   use hampm_kinds, only: dp
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: cycles_t, fill_cycles

   !> &cycles. Each block has a number of cycles, a factor and a ratio.
   type :: cycles_t
      real(dp), allocatable :: number(:)
      real(dp), allocatable :: factor(:)
      real(dp), allocatable :: ratio(:)
      logical :: repeats = .false.
   end type cycles_t

contains

   !> Take the values of the group; without it there is one endless block.
   pure subroutine fill_cycles(settings, cycles)
      type(settings_t), intent(in) :: settings
      type(cycles_t), intent(out) :: cycles
      real(dp) :: ratio
      integer :: entry
      entry = settings%find('cycles', 1)
      ratio = 0
      allocate (cycles%number(0), cycles%factor(0), cycles%ratio(0))
      if (entry > 0) then
         ratio = settings%number(entry, 'ratio')
         cycles%repeats = settings%flag(entry, 'repeat')
         cycles%number = settings%numbers(entry, 'blocks')
         cycles%factor = settings%numbers(entry, 'factors')
         cycles%ratio = settings%numbers(entry, 'ratios')
      end if
      if (size(cycles%number) == 0) cycles%number = [1.0_dp]
      if (size(cycles%factor) == 0) cycles%factor = spread(1.0_dp, 1, size(cycles%number))
      if (size(cycles%ratio) == 0) cycles%ratio = spread(ratio, 1, size(cycles%number))
   end subroutine fill_cycles
end module hampm_cycles_group
