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
   use hampm_face_jumps, only: faces, find_half_stiffness, jump_between
   use hampm_forest, only: level_width
   use hampm_interface_points, only: interfaces_t, interface_point_t, bonded, contact, add_interface_point, along_faces, &
                                     interface_energy, is_half
   use hampm_matter, only: matter_t
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
   real(dp), parameter :: of_rubbing = 300

   real(dp), parameter :: none = 1e-14_dp        !! share of a node

contains

   !> Add the points of all cracks.
   pure subroutine add_points_of_planes(interfaces, m, old)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(interfaces_t), intent(in) :: old      !! those on the mesh before
      real(dp) :: low(2), high(2), part(2), area, middle(2)
      real(dp), allocatable :: opening(:, :, :)  ! of nodes, where it is known: now, before the last step, and felt in that [m]
      logical, allocatable :: is_known(:)
      integer :: k, leaf, side, i, j
      allocate (opening(ndim, 3, 0), is_known(0))
      do k = 1, size(m%grid%planes)
         associate (cut => m%grid%planes(k), forest => m%grid%forest)
            if (cut%moves) call add_points_of_nodes(interfaces, m, k, old, opening, is_known)
            do leaf = 1, forest%leaf_count()
               do side = 1, faces
                  if (.not. is_of(m, cut, leaf, side)) cycle
                  call cut%rectangle_of(forest, leaf, low, high)
                  part = (high - low)/parts
                  do j = 1, parts
                     do i = 1, parts
                        associate (from => low + [i - 1, j - 1]*part)
                           call cut%unbonded(forest%level_of(leaf))%uncracked(from, from + part, area, middle)
                           if (cut%moves) middle = from + part/2
                           if (area > 0) call add_point(interfaces, m, cut, k, bonded, side, middle, middle, area)
                           if (area > 0 .and. cut%moves) &
                              call place_part(interfaces%list(interfaces%n), m, k, part(1), opening, is_known)
                           if (cut%contact .and. m%grid%aggregated_nodes%are_there()) &
                              call add_point(interfaces, m, cut, k, contact, side, from + part/2, from + part/2, product(part))
                        end associate
                     end do
                  end do
               end do
            end do
            if (cut%contact .and. .not. m%grid%aggregated_nodes%are_there()) call add_contact(interfaces, m, cut, k)
         end associate
      end do
   end subroutine add_points_of_planes

   !> Add the points of faces that may touch.
   pure subroutine add_contact(interfaces, m, cut, number)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(plane_cut_t), intent(in) :: cut
      integer, intent(in) :: number              !! of the crack
      real(dp), allocatable :: area(:), beside(:, :) ! of nodes [m2]; the middle of a part of a face at them [m]
      integer, allocatable :: side_of(:)
      real(dp) :: low(2), high(2), part(2), weight(m%grid%n_functions, most_nodes_of_leaf)
      integer :: leaf, side, i, j, c, n, e(faces), master(most_nodes_of_leaf)
      allocate (area(m%grid%n_nodes), source=0.0_dp)
      allocate (beside(2, m%grid%n_nodes), side_of(m%grid%n_nodes))
      side_of = 0
      associate (forest => m%grid%forest)
         do leaf = 1, forest%leaf_count()
            do side = 1, faces
               if (.not. is_of(m, cut, leaf, side)) cycle
               call cut%rectangle_of(forest, leaf, low, high)
               part = (high - low)/parts
               do j = 1, parts
                  do i = 1, parts
                     associate (middle => low + ([i, j] - 0.5_dp)*part)
                        e = elements_beside(m, cut, side, cut%in_space(middle))
                        if (any(e == 0)) cycle
                        call m%grid%dofs%masters_of(m%grid%support_of(e(side)), n, master, weight)
                        do c = 0, 3
                           associate (x => cut%in_space(middle + ([mod(c, 2), c/2] - 0.5_dp)*part))
                              area(master(:n)) = area(master(:n)) + product(part)/4*matmul( &
                                                 m%grid%functions_in(e(side), m%grid%local_coordinate(e(side), x)), weight(:, :n))
                           end associate
                        end do
                        do c = 1, n
                           if (any(abs(cut%in_plane(m%grid%node_position(:, master(c))) - middle) > 0.6_dp*part)) cycle
                           beside(:, master(c)) = middle
                           side_of(master(c)) = side
                        end do
                     end associate
                  end do
               end do
            end do
         end do
         do n = 1, size(area)
            if (area(n) > none*maxval(area) .and. side_of(n) > 0) then
               if (cut%opens_at(forest, m%grid%node_position(:, n))) &
                  call add_point(interfaces, m, cut, number, contact, side_of(n), cut%in_plane(m%grid%node_position(:, n)), &
                                 beside(:, n), area(n))
            end if
         end do
      end associate
   end subroutine add_contact

   !> Let a point follow the front of a crack over its square, from the opening of its nodes.
   pure subroutine place_part(point, m, plane, edge, opening, is_known)
      type(interface_point_t), intent(inout) :: point
      type(matter_t), intent(in) :: m
      integer, intent(in) :: plane               !! number of the crack
      real(dp), intent(in) :: edge               !! of the square [m]
      real(dp), intent(in) :: opening(:, :, :)   !! of nodes, by the node of the first face [m]
      logical, intent(in) :: is_known(:)
      integer :: n, k
      if (point%plane > 0) return                ! there is no material, and no point
      point%plane = plane
      point%length = edge
      point%before = point%opening
      point%felt = point%opening
      n = merge(point%n_left, count(point%node > 0), point%n_left > 0)
      associate (cut => m%grid%planes(plane))
         if (.not. all([(is_known(point%node(k)) .or. &
                         .not. cut%opens_at(m%grid%forest, m%grid%node_position(:, point%node(k))), k=1, n)])) return
      end associate
      associate (share => abs(point%share(:n)), node => point%node(:n))
         point%opening = matmul(opening(:, 1, node), share)
         point%before = matmul(opening(:, 2, node), share)
         point%felt = matmul(opening(:, 3, node), share)
      end associate
   end subroutine place_part

   !> Add the points of open nodes around which something is bonded.
   pure subroutine add_points_of_nodes(interfaces, m, number, old, opening, is_known)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      integer, intent(in) :: number              !! of the crack
      type(interfaces_t), intent(in) :: old
      real(dp), allocatable, intent(out) :: opening(:, :, :) !! [m], (ndim, 3, n_points)
      logical, allocatable, intent(out) :: is_known(:)
      real(dp), parameter :: same = 1e-6_dp      ! cells
      real(dp) :: low(2), high(2), edge, area, middle(2), x(2)
      integer :: leaf, side, i, j, k, n
      allocate (opening(ndim, 3, m%grid%n_points), source=0.0_dp)
      allocate (is_known(m%grid%n_points), source=.false.)
      associate (cut => m%grid%planes(number), forest => m%grid%forest)
         do leaf = 1, forest%leaf_count()
            do side = 1, faces
               if (.not. is_of(m, cut, leaf, side)) cycle
               call cut%rectangle_of(forest, leaf, low, high)
               edge = high(1) - low(1)
               do j = 0, 1
                  do i = 0, 1
                     x = low + [i, j]*edge
                     if (.not. cut%opens_at(forest, cut%in_space(x))) cycle
                     call cut%unbonded(forest%level_of(leaf))%uncracked(x - edge, x + edge, area, middle)
                     if (.not. area > 0) cycle
                     n = interfaces%n
                     call add_point(interfaces, m, cut, number, bonded, side, x, (low + high)/2, area)
                     if (interfaces%n == n) cycle
                     associate (point => interfaces%list(interfaces%n))
                        if (count(point%node > 0) /= merge(1, faces, cut%is_symmetry)) then
                           interfaces%n = n      ! a hanging node
                        else if (is_known(point%node(1))) then
                           interfaces%n = n
                        else
                           is_known(point%node(1)) = .true.
                           point%plane = number
                           point%length = 2*edge
                           point%stiffness = 0
                           point%is_new = old%n > 0
                           if (old%n > 0) point%opening = 0
                           point%before = point%opening
                           point%felt = point%opening
                           do k = 1, old%n
                              if (old%list(k)%plane /= number .or. old%list(k)%stiffness > 0) cycle
                              if (norm(old%list(k)%origin - point%origin) > same*edge) cycle
                              point%is_new = .false.
                              point%opening = old%list(k)%opening
                              point%before = old%list(k)%before
                              point%felt = old%list(k)%felt
                              point%held = old%list(k)%held
                              point%area = old%list(k)%area
                           end do
                           opening(:, :, point%node(1)) = reshape([point%opening, point%before, point%felt], [ndim, 3])
                        end if
                     end associate
                  end do
               end do
            end do
         end do
      end associate
   end subroutine add_points_of_nodes

   !> Let the points follow fronts that have moved, before a step. `dropped` is the decrease of their stored energy, `released` the
   !> work of the released forces: in an explicit step, with mid-step velocities, by the mean of this opening and the last one; else
   !> by the opening at its start, to which `late_release` is added at its end.
   pure subroutine follow_fronts(interfaces, m, is_explicit, dropped, released)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      logical, intent(in) :: is_explicit
      real(dp), intent(out) :: dropped, released !! [J]
      real(dp) :: area, middle(2), x(2)
      integer :: k, level
      dropped = interface_energy(interfaces)
      released = 0
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%plane == 0) cycle
            if (.not. is_explicit) point%before = point%opening
            if (.not. point%area > 0) then
               point%lost = 0
               cycle
            end if
            associate (cut => m%grid%planes(point%plane))
               x = cut%in_plane(point%origin)
               level = nint(log(m%grid%forest%cell/(point%length*merge(2.0_dp, 0.5_dp, point%stiffness > 0)))/log(2.0_dp))
               call cut%unbonded(level)%uncracked(x - point%length/2, x + point%length/2, area, middle)
            end associate
            point%lost = 1 - min(area/point%area, 1.0_dp)
            if (is_explicit) released = released + mean_energy(point, point%before, point%opening)
            point%stiffness = point%stiffness*(1 - point%lost)
            point%held = point%held*(1 - point%lost)
            point%area = min(area, point%area)
         end associate
      end do
      dropped = dropped - interface_energy(interfaces)
      if (.not. is_explicit) released = dropped
   end subroutine follow_fronts

   !> Energy taken by the points of fronts in an implicit step beyond the value at its start [J].
   pure real(dp) function late_release(interfaces) result(energy)
      type(interfaces_t), intent(in) :: interfaces
      integer :: k
      energy = 0
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            if (point%plane == 0 .or. .not. point%lost > 0 .or. .not. point%lost < 1) cycle
            energy = energy + (mean_energy(point, point%before, point%opening) &
                               - mean_energy(point, point%before, point%before))/(1 - point%lost)
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
      across = dot_product(point%held, before + after)
      energy = point%lost*(point%stiffness*energy + across)/2
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

   !> Add a point.
   pure subroutine add_point(interfaces, m, cut, number, law, side, middle, beside, area)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(plane_cut_t), intent(in) :: cut
      integer, intent(in) :: number              !! of the crack
      integer, intent(in) :: law                 !! `bonded` or `contact`
      integer, intent(in) :: side                !! see `elements_beside`
      real(dp), intent(in) :: middle(2)          !! in the plane [m]
      real(dp), intent(in) :: beside(2)          !! a place inside of a face that it is on [m]
      real(dp), intent(in) :: area               !! [m2]
      real(dp) :: weight(m%grid%n_functions, most_nodes_of_leaf), share(most_nodes_of_leaf)
      integer :: e(faces), master(most_nodes_of_leaf), n, j, i, k
      e = elements_beside(m, cut, side, cut%in_space(beside))
      if (all(e == 0)) return
      call add_interface_point(interfaces, law)
      associate (point => interfaces%list(interfaces%n), x => cut%in_space(middle))
         point%normal = identity(:, cut%axis)
         point%place = x
         point%middle = x
         point%origin = x
         point%opening = jump_between(m, e, x)
         point%length = sqrt(area)
         point%area = area
         if (law == contact) then
            point%line = number
            point%friction = cut%friction
            point%slip = along_faces(point, point%opening)
         end if
         point%is_firm = law == contact .and. .not. cut%friction > 0
         call find_half_stiffness(m, e, x, merge(of_contact, merge(of_rubbing, of_bonded, law == contact), point%is_firm), &
                                  point%cell, point%stiffness)
         point%stiffness = area*point%stiffness
         n = 0
         do k = 1, faces
            if (e(k) > 0) then
               call m%grid%dofs%masters_of(m%grid%support_of(e(k)), j, master, weight)
               share(:j) = (3 - 2*k)*matmul(m%grid%functions_in(e(k), m%grid%local_coordinate(e(k), x)), weight(:, :j))
               do i = 1, j
                  if (abs(share(i)) < none) cycle
                  n = n + 1
                  point%node(n) = master(i)
                  point%share(n) = share(i)
               end do
            end if
            if (k == 1) point%n_left = n
         end do
         point%pressed = max(0.0_dp, -dot_product(point%normal, point%opening))
      end associate
   end subroutine add_point
end module hampm_plane_points
