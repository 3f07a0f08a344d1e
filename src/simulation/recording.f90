!> Output of a run: rows of the history and snapshots when they are due, the progress line, and the way it has ended.
module hampm_recording
   use, intrinsic :: ieee_exceptions, only: ieee_usual, ieee_get_halting_mode, ieee_set_halting_mode
   use, intrinsic :: iso_fortran_env, only: compiler_version, compiler_options
   use hampm_kinds, only: dp, long
   use hampm_asked_errors, only: new_asked_errors
   use hampm_cohesive_zone, only: check_zones
   use hampm_element_operators, only: element_operators_t
   use hampm_failure, only: failure_t, exit_done, exit_computation, exit_stopped
   use hampm_front_values, only: front_fields
   use hampm_folders, only: ensure_folder
   use hampm_growing, only: note_branching, tell_taken
   use hampm_growth_points, only: book_rate, must_book
   use hampm_run_time_checks, only: check_state, check_tip, check_faces, check_modes, check_normals, check_rest
   use hampm_measurements, only: take_row, declare_columns, energy_residual, measure_tips, has_measured_tips, have_errors, &
                                  look_for_waves, need_sample, follow_waves
   use hampm_nodal_fields, only: nodal_fields_t
   use hampm_particles, only: particles_t
   use hampm_problem, only: update_particles
   use hampm_progress, only: standing_t
   use hampm_static_equilibrium, only: find_distance_to_equilibrium
   use hampm_model, only: model_t
   use hampm_simulation, only: simulation_t, measure_state, warnings, is_near_equilibrium
   use hampm_snapshots, only: piece_t
   use hampm_text, only: joined, to_text
   use hampm_threads, only: thread_count, host_name
   use hampm_version, only: version, release_of, commit_of
   use hampm_output_fields, only: shows_cracks, particle_fields, mesh_fields, crack_fields
   implicit none
   private
   public :: open_results, next_row, is_due, record, record_between_rows, record_end, show_progress, result_path

   real(dp), parameter :: rounding = 1.0e-6_dp   !! tolerance of a time or a step, relative to a step

contains

   !> Create the result file, or continue it, with its provenance.
   subroutine open_results(s, folder, failure)
      type(simulation_t), intent(inout) :: s
      character(*), intent(in) :: folder
      type(failure_t), intent(inout) :: failure
      if (size(s%model%accuracy) > 0) then
         call take_row(s%model, s%problem, s%cracks, s%growing, 0.0_dp, s%measurements)
         call new_asked_errors(s%model%accuracy, s%measurements%history, s%asked, failure)
      end if
      if (.not. (s%is_pilot .or. failure%failed())) call ensure_folder(folder, failure)
      if (failure%failed()) return
      if (s%is_pilot) then
         call s%results%write_nothing()
      else if (allocated(s%lengths)) then
         call s%results%resume(result_path(s%model, folder), s%model%as_begun, s%lengths, failure)
      else
         call s%results%create(result_path(s%model, folder), failure)
      end if
      call s%results%add_text('/input/namelist', s%model%as_used, failure)
      call s%results%add_attribute('/input', 'version', trim(version), failure)
      call s%results%add_attribute('/input', 'compiler', compiler_version(), failure)
      call s%results%add_attribute('/input', 'compiler_options', compiler_options(), failure)
      call s%results%add_attribute('/input', 'host', host_name(), failure)
      call s%results%add_attribute('/input', 'threads', thread_count(), failure)
      call s%results%add_attribute('/', 'program', 'hampm', failure)
      call s%results%add_attribute('/', 'version', release_of(version), failure)
      call s%results%add_attribute('/', 'commit', commit_of(version), failure)
      call s%results%add_attribute('/', 'date', now(), failure)
      call s%results%add_attribute('/', 'command', command(), failure)
      call s%results%add_attribute('/', 'machine', host_name(), failure)
      call s%results%add_attribute('/history', 'title', trim(s%model%run%title), failure)
      associate (names => [s%model%paths%name, s%model%planes%name])
         if (any(names /= '')) call s%results%add_attribute('/history', 'cracks', joined(names, ', '), failure)
      end associate
      call declare_columns(s%model, s%problem, s%cracks, s%growing, s%measurements, s%results, failure)
   end subroutine open_results

   !> Local date and time, with the offset from UTC: `2001-12-31T23:59:59+01:00` (ISO 8601).
   function now() result(text)
      character(:), allocatable :: text
      character(8) :: date
      character(10) :: time
      character(5) :: zone
      call date_and_time(date, time, zone)
      text = date(:4)//'-'//date(5:6)//'-'//date(7:)//'T'//time(:2)//':'//time(3:4)//':'//time(5:6)//zone(:3)//':'//zone(4:)
   end function now

   !> The command that has started the program.
   function command() result(text)
      character(:), allocatable :: text
      integer :: length
      call get_command(length=length)
      allocate (character(length) :: text)
      call get_command(text)
   end function command

   !> Time of the next row of the history [s].
   pure real(dp) function next_row(s) result(time)
      type(simulation_t), intent(in) :: s
      time = min(output_time(s, s%samples, s%model%output%history_interval), s%model%run%end_time)
   end function next_row

   !> Time of an output at a multiple of its interval [s]: the end of the run where only rounding is between them.
   pure real(dp) function output_time(s, multiple, interval) result(time)
      type(simulation_t), intent(in) :: s
      integer(long), intent(in) :: multiple
      real(dp), intent(in) :: interval           !! [s]
      time = multiple*interval
      if (abs(time - s%model%run%end_time) <= same_time(s)) time = s%model%run%end_time
   end function output_time

   !> Times that differ by no more are the same [s]: a small part of a step and of the intervals between outputs, which may be
   !> shorter than a step, or rounding.
   pure real(dp) function same_time(s)
      type(simulation_t), intent(in) :: s
      associate (output => s%model%output)
         same_time = min(s%longest_step, output%history_interval)
         if (output%snapshot_interval > 0) same_time = min(same_time, output%snapshot_interval)
      end associate
      same_time = max(rounding*same_time, 4*spacing(s%model%run%end_time))
   end function same_time

   !> Whether the time of an output has come.
   pure logical function is_due(s, time)
      type(simulation_t), intent(in) :: s
      real(dp), intent(in) :: time               !! of the output [s]
      is_due = s%problem%state%time >= time - same_time(s)
   end function is_due

   !> Record a row of the history and the snapshot that is due, and check the state.
   subroutine record(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      integer :: k
      if (failure%failed()) return
      s%measurements%indicator = s%refinement%value
      call look_for_waves(s%model, s%problem, s%cracks, s%measurements)
      call measure_state(s, failure)
      if (failure%failed()) return
      call book_growth(s)
      call check_state(s%problem, trim(s%model%method%time), s%measurements, s%warning, failure)
      if (.not. failure%failed()) call check_normals(s%problem, failure)
      if (size(s%cracks%tips) > 0 .and. .not. failure%failed()) call check_tip(s%problem, s%cracks%tips(1), failure)
      if (failure%failed()) return
      do k = 1, size(s%cracks%tips)
         if (s%cracks%tips(k)%is_measured()) &
            call check_modes(s%problem, s%cracks%tips(k), s%warning)
      end do
      call note_branching(s%growing, s%model, s%problem%materials, s%cracks, s%measurements%crack, s%problem%state%time, &
                          s%warning)
      if (s%problem%interfaces%n_cohesive > 0) call check_zones(s%cracks, s%problem%interfaces, s%warning)
      call follow_waves(s%model, s%problem, s%growing, .true., s%measurements)
      call take_row(s%model, s%problem, s%cracks, s%growing, s%dt, s%measurements)
      if (allocated(s%asked)) call s%asked%take(s%measurements%history)
      call s%results%append(s%measurements%history%row, failure)
      if (is_due(s, next_row(s))) s%samples = next_multiple(s, s%samples, s%model%output%history_interval)
      if (has_snapshot(s)) call take_snapshot(s, failure)
   end subroutine record

   !> After a step without a row: take the snapshot that is due. The run is not changed by it, to the last digit. Quantities of rows
   !> over all times, as the largest G so far, cover all steps where rows do not end them.
   subroutine record_between_rows(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(particles_t) :: particles
      type(nodal_fields_t) :: fields
      type(element_operators_t) :: operators
      logical :: were_behind, has_measured
      if (failure%failed()) return
      has_measured = has_measured_tips(s%problem, s%measurements)
      call look_for_waves(s%model, s%problem, s%cracks, s%measurements)
      if (.not. s%integrator%ends_at_rows) then
         if (.not. has_measured .and. (any(s%measurements%crack%errors%are_known) .or. s%growing%are_there() .or. &
                                       size(s%measurements%fronts) > 0 .and. .not. s%integrator%is_static)) &
            call measure_tips(s%model, s%problem, s%cracks, s%measurements, failure)
         has_measured = .true.
         call book_growth(s)
      else if (must_book_growth(s)) then
         if (.not. has_measured) then
            call update_particles(s%problem)
            call measure_tips(s%model, s%problem, s%cracks, s%measurements, failure)
         end if
         has_measured = .true.
         call book_growth(s)
      else if (.not. has_measured .and. need_sample(s%model, s%problem, s%cracks, s%measurements, next_row(s), s%dt)) then
         call update_particles(s%problem)
         call measure_tips(s%model, s%problem, s%cracks, s%measurements, failure, for_waves=.true.)
         has_measured = .true.
      end if
      if (failure%failed()) return
      call follow_waves(s%model, s%problem, s%growing, has_measured, s%measurements)
      if (.not. has_snapshot(s)) return
      associate (m => s%problem)
         were_behind = m%cache%operators%is_behind
         if (were_behind) then
            particles = m%particles
            fields = m%fields
            operators = m%cache%operators
            call update_particles(m)
         end if
         if (size(s%measurements%fronts) > 0) call measure_state(s, failure, in_passing=.true.)
         if (.not. failure%failed()) call take_snapshot(s, failure)
         if (.not. were_behind) return
         m%particles = particles
         m%fields = fields
         m%cache%operators = operators
      end associate
   end subroutine record_between_rows

   !> Book the energy released by moving tips since the last time, by the last measured G.
   subroutine book_growth(s)
      type(simulation_t), intent(inout) :: s
      if (s%growing%are_there() .and. .not. s%growing%is_static) &
         call book_rate(s%growing, s%model, s%cracks, s%measurements%crack, &
                        goes_on=.not. s%integrator%ends_at_rows .or. must_book_growth(s))
   end subroutine book_growth

   !> Whether it is to be booked after this explicit step, where it is recorded.
   pure logical function must_book_growth(s) result(must)
      type(simulation_t), intent(in) :: s
      must = s%growing%are_there() .and. .not. (s%growing%is_static .or. size(s%model%planes) > 0 .or. &
                                                any(s%problem%materials%has_history))
      if (must) must = must_book(s%growing, s%cracks, s%problem%state%time - s%dt/2)
   end function must_book_growth

   !> Whether the time of the next snapshot has come: it is of the end of the step in which it does.
   pure logical function has_snapshot(s)
      type(simulation_t), intent(in) :: s
      has_snapshot = s%model%output%snapshot_interval > 0
      if (has_snapshot) has_snapshot = is_due(s, output_time(s, s%snapshots, s%model%output%snapshot_interval))
   end function has_snapshot

   !> Write a snapshot in the run.
   subroutine take_snapshot(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      call write_snapshot(s, .false., failure)
      s%snapshots = next_multiple(s, s%snapshots, s%model%output%snapshot_interval)
   end subroutine take_snapshot

   !> The next multiple of an interval whose time has not come: a step that is longer than that passes some by.
   pure integer(long) function next_multiple(s, last, interval) result(multiple)
      type(simulation_t), intent(in) :: s
      integer(long), intent(in) :: last          !! that had its output
      real(dp), intent(in) :: interval           !! [s]
      multiple = max(last + 1, int(s%problem%state%time/interval, long))
      do while (is_due(s, output_time(s, multiple, interval)) .and. s%problem%state%time < s%model%run%end_time)
         multiple = multiple + 1
      end do
   end function next_multiple

   !> Write a snapshot of particles and mesh, and of cracks or fronts.
   subroutine write_snapshot(s, after_failure, failure)
      type(simulation_t), intent(inout) :: s
      logical, intent(in) :: after_failure
      type(failure_t), intent(inout) :: failure
      type(piece_t), allocatable :: pieces(:)    ! an array of function results would leak in gfortran 12
      logical :: with_cracks
      with_cracks = shows_cracks(s%cracks)
      allocate (pieces(count([.true., .true., with_cracks, size(s%measurements%fronts) > 0])))
      call particle_fields(s%problem, with_cracks, pieces(1))
      call mesh_fields(s%problem, s%refinement, with_cracks, after_failure, pieces(2))
      if (with_cracks) call crack_fields(s%cracks, pieces(3))
      if (size(s%measurements%fronts) > 0) call front_fields(s%measurements%fronts, pieces(size(pieces)))
      call s%results%write_snapshot(s%problem%state%time, pieces, failure)
   end subroutine write_snapshot

   !> Record the end of the run: the last snapshot of a failed state, its distance to equilibrium, and attributes of the result.
   subroutine record_end(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      call show_progress(s, last=.true.)
      if (failure%code == exit_computation) call show_what_failed(s)
      if (.not. failure%failed()) then
         s%distance_to_equilibrium = s%integrator%distance_to_equilibrium
         if (.not. s%integrator%is_static) call find_distance_to_equilibrium(s%problem, s%distance_to_equilibrium)
         call check_rest(s%problem, s%measurements, s%warning)
      end if
      if (failure%code /= exit_stopped) call check_faces(s%measurements, s%cracks%crack, s%model%planes, &
                                                         is_near_equilibrium(s), s%warning)
      if (failure%code /= exit_stopped) call tell_taken(s%growing%taken, s%warning)
      call tell_end(s, failure)
   end subroutine record_end

   !> Write a last snapshot after a failed computation, with any numbers: it shows how it failed.
   subroutine show_what_failed(s)
      type(simulation_t), intent(inout) :: s
      type(failure_t) :: unwritten               ! not reported: the failed computation matters more
      logical :: halting(size(ieee_usual))
      call ieee_get_halting_mode(ieee_usual, halting)
      call ieee_set_halting_mode(ieee_usual, .false.)
      call write_snapshot(s, .true., unwritten)
      call ieee_set_halting_mode(ieee_usual, halting)
   end subroutine show_what_failed

   !> Write the end of the run and its warnings into the result, so that they go with the numbers. A run that continues later, or
   !> cannot write, has not ended.
   subroutine tell_end(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unwritten               ! not reported: the failed computation matters more
      call s%results%add_attribute('/', 'wall_time', s%interruption%elapsed(), unwritten)
      select case (failure%code)
      case (exit_done)
         call s%results%add_attribute('/history', 'ended', 'done', failure)
         call s%results%add_attribute('/history', 'warnings', warnings(s), failure)
         if (s%distance_to_equilibrium >= 0) &
            call s%results%add_attribute('/history', 'distance_to_equilibrium', s%distance_to_equilibrium, failure)
         if (allocated(s%stopped_when)) call s%results%add_attribute('/history', 'stopped_when', s%stopped_when, failure)
         if (s%model%as_used /= s%model%as_begun) & ! as in the result
            call s%results%add_attribute('/history', 'end_time', s%model%run%end_time, failure)
         call tell_motion(s, failure)
      case (exit_computation)
         call s%results%add_attribute('/history', 'ended', failure%message, unwritten)
         call s%results%add_attribute('/history', 'warnings', warnings(s), unwritten)
      end select
   end subroutine tell_end

   !> Write with the speed of each tip the times at which it began to grow in motion and, if it rests, at which it stopped.
   subroutine tell_motion(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: column
      integer :: k
      if (.not. s%growing%are_there()) return
      if (s%growing%separated >= 0) call s%results%add_attribute('/history', 'separated', s%growing%separated, failure)
      if (s%growing%fatigue%life >= 0) then
         call s%results%add_attribute('/history', 'life', s%growing%fatigue%life, failure)
         if (have_errors(s%measurements)) call s%results%add_attribute('/history', 'life_error', s%growing%fatigue%error, failure)
      end if
      do k = 1, size(s%growing%points)
         associate (point => s%growing%points(k))
            column = '/history/tip_speed'
            if (k > 1) column = column//'_tip'//to_text(k)
            if (k > size(s%cracks%tips)) then    ! points of a crack with fronts have the same times
               if (any(s%growing%points(:k - 1)%crack == point%crack)) cycle
               column = '/history/front_speed'
               if (point%crack > 1) column = column//'_crack'//to_text(point%crack)
            end if
            if (point%onset >= 0) call s%results%add_attribute(column, 'onset_time', point%onset, failure)
            if (point%onset_error >= 0 .and. have_errors(s%measurements)) &
               call s%results%add_attribute(column, 'onset_time_error', point%onset_error, failure)
            if (point%has_arrested(s%problem%state%time, s%dt)) &
               call s%results%add_attribute(column, 'arrest_time', point%last_motion, failure)
         end associate
      end do
   end subroutine tell_motion

   !> Tell the progress line where the run is; `last` ends it.
   subroutine show_progress(s, last)
      type(simulation_t), intent(inout) :: s
      logical, intent(in) :: last
      type(standing_t) :: now
      integer :: k
      associate (m => s%problem)
         now%time = m%state%time
         now%step = m%state%steps
         now%cells = m%grid%forest%leaf_count()
         now%particles = m%particles%n
         now%finest_level = m%grid%forest%finest_level()
         if (allocated(s%measurements%rate)) now%rate = s%measurements%rate
         now%reference = s%measurements%g_ref
         if (s%growing%are_there()) then
            now%crack_length = sum([(s%cracks%crack(k)%length(), k=1, size(s%cracks%crack))])
            if (.not. s%growing%is_static) now%tip_speed = maxval([0.0_dp, s%cracks%tips%speed])
         end if
         now%energy_residual = energy_residual(m, s%measurements)
      end associate
      call s%progress%show(now, last)
   end subroutine show_progress

   !> Path of the result of a model in a folder.
   pure function result_path(model, folder) result(path)
      type(model_t), intent(in) :: model
      character(*), intent(in) :: folder
      character(:), allocatable :: path
      path = folder//'/'//trim(model%output%file)
   end function result_path
end module hampm_recording
