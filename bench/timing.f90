!> What the benchmarks measure with: two clocks, the memory's speed for the bytes that they move, its size, and medians.
module hampm_timing
   use hampm_kinds, only: dp, long
   implicit none
   private
   public :: processor_seconds, wall_seconds, time_to_move, peak_memory, median

   abstract interface
      !> A clock [s].
      real(dp) function clock()
         import :: dp
      end function clock
   end interface

contains

   !> Processor time of all threads [s].
   real(dp) function processor_seconds()
      call cpu_time(processor_seconds)
   end function processor_seconds

   !> Wall time [s].
   real(dp) function wall_seconds()
      integer(long) :: ticks, rate
      call system_clock(ticks, rate)
      wall_seconds = real(ticks, dp)/real(rate, dp)
   end function wall_seconds

   !> Time to read half and write half of `bytes` for each of `n` items, mean of `steps` times [s].
   real(dp) function time_to_move(n, bytes, steps, seconds) result(time)
      integer, intent(in) :: n, bytes, steps
      procedure(clock) :: seconds
      real(dp), allocatable, save :: from(:), to(:)
      integer(long) :: words, i
      integer :: k
      words = int(n, long)*bytes/16
      if (allocated(from)) then
         if (size(from, kind=long) /= words) deallocate (from, to)
      end if
      if (.not. allocated(from)) allocate (from(words), to(words), source=0.0_dp)
      time = seconds()
      do k = 1, steps
         !$omp parallel do schedule(static)
         do i = 1, words
            to(i) = from(i) + k
         end do
      end do
      time = (seconds() - time)/steps
      if (to(words) < 0) print *, to(words)      ! the copy is used
   end function time_to_move

   !> The most memory that this program has held so far [bytes], 0 where the system does not tell.
   integer(long) function peak_memory() result(bytes)
      integer :: unit, status
      character(80) :: line
      bytes = 0
      open (newunit=unit, file='/proc/self/status', action='read', iostat=status)
      do while (status == 0)
         read (unit, '(a)', iostat=status) line
         if (line(:6) /= 'VmHWM:') cycle
         read (line(7:index(line, 'kB') - 1), *) bytes
         bytes = 1024*bytes
         exit
      end do
      close (unit, iostat=status)
   end function peak_memory

   !> Median of a few numbers.
   pure real(dp) function median(values)
      real(dp), intent(in) :: values(:)
      real(dp) :: rest(size(values))
      integer :: k
      rest = values
      do k = 1, size(values)/2
         rest(maxloc(rest, dim=1)) = -huge(median)
      end do
      median = maxval(rest)
   end function median
end module hampm_timing
