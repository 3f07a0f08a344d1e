!> Static equilibrium: the displacement at which internal forces, loads and constraints are in balance (`hampm_balance`).
!>
!> With nonlinear laws a load step is divided where that fails, and where the state may not be on the path of equilibria from the
!> start of the step: where it is not stable, is far from the prediction of the tangent at the start, or has not stored the work of
!> the loads. Beyond a limit point (snap through) Newton's iteration may find an equilibrium that no path leads to. Without laws for
!> large rotations there are no limit points but those of the material, and no other path: no check is made.
!>
!> Source: Wriggers, Nonlinear Finite Element Methods (2008), chapter 5 (limit points).
module hampm_equilibrium
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_archive, only: archive_t
   use hampm_balance, only: balance_t, part_t, start_t, is_in_touch
   use hampm_interface_points, only: along_faces, relax_interfaces, have_friction, contact
   use hampm_failure, only: failure_t, exit_computation
   use hampm_integrator, only: book_step
   use hampm_problem, only: problem_t, map_to_grid, stored_energy, dissipated_energy, archive_history
   use hampm_newton, only: residual, displace, work_of
   use hampm_outer_forces, only: loading_t, find_loading, scale_loads, find_heat, add_followers
   use hampm_supports, only: lift_by, press_on_supports
   use hampm_text, only: three_digits
   implicit none
   private
   public :: equilibrium_t

   real(dp), parameter :: off_path = 0.02_dp     !! part of the work that may not be stored on a path of equilibria
   real(dp), parameter :: off_energy = 1e-3_dp   !! largest relative energy error of a part as faces or supports open or close
   real(dp), parameter :: off_tangent = 0.5_dp   !! largest deviation from the tangent at the start of a load step, relative

   !> How equilibrium is found, and whether it has been.
   type, extends(balance_t) :: equilibrium_t
      logical :: begun = .false.                 !! whether it has been found before
      type(loading_t), private :: first, last    !! in the load step
      real(dp), allocatable, private :: held(:, :) !! forces of the constraints as eigenstrains change [N], (ndim, n_nodes)
      real(dp), private :: kept = 0              !! energy stored and dissipated by the last one [J]
      real(dp), private :: at_first = 0          !! energy of eigenstrains in the first equilibrium that is not work of loads [J]
      logical :: forgets_mesh = .false.          !! whether the state is independent of the path: nothing has grown
   contains
      procedure :: advance
      procedure :: initialise
      procedure :: rescale
      procedure :: attempt_increment
      procedure :: accept_increment
      procedure :: most_divisions
      procedure :: likely_cause
      procedure :: serialise
   end type equilibrium_t

contains

   !> Advance by a load step. Fails where no equilibrium is found.
   subroutine advance(self, m, dt, failure)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! [s]
      type(failure_t), intent(inout) :: failure
      if (.not. m%cache%mapped) call map_to_grid(m)
      call find(self, m, m%state%time + dt, failure)
      if (.not. failure%failed()) call book_step(m, dt)
      call book_equilibrium(self, m)
   end subroutine advance

   !> Find equilibrium at the present time: at the start, or on another mesh from the state of the particles.
   subroutine initialise(self, m, dt, failure)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: dt                 !! not used in equilibrium [s]
      type(failure_t), intent(inout) :: failure
      if (.not. m%cache%mapped) call map_to_grid(m)
      if (allocated(self%free)) deallocate (self%free) ! the mesh may be another one
      if (self%begun .and. .not. (m%state%steps == 0 .and. self%forgets_mesh .and. hangs_on_path(m))) then
         call find_again(self, m, failure)
      else
         ! or the first state would hang on the meshes before, or on a try that has failed
         if (self%begun .or. any(abs(m%particles%displacement(:m%particles%n, :)) > 0)) call unload(self, m)
         call find(self, m, m%state%time, failure)
         if (any(m%materials%has_eigenstrain)) self%at_first = stored_energy(m) - m%energies%external_work
      end if
      call book_equilibrium(self, m)
   end subroutine initialise

   !> Scale all that drives the material and is not held, and go to the equilibrium with it, now or at another time.
   subroutine rescale(self, m, load_factor, failure, time)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: load_factor        !! relative to the model [-]
      type(failure_t), intent(inout) :: failure
      real(dp), intent(in), optional :: time     !! [s]
      real(dp) :: to
      to = m%state%time
      if (present(time)) to = time
      call find(self, m, to, failure, load_factor)
      self%forgets_mesh = .false.                ! tips advance from here on
      call book_equilibrium(self, m)
   end subroutine rescale

   !> Record the distance to equilibrium, as in `hampm_static_equilibrium`: the square root of the energy of the residual
   !> displacement over the strain energy. Book for the energy balance the work of the loads that is not stored: with nonlinear laws
   !> the error of the mean force of a load step.
   subroutine book_equilibrium(self, m)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp) :: stored
      stored = stored_energy(m)
      self%distance_to_equilibrium = -1          ! not known where nothing is strained but by rounding
      if (stored > self%newton%energy_left) self%distance_to_equilibrium = sqrt(max(self%newton%energy_left, 0.0_dp)/stored)
      self%kept = stored + dissipated_energy(m) + m%interfaces%loss
      if (m%audit) m%energies%numerical_loss = m%energies%external_work + self%at_first - self%kept - m%energies%fracture_energy
   end subroutine book_equilibrium

   !> Find equilibrium at a time, from that at the present time of the motion; the first time from material without loads. Fails
   !> where none, or no stable one, is found. With `load_factor` loads and prescribed motions are scaled to it on the way.
   subroutine find(self, m, time, failure, load_factor)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! [s]
      type(failure_t), intent(inout) :: failure
      real(dp), intent(in), optional :: load_factor !! relative to the model [-]
      real(dp) :: heat(2), force(2)              ! at both ends
      heat = 0
      force = 0
      if (self%begun) call find_heat(m, heat(1), force(1))
      call find_loading(m, m%state%time, self%first)
      if (any(m%materials%is_scaled)) call hold_first(self, m)
      if (present(load_factor)) call scale_loads(m, load_factor)
      call find_loading(m, time, self%last)
      if (.not. self%begun) then
         self%first%force = 0
         self%first%shift = 0
         if (allocated(self%first%factor)) self%first%factor = 0
         m%state%displacement = self%first%force
      else if (present(load_factor) .and. any(m%materials%is_scaled)) then
         call displace(m, 0*m%state%displacement) ! cells have the forces of another eigenstrain
      end if
      call self%advance_to(m, time, failure)
      if (allocated(self%held)) deallocate (self%held)
      self%begun = self%begun .or. .not. failure%failed()
      call find_heat(m, heat(2), force(2))
      m%energies%external_work = m%energies%external_work + sum(force)/2*(heat(2) - heat(1))
   end subroutine find

   !> Find the forces of the constraints before a load step in which eigenstrains change with the loads: none at first.
   subroutine hold_first(self, m)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      self%moved = 0*self%first%force
      self%outer%applied = self%first%force
      if (allocated(self%first%factor)) self%outer%factor = self%first%factor
      call find_reactions(self, m, self%held)
      if (.not. self%begun) self%held = 0
   end subroutine hold_first

   !> Try a part of a load step. Fails where no equilibrium is found or, where bodies may buckle, none on the path from its start.
   !> It is rough where the work of the loads on a straight path is not the stored energy: the path is bent as faces or supports
   !> open or close.
   subroutine attempt_increment(self, m, part, start, needs_subincrements, failure)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(part_t), intent(in) :: part
      type(start_t), intent(in) :: start
      logical, intent(out) :: needs_subincrements
      type(failure_t), intent(inout) :: failure
      real(dp) :: stored
      needs_subincrements = .false.
      if (part%from > 0 .and. allocated(self%held)) deallocate (self%held)
      call go_to(self, m, between(self%first, self%last, part%from), between(self%first, self%last, part%to), part%length, failure)
      if (failure%failed()) return
      if (any(m%materials%is_finite) .or. m%interfaces%n_cohesive > 0) &
         call check_stability(self, m, start, .not. part%from > 0 .and. &
                              any(m%materials%is_scaled .or. m%materials%has_eigenstrain .and. .not. self%begun), failure)
      if (failure%failed() .or. .not. tells_work(m)) return
      stored = stored_energy(m) + dissipated_energy(m)
      associate (work => m%energies%external_work - start%instant%energies%external_work)
         needs_subincrements = abs(work - stored + start%stored) > off_energy*max(stored, start%stored)
      end associate
   end subroutine attempt_increment

   !> The equilibrium that was tried is taken.
   subroutine accept_increment(self, m, part)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(part_t), intent(in) :: part
      m%state%displacement = m%state%displacement + self%moved
   end subroutine accept_increment

   !> How often a step that fails is divided into two.
   pure integer function most_divisions(self, m)
      class(equilibrium_t), intent(in) :: self
      type(problem_t), intent(in) :: m
      most_divisions = merge(0, 14, all(m%materials%linear) .and. m%interfaces%n_cohesive == 0)
   end function most_divisions

   !> In words: why parts of a step fail too.
   function likely_cause(self) result(text)
      class(equilibrium_t), intent(in) :: self
      character(:), allocatable :: text
      text = 'a limit point, beyond which the body buckles or snaps through, or a load too large for the material; '// &
             '&method time = ''implicit'' or ''explicit'' computes such a motion'
   end function likely_cause

   !> Find equilibrium again at the present time, on another mesh, from the displacement of its nodes on the last one or, where that
   !> fails and neither material nor friction depends on the history, from material without loads. The work of the loads changes by
   !> the change of stored and dissipated energy: they would have done it on the way; the full force on the displacement due to
   !> finer cells is twice that. A state that does not depend on the path is found from the start.
   subroutine find_again(self, m, failure)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: none
      type(loading_t) :: loading
      real(dp) :: work
      if (hangs_on_path(m) .or. .not. (self%forgets_mesh .and. all(m%materials%linear) .and. &
                                       .not. any(m%materials%has_eigenstrain .and. .not. m%materials%is_scaled))) then
         call carry_over(m)
         call find_loading(m, m%state%time, loading)
         work = m%energies%external_work
         call go_to(self, m, loading, loading, 0.0_dp, none)
         if (.not. (none%failed() .or. all(m%materials%linear))) then
            if (.not. self%newton%is_stable()) call none%report(exit_computation, 'not stable')
         end if
         if (.not. none%failed()) then
            call archive_history(m)
            m%state%displacement = m%state%displacement + self%moved
            m%energies%external_work = work + (stored_energy(m) + dissipated_energy(m) + m%interfaces%loss - self%kept)
            return
         end if
      end if
      if (hangs_on_path(m)) then
         call failure%report(exit_computation, m%state%when()//'on a finer mesh '//none%message)
         return
      end if
      call unload(self, m)
      call find(self, m, m%state%time, failure)
   end subroutine find_again

   !> Whether a state depends on the way to it.
   pure logical function hangs_on_path(m)
      type(problem_t), intent(in) :: m
      hangs_on_path = any(m%materials%has_history) .or. have_friction(m%interfaces) .or. m%interfaces%n_cohesive > 0
   end function hangs_on_path

   !> Go back to material without loads.
   subroutine unload(self, m)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      m%particles%displacement = 0
      m%particles%gradient = 0
      if (allocated(m%particles%history)) m%particles%history = 0
      if (allocated(m%particles%widening)) m%particles%widening = 0
      call relax_interfaces(m%interfaces)
      m%energies%external_work = 0
      call press_on_supports(m%constraints)
      call displace(m, 0*m%state%displacement)
      self%begun = .false.
   end subroutine unload

   !> Archive the data that the next equilibrium needs of the last.
   subroutine serialise(self, m, archive)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      class(archive_t), intent(inout) :: archive
      integer :: n
      call archive%serialise('have_begun', self%begun)
      call archive%serialise('forgets_mesh', self%forgets_mesh)
      if (any(m%materials%has_eigenstrain)) call archive%serialise('at_first', self%at_first)
      if (.not. self%begun) return
      n = 0
      if (allocated(m%state%displacement)) n = size(m%state%displacement, 2)
      call archive%serialise('points', n)
      if (archive%is_read) allocate (m%state%displacement(ndim, n))
      call archive%archive_reals('displacement', ndim*n, m%state%displacement)
      call archive%serialise('kept', self%kept)
   end subroutine serialise

   !> Go to equilibrium from that with another drive. Fails where it is not found.
   subroutine go_to(self, m, before, after, time_increment, failure)
      class(equilibrium_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(loading_t), intent(in) :: before, after
      real(dp), intent(in) :: time_increment     !! between them [s]
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: held(:, :), held_before(:, :), first(:, :)
      logical :: is_prescribed
      self%moved = 0*before%force
      self%outer%applied = before%force
      if (allocated(before%factor)) self%outer%factor = before%factor
      first = all_of(before, m)
      is_prescribed = any(abs(after%shift - before%shift) > 0)
      if (is_prescribed .and. allocated(self%held)) held_before = self%held
      if (is_prescribed .and. .not. allocated(self%held)) call find_reactions(self, m, held_before)
      self%outer%applied = after%force
      if (allocated(after%factor)) self%outer%factor = after%factor
      call self%with_contact(m, time_increment, after%shift - before%shift, failure)
      if (failure%failed()) return
      if (any(m%materials%is_finite) .and. (is_prescribed .or. any(abs(all_of(after, m) - first) > 0))) &
         call check_step_size(self, failure)
      m%energies%external_work = m%energies%external_work + work_of(m, (first + all_of(after, m))/2, self%moved)
      if (.not. is_prescribed) return
      call find_reactions(self, m, held)
      m%energies%external_work = m%energies%external_work + sum((held_before + held)*(after%shift - before%shift))/2
   end subroutine go_to

   !> Forces of all loads where the particles are now, condensed [N].
   function all_of(loading, m) result(force)
      type(loading_t), intent(in) :: loading
      type(problem_t), intent(in) :: m
      real(dp), allocatable :: force(:, :)       !! (ndim, n_points)
      allocate (force, source=loading%force)
      if (allocated(loading%factor)) call add_followers(m, loading%factor, force)
   end function all_of

   !> Forces of the constraints on the nodes that they hold [N].
   subroutine find_reactions(self, m, force)
      class(equilibrium_t), intent(in) :: self
      type(problem_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: force(:, :) !! (ndim, n_nodes)
      real(dp), allocatable :: r(:, :)
      call residual(m, self%outer, self%moved, r)
      allocate (force, source=merge(-r(:, :m%grid%n_nodes), 0.0_dp, m%constraints%fixed))
   end subroutine find_reactions

   !> Fail where a load step has led far from where the tangent at its start pointed to.
   subroutine check_step_size(self, failure)
      type(equilibrium_t), intent(in) :: self
      type(failure_t), intent(inout) :: failure
      if (.not. allocated(self%newton%predicted)) return
      if (norm(self%moved - self%newton%predicted) > off_tangent*norm(self%newton%predicted)) &
         call failure%report(exit_computation, 'the equilibrium found is far from the prediction by the tangent before it')
   end subroutine check_step_size

   !> Loading a part of the way from one to another.
   pure type(loading_t) function between(first, last, part)
      type(loading_t), intent(in) :: first, last
      real(dp), intent(in) :: part
      allocate (between%force, source=first%force + part*(last%force - first%force))
      allocate (between%shift, source=first%shift + part*(last%shift - first%shift))
      if (allocated(first%factor)) allocate (between%factor, source=first%factor + part*(last%factor - first%factor))
   end function between

   !> Whether contact may change in a body whose stored energy equals the work: no friction, no history-dependent material.
   pure logical function tells_work(m)
      type(problem_t), intent(in) :: m
      tells_work = is_in_touch(m) .and. all(m%materials%linear) .and. m%interfaces%n_cohesive == 0 &
                   .and. .not. any(m%materials%has_eigenstrain)
      if (m%interfaces%n_contact > 0) tells_work = tells_work .and. .not. any(m%interfaces%list(:m%interfaces%n)%friction > 0)
   end function tells_work

   !> Fail where the equilibrium that was found is not stable, or not on a path of equilibria from the start.
   subroutine check_stability(self, m, start, relaxes, failure)
      class(equilibrium_t), intent(in) :: self
      type(problem_t), intent(in) :: m
      type(start_t), intent(in) :: start
      logical, intent(in) :: relaxes             !! whether material has taken its eigenstrain besides, which no load has worked for
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: of_all = 1e-3_dp    ! part of all energy: corners of cohesive laws are within it
      real(dp), parameter :: rounding = 1e-10_dp ! part of it that is rounding, over `off_path`
      real(dp) :: work, stored, least
      integer :: k
      work = m%energies%external_work - start%instant%energies%external_work
      least = merge(of_all, rounding, m%interfaces%n_cohesive > 0)*start%stored
      least = max(least, epsilon(least)*m%interfaces%thickness%at(maxval(m%grid%node_position, dim=2)) &
                         *m%grid%forest%cell**(ndim - 2)*maxval(self%moved**2) &
                         *maxval([(m%materials(k)%plane_modulus(), k=1, size(m%materials))])) ! of bodies that are but carried along
      stored = stored_energy(m) + dissipated_energy(m) + m%interfaces%loss - start%stored
      if (.not. self%newton%is_stable()) then
         call failure%report(exit_computation, 'the equilibrium that was found is not stable')
      else if (.not. relaxes .and. abs(work - stored) > off_path*max(abs(work), abs(stored), least)) then
         call failure%report(exit_computation, 'the loads have done work of '//three_digits(work)//' J, of which the material '// &
                             'has stored '//three_digits(stored)//' J: no path of equilibria leads to this state')
      end if
   end subroutine check_stability

   !> After the mesh has changed: let the particles be moved and strained by the displacement of its nodes.
   subroutine carry_over(m)
      type(problem_t), intent(inout) :: m
      real(dp) :: turn(ndim, m%grid%n_nodes)
      integer :: k
      associate (u => m%state%displacement)
         turn = 0
         turn(:, m%constraints%node) = m%constraints%turned(u)
         where (m%constraints%fixed .and. .not. m%constraints%supported) &
            u(:, :m%grid%n_nodes) = m%constraints%prescribed_at(m%state%time) + turn
         call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, u)
         m%particles%displacement = 0
         m%particles%gradient = 0
         if (allocated(m%particles%widening)) m%particles%widening = 0
         do k = 1, m%interfaces%n                   ! friction forces stay
            associate (point => m%interfaces%list(k))
               if (point%law == contact) point%start = 0
               point%slip = point%slip - along_faces(point, point%opening)
               point%opening = 0
            end associate
         end do
         call displace(m, u)
         do k = 1, m%interfaces%n
            associate (point => m%interfaces%list(k))
               point%slip = point%slip + along_faces(point, point%opening)
            end associate
         end do
         if (m%constraints%only_push()) call lift_by(m, u)
      end associate
   end subroutine carry_over
end module hampm_equilibrium
