!> Factorisation of a sparse symmetric matrix, by UMFPACK or by LAPACK's banded Cholesky, which needs it positive definite: analyse
!> its pattern once, factorise its values as often as they change, and solve. A failure says what is the matter with the matrix; the
!> caller knows what it is the matrix of.
module hampm_factorisation
   use hampm_kinds, only: dp
   use hampm_banded, only: banded_t
   use hampm_failure, only: failure_t
   use hampm_sparse, only: sparse_t
   use hampm_umfpack, only: umfpack_t
   implicit none
   private
   public :: factorisation_t

   !> A factorised matrix.
   type :: factorisation_t
      logical :: by_umfpack = .true.             !! else by banded Cholesky
      type(umfpack_t), private :: umfpack
      type(banded_t), private :: banded
   contains
      procedure :: analyse
      procedure :: factorise
      procedure :: solve
      procedure :: sign_of_determinant
      procedure :: bandwidth
      procedure :: release
   end type factorisation_t

contains

   !> Analyse the pattern of a matrix. Fails where the memory does not suffice.
   subroutine analyse(self, matrix, failure)
      class(factorisation_t), intent(inout) :: self
      type(sparse_t), intent(in) :: matrix
      type(failure_t), intent(inout) :: failure
      if (self%by_umfpack) then
         call self%umfpack%analyse(matrix, failure)
      else
         call self%banded%analyse(matrix, failure)
      end if
   end subroutine analyse

   !> Factorise a matrix of the pattern that was analysed. Fails where it is singular or, banded, not positive definite.
   subroutine factorise(self, matrix, failure)
      class(factorisation_t), intent(inout) :: self
      type(sparse_t), intent(in) :: matrix
      type(failure_t), intent(inout) :: failure
      if (self%by_umfpack) then
         call self%umfpack%factorise(matrix, failure)
      else
         call self%banded%factorise(matrix, failure)
      end if
   end subroutine factorise

   !> x = A^-1 b with the factorised matrix A.
   subroutine solve(self, b, x)
      class(factorisation_t), intent(in) :: self
      real(dp), intent(in) :: b(:)
      real(dp), intent(out) :: x(:)
      if (self%by_umfpack) then
         call self%umfpack%solve(b, x)
      else
         call self%banded%solve(b, x)
      end if
   end subroutine solve

   !> Sign of the determinant of the factorised matrix, 0 where it is not known; a Cholesky factorisation is there only where all
   !> eigenvalues are positive.
   integer function sign_of_determinant(self) result(sign_of)
      class(factorisation_t), intent(in) :: self
      sign_of = 1
      if (self%by_umfpack) sign_of = self%umfpack%sign_of_determinant()
   end function sign_of_determinant

   !> Entries beside the diagonal of the banded matrix, to one side; 0 by UMFPACK.
   pure integer function bandwidth(self)
      class(factorisation_t), intent(in) :: self
      bandwidth = self%banded%bandwidth
   end function bandwidth

   !> Give back the memory.
   subroutine release(self)
      class(factorisation_t), intent(inout) :: self
      call self%umfpack%release()
      self%banded = banded_t()
   end subroutine release
end module hampm_factorisation
