!> The file of a checkpoint. What a run has to remember is kept in it item by item; one list of items serves for writing and for
!> reading, where each item gets the value that it had.
!>
!> The file is written under a partial name, sealed with a checksum over all of it, and put in its place whole. Reading fails, and says
!> why, where the file is none of this program or of another version, has changed by a bit or more, or does not fit the scene.
!>
!> A seal at the end of a file: a checksum over all that is before it. A file that has changed since it was sealed, by a bit or more, is
!> told from one that has not, before anybody makes anything of what it says.
!>
!> The checksum is the cyclic redundancy check of 64 bits with the polynomial of ECMA-182, which finds every change within 64 bits that
!> follow each other, and any other but for one in 2**64. HDF5 does not look at what follows its own end of a file.
module hampm_checkpoint
   use, intrinsic :: iso_fortran_env, only: int8
   use hampm_kinds, only: dp, long
   use hampm_archive, only: archive_t
   use hampm_failure, only: failure_t, exit_file
   use hampm_file_moves, only: partial_name, replace_file, remove_file, file_exists
   use hampm_hdf5_file, only: hdf5_file_t
   use hampm_text, only: to_text
   use hampm_version, only: version
   implicit none
   private
   public :: checkpoint_t, checkpoint_name

   ! What the seal of a file says
   integer, parameter :: no_seal = 0, whole = 1, broken = 2

   character(8), parameter :: mark = 'HMPMSEAL'
   integer, parameter :: seal_size = 16                 !! bytes: the checksum and the mark
   integer, parameter :: piece = 2**16                  !! bytes that are read at a time
   integer(long), parameter :: polynomial = int(z'42F0E1EBA9EA3693', long)
   integer, parameter :: bits = 64, byte = 8

   integer, parameter :: format = 22            !! of the file: to be raised with each change of what is kept
   character(*), parameter :: format_name = 'hampm checkpoint'

   !> A checkpoint that is being written or read.
   type, extends(archive_t) :: checkpoint_t
      type(hdf5_file_t), private :: file
      character(:), allocatable, private :: path
      character(:), allocatable, private :: group  !! of the next items, '/group/'
   contains
      procedure :: create
      procedure :: open => open_checkpoint
      procedure :: finish
      procedure :: section
      procedure :: keep_text
      procedure :: keep_reals
      procedure :: keep_longs
      procedure :: refuse
   end type checkpoint_t

contains

   !> Name of the checkpoint of a result.
   pure function checkpoint_name(result_path) result(path)
      character(*), intent(in) :: result_path
      character(:), allocatable :: path
      path = result_path//'.checkpoint'
   end function checkpoint_name

   !> Begin to write a checkpoint.
   subroutine create(self, path)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: path
      character(:), allocatable :: text
      integer :: number
      self%path = path
      self%group = '/'
      self%is_read = .false.
      call self%file%create(partial_name(path), self%failure)
      text = format_name
      call self%keep_text('kind', text)
      number = format
      call self%keep('format', number)
      text = version
      call self%keep_text('version', text)
   end subroutine create

   !> Begin to read a checkpoint. `exit_file` where it is none, or not one that this program has written.
   subroutine open_checkpoint(self, path)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: path
      character(:), allocatable :: found, by
      integer :: number, seal
      self%path = path
      self%group = '/'
      self%is_read = .true.
      if (.not. file_exists(path)) then
         call self%failure%report(exit_file, path//': cannot be read: there is no such file')
         return
      end if
      seal = seal_of_file(path)
      if (seal == broken) then
         call self%refuse('it has changed since it was written: its checksum does not fit')
         return
      end if
      call self%file%open(path, self%failure)
      if (self%failure%failed()) return
      found = ''
      number = 0
      if (self%file%holds('/kind')) call self%keep_text('kind', found)
      if (found /= format_name) then
         call self%refuse('it is no checkpoint of hampm')
         return
      end if
      call self%keep('format', number)
      call self%keep_text('version', by)
      if (self%failure%failed()) return
      if (by /= version .or. number /= format) then
         call self%refuse('it was written by hampm '//by//' (format '//to_text(number)//'), this is hampm '//version// &
                          ' (format '//to_text(format)//'); resume the run with the program that began it')
      else if (seal /= whole) then
         call self%refuse('it is not whole: the checksum at its end is missing')
      end if
   end subroutine open_checkpoint

   !> Close the file; one that was written is put in its place if nothing has failed, and else removed.
   subroutine finish(self, failure)
      class(checkpoint_t), intent(inout) :: self
      type(failure_t), intent(inout) :: failure
      logical :: was_begun
      was_begun = self%file%is_open() .and. .not. self%is_read
      call self%file%close(self%failure)
      if (was_begun .and. .not. self%failure%failed()) call seal_file(partial_name(self%path), self%failure)
      if (was_begun .and. .not. self%failure%failed()) call replace_file(self%path, self%failure)
      if (was_begun .and. self%failure%failed()) call remove_file(partial_name(self%path))
      if (self%failure%failed()) call failure%report(self%failure%code, self%failure%message)
   end subroutine finish

   !> The items that follow belong together.
   subroutine section(self, name)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      self%group = '/'//name//'/'
      if (.not. self%is_read .and. .not. self%failure%failed()) call self%file%make_group('/'//name, self%failure)
   end subroutine section

   !> Fail because what was read cannot be right.
   subroutine refuse(self, why)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: why
      call self%failure%report(exit_file, self%path//': cannot be resumed: '//why)
   end subroutine refuse

   !> Keep a text.
   subroutine keep_text(self, name, text)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      character(:), allocatable, intent(inout) :: text
      if (self%failure%failed()) return
      if (self%is_read) then
         call self%file%get(self%group//name, text, self%failure)
      else
         call self%file%put(self%group//name, text, self%failure)
      end if
   end subroutine keep_text

   !> Keep the first `n` elements of an array of reals of any shape.
   subroutine keep_reals(self, name, n, values)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: n
      real(dp), intent(inout) :: values(n)
      call keep_vector(self, name, values)
   end subroutine keep_reals

   !> Keep the first `n` elements of an array of long integers of any shape.
   subroutine keep_longs(self, name, n, values)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: n
      integer(long), intent(inout) :: values(n)
      call keep_vector(self, name, values)
   end subroutine keep_longs

   !> Keep a vector. What is read has to be as long.
   subroutine keep_vector(self, name, values)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      class(*), intent(inout), target, contiguous :: values(:)
      integer :: found
      if (self%failure%failed()) return
      if (.not. self%is_read) then
         call self%file%put(self%group//name, values, self%failure)
         return
      end if
      call self%file%get(self%group//name, values, found, self%failure)
      if (.not. self%failure%failed() .and. found /= size(values)) &
         call self%refuse(self%group//name//' has '//to_text(found)//' values, not '//to_text(size(values)))
   end subroutine keep_vector

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
end module hampm_checkpoint
