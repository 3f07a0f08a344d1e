!> Failure of the bonded points ahead of a moving tip (`hampm_interface_points`), and its energy.
!>
!> A node released at once would ring. A bonded point reached by the tip keeps its force, which then falls
!>
!>   given speed    linearly with the advance of the tip, to 0 after two cells;
!>   toughness      with the opening u since, by -du f/(2 (G A - U)), with the force f, the energy U of the point at the start of
!>                  failure, its area A, the toughness G at the speed of the tip: the dissipation is G times the area of the point.
!>
!> The work of these forces is the fracture term of the energy balance. In a step it is the force acting in it times the mean of the
!> velocities before and after.
module hampm_nodal_release
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_interface_points, only: interfaces_t, interface_point_t, bonded, releasing, along, force_of, energy_of, pulls
   use hampm_interface_placement, only: release_length
   implicit none
   private
   public :: fail_behind, fail_beyond, release_distance, soften_released, work_of_release, foremost_released, holds_on

contains

   !> Start failure of the bonded points that a tip has passed; the force of failing ones falls with its advance and, once it has
   !> stopped, continues to. `taken` is their stored energy.
   pure subroutine fail_behind(interfaces, tip, way, further, taken)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: tip                 !! its number
      real(dp), intent(in) :: way                !! that it has moved so far [m]
      real(dp), intent(in) :: further            !! additional unloading length of forces [m]
      real(dp), intent(out) :: taken             !! [J]
      integer :: k
      taken = 0
      do k = 1, interfaces%n
         if (interfaces%list(k)%tip /= tip .or. interfaces%list(k)%way > way) cycle
         if (interfaces%list(k)%law == bonded) call start_failure(interfaces%list(k), k <= interfaces%n_at_end, taken)
         interfaces%list(k)%fraction_left = min(interfaces%list(k)%fraction_left, &
                                                max(0.0_dp, 1 - (way + further - interfaces%list(k)%way) &
                                                                                  /(release_length*interfaces%list(k)%cell)))
      end do
   end subroutine fail_behind

   !> Start failure of the bonded points of a tip with a traction beyond a strength, up to a position of the tip; beyond it points
   !> hold. `taken` is their stored energy. `overload` is the largest traction over the strength of the points beyond.
   pure subroutine fail_beyond(interfaces, tip, strength, last, taken, overload)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: tip                 !! its number
      real(dp), intent(in) :: strength           !! times the root of the size of the cell [Pa sqrt(m)]
      real(dp), intent(in) :: last               !! path length up to which bonded points fail [m]
      real(dp), intent(out) :: taken             !! [J]
      real(dp), intent(out) :: overload          !! [-]
      real(dp) :: force(ndim), across, traction
      integer :: k
      taken = 0
      overload = 0
      do k = 1, interfaces%n
         if (interfaces%list(k)%tip /= tip .or. interfaces%list(k)%law == releasing) cycle
         force = force_of(as_felt(interfaces%list(k), k <= interfaces%n_at_end))
         across = dot_product(force, interfaces%list(k)%normal)
         force = force - min(across, 0.0_dp)*interfaces%list(k)%normal
         traction = norm(force)/(interfaces%list(k)%area*strength/sqrt(interfaces%list(k)%cell))
         if (interfaces%list(k)%way > last) then
            overload = max(overload, traction)
         else if (traction > 1) then
            call start_failure(interfaces%list(k), k <= interfaces%n_at_end, taken)
         end if
      end do
   end subroutine fail_beyond

   !> A bonded point with the opening that had the force of the last step: its own oscillates about that.
   pure function as_felt(point, at_end) result(felt)
      type(interface_point_t), intent(in) :: point
      logical, intent(in) :: at_end              !! whether its force depends on the step
      type(interface_point_t) :: felt
      felt = point
      if (at_end) felt%opening = point%effective_opening
   end function as_felt

   !> Start failure of a bonded point.
   pure subroutine start_failure(point, at_end, taken)
      type(interface_point_t), intent(inout) :: point
      logical, intent(in) :: at_end              !! whether its force depends on the step
      real(dp), intent(inout) :: taken           !! [J]
      real(dp) :: force(ndim), across, hold, stored
      force = force_of(as_felt(point, at_end))
      stored = energy_of(as_felt(point, at_end))
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
      point%reached = 0
      point%law = releasing
      point%stored = stored - energy_of(point)
      taken = taken + point%stored
   end subroutine start_failure

   !> Length of crack for which the failing bonded points of a tip would now take a toughness, by their opening since the last step
   !> [m]: a point with a part of its force left has taken 1 less the square of this part.
   pure real(dp) function release_distance(interfaces, tip, toughness) result(way)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: tip                 !! its number
      real(dp), intent(in) :: toughness          !! [J/m2]
      integer :: k
      way = 0
      do k = 1, interfaces%n
         if (interfaces%list(k)%tip /= tip .or. interfaces%list(k)%law /= releasing) cycle
         associate (point => interfaces%list(k))
            way = way + point%length*(point%fraction_left**2 - fraction_at(point, toughness)**2)
         end associate
      end do
   end function release_distance

   !> Part of its force that a bonded point keeps now.
   pure real(dp) function fraction_at(point, toughness) result(fraction_left)
      type(interface_point_t), intent(in) :: point
      real(dp), intent(in) :: toughness          !! [J/m2]
      real(dp) :: further, all
      fraction_left = point%fraction_left
      if (.not. fraction_left > 0) return
      associate (held => norm(point%initial_force))
         all = 2*(toughness*point%area - point%stored)
         if (.not. (held > 0 .and. all > 0)) then
            fraction_left = 0
            return
         end if
         further = opening_along(point) - point%reached
         if (further > 0) fraction_left = max(0.0_dp, fraction_left - held*further/all)
      end associate
   end function fraction_at

   !> Opening of a bonded point along its force since its failure [m].
   pure real(dp) function opening_along(point) result(opening)
      type(interface_point_t), intent(in) :: point
      opening = dot_product(point%opening - point%start, point%initial_force)/norm(point%initial_force)
   end function opening_along

   !> Let the forces of failing bonded points follow their openings, at a toughness. `has_parted` tells whether any has lost all of
   !> its force.
   pure subroutine soften_released(interfaces, tip, toughness, has_parted)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: tip                 !! its number
      real(dp), intent(in) :: toughness          !! [J/m2]
      logical, intent(out) :: has_parted
      integer :: k
      has_parted = .false.
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%tip /= tip .or. point%law /= releasing) cycle
            point%fraction_left = fraction_at(point, toughness)
            if (norm(point%initial_force) > 0) point%reached = max(point%reached, opening_along(point))
            has_parted = has_parted .or. .not. point%fraction_left > 0
         end associate
      end do
   end subroutine soften_released

   !> Work of the forces of failing bonded points in a step [J]; with the forces at its start if `start` is given.
   pure real(dp) function work_of_release(interfaces, before, after, dt, start) result(work)
      type(interfaces_t), intent(in) :: interfaces
      real(dp), intent(in) :: before(:, :), after(:, :) !! velocities of the nodes that the forces of the step have changed [m/s],
                                                 !! (ndim, n_points)
      real(dp), intent(in) :: dt                 !! [s]
      type(interfaces_t), intent(in), optional :: start
      real(dp) :: way(ndim), force(ndim)
      integer :: k, j
      work = 0
      do k = 1, interfaces%n
         if (interfaces%list(k)%law /= releasing) cycle
         force = failing_force(interfaces%list(k))
         if (present(start)) force = failing_force(start%list(k))
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

   !> Rest of the force of a failing bonded point, without contact; the whole force of an intact one [N].
   pure function failing_force(point) result(force)
      type(interface_point_t), intent(in) :: point
      real(dp) :: force(ndim)
      force = force_of(point)
      if (point%law == releasing) force = point%fraction_left*point%initial_force
   end function failing_force

   !> Whether any bonded point on the path of a tip still holds.
   pure logical function holds_on(interfaces, tip)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: tip                 !! its number
      integer :: k
      holds_on = any([(interfaces%list(k)%tip == tip .and. pulls(interfaces%list(k)), k=1, interfaces%n)])
   end function holds_on

   !> Distance of the foremost failing bonded point along the path of a tip [m]; 0 if there is none.
   pure real(dp) function foremost_released(interfaces, tip) result(way)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: tip                 !! its number
      integer :: k
      way = 0
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%tip == tip .and. point%law == releasing) way = max(way, point%way + point%length/2)
         end associate
      end do
   end function foremost_released
end module hampm_nodal_release
