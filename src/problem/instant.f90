!> What a motion is like at an instant, to go back to after a step that was tried. Mesh and cuts stay in between.
module hampm_instant
   use hampm_kinds, only: dp, long
   use hampm_constraints, only: constraints_t
   use hampm_prescribed_nodes, only: prescribed_work_t
   use hampm_interface_points, only: interfaces_t
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: instant_t, save_instant, go_back_to

   !> State of particles, interface points, constraints, faces and nodes, and what has been booked.
   type :: instant_t
      type(particles_t) :: particles
      type(interfaces_t) :: interfaces
      type(constraints_t) :: constraints
      real(dp), allocatable :: nodal_displacement(:, :), nodal_velocity(:, :), nodal_acceleration(:, :)
      type(prescribed_work_t) :: prescribed
      real(dp) :: time = 0, last_dt = 0, external_work = 0, damping_loss = 0, fracture_energy = 0, numerical_loss = 0
      integer(long) :: steps = 0
   end type instant_t

contains

   !> Keep the present state of a motion, of which no particle is behind.
   subroutine save_instant(m, instant)
      type(problem_t), intent(in) :: m
      type(instant_t), intent(inout) :: instant
      instant%particles = m%particles
      instant%interfaces = m%interfaces
      instant%constraints = m%constraints
      if (allocated(m%state%displacement)) instant%nodal_displacement = m%state%displacement
      if (allocated(m%state%velocity)) instant%nodal_velocity = m%state%velocity
      if (allocated(m%state%acceleration)) instant%nodal_acceleration = m%state%acceleration
      instant%prescribed = m%energies%prescribed
      instant%time = m%state%time
      instant%steps = m%state%steps
      instant%last_dt = m%state%last_dt
      instant%external_work = m%energies%external_work
      instant%damping_loss = m%energies%damping_loss
      instant%fracture_energy = m%energies%fracture_energy
      instant%numerical_loss = m%energies%numerical_loss
   end subroutine save_instant

   !> Go back to a state.
   subroutine go_back_to(instant, m)
      type(instant_t), intent(in) :: instant
      type(problem_t), intent(inout) :: m
      m%particles = instant%particles
      m%interfaces = instant%interfaces
      m%constraints = instant%constraints
      if (allocated(instant%nodal_displacement)) m%state%displacement = instant%nodal_displacement
      if (allocated(instant%nodal_velocity)) m%state%velocity = instant%nodal_velocity
      if (allocated(instant%nodal_acceleration)) m%state%acceleration = instant%nodal_acceleration
      m%energies%prescribed = instant%prescribed
      m%state%time = instant%time
      m%state%steps = instant%steps
      m%state%last_dt = instant%last_dt
      m%energies%external_work = instant%external_work
      m%energies%damping_loss = instant%damping_loss
      m%energies%fracture_energy = instant%fracture_energy
      m%energies%numerical_loss = instant%numerical_loss
      m%cache%mapped = .false.
   end subroutine go_back_to
end module hampm_instant
