!> Signals with which a user or a batch system asks the program to stop. The first one is remembered, to be looked at where the run
!> can be stopped well. A second SIGINT, by which an impatient user means it, ends the program at once. Others may come again, as
!> Slurm and srun each send a SIGTERM at the limit of time: the run still has the time to write a checkpoint.
module hampm_signals
   use, intrinsic :: iso_c_binding, only: c_funptr, c_funloc, c_int, c_intptr_t
   implicit none
   private
   public :: watch_signals, stop_signal

   !> A signal that is looked out for.
   type :: signal_t
      integer(c_int) :: number
      character(8) :: name
   end type signal_t

   ! The numbers are those of Linux on x86 and ARM
   type(signal_t), parameter :: watched(*) = [signal_t(1, 'SIGHUP'), signal_t(2, 'SIGINT'), signal_t(10, 'SIGUSR1'), &
                                              signal_t(12, 'SIGUSR2'), signal_t(15, 'SIGTERM'), signal_t(24, 'SIGXCPU')]
   integer(c_int), parameter :: by_keyboard = 2        !! SIGINT
   integer(c_int), parameter :: file_too_large = 25    !! SIGXFSZ: a write beyond the limit of the size of files
   integer(c_intptr_t), parameter :: by_default = 0, ignored = 1    !! what C calls SIG_DFL and SIG_IGN

   integer(c_int), volatile, save :: caught = 0        !! the first signal that has come, 0 for none

   interface
      type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
         import :: c_int, c_funptr
         integer(c_int), value :: number
         type(c_funptr), value :: handler
      end function c_signal
   end interface

contains

   !> Watch for signals from now on, but for those that the program was started to ignore, as by nohup. A write that exceeds the
   !> allowed size of a file is to fail and not to kill.
   subroutine watch_signals()
      type(c_funptr) :: before
      integer :: k
      do k = 1, size(watched)
         before = c_signal(watched(k)%number, c_funloc(remember))
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

   !> What happens when a signal comes.
   subroutine remember(number) bind(c)
      integer(c_int), value :: number
      type(c_funptr) :: before
      caught = number
      if (number == by_keyboard) before = c_signal(number, transfer(by_default, before))
   end subroutine remember
end module hampm_signals
