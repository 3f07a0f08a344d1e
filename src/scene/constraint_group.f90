!> The group &constraint: its row in the table of groups, its keys, and their values in a scene.
module hampm_constraint_group
   use hampm_kinds, only: dp, ndim
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, must, may, repeats, is_optional, any_number
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: constraint_group, constraint_keys, constraint_spec_t, fill_constraints

   type(group_t), parameter :: constraint_group = group_t('constraint', repeats, is_optional, &
      'fixed displacement components of all grid nodes in a box')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: constraint_keys(*) = [ &
      key_t('constraint', 'lower', type_real, ndim, ndim, must, '', '0.05, 0.0', 'm', &
            any_number, 'lower corner of the box whose nodes are held'), &
      key_t('constraint', 'upper', type_real, ndim, ndim, must, '', '0.1, 0.0', 'm', &
            any_number, 'upper corner of the box, may equal the lower one'), &
      key_t('constraint', 'fix', type_name, 1, 1, must, '', 'y', '', &
            'x|y|xy', 'components of the velocity that are zero there')]

   !> &constraint: nodes that are held.
   type :: constraint_spec_t
      real(dp) :: lower(ndim) = 0                !! [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      logical :: fixed(ndim) = .false.           !! which components are held
   end type constraint_spec_t

contains

   !> Take all groups of this name.
   pure subroutine fill_constraints(settings, constraints)
      type(settings_t), intent(in) :: settings
      type(constraint_spec_t), allocatable, intent(out) :: constraints(:)
      integer :: i
      allocate (constraints(settings%count_of('constraint')))
      do i = 1, size(constraints)
         call fill_constraint(settings, settings%find('constraint', i), constraints(i))
      end do
   end subroutine fill_constraints

   !> Take the values of the keys of one; 0, '' or empty where they are mistaken.
   pure subroutine fill_constraint(settings, entry, constraint)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group
      type(constraint_spec_t), intent(inout) :: constraint
      character(*), parameter :: axis = 'xyz'
      character(:), allocatable :: fix
      integer :: d
      constraint%lower = settings%vector(entry, 'lower')
      constraint%upper = settings%vector(entry, 'upper')
      fix = settings%text(entry, 'fix')
      constraint%fixed = [(index(fix, axis(d:d)) > 0, d=1, ndim)]
   end subroutine fill_constraint
end module hampm_constraint_group
