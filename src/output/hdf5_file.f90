!> A thin layer over HDF5 with what the program needs: a file, groups, links, attributes and whole datasets.
!> Objects are named by their path in the file. HDF5 prints nothing itself: what goes wrong is reported as
!> `exit_file` with the file's path. No object carries a time stamp: the same data give the same bytes.
!>
!> What HDF5 calls the program's types of data: types, spaces and texts for the other HDF5 modules.
module hampm_hdf5_file
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_loc, c_null_ptr, c_ptr, c_size_t, c_null_char
   use hdf5, only: hid_t, hsize_t, h5dont_atexit_f, h5open_f, h5eset_auto_f, h5f_acc_trunc_f, h5f_acc_rdonly_f, h5f_acc_rdwr_f, &
                   h5f_close_strong_f, h5fcreate_f, h5fopen_f, h5fclose_f, h5pcreate_f, h5pclose_f, h5pset_fclose_degree_f, &
                   h5pset_link_creation_order_f, h5pset_obj_track_times_f, h5pset_chunk_f, h5pset_fletcher32_f, &
                   h5p_file_access_f, h5p_group_create_f, h5p_dataset_create_f, h5p_crt_order_tracked_f, &
                   h5p_crt_order_indexed_f, h5gcreate_f, h5gclose_f, h5lcreate_soft_f, h5lexists_f, h5oopen_f, h5oclose_f, &
                   h5acreate_f, h5aopen_f, h5aexists_f, h5awrite_f, h5aclose_f, h5sclose_f, h5sget_simple_extent_ndims_f, &
                   h5sget_simple_extent_dims_f, h5dcreate_f, h5dopen_f, h5dget_space_f, h5dread_f, h5dwrite_f, h5dclose_f, &
                   h5tclose_f, h5t_ieee_f64le, h5t_std_i64le, size_t, h5kind_to_type, h5_integer_kind, &
                   h5_real_kind, h5screate_f, h5screate_simple_f, h5s_scalar_f, h5tcopy_f, h5tset_cset_f, h5tset_size_f, &
                   h5tset_strpad_f, h5t_string, h5t_c_s1, h5t_cset_utf8_f, h5t_str_nullpad_f
   use hampm_kinds, only: dp, long
   use hampm_failure, only: failure_t, exit_file
   implicit none
   private
   public :: hdf5_file_t, native_real, native_integer, native_long

   logical, save :: library_open = .false. !! whether HDF5 has been initialised

   !> An open HDF5 file.
   type :: hdf5_file_t
      integer(hid_t) :: id = -1                 !! HDF5's handle, negative while no file is open
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
   subroutine create(self, path, failure)
      class(hdf5_file_t), intent(inout) :: self
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      integer(hid_t) :: access
      integer :: e(3)
      call open_library()
      self%path = path
      call h5pcreate_f(h5p_file_access_f, access, e(1))
      call h5pset_fclose_degree_f(access, h5f_close_strong_f, e(2))
      call h5fcreate_f(path, h5f_acc_trunc_f, self%id, e(3), access_prp=access)
      call h5pclose_f(access, e(1))
      if (e(3) < 0) then
         self%id = -1
         call self%unwritten(why_not(path, 'write', 'its disk is full, or another program has it open'), failure)
      end if
   end subroutine create

   !> Open an existing file for reading, or to be continued. `exit_file` says why where that is impossible.
   subroutine open_file(self, path, failure, writable)
      class(hdf5_file_t), intent(inout) :: self
      character(*), intent(in) :: path
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: writable
      integer(hid_t) :: access
      integer :: e(4), mode
      call open_library()
      self%path = path
      mode = h5f_acc_rdonly_f
      if (present(writable)) mode = merge(h5f_acc_rdwr_f, h5f_acc_rdonly_f, writable)
      call h5pcreate_f(h5p_file_access_f, access, e(1))
      call h5pset_fclose_degree_f(access, h5f_close_strong_f, e(2))
      call h5fopen_f(path, mode, self%id, e(3), access_prp=access)
      call h5pclose_f(access, e(4))
      if (e(3) < 0) then
         self%id = -1
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
      call h5fclose_f(self%id, e)
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
      integer :: e
      call h5lexists_f(self%id, path, holds, e)
      holds = holds .and. e >= 0
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
      integer(hid_t) :: group, list
      integer :: e(5)
      if (self%holds(path)) return
      call h5pcreate_f(h5p_group_create_f, list, e(1))
      call h5pset_link_creation_order_f(list, ior(h5p_crt_order_tracked_f, h5p_crt_order_indexed_f), e(2))
      call h5gcreate_f(self%id, path, group, e(3), gcpl_id=list)
      call h5gclose_f(group, e(4))
      call h5pclose_f(list, e(5))
      if (any(e < 0)) call self%unwritten('making the group '//path//' failed', failure)
   end subroutine make_group

   !> Make `path` another name of the object `target`, unless it is there.
   subroutine make_link(self, target, path, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: target, path
      type(failure_t), intent(inout) :: failure
      integer :: e
      if (self%holds(path)) return
      call h5lcreate_soft_f(target, self%id, path, e)
      if (e < 0) call self%unwritten('making the link '//path//' failed', failure)
   end subroutine make_link

   !> Attach a text of any length (UTF-8), a real number or an integer to the group or dataset `object`, or replace the one of that name.
   subroutine put_attribute_value(self, object, name, value, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: object, name
      class(*), intent(in), target :: value
      type(failure_t), intent(inout) :: failure
      character(c_char), allocatable, target :: chars(:)
      type(c_ptr), target :: address
      integer(hid_t) :: type_id
      integer :: e
      select type (value)
       type is (character(*))
         allocate (chars, source=c_string(value))
         address = c_loc(chars)
         type_id = text_type()
         call write_attribute(self, object, name, type_id, type_id, scalar_space(), c_loc(address), failure)
         call h5tclose_f(type_id, e)
       type is (real(dp))
         call write_attribute(self, object, name, h5t_ieee_f64le, native_real(), scalar_space(), c_loc(value), failure)
       type is (integer)
         call write_attribute(self, object, name, h5t_std_i64le, native_integer(), scalar_space(), c_loc(value), failure)
      end select
   end subroutine put_attribute_value

   !> Attach a text of fixed length (ASCII) that is never replaced: the form in which VTKHDF wants its keywords.
   subroutine put_label(self, object, name, value, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: object, name, value
      type(failure_t), intent(inout) :: failure
      character(c_char), target :: chars(len(value) + 1)
      integer(hid_t) :: type_id
      integer :: e
      chars = c_string(value)
      type_id = label_type(len(value))
      call write_attribute(self, object, name, type_id, type_id, scalar_space(), c_loc(chars), failure)
      call h5tclose_f(type_id, e)
   end subroutine put_label

   !> Attach a few integers, or replace those of that name.
   subroutine put_attribute_integers(self, object, name, values, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: object, name
      integer, intent(in), target, contiguous :: values(:)
      type(failure_t), intent(inout) :: failure
      call write_attribute(self, object, name, h5t_std_i64le, native_integer(), &
                           simple_space(shape(values, hsize_t)), c_loc(values), failure)
   end subroutine put_attribute_integers

   !> Write the dataset `path`: a text of any length (UTF-8).
   subroutine put_text(self, path, text, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: path, text
      type(failure_t), intent(inout) :: failure
      character(c_char), allocatable, target :: chars(:)
      type(c_ptr), target :: address
      integer(hid_t) :: type_id
      integer :: e
      allocate (chars, source=c_string(text))
      address = c_loc(chars)
      type_id = text_type()
      call write_dataset(self, path, type_id, type_id, scalar_space(), c_loc(address), failure)
      call h5tclose_f(type_id, e)
   end subroutine put_text

   !> Write the dataset `path`: a vector of reals or 64-bit integers.
   subroutine put_vector(self, path, values, failure)
      class(hdf5_file_t), intent(in) :: self
      character(*), intent(in) :: path
      class(*), intent(in), target, contiguous :: values(:)
      type(failure_t), intent(inout) :: failure
      select type (values)
       type is (real(dp))
         call write_dataset(self, path, h5t_ieee_f64le, native_real(), simple_space(shape(values, hsize_t)), &
                            c_loc(values), failure)
       type is (integer(long))
         call write_dataset(self, path, h5t_std_i64le, native_long(), simple_space(shape(values, hsize_t)), &
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
      integer(hid_t) :: dataset, type_id
      integer(hsize_t) :: extent(0)
      integer :: e, i
      text = ''
      address = c_null_ptr
      type_id = text_type()
      call find_dataset(self, path, dataset, extent, failure)
      call read_dataset(self, path, dataset, type_id, c_loc(address), failure)
      call h5tclose_f(type_id, e)
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
      integer(hid_t) :: dataset
      integer(hsize_t) :: extent(1)
      call find_dataset(self, path, dataset, extent, failure)
      n = int(extent(1))
      if (n /= size(values)) return
      select type (values)
       type is (real(dp))
         call read_dataset(self, path, dataset, native_real(), c_loc(values), failure)
       type is (integer(long))
         call read_dataset(self, path, dataset, native_long(), c_loc(values), failure)
      end select
   end subroutine get_vector

   !> Write a new dataset whole, in the given space, which is closed. What is not a single value is kept with a checksum: reading
   !> fails where it has been damaged.
   subroutine write_dataset(file, path, file_type, memory_type, space, address, failure)
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: path
      integer(hid_t), intent(in) :: file_type, memory_type, space
      type(c_ptr), intent(in) :: address
      type(failure_t), intent(inout) :: failure
      integer(hid_t) :: dataset, list
      integer :: e(8)
      call h5pcreate_f(h5p_dataset_create_f, list, e(1))
      call h5pset_obj_track_times_f(list, .false., e(2))
      call add_checksum(list, space, e(8))
      call h5dcreate_f(file%id, path, file_type, space, dataset, e(3), dcpl_id=list)
      call h5dwrite_f(dataset, memory_type, address, e(4))
      call h5dclose_f(dataset, e(5))
      call h5pclose_f(list, e(6))
      call h5sclose_f(space, e(7))
      if (any(e < 0)) call file%unwritten('writing '//path//' failed (is the disk full?)', failure)
   end subroutine write_dataset

   !> Ask for checksums of a new dataset of a space that has extent.
   subroutine add_checksum(list, space, e)
      integer(hid_t), intent(in) :: list, space
      integer, intent(out) :: e
      integer(hsize_t), parameter :: longest = 2**20   ! entries that are summed together
      integer(hsize_t), allocatable :: extent(:), limit(:)
      integer :: rank
      call h5sget_simple_extent_ndims_f(space, rank, e)
      allocate (extent(rank), limit(rank))
      if (rank == 0) return
      call h5sget_simple_extent_dims_f(space, extent, limit, e)
      if (any(extent == 0)) return
      call h5pset_chunk_f(list, rank, min(extent, longest), e)
      if (e >= 0) call h5pset_fletcher32_f(list, e)
   end subroutine add_checksum

   !> Open a dataset of rank `size(extent)` and get its extent, which is 0 where there is no such dataset.
   subroutine find_dataset(file, path, dataset, extent, failure)
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: path
      integer(hid_t), intent(out) :: dataset
      integer(hsize_t), intent(out) :: extent(:)
      type(failure_t), intent(inout) :: failure
      integer(hid_t) :: space
      integer(hsize_t) :: limit(size(extent))
      integer :: e(4), rank
      extent = 0
      rank = 0
      call h5dopen_f(file%id, path, dataset, e(1))
      call h5dget_space_f(dataset, space, e(2))
      call h5sget_simple_extent_ndims_f(space, rank, e(3))
      if (all(e(1:3) >= 0) .and. rank == size(extent)) then
         if (rank > 0) call h5sget_simple_extent_dims_f(space, extent, limit, e(4))
      else
         call unread(file, 'there is no '//path//' of the expected shape', failure)
      end if
      call h5sclose_f(space, e(4))
   end subroutine find_dataset

   !> Read a whole dataset to `address` and close it; nothing where `find_dataset` has failed.
   subroutine read_dataset(file, path, dataset, memory_type, address, failure)
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: path
      integer(hid_t), intent(in) :: dataset, memory_type
      type(c_ptr), value :: address
      type(failure_t), intent(inout) :: failure
      integer :: e(2)
      if (failure%failed()) return
      call h5dread_f(dataset, memory_type, address, e(1))
      call h5dclose_f(dataset, e(2))
      if (any(e < 0)) call unread(file, 'reading '//path//' failed', failure)
   end subroutine read_dataset

   !> Write an attribute, making it where there is none yet; the space is closed.
   subroutine write_attribute(file, object, name, file_type, memory_type, space, address, failure)
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: object, name
      integer(hid_t), intent(in) :: file_type, memory_type, space
      type(c_ptr), intent(in) :: address
      type(failure_t), intent(inout) :: failure
      integer(hid_t) :: owner, attribute
      logical :: exists
      integer :: e(7)
      call h5oopen_f(file%id, object, owner, e(1))
      call h5aexists_f(owner, name, exists, e(2))
      if (exists) then
         call h5aopen_f(owner, name, attribute, e(3))
      else
         call h5acreate_f(owner, name, file_type, space, attribute, e(3))
      end if
      call h5awrite_f(attribute, memory_type, address, e(4))
      call h5aclose_f(attribute, e(5))
      call h5oclose_f(owner, e(6))
      call h5sclose_f(space, e(7))
      if (any(e < 0)) call file%unwritten('writing the attribute '//name//' of '//object//' failed', failure)
   end subroutine write_attribute

   !> Initialise HDF5 once. Keep it from printing, and from cleaning up when the program ends: after a full disk that
   !> crashes, and every file is closed by then.
   subroutine open_library()
      integer :: e
      if (library_open) return
      call h5dont_atexit_f(e)
      call h5open_f(e)
      call h5eset_auto_f(0, e)
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

   !> HDF5's type of a `real(dp)` in memory.
   integer(hid_t) function native_real()
      native_real = h5kind_to_type(dp, h5_real_kind)
   end function native_real

   !> HDF5's type of an `integer` in memory.
   integer(hid_t) function native_integer()
      native_integer = h5kind_to_type(kind(0), h5_integer_kind)
   end function native_integer

   !> HDF5's type of an `integer(long)` in memory.
   integer(hid_t) function native_long()
      native_long = h5kind_to_type(long, h5_integer_kind)
   end function native_long

   !> A new HDF5 type: a UTF-8 text of any length, in memory the address of a null-terminated one.
   integer(hid_t) function text_type()
      integer :: e
      call h5tcopy_f(h5t_string, text_type, e)
      call h5tset_cset_f(text_type, h5t_cset_utf8_f, e)
   end function text_type

   !> A new HDF5 type: an ASCII text of fixed length.
   integer(hid_t) function label_type(length)
      integer, intent(in) :: length             !! number of characters, > 0
      integer :: e
      call h5tcopy_f(h5t_c_s1, label_type, e)
      call h5tset_size_f(label_type, int(length, size_t), e)
      call h5tset_strpad_f(label_type, h5t_str_nullpad_f, e)
   end function label_type

   !> A new space of one element.
   integer(hid_t) function scalar_space()
      integer :: e
      call h5screate_f(h5s_scalar_f, scalar_space, e)
   end function scalar_space

   !> A new space of the given extent.
   integer(hid_t) function simple_space(extent)
      integer(hsize_t), intent(in) :: extent(:)
      integer :: e
      call h5screate_simple_f(size(extent), extent, simple_space, e)
   end function simple_space

   !> The text as C wants it: null-terminated.
   pure function c_string(text) result(chars)
      character(*), intent(in) :: text
      character(c_char) :: chars(len(text) + 1)
      integer :: i
      do i = 1, len(text)
         chars(i) = text(i:i)
      end do
      chars(len(text) + 1) = c_null_char
   end function c_string
end module hampm_hdf5_file
