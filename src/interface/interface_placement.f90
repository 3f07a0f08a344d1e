!> Placement of the interface points between the sides of cracks (`hampm_interface_points`), on each new grid: layers of bonded
!> points in the leaves in which cracks end, of contact points where faces may touch, of cohesive points where a cohesive law holds
!> them.
module hampm_interface_placement
   use hampm_kinds, only: dp, ndim
   use hampm_bonded_forces, only: balance_bonded_points
   use hampm_constraints, only: constraints_t
   use hampm_crack_lines, only: both_faces
   use hampm_cut_cells, only: end_leaf_t
   use hampm_face_jumps, only: faces, faces_at, place_of_faces_t, place_between, place_point
   use hampm_interface_points, only: interfaces_t, releasing, bonded, contact, cohesive, along_faces, add_interface_point, &
                                     find_points, sort_for_tips
   use hampm_interface_transfer, only: transfer_points, start_bonded_point
   use hampm_forest, only: forest_t, outside
   use hampm_ghost_penalty, only: stabilise_small_cut_cells, hold_lone_particles
   use hampm_matter, only: matter_t
   use hampm_nearby, only: nearby_t
   use hampm_plane_points, only: add_points_of_planes
   use hampm_part_supports, only: hold_ends_of_supports
   use hampm_tensors, only: norm, quarter_turn
   implicit none
   private
   public :: openings_t, rebuild_interfaces, find_openings

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
      type(nearby_t) :: near                     ! table of these
      integer :: k, supports, faces
      old = interfaces
      if (.not. allocated(interfaces%list)) allocate (interfaces%list(64))
      interfaces%n = 0
      interfaces%n_contact = 0
      interfaces%n_cohesive = 0
      interfaces%n_at_end = 0
      call hold_ends_of_supports(interfaces, m, constraints, old)
      supports = interfaces%n
      if (m%grid%cut_cells%are_there()) call add_interfaces_of_cracks(interfaces, m, old, near)
      if (allocated(m%grid%planes)) call add_points_of_planes(interfaces, m, old, near)
      faces = interfaces%n
      if ((m%grid%cut_cells%are_there() .or. allocated(m%grid%bodies)) .and. ndim == 2 .and. & ! solids have aggregated nodes only
          (m%grid%is_quadratic() .or. .not. interfaces%are_bounded .or. interfaces%strain_last)) &
         call stabilise_small_cut_cells(interfaces, m)
      if (interfaces%are_bounded) interfaces%n_at_end = interfaces%n
      if (m%grid%is_quadratic()) & ! ghost penalties of small cut cells have a mass
         interfaces%n_at_end = min(interfaces%n_at_end, merge(faces, supports, interfaces%n_contact + interfaces%n_cohesive > 0))
      if (.not. (interfaces%are_bounded .or. m%grid%is_quadratic())) call hold_lone_particles(interfaces, m)
      call transfer_points(interfaces, old, near)
      do k = 1, interfaces%n
         if (interfaces%list(k)%plane > 0) cycle
         interfaces%list(k)%effective_opening = interfaces%list(k)%opening
      end do
      call sort_for_tips(interfaces, resting_tips(m))
   end subroutine rebuild_interfaces

   !> How many tips there are; 0 if some have paths ahead, along which they release points.
   pure integer function resting_tips(m)
      class(matter_t), intent(in) :: m
      integer :: k
      resting_tips = 0
      if (.not. m%grid%cut_cells%are_there()) return
      associate (lines => m%grid%cut_cells%lines)
         if (.not. any([(maxval([lines(k)%bonded, lines(k)%grown]) > 0, k=1, size(lines))])) &
            resting_tips = size(m%grid%cut_cells%ends)
      end associate
   end function resting_tips

   !> Add the bonded points of all tips and the contact of all faces.
   pure subroutine add_interfaces_of_cracks(interfaces, m, old, near)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(interfaces_t), intent(in) :: old    !! the last bonded points of moving tips
      type(nearby_t), intent(inout) :: near      !! table of these
      logical, allocatable :: begins(:)
      integer :: k, s
      do k = 1, size(m%grid%cut_cells%ends)
         associate (end => m%grid%cut_cells%ends(k))
            associate (line => m%grid%cut_cells%lines(end%line))
               if (max(line%bonded(end%end), line%grown(end%end)) > 0) then
                  if (line%cohesion == 0) call add_bonded_points_of_tip(interfaces, m, k, old)
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
               call start_bonded_point(interfaces%list(s), old, near, line%grown(end%end), m, begins(s))
               if (m%particles%total_frame) begins(s) = begins(s) .and. max(line%bonded(end%end), line%grown(end%end)) > 0
            end associate
         end associate
      end do
      if (any(begins)) call balance_bonded_points(interfaces, begins, m)
      do k = 1, size(m%grid%cut_cells%lines)
         if (m%grid%cut_cells%lines(k)%cohesion > 0) call add_cohesion(interfaces, m, k)
         if (.not. m%grid%cut_cells%lines(k)%contact) cycle
         s = interfaces%n
         call add_contact(interfaces, m, k, certain=.false.)
         call leave_to_released_points(interfaces, s)
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
   pure subroutine leave_to_released_points(interfaces, n)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: n                   !! number of interface points before the contact was added
      real(dp), parameter :: reach = 0.55_dp     ! part of the length of a bonded point on either side of it
      type(nearby_t) :: near
      integer, allocatable :: found(:)
      integer :: k, s, n_kept
      if (.not. any(interfaces%list(:n)%law == releasing)) return
      n_kept = n
      do s = n + 1, interfaces%n
         call find_points(interfaces, near, interfaces%list(s)%origin, 0.0_dp, found)
         associate (point => interfaces%list(s), before => interfaces%list(pack(found, found <= n)))
            if (any([(before(k)%law == releasing .and. before(k)%line == point%line .and. &
                      norm(before(k)%place - point%place) <= reach*before(k)%length, k=1, size(before))])) cycle
         end associate
         n_kept = n_kept + 1
         interfaces%list(n_kept) = interfaces%list(s)
      end do
      interfaces%n_contact = interfaces%n_contact - (interfaces%n - n_kept)
      interfaces%n = n_kept
   end subroutine leave_to_released_points

   !> Add the bonded points of a moving tip, along its path, from zero force to the end of the cut cells. The ends of layers do not
   !> depend on the place of the tip. Where the material carries the crack through the cells, each point keeps its place in the
   !> material, with its dissipation, up to the end of the planned path; beyond is a layer in the cells, or a surface.
   pure subroutine add_bonded_points_of_tip(interfaces, m, tip, old)
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
   end subroutine add_bonded_points_of_tip

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
      integer :: e(faces)
      e = faces_at(m, x, normal, layer%face, by_edges=.true.) ! a corner may belong to the other side
      if (all(e == 0)) return
      if (any(layer%law == [cohesive, contact]) .and. all(m%blocks%count_in(pack(e, e > 0)) == 0)) return ! there is no material
      if (layer%certain .and. any(m%blocks%count_in(pack(e, e > 0)) == 0)) return
      call add_interface_point(interfaces, layer%law)
      associate (point => interfaces%list(interfaces%n))
         point%normal = normal
         point%place = x
         if (layer%certain) return
         call place_point(point, m, e, firmness, interfaces%thickness%at(x)*length)
         if (layer%line > 0) point%origin = m%grid%cut_cells%origin_of(layer%line, x)
         point%length = length
         point%friction = layer%friction
         point%line = layer%line
         point%cohesion = layer%cohesion
         point%tip = layer%tip
         point%way = layer%way
         point%is_penalty = layer%law == contact .and. .not. (layer%friction > 0 .or. any(is_cut(e)))
         if (point%is_penalty) point%stiffness = of_whole_cells*point%stiffness
         point%slip = along_faces(point, point%opening)
         point%slid = point%slip
      end associate

   contains

      !> Whether a line divides the cell of an element.
      elemental logical function is_cut(e)
         integer, intent(in) :: e                !! 0 for none
         is_cut = .false.
         if (e > 0) is_cut = m%grid%is_piece(e)
      end function is_cut
   end subroutine add_point

end module hampm_interface_placement
