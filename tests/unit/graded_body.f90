!> A body of cells of several sizes, and coarse steps of it, for the unit tests of time steps that fit the size of the cells.
module hampm_graded_body
   use hampm_kinds, only: dp, long
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check
   use hampm_integrator, only: integrator_t
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t, update_particles
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t, place_bodies, total_energy
   use hampm_sorting, only: sort_into_cells
   implicit none
   private
   public :: place_graded, run_coarsely, mean_energy, same_numbers, cell, limit

   real(dp), parameter :: cell = 1.0_dp          !! of the root; shear wave speed and density are 1
   real(dp), parameter :: limit = 1/sqrt(2.6_dp) !! shear wave speed with E = 1, nu = 0.3

contains

   !> A body of cells of several sizes, small ones in its middle or a few at a corner, in which all particles are as close as two in a cell
   !> of the finest.
   subroutine place_graded(levels, law, frame, m, at_corner)
      integer, intent(in) :: levels
      character(*), intent(in) :: law, frame
      type(problem_t), intent(out) :: m
      logical, intent(in), optional :: at_corner
      type(forest_t) :: forest
      type(failure_t) :: failure
      integer :: points, length, k
      forest = forest_t([0.0_dp, 0.0_dp], cell, [8, 6])
      if (present(at_corner)) then
         length = 4
         do k = 1, levels
            call refine_box(forest, [1.0_dp, 2.0_dp], [1.0_dp, 2.0_dp] + 2.0_dp**(1 - k), k)
         end do
      else
         length = 6
         call refine_box(forest, [2.45_dp, 2.45_dp], [3.55_dp, 3.55_dp], levels)
      end if
      points = 2*2**levels
      call place_bodies(forest, new_material('', law, .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([1.0_dp, 2.0_dp], [1.0_dp + length, 4.0_dp], points*[length, 2])], m)
      m%particles%total_frame = frame == 'total'
      m%blocks%by_group = .true.
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      call check(.not. failure%failed(), 'the particles are sorted')
   end subroutine place_graded

   !> Do some coarse steps.
   subroutine run_coarsely(c, m, dt, largest, steps)
      class(integrator_t), intent(inout) :: c
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! finest step [s]
      integer, intent(in) :: largest, steps
      type(failure_t) :: failure
      integer :: k
      c%largest = largest
      do k = 1, steps
         call c%advance(m, dt, failure)
         if (failure%failed()) exit
      end do
      if (.not. failure%failed()) call update_particles(m)
      if (failure%failed()) call check(.false., failure%message)
   end subroutine run_coarsely

   !> The mean energy of the particles over some coarse steps.
   real(dp) function mean_energy(c, m, dt, largest, steps)
      class(integrator_t), intent(inout) :: c
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! finest step [s]
      integer, intent(in) :: largest, steps
      integer :: k
      mean_energy = 0
      do k = 1, steps
         call run_coarsely(c, m, dt, largest, 1)
         mean_energy = mean_energy + total_energy(m)/steps
      end do
   end function mean_energy

   !> Whether numbers have the same bytes.
   pure logical function same_numbers(a, b)
      real(dp), intent(in) :: a(:), b(:)
      same_numbers = all(transfer(a, [0_long]) == transfer(b, [0_long]))
   end function same_numbers
end module hampm_graded_body
