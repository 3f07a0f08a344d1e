!> What a motion is like at an instant, to go back to after a step that was tried. Mesh and cuts stay in between.
module hampm_instant
   use hampm_kinds, only: dp, long
   use hampm_constraints, only: constraints_t
   use hampm_driven_nodes, only: driven_work_t
   use hampm_interface_points, only: interfaces_t
   use hampm_motion, only: motion_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: instant_t, remember, go_back_to

   !> State of particles, interface points, constraints, faces and nodes, and what has been booked.
   type :: instant_t
      type(particles_t) :: particles
      type(interfaces_t) :: interfaces
      type(constraints_t) :: constraints
      real(dp), allocatable :: nodal_displacement(:, :), nodal_velocity(:, :), nodal_acceleration(:, :)
      type(driven_work_t) :: driven
      real(dp) :: time = 0, last_dt = 0, external_work = 0, damping_loss = 0, fracture_energy = 0, numerical_loss = 0
      integer(long) :: steps = 0
   end type instant_t

contains

   !> Keep the present state of a motion, of which no particle is behind.
   subroutine remember(m, instant)
      type(motion_t), intent(in) :: m
      type(instant_t), intent(inout) :: instant
      instant%particles = m%particles
      instant%interfaces = m%interfaces
      instant%constraints = m%constraints
      if (allocated(m%nodal_displacement)) instant%nodal_displacement = m%nodal_displacement
      if (allocated(m%nodal_velocity)) instant%nodal_velocity = m%nodal_velocity
      if (allocated(m%nodal_acceleration)) instant%nodal_acceleration = m%nodal_acceleration
      instant%driven = m%driven
      instant%time = m%time
      instant%steps = m%steps
      instant%last_dt = m%last_dt
      instant%external_work = m%external_work
      instant%damping_loss = m%damping_loss
      instant%fracture_energy = m%fracture_energy
      instant%numerical_loss = m%numerical_loss
   end subroutine remember

   !> Go back to a state.
   subroutine go_back_to(instant, m)
      type(instant_t), intent(in) :: instant
      type(motion_t), intent(inout) :: m
      m%particles = instant%particles
      m%interfaces = instant%interfaces
      m%constraints = instant%constraints
      if (allocated(instant%nodal_displacement)) m%nodal_displacement = instant%nodal_displacement
      if (allocated(instant%nodal_velocity)) m%nodal_velocity = instant%nodal_velocity
      if (allocated(instant%nodal_acceleration)) m%nodal_acceleration = instant%nodal_acceleration
      m%driven = instant%driven
      m%time = instant%time
      m%steps = instant%steps
      m%last_dt = instant%last_dt
      m%external_work = instant%external_work
      m%damping_loss = instant%damping_loss
      m%fracture_energy = instant%fracture_energy
      m%numerical_loss = instant%numerical_loss
      m%mapped = .false.
   end subroutine go_back_to
end module hampm_instant
