!> What a step conserves and keeps exactly, for every scheme.
program test_step
   use hampm_kinds, only: dp, ndim
   use hampm_energy, only: linear_momentum
   use hampm_failure, only: failure_t, exit_computation
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_material, only: material_t, new_material
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps
   use hampm_step, only: advance
   use hampm_tensors, only: identity
   use hampm_critical_step, only: stable_time_step
   implicit none

   real(dp), parameter :: cell = 0.1_dp
   type(material_t) :: linear, neo_hookean
   integer :: k

   call repeat_random_numbers()
   linear = new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp)
   neo_hookean = new_material('', 'neo_hookean', .true., 1.0_dp, 0.3_dp, 1.0_dp)
   do k = 1, size(schemes)
      call momentum_of_a_free_body(trim(schemes(k)))
      call rigid_translation(trim(schemes(k)))
      call uniform_strain_rate(trim(schemes(k)))
      call fresh_start(trim(schemes(k)))
   end do
   call time_step()
   call too_fast()
   call finish()

contains

   !> Angular momentum about the origin [kg m2/s].
   pure real(dp) function angular_momentum(p) result(l)
      type(particles_t), intent(in) :: p
      integer :: i
      real(dp) :: x(ndim)
      l = 0
      do i = 1, p%n
         x = p%position(i)
         l = l + p%mass(i)*(x(1)*p%velocity(i, 2) - x(2)*p%velocity(i, 1))
      end do
   end function angular_momentum

   !> A drifting body with spin and random velocities, whose particles cross cells. Plain USL is given fewer steps: the
   !> free edges of a body that drifts off the cell lines break it up. Angular momentum is not conserved with a lumped
   !> mass matrix; its change, over that of the spin, is printed.
   subroutine momentum_of_a_free_body(scheme)
      character(*), intent(in) :: scheme
      type(problem_t) :: m
      real(dp), parameter :: centre(ndim) = [0.63_dp, 0.62_dp], drift(ndim) = [0.03_dp, 0.02_dp], rate = 0.1_dp
      real(dp) :: momentum(ndim), before, spin, scale, x(ndim), noise(ndim)
      integer :: i, steps
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [16, 14]), neo_hookean, &
                        [rectangle_t(centre - [0.3_dp, 0.25_dp], centre + [0.3_dp, 0.25_dp], [12, 10])], m)
      steps = merge(20, 400, scheme == 'usl')
      spin = 0
      associate (p => m%particles)
         do i = 1, p%n
            x = p%position(i) - centre
            call random_number(noise)
            p%velocity(i, :) = drift + rate*[-x(2), x(1)] + 0.005_dp*(noise - 0.5_dp)
            spin = spin + p%mass(i)*rate*sum(x**2)
         end do
         call start(m, scheme)
         momentum = linear_momentum(p)
         before = angular_momentum(p)
         scale = sum(p%mass*norm2(p%velocity, 2))
         call run_steps(m, 0.2_dp*cell, steps)
         call check_close(maxval(abs(linear_momentum(p) - momentum)), 0.0_dp, 4*(steps + p%n)*epsilon(scale)*scale, &
                          scheme//': the linear momentum of a free body is conserved')
         write (*, '(2a,i0,a,es9.1)') scheme, ': change of angular momentum in ', steps, ' steps, over the spin', &
            (angular_momentum(p) - before)/spin
         p%velocity = 0
         call run_steps(m, 1.0e-9_dp*cell, 1)
         call check_close(sum(m%fields%mass_matrix%lumped), sum(p%mass), 1.0e-13_dp*sum(p%mass), &
                          scheme//': the grid has the mass of the particles, and no other')
      end associate
   end subroutine momentum_of_a_free_body

   !> Two bodies anywhere on the grid that move over many cells: each keeps its velocity, and no strain arises. Plain USL
   !> is left out: at edges that leave the cell lines it blows up what rounding begins.
   subroutine rigid_translation(scheme)
      character(*), intent(in) :: scheme
      type(problem_t) :: m
      real(dp), parameter :: v(ndim, 2) = reshape([0.11_dp, 0.07_dp, 0.13_dp, 0.05_dp], [ndim, 2])
      real(dp), parameter :: rounding = 1.0e-14_dp
      integer, parameter :: steps = 300
      real(dp) :: dt, change, shift
      integer :: i
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [25, 10]), neo_hookean, &
                        [rectangle_t([0.123_dp, 0.057_dp], [0.456_dp, 0.311_dp], [7, 5], v(:, 1)), &
                         rectangle_t([1.029_dp, 0.217_dp], [1.411_dp, 0.457_dp], [7, 5], v(:, 2))], m)
      call start(m, scheme)
      dt = 0.2_dp*cell
      call run_steps(m, dt, steps)
      associate (p => m%particles)
         change = 0
         shift = 0
         do i = 1, p%n
            change = max(change, maxval(abs(p%velocity(i, :) - v(:, p%body(i)))))
            shift = max(shift, maxval(abs(p%displacement(i, :) - steps*dt*v(:, p%body(i)))))
         end do
         write (*, '(2a,2es9.1)') scheme, ': translation over 6 cells: change of velocity, H', change, maxval(abs(p%gradient))
         if (scheme == 'usl') return
         call check_close(change, 0.0_dp, rounding, scheme//': a rigid translation keeps its velocity')
         call check_close(shift, 0.0_dp, rounding, scheme//': every particle moves by v t')
         call check_close(maxval(abs(p%gradient)), 0.0_dp, rounding, scheme//': no strain arises')
      end associate
   end subroutine rigid_translation

   !> A strained body that is given the velocity field A x: F = I + H becomes (I + A dt) F in one step, exactly, and
   !> (I + A dt / 2)**2 F where it is updated in two halves.
   subroutine uniform_strain_rate(scheme)
      character(*), intent(in) :: scheme
      type(problem_t) :: m
      real(dp), parameter :: a(ndim, ndim) = reshape([0.03_dp, -0.02_dp, 0.05_dp, 0.01_dp], [ndim, ndim])
      real(dp), parameter :: lower(ndim) = [0.333_dp, 0.371_dp], upper(ndim) = lower + 1.2_dp, edge = 0.45_dp
      real(dp), parameter :: h(ndim, ndim) = reshape([0.1_dp, 0.3_dp, -0.2_dp, -0.05_dp], [ndim, ndim])
      real(dp) :: dt, expected(ndim, ndim), error
      integer :: i, inside
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [19, 19]), neo_hookean, [rectangle_t(lower, upper, [24, 24])], m)
      dt = 0.2_dp*cell
      expected = matmul(identity + dt*a, identity + h) - identity
      if (scheme == 'usavg') expected = expected + dt**2/4*matmul(matmul(a, a), identity + h)
      error = 0
      inside = 0
      associate (p => m%particles)
         do i = 1, p%n
            p%velocity(i, :) = matmul(a, p%position(i))
            p%gradient(i, :, :) = h
         end do
         call start(m, scheme)
         call run_steps(m, dt, 1)
         do i = 1, p%n
            if (any(p%reference(i, :) < lower + edge .or. p%reference(i, :) > upper - edge)) cycle
            inside = inside + 1
            error = max(error, maxval(abs(p%gradient(i, :, :) - expected)))
         end do
      end associate
      call check(inside == 36, scheme//': there is material away from the edges')
      call check_close(error, 0.0_dp, 1.0e-15_dp, scheme//': a uniform velocity gradient strains uniformly')
   end subroutine uniform_strain_rate

   !> A step that maps the particles anew does what one does that finds them mapped at the end of the step before.
   subroutine fresh_start(scheme)
      character(*), intent(in) :: scheme
      type(problem_t) :: m, anew
      integer :: step
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [10, 10]), neo_hookean, &
                        [rectangle_t([0.3_dp, 0.3_dp], [0.7_dp, 0.6_dp], [8, 6])], m)
      call random_number(m%particles%velocity)
      m%particles%velocity = 0.01_dp*m%particles%velocity
      call start(m, scheme)
      anew = m
      do step = 1, 20
         call run_steps(m, 0.2_dp*cell, 1)
         anew%cache%mapped = .false.
         call run_steps(anew, 0.2_dp*cell, 1)
      end do
      call check(all(transfer(m%particles%velocity, [0]) == transfer(anew%particles%velocity, [0])) .and. &
                 all(transfer(m%particles%gradient, [0]) == transfer(anew%particles%gradient, [0])), &
                 scheme//': a run goes on with the same bytes from any of its states')
   end subroutine fresh_start

   subroutine time_step()
      type(problem_t) :: m
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [4, 4]), linear, &
                        [rectangle_t([0.1_dp, 0.1_dp], [0.3_dp, 0.3_dp], [4, 4])], m)
      m%materials = [linear, new_material('', 'linear_elastic', .true., 4.0_dp, 0.3_dp, 1.0_dp)]
      call check_close(stable_time_step(cell, m%materials, 0.1_dp, 'shear'), 0.1_dp*cell/sqrt(4/2.6_dp), 1.0e-16_dp, &
                       'the fastest material decides the time step, by its shear waves')
      call check_close(stable_time_step(cell, m%materials, 0.1_dp, 'dilatational'), 0.1_dp*cell/sqrt(4/0.91_dp), 1.0e-16_dp, &
                       'or by its dilatational waves')
   end subroutine time_step

   subroutine too_fast()
      type(problem_t) :: m
      type(failure_t) :: failure
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [20, 4]), linear, &
                        [rectangle_t([0.1_dp, 0.1_dp], [0.3_dp, 0.3_dp], [4, 4], [30.0_dp, 0.0_dp])], m)
      call start(m, 'musl')
      call advance(m, cell/10, failure)
      call check(failure%code == exit_computation, 'a body that moves by more than a cell in a step is a failure')
      call check(index(failure%message, 'step 1,') > 0 .and. index(failure%message, '(0.125, 0.125) m') > 0 .and. &
                 index(failure%message, '&method courant') > 0, 'that names step, place and cause')

      failure = failure_t()
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [4, 4]), linear, &
                        [rectangle_t([0.1_dp, 0.1_dp], [0.3_dp, 0.3_dp], [4, 4], [1.0_dp, 0.0_dp])], m)
      call start(m, 'musl')
      do while (.not. failure%failed() .and. m%state%steps < 100)
         call advance(m, cell/10, failure)
      end do
      call check(index(failure%message, 'left the grid') > 0, 'so is one that leaves the grid')
   end subroutine too_fast
end program test_step
