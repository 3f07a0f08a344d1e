!> The factor of a load follows its history.
program test_time_history
   use hampm_kinds, only: dp
   use hampm_time_history, only: time_history_t
   use hampm_harness, only: check_close, finish
   implicit none

   type(time_history_t) :: step, ramp, smooth, sine, table

   step = time_history_t(kind='step', start=1.0_dp)
   call check_close(step%factor(0.999_dp), 0.0_dp, 0.0_dp, 'a step is zero before its start')
   call check_close(step%factor(1.0_dp), 1.0_dp, 0.0_dp, 'a step is one from its start on')
   call check_close(step%factor(1.0e9_dp), 1.0_dp, 0.0_dp, 'a step stays')

   ramp = time_history_t(kind='ramp', start=1.0_dp, rise_time=4.0_dp)
   call check_close(ramp%factor(0.5_dp), 0.0_dp, 0.0_dp, 'a ramp is zero before its start')
   call check_close(ramp%factor(2.0_dp), 0.25_dp, 1.0e-15_dp, 'a ramp rises in proportion to time')
   call check_close(ramp%factor(5.0_dp), 1.0_dp, 1.0e-15_dp, 'a ramp ends at one')
   call check_close(ramp%factor(50.0_dp), 1.0_dp, 0.0_dp, 'a ramp stays at one')

   smooth = time_history_t(kind='smooth_ramp', start=1.0_dp, rise_time=4.0_dp)
   call check_close(smooth%factor(0.5_dp), 0.0_dp, 0.0_dp, 'a smooth ramp is zero before its start')
   call check_close(smooth%factor(3.0_dp), 0.5_dp, 1.0e-15_dp, 'a smooth ramp is a half in its middle')
   call check_close(smooth%factor(5.0_dp), 1.0_dp, 1.0e-15_dp, 'a smooth ramp ends at one')
   call check_close(smooth%factor(50.0_dp), 1.0_dp, 0.0_dp, 'a smooth ramp stays at one')
   call ends(smooth, 1.0_dp, 'a smooth ramp begins with no rate and no change of that')
   call ends(smooth, 5.0_dp, 'a smooth ramp ends with no rate and no change of that')

   sine = time_history_t(kind='sine', start=1.0_dp, frequency=0.5_dp)
   call check_close(sine%factor(0.5_dp), 0.0_dp, 0.0_dp, 'a sine is zero before its start')
   call check_close(sine%factor(1.5_dp), 1.0_dp, 1.0e-15_dp, 'a sine is one after a quarter of its period')
   call check_close(sine%factor(2.5_dp), -1.0_dp, 1.0e-15_dp, 'a sine is minus one after three quarters')

   table = time_history_t(kind='table', start=1.0_dp, times=[0.0_dp, 1.0_dp, 3.0_dp], factors=[0.5_dp, 2.0_dp, -2.0_dp])
   call check_close(table%factor(0.999_dp), 0.0_dp, 0.0_dp, 'a table is zero before its start')
   call check_close(table%factor(1.0_dp), 0.5_dp, 1.0e-15_dp, 'a table begins with its first value')
   call check_close(table%factor(1.5_dp), 1.25_dp, 1.0e-15_dp, 'a table is linear between its times')
   call check_close(table%factor(2.0_dp), 2.0_dp, 1.0e-15_dp, 'a table goes through its values')
   call check_close(table%factor(3.0_dp), 0.0_dp, 1.0e-15_dp, 'a table may cross zero')
   call check_close(table%factor(9.0_dp), -2.0_dp, 1.0e-15_dp, 'a table stays at its last value')
   call integrals([step, ramp, smooth, sine], 'step, ramps, sine')
   call integrals([table], 'table')
   step%start = -3
   ramp%start = -3
   smooth%start = -3
   sine%start = -3
   table%start = -2.5_dp
   call integrals([step, ramp, smooth, sine], 'begun before the run')
   call integrals([table], 'table begun before the run')
   call lines([step, ramp, smooth, sine, table], 'begun before the run')
   step%start = 1
   ramp%start = 1
   smooth%start = 1
   sine%start = 1
   table%start = 1
   call lines([step, ramp, smooth, sine, table], 'begun in the run')
   call finish()

contains

   !> First and second derivatives on both sides of a time are 0, by differences that fall with their distance from it.
   subroutine ends(history, time, name)
      type(time_history_t), intent(in) :: history
      real(dp), intent(in) :: time
      character(*), intent(in) :: name
      real(dp), parameter :: h = 1e-3_dp
      integer :: side
      do side = -1, 1, 2
         associate (at => history%factor(time), near => history%factor(time + side*h), far => history%factor(time + 2*side*h))
            call check_close((near - at)/h, 0.0_dp, 10*h**2, name)
            call check_close((far - 2*near + at)/h**2, 0.0_dp, 10*h, name)
         end associate
      end do
   end subroutine ends

   !> From corner to corner the factor is the line between its values at both ends, of which the last is taken from before a jump.
   subroutine lines(histories, name)
      type(time_history_t), intent(in) :: histories(:)
      character(*), intent(in) :: name
      real(dp), parameter :: whole = 7.3_dp
      real(dp) :: time, next, middle
      integer :: k
      do k = 1, size(histories)
         time = 0
         do while (time < whole)
            next = min(whole, histories(k)%end_of_line(time))
            middle = (histories(k)%factor(time) + histories(k)%factor(nearest(next, -1.0_dp)))/2
            call check_close(histories(k)%factor((time + next)/2), middle, merge(2e-5_dp, 1e-14_dp, k == 3 .or. k == 4), &
                             name//': the factor is a line from corner to corner')
            time = next
         end do
      end do
   end subroutine lines

   !> The integral is that of the factor, by the trapezoidal rule over short pieces, from time 0.
   subroutine integrals(histories, name)
      type(time_history_t), intent(in) :: histories(:)
      character(*), intent(in) :: name
      integer, parameter :: pieces = 20000
      real(dp), parameter :: time = 7.3_dp, dt = time/pieces
      real(dp) :: total
      integer :: i, k
      do k = 1, size(histories)
         total = 0
         do i = 1, pieces
            total = total + dt*histories(k)%factor((i - 0.5_dp)*dt)
         end do
         call check_close(histories(k)%integral(time), total, 2*dt, name//': the integral is that of the factor')
         call check_close(histories(k)%integral(0.0_dp), 0.0_dp, 0.0_dp, name//': the integral begins with the run')
      end do
   end subroutine integrals
end program test_time_history
