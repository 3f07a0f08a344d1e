!> The mistakes found in what the user wrote, collected so that all of them are reported at once.
module hampm_mistakes
   use hampm_failure, only: failure_t, exit_input
   use hampm_text, only: to_text
   implicit none
   private
   public :: mistakes_t

   integer, parameter :: most_shown = 50           !! a file that is no namelist at all would fill the screen

   !> The messages so far.
   type :: mistakes_t
      integer :: count = 0
      character(:), allocatable, private :: text   !! a line for each
   contains
      procedure :: add
      procedure :: tell
   end type mistakes_t

contains

   !> Note one mistake.
   pure subroutine add(self, message)
      class(mistakes_t), intent(inout) :: self
      character(*), intent(in) :: message          !! one line: where, what, what would be right
      self%count = self%count + 1
      if (self%count == 1) then
         self%text = message
      else if (self%count <= most_shown) then
         self%text = self%text//new_line('a')//message
      end if
   end subroutine add

   !> Report all mistakes, if there are any, as one failure.
   pure subroutine tell(self, failure)
      class(mistakes_t), intent(in) :: self
      type(failure_t), intent(inout) :: failure
      if (self%count == 0) return
      call failure%report(exit_input, self%text)
      if (self%count > most_shown) call failure%report(exit_input, &
         '... and '//to_text(self%count - most_shown)//' more')
   end subroutine tell
end module hampm_mistakes
