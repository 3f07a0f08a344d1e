!> Errors of means over hat functions along a front: what they lose of a smooth curve, and their scatter about it.
program test_hat_errors
   use hampm_kinds, only: dp
   use hampm_harness, only: check, check_close, finish
   use hampm_hat_errors, only: ends_t, lost_in_hats, scatter_along
   implicit none
   integer, parameter :: n = 24
   real(dp), parameter :: pi = acos(-1.0_dp), step = 2*pi/n, noise = 1e-2_dp
   type(ends_t), parameter :: closed = ends_t(is_closed=.true.), free = ends_t(), odd = ends_t(.false., .true., [.true., .false.])
   real(dp) :: means(n), of_sine(n/4 + 1), jumps(n)
   integer :: i

   ! The mean of a cosine over a hat is 2 (1 - cos h)/h**2 of it
   means = [(2*(1 - cos(step))/step**2*cos((i - 1)*step), i=1, n)]
   call check_close(maxval(abs(lost_in_hats(means, closed) - abs(means*(step**2/2/(1 - cos(step)) - 1)))), 0.0_dp, &
                    0.02_dp*step**2/12, 'means of a closed cosine lose a twelfth of the second difference')
   call check(maxval(scatter_along(means, closed)) < step**4, 'a smooth curve scatters by its fourth difference alone')
   jumps = means + noise*[((-1)**i, i=1, n)]
   call check(all(scatter_along(jumps, closed) > 2*noise .and. scatter_along(jumps, closed) < 4*noise + step**4), &
              'values that alternate scatter by twice their size, at least')

   ! A quarter of a sine, from its zero at a plane of symmetry to its top at another
   of_sine = [(sin((i - 1)*step), i=1, size(of_sine))]
   call check(.not. any(abs([lost_in_hats(of_sine(:1), odd), scatter_along(of_sine(:4), odd)]) > 0), 'few values tell nothing')
   associate (lost => lost_in_hats(of_sine, odd), scatter => scatter_along(of_sine, odd), whole => [sin([((i - 1)*step, i=1, n)])])
      call check(.not. lost(1) > 0, 'an odd sequence loses nothing at its zero')
      call check_close(maxval(abs(lost - spread_first(lost_in_hats(whole, closed)))), 0.0_dp, 1e-15_dp, 'mirrored ends: lost')
      call check_close(maxval(abs(scatter(2:6) - scatter_of(whole))), 0.0_dp, 1e-15_dp, 'mirrored ends: scatter')
   end associate
   associate (lost => lost_in_hats(of_sine, free), scatter => scatter_along(of_sine, free))
      call check(all(abs(lost([1, 7]) - lost([2, 6])) < epsilon(step)), 'a free end has the loss of the next hat')
      call check(all(scatter > 0) .and. maxval(scatter) < step**4, 'and the scatter of places with a difference')
   end associate
   call finish()

contains

   !> The first quarter of a closed sequence.
   pure function spread_first(values) result(first)
      real(dp), intent(in) :: values(:)
      real(dp) :: first(size(of_sine))
      first = values(:size(first))
   end function spread_first

   !> The scatter of a closed sequence within its first quarter.
   pure function scatter_of(values) result(within)
      real(dp), intent(in) :: values(:)
      real(dp) :: within(5), all_of_it(size(values))
      all_of_it = scatter_along(values, closed)
      within = all_of_it(2:6)
   end function scatter_of
end program test_hat_errors
