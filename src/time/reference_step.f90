!> One explicit step of the material point method as in docs/explanation/theory.md, without optimisation (`&method path =
!> 'reference'`): a pass is one loop over the particles, an equation one loop over the nodes. All other paths agree up to rounding
!> (`tests/unit/test_reference_step.f90`, `tests/program/test_reference_path.py`). From t^n to t^(n+1) = t^n + dt:
!>
!>   1. P2G     masses (9) and momenta of the particles to the nodes, and from these the nodal velocities v^n (8);
!>   2. strain  usf, and half of it usavg: H of the particles by v^n;
!>   3. P2G     internal forces (7), with loads at t^n and damping accelerations a (5); those of interface points at the step's end;
!>   4. G2P     velocities of the particles by a; those of the nodes are then v^(n+1) = v^n + a dt;
!>   5. strain  usl: by v^(n+1); musl, and half of it usavg: by v^(n+1) as it is mapped anew from the particles;
!>   6. G2P     displacements of the particles by v^(n+1).
!> A particle acts on the four (bilinear) or nine (quadratic) nodes of its support by shape functions N_i. Masses are lumped, crack
!> faces do not touch. Sums at a hanging node go to its masters, and its values are means of theirs.
module hampm_reference_step
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t
   use hampm_critical_step, only: largest_wave_speed
   use hampm_interface_points, only: add_interface_forces, stretch_interfaces, ease_faces
   use hampm_interface_step, only: hold_faces, commit_faces
   use hampm_integrator, only: integrator_t
   use hampm_loads, only: place_loads, add_loads, book_work, book_work_late
   use hampm_state_update, only: update_particle_state, hoop_resistance
   use hampm_problem, only: problem_t, sort_anew
   use hampm_step, only: report_jump
   use hampm_nodal_fields, only: at_end => v_next
   use hampm_node_list, only: node_list_t
   use hampm_tensors, only: identity
   implicit none
   private
   public :: reference_t, reference_step

   !> Explicit integration by the step that is there to be read, with all that a run is besides.
   type, extends(integrator_t) :: reference_t
   contains
      procedure :: advance
   end type reference_t

contains

   !> Advance by a step, and find the particles that have moved to other cells.
   subroutine advance(self, m, dt, failure)
      class(reference_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      call reference_step(m, dt, failure)
      m%cache%mapped = .false.
      m%cache%sorted = .not. m%particles%total_frame
      if (.not. m%cache%sorted) return
      call report_jump(m, failure)
      if (.not. failure%failed()) call sort_anew(m, failure)
   end subroutine advance

   !> Advance the particles by one step, and book the work of the loads and the damping. The cells of the particles are still to be
   !> found.
   subroutine reference_step(m, dt, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure  !! of interface points whose forces cannot be found
      real(dp), allocatable :: mass(:)
      real(dp) :: work
      real(dp), allocatable :: external(:, :), force(:, :), v(:, :), a(:, :), v_next(:, :), v_mapped(:, :)
      integer :: i
      allocate (external(ndim, m%grid%n_points), force(ndim, m%grid%n_points), v(ndim, m%grid%n_points), &
                a(ndim, m%grid%n_points), v_next(ndim, m%grid%n_points), v_mapped(ndim, m%grid%n_points))
      allocate (mass(m%grid%n_points))
      external = 0                               ! the loads act where the material is at t^n, with their factors there
      call place_loads(m%loads, m%grid, m%particles)
      call add_loads(m%loads, m%state%time, external)
      call map_mass(m, mass)
      call map_velocity(m, mass, v)
      if (m%scheme%name == 'usf') call strain(m, v, dt)
      if (m%scheme%name == 'usavg') call strain(m, v, dt/2)
      call map_force(m, force)
      call find_acceleration(m, mass, force + external, v, a)
      v_next = v + a*dt
      if (m%interfaces%n_at_end > 0) call add_forces_at_end()
      do i = 1, m%particles%n
         m%particles%velocity(i, :) = m%particles%velocity(i, :) + dt*at_particle(m, i, a)
      end do
      if (m%scheme%name == 'usl') call strain(m, v_next, dt)
      if (m%scheme%name == 'musl' .or. m%scheme%name == 'usavg') then
         call map_velocity(m, mass, v_mapped)
         call strain(m, v_mapped, merge(dt, dt/2, m%scheme%name == 'musl'))
         call open_faces(m, v_mapped, dt)
      else if (m%interfaces%n_at_end == 0 .or. m%scheme%name /= 'usf') then
         call open_faces(m, v_next, dt)
      end if
      do i = 1, m%particles%n
         m%particles%displacement(i, :) = m%particles%displacement(i, :) + dt*at_particle(m, i, v_next)
      end do
      if (m%scheme%remaps) then
         call book_work(m%loads, m%particles, m%state%time, dt, v_mapped, work)
      else
         call book_work_late(m%loads, m%particles, m%state%time, dt, m%state%last_dt, v, work)
      end if
      m%fields%velocity(:, :, at_end) = v_next   ! for what looks at nodes between rows
      m%energies%damping_loss = m%energies%damping_loss + dt*m%damping_rate*sum(spread(mass, 1, ndim)*v*v_next)
      m%state%last_dt = dt
      m%energies%external_work = m%energies%external_work + work
      m%state%time = m%state%time + dt
      m%state%steps = m%state%steps + 1
   contains
      !> Add the forces of interface points at the end of the step, and their effect.
      subroutine add_forces_at_end()
         type(node_list_t) :: nodes
         if (m%scheme%name == 'usf') call open_faces(m, v, dt)
         m%fields%mass_matrix%lumped = mass
         call hold_faces(m%interface_step, m%interfaces, m%matter_t, m%constraints%fixed, m%corners, dt, &
                         m%fields%mass_matrix, m%solver, v_next, a, force, failure)
         nodes = m%grid%dofs%every_node()
         call m%grid%dofs%distribute(nodes, ndim, a)
         call m%grid%dofs%distribute(nodes, ndim, v_next)
      end subroutine add_forces_at_end
   end subroutine reference_step

   !> Open interface points by a nodal velocity, and commit slip and damage.
   subroutine open_faces(m, v, dt)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: v(:, :)            !! [m/s], (ndim, n_points)
      real(dp), intent(in) :: dt                 !! [s]
      call stretch_interfaces(m%interfaces, v, dt)
      call commit_faces(m%interface_step, m%interfaces)
      call ease_faces(m%interfaces, dt*largest_wave_speed(m%materials, 'shear'))
   end subroutine open_faces

   !> P2G. The lumped masses m_i = sum m_p N_i (9) [kg].
   subroutine map_mass(m, mass)
      type(problem_t), intent(in) :: m
      real(dp), intent(out) :: mass(:)           !! (n_points)
      integer :: i
      mass = 0
      do i = 1, m%particles%n
         associate (nodes => m%nodes_of(i))
            mass(nodes) = mass(nodes) + m%particles%mass(i)*m%functions_of(i)
         end associate
      end do
      call condense(m, 1, mass)
   end subroutine map_mass

   !> P2G. The momenta p_i = sum m_p v_p N_i, and the velocities v_i = p_i/m_i that follow (8), (10); 0 where a component is fixed,
   !> and at nodes without mass [m/s].
   subroutine map_velocity(m, mass, v)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: mass(:)
      real(dp), intent(out) :: v(:, :)           !! (ndim, n_points)
      real(dp) :: n(m%grid%n_functions)
      integer :: nodes(m%grid%n_functions), i, c
      v = 0
      do i = 1, m%particles%n
         nodes = m%nodes_of(i)
         n = m%functions_of(i)
         do c = 1, size(nodes)
            v(:, nodes(c)) = v(:, nodes(c)) + m%particles%mass(i)*m%particles%velocity(i, :)*n(c)
         end do
      end do
      call condense(m, ndim, v)
      call divide_by_mass(m, mass, v)
   end subroutine map_velocity

   !> P2G. The internal forces f_i = -sum V_p T_p grad N_i (7) [N], T being the Kirchhoff stress, in the total frame the first
   !> Piola stress; in axisymmetric material radial ones by the hoop stress, -sum V_p P_33 N_i/R, too.
   subroutine map_force(m, force)
      type(problem_t), intent(in) :: m
      real(dp), intent(out) :: force(:, :)       !! (ndim, n_points)
      real(dp) :: gradient(m%grid%n_functions, ndim), stress(ndim, ndim), n(m%grid%n_functions)
      integer :: nodes(m%grid%n_functions), i, c
      force = 0
      associate (p => m%particles)
         do i = 1, p%n
            nodes = m%nodes_of(i)
            gradient = m%gradients_of(i)
            stress = m%materials(p%material(i))%mapped_stress(p%gradient_of(i), p%total_frame, p%history_of(i), p%hoop_of(i))
            do c = 1, size(nodes)
               force(:, nodes(c)) = force(:, nodes(c)) - p%volume(i)*matmul(stress, gradient(c, :))
            end do
            if (.not. p%thickness%is_ring) cycle
            n = m%functions_of(i)
            do c = 1, size(nodes)
               force(1, nodes(c)) = force(1, nodes(c)) - p%volume(i)*hoop_resistance(m%materials(p%material(i)), p, i)*n(c)
            end do
         end do
      end associate
   end subroutine map_force

   !> The accelerations a_i = f_i/m_i - alpha v_i (5), with the damping force -alpha m v; 0 where a component is fixed [m/s2].
   subroutine find_acceleration(m, mass, force, v, a)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: mass(:)
      real(dp), intent(in) :: force(:, :)        !! internal and of the loads [N], (ndim, n_points)
      real(dp), intent(in) :: v(:, :)            !! v^n [m/s], (ndim, n_points)
      real(dp), intent(out) :: a(:, :)           !! (ndim, n_points)
      a = force
      call condense(m, ndim, a)
      call add_interface_forces(m%interfaces, m%interfaces%n_at_end + 1, a)
      call divide_by_mass(m, mass, a)
      a = a - m%damping_rate*v
   end subroutine find_acceleration

   !> Divide nodal sums by the masses, with fixed components set to 0, and find the values of the hanging nodes.
   subroutine divide_by_mass(m, mass, x)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: mass(:)
      real(dp), intent(inout) :: x(:, :)         !! (ndim, n_points)
      type(node_list_t) :: nodes
      integer :: i
      do i = 1, m%grid%n_nodes
         if (mass(i) > 0) x(:, i) = x(:, i)/mass(i)
         where (m%constraints%fixed(:, i)) x(:, i) = 0
      end do
      nodes = m%grid%dofs%every_node()
      call m%grid%dofs%distribute(nodes, ndim, x)
   end subroutine divide_by_mass

   !> Strain the particles. H <- H + dt L (I + H), L being the gradient of a nodal velocity; in the total frame H <- H + dt L.
   subroutine strain(m, v, dt)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: v(:, :)            !! [m/s], (ndim, n_points)
      real(dp), intent(in) :: dt                 !! [s]
      real(dp) :: l(ndim, ndim)
      integer :: i
      associate (p => m%particles)
         do i = 1, p%n
            l = matmul(v(:, m%nodes_of(i)), m%gradients_of(i))
            if (.not. p%total_frame) l = matmul(l, identity + p%gradient_of(i))
            p%gradient(i, :, :) = p%gradient(i, :, :) + dt*l
            if (p%thickness%is_ring) p%widening(i) = p%widening(i) + dt*dot_product(v(1, m%nodes_of(i)), m%functions_of(i))
            call update_particle_state(m%materials(p%material(i)), dt, p, i)
         end do
      end associate
   end subroutine strain

   !> G2P. The value of a nodal field at a particle, sum N_i(x_p) x_i.
   pure function at_particle(m, i, x) result(value)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp), intent(in) :: x(:, :)            !! (ndim, n_points)
      real(dp) :: value(ndim), of_support(ndim, m%grid%n_functions), n(m%grid%n_functions)
      of_support = x(:, m%nodes_of(i))
      n = m%functions_of(i)
      value = matmul(of_support, n)
   end function at_particle

   !> Distribute the sums at the hanging nodes to their masters.
   subroutine condense(m, width, x)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: width               !! components
      real(dp), intent(inout) :: x(width, *)     !! (width, n_points)
      type(node_list_t) :: nodes
      nodes = m%grid%dofs%every_node()
      call m%grid%dofs%condense(nodes, width, x)
   end subroutine condense
end module hampm_reference_step
