!> Nodal motion at an instant between steps, for measurements.
module hampm_nodal_state
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_failure, only: failure_t
   use hampm_loads, only: place_loads, add_loads
   use hampm_mass_solver, only: solve_aside
   use hampm_problem, only: problem_t, map_to_grid, refresh_grid, is_weighed, keeps_velocity, do_pass, assemble_sums, pass_on
   use hampm_particle_pass, only: pass_report_t
   use hampm_pass, only: pass_t
   use hampm_interface_points, only: add_interface_forces, bonded, is_half
   use hampm_interface_step, only: accelerate_by_faces
   use hampm_jumps, only: give_nodes
   use hampm_vectors, only: multiply, add_scaled
   implicit none
   private
   public :: nodal_state_t, find_nodal_state, find_lone_node, find_external_force, internal_force, external_force, unbalanced_force

   !> Nodal fields at one instant, by point: zero where there are no particles.
   type :: nodal_state_t
      real(dp), allocatable :: divergence(:, :)  !! (div stress)/rho: the acceleration by internal force and surface loads, without
                                                 !! damping and body loads; 0 for fixed components [m/s2], (ndim, n_points)
      real(dp) :: reaction(ndim) = 0             !! force of the constraints on the bodies, without the inertia that a mass matrix
                                                 !! that is not diagonal couples to held nodes [N]
      real(dp), allocatable :: reactions(:, :)   !! the same for each constraint [N], (ndim, constraints)
      real(dp) :: lone_part = 0                  !! largest part of all constraint and load forces on a constraint of one node [-]
      real(dp) :: lone_place(ndim) = 0           !! of that node [m]
   end type nodal_state_t

contains

   !> The nodal state of the present particles, by the mass matrix of the run:
   !>
   !>    M d = f_internal + f_surface,   reaction = -sum over fixed components of (f_internal + f_loads).
   !>
   !> Since M d is the weak form of rho d, d is the divergence of the stress over the density, in the equation of motion a + alpha v
   !> - b. The state of the run stays bitwise the same. Fails if the nodal equations cannot be solved.
   !>
   !> Where the next step solves for the acceleration by the same forces it takes it from here: forces are summed in the same order.
   !> Forces of interface points found at the end of steps are left out, and their present effect is added by its responses.
   subroutine find_nodal_state(m, state, failure, reactions_only)
      type(problem_t), intent(inout) :: m
      type(nodal_state_t), intent(inout) :: state
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: reactions_only
      real(dp), allocatable :: reactions(:, :)
      logical :: with_fields, is_of_step         ! whether the next step has the same acceleration
      with_fields = .true.
      if (present(reactions_only)) with_fields = .not. reactions_only
      if (.not. m%cache%mapped) call map_to_grid(m)
      if (with_fields .and. .not. is_weighed(m)) call refresh_grid(m)
      is_of_step = with_fields .and. keeps_velocity(m) .and. m%scheme%map_at_start%map_force .and. .not. any(m%loads%by_mass)
      call sum_stress(m)
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, m%fields%force)
      if (size(m%loads) + m%interfaces%n > 0) then
         call find_external_force(m, .false., merge(m%interfaces%n_at_end, 0, is_of_step) + 1)
         if (.not. is_of_step .and. m%interfaces%are_bounded) call add_effective_opening(m)
         call add_scaled(size(m%fields%force), 1.0_dp, m%fields%external, m%fields%force)
      end if
      if (is_of_step) then
         call solve_for_step(m, failure)
         state%divergence = m%fields%acceleration
         if (m%interfaces%n_at_end > 0) then
            call add_interface_forces(m%interfaces, 1, m%fields%force, m%interfaces%n_at_end)
            call accelerate_by_faces(m%interface_step, m%interfaces, m%matter_t, m%constraints%fixed, m%corners, &
                                     m%fields%mass_matrix, m%solver, state%divergence, failure)
            call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, state%divergence)
         end if
      else if (with_fields) then
         if (allocated(state%divergence)) deallocate (state%divergence)
         allocate (state%divergence, mold=m%fields%acceleration)
         call multiply(size(state%divergence), 1.0_dp, m%fields%acceleration, state%divergence)
         call solve(m, m%fields%force, state%divergence, failure)
      end if
      if (any(m%loads%by_mass)) call gather_loads(m, by_mass=.true.)
      allocate (reactions(ndim, m%constraints%number()), source=0.0_dp)
      call sum_on_held(m, reactions)
      state%reactions = -reactions
      state%reaction = sum(state%reactions, dim=2)
   end subroutine find_nodal_state

   !> Add the excess over openings at points under moving fronts, as in the last step (`hampm_interface_step`): fast nodes.
   subroutine add_effective_opening(m)
      type(problem_t), intent(inout) :: m
      real(dp) :: force(ndim)
      integer :: k
      do k = 1, m%interfaces%n_at_end
         associate (point => m%interfaces%list(k))
            if (point%plane == 0 .or. point%law /= bonded) cycle
            force = point%stiffness*(point%effective_opening - point%before)
            if (is_half(point)) force = dot_product(force, point%normal)*point%normal
            call give_nodes(point%jump, -force, m%fields%external)
         end associate
      end do
   end subroutine add_effective_opening

   !> Solve for the acceleration that the next step then has.
   subroutine solve_for_step(m, failure)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      call solve(m, m%fields%force, m%fields%acceleration, failure)
      m%cache%acceleration_after = m%state%steps
   end subroutine solve_for_step

   !> Nodal forces of the loads, and of interface points between faces, where the material is now, condensed.
   subroutine find_external_force(m, with_mass, first)
      type(problem_t), intent(inout) :: m
      logical, intent(in) :: with_mass           !! whether of the loads on all material too, else on surfaces only
      integer, intent(in) :: first               !! interface point
      integer :: k
      m%fields%external = 0
      call place_loads(m%loads, m%grid, m%particles)
      do k = 1, size(m%loads)
         if (with_mass .or. .not. m%loads(k)%by_mass) call add_loads(m%loads(k:k), m%state%time, m%fields%external)
      end do
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, m%fields%external)
      call add_interface_forces(m%interfaces, first, m%fields%external)
   end subroutine find_external_force

   !> Internal nodal forces of the present particles, condensed [N]. The state of the run stays bitwise the same.
   subroutine internal_force(m, force)
      type(problem_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: force(:, :)  !! (ndim, n_points)
      call gather_stress(m)
      allocate (force, mold=m%fields%force)
      call multiply(size(force), 1.0_dp, m%fields%force, force)
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, force)
   end subroutine internal_force

   !> Forces of all loads that keep their direction on the nodes at a time, where the particles are now, condensed [N].
   subroutine external_force(m, time, force)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! [s]
      real(dp), allocatable, intent(out) :: force(:, :)  !! (ndim, n_points)
      integer :: k
      allocate (force(ndim, m%grid%n_points), source=0.0_dp)
      call place_loads(m%loads, m%grid, m%particles)
      do k = 1, size(m%loads)
         if (.not. allocated(m%loads(k)%follows)) call add_loads(m%loads(k:k), time, force)
      end do
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, force)
   end subroutine external_force

   !> Residual at the nodes of the present particles: internal forces and loads, without contact forces of faces [N]. The state of
   !> the run stays bitwise the same.
   subroutine unbalanced_force(m, force, internal)
      type(problem_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: force(:, :), internal(:, :) !! all, and the internal ones alone; (ndim, n_points)
      call refresh_grid(m)
      call gather_stress(m)
      allocate (internal, source=m%fields%force)
      call gather_loads(m, by_mass=.false.)
      call gather_loads(m, by_mass=.true.)
      allocate (force, source=m%fields%force)
   end subroutine unbalanced_force

   !> Solve M x = b and distribute x to the hanging nodes. On entry `x` is a guess.
   subroutine solve(m, b, x, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in), contiguous :: b(:, :)       !! (ndim, n_points)
      real(dp), intent(inout), contiguous :: x(:, :)    !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      call solve_aside(m%solver, m%grid, m%fields%mass_matrix, b, x, unsolved)
      call pass_on(m, m%state%steps, unsolved, failure)
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, x)
   end subroutine solve

   !> Internal forces of the present particles, and of interface points between faces.
   subroutine gather_stress(m)
      type(problem_t), intent(inout) :: m
      call sum_stress(m)
      call add_interface_forces(m%interfaces, 1, m%fields%force)
   end subroutine gather_stress

   !> Internal forces of the present particles; schemes that strain first have mapped those of the last step.
   subroutine sum_stress(m)
      type(problem_t), intent(inout) :: m
      type(pass_report_t) :: report
      type(failure_t) :: none                    ! nothing moves here
      if (.not. m%scheme%map_at_start%map_force) call do_pass(m, pass_t(map_force=.true.), 0.0_dp, report, none)
      call assemble_sums(m, mass=.false., momentum=.false., force=.true.)
   end subroutine sum_stress

   !> Add to the nodal forces the loads on all material, or those on its surface.
   subroutine gather_loads(m, by_mass)
      type(problem_t), intent(inout) :: m
      logical, intent(in) :: by_mass
      integer :: k
      call place_loads(m%loads, m%grid, m%particles)
      do k = 1, size(m%loads)
         if (m%loads(k)%by_mass .eqv. by_mass) &
            call add_loads(m%loads(k:k), m%state%time, m%fields%force)
      end do
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, m%fields%force)
   end subroutine gather_loads

   !> Sum of the forces on the components of nodes with particles that each constraint fixes [N].
   pure subroutine sum_on_held(m, force)
      type(problem_t), intent(in) :: m
      real(dp), intent(inout) :: force(:, :)     !! (ndim, constraints)
      integer :: a, d
      if (size(force, 2) == 0) return            ! none on an axis
      do a = 1, size(m%constraints%node)
         associate (node => m%constraints%node(a))
            if (.not. m%fields%is_active(node)) cycle
            do d = 1, ndim
               associate (k => m%constraints%box(d, node))
                  if (k > 0 .and. m%constraints%holds(node, d)) force(d, k) = force(d, k) + m%fields%force(d, node)
               end associate
            end do
         end associate
      end do
   end subroutine sum_on_held

   !> Find the share of a single node in all forces on a constraint, as `find_nodal_state` has left them: in the loads, or in half
   !> of the forces of all held nodes if these move the bodies.
   pure subroutine find_lone_node(m, state)
      type(problem_t), intent(in) :: m
      type(nodal_state_t), intent(inout) :: state
      integer, dimension(size(state%reactions, 2)) :: nodes, last
      integer :: a, d, k
      real(dp) :: force(size(nodes)), all
      logical :: has
      if (size(nodes) == 0) return
      nodes = 0
      force = 0
      all = 0
      do a = 1, size(m%constraints%node)
         associate (node => m%constraints%node(a))
            if (.not. m%fields%is_active(node)) cycle
            all = all + norm(pack(m%fields%force(:, node), [(m%constraints%holds(node, d), d=1, ndim)]))/2
            do k = 1, size(nodes)
               has = any(m%constraints%box(:, node) == k)
               if (.not. has) cycle
               nodes(k) = nodes(k) + 1
               last(k) = node
               force(k) = norm(pack(m%fields%force(:, node), m%constraints%box(:, node) == k .and. &
                                     [(m%constraints%holds(node, d), d=1, ndim)]))
            end do
         end associate
      end do
      all = max(all, sum([(abs(m%loads(k)%history%factor(m%state%time))*norm(m%loads(k)%force), k=1, size(m%loads))]))
      do k = 1, size(nodes)
         if (nodes(k) /= 1 .or. .not. force(k) > state%lone_part*all) cycle
         state%lone_part = force(k)/all
         state%lone_place = m%grid%node_position(:, last(k))
      end do
   end subroutine find_lone_node
end module hampm_nodal_state
