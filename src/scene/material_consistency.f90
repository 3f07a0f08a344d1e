!> Whether each material has the constants of its law, and whether they are those of a solid.
module hampm_material_consistency
   use hampm_kinds, only: dp
   use hampm_material_group, only: material_spec_t
   use hampm_mistakes, only: mistakes_t
   use hampm_orthotropic, only: why_not_definite
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: check_constants

   character(*), parameter :: moduli(*) = [character(8) :: 'young_1', 'young_2', 'shear_12']
   character(*), parameter :: across(*) = [character(10) :: 'young_3', 'poisson_13', 'poisson_23']
   character(*), parameter :: all_keys(*) = [character(10) :: 'young_1', 'young_2', 'young_3', 'shear_12', 'poisson_12', &
                                             'poisson_13', 'poisson_23']

contains

   !> Check all materials.
   pure subroutine check_constants(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: i, entry
      do i = 1, size(scene%materials)
         entry = settings%find('material', i)
         if (.not. settings%good(entry, 'law')) cycle
         if (scene%materials(i)%law == 'orthotropic') then
            call check_orthotropic(scene, scene%materials(i), settings, entry, mistakes)
         else
            call check_isotropic(settings, entry, mistakes)
         end if
      end do
   end subroutine check_constants

   !> An isotropic law has Young's modulus, and no axes.
   pure subroutine check_isotropic(settings, entry, mistakes)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group, here and below
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k
      if (is_empty(settings, entry, 'young')) call settings%complain(mistakes, entry, 'young', &
         'must have 1 value, not 0: Young''s modulus; for example young = 70e9; it must be in (0, inf) [Pa]')
      do k = 1, size(all_keys)
         if (size(settings%numbers(entry, trim(all_keys(k)))) > 0) call settings%complain(mistakes, entry, trim(all_keys(k)), &
            'is for law = ''orthotropic'' only')
      end do
      if (abs(settings%number(entry, 'angle')) > 0) call settings%complain(mistakes, entry, 'angle', &
         'is for law = ''orthotropic'' only: other materials have no axes')
   end subroutine check_isotropic

   !> An orthotropic material has the constants of its plane condition, and none of an isotropic one.
   pure subroutine check_orthotropic(scene, material, settings, entry, mistakes)
      type(scene_t), intent(in) :: scene
      type(material_spec_t), intent(in) :: material
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      type(mistakes_t), intent(inout) :: mistakes
      character(*), parameter :: intro = 'must have 1 value, not 0, with law = ''orthotropic'''
      character(:), allocatable :: why
      logical :: plane_stress, has_plane
      integer :: k
      if (size(settings%numbers(entry, 'young')) > 0) call settings%complain(mistakes, entry, 'young', &
         'must be left out with law = ''orthotropic'', which takes young_1, young_2, shear_12 and poisson_12')
      if (abs(settings%number(entry, 'poisson')) > 0) call settings%complain(mistakes, entry, 'poisson', &
         'must be left out with law = ''orthotropic'', which takes poisson_12')
      do k = 1, size(moduli)
         if (is_empty(settings, entry, trim(moduli(k)))) call settings%complain(mistakes, entry, trim(moduli(k)), &
            intro//'; it must be in (0, inf) [Pa]')
      end do
      if (is_empty(settings, entry, 'poisson_12')) call settings%complain(mistakes, entry, 'poisson_12', intro)
      has_plane = settings%good(settings%find('run', 1), 'plane')
      if (.not. has_plane) return
      plane_stress = scene%run%plane == 'stress'
      do k = 1, size(across)
         if (.not. plane_stress .and. is_empty(settings, entry, trim(across(k)))) &
            call settings%complain(mistakes, entry, trim(across(k)), intro//' in plane = ''strain'', where '// &
                                   'material is held across the plane')
      end do
      if (.not. all([(settings%good(entry, trim(all_keys(k))), k=1, size(all_keys))])) return
      if (minval(material%orthotropic%young(:merge(2, 3, plane_stress))) <= 0 .or. material%orthotropic%shear_12 <= 0) return
      why = why_not_definite(material%orthotropic, plane_stress)
      if (why /= '') call settings%complain(mistakes, entry, 'poisson_12', why//': else a strain would release energy')
   end subroutine check_orthotropic

   !> Whether a key in which no mistake was found has no value.
   pure logical function is_empty(settings, entry, key)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      is_empty = .false.
      if (settings%good(entry, key)) is_empty = size(settings%numbers(entry, key)) == 0
   end function is_empty
end module hampm_material_consistency
