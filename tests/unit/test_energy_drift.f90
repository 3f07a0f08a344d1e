!> The energy of a free bar in its first longitudinal vibration over many periods, at rest on the grid and drifting
!> through the cells.
!>
!> At rest the step of usf, usavg and musl is leapfrog (see `test_vibration`): over whole periods its mean energy does not
!> drift, which is asserted for 1000 periods at a Courant number of 1/2. usl loses energy; that it does is asserted.
!> Drifting at a Courant number of 1/10, every cell that a particle enters changes its weights and disturbs the bar. Over
!> 100 periods and 40 cells usf gains energy, musl loses it and usavg, between them, keeps it (Bardenhagen 2002; Nairn
!> 2003): asserted is this, and that no scheme gains more than a few times what there was. usl is left out: its free edges
!> break up.
program test_energy_drift
   use hampm_kinds, only: dp
   use hampm_constraints, only: constrain_box
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps, total_energy
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp)
   integer, parameter :: n_cells = 4              !! along the bar, which has length 1 and wave speed 1
   real(dp), parameter :: amplitude = 1.0e-6_dp   !! of the velocity
   integer, parameter :: averaged = 10            !! periods
   integer :: k

   write (*, '(a)') 'change of the energy at rest after     10            100           1000 periods'
   do k = 1, size(schemes)
      call is_static(trim(schemes(k)))
   end do
   write (*, '(a)') 'change of the energy drifting after    10            100 periods'
   do k = 1, size(schemes)
      if (schemes(k) /= 'usl') call drifting(trim(schemes(k)))
   end do
   call finish()

contains

   subroutine is_static(scheme)
      character(*), intent(in) :: scheme
      real(dp) :: change(3)
      change = energy_change(scheme, 0.0_dp, 16, [10, 100, 1000])
      write (*, '(a,t31,3es15.1)') scheme, change
      if (scheme == 'usl') then
         call check(change(3) < -0.5_dp, 'usl takes energy')
      else
         call check_close(change(3), 0.0_dp, 1.0e-6_dp, scheme//': the energy does not drift')
      end if
   end subroutine is_static

   subroutine drifting(scheme)
      character(*), intent(in) :: scheme
      real(dp) :: change(2)
      change = energy_change(scheme, 0.05_dp, 80, [10, 100])
      write (*, '(a,t31,3es15.1)') scheme, change
      select case (scheme)
      case ('usavg')
         call check_close(change(2), 0.0_dp, 0.01_dp, 'usavg keeps the energy of a drifting bar')
      case ('musl')
         call check(change(2) < 0 .and. change(2) > -1, 'musl takes energy from a drifting bar')
      case default
         call check(abs(change(2)) < 5, 'usf keeps the energy of a drifting bar bounded')
      end select
   end subroutine drifting

   !> Change of the energy of vibration up to some periods, relative to that in the first periods. The time step is such
   !> that a period of the discrete equations is a whole number of steps.
   function energy_change(scheme, speed, steps_a_period, periods) result(change)
      character(*), intent(in) :: scheme
      real(dp), intent(in) :: speed              !! of the bar over the grid
      integer, intent(in) :: steps_a_period
      integer, intent(in) :: periods(:)          !! ascending
      real(dp) :: change(size(periods))
      type(problem_t) :: m
      real(dp), parameter :: cell = 1.0_dp/n_cells, half = sin(pi*cell/2)
      real(dp) :: dt, first
      integer :: i, k, passed
      dt = sin(pi/steps_a_period)*cell/(half*sqrt(1 - 0.75_dp*half**2))
      passed = ceiling(speed*dt*steps_a_period*(maxval(periods) + averaged)/cell)
      call place_bodies(forest_t([-cell, -cell], cell, [n_cells + 3 + passed, 3]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.0_dp, 1.0_dp), &
                        [rectangle_t([0.0_dp, 0.0_dp], [1.0_dp, cell], [2*n_cells, 1])], m)
      call constrain_box(m%constraints, m%grid, [-cell, -cell], [1.0e3_dp, 2*cell], [.false., .true.])
      do i = 1, m%particles%n
         m%particles%velocity(i, 1) = speed + amplitude*cos(pi*m%particles%reference(i, 1))
      end do
      call start(m, scheme)
      first = mean_energy(m, dt, averaged*steps_a_period)
      do k = 1, size(periods)
         call run_steps(m, dt, periods(k)*steps_a_period - int(m%state%steps))
         change(k) = mean_energy(m, dt, averaged*steps_a_period) - first
      end do
      change = change/(first - 0.5_dp*sum(m%particles%mass)*speed**2)
   end function energy_change

   !> Mean of the energy over the next steps [J].
   real(dp) function mean_energy(m, dt, steps)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt
      integer, intent(in) :: steps
      integer :: n
      mean_energy = 0
      do n = 1, steps
         mean_energy = mean_energy + total_energy(m)
         call run_steps(m, dt, 1)
      end do
      mean_energy = mean_energy/steps
   end function mean_energy
end program test_energy_drift
