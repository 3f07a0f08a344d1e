!> The file of a checkpoint. One list of items serves writing and reading, where each item gets its stored value.
!>
!> The file is written under a partial name and renamed when complete. HDF5 keeps checksums: of arrays by its filter Fletcher-32
!> (texts are arrays of letters here), of its own structures by the file format of HDF5 1.10. Reading fails, with the reason, where
!> the file is not of this program or is of another version, has changed, or does not fit the model.
module hampm_checkpoint
   use hampm_kinds, only: dp, long
   use hampm_archive, only: archive_t
   use hampm_failure, only: failure_t, exit_file
   use hampm_file_moves, only: partial_name, replace_file, remove_file, file_exists
   use hampm_hdf5_file, only: hdf5_file_t
   use hampm_text, only: to_text
   use hampm_version, only: version, same_release
   implicit none
   private
   public :: checkpoint_t, checkpoint_name

   integer, parameter :: format = 42            !! of the file: to be raised with each change of its items
   character(*), parameter :: format_name = 'hampm checkpoint'

   !> A checkpoint that is being written or read.
   type, extends(archive_t) :: checkpoint_t
      type(hdf5_file_t), private :: file
      character(:), allocatable, private :: path
      character(:), allocatable, private :: written_by  !! the version that has written it, once it is open
      character(:), allocatable, private :: group  !! of the next items, '/group/'
   contains
      procedure :: create
      procedure :: open => open_checkpoint
      procedure :: other_build
      procedure :: finish
      procedure :: section
      procedure :: archive_text
      procedure :: archive_reals
      procedure :: archive_longs
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
      call self%file%create(partial_name(path), self%failure, sealed=.true.)
      text = format_name
      call self%archive_text('kind', text)
      number = format
      call self%serialise('format', number)
      text = trim(version)
      call self%archive_text('version', text)
   end subroutine create

   !> Begin to read a checkpoint. Fails with `exit_file` where the file is not a checkpoint of this program.
   subroutine open_checkpoint(self, path)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: path
      character(:), allocatable :: found
      integer :: number
      self%path = path
      self%group = '/'
      self%is_read = .true.
      if (.not. file_exists(path)) then
         call self%failure%report(exit_file, path//': cannot be read: there is no such file')
         return
      end if
      call self%file%open(path, self%failure)
      if (self%failure%failed()) return
      found = ''
      number = 0
      if (self%file%holds('/kind')) call self%archive_text('kind', found)
      if (self%failure%failed()) return
      if (found /= format_name) then
         call self%refuse('it is no checkpoint of hampm')
         return
      end if
      call self%serialise('format', number)
      call self%archive_text('version', self%written_by)
      if (self%failure%failed()) return
      if (.not. same_release(self%written_by, version) .or. number /= format) then
         call self%refuse('it was written by hampm '//self%written_by//' (format '//to_text(number)//'), this is hampm '// &
                          trim(version)//' (format '//to_text(format)//'); resume the run with the program that began it')
      end if
   end subroutine open_checkpoint

   !> Notice that another commit of the program has written an open checkpoint; '' else.
   pure function other_build(self) result(text)
      class(checkpoint_t), intent(in) :: self
      character(:), allocatable :: text
      text = ''
      if (self%failure%failed()) return
      if (self%written_by == version) return
      text = self%path//': it was written by hampm '//self%written_by//', this is hampm '//trim(version)// &
             ': the result will be of both'
   end function other_build

   !> Close the file; one that was written is put in its place if nothing has failed, and else removed.
   subroutine finish(self, failure)
      class(checkpoint_t), intent(inout) :: self
      type(failure_t), intent(inout) :: failure
      logical :: was_begun
      was_begun = self%file%is_open() .and. .not. self%is_read
      call self%file%close(self%failure)
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

   !> Report that the values read cannot be right.
   subroutine refuse(self, why)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: why
      call self%failure%report(exit_file, self%path//': cannot be resumed: '//why)
   end subroutine refuse

   !> Keep a text, as the numbers of its letters.
   subroutine archive_text(self, name, text)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      character(:), allocatable, intent(inout) :: text
      integer, allocatable :: letters(:)
      integer :: i, n
      if (.not. self%is_read) n = len(text)
      call self%serialise(name//'_length', n)
      if (self%failure%failed()) return
      if (self%is_read) text = repeat(' ', n)
      allocate (letters(n))
      letters = [(iachar(text(i:i)), i=1, n)]
      call self%archive_integers(name, n, letters)
      do i = 1, n
         text(i:i) = achar(letters(i))
      end do
   end subroutine archive_text

   !> Keep the first `n` elements of an array of reals of any shape.
   subroutine archive_reals(self, name, n, values)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: n
      real(dp), intent(inout) :: values(n)
      call archive_vector(self, name, values)
   end subroutine archive_reals

   !> Keep the first `n` elements of an array of long integers of any shape.
   subroutine archive_longs(self, name, n, values)
      class(checkpoint_t), intent(inout) :: self
      character(*), intent(in) :: name
      integer, intent(in) :: n
      integer(long), intent(inout) :: values(n)
      call archive_vector(self, name, values)
   end subroutine archive_longs

   !> Archive a vector; the length read must be the same.
   subroutine archive_vector(self, name, values)
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
   end subroutine archive_vector
end module hampm_checkpoint
