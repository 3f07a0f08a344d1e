!> Surroundings of a place of a model at which a crack tip may be: bodies, materials, loads and constraints, and the largest radius
!> of a domain integral there.
module hampm_crack_placement
   use hampm_kinds, only: dp, ndim, long
   use hampm_front, only: region_t, region_of
   use hampm_outline, only: walls_of
   use hampm_placement, only: tolerance, within, overlap
   use hampm_crack_groups, only: crack_spec_t
   use hampm_crack_lines, only: segment_at
   use hampm_law, only: law_row_t
   use hampm_laws, only: law_row
   use hampm_model, only: model_t, load_spec_t, area_around, has_shapes
   use hampm_model_materials, only: are_alike
   use hampm_tensors, only: norm, quarter_turn
   use hampm_toughness, only: advance_t
   implicit none
   private
   public :: distance_in_material, body_at, least_radius, domain_radii, is_covered, held_ahead, covered_radius, &
             distance_to_loads, distance_to_constraints, path_at, is_fixed, is_other_within, is_layer, sides_of_tip, face_normal, &
             distance_to_others, layer_around, finest_cell, region_in, take_toughness, way_to_toughness

   real(dp), parameter :: least_cells = 2        !! fewest cells to a radius

contains

   !> Distance from a point, in a direction along the grid lines, to the end of the bodies or of their edges [m].
   pure real(dp) function distance_in_material(model, start, direction) result(distance)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: start(ndim)
      real(dp), intent(in) :: direction(ndim)      !! unit vector
      real(dp) :: x(ndim), reach
      integer :: turn, i
      distance = 0
      do turn = 1, size(model%bodies)
         do i = 1, size(model%bodies)
            associate (body => model%bodies(i))
               x = start + distance*direction
               if (.not. within(x, x, body%lower, body%upper, tolerance(model%grid))) cycle
               reach = max(dot_product(body%lower - start, direction), dot_product(body%upper - start, direction))
               distance = max(distance, reach)
            end associate
         end do
      end do
   end function distance_in_material

   !> The body that contains a point, or has it on its edge; of several the one that leads, 0 if there is none.
   pure integer function body_at(model, point) result(body)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: point(ndim)
      integer :: k
      body = 0
      do k = 1, size(model%bodies)
         if (.not. model%bodies(k)%holds(point, tolerance(model%grid))) cycle
         if (body > 0) then
            if (.not. leads(model, k, body)) cycle
         end if
         body = k
      end do
   end function body_at

   !> Whether the material of a body, and not of another one, represents both on a seam, in any order of bodies: it is
   !> history-dependent, has axes of its own, is for finite strain, or is the softer one.
   pure logical function leads(model, body, other)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body, other
      type(law_row_t) :: row
      real(dp) :: marks(4, 2)
      integer :: k, first, material(2)
      material = model%bodies([body, other])%material_index
      leads = .false.
      if (any(material < 1)) return
      do k = 1, 2
         associate (of => model%materials(material(k)))
            row = law_row(of%law)
            marks(:, k) = [merge(1.0_dp, 0.0_dp, [row%has_history, of%law == 'orthotropic', row%is_finite]), -of%least_young()]
         end associate
      end do
      first = findloc(abs(marks(:, 1) - marks(:, 2)) > 0, .true., dim=1)
      if (first > 0) leads = marks(first, 1) > marks(first, 2)
   end function leads

   !> Take the toughness of the body ahead, else of the one at a place. On a seam of bodies, in any order, the least counts.
   pure subroutine take_toughness(model, ahead, place, advance)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: ahead(ndim), place(ndim) !! [m]
      type(advance_t), intent(inout) :: advance
      real(dp) :: x(ndim)
      integer :: k
      if (.not. any(model%bodies%toughness > 0)) return
      x = merge(ahead, place, body_at(model, ahead) > 0)
      do k = 1, size(model%bodies)
         if (.not. model%bodies(k)%holds(x, tolerance(model%grid))) cycle
         associate (toughness => model%bodies(k)%toughness)
            advance%is_of_seam = advance%is_of_seam .or. (advance%or_of_growth .or. advance%of_body > 0) .and. &
                                 (.not. abs(toughness - advance%of_body) <= 0 .or. (advance%or_of_growth .and. toughness > 0))
            if (.not. toughness > 0) then
               advance%or_of_growth = .true.
            else if (toughness < advance%of_body .or. .not. advance%of_body > 0) then
               advance%of_body = toughness
            end if
         end associate
      end do
   end subroutine take_toughness

   !> Distance from a place to the first body of another toughness in a direction [m]; huge beyond `reach`. Found to rounding
   !> between places that are an eighth of a finest cell apart.
   pure real(dp) function way_to_toughness(model, from, direction, reach) result(way)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: from(ndim), direction(ndim) !! [m], and a unit vector
      real(dp), intent(in) :: reach              !! [m]
      integer, parameter :: looks = 8            ! in a cell
      type(advance_t) :: here
      real(dp) :: before
      integer :: turn
      way = huge(way)
      if (.not. any(model%bodies%toughness > 0)) return
      here = toughness_at(0.0_dp)
      before = 0
      do while (is_as_here(min(reach, before + finest_cell(model)/looks)))
         before = before + finest_cell(model)/looks
         if (before >= reach) return
      end do
      way = min(reach, before + finest_cell(model)/looks)
      do turn = 1, digits(way)
         associate (middle => (before + way)/2)
            if (is_as_here(middle)) then
               before = middle
            else
               way = middle
            end if
         end associate
      end do
   contains
      !> What the toughness depends on just ahead of a place on the way.
      pure type(advance_t) function toughness_at(way)
         real(dp), intent(in) :: way             !! [m]
         call take_toughness(model, from + (way + 2*tolerance(model%grid))*direction, from + way*direction, toughness_at)
      end function toughness_at

      !> Whether that is as at its beginning.
      pure logical function is_as_here(way)
         real(dp), intent(in) :: way             !! [m]
         associate (there => toughness_at(way))
            is_as_here = abs(there%of_body - here%of_body) <= 0 .and. (there%or_of_growth .eqv. here%or_of_growth)
         end associate
      end function is_as_here
   end function way_to_toughness

   !> Whether the box around a tip that reaches `radius` far is full of material, on one side of the crack on a symmetry plane.
   pure logical function is_covered(model, tip, radius) result(covered)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: tip(ndim)          !! place of a tip of the crack, here and below [m]
      real(dp), intent(in) :: radius             !! [m]
      real(dp) :: wanted
      wanted = (2*radius)**ndim
      associate (area => area_around(model, tip, radius) + 4*radius*tolerance(model%grid))
         covered = area >= wanted
         if (.not. covered) covered = area >= wanted/2 .and. model%is_half()
      end associate
   end function is_covered

   !> The largest radius, at most `most`, around a tip whose box is full of material [m]; 0 if there is none. It is `most` or ends
   !> at an edge of a body, found by bisection if bodies have outlines.
   pure real(dp) function covered_radius(model, tip, most) result(radius)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: tip(ndim)
      real(dp), intent(in) :: most               !! [m]
      real(dp) :: edge(2*ndim), above
      integer :: i, k
      radius = 0
      if (is_covered(model, tip, most)) radius = most
      if (has_shapes(model)) then
         above = min(most, norm(model%grid%cells*model%grid%cell))
         do k = 1, digits(above)
            if (radius >= above) exit
            if (is_covered(model, tip, (radius + above)/2)) then
               radius = (radius + above)/2
            else
               above = (radius + above)/2
            end if
         end do
         return
      end if
      do i = 1, size(model%bodies)
         edge = abs([model%bodies(i)%lower - tip, model%bodies(i)%upper - tip])
         do k = 1, size(edge)
            if (edge(k) > radius .and. edge(k) < most .and. is_covered(model, tip, edge(k))) radius = edge(k)
         end do
      end do
   end function covered_radius

   !> The first path that a segment is on, and which straight part of it; 0 where it is on none.
   pure function path_at(model, lower, upper) result(part)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! its ends [m]
      integer :: part(2)
      integer :: k
      do k = 1, size(model%paths)
         part = [k, segment_at(model%paths(k)%points, lower, upper, tolerance(model%grid))]
         if (part(2) > 0) return
      end do
      part = 0
   end function path_at

   !> Whether a body is within a radius of a tip, and of another material than that at the tip, or another eigenstrain.
   pure logical function is_other_within(model, body, tip, radius) result(is)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body
      real(dp), intent(in) :: tip(ndim), radius  !! [m]
      is = radius - model%bodies(body)%room_beside(tip) > tolerance(model%grid)
      if (is) is = .not. are_alike(model, body, body_at(model, tip))
   end function is_other_within

   !> The largest radius around a tip without other materials except layers along the crack [m]; huge if unbounded.
   pure real(dp) function distance_to_others(model, tip, direction) result(distance)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: tip(ndim), direction(ndim) !! direction of any length [m]
      integer :: body, here
      distance = huge(distance)
      here = body_at(model, tip)
      if (here == 0) return
      do body = 1, size(model%bodies)
         if (.not. are_alike(model, body, here)) &
            distance = min(distance, max(model%bodies(body)%room_beside(tip), layer_around(model, body, tip, direction)))
      end do
   end function distance_to_others

   !> Whether a body, within a radius around a tip, is a layer along the crack: the material then does not change in the crack's
   !> direction, and J is path-independent.
   pure logical function is_layer(model, body, tip, direction, radius)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body
      real(dp), intent(in) :: tip(ndim), direction(ndim), radius !! direction of any length; others [m]
      is_layer = layer_around(model, body, tip, direction) >= radius - tolerance(model%grid)
   end function is_layer

   !> The largest radius around a tip within which a body, with its continuations, is a layer along the crack [m]; below 0: none.
   pure real(dp) function layer_around(model, body, tip, direction) result(radius)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body
      real(dp), intent(in) :: tip(ndim), direction(ndim) !! direction of any length [m]
      real(dp), dimension(ndim) :: lower, upper, apart ! of the layer [m]
      integer :: along, turn, i
      along = maxloc(abs(direction), dim=1)
      radius = -huge(radius)
      lower = model%bodies(body)%lower
      upper = model%bodies(body)%upper
      if (model%bodies(body)%outline%is_there() .or. minval(abs(direction)) > epsilon(1.0_dp)*maxval(abs(direction))) return
      do turn = 2, size(model%bodies)
         do i = 1, size(model%bodies)
            associate (b => model%bodies(i), tol => tolerance(model%grid))
               if (b%outline%is_there() .or. .not. overlap(b%lower, b%upper, lower, upper, -tol)) cycle
               apart = max(abs(b%lower - lower), abs(b%upper - upper))
               apart(along) = 0
               if (any(apart > tol) .or. .not. are_alike(model, i, body)) cycle
               lower(along) = min(lower(along), b%lower(along))
               upper(along) = max(upper(along), b%upper(along))
            end associate
         end do
      end do
      radius = min(tip(along) - lower(along), upper(along) - tip(along))
   end function layer_around

   !> The bodies left and right of a tip if its crack is the interface of their two materials and no other body is within a radius;
   !> else 0.
   pure function sides_of_tip(model, tip, direction, radius) result(bodies)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: tip(ndim), direction(ndim), radius !! direction of any length; others [m]
      integer :: bodies(2)
      real(dp) :: aside(ndim)
      integer :: b, side
      aside = 1e-3_dp*model%grid%cell*quarter_turn(direction)/norm(direction)
      bodies = [body_at(model, tip + aside), body_at(model, tip - aside)]
      if (any(bodies == 0)) return
      if (are_alike(model, bodies(1), bodies(2))) bodies = 0
      do b = 1, size(model%bodies)
         if (any(bodies == 0)) exit
         associate (body => model%bodies(b))
            if (.not. overlap(tip - radius, tip + radius, body%lower, body%upper, tolerance(model%grid))) cycle
            side = merge(1, 2, dot_product((body%lower + body%upper)/2 - tip, aside) > 0)
            if (.not. (are_alike(model, b, bodies(side)) .and. is_layer(model, b, tip, direction, radius))) bodies = 0
         end associate
      end do
   end function sides_of_tip

   !> Unit vector from the line of a crack into the material at the face of a load; 0 where it names none, or is on no crack.
   pure function face_normal(model, load) result(normal)
      type(model_t), intent(in) :: model
      type(load_spec_t), intent(in) :: load
      real(dp) :: normal(ndim)
      integer :: at(2)
      normal = 0
      at = path_at(model, load%lower, load%upper)
      if (load%face == 'none' .or. any(at == 0)) return
      associate (points => model%paths(at(1))%points)
         normal = points(:, at(2)) - points(:, at(2) - 1)
      end associate
      normal = merge(1, -1, load%face == 'left')*quarter_turn(normal)/norm(normal)
   end function face_normal

   !> Distance of a tip from the nearest load that is not on crack faces [m]; huge if there is none.
   pure real(dp) function distance_to_loads(model, tip) result(distance)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: tip(ndim)
      integer :: i
      distance = huge(distance)
      do i = 1, size(model%loads)
         if (model%loads(i)%kind == 'body' .or. .not. model%loads(i)%has_place .or. model%loads(i)%face /= 'none') cycle
         if ((model%loads(i)%kind == 'traction' .or. model%loads(i)%kind == 'pressure') .and. &
             any(path_at(model, model%loads(i)%lower, model%loads(i)%upper) > 0)) cycle
         distance = min(distance, distance_to_box(tip, model%loads(i)%lower, model%loads(i)%upper))
      end do
   end function distance_to_loads

   !> Distance of a tip from the nearest place of a constraint [m]; on a symmetry plane from its possible nodes with material,
   !> without the normal constraint of the plane itself. Huge if there is none.
   pure real(dp) function distance_to_constraints(model, tip) result(distance)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: tip(ndim)
      real(dp), dimension(ndim) :: lower, upper  !! from a node at or next to the tip, in finest cells
      real(dp) :: node(ndim)                     !! that [m]
      logical :: normal(ndim)
      integer :: i, j
      normal = .not. abs(model%paths(1)%direction) > 0
      node = model%grid%lower + finest_cell(model)*anint((tip - model%grid%lower)/finest_cell(model))
      if (all(abs(tip - node) <= tolerance(model%grid))) node = tip
      distance = huge(distance)
      do i = 1, size(model%constraints)
         associate (constraint => model%constraints(i), cell => finest_cell(model))
            if (.not. model%is_half()) then
               if (any(constraint%fixed)) distance = min(distance, distance_to_box(tip, constraint%lower, constraint%upper))
               cycle
            end if
            do j = 1, size(model%bodies)
               lower = (max(constraint%lower, model%bodies(j)%lower) - node - tolerance(model%grid))/cell
               upper = (min(constraint%upper, model%bodies(j)%upper) - node + tolerance(model%grid))/cell
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

   !> Whether a constraint fixes a component at a place.
   pure logical function is_fixed(model, x, component)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer, intent(in) :: component
      integer :: i
      is_fixed = any([(model%constraints(i)%fixed(component) .and. within(x, x, model%constraints(i)%lower, &
                       model%constraints(i)%upper, tolerance(model%grid)), i=1, size(model%constraints))])
   end function is_fixed

   !> Length ahead of a place on a symmetry plane, in the direction of its crack, along which constraints hold the plane [m].
   pure real(dp) function held_ahead(model, place) result(distance)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: place(ndim)        !! [m]
      real(dp) :: x(ndim)
      integer :: turn, i
      distance = 0
      do turn = 1, size(model%constraints)
         do i = 1, size(model%constraints)
            associate (constraint => model%constraints(i), direction => model%paths(1)%direction)
               if (.not. all(constraint%fixed .or. abs(direction) > 0)) cycle
               x = place + distance*direction
               if (.not. within(x, x, constraint%lower, constraint%upper, tolerance(model%grid))) cycle
               distance = max(distance, dot_product(constraint%lower - place, direction), &
                              dot_product(constraint%upper - place, direction))
            end associate
         end do
      end do
   end function held_ahead

   !> Distance of a point from a box, in the unit of both.
   pure real(dp) function distance_to_box(point, lower, upper) result(distance)
      real(dp), intent(in) :: point(ndim), lower(ndim), upper(ndim)
      distance = norm(max(lower - point, point - upper, 0.0_dp))
   end function distance_to_box

   !> The least radius of the domain integral [m].
   pure real(dp) function least_radius(model)
      type(model_t), intent(in) :: model
      least_radius = least_cells*finest_cell(model)
   end function least_radius

   !> Radii of the domain integral: those of the model or else up to three that fit below the largest [m].
   pure function domain_radii(model, most) result(radii)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: most               !! the largest that there may be around a tip [m]
      real(dp), allocatable :: radii(:)
      real(dp) :: first, last
      radii = model%energy_release%radii
      if (size(radii) > 0) return
      first = max(0.4_dp*most, least_radius(model))
      last = 0.8_dp*most
      if (first < last) then
         radii = [first, (first + last)/2, last]
      else
         radii = [most]
      end if
   end function domain_radii

   !> The cracked region of a plane of a solid, in the box around the bodies with material in it, with the outlines of those that
   !> are no boxes: fronts end at their sides. No corners without any body there.
   pure type(region_t) function region_in(model, plane) result(region)
      type(model_t), intent(in) :: model
      type(crack_spec_t), intent(in) :: plane
      real(dp) :: lower(ndim), upper(ndim)       ! [m]
      logical :: has(size(model%bodies))
      integer :: k
      associate (x => plane%center(plane%axis), tol => tolerance(model%grid))
         has = [(x >= model%bodies(k)%lower(plane%axis) - tol .and. x <= model%bodies(k)%upper(plane%axis) + tol, k=1, size(has))]
      end associate
      lower = [(minval(model%bodies%lower(k), mask=has), k=1, ndim)]
      upper = [(maxval(model%bodies%upper(k), mask=has), k=1, ndim)]
      allocate (region%outline(2, 0), region%may_be_front(0), region%is_corner(0))
      if (.not. all(upper > lower)) return
      region = region_of(plane%crack_shape_t, lower, upper, finest_cell(model))
      if (.not. has_shapes(model)) return
      allocate (region%bodies(count(has)))
      do k = 1, size(has)
         if (has(k)) region%bodies(count(has(:k))) = model%bodies(k)%whole_outline()
      end do
      region%walls = walls_of(region%bodies)
   end function region_in

   !> Size of the finest cells that there may be [m].
   pure real(dp) function finest_cell(model)
      type(model_t), intent(in) :: model
      finest_cell = model%grid%cell
      if (model%refine%is_active()) finest_cell = scale(finest_cell, -model%refine%max_level)
   end function finest_cell
end module hampm_crack_placement
