!> Cracks in a plane of the grid, and their fronts: geometry alone, of solids only.
!>
!> The cracked region is a polygon in the plane, counterclockwise as seen against the normal; curves are chords far shorter than
!> cells, with the area of the curve. A front is a part of its edge inside the material: from side to side (also of holes and
!> cavities), or closed.
!>
!>    find_fronts(region, fronts)                  the fronts inside material
!>    region%distance(x)                           from the edge of the region in the plane, below 0 where it is cracked
!>    region%uncracked(low, high, area, middle)    of a rectangle
module hampm_front
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_outline, only: box_ring, outline_t, ring_t, wall_t
   use hampm_polygon, only: area_of, clip_segment, clip_to, clip_to_box, distance_to_polygon, is_in_polygon, moments_of, &
                            outward_normal, side_lengths, ways_along
   use hampm_ring_moments, only: sort_few
   use hampm_tensors, only: norm
   implicit none
   private
   public :: grid_plane_t, region_t, front_t, crack_shape_t, region_of, find_fronts, find_cuts, plane_axes, room_of, chords

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: rounding = 1e-9_dp     !! of the box, within which an edge lies on its edge
   real(dp), parameter :: smooth = 0.94_dp       !! cosine of a turn of a polygon beyond which it is a corner: 20 degrees
   integer, parameter :: chords = 8              !! of a curve between two nodes of a front

   !> Shape of a crack in the model.
   type :: crack_shape_t
      character(name_len) :: front = ''          !! 'straight', 'disc', 'ellipse' or 'polygon'
      integer :: axis = ndim                     !! of the normal of the plane
      logical :: is_symmetry = .false.           !! whether the plane is one of symmetry of the model
      real(dp) :: center(ndim) = 0               !! a place on a straight front, the middle of a disc or ellipse [m]
      real(dp) :: direction(ndim) = 0            !! of a straight front: out of the crack
      real(dp) :: length = 0                     !! of a straight crack with two fronts; 0: it reaches the edge of the material [m]
      real(dp), allocatable :: radii(:)          !! one of a disc, two of an ellipse along the axes of the plane [m]
      real(dp), allocatable :: points(:, :)      !! corners of a polygon; in the plane those of a polyline [m], (ndim, any)
   end type crack_shape_t

   !> A plane of the grid.
   type :: grid_plane_t
      integer :: axis = ndim                     !! of the normal of the plane
      integer :: along(2) = 1                    !! the axes of the plane, in cyclic order
      real(dp) :: plane = 0                      !! place of the plane on its axis [m]
      logical :: is_symmetry = .false.           !! whether the plane is one of symmetry of the model
   contains
      procedure :: in_plane => place_in_plane
      procedure :: in_space => place_in_space
   end type grid_plane_t

   !> Another crack that crosses a plane, as a wall on the far side of its faces: fronts end there.
   type, extends(wall_t) :: cut_t
      integer :: across = 0                      !! axis of the normal of its plane
      real(dp) :: faces = 0                      !! place of that plane on the axis [m]
   end type cut_t

   !> The cracked region of a plane.
   type, extends(grid_plane_t) :: region_t
      real(dp) :: lower(ndim) = 0, upper(ndim) = 0 !! of the box around all material in the plane [m]
      real(dp) :: spacing = 0                    !! of the nodes of its fronts, roughly [m]
      real(dp), allocatable :: outline(:, :)     !! corners of the region in the plane [m], (2, any)
      logical, allocatable :: may_be_front(:)    !! of the edge from each corner to the next; the others are far from the material
      logical, allocatable :: is_corner(:)       !! whether the outline has a kink there, not a chord of a curve
      type(outline_t), allocatable :: bodies(:)  !! with material in the plane; not allocated where all of these are boxes
      type(wall_t), allocatable :: walls(:)      !! of these; none of boxes
      type(cut_t), allocatable :: cuts(:)        !! other cracks across it, as `find_cuts` has found them
   contains
      procedure :: all_walls
      procedure :: at_cut
      procedure :: distance
      procedure :: contains => holds
      procedure :: uncracked
      procedure :: cracked_area
      procedure :: shrunk
      procedure :: is_narrow
   end type region_t

   !> A front of such a crack: a polyline of nodes. As one walks along it, as seen against the normal, the crack is to the left.
   type, extends(grid_plane_t) :: front_t
      integer :: crack = 0                       !! number of the crack
      logical :: is_closed = .false.             !! whether the last node is followed by the first
      real(dp), allocatable :: at(:, :)          !! nodes [m], (ndim, n)
      real(dp), allocatable :: outward(:, :)     !! unit vectors in the plane out of the crack, (ndim, n)
      real(dp), allocatable :: weight(:)         !! length of the front that belongs to each node: the integral of its hat [m], (n)
      real(dp), allocatable :: arc(:)            !! way along the front from the first node [m], (n)
      real(dp), allocatable :: on_outline(:)     !! way along the outline from its first corner [m], (n)
      real(dp) :: length = 0                     !! of the front, of a closed one all around [m]
   contains
      procedure :: n => number_of_nodes
      procedure :: ends_at
   end type front_t

contains

   !> The axes of the plane with a normal, in cyclic order.
   pure function plane_axes(axis) result(along)
      integer, intent(in) :: axis                !! of the normal
      integer :: along(2)
      along = modulo(axis + [0, 1], ndim) + 1
   end function plane_axes

   !> The region of a shape. Curves are divided for fronts whose nodes are that far apart; a half plane ends far outside of a box.
   pure function region_of(shape, lower, upper, spacing) result(region)
      type(crack_shape_t), intent(in) :: shape
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! of all material [m]
      real(dp), intent(in) :: spacing            !! [m]
      type(region_t) :: region
      real(dp) :: d(2), reach, angle, radii(2)
      integer :: n, k
      region%axis = shape%axis
      region%along = plane_axes(shape%axis)
      region%plane = shape%center(shape%axis)
      region%is_symmetry = shape%is_symmetry
      region%lower = lower
      region%upper = upper
      region%spacing = spacing
      allocate (region%walls(0))
      associate (center => region%in_plane(shape%center))
         select case (shape%front)
         case ('disc', 'ellipse')
            radii = shape%radii([1, size(shape%radii)])
            n = 4*max(4, ceiling(chords*pi*maxval(radii)/(2*spacing)))
            angle = 2*pi/n
            radii = radii*sqrt(angle/sin(angle)) ! the area of the curve
            allocate (region%outline(2, n))
            do k = 1, n
               region%outline(:, k) = center + radii*[cos((k - 1)*angle), sin((k - 1)*angle)]
            end do
         case ('polygon')
            n = size(shape%points, 2)
            region%plane = shape%points(shape%axis, 1)
            allocate (region%outline(2, n))
            region%outline = shape%points(region%along, :)
            if (area_of(region%outline) < 0) region%outline = region%outline(:, n:1:-1)
         case default
            d = region%in_plane(shape%direction)
            d = d/norm(d)
            reach = 2*norm(upper - lower) + norm(max(abs(shape%center - lower), abs(shape%center - upper))) ! as in a mirror
            allocate (region%outline(2, 4))
            region%outline = reach*reshape([d(2), -d(1), -d(2), d(1), -d(2) - d(1), d(1) - d(2), d(2) - d(1), -d(1) - d(2)], [2, 4])
            region%outline = region%outline + spread(center, 2, 4)
            if (shape%length > 0) region%outline(:, 3:) = region%outline(:, 3:) + spread((reach - shape%length)*d, 2, 2)
         end select
      end associate
      allocate (region%may_be_front(size(region%outline, 2)), source=.true.)
      allocate (region%is_corner(size(region%outline, 2)), source=all(shape%front /= ['disc   ', 'ellipse']))
      if (shape%front == 'polygon') then         ! small turns belong to a curve
         do k = 1, n
            associate (a => region%outline(:, k) - region%outline(:, modulo(k - 2, n) + 1), &
                       b => region%outline(:, modulo(k, n) + 1) - region%outline(:, k))
               region%is_corner(k) = dot_product(a, b) < smooth*norm(a)*norm(b)
            end associate
         end do
      end if
      if (all(shape%front /= ['disc   ', 'ellipse', 'polygon'])) region%may_be_front = [.true., .false., shape%length > 0, .false.]
   end function region_of

   !> The fronts of a region inside material, along its outline.
   pure subroutine find_fronts(whole, fronts)
      type(region_t), intent(in) :: whole
      type(front_t), allocatable, intent(out) :: fronts(:)
      type(region_t) :: region                   ! the same with a corner wherever its outline meets a side of a body
      real(dp), allocatable, dimension(:) :: from, to ! of each edge of the outline, parts of it, where it is inside
      logical, allocatable :: begins(:), ends(:)
      real(dp) :: low(2), high(2), margin
      integer :: n, k, i, first, last
      region = whole
      low = whole%in_plane(whole%lower)
      high = whole%in_plane(whole%upper)
      margin = rounding*norm(high - low)
      call part_edges(region, margin)
      n = size(region%outline, 2)
      allocate (from(n), to(n), begins(n), ends(n))
      do k = 1, n
         associate (a => region%outline(:, k), b => region%outline(:, modulo(k, n) + 1))
            call clip_segment(a, b, low + margin, high - margin, from(k), to(k))
            if (.not. region%may_be_front(k)) to(k) = -1
            if (to(k) <= from(k)) cycle
            associate (middle => a + (from(k) + to(k))/2*(b - a))
               if (region%at_cut(middle) > 0) to(k) = -1
               if (.not. allocated(region%bodies)) cycle
               if (.not. is_in_material(region, middle, margin)) to(k) = -1
            end associate
         end associate
      end do
      do k = 1, n
         associate (before => modulo(k - 2, n) + 1, after => modulo(k, n) + 1)
            begins(k) = to(k) > from(k) .and. (from(k) > 0 .or. .not. (to(before) > from(before) .and. to(before) >= 1))
            ends(k) = to(k) > from(k) .and. (to(k) < 1 .or. .not. (to(after) > from(after) .and. .not. from(after) > 0))
         end associate
      end do
      if (all(to > from) .and. .not. any(begins)) then
         allocate (fronts(1))
         call place_nodes(region, 1, n, from, to, fronts(1))
         return
      end if
      allocate (fronts(count(begins)))
      i = 0
      do first = 1, n
         if (.not. begins(first)) cycle
         last = first
         do while (.not. ends(modulo(last - 1, n) + 1))
            last = last + 1
         end do
         i = i + 1
         call place_nodes(region, first, last, from, to, fronts(i))
         do k = 1, 2                             ! to the box, without the margin
            where (abs(fronts(i)%at(region%along(k), :) - low(k)) < 4*margin) fronts(i)%at(region%along(k), :) = low(k)
            where (abs(fronts(i)%at(region%along(k), :) - high(k)) < 4*margin) fronts(i)%at(region%along(k), :) = high(k)
         end do
      end do
   end subroutine find_fronts

   !> Add a corner, not a kink, wherever the outline of a region meets a side of a body or another crack.
   pure subroutine part_edges(region, shortest)
      type(region_t), intent(inout) :: region
      real(dp), intent(in) :: shortest           !! part of an edge that there is [m]
      type(region_t) :: old
      type(wall_t), allocatable :: walls(:)
      real(dp), allocatable :: at(:)             ! parts of an edge
      real(dp), allocatable :: outline(:, :)
      logical, allocatable :: may_be_front(:), is_corner(:)
      real(dp) :: before
      integer :: n, k, w, i
      walls = region%all_walls()
      if (size(walls) == 0) return
      old = region
      n = size(old%outline, 2)
      allocate (outline(2, 0), may_be_front(0), is_corner(0))
      do k = 1, n
         associate (a => old%in_space(old%outline(:, k)), c => old%in_space(old%outline(:, modulo(k, n) + 1)))
            at = [0.0_dp]
            if (old%may_be_front(k)) then
               do w = 1, size(walls)             ! each is met twice at most
                  at = [at, walls(w)%way_to(a, c - a), 1 - walls(w)%way_to(c, a - c)]
               end do
               at = pack(at, at >= 0 .and. at < 1)
               call sort_few(at)
            end if
            before = 0
            do i = 1, size(at)
               if (i > 1 .and. min(at(i) - before, 1 - at(i))*norm(c - a) <= shortest) cycle
               before = at(i)
               outline = reshape([outline, old%in_plane(a + at(i)*(c - a))], [2, size(outline, 2) + 1])
               may_be_front = [may_be_front, old%may_be_front(k)]
               is_corner = [is_corner, old%is_corner(k) .and. i == 1]
            end do
         end associate
      end do
      call move_alloc(outline, region%outline)
      call move_alloc(may_be_front, region%may_be_front)
      call move_alloc(is_corner, region%is_corner)
   end subroutine part_edges

   !> Find where other cracks cross each plane. One is no wall where a region is on both of its sides already, or on neither.
   pure subroutine find_cuts(regions)
      type(region_t), intent(inout) :: regions(:)
      real(dp), parameter :: thick = 0.5_dp      ! of the spacing of nodes, in which a front that comes there ends
      type(cut_t) :: cut
      type(cut_t), allocatable :: cuts(:)
      real(dp), allocatable :: ends(:), part(:, :)
      real(dp), dimension(ndim) :: low, high
      integer :: k, j, i, along, in_self, in_other ! the last two: axes of planes across each other
      logical :: is_behind(2)
      do k = 1, size(regions)
         allocate (cuts(0))
         do j = 1, size(regions)
            if (regions(j)%axis == regions(k)%axis .or. min(size(regions(j)%outline), size(regions(k)%outline)) == 0) cycle
            associate (self => regions(k), other => regions(j))
               along = sum([(i, i=1, ndim)]) - self%axis - other%axis
               in_self = findloc(self%along, other%axis, dim=1)
               in_other = findloc(other%along, self%axis, dim=1)
               ends = ends_on_line(other, in_other, self%plane)
               do i = 1, size(ends) - 1, 2
                  low = self%lower
                  high = self%upper
                  low(along) = max(low(along), ends(i))
                  high(along) = min(high(along), ends(i + 1))
                  if (low(along) >= high(along)) cycle
                  part = self%outline
                  call clip_to_box(part, self%in_plane(low), self%in_plane(high))
                  if (size(part, 2) == 0) cycle
                  associate (x => part(in_self, :), tolerance => 4*rounding*norm(high - low))
                     is_behind = [minval(x) >= other%plane - tolerance, maxval(x) <= other%plane + tolerance]
                     if (is_behind(1) .eqv. is_behind(2)) cycle
                     low(self%axis) = minval(other%outline(in_other, :))
                     high(self%axis) = maxval(other%outline(in_other, :))
                     low(along) = ends(i)
                     high(along) = ends(i + 1)
                     low(other%axis) = other%plane - merge(thick*self%spacing, tolerance, is_behind(1))
                     high(other%axis) = other%plane + merge(thick*self%spacing, tolerance, is_behind(2))
                  end associate
                  cut%ring_t = box_ring(low, high)
                  cut%is_hole = .true.
                  cut%across = other%axis
                  cut%faces = other%plane
                  cuts = [cuts, cut]
               end do
            end associate
         end do
         call move_alloc(cuts, regions(k)%cuts)
      end do
   end subroutine find_cuts

   !> Where the outline of a region meets a line in its plane, along that, in ascending order: also where it only touches it [m].
   pure function ends_on_line(region, axis, place) result(ends)
      type(region_t), intent(in) :: region
      integer, intent(in) :: axis                !! of the plane, 1 or 2, across the line
      real(dp), intent(in) :: place              !! of the line on that axis [m]
      real(dp), allocatable :: ends(:)
      logical :: above(size(region%outline, 2))
      integer :: n, k, side
      n = size(above)
      do side = 1, 2
         above = merge(region%outline(axis, :) > place, region%outline(axis, :) >= place, side == 1)
         allocate (ends(0))
         do k = 1, n
            associate (a => region%outline(:, k), b => region%outline(:, modulo(k, n) + 1))
               if (above(k) .neqv. above(modulo(k, n) + 1)) &
                  ends = [ends, a(3 - axis) + (place - a(axis))/(b(axis) - a(axis))*(b(3 - axis) - a(3 - axis))]
            end associate
         end do
         if (size(ends) > 0 .or. side == 2) exit
         deallocate (ends)
      end do
      call sort_few(ends)
   end function ends_on_line

   !> All walls at which fronts end: of bodies, and of other cracks.
   pure function all_walls(self) result(walls)
      class(region_t), intent(in) :: self
      type(wall_t), allocatable :: walls(:)
      integer :: n, k
      n = size(self%walls)
      k = 0
      if (allocated(self%cuts)) k = size(self%cuts)
      allocate (walls(n + k))
      walls(:n) = self%walls
      do k = 1, size(walls) - n
         walls(n + k)%ring_t = self%cuts(k)%ring_t
         walls(n + k)%is_hole = .true.
      end do
   end function all_walls

   !> Number of the other crack, in the order of `cuts`, in whose wall a place of the plane is; 0 if there is none.
   pure integer function at_cut(self, y) result(number)
      class(region_t), intent(in) :: self
      real(dp), intent(in) :: y(2)               !! [m]
      integer :: k
      number = 0
      if (.not. allocated(self%cuts)) return
      do k = size(self%cuts), 1, -1
         if (self%cuts(k)%encloses(self%in_space(y))) number = k
      end do
   end function at_cut

   !> Whether there is material at a place of the plane, at both of its sides but on one of symmetry.
   pure logical function is_in_material(region, y, tolerance) result(is)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: y(2), tolerance    !! [m]
      real(dp) :: x(ndim)
      logical :: at(2)
      integer :: side, k
      do side = 1, 2
         x = region%in_space(y)
         x(region%axis) = region%plane + (2*side - 3)*8*tolerance
         at(side) = any([(region%bodies(k)%covers_within(x, tolerance), k=1, size(region%bodies))])
      end do
      is = all(at) .or. region%is_symmetry .and. any(at)
   end function is_in_material

   !> The nodes of a front along edges of an outline: at its ends and its kinks, and in equal ways between them.
   pure subroutine place_nodes(region, first, last, from, to, front)
      type(region_t), intent(in) :: region
      integer, intent(in) :: first, last         !! edges; the last may be counted beyond all of them
      real(dp), intent(in) :: from(:), to(:)     !! of each edge, parts of it, where it is inside [-]
      type(front_t), intent(out) :: front
      real(dp), allocatable :: at(:, :), outward(:, :) ! of nodes, in the plane
      real(dp), dimension(size(from)) :: begin, length ! ways to the edges along the outline, and their lengths [m]
      real(dp) :: way(first:last + 1), wanted, normal(2)
      integer :: n, k, m, i, start, parts
      front%grid_plane_t = region%grid_plane_t
      n = size(region%outline, 2)
      front%is_closed = all(to > from) .and. last - first + 1 == n .and. .not. from(edge(first)) > 0 .and. .not. to(edge(last)) < 1
      begin = ways_along(region%outline)
      length = side_lengths(region%outline)
      way(first) = 0
      do k = first, last
         way(k + 1) = way(k) + (to(edge(k)) - from(edge(k)))*length(edge(k))
      end do
      front%length = way(last + 1)
      allocate (at(2, 0), outward(2, 0), front%arc(0), front%on_outline(0))
      start = first
      do k = first, last                         ! stretches without a kink inside
         if (k < last .and. .not. region%is_corner(edge(k + 1))) cycle
         parts = max(1, nint((way(k + 1) - way(start))/region%spacing))
         if (front%is_closed .and. start == first .and. k == last) parts = 4*max(2, nint(front%length/(4*region%spacing)))
         m = start
         do i = 0, parts
            if (i == 0 .and. start > first) cycle ! the last node of the stretch before
            if (i == parts .and. k == last .and. front%is_closed) exit ! its first one
            wanted = way(start) + i*(way(k + 1) - way(start))/parts
            do while (m < k .and. way(m + 1) < wanted)
               m = m + 1
            end do
            associate (part => from(edge(m)) + (wanted - way(m))/length(edge(m)))
               at = reshape([at, region%outline(:, edge(m)) + part*(region%outline(:, edge(m + 1)) - region%outline(:, edge(m)))], &
                            [2, size(at, 2) + 1])
               normal = (1 - part)*normal_at(m, m) + part*normal_at(m + 1, m)
               if (i == parts .and. k < last) normal = normal_of(k) + normal_of(k + 1)
               if (i == 0 .and. front%is_closed .and. region%is_corner(edge(m))) normal = normal_of(last) + normal_of(first)
            end associate
            outward = reshape([outward, normal/norm(normal)], [2, size(outward, 2) + 1])
            front%arc = [front%arc, wanted]
            front%on_outline = [front%on_outline, begin(edge(m)) + from(edge(m))*length(edge(m)) + wanted - way(m)]
         end do
         start = k + 1
      end do
      front%weight = [front%arc(2:), front%length] - front%arc
      if (.not. front%is_closed) front%weight(front%n()) = 0
      front%weight = (front%weight + cshift(front%weight, -1))/2
      allocate (front%at(ndim, size(at, 2)), front%outward(ndim, size(at, 2)))
      front%outward = 0
      do k = 1, size(at, 2)
         front%at(:, k) = region%in_space(at(:, k))
         front%outward(region%along, k) = outward(:, k)
      end do

   contains

      !> Number of an edge or a corner, from one that may be beyond all of them.
      pure integer function edge(k)
         integer, intent(in) :: k
         edge = modulo(k - 1, n) + 1
      end function edge

      !> Unit vector out of the region at an edge.
      pure function normal_of(k) result(normal)
         integer, intent(in) :: k
         real(dp) :: normal(2)
         normal = outward_normal(region%outline, edge(k))
      end function normal_of

      !> The same at a corner of the outline, for an edge: of the curve, if it has one.
      pure function normal_at(corner, k) result(normal)
         integer, intent(in) :: corner, k
         real(dp) :: normal(2)
         normal = normal_of(k)
         if (.not. region%is_corner(edge(corner))) normal = normal_of(corner - 1) + normal_of(corner)
         normal = normal/norm(normal)
      end function normal_at
   end subroutine place_nodes

   !> Distance of a front along its normals, ahead and behind, to the sides of a box of material or where they meet each other or
   !> another front [m]. Sides at a slant to the normals are those at which a front ends, and no limit.
   pure real(dp) function room_of(fronts, number, lower, upper) result(room)
      type(front_t), intent(in) :: fronts(:)
      integer, intent(in) :: number
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! [m]
      real(dp), parameter :: along_side = 1e-6_dp ! difference of normals by rounding
      real(dp), parameter :: slanted = 0.8_dp
      integer :: k, d, i, next
      associate (front => fronts(number))
         room = maxval(abs([lower(front%axis), upper(front%axis)] - front%plane))
         if (.not. front%is_symmetry) room = minval(abs([lower(front%axis), upper(front%axis)] - front%plane))
         do k = 1, front%n()
            do d = 1, ndim
               if (abs(front%outward(d, k)) < slanted) cycle
               room = min(room, minval(abs(([lower(d), upper(d)] - front%at(d, k))/front%outward(d, k))))
            end do
            do i = 1, size(fronts)
               if (i == number .or. fronts(i)%axis /= front%axis) cycle
               room = min(room, sqrt(minval(sum((fronts(i)%at - spread(front%at(:, k), 2, fronts(i)%n()))**2, dim=1))))
            end do
            if (k == front%n() .and. .not. front%is_closed) cycle
            next = modulo(k, front%n()) + 1
            room = min(room, norm(front%at(:, next) - front%at(:, k)) &
                             /max(norm(front%outward(:, next) - front%outward(:, k)), along_side))
         end do
      end associate
   end function room_of

   !> How many nodes a front has.
   pure integer function number_of_nodes(self)
      class(front_t), intent(in) :: self
      number_of_nodes = size(self%arc)
   end function number_of_nodes

   !> Whether an end of a front is at a wall.
   pure logical function ends_at(self, wall)
      class(front_t), intent(in) :: self
      class(ring_t), intent(in) :: wall
      real(dp), parameter :: on_wall = 1e-6_dp   ! of the front
      integer :: n
      n = self%n()
      ends_at = .not. self%is_closed .and. n > 0
      if (ends_at) ends_at = min(wall%distance(self%at(:, 1)), wall%distance(self%at(:, n))) <= on_wall*self%length
   end function ends_at

   !> A place of space as one of the plane [m].
   pure function place_in_plane(self, x) result(y)
      class(grid_plane_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: y(2)
      y = x(self%along)
   end function place_in_plane

   !> A place of the plane as one of space [m].
   pure function place_in_space(self, y) result(x)
      class(grid_plane_t), intent(in) :: self
      real(dp), intent(in) :: y(2)               !! [m]
      real(dp) :: x(ndim)
      x(self%along) = y
      x(self%axis) = self%plane
   end function place_in_space

   !> Distance of a place from the edge of the region, both seen along the normal; below 0 where the plane is cracked [m].
   pure real(dp) function distance(self, x)
      class(region_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      distance = distance_to_polygon(self%in_plane(x), self%outline, self%may_be_front)
      if (self%contains(x)) distance = -distance
   end function distance

   !> Whether the plane is cracked at a place, seen along the normal.
   pure logical function holds(self, x)
      class(region_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      holds = is_in_polygon(self%in_plane(x), self%outline)
   end function holds

   !> The region without a margin along its possible fronts. It opens at sides of the box of the material on which an edge lies, or
   !> beyond which it lies by less than the margin.
   pure function shrunk(self, by) result(region)
      class(region_t), intent(in) :: self
      real(dp), intent(in) :: by                 !! its width [m]
      type(region_t) :: region
      real(dp) :: normal(2, size(self%outline, 2)), margin(size(self%outline, 2)), low(2), high(2)
      logical, dimension(size(self%outline, 2)) :: is_in, opens
      integer :: n, k
      region%grid_plane_t = self%grid_plane_t
      region%outline = self%outline
      region%may_be_front = self%may_be_front
      region%is_corner = self%is_corner
      n = size(self%outline, 2)
      low = self%in_plane(self%lower)
      high = self%in_plane(self%upper)
      do k = 1, n
         normal(:, k) = outward_normal(self%outline, k)
         is_in(k) = runs_in(0.0_dp)
         opens(k) = runs_in(by) .and. .not. is_in(k)
      end do
      opens = opens .or. .not. is_in .and. (cshift(opens, 1) .or. cshift(opens, -1)) ! beside the box as in it
      margin = merge(by, 0.0_dp, self%may_be_front .and. .not. opens)
      do k = 1, n                                ! to where the edges on either side meet then
         associate (a => normal(:, modulo(k - 2, n) + 1), b => normal(:, k), of_a => margin(modulo(k - 2, n) + 1), &
                    of_b => margin(k))
            if (abs(of_a - of_b) > 0 .and. abs(dot_product(a, b)) < smooth) then
               region%outline(:, k) = region%outline(:, k) - &
                  ((of_a - dot_product(a, b)*of_b)*a + (of_b - dot_product(a, b)*of_a)*b)/(1 - dot_product(a, b)**2)
            else if (dot_product(a, b) > -0.9_dp) then
               region%outline(:, k) = region%outline(:, k) - max(of_a, of_b)*(a + b)/(1 + dot_product(a, b))
            end if
         end associate
      end do

   contains

      !> Whether an edge, moved inward by a length, runs inside the box of the material.
      pure logical function runs_in(inward)
         real(dp), intent(in) :: inward          !! [m]
         real(dp) :: from, to
         associate (way => inward*normal(:, k), tolerance => rounding*norm(high - low), next => modulo(k, n) + 1)
            call clip_segment(self%outline(:, k) - way, self%outline(:, next) - way, low + tolerance, high - tolerance, from, to)
         end associate
         runs_in = to > from
      end function runs_in
   end function shrunk

   !> Whether such a margin leaves less than all edges: the region is narrow somewhere, or an edge short.
   pure logical function is_narrow(self, by)
      class(region_t), intent(in) :: self
      real(dp), intent(in) :: by                 !! [m]
      type(region_t) :: rest
      integer :: n, k
      rest = self%shrunk(by)
      n = size(self%outline, 2)
      is_narrow = .false.
      do k = 1, n
         associate (next => modulo(k, n) + 1)
            is_narrow = is_narrow .or. .not. dot_product(rest%outline(:, next) - rest%outline(:, k), &
                                                         self%outline(:, next) - self%outline(:, k)) > 0
         end associate
      end do
   end function is_narrow

   !> The uncracked part of a rectangle in the plane: its area and middle (the rectangle's if there is none).
   pure subroutine uncracked(self, low, high, area, middle)
      class(region_t), intent(in) :: self
      real(dp), intent(in) :: low(2), high(2)    !! [m]
      real(dp), intent(out) :: area              !! [m2]
      real(dp), intent(out) :: middle(2)         !! [m]
      real(dp), allocatable :: part(:, :)
      real(dp) :: whole, m(0:2)
      integer :: k, n
      whole = product(high - low)
      middle = (low + high)/2
      n = size(self%outline, 2)
      do k = 1, n
         associate (a => self%outline(:, k), b => self%outline(:, modulo(k, n) + 1))
            if (all(min(a, b) < high .and. max(a, b) > low)) exit
         end associate
      end do
      if (k > n) then                            ! no edge is near
         area = merge(0.0_dp, whole, self%contains(self%in_space(middle)))
         return
      end if
      part = self%outline - spread(middle, 2, n) ! from the middle of the rectangle: no digits are lost
      call clip_to_box(part, (low - high)/2, (high - low)/2)
      m = moments_of(part)
      area = whole - m(0)
      if (area > rounding*whole) then
         middle = middle - m(1:)/area
      else
         area = 0
      end if
      if (area > whole*(1 - rounding)) area = whole
   end subroutine uncracked

   !> The cracked area [m2]: of the material, without holes.
   pure real(dp) function cracked_area(self) result(area)
      class(region_t), intent(in) :: self
      real(dp) :: rest, middle(2)
      real(dp), allocatable :: part(:, :)
      integer :: b, r
      if (allocated(self%bodies)) then
         area = 0
         do b = 1, size(self%bodies)
            do r = 1, size(self%bodies(b)%rings)
               part = self%outline
               call clip_to(part, self%bodies(b)%rings(1)%section(self%axis, self%plane))
               if (r > 1) call clip_to(part, self%bodies(b)%rings(r)%section(self%axis, self%plane))
               area = area + merge(-1, 1, r > 1)*area_of(part)
            end do
         end do
         return
      end if
      associate (low => self%in_plane(self%lower), high => self%in_plane(self%upper))
         call self%uncracked(low, high, rest, middle)
         area = product(high - low) - rest
      end associate
   end function cracked_area
end module hampm_front
