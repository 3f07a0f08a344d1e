!> Time steps that fit the size of the cells: cells of group g (`hampm_step_groups`) take steps 2**g times as long as the finest.
!>
!> A coarse step is 2**G finest ones, G being the largest group. For all of it the particles stand still in the grid: shape
!> functions, nodal masses D and cell matrices M stay, and at its end all particles move at once. In it each cell has its turn every
!> 2**g finest steps dt, each node every 2**n for forces and every 2**r for velocities. In each finest step, each at its turn:
!>
!>   1. nodes    take the impulses of the cells whose interval begins, as a whole: dv = dt sum 2**g f / D;
!>   2.          note how far they carry particles: U <- U + 2**r dt (w + dv);
!>   3. cells    kick their particles, v <- v + N dv, and map these anew. Cells in which forces come more often than they have turns
!>               only sum dv up, and map what their particles will have: p <- p + M dv;
!>   4. nodes    find their velocities w = p / D;
!>   5. cells    in which velocities change more often than they have turns sum the displacements of their corners up;
!>   6.          at the ends of their intervals kick by what was summed, strain, and map the force.
!>
!> In cells that are alone with their own group this is the step of musl. With M lumped in 3. it would dissipate; forces that act at
!> the beginning of an interval only, as here, make the whole symplectic, as long as particles stay where they are.
module hampm_local_steps
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_basis, only: shape_functions, inside_cell
   use hampm_failure, only: failure_t
   use hampm_load_history, only: load_history_t
   use hampm_loads, only: add_load
   use hampm_local_kernels, only: gather_at, push_some, divide_some, clear, sum_kick, sum_way
   use hampm_mass_matrix, only: nodes_per_block
   use hampm_nodal_fields, only: nodal_fields_t, new, mapped, momentum_share, force_share, gather
   use hampm_particles, only: particles_t, lanes, smallest_occupied_cell
   use hampm_step, only: motion_t, take_step, settle, map_to_grid, report_jump, end_step
   use hampm_step_groups, only: limit_groups, plain, summing, waiting
   use hampm_step_runs, only: run_t, find_runs, order_by_rate
   use hampm_sweep, only: sweep_t, sweep_report_t, sweep_list, sweep_between, look_for_leavers, blocks_per_task
   implicit none
   private
   public :: local_steps_t, choose_coarse_step, advance_coarsely

   real(dp), parameter :: farthest = 0.5_dp      !! that particles may move in a coarse step, in smallest cells

   !> Which cells take which steps, with the workspace of a coarse step.
   type :: local_steps_t
      integer :: largest = 0                     !! G: a coarse step is 2**G finest ones
      integer, private :: sorts = -1             !! which sort of the particles the following belongs to
      type(run_t), allocatable, private :: runs(:)
      integer, allocatable, private :: points(:) !! those around which there are particles, by the rate of their velocities;
      integer, allocatable, private :: nodes(:)               !! and the nodes
      integer, allocatable, private :: dependents(:)          !! and the dependent points among them
      integer, allocatable, private :: points_until(:)        !! how many have a rate not above one, (0:largest)
      integer, allocatable, private :: nodes_until(:), dependents_until(:)
      ! Of cells that sum and wait, beside the nodes: fields of the corners of the blocks, (ndim, corners, lanes, n_blocks)
      integer, allocatable, private :: corner(:, :, :)        !! numbers of the corners, (corners, lanes, n_blocks)
      logical, allocatable, private :: in_row(:)              !! whether these are two rows: no; (n_blocks)
      real(dp), allocatable, private :: kick(:, :, :, :)      !! sum of the accelerations [m/s2] and
      real(dp), allocatable, private :: way(:, :, :, :)       !! sum of the velocities [m/s] since the last turn, each as many times
                                                              !! as it has acted for dt
      real(dp), allocatable, private :: move(:, :, :, :)      !! the same of what moves particles, since the coarse step began [m/s]
      real(dp), allocatable, private :: matrix(:, :, :, :)    !! M of the cells that wait [kg], (lanes, corners, corners, n_blocks)
      real(dp), allocatable, private :: load(:, :, :)         !! of each load with a factor of 1 [N], (ndim, n_points, loads)
      real(dp), allocatable, private :: partial_power(:)      !! workspace, by blocks of nodes
   end type local_steps_t

contains

   !> Choose how many finest steps a coarse one takes, and how many coarse ones fill a time: those that do the least work. No
   !> finest step is longer than `limit`.
   subroutine choose_coarse_step(c, m, time, limit, steps)
      type(local_steps_t), intent(inout) :: c
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(in) :: limit              !! [s]
      integer(long), intent(out) :: steps        !! coarse ones
      real(dp) :: work, least
      integer(long) :: k
      integer :: g
      c%largest = 0
      steps = steps_for(time, limit)
      if (m%particles%groups%largest == 0) return
      least = steps*turns(m%particles, 0)
      do g = 1, m%particles%groups%largest
         if (.not. moves_little(m, 2**g*limit)) exit
         k = steps_for(time, 2**g*limit)
         work = k*turns(m%particles, g)
         if (work >= least) cycle
         least = work
         c%largest = g
         steps = k
      end do
   end subroutine choose_coarse_step

   !> How many steps, none longer than `limit`, fill a time.
   pure integer(long) function steps_for(time, limit)
      real(dp), intent(in) :: time, limit        !! [s]
      real(dp), parameter :: rounding = 1.0e-6_dp
      steps_for = max(1_long, ceiling(time/limit - rounding, long))
   end function steps_for

   !> How many turns the blocks have in all in a coarse step of 2**largest finest ones.
   pure real(dp) function turns(p, largest)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: largest
      integer :: b
      turns = 0
      do b = 1, p%n_blocks
         turns = turns + 2.0_dp**(largest - min(largest, p%groups%by_size(p%block_cells(1, b))))
      end do
   end function turns

   !> Whether no particle moves further in the grid than it may in a time.
   pure logical function moves_little(m, time) result(little)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: time               !! [s]
      little = m%particles%total_frame
      if (.not. little) little = maxval(abs(m%particles%velocity))*time <= farthest*smallest_occupied_cell(m%grid, m%particles)
   end function moves_little

   !> Advance by a coarse step, of 2**c%largest steps `dt`; particles may stay behind until `settle`. Fails where a particle leaves the grid or jumps.
   subroutine advance_coarsely(c, m, dt, failure)
      type(local_steps_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      type(sweep_report_t) :: report
      integer :: s, turn, ending
      if (c%largest == 0) then
         call take_step(m, dt, failure)
         return
      end if
      call start_coarse_step(c, m)
      do s = 0, 2**c%largest - 1
         turn = min(trailz(s), c%largest)
         ending = min(trailz(s + 1), c%largest)
         call push_nodes(c, m, dt, s, turn)
         call clear_fired(c, m%fields, turn)
         call kick_cells(c, m, dt, turn)
         call find_velocities(c, m, dt, turn)
         call sum_ways(c, m, turn)
         call end_intervals(c, m, dt, ending, s == 2**c%largest - 1)
      end do
      if (.not. m%particles%total_frame) call look_for_leavers(m%particles, m%fields, report)
      if (report%jumped) call report_jump(m, failure)
      if (.not. failure%failed()) call end_step(m, dt, 2**c%largest, report%left_cell, failure)
   end subroutine advance_coarsely

   !> Map what stays for the whole coarse step, and clear what is summed in it.
   subroutine start_coarse_step(c, m)
      type(local_steps_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      integer :: k
      call settle(m)
      if (.not. m%mapped) call map_to_grid(m)
      call fit_to_sort(c, m)
      if (.not. m%particles%total_frame) call map_matrices(c, m%particles, m%fields)
      call gather(m%grid, m%fields, mass=.true., momentum=.false., force=.false.)
      call find_velocities(c, m, 0.0_dp, c%largest)
      m%fields%velocity(:, :, new) = 0
      m%fields%acceleration = 0
      do k = 1, size(c%runs)
         call scale_forces(c%runs(k), m%fields)
      end do
      if (.not. allocated(c%load)) allocate (c%load(ndim, m%grid%n_points, size(m%loads)))
      do k = 1, size(m%loads)
         c%load(:, :, k) = 0
         call add_load(m%loads(k), 1.0_dp, m%grid, m%particles, c%load(:, :, k))
         call m%grid%dependents%collect(c%dependents, ndim, c%load(:, :, k))
      end do
   end subroutine start_coarse_step

   !> After a sort, or where the length of the coarse step has changed: find runs, rates and room.
   subroutine fit_to_sort(c, m)
      type(local_steps_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      integer :: k
      if (c%sorts == m%particles%sorts .and. ubound(c%nodes_until, 1) == c%largest) return
      c%sorts = m%particles%sorts
      associate (p => m%particles, f => m%fields, all => m%fields%mass_matrix%all)
         call limit_groups(m%grid, p%occupied(:p%n_occupied), c%largest, p%groups)
         call find_runs(p, f, c%runs)
         call order_by_rate(all%nodes(:all%n_points), p%groups%velocity_rate, c%largest, c%points, c%points_until)
         call order_by_rate(all%nodes(:all%n_nodes), p%groups%velocity_rate, c%largest, c%nodes, c%nodes_until)
         call order_by_rate(all%nodes(all%n_nodes + 1:all%n_points), p%groups%velocity_rate, c%largest, c%dependents, &
                            c%dependents_until)
         if (allocated(c%load)) deallocate (c%load)
         if (allocated(c%matrix)) deallocate (c%matrix, c%corner, c%in_row, c%kick, c%way, c%move, c%partial_power)
         associate (n => p%n_blocks)
            allocate (c%matrix(lanes, corners, corners, n), c%partial_power(size(c%nodes)/nodes_per_block + 1))
            allocate (c%kick(ndim, corners, lanes, n), c%way(ndim, corners, lanes, n), c%move(ndim, corners, lanes, n), &
                      source=0.0_dp)
            c%corner = reshape([(k, k=1, corners*lanes*n)], [corners, lanes, n])
            allocate (c%in_row(n), source=.false.)
         end associate
      end associate
      call map_matrices(c, m%particles, m%fields)
   end subroutine fit_to_sort

   !> The mass matrices (6) of the cells that wait.
   subroutine map_matrices(c, p, f)
      type(local_steps_t), intent(inout) :: c
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(in) :: f
      integer :: k, b, l, i, j
      real(dp) :: n(corners)
      do k = 1, size(c%runs)
         if (c%runs(k)%kind /= waiting) cycle
         !$omp parallel do schedule(static) private(l, i, j, n)
         do b = c%runs(k)%blocks(1), c%runs(k)%blocks(2)
            c%matrix(:, :, :, b) = 0
            do l = 1, lanes
               if (p%block_cells(l, b) == 0) cycle
               associate (e => p%block_cells(l, b))
                  do i = p%first_in(e), p%last_in(e), p%stride_in(e)
                     n = shape_functions(inside_cell((p%place_in_grid(i) - f%block_lower(l, :, b))*f%block_inverse_size(l, b)))
                     do j = 1, corners
                        c%matrix(l, :, j, b) = c%matrix(l, :, j, b) + (p%mass(i)*n(j))*n
                     end do
                  end do
               end associate
            end do
         end do
      end do
   end subroutine map_matrices

   !> Give the force of the cells of a run the weight of their interval.
   subroutine scale_forces(run, f)
      type(run_t), intent(in) :: run
      type(nodal_fields_t), intent(inout) :: f
      integer :: b
      if (run%group == 0) return
      do b = run%blocks(1), run%blocks(2)
         f%share(:, :, force_share:force_share + ndim - 1, b) = 2**run%group*f%share(:, :, force_share:force_share + ndim - 1, b)
      end do
   end subroutine scale_forces

   !> Forget the forces that have acted, for an interval as a whole: the finest cells will have new ones.
   subroutine clear_fired(c, f, turn)
      type(local_steps_t), intent(in) :: c
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: turn
      integer :: k
      do k = 1, size(c%runs)
         associate (run => c%runs(k))
            if (run%group == 0 .or. run%group > turn) cycle
            f%share(:, :, force_share:force_share + ndim - 1, run%blocks(1):run%blocks(2)) = 0
         end associate
      end do
   end subroutine clear_fired

   !> Accelerations of the nodes by the forces that act now, times 2**n: what dt has to multiply.
   subroutine push_nodes(c, m, dt, s, turn)
      type(local_steps_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      integer, intent(in) :: s                   !! finest steps since the beginning of the coarse one
      integer, intent(in) :: turn                !! the largest group whose turn it is
      real(dp) :: factor(size(m%loads), 0:turn)  ! by the interval for which the load acts
      integer :: block, first, k, n_force
      associate (f => m%fields, rates => m%particles%groups, n => c%nodes_until(turn), &
                 dependents => c%dependents(:c%dependents_until(turn)))
         call gather_at(c%points_until(turn), c%points, f%slot, f%share(1, 1, force_share, 0), f%force)
         call m%grid%dependents%collect(dependents, ndim, f%force)
         do n_force = 0, turn
            factor(:, n_force) = [(mean_around(m%loads(k)%history, m%time + s*dt, 2**n_force*dt), k=1, size(m%loads))]
         end do
         !$omp parallel do schedule(static) private(first)
         do block = 1, (n - 1)/nodes_per_block + 1
            first = (block - 1)*nodes_per_block + 1
            call push_some(min(nodes_per_block, n - first + 1), c%nodes(first), turn, dt, m%damping_rate, m%constraints%free, &
                           f%mass_matrix%inverse_lumped, rates%force_rate, rates%velocity_rate, size(m%loads), factor, c%load, &
                           m%grid%n_points, f%force, f%velocity(1, 1, mapped), f%acceleration, f%velocity(1, 1, new))
         end do
         call m%grid%dependents%expand(dependents, ndim, f%acceleration)
      end associate
   end subroutine push_nodes

   !> The mean factor of a load in the interval around a time, by the rule of trapezoids. An impulse for an interval T acts in its
   !> middle: one at t stands for the forces from t - T/2 to t + T/2, before and after which the velocities hold. A load that sets in
   !> at t has half of it; with all of it the motion would be early by T/2.
   pure real(dp) function mean_around(history, time, interval)
      type(load_history_t), intent(in) :: history
      real(dp), intent(in) :: time, interval     !! [s]
      mean_around = 0.5_dp*(history%factor(time - 0.5_dp*interval) + history%factor(time + 0.5_dp*interval))
   end function mean_around

   !> Kick the particles of the cells whose turn it is and map them anew, and sum up what those that wait would have got.
   subroutine kick_cells(c, m, dt, turn)
      type(local_steps_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                        !! [s]
      integer, intent(in) :: turn
      integer :: k, b
      do k = 1, size(c%runs)
         associate (run => c%runs(k), f => m%fields)
            if (run%kick_rate > turn) cycle
            if (run%kind == waiting) then
               do b = run%blocks(1), run%blocks(2)
                  call sum_kick(dt, f%acceleration, f%block_nodes(1, 1, b), c%matrix(1, 1, 1, b), c%kick(1, 1, 1, b), &
                                f%share(1, 1, momentum_share, b))
               end do
            else
               call sweep_run(c, m, run, sweep_t(kick=.true., map_momentum=.true.), dt, by_corners=.false.)
            end if
         end associate
      end do
   end subroutine kick_cells

   !> Sweep over a run, by nodal fields or by what has been summed at the corners.
   subroutine sweep_run(c, m, run, sweep, dt, by_corners)
      type(local_steps_t), intent(in) :: c
      type(motion_t), intent(inout) :: m
      type(run_t), intent(in) :: run
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt                        !! [s]
      logical, intent(in) :: by_corners
      integer :: first, b
      !$omp parallel do schedule(static)
      do first = run%blocks(1), run%blocks(2), blocks_per_task
         associate (blocks => [(b, b=first, min(first + blocks_per_task - 1, run%blocks(2)))])
            if (by_corners) then
               call sweep_between(sweep, dt, m%materials, m%particles, m%fields, .false., blocks, c%corner, c%in_row, &
                                  c%kick, c%move, c%way)
            else
               call sweep_list(sweep, dt, m%materials, m%particles, m%fields, .false., blocks)
            end if
         end associate
      end do
   end subroutine sweep_run

   !> Find the velocities of the nodes whose turn it is from the momenta of the cells; the accelerations have then acted. Book what
   !> the damping has taken by them.
   subroutine find_velocities(c, m, dt, turn)
      type(local_steps_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                        !! for which it has acted [s]
      integer, intent(in) :: turn
      integer :: block, first
      associate (f => m%fields, n => c%nodes_until(turn), dependents => c%dependents(:c%dependents_until(turn)))
         call gather_at(c%points_until(turn), c%points, f%slot, f%share(1, 1, momentum_share, 0), f%momentum)
         call m%grid%dependents%collect(dependents, ndim, f%momentum)
         !$omp parallel do schedule(static) private(first)
         do block = 1, (n - 1)/nodes_per_block + 1
            first = (block - 1)*nodes_per_block + 1
            call divide_some(min(nodes_per_block, n - first + 1), c%nodes(first), turn, m%constraints%free, &
                             f%mass_matrix%inverse_lumped, f%mass_matrix%lumped, m%particles%groups%force_rate, f%momentum, &
                             f%velocity(1, 1, mapped), f%acceleration, c%partial_power(block))
         end do
         m%damping_loss = m%damping_loss + dt*m%damping_rate*sum(c%partial_power(:(n - 1)/nodes_per_block + 1))
         call m%grid%dependents%expand(dependents, ndim, f%velocity(:, :, mapped))
         call clear(size(dependents), dependents, f%acceleration)
      end associate
   end subroutine find_velocities

   !> Sum the velocities of their corners up in the cells in which these change between their turns.
   subroutine sum_ways(c, m, turn)
      type(local_steps_t), intent(inout) :: c
      type(motion_t), intent(in) :: m
      integer, intent(in) :: turn
      integer :: k, b
      do k = 1, size(c%runs)
         if (c%runs(k)%kind == plain .or. c%runs(k)%velocity_rate > turn) cycle
         do b = c%runs(k)%blocks(1), c%runs(k)%blocks(2)
            call sum_way(turn, m%particles%groups%velocity_rate, m%fields%velocity(1, 1, mapped), m%fields%block_nodes(1, 1, b), &
                         c%way(1, 1, 1, b))
         end do
      end do
   end subroutine sum_ways

   !> In cells whose interval ends: kick by what was summed, strain and map the force. With the coarse step all intervals end, and
   !> the particles move.
   subroutine end_intervals(c, m, dt, ending, is_last)
      type(local_steps_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                        !! [s]
      integer, intent(in) :: ending                     !! the largest group whose intervals end
      logical, intent(in) :: is_last                    !! whether the coarse step does
      integer :: k
      if (is_last) call find_moves(c, m)
      do k = 1, size(c%runs)
         associate (run => c%runs(k))
            if (run%group > ending) cycle
            call sweep_run(c, m, run, last_sweep(run, is_last, m%particles%total_frame), dt, by_corners=run%kind >= summing)
            if (run%kind == waiting) c%kick(:, :, :, run%blocks(1):run%blocks(2)) = 0
            if (run%kind >= summing) c%way(:, :, :, run%blocks(1):run%blocks(2)) = 0
            if (.not. is_last) call scale_forces(run, m%fields)
         end associate
      end do
   end subroutine end_intervals

   !> Find what moves the particles: at dependent points, and at the corners of the cells that have fields there.
   subroutine find_moves(c, m)
      type(local_steps_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      integer :: k, b, l
      call m%grid%dependents%expand(c%dependents, ndim, m%fields%velocity(:, :, new))
      do k = 1, size(c%runs)
         if (c%runs(k)%kind == plain) cycle
         do b = c%runs(k)%blocks(1), c%runs(k)%blocks(2)
            do l = 1, lanes
               c%move(:, :, l, b) = m%fields%velocity(:, m%fields%block_nodes(:, l, b), new)
            end do
         end do
      end do
   end subroutine find_moves

   !> The sweep over the cells of a run whose interval ends, and with it the coarse step or not.
   pure function last_sweep(run, is_last, total_frame) result(sweep)
      type(run_t), intent(in) :: run
      logical, intent(in) :: is_last, total_frame
      type(sweep_t) :: sweep
      sweep%strain_fraction = 1
      if (run%kind == plain) sweep%strain_fraction = 2**run%group
      sweep%strain_by = mapped
      sweep%kick = run%kind == waiting
      sweep%move = is_last
      sweep%map_mass = is_last .and. .not. total_frame
      sweep%map_momentum = sweep%kick .or. sweep%map_mass
      sweep%map_force = .true.
   end function last_sweep
end module hampm_local_steps
