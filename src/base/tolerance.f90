!> When two positions in a scene are the same place.
module hampm_tolerance
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: position_tolerance

contains

   !> Distance below which two positions in a lattice of root cells are the same place [m].
   !>
   !> A billionth of a root cell: far above the rounding of numbers that are computed with 16 digits, and below a fiftieth of the
   !> finest cell that there can be, 24 levels below the root, so that two nodes are never the same place. Far from the origin
   !> coordinates are less exact than that: 4 epsilon of the largest is twice what the roundings of two positions, each the sum of a
   !> product, can add up to.
   pure real(dp) function position_tolerance(cell, lower, upper) result(tolerance)
      real(dp), intent(in) :: cell               !! size of a root cell [m]
      real(dp), intent(in) :: lower(ndim)        !! corners of the lattice [m]
      real(dp), intent(in) :: upper(ndim)
      tolerance = 1e-9_dp*cell + 4*epsilon(1.0_dp)*max(maxval(abs(lower)), maxval(abs(upper)))
   end function position_tolerance
end module hampm_tolerance
