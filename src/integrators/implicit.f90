!> Implicit integration: all cells take the same time step, which no cell limits.
module hampm_implicit
   use hampm_kinds, only: dp, long
   use hampm_archive, only: archive_t
   use hampm_failure, only: failure_t
   use hampm_integrator, only: integrator_t, steps_for, book_step
   use hampm_motion, only: motion_t, map_to_grid
   use hampm_newmark, only: newmark_t
   implicit none
   private
   public :: implicit_t

   real(dp), parameter :: same = 1e-9_dp         !! part by which a step may differ from the last one and be taken for it

   !> The method by which it steps.
   type, extends(integrator_t) :: implicit_t
      type(newmark_t) :: newmark
   contains
      procedure :: choose_steps
      procedure :: advance
      procedure :: settle
      procedure :: finish
      procedure :: keep
   end type implicit_t

contains

   !> Divide a time into equal steps: as long as the last one where only rounding is between them, so that its matrix serves on.
   subroutine choose_steps(self, m, time, limit, steps, dt)
      class(implicit_t), intent(inout) :: self
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(in) :: limit              !! longest time step that is wanted [s]
      integer(long), intent(out) :: steps
      real(dp), intent(out) :: dt                !! [s]
      steps = steps_for(time, limit)
      dt = time/steps
      if (abs(dt - self%newmark%dt) <= same*dt) dt = self%newmark%dt
   end subroutine choose_steps

   !> Advance by a step. Fails where its equations cannot be solved.
   subroutine advance(self, m, dt, failure)
      class(implicit_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      if (.not. m%mapped) call map_to_grid(m)
      call self%newmark%step(m, dt, failure)
      if (failure%failed()) return
      m%time = m%time + dt
      call book_step(m, dt)
   end subroutine advance

   !> Find velocity and acceleration of the nodes, with which the run begins.
   subroutine settle(self, m, dt, failure)
      class(implicit_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! length of the next step [s]
      type(failure_t), intent(inout) :: failure
      call self%newmark%start(m, dt, failure)
   end subroutine settle

   !> Keep in an archive what the steps need of those before.
   subroutine keep(self, m, archive)
      class(implicit_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      class(archive_t), intent(inout) :: archive
      call self%newmark%keep(m, archive)
   end subroutine keep

   !> Give back the memory of the matrix.
   subroutine finish(self)
      class(implicit_t), intent(inout) :: self
      call self%newmark%release()
   end subroutine finish
end module hampm_implicit
