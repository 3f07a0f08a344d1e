!> Segments, lines of segments and polygons: distances, intersections, clipping, areas and moments.
!>
!> Points are columns. Areas, sides and crossings use their first two components; distances use all.
module hampm_polygon
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   implicit none
   private
   public :: cross, twice_area, distance_to_segment, distance_to_line, distance_to_polygon, do_cross, find_crossing, find_meeting, &
             clip_segment, clip, clip_to_box, clip_to, moments_of, area_of, is_in_polygon, side_lengths, outward_normal, ways_along

contains

   !> Product of two vectors of the plane, above 0 where the second one is to the left of the first.
   pure real(dp) function cross(a, b)
      real(dp), intent(in) :: a(2), b(2)
      cross = a(1)*b(2) - a(2)*b(1)
   end function cross

   !> Twice the area of a triangle, above 0 where its corners go anticlockwise [m2].
   pure real(dp) function twice_area(a, b, c)
      real(dp), intent(in) :: a(2), b(2), c(2)   !! [m]
      twice_area = (b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1))
   end function twice_area

   !> Distance of a point from a segment [m].
   pure real(dp) function distance_to_segment(x, a, b) result(distance)
      real(dp), intent(in) :: x(ndim), a(ndim), b(ndim) !! and its ends, which may be the same [m]
      associate (t => dot_product(x - a, b - a)/max(sum((b - a)**2), tiny(1.0_dp)))
         distance = norm(x - a - min(max(t, 0.0_dp), 1.0_dp)*(b - a))
      end associate
   end function distance_to_segment

   !> Distance of a point from a line of segments [m].
   pure real(dp) function distance_to_line(x, points) result(distance)
      real(dp), intent(in) :: x(ndim), points(:, :) !! [m], (ndim, 2 or more)
      integer :: k
      distance = minval([(distance_to_segment(x, points(:, k - 1), points(:, k)), k=2, size(points, 2))])
   end function distance_to_line

   !> Distance of a point from all sides of a polygon, or from some [m].
   pure real(dp) function distance_to_polygon(x, points, sides) result(distance)
      real(dp), intent(in) :: x(2), points(:, :) !! [m]
      logical, intent(in), optional :: sides(:)  !! sides that count, each from its corner to the next
      real(dp) :: from(2), side(2), part
      integer :: k, next
      distance = huge(distance)
      do k = 1, size(points, 2)
         if (present(sides)) then
            if (.not. sides(k)) cycle
         end if
         next = merge(1, k + 1, k == size(points, 2))
         from = x - points(:2, k)
         side = points(:2, next) - points(:2, k)
         part = min(max(dot_product(from, side)/max(sum(side**2), tiny(part)), 0.0_dp), 1.0_dp)
         distance = min(distance, sum((from - part*side)**2))
      end do
      distance = sqrt(distance)
   end function distance_to_polygon

   !> Whether two segments have a point in common.
   pure logical function do_cross(a, b, c, d)
      real(dp), intent(in) :: a(:), b(:), c(:), d(:) !! from a to b, and from c to d [m]
      do_cross = all(max(min(a, b), min(c, d)) <= min(max(a, b), max(c, d)))
      if (do_cross) do_cross = twice_area(a, b, c)*twice_area(a, b, d) <= 0 .and. twice_area(c, d, a)*twice_area(c, d, b) <= 0
   end function do_cross

   !> The first two non-adjacent segments of a line, or sides of a polygon, that cross, by their first points; 0 if none do.
   pure subroutine find_crossing(points, is_closed, i, j)
      real(dp), intent(in) :: points(:, :)       !! [m]
      logical, intent(in) :: is_closed           !! whether it is a polygon
      integer, intent(out) :: i, j
      integer :: n, last
      n = size(points, 2)
      last = merge(n, n - 1, is_closed)
      do i = 1, last - 2
         do j = i + 2, last
            if (is_closed .and. i == 1 .and. j == n) cycle
            if (do_cross(points(:, i), points(:, i + 1), points(:, j), points(:, modulo(j, n) + 1))) return
         end do
      end do
      i = 0
      j = 0
   end subroutine find_crossing

   !> Intersection of a straight line with the line of a segment; huge numbers if they are parallel.
   pure subroutine find_meeting(from, along, a, b, way, at)
      real(dp), intent(in) :: from(2), along(2)  !! a place of the line, and its direction, of any length
      real(dp), intent(in) :: a(2), b(2)         !! the ends of the segment
      real(dp), intent(out) :: way               !! from the place, in lengths of the direction
      real(dp), intent(out) :: at                !! on the segment, from 0 at its first end to 1 at its last
      real(dp) :: across
      across = cross(along, b - a)
      way = huge(way)
      at = huge(at)
      if (.not. abs(across) > 0) return
      way = cross(a - from, b - a)/across
      at = cross(a - from, along)/across
   end subroutine find_meeting

   !> Parts of a segment between which it is in a rectangle; the last is below the first where it is nowhere (Liang & Barsky 1984).
   pure subroutine clip_segment(a, b, low, high, from, to)
      real(dp), intent(in) :: a(2), b(2)         !! its ends [m]
      real(dp), intent(in) :: low(2), high(2)    !! of the rectangle [m]
      real(dp), intent(out) :: from, to          !! [-]
      integer :: d
      from = 0
      to = 1
      do d = 1, 2
         if (abs(b(d) - a(d)) > 0) then
            associate (t => ([low(d), high(d)] - a(d))/(b(d) - a(d)))
               from = max(from, minval(t))
               to = min(to, maxval(t))
            end associate
         else if (a(d) < low(d) .or. a(d) > high(d)) then
            to = -1
         end if
      end do
   end subroutine clip_segment

   !> Clip a polygon to one side of a line, the line included (Sutherland & Hodgman 1974). New corners are on the line, to the last
   !> digit if it is along an axis.
   pure subroutine clip(points, on, inward)
      real(dp), allocatable, intent(inout) :: points(:, :) !! in either sense, (2, any)
      real(dp), intent(in) :: on(2), inward(2)   !! a place of the line, and its normal of any length, to the kept side
      real(dp) :: kept(2, 2*size(points, 2)), a(2), b(2), of_a, of_b ! corners, and their heights
      integer :: k, n
      if (size(points, 2) == 0) return
      n = 0
      a = points(:2, size(points, 2))
      of_a = dot_product(inward, a - on)
      do k = 1, size(points, 2)
         b = points(:2, k)
         of_b = dot_product(inward, b - on)
         if (min(of_a, of_b) < 0 .and. max(of_a, of_b) > 0) then
            n = n + 1
            kept(:, n) = a + of_a/(of_a - of_b)*(b - a)
            kept(:, n) = kept(:, n) - dot_product(inward, kept(:, n) - on)/sum(inward**2)*inward
         end if
         if (of_b >= 0) then
            n = n + 1
            kept(:, n) = b
         end if
         a = b
         of_a = of_b
      end do
      points = kept(:, :n)
   end subroutine clip

   !> Clip a polygon to a rectangle.
   pure subroutine clip_to_box(points, low, high)
      real(dp), allocatable, intent(inout) :: points(:, :)
      real(dp), intent(in) :: low(2), high(2)    !! its corners
      integer :: d
      do d = 1, 2
         associate (axis => real([2 - d, d - 1], dp))
            call clip(points, low, axis)
            call clip(points, high, -axis)
         end associate
      end do
   end subroutine clip_to_box

   !> Clip a polygon to a convex one.
   pure subroutine clip_to(points, window)
      real(dp), allocatable, intent(inout) :: points(:, :)
      real(dp), intent(in) :: window(:, :)       !! anticlockwise, (2, any)
      integer :: k
      if (size(window, 2) == 0) points = points(:, :0)
      do k = 1, size(window, 2)
         call clip(points, window(:, k), -outward_normal(window, k))
      end do
   end subroutine clip_to

   !> Area and first moments of a polygon about the origin, by Green's theorem, above 0 if counterclockwise [m2, m3, m3].
   pure function moments_of(points) result(m)
      real(dp), intent(in) :: points(:, :)       !! [m], (2, any)
      real(dp) :: m(0:2)
      real(dp) :: twice
      integer :: k, before
      m = 0
      do k = 1, size(points, 2)
         before = merge(size(points, 2), k - 1, k == 1)
         twice = points(1, before)*points(2, k) - points(2, before)*points(1, k)
         m(0) = m(0) + twice/2
         m(1:) = m(1:) + twice*(points(:2, before) + points(:2, k))/6
      end do
   end function moments_of

   !> Area of a polygon, above 0 where its corners go anticlockwise [m2].
   pure real(dp) function area_of(points) result(area)
      real(dp), intent(in) :: points(:, :)       !! [m], (2, any)
      real(dp) :: a(2), b(2)
      integer :: k
      area = 0
      do k = 3, size(points, 2)
         a = points(:2, k - 1) - points(:2, 1)
         b = points(:2, k) - points(:2, 1)
         area = area + (a(1)*b(2) - a(2)*b(1))/2
      end do
   end function area_of

   !> Whether a point is inside a polygon. On its edge either result is possible.
   pure logical function is_in_polygon(x, points) result(is)
      real(dp), intent(in) :: x(2), points(:, :) !! [m]
      integer :: k, before
      is = .false.
      do k = 1, size(points, 2)
         before = merge(size(points, 2), k - 1, k == 1)
         associate (a => points(:, before), b => points(:, k))
            if ((a(2) > x(2)) .eqv. (b(2) > x(2))) cycle
            if (x(1) < a(1) + (b(1) - a(1))*((x(2) - a(2))/(b(2) - a(2)))) is = .not. is
         end associate
      end do
   end function is_in_polygon

   !> Length of each side of a polygon [m].
   pure function side_lengths(points) result(length)
      real(dp), intent(in) :: points(:, :)       !! [m]
      real(dp) :: length(size(points, 2))
      length = sqrt(sum((cshift(points, 1, dim=2) - points)**2, dim=1))
   end function side_lengths

   !> The way along a polygon to each of its corners, from the first on [m].
   pure function ways_along(points) result(way)
      real(dp), intent(in) :: points(:, :)       !! [m]
      real(dp) :: way(size(points, 2))
      integer :: k
      way(1) = 0
      do k = 2, size(way)
         way(k) = way(k - 1) + norm(points(:, k) - points(:, k - 1))
      end do
   end function ways_along

   !> Unit vector to the right of a side of a polygon: outward if counterclockwise. 0 for a side without length.
   pure function outward_normal(points, side) result(normal)
      real(dp), intent(in) :: points(:, :)       !! (2, any)
      integer, intent(in) :: side                !! from the corner of this number to the next
      real(dp) :: normal(2)
      normal = points(:2, modulo(side, size(points, 2)) + 1) - points(:2, side)
      normal = [normal(2), -normal(1)]/max(norm(normal), tiny(normal))
   end function outward_normal
end module hampm_polygon
