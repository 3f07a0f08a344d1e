!> Volumes of the particles of a piece of a quadratic cell, as weights of a quadrature: those nearest to equal ones by which polynomials are
!> integrated over the piece exactly (`hampm_piece_moments`).
!>
!> Uniform stress is in balance, whatever a crack or an edge leaves of a cell, when the gradients of its functions are integrated exactly, and
!> linear stress when these times linear functions are. Of M w = m, with the polynomials at the particles in M and their integrals in m, the
!> solution is taken that makes the sum of (w - w_0)**2 least. No weight may be less than a part of the mean: those that would be have that
!> part, and the others make up for it. Where that has no solution, as with few particles, fewer polynomials are integrated exactly, the area
!> always.
!>
!> Source: Mueller, Kummer & Oberlack, Highly accurate surface and volume integration on implicit domains by means of moment-fitting,
!> International Journal for Numerical Methods in Engineering 96 (2013) 512-528.
module hampm_moment_fitting
   use hampm_kinds, only: dp
   use hampm_lapack, only: dposv
   use hampm_piece_moments, only: n_polynomials
   implicit none
   private
   public :: fitted_weights

   integer, parameter :: exact(4) = [13, 8, 3, 1] !! how many polynomials are tried to be integrated exactly
   real(dp), parameter :: least = 0.1_dp         !! weight, over the mean of the weights
   real(dp), parameter :: close = 1e-9_dp        !! what may be left of the polynomials, over the area

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
      real(dp) :: normal(n, n), left(n, 1), trial(size(w)), equal
      logical :: is_free(size(w))
      integer :: turn, i, j, info
      found = .false.
      equal = moments(1)/size(w)
      trial = equal
      is_free = .true.
      do turn = 1, size(w)
         if (count(is_free) < n) return
         normal = 0
         left(:, 1) = moments(:n)
         do i = 1, size(w)
            left(:, 1) = left(:, 1) - trial(i)*at_points(:n, i)
            if (.not. is_free(i)) cycle
            do j = 1, n
               normal(:, j) = normal(:, j) + at_points(:n, i)*at_points(j, i)
            end do
         end do
         call dposv('L', n, 1, normal, n, left, n, info)
         if (info /= 0) return
         do i = 1, size(w)
            if (is_free(i)) trial(i) = trial(i) + dot_product(left(:, 1), at_points(:n, i))
         end do
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
end module hampm_moment_fitting
