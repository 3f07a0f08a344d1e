!> The equations of motion of the nodes.
module hampm_nodal_motion
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: region_t, nodes_per_block
   use hampm_mass_solver, only: mass_solver_t, solve_mass
   use hampm_nodal_fields, only: nodal_fields_t, at_start, new
   implicit none
   private
   public :: find_velocity, accelerate, expand

contains

   !> Nodal velocities (8) from the mapped momentum [m/s]. The guess is the velocity that the nodes had last: it is the
   !> solution, but for the little by which the matrix has changed since and for what a partly lumped one filters.
   subroutine find_velocity(grid, solver, f, which, latest, failure)
      type(grid_t), intent(in) :: grid
      type(mass_solver_t), intent(inout) :: solver
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: which                      !! which velocity to set: `at_start` or `mapped`
      integer, intent(in) :: latest                     !! the velocity that was found last
      type(failure_t), intent(inout) :: failure
      if (solver%iterates()) f%velocity(:, :, which) = f%velocity(:, :, latest)
      call solve_mass(solver, grid, f%mass_matrix, f%momentum, f%velocity(:, :, which), failure)
      call expand(grid, f%mass_matrix%all, f%velocity(:, :, which))
   end subroutine find_velocity

   !> Nodal accelerations (5) with the damping force -alpha m v, and the velocities v + a dt that move the particles.
   !>
   !> Also the power of the damping, and for the audit
   !>    mapping_power = dt sum F_i . a_i - sum f_i . (v_i + a_i dt),   F the total force, f the same without damping:
   !> with sum_p m dv**2/2 of the particles its first term is the kinetic energy that is lost between nodes and
   !> particles, and with the stress work and the work of the loads its second the energy that the scheme loses.
   subroutine accelerate(grid, solver, damping_rate, dt, audit, f, damping_power, mapping_power, failure)
      type(grid_t), intent(in) :: grid
      type(mass_solver_t), intent(inout) :: solver
      real(dp), intent(in) :: damping_rate              !! alpha [1/s]
      real(dp), intent(in) :: dt                        !! [s]
      logical, intent(in) :: audit                      !! whether the mapping power is wanted
      type(nodal_fields_t), intent(inout) :: f
      real(dp), intent(out) :: damping_power            !! sum alpha p_i . (v_i + a_i dt) [W]
      real(dp), intent(out) :: mapping_power            !! see above [W]; 0 without `audit`
      type(failure_t), intent(inout) :: failure
      integer :: block, blocks, first
      if (solver%iterates()) call guess_acceleration(f)
      call solve_mass(solver, grid, f%mass_matrix, f%force, f%acceleration, failure)
      if (solver%iterates()) call remember_acceleration(f)
      call expand(grid, f%mass_matrix%all, f%acceleration)
      blocks = (f%mass_matrix%all%n_points - 1)/nodes_per_block + 1
      !$omp parallel do schedule(static) private(first)
      do block = 1, blocks
         first = (block - 1)*nodes_per_block + 1
         call kick_nodes(min(nodes_per_block, f%mass_matrix%all%n_points - first + 1), f%mass_matrix%all%nodes(first), &
                         damping_rate, dt, audit .or. damping_rate > 0, f%momentum, f%force, f%velocity(1, 1, at_start), &
                         f%acceleration, f%velocity(1, 1, new), f%partial_power(1, block))
      end do
      damping_power = damping_rate*sum(f%partial_power(1, :blocks))
      mapping_power = merge(sum(f%partial_power(2, :blocks)), 0.0_dp, audit)
   end subroutine accelerate

   !> Find the values at the dependent points.
   subroutine expand(grid, region, x)
      type(grid_t), intent(in) :: grid
      type(region_t), intent(in) :: region
      real(dp), intent(inout), contiguous :: x(:, :)    !! (ndim, n_points)
      call grid%dependents%expand(region%nodes(region%n_nodes + 1:region%n_points), ndim, x)
   end subroutine expand

   !> Take the line through the last two solutions as the guess of the next.
   subroutine guess_acceleration(f)
      type(nodal_fields_t), intent(inout) :: f
      if (.not. allocated(f%past)) allocate (f%past(ndim, size(f%acceleration, 2), 2), source=0.0_dp)
      f%acceleration = 2*f%past(:, :, 1) - f%past(:, :, 2)
   end subroutine guess_acceleration

   !> Keep the solution for the next guesses.
   subroutine remember_acceleration(f)
      type(nodal_fields_t), intent(inout) :: f
      f%past(:, :, 2) = f%past(:, :, 1)
      f%past(:, :, 1) = f%acceleration
   end subroutine remember_acceleration

   !> Damp the accelerations of `n` points and find their new velocities and, where wanted, their share in the powers of
   !> `accelerate`.
   pure subroutine kick_nodes(n, nodes, damping_rate, dt, with_power, momentum, force, velocity, acceleration, new_velocity, power)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: damping_rate, dt, momentum(ndim, *), force(ndim, *), velocity(ndim, *)
      logical, intent(in) :: with_power
      real(dp), intent(inout) :: acceleration(ndim, *), new_velocity(ndim, *)
      real(dp), intent(out) :: power(2)
      real(dp) :: a(ndim), v(ndim)
      integer :: k, i, d
      power = 0
      !GCC$ novector
      do k = 1, n
         i = nodes(k)
         a = acceleration(:, i) - damping_rate*velocity(:, i)
         v = velocity(:, i) + dt*a
         acceleration(:, i) = a
         new_velocity(:, i) = v
         if (.not. with_power) cycle
         do d = 1, ndim
            power(1) = power(1) + momentum(d, i)*v(d)
            power(2) = power(2) + dt*(force(d, i) - damping_rate*momentum(d, i))*a(d) - force(d, i)*v(d)
         end do
      end do
   end subroutine kick_nodes
end module hampm_nodal_motion
