!> Whether cracks can grow as a scene asks for.
module hampm_growth_consistency
   use hampm_kinds, only: dp
   use hampm_crack_placement, only: least_radius
   use hampm_mistakes, only: mistakes_t
   use hampm_path_placement, only: path_tips
   use hampm_placement, only: tolerance
   use hampm_scene, only: scene_t
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
      integer :: k, i, method, entry
      if (size(scene%growth) == 0) return
      method = settings%find('method', 1)
      if (any(scene%growth%law == 'quasi_static')) &
         call settings%demand(mistakes, method, 'time', 'static', intro//' of law = ''quasi_static''')
      if (.not. scene%energy_release%domain_integral) call settings%complain(mistakes, settings%find('energy_release', 1), &
         'estimators', 'must name ''domain_integral'' '//intro//', which goes by G, K_I and K_II')
      do i = 1, size(scene%materials)
         entry = settings%find('material', i)
         if (settings%good(entry, 'law') .and. scene%materials(i)%law /= 'linear_elastic') call settings%complain(mistakes, entry, &
            'law', 'must be ''linear_elastic'' '//intro//', under which loads are scaled')
      end do
      do i = 1, size(scene%constraints)
         if (scene%constraints(i)%motion%push_only) call settings%complain(mistakes, settings%find('constraint', i), 'push_only', &
                                                                    'must be .false. '//intro)
      end do
      if (any(scene%paths%friction > 0)) call settings%complain(mistakes, settings%find('crack', scene%paths( &
         findloc(scene%paths%friction > 0, .true., dim=1))%number), 'contact', 'must not be ''friction'' '//intro// &
         ': friction depends on the way, and loads are scaled')
      do k = 1, size(scene%growth)
         call check_one(scene, settings, k, has_bodies, mistakes)
      end do
   end subroutine check_growth

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
         if (size(scene%paths) == 0) then
            call settings%complain(mistakes, entry, 'crack', 'needs a &crack of kind = ''path'': no other grows')
            return
         else if (growth%path == 0 .and. growth%crack == '') then
            call settings%complain(mistakes, entry, 'crack', 'must be the name of one of the cracks, as there are several')
            return
         else if (growth%path == 0) then
            call settings%complain(mistakes, entry, 'crack', 'there is no &crack of this name')
            return
         else if (any(scene%growth(:k - 1)%path == growth%path)) then
            call settings%complain(mistakes, entry, 'crack', 'must be another crack than that of each other &growth')
         end if
         if (.not. has_bodies) return
         if (.not. any(path_tips(scene, growth%path))) &
            call settings%complain(mistakes, entry, 'crack', 'this crack has no tip inside the material')
         if (settings%good(entry, 'increment') .and. growth%increment < least_radius(scene) - tolerance(scene%grid)) &
            call settings%complain(mistakes, entry, 'increment', 'must be at least two of the finest cells, '// &
                                   to_text(least_radius(scene))//' m: between two kinks there is to be a radius of the domain '// &
                                   'integral')
      end associate
      if (size(scene%energy_release%radii) > 0) then
         if (scene%growth(k)%increment < maxval(scene%energy_release%radii) .and. scene%growth(k)%direction /= 'straight') &
            call settings%complain(mistakes, entry, 'increment', 'must be at least the largest of &energy_release radii, '// &
                                   to_text(maxval(scene%energy_release%radii))//' m, in which the crack is to be straight')
      end if
   end subroutine check_one
end module hampm_growth_consistency
