!> Volumes of the particles of a piece of a quadratic cell, as weights of a quadrature: those nearest to equal ones by which polynomials are
!> integrated over the piece exactly (`hampm_piece_moments`).
!>
!> Uniform stress is in balance, whatever a crack or an edge leaves of a cell, when the gradients of its functions are integrated exactly, and
!> linear stress when these times linear functions are. Of M w = m, with the polynomials at the particles in M and their integrals in m, the
!> solution is taken that makes the sum of (w - w_0)**2 least. No weight may be less than a part of the mean: those that would be have that
!> part, and the others make up for it. Where that has no solution, as with few particles, fewer polynomials are integrated exactly, the area
!> always. Polynomials that are sums of others at the particles, as x is of 1 and y where these stand in line beside an edge, need no more than
!> that their integrals are the same sums.
!>
!> Source: Mueller, Kummer & Oberlack, Highly accurate surface and volume integration on implicit domains by means of moment-fitting,
!> International Journal for Numerical Methods in Engineering 96 (2013) 512-528.
module hampm_moment_fitting
   use hampm_kinds, only: dp
   use hampm_piece_moments, only: n_polynomials
   implicit none
   private
   public :: fitted_weights

   integer, parameter :: exact(4) = [13, 8, 3, 1] !! how many polynomials are tried to be integrated exactly
   real(dp), parameter :: least = 0.1_dp         !! weight, over the mean of the weights
   real(dp), parameter :: close = 1e-9_dp        !! what may be left of the polynomials, over the area, and at the particles of those that
                                                 !! are sums of others

contains

   !> The weights of some points.
   pure function fitted_weights(at_points, moments) result(w)
      real(dp), intent(in) :: at_points(:, :)    !! polynomials at the points, (polynomials, points)
      real(dp), intent(in) :: moments(:)         !! their integrals; that of the first, 1, is above 0
      real(dp) :: w(size(at_points, 2))
      logical :: found
      integer :: k
      w = moments(1)/size(w)
      do k = 1, size(exact)
         call fit(exact(k), at_points, moments, w, found)
         if (found) return
      end do
   end function fitted_weights

   !> Weights by which so many polynomials are integrated exactly, if there are.
   pure subroutine fit(n, at_points, moments, w, found)
      integer, intent(in) :: n
      real(dp), intent(in) :: at_points(:, :), moments(:)
      real(dp), intent(inout) :: w(:)
      logical, intent(out) :: found
      real(dp) :: trial(size(w)), equal
      logical :: is_free(size(w))
      integer :: turn
      found = .false.
      equal = moments(1)/size(w)
      trial = equal
      is_free = .true.
      do turn = 1, size(w)
         trial = trial + least_change(at_points(:n, :), moments(:n) - matmul(at_points(:n, :), trial), is_free)
         if (maxval(abs(matmul(at_points(:n, :), trial) - moments(:n))) > close*moments(1)) return
         if (all(trial >= least*equal .or. .not. is_free)) then
            w = trial
            found = .true.
            return
         end if
         where (is_free .and. trial < least*equal)
            is_free = .false.
            trial = least*equal
         end where
      end do
   end subroutine fit

   !> The least change of the weights of some points by which the integrals of the polynomials change as they should, by orthogonal sums of
   !> these (Gram & Schmidt).
   pure function least_change(at_points, missing, is_free) result(change)
      real(dp), intent(in) :: at_points(:, :)    !! polynomials at the points, (polynomials, points)
      real(dp), intent(in) :: missing(:)         !! of their integrals
      logical, intent(in) :: is_free(:)          !! whether the weight of each point may change
      real(dp) :: change(size(is_free))
      real(dp) :: basis(size(is_free), size(missing)), row(size(is_free))
      integer :: n, j, k, turn
      change = 0
      n = 0
      do j = 1, size(missing)
         row = merge(at_points(j, :), 0.0_dp, is_free)
         do turn = 1, 2                          ! the second time takes off what rounding has left
            do k = 1, n
               row = row - dot_product(row, basis(:, k))*basis(:, k)
            end do
         end do
         if (norm2(row) <= close*sqrt(real(size(is_free), dp))) cycle
         n = n + 1
         basis(:, n) = row/norm2(row)
         change = change + (missing(j) - dot_product(at_points(j, :), change))/norm2(row)*basis(:, n)
      end do
   end function least_change
end module hampm_moment_fitting
