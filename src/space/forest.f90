!> The forest: a lattice of square root cells that covers the scene. Each root cell is one leaf.
module hampm_forest
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: forest_t, outside

   integer, parameter :: outside = 0             !! the leaf of a place that the lattice does not cover

   type :: forest_t
      real(dp) :: lower(ndim) = 0                !! lower corner of the lattice [m]
      real(dp) :: cell = 0                       !! size of a root cell [m]
      integer :: cells(ndim) = 0                 !! number of root cells in each direction
   contains
      procedure :: leaf_count
      procedure :: leaf_at
      procedure :: coordinates
      procedure :: corner_position
   end type forest_t

contains

   !> Number of leaves.
   pure integer function leaf_count(self)
      class(forest_t), intent(in) :: self
      leaf_count = product(self%cells)
   end function leaf_count

   !> The leaf that covers the place `x`; `outside` where there is none, or where `x` is not a number.
   pure integer function leaf_at(self, x)
      class(forest_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! place [m]
      real(dp) :: lattice(ndim)
      integer :: i, d
      lattice = (x - self%lower)/self%cell
      leaf_at = outside
      if (.not. all(lattice >= 0 .and. lattice < self%cells)) return
      i = 0
      do d = ndim, 1, -1
         i = i*self%cells(d) + int(lattice(d))
      end do
      leaf_at = i + 1
   end function leaf_at

   !> Integer coordinates of a leaf on the lattice, from 0.
   pure function coordinates(self, leaf) result(c)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: leaf
      integer :: c(ndim)
      integer :: rest, d
      rest = leaf - 1
      do d = 1, ndim
         c(d) = mod(rest, self%cells(d))
         rest = rest/self%cells(d)
      end do
   end function coordinates

   !> Position of the lattice point with integer coordinates `c` [m].
   pure function corner_position(self, c) result(x)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: c(ndim)
      real(dp) :: x(ndim)
      x = self%lower + c*self%cell
   end function corner_position
end module hampm_forest
