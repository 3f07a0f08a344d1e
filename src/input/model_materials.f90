!> The materials of a model as the method has them, from their keys.
module hampm_model_materials
   use hampm_body_group, only: profile_t
   use hampm_key_table, only: material_constants
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_material, only: material_t, slice_t, new_material
   use hampm_material_group, only: material_spec_t
   use hampm_model, only: model_t
   implicit none
   private
   public :: materials_of, material_of, material_of_body, are_alike, is_graded

   integer, parameter :: fewest_slices = 101, most_slices = 20001 !! of a graded body

contains

   !> All materials of a model, then one for each body with an eigenstrain, and those of each graded body.
   function materials_of(model) result(materials)
      type(model_t), intent(in) :: model
      type(material_t), allocatable :: materials(:)
      integer :: k, n, s
      n = size(model%materials)
      allocate (materials(n + sum([(own_materials(model, k), k=1, size(model%bodies))])))
      do k = 1, n
         materials(k) = material_of(model, k)
      end do
      do k = 1, size(model%bodies)
         do s = 1, own_materials(model, k)
            if (is_graded(model, k)) then
               materials(n + s) = material_of_slice(model, k, s, n + 1)
            else
               materials(n + s) = material_of(model, model%bodies(k)%material_index)
               call materials(n + s)%give_eigenstrain(model%bodies(k)%eigenstrain, &
                                                      .not. model%bodies(k)%held .and. any(model%growth%law%scales_loads()))
            end if
         end do
         n = n + own_materials(model, k)
      end do
   end function materials_of

   !> Index of the material of a body among all, for a graded one of its first slice: of the first body that is alike, as stress is
   !> smooth across both.
   pure integer function material_of_body(model, body) result(material)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body
      integer :: first, k
      first = 1
      do while (.not. are_alike(model, first, body))
         first = first + 1
      end do
      material = model%bodies(first)%material_index
      if (own_materials(model, first) > 0) &
         material = size(model%materials) + sum([(own_materials(model, k), k=1, first - 1)]) + 1
   end function material_of_body

   !> Number of materials of a body alone: of a graded one six in the width of the finest cells, plus one, so that no particle at a
   !> usual part of a cell is at a boundary of two.
   pure integer function own_materials(model, body)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body
      own_materials = merge(1, 0, any(abs(model%bodies(body)%eigenstrain) > 0))
      if (.not. is_graded(model, body)) return
      associate (at => model%bodies(body)%profile%at, finest => model%grid%cell/2**model%refine%max_level)
         own_materials = nint(min(max(6*anint((at(size(at)) - at(1))/finest) + 1, real(fewest_slices, dp)), real(most_slices, dp)))
      end associate
   end function own_materials

   !> Whether the material of a body changes from place to place.
   pure logical function is_graded(model, body)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body
      is_graded = .false.
      if (allocated(model%bodies(body)%profile%at)) is_graded = size(model%bodies(body)%profile%at) > 1
   end function is_graded

   !> The material in the middle of a slice of a graded body.
   type(material_t) function material_of_slice(model, body, number, first) result(material)
      type(model_t), intent(in) :: model
      integer, intent(in) :: body, number
      integer, intent(in) :: first               !! number of the material of the first slice
      type(slice_t) :: slice
      real(dp) :: at, part, eigenstrain(4), factor
      integer :: k, slices
      slices = own_materials(model, body)
      associate (b => model%bodies(body), profile => model%bodies(body)%profile)
         associate (places => profile%at, last => size(profile%at))
            slice = slice_t(number, slices, first, profile%direction/norm(profile%direction), places(1), &
                            (places(last) - places(1))/slices)
            at = places(1) + (number - 0.5_dp)*slice%width
            k = max(1, count(places(:last - 1) <= at))
            part = (at - places(k))/(places(k + 1) - places(k))
            material = material_of(model, b%material_index, between(profile%stiffness), between(profile%density))
            slice%rate = log(profile%stiffness(k + 1)/profile%stiffness(k))/(places(k + 1) - places(k))
            factor = profile%eigenstrain(k) + part*(profile%eigenstrain(k + 1) - profile%eigenstrain(k))
            eigenstrain = b%eigenstrain*(profile%eigenstrain(k + 1) - profile%eigenstrain(k))/(places(k + 1) - places(k))
         end associate
         call material%give_eigenstrain(eigenstrain)
         slice%free_rate = material%free
         call material%give_eigenstrain(b%eigenstrain*factor)
         material%has_eigenstrain = any(abs(b%eigenstrain) > 0)
         if (any([1, slices] == number)) then    ! beyond nothing changes
            slice%rate = 0
            slice%free_rate = 0
         end if
         material%slice = slice
      end associate

   contains

      !> A factor there.
      pure real(dp) function between(factors)
         real(dp), intent(in) :: factors(:)
         between = factors(k)*(factors(k + 1)/factors(k))**part
      end function between
   end function material_of_slice

   !> Whether two bodies are of one material with one eigenstrain, which is held in both or in none, and graded alike.
   pure logical function are_alike(model, a, b)
      type(model_t), intent(in) :: model
      integer, intent(in) :: a, b
      are_alike = model%bodies(a)%material_index == model%bodies(b)%material_index .and. &
                  .not. any(abs(model%bodies(a)%eigenstrain - model%bodies(b)%eigenstrain) > 0) .and. &
                  (model%bodies(a)%held .eqv. model%bodies(b)%held) .and. &
                  (is_graded(model, a) .eqv. is_graded(model, b))
      if (.not. (are_alike .and. is_graded(model, a))) return
      associate (p => numbers_of(model%bodies(a)%profile), q => numbers_of(model%bodies(b)%profile))
         are_alike = size(p) == size(q)
         if (are_alike) are_alike = .not. any(abs(p - q) > 0)
      end associate

   contains

      !> All numbers of a profile.
      pure function numbers_of(profile) result(numbers)
         type(profile_t), intent(in) :: profile
         real(dp), allocatable :: numbers(:)
         numbers = [profile%direction, profile%at, profile%stiffness, profile%density, profile%eigenstrain]
      end function numbers_of
   end function are_alike

   !> One of them.
   type(material_t) function material_of(model, k, stiffness, density) result(material)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k
      real(dp), intent(in), optional :: stiffness, density !! factors of its moduli and strengths, and of its density [-]
      type(material_spec_t) :: spec
      integer :: i
      spec = model%materials(k)
      if (present(stiffness)) then
         spec%young = spec%young*stiffness
         do i = 1, size(material_constants)
            if (material_constants(i)%unit == 'Pa') spec%constants(i)%value = spec%constants(i)%value*stiffness
         end do
         spec%density = spec%density*density
      end if
      material = new_material(spec%name, spec%law, ndim == 2 .and. model%run%plane == 'stress', spec%young, spec%poisson, &
                              spec%density, spec%constants)
      material%mean_dilatation = spec%volumetric == 'b_bar' .and. model%grid%order == 1
      material%is_ring = model%run%thickness%is_ring
   end function material_of
end module hampm_model_materials
