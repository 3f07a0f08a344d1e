!> An elastic wave along a bar against d'Alembert: a Gaussian pulse, its two halves running apart, its reflection at a free
!> and at a fixed end.
!>
!> The schemes keep velocity and strain at different times, like leapfrog. With the strain updated last (usl, musl), v is
!> that of half a step before H; with the strain updated first (usf), v is that of half a step after H; with two halves
!> (usavg), both belong to the same time. Taken at their own times, in the initial state and in the comparison, the errors
!> are of second order in the cell size at a fixed Courant number; taken at the same time they would be of first order.
program test_wave
   use hampm_kinds, only: dp
   use hampm_constraints, only: constrain_box
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps
   implicit none

   real(dp), parameter :: amplitude = 1.0e-6_dp   !! of the velocity [m/s]; the bar has length 1 and wave speed 1
   real(dp), parameter :: width = 0.04_dp         !! standard deviation of the pulse [m]
   integer, parameter :: cells(3) = [75, 150, 300]
   integer :: k

   do k = 1, size(schemes)
      call study(trim(schemes(k)), 'two halves      ', 0.5_dp, 0.0_dp, 0.35_dp)
      call study(trim(schemes(k)), 'free end        ', 0.6_dp, 1.0_dp, 0.8_dp)
      call study(trim(schemes(k)), 'fixed end       ', 0.6_dp, -1.0_dp, 0.8_dp)
   end do
   call finish()

contains

   !> Errors and order for a pulse that starts at `place`. `mirror` is 0 for a pulse that stands still at first, 1 and -1
   !> for one that runs to the right, to an end that is free or fixed.
   subroutine study(scheme, what, place, mirror, time)
      character(*), intent(in) :: scheme, what
      real(dp), intent(in) :: place, mirror, time
      real(dp) :: error(3), order(2)
      integer :: n
      do n = 1, 3
         error(n) = wave_error(scheme, cells(n), place, mirror, time)
      end do
      order = log(error(:2)/error(2:))/log(2.0_dp)
      write (*, '(a,t7,2a,3es9.1,a,2f6.2)') scheme, what, ': L2 error with 3, 6, 12 cells per width', error, '  order', order
      call check_close(order(2), 2.0_dp, 0.15_dp, scheme//', '//trim(what)//': second order')
      call check(error(3) < 0.03_dp, scheme//', '//trim(what)//': the wave is the one of d''Alembert')
   end subroutine study

   !> L2 norm of the error of the velocity over that of the velocity.
   real(dp) function wave_error(scheme, n_cells, place, mirror, time)
      character(*), intent(in) :: scheme
      integer, intent(in) :: n_cells
      real(dp), intent(in) :: place, mirror, time
      real(dp), parameter :: courant = 0.5_dp
      type(problem_t) :: m
      real(dp) :: cell, dt, v_time, h_time, expected
      real(dp) :: square(2)
      integer :: i, steps
      cell = 1.0_dp/n_cells
      steps = nint(time*n_cells/courant)
      dt = time/steps
      v_time = 0
      h_time = 0
      if (scheme == 'usl' .or. scheme == 'musl') v_time = -dt/2
      if (scheme == 'usf') h_time = -dt/2
      call place_bodies(forest_t([-cell, -cell], cell, [n_cells + 2, 3]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.0_dp, 1.0_dp), &
                        [rectangle_t([0.0_dp, 0.0_dp], [1.0_dp, cell], [2*n_cells, 1])], m)
      call constrain_box(m%constraints, m%grid, [-cell, -cell], [1 + cell, 2*cell], [.false., .true.])
      if (mirror < 0) call constrain_box(m%constraints, m%grid, [1.0_dp, -cell], [1 + cell, 2*cell], [.true., .false.])
      associate (p => m%particles)
         do i = 1, p%n
            p%velocity(i, 1) = velocity(p%reference(i, 1), v_time, place, mirror)
            p%gradient(i, 1, 1) = strain(p%reference(i, 1), h_time, place, mirror)
         end do
         call start(m, scheme)
         call run_steps(m, dt, steps)
         square = 0
         do i = 1, p%n
            expected = velocity(p%reference(i, 1), time + v_time, place, mirror)
            square = square + [(p%velocity(i, 1) - expected)**2, expected**2]
         end do
      end associate
      wave_error = sqrt(square(1)/square(2))
   end function wave_error

   !> Velocity of d'Alembert's solution. The end at x = 1 sends back the pulse that would come from its mirror image, with
   !> the same velocity where it is free and with the opposite one where it is fixed.
   pure real(dp) function velocity(x, t, place, mirror)
      real(dp), intent(in) :: x, t, place, mirror
      if (abs(mirror) > 0) then
         velocity = pulse(x - place - t) + mirror*pulse(x - (2 - place) + t)
      else
         velocity = (pulse(x - place - t) + pulse(x - place + t))/2
      end if
   end function velocity

   !> Strain of the same solution: minus the velocity of what runs to the right, plus that of what runs to the left.
   pure real(dp) function strain(x, t, place, mirror)
      real(dp), intent(in) :: x, t, place, mirror
      if (abs(mirror) > 0) then
         strain = -pulse(x - place - t) + mirror*pulse(x - (2 - place) + t)
      else
         strain = (-pulse(x - place - t) + pulse(x - place + t))/2
      end if
   end function strain

   pure real(dp) function pulse(x)
      real(dp), intent(in) :: x
      pulse = amplitude*exp(-min(0.5_dp*(x/width)**2, 600.0_dp))
   end function pulse
end program test_wave
