!> Direct solution of a sparse symmetric positive definite matrix by LAPACK's banded Cholesky factorisation, after the rows
!> have been numbered anew for a small bandwidth.
module hampm_banded
   use hampm_kinds, only: dp
   use hampm_cuthill_mckee, only: reverse_cuthill_mckee
   use hampm_failure, only: failure_t, exit_computation
   use hampm_lapack, only: dpbtrf, dpbtrs
   use hampm_sparse, only: sparse_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: banded_t

   !> A factorised banded matrix, with its numbering of the rows.
   type :: banded_t
      integer :: bandwidth = 0                   !! entries beside the diagonal, to one side
      integer, allocatable, private :: place(:)  !! new number of each row, (n)
      real(dp), allocatable, private :: band(:, :)  !! lower triangle, then its factor, (bandwidth + 1, n)
   contains
      procedure :: analyse
      procedure :: factorise
      procedure :: solve
   end type banded_t

contains

   !> Number the rows of a pattern. Fails where the memory does not suffice.
   subroutine analyse(self, matrix, failure)
      class(banded_t), intent(inout) :: self
      type(sparse_t), intent(in) :: matrix
      type(failure_t), intent(inout) :: failure
      integer :: status
      self%place = reverse_cuthill_mckee(matrix)
      self%bandwidth = matrix%bandwidth(self%place)
      if (allocated(self%band)) deallocate (self%band)
      allocate (self%band(self%bandwidth + 1, matrix%n), stat=status)
      if (status /= 0) call failure%report(exit_computation, 'not enough memory for '//to_text(matrix%n)// &
                                           ' rows with bands of '//to_text(self%bandwidth + 1)//' entries')
   end subroutine analyse

   !> Factorise a matrix of the pattern that was analysed. Fails where it is not positive definite.
   subroutine factorise(self, matrix, failure)
      class(banded_t), intent(inout) :: self
      type(sparse_t), intent(in) :: matrix
      type(failure_t), intent(inout) :: failure
      integer :: i, k, info
      self%band = 0
      do i = 1, matrix%n
         do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
            associate (row => self%place(i), column => self%place(matrix%column(k)))
               if (row >= column) self%band(row - column + 1, column) = matrix%value(k)
            end associate
         end do
      end do
      call dpbtrf('L', matrix%n, self%bandwidth, self%band, self%bandwidth + 1, info)
      if (info /= 0) call failure%report(exit_computation, 'not positive definite at row '//to_text(info)//' of '// &
                                         to_text(matrix%n))
   end subroutine factorise

   !> Solve with the factorised matrix.
   subroutine solve(self, rhs, x)
      class(banded_t), intent(in) :: self
      real(dp), intent(in) :: rhs(:)
      real(dp), intent(out) :: x(:)
      real(dp) :: b(size(rhs), 1)
      integer :: info
      b(self%place, 1) = rhs
      call dpbtrs('L', size(rhs), self%bandwidth, 1, self%band, self%bandwidth + 1, b, size(rhs), info)
      x = b(self%place, 1)
   end subroutine solve
end module hampm_banded
