!> Version of the program, written into every result and checkpoint: a number and, in parentheses, the commit of the build.
!>
!> Only the main program knows it, and says it as it begins, so that nothing else is compiled and linked anew with each commit.
module hampm_version
   use hampm_kinds, only: ndim
   implicit none
   private
   public :: program_name, version, identify, same_release, release_of, commit_of

   character(*), parameter :: program_name = 'hampm'//repeat('3d', ndim - 2)
   character(80), protected :: version = 'unknown'

contains

   !> Note the version of the program that runs.
   subroutine identify(by)
      character(*), intent(in) :: by
      version = by
   end subroutine identify

   !> Whether two versions have the same number, with any commits.
   pure logical function same_release(one, other)
      character(*), intent(in) :: one, other
      same_release = release_of(one) == release_of(other)
   end function same_release

   !> The number of a version.
   pure function release_of(version) result(text)
      character(*), intent(in) :: version
      character(:), allocatable :: text
      text = version(:scan(version//' ', ' ') - 1)
   end function release_of

   !> The commit of a version, with "modified" where files differ from it; '' where it is not known.
   pure function commit_of(version) result(text)
      character(*), intent(in) :: version
      character(:), allocatable :: text
      text = version(scan(version//'(', '(') + 1:max(0, scan(version, ')') - 1))
   end function commit_of
end module hampm_version
