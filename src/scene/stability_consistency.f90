!> Whether the time step of a scene is stable, as far as its keys tell before it is run.
module hampm_stability_consistency
   use hampm_kinds, only: dp
   use hampm_largest_step, only: courant_limit, default_courant, crosses_cells, chosen_speed, smallest_cell, most_damping_a_step
   use hampm_load_consistency, only: bodies_good
   use hampm_mistakes, only: mistakes_t
   use hampm_placement, only: particle_number, most_particles
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_stability, choose_courant

   !> Stands in for a courant number that cannot be found, in a scene that is refused
   real(dp), parameter :: unknown = 0.1_dp

contains

   !> Find the courant number of a scene that gives none.
   pure subroutine choose_courant(scene, settings)
      type(scene_t), intent(inout) :: scene
      type(settings_t), intent(inout) :: settings
      integer :: entry
      entry = settings%find('method', 1)
      if (.not. settings%good(entry, 'courant') .or. scene%method%courant > 0 &
          .or. scene%method%time /= 'explicit') return
      scene%method%courant = unknown
      if (is_known(scene, settings)) scene%method%courant = default_courant(scene)
      call settings%set_numbers(entry, 'courant', [scene%method%courant])
   end subroutine choose_courant

   !> Refuse time steps that are unstable, by themselves or with the damping.
   pure subroutine check_stability(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      type(scene_t) :: undamped
      real(dp) :: dt, limit
      integer :: entry
      entry = settings%find('method', 1)
      if (.not. (settings%good(entry, 'courant') .and. is_known(scene, settings)) .or. scene%method%time /= 'explicit') return
      undamped = scene
      undamped%damping%rate = 0
      limit = courant_limit(undamped)
      if (scene%method%courant > limit) then
         call complain_of_step(undamped, limit, settings, entry, mistakes)
         return
      else if (.not. scene%damping%rate > 0) then
         return
      end if
      dt = scene%method%courant*smallest_cell(scene)/chosen_speed(scene)
      if (scene%output%history_interval > 0) dt = min(dt, scene%output%history_interval)
      if (scene%damping%rate*dt > most_damping_a_step) then
         call settings%complain(mistakes, settings%find('damping', 1), 'rate', 'must be at most '// &
                                to_text(most_damping_a_step/dt)//' [1/s] with a time step of '//to_text(dt)// &
                                ' s: above it the damping reverses velocities within a step. Reduce it or &method courant')
         return
      end if
      limit = courant_limit(scene)
      if (scene%method%courant > limit) call complain_of_step(scene, limit, settings, entry, mistakes)
   end subroutine check_stability

   !> Complain of a courant number beyond the limit.
   pure subroutine complain_of_step(scene, limit, settings, entry, mistakes)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: limit                !! of the scene [-]
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group &method
      type(mistakes_t), intent(inout) :: mistakes
      character(:), allocatable :: why
      why = ''
      if (any(crosses_cells(scene, scene%bodies))) why = ' for material that moves through the cells'
      if (scene%method%time_steps == 'local') why = why//' with time_steps = ''local'''
      if (scene%damping%rate > 0) why = why//' with this damping'
      call settings%complain(mistakes, entry, 'courant', 'must be at most '//to_text(limit)//', not '// &
                             to_text(scene%method%courant)//', with wave_speed = '''//trim(scene%method%wave_speed)// &
                             ''': above it mass = '''//trim(scene%method%mass)//''' with scheme = '''// &
                             trim(scene%method%scheme)//''' is unstable in plane '//trim(scene%run%plane)//why// &
                             '. 0 takes what is safe')
   end subroutine complain_of_step

   !> Whether all that the limit depends on is known.
   pure logical function is_known(scene, settings) result(known)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      character(*), parameter :: of_method(*) = [character(10) :: 'scheme', 'wave_speed', 'time_steps', 'frame', 'mass', 'order', &
                                                 'blend', 'solver']
      character(*), parameter :: of_material(*) = [character(7) :: 'law', 'young', 'poisson', 'density']
      integer :: i, k
      known = size(scene%bodies) > 0
      known = known .and. settings%good(settings%find('run', 1), 'plane') .and. settings%good(settings%find('run', 1), 'end_time') &
              .and. settings%good(settings%find('grid', 1), 'cell') &
              .and. settings%good(settings%find('grid', 1), 'lower') .and. size(scene%materials) > 0 .and. bodies_good(settings)
      known = known .and. all([(settings%good(settings%find('method', 1), trim(of_method(k))), k=1, size(of_method))])
      do i = 1, size(scene%materials)
         known = known .and. all([(settings%good(settings%find('material', i), trim(of_material(k))), k=1, size(of_material))])
         if (known) known = scene%materials(i)%is_complete(scene%run%plane)
      end do
      if (settings%count_of('damping') > 0) known = known .and. settings%good(settings%find('damping', 1), 'rate')
      if (settings%count_of('refine') > 0) known = known .and. settings%good(settings%find('refine', 1), 'indicator') &
                                                   .and. settings%good(settings%find('refine', 1), 'max_level')
      if (settings%count_of('output') > 0) known = known .and. settings%good(settings%find('output', 1), 'history_interval') &
                                                   .and. settings%good(settings%find('output', 1), 'snapshot_interval')
      do i = 1, size(scene%bodies)
         if (.not. known) return
         associate (body => scene%bodies(i))
            known = settings%good(settings%find('body', i), 'points_per_cell') &
                    .and. settings%good(settings%find('body', i), 'velocity') .and. body%material_index > 0 &
                    .and. all(body%upper > body%lower)
            if (known) known = particle_number(body, scene%grid%cell) <= most_particles
         end associate
      end do
   end function is_known
end module hampm_stability_consistency
