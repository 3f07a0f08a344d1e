!> Sparse direct solution by UMFPACK (Davis 2004), through its C interface for 32-bit indices.
module hampm_umfpack
   use, intrinsic :: iso_c_binding, only: c_int, c_double, c_ptr, c_null_ptr, c_associated
   use hampm_kinds, only: dp
   use hampm_failure, only: failure_t, exit_computation
   use hampm_sparse, only: sparse_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: umfpack_t

   integer, parameter :: n_control = 20, n_info = 90      ! sizes of UMFPACK's arrays
   integer(c_int), parameter :: solve_system = 1          ! UMFPACK_At: the rows of A are given as columns
   integer, parameter :: refinement_steps = 8             ! position of UMFPACK_IRSTEP, from 1

   !> A factorised matrix. The symbolic analysis belongs to the pattern and is kept until that changes.
   type :: umfpack_t
      private
      type(c_ptr) :: symbolic = c_null_ptr
      type(c_ptr) :: numeric = c_null_ptr
      integer(c_int), allocatable :: column_start(:), row(:)
      real(c_double), allocatable :: value(:)
      real(c_double) :: control(n_control) = 0
   contains
      procedure :: factorise
      procedure :: solve
      procedure :: release
   end type umfpack_t

   interface
      subroutine umfpack_di_defaults(control) bind(c)
         import :: c_double
         real(c_double), intent(out) :: control(*)
      end subroutine umfpack_di_defaults

      integer(c_int) function umfpack_di_symbolic(n_row, n_col, ap, ai, ax, symbolic, control, info) bind(c)
         import :: c_int, c_double, c_ptr
         integer(c_int), value :: n_row, n_col
         integer(c_int), intent(in) :: ap(*), ai(*)
         real(c_double), intent(in) :: ax(*), control(*)
         type(c_ptr), intent(out) :: symbolic
         real(c_double), intent(out) :: info(*)
      end function umfpack_di_symbolic

      integer(c_int) function umfpack_di_numeric(ap, ai, ax, symbolic, numeric, control, info) bind(c)
         import :: c_int, c_double, c_ptr
         integer(c_int), intent(in) :: ap(*), ai(*)
         real(c_double), intent(in) :: ax(*), control(*)
         type(c_ptr), value :: symbolic
         type(c_ptr), intent(out) :: numeric
         real(c_double), intent(out) :: info(*)
      end function umfpack_di_numeric

      integer(c_int) function umfpack_di_solve(system, ap, ai, ax, x, b, numeric, control, info) bind(c)
         import :: c_int, c_double, c_ptr
         integer(c_int), value :: system
         integer(c_int), intent(in) :: ap(*), ai(*)
         real(c_double), intent(in) :: ax(*), b(*), control(*)
         real(c_double), intent(inout) :: x(*)
         type(c_ptr), value :: numeric
         real(c_double), intent(out) :: info(*)
      end function umfpack_di_solve

      subroutine umfpack_di_free_symbolic(symbolic) bind(c)
         import :: c_ptr
         type(c_ptr), intent(inout) :: symbolic
      end subroutine umfpack_di_free_symbolic

      subroutine umfpack_di_free_numeric(numeric) bind(c)
         import :: c_ptr
         type(c_ptr), intent(inout) :: numeric
      end subroutine umfpack_di_free_numeric
   end interface

contains

   !> Analyse the pattern of a matrix and keep it. Fails where the memory does not suffice.
   subroutine analyse(self, matrix, failure)
      class(umfpack_t), intent(inout) :: self
      type(sparse_t), intent(in) :: matrix
      type(failure_t), intent(inout) :: failure
      real(c_double) :: info(n_info)
      integer(c_int) :: status
      call umfpack_di_defaults(self%control)
      self%control(refinement_steps) = 0         ! the caller's iteration replaces refinement
      self%column_start = matrix%row_start - 1
      self%row = matrix%column - 1
      status = umfpack_di_symbolic(matrix%n, matrix%n, self%column_start, self%row, matrix%value, self%symbolic, &
                                   self%control, info)
      if (status /= 0) call failure%report(exit_computation, 'UMFPACK cannot analyse it (status '//to_text(int(status))//')')
   end subroutine analyse

   !> Factorise a matrix; its pattern is analysed at first, and after `release`. Fails where it is singular or memory is short.
   subroutine factorise(self, matrix, failure)
      class(umfpack_t), intent(inout) :: self
      type(sparse_t), intent(in) :: matrix
      type(failure_t), intent(inout) :: failure
      real(c_double) :: info(n_info)
      integer(c_int) :: status
      if (.not. c_associated(self%symbolic)) call analyse(self, matrix, failure)
      if (failure%failed()) return
      if (c_associated(self%numeric)) call umfpack_di_free_numeric(self%numeric)
      self%value = matrix%value
      status = umfpack_di_numeric(self%column_start, self%row, self%value, self%symbolic, self%numeric, self%control, info)
      if (status /= 0) call failure%report(exit_computation, 'UMFPACK cannot factorise it (status '//to_text(int(status))// &
                                           '): it is singular or memory does not suffice')
   end subroutine factorise

   !> Solve with the factorised matrix, for one right-hand side or several, which stand side by side at each row.
   subroutine solve(self, rhs, x)
      class(umfpack_t), intent(in) :: self
      real(dp), intent(in) :: rhs(:)
      real(dp), intent(out) :: x(:)
      real(c_double) :: info(n_info)
      integer(c_int) :: status
      real(dp), allocatable :: x_k(:)
      integer :: k
      associate (n => size(self%column_start) - 1, width => size(rhs)/(size(self%column_start) - 1))
         allocate (x_k(n))
         do k = 1, width
            status = umfpack_di_solve(solve_system, self%column_start, self%row, self%value, x_k, rhs(k::width), self%numeric, &
                                      self%control, info)
            x(k::width) = merge(x_k, 0.0_dp, status == 0) ! the caller checks the residual
         end do
      end associate
   end subroutine solve

   !> Release the memory.
   subroutine release(self)
      class(umfpack_t), intent(inout) :: self
      if (c_associated(self%symbolic)) call umfpack_di_free_symbolic(self%symbolic)
      if (c_associated(self%numeric)) call umfpack_di_free_numeric(self%numeric)
      self%symbolic = c_null_ptr
      self%numeric = c_null_ptr
   end subroutine release
end module hampm_umfpack
