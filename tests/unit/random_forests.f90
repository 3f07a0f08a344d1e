!> Forests that refine and recombine at random, for the unit tests.
module hampm_random_forests
   use hampm_kinds, only: dp
   use hampm_forest, only: forest_t
   implicit none
   private
   public :: random_integer, change_at_random

contains

   !> A random integer from `least` to `most`.
   integer function random_integer(least, most) result(k)
      integer, intent(in) :: least, most
      real(dp) :: r
      call random_number(r)
      k = least + int(r*(most - least + 1))
   end function random_integer

   !> Refine some leaves by one level, recombine some families, and balance. As leaves drawn one by one would rarely make a
   !> whole family, those to recombine are drawn with the three that follow.
   subroutine change_at_random(forest, refined, recombined, max_level)
      type(forest_t), intent(inout) :: forest
      real(dp), intent(in) :: refined            !! part of the leaves
      real(dp), intent(in) :: recombined         !! part of the leaves, refined ones left out
      integer, intent(in) :: max_level           !! leaves of this level are not refined
      integer, allocatable :: change(:)
      real(dp) :: r
      integer :: leaf
      allocate (change(forest%leaf_count()), source=0)
      do leaf = 1, size(change)
         call random_number(r)
         if (r < refined) then
            if (forest%level_of(leaf) < max_level) change(leaf) = 1
         else if (r < refined + recombined) then
            change(leaf:min(leaf + 3, size(change))) = -1
         end if
      end do
      call forest%adapt(change)
      call forest%balance()
   end subroutine change_at_random
end module hampm_random_forests
