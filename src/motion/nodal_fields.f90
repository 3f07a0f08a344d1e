!> What the grid carries during one step: one value a node, and the sums over the particles of each cell from which
!> the nodal values are gathered.
module hampm_nodal_fields
   use hampm_kinds, only: dp, ndim, corners
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t, element_of_slot
   use hampm_mass_matrix, only: mass_matrix_t, find_coupled_region, assemble, nodes_per_block
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: at_start, new, mapped, nodal_fields_t, new_nodal_fields, find_active_nodes, &
             gather_mass_and_momentum, gather_internal_force

   ! The velocities of a node during a step
   integer, parameter :: at_start = 1            !! v_i, mapped from the particles at the start of the step, (10)
   integer, parameter :: new = 2                 !! v_i + a_i dt, which moves the particles
   integer, parameter :: mapped = 3              !! mapped anew from the new velocities of the particles

   !> Arrays by node go on over the dependent points (`hampm_grid`): nodal values there are means of those of the nodes, and
   !> sums are given to the nodes.
   type :: nodal_fields_t
      type(mass_matrix_t) :: mass_matrix                !! M and D of the nodes of occupied cells
      real(dp), allocatable :: momentum(:, :)           !! right-hand side of (8) [kg m/s], (ndim, n_points)
      real(dp), allocatable :: force(:, :)              !! (7), internal and of the loads, without damping [N], (ndim, n_points)
      real(dp), allocatable :: acceleration(:, :)       !! a_i, (10) [m/s2], (ndim, n_points)
      real(dp), allocatable :: velocity(:, :, :)        !! `at_start`, `new` and `mapped` [m/s], (ndim, n_points, 3)
      real(dp), allocatable :: past(:, :, :)            !! last two accelerations without damping, where they are guessed;
                                                        !! (ndim, n_points, 2)
      ! Shares of the cells in the nodal sums, by corner and element as `node_slot` counts them; slot 0 stays zero
      real(dp), allocatable :: cell_mass(:)             !! share in D, (0:corners*n_elements)
      real(dp), allocatable :: cell_momentum(:, :)      !! share in `momentum`, (ndim, 0:corners*n_elements)
      real(dp), allocatable :: cell_force(:, :)         !! share of the internal force in `force`,
                                                        !! (ndim, 0:corners*n_elements)
      real(dp), allocatable :: cell_audit(:, :)         !! workspace of the sweeps for the audit, (2, n_elements)
      logical, allocatable :: is_active(:)              !! workspace of `find_active_nodes`, (n_points)
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
      associate (n => grid%n_points, m => grid%n_elements)
         allocate (f%is_active(n), f%mass_matrix%lumped(n), &
                   f%mass_matrix%all%nodes(n), f%mass_matrix%all%cells(m), f%momentum(ndim, n), &
                   f%force(ndim, n), f%acceleration(ndim, n), f%velocity(ndim, n, 3), f%cell_mass(0:corners*m), &
                   f%cell_momentum(ndim, 0:corners*m), f%cell_force(ndim, 0:corners*m), f%cell_audit(2, m), &
                   f%partial_power(2, n/nodes_per_block + 1), stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'grid: not enough memory for its nodes')
         return
      end if
      f%mass_matrix%lumped = 0
      f%momentum = 0
      f%force = 0
      f%acceleration = 0
      f%velocity = 0
      f%cell_mass = 0
      f%cell_momentum = 0
      f%cell_force = 0
   end subroutine new_nodal_fields

   !> After a sort: list the nodes of occupied cells, and clear what the cells and nodes without
   !> particles hold.
   subroutine find_active_nodes(grid, p, f)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(inout) :: f
      integer :: node, e, slot
      do e = 1, grid%n_elements
         if (p%count_in(e) > 0) cycle
         do slot = corners*(e - 1) + 1, corners*e
            f%cell_mass(slot) = 0
            f%cell_momentum(:, slot) = 0
            f%cell_force(:, slot) = 0
         end do
         if (allocated(f%mass_matrix%cell)) f%mass_matrix%cell(:, :, e) = 0
         if (allocated(f%mass_matrix%cell_inverse)) f%mass_matrix%cell_inverse(:, :, e) = 0
      end do
      do node = 1, grid%n_points
         f%is_active(node) = touches_particles(grid, p, node)
      end do
      do node = grid%n_nodes + 1, grid%n_points
         if (f%is_active(node)) call grid%dependents%mark_parents(node, f%is_active)
      end do
      associate (matrix => f%mass_matrix)
         matrix%all%n_cells = p%n_occupied
         matrix%all%cells(:p%n_occupied) = p%occupied(:p%n_occupied)
         matrix%all%n_points = 0
         do node = 1, grid%n_points
            if (f%is_active(node)) then
               matrix%all%n_points = matrix%all%n_points + 1
               matrix%all%nodes(matrix%all%n_points) = node
               if (node <= grid%n_nodes) matrix%all%n_nodes = matrix%all%n_points
            else
               matrix%lumped(node) = 0
               f%velocity(:, node, :) = 0
               f%acceleration(:, node) = 0
               if (allocated(f%past)) f%past(:, node, :) = 0
            end if
         end do
         call find_coupled_region(grid, matrix)
      end associate
   end subroutine find_active_nodes

   !> Whether some element around a point is occupied.
   pure logical function touches_particles(grid, p, point)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      integer, intent(in) :: point
      integer :: c, e
      touches_particles = .true.
      do c = 1, corners
         if (grid%node_slot(c, point) == 0) exit
         e = element_of_slot(grid%node_slot(c, point))
         if (p%count_in(e) > 0) return
      end do
      touches_particles = .false.
   end function touches_particles

   !> Sum the cells' shares of mass and momentum at each active node, always in the order of the cells, and those of the mass
   !> matrix where it has changed.
   subroutine gather_mass_and_momentum(grid, f)
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(inout) :: f
      associate (all => f%mass_matrix%all)
         call gather_motion(all%n_points, all%nodes, grid%node_slot, f%cell_mass, f%cell_momentum, f%mass_matrix%lumped, &
                            f%momentum)
         call grid%dependents%collect(all%nodes(all%n_nodes + 1:all%n_points), 1, f%mass_matrix%lumped)
         call grid%dependents%collect(all%nodes(all%n_nodes + 1:all%n_points), ndim, f%momentum)
      end associate
      call assemble(grid, f%cell_mass(1:), f%mass_matrix)
   end subroutine gather_mass_and_momentum

   !> Sum the cells' shares of the internal force at each active point. Those of dependent points are not yet given to the nodes.
   subroutine gather_internal_force(grid, f)
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(inout) :: f
      call gather_vectors(f%mass_matrix%all%n_points, f%mass_matrix%all%nodes, grid%node_slot, f%cell_force, f%force)
   end subroutine gather_internal_force

   !> Nodal masses and momenta from the cells' shares.
   subroutine gather_motion(n_active, active, node_slot, mass_share, momentum_share, mass, momentum)
      integer, intent(in) :: n_active, active(n_active) !! nodes to sum for
      integer, intent(in) :: node_slot(corners, *)
      real(dp), intent(in) :: mass_share(0:*), momentum_share(ndim, 0:*)  !! by slot, see `grid_t`
      real(dp), intent(inout) :: mass(*), momentum(ndim, *)               !! by node
      integer :: a, c, slot
      real(dp) :: m, p(ndim)
      !$omp parallel do schedule(static) private(m, p, c, slot)
      do a = 1, n_active
         m = 0
         p = 0
         do c = 1, corners
            slot = node_slot(c, active(a))
            m = m + mass_share(slot)
            p = p + momentum_share(:, slot)
         end do
         mass(active(a)) = m
         momentum(:, active(a)) = p
      end do
   end subroutine gather_motion

   !> Nodal vectors from the cells' shares.
   subroutine gather_vectors(n_active, active, node_slot, share, nodal)
      integer, intent(in) :: n_active, active(n_active) !! nodes to sum for
      integer, intent(in) :: node_slot(corners, *)
      real(dp), intent(in) :: share(ndim, 0:*)          !! by slot, see `grid_t`
      real(dp), intent(inout) :: nodal(ndim, *)         !! by node
      integer :: a, c
      real(dp) :: total(ndim)
      !$omp parallel do schedule(static) private(total, c)
      do a = 1, n_active
         total = 0
         do c = 1, corners
            total = total + share(:, node_slot(c, active(a)))
         end do
         nodal(:, active(a)) = total
      end do
   end subroutine gather_vectors
end module hampm_nodal_fields
