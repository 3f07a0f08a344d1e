!> Local time stepping by leapfrog steps:
!>
!>    groups      differ by one at most between cells that share a node, and no rate is slower than what it follows;
!>    choice      coarse steps fill the time to the next output;
!>    momentum    of a free body is conserved, whatever the mesh;
!>    definition  the mean force is that of a plain recursion over particles;
!>    stability   no vibration of the mesh grows, up to 0.9 of the limit of common steps;
!>    rest        equilibrium by statics and by common steps is equilibrium;
!>    energy      of a vibrating body neither grows nor decays over many periods;
!>    motion      is that of short common steps, the closer the shorter the steps: with second order;
!>    same bytes  on any number of threads.
program test_local_leapfrog
   use hampm_kinds, only: dp, ndim, long
   use hampm_constraints, only: constrain_box
   use hampm_equilibrium, only: equilibrium_t
   use hampm_failure, only: failure_t
   use hampm_fine_region, only: fine_region_t, find_region
   use hampm_graded_body, only: place_graded, run_coarsely, mean_energy, same_numbers, cell, limit
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_lapack, only: dsyev
   use hampm_loads, only: load_on_particles
   use hampm_mean_force, only: mean_force_t, make_room, add_mean_change, theta
   use hampm_problem, only: problem_t, map_to_grid, assemble_sums
   use hampm_local_leapfrog, only: local_leapfrog_t
   use hampm_samples, only: run_steps, start
   use hampm_step_groups, only: limit_groups
   use hampm_text, only: to_text
   use hampm_threads, only: use_threads
   implicit none

   call repeat_random_numbers()
   call test_groups()
   call test_choice()
   call test_momentum()
   call test_definition()
   call test_stability()
   call test_rest()
   call test_energy()
   call test_convergence()
   call test_threads()
   call finish()

contains

   !> A body that is held at its left edge.
   subroutine place(levels, m, at_corner)
      integer, intent(in) :: levels
      type(problem_t), intent(out) :: m
      logical, intent(in), optional :: at_corner
      call place_graded(levels, 'linear_elastic', 'total', m, at_corner)
      call constrain_box(m%constraints, m%grid, [1.0_dp, 0.0_dp], [1.0_dp, 6.0_dp], [.true., .true.])
      call start(m, 'musl')
   end subroutine place

   subroutine test_groups()
      type(problem_t) :: m
      integer :: b, e, k, c
      integer, allocatable :: least(:), most(:)
      real(dp) :: size_of_group
      call place_graded(4, 'linear_elastic', 'total', m)
      associate (g => m%blocks%groups, grid => m%grid)
         call check(g%largest >= 3, 'there are groups')
         allocate (least(grid%n_points), source=huge(1))
         allocate (most(grid%n_points), source=-1)
         do k = 1, m%blocks%n_occupied
            e = m%blocks%occupied(k)
            size_of_group = cell*2.0_dp**(g%of_cell(e) - 4)
            call check(size_of_group < 1.01_dp*grid%element_size(e), 'no cell takes a step that its size does not allow')
            call check(size_of_group > 0.49_dp*grid%element_size(e), 'or less than half of that')
            do c = 1, 4
               least(grid%element_nodes(c, e)) = min(least(grid%element_nodes(c, e)), g%of_cell(e))
               most(grid%element_nodes(c, e)) = max(most(grid%element_nodes(c, e)), g%of_cell(e))
            end do
            call check(g%kick_interval(e) == minval(g%force_interval(grid%element_nodes(:, e))), &
                       'a cell is kicked when its nodes are')
         end do
         call check(all(most - least <= 1 .or. most < 0), 'cells that share a node differ by one group at most')
         call check(all(g%force_interval <= least .and. g%velocity_interval <= g%force_interval), &
                    'nodes are as fast as the cells around them')
         do b = 1, m%blocks%n
            associate (cells => m%blocks%cells(:, b))
               do k = 2, count(cells > 0)
                  call check(g%by_size(cells(k)) == g%by_size(cells(1)), 'blocks are of one group')
               end do
               if (b > 1) call check(g%by_size(cells(1)) >= g%by_size(m%blocks%cells(1, b - 1)), 'blocks stand in order')
            end associate
         end do
      end associate
   end subroutine test_groups

   !> Coarse steps fill a time, none being longer than the limit, and a time between rows has steps of one length.
   subroutine test_choice()
      type(problem_t) :: m
      type(local_leapfrog_t) :: c
      integer(long) :: steps
      real(dp) :: dt
      integer :: k
      call place(3, m)
      do k = 1, 40
         call c%choose_steps(m, real(k, dp), 1.0_dp, steps, dt)
         call check(steps*2**c%largest >= k .and. c%largest <= m%blocks%groups%largest, 'the coarse steps fill the time')
         call check_close(steps*2**c%largest*dt, real(k, dp), 1.0e-12_dp*k, 'to its end')
      end do
      call c%choose_steps(m, 1.0e9_dp, 1.0_dp, steps, dt)
      call check(c%largest == m%blocks%groups%largest, 'a long time has the longest coarse steps')
      call c%choose_steps(m, 0.5_dp, 1.0_dp, steps, dt)
      call check(c%largest == 0 .and. steps == 1, 'a short time is one step')
   end subroutine test_choice

   !> Random velocities of a body that nothing holds.
   subroutine test_momentum()
      type(problem_t) :: m
      type(local_leapfrog_t) :: c, fresh
      real(dp) :: before(ndim), after(ndim), scale
      real(dp), allocatable :: noise(:, :)
      integer :: levels
      do levels = 1, 3
         call place_graded(levels, 'linear_elastic', 'total', m)
         allocate (noise(m%particles%n, ndim))
         call random_number(noise)
         m%particles%velocity = 1.0e-4_dp*(noise - 0.4_dp)
         deallocate (noise)
         call start(m, 'musl')
         before = matmul(m%particles%mass, m%particles%velocity)
         scale = sum(m%particles%mass)*maxval(abs(m%particles%velocity))
         c = fresh
         call run_coarsely(c, m, 0.5_dp*cell*2.0_dp**(-levels)/limit, levels, 100/2**levels)
         after = matmul(m%particles%mass, m%particles%velocity)
         call check_close(maxval(abs(after - before))/scale, 0.0_dp, 1.0e-13_dp, &
                          to_text(levels)//' levels: momentum is conserved')
      end do
   end subroutine test_momentum

   !> The mean force is the one that the definition has, for random forces, whatever the levels and the limit of the groups.
   subroutine test_definition()
      type(problem_t) :: m
      type(fine_region_t) :: region
      type(mean_force_t) :: mean
      real(dp), allocatable :: force(:, :), asked(:, :), kick(:, :), found(:, :)
      real(dp) :: dt
      integer :: levels, largest
      do levels = 1, 4
         call place(levels, m)
         call map_to_grid(m)
         call assemble_sums(m, mass=.true., momentum=.true., force=.true.)
         dt = 0.5_dp*cell*2.0_dp**(-levels)/limit
         do largest = 1, m%blocks%groups%largest
            call limit_groups(m%grid, m%blocks%occupied(:m%blocks%n_occupied), largest, m%blocks%groups)
            associate (f => m%fields, list => m%fields%mass_matrix%all)
               call find_region(largest, m%blocks, m%grid%dofs, list, m%constraints%free, f%mass_matrix%inverse_lumped, &
                                m%particles, region)
               call make_room(region, mean)
               allocate (force(ndim, m%grid%n_points), source=0.0_dp)
               allocate (kick, found, asked, source=force)
               call random_number(force)
               force(:, m%grid%dofs%n_nodes + 1:) = 0
               kick = over_mass(m, force)
               asked = effective(m, largest, largest, dt, 0*force, force)
               call add_mean_change(mean, m%materials, m%blocks, dt, kick, force)
               found = kicked(m, force)
            end associate
            call check_close(maxval(abs(found - asked))/maxval(abs(asked)), 0.0_dp, 1.0e-12_dp, &
                             to_text(levels)//' levels, groups up to '//to_text(largest)//': the mean force is as defined')
            deallocate (force, kick, found, asked)
         end do
      end do
   end subroutine test_definition

   !> A coarse step T takes s(t + T) - 2 s(t) + s(t - T) = T^2 A s, A being the effective acceleration: bounded for ever where all eigenvalues
   !> of -T^2 A are between 0 and 4. Those of common steps are so up to 1.03 h/c_s (docs/explanation/mass.md).
   subroutine test_stability()
      type(problem_t) :: m
      real(dp), allocatable :: unit(:, :), stiffness(:, :), a(:, :), eigenvalues(:)
      real(dp), parameter :: courant = 0.9_dp*1.03_dp
      integer :: levels, j, d
      do levels = 1, 3
         call place(levels, m, at_corner=.true.)
         call map_to_grid(m)
         call assemble_sums(m, mass=.true., momentum=.true., force=.true.)
         associate (largest => m%blocks%groups%largest, list => m%fields%mass_matrix%all, &
                    dt => courant*cell*2.0_dp**(-levels)/limit)
            call limit_groups(m%grid, m%blocks%occupied(:m%blocks%n_occupied), largest, m%blocks%groups)
            allocate (a(ndim*list%n_nodes, ndim*list%n_nodes))
            stiffness = a
            do j = 1, list%n_nodes
               do d = 1, ndim
                  allocate (unit(ndim, m%grid%n_points), source=0.0_dp)
                  unit(d, list%nodes(j)) = m%constraints%free(d, list%nodes(j))
                  associate (column => ndim*(j - 1) + d)
                     stiffness(:, column) = -at_nodes(m, all_forces(m, unit))
                     a(:, column) = -(2**largest*dt)**2*at_nodes(m, effective(m, largest, largest, dt, unit, 0*unit))
                  end associate
                  deallocate (unit)
               end do
            end do
            call find_eigenvalues(stiffness, a, eigenvalues)
            write (*, '(i2,a,2f9.4)') largest, ' groups, T^2 times eigenvalues', minval(eigenvalues), maxval(eigenvalues)
            call check(minval(eigenvalues) > 0 .and. maxval(eigenvalues) < 3.95_dp, to_text(levels)//' levels: stable')
            deallocate (a)
         end associate
      end do
   end subroutine test_stability

   !> The vectors of the nodes that move.
   pure function at_nodes(m, x) result(values)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: x(:, :)
      real(dp), allocatable :: values(:)
      associate (list => m%fields%mass_matrix%all)
         values = reshape(x(:, list%nodes(:list%n_nodes)), [ndim*list%n_nodes])
      end associate
   end function at_nodes

   !> Eigenvalues of A = Q K, K and Q being symmetric and K positive: with K = V k V', those of k**(-1/2) V' K A V k**(-1/2). Where k is
   !> 0 nothing moves.
   subroutine find_eigenvalues(stiffness, a, eigenvalues)
      real(dp), intent(in) :: stiffness(:, :), a(:, :)
      real(dp), allocatable, intent(out) :: eigenvalues(:)
      real(dp), allocatable :: vectors(:, :), moving(:, :), product(:, :)
      real(dp) :: values(size(a, 1)), work(10*size(a, 1))
      integer :: k, n, info
      allocate (vectors, source=stiffness)
      call dsyev('V', 'L', size(a, 1), vectors, size(a, 1), values, work, size(work), info)
      call check(info == 0, 'eigenvectors of the stiffness')
      n = count(values > 1.0e-10_dp*maxval(values))
      allocate (moving(size(a, 1), n))
      do k = 1, n
         associate (at => size(values) - n + k)
            moving(:, k) = vectors(:, at)/sqrt(values(at))
         end associate
      end do
      product = matmul(transpose(moving), matmul(stiffness, matmul(a, moving)))
      call check(maxval(abs(product - transpose(product))) < 1.0e-12_dp, 'Q is symmetric')
      allocate (eigenvalues(n))
      call dsyev('N', 'L', n, product, n, eigenvalues, work, size(work), info)
      call check(info == 0, 'eigenvalues of the effective acceleration')
   end subroutine find_eigenvalues

   !> Do some coarse steps.
   subroutine run_leapfrog(m, dt, largest, steps)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! finest step [s]
      integer, intent(in) :: largest, steps
      type(local_leapfrog_t) :: c
      call run_coarsely(c, m, dt, largest, steps)
   end subroutine run_leapfrog

   !> Longest step of the finest cells, for a courant number of 0.5 [s].
   pure real(dp) function longest(levels)
      integer, intent(in) :: levels
      longest = 0.5_dp*cell*2.0_dp**(-levels)/limit
   end function longest

   !> Start to vibrate in bending, clamped at one end.
   subroutine vibrate(m)
      type(problem_t), intent(inout) :: m
      m%particles%velocity(:, 2) = 1.0e-8_dp*(m%particles%reference(:, 1) - 1)**2
      m%cache%mapped = .false.
   end subroutine vibrate

   !> A load at the free end that acts at once.
   subroutine pull(m)
      type(problem_t), intent(inout) :: m
      deallocate (m%loads)
      allocate (m%loads(1))
      m%loads(1)%force = [0.0_dp, 1.0e-8_dp]
      call load_on_particles(m%particles, [6.5_dp, 2.0_dp], [7.0_dp, 4.0_dp], m%loads(1))
   end subroutine pull

   !> What is in equilibrium by statics stays where it is, and common steps leave it there too.
   subroutine test_rest()
      type(problem_t) :: m
      type(failure_t) :: failure
      real(dp), allocatable :: before(:, :, :)
      integer :: levels
      do levels = 1, 3
         call place(levels, m)
         call pull(m)
         block
            type(equilibrium_t) :: statics       ! a new one of each body
            call statics%initialise(m, 0.0_dp, failure)
            call statics%finish()
         end block
         call check(.not. failure%failed(), to_text(levels)//' levels: equilibrium is found')
         allocate (before, source=m%particles%gradient)
         call run_steps(m, longest(levels), 50*2**levels)
         call check_close(maxval(abs(m%particles%gradient - before))/maxval(abs(before)), 0.0_dp, 1.0e-9_dp, &
                          to_text(levels)//' levels: common steps leave it at rest')
         call run_leapfrog(m, longest(levels), m%blocks%groups%largest, 50)
         call check_close(maxval(abs(m%particles%gradient - before))/maxval(abs(before)), 0.0_dp, 1.0e-9_dp, &
                          to_text(levels)//' levels: so do coarse ones')
         deallocate (before)
      end do
   end subroutine test_rest

   !> The mean energy in the last of many coarse steps is that in the first of them.
   subroutine test_energy()
      type(local_leapfrog_t) :: c, fresh
      type(problem_t) :: m
      real(dp) :: first, last
      integer, parameter :: averaged = 300
      integer :: levels
      do levels = 1, 3
         call place(levels, m)
         c = fresh
         call vibrate(m)
         first = mean_energy(c, m, longest(levels), m%blocks%groups%largest, averaged)
         call run_coarsely(c, m, longest(levels), m%blocks%groups%largest, 1500)
         last = mean_energy(c, m, longest(levels), m%blocks%groups%largest, averaged)
         call check_close(last/first, 1.0_dp, 1.0e-3_dp, to_text(levels)//' levels: the energy does not drift')
      end do
   end subroutine test_energy

   !> Some bending, with coarse steps and with very short common ones.
   subroutine test_convergence()
      type(problem_t) :: m, exact
      real(dp) :: error(2)
      integer :: k
      integer, parameter :: steps = 24
      call place(3, exact)
      call vibrate(exact)
      call run_steps(exact, longest(3)/8, 8*4*steps)
      do k = 1, 2
         call place(3, m)
         call vibrate(m)
         call run_leapfrog(m, longest(3)/k, 2, k*steps)
         error(k) = norm2(m%particles%gradient - exact%particles%gradient)/norm2(exact%particles%gradient)
      end do
      write (*, '(a,2es10.2)') 'error of the strains', error
      call check(error(1) < 0.02_dp, 'the strains are those of common steps')
      call check_close(log(error(1)/error(2))/log(2.0_dp), 2.0_dp, 0.5_dp, 'they converge with second order')
   end subroutine test_convergence

   subroutine test_threads()
      type(problem_t) :: alone, together
      call place(4, alone)
      call vibrate(alone)
      alone%damping_rate = 0.1_dp
      together = alone
      call run_leapfrog(alone, longest(4), alone%blocks%groups%largest, 10)
      call use_threads(2, together%particles%n)
      call run_leapfrog(together, longest(4), together%blocks%groups%largest, 10)
      call use_threads(1, together%particles%n)
      call check(same_numbers(alone%particles%displacement(:, 2), together%particles%displacement(:, 2)) .and. &
                 same_numbers(alone%particles%velocity(:, 2), together%particles%velocity(:, 2)) .and. &
                 same_numbers([alone%energies%damping_loss], [together%energies%damping_loss]), &
                    'the same bytes on one and two threads')
   end subroutine test_threads

   !> The effective acceleration of a group.
   recursive function effective(m, group, largest, dt, d, c) result(a)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: group, largest
      real(dp), intent(in) :: dt, d(:, :), c(:, :)
      real(dp) :: a(ndim, size(d, 2)), held(ndim, size(d, 2)), half(ndim, size(d, 2))
      held = c + forces(m, group, d)
      if (group == 0) then
         a = kicked(m, held)
      else
         half = effective(m, group - 1, largest, dt, d, held)
         a = 0.5_dp*(half + effective(m, group - 1, largest, dt, &
                                      d + 0.5_dp*theta(group - 1, largest)*(2**(group - 1)*dt)**2*half, held))
      end if
   end function effective

   !> D**-1 f with hanging nodes.
   function over_mass(m, force) result(a)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: force(:, :)
      real(dp) :: a(ndim, size(force, 2))
      integer :: k
      a = 0
      do k = 1, m%fields%mass_matrix%all%n_nodes
         associate (i => m%fields%mass_matrix%all%nodes(k))
            a(:, i) = m%constraints%free(:, i)*force(:, i)/m%fields%mass_matrix%lumped(i)
         end associate
      end do
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, a)
   end function over_mass

   !> D**-1 M D**-1 f.
   function kicked(m, force) result(a)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: force(:, :)
      real(dp) :: a(ndim, size(force, 2)), q(ndim, size(force, 2)), momentum(ndim, size(force, 2)), n(4), v(ndim)
      integer :: i, c
      q = over_mass(m, force)
      momentum = 0
      do i = 1, m%particles%n
         associate (nodes => m%grid%element_nodes(:, m%particles%cell(i)))
            n = shapes([m%particles%local(i, 1), m%particles%local(i, 2)])
            v = matmul(q(:, nodes), n)
            do c = 1, 4
               momentum(:, nodes(c)) = momentum(:, nodes(c)) + m%particles%mass(i)*n(c)*v
            end do
         end associate
      end do
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, momentum)
      a = over_mass(m, momentum)
   end function kicked

   !> By what the forces of the cells of a group change where nodes are displaced.
   function forces(m, group, d) result(force)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: group
      real(dp), intent(in) :: d(:, :)
      real(dp) :: force(ndim, size(d, 2)), u(ndim, size(d, 2)), h(ndim, ndim), stress(ndim, ndim), slope(ndim, 4)
      integer :: i, c
      force = 0
      u = d
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, u)
      do i = 1, m%particles%n
         associate (e => m%particles%cell(i), material => m%materials(m%particles%material(i)))
            if (m%blocks%groups%of_cell(e) /= group) cycle
            slope = slopes([m%particles%local(i, 1), m%particles%local(i, 2)])/m%grid%element_size(e)
            h = matmul(u(:, m%grid%element_nodes(:, e)), transpose(slope))
            stress = material%mu*(h + transpose(h))
            do c = 1, ndim
               stress(c, c) = stress(c, c) + material%lambda*(h(1, 1) + h(2, 2))
            end do
            do c = 1, 4
               force(:, m%grid%element_nodes(c, e)) = force(:, m%grid%element_nodes(c, e)) &
                                                      - m%particles%volume(i)*matmul(stress, slope(:, c))
            end do
         end associate
      end do
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, force)
   end function forces

   !> By what the forces of all cells change, on nodes that are free.
   function all_forces(m, d) result(force)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: d(:, :)
      real(dp) :: force(ndim, size(d, 2))
      integer :: group
      force = 0
      do group = 0, m%blocks%groups%largest
         force = force + forces(m, group, d)
      end do
      force = m%constraints%free*force
   end function all_forces

   !> Shape functions, and their derivatives.
   pure function shapes(xi) result(n)
      real(dp), intent(in) :: xi(ndim)
      real(dp) :: n(4)
      n = [(1 - xi(1))*(1 - xi(2)), xi(1)*(1 - xi(2)), (1 - xi(1))*xi(2), xi(1)*xi(2)]
   end function shapes

   pure function slopes(xi) result(n)
      real(dp), intent(in) :: xi(ndim)
      real(dp) :: n(ndim, 4)
      n(1, :) = [xi(2) - 1, 1 - xi(2), -xi(2), xi(2)]
      n(2, :) = [xi(1) - 1, -xi(1), 1 - xi(1), xi(1)]
   end function slopes
end program test_local_leapfrog
