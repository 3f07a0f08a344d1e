!> Fields that children of particles take from their cells: the velocity gradient, and the mixed derivatives of the displacement.
!>
!> The displacement field of a leaf, or of a piece of a cut one, from its particles.
!>
!> Particles have followed the nodes: u and its gradient belong to one field that is bilinear in each element of the leaf. Its nodal
!> values are found again by least squares: exactly where particles have stayed in the leaf, closely elsewhere.
module hampm_leaf_fields
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: interpolate_gradient, hourglasses_of, n_hourglasses, hourglass_directions, &
      inside_cell, shape_functions, shape_gradients
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_recovery, only: slope_weights
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_lapack, only: dsyev
   use hampm_matter, only: matter_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: identity, inverse_transpose
   implicit none
   private
   public :: is_on_crack, displacement_hourglasses, velocity_gradients

   !> Nodal values, or sums of them, that count for less than this of those that particles determine best are left open and 0. The
   !> particles never fit one field better than to some percent: what hardly shows in them would come out many times too large.
   real(dp), parameter :: hardly = 1.0e-3_dp

contains

   !> Whether a crack runs through the middle of a particle, to which it gives a wrong side.
   pure logical function is_on_crack(m, i)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp) :: x(ndim)
      x = m%particles%reference(i, :)
      is_on_crack = m%grid%cut_cells%is_on_line(m%grid%element_leaf(m%particles%cell(i)), x)
   end function is_on_crack

   !> Velocity gradient at the marked particles [1/s], from the momentum mapped to the grid as it is.
   function velocity_gradients(m, marked) result(gradients)
      type(problem_t), intent(inout) :: m
      logical, intent(in) :: marked(:)
      real(dp), allocatable :: gradients(:, :, :)
      real(dp), allocatable :: velocity(:, :)
      real(dp) :: xi(ndim)
      integer :: a, i, k
      allocate (gradients(ndim, ndim, count(marked)))
      allocate (velocity(ndim, m%grid%n_points), source=0.0_dp)
      call refresh_grid(m)
      associate (all => m%fields%mass_matrix%all, lumped => m%fields%mass_matrix%lumped)
         do a = 1, all%n_nodes
            if (lumped(all%nodes(a)) > 0) velocity(:, all%nodes(a)) = m%fields%momentum(:, all%nodes(a))/lumped(all%nodes(a))
         end do
         call m%grid%dofs%distribute(all, ndim, velocity)
      end associate
      k = 0
      do i = 1, m%particles%n
         if (.not. marked(i)) cycle
         k = k + 1
         associate (e => m%particles%cell(i))
            if (is_on_crack(m, i)) then
               gradients(:, :, k) = gradient_beside_crack(m, i)
               cycle
            end if
            xi = inside_cell(m%grid%local_coordinate(e, m%particles%place_in_grid(i)))
            gradients(:, :, k) = interpolate_gradient(xi, velocity(:, m%grid%element_nodes(:, e)))/m%grid%element_size(e)
         end associate
      end do
   end function velocity_gradients

   !> Velocity gradient that best fits the particles of a body on all sides of the cracks in a leaf, each side with a mean velocity
   !> of its own [1/s]. Particles on a crack, as `of` is, do not count: they have no side, but cells have them on one.
   function gradient_beside_crack(m, of) result(gradient)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: of
      real(dp) :: gradient(ndim, ndim)
      real(dp) :: spread_x(ndim, ndim), moment(ndim, ndim)
      real(dp), allocatable :: x(:, :), v(:, :)  ! from the mean of those on a side
      integer, allocatable :: number(:)
      integer :: piece, e, i, d, n
      spread_x = 0
      moment = 0
      n = 0
      associate (p => m%particles, leaf => m%grid%element_leaf(m%particles%cell(of)), blocks => m%blocks, &
                 width => m%grid%leaf_size(m%particles%cell(of)))
         do piece = m%grid%leaf_element(leaf), m%grid%leaf_element(leaf + 1) - 1, m%grid%quarters_of(leaf)
            associate (held => [([(i, i=blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e))], &
                                 e=piece, m%grid%last_of_piece(piece))])
               number = pack(held, [(p%body(held(i)) == p%body(of) .and. .not. is_on_crack(m, held(i)), i=1, size(held))])
            end associate
            x = reshape([(p%place_in_grid(number(i)), i=1, size(number))], [ndim, size(number)])/width
            v = transpose(p%velocity(number, :))
            do d = 1, ndim
               x(d, :) = x(d, :) - sum(x(d, :))/max(size(number), 1)
               v(d, :) = v(d, :) - sum(v(d, :))/max(size(number), 1)
            end do
            spread_x = spread_x + matmul(x, transpose(x))
            moment = moment + matmul(v, transpose(x))
            n = n + size(number)
         end do
         do d = 1, ndim
            gradient(:, d) = matmul(moment, slope_weights(spread_x/max(n, 1), identity(:, d)))/(max(n, 1)*width)
         end do
      end associate
   end function gradient_beside_crack

   !> Hourglasses (mixed derivatives) of the displacement field at the marked particles [1/m, 1/m2]: none on a crack, and none where
   !> material has yielded. Its plastic strains would not follow those of the children, which would store the difference.
   function displacement_hourglasses(m, marked) result(hourglasses)
      type(problem_t), intent(in) :: m
      logical, intent(in) :: marked(:)
      real(dp), allocatable :: hourglasses(:, :, :)
      integer :: i, k
      allocate (hourglasses(ndim, n_hourglasses, count(marked)))
      k = 0
      do i = 1, m%particles%n
         if (.not. marked(i)) cycle
         k = k + 1
         hourglasses(:, :, k) = 0
         if (.not. (is_on_crack(m, i) .or. has_yielded(m%matter_t, i))) &
            hourglasses(:, :, k) = hourglasses_at(m%matter_t, i, m%particles%cell(i), m%particles%body(i))
      end do
   end function displacement_hourglasses

   !> Whether a particle has plastic strains.
   pure logical function has_yielded(m, i)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: i
      has_yielded = m%materials(m%particles%material(i))%yields
      if (has_yielded) has_yielded = any(abs(m%particles%history(i, :)) > 0)
   end function has_yielded

   !> Hourglasses of the displacement field at a particle, from the particles of its body in the leaf, in the grid's coordinates: in
   !> space, in the total frame in the reference configuration.
   function hourglasses_at(m, particle, e, body) result(hourglasses)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: particle, e, body
      real(dp) :: hourglasses(ndim, n_hourglasses)
      real(dp) :: matrix(most_nodes_of_leaf, most_nodes_of_leaf), rhs(most_nodes_of_leaf, ndim), part(corners, most_nodes_of_leaf)
      real(dp) :: middle(ndim), mean_u(ndim), mean_gradient(ndim, ndim), at_corner(corners, ndim), deviation(ndim)
      real(dp) :: xi(ndim), t(ndim), count_of(most_nodes_of_leaf), work(3*most_nodes_of_leaf)
      integer :: node(most_nodes_of_leaf), in_element(most_nodes_of_leaf), n, n_here, i, k, info
      hourglasses = 0
      call find_means(m, e, body, middle, mean_u, mean_gradient, n)
      if (n < 2) return
      n = 0
      matrix = 0
      rhs = 0
      deviation = 0
      do k = m%grid%first_of_piece(e), m%grid%last_of_piece(e)
         do i = m%blocks%first_in(k), m%blocks%last_in(k), m%blocks%stride_in(k)
            if (m%particles%body(i) /= body) cycle
            call add_particle(m, i, middle, mean_u, mean_gradient, n, node, matrix, rhs)
            deviation = max(deviation, maxval(abs(spatial_gradient(m%particles, i) - mean_gradient), dim=2))
         end do
      end do
      call dsyev('V', 'L', n, matrix, most_nodes_of_leaf, count_of, work, size(work), info)
      if (info /= 0) return
      rhs(:n, :) = matmul(transpose(matrix(:n, :n)), rhs(:n, :))
      do k = 1, n
         rhs(k, :) = merge(rhs(k, :)/max(count_of(k), tiny(1.0_dp)), 0.0_dp, count_of(k) > hardly*count_of(n))
      end do
      rhs(:n, :) = matmul(matrix(:n, :n), rhs(:n, :))
      call m%grid%dofs%masters_of(m%grid%element_nodes(:, e), n_here, in_element, part)
      at_corner = 0
      do k = 1, n_here
         i = findloc(node(:n), in_element(k), dim=1)
         if (i > 0) at_corner = at_corner + spread(part(:, k), 2, ndim)*spread(rhs(i, :), 1, corners)
      end do
      xi = inside_cell(m%grid%local_coordinate(e, m%particles%place_in_grid(particle)))
      hourglasses = hourglasses_of(xi, transpose(at_corner))
      ! A child, an eighth of the leaf from its parent, is not to differ more from it than the particles of the leaf do from
      ! their mean: where these do not follow one field, or hardly determine it, anything might come out
      do k = 1, n_hourglasses
         associate (n => popcnt(hourglass_directions(k)), bound => 8*deviation/m%grid%leaf_size(e))
            t = hourglasses(:, k)/m%grid%element_size(e)**n
            hourglasses(:, k) = sign(min(abs(t), bound*(8/m%grid%leaf_size(e))**(n - 2)), t)
         end associate
      end do
   end function hourglasses_at

   !> Number and means of the particles of a body in the leaf of an element, or its piece: place, displacement and gradient.
   subroutine find_means(m, element, body, middle, mean_u, mean_gradient, n)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: element, body
      real(dp), intent(out) :: middle(ndim), mean_u(ndim), mean_gradient(ndim, ndim)
      integer, intent(out) :: n
      integer :: e, i
      n = 0
      middle = 0
      mean_u = 0
      mean_gradient = 0
      do e = m%grid%first_of_piece(element), m%grid%last_of_piece(element)
         do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
            if (m%particles%body(i) /= body) cycle
            n = n + 1
            middle = middle + m%particles%place_in_grid(i)
            mean_u = mean_u + m%particles%displacement(i, :)
            mean_gradient = mean_gradient + spatial_gradient(m%particles, i)
         end do
      end do
      middle = middle/max(n, 1)
      mean_u = mean_u/max(n, 1)
      mean_gradient = mean_gradient/max(n, 1)
   end subroutine find_means

   !> Add the data of a particle on the nodal values to the normal equations: its displacement and, times the size of its element,
   !> the gradient, each less the mean linear field.
   subroutine add_particle(m, i, middle, mean_u, mean_gradient, n, node, matrix, rhs)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp), intent(in) :: middle(ndim), mean_u(ndim), mean_gradient(ndim, ndim)
      integer, intent(inout) :: n, node(:)
      real(dp), intent(inout) :: matrix(:, :), rhs(:, :)
      real(dp) :: xi(ndim), part(corners, most_nodes_of_leaf), row(most_nodes_of_leaf, 0:ndim), value(ndim, 0:ndim)
      integer :: in_element(most_nodes_of_leaf), place(most_nodes_of_leaf), n_here, k, d
      associate (e => m%particles%cell(i))
         xi = inside_cell(m%grid%local_coordinate(e, m%particles%place_in_grid(i)))
         call m%grid%dofs%masters_of(m%grid%element_nodes(:, e), n_here, in_element, part)
         row(:, 0) = matmul(shape_functions(xi), part)
         row(:, 1:) = transpose(matmul(transpose(shape_gradients(xi, 1.0_dp)), part))
         value(:, 0) = m%particles%displacement(i, :) - mean_u - matmul(mean_gradient, m%particles%place_in_grid(i) - middle)
         value(:, 1:) = m%grid%element_size(e)*(spatial_gradient(m%particles, i) - mean_gradient)
      end associate
      do k = 1, n_here
         place(k) = findloc(node(:n), in_element(k), dim=1)
         if (place(k) > 0) cycle
         n = n + 1
         node(n) = in_element(k)
         place(k) = n
      end do
      do d = 0, ndim
         do k = 1, n_here
            matrix(place(:n_here), place(k)) = matrix(place(:n_here), place(k)) + row(k, d)*row(:n_here, d)
            rhs(place(k), :) = rhs(place(k), :) + row(k, d)*value(:, d)
         end do
      end do
   end subroutine add_particle

   !> Gradient of the displacement of a particle in the grid's coordinates: H F^-1 in space; H in the total frame.
   pure function spatial_gradient(p, i) result(g)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: g(ndim, ndim)
      g = p%gradient_of(i)
      if (.not. p%total_frame) g = matmul(g, transpose(inverse_transpose(identity + g)))
   end function spatial_gradient
end module hampm_leaf_fields
