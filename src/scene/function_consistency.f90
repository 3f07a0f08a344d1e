!> Whether the keys of a scene agree with `functions = 'cpdi'`: what domains of particles do not go with is refused.
module hampm_function_consistency
   use hampm_mistakes, only: mistakes_t
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: check_functions

   character(*), parameter :: intro = 'with &method functions = ''cpdi'''

contains

   !> Check a scene whose particles have domains; others have no use for this.
   pure subroutine check_functions(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: method, k
      method = settings%find('method', 1)
      if (.not. settings%good(method, 'functions') .or. .not. scene%method%has_domains()) return
      call settings%demand(mistakes, method, 'frame', 'updated', intro//': in frame = ''total'' particles stay in their cells, '// &
                           'whose own functions are the better ones')
      call settings%demand(mistakes, method, 'time_steps', 'global', intro//': a domain is in several cells, which step together')
      do k = 1, size(scene%materials)
         call settings%demand(mistakes, settings%find('material', k), 'dilatation', 'point', intro//': the corners of a domain '// &
                              'tell one dilatation')
      end do
      if (scene%crack%present .and. scene%crack%kind == 'line') &
         call settings%complain(mistakes, settings%find('crack', 1), 'kind', 'must be ''path'' or ''symmetry'' '//intro// &
                                ': domains at the faces of a line begin on it, and would come across it')
   end subroutine check_functions
end module hampm_function_consistency
