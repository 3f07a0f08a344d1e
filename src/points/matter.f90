!> The matter of a run: particles of materials, in the order in which they stand in the blocks of cells of a grid.
module hampm_matter
   use hampm_kinds, only: dp, ndim
   use hampm_basis, only: inside_cell
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_grid, only: grid_t
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: matter_t

   !> Particles, and how they stand on the grid between two steps.
   type :: matter_t
      type(grid_t) :: grid
      type(particles_t) :: particles
      type(material_t), allocatable :: materials(:)
      type(cell_blocks_t) :: blocks              !! in which order the particles stand
   contains
      procedure :: local_of
      procedure :: nodes_of
      procedure :: functions_of
      procedure :: gradients_of
   end type matter_t

contains

   !> Where particle `i` is in its cell, 0 to 1: by its present position, in the total frame by its reference position.
   pure function local_of(self, i) result(xi)
      class(matter_t), intent(in) :: self
      integer, intent(in) :: i
      real(dp) :: xi(ndim)
      xi = inside_cell(self%grid%local_coordinate(self%particles%cell(i), self%particles%place_in_grid(i)))
   end function local_of

   !> The nodes on which particle `i` acts.
   pure function nodes_of(self, i) result(nodes)
      class(matter_t), intent(in) :: self
      integer, intent(in) :: i
      integer :: nodes(self%grid%n_functions)
      nodes = self%grid%support_of(self%particles%cell(i))
   end function nodes_of

   !> Their shape functions N at the particle.
   pure function functions_of(self, i) result(n)
      class(matter_t), intent(in) :: self
      integer, intent(in) :: i
      real(dp) :: n(self%grid%n_functions)
      n = self%grid%functions_in(self%particles%cell(i), self%local_of(i))
   end function functions_of

   !> And the gradients of these with respect to position [1/m].
   pure function gradients_of(self, i) result(gradient)
      class(matter_t), intent(in) :: self
      integer, intent(in) :: i
      real(dp) :: gradient(self%grid%n_functions, ndim), xi(ndim)
      xi = self%local_of(i)
      gradient = self%grid%gradients_in(self%particles%cell(i), xi)
   end function gradients_of
end module hampm_matter
