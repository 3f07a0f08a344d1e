!> Large arrays in large pages of memory, where the system has them: a pass over the particles reads from many places, and each page
!> that it touches needs an address translation.
module hampm_large_pages
   use, intrinsic :: iso_c_binding, only: c_int, c_size_t, c_intptr_t, c_loc
   use hampm_kinds, only: dp
   implicit none
   private
   public :: prefer_large_pages

   integer(c_intptr_t), parameter :: page = 4096             !! [bytes]
   integer(c_intptr_t), parameter :: large_page = 512*page   !! [bytes]
   integer(c_int), parameter :: advice = 14                  !! MADV_HUGEPAGE of Linux; other systems refuse it or do nothing

   interface
      integer(c_int) function c_madvise(address, length, advice) bind(c, name='madvise')
         import :: c_int, c_size_t, c_intptr_t
         integer(c_intptr_t), value :: address
         integer(c_size_t), value :: length
         integer(c_int), value :: advice
      end function c_madvise
   end interface

contains

   !> Ask for large pages for `n` numbers that have just been allocated and not yet been set.
   subroutine prefer_large_pages(n, values)
      integer, intent(in) :: n
      real(dp), intent(inout), target :: values(n)
      integer(c_intptr_t) :: first, behind
      integer(c_int) :: ignored
      first = transfer(c_loc(values), first)
      behind = first + n*(storage_size(values)/8_c_intptr_t)
      first = (first + page - 1)/page*page
      if (behind - first < 2*large_page) return
      ignored = c_madvise(first, int(behind - first, c_size_t), advice)
   end subroutine prefer_large_pages
end module hampm_large_pages
