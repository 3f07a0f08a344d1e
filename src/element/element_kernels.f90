!> The loops of `hampm_stencils`: change of momenta and internal forces with the motion of points, by lines of a stencil, and sums
!> at the nodes. See `hampm_element_operators`.
module hampm_element_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: lanes
   implicit none
   private
   public :: n_masses, n_moments, add_mass_line, add_stiffness_line, mass_by_lines, stiffness_by_lines, add_to_sum, &
             copy_points

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
