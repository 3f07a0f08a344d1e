!> How thick the material is: a plate everywhere as much, a ring as its circumference at the place, 2 pi r.
module hampm_thickness
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: thickness_t

   real(dp), parameter :: pi = acos(-1.0_dp)

   !> The thickness of a plane, in which a place is (x, y); of axisymmetric material x is the radius.
   type :: thickness_t
      real(dp) :: of_plate = 0                   !! [m]
      logical :: is_ring = .false.               !! whether material is axisymmetric
   contains
      procedure :: at
   end type thickness_t

contains

   !> The thickness at a place [m].
   pure real(dp) function at(self, x)
      class(thickness_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      at = self%of_plate
      if (self%is_ring) at = 2*pi*x(1)
   end function at
end module hampm_thickness
