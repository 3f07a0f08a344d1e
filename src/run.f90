!> A run: from the start of a model through its time steps to G(t).
!>
!> An explicit step follows Tan & Nairn (2001): particles give their masses, momenta and stresses to the nodes of the grid (7), (8),
!> nodes accelerate (10), and particles follow them; `hampm_reference_step` is this step in plain loops. Where the gradients of a
!> field require it (22), cells are divided, and their particles with them. G (14) is measured whenever it is recorded.
module hampm_run
   use hampm_kinds, only: dp, long
   use hampm_checkpoint, only: checkpoint_name
   use hampm_cohesive_zone, only: follow_zones
   use hampm_continuation, only: check_interruption
   use hampm_failure, only: failure_t
   use hampm_file_moves, only: partial_name, remove_file
   use hampm_growing, only: by_time
   use hampm_growth, only: start_growth, prepare_growth, follow_growth
   use hampm_growth_in_motion, only: advance_by_trials
   use hampm_run_time_checks, only: check_step
   use hampm_integrator, only: steps_for
   use hampm_measurements, only: note_initial_energy
   use hampm_mesh_changes, only: adapt, adapt_static, carry_cracks
   use hampm_problem, only: update_particles
   use hampm_recording, only: open_results, next_row, is_due, record, record_between_rows, record_end, show_progress
   use hampm_simulation, only: simulation_t, measure_state, follow_stiffening
   use hampm_static_start, only: begin_at_rest
   use hampm_stopping, only: check_stop
   implicit none
   private
   public :: run, measured_duration

contains

   !> Run to the end time and write the results into `folder`. After a failure the records up to then stay readable. A run that is
   !> asked to stop writes a checkpoint and fails with `exit_stopped`; a run at its end needs none.
   subroutine run(s, folder, quiet, failure)
      type(simulation_t), intent(inout) :: s
      character(*), intent(in) :: folder
      logical, intent(in) :: quiet
      type(failure_t), intent(inout) :: failure
      logical :: resumes
      resumes = allocated(s%lengths)
      call s%interruption%start(s%problem%state%steps)
      call open_results(s, folder, failure)
      if (.not. failure%failed()) then
         call s%progress%start(s%model%run%end_time, quiet)
         call show_progress(s, last=.false.)
         if (.not. resumes) call begin(s, failure)
         do while (s%problem%state%time < s%model%run%end_time .and. .not. (failure%failed() .or. allocated(s%stopped_when)))
            call advance_to_row(s, failure)
            if (s%is_over) exit
            call record(s, failure)
            if (.not. failure%failed()) call check_stop(s)
         end do
         call record_end(s, failure)
      end if
      call s%results%close(failure)
      if (.not. (s%is_pilot .or. failure%failed())) then
         call remove_file(checkpoint_name(s%results%path))
         call remove_file(partial_name(checkpoint_name(s%results%path)))
      end if
      call s%results%lock%release()
   end subroutine run

   !> Estimated duration of a run on this machine [s], from a few of its first steps; below 0 where they fail, or are steps to
   !> equilibrium of too many particles. The simulation cannot be used after that. Growth of cracks in motion and meshes that change
   !> take longer.
   function measured_duration(s, samples, clock_start) result(duration)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: samples            !! of the history
      integer(long), intent(in) :: clock_start   !! ticks when the program has started
      real(dp) :: duration
      real(dp), parameter :: patience = 0.005_dp, most = 0.05_dp ! for steps after the first, and with it [s]
      integer, parameter :: most_steps = 1000, most_at_rest = 100000
      type(failure_t) :: failure
      integer, parameter :: grown = 12, turned = 16 ! equilibria of a load step with quasi-static growth; with turning cracks
      real(dp) :: start, first, last, sample, before
      integer(long) :: steps
      integer :: done, again
      duration = -1
      if (s%integrator%is_static .and. s%problem%particles%n > most_at_rest) return
      call s%integrator%choose_steps(s%model%run%end_time, s%longest_step, steps, s%dt)
      start = seconds()
      before = start - seconds(clock_start)      ! time of reading and building [s]
      call s%integrator%initialise(s%problem, s%dt, failure)
      if (.not. failure%failed()) call s%integrator%advance(s%problem, s%dt, failure)
      first = seconds() - start                  ! with the first setup
      start = seconds()
      last = 0
      do done = 1, int(min(int(most_steps, long), steps - 1))
         if (failure%failed() .or. last > patience .or. first + last > most) exit
         call s%integrator%advance(s%problem, s%dt, failure)
         last = seconds() - start
      end do
      call update_particles(s%problem)
      sample = huge(sample)
      do again = 1, 3                            ! the first one makes room, and any may be interrupted
         start = seconds()
         call measure_state(s, failure)
         sample = min(sample, seconds() - start)
         if (sample > patience) exit
      end do
      if (failure%failed()) return
      duration = first + samples*sample
      if (done > 1) duration = duration + (steps - 1)*last/(done - 1)
      if (done == 1) duration = duration + (steps - 1)*first
      if (s%growing%is_static) & ! each on another mesh
         duration = first + steps*(first + sample)*merge(turned, grown, any(s%model%growth%direction == 'local_symmetry'))
      duration = duration + before

   contains

      !> Monotonic time, now or at some ticks [s].
      real(dp) function seconds(ticks)
         integer(long), intent(in), optional :: ticks
         integer(long) :: count, rate
         call system_clock(count, rate)
         if (present(ticks)) count = ticks
         seconds = real(count, dp)/rate
      end function seconds
   end function measured_duration

   !> Find the equilibrium, or the motion of the nodes, with which a run begins, and record the start.
   subroutine begin(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      real(dp) :: time
      time = s%model%run%end_time
      if (s%integrator%ends_at_rows) time = min(s%model%output%history_interval, time)
      call begin_at_rest(s, failure)
      if (.not. failure%failed()) &
         call s%integrator%initialise(s%problem, time/steps_for(time, s%longest_step), failure)
      if (failure%failed()) return
      call s%integrator%describe(s%problem, s%results, failure)
      call note_initial_energy(s%problem, s%measurements)
      call adapt_static(s, failure)
      call start_growth(s, failure)
      call record(s, failure)
   end subroutine begin

   !> Advance to the next row of the history by steps that are equal as long as the mesh stays, none longer than (31).
   subroutine advance_to_row(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      integer(long) :: before
      do while (.not. is_due(s, next_row(s)))
         if (s%steps_left == 0) call choose_steps(s, failure)
         call check_interruption(s, failure)
         before = s%problem%state%steps
         call prepare_growth(s, failure)
         if (failure%failed() .or. s%is_over) return
         if (s%growing%is_implicit) then
            call advance_by_trials(s, failure)
         else
            call s%integrator%advance(s%problem, s%dt, failure)
         end if
         if (.not. s%integrator%ends_at_rows) call round_time(s)
         if (size(s%model%cohesive) > 0 .and. .not. failure%failed()) call follow_zones(s%cracks, s%problem)
         call adapt_static(s, failure)
         call follow_growth(s, failure)
         call carry_cracks(s, failure)
         call adapt(s, before, failure)
         call follow_stiffening(s)
         if (failure%failed()) return
         call show_progress(s, last=.false.)
         s%steps_left = s%steps_left - 1
         if (abs(s%longest_step - s%limit) > 0) s%steps_left = 0
         if (s%growing%driver == by_time) exit      ! a row at the end of each increment
         if (.not. is_due(s, next_row(s))) call record_between_rows(s, failure)
      end do
      call update_particles(s%problem)
      if (.not. (s%integrator%ends_at_rows .and. is_due(s, next_row(s)))) return
      s%steps_left = 0
      s%problem%state%time = next_row(s)
   end subroutine advance_to_row

   !> Choose number and length of the steps to the next row, or to the end of the run.
   subroutine choose_steps(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      real(dp) :: time                           ! [s]
      call check_step(s%problem, s%longest_step, failure)
      if (failure%failed()) return
      s%limit = s%longest_step
      time = s%model%run%end_time
      if (s%integrator%ends_at_rows) time = next_row(s)
      call s%integrator%choose_steps(time - s%problem%state%time, s%limit, s%steps_left, s%dt)
   end subroutine choose_steps

   !> The time after a step of a given length is a multiple of that, or the end of the run, where only rounding is between them.
   subroutine round_time(s)
      type(simulation_t), intent(inout) :: s
      real(dp), parameter :: rounding = 1e-6_dp  ! of a step
      associate (time => s%problem%state%time, end_time => s%model%run%end_time)
         if (abs(time - anint(time/s%dt)*s%dt) <= rounding*s%dt) time = anint(time/s%dt)*s%dt
         if (abs(time - end_time) <= rounding*s%dt) time = end_time
      end associate
   end subroutine round_time
end module hampm_run
