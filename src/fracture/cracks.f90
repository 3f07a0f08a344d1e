!> The cracks of a run: the owner of their places, queried by grid, refinement, integrals, measurements and checkpoints. The model's
!> cracks are read once, at the assembly of a run.
!>
!> A crack is a polyline in the reference configuration. An end inside the material is a tip; any other end lies on the surface of
!> the material or beyond it. Tips are numbered through: of the first crack its last point, then its first point, if these are tips;
!> then those of the next crack.
module hampm_cracks
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_archive, only: archive_t
   use hampm_crack_tip, only: archive_surroundings, crack_tip_t, frame_along, upper, lower
   use hampm_crack_lines, only: left_face, right_face, line_t, length_of, both_faces, first_point, last_point
   use hampm_front, only: front_t, region_t
   use hampm_moving_front, only: fronts_of
   use hampm_failure, only: failure_t, exit_input
   use hampm_grid, only: grid_t
   use hampm_plane_cuts, only: plane_cut_t
   use hampm_tensors, only: norm, in_plane
   use hampm_text, only: to_text
   implicit none
   private
   public :: crack_t, cracks_t, first_point, last_point, archive_cracks, open_planes, take_planes, toward, way_in_grid

   real(dp), parameter :: straight = 1e-14_dp    !! 1 less the cosine of the largest angle without a kink

   !> A crack: a line in the reference configuration, in the order in which one walks along it.
   type, extends(line_t) :: crack_t
      character(name_len) :: kind = ''           !! 'symmetry', 'line' or 'path'
      character(name_len) :: name = ''           !! of a path, '' where it has none
      logical :: grows = .false.                 !! whether it does: then its tips are at nodes by chance only
      real(dp) :: mouth(ndim) = 0                !! place of the opening at the mouth, on the crack [m]
      real(dp) :: outside = 0                    !! length of its ends that are out of the material [m]
      logical :: waits = .false.                 !! whether it is absent so far: its points are outside the material, without cuts
      real(dp), allocatable :: given(:, :)       !! of one that may appear: where it does, as a whole [m]
      real(dp) :: covered(2) = 0                 !! of the same: ways from and to which it is in the material [m]
      real(dp) :: aside(ndim) = 0                !! offset of its points from the grid while it is absent [m]
      real(dp), allocatable :: places(:, :)      !! of the same: places along it around which cells refine as around a tip [m]
   contains
      procedure :: length
   end type crack_t

   !> All of them, and their tips.
   type :: cracks_t
      type(crack_t), allocatable :: crack(:)
      type(crack_tip_t), allocatable :: tips(:)
      type(region_t), allocatable :: regions(:)  !! cracked regions of planes of solids
      type(front_t), allocatable :: fronts(:)    !! of these
      real(dp) :: spacing = 0                    !! largest distance of points of a line that moves with the material; 0 if lines
                                                 !! are fixed, as the grid is of the reference configuration [m]
   contains
      procedure :: list_tips
      procedure :: tip_places
      procedure :: lines
      procedure :: carries
      procedure :: extend
      procedure :: place
      procedure :: hide
      procedure :: show
      procedure :: move_tip
      procedure :: plan_way
      procedure :: forget_way
      procedure :: plan_end
      procedure :: end_place
      procedure :: end_direction
      procedure :: turn
      procedure :: find_nodes
      procedure :: by_drive
   end type cracks_t

contains

   !> Its length, all segments together, between its tips and where it enters the material [m].
   pure real(dp) function length(self)
      class(crack_t), intent(in) :: self
      length = 0
      if (.not. self%waits) length = length_of(self%points) - sum(self%bonded) - self%outside
   end function length

   !> Number the tips, and find their places and frames.
   pure subroutine list_tips(self)
      class(cracks_t), intent(inout) :: self
      integer :: c, end, n
      if (allocated(self%tips)) deallocate (self%tips)
      allocate (self%tips(sum([(count(self%crack(c)%is_tip), c=1, size(self%crack))])))
      n = 0
      do c = 1, size(self%crack)
         do end = last_point, first_point, -1
            if (.not. self%crack(c)%is_tip(end)) cycle
            n = n + 1
            call place_tip(self%crack(c), end, self%tips(n))
            self%tips(n)%crack = c
            self%tips(n)%end = end
            self%tips(n)%has_zone = end == last_point .and. self%crack(c)%cohesion > 0 .and. self%crack(c)%bonded(end) > 0
            self%tips(n)%may_close = self%crack(c)%contact
         end do
      end do
   end subroutine list_tips

   !> The points of a crack as one walks to an end, where the last of them is then. Turned twice they are as they were.
   pure function toward(points, end)
      real(dp), intent(in) :: points(:, :)       !! [m]
      integer, intent(in) :: end                 !! `first_point` or `last_point`
      real(dp) :: toward(ndim, size(points, 2))
      toward = points
      if (end == first_point) toward = points(:, size(points, 2):1:-1)
   end function toward

   !> The tip at an end of a crack: its place, its frame and its faces. At the last point the upper face is to the left as one walks
   !> along the crack, at the first to the right.
   pure subroutine place_tip(crack, end, tip)
      type(crack_t), intent(in) :: crack
      integer, intent(in) :: end                 !! `first_point` or `last_point`
      type(crack_tip_t), intent(out) :: tip
      real(dp), allocatable :: points(:, :)
      real(dp) :: outward(ndim)
      integer :: n
      allocate (points, source=toward(crack%open_part(), end))
      n = size(points, 2)
      tip%place = points(:, n)
      outward = points(:, n) - points(:, n - 1)
      tip%face(upper) = crack%face /= merge(right_face, left_face, end == last_point)
      tip%face(lower) = crack%face /= merge(left_face, right_face, end == last_point)
      tip%now = tip%place
      tip%direction = outward/norm(outward)
      tip%axis = frame_along(tip%direction)
      tip%has_ended = crack%waits .or. crack%is_through(end) .and. .not. crack%bonded(end) > 0
      allocate (tip%radii(0))
   end subroutine place_tip

   !> Numbers of the tips, those first that are driven most; of equal ones that of the longer crack, and else by their places: which
   !> of two tips takes the room that both need must not depend on the order of cracks in a model.
   pure function by_drive(self, drive) result(order)
      class(cracks_t), intent(in) :: self
      real(dp), intent(in) :: drive(:)           !! by tip, not below 0, of any unit
      integer :: order(size(drive))
      real(dp), parameter :: same = 1e-6_dp
      real(dp) :: keys(2 + ndim, size(drive))
      integer :: k, at
      do k = 1, size(drive)
         associate (tip => self%tips(k))
            keys(:, k) = [drive(k), self%crack(tip%crack)%length(), tip%place]
         end associate
         do at = k, 2, -1
            if (.not. is_before(keys(:, k), keys(:, order(at - 1)))) exit
            order(at) = order(at - 1)
         end do
         order(at) = k
      end do

   contains

      !> Whether the first key that differs is the larger one.
      pure logical function is_before(a, b)
         real(dp), intent(in) :: a(:), b(:)
         integer :: i
         is_before = .false.
         do i = 1, size(a)
            if (abs(a(i) - b(i)) <= same*max(abs(a(i)), abs(b(i)))) cycle
            is_before = a(i) > b(i)
            return
         end do
      end function is_before
   end function by_drive

   !> Extend a tip by a length, at an angle to the left of its direction; straight on, no new point is made.
   pure subroutine extend(self, number, length, angle)
      class(cracks_t), intent(inout) :: self
      integer, intent(in) :: number              !! of the tip
      real(dp), intent(in) :: length             !! [m]
      real(dp), intent(in) :: angle              !! [rad]
      real(dp), allocatable :: points(:, :)
      real(dp) :: to(ndim)
      associate (tip => self%tips(number))
         allocate (points, source=toward(self%crack(tip%crack)%points, tip%end))
         to = tip%place + length*matmul(tip%axis, in_plane(cos(angle), sin(angle)))
         if (abs(angle) > epsilon(angle)) then
            points = reshape([points, to], [ndim, size(points, 2) + 1])
         else
            points(:, size(points, 2)) = to
         end if
         call self%place(tip%crack, toward(points, tip%end))
      end associate
   end subroutine extend

   !> Deactivate a crack: only its part outside the material remains, as in a notch, whose faces then have no common nodes.
   pure subroutine hide(self, crack)
      class(cracks_t), intent(inout) :: self
      integer, intent(in) :: crack               !! its number
      real(dp), parameter :: nothing = 1e-3_dp   ! of the length
      real(dp) :: outside(2)                     ! length out of the material at the end beyond each one [m]
      type(line_t) :: line
      integer :: end
      associate (of => self%crack(crack))
         of%waits = .true.
         of%is_through = of%is_tip               ! cells are cut to where it ends, and no farther
         line%points = of%given + spread(of%aside, 2, size(of%given, 2))
         outside = [length_of(of%given) - of%covered(2), of%covered(1)]
         do end = first_point, last_point
            if (.not. of%is_tip(end) .or. outside(end) <= nothing*length_of(of%given)) cycle
            line%points = of%given
            line%bonded(end) = length_of(of%given) - outside(end)
         end do
         call self%place(crack, line%open_part())
      end associate
   end subroutine hide

   !> Insert a waiting crack, over a length in the material from its first point on.
   pure subroutine show(self, crack, length)
      class(cracks_t), intent(inout) :: self
      integer, intent(in) :: crack               !! its number
      real(dp), intent(in) :: length             !! [m]
      real(dp), parameter :: rounding = 1e-9_dp  ! of the length
      type(line_t) :: line
      associate (of => self%crack(crack))
         of%waits = .false.
         where (of%is_tip)
            of%is_through = .false.
            of%beyond = 0
         end where
         line%points = of%given
         of%outside = of%covered(1)
         if (of%covered(1) + length < of%covered(2)*(1 - rounding)) then
            line%bonded(last_point) = length_of(of%given) - (of%covered(1) + length)
         else
            of%outside = of%outside + length_of(of%given) - of%covered(2)
         end if
         call self%place(crack, line%open_part())
      end associate
   end subroutine show

   !> Give a crack other points, and its tips their places: a straight part may end at both.
   pure subroutine place(self, crack, points)
      class(cracks_t), intent(inout) :: self
      integer, intent(in) :: crack               !! its number
      real(dp), intent(in) :: points(:, :)       !! [m]
      type(crack_tip_t) :: new
      integer :: k
      self%crack(crack)%points = points
      do k = 1, size(self%tips)
         if (self%tips(k)%crack /= crack) cycle
         associate (tip => self%tips(k))
            call place_tip(self%crack(crack), tip%end, new)
            tip%place = new%place
            tip%axis = new%axis
            tip%has_ended = new%has_ended
            if (self%carries(crack)) cycle       ! the grid has its place
            tip%now = new%now
            tip%direction = new%direction
         end associate
      end do
   end subroutine place

   !> Advance a tip in dynamic growth along the bonded part of its crack.
   pure subroutine move_tip(self, number, way, lines)
      class(cracks_t), intent(inout) :: self
      integer, intent(in) :: number              !! of the tip
      real(dp), intent(in) :: way                !! [m]
      type(line_t), intent(in) :: lines(:)       !! in the grid, of all cracks
      associate (tip => self%tips(number))
         self%crack(tip%crack)%bonded(tip%end) = max(0.0_dp, self%crack(tip%crack)%bonded(tip%end) - way)
         tip%grown = tip%grown + way
         call self%place(tip%crack, self%crack(tip%crack)%points)
         if (.not. self%carries(tip%crack)) return
         call find_in_grid(tip, lines(tip%crack))
      end associate
   end subroutine move_tip

   !> Find where a tip that has grown is in the grid, by the line of its crack there.
   pure subroutine find_in_grid(tip, line)
      type(crack_tip_t), intent(inout) :: tip
      type(line_t), intent(in) :: line
      real(dp), allocatable :: points(:, :)
      real(dp) :: out(ndim)
      allocate (points, source=way_in_grid(tip, line))
      tip%now = points(:, size(points, 2))
      out = tip%now - points(:, size(points, 2) - 1)
      tip%direction = out/norm(out)
   end subroutine find_in_grid

   !> The points of a crack in the grid as one walks to a tip that has grown [m].
   pure function way_in_grid(tip, line) result(points)
      type(crack_tip_t), intent(in) :: tip
      type(line_t), intent(in) :: line           !! of its crack there
      real(dp), allocatable :: points(:, :)
      type(line_t) :: now
      now = line
      now%bonded(tip%end) = max(0.0_dp, line%bonded(tip%end) + line%grown(tip%end) - tip%grown)
      allocate (points, source=toward(now%open_part(), tip%end))
   end function way_in_grid

   !> Plan the path of a tip in dynamic growth: the crack extends from its last point to another one, and is bonded there.
   pure subroutine plan_way(self, number, to)
      class(cracks_t), intent(inout) :: self
      integer, intent(in) :: number              !! of the tip
      real(dp), intent(in) :: to(ndim)           !! [m]
      real(dp), allocatable :: points(:, :)
      integer :: last
      real(dp) :: cosine
      associate (tip => self%tips(number))
         allocate (points, source=toward(self%crack(tip%crack)%points, tip%end))
         last = size(points, 2)
         associate (from => points(:, last), before => points(:, last - 1))
            self%crack(tip%crack)%bonded(tip%end) = self%crack(tip%crack)%bonded(tip%end) + norm(to - from)
            cosine = dot_product(to - from, from - before)/(norm(to - from)*norm(from - before))
         end associate
         if (cosine > 1 - straight .and. .not. self%carries(tip%crack)) then ! else its points keep their places in the material
            points(:, last) = to
         else
            points = reshape([points, to], [ndim, last + 1])
         end if
         call self%place(tip%crack, toward(points, tip%end))
      end associate
   end subroutine plan_way

   !> Cancel the planned path of a tip: the crack ends at it.
   pure subroutine forget_way(self, number)
      class(cracks_t), intent(inout) :: self
      integer, intent(in) :: number              !! of the tip
      real(dp), allocatable :: points(:, :)
      real(dp) :: other
      associate (tip => self%tips(number))
         associate (crack => self%crack(tip%crack))
            other = crack%bonded(3 - tip%end)
            crack%bonded(3 - tip%end) = 0
            allocate (points, source=crack%open_part())
            crack%bonded = 0
            crack%bonded(3 - tip%end) = other
            if (crack%is_through(tip%end)) crack%beyond(tip%end) = 0
            crack%is_through(tip%end) = .false.
         end associate
      end associate
      call self%place(self%tips(number)%crack, points)
   end subroutine forget_way

   !> The last point of the crack of a tip is at a surface or on another crack, with cells cut so far beyond it. A tip that has
   !> reached it has ended.
   pure subroutine plan_end(self, number, beyond)
      class(cracks_t), intent(inout) :: self
      integer, intent(in) :: number              !! of the tip
      real(dp), intent(in) :: beyond             !! [m]
      associate (tip => self%tips(number))
         self%crack(tip%crack)%is_through(tip%end) = .true.
         self%crack(tip%crack)%beyond(tip%end) = beyond
         call self%place(tip%crack, self%crack(tip%crack)%points)
      end associate
   end subroutine plan_end

   !> End of the crack of a tip on its side, bonded or not [m].
   pure function end_place(self, number) result(x)
      class(cracks_t), intent(in) :: self
      integer, intent(in) :: number              !! of the tip
      real(dp) :: x(ndim)
      associate (points => self%crack(self%tips(number)%crack)%points)
         x = points(:, merge(1, size(points, 2), self%tips(number)%end == first_point))
      end associate
   end function end_place

   !> Unit vector of the last straight part of the crack of a tip, bonded or not, away from its other end.
   pure function end_direction(self, number) result(direction)
      class(cracks_t), intent(in) :: self
      integer, intent(in) :: number              !! of the tip
      real(dp) :: direction(ndim)
      integer :: last
      associate (points => toward(self%crack(self%tips(number)%crack)%points, self%tips(number)%end))
         last = size(points, 2)
         direction = (points(:, last) - points(:, last - 1))/norm(points(:, last) - points(:, last - 1))
      end associate
   end function end_direction

   !> Turn the last straight part at a tip around its beginning.
   pure subroutine turn(self, number, angle)
      class(cracks_t), intent(inout) :: self
      integer, intent(in) :: number              !! of the tip
      real(dp), intent(in) :: angle              !! to the left [rad]
      real(dp), allocatable :: points(:, :)
      integer :: n
      associate (tip => self%tips(number))
         allocate (points, source=toward(self%crack(tip%crack)%points, tip%end))
         n = size(points, 2)
         points(:, n) = points(:, n - 1) + norm(points(:, n) - points(:, n - 1))*matmul(tip%axis, in_plane(cos(angle), sin(angle)))
         call self%place(tip%crack, toward(points, tip%end))
      end associate
   end subroutine turn

   !> Places of the present tips in the grid, and along nucleating cracks, so that these always cut the same cells [m], (ndim,
   !> number).
   pure function tip_places(self) result(places)
      class(cracks_t), intent(in) :: self
      real(dp), allocatable :: places(:, :)
      integer :: k, n
      n = count(.not. self%tips%has_ended)
      do k = 1, size(self%crack)
         if (allocated(self%crack(k)%places)) n = n + size(self%crack(k)%places, 2)
      end do
      if (allocated(self%fronts)) n = n + sum([(self%fronts(k)%n(), k=1, size(self%fronts))])
      allocate (places(ndim, n))
      n = 0
      if (allocated(self%fronts)) then
         do k = 1, size(self%fronts)
            places(:, n + 1:n + self%fronts(k)%n()) = self%fronts(k)%at
            n = n + self%fronts(k)%n()
         end do
      end if
      do k = 1, size(self%crack)
         if (.not. allocated(self%crack(k)%places)) cycle
         places(:, n + 1:n + size(self%crack(k)%places, 2)) = self%crack(k)%places
         n = n + size(self%crack(k)%places, 2)
      end do
      do k = 1, size(self%tips)
         if (self%tips(k)%has_ended) cycle
         n = n + 1
         places(:, n) = self%tips(k)%now
      end do
   end function tip_places

   !> Initial lines along which cells are cut; ends that are no tips are extended straight.
   pure function lines(self)
      class(cracks_t), intent(in) :: self
      type(line_t), allocatable :: lines(:)
      integer :: c, k
      allocate (lines(size(self%crack)))
      do c = 1, size(self%crack)
         lines(c) = self%crack(c)%line_t
         lines(c)%held = self%crack(c)%held + self%crack(c)%beyond(first_point)
         if (allocated(self%tips)) then
            do k = 1, size(self%tips)
               if (self%tips(k)%crack == c) lines(c)%grown(self%tips(k)%end) = self%tips(k)%grown
            end do
         end if
         lines(c)%bonded = self%crack(c)%bonded + merge(self%crack(c)%beyond, 0.0_dp, self%crack(c)%bonded > 0 .or. &
                                                        self%crack(c)%is_through .and. lines(c)%grown > 0)
         associate (p => lines(c)%points, last => size(lines(c)%points, 2), beyond => self%crack(c)%beyond)
            p(:, 1) = p(:, 1) + beyond(first_point)*(p(:, 1) - p(:, 2))/norm(p(:, 1) - p(:, 2))
            p(:, last) = p(:, last) + beyond(last_point)*(p(:, last) - p(:, last - 1))/norm(p(:, last) - p(:, last - 1))
         end associate
         if (.not. self%carries(c)) cycle
         lines(c)%origin = with_points_between(lines(c)%points, self%spacing)
         lines(c)%points = lines(c)%origin
      end do
   end function lines

   !> Whether the material carries a crack through the grid: a symmetry plane stays.
   pure logical function carries(self, crack)
      class(cracks_t), intent(in) :: self
      integer, intent(in) :: crack
      carries = self%spacing > 0 .and. self%crack(crack)%face == both_faces
   end function carries

   !> A polyline with more points, none further than `spacing` from the next [m].
   pure function with_points_between(points, spacing) result(more)
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, 2 or more)
      real(dp), intent(in) :: spacing            !! [m]
      real(dp), allocatable :: more(:, :)
      integer :: parts(size(points, 2) - 1), k, i, n
      parts = [(max(1, ceiling(norm(points(:, k + 1) - points(:, k))/spacing)), k=1, size(parts))]
      allocate (more(ndim, sum(parts) + 1))
      n = 0
      do k = 1, size(parts)
         do i = 0, parts(k) - 1
            n = n + 1
            more(:, n) = points(:, k) + real(i, dp)/parts(k)*(points(:, k + 1) - points(:, k))
         end do
      end do
      more(:, n + 1) = points(:, size(points, 2))
   end function with_points_between

   !> Find cells and nodes around the tips in a grid: nodes if a crack that does not grow ends at one, along a grid line, while it
   !> is there. Fails if a crack on a symmetry plane has none.
   subroutine find_nodes(self, grid, failure)
      class(cracks_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      type(failure_t), intent(inout) :: failure
      logical :: found
      integer :: k
      do k = 1, size(self%tips)
         associate (tip => self%tips(k))
            call tip%find_cells(grid%cut_cells%ends(k), self%carries(tip%crack), grid)
            if (self%carries(tip%crack) .and. tip%grown > 0) call find_in_grid(tip, grid%cut_cells%lines(tip%crack))
            if (tip%nodes%in_cell .or. self%crack(tip%crack)%grows .or. tip%has_zone .or. norm(tip%now - tip%place) > 0 &
                .or. all(abs(tip%direction) > straight)) cycle
            call tip%find_nodes(grid, found)
            if (found .or. .not. tip%is_half()) cycle
         end associate
         call failure%report(exit_input, &
            '&crack tip: must be at a grid node, with a node of the grid one cell behind it and one ahead of it')
      end do
   end subroutine find_nodes

   !> Save or restore the places of cracks and the surroundings of their tips. On reading, they are the model's initial ones.
   subroutine archive_cracks(cracks, archive)
      type(cracks_t), intent(inout) :: cracks
      class(archive_t), intent(inout) :: archive
      integer :: k
      do k = 1, size(cracks%crack)
         call archive%section('crack_'//to_text(k))
         call archive_crack(cracks%crack(k), archive)
      end do
      if (archive%failure%failed()) return
      if (archive%is_read) call cracks%list_tips()
      do k = 1, size(cracks%tips)
         call archive%section('tip_'//to_text(k))
         call archive_surroundings(cracks%tips(k), archive)
      end do
      if (allocated(cracks%fronts)) call archive_fronts(cracks%fronts, archive)
   end subroutine archive_cracks

   !> Keep which front has which number: `fronts_of` finds them anew.
   subroutine archive_fronts(fronts, archive)
      type(front_t), allocatable, intent(inout) :: fronts(:)
      class(archive_t), intent(inout) :: archive
      integer :: n, k, nodes
      n = size(fronts)
      call archive%section('fronts')
      call archive%serialise('number', n)
      if (archive%failure%failed()) return
      if (archive%is_read) then
         deallocate (fronts)
         allocate (fronts(n))
      end if
      do k = 1, n
         nodes = 0
         if (.not. archive%is_read) nodes = fronts(k)%n()
         call archive%section('front_'//to_text(k))
         call archive%serialise('crack', fronts(k)%crack)
         call archive%serialise('nodes', nodes)
         if (archive%is_read) then
            allocate (fronts(k)%at(ndim, nodes), fronts(k)%outward(ndim, nodes), fronts(k)%arc(nodes), fronts(k)%on_outline(nodes))
         end if
         call archive%archive_reals('at', ndim*nodes, fronts(k)%at)
      end do
   end subroutine archive_fronts

   !> Apply the cracked regions to the planes of a grid.
   pure subroutine open_planes(cracks, planes)
      type(cracks_t), intent(in) :: cracks
      type(plane_cut_t), allocatable, intent(inout) :: planes(:)
      integer :: k
      if (.not. allocated(planes)) return
      do k = 1, size(planes)
         planes(k)%region_t = cracks%regions(k)
      end do
   end subroutine open_planes

   !> Take the cracked regions from the planes of a grid, and see where they cross.
   pure subroutine take_planes(cracks, planes)
      type(cracks_t), intent(inout) :: cracks
      type(plane_cut_t), intent(inout) :: planes(:)
      integer :: k
      if (.not. allocated(cracks%regions)) allocate (cracks%regions(size(planes)))
      do k = 1, size(planes)
         cracks%regions(k) = planes(k)%region_t
      end do
      call fronts_of(cracks%regions, cracks%fronts)
      do k = 1, size(planes)
         planes(k)%region_t = cracks%regions(k)
      end do
   end subroutine take_planes

   !> Keep where a crack is.
   subroutine archive_crack(crack, archive)
      type(crack_t), intent(inout) :: crack
      class(archive_t), intent(inout) :: archive
      integer :: n
      n = size(crack%points, 2)
      call archive%serialise('number_points', n)
      if (archive%is_read) then
         if (n < 2) call archive%refuse('a crack has two points at least')
         if (archive%failure%failed()) return
         deallocate (crack%points)
         allocate (crack%points(ndim, n))
      end if
      call archive%archive_reals('points', size(crack%points), crack%points)
      call archive%archive_logicals('is_tip', size(crack%is_tip), crack%is_tip)
      call archive%archive_logicals('is_through', size(crack%is_through), crack%is_through)
      call archive%archive_reals('mouth', ndim, crack%mouth)
      call archive%archive_reals('beyond', size(crack%beyond), crack%beyond)
      call archive%archive_reals('bonded', size(crack%bonded), crack%bonded)
      call archive%serialise('outside', crack%outside)
      call archive%serialise('waits', crack%waits)
   end subroutine archive_crack
end module hampm_cracks
