!> Patch test on each kind of transition cell, one by one: a cell whose neighbours across sides, and in space across edges, are finer or not. Kinds that are
!> images of each other by mirrors and exchanged axes are taken once, and in space so are those whose edges have the same nodes: a finer neighbour
!> across a side puts nodes on its edges, whatever is across these.
!>
!> The cell is the middle one of 3 by 3 (by 3), which a body fills under a linear displacement. All nodes of the cell are inside of the body, and so without force.
program test_transition_cells
   use hampm_kinds, only: dp, ndim
   use hampm_energy, only: linear_momentum
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_matching, only: adopt_forest
   use hampm_material, only: new_material
   use hampm_problem, only: assemble_sums, problem_t, refresh_grid
   use hampm_samples, only: rectangle_t, place_bodies, start
   implicit none

   integer, parameter :: neighbours = merge(4, 18, ndim == 2), expected_kinds = merge(5, 226, ndim == 2) ! by Burnside
   integer, parameter :: force = 1, mass = 2, momentum = 3, hanging = 4, gradient = 5, no_mass = 6 !! of the figures of `look`
   real(dp), parameter :: cell = 0.3_dp, rounding = 1e-13_dp
   integer, parameter :: axis(*) = [0, 1, 2], first(ndim) = axis(:ndim)
   integer :: offset(ndim, neighbours)           ! of the neighbours from the cell, sides first
   real(dp) :: worst(6), figures(6)
   integer :: code, kinds

   call repeat_random_numbers()
   call list_neighbours()
   worst = 0
   kinds = 0
   do code = 1, 2**neighbours - 1
      if (.not. is_first_of_kind(code)) cycle
      kinds = kinds + 1
      call look(code, figures)
      worst = max(worst, figures)
   end do
   call check(kinds == expected_kinds, 'there are as many kinds of transition cell as Burnside counts')
   call check_close(worst(force), 0.0_dp, rounding, 'a linear field leaves no force on the nodes of the cell')
   call check_close(worst(mass), 0.0_dp, rounding, 'the nodes have the mass of the body')
   call check_close(worst(momentum), 0.0_dp, rounding, 'and its momentum')
   call check_close(worst(hanging), 0.0_dp, rounding, 'hanging nodes have what a linear field has there')
   call check_close(worst(gradient), 0.0_dp, rounding, 'and so have the functions at the particles')
   call check(worst(no_mass) <= 0, 'all nodes have mass')
   write (*, '(i0,a,5es9.1)') kinds, ' kinds; force, mass, momentum, hanging nodes, gradient:', worst(:gradient)
   call finish()

contains

   !> The neighbours across sides and edges, but not those across corners alone.
   subroutine list_neighbours()
      integer :: k, n, d(ndim), away
      n = 0
      do away = 1, ndim - 1
         do k = 0, 3**ndim - 1
            d = modulo(k/3**first, 3) - 1
            if (count(d /= 0) /= away) cycle
            n = n + 1
            offset(:, n) = d
         end do
      end do
   end subroutine list_neighbours

   !> Whether a neighbour is finer.
   pure logical function is_finer(code, k)
      integer, intent(in) :: code, k
      is_finer = btest(code, k - 1)
   end function is_finer

   !> Whether a set of finer neighbours has all of those across the edges of finer sides, and no image with a lesser number.
   logical function is_first_of_kind(code)
      integer, intent(in) :: code
      integer :: axes(ndim), k, j, turn, flip, image
      is_first_of_kind = .false.
      do k = 1, neighbours
         if (k > 2*ndim .and. .not. is_finer(code, k) .and. any([(is_finer(code, j) .and. is_side_of(j, k), j=1, 2*ndim)])) return
      end do
      do turn = 0, ndim**ndim - 1
         axes = modulo(turn/ndim**first, ndim) + 1
         if (any([(count(axes == j) /= 1, j=1, ndim)])) cycle
         do flip = 0, 2**ndim - 1
            image = 0
            do k = 1, neighbours
               if (is_finer(code, k)) image = ibset(image, image_of(k, axes, flip) - 1)
            end do
            if (image < code) return
         end do
      end do
      is_first_of_kind = .true.
   end function is_first_of_kind

   !> Whether the edge of a neighbour is one of the side of another.
   pure logical function is_side_of(side, edge)
      integer, intent(in) :: side, edge
      is_side_of = dot_product(offset(:, side), offset(:, edge)) == 1
   end function is_side_of

   !> Number of the image of a neighbour.
   pure integer function image_of(k, axes, flip)
      integer, intent(in) :: k, axes(ndim), flip
      integer :: d(ndim)
      d = offset(axes, k)*merge(-1, 1, modulo(flip/2**first, 2) == 1)
      do image_of = 1, neighbours
         if (all(offset(:, image_of) == d)) return
      end do
   end function image_of

   !> A body of such a mesh, with a random linear field and random velocities: errors of the nodes.
   subroutine look(code, figures)
      integer, intent(in) :: code
      real(dp), intent(out) :: figures(6)
      type(problem_t) :: m
      type(failure_t) :: failure
      type(forest_t) :: forest
      type(rectangle_t) :: body
      real(dp) :: h(ndim, ndim), mass_before, momentum_before(ndim), scale, x(ndim)
      real(dp), allocatable :: u(:, :)
      integer, allocatable :: change(:)
      integer :: k, i
      body%upper = 3*cell
      body%points = 6
      call place_bodies(forest_t(body%lower, cell, body%points/2), &
                        new_material('', 'linear_elastic', .true., 2.0_dp, 0.3_dp, 1.5_dp), [body], m)
      call random_number(h)
      m%particles%total_frame = .true.
      do i = 1, m%particles%n
         m%particles%gradient(i, :, :) = h
         m%particles%displacement(i, :) = matmul(h, m%particles%reference(i, :))
      end do
      call random_number(m%particles%velocity)
      call start(m, 'usl')
      mass_before = sum(m%particles%mass)
      momentum_before = linear_momentum(m%particles)
      forest = m%grid%forest
      allocate (change(forest%leaf_count()), source=0)
      do k = 1, neighbours                       ! finer ones across sides put nodes on the edges
         if (.not. is_finer(code, k) .or. k > 2*ndim .and. any([(is_finer(code, i) .and. is_side_of(i, k), i=1, 2*ndim)])) cycle
         change(forest%leaf_at((1.5_dp + offset(:, k))*cell)) = 1
      end do
      call forest%adapt(change)
      call adopt_forest(m, forest, failure)
      if (failure%failed()) call check(.false., failure%message)
      call refresh_grid(m)
      call assemble_sums(m, mass=.false., momentum=.false., force=.true.)
      figures = 0
      associate (all => m%fields%mass_matrix%all, f => m%fields, grid => m%grid, p => m%particles)
         call grid%dofs%condense(all, ndim, f%force)
         scale = norm2(m%materials(1)%kirchhoff_stress(h))*cell**(ndim - 1)
         figures(mass) = abs(sum(f%mass_matrix%lumped(:grid%n_nodes))/mass_before - 1)
         figures(momentum) = maxval(abs(sum(f%momentum(:, :grid%n_nodes), dim=2)/momentum_before - 1))
         figures(no_mass) = count(f%mass_matrix%lumped(all%nodes(:all%n_nodes)) <= 0)
         allocate (u(ndim, grid%n_points), source=0.0_dp)
         do i = 1, grid%n_nodes
            x = grid%node_position(:, i)
            u(:, i) = matmul(h, x)
            if (all_within(x, 0.25_dp*cell, 2.75_dp*cell)) figures(force) = max(figures(force), maxval(abs(f%force(:, i)))/scale)
         end do
         call grid%dofs%distribute(grid%dofs%every_node(), ndim, u)
         do i = grid%n_nodes + 1, grid%n_points
            figures(hanging) = max(figures(hanging), maxval(abs(u(:, i) - matmul(h, grid%node_position(:, i))))/cell)
         end do
         do i = 1, p%n
            associate (nodes => grid%element_nodes(:, p%cell(i)), xi => grid%local_coordinate(p%cell(i), p%reference(i, :)))
               figures(gradient) = max(figures(gradient), maxval(abs(matmul(u(:, nodes), grid%gradients_in(p%cell(i), xi)) - h)))
            end associate
         end do
      end associate
   end subroutine look

   !> Whether a place is between two in all directions.
   pure logical function all_within(x, lower, upper)
      real(dp), intent(in) :: x(ndim), lower, upper
      all_within = all(x > lower .and. x < upper)
   end function all_within
end program test_transition_cells
