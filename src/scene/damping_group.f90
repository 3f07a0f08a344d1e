!> The group &damping: its row in the table of groups, its keys, and their values in a scene.
module hampm_damping_group
   use hampm_kinds, only: dp
   use hampm_key_rows, only: group_t, key_t, type_real, may, once, is_assumed, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: damping_group, damping_keys, damping_t, fill_damping

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

contains

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_damping(settings, damping)
      type(settings_t), intent(in) :: settings
      type(damping_t), intent(inout) :: damping
      integer :: entry
      entry = settings%find('damping', 1)
      damping%rate = settings%number(entry, 'rate')
   end subroutine fill_damping
end module hampm_damping_group
