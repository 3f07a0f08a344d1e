!> Cuts: segments of grid lines across which a grid is not connected. A place within a cut has a point on either side, and an
!> element sees those of its own side. All else follows from that: mass matrices come apart, forces do not cross, and cells on both
!> sides may be of different sizes, as no side knows of the nodes of the other. The ends of a cut belong to both sides.
module hampm_cuts
   use hampm_kinds, only: dp, ndim, long
   use hampm_forest, only: forest_t
   implicit none
   private
   public :: cut_t, cut_of, place_seen, crosses

   type :: cut_t
      integer :: normal = 1                      !! the direction normal to the cut
      integer(long) :: lower(ndim) = 0           !! its ends in integer coordinates of the forest; they are equal in direction
      integer(long) :: upper(ndim) = 0           !! `normal`, and a place is within the cut where it is between them in all others
   end type cut_t

contains

   !> The cut between two places, which are on a grid line normal to direction `normal`. A place beyond the lattice is an end
   !> beyond its edge.
   pure function cut_of(forest, normal, from, to) result(cut)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: normal
      real(dp), intent(in) :: from(ndim), to(ndim)      !! [m]
      type(cut_t) :: cut
      cut%normal = normal
      cut%lower = min(forest%nearest_place(from), forest%nearest_place(to))
      cut%upper = max(forest%nearest_place(from), forest%nearest_place(to))
   end function cut_of

   !> The place by which the points at `place` are told apart, as a leaf sees it: where the place is within a cut and the leaf
   !> above, a place of its own outside the lattice.
   pure function place_seen(cuts, place, leaf_place) result(seen)
      type(cut_t), intent(in) :: cuts(:)
      integer(long), intent(in) :: place(ndim)
      integer(long), intent(in) :: leaf_place(ndim)     !! lower corner of the leaf
      integer(long) :: seen(ndim)
      logical :: between(ndim)
      integer :: k
      seen = place
      do k = 1, size(cuts)
         associate (cut => cuts(k), n => cuts(k)%normal)
            between = place > cut%lower .and. place < cut%upper
            between(n) = place(n) == cut%lower(n)
            if (all(between) .and. leaf_place(n) >= cut%lower(n)) seen(n) = -1 - place(n)
         end associate
      end do
   end function place_seen

   !> Whether the way from one place to another leads from one side of a cut to the other.
   pure logical function crosses(cut, forest, from, to)
      type(cut_t), intent(in) :: cut
      type(forest_t), intent(in) :: forest
      real(dp), intent(in) :: from(ndim), to(ndim)      !! [m]
      real(dp) :: lower(ndim), upper(ndim), line
      logical :: between(ndim)
      lower = forest%position(cut%lower)
      upper = forest%position(cut%upper)
      line = lower(cut%normal)
      between = from > lower .and. from < upper
      between(cut%normal) = (from(cut%normal) < line) .neqv. (to(cut%normal) < line)
      crosses = all(between)
   end function crosses
end module hampm_cuts
