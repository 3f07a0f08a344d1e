!> Implicit integration: all cells take the same time step, which no cell limits.
module hampm_implicit
   use hampm_kinds, only: dp
   use hampm_archive, only: archive_t
   use hampm_failure, only: failure_t
   use hampm_integrator, only: integrator_t, book_step
   use hampm_problem, only: problem_t, map_to_grid
   use hampm_newmark, only: newmark_t
   implicit none
   private
   public :: implicit_t

   !> How forces are balanced with those of inertia.
   type, extends(integrator_t) :: implicit_t
      type(newmark_t) :: newmark
   contains
      procedure :: advance
      procedure :: initialise
      procedure :: note_start
      procedure :: go_to_start
      procedure :: finish
      procedure :: serialise
   end type implicit_t

contains

   !> Advance by a step. Fails where its equations cannot be solved.
   subroutine advance(self, m, dt, failure)
      class(implicit_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      if (.not. m%cache%mapped) call map_to_grid(m)
      call self%newmark%advance_to(m, m%state%time + dt, failure)
      if (.not. failure%failed()) call book_step(m, dt)
   end subroutine advance

   !> Find velocity and acceleration of the nodes, with which the run begins.
   subroutine initialise(self, m, dt, failure)
      class(implicit_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! length of the next step [s]
      type(failure_t), intent(inout) :: failure
      call self%newmark%start(m, dt, failure)
   end subroutine initialise

   !> Note what a step begins with.
   subroutine note_start(self, m)
      class(implicit_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      call self%newmark%note_start(m)
   end subroutine note_start

   !> Go back to what was noted.
   subroutine go_to_start(self, m)
      class(implicit_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      call self%newmark%go_to_start(m)
   end subroutine go_to_start

   !> Keep in an archive what the steps need of those before.
   subroutine serialise(self, m, archive)
      class(implicit_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      class(archive_t), intent(inout) :: archive
      call self%newmark%serialise(m, archive)
   end subroutine serialise

   !> Give back the memory of the matrix.
   subroutine finish(self)
      class(implicit_t), intent(inout) :: self
      call self%newmark%newton%release()
   end subroutine finish
end module hampm_implicit
