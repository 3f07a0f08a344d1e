!> What the grid carries during one step: one value a node, and the sums over the particles of each cell from which
!> the nodal values are gathered.
module hampm_nodal_fields
   use hampm_kinds, only: dp, ndim, corners
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t, element_of_slot, corner_of_slot
   use hampm_large_pages, only: prefer_large_pages
   use hampm_mass_matrix, only: mass_matrix_t, find_coupled_region, invert_lumped, assemble, nodes_per_block
   use hampm_particles, only: particles_t, lanes
   implicit none
   private
   public :: nodal_fields_t, new_nodal_fields, find_active_nodes, gather, around, at_start, new, mapped, mass_share, &
             momentum_share, force_share, shares, stride

   ! The velocities of a node during a step
   integer, parameter :: at_start = 1            !! v_i, mapped from the particles at the start of the step, (10)
   integer, parameter :: new = 2                 !! v_i + a_i dt, which moves the particles
   integer, parameter :: mapped = 3              !! mapped anew from the new velocities of the particles

   ! The shares of a cell's corners in nodal sums
   integer, parameter :: mass_share = 1
   integer, parameter :: momentum_share = 2                     !! the first component
   integer, parameter :: force_share = momentum_share + ndim    !! the first component
   integer, parameter :: shares = force_share + ndim - 1
   integer, parameter :: stride = lanes*corners                 !! in `share` from one to the next

   !> Arrays by node go on over the dependent points (`hampm_grid`): nodal values there are means of those of the nodes, and
   !> sums are given to the nodes.
   type :: nodal_fields_t
      type(mass_matrix_t) :: mass_matrix                !! M and D of the nodes of occupied cells
      real(dp), allocatable :: momentum(:, :)           !! right-hand side of (8) [kg m/s], (ndim, n_points)
      real(dp), allocatable :: force(:, :)              !! (7), internal and of the loads, without damping [N], (ndim, n_points)
      real(dp), allocatable :: external(:, :)           !! force of the loads, where it is kept apart [N], (ndim, n_points)
      real(dp), allocatable :: acceleration(:, :)       !! a_i, (10) [m/s2], (ndim, n_points)
      real(dp), allocatable :: velocity(:, :, :)        !! `at_start`, `new` and `mapped` [m/s], (ndim, n_points, 3)
      real(dp), allocatable :: past(:, :, :)            !! last two accelerations without damping, where they are guessed;
                                                        !! (ndim, n_points, 2)
      ! The cells in blocks (`hampm_particles`), and their shares in the nodal sums
      integer :: layout = 0                             !! how often the blocks have changed
      integer :: n_blocks = 0
      integer, allocatable :: block_cells(:, :)         !! elements of each block, 0 for none, (lanes, n_blocks)
      integer, allocatable :: block_nodes(:, :, :)      !! points at the corners of the cells, those of another cell where there is
                                                        !! none; (corners, lanes, n_blocks)
      logical, allocatable :: in_row(:)                 !! whether these points are two rows, lower and upper, each numbered on;
                                                        !! (n_blocks)
      real(dp), allocatable :: block_lower(:, :, :)     !! lower corners of the cells [m], (lanes, ndim, n_blocks)
      real(dp), allocatable :: block_inverse_size(:, :) !! 1 / edge length of the cells [1/m], (lanes, n_blocks)
      real(dp), allocatable :: share(:, :, :, :)        !! of mass, momentum and internal force: `mass_share` and so on;
                                                        !! (lanes, corners, shares, 0:n_blocks), of block 0 always zero
      integer, allocatable :: slot(:, :)                !! where in `share` the masses of the cells around a point stand, in
                                                        !! the order of the cells; (corners, n_points)
      logical, allocatable :: left(:)                   !! whether a particle has left its cell, (n_blocks)
      real(dp), allocatable :: audit(:, :)              !! sums of the sweeps for the audit, (2, n_blocks)
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
         allocate (f%is_active(n), f%mass_matrix%lumped(n), f%mass_matrix%inverse_lumped(n), &
                   f%mass_matrix%all%nodes(n), f%mass_matrix%all%cells(m), f%momentum(ndim, n), &
                   f%force(ndim, n), f%external(ndim, n), f%acceleration(ndim, n), f%velocity(ndim, n, 3), f%slot(corners, n), &
                   f%partial_power(2, n/nodes_per_block + 1), stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'grid: not enough memory for its nodes')
         return
      end if
      f%mass_matrix%lumped = 0
      f%mass_matrix%inverse_lumped = 0
      f%momentum = 0
      f%force = 0
      f%external = 0
      f%acceleration = 0
      f%velocity = 0
   end subroutine new_nodal_fields

   !> After a sort, if it has changed the blocks: list the nodes of occupied cells, and clear what the cells and nodes without
   !> particles hold. Fails where the memory does not suffice.
   subroutine find_active_nodes(grid, p, f, failure)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(inout) :: f
      type(failure_t), intent(inout) :: failure
      integer :: node, e
      if (f%n_blocks == p%n_blocks) then
         if (all(f%block_cells(:, :f%n_blocks) == p%block_cells(:, :p%n_blocks))) return
      end if
      call fit_blocks(p%n_blocks, f, failure)
      if (failure%failed()) return
      call place_blocks(grid, p, f)
      do e = 1, grid%n_elements
         if (p%count_in(e) > 0) cycle
         if (allocated(f%mass_matrix%cell)) f%mass_matrix%cell(:, :, e) = 0
         if (allocated(f%mass_matrix%cell_lumped)) f%mass_matrix%cell_lumped(:, e) = 0
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

   !> Room for a number of blocks.
   subroutine fit_blocks(n_blocks, f, failure)
      integer, intent(in) :: n_blocks
      type(nodal_fields_t), intent(inout) :: f
      type(failure_t), intent(inout) :: failure
      integer :: n, status
      if (allocated(f%left)) then
         if (size(f%left) >= n_blocks) return
         deallocate (f%block_cells, f%block_nodes, f%in_row, f%block_lower, f%block_inverse_size, f%share, f%left, f%audit)
      end if
      n = n_blocks + n_blocks/8
      allocate (f%block_cells(lanes, n), f%block_nodes(corners, lanes, n), f%in_row(n), f%block_lower(lanes, ndim, n), &
                f%block_inverse_size(lanes, n), f%share(lanes, corners, shares, 0:n), f%left(n), f%audit(2, n), stat=status)
      if (status /= 0) then
         call failure%report(exit_computation, 'grid: not enough memory for its cells')
         return
      end if
      call prefer_large_pages(size(f%share), f%share)
      f%share = 0
      f%left = .false.
      f%audit = 0
   end subroutine fit_blocks

   !> Where the cells of the blocks are, and where around each point their shares stand.
   subroutine place_blocks(grid, p, f)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(inout) :: f
      integer, allocatable :: first_slot(:)
      integer :: b, l, e, point, c, k
      allocate (first_slot(grid%n_elements), source=0)
      f%layout = f%layout + 1
      f%n_blocks = p%n_blocks
      f%block_cells(:, :p%n_blocks) = p%block_cells(:, :p%n_blocks)
      do b = 1, p%n_blocks
         do l = 1, lanes
            e = p%block_cells(l, b)
            if (e > 0) then
               first_slot(e) = stride*shares*b + l
            else
               e = p%block_cells(1, b)
            end if
            f%block_nodes(:, l, b) = grid%element_nodes(:, e)
            f%block_lower(l, :, b) = grid%element_lower(:, e)
            f%block_inverse_size(l, b) = 1/grid%element_size(e)
         end do
         f%in_row(b) = are_in_row(f%block_nodes(:, :, b))
      end do
      do point = 1, grid%n_points
         do c = 1, corners
            k = grid%node_slot(c, point)
            f%slot(c, point) = 1
            if (k == 0) cycle
            e = first_slot(element_of_slot(k))
            if (e > 0) f%slot(c, point) = e + lanes*(corner_of_slot(k) - 1)
         end do
      end do
   end subroutine place_blocks

   !> Whether the points of a block are those of cells side by side whose lower and upper points are each numbered on.
   pure logical function are_in_row(nodes)
      integer, intent(in) :: nodes(corners, lanes)
      integer :: l
      are_in_row = .true.
      do l = 1, lanes
         are_in_row = are_in_row .and. all(nodes(1:2, l) == nodes(1, 1) + [l - 1, l]) &
                      .and. all(nodes(3:4, l) == nodes(3, 1) + [l - 1, l])
      end do
   end function are_in_row

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

   !> Sum the cells' shares at each active point, always in the order of the cells: those of mass and mass matrix, of momentum,
   !> and of the internal force. Forces on dependent points are not yet given to the nodes.
   subroutine gather(grid, f, mass, momentum, force)
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(inout) :: f
      logical, intent(in) :: mass, momentum, force
      associate (matrix => f%mass_matrix, all => f%mass_matrix%all)
         call gather_shares(all%n_points, all%nodes, f%slot, f%share, mass, momentum, force, matrix%lumped, f%momentum, f%force)
         associate (points => all%nodes(all%n_nodes + 1:all%n_points))
            if (mass) call grid%dependents%collect(points, 1, matrix%lumped)
            if (momentum) call grid%dependents%collect(points, ndim, f%momentum)
         end associate
         if (mass) call invert_lumped(matrix)
         if (mass) call assemble(grid, matrix)
      end associate
   end subroutine gather

   !> Nodal sums from the cells' shares.
   subroutine gather_shares(n_active, active, slot, share, with_mass, with_momentum, with_force, mass, momentum, force)
      integer, intent(in) :: n_active, active(n_active) !! points to sum for
      integer, intent(in) :: slot(corners, *)
      real(dp), intent(in) :: share(*)
      logical, intent(in) :: with_mass, with_momentum, with_force
      real(dp), intent(inout) :: mass(*), momentum(ndim, *), force(ndim, *)  !! by point
      integer, parameter :: to_momentum = stride*(momentum_share - mass_share), to_force = stride*(force_share - mass_share)
      integer :: a, i, k1, k2, k3, k4
      !$omp parallel do schedule(static) private(i, k1, k2, k3, k4)
      !GCC$ novector
      do a = 1, n_active
         i = active(a)
         k1 = slot(1, i)
         k2 = slot(2, i)
         k3 = slot(3, i)
         k4 = slot(4, i)
         if (with_mass) mass(i) = around(share, k1, k2, k3, k4)
         if (with_momentum) then
            momentum(1, i) = around(share(1 + to_momentum), k1, k2, k3, k4)
            momentum(2, i) = around(share(1 + to_momentum + stride), k1, k2, k3, k4)
         end if
         if (with_force) then
            force(1, i) = around(share(1 + to_force), k1, k2, k3, k4)
            force(2, i) = around(share(1 + to_force + stride), k1, k2, k3, k4)
         end if
      end do
   end subroutine gather_shares

   !> Sum of the shares of the cells around a point.
   pure real(dp) function around(share, k1, k2, k3, k4)
      real(dp), intent(in) :: share(*)
      integer, intent(in) :: k1, k2, k3, k4             !! where they stand
      around = ((share(k1) + share(k2)) + share(k3)) + share(k4)
   end function around
end module hampm_nodal_fields
