!> Whether the time step of a scene is stable, as far as its keys tell before it is run.
module hampm_stability_consistency
   use hampm_kinds, only: dp
   use hampm_history_resolution, only: check_resolution
   use hampm_largest_step, only: courant_limit, default_courant, crosses_cells, chosen_speed, smallest_cell, &
                                 most_damping_a_step, time_between_outputs
   use hampm_load_consistency, only: bodies_good
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
   subroutine choose_courant(scene, settings)
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

   !> Refuse time steps that are unstable, by themselves or with the damping, and those that do not resolve a load.
   subroutine check_stability(scene, settings)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(inout) :: settings
      type(scene_t) :: undamped
      real(dp) :: dt, limit
      integer :: entry
      entry = settings%find('method', 1)
      if (.not. (settings%good(entry, 'courant') .and. is_known(scene, settings))) return
      call check_resolution(scene, settings)
      if (scene%method%time /= 'explicit') return
      if (scene%method%time_steps == 'local' .and. .not. time_between_outputs(scene) > 0) &
         call settings%complain(entry, 'time_steps', 'requires an &output history_interval and snapshot_interval '// &
                                'that are multiples of one time, not less than a thousandth of the shorter: steps whose length '// &
                                'changes are unstable. Use others, or time_steps = ''global''')
      undamped = scene
      undamped%damping%rate = 0
      limit = courant_limit(undamped)
      if (scene%method%courant > limit) then
         call complain_of_step(undamped, limit, settings, entry)
         return
      else if (.not. scene%damping%rate > 0) then
         return
      end if
      dt = scene%method%courant*smallest_cell(scene)/chosen_speed(scene)
      if (scene%output%history_interval > 0) dt = min(dt, scene%output%history_interval)
      if (scene%damping%rate*dt > most_damping_a_step) then
         call settings%complain(settings%find('damping', 1), 'rate', 'must be at most '// &
                                to_text(most_damping_a_step/dt)//' [1/s] with a time step of '//to_text(dt)// &
                                ' s: above it the damping reverses velocities within a step. Reduce it or &method courant')
         return
      end if
      limit = courant_limit(scene)
      if (scene%method%courant > limit) call complain_of_step(scene, limit, settings, entry)
   end subroutine check_stability

   !> Complain of a courant number beyond the limit.
   subroutine complain_of_step(scene, limit, settings, entry)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: limit                !! of the scene [-]
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry                 !! position of the group &method
      character(:), allocatable :: why, of_plane
      of_plane = 'in plane '//trim(scene%run%plane)
      if (scene%run%thickness%is_ring) of_plane = 'around the axis'
      why = ''
      if (any(crosses_cells(scene, scene%bodies))) why = ' for material that moves through the cells'
      if (scene%method%time_steps == 'local') why = why//' with time_steps = ''local'''
      if (scene%damping%rate > 0) why = why//' with this damping'
      call settings%complain(entry, 'courant', 'must be at most '//to_text(limit)//', not '// &
                             to_text(scene%method%courant)//', with wave_speed = '''//trim(scene%method%wave_speed)// &
                             ''': above it mass = '''//trim(scene%method%mass)//''' with scheme = '''// &
                             trim(scene%method%scheme)//''' is unstable '//of_plane//why// &
                             '. 0 takes what is safe')
   end subroutine complain_of_step

   !> Whether all that the limit depends on is known.
   pure logical function is_known(scene, settings) result(known)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer :: i
      known = settings%all_good() .and. settings%count_of('run') > 0 .and. settings%count_of('grid') > 0 &
              .and. size(scene%bodies) > 0 .and. size(scene%materials) > 0
      if (known) known = bodies_good(settings)
      if (known) known = all([(scene%materials(i)%is_complete(scene%run%plane), i=1, size(scene%materials))])
      do i = 1, size(scene%bodies)
         if (.not. known) return
         associate (body => scene%bodies(i))
            known = body%material_index > 0 .and. all(body%upper > body%lower)
            if (known) known = particle_number(scene, body) <= most_particles
         end associate
      end do
   end function is_known
end module hampm_stability_consistency
