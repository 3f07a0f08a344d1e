!> Files found under the names that a run will write, remove or replace. Only files that a run has left are its own: HDF5 files,
!> files that a killed run has begun, and empty locks. Any other, such as the namelist of the run, stays, whatever leads to it:
!> another spelling, a link, a folder or --force.
module hampm_old_files
   use hampm_checkpoint, only: checkpoint_name
   use hampm_failure, only: failure_t, exit_file
   use hampm_file_moves, only: file_exists, partial_name
   use hampm_folders, only: is_folder
   use hampm_results, only: last_name
   use hampm_run_lock, only: lock_name
   use hampm_text, only: string_t
   implicit none
   private
   public :: refuse_files_of_others

   character(*), parameter :: hdf5_mark = char(137)//'HDF'//achar(13)//achar(10)//achar(26)//achar(10)
   character(*), parameter :: not_yet_written = repeat(achar(0), len(hdf5_mark))

contains

   !> Refuse to write a result where one of the files that belong to it is another's.
   subroutine refuse_files_of_others(path, failure)
      character(*), intent(in) :: path           !! of the result
      type(failure_t), intent(inout) :: failure
      type(string_t) :: names(6)
      character(:), allocatable :: reason
      integer :: k
      names(1)%text = path
      names(2)%text = partial_name(path)
      names(3)%text = last_name(path)
      names(4)%text = checkpoint_name(path)
      names(5)%text = partial_name(checkpoint_name(path))
      names(6)%text = lock_name(path)
      do k = 1, size(names)
         if (is_of_a_run(names(k)%text, reason)) cycle
         if (reason /= '') then
            call failure%report(exit_file, names(k)%text//': cannot be read: '//reason)
            return
         end if
         call failure%report(exit_file, names(k)%text//': there is another file than hampm writes, which is not replaced, '// &
                             'by --force neither. Use another &output file or --output')
         return
      end do
   end subroutine refuse_files_of_others

   !> Whether there is no file of this name, or one that a run may have left. Of folders others tell.
   logical function is_of_a_run(name, reason)
      character(*), intent(in) :: name
      character(:), allocatable, intent(out) :: reason   !! why this cannot be known; '' where it is
      character(len(hdf5_mark)) :: begin
      character(500) :: message
      integer :: unit, status, bytes
      reason = ''
      is_of_a_run = .true.
      if (.not. file_exists(name)) return
      if (is_folder(name)) return
      is_of_a_run = .false.
      open (newunit=unit, file=name, access='stream', form='unformatted', action='read', status='old', iostat=status, iomsg=message)
      if (status /= 0) then
         reason = trim(message)
         return
      end if
      inquire (unit=unit, size=bytes)
      is_of_a_run = bytes <= 0
      if (bytes >= len(begin)) then
         read (unit, iostat=status) begin
         is_of_a_run = status == 0 .and. (begin == hdf5_mark .or. begin == not_yet_written)
      end if
      close (unit)
   end function is_of_a_run
end module hampm_old_files
