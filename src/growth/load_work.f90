!> Work of all loads on a body over a load step of static growth, and the load over its own displacement.
!>
!> Tips advance first, loads follow, on meshes that are cut anew. The work is that of a path on which both change together: the mean
!> of each load at both ends times the change of its work-conjugate displacement, and likewise of moving constraints. It needs the
!> states at both ends only, on any meshes.
module hampm_load_work
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_archive, only: archive_t
   use hampm_failure, only: failure_t
   use hampm_loads, only: load_t, add_load, place_loads
   use hampm_newton, only: work_of
   use hampm_nodal_state, only: nodal_state_t, find_nodal_state
   use hampm_outer_forces, only: find_heat
   use hampm_problem, only: problem_t
   implicit none
   private
   public :: load_state_t, find_load_state, work_between, find_frame, archive_load_state

   !> Loads of a body at an equilibrium.
   type :: load_state_t
      real(dp), allocatable :: factor(:)         !! of each load [-]; then the force that does the work of scaled eigenstrains [J]
      real(dp), allocatable :: energy(:)         !! its force at factor 1 times its displacement [J]; then the factor of these [-]
      real(dp), allocatable :: way(:, :)         !! displacement of each box of a constraint [m], (ndim, boxes)
      real(dp), allocatable :: reaction(:, :)    !! its force on the bodies, 0 where none moves [N], (ndim, boxes)
   end type load_state_t

contains

   !> The present loads of a body.
   subroutine find_load_state(m, state, failure)
      type(problem_t), intent(inout) :: m
      type(load_state_t), intent(out) :: state
      type(failure_t), intent(inout) :: failure
      type(nodal_state_t) :: nodal
      real(dp), allocatable :: force(:, :)
      type(load_t) :: first
      integer :: k
      allocate (state%factor(size(m%loads) + 1), state%energy(size(m%loads) + 1))
      call find_heat(m, state%energy(size(m%loads) + 1), state%factor(size(m%loads) + 1))
      call place_loads(m%loads, m%grid, m%particles)
      do k = 1, size(m%loads)
         state%factor(k) = m%loads(k)%history%factor(m%state%time)
         allocate (force(ndim, m%grid%n_points), source=0.0_dp)
         call add_load(m%loads(k), 1.0_dp, force)
         if (allocated(m%loads(k)%follows)) then ! the work is by the mean of the first force and this, in the plane linear in u
            first = m%loads(k)
            deallocate (first%cofactor)
            call add_load(first, 1.0_dp, force)
            force = force/2
         end if
         call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, force)
         state%energy(k) = work_of(m, force, m%state%displacement)
         deallocate (force)
      end do
      state%way = m%constraints%ways_at(m%state%time)
      state%reaction = 0*state%way
      if (.not. m%constraints%move()) return
      call find_nodal_state(m, nodal, failure, reactions_only=.true.)
      if (.not. failure%failed()) state%reaction = nodal%reactions
   end subroutine find_load_state

   !> The scaled load and its work-conjugate displacement, of forces or else of moving constraints. Of several forces the largest is
   !> the load; of several motions the displacement is the sum: two that open a crack give its opening.
   pure subroutine find_frame(m, state, load_factor, load, displacement)
      type(problem_t), intent(in) :: m
      type(load_state_t), intent(in) :: state    !! now
      real(dp), intent(in) :: load_factor        !! [-]
      real(dp), intent(out) :: load              !! [N]
      real(dp), intent(out) :: displacement      !! [m]
      real(dp) :: unit(ndim, m%constraints%number()), largest
      integer :: k
      largest = 0
      do k = 1, size(m%loads)
         if (.not. m%loads(k)%history%held) largest = max(largest, norm(m%loads(k)%force))
      end do
      load = load_factor*largest
      displacement = 0
      if (largest > 0) displacement = sum(state%energy(:size(m%loads)), mask=.not. m%loads%history%held)/largest
      if (largest > 0) return
      unit = m%constraints%scaled_units()
      displacement = load_factor*sum(sqrt(sum(unit**2, dim=1)))
      load = 0
      if (any(abs(unit) > 0)) load = sum(state%reaction*unit)/sum(sqrt(sum(unit**2, dim=1)))
   end subroutine find_frame

   !> The work from one state to another [J].
   pure real(dp) function work_between(first, last) result(work)
      type(load_state_t), intent(in) :: first, last
      work = sum((first%factor + last%factor)*(last%energy - first%energy))/2 &
             + sum((first%reaction + last%reaction)*(last%way - first%way))/2
   end function work_between

   !> Keep a state.
   subroutine archive_load_state(state, archive)
      type(load_state_t), intent(inout) :: state
      class(archive_t), intent(inout) :: archive
      integer :: n, boxes
      n = 0
      boxes = 0
      if (allocated(state%factor)) n = size(state%factor)
      if (allocated(state%way)) boxes = size(state%way, 2)
      call archive%serialise('number_loads', n)
      call archive%serialise('number_boxes', boxes)
      if (archive%is_read) allocate (state%factor(n), state%energy(n), state%way(ndim, boxes), state%reaction(ndim, boxes))
      call archive%archive_reals('factor', n, state%factor)
      call archive%archive_reals('energy', n, state%energy)
      call archive%archive_reals('way', ndim*boxes, state%way)
      call archive%archive_reals('reaction', ndim*boxes, state%reaction)
   end subroutine archive_load_state
end module hampm_load_work
