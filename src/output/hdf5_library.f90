!> Interfaces of HDF5's C library, 1.10 or later. Its own Fortran modules are not used: they serve one compiler only, and slow the
!> start. Identifiers and extents are 64-bit integers; functions and identifiers are negative where they fail.
!>
!> Extents are in C's order: the last one is contiguous in memory. Source: HDF5 Reference Manual, The HDF Group.
module hampm_hdf5_library
   use, intrinsic :: iso_c_binding, only: c_bool, c_char, c_int, c_null_char, c_ptr, c_size_t, long => c_int64_t
   implicit none
   public
   private :: c_bool, c_char, c_int, c_null_char, c_ptr, c_size_t, long

   integer(c_int), parameter :: read_only = 0, read_write = 1, truncate = 2 !! how files are opened
   integer(c_int), parameter :: close_strong = 3        !! a file closes with all that is open in it
   integer(c_int), parameter :: hdf5_110 = 2            !! the file format of that version
   integer(c_int), parameter :: track_and_index = 3     !! the order in which members of a group are made
   integer(c_int), parameter :: scalar = 0, select_set = 0, utf8 = 1, null_padded = 1
   integer(c_size_t), parameter :: variable_length = -1 !! of a text
   integer(long), parameter :: default = 0, unlimited = -1
   integer, parameter :: most_dimensions = 32           !! of any space

   integer(long), bind(c, name='H5T_IEEE_F64LE_g') :: real64_le
   integer(long), bind(c, name='H5T_STD_I64LE_g') :: int64_le
   integer(long), bind(c, name='H5T_STD_U8LE_g') :: uint8_le
   integer(long), bind(c, name='H5T_NATIVE_DOUBLE_g') :: native_real
   integer(long), bind(c, name='H5T_NATIVE_INT32_g') :: native_integer
   integer(long), bind(c, name='H5T_NATIVE_INT64_g') :: native_long
   integer(long), bind(c, name='H5T_C_S1_g') :: c_text
   integer(long), bind(c, name='H5P_CLS_FILE_ACCESS_ID_g') :: file_access
   integer(long), bind(c, name='H5P_CLS_FILE_CREATE_ID_g') :: file_create
   integer(long), bind(c, name='H5P_CLS_GROUP_CREATE_ID_g') :: group_create
   integer(long), bind(c, name='H5P_CLS_DATASET_CREATE_ID_g') :: dataset_create

   interface
      integer(c_int) function h5open() bind(c, name='H5open')
         import :: c_int
      end function h5open
      integer(c_int) function h5dont_atexit() bind(c, name='H5dont_atexit')
         import :: c_int
      end function h5dont_atexit
      !> Which function receives errors: none if null.
      integer(c_int) function h5eset_auto(stack, function, data) bind(c, name='H5Eset_auto2')
         import :: c_int, c_ptr, long
         integer(long), value :: stack
         type(c_ptr), value :: function, data
      end function h5eset_auto

      integer(long) function h5fcreate(path, flags, creation, access) bind(c, name='H5Fcreate')
         import :: c_char, c_int, long
         character(c_char), intent(in) :: path(*)
         integer(c_int), value :: flags
         integer(long), value :: creation, access
      end function h5fcreate
      integer(long) function h5fopen(path, flags, access) bind(c, name='H5Fopen')
         import :: c_char, c_int, long
         character(c_char), intent(in) :: path(*)
         integer(c_int), value :: flags
         integer(long), value :: access
      end function h5fopen
      integer(c_int) function h5fclose(file) bind(c, name='H5Fclose')
         import :: c_int, long
         integer(long), value :: file
      end function h5fclose
      !> Release anything but a file: a group, a dataset, an attribute, a type, a space or a list of properties.
      integer(c_int) function h5release(object) bind(c, name='H5Idec_ref')
         import :: c_int, long
         integer(long), value :: object
      end function h5release

      integer(long) function h5pcreate(class) bind(c, name='H5Pcreate')
         import :: long
         integer(long), value :: class
      end function h5pcreate
      integer(c_int) function h5pset_fclose_degree(list, degree) bind(c, name='H5Pset_fclose_degree')
         import :: c_int, long
         integer(long), value :: list
         integer(c_int), value :: degree
      end function h5pset_fclose_degree
      integer(c_int) function h5pset_libver_bounds(list, low, high) bind(c, name='H5Pset_libver_bounds')
         import :: c_int, long
         integer(long), value :: list
         integer(c_int), value :: low, high
      end function h5pset_libver_bounds
      integer(c_int) function h5pset_link_creation_order(list, order) bind(c, name='H5Pset_link_creation_order')
         import :: c_int, long
         integer(long), value :: list
         integer(c_int), value :: order
      end function h5pset_link_creation_order
      integer(c_int) function h5pset_obj_track_times(list, track) bind(c, name='H5Pset_obj_track_times')
         import :: c_bool, c_int, long
         integer(long), value :: list
         logical(c_bool), value :: track
      end function h5pset_obj_track_times
      integer(c_int) function h5pset_chunk(list, rank, extent) bind(c, name='H5Pset_chunk')
         import :: c_int, long
         integer(long), value :: list
         integer(c_int), value :: rank
         integer(long), intent(in) :: extent(*)
      end function h5pset_chunk
      integer(c_int) function h5pset_fletcher32(list) bind(c, name='H5Pset_fletcher32')
         import :: c_int, long
         integer(long), value :: list
      end function h5pset_fletcher32
      integer(c_int) function h5pset_fill_value(list, type, address) bind(c, name='H5Pset_fill_value')
         import :: c_int, c_ptr, long
         integer(long), value :: list, type
         type(c_ptr), value :: address
      end function h5pset_fill_value

      integer(long) function h5gcreate(place, path, links, creation, access) bind(c, name='H5Gcreate2')
         import :: c_char, long
         integer(long), value :: place, links, creation, access
         character(c_char), intent(in) :: path(*)
      end function h5gcreate
      integer(c_int) function h5lcreate_soft(target, place, path, creation, access) bind(c, name='H5Lcreate_soft')
         import :: c_char, c_int, long
         character(c_char), intent(in) :: target(*), path(*)
         integer(long), value :: place, creation, access
      end function h5lcreate_soft
      integer(c_int) function h5lexists(place, path, access) bind(c, name='H5Lexists')
         import :: c_char, c_int, long
         integer(long), value :: place, access
         character(c_char), intent(in) :: path(*)
      end function h5lexists
      !> Open a group or a dataset.
      integer(long) function h5oopen(place, path, access) bind(c, name='H5Oopen')
         import :: c_char, long
         integer(long), value :: place, access
         character(c_char), intent(in) :: path(*)
      end function h5oopen

      integer(long) function h5acreate(object, name, type, space, creation, access) bind(c, name='H5Acreate2')
         import :: c_char, long
         integer(long), value :: object, type, space, creation, access
         character(c_char), intent(in) :: name(*)
      end function h5acreate
      integer(long) function h5aopen(object, name, access) bind(c, name='H5Aopen')
         import :: c_char, long
         integer(long), value :: object, access
         character(c_char), intent(in) :: name(*)
      end function h5aopen
      integer(c_int) function h5aexists(object, name) bind(c, name='H5Aexists')
         import :: c_char, c_int, long
         integer(long), value :: object
         character(c_char), intent(in) :: name(*)
      end function h5aexists
      integer(c_int) function h5awrite(attribute, type, address) bind(c, name='H5Awrite')
         import :: c_int, c_ptr, long
         integer(long), value :: attribute, type
         type(c_ptr), value :: address
      end function h5awrite

      integer(long) function h5screate(class) bind(c, name='H5Screate')
         import :: c_int, long
         integer(c_int), value :: class
      end function h5screate
      integer(long) function h5screate_simple(rank, extent, limit) bind(c, name='H5Screate_simple')
         import :: c_int, long
         integer(c_int), value :: rank
         integer(long), intent(in) :: extent(*), limit(*)
      end function h5screate_simple
      !> The number of dimensions, and their extents.
      integer(c_int) function h5sget_simple_extent_dims(space, extent, limit) bind(c, name='H5Sget_simple_extent_dims')
         import :: c_int, long
         integer(long), value :: space
         integer(long), intent(out) :: extent(*), limit(*)
      end function h5sget_simple_extent_dims
      integer(c_int) function h5sselect_hyperslab(space, how, start, stride, count, block) bind(c, name='H5Sselect_hyperslab')
         import :: c_int, long
         integer(long), value :: space
         integer(c_int), value :: how
         integer(long), intent(in) :: start(*), stride(*), count(*), block(*)
      end function h5sselect_hyperslab

      integer(long) function h5dcreate(place, path, type, space, links, creation, access) bind(c, name='H5Dcreate2')
         import :: c_char, long
         integer(long), value :: place, type, space, links, creation, access
         character(c_char), intent(in) :: path(*)
      end function h5dcreate
      integer(long) function h5dget_space(dataset) bind(c, name='H5Dget_space')
         import :: long
         integer(long), value :: dataset
      end function h5dget_space
      integer(long) function h5dget_type(dataset) bind(c, name='H5Dget_type')
         import :: long
         integer(long), value :: dataset
      end function h5dget_type
      integer(c_int) function h5dset_extent(dataset, extent) bind(c, name='H5Dset_extent')
         import :: c_int, long
         integer(long), value :: dataset
         integer(long), intent(in) :: extent(*)
      end function h5dset_extent
      integer(c_int) function h5dread(dataset, type, memory, space, transfer, address) bind(c, name='H5Dread')
         import :: c_int, c_ptr, long
         integer(long), value :: dataset, type, memory, space, transfer
         type(c_ptr), value :: address
      end function h5dread
      integer(c_int) function h5dwrite(dataset, type, memory, space, transfer, address) bind(c, name='H5Dwrite')
         import :: c_int, c_ptr, long
         integer(long), value :: dataset, type, memory, space, transfer
         type(c_ptr), value :: address
      end function h5dwrite

      integer(long) function h5tcopy(type) bind(c, name='H5Tcopy')
         import :: long
         integer(long), value :: type
      end function h5tcopy
      integer(c_int) function h5tset_size(type, size) bind(c, name='H5Tset_size')
         import :: c_int, c_size_t, long
         integer(long), value :: type
         integer(c_size_t), value :: size
      end function h5tset_size
      integer(c_size_t) function h5tget_size(type) bind(c, name='H5Tget_size')
         import :: c_size_t, long
         integer(long), value :: type
      end function h5tget_size
      integer(c_int) function h5tset_cset(type, set) bind(c, name='H5Tset_cset')
         import :: c_int, long
         integer(long), value :: type
         integer(c_int), value :: set
      end function h5tset_cset
      integer(c_int) function h5tset_strpad(type, padding) bind(c, name='H5Tset_strpad')
         import :: c_int, long
         integer(long), value :: type
         integer(c_int), value :: padding
      end function h5tset_strpad

      !> Of the library of dimension scales: make a dataset the scale of a dimension of others.
      integer(c_int) function h5dsset_scale(scale, name) bind(c, name='H5DSset_scale')
         import :: c_char, c_int, long
         integer(long), value :: scale
         character(c_char), intent(in) :: name(*)
      end function h5dsset_scale
      integer(c_int) function h5dsattach_scale(dataset, scale, dimension) bind(c, name='H5DSattach_scale')
         import :: c_int, long
         integer(long), value :: dataset, scale
         integer(c_int), value :: dimension
      end function h5dsattach_scale
   end interface

contains

   !> A text as C wants it, with a null at its end.
   pure function c_string(text) result(chars)
      character(*), intent(in) :: text
      character(len(text) + 1, c_char) :: chars
      chars = text//c_null_char
   end function c_string
end module hampm_hdf5_library
