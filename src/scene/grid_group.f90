!> The group &grid: its row in the table of groups, its keys, and their values in a scene.
module hampm_grid_group
   use hampm_kinds, only: dp, ndim
   use hampm_key_rows, only: group_t, key_t, type_real, type_integer, must, may, once, is_required, any_number, positive
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: grid_group, grid_keys, grid_spec_t, fill_grid

   type(group_t), parameter :: grid_group = group_t('grid', once, is_required, &
      'the lattice of square root cells that the material moves through')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: grid_keys(*) = [ &
      key_t('grid', 'lower', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm', &
            any_number, 'lower corner of the lattice'), &
      key_t('grid', 'cell', type_real, 1, 1, must, '', '1.25e-3', 'm', &
            positive, 'size of a root cell, the same in both directions'), &
      key_t('grid', 'cells', type_integer, ndim, ndim, must, '', '80, 9', '', &
            '[1, inf)', 'number of root cells in each direction'), &
      key_t('grid', 'order', type_integer, 1, 1, may, '1', '', '', &
            '[1, 2]', 'of the shape functions: 1 bilinear, 2 biquadratic cells with nine nodes')]

   !> &grid: the lattice of root cells.
   type :: grid_spec_t
      real(dp) :: lower(ndim) = 0                !! lower corner of the lattice [m]
      real(dp) :: cell = 0                       !! size of a root cell [m]
      integer :: cells(ndim) = 0                 !! number of root cells
      integer :: order = 1                       !! of the shape functions
   end type grid_spec_t

contains

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_grid(settings, grid)
      type(settings_t), intent(in) :: settings
      type(grid_spec_t), intent(inout) :: grid
      integer :: entry
      entry = settings%find('grid', 1)
      grid%lower = settings%vector(entry, 'lower')
      grid%cell = settings%number(entry, 'cell')
      grid%cells = nint(settings%vector(entry, 'cells'))
      grid%order = nint(settings%number(entry, 'order'))
   end subroutine fill_grid
end module hampm_grid_group
