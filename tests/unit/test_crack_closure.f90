!> Values at crack nodes from the particles around them, and the energy release rates made of them.
program test_crack_closure
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use hampm_kinds, only: dp, ndim
   use hampm_basis, only: shape_functions
   use hampm_constraints, only: constraints_t
   use hampm_crack_closure, only: stress_closure, virtual_crack_closure
   use hampm_openings, only: opening_at
   use hampm_crack_tip_field, only: modes
   use hampm_cracks, only: cracks_t, last_point
   use hampm_measurements, only: dcb_energy_release_rate, chi_foundation
   use hampm_extrapolation, only: extrapolate
   use hampm_failure, only: failure_t, exit_input
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_mass_choice, only: new_mass_choice
   use hampm_mass_solver, only: mass_solver_t, new_mass_solver
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_patch, only: patch_t, patch_around, fitted_displacement, internal_force
   use hampm_quadratic_samples, only: fill_with_quadratic
   use hampm_samples, only: rectangle_t, place_bodies, start, thickness
   use hampm_crack_lines, only: left_face, right_face
   implicit none

   real(dp), parameter :: no_factors(0) = 0
   real(dp), parameter :: cell = 0.25_dp, young = 50.0_dp, poisson = 0.3_dp
   integer :: points

   call repeat_random_numbers()
   do points = 1, 3
      call nodal_values(points)
      call uniform_stress(points)
   end do
   call few_particles()
   call closure_of_uniform_fields(1.0_dp)
   call closure_of_uniform_fields(-1.0_dp)
   call closure_of_quadratic_fields()
   call closure_of_both_modes([1.0_dp, 0.0_dp])
   call closure_of_both_modes([-1.0_dp, 0.0_dp])
   call closure_of_both_modes([0.0_dp, 1.0_dp])
   call closure_of_both_modes([0.0_dp, -1.0_dp])
   call tip_without_node()
   call double_cantilever_beam()
   call finish()

contains

   !> A body that covers 4 x 2 cells on one side of the plane y = 0.
   subroutine place(points, side, m)
      integer, intent(in) :: points              !! per cell and direction
      real(dp), intent(in) :: side               !! sign of the side
      type(problem_t), intent(out) :: m
      real(dp) :: bottom
      bottom = min(0.0_dp, 2*side*cell)
      call place_bodies(forest_t([-3*cell, -3*cell], cell, [6, 6]), &
                        new_material('', 'linear_elastic', .true., young, poisson, 1.0_dp), &
                        [rectangle_t([-2*cell, bottom], [2*cell, bottom + 2*cell], [4*points, 2*points])], m)
   end subroutine place

   !> Particles that move with a finite element field give its nodal values back, at inner nodes and at the edge.
   subroutine nodal_values(points)
      integer, intent(in) :: points
      type(problem_t) :: m
      type(patch_t) :: patch
      real(dp), allocatable :: nodal(:, :)
      character(10), parameter :: masses(*) = [character(10) :: 'lumped', 'consistent', 'partial', 'fmpm', 'weighted']
      type(mass_solver_t) :: solver
      type(failure_t) :: failure
      real(dp) :: u(ndim), error
      integer :: i, node
      call place(points, 1.0_dp, m)
      allocate (nodal(ndim, m%grid%n_nodes))
      call random_number(nodal)
      associate (p => m%particles, grid => m%grid)
         do i = 1, p%n
            p%displacement(i, :) = matmul(nodal(:, grid%element_nodes(:, p%cell(i))), &
                                          shape_functions(grid%local_coordinate(p%cell(i), p%place_in_grid(i))))
         end do
         ! The particles stay in their cells, at the places where the field was taken
         p%reference = p%reference - p%displacement
         error = 0
         do node = 1, grid%n_nodes
            if (all(grid%node_position(:, node) > [-2.1_dp, -0.1_dp]*cell .and. &
                    grid%node_position(:, node) < [2.1_dp, 2.1_dp]*cell)) then
               call patch_around(grid, p, m%blocks, node, patch)
               u = fitted_displacement(patch, p)
               error = max(error, maxval(abs(u - nodal(:, node))))
               call check(all(ieee_is_finite(u)), 'the fitted displacement is finite')
               call check(all(u > -10 .and. u < 10), 'and of the size of the displacements')
            end if
         end do
         if (points > 1) call check_close(error, 0.0_dp, 1.0e-11_dp, 'the fit returns the nodal values of a finite element field')
         p%displacement = spread([0.3_dp, -0.2_dp], 1, p%n)
         call patch_around(grid, p, m%blocks, grid%node_at([0.0_dp, cell]), patch)
         u = fitted_displacement(patch, p)
         call check_close(maxval(abs(u - [0.3_dp, -0.2_dp])), 0.0_dp, 1.0e-14_dp, 'the fit returns a uniform displacement')
         do i = 1, size(masses)
            call start(m, 'musl', new_mass_choice(masses(i), 'cg', 4, 0.5_dp, [-cell, 0.0_dp], [cell, cell]))
            call refresh_grid(m)
            call new_mass_solver(m%mass%by, m%mass%order, grid, constraints_t(), solver, failure)
            call extrapolate(grid, p, m%fields%mass_matrix, solver, transpose(p%displacement), nodal, failure)
            call check_close(maxval(abs(nodal(:, grid%node_at([0.0_dp, cell])) - [0.3_dp, -0.2_dp])), 0.0_dp, 1.0e-11_dp, &
                             'so does the extrapolation by the mass matrix: '//masses(i))
         end do
      end associate
   end subroutine nodal_values

   !> The fit is linear also where particles are fewer than nodes: what rounding leaves along directions that no particle feels is not followed.
   subroutine few_particles()
      integer, parameter :: fields = 20000
      type(problem_t) :: m
      type(patch_t) :: patch
      real(dp), allocatable :: by_particle(:), x(:)
      real(dp) :: u(ndim), error
      integer :: i, k
      call place(1, 1.0_dp, m)
      associate (p => m%particles)
         call patch_around(m%grid, p, m%blocks, m%grid%node_at([0.0_dp, cell]), patch)
         allocate (by_particle(p%n), x(p%n))
         do i = 1, p%n
            p%displacement = 0
            p%displacement(i, :) = 1
            u = fitted_displacement(patch, p)
            by_particle(i) = u(1)
         end do
         error = 0
         do k = 1, fields
            call random_number(x)
            p%displacement = spread(x, 2, ndim)
            u = fitted_displacement(patch, p)
            error = max(error, maxval(abs(u - dot_product(by_particle, x))))
         end do
         call check_close(error, 0.0_dp, 1.0e-10_dp, 'the fit of few particles is linear')
      end associate
   end subroutine few_particles

   !> A uniform stress puts no force on inner nodes and its traction on those at the edge.
   subroutine uniform_stress(points)
      integer, intent(in) :: points
      type(problem_t) :: m
      type(patch_t) :: patch
      real(dp), parameter :: h(ndim, ndim) = reshape([1.0e-3_dp, 2.0e-3_dp, -5.0e-4_dp, 3.0e-3_dp], [ndim, ndim])
      real(dp) :: stress(ndim, ndim)
      integer :: i
      call place(points, 1.0_dp, m)
      associate (p => m%particles, grid => m%grid)
         do i = 1, p%n
            p%gradient(i, :, :) = h
         end do
         stress = m%materials(1)%kirchhoff_stress(h)
         call patch_around(grid, p, m%blocks, grid%node_at([0.0_dp, cell]), patch)
         call check_close(norm2(internal_force(patch, p, m%materials)), 0.0_dp, 1.0e-16_dp*young, &
                          'a uniform stress puts no force on inner nodes')
         call patch_around(grid, p, m%blocks, grid%node_at([0.0_dp, 0.0_dp]), patch)
         call check_close(norm2(internal_force(patch, p, m%materials) - stress(:, 2)*cell*thickness), 0.0_dp, 1.0e-16_dp*young, &
                          'the force on a node of the edge is its traction times its area')
      end associate
   end subroutine uniform_stress

   !> With a uniform stress s across the plane and every particle displaced by d away from it the closures are
   !> G = (s h B)(2 d) / (2 h B) = s d and, of stress, d / 6 (2 s + s) = s d / 2, with the sign of d.
   subroutine closure_of_uniform_fields(side)
      real(dp), intent(in) :: side
      real(dp), parameter :: strain = 1.0e-3_dp, d = 0.01_dp*cell
      type(problem_t) :: m
      type(cracks_t) :: cracks
      type(forest_t) :: forest
      type(failure_t) :: failure
      type(mass_solver_t) :: solver
      real(dp) :: uncertainty(modes)
      real(dp) :: s, opening(modes), g_force(modes), g_stress(modes)
      integer :: i, turn
      s = young*strain
      call place(2, side, m)
      cracks = crack_to([0.0_dp, 0.0_dp], [1.0_dp, 0.0_dp], [side > 0, side < 0])
      forest = m%grid%forest
      call build_grid(forest, m%grid, failure, cracks%lines())
      call cracks%find_nodes(m%grid, failure)
      if (.not. allocated(m%loads)) allocate (m%loads(0))
      call check(.not. failure%failed(), 'the tip has its nodes')
      associate (p => m%particles, tip => cracks%tips(1))
         do turn = 1, -1, -2
            p%displacement(:, 2) = turn*side*d
            p%gradient = 0                       ! which tells of displacements, too
            opening = opening_at(tip, tip%place - cell*tip%direction, -tip%direction, m, m%particles)
            call check_close(opening(1), turn*2*d, 1.0e-14_dp*d, 'the opening counts both faces')
            do i = 1, p%n
               p%gradient(i, :, :) = reshape([-poisson*strain, 0.0_dp, 0.0_dp, strain], [ndim, ndim])
            end do
            p%reference(:, 2) = p%reference(:, 2) - p%displacement(:, 2)
            call virtual_crack_closure(m, no_factors, tip, p, solver, g_force, uncertainty, failure)
            call start(m, 'musl')
            call refresh_grid(m)
            call new_mass_solver(m%mass%by, m%mass%order, m%grid, constraints_t(), solver, failure)
            call stress_closure(m, no_factors, tip, p, solver, g_stress, uncertainty, failure)
            p%reference(:, 2) = p%reference(:, 2) + p%displacement(:, 2)
            call check_close(g_force(1), turn*s*d, 1.0e-13_dp*s*d, 'VCCT of uniform fields, signed like the opening')
            call check_close(g_stress(1), turn*s*d/2, 1.0e-13_dp*s*d, 'stress closure of uniform fields, signed like the opening')
         end do
      end associate
   end subroutine closure_of_uniform_fields

   !> On quadratic cells openings and tractions that are quadratic along the crack are found to the last digit with the full matrix: with x in
   !> cells from the tip, u = -x (2 - x) d of one face and the stress s (1 - x + 3 x**2) across the plane, stress closure is their integral
   !>    G = integral from 0 to 1 of s (1 - x + 3 x**2) (1 - x) (3 - x) d dx = 91/60 s d.
   subroutine closure_of_quadratic_fields()
      real(dp), parameter :: strain = 1.0e-3_dp, d = 0.01_dp*cell, of_sample = 2.0_dp
      type(problem_t) :: m
      type(cracks_t) :: cracks
      type(forest_t) :: forest
      type(failure_t) :: failure
      type(mass_solver_t) :: solver
      real(dp) :: uncertainty(modes)
      real(dp), allocatable :: solids(:, :, :)
      real(dp) :: x, g(modes)
      integer :: i
      call fill_with_quadratic(forest_t([0.0_dp, 0.0_dp], cell, [4, 4]), 4, 4*cell, 1.0_dp, 1.0_dp, m, &
                               new_mass_choice('consistent', 'direct', 1, 0.0_dp, [0.0_dp, 0.0_dp], [0.0_dp, 0.0_dp]))
      cracks = crack_to([2*cell, 0.0_dp], [1.0_dp, 0.0_dp], [.true., .false.])
      allocate (solids, source=m%grid%solids)
      forest = m%grid%forest
      call build_grid(forest, m%grid, failure, cracks%lines(), solids=solids)
      call cracks%find_nodes(m%grid, failure)
      if (.not. allocated(m%loads)) allocate (m%loads(0))
      associate (p => m%particles, tip => cracks%tips(1))
         do i = 1, p%n
            x = p%reference(i, 1)/cell - 2
            p%displacement(i, :) = [0.0_dp, -x*(2 - x)*d]
            p%gradient(i, :, :) = reshape([-poisson*strain, 0.0_dp, 0.0_dp, strain], [ndim, ndim])*(1 - x + 3*x**2)
         end do
         call new_mass_solver(m%mass%by, m%mass%order, m%grid, constraints_t(), solver, failure)
         call stress_closure(m, no_factors, tip, p, solver, g, uncertainty, failure)
         call check(.not. failure%failed(), 'the fields are extrapolated')
         call check_close(g(1), 91/60.0_dp*of_sample*strain*d, 1.0e-10_dp*strain*d, 'stress closure of quadratic fields')
      end associate
   end subroutine closure_of_quadratic_fields

   !> A crack between two faces, of which the one to the left of its direction is displaced by d and the other by -d, under a
   !> uniform stress s across it: in the directions of d, s and d being along one of them, G = s d and, of stress, s d / 2.
   !> Turned by 90 degrees the crack has the same modes.
   subroutine closure_of_both_modes(direction)
      real(dp), intent(in) :: direction(ndim)
      real(dp), parameter :: d = 0.01_dp*cell, stress(modes) = young*[2.0e-3_dp, 1.0e-3_dp]
      type(problem_t) :: m
      type(cracks_t) :: cracks
      type(forest_t) :: forest
      type(failure_t) :: failure
      type(mass_solver_t) :: solver
      real(dp) :: uncertainty(modes)
      real(dp) :: s(ndim, ndim), h(ndim, ndim), g(modes), opening(modes)
      integer :: i
      cracks = crack_to([0.0_dp, 0.0_dp], direction, [.true., .true.])
      s = reshape([0.0_dp, stress(2), stress(2), stress(1)], [ndim, ndim])  ! in the frame of the crack
      s = matmul(matmul(cracks%tips(1)%axis, s), transpose(cracks%tips(1)%axis))
      h = (1 + poisson)/young*s
      do i = 1, ndim
         h(i, i) = h(i, i) - poisson/young*stress(1)
      end do
      forest = forest_t([-3*cell, -3*cell], cell, [6, 6])
      call place_bodies(forest, new_material('', 'linear_elastic', .true., young, poisson, 1.0_dp), &
                        [rectangle_t([-2*cell, -2*cell], [2*cell, 2*cell], [8, 8])], m)
      call build_grid(forest, m%grid, failure, cracks%lines())
      call cracks%find_nodes(m%grid, failure)
      if (.not. allocated(m%loads)) allocate (m%loads(0))
      call check(.not. failure%failed(), 'the tip has its nodes')
      associate (p => m%particles, tip => cracks%tips(1))
         do i = 1, p%n
            p%displacement(i, :) = sign(d, dot_product(p%reference(i, :), tip%axis(:, 2)))*(tip%axis(:, 1) + tip%axis(:, 2))
         end do
         p%reference = p%reference - p%displacement
         opening = opening_at(tip, tip%place - cell*tip%direction, -tip%direction, m, m%particles)
         call check_close(maxval(abs(opening - 2*d)), 0.0_dp, 1.0e-13_dp*d, 'opening and sliding are those of the faces')
         opening = opening_at(tip, cracks%crack(1)%mouth, [0.0_dp, 0.0_dp], m, m%particles)
         call check_close(maxval(abs(opening - 2*d)), 0.0_dp, 1.0e-13_dp*d, 'so are those at the mouth')
         do i = 1, p%n
            p%gradient(i, :, :) = h
         end do
         call virtual_crack_closure(m, no_factors, tip, p, solver, g, uncertainty, failure)
         call check_close(maxval(abs(g/stress - d)), 0.0_dp, 1.0e-13_dp*d, 'VCCT of both modes')
         call start(m, 'musl')
         call refresh_grid(m)
         call new_mass_solver(m%mass%by, m%mass%order, m%grid, constraints_t(), solver, failure)
         call stress_closure(m, no_factors, tip, p, solver, g, uncertainty, failure)
         call check_close(maxval(abs(g/stress - d/2)), 0.0_dp, 1.0e-13_dp*d, 'stress closure of both modes')
      end associate
   end subroutine closure_of_both_modes

   !> A crack that ends at a tip, with its mouth two cells behind it.
   pure function crack_to(tip, direction, face) result(cracks)
      real(dp), intent(in) :: tip(ndim), direction(ndim)
      logical, intent(in) :: face(2)
      type(cracks_t) :: cracks
      allocate (cracks%crack(1))
      associate (crack => cracks%crack(1))
         crack%points = reshape([tip - 10*cell*direction, tip], [ndim, 2])
         crack%is_tip(last_point) = .true.
         if (.not. all(face)) crack%face = merge(left_face, right_face, face(1))
         crack%mouth = tip - 2*cell*direction
      end associate
      call cracks%list_tips()
   end function crack_to

   !> On a symmetry plane the nodes of a tip have to be there.
   subroutine tip_without_node()
      type(grid_t) :: grid
      type(cracks_t) :: cracks
      type(failure_t) :: failure
      cracks = crack_to([3*cell, 0.0_dp], [1.0_dp, 0.0_dp], [.true., .false.])
      call build_grid(forest_t([-3*cell, -3*cell], cell, [6, 6]), grid, failure, cracks%lines())
      call cracks%find_nodes(grid, failure)
      call check(failure%code == exit_input, 'a tip without a node ahead is a mistake of the input')
   end subroutine tip_without_node

   !> G = P**2 / (2 B) dC/da with the compliance C = 2 a**3 / (3 E I), I = B D**3 / 12, of two cantilevers.
   subroutine double_cantilever_beam()
      real(dp), parameter :: p = 3.0_dp, a = 0.05_dp, d = 0.01_dp, b = 0.02_dp, e = 70.0e9_dp
      real(dp) :: g, slope
      g = dcb_energy_release_rate(p, a, d, b, e, 0.0_dp)
      slope = 2*a**2/(e*b*d**3/12)
      call check_close(g/(p**2/(2*b)*slope), 1.0_dp, 1.0e-15_dp, 'G of the beams is the rate of their compliance')
      call check_close(dcb_energy_release_rate(1.0_dp, 0.05_dp, 0.01_dp, 0.01_dp, 70.0e9_dp, 0.0_dp)/(3.0e-2_dp/7), 1.0_dp, &
                       1.0e-14_dp, 'G of a known beam: 4.286 mJ/m2')
      call check_close(dcb_energy_release_rate(p, a, d, b, e, chi_foundation)/g, (1 + d/a*2/3)**2, 1.0e-14_dp, &
                       'the foundation lengthens the crack by 2/3 of the depth')
   end subroutine double_cantilever_beam
end program test_crack_closure
