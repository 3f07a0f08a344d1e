!> Where the crack of a scene is in its bodies, and how far from a tip a domain integral may reach: for the checks of the input and
!> for the assembly. In the run `cracks_t` knows where cracks are.
module hampm_crack_placement
   use hampm_kinds, only: dp, ndim, long
   use hampm_placement, only: tolerance, within, is_part_of, overlap
   use hampm_scene, only: scene_t, load_spec_t, area_around
   use hampm_scene_materials, only: are_alike
   implicit none
   private
   public :: distance_in_material, body_at, least_radius, domain_radii, is_covered, held_ahead, covered_radius, &
             distance_to_loads, distance_to_constraints, path_at, is_other_within, is_layer, face_normal

   real(dp), parameter :: least_cells = 2        !! fewest cells to a radius

contains

   !> How far one can go from a point, in a direction along the grid lines, in bodies or along their edges [m].
   pure real(dp) function distance_in_material(scene, start, direction) result(distance)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: start(ndim)
      real(dp), intent(in) :: direction(ndim)      !! unit vector
      real(dp) :: x(ndim), reach
      integer :: turn, i
      distance = 0
      do turn = 1, size(scene%bodies)
         do i = 1, size(scene%bodies)
            associate (body => scene%bodies(i))
               x = start + distance*direction
               if (.not. within(x, x, body%lower, body%upper, tolerance(scene%grid))) cycle
               reach = max(dot_product(body%lower - start, direction), dot_product(body%upper - start, direction))
               distance = max(distance, reach)
            end associate
         end do
      end do
   end function distance_in_material

   !> The first body that a point is in or at the edge of, 0 where there is none.
   pure integer function body_at(scene, point) result(body)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: point(ndim)
      do body = 1, size(scene%bodies)
         if (is_part_of(point, scene%bodies(body), tolerance(scene%grid))) return
      end do
      body = 0
   end function body_at

   !> Whether the box around a tip that reaches `radius` far is full of material, on one side of the crack on a symmetry plane.
   pure logical function is_covered(scene, tip, radius) result(covered)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: tip(ndim)          !! place of a tip of the crack, here and below [m]
      real(dp), intent(in) :: radius             !! [m]
      real(dp) :: wanted
      wanted = (2*radius)**ndim
      if (scene%is_half()) wanted = wanted/2
      covered = area_around(scene, tip, radius) >= wanted - 4*radius*tolerance(scene%grid)
   end function is_covered

   !> The largest radius, not above `most`, around a tip whose box is full of material [m]; 0 where there is none. That is `most`
   !> or where an edge of a body is, which is sought by halves where bodies have outlines.
   pure real(dp) function covered_radius(scene, tip, most) result(radius)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: tip(ndim)
      real(dp), intent(in) :: most               !! [m]
      real(dp) :: edge(2*ndim), above
      integer :: i, k
      radius = 0
      if (is_covered(scene, tip, most)) radius = most
      if (any([(scene%bodies(i)%outline%is_there(), i=1, size(scene%bodies))])) then
         above = min(most, norm2(scene%grid%cells*scene%grid%cell))
         do k = 1, digits(above)
            if (radius >= above) exit
            if (is_covered(scene, tip, (radius + above)/2)) then
               radius = (radius + above)/2
            else
               above = (radius + above)/2
            end if
         end do
         return
      end if
      do i = 1, size(scene%bodies)
         edge = abs([scene%bodies(i)%lower - tip, scene%bodies(i)%upper - tip])
         do k = 1, size(edge)
            if (edge(k) > radius .and. edge(k) < most .and. is_covered(scene, tip, edge(k))) radius = edge(k)
         end do
      end do
   end function covered_radius

   !> The first path that a segment is on, and which straight part of it; 0 where it is on none.
   pure function path_at(scene, lower, upper) result(part)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! its ends [m]
      integer :: part(2)
      integer :: k, i
      do k = 1, size(scene%paths)
         do i = 2, size(scene%paths(k)%points, 2)
            part = [k, i]
            if (is_between(lower) .and. is_between(upper)) return
         end do
      end do
      part = 0

   contains

      !> Whether a point is on the straight part.
      pure logical function is_between(x)
         real(dp), intent(in) :: x(ndim)         !! [m]
         real(dp) :: along(ndim), tol
         tol = tolerance(scene%grid)
         associate (a => scene%paths(part(1))%points(:, part(2) - 1), b => scene%paths(part(1))%points(:, part(2)))
            along = (b - a)/max(norm2(b - a), tiny(tol))
            is_between = abs(along(1)*(x(2) - a(2)) - along(2)*(x(1) - a(1))) <= tol .and. &
                         dot_product(x - a, along) >= -tol .and. dot_product(b - x, along) >= -tol
         end associate
      end function is_between
   end function path_at

   !> Whether a body is within a radius of a tip, and of another material than that at the tip, or another eigenstrain.
   pure logical function is_other_within(scene, body, tip, radius) result(is)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: body
      real(dp), intent(in) :: tip(ndim), radius  !! [m]
      associate (b => scene%bodies(body))
         is = overlap(tip - radius, tip + radius, b%lower, b%upper, tolerance(scene%grid))
      end associate
      if (is) is = .not. are_alike(scene, body, body_at(scene, tip))
   end function is_other_within

   !> Whether a body is, as far as a radius around a tip goes, a layer along the crack: then the material does not change in its direction,
   !> and J does not depend on the path.
   pure logical function is_layer(scene, body, tip, direction, radius)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: body
      real(dp), intent(in) :: tip(ndim), direction(ndim), radius !! direction of any length; others [m]
      integer :: along
      along = maxloc(abs(direction), dim=1)
      associate (b => scene%bodies(body))
         is_layer = .not. b%outline%is_there() .and. b%lower(along) <= tip(along) - radius + tolerance(scene%grid) &
                    .and. b%upper(along) >= tip(along) + radius - tolerance(scene%grid) .and. &
                    minval(abs(direction)) <= epsilon(1.0_dp)*maxval(abs(direction))
      end associate
   end function is_layer

   !> Unit vector from the line of a crack into the material at the face of a load; 0 where it names none, or is on no crack.
   pure function face_normal(scene, load) result(normal)
      type(scene_t), intent(in) :: scene
      type(load_spec_t), intent(in) :: load
      real(dp) :: normal(ndim)
      integer :: at(2)
      normal = 0
      at = path_at(scene, load%lower, load%upper)
      if (load%face == 'none' .or. any(at == 0)) return
      associate (points => scene%paths(at(1))%points)
         normal = points(:, at(2)) - points(:, at(2) - 1)
      end associate
      normal = merge(1, -1, load%face == 'left')*[-normal(2), normal(1)]/norm2(normal)
   end function face_normal

   !> Distance of a tip from the nearest load at a place but on the faces of a crack [m]; huge where there is none.
   pure real(dp) function distance_to_loads(scene, tip) result(distance)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: tip(ndim)
      integer :: i
      distance = huge(distance)
      do i = 1, size(scene%loads)
         if (scene%loads(i)%kind == 'body' .or. .not. scene%loads(i)%has_place .or. scene%loads(i)%face /= 'none') cycle
         if ((scene%loads(i)%kind == 'traction' .or. scene%loads(i)%kind == 'pressure') .and. &
             any(path_at(scene, scene%loads(i)%lower, scene%loads(i)%upper) > 0)) cycle
         distance = min(distance, distance_to_box(tip, scene%loads(i)%lower, scene%loads(i)%upper))
      end do
   end function distance_to_loads

   !> Distance of a tip from the nearest place of a constraint [m]; at a symmetry plane from where it may hold a node of material, but for the plane
   !> held in the direction normal to it. Huge where there is none.
   pure real(dp) function distance_to_constraints(scene, tip) result(distance)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: tip(ndim)
      real(dp), dimension(ndim) :: lower, upper  !! from a node at or next to the tip, in finest cells
      real(dp) :: node(ndim)                     !! that [m]
      logical :: normal(ndim)
      integer :: i, j
      normal = .not. abs(scene%paths(1)%direction) > 0
      node = scene%grid%lower + finest_cell(scene)*anint((tip - scene%grid%lower)/finest_cell(scene))
      if (all(abs(tip - node) <= tolerance(scene%grid))) node = tip
      distance = huge(distance)
      do i = 1, size(scene%constraints)
         associate (constraint => scene%constraints(i), cell => finest_cell(scene))
            if (.not. scene%is_half()) then
               if (any(constraint%fixed)) distance = min(distance, distance_to_box(tip, constraint%lower, constraint%upper))
               cycle
            end if
            do j = 1, size(scene%bodies)
               lower = (max(constraint%lower, scene%bodies(j)%lower) - node - tolerance(scene%grid))/cell
               upper = (min(constraint%upper, scene%bodies(j)%upper) - node + tolerance(scene%grid))/cell
               if (any(lower > upper)) cycle
               lower = ceiling(lower, long)      ! nodes are whole cells from each other
               upper = floor(upper, long)
               if (any(lower > upper)) cycle
               if (all(constraint%fixed .eqv. normal) .and. &
                   all(max(abs(lower), abs(upper)) <= 0 .or. .not. normal)) cycle
               distance = min(distance, cell*distance_to_box((tip - node)/cell, lower, upper))
            end do
         end associate
      end do
   end function distance_to_constraints

   !> How far ahead of a place on a symmetry plane, in the direction of its crack, the constraints hold the plane [m].
   pure real(dp) function held_ahead(scene, place) result(distance)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: place(ndim)        !! [m]
      real(dp) :: x(ndim)
      integer :: turn, i
      distance = 0
      do turn = 1, size(scene%constraints)
         do i = 1, size(scene%constraints)
            associate (constraint => scene%constraints(i), direction => scene%paths(1)%direction)
               if (.not. all(constraint%fixed .or. abs(direction) > 0)) cycle
               x = place + distance*direction
               if (.not. within(x, x, constraint%lower, constraint%upper, tolerance(scene%grid))) cycle
               distance = max(distance, dot_product(constraint%lower - place, direction), &
                              dot_product(constraint%upper - place, direction))
            end associate
         end do
      end do
   end function held_ahead

   !> Distance of a point from a box, in the unit of both.
   pure real(dp) function distance_to_box(point, lower, upper) result(distance)
      real(dp), intent(in) :: point(ndim), lower(ndim), upper(ndim)
      distance = norm2(max(lower - point, point - upper, 0.0_dp))
   end function distance_to_box

   !> The least radius of the domain integral [m].
   pure real(dp) function least_radius(scene)
      type(scene_t), intent(in) :: scene
      least_radius = least_cells*finest_cell(scene)
   end function least_radius

   !> The radii of the domain integral: those of the scene or, where it names none, up to three that fit below the largest [m].
   pure function domain_radii(scene, most) result(radii)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: most               !! the largest that there may be around a tip [m]
      real(dp), allocatable :: radii(:)
      real(dp) :: first, last
      radii = scene%energy_release%radii
      if (size(radii) > 0) return
      first = max(0.4_dp*most, least_radius(scene))
      last = 0.8_dp*most
      if (first < last) then
         radii = [first, (first + last)/2, last]
      else
         radii = [most]
      end if
   end function domain_radii

   !> Size of the finest cells that there may be [m].
   pure real(dp) function finest_cell(scene)
      type(scene_t), intent(in) :: scene
      finest_cell = scene%grid%cell
      if (scene%refine%indicator /= 'none') finest_cell = scale(finest_cell, -scene%refine%max_level)
   end function finest_cell
end module hampm_crack_placement
