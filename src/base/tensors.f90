!> Small tensors of the space dimension.
module hampm_tensors
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: identity, trace, determinant, inverse_transpose, product_of

   real(dp), parameter :: identity(ndim, ndim) = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [ndim, ndim])

contains

   !> Trace of a second-order tensor.
   pure real(dp) function trace(f)
      real(dp), intent(in) :: f(ndim, ndim)
      integer :: i
      trace = 0
      do i = 1, ndim
         trace = trace + f(i, i)
      end do
   end function trace

   !> Determinant of a second-order tensor.
   pure real(dp) function determinant(f)
      real(dp), intent(in) :: f(ndim, ndim)
      determinant = f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1)
   end function determinant

   !> Product of two second-order tensors.
   pure function product_of(a, b) result(c)
      real(dp), intent(in) :: a(ndim, ndim), b(ndim, ndim)
      real(dp) :: c(ndim, ndim)
      integer :: j
      do j = 1, ndim
         c(:, j) = a(:, 1)*b(1, j) + a(:, 2)*b(2, j)
      end do
   end function product_of

   !> Transposed inverse of a second-order tensor whose determinant is not zero.
   pure function inverse_transpose(f) result(g)
      real(dp), intent(in) :: f(ndim, ndim)
      real(dp) :: g(ndim, ndim)
      g(1, 1) = f(2, 2)
      g(2, 1) = -f(1, 2)
      g(1, 2) = -f(2, 1)
      g(2, 2) = f(1, 1)
      g = g/determinant(f)
   end function inverse_transpose
end module hampm_tensors
