!> Equilibrium of a motion at a time: the displacement at which internal forces, loads and constraints are in balance, at rest or, in
!> implicit steps, with the forces of inertia (`hampm_newmark`).
!>
!> Newton's iteration (`hampm_newton`) finds it. With other laws than the linear one a load step is divided where that fails, and
!> where what is found may not be on the path of states at rest that begins where the step does: where it is not stable, is far from
!> where the tangent at the start points to, or has not stored the work of the loads. Where there is no such path, as beyond a limit
!> point (snap through), Newton's iteration may well find an equilibrium, but nothing at rest leads to it. In motion a step is divided
!> where Newton's iteration fails; bodies may buckle there.
!>
!> Laws with a history go on from the last state that was kept: when the load step, or a part of it, has ended in equilibrium.
!> Where no law is meant for large rotations there are no limit points but those of the material, and no other path: nothing is
!> looked at.
!>
!> Which pairs of nodes on faces are pressed together, and which nodes on supports that only push, is found by turns: tie what would
!> overlap, let go what would pull.
!>
!> Source: Wriggers, Nonlinear Finite Element Methods (2008), chapters 5 (limit points) and 10 (active sets).
module hampm_equilibrium
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_face_springs, only: face_springs_t, relax_springs, settle_slip
   use hampm_failure, only: failure_t, exit_computation
   use hampm_motion, only: motion_t, stored_energy, dissipated_energy, keep_history
   use hampm_newmark, only: newmark_t, drive_t, is_linear
   use hampm_newton, only: newton_t, out_of_balance, largest_force, displace, work_of
   use hampm_nodal_state, only: external_force
   use hampm_rigid_motions, only: pin_t, find_pins
   use hampm_stiffness, only: local_of
   use hampm_supports, only: move_supports, look_at_supports, lift_by, press_on_supports
   use hampm_text, only: to_text, three_digits
   use hampm_whereabouts, only: when
   implicit none
   private
   public :: equilibrium_t

   integer, parameter :: most_turns = 50         !! of the faces that touch
   integer, parameter :: many_turns = 20         !! after which supports are let go one by one
   integer, parameter :: most_divisions = 14     !! of a load step, each into two
   integer, parameter :: most_in_motion = 8      !! of a step with inertia: then it is far too long
   real(dp), parameter :: pulls = 3.1e-9_dp      !! force between faces, over the largest of a cell, from which on they part
   real(dp), parameter :: off_path = 0.02_dp     !! part of the work that may not be stored on a path of states at rest
   real(dp), parameter :: off_energy = 1e-3_dp   !! part of the energy that work in a part of a step may be off as faces or supports open or close
   integer, parameter :: most_for_work = 6       !! divisions of a load step for that
   real(dp), parameter :: off_tangent = 0.5_dp   !! part of the way of a load step by which it may leave the tangent at its start

   !> How equilibrium is found, and whether it has been.
   type :: equilibrium_t
      type(newton_t) :: newton
      type(newmark_t) :: newmark                 !! inertia, in motion
      logical :: begun = .false.                 !! whether it has been found before
      real(dp), allocatable :: displacement(:, :) !! of the nodes there, from material without loads [m], (ndim, n_points)
      real(dp), allocatable, private :: moved(:, :) !! on the way to the last one [m], (ndim, n_points)
      real(dp), private :: work_at_once = 0      !! that the forces of its loads would have done all the way there [J]
      logical :: forgets_mesh = .false.          !! whether the state is that of the mesh, and not of the way there: nothing has grown
   contains
      procedure :: find
      procedure :: find_again
      procedure :: distance
      procedure :: keep
   end type equilibrium_t

   !> What a part of a load step begins with, to go back to.
   type :: start_t
      real(dp) :: stored = 0                     !! strain energy [J]
      real(dp) :: external_work = 0              !! [J]
      real(dp), allocatable :: displacement(:, :), gradient(:, :, :), widening(:), gap(:)
      real(dp), allocatable :: lift(:, :)
      type(face_springs_t), allocatable :: springs
      logical, allocatable :: touches(:), fixed(:, :)
   end type start_t

contains

   !> Find equilibrium at a time, from that at the present time of the motion; at rest the first time from material without loads. Fails
   !> where there is none to be found, or at rest none that is stable. With `factor` loads and prescribed motions are multiplied by that on the way.
   subroutine find(self, m, time, failure, factor)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! [s]
      type(failure_t), intent(inout) :: failure
      real(dp), intent(in), optional :: factor   !! of what drives the material now [-]
      type(failure_t) :: none
      type(start_t) :: start
      type(drive_t) :: first, last
      real(dp) :: part, done
      integer :: divisions
      logical :: too_long
      if (.not. self%newmark%is_used) call find_drives(self, m, time, first, last, factor)
      done = 0
      part = 1
      divisions = 0
      do while (done < 1)
         none = failure_t()
         call remember(m, start)
         if (self%newmark%is_used) then
            call move_on(self, m, m%time + (done + part)*(time - m%time), part*(time - m%time), none)
         else
            call go_to(self, m, between(first, last, done), between(first, last, done + part), part*(time - m%time), none)
            if (any(m%materials%is_finite()) .and. .not. none%failed()) &
               call look_at_path(self, m, start, .not. (self%begun .or. done > 0) .and. any(m%materials%has_eigenstrain), none)
         end if
         too_long = divisions < most_for_work .and. may_turn(m) .and. .not. (none%failed() .or. self%newmark%is_used)
         if (too_long) too_long = is_work_off(m, start)
         if (none%failed() .or. too_long) then
            divisions = divisions + 1
            part = part/2
            if (none%failed() .and. all(m%materials%linear) .and. .not. (self%newmark%is_used .and. m%springs%n_contact > 0) &
                .or. divisions > merge(most_in_motion, most_divisions, self%newmark%is_used)) exit
            call go_back(m, start)
         else
            call settle_slip(m%springs)
            call keep_history(m)
            if (.not. self%newmark%is_used) call note_displacement(self, m, between(first, last, done + part))
            done = done + part
            part = min(2*part, 1 - done)
            divisions = max(0, divisions - 1)
         end if
      end do
      if (none%failed()) then
         call failure%report(exit_computation, when(m%steps, time)//none%message//how_far(self, m, done))
      else
         m%time = time
         self%begun = .true.
      end if
   end subroutine find

   !> What drives the material at rest now and at a time: loads and prescribed motions then are multiplied by `factor`.
   subroutine find_drives(self, m, time, first, last, factor)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! [s]
      type(drive_t), intent(out) :: first, last
      real(dp), intent(in), optional :: factor   !! [-]
      call find_drive(m, m%time, first)
      if (.not. self%begun) first%force = 0
      if (.not. self%begun) first%way = 0
      if (.not. self%begun) self%displacement = 0*first%force
      call find_drive(m, time, last)
      if (present(factor)) last%force = factor*last%force
      if (present(factor)) last%way = factor*last%way
      if (.not. self%begun .and. m%contact%n > 0) m%contact%touches = .true.
   end subroutine find_drives

   !> Find equilibrium again at the present time, on another mesh, from what the particles carry over to it or, where that does not lead
   !> there, from material without loads. The loads, which stay, do work on what lies between both equilibria, not on the way from what was
   !> carried over: that is no state of the material. Where the state does not depend on the way to it, it is from the start: then the work of
   !> the loads is that on this mesh, whatever nodes constraints hold that were not there before.
   subroutine find_again(self, m, failure)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: none
      type(drive_t) :: drive
      real(dp) :: nothing(ndim, m%grid%n_points), work, at_once
      if (.not. (self%forgets_mesh .and. all(m%materials%linear) .and. .not. any(m%materials%has_eigenstrain))) then
         call carry_over(m, self%displacement)
         call find_drive(m, m%time, drive)
         work = m%external_work
         at_once = self%work_at_once
         call go_to(self, m, drive, drive, 0.0_dp, none)
         if (.not. (none%failed() .or. all(m%materials%linear))) then
            if (.not. self%newton%is_stable()) call none%report(exit_computation, 'not stable')
         end if
         if (.not. none%failed()) then
            call note_displacement(self, m, drive)
            m%external_work = work + (self%work_at_once - at_once)
            return
         end if
      end if
      nothing = 0
      m%particles%displacement = 0
      m%particles%gradient = 0
      if (allocated(m%particles%widening)) m%particles%widening = 0
      call relax_springs(m%springs)
      m%external_work = 0
      call press_on_supports(m%constraints)
      call displace(m, nothing)
      if (m%contact%n > 0) m%contact%gap = 0
      self%begun = .false.
      call self%find(m, m%time, failure)
   end subroutine find_again

   !> Note the displacement with which an equilibrium has been found.
   subroutine note_displacement(self, m, drive)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(in) :: m
      type(drive_t), intent(in) :: drive         !! there
      self%displacement = self%displacement + self%moved
      self%work_at_once = work_of(m, drive%force, self%displacement)
   end subroutine note_displacement

   !> Keep what the next equilibrium needs of the last.
   subroutine keep(self, archive)
      class(equilibrium_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      integer :: n
      call archive%keep('have_begun', self%begun)
      call archive%keep('forgets_mesh', self%forgets_mesh)
      if (.not. self%begun .or. self%newmark%is_used) return
      n = 0
      if (allocated(self%displacement)) n = size(self%displacement, 2)
      call archive%keep('points', n)
      if (archive%is_read) allocate (self%displacement(ndim, n))
      call archive%keep_reals('displacement', ndim*n, self%displacement)
      call archive%keep('work_at_once', self%work_at_once)
   end subroutine keep

   !> Up to where equilibrium could be followed, in words.
   function how_far(self, m, done) result(text)
      type(equilibrium_t), intent(in) :: self
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: done               !! part of the step
      character(:), allocatable :: text
      text = ''
      if (all(m%materials%linear) .and. .not. self%newmark%is_used) return
      text = '. It was followed through '//three_digits(100*done)//' % of this load step, with '//to_text(self%newton%solutions)// &
             ' solutions so far. Likely cause: '
      if (self%newmark%is_used) then
         text = text//'a load too large for the material, or a &method time_step too long for the motion'
      else
         text = text//'a limit point, beyond which the body buckles or snaps through, or a load too large for the material; '// &
                '&method time = ''implicit'' or ''explicit'' follows such a motion'
      end if
   end function how_far

   !> Keep what a part of a load step begins with.
   subroutine remember(m, start)
      type(motion_t), intent(in) :: m
      type(start_t), intent(out) :: start
      if (is_linear(m) .and. .not. may_turn(m)) return ! there is no second try
      start%external_work = m%external_work
      start%stored = stored_energy(m) + dissipated_energy(m)
      if (m%springs%n > 0) start%springs = m%springs
      start%displacement = m%particles%displacement
      start%gradient = m%particles%gradient
      if (allocated(m%particles%widening)) start%widening = m%particles%widening
      start%lift = m%constraints%lift
      start%fixed = m%constraints%fixed
      if (m%contact%n == 0) return
      start%gap = m%contact%gap
      start%touches = m%contact%touches
   end subroutine remember

   !> Let time pass: what remembers relaxes before anything has moved.
   subroutine let_pass(m, elapsed)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: elapsed            !! [s]
      real(dp) :: stay(ndim, m%grid%n_points)
      if (.not. any(m%materials%has_history())) return
      m%materials%elapsed = elapsed
      stay = 0
      call displace(m, stay)
   end subroutine let_pass

   !> Go back to where it began.
   subroutine go_back(m, start)
      type(motion_t), intent(inout) :: m
      type(start_t), intent(in) :: start
      real(dp) :: stay(ndim, m%grid%n_points)
      m%external_work = start%external_work
      m%particles%displacement = start%displacement
      m%particles%gradient = start%gradient
      if (allocated(start%widening)) m%particles%widening = start%widening
      if (allocated(start%gap)) m%contact%gap = start%gap
      if (allocated(start%springs)) m%springs = start%springs
      if (allocated(start%touches)) m%contact%touches = start%touches
      if (allocated(start%lift)) then
         m%constraints%lift = start%lift
         call m%constraints%fix(start%fixed)
      end if
      stay = 0
      m%materials%elapsed = 0
      call displace(m, stay)
   end subroutine go_back

   !> Go to equilibrium from that with another drive. Fails where it is not found.
   subroutine go_to(self, m, before, after, elapsed, failure)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      type(drive_t), intent(in) :: before, after
      real(dp), intent(in) :: elapsed            !! between them [s]
      type(failure_t), intent(inout) :: failure
      type(pin_t), allocatable :: pins(:)
      real(dp), allocatable :: held(:, :), held_before(:, :)
      logical :: is_driven
      associate (outer => self%newmark%outer)
         if (allocated(self%moved)) deallocate (self%moved)
         allocate (self%moved(ndim, m%grid%n_points), source=0.0_dp)
         outer%applied = before%force
         is_driven = any(abs(after%way - before%way) > 0)
         if (is_driven) call find_reactions(self, m, held_before)
         outer%applied = after%force
         call find_pins(m, pins)
         call let_pass(m, elapsed)
         call balance_with_contact(self, m, after%way - before%way, pins, failure)
         if (failure%failed()) return
         if (any(m%materials%is_finite()) .and. differ(before, after)) call look_at_way(self, self%moved, failure)
      end associate
      m%external_work = m%external_work + work_of(m, (before%force + after%force)/2, self%moved)
      if (.not. is_driven) return
      call find_reactions(self, m, held)
      m%external_work = m%external_work + sum((held_before + held)*(after%way - before%way))/2
   end subroutine go_to

   !> Move on by a step with inertia. Fails where its forces are not balanced.
   subroutine move_on(self, m, time, dt, failure)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! at its end [s]
      real(dp), intent(in) :: dt                 !! its length [s]
      type(failure_t), intent(inout) :: failure
      type(drive_t) :: drive
      type(pin_t), allocatable :: none(:)
      real(dp), allocatable :: way(:, :)
      logical :: at_once
      associate (newmark => self%newmark)
         call newmark%begin(m, time, dt, drive)
         allocate (way, source=drive%way - newmark%now%way)
         at_once = is_linear(m)
         if (at_once) then
            call self%newton%solve_at_once(m, newmark%outer, newmark%r, way, self%moved, failure)
         else
            allocate (none(0))
            self%moved = 0*newmark%r
            call let_pass(m, dt)
            call balance_with_contact(self, m, way, none, failure)
            call settle_slip(m%springs)
         end if
         if (.not. failure%failed()) call newmark%finish(m, self%moved, drive, .not. at_once)
      end associate
   end subroutine move_on

   !> Balance the forces with faces and supports that touch as they press. Fails where that is not found.
   subroutine balance_with_contact(self, m, way, pins, failure)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: way(:, :)          !! by which fixed components move [m], (ndim, n_nodes)
      type(pin_t), allocatable, intent(inout) :: pins(:)
      type(failure_t), intent(inout) :: failure
      logical :: changed
      integer :: turn
      if (allocated(self%newton%predicted)) deallocate (self%newton%predicted)
      call move_supports(m%constraints, way)
      do turn = 1, most_turns
         call self%newton%balance(m, self%newmark%outer, way, pins, self%moved, failure)
         if (failure%failed()) return
         call look_at_faces(self, m, changed)
         if (m%constraints%only_push()) call change_supports(self, m, turn, pins, changed)
         if (.not. changed) return
         if (allocated(self%newton%predicted)) deallocate (self%newton%predicted)
      end do
      call failure%report(exit_computation, 'which nodes of faces or supports touch could not be found')
   end subroutine balance_with_contact

   !> Forces of the constraints on the nodes that they hold [N].
   subroutine find_reactions(self, m, force)
      class(equilibrium_t), intent(in) :: self
      type(motion_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: force(:, :) !! (ndim, n_nodes)
      real(dp), allocatable :: r(:, :)
      call out_of_balance(m, self%newmark%outer, self%moved, r)
      allocate (force, source=merge(-r(:, :m%grid%n_nodes), 0.0_dp, m%constraints%fixed))
   end subroutine find_reactions

   !> Let go the supports that pull, and hold what would go through them. Where a body would not be held any more, or after many turns,
   !> only the one that pulls most is let go.
   subroutine change_supports(self, m, turn, pins, changed)
      class(equilibrium_t), intent(in) :: self
      type(motion_t), intent(inout) :: m
      integer, intent(in) :: turn
      type(pin_t), allocatable, intent(inout) :: pins(:)
      logical, intent(inout) :: changed
      real(dp), allocatable :: r(:, :)
      logical :: fixed(ndim, m%grid%n_nodes)
      logical :: has_moved
      real(dp) :: rounding
      integer :: n_before
      n_before = size(pins)
      fixed = m%constraints%fixed
      call out_of_balance(m, self%newmark%outer, self%moved, r)
      rounding = pulls*largest_force(m, r)
      call look_at_supports(m, r, rounding, turn > many_turns, has_moved)
      if (.not. has_moved) return
      changed = .true.
      call find_pins(m, pins)
      if (size(pins) <= n_before .or. turn > many_turns) return
      call m%constraints%fix(fixed)
      call look_at_supports(m, r, rounding, .true., has_moved)
      call find_pins(m, pins)
   end subroutine change_supports

   !> Fail where a load step has led far from where the tangent at its start pointed to.
   subroutine look_at_way(self, moved, failure)
      type(equilibrium_t), intent(in) :: self
      real(dp), intent(in) :: moved(:, :)        !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      if (.not. allocated(self%newton%predicted)) return
      if (norm2(moved - self%newton%predicted) > off_tangent*norm2(self%newton%predicted)) &
         call failure%report(exit_computation, 'the equilibrium that was found is far from where the state before pointed to')
   end subroutine look_at_way

   !> What drives the material at a time.
   subroutine find_drive(m, time, drive)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! [s]
      type(drive_t), intent(out) :: drive
      call external_force(m, time, drive%force)
      allocate (drive%way, source=m%constraints%way(time))
   end subroutine find_drive

   !> What drives it a part of the way from one to another.
   pure type(drive_t) function between(first, last, part)
      type(drive_t), intent(in) :: first, last
      real(dp), intent(in) :: part
      between%force = first%force + part*(last%force - first%force)
      between%way = first%way + part*(last%way - first%way)
   end function between

   !> Whether two drives differ.
   pure logical function differ(a, b)
      type(drive_t), intent(in) :: a, b
      differ = any(abs(a%force - b%force) > 0) .or. any(abs(a%way - b%way) > 0)
   end function differ

   !> Distance from rest, as `hampm_rest` has it: the square root of the energy of the displacement that is left over the strain energy.
   real(dp) function distance(self, m)
      class(equilibrium_t), intent(in) :: self
      type(motion_t), intent(in) :: m
      distance = sqrt(max(self%newton%way_left, 0.0_dp)/max(stored_energy(m), tiny(1.0_dp)))
   end function distance

   !> Tie the pairs that overlap, and let go those that pull.
   subroutine look_at_faces(self, m, changed)
      class(equilibrium_t), intent(in) :: self
      type(motion_t), intent(inout) :: m
      logical, intent(out) :: changed
      real(dp), allocatable :: r(:, :)
      real(dp) :: rounding, largest_gap
      integer :: k
      changed = .false.
      if (m%contact%n == 0) return
      call out_of_balance(m, self%newmark%outer, self%moved, r)
      rounding = pulls*largest_force(m, r)
      largest_gap = maxval(abs(m%contact%gap))
      do k = 1, m%contact%n
         associate (d => m%contact%normal(k), i => m%contact%node(:, k), touches => m%contact%touches(k))
            if (touches) then
               if (-r(d, i(1)) >= -rounding) cycle
            else
               if (m%contact%gap(k) >= -1e-12_dp*largest_gap) cycle
            end if
            touches = .not. touches
            changed = .true.
         end associate
      end do
   end subroutine look_at_faces

   !> Whether faces or supports may open and close in a body whose energy tells the work: there is no friction, and no material remembers.
   pure logical function may_turn(m)
      type(motion_t), intent(in) :: m
      may_turn = (m%contact%n > 0 .or. m%springs%n_contact > 0 .or. m%constraints%only_push()) .and. all(m%materials%linear) &
                 .and. .not. any(m%materials%has_eigenstrain .or. m%materials%has_history())
      if (m%springs%n_contact > 0) may_turn = may_turn .and. .not. any(m%springs%list(:m%springs%n)%friction > 0)
   end function may_turn

   !> Whether the work of the loads, as if they went straight to where they are, is not what has been stored and taken: as faces or supports open
   !> or close on the way it is bent.
   logical function is_work_off(m, start)
      type(motion_t), intent(in) :: m
      type(start_t), intent(in) :: start
      real(dp) :: now
      now = stored_energy(m) + dissipated_energy(m)
      is_work_off = abs(m%external_work - start%external_work - now + start%stored) > off_energy*max(abs(now), abs(start%stored))
   end function is_work_off

   !> Fail where the equilibrium that was found is not stable, or not on a path of states at rest from the start.
   subroutine look_at_path(self, m, start, relaxes, failure)
      class(equilibrium_t), intent(in) :: self
      type(motion_t), intent(in) :: m
      type(start_t), intent(in) :: start
      logical, intent(in) :: relaxes             !! whether material has taken its eigenstrain besides, which no load has worked for
      type(failure_t), intent(inout) :: failure
      real(dp) :: work, stored
      work = m%external_work - start%external_work
      stored = stored_energy(m) + dissipated_energy(m) - start%stored
      if (.not. self%newton%is_stable()) then
         call failure%report(exit_computation, 'the equilibrium that was found is not stable')
      else if (.not. relaxes .and. abs(work - stored) > off_path*max(abs(work), abs(stored))) then
         call failure%report(exit_computation, 'the loads have done work of '//three_digits(work)//' J, of which the material '// &
                             'has stored '//three_digits(stored)//' J: no path of states at rest leads to this equilibrium')
      end if
   end subroutine look_at_path

   !> After the mesh has changed: displacements of its nodes, the means by mass of what the particles around them tell, linear from
   !> where they are, and particles that are moved and strained by these.
   subroutine carry_over(m, u)
      type(motion_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: u(:, :) !! [m], (ndim, n_points)
      real(dp), allocatable :: mass(:)
      real(dp) :: shape(m%grid%n_functions)
      integer :: at(m%grid%n_functions)
      integer :: i, c, k, d
      allocate (u(ndim, m%grid%n_points), mass(m%grid%n_points), source=0.0_dp)
      associate (p => m%particles, all => m%fields%mass_matrix%all)
         do i = 1, p%n
            shape = m%grid%functions_in(p%cell(i), local_of(m, i))
            at = m%grid%support_of(p%cell(i))
            do c = 1, size(at)
               associate (point => at(c))
                  mass(point) = mass(point) + shape(c)*p%mass(i)
                  u(:, point) = u(:, point) + shape(c)*p%mass(i)*(p%displacement(i, :) &
                                + matmul(p%gradient_of(i), m%grid%node_position(:, point) - p%place_in_grid(i)))
               end associate
            end do
         end do
         call m%grid%dofs%condense(all, 1, mass)
         call m%grid%dofs%condense(all, ndim, u)
         do k = 1, all%n_nodes
            if (mass(all%nodes(k)) > 0) u(:, all%nodes(k)) = u(:, all%nodes(k))/mass(all%nodes(k))
         end do
         where (m%constraints%fixed .and. .not. m%constraints%supported) u(:, :m%grid%n_nodes) = m%constraints%way(m%time)
         call m%grid%dofs%distribute(all, ndim, u)
         p%displacement = 0
         if (allocated(p%widening)) p%widening = 0
         p%gradient = 0
         do k = 1, m%springs%n
            m%springs%list(k)%opening = 0
         end do
      end associate
      call displace(m, u)
      if (m%constraints%only_push()) call lift_by(m, u)
      do k = 1, m%contact%n
         d = m%contact%normal(k)
         m%contact%gap(k) = u(d, m%contact%node(1, k)) - u(d, m%contact%node(2, k))
      end do
   end subroutine carry_over
end module hampm_equilibrium
