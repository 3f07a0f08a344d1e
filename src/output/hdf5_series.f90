!> A dataset that grows: a vector, or a matrix whose last dimension grows, stored in chunks. Reals that never reached
!> the file, because the disk was full or the program was killed while it wrote them, are read as NaN, not as 0.
module hampm_hdf5_series
   use, intrinsic :: iso_c_binding, only: c_loc, c_ptr
   use, intrinsic :: iso_fortran_env, only: int8
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hdf5, only: hid_t, hsize_t, h5s_unlimited_f, h5s_select_set_f, h5screate_simple_f, h5sclose_f, &
      h5sselect_hyperslab_f, h5pcreate_f, h5pclose_f, h5pset_chunk_f, h5pset_fill_value_f, h5pset_obj_track_times_f, &
      h5p_dataset_create_f, h5dcreate_f, h5dopen_f, h5dset_extent_f, h5dget_space_f, h5dread_f, h5dwrite_f, h5dget_type_f, &
      h5sget_simple_extent_ndims_f, h5sget_simple_extent_dims_f, h5tget_size_f, h5tclose_f, h5t_ieee_f64le, h5t_std_i64le, &
      h5t_std_u8le, size_t
   use hampm_kinds, only: dp, long
   use hampm_failure, only: failure_t
   use hampm_hdf5_file, only: hdf5_file_t, native_real, native_integer, native_long
   implicit none
   private
   public :: hdf5_series_t, real_values, long_values, byte_values

   integer, parameter :: real_values = 1   !! 64-bit reals in the file
   integer, parameter :: long_values = 2   !! 64-bit integers in the file
   integer, parameter :: byte_values = 3   !! unsigned 8-bit integers in the file

   !> A dataset that grows, open in its file.
   type :: hdf5_series_t
      integer(hid_t) :: id = -1                  !! HDF5's handle; closed together with the file
      integer(hsize_t) :: rows = 1               !! values an entry
      integer(hsize_t) :: length = 0             !! entries so far
      character(:), allocatable :: path          !! path in the file
   contains
      procedure :: create
      procedure :: reopen
      procedure :: shorten
      procedure :: catch_up
      generic :: append => append_vector, append_matrix
      procedure, private :: append_vector, append_matrix
   end type hdf5_series_t

contains

   !> Make the empty dataset `path`: shape (n) where `rows` is one, else (rows, n). Where the file has it, it is continued.
   subroutine create(self, file, path, values, rows, chunk, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: path
      integer, intent(in) :: values              !! what it stores: `real_values`, `long_values` or `byte_values`
      integer, intent(in) :: rows                !! values an entry
      integer, intent(in) :: chunk               !! entries stored together
      type(failure_t), intent(inout) :: failure
      integer(hid_t) :: list, space
      integer(hsize_t) :: none_yet(2), limit(2), chunks(2)
      integer :: e(8), first
      self%path = path
      if (file%holds(path)) then
         call self%reopen(file, failure)
         return
      end if
      self%rows = rows
      self%length = 0
      first = first_dimension(self)
      none_yet = [self%rows, 0_hsize_t]
      limit = [self%rows, h5s_unlimited_f]
      chunks = [self%rows, int(chunk, hsize_t)]
      call h5screate_simple_f(3 - first, none_yet(first:), space, e(1), limit(first:))
      call h5pcreate_f(h5p_dataset_create_f, list, e(2))
      call h5pset_chunk_f(list, 3 - first, chunks(first:), e(3))
      call h5pset_obj_track_times_f(list, .false., e(4))
      e(5) = 0
      if (values == real_values) call h5pset_fill_value_f(list, native_real(), ieee_value(1.0_dp, ieee_quiet_nan), e(5))
      call h5dcreate_f(file%id, path, file_type(values), space, self%id, e(6), dcpl_id=list)
      call h5pclose_f(list, e(7))
      call h5sclose_f(space, e(8))
      if (any(e < 0)) call file%unwritten('making '//path//' failed', failure)
   end subroutine create

   !> Find the dataset again in a file that has been opened anew, with as many entries as it has there.
   subroutine reopen(self, file, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      type(failure_t), intent(inout) :: failure
      integer(hid_t) :: space
      integer(hsize_t) :: extent(2), limit(2)
      integer :: e(5), rank
      extent = 0
      rank = 0
      call h5dopen_f(file%id, self%path, self%id, e(1))
      call h5dget_space_f(self%id, space, e(2))
      call h5sget_simple_extent_ndims_f(space, rank, e(3))
      if (all(e(:3) >= 0) .and. (rank == 1 .or. rank == 2)) then
         call h5sget_simple_extent_dims_f(space, extent(:rank), limit(:rank), e(4))
         self%length = extent(rank)
         self%rows = merge(extent(1), 1_hsize_t, rank == 2)
      else
         call file%unwritten('it has no '//self%path//' that could grow', failure)
      end if
      call h5sclose_f(space, e(5))
   end subroutine reopen

   !> Drop all entries but the first ones.
   subroutine shorten(self, file, length, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      integer(hsize_t), intent(in) :: length
      type(failure_t), intent(inout) :: failure
      integer(hsize_t) :: extent(2)
      integer :: e, first
      first = first_dimension(self)
      extent = [self%rows, length]
      e = -1
      if (length <= self%length) call h5dset_extent_f(self%id, extent(first:), e)
      if (e < 0) call file%unwritten('it has fewer entries of '//self%path//' than there were', failure)
      self%length = length
   end subroutine shorten

   !> Append what the same dataset of another file has beyond the entries that are here, or drop what it has not.
   subroutine catch_up(self, file, donor, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file      !! that this dataset is in
      type(hdf5_file_t), intent(in) :: donor
      type(failure_t), intent(inout) :: failure
      integer(hsize_t), parameter :: longest = 2**16    ! entries that are taken at a time
      type(hdf5_series_t) :: source
      integer(int8), allocatable, target :: bytes(:)
      integer(hsize_t) :: n
      integer(hid_t) :: type_id
      integer(size_t) :: value_size
      integer :: e(3)
      source%path = self%path
      call source%reopen(donor, failure)
      if (self%length > source%length .and. .not. failure%failed()) call self%shorten(file, source%length, failure)
      if (failure%failed()) return
      call h5dget_type_f(source%id, type_id, e(1))
      call h5tget_size_f(type_id, value_size, e(2))
      allocate (bytes(self%rows*min(longest, max(source%length - self%length, 0_hsize_t))*value_size))
      do while (self%length < source%length .and. .not. failure%failed())
         n = min(longest, source%length - self%length)
         call read_raw(source, donor, type_id, self%length, n, c_loc(bytes), failure)
         if (.not. failure%failed()) call append_raw(self, file, type_id, int(n), c_loc(bytes), failure)
      end do
      call h5tclose_f(type_id, e(3))
   end subroutine catch_up

   !> Read `n` entries behind the first `start` ones, one after the other, to `address`.
   subroutine read_raw(self, file, memory_type, start, n, address, failure)
      class(hdf5_series_t), intent(in) :: self
      type(hdf5_file_t), intent(in) :: file
      integer(hid_t), intent(in) :: memory_type
      integer(hsize_t), intent(in) :: start, n
      type(c_ptr), value :: address
      type(failure_t), intent(inout) :: failure
      integer(hid_t) :: space, memory
      integer :: e(6)
      call select_entries(self, start, n, space, memory, e(:3))
      call h5dread_f(self%id, memory_type, address, e(4), memory, space)
      call h5sclose_f(memory, e(5))
      call h5sclose_f(space, e(6))
      if (any(e < 0)) call file%unwritten('reading '//self%path//' again failed', failure)
   end subroutine read_raw

   !> Append the entries of a vector: reals, integers or 64-bit integers.
   subroutine append_vector(self, file, values, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      class(*), intent(in), target, contiguous :: values(:)
      type(failure_t), intent(inout) :: failure
      select type (values)
       type is (real(dp))
         call append_raw(self, file, native_real(), size(values), c_loc(values), failure)
       type is (integer)
         call append_raw(self, file, native_integer(), size(values), c_loc(values), failure)
       type is (integer(long))
         call append_raw(self, file, native_long(), size(values), c_loc(values), failure)
      end select
   end subroutine append_vector

   !> Append the columns of a matrix.
   subroutine append_matrix(self, file, values, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      real(dp), intent(in), target, contiguous :: values(:, :)   !! shape (rows, n)
      type(failure_t), intent(inout) :: failure
      call append_raw(self, file, native_real(), size(values, 2), c_loc(values), failure)
   end subroutine append_matrix

   !> Append `entries` entries that lie one after the other in memory from `address` on.
   subroutine append_raw(self, file, memory_type, entries, address, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      integer(hid_t), intent(in) :: memory_type
      integer, intent(in) :: entries
      type(c_ptr), intent(in) :: address
      type(failure_t), intent(inout) :: failure
      integer(hid_t) :: space, memory
      integer(hsize_t) :: extent(2)
      integer :: e(7)
      if (entries == 0) return
      extent = [self%rows, self%length + entries]
      call h5dset_extent_f(self%id, extent(first_dimension(self):), e(1))
      call select_entries(self, self%length, int(entries, hsize_t), space, memory, e(2:4))
      call h5dwrite_f(self%id, memory_type, address, e(5), memory, space)
      call h5sclose_f(memory, e(6))
      call h5sclose_f(space, e(7))
      if (any(e < 0)) then
         call file%unwritten('adding to '//self%path//' failed (is the disk full?)', failure)
      else
         self%length = extent(2)
      end if
   end subroutine append_raw

   !> The spaces, in the file and in memory, of `n` entries behind the first `start` ones; `e` tells what failed.
   subroutine select_entries(self, start, n, space, memory, e)
      class(hdf5_series_t), intent(in) :: self
      integer(hsize_t), intent(in) :: start, n
      integer(hid_t), intent(out) :: space, memory
      integer, intent(out) :: e(3)
      integer(hsize_t) :: first_entry(2), counts(2)
      integer :: first
      first = first_dimension(self)
      first_entry = [0_hsize_t, start]
      counts = [self%rows, n]
      call h5dget_space_f(self%id, space, e(1))
      call h5sselect_hyperslab_f(space, h5s_select_set_f, first_entry(first:), counts(first:), e(2))
      call h5screate_simple_f(3 - first, counts(first:), memory, e(3))
   end subroutine select_entries

   !> The first of the dimensions (rows, n) that the dataset has: a series of single values has no rows.
   pure integer function first_dimension(self)
      class(hdf5_series_t), intent(in) :: self
      first_dimension = merge(2, 1, self%rows == 1)
   end function first_dimension

   !> HDF5's type of the values in the file.
   integer(hid_t) function file_type(values)
      integer, intent(in) :: values
      select case (values)
      case (long_values)
         file_type = h5t_std_i64le
      case (byte_values)
         file_type = h5t_std_u8le
      case default
         file_type = h5t_ieee_f64le
      end select
   end function file_type
end module hampm_hdf5_series
