!> A run from its scene to its results: build, advance, record.
module hampm_simulation
   use, intrinsic :: ieee_exceptions, only: ieee_usual, ieee_get_halting_mode, ieee_set_halting_mode
   use, intrinsic :: iso_fortran_env, only: compiler_version, compiler_options
   use hampm_kinds, only: dp, long
   use hampm_assembly, only: assemble, choose_integrator
   use hampm_bodies, only: add_spin
   use hampm_caveats, only: warnings_of
   use hampm_cell_blocks, only: smallest_occupied_cell
   use hampm_checkpoint, only: checkpoint_t, checkpoint_name
   use hampm_crack_groups, only: path_spec_t
   use hampm_cohesive_zone, only: follow_zones, look_at_zones
   use hampm_crack_carrying, only: carried_cracks_t, attach_cracks, follow_cracks
   use hampm_crack_measurements, only: crack_values_t, estimate_errors
   use hampm_cracks, only: cracks_t, keep_cracks
   use hampm_cut_cells, only: line_t
   use hampm_failure, only: failure_t, exit_done, exit_computation, exit_stopped
   use hampm_file_moves, only: partial_name, remove_file
   use hampm_folders, only: ensure_folder
   use hampm_growing, only: growing_t, new_growing, keep_growing
   use hampm_growth_at_rest, only: advance_tips, begin_to_turn, mixities_of, turn_tips, take_back, book_fracture, &
                                    factor_to_toughness, note_drive, freed, correct_work, scale_loads
   use hampm_growth_in_motion, only: plan_ways, move_tips, has_to_look, start_tips, note_look, book_rate
   use hampm_growth_pace, only: pace_t, begin_pace, follow_pace
   use hampm_growth_room, only: follow_in_scene
   use hampm_guards, only: check_state, check_step, check_tip, look_at_faces, look_at_modes, look_at_normals
   use hampm_interruption, only: interruption_t
   use hampm_integrator, only: integrator_t, steps_for
   use hampm_matching, only: adopt_lines
   use hampm_measurements, only: measurements_t, new_measurements, note_initial_energy, rebuild_extrapolation, &
                                 measure, take_row, declare_columns, energy_residual, keep_measurements
   use hampm_motion, only: motion_t, stored_energy, update_particles
   use hampm_pressed_faces, only: press_faces
   use hampm_progress, only: progress_t, standing_t
   use hampm_refinement, only: refinement_t, refine_at_start, refine, follow_particles, keep_refinement
   use hampm_rest, only: find_distance_from_rest
   use hampm_results, only: results_t
   use hampm_scene, only: scene_t
   use hampm_snapshots, only: piece_t
   use hampm_state, only: keep_motion
   use hampm_symmetric_turns, only: symmetric_turns_t
   use hampm_text, only: add_line
   use hampm_threads, only: use_threads, thread_count, host_name
   use hampm_critical_step, only: stable_time_step
   use hampm_version, only: version
   use hampm_views, only: shows_cracks, particle_view, mesh_view, crack_view
   use hampm_whereabouts, only: when
   implicit none
   private
   public :: simulation_t, build, rebuild, run, warnings, result_path, is_at_rest

   real(dp), parameter :: near_rest = 0.01_dp    !! distance from rest up to which values are taken for those at rest [-]
   real(dp), parameter :: rounding = 1.0e-6_dp   !! part of a step by which a time or a step may be off

   !> All that a run consists of.
   type :: simulation_t
      type(scene_t) :: scene
      type(motion_t) :: motion
      type(cracks_t) :: cracks
      type(measurements_t) :: measurements
      type(results_t) :: results
      type(refinement_t) :: refinement
      type(carried_cracks_t) :: carried
      type(growing_t) :: growing
      class(integrator_t), allocatable :: integrator
      type(progress_t) :: progress
      type(interruption_t) :: interruption
      real(dp) :: distance_from_rest = -1        !! of the last values, see `find_distance_from_rest`; below 0: not known [-]
      real(dp) :: longest_step = 0               !! time step (31) [s]
      real(dp) :: limit = 0                      !! the same when the steps to the next output were chosen [s]
      integer(long) :: steps_left = 0            !! how many of these are not yet done
      real(dp) :: dt = 0                         !! last time step: not longer, and such that outputs fall on their times [s]
      integer(long) :: samples = 0               !! rows of the history so far
      integer(long) :: snapshots = 0             !! snapshots so far
      integer(long), allocatable :: lengths(:)   !! of the result that is continued; not allocated where a new one begins
      character(:), allocatable :: warning       !! of the scene and of the guards, a line each; not allocated where
                                                 !! there is none
   end type simulation_t

contains

   !> Build the simulation of a scene on a number of threads; 0 lets the size of the scene decide.
   subroutine build(scene, threads, s, failure)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: threads
      type(simulation_t), intent(out) :: s
      type(failure_t), intent(inout) :: failure
      integer :: k
      s%scene = scene
      s%warning = warnings_of(scene)
      if (s%warning == '') deallocate (s%warning)
      call assemble(scene, s%motion, s%cracks, s%refinement, failure)
      call choose_integrator(scene, s%integrator)
      if (failure%failed()) return
      call attach_cracks(s%carried, s%motion, scene%energy_release%is_by_nodes())
      call refine_at_start(s%refinement, s%motion, s%cracks%tip_places(), failure)
      if (failure%failed()) return
      do k = 1, size(scene%bodies)               ! with the particles as they now are: rigid motions to the last digit
         if (abs(scene%bodies(k)%spin) > 0) call add_spin(s%motion%particles, k, scene%bodies(k)%spin)
      end do
      call use_threads(threads, s%motion%particles%n)
      call rebuild_on_mesh(s, failure)
      if (failure%failed()) return
      call new_measurements(scene, s%motion, s%cracks, s%measurements)
      call new_growing(scene, s%cracks, s%growing)
      call estimate_errors(scene, s%motion, s%cracks, s%measurements%extrapolation, s%measurements%crack, failure)
   end subroutine build

   !> Build the simulation of a scene as it was when a checkpoint of it was written.
   subroutine rebuild(scene, threads, checkpoint, s, failure)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: threads
      type(checkpoint_t), intent(inout) :: checkpoint  !! open; it is closed
      type(simulation_t), intent(out) :: s
      type(failure_t), intent(inout) :: failure
      s%scene = scene
      call assemble(scene, s%motion, s%cracks, s%refinement, failure)
      call choose_integrator(scene, s%integrator)
      if (.not. failure%failed()) then
         call attach_cracks(s%carried, s%motion, scene%energy_release%is_by_nodes())
         call new_measurements(scene, s%motion, s%cracks, s%measurements)  ! of the start, as G_ref is
         call new_growing(scene, s%cracks, s%growing)
         call keep_cracks(s%cracks, checkpoint)
         call keep_growing(s%growing, checkpoint)
         call follow_all_in_scene(s)
         call keep_motion(checkpoint, s%cracks, s%motion)
      end if
      if (.not. (failure%failed() .or. checkpoint%failure%failed())) then
         call use_threads(threads, s%motion%particles%n)
         call rebuild_on_mesh(s, failure)
         call keep_rest(checkpoint, s)
      end if
      call checkpoint%finish(failure)
   end subroutine rebuild

   !> Keep in a checkpoint, or get from it, what there is beside the motion.
   subroutine keep_rest(checkpoint, s)
      type(checkpoint_t), intent(inout) :: checkpoint
      type(simulation_t), intent(inout) :: s
      character(:), allocatable :: warning
      integer :: n
      call keep_refinement(s%refinement, checkpoint)
      call keep_measurements(s%motion%grid, s%measurements, checkpoint)
      call checkpoint%section('run')
      call checkpoint%keep('longest_step', s%longest_step)
      call checkpoint%keep('limit', s%limit)
      call checkpoint%keep('steps_left', s%steps_left)
      call checkpoint%keep('dt', s%dt)
      call s%integrator%keep(s%motion, checkpoint)
      call checkpoint%keep('samples', s%samples)
      call checkpoint%keep('snapshots', s%snapshots)
      n = 0
      if (.not. checkpoint%is_read) n = size(s%lengths)
      call checkpoint%keep('number_lengths', n)
      if (checkpoint%is_read) allocate (s%lengths(n))
      call checkpoint%keep_longs('lengths', n, s%lengths)
      warning = ''
      if (allocated(s%warning)) warning = s%warning
      call checkpoint%keep_text('warning', warning)
      if (len(warning) > 0) s%warning = warning
   end subroutine keep_rest

   !> Bring the result up to date, for the last time or not, and then write a checkpoint that continues it.
   subroutine write_checkpoint(s, is_last, failure)
      type(simulation_t), intent(inout) :: s
      logical, intent(in) :: is_last
      type(failure_t), intent(inout) :: failure
      type(checkpoint_t) :: checkpoint
      if (is_last) then
         call s%results%close(failure)
      else
         call s%results%flush(failure)
      end if
      if (failure%failed()) return
      s%lengths = s%results%lengths()
      call checkpoint%create(checkpoint_name(s%results%path))
      call checkpoint%keep_text('scene', s%scene%as_used)
      call keep_cracks(s%cracks, checkpoint)
      call keep_growing(s%growing, checkpoint)
      call keep_motion(checkpoint, s%cracks, s%motion)
      call keep_rest(checkpoint, s)
      call checkpoint%finish(failure)
      call s%interruption%note_checkpoint(s%motion%steps)
   end subroutine write_checkpoint

   !> Before a step: write a checkpoint where it is time, and stop where that is asked for.
   subroutine look_for_interruption(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: reason
      logical :: is_time
      reason = s%interruption%reason_to_stop(s%motion%steps)
      is_time = s%interruption%wants_checkpoint(s%motion%steps)
      if (reason /= '' .or. is_time) call write_checkpoint(s, reason /= '', failure)
      if (reason /= '' .and. .not. failure%failed()) call failure%report(exit_stopped, when(s%motion%steps, s%motion%time)// &
         'stopped by '//reason//'. To go on: hampm --resume '//checkpoint_name(s%results%path))
   end subroutine look_for_interruption

   !> Make time step, nodes around crack tips, pressures on their faces and extrapolations fit a new mesh.
   subroutine rebuild_on_mesh(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      call limit_time_step(s)
      call s%cracks%find_nodes(s%motion%grid, failure)
      call press_faces(s%motion)
      if (.not. failure%failed()) call rebuild_extrapolation(s%motion, s%measurements, failure)
   end subroutine rebuild_on_mesh

   !> The longest time step follows the smallest occupied cell.
   subroutine limit_time_step(s)
      type(simulation_t), intent(inout) :: s
      s%longest_step = stable_time_step(smallest_occupied_cell(s%motion%grid, s%motion%blocks), s%motion%materials, &
                                        s%scene%method%courant, s%scene%method%wave_speed)
      if (s%integrator%fixed_step > 0) s%longest_step = s%integrator%fixed_step
   end subroutine limit_time_step

   !> Run to the end time and write the results into `folder`. Whatever fails, what was recorded before stays readable. A run that
   !> is asked to stop writes a checkpoint and fails with `exit_stopped`; one that has come to its end needs none.
   subroutine run(s, folder, quiet, failure)
      type(simulation_t), intent(inout) :: s
      character(*), intent(in) :: folder
      logical, intent(in) :: quiet
      type(failure_t), intent(inout) :: failure
      logical :: resumes
      resumes = allocated(s%lengths)
      call s%interruption%start(s%motion%steps)
      call open_results(s, folder, failure)
      if (.not. failure%failed()) call run_to_end(s, quiet, resumes, failure)
      call s%results%close(failure)
      call s%integrator%finish()
      if (.not. failure%failed()) then
         call remove_file(checkpoint_name(s%results%path))
         call remove_file(partial_name(checkpoint_name(s%results%path)))
      end if
      call s%results%release()
   end subroutine run

   !> Advance to the end time, from the start or from where a checkpoint was written, and tell how that has ended.
   subroutine run_to_end(s, quiet, resumes, failure)
      type(simulation_t), intent(inout) :: s
      logical, intent(in) :: quiet, resumes
      type(failure_t), intent(inout) :: failure
      call s%progress%start(s%scene%run%end_time, quiet)
      call show_progress(s, last=.false.)
      if (.not. resumes) call settle_at_start(s, failure)
      if (.not. (resumes .or. failure%failed()) .and. s%growing%at_rest) then
         call measure(s%scene, s%motion, s%cracks, s%measurements, failure)
         call load_to_toughness(s, failure)
      end if
      if (.not. (resumes .or. failure%failed())) call record(s, failure)
      do while (s%motion%time < s%scene%run%end_time .and. .not. failure%failed())
         call advance_to(s, next_output(s), failure)
         if (.not. failure%failed()) call record(s, failure)
      end do
      call show_progress(s, last=.true.)
      if (failure%code == exit_computation) call show_what_failed(s)
      if (.not. failure%failed()) then
         s%distance_from_rest = s%integrator%distance_from_rest
         if (.not. s%integrator%is_static) call find_distance_from_rest(s%motion, s%distance_from_rest)
      end if
      if (failure%code /= exit_stopped) call look_at_faces(s%measurements, s%cracks%crack, is_at_rest(s), s%warning)
      call tell_end(s, failure)
   end subroutine run_to_end

   !> Time of the next sample, snapshot or of the end [s].
   pure real(dp) function next_output(s) result(time)
      type(simulation_t), intent(in) :: s
      time = min(output_time(s, s%samples, s%scene%output%history_interval), s%scene%run%end_time)
      if (s%scene%output%snapshot_interval > 0) time = min(time, output_time(s, s%snapshots, s%scene%output%snapshot_interval))
   end function next_output

   !> Time of an output at a multiple of its interval [s]: the end of the run where only rounding is between them.
   pure real(dp) function output_time(s, multiple, interval) result(time)
      type(simulation_t), intent(in) :: s
      integer(long), intent(in) :: multiple
      real(dp), intent(in) :: interval           !! [s]
      time = multiple*interval
      if (abs(time - s%scene%run%end_time) <= same_time(s)) time = s%scene%run%end_time
   end function output_time

   !> Times that differ by no more are the same [s]: by a small part of a step and of the intervals between outputs, which may be shorter than
   !> a step could be, or by rounding.
   pure real(dp) function same_time(s)
      type(simulation_t), intent(in) :: s
      associate (output => s%scene%output)
         same_time = min(s%longest_step, output%history_interval)
         if (output%snapshot_interval > 0) same_time = min(same_time, output%snapshot_interval)
      end associate
      same_time = max(rounding*same_time, 4*spacing(s%scene%run%end_time))
   end function same_time

   !> Advance to a time by steps that are equal as long as the mesh stays, none longer than (31).
   subroutine advance_to(s, time, failure)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: time               !! [s]
      type(failure_t), intent(inout) :: failure
      integer(long) :: before
      do while (s%steps_left > 0 .or. .not. is_due(s, time))
         if (s%steps_left == 0) call choose_steps(s, time, failure)
         if (.not. failure%failed()) call look_for_interruption(s, failure)
         if (failure%failed()) return
         before = s%motion%steps
         if (s%growing%are_there()) call prepare_growth(s, failure)
         if (failure%failed()) return
         if (s%growing%is_paced) then
            call advance_in_pace(s, failure)
         else
            call s%integrator%advance(s%motion, s%dt, failure)
         end if
         if (size(s%scene%cohesive) > 0 .and. .not. failure%failed()) call follow_zones(s%cracks, s%motion)
         if (s%growing%at_rest) call note_drive(s%growing, s%motion)
         if (s%integrator%is_static .and. s%refinement%is_active() .and. .not. failure%failed()) call adapt_at_rest(s, failure)
         if (.not. failure%failed() .and. s%growing%are_there()) call follow_growth(s, failure)
         if (.not. failure%failed() .and. s%carried%are_there()) call carry_cracks(s, failure)
         if (.not. (failure%failed() .or. s%integrator%is_static) .and. (s%refinement%is_active() .or. s%motion%has_domains())) &
            call adapt(s, before, failure)
         if (failure%failed()) return
         call show_progress(s, last=.false.)
         s%steps_left = s%steps_left - 1
         if (abs(s%longest_step - s%limit) > 0) s%steps_left = 0
      end do
      call update_particles(s%motion)
      s%motion%time = time
   end subroutine advance_to

   !> Choose number and length of the steps to a time.
   subroutine choose_steps(s, time, failure)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: time               !! [s]
      type(failure_t), intent(inout) :: failure
      call check_step(s%motion, s%longest_step, failure)
      if (failure%failed()) return
      s%limit = s%longest_step
      call s%integrator%choose_steps(s%motion, time - s%motion%time, s%limit, s%steps_left, s%dt)
   end subroutine choose_steps

   !> Before a step: let tips grow at rest, or plan their ways in motion.
   subroutine prepare_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (s%growing%at_rest) then
         call grow(s, failure)
         s%growing%stored_grown = stored_energy(s%motion)
         return
      end if
      if (has_to_look(s%growing, s%scene, s%motion, s%cracks)) then
         call look_at_tips(s, failure)
         if (failure%failed()) return
      end if
      if (.not. s%growing%is_paced) call plan_growth(s, failure)
   end subroutine prepare_growth

   !> Plan the ways of tips, and cut cells along them.
   subroutine plan_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: have_planned
      call plan_ways(s%growing, s%scene, s%motion, s%cracks, s%dt, have_planned, s%warning)
      if (have_planned) then
         call update_particles(s%motion)
         call change_cut(s, failure)
         if (.not. failure%failed()) call s%integrator%settle(s%motion, s%dt, failure)
      end if
   end subroutine plan_growth

   !> Advance by an implicit step with tips that grow: tried with other ways until G keeps to the toughness (`hampm_growth_pace`).
   subroutine advance_in_pace(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(growing_t) :: growing
      type(cracks_t) :: cracks
      type(measurements_t) :: measurements
      type(pace_t) :: pace
      character(:), allocatable :: warning
      logical :: is_over
      call begin_pace(s%growing, s%dt, pace)
      call update_particles(s%motion)
      do
         call plan_growth(s, failure)
         if (failure%failed()) return
         call s%integrator%note_start(s%motion)
         if (allocated(s%warning)) warning = s%warning
         measurements = s%measurements
         cracks = s%cracks
         growing = s%growing
         call move_tips(s%growing, s%scene, s%motion, s%cracks, s%motion%time, s%dt, s%warning)
         call s%integrator%advance(s%motion, s%dt, failure)
         if (.not. failure%failed()) call look_at_tips(s, failure)
         if (failure%failed()) return
         call follow_pace(pace, s%growing, s%cracks, s%dt, is_over)
         if (is_over) exit
         growing%way = s%growing%way
         growing%fall = s%growing%fall
         growing%is_running = s%growing%is_running
         growing%memory = s%growing%memory
         s%growing = growing
         s%cracks = cracks
         s%measurements = measurements
         if (allocated(s%warning)) deallocate (s%warning)
         if (allocated(warning)) s%warning = warning
         call s%integrator%go_to_start(s%motion)
      end do
   end subroutine advance_in_pace

   !> In motion: measure G and K, and let tips start whose loading has reached the toughness.
   subroutine look_at_tips(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      call update_particles(s%motion)
      call measure(s%scene, s%motion, s%cracks, s%measurements, failure)
      if (failure%failed()) return
      call note_look(s%growing, s%cracks, s%measurements%crack)
      call start_tips(s%growing, s%scene, s%motion, s%cracks, s%measurements%crack)
   end subroutine look_at_tips

   !> After a step: scale loads to the toughness at rest, or let tips move.
   subroutine follow_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(symmetric_turns_t) :: turns
      if (s%growing%at_rest) then
         call measure(s%scene, s%motion, s%cracks, s%measurements, failure)
         call turn_to_symmetry(s, turns, failure) ! loads that do not all change alike, and finer cells, have changed K_II
         call load_to_toughness(s, failure)
      else if (.not. s%growing%is_paced) then
         call move_tips(s%growing, s%scene, s%motion, s%cracks, s%motion%time - s%dt, s%dt, s%warning)
      end if
   end subroutine follow_growth

   !> Before a load step: let tips advance, and find equilibrium with them where they are.
   subroutine grow(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(cracks_t) :: before
      type(crack_values_t), allocatable :: values(:)
      type(symmetric_turns_t) :: turns
      integer, allocatable :: attempts(:)
      logical :: have_moved, have_cut, is_over
      call measure(s%scene, s%motion, s%cracks, s%measurements, failure)
      if (failure%failed()) return
      before = s%cracks
      values = s%measurements%crack
      allocate (attempts(size(values)), source=0)
      have_cut = .false.
      do
         call advance_tips(s%growing, s%scene, s%cracks, values, attempts, have_moved, s%warning)
         if (have_moved .or. have_cut) call cut_anew(s, failure)
         if (.not. have_moved .or. failure%failed()) return
         have_cut = .true.
         call measure(s%scene, s%motion, s%cracks, s%measurements, failure)
         call turn_to_symmetry(s, turns, failure)
         if (failure%failed() .or. turns%have_found()) return
         call take_back(s%growing, s%scene, s%cracks, before, turns, attempts, is_over, s%warning)
         if (is_over) return
      end do
   end subroutine grow

   !> By local symmetry: turn the last increments of the tips until these have no K_II, from what was measured last, and measure.
   subroutine turn_to_symmetry(s, turns, failure)
      type(simulation_t), intent(inout) :: s
      type(symmetric_turns_t), intent(out) :: turns
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: turn(:)
      integer :: is_in_the_way
      logical :: are_over
      call begin_to_turn(s%growing, s%scene, s%cracks, turns)
      allocate (turn(size(turns%tip)))
      are_over = .false.
      do
         if (failure%failed()) return
         if (.not. are_over) call turns%note(mixities_of(s%measurements%crack, turns%tip))
         if (turns%have_found() .or. are_over) return
         call turns%choose(turn, are_over)
         call turn_tips(s%scene, s%cracks, turns%tip, turn, is_in_the_way)
         call cut_anew(s, failure)
         if (.not. failure%failed()) call measure(s%scene, s%motion, s%cracks, s%measurements, failure)
      end do
   end subroutine turn_to_symmetry

   !> Cut cells along cracks that have changed, let the mesh follow their tips, and find equilibrium.
   subroutine cut_anew(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      call change_cut(s, failure)
      if (.not. failure%failed()) call s%integrator%settle(s%motion, s%longest_step, failure)
   end subroutine cut_anew

   !> Cut cells along cracks that have changed, and let the mesh follow their tips.
   subroutine change_cut(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(line_t), allocatable :: lines(:)
      logical :: adapted
      allocate (lines, source=s%cracks%lines())
      call adopt_lines(s%motion, lines, failure)
      adapted = s%refinement%indicator == 'tip'
      do while (adapted .and. .not. failure%failed())
         call refine(s%refinement, s%motion, s%cracks%tip_places(), adapted, failure)
      end do
      if (.not. failure%failed()) call rebuild_on_mesh(s, failure)
   end subroutine change_cut

   !> After a load step, or at the start, when all is measured: scale the loads until the largest G is the toughness: as if the root of G were
   !> proportional to them, which it is in a linear body that they alone drive, then by the secant through what the last two factors gave.
   subroutine load_to_toughness(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: near = 1e-6_dp      ! of the factor
      integer, parameter :: most = 30
      real(dp) :: factor, before, by_advance, change, root, last_root, last_factor
      integer :: attempt
      if (failure%failed()) return
      before = s%growing%load_factor
      last_root = 0
      last_factor = 1
      by_advance = freed(s%growing, s%motion)
      change = 1
      do attempt = 1, most
         factor = factor_to_toughness(s%growing, s%scene, s%cracks, s%measurements%crack)
         if (attempt > 1 .and. abs(factor - 1) < near) exit
         root = 1/factor
         if (attempt > 1) factor = by_secant(last_factor, last_root, root)
         last_root = root
         last_factor = factor
         call correct_work(s%growing, factor*s%growing%load_factor/before, by_advance, change, s%motion)
         call s%integrator%rescale(s%motion, factor, failure)
         if (failure%failed()) return
         s%growing%load_factor = factor*s%growing%load_factor
         call scale_loads(s%growing, s%motion)
         call measure(s%scene, s%motion, s%cracks, s%measurements, failure)
         if (failure%failed()) return
      end do
      if (attempt > most) then
         call failure%report(exit_computation, when(s%motion%steps, s%motion%time)//'no factor of the loads was found that '// &
                             'brings G to the toughness: it hardly hangs on them, as where an eigenstrain drives the crack')
         return
      end if
      call book_fracture(s%growing, s%scene, s%cracks, s%measurements%crack, s%motion)
   end subroutine load_to_toughness

   !> By what to multiply a load so that the root of G over the toughness, a function of the load, is 1, by the secant through its last two values: by
   !> no more than `farthest` and no less than its inverse, and never less of a load that does not suffice, where it closes a tip.
   pure real(dp) function by_secant(last_factor, last_root, root) result(factor)
      real(dp), intent(in) :: last_factor        !! by which the load was multiplied last
      real(dp), intent(in) :: last_root          !! before that
      real(dp), intent(in) :: root               !! after it
      real(dp), parameter :: farthest = 3
      real(dp) :: rise, change
      factor = 1/root
      rise = root - last_root
      if (abs(rise) < epsilon(rise)) return
      change = (1 - root)*(1 - 1/last_factor)/rise         ! of the load, in parts of it
      if (root > 1 .or. change > 0) factor = max(1/farthest, min(farthest, 1 + change))
   end function by_secant

   !> After a checkpoint was read: the scene has its cracks where they are, and loads their scale.
   subroutine follow_all_in_scene(s)
      type(simulation_t), intent(inout) :: s
      integer :: k
      if (.not. s%growing%are_there()) return
      do k = 1, size(s%cracks%crack)
         call follow_in_scene(s%scene, s%cracks, k)
      end do
      if (s%growing%at_rest) call scale_loads(s%growing, s%motion)
   end subroutine follow_all_in_scene

   !> After a step: let cracks that the material carries follow it.
   subroutine carry_cracks(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: moved
      call follow_cracks(s%carried, s%motion, moved, failure)
      if (moved .and. .not. failure%failed()) call rebuild_on_mesh(s, failure)
   end subroutine carry_cracks

   !> After a step: let particles and, at its interval, mesh follow the motion.
   subroutine adapt(s, steps_before, failure)
      type(simulation_t), intent(inout) :: s
      integer(long), intent(in) :: steps_before  !! how many steps had been done before it
      type(failure_t), intent(inout) :: failure
      logical :: adapted
      if (s%motion%sorted) then
         call follow_particles(s%motion, failure)
         if (failure%failed()) return
         call limit_time_step(s)
      end if
      if (.not. s%refinement%is_due(s%motion%time, steps_before, s%motion%steps)) return
      call update_particles(s%motion)
      if (s%growing%are_there()) s%motion%grid%cut_cells%lines = s%cracks%lines() ! with the tips where they are now
      call refine(s%refinement, s%motion, s%cracks%tip_places(), adapted, failure)
      if (adapted .and. .not. failure%failed()) call rebuild_on_mesh(s, failure)
      if (adapted .and. .not. failure%failed()) call s%integrator%settle(s%motion, s%dt, failure)
   end subroutine adapt

   !> Find the equilibrium, or the motion of the nodes, with which a run begins that is not one of explicit steps.
   subroutine settle_at_start(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      real(dp) :: time
      associate (output => s%scene%output)       ! to the first output, which may shorten the steps
         time = min(output%history_interval, s%scene%run%end_time)
         if (output%snapshot_interval > 0) time = min(time, output%snapshot_interval)
      end associate
      call s%integrator%settle(s%motion, time/steps_for(time, s%longest_step), failure)
      if (failure%failed()) return
      call note_initial_energy(s%motion, s%measurements)
      if (s%integrator%is_static .and. s%refinement%is_active()) call adapt_at_rest(s, failure)
   end subroutine settle_at_start

   !> At rest: refine the mesh and find equilibrium on it until the indicator asks for no more.
   subroutine adapt_at_rest(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: adapted
      do while (s%refinement%follows_motion())
         call refine(s%refinement, s%motion, s%cracks%tip_places(), adapted, failure)
         if (failure%failed() .or. .not. adapted) return
         call rebuild_on_mesh(s, failure)
         if (.not. failure%failed()) call s%integrator%settle(s%motion, s%longest_step, failure)
         if (failure%failed()) return
      end do
   end subroutine adapt_at_rest

   !> Whether the time of an output has come.
   pure logical function is_due(s, time)
      type(simulation_t), intent(in) :: s
      real(dp), intent(in) :: time               !! of the output [s]
      is_due = s%motion%time >= time - same_time(s)
   end function is_due

   !> Take the samples and snapshots that are due, and look whether all is well.
   subroutine record(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      integer :: k
      s%measurements%indicator = max(s%refinement%relative_error, s%refinement%largest_r)
      call measure(s%scene, s%motion, s%cracks, s%measurements, failure)
      if (failure%failed()) return
      if (s%growing%are_there() .and. .not. s%growing%at_rest) &
         call book_rate(s%growing, s%scene, s%cracks, s%measurements%crack)
      call check_state(s%motion, trim(s%scene%method%time), s%measurements, s%warning, failure)
      if (.not. failure%failed()) call look_at_normals(s%motion, failure)
      if (size(s%cracks%tips) > 0 .and. .not. failure%failed()) call check_tip(s%motion, s%cracks%tips(1), failure)
      if (failure%failed()) return
      do k = 1, size(s%cracks%tips)
         call look_at_modes(s%motion, s%cracks%tips(k), s%warning)
      end do
      if (s%motion%interfaces%n_cohesive > 0) call look_at_zones(s%cracks, s%motion%interfaces, s%warning)
      if (is_due(s, min(output_time(s, s%samples, s%scene%output%history_interval), s%scene%run%end_time))) then
         call take_row(s%scene, s%motion, s%cracks, s%growing, s%dt, s%measurements)
         call s%results%append(s%measurements%history%row, failure)
         s%samples = s%samples + 1
      end if
      if (s%scene%output%snapshot_interval > 0) then
         if (is_due(s, output_time(s, s%snapshots, s%scene%output%snapshot_interval))) then
            call write_snapshot(s, .false., failure)
            s%snapshots = s%snapshots + 1
         end if
      end if
   end subroutine record

   !> Write a snapshot of particles and mesh, and of cracks.
   subroutine write_snapshot(s, after_failure, failure)
      type(simulation_t), intent(inout) :: s
      logical, intent(in) :: after_failure
      type(failure_t), intent(inout) :: failure
      type(piece_t), allocatable :: pieces(:)    ! an array of what functions return would leak in gfortran 12
      logical :: with_cracks
      with_cracks = shows_cracks(s%cracks)
      allocate (pieces(merge(3, 2, with_cracks)))
      call particle_view(s%motion, with_cracks, pieces(1))
      call mesh_view(s%motion, s%refinement, with_cracks, after_failure, pieces(2))
      if (with_cracks) call crack_view(s%cracks, pieces(3))
      call s%results%write_snapshot(s%motion%time, pieces, failure)
   end subroutine write_snapshot

   !> Write a last snapshot after a computation has gone wrong, whatever numbers it holds: how it went wrong can be seen there.
   subroutine show_what_failed(s)
      type(simulation_t), intent(inout) :: s
      type(failure_t) :: unwritten               ! nobody is told: that the computation has failed matters more
      logical :: halting(size(ieee_usual))
      call ieee_get_halting_mode(ieee_usual, halting)
      call ieee_set_halting_mode(ieee_usual, .false.)
      call write_snapshot(s, .true., unwritten)
      call ieee_set_halting_mode(ieee_usual, halting)
   end subroutine show_what_failed

   !> Whether the run has come to rest.
   pure logical function is_at_rest(s)
      type(simulation_t), intent(in) :: s
      is_at_rest = s%distance_from_rest >= 0 .and. s%distance_from_rest <= near_rest
   end function is_at_rest

   !> Write into the result how the run has ended and what it has warned of, so that the numbers do not go without that. A run that
   !> goes on later, or cannot write, has not ended.
   subroutine tell_end(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unwritten               ! nobody is told: that the computation has failed matters more
      select case (failure%code)
      case (exit_done)
         call s%results%add_attribute('/history', 'ended', 'done', failure)
         call s%results%add_attribute('/history', 'warnings', warnings(s), failure)
         if (s%distance_from_rest >= 0) &
            call s%results%add_attribute('/history', 'distance_from_rest', s%distance_from_rest, failure)
      case (exit_computation)
         call s%results%add_attribute('/history', 'ended', failure%message, unwritten)
         call s%results%add_attribute('/history', 'warnings', warnings(s), unwritten)
      end select
   end subroutine tell_end

   !> What the user should know of the numbers of a run, a line each; '' where there is nothing.
   function warnings(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text, other
      text = ''
      if (allocated(s%warning)) text = s%warning
      other = s%refinement%warning(s%motion%steps, .not. s%motion%grid%forest%is_uniform())
      if (other /= '') call add_line(text, other)
   end function warnings

   !> Path of the result of a scene in a folder.
   pure function result_path(scene, folder) result(path)
      type(scene_t), intent(in) :: scene
      character(*), intent(in) :: folder
      character(:), allocatable :: path
      path = folder//'/'//trim(scene%output%file)
   end function result_path

   !> Create the result file, or continue it, with what produced it.
   subroutine open_results(s, folder, failure)
      type(simulation_t), intent(inout) :: s
      character(*), intent(in) :: folder
      type(failure_t), intent(inout) :: failure
      call ensure_folder(folder, failure)
      if (failure%failed()) return
      if (allocated(s%lengths)) then
         call s%results%resume(result_path(s%scene, folder), s%scene%as_used, s%lengths, failure)
      else
         call s%results%create(result_path(s%scene, folder), failure)
      end if
      call s%results%add_text('/input/namelist', s%scene%as_used, failure)
      call s%results%add_attribute('/input', 'version', version, failure)
      call s%results%add_attribute('/input', 'compiler', compiler_version(), failure)
      call s%results%add_attribute('/input', 'compiler_options', compiler_options(), failure)
      call s%results%add_attribute('/input', 'host', host_name(), failure)
      call s%results%add_attribute('/input', 'threads', thread_count(), failure)
      call s%results%add_attribute('/history', 'title', trim(s%scene%run%title), failure)
      if (any(s%scene%paths%name /= '')) call s%results%add_attribute('/history', 'cracks', path_names(s%scene%paths), failure)
      call declare_columns(s%scene, s%motion, s%cracks, s%growing, s%measurements, s%results, failure)
   end subroutine open_results

   !> The names of cracks of the kind 'path', in their order, which is that of the tips.
   pure function path_names(paths) result(names)
      type(path_spec_t), intent(in) :: paths(:)
      character(:), allocatable :: names
      integer :: k
      names = ''
      do k = 1, size(paths)
         names = names//trim(paths(k)%name)
         if (k < size(paths)) names = names//', '
      end do
   end function path_names

   !> Tell the progress line where the run is; `last` ends it.
   subroutine show_progress(s, last)
      type(simulation_t), intent(inout) :: s
      logical, intent(in) :: last
      type(standing_t) :: now
      integer :: k
      associate (m => s%motion)
         now%time = m%time
         now%step = m%steps
         now%cells = m%grid%forest%leaf_count()
         now%particles = m%particles%n
         now%finest_level = m%grid%forest%finest_level()
         if (allocated(s%measurements%g_ratio)) now%g_ratio = s%measurements%g_ratio
         if (s%growing%are_there()) then
            now%crack_length = sum([(s%cracks%crack(k)%length(), k=1, size(s%cracks%crack))])
            if (.not. s%growing%at_rest) now%tip_speed = maxval(s%cracks%tips%speed)
         end if
         now%energy_residual = energy_residual(m, s%measurements)
      end associate
      call s%progress%show(now, last)
   end subroutine show_progress
end module hampm_simulation
