!> Whether the system starts as many threads as are wanted. The library of OpenMP ends the program where one cannot be started, with
!> a message of its own; so it is tried before.
module hampm_thread_probe
   use, intrinsic :: iso_c_binding, only: c_funloc, c_funptr, c_int, c_int64_t, c_null_ptr, c_ptr
   implicit none
   private
   public :: threads_that_start

   integer, parameter :: room = 16                      !! of `pthread_mutex_t`, in words of 8 bytes: more than any system takes

   integer(c_int64_t), save :: gate(room) = 0           !! PTHREAD_MUTEX_INITIALIZER: held until all threads are there

   interface
      integer(c_int) function c_thread_create(thread, attributes, start, argument) bind(c, name='pthread_create')
         import :: c_funptr, c_int, c_int64_t, c_ptr
         integer(c_int64_t), intent(out) :: thread
         type(c_ptr), value :: attributes
         type(c_funptr), value :: start
         type(c_ptr), value :: argument
      end function c_thread_create

      integer(c_int) function c_thread_join(thread, outcome) bind(c, name='pthread_join')
         import :: c_int, c_int64_t, c_ptr
         integer(c_int64_t), value :: thread
         type(c_ptr), value :: outcome
      end function c_thread_join

      integer(c_int) function c_lock(mutex) bind(c, name='pthread_mutex_lock')
         import :: c_int, c_int64_t
         integer(c_int64_t), intent(inout) :: mutex(*)
      end function c_lock

      integer(c_int) function c_unlock(mutex) bind(c, name='pthread_mutex_unlock')
         import :: c_int, c_int64_t
         integer(c_int64_t), intent(inout) :: mutex(*)
      end function c_unlock
   end interface

contains

   !> How many of the wanted threads can run at a time, with the present one; they are started and end at once.
   integer function threads_that_start(wanted) result(n)
      integer, intent(in) :: wanted
      integer(c_int64_t) :: threads(max(1, wanted))
      integer :: k
      integer(c_int) :: status
      status = c_lock(gate)
      do n = 1, wanted - 1
         if (c_thread_create(threads(n), c_null_ptr, c_funloc(pass_gate), c_null_ptr) /= 0) exit
      end do
      status = c_unlock(gate)
      do k = 1, n - 1
         status = c_thread_join(threads(k), c_null_ptr)
      end do
   end function threads_that_start

   !> What each thread does: it waits at the gate.
   type(c_ptr) function pass_gate(argument) bind(c, name='hampm_pass_gate')
      type(c_ptr), value :: argument
      integer(c_int) :: status
      status = c_lock(gate)
      status = c_unlock(gate)
      pass_gate = argument
   end function pass_gate
end module hampm_thread_probe
