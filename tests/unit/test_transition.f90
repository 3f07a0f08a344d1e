!> Elements beside finer ones: for every set of nodes in the middle of their sides their shape functions are what convergence,
!> conservation and positive masses rest on.
!>
!> The shape functions are taken as functions of place by node, over all the grid: from `masters_of` and the shape functions
!> of the element. What is expected of them follows from their definition alone.
program test_transition
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_basis, only: shape_functions, shape_gradients
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t, corner_offset, level_width
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_node_list, only: node_list_t
   use hampm_random_forests, only: change_at_random
   use hampm_text, only: to_text
   implicit none

   integer, parameter :: sides = 4               !! numbered lower and upper in x, lower and upper in y
   integer, parameter :: neighbour(sides) = [4, 6, 2, 8] !! root beside each side of root 5, of three by three roots
   real(dp), parameter :: rounding = 200*epsilon(1.0_dp) !! of places up to 100 of the finest cells from the origin
   type(grid_t) :: grid
   integer :: k, kinds_seen(0:15)

   call repeat_random_numbers()
   do k = 0, 15
      call build(around_middle(k))
      call check_nodes_of_middle(k)
      call check_middle_value(k)
      call check_functions('mid-side nodes '//list_of(k)//': ')
   end do
   kinds_seen = 0
   do k = 1, 40
      call build(random_forest())
      call count_kinds()
      call check_functions('random mesh '//to_text(k)//': ')
   end do
   call check(all(kinds_seen > 0), 'the random meshes have elements of all kinds')
   call finish()

contains

   subroutine build(forest)
      type(forest_t), intent(in) :: forest
      type(failure_t) :: failure
      call build_grid(forest, grid, failure)
      call check(.not. failure%failed(), 'the grid is built')
   end subroutine build

   !> Three by three roots, of which those beside the middle one are refined where `set` has the bit of the side.
   function around_middle(set) result(forest)
      integer, intent(in) :: set
      type(forest_t) :: forest
      integer :: change(9)
      forest = forest_t(lower=[0.5_dp, -1.0_dp], cell=0.75_dp, cells=[3, 3])
      change = 0
      change(neighbour) = ibits(set, [0, 1, 2, 3], 1)
      call forest%adapt(change)
      call forest%balance()
   end function around_middle

   function random_forest() result(forest)
      type(forest_t) :: forest
      integer :: k
      forest = forest_t(lower=[0.5_dp, -1.0_dp], cell=0.75_dp, cells=[5, 4])
      do k = 1, 3
         call change_at_random(forest, 0.2_dp, 0.0_dp, 4)
      end do
   end function random_forest

   !> The sides of a set, as text.
   function list_of(set) result(text)
      integer, intent(in) :: set
      character(:), allocatable :: text
      integer :: side
      text = ''
      do side = 1, sides
         if (btest(set, side - 1)) text = text//to_text(side)
      end do
      if (text == '') text = 'none'
   end function list_of

   !> Middle of a side of a leaf [m].
   pure function middle_of_side(leaf, side) result(x)
      integer, intent(in) :: leaf, side
      real(dp) :: x(ndim)
      integer :: normal
      normal = (side + 1)/2
      x = grid%forest%position(grid%forest%place_of(leaf)) + 0.5_dp*grid%forest%size_of(leaf)
      x(normal) = x(normal) + (mod(side - 1, 2) - 0.5_dp)*grid%forest%size_of(leaf)
   end function middle_of_side

   !> The leaf in the middle has the nodes that it was given, and is a transition element where there are any.
   subroutine check_nodes_of_middle(set)
      integer, intent(in) :: set
      integer :: leaf, side, e, n, node(most_nodes_of_leaf)
      real(dp) :: part(corners, most_nodes_of_leaf)
      logical :: met(grid%n_nodes)
      leaf = grid%forest%leaf_of(level_width(0) + [0_long, 0_long])
      call check(grid%is_transition(leaf) .eqv. set > 0, &
                 list_of(set)//': a node in the middle of a side makes a transition element')
      met = .false.
      do e = grid%leaf_element(leaf), grid%leaf_element(leaf + 1) - 1
         call grid%dofs%masters_of(grid%element_nodes(:, e), n, node, part)
         met(node(:n)) = .true.
      end do
      call check(count(met) == corners + popcnt(set), list_of(set)//': of four to eight nodes, as the sides have it')
      do side = 1, sides
         call check(grid%node_at(middle_of_side(leaf, side)) > 0 .eqv. btest(set, side - 1), &
                    list_of(set)//': there is a node in the middle of side '//to_text(side)//' or none')
      end do
   end subroutine check_nodes_of_middle

   !> The value in the middle is the mean of those in the middles of the sides, and without a node there that is the mean of the
   !> corners of the side.
   subroutine check_middle_value(set)
      integer, intent(in) :: set
      real(dp) :: expected(grid%n_nodes), x(ndim), edge
      integer :: leaf, side, along, k, node
      leaf = grid%forest%leaf_of(level_width(0) + [0_long, 0_long])
      edge = grid%forest%size_of(leaf)
      expected = 0
      do side = 1, sides
         if (btest(set, side - 1)) then
            node = grid%node_at(middle_of_side(leaf, side))
            expected(node) = expected(node) + 0.25_dp
         else
            along = 3 - (side + 1)/2
            do k = 0, 1
               x = middle_of_side(leaf, side)
               x(along) = x(along) + (k - 0.5_dp)*edge
               node = grid%node_at(x)
               expected(node) = expected(node) + 0.125_dp
            end do
         end if
      end do
      x = grid%forest%position(grid%forest%place_of(leaf)) + 0.5_dp*edge
      call check_close(maxval(abs(functions_at(grid%element_at(x), x) - expected)), 0.0_dp, rounding, &
                       list_of(set)//': the value in the middle is the mean of those in the middles of the sides')
   end subroutine check_middle_value

   !> Count the leaves with each set of nodes in the middle of their sides.
   subroutine count_kinds()
      integer :: leaf, side, set
      do leaf = 1, grid%forest%leaf_count()
         set = 0
         do side = 1, sides
            if (grid%node_at(middle_of_side(leaf, side)) > 0) set = ibset(set, side - 1)
         end do
         kinds_seen(set) = kinds_seen(set) + 1
      end do
   end subroutine count_kinds

   !> Shape functions of all nodes at a place in element `e` or on its edge.
   function functions_at(e, x) result(n)
      integer, intent(in) :: e
      real(dp), intent(in) :: x(ndim)
      real(dp) :: n(grid%n_nodes)
      integer :: k, node(most_nodes_of_leaf)
      real(dp) :: part(corners, most_nodes_of_leaf)
      call grid%dofs%masters_of(grid%element_nodes(:, e), k, node, part)
      n = 0
      n(node(:k)) = matmul(shape_functions(grid%local_coordinate(e, x)), part(:, :k))
   end function functions_at

   !> Their gradients [1/m].
   function gradients_at(e, x) result(gradient)
      integer, intent(in) :: e
      real(dp), intent(in) :: x(ndim)
      real(dp) :: gradient(ndim, grid%n_nodes)
      integer :: k, node(most_nodes_of_leaf)
      real(dp) :: part(corners, most_nodes_of_leaf)
      call grid%dofs%masters_of(grid%element_nodes(:, e), k, node, part)
      gradient = 0
      gradient(:, node(:k)) = matmul(transpose(shape_gradients(grid%local_coordinate(e, x), 1/grid%element_size(e))), &
                                     part(:, :k))
   end function gradients_at

   subroutine check_functions(what)
      character(*), intent(in) :: what
      call check_weights(what)
      call check_expansion(what)
      call check_inside(what)
      call check_at_nodes(what)
      call check_edges(what)
      call check_quarters(what)
   end subroutine check_functions

   !> Weights of the masters of hanging nodes.
   subroutine check_weights(what)
      character(*), intent(in) :: what
      real(dp) :: error
      integer :: k
      error = 0
      associate (d => grid%dofs)
         do k = 1, d%n_hanging
            associate (weight => d%weight(d%first_master(k):d%first_master(k + 1) - 1), &
                       node => d%master(d%first_master(k):d%first_master(k + 1) - 1))
               error = max(error, abs(sum(weight) - 1), maxval(abs(matmul(grid%node_position(:, node), weight) &
                                                                   - grid%node_position(:, d%n_nodes + k))))
            end associate
         end do
         call check(all(d%weight > 0), what//'weights of masters are positive')
         call check(all(d%master <= grid%n_nodes .and. d%master > 0), what//'and masters have degrees of freedom')
      end associate
      call check_close(error, 0.0_dp, rounding, what//'weights sum to one and have the hanging node as their centre')
   end subroutine check_weights

   !> What a step does with hanging nodes: their values are those of the shape functions there, and what is summed at them does the
   !> same work on their masters, to which it is condensed, as it did where it was.
   subroutine check_expansion(what)
      character(*), intent(in) :: what
      real(dp) :: x(ndim, grid%n_points), y(ndim, grid%n_points), error, work(2)
      type(node_list_t) :: all
      integer :: node, e
      all = grid%dofs%every_node()
      call random_number(x)
      call random_number(y)
      call grid%dofs%distribute(all, ndim, x)
      error = 0
      do node = grid%n_nodes + 1, grid%n_points
         associate (place => grid%node_position(:, node))
            do e = 1, grid%n_elements
               if (touches(e, place)) error = max(error, maxval(abs(matmul(x(:, :grid%n_nodes), functions_at(e, place)) &
                                                                    - x(:, node))))
            end do
         end associate
      end do
      call check_close(error, 0.0_dp, rounding, what//'values at hanging nodes are those of the shape functions')
      work(1) = sum(x*y)
      call grid%dofs%condense(all, ndim, y)
      work(2) = sum(x*y)
      call check_close(work(2)/work(1), 1.0_dp, rounding, what//'forces do the same work on the nodes they are given to')
      call check(maxval(abs(y(:, grid%n_nodes + 1:))) <= 0, what//'of which nothing is left behind')
   end subroutine check_expansion

   !> At random places: sum, linear fields and sign.
   subroutine check_inside(what)
      character(*), intent(in) :: what
      integer, parameter :: places = 6
      real(dp) :: x(ndim), n(grid%n_nodes), gradient(ndim, grid%n_nodes), error(4), least
      integer :: e, k
      error = 0
      least = 1
      associate (position => grid%node_position(:, :grid%n_nodes))
         do e = 1, grid%n_elements
            do k = 1, places
               call random_number(x)
               x = grid%element_lower(:, e) + grid%element_size(e)*x
               n = functions_at(e, x)
               gradient = gradients_at(e, x)
               error(1) = max(error(1), abs(sum(n) - 1))
               error(2) = max(error(2), maxval(abs(matmul(position, n) - x)))
               error(3) = max(error(3), maxval(abs(sum(gradient, dim=2)))*grid%element_size(e))
               error(4) = max(error(4), maxval(abs(matmul(position, transpose(gradient)) &
                                                   - reshape([1, 0, 0, 1], [ndim, ndim])))*grid%element_size(e))
               least = min(least, minval(n))
            end do
         end do
      end associate
      call check_close(error(1), 0.0_dp, rounding, what//'shape functions sum to one')
      call check_close(error(2), 0.0_dp, rounding, what//'a linear field is interpolated exactly')
      call check_close(error(3), 0.0_dp, rounding, what//'gradients sum to zero')
      call check_close(error(4), 0.0_dp, rounding, what//'the gradient of a linear field is exact')
      call check(least >= 0, what//'shape functions are nowhere negative')
   end subroutine check_inside

   !> At the nodes.
   subroutine check_at_nodes(what)
      character(*), intent(in) :: what
      real(dp) :: expected(grid%n_nodes), error
      integer :: node, e
      error = 0
      do node = 1, grid%n_nodes
         expected = 0
         expected(node) = 1
         do e = 1, grid%n_elements
            if (.not. touches(e, grid%node_position(:, node))) cycle
            error = max(error, maxval(abs(functions_at(e, grid%node_position(:, node)) - expected)))
         end do
      end do
      call check_close(error, 0.0_dp, rounding, what//'at a node its own function is one and the others are zero')
   end subroutine check_at_nodes

   !> Whether a place is in an element or on its edge.
   pure logical function touches(e, x)
      integer, intent(in) :: e
      real(dp), intent(in) :: x(ndim)
      associate (xi => grid%local_coordinate(e, x))
         touches = all(xi > -1.0e-9_dp .and. xi < 1 + 1.0e-9_dp)
      end associate
   end function touches

   !> On every edge: values and derivatives along the edge are those of all the elements that meet there, whether of one leaf, of
   !> leaves of one size, or of a coarse and a fine one.
   subroutine check_edges(what)
      character(*), intent(in) :: what
      real(dp) :: x(ndim), n(grid%n_nodes), slope(ndim, grid%n_nodes), other(ndim, grid%n_nodes), jump, kink, r
      integer :: e, b, side, along, k, pairs(2)
      jump = 0
      kink = 0
      pairs = 0
      do e = 1, grid%n_elements
         do side = 1, sides
            along = 3 - (side + 1)/2
            do k = 1, 2
               call random_number(r)
               x = grid%element_lower(:, e)
               x(3 - along) = x(3 - along) + mod(side - 1, 2)*grid%element_size(e)
               x(along) = x(along) + r*grid%element_size(e)
               n = functions_at(e, x)
               slope = gradients_at(e, x)
               do b = 1, grid%n_elements
                  if (b == e .or. .not. touches(b, x)) cycle
                  other = gradients_at(b, x)
                  jump = max(jump, maxval(abs(functions_at(b, x) - n)))
                  kink = max(kink, maxval(abs(other(along, :) - slope(along, :)))*grid%element_size(e))
                  if (grid%forest%level_of(grid%element_leaf(b)) == grid%forest%level_of(grid%element_leaf(e))) then
                     pairs(1) = pairs(1) + 1
                  else
                     pairs(2) = pairs(2) + 1
                  end if
               end do
            end do
         end do
      end do
      call check_close(jump, 0.0_dp, rounding, what//'shape functions are continuous across every edge')
      call check_close(kink, 0.0_dp, rounding, what//'and so are their derivatives along it')
      call check(pairs(1) > 0 .and. (pairs(2) > 0 .or. grid%forest%finest_level() == 0), &
                 what//'edges of like and of unlike leaves were looked at')
   end subroutine check_edges

   !> In each quarter of a transition element and in each other leaf, along a line in x or y each function is a straight line.
   subroutine check_quarters(what)
      character(*), intent(in) :: what
      real(dp) :: x(ndim, 3), n(grid%n_nodes, 3), r, width, error
      integer :: leaf, quarter, along, k, e(3), strays
      error = 0
      strays = 0
      do leaf = 1, grid%forest%leaf_count()
         do quarter = 1, corners
            do along = 1, ndim
               width = grid%forest%size_of(leaf)/2
               call random_number(r)
               do k = 1, 3
                  x(along, k) = 0.5_dp*(k - 1)*0.999_dp
                  x(3 - along, k) = r
                  x(:, k) = grid%forest%position(grid%forest%place_of(leaf)) + width*(corner_offset(quarter) + x(:, k))
                  e(k) = grid%element_at(x(:, k))
                  n(:, k) = functions_at(e(k), x(:, k))
                  if (grid%element_leaf(e(k)) /= leaf .or. .not. touches(e(k), x(:, k))) strays = strays + 1
               end do
               error = max(error, maxval(abs(n(:, 1) - 2*n(:, 2) + n(:, 3))))
               if (any(e /= e(1))) strays = strays + 1
            end do
         end do
      end do
      call check(strays == 0, what//'a quarter of a leaf is in one element, of this leaf')
      call check_close(error, 0.0_dp, rounding, what//'functions are bilinear in quarters')
   end subroutine check_quarters
end program test_transition
