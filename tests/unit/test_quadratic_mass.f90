!> Mass matrices of quadratic cells on random balanced meshes, against matrices that are summed particle by particle and node by node, and
!> all ways of solving with them.
program test_quadratic_mass
   use hampm_kinds, only: dp, ndim
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_mass_choice, only: mass_choice_t
   use hampm_mass_matrix, only: floor_of_quadratic
   use hampm_mass_product, only: multiply_by_mass, find_concentrated_mass
   use hampm_mass_samples, only: choice_of, solution
   use hampm_problem, only: problem_t
   use hampm_quadratic_samples, only: fill_with_quadratic
   use hampm_random_forests, only: change_at_random, random_integer
   use hampm_threads, only: use_threads
   implicit none

   real(dp), parameter :: thickness = 0.5_dp, density = 3.0_dp, cell = 0.25_dp
   integer, parameter :: roots = 3, meshes = 60
   character(6), parameter :: solvers(2) = ['cg    ', 'direct']
   real(dp) :: residual(size(solvers)), momentum, multiplied, series, least
   integer :: k

   call repeat_random_numbers()
   call use_threads(1, 0)                        ! meshes are too small for more
   residual = 0
   momentum = 0
   multiplied = 0
   series = 0
   least = huge(least)
   do k = 1, meshes
      call look_at_mesh(3 + mod(k, 3))
   end do
   do k = 1, size(solvers)
      call check_close(residual(k), 0.0_dp, 1e-11_dp, trim(solvers(k))//': M x = b')
   end do
   call check_close(momentum, 0.0_dp, 1e-13_dp, 'rows of the matrix sum to the lumped masses')
   call check_close(multiplied, 0.0_dp, 1e-13_dp, 'the product of implicit steps is that of the matrix')
   call check_close(series, 0.0_dp, 1e-12_dp, 'fmpm is the series of the matrix that is not lumped in any part')
   call check(least > -1e-14_dp, 'lumped masses are positive in every part of each matrix')
   call finish()

contains

   !> All mass matrices on a random mesh with n particles a cell and direction.
   subroutine look_at_mesh(n)
      integer, intent(in) :: n
      type(forest_t) :: forest
      real(dp) :: box(ndim)
      integer :: i
      forest = forest_t([0.0_dp, 0.0_dp], cell, [roots, roots])
      do i = 1, random_integer(1, 3)
         call change_at_random(forest, 0.2_dp, 0.1_dp, 3)
      end do
      call random_number(box)
      do i = 1, size(solvers)
         call look_at_matrix(forest, n, choice_of('consistent', solvers(i)), i)
         call look_at_matrix(forest, n, choice_of('weighted', solvers(i), lumped_fraction=0.3_dp), i)
         call look_at_matrix(forest, n, choice_of('partial', solvers(i), lower=[0.0_dp, 0.0_dp], upper=roots*cell*box), i)
      end do
      call look_at_series(forest, n)
   end subroutine look_at_mesh

   !> Solve with a matrix, and multiply by it.
   subroutine look_at_matrix(forest, n, choice, solver)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: n, solver
      type(mass_choice_t), intent(in) :: choice
      type(problem_t) :: m
      type(failure_t) :: failure
      real(dp), allocatable :: a(:, :), b(:, :), guess(:, :), x(:, :), y(:, :), diagonal(:)
      call fill_with_quadratic(forest, n, roots*cell, density, thickness, m, choice)
      associate (nodes => m%grid%n_nodes, mass => m%fields%mass_matrix)
         a = summed_matrix(m, floor_of_quadratic)
         allocate (b(ndim, m%grid%n_points), guess(ndim, m%grid%n_points))
         call random_number(b)
         call random_number(guess)
         b = b*spread(mass%lumped, 1, ndim)
         x = solution(m, b, guess)
         residual(solver) = max(residual(solver), maxval(abs(b(:, :nodes) - matmul(x, a)))/maxval(abs(b)))
         momentum = max(momentum, maxval(abs(sum(a, dim=1) - mass%lumped(:nodes)))/maxval(mass%lumped))
         call find_concentrated_mass(m%grid, mass, diagonal)
         least = min(least, minval(diagonal(:nodes))/maxval(mass%lumped))
         allocate (y, mold=guess)
         call m%grid%dofs%distribute(m%grid%dofs%every_node(), ndim, guess)
         call multiply_by_mass(m%grid, mass, diagonal, guess, y)
         multiplied = max(multiplied, maxval(abs(y(:, :nodes) - matmul(guess(:, :nodes), a)))/maxval(abs(b)))
      end associate
      call m%solver%direct%release()
      call check(.not. failure%failed(), 'the matrix is solved')
   end subroutine look_at_matrix

   !> The series of `fmpm`.
   subroutine look_at_series(forest, n)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: n
      integer, parameter :: order = 3
      type(problem_t) :: m
      real(dp), allocatable :: a(:, :), b(:, :), x(:, :), term(:, :), zero(:, :), inverse(:, :)
      integer :: k
      call fill_with_quadratic(forest, n, roots*cell, density, thickness, m, choice_of('fmpm', order=order))
      associate (nodes => m%grid%n_nodes)
         a = summed_matrix(m, 0.0_dp)
         allocate (b(ndim, m%grid%n_points), zero(ndim, m%grid%n_points), x(ndim, nodes), term(ndim, nodes), inverse(ndim, nodes))
         zero = 0
         call random_number(b)
         b = b*spread(m%fields%mass_matrix%lumped, 1, ndim)
         inverse = spread(1/sum(a, dim=1), 1, ndim)
         term = inverse*b(:, :nodes)
         x = term
         do k = 2, order
            term = term - inverse*matmul(term, a)
            x = x + term
         end do
         series = max(series, maxval(abs(x - solution(m, b, zero)))/maxval(abs(x)))
      end associate
   end subroutine look_at_series

   !> The matrix of the free nodes, particle by particle: in each cell the part b of it that is lumped by the choice, and of cells with nodes
   !> that hang the part `floor` of the rest, is put on the diagonal, hanging nodes' by their weights.
   function summed_matrix(m, floor) result(a)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: floor
      real(dp), allocatable :: a(:, :)
      real(dp) :: weight(m%grid%n_functions, most_nodes_of_leaf), part
      real(dp), allocatable :: shape(:)
      integer :: masters(most_nodes_of_leaf), i, k, c, count
      allocate (a(m%grid%n_nodes, m%grid%n_nodes), source=0.0_dp)
      do i = 1, m%particles%n
         associate (e => m%particles%cell(i), mass => m%particles%mass(i))
            call m%grid%dofs%masters_of(m%grid%support_of(e), count, masters, weight)
            shape = matmul(m%grid%functions_in(e, m%grid%local_coordinate(e, m%particles%reference(i, :))), weight(:, :count))
            part = m%fields%mass_matrix%lumped_fraction(m%fields%mass_matrix%cell_of(e))
            if (any(m%grid%support_of(e) > m%grid%n_nodes) .and. part < 1) part = 1 - (1 - part)*(1 - floor)
            do c = 1, count
               do k = 1, count
                  a(masters(k), masters(c)) = a(masters(k), masters(c)) + (1 - part)*mass*shape(k)*shape(c)
               end do
               a(masters(c), masters(c)) = a(masters(c), masters(c)) + part*mass*shape(c)
            end do
         end associate
      end do
   end function summed_matrix
end program test_quadratic_mass
