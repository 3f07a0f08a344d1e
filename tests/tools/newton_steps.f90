!> Newton's iteration in the steps of a model, at rest or with inertia: how fast what is out of balance falls, and how well the
!> tangent is the change of the forces.
!>
!>    newton_steps case.nml [--set group.key=value ...]
!>
!> prints a line for each step: its number, the error of the tangent by differences in a strained state after its end, relative, and
!> what was out of balance in each iteration of its last part, over the largest force. Steps that are one solution have no iteration.
program newton_steps
   use hampm_balance, only: balance_t
   use hampm_kinds, only: dp, ndim, long
   use hampm_command_line, only: options_t, command_arguments, parse_arguments
   use hampm_constraints, only: hold
   use hampm_failure, only: failure_t
   use hampm_newton, only: displace
   use hampm_nodal_state, only: internal_force
   use hampm_program, only: end_program
   use hampm_reading, only: read_model
   use hampm_model, only: model_t
   use hampm_simulation, only: simulation_t, build
   use hampm_stiffness, only: stiffness_t, stiffness_kind_t, factorise_stiffness
   implicit none
   real(dp), parameter :: strain = 1e-3_dp         !! of the state of which the tangent is taken, over the displacement of a cell
   type(options_t) :: options
   type(model_t) :: model
   type(simulation_t) :: s
   character(:), allocatable :: text
   type(failure_t) :: failure
   integer(long) :: steps
   real(dp) :: dt
   integer :: k, n

   call random_seed(size=n)
   call random_seed(put=[(k, k=1, n)])           ! the same state in each run
   call parse_arguments(command_arguments(), options, failure)
   if (.not. failure%failed()) call read_model(options%input, options%overrides, model, failure, text=text)
   if (.not. failure%failed()) call build(model, 1, s, failure)
   if (failure%failed()) call end_program(failure)
   dt = model%output%history_interval
   if (.not. s%integrator%is_static) dt = model%method%time_step
   steps = nint(model%run%end_time/dt, long)
   call s%integrator%initialise(s%problem, dt, failure)
   do k = 1, int(steps)
      if (.not. failure%failed()) call s%integrator%advance(s%problem, dt, failure)
      if (failure%failed()) exit
      select type (by => s%integrator)
       class is (balance_t)
         call tell(by%newton%residuals)
      end select
   end do
   call end_program(failure)

contains

   !> Print the line of a step.
   subroutine tell(residuals)
      real(dp), intent(in) :: residuals(:)
      print '(i0, *(es10.2e3))', k, tangent_error(s), residuals
   end subroutine tell

   !> A displacement is found again from what forces change by it, forth and back, in a state with some strain beside that at the
   !> end of the step, as in a trial of the next one: how far that is off.
   real(dp) function tangent_error(s) result(error)
      type(simulation_t), intent(inout) :: s
      real(dp), parameter :: part = 1e-5_dp      ! of the strain: so little that hardly a point begins to yield between
      type(stiffness_t) :: tangent
      real(dp), allocatable, dimension(:, :) :: u, du, forth, back, found
      associate (m => s%problem)
         allocate (u, source=at_random(s))
         du = part*at_random(s)
         call displace(m, u)
         call factorise_stiffness(m, stiffness_kind_t(.true., .false.), tangent, failure)
         call displace(m, du)
         call internal_force(m, forth)
         call displace(m, -2*du)
         call internal_force(m, back)
         call tangent%solve(m, (back - forth)/2, found)
         call displace(m, du - u)
         call tangent%release()
         error = maxval(abs(found - du))/maxval(abs(du))
      end associate
   end function tangent_error

   !> A displacement of the nodes at random that constraints allow [m], (ndim, n_points).
   function at_random(s) result(u)
      type(simulation_t), intent(in) :: s
      real(dp), allocatable :: u(:, :)
      integer :: i
      associate (m => s%problem, all => s%problem%fields%mass_matrix%all)
         allocate (u(ndim, m%grid%n_points), source=0.0_dp)
         do i = 1, all%n_nodes
            call random_number(u(:, all%nodes(i)))
         end do
         u = strain*m%grid%forest%cell*u
         call hold(m%constraints, u)
         call m%grid%dofs%distribute(all, ndim, u)
      end associate
   end function at_random
end program newton_steps
