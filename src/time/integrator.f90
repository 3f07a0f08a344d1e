!> Common part of all integrators: each advances a motion in time by steps of its own kind.
module hampm_integrator
   use hampm_kinds, only: dp, long
   use hampm_archive, only: archive_t
   use hampm_failure, only: failure_t
   use hampm_problem, only: problem_t
   use hampm_results, only: results_t
   implicit none
   private
   public :: integrator_t, steps_for, book_step

   !> A way to integrate the equations of motion.
   type, abstract :: integrator_t
      real(dp) :: fixed_step = 0                 !! time step where it does not follow the cells, else 0 [s]
      logical :: is_static = .false.             !! whether a step ends in equilibrium
      logical :: ends_at_rows = .true.           !! whether steps end at the times of rows; else a row is at the end of its step
      real(dp) :: distance_to_equilibrium = -1   !! of the last such step, see `equilibrium_t` [-]
   contains
      procedure :: choose_steps
      procedure(advance), deferred :: advance
      procedure :: initialise
      procedure :: note_start
      procedure :: go_to_start
      procedure :: rescale
      procedure :: serialise
      procedure :: describe
      procedure :: report
   end type integrator_t

   abstract interface
      !> Advance by a step; particles may stay behind until `update_particles`. Fails where a particle leaves the grid or jumps, or
      !> where equations cannot be solved.
      subroutine advance(self, m, dt, failure)
         import :: integrator_t, problem_t, failure_t, dp
         class(integrator_t), intent(inout) :: self
         type(problem_t), intent(inout) :: m
         real(dp), intent(in) :: dt              !! [s]
         type(failure_t), intent(inout) :: failure
      end subroutine advance
   end interface

contains

   !> Choose into how many equal steps a time is divided: a single one to equilibrium.
   subroutine choose_steps(self, time, limit, steps, dt)
      class(integrator_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(in) :: limit              !! longest time step that is stable [s]
      integer(long), intent(out) :: steps
      real(dp), intent(out) :: dt                !! [s]
      steps = 1
      if (.not. self%is_static) steps = steps_for(time, limit)
      dt = time/steps
   end subroutine choose_steps

   !> Find the initial state of steps at the present time, at the start or on another mesh, if particles do not give it:
   !> equilibrium, or the motion of the nodes. Here nothing.
   subroutine initialise(self, m, dt, failure)
      class(integrator_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! length of the next step [s]
      type(failure_t), intent(inout) :: failure
   end subroutine initialise

   !> Save the state at the start of a step that may be tried again, with up-to-date particles. Here nothing.
   subroutine note_start(self, m)
      class(integrator_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
   end subroutine note_start

   !> Restore the saved state. Here nothing.
   subroutine go_to_start(self, m)
      class(integrator_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
   end subroutine go_to_start

   !> In equilibrium: scale all loading that is not held, and find the equilibrium with it, now or at another time. Here nothing.
   subroutine rescale(self, m, load_factor, failure, time)
      class(integrator_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: load_factor        !! relative to the model [-]
      type(failure_t), intent(inout) :: failure
      real(dp), intent(in), optional :: time     !! [s]
   end subroutine rescale

   !> Archive the data that steps need of earlier ones. Here nothing.
   subroutine serialise(self, m, archive)
      class(integrator_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      class(archive_t), intent(inout) :: archive
   end subroutine serialise

   !> Write what the method has found at the start into the result. Here nothing.
   subroutine describe(self, m, results, failure)
      class(integrator_t), intent(in) :: self
      type(problem_t), intent(in) :: m
      type(results_t), intent(inout) :: results
      type(failure_t), intent(inout) :: failure
   end subroutine describe

   !> In words: what the method has found at the start. Here ''.
   function report(self) result(text)
      class(integrator_t), intent(in) :: self
      character(:), allocatable :: text
      text = ''
   end function report

   !> Book a step at the end of which all particles stay in the cells in which they are.
   pure subroutine book_step(m, dt)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      m%state%steps = m%state%steps + 1
      m%state%last_dt = dt
      m%cache%sorted = .false.
   end subroutine book_step

   !> How many steps, none longer than `limit`, fill a time.
   pure integer(long) function steps_for(time, limit)
      real(dp), intent(in) :: time, limit        !! [s]
      real(dp), parameter :: rounding = 1.0e-6_dp       ! excess of a step, relative, that adds no step
      steps_for = max(1_long, ceiling(time/limit - rounding, long))
   end function steps_for
end module hampm_integrator
