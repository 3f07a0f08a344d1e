!> Solution of a sparse symmetric positive definite matrix by conjugate gradients, preconditioned by its diagonal or a multigrid
!> cycle. The diagonal needs no more memory than the matrix, but ever more iterations for finer meshes. Sums are taken in a fixed
!> order, independent of the number of threads. (Saad, Iterative Methods for Sparse Linear Systems, 2nd ed., algorithm 9.1.)
module hampm_conjugate_gradients
   use hampm_kinds, only: dp
   use hampm_failure, only: failure_t, exit_computation
   use hampm_multigrid, only: multigrid_t
   use hampm_sparse, only: sparse_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: solve_by_cg

   real(dp), parameter :: tolerance = 1e-10_dp   !! of the residual over the right-hand side
   integer, parameter :: iterations_per_row = 10 !! after which there is no hope
   integer, parameter :: most_with_multigrid = 500 !! the same; 13 to 60 are usual
   integer, parameter :: chunk = 4096            !! rows whose sums are taken at once

contains

   !> x = A^-1 b. Fails where the matrix is not positive definite or the iteration does not end.
   subroutine solve_by_cg(matrix, b, x, failure, multigrid)
      type(sparse_t), intent(in) :: matrix
      real(dp), intent(in) :: b(:)
      real(dp), intent(out) :: x(:)
      type(failure_t), intent(inout) :: failure
      type(multigrid_t), intent(inout), optional :: multigrid !! of the matrix
      real(dp), allocatable :: r(:), z(:), p(:), q(:), scale(:)
      real(dp) :: rho, last, curvature, norm
      integer :: k, most
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
      most = iterations_per_row*size(b)
      if (present(multigrid)) most = most_with_multigrid
      p = 0
      last = 1
      do k = 1, most
         if (present(multigrid)) then
            call multigrid%precondition(matrix, r, z, 1)
         else
            z = r/scale
         end if
         rho = dot(r, z)
         p = z + (rho/last)*p
         call matrix%multiply(p, q)
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
      call failure%report(exit_computation, 'conjugate gradients have not solved it in '//to_text(most)//' iterations')
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
