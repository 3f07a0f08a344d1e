!> The error estimate of Zienkiewicz & Zhu (1987): the energy norm of the difference between the stress recovered at the nodes
!> and that of the particles. Stress is recovered in each material by itself: across an interface it may jump.
module hampm_error_indicator
   use hampm_kinds, only: dp, ndim
   use hampm_basis, only: shape_functions, inside_cell
   use hampm_cell_values, only: sum_over_particles
   use hampm_motion, only: motion_t, refresh_grid
   use hampm_recovery, only: recover
   implicit none
   private
   public :: estimate_errors

   integer, parameter :: n_stress = ndim*ndim

contains

   !> Estimated squared error of each leaf in the energy norm [J], and the squared energy norm of the solution, which is twice
   !> the strain energy [J].
   subroutine estimate_errors(m, squared, norm)
      type(motion_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: squared(:)   !! (leaves)
      real(dp), intent(out) :: norm
      real(dp), allocatable :: stress(:, :), nodal(:, :), error(:)
      real(dp) :: difference(ndim, ndim), recovered(n_stress)
      integer :: i, k, leaf
      associate (p => m%particles, grid => m%grid)
         allocate (stress(n_stress, p%n), nodal(n_stress, grid%n_points), error(p%n))
         allocate (squared(grid%forest%leaf_count()))
         norm = 0
         do i = 1, p%n
            associate (material => m%materials(p%material(i)))
               stress(:, i) = reshape(material%kirchhoff_stress(p%gradient_of(i), p%history_of(i)), [n_stress])
               norm = norm + p%volume(i)*2*material%stress_energy_density(reshape(stress(:, i), [ndim, ndim]))
            end associate
         end do
         call refresh_grid(m)
         do k = 1, size(m%materials)
            call recover(grid, p, m%blocks, m%fields%mass_matrix, n_stress, stress, nodal, material=k)
            do i = 1, p%n
               if (p%material(i) /= k) cycle
               associate (e => p%cell(i))
                  recovered = matmul(nodal(:, grid%element_nodes(:, e)), &
                                     shape_functions(inside_cell(grid%local_coordinate(e, p%place_in_grid(i)))))
               end associate
               difference = reshape(recovered - stress(:, i), [ndim, ndim])
               error(i) = p%volume(i)*2*m%materials(k)%stress_energy_density(difference)
            end do
         end do
         do leaf = 1, size(squared)
            squared(leaf) = sum_over_particles(grid, m%blocks, leaf, error)
         end do
      end associate
   end subroutine estimate_errors
end module hampm_error_indicator
