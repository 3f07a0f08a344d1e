!> Squares of quadratic cells, for the unit tests.
module hampm_quadratic_samples
   use hampm_kinds, only: dp, ndim
   use hampm_bodies, only: fill_rectangle
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check
   use hampm_mass_choice, only: mass_choice_t
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t, start_problem, refresh_grid
   use hampm_particles, only: new_particles
   use hampm_quadratic_points, only: weigh_points
   use hampm_sorting, only: sort_into_cells
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: fill_with_quadratic

contains

   !> Fill the leaves of a forest, a square from the origin on, with n x n particles each, and map these to the grid.
   subroutine fill_with_quadratic(forest, n, edge, density, thickness, m, mass)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: n
      real(dp), intent(in) :: edge               !! of the square [m]
      real(dp), intent(in) :: density            !! [kg/m3]
      real(dp), intent(in) :: thickness          !! [m]
      type(problem_t), intent(out) :: m
      type(mass_choice_t), intent(in), optional :: mass
      type(failure_t) :: failure
      real(dp), allocatable :: solids(:, :, :)
      real(dp) :: lower(ndim)
      integer :: leaf
      solids = reshape([0.0_dp, 0.0_dp, edge, edge], [ndim, 2, 1])
      call build_grid(forest, m%grid, failure, solids=solids)
      call new_particles(n**2*forest%leaf_count(), m%particles, failure)
      m%particles%total_frame = .true.
      m%interfaces%thickness = thickness_t(thickness)
      m%particles%thickness = thickness_t(thickness)
      m%materials = [new_material('sample', 'linear_elastic', .true., 2.0_dp, 0.3_dp, density)]
      do leaf = 1, forest%leaf_count()
         lower = forest%position(forest%place_of(leaf))
         call fill_rectangle(m%particles, 1 + n**2*(leaf - 1), [n, n], lower, lower + forest%size_of(leaf), &
                             thickness_t(thickness), density, &
                             [0.0_dp, 0.0_dp], 1, 1)
      end do
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      call weigh_points(m%matter_t)
      call start_problem(m, 'musl', failure, mass)
      call refresh_grid(m)
      call check(.not. failure%failed(), 'the mesh is built')
   end subroutine fill_with_quadratic
end module hampm_quadratic_samples
