!> Whether bodies and holes have the shapes that a model gives them: every key that a shape needs and none that it does not, lines without
!> crossings, holes inside bodies.
module hampm_shape_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_outline, only: outline_t, ring_t
   use hampm_placement, only: point_text
   use hampm_polygon, only: area_of, distance_to_segment, do_cross, find_crossing
   use hampm_model, only: model_t
   use hampm_settings, only: settings_t
   use hampm_tensors, only: norm, quarter_turn
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_shape, check_holes, outlines_overlap, comes_near_edges

   integer, parameter :: looks = 720             !! around a circle

contains

   !> Whether a polyline comes nearer than two cells to an edge of a polygon, a circle or a body with holes.
   pure logical function comes_near_edges(model, points) result(near)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, points)
      real(dp), parameter :: step = 0.25_dp      ! cells
      integer :: i, j, k, n
      near = .false.
      do k = 1, size(model%bodies)
         if (.not. model%bodies(k)%outline%is_there()) cycle
         do i = 2, size(points, 2)
            n = ceiling(norm(points(:, i) - points(:, i - 1))/(step*model%grid%cell))
            do j = 0, n
               associate (x => points(:, i - 1) + real(j, dp)/max(n, 1)*(points(:, i) - points(:, i - 1)))
                  near = near .or. model%bodies(k)%outline%distance(x) < 2*model%grid%cell
               end associate
            end do
         end do
      end do
   end function comes_near_edges

   !> Check the line of a polygon. `is_good` tells whether it can be used.
   pure subroutine check_shape(settings, entry, is_good)
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry               !! position of the group
      logical, intent(out) :: is_good
      character(:), allocatable :: shape
      integer :: before
      before = settings%errors%count
      is_good = settings%good(entry, 'shape') .and. settings%good(entry, 'hole')
      if (.not. is_good) return
      shape = settings%text(entry, 'shape')
      if (shape == 'polygon') call check_corners(settings, entry)
      if (shape == 'cylinder') call check_axis(settings, entry)
      is_good = settings%errors%count == before .and. settings%good(entry, 'lower') .and. settings%good(entry, 'upper') .and. &
                settings%good(entry, 'points') .and. settings%good(entry, 'center') .and. settings%good(entry, 'radius')
   end subroutine check_shape

   !> The axis of a cylinder is along a direction of the grid.
   pure subroutine check_axis(settings, entry)
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      if (.not. (settings%good(entry, 'lower') .and. settings%good(entry, 'upper'))) return
      associate (way => settings%numbers(entry, 'upper') - settings%numbers(entry, 'lower'))
         if (count(abs(way) > 0) /= 1 .or. any(way < 0)) &
            call settings%complain(entry, 'upper', 'must be above lower = '//point_text(settings%vector(entry, 'lower'))// &
                                   ' in one direction, and equal it in the others: these are the ends of the axis')
      end associate
   end subroutine check_axis

   !> A polygon has three corners at least, an inside, and sides that do not cross.
   pure subroutine check_corners(settings, entry)
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      real(dp), allocatable :: numbers(:), x(:, :)
      integer :: n, i, j
      if (.not. settings%good(entry, 'points')) return
      numbers = settings%numbers(entry, 'points')
      n = size(numbers)/ndim
      if (mod(size(numbers), ndim) /= 0 .or. n < 3) then
         call settings%complain(entry, 'points', 'must be three corners or more, x1, y1, x2, y2, ..., not '// &
                                to_text(size(numbers))//' values')
         return
      end if
      x = reshape(numbers/max(maxval(abs(numbers)), tiny(1.0_dp)), [ndim, n]) ! squares of areas stay numbers
      do i = 1, n
         associate (a => x(:, i), b => x(:, mod(i, n) + 1))
            if (norm(b - a) <= 1e-12_dp*maxval(maxval(x, 2) - minval(x, 2))) then
               call settings%complain(entry, 'points', 'corners '//to_text(i)//' and '//to_text(mod(i, n) + 1)// &
                                      ' are at one place, '//point_text(numbers(ndim*(i - 1) + 1:ndim*i)))
               return
            end if
         end associate
      end do
      call find_crossing(x, .true., i, j)
      if (i > 0) then
         call settings%complain(entry, 'points', 'sides '//to_text(i)//' and '//to_text(j)//' of the polygon cross or touch; '// &
                                'side 1 is from corner 1 to corner 2')
         return
      end if
      if (2*abs(area_of(x)) <= 1e-12_dp*product(maxval(x, 2) - minval(x, 2))) &
         call settings%complain(entry, 'points', 'the corners are on one line')
   end subroutine check_corners

   !> Holes come after all bodies, are inside one of them, and apart from each other.
   pure subroutine check_holes(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical :: is_good
      integer :: k, j, entry
      if (size(model%bodies) == 0 .and. size(model%holes) > 0) then
         call settings%complain(settings%find('body', 1), 'hole', 'there must be a &body of material, too')
         return
      end if
      do k = 1, size(model%holes)
         entry = settings%find('body', model%holes(k)%number)
         call check_shape(settings, entry, is_good)
         if (model%holes(k)%number <= size(model%bodies)) then
            call settings%complain(entry, 'hole', 'holes must come after all groups &body that are none')
            cycle
         end if
         if (.not. is_good) cycle
         if (model%holes(k)%body == 0 .and. ndim > 2) then
            call settings%complain(entry, 'hole', 'must be inside one body, but where it leaves the box around that')
            cycle
         else if (model%holes(k)%body == 0) then
            call settings%complain(entry, 'hole', 'must be inside one body, without touching its edge: a notch is a '// &
                                   'part of the outline, a body of shape = ''polygon''')
            cycle
         end if
         do j = 1, k - 1
            if (model%holes(j)%body /= model%holes(k)%body) cycle
            if (rings_overlap(model%holes(j)%ring, model%holes(k)%ring, 0.0_dp)) &
               call settings%complain(entry, 'hole', 'must be apart from the hole of &body '// &
                                      to_text(model%holes(j)%number))
         end do
      end do
   end subroutine check_holes

   !> Whether two bodies have more in common than an edge. Holes are looked at where a body is in that of another one.
   pure logical function outlines_overlap(a, b, tolerance)
      type(outline_t), intent(in) :: a, b        !! that are there
      real(dp), intent(in) :: tolerance          !! distance below which places are the same [m]
      integer :: k
      outlines_overlap = rings_overlap(a%rings(1), b%rings(1), tolerance)
      if (.not. outlines_overlap) return
      do k = 2, size(a%rings)
         if (is_inside(b%rings(1), a%rings(k), tolerance)) outlines_overlap = .false.
      end do
      do k = 2, size(b%rings)
         if (is_inside(a%rings(1), b%rings(k), tolerance)) outlines_overlap = .false.
      end do
   end function outlines_overlap

   !> Whether all of a ring is inside another one, or on it.
   pure logical function is_inside(inner, outer, tolerance)
      type(ring_t), intent(in) :: inner, outer
      real(dp), intent(in) :: tolerance
      real(dp), allocatable :: x(:, :)
      integer :: k
      allocate (x, source=inner%corners(looks))
      is_inside = all([(outer%encloses(x(:, k)) .or. outer%distance(x(:, k)) <= tolerance, k=1, size(x, 2))])
   end function is_inside

   !> Whether the insides of two rings have a point in common: sides cross, or a corner, a middle of a side or the middle of the inside of
   !> one is in the other.
   pure logical function rings_overlap(a, b, tolerance) result(overlap)
      type(ring_t), intent(in) :: a, b
      real(dp), intent(in) :: tolerance          !! [m]
      real(dp), allocatable :: x(:, :), y(:, :)
      integer :: i, j
      overlap = .false.
      if (any(a%upper() <= b%lower() + tolerance .or. b%upper() <= a%lower() + tolerance)) return
      x = a%corners(looks)
      y = b%corners(looks)
      overlap = has_point_of(a, y) .or. has_point_of(b, x)
      if (ndim > 2) overlap = overlap .or. .not. (a%is_circle .or. b%is_circle) ! boxes
      if (overlap .or. ndim > 2) return
      do i = 1, size(x, 2)
         do j = 1, size(y, 2)
            associate (p => x(:, i), q => x(:, mod(i, size(x, 2)) + 1), r => y(:, j), s => y(:, mod(j, size(y, 2)) + 1))
               if (.not. do_cross(p, q, r, s)) cycle
               if (min(distance_to_segment(p, r, s), distance_to_segment(q, r, s), &
                       distance_to_segment(r, p, q), distance_to_segment(s, p, q)) <= tolerance) cycle
               overlap = .true.
               return
            end associate
         end do
      end do
   contains
      !> Whether a corner or a middle of a side, or a point of the inside, of a polygon is inside a ring.
      pure logical function has_point_of(ring, corner)
         type(ring_t), intent(in) :: ring
         real(dp), intent(in) :: corner(:, :)
         real(dp) :: at(ndim), inward(ndim)
         integer :: k
         has_point_of = .false.
         do k = 1, size(corner, 2)
            associate (from => corner(:, k), to => corner(:, mod(k, size(corner, 2)) + 1))
               inward = 0
               if (ndim == 2) inward = quarter_turn(to - from)/norm(to - from)
               at = (from + to)/2 + 4*tolerance*inward
               has_point_of = has_point_of .or. (ring%encloses(from) .and. ring%distance(from) > 4*tolerance) .or. &
                              (ring%encloses(at) .and. ring%distance(at) > 2*tolerance)
            end associate
         end do
      end function has_point_of
   end function rings_overlap
end module hampm_shape_consistency
