!> The materials of a scene as the method has them, from their keys.
module hampm_scene_materials
   use hampm_material, only: material_t, new_material, new_orthotropic
   use hampm_scene, only: scene_t
   implicit none
   private
   public :: materials_of, material_of, material_of_body, are_alike

contains

   !> All materials of a scene, and behind them one for each body with an eigenstrain.
   function materials_of(scene) result(materials)
      type(scene_t), intent(in) :: scene
      type(material_t), allocatable :: materials(:)
      integer :: k, n
      allocate (materials(size(scene%materials) + count([(has_eigenstrain(scene, k), k=1, size(scene%bodies))])))
      n = size(scene%materials)
      do k = 1, n
         materials(k) = material_of(scene, k)
      end do
      do k = 1, size(scene%bodies)
         if (.not. has_eigenstrain(scene, k)) cycle
         n = n + 1
         materials(n) = material_of(scene, scene%bodies(k)%material_index)
         call materials(n)%give_eigenstrain(scene%bodies(k)%eigenstrain)
      end do
   end function materials_of

   !> Where the material of a body is among all: that of the first body that is alike, as stress is smooth from one into the other.
   pure integer function material_of_body(scene, body) result(material)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: body
      integer :: first, k
      first = 1
      do while (.not. are_alike(scene, first, body))
         first = first + 1
      end do
      material = scene%bodies(first)%material_index
      if (has_eigenstrain(scene, first)) material = size(scene%materials) + count([(has_eigenstrain(scene, k), k=1, first)])
   end function material_of_body

   !> Whether a body has an eigenstrain.
   pure logical function has_eigenstrain(scene, body)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: body
      has_eigenstrain = any(abs(scene%bodies(body)%eigenstrain) > 0)
   end function has_eigenstrain

   !> Whether two bodies are of one material with one eigenstrain.
   pure logical function are_alike(scene, a, b)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: a, b
      are_alike = scene%bodies(a)%material_index == scene%bodies(b)%material_index .and. &
                  .not. any(abs(scene%bodies(a)%eigenstrain - scene%bodies(b)%eigenstrain) > 0)
   end function are_alike

   !> One of them.
   type(material_t) function material_of(scene, k) result(material)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: k
      associate (spec => scene%materials(k))
         if (spec%law == 'orthotropic') then
            material = new_orthotropic(spec%name, scene%run%plane == 'stress', spec%orthotropic, spec%density)
         else
            material = new_material(spec%name, spec%law, scene%run%plane == 'stress', spec%young, spec%poisson, spec%density, &
                                    spec%yield_stress, spec%hardening, spec%moduli, spec%relaxation_times, spec%saturation, &
                                    spec%saturation_strain, spec%kinematic, spec%c01)
         end if
         material%mean_dilatation = spec%dilatation == 'cell' .and. scene%grid%order == 1
         material%is_ring = scene%run%thickness%is_ring
      end associate
   end function material_of
end module hampm_scene_materials
