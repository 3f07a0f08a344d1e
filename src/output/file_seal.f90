!> A seal at the end of a file: a checksum over all that is before it. A file that has changed since it was sealed, by a bit or more, is
!> told from one that has not, before anybody makes anything of what it says.
!>
!> The checksum is the cyclic redundancy check of 64 bits with the polynomial of ECMA-182, which finds every change within 64 bits that
!> follow each other, and any other but for one in 2**64. HDF5 does not look at what follows its own end of a file.
module hampm_file_seal
   use, intrinsic :: iso_fortran_env, only: int8
   use hampm_kinds, only: long
   use hampm_failure, only: failure_t, exit_file
   implicit none
   private
   public :: seal_file, seal_of_file, no_seal, whole, broken

   ! What the seal of a file says
   integer, parameter :: no_seal = 0, whole = 1, broken = 2

   character(8), parameter :: mark = 'HMPMSEAL'
   integer, parameter :: seal_size = 16                 !! bytes: the checksum and the mark
   integer, parameter :: piece = 2**16                  !! bytes that are read at a time
   integer(long), parameter :: polynomial = int(z'42F0E1EBA9EA3693', long)
   integer, parameter :: bits = 64, byte = 8

contains

   !> Put a seal at the end of a file that is closed. `exit_file` where it cannot be written.
   subroutine seal_file(path, failure)
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      integer(long) :: size_of, checksum
      integer :: unit, status
      open (newunit=unit, file=path, access='stream', form='unformatted', action='readwrite', status='old', iostat=status)
      if (status == 0) then
         inquire (unit=unit, size=size_of)
         call find_checksum(unit, size_of, checksum, status)
         if (status == 0) write (unit, pos=size_of + 1, iostat=status) checksum, mark
         if (status == 0) then
            close (unit, iostat=status)
         else
            close (unit)
         end if
      end if
      if (status /= 0) call failure%report(exit_file, path//': cannot be written')
   end subroutine seal_file

   !> What the seal of a file says: `no_seal` also where it cannot be read.
   integer function seal_of_file(path) result(found)
      character(*), intent(in) :: path
      integer(long) :: size_of, stored, checksum
      character(len(mark)) :: ending
      integer :: unit, status
      found = no_seal
      open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old', iostat=status)
      if (status /= 0) return
      inquire (unit=unit, size=size_of)
      if (size_of > seal_size) then
         read (unit, pos=size_of - seal_size + 1, iostat=status) stored, ending
         if (status == 0 .and. ending == mark) then
            call find_checksum(unit, size_of - seal_size, checksum, status)
            if (status == 0) found = merge(whole, broken, checksum == stored)
         end if
      end if
      close (unit)
   end function seal_of_file

   !> The checksum of the first bytes of an open file.
   subroutine find_checksum(unit, size_of, checksum, status)
      integer, intent(in) :: unit
      integer(long), intent(in) :: size_of       !! how many bytes
      integer(long), intent(out) :: checksum
      integer, intent(out) :: status             !! of the last reading
      integer(long) :: table(0:255), done
      integer(int8) :: bytes(piece)
      integer :: i, n
      table = [(remainder_of(int(i, long)), i=0, 255)]
      checksum = 0
      done = 0
      status = 0
      do while (done < size_of .and. status == 0)
         n = int(min(int(piece, long), size_of - done))
         read (unit, pos=done + 1, iostat=status) bytes(:n)
         do i = 1, n
            checksum = ieor(ishft(checksum, byte), &
                            table(iand(ieor(ishft(checksum, byte - bits), int(bytes(i), long)), 255_long)))
         end do
         done = done + n
      end do
   end subroutine find_checksum

   !> The remainder of a byte at the front.
   pure integer(long) function remainder_of(value) result(rest)
      integer(long), intent(in) :: value
      integer :: k
      rest = ishft(value, bits - byte)
      do k = 1, byte
         if (rest < 0) then
            rest = ieor(ishft(rest, 1), polynomial)
         else
            rest = ishft(rest, 1)
         end if
      end do
   end function remainder_of
end module hampm_file_seal
