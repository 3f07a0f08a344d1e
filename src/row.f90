!> One row of the history as it is filled, value by value.
module hampm_row
   use hampm_kinds, only: dp
   implicit none
   private
   public :: row_t

   !> The values of a row so far.
   type :: row_t
      integer :: n = 0                           !! values so far
      real(dp) :: values(64) = 0                 !! (n); a scene has 30 columns and one for each radius at most
   contains
      procedure, private :: add_one
      procedure, private :: add_several
      generic :: add => add_one, add_several
   end type row_t

contains

   !> Append a value.
   pure subroutine add_one(self, value)
      class(row_t), intent(inout) :: self
      real(dp), intent(in) :: value
      self%n = self%n + 1
      self%values(self%n) = value
   end subroutine add_one

   !> Append several values.
   pure subroutine add_several(self, values)
      class(row_t), intent(inout) :: self
      real(dp), intent(in) :: values(:)
      self%values(self%n + 1:self%n + size(values)) = values
      self%n = self%n + size(values)
   end subroutine add_several
end module hampm_row
