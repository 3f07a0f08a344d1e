!> Interface points on the faces of cells along cracks in planes of the grid (`hampm_plane_cuts`), by area; of solids only.
!>
!> Each part of a face has a point in the middle of its bonded area. Where the faces of the crack may touch, each of their open
!> nodes has a point, for the integral of its function: fewer would leave nodes free, more would be redundant. Where nodes of cut
!> cells hang on others, functions of both sides differ, and each part has a point in its middle.
!>
!> Where fronts move on one mesh each point is in the middle of its part, with the stiffness of the bonded area. Open nodes near the
!> front have points without stiffness, whose openings start the points of new parts when cells are cut anew. A node that becomes
!> open transfers its force to its point, which releases it with the bonded area of the square around it, up to the next nodes
!> (Malluck & King, Fast fracture simulated by conventional finite elements: a comparison of two energy-release algorithms, 1980).
module hampm_plane_points
   use hampm_kinds, only: dp, ndim, long
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_face_jumps, only: faces, place_point
   use hampm_forest, only: level_width
   use hampm_interface_points, only: interfaces_t, interface_point_t, bonded, contact, add_interface_point, find_points, &
                                     along_faces, is_half
   use hampm_matter, only: matter_t
   use hampm_nearby, only: nearby_t
   use hampm_plane_cuts, only: plane_cut_t, has_face_in
   use hampm_tensors, only: norm, identity
   implicit none
   private
   public :: add_points_of_planes, follow_fronts, late_release, elements_beside, parts

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
                     if (area > 0) call add_point(interfaces, m, k, bonded, list(f)%side, middle, middle, area)
                     if (interfaces%n > n .and. cut%moves) call place_part(interfaces, m, k, part(1), at_node)
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

   !> Let the last point follow the front of a crack over its square, from the opening of its nodes.
   pure subroutine place_part(interfaces, m, number, edge, at_node)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: edge               !! of the square [m]
      integer, intent(in) :: at_node(:)          !! points of open nodes
      integer :: k
      associate (point => interfaces%list(interfaces%n), cut => m%grid%planes(number))
         call follow_front(point, number, edge)
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

   !> Let a point follow the front of a crack over a square, with its opening as before the last step.
   pure subroutine follow_front(point, number, edge)
      type(interface_point_t), intent(inout) :: point
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: edge               !! of the square [m]
      point%plane = number
      point%length = edge
      point%before = point%opening
      point%effective_opening = point%opening
   end subroutine follow_front

   !> Add the points of open nodes around which something is bonded.
   pure subroutine add_points_of_nodes(interfaces, m, number, list, old, near, at_node)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: number              !! of the crack
      type(plane_face_t), intent(in) :: list(:)  !! its faces
      type(interfaces_t), intent(in) :: old
      type(nearby_t), intent(inout) :: near      !! table of these
      integer, allocatable, intent(out) :: at_node(:)
      real(dp), parameter :: same = 1e-6_dp      ! cells
      real(dp) :: edge, area, middle(2), x(2)
      integer, allocatable :: found(:)
      integer :: f, i, j, k, n
      allocate (at_node(m%grid%n_points), source=0)
      associate (cut => m%grid%planes(number), forest => m%grid%forest)
         do f = 1, size(list)
            edge = list(f)%high(1) - list(f)%low(1)
            do j = 0, 1
               do i = 0, 1
                  x = list(f)%low + [i, j]*edge
                  if (.not. cut%opens_at(forest, cut%in_space(x))) cycle
                  call cut%unbonded(forest%level_of(list(f)%leaf))%uncracked(max(x - edge, cut%in_plane(cut%lower)), &
                                                                             min(x + edge, cut%in_plane(cut%upper)), area, middle)
                  if (.not. area > 0) cycle
                  n = interfaces%n
                  call add_point(interfaces, m, number, bonded, list(f)%side, x, (list(f)%low + list(f)%high)/2, area)
                  if (interfaces%n == n) cycle
                  associate (point => interfaces%list(interfaces%n))
                     if (count(point%jump%node > 0) /= merge(1, faces, cut%is_symmetry) .or. at_node(point%jump%node(1)) > 0) then
                        interfaces%n = n         ! at a hanging node, or there already
                        cycle
                     end if
                     at_node(point%jump%node(1)) = interfaces%n
                     point%stiffness = 0
                     point%is_new = old%n > 0
                     if (old%n > 0) point%opening = 0
                     call follow_front(point, number, 2*edge)
                     call find_points(old, near, point%origin, 0.0_dp, found)
                     do k = 1, size(found)
                        associate (before => old%list(found(k)))
                           if (before%plane /= number .or. before%stiffness > 0) cycle
                           if (norm(before%origin - point%origin) > same*edge) cycle
                           point%is_new = .false.
                           point%face_state_t = before%face_state_t
                           point%area = before%area
                           point%released = 0    ! in the step to come
                        end associate
                     end do
                  end associate
               end do
            end do
         end do
      end associate
   end subroutine add_points_of_nodes

   !> Let the points follow fronts that have moved, before a step. `released` is the work of the released forces: in an explicit
   !> step, with mid-step velocities, by the mean of this opening and the last one; else by the opening at its start, to which
   !> `late_release` is added at its end.
   pure subroutine follow_fronts(interfaces, m, is_explicit, released)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      logical, intent(in) :: is_explicit
      real(dp), intent(out) :: released(:)       !! [J], (cracks)
      real(dp), parameter :: most = 1 - epsilon(1.0_dp) ! of a force: `late_release` knows it by the rest
      real(dp) :: area, middle(2), x(2)
      integer :: k, level
      released = 0
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%plane == 0) cycle
            if (.not. is_explicit) point%before = point%opening
            if (.not. point%area > 0) then
               point%released = 0
               cycle
            end if
            associate (cut => m%grid%planes(point%plane))
               x = cut%in_plane(point%origin)
               level = nint(log(m%grid%forest%cell/(point%length*merge(2.0_dp, 0.5_dp, point%stiffness > 0)))/log(2.0_dp))
               call cut%unbonded(level)%uncracked(max(x - point%length/2, cut%in_plane(cut%lower)), &
                                                  min(x + point%length/2, cut%in_plane(cut%upper)), area, middle)
            end associate
            point%released = min(1 - min(area/point%area, 1.0_dp), most)
            released(point%plane) = released(point%plane) + mean_energy(point, point%before, point%opening)
            point%stiffness = point%stiffness*(1 - point%released)
            point%initial_force = point%initial_force*(1 - point%released)
            point%area = min(area, point%area)
         end associate
      end do
   end subroutine follow_fronts

   !> Energy taken by the points of the fronts of each crack in an implicit step beyond the value at its start [J].
   pure function late_release(interfaces, cracks) result(energy)
      type(interfaces_t), intent(in) :: interfaces
      integer, intent(in) :: cracks              !! their number
      real(dp) :: energy(cracks)
      integer :: k
      energy = 0
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%plane == 0 .or. .not. point%released > 0) cycle
            energy(point%plane) = energy(point%plane) + (mean_energy(point, point%before, point%opening) &
                                  - mean_energy(point, point%before, point%before))/(1 - point%released)
         end associate
      end do
   end function late_release

   !> Energy taken by a point for the lost part of its force between two openings [J].
   pure real(dp) function mean_energy(point, before, after) result(energy)
      type(interface_point_t), intent(in) :: point
      real(dp), intent(in) :: before(ndim), after(ndim) !! [m]
      real(dp) :: across
      energy = dot_product(before, after)
      if (is_half(point)) energy = dot_product(before, point%normal)*dot_product(after, point%normal)
      across = dot_product(point%initial_force, before + after)
      energy = point%released*(point%stiffness*energy + across)/2
   end function mean_energy

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
