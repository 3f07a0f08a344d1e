!> What HDF5 calls the program's types of data: types, spaces and texts for the other HDF5 modules.
module hampm_hdf5_types
   use, intrinsic :: iso_c_binding, only: c_char, c_null_char
   use hdf5, only: hid_t, hsize_t, size_t, h5kind_to_type, h5_integer_kind, h5_real_kind, h5screate_f, &
      h5screate_simple_f, h5s_scalar_f, h5tcopy_f, h5tset_cset_f, h5tset_size_f, h5tset_strpad_f, h5t_string, &
      h5t_c_s1, h5t_cset_utf8_f, h5t_str_nullpad_f
   use hampm_kinds, only: dp, long
   implicit none
   private
   public :: native_real, native_integer, native_long, text_type, label_type, scalar_space, simple_space, c_string

contains

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
end module hampm_hdf5_types
