!> The memory and the stack that this process may use, as Linux tells it in files.
module hampm_memory
   use hampm_kinds, only: dp
   implicit none
   private
   public :: memory_there_is, room_for_algebra, stack_there_is, least_stack

   real(dp), parameter :: unknown = -1
   real(dp), parameter :: of_algebra = 3.2e8_dp  !! address space that OpenBLAS and its thread take at first use, or wait for [bytes]
   real(dp), parameter :: least_stack = 1048576  !! five times what the program and its threads have taken of it at most [bytes]

contains

   !> The least of what the machine has and of what this process or its group of processes is allowed [bytes]; huge where
   !> nothing tells. A limit on the address space counts what the program and its libraries have mapped already.
   real(dp) function memory_there_is() result(bytes)
      real(dp), parameter :: kilobyte = 1024
      real(dp) :: limit
      bytes = huge(bytes)
      call take(kilobyte*number_behind('/proc/meminfo', 'MemTotal:'))
      call take(number_behind('/sys/fs/cgroup/memory.max', ''))
      call take(number_behind('/sys/fs/cgroup/memory/memory.limit_in_bytes', ''))
      limit = number_behind('/proc/self/limits', 'Max address space')
      if (limit > 0) call take(max(1.0_dp, limit - kilobyte*number_behind('/proc/self/status', 'VmSize:') - of_algebra))

   contains

      !> Take a limit over where it is lower than those so far; 0 and below is none.
      subroutine take(limit)
         real(dp), intent(in) :: limit
         if (limit > 0) bytes = min(bytes, limit)
      end subroutine take
   end function memory_there_is

   !> Whether the library of linear algebra can take the room that it asks for at its first use. Where it cannot, it waits for ever.
   logical function room_for_algebra()
      room_for_algebra = memory_there_is() > 1
   end function room_for_algebra

   !> The limit of the stack [bytes]; huge where there is none or nothing tells.
   real(dp) function stack_there_is() result(bytes)
      bytes = number_behind('/proc/self/limits', 'Max stack size')
      if (bytes < 0) bytes = huge(bytes)
   end function stack_there_is

   !> The number behind a label that begins a line of a file; negative where there is no file, line or number.
   real(dp) function number_behind(path, label) result(number)
      character(*), intent(in) :: path, label
      character(*), parameter :: blank = ' '//achar(9)
      character(200) :: line
      integer :: unit, status
      number = unknown
      open (newunit=unit, file=path, status='old', action='read', iostat=status)
      if (status /= 0) return
      do
         read (unit, '(a)', iostat=status) line
         if (status /= 0) exit
         if (index(line, label) /= 1) cycle
         if (verify(line(len(label) + 1:), blank) == 0) exit
         line = line(len(label) + 1:)
         line = line(verify(line, blank):)
         line = line(:scan(line, blank) - 1)
         if (line /= '' .and. verify(trim(line), '0123456789') == 0) read (line, *, iostat=status) number
         exit
      end do
      close (unit)
   end function number_behind
end module hampm_memory
