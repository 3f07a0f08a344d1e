!> One explicit time step of the material point method, as `hampm_reference_step` has it, on the path that is fastest for a model:
!>
!>   in tiles   where a node needs no more than the cells around it: nodes and particles of a part of the grid after each other;
!>   in stages  elsewhere: with mass matrices not lumped, hanging nodes, faces in contact, or the energy balance, first
!>              all nodes and then all particles.
!>
!> On both, cells that have element operators are passed without their particles (`hampm_element_operators`).
module hampm_step
   use hampm_kinds, only: dp, ndim, long
   use hampm_constraints, only: let_turn
   use hampm_body_contact, only: find_body_pairs, find_gaps, share_between_bodies, separate_bodies
   use hampm_nodal_release, only: work_of_release
   use hampm_prescribed_nodes, only: prescribed_velocity, prescribed_acceleration, coupled_to_prescribed, set_prescribed, &
                                     move_prescribed, find_work
   use hampm_element_operators, only: pass_by_all_operators, refresh_sums
   use hampm_failure, only: failure_t, exit_computation
   use hampm_integrator, only: integrator_t
   use hampm_loads, only: book_work, book_work_late
   use hampm_mass_solver, only: by_lumped
   use hampm_critical_step, only: largest_wave_speed
   use hampm_problem, only: problem_t, update_particles, map_to_grid, do_pass, assemble_sums, sort_particles, sort_anew, pass_on, &
                           renew_interfaces, is_weighed, keeps_velocity
   use hampm_nodal_fields, only: v_n, v_next, v_mapped, find_active_nodes
   use hampm_nodal_state, only: find_external_force
   use hampm_nodal_motion, only: find_velocity, accelerate, find_powers
   use hampm_particle_pass, only: pass_report_t, pass_over_all, pass_over, find_crossing_particles
   use hampm_pass, only: pass_t
   use hampm_tiling, only: plan_tiles, is_planned, step_in_tiles
   use hampm_vectors, only: add_scaled
   use hampm_interface_step, only: hold_faces, commit_faces, accelerate_by_faces
   use hampm_interface_points, only: add_interface_forces, stretch_interfaces, ease_faces, interface_energy, &
                                     kick_interfaces
   use hampm_error_context, only: when, origin
   implicit none
   private
   public :: explicit_t, advance, report_jump, end_step

   !> Explicit integration: all cells take the same time step, and nothing is kept from step to step.
   type, extends(integrator_t) :: explicit_t
   contains
      procedure :: advance => take_step
   end type explicit_t

contains

   !> Advance by one step `dt`, with all particles. Fails where a particle leaves the grid or jumps.
   subroutine advance(m, dt, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      type(explicit_t) :: explicit
      call explicit%advance(m, dt, failure)
      if (.not. failure%failed()) call update_particles(m)
   end subroutine advance

   !> As `advance`, but particles may stay behind until `update_particles`.
   subroutine take_step(self, m, dt, failure)
      class(explicit_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      type(pass_report_t) :: report
      logical :: new_masses
      real(dp) :: loss
      integer :: part, parts                     ! of a step in tiles: before and behind forces at its end
      if (.not. m%cache%mapped) call map_to_grid(m, failure)
      if (failure%failed()) return
      new_masses = .not. is_weighed(m)
      m%cache%weighed = .true.
      if (m%body_contact%wanted) call find_surroundings(m)
      ! With the factors and the places of the material at t^n: on any path, whenever a step strains the particles, these forces act
      ! in it
      if (has_external(m) .or. is_local(m) .and. m%interfaces%n > 0) & ! tiles always add what it was last
         call find_external_force(m, .true., m%interfaces%n_at_end + 1)
      call m%absorbing%renew(m%loads, m%grid, m%particles, m%fields%mass_matrix, m%fields%layout)
      if (is_local(m)) then
         call plan_step(m)
         if (m%cache%operators%is_active) call prepare_sums(m, new_masses)
         parts = merge(2, 0, waits_for_forces(m))
         do part = min(parts, 1), parts
            call step_in_tiles(m%cache%tiling, m%scheme, dt, m%damping_rate, m%matter_t, m%constraints%free, new_masses, m%fields, &
                               m%cache%operators, loss, part)
            if (part == 1) call add_forces_at_end(m, dt, failure)
            m%energies%damping_loss = m%energies%damping_loss + loss
         end do
         if (.not. m%particles%total_frame) call find_crossing_particles(m%matter_t, m%fields, report)
      else
         call step_in_stages(m, dt, new_masses, report, failure)
      end if
      m%cache%operators%is_behind = m%cache%operators%is_active
      if (report%jumped) call report_jump(m, failure)
      if (size(m%loads) > 0) call book_loads(m, dt)
      if (m%interfaces%n > 0) call follow_interfaces(m, dt)
      if (.not. failure%failed()) call end_step(m, dt, 1, report%left_cell, failure)
   end subroutine take_step

   !> Find which bodies are near each other, and where.
   subroutine find_surroundings(m)
      type(problem_t), intent(inout) :: m
      call find_body_pairs(m%body_contact, m%grid, m%fields)
      call find_gaps(m%body_contact, m%grid, m%particles, m%blocks, m%corners)
   end subroutine find_surroundings

   !> Whether nodes need no more than the cells around them: then a step can be done in tiles.
   pure logical function is_local(m)
      type(problem_t), intent(in) :: m
      is_local = m%solver%by == by_lumped .and. m%grid%dofs%n_hanging == 0 .and. m%body_contact%n == 0 &
                 .and. .not. m%audit .and. .not. m%constraints%move() .and. .not. m%has_domains() &
                 .and. .not. allocated(m%blocks%supports) .and. (m%particles%total_frame .or. m%interfaces%n + m%absorbing%n == 0)
   end function is_local

   !> Whether loads or interface points act with forces that a step has from its start.
   pure logical function has_external(m)
      type(problem_t), intent(in) :: m
      has_external = size(m%loads) > 0 .or. m%interfaces%n > m%interfaces%n_at_end
   end function has_external

   !> Whether forces at the end of the step act on some nodes.
   pure logical function waits_for_forces(m)
      type(problem_t), intent(in) :: m
      waits_for_forces = m%interfaces%n_at_end + m%absorbing%n > 0
   end function waits_for_forces

   !> Prepare the sums of points that keep them, in a step in tiles.
   subroutine prepare_sums(m, new_masses)
      type(problem_t), intent(inout) :: m
      logical, intent(inout) :: new_masses       !! whether nodal masses have changed: not any more
      if (new_masses) call assemble_sums(m, mass=.true., momentum=.false., force=.false.)
      new_masses = .false.
      associate (operators => m%cache%operators)
         call refresh_sums(operators, m%blocks, m%fields)
         if (.not. allocated(operators%mobility)) &
            operators%mobility = m%constraints%free*spread(m%fields%mass_matrix%inverse_lumped, 1, ndim)
      end associate
   end subroutine prepare_sums

   !> Plan a step in tiles, with nodes that wait for forces at its end.
   subroutine plan_step(m)
      type(problem_t), intent(inout) :: m
      logical, allocatable :: waits(:)
      if (waits_for_forces(m) .and. .not. is_planned(m%cache%tiling, m%blocks)) waits = around_forces(m)
      associate (all => m%fields%mass_matrix%all)
         call plan_tiles(m%blocks, all%nodes(:all%n_nodes), size(m%scheme%passes), m%cache%operators, m%cache%tiling, waits)
      end associate
   end subroutine plan_step

   !> The nodes of interface points and dashpots, and those around the cells beside these.
   pure function around_forces(m) result(is_near)
      type(problem_t), intent(in) :: m
      logical, allocatable :: is_near(:)
      integer :: k, j
      allocate (is_near(m%grid%n_points))
      is_near = .false.
      do k = 1, m%interfaces%n
         do j = 1, count(m%interfaces%list(k)%jump%node > 0)
            call mark(m%interfaces%list(k)%jump%node(j), is_near)
         end do
      end do
      do k = 1, m%absorbing%n
         call mark(m%absorbing%node(k), is_near)
      end do
   contains
      !> Mark the nodes of the cells around one.
      pure subroutine mark(node, is_near)
         integer, intent(in) :: node
         logical, intent(inout) :: is_near(:)
         integer :: e
         associate (around => m%grid%dofs%elements_at(node))
            do e = 1, size(around)
               is_near(m%grid%element_nodes(:, around(e))) = .true.
            end do
         end associate
      end subroutine mark
   end function around_forces

   !> Do the nodal sums and the passes of a step, one after the other.
   subroutine step_in_stages(m, dt, new_masses, report, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      logical, intent(in) :: new_masses          !! whether nodal masses have changed since the last step
      type(pass_report_t), intent(inout) :: report
      type(failure_t), intent(inout) :: failure
      type(pass_t) :: audited
      real(dp) :: kick_energy
      integer :: k
      associate (start => m%scheme%map_at_start)
         call assemble_sums(m, mass=new_masses, momentum=.true., force=start%map_force)
         call solve_velocity(m, v_n, merge(v_mapped, v_next, m%scheme%remaps), failure)
         if (start%map_force) call solve_acceleration(m, dt, failure)
      end associate
      do k = 1, size(m%scheme%passes)
         if (failure%failed()) return
         associate (pass => m%scheme%passes(k))
            audited = pass
            audited%audit = m%audit
            if (m%cache%operators%is_active) then
               call pass_by_all_operators(m%cache%operators, pass, dt, m%matter_t, m%fields)
            else if (m%has_domains()) then
               call do_pass(m, audited, dt, report, failure)
            else
               call pass_over_all(audited, dt, m%matter_t, m%fields, report)
            end if
            kick_energy = 0
            if (pass%kick .and. m%interfaces%n > 0) call kick_interfaces(m%interfaces, m%fields%acceleration, dt, kick_energy)
            if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss - report%velocity_change_energy - kick_energy &
                                                     - report%stress_work
            if (k == size(m%scheme%passes) .or. failure%failed() .or. report%jumped) return
            call assemble_sums(m, mass=pass%map_mass, momentum=pass%map_momentum, force=pass%map_force)
            if (m%body_contact%wanted .and. pass%map_mass) call find_surroundings(m)
            if (pass%map_momentum) call solve_velocity(m, merge(v_n, v_mapped, pass%map_force), v_next, failure)
            if (m%has_domains() .and. pass%strain_fraction > 0 .and. has_external(m)) &
               call find_external_force(m, .true., m%interfaces%n_at_end + 1)
            if (pass%map_force) call solve_acceleration(m, dt, failure)
         end associate
      end do
   end subroutine step_in_stages

   !> Velocities of the nodes, `v_n` or `v_mapped`, from their momentum.
   subroutine solve_velocity(m, which, latest, failure)
      type(problem_t), intent(inout) :: m
      integer, intent(in) :: which
      integer, intent(in) :: latest              !! the velocity that was found last, as a guess
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: prescribed(:, :), momentum(:, :)
      type(failure_t) :: unsolved
      logical :: couples                         ! whether nodes of given motion stand in the equations of others
      if (which == v_n .and. m%cache%velocity_after == m%state%steps) then
         m%fields%velocity(:, :, v_n) = m%fields%velocity(:, :, v_mapped)
      else if (m%constraints%move()) then
         prescribed = prescribed_velocity(m%constraints, m%state%time, m%energies%prescribed, m%fields, which)
         couples = m%solver%by /= by_lumped .or. allocated(m%constraints%turning)
         if (couples) then
            momentum = m%fields%momentum
            m%fields%momentum = momentum - coupled_to_prescribed(m%constraints, m%grid, m%fields, prescribed)
         end if
         call find_velocity(m%grid, m%solver, m%constraints%free, m%fields, which, latest, unsolved)
         if (couples) call move_alloc(momentum, m%fields%momentum)
         call set_prescribed(m%constraints, m%grid, m%fields, prescribed, m%fields%velocity(:, :, which))
      else
         call find_velocity(m%grid, m%solver, m%constraints%free, m%fields, which, latest, unsolved)
      end if
      m%cache%velocity_after = merge(m%state%steps + 1, -1_long, which == v_mapped .and. keeps_velocity(m))
      if (m%body_contact%n > 0) call share_between_bodies(m%body_contact, m%grid, m%constraints%free, m%fields, which)
      call pass_on(m, m%state%steps + 1, unsolved, failure)
   end subroutine solve_velocity

   !> Accelerations from the forces, and the velocities that move the particles; book the work of the forces.
   subroutine solve_acceleration(m, dt, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      real(dp), allocatable :: prescribed(:, :), force(:, :)
      real(dp) :: damping_power, mapping_power, work, taken !! work that bodies lose by meeting [J]
      logical :: moves, couples                  ! whether the motion of nodes is given, and these stand in the equations of others
      logical :: wants_powers, is_changed        ! whether they are wanted, and the motion is changed once accelerations are found
      moves = m%constraints%move()
      wants_powers = m%audit .or. m%damping_rate > 0
      is_changed = moves .or. m%body_contact%n + m%interfaces%n + m%absorbing%n > 0
      couples = moves .and. (m%solver%by /= by_lumped .or. allocated(m%constraints%turning))
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, m%fields%force)
      if (has_external(m)) call add_scaled(size(m%fields%force), 1.0_dp, m%fields%external, m%fields%force)
      if (moves) prescribed = prescribed_acceleration(m%constraints, m%state%time, dt, m%fields)
      if (couples) then
         force = m%fields%force
         m%fields%force = force - coupled_to_prescribed(m%constraints, m%grid, m%fields, prescribed)
      end if
      call accelerate(m%grid, m%solver, m%constraints%free, m%damping_rate, dt, wants_powers .and. .not. is_changed, &
                      m%cache%acceleration_after == m%state%steps, m%fields, damping_power, mapping_power, unsolved)
      if (couples) call move_alloc(force, m%fields%force)
      if (moves) call move_prescribed(m%constraints, m%grid, dt, prescribed, m%fields)
      if (waits_for_forces(m)) call add_forces_at_end(m, dt, unsolved)
      if (moves) then
         call find_work(m%constraints, m%grid, dt, m%damping_rate, m%fields, m%energies%prescribed, work)
         m%energies%external_work = m%energies%external_work + work
         if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss + work
      end if
      taken = m%body_contact%loss + m%body_contact%friction_loss
      if (m%body_contact%n > 0) call separate_bodies(m%body_contact, m%grid, m%constraints%free, dt, m%fields)
      taken = m%body_contact%loss + m%body_contact%friction_loss - taken
      if (wants_powers .and. is_changed) call find_powers(m%fields, m%damping_rate, damping_power, mapping_power)
      call pass_on(m, m%state%steps + 1, unsolved, failure)
      m%energies%damping_loss = m%energies%damping_loss + dt*damping_power
      if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss + dt*mapping_power - taken
   end subroutine solve_acceleration

   !> Let dashpots act, by their forces in the middle of the step, and interface points, by theirs at its end. Dashpots see the
   !> motion that these have already stopped: from equilibrium none begins.
   subroutine add_forces_at_end(m, dt, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: before(:, :)      ! forces on the nodes [N]
      real(dp), allocatable :: by_faces(:, :)    ! accelerations of the nodes by interface points as they are [m/s2]
      real(dp) :: taken                          ! by dashpots [J]
      if (m%interfaces%n_at_end > 0 .and. strains_first(m)) call open_faces(m, v_n, dt)
      associate (f => m%fields)
         if (m%absorbing%n > 0) then
            if (m%interfaces%n_at_end > 0) then
               allocate (by_faces, source=0*f%acceleration)
               call accelerate_by_faces(m%interface_step, m%interfaces, m%matter_t, m%constraints%fixed, m%corners, &
                                        f%mass_matrix, m%solver, by_faces, failure)
               f%velocity(:, :, v_next) = f%velocity(:, :, v_next) + dt*by_faces
            end if
            call m%absorbing%brake(m%constraints%free, f%mass_matrix%lumped, dt, f%velocity(:, :, v_n), f%velocity(:, :, v_next), &
                                   f%acceleration, f%force, taken)
            if (allocated(by_faces)) f%velocity(:, :, v_next) = f%velocity(:, :, v_next) - dt*by_faces
            m%energies%absorbed_energy = m%energies%absorbed_energy + taken
            if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss - taken
         end if
         if (allocated(m%constraints%turning)) then ! by those forces too: the present ones, then their increments
            allocate (before, source=0*f%force)
            call add_interface_forces(m%interfaces, 1, before, m%interfaces%n_at_end)
            call turn_by(m, dt, before)
            before = f%force + before
         end if
         if (m%interfaces%n_at_end > 0) &
            call hold_faces(m%interface_step, m%interfaces, m%matter_t, m%constraints%fixed, m%corners, dt, &
                         f%mass_matrix, m%solver, &
                         f%velocity(:, :, v_next), f%acceleration, f%force, failure)
         if (allocated(before)) call turn_by(m, dt, f%force - before)
         call m%grid%dofs%distribute(f%mass_matrix%all, ndim, f%acceleration)
         call m%grid%dofs%distribute(f%mass_matrix%all, ndim, f%velocity(:, :, v_next))
      end associate
   end subroutine add_forces_at_end

   !> Turn boxes by forces besides those for which their accelerations have been found.
   subroutine turn_by(m, dt, force)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: force(:, :)        !! [N], (ndim, n_points)
      real(dp) :: a(ndim, m%grid%n_points)
      a = 0
      call let_turn(m%constraints, m%fields%mass_matrix%lumped, force, a)
      m%fields%acceleration = m%fields%acceleration + a
      m%fields%velocity(:, :, v_next) = m%fields%velocity(:, :, v_next) + dt*a
   end subroutine turn_by

   !> Book the work of the loads in a step that has mapped the new velocities, or will do so only in the next.
   subroutine book_loads(m, dt)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      real(dp) :: work
      if (m%scheme%remaps) then
         call book_work(m%loads, m%particles, m%state%time, dt, m%fields%velocity(:, :, v_mapped), work)
      else
         call book_work_late(m%loads, m%particles, m%state%time, dt, m%state%last_dt, m%fields%velocity(:, :, v_n), work)
      end if
      m%state%last_dt = dt
      m%energies%external_work = m%energies%external_work + work
      if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss + work
   end subroutine book_loads

   !> Let interface points follow the velocities that strain the particles; their stored energy, friction and failure are no loss of
   !> the method.
   subroutine follow_interfaces(m, dt)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      real(dp) :: taken
      associate (velocity => m%fields%velocity, after => merge(v_mapped, v_next, m%scheme%remaps))
         taken = work_of_release(m%interfaces, velocity(:, :, v_n), velocity(:, :, after), dt, is_implicit=.false.)
         if (.not. strains_first(m)) call open_faces(m, after, dt)
      end associate
      m%energies%fracture_energy = m%energies%fracture_energy + taken
      if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss - taken
   end subroutine follow_interfaces

   !> Whether interface points, as the particles, follow the velocities at the beginning of a step: in usf, with forces at its end.
   pure logical function strains_first(m)
      type(problem_t), intent(in) :: m
      strains_first = m%interfaces%n_at_end > 0 .and. m%interfaces%n_at_end == m%interfaces%n .and. m%scheme%name == 'usf'
   end function strains_first

   !> Open interface points by a velocity.
   subroutine open_faces(m, which, dt)
      type(problem_t), intent(inout) :: m
      integer, intent(in) :: which               !! the velocity
      real(dp), intent(in) :: dt                 !! [s]
      if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss + interface_energy(m%interfaces) + m%interfaces%loss
      call stretch_interfaces(m%interfaces, m%fields%velocity(:, :, which), dt)
      call commit_faces(m%interface_step, m%interfaces)
      call ease_faces(m%interfaces, dt*largest_wave_speed(m%materials, 'shear'))
      if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss - interface_energy(m%interfaces) - m%interfaces%loss
   end subroutine open_faces

   !> Count a step, and sort the particles if any has left its cell. Particles may have moved for several `dt` at once.
   subroutine end_step(m, dt, steps, left_cell, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      integer, intent(in) :: steps
      logical, intent(in) :: left_cell
      type(failure_t), intent(inout) :: failure
      m%cache%mapped = .not. (left_cell .or. m%has_domains())
      m%state%time = m%state%time + steps*dt
      m%state%steps = m%state%steps + steps
      m%cache%sorted = left_cell
      if (.not. left_cell) return
      if (m%has_domains()) then
         call sort_anew(m, failure)
      else
         call change_cells(m, failure)
      end if
   end subroutine end_step

   !> Sort the particles after some have moved to other cells, and map the blocks that they have left or entered anew.
   subroutine change_cells(m, failure)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      integer :: layout, b, l
      logical, allocatable :: touched(:)
      layout = m%fields%layout
      call sort_particles(m, failure, m%fields%left(:m%blocks%n))
      if (failure%failed()) return
      call find_active_nodes(m%grid, m%blocks, m%fields, failure)
      m%cache%mapped = m%fields%layout == layout
      if (.not. m%cache%mapped) call renew_interfaces(m)
      if (.not. m%cache%mapped) return
      associate (blocks => m%blocks)
         allocate (touched(blocks%n))
         do b = 1, blocks%n
            touched(b) = any([(m%cache%sorting%changed(blocks%cells(l, b)), l=1, count(blocks%cells(:, b) > 0))])
         end do
         call pass_over(m%scheme%map_at_start, 0.0_dp, m%matter_t, m%fields, &
                        pack([(b, b=1, blocks%n)], touched))
      end associate
   end subroutine change_cells

   !> Fail because a particle has moved further than a stable run would, naming it and the likely cause.
   subroutine report_jump(m, failure)
      type(problem_t), intent(in) :: m
      type(failure_t), intent(inout) :: failure
      integer :: i
      do i = 1, m%particles%n
         if (.not. has_jumped(m, i)) cycle
         call failure%report(exit_computation, when(m%state%steps + 1, m%state%time)// &
                             'the particle that started at '//origin(m%grid, m%particles, i)// &
                             ' moved by more than a cell in one step or is no longer a number. Likely cause: '// &
                             'the run is unstable, or a body is too fast for its cells; reduce &method courant')
         return
      end do
   end subroutine report_jump

   !> Whether a particle is no longer in its cell or one beside it.
   pure logical function has_jumped(m, i)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp) :: xi(ndim)
      xi = m%grid%local_coordinate(m%particles%cell(i), m%particles%position(i))
      has_jumped = .not. all(xi >= -1 .and. xi < 2)
   end function has_jumped
end module hampm_step
