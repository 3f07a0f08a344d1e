!> The displacement field of a leaf, or of a piece of one that is cut, from what its particles carry.
!>
!> Particles have followed the nodes: u and its gradient are those of one field that is bilinear in each element of the leaf. Its
!> values at the nodes are found again by least squares: exactly where particles have stayed in the leaf, closely elsewhere.
module hampm_leaf_field
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions, shape_gradients, inside_cell
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_grid, only: grid_t
   use hampm_lapack, only: dposv
   use hampm_particles, only: particles_t
   use hampm_tensors, only: identity, inverse_transpose
   implicit none
   private
   public :: twist_of_element, spatial_gradient

   !> Added to the diagonal, of which the entries are about 1: values that the particles leave open stay small. Of the sixteen
   !> digits of the others it takes none but the last six, and leaves six in solving for the open ones.
   real(dp), parameter :: ridge = 1.0e-10_dp

contains

   !> Twist of the displacement field in an element, its mixed second derivative [1/m], from the particles of a body in the leaf. It
   !> counts in the grid's coordinates: in space, in the total frame in the reference configuration.
   function twist_of_element(grid, p, blocks, e, body) result(twist)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: e, body
      real(dp) :: twist(ndim)
      real(dp) :: matrix(most_nodes_of_leaf, most_nodes_of_leaf), rhs(most_nodes_of_leaf, ndim), part(corners, most_nodes_of_leaf)
      real(dp) :: middle(ndim), mean_u(ndim), mean_gradient(ndim, ndim), at_corner(corners, ndim), deviation(ndim)
      integer :: node(most_nodes_of_leaf), in_element(most_nodes_of_leaf), n, n_here, i, k, info
      twist = 0
      call find_means(grid, p, blocks, e, body, middle, mean_u, mean_gradient, n)
      if (n < 2) return
      n = 0
      matrix = 0
      rhs = 0
      deviation = 0
      do k = grid%first_of_piece(e), grid%last_of_piece(e)
         do i = blocks%first_in(k), blocks%last_in(k), blocks%stride_in(k)
            if (p%body(i) /= body) cycle
            call add_particle(grid, p, i, middle, mean_u, mean_gradient, n, node, matrix, rhs)
            deviation = max(deviation, maxval(abs(spatial_gradient(p, i) - mean_gradient), dim=2))
         end do
      end do
      do k = 1, n
         matrix(k, k) = matrix(k, k) + ridge
      end do
      call dposv('L', n, ndim, matrix, most_nodes_of_leaf, rhs, most_nodes_of_leaf, info)
      if (info /= 0) return
      call grid%dofs%masters_of(grid%element_nodes(:, e), n_here, in_element, part)
      at_corner = 0
      do k = 1, n_here
         i = findloc(node(:n), in_element(k), dim=1)
         if (i > 0) at_corner = at_corner + spread(part(:, k), 2, ndim)*spread(rhs(i, :), 1, corners)
      end do
      twist = (at_corner(4, :) - at_corner(3, :) - at_corner(2, :) + at_corner(1, :))/grid%element_size(e)**2
      ! A child, an eighth of the leaf from its parent, is not to differ more from it than the particles of the leaf do from
      ! their mean: where these do not follow one field, or hardly determine it, anything might come out
      twist = sign(min(abs(twist), 8*deviation/grid%leaf_size(e)), twist)
   end function twist_of_element

   !> Number and means of the particles of a body in the leaf of an element, or its piece: place, displacement and gradient.
   subroutine find_means(grid, p, blocks, element, body, middle, mean_u, mean_gradient, n)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: element, body
      real(dp), intent(out) :: middle(ndim), mean_u(ndim), mean_gradient(ndim, ndim)
      integer, intent(out) :: n
      integer :: e, i
      n = 0
      middle = 0
      mean_u = 0
      mean_gradient = 0
      do e = grid%first_of_piece(element), grid%last_of_piece(element)
         do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
            if (p%body(i) /= body) cycle
            n = n + 1
            middle = middle + p%place_in_grid(i)
            mean_u = mean_u + p%displacement(i, :)
            mean_gradient = mean_gradient + spatial_gradient(p, i)
         end do
      end do
      middle = middle/max(n, 1)
      mean_u = mean_u/max(n, 1)
      mean_gradient = mean_gradient/max(n, 1)
   end subroutine find_means

   !> Add what a particle knows of the nodal values to the normal equations: its displacement and, times the size of its element,
   !> the gradient, each less that of the mean linear field.
   subroutine add_particle(grid, p, i, middle, mean_u, mean_gradient, n, node, matrix, rhs)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp), intent(in) :: middle(ndim), mean_u(ndim), mean_gradient(ndim, ndim)
      integer, intent(inout) :: n, node(:)
      real(dp), intent(inout) :: matrix(:, :), rhs(:, :)
      real(dp) :: xi(ndim), part(corners, most_nodes_of_leaf), row(most_nodes_of_leaf, 0:ndim), value(ndim, 0:ndim)
      integer :: in_element(most_nodes_of_leaf), place(most_nodes_of_leaf), n_here, k, d
      associate (e => p%cell(i))
         xi = inside_cell(grid%local_coordinate(e, p%place_in_grid(i)))
         call grid%dofs%masters_of(grid%element_nodes(:, e), n_here, in_element, part)
         row(:, 0) = matmul(shape_functions(xi), part)
         row(:, 1:) = transpose(matmul(transpose(shape_gradients(xi, 1.0_dp)), part))
         value(:, 0) = p%displacement(i, :) - mean_u - matmul(mean_gradient, p%place_in_grid(i) - middle)
         value(:, 1:) = grid%element_size(e)*(spatial_gradient(p, i) - mean_gradient)
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
end module hampm_leaf_field
