!> The group &constraint: its row in the table of groups, its keys, and their values in a scene.
module hampm_constraint_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_constraints, only: given_motion_t
   use hampm_history_values, only: history_keys, fill_history
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, type_text, type_logical, must, may, repeats, is_optional, &
                             any_number
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: constraint_group, constraint_keys, constraint_spec_t, fill_constraints

   type(group_t), parameter :: constraint_group = group_t('constraint', repeats, is_optional, &
      'displacement components of all grid nodes in a box that are held, or moved in a given way')

   integer :: i                                  !! counts in the following table only

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: constraint_keys(*) = [ &
      key_t('constraint', 'lower', type_real, ndim, ndim, must, '', '0.05, 0.0', 'm', &
            any_number, 'lower corner of the box whose nodes are held'), &
      key_t('constraint', 'upper', type_real, ndim, ndim, must, '', '0.1, 0.0', 'm', &
            any_number, 'upper corner of the box, may equal the lower one'), &
      key_t('constraint', 'fix', type_name, 1, 1, must, '', 'y', '', &
            'x|y|xy', 'components that are held there, or moved'), &
      key_t('constraint', 'displacement', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm', &
            any_number, 'by which they are moved where its factor is 1'), &
      key_t('constraint', 'velocity', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm/s', &
            any_number, 'with which they are moved where its factor is 1'), &
      (key_t('constraint', history_keys(i)%name, history_keys(i)%value_type, history_keys(i)%fewest, history_keys(i)%most, &
             history_keys(i)%required, history_keys(i)%default, history_keys(i)%example, history_keys(i)%unit, &
             history_keys(i)%allowed, history_keys(i)%meaning), i=1, size(history_keys)), &
      key_t('constraint', 'name', type_text, 1, 1, may, '', 'grip', '', &
            '', 'gives the force of this constraint columns of its own: reaction_<name>_x and _y'), &
      key_t('constraint', 'push_only', type_logical, 1, 1, may, '.false.', '', '', &
            '', 'whether it holds what presses on it only: a support from which material may lift off')]

   !> &constraint: nodes that are held.
   type :: constraint_spec_t
      real(dp) :: lower(ndim) = 0                !! [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      logical :: fixed(ndim) = .false.           !! which components are held
      type(given_motion_t) :: motion             !! how they are moved
      character(name_len) :: name = ''           !! of the columns of its reaction; '' for none
   end type constraint_spec_t

contains

   !> Take all groups of this name; values are 0, '' or empty where they are mistaken.
   pure subroutine fill_constraints(settings, constraints)
      type(settings_t), intent(in) :: settings
      type(constraint_spec_t), allocatable, intent(out) :: constraints(:)
      character(*), parameter :: axis = 'xyz'
      character(:), allocatable :: fix
      integer :: i, entry, d
      allocate (constraints(settings%count_of('constraint')))
      do i = 1, size(constraints)
         entry = settings%find('constraint', i)
         associate (constraint => constraints(i))
            constraint%lower = settings%vector(entry, 'lower')
            constraint%upper = settings%vector(entry, 'upper')
            fix = settings%text(entry, 'fix')
            constraint%motion%displacement = settings%vector(entry, 'displacement')
            constraint%motion%velocity = settings%vector(entry, 'velocity')
            call fill_history(settings, entry, constraint%motion%history)
            constraint%name = settings%text(entry, 'name')
            constraint%motion%push_only = settings%flag(entry, 'push_only')
            constraint%fixed = [(index(fix, axis(d:d)) > 0, d=1, ndim)]
         end associate
      end do
   end subroutine fill_constraints
end module hampm_constraint_group
