!> Openings and forces of faces beside an interface point, by its neighbours, for the integrals at tips and fronts.
module hampm_face_slopes
   use hampm_kinds, only: dp, ndim
   use hampm_interface_points, only: interfaces_t, interface_point_t, releasing, contact, cohesive, holds, is_free, is_softening, &
                                     has_force, force_at, along, find_points
   use hampm_nearby, only: nearby_t
   use hampm_tensors, only: norm
   implicit none
   private
   public :: find_face_force, extend_opening

contains

   !> Force of an interface point against separation of the faces, and the change of their opening along a direction, by its
   !> neighbours. `is_there` is false for intact bonded points and separate faces. For failing points it is the change, along the
   !> path of the tip, of the opening since the start of failure: it does their work, and each began with another opening.
   pure subroutine find_face_force(interfaces, near, k, direction, force, slope, is_there)
      type(interfaces_t), intent(in) :: interfaces
      type(nearby_t), intent(inout) :: near      !! see `find_points`
      integer, intent(in) :: k
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      real(dp), intent(out) :: force(ndim)       !! [N]
      real(dp), intent(out) :: slope(ndim)       !! [-]
      logical, intent(out) :: is_there
      integer :: before, after
      real(dp) :: way, line(ndim)
      force = 0
      slope = 0
      is_there = has_force(interfaces%list(k))
      if (.not. is_there) return
      force = force_at(interfaces, k)
      if (ndim > 2) then
         call find_slope_on_face(interfaces, near, k, direction, slope)
         return
      end if
      before = merge(k - 1, k, is_next(max(k - 1, 1)))
      after = merge(k + 1, k, is_next(min(k + 1, interfaces%n)))
      line = direction
      if (is_softening(interfaces%list(k))) line = along(interfaces%list(k))
      way = dot_product(interfaces%list(after)%place - interfaces%list(before)%place, line)
      if (abs(way) > 0) slope = (opening_of(interfaces%list(after)) - opening_of(interfaces%list(before)))/way

   contains

      !> The opening of an interface point that counts there [m].
      pure function opening_of(point) result(opening)
         type(interface_point_t), intent(in) :: point
         real(dp) :: opening(ndim)
         opening = point%opening
         if (is_softening(interfaces%list(k))) opening = merge(1, 0, point%law == releasing)*(opening - point%start)
      end function opening_of

      !> Whether another interface point is one of the same crack, on the same straight part of it.
      pure logical function is_next(other)
         integer, intent(in) :: other
         associate (point => interfaces%list(k), beside => interfaces%list(other))
            is_next = is_free(beside) .or. holds(beside)
            if (is_softening(point)) is_next = beside%tip == point%tip
            is_next = is_next .and. other /= k .and. beside%line == point%line .and. norm(beside%normal - point%normal) <= 1e-6_dp
         end associate
      end function is_next
   end subroutine find_face_force

   !> The change of the opening along a direction in space, by that at the points of the nodes beside it [-].
   pure subroutine find_slope_on_face(interfaces, near, k, direction, slope)
      type(interfaces_t), intent(in) :: interfaces
      type(nearby_t), intent(inout) :: near
      integer, intent(in) :: k
      real(dp), intent(in) :: direction(ndim)
      real(dp), intent(out) :: slope(ndim)
      real(dp) :: way(ndim), changes(ndim, ndim), square(ndim)
      integer, allocatable :: found(:)
      integer :: other, d
      changes = 0
      square = 0
      associate (point => interfaces%list(k))
         call find_points(interfaces, near, point%origin, 2*point%cell, found)
         do other = 1, size(found)
            associate (beside => interfaces%list(found(other)))
               if (beside%law /= contact .or. beside%line /= point%line) cycle
               way = beside%place - point%place
               d = maxloc(abs(way), dim=1)
               if (abs(way(d)) > 1.1_dp*point%cell .or. count(abs(way) > 1e-3_dp*point%cell) /= 1) cycle
               changes(:, d) = changes(:, d) + way(d)*(beside%opening - point%opening)
               square(d) = square(d) + way(d)**2
            end associate
         end do
      end associate
      slope = matmul(changes, direction/max(square, tiny(square)))
   end subroutine find_slope_on_face

   !> Opening of faces that may touch at a place of their crack [m]: extrapolated from the two nearest points on one side. Not there
   !> without such points.
   pure subroutine extend_opening(interfaces, line, x, toward, opening, is_there)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: line                !! number of the crack
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: toward(ndim)       !! unit vector along the crack to that side
      real(dp), intent(inout) :: opening(ndim)
      logical, intent(out) :: is_there
      real(dp), parameter :: far = 1.5_dp        ! cells; points of the next cell are no farther
      real(dp), parameter :: same = 1e-3_dp      ! distance of points at one place, on both sides of a kink [cells]
      real(dp), allocatable :: way(:) ! from the place to the points [m]
      integer :: k, near, next
      allocate (way(interfaces%n), source=-1.0_dp)
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%line /= line .or. point%law /= contact .and. point%law /= cohesive) cycle
            way(k) = dot_product(point%place - x, toward)
            if (way(k) > far*point%cell) way(k) = -1
         end associate
      end do
      is_there = count(way > 0) > 1
      if (.not. is_there) return
      near = minloc(way, dim=1, mask=way > 0)
      next = minloc(way, dim=1, mask=way > way(near) + same*interfaces%list(near)%cell)
      is_there = next > 0
      if (.not. is_there) return
      associate (a => interfaces%list(near)%opening, b => interfaces%list(next)%opening)
         opening = a + way(near)/(way(next) - way(near))*(a - b)
      end associate
   end subroutine extend_opening
end module hampm_face_slopes
