!> The procedures of LAPACK that are in use, in double precision. A positive `info` tells where the matrix is not positive definite,
!> or that eigenvalues were not found.
module hampm_lapack
   use hampm_kinds, only: dp
   implicit none
   private
   public :: dposv, dpotrf, dpotri, dsyev

   interface
      !> Solve a symmetric positive definite system.
      pure subroutine dposv(uplo, n, nrhs, a, lda, b, ldb, info)
         import :: dp
         character, intent(in) :: uplo
         integer, intent(in) :: n, nrhs, lda, ldb
         real(dp), intent(inout) :: a(lda, *), b(ldb, *)
         integer, intent(out) :: info
      end subroutine dposv

      !> Factorise a symmetric positive definite matrix (Cholesky).
      pure subroutine dpotrf(uplo, n, a, lda, info)
         import :: dp
         character, intent(in) :: uplo
         integer, intent(in) :: n, lda
         real(dp), intent(inout) :: a(lda, *)
         integer, intent(out) :: info
      end subroutine dpotrf

      !> Invert a matrix that `dpotrf` has factorised.
      pure subroutine dpotri(uplo, n, a, lda, info)
         import :: dp
         character, intent(in) :: uplo
         integer, intent(in) :: n, lda
         real(dp), intent(inout) :: a(lda, *)
         integer, intent(out) :: info
      end subroutine dpotri

      !> Eigenvalues of a symmetric matrix, ascending, and on request its eigenvectors.
      pure subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
         import :: dp
         character, intent(in) :: jobz, uplo
         integer, intent(in) :: n, lda, lwork
         real(dp), intent(inout) :: a(lda, *)
         real(dp), intent(out) :: w(*), work(*)
         integer, intent(out) :: info
      end subroutine dsyev
   end interface
end module hampm_lapack
