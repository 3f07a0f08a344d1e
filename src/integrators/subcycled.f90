!> Subcycling, time steps that fit the size of the cells: cells of group g (`hampm_step_groups`) take steps 2**g times as long as
!> the finest.
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
module hampm_subcycled
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: cell_blocks_t, lanes, of_momentum, of_force
   use hampm_failure, only: failure_t
   use hampm_local_steps, only: local_steps_t
   use hampm_time_history, only: time_history_t
   use hampm_loads, only: place_loads, add_load, book_work
   use hampm_mass_matrix, only: nodes_per_chunk
   use hampm_motion, only: motion_t, update_particles, map_to_grid
   use hampm_nodal_fields, only: nodal_fields_t, v_next, v_mapped, assemble, assemble_at
   use hampm_node_list, only: node_list_t, lists_by_interval, clear_hanging
   use hampm_particle_pass, only: pass_report_t, pass_over, pass_between, cell_matrices, look_for_leavers, blocks_per_task
   use hampm_particles, only: particles_t
   use hampm_pass, only: pass_t
   use hampm_step, only: take_step, report_jump, end_step
   use hampm_step_groups, only: limit_groups, plain, summing, waiting
   use hampm_subcycled_batches, only: batch_t, find_batches
   use hampm_subcycling_kernels, only: add_impulses, push_some, divide_some, sum_kick, sum_way
   implicit none
   private
   public :: subcycled_t

   !> Which cells take which steps, with the workspace of a coarse step.
   type, extends(local_steps_t) :: subcycled_t
      integer, private :: sorts = -1             !! which sort of the particles the following belongs to
      type(batch_t), allocatable, private :: batches(:)
      type(node_list_t), allocatable, private :: due(:)       !! the nodes whose velocities change at each turn, (0:largest)
      ! Of cells that sum and wait, beside the nodes: fields of the corners of the blocks, (ndim, corners, lanes, n_blocks)
      integer, allocatable, private :: corner(:, :, :)        !! numbers of the corners, (corners, lanes, n_blocks)
      logical, allocatable, private :: in_row(:)              !! whether these are two rows: no; (n_blocks)
      real(dp), allocatable, private :: kick(:, :, :, :)      !! sum of the accelerations [m/s2] and
      real(dp), allocatable, private :: way(:, :, :, :)       !! sum of the velocities [m/s] since the last turn, each as many times
                                                              !! as it has acted for dt
      real(dp), allocatable, private :: move(:, :, :, :)      !! the same of what moves particles, since the coarse step began [m/s]
      real(dp), allocatable, private :: matrix(:, :, :, :)    !! M of the cells that wait [kg], (lanes, corners, corners, n_blocks)
      real(dp), allocatable, private :: load(:, :, :)         !! of each load with a factor of 1 [N], (ndim, n_points, loads)
      real(dp), allocatable, private :: partial_power(:)      !! workspace, by chunks of nodes
   contains
      procedure :: advance
   end type subcycled_t

contains

   !> Advance by a coarse step, of 2**largest steps `dt`.
   subroutine advance(self, m, dt, failure)
      class(subcycled_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      type(pass_report_t) :: report
      real(dp) :: work
      integer :: s, turn, ending
      if (self%largest == 0) then
         call take_step(m, dt, failure)
         return
      end if
      call start_coarse_step(self, m, failure)
      do s = 0, 2**self%largest - 1
         turn = min(trailz(s), self%largest)
         ending = min(trailz(s + 1), self%largest)
         call push_nodes(self, m, dt, s, turn)
         call clear_fired(self, m%fields, turn)
         call kick_cells(self, m, dt, turn)
         call find_velocities(self, m, dt, turn)
         call book_work(m%loads, m%time + s*dt, dt, m%fields%velocity(:, :, v_mapped), work)
         m%external_work = m%external_work + work
         call sum_ways(self, m, turn)
         call end_intervals(self, m, dt, ending, s == 2**self%largest - 1)
      end do
      if (.not. m%particles%total_frame) call look_for_leavers(m%particles, m%blocks, m%fields, report)
      if (report%jumped) call report_jump(m, failure)
      if (.not. failure%failed()) call end_step(m, dt, 2**self%largest, report%left_cell, failure)
   end subroutine advance

   !> Map what stays for the whole coarse step, and clear what is summed in it.
   subroutine start_coarse_step(c, m, failure)
      type(subcycled_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      integer :: k
      call update_particles(m)
      if (.not. m%mapped) call map_to_grid(m)
      call rebuild_batches(c, m)
      if (.not. m%particles%total_frame) call map_matrices(c, m%particles, m%blocks)
      call assemble(m%grid, m%blocks, m%fields, mass=.true., momentum=.false., force=.false.)
      call find_velocities(c, m, 0.0_dp, c%largest)
      m%fields%velocity(:, :, v_next) = 0
      m%fields%acceleration = 0
      do k = 1, size(c%batches)
         call scale_forces(c%batches(k), m%fields)
      end do
      call place_loads(m%loads, m%grid, m%particles)
      if (.not. allocated(c%load)) allocate (c%load(ndim, m%grid%n_points, size(m%loads)))
      do k = 1, size(m%loads)
         c%load(:, :, k) = 0
         call add_load(m%loads(k), 1.0_dp, c%load(:, :, k))
         call m%grid%dofs%condense(c%due(c%largest), ndim, c%load(:, :, k))
      end do
   end subroutine start_coarse_step

   !> After a sort, or where the length of the coarse step has changed: find batches, intervals and room.
   subroutine rebuild_batches(c, m)
      type(subcycled_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      integer :: k
      if (c%sorts == m%blocks%sorts .and. ubound(c%due, 1) == c%largest) return
      c%sorts = m%blocks%sorts
      associate (blocks => m%blocks, all => m%fields%mass_matrix%all)
         call limit_groups(m%grid, blocks%occupied(:blocks%n_occupied), c%largest, blocks%groups)
         call find_batches(blocks, c%batches)
         call lists_by_interval(all, blocks%groups%velocity_interval, c%largest, c%due)
         if (allocated(c%load)) deallocate (c%load)
         if (allocated(c%matrix)) deallocate (c%matrix, c%corner, c%in_row, c%kick, c%way, c%move, c%partial_power)
         associate (n => blocks%n)
            allocate (c%matrix(lanes, corners, corners, n), c%partial_power(all%n_nodes/nodes_per_chunk + 1))
            allocate (c%kick(ndim, corners, lanes, n), c%way(ndim, corners, lanes, n), c%move(ndim, corners, lanes, n), &
                      source=0.0_dp)
            c%corner = reshape([(k, k=1, corners*lanes*n)], [corners, lanes, n])
            allocate (c%in_row(n), source=.false.)
         end associate
      end associate
      call map_matrices(c, m%particles, m%blocks)
   end subroutine rebuild_batches

   !> The mass matrices (6) of the cells that wait.
   subroutine map_matrices(c, p, blocks)
      type(subcycled_t), intent(inout) :: c
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer :: k, b
      do k = 1, size(c%batches)
         if (c%batches(k)%role /= waiting) cycle
         !$omp parallel do schedule(static)
         do b = c%batches(k)%blocks(1), c%batches(k)%blocks(2)
            call cell_matrices(p, blocks, b, c%matrix(:, :, :, b))
         end do
      end do
   end subroutine map_matrices

   !> Give the force of the cells of a batch the weight of their interval.
   subroutine scale_forces(batch, f)
      type(batch_t), intent(in) :: batch
      type(nodal_fields_t), intent(inout) :: f
      integer :: b
      if (batch%group == 0) return
      do b = batch%blocks(1), batch%blocks(2)
         associate (forces => f%contribution(:, :, of_force:of_force + ndim - 1, b))
            forces = 2**batch%group*forces
         end associate
      end do
   end subroutine scale_forces

   !> Forget the forces that have acted, for an interval as a whole: the finest cells will have new ones.
   subroutine clear_fired(c, f, turn)
      type(subcycled_t), intent(in) :: c
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: turn
      integer :: k
      do k = 1, size(c%batches)
         associate (batch => c%batches(k))
            if (batch%group == 0 .or. batch%group > turn) cycle
            f%contribution(:, :, of_force:of_force + ndim - 1, batch%blocks(1):batch%blocks(2)) = 0
         end associate
      end do
   end subroutine clear_fired

   !> Accelerations of the nodes by the forces that act now, times 2**n: what dt has to multiply.
   subroutine push_nodes(c, m, dt, s, turn)
      type(subcycled_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      integer, intent(in) :: s                   !! finest steps since the beginning of the coarse one
      integer, intent(in) :: turn                !! the largest group whose turn it is
      real(dp) :: factor(0:turn)                 ! of a load, by the interval for which it acts
      integer :: chunk, first, k, r
      associate (f => m%fields, groups => m%blocks%groups, due => c%due(turn), n => c%due(turn)%n_nodes)
         call assemble_at(due%nodes(:due%n_points), m%blocks, m%fields, mass=.false., momentum=.false., force=.true.)
         call m%grid%dofs%condense(due, ndim, f%force)
         do k = 1, size(m%loads)
            factor = [(mean_around(m%loads(k)%history, m%time + s*dt, 2**r*dt), r=0, turn)]
            call add_impulses(n, due%nodes, turn, groups%force_interval, factor, c%load(:, :, k), f%force)
         end do
         !$omp parallel do schedule(static) private(first)
         do chunk = 1, (n - 1)/nodes_per_chunk + 1
            first = (chunk - 1)*nodes_per_chunk + 1
            call push_some(min(nodes_per_chunk, n - first + 1), due%nodes(first), turn, dt, m%damping_rate, m%constraints%free, &
                           f%mass_matrix%inverse_lumped, groups%force_interval, groups%velocity_interval, f%force, &
                           f%velocity(1, 1, v_mapped), f%acceleration, f%velocity(1, 1, v_next))
         end do
         call m%grid%dofs%distribute(due, ndim, f%acceleration)
      end associate
   end subroutine push_nodes

   !> The mean factor of a load in the interval around a time, by the rule of trapezoids. An impulse for an interval T acts in its
   !> middle: one at t stands for the forces from t - T/2 to t + T/2, before and after which the velocities hold. A load that sets
   !> in at t has half of it; with all of it the motion would be early by T/2.
   pure real(dp) function mean_around(history, time, interval)
      type(time_history_t), intent(in) :: history
      real(dp), intent(in) :: time, interval     !! [s]
      mean_around = 0.5_dp*(history%factor(time - 0.5_dp*interval) + history%factor(time + 0.5_dp*interval))
   end function mean_around

   !> Kick the particles of the cells whose turn it is and map them anew, and sum up what those that wait would have got.
   subroutine kick_cells(c, m, dt, turn)
      type(subcycled_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                        !! [s]
      integer, intent(in) :: turn
      integer :: k, b
      do k = 1, size(c%batches)
         associate (batch => c%batches(k), f => m%fields)
            if (batch%kick_interval > turn) cycle
            if (batch%role == waiting) then
               do b = batch%blocks(1), batch%blocks(2)
                  call sum_kick(dt, f%acceleration, m%blocks%nodes(1, 1, b), c%matrix(1, 1, 1, b), c%kick(1, 1, 1, b), &
                                f%contribution(1, 1, of_momentum, b))
               end do
            else
               call pass_batch(c, m, batch, pass_t(kick=.true., map_momentum=.true.), dt, by_corners=.false.)
            end if
         end associate
      end do
   end subroutine kick_cells

   !> Pass over a batch, by nodal fields or by what has been summed at the corners.
   subroutine pass_batch(c, m, batch, pass, dt, by_corners)
      type(subcycled_t), intent(in) :: c
      type(motion_t), intent(inout) :: m
      type(batch_t), intent(in) :: batch
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                        !! [s]
      logical, intent(in) :: by_corners
      integer :: first, b
      !$omp parallel do schedule(static)
      do first = batch%blocks(1), batch%blocks(2), blocks_per_task
         associate (listed => [(b, b=first, min(first + blocks_per_task - 1, batch%blocks(2)))])
            if (by_corners) then
               call pass_between(pass, dt, m%materials, m%particles, m%blocks, m%fields, listed, c%corner, c%in_row, c%kick, &
                                 c%move, c%way)
            else
               call pass_over(pass, dt, m%materials, m%particles, m%blocks, m%fields, listed)
            end if
         end associate
      end do
   end subroutine pass_batch

   !> Find the velocities of the nodes whose turn it is from the momenta of the cells; the accelerations have then acted. Book what
   !> the damping has taken by them.
   subroutine find_velocities(c, m, dt, turn)
      type(subcycled_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                        !! for which it has acted [s]
      integer, intent(in) :: turn
      integer :: chunk, first
      associate (f => m%fields, due => c%due(turn), n => c%due(turn)%n_nodes)
         call assemble_at(due%nodes(:due%n_points), m%blocks, m%fields, mass=.false., momentum=.true., force=.false.)
         call m%grid%dofs%condense(due, ndim, f%momentum)
         !$omp parallel do schedule(static) private(first)
         do chunk = 1, (n - 1)/nodes_per_chunk + 1
            first = (chunk - 1)*nodes_per_chunk + 1
            call divide_some(min(nodes_per_chunk, n - first + 1), due%nodes(first), turn, m%constraints%free, &
                             f%mass_matrix%inverse_lumped, f%mass_matrix%lumped, m%blocks%groups%force_interval, f%momentum, &
                             f%velocity(1, 1, v_mapped), f%acceleration, c%partial_power(chunk))
         end do
         m%damping_loss = m%damping_loss + dt*m%damping_rate*sum(c%partial_power(:(n - 1)/nodes_per_chunk + 1))
         call m%grid%dofs%distribute(due, ndim, f%velocity(:, :, v_mapped))
         call clear_hanging(due, ndim, f%acceleration)
      end associate
   end subroutine find_velocities

   !> Sum the velocities of their corners up in the cells in which these change between their turns.
   subroutine sum_ways(c, m, turn)
      type(subcycled_t), intent(inout) :: c
      type(motion_t), intent(in) :: m
      integer, intent(in) :: turn
      integer :: k, b
      do k = 1, size(c%batches)
         if (c%batches(k)%role == plain .or. c%batches(k)%velocity_interval > turn) cycle
         do b = c%batches(k)%blocks(1), c%batches(k)%blocks(2)
            call sum_way(turn, m%blocks%groups%velocity_interval, m%fields%velocity(1, 1, v_mapped), m%blocks%nodes(1, 1, b), &
                         c%way(1, 1, 1, b))
         end do
      end do
   end subroutine sum_ways

   !> In cells whose interval ends: kick by what was summed, strain and map the force. With the coarse step all intervals end, and
   !> the particles move.
   subroutine end_intervals(c, m, dt, ending, is_last)
      type(subcycled_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                        !! [s]
      integer, intent(in) :: ending                     !! the largest group whose intervals end
      logical, intent(in) :: is_last                    !! whether the coarse step does
      integer :: k
      if (is_last) call find_moves(c, m)
      do k = 1, size(c%batches)
         associate (batch => c%batches(k))
            if (batch%group > ending) cycle
            call pass_batch(c, m, batch, last_pass(batch, is_last, m%particles%total_frame), dt, by_corners=batch%role >= summing)
            if (batch%role == waiting) c%kick(:, :, :, batch%blocks(1):batch%blocks(2)) = 0
            if (batch%role >= summing) c%way(:, :, :, batch%blocks(1):batch%blocks(2)) = 0
            if (.not. is_last) call scale_forces(batch, m%fields)
         end associate
      end do
   end subroutine end_intervals

   !> Find what moves the particles: at hanging nodes, and at the corners of the cells that have fields there.
   subroutine find_moves(c, m)
      type(subcycled_t), intent(inout) :: c
      type(motion_t), intent(inout) :: m
      integer :: k, b, l
      call m%grid%dofs%distribute(c%due(c%largest), ndim, m%fields%velocity(:, :, v_next))
      do k = 1, size(c%batches)
         if (c%batches(k)%role == plain) cycle
         do b = c%batches(k)%blocks(1), c%batches(k)%blocks(2)
            do l = 1, lanes
               c%move(:, :, l, b) = m%fields%velocity(:, m%blocks%nodes(:, l, b), v_next)
            end do
         end do
      end do
   end subroutine find_moves

   !> The pass over the cells of a batch whose interval ends, and with it the coarse step or not.
   pure function last_pass(batch, is_last, total_frame) result(pass)
      type(batch_t), intent(in) :: batch
      logical, intent(in) :: is_last, total_frame
      type(pass_t) :: pass
      pass%strain_fraction = 1
      if (batch%role == plain) pass%strain_fraction = 2**batch%group
      pass%strain_by = v_mapped
      pass%kick = batch%role == waiting
      pass%move = is_last
      pass%map_mass = is_last .and. .not. total_frame
      pass%map_momentum = pass%kick .or. pass%map_mass
      pass%map_force = .true.
   end function last_pass
end module hampm_subcycled
