!> Files that replace others as a whole: a reader of a name finds the old file or the new one, and never a part of it, whenever the
!> program or the computer stops.
module hampm_file_moves
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
   use, intrinsic :: iso_fortran_env, only: int8
   use hampm_kinds, only: long
   use hampm_failure, only: failure_t, exit_file
   implicit none
   private
   public :: partial_name, file_exists, replace_file, give_second_name, rename_file, copy_file, remove_file, &
             c_open, c_close

   character(*), parameter :: partial_ending = '.part'
   integer(c_int), parameter :: read_only = 0           !! O_RDONLY
   integer, parameter :: piece = 2**20                  !! bytes that are copied at a time

   interface
      integer(c_int) function c_rename(from, to) bind(c, name='rename')
         import :: c_char, c_int
         character(c_char), intent(in) :: from(*), to(*)
      end function c_rename

      integer(c_int) function c_link(from, to) bind(c, name='link')
         import :: c_char, c_int
         character(c_char), intent(in) :: from(*), to(*)
      end function c_link

      integer(c_int) function c_unlink(path) bind(c, name='unlink')
         import :: c_char, c_int
         character(c_char), intent(in) :: path(*)
      end function c_unlink

      integer(c_int) function c_open(path, flags) bind(c, name='open')
         import :: c_char, c_int
         character(c_char), intent(in) :: path(*)
         integer(c_int), value :: flags
      end function c_open

      integer(c_int) function c_fsync(descriptor) bind(c, name='fsync')
         import :: c_int
         integer(c_int), value :: descriptor
      end function c_fsync

      integer(c_int) function c_close(descriptor) bind(c, name='close')
         import :: c_int
         integer(c_int), value :: descriptor
      end function c_close
   end interface

contains

   !> Name under which a file is written until it is whole.
   pure function partial_name(path) result(name)
      character(*), intent(in) :: path
      character(:), allocatable :: name
      name = path//partial_ending
   end function partial_name

   !> Whether there is a file or folder of this name.
   logical function file_exists(path)
      character(*), intent(in) :: path
      inquire (file=path, exist=file_exists)
   end function file_exists

   !> Rename a complete file, written under its partial name and closed, once it is on the disk. `exit_file` where that is
   !> impossible; the old file is kept then.
   subroutine replace_file(path, failure)
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      if (is_on_disk(partial_name(path))) then
         if (rename_file(partial_name(path), path)) return
      end if
      call failure%report(exit_file, path//': cannot be written: '//partial_name(path)//' cannot be put in its place '// &
                          '(is the disk full, or the folder read-only?)')
   end subroutine replace_file

   !> Hand a file to the disk.
   logical function is_on_disk(path)
      character(*), intent(in) :: path
      integer(c_int) :: descriptor, status
      descriptor = c_open(path//c_null_char, read_only)
      is_on_disk = descriptor >= 0
      if (.not. is_on_disk) return
      is_on_disk = c_fsync(descriptor) == 0
      status = c_close(descriptor)
   end function is_on_disk

   !> Rename a file, in the place of one that has the name; false where that is impossible.
   logical function rename_file(from, to) result(done)
      character(*), intent(in) :: from, to
      done = c_rename(from//c_null_char, to//c_null_char) == 0
   end function rename_file

   !> Give a file a second name, which takes no room; false where the file system cannot do that.
   logical function give_second_name(path, second) result(done)
      character(*), intent(in) :: path, second
      call remove_file(second)
      done = c_link(path//c_null_char, second//c_null_char) == 0
   end function give_second_name

   !> Remove a file, if there is one.
   subroutine remove_file(path)
      character(*), intent(in) :: path
      integer(c_int) :: status
      status = c_unlink(path//c_null_char)
   end subroutine remove_file

   !> Copy a file to a new one. `exit_file` where that is impossible.
   subroutine copy_file(from, to, failure)
      character(*), intent(in) :: from, to
      type(failure_t), intent(inout) :: failure
      integer(int8), allocatable :: bytes(:)
      integer(long) :: length, done
      character(512) :: message
      integer :: source, copy, status
      call remove_file(to)                       ! and not its contents: they may have another name
      open (newunit=source, file=from, access='stream', action='read', status='old', iostat=status, iomsg=message)
      if (status /= 0) then
         call failure%report(exit_file, from//': cannot be read: '//trim(message))
         return
      end if
      inquire (unit=source, size=length)
      allocate (bytes(piece))
      open (newunit=copy, file=to, access='stream', action='write', status='replace', iostat=status, iomsg=message)
      done = 0
      do while (status == 0 .and. done < length)
         associate (n => int(min(int(piece, long), length - done)))
            read (source, iostat=status, iomsg=message) bytes(:n)
            if (status == 0) write (copy, iostat=status, iomsg=message) bytes(:n)
            done = done + n
         end associate
      end do
      close (source)
      if (status == 0) close (copy, iostat=status, iomsg=message)
      if (status == 0) return
      call remove_file(to)
      call failure%report(exit_file, to//': cannot be written: '//trim(message))
   end subroutine copy_file
end module hampm_file_moves
