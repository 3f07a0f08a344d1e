!> Lines along grid lines: what is and what is not connected, on cells of one and of several sizes, and contact of their faces,
!> which pass pressure on, part where they are pulled, and slide freely.
program test_grid_lines
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constrain_box
   use hampm_crack_lines, only: line_t
   use hampm_energy, only: kinetic_energy
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish
   use hampm_interface_points, only: contact, interface_energy, overlap_of
   use loading, only: load_on_points
   use hampm_loads, only: load_on_particles
   use hampm_mass_samples, only: choice_of
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, schemes, place_bodies, start, run_steps, total_energy, energy_residual
   implicit none

   real(dp), parameter :: cell = 0.5_dp
   integer, parameter :: cells(ndim) = [8, 6]
   real(dp), parameter :: tip(ndim) = [2.5_dp, 1.5_dp], end(ndim) = [1.0_dp, 1.5_dp], up(ndim) = [0.0_dp, 1.0_dp]
   real(dp), parameter :: block_cell = 0.1_dp, block_line = 0.7_dp !! of blocks: the cells, and the place of the line [m]
   character(10), parameter :: masses(3) = [character(10) :: 'lumped', 'consistent', 'fmpm']
   integer :: levels, k, j

   call nodes_of_a_line()
   do levels = 0, 3
      call sides_are_apart(levels)
   end do
   do k = 1, size(schemes)
      call pulses(trim(schemes(k)), 'lumped')
      do j = 1, size(masses)
         call sliding(trim(schemes(k)), trim(masses(j)))
      end do
   end do
   call pulses('musl', 'consistent')
   call pressed_halves()
   call finish()

contains

   !> A line between two points, of which both or none are tips.
   function line_between(from, to, is_tip) result(line)
      real(dp), intent(in) :: from(ndim), to(ndim) !! [m]
      logical, intent(in) :: is_tip
      type(line_t) :: line
      allocate (line%points, source=reshape([from, to], [ndim, 2]))
      line%is_tip = is_tip
      line%contact = .true.
   end function line_between

   !> The forest, with the cells around a place on the upper side of the line refined: the sides then differ.
   function refined(levels) result(forest)
      integer, intent(in) :: levels
      type(forest_t) :: forest
      integer, allocatable :: change(:)
      integer :: level, leaf
      real(dp) :: centre(ndim)
      forest = forest_t([0.0_dp, 0.0_dp], cell, cells)
      do level = 1, levels
         allocate (change(forest%leaf_count()), source=0)
         do leaf = 1, size(change)
            centre = forest%position(forest%place_of(leaf)) + 0.5_dp*forest%size_of(leaf)
            if (centre(2) > tip(2) .and. norm2(centre - [1.6_dp, 1.8_dp]) < 2*forest%size_of(leaf)) change(leaf) = 1
         end do
         call forest%adapt(change)
         call forest%balance()
         deallocate (change)
      end do
   end function refined

   !> A grid with a line.
   subroutine build(levels, line, grid)
      integer, intent(in) :: levels
      type(line_t), intent(in) :: line
      type(grid_t), intent(out) :: grid
      type(failure_t) :: failure
      call build_grid(refined(levels), grid, failure, [line])
      call check(.not. failure%failed(), 'the grid is built')
   end subroutine build

   !> Nodes within the line are double, its tips are not; a line that goes on beyond the lattice is open there.
   subroutine nodes_of_a_line()
      type(grid_t) :: grid
      type(line_t) :: line
      call build(0, line_between(end, tip, .true.), grid)
      call check(grid%n_nodes == product(cells + 1) + 2, 'the two nodes between the tips are double')
      call check(grid%node_at(tip, up) == grid%node_at(tip, -up), 'a tip is one node')
      call check(grid%node_at(end, up) == grid%node_at(end, -up), 'so is the other tip')
      call check(grid%node_at([1.5_dp, 1.5_dp], up) /= grid%node_at([1.5_dp, 1.5_dp], -up), 'within the line there are two')
      call check(grid%node_at([1.5_dp, 1.5_dp], up) > 0 .and. grid%node_at([1.5_dp, 1.5_dp], -up) > 0, 'which are both found')
      call check(grid%n_elements == product(cells), 'no cell is cut')
      line = line_between([-100.0_dp, tip(2)], tip, .true.)
      line%is_tip(1) = .false.
      call build(0, line, grid)
      call check(grid%n_nodes == product(cells + 1) + 5, 'of an open line the node at the edge is double too')
   end subroutine nodes_of_a_line

   !> No element of one side shares a point with one of the other, but for the tips; hanging nodes of each side take their values
   !> from that side, on both sides of any sizes; everything else is as without the line.
   subroutine sides_are_apart(levels)
      integer, intent(in) :: levels
      type(grid_t) :: grid, whole
      type(failure_t) :: failure
      integer :: e, node, point, k, shared, strange
      call build(levels, line_between(end, tip, .true.), grid)
      shared = 0
      do node = 1, grid%n_points
         if (.not. is_within(grid, node)) cycle
         if (any(grid%element_lower(2, grid%dofs%elements_at(node)) > tip(2) - 1.0e-9_dp .neqv. side_of(grid, node))) &
            shared = shared + 1
      end do
      call check(shared == 0, 'no point within the line belongs to both sides')
      strange = 0
      do point = grid%n_nodes + 1, grid%n_points
         if (.not. is_within(grid, point)) cycle
         do k = grid%dofs%first_master(point - grid%n_nodes), grid%dofs%first_master(point - grid%n_nodes + 1) - 1
            associate (master => grid%dofs%master(k))
               if (is_within(grid, master) .and. (side_of(grid, master) .neqv. side_of(grid, point))) strange = strange + 1
            end associate
         end do
      end do
      call check(strange == 0, 'hanging nodes within the line take their values from their own side')
      call build_grid(refined(levels), whole, failure)
      call check(whole%n_nodes <= grid%n_nodes .and. whole%forest%same_leaves(grid%forest), 'the line adds nodes only')
      if (levels > 0) call check(whole%n_elements > grid%n_elements, &
                                 'cells across the line from finer ones need not be transition elements')
      call check(all([(grid%element_nodes(:, e) > 0, e=1, grid%n_elements)]), 'every corner has its point')
   end subroutine sides_are_apart

   !> Whether a point is within the line.
   pure logical function is_within(grid, point)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: point
      associate (x => grid%node_position(:, point))
         is_within = abs(x(2) - tip(2)) < 1.0e-9_dp .and. x(1) > end(1) + 1.0e-9_dp .and. x(1) < tip(1) - 1.0e-9_dp
      end associate
   end function is_within

   !> Whether the first element of a point is above the line.
   pure logical function side_of(grid, point)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: point
      associate (elements => grid%dofs%elements_at(point))
         side_of = grid%element_lower(2, elements(1)) > tip(2) - 1.0e-9_dp
      end associate
   end function side_of

   !> A bar of length and wave speed 1 along x, with a line through it or not.
   subroutine build_bar(n_cells, cut_at, m, length)
      integer, intent(in) :: n_cells
      real(dp), intent(in) :: cut_at             !! place of the line; beyond the lattice there is none [m]
      type(problem_t), intent(out) :: m
      real(dp), intent(in) :: length             !! [m]
      type(line_t), allocatable :: lines(:)
      real(dp) :: edge
      edge = 1.0_dp/n_cells
      allocate (lines(merge(1, 0, cut_at < 1)))
      if (cut_at < 1) lines(1) = line_between([cut_at, -100.0_dp], [cut_at, 100.0_dp], .false.)
      call place_bodies(forest_t([-edge, -edge], edge, [n_cells + 2, 3]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.0_dp, 1.0_dp), &
                        [rectangle_t([0.0_dp, 0.0_dp], [length, edge], [nint(2*n_cells*length), 1])], m, lines)
      call constrain_box(m%constraints, m%grid, [-edge, -edge], [1 + edge, 2*edge], [.false., .true.])
   end subroutine build_bar

   !> Put a Gaussian pulse into a bar that runs to the right; `amplitude` < 0: a tensile one.
   subroutine put_pulse(m, amplitude)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: amplitude          !! of the velocity [m/s]
      integer :: i
      do i = 1, m%particles%n
         m%particles%velocity(i, 1) = amplitude*exp(-0.5_dp*((m%particles%reference(i, 1) - 0.3_dp)/0.04_dp)**2)
      end do
      m%particles%gradient(:, 1, 1) = -m%particles%velocity(:, 1)
   end subroutine put_pulse

   !> A compressive pulse goes through a line as through a whole bar, but for the layer between its faces, which is as soft as a third
   !> of a cell; a tensile one comes back as from a free end, and the faces open.
   subroutine pulses(scheme, mass)
      character(*), intent(in) :: scheme, mass
      integer, parameter :: n_cells(3) = [50, 100, 200]
      real(dp), parameter :: cut_at = 0.6_dp, amplitude = 1.0e-6_dp
      type(problem_t) :: whole, cut
      real(dp) :: through(3), back(3), opening
      integer :: n, steps, i
      do n = 1, 3
         steps = nint(0.5_dp*n_cells(n)/0.2_dp)
         call build_bar(n_cells(n), 2.0_dp, whole, 1.0_dp)
         call build_bar(n_cells(n), cut_at, cut, 1.0_dp)
         call put_pulse(whole, amplitude)
         call put_pulse(cut, amplitude)
         call start(whole, scheme, choice_of(mass, 'direct'))
         call start(cut, scheme, choice_of(mass, 'direct'))
         call run_steps(whole, 0.5_dp/steps, steps)
         call run_steps(cut, 0.5_dp/steps, steps)
         through(n) = difference(cut, whole)
         call build_bar(n_cells(n), 2.0_dp, whole, cut_at)
         call build_bar(n_cells(n), cut_at, cut, 1.0_dp)
         call put_pulse(whole, -amplitude)
         call put_pulse(cut, -amplitude)
         call start(whole, scheme, choice_of(mass, 'direct'))
         call start(cut, scheme, choice_of(mass, 'direct'))
         call check(whole%interfaces%n == 0 .and. cut%interfaces%n_contact > 0, 'faces are where the line is')
         call run_steps(whole, 0.5_dp/steps, steps)
         call run_steps(cut, 0.5_dp/steps, steps)
         back(n) = difference(cut, whole)
         associate (list => cut%interfaces%list)
            opening = maxval([(dot_product(list(i)%normal, list(i)%opening), i=1, cut%interfaces%n)])
            opening = max(opening, maxval([(-overlap_of(list(i)), i=1, cut%interfaces%n)]))
         end associate
      end do
      write (*, '(a6,a7,a,3es9.1,a,2f5.1,a,3es9.1,a,es11.3)') scheme, mass, ' pulse through a line, difference to a whole bar:', &
         through, '  order', log(through(:2)/through(2:))/log(2.0_dp), '; back:', back, '; opening over that of a free end', &
         opening/(2*amplitude*0.04_dp*sqrt(2*acos(-1.0_dp)))
      call check(log(through(2)/through(3))/log(2.0_dp) > 0.9_dp, scheme//', '//mass//': the difference to a whole bar converges')
      ! Nodes of faces have lumped masses, whatever the others have
      call check(back(3) < merge(1.0e-4_dp, 1.0e-3_dp, mass == 'lumped'), &
                 scheme//', '//mass//': tension comes back as from a free end')
      call check_close(opening/(2*amplitude*0.04_dp*sqrt(2*acos(-1.0_dp))), 1.0_dp, 1.0e-3_dp, &
                       scheme//', '//mass//': the faces open as theory says')
   end subroutine pulses

   !> Rms difference of the velocities of two motions over the rms of one of them, by particles that both have.
   real(dp) function difference(a, b)
      type(problem_t), intent(in) :: a, b
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

   !> Two blocks slide over each other while opposite forces press them together.
   subroutine sliding(scheme, mass)
      character(*), intent(in) :: scheme, mass
      real(dp), parameter :: speed = 0.02_dp, force(ndim) = [0.0_dp, 1.0e-4_dp]
      type(problem_t) :: m
      type(line_t) :: lines(1)
      real(dp) :: initial, momentum(ndim), half(2), residual
      integer :: i
      lines(1) = line_between([-100.0_dp, block_line], [100.0_dp, block_line], .false.)
      call place_bodies(forest_t([0.0_dp, 0.0_dp], block_cell, [20, 14]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([0.64_dp, 0.4_dp], [1.24_dp, block_line], [12, 6], [-speed, 0.0_dp]), &
                         rectangle_t([0.56_dp, block_line], [1.16_dp, 1.0_dp], [12, 6], [speed, 0.0_dp])], m, lines)
      m%particles%total_frame = .true.
      m%audit = .true.
      allocate (m%loads(2))
      m%loads(1)%force = force
      m%loads(2)%force = -force
      call load_on_particles(m%particles, [0.0_dp, 0.0_dp], [2.0_dp, block_line], m%loads(1))
      call load_on_particles(m%particles, [0.0_dp, block_line], [2.0_dp, 2.0_dp], m%loads(2))
      call start(m, scheme, choice_of(mass, order=2))
      initial = total_energy(m)
      call run_steps(m, 0.01_dp, 400)
      associate (p => m%particles)
         do i = 1, ndim
            momentum(i) = sum(p%mass*p%velocity(:, i))/(speed*sum(p%mass))
         end do
         do i = 1, 2
            half(i) = sum(p%mass*p%velocity(:, 1), mask=p%body == i)/(speed*sum(p%mass)/2) + 3 - 2*i
         end do
      end associate
      residual = (energy_residual(m, initial) + interface_energy(m%interfaces))/initial
      write (*, '(a6,a7,a,4es9.1,a,i3,a,es9.1,a,es9.1,a,es9.1)') scheme, mass, ' sliding, momentum', momentum, half, ' pressed', &
         pressed(m), ' residual', residual, ' loss', m%energies%numerical_loss/initial, ' strain', maxval(abs(m%particles%gradient))
      call check(maxval(abs([momentum, half])) < 1.0e-13_dp, &
                 scheme//', '//mass//': momentum stays, and that along the line of each block')
      call check(pressed(m) > 4, scheme//', '//mass//': they are pressed together')
      call check_close(residual, 0.0_dp, 1.0e-13_dp, scheme//', '//mass//': the audit of sliding blocks closes')
   end subroutine sliding

   !> How many interface points are pressed together.
   pure integer function pressed(m)
      type(problem_t), intent(in) :: m
      integer :: i
      associate (list => m%interfaces%list)
         pressed = count([(list(i)%law == contact .and. overlap_of(list(i)) > 0, i=1, m%interfaces%n)])
      end associate
   end function pressed

   !> A block on its ground, cut into halves where `is_cut`, with pressure on its top.
   subroutine build_pressed(is_cut, side, m)
      logical, intent(in) :: is_cut
      integer, intent(in) :: side                !! particles in a row
      type(problem_t), intent(out) :: m
      type(line_t), allocatable :: lines(:)
      integer :: i
      allocate (lines(merge(1, 0, is_cut)))
      if (is_cut) lines(1) = line_between([-100.0_dp, block_line], [100.0_dp, block_line], .false.)
      call place_bodies(forest_t([0.0_dp, 0.0_dp], block_cell, [16, 14]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([0.3_dp, 0.2_dp], [1.3_dp, 1.2_dp], [side, side])], m, lines)
      call constrain_box(m%constraints, m%grid, [0.0_dp, 0.2_dp], [2.0_dp, 0.2_dp], [.false., .true.])
      m%particles%total_frame = .true.
      m%audit = .true.
      m%damping_rate = 2
      allocate (m%loads(1))
      m%loads(1)%force = [0.0_dp, -1.0e-3_dp]
      call load_on_points(m%matter_t, reshape([(0.3_dp + (i - 0.5_dp)/side, 1.2_dp, i=1, side)], [ndim, side]), [0.0_dp, 0.0_dp], &
                          m%loads(1))
      call start(m, 'musl')
   end subroutine build_pressed

   !> Halves that are pressed together come to rest as one block does, and stay together.
   subroutine pressed_halves()
      integer, parameter :: side = 20
      type(problem_t) :: whole, cut
      real(dp) :: strain(side**2, ndim, ndim, 2), initial, work
      integer :: i, parted
      call build_pressed(.false., side, whole)
      call build_pressed(.true., side, cut)
      initial = total_energy(cut)
      call run_steps(whole, 0.02_dp, 1200)
      parted = 0
      do i = 1, 1200
         call run_steps(cut, 0.02_dp, 1)
         if (i > 200 .and. pressed(cut) < cut%interfaces%n_contact) parted = parted + 1
      end do
      strain(whole%particles%id, :, :, 1) = whole%particles%gradient
      strain(cut%particles%id, :, :, 2) = cut%particles%gradient
      work = cut%energies%external_work
      write (*, '(a,2es9.1,a,i5,a,2es9.1)') 'pressed: strain difference, spread', &
         maxval(abs(strain(:, :, :, 2) - strain(:, :, :, 1)))/maxval(abs(strain)), &
         (maxval(strain(:, 2, 2, 2)) - minval(strain(:, 2, 2, 2)))/maxval(abs(strain)), ' steps parted', parted, &
         ' residual, kinetic', (energy_residual(cut, initial) + interface_energy(cut%interfaces))/work, &
         kinetic_energy(cut%particles)/work
      call check(maxval(abs(strain(:, :, :, 2) - strain(:, :, :, 1))) < 2.0e-3_dp*maxval(abs(strain)), &
                 'the strain in pressed halves is that in a whole block')
      call check(parted == 0, 'they touch everywhere, and never part again')
      call check_close((energy_residual(cut, initial) + interface_energy(cut%interfaces))/work, 0.0_dp, 1.0e-13_dp, &
                       'the audit of pressed halves closes')
   end subroutine pressed_halves
end program test_grid_lines
