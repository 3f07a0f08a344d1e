!> What a unit test asks of the build that it is in.
module hampm_builds
   use, intrinsic :: iso_fortran_env, only: compiler_options
   implicit none
   private
   public :: is_slow

contains

   !> Whether this is a build that looks closer and is many times as slow as the release build: debug, sanitize, memcheck, coverage.
   !> Tests that repeat the same at very many places or times take fewer of them then.
   logical function is_slow()
      is_slow = index(compiler_options(), '-O3') == 0
   end function is_slow
end module hampm_builds
