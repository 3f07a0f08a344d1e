!> Checks whether cracks can be cut: each alone, against each other, and against features that exclude them.
module hampm_path_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_crack_lines, only: first_point, last_point
   use hampm_tensors, only: norm
   use hampm_crack_placement, only: least_radius, is_other_within, distance_to_others, is_layer, sides_of_tip
   use hampm_path_placement, only: path_tips, path_tip, path_direction, path_radius, path_radii, clear_radius, distance_to_cracks, &
                                   length_along, is_inside
   use hampm_placement, only: tolerance, upper_corner, point_text
   use hampm_plane_consistency, only: check_shape
   use hampm_polygon, only: find_crossing
   use hampm_model, only: model_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text, length_text
   implicit none
   private
   public :: check_paths, check_path_radii

   real(dp), parameter :: beside = 0.1_dp        !! root cells between paths that run along each other, at least
   real(dp), parameter :: least_way = 1          !! root cells from one point of a path to the next, and from a tip to other objects

contains

   !> Check all paths.
   pure subroutine check_paths(model, settings, has_bodies)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_bodies          !! whether grid and bodies are without errors
      integer :: k, before
      do k = 1, size(model%paths)
         if (.not. settings%good(settings%find('crack', k), 'kind') .or. model%paths(k)%is_symmetry) cycle
         before = settings%errors%count
         call check_points(model, settings, k, has_bodies)
         if (settings%errors%count == before .and. has_bodies) call check_place(model, settings, k)
      end do
   end subroutine check_paths

   !> The points of the k-th path: enough of them, and not too close.
   pure subroutine check_points(model, settings, k, has_bodies)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: k
      logical, intent(in) :: has_bodies          !! whether grid and bodies are without errors
      logical :: is_tip(2)
      real(dp) :: near
      integer :: entry, i, j
      entry = settings%find('crack', k)
      if (.not. settings%good(entry, trim(model%paths(k)%key))) return
      if (model%paths(k)%kind == 'plane') then
         call check_shape(model, model%paths(k), settings, entry)
      else if (model%paths(k)%key == 'tip' .and. .not. norm(model%paths(k)%direction) > 0) then
         call settings%complain(entry, 'direction', 'must not be 0, 0')
      end if
      if (model%paths(k)%key /= 'points' .and. size(model%paths(k)%points, 2) < 2) return ! reported, or elsewhere
      associate (points => model%paths(k)%points, numbers => settings%numbers(entry, trim(model%paths(k)%key)))
         if (mod(size(numbers), ndim) /= 0) then
            call settings%complain(entry, 'points', 'must be pairs x, y: it has '//to_text(size(numbers))//' values')
            return
         else if (size(points, 2) < 2) then
            call settings%complain(entry, 'points', 'must have two points at least, x1, y1, x2, y2, for kind = ''path''')
            return
         end if
         is_tip = .false.
         if (has_bodies) is_tip = path_tips(model, k)
         do i = 2, size(points, 2)
            near = least_way*cell_at(model, k)
            if (is_tip(first_point) .and. i == 2 .or. is_tip(last_point) .and. i == size(points, 2)) &
               near = least_way*cell_at(model, k, is_at_tip=.true.)
            if (norm(points(:, i) - points(:, i - 1)) >= near - tolerance(model%grid)) cycle
            call settings%complain(entry, trim(model%paths(k)%key), 'points '//to_text(i - 1)//' and '//to_text(i)//' are '// &
                                   length_text(norm(points(:, i) - points(:, i - 1)))//' m apart, less than a cell, '// &
                                   to_text(near)//' m: the cells cannot follow. Use fewer points or smaller cells')
            return
         end do
         call find_crossing(points, .false., i, j)
         if (i > 0) then
            call settings%complain(entry, trim(model%paths(k)%key), 'the path crosses itself: from point '//to_text(i)// &
                                   ' to '//to_text(i + 1)//' and from '//to_text(j)//' to '//to_text(j + 1)// &
                                   '; make two cracks of it')
            return
         end if
      end associate
      do i = 1, k - 1
         if (model%paths(k)%name == '' .or. model%paths(i)%name /= model%paths(k)%name) cycle
         call settings%complain(entry, 'name', 'must differ from the name of every other crack')
      end do
   end subroutine check_points

   !> The k-th path is in the material, its tips far enough from all else.
   pure subroutine check_place(model, settings, k)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: k
      logical :: is_tip(2)
      integer :: entry, end, i
      real(dp) :: near
      entry = settings%find('crack', k)
      associate (path => model%paths(k))
         is_tip = path_tips(model, k)
         if (path%key == 'tip' .and. .not. is_tip(last_point)) then
            call settings%complain(entry, 'tip', 'must be inside the material, and on no other crack')
            return
         end if
         if (.not. enters(model, path%points)) then
            call settings%complain(entry, trim(model%paths(k)%key), 'the crack is outside of the material')
            return
         end if
         if (any([(any(path%points(:, i) < 2*model%grid%lower - upper_corner(model%grid) .or. &
                       path%points(:, i) > 2*upper_corner(model%grid) - model%grid%lower), i=1, size(path%points, 2))])) then
            call settings%complain(entry, trim(model%paths(k)%key), 'a point is further outside of the grid '// &
                                   'than that is wide, up to '// &
                                   point_text(upper_corner(model%grid))//'; lengths are in m')
            return
         end if
         near = least_way*model%grid%cell
         do i = 1, k - 1
            if (length_along(model, k, i, beside*model%grid%cell) <= near) cycle
            call settings%complain(entry, trim(model%paths(k)%key), 'the path runs along another one, that of &crack '// &
                                   to_text(i)//', for more than a cell, '//to_text(model%grid%cell)// &
                                   ' m, at less than a tenth of a cell: the material between them would not be modelled')
            return
         end do
         do end = first_point, last_point
            if (.not. is_tip(end)) cycle
            associate (tip => path_tip(path, end))
               near = least_way*cell_at(model, k, is_at_tip=.true.)
               if (clear_radius(model, k, end) >= near - tolerance(model%grid)) cycle
               if (distance_to_cracks(model, tip, k) < near) then
                  call settings%complain(entry, trim(model%paths(k)%key), 'the tip '//point_text(tip)//' is '// &
                                         length_text(distance_to_cracks(model, tip, k))//' m from another crack, less than a '// &
                                         'cell, '//to_text(near)//' m: let it end on that crack, or use smaller cells')
               else
                  call settings%complain(entry, trim(model%paths(k)%key), 'the tip '//point_text(tip)//' is less than a cell, '// &
                                         to_text(near)//' m, from a surface or another part '// &
                                         'of its crack: let it end beyond the surface, move it, or use smaller cells')
               end if
            end associate
         end do
      end associate
   end subroutine check_place

   !> Size of the cells along the k-th path, or at its tips [m]: these, and those along a nucleating crack, are refined from the
   !> start if refinement is by places.
   pure real(dp) function cell_at(model, k, is_at_tip) result(cell)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k
      logical, intent(in), optional :: is_at_tip
      cell = model%grid%cell
      if (.not. model%refine%by%is_of_places) return
      if (present(is_at_tip) .or. any(model%nucleations%path == k)) cell = least_radius(model)/2
   end function cell_at

   !> Whether a polyline runs through material.
   pure logical function enters(model, points)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, points)
      integer, parameter :: looks = 64           ! at each segment
      integer :: i, j
      enters = .false.
      do i = 2, size(points, 2)
         do j = 0, looks
            enters = enters .or. is_inside(model, points(:, i - 1) + real(j, dp)/looks*(points(:, i) - points(:, i - 1)))
            if (enters) return
         end do
      end do
   end function enters

   !> The domains of the integral around all tips.
   pure subroutine check_path_radii(model, settings, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry               !! position of the group &energy_release
      character(:), allocatable :: why
      real(dp) :: most, room
      logical :: is_tip(2), is_at_interface
      integer :: k, end, i
      is_at_interface = .false.
      do k = 1, size(model%paths)
         is_tip = path_tips(model, k)
         do end = last_point, first_point, -1
            if (.not. is_tip(end)) cycle
            most = path_radius(model, k, end)
            room = distance_to_others(model, path_tip(model%paths(k), end), path_direction(model%paths(k), end))
            associate (tip => path_tip(model%paths(k), end), radii => path_radii(model, k, end), least => least_radius(model))
               why = ''
               if (most < least - tolerance(model%grid)) then
                  why = 'there is no place for a radius around the tip '// &
                        point_text(tip)//': only material and the straight end of this crack are within '//length_text(most)// &
                        ' m of it, and two of the finest cells, '//to_text(least)//' m, are the least; use smaller cells'
               else if (any(radii(2:) <= radii(:size(radii) - 1))) then
                  why = 'must increase from one to the next'
               else if (room >= least .and. &
                        any(radii < least - tolerance(model%grid) .or. radii > most + tolerance(model%grid))) then
                  why = 'must be in ['//to_text(least)//', '//length_text(most)// &
                        '] [m] around the tip '//point_text(tip)//': two of the finest cells at least, and nothing within them '// &
                        'but material and the straight end of this crack: no load but on its faces, and no constraint'
               end if
               do i = 1, size(model%bodies)
                  if (why /= '' .or. .not. is_other_within(model, i, tip, max(least, maxval(radii)))) cycle
                  if (is_layer(model, i, tip, path_direction(model%paths(k), end), max(least, maxval(radii)))) cycle
                  why = 'there must be one material within them, or layers along the crack, around the tip '//point_text(tip)// &
                        '; body '//to_text(i)//' is of another one, or has another eigenstrain. The largest that fits is '// &
                        length_text(min(most, room))//' m'
                  if (room < least) why = why//', less than two of the finest cells, '//to_text(least)//' m: use smaller cells'
               end do
               if (why /= '') call settings%complain(entry, 'radii', why)
               if (why /= '') return
               is_at_interface = is_at_interface .or. &
                                 all(sides_of_tip(model, tip, path_direction(model%paths(k), end), maxval(radii)) > 0)
            end associate
         end do
      end do
      if (model%energy_release%phase_length > 0 .and. .not. is_at_interface) &
         call settings%complain(entry, 'phase_length', 'there is no tip at the interface of two bodies of different materials '// &
                                'which have the radii for themselves')
   end subroutine check_path_radii
end module hampm_path_consistency
