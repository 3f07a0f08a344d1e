!> Grids that lines in any direction cut: lines that run through part them into as many parts as there are, lines that end do not, and
!> hanging nodes stay where they are; with cells of four sizes, and lines along grid lines, through nodes, and with kinks.
program test_cut_cells
   use hampm_kinds, only: dp, ndim, corners
   use hampm_crack_lines, only: line_t
   use hampm_disjoint_sets, only: disjoint_sets_t, singletons
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, finish, repeat_random_numbers
   use hampm_refined, only: refine_box
   use hampm_text, only: to_text
   implicit none

   integer, parameter :: trials = 60, levels = 3
   real(dp), parameter :: far = 40
   type(grid_t) :: grid
   integer :: trial

   call repeat_random_numbers()
   do trial = 1, trials
      call random_line(trial)
   end do
   call some_lines()
   call an_end()
   call finish()

contains

   !> A forest with finer and finer cells around a place.
   function refined(centre) result(forest)
      real(dp), intent(in) :: centre(ndim)
      type(forest_t) :: forest
      real(dp) :: reach
      integer :: level
      forest = forest_t([-8.0_dp, -8.0_dp], 1.0_dp, [17, 17])
      do level = 1, levels
         reach = scale(3.3_dp, 1 - level)        ! of the cells that are refined
         call refine_box(forest, centre - reach, centre + reach, level)
      end do
   end function refined

   !> Cut the grid of a forest by lines.
   subroutine cut(forest, lines)
      type(forest_t), intent(in) :: forest
      type(line_t), intent(in) :: lines(:)
      type(failure_t) :: failure
      call build_grid(forest, grid, failure, lines=lines)
      call check(.not. failure%failed(), 'a grid is built')
   end subroutine cut

   !> A line through a place in a direction, which may turn there.
   pure type(line_t) function line_through(x, angle, turn) result(line)
      real(dp), intent(in) :: x(ndim), angle, turn
      real(dp) :: before(ndim), after(ndim)
      before = x - far*[cos(angle), sin(angle)]
      after = x + far*[cos(angle + turn), sin(angle + turn)]
      allocate (line%points, source=reshape([before, x, after], [ndim, 3]))
   end function line_through

   !> A line that runs through parts the grid in two; every fifth is along a grid line or a diagonal, every seventh through a place on
   !> quarters of cells, every third turns.
   subroutine random_line(trial)
      integer, intent(in) :: trial
      type(line_t) :: lines(1)
      real(dp) :: angle, x(ndim), y(ndim), turn
      call random_number(angle)
      call random_number(x)
      call random_number(y)
      if (mod(trial, 5) == 0) angle = 0.125_dp*nint(8*angle)
      if (mod(trial, 7) == 0) x = anint(4*x)/4
      turn = merge(1.3_dp*(y(1) - 0.5_dp), 0.0_dp, mod(trial, 3) == 0)
      lines(1) = line_through(x, 2*acos(-1.0_dp)*angle, turn)
      call cut(refined(4*(y - 0.5_dp)), lines)
      call check(parts() == 2, 'line '//to_text(trial)//' parts the grid in two, not '//to_text(parts()))
      call check(hanging_nodes_are_in_place(), 'hanging nodes of line '//to_text(trial)//' are where their masters have them')
      call check(sides_are_right(grid%cut_cells%lines(1)%points, turn > 0), 'sides of line '//to_text(trial)//' are left and right')
   end subroutine random_line

   !> Whether places in leaves that are cut have their side of a line with a kink, and others none. To the left of a line that turns to the
   !> left is what is to the left of both of its parts, of one that turns to the right what is to the left of one of them.
   logical function sides_are_right(points, turns_left) result(yes)
      real(dp), intent(in) :: points(:, :)
      logical, intent(in) :: turns_left
      real(dp) :: x(ndim), height(2)
      integer :: k, leaf, side
      yes = .true.
      do k = 1, 300
         call random_number(x)
         x = points(:, 2) + 6*x - 3
         leaf = grid%forest%leaf_at(x)
         side = grid%cut_cells%side_at(leaf, x)
         if (grid%cut_cells%pieces_of(leaf) == 1) then
            yes = yes .and. side == 0
            cycle
         end if
         height = [left_of(points(:, 1), points(:, 2), x), left_of(points(:, 2), points(:, 3), x)]
         yes = yes .and. side == merge(1, -1, merge(minval(height), maxval(height), turns_left) > 0)
      end do
   end function sides_are_right

   !> Above 0 to the left of the line from a to b.
   pure real(dp) function left_of(a, b, x)
      real(dp), intent(in) :: a(ndim), b(ndim), x(ndim)
      left_of = (b(1) - a(1))*(x(2) - a(2)) - (b(2) - a(2))*(x(1) - a(1))
   end function left_of

   !> Two lines that cross part it in four, a third one that ends on one of them in five.
   subroutine some_lines()
      type(line_t) :: lines(3)
      lines(1) = line_through([0.3_dp, 0.1_dp], 0.4_dp, 0.0_dp)
      lines(2) = line_through([0.4_dp, -0.2_dp], 1.9_dp, 0.0_dp)
      call cut(refined([0.5_dp, 0.5_dp]), lines(:2))
      call check(parts() == 4, 'two lines that cross part the grid in four, not '//to_text(parts()))
      lines(3)%points = reshape([-4.0_dp, 0.1_dp + tan(0.4_dp)*(-4.3_dp), -5.0_dp, far], [ndim, 2])
      lines(3)%points(:, 1) = lines(3)%points(:, 1) - 1e-4_dp*[0.0_dp, 1.0_dp]
      call cut(refined([0.5_dp, 0.5_dp]), lines)
      call check(parts() == 5, 'one more that ends on one of them in five, not '//to_text(parts()))
   end subroutine some_lines

   !> A line that ends leaves the grid in one part, with copies of nodes behind its end; its tip is moved to where its leaf ends.
   subroutine an_end()
      type(line_t) :: line
      type(forest_t) :: forest
      forest = forest_t([-8.0_dp, -8.0_dp], 1.0_dp, [17, 17])
      line%points = reshape([-far, 0.3_dp, 0.4_dp, 0.3_dp], [ndim, 2])
      line%is_tip = [.false., .true.]
      call cut(forest, [line])
      call check(parts() == 1, 'a line that ends leaves the grid in one part')
      call check(grid%n_nodes == 18**2 + 2*9, 'nodes at both edges of nine cells have copies')
      call check(size(grid%cut_cells%ends) == 1 .and. grid%cut_cells%ends(1)%leaf > 0, 'the leaf of its end is known')
      call check(norm2(grid%cut_cells%ends(1)%front - [1.0_dp, 0.3_dp]) < 1e-12_dp, 'and where the line leaves it')
      call check(grid%element_at([0.2_dp, 0.6_dp]) /= grid%element_at([0.2_dp, 0.1_dp]), 'above and below it are two elements')
      call check(grid%element_at([1.2_dp, 0.6_dp]) == grid%element_at([1.2_dp, 0.1_dp]), 'ahead of it is one')
   end subroutine an_end

   !> Into how many parts the grid falls: nodes are together where an element depends on them.
   integer function parts()
      type(disjoint_sets_t) :: sets
      integer :: master(most_nodes_of_leaf), n, e, k
      real(dp) :: weight(corners, most_nodes_of_leaf)
      call singletons(grid%n_nodes, sets)
      do e = 1, grid%n_elements
         call grid%dofs%masters_of(grid%element_nodes(:, e), n, master, weight)
         do k = 2, n
            call sets%join(master(1), master(k))
         end do
      end do
      parts = sets%how_many()
   end function parts

   !> Whether hanging nodes are at the means of their masters.
   logical function hanging_nodes_are_in_place() result(yes)
      real(dp) :: x(ndim, grid%n_points)
      x = grid%node_position
      call grid%dofs%distribute(grid%dofs%every_node(), ndim, x)
      yes = maxval(abs(x - grid%node_position)) < 1e-9_dp
   end function hanging_nodes_are_in_place
end program test_cut_cells
