!> Bilinear shape functions of a cell, and biquadratic ones.
!>
!> Corners are numbered like the bits of (corner - 1): bit 0 set means the upper side in x, bit 1 the upper side in y.
!> In one direction the function of the lower corner is 1 - xi and that of the upper corner xi, with the local
!> coordinate xi = (x - lower) / size in [0, 1]; the functions of a corner multiply over the directions.
!>
!> A quadratic cell has nine nodes, at 0, 1/2 and 1 in each direction, numbered along x first. In one direction their functions are
!> the Lagrange polynomials of these places.
module hampm_basis
   use hampm_kinds, only: dp, ndim, corners
   implicit none
   private
   public :: shape_functions, shape_gradients, interpolate_gradient, hourglasses_of, n_hourglasses, hourglass_directions, &
             hourglass_functions, inside_cell, edge_margin, points_of_quadratic, quarter_of_point, corner_of_point, &
             quadratic_functions, quadratic_gradients, derivatives_along

   integer, parameter :: points_of_quadratic = 3**ndim  !! nodes of a quadratic cell
   ! A quadratic cell is stored as its quarters: each node is a corner of one of them, the first that has it
   integer :: i, j, k
   integer, parameter :: quarters(3) = [0, 0, 1], upper(3) = [0, 1, 1]  ! of the points along one direction
   integer, parameter :: quarter_of_point(points_of_quadratic) = &
                         [(((1 + quarters(i) + 2*quarters(j) + 4*quarters(k), i=1, 3), j=1, 3), k=1, 3**(ndim - 2))]
   integer, parameter :: corner_of_point(points_of_quadratic) = &
                         [(((1 + upper(i) + 2*upper(j) + 4*upper(k), i=1, 3), j=1, 3), k=1, 3**(ndim - 2))]

   integer, parameter :: n_hourglasses = corners - ndim - 1  !! mixed derivatives of a bilinear field, each direction once at most
   !> The directions of each: bits as those of a corner
   integer, parameter :: hourglass_directions(n_hourglasses) = pack([(i, i=0, corners - 1)], [(popcnt(i) > 1, i=0, corners - 1)])

   !> A particle closer to the edge of its cell than this (in cells) is mapped as if it stood at this distance. All
   !> corners of an occupied cell then have a mass above zero, so that no force meets a node without mass and none is
   !> lost. It is of the size of the rounding of the position itself.
   real(dp), parameter :: edge_margin = 1.0e-14_dp

contains

   !> Shape functions at the local coordinate `xi`.
   pure function shape_functions(xi) result(n)
      real(dp), intent(in) :: xi(ndim)      !! local coordinate [-], in [0, 1]; outside, the functions extrapolate
      real(dp) :: n(corners)
      integer :: d
      n(1) = 1 - xi(1)
      n(2) = xi(1)
      do d = 2, ndim
         n(2**(d - 1) + 1:2**d) = n(:2**(d - 1))*xi(d)
         n(:2**(d - 1)) = n(:2**(d - 1))*(1 - xi(d))
      end do
   end function shape_functions

   !> Gradients of the shape functions with respect to position.
   pure function shape_gradients(xi, inverse_size) result(gradient)
      real(dp), intent(in) :: xi(ndim)      !! local coordinate [-]
      real(dp), intent(in) :: inverse_size  !! 1 / size of the cell [1/m]
      real(dp) :: gradient(corners, ndim)   !! [1/m]
      real(dp) :: lower(ndim), upper(ndim)
      integer :: j, d
      do j = 1, ndim
         lower = 1 - xi
         upper = xi
         lower(j) = -inverse_size
         upper(j) = inverse_size
         gradient(1, j) = lower(1)
         gradient(2, j) = upper(1)
         do d = 2, ndim
            gradient(2**(d - 1) + 1:2**d, j) = gradient(:2**(d - 1), j)*upper(d)
            gradient(:2**(d - 1), j) = gradient(:2**(d - 1), j)*lower(d)
         end do
      end do
   end function shape_gradients

   !> Mixed derivatives at `xi`, times powers of the size of the cell, of a vector field given at the corners.
   pure function hourglasses_of(xi, at_corner) result(hourglasses)
      real(dp), intent(in) :: xi(ndim)                  !! local coordinate [-]
      real(dp), intent(in) :: at_corner(ndim, corners)
      real(dp) :: hourglasses(ndim, n_hourglasses), part(corners)
      integer :: k, c
      hourglasses = 0
      do k = 1, n_hourglasses
         part = hourglass_functions(k, xi)
         do c = corners, 1, -1
            hourglasses(:, k) = hourglasses(:, k) + part(c)*at_corner(:, c)
         end do
      end do
   end function hourglasses_of

   !> The mixed derivative of this number of each function of a cell, times a power of its size.
   pure function hourglass_functions(number, xi) result(part)
      integer, intent(in) :: number
      real(dp), intent(in) :: xi(ndim)                  !! local coordinate [-]
      real(dp) :: part(corners)
      integer :: c, d
      part = 1
      do c = 1, corners
         do d = 1, ndim
            if (btest(hourglass_directions(number), d - 1)) then
               part(c) = part(c)*merge(1.0_dp, -1.0_dp, btest(c - 1, d - 1))
            else
               part(c) = part(c)*merge(xi(d), 1 - xi(d), btest(c - 1, d - 1))
            end if
         end do
      end do
   end function hourglass_functions

   !> Gradient at `xi`, times the size of the cell, of a vector field given at the corners: component d, direction j.
   pure function interpolate_gradient(xi, at_corner) result(gradient)
      real(dp), intent(in) :: xi(ndim)                  !! local coordinate [-]
      real(dp), intent(in) :: at_corner(ndim, corners)
      real(dp) :: gradient(ndim, ndim)
      real(dp) :: hourglass
      real(dp) :: slopes(corners, ndim)
      integer :: d
      if (ndim > 2) then
         slopes = shape_gradients(xi, 1.0_dp)
         gradient = matmul(at_corner, slopes)
         return
      end if
      do d = 1, ndim
         hourglass = (at_corner(d, 4) - at_corner(d, 3)) - (at_corner(d, 2) - at_corner(d, 1))
         gradient(d, 1) = (at_corner(d, 2) - at_corner(d, 1)) + xi(2)*hourglass
         gradient(d, 2) = (at_corner(d, 3) - at_corner(d, 1)) + xi(1)*hourglass
      end do
   end function interpolate_gradient

   !> Biquadratic functions at the local coordinate `xi`.
   pure function quadratic_functions(xi) result(n)
      real(dp), intent(in) :: xi(ndim)      !! local coordinate [-], in [0, 1]; outside, the functions extrapolate
      real(dp) :: n(points_of_quadratic)
      real(dp) :: along(3, ndim)
      integer :: d
      do d = 1, ndim
         along(:, d) = lagrange(xi(d))
      end do
      n = products(along)
   end function quadratic_functions

   !> Gradients of the biquadratic functions with respect to position.
   pure function quadratic_gradients(xi, inverse_size) result(gradient)
      real(dp), intent(in) :: xi(ndim)      !! local coordinate [-]
      real(dp), intent(in) :: inverse_size  !! 1 / size of the cell [1/m]
      real(dp) :: gradient(points_of_quadratic, ndim)   !! [1/m]
      real(dp) :: along(3, ndim)
      integer :: j, d
      do j = 1, ndim
         do d = 1, ndim
            if (d == j) then
               along(:, d) = lagrange_slopes(xi(d))
            else
               along(:, d) = lagrange(xi(d))
            end if
         end do
         gradient(:, j) = products(along)*inverse_size
      end do
   end function quadratic_gradients

   !> The k-th derivatives of the functions of a cell along x or y, times the k-th power of its size.
   pure function derivatives_along(n_functions, direction, k, xi) result(n)
      integer, intent(in) :: n_functions    !! of a bilinear or a biquadratic cell
      integer, intent(in) :: direction, k   !! k from 1 to the order of the functions
      real(dp), intent(in) :: xi(ndim)      !! local coordinate [-]
      real(dp) :: n(n_functions)
      real(dp), allocatable :: along(:), across(:)
      associate (x => xi(direction), y => xi(3 - direction))
         if (n_functions == corners) then
            along = [-1.0_dp, 1.0_dp]
            across = [1 - y, y]
         else
            along = merge(lagrange_slopes(x), [4.0_dp, -8.0_dp, 4.0_dp], k == 1)
            across = lagrange(y)
         end if
      end associate
      if (direction == 1) n = reshape(spread(along, 2, size(across))*spread(across, 1, size(along)), [n_functions])
      if (direction == 2) n = reshape(spread(across, 2, size(along))*spread(along, 1, size(across)), [n_functions])
   end function derivatives_along

   !> The Lagrange polynomials of 0, 1/2 and 1.
   pure function lagrange(x) result(n)
      real(dp), intent(in) :: x
      real(dp) :: n(3)
      n = [(1 - x)*(1 - 2*x), 4*x*(1 - x), x*(2*x - 1)]
   end function lagrange

   !> Their derivatives.
   pure function lagrange_slopes(x) result(slope)
      real(dp), intent(in) :: x
      real(dp) :: slope(3)
      slope = [4*x - 3, 4 - 8*x, 4*x - 1]
   end function lagrange_slopes

   !> Products of functions along each direction, those along x one after the other.
   pure function products(along) result(n)
      real(dp), intent(in) :: along(3, ndim)
      real(dp) :: n(points_of_quadratic)
      integer :: d, k
      n(:3) = along(:, 1)
      do d = 2, ndim
         do k = 3, 1, -1
            n((k - 1)*3**(d - 1) + 1:k*3**(d - 1)) = n(:3**(d - 1))*along(k, d)
         end do
      end do
   end function products

   !> The local coordinate kept `edge_margin` away from the edges of the cell.
   pure function inside_cell(xi) result(inside)
      real(dp), intent(in) :: xi(ndim)
      real(dp) :: inside(ndim)
      inside = min(max(xi, edge_margin), 1 - edge_margin)
   end function inside_cell
end module hampm_basis
