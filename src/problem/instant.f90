!> State of a motion at an instant, restored after a trial step. Mesh and cuts stay in between.
module hampm_instant
   use hampm_constraints, only: constraints_t
   use hampm_interface_points, only: interfaces_t
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t
   use hampm_state, only: state_t, energies_t
   implicit none
   private
   public :: instant_t, save_instant, go_back_to

   !> State of particles, interface points, constraints, faces and nodes, and accumulated energies.
   type :: instant_t
      type(particles_t) :: particles
      type(interfaces_t) :: interfaces
      type(constraints_t) :: constraints
      type(state_t) :: state
      type(energies_t) :: energies
   end type instant_t

contains

   !> Keep the present state of a motion, of which no particle is behind.
   subroutine save_instant(m, instant)
      type(problem_t), intent(in) :: m
      type(instant_t), intent(inout) :: instant
      instant%particles = m%particles
      instant%interfaces = m%interfaces
      instant%constraints = m%constraints
      instant%state = m%state
      instant%energies = m%energies
   end subroutine save_instant

   !> Restore a state.
   subroutine go_back_to(instant, m)
      type(instant_t), intent(in) :: instant
      type(problem_t), intent(inout) :: m
      m%particles = instant%particles
      m%interfaces = instant%interfaces
      m%constraints = instant%constraints
      m%state = instant%state
      m%energies = instant%energies
      m%cache%mapped = .false.
   end subroutine go_back_to
end module hampm_instant
