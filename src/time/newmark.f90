!> Implicit steps: Newmark's average acceleration, and the method of Hilber, Hughes and Taylor with alpha from -1/3 to 0. The nodes
!> keep displacement u, velocity v and acceleration a; particles are quadrature points (total frame). A step from t to t + dt solves
!>
!>    M a' + (1 + alpha) (C v' - r' - f') - alpha (C v - r - f) = 0,      C = rate M,
!>    u' = u + dt v + dt**2 ((1/2 - beta) a + beta a'),    v' = v + dt ((1 - gamma) a + gamma a'),
!>    gamma = 1/2 - alpha,    beta = (1 - alpha)**2/4,
!>
!> with internal forces r and loads f: a balance (`hampm_balance`) in du = u' - u, with forces of inertia that are linear in du.
!> Theory, prescribed motion, contact, energy: docs/explanation/implicit.md. Sources: Newmark, J. Eng. Mech. Div. ASCE 85 (1959)
!> 67-94; Hilber, Hughes & Taylor, Earthq. Eng. Struct. Dyn. 5 (1977) 283-292; Hughes, The Finite Element Method (1987), chapter 9;
!> Kane, Repetto, Ortiz & Marsden, Comput. Methods Appl. Mech. Eng. 180 (1999) 1-26; Simo & Tarnow, J. Appl. Math. Phys. 43 (1992)
!> 757-792.
module hampm_newmark
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_nodal_release, only: work_of_release
   use hampm_balance, only: balance_t, part_t, start_t, is_linear
   use hampm_constraints, only: hold
   use hampm_failure, only: failure_t
   use hampm_instant, only: instant_t, save_instant, go_back_to
   use hampm_integrator, only: book_step
   use hampm_mass_product, only: find_concentrated_mass, multiply_by_mass
   use hampm_mass_solver, only: solve_aside
   use hampm_critical_step, only: largest_wave_speed
   use hampm_problem, only: problem_t, map_to_grid, refresh_grid, pass_on, stored_energy, dissipated_energy, &
                           kinetic_energy
   use hampm_nodal_fields, only: v_next
   use hampm_nodal_state, only: internal_force
   use hampm_outer_forces, only: loading_t, add_followers, find_loading
   use hampm_particle_pass, only: pass_report_t, pass_over_all
   use hampm_pass, only: pass_t
   use hampm_interface_points, only: stretch_interfaces, open_interfaces, kick_interfaces, interface_energy, ease_faces, &
                                     forces_of_penalty_contact
   use hampm_supports, only: lift_by
   use hampm_vectors, only: multiply, add_scaled, combine, correct, difference_over, product_with_sum
   implicit none
   private
   public :: newmark_t, move_particles, follow_nodes

   real(dp), parameter :: same = 1e-9_dp         !! relative difference of steps that count as equal

   !> Prescribed motion of fixed components of nodes in a step; 0 for the others.
   type :: prescribed_t
      real(dp), allocatable :: du(:, :)          !! displacement in the step [m], (ndim, n_points)
      real(dp), allocatable :: v(:, :)           !! velocity at its end [m/s], (ndim, n_points)
      real(dp), allocatable :: a(:, :)           !! acceleration at its end [m/s2], (ndim, n_points)
   end type prescribed_t

   !> State at the start of a step, to try it again.
   type :: previous_t
      type(instant_t) :: instant
      type(loading_t) :: now
      real(dp), allocatable :: r(:, :)           !! internal forces, with all bonded points, condensed [N], (ndim, n_points)
      real(dp) :: kinetic = 0
      logical :: is_carried = .false.
      logical :: is_now = .false.                !! whether it is the start of the present try; points may have failed since
   end type previous_t

   !> The method, and the data of the nodes beside their velocity, which is part of the motion.
   type, extends(balance_t) :: newmark_t
      real(dp) :: alpha = 0                      !! of Hilber, Hughes and Taylor [-]
      real(dp) :: dt = 0                         !! of the last step [s]
      type(loading_t) :: now                     !! loading of the nodes at the present time
      real(dp), allocatable :: r(:, :)           !! internal forces at the start of the step, without bonded points that
                                                 !! fail in it, condensed [N], (ndim, n_points)
      real(dp), private :: stored = 0            !! at its start, and dissipated before, with an energy balance [J]
      real(dp), private :: kinetic = 0           !! kinetic energy after the last step, with an energy balance [J]
      integer, private :: layout = 0             !! of the blocks for which there is a mass matrix
      logical, private :: is_carried = .false.   !! whether nodes have values of another mesh
      ! v' = v_du (du - given) + by_v, a' = a_du (du - given) + by_a in it
      real(dp), private :: v_du = 0, a_du = 0    !! [1/s], [1/s2]
      real(dp), allocatable, private :: by_v(:, :), by_a(:, :) !! (ndim, n_points)
      type(prescribed_t), private :: prescribed
      logical, allocatable, private :: fixed(:, :) !! components at its start, (ndim, n_nodes)
      type(previous_t), private :: previous
   contains
      procedure :: advance
      procedure :: initialise
      procedure :: note_start
      procedure :: go_to_start
      procedure :: begin
      procedure :: attempt_increment
      procedure :: most_divisions
      procedure :: likely_cause
      procedure :: serialise
   end type newmark_t

contains

   !> Advance by a step. Fails where its equations cannot be solved.
   subroutine advance(self, m, dt, failure)
      class(newmark_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      if (.not. m%cache%mapped) call map_to_grid(m)
      call self%advance_to(m, m%state%time + dt, failure)
      if (.not. failure%failed()) call book_step(m, dt)
   end subroutine advance

   !> Find velocity and acceleration of the nodes at the present time, at the start M v = p of the particles, M a = f - C v. On
   !> another mesh nodes keep theirs, and particles follow them; the change of kinetic energy is booked. (With alpha below 0 M a
   !> alone does not balance the forces at the end of a step: an a found anew from them would excite the motions that the method
   !> damps.) The next step is `dt` long. Fails where the equations cannot be solved.
   subroutine initialise(self, m, dt, failure)
      class(newmark_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: b(:, :), r(:, :), product(:, :)
      type(prescribed_t) :: first
      real(dp) :: opened
      logical :: has_begun
      has_begun = allocated(m%state%velocity)
      call find_mass(self, m)
      call find_loading(m, m%state%time, self%now)
      if (allocated(self%now%factor)) call add_followers(m, self%now%factor, self%now%force)
      if (has_begun .and. m%constraints%only_push()) call lift_by(m, m%state%displacement)
      if (m%state%steps > 0) then
         call find_prescribed(m, m%constraints%prescribed_at(m%state%time - dt), m%state%time, dt, first)
      else
         call begin_prescribed(m, m%state%time, dt, first)
      end if
      if (has_begun) then
         call give(m, first%v, m%state%velocity)
         call give(m, first%a, m%state%acceleration)
         call follow_nodes(m, m%state%velocity)
         opened = interface_energy(m%interfaces)
         call open_interfaces(m%interfaces, m%state%displacement)
         if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss + opened - interface_energy(m%interfaces) + &
            self%kinetic &
                                         - kinetic_energy(m)
         self%is_carried = .true.
      else
         associate (mass => self%outer%mass, matrix => m%fields%mass_matrix)
            allocate (product, mold=self%now%force)
            call multiply_by_mass(m%grid, matrix, mass, first%v, product)
            allocate (b, source=m%fields%momentum - product)
            call solve_mass_equation(m, b, first%v, m%state%velocity, failure)
            if (.not. allocated(m%state%displacement)) allocate (m%state%displacement, source=0*m%state%velocity)
            call internal_force(m, r)
            call multiply_by_mass(m%grid, matrix, mass, m%damping_rate*m%state%velocity + first%a, product)
            b = r + self%now%force - product
            call m%absorbing%resist(m%state%velocity, b)
            call solve_mass_equation(m, b, first%a, m%state%acceleration, failure)
         end associate
      end if
      if (m%audit) self%kinetic = kinetic_energy(m)
   end subroutine initialise

   !> Internal forces at the start of a step; at free nodes carried over from another mesh the forces that keep their balance there:
   !> the imbalance on this mesh acts within this step.
   subroutine forces_at_start(self, m, r)
      class(newmark_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: r(:, :) !! condensed [N], (ndim, n_points)
      real(dp), allocatable :: inertia(:, :), of_faces(:, :)
      call internal_force(m, r)
      if (have_penalty_contact(m)) then
         allocate (of_faces, source=forces_of_penalty_contact(m%interfaces, m%grid%n_points))
         r = r - of_faces
      end if
      if (.not. self%is_carried) return
      if (.not. allocated(of_faces)) allocate (of_faces, source=0*r)
      if (self%layout /= m%fields%layout) call find_mass(self, m) ! in a run that is resumed
      allocate (inertia, mold=r)
      call multiply_by_mass(m%grid, m%fields%mass_matrix, self%outer%mass, &
                            m%state%acceleration + m%damping_rate*m%state%velocity, inertia)
      call m%absorbing%resist(-m%state%velocity, inertia)
      associate (n => m%grid%n_nodes)
         where (.not. m%constraints%fixed) r(:, :n) = inertia(:, :n) - self%now%force(:, :n) - of_faces(:, :n)
      end associate
   end subroutine forces_at_start

   !> Give the particles the velocity that nodes have where they are.
   subroutine follow_nodes(m, v)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: v(:, :)            !! (ndim, n_points)
      integer :: i
      do i = 1, m%particles%n
         m%particles%velocity(i, :) = matmul(v(:, m%nodes_of(i)), m%functions_of(i))
      end do
      m%cache%mapped = .false.
   end subroutine follow_nodes

   !> x of M x = b at the nodes, with given values of the fixed components, distributed.
   subroutine solve_mass_equation(m, b, given, x, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in), contiguous :: b(:, :) !! condensed, less the product with given values, (ndim, n_points)
      real(dp), intent(in) :: given(:, :)        !! (ndim, n_points)
      real(dp), allocatable, intent(out) :: x(:, :) !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      allocate (x(ndim, m%grid%n_points), source=0.0_dp)
      call solve_aside(m%solver, m%grid, m%fields%mass_matrix, b, x, unsolved)
      call pass_on(m, m%state%steps, unsolved, failure)
      call hold(m%constraints, x)
      x = x + given
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, x)
   end subroutine solve_mass_equation

   !> Find the mass matrix of the present mesh.
   subroutine find_mass(self, m)
      class(newmark_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      call refresh_grid(m)
      call find_concentrated_mass(m%grid, m%fields%mass_matrix, self%outer%mass)
      call m%absorbing%renew(m%loads, m%grid, m%particles, m%fields%mass_matrix, m%fields%layout)
      self%layout = m%fields%layout
   end subroutine find_mass

   !> Try to move on by a part of a step. Fails where its forces are not balanced.
   subroutine attempt_increment(self, m, part, start, needs_subincrements, failure)
      class(newmark_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(part_t), intent(in) :: part
      type(start_t), intent(in) :: start
      logical, intent(out) :: needs_subincrements
      type(failure_t), intent(inout) :: failure
      type(loading_t) :: loading
      real(dp), allocatable :: shift(:, :)
      needs_subincrements = .false.
      call self%begin(m, part%end, part%length, loading, failure)
      if (failure%failed()) return
      allocate (shift, mold=loading%shift)
      call difference_over(size(shift), loading%shift, self%now%shift, 1.0_dp, shift)
      if (is_linear(m)) then
         call self%newton%solve_at_once(m, self%outer, self%r, shift, self%moved, failure)
      else
         self%moved = 0*self%r
         call self%with_contact(m, part%length, shift, failure)
      end if
      if (.not. failure%failed()) call finish_step(self, m, self%moved, loading, .not. is_linear(m), failure)
   end subroutine attempt_increment

   !> How often a step that fails is divided into two; with more a step is far too long.
   pure integer function most_divisions(self, m)
      class(newmark_t), intent(in) :: self
      type(problem_t), intent(in) :: m
      most_divisions = merge(0, 8, is_linear(m))
   end function most_divisions

   !> In words: why parts of a step fail too.
   function likely_cause(self) result(text)
      class(newmark_t), intent(in) :: self
      character(:), allocatable :: text
      text = 'a load too large for the material, or a &method time_step too long for the motion'
   end function likely_cause

   !> Begin to try a step, at the present state: find the inertia in it, the loading at its end, and the part of loads and of forces
   !> at its start that stands beside the internal forces in its equations.
   subroutine begin(self, m, time, length, loading, failure)
      class(newmark_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! at its end [s]
      real(dp), intent(in) :: length             !! of it [s]
      type(loading_t), intent(out) :: loading
      type(failure_t), intent(inout) :: failure
      real(dp) :: beta, gamma, dt
      real(dp), allocatable :: a(:, :)           ! at the start, by all forces but those of penalty faces [m/s2]
      real(dp), allocatable :: inertia(:, :)     ! forces from outside with it [N]
      if (self%layout /= m%fields%layout) call find_mass(self, m)
      beta = (1 - self%alpha)**2/4
      gamma = 0.5_dp - self%alpha
      if (abs(length - self%dt) > same*length) self%dt = length ! else the matrix serves on
      dt = self%dt
      self%a_du = 1/(beta*dt**2)
      self%v_du = gamma/(beta*dt)
      if (m%audit) self%stored = stored_energy(m) + dissipated_energy(m) + m%interfaces%loss
      call ease_faces(m%interfaces, dt*largest_wave_speed(m%materials, 'shear'))
      a = m%state%acceleration
      call subtract_penalty_contact(m, a, 1.0_dp, failure)
      if (.not. self%previous%is_now) call forces_at_start(self, m, self%previous%r)
      m%interfaces%weight = 1/(2*beta*(1 + self%alpha))
      call internal_force(m, self%r)
      call find_loading(m, time, loading)
      call find_prescribed(m, self%now%shift, time, dt, self%prescribed)
      associate (v => m%state%velocity, alpha => self%alpha, rate => m%damping_rate, outer => self%outer)
         if (allocated(self%by_v)) deallocate (self%by_v, self%by_a, outer%rest, outer%given, outer%applied)
         allocate (self%by_v, self%by_a, outer%rest, outer%given, outer%applied, mold=v)
         call combine(size(v), 1 - gamma/beta, v, dt*(1 - gamma/(2*beta)), m%state%acceleration, self%by_v)
         call combine(size(v), -1/(beta*dt), v, 1 - 1/(2*beta), a, self%by_a)
         call give(m, self%prescribed%v, self%by_v, .false.)
         call give(m, self%prescribed%a, self%by_a, .false.)
         outer%mass_factor = self%a_du/(1 + alpha) + rate*self%v_du
         outer%given = 0
         call give(m, self%prescribed%du, outer%given, .false.)
         call combine(size(v), 1/(1 + alpha), self%by_a, rate, self%by_v, outer%rest)
         call add_scaled(size(v), -rate*alpha/(1 + alpha), v, outer%rest)
         if (m%absorbing%n > 0) then
            outer%dashpot_factor = self%v_du
            outer%slide = self%by_v - alpha/(1 + alpha)*v
         end if
         call combine(size(v), 1.0_dp, loading%force, -alpha/(1 + alpha), self%previous%r, outer%applied)
         call add_scaled(size(v), -alpha/(1 + alpha), self%now%force, outer%applied)
         if (allocated(loading%factor)) outer%factor = loading%factor
         if (m%audit .or. m%constraints%move()) self%fixed = m%constraints%fixed
         if (.not. is_linear(m)) then
            allocate (inertia, source=0*v)
            call outer%add_to(m, outer%given, inertia)
            outer%inertia = maxval(abs(inertia - outer%applied))
         end if
      end associate
   end subroutine begin

   !> Finish the step with the displacement found: the particles follow, and the work of loads, constraints and damping is booked.
   subroutine finish_step(self, m, du, loading, have_moved, failure)
      class(newmark_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in), contiguous :: du(:, :) !! [m], (ndim, n_points)
      type(loading_t), intent(inout) :: loading  !! at its end; it is taken
      logical, intent(in) :: have_moved          !! whether the particles have been moved and strained, and only lack their velocity
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: v(:, :), a(:, :)
      allocate (v, a, mold=self%by_v)
      call correct(size(v), self%v_du, du, self%outer%given, self%by_v, v)
      call correct(size(a), self%a_du, du, self%outer%given, self%by_a, a)
      if (m%constraints%only_push()) then
         call give(m, self%prescribed%v, v, .true.)
         call give(m, self%prescribed%a, a, .true.)
      end if
      call move_particles(m, self%dt, du, v, have_moved)
      if (allocated(loading%factor)) call add_followers(m, loading%factor, loading%force)
      call book(self, m, loading, du, v)
      m%interfaces%weight = 1
      call subtract_penalty_contact(m, a, 0.5_dp*self%a_du*self%dt**2 - 1, failure)
      call move_alloc(v, m%state%velocity)
      call move_alloc(a, m%state%acceleration)
      call move_alloc(loading%force, self%now%force)
      call move_alloc(loading%shift, self%now%shift)
      call add_scaled(size(du), 1.0_dp, du, m%state%displacement)
      self%previous%is_now = .false.
      self%is_carried = .false.
      if (m%audit) self%kinetic = kinetic_energy(m)
   end subroutine finish_step

   !> Take some times the acceleration by the forces of penalty faces from one of the nodes.
   subroutine subtract_penalty_contact(m, a, times, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(inout) :: a(:, :)         !! [m/s2], (ndim, n_points)
      real(dp), intent(in) :: times
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: by_faces(:, :)
      if (.not. have_penalty_contact(m)) return
      call solve_mass_equation(m, forces_of_penalty_contact(m%interfaces, m%grid%n_points), 0*a, by_faces, failure)
      a = a - times*by_faces
   end subroutine subtract_penalty_contact

   !> Whether any faces that may touch have a penalty.
   pure logical function have_penalty_contact(m) result(have)
      type(problem_t), intent(in) :: m
      have = m%interfaces%n_contact > 0
      if (have) have = any(m%interfaces%list(:m%interfaces%n)%is_penalty)
   end function have_penalty_contact

   !> Motion of fixed components in the step that ends at a time: central differences of the prescribed displacement.
   subroutine find_prescribed(m, shift, time, dt, prescribed)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: shift(:, :)        !! at the start of the step [m], (ndim, n_nodes)
      real(dp), intent(in) :: time, dt           !! [s]
      type(prescribed_t), intent(out) :: prescribed
      real(dp), allocatable :: last(:, :), next(:, :)
      allocate (prescribed%du(ndim, m%grid%n_points), prescribed%v(ndim, m%grid%n_points), prescribed%a(ndim, m%grid%n_points), &
                source=0.0_dp)
      if (.not. m%constraints%move()) return
      last = m%constraints%prescribed_at(time)
      next = m%constraints%prescribed_at(time + dt)
      associate (n => m%grid%n_nodes, all => m%fields%mass_matrix%all)
         prescribed%du(:, :n) = last - shift
         prescribed%v(:, :n) = (next - shift)/(2*dt)
         prescribed%a(:, :n) = (next - 2*last + shift)/dt**2
         call m%grid%dofs%distribute(all, ndim, prescribed%du)
      end associate
   end subroutine find_prescribed

   !> The same at the start of the run: one-sided differences, such that the velocity gains dt (a + a')/2 in the first step as in
   !> all others.
   subroutine begin_prescribed(m, time, dt, first)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: time, dt           !! [s]
      type(prescribed_t), intent(out) :: first
      type(prescribed_t) :: next
      call find_prescribed(m, m%constraints%prescribed_at(time), time + dt, dt, next)
      first = next
      first%v = next%du/dt
      where (.not. m%constraints%fixed) first%v(:, :m%grid%n_nodes) = 0
      first%a = 2*(next%v - first%v)/dt - next%a
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, first%v)
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, first%a)
   end subroutine begin_prescribed

   !> Set components of a nodal field that are held by constraints or supports, with their rotation, and distribute it.
   subroutine give(m, given, x, on_supports)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: given(:, :)        !! (ndim, n_points)
      real(dp), intent(inout), contiguous :: x(:, :) !! (ndim, n_points)
      logical, intent(in), optional :: on_supports !! which; without both are given
      real(dp) :: turn(ndim, size(m%constraints%node))
      logical :: is_given
      integer :: k, d
      associate (c => m%constraints)
         turn = c%turned(x)
         do k = 1, size(c%node)
            do d = 1, ndim
               is_given = c%fixed(d, c%node(k))
               if (present(on_supports)) is_given = is_given .and. (c%supported(d, c%node(k)) .eqv. on_supports)
               if (is_given) x(d, c%node(k)) = given(d, c%node(k)) + turn(d, k)
            end do
         end do
      end associate
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, x)
   end subroutine give

   !> Move, strain and accelerate the particles by the increments of the nodes, and map them.
   subroutine move_particles(m, dt, du, v, have_moved)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in), contiguous :: du(:, :) !! [m], (ndim, n_points)
      real(dp), intent(in), contiguous :: v(:, :) !! velocity at the end [m/s], (ndim, n_points)
      logical, intent(in) :: have_moved          !! whether they are only to be accelerated
      type(pass_t), parameter :: advance_to = pass_t(kick=.true., strain_fraction=1.0_dp, strain_by=v_next, move=.true., &
                                                     map_momentum=.true., momentum_later=.true., map_force=.true.)
      type(pass_t), parameter :: kick = pass_t(kick=.true., map_momentum=.true.)
      type(pass_report_t) :: report
      real(dp) :: unused
      call difference_over(size(v), v, m%state%velocity, dt, m%fields%acceleration)
      call multiply(size(du), 1/dt, du, m%fields%velocity(:, :, v_next))
      if (have_moved) then
         call pass_over_all(kick, dt, m%matter_t, m%fields, report)
      else
         call pass_over_all(advance_to, dt, m%matter_t, m%fields, report)
      end if
      call kick_interfaces(m%interfaces, m%fields%acceleration, dt, unused)
      if (have_moved) return
      call stretch_interfaces(m%interfaces, du, 1.0_dp)
   end subroutine move_particles

   !> Book a step: the work of the loads by the means of the forces at both ends, the work of the forces R on nodes of prescribed
   !> motion, and the damping. With v and v' the velocities at both ends the kinetic energy gains (v + v')/2 . M (v' - v), the
   !> strain energy of linear laws du . K (u + u')/2. At free nodes the sum is the work of loads and damping; at prescribed nodes,
   !> where du is not dt (v + v')/2, it is the work of R with the inertia on (v + v')/2 dt and of the rest on du. Where a node meets
   !> or leaves its support in the step it is the mean of R times the displacement of the support.
   !>
   !> The numerical loss is the dissipation of alpha (work of the mean forces at free nodes without gain of motion), the loss of
   !> nodes that meet supports or the other face, and work of the mean internal forces that is neither stored nor dissipated.
   subroutine book(self, m, loading, du, v)
      class(newmark_t), intent(in) :: self
      type(problem_t), intent(inout) :: m
      type(loading_t), intent(in) :: loading     !! at the end
      real(dp), intent(in), contiguous :: du(:, :) !! [m], (ndim, n_points)
      real(dp), intent(in) :: v(:, :)            !! velocity at the end [m/s], (ndim, n_points)
      real(dp), allocatable, dimension(:, :) :: drag, dashpots, momentum_change, work, r ! of damping; of R; mean of internal forces
      real(dp) :: taken                          ! by bonded points that have failed [J]
      integer :: n
      n = m%grid%n_nodes
      associate (v_0 => m%state%velocity, matrix => m%fields%mass_matrix, mean => (self%now%force + loading%force)/2, &
                 fixed => m%constraints%fixed)
         m%energies%external_work = m%energies%external_work + product_with_sum(ndim*n, du, self%now%force, loading%force)/2
         if (m%damping_rate > 0) then
            allocate (drag, mold=du)
            call multiply_by_mass(m%grid, matrix, self%outer%mass, m%damping_rate*(v_0 + v)/2, drag)
            m%energies%damping_loss = m%energies%damping_loss + sum(du(:, :n)*drag(:, :n))
         end if
         if (m%absorbing%n > 0) then
            allocate (dashpots, source=0*du)
            call m%absorbing%resist(-(v_0 + v)/2, dashpots)
            m%energies%absorbed_energy = m%energies%absorbed_energy + sum(du(:, :n)*dashpots(:, :n))
         end if
         taken = work_of_release(m%interfaces, du, du, 1.0_dp, is_implicit=.true.)
         m%energies%fracture_energy = m%energies%fracture_energy + taken
         if (.not. (m%audit .or. m%constraints%move())) return
         if (.not. allocated(drag)) allocate (drag, source=0*du)
         if (allocated(dashpots)) drag = drag + dashpots
         allocate (momentum_change, mold=du)
         call internal_force(m, r)
         r = (self%previous%r + r)/2
         call multiply_by_mass(m%grid, matrix, self%outer%mass, v - v_0, momentum_change)
         work = momentum_change(:, :n)/self%dt + drag(:, :n) - r(:, :n) - mean(:, :n)
         momentum_change(:, :n) = (v_0(:, :n) + v(:, :n))/2*momentum_change(:, :n) + du(:, :n)* &
                                  (drag(:, :n) - r(:, :n) - mean(:, :n))
         work = merge(momentum_change(:, :n), merge((loading%shift - self%now%shift)*work, 0.0_dp, fixed .or. self%fixed), &
                      fixed .and. self%fixed)
         m%energies%external_work = m%energies%external_work + sum(work)
         if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss - sum(momentum_change(:, :n) - work) &
            - sum(du(:, :n)*r(:, :n)) &
            - taken &
                                         - (stored_energy(m) + dissipated_energy(m) + m%interfaces%loss - self%stored)
      end associate
   end subroutine book

   !> Save the state at the start of a step.
   subroutine note_start(self, m)
      class(newmark_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      call save_instant(m, self%previous%instant)
      if (.not. m%cache%mapped) call map_to_grid(m)
      call forces_at_start(self, m, self%previous%r)
      self%previous%now = self%now
      self%previous%kinetic = self%kinetic
      self%previous%is_carried = self%is_carried
      self%previous%is_now = .true.
   end subroutine note_start

   !> Restore the saved state.
   subroutine go_to_start(self, m)
      class(newmark_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      call go_back_to(self%previous%instant, m)
      self%now = self%previous%now
      self%kinetic = self%previous%kinetic
      self%is_carried = self%previous%is_carried
      self%previous%is_now = .true.
   end subroutine go_to_start

   !> Archive the data of the next step.
   subroutine serialise(self, m, archive)
      class(newmark_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      class(archive_t), intent(inout) :: archive
      logical :: has_begun
      has_begun = allocated(m%state%acceleration)
      call archive%serialise('have_begun', has_begun)
      if (.not. has_begun) return
      if (archive%is_read) allocate (m%state%acceleration(ndim, m%grid%n_points), self%now%force(ndim, m%grid%n_points), &
                                     self%now%shift(ndim, m%grid%n_nodes), m%state%velocity(ndim, m%grid%n_points), &
                                     m%state%displacement(ndim, m%grid%n_points))
      call archive%serialise('last_dt', self%dt)
      call archive%serialise('kinetic', self%kinetic)
      call archive%serialise('is_carried', self%is_carried)
      call archive%archive_reals('nodal_displacement', size(m%state%displacement), m%state%displacement)
      call archive%archive_reals('nodal_velocity', size(m%state%velocity), m%state%velocity)
      call archive%archive_reals('nodal_acceleration', size(m%state%acceleration), m%state%acceleration)
      call archive%archive_reals('nodal_load', size(self%now%force), self%now%force)
      call archive%archive_reals('nodal_way', size(self%now%shift), self%now%shift)
   end subroutine serialise
end module hampm_newmark
