!> Checks of the shapes of bodies and holes: all required keys and no others, lines without crossings, holes inside bodies.
module hampm_shape_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_body_shape, only: rings_overlap
   use hampm_placement, only: point_text
   use hampm_polygon, only: area_of, find_crossing
   use hampm_model, only: model_t
   use hampm_settings, only: settings_t
   use hampm_tensors, only: norm
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_shape, check_holes, comes_near_edges

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

   !> Check the line of a polygon. `is_good`: it can be used.
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

end module hampm_shape_consistency
