!> From a namelist file to a model. Files of models are read here and nowhere else.
!>
!> `--set group.key=value`: values of the command line that replace values of the file.
module hampm_reading
   use hampm_body_group, only: body_t, fill_bodies
   use hampm_choice_sets, only: is_among
   use hampm_consistency, only: check_consistency
   use hampm_failure, only: failure_t
   use hampm_kinds, only: dp, ndim
   use hampm_namelist_file, only: read_text, scan_namelist, scan_value_text
   use hampm_namelist_text, only: canonical_text
   use hampm_rule_check, only: check_rules
   use hampm_model, only: model_t, fill_model
   use hampm_settings, only: settings_t, setting_t, group_entry_t, input_errors_t
   use hampm_stability_consistency, only: choose_courant
   use hampm_text, only: string_t, to_text, lower_case, printable
   use hampm_validation, only: validate
   use hampm_version, only: program_name
   use hampm_values, only: least_magnitude
   use hampm_key_rows, only: is_required, key_t, max_values
   use hampm_keys, only: groups, keys, find_group, find_key, first_key, unknown_group, unknown_key, is_text, new_entry
   implicit none
   private
   public :: read_model, understand_model, split_instance

   real(dp), parameter :: most_factorised = merge(1.0e6_dp, 3.0e4_dp, ndim == 2) !! cells up to which `solver = 'auto'` factorises

   character(*), parameter :: by_user = '--set ', by_choice = 'chosen for &accuracy, ' !! places of overrides, for messages

contains

   !> Read a model. Every error in the file and in the overrides is reported, not only the first.
   subroutine read_model(path, overrides, model, failure, written, text)
      character(*), intent(in) :: path
      type(string_t), intent(in) :: overrides(:)   !! `group.key=value`; later ones win
      type(model_t), intent(out) :: model
      type(failure_t), intent(inout) :: failure
      type(settings_t), intent(out), optional :: written !! settings read, with their locations
      character(:), allocatable, intent(out) :: text !! of the file
      text = ''
      call read_text(path, text, failure)
      if (.not. failure%failed()) call understand_model(path, text, overrides, model, failure, written)
   end subroutine read_model

   !> The model that a namelist text and overrides describe.
   subroutine understand_model(path, text, overrides, model, failure, written, chosen)
      character(*), intent(in) :: path             !! of the file that the text comes from, for messages
      character(*), intent(in) :: text
      type(string_t), intent(in) :: overrides(:)   !! `group.key=value`; later ones win
      type(model_t), intent(out) :: model
      type(failure_t), intent(inout) :: failure
      type(settings_t), intent(out), optional :: written !! settings read, with their locations
      type(string_t), intent(in), optional :: chosen(:) !! overrides that &accuracy has chosen
      type(settings_t) :: settings
      logical :: lacks_lattice                     ! which is to be chosen
      logical :: is_other                          ! than a model of this program
      integer :: i
      settings%file = path
      call scan_namelist(path, text, settings)
      call find_no_namelist(text, settings, is_other)
      do i = 1, size(overrides)
         if (.not. is_other) call override(overrides(i)%text, settings, by_user)
      end do
      if (present(chosen)) then
         do i = 1, size(chosen)
            call override(chosen(i)%text, settings, by_choice)
         end do
      end if
      if (.not. is_other) call find_other_program(settings, is_other)
      if (is_other) then
         call settings%errors%tell(failure)
         if (present(written)) written = settings
         return
      end if
      lacks_lattice = settings%count_of('grid') == 0 .and. settings%count_of('accuracy') > 0
      if (lacks_lattice) call override('grid.cell=1', settings, by_choice)
      if (lacks_lattice) call override('grid.cells='//repeat('1,', ndim - 1)//'1', settings, by_choice)
      call validate(settings)
      if (lacks_lattice) call lay_over_bodies(settings)
      call resolve(settings)
      call fill_model(settings, model)
      model%lacks_lattice = lacks_lattice
      if (lacks_lattice) then
         call settings%errors%tell(failure)
         if (present(written)) written = settings
         return
      end if
      call choose_courant(model, settings)
      model%warned = ''
      model%noted = ''
      call check_rules(model, settings, model%warned, model%noted)
      call check_consistency(model, settings)
      call settings%errors%tell(failure)
      if (.not. failure%failed()) model%as_used = canonical_text(settings)
      if (.not. failure%failed()) model%as_begun = model%as_used
      if (present(written)) written = settings
   end subroutine understand_model

   !> Whether a text begins with something other than a group, and has no mandatory group, or much else between groups: one error
   !> instead of one for each word.
   pure subroutine find_no_namelist(text, settings, is_other)
      character(*), intent(in) :: text
      type(settings_t), intent(inout) :: settings
      logical, intent(out) :: is_other
      integer, parameter :: most_beside = 3       ! errors of a namelist with a line that was to be a comment
      type(input_errors_t) :: errors
      integer :: first, last, i
      last = 0
      do                                         ! comments
         first = last + verify(text(last + 1:), ' '//achar(9)//achar(10)//achar(13))
         is_other = first > last
         if (.not. is_other) return
         last = first + scan(text(first:)//achar(10), achar(10)//achar(13)) - 2
         if (text(first:first) /= '!') exit
      end do
      is_other = scan(text(first:first), '&'//char(239)) == 0 .and. (settings%errors%count > most_beside .or. &
                 .not. any([(groups(settings%entries(i)%group)%presence == is_required, i=1, settings%count)]))
      if (.not. is_other) return
      call errors%add('is no namelist file: it begins with '''//printable(text(first:last), 40)//''', not with a group, '// &
                      '&name key = value /; '//program_name//' --template prints a model', settings%file//':'// &
                      to_text(1 + count([(text(i:i) == achar(10), i=1, first)])))
      settings%errors = errors
   end subroutine find_no_namelist

   !> Whether the grid is of a solid in the program of the plane, or the reverse: one error instead of one for every place.
   pure subroutine find_other_program(settings, is_other)
      type(settings_t), intent(inout) :: settings
      logical, intent(out) :: is_other
      integer :: grid
      grid = settings%find('grid', 1)
      is_other = values_of('cells') == 5 - ndim .and. any(values_of('lower') == [0, 5 - ndim])
      if (is_other) call settings%complain(grid, 'cells', 'has '//to_text(5 - ndim)//' values, as that of '// &
                                           trim(merge('a plane: run hampm                                     ', &
                                                      'a solid: run hampm3d, which `make program dim=3` builds', ndim > 2)))
   contains
      !> How many values a key of the grid has.
      pure integer function values_of(key) result(n)
         character(*), intent(in) :: key
         n = 0
         if (grid > 0) n = settings%entries(grid)%settings(find_key(settings%entries(grid)%group, key))%count
      end function values_of
   end subroutine find_other_program

   !> Lay a lattice over the boxes of all bodies, for what is measured before one is chosen.
   pure subroutine lay_over_bodies(settings)
      type(settings_t), intent(inout) :: settings
      integer, parameter :: most = 64            ! cells along the longest side
      type(body_t), allocatable :: bodies(:)
      real(dp) :: lower(ndim), upper(ndim), cell
      integer :: d, k
      call fill_bodies(settings, bodies)
      if (size(bodies) == 0) return
      do d = 1, ndim
         lower(d) = minval([(bodies(k)%lower(d), k=1, size(bodies))])
         upper(d) = maxval([(bodies(k)%upper(d), k=1, size(bodies))])
      end do
      cell = maxval(upper - lower)/most
      if (.not. cell > 0) return
      call settings%set_numbers(settings%find('grid', 1), 'lower', lower)
      call settings%set_numbers(settings%find('grid', 1), 'cell', [cell])
      call settings%set_numbers(settings%find('grid', 1), 'cells', max(1.0_dp, anint((upper - lower)/cell + 0.5_dp)))
   end subroutine lay_over_bodies

   !> Resolve values that stand for another one.
   pure subroutine resolve(settings)
      type(settings_t), intent(inout) :: settings
      real(dp) :: direction(ndim)
      character(:), allocatable :: solver, time
      integer :: run, output, crack, method
      run = settings%find('run', 1)
      output = settings%find('output', 1)
      crack = settings%find('crack', 1)
      method = settings%find('method', 1)
      time = settings%text(method, 'time')
      if (.not. settings%given(output, 'file')) call settings%set_text(output, 'file', result_file(settings%file))
      if (settings%good(output, 'history_interval') .and. settings%good(run, 'end_time')) then
         if (settings%number(output, 'history_interval') <= 0) &
            call settings%set_numbers(output, 'history_interval', [max(settings%number(run, 'end_time')/1000, least_magnitude)])
         if (time == 'static' .and. settings%good(method, 'load_steps')) &
            call settings%set_numbers(output, 'history_interval', [max(settings%number(run, 'end_time') &
                                                                       /settings%number(method, 'load_steps'), least_magnitude)])
      end if
      if (time == 'implicit' .and. settings%good(run, 'end_time') .and. settings%good(method, 'time_step') &
          .and. settings%good(method, 'courant')) then
         if (settings%number(method, 'time_step') <= 0 .and. settings%number(method, 'courant') <= 0) &
            call settings%set_numbers(method, 'time_step', [max(settings%number(run, 'end_time')/1000, least_magnitude)])
      end if
      if (settings%text(method, 'mass') == 'auto') &
         call settings%set_text(method, 'mass', trim(merge('tip_weighted', 'lumped      ', waves_of_cells_leave_tips(settings))))
      if (settings%text(method, 'solver') == 'auto') then
         solver = 'direct'
         if (time == 'explicit' .and. .not. cuts_quadratic_cells(settings)) then
            if (.not. has_factors(settings%text(method, 'mass')) .or. has_many_cells(settings)) solver = 'cg'
         end if
         if (ndim == 3 .and. (time == 'static' .or. time == 'implicit')) &
            solver = merge('cg  ', 'auto', has_many_cells(settings)) ! else by the unknowns
         call settings%set_text(method, 'solver', trim(solver))
      end if
      if (settings%good(crack, 'direction')) then
         direction = settings%numbers(crack, 'direction')
         direction = direction/max(maxval(abs(direction)), least_magnitude)
         where (abs(direction) < 1e-9_dp) direction = 0
         call settings%set_numbers(crack, 'direction', direction)
      end if
   end subroutine resolve

   !> Whether tips, or fronts of slabs, grow in explicit steps, in which lumped masses at their faces radiate waves of the cells.
   !> Points of faces with contact or cohesion, and those of `usl`, move lumped masses with any matrix. Each point that is bonded
   !> ahead of a wide front would have a solution of its own, and a full row of the matrix of all.
   pure logical function waves_of_cells_leave_tips(settings) result(they_do)
      type(settings_t), intent(in) :: settings
      integer :: k, method
      method = settings%find('method', 1)
      they_do = .false.
      if (settings%text(method, 'time') /= 'explicit' .or. settings%text(method, 'scheme') == 'usl') return
      if (ndim > 2 .and. .not. is_slab(settings)) return
      if (settings%number(method, 'courant') > 0) return ! of the steps of lumped masses, which are longer
      if (settings%count_of('cohesive') > 0) return
      if (settings%text(method, 'frame') == 'updated') then ! what flies through the cells loses more with solved masses
         if (any([(any(abs(settings%numbers(settings%find('body', k), 'velocity')) > 0), k=1, settings%count_of('body'))])) return
      end if
      they_do = any([(is_among(settings%text(settings%find('growth', k), 'law'), ['{growth laws in motion}']), &
                      k=1, settings%count_of('growth'))])
      do k = 1, settings%count_of('crack')
         they_do = they_do .and. settings%text(settings%find('crack', k), 'contact') == 'none'
      end do
   end function waves_of_cells_leave_tips

   !> Whether the grid is a slab of few cells, the finest ones counted.
   pure logical function is_slab(settings)
      type(settings_t), intent(in) :: settings
      integer, parameter :: most_across = 4
      integer :: grid, refine, levels
      grid = settings%find('grid', 1)
      refine = settings%find('refine', 1)
      levels = 0
      if (settings%count_of('refine') > 0) then
         if (settings%text(refine, 'indicator') /= 'none') levels = nint(settings%number(refine, 'max_level'))
      end if
      is_slab = settings%good(grid, 'cells')
      if (is_slab) is_slab = nint(minval(settings%numbers(grid, 'cells'))) <= most_across/2**min(levels, most_across)
   end function is_slab

   !> Whether nodal equations with a mass matrix are solved by its factors.
   pure logical function has_factors(mass)
      character(*), intent(in) :: mass
      has_factors = mass /= 'lumped' .and. mass /= 'fmpm'
   end function has_factors

   !> Whether the factors of a mass matrix would take far more memory than all else.
   pure logical function has_many_cells(settings)
      type(settings_t), intent(in) :: settings
      integer :: grid
      grid = settings%find('grid', 1)
      has_many_cells = .false.
      if (settings%good(grid, 'cells')) has_many_cells = product(settings%numbers(grid, 'cells')) > most_factorised
   end function has_many_cells

   !> Whether quadratic cells are cut by cracks or edges or may be at an axis: cell-by-cell iterations are not for these.
   pure logical function cuts_quadratic_cells(settings) result(cuts)
      type(settings_t), intent(in) :: settings
      integer :: k
      cuts = .false.
      if (.not. settings%good(settings%find('grid', 1), 'order')) return
      if (settings%number(settings%find('grid', 1), 'order') < 2) return
      cuts = settings%text(settings%find('run', 1), 'plane') == 'axisymmetric' .or. &
             any([(settings%text(settings%find('crack', k), 'kind') == 'path', k=1, settings%count_of('crack'))]) .or. &
             any([(settings%text(settings%find('body', k), 'shape') /= 'rectangle' .or. &
                   settings%flag(settings%find('body', k), 'hole'), k=1, settings%count_of('body'))])
   end function cuts_quadratic_cells

   !> Name of the result file of a namelist file: without folder, `.h5` instead of its ending.
   pure function result_file(path) result(name)
      character(*), intent(in) :: path
      character(:), allocatable :: name
      integer :: dot
      name = path(index(path, '/', back=.true.) + 1:)
      dot = index(name, '.', back=.true.)
      if (dot > 1) name = name(:dot - 1)
      name = name//'.h5'
   end function result_file

   !> Apply one override, `group.key=value` or `group(2).key=value` for the second group of a name.
   !> A group that the file does not have is added.
   pure subroutine override(text, settings, origin)
      character(*), intent(in) :: text
      type(settings_t), intent(inout) :: settings
      character(*), intent(in) :: origin           !! `by_user` or `by_choice`
      character(:), allocatable :: source, name, message
      type(setting_t) :: setting
      integer :: equals, dot, group, key, instance, entry
      source = origin//printable(text, 60)
      equals = index(text, '=')
      dot = index(text(:max(equals, 1)), '.')
      group = 0
      key = 0
      message = 'must have the form group.key=value, or group(2).key=value for the second of its name'
      if (equals > 1 .and. dot > 1) then
         call split_instance(trim(adjustl(text(:dot - 1))), name, instance)
         group = find_group(name)
         message = unknown_group(name)
      end if
      if (group > 0) then
         name = lower_case(trim(adjustl(text(dot + 1:equals - 1))))
         key = find_key(group, name)
         message = unknown_key(group, name)
      end if
      entry = 0
      if (key > 0) call choose_entry(settings, group, instance, source, entry, message)
      if (message /= '') then
         call settings%errors%add(message, source)
         return
      end if
      setting%given = .true.
      setting%location = source
      call take_values(keys(first_key(group) + key - 1), text(equals + 1:), group, setting, settings%errors)
      settings%entries(entry)%settings(key) = setting
   end subroutine override

   !> Split `group(2)` into name and number; the number is 0 if absent and -1 if wrong.
   pure subroutine split_instance(text, name, instance)
      character(*), intent(in) :: text
      character(:), allocatable, intent(out) :: name
      integer, intent(out) :: instance
      character(:), allocatable :: digits
      integer :: bracket
      bracket = index(text, '(')
      instance = 0
      name = lower_case(text)
      if (bracket == 0) return
      name = lower_case(trim(text(:bracket - 1)))
      digits = text(bracket + 1:max(len(text) - 1, bracket))
      instance = -1
      if (len(digits) < 1 .or. len(digits) > 6 .or. verify(digits, '0123456789') > 0) return
      if (text(len(text):) /= ')') return
      read (digits, '(i6)') instance
      if (instance == 0) instance = -1
   end subroutine split_instance

   !> The named group; it is added if the model has none of this name.
   pure subroutine choose_entry(settings, group, instance, source, entry, message)
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: group, instance
      character(*), intent(in) :: source
      integer, intent(out) :: entry
      character(:), allocatable, intent(out) :: message   !! error message, '' for none
      type(group_entry_t) :: added
      character(:), allocatable :: name
      integer :: present
      name = trim(groups(group)%name)
      present = settings%count_of(name)
      message = ''
      entry = 0
      if (instance == -1) then
         message = 'the number of a group must be an integer in [1, inf): '//name//'(2)'
      else if (instance > max(present, 1)) then
         message = 'there is no &'//name//'('//to_text(instance)//'), the number of &'//name//' is '//to_text(present)
      else if (instance == 0 .and. present > 1) then
         message = 'there are '//to_text(present)//' of &'//name//': say which, for example '//name//'(2)'
      else if (present == 0) then
         added = new_entry(group, source)
         call settings%add_entry(added)
         entry = settings%count
      else
         entry = settings%find(name, max(instance, 1))
      end if
   end subroutine choose_entry

   !> The values behind the `=`. Quotes may be missing, since a shell takes them away.
   pure subroutine take_values(key, text, group, setting, errors)
      type(key_t), intent(in) :: key
      character(*), intent(in) :: text
      integer, intent(in) :: group
      type(setting_t), intent(inout) :: setting
      type(input_errors_t), intent(inout) :: errors
      integer :: i
      if (is_text(key) .and. key%most == 1 .and. scan(adjustl(text//' '), '''"') /= 1) then
         call setting%append(trim(adjustl(text)), .true.)
      else
         call scan_value_text(setting%location, text, group, setting, errors)
         do i = 1, min(setting%count, max_values)
            setting%values(i)%quoted = setting%values(i)%quoted .or. is_text(key) .and. .not. setting%values(i)%is_null()
         end do
      end if
   end subroutine take_values
end module hampm_reading
