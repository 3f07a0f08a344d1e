!> Transfer of interface points to a new mesh. Points at the places of old ones have their state: particles give only the opening of
!> a linear field between the nodes, and repeated changes of the mesh elsewhere would erase the rest of it and return other work
!> than was put in. Points of faces between old places have a state between those there.
!>
!> Most points follow each other as before; the others find their predecessors by a table of places (`hampm_nearby`), in a time
!> linear in the number of points.
module hampm_interface_transfer
   use hampm_kinds, only: dp, ndim, plane
   use hampm_bonded_forces, only: traction_at
   use hampm_interface_points, only: interfaces_t, interface_point_t, face_state_t, bonded, releasing, contact, support, holds, &
                                     along, along_faces, direction_of, turned, interpolated, is_half, force_of, face_force, &
                                     overlap_of, sliding_of, energy_of, find_points
   use hampm_crack_lines, only: left_face, right_face, both_faces
   use hampm_matter, only: matter_t
   use hampm_nearby, only: nearby_t
   use hampm_tensors, only: norm
   implicit none
   private
   public :: transfer_points, start_bonded_point

   real(dp), parameter :: same = 1e-9_dp         !! distance within which places are the same [cells]

contains

   !> Transfer the state of old points to new ones; see `start_bonded_point` and `hampm_plane_points` for those of fronts in motion.
   pure subroutine transfer_points(interfaces, old, near, visits)
      type(interfaces_t), intent(inout) :: interfaces
      type(interfaces_t), intent(in) :: old      !! those on the mesh before
      type(nearby_t), intent(inout) :: near      !! see `find_points`
      integer, intent(inout), optional :: visits !! old points compared so far
      integer, allocatable :: found(:), at_place(:)
      integer :: s, i, last
      last = 0
      do s = 1, interfaces%n
         associate (point => interfaces%list(s))
            if (point%tip > 0 .and. .not. (point%law == releasing .and. point%line > 0) .or. point%plane > 0) cycle
            i = mod(last, max(1, old%n)) + 1
            if (is_at_place(i)) then
               last = i
            else
               call find_points(old, near, point%origin, 0.0_dp, found, visits)
               found = pack(found, [(is_predecessor(old%list(found(i)), point), i=1, size(found))])
               at_place = pack(found, [(is_at_place(found(i)), i=1, size(found))])
               if (size(at_place) == 0) then
                  if (point%line > 0) call interpolate_state(point, old, found)
                  cycle
               end if
               last = at_place(max(1, findloc(at_place > last, .true., dim=1)))
            end if
            if (point%tip == 0) then
               point%opening = turned(old%list(last)%opening, old%list(last), point)
               point%rate = turned(old%list(last)%rate, old%list(last), point)
            end if
            if (point%line > 0) call copy_state(point, old%list(last), old%keep_slip)
         end associate
      end do

   contains

      !> Whether an old point is a predecessor at the same place.
      pure logical function is_at_place(k)
         integer, intent(in) :: k
         is_at_place = k <= old%n
         if (is_at_place) is_at_place = is_predecessor(old%list(k), interfaces%list(s))
         if (.not. is_at_place) return
         associate (before => old%list(k), point => interfaces%list(s))
            is_at_place = max(norm(before%origin - point%origin), abs(before%length - point%length)) <= same*point%cell
         end associate
      end function is_at_place
   end subroutine transfer_points

   !> Interpolate the state of a point between faces from the nearest old points on either side of it, or the means of those equally
   !> near. Beside all of them it has the state of the last, within its length. In space it has the state of the nearest.
   pure subroutine interpolate_state(point, old, found)
      type(interface_point_t), intent(inout) :: point
      type(interfaces_t), intent(in) :: old
      integer, intent(in) :: found(:)            !! predecessors nearby
      type(interface_point_t) :: one
      type(face_state_t) :: mean(2)
      real(dp) :: distance, least(2), cell(2), length(2)
      integer :: k, side, n(2)
      n = 0
      least = huge(least)
      cell = 0
      length = 0
      do k = 1, size(found)
         associate (before => old%list(found(k)))
            distance = norm(before%origin - point%origin)
            side = merge(1, 2, ndim > plane .or. dot_product(along(point), before%place - point%place) < 0)
            if (distance > least(side) + same*point%cell) cycle
            if (distance < least(side) - same*point%cell) n(side) = 0
            one = point
            call copy_state(one, before, old%keep_slip)
            if (n(side) == 0) then
               mean(side) = one%face_state_t
               cell(side) = 0
               length(side) = 0
            end if
            n(side) = n(side) + 1
            mean(side) = interpolated(mean(side), one%face_state_t, 1.0_dp/n(side))
            least(side) = distance
            cell(side) = max(cell(side), before%cell)
            length(side) = max(length(side), before%length)
         end associate
      end do
      side = minloc(least, dim=1)
      if (all(least <= cell)) then
         point%face_state_t = interpolated(mean(1), mean(2), least(1)/sum(least))
      else if (least(side) <= length(side)) then
         point%face_state_t = mean(side)
      end if
   end subroutine interpolate_state

   !> Whether an old point is a predecessor of another one: faces that press on each other may have been a point that has failed.
   pure logical function is_predecessor(before, point)
      type(interface_point_t), intent(in) :: before, point
      is_predecessor = before%line == point%line .and. (before%law == point%law .and. before%tip == point%tip .or. &
                                                        before%law == releasing .and. point%law == contact)
      if (is_predecessor .and. point%law == support) is_predecessor = norm(before%normal - point%normal) <= same .and. &
         max(norm(before%place - point%place), norm(before%middle - point%middle)) <= same*point%cell
   end function is_predecessor

   !> Copy the state of faces: damage; or, per length, pressure and friction force, and separated faces stay so. Overlap and sliding
   !> are copied too, and take effect gradually (`ease_faces`), as the layer is another one.
   pure subroutine copy_state(point, before, keep_slip)
      type(interface_point_t), intent(inout) :: point
      type(interface_point_t), intent(in) :: before
      logical, intent(in) :: keep_slip           !! whether slip since the last step is not yet committed
      real(dp) :: effective(ndim), strain(ndim), across, firmer
      integer :: d
      if (point%tip == 0) point%opening = turned(before%opening, before, point) ! else it has one of its own
      point%damage = before%damage
      point%dissipated = before%dissipated
      point%slid = before%slid
      if (holds(point)) return
      firmer = merge(point%length/before%length, point%area/before%area, ndim == plane)*before%stiffness/point%stiffness
      point%carried = firmer*turned(before%carried, before, point)
      point%spare = firmer*before%spare
      strain = turned(face_force(before)/before%stiffness, before, point)
      if (keep_slip) then
         strain = dot_product(strain, point%normal)*point%normal
         associate (sliding => sliding_of(before))
            do d = 2, ndim
               strain = strain + sliding(d - 1)*direction_of(point, d)
            end do
         end associate
      end if
      strain = strain - turned(before%carried, before, point)
      effective = firmer*strain
      if (point%law == contact) then
         if (before%law == contact) strain = strain + turned(before%start, before, point)
         point%start = strain - effective
      else
         strain = effective
      end if
      associate (n => point%normal)
         across = dot_product(n, strain)
         if (.not. dot_product(n, effective + point%carried) < 0) across = max(0.0_dp, -overlap_of(before))
         if (point%law == contact) then
            point%opening = point%opening + (across - dot_product(n, point%opening))*n
         else
            point%contact_offset = dot_product(n, point%opening) - across
         end if
         point%pressed = max(0.0_dp, -dot_product(n, effective + point%carried))
         point%slip = along_faces(point, point%opening - strain)
      end associate
   end subroutine copy_state

   !> Start a bonded point of a moving tip, or of one carried through the cells: with its state on the last mesh, or with the
   !> traction of the material.
   pure subroutine start_bonded_point(point, old, near, grown, m, begins)
      type(interface_point_t), intent(inout) :: point
      type(interfaces_t), intent(in) :: old
      type(nearby_t), intent(inout) :: near      !! see `find_points`
      real(dp), intent(in) :: grown              !! way of the tip so far [m]
      type(matter_t), intent(in) :: m
      logical, intent(out) :: begins             !! whether it is new, and the crack has not reached it
      real(dp), allocatable :: distance(:)
      integer, allocatable :: found(:)
      integer :: k, nearest, face
      begins = .false.
      call find_points(old, near, point%origin, point%length, found)
      found = pack(found, [(old%list(found(k))%tip == point%tip .or. & ! or of a tip which did not move, in equilibrium
                            .not. m%particles%total_frame .and. old%list(found(k))%tip == 0 .and. &
                            old%list(found(k))%law == bonded, k=1, size(found))])
      ! of two as near the one behind, independent of rounding of the middle between them
      distance = [(abs(old%list(found(k))%way - point%way) + 1e-9_dp*old%list(found(k))%way + &
                   norm(old%list(found(k))%origin - point%origin), k=1, size(found))]
      nearest = minloc(distance, dim=1)
      if (nearest > 0) then
         if (distance(nearest) > max(old%list(found(nearest))%length, point%length)) nearest = 0
      end if
      point%start = point%opening
      if (nearest > 0) then
         associate (before => old%list(found(nearest)), part => point%length/old%list(found(nearest))%length)
            if (stays(before, point)) then
               call continue_as(point, before)
               return
            end if
            point%law = before%law
            point%initial_force = part*merge(before%initial_force, force_of(before), before%law == releasing)
            if (.not. m%particles%total_frame) point%initial_force = turned(point%initial_force, before, point)
            point%stored = part*merge(before%stored, energy_of(before), before%law == releasing)
            point%fraction_left = before%fraction_left
            point%fraction_before = before%fraction_before
            point%reached = before%reached
            if (point%law == releasing) point%start = point%opening - (before%opening - before%start)
         end associate
      else if (point%way < grown) then
         point%law = releasing
         point%fraction_left = 0
      else
         begins = .true.
         face = both_faces
         if (is_half(point)) face = merge(left_face, right_face, point%n_left > 0)
         point%initial_force = point%area*traction_at(m, point%place, point%normal, face)
      end if
      if (point%law == releasing .and. point%line > 0) &
         point%contact_offset = min(0.0_dp, dot_product(point%normal, point%opening))
   end subroutine start_bonded_point

   !> Whether a bonded point has the place in the material of an old one.
   pure logical function stays(before, point)
      type(interface_point_t), intent(in) :: before, point
      stays = .not. point%follows_leaf .and. .not. before%follows_leaf .and. abs(before%length - point%length) < same*point%length &
              .and. abs(before%way - point%way) < same*point%length
   end function stays

   !> Continue an old bonded point in other cells: the material may have rotated it.
   pure subroutine continue_as(point, before)
      type(interface_point_t), intent(inout) :: point
      type(interface_point_t), intent(in) :: before
      point%law = before%law
      point%face_state_t = before%face_state_t
      point%opening = turned(before%opening, before, point)
      point%start = turned(before%start, before, point)
      point%initial_force = turned(before%initial_force, before, point)
   end subroutine continue_as
end module hampm_interface_transfer
