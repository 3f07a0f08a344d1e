!> Loads keep their resultant and their moment however they, the deformed body and the cells lie to each other.
program test_loads
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_time_history, only: time_history_t
   use loading, only: load_on_points
   use hampm_loads, only: load_t, load_on_particles, place_loads, add_loads, book_work, follow_sort, &
                           all_become_constant, time_to_constant_value
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, place_bodies
   use hampm_sorting, only: sort_into_cells
   use hampm_tensors, only: identity
   implicit none

   real(dp), parameter :: cell = 0.1_dp, force(ndim) = [3.0_dp, -7.0_dp]
   real(dp), parameter :: lower(ndim) = [0.3_dp, 0.3_dp], upper(ndim) = [0.7_dp, 0.5_dp]
   real(dp), parameter :: rounding = 1.0e-13_dp
   integer :: k
   real(dp) :: shift(ndim)

   call repeat_random_numbers()
   do k = 1, 20
      call random_number(shift)
      call traction_on_edge(cell*shift)
      call body_force(cell*shift)
      call work_of_loads(cell*shift)
   end do
   call nearest_particle()
   call loads_that_settle()
   call finish()

contains

   !> A body on a grid that is shifted against it.
   subroutine place(shift, m)
      real(dp), intent(in) :: shift(ndim)
      type(problem_t), intent(out) :: m
      call place_bodies(forest_t(-shift, cell, [14, 12]), new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 2.0_dp), &
                        [rectangle_t(lower, upper, [9, 5])], m)
   end subroutine place

   !> A ramp settles when it has risen, a table at its last time, a sine never.
   subroutine loads_that_settle()
      type(load_t) :: loads(3)
      loads(1)%history = time_history_t(kind='ramp', start=1.0_dp, rise_time=4.0_dp)
      loads(2)%history = time_history_t(kind='sine', start=9.0_dp, frequency=1.0_dp)
      loads(3)%history = time_history_t(kind='table', start=1.0_dp, times=[0.0_dp, 5.0_dp], factors=[0.0_dp, 1.0_dp])
      call check(all_become_constant(loads(:0)) .and. all_become_constant(loads(1::2)), 'loads settle')
      call check(.not. all_become_constant(loads(:2)), 'a sine never settles')
      call check_close(time_to_constant_value(loads(:0)), 0.0_dp, 0.0_dp, 'without loads all is settled at the start')
      call check_close(time_to_constant_value(loads(:2)), 5.0_dp, 0.0_dp, &
                       'settled: when the ramp has risen, without a look at the sine')
      call check_close(time_to_constant_value(loads), 6.0_dp, 0.0_dp, 'settled: with the last load')
   end subroutine loads_that_settle

   !> Places at the centres of equal parts of the right edge of the body.
   pure function edge_places() result(x)
      integer, parameter :: n = 7
      real(dp) :: x(ndim, n)
      integer :: i
      do i = 1, n
         x(:, i) = [upper(1), lower(2) + (i - 0.5_dp)/n*(upper(2) - lower(2))]
      end do
   end function edge_places

   !> Move the body by u = b + A X, a stretch and a rotation of 40 degrees, and sort its particles.
   subroutine deform(m, b, a)
      type(problem_t), intent(inout) :: m
      real(dp), intent(out) :: b(ndim), a(ndim, ndim)
      real(dp), parameter :: angle = 0.7_dp
      type(failure_t) :: failure
      integer :: i
      a = reshape([1.1_dp*cos(angle), 1.1_dp*sin(angle), -0.95_dp*sin(angle), 0.95_dp*cos(angle)], [ndim, ndim]) - identity
      b = [0.26_dp, -0.19_dp]
      do i = 1, m%particles%n
         m%particles%displacement(i, :) = b + matmul(a, m%particles%reference(i, :))
         m%particles%gradient(i, :, :) = a
      end do
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      call follow_sort(m%loads, m%cache%sorting%new_place)
      call check(.not. failure%failed(), 'the deformed body is in the grid')
   end subroutine deform

   !> The nodal forces have the resultant `force` and the moment of that force at `centre`.
   subroutine check_resultant(m, time, centre, expected, what)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: time, centre(ndim), expected(ndim)
      character(*), intent(in) :: what
      real(dp) :: f(ndim, m%grid%n_nodes), moment
      f = 0
      call place_loads(m%loads, m%grid, m%particles)
      call add_loads(m%loads, time, f)
      moment = sum(m%grid%node_position(1, :)*f(2, :) - m%grid%node_position(2, :)*f(1, :))
      call check_close(maxval(abs(sum(f, dim=2) - expected)), 0.0_dp, rounding*norm2(force), what//': resultant')
      call check_close(moment, centre(1)*expected(2) - centre(2)*expected(1), rounding*norm2(force), what//': moment')
      call add_loads(m%loads, time, f)
      call check_close(maxval(abs(sum(f, dim=2) - 2*expected)), 0.0_dp, rounding*norm2(force), what//': added to what is there')
   end subroutine check_resultant

   subroutine traction_on_edge(shift)
      real(dp), intent(in) :: shift(ndim)
      type(problem_t) :: m
      real(dp) :: centre(ndim), b(ndim), a(ndim, ndim)
      call place(shift, m)
      allocate (m%loads(1))
      m%loads(1)%force = force
      m%loads(1)%history = time_history_t(kind='ramp', rise_time=2.0_dp)
      call load_on_points(m%matter_t, edge_places(), [0.0_dp, 0.0_dp], m%loads(1))
      centre = [upper(1), (lower(2) + upper(2))/2]
      call check_resultant(m, 2.0_dp, centre, force, 'traction on the edge')
      call check_resultant(m, 0.5_dp, centre, 0.25_dp*force, 'traction while it rises')
      call deform(m, b, a)
      call check_resultant(m, 2.0_dp, centre + b + matmul(a, centre), force, 'traction on the deformed edge')
   end subroutine traction_on_edge

   subroutine body_force(shift)
      real(dp), intent(in) :: shift(ndim)
      type(problem_t) :: m
      real(dp) :: centre(ndim), b(ndim), a(ndim, ndim)
      call place(shift, m)
      allocate (m%loads(1))
      m%loads(1)%force = force
      call load_on_particles(m%particles, lower, upper, m%loads(1))
      call check(size(m%loads(1)%particle) == m%particles%n, 'a body force acts on all particles in its box')
      centre = (lower + upper)/2
      call check_resultant(m, 0.0_dp, centre, force, 'body force')
      call deform(m, b, a)
      call check_resultant(m, 0.0_dp, centre + b + matmul(a, centre), force, 'body force on the deformed body')
   end subroutine body_force

   !> Two loads: where all move alike their work is the mean of the forces at both ends times the way.
   subroutine work_of_loads(shift)
      real(dp), intent(in) :: shift(ndim)
      type(problem_t) :: m
      real(dp), parameter :: velocity(ndim) = [0.3_dp, 0.4_dp], dt = 0.1_dp
      real(dp) :: work
      call place(shift, m)
      allocate (m%loads(2))
      m%loads(1)%force = force
      m%loads(1)%history = time_history_t(kind='ramp', rise_time=2.0_dp)
      m%loads(2)%force = -3*force
      call load_on_points(m%matter_t, edge_places(), [0.0_dp, 0.0_dp], m%loads(1))
      call load_on_particles(m%particles, lower, upper, m%loads(2))
      call place_loads(m%loads, m%grid, m%particles)
      call book_work(m%loads, m%particles, 1.0_dp, dt, spread(velocity, 2, m%grid%n_points), work)
      call check_close(work, (0.5_dp + 0.25_dp*dt - 3)*dot_product(force, velocity)*dt, 1.0e-12_dp, &
                       'work of the loads in a translation = mean force times way')
   end subroutine work_of_loads

   !> The particle of a place is the one nearest to it, however far away.
   subroutine nearest_particle()
      type(problem_t) :: m
      type(load_t) :: load
      integer, parameter :: places = 100
      real(dp) :: x(ndim, places), distance
      integer :: i, n, wrong
      call place([0.0_dp, 0.0_dp], m)
      call random_number(x)
      x = 1.6_dp*x - 0.2_dp
      call load_on_points(m%matter_t, x, [0.0_dp, 0.0_dp], load)
      wrong = 0
      do i = 1, places
         distance = minval([(norm2(m%particles%position(n) - x(:, i)), n=1, m%particles%n)])
         if (norm2(m%particles%position(load%particle(i)) - x(:, i)) > distance + 1.0e-15_dp) wrong = wrong + 1
      end do
      call check(wrong == 0, 'a load is carried by the nearest particle')
   end subroutine nearest_particle
end program test_loads
