!> The group &cycles: its row in the table of groups, its keys, and their values in a model.
module hampm_cycles_group
   use hampm_kinds, only: dp
   use hampm_key_rows, only: group_t, key_t, type_logical, type_real, once, is_optional, any_number, max_values, positive
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: cycles_group, cycles_keys, cycles_t, fill_cycles

   type(group_t), parameter :: cycles_group = group_t('cycles', once, is_optional, &
      'the load cycles of law = fatigue; without it loads fall to 0 in each cycle', is_apart=.true.)

   type(key_t), parameter :: cycles_keys(*) = [ &
      key_t('ratio', type_real, 'least over largest load of a cycle', default='0.0', example='0.1', allowed='(-inf, 1)'), &
      key_t('blocks', type_real, 'cycles of one kind that follow one another: how many of each kind', allowed=positive, &
            example='10000, 1, 10000', fewest=0, most=max_values), &
      key_t('factors', type_real, 'of each block: by which the largest load is multiplied', allowed=positive, &
            example='1.0, 1.5, 1.0', fewest=0, most=max_values), &
      key_t('ratios', type_real, 'of each block: least over largest load, in place of ratio', allowed='(-inf, 1)', &
            example='0.1, 0.0, 0.1', fewest=0, most=max_values), &
      key_t('repeat', type_logical, 'whether the blocks begin again after the last one; else that goes on', default='.false.')]

   !> &cycles. Each block has a number of cycles, a factor and a ratio.
   type :: cycles_t
      real(dp), allocatable :: number(:)
      real(dp), allocatable :: factor(:)
      real(dp), allocatable :: ratio(:)
      logical :: repeats = .false.
   end type cycles_t

contains

   !> Take the values of the group; without it there is one block that goes on.
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
