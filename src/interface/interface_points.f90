!> Laws of interface points: the force across their opening g, on node j -c_j f(g).
!>
!> `bonded`: springs ahead of a tip in the cell where a crack ends, which is cut as a whole; ahead of a moving tip they begin with
!> the traction of the material, and are `releasing` once the tip has reached them (`hampm_nodal_release`). On a symmetry plane a
!> half point has the displacement of the face as g, a normal force only, and the energy of the half. `contact`: a penalty against
!> overlap by the layer of a third of a cell, friction by return mapping; with given limits (`hold_friction`) the potential is
!> convex. `ghost`: ghost penalty (`hampm_ghost_penalty`), with a mass m at the rate w of the jump: momentum m c_j w of node j, dw =
!> c.a dt, mass matrix m c c^T. `cohesive`: a traction-separation law in series with the layer (`hampm_cohesive_law`), then contact.
!> `support`: a node held in part along the normal (`hampm_part_supports`). Source: Wriggers, Computational Contact Mechanics
!> (2006), sections 5.2 (penalty), 10.5 (return mapping).
module hampm_interface_points
   use hampm_kinds, only: dp, ndim
   use hampm_cohesive_law, only: cohesive_state_t
   use hampm_interface_point, only: interfaces_t, interface_point_t, face_state_t, bonded, releasing, contact, ghost, cohesive, &
                                    support, is_half, along, along_faces, length_along, in_direction_of, direction_of, &
                                    components_of, vector_of, turned, interpolated, add_interface_point, find_points, &
                                    find_points_at_tip, sort_for_tips, archive_interfaces
   use hampm_jumps, only: jump_t, jump_of, give_nodes
   use hampm_tensors, only: in_plane
   implicit none
   private
   public :: interfaces_t, interface_point_t, face_state_t, bonded, releasing, contact, ghost, cohesive, support, is_half, along, &
             along_faces, length_along, direction_of, components_of, vector_of, turned, interpolated, add_interface_point, &
             find_points, find_points_at_tip, sort_for_tips, archive_interfaces
   public :: stretch_of, holds, pulls, are_apart, is_free, is_pressed, is_softening, has_force, overlap_of, sliding_of, &
             slid_in_all, have_friction, hold_friction, is_sliding, cohesion_at, force_of, force_at, face_force, &
             add_interface_forces, forces_of_penalty_contact, add_interface_resistance, interface_states, interface_stiffness, &
             stiffness_in_directions, energy_of, interface_energy, commit_slip, stretch_interfaces, open_interfaces, &
             relax_interfaces, ease_faces, jumps_with_mass, add_interface_momentum, kick_interfaces, energy_of_rates

   integer, parameter :: is_open = 0, sticks = 1, slides = 2 !! states of faces
   integer, parameter :: sticks_apart = 3        !! and with given friction limits: separate faces held along

contains

   !> Stretch of a bonded point since it began [m].
   pure function stretch_of(point) result(stretch)
      type(interface_point_t), intent(in) :: point
      real(dp) :: stretch(ndim)
      stretch = point%opening - point%start
      if (is_half(point)) stretch = dot_product(stretch, point%normal)*point%normal
   end function stretch_of

   !> Whether cohesion holds the faces at an interface point.
   pure logical function holds(point)
      type(interface_point_t), intent(in) :: point
      holds = point%law == cohesive .and. point%damage < 1
   end function holds

   !> Whether the faces at an interface point still pull on each other, by cohesion or as bonded points.
   pure logical function pulls(point)
      type(interface_point_t), intent(in) :: point
      pulls = holds(point) .or. any(point%law == [bonded, releasing]) .and. point%fraction_left > 0
   end function pulls

   !> Whether a bonded point that has begun to fail still pulls, and its faces do not press on each other.
   pure logical function is_softening(point)
      type(interface_point_t), intent(in) :: point
      is_softening = point%law == releasing .and. point%fraction_left > 0
      if (is_softening) is_softening = overlap_of(point) < 0
   end function is_softening

   !> Whether an interface point is one of faces that are free to part.
   pure logical function is_free(point)
      type(interface_point_t), intent(in) :: point
      is_free = any(point%law == [contact, releasing]) .or. point%law == cohesive .and. .not. holds(point)
   end function is_free

   !> Whether an interface point is between faces that no bonded point has held, or none since cohesion did.
   pure logical function are_apart(point)
      type(interface_point_t), intent(in) :: point
      are_apart = is_free(point) .and. point%law /= releasing
   end function are_apart

   !> State of an interface point.
   pure integer function state_of(point) result(state)
      type(interface_point_t), intent(in) :: point
      logical :: holds
      state = sticks
      if (.not. is_free(point)) return
      holds = point%friction > 0
      if (holds) holds = length_along(sliding_of(point)) <= limit_of(point)
      if (.not. holds) state = slides
      if (overlap_of(point) < 0) state = merge(sticks_apart, is_open, holds .and. point%friction_limit >= 0)
   end function state_of

   !> Whether the faces at a point hold or press on each other: by cohesion, a releasing point or contact, not as bonded ones.
   pure logical function has_force(point)
      type(interface_point_t), intent(in) :: point
      has_force = holds(point) .or. is_softening(point)
      if (.not. has_force .and. is_free(point)) has_force = state_of(point) /= is_open
   end function has_force

   !> Opening of the faces that gives their force [m].
   pure function opening_of_faces(point) result(opening)
      type(interface_point_t), intent(in) :: point
      real(dp) :: opening(ndim)
      opening = point%opening
      if (point%law == contact) opening = opening - point%start + point%carried
   end function opening_of_faces

   !> Overlap of the faces; below 0 where they are separate [m].
   pure real(dp) function overlap_of(point) result(overlap)
      type(interface_point_t), intent(in) :: point
      overlap = point%contact_offset - dot_product(point%normal, opening_of_faces(point))
   end function overlap_of

   !> Sliding of the faces from their place without a force along them [m].
   pure function sliding_of(point) result(sliding)
      type(interface_point_t), intent(in) :: point
      real(dp) :: sliding(ndim - 1)
      sliding = along_faces(point, opening_of_faces(point)) - point%slip
   end function sliding_of

   !> Friction limit over the stiffness [m].
   pure real(dp) function limit_of(point) result(limit)
      type(interface_point_t), intent(in) :: point
      limit = point%friction*max(overlap_of(point), 0.0_dp) + merge(point%spare, 0.0_dp, overlap_of(point) > 0)
      if (point%friction_limit >= 0) limit = point%friction_limit
   end function limit_of

   !> Whether an interface point is for contact and its faces press on each other.
   pure logical function is_pressed(point)
      type(interface_point_t), intent(in) :: point
      is_pressed = point%law == contact .and. has_force(point)
   end function is_pressed

   !> Whether the faces at an interface point press on each other and slide.
   pure logical function is_sliding(point)
      type(interface_point_t), intent(in) :: point
      is_sliding = is_free(point)
      if (is_sliding) is_sliding = state_of(point) == slides
   end function is_sliding

   !> Resistance of faces in contact to separation [N].
   pure function face_force(point) result(force)
      type(interface_point_t), intent(in) :: point
      real(dp) :: force(ndim), held(ndim - 1)
      held = sliding_of(point)
      held = in_direction_of(held, min(limit_of(point), length_along(held)))
      force = point%stiffness*(held(1)*along(point) - max(overlap_of(point), 0.0_dp)*point%normal)
      if (ndim > 2) force = force + point%stiffness*held(ndim - 1)*direction_of(point, ndim)
   end function face_force

   !> Limit friction by the present pressure, independent of its changes.
   pure subroutine hold_friction(interfaces)
      type(interfaces_t), intent(inout) :: interfaces
      integer :: k
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            point%friction_limit = -1
            point%friction_limit = limit_of(point)
         end associate
      end do
   end subroutine hold_friction

   !> Whether there is friction.
   pure logical function have_friction(interfaces)
      type(interfaces_t), intent(in) :: interfaces
      have_friction = interfaces%n > 0
      if (have_friction) have_friction = any(interfaces%list(:interfaces%n)%friction > 0)
   end function have_friction

   !> States of all interface points: a factorised matrix fits as long as they stay.
   pure function interface_states(interfaces) result(states)
      type(interfaces_t), intent(in) :: interfaces
      integer, allocatable :: states(:)
      integer :: k
      allocate (states(interfaces%n))
      states = [(state_of(interfaces%list(k)), k=1, interfaces%n)]
   end function interface_states

   !> Response of the law of the k-th, a cohesive point, to its opening, for all of its area: tractions as forces [N], tangents
   !> [N/m], energies [J]. A half point has twice its opening, the layer of both halves, and half of the energies.
   pure type(cohesive_state_t) function cohesion_at(interfaces, k) result(answer)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: k
      real(dp) :: halves
      associate (point => interfaces%list(k), area => interfaces%list(k)%area)
         halves = merge(2, 1, is_half(point))
         answer = interfaces%cohesion(point%cohesion)%respond( &
                  halves*in_plane(dot_product(along(point), stretch_of(point)), dot_product(point%normal, point%opening)), &
                  point%stiffness/area/halves, point%damage, point%dissipated)
         answer%traction = area*answer%traction
         answer%tangent = area*halves*answer%tangent
         answer%secant = area*halves*answer%secant
         answer%stored = area/halves*answer%stored
         answer%taken = area/halves*answer%taken
         if (is_half(point)) answer%secant(1, 1) = 0
      end associate
   end function cohesion_at

   !> Resistance of the k-th interface point to its opening [N].
   pure function force_at(interfaces, k) result(force)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: k
      real(dp) :: force(ndim)
      type(cohesive_state_t) :: answer
      associate (point => interfaces%list(k))
         if (holds(point)) then
            answer = cohesion_at(interfaces, k)
            force = answer%traction(1)*along(point) + answer%traction(2)*point%normal
         else
            force = force_of(point)
         end if
      end associate
   end function force_at

   !> Resistance of an interface point without cohesion to its opening [N].
   pure function force_of(point) result(force)
      type(interface_point_t), intent(in) :: point
      real(dp) :: force(ndim)
      if (.not. is_free(point)) then
         force = point%initial_force + point%stiffness*stretch_of(point)
      else
         force = face_force(point)
         if (point%law == releasing) force = force + point%fraction_left*point%initial_force
      end if
   end function force_of

   !> Change of the force of the k-th with its opening, without the unsymmetric change of friction with pressure [N/m].
   pure function interface_stiffness(interfaces, k) result(tangent)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: k
      real(dp) :: tangent(ndim, ndim), axes(ndim, ndim)
      integer :: d
      do d = 1, ndim
         axes(:, d) = direction_of(interfaces%list(k), d)
      end do
      tangent = matmul(axes, matmul(stiffness_in_directions(interfaces, k), transpose(axes)))
   end function interface_stiffness

   !> The same of the components of the force with those of the opening, in the directions of the point [N/m].
   pure function stiffness_in_directions(interfaces, k) result(tangent)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: k
      real(dp) :: tangent(ndim, ndim)
      type(cohesive_state_t) :: answer
      real(dp) :: sliding(ndim - 1), turning
      integer :: state
      tangent = 0
      associate (point => interfaces%list(k), tangent_floor => interfaces%tangent_floor)
         if (holds(point)) then
            answer = cohesion_at(interfaces, k)
            tangent(:2, :2) = (1 - tangent_floor)*answer%tangent(2:1:-1, 2:1:-1) + tangent_floor*answer%secant(2:1:-1, 2:1:-1)
         else
            state = state_of(point)
            if (point%law /= contact .and. state == is_open) return
            tangent(1, 1) = point%stiffness*merge(1.0_dp, tangent_floor, state == sticks .or. state == slides)
            tangent(2, 2) = point%stiffness*merge(1.0_dp, tangent_floor, state == sticks .or. state == sticks_apart)
         end if
         if (is_half(point)) tangent(2, 2) = 0
         if (ndim > 2) then
            tangent(ndim, ndim) = tangent(2, 2)
            if (point%friction > 0 .and. state == slides) then ! the force turns with the sliding
               sliding = sliding_of(point)
               turning = (1 - tangent_floor)*point%stiffness*limit_of(point)/length_along(sliding)
               sliding = sliding/length_along(sliding)
               tangent(2, 2) = tangent(2, 2) + turning*(1 - sliding(1)**2)
               tangent(ndim, ndim) = tangent(ndim, ndim) + turning*(1 - sliding(ndim - 1)**2)
               tangent(2, ndim) = -turning*sliding(1)*sliding(ndim - 1)
               tangent(ndim, 2) = tangent(2, ndim)
            end if
         end if
         if (point%is_penalty) tangent = interfaces%weight*tangent
      end associate
   end function stiffness_in_directions

   !> Add the forces of the interface points from the `first` on, to the `last` one where that is given, on the nodes [N].
   pure subroutine add_interface_forces(interfaces, first, force, last)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: first
      real(dp), intent(inout) :: force(:, :)     !! (ndim, n_points)
      integer, intent(in), optional :: last
      integer :: k, to
      to = interfaces%n
      if (present(last)) to = last
      do k = first, to
         call give_nodes(interfaces%list(k)%jump, &
                         -merge(interfaces%weight, 1.0_dp, interfaces%list(k)%is_penalty)*force_at(interfaces, k), force)
      end do
   end subroutine add_interface_forces

   !> The forces on the nodes of penalty faces alone [N].
   pure function forces_of_penalty_contact(interfaces, n_points) result(force)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: n_points            !! of the grid
      real(dp) :: force(ndim, n_points)
      integer :: k
      force = 0
      do k = 1, interfaces%n
         if (interfaces%list(k)%is_penalty) call give_nodes(interfaces%list(k)%jump, -force_of(interfaces%list(k)), force)
      end do
   end function forces_of_penalty_contact

   !> Add the resistance of interface points, in their present state, to a small displacement of the nodes [N].
   pure subroutine add_interface_resistance(interfaces, u, force)
      type(interfaces_t), intent(in) :: interfaces
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, n_points)
      real(dp), intent(inout) :: force(:, :)     !! (ndim, n_points)
      integer :: k
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            call give_nodes(point%jump, matmul(interface_stiffness(interfaces, k), jump_of(point%jump, u)), force)
         end associate
      end do
   end subroutine add_interface_resistance

   !> After a step: commit slip, with the friction at its end in explicit steps, else with the mean of both ends, the future contact
   !> places of open faces, and damage.
   pure subroutine commit_slip(interfaces)
      type(interfaces_t), intent(inout) :: interfaces
      real(dp) :: sliding(ndim - 1), pressed
      type(cohesive_state_t) :: answer
      integer :: k
      if (interfaces%n_contact + interfaces%n_cohesive == 0 .or. interfaces%keep_slip) return
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (holds(point)) then
               answer = cohesion_at(interfaces, k)
               point%damage = answer%damage
               point%dissipated = point%dissipated + merge(2, 1, is_half(point))*answer%taken/point%area
               interfaces%of_cohesion = interfaces%of_cohesion + sum(answer%taken)
               interfaces%loss = interfaces%loss + sum(answer%taken)
               point%slip = along_faces(point, point%opening)
            end if
            if (.not. is_free(point)) cycle
            sliding = sliding_of(point)
            pressed = max(0.0_dp, overlap_of(point))
            select case (state_of(point))
             case (is_open)
               point%slip = along_faces(point, opening_of_faces(point))
               point%slid = along_faces(point, point%opening)
             case (slides)
               sliding = slid_by(point)
               interfaces%loss = interfaces%loss + point%stiffness*length_along(sliding)*(point%spare + point%friction &
                                 *merge(pressed, (point%pressed + pressed)/2, k <= interfaces%n_at_end))
               point%slip = point%slip + sliding
               point%slid = point%slid + sliding
            end select
            point%pressed = pressed
         end associate
      end do
   end subroutine commit_slip

   !> Slip of faces: their sliding beyond the limit of friction [m].
   pure function slid_by(point)
      type(interface_point_t), intent(in) :: point
      real(dp) :: slid_by(ndim - 1)
      slid_by = sliding_of(point)
      slid_by = slid_by - in_direction_of(slid_by, limit_of(point))
   end function slid_by

   !> Total slip of faces, with the part not yet committed; of separate faces all of their opening along them [m].
   pure function slid_in_all(point) result(slid)
      type(interface_point_t), intent(in) :: point
      real(dp) :: slid(ndim - 1)
      slid = point%slid
      select case (state_of(point))
       case (is_open)
         slid = along_faces(point, point%opening)
       case (slides)
         slid = slid + slid_by(point)
      end select
   end function slid_in_all

   !> Energy that the interface points store [J].
   pure real(dp) function interface_energy(interfaces) result(energy)
      type(interfaces_t), intent(in) :: interfaces
      type(cohesive_state_t) :: answer
      integer :: k
      energy = 0
      do k = 1, interfaces%n
         if (holds(interfaces%list(k))) then
            answer = cohesion_at(interfaces, k)
            energy = energy + answer%stored
         else
            energy = energy + energy_of(interfaces%list(k))
         end if
      end do
   end function interface_energy

   !> Energy stored by an interface point [J]: by a bonded point since it began. A failing one stores only the energy of pressed
   !> faces; its dissipation is lost.
   pure real(dp) function energy_of(point) result(energy)
      type(interface_point_t), intent(in) :: point
      associate (stretch => stretch_of(point), s => point%stiffness)
         if (is_free(point)) then
            energy = dot_product(face_force(point), face_force(point)/s - point%carried)/2
         else
            energy = point%stored + dot_product(point%initial_force, stretch) + s*sum(stretch**2)/2
         end if
      end associate
   end function energy_of

   !> Let the openings follow a displacement of the nodes, `scale` times a field.
   pure subroutine stretch_interfaces(interfaces, field, scale)
      type(interfaces_t), intent(inout) :: interfaces
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp), intent(in) :: scale
      integer :: k
      do k = 1, interfaces%n
         interfaces%list(k)%opening = interfaces%list(k)%opening + scale*jump_of(interfaces%list(k)%jump, field)
      end do
   end subroutine stretch_interfaces

   !> Open the bonded points without a tip by a displacement of the nodes since the start. New ones on a mesh do not begin with the
   !> stress of the field, and of two at one place, on pieces of either side of a crack, each has its own.
   pure subroutine open_interfaces(interfaces, displacement)
      type(interfaces_t), intent(inout) :: interfaces
      real(dp), intent(in) :: displacement(:, :) !! [m], (ndim, n_points)
      integer :: k
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%law /= contact .and. point%tip == 0) point%opening = jump_of(point%jump, displacement)
         end associate
      end do
   end subroutine open_interfaces

   !> Let all be as before any load, with the initial forces.
   pure subroutine relax_interfaces(interfaces)
      type(interfaces_t), intent(inout) :: interfaces
      type(face_state_t) :: new
      integer :: k
      do k = 1, interfaces%n
         new%initial_force = interfaces%list(k)%initial_force
         new%contact_offset = interfaces%list(k)%contact_offset
         interfaces%list(k)%face_state_t = new
      end do
      interfaces%loss = 0
      interfaces%of_cohesion = 0
   end subroutine relax_interfaces

   !> Let the opening of faces on a new mesh take effect while waves cross some cells: at once it would emit waves.
   pure subroutine ease_faces(interfaces, way)
      type(interfaces_t), intent(inout) :: interfaces
      real(dp), intent(in) :: way                !! of waves, since they felt the last [m]
      real(dp), parameter :: cells = 10
      integer :: k
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%law == contact .and. any(abs(point%start) > tiny(way))) point%start = exp(-way/(cells*point%cell))*point%start
         end associate
      end do
   end subroutine ease_faces

   !> The jumps of the interface points that have a mass.
   pure function jumps_with_mass(interfaces) result(jumps)
      type(interfaces_t), intent(in) :: interfaces
      type(jump_t), allocatable :: jumps(:)
      jumps = pack(interfaces%list(:interfaces%n)%jump, interfaces%list(:interfaces%n)%jump%mass > 0)
   end function jumps_with_mass

   !> Add the momentum of the interface points at the nodes [kg m/s].
   pure subroutine add_interface_momentum(interfaces, momentum)
      type(interfaces_t), intent(in) :: interfaces
      real(dp), intent(inout) :: momentum(:, :)  !! (ndim, n_points)
      integer :: k
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%jump%mass > 0) call give_nodes(point%jump, point%jump%mass*point%rate, momentum)
         end associate
      end do
   end subroutine add_interface_momentum

   !> Let the masses of interface points follow an acceleration of the nodes. `energy` is the sum of m |dw|**2/2 [J].
   pure subroutine kick_interfaces(interfaces, acceleration, dt, energy)
      type(interfaces_t), intent(inout) :: interfaces
      real(dp), intent(in) :: acceleration(:, :) !! [m/s2], (ndim, n_points)
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(out) :: energy
      real(dp) :: change(ndim)
      integer :: k
      energy = 0
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (.not. point%jump%mass > 0) cycle
            change = dt*jump_of(point%jump, acceleration)
            point%rate = point%rate + change
            energy = energy + point%jump%mass*sum(change**2)/2
         end associate
      end do
   end subroutine kick_interfaces

   !> Kinetic energy of the masses of interface points [J].
   pure real(dp) function energy_of_rates(interfaces) result(energy)
      type(interfaces_t), intent(in) :: interfaces
      integer :: k
      energy = sum([(interfaces%list(k)%jump%mass*sum(interfaces%list(k)%rate**2)/2, k=1, interfaces%n)])
   end function energy_of_rates
end module hampm_interface_points
