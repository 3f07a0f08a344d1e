!> Geometry of a model's cracks in its bodies: tips among their ends, and the largest radius of a domain integral at a tip. For
!> checks of the input and the assembly; during a run `cracks_t` has the cracks and queries by places.
module hampm_path_placement
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_crack_lines, only: length_of, room_on_line, first_point, last_point
   use hampm_crack_placement, only: is_covered, covered_radius, distance_to_loads, distance_to_constraints, distance_to_others, &
                                    domain_radii
   use hampm_placement, only: tolerance
   use hampm_polygon, only: distance_to_line
   use hampm_model, only: model_t, crack_spec_t
   implicit none
   private
   public :: path_tips, path_reaches, is_tip_at, reach_beyond, path_mouth, path_outside, path_tip, path_direction, path_radius, &
             path_radii, clear_radius, held_part, to_surface, room_around, distance_to_cracks, length_along, is_inside, &
             place_along

   real(dp), parameter :: inward = 1e-6_dp       !! cells that a place is in the material at which a line is found to enter it
   real(dp), parameter :: to_surface = 2         !! cells by which an end at a surface is continued
   real(dp), parameter :: to_crack = 1e-4_dp     !! the same of an end on another crack

contains

   !> Whether a point is inside the material, and not on its surface.
   pure logical function is_inside(model, x)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: x(ndim)            !! [m]
      is_inside = is_covered(model, x, 1e-3_dp*model%grid%cell)
   end function is_inside

   !> An end of a path; with cohesion the beginning of the cohesive part [m].
   pure function path_tip(path, end) result(x)
      type(crack_spec_t), intent(in) :: path
      integer, intent(in) :: end                 !! `first_point` or `last_point`, here and below
      real(dp) :: x(ndim)
      x = path%points(:, merge(1, size(path%points, 2), end == first_point))
      if (end == last_point .and. path%held_from > 0) x = place_along(path%points, path%held_from/length_of(path%points))
   end function path_tip

   !> The direction of the straight part of a path out of an end, of any length.
   pure function path_direction(path, end) result(direction)
      type(crack_spec_t), intent(in) :: path
      integer, intent(in) :: end
      real(dp) :: direction(ndim)
      integer :: i
      i = straight_at(path, end)
      direction = path%points(:, i) - path%points(:, i - 1)
      if (end == first_point) direction = -direction
   end function path_direction

   !> Distances along the k-th path between which cohesion holds its faces: within the material, from its initial tip [m].
   pure function held_part(model, k) result(held)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k
      real(dp) :: held(2)
      held = length_of(model%paths(k)%points)*covered_part(model, model%paths(k)%points)
      held(1) = max(held(1), model%paths(k)%held_from)
   end function held_part

   !> Entries and exits of a polyline in the material, as parts of its length.
   pure function covered_part(model, points) result(part)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, 2 or more)
      real(dp) :: part(2)
      integer, parameter :: looks = 1000
      logical :: inside(0:looks)
      integer :: i
      inside = [(is_inside(model, place_along(points, i/real(looks, dp))), i=0, looks)]
      part = [edge_at(findloc(inside, .true., dim=1) - 1, -1), edge_at(findloc(inside, .true., dim=1, back=.true.) - 1, 1)]

   contains

      !> Its exit from the material beyond the i-th place, forwards or backwards.
      pure real(dp) function edge_at(i, sense) result(part)
         integer, intent(in) :: i, sense
         real(dp) :: step
         integer :: turn
         part = i/real(looks, dp)
         if (i == merge(0, looks, sense < 0)) return
         step = 1/real(looks, dp)
         do turn = 1, 50
            if (turn > 2) step = step/2          ! two steps may be needed, as a place on a surface is not inside
            if (is_covered(model, place_along(points, part + sense*step), inward*model%grid%cell)) part = part + sense*step
         end do
      end function edge_at
   end function covered_part

   !> Number of the last point of the straight part with a tip, which ends there or continues.
   pure integer function straight_at(path, end) result(i)
      type(crack_spec_t), intent(in) :: path
      integer, intent(in) :: end
      i = merge(2, size(path%points, 2), end == first_point)
      if (end == first_point .or. .not. path%held_from > 0) return
      do i = 2, size(path%points, 2) - 1
         if (length_of(path%points(:, :i)) > path%held_from) return
      end do
   end function straight_at

   !> Whether the first and the last point of the k-th path are tips: inside the material, and not on another crack.
   pure function path_tips(model, k) result(is_tip)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k
      logical :: is_tip(2)
      integer :: end
      is_tip = .false.
      if (size(model%paths(k)%points, 2) < 2) return ! its points have an error
      do end = first_point, last_point
         associate (x => path_tip(model%paths(k), end))
            is_tip(end) = is_tip_at(model, x, distance_to_cracks(model, x, k))
         end associate
      end do
   end function path_tips

   !> Whether a crack that ends at a place has a tip there: inside the material, and not on another crack.
   pure logical function is_tip_at(model, x, away)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: x(ndim), away      !! the place, and its distance from other cracks [m]
      is_tip_at = is_inside(model, x) .and. away > tolerance(model%grid)
   end function is_tip_at

   !> Extension of the ends of the k-th path that are no tips, to cut all material there [m]; if other material is beyond a gap,
   !> half of the gap.
   pure function path_reaches(model, k) result(beyond)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k
      real(dp) :: beyond(2)
      integer :: end
      do end = first_point, last_point
         associate (points => model%paths(k)%points, out => path_direction(model%paths(k), end))
            associate (at => merge(1, size(points, 2), end == first_point))
               beyond(end) = reach_beyond(model, points(:, at), out/norm(out), distance_to_cracks(model, points(:, at), k))
            end associate
         end associate
      end do
   end function path_reaches

   !> The same of an end at a place.
   pure real(dp) function reach_beyond(model, x, out, away) result(beyond)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: x(ndim), out(ndim), away !! the place, unit vector out of the crack, distance from other cracks [m]
      integer, parameter :: looks = 16
      real(dp) :: step
      integer :: i
      step = to_surface/looks*model%grid%cell
      beyond = merge(to_crack, to_surface, is_inside(model, x))*model%grid%cell
      if (is_tip_at(model, x, away)) beyond = 0
      if (is_inside(model, x) .or. .not. is_inside(model, x - step*out)) return ! it ends outside anyway
      do i = 1, looks
         if (.not. is_inside(model, x + i*step*out)) cycle
         beyond = i*step/2
         return
      end do
   end function reach_beyond

   !> Place of the opening at the mouth of the k-th path: its entry into the material or, with two tips, its middle [m].
   pure function path_mouth(model, k) result(x)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k
      real(dp) :: x(ndim), edges(2)
      associate (is_tip => path_tips(model, k), points => model%paths(k)%points)
         edges = merge([0.5_dp, 0.5_dp], covered_part(model, points), all(is_tip))
         x = place_along(points, edges(merge(2, 1, is_tip(first_point))))
         if (model%paths(k)%key == 'tip' .and. .not. is_tip(first_point)) x = points(:, 1)
      end associate
   end function path_mouth

   !> Length of the first and the last end of the k-th path that are out of the material [m].
   pure function path_outside(model, k) result(outside)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k
      real(dp) :: outside(2), part(2)
      associate (points => model%paths(k)%points)
         part = covered_part(model, points)
         outside = [part(1), 1 - part(2)]*length_of(points) - inward*model%grid%cell
      end associate
      where (outside <= tolerance(model%grid)) outside = 0
   end function path_outside

   !> The place on a polyline at a part of its length [m].
   pure function place_along(points, part) result(x)
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, 2 or more)
      real(dp), intent(in) :: part               !! 0 to 1
      real(dp) :: x(ndim)
      real(dp) :: way, length
      integer :: i
      way = part*length_of(points)
      x = points(:, 1)
      do i = 2, size(points, 2)
         length = norm(points(:, i) - points(:, i - 1))
         x = points(:, i - 1) + min(way/length, 1.0_dp)*(points(:, i) - points(:, i - 1))
         if (way <= length) return
         way = way - length
      end do
   end function place_along

   !> Distance of a point from all paths but one [m]; huge where there are no others.
   pure real(dp) function distance_to_cracks(model, x, but) result(distance)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer, intent(in) :: but
      integer :: k
      distance = huge(distance)
      do k = 1, size(model%paths)
         if (k /= but) distance = min(distance, distance_to_line(x, model%paths(k)%points))
      end do
   end function distance_to_cracks

   !> Length of the longest part of a path along which it is next to another one, within `beside` [m].
   pure real(dp) function length_along(model, k, other, beside) result(longest)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k, other            !! numbers of the paths
      real(dp), intent(in) :: beside             !! [m]
      real(dp) :: x(ndim), step, way
      integer :: i, j, steps
      longest = 0
      way = 0
      associate (points => model%paths(k)%points, others => model%paths(other)%points)
         do i = 2, size(points, 2)
            steps = ceiling(8*norm(points(:, i) - points(:, i - 1))/model%grid%cell)
            step = norm(points(:, i) - points(:, i - 1))/steps
            do j = 0, steps - 1
               x = points(:, i - 1) + (j + 0.5_dp)/steps*(points(:, i) - points(:, i - 1))
               way = way + step
               if (distance_to_line(x, others) > beside) way = 0
               longest = max(longest, way)
            end do
         end do
      end associate
   end function length_along

   !> The largest radius around a tip of the k-th path with only material and the straight end of this crack, without loads and
   !> constraints [m]; 0 if there is none.
   pure real(dp) function path_radius(model, k, end) result(radius)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k, end
      radius = room_around(model, path_tip(model%paths(k), end), room_of_cracks(model, k, end))
   end function path_radius

   !> Radii of the domain integral around a tip of the k-th path: of the model, else some that fit, also before other materials [m].
   pure function path_radii(model, k, end) result(radii)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k, end
      real(dp), allocatable :: radii(:)
      radii = domain_radii(model, min(path_radius(model, k, end), distance_to_others(model, path_tip(model%paths(k), end), &
                                                                                       path_direction(model%paths(k), end))))
   end function path_radii

   !> The same with loads and constraints.
   pure real(dp) function clear_radius(model, k, end) result(radius)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k, end
      radius = covered_radius(model, path_tip(model%paths(k), end), room_of_cracks(model, k, end))
   end function clear_radius

   !> The same with all else but cracks.
   pure real(dp) function room_of_cracks(model, k, end) result(radius)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k, end
      associate (path => model%paths(k), tip => path_tip(model%paths(k), end))
         radius = min(room_on_line(path%points, tip, straight_at(path, end), end == first_point), distance_to_cracks(model, tip, k))
      end associate
   end function room_of_cracks

   !> The largest radius around a tip, at most `most`, with only material, without loads and constraints [m]; 0 if there is none.
   pure real(dp) function room_around(model, tip, most) result(radius)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: tip(ndim)          !! its place [m]
      real(dp), intent(in) :: most               !! [m]
      radius = min(most, sum(model%grid%cells)*model%grid%cell) ! else there may be no bound
      radius = covered_radius(model, tip, min(radius, distance_to_loads(model, tip), distance_to_constraints(model, tip)))
   end function room_around
end module hampm_path_placement
