!> Explicit integration: all cells take the same time step.
module hampm_explicit
   use hampm_kinds, only: dp, long
   use hampm_failure, only: failure_t
   use hampm_integrator, only: integrator_t, steps_for
   use hampm_motion, only: motion_t
   use hampm_step, only: take_step
   implicit none
   private
   public :: explicit_t

   !> It keeps nothing from step to step.
   type, extends(integrator_t) :: explicit_t
   contains
      procedure :: choose_steps
      procedure :: advance
   end type explicit_t

contains

   !> Divide a time into equal steps.
   subroutine choose_steps(self, m, time, limit, steps, dt)
      class(explicit_t), intent(inout) :: self
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(in) :: limit              !! longest time step that is stable [s]
      integer(long), intent(out) :: steps
      real(dp), intent(out) :: dt                !! [s]
      self%largest = min(0, m%blocks%groups%largest)    ! whatever the groups of the cells
      steps = steps_for(time, limit)
      dt = time/steps
   end subroutine choose_steps

   !> Advance by a step.
   subroutine advance(self, m, dt, failure)
      class(explicit_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      call take_step(m, 2**self%largest*dt, failure)
   end subroutine advance
end module hampm_explicit
