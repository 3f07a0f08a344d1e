!> Sums of fields as vectors of so many numbers: a field of two components a node in an expression would be done node by node;
!> and the line through some values.
module hampm_vectors
   use hampm_kinds, only: dp
   implicit none
   private
   public :: multiply, add_scaled, combine, correct, difference_over, product_with_sum, fit_line

contains

   !> y = factor x.
   pure subroutine multiply(n, factor, x, y)
      integer, intent(in) :: n
      real(dp), intent(in) :: factor, x(n)
      real(dp), intent(out) :: y(n)
      integer :: k
      !$omp simd
      do k = 1, n
         y(k) = factor*x(k)
      end do
   end subroutine multiply

   !> total <- total + factor x.
   pure subroutine add_scaled(n, factor, x, total)
      integer, intent(in) :: n
      real(dp), intent(in) :: factor, x(n)
      real(dp), intent(inout) :: total(n)
      integer :: k
      !$omp simd
      do k = 1, n
         total(k) = total(k) + factor*x(k)
      end do
   end subroutine add_scaled

   !> z = a x + b y.
   pure subroutine combine(n, a, x, b, y, z)
      integer, intent(in) :: n
      real(dp), intent(in) :: a, x(n), b, y(n)
      real(dp), intent(out) :: z(n)
      integer :: k
      !$omp simd
      do k = 1, n
         z(k) = a*x(k) + b*y(k)
      end do
   end subroutine combine

   !> z = factor (x - from) + start.
   pure subroutine correct(n, factor, x, from, start, z)
      integer, intent(in) :: n
      real(dp), intent(in) :: factor, x(n), from(n), start(n)
      real(dp), intent(out) :: z(n)
      integer :: k
      !$omp simd
      do k = 1, n
         z(k) = factor*(x(k) - from(k)) + start(k)
      end do
   end subroutine correct

   !> z = (x - y)/over.
   pure subroutine difference_over(n, x, y, over, z)
      integer, intent(in) :: n
      real(dp), intent(in) :: x(n), y(n), over
      real(dp), intent(out) :: z(n)
      integer :: k
      !$omp simd
      do k = 1, n
         z(k) = (x(k) - y(k))/over
      end do
   end subroutine difference_over

   !> x . (y + z).
   pure real(dp) function product_with_sum(n, x, y, z) result(product)
      integer, intent(in) :: n
      real(dp), intent(in) :: x(n), y(n), z(n)
      integer :: k
      product = 0
      !$omp simd reduction(+: product)
      do k = 1, n
         product = product + x(k)*(y(k) + z(k))
      end do
   end function product_with_sum

   !> Slope of the line of least squares through values y at x, and twice the standard deviation of the values from it.
   pure subroutine fit_line(x, y, slope, scatter)
      real(dp), intent(in) :: x(:), y(:)         !! three values at least
      real(dp), intent(out) :: slope, scatter
      real(dp), dimension(size(x)) :: a, b       ! from the means
      a = x - sum(x)/size(x)
      b = y - sum(y)/size(y)
      slope = dot_product(a, b)/dot_product(a, a)
      scatter = 2*sqrt(sum((b - slope*a)**2)/(size(x) - 2))
   end subroutine fit_line
end module hampm_vectors
