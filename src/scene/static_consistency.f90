!> Whether the keys of a scene agree with `time = 'static'`: what has no meaning without inertia is refused, where it would change
!> what is meant, or noted.
module hampm_static_consistency
   use hampm_mistakes, only: mistakes_t
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: check_static, unused_at_rest

   character(*), parameter :: intro = 'with &method time = ''static'''

contains

   !> Check a static scene; there is nothing to check of others.
   pure subroutine check_static(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: method, entry, k
      if (scene%method%time /= 'static') return
      method = settings%find('method', 1)
      call settings%demand(mistakes, method, 'frame', 'total', intro//': equilibrium is found from where the material was at first')
      call settings%demand(mistakes, method, 'time_steps', 'global', intro//': all cells rest at once')
      do k = 1, size(scene%bodies)
         entry = settings%find('body', k)
         if (settings%good(entry, 'velocity') .and. any(abs(scene%bodies(k)%velocity) > 0)) &
            call settings%complain(mistakes, entry, 'velocity', 'must be 0 '//intro//': what rests has none')
         if (settings%good(entry, 'spin') .and. abs(scene%bodies(k)%spin) > 0) &
            call settings%complain(mistakes, entry, 'spin', 'must be 0 '//intro//': what rests has none')
         if (settings%good(entry, 'points_per_cell') .and. scene%bodies(k)%points_per_cell == 1) &
            call settings%complain(mistakes, entry, 'points_per_cell', 'must be at least 2 '//intro//': one particle in a cell '// &
                                   'does not feel how that is bent, and nothing else holds its nodes')
      end do
   end subroutine check_static

   !> Names of the keys of a static scene that say something else than their defaults and are not used; '' for none.
   pure function unused_at_rest(scene) result(names)
      type(scene_t), intent(in) :: scene
      character(:), allocatable :: names
      names = ''
      if (scene%method%time /= 'static') return
      if (scene%method%courant > 0) names = names//', &method courant'
      if (scene%damping%rate > 0) names = names//', &damping rate'
      if (scene%refine%indicator /= 'none' .and. scene%refine%indicator /= 'tip') names = names//', &refine start and interval'
      if (names /= '') names = names(3:)
   end function unused_at_rest
end module hampm_static_consistency
