!> Equilibrium of a motion at a time: the displacement at which internal forces, loads and constraints are in balance.
!>
!> Newton's iteration K du = r, with r what is out of balance and K the tangent (`hampm_stiffness`), gives displacements of the nodes,
!> by which the particles move and strain as in a pass of a step. With the linear law the first is exact but for rounding. With others
!> each is made shorter until it lessens the work r . du of what is out of balance, and the load step is divided where that fails, and
!> where what is found may not be on the path of states at rest that begins where the step does: where it is not stable, is far from
!> where the tangent at the start points to, or has not stored the work of the loads. Where there is no such path, as beyond a limit
!> point (snap through), Newton's iteration may well find an equilibrium, but nothing at rest leads to it.
!>
!> Of the pairs of nodes on faces that may touch, those that are pressed together are tied in the direction normal to the faces. Which
!> these are is found by turns: tie what would overlap, let go what would pull.
!>
!> Source: Wriggers, Nonlinear Finite Element Methods (2008), chapters 5 (Newton's method, limit points) and 10 (active sets);
!> Bathe, Finite Element Procedures (1996), section 8.4.
module hampm_equilibrium
   use hampm_kinds, only: dp, ndim, corners, name_len
   use hampm_basis, only: shape_functions
   use hampm_cell_blocks, only: of_force
   use hampm_energy, only: determinant_of, most_crushed_particle, strain_energy
   use hampm_failure, only: failure_t, exit_computation
   use hampm_loads, only: add_loads, place_loads
   use hampm_motion, only: motion_t
   use hampm_nodal_fields, only: v_next
   use hampm_nodal_state, only: internal_force
   use hampm_particle_pass, only: pass_report_t, pass_over_all
   use hampm_pass, only: pass_t
   use hampm_rigid_motions, only: pin_t, find_pins, check_pins
   use hampm_stiffness, only: stiffness_t, stiffness_kind_t, factorise_stiffness, forces_of, local_of
   use hampm_text, only: to_text, three_digits
   use hampm_whereabouts, only: when
   implicit none
   private
   public :: equilibrium_t

   integer, parameter :: most_iterations = 25    !! of Newton
   integer, parameter :: most_turns = 50         !! of the faces that touch
   integer, parameter :: most_halvings = 10      !! of a displacement, to lessen what is out of balance
   integer, parameter :: most_divisions = 14     !! of a load step, each into two
   real(dp), parameter :: balanced = 1e-11_dp    !! what is out of balance, over the largest force of a cell
   real(dp), parameter :: lessened = 0.9_dp      !! part of the work r . du that may be left
   real(dp), parameter :: off_path = 0.02_dp     !! part of the work that may not be stored on a path of states at rest
   real(dp), parameter :: off_tangent = 0.5_dp   !! part of the way of a load step by which it may leave the tangent at its start

   !> How equilibrium is found, and what it took.
   type :: equilibrium_t
      character(name_len) :: solver = 'umfpack'  !! 'umfpack', 'banded' or 'cg'
      integer :: factorisations = 0              !! so far
      integer :: solutions = 0                   !! so far
      real(dp) :: way_left = 0                   !! energy of the displacement that is left to equilibrium, as it was found last [J]
      logical :: begun = .false.                 !! whether it has been found before
      real(dp), allocatable, private :: predicted(:, :) !! where the tangent at the start of a load step points to [m],
                                                 !! (ndim, n_points); not allocated where other faces touch at its end
      type(stiffness_t), private :: k            !! that was factorised last
      integer, private :: layout = 0             !! of the blocks for which it was
      logical, allocatable, private :: tied(:)   !! and the pairs that touched
   contains
      procedure :: find
      procedure :: find_again
      procedure :: distance
      procedure :: release
   end type equilibrium_t

   !> What drives the material at a time.
   type :: drive_t
      real(dp), allocatable :: force(:, :)       !! of all loads on the points [N], (ndim, n_points)
      real(dp), allocatable :: way(:, :)         !! by how much fixed components of nodes have been moved [m], (ndim, n_nodes)
   end type drive_t

   !> What a part of a load step begins with, to go back to.
   type :: start_t
      real(dp) :: stored = 0                     !! strain energy [J]
      real(dp) :: external_work = 0              !! [J]
      real(dp), allocatable :: displacement(:, :), gradient(:, :, :), gap(:)
      logical, allocatable :: touches(:)
   end type start_t

contains

   !> Find equilibrium at a time, from that at the present time of the motion; the first time from material without loads. Fails where
   !> there is none to be found, or none that is stable.
   subroutine find(self, m, time, failure)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! [s]
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: none
      type(start_t) :: start
      type(drive_t) :: first, last
      real(dp) :: part, done
      integer :: divisions
      call find_drive(m, m%time, first)
      if (.not. self%begun) first%force = 0
      if (.not. self%begun) first%way = 0
      call find_drive(m, time, last)
      if (.not. self%begun .and. m%contact%n > 0) m%contact%touches = .true.
      done = 0
      part = 1
      divisions = 0
      do while (done < 1)
         none = failure_t()
         call remember(m, start)
         call go_to(self, m, between(first, last, done), between(first, last, done + part), none)
         if (.not. (none%failed() .or. all(m%materials%linear))) call look_at_path(self, m, start, none)
         if (none%failed()) then
            divisions = divisions + 1
            part = part/2
            if (all(m%materials%linear) .or. divisions > most_divisions) exit
            call go_back(m, start)
         else
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

   !> Find equilibrium again at the present time, on another mesh, from what the particles carry over to it or, where that does not lead
   !> there, from material without loads.
   subroutine find_again(self, m, failure)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: none
      type(drive_t) :: drive
      real(dp) :: nothing(ndim, m%grid%n_points)
      call carry_over(m)
      call find_drive(m, m%time, drive)
      call go_to(self, m, drive, drive, none)
      if (.not. (none%failed() .or. all(m%materials%linear))) then
         if (.not. self%k%is_stable()) call none%report(exit_computation, 'not stable')
      end if
      if (.not. none%failed()) return
      nothing = 0
      m%particles%displacement = 0
      m%particles%gradient = 0
      m%external_work = 0
      call displace(m, nothing)
      if (m%contact%n > 0) m%contact%gap = 0
      self%begun = .false.
      call self%find(m, m%time, failure)
   end subroutine find_again

   !> Up to where equilibrium could be followed, in words.
   function how_far(self, m, done) result(text)
      type(equilibrium_t), intent(in) :: self
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: done               !! part of the step
      character(:), allocatable :: text
      text = ''
      if (all(m%materials%linear)) return
      text = '. It was followed through '//three_digits(100*done)//' % of this load step, with '//to_text(self%solutions)// &
             ' solutions so far. Likely cause: a limit point, beyond which the body buckles or snaps through, or a load '// &
             'too large for the material; &method time = ''explicit'' follows such a motion'
   end function how_far

   !> Keep what a part of a load step begins with.
   subroutine remember(m, start)
      type(motion_t), intent(in) :: m
      type(start_t), intent(out) :: start
      if (all(m%materials%linear)) return        ! there is no second try
      start%external_work = m%external_work
      start%stored = strain_energy(m%particles, m%materials)
      start%displacement = m%particles%displacement
      start%gradient = m%particles%gradient
      if (m%contact%n == 0) return
      start%gap = m%contact%gap
      start%touches = m%contact%touches
   end subroutine remember

   !> Go back to where it began.
   subroutine go_back(m, start)
      type(motion_t), intent(inout) :: m
      type(start_t), intent(in) :: start
      real(dp) :: stay(ndim, m%grid%n_points)
      m%external_work = start%external_work
      m%particles%displacement = start%displacement
      m%particles%gradient = start%gradient
      if (allocated(start%gap)) m%contact%gap = start%gap
      if (allocated(start%touches)) m%contact%touches = start%touches
      stay = 0
      call displace(m, stay)
   end subroutine go_back

   !> Go to equilibrium from that with another drive. Fails where it is not found.
   subroutine go_to(self, m, before, after, failure)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      type(drive_t), intent(in) :: before, after
      type(failure_t), intent(inout) :: failure
      type(pin_t), allocatable :: pins(:)
      real(dp), allocatable :: moved(:, :), mean(:, :), r(:, :), r_before(:, :)
      logical :: changed
      integer :: turn
      allocate (moved(ndim, m%grid%n_points), source=0.0_dp)
      if (allocated(self%predicted)) deallocate (self%predicted)
      call find_pins(m, pins)
      call out_of_balance(m, before%force, r_before)
      do turn = 1, most_turns
         call balance(self, m, after%force, after%way - before%way, pins, moved, failure)
         if (failure%failed()) return
         call look_at_faces(m, after%force, changed)
         if (.not. changed) exit
         if (allocated(self%predicted)) deallocate (self%predicted)
      end do
      if (.not. (all(m%materials%linear) .or. failure%failed()) .and. differ(before, after)) call look_at_way(self, moved, failure)
      if (turn > most_turns) call failure%report(exit_computation, 'which nodes of the faces touch could not be found')
      mean = (before%force + after%force)/2
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, mean)
      m%external_work = m%external_work + work_of(m, mean, moved)
      call out_of_balance(m, after%force, r)
      m%external_work = m%external_work - work_of(m, merge(r_before + r, 0.0_dp, held_points(m)), moved)/2
   end subroutine go_to

   !> Fail where a load step has led far from where the tangent at its start pointed to.
   subroutine look_at_way(self, moved, failure)
      type(equilibrium_t), intent(in) :: self
      real(dp), intent(in) :: moved(:, :)        !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      if (.not. allocated(self%predicted)) return
      if (norm2(moved - self%predicted) > off_tangent*norm2(self%predicted)) &
         call failure%report(exit_computation, 'the equilibrium that was found is far from where the state before pointed to')
   end subroutine look_at_way

   !> Which components of points are fixed.
   pure function held_points(m) result(held)
      type(motion_t), intent(in) :: m
      logical :: held(ndim, m%grid%n_points)
      held = .false.
      held(:, :m%grid%n_nodes) = m%constraints%fixed
   end function held_points

   !> What drives the material at a time.
   subroutine find_drive(m, time, drive)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! [s]
      type(drive_t), intent(out) :: drive
      allocate (drive%force(ndim, m%grid%n_points), source=0.0_dp)
      call place_loads(m%loads, m%grid, m%particles)
      call add_loads(m%loads, time, drive%force)
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

   !> What is out of balance at the nodes under some forces on the points, condensed [N].
   subroutine out_of_balance(m, applied, r)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: applied(:, :)      !! [N], (ndim, n_points)
      real(dp), allocatable, intent(out) :: r(:, :) !! (ndim, n_points)
      call internal_force(m, r)
      r = r + applied
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, r)
   end subroutine out_of_balance

   !> Newton's iteration under some forces with the pairs that touch now. Fails where it does not end.
   subroutine balance(self, m, applied, way, pins, moved, failure)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: applied(:, :)      !! on the points [N], (ndim, n_points)
      real(dp), intent(in) :: way(:, :)          !! by which fixed components move in this load step [m], (ndim, n_nodes)
      type(pin_t), intent(in) :: pins(:)
      real(dp), intent(inout) :: moved(:, :)     !! by which nodes have moved in this load step [m], (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: r(:, :), offset(:, :), du(:, :), resisting(:, :)
      logical :: has_offset
      real(dp) :: largest
      integer :: iteration
      do iteration = 1, most_iterations
         call out_of_balance(m, applied, r)
         call find_offset(m, way - moved(:, :m%grid%n_nodes), offset, has_offset)
         if (has_offset) then
            call forces_of(m, offset, resisting)
            call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, resisting)
            r = r - resisting
         end if
         call factorise_now(self, m, pins, failure)
         if (failure%failed()) return
         largest = maxval(abs(self%k%on_unknowns(r)))
         if (.not. has_offset .and. largest <= balanced*largest_force(m, r)) then
            call check_pins(m, pins, r, sqrt(balanced)*largest_force(m, r), failure)
            call self%k%solve(m, r, du, failure)
            self%way_left = work_of(m, r, du)/2
            return
         end if
         call self%k%solve(m, r, du, failure)
         if (failure%failed()) return
         self%solutions = self%solutions + 1
         du = du + offset
         if (iteration == 1 .and. .not. any(abs(moved) > 0)) self%predicted = du
         if (.not. all(m%materials%linear)) call look_at_size(m, du, failure)
         if (failure%failed()) return
         call displace(m, du)
         if (.not. all(m%materials%linear)) call shorten(m, applied, work_of(m, r, du - offset), has_offset, du, self%k, failure)
         if (failure%failed()) return
         moved = moved + du
         call follow_gaps(m, du)
      end do
      call failure%report(exit_computation, 'no equilibrium was found: after '//to_text(most_iterations)// &
                          ' iterations a node is out of balance by '//three_digits(largest)//' N')
   end subroutine balance

   !> Fail where a displacement would strain a cell so much at once that its tangent tells nothing of where that leads.
   subroutine look_at_size(m, du, failure)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: du(:, :)           !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: most = 1            ! of a cell
      integer :: k, d
      do k = 1, m%blocks%n_occupied
         associate (e => m%blocks%occupied(k), at => m%grid%element_nodes(:, m%blocks%occupied(k)))
            do d = 1, ndim
               if (maxval(du(d, at)) - minval(du(d, at)) <= most*m%grid%element_size(e)) cycle
               call failure%report(exit_computation, 'no equilibrium was found: on the way to it a cell would be strained by '// &
                                   'more than one at once')
               return
            end do
         end associate
      end do
   end subroutine look_at_size

   !> Factorise the tangent of the present state, if it is not there.
   subroutine factorise_now(self, m, pins, failure)
      class(equilibrium_t), intent(inout) :: self
      type(motion_t), intent(in) :: m
      type(pin_t), intent(in) :: pins(:)
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      logical :: fits
      fits = all(m%materials%linear) .and. self%layout == m%fields%layout .and. allocated(self%tied)
      if (fits) fits = all(self%tied .eqv. pairs_that_touch(m))
      if (fits) return
      self%tied = pairs_that_touch(m)
      self%layout = m%fields%layout
      call factorise_stiffness(m, stiffness_kind_t(.true., .false., self%solver, pins), self%tied, self%k, unsolved)
      if (unsolved%failed()) call failure%report(unsolved%code, 'the stiffness cannot be factorised: '//unsolved%message// &
                                                 ', as where cells hold too few particles')
      self%factorisations = self%factorisations + 1
   end subroutine factorise_now

   !> Distance from rest, as `hampm_rest` has it: the square root of the energy of the displacement that is left over the strain energy.
   real(dp) function distance(self, m)
      class(equilibrium_t), intent(in) :: self
      type(motion_t), intent(in) :: m
      distance = sqrt(max(self%way_left, 0.0_dp)/max(strain_energy(m%particles, m%materials), tiny(1.0_dp)))
   end function distance

   !> Give back the memory.
   subroutine release(self)
      class(equilibrium_t), intent(inout) :: self
      call self%k%release()
      self%layout = 0
   end subroutine release

   !> Work of condensed forces on a displacement [J].
   pure real(dp) function work_of(m, force, u)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: force(:, :), u(:, :) !! [N], [m], (ndim, n_points)
      work_of = sum(force(:, :m%grid%n_nodes)*u(:, :m%grid%n_nodes))
   end function work_of

   !> The pairs of faces that touch.
   pure function pairs_that_touch(m) result(tied)
      type(motion_t), intent(in) :: m
      logical :: tied(m%contact%n)
      if (m%contact%n > 0) tied = m%contact%touches
   end function pairs_that_touch

   !> The largest force in play: of a cell on one of its corners, or on a node [N].
   pure real(dp) function largest_force(m, r)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: r(:, :)            !! what is out of balance [N]
      largest_force = max(maxval(abs(r)), tiny(1.0_dp))
      if (m%blocks%n > 0) largest_force = max(largest_force, &
                                              maxval(abs(m%fields%contribution(:, :, of_force:of_force + ndim - 1, 1:m%blocks%n))))
   end function largest_force

   !> By how much nodes are to move whatever the forces: held ones with their constraints, and the lower ones of pairs that touch,
   !> to where the upper ones are.
   subroutine find_offset(m, left, offset, has_offset)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: left(:, :)         !! of the way of fixed components [m], (ndim, n_nodes)
      real(dp), allocatable, intent(out) :: offset(:, :) !! (ndim, n_points)
      logical, intent(out) :: has_offset
      integer :: k
      allocate (offset(ndim, m%grid%n_points), source=0.0_dp)
      where (m%constraints%fixed) offset(:, :m%grid%n_nodes) = left
      do k = 1, m%contact%n
         if (m%contact%touches(k)) offset(m%contact%normal(k), m%contact%node(2, k)) = m%contact%gap(k)
      end do
      has_offset = any(abs(offset) > 0)
      if (has_offset) call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, offset)
   end subroutine find_offset

   !> Move and strain the particles by a displacement of the nodes, and map what forces they then have.
   subroutine displace(m, du)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: du(:, :)           !! (ndim, n_points)
      type(pass_report_t) :: report
      m%fields%velocity(:, :, v_next) = du
      call pass_over_all(pass_t(strain_fraction=1.0_dp, strain_by=v_next, move=.true., map_force=.true.), 1.0_dp, m%materials, &
                         m%particles, m%blocks, m%fields, report)
      m%fields%velocity(:, :, v_next) = 0
   end subroutine displace

   !> Make the displacement, by which the particles have moved already, shorter until it lessens what is out of balance.
   subroutine shorten(m, applied, work, has_offset, du, k, failure)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: applied(:, :)      !! forces on the points [N], (ndim, n_points)
      real(dp), intent(in) :: work               !! r . du before [J]
      logical, intent(in) :: has_offset          !! whether nodes had to move
      real(dp), intent(inout) :: du(:, :)        !! (ndim, n_points)
      type(stiffness_t), intent(in) :: k
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: r(:, :)
      integer :: halving, crushed
      logical :: good
      do halving = 0, most_halvings
         crushed = most_crushed_particle(m%particles, m%materials)
         good = crushed == 0
         if (.not. good) good = determinant_of(m%particles, crushed) > 0
         if (good) then
            call out_of_balance(m, applied, r)
            good = has_offset .or. abs(work_of(m, r, du)) <= lessened*abs(work) &
                   .or. maxval(abs(k%on_unknowns(r))) <= sqrt(balanced)*largest_force(m, r)
         end if
         if (good) return
         du = du/2
         call displace(m, -du)
      end do
      call failure%report(exit_computation, 'no equilibrium was found: every displacement on the way to it makes the forces '// &
                          'less balanced')
   end subroutine shorten

   !> Follow the gaps of pairs.
   pure subroutine follow_gaps(m, du)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: du(:, :)           !! (ndim, n_points)
      integer :: k
      do k = 1, m%contact%n
         associate (d => m%contact%normal(k), i => m%contact%node(:, k))
            m%contact%gap(k) = m%contact%gap(k) + du(d, i(1)) - du(d, i(2))
            if (m%contact%touches(k)) m%contact%gap(k) = 0
         end associate
      end do
   end subroutine follow_gaps

   !> Tie the pairs that overlap, and let go those that pull.
   subroutine look_at_faces(m, applied, changed)
      type(motion_t), intent(inout) :: m
      real(dp), intent(in) :: applied(:, :)      !! forces on the points [N], (ndim, n_points)
      logical, intent(out) :: changed
      real(dp), allocatable :: r(:, :)
      real(dp) :: rounding, largest_gap
      integer :: k
      changed = .false.
      if (m%contact%n == 0) return
      call out_of_balance(m, applied, r)
      rounding = sqrt(balanced)*largest_force(m, r)*1e-3_dp
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

   !> Fail where the equilibrium that was found is not stable, or not on a path of states at rest from the start.
   subroutine look_at_path(self, m, start, failure)
      class(equilibrium_t), intent(in) :: self
      type(motion_t), intent(in) :: m
      type(start_t), intent(in) :: start
      type(failure_t), intent(inout) :: failure
      real(dp) :: work, stored
      work = m%external_work - start%external_work
      stored = strain_energy(m%particles, m%materials) - start%stored
      if (.not. self%k%is_stable()) then
         call failure%report(exit_computation, 'the equilibrium that was found is not stable')
      else if (abs(work - stored) > off_path*max(abs(work), abs(stored))) then
         call failure%report(exit_computation, 'the loads have done work of '//three_digits(work)//' J, of which the material '// &
                             'has stored '//three_digits(stored)//' J: no path of states at rest leads to this equilibrium')
      end if
   end subroutine look_at_path

   !> After the mesh has changed: displacements of its nodes, the means by mass of what the particles around them tell, linear from
   !> where they are, and particles that are moved and strained by these.
   subroutine carry_over(m)
      type(motion_t), intent(inout) :: m
      real(dp), allocatable :: u(:, :), mass(:)
      real(dp) :: shape(corners)
      integer :: i, c, k, d
      allocate (u(ndim, m%grid%n_points), mass(m%grid%n_points), source=0.0_dp)
      associate (p => m%particles, all => m%fields%mass_matrix%all)
         do i = 1, p%n
            shape = shape_functions(local_of(m, i))
            do c = 1, corners
               associate (point => m%grid%element_nodes(c, p%cell(i)))
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
         where (m%constraints%fixed) u(:, :m%grid%n_nodes) = m%constraints%way(m%time)
         call m%grid%dofs%distribute(all, ndim, u)
         p%displacement = 0
         p%gradient = 0
      end associate
      call displace(m, u)
      do k = 1, m%contact%n
         d = m%contact%normal(k)
         m%contact%gap(k) = u(d, m%contact%node(1, k)) - u(d, m%contact%node(2, k))
      end do
   end subroutine carry_over
end module hampm_equilibrium
