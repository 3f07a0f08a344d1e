!> Rectangular bodies of one material in motion, for the unit tests.
module hampm_samples
   use hampm_kinds, only: dp, ndim
   use hampm_bodies, only: fill_rectangle
   use hampm_crack_lines, only: line_t
   use hampm_energy, only: kinetic_energy, strain_energy
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check
   use hampm_mass_choice, only: mass_choice_t
   use hampm_mass_solver, only: solve_aside
   use hampm_material, only: material_t
   use hampm_problem, only: problem_t, start_problem, refresh_grid
   use hampm_particles, only: new_particles
   use hampm_sorting, only: sort_into_cells
   use hampm_step, only: advance
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: rectangle_t, schemes, place_bodies, start, run_steps, nodal_velocity, total_energy, energy_residual, thickness

   character(5), parameter :: schemes(4) = ['usf  ', 'usl  ', 'usavg', 'musl ']
   real(dp), parameter :: thickness = 0.5_dp     !! of every body [m]

   type :: rectangle_t
      real(dp) :: lower(ndim) = 0                !! [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      integer :: points(ndim) = 0                !! in each direction
      real(dp) :: velocity(ndim) = 0             !! [m/s]
   end type rectangle_t

contains

   !> A grid, with or without lines that cut, with rectangles of one material in it.
   subroutine place_bodies(forest, material, rectangles, m, lines)
      type(forest_t), intent(in) :: forest
      type(material_t), intent(in) :: material
      type(rectangle_t), intent(in) :: rectangles(:)
      type(problem_t), intent(out) :: m
      type(line_t), intent(in), optional :: lines(:)
      type(failure_t) :: failure
      integer :: k, n, first
      n = 0
      do k = 1, size(rectangles)
         n = n + product(rectangles(k)%points)
      end do
      call build_grid(forest, m%grid, failure, lines)
      call new_particles(n, m%particles, failure)
      m%particles%thickness = thickness_t(thickness)
      m%interfaces%thickness = thickness_t(thickness)
      m%materials = [material]
      first = 1
      do k = 1, size(rectangles)
         associate (r => rectangles(k))
            call fill_rectangle(m%particles, first, r%points, r%lower, r%upper, thickness_t(thickness), &
                                material%density, r%velocity, 1, k)
            first = first + product(r%points)
         end associate
      end do
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      call check_failure(failure)
   end subroutine place_bodies

   !> Make ready for the first step, with the lumped or another mass matrix.
   subroutine start(m, scheme, mass)
      type(problem_t), intent(inout) :: m
      character(*), intent(in) :: scheme
      type(mass_choice_t), intent(in), optional :: mass
      type(failure_t) :: failure
      call start_problem(m, trim(scheme), failure, mass)
      call check_failure(failure)
   end subroutine start

   !> Do a number of steps.
   subroutine run_steps(m, dt, steps)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      integer, intent(in) :: steps
      type(failure_t) :: failure
      integer :: k
      do k = 1, steps
         call advance(m, dt, failure)
         if (failure%failed()) exit
      end do
      call check_failure(failure)
   end subroutine run_steps

   !> Velocities of the nodes by the mass matrix of the run, v of M v = p [m/s], (ndim, n_points).
   function nodal_velocity(m) result(v)
      type(problem_t), intent(inout) :: m
      real(dp), allocatable :: v(:, :)
      type(failure_t) :: failure
      call refresh_grid(m)
      allocate (v(ndim, m%grid%n_points), source=0.0_dp)
      call solve_aside(m%solver, m%grid, m%fields%mass_matrix, m%fields%momentum, v, failure)
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, v)
      call check_failure(failure)
   end function nodal_velocity

   subroutine check_failure(failure)
      type(failure_t), intent(in) :: failure
      if (failure%failed()) call check(.false., failure%message)
   end subroutine check_failure

   !> Kinetic and strain energy of the particles [J].
   real(dp) function total_energy(m)
      type(problem_t), intent(in) :: m
      total_energy = kinetic_energy(m%particles) + strain_energy(m%particles, m%materials)
   end function total_energy

   !> What the energy audit leaves unexplained since the energy was `initial` [J].
   real(dp) function energy_residual(m, initial)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: initial            !! [J]
      energy_residual = total_energy(m) + m%energies%damping_loss + m%energies%numerical_loss - m%energies%external_work - initial
   end function energy_residual
end module hampm_samples
