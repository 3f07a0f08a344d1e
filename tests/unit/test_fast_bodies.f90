!> Fast bodies of random velocities, of the order of the wave speed, with the full mass matrix: particles cross cells all the
!> time, and neither products nor factors of cells that are empty by then may be left. Every solver brings the run to its end
!> and keeps the momentum.
program test_fast_bodies
   use hampm_kinds, only: dp, ndim
   use hampm_energy, only: linear_momentum
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_mass_samples, only: choice_of
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, place_bodies, start
   use hampm_step, only: advance
   implicit none

   character(6), parameter :: solvers(2) = ['cg    ', 'direct']
   integer :: trial, k

   call repeat_random_numbers()
   do trial = 1, 3
      do k = 1, size(solvers)
         call check_body(trim(solvers(k)))
      end do
   end do
   call finish()

contains

   !> 200 steps of a body that flies apart in the middle of a large grid.
   subroutine check_body(solver)
      character(*), intent(in) :: solver
      type(problem_t) :: m
      type(failure_t) :: failure
      real(dp), parameter :: cell = 0.1_dp
      integer, parameter :: steps = 200
      real(dp) :: momentum(ndim), scale
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [40, 40]), &
                        new_material('', 'neo_hookean', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([1.8_dp, 1.8_dp], [2.2_dp, 2.2_dp], [8, 8])], m)
      call random_number(m%particles%velocity)
      m%particles%velocity = 2*m%particles%velocity - 1
      momentum = linear_momentum(m%particles)
      scale = sum(m%particles%mass*norm2(m%particles%velocity, 2))
      call start(m, 'musl', choice_of('consistent', solver))
      do while (m%state%steps < steps .and. .not. failure%failed())
         call advance(m, 0.02_dp*cell, failure)
      end do
      if (failure%failed()) call check(.false., solver//': '//failure%message)
      call check(m%fields%mass_matrix%layout > 10, solver//': the occupied cells change many times')
      call check_close(maxval(abs(linear_momentum(m%particles) - momentum)), 0.0_dp, &
                       4*(steps + m%particles%n)*epsilon(scale)*scale, solver//': momentum is kept')
      call m%solver%direct%release()
   end subroutine check_body
end program test_fast_bodies
