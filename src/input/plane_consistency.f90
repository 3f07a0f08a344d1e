!> Checks of plane cracks of solids: in a plane of the lattice, with a front inside the material and, on a symmetry plane, with
!> constraints that hold it.
module hampm_plane_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_crack_groups, only: crack_spec_t
   use hampm_crack_placement, only: body_at, finest_cell, is_fixed, region_in
   use hampm_front, only: front_t, region_t, region_of, find_fronts, plane_axes, room_of
   use hampm_model, only: model_t, has_shapes
   use hampm_placement, only: tolerance
   use hampm_polygon, only: find_crossing
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text, point_text, three_digits
   implicit none
   private
   public :: check_planes, check_shape

   character(*), parameter :: axes = 'xyz'
   real(dp), parameter :: least_width = 3        !! of a crack [finest cells]

contains

   !> Check them all.
   pure subroutine check_planes(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      character(*), parameter :: of_shape(*) = [character(9) :: 'normal', 'front', 'center', 'radii', 'points', 'tip', 'direction']
      integer :: k, d, before
      do k = 1, size(model%planes)
         associate (entry => settings%find('crack', k))
            if (.not. all([(settings%good(entry, trim(of_shape(d))), d=1, size(of_shape))])) cycle
            before = settings%errors%count
            call check_shape(model, model%planes(k), settings, entry)
            if (settings%errors%count == before) call check_place(model, model%planes(k), settings, entry)
         end associate
      end do
   end subroutine check_planes

   !> The numbers of a front make one.
   pure subroutine check_shape(model, plane, settings, entry)
      type(model_t), intent(in) :: model
      type(crack_spec_t), intent(in) :: plane
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      real(dp) :: tol, in_plane(ndim)
      type(region_t) :: region
      integer :: i, j
      tol = tolerance(model%grid)
      select case (plane%front)
       case ('straight')
         in_plane = plane%direction
         in_plane(plane%axis) = 0
         if (abs(plane%direction(plane%axis)) > 0 .or. .not. norm(in_plane) > 0) &
            call settings%complain(entry, 'direction', 'must be in the plane across '//axes(plane%axis:plane%axis)// &
                                   ', the normal, and not 0')
         if (plane%length > 0 .and. plane%length < least_width*finest_cell(model)) &
            call settings%complain(entry, 'length', 'must be '//to_text(least_width)//' of the finest cells, '// &
                                   to_text(finest_cell(model))//' m, or more')
       case ('disc', 'ellipse')
         if (size(plane%radii) /= merge(1, 2, plane%front == 'disc')) then
            call settings%complain(entry, 'radii', 'must have '//trim(merge('1 value ', '2 values', plane%front == 'disc'))// &
                                   ' with front = '''//trim(plane%front)//'''')
         else if (2*minval(plane%radii) < least_width*finest_cell(model)) then
            call settings%complain(entry, 'radii', 'must be '//to_text(least_width/2)//' of the finest cells, '// &
                                   to_text(finest_cell(model))//' m, or more')
         end if
       case ('polygon')
         call find_crossing(plane%points(plane_axes(plane%axis), :), .true., i, j)
         if (size(plane%points, 2) < 3) then
            call settings%complain(entry, 'points', 'must be three corners or more, each x, y, z')
         else if (any(abs(plane%points(plane%axis, :) - plane%points(plane%axis, 1)) > tol)) then
            call settings%complain(entry, 'points', 'must have the same '//axes(plane%axis:plane%axis)// &
                                   ', that of the plane across the normal')
         else if (i > 0) then
            call settings%complain(entry, 'points', 'must go around the crack: edges that are no neighbours must not meet')
         else
            region = region_of(plane%crack_shape_t, 0*plane%center, 0*plane%center, finest_cell(model))
            if (region%is_narrow(finest_cell(model)/2)) call settings%complain(entry, 'points', &
               'must be those of a wider crack: within half of the finest cells, '//to_text(finest_cell(model)/2)// &
               ' m, from its edges it must not lose any of them')
         end if
      end select
   end subroutine check_shape

   !> The crack is in a plane of the lattice and has a front in the material; on a symmetry plane the material is on one side and
   !> constraints hold the plane ahead of the front.
   pure subroutine check_place(model, plane, settings, entry)
      type(model_t), intent(in) :: model
      type(crack_spec_t), intent(in) :: plane
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      character(:), allocatable :: key
      real(dp) :: steps, aside(ndim)
      type(region_t) :: region
      type(front_t), allocatable :: fronts(:)
      logical :: is_above, is_below, is_there
      integer :: k, i
      key = 'center'
      if (plane%front == 'straight') key = 'tip'
      if (plane%front == 'polygon') key = 'points'
      if (.not. settings%good(entry, key)) return
      steps = (plane%center(plane%axis) - model%grid%lower(plane%axis))/model%grid%cell
      if (abs(steps - anint(steps))*model%grid%cell > tolerance(model%grid)) then
         call settings%complain(entry, key, axes(plane%axis:plane%axis)//' must be that of a plane of the lattice: the '// &
                                'nearest is '//to_text(model%grid%lower(plane%axis) + anint(steps)*model%grid%cell))
         return
      end if
      region = region_in(model, plane)
      is_there = size(region%outline) > 0
      if (is_there) then
         call find_fronts(region, fronts)
         is_there = size(fronts) > 0
      end if
      if (is_there) then
         aside = 0
         aside(plane%axis) = model%grid%cell/4
         is_above = any([((body_at(model, fronts(k)%at(:, i) + aside) > 0, i=1, fronts(k)%n()), k=1, size(fronts))])
         is_below = any([((body_at(model, fronts(k)%at(:, i) - aside) > 0, i=1, fronts(k)%n()), k=1, size(fronts))])
         is_there = is_above .or. is_below
      end if
      if (.not. is_there) then
         call settings%complain(entry, key, 'the front must be inside of the material')
      else if (plane%is_symmetry .and. is_above .and. is_below) then
         call settings%complain(entry, 'kind', '''symmetry'' must have material at one side of the plane, which is at '// &
                                axes(plane%axis:plane%axis)//' = '//to_text(region%plane)//'; use kind = ''plane''')
      else if (.not. plane%is_symmetry .and. .not. (is_above .and. is_below)) then
         call settings%complain(entry, 'kind', '''plane'' must have material at both sides of the plane, which is at '// &
                                axes(plane%axis:plane%axis)//' = '//to_text(region%plane))
      else if (plane%is_symmetry .and. .not. is_held(model, fronts, plane%axis)) then
         call settings%complain(entry, key, 'all nodes of the plane must be held in '//axes(plane%axis:plane%axis)// &
                                ' by a &constraint, for kind = ''symmetry'': the crack frees those that it opens')
      else if (size(model%energy_release%chosen) > 0) then
         call check_domain(model, plane, fronts, region%lower, region%upper, settings)
      end if
   end subroutine check_place

   !> Assumptions of estimators along a front: no loads near it, room around it and, for the domain integral, one material along it.
   pure subroutine check_domain(model, plane, fronts, lower, upper, settings)
      type(model_t), intent(in) :: model
      type(crack_spec_t), intent(in) :: plane
      type(front_t), intent(in) :: fronts(:)
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! extents of the material around the crack [m]
      type(settings_t), intent(inout) :: settings
      real(dp), parameter :: least_room = 3.4_dp ! finest cells: two to the smallest radius
      real(dp), parameter :: least_radius = 2    ! the same
      real(dp), parameter :: reach = 6           ! of the largest
      character(:), allocatable :: why
      real(dp), parameter :: along_axis = 0.999_dp ! component of a normal of a straight front along an axis
      real(dp) :: room, tol, low(ndim), high(ndim)
      integer :: k, first
      why = ''
      tol = tolerance(model%grid)
      do k = 1, size(fronts)
         room = room_of(fronts, k, lower, upper) ! gfortran 12 takes it for impure as an associate name
         if (room < least_room*finest_cell(model)) why = to_text(least_room)//' of the finest cells, '// &
            to_text(least_room*finest_cell(model))//' m, between each front and sides, corners and other fronts, and front '// &
            to_text(k)//' of a crack has '//three_digits(room)//' m'
         associate (radii => model%energy_release%radii)
            if (size(radii) > 0) then
               if (radii(1) < least_radius*finest_cell(model) .or. radii(size(radii)) > room) &
                  call settings%complain(settings%find('energy_release', 1), 'radii', 'must be from '// &
                                         to_text(least_radius*finest_cell(model))//' m, two of the finest cells, to '// &
                                         three_digits(room)//' m, what front '//to_text(k)//' of a crack has around it')
            end if
         end associate
      end do
      if (has_shapes(model)) then
         do k = 1, size(fronts)
            do first = 1, fronts(k)%n()
               associate (at => fronts(k)%at(:, first), ahead => least_room*finest_cell(model)*fronts(k)%outward(:, first))
                  if (any([body_at(model, at), body_at(model, at + ahead)] == 0)) why = 'a front inside of the material, '// &
                     'with '//to_text(least_room)//' of the finest cells ahead of it: curved sides may not end it, and front '// &
                     to_text(k)//' of a crack has none at '//point_text(at)//' m'
               end associate
            end do
         end do
      end if
      do k = 1, size(model%loads)
         associate (load => model%loads(k))
            if (.not. any(load%kind == ['traction', 'point   ', 'pressure']) .or. .not. load%has_place) cycle
            do first = 1, size(fronts)
               associate (at => fronts(first)%at)
                  if (all(load%lower < maxval(at, dim=2) + reach*finest_cell(model) .and. &
                          load%upper > minval(at, dim=2) - reach*finest_cell(model))) &
                     why = 'no load within '//to_text(reach*finest_cell(model))//' m, six of the finest cells, of the fronts'
               end associate
            end do
         end associate
      end do
      do k = 1, size(model%constraints)
         associate (box => model%constraints(k), far => reach*finest_cell(model), x => plane%center(plane%axis))
            do first = 1, size(fronts)
               low = minval(fronts(first)%at, dim=2) - far
               high = maxval(fronts(first)%at, dim=2) + far
               if (.not. all(box%lower < high .and. box%upper > low)) cycle
               if (plane%is_symmetry .and. max(abs(box%lower(plane%axis) - x), abs(box%upper(plane%axis) - x)) < tol) then
                  where (minval(fronts(first)%outward, dim=2) > along_axis) low = low + far ! the cracked part needs none
                  where (maxval(fronts(first)%outward, dim=2) < -along_axis) high = high - far
               end if
               if (any((box%lower > max(low, lower) + tol .or. box%upper < min(high, upper) - tol) .and. .not. &
                       (box%upper < lower + tol .or. box%lower > upper - tol))) &
                  why = 'no edge of what &constraint '//to_text(k)//' holds within '//to_text(far)// &
                        ' m, six of the finest cells, of the fronts'
            end do
         end associate
      end do
      associate (x => plane%center(plane%axis))
         first = 0
         do k = 1, size(model%bodies)
            if (x < model%bodies(k)%lower(plane%axis) - tol .or. x > model%bodies(k)%upper(plane%axis) + tol) cycle
            if (first == 0) first = k
            if (model%bodies(k)%material /= model%bodies(first)%material .and. &
                any(model%energy_release%chosen%name == 'domain_integral')) why = 'one material in the plane of the crack'
         end do
      end associate
      if (why /= '') call settings%complain(settings%find('energy_release', 1), 'estimators', 'needs '//why)
   end subroutine check_domain

   !> Whether constraints hold a plane of symmetry at its fronts and half a cell ahead of them.
   pure logical function is_held(model, fronts, axis)
      type(model_t), intent(in) :: model
      type(front_t), intent(in) :: fronts(:)
      integer, intent(in) :: axis
      real(dp) :: x(ndim)
      integer :: k, i, ahead
      is_held = .true.
      do k = 1, size(fronts)
         do i = 1, fronts(k)%n()
            do ahead = 0, 1
               x = fronts(k)%at(:, i) + ahead*model%grid%cell/2*fronts(k)%outward(:, i)
               if (body_at(model, x) > 0) is_held = is_held .and. is_fixed(model, x, axis)
            end do
         end do
      end do
   end function is_held
end module hampm_plane_consistency
