!> The tables between elements and nodes of a grid say the same in both directions.
program test_grid
   use hampm_kinds, only: dp, ndim, corners
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_outline, only: outline_t, polygon_ring, circle_ring
   use hampm_random_forests, only: change_at_random
   implicit none

   type(grid_t) :: grid
   type(failure_t) :: failure

   call build_grid(forest_t(lower=[0.1_dp, -0.3_dp], cell=0.07_dp, cells=[6, 4]), grid, failure)
   call check(.not. failure%failed(), 'the grid is built')
   call check(grid%n_elements == 24 .and. grid%n_nodes == 35, 'as many elements and nodes as the lattice has')
   call corners_of_elements()
   call elements_of_nodes()
   call places_of_nodes()
   call repeat_random_numbers()
   call masters_around_holes()
   call finish()

contains

   subroutine corners_of_elements()
      real(dp) :: xi(ndim), error
      integer :: e, c, d
      error = 0
      do e = 1, grid%n_elements
         do c = 1, corners
            xi = grid%local_coordinate(e, grid%node_position(:, grid%element_nodes(c, e)))
            error = max(error, maxval(abs(xi - [(real(ibits(c - 1, d - 1, 1), dp), d=1, ndim)])))
         end do
      end do
      call check_close(error, 0.0_dp, 1.0e-14_dp, 'the nodes of an element stand at its corners')
   end subroutine corners_of_elements

   subroutine elements_of_nodes()
      integer :: node, k, last, wrong, seen(corners, grid%n_elements)
      wrong = 0
      seen = 0
      do node = 1, grid%n_nodes
         last = 0
         associate (elements => grid%dofs%elements_at(node), corner => grid%dofs%corners_at(node))
            do k = 1, size(elements)
               associate (e => elements(k), c => corner(k))
                  seen(c, e) = seen(c, e) + 1
                  if (grid%element_nodes(c, e) /= node .or. e <= last) wrong = wrong + 1
                  last = e
               end associate
            end do
         end associate
      end do
      call check(wrong == 0, 'the elements around a node have it as the corner that is noted, in ascending order')
      call check(all(seen == 1), 'every corner of every element is listed at one node, once')
   end subroutine elements_of_nodes

   subroutine places_of_nodes()
      integer :: node, wrong
      wrong = 0
      do node = 1, grid%n_nodes
         if (grid%node_at(grid%node_position(:, node)) /= node) wrong = wrong + 1
         if (grid%node_at(grid%node_position(:, node) + 1.0e-9_dp*grid%forest%cell) /= node) wrong = wrong + 1
         if (grid%node_at(grid%node_position(:, node) + 0.5_dp*grid%forest%cell) /= 0) wrong = wrong + 1
      end do
      call check(wrong == 0, 'node_at finds every node at its place and none between nodes')
      call check(grid%node_at(grid%forest%lower + [7, 0]*grid%forest%cell) == 0, 'nor beyond the upper edge of the grid')
      call check(grid%node_at(grid%forest%lower + [0, -1]*grid%forest%cell) == 0, 'nor below the lower edge')
   end subroutine places_of_nodes

   !> Around a hole, where nearly empty cells and refined ones meet, hanging nodes have nodes with degrees of freedom as masters, and in cells with
   !> material the weighted mean of the places of these as their own.
   subroutine masters_around_holes()
      integer, parameter :: meshes = 40
      type(outline_t), allocatable :: bodies(:)
      type(forest_t) :: forest
      real(dp) :: place(ndim, corners), weight(corners, 9), x(2), error
      integer :: mesh, e, n, master(9), wrong
      wrong = 0
      error = 0
      do mesh = 1, meshes
         forest = forest_t(lower=[0.0_dp, 0.0_dp], cell=1.0_dp, cells=[9, 9])
         call change_at_random(forest, 0.1_dp, 0.0_dp, 1)
         call random_number(x)
         if (allocated(bodies)) deallocate (bodies)
         allocate (bodies(1))
         allocate (bodies(1)%rings(2))
         bodies(1)%rings(1) = polygon_ring(reshape([0.0_dp, 0.0_dp, 9.0_dp, 0.0_dp, 9.0_dp, 9.0_dp, 0.0_dp, 9.0_dp], [ndim, 4]))
         bodies(1)%rings(2) = circle_ring(4 + x, 2.8_dp)
         call build_grid(forest, grid, failure, bodies=bodies)
         wrong = wrong + count(grid%dofs%master > grid%n_nodes)
         do e = 1, grid%n_elements
            if (.not. grid%is_met(grid%element_leaf(e))) cycle
            call grid%dofs%masters_of(grid%element_nodes(:, e), n, master, weight)
            place = matmul(grid%node_position(:, master(:n)), transpose(weight(:, :n)))
            error = max(error, maxval(abs(place - grid%node_position(:, grid%element_nodes(:, e)))))
         end do
      end do
      call check(wrong == 0, 'masters have degrees of freedom')
      call check_close(error, 0.0_dp, 1e-13_dp, 'hanging nodes are where their masters say')
   end subroutine masters_around_holes
end program test_grid
