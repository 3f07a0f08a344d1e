!> Balance of the forces on a body at the end of a step: internal forces, loads and, in motion, inertia, with faces and supports in
!> contact. Static equilibrium (`hampm_equilibrium`) and implicit steps (`hampm_newmark`) are two kinds of such steps.
!>
!> Newton's iteration (`hampm_newton`) solves it. An active-set iteration finds the pairs of nodes on faces, and the nodes on
!> unilateral supports, that are pressed: tie where they would overlap, release where they would pull; all at once or, if that
!> cycles, one by one in the order of their numbers, which ends for a convex potential (Murty 1974). If that fails, a step is
!> divided: each part is half as long as the last attempt, which leaves nothing behind: laws with a history go on from the state
!> of the last part in balance.
!>
!> Source: Wriggers, Nonlinear Finite Element Methods (2008), chapter 10 (active sets); Judice & Pires, Comput. Oper. Res. 21 (1994)
!> 587-596 (block principal pivoting, with Murty's method where it cycles).
module hampm_balance
   use hampm_kinds, only: dp, ndim
   use hampm_carried_forces, only: carry_forces
   use hampm_interface_points, only: commit_slip, have_friction
   use hampm_failure, only: failure_t, exit_computation
   use hampm_instant, only: instant_t, save_instant, go_back_to
   use hampm_integrator, only: integrator_t
   use hampm_nearby, only: nearby_t
   use hampm_problem, only: problem_t, stored_energy, dissipated_energy, archive_history
   use hampm_newton, only: newton_t, residual, largest_force, displace
   use hampm_outer_forces, only: outer_forces_t
   use hampm_rigid_motions, only: rigid_constraint_t, find_rigid_constraints, free_motions_t, find_free_motions, &
                                  take_motion_as_whole
   use hampm_supports, only: find_wrong_supports, turn_supports
   use hampm_text, only: to_text, three_digits
   use hampm_error_context, only: when
   implicit none
   private
   public :: balance_t, start_t, part_t, is_linear, is_in_touch

   integer, parameter :: most_turns = 200        !! of the faces that touch
   integer, parameter :: most_in_vain = 10       !! of these that leave no fewer wrong, after which nodes change one by one
   integer, parameter :: most_for_path = 6       !! divisions of a step to find how faces or supports open or close in it
   real(dp), parameter :: pulls = 3.1e-9_dp      !! force between faces, over the largest of a cell, from which on they part

   !> Integration by steps whose forces are balanced at their ends.
   type, abstract, extends(integrator_t) :: balance_t
      type(newton_t) :: newton
      type(outer_forces_t) :: outer              !! in the step that is tried
      type(free_motions_t), allocatable :: free  !! motions as a whole on this mesh, once they were asked for
      real(dp), allocatable :: moved(:, :)       !! displacement of the nodes in it [m], (ndim, n_points)
      logical :: carries = .false.               !! whether faces carry forces without an opening of their layer: at rest, where no
                                                 !! motion follows
   contains
      procedure :: advance_to
      procedure :: with_contact
      procedure :: finish
      procedure(attempt_increment), deferred :: attempt_increment
      procedure :: accept_increment
      procedure(most_divisions), deferred :: most_divisions
      procedure(likely_cause), deferred :: likely_cause
   end type balance_t

   !> A part of a step.
   type :: part_t
      real(dp) :: from = 0, to = 0               !! of the step [-]
      real(dp) :: end = 0                        !! time at its end [s]
      real(dp) :: length = 0                     !! [s]
   end type part_t

   !> State at the start of a part of a step, to return to.
   type :: start_t
      type(instant_t) :: instant
      real(dp) :: stored = 0                     !! strain energy and dissipation so far [J]
   end type start_t

   abstract interface
      !> Attempt a part of a step. Fails where no balance is found; `needs_subincrements` where shorter parts had better lead to it.
      subroutine attempt_increment(self, m, part, start, needs_subincrements, failure)
         import :: balance_t, problem_t, part_t, start_t, failure_t
         class(balance_t), intent(inout) :: self
         type(problem_t), intent(inout) :: m
         type(part_t), intent(in) :: part
         type(start_t), intent(in) :: start      !! state at its start
         logical, intent(out) :: needs_subincrements
         type(failure_t), intent(inout) :: failure
      end subroutine attempt_increment

      !> How often a step that fails is divided into two; 0 where parts of it would fail too.
      pure integer function most_divisions(self, m)
         import :: balance_t, problem_t
         class(balance_t), intent(in) :: self
         type(problem_t), intent(in) :: m
      end function most_divisions

      !> In words: why parts of a step fail too.
      function likely_cause(self) result(text)
         import :: balance_t
         class(balance_t), intent(in) :: self
         character(:), allocatable :: text
      end function likely_cause
   end interface

contains

   !> Follow a step from the present time of the motion to another, in one part or in several. Fails where that is not found.
   subroutine advance_to(self, m, time, failure)
      class(balance_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: time               !! at its end [s]
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: none
      type(start_t) :: start
      real(dp) :: done, length
      integer :: divisions
      logical :: needs_subincrements
      done = 0
      length = 1
      divisions = 0
      do while (done < 1)
         none = failure_t()
         if (.not. is_linear(m)) then
            start%stored = stored_energy(m) + dissipated_energy(m) + m%interfaces%loss
            call save_instant(m, start%instant)
         end if
         associate (part => part_t(done, done + length, m%state%time + (done + length)*(time - m%state%time), &
                                   length*(time - m%state%time)))
            call self%attempt_increment(m, part, start, needs_subincrements, none)
            if (none%failed() .or. needs_subincrements .and. divisions < most_for_path) then
               divisions = divisions + 1
               length = length/2
               if (none%failed() .and. divisions > self%most_divisions(m)) exit
               call go_back(m, start)
            else
               call archive_history(m)
               call self%accept_increment(m, part)
               done = done + length
               length = min(2*length, 1 - done)
               divisions = max(0, divisions - 1)
            end if
         end associate
      end do
      if (.not. none%failed()) then
         m%state%time = time
         return
      end if
      none%message = when(m%state%steps, time)//none%message
      if (self%most_divisions(m) > 0) none%message = none%message//'. It was followed through '//three_digits(100*done)// &
         ' % of this load step, with '//to_text(self%newton%solutions)//' solutions so far. Likely cause: '//self%likely_cause()
      call failure%report(exit_computation, none%message)
   end subroutine advance_to

   !> A part of a step has been followed. Here nothing.
   subroutine accept_increment(self, m, part)
      class(balance_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(part_t), intent(in) :: part
   end subroutine accept_increment

   !> Release the memory of the matrix.
   subroutine finish(self)
      class(balance_t), intent(inout) :: self
      call self%newton%release()
   end subroutine finish

   !> Whether faces or supports may open and close.
   pure logical function is_in_touch(m)
      type(problem_t), intent(in) :: m
      is_in_touch = m%interfaces%n_contact > 0 .or. m%constraints%only_push()
   end function is_in_touch

   !> Whether internal forces are linear in the displacement, so that one solution is a step.
   pure logical function is_linear(m)
      type(problem_t), intent(in) :: m
      is_linear = all(m%materials%linear) .and. .not. is_in_touch(m) .and. m%interfaces%n_cohesive == 0
   end function is_linear

   !> Balance the forces of a step after a time with faces and supports in contact, history-dependent material relaxed before any
   !> displacement. Fails where no balance is found.
   subroutine with_contact(self, m, time_increment, shift, failure)
      class(balance_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: time_increment     !! [s]
      real(dp), intent(in) :: shift(:, :)        !! displacement of fixed components [m], (ndim, n_nodes)
      type(failure_t), intent(inout) :: failure
      type(rigid_constraint_t), allocatable :: rigid_constraints(:)
      integer :: turn, wrong, fewest, in_vain    ! numbers of nodes and of turns
      call add_rigid_constraints(self, m, rigid_constraints)
      if (any(m%materials%has_history)) then
         m%materials%time_increment = time_increment
         call displace(m, 0*self%moved)
      end if
      m%constraints%lift = m%constraints%lift - shift
      fewest = huge(fewest)
      in_vain = 0
      do turn = 1, most_turns
         if (allocated(self%newton%predicted)) deallocate (self%newton%predicted)
         call self%newton%balance(m, self%outer, shift, rigid_constraints, self%moved, failure)
         if (failure%failed()) return
         call change_touch(self, m, in_vain > most_in_vain, rigid_constraints, wrong)
         if (wrong == 0) then
            call stiffen_faces(self, m, shift, rigid_constraints, failure)
            if (failure%failed()) return
            call commit_slip(m%interfaces)
            call keep_place(self, m, pack(rigid_constraints, rigid_constraints%motion <= ndim .or. &
                                                             .not. any(m%materials%is_finite)))
            return
         end if
         in_vain = merge(0, in_vain + 1, wrong < fewest)
         fewest = min(fewest, wrong)
      end do
      call failure%report(exit_computation, 'the contact state of faces or supports was not found: the iteration of '// &
                          'active nodes does not end')
   end subroutine with_contact

   !> Take from the displacement what moves bodies as a whole where nothing holds them: nodes that stand in for constraints would
   !> choose it. The centre of mass stays, and nothing turns in the mean by mass. Large strain knows no small turning: there only
   !> motions along an axis are given.
   subroutine keep_place(self, m, rigid_constraints)
      class(balance_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      type(rigid_constraint_t), intent(in) :: rigid_constraints(:)
      real(dp), allocatable :: settled(:, :)     ! [m], (ndim, n_points)
      if (size(rigid_constraints) == 0) return
      if (allocated(self%free)) then
         if (.not. are_same(self%free%rigid_constraints, rigid_constraints)) deallocate (self%free)
      end if
      if (.not. allocated(self%free)) then
         allocate (self%free)
         call find_free_motions(m, self%free, rigid_constraints)
      end if
      settled = self%moved
      call take_motion_as_whole(self%free, settled)
      if (allocated(self%newton%predicted)) call take_motion_as_whole(self%free, self%newton%predicted) ! both are compared
      call displace(m, settled - self%moved)
      self%moved = settled

   contains

      !> Whether constraints are of the same nodes and motions.
      pure logical function are_same(a, b)
         type(rigid_constraint_t), intent(in) :: a(:), b(:)
         are_same = size(a) == size(b)
         if (are_same) are_same = all(a%node == b%node .and. a%motion == b%motion)
      end function are_same
   end subroutine keep_place

   !> Balance the forces again until the layer between faces in contact does not give way at rest (augmented Lagrangian, Uzawa's
   !> method), friction slides where mean tractions reach its cone, and forces depend on those before by less than a load that is
   !> searched may (`hampm_load_search`).
   !> Source: Simo & Laursen, Comput. Struct. 42 (1992) 97-116.
   subroutine stiffen_faces(self, m, shift, rigid_constraints, failure)
      class(balance_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: shift(:, :)        !! displacement of fixed components [m], (ndim, n_nodes)
      type(rigid_constraint_t), intent(in) :: rigid_constraints(:)
      type(failure_t), intent(inout) :: failure
      integer, parameter :: most = 30
      real(dp), parameter :: hardly = 1e-6_dp    ! change of the carried forces, relative
      type(nearby_t) :: near                     ! points stay where they are
      real(dp) :: change
      integer :: turn
      if (m%interfaces%n_contact == 0 .or. .not. (self%carries .or. have_friction(m%interfaces))) return
      do turn = 1, merge(most, 1, self%carries)  ! in motion it goes on in the next step
         call carry_forces(m%interfaces, near, self%carries, .false., change)
         if (.not. change > merge(0.0_dp, hardly, self%carries)) return
         call self%newton%balance(m, self%outer, shift, rigid_constraints, self%moved, failure)
         if (failure%failed() .or. change <= hardly) return
      end do
   end subroutine stiffen_faces

   !> Find the constraints of rigid-body modes: those with inertia need nothing to hold them.
   subroutine add_rigid_constraints(self, m, rigid_constraints)
      class(balance_t), intent(in) :: self
      type(problem_t), intent(inout) :: m
      type(rigid_constraint_t), allocatable, intent(inout) :: rigid_constraints(:)
      if (.not. self%outer%mass_factor > 0) then
         call find_rigid_constraints(m, rigid_constraints)
      else if (.not. allocated(rigid_constraints)) then
         allocate (rigid_constraints(0))
      end if
   end subroutine add_rigid_constraints

   !> Hold nodes that would penetrate their support, and release those that pull. If a body would then be free only the support that
   !> pulls most is released.
   subroutine change_touch(self, m, one_only, rigid_constraints, n_wrong)
      class(balance_t), intent(inout) :: self
      type(problem_t), intent(inout) :: m
      logical, intent(in) :: one_only            !! whether only the last one that is wrong changes
      type(rigid_constraint_t), allocatable, intent(inout) :: rigid_constraints(:)
      integer, intent(out) :: n_wrong            !! how many did touch or not as they should not
      real(dp), allocatable :: r(:, :), pull(:, :)
      logical, allocatable :: wrong(:, :)
      real(dp) :: rounding
      integer :: last(2), n_before
      n_wrong = 0
      if (.not. m%constraints%only_push()) return
      call residual(m, self%outer, self%moved, r)
      rounding = pulls*largest_force(m, r)
      call find_wrong_supports(m, r, rounding, wrong, pull)
      n_wrong = count(wrong)
      if (n_wrong == 0) return
      if (one_only) then
         last = findloc(wrong, .true., back=.true.)
         wrong = .false.
         wrong(last(1), last(2)) = .true.
      end if
      n_before = size(rigid_constraints)
      call turn_supports(m%constraints, wrong)
      call add_rigid_constraints(self, m, rigid_constraints)
      if (size(rigid_constraints) > n_before) then
         call turn_supports(m%constraints, wrong)
         wrong = wrong .and. (pull >= maxval(pull, mask=wrong) .or. .not. m%constraints%fixed)
         call turn_supports(m%constraints, wrong)
         call add_rigid_constraints(self, m, rigid_constraints)
      end if
   end subroutine change_touch

   !> Go back to where it began, with the forces there.
   subroutine go_back(m, start)
      type(problem_t), intent(inout) :: m
      type(start_t), intent(in) :: start
      real(dp), allocatable :: stay(:, :)
      allocate (stay(ndim, m%grid%n_points))
      call go_back_to(start%instant, m)
      stay = 0
      m%materials%time_increment = 0
      call displace(m, stay)
   end subroutine go_back
end module hampm_balance
