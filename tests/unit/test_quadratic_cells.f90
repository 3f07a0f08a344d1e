!> Quadratic cells on random balanced meshes: values are continuous from cell to cell, quadratic fields are held and in balance with the
!> body force that belongs to them (the patch test of order 2), masses are positive; and what 2, 3 and 4 particles a direction do.
program test_quadratic_cells
   use hampm_kinds, only: dp, ndim
   use hampm_basis, only: points_of_quadratic, quadratic_gradients
   use hampm_constraints, only: constrain_box
   use hampm_error_indicator, only: estimate_errors
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_lapack, only: dsyev
   use hampm_material, only: material_t
   use hampm_problem, only: problem_t
   use hampm_newton, only: displace
   use hampm_nodal_state, only: internal_force
   use hampm_quadratic_points, only: weights_along
   use hampm_quadratic_samples, only: fill_with_quadratic
   use hampm_random_forests, only: change_at_random, random_integer
   use hampm_stiffness, only: stiffness_t, stiffness_kind_t, factorise_stiffness
   use hampm_threads, only: use_threads
   implicit none

   real(dp), parameter :: thickness = 0.5_dp, density = 3.0_dp, cell = 0.25_dp
   integer, parameter :: roots = 3, meshes = 1000
   real(dp) :: jump, field_error, imbalance(3:5), least_mass, volume_error, equal_weights
   integer :: k

   call repeat_random_numbers()
   call use_threads(1, 0)                        ! meshes are too small for more
   call weights_are_exact()
   call strained_motions()
   jump = 0
   field_error = 0
   imbalance = 0
   equal_weights = 0
   volume_error = 0
   least_mass = huge(least_mass)
   do k = 1, meshes
      call look_at_mesh(3 + mod(k, 3))
   end do
   call energy_is_of_fourth_order()
   call check_close(jump, 0.0_dp, 1e-13_dp, 'values are continuous from cell to cell, of other sizes too')
   call check_close(field_error, 0.0_dp, 1e-13_dp, 'hanging nodes hold quadratic fields')
   do k = 3, 5
      call check_close(imbalance(k), 0.0_dp, 1e-12_dp, 'quadratic fields are in balance, with 3, 4 or 5 particles a direction')
   end do
   call check(equal_weights > 0.01_dp, 'with equal volumes of the particles they are not')
   call check(least_mass > 0, 'all lumped masses are positive')
   call check_close(volume_error, 0.0_dp, 1e-13_dp, 'the particles have the volume of the body')
   call finish()

contains

   !> The weights integrate cubics exactly; those of three and four points in closed form.
   subroutine weights_are_exact()
      real(dp), allocatable :: w(:), x(:)
      integer :: n, i, power
      allocate (w, source=weights_along(3))
      allocate (x(0))
      call check_close(maxval(abs(w - [3, 2, 3]/8.0_dp)), 0.0_dp, 1e-15_dp, 'three points have the weights 3/8, 1/4, 3/8')
      w = weights_along(4)
      call check_close(maxval(abs(w - [13, 11, 11, 13]/48.0_dp)), 0.0_dp, 1e-15_dp, 'four 13/48, 11/48, 11/48, 13/48')
      do n = 3, 12
         w = weights_along(n)
         x = [((i - 0.5_dp)/n, i=1, n)]
         do power = 0, 3
            call check_close(sum(w*x**power), 1/(power + 1.0_dp), 1e-14_dp, 'weights integrate cubics')
         end do
         call check(all(w > 0), 'weights are positive')
      end do
   end subroutine weights_are_exact

   !> The energy of u = sin(pi x) sin(pi y) (1, 2) on a square whose edges are held errs in fourth order of the cells.
   subroutine energy_is_of_fourth_order()
      real(dp) :: error(3), index(3)
      integer :: i, n
      do n = 3, 4
         do i = 1, 3
            call solve_square(2**(i + 1), n, error(i), index(i))
         end do
         call check(all(error(:2)/error(2:) > 14 .and. error(:2)/error(2:) < 18), 'the energy errs in fourth order of the cells')
         call check_close(index(3), 1.0_dp, 0.05_dp, 'the error estimate of quadratic cells is the error')
         call check(abs(index(3) - 1) < abs(index(1) - 1), 'and tends to it')
      end do
   end subroutine energy_is_of_fourth_order

   !> The square of side 1 with `cells` along an edge and n particles in each direction of a cell.
   subroutine solve_square(cells, n, error, index)
      integer, intent(in) :: cells, n
      real(dp), intent(out) :: error             !! of the strain energy, over this
      real(dp), intent(out) :: index             !! estimated error in the energy norm over the true one, both at the particles
      type(problem_t) :: m
      type(failure_t) :: failure
      type(stiffness_t) :: stiffness
      real(dp), allocatable :: force(:, :), u(:, :)
      real(dp), allocatable :: squared(:)
      real(dp) :: s(ndim), c(ndim), laplace(ndim), mixed(ndim), exact, norm, true, h(ndim, ndim)
      real(dp), parameter :: pi = acos(-1.0_dp), part(ndim) = [1.0_dp, 2.0_dp]
      integer :: i, d
      call fill_with_quadratic(forest_t([0.0_dp, 0.0_dp], 1.0_dp/cells, [cells, cells]), n, 1.0_dp, density, thickness, m)
      do d = 1, ndim
         do i = 0, 1
            s = [0, 0]
            c = [1, 1]
            s(d) = i
            c(d) = i
            call constrain_box(m%constraints, m%grid, s, c, [.true., .true.])
         end do
      end do
      allocate (force(ndim, m%grid%n_points), source=0.0_dp)
      associate (p => m%particles, law => m%materials(1))
         do i = 1, p%n
            s = sin(pi*p%reference(i, :))
            c = cos(pi*p%reference(i, :))
            laplace = -2*pi**2*s(1)*s(2)*part
            mixed = pi**2*[c(1)*c(2)*part(2) - s(1)*s(2)*part(1), c(1)*c(2)*part(1) - s(1)*s(2)*part(2)]
            associate (at => m%grid%support_of(p%cell(i)), shape => m%grid%functions_in(p%cell(i), &
                             m%grid%local_coordinate(p%cell(i), p%reference(i, :))))
               do d = 1, ndim
                  force(d, at) = force(d, at) - p%volume(i)*shape*(law%mu*laplace(d) + (law%lambda + law%mu)*mixed(d))
               end do
            end associate
         end do
         ! energy: the integral of mu |grad u|**2/2 + (lambda + mu) (div u)**2/2, as u is zero on the edges
         exact = thickness*pi**2*(law%mu*sum(part**2)/4 + (law%lambda + law%mu)*sum(part**2)/8)
      end associate
      call factorise_stiffness(m, stiffness_kind_t(is_tangent=.true., on_interfaces=.false.), stiffness, failure)
      call stiffness%solve(m, force, u, failure)
      call check(.not. failure%failed(), 'the square is solved')
      error = abs(sum(force*u)/2/exact - 1)
      call stiffness%release()
      call displace(m, u)
      call estimate_errors(m, squared, norm)
      true = 0
      associate (p => m%particles, law => m%materials(1))
         do i = 1, p%n
            s = sin(pi*p%reference(i, :))
            c = cos(pi*p%reference(i, :))
            h = pi*spread(part, 2, ndim)*spread([c(1)*s(2), s(1)*c(2)], 1, ndim)
            true = true + p%volume(i)*2*law%stress_energy_density(law%small_strain_stress(p%gradient_of(i) - h))
         end do
      end associate
      index = sqrt(sum(squared)/true)
   end subroutine solve_square

   !> Motions of a cell that strain no particle: the three rigid ones with three or four particles a direction, six with two.
   subroutine strained_motions()
      integer :: n
      do n = 2, 4
         call check(rank_of_strain(n) == ndim*points_of_quadratic - merge(6, 3, n == 2), &
                    'particles feel all motions of a cell but rigid ones, from three a direction on')
      end do
   end subroutine strained_motions

   !> Rank of the strain of n x n particles as a function of the motion of the nodes.
   integer function rank_of_strain(n) result(rank)
      integer, intent(in) :: n
      integer, parameter :: dofs = ndim*points_of_quadratic
      real(dp) :: product(dofs, dofs), strain(3, dofs), gradient(points_of_quadratic, ndim), eigenvalue(dofs), work(8*dofs)
      integer :: i, j, info
      product = 0
      do j = 1, n
         do i = 1, n
            gradient = quadratic_gradients([i - 0.5_dp, j - 0.5_dp]/n, 1.0_dp)
            strain = 0
            strain(1, 1::2) = gradient(:, 1)
            strain(2, 2::2) = gradient(:, 2)
            strain(3, 1::2) = gradient(:, 2)
            strain(3, 2::2) = gradient(:, 1)
            product = product + matmul(transpose(strain), strain)
         end do
      end do
      call dsyev('N', 'L', dofs, product, dofs, eigenvalue, work, size(work), info)
      rank = count(eigenvalue > 1e-10_dp*maxval(eigenvalue))
   end function rank_of_strain

   !> A square on a random mesh, with n particles a cell and direction.
   subroutine look_at_mesh(n)
      integer, intent(in) :: n
      type(problem_t) :: m
      type(forest_t) :: forest
      real(dp) :: a(ndim, 6)
      integer :: i
      forest = forest_t([0.0_dp, 0.0_dp], cell, [roots, roots])
      do i = 1, random_integer(1, 3)
         call change_at_random(forest, 0.2_dp, 0.1_dp, 3)
      end do
      call fill_with_quadratic(forest, n, roots*cell, density, thickness, m)
      call look_at_sides(m)
      call random_number(a)
      call check_energy_balance(m, a - 0.5_dp, imbalance(n))
      least_mass = min(least_mass, minval(m%fields%mass_matrix%lumped(:m%grid%n_nodes))/maxval(m%fields%mass_matrix%lumped))
      volume_error = max(volume_error, abs(sum(m%particles%volume(:m%particles%n))/(thickness*(roots*cell)**2) - 1))
      if (n > 3 .or. m%grid%forest%is_uniform()) return
      m%particles%volume = thickness*[(m%grid%leaf_size(m%particles%cell(i)), i=1, m%particles%n)]**2/n**2
      call check_energy_balance(m, a - 0.5_dp, equal_weights)
   end subroutine look_at_mesh

   !> Random values at the nodes are one function: on the sides of each leaf it is that of the leaf on the other side.
   subroutine look_at_sides(m)
      type(problem_t), intent(in) :: m
      real(dp), parameter :: aside = 1e-6_dp
      real(dp) :: values(1, m%grid%n_points), x(ndim), outward(ndim), r
      integer :: leaf, side, axis, other
      call random_number(values)
      call m%grid%dofs%distribute(m%grid%dofs%every_node(), 1, values)
      do leaf = 1, m%grid%forest%leaf_count()
         do side = 0, 3
            call random_number(r)
            outward = 0
            axis = merge(1, 2, side < 2)
            outward(axis) = 2*mod(side, 2) - 1
            x = r
            x(axis) = mod(side, 2)
            x = m%grid%forest%position(m%grid%forest%place_of(leaf)) + m%grid%forest%size_of(leaf)*x
            other = m%grid%element_at(x + aside*cell*outward)
            if (other == 0) cycle
            jump = max(jump, abs(value_in(m, values(1, :), m%grid%leaf_element(leaf), x) - value_in(m, values(1, :), other, x)))
         end do
      end do
   end subroutine look_at_sides

   !> Value at a place by the functions of the leaf of an element.
   real(dp) function value_in(m, values, e, x)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: values(:), x(ndim)
      integer, intent(in) :: e
      value_in = dot_product(m%grid%functions_in(e, m%grid%local_coordinate(e, x)), values(m%grid%support_of(e)))
   end function value_in

   !> The displacement a (1, x, y, x**2, x y, y**2): what is out of balance at inner nodes with the body force that belongs to it, over the
   !> largest force.
   subroutine check_energy_balance(m, a, worst)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: a(ndim, 6)
      real(dp), intent(inout) :: worst
      real(dp) :: u(ndim, m%grid%n_points), exact(ndim), divergence(ndim), h(ndim, ndim), stress(ndim, ndim)
      real(dp), allocatable :: force(:, :)
      integer :: i, d
      do i = 1, m%grid%n_points
         associate (x => m%grid%node_position(:, i))
            u(:, i) = matmul(a, [1.0_dp, x(1), x(2), x(1)**2, x(1)*x(2), x(2)**2])
         end associate
      end do
      call m%grid%dofs%distribute(m%grid%dofs%every_node(), ndim, u)
      do i = m%grid%n_nodes + 1, m%grid%n_points
         associate (x => m%grid%node_position(:, i))
            exact = matmul(a, [1.0_dp, x(1), x(2), x(1)**2, x(1)*x(2), x(2)**2])
            field_error = max(field_error, maxval(abs(u(:, i) - exact)))
         end associate
      end do
      divergence = 0
      do d = 1, ndim                             ! the change of the stress along direction d
         h(:, 1) = matmul(a(:, 4:5), merge([2, 0], [0, 1], d == 1))
         h(:, 2) = matmul(a(:, 5:6), merge([1, 0], [0, 2], d == 1))
         stress = m%materials(1)%small_strain_stress(h)
         divergence = divergence + stress(:, d)
      end do
      m%particles%gradient = 0
      m%particles%displacement = 0
      call displace(m, u)
      call internal_force(m, force)
      do i = 1, m%grid%n_nodes
         associate (x => m%grid%node_position(:, i), mass => m%fields%mass_matrix%lumped(i))
            if (any(x < 1e-9_dp .or. x > roots*cell - 1e-9_dp)) cycle
            worst = max(worst, maxval(abs(force(:, i) - divergence*mass/density))/maxval(abs(force)))
         end associate
      end do
   end subroutine check_energy_balance
end program test_quadratic_cells
