!> Whether the keys of a scene agree with `time = 'implicit'`: what implicit steps cannot follow is refused.
module hampm_implicit_consistency
   use hampm_mistakes, only: mistakes_t
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: check_implicit

   character(*), parameter :: intro = 'with &method time = ''implicit'''

contains

   !> Check an implicit scene; others have no use for its keys.
   pure subroutine check_implicit(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: method
      method = settings%find('method', 1)
      if (.not. settings%good(method, 'time')) return
      if (scene%method%time /= 'implicit') return
      call check_method(scene, settings, method, mistakes)
      call check_rest(scene, settings, mistakes)
   end subroutine check_implicit

   !> Check how the equations of motion are integrated.
   pure subroutine check_method(scene, settings, entry, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group &method
      type(mistakes_t), intent(inout) :: mistakes
      associate (method => scene%method)
         call settings%demand(mistakes, entry, 'frame', 'total', intro//': the nodes keep their motion from step to step, and '// &
                              'so their material')
         call settings%demand(mistakes, entry, 'time_steps', 'global', intro//': all nodes are solved for at once')
         if (settings%good(entry, 'mass') .and. method%mass == 'fmpm') &
            call settings%complain(mistakes, entry, 'mass', 'must not be ''fmpm'' '//intro//': a series for the inverse, '// &
                                   'and these steps use the matrix. Use ''full'', which it comes to')
         if (settings%good(entry, 'time_step') .and. settings%good(entry, 'courant') .and. method%time_step > 0 &
             .and. method%courant > 0) call settings%complain(mistakes, entry, 'time_step', 'must be 0 where courant is given '// &
             intro//': give one of both')
      end associate
   end subroutine check_method

   !> Check the laws, the crack, and the cells.
   pure subroutine check_rest(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k
      do k = 1, size(scene%materials)
         if (scene%materials(k)%law == 'orthotropic') cycle
         call settings%demand(mistakes, settings%find('material', k), 'law', 'linear_elastic', intro//': its steps solve '// &
                              'linear equations. time = ''explicit'' follows other laws')
      end do
      if (scene%crack%contact) call settings%complain(mistakes, settings%find('crack', 1), 'contact', 'must be ''none'' '// &
         intro//': whether faces touch would have to be found in each step. time = ''explicit'' does that')
      if (scene%energy_release%energy_balance) call settings%complain(mistakes, settings%find('energy_release', 1), &
         'estimators', 'must be others than ''energy_balance'' '//intro//': the audit books explicit steps')
      if (scene%refine%indicator /= 'none' .and. scene%refine%indicator /= 'tip') &
         call settings%complain(mistakes, settings%find('refine', 1), 'indicator', 'must be ''tip'' or ''none'' '//intro// &
                                ': the nodes keep their motion, and their mesh has to stay')
   end subroutine check_rest
end module hampm_implicit_consistency
