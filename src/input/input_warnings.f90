!> Warnings of a valid model before its results are used: values with unexpected meaning (`warnings_of`), and effects of the method
!> (`notes_of`). A line each.
module hampm_input_warnings
   use hampm_key_table, only: material_constants
   use hampm_kinds, only: dp, ndim
   use hampm_bodies, only: points_along
   use hampm_crack_lines, only: length_of
   use hampm_crack_placement, only: body_at
   use hampm_edge_parts, only: edge_part_t
   use hampm_history_resolution, only: begins_too_late, coarse_histories
   use hampm_joints, only: do_touch, holds_material, near_pairs, share_nodes, velocity_fields_of
   use hampm_law, only: value_of
   use hampm_path_placement, only: path_tip, path_direction, path_outside, path_tips
   use hampm_placement, only: upper_corner, points_of, reach_of, spacing_of, tolerance, point_text
   use hampm_model, only: model_t, material_spec_t
   use hampm_tensors, only: norm, in_plane
   use hampm_text, only: add => add_line, to_text, length_text, three_digits
   implicit none
   private
   public :: warnings_of, notes_of

   ! Ranges of solids: wave speeds from 10 m/s in gel to 18 km/s in diamond; dense as stone or metal means stiff as those. Values
   ! beyond suggest another unit; models without units have speeds about 1.
   real(dp), parameter :: slowest = 0.3_dp       !! bar wave [m/s]
   real(dp), parameter :: fastest = 3e4_dp       !! the same
   real(dp), parameter :: heavy = 2000           !! density [kg/m3] of materials without waves slower than
   real(dp), parameter :: slow_for_heavy = 100   !! this [m/s]
   real(dp), parameter :: largest = 1000         !! extent of a grid [m]
   real(dp), parameter :: smallest = 1e-7_dp     !! the same

contains

   !> Values of the model with unexpected meaning, and units that may be wrong.
   function warnings_of(model) result(text)
      type(model_t), intent(in) :: model
      character(:), allocatable :: text, sides
      logical :: strays
      integer :: i
      text = model%warned
      call check_constraints(model, text)
      call check_gaps(model, text)
      call check_particles_per_cell(model, text)
      call check_rows(model, text)
      call check_interfaces(model, text)
      call check_starts(model, text)
      call check_tips(model, text)
      call check_ends(model, text)
      call check_point_loads(model, text)
      do i = 1, size(model%loads)
         call find_sides(model, i, sides, strays)
         if (strays) call add(text, '&load '//to_text(i)//': its box takes parts of several sides:'//sides// &
                              '. To load one of them alone, give its number: side')
      end do
      do i = 1, size(model%materials)
         call check_units(model%materials(i), text)
      end do
      if (coarse_histories(model) /= '') call add(text, coarse_histories(model))
   end function warnings_of

   !> The displacement of a point load has no limit as cells shrink.
   pure subroutine check_point_loads(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      integer :: k, i, at
      do k = 1, size(model%probes)
         if (.not. model%probes(k)%gives('load_line')) cycle
         do i = 1, size(model%probes(k)%of)
            if (model%probes(k)%of(i) == '') cycle
            at = findloc(model%loads%name, model%probes(k)%of(i), dim=1)
            if (at == 0) cycle
            if (model%loads(at)%kind == 'point') &
               call add(text, '&probe '''//trim(model%probes(k)%name)//''': the displacement of the point load '''// &
                        trim(model%loads(at)%name)//''' depends on the cells there, and has no limit as they shrink. Give a '// &
                        'traction on a part of an edge, or record the displacement at a place some cells away')
         end do
      end do
   end subroutine check_point_loads

   !> Sides of polygons on which a load on edges acts, and its length on each; `strays` if it takes part of a side at a sharp angle
   !> to its main side, as a box around a slanted side that reaches around its corner.
   pure subroutine find_sides(model, k, list, strays)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k                   !! load
      character(:), allocatable, intent(out) :: list !! '' where it acts on no polygon
      logical, intent(out) :: strays
      real(dp), parameter :: sharp = 0.87_dp     ! cosine of 30 degrees
      real(dp), allocatable :: length(:), whole(:), along(:, :)
      type(edge_part_t), allocatable :: parts(:)
      integer :: b, r, i, j, n, most
      list = ''
      strays = .false.
      associate (load => model%loads(k), tol => tolerance(model%grid))
         if (ndim > 2 .or. .not. load%has_place .or. all(load%kind /= [character(9) :: 'traction', 'pressure', 'absorbing'])) return
         do b = 1, size(model%bodies)
            if (.not. model%bodies(b)%outline%is_there()) cycle
            associate (outline => model%bodies(b)%outline)
               parts = outline%parts_in_box(load%lower, load%upper, tol, model%grid%lower, model%grid%cell, load%side)
               do r = 1, size(outline%rings)
                  if (outline%rings(r)%is_circle) cycle
                  n = size(outline%rings(r)%points, 2)
                  along = cshift(outline%rings(r)%points, 1, dim=2) - outline%rings(r)%points
                  whole = sqrt(sum(along**2, dim=1))
                  length = [(sum([(2*norm(parts(j)%half), j=1, size(parts))], mask=parts%ring == r .and. parts%side == i), i=1, n)]
                  most = maxloc(length, dim=1)
                  do i = 1, n
                     if (.not. length(i) > tol) cycle
                     list = list//trim(merge(', ', '  ', list /= ''))//' '//length_text(length(i))//' m of side '//to_text(i)
                     if (r > 1) list = list//' of its hole '//to_text(r - 1)
                     if (size(model%bodies) > 1) list = list//' of body '//to_text(b)
                     strays = strays .or. load%side == 0 .and. length(i) < whole(i) - tol .and. &
                              dot_product(along(:, i), along(:, most)) < sharp*whole(i)*whole(most)
                  end do
               end do
            end associate
         end do
      end associate
   end subroutine find_sides

   !> Effects of the method on the model, and doubts about its grid.
   pure function notes_of(model) result(text)
      type(model_t), intent(in) :: model
      character(:), allocatable :: text, sides
      logical :: strays
      integer :: i
      text = model%noted
      associate (extent => maxval(upper_corner(model%grid) - model%grid%lower))
         if (extent > largest .or. extent < smallest) &
            call add(text, '&grid: it is '//length_text(extent)//' m large; lengths are in m')
      end associate
      call check_bodies(model, text)
      call check_lines(model, text)
      do i = 1, size(model%loads)
         call find_sides(model, i, sides, strays)
         if (sides /= '') call add(text, '&load '//to_text(i)//' acts on'//sides)
      end do
   end function notes_of

   !> A load that begins after the end of the run has no effect.
   pure subroutine check_starts(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      integer :: k
      if (model%method%time == 'static') return  ! there is a rule for it
      if (model%refine%looks_at_motion() .and. begins_too_late(model, model%refine%start)) &
         call add(text, '&refine: no cell refines: start is '//to_text(model%refine%start)//' s, and the run ends at '// &
                  to_text(model%run%end_time)//' s')
      do k = 1, size(model%growth)
         if (.not. begins_too_late(model, model%growth(k)%start)) cycle
         call add(text, '&growth '//to_text(k)//': no crack grows by it: start is '//to_text(model%growth(k)%start)// &
                  ' s, and the run ends at '//to_text(model%run%end_time)//' s')
      end do
   end subroutine check_starts

   !> Of cracks that cut bodies in two there is no tip at which G could be found.
   pure subroutine check_tips(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      integer :: k
      if (size(model%paths) == 0 .or. size(model%energy_release%chosen) == 0) return
      do k = 1, size(model%paths)
         if (any(path_tips(model, k))) return
      end do
      call add(text, '&energy_release estimators: no G, J or K is recorded: no end of a &crack is inside the material, so that '// &
               'none is a tip')
   end subroutine check_tips

   !> Ends of cracks farther outside the box around the bodies than the crack is long in the material: probably meant as tips.
   pure subroutine check_ends(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      real(dp), parameter :: enough = 2          ! root cells
      real(dp) :: away, x(ndim)
      integer :: k, end, d
      do k = 1, size(model%paths)
         if (model%paths(k)%is_symmetry .or. .not. any(path_tips(model, k))) cycle
         associate (points => model%paths(k)%points, outside => path_outside(model, k))
            do end = 1, 2
               x = points(:, merge(1, size(points, 2), end == 1))
               away = maxval([(max(minval(model%bodies%lower(d)) - x(d), x(d) - maxval(model%bodies%upper(d))), d=1, ndim)])
               if (away <= max(enough*model%grid%cell, length_of(points) - sum(outside))) cycle
               call add(text, '&crack '//to_text(k)//': its end '//point_text(x)//' m is '//length_text(away)// &
                        ' m out of all bodies, and no tip: the crack is '//length_text(length_of(points) - sum(outside))// &
                        ' m long in the material. A mouth needs to be no more than a cell beyond the surface')
            end do
         end associate
      end do
   end subroutine check_ends

   !> Constraints that hold nothing yet: walls or errors. Constraints that cells change: they hold less of a body than some cells,
   !> or end between nodes without being held in part (`hampm_part_supports`).
   pure subroutine check_constraints(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      real(dp) :: reach(ndim, 2), at(ndim, 2)
      character(:), allocatable :: held, with
      integer :: k
      do k = 1, size(model%constraints)
         associate (c => model%constraints(k), grid => model%grid)
            if (.not. holds_material(model, c%lower, c%upper)) then
               call add(text, '&constraint('//to_text(k)//') holds no node of a cell with material: it does nothing before '// &
                        'material comes there')
               cycle
            end if
            held = held_of_body(model, c%lower, c%upper)
            if (held /= '') &
               call add(text, '&constraint('//to_text(k)//') holds '//held//': how far it gives way, and so energies and G, '// &
                        'depends on the cells, and no estimated error knows of it. Let it hold more, or use smaller &grid cell')
            if (all(c%upper - c%lower > tolerance(grid))) cycle
            with = ''
            if (c%motion%turns) with = 'turns'
            if (c%motion%unilateral) with = 'unilateral'
            if (with == '') cycle
            reach = reach_of(model, c%lower, c%upper)
            at = (reach - spread(grid%lower, 2, 2))/grid%cell*grid%order
            if (any(abs(at - anint(at))*grid%cell > tolerance(grid) .and. at > 0 .and. &
                    at < grid%order*spread(grid%cells, 2, 2) .and. spread(c%upper - c%lower > tolerance(grid), 2, 2))) &
               call add(text, '&constraint('//to_text(k)//') ends between nodes: with '//with//' it holds the nodes in its '// &
                        'box alone, and so up to a cell less at each end. Let it end at nodes, which are at &grid lower + i*cell')
         end associate
      end do
   end subroutine check_constraints

   !> The part of bodies in a box, in words, if below the resolution: a cell along an edge or, for bodies that are no rectangles,
   !> two whole ones.
   pure function held_of_body(model, lower, upper) result(held)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! corners of the box [m]
      character(:), allocatable :: held
      real(dp), parameter :: fewest(2) = [1, 2]  ! along an edge, and whole ones
      type(edge_part_t), allocatable :: parts(:)
      real(dp) :: cells(2)                       ! that are held
      integer :: i, k
      held = ''
      if (all(upper - lower < model%grid%cell)) return ! a pin
      cells = 0
      do i = 1, size(model%bodies)
         associate (body => model%bodies(i), cell => model%grid%cell)
            if (.not. body%outline%is_there()) then
               associate (common => min(body%upper, upper) - max(body%lower, lower), tol => tolerance(model%grid))
                  if (.not. all(common >= -tol)) cycle
                  if (any(common >= body%upper - body%lower - tol)) return ! a whole edge
                  cells(1) = max(cells(1), maxval(common)/cell)
               end associate
            else
               cells(2) = cells(2) + body%area_in(lower, upper)/cell**ndim
               parts = body%outline%parts_in_box(lower, upper, tolerance(model%grid), model%grid%lower, cell, 0)
               cells(1) = max(cells(1), sum([(maxval(abs(parts(k)%half))*2/cell, k=1, size(parts))], &
                                            mask=[(maxval(abs(parts(k)%normal)) > 0.999_dp, k=1, size(parts))]))
            end if
         end associate
      end do
      if (any(cells > fewest)) return
      held = three_digits(cells(1))//' of a cell along an edge'
      if (cells(2) > 0) held = three_digits(cells(2))//' cells of the body'
   end function held_of_body

   !> Bodies that do not touch but have cells at a common node are joined there.
   pure subroutine check_gaps(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      integer, allocatable :: pairs(:, :)
      integer :: k, velocity_field(size(model%bodies))
      velocity_field = velocity_fields_of(model)
      pairs = near_pairs(model)
      do k = 1, size(pairs, 2)
         associate (i => pairs(1, k), j => pairs(2, k))
            if (velocity_field(i) /= velocity_field(j)) cycle
            if (do_touch(model, i, j) .or. .not. share_nodes(model, i, j)) cycle
            call add(text, 'bodies '//to_text(j)//' and '//to_text(i)//' are '// &
                     length_text(model%bodies(i)%gap_to(model%bodies(j)))//' m apart, but no whole cell is free between '// &
                     'them: they act on each other from the start, as if they touched. Use '// &
                     'smaller &grid cell, &contact, or a &crack where they are to separate')
         end associate
      end do
   end subroutine check_gaps

   !> One particle a cell leaves modes of the cell without stiffness.
   pure subroutine check_particles_per_cell(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      real(dp), allocatable :: tips(:, :), directions(:, :)
      integer :: k, body, row
      row = findloc(model%energy_release%chosen%needs_two_points, .true., dim=1)
      if (row == 0) return
      call list_tips(model, tips, directions)
      do k = 1, max(size(tips, 2), merge(size(model%bodies), 0, size(model%planes) > 0))
         body = k
         if (size(model%planes) == 0) body = body_at(model, tips(:, k))
         if (body == 0) cycle
         if (model%bodies(body)%points_per_cell /= 1) cycle
         call add(text, 'G_'//trim(model%energy_release%chosen(row)%name)//' is 14 to 24 % off with points_per_cell = 1 around '// &
                  'the tip of the crack; use 2, or the estimator ''domain_integral''')
         return
      end do
   end subroutine check_particles_per_cell

   !> Cracks that run through the middles of particles over more than a cell: these are on no side of it.
   pure subroutine check_rows(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      real(dp) :: apart
      integer :: k, s, body, level, n, least, most
      least = model%grid%order - 1               ! quadratic cells that are cut have more particles
      most = least + merge(model%refine%max_level, 0, model%refine%is_active())
      do k = 1, size(model%paths)
         rows: do body = 1, size(model%bodies)
            do level = least, most
               do s = 2, size(model%paths(k)%points, 2)
                  call find_row(model, body, level, model%paths(k)%points(:, s - 1), model%paths(k)%points(:, s), n, apart)
                  if (n == 0) cycle
                  call add(text, '&crack '''//trim(model%paths(k)%name)//''': '//to_text(n)//' particles of body '// &
                           to_text(body)//trim(merge(' in finer cells', '               ', level > least))// &
                           ' are on it in a row, and are split into their halves beside it. Moved across by '// &
                           three_digits(apart/2)//' m it runs between two rows of them and splits none of these')
                  exit rows
               end do
            end do
         end do rows
      end do
   end subroutine check_rows

   !> The longest row of particles of a body, in cells of a refinement level, along a segment through their middles.
   pure subroutine find_row(model, body, level, a, b, n, apart)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body, level
      real(dp), intent(in) :: a(ndim), b(ndim)   !! ends of the segment [m]
      integer, intent(out) :: n                  !! particles in the row; 0 if it is no longer than such a cell
      real(dp), intent(out) :: apart             !! distance to the next row [m]
      real(dp) :: lower(ndim), spacing(ndim), x(ndim), cell, step, place
      integer :: c, d, last, here
      n = 0
      apart = 0
      cell = model%grid%cell/2**level
      lower = merge(model%grid%lower, model%bodies(body)%lower, model%bodies(body)%outline%is_there())
      spacing = spacing_of(model, model%bodies(body))/2**level
      d = maxloc(abs(b - a)/spacing, dim=1)
      step = spacing(d)*norm(b - a)/abs(b(d) - a(d)) ! along the segment from one column of particles to the next
      last = -2**30
      here = 0
      do c = ceiling((min(a(d), b(d)) - lower(d))/spacing(d) - 0.5_dp), floor((max(a(d), b(d)) - lower(d))/spacing(d) - 0.5_dp)
         x(d) = lower(d) + (c + 0.5_dp)*spacing(d)
         x(3 - d) = a(3 - d) + (x(d) - a(d))*(b(3 - d) - a(3 - d))/(b(d) - a(d))
         place = (x(3 - d) - lower(3 - d))/spacing(3 - d) - 0.5_dp
         if (abs(place - anint(place))*spacing(3 - d) > tolerance(model%grid) .or. body_at(model, x) /= body) cycle
         here = merge(here + 1, 1, (c - last)*step <= sqrt(2.0_dp)*cell*(1 + 1e-9_dp))
         if (here > 1 .and. here*(c - last)*step > cell .and. here > n) then
            n = here
            apart = product(spacing)/((c - last)*step)
         end if
         last = c
      end do
   end subroutine find_row

   !> Modes are separated for a crack in one material only: the fields around an interface tip mix the modes. (Domain integrals give
   !> J there, if the interface runs along the crack, and no K.)
   pure subroutine check_interfaces(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      real(dp), allocatable :: tips(:, :), directions(:, :)
      real(dp) :: aside(ndim)
      integer :: around(4), k, t, body           ! materials around a tip, 0 for none
      integer, allocatable :: materials(:)       ! of bodies in the plane of a crack
      logical :: is_between
      is_between = .false.
      call list_tips(model, tips, directions)
      do t = 1, size(tips, 2)
         do k = 1, 4
            aside = 0.25_dp*model%grid%cell*(merge(1, -1, k <= 2)*directions(:, t) + merge(1, -1, mod(k, 2) == 0) &
                                             *in_plane(-directions(2, t), directions(1, t)))
            body = body_at(model, tips(:, t) + aside)
            around(k) = 0
            if (body > 0) around(k) = model%bodies(body)%material_index
         end do
         is_between = is_between .or. any(around > 0 .and. .not. are_alike(model, around, maxval(around)))
      end do
      do t = 1, size(model%planes)
         associate (x => model%planes(t)%center(model%planes(t)%axis), axis => model%planes(t)%axis, tol => tolerance(model%grid))
            materials = pack(model%bodies%material_index, [(x > model%bodies(k)%lower(axis) - tol .and. &
                                                            x < model%bodies(k)%upper(axis) + tol, k=1, size(model%bodies))])
         end associate
         is_between = is_between .or. .not. all(are_alike(model, materials, materials(1)))
      end do
      if (is_between) &
         call add(text, 'the tip of the crack is between two materials: G of modes I and II depends on the size of the '// &
                  'cells there, only their sum is valid'//trim(merge('; K is not recorded', '                   ', &
                                                               .not. model%energy_release%phase_length > 0)))
   end subroutine check_interfaces

   !> All tips, and unit vectors out of the cracks there.
   pure subroutine list_tips(model, tips, directions)
      type(model_t), intent(in) :: model
      real(dp), allocatable, intent(out) :: tips(:, :), directions(:, :) !! (ndim, tips), [m]
      logical :: is_tip(2)
      real(dp) :: out(ndim)
      integer :: k, end
      allocate (tips(ndim, 0), directions(ndim, 0))
      do k = 1, size(model%paths)
         is_tip = path_tips(model, k)
         do end = 1, 2
            if (.not. is_tip(end)) cycle
            out = path_direction(model%paths(k), end)
            tips = reshape([tips, path_tip(model%paths(k), end)], [ndim, size(tips, 2) + 1])
            directions = reshape([directions, out/norm(out)], [ndim, size(directions, 2) + 1])
         end do
      end do
   end subroutine list_tips

   !> Whether two materials have the same constants.
   elemental logical function are_alike(model, i, j)
      type(model_t), intent(in) :: model
      integer, intent(in) :: i, j
      integer :: k
      are_alike = i == j
      if (are_alike .or. min(i, j) == 0) return
      associate (a => model%materials(i), b => model%materials(j))
         are_alike = a%law == b%law .and. .not. (abs(a%young - b%young) > 0 .or. abs(a%poisson - b%poisson) > 0)
         are_alike = are_alike .and. all([(abs(value_of(a%constants, material_constants(k)%name, 0.0_dp) - &
                                               value_of(b%constants, material_constants(k)%name, 0.0_dp)) <= 0, &
                                           k=1, size(material_constants))])
      end associate
   end function are_alike

   !> Constants of a material that are in other units, more likely than not.
   pure subroutine check_units(material, text)
      type(material_spec_t), intent(in) :: material
      character(:), allocatable, intent(inout) :: text
      real(dp) :: speed
      speed = sqrt(material%least_young()/material%density)
      if (speed >= slowest .and. speed <= fastest .and. (speed >= slow_for_heavy .or. material%density < heavy)) return
      call add(text, '&material '''//trim(material%name)//''': waves would pass at '// &
               three_digits(speed)//' m/s; '//trim(merge('young_1', 'young  ', material%law == 'orthotropic'))// &
               ' is in Pa, density in kg/m3 (steel: 210e9 and 7850)')
   end subroutine check_units

   !> Interaction of bodies.
   pure subroutine check_bodies(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      integer, parameter :: most_named = 6
      character(:), allocatable :: named
      integer, allocatable :: pairs(:, :)
      integer :: k, touching, velocity_field(size(model%bodies))
      logical :: are_apart                       ! whether any two on one velocity field are
      velocity_field = velocity_fields_of(model)
      pairs = near_pairs(model)
      touching = 0
      named = ''
      do k = 1, size(pairs, 2)
         associate (i => pairs(1, k), j => pairs(2, k))
            if (velocity_field(i) /= velocity_field(j)) cycle
            if (.not. do_touch(model, i, j)) cycle
            touching = touching + 1
            if (touching > most_named) cycle
            if (touching > 1) named = named//', '
            named = named//to_text(j)//' and '//to_text(i)
         end associate
      end do
      are_apart = touching < sum([(count(velocity_field == k)*(count(velocity_field == k) - 1.0_dp)/2, k=1, &
                                   maxval([0, velocity_field]))])
      if (touching > most_named) named = named//' and '//to_text(touching - most_named)//' other pairs'
      if (touching > 0) call add(text, 'bodies '//named//' touch: they are bonded, except along a &crack'// &
         trim(merge('; a crack that grows along their seam has the lesser toughness', repeat(' ', 62), &
                    size(model%growth) > 0 .and. maxval(model%bodies%toughness) > minval(model%bodies%toughness))))
      if (are_apart .and. model%method%frame == 'updated') call add(text, 'bodies interact from about a '// &
         'cell apart ('//to_text(model%grid%cell)//' m) on, by the nodes that their cells have in common, and stick as long '// &
         'as they are so near; smaller cells reduce both, and &contact resolves the gap')
   end subroutine check_bodies

   !> Bodies that have more points than they were given, as these would stand on grid lines.
   pure subroutine check_lines(model, text)
      type(model_t), intent(in) :: model
      character(:), allocatable, intent(inout) :: text
      integer :: k, n(ndim)
      do k = 1, size(model%bodies)
         associate (b => model%bodies(k))
            if (b%outline%is_there()) cycle
            n = points_of(model, b)
            if (all(n == points_along(b%lower, b%upper, model%grid%cell, b%points_per_cell))) cycle
            call add(text, 'body '//to_text(k)//' has '//to_text(n(1))//' by '//to_text(n(2))//' points, more than &body '// &
                     'points_per_cell = '//to_text(b%points_per_cell)//' gives: of these some would stand on grid lines, '// &
                     'strained by the cell on one side only')
         end associate
      end do
   end subroutine check_lines
end module hampm_input_warnings
