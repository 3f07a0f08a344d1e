!> What a user should know of a scene that can be run, before its numbers are believed: where they mean something else than one
!> may think (`warnings_of`), and what the method makes of it (`notes_of`). A line each.
module hampm_caveats
   use hampm_kinds, only: dp, ndim
   use hampm_bodies, only: points_along
   use hampm_crack_placement, only: body_at
   use hampm_history_resolution, only: begins_too_late, coarse_histories
   use hampm_joints, only: do_touch, gap_between, holds_material, share_nodes, sheets_of_bodies
   use hampm_path_placement, only: path_tip, path_direction, path_tips
   use hampm_placement, only: upper_corner, points_of, spacing_of, tolerance
   use hampm_scene, only: scene_t, material_spec_t
   use hampm_text, only: add => add_line, to_text, length_text, three_digits
   implicit none
   private
   public :: warnings_of, notes_of

   ! What solids have: waves pass at 10 m/s through gel and at 18 km/s through diamond; what is as heavy as stone or metal is as
   ! stiff. Beyond these there is more likely another unit; scenes without units have speeds about 1.
   real(dp), parameter :: slowest = 0.3_dp       !! bar wave [m/s]
   real(dp), parameter :: fastest = 3e4_dp       !! the same
   real(dp), parameter :: heavy = 2000           !! density [kg/m3] of what has no wave slower than
   real(dp), parameter :: slow_for_heavy = 100   !! this [m/s]
   real(dp), parameter :: largest = 1000         !! extent of a grid [m]
   real(dp), parameter :: smallest = 1e-7_dp     !! the same

contains

   !> Where numbers of the scene mean something else than they seem to.
   function warnings_of(scene) result(text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable :: text
      text = scene%warned
      call look_at_constraints(scene, text)
      call look_at_gaps(scene, text)
      call look_at_points(scene, text)
      call look_at_rows(scene, text)
      call look_at_interfaces(scene, text)
      call look_at_starts(scene, text)
      call look_at_tips(scene, text)
      if (coarse_histories(scene) /= '') call add(text, coarse_histories(scene))
   end function warnings_of

   !> What the method makes of the scene, and which units look wrong.
   pure function notes_of(scene) result(text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable :: text
      integer :: i
      text = scene%noted
      do i = 1, size(scene%materials)
         call look_at_units(scene%materials(i), text)
      end do
      associate (extent => maxval(upper_corner(scene%grid) - scene%grid%lower))
         if (extent > largest .or. extent < smallest) &
            call add(text, '&grid: it is '//length_text(extent)//' m large; lengths are in m')
      end associate
      call look_at_bodies(scene, text)
      call look_at_lines(scene, text)
   end function notes_of

   !> What begins when the run is over does nothing.
   pure subroutine look_at_starts(scene, text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable, intent(inout) :: text
      integer :: k
      if (scene%method%time == 'static') return  ! there is a rule for it
      if (any(scene%refine%indicator == ['gradient', 'zz      ']) .and. begins_too_late(scene, scene%refine%start)) &
         call add(text, '&refine: no cell refines: start is '//to_text(scene%refine%start)//' s, and the run ends at '// &
                  to_text(scene%run%end_time)//' s')
      do k = 1, size(scene%growth)
         if (.not. begins_too_late(scene, scene%growth(k)%start)) cycle
         call add(text, '&growth '//to_text(k)//': no crack grows by it: start is '//to_text(scene%growth(k)%start)// &
                  ' s, and the run ends at '//to_text(scene%run%end_time)//' s')
      end do
   end subroutine look_at_starts

   !> Of cracks that cut bodies in two there is no tip at which G could be found.
   pure subroutine look_at_tips(scene, text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable, intent(inout) :: text
      integer :: k
      if (size(scene%paths) == 0 .or. .not. scene%energy_release%needs_crack()) return
      do k = 1, size(scene%paths)
         if (any(path_tips(scene, k))) return
      end do
      call add(text, '&energy_release estimators: no G, J or K is recorded: no end of a &crack is inside the material, so that '// &
               'none is a tip')
   end subroutine look_at_tips

   !> Constraints that hold nothing yet: a wall, or a slip of the pen.
   pure subroutine look_at_constraints(scene, text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable, intent(inout) :: text
      integer :: k
      do k = 1, size(scene%constraints)
         if (holds_material(scene, scene%constraints(k)%lower, scene%constraints(k)%upper)) cycle
         call add(text, '&constraint('//to_text(k)//') holds no node of a cell with material: it does nothing before material '// &
                  'comes there')
      end do
   end subroutine look_at_constraints

   !> Bodies that do not touch but have cells at a common node are joined there.
   pure subroutine look_at_gaps(scene, text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable, intent(inout) :: text
      integer :: i, j, sheet(size(scene%bodies))
      sheet = sheets_of_bodies(scene)
      do i = 2, size(scene%bodies)
         do j = 1, i - 1
            if (sheet(i) /= sheet(j)) cycle
            if (do_touch(scene, i, j) .or. .not. share_nodes(scene, i, j)) cycle
            call add(text, 'bodies '//to_text(j)//' and '//to_text(i)//' are '//length_text(gap_between(scene, i, j))// &
                     ' m apart, but no whole cell is free between them: they act on each other from the start, as if they '// &
                     'touched. Use smaller &grid cell, &contact, or a &crack where they are to part')
         end do
      end do
   end subroutine look_at_gaps

   !> One particle a cell leaves modes of the cell without stiffness.
   pure subroutine look_at_points(scene, text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable, intent(inout) :: text
      integer :: body
      real(dp), allocatable :: tips(:, :), directions(:, :)
      integer :: k
      if (.not. scene%energy_release%has('nodal_force')) return
      call list_tips(scene, tips, directions)
      body = 0
      do k = 1, size(tips, 2)
         body = body_at(scene, tips(:, k))
         if (body > 0) then
            if (scene%bodies(body)%points_per_cell == 1) exit
         end if
         body = 0
      end do
      if (body == 0) return
      call add(text, 'G_nodal_force is 14 to 24 % off with points_per_cell = 1 around the tip of the crack; use 2, or the '// &
               'estimator ''domain_integral''')
   end subroutine look_at_points

   !> Cracks that run through the middles of particles over more than a cell: these are on no side of it.
   pure subroutine look_at_rows(scene, text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable, intent(inout) :: text
      real(dp) :: apart
      integer :: k, s, body, level, n, least, most
      least = scene%grid%order - 1               ! quadratic cells that are cut have more particles
      most = least + merge(0, scene%refine%max_level, scene%refine%indicator == 'none')
      do k = 1, size(scene%paths)
         rows: do body = 1, size(scene%bodies)
            do level = least, most
               do s = 2, size(scene%paths(k)%points, 2)
                  call find_row(scene, body, level, scene%paths(k)%points(:, s - 1), scene%paths(k)%points(:, s), n, apart)
                  if (n == 0) cycle
                  call add(text, '&crack '''//trim(scene%paths(k)%name)//''': '//to_text(n)//' particles of body '// &
                           to_text(body)//trim(merge(' in finer cells', '               ', level > least))// &
                           ' are on it in a row, and are split into their halves beside it. Moved across by '// &
                           three_digits(apart/2)//' m it runs between two rows of them and splits none of these')
                  exit rows
               end do
            end do
         end do rows
      end do
   end subroutine look_at_rows

   !> The longest row of particles of a body, in cells that are refined a number of times, through the middles of which a segment runs.
   pure subroutine find_row(scene, body, level, a, b, n, apart)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: body, level
      real(dp), intent(in) :: a(ndim), b(ndim)   !! ends of the segment [m]
      integer, intent(out) :: n                  !! particles in the row; 0 where it is no longer than such a cell
      real(dp), intent(out) :: apart             !! how far the next row is [m]
      real(dp) :: lower(ndim), spacing(ndim), x(ndim), cell, step, place
      integer :: c, d, last, here
      n = 0
      apart = 0
      cell = scene%grid%cell/2**level
      lower = merge(scene%grid%lower, scene%bodies(body)%lower, scene%bodies(body)%outline%is_there())
      spacing = spacing_of(scene, scene%bodies(body))/2**level
      d = maxloc(abs(b - a)/spacing, dim=1)
      step = spacing(d)*norm2(b - a)/abs(b(d) - a(d)) ! along the segment from one column of particles to the next
      last = -huge(last)/2
      here = 0
      do c = ceiling((min(a(d), b(d)) - lower(d))/spacing(d) - 0.5_dp), floor((max(a(d), b(d)) - lower(d))/spacing(d) - 0.5_dp)
         x(d) = lower(d) + (c + 0.5_dp)*spacing(d)
         x(3 - d) = a(3 - d) + (x(d) - a(d))*(b(3 - d) - a(3 - d))/(b(d) - a(d))
         place = (x(3 - d) - lower(3 - d))/spacing(3 - d) - 0.5_dp
         if (abs(place - anint(place))*spacing(3 - d) > tolerance(scene%grid) .or. body_at(scene, x) /= body) cycle
         here = merge(here + 1, 1, (c - last)*step <= sqrt(2.0_dp)*cell*(1 + 1e-9_dp))
         if (here > 1 .and. here*(c - last)*step > cell .and. here > n) then
            n = here
            apart = product(spacing)/((c - last)*step)
         end if
         last = c
      end do
   end subroutine find_row

   !> Modes are found for a crack in one material: the fields around a tip at an interface are others, and mix the modes. (Domain integrals
   !> give J there, where the interface runs along the crack, and no K.)
   pure subroutine look_at_interfaces(scene, text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable, intent(inout) :: text
      real(dp), allocatable :: tips(:, :), directions(:, :)
      real(dp) :: aside(ndim)
      integer :: around(4), k, t, body           ! materials around a tip, 0 for none
      call list_tips(scene, tips, directions)
      do t = 1, size(tips, 2)
         do k = 1, 4
            aside = 0.25_dp*scene%grid%cell*(merge(1, -1, k <= 2)*directions(:, t) + merge(1, -1, mod(k, 2) == 0) &
                                             *[-directions(2, t), directions(1, t)])
            body = body_at(scene, tips(:, t) + aside)
            around(k) = 0
            if (body > 0) around(k) = scene%bodies(body)%material_index
         end do
         if (.not. any(around > 0 .and. .not. are_alike(scene, around, maxval(around)))) cycle
         call add(text, 'the tip of the crack is between two materials: the parts of modes I and II depend on the size of the '// &
                  'cells there, and only their sum has a meaning; K is not recorded')
         return
      end do
   end subroutine look_at_interfaces

   !> All tips, and unit vectors out of the cracks there.
   pure subroutine list_tips(scene, tips, directions)
      type(scene_t), intent(in) :: scene
      real(dp), allocatable, intent(out) :: tips(:, :), directions(:, :) !! (ndim, tips), [m]
      logical :: is_tip(2)
      real(dp) :: out(ndim)
      integer :: k, end
      allocate (tips(ndim, 0), directions(ndim, 0))
      do k = 1, size(scene%paths)
         is_tip = path_tips(scene, k)
         do end = 1, 2
            if (.not. is_tip(end)) cycle
            out = path_direction(scene%paths(k), end)
            tips = reshape([tips, path_tip(scene%paths(k), end)], [ndim, size(tips, 2) + 1])
            directions = reshape([directions, out/norm2(out)], [ndim, size(directions, 2) + 1])
         end do
      end do
   end subroutine list_tips

   !> Whether two materials have the same constants.
   elemental logical function are_alike(scene, i, j)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: i, j
      are_alike = i == j
      if (are_alike .or. min(i, j) == 0) return
      associate (a => scene%materials(i), b => scene%materials(j))
         are_alike = a%law == b%law .and. .not. (abs(a%young - b%young) > 0 .or. abs(a%poisson - b%poisson) > 0)
         are_alike = are_alike .and. all(abs(a%orthotropic%constants() - b%orthotropic%constants()) <= 0)
      end associate
   end function are_alike

   !> Constants of a material that are in other units, more likely than not.
   pure subroutine look_at_units(material, text)
      type(material_spec_t), intent(in) :: material
      character(:), allocatable, intent(inout) :: text
      real(dp) :: speed
      speed = sqrt(material%least_young()/material%density)
      if (speed >= slowest .and. speed <= fastest .and. (speed >= slow_for_heavy .or. material%density < heavy)) return
      call add(text, '&material '''//trim(material%name)//''': waves would pass at '// &
               three_digits(speed)//' m/s; '//trim(merge('young_1', 'young  ', material%law == 'orthotropic'))// &
               ' is in Pa, density in kg/m3 (steel: 210e9 and 7850)')
   end subroutine look_at_units

   !> What bodies do to each other.
   pure subroutine look_at_bodies(scene, text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable, intent(inout) :: text
      integer, parameter :: most_named = 6
      character(:), allocatable :: pairs
      integer :: i, j, touching, apart, sheet(size(scene%bodies))
      sheet = sheets_of_bodies(scene)
      touching = 0
      apart = 0
      pairs = ''
      do i = 2, size(scene%bodies)
         do j = 1, i - 1
            if (sheet(i) /= sheet(j)) cycle
            if (.not. do_touch(scene, i, j)) then
               apart = apart + 1
               cycle
            end if
            touching = touching + 1
            if (touching > most_named) cycle
            if (touching > 1) pairs = pairs//', '
            pairs = pairs//to_text(j)//' and '//to_text(i)
         end do
      end do
      if (touching > most_named) pairs = pairs//' and '//to_text(touching - most_named)//' other pairs'
      if (touching > 0) call add(text, 'bodies '//pairs//' touch: they are joined as one, but where a &crack parts them')
      if (apart > 0 .and. scene%method%frame == 'updated') call add(text, 'bodies that meet act on each other from about a '// &
         'cell apart ('//to_text(scene%grid%cell)//' m) on, by the nodes that their cells have in common, and stick as long '// &
         'as they are so near; smaller cells make both less, and &contact lets them meet where they are')
   end subroutine look_at_bodies

   !> Bodies that have more points than they were given, as these would stand on grid lines.
   pure subroutine look_at_lines(scene, text)
      type(scene_t), intent(in) :: scene
      character(:), allocatable, intent(inout) :: text
      integer :: k, n(ndim)
      do k = 1, size(scene%bodies)
         associate (b => scene%bodies(k))
            if (b%outline%is_there()) cycle
            n = points_of(scene, b)
            if (all(n == points_along(b%lower, b%upper, scene%grid%cell, b%points_per_cell))) cycle
            call add(text, 'body '//to_text(k)//' has '//to_text(n(1))//' by '//to_text(n(2))//' points, more than &body '// &
                     'points_per_cell = '//to_text(b%points_per_cell)//' gives: of these some would stand on grid lines, '// &
                     'strained by the cell on one side only')
         end associate
      end do
   end subroutine look_at_lines
end module hampm_caveats
