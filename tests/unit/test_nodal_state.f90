!> What the nodes do at an instant: the divergence of the stress is what surface loads and stresses make of it, reactions balance
!> loads, and whoever looks does not disturb the run.
program test_nodal_state
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constrain_box
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use loading, only: load_on_points
   use hampm_loads, only: load_on_particles
   use hampm_mass_choice, only: mass_choice_t
   use hampm_mass_samples, only: choice_of
   use hampm_matching, only: adopt_forest
   use hampm_material, only: material_t, new_material
   use hampm_problem, only: problem_t
   use hampm_nodal_state, only: nodal_state_t, find_nodal_state
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps, nodal_velocity, thickness
   implicit none

   real(dp), parameter :: cell = 0.1_dp, depth = 0.4_dp, length = 1.0_dp
   real(dp), parameter :: everywhere(ndim) = 10.0_dp
   type(material_t) :: material, rubber
   integer :: k

   call repeat_random_numbers()
   material = new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp)
   rubber = new_material('', 'neo_hookean', .true., 1.0_dp, 0.3_dp, 1.0_dp)
   do k = 1, size(schemes)
      call falling_body(trim(schemes(k)))
      call pushed_bar(trim(schemes(k)), mass_choice_t())
      call pushed_bar(trim(schemes(k)), choice_of('consistent', solver='cg'))
      call undisturbed(trim(schemes(k)), mass_choice_t(), 'lumped')
      call undisturbed(trim(schemes(k)), choice_of('consistent', solver='cg'), 'cg')
      call undisturbed(trim(schemes(k)), choice_of('consistent', solver='direct'), 'direct')
      call undisturbed(trim(schemes(k)), choice_of('fmpm', order=3), 'fmpm')
      call after_refinement(trim(schemes(k)))
   end do
   call held_bar()
   call finish()

contains

   !> A bar of `length` by `depth`, of which the left end is held against moving along it where `held`.
   subroutine place_bar(law, held, m)
      type(material_t), intent(in) :: law
      logical, intent(in) :: held
      type(problem_t), intent(out) :: m
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [16, 10]), law, &
                        [rectangle_t([0.0_dp, 0.0_dp], [length, depth], [20, 8])], m)
      if (held) call constrain_box(m%constraints, m%grid, [0.0_dp, 0.0_dp], [0.0_dp, depth], [.true., .false.])
   end subroutine place_bar

   !> A traction on the right end with the resultant `force`.
   subroutine push_end(force, m)
      real(dp), intent(in) :: force(ndim)        !! [N]
      type(problem_t), intent(inout) :: m
      real(dp) :: points(ndim, 8)
      integer :: i
      do i = 1, size(points, 2)
         points(:, i) = [length, (i - 0.5_dp)*depth/size(points, 2)]
      end do
      allocate (m%loads(1))
      m%loads(1)%force = force
      call load_on_points(m%matter_t, points, [0.0_dp, depth/(2*size(points, 2))], m%loads(1))
   end subroutine push_end

   subroutine look(m, state)
      type(problem_t), intent(inout) :: m
      type(nodal_state_t), intent(inout) :: state
      type(failure_t) :: failure
      call find_nodal_state(m, state, failure)
      if (failure%failed()) call check(.false., failure%message)
   end subroutine look

   !> A body load accelerates a free body as a whole: no stress, so no divergence, though it moves and is damped.
   subroutine falling_body(scheme)
      character(*), intent(in) :: scheme
      type(problem_t) :: m
      type(nodal_state_t) :: state
      real(dp), parameter :: v(ndim) = [0.3_dp, -0.2_dp]
      integer :: i
      real(dp), allocatable :: velocity(:, :)
      real(dp) :: error
      call place_bar(material, .false., m)
      allocate (m%loads(1))
      m%loads(1)%force = [0.2_dp, -3.0_dp]
      call load_on_particles(m%particles, [0.0_dp, 0.0_dp], everywhere, m%loads(1))
      m%damping_rate = 2
      do i = 1, m%particles%n
         m%particles%velocity(i, :) = v
      end do
      call start(m, scheme)
      call look(m, state)
      allocate (velocity, source=nodal_velocity(m))
      error = 0
      associate (all => m%fields%mass_matrix%all)
         do i = 1, all%n_nodes
            error = max(error, maxval(abs(velocity(:, all%nodes(i)) - v)))
         end do
      end associate
      call check_close(maxval(abs(state%divergence)), 0.0_dp, 1.0e-14_dp, scheme//': a body load is no divergence of stress')
      call check_close(error, 0.0_dp, 1.0e-14_dp, scheme//': the nodes have the velocity of the body')
      call check_close(maxval(abs(state%reaction)), 0.0_dp, 0.0_dp, scheme//': nothing holds a free body')
   end subroutine falling_body

   !> The divergence of a stress that grows along the bar, as the nodes have it inside; and that of a uniform stress which a
   !> traction balances, at the loaded end too.
   subroutine pushed_bar(scheme, mass)
      character(*), intent(in) :: scheme
      type(mass_choice_t), intent(in) :: mass
      type(problem_t) :: m
      type(nodal_state_t) :: state
      real(dp), parameter :: strain = 1.0e-9_dp
      integer :: i
      call place_bar(material, .true., m)
      call push_end([strain*depth*thickness, 0.0_dp], m)
      m%particles%gradient(:, 1, 1) = strain
      m%particles%gradient(:, 2, 2) = -material%poisson*strain
      call start(m, scheme, mass)
      call look(m, state)
      call check_close(maxval(abs(state%divergence))*cell, 0.0_dp, 10*strain**2, &
                       scheme//': a stress in balance with a traction has no divergence')
      call check_close(state%reaction(1), -strain*depth*thickness, 1.0e-13_dp*strain, &
                       scheme//': and the support bears it')
      call m%solver%direct%release()

      call place_bar(material, .false., m)
      m%particles%gradient(:, 1, 1) = strain*m%particles%reference(:, 1)
      m%particles%gradient(:, 2, 2) = -material%poisson*m%particles%gradient(:, 1, 1)
      call start(m, scheme)
      call look(m, state)
      i = m%grid%node_at([0.5_dp*length, 0.5_dp*depth])
      call check_close(state%divergence(1, i), strain, 1.0e-13_dp*strain, scheme//': the divergence of a linear stress')
   end subroutine pushed_bar

   !> A bar under its weight, held at an end and damped, comes to rest: the support bears the weight, and the divergence is its
   !> opposite.
   subroutine held_bar()
      type(problem_t) :: m
      type(nodal_state_t) :: state
      real(dp), parameter :: weight = 1.0e-6_dp
      integer :: i
      call place_bar(material, .true., m)
      allocate (m%loads(1))
      m%loads(1)%force = [weight, 0.0_dp]
      call load_on_particles(m%particles, [0.0_dp, 0.0_dp], everywhere, m%loads(1))
      m%damping_rate = 3
      call start(m, 'musl')
      call run_steps(m, 0.3_dp*cell, 1000)
      call look(m, state)
      i = m%grid%node_at([0.5_dp*length, 0.5_dp*depth])
      call check_close(state%reaction(1), -weight, 1.0e-8_dp*weight, 'the support of a bar at rest bears its weight')
      call check_close(state%divergence(1, i), -weight/sum(m%particles%mass), 1.0e-4_dp*weight/sum(m%particles%mass), &
                       'and the stress holds it')
   end subroutine held_bar

   !> A run in which somebody looks before every step, while particles change cells, goes through the same bytes. Plain USL is
   !> not given particles that change cells: free edges that leave the cell lines break it up.
   subroutine undisturbed(scheme, mass, name)
      character(*), intent(in) :: scheme, name
      type(mass_choice_t), intent(in) :: mass
      type(problem_t) :: m, alone
      logical :: crossed
      call moving_bar(scheme, mass, alone)
      call run_on(alone, .false., crossed)
      call moving_bar(scheme, mass, m)
      call run_on(m, .true., crossed)
      call check(crossed .neqv. scheme == 'usl', 'particles change cells')
      call check(same_bytes(m, alone), scheme//', '//name//': looking at the nodes does not disturb the run')
      call m%solver%direct%release()
      call alone%solver%direct%release()
   end subroutine undisturbed

   !> A loaded and stretching bar whose particles are about to change cells.
   subroutine moving_bar(scheme, mass, m)
      character(*), intent(in) :: scheme
      type(mass_choice_t), intent(in) :: mass
      type(problem_t), intent(out) :: m
      integer :: i
      call place_bar(rubber, .true., m)
      call push_end([1.0e-4_dp, 1.0e-4_dp], m)
      do i = 1, m%particles%n
         if (scheme /= 'usl') m%particles%displacement(i, :) = [0.0245_dp, 0.0_dp]
         m%particles%velocity(i, :) = 0.05_dp*m%particles%reference(i, 1)*[1.0_dp, 0.5_dp]
      end do
      call start(m, scheme, mass)
   end subroutine moving_bar

   !> Do some steps, and note whether particles change cells in them.
   subroutine run_on(m, looking, crossed)
      type(problem_t), intent(inout) :: m
      logical, intent(in) :: looking
      logical, intent(out) :: crossed
      type(nodal_state_t) :: state
      integer :: step
      crossed = .false.
      do step = 1, 10
         if (looking) call look(m, state)
         call run_steps(m, 0.2_dp*cell, 1)
         crossed = crossed .or. .not. m%cache%mapped
      end do
   end subroutine run_on

   logical function same_bytes(a, b)
      type(problem_t), intent(in) :: a, b
      same_bytes = all(transfer(a%particles%velocity, [0]) == transfer(b%particles%velocity, [0])) .and. &
                   all(transfer(a%particles%displacement, [0]) == transfer(b%particles%displacement, [0])) .and. &
                   all(transfer(a%particles%gradient, [0]) == transfer(b%particles%gradient, [0]))
   end function same_bytes

   !> Right after a refinement, when nothing is mapped and all nodal fields are zero: a uniform stress has no divergence at nodes
   !> inside, a uniform motion is that of every point, dependent ones included.
   subroutine after_refinement(scheme)
      character(*), intent(in) :: scheme
      type(problem_t) :: m
      type(nodal_state_t) :: state
      type(forest_t) :: forest
      type(failure_t) :: failure
      real(dp), parameter :: v(ndim) = [0.3_dp, -0.2_dp], strain = 1.0e-6_dp
      real(dp), allocatable :: velocity(:, :)
      integer :: i
      call place_bar(material, .false., m)
      call start(m, scheme)
      forest = m%grid%forest
      call refine_box(forest, [0.35_dp, 0.1_dp], [0.65_dp, 0.3_dp], 2)
      call adopt_forest(m, forest, failure)
      call check(.not. failure%failed() .and. m%grid%dofs%n_hanging > 0, 'the mesh is refined')
      do i = 1, m%particles%n
         m%particles%velocity(i, :) = v
         m%particles%gradient(i, :, :) = strain
      end do
      m%cache%mapped = .false.
      call look(m, state)
      allocate (velocity, source=nodal_velocity(m))
      do i = 1, m%grid%n_points
         associate (x => m%grid%node_position(:, i), n => m%fields%mass_matrix%all)
            if (.not. any(n%nodes(:n%n_points) == i)) cycle
            call check_close(maxval(abs(velocity(:, i) - v)), 0.0_dp, 1.0e-14_dp, scheme//': every point moves alike')
            if (i > m%grid%n_nodes .or. any(x < 0.01_dp .or. x > [length, depth] - 0.01_dp)) cycle
            call check_close(maxval(abs(state%divergence(:, i)))*cell, 0.0_dp, 1.0e-12_dp*strain, &
                             scheme//': a uniform stress has no divergence in a refined mesh')
         end associate
      end do
   end subroutine after_refinement
end program test_nodal_state
