!> Whether cracks can grow as a scene asks for.
module hampm_growth_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_crack_placement, only: least_radius
   use hampm_mistakes, only: mistakes_t
   use hampm_moving_tip, only: rayleigh_speed
   use hampm_path_placement, only: path_tips
   use hampm_placement, only: tolerance
   use hampm_scene, only: scene_t
   use hampm_scene_materials, only: material_of
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_growth

   character(*), parameter :: intro = 'with a &growth'

contains

   !> Check all groups &growth.
   pure subroutine check_growth(scene, settings, has_bodies, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      logical, intent(in) :: has_bodies          !! whether grid and bodies are without mistakes
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k
      if (size(scene%growth) == 0) return
      if (.not. scene%energy_release%domain_integral) call settings%complain(mistakes, settings%find('energy_release', 1), &
         'estimators', 'must name ''domain_integral'' '//intro//', which goes by G, K_I and K_II')
      if (any(scene%growth%is_at_rest())) then
         call check_at_rest(scene, settings, mistakes)
      else
         call check_in_motion(scene, settings, mistakes)
      end if
      do k = 1, size(scene%materials)
         if (scene%materials(k)%law == 'orthotropic') call settings%complain(mistakes, settings%find('material', k), 'law', &
            'must not be ''orthotropic'' '//intro//': where a crack goes and how it speeds up is known of isotropic material only')
      end do
      if (any(scene%paths%friction > 0)) call settings%complain(mistakes, settings%find('crack', scene%paths( &
         findloc(scene%paths%friction > 0, .true., dim=1))%number), 'contact', 'must not be ''friction'' '//intro// &
         ': what has slid is not carried over when cells are cut anew')
      if (scene%crack%kind == 'symmetry') call check_on_plane(scene, settings, mistakes)
      do k = 1, size(scene%growth)
         call check_one(scene, settings, k, has_bodies, mistakes)
      end do
   end subroutine check_growth

   !> Check what growth on a symmetry plane asks of a scene.
   pure subroutine check_on_plane(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      character(*), parameter :: of_crack = intro//' of a &crack of kind = ''symmetry'''
      integer :: release, entry, i, normal
      release = settings%find('energy_release', 1)
      call settings%demand(mistakes, settings%find('method', 1), 'frame', 'total', of_crack)
      if (scene%energy_release%nodal_force .or. scene%energy_release%stress_closure) call settings%complain(mistakes, release, &
         'estimators', 'must be ''domain_integral'' '//intro//', whose tip leaves the nodes, by which ''nodal_force'' and '// &
         '''stress_closure'' close the crack')
      if (scene%energy_release%reference == 'dcb') call settings%complain(mistakes, release, 'reference', &
                                                                    'must not be ''dcb'' '//intro)
      normal = maxloc(merge(0, 1, abs(scene%crack%direction) > 0), dim=1)
      do i = 1, size(scene%constraints)
         entry = settings%find('constraint', i)
         associate (constraint => scene%constraints(i), tol => tolerance(scene%grid))
            if (.not. constraint%fixed(normal)) cycle
            if (max(abs(constraint%lower(normal) - scene%crack%tip(normal)), &
                    abs(constraint%upper(normal) - scene%crack%tip(normal))) > tol) cycle
            if (constraint%motion%push_only) call settings%complain(mistakes, entry, 'push_only', &
               'must be .false. '//of_crack//': ahead of its tip the plane holds the material')
            if (abs(constraint%motion%displacement(normal)) > 0) call settings%complain(mistakes, entry, 'displacement', &
               'must not move the symmetry plane '//of_crack)
            if (abs(constraint%motion%velocity(normal)) > 0) call settings%complain(mistakes, entry, 'velocity', &
               'must not move the symmetry plane '//of_crack)
         end associate
      end do
      do i = 1, size(scene%growth)
         entry = settings%find('growth', i)
         if (settings%good(entry, 'direction') .and. scene%growth(i)%direction /= 'straight') call settings%complain(mistakes, &
            entry, 'direction', 'must be ''straight'' of a &crack of kind = ''symmetry'', which stays on its plane')
         if (settings%text(entry, 'tips') == 'first') call settings%complain(mistakes, entry, 'tips', &
            'must not be ''first'' of a &crack of kind = ''symmetry'': it has one tip, the last point')
      end do
   end subroutine check_on_plane

   !> Check what growth at rest asks of a scene.
   pure subroutine check_at_rest(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: i, entry
      call settings%demand(mistakes, settings%find('method', 1), 'time', 'static', intro//' of law = ''quasi_static''')
      do i = 1, size(scene%growth)
         if (.not. scene%growth(i)%is_at_rest()) call settings%complain(mistakes, settings%find('growth', i), 'law', &
            'must be ''quasi_static'' of each &growth or of none')
      end do
      do i = 1, size(scene%materials)
         entry = settings%find('material', i)
         if (settings%good(entry, 'law') .and. .not. scene%materials(i)%is_linear()) call settings%complain(mistakes, entry, &
            'law', 'must be ''linear_elastic'' '//intro//' of law = ''quasi_static'', under which loads are scaled')
      end do
      do i = 1, size(scene%constraints)
         if (scene%constraints(i)%motion%push_only) call settings%complain(mistakes, settings%find('constraint', i), 'push_only', &
                                                                    'must be .false. '//intro)
      end do
   end subroutine check_at_rest

   !> Check what growth in motion asks of a scene.
   pure subroutine check_in_motion(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      character(*), parameter :: of_law = intro//' of law = ''prescribed'' or ''toughness'''
      integer :: method
      method = settings%find('method', 1)
      call settings%demand(mistakes, method, 'time', 'explicit', of_law)
      call settings%demand(mistakes, method, 'frame', 'total', of_law)
      call settings%demand(mistakes, method, 'time_steps', 'global', of_law)
   end subroutine check_in_motion

   !> Check the keys of law = quasi_static.
   pure subroutine check_keys_at_rest(settings, entry, mistakes)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      type(mistakes_t), intent(inout) :: mistakes
      character(*), parameter :: of_motion(*) = [character(11) :: 'speed', 'start', 'end', 'limit_speed', 'points']
      real(dp), allocatable :: numbers(:)
      integer :: i
      if (.not. settings%number(entry, 'increment') > 0) &
         call settings%complain(mistakes, entry, 'increment', 'must be given of law = ''quasi_static''')
      if (.not. settings%number(entry, 'toughness') > 0) &
         call settings%complain(mistakes, entry, 'toughness', 'must be given of law = ''quasi_static''')
      if (settings%text(entry, 'direction') == 'path') &
         call settings%complain(mistakes, entry, 'direction', 'must not be ''path'' of law = ''quasi_static''')
      if (any(settings%text(entry, 'tips') == [character(5) :: 'last', 'first'])) &
         call settings%complain(mistakes, entry, 'tips', 'must be ''all'' or ''largest'' of law = ''quasi_static''')
      do i = 1, size(of_motion)
         numbers = settings%numbers(entry, trim(of_motion(i)))
         if (any(abs(numbers) > 0)) call settings%complain(mistakes, entry, trim(of_motion(i)), &
                                                           'must be left out of law = ''quasi_static''')
      end do
   end subroutine check_keys_at_rest

   !> Check the keys of the k-th one, in motion.
   pure subroutine check_keys_in_motion(scene, settings, k, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: k
      type(mistakes_t), intent(inout) :: mistakes
      real(dp) :: rayleigh
      integer :: entry, i
      logical :: fits
      entry = settings%find('growth', k)
      associate (growth => scene%growth(k))
         if (growth%increment > 0) call settings%complain(mistakes, entry, 'increment', &
            'must be left out of law = '''//trim(growth%law)//''': tips go on step by step')
         if (growth%only_largest) call settings%complain(mistakes, entry, 'tips', &
            'must be ''all'', ''last'' or ''first'' of law = '''//trim(growth%law)//'''')
         if (growth%end <= growth%start) call settings%complain(mistakes, entry, 'end', 'must be later than start')
         if (growth%law == 'prescribed') then
            if (.not. growth%speed > 0) &
               call settings%complain(mistakes, entry, 'speed', 'must be given of law = ''prescribed''')
            if (growth%toughness > 0) &
               call settings%complain(mistakes, entry, 'toughness', 'must be left out of law = ''prescribed''')
         else
            if (.not. growth%toughness > 0) &
               call settings%complain(mistakes, entry, 'toughness', 'must be given of law = ''toughness''')
            if (growth%speed > 0) call settings%complain(mistakes, entry, 'speed', &
               'must be left out of law = ''toughness'': it follows from that')
         end if
         fits = size(growth%points, 2) > 0 .eqv. growth%direction == 'path'
         if (.not. fits .or. mod(size(settings%numbers(entry, 'points')), ndim) /= 0) call settings%complain(mistakes, entry, &
            'points', 'must be x, y of each point of direction = ''path'', and be left out else')
         do i = 1, size(scene%materials)
            rayleigh = rayleigh_of(scene, i)
            if (growth%law == 'prescribed' .and. growth%speed >= rayleigh) then
               call settings%complain(mistakes, entry, 'speed', 'must be below the speed of Rayleigh waves, '//to_text(rayleigh)// &
                                      ' m/s: the energy release rate of a faster crack is negative')
               exit
            end if
         end do
         do i = 1, k - 1
            associate (other => scene%growth(i))
               if (other%path == growth%path .and. max(other%start, growth%start) < min(other%end, growth%end) .and. &
                   any(other%of_end .and. growth%of_end)) call settings%complain(mistakes, entry, 'start', &
                  'two &growth of one tip must not apply at the same time')
            end associate
         end do
      end associate
   end subroutine check_keys_in_motion

   !> Speed of Rayleigh waves in a material, huge where that is not known [m/s].
   pure real(dp) function rayleigh_of(scene, i) result(speed)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: i
      speed = huge(speed)
      associate (of => scene%materials(i))
         if (of%young > 0 .and. of%density > 0 .and. of%poisson > -1 .and. of%poisson < 0.5_dp) &
            speed = rayleigh_speed(material_of(scene, i))
      end associate
   end function rayleigh_of

   !> Check the k-th one.
   pure subroutine check_one(scene, settings, k, has_bodies, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: k
      logical, intent(in) :: has_bodies
      type(mistakes_t), intent(inout) :: mistakes
      integer :: entry
      entry = settings%find('growth', k)
      associate (growth => scene%growth(k))
         if (scene%crack%kind == 'line') then
            call settings%complain(mistakes, entry, 'crack', 'a &crack of kind = ''line'' does not grow; write it as '// &
                                   'one of kind = ''path'' whose points are on the same grid line')
            return
         else if (scene%crack%kind == 'symmetry' .and. growth%crack /= '') then
            call settings%complain(mistakes, entry, 'crack', 'must be left out of a &crack of kind = ''symmetry'', '// &
                                   'which is the only one')
            return
         else if (size(scene%paths) == 0 .and. .not. scene%crack%present) then
            call settings%complain(mistakes, entry, 'crack', 'needs a &crack of kind = ''path'' or ''symmetry''')
            return
         else if (growth%path == 0 .and. growth%crack == '') then
            call settings%complain(mistakes, entry, 'crack', 'must be the name of one of the cracks, as there are several')
            return
         else if (growth%path == 0) then
            call settings%complain(mistakes, entry, 'crack', 'there is no &crack of this name')
            return
         else if (growth%is_at_rest() .and. any(scene%growth(:k - 1)%path == growth%path)) then
            call settings%complain(mistakes, entry, 'crack', 'must be another crack than that of each other &growth')
         end if
         if (growth%is_at_rest()) then
            call check_keys_at_rest(settings, entry, mistakes)
         else
            call check_keys_in_motion(scene, settings, k, mistakes)
         end if
         if (.not. has_bodies) return
         if (.not. scene%crack%present) then
            if (size(scene%paths(growth%path)%points, 2) < 2) return ! told already
            if (.not. any(path_tips(scene, growth%path))) &
               call settings%complain(mistakes, entry, 'crack', 'this crack has no tip inside the material')
         end if
         if (growth%is_at_rest() .and. growth%increment > 0 .and. &
             growth%increment < least_radius(scene) - tolerance(scene%grid)) &
            call settings%complain(mistakes, entry, 'increment', 'must be at least two of the finest cells, '// &
                                   to_text(least_radius(scene))//' m: between two kinks there is to be a radius of the domain '// &
                                   'integral')
      end associate
      if (size(scene%energy_release%radii) > 0 .and. scene%growth(k)%is_at_rest()) then
         if (scene%growth(k)%increment < maxval(scene%energy_release%radii) .and. scene%growth(k)%direction /= 'straight') &
            call settings%complain(mistakes, entry, 'increment', 'must be at least the largest of &energy_release radii, '// &
                                   to_text(maxval(scene%energy_release%radii))//' m, in which the crack is to be straight')
      end if
   end subroutine check_one
end module hampm_growth_consistency
