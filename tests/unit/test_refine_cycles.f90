!> Mesh and particles at the extremes of refinement: thousands of cycles, random meshes, twelve levels, everything refined.
program test_refine_cycles
   use hampm_kinds, only: dp, ndim, corners
   use hampm_builds, only: is_slow
   use hampm_energy, only: strain_energy, linear_momentum
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use loading, only: load_on_points
   use hampm_loads, only: load_on_particles
   use hampm_matching, only: adopt_forest
   use hampm_material, only: material_t, new_material
   use hampm_problem, only: problem_t
   use hampm_nodal_fields, only: v_next
   use hampm_refined, only: refine_box, misplaced, is_balanced, spans_lattice
   use hampm_refinement, only: follow_particles
   use hampm_samples, only: rectangle_t, place_bodies, start, run_steps, total_energy, energy_residual
   use hampm_splitting, only: start_families
   use hampm_text, only: to_text
   implicit none

   real(dp), parameter :: cell = 0.1_dp
   real(dp), parameter :: lower(ndim) = [0.113_dp, 0.127_dp], upper(ndim) = lower + [0.15_dp, 0.12_dp]
   real(dp), parameter :: middle(ndim) = lower + 0.07_dp
   type(material_t) :: neo_hookean
   type(forest_t) :: uniform

   call repeat_random_numbers()
   neo_hookean = new_material('', 'neo_hookean', .true., 1.0_dp, 0.3_dp, 1.3_dp)
   uniform = forest_t([0.0_dp, 0.0_dp], cell, [4, 4])
   call cycles(.false.)
   call cycles(.true.)
   call random_forests(.false.)
   call random_forests(.true.)
   call twelve_levels(.true.)
   call twelve_levels(.false.)
   call refined_everywhere()
   call stretched_family()
   call finish()

contains

   !> A small body; if it is loaded, it is strained, moves and has a traction and a body force.
   subroutine place(points, is_loaded, m)
      integer, intent(in) :: points(ndim)
      logical, intent(in) :: is_loaded
      type(problem_t), intent(out) :: m
      real(dp) :: h(ndim, ndim), v(ndim)
      integer :: i
      call place_bodies(uniform, neo_hookean, [rectangle_t(lower, upper, points)], m)
      call start_families(m%particles)
      if (is_loaded) then
         allocate (m%loads(2))
         call load_on_points(m%matter_t, reshape([upper(1), middle(2)], [ndim, 1]), [0.0_dp, 0.02_dp], m%loads(1))
         call load_on_particles(m%particles, lower, upper, m%loads(2))
         do i = 1, m%particles%n
            call random_number(h)
            call random_number(v)
            m%particles%gradient(i, :, :) = 0.1_dp*(h - 0.5_dp)
            m%particles%velocity(i, :) = 0.1_dp*(v - 0.3_dp)
         end do
      end if
      m%audit = .true.
      call start(m, 'musl')
   end subroutine place

   !> Make grid and particles follow a forest.
   subroutine adopt(m, forest)
      type(problem_t), intent(inout) :: m
      type(forest_t), intent(in) :: forest
      type(failure_t) :: failure
      call adopt_forest(m, forest, failure)
      if (failure%failed()) call check(.false., 'the particles fit the v_next mesh: '//failure%message)
   end subroutine adopt

   !> Make the particles follow the motion.
   subroutine follow(m)
      type(problem_t), intent(inout) :: m
      type(failure_t) :: failure
      call follow_particles(m, failure)
      if (failure%failed()) call check(.false., 'the particles follow the motion: '//failure%message)
   end subroutine follow

   !> Mass and volume of each particle that was before, exactly.
   subroutine check_masses(m, before, what)
      type(problem_t), intent(in) :: m, before
      character(*), intent(in) :: what
      real(dp) :: mass(before%particles%n), volume(before%particles%n)
      integer :: before_in(before%particles%n), i
      before_in = sorted_by_id(before)
      mass = 0
      volume = 0
      do i = 1, m%particles%n
         associate (id => m%particles%id(i))
            mass(id) = mass(id) + m%particles%mass(i)
            volume(id) = volume(id) + m%particles%volume(i)
         end associate
      end do
      call check(all(abs(mass - before%particles%mass(before_in)) <= 0) .and. &
                 all(abs(volume - before%particles%volume(before_in)) <= 0), &
                 what//': mass and volume of each particle that was, exactly')
   end subroutine check_masses

   !> Momentum and strain energy are those of before, to a tolerance, and masses exactly.
   subroutine check_sums(m, before, tolerance, what)
      type(problem_t), intent(in) :: m, before
      real(dp), intent(in) :: tolerance
      character(*), intent(in) :: what
      call check_masses(m, before, what)
      call check_close(norm2(linear_momentum(m%particles) - linear_momentum(before%particles)), 0.0_dp, &
                       tolerance*sum(before%particles%mass*norm2(before%particles%velocity, 2)), what//': momentum')
      call check_close(strain_energy(m%particles, m%materials), strain_energy(before%particles, before%materials), &
                       tolerance*strain_energy(before%particles, before%materials), what//': strain energy')
   end subroutine check_sums

   !> The numbers of the particles in the order of their ids.
   pure function sorted_by_id(m) result(number)
      type(problem_t), intent(in) :: m
      integer :: number(m%particles%n), i
      number(m%particles%id) = [(i, i=1, m%particles%n)]
   end function sorted_by_id

   !> The body is what it was before.
   subroutine check_returned(m, before, tolerance, what)
      type(problem_t), intent(in) :: m, before
      real(dp), intent(in) :: tolerance
      character(*), intent(in) :: what
      real(dp) :: drift(4)
      integer :: now(before%particles%n), then(before%particles%n), l
      call check(m%particles%n == before%particles%n, what//': as many particles as before')
      if (m%particles%n /= before%particles%n) return
      now = sorted_by_id(m)
      then = sorted_by_id(before)
      associate (p => m%particles, q => before%particles)
         drift(1) = maxval(abs(p%reference(now, :) - q%reference(then, :)))
         drift(2) = maxval(abs(p%displacement(now, :) - q%displacement(then, :)))
         drift(3) = maxval(abs(p%velocity(now, :) - q%velocity(then, :)))
         drift(4) = maxval(abs(p%gradient(now, :, :) - q%gradient(then, :, :)))
      end associate
      write (*, '(2a,4es9.1)') what, ': drift of X, u, v, H', drift
      call check_close(maxval(drift), 0.0_dp, tolerance, what//': X, u, v and H')
      do l = 1, size(m%loads)
         call check(size(m%loads(l)%particle) == size(before%loads(l)%particle), what//': the load acts where it did')
         call check_close(sum(m%loads(l)%fraction), 1.0_dp, tolerance, what//': fractions of a load')
      end do
   end subroutine check_returned

   !> Refine and recombine again and again.
   subroutine cycles(is_loaded)
      logical, intent(in) :: is_loaded
      type(problem_t) :: m, before
      type(forest_t) :: fine(2)
      integer :: n, times, wrong, finest
      character(:), allocatable :: what
      times = merge(1000, 10000, is_slow())
      what = to_text(times)//' cycles'//trim(merge(' under load', '           ', is_loaded))
      fine = uniform
      call refine_box(fine(1), [0.1_dp, 0.1_dp], [0.2_dp, 0.3_dp], 1)
      call refine_box(fine(2), [0.15_dp, 0.15_dp], [0.2_dp, 0.2_dp], 2)
      call place([3, 2], is_loaded, m)
      before = m
      wrong = 0
      finest = 0
      do n = 1, times
         call adopt(m, fine(1 + mod(n, 2)))
         wrong = wrong + misplaced(m)
         finest = max(finest, m%particles%n)
         call adopt(m, uniform)
         wrong = wrong + misplaced(m)
         if (m%particles%n /= before%particles%n) wrong = wrong + 1
      end do
      call check(finest > 2*before%particles%n, what//': there are more particles in between')
      call check(wrong == 0, what//': each particle is in one leaf that is not finer than it, and recombined after each cycle')
      call check_sums(m, before, 1.0e-12_dp, what)
      call check_returned(m, before, 1.0e-13_dp, what)
      call check_close(energy_residual(m, total_energy(before)), 0.0_dp, &
                       1.0e-12_dp*total_energy(before), what//': the energy audit closes')
   end subroutine cycles

   !> Refine and recombine leaves at random, up to four levels, now and then with steps in between.
   subroutine random_forests(moves)
      logical, intent(in) :: moves
      type(problem_t) :: m, before
      type(forest_t) :: forest
      real(dp), allocatable :: chance(:)
      integer, allocatable :: change(:)
      character(:), allocatable :: what
      integer :: n, leaf, wrong, unbalanced, most, crossings
      integer, parameter :: deepest_tried = 4
      integer :: times
      times = merge(40, 200, is_slow())
      what = 'random forests'//trim(merge(' and steps', '          ', moves))
      call place([3, 2], .true., m)
      if (moves) m%particles%velocity = m%particles%velocity/10
      before = m
      wrong = 0
      unbalanced = 0
      most = 0
      crossings = 0
      do n = 1, times
         forest = m%grid%forest
         allocate (chance(forest%leaf_count()), change(forest%leaf_count()))
         call random_number(chance)
         change = merge(1, merge(0, -1, chance < 0.4_dp), chance < 0.2_dp)
         do leaf = 1, size(change)
            if (forest%level_of(leaf) >= deepest_tried) change(leaf) = min(change(leaf), 0)
         end do
         call forest%adapt(change)
         call forest%balance()
         deallocate (chance, change)
         if (.not. (is_balanced(forest) .and. spans_lattice(forest))) unbalanced = unbalanced + 1
         call adopt(m, forest)
         if (moves) then
            ! short steps: the audit's Gauss rule for the stress work errs in their fourth power
            call run_steps(m, 0.05_dp*cell/2**deepest_tried, 2)
            if (m%cache%sorted) crossings = crossings + 1
            call follow(m)
         end if
         wrong = wrong + misplaced(m)
         most = max(most, m%particles%n)
      end do
      if (moves) call check(crossings > times/4, what//': particles cross cells')
      call check(most > 20*before%particles%n, what//': there are many particles in between')
      call check(unbalanced == 0, what//': every mesh covers the lattice and is balanced')
      call check(wrong == 0, what//': each particle is in one leaf that is not finer than it')
      call adopt(m, uniform)
      if (moves) then
         call check(m%particles%n == before%particles%n, what//': as many particles as before')
         call check_close(norm2(linear_momentum(m%particles) - linear_momentum(before%particles)), 0.0_dp, &
                          1.0e-12_dp*norm2(linear_momentum(before%particles)), what//': momentum')
      else
         call check_sums(m, before, 1.0e-12_dp, what)
         call check_returned(m, before, 1.0e-13_dp, what)
      end if
      call check_close(energy_residual(m, total_energy(before)), 0.0_dp, 1.0e-11_dp*total_energy(before), &
                       what//': the energy audit closes')
   end subroutine random_forests

   !> Refinement around a point by twelve levels, one by one or all at once; steps there; and all back at once.
   subroutine twelve_levels(one_by_one)
      logical, intent(in) :: one_by_one
      type(problem_t) :: m, before
      type(forest_t) :: forest
      integer, allocatable :: change(:)
      character(:), allocatable :: what
      integer, parameter :: levels = 12
      integer :: k
      what = 'twelve levels, '//trim(merge('one by one ', 'all at once', one_by_one))
      call place([6, 5], .true., m)
      before = m
      forest = uniform
      do k = 1, levels
         allocate (change(forest%leaf_count()), source=0)
         change(forest%leaf_at(middle)) = 1
         call forest%adapt(change)
         call forest%balance()
         deallocate (change)
         if (one_by_one .or. k == levels) call adopt(m, forest)
      end do
      call check(forest%finest_level() == levels .and. is_balanced(forest) .and. spans_lattice(forest), &
                 what//': the mesh covers the lattice and is balanced')
      call check(misplaced(m) == 0 .and. maxval(m%particles%level) == levels, &
                 what//': each particle is in one leaf that is not finer than it')
      call check_close(sum(m%particles%mass), sum(before%particles%mass), 1.0e-13_dp*sum(before%particles%mass), what//': mass')
      write (*, '(2a,i0,a,i0)') what, ': leaves ', forest%leaf_count(), ', particles ', m%particles%n
      call run_steps(m, 0.1_dp*m%grid%finest_cell, 20)
      call check_close(norm2(linear_momentum(m%particles) - linear_momentum(before%particles)), 0.0_dp, &
                       1.0e-12_dp*norm2(linear_momentum(before%particles)), what//': momentum after some steps')
      call check_close(energy_residual(m, total_energy(before)), 0.0_dp, 1.0e-12_dp*total_energy(before), &
                       what//': the energy audit closes')
      call check(maxval(abs(m%particles%gradient)) < 0.1_dp .and. maxval(abs(m%particles%velocity)) < 0.2_dp, &
                 what//': nothing is torn')
      call adopt(m, uniform)
      call check(m%particles%n == before%particles%n .and. misplaced(m) == 0, what//': as many particles as before')
      call check_masses(m, before, what)
      call check_close(norm2(linear_momentum(m%particles) - linear_momentum(before%particles)), 0.0_dp, &
                       1.0e-12_dp*norm2(linear_momentum(before%particles)), what//': momentum at the end')
   end subroutine twelve_levels

   !> Where everything is refined, masses, momenta and forces at the nodes are those on the uniform grid of that cell size.
   subroutine refined_everywhere()
      type(problem_t) :: m, fine
      type(forest_t) :: forest
      integer, parameter :: levels = 3, points(ndim) = [3, 2]*2**levels
      integer :: k, a, b, missing
      real(dp) :: error(3), scale(3)
      call place([3, 2], .false., m)
      forest = uniform
      do k = 1, levels
         call forest%adapt(spread(1, 1, forest%leaf_count()))
      end do
      call adopt(m, forest)
      call check(m%particles%n == product(points), 'everything refined: number of particles')
      call place_bodies(forest_t(uniform%lower, cell/2**levels, uniform%cells*2**levels), neo_hookean, &
                        [rectangle_t(lower, upper, points)], fine)
      call start(fine, 'musl')
      call give_fields(m)
      call give_fields(fine)
      call run_steps(m, 1.0e-3_dp*cell, 1)
      call run_steps(fine, 1.0e-3_dp*cell, 1)
      scale = [maxval(fine%fields%mass_matrix%lumped), maxval(abs(fine%fields%velocity(:, :, v_next))), &
               maxval(abs(fine%fields%acceleration))]
      error = 0
      missing = 0
      do a = 1, m%grid%n_nodes
         b = fine%grid%node_at(m%grid%node_position(:, a))
         if (b == 0) then
            missing = missing + 1
            cycle
         end if
         error(1) = max(error(1), abs(m%fields%mass_matrix%lumped(a) - fine%fields%mass_matrix%lumped(b)))
         error(2) = max(error(2), maxval(abs(m%fields%velocity(:, a, v_next) - fine%fields%velocity(:, b, v_next))))
         error(3) = max(error(3), maxval(abs(m%fields%acceleration(:, a) - fine%fields%acceleration(:, b))))
      end do
      call check(missing == 0 .and. m%grid%n_points == fine%grid%n_points, 'everything refined: the same nodes')
      call check(all(scale > 0), 'everything refined: there are masses, velocities and accelerations')
      call check_close(maxval(error/scale), 0.0_dp, 1.0e-13_dp, 'everything refined: nodal values')
   end subroutine refined_everywhere

   !> Displacement, velocity and H as smooth fields of X.
   subroutine give_fields(m)
      type(problem_t), intent(inout) :: m
      real(dp) :: x(ndim)
      integer :: i
      do i = 1, m%particles%n
         x = m%particles%reference(i, :)
         m%particles%velocity(i, :) = [sin(20*x(1)), cos(30*x(2)*x(1))]
         m%particles%gradient(i, :, :) = 0.1_dp*reshape([x(1), x(2), x(2) - x(1), sin(50*x(1))], [ndim, ndim])
      end do
      m%cache%mapped = .false.
   end subroutine give_fields

   !> A particle that is so stretched that its children stand beyond the fine cell in which it stands is not recombined there.
   subroutine stretched_family()
      type(problem_t) :: m
      type(forest_t) :: forest
      real(dp), parameter :: from(ndim) = [0.125_dp, 0.125_dp], to(ndim) = [0.175_dp, 0.175_dp]
      forest = uniform
      call refine_box(forest, [0.1_dp, 0.1_dp], [0.2_dp, 0.2_dp], 1)
      call place_bodies(uniform, neo_hookean, [rectangle_t(from, to, [1, 1])], m)
      m%particles%gradient(1, 1, 1) = 5
      call start(m, 'musl')
      call adopt(m, forest)
      call check(m%particles%n == corners, 'a stretched family stays: number of particles')
      call check(misplaced(m) == 0, 'a stretched family stays: each particle is in one leaf that is not finer than it')
      call adopt(m, uniform)
      call check(m%particles%n == 1, 'a stretched family stays until its place is coarse')
   end subroutine stretched_family
end program test_refine_cycles
