!> The group &material: its row in the table of groups, its keys, and their values in a model.
module hampm_material_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, repeats, is_required, positive
   use hampm_law, only: constant_t, value_of
   use hampm_laws, only: law_keys
   use hampm_orthotropic, only: orthotropic_of, why_not_definite
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: material_group, material_keys, material_spec_t, fill_materials

   type(group_t), parameter :: material_group = group_t('material', repeats, is_required, 'a material; bodies name it')

   type(key_t), parameter :: material_keys(*) = [ &
      key_t('name', type_name, 'name that bodies refer to', example='aluminium', required=.true.), &
      key_t('law', type_name, 'neo_hookean and mooney_rivlin are for any strain and rotation, the others for small ones', &
            default='linear_elastic', allowed='{laws}'), &
      key_t('young', type_real, 'Young''s modulus, at small strain; required of isotropic laws', example='70e9', unit='Pa', &
            allowed=positive, fewest=0), &
      key_t('poisson', type_real, 'Poisson''s ratio, at small strain', default='0.0', example='0.3', allowed='(-1, 0.5)'), &
      key_t('density', type_real, 'mass per undeformed volume', example='2700.0', unit='kg/m3', allowed=positive, &
            required=.true.), &
      key_t('volumetric', type_name, &
            'each point has its own dilatation, or the mean of its cell, which does not lock at constant volume', &
            default='standard', allowed='standard|b_bar'), &
      law_keys]

   !> &material: a law and its constants.
   type :: material_spec_t
      character(name_len) :: name = ''
      integer :: number = 0                      !! of the group, among all &material
      character(name_len) :: law = ''            !! one of those of `hampm_laws`
      real(dp) :: young = 0                      !! [Pa]
      real(dp) :: poisson = 0                    !! [-]
      real(dp) :: density = 0                    !! [kg/m3]
      character(name_len) :: volumetric = ''     !! 'standard' or 'b_bar'
      type(constant_t) :: constants(size(law_keys)) !! of single laws
   contains
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
         materials(i)%name = settings%text(entry, 'name')
         materials(i)%law = settings%text(entry, 'law')
         materials(i)%young = settings%number(entry, 'young')
         materials(i)%poisson = settings%number(entry, 'poisson')
         materials(i)%density = settings%number(entry, 'density')
         materials(i)%volumetric = settings%text(entry, 'volumetric')
         materials(i)%constants = settings%constants(entry, law_keys%name)
      end do
   end subroutine fill_materials

   !> Whether there is a material with these constants.
   pure logical function is_complete(self, plane)
      class(material_spec_t), intent(in) :: self
      character(*), intent(in) :: plane            !! 'stress' or 'strain'
      if (self%law /= 'orthotropic') then
         is_complete = self%young > 0
         return
      end if
      associate (of => orthotropic_of(self%constants, 0.0_dp, 0.0_dp), plane_stress => ndim == 2 .and. plane == 'stress')
         is_complete = minval(of%young(:merge(2, 3, plane_stress))) > 0 .and. minval([of%shear_12, of%shear]) > 0
         if (is_complete) is_complete = len(why_not_definite(of, plane_stress)) == 0
      end associate
   end function is_complete

   !> The smallest Young's modulus in the plane [Pa].
   elemental real(dp) function least_young(self)
      class(material_spec_t), intent(in) :: self
      least_young = self%young
      if (self%law == 'orthotropic') least_young = min(value_of(self%constants, 'young_1', 0.0_dp), &
                                                       value_of(self%constants, 'young_2', 0.0_dp))
   end function least_young

   !> Whether another one has the same law and constants, whatever its name.
   pure logical function is_the_same_as(self, other) result(is)
      class(material_spec_t), intent(in) :: self
      type(material_spec_t), intent(in) :: other
      integer :: k
      is = self%law == other%law .and. self%volumetric == other%volumetric .and. &
           .not. any(abs([self%young, self%poisson, self%density] - [other%young, other%poisson, other%density]) > 0) .and. &
           all(self%constants%count == other%constants%count) .and. &
           all([(maxval(abs(self%constants(k)%value - other%constants(k)%value)) <= 0, k=1, size(self%constants))])
   end function is_the_same_as
end module hampm_material_group
