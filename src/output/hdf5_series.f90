!> A dataset that grows: a vector, or a matrix whose last dimension grows, stored in chunks. Reals that never reached
!> the file, because the disk was full or the program was killed while it wrote them, are read as NaN, not as 0.
module hampm_hdf5_series
   use, intrinsic :: iso_c_binding, only: c_bool, c_loc, c_ptr
   use, intrinsic :: iso_fortran_env, only: int8
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hampm_kinds, only: dp, long
   use hampm_failure, only: failure_t
   use hampm_hdf5_file, only: hdf5_file_t
   use hampm_hdf5_library
   implicit none
   private
   public :: hdf5_series_t, real_values, long_values, byte_values

   integer, parameter :: real_values = 1   !! 64-bit reals in the file
   integer, parameter :: long_values = 2   !! 64-bit integers in the file
   integer, parameter :: byte_values = 3   !! unsigned 8-bit integers in the file

   !> A dataset that grows, open in its file.
   type :: hdf5_series_t
      integer(long) :: id = -1                  !! HDF5's handle; closed together with the file
      integer(long) :: rows = 1               !! values an entry
      integer(long) :: length = 0             !! entries so far
      character(:), allocatable :: path          !! path in the file
   contains
      procedure :: create
      procedure :: attach_to
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
      integer, intent(in) :: values              !! type of its values: `real_values`, `long_values` or `byte_values`
      integer, intent(in) :: rows                !! values an entry
      integer, intent(in) :: chunk               !! entries stored together
      type(failure_t), intent(inout) :: failure
      integer(long) :: list, space
      integer(long) :: types(3)                  ! in the file, in the order of their names above
      real(dp), target :: missing
      integer :: e(5)
      types = [real64_le, int64_le, uint8_le]
      self%path = path
      if (file%holds(path)) then
         call self%reopen(file, failure)
         return
      end if
      self%rows = rows
      self%length = 0
      space = h5screate_simple(rank_of(self), [0_long, self%rows], [unlimited, self%rows])
      list = h5pcreate(dataset_create)
      e(1) = h5pset_chunk(list, rank_of(self), [int(chunk, long), self%rows])
      e(2) = h5pset_obj_track_times(list, .false._c_bool)
      missing = ieee_value(1.0_dp, ieee_quiet_nan)
      e(3) = 0
      if (values == real_values) e(3) = h5pset_fill_value(list, native_real, c_loc(missing))
      self%id = h5dcreate(file%id, c_string(path), types(values), space, default, list, default)
      e(4) = h5release(list)
      e(5) = h5release(space)
      if (self%id < 0 .or. any(e < 0)) call file%unwritten('making '//path//' failed', failure)
   end subroutine create

   !> Say that a dataset has the values of the dimension along which this vector grows; which may be this one.
   subroutine attach_to(self, scale, file, failure)
      class(hdf5_series_t), intent(in) :: self, scale
      type(hdf5_file_t), intent(in) :: file
      type(failure_t), intent(inout) :: failure
      integer :: e
      if (self%id == scale%id) then
         e = h5dsset_scale(self%id, c_string(self%path(index(self%path, '/', back=.true.) + 1:)))
      else
         e = h5dsattach_scale(self%id, scale%id, 0)
      end if
      if (e < 0) call file%unwritten('making '//scale%path//' the dimension of '//self%path//' failed', failure)
   end subroutine attach_to

   !> Find the dataset again in a file that has been opened anew, with as many entries as it has there.
   subroutine reopen(self, file, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      type(failure_t), intent(inout) :: failure
      integer(long) :: space
      integer(long), dimension(most_dimensions) :: extent, limit
      integer :: e, rank
      extent = 1
      self%id = h5oopen(file%id, c_string(self%path), default)
      space = h5dget_space(self%id)
      rank = h5sget_simple_extent_dims(space, extent, limit)
      if (rank == 1 .or. rank == 2) then
         self%length = extent(1)
         self%rows = extent(2)
      else
         call file%unwritten('it has no '//self%path//' that could grow', failure)
      end if
      e = h5release(space)
   end subroutine reopen

   !> Drop all entries but the first ones.
   subroutine shorten(self, file, length, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      integer(long), intent(in) :: length
      type(failure_t), intent(inout) :: failure
      integer :: e
      e = -1
      if (length <= self%length) e = h5dset_extent(self%id, [length, self%rows])
      if (e < 0) call file%unwritten('it has fewer entries of '//self%path//' than there were', failure)
      self%length = length
   end subroutine shorten

   !> Append the entries that the same dataset of another file has beyond these, or drop those that it lacks.
   subroutine catch_up(self, file, donor, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file      !! that this dataset is in
      type(hdf5_file_t), intent(in) :: donor
      type(failure_t), intent(inout) :: failure
      integer(long), parameter :: longest = 2**16    ! entries that are taken at a time
      type(hdf5_series_t) :: source
      integer(int8), allocatable, target :: bytes(:)
      integer(long) :: n
      integer(long) :: type_id
      integer :: e
      source%path = self%path
      call source%reopen(donor, failure)
      if (self%length > source%length .and. .not. failure%failed()) call self%shorten(file, source%length, failure)
      if (failure%failed()) return
      type_id = h5dget_type(source%id)
      allocate (bytes(self%rows*min(longest, max(source%length - self%length, 0_long))*h5tget_size(type_id)))
      do while (self%length < source%length .and. .not. failure%failed())
         n = min(longest, source%length - self%length)
         call read_raw(source, donor, type_id, self%length, n, c_loc(bytes), failure)
         if (.not. failure%failed()) call append_raw(self, file, type_id, int(n), c_loc(bytes), failure)
      end do
      e = h5release(type_id)
   end subroutine catch_up

   !> Read `n` entries behind the first `start` ones, one after the other, to `address`.
   subroutine read_raw(self, file, memory_type, start, n, address, failure)
      class(hdf5_series_t), intent(in) :: self
      type(hdf5_file_t), intent(in) :: file
      integer(long), intent(in) :: memory_type
      integer(long), intent(in) :: start, n
      type(c_ptr), value :: address
      type(failure_t), intent(inout) :: failure
      integer(long) :: space, memory
      integer :: e(4)
      call select_entries(self, start, n, space, memory, e(1))
      e(2) = h5dread(self%id, memory_type, memory, space, default, address)
      e(3) = h5release(memory)
      e(4) = h5release(space)
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
         call append_raw(self, file, native_real, size(values), c_loc(values), failure)
       type is (integer)
         call append_raw(self, file, native_integer, size(values), c_loc(values), failure)
       type is (integer(long))
         call append_raw(self, file, native_long, size(values), c_loc(values), failure)
      end select
   end subroutine append_vector

   !> Append the columns of a matrix.
   subroutine append_matrix(self, file, values, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      real(dp), intent(in), target, contiguous :: values(:, :)   !! shape (rows, n)
      type(failure_t), intent(inout) :: failure
      call append_raw(self, file, native_real, size(values, 2), c_loc(values), failure)
   end subroutine append_matrix

   !> Append `entries` entries that lie one after the other in memory from `address` on.
   subroutine append_raw(self, file, memory_type, entries, address, failure)
      class(hdf5_series_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      integer(long), intent(in) :: memory_type
      integer, intent(in) :: entries
      type(c_ptr), intent(in) :: address
      type(failure_t), intent(inout) :: failure
      integer(long) :: space, memory
      integer :: e(5)
      if (entries == 0) return
      e(1) = h5dset_extent(self%id, [self%length + entries, self%rows])
      call select_entries(self, self%length, int(entries, long), space, memory, e(2))
      e(3) = h5dwrite(self%id, memory_type, memory, space, default, address)
      e(4) = h5release(memory)
      e(5) = h5release(space)
      if (any(e < 0)) then
         call file%unwritten('adding to '//self%path//' failed (is the disk full?)', failure)
      else
         self%length = self%length + entries
      end if
   end subroutine append_raw

   !> The spaces, in the file and in memory, of `n` entries behind the first `start` ones; `e` tells whether that failed.
   subroutine select_entries(self, start, n, space, memory, e)
      class(hdf5_series_t), intent(in) :: self
      integer(long), intent(in) :: start, n
      integer(long), intent(out) :: space, memory
      integer, intent(out) :: e
      integer(long), parameter :: single(2) = 1
      space = h5dget_space(self%id)
      e = h5sselect_hyperslab(space, select_set, [start, 0_long], single, [n, self%rows], single)
      memory = h5screate_simple(rank_of(self), [n, self%rows], [n, self%rows])
   end subroutine select_entries

   !> Number of dimensions that the dataset has, of (n, rows) in C's order: a series of single values has no rows.
   pure integer function rank_of(self)
      class(hdf5_series_t), intent(in) :: self
      rank_of = merge(1, 2, self%rows == 1)
   end function rank_of
end module hampm_hdf5_series
