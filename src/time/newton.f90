!> Newton's iteration to equilibrium under given forces: K du = r, with the residual r and the tangent K (`hampm_stiffness`);
!> particles move and strain by the nodal displacements. For the linear law one step is exact up to rounding; others are shortened
!> until the work r . du of the residual decreases.
!>
!> A body that is free to turn (`hampm_rigid_motions`): loads balanced on the undeformed body have a moment on the deformed one. The
!> rigid-body constraint is moved by r/k until the moment is zero, with the force r on it and its stiffness k = t.K t, t being its
!> unit displacement with all else following. k is below 0 where the loads would turn the body around (docs/explanation/statics.md).
!>
!> Where cohesion softens and the tangent is not definite, the step uses the secant of the cohesion: its energy is never below the
!> true one and equal to it at the start of the step, so the true energy decreases and the result is stable.
!>
!> Source: Bathe, Finite Element Procedures (1996), section 8.4.
module hampm_newton
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_tensors, only: norm
   use hampm_cell_blocks, only: of_force
   use hampm_energy, only: determinant_of, most_crushed_particle
   use hampm_interface_points, only: stretch_interfaces, add_interface_forces, add_interface_resistance, have_friction, &
                                     hold_friction, interface_states, contact
   use hampm_failure, only: failure_t, exit_computation
   use hampm_problem, only: problem_t
   use hampm_outer_forces, only: outer_forces_t
   use hampm_nodal_fields, only: v_next
   use hampm_nodal_state, only: internal_force
   use hampm_particle_pass, only: pass_report_t, pass_over_all
   use hampm_pass, only: pass_t
   use hampm_rigid_motions, only: rigid_constraint_t, check_rigid_constraints, turn_with
   use hampm_stiffness, only: stiffness_t, stiffness_kind_t, usual_solver, factorise_stiffness, forces_of
   use hampm_text, only: to_text, three_digits, point_text
   use hampm_vectors, only: multiply
   implicit none
   private
   public :: newton_t, residual, largest_force, displace, work_of

   integer, parameter :: most_iterations = 25
   integer, parameter :: most_with_contact = 200 !! with interface points between faces that close, open and slide
   integer, parameter :: most_jumps = 40         !! iterations in which faces jump apart: beyond, they separate all along
   integer, parameter :: most_halvings = 10      !! of a displacement, to lessen the residual
   real(dp), parameter :: balanced = 1e-11_dp    !! the residual, over the largest force of a cell
   real(dp), parameter :: sums = 16*epsilon(1.0_dp) !! residue of the largest loads of a run where they cancel
   real(dp), parameter :: of_turn = 1e-3_dp      !! counted part of the forces that a turn would have as a strain: the
                                                 !! balance is then 45 times its rounding
   real(dp), parameter :: nearly_balanced = 0.1_dp !! part of the residual that may be left before friction follows the pressure
   real(dp), parameter :: hopeless = 1e6_dp      !! the residual, over the largest force at first
   real(dp), parameter :: lessened = 0.9_dp      !! part of the work r . du that may be left where bodies may buckle; elsewhere r
                                                 !! belongs to a convex potential, and none may be added

   !> Method and cost of equilibrium.
   type :: newton_t
      character(name_len) :: solver = usual_solver !! see `stiffness_kind_t`
      integer :: solutions = 0                   !! so far
      real(dp), allocatable :: residuals(:)      !! the residual in each iteration of the last balance, over the largest force
      real(dp) :: energy_left = 0                !! energy of the displacement that is left to equilibrium, as it was found last [J]
      real(dp), allocatable :: predicted(:, :)   !! prediction by the tangent at the start of a load step [m], (ndim, n_points); not
                                                 !! allocated where other faces touch at its end or have jumped apart
      type(stiffness_t) :: k                     !! that was factorised last
   contains
      procedure :: balance
      procedure :: solve_at_once
      procedure :: is_stable
      procedure :: release
   end type newton_t

contains

   !> Iterate under some forces with the pairs that touch now. Fails where it does not end.
   !>
   !> Friction limits are constant for some iterations: the forces then have a convex potential, and a displacement shortened until
   !> the potential decreases always helps. Then the limits follow the pressure.
   subroutine balance(self, m, outer, shift, rigid_constraints, moved, failure)
      class(newton_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(outer_forces_t), intent(in) :: outer  !! forces of loads and inertia
      real(dp), intent(in) :: shift(:, :)        !! displacement of fixed components in this load step [m], (ndim, n_nodes)
      type(rigid_constraint_t), intent(in) :: rigid_constraints(:)
      real(dp), intent(inout) :: moved(:, :)     !! displacement of nodes in this load step [m], (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: r(:, :), offset(:, :), du(:, :)
      logical :: has_offset, rubs, jumps, done, turned, touch_otherwise
      real(dp) :: largest, scale, at_first, when_held
      real(dp) :: last(size(rigid_constraints))  ! forces on these constraints before they were turned last [N]
      integer, allocatable :: predicted_states(:) ! states of interface points at which `predicted` was found
      integer :: iteration, most, n_jumps
      most = merge(most_with_contact, most_iterations, m%interfaces%n_contact + m%interfaces%n_cohesive > 0)
      rubs = have_friction(m%interfaces)
      at_first = 0
      scale = 0
      n_jumps = 0
      self%residuals = [real(dp) ::]
      when_held = huge(when_held)
      done = .false.
      last = huge(last)
      do iteration = 1, most
         if (rubs .and. iteration == 1) call hold_friction(m%interfaces)
         call internal_force(m, r)
         call less_offset(m, outer, shift, moved, r, offset, has_offset)
         call factorise_now(self, m, outer, rigid_constraints, failure)
         if (failure%failed()) exit
         jumps = m%interfaces%n_cohesive > 0 .and. .not. self%is_stable()
         if (jumps) then
            n_jumps = n_jumps + 1
            if (n_jumps > most_jumps) exit
            m%interfaces%tangent_floor = 1
            call factorise_now(self, m, outer, rigid_constraints, failure)
            m%interfaces%tangent_floor = 0
            if (failure%failed()) exit
         end if
         largest = maxval(abs(self%k%unknowns%gather(r)))
         scale = largest_force(m, r)
         if (rubs .and. iteration > 1 .and. largest <= max(nearly_balanced*when_held, balanced*scale)) then
            call hold_friction(m%interfaces)
            call internal_force(m, r)
            call less_offset(m, outer, shift, moved, r, offset, has_offset)
            call factorise_now(self, m, outer, rigid_constraints, failure)
            if (failure%failed()) exit
            largest = maxval(abs(self%k%unknowns%gather(r)))
            scale = largest_force(m, r)
            when_held = largest
         end if
         scale = max(scale, outer%inertia)
         if (iteration == 1) at_first = scale
         self%residuals = [self%residuals, largest/scale]
         done = .not. has_offset .and. largest <= balanced*scale
         if (done .and. any(m%materials%is_finite)) then
            call turn_until_balanced(self, m, outer, rigid_constraints, r, balanced*scale, last, moved, turned, failure)
            if (failure%failed()) exit
            if (turned) done = .false.
            if (turned) cycle
         end if
         if (done .or. largest > hopeless*at_first) exit
         call self%k%solve(m, r, du, failure)
         if (failure%failed()) exit
         self%solutions = self%solutions + 1
         du = du + offset
         if (iteration == 1 .and. .not. any(abs(moved) > 0)) then
            self%predicted = du
            allocate (predicted_states, source=interface_states(m%interfaces))
         end if
         if (jumps) then
            if (allocated(self%predicted)) deallocate (self%predicted)
            call jump(m, outer, moved, has_offset, du, failure)
         else if (all(m%materials%linear) .and. m%interfaces%n_cohesive == 0) then
            call displace(m, du)
            if (m%interfaces%n_contact > 0 .and. .not. has_offset) call go_back_to_least(m, outer, moved, work_of(m, r, du), du)
         else
            call displace_with_care(self, m, outer, moved, work_of(m, r, du - offset), has_offset, du, failure)
         end if
         if (failure%failed()) exit
         moved = moved + du
         if (m%constraints%only_push()) m%constraints%lift = m%constraints%lift + du(:, :m%grid%n_nodes)
      end do
      if (allocated(predicted_states) .and. m%interfaces%n_contact > 0) then
         associate (points => m%interfaces%list(:m%interfaces%n))
            touch_otherwise = any(interface_states(m%interfaces) /= predicted_states .and. points%law == contact)
         end associate
         if (touch_otherwise .and. allocated(self%predicted)) deallocate (self%predicted)
      end if
      if (m%interfaces%n > 0) m%interfaces%list%friction_limit = -1  ! friction limits follow the pressure again
      m%interfaces%tangent_floor = 0
      if (failure%failed()) return
      call check_rigid_constraints(m, rigid_constraints, r, sqrt(balanced)*scale, failure)
      if (done) then
         call self%k%solve(m, r, du, failure)
         self%energy_left = work_of(m, r, du)/2
      else if (.not. failure%failed()) then
         call failure%report(exit_computation, 'no equilibrium was found: after '//to_text(min(iteration, most))// &
                             ' iterations a node'//place_of(m, r)//' has a residual of '//three_digits(largest)//' N'// &
                             likely_cause(m))
      end if
   end subroutine balance

   !> Displacement of the nodes of a linear model, by one solution. The particles do not follow yet. Fails where it is not found.
   subroutine solve_at_once(self, m, outer, internal, shift, moved, failure)
      class(newton_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(outer_forces_t), intent(in) :: outer  !! forces of loads and inertia
      real(dp), intent(in), contiguous :: internal(:, :) !! internal forces, condensed [N], (ndim, n_points)
      real(dp), intent(in) :: shift(:, :)        !! displacement of fixed components [m], (ndim, n_nodes)
      real(dp), allocatable, intent(out) :: moved(:, :) !! [m], (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      type(rigid_constraint_t), allocatable :: none(:)
      real(dp), allocatable :: r(:, :), offset(:, :)
      logical :: has_offset
      allocate (none(0))
      call factorise_now(self, m, outer, none, failure)
      if (failure%failed()) return
      allocate (r, moved, mold=internal)
      moved = 0
      call multiply(size(r), 1.0_dp, internal, r)
      call less_offset(m, outer, shift, moved, r, offset, has_offset)
      call self%k%solve(m, r, moved, failure)
      self%solutions = self%solutions + 1
      if (has_offset) moved = moved + offset
   end subroutine solve_at_once

   !> Turn the pieces of material whose rigid-body constraints are loaded, and with them the prediction by the first tangent, where
   !> no stress may resist. A piece whose loads have a moment before deformation stays: no path of equilibria leads to its balance.
   !> Fails where loads would turn a piece around, and where its turning strains a cell by more than one.
   subroutine turn_until_balanced(self, m, outer, rigid_constraints, r, rounding, last, moved, turned, failure)
      class(newton_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(outer_forces_t), intent(in) :: outer  !! forces of loads and inertia
      type(rigid_constraint_t), intent(in) :: rigid_constraints(:)
      real(dp), intent(in) :: r(:, :)            !! the residual, without rigid-body constraints balanced [N], (ndim, n_points)
      real(dp), intent(in) :: rounding           !! of that [N]
      real(dp), intent(inout) :: last(:)         !! force on each rigid-body constraint before it was turned last [N]
      real(dp), intent(inout) :: moved(:, :)     !! displacement of nodes in this load step [m], (ndim, n_points)
      logical, intent(out) :: turned
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: turn(:, :), resisting(:, :), follow(:, :)
      real(dp) :: stiffness                      ! of the rigid-body constraint [N/m]
      integer :: k
      turned = .false.
      do k = 1, size(rigid_constraints)
         associate (force => r(rigid_constraints(k)%direction, rigid_constraints(k)%node))
            if (.not. rigid_constraints(k)%turns() .or. abs(force) <= rounding .or. abs(force) > last(k)/2) cycle
            call turn_with(m, rigid_constraints(k), turn)
            if (abs(work_of(m, outer%applied, turn)) > abs(force)/2) cycle
            call forces_of(m, turn, resisting, outer%factor)
            call add_interface_resistance(m%interfaces, turn, resisting)
            call self%k%solve(m, -resisting, follow, failure)
            if (failure%failed()) return
            turn = turn + follow
            stiffness = work_of(m, resisting, turn)
            if (.not. stiffness > 0 .and. abs(force) <= rounding/sqrt(balanced)) cycle ! see `check_rigid_constraints`
            if (.not. stiffness > 0) then
               call failure%report(exit_computation, 'a piece of body '//to_text(rigid_constraints(k)%body)// &
                                   ' has no equilibrium: its '// &
                                   'loads keep their direction and push it together more than they pull, which turns it '// &
                                   'around. Hold it by a &constraint, or use &method time = ''explicit''')
               return
            end if
            last(k) = abs(force)
            turn = force/stiffness*turn
            call check_increment(m, turn, failure)
            if (failure%failed()) return
            call displace(m, turn)
            moved = moved + turn
            if (allocated(self%predicted)) self%predicted = self%predicted + turn
            turned = .true.
         end associate
      end do
   end subroutine turn_until_balanced

   !> In words: where the residual is largest.
   function place_of(m, r) result(text)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: r(:, :)            !! the residual [N], (ndim, n_points)
      character(:), allocatable :: text
      integer :: worst(2)
      worst = maxloc(abs(r(:, :m%grid%n_nodes)))
      associate (x => m%grid%node_position(:, worst(2)))
         text = ' at '//point_text(x)//' m'
      end associate
   end function place_of

   !> In words: why there may be no equilibrium; '' where nothing is known.
   function likely_cause(m) result(text)
      type(problem_t), intent(in) :: m
      character(:), allocatable :: text
      text = ''
      if (m%interfaces%n_cohesive > 0) then
         text = ', as cohesive faces snap back: the material around them stores more energy than they dissipate'
      else if (have_friction(m%interfaces)) then
         text = '. Likely cause: friction and pressure between the faces of a crack increase each other '// &
                'there; use a lower &crack friction, or finer cells'
      else if (m%interfaces%n_contact > 0) then
         return
      else if (m%grid%cut_cells%are_there()) then
         text = '. Likely cause: a crack cuts off a piece of a cell with one or two particles there, which can move without '// &
                'strain, and loads push it; move the crack or the load, use smaller &grid cell, or &method time = ''explicit'''
      else if (allocated(m%grid%bodies)) then
         text = '. Likely cause: a body is much thinner there than a cell, which leaves some motions without stiffness; use '// &
                'smaller &grid cell'
      end if
   end function likely_cause

   !> Factorise the tangent of the present state.
   subroutine factorise_now(self, m, outer, rigid_constraints, failure)
      class(newton_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      type(outer_forces_t), intent(in) :: outer
      type(rigid_constraint_t), intent(in) :: rigid_constraints(:)
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      type(stiffness_kind_t) :: kind
      kind = stiffness_kind_t(.true., .false., self%solver, rigid_constraints, outer%mass_factor, outer%dashpot_factor)
      if (allocated(outer%factor)) kind%factor = outer%factor
      call factorise_stiffness(m, kind, self%k, unsolved)
      if (unsolved%failed()) call failure%report(unsolved%code, 'the stiffness cannot be factorised: '//unsolved%message// &
                                                 ', as where cells hold too few particles')
   end subroutine factorise_now

   !> Whether the equilibrium that was found is stable, see `is_stable` of `hampm_stiffness`.
   pure logical function is_stable(self)
      class(newton_t), intent(in) :: self
      is_stable = self%k%is_stable()
   end function is_stable

   !> Release the memory.
   subroutine release(self)
      class(newton_t), intent(inout) :: self
      call self%k%release()
   end subroutine release

   !> The residual at the nodes that have been displaced in this load step, condensed [N].
   subroutine residual(m, outer, moved, r)
      type(problem_t), intent(inout) :: m
      type(outer_forces_t), intent(in) :: outer  !! forces of loads and inertia
      real(dp), intent(in), contiguous :: moved(:, :) !! their displacement [m], (ndim, n_points)
      real(dp), allocatable, intent(out) :: r(:, :) !! (ndim, n_points)
      call internal_force(m, r)
      call outer%add_to(m, moved, r)
   end subroutine residual

   !> Add external to internal forces, less the force for the prescribed displacement `offset` of nodes.
   subroutine less_offset(m, outer, shift, moved, r, offset, has_offset)
      type(problem_t), intent(in) :: m
      type(outer_forces_t), intent(in) :: outer  !! forces of loads and inertia
      real(dp), intent(in) :: shift(:, :)        !! displacement of fixed components in this load step [m], (ndim, n_nodes)
      real(dp), intent(in), contiguous :: moved(:, :) !! displacement of nodes in it [m], (ndim, n_points)
      real(dp), intent(inout), contiguous :: r(:, :) !! condensed [N], (ndim, n_points)
      real(dp), allocatable, intent(out) :: offset(:, :) !! [m], (ndim, n_points)
      logical, intent(out) :: has_offset
      real(dp), allocatable :: resisting(:, :)
      call find_offset(m, shift, moved, offset, has_offset)
      if (.not. has_offset) call outer%add_to(m, moved, r)
      if (.not. has_offset) return
      call outer%add_to(m, moved + offset, r)
      call forces_of(m, offset, resisting, outer%factor)
      call add_interface_resistance(m%interfaces, offset, resisting)
      r = r - resisting
   end subroutine less_offset

   !> Work of condensed forces on a displacement [J].
   pure real(dp) function work_of(m, force, u)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: force(:, :), u(:, :) !! [N], [m], (ndim, n_points)
      work_of = sum(force(:, :m%grid%n_nodes)*u(:, :m%grid%n_nodes))
   end function work_of

   !> The largest force in play: of a cell on one of its corners, of faces that press on each other, or on a node [N].
   pure real(dp) function largest_force(m, r)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: r(:, :)            !! the residual [N]
      real(dp) :: area                           ! of the side of a cell that acts on one of its corners [m2]
      real(dp), allocatable :: by_faces(:, :)
      integer :: k
      area = (m%grid%forest%cell/2)**(ndim - 1)*m%interfaces%thickness%at(maxval(m%grid%node_position, dim=2))
      largest_force = max(maxval(abs(r)), tiny(1.0_dp), sums/balanced*sum([(norm(m%loads(k)%force) &
                      *abs(m%loads(k)%history%largest_factor()*m%loads(k)%history%scale), k=1, size(m%loads))])) ! they may cancel
      if (m%blocks%n > 0) largest_force = max(largest_force, &
                                              maxval(abs(m%fields%contribution(:, :, of_force:of_force + ndim - 1, 1:m%blocks%n))))
      if (m%interfaces%n > 0) then               ! tractions that press them together strain no cell
         allocate (by_faces(ndim, m%grid%n_points), source=0.0_dp)
         call add_interface_forces(m%interfaces, 1, by_faces)
         largest_force = max(largest_force, maxval(abs(by_faces)))
      end if
      do k = 1, size(m%materials)                ! a body that is free to take its eigenstrain has no forces in equilibrium
         if (m%materials(k)%has_eigenstrain) largest_force = max(largest_force, area*maxval(abs(m%materials(k)%stress_at_first())))
      end do
      if (m%particles%n == 0) return             ! and a body turned by its supports has their rounding
      largest_force = max(largest_force, of_turn*area*maxval([(m%materials(k)%plane_modulus(), k=1, size(m%materials))]) &
                                         *maxval(abs(m%particles%gradient(:m%particles%n, :, :))))
   end function largest_force

   !> Displacement that nodes must make under any forces: fixed ones with their constraints.
   subroutine find_offset(m, shift, moved, offset, has_offset)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: shift(:, :)        !! displacement of fixed components in this load step [m], (ndim, n_nodes)
      real(dp), intent(in) :: moved(:, :)        !! displacement of nodes in it [m], (ndim, n_points)
      real(dp), allocatable, intent(out) :: offset(:, :) !! (ndim, n_points)
      logical, intent(out) :: has_offset
      real(dp), parameter :: rounding = 1e-12_dp ! part of a displacement
      real(dp) :: turn(ndim, size(m%constraints%node)), slight
      integer :: k, d
      slight = 0
      if (allocated(m%constraints%turning)) slight = rounding*maxval(abs(moved))
      allocate (offset(ndim, m%grid%n_points), source=0.0_dp)
      has_offset = .false.
      associate (c => m%constraints)
         turn = c%turned(moved)
         do k = 1, size(c%node)
            do d = 1, ndim
               associate (i => c%node(k))
                  if (.not. c%fixed(d, i)) cycle
                  offset(d, i) = merge(-c%lift(d, i), shift(d, i) + turn(d, k) - moved(d, i), c%supported(d, i))
                  if (abs(offset(d, i)) <= slight) offset(d, i) = 0
                  has_offset = has_offset .or. abs(offset(d, i)) > 0
               end associate
            end do
         end do
      end associate
      if (has_offset) call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, offset)
   end subroutine find_offset

   !> Move and strain the particles by a displacement of the nodes, and map their forces.
   subroutine displace(m, du)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: du(:, :)           !! (ndim, n_points)
      type(pass_report_t) :: report
      m%fields%velocity(:, :, v_next) = du
      call pass_over_all(pass_t(strain_fraction=1.0_dp, strain_by=v_next, updates_state=.false., move=.true., map_force=.true.), &
                         1.0_dp, m%matter_t, m%fields, report)
      call stretch_interfaces(m%interfaces, du, 1.0_dp)
      m%fields%velocity(:, :, v_next) = 0
   end subroutine displace

   !> Move the particles by a displacement, made shorter until it lessens the residual. Fails where it strains a cell by more
   !> than one at once, or where no shorter one helps.
   subroutine displace_with_care(self, m, outer, moved, work, has_offset, du, failure)
      class(newton_t), intent(in) :: self
      type(problem_t), intent(inout) :: m
      type(outer_forces_t), intent(in) :: outer  !! forces of loads and inertia
      real(dp), intent(in) :: moved(:, :)        !! displacement of nodes before in this load step [m], (ndim, n_points)
      real(dp), intent(in) :: work               !! r . du before [J]
      logical, intent(in) :: has_offset          !! whether nodes had to move
      real(dp), intent(inout) :: du(:, :)        !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: r(:, :)
      integer :: halving, crushed
      real(dp) :: left                           ! part of the work that may be left
      logical :: good
      left = merge(lessened, 1.0_dp, any(m%materials%is_finite) .or. m%interfaces%n_cohesive > 0)
      call check_increment(m, du, failure)
      if (failure%failed()) return
      call displace(m, du)
      do halving = 0, most_halvings
         crushed = most_crushed_particle(m%particles, m%materials)
         good = crushed == 0
         if (.not. good) good = determinant_of(m%particles, crushed) > 0
         if (good) then
            call residual(m, outer, moved + du, r)
            good = has_offset .or. abs(work_of(m, r, du)) <= left*abs(work) &
                   .or. maxval(abs(self%k%unknowns%gather(r))) <= sqrt(balanced)*largest_force(m, r)
         end if
         if (good) return
         du = du/2
         call displace(m, -du)
      end do
      call failure%report(exit_computation, 'no equilibrium was found: every correction makes the forces '// &
                          'less balanced')
   end subroutine displace_with_care

   !> Move the particles by a displacement, and on as long as the forces push further: each time twice as far.
   subroutine jump(m, outer, moved, has_offset, du, failure)
      type(problem_t), intent(inout) :: m
      type(outer_forces_t), intent(in) :: outer  !! forces of loads and inertia
      real(dp), intent(in) :: moved(:, :)        !! displacement of nodes before in this load step [m], (ndim, n_points)
      logical, intent(in) :: has_offset          !! whether nodes had to move, which they do once
      real(dp), intent(inout) :: du(:, :)        !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      integer, parameter :: most = 8
      real(dp), allocatable :: r(:, :)
      integer :: turn
      call check_increment(m, du, failure)
      if (failure%failed()) return
      call displace(m, du)
      do turn = 1, most
         if (has_offset) return
         call residual(m, outer, moved + du, r)
         if (.not. work_of(m, r, du) > 0) return
         call check_increment(m, 2*du, failure)
         if (failure%failed()) return
         call displace(m, du)
         du = 2*du
      end do
   end subroutine jump

   !> Lengthen a shortened displacement to where forces do about no more work along it: faces that meet on the way are not in the
   !> tangent. The forces have a convex potential, which this always decreases. The place is found by the rule of false position,
   !> the value at an end that stays halved each time (Illinois).
   subroutine go_back_to_least(m, outer, moved, work, du)
      type(problem_t), intent(inout) :: m
      type(outer_forces_t), intent(in) :: outer  !! forces of loads and inertia
      real(dp), intent(in) :: moved(:, :)        !! displacement of nodes before in this load step [m], (ndim, n_points)
      real(dp), intent(in) :: work               !! r . du before [J]
      real(dp), intent(inout) :: du(:, :)        !! (ndim, n_points)
      real(dp), parameter :: beyond = 0.1_dp     ! part of the work that forces may do against the displacement at its end
      real(dp), parameter :: hardly = 0.1_dp     ! part of a displacement that is little of it
      real(dp), parameter :: least_floor = 1e-4_dp
      integer, parameter :: most_trials = 40
      real(dp), allocatable :: r(:, :)
      real(dp) :: part, left                     ! of the displacement, of the work there
      real(dp) :: short, long, of_short, of_long
      integer :: trial
      short = 0
      of_short = 1
      of_long = 0
      long = 1
      part = 1
      do trial = 1, most_trials
         call residual(m, outer, moved + part*du, r)
         left = work_of(m, r, du)/work
         if (left >= -beyond .and. (left <= 1 - beyond .or. part >= 1)) exit
         if (left < 0) then
            long = part
            of_long = left
            if (trial > 2) of_short = of_short/2
         else
            short = part
            of_short = left
            of_long = of_long/2
         end if
         left = short + (long - short)*of_short/(of_short - of_long)
         call displace(m, (left - part)*du)
         part = left
      end do
      du = part*du
      if (part < hardly) then                    ! something would move far that nothing but the faces holds
         m%interfaces%tangent_floor = min(max(10*m%interfaces%tangent_floor, least_floor), 1.0_dp)
      else if (m%interfaces%tangent_floor > 0) then
         m%interfaces%tangent_floor = m%interfaces%tangent_floor/10
         if (m%interfaces%tangent_floor < least_floor) m%interfaces%tangent_floor = 0
      end if
   end subroutine go_back_to_least

   !> Fail where a displacement would strain a cell so much at once that its tangent tells nothing of where that leads.
   subroutine check_increment(m, du, failure)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: du(:, :)           !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: most = 1            ! of a cell
      integer :: k, d
      do k = 1, m%blocks%n_occupied
         associate (e => m%blocks%occupied(k), at => m%grid%element_nodes(:, m%blocks%occupied(k)))
            do d = 1, ndim
               if (maxval(du(d, at)) - minval(du(d, at)) <= most*m%grid%element_size(e)) cycle
               call failure%report(exit_computation, 'no equilibrium was found: a correction would strain a cell by '// &
                                   'more than one')
               return
            end do
         end associate
      end do
   end subroutine check_increment
end module hampm_newton
