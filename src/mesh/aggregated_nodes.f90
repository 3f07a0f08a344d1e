!> Aggregated nodes: nodes of cells that the edge of a body leaves nearly empty (docs/explanation/shapes.md).
!>
!> A node with next to no mass would need arbitrarily short explicit steps and a badly conditioned stiffness. A node that belongs to
!> no cell filled by a part `least_fill` at least has no degrees of freedom: it hangs on the nodes of a fuller cell beside one of
!> its own, by the extrapolated shape functions of that cell, or else on the root cell of a neighbour, as at a sharp corner. Of
!> equally full or near cells it takes the one towards the material: mirror images agree. Displacements stay continuous, linear ones
!> exact. Cells beside cells of another size, and cut cells and their neighbours, keep their nodes. Beside a crack along the grid a
!> node has a copy for each face, which hangs on its own side; ahead of it one as near to cells on both sides hangs on both.
!>
!> Source: Badia, Verdugo & Martin, The aggregated unfitted finite element method for elliptic problems, Computer Methods in Applied
!> Mechanics and Engineering 336 (2018) 533-553.
module hampm_aggregated_nodes
   use hampm_kinds, only: dp, ndim, corners, neighbours, long
   use hampm_tensors, only: norm
   use hampm_basis, only: shape_functions
   use hampm_cut_cells, only: cut_cells_t, place_of_copy
   use hampm_forest, only: forest_t, outside, corner_offset, level_width
   use hampm_plane_cuts, only: plane_cut_t, seen_beside
   use hampm_outline, only: outline_t, least_part
   use hampm_place_table, only: place_table_t
   use hampm_tolerance, only: part_of_cell
   implicit none
   private
   public :: aggregated_nodes_t, find_aggregated_nodes, least_fill

   !> Part of a cell that has to be filled for its nodes to be free.
   real(dp), parameter :: least_fill = 0.25_dp
   integer :: k, d
   real(dp), parameter :: longer(ndim) = [(1 + merge(0.0_dp, 1e-6_dp*(d - 1), ndim == 2), d=1, ndim)]
   !> Steps to the cells beside the sides of one: in the plane down, left, right and up.
   integer, parameter :: sides(ndim, 2*ndim) = reshape([((merge(merge(-1, 1, k <= ndim), 0, &
      d == merge(ndim + 1 - k, k - ndim, k <= ndim)), d=1, ndim), k=1, 2*ndim)], [ndim, 2*ndim])

   !> Which places are aggregated nodes, and the leaf on whose nodes each hangs.
   type :: aggregated_nodes_t
      type(place_table_t) :: places              !! as the leaves see them
      integer, allocatable :: root_cell(:, :)    !! by number of the place in the table; two, the second 0, but ahead of a crack
      integer, allocatable, private :: root_cell_of_leaf(:) !! of each nearly empty leaf whose nodes may hang, 0 of others
   contains
      procedure :: are_there
      procedure :: number_at
      procedure :: has_root_cell
      procedure :: weights
   end type aggregated_nodes_t

contains

   !> Whether there are any.
   pure logical function are_there(self)
      class(aggregated_nodes_t), intent(in) :: self
      are_there = self%places%n > 0
   end function are_there

   !> Number of the aggregated node at a place, 0 where none is.
   pure integer function number_at(self, place) result(number)
      class(aggregated_nodes_t), intent(in) :: self
      integer(long), intent(in) :: place(ndim)
      number = 0
      if (self%places%n > 0) number = self%places%number_of(place)
   end function number_at

   !> Whether a leaf is nearly empty and its aggregated nodes hang.
   pure logical function has_root_cell(self, leaf)
      class(aggregated_nodes_t), intent(in) :: self
      integer, intent(in) :: leaf
      has_root_cell = .false.
      if (allocated(self%root_cell_of_leaf)) has_root_cell = self%root_cell_of_leaf(leaf) > 0
   end function has_root_cell

   !> Weights of the corners of a root cell of an aggregated node.
   pure function weights(self, forest, number, which, place) result(weight)
      class(aggregated_nodes_t), intent(in) :: self
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: number, which       !! of the node, and of its root cell
      integer(long), intent(in) :: place(ndim)   !! where it is
      real(dp) :: weight(corners)
      associate (leaf => self%root_cell(which, number))
         weight = shape_functions(real(place - forest%place_of(leaf), dp)/level_width(forest%level_of(leaf)))
      end associate
   end function weights

   !> Find the aggregated nodes of a forest in which there are some bodies.
   pure subroutine find_aggregated_nodes(forest, cut_cells, planes, bodies, aggregated)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(in) :: cut_cells
      type(plane_cut_t), allocatable, intent(in) :: planes(:) !! with their open nodes
      type(outline_t), intent(in) :: bodies(:)
      type(aggregated_nodes_t), intent(out) :: aggregated
      real(dp) :: fill(forest%leaf_count()), centre(ndim, forest%leaf_count())
      logical :: may_hang(forest%leaf_count())
      integer :: leaf, c, status
      integer, dimension(forest%leaf_count()) :: root_cells, before
      do leaf = 1, size(fill)
         call find_root_cell(forest, bodies, leaf, fill(leaf), centre(:, leaf))
      end do
      root_cells = 0
      may_hang = [(fill(leaf) > 0 .and. fill(leaf) < least_fill, leaf=1, size(fill))]
      do leaf = 1, size(fill)
         if (may_hang(leaf)) may_hang(leaf) = is_among_alike(forest, cut_cells, fill, leaf)
         if (may_hang(leaf)) root_cells(leaf) = root_cell_of(forest, cut_cells, planes, fill, centre(:, leaf), leaf)
      end do
      do
         before = root_cells
         do leaf = 1, size(fill)
            if (may_hang(leaf) .and. before(leaf) == 0) &
               root_cells(leaf) = root_cell_of_next(forest, cut_cells, planes, before, centre(:, leaf), leaf)
         end do
         if (all(root_cells == before)) exit
      end do
      if (all(root_cells == 0)) return
      allocate (aggregated%root_cell_of_leaf, source=root_cells)
      call aggregated%places%reserve(corners*count(root_cells > 0), status)
      allocate (aggregated%root_cell(2, corners*count(root_cells > 0)), source=0)
      do leaf = 1, size(fill)
         if (root_cells(leaf) == 0) cycle
         do c = 1, corners
            call add_corner(forest, cut_cells, planes, fill, centre, root_cells, &
                            forest%place_of(leaf) + corner_offset(c)*level_width(forest%level_of(leaf)), &
                            leaf, aggregated)
         end do
      end do
   end subroutine find_aggregated_nodes

   !> Filled part of a leaf, and the centre of its material.
   pure subroutine find_root_cell(forest, bodies, leaf, fill, centre)
      type(forest_t), intent(in) :: forest
      type(outline_t), intent(in) :: bodies(:)
      integer, intent(in) :: leaf
      real(dp), intent(out) :: fill              !! [-]
      real(dp), intent(out) :: centre(ndim)      !! [m]
      real(dp) :: m(0:ndim), of_body(0:ndim)
      integer :: k
      m = 0
      associate (lower => forest%position(forest%place_of(leaf)), size_of => forest%size_of(leaf))
         do k = 1, size(bodies)
            of_body = bodies(k)%moments(lower, lower + size_of)
            if (of_body(0) > 0) m = m + of_body
         end do
         fill = part_of_cell(m(0)/size_of**ndim)
      end associate
      centre = forest%middle_of(leaf)
      if (fill > 0) centre = forest%position(forest%place_of(leaf)) + m(1:)/m(0)
      if (fill < least_part*0.1_dp) fill = 0
   end subroutine find_root_cell

   !> Whether all leaves around one are of its size, in solids those with material, and no crack cuts them.
   pure logical function is_among_alike(forest, cut_cells, fill, leaf) result(is)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(in) :: cut_cells
      real(dp), intent(in) :: fill(:)
      integer, intent(in) :: leaf
      integer :: next, i, d
      is = .true.
      do i = 0, neighbours - 1
         next = neighbour(forest, leaf, [(mod(i/3**(d - 1), 3) - 1, d=1, ndim)])
         if (next == outside) cycle
         if (ndim > 2 .and. .not. fill(next) > 0) cycle
         is = is .and. forest%level_of(next) == forest%level_of(leaf) .and. cut_cells%pieces_of(next) == 1
      end do
   end function is_among_alike

   !> The leaf beside one of the sides of a nearly empty one that is fullest, and full enough; 0 for none.
   pure integer function root_cell_of(forest, cut_cells, planes, fill, centre, leaf) result(root_cell)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(in) :: cut_cells
      type(plane_cut_t), allocatable, intent(in) :: planes(:)
      real(dp), intent(in) :: fill(:)
      real(dp), intent(in) :: centre(ndim)       !! of its material [m]
      integer, intent(in) :: leaf
      integer :: next, side
      root_cell = 0
      do side = 1, size(sides, 2)
         next = neighbour(forest, leaf, sides(:, side))
         if (next == outside) cycle
         if (fill(next) < least_fill .or. is_parted(forest, cut_cells, planes, leaf, next)) cycle
         if (root_cell > 0) then
            if (.not. is_first(-fill(next), -fill(root_cell), distance_to(forest, next, centre), &
                               distance_to(forest, root_cell, centre))) cycle
         end if
         root_cell = next
      end do
      if (is_across(forest, cut_cells, leaf, root_cell)) root_cell = 0
   end function root_cell_of

   !> The root cell of a leaf beside one of the sides of a nearly empty one, the nearest of them; 0 for none.
   pure integer function root_cell_of_next(forest, cut_cells, planes, root_cells, centre, leaf) result(root_cell)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(in) :: cut_cells
      type(plane_cut_t), allocatable, intent(in) :: planes(:)
      integer, intent(in) :: root_cells(:)
      real(dp), intent(in) :: centre(ndim)       !! of its material [m]
      integer, intent(in) :: leaf
      integer :: next, side
      root_cell = 0
      do side = 1, size(sides, 2)
         next = neighbour(forest, leaf, sides(:, side))
         if (next == outside) cycle
         if (root_cells(next) == 0 .or. is_parted(forest, cut_cells, planes, leaf, next)) cycle
         if (is_across(forest, cut_cells, leaf, root_cells(next))) cycle
         if (root_cell > 0) then
            associate (x => forest%middle_of(leaf), other => root_cells(next))
               if (.not. is_first(distance_to(forest, other, x), distance_to(forest, root_cell, x), &
                                  distance_to(forest, other, centre), distance_to(forest, root_cell, centre))) cycle
            end associate
         end if
         root_cell = root_cells(next)
      end do
   end function root_cell_of_next

   !> Whether one of two comes first: by the first pair of numbers, or by the second if these are equal up to rounding.
   pure logical function is_first(one, other, one_else, other_else)
      real(dp), intent(in) :: one, other         !! the smaller one is first
      real(dp), intent(in) :: one_else, other_else
      real(dp), parameter :: same = 1e-9_dp
      is_first = one < other - same*abs(other)
      if (abs(one - other) <= same*abs(other)) is_first = one_else < other_else - same*abs(other_else)
   end function is_first

   !> Distance of the middle of a leaf from a place [m], in solids a little longer in y and in z than along x: of two equally near
   !> in two directions a mirror image takes the same one.
   pure real(dp) function distance_to(forest, leaf, x) result(distance)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      real(dp), intent(in) :: x(ndim)            !! [m]
      distance = norm((forest%middle_of(leaf) - x)*longer)
   end function distance_to

   !> Whether a crack is between two leaves.
   pure logical function is_across(forest, cut_cells, leaf, other)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(in) :: cut_cells
      integer, intent(in) :: leaf, other         !! 0 for none
      is_across = .false.
      if (other > 0 .and. cut_cells%are_there()) is_across = cut_cells%divide(forest%middle_of(leaf), forest%middle_of(other))
   end function is_across

   !> Whether a crack along a line or plane of the grid is open between two leaves of one size, one beside the other.
   pure logical function is_parted(forest, cut_cells, planes, leaf, other)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(in) :: cut_cells
      type(plane_cut_t), allocatable, intent(in) :: planes(:)
      integer, intent(in) :: leaf, other
      integer(long) :: place(ndim)
      integer :: c
      is_parted = .false.
      if (.not. (allocated(planes) .or. cut_cells%are_there())) return
      do c = 1, corners
         place = forest%place_of(leaf) + corner_offset(c)*level_width(forest%level_of(leaf))
         if (any(place < forest%place_of(other) .or. &
                 place > forest%place_of(other) + level_width(forest%level_of(other)))) cycle
         is_parted = any(seen_from(forest, cut_cells, planes, leaf, place) /= seen_from(forest, cut_cells, planes, other, place))
         if (is_parted) return
      end do
   end function is_parted

   !> Place of a node as a leaf of one piece sees it: that of its copy beside a crack.
   pure function seen_from(forest, cut_cells, planes, leaf, place) result(seen)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(in) :: cut_cells
      type(plane_cut_t), allocatable, intent(in) :: planes(:)
      integer, intent(in) :: leaf
      integer(long), intent(in) :: place(ndim)
      integer(long) :: seen(ndim)
      seen = place
      if (cut_cells%are_there()) seen = place_of_copy(place, cut_cells%copy_at(forest, place, leaf, 1))
      if (allocated(planes)) seen = seen_beside(planes, forest, leaf, place)
   end function seen_from

   !> The leaf so many leaves of this size away; `outside` if there is none.
   pure integer function neighbour(forest, leaf, steps) result(next)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf, steps(ndim)
      next = forest%leaf_at(forest%middle_of(leaf) + steps*forest%size_of(leaf))
   end function neighbour

   !> Record a corner of a nearly empty leaf, if all leaves around it are (nearly) empty, with the nearest of their root cells: of
   !> those that see the same copy of it.
   pure subroutine add_corner(forest, cut_cells, planes, fill, centre, root_cells, place, leaf, aggregated)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(in) :: cut_cells
      type(plane_cut_t), allocatable, intent(in) :: planes(:)
      real(dp), intent(in) :: fill(:)
      real(dp), intent(in) :: centre(:, :)       !! of the material in each leaf [m]
      integer, intent(in) :: root_cells(:)
      integer(long), intent(in) :: place(ndim)   !! of the corner
      integer, intent(in) :: leaf
      type(aggregated_nodes_t), intent(inout) :: aggregated
      real(dp) :: middle(ndim), filled
      integer(long) :: seen(ndim)
      integer :: around(corners), c, root_cell, twin, number
      seen = seen_from(forest, cut_cells, planes, leaf, place)
      root_cell = 0
      middle = 0
      filled = 0
      do c = 1, corners
         around(c) = forest%leaf_at(forest%position(place) + (corner_offset(c) - 0.5_dp)*forest%size_of(leaf))
         if (around(c) == outside) cycle
         if (.not. fill(around(c)) > 0) around(c) = outside
         if (around(c) == outside) cycle
         if (any(seen_from(forest, cut_cells, planes, around(c), place) /= seen)) around(c) = outside
         if (around(c) == outside) cycle
         if (root_cells(around(c)) == 0) return
         middle = middle + fill(around(c))*centre(:, around(c))
         filled = filled + fill(around(c))
      end do
      middle = middle/filled
      do c = 1, corners
         if (around(c) == outside) cycle
         if (root_cell > 0) then
            if (.not. is_nearer(root_cells(around(c)), root_cell)) cycle
         end if
         root_cell = root_cells(around(c))
      end do
      twin = 0
      do c = 1, corners
         if (around(c) == outside) cycle
         associate (other => root_cells(around(c)))
            if (.not. is_nearer(root_cell, other) .and. is_parted(forest, cut_cells, planes, root_cell, other)) twin = other
         end associate
      end do
      call aggregated%places%enter(seen, number)
      aggregated%root_cell(:, number) = [root_cell, twin]

   contains

      !> Whether one cell is nearer to the corner than another, or as near and nearer to the material.
      pure logical function is_nearer(one, other)
         integer, intent(in) :: one, other       !! leaves
         associate (x => forest%position(place))
            is_nearer = is_first(distance_to(forest, one, x), distance_to(forest, other, x), &
                                 distance_to(forest, one, middle), distance_to(forest, other, middle))
         end associate
      end function is_nearer
   end subroutine add_corner
end module hampm_aggregated_nodes
