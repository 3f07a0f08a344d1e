!> Where interface points between the faces of cracks are: all along a crack, whatever pieces of cells it leaves, on cells of several sizes.
program test_interface_points
   use hampm_kinds, only: dp, ndim
   use hampm_interface_points, only: contact
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
end program test_interface_points
