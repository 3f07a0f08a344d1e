!> The parts of a run, built from its model. Procedures of a run do nothing after a failure.
module hampm_simulation
   use hampm_kinds, only: dp, long
   use hampm_asked_errors, only: asked_error_t
   use hampm_assembly, only: assemble, choose_integrator
   use hampm_bodies, only: add_spin
   use hampm_input_warnings, only: warnings_of
   use hampm_cell_blocks, only: smallest_occupied_cell
   use hampm_crack_carrying, only: carried_cracks_t, attach_cracks
   use hampm_crack_errors, only: estimate_errors
   use hampm_cracks, only: cracks_t
   use hampm_critical_step, only: stable_time_step
   use hampm_equilibrium, only: equilibrium_t
   use hampm_failure, only: failure_t
   use hampm_growing, only: growing_t, new_growing
   use hampm_integrator, only: integrator_t
   use hampm_interface_step, only: forget_faces
   use hampm_interruption, only: interruption_t
   use hampm_largest_step, only: default_courant, default_part
   use hampm_measurements, only: measurements_t, new_measurements, rebuild_extrapolation, measure
   use hampm_problem, only: problem_t
   use hampm_edge_loads, only: lay_loads
   use hampm_pressed_faces, only: press_faces
   use hampm_progress, only: progress_t
   use hampm_indicator, only: refinement_t
   use hampm_refinement, only: refine_at_start
   use hampm_results, only: results_t
   use hampm_stiffening, only: stiffening_of
   use hampm_stiffness, only: stiffness_t
   use hampm_model, only: model_t
   use hampm_text, only: add_line
   use hampm_threads, only: use_threads
   implicit none
   private
   public :: simulation_t, build, release, rebuild_on_mesh, limit_time_step, follow_stiffening, measure_state, warnings, &
             is_near_equilibrium

   real(dp), parameter :: near_equilibrium = 0.01_dp !! distance to equilibrium up to which values count as static [-]

   !> All that a run consists of.
   type :: simulation_t
      type(model_t) :: model
      type(problem_t) :: problem
      type(cracks_t) :: cracks
      type(measurements_t) :: measurements
      type(results_t) :: results
      type(asked_error_t), allocatable :: asked(:) !! errors that are asked, and told
      logical :: is_pilot = .false.              !! whether it is run for these alone, and writes nothing
      type(refinement_t) :: refinement
      type(carried_cracks_t) :: carried
      type(growing_t) :: growing
      class(integrator_t), allocatable :: integrator
      type(progress_t) :: progress
      type(interruption_t) :: interruption
      real(dp) :: distance_to_equilibrium = -1   !! of the last values, see `find_distance_to_equilibrium`; below 0: not known [-]
      real(dp) :: longest_step = 0               !! time step (31) [s]
      real(dp) :: stiffening = 1                 !! wave speed in strained material over the unstrained one [-]
      real(dp) :: limit = 0                      !! the same when the steps to the next output were chosen [s]
      integer(long) :: steps_left = 0            !! how many of these are not yet done
      real(dp) :: dt = 0                         !! last time step: not longer, and such that outputs fall on their times [s]
      logical :: is_over = .false.               !! whether the run ends before its end time: pieces have no equilibrium
      integer(long) :: samples = 0               !! rows of the history so far
      integer(long) :: snapshots = 0             !! snapshots so far
      real(dp) :: largest_load = 0               !! of the samples so far, see `hampm_stopping`
      character(:), allocatable :: stopped_when  !! why it has ended before its end time; not allocated where it has not
      integer(long), allocatable :: lengths(:)   !! of the result that is continued; not allocated where a new one begins
      character(:), allocatable :: warning       !! of the model and of the run-time checks, a line each
   end type simulation_t

contains

   !> Build the simulation of a model on a number of threads; 0 lets the size of the model decide.
   subroutine build(model, threads, s, failure, rest)
      type(model_t), intent(in) :: model
      integer, intent(in) :: threads
      type(simulation_t), intent(out) :: s
      type(failure_t), intent(inout) :: failure
      type(stiffness_t), intent(inout), optional :: rest !! of a motion, by which errors are estimated: to keep it, and to release
      type(stiffness_t) :: own
      integer :: k
      s%model = model
      s%warning = warnings_of(model)
      call assemble(model, s%problem, s%cracks, s%refinement, failure)
      call choose_integrator(model, s%integrator)
      if (failure%failed()) return
      call attach_cracks(s%carried, s%problem, any(model%energy_release%chosen%needs_nodes))
      call refine_at_start(s%refinement, s%problem, s%cracks%tip_places(), failure)
      if (failure%failed()) return
      do k = 1, size(model%bodies)               ! with the particles as they now are: rigid motions to the last digit
         if (any(abs(model%bodies(k)%spin) > 0)) call add_spin(s%problem%particles, k, model%bodies(k)%spin)
      end do
      call use_threads(threads, s%problem%particles%n)
      call rebuild_on_mesh(s, failure)
      if (failure%failed()) return
      call new_measurements(model, s%problem, s%cracks, s%measurements)
      call new_growing(model, s%cracks, s%measurements%fronts, s%growing)
      associate (measurements => s%measurements)
         select type (integrator => s%integrator)
         type is (equilibrium_t)                 ! finds rest by the same matrix
            call estimate_errors(s%problem, s%cracks, integrator%newton%k, measurements%extrapolation, measurements%crack, &
                                 failure, model%run%end_time)
         class default
            if (present(rest)) then
               call estimate_errors(s%problem, s%cracks, rest, measurements%extrapolation, measurements%crack, failure)
            else
               call estimate_errors(s%problem, s%cracks, own, measurements%extrapolation, measurements%crack, failure)
               call own%release()
            end if
         end select
      end associate
   end subroutine build

   !> Release the memory of C libraries, which is not released automatically.
   subroutine release(s)
      type(simulation_t), intent(inout) :: s
      call s%problem%solver%direct%release()
      call s%measurements%extrapolation%direct%release()
      call forget_faces(s%problem%interface_step)
   end subroutine release

   !> Make time step, nodes around crack tips, loads on edges and faces and extrapolations fit a new mesh.
   subroutine rebuild_on_mesh(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: changed
      changed = .false.
      call limit_time_step(s)
      call s%cracks%find_nodes(s%problem%grid, failure)
      call lay_loads(s%problem%loads, s%problem%matter_t, changed)
      if (changed) s%problem%cache%mapped = .false. ! which cells have operators depends on the particles
      call press_faces(s%problem)
      if (.not. failure%failed()) call rebuild_extrapolation(s%problem, s%measurements, failure)
   end subroutine rebuild_on_mesh

   !> The longest time step follows the smallest occupied cell, and waves in strained material where that would be unstable: a given
   !> `courant` is kept up to the limit, as changes of steps cost accuracy.
   subroutine limit_time_step(s)
      type(simulation_t), intent(inout) :: s
      real(dp) :: courant
      courant = s%model%method%courant
      if (s%stiffening > 1) courant = min(courant, s%model%method%courant_limit/s%stiffening* &
                                          merge(1.0_dp, default_part, abs(courant - default_courant(s%model)) > 0))
      s%longest_step = stable_time_step(smallest_occupied_cell(s%problem%grid, s%problem%blocks), s%problem%materials, &
                                        courant, s%model%method%wave_speed)
      if (s%integrator%fixed_step > 0) s%longest_step = s%integrator%fixed_step
   end subroutine limit_time_step

   !> After some explicit steps: shorten them where finite-strain material has become stiffer, and lengthen them again where it is
   !> less so, in increments of `stiffening` that are small against the margin of `default_part`.
   subroutine follow_stiffening(s)
      type(simulation_t), intent(inout) :: s
      integer(long), parameter :: every = 8
      real(dp), parameter :: part = 1.02_dp
      real(dp) :: now
      if (s%model%method%time /= 'explicit' .or. mod(s%problem%state%steps, every) /= 0) return
      if (.not. any(s%problem%materials%is_finite)) return
      now = stiffening_of(s%problem%particles, s%problem%materials)
      if (now < s%stiffening*part .and. now > s%stiffening/part) return
      s%stiffening = part**floor(log(now)/log(part))
      call limit_time_step(s)
   end subroutine follow_stiffening

   !> Measure energies, G and K, unless something has failed.
   subroutine measure_state(s, failure, in_passing)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: in_passing !! whether faces may overlap, in a state that is not of the run
      type(measurements_t) :: before
      if (failure%failed()) return
      if (present(in_passing)) before%overlap = s%measurements%overlap
      call measure(s%model, s%problem, s%cracks, s%measurements, failure)
      if (present(in_passing)) s%measurements%overlap = before%overlap
   end subroutine measure_state

   !> Warnings on the numbers of a run, a line each; '' if there are none.
   function warnings(s) result(text)
      type(simulation_t), intent(in) :: s
      character(:), allocatable :: text, other
      text = s%warning
      other = s%refinement%warning(s%problem%state%steps, .not. s%problem%grid%forest%is_uniform())
      if (other /= '') call add_line(text, other)
   end function warnings

   !> Whether the run has reached equilibrium.
   pure logical function is_near_equilibrium(s)
      type(simulation_t), intent(in) :: s
      is_near_equilibrium = s%distance_to_equilibrium >= 0 .and. s%distance_to_equilibrium <= near_equilibrium
   end function is_near_equilibrium
end module hampm_simulation
