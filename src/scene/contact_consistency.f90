!> Whether contact between bodies has cells and cracks with which it goes.
module hampm_contact_consistency
   use hampm_crack_placement, only: body_at, distance_to_mouth
   use hampm_kinds, only: dp, ndim
   use hampm_joints, only: sheets_of_bodies
   use hampm_mistakes, only: mistakes_t
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_contact

   character(*), parameter :: intro = 'with &contact bodies'
   integer, parameter :: most_sheets = 16        !! each has all cells of the grid

contains

   !> Check a scene whose bodies meet; others have no use for the keys.
   pure subroutine check_contact(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: contact
      contact = settings%find('contact', 1)
      if (.not. settings%good(contact, 'bodies')) return
      if (.not. scene%contact%is_wanted()) return
      if (settings%good(contact, 'distance') .and. scene%contact%distance > scene%grid%cell/2) call settings%complain(mistakes, &
         contact, 'distance', 'must not be above half of a cell: bodies farther apart have no nodes in common')
      call check_cracks(scene, settings, mistakes)
      if (maxval(sheets_of_bodies(scene)) > most_sheets) call settings%complain(mistakes, contact, 'bodies', 'must be '// &
         '''joined'' where there are more than '//to_text(most_sheets)//' bodies: each has a velocity field on the whole grid. '// &
         'Give the same &body part to those that do not meet')
   end subroutine check_contact

   !> Cracks are those of the first velocity field.
   pure subroutine check_cracks(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k, i
      if (scene%crack%present) call check_way(scene, settings, mistakes, settings%find('crack', 1), 'tip', scene%crack%tip, &
                                              scene%crack%tip - distance_to_mouth(scene)*scene%crack%direction)
      do k = 1, size(scene%paths)
         associate (path => scene%paths(k))
            do i = 2, size(path%points, 2)
               call check_way(scene, settings, mistakes, settings%find('crack', path%number), 'points', path%points(:, i - 1), &
                              path%points(:, i))
            end do
         end associate
      end do
   end subroutine check_cracks

   !> A straight part of a crack must not be in a body of another velocity field.
   pure subroutine check_way(scene, settings, mistakes, entry, key, from, to)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer, intent(in) :: entry               !! the crack
      character(*), intent(in) :: key
      real(dp), intent(in) :: from(ndim), to(ndim) !! [m]
      integer, parameter :: places = 1000        ! that are looked at
      integer :: sheets(size(scene%bodies)), i, body
      if (.not. settings%good(entry, key)) return
      sheets = sheets_of_bodies(scene)
      do i = 0, places
         body = body_at(scene, from + (i*(to - from))/places)
         if (body == 0) cycle
         if (sheets(body) == 1) cycle
         call settings%complain(mistakes, entry, key, 'must be in the first &body, or in one of its part, '//intro// &
                                ': put the body with the crack first')
         return
      end do
   end subroutine check_way
end module hampm_contact_consistency
