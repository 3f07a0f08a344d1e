!> The group &control: the values of its keys in a model.
module hampm_control_group
   use hampm_kinds, only: dp
   use hampm_group_values, only: control_keys_t, take_control
   use hampm_load_groups, only: fill_history
   use hampm_settings, only: settings_t
   use hampm_time_history, only: time_history_t
   implicit none
   private
   public :: control_t, fill_control

   !> &control.
   type, extends(control_keys_t) :: control_t
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

   !> Prescribed value at a time: the load factor [-], or the displacement of the load frame [m].
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
      call take_control(settings, entry, control)
      call fill_history(settings, entry, control%history)
   end subroutine fill_control
end module hampm_control_group
