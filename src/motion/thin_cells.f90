!> Cells that the edges of bodies leave nearly empty, and whose nodes do not hang on others (`hampm_outer_nodes`): those beside cells of
!> another size or at a crack. Their outer nodes have little mass, and would have explicit steps as short as one likes.
!>
!> So in explicit steps the material in them is softer: with f the part of the cell that is filled, and f_least that from which on nodes are free, its stress acts
!> on the volume times (f/f_least)**2. The stiffness of an outer node falls with f, its mass at least with f**2 if lumped and with f**3 if
!> not. What is lost is less than a tenth of a cell at the few cells where sizes change along an edge. Masses stay.
module hampm_thin_cells
   use hampm_kinds, only: dp, ndim
   use hampm_grid, only: grid_t
   use hampm_material, only: material_t
   use hampm_outer_nodes, only: least_fill
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: soften_thin_cells

contains

   !> Give particles the volume on which their stress acts, in the cells of a new grid.
   pure subroutine soften_thin_cells(p, grid, materials)
      type(particles_t), intent(inout) :: p
      type(grid_t), intent(in) :: grid
      type(material_t), intent(in) :: materials(:)
      real(dp) :: fill(grid%n_elements)
      integer :: i
      fill = 0
      do i = 1, p%n
         p%volume(i) = p%mass(i)/materials(p%material(i))%density
         fill(p%cell(i)) = fill(p%cell(i)) + p%area_of(i)
      end do
      fill = fill/grid%element_size**ndim
      do i = 1, p%n
         associate (e => p%cell(i))
            if (fill(e) < least_fill .and. .not. grid%outer_nodes%has_host(grid%element_leaf(e))) &
               p%volume(i) = p%volume(i)*(fill(e)/least_fill)**2
         end associate
      end do
   end subroutine soften_thin_cells
end module hampm_thin_cells
