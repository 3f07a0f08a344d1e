!> The longest stable time step of a model with a mass matrix that is solved with, from its own matrices as they are at the start of a run:
!> 2 over the root of the largest eigenvalue of M**-1 K, interface points with forces at the start of a step and their masses included, by the method of Lanczos.
!>
!>    eigenvalue_limit COURANT case.nml [options of hampm for a run]
!>
!> prints that step over the one of this courant number, [-], which is read as in `forced_step`.
program eigenvalue_limit
   use hampm_kinds, only: dp, ndim
   use hampm_command_line, only: options_t, command_arguments, parse_arguments
   use hampm_constraints, only: hold
   use hampm_interface_points, only: interfaces_t, relax_interfaces, add_interface_resistance
   use hampm_failure, only: failure_t
   use hampm_lapack, only: dsyev
   use hampm_mass_solver, only: solve_aside
   use hampm_problem, only: refresh_grid
   use hampm_program, only: end_program
   use hampm_reading, only: read_model
   use hampm_model, only: model_t
   use hampm_simulation, only: simulation_t, build
   use hampm_stiffness, only: forces_of
   use hampm_text, only: string_t
   implicit none
   integer, parameter :: most_turns = 120
   type(string_t), allocatable :: words(:)
   type(options_t) :: options
   type(model_t) :: model
   type(simulation_t) :: s
   character(:), allocatable :: text
   type(failure_t) :: failure

   allocate (words, source=command_arguments())
   call parse_arguments(words(2:), options, failure)
   if (.not. failure%failed()) call read_model(options%input, options%overrides, model, failure, text=text)
   read (words(1)%text, *) model%method%courant
   if (.not. failure%failed()) call build(model, options%threads, s, failure)
   if (.not. failure%failed()) print '(es23.15)', 2/sqrt(largest_eigenvalue())/s%longest_step
   call end_program(failure)

contains

   !> The largest eigenvalue of M**-1 K [1/s2].
   real(dp) function largest_eigenvalue() result(largest)
      real(dp), allocatable, dimension(:, :) :: v, mass_v, mass_last, w, force
      real(dp) :: t(most_turns, most_turns), value(most_turns), work(4*most_turns), beta
      integer :: turn, info, k
      call refresh_grid(s%problem)
      associate (n => s%problem%grid%n_points)
         allocate (v(ndim, n), mass_last(ndim, n), w(ndim, n), source=0.0_dp)
         allocate (mass_v(ndim, n), force(ndim, n))
      end associate
      call random_seed(size=k)
      call random_seed(put=[(turn, turn=1, k)])  ! the same in every run
      call random_number(mass_v)
      mass_v = mass_v - 0.5_dp
      t = 0
      beta = 0
      do turn = 1, most_turns
         if (turn > 1) mass_v = force
         call solve(mass_v, w)
         beta = sqrt(sum(mass_v*w))               ! of what is left: M v is there before v
         v = w/beta
         mass_v = mass_v/beta
         if (turn > 1) then
            t(turn, turn - 1) = beta
            t(turn - 1, turn) = beta
         end if
         force = stiffness_times(v)
         t(turn, turn) = sum(force*v)
         force = force - t(turn, turn)*mass_v
         if (turn > 1) force = force - beta*mass_last
         mass_last = mass_v
      end do
      call dsyev('N', 'U', most_turns, t, most_turns, value, work, size(work), info)
      largest = value(most_turns)
   end function largest_eigenvalue

   !> x of M x = b, and b at the nodes that move.
   subroutine solve(b, x)
      real(dp), intent(inout), contiguous :: b(:, :), x(:, :)
      logical, allocatable :: moves(:)
      associate (m => s%problem, all => s%problem%fields%mass_matrix%all)
         allocate (moves(m%grid%n_points), source=.false.)
         moves(all%nodes(:all%n_nodes)) = .true.
         where (spread(.not. moves, 1, ndim)) b = 0
         call hold(m%constraints, b)
         x = 0
         call solve_aside(m%solver, m%grid, m%fields%mass_matrix, b, x, failure)
         call m%grid%dofs%distribute(all, ndim, x)
      end associate
   end subroutine solve

   !> K u, at the nodes that are free to move.
   function stiffness_times(u) result(force)
      real(dp), intent(in) :: u(:, :)
      real(dp), allocatable :: force(:, :)
      type(interfaces_t) :: interfaces
      call forces_of(s%problem, u, force)
      interfaces = s%problem%interfaces
      if (interfaces%n > 0) then
         call relax_interfaces(interfaces)
         interfaces%list(:interfaces%n_at_end)%stiffness = 0 ! forces at the end of a step need none that is shorter
         call add_interface_resistance(interfaces, u, force)
      end if
      call hold(s%problem%constraints, force)
   end function stiffness_times
end program eigenvalue_limit
