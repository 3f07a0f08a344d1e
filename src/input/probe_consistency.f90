!> Whether the objects of probes exist: material at their places, a crack with a tip, a load or a constraint.
module hampm_probe_consistency
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_tensors, only: norm
   use hampm_crack_lines, only: length_of
   use hampm_crack_placement, only: body_at, path_at
   use hampm_load_consistency, only: check_name
   use hampm_model, only: model_t, probe_t, path_of
   use hampm_path_placement, only: path_tips
   use hampm_placement, only: point_text, tolerance
   use hampm_settings, only: settings_t
   use hampm_text, only: did_you_mean, length_text, to_text
   implicit none
   private
   public :: check_probes

contains

   !> Check all groups &probe.
   subroutine check_probes(model, settings, has_geometry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_geometry        !! whether grid, bodies and cracks are without errors
      integer :: k, i, entry
      do k = 1, size(model%probes)
         entry = settings%find('probe', k)
         associate (probe => model%probes(k))
            if (settings%good(entry, 'name')) call check_name(model%probes(:k)%name, 'probe', entry, settings)
            do i = 2, size(probe%quantity)
               if (probe%quantity(i) /= '' .and. any(probe%quantity(:i - 1) == probe%quantity(i))) &
                  call settings%complain(entry, 'quantity', 'has '''//trim(probe%quantity(i))//''' twice')
            end do
            if (settings%good(entry, 'at')) then
               if (mod(size(settings%numbers(entry, 'at')), ndim) /= 0) then
                  call settings%complain(entry, 'at', 'must have '//to_text(ndim)//' values, a point, or '// &
                                         to_text(2*ndim)//', the ends of a line')
               else if (has_geometry .and. size(probe%at, 2) > 0 .and. settings%good(entry, 'face')) then
                  call check_place(model, probe, entry, settings)
               end if
            end if
            if (.not. (settings%good(entry, 'quantity') .and. settings%good(entry, 'of'))) cycle
            if (probe%gives('load_line')) then
               call check_load(model, probe, entry, settings)
            else if (has_geometry .and. (probe%gives('opening') .or. probe%gives('volume'))) then
               call check_crack(model, probe, entry, settings)
            end if
         end associate
      end do
   end subroutine check_probes

   !> There is material at its place, and the side of a crack is known: at both ends of a line of strain, and along the whole of a
   !> line of means.
   subroutine check_place(model, probe, entry, settings)
      type(model_t), intent(in) :: model
      type(probe_t), intent(in) :: probe
      integer, intent(in) :: entry               !! position of the group
      type(settings_t), intent(inout) :: settings
      integer, parameter :: looks_in_cell = 8
      real(dp) :: x(ndim), length
      logical :: is_on_crack
      integer :: i, n
      is_on_crack = .false.
      do i = 1, size(probe%at, 2)
         x = probe%at(:, i)
         if (body_at(model, x) == 0) then
            call settings%complain(entry, 'at', 'must be in or on a body, and '//point_text(x)//' is outside of all, or in a hole')
            return
         end if
         if (.not. model%is_half()) is_on_crack = is_on_crack .or. all(path_at(model, x, x) > 0)
      end do
      if (size(probe%at, 2) == 1) then
         if (is_on_crack .and. probe%face == 'none') then
            call settings%complain(entry, 'face', 'must be ''left'' or ''right'': the point is on a crack, which has two faces')
         else if (probe%face /= 'none' .and. .not. is_on_crack) then
            call settings%complain(entry, 'face', 'must be ''none'' but for a point on a crack with two faces')
         end if
         return
      end if
      length = norm(probe%at(:, 2) - probe%at(:, 1))
      if (length <= tolerance(model%grid)) then
         call settings%complain(entry, 'at', 'the ends of the line must differ')
      else if (probe%face /= 'none') then
         call settings%complain(entry, 'face', 'must be ''none'' for a line')
      else if (is_on_crack) then
         call settings%complain(entry, 'at', 'an end of the line is on a crack, which has two faces: move it to one of them')
      else if (any(probe%quantity /= 'strain' .and. probe%quantity /= '')) then
         n = looks_in_cell*ceiling(length/model%grid%cell)
         do i = 1, n - 1
            x = probe%at(:, 1) + real(i, dp)/n*(probe%at(:, 2) - probe%at(:, 1))
            if (body_at(model, x) > 0) cycle
            call settings%complain(entry, 'at', 'the line leaves the material at '//point_text(x)//': only the quantity '// &
                                   '''strain'' needs none between its ends')
            return
         end do
      end if
   end subroutine check_place

   !> There is a crack of this name, with a tip where one is asked for, and a face that far behind it.
   pure subroutine check_crack(model, probe, entry, settings)
      type(model_t), intent(in) :: model
      type(probe_t), intent(in) :: probe
      integer, intent(in) :: entry               !! position of the group
      type(settings_t), intent(inout) :: settings
      integer :: path
      logical :: is_tip(2)
      path = path_of(model, probe%of(1))
      if (size(model%paths) == 0 .or. (probe%of(1) == '' .and. path == 0)) return ! a rule reports it
      if (path == 0) then
         call settings%complain(entry, 'of', 'there is no &crack of this name'//did_you_mean(trim(probe%of(1)), model%paths%name))
         return
      end if
      if (probe%of(2) /= '') call settings%complain(entry, 'of', 'must be one crack')
      if (.not. probe%gives('opening')) return
      is_tip = [.false., .true.]
      if (.not. model%paths(path)%is_symmetry) is_tip = path_tips(model, path)
      if (.not. is_tip(merge(1, 2, probe%tip == 'first'))) then
         call settings%complain(entry, 'tip', 'the crack has no tip at its '//trim(probe%tip)//' point')
      else if (probe%distance >= length_of(model%paths(path)%points)) then
         call settings%complain(entry, 'distance', 'must be less than the length of the crack, '// &
                                length_text(length_of(model%paths(path)%points))//' m')
      end if
   end subroutine check_crack

   !> There are loads with a resultant, or constraints, of these names, each one only.
   pure subroutine check_load(model, probe, entry, settings)
      type(model_t), intent(in) :: model
      type(probe_t), intent(in) :: probe
      integer, intent(in) :: entry               !! position of the group
      type(settings_t), intent(inout) :: settings
      integer :: i, load, constraint
      do i = 1, size(probe%of)
         if (probe%of(i) == '') cycle
         load = findloc(model%loads%name, probe%of(i), dim=1)
         constraint = findloc(model%constraints%name, probe%of(i), dim=1)
         if (load == 0 .and. constraint == 0) then
            call settings%complain(entry, 'of', 'there is no &load or &constraint with the name '''//trim(probe%of(i))//''''// &
                                   did_you_mean(trim(probe%of(i)), [character(name_len) :: model%loads%name, &
                                                                    model%constraints%name]))
         else if (load > 0 .and. constraint > 0) then
            call settings%complain(entry, 'of', 'a &load and a &constraint have the name '''//trim(probe%of(i))//'''')
         else if (load > 0) then
            if (any(model%loads(load)%kind == ['pressure', 'gravity '])) &
               call settings%complain(entry, 'of', 'must be a load of kind = ''point'', ''traction'' or ''body'': a '// &
                                      trim(model%loads(load)%kind)//' does no work on a mean displacement')
         end if
      end do
   end subroutine check_load
end module hampm_probe_consistency
