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
      type(sparse_t) :: a, b
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
      call a%add_block([5, 0, 3], reshape([1.0_dp, 2.0_dp, 3.0_dp, 4.0_dp, 5.0_dp, 6.0_dp, 7.0_dp, 8.0_dp, 9.0_dp], [3, 3]))
      call check(all(abs(a%value(9:) - [9.0_dp, 5.5_dp, 7.0_dp, 1.0_dp]) <= 0), 'a full matrix is added entry by entry')
      call check_close(sum(abs(a%value)), 22.5_dp, 0.0_dp, 'but for rows and columns that are left out')
      call a%add_block([3, 3], reshape([1.0_dp, 2.0_dp, 3.0_dp, 4.0_dp], [2, 2]))
      call check_close(a%value(9), 19.0_dp, 0.0_dp, 'rows and columns that are the same are summed up')
      b = a
      b%value = 0
      call check(a%has_pattern_of(b), 'a pattern is that of other values')
      call pattern_of_cliques(5, reshape([3, 1, 2, 0, 4, 3, 2, 1, 0], [3, 3]), b)
      call check(.not. a%has_pattern_of(b), 'but not one with as many other entries')
      call check(.not. a%has_pattern_of(sparse_t()), 'nor none at all')
   end subroutine check_pattern
end program test_sparse
