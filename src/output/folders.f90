!> Folders for the results.
module hampm_folders
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
   use hampm_failure, only: failure_t, exit_file
   implicit none
   private
   public :: ensure_folder, is_folder

   integer(c_int), parameter :: everyone = int(o'777', c_int) !! permissions asked for; the user's mask limits them

   interface
      integer(c_int) function c_mkdir(path, mode) bind(c, name='mkdir')
         import :: c_char, c_int
         character(c_char), intent(in) :: path(*)
         integer(c_int), value :: mode
      end function c_mkdir
   end interface

contains

   !> Make the folder `path` and the folders above it where they do not exist. `exit_file` names the one that
   !> cannot be made.
   subroutine ensure_folder(path, failure)
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      integer :: last
      do last = 1, len_trim(path)
         if (.not. ends_a_name(path, last)) cycle
         call make_one(path(:last), failure)
         if (failure%failed()) return
      end do
   end subroutine ensure_folder

   !> Whether the name of a folder ends at this character of a path.
   pure logical function ends_a_name(path, last)
      character(*), intent(in) :: path
      integer, intent(in) :: last
      ends_a_name = path(last:last) /= '/'
      if (last < len_trim(path)) ends_a_name = ends_a_name .and. path(last + 1:last + 1) == '/'
   end function ends_a_name

   !> Make one folder, unless it is there; the folder above it exists.
   subroutine make_one(path, failure)
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      integer(c_int) :: status
      if (is_folder(path)) return
      status = c_mkdir(path//c_null_char, everyone)
      if (is_folder(path)) return
      call failure%report(exit_file, path//': the folder cannot be made: '//why_not(path))
   end subroutine make_one

   !> Whether `path` is a folder.
   logical function is_folder(path)
      character(*), intent(in) :: path
      inquire (file=path//'/.', exist=is_folder)
   end function is_folder

   !> Why a folder could not be made.
   function why_not(path) result(reason)
      character(*), intent(in) :: path
      character(:), allocatable :: reason
      logical :: taken
      inquire (file=path, exist=taken)
      if (taken) then
         reason = 'a file has this name, or a folder that may not be entered'
      else
         reason = 'no permission to write in the folder above it, or its disk is full'
      end if
   end function why_not
end module hampm_folders
