!> The file of a checkpoint. What a run has to remember is kept in it item by item; one list of items serves for writing and for
!> reading, where each item gets the value that it had.
!>
!> The file is written under a partial name, sealed with a checksum over all of it, and put in its place whole. Reading fails, and says
!> why, where the file is none of this program or of another version, has changed by a bit or more, or does not fit the scene.
module hampm_checkpoint
   use hampm_kinds, only: dp, long
   use hampm_archive, only: archive_t
   use hampm_failure, only: failure_t, exit_file
   use hampm_file_seal, only: seal_file, seal_of_file, whole, broken
   use hampm_file_moves, only: partial_name, replace_file, remove_file, file_exists
   use hampm_hdf5_file, only: hdf5_file_t
   use hampm_text, only: to_text
   use hampm_version, only: version
   implicit none
   private
   public :: checkpoint_t, checkpoint_name

   integer, parameter :: format = 13            !! of the file: to be raised with each change of what is kept
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
      procedure :: keep_integers
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
      call self%keep('kind', text)
      number = format
      call self%keep('format', number)
      text = version
      call self%keep('version', text)
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
      if (self%file%holds('/kind')) call self%keep('kind', found)
      if (found /= format_name) then
         call self%refuse('it is no checkpoint of hampm')
         return
      end if
      call self%keep('format', number)
      call self%keep('version', by)
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
      real(dp), allocatable :: found(:)
      if (self%failure%failed()) return
      if (.not. self%is_read) then
         call self%file%put(self%group//name, values, self%failure)
         return
      end if
      call self%file%get(self%group//name, found, self%failure)
      if (fits(self, name, n, size(found))) values = found
   end subroutine keep_reals

   !> Keep the first `n` elements of an array of integers of any shape.
   subroutine keep_integers(self, name, n, values)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: n
      integer, intent(inout) :: values(n)
      integer, allocatable :: found(:)
      if (self%failure%failed()) return
      if (.not. self%is_read) then
         call self%file%put(self%group//name, values, self%failure)
         return
      end if
      call self%file%get(self%group//name, found, self%failure)
      if (fits(self, name, n, size(found))) values = found
   end subroutine keep_integers

   !> Keep the first `n` elements of an array of long integers of any shape.
   subroutine keep_longs(self, name, n, values)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: n
      integer(long), intent(inout) :: values(n)
      integer(long), allocatable :: found(:)
      if (self%failure%failed()) return
      if (.not. self%is_read) then
         call self%file%put(self%group//name, values, self%failure)
         return
      end if
      call self%file%get(self%group//name, found, self%failure)
      if (fits(self, name, n, size(found))) values = found
   end subroutine keep_longs

   !> Whether an array that was read has the length that is expected.
   logical function fits(self, name, expected, found)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: expected, found
      fits = .not. self%failure%failed()
      if (.not. fits .or. found == expected) return
      fits = .false.
      call self%refuse(self%group//name//' has '//to_text(found)//' values, not '//to_text(expected))
   end function fits
end module hampm_checkpoint
