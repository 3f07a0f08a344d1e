!> Cells that answer by themselves move their particles as sweeps over these do.
program test_element_operators
   use hampm_kinds, only: dp, ndim
   use hampm_bodies, only: fill_rectangle
   use hampm_constraints, only: constrain_box
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_time_history, only: time_history_t
   use loading, only: load_on_points
   use hampm_loads, only: load_t
   use hampm_mass_choice, only: mass_choice_t, new_mass_choice
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t, update_particles
   use hampm_particles, only: new_particles
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps, thickness
   use hampm_sorting, only: sort_into_cells
   use hampm_step, only: explicit_t
   use hampm_threads, only: use_threads
   use hampm_thickness, only: thickness_t
   implicit none
   type(explicit_t) :: explicit

   real(dp), parameter :: cell = 0.1_dp, dt = 0.1_dp*cell/4
   real(dp), parameter :: rounding = 1.0e-12_dp          !! over the largest value
   integer, parameter :: steps = 200
   integer :: k

   call use_threads(1, 0)
   call repeat_random_numbers()
   do k = 1, size(schemes)
      call as_by_particles(trim(schemes(k)), 0)
      call as_by_particles(trim(schemes(k)), 2)
      call as_by_particles(trim(schemes(k)), 1, new_mass_choice('consistent', 'direct', 1, 0.0_dp, [0.0_dp, 0.0_dp], &
                                                                    [0.0_dp, 0.0_dp]))
      call looking_changes_nothing(trim(schemes(k)))
      call settled_is_a_state(trim(schemes(k)))
   end do
   call who_has_a_response()
   call hardly_any_mass()
   call same_bytes_with_two_threads()
   call finish()

contains

   !> Three bodies of different linear and nonlinear materials side by side, none of whose edges or particles fits to the cells, on
   !> a mesh that may be refined: at random velocities, damped, held and loaded.
   subroutine place(scheme, levels, m, mass)
      character(*), intent(in) :: scheme
      integer, intent(in) :: levels
      type(problem_t), intent(out) :: m
      type(mass_choice_t), intent(in), optional :: mass
      integer, parameter :: points(ndim) = [15, 13]
      real(dp), parameter :: x(4) = [0.13_dp, 0.77_dp, 1.42_dp, 1.87_dp], y(2) = [0.16_dp, 0.73_dp]
      type(forest_t) :: forest
      type(failure_t) :: failure
      integer :: k
      forest = forest_t([0.0_dp, 0.0_dp], cell, [20, 9])
      call refine_box(forest, [0.5_dp, 0.3_dp], [0.9_dp, 0.6_dp], levels)
      call build_grid(forest, m%grid, failure)
      call new_particles(3*product(points), m%particles, failure)
      allocate (m%materials(3))                  ! a constructor of an array would leak in gfortran 12
      m%materials(1) = new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp)
      m%materials(2) = new_material('', 'linear_elastic', .true., 3.0_dp, 0.1_dp, 2.0_dp)
      m%materials(3) = new_material('', 'neo_hookean', .true., 1.0_dp, 0.2_dp, 1.0_dp)
      do k = 1, 3
         call fill_rectangle(m%particles, 1 + (k - 1)*product(points), points, [x(k), y(1)], [x(k + 1), y(2)], &
                             thickness_t(thickness), &
                             m%materials(k)%density, [0.0_dp, 0.0_dp], k, k)
      end do
      call random_number(m%particles%velocity)
      m%particles%velocity = 0.01_dp*(m%particles%velocity - 0.5_dp)
      m%particles%total_frame = .true.
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      allocate (m%loads(1))
      m%loads(1)%force = [1.0e-3_dp, -2.0e-3_dp]
      m%loads(1)%history = time_history_t(kind='ramp', rise_time=100*dt)
      call load_on_points(m%matter_t, reshape([x(1), 0.2_dp, x(1), 0.6_dp], [ndim, 2]), [0.0_dp, 0.1_dp], m%loads(1))
      call constrain_box(m%constraints, m%grid, [1.8_dp, 0.0_dp], [2.0_dp, 0.9_dp], [.true., .false.])
      m%damping_rate = 0.3_dp
      call start(m, scheme, mass)
      call check(.not. failure%failed(), 'the bodies are in the grid')
   end subroutine place

   !> Do steps, looking at the particles at an interval.
   subroutine run_and_look(m, steps, interval)
      type(problem_t), intent(inout) :: m
      integer, intent(in) :: steps, interval
      type(failure_t) :: failure
      integer :: k
      do k = 1, steps
         call explicit%advance(m, dt, failure)
         if (mod(k, interval) == 0) call update_particles(m)
      end do
      call check(.not. failure%failed(), 'the steps are done')
   end subroutine run_and_look

   !> Whether two motions are the same but for rounding.
   subroutine check_same(a, b, what)
      type(problem_t), intent(in) :: a, b
      character(*), intent(in) :: what
      real(dp) :: error(3)
      error(1) = maxval(abs(a%particles%velocity - b%particles%velocity))/maxval(abs(b%particles%velocity))
      error(2) = maxval(abs(a%particles%displacement - b%particles%displacement))/maxval(abs(b%particles%displacement))
      error(3) = maxval(abs(a%particles%gradient - b%particles%gradient))/maxval(abs(b%particles%gradient))
      write (*, '(2a,3es9.1)') what, ': differences of v, u and H, over the largest', error
      call check_close(maxval(error), 0.0_dp, rounding, what)
      call check_close(a%energies%external_work, b%energies%external_work, rounding*abs(b%energies%external_work), &
                       what//': work of the load')
      call check_close(a%energies%damping_loss, b%energies%damping_loss, rounding*abs(b%energies%damping_loss), &
                       what//': loss by damping')
   end subroutine check_same

   !> With the audit all cells are swept particle by particle.
   subroutine as_by_particles(scheme, levels, mass)
      character(*), intent(in) :: scheme
      integer, intent(in) :: levels
      type(mass_choice_t), intent(in), optional :: mass
      type(problem_t) :: m, swept
      call place(scheme, levels, m, mass)
      swept = m
      swept%audit = .true.
      call run_and_look(m, steps, steps)
      call run_steps(swept, dt, steps)
      call check(m%cache%operators%is_active .and. .not. swept%cache%operators%is_active, &
                 scheme//': one is swept, the other answers')
      call check((m%grid%dofs%n_hanging > 0) .eqv. levels > 0, 'the mesh is refined')
      call check_same(m, swept, scheme//': cells answer as their particles do')
   end subroutine as_by_particles

   subroutine looking_changes_nothing(scheme)
      character(*), intent(in) :: scheme
      type(problem_t) :: m, looked_at
      call place(scheme, 0, m)
      looked_at = m
      call run_and_look(m, steps, 50)
      call run_and_look(looked_at, steps, 1)
      call check_same(m, looked_at, scheme//': looking at each step changes nothing but rounding')
   end subroutine looking_changes_nothing

   !> Settled particles tell all: mapped anew, they go on with the same bytes.
   subroutine settled_is_a_state(scheme)
      character(*), intent(in) :: scheme
      type(problem_t) :: m, anew
      call place(scheme, 1, m)
      call run_and_look(m, 30, 30)
      anew = m
      anew%cache%mapped = .false.
      call run_and_look(m, 30, 30)
      call run_and_look(anew, 30, 30)
      call check(same_bytes(m, anew), scheme//': a run goes on with the same bytes from settled particles')
   end subroutine settled_is_a_state

   !> Blocks of one linear material, without loads.
   subroutine who_has_a_response()
      type(problem_t) :: m
      integer :: b, k
      logical :: expected
      call place('musl', 0, m)
      call run_steps(m, dt, 1)
      associate (p => m%particles)
         do b = 1, m%blocks%n
            expected = m%blocks%material(b) == 1 .or. m%blocks%material(b) == 2
            do k = 1, size(m%loads(1)%particle)
               if (any(m%blocks%cells(:, b) == p%cell(m%loads(1)%particle(k)))) expected = .false.
            end do
            call check((m%cache%operators%material(b) > 0) .eqv. expected, &
                       'blocks of one linear material without loads have a response')
         end do
         call check(any(m%cache%operators%material > 0) .and. .not. all(m%cache%operators%material > 0), &
                    'there are both kinds of blocks')
      end associate
   end subroutine who_has_a_response

   !> Particles on the lines of the grid give some nodes hardly any mass: their cells are swept.
   subroutine hardly_any_mass()
      type(problem_t) :: m
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [10, 10]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([0.15_dp, 0.15_dp], [0.75_dp, 0.75_dp], [6, 6])], m)
      m%particles%total_frame = .true.
      call start(m, 'musl')
      call run_steps(m, dt, 1)
      call check(.not. m%cache%operators%is_active, 'cells with hardly any mass at a corner are swept')
   end subroutine hardly_any_mass

   subroutine same_bytes_with_two_threads()
      type(problem_t) :: m, by_two
      integer :: levels
      do levels = 0, 1
         call place('usavg', levels, m)
         by_two = m
         call run_and_look(m, 50, 20)
         call use_threads(2, 0)
         call run_and_look(by_two, 50, 20)
         call use_threads(1, 0)
         call check(same_bytes(m, by_two), 'two threads find the same bytes as one')
      end do
   end subroutine same_bytes_with_two_threads

   logical function same_bytes(a, b)
      type(problem_t), intent(in) :: a, b
      same_bytes = all(transfer(a%particles%velocity, [0]) == transfer(b%particles%velocity, [0])) .and. &
                   all(transfer(a%particles%displacement, [0]) == transfer(b%particles%displacement, [0])) .and. &
                   all(transfer(a%particles%gradient, [0]) == transfer(b%particles%gradient, [0]))
   end function same_bytes
end program test_element_operators
