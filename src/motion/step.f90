!> One time step of the material point method.
module hampm_step
   use hampm_kinds, only: dp, ndim, long
   use hampm_cell_response, only: cell_response_t, fit_response, respond_everywhere, settle_particles
   use hampm_constraints, only: constraints_t, fit_constraints
   use hampm_contact, only: contact_t, fit_contact, lump_at_pairs, share_velocity, keep_apart
   use hampm_cuts, only: crosses
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_loads, only: load_t, add_loads, book_work, follow_sort
   use hampm_mass_choice, only: mass_choice_t, choose_cells
   use hampm_mass_solver, only: mass_solver_t, new_mass_solver, by_lumped
   use hampm_material, only: material_t
   use hampm_nodal_fields, only: at_start, new, mapped, nodal_fields_t, new_nodal_fields, find_active_nodes, gather
   use hampm_nodal_motion, only: find_velocity, accelerate
   use hampm_particles, only: particles_t, sort_into_cells
   use hampm_schemes, only: scheme_t, new_scheme
   use hampm_pipeline, only: pipeline_t, plan_pipeline
   use hampm_sweep, only: sweep_t, sweep_report_t, sweep_particles, sweep_list, look_for_leavers
   use hampm_tiled_step, only: step_in_tiles
   use hampm_whereabouts, only: when, origin
   implicit none
   private
   public :: motion_t, start_motion, fit_to_grid, sort_particles, sort_anew, advance, take_step, settle, map_to_grid, &
             fit_to_cells, report_jump, end_step, refresh_grid, stable_time_step

   !> Everything that moves, and what moves it.
   type :: motion_t
      type(grid_t) :: grid
      type(particles_t) :: particles
      type(material_t), allocatable :: materials(:)
      type(constraints_t) :: constraints
      type(load_t), allocatable :: loads(:)
      real(dp) :: damping_rate = 0               !! alpha of the force -alpha m v [1/s]
      logical :: audit = .false.                 !! whether to book the numerical loss
      type(scheme_t) :: scheme
      type(mass_choice_t) :: mass                !! which mass matrix
      type(mass_solver_t) :: solver
      type(nodal_fields_t) :: fields
      type(contact_t) :: contact                 !! of the faces of cuts
      type(pipeline_t) :: plan                   !! of steps in tiles
      type(cell_response_t) :: response          !! of cells that are swept without their particles
      logical :: mapped = .false.                !! whether the cells hold the sums for the next step
      logical :: weighed = .false.               !! whether the nodes have the masses that these give
      logical :: sorted = .false.                !! whether particles moved to other cells in the last step
      real(dp) :: time = 0                       !! [s]
      integer(long) :: steps = 0                 !! steps done
      real(dp) :: external_work = 0              !! work of the loads so far [J]
      real(dp) :: damping_loss = 0               !! energy taken by the damping so far [J]
      real(dp) :: numerical_loss = 0             !! energy lost by the method so far, booked with `audit` [J]
   end type motion_t

contains

   !> Prepare for the first step with a scheme ('usf', 'usl', 'usavg' or 'musl') and, where it is not to be lumped, a mass
   !> matrix.
   subroutine start_motion(m, scheme, failure, mass)
      type(motion_t), intent(inout) :: m
      character(*), intent(in) :: scheme
      type(failure_t), intent(inout) :: failure
      type(mass_choice_t), intent(in), optional :: mass
      if (present(mass)) m%mass = mass
      m%scheme = new_scheme(scheme, m%mass%by /= by_lumped, m%particles%total_frame)
      if (.not. allocated(m%loads)) allocate (m%loads(0))
      call fit_to_grid(m, failure)
   end subroutine start_motion

   !> Make constraints, contact, nodal fields and solver fit a new grid, into which the particles are sorted. Fails where the
   !> memory does not suffice.
   subroutine fit_to_grid(m, failure)
      type(motion_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      m%mapped = .false.
      m%plan = pipeline_t()
      m%response = cell_response_t()
      call fit_constraints(m%constraints, m%grid)
      call fit_contact(m%contact, m%grid)
      call new_nodal_fields(m%grid, m%fields, failure)
      if (failure%failed()) return
      call choose_cells(m%mass, m%grid, m%fields%mass_matrix, failure)
      call lump_at_pairs(m%contact, m%grid, m%fields%mass_matrix)
      call new_mass_solver(m%mass%by, m%mass%order, m%grid, m%constraints, m%solver, failure)
      if (failure%failed()) return
      call find_active_nodes(m%grid, m%particles, m%fields, failure)
   end subroutine fit_to_grid

   !> Advance by one step `dt`, with all particles. Fails where a particle leaves the grid or jumps.
   subroutine advance(m, dt, failure)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      call take_step(m, dt, failure)
      call settle(m)
   end subroutine advance

   !> Bring the particles up to date, before they are looked at.
   subroutine settle(m)
      type(motion_t), intent(inout) :: m
      call settle_particles(m%response, m%materials, m%particles, m%fields)
   end subroutine settle

   !> As `advance`, but particles may stay behind until `settle`.
   subroutine take_step(m, dt, failure)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      logical :: new_masses, left_cell
      if (.not. m%mapped) call map_to_grid(m)
      new_masses = .not. (m%weighed .and. m%particles%total_frame)
      m%weighed = .true.
      if (size(m%loads) > 0) call find_external_force(m)
      if (is_local(m)) then
         call step_through_tiles(m, dt, new_masses, left_cell, failure)
      else
         call step_in_stages(m, dt, new_masses, left_cell, failure)
      end if
      m%response%is_behind = m%response%is_active
      if (.not. failure%failed()) call end_step(m, dt, 1, left_cell, failure)
   end subroutine take_step

   !> Book what the loads have done, and sort the particles if any has left its cell. Particles may have moved for several `dt`
   !> at once.
   subroutine end_step(m, dt, steps, left_cell, failure)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      integer, intent(in) :: steps
      logical, intent(in) :: left_cell
      type(failure_t), intent(inout) :: failure
      real(dp) :: work
      m%mapped = .not. left_cell
      call book_work(m%loads, m%time, m%particles, work, dt, steps)
      m%external_work = m%external_work + work
      if (m%audit) m%numerical_loss = m%numerical_loss + work
      m%time = m%time + steps*dt
      m%steps = m%steps + steps
      m%sorted = left_cell
      if (.not. left_cell) return
      if (m%particles%by_group) then
         call sort_anew(m, failure)
      else
         call change_cells(m, failure)
      end if
   end subroutine end_step

   !> Sort the particles after some have moved to other cells, and map the blocks that they have left or entered anew.
   subroutine change_cells(m, failure)
      type(motion_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      integer :: layout, b, l
      logical, allocatable :: touched(:)
      layout = m%fields%layout
      call sort_particles(m, failure, m%fields%left(:m%particles%n_blocks))
      if (failure%failed()) return
      call find_active_nodes(m%grid, m%particles, m%fields, failure)
      m%mapped = m%fields%layout == layout
      if (.not. m%mapped) return
      associate (p => m%particles)
         allocate (touched(p%n_blocks))
         do b = 1, p%n_blocks
            touched(b) = any([(p%changed(p%block_cells(l, b)), l=1, count(p%block_cells(:, b) > 0))])
         end do
         call sweep_list(m%scheme%map_at_start, 0.0_dp, m%materials, p, m%fields, .false., pack([(b, b=1, p%n_blocks)], touched))
      end associate
   end subroutine change_cells

   !> Nodal forces of the loads for the coming step: with the factors at t^n, at the places where the material is at t^n. Whatever path
   !> the step takes and whenever it strains the particles, these are the forces that act in it.
   subroutine find_external_force(m)
      type(motion_t), intent(inout) :: m
      m%fields%external = 0
      call add_loads(m%loads, m%time, m%grid, m%particles, m%fields%external)
      associate (all => m%fields%mass_matrix%all)
         call m%grid%dependents%collect(all%nodes(all%n_nodes + 1:all%n_points), ndim, m%fields%external)
      end associate
   end subroutine find_external_force

   !> Whether nodes need no more than the cells around them: then a step can be done in tiles.
   pure logical function is_local(m)
      type(motion_t), intent(in) :: m
      is_local = m%solver%by == by_lumped .and. m%grid%dependents%n == 0 .and. m%contact%n == 0 .and. .not. m%audit
   end function is_local

   !> Do the nodal sums and the sweeps of a step tile by tile, and book what the damping does.
   subroutine step_through_tiles(m, dt, new_masses, left_cell, failure)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      logical, intent(in) :: new_masses          !! whether nodal masses have changed since the last step
      logical, intent(out) :: left_cell
      type(failure_t), intent(inout) :: failure
      type(sweep_report_t) :: report
      real(dp) :: damping_power
      if (.not. m%plan%fits(m%fields)) call plan_pipeline(m%fields, size(m%scheme%sweeps), m%plan)
      call step_in_tiles(m%plan, m%scheme, dt, m%damping_rate, m%materials, m%constraints%free, new_masses, m%particles, &
                         m%fields, m%response, damping_power)
      m%damping_loss = m%damping_loss + dt*damping_power
      if (.not. m%particles%total_frame) call look_for_leavers(m%particles, m%fields, report)
      left_cell = report%left_cell
      if (report%jumped) call report_jump(m, failure)
   end subroutine step_through_tiles

   !> Do the nodal sums and the sweeps of a step, one after the other.
   subroutine step_in_stages(m, dt, new_masses, left_cell, failure)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      logical, intent(in) :: new_masses          !! whether nodal masses have changed since the last step
      logical, intent(out) :: left_cell
      type(failure_t), intent(inout) :: failure
      integer :: k
      left_cell = .false.
      associate (start => m%scheme%map_at_start)
         call gather(m%grid, m%fields, mass=new_masses, momentum=.true., force=start%map_force)
         call solve_velocity(m, at_start, merge(mapped, new, m%scheme%remaps), failure)
         if (start%map_force) call solve_acceleration(m, dt, failure)
      end associate
      do k = 1, size(m%scheme%sweeps)
         if (failure%failed()) return
         associate (sweep => m%scheme%sweeps(k))
            call sweep_and_book(m, sweep, dt, left_cell, failure)
            if (k == size(m%scheme%sweeps)) exit
            call gather(m%grid, m%fields, mass=.false., momentum=sweep%map_momentum, force=sweep%map_force)
            if (sweep%map_momentum) call solve_velocity(m, mapped, new, failure)
            if (sweep%map_force) call solve_acceleration(m, dt, failure)
         end associate
      end do
   end subroutine step_in_stages

   !> Sort the particles, after some have moved to other cells or their number has changed.
   subroutine sort_anew(m, failure)
      type(motion_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      m%mapped = .false.
      call sort_particles(m, failure)
      if (.not. failure%failed()) call find_active_nodes(m%grid, m%particles, m%fields, failure)
   end subroutine sort_anew

   !> Map the particles to the grid at the start of a step, where the last step has not done so.
   subroutine map_to_grid(m)
      type(motion_t), intent(inout) :: m
      type(sweep_report_t) :: report
      type(sweep_t) :: map
      m%weighed = .false.
      map = m%scheme%map_at_start
      map%map_force = map%map_force .or. m%particles%total_frame      ! responses add to the force that is there
      call sweep_particles(map, 0.0_dp, m%materials, m%particles, m%fields, .false., report)
      call fit_to_cells(m)
      m%mapped = .true.
   end subroutine map_to_grid

   !> Find the cells that are swept without their particles, from particles and shares of cells that fit each other.
   subroutine fit_to_cells(m)
      type(motion_t), intent(inout) :: m
      call fit_response(m%particles%total_frame .and. .not. m%audit, m%materials, m%loads, m%particles, m%fields, m%response)
   end subroutine fit_to_cells

   !> Bring the nodal masses and the mass matrix to the present positions of the particles, for extrapolations between steps.
   subroutine refresh_grid(m)
      type(motion_t), intent(inout) :: m
      if (.not. m%mapped) call map_to_grid(m)
      call gather(m%grid, m%fields, mass=.true., momentum=.true., force=.false.)
   end subroutine refresh_grid

   !> Do one sweep, and book for the audit what it finds.
   subroutine sweep_and_book(m, sweep, dt, left_cell, failure)
      type(motion_t), intent(inout) :: m
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt
      logical, intent(out) :: left_cell
      type(failure_t), intent(inout) :: failure
      type(sweep_report_t) :: report
      if (m%response%is_active) then
         call respond_everywhere(m%response, sweep, dt, m%materials, m%particles, m%fields)
      else
         call sweep_particles(sweep, dt, m%materials, m%particles, m%fields, m%audit, report)
      end if
      left_cell = report%left_cell
      if (report%jumped) call report_jump(m, failure)
      if (m%audit) m%numerical_loss = m%numerical_loss - report%velocity_change_energy - report%stress_work
   end subroutine sweep_and_book

   !> Velocities of the nodes, `at_start` or `mapped`, from their momentum.
   subroutine solve_velocity(m, which, latest, failure)
      type(motion_t), intent(inout) :: m
      integer, intent(in) :: which
      integer, intent(in) :: latest              !! the velocity that was found last, as a guess
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      call find_velocity(m%grid, m%solver, m%fields, which, latest, unsolved)
      if (m%contact%n > 0) call share_velocity(m%contact, m%grid, m%fields, which)
      call pass_on(m, m%steps + 1, unsolved, failure)
   end subroutine solve_velocity

   !> Accelerations from the forces, and the velocities that move the particles; book what the forces do.
   subroutine solve_acceleration(m, dt, failure)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      real(dp) :: damping_power, mapping_power
      associate (all => m%fields%mass_matrix%all)
         call m%grid%dependents%collect(all%nodes(all%n_nodes + 1:all%n_points), ndim, m%fields%force)
      end associate
      if (size(m%loads) > 0) m%fields%force = m%fields%force + m%fields%external
      call accelerate(m%grid, m%solver, m%damping_rate, dt, m%audit, m%fields, damping_power, mapping_power, unsolved)
      if (m%contact%n > 0) call keep_apart(m%contact, m%grid, m%damping_rate, dt, m%fields, damping_power, mapping_power)
      call pass_on(m, m%steps + 1, unsolved, failure)
      m%damping_loss = m%damping_loss + dt*damping_power
      if (m%audit) m%numerical_loss = m%numerical_loss + dt*mapping_power
   end subroutine solve_acceleration

   !> Sort the particles into the cells of the grid, with the loads that they carry. Fails where one has left the grid or gone
   !> through a cut: it would go on as part of the other side.
   subroutine sort_particles(m, failure, left)
      type(motion_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: left(:)   !! the blocks that some particle has left, where that is known
      type(failure_t) :: lost
      call sort_into_cells(m%particles, m%grid, lost, left)
      call pass_on(m, m%steps, lost, failure)
      if (failure%failed()) return
      call follow_sort(m%loads, m%particles%new_place)
      if (size(m%grid%cuts) > 0 .and. .not. m%particles%total_frame) call look_for_crossing(m, failure)
   end subroutine sort_particles

   !> Fail where a particle is no longer on its side of a cut.
   subroutine look_for_crossing(m, failure)
      type(motion_t), intent(in) :: m
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: advice
      real(dp) :: start(ndim)
      integer :: i, k
      do i = 1, m%particles%n
         start = m%particles%reference(i, :)
         do k = 1, size(m%grid%cuts)
            if (.not. crosses(m%grid%cuts(k), m%grid%forest, start, m%particles%position(i))) cycle
            advice = 'a face, or the body as a whole, moves by more than a fraction of a cell: use &method frame = ''total'''
            if (.not. m%contact%wanted) advice = advice//'; or the faces press on each other: use &crack contact = '// &
                                                 '''frictionless'''
            call failure%report(exit_computation, when(m%steps, m%time)//'the particle that started at '// &
                                origin(m%grid, m%particles, i)//' has crossed the line of the crack, and would stick to the '// &
                                'other face. Likely cause: '//advice)
            return
         end do
      end do
   end subroutine look_for_crossing

   !> Fail as a part of a step did, if it did, and say when.
   subroutine pass_on(m, step, part, failure)
      type(motion_t), intent(in) :: m
      integer(long), intent(in) :: step
      type(failure_t), intent(in) :: part
      type(failure_t), intent(inout) :: failure
      if (part%failed()) call failure%report(part%code, when(step, m%time)//part%message)
   end subroutine pass_on

   !> Fail because a particle has moved further than a stable run would, naming it and the likely cause.
   subroutine report_jump(m, failure)
      type(motion_t), intent(in) :: m
      type(failure_t), intent(inout) :: failure
      integer :: i
      do i = 1, m%particles%n
         if (.not. has_jumped(m, i)) cycle
         call failure%report(exit_computation, when(m%steps + 1, m%time)// &
                             'the particle that started at '//origin(m%grid, m%particles, i)// &
                             ' moved by more than a cell in one step or is no longer a number. Likely cause: '// &
                             'the run is unstable, or a body is too fast for its cells; reduce &method courant')
         return
      end do
   end subroutine report_jump

   !> Whether a particle is no longer in its cell or one beside it.
   pure logical function has_jumped(m, i)
      type(motion_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp) :: xi(ndim)
      xi = m%grid%local_coordinate(m%particles%cell(i), m%particles%position(i))
      has_jumped = .not. all(xi >= -1 .and. xi < 2)
   end function has_jumped

   !> The time step (31): courant times the size of the smallest cell over the largest wave speed [s].
   pure real(dp) function stable_time_step(cell, materials, courant, wave_speed) result(dt)
      real(dp), intent(in) :: cell               !! size of the smallest cell with particles [m]
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: courant            !! [-]
      character(*), intent(in) :: wave_speed     !! 'shear', as in (32), or 'dilatational'
      real(dp) :: speed
      integer :: k
      speed = 0
      do k = 1, size(materials)
         if (wave_speed == 'shear') then
            speed = max(speed, materials(k)%shear_wave_speed())
         else
            speed = max(speed, materials(k)%dilatational_wave_speed())
         end if
      end do
      dt = courant*cell/speed
   end function stable_time_step
end module hampm_step
