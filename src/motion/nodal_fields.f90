!> What the grid carries during one step: one value a node, and the sums over the particles of each cell from which
!> the nodal values are gathered.
module hampm_nodal_fields
   use hampm_kinds, only: dp, ndim, corners
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: at_start, new, mapped, nodes_per_block, nodal_fields_t, new_nodal_fields, find_active_nodes, &
             gather_mass_and_momentum, &
             gather_internal_force

   ! The velocities of a node during a step
   integer, parameter :: at_start = 1            !! v_i, mapped from the particles at the start of the step, (10)
   integer, parameter :: new = 2                 !! v_i + a_i dt, which moves the particles
   integer, parameter :: mapped = 3              !! mapped anew from the new velocities of the particles

   !> Sums over nodes are taken over blocks of this many nodes first, so that they do not depend on the number of threads.
   integer, parameter :: nodes_per_block = 512

   type :: nodal_fields_t
      real(dp), allocatable :: mass(:)                  !! lumped mass m_i, (9) [kg], (n_nodes)
      real(dp), allocatable :: momentum(:, :)           !! right-hand side of (8) [kg m/s], (ndim, n_nodes)
      real(dp), allocatable :: internal_force(:, :)     !! (7) [N], (ndim, n_nodes)
      real(dp), allocatable :: external_force(:, :)     !! (7), loads without damping [N], (ndim, n_nodes)
      real(dp), allocatable :: acceleration(:, :)       !! a_i, (10) [m/s2], (ndim, n_nodes)
      real(dp), allocatable :: velocity(:, :, :)        !! `at_start`, `new` and `mapped` [m/s], (ndim, n_nodes, 3)
      integer, allocatable :: active(:)                 !! nodes of occupied cells, ascending, (n_active)
      integer :: n_active = 0
      real(dp), allocatable :: cell_mass(:, :)          !! share of a cell in `mass`, (corners, n_elements)
      real(dp), allocatable :: cell_momentum(:, :, :)   !! share in `momentum`, (ndim, corners, n_elements)
      real(dp), allocatable :: cell_force(:, :, :)      !! share in `internal_force`, (ndim, corners, n_elements)
      real(dp), allocatable :: cell_audit(:, :)         !! workspace of the sweeps for the audit, (2, n_elements)
      real(dp), allocatable :: partial_power(:, :)      !! workspace of `accelerate`: sums over blocks of active nodes,
                                                        !! (2, number of blocks)
   end type nodal_fields_t

contains

   !> Nodal fields of a grid, all zero. Fails where the memory does not suffice.
   subroutine new_nodal_fields(grid, f, failure)
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(out) :: f
      type(failure_t), intent(inout) :: failure
      integer :: status
      associate (n => grid%n_nodes, m => grid%n_elements)
         allocate (f%mass(n), f%momentum(ndim, n), f%internal_force(ndim, n), f%external_force(ndim, n), &
                   f%acceleration(ndim, n), f%velocity(ndim, n, 3), f%active(n), f%cell_mass(corners, m), &
                   f%cell_momentum(ndim, corners, m), &
                   f%cell_force(ndim, corners, m), f%cell_audit(2, m), f%partial_power(2, n/nodes_per_block + 1), &
                   stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'grid: not enough memory for its nodes')
         return
      end if
      f%mass = 0
      f%momentum = 0
      f%internal_force = 0
      f%external_force = 0
      f%acceleration = 0
      f%velocity = 0
   end subroutine new_nodal_fields

   !> After a sort: list the nodes of occupied cells, and clear the sums of the cells without particles.
   subroutine find_active_nodes(grid, p, f)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(inout) :: f
      integer :: node, e, k
      do e = 1, grid%n_elements
         if (p%cell_start(e + 1) > p%cell_start(e)) cycle
         f%cell_mass(:, e) = 0
         f%cell_momentum(:, :, e) = 0
         f%cell_force(:, :, e) = 0
      end do
      f%n_active = 0
      do node = 1, grid%n_nodes
         do k = grid%node_start(node), grid%node_start(node + 1) - 1
            e = grid%node_element(k)
            if (p%cell_start(e + 1) > p%cell_start(e)) then
               f%n_active = f%n_active + 1
               f%active(f%n_active) = node
               exit
            end if
         end do
      end do
   end subroutine find_active_nodes

   !> Sum the cells' shares of mass and momentum at each active node.
   subroutine gather_mass_and_momentum(grid, f)
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(inout) :: f
      call gather_scalars(grid%node_start, grid%node_slot, f%n_active, f%active, f%cell_mass, f%mass)
      call gather_vectors(grid%node_start, grid%node_slot, f%n_active, f%active, f%cell_momentum, f%momentum)
   end subroutine gather_mass_and_momentum

   !> Sum the cells' shares of the internal force at each active node.
   subroutine gather_internal_force(grid, f)
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(inout) :: f
      call gather_vectors(grid%node_start, grid%node_slot, f%n_active, f%active, f%cell_force, f%internal_force)
   end subroutine gather_internal_force

   !> Nodal scalars from the cells' shares, always summed in the order of the cells.
   subroutine gather_scalars(node_start, node_slot, n_active, active, share, nodal)
      integer, intent(in) :: node_start(*), node_slot(*)
      integer, intent(in) :: n_active, active(n_active) !! nodes to sum for
      real(dp), intent(in) :: share(*)                  !! (corners*n_elements)
      real(dp), intent(inout) :: nodal(*)               !! (n_nodes)
      integer :: a, node, k
      real(dp) :: total
      !$omp parallel do schedule(static) private(node, k, total)
      do a = 1, n_active
         node = active(a)
         total = 0
         do k = node_start(node), node_start(node + 1) - 1
            total = total + share(node_slot(k))
         end do
         nodal(node) = total
      end do
   end subroutine gather_scalars

   !> As `gather_scalars`, of vectors.
   subroutine gather_vectors(node_start, node_slot, n_active, active, share, nodal)
      integer, intent(in) :: node_start(*), node_slot(*)
      integer, intent(in) :: n_active, active(n_active) !! nodes to sum for
      real(dp), intent(in) :: share(ndim, *)            !! (ndim, corners*n_elements)
      real(dp), intent(inout) :: nodal(ndim, *)         !! (ndim, n_nodes)
      integer :: a, node, k
      real(dp) :: total(ndim)
      !$omp parallel do schedule(static) private(node, k, total)
      do a = 1, n_active
         node = active(a)
         total = 0
         do k = node_start(node), node_start(node + 1) - 1
            total = total + share(:, node_slot(k))
         end do
         nodal(:, node) = total
      end do
   end subroutine gather_vectors
end module hampm_nodal_fields
