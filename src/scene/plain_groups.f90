!> The groups &run, &grid, &damping, &output and &contact: their rows in the table of groups, their keys, and their values in a scene.
module hampm_plain_groups
   use hampm_kinds, only: dp, ndim, name_len, path_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_integer, must, may, once, is_required, any_number, positive, &
                             type_name, type_text, is_assumed, not_negative
   use hampm_settings, only: settings_t
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: grid_group, grid_keys, grid_spec_t, fill_grid, run_group, run_keys, run_t, fill_run, damping_group, damping_keys, &
             damping_t, fill_damping, output_group, output_keys, output_t, fill_output, contact_group, contact_keys, &
             body_contact_spec_t, fill_contact

   type(group_t), parameter :: contact_group = group_t('contact', once, is_assumed, 'how bodies that meet act on each other')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: contact_keys(*) = [ &
      key_t('contact', 'bodies', type_name, 1, 1, may, 'joined', '', '', &
            'joined|stick|frictionless|friction', &
            'joined: one velocity field, in which they stick; else one for each: those that touch stick, or slide'), &
      key_t('contact', 'friction', type_real, 1, 1, may, '0.0', '', '', &
            not_negative, 'of bodies = ''friction'': coefficient'), &
      key_t('contact', 'distance', type_real, 1, 1, may, '0.0', '', 'm', &
            not_negative, 'gap between their surfaces at which bodies touch')]

   !> &contact.
   type :: body_contact_spec_t
      character(name_len) :: bodies = 'joined'   !! 'joined', 'stick', 'frictionless' or 'friction'
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: distance = 0                   !! gap at which they touch [m]
   contains
      procedure :: is_wanted
   end type body_contact_spec_t

   type(group_t), parameter :: output_group = group_t('output', once, is_assumed, 'what is written, and how often')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: output_keys(*) = [ &
      key_t('output', 'file', type_text, 1, 1, may, '', 'dcb.h5', '', &
            '', 'result file in the output folder; by default named after the namelist file'), &
      key_t('output', 'history_interval', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'time between samples of the history; 0: a thousandth of end_time'), &
      key_t('output', 'snapshot_interval', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'time between snapshots of particles and mesh; 0: none'), &
      key_t('output', 'checkpoint_interval', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'wall time between checkpoints, from which --resume goes on; 0: none'), &
      key_t('output', 'checkpoint_steps', type_integer, 1, 1, may, '0', '', '', &
            '[0, inf)', 'steps between checkpoints; 0: none')]

   !> &output: what is written, and how often.
   type :: output_t
      character(path_len) :: file = ''           !! name of the result file, within the output folder
      real(dp) :: history_interval = 0           !! [s], always > 0 after validation
      real(dp) :: snapshot_interval = 0          !! [s], 0: no snapshots
      real(dp) :: checkpoint_interval = 0        !! wall time [s], 0: none
      integer :: checkpoint_steps = 0            !! 0: none
   end type output_t

   type(group_t), parameter :: damping_group = group_t('damping', once, is_assumed, 'a force -rate m v on all material')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: damping_keys(*) = [ &
      key_t('damping', 'rate', type_real, 1, 1, may, '0.0', '1.0e4', '1/s', &
            not_negative, 'damping force over mass times velocity')]

   !> &damping.
   type :: damping_t
      real(dp) :: rate = 0                       !! alpha of the force -alpha m v [1/s]
   end type damping_t

   type(group_t), parameter :: run_group = group_t('run', once, is_required, 'what is computed, and for how long')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: run_keys(*) = [ &
      key_t('run', 'title', type_text, 1, 1, may, '', 'DCB, suddenly loaded', '', &
            '', 'what the run is about; the result keeps it'), &
      key_t('run', 'plane', type_name, 1, 1, may, 'stress', '', '', &
            'stress|strain|axisymmetric', 'plane stress, plane strain, or material around the axis x = 0, where x is the radius'), &
      key_t('run', 'thickness', type_real, 1, 1, may, '1.0', '0.01', 'm', &
            positive, 'thickness of the plane; forces and energies are those of all of it'), &
      key_t('run', 'end_time', type_real, 1, 1, must, '', '1.5e-3', 's', &
            positive, 'the run goes from time 0 to this time')]

   !> &run: what is computed, and for how long.
   type :: run_t
      character(path_len) :: title = ''
      character(name_len) :: plane = ''          !! 'stress', 'strain' or 'axisymmetric'
      type(thickness_t) :: thickness
      real(dp) :: end_time = 0                   !! [s]
   end type run_t

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

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_run(settings, run)
      type(settings_t), intent(in) :: settings
      type(run_t), intent(inout) :: run
      integer :: entry
      entry = settings%find('run', 1)
      run%title = settings%text(entry, 'title')
      run%plane = settings%text(entry, 'plane')
      run%thickness = thickness_t(settings%number(entry, 'thickness'), run%plane == 'axisymmetric')
      run%end_time = settings%number(entry, 'end_time')
   end subroutine fill_run

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_damping(settings, damping)
      type(settings_t), intent(in) :: settings
      type(damping_t), intent(inout) :: damping
      integer :: entry
      entry = settings%find('damping', 1)
      damping%rate = settings%number(entry, 'rate')
   end subroutine fill_damping

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_output(settings, output)
      type(settings_t), intent(in) :: settings
      type(output_t), intent(inout) :: output
      integer :: entry
      entry = settings%find('output', 1)
      output%file = settings%text(entry, 'file')
      output%history_interval = settings%number(entry, 'history_interval')
      output%snapshot_interval = settings%number(entry, 'snapshot_interval')
      output%checkpoint_interval = settings%number(entry, 'checkpoint_interval')
      output%checkpoint_steps = nint(settings%number(entry, 'checkpoint_steps'))
   end subroutine fill_output

   !> Whether bodies have velocity fields of their own.
   pure logical function is_wanted(self)
      class(body_contact_spec_t), intent(in) :: self
      is_wanted = self%bodies == 'stick' .or. self%bodies == 'frictionless' .or. self%bodies == 'friction'
   end function is_wanted

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_contact(settings, contact)
      type(settings_t), intent(in) :: settings
      type(body_contact_spec_t), intent(inout) :: contact
      integer :: entry
      entry = settings%find('contact', 1)
      contact%bodies = settings%text(entry, 'bodies')
      contact%friction = settings%number(entry, 'friction')
      contact%distance = settings%number(entry, 'distance')
   end subroutine fill_contact
end module hampm_plain_groups
