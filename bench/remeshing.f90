!> How long a new mesh takes to have the interface points of a crack, with the state of those of the mesh before, by their number: a strip with
!> a slanted crack whose faces may touch, in cells of 1 and then of 0.75. Prints points, seconds of the
!> processor and microseconds a point.
!>
!>    make build/release/remeshing && build/release/remeshing [largest number of points]
program remeshing
   use hampm_kinds, only: dp
   use hampm_failure, only: failure_t
   use hampm_interface_placement, only: rebuild_interfaces
   use hampm_interface_points, only: interfaces_t
   use hampm_model, only: model_t
   use hampm_program, only: end_program
   use hampm_reading, only: understand_model
   use hampm_simulation, only: simulation_t, build
   use hampm_text, only: string_t, to_text
   use hampm_threads, only: use_threads
   implicit none
   character(20) :: argument
   integer :: n, most

   most = 100000
   call get_command_argument(1, argument)
   if (argument /= '') read (argument, *) most
   call use_threads(1, 0)
   n = 1000
   do while (n <= most)
      call remesh(n)
      n = 10*n
   end do

contains

   !> Build both meshes, and let the second take over the points of the first.
   subroutine remesh(points)
      integer, intent(in) :: points
      type(simulation_t) :: before, after
      type(interfaces_t) :: interfaces
      real(dp) :: from, to
      call build_strip(points/4, 1.0_dp, before)
      call build_strip(points/4, 0.75_dp, after)
      interfaces = before%problem%interfaces
      call cpu_time(from)
      call rebuild_interfaces(interfaces, after%problem%matter_t, after%problem%constraints)
      call cpu_time(to)
      print '(i8, f10.4, f10.2)', interfaces%n, to - from, 1e6_dp*(to - from)/interfaces%n
   end subroutine remesh

   !> A strip of a length, with cells of a size.
   subroutine build_strip(length, cell, s)
      integer, intent(in) :: length
      real(dp), intent(in) :: cell
      type(simulation_t), intent(out) :: s
      type(string_t) :: overrides(0)
      type(model_t) :: model
      type(failure_t) :: failure
      call understand_model('remeshing', &
                            "&run end_time = 1.0 / &grid lower = 0.0, 0.0  cell = "//to_text(cell)//"  cells = "// &
                            to_text(nint(length/cell) + 1)//", "//to_text(nint(6/cell))//" / "// &
                            "&material name = 'a'  young = 1.0  poisson = 0.3  density = 1.0 / &method time = 'static' / "// &
                            "&body material = 'a'  lower = 0.0, 0.0  upper = "//to_text(length)//".0, 6.0 / "// &
                            "&crack kind = 'path'  contact = 'frictionless'  points = 2.3, 2.2, "// &
                            to_text(length - 3)//".6, 3.9 /", &
                            overrides, model, failure)
      if (.not. failure%failed()) call build(model, 1, s, failure)
      if (failure%failed()) call end_program(failure)
   end subroutine build_strip
end program remeshing
