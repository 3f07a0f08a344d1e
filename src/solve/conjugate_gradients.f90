!> Solution of a sparse symmetric positive definite matrix by conjugate gradients, with its diagonal as preconditioner. It needs no
!> more memory than the matrix, and ever more iterations for finer meshes. Sums are taken in a fixed order, whatever the number of
!> threads. (Saad, Iterative Methods for Sparse Linear Systems, 2nd ed., algorithm 9.1.)
module hampm_conjugate_gradients
   use hampm_kinds, only: dp
   use hampm_failure, only: failure_t, exit_computation
   use hampm_sparse, only: sparse_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: solve_by_cg

   real(dp), parameter :: tolerance = 1e-10_dp   !! of the residual over the right-hand side
   integer, parameter :: iterations_per_row = 10 !! after which there is no hope
   integer, parameter :: chunk = 4096            !! rows whose sums are taken at once

contains

   !> x = A^-1 b. Fails where the matrix is not positive definite or the iteration does not end.
   subroutine solve_by_cg(matrix, b, x, failure)
      type(sparse_t), intent(in) :: matrix
      real(dp), intent(in) :: b(:)
      real(dp), intent(out) :: x(:)
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: r(:), z(:), p(:), q(:), scale(:)
      real(dp) :: rho, last, curvature, norm
      integer :: k
      x = 0
      norm = sqrt(dot(b, b))
      if (.not. norm > 0) return
      allocate (r, source=b)
      allocate (z(size(b)), p(size(b)), q(size(b)), scale(size(b)))
      call diagonal_of(matrix, scale)
      if (any(scale <= 0)) then
         call failure%report(exit_computation, 'it is not positive definite')
         return
      end if
      p = 0
      last = 1
      do k = 1, iterations_per_row*size(b)
         z = r/scale
         rho = dot(r, z)
         p = z + (rho/last)*p
         call multiply(matrix, p, q)
         curvature = dot(p, q)
         if (.not. curvature > 0) then
            call failure%report(exit_computation, 'it is not positive definite')
            return
         end if
         x = x + (rho/curvature)*p
         r = r - (rho/curvature)*q
         last = rho
         if (sqrt(dot(r, r)) <= tolerance*norm) return
      end do
      call failure%report(exit_computation, 'conjugate gradients have not solved it in '//to_text(iterations_per_row*size(b))// &
                          ' iterations')
   end subroutine solve_by_cg

   !> The diagonal.
   pure subroutine diagonal_of(matrix, diagonal)
      type(sparse_t), intent(in) :: matrix
      real(dp), intent(out) :: diagonal(:)
      integer :: i, k
      diagonal = 0
      do i = 1, matrix%n
         do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
            if (matrix%column(k) == i) diagonal(i) = matrix%value(k)
         end do
      end do
   end subroutine diagonal_of

   !> q = A p.
   subroutine multiply(matrix, p, q)
      type(sparse_t), intent(in) :: matrix
      real(dp), intent(in) :: p(:)
      real(dp), intent(out) :: q(:)
      real(dp) :: total
      integer :: i, k
      !$omp parallel do schedule(static) private(k, total)
      do i = 1, matrix%n
         total = 0
         do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
            total = total + matrix%value(k)*p(matrix%column(k))
         end do
         q(i) = total
      end do
   end subroutine multiply

   !> Product of two vectors, summed up chunk by chunk.
   real(dp) function dot(a, b)
      real(dp), intent(in) :: a(:), b(:)
      real(dp) :: part((size(a) - 1)/chunk + 1)
      integer :: c
      !$omp parallel do schedule(static)
      do c = 1, size(part)
         part(c) = dot_product(a((c - 1)*chunk + 1:min(c*chunk, size(a))), b((c - 1)*chunk + 1:min(c*chunk, size(a))))
      end do
      dot = sum(part)
   end function dot
end module hampm_conjugate_gradients
