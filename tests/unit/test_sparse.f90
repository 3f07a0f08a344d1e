!> Sparse symmetric matrices: the pattern of cliques.
program test_sparse
   use hampm_kinds, only: dp
   use hampm_harness, only: check, check_close, finish
   use hampm_sparse, only: sparse_t, pattern_of_cliques
   implicit none

   call check_pattern()
   call finish()

contains

   subroutine check_pattern()
      type(sparse_t) :: a
      ! 1 - 2 - 3 and 3 - 5; row 4 is in no clique, 0 is no member
      call pattern_of_cliques(5, reshape([3, 1, 2, 0, 5, 3, 2, 1, 0], [3, 3]), a)
      call check(a%n == 5, 'a pattern has as many rows as asked for')
      call check(all(a%row_start == [1, 4, 7, 11, 11, 13]), 'each row has its entries')
      call check(all(a%column == [1, 2, 3, 1, 2, 3, 1, 2, 3, 5, 3, 5]), 'couplings are found once, ascending')
      call check(all(abs(a%value) <= 0), 'values start at zero')
      call a%add(3, 5, 2.0_dp)
      call a%add(3, 5, 0.5_dp)
      call check_close(a%value(10), 2.5_dp, 0.0_dp, 'values are added to their entry')
      call check_close(sum(abs(a%value)), 2.5_dp, 0.0_dp, 'and to no other')
   end subroutine check_pattern
end program test_sparse
