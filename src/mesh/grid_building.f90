!> Building a grid from a forest: numbering its nodes, placing its elements, and finding on which nodes others hang.
module hampm_grid_building
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_basis, only: points_of_quadratic
   use hampm_cut_cells, only: place_of_copy
   use hampm_cutting, only: find_cut_cells
   use hampm_crack_lines, only: line_t
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_forest, only: forest_t, outside, corner_offset, level_width
   use hampm_failure, only: failure_t, exit_computation
   use hampm_aggregated_nodes, only: find_aggregated_nodes
   use hampm_outline, only: outline_t, least_part
   use hampm_place_table, only: place_table_t
   use hampm_plane_cuts, only: plane_cut_t, find_open_nodes, seen_beside
   use hampm_grid, only: grid_t, side_corner, sides
   implicit none
   private
   public :: build_grid, add_points

contains

   !> Build the grid of a forest, with or without lines that cut. Fails where the memory does
   !> not suffice.
   subroutine build_grid(forest, grid, failure, lines, bodies, velocity_fields, solids, waits, planes)
      type(forest_t), intent(in) :: forest
      type(grid_t), intent(out) :: grid
      type(failure_t), intent(inout) :: failure
      type(line_t), intent(in), optional :: lines(:)
      type(outline_t), allocatable, intent(in), optional :: bodies(:) !! whose edges may cut cells
      integer, allocatable, intent(in), optional :: velocity_fields(:) !! the velocity field on which each body is, from 1 on
      real(dp), allocatable, intent(in), optional :: solids(:, :, :)  !! see `grid_t`; where it is allocated, cells are quadratic
      logical, intent(in), optional :: waits     !! whether the points of quadratic cells wait for `add_points`
      type(plane_cut_t), allocatable, intent(in), optional :: planes(:) !! cracks in planes of the grid
      logical :: is_complete
      is_complete = .true.
      if (present(waits) .and. present(solids)) is_complete = .not. (waits .and. allocated(solids))
      grid%forest = forest
      if (present(solids)) then
         if (allocated(solids)) then
            allocate (grid%solids, source=solids)
            grid%n_functions = points_of_quadratic
         end if
      end if
      if (present(lines)) call find_cut_cells(forest, lines, grid%cut_cells)
      if (present(bodies)) then
         if (allocated(bodies)) then
            allocate (grid%bodies, source=bodies)
            call find_fills(grid)
         end if
      end if
      if (present(velocity_fields)) then
         if (allocated(velocity_fields)) then
            allocate (grid%field_of_body, source=velocity_fields)
            grid%n_velocity_fields = maxval(velocity_fields)
         end if
      end if
      if (present(planes)) then
         if (allocated(planes)) allocate (grid%planes, source=planes)
      end if
      grid%finest_cell = scale(forest%cell, -forest%finest_level())
      if (grid%is_quadratic()) call place_elements(grid, failure)
      if (is_complete .and. .not. failure%failed()) call add_points(grid, failure)
   end subroutine build_grid

   !> Add the points to a grid of leaves, and its elements where these are not there. Fails where the memory does not suffice.
   subroutine add_points(grid, failure)
      type(grid_t), intent(inout) :: grid
      type(failure_t), intent(inout) :: failure
      type(place_table_t) :: points
      integer :: status
      status = 0
      if (grid%cut_cells%are_there()) call grid%cut_cells%find_copies(grid%forest)
      if (allocated(grid%planes)) call find_open_nodes(grid%planes, grid%forest, status)
      if (status == 0 .and. allocated(grid%bodies) .and. .not. grid%is_quadratic()) &
         call find_aggregated_nodes(grid%forest, grid%cut_cells, grid%planes, grid%bodies, grid%aggregated_nodes)
      associate (n_leaves => grid%forest%leaf_count())
         if (status == 0) &
            call points%reserve(merge(corners, 1, grid%is_quadratic())*grid%n_velocity_fields*(n_leaves + n_leaves/8 + 16), &
                                status, grid%forest%cells, level_width(0))
      end associate
      if (status == 0) then
         call number_nodes(grid, points)
         if (.not. (grid%forest%is_uniform() .or. grid%is_quadratic())) call points%number_by_rows()
         if (grid%is_quadratic()) call number_inner_nodes(grid, points)
         grid%n_nodes = points%n
         if (.not. grid%is_quadratic()) call place_elements(grid, failure, points)
         if (failure%failed()) return
         allocate (grid%element_nodes(corners, grid%n_elements), stat=status)
      end if
      if (status == 0) then
         call number_corners(grid, points)
         grid%n_points = points%n
         call find_masters(grid, points)
         call grid%dofs%connect(grid%element_nodes, status)
      end if
      if (status == 0) allocate (grid%node_position(ndim, grid%n_points), stat=status)
      if (status /= 0) then
         call report_memory(failure)
         return
      end if
      call place_nodes(grid)
   end subroutine add_points

   !> Fail as the memory does not suffice.
   pure subroutine report_memory(failure)
      type(failure_t), intent(inout) :: failure
      call failure%report(exit_computation, 'grid: not enough memory for this number of cells')
   end subroutine report_memory

   !> Number the nodes: the corners of leaves, without aggregated nodes. In refined grids they are then numbered row by row, for
   !> stencils along rows (`hampm_stencils`).
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

   !> The coarser leaf with material beside a side of a piece of a quadratic one, and its piece that is connected there; `outside`
   !> if there is none, or a cut between.
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

   !> Whether there is material in a leaf.
   pure logical function is_solid(grid, leaf)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf
      real(dp) :: x(ndim)
      integer :: k
      x = grid%forest%middle_of(leaf)
      is_solid = .false.
      if (allocated(grid%is_met)) then
         is_solid = grid%is_met(leaf)
         return
      end if
      do k = 1, size(grid%solids, 3)
         is_solid = is_solid .or. all(x > grid%solids(:, 1, k) .and. x < grid%solids(:, 2, k))
      end do
   end function is_solid

   !> A place in the numbering of a piece of a leaf, on its velocity field: different points at one place differ. Points of all
   !> velocity fields but the first are far outside the lattice.
   pure function seen_from(grid, leaf, piece, place) result(seen)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf
      integer, intent(in) :: piece               !! of all velocity fields
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
      if (allocated(grid%planes)) seen = seen + seen_beside(grid%planes, grid%forest, leaf, place) - place
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

   !> Place of the middle of a side of a leaf for one of its pieces: sides 1 and 2 are lower and upper in x, 3 and 4 in y.
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

   !> Steps of half a leaf to the k-th of the points of its quarters, 0 to 2 in each direction; those along x follow each other.
   pure function steps_to(k) result(steps)
      integer, intent(in) :: k
      integer :: steps(ndim)
      integer :: d
      steps = [(mod((k - 1)/3**d, 3), d=0, ndim - 1)]
   end function steps_to

   !> Place of that point, as a piece of the leaf sees it.
   pure function point_of_leaf(grid, leaf, piece, k) result(place)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf, piece, k
      integer(long) :: place(ndim)
      place = seen_from(grid, leaf, piece, grid%forest%place_of(leaf) + steps_to(k)*(level_width(grid%forest%level_of(leaf))/2))
   end function point_of_leaf

   !> Whether a leaf is stored as its quarters: a quadratic one, or one with a node in the middle of a side.
   pure logical function is_divided(grid, leaf, nodes)
      type(grid_t), intent(in) :: grid
      type(place_table_t), intent(in), optional :: nodes !! where it is not quadratic
      integer, intent(in) :: leaf
      integer :: piece, k, d
      is_divided = grid%is_quadratic()
      if (is_divided .or. grid%forest%is_uniform() .or. .not. present(nodes)) return
      do piece = 1, grid%all_pieces(leaf)
         do k = 1, points_of_quadratic
            if (all(count(steps_to(k) == 1) /= [(d, d=1, ndim - 1)])) cycle
            is_divided = is_divided .or. nodes%number_of(point_of_leaf(grid, leaf, piece, k)) > 0
         end do
      end do
   end function is_divided

   !> Elements of the leaves. Fails where the memory does not suffice.
   subroutine place_elements(grid, failure, nodes)
      type(grid_t), intent(inout) :: grid
      type(failure_t), intent(inout) :: failure
      type(place_table_t), intent(in), optional :: nodes !! where cells are not quadratic
      integer(long) :: lower(ndim), width
      integer :: leaf, piece, e, quarter, status
      allocate (grid%leaf_element(grid%forest%leaf_count() + 1), stat=status)
      if (status == 0) then
         grid%leaf_element(1) = 1
         do leaf = 1, grid%forest%leaf_count()
            grid%leaf_element(leaf + 1) = grid%leaf_element(leaf) &
                                          + grid%all_pieces(leaf)*merge(corners, 1, is_divided(grid, leaf, nodes))
         end do
         grid%n_elements = grid%leaf_element(grid%forest%leaf_count() + 1) - 1
         allocate (grid%element_lower(ndim, grid%n_elements), grid%element_size(grid%n_elements), &
                   grid%element_leaf(grid%n_elements), stat=status)
      end if
      if (status /= 0) then
         call report_memory(failure)
         return
      end if
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
            end do
         end do
      end do
   end subroutine place_elements

   !> The nodes at the corners of the elements, of which the new ones hang.
   subroutine number_corners(grid, points)
      type(grid_t), intent(inout) :: grid
      type(place_table_t), intent(inout) :: points
      integer(long) :: lower(ndim), width
      integer :: leaf, piece, e, quarter, c
      e = 0
      do leaf = 1, grid%forest%leaf_count()
         width = level_width(grid%forest%level_of(leaf))
         if (grid%is_transition(leaf)) width = width/2
         do piece = 1, grid%all_pieces(leaf)
            do quarter = 1, grid%quarters_of(leaf)
               e = e + 1
               lower = grid%forest%place_of(leaf) + corner_offset(quarter)*width
               do c = 1, corners
                  call points%enter(seen_from(grid, leaf, piece, lower + corner_offset(c)*width), grid%element_nodes(c, e))
               end do
            end do
         end do
      end do
   end subroutine number_corners

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

   !> The masters of the hanging nodes and their weights. Hanging nodes of empty leaves have none (between aggregated nodes).
   subroutine find_masters(grid, points)
      type(grid_t), intent(inout) :: grid
      type(place_table_t), intent(in) :: points
      real(dp), allocatable :: weight(:, :)
      integer, allocatable :: node(:, :), count_of(:)
      integer :: leaf, piece, side, middle, k
      integer :: number(points_of_quadratic), middles, d, lower
      associate (n_nodes => grid%n_nodes, n_hanging => grid%n_points - grid%n_nodes)
         k = merge(corners**2, most_nodes_of_leaf, grid%aggregated_nodes%are_there())
         allocate (weight(k, n_hanging), node(k, n_hanging), count_of(n_hanging))
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
               number = [(points%number_of(point_of_leaf(grid, leaf, piece, k)), k=1, points_of_quadratic)]
               do middles = 1, ndim              ! of sides, then of the faces or cell with these as sides
                  do k = 1, points_of_quadratic
                     if (count(steps_to(k) == 1) /= middles .or. number(k) <= n_nodes) cycle
                     middle = number(k) - n_nodes
                     count_of(middle) = 0
                     do d = 1, ndim
                        if (mod((k - 1)/3**(d - 1), 3) /= 1) cycle
                        do lower = k - 3**(d - 1), k + 3**(d - 1), 2*3**(d - 1)
                           call add_masters(number(lower), middles == 1)
                        end do
                     end do
                  end do
               end do
            end do
         end do
      end associate
      if (grid%aggregated_nodes%are_there()) then
         do leaf = 1, grid%forest%leaf_count()
            do k = 1, corners
               call add_aggregated_node(corner_of_leaf(grid, leaf, 1, k), place_of_corner(grid, leaf, k))
            end do
         end do
         do middle = 1, size(count_of)
            call follow_aggregated_nodes()
         end do
      end if
      call grid%dofs%set_masters(grid%n_nodes, count_of, node, weight)
   contains
      !> Let an aggregated node hang on the corners of its root cells.
      subroutine add_aggregated_node(seen, place)
         integer(long), intent(in) :: seen(ndim), place(ndim) !! where it is, as a leaf sees it
         real(dp) :: part(corners)
         integer :: number, which
         number = grid%aggregated_nodes%number_at(seen)
         if (number == 0) return
         associate (root_cell => grid%aggregated_nodes%root_cell(:, number))
            middle = points%number_of(seen) - grid%n_nodes
            count_of(middle) = 0
            do which = 1, count(root_cell > 0)
               part = grid%aggregated_nodes%weights(grid%forest, number, which, place)/count(root_cell > 0)
               do side = 1, corners
                  call add_master(points%number_of(corner_of_leaf(grid, root_cell(which), 1, side)), part(side))
               end do
            end do
         end associate
      end subroutine add_aggregated_node

      !> Let the hanging node in the middle follow the masters of aggregated nodes among its own.
      subroutine follow_aggregated_nodes()
         integer :: before(size(node, 1)), n, i, j
         real(dp) :: part(size(node, 1))
         do while (any(node(:count_of(middle), middle) > grid%n_nodes))
            n = count_of(middle)
            before = node(:, middle)
            part = weight(:, middle)
            count_of(middle) = 0
            do i = 1, n
               associate (hanging => before(i) - grid%n_nodes)
                  if (hanging <= 0) call add_master(before(i), part(i))
                  if (hanging <= 0) cycle
                  do j = 1, count_of(hanging)
                     call add_master(node(j, hanging), part(i)*weight(j, hanging))
                  end do
               end associate
            end do
         end do
      end subroutine follow_aggregated_nodes

      !> Let the hanging node in the middle follow one of the nodes whose mean it is, or the masters of that node.
      subroutine add_masters(of, is_corner)
         integer, intent(in) :: of
         logical, intent(in) :: is_corner
         integer :: i
         if (is_corner .or. of <= grid%n_nodes) then
            call add_master(of, 0.5_dp/middles)
         else
            do i = 1, count_of(of - grid%n_nodes)
               call add_master(node(i, of - grid%n_nodes), 0.5_dp/middles*weight(i, of - grid%n_nodes))
            end do
         end if
      end subroutine add_masters

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

   !> The masters of the node in the middle of a side of a piece of a quadratic leaf beside a coarser one: the nodes of the coarser
   !> side, from the end shared with the leaf on.
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
end module hampm_grid_building
