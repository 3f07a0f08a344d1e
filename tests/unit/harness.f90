!> The checks of the unit tests: count what holds, print what does not, and end the program accordingly.
module hampm_harness
   use hampm_kinds, only: dp
   use hampm_text, only: to_text
   implicit none
   private
   public :: check, check_close, finish, repeat_random_numbers

   integer :: passed = 0
   integer :: failed = 0

contains

   !> Note whether a promise holds; `what` says what was promised.
   subroutine check(condition, what)
      logical, intent(in) :: condition
      character(*), intent(in) :: what
      if (condition) then
         passed = passed + 1
      else
         failed = failed + 1
         write (*, '(2a)') 'FAILED: ', what
      end if
   end subroutine check

   !> Check that a value is within `tolerance` of the expected one; not a number never is.
   subroutine check_close(value, expected, tolerance, what)
      real(dp), intent(in) :: value, expected, tolerance
      character(*), intent(in) :: what
      if (abs(value - expected) <= tolerance) then
         call check(.true., what)
      else
         call check(.false., what//': '//to_text(value)//' is not within '//to_text(tolerance)//' of '//to_text(expected))
      end if
   end subroutine check_close

   !> Let `random_number` give the same numbers in every run.
   subroutine repeat_random_numbers()
      integer :: n, k
      call random_seed(size=n)
      call random_seed(put=[(37*k, k=1, n)])
   end subroutine repeat_random_numbers

   !> Print the number of checks; end with an exit code above zero where one has failed.
   subroutine finish()
      write (*, '(a)') to_text(passed)//' checks passed'
      if (failed == 0) return
      write (*, '(a)') to_text(failed)//' checks FAILED'
      error stop 1
   end subroutine finish
end module hampm_harness
