!> Sets that are joined pair by pair are those that paths along the pairs connect, and each is known by its least member.
program test_disjoint_sets
   use hampm_kinds, only: dp
   use hampm_disjoint_sets, only: disjoint_sets_t, singletons
   use hampm_harness, only: check, finish, repeat_random_numbers
   use hampm_text, only: to_text
   implicit none

   integer, parameter :: n = 40
   integer :: pairs

   call repeat_random_numbers()
   do pairs = 0, n
      call random_pairs(pairs)
   end do
   call finish()

contains

   !> The same as a label that spreads along the pairs until all of a pair have the same, the least one.
   subroutine random_pairs(pairs)
      integer, intent(in) :: pairs
      type(disjoint_sets_t) :: sets
      real(dp) :: x(2, pairs)
      integer :: pair(2, pairs), label(n), k, turn
      call random_number(x)
      pair = 1 + int(n*x)
      call singletons(n, sets)
      do k = 1, pairs
         call sets%join(pair(1, k), pair(2, k))
      end do
      label = [(k, k=1, n)]
      do turn = 1, n
         do k = 1, pairs
            label(pair(:, k)) = minval(label(pair(:, k)))
         end do
      end do
      call check(all([(sets%least_of(k), k=1, n)] == label), 'members of '//to_text(pairs)//' pairs are in the right sets')
      call check(sets%how_many(below=n/2) == count(label(:n/2 - 1) == [(k, k=1, n/2 - 1)]), 'and of those below some member')
      call check(sets%how_many() == count(label == [(k, k=1, n)]), 'there are as many sets as least members')
   end subroutine random_pairs
end program test_disjoint_sets
