!> A grid with a cut: what is and what is not connected, on cells of one and of several sizes.
program test_cuts
   use hampm_kinds, only: dp, ndim
   use hampm_cuts, only: cut_t, cut_of, crosses
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t, build_grid
   use hampm_harness, only: check, check_close, finish
   implicit none

   real(dp), parameter :: cell = 0.5_dp
   integer, parameter :: cells(ndim) = [8, 6]
   real(dp), parameter :: tip(ndim) = [2.5_dp, 1.5_dp], end(ndim) = [1.0_dp, 1.5_dp]
   integer :: levels

   call nodes_of_a_cut()
   do levels = 0, 3
      call sides_are_apart(levels)
      call sides_match(levels)
   end do
   call ways_across()
   call finish()

contains

   !> The forest, with the cells around a place on the upper side of the cut refined: the sides then differ.
   function refined(levels) result(forest)
      integer, intent(in) :: levels
      type(forest_t) :: forest
      integer, allocatable :: change(:)
      integer :: level, leaf
      real(dp) :: centre(ndim)
      forest = forest_t([0.0_dp, 0.0_dp], cell, cells)
      do level = 1, levels
         allocate (change(forest%leaf_count()), source=0)
         do leaf = 1, size(change)
            centre = forest%position(forest%place_of(leaf)) + 0.5_dp*forest%size_of(leaf)
            if (centre(2) > tip(2) .and. norm2(centre - [1.6_dp, 1.8_dp]) < 2*forest%size_of(leaf)) change(leaf) = 1
         end do
         call forest%adapt(change)
         call forest%balance()
         deallocate (change)
      end do
   end function refined

   !> A grid with the cut from `end` to `tip`, or to the edge of the lattice where it `is_open`.
   subroutine build(levels, is_open, grid)
      integer, intent(in) :: levels
      logical, intent(in) :: is_open
      type(grid_t), intent(out) :: grid
      type(failure_t) :: failure
      type(forest_t) :: forest
      forest = refined(levels)
      call build_grid(forest, grid, failure, &
                      [cut_of(forest, 2, tip, merge([-100.0_dp, tip(2)], end, is_open))])
      call check(.not. failure%failed(), 'the grid is built')
   end subroutine build

   !> Nodes within the cut are double, its tips are not; a cut that ends beyond the lattice is open there.
   subroutine nodes_of_a_cut()
      type(grid_t) :: grid
      real(dp), parameter :: up(ndim) = [0.0_dp, 1.0_dp]
      call build(0, .false., grid)
      call check(grid%n_nodes == product(cells + 1) + 2, 'the two nodes between the tips are double')
      call check(grid%node_at(tip, up) == grid%node_at(tip, -up), 'a tip is one node')
      call check(grid%node_at(end, up) == grid%node_at(end, -up), 'so is the other tip')
      call check(grid%node_at([1.5_dp, 1.5_dp], up) /= grid%node_at([1.5_dp, 1.5_dp], -up), 'within the cut there are two')
      call check(grid%node_at([1.5_dp, 1.5_dp], up) > 0 .and. grid%node_at([1.5_dp, 1.5_dp], -up) > 0, 'which are both found')
      call build(0, .true., grid)
      call check(grid%n_nodes == product(cells + 1) + 5, 'of an open cut the node at the edge is double too')
   end subroutine nodes_of_a_cut

   !> No element of one side shares a point with one of the other, but for the tips; each side's points hold linear fields of their
   !> own, on both sides of any sizes; everything else is as without the cut.
   subroutine sides_are_apart(levels)
      integer, intent(in) :: levels
      type(grid_t) :: grid, whole
      type(failure_t) :: failure
      integer :: e, node, point, k, shared, strange
      call build(levels, .false., grid)
      shared = 0
      do node = 1, grid%n_points
         if (.not. is_within(grid, node)) cycle
         if (any(grid%element_lower(2, grid%dofs%elements_at(node)) > tip(2) - 1.0e-9_dp .neqv. side_of(grid, node))) &
            shared = shared + 1
      end do
      call check(shared == 0, 'no point within the cut belongs to both sides')
      strange = 0
      do point = grid%n_nodes + 1, grid%n_points
         if (.not. is_within(grid, point)) cycle
         do k = grid%dofs%first_master(point - grid%n_nodes), grid%dofs%first_master(point - grid%n_nodes + 1) - 1
            associate (master => grid%dofs%master(k))
               if (is_within(grid, master) .and. (side_of(grid, master) .neqv. side_of(grid, point))) strange = strange + 1
            end associate
         end do
      end do
      call check(strange == 0, 'hanging nodes within the cut take their values from their own side')
      call build_grid(refined(levels), whole, failure)
      call check(whole%n_nodes <= grid%n_nodes .and. whole%forest%same_leaves(grid%forest), 'the cut adds nodes only')
      if (levels > 0) call check(whole%n_elements > grid%n_elements, &
                                 'cells across the cut from finer ones need not be transition elements')
      call check(all([(grid%element_nodes(:, e) > 0, e=1, grid%n_elements)]), 'every corner has its point')
   end subroutine sides_are_apart

   !> Where the sides of a cut are matched, each has a node wherever the other has one, still apart from it; on cells of one size
   !> nothing changes.
   subroutine sides_match(levels)
      integer, intent(in) :: levels
      type(grid_t) :: grid, unmatched
      type(failure_t) :: failure
      type(forest_t) :: forest
      real(dp), parameter :: up(ndim) = [0.0_dp, 1.0_dp]
      integer :: node, above, below, mixed
      call build(levels, .false., unmatched)
      forest = refined(levels)
      call build_grid(forest, grid, failure, [cut_of(forest, 2, tip, end, matched=.true.)])
      above = 0
      below = 0
      mixed = 0
      do node = 1, grid%n_nodes
         if (.not. is_within(grid, node)) cycle
         if (grid%node_at(grid%node_position(:, node), up) == node) above = above + 1
         if (grid%node_at(grid%node_position(:, node), -up) == node) below = below + 1
         if (grid%has_element_toward(node, up) .and. grid%has_element_toward(node, -up)) mixed = mixed + 1
      end do
      call check(above == below .and. mixed == 0, 'matched sides have the same nodes, apart from each other')
      call check((grid%n_nodes > unmatched%n_nodes) .eqv. levels > 0, 'of which the larger cells get theirs')
   end subroutine sides_match

   !> Whether a point is within the cut.
   logical function is_within(grid, point)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: point
      associate (x => grid%node_position(:, point))
         is_within = abs(x(2) - tip(2)) < 1.0e-9_dp .and. x(1) > end(1) + 1.0e-9_dp .and. x(1) < tip(1) - 1.0e-9_dp
      end associate
   end function is_within

   !> Whether the first element of a point is above the line of the cut.
   logical function side_of(grid, point)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: point
      associate (elements => grid%dofs%elements_at(point))
         side_of = grid%element_lower(2, elements(1)) > tip(2) - 1.0e-9_dp
      end associate
   end function side_of

   !> A way crosses the cut where it starts between the ends and changes sides.
   subroutine ways_across()
      type(forest_t) :: forest
      type(cut_t) :: cut
      forest = refined(0)
      cut = cut_of(forest, 2, tip, end)
      call check(crosses(cut, forest, [1.6_dp, 1.4_dp], [1.6_dp, 1.6_dp]), 'a way up through the cut')
      call check(crosses(cut, forest, [1.6_dp, 1.6_dp], [1.7_dp, 1.4_dp]), 'a way down through it')
      call check(.not. crosses(cut, forest, [1.6_dp, 1.4_dp], [1.7_dp, 1.45_dp]), 'a way on one side')
      call check(.not. crosses(cut, forest, [2.6_dp, 1.4_dp], [2.6_dp, 1.6_dp]), 'a way ahead of the tip')
   end subroutine ways_across
end program test_cuts
