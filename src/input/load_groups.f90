!> The groups &constraint and &load, and their keys of time histories: their values in a model.
module hampm_load_groups
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: given_motion_t
   use hampm_group_values, only: constraint_keys_t, load_keys_t, take_constraint, take_load
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   use hampm_time_history, only: time_history_t
   implicit none
   private
   public :: fill_history, check_history, constraint_spec_t, fill_constraints, load_spec_t, fill_loads

   !> &constraint: nodes that are held.
   type, extends(constraint_keys_t) :: constraint_spec_t
      logical :: fixed(ndim) = .false.           !! fixed components
      type(given_motion_t) :: motion             !! how they are moved
   end type constraint_spec_t

   !> &load: a force and its history.
   type, extends(load_keys_t) :: load_spec_t
      logical :: has_place = .true.              !! whether it acts in a box, else on all material or on a crack
      integer :: of_outlines = 1                 !! how many have its side in the box
      type(time_history_t) :: history            !! of its factor
   end type load_spec_t

contains

   !> Take the values of these keys of one group; 0, '' or empty where they are wrong.
   pure subroutine fill_history(settings, entry, history)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group
      type(time_history_t), intent(inout) :: history
      history%kind = settings%text(entry, 'history')
      history%start = settings%number(entry, 'start')
      history%rise_time = settings%number(entry, 'rise_time')
      history%frequency = settings%number(entry, 'frequency')
      history%times = settings%numbers(entry, 'times')
      history%factors = settings%numbers(entry, 'factors')
   end subroutine fill_history

   !> The times of a table increase, and have as many factors.
   pure subroutine check_history(history, entry, settings)
      type(time_history_t), intent(in) :: history
      integer, intent(in) :: entry                 !! position of the group
      type(settings_t), intent(inout) :: settings
      integer :: n
      if (.not. (settings%good(entry, 'history') .and. settings%good(entry, 'times')) .or. history%kind /= 'table') return
      n = size(history%times)
      if (n < 2) then
         call settings%complain(entry, 'times', 'must have at least 2 values for history = ''table''')
      else if (any(history%times(2:) <= history%times(:n - 1))) then
         call settings%complain(entry, 'times', 'must increase from value to value')
      end if
      if (settings%good(entry, 'factors') .and. size(history%factors) /= n) &
         call settings%complain(entry, 'factors', 'must have as many values as times, '//to_text(n)//', not '// &
                                to_text(size(history%factors)))
   end subroutine check_history

   !> Take all groups of this name; values are 0, '' or empty where they are wrong.
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
            call take_constraint(settings, entry, constraint)
            fix = settings%text(entry, 'fix')
            constraint%motion%displacement = settings%vector(entry, 'displacement')
            constraint%motion%velocity = settings%vector(entry, 'velocity')
            call fill_history(settings, entry, constraint%motion%history)
            constraint%motion%history%held = settings%flag(entry, 'held')
            constraint%motion%unilateral = settings%flag(entry, 'unilateral')
            constraint%motion%turns = settings%flag(entry, 'turns')
            constraint%fixed = [(index(fix, axis(d:d)) > 0, d=1, ndim)]
         end associate
      end do
   end subroutine fill_constraints

   !> Take all groups of this name; values are 0, '' or empty where they are wrong.
   pure subroutine fill_loads(settings, loads)
      type(settings_t), intent(in) :: settings
      type(load_spec_t), allocatable, intent(out) :: loads(:)
      integer :: i, entry
      allocate (loads(settings%count_of('load')))
      do i = 1, size(loads)
         entry = settings%find('load', i)
         associate (load => loads(i))
            call take_load(settings, entry, load)
            load%has_place = load%kind /= 'gravity' .and. &
                             .not. (load%kind == 'pressure' .and. settings%text(entry, 'on') == 'crack')
            call fill_history(settings, entry, load%history)
            load%history%held = settings%flag(entry, 'held')
         end associate
      end do
   end subroutine fill_loads
end module hampm_load_groups
