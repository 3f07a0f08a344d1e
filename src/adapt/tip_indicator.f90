!> Refinement around the tips of cracks.
module hampm_tip_indicator
   use hampm_kinds, only: dp, ndim
   use hampm_indicator, only: refinement_t, may_refine
   use hampm_law, only: value_of
   use hampm_problem, only: problem_t
   implicit none
   private
   public :: mark_around_tips

contains

   !> Refine the leaves within `rings` cells of their own size of a tip. Behind moving tips, recombine those farther away than the
   !> refined region by a cell of the next size.
   subroutine mark_around_tips(r, m, tips, change)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: tips(:, :)
      integer, intent(inout) :: change(:)
      real(dp), parameter :: rounding = 1e-9_dp  ! of distances [cells]
      real(dp) :: distance, edge, middle(ndim)
      integer :: leaf, k, rings
      rings = nint(value_of(r%constants, 'rings', 0.0_dp))
      do leaf = 1, size(change)
         middle = m%grid%forest%middle_of(leaf)
         distance = huge(distance)
         do k = 1, size(tips, 2)
            distance = min(distance, maxval(abs(middle - tips(:, k))))
         end do
         edge = m%grid%forest%size_of(leaf)
         if (r%tips_move .and. distance > (rings + 1)*2*edge*(1 + rounding)) change(leaf) = -1
         if (distance >= rings*edge*(1 - rounding) .or. m%grid%forest%level_of(leaf) >= r%max_level) cycle
         if (may_refine(r, m, leaf)) change(leaf) = 1
      end do
   end subroutine mark_around_tips
end module hampm_tip_indicator
