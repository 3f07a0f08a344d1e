!> When two positions in a model are the same place, and two cells as full.
module hampm_tolerance
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: position_tolerance, part_of_cell

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

   !> A part of a cell that is filled [-], without its rounding: to a billionth, in steps in which halves and quarters are exact. What is done
   !> where cells are less full than some part of them is done alike in an image of the model, also where they have just that part.
   elemental real(dp) function part_of_cell(fill) result(part)
      real(dp), intent(in) :: fill
      real(dp), parameter :: steps = 2.0_dp**30
      part = fill
      if (fill > 1/steps) part = anint(fill*steps)/steps
   end function part_of_cell
end module hampm_tolerance
