!> When two positions in a model are the same place, two cells as full, and ratios too large to matter.
module hampm_tolerance
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: position_tolerance, part_of_cell, bounded_ratio

contains

   !> Distance below which two positions in a lattice of root cells are the same place [m].
   !>
   !> A billionth of a root cell: far above the rounding of numbers of 16 digits, and below a fiftieth of the finest possible cell,
   !> 24 levels below the root, so that two nodes are never the same place. Far from the origin coordinates are less exact: 4
   !> epsilon of the largest is twice the largest rounding of two positions, each the sum of a product.
   pure real(dp) function position_tolerance(cell, lower, upper) result(tolerance)
      real(dp), intent(in) :: cell               !! size of a root cell [m]
      real(dp), intent(in) :: lower(ndim)        !! corners of the lattice [m]
      real(dp), intent(in) :: upper(ndim)
      tolerance = 1e-9_dp*cell + 4*epsilon(1.0_dp)*max(maxval(abs(lower)), maxval(abs(upper)))
   end function position_tolerance

   !> Filled part of a cell [-] without its rounding: to a billionth, in steps in which halves and quarters are exact. Limits on it
   !> then decide alike in an image of the model, also for cells filled just to the limit.
   elemental real(dp) function part_of_cell(fill) result(part)
      real(dp), intent(in) :: fill
      real(dp), parameter :: steps = 2.0_dp**30
      part = fill
      if (fill > 1/steps) part = anint(fill*steps)/steps
   end function part_of_cell

   !> The ratio of an amount to another one, at most `most`, also where the other is 0 or next to it.
   elemental real(dp) function bounded_ratio(part, whole, most) result(ratio)
      real(dp), intent(in) :: part, whole, most
      ratio = 0
      if (.not. part > 0) return
      ratio = most
      if (part < most*whole) ratio = part/whole
   end function bounded_ratio
end module hampm_tolerance
