!> The version of the program, written into every result.
module hampm_version
   implicit none
   private
   public :: version

   character(*), parameter :: version = '1.0.0'
end module hampm_version
