!> Contact of the faces of a cut: pressed together they are as one body, pulled they part, and they slide freely.
program test_contact
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constrain_box
   use hampm_contact, only: contact_t, rebuild_contact
   use hampm_cuts, only: cut_t, cut_of
   use hampm_energy, only: kinetic_energy
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t, build_grid
   use hampm_harness, only: check, check_close, finish
   use hampm_loads, only: load_on_particles, load_on_points
   use hampm_mass_samples, only: choice_of
   use hampm_material, only: new_material
   use hampm_motion, only: motion_t, rebuild_on_grid, sort_particles
   use hampm_nodal_state, only: nodal_state_t, find_nodal_state
   use hampm_patch, only: patch_t, patch_around, fitted_displacement
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps, total_energy, energy_residual, thickness
   implicit none

   real(dp), parameter :: cell = 0.1_dp, line = 0.7_dp   !! of blocks: the cells, and the place of the cut [m]
   character(7), parameter :: masses(3) = ['lumped ', 'full   ', 'fmpm   ']
   integer :: k, j, n

   do k = 1, size(schemes)
      call pulses(trim(schemes(k)), 'lumped')
      call impact(trim(schemes(k)))
      do j = 1, size(masses)
         call sliding(trim(schemes(k)), trim(masses(j)), total_frame=.true.)
         ! Plain USL is unstable where particles move along a free edge through cells
         if (schemes(k) /= 'usl') call sliding(trim(schemes(k)), trim(masses(j)), total_frame=.false.)
      end do
   end do
   call pulses('musl', 'full')
   do n = 1, 2
      call pressed_halves(total_frame=n == 2)
   end do
   call pressed_unlike_cells(matched=.false.)
   call pressed_unlike_cells(matched=.true.)
   call new_grids()
   call new_quadratic_grids()
   call finish()

contains

   !> A bar of length and wave speed 1 along x, with a cut through it or not.
   subroutine build_bar(n_cells, cut_at, contact, m, length, velocity)
      integer, intent(in) :: n_cells
      real(dp), intent(in) :: cut_at             !! place of the cut; beyond the lattice there is none [m]
      logical, intent(in) :: contact
      type(motion_t), intent(out) :: m
      real(dp), intent(in) :: length             !! [m]
      real(dp), intent(in), optional :: velocity !! towards the cut [m/s]
      type(forest_t) :: forest
      type(cut_t), allocatable :: cuts(:)
      real(dp) :: edge
      integer :: i
      edge = 1.0_dp/n_cells
      forest = forest_t([-edge, -edge], edge, [n_cells + 2, 3])
      allocate (cuts(0))
      if (cut_at < 1) cuts = [cut_of(forest, 1, [cut_at, -100.0_dp], [cut_at, 100.0_dp])]
      call place_bodies(forest, new_material('', 'linear_elastic', .true., 1.0_dp, 0.0_dp, 1.0_dp), &
                        [rectangle_t([0.0_dp, 0.0_dp], [length, edge], [nint(2*n_cells*length), 1])], m, cuts)
      call constrain_box(m%constraints, m%grid, [-edge, -edge], [1 + edge, 2*edge], [.false., .true.])
      m%contact%wanted = contact
      m%audit = .true.
      if (.not. present(velocity)) return
      do i = 1, m%particles%n
         m%particles%velocity(i, 1) = sign(velocity, cut_at - m%particles%reference(i, 1))
      end do
   end subroutine build_bar

   !> Put a Gaussian pulse into a bar that runs to the right; `amplitude` < 0: a tensile one.
   subroutine put_pulse(m, amplitude)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: amplitude          !! of the velocity [m/s]
      integer :: i
      do i = 1, m%particles%n
         m%particles%velocity(i, 1) = amplitude*exp(-0.5_dp*((m%particles%reference(i, 1) - 0.3_dp)/0.04_dp)**2)
      end do
      m%particles%gradient(:, 1, 1) = -m%particles%velocity(:, 1)
   end subroutine put_pulse

   !> A compressive pulse goes through a cut as through a whole bar; a tensile one comes back as from a free end, and the faces
   !> open.
   subroutine pulses(scheme, mass)
      character(*), intent(in) :: scheme, mass
      integer, parameter :: cells(3) = [50, 100, 200]
      real(dp), parameter :: cut_at = 0.6_dp, amplitude = 1.0e-6_dp
      type(motion_t) :: whole, cut
      real(dp) :: through(3), back(3), opening
      integer :: n, steps
      do n = 1, 3
         steps = nint(0.5_dp*cells(n)/0.2_dp)
         call build_bar(cells(n), 2.0_dp, .false., whole, 1.0_dp)
         call build_bar(cells(n), cut_at, .true., cut, 1.0_dp)
         call put_pulse(whole, amplitude)
         call put_pulse(cut, amplitude)
         call start(whole, scheme, choice_of(mass, 'direct'))
         call start(cut, scheme, choice_of(mass, 'direct'))
         call run_steps(whole, 0.5_dp/steps, steps)
         call run_steps(cut, 0.5_dp/steps, steps)
         through(n) = difference(cut, whole)
         call build_bar(cells(n), 2.0_dp, .false., whole, cut_at)
         call build_bar(cells(n), cut_at, .true., cut, 1.0_dp)
         call put_pulse(whole, -amplitude)
         call put_pulse(cut, -amplitude)
         call start(whole, scheme, choice_of(mass, 'direct'))
         call start(cut, scheme, choice_of(mass, 'direct'))
         call check(whole%contact%n == 0 .and. .not. allocated(whole%contact%gap), 'without contact there is nothing of it')
         call run_steps(whole, 0.5_dp/steps, steps)
         call run_steps(cut, 0.5_dp/steps, steps)
         back(n) = difference(cut, whole)
         opening = maxval(cut%contact%gap)
      end do
      write (*, '(a6,a7,a,3es9.1,a,2f5.1,a,3es9.1,a,es11.3)') scheme, mass, ' pulse through a cut, difference to a whole bar:', &
         through, '  order', log(through(:2)/through(2:))/log(2.0_dp), '; back:', back, '; opening over that of a free end', &
         opening/(2*amplitude*0.04_dp*sqrt(2*acos(-1.0_dp)))
      call check(log(through(2)/through(3))/log(2.0_dp) > 2, scheme//', '//mass//': the difference to a whole bar converges')
      call check(through(3) < merge(1.0e-5_dp, 2.0e-3_dp, mass == 'lumped'), scheme//', '//mass//': pressure goes through a cut')
      call check(back(3) < 1.0e-4_dp, scheme//', '//mass//': tension comes back as from a free end')
      call check_close(opening/(2*amplitude*0.04_dp*sqrt(2*acos(-1.0_dp))), 1.0_dp, 1.0e-3_dp, &
                       scheme//', '//mass//': the faces open as theory says')
   end subroutine pulses

   !> Rms difference of the velocities of two motions over the rms of one of them, by particles that both have.
   real(dp) function difference(a, b)
      type(motion_t), intent(in) :: a, b
      real(dp) :: v(2, a%particles%n)
      integer :: i
      v = 0
      do i = 1, a%particles%n
         if (a%particles%id(i) <= b%particles%n) v(1, a%particles%id(i)) = a%particles%velocity(i, 1)
      end do
      do i = 1, b%particles%n
         v(2, b%particles%id(i)) = b%particles%velocity(i, 1)
      end do
      difference = norm2(v(1, :) - v(2, :))/norm2(v(2, :))
   end function difference

   !> Two bars of length L meet: after 2 L/c they leave with exchanged velocities.
   subroutine impact(scheme)
      character(*), intent(in) :: scheme
      integer, parameter :: cells(3) = [40, 80, 160]
      real(dp), parameter :: speed = 1.0e-6_dp
      type(motion_t) :: m
      real(dp) :: before, contact_time(3), restitution(3), kinetic(3), initial, loss, residual
      integer :: n, i, steps
      do n = 1, 3
         call build_bar(cells(n), 0.5_dp, .true., m, 1.0_dp, speed)
         call start(m, scheme)
         steps = nint(1.5_dp*cells(n)/0.2_dp)
         initial = total_energy(m)
         before = mean_velocity(m)
         contact_time(n) = 0
         do i = 1, steps
            call run_steps(m, 1.5_dp/steps, 1)
            if (any(m%contact%touches)) contact_time(n) = m%time
         end do
         restitution(n) = -mean_velocity(m)/before
         kinetic(n) = kinetic_energy(m%particles)/initial
         loss = m%numerical_loss/initial
         residual = energy_residual(m, initial)/initial
      end do
      write (*, '(2a,3f8.4,a,3f8.4,a,3f8.4,a,f8.4,a,es9.1)') scheme, ' impact: restitution', restitution, ' contact time', &
         contact_time, ' kinetic energy after', kinetic, ' loss', loss, ' residual', residual
      call check_close(contact_time(3), 1.0_dp, 0.015_dp, scheme//': the bars part after 2 L/c')
      call check_close(restitution(3), 1.0_dp, 0.03_dp, scheme//': they leave with exchanged velocities')
      call check(all(1 - restitution(2:) < 0.68_dp*(1 - restitution(:2))), scheme//': the nearer so the smaller the cells')
      call check_close(residual, 0.0_dp, 1.0e-13_dp, scheme//': the audit of an impact closes')
   end subroutine impact

   !> Mean velocity of the left half [m/s].
   real(dp) function mean_velocity(m)
      type(motion_t), intent(in) :: m
      associate (p => m%particles)
         mean_velocity = sum(p%velocity(:, 1), mask=p%reference(:, 1) < 0.5_dp)/count(p%reference(:, 1) < 0.5_dp)
      end associate
   end function mean_velocity

   !> A block on its ground, cut into halves where `is_cut`, with pressure on its top.
   subroutine build_pressed(is_cut, total_frame, side, m)
      logical, intent(in) :: is_cut, total_frame
      integer, intent(in) :: side                !! particles in a row
      type(motion_t), intent(out) :: m
      type(forest_t) :: forest
      integer :: i
      forest = forest_t([0.0_dp, 0.0_dp], cell, [16, 14])
      call place_bodies(forest, new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([0.3_dp, 0.2_dp], [1.3_dp, 1.2_dp], [side, side])], m, &
                        [cut_of(forest, 2, [-100.0_dp, line], [merge(100.0_dp, -99.0_dp, is_cut), line], matched=.true.)])
      call constrain_box(m%constraints, m%grid, [0.0_dp, 0.2_dp], [2.0_dp, 0.2_dp], [.false., .true.])
      m%contact%wanted = .true.
      m%particles%total_frame = total_frame
      m%audit = .true.
      m%damping_rate = 2
      allocate (m%loads(1))
      m%loads(1)%force = [0.0_dp, -1.0e-3_dp]
      call load_on_points(m%matter_t, reshape([(0.3_dp + (i - 0.5_dp)/side, 1.2_dp, i=1, side)], [ndim, side]), [0.0_dp, 0.0_dp], &
                          m%loads(1))
      call start(m, 'musl')
   end subroutine build_pressed

   !> Halves that are pressed together come to rest as one block does, and stay together.
   subroutine pressed_halves(total_frame)
      logical, intent(in) :: total_frame
      integer, parameter :: side = 20
      type(motion_t) :: whole, cut
      real(dp) :: strain(side**2, ndim, ndim, 2), initial, work
      integer :: i, parted
      call build_pressed(.false., total_frame, side, whole)
      call build_pressed(.true., total_frame, side, cut)
      initial = total_energy(cut)
      call run_steps(whole, 0.02_dp, 1200)
      parted = 0
      do i = 1, 1200
         call run_steps(cut, 0.02_dp, 1)
         if (i > 200 .and. pressed(cut) < 11) parted = parted + 1
      end do
      strain(whole%particles%id, :, :, 1) = whole%particles%gradient
      strain(cut%particles%id, :, :, 2) = cut%particles%gradient
      work = cut%external_work
      write (*, '(a,l2,a,2es9.1,a,es9.1,a,i5,a,2es9.1,a,es9.1)') 'pressed, total', total_frame, ' strain difference, spread', &
         maxval(abs(strain(:, :, :, 2) - strain(:, :, :, 1)))/maxval(abs(strain)), &
         (maxval(strain(:, 2, 2, 2)) - minval(strain(:, 2, 2, 2)))/maxval(abs(strain)), ' gap', maxval(cut%contact%gap), &
         ' steps parted', parted, ' residual, kinetic', energy_residual(cut, initial)/work, &
         kinetic_energy(cut%particles)/work, ' gap error', gap_error(cut)/(cell*maxval(abs(strain)))
      call check(maxval(abs(strain(:, :, :, 2) - strain(:, :, :, 1))) < 2.0e-3_dp*maxval(abs(strain)), &
                 'the strain in pressed halves is that in a whole block')
      call check(maxval(cut%contact%gap) <= 0, 'they touch everywhere')
      call check(parted == 0, 'and never part again')
      call check_close(energy_residual(cut, initial)/work, 0.0_dp, 1.0e-13_dp, 'the audit of pressed halves closes')
      call check(gap_error(cut) < merge(1.0e-11_dp, 1.0e-2_dp, total_frame)*cell*maxval(abs(strain)), &
                 'the particles do not drift through the faces')
      call check_state(cut)
   end subroutine pressed_halves

   !> The nodal state has one normal velocity and divergence at pressed pairs, where each side alone has the force of the other.
   subroutine check_state(m)
      type(motion_t), intent(inout) :: m
      type(nodal_state_t) :: state
      type(failure_t) :: failure
      integer :: k, apart
      call find_nodal_state(m, state, failure)
      apart = 0
      do k = 1, m%contact%n
         associate (v => state%velocity(2, m%contact%node(:, k)), d => state%divergence(2, m%contact%node(:, k)))
            if (m%contact%touches(k) .and. max(abs(v(1) - v(2)), abs(d(1) - d(2))) > 0) apart = apart + 1
         end associate
      end do
      call check(apart == 0, 'the nodal state has one normal motion of pressed faces')
      call check(maxval(abs(state%divergence(2, m%contact%node(1, :)))) < 1.0e-2_dp*1.0e-3_dp/(thickness*cell), &
                 'which is none at rest, though each side presses on the other')
      call check_close(sum(state%pressing), -m%loads(1)%force(2), 1.0e-4_dp*1.0e-3_dp, 'with the force that presses them together')
   end subroutine check_state

   !> How many pairs are pressed together.
   integer function pressed(m)
      type(motion_t), intent(in) :: m
      pressed = count(m%contact%touches)
   end function pressed

   !> Pressed halves of which the cells of one become finer: where the sides are matched pressure passes as before.
   subroutine pressed_unlike_cells(matched)
      logical, intent(in) :: matched
      type(motion_t) :: m
      type(forest_t) :: forest
      type(failure_t) :: failure
      type(cut_t), allocatable :: cuts(:)
      real(dp) :: strain, kinetic, spread, near
      integer :: i, parted, n
      call build_pressed(.true., .false., 40, m)
      call run_steps(m, 0.02_dp, 500)
      strain = maxval(abs(m%particles%gradient))
      kinetic = kinetic_energy(m%particles)
      forest = m%grid%forest
      call refine_box(forest, [0.0_dp, line], [0.8_dp, 1.0_dp], 1)
      n = m%contact%n
      cuts = m%grid%cuts
      cuts%matched = matched
      call build_grid(forest, m%grid, failure, cuts)
      call sort_particles(m, failure)
      call rebuild_on_grid(m, failure)
      call check(.not. failure%failed(), 'the grid is refined on one side')
      call check(m%contact%n == n + merge(8, 0, matched), 'finer nodes have partners where the sides are matched')
      n = pressed(m)
      call check(n == 11 + merge(5, 0, matched), 'pairs are pressed where they were, and between')
      parted = 0
      do i = 1, 1200
         call run_steps(m, 0.01_dp, 1)
         if (pressed(m) < n) parted = parted + 1
      end do
      associate (h => m%particles%gradient(:, 2, 2), y => m%particles%reference(:, 2))
         spread = (maxval(h) - minval(h))/strain
         near = (maxval(h, mask=abs(y - line) > cell) - minval(h, mask=abs(y - line) > cell))/strain
      end associate
      write (*, '(a,i5,a,2f8.4,a,es9.1)') 'finer on one side: steps parted', parted, &
         ' spread of strain, beyond a cell from the line', spread, near, ' kinetic energy', kinetic_energy(m%particles)/kinetic
      call check(parted == 0, 'pairs stay pressed where one side is finer')
      call check(merge(spread < 0.05_dp, near < 0.15_dp, matched), 'and the strain stays even, at the line where they match')
   end subroutine pressed_unlike_cells

   !> Gaps are taken over by a new grid: they are the same where they were, linear between, and zero at the tips.
   subroutine new_grids()
      type(grid_t) :: coarse, fine
      type(forest_t) :: forest
      type(failure_t) :: failure
      type(contact_t) :: c
      type(cut_t) :: cuts(1)
      real(dp), allocatable :: x(:), expected(:)
      integer :: wrong, level
      forest = forest_t([0.0_dp, 0.0_dp], cell, [16, 14])
      cuts = cut_of(forest, 2, [0.3_dp, line], [0.9_dp, line], matched=.true.)
      call build_grid(forest, coarse, failure, cuts)
      c%wanted = .true.
      call rebuild_contact(c, coarse)
      call check(c%n == 5, 'the nodes between the tips are pairs')
      call check(all(c%gap <= 0) .and. .not. any(c%touches), 'which begin without gap or pressure')
      c%gap = max(0.0_dp, place_along(c, coarse) - 0.4_dp)
      c%touches = place_along(c, coarse) < 0.45_dp
      do level = 1, 2
         call refine_box(forest, [0.0_dp, 0.0_dp], [0.8_dp, 1.4_dp], level)
         call build_grid(forest, fine, failure, cuts)
         call rebuild_contact(c, fine)
         x = place_along(c, fine)
         expected = merge(4*(0.9_dp - x), max(0.0_dp, x - 0.4_dp), x > 0.8_dp)
         wrong = count(abs(c%gap - expected) > 1.0e-12_dp .or. (c%touches .neqv. x < 0.4_dp + 1.0e-9_dp))
         call check(c%n > 5 .and. wrong == 0, 'gaps are linear between the pairs of the last grid')
      end do
      call rebuild_contact(c, coarse)
      call check(c%n == 5 .and. all(abs(c%gap - max(0.0_dp, place_along(c, coarse) - 0.4_dp)) < 1.0e-12_dp), &
                 'and the same where pairs were')
   end subroutine new_grids

   !> The gaps of quadratic cells are quadratic in each, on cells of any size.
   subroutine new_quadratic_grids()
      type(grid_t) :: grid
      type(forest_t) :: forest
      type(failure_t) :: failure
      type(contact_t) :: c
      type(cut_t) :: cuts(1)
      real(dp), allocatable :: solids(:, :, :)
      real(dp) :: x
      integer :: level, k
      logical :: is_right
      forest = forest_t([0.0_dp, 0.0_dp], cell, [16, 14])
      allocate (solids(ndim, 2, 1))
      solids(:, :, 1) = reshape([0.0_dp, 0.0_dp, 1.6_dp, 1.4_dp], [ndim, 2])
      cuts = cut_of(forest, 2, [0.3_dp, line], [0.9_dp, line], matched=.true.)
      c%wanted = .true.
      is_right = .true.
      do level = 0, 3
         if (level > 0) call refine_box(forest, [0.0_dp, 0.0_dp], [0.5_dp, 1.4_dp], level)
         call build_grid(forest, grid, failure, cuts, solids=solids)
         call rebuild_contact(c, grid)
         do k = 1, c%n
            x = grid%node_position(1, c%node(1, k))
            if (level == 0) c%gap(k) = (x - 0.3_dp)*(0.9_dp - x)
            is_right = is_right .and. abs(c%gap(k) - (x - 0.3_dp)*(0.9_dp - x)) < 1.0e-12_dp
         end do
      end do
      call check(c%n > 11 + 2*14, 'quadratic cells have pairs at their corners and between')
      call check(is_right, 'and gaps that are quadratic')
   end subroutine new_quadratic_grids

   !> Places of the pairs along a cut in x [m].
   function place_along(c, grid) result(x)
      type(contact_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      real(dp) :: x(c%n)
      x = grid%node_position(1, c%node(1, :))
   end function place_along

   !> Two blocks slide over each other while opposite forces press them together.
   subroutine sliding(scheme, mass, total_frame)
      character(*), intent(in) :: scheme, mass
      logical, intent(in) :: total_frame
      real(dp), parameter :: speed = 0.02_dp, force(ndim) = [0.0_dp, 1.0e-4_dp]
      type(motion_t) :: m
      type(forest_t) :: forest
      real(dp) :: initial, momentum(ndim), half(2), residual
      integer :: i, steps
      forest = forest_t([0.0_dp, 0.0_dp], cell, [20, 14])
      call place_bodies(forest, new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([0.64_dp, 0.4_dp], [1.24_dp, line], [12, 6], [-speed, 0.0_dp]), &
                         rectangle_t([0.56_dp, line], [1.16_dp, 1.0_dp], [12, 6], [speed, 0.0_dp])], m, &
                        [cut_of(forest, 2, [-100.0_dp, line], [100.0_dp, line])])
      m%contact%wanted = .true.
      m%particles%total_frame = total_frame
      m%audit = .true.
      allocate (m%loads(2))
      m%loads(1)%force = force
      m%loads(2)%force = -force
      call load_on_particles(m%particles, [0.0_dp, 0.0_dp], [2.0_dp, line], m%loads(1))
      call load_on_particles(m%particles, [0.0_dp, line], [2.0_dp, 2.0_dp], m%loads(2))
      call start(m, scheme, choice_of(mass, order=2))
      initial = total_energy(m)
      steps = 400
      call run_steps(m, 0.01_dp, steps)
      associate (p => m%particles)
         do i = 1, ndim
            momentum(i) = sum(p%mass*p%velocity(:, i))/(speed*sum(p%mass))
         end do
         do i = 1, 2
            half(i) = sum(p%mass*p%velocity(:, 1), mask=p%body == i)/(speed*sum(p%mass)/2) + 3 - 2*i
         end do
      end associate
      residual = energy_residual(m, initial)/initial
      write (*, '(a6,a7,a,l2,a,4es9.1,a,i3,a,es9.1,a,es9.1,a,es9.1,a,es9.1)') scheme, mass, ' sliding, total', total_frame, &
         ' momentum', &
         momentum, half, ' pressed', count(m%contact%touches), ' residual', residual, ' loss', m%numerical_loss/initial, &
         ' strain', maxval(abs(m%particles%gradient)), ' gap error', gap_error(m)/(cell*maxval(abs(m%particles%gradient)))
      call check(maxval(abs([momentum, half])) < 1.0e-13_dp, &
                 scheme//', '//mass//': momentum stays, and that along the line of each block')
      call check(count(m%contact%touches) > 4, scheme//', '//mass//': they are pressed together')
      call check_close(residual, 0.0_dp, 1.0e-13_dp, scheme//', '//mass//': the audit of sliding blocks closes')
   end subroutine sliding

   !> Largest difference between the gaps and those of the particles' displacements at pairs that have material around them [m].
   real(dp) function gap_error(m)
      type(motion_t), intent(in) :: m
      type(patch_t) :: patch
      real(dp) :: u(ndim, 2), most
      integer :: k, side
      gap_error = 0
      most = maxval(m%fields%mass_matrix%lumped(m%contact%node(1, :)))
      do k = 1, m%contact%n
         if (any(m%fields%mass_matrix%lumped(m%contact%node(:, k)) < 0.9_dp*most)) cycle
         do side = 1, 2
            call patch_around(m%grid, m%particles, m%blocks, m%contact%node(side, k), patch)
            u(:, side) = fitted_displacement(patch, m%particles)
         end do
         gap_error = max(gap_error, abs(u(2, 1) - u(2, 2) - m%contact%gap(k)))
      end do
   end function gap_error
end program test_contact
