!> Bilinear shape functions of a cell.
!>
!> Corners are numbered like the bits of (corner - 1): bit 0 set means the upper side in x, bit 1 the upper side in y.
!> In one direction the function of the lower corner is 1 - xi and that of the upper corner xi, with the local
!> coordinate xi = (x - lower) / size in [0, 1]; the functions of a corner multiply over the directions.
module hampm_basis
   use hampm_kinds, only: dp, ndim, corners
   implicit none
   private
   public :: shape_functions, shape_gradients, interpolate, interpolate_gradient, add_shares, add_divergence, &
             inside_cell, edge_margin

   !> A particle closer to the edge of its cell than this (in cells) is mapped as if it stood at this distance. All
   !> corners of an occupied cell then have a mass above zero, so that no force meets a node without mass and none is
   !> lost. It is of the size of the rounding of the position itself.
   real(dp), parameter :: edge_margin = 1.0e-14_dp

contains

   !> Shape functions at the local coordinate `xi`.
   pure function shape_functions(xi) result(n)
      real(dp), intent(in) :: xi(ndim)      !! local coordinate [-], in [0, 1]; outside, the functions extrapolate
      real(dp) :: n(corners)
      n(1) = (1 - xi(1))*(1 - xi(2))
      n(2) = xi(1)*(1 - xi(2))
      n(3) = (1 - xi(1))*xi(2)
      n(4) = xi(1)*xi(2)
   end function shape_functions

   !> Gradients of the shape functions with respect to position.
   pure function shape_gradients(xi, inverse_size) result(gradient)
      real(dp), intent(in) :: xi(ndim)      !! local coordinate [-]
      real(dp), intent(in) :: inverse_size  !! 1 / size of the cell [1/m]
      real(dp) :: gradient(corners, ndim)   !! [1/m]
      gradient(1, 1) = -(1 - xi(2))*inverse_size
      gradient(1, 2) = -(1 - xi(1))*inverse_size
      gradient(2, 1) = (1 - xi(2))*inverse_size
      gradient(2, 2) = -xi(1)*inverse_size
      gradient(3, 1) = -xi(2)*inverse_size
      gradient(3, 2) = (1 - xi(1))*inverse_size
      gradient(4, 1) = xi(2)*inverse_size
      gradient(4, 2) = xi(1)*inverse_size
   end function shape_gradients

   !> Value at `xi` of a vector field given at the corners.
   pure function interpolate(xi, at_corner) result(value)
      real(dp), intent(in) :: xi(ndim)                  !! local coordinate [-]
      real(dp), intent(in) :: at_corner(ndim, corners)
      real(dp) :: value(ndim)
      real(dp) :: low, high
      integer :: d
      do d = 1, ndim
         low = at_corner(d, 1) + xi(1)*(at_corner(d, 2) - at_corner(d, 1))
         high = at_corner(d, 3) + xi(1)*(at_corner(d, 4) - at_corner(d, 3))
         value(d) = low + xi(2)*(high - low)
      end do
   end function interpolate

   !> Gradient at `xi`, times the size of the cell, of a vector field given at the corners: component d, direction j.
   pure function interpolate_gradient(xi, at_corner) result(gradient)
      real(dp), intent(in) :: xi(ndim)                  !! local coordinate [-]
      real(dp), intent(in) :: at_corner(ndim, corners)
      real(dp) :: gradient(ndim, ndim)
      real(dp) :: twist
      integer :: d
      do d = 1, ndim
         twist = (at_corner(d, 4) - at_corner(d, 3)) - (at_corner(d, 2) - at_corner(d, 1))
         gradient(d, 1) = (at_corner(d, 2) - at_corner(d, 1)) + xi(2)*twist
         gradient(d, 2) = (at_corner(d, 3) - at_corner(d, 1)) + xi(1)*twist
      end do
   end function interpolate_gradient

   !> Add to the corners their shares of a scalar and of a vector that stand at `xi`.
   pure subroutine add_shares(xi, scalar, vector, scalar_sum, vector_sum)
      real(dp), intent(in) :: xi(ndim)                  !! local coordinate [-]
      real(dp), intent(in) :: scalar
      real(dp), intent(in) :: vector(ndim)
      real(dp), intent(inout) :: scalar_sum(corners)
      real(dp), intent(inout) :: vector_sum(ndim, corners)
      real(dp) :: n(corners)
      integer :: d
      n = shape_functions(xi)
      scalar_sum(1) = scalar_sum(1) + n(1)*scalar
      scalar_sum(2) = scalar_sum(2) + n(2)*scalar
      scalar_sum(3) = scalar_sum(3) + n(3)*scalar
      scalar_sum(4) = scalar_sum(4) + n(4)*scalar
      do d = 1, ndim
         vector_sum(d, 1) = vector_sum(d, 1) + n(1)*vector(d)
         vector_sum(d, 2) = vector_sum(d, 2) + n(2)*vector(d)
         vector_sum(d, 3) = vector_sum(d, 3) + n(3)*vector(d)
         vector_sum(d, 4) = vector_sum(d, 4) + n(4)*vector(d)
      end do
   end subroutine add_shares

   !> Add to the corners what a tensor gives by the gradients of their shape functions, times the size of the cell: the sum
   !> over the directions j of tensor(:, j) times the derivative in direction j.
   pure subroutine add_divergence(xi, tensor, at_corner)
      real(dp), intent(in) :: xi(ndim)                  !! local coordinate [-]
      real(dp), intent(in) :: tensor(ndim, ndim)
      real(dp), intent(inout) :: at_corner(ndim, corners)
      real(dp) :: x_upper, x_lower, y_upper, y_lower
      integer :: d
      do d = 1, ndim
         x_upper = xi(2)*tensor(d, 1)
         x_lower = tensor(d, 1) - x_upper
         y_upper = xi(1)*tensor(d, 2)
         y_lower = tensor(d, 2) - y_upper
         at_corner(d, 1) = at_corner(d, 1) - (x_lower + y_lower)
         at_corner(d, 2) = at_corner(d, 2) + (x_lower - y_upper)
         at_corner(d, 3) = at_corner(d, 3) + (y_lower - x_upper)
         at_corner(d, 4) = at_corner(d, 4) + (x_upper + y_upper)
      end do
   end subroutine add_divergence

   !> The local coordinate kept `edge_margin` away from the edges of the cell.
   pure function inside_cell(xi) result(inside)
      real(dp), intent(in) :: xi(ndim)
      real(dp) :: inside(ndim)
      inside = min(max(xi, edge_margin), 1 - edge_margin)
   end function inside_cell
end module hampm_basis
