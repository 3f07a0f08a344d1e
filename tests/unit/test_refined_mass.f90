!> Mass matrices on a refined mesh: assembled by nodes, every way of solving solves with the same matrix.
program test_refined_mass
   use hampm_kinds, only: dp, corners
   use hampm_constraints, only: constrain_box
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_mass_choice, only: mass_choice_t, new_mass_choice
   use hampm_mass_product, only: find_concentrated_mass, multiply_by_mass
   use hampm_mass_samples, only: choice_of
   use hampm_mass_solver, only: solve_mass
   use hampm_matching, only: adopt_forest
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_samples, only: rectangle_t, place_bodies, start
   use hampm_stiffness, only: stiffness_t, stiffness_kind_t, factorise_stiffness
   implicit none

   character(6), parameter :: solvers(2) = ['cg    ', 'direct']
   integer :: k

   call repeat_random_numbers()
   do k = 1, size(solvers)
      call check_solver('consistent', solvers(k), choice_of('consistent', solvers(k)))
      call check_solver('partial', solvers(k), choice_of('partial', solvers(k), lower=[0.0_dp, 0.0_dp], upper=[2.2_dp, 9.0_dp]))
      call check_solver('partial, refined', solvers(k), new_mass_choice('partial', trim(solvers(k)), 1, 0.0_dp, &
                                                                        [0.0_dp, 0.0_dp], [0.0_dp, 0.0_dp], .true.))
      call check_solver('weighted', solvers(k), choice_of('weighted', solvers(k), lumped_fraction=0.4_dp))
   end do
   call check_series()
   call finish()

contains

   !> A body on a mesh of three levels, displaced at random, with some nodes held.
   subroutine refined_body(choice, m)
      type(mass_choice_t), intent(in) :: choice
      type(problem_t), intent(out) :: m
      type(forest_t) :: forest
      type(failure_t) :: failure
      integer, allocatable :: change(:)
      integer :: leaf, level
      call place_bodies(forest_t([0.0_dp, 0.0_dp], 1.0_dp, [6, 5]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([1.0_dp, 1.0_dp], [5.0_dp, 4.0_dp], [8, 6])], m)
      call constrain_box(m%constraints, m%grid, [0.0_dp, 0.0_dp], [1.0_dp, 9.0_dp], [.true., .false.])
      call constrain_box(m%constraints, m%grid, [2.5_dp, 0.0_dp], [3.0_dp, 1.0_dp], [.true., .true.])
      call start(m, 'musl', choice)
      forest = m%grid%forest
      do level = 1, 3
         allocate (change(forest%leaf_count()), source=0)
         do leaf = 1, size(change)
            if (maxval(abs(forest%position(forest%place_of(leaf)) + forest%size_of(leaf)/2 - [2.1_dp, 1.6_dp])) &
                < 1.2_dp*forest%size_of(leaf)) change(leaf) = 1
         end do
         call forest%adapt(change)
         call forest%balance()
         deallocate (change)
      end do
      call adopt_forest(m, forest, failure)
      call check(.not. failure%failed(), 'the mesh is adopted')
      call random_number(m%particles%velocity)
      call refresh_grid(m)
   end subroutine refined_body

   !> The mass matrix by nodes: what is coupled by elements, and what is lumped on the diagonal.
   function matrix_of(m) result(a)
      type(problem_t), intent(in) :: m
      real(dp), allocatable :: a(:, :)
      real(dp) :: part(corners, most_nodes_of_leaf), by_node(most_nodes_of_leaf, most_nodes_of_leaf)
      integer :: node(most_nodes_of_leaf), n, k, i
      allocate (a(m%grid%n_nodes, m%grid%n_nodes), source=0.0_dp)
      associate (matrix => m%fields%mass_matrix)
         do k = 1, matrix%all%n_cells
            call m%grid%dofs%masters_of(m%grid%element_nodes(:, matrix%all%cells(k)), n, node, part)
            by_node = matmul(transpose(part), matmul(matrix%cell(:, :, matrix%all%cells(k)), part))
            a(node(:n), node(:n)) = a(node(:n), node(:n)) + by_node(:n, :n)
         end do
         do i = 1, m%grid%n_nodes
            a(i, i) = a(i, i) + (matrix%lumped(i) - sum(a(:, i)))
         end do
      end associate
   end function matrix_of

   subroutine check_solver(name, solver, choice)
      character(*), intent(in) :: name, solver
      type(mass_choice_t), intent(in) :: choice
      type(problem_t) :: m
      type(failure_t) :: failure
      real(dp), allocatable :: a(:, :), b(:, :), x(:, :), residual(:, :)
      character(:), allocatable :: what
      integer :: n
      call refined_body(choice, m)
      n = m%grid%n_nodes
      what = name//', '//trim(solver)//': '
      a = matrix_of(m)
      allocate (b, source=m%fields%momentum)
      allocate (x, mold=b)
      call random_number(x)
      call solve_mass(m%solver, m%grid, m%fields%mass_matrix, b, x, failure)
      call check(.not. failure%failed(), what//'solved')
      residual = b(:, :n) - matmul(x(:, :n), a)
      where (m%constraints%fixed) residual = 0
      call check_close(maxval(abs(residual))/maxval(abs(b)), 0.0_dp, 1.0e-11_dp, what//'M x = b on a refined mesh')
      call check(.not. any(m%constraints%fixed .and. abs(x(:, :n)) > 0), what//'held nodes stay')
      call check_close(sum(m%fields%mass_matrix%lumped(:n)), sum(m%particles%mass), 1.0e-14_dp, what//'the nodes have the mass')
      call check_close(maxval(abs(sum(b(:, :n), dim=2) - matmul(m%particles%mass, m%particles%velocity))), 0.0_dp, 1.0e-13_dp, &
                       what//'and the momentum of the particles')
      call check(all(m%fields%mass_matrix%lumped(m%fields%mass_matrix%all%nodes(:m%fields%mass_matrix%all%n_nodes)) > 0), &
                 what//'no active node is without mass')
      call check_products(what, m, a, b, x)
      call m%solver%direct%release()
   end subroutine check_solver

   !> The product with the whole matrix, and the matrix as it is added to a stiffness: where it is by far the larger part,
   !> c (K + c M)^-1 b is M^-1 b.
   subroutine check_products(what, m, a, b, x)
      character(*), intent(in) :: what
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: a(:, :)            !! M by nodes
      real(dp), intent(in) :: b(:, :), x(:, :)   !! of M x = b, (ndim, n_points)
      real(dp), parameter :: c = 1.0e12_dp
      type(stiffness_kind_t) :: kind
      type(stiffness_t) :: k
      type(failure_t) :: failure
      real(dp), allocatable :: mass(:), y(:, :), u(:, :), field(:, :)
      allocate (field, source=x)
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, 2, field)
      allocate (y, mold=field)
      call find_concentrated_mass(m%grid, m%fields%mass_matrix, mass)
      call multiply_by_mass(m%grid, m%fields%mass_matrix, mass, field, y)
      call check_close(maxval(abs(y(:, :m%grid%n_nodes) - matmul(field(:, :m%grid%n_nodes), a))), 0.0_dp, 1.0e-14_dp, &
                       what//'the product with M')
      kind = stiffness_kind_t(is_tangent=.true., on_interfaces=.false., mass_factor=c)
      call factorise_stiffness(m, kind, k, failure)
      call check(.not. failure%failed(), what//'K + c M is factorised')
      call k%solve(m, b, u)
      associate (nodes => m%fields%mass_matrix%all%nodes(:m%fields%mass_matrix%all%n_nodes))
         call check_close(maxval(abs(c*u(:, nodes) - x(:, nodes))), 0.0_dp, 1.0e-9_dp*maxval(abs(x(:, nodes))), &
                          what//'K + c M holds M')
      end associate
      call k%release()
   end subroutine check_products

   !> fmpm of order 2 gives 2 D^-1 - D^-1 M D^-1, from which M can be seen column by column.
   subroutine check_series()
      type(problem_t) :: m
      type(failure_t) :: failure
      real(dp), allocatable :: a(:, :), b(:, :), x(:, :), seen(:)
      real(dp) :: error
      integer :: j, n
      call refined_body(choice_of('fmpm', order=2), m)
      n = m%grid%n_nodes
      allocate (a, source=matrix_of(m))
      allocate (b, x, mold=m%fields%momentum)
      allocate (seen(n))
      error = 0
      associate (d => m%fields%mass_matrix%lumped)
         do j = 1, n
            if (.not. d(j) > 0 .or. m%constraints%fixed(2, j)) cycle
            b = 0
            b(2, j) = 1
            x = 0
            call solve_mass(m%solver, m%grid, m%fields%mass_matrix, b, x, failure)
            seen = -d(:n)*x(2, :n)*d(j)
            seen(j) = seen(j) + 2*d(j)
            error = max(error, maxval(abs(seen - a(:, j)), mask=.not. m%constraints%fixed(2, :)))
         end do
         call check_close(error/maxval(d), 0.0_dp, 1.0e-14_dp, 'fmpm multiplies by the assembled matrix')
      end associate
   end subroutine check_series
end program test_refined_mass
