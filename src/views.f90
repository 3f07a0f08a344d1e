!> What a snapshot shows: the particles as points and the mesh as cells, with their fields.
module hampm_views
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hampm_kinds, only: dp, ndim, corners
   use hampm_gradient_indicator, only: nodal_field, refinement_parameter
   use hampm_motion, only: motion_t
   use hampm_nodal_fields, only: v_n
   use hampm_refinement, only: refinement_t
   use hampm_snapshots, only: piece_t, vtk_quad
   implicit none
   private
   public :: particle_view, mesh_view

contains

   !> The particles at their present position.
   subroutine particle_view(motion, view)
      type(motion_t), intent(in) :: motion
      type(piece_t), intent(out) :: view
      real(dp) :: h(ndim, ndim), stress(ndim, ndim)
      real(dp), allocatable :: components(:, :), energy(:)
      integer :: i
      associate (p => motion%particles)
         allocate (components(3, p%n), energy(p%n))
         do i = 1, p%n
            h = p%gradient_of(i)
            associate (material => motion%materials(p%material(i)))
               stress = material%kirchhoff_stress(h)
               components(:, i) = [stress(1, 1), stress(2, 2), stress(1, 2)]
               energy(i) = material%energy_density(h)
            end associate
         end do
         call view%set_vertices('particles', transpose(p%reference + p%displacement))
         call view%add_point_field('id', real(reshape(p%id, [1, p%n]), dp))
         call view%add_point_field('body', real(reshape(p%body, [1, p%n]), dp))
         call view%add_point_field('displacement', transpose(p%displacement))
         call view%add_point_field('velocity', transpose(p%velocity))
         call view%add_point_field('stress_xx', components(1:1, :))
         call view%add_point_field('stress_yy', components(2:2, :))
         call view%add_point_field('stress_xy', components(3:3, :))
         call view%add_point_field('energy_density', reshape(energy, [1, p%n]))
      end associate
   end subroutine particle_view

   !> The grid, transition cells by their quarters, with the mass and velocity that its nodes had in the last step and, where the
   !> mesh follows a gradient, the refinement parameter: not a number after a failure, when it can't be had from the particles.
   subroutine mesh_view(motion, refinement, after_failure, view)
      type(motion_t), intent(inout) :: motion
      type(refinement_t), intent(in) :: refinement
      logical, intent(in) :: after_failure
      type(piece_t), intent(out) :: view
      integer, parameter :: around(corners) = [1, 2, 4, 3]  ! corners in VTK's order, around the cell
      real(dp), allocatable :: phi(:), r(:)
      integer :: e
      if (refinement%indicator == 'gradient') then
         if (after_failure) then
            r = spread(ieee_value(0.0_dp, ieee_quiet_nan), 1, motion%grid%n_points)
         else
            call nodal_field(motion, refinement%field, phi)
            call refinement_parameter(motion, refinement%field, phi, r)
         end if
         call view%add_point_field('R', reshape(r, [1, size(r)]))
      end if
      associate (grid => motion%grid, f => motion%fields)
         view%name = 'mesh'
         view%points = grid%node_position
         view%connectivity = reshape(grid%element_nodes(around, :) - 1, [corners*grid%n_elements])
         view%offsets = [(corners*e, e=0, grid%n_elements)]
         view%cell_types = spread(vtk_quad, 1, grid%n_elements)
         call view%add_point_field('mass', reshape(f%mass_matrix%lumped, [1, grid%n_points]))
         call view%add_point_field('velocity', f%velocity(:, :, v_n))
         call view%add_cell_field('level', reshape([(real(grid%forest%level_of(grid%element_leaf(e)), dp), &
                                                     e=1, grid%n_elements)], [1, grid%n_elements]))
         call view%add_cell_field('particles', reshape(real(motion%blocks%count_in, dp), [1, grid%n_elements]))
      end associate
   end subroutine mesh_view
end module hampm_views
