!> Local time stepping by leapfrog steps (Diaz & Grote 2009), in the total frame with laws that are linear: time steps that fit the
!> size of the cells, without a particle. Cells of group g (`hampm_step_groups`) take 2**g of the finest steps at once.
!>
!> There the material point method is a finite element method with the particles as quadrature points (`hampm_element_operators`): a
!> step of `musl` kicks the particles by q = D**-1 f, maps them (the nodes gain B f with B = D**-1 M D**-1), and moves and strains
!> them by the new nodal values. A coarse step here is such a step, of the length of the largest cells, in which f is the mean force
!> of a motion within it with short steps in small cells (`hampm_mean_force`). All else is as in ordinary steps: particles are
!> updated at output times only, and an equilibrium of these is one of common steps.
module hampm_local_leapfrog
   use hampm_kinds, only: dp, ndim, long
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_element_operators, only: pass_by_all_operators
   use hampm_failure, only: failure_t
   use hampm_fine_region, only: fine_region_t, find_region
   use hampm_integrator, only: steps_for
   use hampm_loads, only: place_loads, add_load, book_work
   use hampm_mean_force, only: mean_force_t, make_room, add_mean_change
   use hampm_problem, only: problem_t, map_to_grid, assemble_sums, pass_on
   use hampm_nodal_fields, only: v_n, v_next, v_mapped
   use hampm_nodal_kernels, only: divide_by_mass
   use hampm_nodal_motion, only: find_velocity, accelerate
   use hampm_step, only: explicit_t, end_step
   use hampm_step_groups, only: limit_groups
   use hampm_time_history, only: time_history_t
   implicit none
   private
   public :: local_leapfrog_t

   !> State within a coarse step, with its workspace.
   type, extends(explicit_t) :: local_leapfrog_t
      integer, private :: sorts = -1             !! which sort of the particles the following belongs to
      type(mean_force_t), private :: mean
   contains
      procedure :: choose_steps
      procedure :: advance
      procedure :: finish
   end type local_leapfrog_t

contains

   !> Choose how many finest steps a coarse one takes, and how many coarse ones fill a time: those that do the least work.
   subroutine choose_steps(self, m, time, limit, steps, dt)
      class(local_leapfrog_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(in) :: limit              !! longest that a finest step may be [s]
      integer(long), intent(out) :: steps        !! coarse ones
      real(dp), intent(out) :: dt                !! finest step [s]
      real(dp) :: work, least
      integer(long) :: k
      integer :: g
      self%largest = 0
      steps = steps_for(time, limit)
      least = steps*turns(m%blocks, 0)
      do g = 1, m%blocks%groups%largest
         k = steps_for(time, 2**g*limit)
         work = k*turns(m%blocks, g)
         if (work >= least) cycle
         least = work
         self%largest = g
         steps = k
      end do
      dt = time/(steps*2**self%largest)
   end subroutine choose_steps

   !> How many turns the blocks have in all in a coarse step of 2**largest finest ones.
   pure real(dp) function turns(blocks, largest)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: largest
      integer :: b
      turns = 0
      do b = 1, blocks%n
         turns = turns + 2.0_dp**(largest - min(largest, blocks%groups%by_size(blocks%cells(1, b))))
      end do
   end function turns

   !> Advance by a coarse step, of 2**largest steps `dt`. Velocities are at mid-step; at the start of a run, where they are given,
   !> they are kicked for half a step.
   subroutine advance(self, m, dt, failure)
      class(local_leapfrog_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      real(dp) :: step, kick, work
      step = 2**self%largest*dt
      if (self%largest == 0) then
         call self%explicit_t%advance(m, dt, failure)
         return
      end if
      if (.not. m%cache%mapped) call map_to_grid(m)
      kick = step
      if (m%state%steps == 0) kick = 0.5_dp*step
      call assemble_sums(m, mass=.not. m%cache%weighed, momentum=.true., force=.true.)
      m%cache%weighed = .true.
      call find_mean_force(self, m, dt, step, kick)
      call kick_nodes(m, kick, failure)
      associate (kick_and_map => m%scheme%passes(1), strain_and_move => m%scheme%passes(2))
         call pass_by_all_operators(m%cache%operators, kick_and_map, kick, m%matter_t, m%fields)
         call assemble_sums(m, mass=.false., momentum=.true., force=.false.)
         call solve_velocity(m, v_mapped, failure)
         m%fields%velocity(:, :, v_next) = m%fields%velocity(:, :, v_mapped)
         call pass_by_all_operators(m%cache%operators, strain_and_move, step, m%matter_t, m%fields)
      end associate
      m%cache%operators%is_behind = m%cache%operators%is_active
      call book_work(m%loads, m%particles, m%state%time, step, m%fields%velocity(:, :, v_mapped), work)
      m%energies%external_work = m%energies%external_work + work
      if (.not. failure%failed()) call end_step(m, dt, 2**self%largest, .false., failure)
   end subroutine advance

   !> Find the mean nodal forces over a coarse step, with the loads.
   subroutine find_mean_force(c, m, dt, step, kick)
      type(local_leapfrog_t), intent(inout) :: c
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: step               !! coarse one [s]
      real(dp), intent(in) :: kick               !! for how long they act, until the middle of the step [s]
      integer :: k
      if (c%sorts /= m%blocks%sorts .or. c%mean%region%largest /= c%largest) call rebuild(c, m)
      associate (f => m%fields, all => m%fields%mass_matrix%all)
         call place_loads(m%loads, m%grid, m%particles)
         do k = 1, size(m%loads)
            call add_load(m%loads(k), mean_factor(m%loads(k)%history, m%state%time + 0.5_dp*step - kick, kick), f%force)
         end do
         call m%grid%dofs%condense(all, ndim, f%force)
         call divide_by_mass(all%n_nodes, all%nodes, m%constraints%free, f%mass_matrix%inverse_lumped, f%force, f%acceleration)
         call m%grid%dofs%distribute(all, ndim, f%acceleration)
         call add_mean_change(c%mean, m%materials, m%blocks, dt, f%acceleration, f%force)
      end associate
   end subroutine find_mean_force

   !> The mean factor of a load while it acts. The forces at a time stand for those in half a step before and half a step after it.
   pure real(dp) function mean_factor(history, start, duration)
      type(time_history_t), intent(in) :: history
      real(dp), intent(in) :: start, duration    !! [s]
      mean_factor = (history%integral(start + duration) - history%integral(start))/duration
   end function mean_factor

   !> Release the memory of the region: gfortran leaves some of it when the integrator is deallocated.
   subroutine finish(self)
      class(local_leapfrog_t), intent(inout) :: self
      call forget(self%mean)
   end subroutine finish

   !> Forget the region.
   subroutine forget(mean)
      type(mean_force_t), intent(out) :: mean
   end subroutine forget

   !> After a sort, or a change of the length of the coarse step: find the region that changes in it.
   subroutine rebuild(c, m)
      type(local_leapfrog_t), intent(inout) :: c
      type(problem_t), intent(inout) :: m
      type(fine_region_t) :: region
      c%sorts = m%blocks%sorts
      associate (blocks => m%blocks, matrix => m%fields%mass_matrix)
         call limit_groups(m%grid, blocks%occupied(:blocks%n_occupied), c%largest, blocks%groups)
         call find_region(c%largest, blocks, m%grid%dofs, matrix%all, m%constraints%free, matrix%inverse_lumped, m%particles, &
                          region)
      end associate
      call make_room(region, c%mean)
   end subroutine rebuild

   !> Velocities of the nodes and, by the mean forces, their accelerations. Damping acts on the mean of the velocities before and
   !> after, (v' - v)/T = f/D - alpha (v + v')/2: the limit of the step is the same as without it. Book its dissipation.
   subroutine kick_nodes(m, kick, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: kick               !! for how long forces act [s]
      type(failure_t), intent(inout) :: failure
      real(dp) :: damping_power, mapping_power, share
      type(failure_t) :: unsolved
      call solve_velocity(m, v_n, failure)
      share = 1/(1 + 0.5_dp*m%damping_rate*kick)
      if (m%damping_rate > 0) m%fields%force = share*m%fields%force
      call accelerate(m%grid, m%solver, m%constraints%free, share*m%damping_rate, kick, .false., .false., m%fields, damping_power, &
                      mapping_power, unsolved)
      call pass_on(m, m%state%steps + 1, unsolved, failure)
      m%energies%damping_loss = m%energies%damping_loss + kick*damping_power/share
   end subroutine kick_nodes

   !> Velocities of the nodes from their momentum.
   subroutine solve_velocity(m, which, failure)
      type(problem_t), intent(inout) :: m
      integer, intent(in) :: which               !! `v_n` or `v_mapped`
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      call find_velocity(m%grid, m%solver, m%constraints%free, m%fields, which, v_mapped, unsolved)
      call pass_on(m, m%state%steps + 1, unsolved, failure)
   end subroutine solve_velocity
end module hampm_local_leapfrog
