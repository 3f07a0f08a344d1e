!> Conjugate gradients solve what is positive definite, and say so of what is not.
program test_conjugate_gradients
   use hampm_kinds, only: dp
   use hampm_conjugate_gradients, only: solve_by_cg
   use hampm_failure, only: failure_t
   use hampm_harness, only: check, check_close, finish
   use hampm_sparse, only: sparse_t, pattern_of_cliques
   implicit none

   integer, parameter :: n = 5000
   type(sparse_t) :: string
   type(failure_t) :: failure
   real(dp) :: x(n), solution(n)
   integer :: i

   ! A string of n interface points that is held at both ends, under its weight: a parabola at its nodes, exactly
   call new_string(2.0_dp, string)
   call solve_by_cg(string, [(1.0_dp, i=1, n)], x, failure)
   solution = [(0.5_dp*i*(n + 1 - i), i=1, n)]
   call check(.not. failure%failed(), 'a string of springs is solved')
   call check_close(maxval(abs(x - solution))/maxval(solution), 0.0_dp, 1e-6_dp, 'it hangs as a parabola')
   call solve_by_cg(string, [(0.0_dp, i=1, n)], x, failure)
   call check_close(maxval(abs(x)), 0.0_dp, 0.0_dp, 'without weight it is straight')
   call new_string(1.0_dp, string)
   call solve_by_cg(string, [(1.0_dp, i=1, n)], x, failure)
   call check(failure%failed(), 'what has negative eigenvalues is refused')
   call finish()

contains

   !> The stiffness of the string, with another diagonal than 2 on the whole.
   subroutine new_string(diagonal, matrix)
      real(dp), intent(in) :: diagonal
      type(sparse_t), intent(out) :: matrix
      integer :: k
      call pattern_of_cliques(n, reshape([([k, k + 1], k=1, n - 1)], [2, n - 1]), matrix)
      do k = 1, n
         call matrix%add(k, k, diagonal)
         if (k < n) call matrix%add(k, k + 1, -1.0_dp)
         if (k < n) call matrix%add(k + 1, k, -1.0_dp)
      end do
   end subroutine new_string
end program test_conjugate_gradients
