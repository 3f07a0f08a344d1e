!> The threads and the host that a run uses.
!>
!> Whether the system starts as many threads as are wanted. The library of OpenMP ends the program where one cannot be started, with
!> a message of its own; so it is tried before.
module hampm_threads
   use, intrinsic :: iso_c_binding, only: c_int, c_long, c_size_t, c_char, c_null_char, c_funloc, c_funptr, c_int64_t, &
                                          c_null_ptr, c_ptr
   use hampm_failure, only: failure_t, exit_input
   use hampm_text, only: to_text
   !$ use omp_lib, only: omp_set_num_threads, omp_get_max_threads, omp_get_num_procs
   implicit none
   private
   public :: check_threads, surplus_threads, use_threads, thread_count, thread_report, processor_count, host_name

   integer, parameter :: room = 16                      !! of `pthread_mutex_t`, in words of 8 bytes: more than any system takes

   integer(c_int64_t), save :: gate(room) = 0           !! PTHREAD_MUTEX_INITIALIZER: held until all threads are there
   character(:), allocatable, save :: reason            !! why there are as many threads as there are

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

   integer, parameter :: particles_per_thread = 50000   !! with fewer, a further thread costs more than it gives

   interface
      integer(c_long) function c_sysconf(name) bind(c, name='sysconf')
         import :: c_int, c_long
         integer(c_int), value :: name
      end function c_sysconf

      integer(c_int) function c_gethostname(name, length) bind(c, name='gethostname')
         import :: c_int, c_size_t, c_char
         character(kind=c_char), intent(out) :: name(*)
         integer(c_size_t), value :: length
      end function c_gethostname
   end interface

contains

   !> Use the wanted number of threads; 0 takes the number of the environment. Fails where the system cannot start as many.
   subroutine check_threads(wanted, failure)
      integer, intent(in) :: wanted
      type(failure_t), intent(inout) :: failure
      integer :: n
      if (wanted > 0) call use_threads(wanted, 0)
      n = threads_that_start(thread_count())
      if (n >= thread_count()) return
      call failure%report(exit_input, to_text(thread_count())//' threads cannot be started, but '//to_text(n)// &
                          ': use fewer (--threads, OMP_NUM_THREADS), or allow more processes or memory (ulimit -u, ulimit -v)')
   end subroutine check_threads

   !> A warning where more threads are wanted than there are processors: in each step all threads wait for one without a processor.
   function surplus_threads(wanted) result(warning)
      integer, intent(in) :: wanted
      character(:), allocatable :: warning
      warning = ''
      if (wanted > processor_count()) &
         warning = to_text(wanted)//' threads share '//to_text(processor_count())//' processors, and wait for each other in '// &
                   'every step: --threads '//to_text(processor_count())//' is faster'
   end function surplus_threads

   !> Use `wanted` threads from now on; 0 takes as many as the particles keep busy, up to the number of free processors and to the
   !> number of the environment (OMP_NUM_THREADS).
   subroutine use_threads(wanted, particles)
      integer, intent(in) :: wanted
      integer, intent(in) :: particles
      integer, save :: most = 0                  ! in the environment
      integer :: n
      if (most == 0) most = thread_count()
      n = wanted
      reason = 'as --threads says'
      if (n == 0) then
         n = max(1, particles/particles_per_thread)
         reason = 'for '//to_text(particles)//' particles'
         call limit(most, 'as OMP_NUM_THREADS and the processors allow')
         call limit(free_processors(), 'as other processes are busy')
      end if
      !$ call omp_set_num_threads(n)
   contains
      !> Take no more than so many, and know why.
      subroutine limit(available, cause)
         integer, intent(in) :: available
         character(*), intent(in) :: cause
         if (available >= n) return
         n = available
         reason = cause
      end subroutine limit
   end subroutine use_threads

   !> How many threads there are, and why.
   function thread_report() result(text)
      character(:), allocatable :: text
      text = to_text(thread_count())//' thread'//trim(merge(' ', 's', thread_count() == 1))//', '//reason
   end function thread_report

   !> Number of processors that other processes leave free now, 1 at least; all where the system does not tell, or where this
   !> process has only some of the processors, whose load the system does not tell.
   integer function free_processors() result(free)
      integer, parameter :: processors_online = 84  ! _SC_NPROCESSORS_ONLN of Linux
      character(80) :: line                      ! mean loads, processes that run / all, last process: 0.20 0.18 0.12 1/80 11206
      integer :: unit, status, running, first
      free = processor_count()
      if (c_sysconf(int(processors_online, c_int)) /= free) return
      open (newunit=unit, file='/proc/loadavg', status='old', action='read', iostat=status)
      if (status /= 0) return
      read (unit, '(a)', iostat=status) line
      close (unit)
      if (status /= 0) return
      first = index(line(:index(line, '/')), ' ', back=.true.)
      read (line(first + 1:max(first, index(line, '/') - 1)), *, iostat=status) running
      if (status == 0) free = max(1, free - max(0, running - 1)) ! this process runs
   end function free_processors

   !> Number of threads in use.
   integer function thread_count()
      thread_count = 1
      !$ thread_count = omp_get_max_threads()
   end function thread_count

   !> Number of processors that this program may use.
   integer function processor_count()
      processor_count = 1
      !$ processor_count = omp_get_num_procs()
   end function processor_count

   !> Name of this computer, '' where it has none.
   function host_name() result(name)
      character(:), allocatable :: name
      integer(c_size_t), parameter :: longest = 256
      character(kind=c_char) :: buffer(longest)
      integer :: k
      name = ''
      if (c_gethostname(buffer, longest) /= 0) return
      do k = 1, int(longest)
         if (buffer(k) == c_null_char) exit
         name = name//buffer(k)
      end do
   end function host_name

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

   !> Body of each thread: it waits at the gate.
   type(c_ptr) function pass_gate(argument) bind(c, name='hampm_pass_gate')
      type(c_ptr), value :: argument
      integer(c_int) :: status
      status = c_lock(gate)
      status = c_unlock(gate)
      pass_gate = argument
   end function pass_gate
end module hampm_threads
