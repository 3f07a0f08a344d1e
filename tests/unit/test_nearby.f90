!> The table finds the places near another one, whatever their reaches, and compares about as many as it finds.
program test_nearby
   use hampm_kinds, only: dp, ndim
   use hampm_builds, only: is_slow
   use hampm_harness, only: check, finish, repeat_random_numbers
   use hampm_nearby, only: nearby_t
   use hampm_text, only: to_text
   implicit none

   integer :: k

   call repeat_random_numbers()
   do k = 0, 12, 4
      call random_places(k)
   end do
   do k = 3, merge(4, 5, is_slow())
      call places_on_a_line(10**k)
   end do
   call finish()

contains

   !> Places in a square with reaches over some powers of two, and beyond: found as by comparing with all.
   subroutine random_places(powers)
      integer, intent(in) :: powers
      integer, parameter :: n = 500
      real(dp) :: x(ndim, n), reach(n), other(ndim), far
      integer, allocatable :: found(:)
      type(nearby_t) :: near
      integer :: i, trial, wrong
      call random_number(x)
      call random_number(reach)
      x = x - 0.5_dp
      reach = 0.1_dp*2**(-powers*reach)
      call near%sort(x, reach)
      wrong = 0
      do trial = 1, 200
         call random_number(other)
         call random_number(far)
         far = 0.1_dp*max(0.0_dp, far - 0.5_dp)
         other = 1.2_dp*(other - 0.5_dp)
         call near%find(other, far, found)
         associate (all_near => pack([(i, i=1, n)], [(all(abs(x(:, i) - other) <= max(far, reach(i))), i=1, n)]))
            if (size(found) /= size(all_near)) then
               wrong = wrong + 1
            else if (any(found /= all_near)) then
               wrong = wrong + 1
            end if
         end associate
      end do
      call check(wrong == 0, 'all places near another one are found, in order, with reaches over 2**'//to_text(powers))
   end subroutine random_places

   !> Each place of a line has its neighbours, for as many comparisons however many places there are.
   subroutine places_on_a_line(n)
      integer, intent(in) :: n
      integer, allocatable :: found(:)
      type(nearby_t) :: near
      integer :: i, wrong, visits
      call near%sort(reshape([([real(i, dp), 0.3_dp*i], i=1, n)], [ndim, n]), [(1.5_dp, i=1, n)])
      wrong = 0
      visits = 0
      do i = 1, n
         call near%find([real(i, dp), 0.3_dp*i], 0.0_dp, found, visits)
         if (size(found) /= count([i > 1, .true., i < n])) wrong = wrong + 1
      end do
      call check(wrong == 0, 'all of '//to_text(n)//' places of a line find their neighbours')
      call check(visits <= 20*n, 'with '//to_text(visits)//' comparisons for '//to_text(n)//' places')
   end subroutine places_on_a_line
end program test_nearby
