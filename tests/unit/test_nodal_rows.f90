!> The nodal equations: products by rows, and solution by conjugate gradients.
program test_nodal_rows
   use hampm_kinds, only: dp, ndim, corners, neighbours
   use hampm_constraints, only: constraints_t
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_mass_choice, only: new_mass_choice
   use hampm_mass_solver, only: mass_solver_t, new_mass_solver, solve_mass
   use hampm_material, only: material_t
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_nodal_rows, only: pattern_t, spans_t, pattern_of_grid, find_spans, sum_rows, multiply_rows
   use hampm_samples, only: rectangle_t, place_bodies, start
   implicit none
   call repeat_random_numbers()
   call rows_of_cells()
   call solution()
   call finish()

contains

   !> Products by rows are those by cells, also at some of the nodes only and over several chunks.
   subroutine rows_of_cells()
      integer, parameter :: nodes(13) = [1, 2, 3, 4, 6, 8, 9, 10, 11, 12, 13, 19, 20]
      type(grid_t) :: grid
      type(failure_t) :: failure
      type(pattern_t) :: pattern
      type(spans_t) :: spans
      real(dp), allocatable :: cell(:, :, :), row(:, :), ones(:, :), x(:, :), y(:, :), expected(:, :)
      real(dp) :: xax(ndim), part(ndim)
      integer :: e, chunk, first, status
      call build_grid(forest_t([0.0_dp, 0.0_dp], 1.0_dp, [4, 3]), grid, failure)
      allocate (cell(corners, corners, grid%n_elements), row(neighbours, grid%n_nodes), x(ndim, grid%n_nodes), &
                y(ndim, grid%n_nodes))
      allocate (ones(ndim, grid%n_nodes), source=1.0_dp)
      allocate (expected(ndim, grid%n_nodes), source=0.0_dp)
      call random_number(cell)
      call random_number(x)
      do e = 1, grid%n_elements
         cell(:, :, e) = cell(:, :, e) + transpose(cell(:, :, e))
         associate (at => grid%element_nodes(:, e))
            expected(:, at) = expected(:, at) + matmul(x(:, at), cell(:, :, e))
         end associate
      end do
      call pattern_of_grid(grid, pattern, status)
      call check(status == 0 .and. pattern%width == neighbours, 'on like cells each node has nine neighbours, itself included')
      call sum_rows(pattern, size(nodes), nodes, cell, row)
      call find_spans(pattern, nodes, 5, spans)
      y = 0
      xax = 0
      do chunk = 1, 3
         first = spans%of_chunk(chunk)
         call multiply_rows(neighbours, spans%of_chunk(chunk + 1) - first, spans%first(first), spans%last(first), &
                            spans%offset(1, first), &
                            row, ones, x, y, part)
         xax = xax + part
      end do
      call check(sum(spans%last - spans%first + 1) == size(nodes), 'spans have every node once')
      call check_close(maxval(abs(y(:, nodes) - expected(:, nodes))), 0.0_dp, 1.0e-13_dp, 'a product by rows is that by cells')
      call check_close(maxval(abs(xax - sum(x(:, nodes)*expected(:, nodes), dim=2))), 0.0_dp, 1.0e-12_dp, &
                       'the quadratic form is x.A x')
   end subroutine rows_of_cells

   !> With the particles at the quarter points the eigenvalues of the preconditioned matrix are 1 to (25/16)**2, so that
   !> conjugate gradients gain a factor of (25 - 16)/(25 + 16) at least with each iteration.
   subroutine solution()
      type(problem_t) :: m
      type(mass_solver_t) :: cg, direct
      type(failure_t) :: failure
      real(dp), allocatable :: b(:, :), x(:, :), y(:, :)
      integer :: most
      call place_bodies(forest_t([0.0_dp, 0.0_dp], 1.0_dp, [30, 22]), material_t(), &
                        [rectangle_t([1.0_dp, 1.0_dp], [29.0_dp, 21.0_dp], [56, 40])], m)
      m%particles%mass = 1
      call start(m, 'musl', new_mass_choice('consistent', 'cg', 1, 0.0_dp, [0.0_dp, 0.0_dp], [0.0_dp, 0.0_dp]))
      call refresh_grid(m)
      allocate (b(ndim, m%grid%n_nodes), y(ndim, m%grid%n_nodes))
      allocate (x(ndim, m%grid%n_nodes), source=0.0_dp)
      call random_number(b)
      b = (b - 0.3_dp)*spread(m%fields%mass_matrix%lumped, 1, ndim)
      call new_mass_solver(m%mass%by, 1, m%grid, constraints_t(), cg, failure)
      call solve_mass(cg, m%grid, m%fields%mass_matrix, b, x, failure)
      call check(.not. failure%failed(), 'the equations have a solution')
      most = ceiling(log(2.0_dp*sqrt(16.0_dp)/1.0e-13_dp)/log(41.0_dp/9.0_dp))
      call check(cg%iterations <= most, 'from any guess as few iterations as the eigenvalues promise')
      call check_close(maxval(abs(sum(spread(m%fields%mass_matrix%lumped, 1, ndim)*x, dim=2) - sum(b, dim=2))), 0.0_dp, &
                       1.0e-13_dp*sum(abs(b)), 'the sum of M x is that of b')
      m%mass = new_mass_choice('consistent', 'direct', 1, 0.0_dp, [0.0_dp, 0.0_dp], [0.0_dp, 0.0_dp])
      call new_mass_solver(m%mass%by, 1, m%grid, constraints_t(), direct, failure)
      y = 0
      call solve_mass(direct, m%grid, m%fields%mass_matrix, b, y, failure)
      call check_close(maxval(abs(x - y)), 0.0_dp, 1.0e-11_dp*maxval(abs(y)), 'conjugate gradients and factorisation agree')
   end subroutine solution
end program test_nodal_rows
