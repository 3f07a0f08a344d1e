!> The materials of a scene as the method has them, from their keys.
module hampm_scene_materials
   use hampm_material, only: material_t, new_material, new_orthotropic
   use hampm_scene, only: scene_t
   implicit none
   private
   public :: materials_of, material_of

contains

   !> All materials of a scene.
   pure function materials_of(scene) result(materials)
      type(scene_t), intent(in) :: scene
      type(material_t) :: materials(size(scene%materials))
      integer :: k
      do k = 1, size(materials)
         materials(k) = material_of(scene, k)
      end do
   end function materials_of

   !> One of them.
   pure type(material_t) function material_of(scene, k) result(material)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: k
      associate (spec => scene%materials(k))
         if (spec%law == 'orthotropic') then
            material = new_orthotropic(spec%name, scene%run%plane == 'stress', spec%orthotropic, spec%density)
         else
            material = new_material(spec%name, spec%law, scene%run%plane == 'stress', spec%young, spec%poisson, spec%density, &
                                    spec%yield_stress, spec%hardening, spec%moduli, spec%relaxation_times)
            material%mean_dilatation = spec%dilatation == 'cell'
         end if
      end associate
   end function material_of
end module hampm_scene_materials
