!> Graded bodies: their particles have the materials of their places, each of which stands for a slice of the body.
module hampm_grading
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: give_materials_of_places

contains

   !> Give each particle of a graded body the material of its slice. Material with a history must not change: its dissipation would.
   pure subroutine give_materials_of_places(p, materials)
      type(particles_t), intent(inout) :: p
      type(material_t), intent(in) :: materials(:)
      integer :: i
      if (.not. any(materials%is_graded())) return
      do i = 1, p%n
         p%material(i) = p%material(i) + materials(p%material(i))%slices_to(p%reference(i, :))
      end do
   end subroutine give_materials_of_places
end module hampm_grading
