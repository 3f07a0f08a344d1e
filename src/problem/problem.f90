!> The problem that a run solves, and its state between two steps.
module hampm_problem
   use hampm_kinds, only: dp, corners, long
   use hampm_absorbing_edges, only: absorbing_edges_t, nodes_of_dashpots
   use hampm_body_contact, only: body_contact_t, rebuild_body_contact
   use hampm_constraints, only: constraints_t, rebuild_constraints, find_levers
   use hampm_domain_pass, only: corner_map_t, locate_corners, move_corners, map_corners, assemble_corners
   use hampm_energy, only: energy_of_particles => kinetic_energy, strain_energy, dissipation
   use hampm_element_operators, only: element_operators_t, find_operators, assemble_all, give_to_particles
   use hampm_ghost_penalty, only: enough_alone, are_nearly_empty
   use hampm_interface_points, only: interfaces_t, bonded, releasing, cohesive, ghost, interface_energy, energy_of_rates, &
                                     jumps_with_mass, add_interface_momentum
   use hampm_failure, only: failure_t, exit_computation, exit_input
   use hampm_loads, only: load_t, follow_sort, share_by_mass
   use hampm_mass_choice, only: mass_choice_t, choose_cells
   use hampm_mass_product, only: by_mass
   use hampm_mass_solver, only: mass_solver_t, new_mass_solver, by_lumped, by_fmpm
   use hampm_matter, only: matter_t
   use hampm_state_update, only: update_particle_state
   use hampm_mass_matrix, only: find_coupled_region, lump_at
   use hampm_nodal_fields, only: nodal_fields_t, new_nodal_fields, find_active_nodes, finish_sums
   use hampm_particle_pass, only: pass_report_t, pass_over_all
   use hampm_pass, only: pass_t, scheme_t, new_scheme, new_scheme_of_domains
   use hampm_quadratic_points, only: weigh_points
   use hampm_sorting, only: sorting_t, sort_into_cells
   use hampm_interface_placement, only: rebuild_interfaces
   use hampm_jumps, only: nodes_of_jumps
   use hampm_interface_step, only: interface_step_t, forget_faces
   use hampm_state, only: state_t, energies_t
   use hampm_text, only: to_text, point_text
   use hampm_tiling, only: tiling_t
   use hampm_error_context, only: when
   implicit none
   private
   public :: problem_t, start_problem, rebuild_on_grid, renew_interfaces, sort_particles, sort_anew, weigh_particles, &
             update_particles, map_to_grid, rebuild_operators, refresh_grid, is_weighed, keeps_velocity, pass_on, do_pass, &
             assemble_sums, kinetic_energy, stored_energy, dissipated_energy, archive_history

   integer, parameter :: cells_around_tips = 4   !! within which mass = 'tip_weighted' is not lumped

   !> Derived data that make steps fast.
   type :: cache_t
      type(sorting_t) :: sorting                 !! how particles got into their order
      type(tiling_t) :: tiling                   !! of steps in tiles
      type(element_operators_t) :: operators     !! of cells that are passed without their particles
      logical :: mapped = .false.                !! whether the cells hold the contributions for the next step
      logical :: weighed = .false.               !! whether the nodes have the masses that these give
      integer(long) :: velocity_after = -1       !! steps after which `v_mapped` is the nodal velocity, the start of the next step
      integer(long) :: acceleration_after = -1   !! the same for the acceleration by the forces
      logical :: sorted = .false.                !! whether particles moved to other cells in the last step
      logical :: is_provisional = .false.        !! whether the mesh will change before any motion: nodes and weights wait
   end type cache_t

   !> The body and its loading: particles of materials in the cells of a grid, constraints, loads and interfaces; its solution
   !> method, and its state.
   type, extends(matter_t) :: problem_t
      type(constraints_t) :: constraints
      type(load_t), allocatable :: loads(:)
      type(absorbing_edges_t) :: absorbing       !! dashpots on edges
      real(dp) :: damping_rate = 0               !! alpha of the force -alpha m v [1/s]
      logical :: audit = .false.                 !! whether to book the numerical loss
      logical :: is_explicit = .true.            !! explicit steps, in which cells may be processed without their particles
      type(scheme_t) :: scheme
      type(mass_choice_t) :: mass                !! kind of mass matrix
      type(mass_solver_t) :: solver
      type(nodal_fields_t) :: fields
      type(body_contact_t) :: body_contact       !! of bodies with velocity fields of their own
      type(corner_map_t) :: corners              !! of the domains of particles, where these have any
      type(interfaces_t) :: interfaces           !! between the sides of cracks that cut cells
      type(interface_step_t) :: interface_step   !! and their forces in explicit steps
      type(state_t) :: state                     !! time, and nodal values
      type(energies_t) :: energies               !! work and losses so far
      type(cache_t) :: cache                     !! derived data
   contains
      procedure :: has_domains
      procedure :: runs_lumped
   end type problem_t

contains

   !> Whether particles have domains (`hampm_domains`).
   pure logical function has_domains(self)
      class(problem_t), intent(in) :: self
      has_domains = allocated(self%particles%corner_velocity)
   end function has_domains

   !> Whether cracks that grow run through lumped masses in explicit steps.
   pure logical function runs_lumped(self)
      class(problem_t), intent(in) :: self
      runs_lumped = self%is_explicit .and. (self%mass%by == by_lumped .or. self%interfaces%are_lumped)
   end function runs_lumped

   !> Prepare for the first step with a scheme ('usf', 'usl', 'usavg' or 'musl') and, where it is not to be lumped, a mass
   !> matrix.
   subroutine start_problem(m, scheme, failure, mass)
      type(problem_t), intent(inout) :: m
      character(*), intent(in) :: scheme
      type(failure_t), intent(inout) :: failure
      type(mass_choice_t), intent(in), optional :: mass
      if (present(mass)) m%mass = mass
      if (m%has_domains()) then
         m%scheme = new_scheme_of_domains(scheme, m%mass%by /= by_lumped)
      else
         m%scheme = new_scheme(scheme, m%mass%by /= by_lumped, m%particles%total_frame)
      end if
      if (.not. allocated(m%loads)) allocate (m%loads(0))
      m%interfaces%strain_last = scheme == 'usl'
      call rebuild_on_grid(m, failure)
   end subroutine start_problem

   !> Make constraints, contact, nodal fields and solver fit a new grid, into which the particles are sorted. Fails where the
   !> memory does not suffice.
   subroutine rebuild_on_grid(m, failure)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      type(element_operators_t) :: none
      m%cache%mapped = .false.
      if (m%cache%is_provisional) return
      m%blocks%layout = m%blocks%layout + 1      ! places of its elements are new
      m%blocks%by_supports = any(m%materials%mean_dilatation) .or. m%particles%thickness%is_ring
      m%cache%tiling = tiling_t()
      m%cache%operators = none
      m%corners = corner_map_t()
      call rebuild_constraints(m%constraints, m%grid)
      if (m%constraints%move()) call find_levers(m%constraints, m%grid, nodes_with_material(m))
      call rebuild_body_contact(m%body_contact, m%grid)
      call rebuild_interfaces(m%interfaces, m%matter_t, m%constraints)
      m%interfaces%are_lumped = m%mass%by == by_lumped .or. &
                                .not. m%particles%total_frame .and. (m%mass%by == by_fmpm .or. m%grid%is_quadratic()) .or. &
                                .not. m%grid%is_quadratic() .and. (m%interfaces%n_contact + m%interfaces%n_cohesive > 0 .or. &
                                                                   any(m%interfaces%list(:m%interfaces%n)%law == ghost))
      call forget_faces(m%interface_step)
      if (m%interfaces%alone > 0) call report_thin_piece(m, failure)
      if (m%interfaces%n_cohesive > 0) call check_layers(m, failure)
      if (.not. failure%failed()) call new_nodal_fields(m%grid, m%fields, failure)
      if (failure%failed()) return
      call choose_cells(m%mass, m%grid, near_growing_tips(m), m%fields%mass_matrix, failure)
      if (failure%failed()) return
      m%fields%mass_matrix%stays = m%particles%total_frame
      if (allocated(m%fields%mass_matrix%lumped_fraction)) then
         m%fields%mass_matrix%ghosts = jumps_with_mass(m%interfaces)
         ! For quadratic cells that are cut or have nodes on an axis
         if (allocated(m%grid%correction) .or. m%particles%thickness%is_ring .and. m%grid%is_quadratic()) &
            allocate (m%fields%mass_matrix%diagonal(m%grid%n_points), source=0.0_dp)
      end if
      call lump_at(m%fields%mass_matrix, m%grid, [m%constraints%supporting(), m%constraints%nodes_that_turn(), &
                                                  nodes_lumped_in_steps(m), lumped_by_dashpots(m)])
      if (m%body_contact%wanted .and. allocated(m%fields%mass_matrix%lumped_fraction)) then
         call m%grid%copies_of_nodes(m%fields%mass_matrix%copies)
         m%fields%mass_matrix%lumped_apart = m%fields%mass_matrix%lumped_fraction
      end if
      call new_mass_solver(m%mass%by, m%mass%order, m%grid, m%constraints, m%solver, failure, m%fields%mass_matrix%ghosts)
      if (failure%failed()) return
      call find_active_nodes(m%grid, m%blocks, m%fields, failure)
   end subroutine rebuild_on_grid

   !> Whether elements are around tips or fronts that grow in motion, where the mass matrix is another one there: within some cells
   !> of the points that are bonded ahead of these, or fail behind.
   pure function near_growing_tips(m) result(is_near)
      type(problem_t), intent(in) :: m
      logical, allocatable :: is_near(:)
      logical :: is_met(m%grid%n_points)
      integer :: e, k, ring
      allocate (is_near(merge(m%grid%n_elements, 0, m%mass%around_tips)), source=.false.)
      if (.not. m%mass%around_tips) return
      is_met = .false.
      do k = 1, m%interfaces%n
         associate (point => m%interfaces%list(k))
            if (point%law == bonded .or. point%law == releasing) is_met(pack(point%jump%node, point%jump%node > 0)) = .true.
         end associate
      end do
      do ring = 1, cells_around_tips
         is_near = [(any(is_met(m%grid%support_of(e))), e=1, m%grid%n_elements)]
         do e = 1, m%grid%n_elements
            if (is_near(e)) is_met(m%grid%support_of(e)) = .true.
         end do
         call m%grid%dofs%mark_masters(is_met)
         call m%grid%dofs%mark_hanging(is_met)
      end do
   end function near_growing_tips

   !> Whether points have material; all may have it where that moves through the cells.
   pure function nodes_with_material(m) result(has)
      type(problem_t), intent(in) :: m
      logical :: has(m%grid%n_points)
      integer :: i
      has = .not. m%particles%total_frame
      do i = 1, m%particles%n
         has(m%grid%support_of(m%particles%cell(i))) = .true.
      end do
      call m%grid%dofs%mark_masters(has)
   end function nodes_with_material

   !> Attach interface points to the nodes of cells with material, where that moves through the cells: other nodes have no motion.
   subroutine renew_interfaces(m)
      type(problem_t), intent(inout) :: m
      real(dp) :: before
      if (m%particles%total_frame .or. m%interfaces%n == 0 .and. .not. any(m%loads%absorbs > 0)) return
      before = interface_energy(m%interfaces)
      call rebuild_interfaces(m%interfaces, m%matter_t, m%constraints)
      if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss - (interface_energy(m%interfaces) - before)
      call forget_faces(m%interface_step)
      if (.not. allocated(m%fields%mass_matrix%lumped_fraction)) return
      call lump_at(m%fields%mass_matrix, m%grid, [nodes_lumped_in_steps(m), lumped_by_dashpots(m)])
      call find_coupled_region(m%grid, m%fields%mass_matrix)
   end subroutine renew_interfaces

   !> Nodes with lumped masses in explicit steps as dashpots act on them.
   function lumped_by_dashpots(m) result(nodes)
      type(problem_t), intent(inout) :: m
      integer, allocatable :: nodes(:)
      allocate (nodes(0))
      if (m%interfaces%are_bounded) nodes = nodes_of_dashpots(m%loads, m%grid, m%particles)
   end function lumped_by_dashpots

   !> Nodes with lumped masses in explicit steps: those moved by interface points at the end of steps, and those of nearly empty
   !> cells, for which other masses would be nearly 0.
   pure function nodes_lumped_in_steps(m) result(nodes)
      type(problem_t), intent(in) :: m
      integer, allocatable :: nodes(:)
      logical, allocatable :: is_thin(:)
      integer :: k
      allocate (is_thin(m%grid%n_elements), nodes(0))
      if (.not. m%interfaces%are_bounded) return
      is_thin = are_nearly_empty(m%matter_t)
      nodes = [(m%grid%element_nodes(:, k), k=1, m%grid%n_elements)]
      nodes = pack(nodes, [(spread(is_thin(k), 1, corners), k=1, m%grid%n_elements)])
      if (m%interfaces%are_lumped) nodes = [nodes, nodes_of_jumps(m%interfaces%list(:m%interfaces%n)%jump)]
      nodes = pack(nodes, nodes > 0)
   end function nodes_lumped_in_steps

   !> Exit code of cells that do not suit the model: before the first step the input is wrong.
   pure integer function code_of(m)
      type(problem_t), intent(in) :: m
      code_of = merge(exit_input, exit_computation, m%state%steps == 0)
   end function code_of

   !> Fail for a piece of a cell too small to move by itself.
   subroutine report_thin_piece(m, failure)
      type(problem_t), intent(in) :: m
      type(failure_t), intent(inout) :: failure
      associate (x => m%grid%element_lower(:, m%interfaces%alone) + m%grid%leaf_size(m%interfaces%alone)/2)
         call failure%report(code_of(m), 'the material around '//point_text(x)//' m is less than '// &
                             to_text(enough_alone)//' of a quadratic cell wide, too narrow for dynamics. Use smaller cells, '// &
                             '&grid order = 1, or time = ''static''')
      end associate
   end subroutine report_thin_piece

   !> Fail where the layer of the cells, in series with cohesion, is too soft for faces to part steadily.
   pure subroutine check_layers(m, failure)
      type(problem_t), intent(in) :: m
      type(failure_t), intent(inout) :: failure
      integer :: k
      do k = 1, m%interfaces%n
         associate (point => m%interfaces%list(k))
            if (point%law /= cohesive) cycle
            if (.not. m%interfaces%cohesion(point%cohesion)%turns_back(point%stiffness/(m%interfaces%thickness%at(point%place) &
                                                                                      *point%length))) cycle
            call failure%report(code_of(m), 'the cells around ('//to_text(point%place(1))//', '//to_text(point%place(2))// &
                                ') m, '//to_text(point%cell)//' m wide, are too large for the cohesive zone: faces would snap '// &
                                'apart. Use smaller cells, or a lower &cohesive strength')
            return
         end associate
      end do
   end subroutine check_layers

   !> Kinetic energy [J]: of the particles, sum of m v**2/2; if nodes keep their velocities between implicit steps, v.M v/2, which
   !> such steps conserve.
   real(dp) function kinetic_energy(m) result(energy)
      type(problem_t), intent(in) :: m
      if (.not. allocated(m%state%velocity)) then
         energy = energy_of_particles(m%particles) + energy_of_rates(m%interfaces)
         return
      end if
      energy = sum(m%state%velocity*by_mass(m%grid, m%fields%mass_matrix, m%state%velocity))/2
   end function kinetic_energy

   !> Stored energy of the material and of bonded and cohesive points [J].
   real(dp) function stored_energy(m)
      type(problem_t), intent(in) :: m
      stored_energy = strain_energy(m%particles, m%materials) + interface_energy(m%interfaces)
   end function stored_energy

   !> Energy that plastic flow and viscosity have taken [J].
   real(dp) function dissipated_energy(m)
      type(problem_t), intent(in) :: m
      dissipated_energy = dissipation(m%particles, m%materials, .true.) + dissipation(m%particles, m%materials, .false.)
   end function dissipated_energy

   !> Keep the present states of particles whose laws have a history: a step has ended.
   subroutine archive_history(m)
      type(problem_t), intent(inout) :: m
      integer :: i
      if (.not. any(m%materials%has_history)) return
      do i = 1, m%particles%n
         associate (material => m%materials(m%particles%material(i)))
            call update_particle_state(material, material%time_increment, m%particles, i)
         end associate
      end do
      m%materials%time_increment = 0
   end subroutine archive_history

   !> Update the particles before output: those of cells with operators may be behind.
   subroutine update_particles(m)
      type(problem_t), intent(inout) :: m
      call give_to_particles(m%cache%operators, m%matter_t, m%fields)
   end subroutine update_particles

   !> Map the particles to the grid at the start of a step, where the last step has not done so.
   subroutine map_to_grid(m, failure)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout), optional :: failure !! of a domain that has left the grid
      type(pass_report_t) :: report
      type(pass_t) :: map
      type(failure_t) :: lost
      m%cache%weighed = .false.
      m%cache%velocity_after = -1
      m%cache%acceleration_after = -1
      map = m%scheme%map_at_start
      map%map_force = map%map_force .or. m%particles%total_frame      ! operators add to the present force
      if (m%has_domains()) call locate_corners(m%corners, m%matter_t, m%fields, lost)
      if (lost%failed()) then
         if (present(failure)) call pass_on(m, m%state%steps, lost, failure)
         return
      end if
      call do_pass(m, map, 0.0_dp, report, lost)
      call rebuild_operators(m)
      m%cache%mapped = .true.
   end subroutine map_to_grid

   !> Do a pass over the particles. Fails where a corner of a domain leaves the grid.
   subroutine do_pass(m, pass, dt, report, failure)
      type(problem_t), intent(inout) :: m
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      type(pass_report_t), intent(inout) :: report
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: lost
      if (.not. m%has_domains()) then
         call pass_over_all(pass, dt, m%matter_t, m%fields, report)
         return
      end if
      call move_corners(pass, dt, m%matter_t, m%corners, m%fields, report)
      if (report%jumped) return
      if (pass%strain_fraction > 0) call locate_corners(m%corners, m%matter_t, m%fields, lost)
      call pass_on(m, m%state%steps + 1, lost, failure)
      if (lost%failed()) return
      call map_corners(pass, m%matter_t, m%corners, m%fields)
   end subroutine do_pass

   !> Assemble the nodal sums from the mapped values of the particles.
   subroutine assemble_sums(m, mass, momentum, force)
      type(problem_t), intent(inout) :: m
      logical, intent(in) :: mass, momentum, force
      if (m%has_domains()) then
         call assemble_corners(m%corners, m%grid, m%fields, mass, momentum, force)
      else
         call assemble_all(m%cache%operators, m%blocks, m%fields, mass, momentum, force)
         call finish_sums(m%grid, m%fields, mass, momentum)
      end if
      if (momentum .and. m%interfaces%n > 0) call add_interface_momentum(m%interfaces, m%fields%momentum)
   end subroutine assemble_sums

   !> Find the cells that are passed without their particles, and their operators, from particles and contributions that fit each
   !> other.
   subroutine rebuild_operators(m)
      type(problem_t), intent(inout) :: m
      type(element_operators_t) :: none
      logical, allocatable :: is_loaded(:)
      integer :: k
      if (m%cache%operators%is_active) m%cache%tiling = tiling_t()
      m%cache%operators = none
      if (.not. m%is_explicit .or. m%audit .or. .not. m%particles%total_frame .or. m%particles%thickness%is_ring) return
      allocate (is_loaded(m%grid%n_elements), source=.false.)
      do k = 1, size(m%loads)
         is_loaded(m%particles%cell(m%loads(k)%particle)) = .true.
      end do
      call find_operators(m%matter_t, is_loaded, m%fields, m%cache%operators)
      if (m%cache%operators%is_active) m%cache%tiling = tiling_t()
   end subroutine rebuild_operators

   !> Bring the nodal masses and the mass matrix to the present positions of the particles, for extrapolations between steps.
   subroutine refresh_grid(m)
      type(problem_t), intent(inout) :: m
      if (.not. m%cache%mapped) call map_to_grid(m)
      call assemble_sums(m, mass=.not. is_weighed(m), momentum=.true., force=.false.)
      m%cache%weighed = .true.
   end subroutine refresh_grid

   !> Whether the nodes have the masses of the next step.
   pure logical function is_weighed(m)
      type(problem_t), intent(in) :: m
      is_weighed = m%cache%mapped .and. m%cache%weighed .and. m%particles%total_frame
   end function is_weighed

   !> Whether velocities solved for the momentum at the end of a step are those at the start of the next: if they depend on nothing
   !> else, and only the velocities of particles change the momentum. Not worthwhile for lumped masses.
   pure logical function keeps_velocity(m)
      type(problem_t), intent(in) :: m
      keeps_velocity = m%scheme%remaps .and. is_weighed(m) .and. m%solver%by /= by_lumped .and. .not. m%solver%iterates() &
                       .and. .not. m%constraints%move() .and. m%body_contact%n == 0 .and. .not. m%has_domains()
   end function keeps_velocity

   !> Sort the particles, after some have moved to other cells or their number has changed.
   subroutine sort_anew(m, failure)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      m%cache%mapped = .false.
      call sort_particles(m, failure)
      if (.not. (failure%failed() .or. m%cache%is_provisional)) call find_active_nodes(m%grid, m%blocks, m%fields, failure)
   end subroutine sort_anew

   !> Sort the particles into the cells of the grid, with the loads that they carry. Fails where one has left the
   !> grid.
   subroutine sort_particles(m, failure, left)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: left(:)   !! the blocks that some particle has left, if known
      type(failure_t) :: lost
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, lost, left)
      call pass_on(m, m%state%steps, lost, failure)
      if (failure%failed()) return
      call follow_sort(m%loads, m%cache%sorting%new_place)
      if (m%grid%is_quadratic() .and. .not. m%cache%is_provisional) call weigh_particles(m)
   end subroutine sort_particles

   !> Give the particles of quadratic cells their quadrature weights, and update loads by mass.
   subroutine weigh_particles(m)
      type(problem_t), intent(inout) :: m
      logical :: fills(m%particles%n)
      call weigh_points(m%matter_t, fills)
      call share_by_mass(m%loads, m%particles, m%grid, fills)
   end subroutine weigh_particles

   !> Fail as a part of a step did, if it did, and say when.
   subroutine pass_on(m, step, part, failure)
      type(problem_t), intent(in) :: m
      integer(long), intent(in) :: step
      type(failure_t), intent(in) :: part
      type(failure_t), intent(inout) :: failure
      if (part%failed()) call failure%report(part%code, when(step, m%state%time)//part%message)
   end subroutine pass_on
end module hampm_problem
