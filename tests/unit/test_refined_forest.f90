!> A forest that refines and recombines covers every place once, stays balanced, and never loses the identity of a node.
program test_refined_forest
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf
   use, intrinsic :: ieee_exceptions, only: ieee_set_halting_mode, ieee_set_flag, ieee_invalid
   use hampm_kinds, only: dp, ndim, long
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t, outside, level_width, deepest
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_random_forests, only: change_at_random
   use hampm_text, only: to_text
   implicit none

   integer, parameter :: lattices(ndim, 5) = reshape([1, 1, 2, 2, 1, 5, 3, 2, 7, 3], [ndim, 5])
   integer :: k

   call repeat_random_numbers()
   do k = 1, size(lattices, 2)
      call random_cycles(lattices(:, k))
      call there_and_back(lattices(:, k))
   end do
   call only_whole_families_recombine()
   do k = 20, 23
      call deep_corner(k)
      call deep_centre(k)
   end do
   call rough_coordinates()
   call finish()

contains

   !> Refine, balance and recombine at random, and look at the forest and its grid after every change.
   subroutine random_cycles(cells)
      integer, intent(in) :: cells(ndim)
      integer, parameter :: cycles = 12
      type(forest_t) :: forest, again
      character(:), allocatable :: what
      integer :: cycle, deep, recombinations, before
      forest = forest_t(lower=[-1.0_dp, 0.5_dp], cell=0.25_dp, cells=cells)
      what = to_text(cells(1))//' x '//to_text(cells(2))//' roots: '
      deep = 0
      recombinations = 0
      do cycle = 1, cycles
         before = forest%leaf_count()
         if (before > 400) then
            call change_at_random(forest, 0.0_dp, 0.5_dp, 6)
         else
            call change_at_random(forest, 0.25_dp, 0.15_dp, 6)
         end if
         if (forest%leaf_count() < before) recombinations = recombinations + 1
         deep = max(deep, forest%finest_level())
         call check(is_gapless(forest), what//'leaves follow each other in Morton order without gap or overlap')
         call check(is_balanced(forest), what//'leaves that touch differ by one level at most')
         call check(finds_its_leaves(forest), what//'every place is found in the leaf that covers it')
         again = forest
         call again%balance()
         call check(again%same_leaves(forest), what//'a balanced forest stays as it is')
         call check_nodes(forest, what)
      end do
      call check(deep >= 3 .and. recombinations > 0, what//'the random changes are of both kinds and reach several levels')
   end subroutine random_cycles

   !> Place in Morton order, counted over all roots in finest cells: bits of the coordinates taken in turn.
   pure integer(long) function morton(forest, place)
      type(forest_t), intent(in) :: forest
      integer(long), intent(in) :: place(ndim)
      integer(long) :: root(ndim), inside(ndim)
      integer :: bit, d
      root = place/level_width(0)
      inside = place - root*level_width(0)
      morton = 0
      do bit = 0, deepest - 1
         do d = 1, ndim
            morton = morton + ishft(ibits(inside(d), bit, 1), ndim*bit + d - 1)
         end do
      end do
      morton = morton + (root(1) + forest%cells(1)*root(2))*level_width(0)**2
   end function morton

   !> Whether each leaf begins, in Morton order, where the area of the one before ends, and the last ends with the lattice.
   pure logical function is_gapless(forest) result(gapless)
      type(forest_t), intent(in) :: forest
      integer(long) :: covered
      integer :: leaf
      covered = 0
      gapless = .true.
      do leaf = 1, forest%leaf_count()
         gapless = gapless .and. morton(forest, forest%place_of(leaf)) == covered
         gapless = gapless .and. all(mod(forest%place_of(leaf), level_width(forest%level_of(leaf))) == 0)
         covered = covered + level_width(forest%level_of(leaf))**2
      end do
      gapless = gapless .and. covered == product(int(forest%cells, long))*level_width(0)**2
   end function is_gapless

   !> Whether all pairs of leaves that share an edge or only a corner are of like levels.
   pure logical function is_balanced(forest) result(balanced)
      type(forest_t), intent(in) :: forest
      integer(long) :: lower(ndim, forest%leaf_count()), upper(ndim, forest%leaf_count())
      integer :: a, b
      do a = 1, forest%leaf_count()
         lower(:, a) = forest%place_of(a)
         upper(:, a) = lower(:, a) + level_width(forest%level_of(a))
      end do
      balanced = .true.
      do a = 2, forest%leaf_count()
         do b = 1, a - 1
            if (abs(forest%level_of(a) - forest%level_of(b)) < 2) cycle
            if (all(lower(:, a) <= upper(:, b) .and. lower(:, b) <= upper(:, a))) balanced = .false.
         end do
      end do
   end function is_balanced

   !> Whether leaves are found from their four extreme finest cells, and from places on their edges and inside.
   logical function finds_its_leaves(forest) result(right)
      type(forest_t), intent(in) :: forest
      integer(long) :: lower(ndim), last(ndim)
      real(dp) :: x(ndim), edge
      integer :: leaf
      right = .true.
      do leaf = 1, forest%leaf_count()
         lower = forest%place_of(leaf)
         last = lower + level_width(forest%level_of(leaf)) - 1
         edge = forest%size_of(leaf)
         call random_number(x)
         right = right .and. forest%leaf_of(lower) == leaf .and. forest%leaf_of(last) == leaf &
                 .and. forest%leaf_of([lower(1), last(2)]) == leaf .and. forest%leaf_of([last(1), lower(2)]) == leaf &
                 .and. forest%leaf_at(forest%position(lower)) == leaf &
                 .and. forest%leaf_at(forest%position(lower) + edge*x) == leaf &
                 .and. forest%leaf_at(forest%position(lower) + edge*[0.0_dp, x(2)]) == leaf &
                 .and. forest%leaf_at(forest%position(lower) + edge*[x(1), 0.0_dp]) == leaf
         x = forest%position(lower) + edge        ! the upper corner belongs to the next leaf, or to none
         right = right .and. forest%leaf_at(x) /= leaf
         if (any(last + 1 == forest%cells*level_width(0))) right = right .and. forest%leaf_at(x) == outside
      end do
   end function finds_its_leaves

   !> The number of nodes after Euler: nodes - edges + leaves = 1. An edge that leaves share is counted twice by
   !> the sum over the leaves of their 4 sides, of which one beside finer leaves is two edges; an edge of the lattice once.
   subroutine check_nodes(forest, what)
      type(forest_t), intent(in) :: forest
      character(*), intent(in) :: what
      type(grid_t) :: grid
      type(failure_t) :: failure
      integer(long) :: place(ndim), width
      integer :: leaf, side, normal, twice_the_edges, same
      call build_grid(forest, grid, failure)
      call check(.not. failure%failed(), what//'the grid is built')
      twice_the_edges = 0
      same = 0
      do leaf = 1, forest%leaf_count()
         width = level_width(forest%level_of(leaf))
         do side = 0, 3
            normal = side/2 + 1
            place = forest%place_of(leaf)
            place(normal) = place(normal) + merge(width, -1_long, mod(side, 2) == 1)
            if (any(place < 0 .or. place >= forest%cells*level_width(0))) then
               twice_the_edges = twice_the_edges + 2
            else if (forest%level_of(forest%leaf_of(place)) > forest%level_of(leaf)) then
               twice_the_edges = twice_the_edges + 2
            else
               twice_the_edges = twice_the_edges + 1
            end if
         end do
      end do
      call check(grid%n_nodes == 1 + twice_the_edges/2 - forest%leaf_count(), what//'as many nodes as Euler counts')
      if (grid%n_nodes < 400) then
         do leaf = 1, grid%n_points
            same = same + count(norm2(grid%node_position(:, leaf + 1:) &
                                      - spread(grid%node_position(:, leaf), 2, grid%n_points - leaf), 1) &
                                < 0.1_dp*grid%finest_cell)
         end do
         call check(same == 0, what//'no two points stand at one place')
      end if
   end subroutine check_nodes

   !> Refine everything three times and take it back.
   subroutine there_and_back(cells)
      integer, intent(in) :: cells(ndim)
      type(forest_t) :: forest, roots
      integer, allocatable :: change(:)
      integer :: level, count
      roots = forest_t(lower=[0.0_dp, 0.0_dp], cell=1.0_dp, cells=cells)
      forest = roots
      do level = 1, 3
         allocate (change(forest%leaf_count()), source=1)
         call forest%adapt(change)
         deallocate (change)
         call check(forest%leaf_count() == product(cells)*4**level, 'every leaf becomes four')
         call check(is_gapless(forest), 'which stand in Morton order')
      end do
      call check(.not. forest%same_leaves(roots), 'a refined forest is not the one of its roots')
      do level = 2, 0, -1
         allocate (change(forest%leaf_count()), source=-1)
         call forest%adapt(change)
         deallocate (change)
         count = forest%leaf_count()
         call check(count == product(cells)*4**level .and. forest%finest_level() == level, 'every family becomes its parent')
      end do
      call check(forest%same_leaves(roots) .and. roots%same_leaves(forest), 'recombining all leads back to the roots')
      allocate (change(forest%leaf_count()), source=-1)
      call forest%adapt(change)
      call check(forest%same_leaves(roots), 'and roots are not recombined')
   end subroutine there_and_back

   !> A family of which a member is not marked, or is finer, stays.
   subroutine only_whole_families_recombine()
      type(forest_t) :: forest, before
      forest = forest_t(lower=[0.0_dp, 0.0_dp], cell=1.0_dp, cells=[2, 1])
      call forest%adapt([1, 1])
      before = forest
      call forest%adapt([-1, -1, -1, 0, 0, -1, -1, -1])
      call check(forest%same_leaves(before), 'families that are not marked as a whole stay')
      call forest%adapt([0, 0, -1, -1, -1, -1, 0, 0])
      call check(forest%same_leaves(before), 'and so do four leaves in a row that are of two families')
      call forest%adapt([0, 0, 0, 1, 0, 0, 0, 0])
      before = forest
      call forest%adapt([-1, -1, -1, 0, 0, 0, 0, -1, -1, -1, 0])
      call check(forest%same_leaves(before), 'and one with a refined member')
      call forest%adapt([0, 0, 0, -1, -1, -1, -1, -1, -1, -1, -1])
      call check(forest%leaf_count() == 5, 'families that are marked as a whole recombine by one level')
      call check(is_gapless(forest), 'and the leaves remain in order')
   end subroutine only_whole_families_recombine

   !> One root, refined again and again at its lower corner. Each time one leaf becomes four, with five new nodes.
   subroutine deep_corner(levels)
      integer, intent(in) :: levels
      type(forest_t) :: forest
      integer, allocatable :: change(:)
      integer :: level
      forest = forest_t(lower=[0.0_dp, 0.0_dp], cell=1.0_dp, cells=[1, 1])
      do level = 1, levels
         allocate (change(forest%leaf_count()), source=0)
         change(1) = 1
         call forest%adapt(change)
         call forest%balance()
         deallocate (change)
      end do
      call check_deep(forest, levels, 1 + 3*levels, 4 + 5*levels, [0.0_dp, 0.0_dp])
   end subroutine deep_corner

   !> Four roots, refined again and again around their common corner: each time four leaves become 16, with 16 new nodes.
   subroutine deep_centre(levels)
      integer, intent(in) :: levels
      type(forest_t) :: forest
      integer, allocatable :: change(:)
      integer(long) :: centre(ndim)
      integer :: level
      forest = forest_t(lower=[-1.0_dp, -1.0_dp], cell=1.0_dp, cells=[2, 2])
      centre = level_width(0)
      do level = 1, levels
         allocate (change(forest%leaf_count()), source=0)
         change(forest%leaf_of(centre)) = 1
         change(forest%leaf_of(centre - 1)) = 1
         change(forest%leaf_of(centre - [1, 0])) = 1
         change(forest%leaf_of(centre - [0, 1])) = 1
         call forest%adapt(change)
         call forest%balance()
         deallocate (change)
      end do
      call check_deep(forest, levels, 4 + 12*levels, 9 + 16*levels, [0.0_dp, 0.0_dp])
   end subroutine deep_centre

   subroutine check_deep(forest, levels, leaves, nodes, finest_at)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: levels, leaves, nodes
      real(dp), intent(in) :: finest_at(ndim)
      type(grid_t) :: grid
      type(failure_t) :: failure
      character(:), allocatable :: what
      real(dp) :: edge
      integer :: e, node, wrong
      what = to_text(levels)//' levels: '
      call build_grid(forest, grid, failure)
      call check(forest%leaf_count() == leaves, what//'as many leaves as the construction has')
      call check(grid%n_nodes == nodes, what//'as many nodes as the construction has')
      call check(is_gapless(forest) .and. is_balanced(forest), what//'the leaves are without gap and balanced')
      call check(finds_its_leaves(forest), what//'every place is found in the leaf that covers it')
      call check_nodes(forest, what)
      edge = forest%size_of(forest%leaf_at(finest_at))
      call check_close(edge, 0.5_dp**levels, 0.0_dp, what//'the finest leaf has its size exactly')
      wrong = 0
      do node = 1, grid%n_nodes
         if (grid%node_at(grid%node_position(:, node)) /= node) wrong = wrong + 1
      end do
      call check(wrong == 0, what//'every node is found at its place')
      wrong = 0
      do e = 1, grid%n_elements
         if (grid%element_at(grid%element_lower(:, e)) /= e) wrong = wrong + 1
         if (grid%element_at(grid%element_lower(:, e) + (1 - 1.0e-6_dp)*grid%element_size(e)) /= e) wrong = wrong + 1
      end do
      call check(wrong == 0, what//'every element covers its lower corner and all that is nearer than the upper one')
   end subroutine check_deep

   !> With a corner and a cell that no binary number is, a place computed for an edge is on one side or the other: it is in a leaf
   !> that has the edge, and what is not a place is in none.
   subroutine rough_coordinates()
      type(forest_t) :: forest
      real(dp) :: x(ndim), from_leaf(ndim), r(ndim), farthest
      integer :: leaf, found, k, lost
      forest = forest_t(lower=[0.1_dp, -0.7_dp], cell=0.3_dp, cells=[3, 2])
      do k = 1, 5
         call change_at_random(forest, 0.3_dp, 0.0_dp, 5)
      end do
      lost = 0
      farthest = 0
      do leaf = 1, forest%leaf_count()
         do k = 1, 20
            call random_number(r)
            if (mod(k, 2) == 0) r(1) = nint(r(1))
            if (mod(k, 3) == 0) r(2) = nint(r(2))
            x = forest%position(forest%place_of(leaf)) + r*forest%size_of(leaf)
            found = forest%leaf_at(x)
            if (found == outside) then            ! only the upper edges of the lattice are
               if (all(x < forest%lower + forest%cells*forest%cell*(1 - 4*epsilon(x)))) lost = lost + 1
               cycle
            end if
            from_leaf = (x - forest%position(forest%place_of(found)))/forest%size_of(found)
            farthest = max(farthest, maxval(abs(from_leaf - 0.5_dp)) - 0.5_dp)
         end do
      end do
      call check(lost == 0, 'no place in the lattice is lost to rounding')
      call check_close(farthest, 0.0_dp, 200*epsilon(x), 'a place is in a leaf that it touches')
      x = forest%lower + 0.1_dp
      call ieee_set_halting_mode(ieee_invalid, .false.)
      do k = 1, ndim
         r = x
         r(k) = ieee_value(1.0_dp, ieee_quiet_nan)
         call check(forest%leaf_at(r) == outside, 'a place that is not a number is outside a refined forest')
         r(k) = -ieee_value(1.0_dp, ieee_positive_inf)
         call check(forest%leaf_at(r) == outside, 'so is one at infinity')
         r(k) = forest%lower(k) - 1.0e-12_dp
         call check(forest%leaf_at(r) == outside, 'and one below the lower edge')
         r(k) = 1.0e300_dp
         call check(forest%leaf_at(r) == outside, 'and one far away')
      end do
      call ieee_set_flag(ieee_invalid, .false.)
   end subroutine rough_coordinates
end program test_refined_forest
