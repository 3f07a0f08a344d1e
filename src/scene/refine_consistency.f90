!> Whether what tells cells to refine has all it needs: a crack, a region with material in it, room for more particles.
module hampm_refine_consistency
   use hampm_kinds, only: dp, ndim
   use hampm_mistakes, only: mistakes_t
   use hampm_placement, only: tolerance, overlap, particle_number, point_text
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_refine

contains

   !> Check the group &refine. With indicator = 'none' its other keys have no meaning.
   pure subroutine check_refine(scene, settings, has_bodies, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      logical, intent(in) :: has_bodies            !! whether grid and bodies are without mistakes
      type(mistakes_t), intent(inout) :: mistakes
      integer :: entry
      entry = settings%find('refine', 1)
      if (.not. settings%good(entry, 'indicator') .or. scene%refine%indicator == 'none') return
      if (scene%refine%indicator == 'gradient' .and. settings%good(entry, 'r_crit') .and. settings%good(entry, 'r_coarsen') &
          .and. scene%refine%r_coarsen >= scene%refine%r_crit) &
         call settings%complain(mistakes, entry, 'r_coarsen', 'must be below r_crit = '//to_text(scene%refine%r_crit))
      call check_region(scene, settings, entry, has_bodies, mistakes)
      if (has_bodies) call check_room(scene, settings, entry, mistakes)
   end subroutine check_refine

   !> The box in which cells may refine has an extent and holds material. A corner that is not given sets no limit.
   pure subroutine check_region(scene, settings, entry, has_bodies, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group &refine, here and below
      logical, intent(in) :: has_bodies
      type(mistakes_t), intent(inout) :: mistakes
      integer :: i
      if (.not. (settings%good(entry, 'region_lower') .and. settings%good(entry, 'region_upper'))) return
      associate (lower => scene%refine%region_lower, upper => scene%refine%region_upper)
         if (any(upper <= lower)) then
            call settings%complain(mistakes, entry, 'region_upper', 'must be above region_lower = '//point_text(lower)// &
                                   ' in every direction')
            return
         end if
         if (.not. has_bodies) return
         do i = 1, size(scene%bodies)
            if (overlap(lower, upper, scene%bodies(i)%lower, scene%bodies(i)%upper, tolerance(scene%grid))) return
         end do
      end associate
      call settings%complain(mistakes, entry, &
                             merge('region_lower', 'region_upper', size(settings%numbers(entry, 'region_lower')) > 0), &
                             'the box from region_lower to region_upper must contain material of a body')
   end subroutine check_region

   !> The material points that the scene begins with are not too many already.
   pure subroutine check_room(scene, settings, entry, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      type(mistakes_t), intent(inout) :: mistakes
      real(dp) :: particles
      integer :: i
      if (.not. settings%good(entry, 'max_particles')) return
      particles = 0
      do i = 1, size(scene%bodies)
         if (.not. settings%good(settings%find('body', i), 'points_per_cell')) return
         particles = particles + particle_number(scene, scene%bodies(i))
      end do
      if (scene%refine%max_particles < particles) call settings%complain(mistakes, entry, 'max_particles', &
         'must be at least the number of material points that the scene begins with, '//to_text(nint(particles)))
   end subroutine check_room
end module hampm_refine_consistency
