!> Stability of the time step of a model, as far as its keys determine it before a run.
module hampm_stability_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_history_resolution, only: check_resolution
   use hampm_largest_step, only: courant_limit, default_courant, crosses_cells, chosen_speed, smallest_cell, &
                                 most_damping_a_step
   use hampm_load_consistency, only: bodies_good
   use hampm_placement, only: particle_number, most_particles
   use hampm_model, only: model_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_stability, choose_courant

   !> Replaces a courant number that cannot be found, in a refused model
   real(dp), parameter :: unknown = 0.1_dp

contains

   !> Find the largest courant number of a model, and the default if it gives none.
   subroutine choose_courant(model, settings)
      type(model_t), intent(inout) :: model
      type(settings_t), intent(inout) :: settings
      integer :: entry
      entry = settings%find('method', 1)
      if (.not. settings%good(entry, 'courant') .or. model%method%time /= 'explicit') return
      if (is_known(model, settings)) model%method%courant_limit = courant_limit(model)
      if (model%method%courant > 0) return
      model%method%courant = unknown
      if (model%method%courant_limit > 0) model%method%courant = default_courant(model)
      call settings%set_numbers(entry, 'courant', [model%method%courant])
   end subroutine choose_courant

   !> Refuse unstable time steps, by themselves or with the damping, and steps that do not resolve a load.
   subroutine check_stability(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      type(model_t) :: undamped
      real(dp) :: dt, limit, undamped_limit
      integer :: entry
      entry = settings%find('method', 1)
      if (.not. (settings%good(entry, 'courant') .and. is_known(model, settings))) return
      call check_resolution(model, settings)
      if (model%method%time /= 'explicit') return
      limit = model%method%courant_limit
      if (.not. limit > 0) limit = courant_limit(model)
      if (model%method%courant > limit) then
         undamped = model
         undamped%damping%rate = 0
         undamped_limit = courant_limit(undamped)
         if (model%method%courant > undamped_limit) then
            call complain_of_step(undamped, undamped_limit, settings, entry)
            return
         end if
      end if
      if (.not. model%damping%rate > 0) return
      dt = model%method%courant*smallest_cell(model)/chosen_speed(model)
      if (model%output%history_interval > 0) dt = min(dt, model%output%history_interval)
      if (model%damping%rate*dt > most_damping_a_step) then
         call settings%complain(settings%find('damping', 1), 'rate', 'must be at most '// &
                                to_text(most_damping_a_step/dt)//' [1/s] with a time step of '//to_text(dt)// &
                                ' s: above it the damping reverses velocities within a step. Reduce it or &method courant')
         return
      end if
      if (model%method%courant > limit) call complain_of_step(model, limit, settings, entry)
   end subroutine check_stability

   !> Complain of a courant number beyond the limit.
   subroutine complain_of_step(model, limit, settings, entry)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: limit                !! of the model [-]
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry                 !! position of the group &method
      character(:), allocatable :: why, of_plane
      of_plane = 'in plane '//trim(model%run%plane)
      if (model%run%thickness%is_ring) of_plane = 'around the axis'
      if (ndim > 2) of_plane = 'in a solid'
      why = ''
      if (any(crosses_cells(model, model%bodies))) why = ' for material that moves through the cells'
      if (model%damping%rate > 0) why = why//' with this damping'
      call settings%complain(entry, 'courant', 'must be at most '//to_text(limit)//', not '// &
                             to_text(model%method%courant)//', with wave_speed = '''//trim(model%method%wave_speed)// &
                             ''': above it mass = '''//trim(model%method%mass)//''' with scheme = '''// &
                             trim(model%method%scheme)//''' is unstable '//of_plane//why// &
                             '. 0 takes what is safe')
   end subroutine complain_of_step

   !> Whether all that the limit depends on is known.
   pure logical function is_known(model, settings) result(known)
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      integer :: i
      known = settings%all_good() .and. settings%count_of('run') > 0 .and. settings%count_of('grid') > 0 &
              .and. size(model%bodies) > 0 .and. size(model%materials) > 0
      if (known) known = bodies_good(settings)
      if (known) known = all([(model%materials(i)%is_complete(model%run%plane), i=1, size(model%materials))])
      do i = 1, size(model%bodies)
         if (.not. known) return
         associate (body => model%bodies(i))
            known = body%material_index > 0 .and. all(body%upper > body%lower)
            if (known) known = particle_number(model, body) <= most_particles
         end associate
      end do
   end function is_known
end module hampm_stability_consistency
