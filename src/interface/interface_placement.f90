!> Placement of the interface points between the sides of cracks (`hampm_interface_points`), on each new grid: layers of bonded
!> points in the leaves in which cracks end, of contact points where faces may touch, of cohesive points where a cohesive law holds
!> them.
!>
!> Initial forces of bonded points where cells are cut through stressed material, so that the cut changes nothing at that moment:
!> the accelerations of the nodes of both faces do not separate them,
!>
!>    C M**-1 C' x = C M**-1 S f,
!>
!> with C the weights of the nodes in the openings, M their lumped masses, f the forces on them, S the held part of these, and x the
!> forces of the points beyond the mean traction of the material. S is the length of a node's function along the points, over its
!> length along a side of a cell. Least squares of x over the lengths of the points, damped for points much shorter than a cell.
module hampm_interface_placement
   use hampm_kinds, only: dp, ndim, plane
   use hampm_constraints, only: constraints_t
   use hampm_crack_lines, only: left_face, right_face, both_faces
   use hampm_cut_cells, only: end_leaf_t
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_face_jumps, only: faces, faces_at, nearest_carrier, place_of_faces_t, place_between, jump_between, &
                                find_half_stiffness
   use hampm_interface_points, only: interfaces_t, interface_point_t, bonded, contact, cohesive, support, holds, along, &
                                     direction_of, add_interface_point, force_of, face_force, overlap_of, sliding_of, along_faces, &
                                     energy_of, is_half, add_interface_forces, vector_of, components_of
   use hampm_forest, only: forest_t, outside
   use hampm_ghost_penalty, only: stabilise_small_cut_cells, hold_lone_particles
   use hampm_jumps, only: give_nodes, jump_of
   use hampm_lapack, only: dposv
   use hampm_matter, only: matter_t
   use hampm_plane_points, only: add_points_of_planes
   use hampm_part_supports, only: hold_ends_of_supports
   use hampm_patch, only: patch_t, patch_around, internal_force, patch_mass
   use hampm_tensors, only: norm, quarter_turn
   implicit none
   private
   public :: openings_t, rebuild_interfaces, find_openings, release_length

   integer, parameter :: points = 4              !! points of Gauss in a layer
   real(dp), parameter :: outer = 0.8611363115940526_dp, inner = 0.3399810435848563_dp
   real(dp), parameter :: place(points) = [-outer, -inner, inner, outer] !! in a layer from -1 to 1
   real(dp), parameter :: of_outer = 0.3478548451374538_dp/2, of_inner = 0.6521451548625461_dp/2
   real(dp), parameter :: part(points) = [of_outer, of_inner, of_inner, of_outer] !! of the layer that each stands for

   !> Stiffness of a layer per area, in E'/h with h the distance of the nodes along the edges of cells. Of 0.3, 1, 3 and 10 the last
   !> two leave the least scatter of J between places of the tip (docs/explanation/cracks.md).
   real(dp), parameter :: firmness = 3

   !> Factor of the stiffness of contact without friction between whole cells, with the same nodes on both sides: such faces can
   !> close everywhere at once. Between cut cells that does not converge (K_II of 16 sliding cracks is off by up to 5.9 %, by 0.2 %
   !> without), and friction does not find its limits.
   real(dp), parameter :: of_whole_cells = 1e4_dp

   real(dp), parameter :: same = 1e-9_dp         !! distance within which places are the same [cells]
   real(dp), parameter :: least_part = 1e-6_dp   !! of a leaf, that a layer has at least
   real(dp), parameter :: parallel = 1e-3_dp     !! less of a direction along an axis is along a grid line of the other one

   !> Advance of a tip, in cells, in which the force of a bonded point behind it falls to 0 (`hampm_nodal_release`).
   real(dp), parameter :: release_length = 2

   !> Places at which the openings of a line are sampled. In the total frame they stay while the mesh does.
   type :: openings_t
      integer, private :: layout = -1            !! of the blocks that their particles are in
      type(place_of_faces_t), allocatable, private :: places(:)
   end type openings_t

   !> A straight part of a line within a leaf, and the interface points that are to be there.
   type :: layer_t
      integer :: law = bonded                    !! or `contact` or `cohesive`
      integer :: cohesion = 0                    !! number of the law of that
      real(dp) :: from(ndim) = 0                 !! [m]
      real(dp) :: to(ndim) = 0                   !! [m]
      real(dp) :: friction = 0                   !! coefficient [-]
      logical :: certain = .false.               !! whether only for openings, where both pieces have particles
      integer :: line = 0                        !! number of the crack, of `contact` and `cohesive`
      integer :: tip = 0                         !! number of the tip that moves over it, 0 for none
      real(dp) :: way = 0                        !! of that tip to `from` [m]
      integer :: face = both_faces               !! which faces have material
   end type layer_t

contains

   !> Find the interface points of a new grid. New points have the openings of the particles beside them.
   pure subroutine rebuild_interfaces(interfaces, m, constraints)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(constraints_t), intent(in) :: constraints
      type(interfaces_t) :: old
      integer :: k, supports, faces
      old = interfaces
      if (.not. allocated(interfaces%list)) allocate (interfaces%list(64))
      interfaces%n = 0
      interfaces%n_contact = 0
      interfaces%n_cohesive = 0
      interfaces%n_at_end = 0
      call hold_ends_of_supports(interfaces, m, constraints)
      supports = interfaces%n
      if (m%grid%cut_cells%are_there()) call add_interfaces_of_cracks(interfaces, m, old)
      if (allocated(m%grid%planes)) call add_points_of_planes(interfaces, m, old)
      faces = interfaces%n
      if ((m%grid%cut_cells%are_there() .or. allocated(m%grid%bodies)) .and. ndim == 2 .and. & ! solids have aggregated nodes only
          (m%grid%is_quadratic() .or. .not. interfaces%are_bounded .or. interfaces%strain_last)) &
         call stabilise_small_cut_cells(interfaces, m)
      if (interfaces%are_bounded) interfaces%n_at_end = interfaces%n
      if (m%grid%is_quadratic()) & ! ghost penalties of small cut cells have a mass
         interfaces%n_at_end = min(interfaces%n_at_end, merge(faces, supports, interfaces%n_contact + interfaces%n_cohesive > 0))
      if (.not. (interfaces%are_bounded .or. m%grid%is_quadratic())) call hold_lone_particles(interfaces, m)
      call go_on(interfaces, old)
      do k = 1, interfaces%n
         if (interfaces%list(k)%plane > 0) cycle
         interfaces%list(k)%felt = interfaces%list(k)%opening
      end do
   end subroutine rebuild_interfaces

   !> Add the bonded points of all tips and the contact of all faces.
   pure subroutine add_interfaces_of_cracks(interfaces, m, old)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(interfaces_t), intent(in) :: old    !! the last bonded points of moving tips
      logical, allocatable :: begins(:)
      integer :: k, s
      do k = 1, size(m%grid%cut_cells%ends)
         associate (end => m%grid%cut_cells%ends(k))
            associate (line => m%grid%cut_cells%lines(end%line))
               if (max(line%bonded(end%end), line%grown(end%end)) > 0) then
                  if (line%cohesion == 0) call add_cohesive_points_of_tip(interfaces, m, k, old)
               else if (end%leaf > 0) then
                  call add_along(interfaces, m, reshape([end%tip, end%front], [ndim, 2]), &
                                 layer_t(bonded, tip=merge(0, k, m%particles%total_frame), face=line%face))
               end if
            end associate
         end associate
      end do
      allocate (begins(interfaces%n), source=.false.)
      do s = 1, interfaces%n
         if (interfaces%list(s)%tip == 0) cycle
         associate (end => m%grid%cut_cells%ends(interfaces%list(s)%tip))
            associate (line => m%grid%cut_cells%lines(end%line))
               call begin_cohesive_point(interfaces%list(s), old, line%grown(end%end), m, begins(s))
               if (max(line%bonded(end%end), line%grown(end%end)) > 0) begins(s) = .false. ! see docs/explanation/growth.md
            end associate
         end associate
      end do
      if (.not. m%particles%total_frame .and. any(begins)) call balance_cohesive_points(interfaces, begins, m)
      do k = 1, size(m%grid%cut_cells%lines)
         if (m%grid%cut_cells%lines(k)%cohesion > 0) call add_cohesion(interfaces, m, k)
         if (.not. m%grid%cut_cells%lines(k)%contact) cycle
         s = interfaces%n
         call add_contact(interfaces, m, k, certain=.false.)
         call leave_to_cohesive_points(interfaces, s)
      end do
   end subroutine add_interfaces_of_cracks

   !> Add cohesion along the part of a line that it holds, of one that ends in the material to where the cells that are cut do.
   pure subroutine add_cohesion(interfaces, m, number)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: number              !! of the line
      real(dp), allocatable :: points(:, :)
      integer :: k
      associate (line => m%grid%cut_cells%lines(number))
         allocate (points, source=line%held_part())
         do k = 1, size(m%grid%cut_cells%ends)
            associate (end => m%grid%cut_cells%ends(k), n => size(points, 2))
               if (end%line == number .and. end%end == 2 .and. line%bonded(2) > 0 .and. &
                   norm(points(:, n) - line%points(:, size(line%points, 2))) <= m%grid%cut_cells%slack) points(:, n) = end%front
            end associate
         end do
         call add_along(interfaces, m, points, layer_t(cohesive, line%cohesion, friction=line%friction, line=number, &
                                                       face=line%face))
      end associate
   end subroutine add_cohesion

   !> Drop contact where bonded points have failed, whose faces press on each other by themselves.
   pure subroutine leave_to_cohesive_points(interfaces, n)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: n                   !! number of interface points before the contact was added
      real(dp), parameter :: reach = 0.55_dp     ! part of the length of a bonded point on either side of it
      integer :: k, s, fraction_left
      fraction_left = n
      do s = n + 1, interfaces%n
         associate (point => interfaces%list(s))
            if (any([(interfaces%list(k)%is_failing .and. interfaces%list(k)%line == point%line .and. &
                      norm(interfaces%list(k)%place - point%place) <= reach*interfaces%list(k)%length, k=1, n)])) cycle
         end associate
         fraction_left = fraction_left + 1
         interfaces%list(fraction_left) = interfaces%list(s)
      end do
      interfaces%n_contact = interfaces%n_contact - (interfaces%n - fraction_left)
      interfaces%n = fraction_left
   end subroutine leave_to_cohesive_points

   !> Transfer the state of old points to new points at the same places: particles give only the opening of a linear field between
   !> the nodes, and repeated changes of the mesh elsewhere would erase the rest of it and return other work than was put in. Points
   !> of faces are transferred between old places too.
   pure subroutine go_on(interfaces, old)
      type(interfaces_t), intent(inout) :: interfaces
      type(interfaces_t), intent(in) :: old    !! those on the grid before
      integer :: s, k, i
      logical :: is_there
      k = 0
      do s = 1, interfaces%n
         associate (point => interfaces%list(s))
            if (point%tip > 0 .and. .not. (point%is_failing .and. point%line > 0)) cycle ! see `begin_cohesive_point`
            if (point%plane > 0) cycle           ! see `hampm_plane_points`
            is_there = .false.
            do i = 1, old%n                      ! most follow each other as before
               k = mod(k, old%n) + 1
               associate (before => old%list(k))
                  if (.not. is_before(before, point)) cycle
                  is_there = max(norm(before%origin - point%origin), abs(before%length - point%length)) <= same*point%cell
                  if (.not. is_there) cycle
                  if (point%tip == 0) then
                     point%opening = turned(before%opening, before, point)
                     point%rate = turned(before%rate, before, point)
                  end if
                  if (point%line > 0) call go_on_as(point, before, old%keep_slip)
                  exit
               end associate
            end do
            if (.not. is_there .and. point%line > 0) call go_on_between(point, old)
         end associate
      end do
   end subroutine go_on

   !> Interpolate the state of a point between faces from the nearest old points on either side of it, or the means of those equally
   !> near. Beside all of them it has the state of the last, within its length. In space it has the state of the nearest.
   pure subroutine go_on_between(point, old)
      type(interface_point_t), intent(inout) :: point
      type(interfaces_t), intent(in) :: old
      type(interface_point_t) :: one, mean(2)
      real(dp) :: distance, least(2), cell(2), length(2)
      integer :: k, side, n(2)
      n = 0
      least = huge(least)
      cell = 0
      length = 0
      do k = 1, old%n
         if (.not. is_before(old%list(k), point)) cycle
         distance = norm(old%list(k)%origin - point%origin)
         side = merge(1, 2, ndim > plane .or. dot_product(along(point), old%list(k)%place - point%place) < 0)
         if (distance > least(side) + same*point%cell) cycle
         if (distance < least(side) - same*point%cell) n(side) = 0
         one = point
         call go_on_as(one, old%list(k), old%keep_slip)
         if (n(side) == 0) then
            mean(side) = one
            cell(side) = 0
            length(side) = 0
         end if
         n(side) = n(side) + 1
         mean(side) = between(mean(side), one, 1.0_dp/n(side))
         least(side) = distance
         cell(side) = max(cell(side), old%list(k)%cell)
         length(side) = max(length(side), old%list(k)%length)
      end do
      side = minloc(least, dim=1)
      if (all(least <= cell)) then
         point = between(mean(1), mean(2), least(1)/sum(least))
      else if (least(side) <= length(side)) then
         point = mean(side)
      end if
   end subroutine go_on_between

   !> A point between faces that is a part of the way from one to another.
   pure type(interface_point_t) function between(one, other, part)
      type(interface_point_t), intent(in) :: one, other
      real(dp), intent(in) :: part
      between = one
      between%opening = one%opening + part*(other%opening - one%opening)
      between%touch = one%touch + part*(other%touch - one%touch)
      between%start = one%start + part*(other%start - one%start)
      between%carried = one%carried + part*(other%carried - one%carried)
      between%spare = one%spare + part*(other%spare - one%spare)
      between%pressed = one%pressed + part*(other%pressed - one%pressed)
      between%slip = one%slip + part*(other%slip - one%slip)
      between%slid = one%slid + part*(other%slid - one%slid)
      between%damage = one%damage + part*(other%damage - one%damage)
      between%taken = one%taken + part*(other%taken - one%taken)
   end function between

   !> Whether an old point is a predecessor of another one: faces that press on each other may have been a point that has failed.
   pure logical function is_before(before, point)
      type(interface_point_t), intent(in) :: before, point
      is_before = before%line == point%line
      if (.not. is_before) return
      if (point%tip > 0) then
         is_before = before%tip == point%tip .and. before%is_failing
      else
         is_before = merge(before%tip == 0, before%is_failing, before%law == point%law)
         if (point%law == support) is_before = is_before .and. norm(before%normal - point%normal) <= same
      end if
   end function is_before

   !> Rotate a vector at an old point, across and along the faces, to its successor: material may have rotated it, and bonded points
   !> follow the path of their tip, contact the points of its crack.
   pure function turned(vector, before, point)
      real(dp), intent(in) :: vector(ndim)
      type(interface_point_t), intent(in) :: before, point
      real(dp) :: turned(ndim)
      turned = vector_of(point, components_of(before, vector))
   end function turned

   !> Copy the state of faces: damage; or, per length, pressure and friction force, and separated faces stay so. Overlap and sliding
   !> are copied too, and take effect gradually (`ease_faces`), as the layer is another one.
   pure subroutine go_on_as(point, before, keep_slip)
      type(interface_point_t), intent(inout) :: point
      type(interface_point_t), intent(in) :: before
      logical, intent(in) :: keep_slip           !! whether slip since the last step is not yet committed
      real(dp) :: felt(ndim), strain(ndim), across, firmer
      integer :: d
      if (point%tip == 0) point%opening = turned(before%opening, before, point) ! else it has one of its own
      point%damage = before%damage
      point%taken = before%taken
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
      felt = firmer*strain
      if (point%law == contact) then
         if (before%law == contact) strain = strain + turned(before%start, before, point)
         point%start = strain - felt
      else
         strain = felt
      end if
      associate (n => point%normal)
         across = dot_product(n, strain)
         if (.not. dot_product(n, felt + point%carried) < 0) across = max(0.0_dp, -overlap_of(before))
         if (point%law == contact) then
            point%opening = point%opening + (across - dot_product(n, point%opening))*n
         else
            point%touch = dot_product(n, point%opening) - across
         end if
         point%pressed = max(0.0_dp, -dot_product(n, felt + point%carried))
         point%slip = along_faces(point, point%opening - strain)
      end associate
   end subroutine go_on_as

   !> Add the bonded points of a moving tip, along its path, from zero force to the end of the cut cells. The ends of layers do not
   !> depend on the place of the tip. Where the material carries the crack through the cells, each point keeps its place in the
   !> material, with its dissipation, up to the end of the planned path; beyond is a layer in the cells, or a surface.
   pure subroutine add_cohesive_points_of_tip(interfaces, m, tip, old)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: tip                 !! its number
      type(interfaces_t), intent(in) :: old
      real(dp), allocatable :: points(:, :)
      real(dp) :: after
      integer :: k
      type(layer_t) :: kind
      associate (end => m%grid%cut_cells%ends(tip))
         associate (line => m%grid%cut_cells%lines(end%line))
            kind = layer_t(bonded, tip=tip, face=line%face, line=merge(end%line, 0, line%contact), friction=line%friction)
            after = line%grown(end%end)
            do k = 1, old%n
               if (old%list(k)%tip == tip .and. old%list(k)%fraction_left > 0) after = min(after, old%list(k)%way &
                                                                                           - old%list(k)%length/2)
            end do
            if (.not. allocated(line%origin)) then
               allocate (points, source=line%new_part(end%end))
               points(:, size(points, 2)) = end%front
               call add_along(interfaces, m, points, kind, after)
               return
            end if
            call add_points_in_material(interfaces, m, end, kind, after)
         end associate
      end associate
   end subroutine add_cohesive_points_of_tip

   !> The same along a line that the material carries, from a way of the tip on.
   pure subroutine add_points_in_material(interfaces, m, end, of_tip, after)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(end_leaf_t), intent(in) :: end
      type(layer_t), intent(in) :: of_tip
      real(dp), intent(in) :: after              !! [m]
      type(layer_t) :: kind
      real(dp), allocatable :: rest(:, :)
      real(dp) :: length, way
      integer :: k, n, last
      kind = of_tip
      n = interfaces%n
      length = m%grid%finest_cell/points
      associate (line => m%grid%cut_cells%lines(end%line))
         way = line%grown(end%end) + line%bonded(end%end)
         last = floor(way/length*(1 + same))
         if (line%is_through(end%end)) last = nint((way - line%beyond(end%end))/length) ! beyond is no material
         do k = max(1, floor(after/length + same) + 1), last
            kind%way = (k - 0.5_dp)*length
            associate (ahead => line%new_part(end%end, kind%way))
               call add_point(interfaces, m, kind, ahead(:, 1), left_of(ahead(:, 2) - ahead(:, 1)), length)
            end associate
         end do
         kind%way = last*length
         allocate (rest, source=line%new_part(end%end, kind%way))
         rest(:, size(rest, 2)) = end%front
         if (.not. line%is_through(end%end) .and. &
             norm(rest(:, size(rest, 2)) - rest(:, size(rest, 2) - 1)) > least_part*m%grid%finest_cell) &
            call add_along(interfaces, m, rest, kind)
      end associate
      do k = n + 1, interfaces%n
         interfaces%list(k)%origin = m%grid%cut_cells%origin_of(end%line, interfaces%list(k)%place)
      end do
   end subroutine add_points_in_material

   !> Unit vector to the left of a direction.
   pure function left_of(direction) result(normal)
      real(dp), intent(in) :: direction(ndim)    !! of any length
      real(dp) :: normal(ndim)
      normal = quarter_turn(direction)/norm(direction)
   end function left_of

   !> Start a bonded point of a moving tip, or of one carried through the cells: with its state on the last grid, or with the
   !> traction of the material.
   pure subroutine begin_cohesive_point(point, old, grown, m, begins)
      type(interface_point_t), intent(inout) :: point
      type(interfaces_t), intent(in) :: old
      real(dp), intent(in) :: grown              !! way of the tip so far [m]
      type(matter_t), intent(in) :: m
      logical, intent(out) :: begins             !! whether it is new, and the crack has not reached it
      real(dp), allocatable :: distance(:)
      integer :: k, nearest, face
      allocate (distance(old%n))
      begins = .false.
      ! of two as near the one behind, independent of rounding of the middle between them
      distance = [(abs(old%list(k)%way - point%way) + 1e-9_dp*old%list(k)%way + norm(old%list(k)%origin - point%origin), &
                   k=1, old%n)]
      nearest = minloc(distance, dim=1, mask=[(old%list(k)%tip == point%tip .or. & ! or of a tip which did not move, in equilibrium
                                               .not. m%particles%total_frame .and. old%list(k)%tip == 0 .and. &
                                               old%list(k)%law == bonded, k=1, old%n)])
      if (nearest > 0) then
         if (distance(nearest) > max(old%list(nearest)%length, point%length)) nearest = 0
      end if
      if (nearest > 0) then
         if (stays(old%list(nearest), point)) then
            call continue_as(point, old%list(nearest))
            return
         end if
      end if
      point%start = point%opening
      if (nearest > 0) then
         associate (before => old%list(nearest))
            point%held = point%length/before%length*merge(before%held, force_of(before), before%is_failing)
            if (.not. m%particles%total_frame) point%held = turned(point%held, before, point)
            point%stored = point%length/before%length*merge(before%stored, energy_of(before), before%is_failing)
            point%is_failing = before%is_failing
            point%fraction_left = before%fraction_left
            point%reached = before%reached
            if (point%is_failing) point%start = point%opening - (before%opening - before%start)
            if (point%is_failing .and. point%line > 0) point%touch = min(0.0_dp, dot_product(point%normal, point%opening))
         end associate
      else if (point%way < grown) then
         point%is_failing = .true.
         point%fraction_left = 0
         if (point%line > 0) point%touch = min(0.0_dp, dot_product(point%normal, point%opening))
      else
         begins = .true.
         face = both_faces
         if (is_half(point)) face = merge(left_face, right_face, point%n_left > 0)
         point%held = point%area*traction_at(m, point%place, point%normal, face)
      end if
   end subroutine begin_cohesive_point

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
      point%opening = turned(before%opening, before, point)
      point%start = turned(before%start, before, point)
      point%held = turned(before%held, before, point)
      point%stored = before%stored
      point%is_failing = before%is_failing
      point%fraction_left = before%fraction_left
      point%reached = before%reached
      point%touch = before%touch
      point%slip = before%slip
      point%slid = before%slid
      point%pressed = before%pressed
   end subroutine continue_as

   !> Traction in the material on both sides of a line, on its right side [Pa], by the mean stress of the particles of the leaf.
   !> On a symmetry plane the mean with the mirror image has no part along it.
   pure function traction_at(m, x, normal, face) result(traction)
      type(matter_t), intent(in) :: m
      real(dp), intent(in) :: x(ndim)            !! on the line [m]
      real(dp), intent(in) :: normal(ndim)       !! unit vector to its left
      integer, intent(in) :: face                !! which faces have material
      real(dp) :: traction(ndim)
      integer :: e(faces), side, i
      real(dp) :: volume
      traction = 0
      volume = 0
      e = faces_at(m, x, normal, face)
      do side = 1, faces
         if (e(side) == 0) cycle
         associate (carrier => nearest_carrier(m, e(side), x))
            do i = m%blocks%first_in(carrier), m%blocks%last_in(carrier), m%blocks%stride_in(carrier)
               volume = volume + m%particles%volume(i)
               traction = traction + m%particles%volume(i) &
                     *matmul(m%materials(m%particles%material(i))%first_piola_stress(m%particles%gradient_of(i), &
                                                                                     m%particles%history_of(i), &
                                                                                     m%particles%hoop_of(i)), normal)
            end do
         end associate
      end do
      if (volume > 0) traction = traction/volume
      if (face /= both_faces) traction = dot_product(traction, normal)*normal
   end function traction_at

   !> The least opening normal to a line, over the ends of the leaves, and the largest jump between its faces [m]; 0 if there are
   !> none.
   pure subroutine find_openings(m, line, openings, least, largest)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: line
      type(openings_t), intent(inout) :: openings !! of the last time
      real(dp), intent(out) :: least, largest
      real(dp) :: jump(ndim)
      type(interfaces_t) :: interfaces
      integer :: k
      associate (face => m%grid%cut_cells%lines(line)%face)
         if (.not. m%particles%total_frame .or. openings%layout /= m%blocks%layout) then
            call add_contact(interfaces, m, line, certain=.true.)
            if (allocated(openings%places)) deallocate (openings%places)
            allocate (openings%places(interfaces%n))
            do k = 1, interfaces%n
               associate (point => interfaces%list(k))
                  openings%places(k) = place_between(m, faces_at(m, point%place, point%normal, face, by_edges=.true.), &
                                                     point%place, point%normal)
               end associate
            end do
            openings%layout = m%blocks%layout
         end if
         least = 0
         largest = 0
         do k = 1, size(openings%places)
            associate (normal => openings%places(k)%normal)
               jump = openings%places(k)%jump(m%particles)
               if (face /= both_faces) jump = 2*dot_product(normal, jump)*normal
               least = min(least, dot_product(normal, jump))
               largest = max(largest, norm(jump))
            end associate
         end do
      end associate
   end subroutine find_openings

   !> Add contact along a line, leaf by leaf, up to its tips.
   pure subroutine add_contact(interfaces, m, line, certain)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: line
      logical, intent(in) :: certain             !! see `layer_t`
      associate (of => m%grid%cut_cells%lines(line))
         if (of%cohesion > 0 .and. .not. any(of%bonded > 0)) return ! that is all along it
         call add_along(interfaces, m, of%free_part(), &
                        layer_t(contact, friction=of%friction, certain=certain, line=line, face=of%face))
      end associate
   end subroutine add_contact

   !> Add layers of a kind along a polyline, from edge to edge of each leaf, independent of its direction, along a grid line by the
   !> leaves of both faces; with `after` none that end before that distance from its first point.
   pure subroutine add_along(interfaces, m, points, kind, after)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      real(dp), intent(in) :: points(:, :)       !! [m]
      type(layer_t), intent(in) :: kind          !! without its ends
      real(dp), intent(in), optional :: after    !! [m]
      real(dp) :: direction(ndim), aside(ndim, faces), x(ndim), from, to, length, step, way
      type(layer_t) :: layer
      integer :: i, side, leaf(faces)
      way = kind%way
      associate (forest => m%grid%forest)
         do i = 2, size(points, 2)
            length = norm(points(:, i) - points(:, i - 1))
            direction = (points(:, i) - points(:, i - 1))/length
            aside = spread(direction, 2, faces)
            if (any(abs(direction) < parallel)) then
               do side = 1, faces                ! of a line with one face both are that
                  aside(:, side) = direction + (3 - 2*merge(side, kind%face, kind%face == both_faces))*quarter_turn(direction)
               end do
            end if
            aside = least_part*forest%cell*aside
            from = 0
            do while (from < length)
               x = points(:, i - 1) + from*direction
               step = huge(step)
               do side = 1, faces
                  leaf(side) = forest%leaf_at(x + aside(:, side))
                  step = min(step, way_to_edge(forest, leaf(side), x, direction, aside(:, side)))
               end do
               to = from + step
               if (to > length - least_part*forest%cell) to = length
               layer = kind
               layer%from = points(:, i - 1) + from*direction
               layer%to = points(:, i - 1) + to*direction
               layer%way = way + from
               if (present(after)) then
                  if (way + to < after) leaf = outside
               end if
               if (any(leaf /= outside)) call add_layer(interfaces, m, layer)
               from = to
            end do
            way = way + length
         end do
      end associate
   end subroutine add_along

   !> Distance along a line from a place to the edge at which it leaves its leaf or, outside the lattice, enters it [m].
   pure real(dp) function way_to_edge(forest, leaf, x, direction, aside) result(way)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf                !! may be `outside`
      real(dp), intent(in) :: x(ndim)            !! on the line [m]
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      real(dp), intent(in) :: aside(ndim)        !! from the line to the leaf [m]
      real(dp) :: beside(ndim)
      beside = x + merge(0.0_dp, aside, abs(direction) > parallel)
      if (leaf == outside) then
         way = max(way_into(forest, beside, direction), least_part*forest%cell)
         return
      end if
      way = max(min(forest%way_out(leaf, beside, direction, least_part), 2*forest%size_of(leaf)), &
                least_part*forest%size_of(leaf))
   end function way_to_edge

   !> Distance along a line from a place outside a lattice to its edge [m]; huge if the line misses it.
   pure real(dp) function way_into(forest, x, direction) result(way)
      type(forest_t), intent(in) :: forest
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      integer :: d
      way = 0
      do d = 1, ndim
         associate (lower => forest%lower(d), upper => forest%lower(d) + forest%cells(d)*forest%cell)
            if (x(d) >= upper .and. .not. direction(d) < 0 .or. x(d) < lower .and. .not. direction(d) > 0) then
               way = huge(way)
               return
            end if
            if (x(d) < lower) way = max(way, (lower - x(d))/direction(d))
            if (x(d) >= upper) way = max(way, (upper - x(d))/direction(d))
         end associate
      end do
   end function way_into

   !> Add the interface points of a layer.
   pure subroutine add_layer(interfaces, m, layer)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(layer_t), intent(in) :: layer
      type(layer_t) :: of_point
      real(dp) :: normal(ndim)
      integer :: i, before
      associate (from => layer%from, to => layer%to)
         if (.not. norm(to - from) > 0) return
         normal = left_of(to - from)
         of_point = layer
         do i = 1, points, merge(points - 1, 1, layer%certain) ! an opening is linear along a leaf
            of_point%way = layer%way + (1 + place(i))/2*norm(to - from)
            if (layer%law == cohesive) of_point%way = layer%way + sum(part(:i - 1))*norm(to - from)
            before = interfaces%n
            call add_point(interfaces, m, of_point, (from + to)/2 + place(i)*(to - from)/2, normal, part(i)*norm(to - from))
            if (interfaces%n == before) cycle
            interfaces%list(interfaces%n)%middle = from + (sum(part(:i - 1)) + part(i)/2)*(to - from)
            interfaces%list(interfaces%n)%follows_leaf = .true.
         end do
      end associate
   end subroutine add_layer

   !> Add an interface point at a place of a line, with a length around it, where there is material on both sides.
   pure subroutine add_point(interfaces, m, layer, x, normal, length)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(layer_t), intent(in) :: layer
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: normal(ndim)       !! unit vector to the left of the line
      real(dp), intent(in) :: length             !! [m]
      real(dp) :: weight(m%grid%n_functions, most_nodes_of_leaf)
      integer :: side, e(faces), master(most_nodes_of_leaf), n, j
      e = faces_at(m, x, normal, layer%face, by_edges=.true.) ! a corner may belong to the other side
      if (all(e == 0)) return
      if (any(layer%law == [cohesive, contact]) .and. all(m%blocks%count_in(pack(e, e > 0)) == 0)) return ! there is no material
      if (layer%certain .and. any(m%blocks%count_in(pack(e, e > 0)) == 0)) return
      call add_interface_point(interfaces, layer%law)
      associate (point => interfaces%list(interfaces%n))
         point%normal = normal
         point%place = x
         if (layer%certain) return
         point%opening = jump_between(m, e, x)
         point%middle = x
         point%origin = x
         if (layer%line > 0) point%origin = m%grid%cut_cells%origin_of(layer%line, x)
         point%length = length
         point%area = interfaces%thickness%at(x)*length
         point%friction = layer%friction
         point%line = layer%line
         point%cohesion = layer%cohesion
         point%tip = layer%tip
         point%way = layer%way
         call find_half_stiffness(m, e, x, firmness, point%cell, point%stiffness)
         point%stiffness = point%stiffness*point%area
         point%is_firm = layer%law == contact .and. .not. (layer%friction > 0 .or. any(is_cut(e)))
         if (point%is_firm) point%stiffness = of_whole_cells*point%stiffness
         n = 0
         do side = 1, faces
            if (e(side) == 0) cycle
            associate (element => nearest_carrier(m, e(side), x))
               call m%grid%dofs%masters_of(m%grid%support_of(element), j, master, weight)
               point%node(n + 1:n + j) = master(:j)
               point%share(n + 1:n + j) = (3 - 2*side)*matmul(m%grid%functions_in(element, m%grid%local_coordinate(element, x)), &
                                                               weight(:, :j))
               n = n + j
               if (side == 1) point%n_left = n
            end associate
         end do
         point%slip = along_faces(point, point%opening)
         point%slid = point%slip
         point%pressed = max(0.0_dp, -dot_product(normal, point%opening))
      end associate

   contains

      !> Whether a line divides the cell of an element.
      elemental logical function is_cut(e)
         integer, intent(in) :: e                !! 0 for none
         is_cut = .false.
         if (e > 0) is_cut = m%grid%is_piece(e)
      end function is_cut
   end subroutine add_point

   !> Let new bonded points hold their faces together as the uncut cells did.
   pure subroutine balance_cohesive_points(interfaces, begins, m)
      type(interfaces_t), intent(inout) :: interfaces
      logical, intent(in) :: begins(:)
      type(matter_t), intent(in) :: m
      real(dp), parameter :: firm = 0.005_dp     ! relative damping of least squares: small except for short layers
      real(dp), allocatable :: mass(:), held(:)
      real(dp) :: damping
      real(dp), allocatable :: force(:, :), inverse(:, :), moved(:, :) ! moved: by a unit force of a bonded point [1/kg]
      real(dp) :: matrix(count(begins), count(begins)), x(count(begins), ndim), change(ndim)
      integer, allocatable :: new(:)
      integer :: i, j, info
      allocate (force(ndim, m%grid%n_nodes), inverse(ndim, m%grid%n_nodes), moved(ndim, m%grid%n_nodes))
      allocate (mass(m%grid%n_nodes), held(m%grid%n_nodes))
      call load_nodes(interfaces, m, mass, force)
      new = pack([(i, i=1, interfaces%n)], begins)
      held = 0
      do i = 1, size(new)
         associate (point => interfaces%list(new(i)))
            do j = 1, count(point%node > 0)      ! its function along them, over that on a side of a cell
               held(point%node(j)) = held(point%node(j)) + abs(point%share(j))*point%length/(point%cell/2)
            end do
         end associate
      end do
      inverse = spread(merge(1/max(mass, tiny(mass)), 0.0_dp, mass > 0), 1, ndim)
      force = inverse*spread(min(1.0_dp, held), 1, ndim)*force
      damping = 0
      do i = 1, size(new)
         associate (point => interfaces%list(new(i)), n => count(interfaces%list(new(i))%node > 0))
            damping = max(damping, firm*point%cell*sum(point%share(:n)**2/mass(point%node(:n))))
            x(i, :) = sqrt(point%length)*jump_of(point%jump_t, force)
            moved = 0
            call give_nodes(point%jump_t, spread(1.0_dp, 1, ndim), moved, inverse)
            do j = 1, size(new)
               change = jump_of(interfaces%list(new(j))%jump_t, moved)
               matrix(i, j) = sqrt(point%length*interfaces%list(new(j))%length)*change(1)
            end do
         end associate
      end do
      do i = 1, size(new)
         matrix(i, i) = matrix(i, i) + damping
      end do
      call dposv('L', size(new), ndim, matrix, size(new), x, size(new), info)
      if (info /= 0) return                      ! NaN: reported elsewhere
      do i = 1, size(new)
         interfaces%list(new(i))%held = interfaces%list(new(i))%held + sqrt(interfaces%list(new(i))%length)*x(i, :)
      end do
   end subroutine balance_cohesive_points

   !> Lumped masses of the nodes of interface points, and the forces on them of the particles (hanging nodes included) and of the
   !> points; masses of other nodes are 0.
   pure subroutine load_nodes(interfaces, m, mass, force)
      type(interfaces_t), intent(in) :: interfaces
      type(matter_t), intent(in) :: m
      real(dp), intent(out) :: mass(:)           !! [kg]
      real(dp), intent(out) :: force(:, :)       !! [N], (ndim, nodes)
      logical :: is_wanted(size(mass))
      type(patch_t) :: patch
      real(dp) :: weight(1, most_nodes_of_leaf)
      integer :: node, n, j, k, master(most_nodes_of_leaf)
      is_wanted = .false.
      do k = 1, interfaces%n
         is_wanted(pack(interfaces%list(k)%node, interfaces%list(k)%node > 0)) = .true.
      end do
      mass = 0
      force = 0
      do node = 1, m%grid%n_points
         call m%grid%dofs%masters_of([node], n, master, weight)
         if (.not. any(is_wanted(master(:n)))) cycle
         call patch_around(m%grid, m%particles, m%blocks, node, patch)
         do j = 1, n
            mass(master(j)) = mass(master(j)) + weight(1, j)*patch_mass(patch, m%particles)
            force(:, master(j)) = force(:, master(j)) + weight(1, j)*internal_force(patch, m%particles, m%materials)
         end do
      end do
      ! Particles on an edge of a cell do not load the nodes at the opposite one: avoid division by next to nothing
      where (is_wanted) mass = max(mass, epsilon(mass)*maxval(mass), tiny(mass))
      call add_interface_forces(interfaces, 1, force)
   end subroutine load_nodes
end module hampm_interface_placement
