!> Outlines of bodies: polygons and circles, and holes of these in them.
!>
!> The part of an outline in a box has exact area and first moments: of a polygon by clipping with the box (Sutherland & Hodgman
!> 1974) and Green's theorem, of a circle by integration between its arcs and the sides of the box in closed form. Holes, inside the
!> outer ring and apart from each other, are subtracted.
!>
!> In solids rings are boxes, cylinders along an axis and spheres. Holes may go through the box around the outer ring.
module hampm_outline
   use hampm_edge_parts, only: edge_part_t, rectangles_of_side, parts_of_mantle, parts_of_sphere
   use hampm_kinds, only: dp, ndim
   use hampm_polygon, only: area_of, clip_to_box, distance_to_polygon, find_meeting, is_in_polygon, moments_of
   use hampm_ring_moments, only: moments_of_circle, moments_of_box, moments_of_cylinder, moments_of_sphere, sort_few
   use hampm_tensors, only: norm, in_plane, quarter_turn
   implicit none
   private
   public :: outline_t, ring_t, wall_t, walls_of, polygon_ring, circle_ring, box_ring, cylinder_ring, least_part

   real(dp), parameter :: pi = acos(-1.0_dp)

   !> Part of a box below which the part of a body in it counts as 0.
   real(dp), parameter :: least_part = 1e-12_dp

   !> A closed line without crossings.
   type :: ring_t
      logical :: is_circle = .false.
      real(dp), allocatable :: points(:, :)      !! of a polygon, in either sense [m], (ndim, 3 or more); of a box its two ends
      real(dp) :: center(ndim) = 0               !! of a circle, a cylinder or a sphere [m]
      real(dp) :: radius = 0                     !! of these [m]
      integer :: axis = 0                        !! the direction of a cylinder; 0: none
      real(dp) :: ends(2) = 0                    !! of it [m]
   contains
      procedure :: area => area_of_ring
      procedure :: lower => lower_of_ring
      procedure :: upper => upper_of_ring
      procedure :: encloses
      procedure :: distance => distance_to_ring
      procedure :: moments => moments_of_ring
      procedure :: corners => corners_of_ring
      procedure :: way_to => way_to_ring
      procedure :: section => section_of_ring
      procedure :: normal_at => normal_of_ring
   end type ring_t

   !> A ring as a wall of a body.
   type, extends(ring_t) :: wall_t
      logical :: is_hole = .false.               !! whether the material is outside of it
   end type wall_t

   !> A ring with others cut out.
   type :: outline_t
      type(ring_t), allocatable :: rings(:)      !! the outer one, then the holes
   contains
      procedure :: is_there
      procedure :: area
      procedure :: covers
      procedure :: covers_within
      procedure :: distance
      procedure :: way_out
      procedure :: moments
      procedure :: parts_in_box
   end type outline_t

contains

   !> The ring of a polygon.
   pure type(ring_t) function polygon_ring(points) result(ring)
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, 3 or more)
      allocate (ring%points, source=points)
   end function polygon_ring

   !> The ring of a circle.
   pure type(ring_t) function circle_ring(center, radius) result(ring)
      real(dp), intent(in) :: center(ndim), radius !! [m]
      ring%is_circle = .true.
      ring%center = center
      ring%radius = radius
   end function circle_ring

   !> A box in space.
   pure type(ring_t) function box_ring(lower, upper) result(ring)
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! [m]
      allocate (ring%points(ndim, 2))
      ring%points(:, 1) = lower
      ring%points(:, 2) = upper
   end function box_ring

   !> A cylinder in space.
   pure type(ring_t) function cylinder_ring(lower, upper, radius) result(ring)
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! ends of its axis, which is a direction of the grid [m]
      real(dp), intent(in) :: radius             !! [m]
      ring = circle_ring((lower + upper)/2, radius)
      ring%axis = maxloc(upper - lower, dim=1)
      ring%ends = [lower(ring%axis), upper(ring%axis)]
   end function cylinder_ring

   !> The walls of some bodies.
   pure function walls_of(bodies) result(walls)
      type(outline_t), intent(in) :: bodies(:)
      type(wall_t), allocatable :: walls(:)
      integer :: b, r, n
      allocate (walls(sum([(size(bodies(b)%rings), b=1, size(bodies))])))
      n = 0
      do b = 1, size(bodies)
         do r = 1, size(bodies(b)%rings)
            n = n + 1
            walls(n)%ring_t = bodies(b)%rings(r)
            walls(n)%is_hole = r > 1
         end do
      end do
   end function walls_of

   !> Distance of a place from the sides of a ring in space, below 0 inside [m].
   pure function beyond(self, x)
      class(ring_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: beyond(ndim)
      real(dp) :: across(ndim)
      beyond = -huge(beyond)
      if (self%is_circle) then
         across = x - self%center
         if (self%axis > 0) then
            beyond(ndim) = abs(across(self%axis)) - (self%ends(2) - self%ends(1))/2
            across(self%axis) = 0
         end if
         beyond(1) = norm(across) - self%radius
      else
         beyond = abs(x - (self%points(:, 1) + self%points(:, 2))/2) - (self%points(:, 2) - self%points(:, 1))/2
      end if
   end function beyond

   !> Area inside a ring, of a polygon above 0 where its points go anticlockwise, else below [m2]; in solids the volume [m3].
   pure real(dp) function area_of_ring(self) result(area)
      class(ring_t), intent(in) :: self
      if (ndim > 2 .and. self%axis > 0) then
         area = pi*self%radius**2*(self%ends(2) - self%ends(1))
      else if (ndim > 2 .and. self%is_circle) then
         area = 4*pi/3*self%radius**3
      else if (ndim > 2) then
         area = product(self%points(:, 2) - self%points(:, 1))
      else if (self%is_circle) then
         area = pi*self%radius**2
      else
         area = area_of(self%points)
      end if
   end function area_of_ring

   !> Lower corner of the box around a ring [m].
   pure function lower_of_ring(self) result(lower)
      class(ring_t), intent(in) :: self
      real(dp) :: lower(ndim)
      if (self%is_circle) then
         lower = self%center - self%radius
         if (self%axis > 0) lower(self%axis) = self%ends(1)
      else
         lower = minval(self%points, dim=2)
      end if
   end function lower_of_ring

   !> Upper corner of the box around a ring [m].
   pure function upper_of_ring(self) result(upper)
      class(ring_t), intent(in) :: self
      real(dp) :: upper(ndim)
      if (self%is_circle) then
         upper = self%center + self%radius
         if (self%axis > 0) upper(self%axis) = self%ends(2)
      else
         upper = maxval(self%points, dim=2)
      end if
   end function upper_of_ring

   !> Whether a point is inside a ring. On it, the answer may be either.
   pure logical function encloses(self, x)
      class(ring_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      if (ndim > 2) then
         encloses = all(beyond(self, x) < 0)
      else if (self%is_circle) then
         encloses = norm(x - self%center) < self%radius
      else
         encloses = is_in_polygon(x, self%points)
      end if
   end function encloses

   !> Distance of a point from a ring [m].
   pure real(dp) function distance_to_ring(self, x) result(distance)
      class(ring_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: out(ndim)
      if (ndim > 2) then
         out = beyond(self, x)
         distance = max(norm(max(out, 0.0_dp)), -maxval(out))
      else if (self%is_circle) then
         distance = abs(norm(x - self%center) - self%radius)
      else
         distance = distance_to_polygon(x, self%points)
      end if
   end function distance_to_ring

   !> Distance of a point from a ring in a direction, in lengths of its vector: huge if the ring is not met.
   pure real(dp) function way_to_ring(self, x, direction) result(way)
      class(ring_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: direction(ndim)
      real(dp) :: middle, root
      integer :: k, n
      way = huge(way)
      if (ndim > 2) then
         way = way_in_space(self, x, direction)
         return
      else if (self%is_circle) then
         middle = -dot_product(x - self%center, direction)/sum(direction**2)
         root = middle**2 - (sum((x - self%center)**2) - self%radius**2)/sum(direction**2)
         if (root < 0) return
         if (middle + sqrt(root) >= 0) way = middle + sqrt(root)
         if (middle - sqrt(root) >= 0) way = middle - sqrt(root)
         return
      end if
      n = size(self%points, 2)
      do k = 1, n
         call find_meeting(x, direction, self%points(:, k), self%points(:, modulo(k, n) + 1), middle, root)
         if (root >= 0 .and. root <= 1 .and. middle >= 0) way = min(way, middle)
      end do
   end function way_to_ring

   !> The same in space: a ring is the intersection of slabs and a circle or a ball, each of which is met twice.
   pure real(dp) function way_in_space(self, x, direction) result(way)
      class(ring_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim), direction(ndim)
      real(dp), dimension(ndim) :: lower, upper, to, ahead
      real(dp) :: first, last, root
      logical :: is_round(ndim)                  ! components of a place along the circle or the ball
      integer :: d
      is_round = self%is_circle
      if (self%axis > 0) is_round(self%axis) = .false.
      lower = self%lower()
      upper = self%upper()
      first = -huge(first)
      last = huge(last)
      do d = 1, ndim
         if (is_round(d)) cycle
         if (.not. abs(direction(d)) > 0) then
            if (x(d) < lower(d) .or. x(d) > upper(d)) last = -huge(last)
            cycle
         end if
         first = max(first, min((lower(d) - x(d))/direction(d), (upper(d) - x(d))/direction(d)))
         last = min(last, max((lower(d) - x(d))/direction(d), (upper(d) - x(d))/direction(d)))
      end do
      to = merge(self%center - x, 0.0_dp, is_round)
      ahead = merge(direction, 0.0_dp, is_round)
      if (.not. any(abs(ahead) > 0)) then
         if (self%is_circle .and. sum(to**2) > self%radius**2) last = -huge(last)
      else
         root = (dot_product(to, ahead)/sum(ahead**2))**2 - (sum(to**2) - self%radius**2)/sum(ahead**2)
         first = merge(max(first, dot_product(to, ahead)/sum(ahead**2) - sqrt(max(root, 0.0_dp))), last, root >= 0)
         last = min(last, dot_product(to, ahead)/sum(ahead**2) + sqrt(max(root, 0.0_dp)))
      end if
      way = huge(way)
      if (last >= 0 .and. last > first) way = merge(first, last, first >= 0)
   end function way_in_space

   !> Section of a ring in space across an axis: convex, counterclockwise against the axis, of a circle a polygon of its area.
   pure function section_of_ring(self, axis, plane) result(points)
      class(ring_t), intent(in) :: self
      integer, intent(in) :: axis
      real(dp), intent(in) :: plane              !! [m]
      real(dp), allocatable :: points(:, :)      !! along the axes that follow it in cyclic order [m], (2, any)
      integer, parameter :: chords = 360
      real(dp), dimension(ndim) :: from, to, middle
      real(dp) :: half, angle
      integer :: along(2), k
      along = modulo(axis + [0, 1], ndim) + 1
      allocate (points(2, 0))
      from = self%lower()
      to = self%upper()
      if (plane < from(axis) .or. plane > to(axis)) return
      middle = (from + to)/2
      half = self%radius
      if (self%axis /= axis) half = sqrt(max(half**2 - (plane - middle(axis))**2, 0.0_dp))
      if (self%is_circle .and. (self%axis == axis .or. self%axis == 0)) then
         angle = 2*pi/chords
         half = half*sqrt(angle/sin(angle))
         points = reshape([(middle(along) + half*[cos(k*angle), sin(k*angle)], k=1, chords)], [2, chords])
         return
      end if
      if (self%is_circle) then
         from = merge(from, middle - half, [(k, k=1, ndim)] == self%axis)
         to = merge(to, middle + half, [(k, k=1, ndim)] == self%axis)
      end if
      associate (a => from(along), b => to(along))
         points = reshape([a(1), a(2), b(1), a(2), b(1), b(2), a(1), b(2)], [2, 4])
      end associate
   end function section_of_ring

   !> Outward unit vector of a ring in space, at its nearest place.
   pure function normal_of_ring(self, x) result(normal)
      class(ring_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: normal(ndim), out(ndim)
      integer :: d
      normal = 0
      out = beyond(self, x)
      d = maxloc(out, dim=1)
      if (self%is_circle .and. d == 1) then
         normal = x - self%center
         if (self%axis > 0) normal(self%axis) = 0
         normal = normal/max(norm(normal), tiny(normal))
      else
         if (self%is_circle) d = self%axis
         associate (from => self%lower(), to => self%upper())
            normal(d) = sign(1.0_dp, x(d) - (from(d) + to(d))/2)
         end associate
      end if
   end function normal_of_ring

   !> Area, in solids volume, inside a ring and a box, and its first moments around the lower corner of the box [m2, m3, m3].
   pure function moments_of_ring(self, lower, upper) result(m)
      class(ring_t), intent(in) :: self
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! corners of the box [m]
      real(dp) :: m(0:ndim)
      real(dp), allocatable :: points(:, :)
      if (ndim > 2) then
         if (self%axis > 0) then
            m = moments_of_cylinder(lower - self%center, upper - self%center, self%radius, self%axis, &
                                    self%ends - self%center(self%axis))
         else if (self%is_circle) then
            m = moments_of_sphere(lower - self%center, upper - self%center, self%radius)
         else
            m = moments_of_box(lower, upper, self%points(:, 1), self%points(:, 2))
         end if
         return
      else if (self%is_circle) then
         m = moments_of_circle(lower - self%center, upper - self%center, self%radius)
         return
      end if
      points = self%points - spread(lower, 2, size(self%points, 2))
      call clip_to_box(points, 0*lower, upper - lower)
      m(:2) = moments_of(points)
      if (self%area() < 0) m = -m
   end function moments_of_ring

   !> Corners of a ring, anticlockwise; of a circle a number of points; in solids places all over the surface [m].
   pure function corners_of_ring(self, of_circle) result(points)
      class(ring_t), intent(in) :: self
      integer, intent(in) :: of_circle
      real(dp), allocatable :: points(:, :)
      type(edge_part_t), allocatable :: parts(:)
      integer :: k
      if (ndim > 2) then
         allocate (parts, source=parts_of_surface(self, self%lower(), self%upper(), self%lower(), &
                                                  maxval(self%upper() - self%lower())/sqrt(of_circle/6.0_dp)))
         points = reshape([(parts(k)%middle, k=1, size(parts))], [ndim, size(parts)])
      else if (self%is_circle) then
         allocate (points(ndim, of_circle))
         do k = 1, of_circle
            points(:, k) = self%center + self%radius*in_plane(cos(2*pi*k/of_circle), sin(2*pi*k/of_circle))
         end do
      else if (self%area() < 0) then
         points = self%points(:, size(self%points, 2):1:-1)
      else
         points = self%points
      end if
   end function corners_of_ring

   !> Whether there is an outline; a rectangle along the grid lines has none.
   pure logical function is_there(self)
      class(outline_t), intent(in) :: self
      is_there = allocated(self%rings)
   end function is_there

   !> Area inside an outline [m2].
   pure real(dp) function area(self)
      class(outline_t), intent(in) :: self
      integer :: k
      area = abs(self%rings(1)%area())
      do k = 2, size(self%rings)
         area = area - abs(self%rings(k)%area())
      end do
   end function area

   !> Whether a point is inside an outline. On its edge, the answer may be either.
   pure logical function covers(self, x)
      class(outline_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer :: k
      covers = self%rings(1)%encloses(x)
      do k = 2, size(self%rings)
         if (covers) covers = .not. self%rings(k)%encloses(x)
      end do
   end function covers

   !> Whether a point is inside an outline, or on its edge. A hole that extends beyond the outer edge is one there too.
   pure logical function covers_within(self, x, tolerance) result(covers)
      class(outline_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: tolerance          !! from the edge [m]
      integer :: k
      covers = self%rings(1)%encloses(x) .or. self%rings(1)%distance(x) <= tolerance
      do k = 2, size(self%rings)
         if (covers) covers = .not. self%rings(k)%encloses(x) .or. self%rings(k)%distance(x) <= tolerance
      end do
   end function covers_within

   !> Distance of a point from the edges of an outline [m].
   pure real(dp) function distance(self, x)
      class(outline_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer :: k
      distance = huge(distance)
      do k = 1, size(self%rings)
         distance = min(distance, self%rings(k)%distance(x))
      end do
   end function distance

   !> Distance of a point from the nearest edge in a direction, in lengths of its vector: huge if there is none.
   pure real(dp) function way_out(self, x, direction)
      class(outline_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: direction(ndim)
      integer :: k
      way_out = huge(way_out)
      do k = 1, size(self%rings)
         way_out = min(way_out, self%rings(k)%way_to(x, direction))
      end do
   end function way_out

   !> Area inside an outline and a box, and its first moments around the lower corner of the box [m2, m3, m3].
   pure function moments(self, lower, upper) result(m)
      class(outline_t), intent(in) :: self
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! corners of the box [m]
      real(dp) :: m(0:ndim)
      real(dp) :: whole, from(ndim), to(ndim)
      integer :: k
      whole = product(upper - lower)
      m = 0
      if (self%distance((lower + upper)/2) > 0.501_dp*norm(upper - lower)) then
         if (self%covers((lower + upper)/2)) m = whole*[1.0_dp, (upper - lower)/2]
         return
      end if
      from = lower
      to = upper
      if (ndim > 2) then                         ! holes may extend outside
         from = max(from, self%rings(1)%lower())
         to = min(to, self%rings(1)%upper())
         if (any(to <= from)) return
      end if
      m = self%rings(1)%moments(from, to)
      do k = 2, size(self%rings)
         m = m - self%rings(k)%moments(from, to)
      end do
      if (ndim > 2) m(1:) = m(1:) + m(0)*(from - lower)
   end function moments

   !> The parts of the edges of an outline with their middle in a box, each within one cell of a lattice, for tractions. All, or
   !> parts of the sides of a number.
   pure function parts_in_box(self, lower, upper, tolerance, origin, spacing, side) result(parts)
      class(outline_t), intent(in) :: self
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! corners of the box [m]
      real(dp), intent(in) :: tolerance          !! below which two positions are the same place [m]
      real(dp), intent(in) :: origin(ndim)       !! of the lattice [m]
      real(dp), intent(in) :: spacing            !! of the lattice [m]
      integer, intent(in) :: side                !! 0: all
      type(edge_part_t), allocatable :: parts(:)
      integer :: k
      allocate (parts(0))
      do k = 1, size(self%rings)
         if (ndim > 2) then
            parts = [parts, parts_with_material(self, parts_of_surface(self%rings(k), max(lower, self%rings(1)%lower()), &
                                                                       min(upper, self%rings(1)%upper()), origin, spacing), &
                                                k > 1, lower - tolerance, upper + tolerance, spacing)]
         else if (self%rings(k)%is_circle) then
            call add_arcs(self%rings(k), k > 1, lower - tolerance, upper + tolerance, spacing, parts)
         else
            call add_sides(self%rings(k), k > 1, lower, upper, tolerance, origin, spacing, parts)
         end if
         where (parts%ring == 0) parts%ring = k
      end do
      if (side > 0) parts = pack(parts, parts%side == side)
   end function parts_in_box

   !> Add the sides of a polygon, divided where they cross the lines of a lattice and the box. The tolerance is for sides along the
   !> box: one that leaves it at a small angle would be within the tolerance for some length, and its traction would act there too.
   pure subroutine add_sides(ring, is_hole, lower, upper, tolerance, origin, spacing, parts)
      type(ring_t), intent(in) :: ring
      logical, intent(in) :: is_hole
      real(dp), intent(in) :: lower(ndim), upper(ndim), tolerance, origin(ndim), spacing
      type(edge_part_t), allocatable, intent(inout) :: parts(:)
      real(dp), allocatable :: corner(:, :), cut(:)
      real(dp) :: a(ndim), b(ndim), normal(ndim), at
      real(dp) :: beyond(ndim)                   ! the box, where a side still is in it [m]
      type(edge_part_t) :: part
      integer :: i, d, k
      allocate (corner, source=ring%corners(0))
      do i = 1, size(corner, 2)
         part%side = merge(size(corner, 2), i - 1, i == 1)
         a = corner(:, part%side)
         if (ring%area() < 0) part%side = size(corner, 2) - mod(part%side, size(corner, 2)) ! written the other way round
         b = corner(:, i)
         if (.not. norm(b - a) > 0) cycle
         normal = quarter_turn(a - b)/norm(b - a)
         if (is_hole) normal = -normal
         beyond = merge(tolerance, 0.0_dp, abs(b - a) <= tolerance)
         cut = [0.0_dp, 1.0_dp]
         do d = 1, ndim
            if (abs(b(d) - a(d)) <= tolerance) cycle
            do k = ceiling((min(a(d), b(d)) - origin(d))/spacing), floor((max(a(d), b(d)) - origin(d))/spacing)
               cut = [cut, (origin(d) + k*spacing - a(d))/(b(d) - a(d))]
            end do
            cut = [cut, (lower(d) - a(d))/(b(d) - a(d)), (upper(d) - a(d))/(b(d) - a(d))]
         end do
         cut = min(max(cut, 0.0_dp), 1.0_dp)
         call sort_few(cut)
         do k = 2, size(cut)
            at = (cut(k - 1) + cut(k))/2
            if ((cut(k) - cut(k - 1))*norm(b - a) <= tolerance) cycle
            part%middle = a + at*(b - a)
            if (any(part%middle < lower - beyond .or. part%middle > upper + beyond)) cycle
            part%half = (cut(k) - cut(k - 1))/2*(b - a)
            part%normal = normal
            parts = [parts, part]
         end do
      end do
   end subroutine add_sides

   !> Add the arcs of a circle, in parts of an eighth of the spacing at most.
   pure subroutine add_arcs(ring, is_hole, lower, upper, spacing, parts)
      type(ring_t), intent(in) :: ring
      logical, intent(in) :: is_hole
      real(dp), intent(in) :: lower(ndim), upper(ndim), spacing
      type(edge_part_t), allocatable, intent(inout) :: parts(:)
      type(edge_part_t), allocatable :: arcs(:)
      logical, allocatable :: is_in(:)
      real(dp) :: angle
      integer :: k, n
      n = max(64, 8*ceiling(2*pi*ring%radius/spacing))
      allocate (arcs(n), is_in(n))
      do k = 1, n
         angle = 2*pi*(k - 0.5_dp)/n
         arcs(k)%normal = in_plane(cos(angle), sin(angle))
         arcs(k)%middle = ring%center + ring%radius*arcs(k)%normal
         arcs(k)%half = pi*ring%radius/n*quarter_turn(arcs(k)%normal)
         if (is_hole) arcs(k)%normal = -arcs(k)%normal
         is_in(k) = all(arcs(k)%middle >= lower .and. arcs(k)%middle <= upper)
      end do
      parts = [parts, pack(arcs, is_in)]
   end subroutine add_arcs

   !> The parts of the surface of a ring in space, flat and round ones within a box.
   pure function parts_of_surface(ring, lower, upper, origin, spacing) result(parts)
      type(ring_t), intent(in) :: ring
      real(dp), intent(in) :: lower(ndim), upper(ndim), origin(ndim), spacing
      type(edge_part_t), allocatable :: parts(:)
      real(dp), dimension(ndim) :: from, to, first, last
      integer :: d
      if (ring%is_circle .and. ring%axis == 0) then
         allocate (parts, source=parts_of_sphere(ring%center, ring%radius, spacing))
         return
      end if
      first = ring%lower()
      last = ring%upper()
      allocate (parts(0))
      do d = 1, ndim
         from = max(lower, first)
         to = min(upper, last)
         if (ring%axis == d) parts = [parts, parts_of_mantle(ring%center, ring%radius, d, [from(d), to(d)], spacing)]
         if (ring%axis > 0 .and. ring%axis /= d) cycle
         from(d) = first(d)
         to(d) = last(d)
         parts = [parts, rectangles_of_side(from, to, d, .false., origin, spacing), &
                  rectangles_of_side(from, to, d, .true., origin, spacing)]
      end do
   end function parts_of_surface

   !> The parts in a box next to material of a body (of rectangles the fraction next to it), found in a thin slab beside them.
   pure function parts_with_material(body, all_parts, is_hole, lower, upper, spacing) result(parts)
      class(outline_t), intent(in) :: body
      type(edge_part_t), intent(in) :: all_parts(:)
      logical, intent(in) :: is_hole
      real(dp), intent(in) :: lower(ndim), upper(ndim), spacing
      type(edge_part_t), allocatable :: parts(:)
      real(dp), parameter :: thin = 1e-5_dp, full = 1 - 1e-9_dp
      real(dp) :: m(0:ndim), inward(ndim), from(ndim), to(ndim)
      logical :: has(size(all_parts))
      integer :: k, d
      parts = all_parts
      do k = 1, size(parts)
         associate (part => parts(k))
            has(k) = all(part%middle >= lower .and. part%middle <= upper)
            if (.not. has(k)) cycle
            if (.not. is_hole) part%normal = -part%normal
            inward = part%normal*thin*spacing
            part%normal = -part%normal
            if (all(part%half <= 0)) then
               has(k) = body%covers(part%middle + inward)
               cycle
            end if
            d = maxloc(abs(inward), dim=1)
            from = part%middle - part%half + min(inward, 0.0_dp)
            to = part%middle + part%half + max(inward, 0.0_dp)
            m = body%moments(from, to)/(to(d) - from(d))
            has(k) = m(0) > least_part*part%area
            if (m(0) >= full*part%area .or. .not. has(k)) cycle
            from = from + m(1:)/m(0)
            from(d) = part%middle(d)
            part%middle = from
            part%half = 0
            part%area = m(0)
         end associate
      end do
      parts = pack(parts, has)
   end function parts_with_material
end module hampm_outline
