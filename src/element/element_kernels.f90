!> The loops of `hampm_stencils` and `hampm_mean_force`: change of momenta and internal forces with the motion of points, by lines
!> of a stencil, and by mass matrices and moments of the cells of a block, side by side in `lanes` as in `hampm_particle_kernels`;
!> and sums at the nodes. See `hampm_element_operators`.
module hampm_element_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: lanes, of_force, n_sums
   use hampm_particle_kernels, only: divergence, n_across
   implicit none
   private
   public :: n_masses, n_moments, add_mass_line, add_stiffness_line, mass_by_lines, stiffness_by_lines, apply_mass, &
             isotropic_stress, anisotropic_stress, add_divergence, add_to_sum, copy_points

   integer, parameter :: n_masses = corners*(corners + 1)/2   !! of a symmetric mass matrix: 11 21 31 41 22 32 42 33 43 44
   integer, parameter :: n_moments = 1 + ndim + ndim*(ndim + 1)/2 !! of the volume: 1, xi, eta, xi**2, xi eta, eta**2, or in space

contains

   !> Add the effect of a kick to the momenta of consecutive points by a line of their stencil (`hampm_stencils`).
   pure subroutine add_mass_line(n, dt, c, a, momentum)
      integer, intent(in) :: n                          !! components of the points
      real(dp), intent(in) :: dt                        !! [s]
      real(dp), intent(in) :: c(3)                      !! [kg]
      real(dp), intent(in) :: a(n + 2*ndim)             !! accelerations, from the point before the middle of the first on [m/s2]
      real(dp), intent(inout) :: momentum(n)
      integer :: i
      !$omp simd
      do i = 1, n
         momentum(i) = momentum(i) + dt*((c(1)*a(i) + c(2)*a(i + ndim)) + c(3)*a(i + 2*ndim))
      end do
   end subroutine add_mass_line

   !> Add the change by straining to the forces at consecutive points by a line of their stencil. A component of a force meets the
   !> components of the line up to 2 `ndim` - 1 places before and behind its own in the middle: some of these belong to other
   !> points, with zero coefficients.
   pure subroutine add_stiffness_line(n, dt, c, v, force)
      integer, intent(in) :: n                          !! points
      real(dp), intent(in) :: dt                        !! [s]
      real(dp), intent(in) :: c(ndim, ndim, 3)          !! minus the stiffness [N/m]
      integer, parameter :: beside = 2*ndim - 1, period = lanes*merge(1, ndim, ndim == 2) !! of components in vectors
      real(dp), intent(in) :: v(ndim*n + 2*beside)      !! velocities, from `beside` places before the middle of the first on [m/s]
      real(dp), intent(inout) :: force(ndim*n)
      real(dp) :: s(period, 2*beside + 1)
      integer :: i, l, d, k
      s = 0
      do d = 1, ndim
         do k = 1, 3
            s(d, ndim*k - d + 1:ndim*(k + 1) - d) = c(d, :, k)
         end do
      end do
      do l = ndim + 1, period
         s(l, :) = s(l - ndim, :)
      end do
      do i = 0, ndim*n - period, period
         !$omp simd
         do l = 1, period
            block
               real(dp) :: change
               if (ndim == 2) then
                  change = ((s(l, 1)*v(i + l) + s(l, 2)*v(i + l + 1)) + (s(l, 3)*v(i + l + 2) + s(l, 4)*v(i + l + 3))) &
                           + ((s(l, 5)*v(i + l + 4) + s(l, 6)*v(i + l + 5)) + s(l, 7)*v(i + l + 6))
               else
                  change = s(l, 1)*v(i + l)
                  do k = 2, 2*beside + 1
                     change = change + s(l, k)*v(i + l + k - 1)
                  end do
               end if
               force(i + l) = force(i + l) + dt*change
            end block
         end do
      end do
      do i = i, ndim*n - 1, ndim                        ! the points that are left
         force(i + 1:i + ndim) = force(i + 1:i + ndim) + dt*stiffness_by_lines(1, [2], c, 0, v(i + beside - ndim + 1:))
      end do
   end subroutine add_stiffness_line

   !> Change of the momentum of one point by the lines of its stencil, per time.
   pure function mass_by_lines(lines, middle, c, i, a) result(change)
      integer, intent(in) :: lines
      integer, intent(in) :: middle(lines)
      real(dp), intent(in) :: c(-1:1, lines)            !! [kg]
      integer, intent(in) :: i                          !! point
      real(dp), intent(in) :: a(ndim, *)
      real(dp) :: change(ndim)
      integer :: k
      change = 0
      do k = 1, lines
         associate (m => i + middle(k))
            change = change + ((c(-1, k)*a(:, m - 1) + c(0, k)*a(:, m)) + c(1, k)*a(:, m + 1))
         end associate
      end do
   end function mass_by_lines

   !> Change of the force at one point by the lines of its stencil, per time.
   pure function stiffness_by_lines(lines, middle, c, i, v) result(change)
      integer, intent(in) :: lines
      integer, intent(in) :: middle(lines)
      real(dp), intent(in) :: c(ndim, ndim, -1:1, lines)  !! minus the stiffness [N/m]
      integer, intent(in) :: i                          !! point
      real(dp), intent(in) :: v(ndim, *)
      real(dp) :: change(ndim)
      integer :: k
      change = 0
      do k = 1, lines
         associate (m => i + middle(k))
            change = change + (((c(:, 1, -1, k)*v(1, m - 1) + c(:, 2, -1, k)*v(2, m - 1)) &
                                + (c(:, 1, 0, k)*v(1, m) + c(:, 2, 0, k)*v(2, m))) &
                               + (c(:, 1, 1, k)*v(1, m + 1) + c(:, 2, 1, k)*v(2, m + 1)))
            if (ndim > 2) change = change + ((c(:, ndim, -1, k)*v(ndim, m - 1) + c(:, ndim, 0, k)*v(ndim, m)) &
                                             + c(:, ndim, 1, k)*v(ndim, m + 1))
         end associate
      end do
   end function stiffness_by_lines

   !> Add a kick of the particles to the momenta, p_i <- p_i + sum_j M_ij dv_j, dv being the polynomials `a` in the cells.
   pure subroutine apply_mass(a, masses, sums)
      real(dp), intent(in) :: a(lanes, corners, ndim), masses(lanes, n_masses)
      real(dp), intent(inout) :: sums(lanes, corners, ndim)
      real(dp) :: v1, v2, v3, v4
      integer :: l, d
      do d = 1, ndim
         !$omp simd private(v1, v2, v3, v4)
         do l = 1, lanes
            v1 = a(l, 1, d)
            v2 = v1 + a(l, 2, d)
            v3 = v1 + a(l, 3, d)
            v4 = v3 + (a(l, 2, d) + a(l, 4, d))
            sums(l, 1, d) = sums(l, 1, d) + (masses(l, 1)*v1 + masses(l, 2)*v2 + (masses(l, 3)*v3 + masses(l, 4)*v4))
            sums(l, 2, d) = sums(l, 2, d) + (masses(l, 2)*v1 + masses(l, 5)*v2 + (masses(l, 6)*v3 + masses(l, 7)*v4))
            sums(l, 3, d) = sums(l, 3, d) + (masses(l, 3)*v1 + masses(l, 6)*v2 + (masses(l, 8)*v3 + masses(l, 9)*v4))
            sums(l, 4, d) = sums(l, 4, d) + (masses(l, 4)*v1 + masses(l, 7)*v2 + (masses(l, 9)*v3 + masses(l, 10)*v4))
         end do
      end do
   end subroutine apply_mass

   !> Sums of V times stress, and of the same times the local coordinate across its direction, of linear elastic particles of one
   !> material, for the internal forces (7) (`add_divergence`). L = grad of a field is linear in the local coordinates: these sums
   !> need only the moments of V.
   pure subroutine isotropic_stress(lambda, mu, a, moments, integrals)
      real(dp), intent(in) :: lambda, mu                !! [Pa]
      real(dp), intent(in) :: a(lanes, corners, ndim)   !! the field as by `take_corners`, over the size of the cell
      real(dp), intent(in) :: moments(lanes, n_moments) !! [m3]
      real(dp), intent(out) :: integrals(lanes, ndim*ndim, n_across)
      real(dp) :: l11, l21, l12, l22
      integer :: l
      !$omp simd private(l11, l21, l12, l22)
      do l = 1, lanes
         l11 = a(l, 2, 1)*moments(l, 1) + a(l, 4, 1)*moments(l, 3)
         l21 = a(l, 2, 2)*moments(l, 1) + a(l, 4, 2)*moments(l, 3)
         l12 = a(l, 3, 1)*moments(l, 1) + a(l, 4, 1)*moments(l, 2)
         l22 = a(l, 3, 2)*moments(l, 1) + a(l, 4, 2)*moments(l, 2)
         integrals(l, 1, 1) = (lambda + 2*mu)*l11 + lambda*l22
         integrals(l, 2, 1) = mu*(l12 + l21)
         integrals(l, 3, 1) = integrals(l, 2, 1)
         integrals(l, 4, 1) = (lambda + 2*mu)*l22 + lambda*l11
         ! times eta
         l11 = a(l, 2, 1)*moments(l, 3) + a(l, 4, 1)*moments(l, 6)
         l21 = a(l, 2, 2)*moments(l, 3) + a(l, 4, 2)*moments(l, 6)
         l12 = a(l, 3, 1)*moments(l, 3) + a(l, 4, 1)*moments(l, 5)
         l22 = a(l, 3, 2)*moments(l, 3) + a(l, 4, 2)*moments(l, 5)
         integrals(l, 1, 2) = (lambda + 2*mu)*l11 + lambda*l22
         integrals(l, 2, 2) = mu*(l12 + l21)
         ! times xi
         l11 = a(l, 2, 1)*moments(l, 2) + a(l, 4, 1)*moments(l, 5)
         l21 = a(l, 2, 2)*moments(l, 2) + a(l, 4, 2)*moments(l, 5)
         l12 = a(l, 3, 1)*moments(l, 2) + a(l, 4, 1)*moments(l, 4)
         l22 = a(l, 3, 2)*moments(l, 2) + a(l, 4, 2)*moments(l, 4)
         integrals(l, 3, 2) = mu*(l12 + l21)
         integrals(l, 4, 2) = (lambda + 2*mu)*l22 + lambda*l11
      end do
   end subroutine isotropic_stress

   !> The same by a stiffness of the columns (11, 22, 12).
   pure subroutine anisotropic_stress(c, a, moments, integrals)
      real(dp), intent(in) :: c(3, 3)                   !! [Pa]
      real(dp), intent(in) :: a(lanes, corners, ndim)   !! the field as by `take_corners`, over the size of the cell
      real(dp), intent(in) :: moments(lanes, n_moments) !! [m3]
      real(dp), intent(out) :: integrals(lanes, ndim*ndim, n_across)
      integer, parameter :: with(3, 3) = reshape([1, 3, 2, 3, 6, 5, 2, 5, 4], [3, 3]) !! moments of 1, eta, xi with 1, eta and xi
      real(dp) :: stress(lanes, 3, 3)
      real(dp) :: l11, l22, shear
      integer :: l, k
      do k = 1, 3                                       ! times 1, eta and xi
         !$omp simd private(l11, l22, shear)
         do l = 1, lanes
            l11 = a(l, 2, 1)*moments(l, with(1, k)) + a(l, 4, 1)*moments(l, with(2, k))
            l22 = a(l, 3, 2)*moments(l, with(1, k)) + a(l, 4, 2)*moments(l, with(3, k))
            shear = a(l, 2, 2)*moments(l, with(1, k)) + a(l, 4, 2)*moments(l, with(2, k)) &
                    + (a(l, 3, 1)*moments(l, with(1, k)) + a(l, 4, 1)*moments(l, with(3, k)))
            stress(l, 1, k) = c(1, 1)*l11 + c(1, 2)*l22 + c(1, 3)*shear
            stress(l, 2, k) = c(1, 3)*l11 + c(2, 3)*l22 + c(3, 3)*shear
            stress(l, 3, k) = c(1, 2)*l11 + c(2, 2)*l22 + c(2, 3)*shear
         end do
      end do
      integrals(:, :4, 1) = stress(:, [1, 2, 2, 3], 1)
      integrals(:, :2, 2) = stress(:, :2, 2)
      integrals(:, 3:4, 2) = stress(:, 2:, 3)
   end subroutine anisotropic_stress

   !> Add the internal forces of the sums of V times stress, and of the same times the local coordinate across its direction.
   pure subroutine add_divergence(inverse_size, integrals, sums)
      real(dp), intent(in) :: inverse_size(lanes)       !! [1/m]
      real(dp), intent(in) :: integrals(lanes, ndim*ndim, n_across)
      real(dp), intent(inout) :: sums(lanes, corners, ndim)
      real(dp) :: change(lanes, corners, n_sums)
      integer :: l, c, d
      call divergence(1, inverse_size, integrals, change)
      do d = 1, ndim
         do c = 1, corners
            !$omp simd
            do l = 1, lanes
               sums(l, c, d) = sums(l, c, d) + change(l, c, of_force + d - 1)
            end do
         end do
      end do
   end subroutine add_divergence

   !> Add a factor times a nodal field to a sum at some points.
   pure subroutine add_to_sum(factor, n, points, field, total)
      real(dp), intent(in) :: factor
      integer, intent(in) :: n, points(n)
      real(dp), intent(in) :: field(ndim, *)            !! by point
      real(dp), intent(inout) :: total(ndim, *)
      integer :: k
      do k = 1, n
         total(:, points(k)) = total(:, points(k)) + factor*field(:, points(k))
      end do
   end subroutine add_to_sum

   !> Copy a nodal field at some points.
   pure subroutine copy_points(n, points, from, to)
      integer, intent(in) :: n, points(n)
      real(dp), intent(in) :: from(ndim, *)             !! by point
      real(dp), intent(inout) :: to(ndim, *)
      integer :: k
      do k = 1, n
         to(:, points(k)) = from(:, points(k))
      end do
   end subroutine copy_points
end module hampm_element_kernels
