!> When a run writes checkpoints, and why it stops before its end: at a limit that the user gave, or by a signal of a user or
!> a batch system.
module hampm_interruption
   use hampm_kinds, only: dp, long
   use hampm_signals, only: watch_signals, stop_signal
   use hampm_text, only: to_text
   implicit none
   private
   public :: interruption_t

   !> The limits of a run, and when it last wrote a checkpoint.
   type :: interruption_t
      real(dp) :: interval = 0                   !! wall time between checkpoints [s]; 0: none
      integer :: every_steps = 0                 !! steps between checkpoints; 0: none
      real(dp) :: time_limit = 0                 !! wall time of this run [s]; 0: no limit
      integer(long) :: step_limit = 0            !! steps of this run; 0: no limit
      integer(long), private :: clock_start = 0, clock_last = 0 !! ticks at the start and at the last checkpoint
      integer(long), private :: first_step = 0, last_step = 0   !! steps done then
   contains
      procedure :: start
      procedure :: wants_checkpoint
      procedure :: note_checkpoint
      procedure :: reason_to_stop
   end type interruption_t

contains

   !> Begin to count and to watch for signals.
   subroutine start(self, step)
      class(interruption_t), intent(inout) :: self
      integer(long), intent(in) :: step          !! steps done before this run
      call watch_signals()
      call system_clock(self%clock_start)
      self%clock_last = self%clock_start
      self%first_step = step
      self%last_step = step
   end subroutine start

   !> Whether it is time for a checkpoint.
   logical function wants_checkpoint(self, step) result(wants)
      class(interruption_t), intent(in) :: self
      integer(long), intent(in) :: step
      wants = .false.
      if (self%every_steps > 0) wants = step - self%last_step >= self%every_steps
      if (.not. wants .and. self%interval > 0) wants = seconds_since(self%clock_last) >= self%interval
   end function wants_checkpoint

   !> A checkpoint has been written; the time of the next one is counted from now.
   subroutine note_checkpoint(self, step)
      class(interruption_t), intent(inout) :: self
      integer(long), intent(in) :: step
      call system_clock(self%clock_last)
      self%last_step = step
   end subroutine note_checkpoint

   !> Why the run is to stop now; '' where it is not.
   function reason_to_stop(self, step) result(reason)
      class(interruption_t), intent(in) :: self
      integer(long), intent(in) :: step
      character(:), allocatable :: reason
      reason = stop_signal()
      if (reason /= '') return
      if (self%step_limit > 0 .and. step - self%first_step >= self%step_limit) then
         reason = '--steps '//to_text(self%step_limit)
      else if (self%time_limit > 0) then
         if (seconds_since(self%clock_start) >= self%time_limit) reason = '--time-limit '//to_text(self%time_limit)
      end if
   end function reason_to_stop

   !> Wall time since a reading of the clock [s].
   real(dp) function seconds_since(earlier) result(seconds)
      integer(long), intent(in) :: earlier
      integer(long) :: now, rate
      call system_clock(now, rate)
      seconds = real(now - earlier, dp)/real(rate, dp)
   end function seconds_since
end module hampm_interruption
