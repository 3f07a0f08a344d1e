!> When a run writes checkpoints, and why it stops before its end: a limit given by the user, or a signal of a user or a batch
!> system.
!>
!> The first signal is stored; the run reads it where it can be stopped safely. A second SIGINT ends the program at once. Other
!> signals may repeat, as Slurm and srun each send a SIGTERM at the time limit: the run still has the time to write a checkpoint.
module hampm_interruption
   use, intrinsic :: iso_c_binding, only: c_funptr, c_funloc, c_int, c_intptr_t
   use hampm_kinds, only: dp, long
   use hampm_text, only: to_text
   implicit none
   private
   public :: interruption_t

   !> A signal that the program catches.
   type :: signal_t
      integer(c_int) :: number
      character(8) :: name
   end type signal_t

   ! Numbers of Linux on x86 and ARM
   type(signal_t), parameter :: watched(*) = [signal_t(1, 'SIGHUP'), signal_t(2, 'SIGINT'), signal_t(10, 'SIGUSR1'), &
                                              signal_t(12, 'SIGUSR2'), signal_t(15, 'SIGTERM'), signal_t(24, 'SIGXCPU')]
   integer(c_int), parameter :: by_keyboard = 2        !! SIGINT
   integer(c_int), parameter :: file_too_large = 25    !! SIGXFSZ: a write beyond the limit of the size of files
   integer(c_intptr_t), parameter :: by_default = 0, ignored = 1    !! SIG_DFL and SIG_IGN of C

   integer(c_int), volatile, save :: caught = 0        !! the first signal that has come, 0 for none

   interface
      type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
         import :: c_int, c_funptr
         integer(c_int), value :: number
         type(c_funptr), value :: handler
      end function c_signal
   end interface

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
      procedure :: elapsed
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

   !> Wall time since the start [s].
   real(dp) function elapsed(self)
      class(interruption_t), intent(in) :: self
      elapsed = seconds_since(self%clock_start)
   end function elapsed

   !> Wall time since a reading of the clock [s].
   real(dp) function seconds_since(earlier) result(seconds)
      integer(long), intent(in) :: earlier
      integer(long) :: now, rate
      call system_clock(now, rate)
      seconds = real(now - earlier, dp)/real(rate, dp)
   end function seconds_since

   !> Watch for signals from now on, except those that the program was started to ignore, as by nohup. A write beyond the size limit
   !> of files fails then and does not end the program.
   subroutine watch_signals()
      type(c_funptr) :: before
      integer :: k
      do k = 1, size(watched)
         before = c_signal(watched(k)%number, c_funloc(note_signal))
         if (transfer(before, ignored) == ignored) before = c_signal(watched(k)%number, before)
      end do
      before = c_signal(file_too_large, transfer(ignored, before))
   end subroutine watch_signals

   !> Name of the signal that has come; '' where none has.
   function stop_signal() result(name)
      character(:), allocatable :: name
      integer :: k
      name = ''
      do k = 1, size(watched)
         if (watched(k)%number == caught) name = trim(watched(k)%name)
      end do
   end function stop_signal

   !> Store the number of a signal: the handler of all.
   subroutine note_signal(number) bind(c)
      integer(c_int), value :: number
      type(c_funptr) :: before
      caught = number
      if (number == by_keyboard) before = c_signal(number, transfer(by_default, before))
   end subroutine note_signal
end module hampm_interruption
