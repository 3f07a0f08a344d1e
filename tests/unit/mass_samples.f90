!> Mass matrices of sample bodies, for the unit tests: mapped as a step maps them, and as dense matrices.
module hampm_mass_samples
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t
   use hampm_harness, only: check
   use hampm_mass_choice, only: mass_choice_t, new_mass_choice
   use hampm_mass_solver, only: solve_mass
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_samples, only: start
   use hampm_sorting, only: sort_into_cells
   implicit none
   private
   public :: choice_of, map_mass, displace, dense_matrix, solution

   real(dp), parameter :: everywhere = huge(1.0_dp)

contains

   !> A mass matrix by name, with what most tests leave as it is.
   pure function choice_of(mass, solver, order, lumped_fraction, lower, upper) result(choice)
      character(*), intent(in) :: mass
      character(*), intent(in), optional :: solver
      integer, intent(in), optional :: order
      real(dp), intent(in), optional :: lumped_fraction, lower(ndim), upper(ndim)
      type(mass_choice_t) :: choice
      character(7) :: by
      integer :: k
      real(dp) :: b, box(ndim, 2)
      by = 'cg'
      if (present(solver)) by = solver
      k = 1
      if (present(order)) k = order
      b = 0
      if (present(lumped_fraction)) b = lumped_fraction
      box(:, 1) = -everywhere
      box(:, 2) = everywhere
      if (present(lower)) box(:, 1) = lower
      if (present(upper)) box(:, 2) = upper
      choice = new_mass_choice(mass, trim(by), k, b, box(:, 1), box(:, 2))
   end function choice_of

   !> Displace all particles, at random by up to `range` in each direction, or all by the same, and sort them.
   subroutine displace(m, range, shift)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: range              !! [m]
      real(dp), intent(in) :: shift(ndim)        !! [m]
      type(failure_t) :: failure
      real(dp) :: r(ndim, m%particles%n)
      integer :: i
      call random_number(r)
      do i = 1, m%particles%n
         m%particles%displacement(i, :) = range*(2*r(:, i) - 1) + shift
      end do
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      call check(.not. failure%failed(), 'the displaced particles are in the grid')
   end subroutine displace

   !> Map masses, momenta and the mass matrix of a choice to the grid.
   subroutine map_mass(m, choice)
      type(problem_t), intent(inout) :: m
      type(mass_choice_t), intent(in) :: choice
      call m%solver%direct%release()
      call start(m, 'musl', choice)
      m%cache%mapped = .false.
      call refresh_grid(m)
   end subroutine map_mass

   !> The mass matrix that was mapped, for all nodes of the grid.
   function dense_matrix(m) result(a)
      type(problem_t), intent(in) :: m
      real(dp) :: a(m%grid%n_nodes, m%grid%n_nodes)
      integer :: i, k
      a = 0
      if (.not. allocated(m%fields%mass_matrix%cell)) then
         do i = 1, m%grid%n_nodes
            a(i, i) = m%fields%mass_matrix%lumped(i)
         end do
         return
      end if
      do k = 1, m%blocks%n_occupied
         associate (e => m%blocks%occupied(k))
            associate (nodes => m%grid%element_nodes(:, e))
               a(nodes, nodes) = a(nodes, nodes) + m%fields%mass_matrix%cell(:, :, e)
            end associate
         end associate
      end do
   end function dense_matrix

   !> x of M x = b, from a guess; zero at nodes without mass.
   function solution(m, b, guess) result(x)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in), contiguous :: b(:, :), guess(:, :)
      real(dp) :: x(ndim, m%grid%n_nodes)
      real(dp), allocatable :: values(:, :)      ! at hanging nodes, too
      type(failure_t) :: failure
      integer :: i
      allocate (values, source=guess)
      call solve_mass(m%solver, m%grid, m%fields%mass_matrix, b, values, failure)
      x = values(:, :m%grid%n_nodes)
      if (failure%failed()) call check(.false., failure%message)
      do i = 1, m%grid%n_nodes
         if (.not. m%fields%mass_matrix%lumped(i) > 0) x(:, i) = 0
      end do
   end function solution
end module hampm_mass_samples
