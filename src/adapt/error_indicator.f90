!> The error estimate of Zienkiewicz & Zhu (1987): the energy norm of the difference between the stress recovered at the nodes
!> and that of the particles. Stress is recovered in each material by itself: across an interface it may jump. In quadratic cells it is
!> recovered by quadratic functions.
module hampm_error_indicator
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions, inside_cell
   use hampm_cell_values, only: sum_over_particles
   use hampm_material, only: material_t
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_particles, only: particles_t
   use hampm_recovery, only: recover, recover_quadratic, terms_at, n_terms
   implicit none
   private
   public :: estimate_errors, errors_at_particles, energy_of_stress, stress_components

   integer, parameter :: n_stress = ndim*ndim

contains

   !> Estimated squared error of each leaf in the energy norm [J], and the squared energy norm of the solution, which is twice
   !> the strain energy [J].
   subroutine estimate_errors(m, squared, norm)
      type(problem_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: squared(:)   !! (leaves)
      real(dp), intent(out) :: norm
      real(dp), allocatable :: stress(:, :), error(:)
      integer :: i, leaf
      associate (p => m%particles, grid => m%grid)
         allocate (stress(stress_components(p), p%n), squared(grid%forest%leaf_count()))
         norm = 0
         do i = 1, p%n
            associate (material => m%materials(p%material(i)))
               stress(:n_stress, i) = reshape(material%kirchhoff_stress(p%gradient_of(i), p%history_of(i), p%hoop_of(i)), &
                                              [n_stress])
               if (material%is_ring) stress(n_stress + 1, i) = material%hoop_stress(p%gradient_of(i), p%history_of(i), p%hoop_of(i))
               norm = norm + p%volume(i)*2*energy_of_stress(material, stress(:, i))
            end associate
         end do
         call refresh_grid(m)
         call errors_at_particles(m, stress, error)
         do leaf = 1, size(squared)
            squared(leaf) = sum_over_particles(grid, m%blocks, leaf, error)
         end do
      end associate
   end subroutine estimate_errors

   !> Components of stress that are kept: those of the plane, and stress_33 of axisymmetric material.
   pure integer function stress_components(p)
      type(particles_t), intent(in) :: p
      stress_components = merge(n_stress + 1, n_stress, p%thickness%is_ring)
   end function stress_components

   !> Elastic energy per volume of a small stress of so many components [J/m3].
   pure real(dp) function energy_of_stress(material, stress) result(energy)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: stress(:)          !! [Pa]
      energy = material%stress_energy_density(reshape(stress(:n_stress), [ndim, ndim]), stress(size(stress)))
   end function energy_of_stress

   !> The squared error of stress at each particle in the energy norm, with its volume [J].
   subroutine errors_at_particles(m, stress, error)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: stress(:, :)               !! of the particles [Pa], (n_stress, particles)
      real(dp), allocatable, intent(out) :: error(:)
      real(dp), allocatable :: nodal(:, :), coefficient(:, :, :), edge(:)
      real(dp) :: recovered(size(stress, 1))
      integer :: i, k
      associate (p => m%particles, grid => m%grid)
         allocate (nodal(size(stress, 1), grid%n_points), error(p%n))
         if (grid%is_quadratic()) allocate (coefficient(n_terms, size(stress, 1), grid%n_nodes), edge(grid%n_nodes))
         do k = 1, size(m%materials)
            if (grid%is_quadratic()) then
               call recover_quadratic(m%matter_t, size(stress, 1), stress, coefficient, edge, material=k)
            else
               call recover(m%matter_t, m%fields%mass_matrix, size(stress, 1), stress, nodal, material=k)
            end if
            do i = 1, p%n
               if (p%material(i) /= k) cycle
               if (grid%is_quadratic()) then
                  recovered = blended(m, i, coefficient, edge)
               else
                  associate (e => p%cell(i))
                     recovered = matmul(nodal(:, grid%element_nodes(:, e)), &
                                        shape_functions(inside_cell(grid%local_coordinate(e, p%place_in_grid(i)))))
                  end associate
               end if
               error(i) = p%volume(i)*2*energy_of_stress(m%materials(k), recovered - stress(:, i))
            end do
         end do
      end associate
   end subroutine errors_at_particles

   !> At a particle of a quadratic cell: the quadratic functions that were recovered at the four corners, with the bilinear functions of these as
   !> weights, which makes one field of them that is continuous (Zienkiewicz & Zhu 1992 take their means at the nodes).
   pure function blended(m, i, coefficient, edge) result(value)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp), intent(in) :: coefficient(:, :, :), edge(:)
      real(dp) :: value(size(coefficient, 2))
      real(dp) :: shape(corners), x(ndim)
      integer :: first, q
      x = m%particles%place_in_grid(i)
      associate (grid => m%grid, e => m%particles%cell(i))
         first = grid%first_of_piece(e)
         shape = shape_functions(grid%in_leaf(e, grid%local_coordinate(e, x)))
         value = 0
         do q = 1, corners
            associate (node => grid%element_nodes(q, first + q - 1))
               value = value + shape(q)*matmul(terms_at((x - grid%node_position(:, node))/edge(node)), coefficient(:, :, node))
            end associate
         end do
      end associate
   end function blended
end module hampm_error_indicator
