!> The first longitudinal vibration of a free bar against the exact solution of the discrete equations.
!>
!> With two points per cell the shape cos(pi x / L), taken at the nodes, stays what it is. Its amplitudes of velocity, A,
!> and of strain, q, obey the following, where Omega = 2 c / h sin(k h / 2) is the frequency of linear elements with a
!> lumped mass matrix and S = 1 - 3/4 sin(k h / 2)**2 what the mapping from nodes to particles and back leaves of a velocity:
!>
!>    usf, musl, usavg:  leapfrog with Omega**2 S, so sin(omega dt / 2) = Omega sqrt(S) dt / 2, without loss;
!>    usl:               strained by v + a dt of the nodes, which are not what the particles then have: the determinant
!>                       of a step is 1 - (Omega dt)**2 (1 - S), which takes energy.
program test_vibration
   use hampm_kinds, only: dp
   use hampm_basis, only: shape_functions
   use hampm_constraints, only: constrain_box
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: amplitude = 1.0e-9_dp   !! of the velocity; the bar has length 1 and wave speed 1
   real(dp), parameter :: courant = 0.5_dp
   integer, parameter :: periods = 5
   real(dp) :: error(2)
   integer :: k

   do k = 1, size(schemes)
      error = [frequency_error(trim(schemes(k)), 10), frequency_error(trim(schemes(k)), 20)]
      write (*, '(a,a,2es10.2,a,f6.2)') schemes(k), ': frequency of the bar, relative error with 10, 20 cells', error, &
         '  order', log(error(1)/error(2))/log(2.0_dp)
      call check_close(log(error(1)/error(2))/log(2.0_dp), 2.0_dp, 0.05_dp, &
                       trim(schemes(k))//': the frequency converges with second order')
   end do
   call finish()

contains

   !> Vibrate for some periods, compare every step with the discrete solution, and return how far the frequency is from
   !> c / (2 L).
   real(dp) function frequency_error(scheme, n_cells) result(error)
      character(*), intent(in) :: scheme
      integer, intent(in) :: n_cells
      type(problem_t) :: m
      real(dp) :: cell, dt, omega2, s, step(2, 2), state(2), mode, difference, cosine
      integer :: i, n, steps
      cell = 1.0_dp/n_cells
      dt = courant*cell
      call place_bodies(forest_t([-cell, -cell], cell, [n_cells + 2, 3]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.0_dp, 1.0_dp), &
                        [rectangle_t([0.0_dp, 0.0_dp], [1.0_dp, cell], [2*n_cells, 1])], m)
      call constrain_box(m%constraints, m%grid, [-cell, -cell], [1 + cell, 2*cell], [.false., .true.])
      do i = 1, m%particles%n
         m%particles%velocity(i, 1) = amplitude*cos(pi*m%particles%reference(i, 1))
      end do
      call start(m, scheme)

      omega2 = (2/cell*sin(pi*cell/2))**2
      s = 1 - 0.75_dp*sin(pi*cell/2)**2
      step = matrix_of_step(scheme, dt, omega2, s)
      state = [modal_velocity(m), 0.0_dp]
      mode = state(1)
      steps = nint(2*periods/dt)
      difference = 0
      do n = 1, steps
         call run_steps(m, dt, 1)
         state = matmul(step, state)
         difference = max(difference, abs(modal_velocity(m) - state(1)))
      end do
      call check_close(difference/mode, 0.0_dp, 1.0e-7_dp, scheme//': the bar follows the exact discrete solution')
      cosine = (step(1, 1) + step(2, 2))/2/sqrt(step(1, 1)*step(2, 2) - step(1, 2)*step(2, 1))
      error = abs(acos(cosine)/(pi*dt) - 1)
   end function frequency_error

   !> What a step does to the amplitudes of velocity and strain of the mode.
   pure function matrix_of_step(scheme, dt, omega2, s) result(step)
      character(*), intent(in) :: scheme
      real(dp), intent(in) :: dt, omega2, s
      real(dp) :: step(2, 2), kick(2, 2), strain(2, 2), half_strain(2, 2)
      kick = reshape([1.0_dp, 0.0_dp, -dt*s*omega2, 1.0_dp], [2, 2])
      strain = reshape([1.0_dp, dt, 0.0_dp, 1.0_dp], [2, 2])
      half_strain = reshape([1.0_dp, dt/2, 0.0_dp, 1.0_dp], [2, 2])
      select case (scheme)
      case ('usf')
         step = matmul(kick, strain)
      case ('musl')
         step = matmul(strain, kick)
      case ('usavg')
         step = matmul(half_strain, matmul(kick, half_strain))
      case default
         step = reshape([1.0_dp, dt, -dt*s*omega2, 1 - dt**2*omega2], [2, 2])
      end select
   end function matrix_of_step

   !> Amplitude of the mode in the momentum of the nodes.
   real(dp) function modal_velocity(m)
      type(problem_t), intent(in) :: m
      real(dp) :: n(4), x
      integer :: i, e
      modal_velocity = 0
      associate (p => m%particles, grid => m%grid)
         do i = 1, p%n
            e = p%cell(i)
            x = grid%element_lower(1, e)
            n = shape_functions(grid%local_coordinate(e, p%position(i)))
            modal_velocity = modal_velocity + p%mass(i)*p%velocity(i, 1) &
                             *((n(1) + n(3))*cos(pi*x) + (n(2) + n(4))*cos(pi*(x + grid%element_size(e))))
         end do
      end associate
   end function modal_velocity
end program test_vibration
