!> The group &material: its row in the table of groups, its keys, and their values in a scene.
module hampm_material_group
   use hampm_kinds, only: dp, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, must, may, repeats, is_required, positive, not_negative
   use hampm_settings, only: settings_t
   use hampm_viscoelastic, only: most_branches
   implicit none
   private
   public :: material_group, material_keys, material_spec_t, fill_materials

   type(group_t), parameter :: material_group = group_t('material', repeats, is_required, 'a material; bodies name it')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: material_keys(*) = [ &
      key_t('material', 'name', type_name, 1, 1, must, '', 'aluminium', '', &
            '', 'name that bodies refer to'), &
      key_t('material', 'law', type_name, 1, 1, may, 'linear_elastic', '', '', &
            'linear_elastic|neo_hookean|j2_plastic|viscoelastic', &
            'neo_hookean is for any strain and rotation, the others for small ones'), &
      key_t('material', 'young', type_real, 1, 1, must, '', '70e9', 'Pa', &
            positive, 'Young''s modulus, at small strain'), &
      key_t('material', 'poisson', type_real, 1, 1, may, '0.0', '0.3', '', &
            '(-1, 0.5)', 'Poisson''s ratio, at small strain'), &
      key_t('material', 'density', type_real, 1, 1, must, '', '2700.0', 'kg/m3', &
            positive, 'mass per undeformed volume'), &
      key_t('material', 'yield_stress', type_real, 1, 1, may, '0.0', '', 'Pa', &
            not_negative, 'of law = ''j2_plastic'': the stress in uniaxial tension at which the material yields at first'), &
      key_t('material', 'hardening', type_real, 1, 1, may, '0.0', '', 'Pa', &
            not_negative, 'of law = ''j2_plastic'': by which the yield stress rises with the equivalent plastic strain'), &
      key_t('material', 'moduli', type_real, 0, most_branches, may, '', '', 'Pa', &
            positive, 'of law = ''viscoelastic'': the parts of the shear modulus at once that relax, a Prony series'), &
      key_t('material', 'relaxation_times', type_real, 0, most_branches, may, '', '', 's', &
            positive, 'of law = ''viscoelastic'': the time in which each of them falls to 1/e'), &
      key_t('material', 'dilatation', type_name, 1, 1, may, 'point', '', '', &
            'point|cell', 'of laws with a history: each point has its own, or the mean of its cell, which does not lock')]

   !> &material: a law and its constants.
   type :: material_spec_t
      character(name_len) :: name = ''
      character(name_len) :: law = ''            !! one of those of `hampm_material`
      real(dp) :: young = 0                      !! [Pa]
      real(dp) :: poisson = 0                    !! [-]
      real(dp) :: density = 0                    !! [kg/m3]
      character(name_len) :: dilatation = ''     !! 'point' or 'cell'
      real(dp) :: yield_stress = 0               !! of 'j2_plastic' [Pa]
      real(dp) :: hardening = 0                  !! the same [Pa]
      real(dp), allocatable :: moduli(:)         !! of 'viscoelastic' [Pa]
      real(dp), allocatable :: relaxation_times(:) !! the same [s]
   end type material_spec_t

contains

   !> Take all groups of this name.
   pure subroutine fill_materials(settings, materials)
      type(settings_t), intent(in) :: settings
      type(material_spec_t), allocatable, intent(out) :: materials(:)
      integer :: i
      allocate (materials(settings%count_of('material')))
      do i = 1, size(materials)
         call fill_material(settings, settings%find('material', i), materials(i))
      end do
   end subroutine fill_materials

   !> Take the values of the keys of one; 0, '' or empty where they are mistaken.
   pure subroutine fill_material(settings, entry, material)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group
      type(material_spec_t), intent(inout) :: material
      material%name = settings%text(entry, 'name')
      material%law = settings%text(entry, 'law')
      material%young = settings%number(entry, 'young')
      material%poisson = settings%number(entry, 'poisson')
      material%density = settings%number(entry, 'density')
      material%dilatation = settings%text(entry, 'dilatation')
      material%yield_stress = settings%number(entry, 'yield_stress')
      material%hardening = settings%number(entry, 'hardening')
      material%moduli = settings%numbers(entry, 'moduli')
      material%relaxation_times = settings%numbers(entry, 'relaxation_times')
   end subroutine fill_material
end module hampm_material_group
