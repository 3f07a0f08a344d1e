!> What a pass does with the particles of a batch: blocks of `lanes` cells side by side, one block after the other, each in as many
!> rows of one particle of each cell. The loop over the lanes is the vector loop: it loads and stores with unit stride, and what
!> is summed over the particles of a cell stays in registers. Each procedure does one thing with all blocks of a batch; the
!> pass calls those that it needs.
!>
!> The k-th place of a batch is in lane mod(k - 1, lanes) + 1. Arrays of particles come from the first place on, with
!> their leading dimension. Nodal fields come as the polynomials a1 + a2 xi + a3 eta + a4 xi eta of the lanes' cells, by block.
module hampm_particle_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: edge_margin
   use hampm_cell_blocks, only: lanes, of_mass, of_momentum, of_force, n_sums
   use hampm_tensors, only: voigt, n_voigt
   implicit none
   private
   public :: most_rows, clear, take_corners, locate_reference, locate_present, add_field, add_gradient, add_gradient_product, &
             add_mass, add_momentum, add_matrix, linear_forces, anisotropic_forces, add_stress, divergence

   integer, parameter :: most_rows = 16          !! that are done at a time

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
      logical, intent(in) :: in_row(n)                  !! whether the points of a block are two rows, each numbered on
      real(dp), intent(out) :: a(lanes, corners, ndim, n)
      integer :: b
      do b = 1, n
         if (in_row(b)) then
            call take_rows(factor(1, b), field(1, nodes(1, 1, b)), field(1, nodes(3, 1, b)), a(1, 1, 1, b))
         else
            call take_points(factor(1, b), field, nodes(1, 1, b), a(1, 1, 1, b))
         end if
      end do
   end subroutine take_corners

   !> The polynomials in the cells of a block, from the points at its lower and at its upper edge.
   pure subroutine take_rows(factor, lower, upper, a)
      real(dp), intent(in) :: factor(lanes), lower(ndim, lanes + 1), upper(ndim, lanes + 1)
      real(dp), intent(out) :: a(lanes, corners, ndim)
      real(dp) :: f1, f2, f3, f4
      integer :: l, d
      do d = 1, ndim
         !$omp simd private(f1, f2, f3, f4)
         do l = 1, lanes
            f1 = factor(l)*lower(d, l)
            f2 = factor(l)*lower(d, l + 1)
            f3 = factor(l)*upper(d, l)
            f4 = factor(l)*upper(d, l + 1)
            a(l, 1, d) = f1
            a(l, 2, d) = f2 - f1
            a(l, 3, d) = f3 - f1
            a(l, 4, d) = (f4 - f3) - (f2 - f1)
         end do
      end do
   end subroutine take_rows

   !> The polynomials in the cells of a block, from any points.
   pure subroutine take_points(factor, field, nodes, a)
      real(dp), intent(in) :: factor(lanes)
      real(dp), intent(in) :: field(ndim, *)
      integer, intent(in) :: nodes(corners, lanes)
      real(dp), intent(out) :: a(lanes, corners, ndim)
      real(dp) :: f1, f2, f3, f4
      integer :: l, c, d
      !GCC$ novector
      do l = 1, lanes
         do c = 1, corners
            a(l, c, 1) = field(1, nodes(c, l))
            a(l, c, 2) = field(2, nodes(c, l))
         end do
      end do
      do d = 1, ndim
         !$omp simd private(f1, f2, f3, f4)
         do l = 1, lanes
            f1 = factor(l)*a(l, 1, d)
            f2 = factor(l)*a(l, 2, d)
            f3 = factor(l)*a(l, 3, d)
            f4 = factor(l)*a(l, 4, d)
            a(l, 1, d) = f1
            a(l, 2, d) = f2 - f1
            a(l, 3, d) = f3 - f1
            a(l, 4, d) = (f4 - f3) - (f2 - f1)
         end do
      end do
   end subroutine take_points

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

   !> Local coordinates of the present positions, kept inside the cells, and by how much that has changed them: add the sums by
   !> lane, in cells. At most `rows` times 4 `edge_margin` is rounding; more, or what is not a number, tells that a particle has
   !> left.
   pure subroutine locate_present(n, rows, ld, lower, inverse_size, x, u, xi, beyond)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: lower(lanes, ndim, n), inverse_size(lanes, n), x(ld, ndim), u(ld, ndim)
      real(dp), intent(inout) :: xi(ld, ndim)
      real(dp), intent(inout) :: beyond(lanes, n)
      real(dp) :: total(lanes), free1, free2, inside1, inside2
      integer :: b, s, l, k
      do b = 1, n
         total = beyond(:, b)
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            !$omp simd private(free1, free2, inside1, inside2)
            do l = 1, lanes
               free1 = ((x(k + l, 1) - lower(l, 1, b)) + u(k + l, 1))*inverse_size(l, b)
               free2 = ((x(k + l, 2) - lower(l, 2, b)) + u(k + l, 2))*inverse_size(l, b)
               inside1 = min(max(free1, edge_margin), 1 - edge_margin)
               inside2 = min(max(free2, edge_margin), 1 - edge_margin)
               xi(k + l, 1) = inside1
               xi(k + l, 2) = inside2
               total(l) = total(l) + (abs(free1 - inside1) + abs(free2 - inside2))
            end do
         end do
         beyond(:, b) = total
      end do
   end subroutine locate_present

   !> v <- v + a: what is interpolated from the nodes.
   pure subroutine add_field(n, rows, ld, xi, a, v)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: xi(ld, ndim), a(lanes, corners, ndim, n)
      real(dp), intent(inout) :: v(ld, ndim)
      integer :: b, s, l, k
      do b = 1, n
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            !$omp simd
            do l = 1, lanes
               v(k + l, 1) = v(k + l, 1) + ((a(l, 1, 1, b) + xi(k + l, 1)*a(l, 2, 1, b)) &
                                            + xi(k + l, 2)*(a(l, 3, 1, b) + xi(k + l, 1)*a(l, 4, 1, b)))
               v(k + l, 2) = v(k + l, 2) + ((a(l, 1, 2, b) + xi(k + l, 1)*a(l, 2, 2, b)) &
                                            + xi(k + l, 2)*(a(l, 3, 2, b) + xi(k + l, 1)*a(l, 4, 2, b)))
            end do
         end do
      end do
   end subroutine add_field

   !> H <- H + L, L being the gradient of what is interpolated from the nodes.
   pure subroutine add_gradient(n, rows, ld, xi, a, h)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: xi(ld, ndim), a(lanes, corners, ndim, n)
      real(dp), intent(inout) :: h(ld, ndim, ndim)
      integer :: b, s, l, k, d
      do b = 1, n
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            do d = 1, ndim
               !$omp simd
               do l = 1, lanes
                  h(k + l, d, 1) = h(k + l, d, 1) + (a(l, 2, d, b) + xi(k + l, 2)*a(l, 4, d, b))
                  h(k + l, d, 2) = h(k + l, d, 2) + (a(l, 3, d, b) + xi(k + l, 1)*a(l, 4, d, b))
               end do
            end do
         end do
      end do
   end subroutine add_gradient

   !> H <- H + L (I + H), L as in `add_gradient`.
   pure subroutine add_gradient_product(n, rows, ld, xi, a, h)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: xi(ld, ndim), a(lanes, corners, ndim, n)
      real(dp), intent(inout) :: h(ld, ndim, ndim)
      real(dp) :: l11, l12, l21, l22, h11, h12, h21, h22
      integer :: b, s, l, k
      do b = 1, n
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            !$omp simd private(l11, l12, l21, l22, h11, h12, h21, h22)
            do l = 1, lanes
               l11 = a(l, 2, 1, b) + xi(k + l, 2)*a(l, 4, 1, b)
               l12 = a(l, 3, 1, b) + xi(k + l, 1)*a(l, 4, 1, b)
               l21 = a(l, 2, 2, b) + xi(k + l, 2)*a(l, 4, 2, b)
               l22 = a(l, 3, 2, b) + xi(k + l, 1)*a(l, 4, 2, b)
               h11 = h(k + l, 1, 1)
               h21 = h(k + l, 2, 1)
               h12 = h(k + l, 1, 2)
               h22 = h(k + l, 2, 2)
               h(k + l, 1, 1) = h11 + (l11 + (l11*h11 + l12*h21))
               h(k + l, 2, 1) = h21 + (l21 + (l21*h11 + l22*h21))
               h(k + l, 1, 2) = h12 + (l12 + (l11*h12 + l12*h22))
               h(k + l, 2, 2) = h22 + (l22 + (l21*h12 + l22*h22))
            end do
         end do
      end do
   end subroutine add_gradient_product

   !> Add the contributions to the masses at the corners (9). Here and in the momenta each is a product: as differences they would
   !> lose all digits at nodes whose mass is small, and the velocity of these with them.
   pure subroutine add_mass(n, rows, ld, xi, mass, contribution)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: xi(ld, ndim), mass(ld)
      real(dp), intent(inout) :: contribution(lanes, corners, n_sums, n)
      real(dp), dimension(lanes) :: m1, m2, m3, m4
      real(dp) :: left, right
      integer :: b, s, l, k
      do b = 1, n
         m1 = contribution(:, 1, of_mass, b)
         m2 = contribution(:, 2, of_mass, b)
         m3 = contribution(:, 3, of_mass, b)
         m4 = contribution(:, 4, of_mass, b)
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            !$omp simd private(left, right)
            do l = 1, lanes
               left = (1 - xi(k + l, 1))*mass(k + l)
               right = xi(k + l, 1)*mass(k + l)
               m1(l) = m1(l) + left*(1 - xi(k + l, 2))
               m2(l) = m2(l) + right*(1 - xi(k + l, 2))
               m3(l) = m3(l) + left*xi(k + l, 2)
               m4(l) = m4(l) + right*xi(k + l, 2)
            end do
         end do
         contribution(:, 1, of_mass, b) = m1
         contribution(:, 2, of_mass, b) = m2
         contribution(:, 3, of_mass, b) = m3
         contribution(:, 4, of_mass, b) = m4
      end do
   end subroutine add_mass

   !> Add the contributions to the momenta at the corners, the right-hand side of (8).
   pure subroutine add_momentum(n, rows, ld, xi, mass, v, contribution)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: xi(ld, ndim), mass(ld), v(ld, ndim)
      real(dp), intent(inout) :: contribution(lanes, corners, n_sums, n)
      real(dp), dimension(lanes) :: p1, p2, p3, p4, q1, q2, q3, q4
      real(dp) :: left, right, m1, m2, m3, m4
      integer :: b, s, l, k
      do b = 1, n
         p1 = contribution(:, 1, of_momentum, b)
         p2 = contribution(:, 2, of_momentum, b)
         p3 = contribution(:, 3, of_momentum, b)
         p4 = contribution(:, 4, of_momentum, b)
         q1 = contribution(:, 1, of_momentum + 1, b)
         q2 = contribution(:, 2, of_momentum + 1, b)
         q3 = contribution(:, 3, of_momentum + 1, b)
         q4 = contribution(:, 4, of_momentum + 1, b)
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            !$omp simd private(left, right, m1, m2, m3, m4)
            do l = 1, lanes
               left = (1 - xi(k + l, 1))*mass(k + l)
               right = xi(k + l, 1)*mass(k + l)
               m1 = left*(1 - xi(k + l, 2))
               m2 = right*(1 - xi(k + l, 2))
               m3 = left*xi(k + l, 2)
               m4 = right*xi(k + l, 2)
               p1(l) = p1(l) + m1*v(k + l, 1)
               p2(l) = p2(l) + m2*v(k + l, 1)
               p3(l) = p3(l) + m3*v(k + l, 1)
               p4(l) = p4(l) + m4*v(k + l, 1)
               q1(l) = q1(l) + m1*v(k + l, 2)
               q2(l) = q2(l) + m2*v(k + l, 2)
               q3(l) = q3(l) + m3*v(k + l, 2)
               q4(l) = q4(l) + m4*v(k + l, 2)
            end do
         end do
         contribution(:, 1, of_momentum, b) = p1
         contribution(:, 2, of_momentum, b) = p2
         contribution(:, 3, of_momentum, b) = p3
         contribution(:, 4, of_momentum, b) = p4
         contribution(:, 1, of_momentum + 1, b) = q1
         contribution(:, 2, of_momentum + 1, b) = q2
         contribution(:, 3, of_momentum + 1, b) = q3
         contribution(:, 4, of_momentum + 1, b) = q4
      end do
   end subroutine add_momentum

   !> Add the mass matrices (6) of the particles to those of the cells of a block.
   pure subroutine add_matrix(rows, ld, xi, mass, matrix)
      integer, intent(in) :: rows, ld
      real(dp), intent(in) :: xi(ld, ndim), mass(ld)
      real(dp), intent(inout) :: matrix(lanes, corners, corners)
      real(dp) :: shape(lanes, corners)
      integer :: s, l, k, c, d
      do s = 1, rows
         k = lanes*(s - 1)
         !$omp simd
         do l = 1, lanes
            shape(l, 1) = (1 - xi(k + l, 1))*(1 - xi(k + l, 2))
            shape(l, 2) = xi(k + l, 1)*(1 - xi(k + l, 2))
            shape(l, 3) = (1 - xi(k + l, 1))*xi(k + l, 2)
            shape(l, 4) = xi(k + l, 1)*xi(k + l, 2)
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
      real(dp), intent(out) :: t(lanes, ndim*ndim, rows)
      real(dp) :: pressure
      integer :: s, l, k
      do s = 1, rows
         k = lanes*(s - 1)
         !$omp simd private(pressure)
         do l = 1, lanes
            pressure = lambda*(h(k + l, 1, 1) + h(k + l, 2, 2))
            t(l, 1, s) = volume(k + l)*(pressure + 2*mu*h(k + l, 1, 1))
            t(l, 2, s) = volume(k + l)*(mu*(h(k + l, 1, 2) + h(k + l, 2, 1)))
            t(l, 3, s) = volume(k + l)*(mu*(h(k + l, 1, 2) + h(k + l, 2, 1)))
            t(l, 4, s) = volume(k + l)*(pressure + 2*mu*h(k + l, 2, 2))
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

   !> Add to the sums from which the internal forces (7) follow: those of volume times stress, and of the same times the local
   !> coordinate across its direction; the second index is that of t in `linear_forces`.
   pure subroutine add_stress(n, rows, ld, xi, t, total, moment)
      integer, intent(in) :: n, rows, ld
      real(dp), intent(in) :: xi(ld, ndim), t(lanes, ndim*ndim, rows, n)
      real(dp), intent(inout) :: total(lanes, ndim*ndim, n), moment(lanes, ndim*ndim, n)
      real(dp), dimension(lanes) :: t1, t2, t3, t4, m1, m2, m3, m4
      integer :: b, s, l, k
      do b = 1, n
         t1 = total(:, 1, b)
         t2 = total(:, 2, b)
         t3 = total(:, 3, b)
         t4 = total(:, 4, b)
         m1 = moment(:, 1, b)
         m2 = moment(:, 2, b)
         m3 = moment(:, 3, b)
         m4 = moment(:, 4, b)
         do s = 1, rows
            k = lanes*(rows*(b - 1) + s - 1)
            !$omp simd
            do l = 1, lanes
               t1(l) = t1(l) + t(l, 1, s, b)
               t2(l) = t2(l) + t(l, 2, s, b)
               t3(l) = t3(l) + t(l, 3, s, b)
               t4(l) = t4(l) + t(l, 4, s, b)
               m1(l) = m1(l) + xi(k + l, 2)*t(l, 1, s, b)
               m2(l) = m2(l) + xi(k + l, 2)*t(l, 2, s, b)
               m3(l) = m3(l) + xi(k + l, 1)*t(l, 3, s, b)
               m4(l) = m4(l) + xi(k + l, 1)*t(l, 4, s, b)
            end do
         end do
         total(:, 1, b) = t1
         total(:, 2, b) = t2
         total(:, 3, b) = t3
         total(:, 4, b) = t4
         moment(:, 1, b) = m1
         moment(:, 2, b) = m2
         moment(:, 3, b) = m3
         moment(:, 4, b) = m4
      end do
   end subroutine add_stress

   !> The contributions to the internal forces at the corners from the sums of `add_stress`.
   pure subroutine divergence(n, inverse_size, total, moment, contribution)
      integer, intent(in) :: n
      real(dp), intent(in) :: inverse_size(lanes, n), total(lanes, ndim, ndim, n), moment(lanes, ndim, ndim, n)
      real(dp), intent(inout) :: contribution(lanes, corners, n_sums, n)
      real(dp) :: x_lower, x_upper, y_lower, y_upper
      integer :: b, l, d
      do b = 1, n
         do d = 1, ndim
            !$omp simd private(x_lower, x_upper, y_lower, y_upper)
            do l = 1, lanes
               x_upper = inverse_size(l, b)*moment(l, d, 1, b)
               x_lower = inverse_size(l, b)*total(l, d, 1, b) - x_upper
               y_upper = inverse_size(l, b)*moment(l, d, 2, b)
               y_lower = inverse_size(l, b)*total(l, d, 2, b) - y_upper
               contribution(l, 1, of_force + d - 1, b) = x_lower + y_lower
               contribution(l, 2, of_force + d - 1, b) = y_upper - x_lower
               contribution(l, 3, of_force + d - 1, b) = x_upper - y_lower
               contribution(l, 4, of_force + d - 1, b) = -x_upper - y_upper
            end do
         end do
      end do
   end subroutine divergence
end module hampm_particle_kernels
