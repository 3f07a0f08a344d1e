!> Fronts of cracks in planes that advance: geometry alone, of solids only.
!>
!> Corners of the outline move along their normals, those beyond the ends of fronts with these ends: fronts slide along sides. An
!> outline represents a curve of the same area, before and after a move and after division. Kinks become arcs where the crack is
!> convex and stay kinks elsewhere, where corners that meet are merged. Nothing heals: advances are not negative.
module hampm_moving_front
   use hampm_kinds, only: dp
   use hampm_front, only: region_t, front_t, find_cuts, find_fronts, chords
   use hampm_polygon, only: area_of, clip_segment, cross, find_crossing, find_meeting, normal_of => outward_normal, side_lengths, &
                            ways_along
   use hampm_tensors, only: norm
   implicit none
   private
   public :: advance_region, fronts_of

   real(dp), parameter :: of_arc = acos(-1.0_dp)/16 !! angle of each chord of the arc that a kink becomes [rad]
   real(dp), parameter :: kink = 0.5_dp          !! angle between chords beyond which they are no curve [rad]
   real(dp), parameter :: most = 0.25_dp, shortest = 0.5_dp !! way of a move, and distance of corners that come together, in chords
   integer, parameter :: moves_between_looks = 8 !! whether parts of the outline have met

   !> An outline that moves, with the way of each of its corners.
   type :: moving_t
      real(dp), allocatable :: at(:, :)          !! [m]
      real(dp), allocatable :: way(:)            !! [m]
      logical, allocatable :: may_be_front(:), is_corner(:) !! as in a region
      integer :: n = 0                           !! how many there are, while some are added
   end type moving_t

contains

   !> Find the present fronts of all planes, and where planes cross, with the number of the nearest front of the same crack before.
   !> Ended fronts keep their numbers, without nodes; new ones follow all others.
   pure subroutine fronts_of(regions, fronts)
      type(region_t), intent(inout) :: regions(:)
      type(front_t), allocatable, intent(inout) :: fronts(:)
      type(front_t), allocatable :: before(:), here(:), more(:)
      real(dp), allocatable :: away(:, :)        ! of the middle of each front from each one before [m]
      integer :: k, i, j, n, pair(2)
      if (allocated(fronts)) call move_alloc(fronts, before)
      if (.not. allocated(before)) allocate (before(0))
      fronts = before
      call find_cuts(regions)
      do i = 1, size(before)
         fronts(i)%grid_plane_t = regions(before(i)%crack)%grid_plane_t
         fronts(i)%at = before(i)%at(:, :0)
         fronts(i)%outward = before(i)%outward(:, :0)
         fronts(i)%arc = before(i)%arc(:0)
         fronts(i)%on_outline = before(i)%on_outline(:0)
         fronts(i)%weight = before(i)%arc(:0)
      end do
      do k = 1, size(regions)
         call find_fronts(regions(k), here)
         here%crack = k
         allocate (away(size(here), size(before)), source=huge(1.0_dp))
         do j = 1, size(before)
            if (before(j)%crack /= k .or. before(j)%n() == 0) cycle
            do i = 1, size(here)
               associate (middle => here(i)%n()/2 + 1)
                  away(i, j) = sqrt(minval(sum((before(j)%at - spread(here(i)%at(:, middle), 2, before(j)%n()))**2, dim=1)))
               end associate
            end do
         end do
         do while (any(away < huge(away)))
            pair = minloc(away)
            fronts(pair(2)) = here(pair(1))
            here(pair(1))%crack = 0
            away(pair(1), :) = huge(away)
            away(:, pair(2)) = huge(away)
         end do
         deallocate (away)
         n = size(fronts)
         allocate (more(n + count(here%crack == k)))
         more(:n) = fronts
         do i = 1, size(here)
            if (here(i)%crack == 0) cycle
            n = n + 1
            more(n) = here(i)
         end do
         call move_alloc(more, fronts)
      end do
   end subroutine fronts_of

   !> Advance all fronts of a region, as `find_fronts` found them. If they would enclose uncracked material the region stays.
   pure subroutine advance_region(region, fronts, ways, meets_itself)
      type(region_t), intent(inout) :: region
      type(front_t), intent(in) :: fronts(:)
      real(dp), intent(in) :: ways(:)            !! along `outward`, of the nodes of all fronts, one after another [m]
      logical, intent(out) :: meets_itself
      type(moving_t) :: new
      real(dp) :: chord
      integer :: moves, k
      meets_itself = .false.
      if (size(fronts) == 0 .or. .not. any(ways > 0)) return
      chord = region%spacing/chords
      new = moving_t(region%outline, ways_along(region%outline), region%may_be_front, region%is_corner) ! initial places
      call divide(new, region%in_plane(region%lower), region%in_plane(region%upper), chord, sum(side_lengths(region%outline)))
      new%way = ways_at(new%way)
      where ([(region%at_cut(new%at(:, k)) > 0, k=1, size(new%way))]) new%way = 0
      moves = max(1, ceiling(maxval(new%way)/(most*chord)))
      new%way = new%way/moves
      do k = 1, moves
         if (k > 1) call divide(new, region%in_plane(region%lower), region%in_plane(region%upper), chord, (new%way(1)))
         call move(new)
         call join(new, shortest*chord)
         if (mod(k, moves_between_looks) > 0 .and. k < moves) cycle
         call cut_loops(new, meets_itself)
         if (meets_itself) return
      end do
      call end_at_cuts(region, new)
      deallocate (region%outline, region%may_be_front, region%is_corner)
      call move_alloc(new%at, region%outline)
      call move_alloc(new%may_be_front, region%may_be_front)
      call move_alloc(new%is_corner, region%is_corner)

   contains

      !> Ways of places along the outline: between nodes, and beyond the ends of fronts, by lines.
      pure function ways_at(on) result(way)
         real(dp), intent(in) :: on(:)           !! [m]
         real(dp) :: way(size(on)), node(size(ways)), around, part
         integer :: before, after, i, f
         node = [(fronts(f)%on_outline, f=1, size(fronts))]
         around = sum(side_lengths(region%outline))
         do i = 1, size(on)
            before = minloc(modulo(on(i) - node, around), dim=1)
            after = minloc(modulo(node - on(i), around), dim=1)
            part = modulo(on(i) - node(before), around)
            if (part > 0) part = part/(part + modulo(node(after) - on(i), around))
            way(i) = ways(before) + part*(ways(after) - ways(before))
         end do
      end function ways_at
   end subroutine advance_region

   !> Put corners in the walls of other cracks on the faces of these, where the outline is no front any more.
   pure subroutine end_at_cuts(region, new)
      type(region_t), intent(in) :: region
      type(moving_t), intent(inout) :: new
      logical :: is_there(size(new%way))
      integer :: c, i
      do i = 1, size(is_there)
         c = region%at_cut(new%at(:, i))
         is_there(i) = c > 0
         if (is_there(i)) new%at(findloc(region%along, region%cuts(c)%across, dim=1), i) = region%cuts(c)%faces
      end do
      new%may_be_front = new%may_be_front .and. .not. (is_there .and. cshift(is_there, 1))
   end subroutine end_at_cuts

   !> Divide long edges where they are in a box, so that the outline keeps its area.
   pure subroutine divide(new, low, high, chord, last)
      type(moving_t), intent(inout) :: new
      real(dp), intent(in) :: low(2), high(2)    !! [m]
      real(dp), intent(in) :: chord              !! [m]
      real(dp), intent(in) :: last               !! way at the end of the last edge [m]
      real(dp), parameter :: longest = 2, outside = 2, far = 16 ! chords
      type(moving_t) :: old
      real(dp) :: from, to, length, normal(2), bend, t
      integer :: n, k, next, parts, i
      logical :: is_long(size(new%way))
      n = size(new%way)
      is_long = new%may_be_front .and. side_lengths(new%at) > longest*chord
      do k = 1, n
         if (.not. is_long(k)) cycle
         call find_part(new, k, length, from, to)
         is_long(k) = to > from
      end do
      if (.not. any(is_long)) return
      new%at = new%at - bulge(new, chord)
      old = new
      new%n = 0
      associate (curvature => curvatures(old, chord))
         do k = 1, n
            next = modulo(k, n) + 1
            call add(new, old%at(:, k), old%way(k), old%may_be_front(k), old%is_corner(k))
            if (.not. is_long(k)) cycle
            call find_part(old, k, length, from, to)
            parts = max(1, nint((to - from)*length/chord))
            normal = normal_of(old%at, k)
            bend = sum(curvature([k, next]))/max(1, count(abs(curvature([k, next])) > 0))*length**2/2
            do i = 0, parts
               t = from + (to - from)*i/parts
               if (min(t, 1 - t)*length < shortest*chord) cycle
               call add(new, old%at(:, k) + t*(old%at(:, next) - old%at(:, k)) + t*(1 - t)*bend*normal, &
                        old%way(k) + t*(merge(old%way(next), last, next > 1) - old%way(k)), &
                        .true., .false.)
            end do
         end do
      end associate
      call resize(new, new%n)
      new%at = new%at + bulge(new, chord)

   contains

      !> The part of an edge to be divided: the whole edge, or of a long one its part in the box and a little more.
      pure subroutine find_part(of, k, length, from, to)
         type(moving_t), intent(in) :: of
         integer, intent(in) :: k
         real(dp), intent(out) :: length         !! of it [m]
         real(dp), intent(out) :: from, to       !! [-]
         length = norm(of%at(:, modulo(k, n) + 1) - of%at(:, k))
         from = 0
         to = 1
         if (length < far*chord) return
         call clip_segment(of%at(:, k), of%at(:, modulo(k, n) + 1), low, high, from, to)
         if (to <= from) return                  ! beside the box, however near
         from = max(0.0_dp, from - outside*chord/length)
         to = min(1.0_dp, to + outside*chord/length)
      end subroutine find_part
   end subroutine divide

   !> Add a corner behind the last.
   pure subroutine add(new, at, way, may_be_front, is_corner)
      type(moving_t), intent(inout) :: new
      real(dp), intent(in) :: at(2), way
      logical, intent(in) :: may_be_front, is_corner
      if (new%n == size(new%way)) call resize(new, 2*new%n + 1)
      new%n = new%n + 1
      new%at(:, new%n) = at
      new%way(new%n) = way
      new%may_be_front(new%n) = may_be_front
      new%is_corner(new%n) = is_corner
   end subroutine add

   !> Give it room for as many corners.
   pure subroutine resize(new, room)
      type(moving_t), intent(inout) :: new
      integer, intent(in) :: room
      type(moving_t) :: old
      old = new
      deallocate (new%at, new%way, new%may_be_front, new%is_corner)
      allocate (new%at(2, room), new%way(room), new%may_be_front(room), new%is_corner(room))
      new%at(:, :new%n) = old%at(:, :new%n)
      new%way(:new%n) = old%way(:new%n)
      new%may_be_front(:new%n) = old%may_be_front(:new%n)
      new%is_corner(:new%n) = old%is_corner(:new%n)
   end subroutine resize

   !> Turning angle of an outline at each corner, above 0 to the left [rad].
   pure function turns_of(outline) result(turn)
      real(dp), intent(in) :: outline(:, :)
      real(dp) :: turn(size(outline, 2)), a(2), b(2)
      integer :: k
      do k = 1, size(turn)
         a = normal_of(outline, modulo(k - 2, size(turn)) + 1)
         b = normal_of(outline, k)
         turn(k) = atan2(cross(a, b), dot_product(a, b))
      end do
   end function turns_of

   !> Whether it turns to the left only.
   pure logical function is_convex(outline)
      real(dp), intent(in) :: outline(:, :)
      is_convex = all(turns_of(outline) > -epsilon(1.0_dp)*1e3_dp)
   end function is_convex

   !> Curvature of the curve for which chords stand, at each corner; 0 at kinks [1/m].
   pure function curvatures(of, chord) result(curvature)
      type(moving_t), intent(in) :: of
      real(dp), intent(in) :: chord              !! [m]
      real(dp), parameter :: far = 4             ! chords
      real(dp) :: curvature(size(of%way))
      associate (length => side_lengths(of%at))
         associate (before => cshift(length, -1))
            curvature = turns_of(of%at)
            where (of%is_corner .or. abs(curvature) > kink .or. max(length, before) > far*chord) curvature = 0
            curvature = 2*curvature/(length + before)
         end associate
      end associate
   end function curvatures

   !> Distance of corners outside of the curve of the same area [m].
   pure function bulge(of, chord)
      type(moving_t), intent(in) :: of
      real(dp), intent(in) :: chord              !! [m]
      real(dp) :: bulge(2, size(of%way)), out(2)
      integer :: k
      associate (length => side_lengths(of%at), curvature => curvatures(of, chord))
         do k = 1, size(of%way)
            associate (before => modulo(k - 2, size(of%way)) + 1)
               out = normal_of(of%at, before) + normal_of(of%at, k)
               bulge(:, k) = 0
               if (abs(curvature(k)) > 0) bulge(:, k) = out/norm(out)*curvature(k)/12 &
                                                        *(length(before)**2 - length(before)*length(k) + length(k)**2)
            end associate
         end do
      end associate
   end function bulge

   !> Move each corner by its advance.
   pure subroutine move(new)
      type(moving_t), intent(inout) :: new
      type(moving_t) :: old
      real(dp) :: a(2), b(2), turn(size(new%way)), along
      integer :: k, before, i, parts
      old = new
      turn = turns_of(old%at)
      new%n = 0
      do k = 1, size(turn)
         before = modulo(k - 2, size(turn)) + 1
         a = normal_of(old%at, before)
         b = normal_of(old%at, k)
         if (.not. (old%may_be_front(before) .and. old%may_be_front(k))) then
            a = a*merge(1, 0, old%may_be_front(before)) + b*merge(1, 0, old%may_be_front(k))
            call add(new, old%at(:, k) + old%way(k)*a, old%way(k), old%may_be_front(k), old%is_corner(k))
            cycle
         end if
         parts = 0
         if (old%is_corner(k) .and. turn(k) > of_arc/2 .and. old%way(k) > 0) parts = ceiling(turn(k)/of_arc)
         do i = 0, parts                         ! of an arc around a kink
            along = old%way(k)
            if (turn(k) < 0) along = along/cos(max(turn(k), -2.0_dp)/2) ! edges beside it go the same way
            if (i > 0 .and. i < parts) then
               along = along*of_area(turn(k)/parts)
            else if (parts == 0 .and. turn(k) > 0) then
               along = along*of_area(turn(k))
            end if
            associate (out => merge(a + b, a*sin((parts - i)*turn(k)/max(1, parts)) + b*sin(i*turn(k)/max(1, parts)), parts == 0))
               call add(new, old%at(:, k) + along*out/norm(out), old%way(k), .true., old%is_corner(k) .and. parts == 0)
            end associate
         end do
      end do
      call resize(new, new%n)

   contains

      !> Radius of the corners of a polygon over the radius of the circle of the same area.
      pure real(dp) function of_area(angle)
         real(dp), intent(in) :: angle           !! of each edge [rad]
         of_area = 1
         if (angle < kink) of_area = 1 + angle**2/12
      end function of_area
   end subroutine move

   !> Join corners that come together where the outline is concave.
   pure subroutine join(new, shortest)
      type(moving_t), intent(inout) :: new
      real(dp), intent(in) :: shortest           !! distance [m]
      real(dp), parameter :: straight = 1e-3_dp  ! [rad]
      real(dp) :: length(size(new%way)), turn(size(new%way))
      logical :: stays(size(new%way))
      integer :: k, next
      turn = turns_of(new%at)
      length = side_lengths(new%at)
      stays = .true.
      do k = 1, size(turn)
         next = modulo(k, size(turn)) + 1
         if (length(k) > shortest .or. min(turn(k), turn(next)) > -straight) cycle
         if (.not. (stays(k) .and. stays(next) .and. new%may_be_front(k))) cycle
         if (abs(turn(k) - turn(next)) < straight) then
            new%at(:, next) = (new%at(:, k) + new%at(:, next))/2
            new%way(next) = (new%way(k) + new%way(next))/2
            stays(k) = .false.
         else                                    ! the one of the larger kink stays
            stays(k) = turn(k) < turn(next)
            stays(next) = .not. stays(k)
            if (stays(k)) new%may_be_front(k) = new%may_be_front(next)
         end if
      end do
      if (all(stays)) return
      new%at = reshape(pack(new%at, spread(stays, 1, 2)), [2, count(stays)])
      new%way = pack(new%way, stays)
      new%may_be_front = pack(new%may_be_front, stays)
      new%is_corner = pack(new%is_corner, stays)
   end subroutine join

   !> Cut off the loops of an outline whose parts have met. A loop in the sense of a hole encloses uncracked material, which an
   !> outline cannot represent.
   pure subroutine cut_loops(new, encloses)
      type(moving_t), intent(inout) :: new
      logical, intent(out) :: encloses
      type(moving_t) :: old
      real(dp) :: at(2), part, of_other
      integer :: i, j, n, k
      encloses = .false.
      do while (.not. is_convex(new%at))
         call find_crossing(new%at, .true., i, j)
         if (i == 0) return
         n = size(new%way)
         associate (a => new%at(:, i), b => new%at(:, i + 1))
            call find_meeting(a, b - a, new%at(:, j), new%at(:, modulo(j, n) + 1), part, of_other)
            at = a + min(max(part, 0.0_dp), 1.0_dp)*(b - a)
         end associate
         associate (inner => area_of(reshape([at, new%at(:, i + 1:j)], [2, j - i + 1])), whole => area_of(new%at))
            encloses = min(inner, whole - inner) < 0
            if (encloses) return
            old = new
            new%n = 0
            do k = 1, n                          ! the larger part stays
               if ((k > i .and. k <= j) .eqv. inner > whole - inner) &
                  call add(new, old%at(:, k), old%way(k), old%may_be_front(k), old%is_corner(k))
               if (k == merge(j, i, inner > whole - inner)) &
                  call add(new, at, old%way(k), old%may_be_front(merge(i, j, inner > whole - inner)), .true.)
            end do
            call resize(new, new%n)
         end associate
      end do
   end subroutine cut_loops
end module hampm_moving_front
