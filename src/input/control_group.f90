!> The group &control: its row in the table of groups, its keys, and their values in a model.
module hampm_control_group
   use hampm_kinds, only: dp, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, once, is_optional, any_number, not_negative
   use hampm_load_groups, only: history_keys, fill_history
   use hampm_settings, only: settings_t
   use hampm_time_history, only: time_history_t
   implicit none
   private
   public :: control_group, control_keys, control_t, fill_control

   type(group_t), parameter :: control_group = group_t('control', once, is_optional, &
      'what a load frame controls as cracks grow at rest; load and displacement become columns', is_apart=.true.)

   type(key_t), parameter :: control_keys(*) = [ &
      key_t('quantity', type_name, &
            'what is given: growth, an increment a load step; the load; or the displacement of the load frame', &
            default='growth', allowed='growth|load|displacement'), &
      key_t('displacement', type_real, 'of the load frame where its factor is 1', default='0.0', example='1.0e-3', unit='m', &
            allowed=any_number), &
      key_t('stiffness', type_real, 'of the load frame, a spring in series with the specimen; 0: it is rigid', default='0.0', &
            unit='N/m', allowed=not_negative), &
      history_keys(:size(history_keys) - 1)]     ! but `held`

   !> &control.
   type :: control_t
      character(name_len) :: quantity = ''       !! 'growth', 'load' or 'displacement'; '' without the group
      real(dp) :: displacement = 0               !! [m]
      real(dp) :: stiffness = 0                  !! 0: rigid [N/m]
      type(time_history_t) :: history
   contains
      procedure :: is_there
      procedure :: leads
      procedure :: target_at
   end type control_t

contains

   !> Whether there is a load frame.
   pure logical function is_there(self)
      class(control_t), intent(in) :: self
      is_there = self%quantity /= ''
   end function is_there

   !> Whether load or displacement are given, and growth follows.
   pure logical function leads(self)
      class(control_t), intent(in) :: self
      leads = self%quantity == 'load' .or. self%quantity == 'displacement'
   end function leads

   !> What is given at a time: the load factor, or the displacement of the load frame [-] or [m].
   pure real(dp) function target_at(self, time) result(target)
      class(control_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      target = self%history%factor(time)
      if (self%quantity == 'displacement') target = self%displacement*target
   end function target_at

   !> Take the values of the group; 0 or '' where they are wrong.
   pure subroutine fill_control(settings, control)
      type(settings_t), intent(in) :: settings
      type(control_t), intent(out) :: control
      integer :: entry
      entry = settings%find('control', 1)
      if (entry == 0) return
      control%quantity = settings%text(entry, 'quantity')
      control%displacement = settings%number(entry, 'displacement')
      control%stiffness = settings%number(entry, 'stiffness')
      call fill_history(settings, entry, control%history)
   end subroutine fill_control
end module hampm_control_group
