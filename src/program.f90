!> The actions of the program, by its options.
module hampm_program
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_size_t
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use hampm_input_warnings, only: notes_of
   use hampm_asked_errors, only: no_value
   use hampm_checkpoint, only: checkpoint_t, checkpoint_name
   use hampm_choice, only: choose, fell_short
   use hampm_choice_report, only: choice_report, explained_model
   use hampm_choice_runs, only: choice_t
   use hampm_command_line, only: options_t, changes_model, usage_text
   use hampm_continuation, only: rebuild
   use hampm_failure, only: failure_t, exit_computation, exit_file, exit_input, exit_stopped
   use hampm_file_moves, only: file_exists
   use hampm_folders, only: is_folder
   use hampm_json, only: array, member, object
   use hampm_key_reference, only: reference_text, keys_json
   use hampm_kinds, only: dp, long
   use hampm_namelist_text, only: template_text
   use hampm_resource_estimate, only: resources_t, estimate_resources, check_resources, resource_report, resource_json
   use hampm_old_files, only: refuse_files_of_others
   use hampm_reading, only: read_model, understand_model
   use hampm_recording, only: result_path
   use hampm_rule_reference, only: rules_text, rules_json
   use hampm_run, only: run, measured_duration
   use hampm_settings, only: settings_t
   use hampm_model, only: model_t
   use hampm_simulation, only: simulation_t, build, release, warnings
   use hampm_stiffness, only: stiffness_t
   use hampm_summary, only: summary, summary_json, solver_report, tip_report, equilibrium_report, equilibrium_proposal
   use hampm_text, only: digits_text, string_t, to_text, three_digits
   use hampm_threads, only: check_threads, surplus_threads, use_threads, thread_count, thread_report
   use hampm_version, only: program_name, version, release_of, commit_of
   implicit none
   private
   public :: act, run_and_report, end_program, check_report

   integer(c_int), parameter :: standard_output = 1

   interface
      subroutine c_exit(code) bind(c, name='exit')
         import :: c_int
         integer(c_int), value :: code
      end subroutine c_exit

      integer(c_size_t) function c_write(descriptor, text, size) bind(c, name='write')
         import :: c_char, c_int, c_size_t
         integer(c_int), value :: descriptor
         character(c_char), intent(in) :: text(*)
         integer(c_size_t), value :: size
      end function c_write
   end interface

contains

   !> Act by the options.
   subroutine act(options, failure)
      type(options_t), intent(in) :: options
      type(failure_t), intent(inout) :: failure
      if (options%help) then
         call print_text(usage_text(), failure)
      else if (options%version) then
         call print_text('hampm '//trim(version)//new_line('a'), failure)
      else if (options%template) then
         call print_text(template_text(), failure)
      else if (options%keys .and. options%json) then
         call print_text(keys_json(), failure)
      else if (options%keys) then
         call print_text(reference_text(), failure)
      else if (options%rules .and. options%json) then
         call print_text(rules_json(), failure)
      else if (options%rules) then
         call print_text(rules_text(), failure)
      else
         call simulate(options, failure)
         if (options%json .and. failure%failed()) call print_text(refusal_json(failure), failure)
      end if
   end subroutine act

   !> Print a text on the standard output. `exit_file` if it cannot be written.
   subroutine print_text(text, failure)
      character(*), intent(in) :: text
      type(failure_t), intent(inout) :: failure
      integer(c_size_t) :: done, more
      flush (output_unit)
      done = 0
      do while (done < len(text))                ! the run time library takes a full disk for a success
         more = c_write(standard_output, text(done + 1:), len(text, c_size_t) - done)
         if (more <= 0) exit
         done = done + more
      end do
      if (done < len(text)) call failure%report(exit_file, 'the standard output cannot be written (is the disk full?)')
   end subroutine print_text

   !> End the program with the exit code of a failure, and print its message.
   subroutine end_program(failure)
      type(failure_t), intent(in) :: failure
      if (failure%failed()) call print_message(failure%message)
      call c_exit(int(failure%code, c_int))
   end subroutine end_program

   !> Read the model, then check or run it.
   subroutine simulate(options, failure)
      type(options_t), intent(in) :: options
      type(failure_t), intent(inout) :: failure
      type(model_t) :: model
      type(simulation_t) :: simulation
      type(resources_t) :: resources
      type(settings_t) :: written
      type(choice_t) :: choice
      type(stiffness_t), allocatable :: rest     ! of --check alone
      character(:), allocatable :: report, text
      integer(long) :: clock_start
      real(dp) :: start, now                     ! processor time [s]
      call system_clock(clock_start)
      call cpu_time(start)
      call check_threads(options%threads, failure)
      if (failure%failed()) return
      report = surplus_threads(options%threads)
      if (report /= '') call print_message(report, kind='warning: ')
      if (options%resume /= '') then
         call resume(options, model, resources, simulation, failure)
      else
         call read_model(options%input, options%overrides, model, failure, written, text)
         if (.not. (failure%failed() .or. options%check .or. options%explain)) &
            call refuse_old(model, folder_of(options), options%force, failure)
         if (.not. failure%failed()) &
            call choose(options%input, text, options%overrides, options%threads, options%check, options%explain, model, &
                        written, choice, failure)
         if (options%explain .and. .not. failure%failed()) then
            call print_text(explained_model(choice, model), failure)
            return
         end if
         call cpu_time(start)
         if (.not. failure%failed()) call weigh(model, options%threads, resources, failure)
         if (options%check) allocate (rest)
         if (.not. failure%failed()) call build(model, options%threads, simulation, failure, rest)
      end if
      if (failure%failed()) return
      if (options%check) then
         if (options%json) then
            call print_text(check_json(model, simulation, resources, written, options%quiet, clock_start, &
                                       choice_report(choice, model, checks=.true.)), failure)
         else
            call print_text(check_report(model, simulation, resources, rest)// &
                            with_prefix('! ', choice_report(choice, model, checks=.true.)), failure)
            report = warnings(simulation)
            if (len(report) > 0) call print_message(report, kind='warning: ')
            if (.not. (options%quiet .or. failure%failed())) &
               call print_text(duration_report(measured_duration(simulation, resources%rows, clock_start)), failure)
         end if
      else
         if (choice%pilots > 0 .and. .not. options%quiet) write (output_unit, '(a)', advance='no') &
            choice_report(choice, model, checks=.false.)
         do
            call start_run(options, simulation, failure)
            call cpu_time(now)
            if (.not. fell_short(choice, simulation, now - start, options%threads, model, failure)) exit
            call release(simulation)
            call cpu_time(start)
            call build(model, options%threads, simulation, failure)
            if (failure%failed()) exit
            if (.not. options%quiet) write (output_unit, '(a)', advance='no') choice_report(choice, model, checks=.false.)
         end do
         call report_run(options, simulation, failure)
         call tell_accuracy(simulation, choice, options%quiet, failure)
         if (.not. options%quiet) write (output_unit, '(a)') time_report(clock_start)
      end if
      if (allocated(rest)) call rest%release()
      call release(simulation)
   end subroutine simulate

   !> Tell which errors were asked and which were reached. Fails where a result misses one; it is there nevertheless.
   subroutine tell_accuracy(simulation, choice, quiet, failure)
      type(simulation_t), intent(in) :: simulation
      type(choice_t), intent(in) :: choice
      logical, intent(in) :: quiet
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: text
      real(dp) :: estimate
      integer :: k
      if (failure%failed() .or. .not. allocated(simulation%asked)) return
      if (choice%is_open .and. .not. choice%lattices%fits) call print_message('&accuracy: a &constraint ends between '// &
         'nodes: what it holds depends on the cells, which no estimated error knows, and only other meshes tell. Let it end at '// &
         'round coordinates, or beyond the bodies', kind='warning: ')
      do k = 1, size(simulation%asked)
         associate (asked => simulation%asked(k))
            estimate = asked%estimated()
            if (choice%is_open) estimate = max(estimate, choice%reached*asked%keys%error)
            if (.not. (simulation%integrator%is_static .or. choice%is_open)) then
               if (.not. quiet) write (output_unit, '(a)') 'accuracy of '//trim(asked%keys%quantity)//': rows tell '// &
                  digits_text(100*estimate, 2)//' %; what cells and steps do to waves is not judged, as they are given'
               cycle
            end if
            if (estimate >= no_value) then
               call failure%report(exit_computation, '&accuracy quantity = '''//trim(asked%keys%quantity)// &
                                   ''': its value is 0, which has no relative error: ask for another quantity, as J')
               cycle
            end if
            text = ': estimated error '//digits_text(100*estimate, 2)//' %, asked '// &
                   digits_text(100*asked%keys%error, 3)//' %'
            if (estimate <= asked%keys%error) then
               if (.not. quiet) write (output_unit, '(a)') 'accuracy of '//trim(asked%keys%quantity)//text
            else
               call failure%report(exit_computation, '&accuracy quantity = '''//trim(asked%keys%quantity)//''''//text// &
                                   ': it is not reached; '// &
                                   'the result is that of the mesh and steps that come nearest')
            end if
         end associate
      end do
   end subroutine tell_accuracy

   !> Time and memory of the run.
   function time_report(clock_start) result(text)
      integer(long), intent(in) :: clock_start     !! ticks at the start
      character(:), allocatable :: text
      integer(long) :: clock, rate
      real(dp) :: processor
      call system_clock(clock, rate)
      call cpu_time(processor)
      text = 'wall time '//three_digits(real(clock - clock_start, dp)/real(rate, dp))//' s, processor time '// &
             three_digits(processor)//' s, threads '//to_text(thread_count())
   end function time_report

   !> Estimate the resources of a model, and refuse those that exceed limits. Use as many threads as it keeps busy.
   subroutine weigh(model, threads, resources, failure)
      type(model_t), intent(in) :: model
      integer, intent(in) :: threads               !! wanted, 0 for as many as are of use
      type(resources_t), intent(out) :: resources
      type(failure_t), intent(inout) :: failure
      resources = estimate_resources(model)
      call check_resources(resources, failure)
      if (.not. failure%failed()) call use_threads(threads, int(min(resources%particles, real(huge(threads), dp))))
   end subroutine weigh

   !> Take up a run where a checkpoint was written, with its model.
   subroutine resume(options, model, resources, simulation, failure)
      type(options_t), intent(in) :: options
      type(model_t), intent(out) :: model
      type(resources_t), intent(out) :: resources
      type(simulation_t), intent(out) :: simulation
      type(failure_t), intent(inout) :: failure
      type(checkpoint_t) :: checkpoint
      type(model_t) :: before
      character(:), allocatable :: text, begun
      call checkpoint%open(options%resume)
      if (checkpoint%other_build() /= '') call print_message(checkpoint%other_build(), kind='warning: ')
      call checkpoint%archive_text('scene', text)
      call checkpoint%archive_text('scene_of_result', begun)
      if (checkpoint%failure%failed()) then
         call checkpoint%finish(failure)
         return
      end if
      call understand_model(options%resume, text, [string_t ::], before, failure)
      if (.not. failure%failed()) call understand_model(options%resume, text, options%overrides, model, failure)
      if (failure%failed()) return
      if (.not. changes_model(options)) model%as_used = text
      model%as_begun = begun
      if (abs(model%output%history_interval - before%output%history_interval) > 1e-9_dp*before%output%history_interval) then
         call failure%report(exit_input, '--set: with --resume end_time/load_steps has to stay '// &
                             to_text(before%output%history_interval)//' s, the load step; change both')
         return
      end if
      if (.not. options%check) call refuse_files_of_others(result_path(model, folder_of(options)), failure)
      if (.not. failure%failed()) call weigh(model, options%threads, resources, failure)
      if (.not. failure%failed()) call rebuild(model, options%threads, checkpoint, simulation, failure)
      if (failure%failed() .or. simulation%problem%state%time <= model%run%end_time) return
      call failure%report(exit_input, '--set run.end_time: the run has come to '//to_text(simulation%problem%state%time)// &
                          ' s, and cannot end before that')
   end subroutine resume

   !> Refuse to begin a run where there are files of others and, unless it is forced, a result or a checkpoint of one.
   subroutine refuse_old(model, folder, force, failure)
      type(model_t), intent(in) :: model
      character(*), intent(in) :: folder
      logical, intent(in) :: force
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: path, checkpoint
      path = result_path(model, folder)
      checkpoint = checkpoint_name(path)
      call refuse_files_of_others(path, failure)
      if (failure%failed() .or. force) return
      if (file_exists(checkpoint)) then
         call failure%report(exit_file, checkpoint//': there is a checkpoint of a run. To go on with it: '// &
                             program_name//' --resume '// &
                             checkpoint//'. To begin it anew: --force. Or use another &output file or --output')
      else if (is_folder(path)) then
         return                                  ! to write the result will fail
      else if (file_exists(path)) then
         call failure%report(exit_file, path//': there is a result. To replace it: --force. Or use another &output file or '// &
                             '--output')
      end if
   end subroutine refuse_old

   !> The folder for the results: as asked for, of the checkpoint, or the current one.
   pure function folder_of(options) result(folder)
      type(options_t), intent(in) :: options
      character(:), allocatable :: folder
      integer :: slash
      folder = options%output
      if (folder /= '') return
      folder = '.'
      slash = index(options%resume, '/', back=.true.)
      if (slash > 0) folder = options%resume(:max(1, slash - 1))
   end function folder_of

   !> Run a simulation and print its warnings.
   subroutine run_and_report(options, simulation, failure)
      type(options_t), intent(in) :: options
      type(simulation_t), intent(inout) :: simulation
      type(failure_t), intent(inout) :: failure
      call start_run(options, simulation, failure)
      call report_run(options, simulation, failure)
   end subroutine run_and_report

   !> Run a simulation.
   subroutine start_run(options, simulation, failure)
      type(options_t), intent(in) :: options
      type(simulation_t), intent(inout) :: simulation
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: report
      associate (output => simulation%model%output, interruption => simulation%interruption)
         interruption%interval = output%checkpoint_interval
         interruption%every_steps = output%checkpoint_steps
         interruption%time_limit = options%time_limit
         interruption%step_limit = options%steps
      end associate
      if (.not. options%quiet) write (output_unit, '(a)') thread_report()
      if (.not. options%quiet .and. options%resume == '') &
         write (output_unit, '(a)', advance='no') with_prefix('note: ', as_lines(notes_of(simulation%model)))
      report = long_run(simulation)
      if (len(report) > 0 .and. .not. options%time_limit > 0) call print_message(report, kind='warning: ')
      call run(simulation, folder_of(options), options%quiet, failure)
   end subroutine start_run

   !> Print what a run has found, and its warnings.
   subroutine report_run(options, simulation, failure)
      type(options_t), intent(in) :: options
      type(simulation_t), intent(inout) :: simulation
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: report
      if (failure%code == exit_stopped) return
      report = solver_report(simulation)
      if (.not. options%quiet .and. len(report) > 0) write (output_unit, '(a)') report
      report = simulation%integrator%report()
      if (.not. options%quiet .and. len(report) > 0) write (output_unit, '(a)') report
      if (allocated(simulation%stopped_when) .and. .not. (options%quiet .or. failure%failed())) &
         write (output_unit, '(a)') 'ended at t = '//digits_text(simulation%problem%state%time, 6)//' s by &run stop_when, '// &
         simulation%stopped_when
      if (.not. (options%quiet .or. failure%failed())) then
         write (output_unit, '(a)', advance='no') as_lines(tip_report(simulation))
         if (simulation%distance_to_equilibrium >= 0) &
            write (output_unit, '(a)') 'distance to equilibrium: '//equilibrium_report(simulation)
      end if
      report = warnings(simulation)
      if (len(report) > 0) call print_message(report, kind='warning: ')
   end subroutine report_run

   !> How long a motion takes on a usual machine, to tell before it starts; '' where that is less than a day.
   function long_run(simulation) result(text)
      type(simulation_t), intent(in) :: simulation
      character(:), allocatable :: text
      real(dp), parameter :: explicit = 2e-7_dp, implicit = 5e-6_dp ! time for a step of a particle, at least [s]
      real(dp), parameter :: day = 86400
      real(dp) :: steps, time
      text = ''
      associate (s => simulation)
         if (s%integrator%is_static) return
         steps = (s%model%run%end_time - s%problem%state%time)/s%longest_step
         time = steps*s%problem%particles%n*merge(explicit, implicit, s%model%method%time == 'explicit')/thread_count()
         if (time < day) return
         text = 'the run takes about '//three_digits(time/day)//' days: '//three_digits(steps)//' steps of '// &
                three_digits(s%longest_step)//' s. For less use a shorter &run end_time or a larger &grid cell; '// &
                '--time-limit ends it with a checkpoint; --check measures its time'
      end associate
   end function long_run

   !> Output of --check: the model as it is used, and the summary of a simulation as comments, so that it can be run.
   function check_report(model, simulation, resources, rest) result(text)
      type(model_t), intent(in) :: model
      type(simulation_t), intent(inout) :: simulation
      type(resources_t), intent(in) :: resources
      type(stiffness_t), intent(inout) :: rest   !! as `build` leaves it
      character(:), allocatable :: text
      text = model%as_used//with_prefix('! ', summary(simulation)//equilibrium_proposal(simulation, rest)// &
                                        refinement_summary(model)//resource_report(resources))// &
             with_prefix('! note: ', as_lines(notes_of(model)))
   end function check_report

   !> The last line of --check: the duration of a run [s]; '' if that is not known, below 0.
   function duration_report(duration) result(text)
      real(dp), intent(in) :: duration
      character(:), allocatable :: text
      text = ''
      if (duration < 0) return
      text = '! wall time       about '//digits_text(duration, 2)//' s on this machine: '//thread_report()//new_line('a')
   end function duration_report

   !> The same for programs, as one line of JSON; with `seconds`, the duration of the run on this machine, unless `quiet`.
   function check_json(model, simulation, resources, written, quiet, clock_start, chosen) result(text)
      type(model_t), intent(in) :: model
      type(simulation_t), intent(inout) :: simulation
      type(resources_t), intent(in) :: resources
      type(settings_t), intent(in) :: written
      logical, intent(in) :: quiet
      integer(long), intent(in) :: clock_start   !! ticks at the start
      character(*), intent(in) :: chosen         !! report of what &accuracy has chosen; '' without it
      character(:), allocatable :: text
      real(dp) :: duration
      text = own_json(is_valid=.true.)//summary_json(simulation)//resource_json(resources)// &
             member('errors', array(''), raw=.true.)// &
             member('warnings', array(written%records_of(warnings(simulation))), raw=.true.)// &
             member('notes', array(written%records_of(notes_of(model))), raw=.true.)//member('namelist', model%as_used)
      duration = -1
      if (.not. quiet) duration = measured_duration(simulation, resources%rows, clock_start)
      text = text//member('threads', thread_count())
      if (chosen /= '') text = text//member('accuracy', chosen)
      if (duration >= 0) text = text//member('seconds', duration)
      text = object(text)//new_line('a')
   end function check_json

   !> Output of --check --json for a model that is refused.
   function refusal_json(failure) result(text)
      type(failure_t), intent(in) :: failure
      character(:), allocatable :: text
      text = object(own_json(is_valid=.false.)//member('errors', array(failure%records), raw=.true.))//new_line('a')
   end function refusal_json

   !> First members of the JSON of a model: the program, and whether the model is valid.
   function own_json(is_valid) result(text)
      logical, intent(in) :: is_valid
      character(:), allocatable :: text
      text = member('program', 'hampm')//member('version', release_of(version))//member('commit', commit_of(version))// &
             member('valid', is_valid)
   end function own_json

   !> How cells refine, and how deep; no line where they do not.
   pure function refinement_summary(model) result(text)
      type(model_t), intent(in) :: model
      character(:), allocatable :: text
      text = ''
      associate (refine => model%refine)
         if (refine%by%name == '') return
         text = 'refinement      '//trim(refine%by%name)//', at most '//to_text(refine%max_level)//' levels, to cells of '// &
                to_text(scale(model%grid%cell, -refine%max_level))//' m'//new_line('a')
      end associate
   end function refinement_summary

   !> Print every line of a message to the standard error, behind the name of the program and the kind of message.
   subroutine print_message(message, kind)
      character(*), intent(in) :: message
      character(*), intent(in), optional :: kind
      character(:), allocatable :: prefix
      prefix = 'hampm: '
      if (present(kind)) prefix = prefix//kind
      flush (output_unit)
      write (error_unit, '(a)', advance='no') with_prefix(prefix, message//new_line('a'))
      flush (error_unit)
   end subroutine print_message

   !> A text of which every line ends with a line feed, from one in which it stands between lines.
   pure function as_lines(text) result(lines)
      character(*), intent(in) :: text
      character(:), allocatable :: lines
      lines = text
      if (len(text) > 0) lines = text//new_line('a')
   end function as_lines

   !> Put a prefix before every line of a text whose lines all end with a line feed.
   pure function with_prefix(prefix, text) result(prefixed)
      character(*), intent(in) :: prefix, text
      character(:), allocatable :: prefixed
      integer :: first, last
      prefixed = ''
      first = 1
      do while (first <= len(text))
         last = first + index(text(first:), new_line('a')) - 1
         prefixed = prefixed//prefix//text(first:last)
         first = last + 1
      end do
   end function with_prefix
end module hampm_program
