!> The matter of a run: particles of materials, in the order in which they stand in the blocks of cells of a grid.
module hampm_matter
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
   end type matter_t
end module hampm_matter
