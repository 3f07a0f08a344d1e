!> Time steps that fit the size of the cells, against the step of all cells together:
!>
!>    groups      differ by one at most between cells that share a node, and no rate is slower than what it follows;
!>    same bytes  where all cells are of one size, and on any number of threads;
!>    momentum    of a free body is conserved, whatever the mesh;
!>    energy      of a vibrating body neither grows nor decays over many periods;
!>    motion      is that of short common steps, the closer the shorter the steps: with second order;
!>    audit       damping and work of the loads are booked such that the balance stays closed within the method's own ripple.
program test_subcycled
   use hampm_kinds, only: dp, ndim, long
   use hampm_constraints, only: constrain_box
   use hampm_graded_body, only: place_graded, run_coarsely, mean_energy, same_numbers, cell, limit
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_loads, only: load_on_particles
   use hampm_motion, only: motion_t
   use hampm_samples, only: start, run_steps, total_energy
   use hampm_subcycled, only: subcycled_t
   use hampm_text, only: to_text
   use hampm_threads, only: use_threads
   implicit none

   call repeat_random_numbers()
   call test_groups()
   call test_one_size()
   call test_turns()
   call test_threads()
   call test_momentum()
   call test_energy()
   call test_convergence()
   call test_balance()
   call test_choice()
   call finish()

contains

   !> Do some coarse steps.
   subroutine run_impulses(m, dt, largest, steps)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt
      integer, intent(in) :: largest, steps
      type(subcycled_t) :: c
      call run_coarsely(c, m, dt, largest, steps)
   end subroutine run_impulses

   subroutine test_groups()
      type(motion_t) :: m
      integer :: b, e, k, c
      integer, allocatable :: least(:), most(:)
      real(dp) :: size_of_group
      call place_graded(4, 'linear_elastic', 'updated', m)
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

   !> With cells of one size a coarse step is two ordinary ones, in which particles stay: in the total frame that is no difference.
   subroutine test_one_size()
      type(motion_t) :: together, apart
      call place_graded(0, 'neo_hookean', 'total', apart)       ! whose cells are always swept particle by particle
      together = apart
      call vibrate(apart)
      call vibrate(together)
      call run_impulses(apart, 0.4_dp, 1, 10)
      call run_steps(together, 0.4_dp, 20)
      call check(same_numbers(apart%particles%velocity(:, 2), together%particles%velocity(:, 2)) .and. &
                 same_numbers(apart%particles%gradient(:, 1, 2), together%particles%gradient(:, 1, 2)), &
                 'cells of one size: velocities and strains have the same bytes')
      call check(maxval(abs(apart%particles%displacement - together%particles%displacement)) < 1.0e-18_dp, &
                 'cells of one size: displacements are the same but for rounding')
      call run_impulses(apart, 0.4_dp, 0, 1)
      call run_steps(together, 0.4_dp, 1)
      call check(same_numbers(apart%particles%velocity(:, 2), together%particles%velocity(:, 2)), 'a coarse step of one is a step')
   end subroutine test_one_size

   !> Cells of a linear material answer by themselves in ordinary steps, and are swept in coarse ones: both may take turns.
   subroutine test_turns()
      type(motion_t) :: together, apart
      integer :: k
      call place_graded(0, 'linear_elastic', 'total', apart)
      together = apart
      call vibrate(apart)
      call vibrate(together)
      do k = 1, 5
         call run_impulses(apart, 0.4_dp, 0, 3)
         call run_impulses(apart, 0.4_dp, 1, 2)
      end do
      call run_steps(together, 0.4_dp, 35)
      call check(together%operators%is_active, 'cells answer by themselves')
      call check(maxval(abs(apart%particles%velocity - together%particles%velocity)) < &
                 1.0e-12_dp*maxval(abs(together%particles%velocity)), 'ordinary and coarse steps may take turns: velocities')
      call check(maxval(abs(apart%particles%gradient - together%particles%gradient)) < &
                 1.0e-12_dp*maxval(abs(together%particles%gradient)), 'ordinary and coarse steps may take turns: strains')
   end subroutine test_turns

   subroutine test_threads()
      type(motion_t) :: alone, together
      call place_graded(3, 'neo_hookean', 'updated', alone)
      call push(alone)
      together = alone
      call start(alone, 'musl')
      call start(together, 'musl')
      call run_impulses(alone, 0.05_dp, 3, 10)
      call use_threads(2, together%particles%n)
      call run_impulses(together, 0.05_dp, 3, 10)
      call use_threads(1, together%particles%n)
      call check(all(alone%particles%id == together%particles%id) .and. &
                 same_numbers(alone%particles%displacement(:, 1), together%particles%displacement(:, 1)) .and. &
                 same_numbers(alone%particles%velocity(:, 2), together%particles%velocity(:, 2)) .and. &
                 same_numbers([alone%damping_loss, alone%external_work], [together%damping_loss, together%external_work]), &
                 'the same bytes on one and two threads')
      call check(alone%blocks%sorts > 1, 'particles crossed')
   end subroutine test_threads

   !> Random velocities, a load and damping.
   subroutine push(m)
      type(motion_t), intent(inout) :: m
      real(dp) :: noise(m%particles%n, ndim)
      call random_number(noise)
      m%particles%velocity = 0.02_dp*(noise - 0.5_dp)
      m%damping_rate = 0.1_dp
      allocate (m%loads(1))
      m%loads(1)%force = [0.01_dp, 0.02_dp]
      call load_on_particles(m%particles, [1.0_dp, 2.0_dp], [2.0_dp, 4.0_dp], m%loads(1))
   end subroutine push

   subroutine test_momentum()
      type(motion_t) :: m
      real(dp) :: before(ndim), after(ndim), scale
      real(dp), allocatable :: noise(:, :)
      integer :: levels
      do levels = 1, 3
         call place_graded(levels, 'linear_elastic', 'updated', m)
         allocate (noise(m%particles%n, ndim))
         call random_number(noise)
         m%particles%velocity = 1.0e-4_dp*(noise - 0.4_dp)
         deallocate (noise)
         call start(m, 'musl')
         before = matmul(m%particles%mass, m%particles%velocity)
         scale = sum(m%particles%mass)*maxval(abs(m%particles%velocity))
         call run_impulses(m, 0.5_dp*limit_of(levels), levels, 100/2**levels)
         after = matmul(m%particles%mass, m%particles%velocity)
         call check_close(maxval(abs(after - before))/scale, 0.0_dp, 1.0e-13_dp, &
                          to_text(levels)//' levels: momentum is conserved')
      end do
   end subroutine test_momentum

   !> Longest step of the finest cells, for a courant number of 1 [s].
   pure real(dp) function limit_of(levels)
      integer, intent(in) :: levels
      limit_of = cell*2.0_dp**(-levels)/limit
   end function limit_of

   !> Let a beam vibrate in bending, clamped at one end.
   subroutine vibrate(m)
      type(motion_t), intent(inout) :: m
      call constrain_box(m%constraints, m%grid, [1.0_dp, 0.0_dp], [1.0_dp, 6.0_dp], [.true., .true.])
      m%particles%velocity(:, 2) = 1.0e-8_dp*(m%particles%reference(:, 1) - 1)**2
      call start(m, 'musl')
   end subroutine vibrate

   !> The mean energy in the last of many coarse steps is that in the first of them. The length of the steps is the default of runs
   !> with these steps, close to the longest that is allowed.
   subroutine test_energy()
      type(subcycled_t) :: c
      type(motion_t) :: m
      real(dp) :: first, last
      integer, parameter :: averaged = 300
      integer :: levels
      do levels = 1, 2
         call place_graded(levels, 'linear_elastic', 'updated', m)
         c = subcycled_t()
         call vibrate(m)
         first = mean_energy(c, m, 0.5_dp*limit_of(levels), levels, averaged)
         call run_coarsely(c, m, 0.5_dp*limit_of(levels), levels, 800/2**levels)
         last = mean_energy(c, m, 0.5_dp*limit_of(levels), levels, averaged)
         write (*, '(a,i0,a,es10.2)') 'levels: ', levels, '  change of the mean energy', last/first - 1
         call check_close(last/first, 1.0_dp, 3.0e-3_dp, to_text(levels)//' levels: the energy does not drift')
      end do
   end subroutine test_energy

   !> Some bending, with coarse steps and with very short common ones: from a velocity, and from rest by a load that acts at once
   !> and one that follows a table. Strains are compared: what moves particles in musl, the velocities v + a dt of the nodes,
   !> differs with the length of the step from those that the particles have.
   subroutine test_convergence()
      call check_convergence('velocity', 0.02_dp)
      call check_convergence('step', 0.02_dp)
      call check_convergence('table', 0.02_dp)
   end subroutine test_convergence

   subroutine check_convergence(by, most)
      character(*), intent(in) :: by
      real(dp), intent(in) :: most               !! error with the longest steps
      type(motion_t) :: m, exact
      real(dp) :: dt, error(2)
      integer :: k
      integer, parameter :: steps = 24
      dt = 0.5_dp*limit_of(2)
      call place_graded(2, 'linear_elastic', 'total', exact)
      call bend(by, exact)
      if (by == 'step') call take_half_of_first(dt/8, exact)
      call run_steps(exact, dt/8, 8*4*steps)
      do k = 1, 2
         call place_graded(2, 'linear_elastic', 'total', m)
         call bend(by, m)
         call run_impulses(m, dt/k, 2, k*steps)
         error(k) = norm2(m%particles%gradient - exact%particles%gradient)/norm2(exact%particles%gradient)
      end do
      write (*, '(a,2es10.2)') by//': error of the strains', error
      call check(error(1) < most, by//': the strains are those of common steps')
      call check_close(log(error(1)/error(2))/log(2.0_dp), 2.0_dp, 0.5_dp, by//': they converge with second order')
   end subroutine check_convergence

   !> Let a beam start to move in bending, clamped at one end.
   subroutine bend(by, m)
      character(*), intent(in) :: by             !! 'velocity', or the kind of history of a load on all of it
      type(motion_t), intent(inout) :: m
      if (by == 'velocity') then
         call vibrate(m)
         return
      end if
      call constrain_box(m%constraints, m%grid, [1.0_dp, 0.0_dp], [1.0_dp, 6.0_dp], [.true., .true.])
      allocate (m%loads(1))
      m%loads(1)%force = [0.0_dp, 1.0e-8_dp]
      m%loads(1)%history%kind = by
      m%loads(1)%history%times = [0.0_dp, 3.0_dp, 11.0_dp]
      m%loads(1)%history%factors = [0.0_dp, 2.0_dp, 1.0_dp]
      call load_on_particles(m%particles, [1.0_dp, 2.0_dp], [7.0_dp, 4.0_dp], m%loads(1))
      call start(m, 'musl')
   end subroutine bend

   !> A common step takes a force as an impulse in its middle: one that sets in at 0 as if it had done so half a step before. Half
   !> of the first impulse puts that right.
   subroutine take_half_of_first(dt, m)
      real(dp), intent(in) :: dt                 !! [s]
      type(motion_t), intent(inout) :: m
      m%loads(1)%history%kind = 'table'
      m%loads(1)%history%times = [0.0_dp, dt]
      m%loads(1)%history%factors = [0.5_dp, 1.0_dp]
   end subroutine take_half_of_first

   !> A damped beam under a load that grows: what is brought in is stored or taken by the damping.
   subroutine test_balance()
      type(motion_t) :: m
      integer :: k
      real(dp) :: error(2)
      do k = 1, 2
         call place_graded(3, 'linear_elastic', 'updated', m)
         allocate (m%loads(1))
         m%loads(1)%force = [0.0_dp, 1.0e-8_dp]
         m%loads(1)%history%kind = 'ramp'
         m%loads(1)%history%rise_time = 20
         call load_on_particles(m%particles, [6.5_dp, 2.0_dp], [7.0_dp, 4.0_dp], m%loads(1))
         m%damping_rate = 0.1_dp
         call constrain_box(m%constraints, m%grid, [1.0_dp, 0.0_dp], [1.0_dp, 6.0_dp], [.true., .true.])
         call start(m, 'musl')
         call run_impulses(m, 0.5_dp*limit_of(3)/k, 3, 120*k)
         error(k) = (total_energy(m) + m%damping_loss - m%external_work)/m%external_work
      end do
      write (*, '(a,2es10.2)') 'error of the energy balance', error
      call check(abs(error(1)) < 5.0e-3_dp, 'the energy balance is closed')
      call check(m%damping_loss > 0.1_dp*m%external_work, 'damping took energy')
      call check(m%steps == 8*120*2 .and. abs(m%time - 120*8*0.5_dp*limit_of(3)) < 1.0e-9_dp*m%time, 'steps and time are counted')
   end subroutine test_balance

   !> Coarse steps fill a time, none being longer than the limit, and fast bodies take none.
   subroutine test_choice()
      type(motion_t) :: m
      type(subcycled_t) :: c
      integer(long) :: steps
      real(dp) :: dt
      integer :: k
      call place_graded(3, 'linear_elastic', 'updated', m)
      call start(m, 'musl')
      do k = 1, 40
         call c%choose_steps(m, real(k, dp), 1.0_dp, steps, dt)
         call check(steps*2**c%largest >= k .and. c%largest <= m%blocks%groups%largest, 'the coarse steps fill the time')
      end do
      call c%choose_steps(m, 1.0e9_dp, 1.0_dp, steps, dt)
      call check(c%largest == m%blocks%groups%largest, 'a long time has the longest coarse steps')
      call c%choose_steps(m, 0.5_dp, 1.0_dp, steps, dt)
      call check(c%largest == 0 .and. steps == 1, 'a short time is one step')
      m%particles%velocity = 1
      call c%choose_steps(m, 1.0e3_dp, 1.0_dp, steps, dt)
      call check(c%largest == 0, 'fast particles take common steps')
   end subroutine test_choice
end program test_subcycled
