!> Whether cracks can grow as a model asks for.
module hampm_growth_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_crack_placement, only: least_radius, is_other_within
   use hampm_moving_tip, only: rayleigh_speed
   use hampm_crack_lines, only: last_point
   use hampm_path_placement, only: path_tips, path_tip, path_radii, held_part
   use hampm_placement, only: tolerance
   use hampm_model, only: model_t
   use hampm_model_materials, only: material_of
   use hampm_settings, only: settings_t
   use hampm_text, only: length_text, to_text
   implicit none
   private
   public :: check_growth, check_nucleations

contains

   !> Check all groups &growth.
   subroutine check_growth(model, settings, has_bodies)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_bodies          !! whether grid and bodies are without errors
      integer :: k
      if (settings%find('cycles', 1) > 0) call check_cycles(model, settings)
      if (model%is_half() .and. size(model%growth) + size(model%cohesive) > 0) call check_on_plane(model, settings)
      do k = 1, size(model%growth)
         call check_one(model, settings, k, has_bodies)
      end do
   end subroutine check_growth

   !> Check that blocks of cycles have as many values each.
   pure subroutine check_cycles(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer :: entry
      entry = settings%find('cycles', 1)
      associate (n => size(model%cycles%number))
         if (size(model%cycles%factor) /= n) call settings%complain(entry, 'factors', &
            'must have one value for each of the '//to_text(n)//' blocks')
         if (size(model%cycles%ratio) /= n) call settings%complain(entry, 'ratios', &
            'must have one value for each of the '//to_text(n)//' blocks')
      end associate
   end subroutine check_cycles

   !> Check the requirements of growth and cohesion on a symmetry plane.
   pure subroutine check_on_plane(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      character(*), parameter :: of_crack = 'where a &crack of kind = ''symmetry'' goes on'
      integer :: entry, i, normal
      normal = maxloc(merge(0, 1, abs(model%paths(1)%direction) > 0), dim=1)
      if (size(model%paths(1)%points, 2) < 2) return ! reported already
      do i = 1, size(model%constraints)
         entry = settings%find('constraint', i)
         associate (constraint => model%constraints(i), tol => tolerance(model%grid), plane => model%paths(1)%points(normal, 2))
            if (.not. constraint%fixed(normal)) cycle
            if (max(abs(constraint%lower(normal) - plane), abs(constraint%upper(normal) - plane)) > tol) cycle
            if (abs(constraint%motion%displacement(normal)) > 0) call settings%complain(entry, 'displacement', &
               'must not move the symmetry plane '//of_crack)
            if (abs(constraint%motion%velocity(normal)) > 0) call settings%complain(entry, 'velocity', &
               'must not move the symmetry plane '//of_crack)
         end associate
      end do
   end subroutine check_on_plane

   !> Check the keys of the k-th one, in motion.
   subroutine check_keys_in_motion(model, settings, k)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: k
      real(dp) :: rayleigh
      integer :: entry, i
      entry = settings%find('growth', k)
      associate (growth => model%growth(k))
         if (growth%end <= growth%start) call settings%complain(entry, 'end', 'must be later than start')
         if (mod(size(settings%numbers(entry, 'points')), ndim) /= 0) call settings%complain(entry, 'points', &
            'must be x, y of each point')
         do i = 1, size(model%materials)
            associate (of => model%materials(i))
               if (.not. growth%law%gives_speed() .or. .not. (of%young > 0 .and. of%density > 0 .and. of%poisson > -1 .and. &
                                                          of%poisson < 0.5_dp)) cycle
            end associate
            rayleigh = rayleigh_speed(material_of(model, i))
            if (growth%speed_at(growth%start) >= rayleigh) then
               call settings%complain(entry, 'speed', 'must be below the speed of Rayleigh waves, '//to_text(rayleigh)// &
                                      ' m/s: the energy release rate of a faster crack is negative')
               exit
            end if
         end do
         do i = 1, k - 1
            associate (other => model%growth(i))
               if (other%path == growth%path .and. max(other%start, growth%start) < min(other%end, growth%end) .and. &
                   any(other%of_end .and. growth%of_end)) call settings%complain(entry, 'start', &
                  'two &growth of one tip must not apply at the same time')
            end associate
         end do
      end associate
   end subroutine check_keys_in_motion

   !> Whether other material is within the radii of a tip of a path.
   pure logical function has_layers(model, path)
      type(model_t), intent(in) :: model
      integer, intent(in) :: path
      logical :: tips(2)
      integer :: end, body
      has_layers = .false.
      tips = path_tips(model, path)
      do end = 1, 2
         if (.not. tips(end)) cycle
         associate (radius => maxval(path_radii(model, path, end)))
            has_layers = has_layers .or. any([(is_other_within(model, body, path_tip(model%paths(path), end), radius), &
                                               body=1, size(model%bodies))])
         end associate
      end do
   end function has_layers

   !> Check a table of factors.
   pure subroutine check_table(settings, entry, key, factors, most)
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      character(*), intent(in) :: key, factors
      real(dp), intent(in) :: most               !! from the first to the last
      real(dp), allocatable :: x(:)
      if (.not. (settings%good(entry, key) .and. settings%good(entry, factors))) return
      allocate (x, source=settings%numbers(entry, key))
      if (size(x) /= size(settings%numbers(entry, factors))) then
         call settings%complain(entry, factors, 'must be as many as there are '//key)
      else if (size(x) == 0) then
         return
      else if (any(x(2:) <= x(:size(x) - 1))) then
         call settings%complain(entry, key, 'must ascend')
      else if (any(x - x(1) >= most)) then
         call settings%complain(entry, key, 'must be of less than '//to_text(most)//' degrees, after which they repeat')
      end if
   end subroutine check_table

   !> Check the k-th one.
   subroutine check_one(model, settings, k, has_bodies)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: k
      logical, intent(in) :: has_bodies
      integer :: entry
      entry = settings%find('growth', k)
      associate (growth => model%growth(k))
         if (.not. settings%good(entry, 'crack') .or. (growth%path == 0 .and. growth%crack == '')) then
            return                               ! a rule reports it
         else if (growth%path == 0) then
            call settings%complain(entry, 'crack', 'there is no &crack of this name')
            return
         else if (growth%law%is_static .and. any(model%growth(:k - 1)%path == growth%path)) then
            call settings%complain(entry, 'crack', 'is the crack of another &growth: choose another crack')
         end if
         if (.not. growth%law%is_static) call check_keys_in_motion(model, settings, k)
         call check_table(settings, entry, 'extensions', 'extension_factors', huge(1.0_dp))
         call check_table(settings, entry, 'speeds', 'speed_factors', huge(1.0_dp))
         call check_table(settings, entry, 'angles', 'angle_factors', 180.0_dp)
         if (growth%law%is_in_time .and. growth%factors%of_speed%is_there()) then
            associate (factor => growth%factors%of_speed%factor)
               if (any(factor(2:) <= factor(:size(factor) - 1))) call settings%complain(entry, 'speed_factors', &
                  'must ascend at rest: a crack whose toughness falls with its speed runs away')
            end associate
         end if
         if (.not. has_bodies .or. ndim > 2) return
         if (size(model%paths(growth%path)%points, 2) < 2) return ! reported already
         if (.not. any(path_tips(model, growth%path))) &
            call settings%complain(entry, 'crack', 'this crack has no tip inside the material')
         if (growth%factors%mixed_mode /= 'none' .and. has_layers(model, growth%path)) &
            call settings%complain(entry, 'mixed_mode', 'must be ''none'' between layers: other material is within the '// &
                                   'radii of a tip, where G has no parts of modes')
         if (growth%law%is_static .and. growth%increment > 0 .and. &
             growth%increment < least_radius(model) - tolerance(model%grid)) &
            call settings%complain(entry, 'increment', 'must be at least two of the finest cells, '// &
                                        to_text(least_radius(model))// &
                                           ' m: a radius of the domain integral must fit between two kinks '// &
                                        'integral')
      end associate
      if (size(model%energy_release%radii) > 0 .and. model%growth(k)%law%is_static) then
         if (model%growth(k)%increment < maxval(model%energy_release%radii) .and. model%growth(k)%direction /= 'straight') &
            call settings%complain(entry, 'increment', 'must be at least the largest of &energy_release radii, '// &
                                   to_text(maxval(model%energy_release%radii))//' m, in which the crack is to be straight')
      end if
   end subroutine check_one

   !> Check all groups &nucleation.
   subroutine check_nucleations(model, settings, has_bodies)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_bodies          !! whether grid and bodies are without errors
      real(dp) :: covered(2)
      integer :: k, entry
      logical :: is_tip(2)
      do k = 1, size(model%nucleations)
         entry = settings%find('nucleation', k)
         associate (path => model%nucleations(k)%path, increment => model%nucleations(k)%increment)
            if (.not. settings%good(entry, 'crack') .or. (path == 0 .and. model%nucleations(k)%crack == '')) cycle ! by a rule
            if (path == 0) then
               call settings%complain(entry, 'crack', 'there is no &crack of this name')
               cycle
            end if
            if (any(model%nucleations(:k - 1)%path == path)) &
               call settings%complain(entry, 'crack', 'is the crack of another &nucleation: choose another crack')
            if (.not. has_bodies .or. size(model%paths(path)%points, 2) < 2) cycle
            covered = held_part(model, path)
            is_tip = path_tips(model, path)
            if (increment > 0 .and. .not. is_tip(last_point)) call settings%complain(entry, 'increment', &
               'is for a crack whose last point is a tip inside the material: the longest that is tried ends there')
            if (increment > (covered(2) - covered(1))*(1 + 1e-3_dp)) call settings%complain(entry, 'increment', &
               'must be at most the length of the crack in the material, '//length_text(covered(2) - covered(1))//' m')
            if (increment > 0 .and. increment < least_radius(model)/2 - tolerance(model%grid)) call settings%complain(entry, &
               'increment', 'must be at least the finest cell, '//to_text(least_radius(model)/2)//' m: cells are cut as a whole')
         end associate
      end do
   end subroutine check_nucleations
end module hampm_growth_consistency
