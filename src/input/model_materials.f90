!> The materials of a model as the method has them, from their keys.
module hampm_model_materials
   use hampm_material, only: material_t, new_material
   use hampm_model, only: model_t
   implicit none
   private
   public :: materials_of, material_of, material_of_body, are_alike

contains

   !> All materials of a model, and behind them one for each body with an eigenstrain.
   function materials_of(model) result(materials)
      type(model_t), intent(in) :: model
      type(material_t), allocatable :: materials(:)
      integer :: k, n
      allocate (materials(size(model%materials) + count([(has_eigenstrain(model, k), k=1, size(model%bodies))])))
      n = size(model%materials)
      do k = 1, n
         materials(k) = material_of(model, k)
      end do
      do k = 1, size(model%bodies)
         if (.not. has_eigenstrain(model, k)) cycle
         n = n + 1
         materials(n) = material_of(model, model%bodies(k)%material_index)
         call materials(n)%give_eigenstrain(model%bodies(k)%eigenstrain, &
                                            .not. model%bodies(k)%held .and. any(model%growth%law%is_static))
      end do
   end function materials_of

   !> Where the material of a body is among all: that of the first body that is alike, as stress is smooth from one into the other.
   pure integer function material_of_body(model, body) result(material)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body
      integer :: first, k
      first = 1
      do while (.not. are_alike(model, first, body))
         first = first + 1
      end do
      material = model%bodies(first)%material_index
      if (has_eigenstrain(model, first)) material = size(model%materials) + count([(has_eigenstrain(model, k), k=1, first)])
   end function material_of_body

   !> Whether a body has an eigenstrain.
   pure logical function has_eigenstrain(model, body)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body
      has_eigenstrain = any(abs(model%bodies(body)%eigenstrain) > 0)
   end function has_eigenstrain

   !> Whether two bodies are of one material with one eigenstrain, which is held in both or in none.
   pure logical function are_alike(model, a, b)
      type(model_t), intent(in) :: model
      integer, intent(in) :: a, b
      are_alike = model%bodies(a)%material_index == model%bodies(b)%material_index .and. &
                  .not. any(abs(model%bodies(a)%eigenstrain - model%bodies(b)%eigenstrain) > 0) .and. &
                  (model%bodies(a)%held .eqv. model%bodies(b)%held)
   end function are_alike

   !> One of them.
   type(material_t) function material_of(model, k) result(material)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k
      associate (spec => model%materials(k))
         material = new_material(spec%name, spec%law, model%run%plane == 'stress', spec%young, spec%poisson, spec%density, &
                                 spec%constants)
         material%mean_dilatation = spec%volumetric == 'b_bar' .and. model%grid%order == 1
         material%is_ring = model%run%thickness%is_ring
      end associate
   end function material_of
end module hampm_model_materials
