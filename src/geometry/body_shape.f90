!> Shape of a body: the box around it and, except for a rectangle along the grid lines without holes, its outline.
module hampm_body_shape
   use hampm_kinds, only: dp, ndim
   use hampm_outline, only: outline_t, ring_t, polygon_ring, box_ring
   use hampm_polygon, only: distance_to_segment, do_cross
   use hampm_tensors, only: norm, in_plane, quarter_turn
   implicit none
   private
   public :: body_shape_t, rectangle_ring, rings_overlap

   integer, parameter :: looks = 720             !! around a circle, or at a solid

   !> The place of a body.
   type :: body_shape_t
      real(dp) :: lower(ndim) = 0                !! corner of the box around it [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      type(outline_t) :: outline                 !! none of a rectangle without holes
   contains
      procedure :: whole_outline
      procedure :: holds
      procedure :: area_in
      procedure :: room_beside
      procedure :: gap_to
      procedure :: overlaps
      procedure :: surrounds
      procedure :: add_hole
   end type body_shape_t

contains

   !> The outline of a body, also of a rectangle.
   pure type(outline_t) function whole_outline(self) result(outline)
      class(body_shape_t), intent(in) :: self
      if (self%outline%is_there()) then
         allocate (outline%rings, source=self%outline%rings)
      else
         allocate (outline%rings(1))
         outline%rings(1) = rectangle_ring(self%lower, self%upper)
      end if
   end function whole_outline

   !> The ring of a rectangle, or of a box.
   pure type(ring_t) function rectangle_ring(lower, upper) result(ring)
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! [m]
      if (ndim > 2) then
         ring = box_ring(lower, upper)
      else
         ring = polygon_ring(reshape([lower, in_plane(upper(1), lower(2)), upper, in_plane(lower(1), upper(2))], [ndim, 4]))
      end if
   end function rectangle_ring

   !> Add a hole to a body, which begins as a rectangle.
   pure subroutine add_hole(self, hole)
      class(body_shape_t), intent(inout) :: self
      type(ring_t), intent(in) :: hole
      type(outline_t) :: before
      before = self%whole_outline()
      self%outline = outline_t()
      allocate (self%outline%rings(size(before%rings) + 1))
      self%outline%rings(:size(before%rings)) = before%rings
      self%outline%rings(size(before%rings) + 1) = hole
   end subroutine add_hole

   !> Whether a point is in a body or on its edge.
   pure logical function holds(self, point, tolerance)
      class(body_shape_t), intent(in) :: self
      real(dp), intent(in) :: point(ndim), tolerance !! the latter below which places are the same [m]
      holds = all(point >= self%lower - tolerance) .and. all(point <= self%upper + tolerance)
      if (holds .and. self%outline%is_there()) holds = self%outline%covers_within(point, tolerance)
   end function holds

   !> Area of a body within a box [m2], in solids the volume [m3].
   pure real(dp) function area_in(self, lower, upper) result(area)
      class(body_shape_t), intent(in) :: self
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! corners of the box [m]
      real(dp) :: m(0:ndim)
      if (self%outline%is_there()) then
         m = self%outline%moments(lower, upper)
         area = m(0)
      else
         area = product(max(min(self%upper, upper) - max(self%lower, lower), 0.0_dp))
      end if
   end function area_in

   !> The half width of the largest square around a place that a body does not reach into [m]; 0 at its edge, and in it.
   pure real(dp) function room_beside(self, x) result(room)
      class(body_shape_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      room = max(0.0_dp, maxval([self%lower - x, x - self%upper]))
      if (self%outline%is_there()) room = max(room, merge(0.0_dp, self%outline%distance(x)/sqrt(real(ndim, dp)), &
                                                          self%outline%covers(x)))
   end function room_beside

   !> Distance between two bodies [m].
   pure real(dp) function gap_to(self, other) result(gap)
      class(body_shape_t), intent(in) :: self, other
      type(outline_t) :: a, b
      integer :: i, j
      gap = norm(max(self%lower - other%upper, other%lower - self%upper, 0.0_dp))
      if (.not. (self%outline%is_there() .or. other%outline%is_there())) return
      a = self%whole_outline()
      b = other%whole_outline()
      gap = max(gap, minval([((gap_of_rings(a%rings(i), b%rings(j)), i=1, size(a%rings)), j=1, size(b%rings))]))
   end function gap_to

   !> Distance between two rings [m].
   pure real(dp) function gap_of_rings(p, q) result(gap)
      type(ring_t), intent(in) :: p, q
      if (ndim == 2 .and. p%is_circle) then
         gap = abs(q%distance(p%center) - p%radius)
      else if (ndim == 2 .and. q%is_circle) then
         gap = abs(p%distance(q%center) - q%radius)
      else
         gap = min(least_distance(q, p%corners(looks)), least_distance(p, q%corners(looks)))
      end if
   end function gap_of_rings

   !> The least distance of some places from a ring [m].
   pure real(dp) function least_distance(ring, x) result(distance)
      type(ring_t), intent(in) :: ring
      real(dp), intent(in) :: x(:, :)            !! [m]
      integer :: k
      distance = minval([(ring%distance(x(:, k)), k=1, size(x, 2))])
   end function least_distance

   !> Whether a hole is inside the outer ring of a body, without contact. In solids it may extend beyond the box around the ring.
   pure logical function surrounds(self, hole)
      class(body_shape_t), intent(in) :: self
      type(ring_t), intent(in) :: hole
      real(dp), allocatable :: x(:, :)
      integer :: k
      allocate (x, source=hole%corners(looks))
      if (ndim > 2) then
         surrounds = all(hole%lower() < self%upper .and. hole%upper() > self%lower)
         if (.not. (surrounds .and. self%outline%is_there())) return
         do k = 1, size(x, 2)
            x(:, k) = min(max(x(:, k), self%lower), self%upper)
         end do
         surrounds = is_inside(x, self%outline%rings(1), epsilon(1.0)*norm(self%upper - self%lower))
      else if (self%outline%is_there()) then
         associate (outer => self%outline%rings(1))
            surrounds = all([(outer%encloses(x(:, k)) .and. outer%distance(x(:, k)) > 0, k=1, size(x, 2))])
            if (surrounds .and. .not. outer%is_circle) &
               surrounds = .not. any([(hole%encloses(outer%points(:, k)), k=1, size(outer%points, 2))])
         end associate
      else
         surrounds = all(hole%lower() > self%lower) .and. all(hole%upper() < self%upper)
      end if
   end function surrounds

   !> Whether two bodies share more than an edge. A hole of one body that contains the other is taken into account.
   pure logical function overlaps(self, other, tolerance)
      class(body_shape_t), intent(in) :: self, other
      real(dp), intent(in) :: tolerance          !! distance below which places are the same [m]
      type(outline_t) :: a, b
      integer :: k
      overlaps = all(min(self%upper, other%upper) - max(self%lower, other%lower) > tolerance)
      if (.not. overlaps .or. .not. (self%outline%is_there() .or. other%outline%is_there())) return
      a = self%whole_outline()
      b = other%whole_outline()
      overlaps = rings_overlap(a%rings(1), b%rings(1), tolerance)
      do k = 2, size(a%rings)
         if (overlaps) overlaps = .not. is_inside(b%rings(1)%corners(looks), a%rings(k), tolerance)
      end do
      do k = 2, size(b%rings)
         if (overlaps) overlaps = .not. is_inside(a%rings(1)%corners(looks), b%rings(k), tolerance)
      end do
   end function overlaps

   !> Whether all of some places are inside a ring, or on it.
   pure logical function is_inside(x, outer, tolerance)
      real(dp), intent(in) :: x(:, :)            !! [m]
      type(ring_t), intent(in) :: outer
      real(dp), intent(in) :: tolerance          !! [m]
      integer :: k
      is_inside = all([(outer%encloses(x(:, k)) .or. outer%distance(x(:, k)) <= tolerance, k=1, size(x, 2))])
   end function is_inside

   !> Whether the insides of two rings have a point in common: sides cross, or a corner, a middle of a side or the middle of the
   !> inside of one is in the other.
   pure logical function rings_overlap(a, b, tolerance) result(overlap)
      type(ring_t), intent(in) :: a, b
      real(dp), intent(in) :: tolerance          !! [m]
      real(dp), allocatable :: x(:, :), y(:, :)
      integer :: i, j, m, n
      overlap = .false.
      if (any(a%upper() <= b%lower() + tolerance .or. b%upper() <= a%lower() + tolerance)) return
      x = a%corners(looks)
      y = b%corners(looks)
      overlap = has_point_of(a, y) .or. has_point_of(b, x)
      if (ndim > 2) overlap = overlap .or. .not. (a%is_circle .or. b%is_circle) ! boxes
      if (overlap .or. ndim > 2) return
      m = size(x, 2)
      n = size(y, 2)
      do i = 1, m
         do j = 1, n
            associate (p => x(:, i), q => x(:, mod(i, m) + 1), r => y(:, j), s => y(:, mod(j, n) + 1))
               if (.not. do_cross(p, q, r, s)) cycle
               if (min(distance_to_segment(p, r, s), distance_to_segment(q, r, s), &
                       distance_to_segment(r, p, q), distance_to_segment(s, p, q)) <= tolerance) cycle
               overlap = .true.
               return
            end associate
         end do
      end do
   contains
      !> Whether a corner or a middle of a side, or a point of the inside, of a polygon is inside a ring.
      pure logical function has_point_of(ring, corner)
         type(ring_t), intent(in) :: ring
         real(dp), intent(in) :: corner(:, :)
         real(dp) :: at(ndim), inward(ndim)
         integer :: k, n
         has_point_of = .false.
         n = size(corner, 2)
         do k = 1, n
            associate (from => corner(:, k), to => corner(:, mod(k, n) + 1))
               inward = 0
               if (ndim == 2) inward = quarter_turn(to - from)/norm(to - from)
               at = (from + to)/2 + 4*tolerance*inward
               has_point_of = has_point_of .or. (ring%encloses(from) .and. ring%distance(from) > 4*tolerance) .or. &
                              (ring%encloses(at) .and. ring%distance(at) > 2*tolerance)
            end associate
         end do
      end function has_point_of
   end function rings_overlap
end module hampm_body_shape
