!> Any number of elements around a node: elements are doubled by hand, over one square and at the same nodes, and each of their
!> particles is in one of both, as in a cell that a crack cuts. All that is summed at nodes must be what it is where they are in one
!> element.
program test_high_valence_nodes
   use hampm_kinds, only: dp, ndim, corners
   use hampm_constraints, only: constrain_box
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_loads, only: load_on_particles
   use hampm_mass_choice, only: mass_choice_t
   use hampm_mass_samples, only: choice_of, dense_matrix
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_nodal_rows, only: pattern_t, spans_t, unlike_neighbours, pattern_of_grid, find_spans, sum_rows, multiply_rows
   use hampm_patch, only: patch_t, patch_around, patch_mass, internal_force, fitted_displacement
   use hampm_recovery, only: recover
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps
   use hampm_sorting, only: sort_into_cells
   implicit none

   character(7), parameter :: frames(2) = ['updated', 'total  '], solvers(2) = ['cg     ', 'direct ']
   real(dp), parameter :: place(ndim) = [0.25_dp, 0.15_dp]  !! in the cell that is doubled [m]
   integer :: k, f

   call repeat_random_numbers()
   call check_rows()
   call check_products()
   call check_mapping()
   call check_patches()
   do f = 1, size(frames)
      do k = 1, size(schemes)
         call check_steps(trim(schemes(k))//', lumped', schemes(k), choice_of('lumped'), trim(frames(f)))
      end do
      call check_steps('fmpm', 'musl', choice_of('fmpm', order=3), trim(frames(f)))
      do k = 1, size(solvers)
         call check_steps('full, '//solvers(k), 'musl', choice_of('consistent', solvers(k)), trim(frames(f)))
      end do
   end do
   call check_hanging_nodes()
   call finish()

contains

   !> Add an element over the square of another, at some nodes of its own or of others.
   subroutine add_element(grid, e, nodes)
      type(grid_t), intent(inout) :: grid
      integer, intent(in) :: e
      integer, intent(in) :: nodes(corners)      !! those beyond the last one of the grid are new
      integer :: status, c
      associate (n => maxval(nodes))
         if (n > grid%n_points) then
            call check(grid%dofs%n_hanging == 0, 'new nodes are numbered on')
            grid%node_position = reshape([grid%node_position, [(0.0_dp, c=1, ndim*(n - grid%n_nodes))]], [ndim, n])
            grid%node_position(:, nodes) = grid%node_position(:, grid%element_nodes(:, e))
            grid%n_nodes = n
            grid%n_points = n
            grid%dofs%n_nodes = n
         end if
      end associate
      grid%element_lower = reshape([grid%element_lower, grid%element_lower(:, e)], [ndim, grid%n_elements + 1])
      grid%element_size = [grid%element_size, grid%element_size(e)]
      grid%element_nodes = reshape([grid%element_nodes, nodes], [corners, grid%n_elements + 1])
      grid%element_leaf = [grid%element_leaf, grid%element_leaf(e)]
      grid%n_elements = grid%n_elements + 1
      call grid%dofs%connect(grid%element_nodes, status)
      call check(status == 0, 'the rows of slots are found')
   end subroutine add_element

   !> Double elements of a model, and give every other column of their particles to the second one.
   subroutine double_elements(m, elements)
      type(problem_t), intent(inout) :: m
      integer, intent(in) :: elements(:)
      type(failure_t) :: failure
      real(dp) :: xi(ndim)
      integer :: k, i, b
      do k = 1, size(elements)
         call add_element(m%grid, elements(k), m%grid%element_nodes(:, elements(k)))
         do i = 1, m%particles%n
            if (m%particles%cell(i) /= elements(k)) cycle
            xi = m%grid%local_coordinate(elements(k), m%particles%place_in_grid(i))
            if (mod(floor(4*xi(1)), 2) == 0) m%particles%cell(i) = m%grid%n_elements
         end do
      end do
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure, left=[(.false., b=1, m%blocks%n)])
      call check(.not. failure%failed(), 'the particles are sorted')
   end subroutine double_elements

   !> A body of 4 x 4 particles a cell, strained and in motion, once as it is and once with an element doubled in the middle, so
   !> that there are five around each of its nodes. An end is held.
   subroutine two_bodies(frame, plain, doubled)
      character(*), intent(in) :: frame
      type(problem_t), intent(out) :: plain, doubled
      integer :: i
      call place_bodies(forest_t([0.0_dp, 0.0_dp], 0.1_dp, [5, 4]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([0.1_dp, 0.1_dp], [0.4_dp, 0.3_dp], [12, 8])], plain)
      plain%particles%total_frame = frame == 'total'
      call random_number(plain%particles%velocity)
      plain%particles%velocity = 0.001_dp*(2*plain%particles%velocity - 1)
      do i = 1, plain%particles%n
         plain%particles%displacement(i, :) = 1.0e-4_dp*plain%particles%reference(i, :)
         plain%particles%gradient(i, :, :) = 1.0e-4_dp*reshape([1, 0, 0, 1], [ndim, ndim])
      end do
      call constrain_box(plain%constraints, plain%grid, [0.1_dp, 0.0_dp], [0.1_dp, 0.4_dp], [.true., .false.])
      doubled = plain
      call double_elements(doubled, [doubled%grid%element_at(place)])
   end subroutine two_bodies

   !> Largest difference of a field of the particles of two models, which are in different order.
   pure real(dp) function difference(a, b, field_a, field_b)
      type(problem_t), intent(in) :: a, b
      real(dp), intent(in) :: field_a(:, :), field_b(:, :)
      integer :: in_a(a%particles%n), in_b(b%particles%n), i
      in_a(a%particles%id) = [(i, i=1, size(in_a))]
      in_b(b%particles%id) = [(i, i=1, size(in_b))]
      difference = maxval(abs(field_a(in_a, :) - field_b(in_b, :)))
   end function difference

   !> Elements and nodes say the same in both directions, with five elements at a node.
   subroutine check_rows()
      type(problem_t) :: plain, doubled
      integer :: e, c, node, wrong
      integer, allocatable :: at(:)
      call two_bodies('total', plain, doubled)
      associate (grid => doubled%grid)
         wrong = 0
         do node = 1, grid%n_points
            at = pack([(e, e=1, grid%n_elements)], any(grid%element_nodes == node, dim=1))
            if (size(at) /= size(grid%dofs%elements_at(node))) then
               wrong = wrong + 1
            else if (any(at /= grid%dofs%elements_at(node))) then
               wrong = wrong + 1
            end if
         end do
         call check(wrong == 0, 'the elements around every node are found, in ascending order')
         e = grid%element_at(place)
         call check(all([(size(grid%dofs%elements_at(grid%element_nodes(c, e))), c=1, corners)] == corners + 1), &
                    'around the nodes of the doubled element there are five')
         call check(all([(size(grid%dofs%elements_at(grid%element_nodes(c, e))), c=1, corners)] &
                        == [(size(grid%dofs%corners_at(grid%element_nodes(c, e))), c=1, corners)]), 'each of them at a corner')
      end associate
   end subroutine check_rows

   !> Products by rows are those by cells with more nodes around a node than four cells have: elements that share no more than one
   !> node with the others, as at the tip of a crack.
   subroutine check_products()
      type(grid_t) :: grid
      type(failure_t) :: failure
      type(pattern_t) :: pattern
      type(spans_t) :: spans
      real(dp), allocatable :: cell(:, :, :), row(:, :), ones(:, :), x(:, :), y(:, :), expected(:, :)
      real(dp) :: xax(ndim)
      integer :: e, i, status
      call build_grid(forest_t([0.0_dp, 0.0_dp], 1.0_dp, [4, 3]), grid, failure)
      call add_element(grid, 6, [grid%n_nodes + 1, grid%n_nodes + 2, grid%n_nodes + 3, grid%element_nodes(4, 6)])
      call add_element(grid, 7, [grid%n_nodes + 1, grid%n_nodes + 2, grid%element_nodes(3, 7), grid%n_nodes + 3])
      call add_element(grid, 7, [grid%n_nodes + 1, grid%n_nodes + 2, grid%element_nodes(3, 7), grid%n_nodes + 3])
      allocate (cell(corners, corners, grid%n_elements), x(ndim, grid%n_nodes), y(ndim, grid%n_nodes))
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
      call check(status == 0 .and. pattern%width == 9 + 3*3 .and. pattern%width > unlike_neighbours, &
                 'rows are as long as the most crowded node asks for')
      allocate (row(pattern%width, grid%n_nodes))
      associate (nodes => [(i, i=1, grid%n_nodes)])
         call sum_rows(pattern, size(nodes), nodes, cell, row)
         call find_spans(pattern, nodes, size(nodes), spans)
      end associate
      call multiply_rows(pattern%width, size(spans%first), spans%first, spans%last, spans%offset, row, ones, x, y, xax)
      call check_close(maxval(abs(y - expected)), 0.0_dp, 1.0e-13_dp, 'a product by rows is that by cells at crowded nodes')
   end subroutine check_products

   !> Masses, momenta and mass matrix are those of the particles, whichever element they are in.
   subroutine check_mapping()
      type(problem_t) :: plain, doubled
      real(dp) :: mass
      integer :: node
      call two_bodies('updated', plain, doubled)
      call start(plain, 'musl', choice_of('fmpm', order=2))
      call start(doubled, 'musl', choice_of('fmpm', order=2))
      call refresh_grid(plain)
      call refresh_grid(doubled)
      mass = sum(plain%particles%mass)
      associate (f => doubled%fields, g => plain%fields)
         associate (dofs => doubled%grid%dofs, count_in => doubled%blocks%count_in)
            call check(size(doubled%blocks%high_valence, 2) == sum([(max(0, count(count_in(dofs%elements_at(node)) > 0) &
                                                                         - corners), &
                                                                     node=1, doubled%grid%n_nodes)]), &
                       'elements with particles beyond the fourth have no room in the table')
            call check(size(doubled%blocks%high_valence, 2) > 0, 'and there are such elements')
         end associate
         call check_close(sum(f%mass_matrix%lumped), mass, 1.0e-14_dp*mass, 'the nodes have the mass of the particles')
         call check_close(maxval(abs(sum(f%momentum, dim=2) - matmul(plain%particles%mass, plain%particles%velocity))), 0.0_dp, &
                          1.0e-16_dp*mass, 'and their momentum')
         call check_close(maxval(abs(f%mass_matrix%lumped - g%mass_matrix%lumped)), 0.0_dp, 1.0e-15_dp*mass, 'each node its own')
         call check_close(maxval(abs(f%momentum - g%momentum)), 0.0_dp, 1.0e-18_dp*mass, 'in momentum too')
         call check_close(maxval(abs(dense_matrix(doubled) - dense_matrix(plain))), 0.0_dp, 1.0e-15_dp*mass, &
                          'and so is the mass matrix by cells')
         associate (nodes => f%mass_matrix%all%nodes(:f%mass_matrix%all%n_nodes))
            call check_close(maxval(abs(f%mass_matrix%row(:, nodes) - g%mass_matrix%row(:, nodes))), 0.0_dp, 1.0e-15_dp*mass, &
                             'and by rows')
         end associate
      end associate
   end subroutine check_mapping

   !> What is found from the particles around a node is found from those of all its elements.
   subroutine check_patches()
      type(problem_t) :: plain, doubled
      type(patch_t) :: a, b
      real(dp), allocatable :: values(:, :)
      integer :: node, c
      call two_bodies('total', plain, doubled)
      call start(plain, 'musl')
      call start(doubled, 'musl')
      do c = 1, corners
         node = plain%grid%element_nodes(c, plain%grid%element_at(place))
         call patch_around(plain%grid, plain%particles, plain%blocks, node, a)
         call patch_around(doubled%grid, doubled%particles, doubled%blocks, node, b)
         call check(a%n == b%n .and. a%n_nodes == b%n_nodes, 'a patch has the particles and nodes of all elements')
         call check_close(patch_mass(b, doubled%particles), patch_mass(a, plain%particles), 1.0e-17_dp, 'with their mass')
         call check_close(maxval(abs(internal_force(b, doubled%particles, doubled%materials) &
                                     - internal_force(a, plain%particles, plain%materials))), 0.0_dp, 1.0e-20_dp, 'and force')
         call check_close(maxval(abs(fitted_displacement(b, doubled%particles) - 1.0e-4_dp*plain%grid%node_position(:, node))), &
                          0.0_dp, 1.0e-16_dp, 'and displacement')
         call check(doubled%grid%smallest_leaf_at(node) <= 0.1_dp + 1.0e-15_dp, 'the leaves are those of the elements')
      end do
      allocate (values(1, doubled%grid%n_points))
      call recover(doubled%matter_t, doubled%fields%mass_matrix, 1, &
                   doubled%particles%reference(:, 1), values)
      associate (all => doubled%fields%mass_matrix%all)
         call check_close(maxval(abs(values(1, all%nodes(:all%n_nodes)) &
                                     - doubled%grid%node_position(1, all%nodes(:all%n_nodes)))), 0.0_dp, 0.05_dp, &
                          'recovered values are near those of the particles')
      end associate
   end subroutine check_patches

   !> The motion is the same, whichever element the particles are in.
   subroutine check_steps(what, scheme, mass, frame)
      character(*), intent(in) :: what, scheme, frame
      type(mass_choice_t), intent(in) :: mass
      type(problem_t) :: plain, doubled
      real(dp) :: moved
      call two_bodies(frame, plain, doubled)
      call load_and_damp(plain)
      call load_and_damp(doubled)
      moved = maxval(abs(plain%particles%velocity))
      call start(plain, scheme, mass)
      call start(doubled, scheme, mass)
      call run_steps(plain, 0.02_dp, 20)
      call run_steps(doubled, 0.02_dp, 20)
      call check_close(difference(plain, doubled, plain%particles%velocity, doubled%particles%velocity), 0.0_dp, &
                       1.0e-11_dp*moved, what//', '//frame//' frame: velocities are those with one element')
      call check_close(difference(plain, doubled, plain%particles%displacement, doubled%particles%displacement), 0.0_dp, &
                       1.0e-14_dp, what//', '//frame//' frame: so are displacements')
      call check_close(doubled%energies%damping_loss, plain%energies%damping_loss, 1.0e-11_dp*abs(plain%energies%damping_loss), &
                       what//', '//frame//' frame: and the energy that the damping takes')
      call plain%solver%direct%release()
      call doubled%solver%direct%release()
   end subroutine check_steps

   !> A force on all material, and damping.
   subroutine load_and_damp(m)
      type(problem_t), intent(inout) :: m
      allocate (m%loads(1))
      call load_on_particles(m%particles, [0.0_dp, 0.0_dp], [1.0_dp, 1.0_dp], m%loads(1))
      m%loads(1)%force = [1.0e-5_dp, 2.0e-5_dp]
      m%damping_rate = 0.2_dp
   end subroutine load_and_damp

   !> So it is where elements of hanging nodes are doubled.
   subroutine check_hanging_nodes()
      type(problem_t) :: plain, doubled
      type(forest_t) :: forest
      type(failure_t) :: failure
      forest = forest_t([0.0_dp, 0.0_dp], 1.0_dp, [8, 6])
      call refine_box(forest, [2.45_dp, 2.45_dp], [3.55_dp, 3.55_dp], 2)
      call place_bodies(forest, new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([1.0_dp, 2.0_dp], [7.0_dp, 4.0_dp], 8*[6, 2])], plain)
      plain%particles%total_frame = .true.
      call random_number(plain%particles%velocity)
      call sort_into_cells(plain%cache%sorting, plain%particles, plain%grid, plain%blocks, failure)
      doubled = plain
      call double_elements(doubled, plain%blocks%occupied(3:plain%blocks%n_occupied:5))
      call check(any(doubled%grid%element_nodes(:, plain%grid%n_elements + 1:) > doubled%grid%n_nodes), &
                 'some doubled elements have hanging nodes')
      call start(plain, 'musl')
      call start(doubled, 'musl')
      call run_steps(plain, 0.05_dp, 20)
      call run_steps(doubled, 0.05_dp, 20)
      call check_close(difference(plain, doubled, plain%particles%velocity, doubled%particles%velocity), 0.0_dp, &
                       1.0e-11_dp, 'hanging nodes: velocities are those with one element')
   end subroutine check_hanging_nodes
end program test_high_valence_nodes
