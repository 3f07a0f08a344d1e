!> The group &body: its row in the table of groups, its keys, and their values in a scene.
module hampm_body_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_integer, type_name, must, may, repeats, is_required, any_number
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: body_group, body_keys, body_t, fill_bodies

   type(group_t), parameter :: body_group = group_t('body', repeats, is_required, 'a piece of material; bodies must not overlap')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: body_keys(*) = [ &
      key_t('body', 'material', type_name, 1, 1, must, '', 'aluminium', '', &
            '', 'name of its material'), &
      key_t('body', 'shape', type_name, 1, 1, may, 'rectangle', '', '', &
            'rectangle', 'a rectangle along the grid lines'), &
      key_t('body', 'lower', type_real, ndim, ndim, must, '', '0.0, 0.0', 'm', &
            any_number, 'its lower corner'), &
      key_t('body', 'upper', type_real, ndim, ndim, must, '', '0.1, 0.01', 'm', &
            any_number, 'its upper corner'), &
      key_t('body', 'points_per_cell', type_integer, 1, 1, may, '2', '', '', &
            '[1, 16]', 'material points per root cell in each direction; even where cells may refine'), &
      key_t('body', 'velocity', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm/s', &
            any_number, 'initial velocity of its middle'), &
      key_t('body', 'spin', type_real, 1, 1, may, '0.0', '', 'rad/s', &
            any_number, 'initial angular velocity around its middle, anticlockwise'), &
      key_t('body', 'eigenstrain', type_real, 3, 4, may, '0.0, 0.0, 0.0', '', '', &
            '[-0.05, 0.05]', 'strain xx, yy, xy and zz (0) at which there is no stress; heat: alpha dT in xx, yy and zz')]

   !> &body: a piece of material.
   type :: body_t
      character(name_len) :: material = ''       !! name of its material
      integer :: material_index = 0              !! position of that material in `scene_t%materials`
      character(name_len) :: shape = ''          !! 'rectangle'
      real(dp) :: lower(ndim) = 0                !! [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      integer :: points_per_cell = 0             !! material points per cell and direction
      real(dp) :: velocity(ndim) = 0             !! initial velocity of its middle [m/s]
      real(dp) :: spin = 0                       !! initial angular velocity around that [rad/s]
      real(dp) :: eigenstrain(4) = 0             !! components xx, yy, xy and zz of the strain without stress [-]
   end type body_t

contains

   !> Take all groups of this name.
   pure subroutine fill_bodies(settings, bodies)
      type(settings_t), intent(in) :: settings
      type(body_t), allocatable, intent(out) :: bodies(:)
      integer :: i
      allocate (bodies(settings%count_of('body')))
      do i = 1, size(bodies)
         call fill_body(settings, settings%find('body', i), bodies(i))
      end do
   end subroutine fill_bodies

   !> Take the values of the keys of one; 0, '' or empty where they are mistaken.
   pure subroutine fill_body(settings, entry, body)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group
      type(body_t), intent(inout) :: body
      body%material = settings%text(entry, 'material')
      body%shape = settings%text(entry, 'shape')
      body%lower = settings%vector(entry, 'lower')
      body%upper = settings%vector(entry, 'upper')
      body%points_per_cell = nint(settings%number(entry, 'points_per_cell'))
      body%velocity = settings%vector(entry, 'velocity')
      body%spin = settings%number(entry, 'spin')
      associate (numbers => settings%numbers(entry, 'eigenstrain'))
         body%eigenstrain(:size(numbers)) = numbers
      end associate
   end subroutine fill_body
end module hampm_body_group
