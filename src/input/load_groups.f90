!> The groups &constraint and &load, and the keys by which both tell how something varies with time: their rows in the table of groups,
!> their keys, and their values in a model.
module hampm_load_groups
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_constraints, only: given_motion_t
   use hampm_key_rows, only: zeros, near_side, far_side, components, key_t, type_real, type_integer, type_name, any_number, &
                             not_negative, max_values, group_t, &
                             type_text, type_logical, repeats, is_optional
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   use hampm_time_history, only: time_history_t
   implicit none
   private
   public :: history_keys, fill_history, check_history, constraint_group, constraint_keys, constraint_spec_t, fill_constraints, &
             load_group, load_keys, load_spec_t, fill_loads

   type(key_t), parameter :: history_keys(*) = [ &
      key_t('history', type_name, &
            'factor over time: 1, rising to 1 by a line or smoothly, sin(2 pi frequency t), or a table; t counts from start', &
            default='step', allowed='step|ramp|smooth_ramp|sine|table'), &
      key_t('start', type_real, 'time at which the history begins; before it the factor is 0', default='0.0', unit='s', &
            allowed=any_number), &
      key_t('rise_time', type_real, 'of both ramps: time in which the factor rises from 0 to 1; needed there', default='0.0', &
            unit='s', allowed=not_negative), &
      key_t('frequency', type_real, 'of a sine: its frequency; needed there', default='0.0', unit='Hz', allowed=not_negative), &
      key_t('times', type_real, 'of a table: increasing, counted from start; linear between, constant outside', unit='s', &
            allowed=any_number, fewest=0, most=max_values), &
      key_t('factors', type_real, 'of a table: factors at its times, as many as these', allowed=any_number, fewest=0, &
            most=max_values), &
      key_t('held', type_logical, 'whether it stays as its history has it where cracks grow at rest, which scales all others', &
            default='.false.')]

   type(group_t), parameter :: constraint_group = group_t('constraint', repeats, is_optional, &
      'displacement components of all grid nodes in a box that are held, or moved as prescribed')

   type(key_t), parameter :: constraint_keys(*) = [ &
      key_t('lower', type_real, 'lower corner of the box whose nodes are held', unit='m', allowed=any_number, &
            example=merge('0.05, 0.0    ', '0.0, 0.0, 0.0', ndim == 2), fewest=ndim, most=ndim, required=.true.), &
      key_t('upper', type_real, 'upper corner of the box, may equal the lower one', example='0.1, 0.0'//far_side, unit='m', &
            allowed=any_number, fewest=ndim, most=ndim, required=.true.), &
      key_t('fix', type_name, 'components that are held there, or moved', example='y', &
            allowed=components(:merge(6, 18, ndim == 2)), required=.true.), &
      key_t('displacement', type_real, 'by which they are moved where its factor is 1', default=zeros, unit='m', &
            allowed=any_number, fewest=ndim, most=ndim), &
      key_t('velocity', type_real, 'with which they are moved where its factor is 1', default=zeros, unit='m/s', &
            allowed=any_number, fewest=ndim, most=ndim), &
      history_keys, &
      key_t('name', type_text, 'gives the force of this constraint columns of its own: reaction_<name>_x and _y', example='grip'), &
      key_t('unilateral', type_logical, 'whether it holds what presses on it only: a support from which material may lift off', &
            default='.false.'), &
      key_t('turns', type_logical, 'whether its nodes turn freely about the middle of the box, as a rigid body: a pin or roller', &
            default='.false.')]

   !> &constraint: nodes that are held.
   type :: constraint_spec_t
      real(dp) :: lower(ndim) = 0                !! [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      logical :: fixed(ndim) = .false.           !! which components are held
      type(given_motion_t) :: motion             !! how they are moved
      character(name_len) :: name = ''           !! of the columns of its reaction; '' for none
   end type constraint_spec_t

   type(group_t), parameter :: load_group = group_t('load', repeats, is_optional, &
      'a force on the material, with its history in time')

   type(key_t), parameter :: load_keys(*) = [ &
      key_t('kind', type_name, &
            'acts at a point, on an edge, in a box, normal to an edge or crack, on all material; or lets waves out of an edge', &
            example='traction', allowed='point|traction|body|pressure|gravity|absorbing', required=.true.), &
      key_t('lower', type_real, 'lower corner of where it acts; none of gravity and of pressure on a crack', unit='m', &
            example='0.0, 0.0'//near_side, allowed=any_number, fewest=0, most=ndim), &
      key_t('upper', type_real, 'upper corner of where it acts, for a point equal to the lower one; none where lower is none', &
            example='0.0, 0.01'//far_side, unit='m', allowed=any_number, fewest=0, most=ndim), &
      key_t('side', type_integer, &
            'of a traction, pressure or absorbing edge: the side of a polygon or rectangle, by its number; 0: all in the box', &
            default='0', allowed='[0, inf)'), &
      key_t('force', type_real, 'of a point, traction or body: resultant of the whole load where its factor is 1', &
            example='0.0, 1.0'//near_side, unit='N', allowed=any_number, fewest=0, most=ndim), &
      key_t('pressure', type_real, 'of a pressure: force on each area where its factor is 1, positive into the material', &
            default='0.0', unit='Pa', allowed=any_number), &
      key_t('on', type_name, 'of a pressure: whether on a part of a body''s edge or on all faces of a crack', default='edge', &
            allowed='edge|crack'), &
      key_t('crack', type_text, 'of a pressure on a crack: its name, not needed where there is only one'), &
      key_t('acceleration', type_real, 'of gravity: force on each mass where its factor is 1', default=zeros, unit='m/s2', &
            allowed=any_number, fewest=ndim, most=ndim), &
      key_t('face', type_name, 'of a point or traction on a line or path: its face, as one walks to its tip or last point', &
            default='none', allowed='none|left|right'), &
      history_keys, &
      key_t('name', type_text, 'by which a &probe means it')]

   !> &load: a force and its history.
   type :: load_spec_t
      character(name_len) :: kind = ''           !! 'point', 'traction', 'body', 'pressure', 'gravity' or 'absorbing'
      logical :: has_place = .true.              !! whether it acts in a box, else on all material or on a crack
      real(dp) :: lower(ndim) = 0                !! [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      integer :: side = 0                        !! of a polygon or rectangle, on which alone it acts; 0: all in the box
      integer :: of_outlines = 1                 !! how many have such a side in the box
      real(dp) :: force(ndim) = 0                !! resultant of the whole load [N]
      character(name_len) :: face = ''           !! of a crack: 'none', 'left' or 'right'
      real(dp) :: pressure = 0                   !! positive into the material [Pa]
      character(name_len) :: crack = ''          !! name of the crack that the pressure is on
      real(dp) :: acceleration(ndim) = 0         !! [m/s2]
      type(time_history_t) :: history            !! of its factor
      character(name_len) :: name = ''           !! '' for none
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
            constraint%lower = settings%vector(entry, 'lower')
            constraint%upper = settings%vector(entry, 'upper')
            fix = settings%text(entry, 'fix')
            constraint%motion%displacement = settings%vector(entry, 'displacement')
            constraint%motion%velocity = settings%vector(entry, 'velocity')
            call fill_history(settings, entry, constraint%motion%history)
            constraint%motion%history%held = settings%flag(entry, 'held')
            constraint%name = settings%text(entry, 'name')
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
            load%kind = settings%text(entry, 'kind')
            load%has_place = load%kind /= 'gravity' .and. &
                             .not. (load%kind == 'pressure' .and. settings%text(entry, 'on') == 'crack')
            if (size(settings%numbers(entry, 'lower')) == ndim) load%lower = settings%vector(entry, 'lower')
            if (size(settings%numbers(entry, 'upper')) == ndim) load%upper = settings%vector(entry, 'upper')
            if (size(settings%numbers(entry, 'force')) == ndim) load%force = settings%vector(entry, 'force')
            load%side = nint(settings%number(entry, 'side'))
            load%pressure = settings%number(entry, 'pressure')
            load%crack = settings%text(entry, 'crack')
            load%acceleration = settings%vector(entry, 'acceleration')
            load%face = settings%text(entry, 'face')
            call fill_history(settings, entry, load%history)
            load%history%held = settings%flag(entry, 'held')
            load%name = settings%text(entry, 'name')
         end associate
      end do
   end subroutine fill_loads
end module hampm_load_groups
