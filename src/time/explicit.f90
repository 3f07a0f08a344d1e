!> Explicit integration: all cells take the same time step.
!>
!> Explicit integration by the step that is there to be read (`hampm_reference_step`), with all that a run is besides.
module hampm_explicit
   use hampm_kinds, only: dp
   use hampm_failure, only: failure_t
   use hampm_integrator, only: integrator_t
   use hampm_problem, only: problem_t, sort_anew
   use hampm_step, only: take_step, report_jump
   use hampm_reference_step, only: reference_step
   implicit none
   private
   public :: explicit_t, reference_t

   !> It keeps nothing from step to step.
   type, extends(integrator_t) :: explicit_t
   contains
      procedure :: advance
   end type explicit_t

   !> The same by the step that is there to be read, with all that a run is besides.
   type, extends(integrator_t) :: reference_t
   contains
      procedure :: advance => advance_readably
   end type reference_t

contains

   !> Advance by a step.
   subroutine advance(self, m, dt, failure)
      class(explicit_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      call take_step(m, dt, failure)
   end subroutine advance

   !> Advance by a step, and find the particles that have moved to other cells.
   subroutine advance_readably(self, m, dt, failure)
      class(reference_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      call reference_step(m, dt, failure)
      m%cache%mapped = .false.
      m%cache%sorted = .not. m%particles%total_frame
      if (.not. m%cache%sorted) return
      call report_jump(m, failure)
      if (.not. failure%failed()) call sort_anew(m, failure)
   end subroutine advance_readably
end module hampm_explicit
