!> Failure of the bonded points ahead of a moving tip (`hampm_interface_points`), and its energy.
!>
!> A node released at once would ring. A bonded point reached by the tip keeps its force, which then falls linearly with the
!> advance of the tip, to 0 after two cells.
!>
!> The work of these forces is the fracture term of the energy balance. In a step it is the force acting in it times the mean of the
!> velocities before and after.
module hampm_nodal_release
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_interface_points, only: interfaces_t, interface_point_t, bonded, releasing, along, force_of, energy_of, stretch_of, &
                                     pulls, is_softening
   use hampm_moving_tip, only: release_length
   implicit none
   private
   public :: fail_behind, let_fail, scale_failing, work_of_release, holds_on

contains

   !> Start failure of the bonded points that a tip has passed; the force of failing ones falls with its advance and, once it has
   !> stopped, continues to. `taken` is the stored energy of those that start, `work` that and the work of all since the last call.
   pure subroutine fail_behind(interfaces, tip, way, further, taken, work)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: tip                 !! its number
      real(dp), intent(in) :: way                !! that it has moved so far [m]
      real(dp), intent(in) :: further            !! additional unloading length of forces [m]
      real(dp), intent(out) :: taken             !! [J]
      real(dp), intent(out), optional :: work    !! [J]
      real(dp) :: done
      integer :: k
      taken = 0
      done = 0
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%tip /= tip .or. point%way > way) cycle
            call let_fail(point, max(0.0_dp, 1 - (way + further - point%way)/(release_length*point%cell)), &
                          k <= interfaces%n_at_end, taken, done)
         end associate
      end do
      if (present(work)) work = done
   end subroutine fail_behind

   !> Leave a bonded point a part of its force at most. Added to `taken` is the stored energy if it starts to fail, and to `work`
   !> that and the work of its force since the last call.
   pure subroutine let_fail(point, part, at_end, taken, work)
      type(interface_point_t), intent(inout) :: point
      real(dp), intent(in) :: part               !! [-]
      logical, intent(in) :: at_end              !! whether its force depends on the step
      real(dp), intent(inout) :: taken, work     !! [J]
      real(dp) :: before, opening
      if (point%law == bonded) then
         call start_failure(point, at_end)
         taken = taken + point%stored
         work = work + point%stored
      end if
      before = point%fraction_left
      point%fraction_left = min(before, part)
      opening = dot_product(point%opening - point%start, point%initial_force)/max(norm(point%initial_force), tiny(opening))
      work = work + (before + point%fraction_left)/2*norm(point%initial_force)*(opening - point%reached)
      point%reached = opening
   end subroutine let_fail

   !> Scale the forces of the failing points behind a tip.
   pure subroutine scale_failing(interfaces, tip, factor)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: tip                 !! its number
      real(dp), intent(in) :: factor             !! [-]
      integer :: k
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%tip == tip .and. is_softening(point)) point%initial_force = factor*point%initial_force
         end associate
      end do
   end subroutine scale_failing

   !> A bonded point with the opening that had the force of the last step: its own oscillates about that.
   pure function as_felt(point, at_end) result(felt)
      type(interface_point_t), intent(in) :: point
      logical, intent(in) :: at_end              !! whether its force depends on the step
      type(interface_point_t) :: felt
      felt = point
      if (at_end) felt%opening = point%effective_opening
   end function as_felt

   !> Energy stored by a bonded point in explicit steps, whose velocities belong to the middles of steps: the work of its forces up
   !> to that of the last step [J].
   pure real(dp) function energy_between(point) result(energy)
      type(interface_point_t), intent(in) :: point
      type(interface_point_t) :: then
      then = point
      then%opening = point%before
      associate (before => stretch_of(then), after => stretch_of(point))
         energy = point%stored + dot_product(point%initial_force, before + after)/2 + point%stiffness*dot_product(before, after)/2
      end associate
   end function energy_between

   !> Start failure of a bonded point.
   pure subroutine start_failure(point, at_end)
      type(interface_point_t), intent(inout) :: point
      logical, intent(in) :: at_end              !! whether its force depends on the step
      real(dp) :: force(ndim), across, hold, stored
      force = force_of(as_felt(point, at_end))
      stored = energy_of(as_felt(point, at_end))
      if (at_end .and. point%plane > 0) stored = energy_between(point) ! of tips the frames would differ by more
      if (point%line > 0) then                  ! pressure stays, and friction
         across = min(0.0_dp, dot_product(force, point%normal))
         hold = dot_product(force, along(point))
         hold = sign(min(abs(hold), -point%friction*across), hold)
         force = force - across*point%normal - hold*along(point)
         point%contact_offset = 0
         if (across < 0) point%contact_offset = dot_product(point%normal, point%opening) - across/point%stiffness
         point%slip = dot_product(along(point), point%opening) - hold/point%stiffness
         point%slid = point%slip
         point%pressed = -across/point%stiffness
      end if
      point%initial_force = force
      point%start = point%opening
      point%law = releasing
      point%stored = stored - energy_of(point)
      point%reached = 0
   end subroutine start_failure

   !> Work of the forces of failing bonded points in a step [J]: of those of an implicit one with the mean of its start and its end.
   pure real(dp) function work_of_release(interfaces, before, after, dt, is_implicit) result(work)
      type(interfaces_t), intent(in) :: interfaces
      real(dp), intent(in) :: before(:, :), after(:, :) !! velocities of the nodes that the forces of the step have changed [m/s],
                                                 !! (ndim, n_points)
      real(dp), intent(in) :: dt                 !! [s]
      logical, intent(in) :: is_implicit
      real(dp) :: way(ndim), force(ndim)
      integer :: k, j
      work = 0
      do k = 1, interfaces%n
         if (interfaces%list(k)%law /= releasing) cycle
         associate (point => interfaces%list(k))
            force = merge((point%fraction_before + point%fraction_left)/2, point%fraction_left, is_implicit)*point%initial_force
         end associate
         if (.not. any(abs(force) > 0)) cycle
         way = 0
         do j = 1, count(interfaces%list(k)%jump%node > 0)
            associate (node => interfaces%list(k)%jump%node(j))
               way = way + dt*interfaces%list(k)%jump%share(j)*(before(:, node) + after(:, node))/2
            end associate
         end do
         work = work + dot_product(force, way)
      end do
   end function work_of_release

   !> Whether any bonded point on the path of a tip still holds.
   pure logical function holds_on(interfaces, tip, crack)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: tip, crack          !! their numbers; fronts of a crack of a solid hold on together
      integer :: k
      holds_on = any([((interfaces%list(k)%tip == tip .or. interfaces%list(k)%plane == crack) .and. &
                       pulls(interfaces%list(k)), k=1, interfaces%n)])
   end function holds_on
end module hampm_nodal_release
