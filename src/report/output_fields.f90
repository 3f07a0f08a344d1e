!> Fields of a snapshot: the particles as points, the mesh as cells and cracks as lines.
module hampm_output_fields
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hampm_kinds, only: dp, ndim, plane, corners
   use hampm_basis, only: points_of_quadratic
   use hampm_cracks, only: crack_t, cracks_t, first_point, last_point
   use hampm_crack_lines, only: both_faces
   use hampm_grid, only: grid_t
   use hampm_gradient_indicator, only: nodal_field, refinement_parameter
   use hampm_problem, only: problem_t
   use hampm_nodal_fields, only: v_n
   use hampm_indicator, only: refinement_t
   use hampm_snapshots, only: piece_t, add_field, vtk_line, vtk_quad, vtk_hexahedron, vtk_biquadratic_quad
   use hampm_tensors, only: name_of_component, n_voigt, identity, voigt, n_symmetric
   implicit none
   private
   public :: shows_cracks, particle_fields, mesh_fields, crack_fields

contains

   !> Whether snapshots show the cracks, and the side of each particle: not for a symmetry plane that stays as in the model.
   pure logical function shows_cracks(cracks)
      type(cracks_t), intent(in) :: cracks
      integer :: c
      shows_cracks = any([(cracks%crack(c)%face == both_faces .or. cracks%crack(c)%grows .or. cracks%crack(c)%cohesion > 0, &
                           c=1, size(cracks%crack))])
   end function shows_cracks

   !> The particles at their present position. With cracks, each has the piece of its cell to which it belongs, and the side of the
   !> crack on which it began.
   subroutine particle_fields(problem, with_cracks, output)
      type(problem_t), intent(in) :: problem
      logical, intent(in) :: with_cracks
      type(piece_t), intent(out) :: output
      real(dp) :: h(ndim, ndim), stress(ndim, ndim)
      real(dp), allocatable :: components(:, :), energy(:), plastic(:), deformation(:, :)
      integer :: i, k
      associate (p => problem%particles)
         allocate (components(n_symmetric, p%n), energy(p%n), plastic(p%n), deformation(ndim*ndim, p%n))
         do i = 1, p%n
            h = p%gradient_of(i)
            deformation(:, i) = reshape(transpose(identity + h), [ndim*ndim])
            associate (material => problem%materials(p%material(i)))
               stress = material%kirchhoff_stress(h, p%history_of(i), p%hoop_of(i))
               do k = 1, ndim
                  components(voigt(:, k), i) = stress(:, k)
               end do
               if (ndim == plane) components(4, i) = (1 + merge(p%hoop_of(i), 0.0_dp, material%is_finite)) &
                                                     *material%hoop_stress(h, p%history_of(i), p%hoop_of(i))
               energy(i) = material%energy_density(h, p%history_of(i), p%hoop_of(i))
               plastic(i) = material%equivalent_plastic_strain(p%history_of(i))
            end associate
         end do
         call output%set_vertices('particles', transpose(p%reference + p%displacement))
         call add_field(output%point_fields, 'id', real(reshape(p%id, [1, p%n]), dp))
         call add_field(output%point_fields, 'body', real(reshape(p%body, [1, p%n]), dp))
         call add_field(output%point_fields, 'displacement', transpose(p%displacement), 'm')
         call add_field(output%point_fields, 'velocity', transpose(p%velocity), 'm/s')
         do k = 1, n_voigt
            call add_field(output%point_fields, 'stress_'//name_of_component(k), components(k:k, :), 'Pa')
         end do
         if (ndim == plane .and. .not. problem%materials(1)%plane_stress) &
            call add_field(output%point_fields, 'stress_zz', components(4:4, :), 'Pa')
         call add_field(output%point_fields, 'energy_density', reshape(energy, [1, p%n]), 'J/m3')
         call add_field(output%point_fields, 'deformation_gradient', deformation)
         if (any(problem%materials%yields)) call add_field(output%point_fields, 'plastic_strain', reshape(plastic, [1, p%n]))
      end associate
      if (with_cracks) call add_sides(problem, output)
   end subroutine particle_fields

   !> Add to the particles their pieces and sides; after a failure some may be in no cell.
   subroutine add_sides(problem, output)
      type(problem_t), intent(in) :: problem
      type(piece_t), intent(inout) :: output
      real(dp), allocatable :: of(:, :) ! piece, side
      real(dp) :: origin(ndim)
      integer :: i
      allocate (of(2, problem%particles%n))
      of = 0
      associate (grid => problem%grid, p => problem%particles)
         do i = 1, p%n
            if (p%cell(i) == 0) cycle
            origin = p%reference(i, :)
            of(:, i) = [grid%piece_of(p%cell(i)), &
                        grid%cut_cells%side_at(grid%element_leaf(p%cell(i)), grid%cut_cells%follow(origin))]
         end do
         call add_field(output%point_fields, 'piece', of(1:1, :))
         call add_field(output%point_fields, 'side', of(2:2, :))
      end associate
   end subroutine add_sides

   !> The grid, transition cells by their quarters, cut cells by their pieces, each over the whole cell, and quadratic cells whole.
   !> Its fields are mass and velocity of the nodes in the last step and, where the mesh follows a gradient, the refinement
   !> parameter: NaN after a failure, when particles cannot give it.
   subroutine mesh_fields(problem, refinement, with_cracks, after_failure, output)
      type(problem_t), intent(inout) :: problem
      type(refinement_t), intent(in) :: refinement
      logical, intent(in) :: with_cracks, after_failure
      type(piece_t), intent(out) :: output
      integer, parameter :: order(8) = [1, 2, 4, 3, 5, 6, 8, 7], around(corners) = order(:corners) ! corners in VTK's order
      real(dp), allocatable :: phi(:), r(:)
      integer :: e
      if (refinement%by%name == 'gradient') then
         if (after_failure) then
            r = spread(ieee_value(0.0_dp, ieee_quiet_nan), 1, problem%grid%n_points)
         else
            call nodal_field(problem, refinement%field, phi)
            call refinement_parameter(problem, refinement%field, phi, r)
         end if
         call add_field(output%point_fields, 'R', reshape(r, [1, size(r)]))
      end if
      associate (grid => problem%grid, f => problem%fields)
         output%name = 'mesh'
         output%points = grid%node_position
         call add_field(output%point_fields, 'mass', reshape(f%mass_matrix%lumped, [1, grid%n_points]), 'kg')
         call add_field(output%point_fields, 'velocity', f%velocity(:, :, v_n), 'm/s')
         if (grid%is_quadratic()) then
            call add_quadratic_cells(grid, problem%blocks%count_in, with_cracks, output)
            return
         end if
         output%connectivity = reshape(grid%element_nodes(around, :) - 1, [corners*grid%n_elements])
         output%offsets = [(corners*e, e=0, grid%n_elements)]
         output%cell_types = spread(merge(vtk_quad, vtk_hexahedron, ndim == 2), 1, grid%n_elements)
         call add_field(output%cell_fields, 'level', &
                        reshape([(real(grid%forest%level_of(grid%element_leaf(e)), dp), e=1, grid%n_elements)], &
                                  [1, grid%n_elements]))
         call add_field(output%cell_fields, 'particles', reshape(real(problem%blocks%count_in, dp), [1, grid%n_elements]))
         if (with_cracks) call add_field(output%cell_fields, 'piece', &
                                         reshape([(real(grid%piece_of(e), dp), e=1, grid%n_elements)], [1, grid%n_elements]))
      end associate
   end subroutine mesh_fields

   !> Quadratic cells, or their pieces, each with its nine nodes, its level and the number of its particles.
   subroutine add_quadratic_cells(grid, particles, with_cracks, output)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: particles(:)        !! by element
      logical, intent(in) :: with_cracks
      type(piece_t), intent(inout) :: output
      integer, parameter :: n = points_of_quadratic
      integer, parameter :: around(9) = [1, 3, 9, 7, 2, 6, 8, 4, 5]  ! VTK's order: corners, middles of sides, middle
      integer :: support(n), e, k
      associate (cells => grid%n_elements/corners, first => [(e, e=1, grid%n_elements, corners)])
         allocate (output%connectivity(n*cells))
         do k = 1, cells
            support = grid%support_of(first(k))
            output%connectivity(n*(k - 1) + 1:n*(k - 1) + size(around)) = support(around) - 1
         end do
         output%offsets = [(n*k, k=0, cells)]
         output%cell_types = spread(vtk_biquadratic_quad, 1, cells)
         call add_field(output%cell_fields, 'level', &
                        reshape([(real(grid%forest%level_of(grid%element_leaf(first(k))), dp), k=1, cells)], [1, cells]))
         call add_field(output%cell_fields, 'particles', &
                        reshape([(real(sum(particles(first(k):first(k) + corners - 1)), dp), k=1, cells)], [1, cells]))
         if (with_cracks) call add_field(output%cell_fields, 'piece', &
                                         reshape([(real(grid%piece_of(first(k)), dp), k=1, cells)], [1, cells]))
      end associate
   end subroutine add_quadratic_cells

   !> The cracks in the reference configuration, a line for each straight part, with the number of the crack and, at its points, of
   !> the tip there, or 0.
   subroutine crack_fields(cracks, output)
      type(cracks_t), intent(in) :: cracks
      type(piece_t), intent(out) :: output
      real(dp), allocatable :: tip(:, :), number(:, :)
      integer :: first(size(cracks%crack) + 1)   ! point of each crack
      integer :: c, k
      first(1) = 1
      do c = 1, size(cracks%crack)
         first(c + 1) = first(c) + size(shown(cracks%crack(c)), 2)
      end do
      associate (n_points => first(size(first)) - 1, n_lines => first(size(first)) - size(first))
         allocate (output%points(ndim, n_points), output%connectivity(0), number(1, n_lines))
         allocate (tip(1, n_points), source=0.0_dp)
         output%name = 'cracks'
         output%offsets = [(2*k, k=0, n_lines)]
         output%cell_types = spread(vtk_line, 1, n_lines)
      end associate
      do c = 1, size(cracks%crack)
         output%points(:, first(c):first(c + 1) - 1) = shown(cracks%crack(c))
         output%connectivity = [output%connectivity, [([k - 1, k], k=first(c), first(c + 1) - 2)]]
         number(1, first(c) - c + 1:first(c + 1) - 1 - c) = c
      end do
      do k = 1, size(cracks%tips)
         if (cracks%tips(k)%has_ended) cycle
         associate (c => cracks%tips(k)%crack)
            if (cracks%tips(k)%end == first_point) tip(1, first(c)) = k
            if (cracks%tips(k)%end == last_point) tip(1, first(c + 1) - 1) = k
         end associate
      end do
      call add_field(output%point_fields, 'tip', tip)
      call add_field(output%cell_fields, 'crack', number)

   contains

      !> Where a crack is, or where it may appear, without a tip then.
      pure function shown(crack) result(points)
         type(crack_t), intent(in) :: crack
         real(dp), allocatable :: points(:, :)
         if (crack%waits) then
            allocate (points, source=crack%given)
         else
            allocate (points, source=crack%open_part())
         end if
      end function shown
   end subroutine crack_fields
end module hampm_output_fields
