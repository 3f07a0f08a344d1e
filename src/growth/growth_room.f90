!> Geometry of the model around a growing crack: materials near its tips, and room for their domains.
module hampm_growth_room
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_crack_placement, only: held_ahead, least_radius, distance_in_material, body_at, is_covered, distance_to_loads, &
                                    distance_to_others, layer_around, sides_of_tip
   use hampm_crack_lines, only: find_nearest_segment, room_on_line
   use hampm_crack_tip, only: crack_tip_t
   use hampm_cracks, only: cracks_t, first_point
   use hampm_growing, only: growing_t
   use hampm_interface_points, only: interfaces_t
   use hampm_nodal_release, only: holds_on
   use hampm_model_materials, only: are_alike, material_of_body
   use hampm_path_placement, only: room_around, is_tip_at, reach_beyond
   use hampm_placement, only: tolerance
   use hampm_polygon, only: cross, distance_to_line, find_meeting
   use hampm_model, only: model_t
   use hampm_text, only: digits_text, to_text, without_rounding
   implicit none
   private
   public :: see_surroundings, see_around_tips, room_of_material, room_for, room_of_tip, is_free, why_no_room, find_end, &
             plan_end, end_tips, shrink_domains, find_loose_tips, is_plane_open

contains

   !> Find the surroundings of all tips, or of those of a crack.
   pure subroutine see_around_tips(model, cracks, crack)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(inout) :: cracks
      integer, intent(in), optional :: crack     !! its number
      integer :: k
      do k = 1, size(cracks%tips)
         if (present(crack)) then
            if (cracks%tips(k)%crack /= crack) cycle
         end if
         call see_surroundings(model, cracks%tips(k))
      end do
   end subroutine see_around_tips

   !> Find the surroundings of a tip: its material, the material just ahead, and those above and below at an interface; within its
   !> radii the layers along its crack, and bodies of other materials at which its domains end.
   pure subroutine see_surroundings(model, tip)
      type(model_t), intent(in) :: model
      type(crack_tip_t), intent(inout) :: tip
      real(dp), parameter :: ahead = 1e-6_dp     ! cells
      integer :: body, here, sides(2)
      real(dp) :: radius, layer, distance
      here = body_at(model, tip%place + ahead*model%grid%cell*tip%axis(:, 1))
      if (here == 0) here = body_at(model, tip%place)
      if (here > 0) tip%material = material_of_body(model, here)
      if (here == 0 .or. size(tip%radii) == 0 .or. size(model%bodies) == 1) return
      radius = maxval(tip%radii)
      tip%has_layers = .false.
      tip%to_other = huge(radius)
      if (allocated(tip%ends_at)) deallocate (tip%ends_at)
      do body = 1, size(model%bodies)
         if (are_alike(model, body, here)) cycle
         distance = model%bodies(body)%room_beside(tip%place)
         if (radius - distance <= tolerance(model%grid)) cycle
         layer = layer_around(model, body, tip%place, tip%axis(:, 1))
         tip%has_layers = tip%has_layers .or. layer > tolerance(model%grid)
         if (layer >= radius - tolerance(model%grid)) cycle
         tip%to_other = min(tip%to_other, max(distance, layer))
         if (layer > tolerance(model%grid)) cycle
         if (.not. allocated(tip%ends_at)) allocate (tip%ends_at(size(model%bodies)), source=.false.)
         tip%ends_at(body) = .true.
      end do
      tip%phase_length = 0
      if (.not. model%energy_release%phase_length > 0) return
      sides = sides_of_tip(model, tip%place, tip%axis(:, 1), radius)
      if (any(sides == 0)) return
      tip%phase_length = model%energy_release%phase_length
      tip%material = material_of_body(model, sides(1))
      tip%below = material_of_body(model, sides(2))
   end subroutine see_surroundings

   !> The largest radius of a domain integral around a tip before another material [m], at least two of the finest cells: if even
   !> these reach into it, their loss is an error.
   pure real(dp) function room_of_material(model, tip) result(room)
      type(model_t), intent(in) :: model
      type(crack_tip_t), intent(in) :: tip
      room = max(least_radius(model), distance_to_others(model, tip%place, tip%axis(:, 1)))
   end function room_of_material

   !> The largest radius of a domain integral around a tip at a place, at most `most` [m]; 0 if none fits.
   pure real(dp) function room_for(model, cracks, crack, place, most) result(room)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks       !! with their planned paths
      integer, intent(in) :: crack               !! its number
      real(dp), intent(in) :: place(ndim)        !! [m]
      real(dp), intent(in), optional :: most     !! [m]
      integer :: k
      room = huge(room)
      if (present(most)) room = most
      do k = 1, size(cracks%crack)
         if (k /= crack) room = min(room, distance_to_line(place, cracks%crack(k)%points))
      end do
      room = room_around(model, place, room)
      if (model%is_half()) room = min(room, held_ahead(model, place))
   end function room_for

   !> The largest radius of a domain integral around a tip, within which its crack is straight [m].
   pure real(dp) function room_of_tip(model, cracks, tip) result(room)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(crack_tip_t), intent(in) :: tip
      associate (points => cracks%crack(tip%crack)%points)
         room = room_for(model, cracks, tip%crack, tip%place, &
                         room_on_line(points, tip%place, merge(2, size(points, 2), tip%end == first_point), tip%end == first_point))
      end associate
   end function room_of_tip

   !> Whether no surface and no other crack, with its planned path, is between the end of a crack and a place: behind one there may
   !> be room again.
   logical function is_free(model, cracks, number, from, to)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: from(ndim), to(ndim) !! [m]
      real(dp) :: length
      length = norm(to - from)
      is_free = .not. length > 0
      if (is_free) return
      associate (direction => (to - from)/length)
         is_free = min(way_to_surface(model, from, direction, length), way_to_cracks(cracks, number, from, direction)) > length
      end associate
   end function is_free

   !> Distance of a place from all cracks except one, along their open parts [m].
   pure real(dp) function away_from_cracks(cracks, but, x) result(away)
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: but                 !! its number
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer :: k
      away = huge(away)
      do k = 1, size(cracks%crack)
         if (k /= but) away = min(away, distance_to_line(x, cracks%crack(k)%open_part()))
      end do
   end function away_from_cracks

   !> Why there is no room for a tip at a place.
   pure function why_no_room(model, place) result(why)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: place(ndim)        !! [m]
      character(:), allocatable :: why
      why = 'there is no room for a radius of the domain integral of two of the finest cells: a surface, a load, a constraint '// &
            'or another crack is near'
      if (.not. model%is_half() .or. body_at(model, place) == 0) return
      associate (held => held_ahead(model, place), material => distance_in_material(model, place, model%paths(1)%direction))
         if (held < min(least_radius(model), material)*(1 - 1e-9_dp)) &
            why = 'there is no &constraint that holds its symmetry plane ahead of it, over two of the finest cells at least'
      end associate
   end function why_no_room

   !> End of a crack: straight ahead at a surface, or at another crack with its planned path; `from` if another crack has reached
   !> it; if it would pass another crack, the nearest point of that, if within 60 degrees. None beyond `reach` or too near to a
   !> load.
   subroutine find_end(model, cracks, number, from, direction, reach, to, is_there)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: from(ndim)         !! [m]
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      real(dp), intent(in) :: reach              !! [m]
      real(dp), intent(out) :: to(ndim)          !! [m]
      logical, intent(out) :: is_there
      real(dp), parameter :: rounding = 1e-6_dp, least_cosine = 0.5_dp
      real(dp) :: way, along, nearest, beside(ndim)
      integer :: k, i
      way = min(way_to_surface(model, from, direction, reach), way_to_cracks(cracks, number, from, direction))
      nearest = reach
      beside = from
      do k = 1, size(cracks%crack)
         if (k == number) cycle
         associate (points => cracks%crack(k)%points)
            call find_nearest_segment(points, from, nearest, i, along)
            if (i > 0) beside = points(:, i - 1) + min(max(along, 0.0_dp), 1.0_dp)*(points(:, i) - points(:, i - 1))
         end associate
      end do
      is_there = way <= reach .or. nearest <= tolerance(model%grid)
      to = from
      if (way <= reach .and. nearest > tolerance(model%grid)) to = from + way*direction
      if (.not. is_there .and. dot_product(beside - from, direction) > least_cosine*norm(beside - from)) then
         is_there = .true.
         to = beside
      end if
      if (.not. is_there) return
      is_there = distance_to_loads(model, to) >= least_radius(model)*(1 - rounding)
      if (model%is_half()) is_there = is_there .and. held_ahead(model, from) >= way*(1 - rounding)
   end subroutine find_end

   !> Distance to the end of the material in a direction [m]; huge beyond `reach`.
   real(dp) function way_to_surface(model, from, direction, reach) result(way)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: from(ndim), direction(ndim) !! [m], and a unit vector
      real(dp), intent(in) :: reach              !! [m]
      integer, parameter :: looks = 8            ! in a cell
      real(dp), parameter :: around = 1e-6_dp    ! of a cell, around a sampled place
      real(dp) :: inside, outside
      integer :: turn
      way = huge(way)
      inside = 0
      do
         outside = min(inside + least_radius(model)/(2*looks), reach)
         if (.not. is_in(outside)) exit
         if (outside >= reach) return
         inside = outside
      end do
      do turn = 1, digits(way)
         if (is_in((inside + outside)/2)) then
            inside = (inside + outside)/2
         else
            outside = (inside + outside)/2
         end if
      end do
      way = inside + around*model%grid%cell

   contains

      !> Whether all around a place on the way there is material.
      logical function is_in(way)
         real(dp), intent(in) :: way             !! [m]
         is_in = is_covered(model, from + way*direction, around*model%grid%cell)
      end function is_in
   end function way_to_surface

   !> Distance from the end of a crack to other ones in a direction [m]; huge without any.
   pure real(dp) function way_to_cracks(cracks, number, from, direction) result(way)
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: from(ndim), direction(ndim) !! [m], and a unit vector
      integer :: k, i
      way = huge(way)
      do k = 1, size(cracks%crack)
         if (k == number) cycle
         associate (points => cracks%crack(k)%points)
            do i = 2, size(points, 2)
               way = min(way, way_to_segment(from, direction, points(:, i - 1), points(:, i)))
            end do
         end associate
      end do
   end function way_to_cracks

   !> Distance from a place to a segment in a direction [m]; huge without an intersection.
   pure real(dp) function way_to_segment(from, direction, a, b) result(way)
      real(dp), intent(in) :: from(ndim), direction(ndim), a(ndim), b(ndim) !! direction a unit vector, others [m]
      real(dp), parameter :: rounding = 1e-9_dp  ! of the segment
      real(dp) :: at
      call find_meeting(from, direction, a, b, way, at)
      if (abs(cross(direction, b - a)) <= rounding*norm(b - a)) then ! along it, to the nearer of its ends
         way = min(dot_product(a - from, direction), dot_product(b - from, direction))
         at = merge(0.0_dp, huge(at), abs(cross(direction, a - from)) <= rounding*norm(b - a))
      end if
      if (at < -rounding .or. at > 1 + rounding .or. .not. way > 0) way = huge(way)
   end function way_to_segment

   !> Whether a crack on a symmetry plane has run through all material there.
   pure logical function is_plane_open(model, cracks)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      real(dp) :: x(ndim)
      integer :: k
      is_plane_open = .false.
      if (.not. model%is_half()) return
      is_plane_open = cracks%tips(1)%has_ended
      do k = 1, 2*maxval(model%grid%cells)
         x = cracks%tips(1)%place + k*model%grid%cell/2*model%paths(1)%direction
         if (body_at(model, x) > 0) is_plane_open = .false.
      end do
   end function is_plane_open

   !> The last point of the crack of a tip is its end: plan how far cells are cut beyond it.
   subroutine plan_end(model, cracks, number)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(inout) :: cracks
      integer, intent(in) :: number              !! of the tip
      real(dp) :: x(ndim)
      integer :: crack
      x = cracks%end_place(number)
      crack = cracks%tips(number)%crack
      call cracks%plan_end(number, reach_beyond(model, x, cracks%end_direction(number), away_from_cracks(cracks, crack, x)))
      call see_around_tips(model, cracks, crack)
   end subroutine plan_end

   !> Shrink the domains of a tip near the end of its crack with the remaining room, down to a cell. With less nothing is measured.
   subroutine shrink_domains(growing, model, cracks, number, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(inout) :: cracks
      integer, intent(in) :: number              !! of the tip
      character(:), allocatable, intent(inout) :: message
      real(dp), parameter :: least = 0.5_dp      ! of the least radius elsewhere: a cell
      associate (tip => cracks%tips(number))
         if (tip%has_ended .or. .not. cracks%crack(tip%crack)%is_through(tip%end)) return
         growing%points(number)%room = min(room_for(model, cracks, tip%crack, tip%place), room_of_material(model, tip))
         call growing%fit_radii(number, least*least_radius(model), tip)
         tip%has_no_domain = growing%points(number)%room < least*least_radius(model)*(1 - 1e-9_dp)
         if (tip%has_no_domain) call growing%warn_once(number, 'is nearer than one of the finest cells to where its crack '// &
                                                       'ends: its G, J and K are not numbers from there on', message)
      end associate
   end subroutine shrink_domains

   !> Find the tips that have ended, in motion, and whose faces nothing holds on their path any more. `is_new`: one was not found
   !> before.
   subroutine find_loose_tips(growing, interfaces, is_new)
      type(growing_t), intent(inout) :: growing
      type(interfaces_t), intent(in) :: interfaces
      logical, intent(out) :: is_new
      integer :: k
      is_new = .false.
      do k = 1, size(growing%points)
         if (.not. growing%points(k)%has_ended .or. growing%points(k)%is_loose) cycle
         growing%points(k)%is_loose = .not. holds_on(interfaces, k, growing%points(k)%crack)
         is_new = is_new .or. growing%points(k)%is_loose
      end do
   end subroutine find_loose_tips

   !> A tip has reached the end of its crack. End all finished tips: those at a surface or on another crack, also if that has
   !> reached them.
   subroutine end_tips(growing, model, cracks, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(inout) :: cracks
      character(:), allocatable, intent(inout) :: message
      logical :: runs
      integer :: k
      call see_around_tips(model, cracks)
      do k = 1, size(cracks%tips)
         associate (tip => cracks%tips(k))
            runs = cracks%crack(tip%crack)%is_through(tip%end)
            if (.not. runs) then                 ! also where its way is planned to something that has come there
               associate (x => cracks%end_place(k))
                  if (is_tip_at(model, x, away_from_cracks(cracks, tip%crack, x))) cycle
               end associate
               call plan_end(model, cracks, k)
               growing%points(k)%has_no_room = .true.
            end if
            if (growing%points(k)%has_ended .or. .not. tip%has_ended) cycle
            growing%must_cut = .true.
            tip%speed = 0
            if (runs) then
               call growing%stop_points([k], 'has run through to '//what_is_there(tip%crack, tip%place)//': its crack ends '// &
                                        'there, at '//shown(tip%place), message, have_ended=.true.)
            else
               call growing%stop_points([k], 'has ended: another crack has come to it', message, have_ended=.true.)
            end if
         end associate
      end do

   contains

      !> A place, to six digits.
      function shown(place) result(text)
         real(dp), intent(in) :: place(ndim)     !! [m]
         character(:), allocatable :: text
         real(dp) :: x(ndim)
         x = without_rounding(place, model%grid%cell)
         text = '('//digits_text(x(1), 6)//', '//digits_text(x(2), 6)//') m'
      end function shown

      !> Name of the surface or crack that a tip has reached.
      function what_is_there(crack, place) result(what)
         integer, intent(in) :: crack            !! its number
         real(dp), intent(in) :: place(ndim)     !! [m]
         character(:), allocatable :: what
         integer :: other
         what = 'a surface'
         do other = 1, size(cracks%crack)
            if (other == crack) cycle
            if (.not. distance_to_line(place, cracks%crack(other)%points) <= tolerance(model%grid)) cycle
            what = 'crack '//to_text(other)
            if (model%paths(other)%name /= '') what = 'crack '''//trim(model%paths(other)%name)//''''
         end do
      end function what_is_there
   end subroutine end_tips
end module hampm_growth_room
