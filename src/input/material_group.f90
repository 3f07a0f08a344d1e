!> The group &material: the values of its keys in a model.
module hampm_material_group
   use hampm_kinds, only: dp, ndim
   use hampm_group_values, only: material_keys_t, take_material
   use hampm_law, only: value_of
   use hampm_orthotropic, only: orthotropic_of, why_not_definite
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: material_spec_t, fill_materials

   !> &material: a law and its constants.
   type, extends(material_keys_t) :: material_spec_t
      integer :: number = 0                      !! of the group, among all &material
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
      integer :: i
      allocate (materials(settings%count_of('material')))
      do i = 1, size(materials)
         materials(i)%number = i
         call take_material(settings, settings%find('material', i), materials(i))
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

   !> Whether another one has the same law and constants, under any name.
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
