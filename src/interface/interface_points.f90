!> Interface points: quadrature points with two sides, each a set of nodes with weights, and a law of the force across their jump
!>
!>    g = sum over nodes of c_j u_j,   force on node j   -c_j f(g).
!>
!> `bonded`: springs ahead of a tip in the cell where a crack ends, which is cut as a whole; ahead of a moving tip they begin with
!> the traction of the material and fail when the tip has reached them (`hampm_nodal_release`). On a symmetry plane a half point has
!> the displacement of the face as g, a normal force only, and the energy of the half. `contact`: a penalty against overlap by the
!> layer of a third of a cell, friction by return mapping; with given limits (`hold_friction`) the potential is convex. `ghost`:
!> ghost penalty (`hampm_ghost_penalty`), with a mass m at the rate w of the jump: momentum m c_j w of node j, dw = c.a dt, mass
!> matrix m c c^T. `cohesive`: a traction-separation law in series with the layer (`hampm_cohesive_law`), then contact. `support`: a
!> node held in part along the normal (`hampm_part_supports`). Placement: `hampm_interface_placement`. Source: Wriggers,
!> Computational Contact Mechanics (2006), sections 5.2 (penalty), 10.5 (return mapping).
module hampm_interface_points
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_cohesive_law, only: cohesive_law_t, cohesive_state_t
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_jumps, only: jump_t, jump_of, give_nodes
   use hampm_tensors, only: norm, identity, in_plane, quarter_turn
   use hampm_text, only: to_text
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: interfaces_t, interface_point_t, bonded, contact, ghost, cohesive, support, holds, pulls, are_apart, cohesion_at, &
             along, along_faces, &
             add_interface_forces, forces_of_firm_faces, stretch_interfaces, &
             open_interfaces, commit_slip, ease_faces, direction_of, components_of, vector_of, of_direction, &
             interface_energy, interface_states, interface_stiffness, stiffness_of_axes, force_of, force_at, &
             face_force, overlap_of, sliding_of, slid_in_all, energy_of, relax_interfaces, find_face_force, extend_opening, &
             is_pressed, is_softening, have_friction, hold_friction, length_along, &
             archive_interfaces, add_interface_point, is_half, jumps_with_mass, add_interface_momentum, &
             kick_interfaces, energy_of_rates, add_interface_resistance

   integer, parameter :: bonded = 1, contact = 2, ghost = 3, cohesive = 4, support = 5 !! law of an interface point
   integer, parameter :: of_direction(3) = [2, 1, 3] !! rows of `stiffness_of_axes` of the directions of a point
   integer, parameter :: is_open = 0, sticks = 1, slides = 2 !! its states
   integer, parameter :: sticks_apart = 3        !! and with given friction limits: separate faces held along

   !> An interface point.
   type, extends(jump_t) :: interface_point_t
      integer :: law = bonded                    !! `bonded`, `contact`, `ghost`, `cohesive` or `support`
      integer :: n_left = 0                      !! number of nodes of the left face, which come first
      real(dp) :: stiffness = 0                  !! s [N/m]
      real(dp) :: place(ndim) = 0                !! on the line [m]
      real(dp) :: middle(ndim) = 0               !! of the part of the line that it stands for [m]
      real(dp) :: origin(ndim) = 0               !! in the reference configuration, of faces; of `ghost` place in the grid [m]
      real(dp) :: length = 0                     !! of the line that it stands for [m]
      real(dp) :: area = 0                       !! of faces that it stands for [m2]
      real(dp) :: normal(ndim) = identity(:, 1)          !! from the right to the left face
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: opening(ndim) = 0              !! g, of the left face from the right one [m]
      real(dp) :: touch = -huge(1.0_dp)          !! opening across the faces below which they press on each other [m]
      real(dp) :: slip(ndim - 1) = 0             !! sliding at which they hold each other without a force along them [m]
      real(dp) :: slid(ndim - 1) = 0             !! sliding not held by friction so far; all of it if separate [m]
      real(dp) :: pressed = 0                    !! overlap of the faces after the last step [m]
      real(dp) :: felt(ndim) = 0                 !! opening with the force of the last step, for forces at its end [m]
      real(dp) :: most_held = -1                 !! friction limit over the stiffness; below 0 if it follows the
                                                 !! pressure [m]
      integer :: plane = 0                       !! number of the crack in a plane whose front moves over its square, 0 for none
      real(dp) :: before(ndim) = 0               !! opening before the last step [m]
      real(dp) :: lost = 0                       !! part of its stiffness and force that has gone before the last step [-]
      logical :: is_new = .false.                !! of that: whether it is at a node whose force it is to take
      logical :: is_firm = .false.               !! whether the layer is far stiffer than the cells beside it
      integer :: line = 0                        !! number of the crack whose faces may touch there, 0 for none
      logical :: follows_leaf = .false.          !! whether its place is one in a leaf, else in the material
      integer :: tip = 0                         !! number of the tip that moves over a bonded point, 0 for none
      real(dp) :: way = 0                        !! of that tip from its start to the point; of `cohesive` to its start [m]
      real(dp) :: cell = 0                       !! size of the cell there [m]
      real(dp) :: held(ndim) = 0                 !! force of a bonded point at the opening `start` [N]
      real(dp) :: start(ndim) = 0                !! [m]; of `contact` the opening without effect after a change of the mesh
      real(dp) :: carried(ndim) = 0              !! force of `contact` without overlap and elastic sliding, over the stiffness [m]
      real(dp) :: spare = 0                      !! limit of its friction beyond that of its own pressure, over the stiffness [m]
      logical :: is_failing = .false.            !! whether it has begun to fail: force `fraction_left` of `held`, and contact
      real(dp) :: fraction_left = 1              !! [-]
      real(dp) :: reached = 0                    !! largest opening since then along the force, of law = toughness [m]
      real(dp) :: rate(ndim) = 0                 !! w [m/s]
      integer :: cohesion = 0                    !! number of the law of `cohesive`
      real(dp) :: damage = 0                     !! of that, 1 where it has failed [-]
      real(dp) :: taken(2) = 0                   !! by that, of opening and of sliding [J/m2]
      real(dp) :: stored = 0                     !! energy of a bonded point at the opening `start`, or at the start of failure [J]
   end type interface_point_t

   !> All interface points.
   type :: interfaces_t
      type(thickness_t) :: thickness             !! of the material
      logical :: are_bounded = .true.            !! whether explicit steps have to be stable
      integer :: n_at_end = 0                    !! number of the first points with forces that depend on the step
      logical :: strain_last = .false.           !! whether velocities that particles do not keep open them (usl)
      logical :: are_lumped = .true.             !! whether the masses of their nodes are lumped then
      logical :: are_moving = .true.             !! whether they have masses, where they may
      integer :: alone = 0                       !! first element of a piece too small to move with no fuller one beside it, 0
                                                 !! for none
      integer :: n = 0                           !! number of interface points
      integer :: n_contact = 0                   !! of which are for contact
      real(dp) :: weight = 1                     !! of the forces of firm faces, in an implicit step (`hampm_newmark`) [-]
      logical :: keep_slip = .false.             !! whether slip is not yet committed: its load is still searched
      real(dp) :: caution = 0                    !! least part of the stiffness in the tangent of faces [-]
      integer :: n_cohesive = 0                  !! and of which are `cohesive`
      type(cohesive_law_t), allocatable :: cohesion(:) !! the laws
      real(dp) :: loss = 0                       !! energy taken by friction and by cohesion [J]
      real(dp) :: of_cohesion = 0                !! of which is taken by cohesion [J]
      type(interface_point_t), allocatable :: list(:)     !! (n at least)
   end type interfaces_t

contains

   !> Unit vector along the line of an interface point; in space one along its face, which is in a plane of the grid.
   pure function along(point) result(t)
      type(interface_point_t), intent(in) :: point
      real(dp) :: t(ndim)
      if (ndim == 2) then
         t = quarter_turn(-point%normal)
      else
         t = direction_of(point, 2)
      end if
   end function along

   !> The d-th direction of an interface point: the first across its faces, the others along them.
   pure function direction_of(point, d) result(t)
      type(interface_point_t), intent(in) :: point
      integer, intent(in) :: d
      real(dp) :: t(ndim)
      if (d == 1) then
         t = point%normal
      else if (ndim == 2) then
         t = along(point)
      else
         t = identity(:, mod(maxloc(abs(point%normal), dim=1) + d - 2, ndim) + 1)
      end if
   end function direction_of

   !> Components of a vector along the faces.
   pure function along_faces(point, vector) result(components)
      type(interface_point_t), intent(in) :: point
      real(dp), intent(in) :: vector(ndim)
      real(dp) :: components(ndim - 1)
      integer :: d
      do d = 2, ndim
         components(d - 1) = dot_product(direction_of(point, d), vector)
      end do
   end function along_faces

   !> How long a vector along faces is.
   pure real(dp) function length_along(components) result(length)
      real(dp), intent(in) :: components(ndim - 1)
      length = merge(abs(components(1)), norm(components), ndim == 2)
   end function length_along

   !> Vector of the length of a limit in the direction of a sliding.
   pure function in_direction_of(sliding, limit) result(components)
      real(dp), intent(in) :: sliding(ndim - 1), limit
      real(dp) :: components(ndim - 1)
      if (ndim == 2) then
         components = sign(limit, sliding)
      else
         components = limit/max(norm(sliding), tiny(limit))*sliding
      end if
   end function in_direction_of

   !> Components of a vector in these directions.
   pure function components_of(point, vector) result(components)
      type(interface_point_t), intent(in) :: point
      real(dp), intent(in) :: vector(ndim)
      real(dp) :: components(ndim)
      integer :: d
      do d = 1, ndim
         components(d) = dot_product(vector, direction_of(point, d))
      end do
   end function components_of

   !> The vector with these components.
   pure function vector_of(point, components) result(vector)
      type(interface_point_t), intent(in) :: point
      real(dp), intent(in) :: components(ndim)
      real(dp) :: vector(ndim)
      integer :: d
      vector = components(1)*point%normal
      do d = 2, ndim
         vector = vector + components(d)*direction_of(point, d)
      end do
   end function vector_of

   !> Whether a point lies between a face and its mirror image: nodes of the other face are missing. Both sides of a ghost penalty
   !> may have the same nodes. A support, which holds along the normal alone, counts as half.
   pure logical function is_half(point)
      type(interface_point_t), intent(in) :: point
      is_half = point%law == support .or. &
                point%law /= ghost .and. (point%n_left == 0 .or. point%node(point%n_left + 1) == 0)
   end function is_half

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
      pulls = holds(point) .or. point%law == bonded .and. point%fraction_left > 0
   end function pulls

   !> Whether a bonded point has begun to fail, still pulls, and its faces do not press on each other.
   pure logical function is_softening(point)
      type(interface_point_t), intent(in) :: point
      is_softening = point%is_failing .and. point%fraction_left > 0
      if (is_softening) is_softening = overlap_of(point) < 0
   end function is_softening

   !> Whether an interface point is one of faces that are free to part.
   pure logical function is_free(point)
      type(interface_point_t), intent(in) :: point
      is_free = point%law == contact .or. point%is_failing .or. point%law == cohesive .and. .not. holds(point)
   end function is_free

   !> Whether an interface point is between faces that no bonded point has held, or none since cohesion did.
   pure logical function are_apart(point)
      type(interface_point_t), intent(in) :: point
      are_apart = is_free(point) .and. point%law /= bonded
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
      if (overlap_of(point) < 0) state = merge(sticks_apart, is_open, holds .and. point%most_held >= 0)
   end function state_of

   !> Effective opening of the faces [m].
   pure function felt_by_faces(point) result(opening)
      type(interface_point_t), intent(in) :: point
      real(dp) :: opening(ndim)
      opening = point%opening
      if (point%law == contact) opening = opening - point%start + point%carried
   end function felt_by_faces

   !> Overlap of the faces; below 0 where they are separate [m].
   pure real(dp) function overlap_of(point) result(overlap)
      type(interface_point_t), intent(in) :: point
      overlap = point%touch - dot_product(point%normal, felt_by_faces(point))
   end function overlap_of

   !> Sliding of the faces from their place without a force along them [m].
   pure function sliding_of(point) result(sliding)
      type(interface_point_t), intent(in) :: point
      real(dp) :: sliding(ndim - 1)
      sliding = along_faces(point, felt_by_faces(point)) - point%slip
   end function sliding_of

   !> Friction limit over the stiffness [m].
   pure real(dp) function limit_of(point) result(limit)
      type(interface_point_t), intent(in) :: point
      limit = point%friction*max(overlap_of(point), 0.0_dp) + merge(point%spare, 0.0_dp, overlap_of(point) > 0)
      if (point%most_held >= 0) limit = point%most_held
   end function limit_of

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
            point%most_held = -1
            point%most_held = limit_of(point)
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
                  point%stiffness/area/halves, point%damage, point%taken)
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
         force = point%held + point%stiffness*stretch_of(point)
      else
         force = face_force(point)
         if (point%is_failing) force = force + point%fraction_left*point%held
      end if
   end function force_of

   !> Force of an interface point against separation of the faces, and the change of their opening along a direction, by its
   !> neighbours. `is_there` is false for intact bonded points and separate faces. For failing points it is the change, along the
   !> path of the tip, of the opening since the start of failure: it does their work, and each began with another opening.
   pure subroutine find_face_force(interfaces, k, direction, force, slope, is_there)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: k
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      real(dp), intent(out) :: force(ndim)       !! [N]
      real(dp), intent(out) :: slope(ndim)       !! [-]
      logical, intent(out) :: is_there
      integer :: before, after
      real(dp) :: way, line(ndim)
      force = 0
      slope = 0
      is_there = holds(interfaces%list(k)) .or. is_softening(interfaces%list(k)) .or. &
                 is_free(interfaces%list(k)) .and. state_of(interfaces%list(k)) /= is_open
      if (.not. is_there) return
      force = force_at(interfaces, k)
      if (ndim > 2) then
         slope = slope_on_face(interfaces, k, direction)
         return
      end if
      before = merge(k - 1, k, is_next(max(k - 1, 1)))
      after = merge(k + 1, k, is_next(min(k + 1, interfaces%n)))
      line = direction
      if (is_softening(interfaces%list(k))) line = along(interfaces%list(k))
      way = dot_product(interfaces%list(after)%place - interfaces%list(before)%place, line)
      if (abs(way) > 0) slope = (opening_of(interfaces%list(after)) - opening_of(interfaces%list(before)))/way

   contains

      !> The opening of an interface point that counts there [m].
      pure function opening_of(point) result(opening)
         type(interface_point_t), intent(in) :: point
         real(dp) :: opening(ndim)
         opening = point%opening
         if (is_softening(interfaces%list(k))) opening = merge(1, 0, point%is_failing)*(opening - point%start)
      end function opening_of

      !> Whether another interface point is one of the same crack, on the same straight part of it.
      pure logical function is_next(other)
         integer, intent(in) :: other
         associate (point => interfaces%list(k), beside => interfaces%list(other))
            is_next = is_free(beside) .or. holds(beside)
            if (is_softening(point)) is_next = beside%tip == point%tip
            is_next = is_next .and. other /= k .and. beside%line == point%line .and. norm(beside%normal - point%normal) <= 1e-6_dp
         end associate
      end function is_next
   end subroutine find_face_force

   !> The change of the opening along a direction in space, by that at the points of the nodes beside it [-].
   pure function slope_on_face(interfaces, k, direction) result(slope)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: k
      real(dp), intent(in) :: direction(ndim)
      real(dp) :: slope(ndim), way(ndim), changes(ndim, ndim), square(ndim)
      integer :: other, d
      changes = 0
      square = 0
      associate (point => interfaces%list(k))
         do other = 1, interfaces%n
            associate (beside => interfaces%list(other))
               if (beside%law /= contact .or. beside%line /= point%line) cycle
               way = beside%place - point%place
               d = maxloc(abs(way), dim=1)
               if (abs(way(d)) > 1.1_dp*point%cell .or. count(abs(way) > 1e-3_dp*point%cell) /= 1) cycle
               changes(:, d) = changes(:, d) + way(d)*(beside%opening - point%opening)
               square(d) = square(d) + way(d)**2
            end associate
         end do
      end associate
      slope = matmul(changes, direction/max(square, tiny(square)))
   end function slope_on_face

   !> Opening of faces that may touch at a place of their crack [m]: extrapolated from the two nearest points on one side. Not there
   !> without such points.
   pure subroutine extend_opening(interfaces, line, x, toward, opening, is_there)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: line                !! number of the crack
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: toward(ndim)       !! unit vector along the crack to that side
      real(dp), intent(inout) :: opening(ndim)
      logical, intent(out) :: is_there
      real(dp), parameter :: far = 1.5_dp        ! cells; points of the next cell are no farther
      real(dp), parameter :: same = 1e-3_dp      ! distance of points at one place, on both sides of a kink [cells]
      real(dp), allocatable :: way(:) ! from the place to the points [m]
      integer :: k, near, next
      allocate (way(interfaces%n))
      way = [(dot_product(interfaces%list(k)%place - x, toward), k=1, interfaces%n)]
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%line /= line .or. all(point%law /= [contact, cohesive]) .or. way(k) > far*point%cell) way(k) = -1
         end associate
      end do
      is_there = count(way > 0) > 1
      if (.not. is_there) return
      near = minloc(way, dim=1, mask=way > 0)
      next = minloc(way, dim=1, mask=way > way(near) + same*interfaces%list(near)%cell)
      is_there = next > 0
      if (.not. is_there) return
      associate (a => interfaces%list(near)%opening, b => interfaces%list(next)%opening)
         opening = a + way(near)/(way(next) - way(near))*(a - b)
      end associate
   end subroutine extend_opening

   !> Whether an interface point is for contact and its faces press on each other.
   pure logical function is_pressed(point)
      type(interface_point_t), intent(in) :: point
      is_pressed = point%law == contact
      if (is_pressed) is_pressed = state_of(point) /= is_open
   end function is_pressed

   !> Change of the force of the k-th with its opening, without the unsymmetric change of friction with pressure [N/m].
   pure function interface_stiffness(interfaces, k) result(tangent)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: k
      real(dp) :: tangent(ndim, ndim), axes(ndim, ndim)
      integer :: d
      do d = 1, ndim
         axes(:, of_direction(d)) = direction_of(interfaces%list(k), d)
      end do
      tangent = matmul(axes, matmul(stiffness_of_axes(interfaces, k), transpose(axes)))
   end function interface_stiffness

   !> The same of the force along the faces and across them with the opening along and across them, in space along them again [N/m].
   pure function stiffness_of_axes(interfaces, k) result(tangent)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: k
      real(dp) :: tangent(ndim, ndim)
      type(cohesive_state_t) :: answer
      real(dp) :: sliding(ndim - 1), turning
      integer :: state
      tangent = 0
      associate (point => interfaces%list(k), caution => interfaces%caution)
         if (holds(point)) then
            answer = cohesion_at(interfaces, k)
            tangent = (1 - caution)*answer%tangent + caution*answer%secant
         else
            state = state_of(point)
            if (point%law /= contact .and. state == is_open) return
            tangent(1, 1) = point%stiffness*merge(1.0_dp, caution, state == sticks .or. state == sticks_apart)
            tangent(2, 2) = point%stiffness*merge(1.0_dp, caution, state == sticks .or. state == slides)
         end if
         if (is_half(point)) tangent(1, 1) = 0
         if (ndim > 2) then
            tangent(ndim, ndim) = tangent(1, 1)
            if (point%friction > 0 .and. state == slides) then ! the force turns with the sliding
               sliding = sliding_of(point)
               turning = (1 - caution)*point%stiffness*limit_of(point)/length_along(sliding)
               sliding = sliding/length_along(sliding)
               tangent(1, 1) = tangent(1, 1) + turning*(1 - sliding(1)**2)
               tangent(ndim, ndim) = tangent(ndim, ndim) + turning*(1 - sliding(ndim - 1)**2)
               tangent(1, ndim) = -turning*sliding(1)*sliding(ndim - 1)
               tangent(ndim, 1) = tangent(1, ndim)
            end if
         end if
         if (point%is_firm) tangent = interfaces%weight*tangent
      end associate
   end function stiffness_of_axes

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
         call give_nodes(interfaces%list(k)%jump_t, &
                         -merge(interfaces%weight, 1.0_dp, interfaces%list(k)%is_firm)*force_at(interfaces, k), force)
      end do
   end subroutine add_interface_forces

   !> The forces on the nodes of firm faces alone [N].
   pure function forces_of_firm_faces(interfaces, n_points) result(force)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: n_points            !! of the grid
      real(dp) :: force(ndim, n_points)
      integer :: k
      force = 0
      do k = 1, interfaces%n
         if (interfaces%list(k)%is_firm) call give_nodes(interfaces%list(k)%jump_t, -force_of(interfaces%list(k)), force)
      end do
   end function forces_of_firm_faces

   !> Add the resistance of interface points, in their present state, to a small displacement of the nodes [N].
   pure subroutine add_interface_resistance(interfaces, u, force)
      type(interfaces_t), intent(in) :: interfaces
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, n_points)
      real(dp), intent(inout) :: force(:, :)     !! (ndim, n_points)
      integer :: k
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            call give_nodes(point%jump_t, matmul(interface_stiffness(interfaces, k), jump_of(point%jump_t, u)), force)
         end associate
      end do
   end subroutine add_interface_resistance

   !> Let the openings follow a displacement of the nodes, `scale` times a field.
   pure subroutine stretch_interfaces(interfaces, field, scale)
      type(interfaces_t), intent(inout) :: interfaces
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp), intent(in) :: scale
      integer :: k
      do k = 1, interfaces%n
         interfaces%list(k)%opening = interfaces%list(k)%opening + scale*jump_of(interfaces%list(k)%jump_t, field)
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
            if (point%law /= contact .and. point%tip == 0) point%opening = jump_of(point%jump_t, displacement)
         end associate
      end do
   end subroutine open_interfaces

   !> The jumps of the interface points that have a mass.
   pure function jumps_with_mass(interfaces) result(jumps)
      type(interfaces_t), intent(in) :: interfaces
      type(jump_t), allocatable :: jumps(:)
      jumps = pack(interfaces%list(:interfaces%n)%jump_t, interfaces%list(:interfaces%n)%mass > 0)
   end function jumps_with_mass

   !> Add the momentum of the interface points at the nodes [kg m/s].
   pure subroutine add_interface_momentum(interfaces, momentum)
      type(interfaces_t), intent(in) :: interfaces
      real(dp), intent(inout) :: momentum(:, :)  !! (ndim, n_points)
      integer :: k
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%mass > 0) call give_nodes(point%jump_t, point%mass*point%rate, momentum)
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
         if (.not. interfaces%list(k)%mass > 0) cycle
         change = dt*jump_of(interfaces%list(k)%jump_t, acceleration)
         interfaces%list(k)%rate = interfaces%list(k)%rate + change
         energy = energy + interfaces%list(k)%mass*sum(change**2)/2
      end do
   end subroutine kick_interfaces

   !> Kinetic energy of the masses of interface points [J].
   pure real(dp) function energy_of_rates(interfaces) result(energy)
      type(interfaces_t), intent(in) :: interfaces
      integer :: k
      energy = sum([(interfaces%list(k)%mass*sum(interfaces%list(k)%rate**2)/2, k=1, interfaces%n)])
   end function energy_of_rates

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

   !> Let all be as before any load.
   pure subroutine relax_interfaces(interfaces)
      type(interfaces_t), intent(inout) :: interfaces
      integer :: k
      if (interfaces%n == 0) return
      do k = 1, interfaces%n
         interfaces%list(k)%opening = 0
         interfaces%list(k)%slip = 0
         interfaces%list(k)%slid = 0
         interfaces%list(k)%start = 0
         interfaces%list(k)%carried = 0
         interfaces%list(k)%spare = 0
         interfaces%list(k)%pressed = 0
         interfaces%list(k)%damage = 0
         interfaces%list(k)%taken = 0
      end do
      interfaces%loss = 0
      interfaces%of_cohesion = 0
   end subroutine relax_interfaces

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
               point%taken = point%taken + merge(2, 1, is_half(point))*answer%taken/point%area
               interfaces%of_cohesion = interfaces%of_cohesion + sum(answer%taken)
               interfaces%loss = interfaces%loss + sum(answer%taken)
               point%slip = along_faces(point, point%opening)
            end if
            if (.not. is_free(point)) cycle
            sliding = sliding_of(point)
            pressed = max(0.0_dp, overlap_of(point))
            select case (state_of(point))
             case (is_open)
               point%slip = along_faces(point, felt_by_faces(point))
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
            energy = point%stored + dot_product(point%held, stretch) + s*sum(stretch**2)/2
         end if
      end associate
   end function energy_of

   !> Add an interface point that nothing has stretched, without nodes.
   pure subroutine add_interface_point(interfaces, law)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: law
      type(interface_point_t) :: new             ! its constructor ends flang 19
      type(interface_point_t), allocatable :: more(:)
      if (.not. allocated(interfaces%list)) allocate (interfaces%list(64))
      if (interfaces%n == size(interfaces%list)) then
         allocate (more(2*interfaces%n))
         more(:interfaces%n) = interfaces%list
         call move_alloc(more, interfaces%list)
      end if
      interfaces%n = interfaces%n + 1
      new%law = law
      interfaces%list(interfaces%n) = new
      if (law == cohesive) interfaces%n_cohesive = interfaces%n_cohesive + 1
      if (law == contact) interfaces%n_contact = interfaces%n_contact + 1
      if (law == contact .or. law == cohesive) interfaces%list(interfaces%n)%touch = 0
   end subroutine add_interface_point

   !> Archive interface points: in the updated frame their places at the last cut of cells, and their state.
   subroutine archive_interfaces(interfaces, archive)
      type(interfaces_t), intent(inout) :: interfaces
      class(archive_t), intent(inout) :: archive
      integer :: n, j, d
      n = interfaces%n
      call archive%section('interface_points')
      call archive%serialise('number', n)
      call archive%serialise('n_at_end', interfaces%n_at_end)
      if (n == 0 .or. archive%failure%failed()) return
      if (archive%is_read) then
         interfaces%n = n
         if (allocated(interfaces%list)) deallocate (interfaces%list)
         allocate (interfaces%list(max(n, 64)))
      end if
      call archive%serialise('n_contact', interfaces%n_contact)
      call archive%serialise('n_cohesive', interfaces%n_cohesive)
      call archive%serialise('loss', interfaces%loss)
      call archive%serialise('of_cohesion', interfaces%of_cohesion)
      associate (of => interfaces%list(:n))
         call archive%archive_integers('law', n, of%law)
         call archive%archive_integers('n_left', n, of%n_left)
         do j = 1, 2*most_nodes_of_leaf
            call archive%archive_integers('node_'//to_text(j), n, of%node(j))
            call archive%archive_reals('share_'//to_text(j), n, of%share(j))
         end do
         do d = 1, ndim
            call archive%archive_reals('place_'//to_text(d), n, of%place(d))
            call archive%archive_reals('middle_'//to_text(d), n, of%middle(d))
            call archive%archive_reals('origin_'//to_text(d), n, of%origin(d))
            call archive%archive_reals('normal_'//to_text(d), n, of%normal(d))
            call archive%archive_reals('opening_'//to_text(d), n, of%opening(d))
            call archive%archive_reals('held_'//to_text(d), n, of%held(d))
            call archive%archive_reals('start_'//to_text(d), n, of%start(d))
            call archive%archive_reals('carried_'//to_text(d), n, of%carried(d))
            call archive%archive_reals('rate_'//to_text(d), n, of%rate(d))
            call archive%archive_reals('felt_'//to_text(d), n, of%felt(d))
            call archive%archive_reals('before_'//to_text(d), n, of%before(d))
         end do
         do d = 1, size(of(1)%taken)
            call archive%archive_reals('taken_'//to_text(d), n, of%taken(d))
         end do
         call archive%archive_reals('stiffness', n, of%stiffness)
         call archive%archive_reals('length', n, of%length)
         call archive%archive_reals('area', n, of%area)
         call archive%archive_reals('friction', n, of%friction)
         call archive%archive_reals('pressed', n, of%pressed)
         call archive%archive_reals('spare', n, of%spare)
         call archive%archive_integers('line', n, of%line)
         call archive%archive_integers('tip', n, of%tip)
         call archive%archive_integers('plane', n, of%plane)
         call archive%archive_reals('lost', n, of%lost)
         call archive%archive_reals('way', n, of%way)
         call archive%archive_reals('cell', n, of%cell)
         call archive%archive_logicals('is_failing', n, of%is_failing)
         call archive%archive_logicals('is_firm', n, of%is_firm)
         call archive%archive_logicals('follows_leaf', n, of%follows_leaf)
         call archive%archive_reals('fraction_left', n, of%fraction_left)
         call archive%archive_reals('touch', n, of%touch)
         call archive%archive_reals('slip', n, of%slip(1))
         if (ndim > 2) call archive%archive_reals('slip_2', n, of%slip(ndim - 1))
         call archive%archive_reals('slid', n, of%slid(1))
         if (ndim > 2) call archive%archive_reals('slid_2', n, of%slid(ndim - 1))
         call archive%archive_reals('reached', n, of%reached)
         call archive%archive_reals('stored', n, of%stored)
         call archive%archive_reals('mass', n, of%mass)
         call archive%archive_integers('cohesion', n, of%cohesion)
         call archive%archive_reals('damage', n, of%damage)
      end associate
   end subroutine archive_interfaces
end module hampm_interface_points
