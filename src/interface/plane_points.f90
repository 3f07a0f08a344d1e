!> Interface points on the faces of cells along cracks in planes of the grid (`hampm_plane_cuts`), by area; of solids only.
!>
!> Each part of a face has a point in the middle of its bonded area. Where the faces of the crack may touch, each of their open
!> nodes has a point, for the integral of its function: fewer would leave nodes free, more would be redundant. Where nodes of cut
!> cells hang on others, functions of both sides differ, and each part has a point in its middle.
!>
!> Where fronts move on one mesh each point is in the middle of its part, with the stiffness of the area bonded at first. A node
!> that becomes open transfers its force to a point of its own. A front releases both as a tip does (`held_part` of
!> `hampm_plane_cuts`, `hampm_nodal_release`): a spring becomes a force, which falls while the front advances by two cells, a node
!> with all parts of its faces. Faster release emits waves, which take from the energy of fast fronts.
module hampm_plane_points
   use hampm_kinds, only: dp, ndim, long
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_face_jumps, only: faces, place_point
   use hampm_forest, only: level_width
   use hampm_interface_points, only: interfaces_t, interface_point_t, bonded, contact, releasing, add_interface_point, &
                                     find_points, along_faces
   use hampm_matter, only: matter_t
   use hampm_nearby, only: nearby_t
   use hampm_nodal_release, only: let_fail
   use hampm_plane_cuts, only: plane_cut_t, has_face_in
   use hampm_tensors, only: norm, identity
   implicit none
   private
   public :: add_points_of_planes, follow_fronts, elements_beside, parts

   integer, parameter :: parts = 2               !! of a face along each edge

   !> Stiffness of bonded faces per area, in E'/h. Of 0.3 to 100 this leaves the least difference between places of the front in a
   !> cell (docs/explanation/solids.md).
   real(dp), parameter :: of_bonded = 1

   !> The same of faces that touch.
   real(dp), parameter :: of_contact = 3e4_dp

   !> The same with friction, which does not find its limits between faces as firm as those.
   real(dp), parameter :: of_friction = 300

   real(dp), parameter :: none = 1e-14_dp        !! share of a node

   !> A face of a cell in the plane of a crack.
   type :: plane_face_t
      integer :: leaf = 0
      integer :: side = 0                        !! on which that is: 1 above, 2 below the plane
      real(dp) :: low(2) = 0, high(2) = 0        !! its corners in the plane [m]
   end type plane_face_t

contains

   !> Add the points of all cracks.
   pure subroutine add_points_of_planes(interfaces, m, old, near)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(interfaces_t), intent(in) :: old      !! those on the mesh before
      type(nearby_t), intent(inout) :: near      !! table of these
      real(dp) :: from(2), part(2), area, middle(2)
      type(plane_face_t), allocatable :: list(:)
      integer, allocatable :: at_node(:)         ! points of open nodes, by the node of the first face; 0 where there is none
      integer :: k, f, i, j, n
      do k = 1, size(m%grid%planes)
         associate (cut => m%grid%planes(k), forest => m%grid%forest)
            list = faces_of(m, cut)
            if (cut%moves) call add_points_of_nodes(interfaces, m, k, list, old, near, at_node)
            do f = 1, size(list)
               part = (list(f)%high - list(f)%low)/parts
               do j = 1, parts
                  do i = 1, parts
                     from = list(f)%low + [i - 1, j - 1]*part
                     call cut%unbonded(forest%level_of(list(f)%leaf))%uncracked(from, from + part, area, middle)
                     if (cut%moves) middle = from + part/2
                     n = interfaces%n
                     if (cut%moves .and. old%n > 0) then ! else it has been released
                        if (cut%way_to(forest%level_of(list(f)%leaf), cut%in_space(middle)) > 0) area = product(part)
                     end if
                     if (area > 0) call add_point(interfaces, m, k, bonded, list(f)%side, middle, middle, area)
                     if (interfaces%n > n .and. cut%moves) call place_part(interfaces, m, k, part(1), at_node, old, near)
                     if (cut%contact .and. m%grid%aggregated_nodes%are_there()) &
                        call add_point(interfaces, m, k, contact, list(f)%side, from + part/2, from + part/2, product(part))
                  end do
               end do
            end do
            if (cut%contact .and. .not. m%grid%aggregated_nodes%are_there()) call add_contact(interfaces, m, k, list)
         end associate
      end do
   end subroutine add_points_of_planes

   !> The faces of cells on which a crack has points.
   pure function faces_of(m, cut) result(list)
      type(matter_t), intent(in) :: m
      type(plane_cut_t), intent(in) :: cut
      type(plane_face_t), allocatable :: list(:)
      integer :: leaf, side, n
      allocate (list(faces*m%grid%forest%leaf_count()))
      n = 0
      do leaf = 1, m%grid%forest%leaf_count()
         do side = 1, faces
            if (.not. is_of(m, cut, leaf, side)) cycle
            n = n + 1
            list(n)%leaf = leaf
            list(n)%side = side
            call cut%rectangle_of(m%grid%forest, leaf, list(n)%low, list(n)%high)
         end do
      end do
      list = list(:n)
   end function faces_of

   !> Add the points of faces that may touch.
   pure subroutine add_contact(interfaces, m, number, list)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: number              !! of the crack
      type(plane_face_t), intent(in) :: list(:)
      real(dp), allocatable :: area(:), beside(:, :) ! of nodes [m2]; the middle of a part of a face at them [m]
      integer, allocatable :: side_of(:)
      real(dp) :: part(2), weight(m%grid%n_functions, most_nodes_of_leaf)
      integer :: f, i, j, c, n, e(faces), master(most_nodes_of_leaf)
      allocate (area(m%grid%n_nodes), source=0.0_dp)
      allocate (beside(2, m%grid%n_nodes))
      allocate (side_of(m%grid%n_nodes), source=0)
      associate (cut => m%grid%planes(number))
         do f = 1, size(list)
            part = (list(f)%high - list(f)%low)/parts
            do j = 1, parts
               do i = 1, parts
                  associate (middle => list(f)%low + ([i, j] - 0.5_dp)*part)
                     e = elements_beside(m, cut, list(f)%side, cut%in_space(middle))
                     if (any(e == 0)) cycle
                     call m%grid%dofs%masters_of(m%grid%support_of(e(list(f)%side)), n, master, weight)
                     do c = 0, 3
                        associate (x => cut%in_space(middle + ([mod(c, 2), c/2] - 0.5_dp)*part), of => e(list(f)%side))
                           area(master(:n)) = area(master(:n)) + product(part)/4*matmul( &
                                              m%grid%functions_in(of, m%grid%local_coordinate(of, x)), weight(:, :n))
                        end associate
                     end do
                     do c = 1, n
                        if (any(abs(cut%in_plane(m%grid%node_position(:, master(c))) - middle) > 0.6_dp*part)) cycle
                        beside(:, master(c)) = middle
                        side_of(master(c)) = list(f)%side
                     end do
                  end associate
               end do
            end do
         end do
         do n = 1, size(area)
            if (.not. area(n) > none*maxval(area) .or. side_of(n) == 0) cycle
            associate (x => m%grid%node_position(:, n))
               if (cut%opens_at(m%grid%forest, x)) &
                  call add_point(interfaces, m, number, contact, side_of(n), cut%in_plane(x), beside(:, n), area(n))
            end associate
         end do
      end associate
   end subroutine add_contact

   !> Let the last point be released by the front of a crack, from what it was on the mesh before or the opening of its nodes; take
   !> it away if the front has released it.
   pure subroutine place_part(interfaces, m, number, edge, at_node, old, near)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: edge               !! of the part [m]
      integer, intent(in) :: at_node(:)          !! points of open nodes
      type(interfaces_t), intent(in) :: old      !! points on the mesh before
      type(nearby_t), intent(inout) :: near      !! table of these
      logical :: is_there
      integer :: k
      associate (point => interfaces%list(interfaces%n), cut => m%grid%planes(number))
         call follow_front(point, m, number, parts*edge, edge)
         call take_state(point, old, near, is_there)
         if (is_there) return
         if (old%n > 0 .and. held_part_at(point, m) < 1) then
            interfaces%n = interfaces%n - 1
            return
         end if
         associate (node => point%jump%node(:merge(point%n_left, count(point%jump%node > 0), point%n_left > 0)))
            if (any([(at_node(node(k)) == 0 .and. cut%opens_at(m%grid%forest, m%grid%node_position(:, node(k))), &
                      k=1, size(node))])) return
            point%opening = 0
            point%before = 0
            point%effective_opening = 0
            do k = 1, size(node)
               if (at_node(node(k)) == 0) cycle
               associate (open => interfaces%list(at_node(node(k))), share => abs(point%jump%share(k)))
                  point%opening = point%opening + open%opening*share
                  point%before = point%before + open%before*share
                  point%effective_opening = point%effective_opening + open%effective_opening*share
               end associate
            end do
         end associate
      end associate
   end subroutine place_part

   !> Let a point be released by the front of a crack, with its opening as before the last step.
   pure subroutine follow_front(point, m, number, cell, length)
      type(interface_point_t), intent(inout) :: point
      type(matter_t), intent(in) :: m
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: cell, length       !! of the face, and of what the point stands for: two faces at a node [m]
      point%plane = number
      point%cell = cell
      point%length = length
      point%way = m%grid%planes(number)%way_to(level_of_cell(point, m), point%origin)
      point%before = point%opening
      point%effective_opening = point%opening
   end subroutine follow_front

   !> Level of the cell beside a point of a front that moves.
   pure integer function level_of_cell(point, m) result(level)
      type(interface_point_t), intent(in) :: point
      type(matter_t), intent(in) :: m
      level = nint(log(m%grid%forest%cell/point%cell)/log(2.0_dp))
   end function level_of_cell

   !> Part of the force of a point that the front of its crack leaves now.
   pure real(dp) function held_part_at(point, m)
      type(interface_point_t), intent(in) :: point
      type(matter_t), intent(in) :: m
      held_part_at = m%grid%planes(point%plane)%held_part(level_of_cell(point, m), point%cell, point%origin, point%way, &
                                                          is_of_node(point))
   end function held_part_at

   !> Whether a point of a front that moves is at a node.
   pure logical function is_of_node(point)
      type(interface_point_t), intent(in) :: point
      is_of_node = point%length > point%cell
   end function is_of_node

   !> Give a point of a front that moves the state that it had on the mesh before.
   pure subroutine take_state(point, old, near, is_there)
      type(interface_point_t), intent(inout) :: point
      type(interfaces_t), intent(in) :: old
      type(nearby_t), intent(inout) :: near
      logical, intent(out) :: is_there           !! whether it was on that
      real(dp), parameter :: same = 1e-6_dp      ! cells
      integer, allocatable :: found(:)
      integer :: k
      is_there = .false.
      if (old%n == 0) return
      call find_points(old, near, point%origin, 0.0_dp, found)
      do k = 1, size(found)
         associate (before => old%list(found(k)))
            if (before%plane /= point%plane .or. abs(before%length - point%length) > same*point%cell) cycle
            if (norm(before%origin - point%origin) > same*point%cell) cycle
            is_there = .true.
            point%face_state_t = before%face_state_t
            point%law = before%law
            point%area = before%area
            point%stiffness = before%stiffness
         end associate
      end do
   end subroutine take_state

   !> Add the points of open nodes around which something is bonded.
   pure subroutine add_points_of_nodes(interfaces, m, number, list, old, near, at_node)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: number              !! of the crack
      type(plane_face_t), intent(in) :: list(:)  !! its faces
      type(interfaces_t), intent(in) :: old
      type(nearby_t), intent(inout) :: near      !! table of these
      integer, allocatable, intent(out) :: at_node(:)
      real(dp) :: edge, x(2)
      logical :: is_there
      integer :: f, i, j, n
      allocate (at_node(m%grid%n_points), source=0)
      associate (cut => m%grid%planes(number), forest => m%grid%forest)
         do f = 1, size(list)
            edge = list(f)%high(1) - list(f)%low(1)
            do j = 0, 1
               do i = 0, 1
                  x = list(f)%low + [i, j]*edge
                  if (.not. cut%opens_at(forest, cut%in_space(x))) cycle
                  n = interfaces%n
                  call add_point(interfaces, m, number, bonded, list(f)%side, x, (list(f)%low + list(f)%high)/2, (2*edge)**2)
                  if (interfaces%n == n) cycle
                  associate (point => interfaces%list(interfaces%n))
                     if (count(point%jump%node > 0) /= merge(1, faces, cut%is_symmetry) .or. at_node(point%jump%node(1)) > 0) then
                        interfaces%n = n         ! at a hanging node, or there already
                        cycle
                     end if
                     call follow_front(point, m, number, edge, 2*edge)
                     if (.not. held_part_at(point, m) > 0) then
                        interfaces%n = n
                        cycle
                     end if
                     at_node(point%jump%node(1)) = interfaces%n
                     point%law = releasing
                     call take_state(point, old, near, is_there)
                     point%is_new = old%n > 0 .and. .not. is_there
                     if (.not. point%is_new) cycle
                     point%opening = 0
                     point%before = 0
                     point%effective_opening = 0
                     point%fraction_left = held_part_at(point, m)
                     point%fraction_before = point%fraction_left
                  end associate
               end do
            end do
         end do
      end associate
   end subroutine add_points_of_nodes

   !> Let the points follow fronts that have moved: after an explicit step, before an implicit one.
   pure subroutine follow_fronts(interfaces, m, taken, work)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      real(dp), intent(out) :: taken(:)          !! stored energy of those that start to fail [J], (cracks)
      real(dp), intent(out) :: work(:)           !! that and the work of all since the last call [J], (cracks)
      real(dp) :: held
      integer :: k
      taken = 0
      work = 0
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%plane == 0 .or. .not. point%fraction_left > 0) cycle
            held = held_part_at(point, m)
            if (held < point%fraction_left .or. point%law == releasing) &
               call let_fail(point, held, k <= interfaces%n_at_end, taken(point%plane), work(point%plane))
         end associate
      end do
   end subroutine follow_fronts

   !> Whether a crack has points on a face of a leaf in its plane: with an open node; of two at one place the finer or upper one.
   pure logical function is_of(m, cut, leaf, side) result(is)
      type(matter_t), intent(in) :: m
      type(plane_cut_t), intent(in) :: cut
      integer, intent(in) :: leaf
      integer, intent(in) :: side                !! on which the leaf is: 1 above, 2 below the plane
      integer(long) :: place(ndim)
      integer :: other
      is = has_face_in(cut, m%grid%forest, leaf, side)
      if (is) is = cut%opens_face(m%grid%forest, leaf)
      if (.not. is .or. cut%is_symmetry) return
      place = m%grid%forest%place_of(leaf) + level_width(m%grid%forest%level_of(leaf))/2
      place(cut%axis) = cut%at + merge(-1, 0, side == 1)
      is = place(cut%axis) >= 0 .and. place(cut%axis) < m%grid%forest%cells(cut%axis)*level_width(0)
      if (.not. is) return
      other = m%grid%forest%leaf_of(place)
      is = m%grid%forest%level_of(other) < m%grid%forest%level_of(leaf) .or. &
           m%grid%forest%level_of(other) == m%grid%forest%level_of(leaf) .and. side == 1
   end function is_of

   !> The elements with material above and below a place in the plane of a crack; 0 if none, and beyond a plane of symmetry.
   pure function elements_beside(m, cut, side, x) result(e)
      type(matter_t), intent(in) :: m
      type(plane_cut_t), intent(in) :: cut
      integer, intent(in) :: side                !! on which there is material: 1 above, 2 below
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), parameter :: aside = 1e-3_dp     ! finest cells
      integer :: e(faces), k
      do k = 1, faces
         e(k) = m%grid%element_at(x + (3 - 2*k)*aside*m%grid%finest_cell*identity(:, cut%axis))
         if (e(k) > 0) e(k) = merge(e(k), 0, m%blocks%count_in(e(k)) > 0 .and. .not. (cut%is_symmetry .and. k /= side))
      end do
      if (.not. cut%is_symmetry .and. any(e == 0)) e = 0
   end function elements_beside

   !> Add a point, if there is material.
   pure subroutine add_point(interfaces, m, number, law, side, middle, beside, area)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: number              !! of the crack
      integer, intent(in) :: law                 !! `bonded` or `contact`
      integer, intent(in) :: side                !! see `elements_beside`
      real(dp), intent(in) :: middle(2)          !! in the plane [m]
      real(dp), intent(in) :: beside(2)          !! a place inside of a face that it is on [m]
      real(dp), intent(in) :: area               !! [m2]
      integer :: e(faces)
      associate (cut => m%grid%planes(number))
         e = elements_beside(m, cut, side, cut%in_space(beside))
         if (all(e == 0)) return
         call add_interface_point(interfaces, law)
         associate (point => interfaces%list(interfaces%n))
            point%normal = identity(:, cut%axis)
            point%place = cut%in_space(middle)
            point%is_penalty = law == contact .and. .not. cut%friction > 0
            call place_point(point, m, e, merge(of_contact, merge(of_friction, of_bonded, law == contact), point%is_penalty), &
                             area, none)
            point%length = sqrt(area)
            if (law /= contact) return
            point%line = number
            point%friction = cut%friction
            point%slip = along_faces(point, point%opening)
         end associate
      end associate
   end subroutine add_point
end module hampm_plane_points
