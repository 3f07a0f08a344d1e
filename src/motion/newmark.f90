!> Implicit steps in time: Newmark's average acceleration, and the method of Hilber, Hughes and Taylor with alpha from -1/3 to 0. In
!> the total frame material points are points of quadrature, and the method is one of finite elements: the nodes keep displacement
!> u, velocity v and acceleration a from step to step, and the particles follow by what these gain. The step from t to t + dt solves
!>
!>    M a' + (1 + alpha) (C v' + K u' - f') - alpha (C v + K u - f) = 0,      C = rate M,
!>    u' = u + dt v + dt**2 ((1/2 - beta) a + beta a'),    v' = v + dt ((1 - gamma) a + gamma a'),
!>    gamma = 1/2 - alpha,    beta = (1 - alpha)**2/4,
!>
!> for the displacement du = u' - u: (K + c M) du = b, with a matrix that stays as long as mesh and dt do. With alpha = 0 the method
!> has no limit of dt, is of second order, and conserves v.M v/2 + u.K u/2 but for the work of the loads, which is then exactly the
!> mean of the forces at both ends times du. Each angular frequency w is too low by the part (w dt)**2/12.
!>
!> Nodes that are moved in a given way have it as their displacement; their velocity and acceleration are central differences of
!> it. (By the formulas above they would swing around the given motion, and ever more so.)
!>
!> Source: Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94; Hilber, Hughes & Taylor, Earthq. Eng. Struct. Dyn. 5 (1977) 283-292;
!> Hughes, The Finite Element Method (1987), chapter 9.
module hampm_newmark
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_archive, only: archive_t
   use hampm_constraints, only: hold
   use hampm_element_operators, only: pass_or_apply_everywhere
   use hampm_failure, only: failure_t
   use hampm_mass_product, only: find_concentrated_mass, multiply_by_mass
   use hampm_mass_solver, only: solve_aside
   use hampm_motion, only: motion_t, refresh_grid
   use hampm_nodal_fields, only: v_next
   use hampm_nodal_state, only: internal_force, external_force
   use hampm_particle_pass, only: pass_report_t, pass_over_all
   use hampm_pass, only: pass_t
   use hampm_stiffness, only: stiffness_t, stiffness_kind_t, factorise_stiffness, forces_of
   use hampm_face_springs, only: stretch_springs, kick_springs, add_spring_resistance
   use hampm_whereabouts, only: when
   implicit none
   private
   public :: newmark_t

   !> The method, and what the nodes keep beside their velocity, which is the motion's.
   type :: newmark_t
      real(dp) :: alpha = 0                      !! of Hilber, Hughes and Taylor [-]
      character(name_len) :: solver = 'umfpack'  !! 'umfpack', 'banded' or 'cg'
      integer :: factorisations = 0              !! so far
      real(dp) :: dt = 0                         !! of the step whose matrix was factorised last [s]
      integer, private :: layout = 0             !! of the blocks for which it was
      type(stiffness_t), private :: k            !! K + c M
      real(dp), allocatable, private :: mass(:)  !! what of M is on its diagonal beside the matrices of cells [kg], (n_points)
      real(dp), allocatable, private :: a(:, :)  !! acceleration at the present time [m/s2], (ndim, n_points)
      real(dp), allocatable, private :: f(:, :)  !! loads at the present time, condensed [N], (ndim, n_points)
      real(dp), allocatable, private :: way(:, :) !! of the fixed components up to the present time [m], (ndim, n_nodes)
   contains
      procedure :: start
      procedure :: step
      procedure :: keep
      procedure :: release
   end type newmark_t

   !> What fixed components of nodes do in a step; 0 for the others.
   type :: driven_t
      real(dp), allocatable :: du(:, :)          !! displacement in the step [m], (ndim, n_points)
      real(dp), allocatable :: v(:, :)           !! velocity at its end [m/s], (ndim, n_points)
      real(dp), allocatable :: a(:, :)           !! acceleration at its end [m/s2], (ndim, n_points)
      real(dp), allocatable :: way(:, :)         !! way up to its end [m], (ndim, n_nodes)
   end type driven_t

   !> Coefficients of a step.
   type :: coefficients_t
      real(dp) :: alpha, beta, gamma
      real(dp) :: a_du                           !! a' = a_du du - ... [1/s2]
      real(dp) :: v_du                           !! v' = v_du du + ... [1/s]
      real(dp) :: mass_factor                    !! c [1/s2]
   end type coefficients_t

contains

   !> Find velocity and acceleration of the nodes at the present time from the particles: M v = p, M a = f - C v. The step that
   !> comes is `dt` long. Fails where the equations cannot be solved.
   subroutine start(self, m, dt, failure)
      class(newmark_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: b(:, :), r(:, :), product(:, :), v(:, :), a(:, :)
      type(driven_t) :: first
      call refresh_grid(m)
      call find_concentrated_mass(m%grid, m%fields%mass_matrix, self%mass)
      self%way = m%constraints%way(m%time)
      call external_force(m, m%time, self%f)
      call begin_driven(m, m%time, dt, first)
      allocate (product, mold=self%f)
      call multiply_by_mass(m%grid, m%fields%mass_matrix, self%mass, first%v, product)
      allocate (b, source=m%fields%momentum - product)
      call solve_mass_equation(m, b, first%v, v, failure)
      call internal_force(m, r)
      call multiply_by_mass(m%grid, m%fields%mass_matrix, self%mass, m%damping_rate*v + first%a, product)
      b = r + self%f - product
      call solve_mass_equation(m, b, first%a, a, failure)
      call move_alloc(v, m%nodal_velocity)
      call move_alloc(a, self%a)
   end subroutine start

   !> x of M x = b at the nodes, with given values of the fixed components, distributed.
   subroutine solve_mass_equation(m, b, given, x, failure)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in), contiguous :: b(:, :) !! condensed, without what the given values take, (ndim, n_points)
      real(dp), intent(in) :: given(:, :)        !! (ndim, n_points)
      real(dp), allocatable, intent(out) :: x(:, :) !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      allocate (x(ndim, m%grid%n_points), source=0.0_dp)
      call solve_aside(m%solver, m%grid, m%fields%mass_matrix, b, x, unsolved)
      if (unsolved%failed()) call failure%report(unsolved%code, when(m%steps, m%time)//unsolved%message)
      call hold(m%constraints, x)
      x = x + given
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, x)
   end subroutine solve_mass_equation

   !> Advance by a step, and book what loads, constraints and damping do in it. Fails where the matrix cannot be factorised or the
   !> iteration with it does not end.
   subroutine step(self, m, dt, failure)
      class(newmark_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      type(coefficients_t) :: c
      type(driven_t) :: driven
      type(failure_t) :: unsolved
      real(dp), allocatable :: r(:, :), f(:, :), b(:, :), du(:, :), by_v(:, :), by_a(:, :), product(:, :), v(:, :), a(:, :)
      real(dp), allocatable :: resisting(:, :)   ! forces by which the nodes resist the displacement of those that are driven [N]
      c = coefficients_of(self%alpha, m%damping_rate, dt)
      call factorise(self, m, c, dt, failure)
      if (failure%failed()) return
      associate (v_0 => m%nodal_velocity, a_0 => self%a, all => m%fields%mass_matrix%all, rate => m%damping_rate)
         call internal_force(m, r)
         call external_force(m, m%time + dt, f)
         call find_driven(m, self%way, m%time + dt, dt, driven)
         ! v' = v_du du + by_v, a' = a_du du + by_a
         by_v = (1 - c%gamma/c%beta)*v_0 + dt*(1 - c%gamma/(2*c%beta))*a_0
         by_a = -v_0/(c%beta*dt) - (1/(2*c%beta) - 1)*a_0
         call give(m, driven%v, by_v)
         call give(m, driven%a, by_a)
         allocate (product, v, a, mold=r)
         call multiply_by_mass(m%grid, m%fields%mass_matrix, self%mass, by_a + rate*((1 + c%alpha)*by_v - c%alpha*v_0), product)
         b = (r + (1 + c%alpha)*f - c%alpha*self%f - product)/(1 + c%alpha)
         if (any(abs(driven%du) > 0)) then
            call forces_of(m, driven%du, resisting)
            call add_spring_resistance(m%springs, driven%du, resisting)
            b = b - resisting
         end if
         call self%k%solve(m, b, du, unsolved)
         if (unsolved%failed()) then
            call failure%report(unsolved%code, when(m%steps + 1, m%time + dt)//'K + c M: '//unsolved%message)
            return
         end if
         v = c%v_du*du + by_v
         a = c%a_du*du + by_a
         du = du + driven%du
         call m%grid%dofs%distribute(all, ndim, du)
         call move_particles(m, dt, du, v - v_0)
         call book(self, m, r, f, du, v)
         call move_alloc(v, m%nodal_velocity)
         call move_alloc(a, self%a)
         call move_alloc(f, self%f)
         call move_alloc(driven%way, self%way)
      end associate
   end subroutine step

   !> Coefficients of a step.
   pure type(coefficients_t) function coefficients_of(alpha, damping_rate, dt) result(c)
      real(dp), intent(in) :: alpha
      real(dp), intent(in) :: damping_rate       !! [1/s]
      real(dp), intent(in) :: dt                 !! [s]
      c%alpha = alpha
      c%gamma = 0.5_dp - alpha
      c%beta = (1 - alpha)**2/4
      c%a_du = 1/(c%beta*dt**2)
      c%v_du = c%gamma/(c%beta*dt)
      c%mass_factor = c%a_du/(1 + alpha) + damping_rate*c%v_du
   end function coefficients_of

   !> Factorise K + c M, if it is not there.
   subroutine factorise(self, m, c, dt, failure)
      class(newmark_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      type(coefficients_t), intent(in) :: c
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      type(stiffness_kind_t) :: kind
      if (self%layout == m%fields%layout .and. .not. abs(dt - self%dt) > 0) return
      call refresh_grid(m)
      call find_concentrated_mass(m%grid, m%fields%mass_matrix, self%mass)
      kind = stiffness_kind_t(is_tangent=.true., on_springs=.false., solver=self%solver, mass_factor=c%mass_factor)
      call factorise_stiffness(m, kind, [logical ::], self%k, unsolved)
      if (unsolved%failed()) call failure%report(unsolved%code, when(m%steps + 1, m%time + dt)// &
                                                 'K + c M cannot be factorised: '//unsolved%message)
      self%factorisations = self%factorisations + 1
      self%layout = m%fields%layout
      self%dt = dt
   end subroutine factorise

   !> What fixed components do in the step that ends at a time: central differences of the way that they are given.
   subroutine find_driven(m, way, time, dt, driven)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: way(:, :)          !! at the start of the step [m], (ndim, n_nodes)
      real(dp), intent(in) :: time, dt           !! [s]
      type(driven_t), intent(out) :: driven
      real(dp), allocatable :: next(:, :)
      allocate (driven%du(ndim, m%grid%n_points), driven%v(ndim, m%grid%n_points), driven%a(ndim, m%grid%n_points), source=0.0_dp)
      driven%way = way
      if (.not. m%constraints%move()) return
      driven%way = m%constraints%way(time)
      next = m%constraints%way(time + dt)
      associate (n => m%grid%n_nodes, all => m%fields%mass_matrix%all)
         driven%du(:, :n) = driven%way - way
         driven%v(:, :n) = (next - way)/(2*dt)
         driven%a(:, :n) = (next - 2*driven%way + way)/dt**2
         call m%grid%dofs%distribute(all, ndim, driven%du)
      end associate
   end subroutine find_driven

   !> The same at the start of the run: one-sided differences, such that the velocity gains dt (a + a')/2 in the first step as in
   !> all others.
   subroutine begin_driven(m, time, dt, first)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: time, dt           !! [s]
      type(driven_t), intent(out) :: first
      type(driven_t) :: next
      call find_driven(m, m%constraints%way(time), time + dt, dt, next)
      first = next
      first%v = next%du/dt
      call hold_not(m, first%v)
      first%a = 2*(next%v - first%v)/dt - next%a
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, first%v)
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, first%a)
   end subroutine begin_driven

   !> Set what is not fixed to 0.
   pure subroutine hold_not(m, x)
      type(motion_t), intent(in) :: m
      real(dp), intent(inout) :: x(:, :)         !! (ndim, n_points)
      where (.not. m%constraints%fixed) x(:, :m%grid%n_nodes) = 0
      x(:, m%grid%n_nodes + 1:) = 0
   end subroutine hold_not

   !> Give fixed components of a nodal field their values, and distribute it.
   subroutine give(m, given, x)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: given(:, :)        !! (ndim, n_points)
      real(dp), intent(inout) :: x(:, :)         !! (ndim, n_points)
      where (m%constraints%fixed) x(:, :m%grid%n_nodes) = given(:, :m%grid%n_nodes)
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, x)
   end subroutine give

   !> Move, strain and accelerate the particles by what the nodes gain, and map them; cells with operators without their particles.
   subroutine move_particles(m, dt, du, dv)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: du(:, :), dv(:, :) !! [m], [m/s], (ndim, n_points)
      type(pass_t), parameter :: follow = pass_t(kick=.true., strain_fraction=1.0_dp, strain_by=v_next, move=.true., &
                                                 map_momentum=.true., map_force=.true.)
      type(pass_report_t) :: report
      real(dp) :: unused
      m%fields%acceleration = dv/dt
      m%fields%velocity(:, :, v_next) = du/dt
      if (m%operators%is_active) then
         call pass_or_apply_everywhere(m%operators, follow, dt, m%materials, m%particles, m%blocks, m%fields)
      else
         call pass_over_all(follow, dt, m%materials, m%particles, m%blocks, m%fields, report)
      end if
      call stretch_springs(m%springs, du, 1.0_dp)
      call kick_springs(m%springs, m%fields%acceleration, dt, unused)
      m%operators%is_behind = m%operators%is_active
   end subroutine move_particles

   !> Book what a step has done: the work of the loads by the means of the forces at both ends, with that of the forces R by which
   !> nodes are driven, and what the damping takes. With v and v' the velocities at both ends of a step the kinetic energy gains
   !> (v + v')/2 . M (v' - v), the strain energy du . K (u + u')/2; at free nodes the sum is what loads and damping do there, and at
   !> driven ones, where du is not dt (v + v')/2, it is the work of R with the inertia on the way (v + v')/2 dt and the rest on du.
   subroutine book(self, m, r, f, du, v)
      class(newmark_t), intent(in) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: r(:, :)            !! internal forces at the start, condensed [N], (ndim, n_points)
      real(dp), intent(in) :: f(:, :)            !! loads at the end [N], (ndim, n_points)
      real(dp), intent(in) :: du(:, :)           !! [m], (ndim, n_points)
      real(dp), intent(in) :: v(:, :)            !! velocity at the end [m/s], (ndim, n_points)
      real(dp), allocatable :: drag(:, :), gain(:, :), rest(:, :), r_end(:, :)
      logical :: moves
      allocate (drag, gain, rest, mold=du)
      moves = m%constraints%move()
      associate (n => m%grid%n_nodes, v_0 => m%nodal_velocity, matrix => m%fields%mass_matrix)
         m%external_work = m%external_work + sum(du(:, :n)*(self%f(:, :n) + f(:, :n)))/2
         drag = 0
         if (m%damping_rate > 0) then
            call multiply_by_mass(m%grid, matrix, self%mass, m%damping_rate*(v_0 + v)/2, drag)
            m%damping_loss = m%damping_loss + sum(du(:, :n)*drag(:, :n))
         end if
         if (.not. moves) return
         call internal_force(m, r_end)
         call multiply_by_mass(m%grid, matrix, self%mass, v - v_0, gain)
         rest = drag - (r + r_end + self%f + f)/2
         m%external_work = m%external_work + sum((v_0(:, :n) + v(:, :n))/2*gain(:, :n) + du(:, :n)*rest(:, :n), &
                                                 mask=m%constraints%fixed)
      end associate
   end subroutine book

   !> Keep in an archive what the next step needs.
   subroutine keep(self, m, archive)
      class(newmark_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      class(archive_t), intent(inout) :: archive
      logical :: has_begun
      has_begun = allocated(self%a)
      call archive%keep('have_begun', has_begun)
      if (.not. has_begun) return
      if (archive%is_read) allocate (self%a(ndim, m%grid%n_points), self%f(ndim, m%grid%n_points), &
                                     self%way(ndim, m%grid%n_nodes), m%nodal_velocity(ndim, m%grid%n_points))
      call archive%keep('factorised_dt', self%dt)
      call archive%keep_reals('nodal_velocity', size(m%nodal_velocity), m%nodal_velocity)
      call archive%keep_reals('nodal_acceleration', size(self%a), self%a)
      call archive%keep_reals('nodal_load', size(self%f), self%f)
      call archive%keep_reals('nodal_way', size(self%way), self%way)
   end subroutine keep

   !> Give back the memory of the matrix.
   subroutine release(self)
      class(newmark_t), intent(inout) :: self
      call self%k%release()
      self%layout = 0
   end subroutine release
end module hampm_newmark
