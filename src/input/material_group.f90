!> The group &material: its row in the table of groups, its keys, and their values in a model.
module hampm_material_group
   use hampm_kinds, only: dp, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, must, may, repeats, is_required, positive, not_negative, &
                             any_number
   use hampm_orthotropic, only: orthotropic_t, why_not_definite
   use hampm_settings, only: settings_t
   use hampm_viscoelastic, only: most_branches
   implicit none
   private
   public :: material_group, material_keys, orthotropic_keys, material_spec_t, fill_materials

   type(group_t), parameter :: material_group = group_t('material', repeats, is_required, 'a material; bodies name it')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: material_keys(*) = [ &
      key_t('material', 'name', type_name, 1, 1, must, '', 'aluminium', '', &
            '', 'name that bodies refer to'), &
      key_t('material', 'law', type_name, 1, 1, may, 'linear_elastic', '', '', &
            'linear_elastic|neo_hookean|mooney_rivlin|j2_plastic|viscoelastic|orthotropic', &
            'neo_hookean and mooney_rivlin are for any strain and rotation, the others for small ones'), &
      key_t('material', 'young', type_real, 0, 1, may, '', '70e9', 'Pa', &
            positive, 'Young''s modulus, at small strain; required of isotropic laws'), &
      key_t('material', 'poisson', type_real, 1, 1, may, '0.0', '0.3', '', &
            '(-1, 0.5)', 'Poisson''s ratio, at small strain'), &
      key_t('material', 'density', type_real, 1, 1, must, '', '2700.0', 'kg/m3', &
            positive, 'mass per undeformed volume'), &
      key_t('material', 'yield_stress', type_real, 1, 1, may, '0.0', '', 'Pa', &
            not_negative, 'of law = ''j2_plastic'': the stress in uniaxial tension at which the material yields at first'), &
      key_t('material', 'hardening', type_real, 1, 1, may, '0.0', '', 'Pa', &
            not_negative, 'of law = ''j2_plastic'': by which the yield stress rises with the equivalent plastic strain'), &
      key_t('material', 'saturation', type_real, 1, 1, may, '0.0', '', 'Pa', &
            not_negative, 'of law = ''j2_plastic'': by which it rises to a limit besides (Voce)'), &
      key_t('material', 'saturation_strain', type_real, 0, 1, may, '', '', '', &
            positive, 'the equivalent plastic strain at which 1 - 1/e of that is reached; required with saturation'), &
      key_t('material', 'kinematic_hardening', type_real, 1, 1, may, '0.0', '', 'Pa', &
            not_negative, 'of law = ''j2_plastic'': by which the back stress rises with the plastic strain (Prager)'), &
      key_t('material', 'c01', type_real, 0, 1, may, '', '', 'Pa', &
            positive, 'of law = ''mooney_rivlin'': modulus of the second invariant; c10 = young/(4 (1 + poisson)) - c01'), &
      key_t('material', 'moduli', type_real, 0, most_branches, may, '', '', 'Pa', &
            positive, 'of law = ''viscoelastic'': the relaxing parts of the instantaneous shear modulus, a Prony series'), &
      key_t('material', 'relaxation_times', type_real, 0, most_branches, may, '', '', 's', &
            positive, 'of law = ''viscoelastic'': the time in which each of them falls to 1/e'), &
      key_t('material', 'volumetric', type_name, 1, 1, may, 'standard', '', '', &
            'standard|b_bar', &
            'each point has its own dilatation, or the mean of its cell, which does not lock at constant volume'), &
      key_t('material', 'young_1', type_real, 0, 1, may, '', '', 'Pa', &
            positive, 'of ''orthotropic'': Young''s modulus along axis 1 of the material'), &
      key_t('material', 'young_2', type_real, 0, 1, may, '', '', 'Pa', &
            positive, 'the same along axis 2'), &
      key_t('material', 'young_3', type_real, 0, 1, may, '', '', 'Pa', &
            positive, 'the same across the plane; required in plane strain'), &
      key_t('material', 'shear_12', type_real, 0, 1, may, '', '', 'Pa', &
            positive, 'shear modulus in the plane, between axes 1 and 2'), &
      key_t('material', 'poisson_12', type_real, 0, 1, may, '', '', '', &
            any_number, '-(strain along 2)/(strain along 1) under stress along 1; poisson_21 follows'), &
      key_t('material', 'poisson_13', type_real, 0, 1, may, '', '', '', &
            any_number, '-(strain across the plane)/(strain along 1) under stress along 1; required in plane strain'), &
      key_t('material', 'poisson_23', type_real, 0, 1, may, '', '', '', &
            any_number, '-(strain across the plane)/(strain along 2) under stress along 2; required in plane strain'), &
      key_t('material', 'angle', type_real, 1, 1, may, '0.0', '', 'degrees', &
            any_number, 'of axis 1 of an orthotropic material from x, anticlockwise')]

   !> The constants of an orthotropic material alone.
   character(*), parameter :: orthotropic_keys(*) = [character(10) :: 'young_1', 'young_2', 'young_3', 'shear_12', 'poisson_12', &
                                                     'poisson_13', 'poisson_23']

   !> &material: a law and its constants.
   type :: material_spec_t
      character(name_len) :: name = ''
      integer :: number = 0                      !! of the group, among all &material
      character(name_len) :: law = ''            !! one of those of `hampm_material`
      real(dp) :: young = 0                      !! [Pa]
      real(dp) :: poisson = 0                    !! [-]
      real(dp) :: density = 0                    !! [kg/m3]
      character(name_len) :: volumetric = ''     !! 'standard' or 'b_bar'
      real(dp) :: yield_stress = 0               !! of 'j2_plastic' [Pa]
      real(dp) :: hardening = 0                  !! the same [Pa]
      real(dp) :: saturation = 0                 !! the same [Pa]
      real(dp) :: saturation_strain = 0          !! the same [-]
      real(dp) :: kinematic = 0                  !! the same [Pa]
      real(dp) :: c01 = 0                        !! of 'mooney_rivlin' [Pa]
      real(dp), allocatable :: moduli(:)         !! of 'viscoelastic' [Pa]
      real(dp), allocatable :: relaxation_times(:) !! the same [s]
      type(orthotropic_t) :: orthotropic         !! constants of that law
   contains
      procedure :: is_linear
      procedure :: is_complete
      procedure :: least_young
      procedure :: is_the_same_as
   end type material_spec_t

contains

   !> Take all groups of this name.
   pure subroutine fill_materials(settings, materials)
      type(settings_t), intent(in) :: settings
      type(material_spec_t), allocatable, intent(out) :: materials(:)
      integer :: i, entry
      allocate (materials(settings%count_of('material')))
      do i = 1, size(materials)
         entry = settings%find('material', i)
         materials(i)%number = i
         associate (material => materials(i))
            material%name = settings%text(entry, 'name')
            material%law = settings%text(entry, 'law')
            material%young = settings%number(entry, 'young')
            material%poisson = settings%number(entry, 'poisson')
            material%density = settings%number(entry, 'density')
            material%volumetric = settings%text(entry, 'volumetric')
            material%yield_stress = settings%number(entry, 'yield_stress')
            material%hardening = settings%number(entry, 'hardening')
            material%saturation = settings%number(entry, 'saturation')
            material%saturation_strain = settings%number(entry, 'saturation_strain')
            material%kinematic = settings%number(entry, 'kinematic_hardening')
            material%c01 = settings%number(entry, 'c01')
            material%moduli = settings%numbers(entry, 'moduli')
            material%relaxation_times = settings%numbers(entry, 'relaxation_times')
            associate (of => material%orthotropic)
               of%young = [settings%number(entry, 'young_1'), settings%number(entry, 'young_2'), &
                           settings%number(entry, 'young_3')]
               of%shear_12 = settings%number(entry, 'shear_12')
               of%poisson_12 = settings%number(entry, 'poisson_12')
               of%poisson_13 = settings%number(entry, 'poisson_13')
               of%poisson_23 = settings%number(entry, 'poisson_23')
               of%angle = settings%number(entry, 'angle')
            end associate
         end associate
      end do
   end subroutine fill_materials

   !> Whether the stress is linear in the displacement gradient.
   elemental logical function is_linear(self)
      class(material_spec_t), intent(in) :: self
      is_linear = self%law == 'linear_elastic' .or. self%law == 'orthotropic'
   end function is_linear

   !> Whether there is a material with these constants.
   pure logical function is_complete(self, plane)
      class(material_spec_t), intent(in) :: self
      character(*), intent(in) :: plane            !! 'stress' or 'strain'
      if (self%law /= 'orthotropic') then
         is_complete = self%young > 0
         return
      end if
      associate (of => self%orthotropic)
         is_complete = minval(of%young(:merge(2, 3, plane == 'stress'))) > 0 .and. of%shear_12 > 0
         if (is_complete) is_complete = len(why_not_definite(of, plane == 'stress')) == 0
      end associate
   end function is_complete

   !> The smallest Young's modulus in the plane [Pa].
   elemental real(dp) function least_young(self)
      class(material_spec_t), intent(in) :: self
      least_young = self%young
      if (self%law == 'orthotropic') least_young = minval(self%orthotropic%young(:2))
   end function least_young

   !> Whether another one has the same law and constants, whatever its name.
   pure logical function is_the_same_as(self, other) result(is)
      class(material_spec_t), intent(in) :: self
      type(material_spec_t), intent(in) :: other
      is = self%law == other%law .and. self%volumetric == other%volumetric
      if (is) is = are_equal([self%young, self%poisson, self%density, self%yield_stress, self%hardening, self%saturation, &
                              self%saturation_strain, self%kinematic, self%c01], &
                             [other%young, other%poisson, other%density, other%yield_stress, other%hardening, other%saturation, &
                              other%saturation_strain, other%kinematic, other%c01])
      if (is) is = are_equal(self%moduli, other%moduli) .and. are_equal(self%relaxation_times, other%relaxation_times)
      if (is) is = are_equal(self%orthotropic%constants(), other%orthotropic%constants())
   end function is_the_same_as

   !> Whether two lists have the same numbers.
   pure logical function are_equal(a, b)
      real(dp), intent(in) :: a(:), b(:)
      are_equal = size(a) == size(b)
      if (are_equal) are_equal = .not. any(abs(a - b) > 0)
   end function are_equal
end module hampm_material_group
