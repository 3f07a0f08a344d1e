!> Operations of a pass on the particles of a batch: blocks of `lanes` cells side by side, consecutive blocks, each in as many rows
!> of one particle of each cell. The loop over the lanes is the vector loop: it loads and stores with unit stride, and sums over the
!> particles of a cell stay in registers. Each procedure does one thing with all blocks of a batch; the pass calls those that it
!> needs.
!>
!> The k-th place of a batch is in lane mod(k - 1, lanes) + 1. Arrays of particles come from the first place on, with their leading
!> dimension. Nodal fields come as the polynomials a1 + a2 xi + a3 eta + a4 xi eta of the lanes' cells, by block; in space with four
!> more terms, times the third coordinate. Private data of a lane are declared in the loop; the compiler unrolls inner loops of
!> constant length.
module hampm_particle_kernels
   use hampm_kinds, only: dp, ndim, plane, corners
   use hampm_basis, only: edge_margin
   use hampm_cell_blocks, only: lanes, of_mass, of_momentum, of_force, n_sums
   use hampm_tensors, only: voigt, n_voigt
   implicit none
   private
   public :: most_blocks, most_rows, n_across, clear, take_corners, locate_reference, locate_present, add_field, add_gradient, &
             add_mass, add_momentum, add_matrix, linear_forces, anisotropic_forces, add_stress, divergence

   integer, parameter :: most_blocks = 16, most_rows = merge(16, 64, ndim == 2) !! that are done at a time
   integer, parameter :: n_across = corners/2   !! corners of the side across a direction, and moments of stress over it
   integer, parameter :: plane_corners = 2**plane

contains

   !> Set sums of the blocks of a batch to zero: the first `m` of every `ld` of each lane. (A constant gfortran 12 would store
   !> number by number.)
   pure subroutine clear(n, m, ld, zeros, sums)
      integer, intent(in) :: n, m, ld
      real(dp), intent(in) :: zeros(lanes)
      real(dp), intent(inout) :: sums(lanes, ld, n)
      integer :: l, k, b
      do b = 1, n
         do k = 1, m
            !$omp simd
            do l = 1, lanes
               sums(l, k, b) = zeros(l)
            end do
         end do
      end do
   end subroutine clear

   !> The polynomials of a nodal vector field in the cells of a batch, times a factor.
   pure subroutine take_corners(n, factor, field, nodes, in_row, a)
      integer, intent(in) :: n
      real(dp), intent(in) :: factor(lanes, n)
      real(dp), intent(in) :: field(ndim, *)            !! by point
      integer, intent(in) :: nodes(corners, lanes, n)   !! points at the corners of the cells
      logical, intent(in) :: in_row(n)                  !! whether the points of a block are rows, each numbered on
      real(dp), intent(out) :: a(lanes, corners, ndim, n)
      integer :: b, l, c, d
      do b = 1, n
         if (in_row(b)) then
            do c = 1, corners, 2
               call take_row(field(1, nodes(c, 1, b)), a(1, c, 1, b))
            end do
         else
            !GCC$ novector
            do l = 1, lanes
               do c = 1, corners
                  do d = 1, ndim
                     a(l, c, d, b) = field(d, nodes(c, l, b))
                  end do
               end do
            end do
         end if
         call find_polynomials(factor(1, b), a(1, 1, 1, b))
      end do
   end subroutine take_corners

   !> The field at two corners of cells side by side, from the points of a row.
   pure subroutine take_row(row, a)
      real(dp), intent(in) :: row(ndim, lanes + 1)
      real(dp), intent(inout) :: a(lanes, corners, *)   !! from the first of the two corners on
      integer :: l, d
      !$omp simd
      do l = 1, lanes
         do d = 1, ndim
            a(l, 1, d) = row(d, l)
            a(l, 2, d) = row(d, l + 1)
         end do
      end do
   end subroutine take_row

   !> The polynomials in the cells of a block, from the values at their corners times a factor.
   pure subroutine find_polynomials(factor, a)
      real(dp), intent(in) :: factor(lanes)
      real(dp), intent(inout) :: a(lanes, corners, ndim)
      integer :: l, c, d, e
      do d = 1, ndim
         !$omp simd
         do l = 1, lanes
            block
               real(dp) :: f(corners)
               do c = 1, corners
                  f(c) = factor(l)*a(l, c, d)
               end do
               do e = 0, ndim - 1
                  do c = 1, corners
                     if (btest(c - 1, e)) f(c) = f(c) - f(c - 2**e)
                  end do
               end do
               do c = 1, corners
                  a(l, c, d) = f(c)
               end do
            end block
         end do
      end do
   end subroutine find_polynomials

   !> Local coordinates of the reference positions, kept inside the cells.
   pure subroutine locate_reference(n, rows, ld, lower, inverse_size, x, xi)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: lower(lanes, ndim, n), inverse_size(lanes, n), x(ld, ndim)
      real(dp), intent(inout) :: xi(ld, ndim)
      integer :: b, s, l, k, d
      do b = 1, n
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            do d = 1, ndim
               !$omp simd
               do l = 1, lanes
                  xi(k + l, d) = min(max((x(k + l, d) - lower(l, d, b))*inverse_size(l, b), edge_margin), 1 - edge_margin)
               end do
            end do
         end do
      end do
   end subroutine locate_reference

   !> Local coordinates of the present positions, kept inside the cells, with the sums of their changes by this, by lane, in cells.
   !> At most `rows` times 2 `ndim` times `edge_margin` is rounding; more, or NaN, tells that a particle has left.
   pure subroutine locate_present(n, rows, ld, lower, inverse_size, x, u, xi, beyond)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: lower(lanes, ndim, n), inverse_size(lanes, n), x(ld, ndim), u(ld, ndim)
      real(dp), intent(inout) :: xi(ld, ndim)
      real(dp), intent(inout) :: beyond(lanes, n)
      real(dp) :: total(lanes)
      integer :: b, s, l, k, d
      do b = 1, n
         total = beyond(:, b)
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            !$omp simd
            do l = 1, lanes
               block
                  real(dp) :: free(ndim), off
                  do d = 1, ndim
                     free(d) = ((x(k + l, d) - lower(l, d, b)) + u(k + l, d))*inverse_size(l, b)
                     xi(k + l, d) = min(max(free(d), edge_margin), 1 - edge_margin)
                  end do
                  off = abs(free(1) - xi(k + l, 1)) + abs(free(2) - xi(k + l, 2))
                  if (ndim > 2) off = off + abs(free(ndim) - xi(k + l, ndim))
                  total(l) = total(l) + off
               end block
            end do
         end do
         beyond(:, b) = total
      end do
   end subroutine locate_present

   !> v <- v + a, interpolated from the nodes.
   pure subroutine add_field(n, rows, ld, xi, a, v)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: xi(ld, ndim), a(lanes, corners, ndim, n)
      real(dp), intent(inout) :: v(ld, ndim)
      integer :: b, s, l, k, d
      do b = 1, n
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            !$omp simd
            do l = 1, lanes
               do d = 1, ndim
                  block
                     real(dp) :: change
                     change = (a(l, 1, d, b) + xi(k + l, 1)*a(l, 2, d, b)) &
                              + xi(k + l, 2)*(a(l, 3, d, b) + xi(k + l, 1)*a(l, 4, d, b))
                     if (ndim > 2) change = change + xi(k + l, ndim)*((a(l, corners - 3, d, b) &
                                                                       + xi(k + l, 1)*a(l, corners - 2, d, b)) &
                                                                      + xi(k + l, 2)*(a(l, corners - 1, d, b) &
                                                                                      + xi(k + l, 1)*a(l, corners, d, b)))
                     v(k + l, d) = v(k + l, d) + change
                  end block
               end do
            end do
         end do
      end do
   end subroutine add_field

   !> H <- H + L, L being the gradient of an interpolated field, or where it `multiplies` H <- H + L (I + H).
   pure subroutine add_gradient(n, rows, ld, multiplies, xi, a, h)
      integer, intent(in) :: n, rows, ld
      logical, intent(in) :: multiplies
      real(dp), intent(in) :: xi(ld, ndim), a(lanes, corners, ndim, n)
      real(dp), intent(inout) :: h(ld, ndim, ndim)
      real(dp) :: g(lanes, ndim, ndim)
      integer :: b, s, l, k, i, j
      do b = 1, n
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            !$omp simd
            do l = 1, lanes
               do i = 1, ndim
                  g(l, i, 1) = a(l, 2, i, b) + xi(k + l, 2)*a(l, 4, i, b)
                  g(l, i, 2) = a(l, 3, i, b) + xi(k + l, 1)*a(l, 4, i, b)
                  if (ndim == 2) cycle
                  g(l, i, 1) = g(l, i, 1) + xi(k + l, ndim)*(a(l, corners - 2, i, b) + xi(k + l, 2)*a(l, corners, i, b))
                  g(l, i, 2) = g(l, i, 2) + xi(k + l, ndim)*(a(l, corners - 1, i, b) + xi(k + l, 1)*a(l, corners, i, b))
                  g(l, i, ndim) = (a(l, corners - 3, i, b) + xi(k + l, 1)*a(l, corners - 2, i, b)) &
                                  + xi(k + l, 2)*(a(l, corners - 1, i, b) + xi(k + l, 1)*a(l, corners, i, b))
               end do
            end do
            if (multiplies) then
               !$omp simd
               do l = 1, lanes
                  do j = 1, ndim
                     block
                        real(dp) :: old(ndim), product
                        do i = 1, ndim
                           old(i) = h(k + l, i, j)
                        end do
                        do i = 1, ndim
                           product = g(l, i, 1)*old(1) + g(l, i, 2)*old(2)
                           if (ndim > 2) product = product + g(l, i, ndim)*old(ndim)
                           h(k + l, i, j) = old(i) + (g(l, i, j) + product)
                        end do
                     end block
                  end do
               end do
            else
               !$omp simd
               do l = 1, lanes
                  do j = 1, ndim
                     do i = 1, ndim
                        h(k + l, i, j) = h(k + l, i, j) + g(l, i, j)
                     end do
                  end do
               end do
            end if
         end do
      end do
   end subroutine add_gradient

   !> Add the contributions to the masses at the corners (9): of a plane, and in space of the next one. Masses and momenta are
   !> products: as differences they would lose all digits at nodes of small mass, and so would their velocity.
   pure subroutine add_mass(n, rows, ld, xi, mass, contribution)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: xi(ld, ndim), mass(ld)
      real(dp), intent(inout) :: contribution(lanes, plane_corners, corners/plane_corners, n_sums, n)
      real(dp), dimension(lanes) :: m1, m2, m3, m4
      real(dp) :: m, left, right
      integer :: b, s, l, k, side
      do b = 1, n
         do side = 1, corners/plane_corners
            m1 = contribution(:, 1, side, of_mass, b)
            m2 = contribution(:, 2, side, of_mass, b)
            m3 = contribution(:, 3, side, of_mass, b)
            m4 = contribution(:, 4, side, of_mass, b)
            do s = 1, rows
               k = lanes*(rows*(b - 1) + s - 1)
               !$omp simd private(m, left, right)
               do l = 1, lanes
                  m = mass(k + l)
                  if (ndim > 2) m = m*abs((2 - side) - xi(k + l, ndim))
                  left = (1 - xi(k + l, 1))*m
                  right = xi(k + l, 1)*m
                  m1(l) = m1(l) + left*(1 - xi(k + l, 2))
                  m2(l) = m2(l) + right*(1 - xi(k + l, 2))
                  m3(l) = m3(l) + left*xi(k + l, 2)
                  m4(l) = m4(l) + right*xi(k + l, 2)
               end do
            end do
            contribution(:, 1, side, of_mass, b) = m1
            contribution(:, 2, side, of_mass, b) = m2
            contribution(:, 3, side, of_mass, b) = m3
            contribution(:, 4, side, of_mass, b) = m4
         end do
      end do
   end subroutine add_mass

   !> Add the contributions to the momenta at the corners, the right-hand side of (8).
   pure subroutine add_momentum(n, rows, ld, xi, mass, v, contribution)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: xi(ld, ndim), mass(ld), v(ld, ndim)
      real(dp), intent(inout) :: contribution(lanes, plane_corners, corners/plane_corners, n_sums, n)
      real(dp) :: sums(lanes, plane_corners, ndim)
      integer :: b, s, l, k, c, d, side
      do b = 1, n
         do side = 1, corners/plane_corners
            do d = 1, ndim
               do c = 1, plane_corners
                  !$omp simd
                  do l = 1, lanes
                     sums(l, c, d) = contribution(l, c, side, of_momentum + d - 1, b)
                  end do
               end do
            end do
            do s = 1, rows
               k = lanes*(rows*(b - 1) + s - 1)
               !$omp simd
               do l = 1, lanes
                  block
                     real(dp) :: m, left, right, w(plane_corners)
                     m = mass(k + l)
                     if (ndim > 2) m = m*abs((2 - side) - xi(k + l, ndim))
                     left = (1 - xi(k + l, 1))*m
                     right = xi(k + l, 1)*m
                     w(1) = left*(1 - xi(k + l, 2))
                     w(2) = right*(1 - xi(k + l, 2))
                     w(3) = left*xi(k + l, 2)
                     w(4) = right*xi(k + l, 2)
                     do d = 1, ndim
                        do c = 1, plane_corners
                           sums(l, c, d) = sums(l, c, d) + w(c)*v(k + l, d)
                        end do
                     end do
                  end block
               end do
            end do
            do d = 1, ndim
               do c = 1, plane_corners
                  !$omp simd
                  do l = 1, lanes
                     contribution(l, c, side, of_momentum + d - 1, b) = sums(l, c, d)
                  end do
               end do
            end do
         end do
      end do
   end subroutine add_momentum

   !> Add the mass matrices (6) of the particles to the matrices of the cells of a block.
   pure subroutine add_matrix(rows, ld, xi, mass, matrix)
      integer, intent(in) :: rows, ld
      real(dp), intent(in) :: xi(ld, ndim), mass(ld)
      real(dp), intent(inout) :: matrix(lanes, corners, corners)
      real(dp) :: shape(lanes, corners)
      integer :: s, l, k, c, d
      do s = 1, rows
         k = lanes*(s - 1)
         do c = 1, corners
            !$omp simd
            do l = 1, lanes
               shape(l, c) = merge(xi(k + l, 1), 1 - xi(k + l, 1), btest(c - 1, 0)) &
                             *merge(xi(k + l, 2), 1 - xi(k + l, 2), btest(c - 1, 1))
               if (ndim > 2) shape(l, c) = shape(l, c)*merge(xi(k + l, ndim), 1 - xi(k + l, ndim), btest(c - 1, ndim - 1))
            end do
         end do
         do c = 1, corners
            do d = 1, corners
               !$omp simd
               do l = 1, lanes
                  matrix(l, d, c) = matrix(l, d, c) + (mass(k + l)*shape(l, c))*shape(l, d)
               end do
            end do
         end do
      end do
   end subroutine add_matrix

   !> Volume times stress of linear elastic particles of one material: the components 11, 21, 12, 22.
   pure subroutine linear_forces(rows, ld, lambda, mu, volume, h, t)
      integer, intent(in) :: rows, ld
      real(dp), intent(in) :: lambda, mu, volume(ld), h(ld, ndim, ndim)
      real(dp), intent(out) :: t(lanes, ndim, ndim, rows)
      integer :: s, l, k, i, j
      do s = 1, rows
         k = lanes*(s - 1)
         !$omp simd
         do l = 1, lanes
            block
               real(dp) :: pressure
               pressure = h(k + l, 1, 1) + h(k + l, 2, 2)
               if (ndim > 2) pressure = pressure + h(k + l, ndim, ndim)
               pressure = lambda*pressure
               do j = 1, ndim
                  do i = 1, ndim
                     t(l, i, j, s) = volume(k + l)*(mu*(h(k + l, i, j) + h(k + l, j, i)))
                  end do
                  t(l, j, j, s) = volume(k + l)*(pressure + 2*mu*h(k + l, j, j))
               end do
            end block
         end do
      end do
   end subroutine linear_forces

   !> The same by a stiffness, in plane models of the columns (11, 22, 12).
   pure subroutine anisotropic_forces(rows, ld, c, volume, h, t)
      integer, intent(in) :: rows, ld
      real(dp), intent(in) :: c(n_voigt, n_voigt), volume(ld), h(ld, ndim, ndim)
      real(dp), intent(out) :: t(lanes, ndim*ndim, rows)
      real(dp) :: shear
      integer :: s, l, k
      if (ndim > 2) then
         call forces_of_solid(rows, ld, c, volume, h, t)
         return
      end if
      do s = 1, rows
         k = lanes*(s - 1)
         !$omp simd private(shear)
         do l = 1, lanes
            shear = h(k + l, 1, 2) + h(k + l, 2, 1)
            t(l, 1, s) = volume(k + l)*(c(1, 1)*h(k + l, 1, 1) + c(1, 2)*h(k + l, 2, 2) + c(1, 3)*shear)
            t(l, 2, s) = volume(k + l)*(c(1, 3)*h(k + l, 1, 1) + c(2, 3)*h(k + l, 2, 2) + c(3, 3)*shear)
            t(l, 3, s) = t(l, 2, s)
            t(l, 4, s) = volume(k + l)*(c(1, 2)*h(k + l, 1, 1) + c(2, 2)*h(k + l, 2, 2) + c(2, 3)*shear)
         end do
      end do
   end subroutine anisotropic_forces

   !> The same of solids.
   pure subroutine forces_of_solid(rows, ld, c, volume, h, t)
      integer, intent(in) :: rows, ld
      real(dp), intent(in) :: c(n_voigt, n_voigt), volume(ld), h(ld, ndim, ndim)
      real(dp), intent(out) :: t(lanes, ndim, ndim, rows)
      real(dp) :: strain(lanes, n_voigt), stress(lanes)
      integer :: s, k, i, j
      do s = 1, rows
         k = lanes*(s - 1)
         strain = 0
         do j = 1, ndim
            do i = 1, ndim
               strain(:, voigt(i, j)) = strain(:, voigt(i, j)) + h(k + 1:k + lanes, i, j)
            end do
         end do
         do j = 1, ndim
            do i = 1, j
               stress = volume(k + 1:k + lanes)*matmul(strain, c(:, voigt(i, j)))
               t(:, i, j, s) = stress
               t(:, j, i, s) = stress
            end do
         end do
      end do
   end subroutine forces_of_solid

   !> Add to the moments for the internal forces (7): the sums of volume times stress, the same times the local coordinate across
   !> its direction and, in space, times the other one and the product of both; the second and third index are those of t in
   !> `linear_forces`. In space the components are done one by one, so that the sums stay in registers.
   pure subroutine add_stress(n, rows, ld, xi, t, moments)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: xi(ld, ndim), t(lanes, ndim, ndim, rows, n)
      real(dp), intent(inout) :: moments(lanes, ndim, ndim, n_across, n)
      integer, parameter :: together = merge(2, 1, ndim == 2) ! components
      real(dp) :: sums(lanes, together, ndim, n_across)
      integer :: b, s, l, k, d, j, m, first
      do b = 1, n
         do first = 0, ndim - 1, together
            do m = 1, n_across
               do j = 1, ndim
                  do d = 1, together
                     !$omp simd
                     do l = 1, lanes
                        sums(l, d, j, m) = moments(l, first + d, j, m, b)
                     end do
                  end do
               end do
            end do
            do s = 1, rows
               k = lanes*(rows*(b - 1) + s - 1)
               !$omp simd
               do l = 1, lanes
                  do j = 1, ndim
                     block
                        real(dp) :: factor(n_across)
                        factor(1) = 1
                        factor(2) = xi(k + l, merge(2, 1, j == 1))
                        if (ndim > 2) then
                           factor(n_across - 1) = xi(k + l, merge(2, ndim, j == ndim))
                           factor(n_across) = factor(2)*factor(n_across - 1)
                        end if
                        do d = 1, together
                           do m = 1, n_across
                              sums(l, d, j, m) = sums(l, d, j, m) + factor(m)*t(l, first + d, j, s, b)
                           end do
                        end do
                     end block
                  end do
               end do
            end do
            do m = 1, n_across
               do j = 1, ndim
                  do d = 1, together
                     !$omp simd
                     do l = 1, lanes
                        moments(l, first + d, j, m, b) = sums(l, d, j, m)
                     end do
                  end do
               end do
            end do
         end do
      end do
   end subroutine add_stress

   !> The contributions to the internal forces at the corners from the moments of `add_stress`.
   pure subroutine divergence(n, inverse_size, moments, contribution)
      integer, intent(in) :: n
      real(dp), intent(in) :: inverse_size(lanes, n), moments(lanes, ndim, ndim, n_across, n)
      integer :: c, j
      real(dp), intent(inout) :: contribution(lanes, corners, n_sums, n)
      integer, parameter :: on_side(corners, ndim) = reshape([((1 + mod(c - 1, 2**(j - 1)) + ishft(ishft(c - 1, -j), j - 1), &
                                                               c=1, corners), j=1, ndim)], [corners, ndim])
      real(dp), parameter :: outward(corners, ndim) = reshape([((merge(-1, 1, btest(c - 1, j - 1)), c=1, corners), j=1, ndim)], &
                                                             [corners, ndim])
      integer :: b, l, d, m
      do b = 1, n
         do d = 1, ndim
            !$omp simd
            do l = 1, lanes
               block
                  real(dp) :: side(n_across, ndim), force ! of the corners below and above across each direction
                  do j = 1, ndim
                     do m = 1, n_across
                        side(m, j) = inverse_size(l, b)*moments(l, d, j, m, b)
                     end do
                     if (ndim > 2) then
                        side(2, j) = side(2, j) - side(n_across, j)
                        side(1, j) = side(1, j) - side(n_across - 1, j)
                        side(n_across - 1, j) = side(n_across - 1, j) - side(n_across, j)
                     end if
                     side(1, j) = side(1, j) - side(2, j)
                  end do
                  do c = 1, corners
                     force = outward(c, 1)*side(on_side(c, 1), 1) + outward(c, 2)*side(on_side(c, 2), 2)
                     if (ndim > 2) force = force + outward(c, ndim)*side(on_side(c, ndim), ndim)
                     contribution(l, c, of_force + d - 1, b) = force
                  end do
               end block
            end do
         end do
      end do
   end subroutine divergence
end module hampm_particle_kernels
