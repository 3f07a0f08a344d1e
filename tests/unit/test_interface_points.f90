!> Where interface points between the faces of cracks are: all along a crack, whatever pieces of cells it leaves, on cells of several sizes; and what
!> those of another mesh take over from them, in a time that grows as their number.
program test_interface_points
   use hampm_kinds, only: dp, ndim
   use hampm_builds, only: is_slow
   use hampm_interface_points, only: interfaces_t, contact, add_interface_point
   use hampm_interface_transfer, only: transfer_points
   use hampm_nearby, only: nearby_t
   use hampm_failure, only: failure_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_reading, only: understand_model
   use hampm_model, only: model_t
   use hampm_simulation, only: simulation_t, build
   use hampm_text, only: string_t, to_text
   use hampm_threads, only: use_threads
   implicit none

   integer :: k

   call repeat_random_numbers()
   call use_threads(1, 0)
   do k = 1, 20
      call look_at_crack(k)
   end do
   do k = 3, merge(4, 5, is_slow())
      call carry_over(10**k)
   end do
   call finish()

contains

   !> A crack somewhere in a plate with three sizes of cells: its interface points stand for the whole of it. Quarters of cells beside finer ones without a
   !> particle had none, up to 5 % of a crack.
   subroutine look_at_crack(number)
      integer, intent(in) :: number
      real(dp), parameter :: pi = acos(-1.0_dp), half = 8
      type(string_t) :: overrides(0)
      type(model_t) :: model
      type(simulation_t) :: s
      type(failure_t) :: failure
      real(dp) :: angle, x(ndim), ends(2*ndim)
      call random_number(angle)
      call random_number(x)
      ends = [x - half*[cos(pi*angle), sin(pi*angle)], x + half*[cos(pi*angle), sin(pi*angle)]]
      call understand_model('test_face_springs', &
                            "&run end_time = 1.0 / &grid lower = -16.0, -16.0  cell = 1.0  cells = 32, 32 / "// &
                            "&material name = 'a'  young = 1.0  poisson = 0.3  density = 1.0 / "// &
                            "&body material = 'a'  lower = -15.0, -15.0  upper = 15.0, 15.0 / &method time = 'static' / "// &
                            "&refine indicator = 'tip'  max_level = 2  rings = 4 / "// &
                            "&crack kind = 'path'  contact = 'frictionless'  points = "// &
                            to_text(ends(1))//', '//to_text(ends(2))//', '//to_text(ends(3))//', '//to_text(ends(4))//' /', &
                            overrides, model, failure)
      if (.not. failure%failed()) call build(model, 1, s, failure)
      call check(.not. failure%failed(), 'scene '//to_text(number)//' is built')
      if (failure%failed()) return
      associate (interfaces => s%problem%interfaces)
         call check_close(sum(interfaces%list(:interfaces%n)%length, mask=interfaces%list(:interfaces%n)%law == contact), &
                          2*half, 1e-6_dp, &
                          'springs stand for all of crack '//to_text(number))
      end associate
   end subroutine look_at_crack
   !> Open faces on n points: on a mesh with other cells their opening is between that of the points beside each, and no point is compared with more
   !> than those nearby.
   subroutine carry_over(n)
      integer, intent(in) :: n
      real(dp), parameter :: ratio = 0.7_dp
      type(interfaces_t) :: old, new
      type(nearby_t) :: near
      real(dp) :: off
      integer :: k, visits
      call line_of_points(old, 1.0_dp, n)
      call line_of_points(new, ratio, n)
      do k = 1, n
         old%list(k)%opening = opening_at(old%list(k)%place)
      end do
      visits = 0
      call transfer_points(new, old, near, visits)
      off = maxval([(maxval(abs(new%list(k)%opening - opening_at(new%list(k)%place))), k=2, n)])
      call check(off <= 1e-9_dp*n, 'the opening of '//to_text(n)//' points is that between old ones')
      call check(visits <= 60*n, 'for '//to_text(visits)//' comparisons of '//to_text(n)//' points')
      near = nearby_t()
      visits = 0
      call line_of_points(new, 1.0_dp, n)
      call transfer_points(new, old, near, visits)
      off = maxval([(maxval(abs(new%list(k)%opening - old%list(k)%opening)), k=1, n)])
      call check(off <= 1e-9_dp*n .and. visits == 0, 'points that follow each other as before are not searched for')
   end subroutine carry_over

   !> Points for contact along a line.
   subroutine line_of_points(interfaces, distance, n)
      type(interfaces_t), intent(out) :: interfaces
      real(dp), intent(in) :: distance
      integer, intent(in) :: n
      real(dp), parameter :: direction(ndim) = [0.8_dp, 0.6_dp]
      integer :: k
      do k = 1, n
         call add_interface_point(interfaces, contact)
         associate (point => interfaces%list(k))
            point%place = (k - 0.5_dp)*distance*direction
            point%origin = point%place
            point%normal = [-direction(2), direction(1)]
            point%length = distance
            point%area = distance
            point%cell = 2*distance
            point%stiffness = 1
            point%line = 1
         end associate
      end do
   end subroutine line_of_points

   !> An opening that grows along the line of points.
   pure function opening_at(place) result(opening)
      real(dp), intent(in) :: place(ndim)
      real(dp) :: opening(ndim)
      opening = [-0.5_dp, 1.0_dp]*(1 + dot_product(place, [0.8_dp, 0.6_dp]))
   end function opening_at
end program test_interface_points
