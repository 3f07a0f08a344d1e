!> The grid that is built from a forest: nodes, elements, and which element touches which node.
!> One element is one leaf of the forest, with the same index.
module hampm_grid
   use hampm_kinds, only: dp, ndim, corners
   use hampm_forest, only: forest_t
   use hampm_failure, only: failure_t, exit_computation
   implicit none
   private
   public :: grid_t, build_grid, element_of_slot, corner_of_slot

   type :: grid_t
      type(forest_t) :: forest                          !! what the grid was built from
      integer :: n_nodes = 0
      integer :: n_elements = 0
      real(dp), allocatable :: node_position(:, :)      !! [m], (ndim, n_nodes)
      real(dp), allocatable :: element_lower(:, :)      !! lower corner [m], (ndim, n_elements)
      real(dp), allocatable :: element_size(:)          !! edge length [m], (n_elements)
      integer, allocatable :: element_nodes(:, :)       !! node of each corner, (corners, n_elements)
      integer, allocatable :: node_slot(:, :)           !! the corners of elements at which a node stands, in the order of the
                                                        !! elements: corner + corners (element - 1), 0 where there are
                                                        !! fewer; (corners, n_nodes)
   contains
      procedure :: node_at
      procedure :: local_coordinate
   end type grid_t

contains

   !> Build the grid of a forest. Fails where the memory does not suffice.
   subroutine build_grid(forest, grid, failure)
      type(forest_t), intent(in) :: forest
      type(grid_t), intent(out) :: grid
      type(failure_t), intent(inout) :: failure
      integer :: status
      grid%forest = forest
      grid%n_nodes = product(forest%cells + 1)
      grid%n_elements = forest%leaf_count()
      allocate (grid%node_position(ndim, grid%n_nodes), grid%element_lower(ndim, grid%n_elements), &
                grid%element_size(grid%n_elements), grid%element_nodes(corners, grid%n_elements), &
                grid%node_slot(corners, grid%n_nodes), stat=status)
      if (status /= 0) then
         call failure%report(exit_computation, 'grid: not enough memory for this number of cells')
         return
      end if
      call place_elements(grid)
      call connect_nodes(grid)
   end subroutine build_grid

   !> Elements and nodes from the lattice. Nodes are numbered along x first.
   subroutine place_elements(grid)
      type(grid_t), intent(inout) :: grid
      integer :: e, corner, lower(ndim), c(ndim), node
      do e = 1, grid%n_elements
         lower = grid%forest%coordinates(e)
         grid%element_lower(:, e) = grid%forest%corner_position(lower)
         grid%element_size(e) = grid%forest%cell
         do corner = 1, corners
            c = lower + corner_offset(corner)
            node = lattice_node(grid%forest, c)
            grid%element_nodes(corner, e) = node
            grid%node_position(:, node) = grid%forest%corner_position(c)
         end do
      end do
   end subroutine place_elements

   !> For each node the corners of elements at which it stands.
   subroutine connect_nodes(grid)
      type(grid_t), intent(inout) :: grid
      integer :: e, corner, k
      grid%node_slot = 0
      do e = 1, grid%n_elements
         do corner = 1, corners
            associate (slots => grid%node_slot(:, grid%element_nodes(corner, e)))
               k = count(slots > 0) + 1
               slots(k) = corner + corners*(e - 1)
            end associate
         end do
      end do
   end subroutine connect_nodes

   !> The node that stands at the place `x`, within a millionth of a cell; 0 where none does.
   pure integer function node_at(self, x)
      class(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! place [m]
      real(dp) :: lattice(ndim)
      node_at = 0
      lattice = (x - self%forest%lower)/self%forest%cell
      if (any(.not. (lattice > -0.5_dp .and. lattice < self%forest%cells + 0.5_dp))) return
      if (any(abs(lattice - anint(lattice)) > 1.0e-6_dp)) return
      node_at = lattice_node(self%forest, nint(lattice))
   end function node_at

   !> Element of an entry of `node_slot`.
   pure integer function element_of_slot(slot) result(e)
      integer, intent(in) :: slot
      e = (slot + corners - 1)/corners
   end function element_of_slot

   !> Corner of an entry of `node_slot`.
   pure integer function corner_of_slot(slot) result(corner)
      integer, intent(in) :: slot
      corner = mod(slot - 1, corners) + 1
   end function corner_of_slot

   !> Local coordinate of the place `x` in element `e`, in [0, 1] inside it.
   pure function local_coordinate(self, e, x) result(xi)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: x(ndim)            !! place [m]
      real(dp) :: xi(ndim)
      xi = (x - self%element_lower(:, e))/self%element_size(e)
   end function local_coordinate

   !> Number of the node with integer coordinates `c`.
   pure integer function lattice_node(forest, c)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: c(ndim)
      integer :: d
      lattice_node = 0
      do d = ndim, 1, -1
         lattice_node = lattice_node*(forest%cells(d) + 1) + c(d)
      end do
      lattice_node = lattice_node + 1
   end function lattice_node

   !> Which corner: 0 on the lower and 1 on the upper side in each direction.
   pure function corner_offset(corner) result(offset)
      integer, intent(in) :: corner
      integer :: offset(ndim)
      integer :: d
      do d = 1, ndim
         offset(d) = ibits(corner - 1, d - 1, 1)
      end do
   end function corner_offset
end module hampm_grid
