!> The grid that is built from a forest: nodes, elements, and which element touches which node.
!>
!> A leaf is one bilinear element of four nodes, the corners. A leaf beside which there are finer ones has up to four nodes
!> more, in the middle of its sides: it is a transition element, of 5 to 8 nodes. Its shape functions are bilinear in each
!> quarter: on a side they are piecewise linear through the nodes, as the finer cells have them, and in the middle the value
!> is the mean of those at the middles of the four sides. They are continuous across every kind of edge, sum to 1, are 1 at
!> their own node and 0 at the others, hold every linear field, and are nowhere negative. (The transition element of Gupta 1978
!> blends the side functions linearly to the opposite side, which gives the middle the weights of its nodes twice as strongly:
!> its corner functions are negative inside, and with them lumped masses may be.)
!>
!> So a transition leaf is stored as its four quarters, each a bilinear element like any other. Corners of quarters at which none of
!> its nodes stands are hanging nodes (`hampm_dofs`), numbered on from the nodes. A kernel that visits elements need not know
!> which is which. Nodes of cells that are nearly empty hang, too (`hampm_aggregated_nodes`).
!>
!> A leaf that a line divides (`hampm_cut_cells`) has an element, or four quarters, for each of its pieces, and its nodes have copies; along a line on
!> a grid line there are nodes on either side, at one position.
!>
!> Where cells are quadratic, of order 2, every leaf is stored as its quarters, and all corners of these, nine, are nodes of the leaf. Its
!> functions are biquadratic: values in an element depend on all points of its leaf, its support. Beside a coarser leaf with material
!> the node in the middle of a side hangs, so that the side has the quadratic through the three nodes of the coarser one, of which it is a
!> half. The weights of its masters are 3/8, 3/4 and -1/8, and the lumped masses stay positive: what the last one takes from an end of
!> the coarser side is less than what the leaf beside it gives.
!>
!> Where bodies have velocity fields of their own, to meet and part (`hampm_body_contact`), each field is a sheet: all leaves have the
!> same elements, or quarters, or pieces of these, once more for each sheet, and all nodes a copy on each. Those of a leaf follow each
!> other, sheet after sheet. A particle stands in an element of the sheet of its body. Cracks are on the first sheet only: on others the pieces of
!> a leaf have the same nodes.
module hampm_grid
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_basis, only: points_of_quadratic, quarter_of_point, corner_of_point, shape_functions, shape_gradients, &
                          quadratic_functions, quadratic_gradients
   use hampm_cut_cells, only: cut_cells_t, line_t, find_cut_cells, place_of_copy
   use hampm_dofs, only: dofs_t, element_of_slot, corner_of_slot, most_nodes_of_leaf
   use hampm_forest, only: forest_t, outside, corner_offset, level_width
   use hampm_failure, only: failure_t, exit_computation
   use hampm_aggregated_nodes, only: aggregated_nodes_t, find_aggregated_nodes
   use hampm_outline, only: outline_t, least_part
   use hampm_place_table, only: place_table_t
   implicit none
   private
   public :: grid_t, build_grid, is_toward, side_corner

   integer, parameter :: sides = 2*ndim

   !> Nodes and elements of a forest.
   type :: grid_t
      type(forest_t) :: forest                          !! what the grid was built from
      type(cut_cells_t) :: cut_cells                    !! and where it was cut then
      type(outline_t), allocatable :: bodies(:)         !! in it, where edges of bodies may cut cells; else not allocated
      logical, allocatable :: is_full(:)                !! whether one of them fills each leaf; not allocated where there are none, (leaves)
      logical, allocatable :: is_met(:)                 !! whether any of them has a part of each leaf; as above, (leaves)
      type(aggregated_nodes_t) :: aggregated_nodes      !! of cells that these nearly leave empty
      integer, allocatable :: field_of_body(:)          !! the sheet on which each body is; not allocated where there is one only
      integer :: n_velocity_fields = 1
      real(dp), allocatable :: solids(:, :, :)          !! corners of the rectangles that are filled with material, where cells are
                                                        !! quadratic; else not allocated [m], (ndim, 2, number)
      integer :: n_functions = corners                  !! shape functions in an element
      real(dp), allocatable :: correction(:, :, :)      !! of the gradients of functions in quadratic cells, or pieces of them, that are cut
                                                        !! (`hampm_quadratic_points`); not allocated where none are [1/m],
                                                        !! (functions, ndim, cells)
      integer :: n_nodes = 0                            !! number of nodes with degrees of freedom
      integer :: n_points = 0                           !! number of nodes, hanging nodes included
      integer :: n_elements = 0
      real(dp) :: finest_cell = 0                       !! size of the smallest leaf [m]
      real(dp), allocatable :: node_position(:, :)      !! [m], (ndim, n_points)
      real(dp), allocatable :: element_lower(:, :)      !! lower corner [m], (ndim, n_elements)
      real(dp), allocatable :: element_size(:)          !! edge length [m], (n_elements)
      integer, allocatable :: element_nodes(:, :)       !! node at each corner, (corners, n_elements)
      integer, allocatable :: element_leaf(:)           !! leaf of which it is the whole or a quarter, or a piece of these, (n_elements)
      integer, allocatable :: leaf_element(:)           !! first element of each leaf, (leaves + 1)
      type(dofs_t) :: dofs                              !! which nodes hang and on which others, and the elements around each
   contains
      procedure :: node_at
      procedure :: has_element_toward
      procedure :: element_at
      procedure :: element_on_side
      procedure :: element_of_face
      procedure :: local_coordinate
      procedure :: is_transition
      procedure :: quarters_of
      procedure :: is_piece
      procedure :: piece_of
      procedure :: first_of_piece
      procedure :: last_of_piece
      procedure :: leaf_size
      procedure :: smallest_leaf_at
      procedure :: velocity_field_of
      procedure :: copy_on
      procedure :: is_in_first_field
      procedure :: copies_of_nodes
      procedure :: is_quadratic
      procedure :: is_cut
      procedure :: support_of
      procedure :: functions_in
      procedure :: shape_functions_in
      procedure :: gradients_in
      procedure :: in_leaf
      procedure :: is_corner_of_leaf
      procedure, private :: all_pieces
   end type grid_t

contains

   !> Build the grid of a forest, with or without lines that cut. Fails where the memory does
   !> not suffice.
   subroutine build_grid(forest, grid, failure, lines, bodies, velocity_fields, solids)
      type(forest_t), intent(in) :: forest
      type(grid_t), intent(out) :: grid
      type(failure_t), intent(inout) :: failure
      type(line_t), intent(in), optional :: lines(:)
      type(outline_t), allocatable, intent(in), optional :: bodies(:) !! whose edges may cut cells
      integer, allocatable, intent(in), optional :: velocity_fields(:) !! the sheet on which each body is, from 1 on
      real(dp), allocatable, intent(in), optional :: solids(:, :, :)  !! see `grid_t`; where it is allocated, cells are quadratic
      type(place_table_t) :: points
      integer :: status, leaf
      grid%forest = forest
      if (present(solids)) then
         if (allocated(solids)) then
            allocate (grid%solids, source=solids)
            grid%n_functions = points_of_quadratic
         end if
      end if
      if (present(lines)) call find_cut_cells(forest, lines, .not. grid%is_quadratic(), grid%cut_cells)
      if (present(bodies)) then
         if (allocated(bodies)) then
            allocate (grid%bodies, source=bodies)
            call find_fills(grid)
            if (.not. grid%is_quadratic()) call find_aggregated_nodes(forest, grid%cut_cells, bodies, grid%aggregated_nodes)
         end if
      end if
      if (present(velocity_fields)) then
         if (allocated(velocity_fields)) then
            allocate (grid%field_of_body, source=velocity_fields)
            grid%n_velocity_fields = maxval(velocity_fields)
         end if
      end if
      associate (n_leaves => forest%leaf_count())
         call points%reserve(merge(corners, 1, grid%is_quadratic())*grid%n_velocity_fields*expected_points(n_leaves), status)
         if (status == 0) allocate (grid%leaf_element(n_leaves + 1), stat=status)
         if (status == 0) then
            call number_nodes(grid, points)
            if (grid%is_quadratic()) call number_inner_nodes(grid, points)
            grid%n_nodes = points%n
            grid%leaf_element(1) = 1
            do leaf = 1, n_leaves
               grid%leaf_element(leaf + 1) = grid%leaf_element(leaf) &
                                             + grid%all_pieces(leaf)*merge(corners, 1, is_divided(grid, points, leaf))
            end do
            grid%n_elements = grid%leaf_element(n_leaves + 1) - 1
            allocate (grid%element_lower(ndim, grid%n_elements), grid%element_size(grid%n_elements), &
                      grid%element_nodes(corners, grid%n_elements), grid%element_leaf(grid%n_elements), stat=status)
         end if
         if (status == 0) then
            call place_elements(grid, points)
            grid%n_points = points%n
            call find_masters(grid, points)
            call grid%dofs%connect(grid%element_nodes, status)
         end if
         if (status == 0) allocate (grid%node_position(ndim, grid%n_points), stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'grid: not enough memory for this number of cells')
         return
      end if
      grid%finest_cell = scale(forest%cell, -forest%finest_level())
      call place_nodes(grid)
   end subroutine build_grid

   !> About how many nodes so many leaves have.
   pure integer function expected_points(leaves)
      integer, intent(in) :: leaves
      expected_points = leaves + leaves/8 + 16
   end function expected_points

   !> Number the nodes: the corners of leaves, in the order of the leaves, but for outer nodes.
   subroutine number_nodes(grid, points)
      type(grid_t), intent(in) :: grid
      type(place_table_t), intent(inout) :: points
      integer :: leaf, piece, c, number
      do leaf = 1, grid%forest%leaf_count()
         do piece = 1, grid%all_pieces(leaf)
            do c = 1, corners
               if (grid%aggregated_nodes%are_there()) then
                  if (grid%aggregated_nodes%number_at(corner_of_leaf(grid, leaf, piece, c)) > 0) cycle
               end if
               call points%enter(corner_of_leaf(grid, leaf, piece, c), number)
            end do
         end do
      end do
   end subroutine number_nodes

   !> Number on, where cells are quadratic, the nodes in the middle of sides that do not hang, and those in the middle of leaves.
   subroutine number_inner_nodes(grid, points)
      type(grid_t), intent(in) :: grid
      type(place_table_t), intent(inout) :: points
      integer :: leaf, piece, side, coarser, of_coarser, number
      do leaf = 1, grid%forest%leaf_count()
         do piece = 1, grid%all_pieces(leaf)
            do side = 1, sides
               call find_coarser(grid, leaf, piece, side, coarser, of_coarser)
               if (coarser == outside) call points%enter(middle_of_side(grid, leaf, piece, side), number)
            end do
            call points%enter(seen_from(grid, leaf, piece, grid%forest%place_of(leaf) &
                                                           + level_width(grid%forest%level_of(leaf))/2), number)
         end do
      end do
   end subroutine number_inner_nodes

   !> The coarser leaf with material beside a side of a piece of a quadratic one, and the piece of it that is connected there; `outside`
   !> where there is none, or a cut between them.
   pure subroutine find_coarser(grid, leaf, piece, side, coarser, of_coarser)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf, piece, side
      integer, intent(out) :: coarser, of_coarser
      integer(long) :: place(ndim), middle(ndim)
      integer :: normal, other, end
      normal = (side + 1)/2
      coarser = outside
      of_coarser = 0
      associate (forest => grid%forest, width => level_width(grid%forest%level_of(leaf)))
         middle = forest%place_of(leaf) + width/2
         middle(normal) = middle(normal) + (2*mod(side - 1, 2) - 1)*(width/2)
         place = middle
         if (mod(side, 2) == 1) place(normal) = place(normal) - 1
         if (any(place < 0 .or. place >= forest%cells*level_width(0))) return
         associate (next => forest%leaf_of(place))
            if (forest%level_of(next) >= forest%level_of(leaf)) return
            if (.not. is_solid(grid, next)) return
            do other = 1, grid%all_pieces(next)
               if (any(seen_from(grid, leaf, piece, middle) /= seen_from(grid, next, other, middle))) cycle
               do end = 1, 2                     ! samples tell less of the ends than of the middle
                  place = place_of_corner(grid, leaf, side_corner(side, end))
                  if (any(seen_from(grid, leaf, piece, place) /= seen_from(grid, next, other, place))) exit
               end do
               if (end <= 2) cycle
               coarser = next
               of_coarser = other
               return
            end do
         end associate
      end associate
   end subroutine find_coarser

   !> Find which leaves bodies fill, and of which they have a part.
   pure subroutine find_fills(grid)
      type(grid_t), intent(inout) :: grid
      real(dp) :: m(0:ndim), fill, largest
      integer :: leaf, k
      associate (n => grid%forest%leaf_count())
         allocate (grid%is_full(n), grid%is_met(n))
         do leaf = 1, n
            fill = 0
            largest = 0
            associate (lower => grid%forest%position(grid%forest%place_of(leaf)), width => grid%forest%size_of(leaf))
               do k = 1, size(grid%bodies)
                  m = grid%bodies(k)%moments(lower, lower + width)/width**ndim
                  fill = fill + max(m(0), 0.0_dp)
                  largest = max(largest, m(0))
               end do
            end associate
            grid%is_met(leaf) = fill > least_part
            grid%is_full(leaf) = largest > 1 - 1e-9_dp
         end do
      end associate
   end subroutine find_fills

   !> Whether a leaf is cut by a line, or by the edge of a body that is no mere rectangle, so that its particles do not stand for all of it.
   pure logical function is_cut(self, leaf)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: leaf
      is_cut = self%cut_cells%pieces_of(leaf) > 1
      if (allocated(self%is_full) .and. .not. is_cut) is_cut = self%is_met(leaf) .and. .not. self%is_full(leaf)
   end function is_cut

   !> Whether there is material in a leaf.
   pure logical function is_solid(grid, leaf)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf
      real(dp) :: x(ndim)
      integer :: k
      x = grid%forest%position(grid%forest%place_of(leaf)) + grid%forest%size_of(leaf)/2
      is_solid = .false.
      if (allocated(grid%is_met)) then
         is_solid = grid%is_met(leaf)
         return
      end if
      do k = 1, size(grid%solids, 3)
         is_solid = is_solid .or. all(x > grid%solids(:, 1, k) .and. x < grid%solids(:, 2, k))
      end do
   end function is_solid

   !> A place as a piece of a leaf, on its sheet, sees it: points at one place that are not the same have different ones. Those of
   !> sheets but the first one are far outside the lattice.
   pure function seen_from(grid, leaf, piece, place) result(seen)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf
      integer, intent(in) :: piece               !! of all sheets
      integer(long), intent(in) :: place(ndim)
      integer(long) :: seen(ndim)
      integer(long), parameter :: far = 2_long**48
      integer :: velocity_field
      velocity_field = (piece - 1)/grid%cut_cells%pieces_of(leaf)
      seen = place
      if (velocity_field == 0 .and. grid%cut_cells%are_there()) then
         seen = place_of_copy(place, grid%cut_cells%copy_at(grid%forest, place, leaf, piece))
      end if
      seen(2) = seen(2) + velocity_field*far
   end function seen_from

   !> Place of a corner of a leaf, as a piece of it sees it.
   pure function corner_of_leaf(grid, leaf, piece, corner) result(place)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf, piece, corner
      integer(long) :: place(ndim)
      place = seen_from(grid, leaf, piece, place_of_corner(grid, leaf, corner))
   end function corner_of_leaf

   !> Place of a corner of a leaf.
   pure function place_of_corner(grid, leaf, corner) result(place)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf, corner
      integer(long) :: place(ndim)
      place = grid%forest%place_of(leaf) + corner_offset(corner)*level_width(grid%forest%level_of(leaf))
   end function place_of_corner

   !> Place of the middle of a side of a leaf, as a piece of it sees it: sides 1 and 2 are the lower and upper one in x, 3 and 4 in y.
   pure function middle_of_side(grid, leaf, piece, side) result(place)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf, piece, side
      integer(long) :: place(ndim)
      integer :: normal
      normal = (side + 1)/2
      associate (lower => grid%forest%place_of(leaf), width => level_width(grid%forest%level_of(leaf)))
         place = lower + width/2
         place(normal) = place(normal) + (2*mod(side - 1, 2) - 1)*(width/2)
         place = seen_from(grid, leaf, piece, place)
      end associate
   end function middle_of_side

   !> Whether a leaf is stored as its quarters.
   pure logical function is_divided(grid, nodes, leaf)
      type(grid_t), intent(in) :: grid
      type(place_table_t), intent(in) :: nodes
      integer, intent(in) :: leaf
      is_divided = grid%is_quadratic()
      if (.not. is_divided) is_divided = has_mid_node(grid, nodes, leaf)
   end function is_divided

   !> Whether there is a node in the middle of any side of a leaf.
   pure logical function has_mid_node(grid, nodes, leaf) result(has)
      type(grid_t), intent(in) :: grid
      type(place_table_t), intent(in) :: nodes
      integer, intent(in) :: leaf
      integer :: piece, side
      has = .false.
      if (grid%forest%is_uniform()) return
      do piece = 1, grid%all_pieces(leaf)
         do side = 1, sides
            has = has .or. nodes%number_of(middle_of_side(grid, leaf, piece, side)) > 0
         end do
      end do
   end function has_mid_node

   !> Elements of the leaves, and the nodes at their corners, of which the new ones hang.
   subroutine place_elements(grid, points)
      type(grid_t), intent(inout) :: grid
      type(place_table_t), intent(inout) :: points
      integer(long) :: lower(ndim), width
      integer :: leaf, piece, e, quarter, c
      do leaf = 1, grid%forest%leaf_count()
         width = level_width(grid%forest%level_of(leaf))
         if (grid%is_transition(leaf)) width = width/2
         e = grid%leaf_element(leaf) - 1
         do piece = 1, grid%all_pieces(leaf)
            do quarter = 1, grid%quarters_of(leaf)
               e = e + 1
               lower = grid%forest%place_of(leaf) + corner_offset(quarter)*width
               grid%element_leaf(e) = leaf
               grid%element_lower(:, e) = grid%forest%position(lower)
               grid%element_size(e) = grid%forest%size_of(leaf)
               if (grid%is_transition(leaf)) grid%element_size(e) = grid%element_size(e)/2
               do c = 1, corners
                  call points%enter(seen_from(grid, leaf, piece, lower + corner_offset(c)*width), grid%element_nodes(c, e))
               end do
            end do
         end do
      end do
   end subroutine place_elements

   !> Positions of the nodes, each by the first of its elements.
   subroutine place_nodes(grid)
      type(grid_t), intent(inout) :: grid
      integer :: e, corner
      do e = grid%n_elements, 1, -1
         do corner = 1, corners
            grid%node_position(:, grid%element_nodes(corner, e)) = grid%element_lower(:, e) &
                                                                   + corner_offset(corner)*grid%element_size(e)
         end do
      end do
   end subroutine place_nodes

   !> The masters of the hanging nodes and their weights. What leaves without material let hang has none: it may be between outer nodes.
   subroutine find_masters(grid, points)
      type(grid_t), intent(inout) :: grid
      type(place_table_t), intent(in) :: points
      real(dp), allocatable :: weight(:, :)
      integer, allocatable :: node(:, :), count_of(:)
      integer :: leaf, piece, side, middle, k
      integer :: mids(sides), ends(2, sides)
      associate (n_nodes => grid%n_nodes, n_hanging => grid%n_points - grid%n_nodes)
         allocate (weight(most_nodes_of_leaf, n_hanging), node(most_nodes_of_leaf, n_hanging), count_of(n_hanging))
         count_of = 0
         if (grid%is_quadratic()) then
            do leaf = 1, grid%forest%leaf_count()
               do piece = 1, grid%all_pieces(leaf)
                  do side = 1, sides
                     middle = points%number_of(middle_of_side(grid, leaf, piece, side)) - n_nodes
                     if (middle > 0) call find_masters_of_side(grid, points, leaf, piece, side, count_of(middle), &
                                                               node(:, middle), weight(:, middle))
                  end do
               end do
            end do
            call grid%dofs%set_masters(n_nodes, count_of, node, weight)
            return
         end if
         do leaf = 1, grid%forest%leaf_count()
            if (.not. grid%is_transition(leaf)) cycle
            if (grid%aggregated_nodes%are_there()) then
               if (.not. grid%is_met(leaf)) cycle
            end if
            do piece = 1, grid%all_pieces(leaf)
               do side = 1, sides
                  mids(side) = points%number_of(middle_of_side(grid, leaf, piece, side))
                  ends(:, side) = [(points%number_of(corner_of_leaf(grid, leaf, piece, side_corner(side, k))), k=1, 2)]
                  if (mids(side) <= n_nodes) cycle
                  count_of(mids(side) - n_nodes) = 2
                  node(:2, mids(side) - n_nodes) = ends(:, side)
                  weight(:2, mids(side) - n_nodes) = 0.5_dp
               end do
               middle = grid%element_nodes(corners, grid%leaf_element(leaf) + (piece - 1)*corners) - n_nodes
               count_of(middle) = 0
               do side = 1, sides
                  if (mids(side) <= n_nodes) then
                     call add_master(mids(side), 0.25_dp)
                  else
                     call add_master(ends(1, side), 0.125_dp)
                     call add_master(ends(2, side), 0.125_dp)
                  end if
               end do
            end do
         end do
      end associate
      if (grid%aggregated_nodes%are_there()) call add_aggregated_nodes()
      call grid%dofs%set_masters(grid%n_nodes, count_of, node, weight)
   contains
      !> Let outer nodes hang on the corners of their hosts.
      subroutine add_aggregated_nodes()
         integer(long) :: place(ndim)
         integer :: root_cell, point, aggregated
         do leaf = 1, grid%forest%leaf_count()
            do k = 1, corners
               place = corner_of_leaf(grid, leaf, 1, k)
               aggregated = grid%aggregated_nodes%number_at(place)
               if (aggregated == 0) cycle
               root_cell = grid%aggregated_nodes%root_cell(aggregated)
               point = points%number_of(place) - grid%n_nodes
               count_of(point) = corners
               node(:corners, point) = [(points%number_of(corner_of_leaf(grid, root_cell, 1, side)), side=1, corners)]
               weight(:corners, point) = grid%aggregated_nodes%weights(grid%forest, place)
            end do
         end do
      end subroutine add_aggregated_nodes

      !> Add to the weight of a master of the hanging node in the middle.
      subroutine add_master(master, part)
         integer, intent(in) :: master
         real(dp), intent(in) :: part
         integer :: j
         do j = 1, count_of(middle)
            if (node(j, middle) == master) exit
         end do
         if (j > count_of(middle)) then
            count_of(middle) = j
            node(j, middle) = master
            weight(j, middle) = 0
         end if
         weight(j, middle) = weight(j, middle) + part
      end subroutine add_master
   end subroutine find_masters

   !> The masters of the node in the middle of a side of a piece of a quadratic leaf beside a coarser one: the nodes of the side of that,
   !> from the end that it has in common with the leaf on.
   pure subroutine find_masters_of_side(grid, points, leaf, piece, side, n, master, weight)
      type(grid_t), intent(in) :: grid
      type(place_table_t), intent(in) :: points
      integer, intent(in) :: leaf, piece, side
      integer, intent(out) :: n
      integer, intent(inout) :: master(:)
      real(dp), intent(inout) :: weight(:)
      integer(long) :: shared(ndim), own(ndim, corners)
      integer :: coarser, of_coarser, opposite, k
      call find_coarser(grid, leaf, piece, side, coarser, of_coarser)
      opposite = side + 2*mod(side, 2) - 1
      n = 3
      weight(:n) = [0.375_dp, 0.75_dp, -0.125_dp]
      master(1:3:2) = [(points%number_of(corner_of_leaf(grid, coarser, of_coarser, side_corner(opposite, k))), k=1, 2)]
      master(2) = points%number_of(middle_of_side(grid, coarser, of_coarser, opposite))
      do k = 1, corners
         own(:, k) = place_of_corner(grid, leaf, k)
      end do
      shared = place_of_corner(grid, coarser, side_corner(opposite, 1))
      if (.not. any([(all(own(:, k) == shared), k=1, corners)])) master(:n) = master(n:1:-1)
   end subroutine find_masters_of_side

   !> The corner at one end, 1 or 2, of a side of a leaf: the lower one in x is the first, the upper one the second, then those in y.
   pure integer function side_corner(side, end)
      integer, intent(in) :: side, end
      integer, parameter :: table(2, sides) = reshape([1, 3, 2, 4, 1, 2, 3, 4], [2, sides])
      side_corner = table(end, side)
   end function side_corner

   !> Whether a leaf is a transition element.
   pure logical function is_transition(self, leaf)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: leaf
      is_transition = self%quarters_of(leaf) > 1
   end function is_transition

   !> Number of elements of each piece of a leaf: 1, or its quarters.
   pure integer function quarters_of(self, leaf)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: leaf
      quarters_of = (self%leaf_element(leaf + 1) - self%leaf_element(leaf))/self%all_pieces(leaf)
   end function quarters_of

   !> Number of pieces of a leaf on all sheets.
   pure integer function all_pieces(self, leaf)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: leaf
      all_pieces = self%n_velocity_fields*self%cut_cells%pieces_of(leaf)
   end function all_pieces

   !> The sheet on which a body is.
   pure integer function velocity_field_of(self, body) result(velocity_field)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: body
      velocity_field = 1
      if (allocated(self%field_of_body)) velocity_field = self%field_of_body(body)
   end function velocity_field_of

   !> Whether an element is on the first sheet.
   pure logical function is_in_first_field(self, e) result(is)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      associate (leaf => self%element_leaf(e))
         is = e - self%leaf_element(leaf) < (self%leaf_element(leaf + 1) - self%leaf_element(leaf))/self%n_velocity_fields
      end associate
   end function is_in_first_field

   !> What is on a sheet where an element of the first one is.
   pure integer function copy_on(self, e, velocity_field) result(copy)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e, velocity_field
      associate (leaf => self%element_leaf(e))
         copy = e + (velocity_field - 1)*((self%leaf_element(leaf + 1) - self%leaf_element(leaf))/self%n_velocity_fields)
      end associate
   end function copy_on

   !> The copies of each node on all sheets, by its copy on the first one; 0 for the other points. (sheets, points)
   pure subroutine copies_of_nodes(self, copies)
      class(grid_t), intent(in) :: self
      integer, allocatable, intent(out) :: copies(:, :)
      integer :: leaf, first, e, c, velocity_field
      allocate (copies(self%n_velocity_fields, self%n_points), source=0)
      do leaf = 1, self%forest%leaf_count()
         first = self%leaf_element(leaf)
         do e = first, first + (self%leaf_element(leaf + 1) - first)/self%n_velocity_fields - 1
            do c = 1, corners
               copies(:, self%element_nodes(c, e)) = [(self%element_nodes(c, self%copy_on(e, velocity_field)), velocity_field=1, &
                                                       self%n_velocity_fields)]
            end do
         end do
      end do
   end subroutine copies_of_nodes

   !> Whether the cells are quadratic.
   pure logical function is_quadratic(self)
      class(grid_t), intent(in) :: self
      is_quadratic = allocated(self%solids)
   end function is_quadratic

   !> The points on which values in an element depend: its corners or, where cells are quadratic, all points of its leaf, those along x one
   !> after the other.
   pure function support_of(self, e) result(points)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      integer :: points(self%n_functions)
      integer :: k
      if (self%is_quadratic()) then
         associate (first => self%first_of_piece(e))
            points = [(self%element_nodes(corner_of_point(k), first + quarter_of_point(k) - 1), k=1, points_of_quadratic)]
         end associate
      else
         points = self%element_nodes(:, e)
      end if
   end function support_of

   !> The functions of these points at a place in an element.
   pure function functions_in(self, e, xi) result(n)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: xi(ndim)           !! local coordinate in the element [-]
      real(dp) :: n(self%n_functions)
      if (self%is_quadratic()) then
         n = quadratic_functions(self%in_leaf(e, xi))
      else
         n = shape_functions(xi)
      end if
   end function functions_in

   !> Both at once, the first `n_functions` of the arrays, which need no room of their own.
   pure subroutine shape_functions_in(self, e, xi, points, n)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: xi(ndim)           !! local coordinate in the element [-]
      integer, intent(out) :: points(:)
      real(dp), intent(out) :: n(:)
      if (self%is_quadratic()) then
         points(:self%n_functions) = self%support_of(e)
         n(:points_of_quadratic) = quadratic_functions(self%in_leaf(e, xi))
      else
         points(:corners) = self%element_nodes(:, e)
         n(:corners) = shape_functions(xi)
      end if
   end subroutine shape_functions_in

   !> Gradients of these functions with respect to position.
   pure function gradients_in(self, e, xi) result(gradient)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: xi(ndim)           !! local coordinate in the element [-]
      real(dp) :: gradient(self%n_functions, ndim) !! [1/m]
      if (self%is_quadratic()) then
         gradient = quadratic_gradients(self%in_leaf(e, xi), 0.5_dp/self%element_size(e))
         if (allocated(self%correction)) gradient = gradient + self%correction(:, :, (e - 1)/corners + 1)
      else
         gradient = shape_gradients(xi, 1/self%element_size(e))
      end if
   end function gradients_in

   !> Local coordinate in the leaf of which an element is a quarter.
   pure function in_leaf(self, e, xi) result(of_leaf)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: xi(ndim)           !! local coordinate in the element [-]
      real(dp) :: of_leaf(ndim)
      of_leaf = (corner_offset(e - self%first_of_piece(e) + 1) + xi)/2
   end function in_leaf

   !> Whether a node is a corner of the leaves around it, and not in the middle of a side of one or inside it.
   pure logical function is_corner_of_leaf(self, node) result(is)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: node
      is = .true.
      if (.not. self%is_quadratic()) return
      associate (slot => self%dofs%slot(self%dofs%first_slot(node)))
         is = all(mod(nint(2*self%in_leaf(element_of_slot(slot), real(corner_offset(corner_of_slot(slot)), dp))), 2) == 0)
      end associate
   end function is_corner_of_leaf

   !> The first element of the leaf of an element or, where that is cut, of its piece.
   pure integer function first_of_piece(self, e) result(first)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      associate (of_leaf => self%leaf_element(self%element_leaf(e)), quarters => self%quarters_of(self%element_leaf(e)))
         first = of_leaf + (e - of_leaf)/quarters*quarters
      end associate
   end function first_of_piece

   !> The last one.
   pure integer function last_of_piece(self, e) result(last)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      last = self%first_of_piece(e) + self%quarters_of(self%element_leaf(e)) - 1
   end function last_of_piece

   !> Whether an element is of a piece of a leaf that is cut.
   pure logical function is_piece(self, e)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      is_piece = self%cut_cells%pieces_of(self%element_leaf(e)) > 1
   end function is_piece

   !> Which piece of its leaf an element is of, from 1 on; 0 where that is not cut.
   pure integer function piece_of(self, e) result(piece)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      piece = 0
      if (.not. self%is_piece(e)) return
      associate (leaf => self%element_leaf(e))
         piece = 1 + mod((e - self%leaf_element(leaf))/self%quarters_of(leaf), self%cut_cells%pieces_of(leaf))
      end associate
   end function piece_of

   !> Size of the leaf of an element [m].
   pure real(dp) function leaf_size(self, e)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      leaf_size = self%forest%size_of(self%element_leaf(e))
   end function leaf_size

   !> Size of the smallest leaf at a node [m].
   pure real(dp) function smallest_leaf_at(self, node) result(smallest)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: node
      integer :: k
      associate (elements => self%dofs%elements_at(node))
         smallest = minval([(self%leaf_size(elements(k)), k=1, size(elements))])
      end associate
   end function smallest_leaf_at

   !> The node that stands at the place `x`; 0 where none does. Where there are two, on both sides of a cut, `toward` tells which is
   !> meant: it has an element on that side.
   pure integer function node_at(self, x, toward)
      class(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in), optional :: toward(ndim)
      real(dp) :: tolerance
      tolerance = self%forest%tolerance()
      do node_at = self%n_nodes, 1, -1
         if (.not. all(abs(self%node_position(:, node_at) - x) <= tolerance)) cycle
         if (self%n_velocity_fields > 1) then
            associate (elements => self%dofs%elements_at(node_at))
               if (.not. self%is_in_first_field(elements(1))) cycle
            end associate
         end if
         if (.not. present(toward)) return
         if (self%has_element_toward(node_at, toward)) return
      end do
   end function node_at

   !> Whether a node has an element on one side: one whose centre is in the direction `toward`, along the grid or a diagonal.
   pure logical function has_element_toward(self, node, toward) result(has)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: node
      real(dp), intent(in) :: toward(ndim)
      integer :: k
      associate (corner => self%dofs%corners_at(node))
         has = any([(is_toward(corner(k), toward), k=1, size(corner))])
      end associate
   end function has_element_toward

   !> Whether an element is on one side of the node at one of its corners, in the direction `toward`.
   pure logical function is_toward(corner, toward)
      integer, intent(in) :: corner
      real(dp), intent(in) :: toward(ndim)
      is_toward = dot_product(0.5_dp - corner_offset(corner), toward) > 0.25_dp*norm2(toward) ! 0 of a cell beside a diagonal
   end function is_toward

   !> The element that covers the place `x`, of its piece where there are several; `outside` where there is none, or where `x` is not a
   !> number. Where lines move, the piece is that of the material that began at `origin`. Of several sheets it is that of the body to
   !> which the material belongs, or else the first.
   pure integer function element_at(self, x, origin, body) result(e)
      class(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in), optional :: origin(ndim) !! in the reference configuration [m]
      integer, intent(in), optional :: body
      real(dp) :: beside(ndim)
      integer(long) :: place(ndim)
      integer :: leaf, d
      e = outside
      place = self%forest%place_at(x)
      if (place(1) < 0) return
      leaf = self%forest%leaf_of(place)
      e = self%leaf_element(leaf)
      if (self%leaf_element(leaf + 1) == e + 1) return
      if (self%cut_cells%pieces_of(leaf) > 1) then
         beside = x
         if (present(origin)) beside = self%cut_cells%follow(origin)
         e = e + (self%cut_cells%piece_at(self%forest, leaf, beside) - 1)*self%quarters_of(leaf)
      end if
      if (present(body) .and. self%n_velocity_fields > 1) e = self%copy_on(e, self%velocity_field_of(body))
      if (.not. self%is_transition(leaf)) return
      place = (place - self%forest%place_of(leaf))/(level_width(self%forest%level_of(leaf))/2)
      do d = 1, ndim
         e = e + int(place(d))*2**(d - 1)
      end do
   end function element_at

   !> The element of material on a face of a crack, which began at a place beside it: as `element_at` or, where the place is in a sliver, which
   !> belongs to the piece beyond the crack, that from which the sliver is cut off. The place is outside of this by up to an eighth.
   pure integer function element_on_side(self, x, origin, body) result(e)
      class(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: origin(ndim)       !! in the reference configuration, beside the crack [m]
      integer, intent(in) :: body
      e = self%element_at(out_of_sliver(self, x, self%cut_cells%follow(origin)), origin, body)
   end function element_on_side

   !> The element that a face of a crack belongs to, from a place beside it: as `element_on_side`.
   pure integer function element_of_face(self, x) result(e)
      class(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      e = self%element_at(out_of_sliver(self, x, x))
   end function element_of_face

   !> A place or, where what is there is in a sliver of its leaf, one farther away from the crack, beyond the sliver [m].
   pure function out_of_sliver(self, x, beside) result(place)
      type(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: beside(ndim)       !! where it would be if it had kept its distance from the crack [m]
      real(dp), parameter :: beyond_slivers = 0.125_dp ! of a leaf: two samples
      real(dp) :: place(ndim), point(ndim), normal(ndim)
      integer :: leaf
      place = x
      leaf = self%forest%leaf_at(x)
      if (leaf == outside) return
      if (.not. self%cut_cells%is_in_sliver(self%forest, leaf, beside)) return
      call self%cut_cells%find_nearest(beside, point, normal)
      place = x + sign(beyond_slivers*self%forest%size_of(leaf), dot_product(beside - point, normal))*normal
   end function out_of_sliver

   !> Local coordinate of the place `x` in element `e`, in [0, 1] inside it.
   pure function local_coordinate(self, e, x) result(xi)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: xi(ndim)
      xi = (x - self%element_lower(:, e))/self%element_size(e)
   end function local_coordinate
end module hampm_grid
