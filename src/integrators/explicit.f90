!> Explicit integration: all cells take the same time step.
module hampm_explicit
   use hampm_kinds, only: dp
   use hampm_failure, only: failure_t
   use hampm_integrator, only: integrator_t
   use hampm_motion, only: motion_t
   use hampm_step, only: take_step
   implicit none
   private
   public :: explicit_t

   !> It keeps nothing from step to step.
   type, extends(integrator_t) :: explicit_t
   contains
      procedure :: advance
   end type explicit_t

contains

   !> Advance by a step.
   subroutine advance(self, m, dt, failure)
      class(explicit_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      call take_step(m, dt, failure)
   end subroutine advance
end module hampm_explicit
