!> Whether the eigenstrains of bodies go with the rest of a scene.
module hampm_eigenstrain_consistency
   use hampm_mistakes, only: mistakes_t
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: check_eigenstrains

contains

   !> Check the eigenstrain of each body that has one.
   pure subroutine check_eigenstrains(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      character(*), parameter :: intro = 'must be 0 '
      integer :: i, entry
      do i = 1, size(scene%bodies)
         entry = settings%find('body', i)
         associate (body => scene%bodies(i))
            if (.not. any(abs(body%eigenstrain) > 0)) cycle
            if (body%material_index > 0) then
               if (scene%materials(body%material_index)%law /= 'linear_elastic') &
                  call settings%complain(mistakes, entry, 'eigenstrain', intro//'but with &material law = ''linear_elastic''')
            end if
            if (scene%crack%present .and. scene%crack%kind == 'symmetry' .and. abs(body%eigenstrain(3)) > 0) &
               call settings%complain(mistakes, entry, 'eigenstrain', 'must have no shear, the third value, with a &crack of '// &
                                      'kind = ''symmetry'': the other half would have the opposite one')
            if (size(scene%growth) > 0) &
               call settings%complain(mistakes, entry, 'eigenstrain', intro//'with &growth: that scales loads, or books the '// &
                                      'energy of new faces, as if they alone had strained the body')
            if (scene%energy_release%reference == 'dcb') &
               call settings%complain(mistakes, entry, 'eigenstrain', intro//'with &energy_release reference = ''dcb'', which '// &
                                      'is that of forces')
         end associate
      end do
   end subroutine check_eigenstrains
end module hampm_eigenstrain_consistency
