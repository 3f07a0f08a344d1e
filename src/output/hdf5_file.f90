!> A thin layer over HDF5 for the needs of the program: a file, groups, links, attributes and whole datasets. Objects are named by
!> their path in the file. HDF5 prints nothing itself: failures are reported as `exit_file` with the file's path. No object carries
!> a time stamp: the same data give the same bytes.
!>
!> Types, spaces and texts of HDF5 for the other HDF5 modules.
module hampm_hdf5_file
   use, intrinsic :: iso_c_binding, only: c_associated, c_bool, c_char, c_f_pointer, c_loc, c_null_ptr, c_ptr, c_size_t
   use hampm_kinds, only: dp, long
   use hampm_failure, only: failure_t, exit_file
   use hampm_hdf5_library
   implicit none
   private
   public :: hdf5_file_t

   logical, save :: library_open = .false. !! whether HDF5 has been initialised

   !> An open HDF5 file.
   type :: hdf5_file_t
      integer(long) :: id = -1                 !! HDF5's handle, negative while no file is open
      character(:), allocatable :: path         !! path of the file
   contains
      procedure :: create
      procedure :: open => open_file
      procedure :: close => close_file
      procedure :: is_open
      procedure :: holds
      procedure :: make_group
      procedure :: make_link
      procedure :: unwritten
      procedure :: put_label
      generic :: put_attribute => put_attribute_value, put_attribute_integers
      generic :: put => put_text, put_vector
      generic :: get => get_text, get_vector
      procedure, private :: put_attribute_value, put_attribute_integers
      procedure, private :: put_text, put_vector
      procedure, private :: get_text, get_vector
   end type hdf5_file_t

contains

   !> Make a new file, in place of an old one of that name. `exit_file` says why where that is impossible.
   subroutine create(self, path, failure, sealed)
      class(hdf5_file_t), intent(inout) :: self
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: sealed   !! whether HDF5's own structures have checksums (HDF5 1.10 on); default: no
      integer(long) :: access, list
      integer :: e
      call open_library()
      self%path = path
      access = h5pcreate(file_access)
      e = h5pset_fclose_degree(access, close_strong)
      if (present(sealed)) e = h5pset_libver_bounds(access, hdf5_110, hdf5_110)
      list = h5pcreate(file_create)
      e = h5pset_obj_track_times(list, .false._c_bool)
      self%id = h5fcreate(c_string(path), truncate, list, access)
      e = h5release(access)
      e = h5release(list)
      if (.not. self%is_open()) then
         call self%unwritten(why_not(path, 'write', 'its disk is full, or another program has it open'), failure)
      end if
   end subroutine create

   !> Open an existing file for reading, or to be continued. `exit_file` says why where that is impossible.
   subroutine open_file(self, path, failure, writable)
      class(hdf5_file_t), intent(inout) :: self
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: writable
      integer(long) :: access
      integer :: e, mode
      call open_library()
      self%path = path
      mode = read_only
      if (present(writable)) mode = merge(read_write, read_only, writable)
      access = h5pcreate(file_access)
      e = h5pset_fclose_degree(access, close_strong)
      self%id = h5fopen(c_string(path), mode, access)
      e = h5release(access)
      if (.not. self%is_open()) then
         call unread(self, why_not(path, 'read', 'it is no HDF5 file, or not a whole one, or a program is still writing it'), &
                     failure)
      end if
   end subroutine open_file

   !> Close the file and every object in it. Nothing happens where none is open.
   subroutine close_file(self, failure)
      class(hdf5_file_t), intent(inout) :: self
      type(failure_t), intent(inout) :: failure
      integer :: e
      if (.not. self%is_open()) return
      e = h5fclose(self%id)
      self%id = -1
      if (e < 0) call self%unwritten('closing failed (is the disk full?)', failure)
   end subroutine close_file

   !> Whether a file is open.
   pure logical function is_open(self)
      class(hdf5_file_t), intent(in) :: self
      is_open = self%id >= 0
   end function is_open

   !> Whether there is an object of this path, whose parent exists.
   logical function holds(self, path)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: path
      holds = h5lexists(self%id, c_string(path), default) > 0
   end function holds

   !> Report that the file cannot be written, and why.
   subroutine unwritten(self, why, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: why
      type(failure_t), intent(inout) :: failure
      call failure%report(exit_file, self%path//': cannot be written: '//why)
   end subroutine unwritten

   !> Make a group, unless it is there; its parent exists. Its members keep the order in which they are made.
   subroutine make_group(self, path, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      integer(long) :: group, list
      integer :: e(4)
      if (self%holds(path)) return
      list = h5pcreate(group_create)
      e(1) = h5pset_link_creation_order(list, track_and_index)
      e(2) = h5pset_obj_track_times(list, .false._c_bool)
      group = h5gcreate(self%id, c_string(path), default, list, default)
      e(3) = h5release(group)
      e(4) = h5release(list)
      if (any(e < 0)) call self%unwritten('making the group '//path//' failed', failure)
   end subroutine make_group

   !> Make `path` another name of the object `target`, unless it is there.
   subroutine make_link(self, target, path, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: target, path
      type(failure_t), intent(inout) :: failure
      if (self%holds(path)) return
      if (h5lcreate_soft(c_string(target), self%id, c_string(path), default, default) < 0) &
         call self%unwritten('making the link '//path//' failed', failure)
   end subroutine make_link

   !> Attach a text of any length (UTF-8), a real number or an integer to the group or dataset `object`, or replace it.
   subroutine put_attribute_value(self, object, name, value, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: object, name
      class(*), intent(in), target :: value
      type(failure_t), intent(inout) :: failure
      character(:, c_char), allocatable, target :: chars
      type(c_ptr), target :: address
      integer(long) :: type_id
      integer :: e
      select type (value)
       type is (character(*))
         chars = c_string(value)
         address = c_loc(chars)
         type_id = text_type()
         call write_attribute(self, object, name, type_id, type_id, h5screate(scalar), c_loc(address), failure)
         e = h5release(type_id)
       type is (real(dp))
         call write_attribute(self, object, name, real64_le, native_real, h5screate(scalar), c_loc(value), failure)
       type is (integer)
         call write_attribute(self, object, name, int64_le, native_integer, h5screate(scalar), c_loc(value), failure)
      end select
   end subroutine put_attribute_value

   !> Attach a text of fixed length (ASCII) that is never replaced: the form in which VTKHDF wants its keywords.
   subroutine put_label(self, object, name, value, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: object, name, value
      type(failure_t), intent(inout) :: failure
      character(len(value) + 1, c_char), target :: chars
      integer(long) :: type_id
      integer :: e
      chars = c_string(value)
      type_id = h5tcopy(c_text)
      e = h5tset_size(type_id, len(value, c_size_t))
      e = h5tset_strpad(type_id, null_padded)
      call write_attribute(self, object, name, type_id, type_id, h5screate(scalar), c_loc(chars), failure)
      e = h5release(type_id)
   end subroutine put_label

   !> Attach a few integers, or replace them.
   subroutine put_attribute_integers(self, object, name, values, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: object, name
      integer, intent(in), target, contiguous :: values(:)
      type(failure_t), intent(inout) :: failure
      call write_attribute(self, object, name, int64_le, native_integer, &
                           simple_space(shape(values, long)), c_loc(values), failure)
   end subroutine put_attribute_integers

   !> Write the dataset `path`: a text of any length (UTF-8).
   subroutine put_text(self, path, text, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: path, text
      type(failure_t), intent(inout) :: failure
      character(:, c_char), allocatable, target :: chars
      type(c_ptr), target :: address
      integer(long) :: type_id
      integer :: e
      chars = c_string(text)
      address = c_loc(chars)
      type_id = text_type()
      call write_dataset(self, path, type_id, type_id, h5screate(scalar), c_loc(address), failure)
      e = h5release(type_id)
   end subroutine put_text

   !> Write the dataset `path`: a vector of reals or 64-bit integers.
   subroutine put_vector(self, path, values, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: path
      class(*), intent(in), target, contiguous :: values(:)
      type(failure_t), intent(inout) :: failure
      select type (values)
       type is (real(dp))
         call write_dataset(self, path, real64_le, native_real, simple_space(shape(values, long)), &
                            c_loc(values), failure)
       type is (integer(long))
         call write_dataset(self, path, int64_le, native_long, simple_space(shape(values, long)), &
                            c_loc(values), failure)
      end select
   end subroutine put_vector

   !> Read the dataset `path`, a text.
   subroutine get_text(self, path, text, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: path
      character(:), allocatable, intent(out) :: text
      type(failure_t), intent(inout) :: failure
      interface
         integer(c_size_t) function c_strlen(address) bind(c, name='strlen')
            import :: c_size_t, c_ptr
            type(c_ptr), value :: address
         end function c_strlen
         subroutine c_free(address) bind(c, name='free')
            import :: c_ptr
            type(c_ptr), value :: address
         end subroutine c_free
      end interface
      type(c_ptr), target :: address
      character(c_char), pointer :: chars(:)
      integer(long) :: dataset, type_id
      integer(long) :: extent(0)
      integer :: e, i
      text = ''
      address = c_null_ptr
      type_id = text_type()
      call find_dataset(self, path, dataset, extent, failure)
      call read_dataset(self, path, dataset, type_id, c_loc(address), failure)
      e = h5release(type_id)
      if (failure%failed() .or. .not. c_associated(address)) return
      call c_f_pointer(address, chars, [c_strlen(address)])
      text = repeat(' ', size(chars))
      do i = 1, size(chars)
         text(i:i) = chars(i)
      end do
      call c_free(address)
   end subroutine get_text

   !> Read the dataset `path`, a vector of reals or 64-bit integers, where it has as many as there is room for.
   subroutine get_vector(self, path, values, n, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: path
      class(*), intent(inout), target, contiguous :: values(:)
      integer, intent(out) :: n                  !! values that it has
      type(failure_t), intent(inout) :: failure
      integer(long) :: dataset
      integer(long) :: extent(1)
      call find_dataset(self, path, dataset, extent, failure)
      n = int(extent(1))
      if (n /= size(values)) return
      select type (values)
       type is (real(dp))
         call read_dataset(self, path, dataset, native_real, c_loc(values), failure)
       type is (integer(long))
         call read_dataset(self, path, dataset, native_long, c_loc(values), failure)
      end select
   end subroutine get_vector

   !> Write a new dataset whole, in the given space, which is closed. All but single values have a checksum: reading fails if they
   !> are damaged.
   subroutine write_dataset(file, path, file_type, memory_type, space, address, failure)
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: path
      integer(long), intent(in) :: file_type, memory_type, space
      type(c_ptr), intent(in) :: address
      type(failure_t), intent(inout) :: failure
      integer(long) :: dataset, list
      integer :: e(6)
      list = h5pcreate(dataset_create)
      e(1) = h5pset_obj_track_times(list, .false._c_bool)
      call add_checksum(list, space, e(2))
      dataset = h5dcreate(file%id, c_string(path), file_type, space, default, list, default)
      e(3) = h5dwrite(dataset, memory_type, default, default, default, address)
      e(4) = h5release(dataset)
      e(5) = h5release(list)
      e(6) = h5release(space)
      if (any(e < 0)) call file%unwritten('writing '//path//' failed (is the disk full?)', failure)
   end subroutine write_dataset

   !> Ask for checksums of a new dataset of a space that has extent.
   subroutine add_checksum(list, space, e)
      integer(long), intent(in) :: list, space
      integer, intent(out) :: e
      integer(long), parameter :: longest = 2**20   ! entries that are summed together
      integer(long), dimension(most_dimensions) :: extent, limit
      integer :: rank
      rank = h5sget_simple_extent_dims(space, extent, limit)
      e = min(rank, 0)
      if (rank <= 0) return
      if (any(extent(:rank) == 0)) return
      e = h5pset_chunk(list, rank, min(extent(:rank), longest))
      if (e >= 0) e = h5pset_fletcher32(list)
   end subroutine add_checksum

   !> Open a dataset of rank `size(extent)` and get its extent, which is 0 where there is no such dataset.
   subroutine find_dataset(file, path, dataset, extent, failure)
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: path
      integer(long), intent(out) :: dataset
      integer(long), intent(out) :: extent(:)
      type(failure_t), intent(inout) :: failure
      integer(long), dimension(most_dimensions) :: found, limit
      integer(long) :: space
      integer :: e
      extent = 0
      dataset = h5oopen(file%id, c_string(path), default)
      space = h5dget_space(dataset)
      if (h5sget_simple_extent_dims(space, found, limit) == size(extent)) then
         extent = found(:size(extent))
      else
         call unread(file, 'there is no '//path//' of the expected shape (has it changed since it was written?)', failure)
      end if
      e = h5release(space)
   end subroutine find_dataset

   !> Read a whole dataset to `address` and close it; nothing where `find_dataset` has failed.
   subroutine read_dataset(file, path, dataset, memory_type, address, failure)
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: path
      integer(long), intent(in) :: dataset, memory_type
      type(c_ptr), value :: address
      type(failure_t), intent(inout) :: failure
      integer :: e(2)
      if (failure%failed()) return
      e(1) = h5dread(dataset, memory_type, default, default, default, address)
      e(2) = h5release(dataset)
      if (any(e < 0)) call unread(file, 'reading '//path//' failed (has it changed since it was written?)', failure)
   end subroutine read_dataset

   !> Write an attribute, created if absent; the space is closed.
   subroutine write_attribute(file, object, name, file_type, memory_type, space, address, failure)
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: object, name
      integer(long), intent(in) :: file_type, memory_type, space
      type(c_ptr), intent(in) :: address
      type(failure_t), intent(inout) :: failure
      integer(long) :: owner, attribute
      integer :: e(4)
      owner = h5oopen(file%id, c_string(object), default)
      if (h5aexists(owner, c_string(name)) > 0) then
         attribute = h5aopen(owner, c_string(name), default)
      else
         attribute = h5acreate(owner, c_string(name), file_type, space, default, default)
      end if
      e(1) = h5awrite(attribute, memory_type, address)
      e(2) = h5release(attribute)
      e(3) = h5release(owner)
      e(4) = h5release(space)
      if (any(e < 0)) call file%unwritten('writing the attribute '//name//' of '//object//' failed', failure)
   end subroutine write_attribute

   !> Initialise HDF5 once. Keep it from printing, and from cleaning up when the program ends: after a full disk that
   !> crashes, and every file is closed by then.
   subroutine open_library()
      integer :: e
      if (library_open) return
      e = h5dont_atexit()
      e = h5open()
      e = h5eset_auto(default, c_null_ptr, c_null_ptr)
      library_open = .true.
   end subroutine open_library

   !> Report that the file cannot be read, and why.
   subroutine unread(file, why, failure)
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: why
      type(failure_t), intent(inout) :: failure
      call failure%report(exit_file, file%path//': cannot be read: '//why)
   end subroutine unread

   !> Why HDF5 cannot open a file: the operating system's reason, which HDF5 does not pass on, where it has one.
   function why_not(path, action, otherwise) result(reason)
      character(*), intent(in) :: path
      character(*), intent(in) :: action        !! 'read' or 'write'
      character(*), intent(in) :: otherwise     !! the likely reason where the operating system has none
      character(:), allocatable :: reason
      character(512) :: message
      integer :: unit, status
      open (newunit=unit, file=path, action=action, iostat=status, iomsg=message)
      if (status /= 0) then
         reason = trim(message)
      else
         close (unit)
         reason = otherwise
      end if
   end function why_not

   !> A new HDF5 type: a UTF-8 text of any length, in memory the address of a null-terminated one.
   integer(long) function text_type()
      integer :: e
      text_type = h5tcopy(c_text)
      e = h5tset_size(text_type, variable_length)
      e = h5tset_cset(text_type, utf8)
   end function text_type

   !> A new space of the given extent.
   integer(long) function simple_space(extent)
      integer(long), intent(in) :: extent(:)
      simple_space = h5screate_simple(size(extent), extent, extent)
   end function simple_space
end module hampm_hdf5_file
