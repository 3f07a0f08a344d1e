!> The equations of motion of the nodes with the lumped mass matrix.
module hampm_nodal_motion
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constraints_t, hold
   use hampm_nodal_fields, only: nodal_fields_t, nodes_per_block, at_start, new
   implicit none
   private
   public :: velocity_from_momentum, accelerate

contains

   !> Nodal velocities (10): mapped momentum over lumped mass [m/s].
   subroutine velocity_from_momentum(f, which)
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: which                      !! which velocity to set: `at_start` or `mapped`
      integer :: block
      !$omp parallel do schedule(static)
      do block = 1, block_count(f)
         call find_velocities(block_size(f, block), f%active(first_of(block)), f%mass, f%momentum, f%velocity(1, 1, which))
      end do
   end subroutine velocity_from_momentum

   !> Nodal accelerations (10) with the damping force -alpha m v, and the velocities v + a dt that move the particles.
   !>
   !> Also the power of the damping, and for the audit
   !>    mapping_power = dt sum m_i a_i**2 - sum f_int,i . (v_i + a_i dt):
   !> with sum_p m dv**2/2 of the particles its first term is the kinetic energy that is lost between nodes and
   !> particles, and with the stress work of the particles its second the strain energy that is.
   subroutine accelerate(f, constraints, damping_rate, dt, damping_power, mapping_power)
      type(nodal_fields_t), intent(inout) :: f
      type(constraints_t), intent(in) :: constraints
      real(dp), intent(in) :: damping_rate              !! alpha [1/s]
      real(dp), intent(in) :: dt                        !! [s]
      real(dp), intent(out) :: damping_power            !! sum alpha p_i . (v_i + a_i dt) [W]
      real(dp), intent(out) :: mapping_power            !! see above [W]
      integer :: block
      call hold(constraints, f%internal_force)
      call hold(constraints, f%external_force)
      !$omp parallel do schedule(static)
      do block = 1, block_count(f)
         call accelerate_nodes(block_size(f, block), f%active(first_of(block)), damping_rate, dt, f%mass, f%momentum, &
                               f%internal_force, f%external_force, f%velocity(1, 1, at_start), &
                               f%acceleration, f%velocity(1, 1, new), f%partial_power(1, block))
      end do
      damping_power = damping_rate*sum(f%partial_power(1, :block_count(f)))
      mapping_power = sum(f%partial_power(2, :block_count(f)))
   end subroutine accelerate

   !> Number of blocks of active nodes.
   pure integer function block_count(f)
      type(nodal_fields_t), intent(in) :: f
      block_count = (f%n_active - 1)/nodes_per_block + 1
   end function block_count

   !> Position of the first node of a block in the list of active nodes.
   pure integer function first_of(block)
      integer, intent(in) :: block
      first_of = (block - 1)*nodes_per_block + 1
   end function first_of

   !> Number of nodes of a block.
   pure integer function block_size(f, block)
      type(nodal_fields_t), intent(in) :: f
      integer, intent(in) :: block
      block_size = min(nodes_per_block, f%n_active - (block - 1)*nodes_per_block)
   end function block_size

   !> The velocities of `n` nodes.
   pure subroutine find_velocities(n, nodes, mass, momentum, velocity)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: mass(*), momentum(ndim, *)
      real(dp), intent(inout) :: velocity(ndim, *)
      real(dp) :: inverse_mass
      integer :: a
      do a = 1, n
         inverse_mass = 1/mass(nodes(a))
         velocity(:, nodes(a)) = momentum(:, nodes(a))*inverse_mass
      end do
   end subroutine find_velocities

   !> The accelerations of `n` nodes, with their share in the powers of `accelerate`.
   pure subroutine accelerate_nodes(n, nodes, damping_rate, dt, mass, momentum, internal_force, external_force, velocity, &
                                    acceleration, new_velocity, power)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: damping_rate, dt, mass(*), momentum(ndim, *), internal_force(ndim, *), external_force(ndim, *)
      real(dp), intent(in) :: velocity(ndim, *)
      real(dp), intent(inout) :: acceleration(ndim, *), new_velocity(ndim, *)
      real(dp), intent(out) :: power(2)
      real(dp) :: inverse_mass, a_i(ndim), v_i(ndim)
      integer :: k, i, d
      power = 0
      do k = 1, n
         i = nodes(k)
         inverse_mass = 1/mass(i)
         a_i = (internal_force(:, i) + external_force(:, i))*inverse_mass - damping_rate*velocity(:, i)
         v_i = velocity(:, i) + dt*a_i
         acceleration(:, i) = a_i
         new_velocity(:, i) = v_i
         do d = 1, ndim
            power(1) = power(1) + momentum(d, i)*v_i(d)
            power(2) = power(2) + dt*mass(i)*a_i(d)**2 - internal_force(d, i)*v_i(d)
         end do
      end do
   end subroutine accelerate_nodes
end module hampm_nodal_motion
