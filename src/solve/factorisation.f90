!> Factorisation of a sparse matrix: by CHOLMOD where it is symmetric and positive definite, else by UMFPACK. A failure names the
!> defect of the matrix; the caller knows its meaning.
module hampm_factorisation
   use hampm_kinds, only: dp
   use hampm_cholmod, only: cholmod_t
   use hampm_failure, only: failure_t
   use hampm_sparse, only: sparse_t
   use hampm_umfpack, only: umfpack_t
   implicit none
   private
   public :: factorisation_t

   !> A factorised matrix.
   type :: factorisation_t
      logical :: is_definite = .false.           !! whether the matrix, or its symmetric part, is positive definite: CHOLMOD has it
      logical :: solves_often = .false.          !! whether many solutions will follow
      logical, private :: by_cholmod = .false.   !! whether CHOLMOD has all of it
      type(cholmod_t), private :: cholmod
      type(umfpack_t), private :: umfpack
   contains
      procedure :: factorise
      procedure :: solve
      procedure :: release
   end type factorisation_t

contains

   !> Factorise a matrix; its pattern is constant until `release`. Fails where the matrix is singular or memory does not suffice.
   subroutine factorise(self, matrix, failure, last)
      class(factorisation_t), intent(inout) :: self
      type(sparse_t), intent(in) :: matrix
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: last(:)   !! rows that are to be eliminated behind all others
      self%cholmod%solves_often = self%solves_often
      if (matrix%is_symmetric) then
         call self%cholmod%factorise(matrix, self%is_definite, failure, last)
      else
         call self%cholmod%factorise(matrix%symmetric_part(), self%is_definite, failure, last)
      end if
      if (failure%failed()) return
      self%by_cholmod = self%is_definite .and. matrix%is_symmetric
      if (self%by_cholmod) then
         call self%umfpack%release()
      else
         call self%cholmod%release()
         call self%umfpack%factorise(matrix, failure)
      end if
   end subroutine factorise

   !> x = A^-1 b with the factorised matrix A, which may have no rows, for one b or several, side by side at each row. Where A is
   !> positive definite and many solutions follow, a b `without` the rows that are eliminated last leaves them out: x is 0 there.
   subroutine solve(self, b, x, without)
      class(factorisation_t), intent(inout) :: self
      real(dp), intent(in), contiguous :: b(:)
      real(dp), intent(out), contiguous :: x(:)
      logical, intent(in), optional :: without(:) !! (right-hand sides)
      if (size(b) == 0) return
      if (.not. self%by_cholmod) then
         call self%umfpack%solve(b, x)
      else if (present(without)) then            ! its offset would be taken where it is absent
         call self%cholmod%solve(b, x, without)
      else
         call self%cholmod%solve(b, x)
      end if
   end subroutine solve

   !> Release the memory.
   subroutine release(self)
      class(factorisation_t), intent(inout) :: self
      call self%cholmod%release()
      call self%umfpack%release()
   end subroutine release
end module hampm_factorisation
