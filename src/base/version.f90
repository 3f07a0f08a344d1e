!> The version of the program, written into every result and checkpoint: a number and, in parentheses, the commit that it was built from.
!>
!> Only the main program knows it, and says it as it begins, so that nothing else is compiled and linked anew with each commit.
module hampm_version
   implicit none
   private
   public :: version, identify, same_release

   character(80), protected :: version = 'unknown'

contains

   !> Note the version of the program that runs.
   subroutine identify(by)
      character(*), intent(in) :: by
      version = by
   end subroutine identify

   !> Whether two versions have the same number, whatever their commits.
   pure logical function same_release(one, other)
      character(*), intent(in) :: one, other
      same_release = one(:scan(one//' ', ' ') - 1) == other(:scan(other//' ', ' ') - 1)
   end function same_release
end module hampm_version
