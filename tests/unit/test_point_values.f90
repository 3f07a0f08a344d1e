!> Fits to scattered particles give the value of any quadratic polynomial at a point; where particles stand in two rows, that of any linear one, and of
!> what is quadratic along the rows.
program test_point_values
   use hampm_kinds, only: dp, ndim
   use hampm_harness, only: check_close, finish, repeat_random_numbers
   use hampm_point_values, only: surroundings_t, weights_of, quadratic_fit
   implicit none

   real(dp), parameter :: rounding = 1e-11_dp
   type(surroundings_t) :: around
   real(dp), allocatable :: weights(:)
   real(dp) :: error(3)
   integer :: k

   call repeat_random_numbers()
   error = 0
   do k = 1, 100
      call scatter(24)
      weights = weights_of(around, quadratic_fit)
      associate (x => around%from_point(1, :), y => around%from_point(2, :))
         error(1) = max(error(1), abs(sum(weights*(3 + 2*x - y + x**2 - 4*x*y + 5*y**2)) - 3))
         error(2) = max(error(2), maxval(abs(weights), mask=x**2 + y**2 >= 1))
      end associate
      around%from_point(2, :) = merge(0.25_dp, 0.75_dp, around%from_point(2, :) < 0)
      weights = weights_of(around, quadratic_fit)
      associate (x => around%from_point(1, :), y => around%from_point(2, :))
         error(3) = max(error(3), abs(sum(weights*(3 + 2*x - y + x**2 - 4*x*y)) - 3))
      end associate
   end do
   call check_close(error(1), 0.0_dp, rounding, 'quadratic polynomials are exact')
   call check_close(error(2), 0.0_dp, 0.0_dp, 'particles that are farther away than the radius have no part')
   call check_close(error(3), 0.0_dp, rounding, 'in two rows, all but the square across these is exact')
   call finish()

contains

   !> Put particles at random places in a square, some of them farther from the point than the radius.
   subroutine scatter(n)
      integer, intent(in) :: n
      if (allocated(around%from_point)) deallocate (around%from_point)
      allocate (around%from_point(ndim, n))
      call random_number(around%from_point)
      around%from_point = 2*around%from_point - 1
   end subroutine scatter
end program test_point_values
