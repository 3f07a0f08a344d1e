!> The response of a mode to a load that is linear in time, against small steps of Runge and Kutta.
program test_modal
   use hampm_kinds, only: dp
   use hampm_modal, only: response_t, respond
   use hampm_harness, only: check_close, finish
   implicit none

   real(dp), parameter :: squares(4) = [0.0_dp, 1e-6_dp, 2.0_dp, 1e4_dp]
   real(dp), parameter :: rates(6) = [0.0_dp, 1e-9_dp, 0.3_dp, 1.5_dp, 2*sqrt(2.0_dp), 40.0_dp] ! the fifth is critical of the third mode
   real(dp), parameter :: p = 1.3_dp, slope = -0.7_dp !! load, and its rate
   integer :: i, j

   do i = 1, size(squares)
      do j = 1, size(rates)
         call follows_its_equation(squares(i), rates(j))
      end do
   end do
   call finish()

contains

   !> q, its rate and its integral.
   subroutine follows_its_equation(square, alpha)
      real(dp), intent(in) :: square, alpha
      real(dp), parameter :: t = 0.9_dp, first(3) = [0.4_dp, -0.2_dp, 0.0_dp]
      integer, parameter :: steps = 20000
      real(dp), parameter :: dt = t/steps
      real(dp) :: y(3), k(3, 4)
      type(response_t) :: found
      integer :: n
      y = first
      do n = 0, steps - 1
         k(:, 1) = change(square, alpha, n*dt, y)
         k(:, 2) = change(square, alpha, (n + 0.5_dp)*dt, y + dt/2*k(:, 1))
         k(:, 3) = change(square, alpha, (n + 0.5_dp)*dt, y + dt/2*k(:, 2))
         k(:, 4) = change(square, alpha, (n + 1)*dt, y + dt*k(:, 3))
         y = y + dt/6*(k(:, 1) + 2*k(:, 2) + 2*k(:, 3) + k(:, 4))
      end do
      found = respond(square, alpha, p, slope, t, first(1), first(2))
      call check_close(found%q, y(1), 1e-9_dp, 'a mode moves by its equation')
      call check_close(found%rate, y(2), 1e-8_dp, 'so does its rate')
      call check_close(found%sum, y(3), 1e-9_dp, 'its integral is that of the motion')
   end subroutine follows_its_equation

   !> Rates of q, of its rate and of its integral.
   pure function change(square, alpha, time, y) result(rate)
      real(dp), intent(in) :: square, alpha, time, y(3)
      real(dp) :: rate(3)
      rate = [y(2), p + slope*time - alpha*y(2) - square*y(1), y(1)]
   end function change
end program test_modal
