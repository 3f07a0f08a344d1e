!> Motion without inertia: each step goes from equilibrium to equilibrium, in a time that only tells how large the loads are.
module hampm_static
   use hampm_kinds, only: dp, long
   use hampm_archive, only: archive_t
   use hampm_equilibrium, only: equilibrium_t
   use hampm_failure, only: failure_t
   use hampm_integrator, only: integrator_t, book_step
   use hampm_problem, only: problem_t, map_to_grid, stored_energy, dissipated_energy
   implicit none
   private
   public :: static_t

   !> How equilibrium is found.
   type, extends(integrator_t) :: static_t
      type(equilibrium_t) :: equilibrium
      real(dp) :: at_first = 0                   !! energy of eigenstrains in the first equilibrium that is not work of loads [J]
   contains
      procedure :: choose_steps
      procedure :: advance
      procedure :: initialise
      procedure :: rescale
      procedure :: finish
      procedure :: serialise
   end type static_t

contains

   !> A time is one load step.
   subroutine choose_steps(self, m, time, limit, steps, dt)
      class(static_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(in) :: limit              !! not asked [s]
      integer(long), intent(out) :: steps
      real(dp), intent(out) :: dt                !! [s]
      steps = 1
      dt = time
   end subroutine choose_steps

   !> Advance by a load step. Fails where no equilibrium is found.
   subroutine advance(self, m, dt, failure)
      class(static_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      if (.not. m%cache%mapped) call map_to_grid(m)
      call self%equilibrium%find(m, m%state%time + dt, failure)
      self%distance_to_equilibrium = self%equilibrium%distance(m)
      if (failure%failed()) return
      call book_step(m, dt)
      call book_loss(self, m)
   end subroutine advance

   !> Find equilibrium at the present time: at the start, or on another mesh from what the particles carry over to it.
   subroutine initialise(self, m, dt, failure)
      class(static_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! of no matter at rest [s]
      type(failure_t), intent(inout) :: failure
      if (.not. m%cache%mapped) call map_to_grid(m)
      if (self%equilibrium%begun) then
         call self%equilibrium%find_again(m, failure)
      else
         call self%equilibrium%find(m, m%state%time, failure)
         if (any(m%materials%has_eigenstrain)) self%at_first = stored_energy(m) - m%energies%external_work
      end if
      call book_loss(self, m)
      self%distance_to_equilibrium = self%equilibrium%distance(m)
   end subroutine initialise

   !> Multiply all that drives the material, and go to the equilibrium with it. The scales of loads and prescribed motions are to follow.
   subroutine rescale(self, m, factor, failure)
      class(static_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: factor
      type(failure_t), intent(inout) :: failure
      call self%equilibrium%find(m, m%state%time, failure, factor)
      self%equilibrium%forgets_mesh = .false.    ! tips advance from here on
      self%distance_to_equilibrium = self%equilibrium%distance(m)
      call book_loss(self, m)
   end subroutine rescale

   !> Book for the energy balance what the loads have done and the material has not stored: with other laws than the linear one what the mean force
   !> of a load step does not tell, and what finer cells give way.
   subroutine book_loss(self, m)
      class(static_t), intent(in) :: self
      type(problem_t), intent(inout) :: m
      if (m%audit) m%energies%numerical_loss = m%energies%external_work + self%at_first - stored_energy(m) - dissipated_energy(m) &
                                      - m%interfaces%loss - m%energies%fracture_energy
   end subroutine book_loss

   !> Keep in an archive what the steps need of those before.
   subroutine serialise(self, m, archive)
      class(static_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      class(archive_t), intent(inout) :: archive
      call self%equilibrium%serialise(m, archive)
      if (any(m%materials%has_eigenstrain)) call archive%serialise('at_first', self%at_first)
   end subroutine serialise

   !> Give back the memory of the last solution.
   subroutine finish(self)
      class(static_t), intent(inout) :: self
      call self%equilibrium%newton%release()
   end subroutine finish
end module hampm_static
