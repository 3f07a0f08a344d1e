!> Where the crack of a scene is in its bodies, and how far from a tip a domain integral may reach: for the checks of the input and
!> for the assembly. In the run `cracks_t` knows where cracks are.
module hampm_crack_placement
   use hampm_kinds, only: dp, ndim, long
   use hampm_body_group, only: area_in_box
   use hampm_placement, only: tolerance, within, is_part_of, overlap
   use hampm_scene, only: scene_t, load_spec_t
   use hampm_scene_materials, only: are_alike
   implicit none
   private
   public :: has_two_tips, distance_in_material, distance_to_mouth, distance_to_next_body, body_at, largest_radius, &
             least_radius, domain_radii, is_covered, held_ahead, room_on_plane, covered_radius, &
             distance_to_box, is_on_crack, is_other_within, is_layer, face_normal

   real(dp), parameter :: least_cells = 2        !! fewest cells to a radius

contains

   !> Whether the other end of the crack is inside the material too.
   pure logical function has_two_tips(scene)
      type(scene_t), intent(in) :: scene
      associate (spec => scene%crack)
         has_two_tips = spec%length > 0 .and. &
                        spec%length < distance_to_mouth(scene) - tolerance(scene%grid)
      end associate
   end function has_two_tips

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

   !> How far it is from the tip of a crack that has no other to its mouth: as far as there is material at each face [m].
   pure real(dp) function distance_to_mouth(scene) result(distance)
      type(scene_t), intent(in) :: scene
      real(dp) :: aside(ndim)                    !! from the crack into the cells on one side [m]
      associate (spec => scene%crack)
         aside = 0
         if (spec%kind == 'line') aside = 0.5_dp*scene%grid%cell*[-spec%direction(2), spec%direction(1)]
         distance = min(distance_in_material(scene, spec%tip + aside, -spec%direction), &
                        distance_in_material(scene, spec%tip - aside, -spec%direction))
      end associate
   end function distance_to_mouth

   !> How far it is from a point, in a direction along the grid lines, to the first body that begins further away than `beyond`
   !> [m]; huge where there is none.
   pure real(dp) function distance_to_next_body(scene, start, direction, beyond) result(distance)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: start(ndim)
      real(dp), intent(in) :: direction(ndim)      !! unit vector
      real(dp), intent(in) :: beyond               !! [m]
      real(dp) :: x(ndim), begins
      integer :: i
      distance = huge(distance)
      do i = 1, size(scene%bodies)
         associate (body => scene%bodies(i))
            begins = min(dot_product(body%lower - start, direction), dot_product(body%upper - start, direction))
            x = start + begins*direction
            if (begins > beyond + tolerance(scene%grid) .and. within(x, x, body%lower, body%upper, tolerance(scene%grid))) &
               distance = min(distance, begins)
         end associate
      end do
   end function distance_to_next_body

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
      real(dp) :: area, wanted
      integer :: i
      area = 0
      do i = 1, size(scene%bodies)
         area = area + area_in_box(scene%bodies(i), tip - radius, tip + radius)
      end do
      wanted = (2*radius)**ndim
      if (scene%crack%kind == 'symmetry') wanted = wanted/2
      covered = area >= wanted - 4*radius*tolerance(scene%grid)
   end function is_covered

   !> The largest radius around a tip within which there are only material and the crack, and no point load, no load on
   !> another surface than its faces and no constraint but those of the symmetry plane [m]; 0 where there is none.
   pure real(dp) function largest_radius(scene, tip) result(radius)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: tip(ndim)
      real(dp) :: direction(ndim), distance
      integer :: d, side
      radius = huge(radius)
      do d = 1, ndim
         do side = -1, 1, 2
            direction = 0
            direction(d) = side
            distance = distance_in_material(scene, tip, direction)
            if (distance <= tolerance(scene%grid) .and. scene%crack%kind == 'symmetry') cycle ! the plane itself
            radius = min(radius, distance)
         end do
      end do
      if (has_two_tips(scene)) radius = min(radius, scene%crack%length)
      radius = min(covered_radius(scene, tip, radius), distance_to_loads(scene, tip), distance_to_constraints(scene, tip))
   end function largest_radius

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

   !> Whether a box is a part of the crack's line, from its mouth or its other tip to its tip.
   pure logical function is_on_crack(scene, lower, upper) result(on)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! [m]
      real(dp) :: start(ndim), length
      on = .false.
      if (.not. scene%crack%present) return
      associate (spec => scene%crack)
         length = distance_to_mouth(scene)
         if (has_two_tips(scene)) length = spec%length
         start = spec%tip - length*spec%direction
         on = within(lower, upper, min(start, spec%tip), max(start, spec%tip), tolerance(scene%grid))
      end associate
   end function is_on_crack

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
   pure logical function is_layer(scene, body, tip, radius)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: body
      real(dp), intent(in) :: tip(ndim), radius  !! [m]
      integer :: along
      along = maxloc(abs(scene%crack%direction), dim=1)
      associate (b => scene%bodies(body))
         is_layer = .not. b%outline%is_there() .and. b%lower(along) <= tip(along) - radius + tolerance(scene%grid) &
                    .and. b%upper(along) >= tip(along) + radius - tolerance(scene%grid)
      end associate
   end function is_layer

   !> Unit vector from the crack's line into the material at the face of a load; 0 where it names none.
   pure function face_normal(scene, load) result(normal)
      type(scene_t), intent(in) :: scene
      type(load_spec_t), intent(in) :: load
      real(dp) :: normal(ndim)
      normal = 0
      associate (direction => scene%crack%direction)
         if (load%face == 'left') normal = [-direction(2), direction(1)]
         if (load%face == 'right') normal = [direction(2), -direction(1)]
      end associate
   end function face_normal

   !> Distance of a tip from the nearest point load, or load on a surface but the faces of the crack [m]; huge where there is none.
   pure real(dp) function distance_to_loads(scene, tip) result(distance)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: tip(ndim)
      integer :: i
      distance = huge(distance)
      do i = 1, size(scene%loads)
         if (scene%loads(i)%kind == 'body' .or. .not. scene%loads(i)%has_place) cycle
         if ((scene%loads(i)%kind == 'traction' .or. scene%loads(i)%kind == 'pressure') .and. &
             is_on_crack(scene, scene%loads(i)%lower, scene%loads(i)%upper)) cycle
         distance = min(distance, distance_to_box(tip, scene%loads(i)%lower, scene%loads(i)%upper))
      end do
   end function distance_to_loads

   !> Distance of a tip from the nearest place of material where a constraint may hold a node [m], but for the symmetry plane
   !> held in the direction normal to it; huge where there is none.
   pure real(dp) function distance_to_constraints(scene, tip) result(distance)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: tip(ndim)
      real(dp), dimension(ndim) :: lower, upper  !! from a node at or next to the tip, in finest cells
      real(dp) :: node(ndim)                     !! that [m]
      logical :: normal(ndim)
      integer :: i, j
      normal = .not. abs(scene%crack%direction) > 0
      node = scene%grid%lower + finest_cell(scene)*anint((tip - scene%grid%lower)/finest_cell(scene))
      if (all(abs(tip - node) <= tolerance(scene%grid))) node = tip
      distance = huge(distance)
      do i = 1, size(scene%constraints)
         associate (constraint => scene%constraints(i), cell => finest_cell(scene))
            do j = 1, size(scene%bodies)
               lower = (max(constraint%lower, scene%bodies(j)%lower) - node - tolerance(scene%grid))/cell
               upper = (min(constraint%upper, scene%bodies(j)%upper) - node + tolerance(scene%grid))/cell
               if (any(lower > upper)) cycle
               lower = ceiling(lower, long)      ! nodes are whole cells from each other
               upper = floor(upper, long)
               if (any(lower > upper)) cycle
               if (scene%crack%kind == 'symmetry' .and. all(constraint%fixed .eqv. normal) .and. &
                   all(max(abs(lower), abs(upper)) <= 0 .or. .not. normal)) cycle
               distance = min(distance, cell*distance_to_box((tip - node)/cell, lower, upper))
            end do
         end associate
      end do
   end function distance_to_constraints

   !> The largest radius around a tip on a symmetry plane that grows, within which there are only material and the crack, no load
   !> and no constraint, and the plane is held ahead [m]; 0 where there is none.
   pure real(dp) function room_on_plane(scene, tip) result(radius)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: tip(ndim)
      radius = min(largest_radius(scene, tip), held_ahead(scene, tip))
   end function room_on_plane

   !> How far ahead of a place on a symmetry plane, in the direction of its crack, the constraints hold the plane [m].
   pure real(dp) function held_ahead(scene, place) result(distance)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: place(ndim)        !! [m]
      real(dp) :: x(ndim)
      integer :: turn, i
      distance = 0
      do turn = 1, size(scene%constraints)
         do i = 1, size(scene%constraints)
            associate (constraint => scene%constraints(i), direction => scene%crack%direction)
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
