!> Whether the keys of a scene agree with contact between bodies: what cannot follow them is refused.
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
      integer :: contact, method
      contact = settings%find('contact', 1)
      method = settings%find('method', 1)
      if (.not. settings%good(contact, 'bodies')) return
      if (settings%good(contact, 'friction') .and. (scene%contact%bodies == 'friction' .neqv. scene%contact%friction > 0)) &
         call settings%complain(mistakes, contact, 'friction', 'must be above 0 with bodies = ''friction'' and 0 without')
      if (.not. scene%contact%is_wanted()) then
         if (settings%good(contact, 'distance') .and. scene%contact%distance > 0) call settings%complain(mistakes, contact, &
            'distance', 'must be 0 with bodies = ''joined'': such bodies act on each other as soon as both have cells at a node')
         call check_parts(scene, settings, mistakes)
         return
      end if
      if (settings%good(contact, 'distance') .and. scene%contact%distance > scene%grid%cell/2) call settings%complain(mistakes, &
         contact, 'distance', 'must not be above half of a cell: bodies farther apart have no nodes in common')
      call settings%demand(mistakes, method, 'time', 'explicit', intro//': whether bodies touch is found in each short step')
      call settings%demand(mistakes, method, 'frame', 'updated', intro//': in the total frame bodies never meet')
      call settings%demand(mistakes, method, 'time_steps', 'global', intro//': bodies that meet exchange momentum at one time')
      if (settings%good(settings%find('refine', 1), 'indicator') .and. scene%refine%indicator == 'gradient') &
         call settings%complain(mistakes, settings%find('refine', 1), 'indicator', 'must not be ''gradient'' '//intro// &
                                ': it takes all nodes of a cell for those of one body. Use ''zz''')
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

   !> Parts are told apart by contact only.
   pure subroutine check_parts(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k
      do k = 1, size(scene%bodies)
         if (scene%bodies(k)%part == '') cycle
         call settings%complain(mistakes, settings%find('body', k), 'part', 'goes with &contact bodies = ''stick'', '// &
                                '''frictionless'' or ''friction'' only')
         return
      end do
   end subroutine check_parts
end module hampm_contact_consistency
