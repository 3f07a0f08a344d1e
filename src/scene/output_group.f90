!> The group &output: its row in the table of groups, its keys, and their values in a scene.
module hampm_output_group
   use hampm_kinds, only: dp, path_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_integer, type_text, may, once, is_assumed, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: output_group, output_keys, output_t, fill_output

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

contains

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
end module hampm_output_group
