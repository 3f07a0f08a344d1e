!> A rectangle has its own mass wherever it lies on the grid.
program test_bodies
   use hampm_kinds, only: dp, ndim
   use hampm_bodies, only: points_along, fill_rectangle
   use hampm_failure, only: failure_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_particles, only: particles_t, new_particles
   use hampm_thickness, only: thickness_t
   implicit none

   real(dp), parameter :: thickness = 0.02_dp, density = 2700.0_dp, cell = 0.1_dp
   type(particles_t) :: p
   type(failure_t) :: failure
   integer :: k
   real(dp) :: lower(ndim), extent(ndim)

   call repeat_random_numbers()
   call check(all(points_along([0.0_dp, 0.0_dp], [0.4_dp, 0.1_dp], cell, 2) == [8, 2]), 'points per cell and direction')
   call check(all(points_along([0.03_dp, 0.0_dp], [0.43_dp, 0.1_dp], cell, 3) == [12, 3]), 'wherever the body begins')
   call check(all(points_along([0.0_dp, 0.0_dp], [0.4_dp, 0.001_dp], cell, 2) == [8, 1]), 'a thin body has one row')
   do k = 1, 50
      call random_number(lower)
      call random_number(extent)
      call fill_and_check(lower, lower + extent + 0.01_dp, 1 + mod(k, 4))
   end do
   call finish()

contains

   subroutine fill_and_check(lower, upper, points_per_cell)
      real(dp), intent(in) :: lower(ndim), upper(ndim)
      integer, intent(in) :: points_per_cell
      real(dp) :: mass, centre(ndim)
      integer :: n(ndim), total, d, i
      n = points_along(lower, upper, cell, points_per_cell)
      total = product(n)
      call new_particles(total, p, failure)
      call fill_rectangle(p, 1, n, lower, upper, thickness_t(thickness), density, [1.0_dp, 2.0_dp], 3, 4)
      mass = density*thickness*product(upper - lower)
      call check_close(sum(p%mass)/mass, 1.0_dp, total*epsilon(mass), 'mass = density area thickness')
      call check_close(sum(p%volume)/(mass/density), 1.0_dp, total*epsilon(mass), 'volume = area thickness')
      do d = 1, ndim
         centre(d) = sum(p%mass*p%reference(:, d))/mass
      end do
      call check_close(maxval(abs(centre - (lower + upper)/2)), 0.0_dp, total*epsilon(mass), 'the centre of mass is the middle')
      call check(all([(all(p%reference(i, :) > lower .and. p%reference(i, :) < upper), i=1, total)]), &
                 'all points lie inside')
      call check(all(p%material == 3) .and. all(p%body == 4) .and. all(p%id == [(i, i=1, total)]), &
                 'every point knows its material, its body and its number')
      call check(maxval(abs(p%velocity(:, 1) - 1)) <= 0 .and. maxval(abs(p%velocity(:, 2) - 2)) <= 0, &
                 'every point moves with the body')
   end subroutine fill_and_check
end program test_bodies
