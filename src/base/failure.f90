!> The one way in which things go wrong: a procedure that can fail takes a `failure_t` last, describes the
!> failure in it and returns. Only the main program turns it into a message and an exit code.
module hampm_failure
   use hampm_json, only: message_record
   implicit none
   private
   public :: failure_t, exit_done, exit_input, exit_computation, exit_file, exit_stopped

   integer, parameter :: exit_done = 0        !! all went well
   integer, parameter :: exit_input = 2       !! an error on the command line or in the input file
   integer, parameter :: exit_computation = 3 !! the computation went wrong
   integer, parameter :: exit_file = 4        !! a file could not be read or written
   integer, parameter :: exit_stopped = 5     !! the run was asked to stop before its end, and can be resumed

   !> Whether something has failed, and the message to the user.
   type :: failure_t
      integer :: code = exit_done               !! exit code of the program, `exit_done` while nothing failed
      character(:), allocatable :: message      !! the error, its place and the remedy; may have several lines
      character(:), allocatable :: records      !! the same as items of an array of JSON
   contains
      procedure :: failed
      procedure :: report
   end type failure_t

contains

   !> Whether something has failed.
   pure logical function failed(self)
      class(failure_t), intent(in) :: self
      failed = self%code /= exit_done
   end function failed

   !> Record a failure. A further failure of the same run adds its message below the first; the first code stays.
   pure subroutine report(self, code, message, records)
      class(failure_t), intent(inout) :: self
      integer, intent(in) :: code               !! one of the exit codes
      character(*), intent(in) :: message       !! the error, its place and the remedy
      character(*), intent(in), optional :: records !! the same as items of an array of JSON, where more is known than the message
      if (.not. allocated(self%records)) self%records = ''
      if (present(records)) then
         self%records = self%records//records
      else
         self%records = self%records//message_record(message, '', '', '', '')
      end if
      if (self%failed()) then
         self%message = self%message//new_line('a')//message
      else
         self%code = code
         self%message = message
      end if
   end subroutine report
end module hampm_failure
