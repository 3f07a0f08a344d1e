!> What the benchmarks measure with: the memory's speed for the bytes that they move, and medians.
module hampm_timing
   use hampm_kinds, only: dp, long
   implicit none
   private
   public :: time_to_move, median

   abstract interface
      !> A clock [s].
      real(dp) function clock()
         import :: dp
      end function clock
   end interface

contains

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
