!> The group &run: its row in the table of groups, its keys, and their values in a scene.
module hampm_run_group
   use hampm_kinds, only: dp, name_len, path_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, type_text, must, may, once, is_required, positive
   use hampm_settings, only: settings_t
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: run_group, run_keys, run_t, fill_run

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

contains

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
end module hampm_run_group
