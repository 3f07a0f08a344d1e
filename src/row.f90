!> One row of the history as it is filled, value by value.
module hampm_row
   use hampm_kinds, only: dp
   implicit none
   private
   public :: row_t

   type :: row_t
      integer :: n = 0                           !! values so far
      real(dp) :: values(64) = 0                 !! (n); a scene has 30 columns and one for each radius at most
   contains
      procedure :: add
   end type row_t

contains

   !> Append a value.
   pure subroutine add(self, value)
      class(row_t), intent(inout) :: self
      real(dp), intent(in) :: value
      self%n = self%n + 1
      self%values(self%n) = value
   end subroutine add
end module hampm_row
