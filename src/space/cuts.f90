!> Cuts are segments of grid lines across which a grid is not connected. A place within a cut has a point on either side, and an
!> element sees those of its own side. All else follows from that: mass matrices come apart, forces do not cross, and cells on both
!> sides may be of different sizes, as no side knows of the nodes of the other. The ends of a cut belong to both sides.
!>
!> Where the sides of a cut are `matched`, each has a node wherever the other has one, so that they can act on each other.
module hampm_cuts
   use hampm_kinds, only: dp, ndim, long
   use hampm_forest, only: forest_t
   implicit none
   private
   public :: cut_t, cut_of, place_seen, place_across, is_within, crosses

   !> A segment of a grid line.
   type :: cut_t
      integer :: normal = 1                      !! the direction normal to the cut
      integer(long) :: lower(ndim) = 0           !! its ends in integer coordinates of the forest; they are equal in direction
      integer(long) :: upper(ndim) = 0           !! `normal`, and a place is within the cut where it is between them in all others
      logical :: matched = .false.               !! whether the nodes of both sides stand at the same places
   end type cut_t

contains

   !> The cut between two places, which are on a grid line normal to direction `normal`. A place beyond the lattice is an end
   !> beyond its edge.
   pure function cut_of(forest, normal, from, to, matched) result(cut)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: normal
      real(dp), intent(in) :: from(ndim), to(ndim)      !! [m]
      logical, intent(in), optional :: matched
      type(cut_t) :: cut
      if (present(matched)) cut%matched = matched
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
      integer :: k
      seen = place
      do k = 1, size(cuts)
         associate (n => cuts(k)%normal)
            if (is_within(cuts(k), place) .and. leaf_place(n) >= cuts(k)%lower(n)) seen(n) = -1 - place(n)
         end associate
      end do
   end function place_seen

   !> The place that is opposite to one, as `place_seen` gives it, across a cut whose sides are matched; elsewhere the same.
   pure function place_across(cuts, seen) result(across)
      type(cut_t), intent(in) :: cuts(:)
      integer(long), intent(in) :: seen(ndim)
      integer(long) :: across(ndim), place(ndim)
      integer :: k
      across = seen
      place = merge(-1 - seen, seen, seen < 0)
      do k = 1, size(cuts)
         associate (n => cuts(k)%normal)
            if (cuts(k)%matched .and. is_within(cuts(k), place)) across(n) = -1 - seen(n)
         end associate
      end do
   end function place_across

   !> Whether a place is within a cut: on it, and not at an end.
   pure logical function is_within(cut, place)
      type(cut_t), intent(in) :: cut
      integer(long), intent(in) :: place(ndim)
      logical :: between(ndim)
      between = place > cut%lower .and. place < cut%upper
      between(cut%normal) = place(cut%normal) == cut%lower(cut%normal)
      is_within = all(between)
   end function is_within

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
