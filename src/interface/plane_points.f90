!> Interface points on the faces of cells along cracks in planes of the grid (`hampm_plane_cuts`), by area; of solids only.
!>
!> Each part of a face has a point in the middle of what is bonded of it, and where the faces of the crack may touch one in the middle
!> of all of it.
module hampm_plane_points
   use hampm_kinds, only: dp, ndim, long
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_face_jumps, only: faces, find_half_stiffness, jump_between
   use hampm_forest, only: level_width
   use hampm_interface_points, only: interfaces_t, bonded, contact, add_interface_point
   use hampm_matter, only: matter_t
   use hampm_plane_cuts, only: plane_cut_t, has_face_in
   use hampm_tensors, only: identity
   implicit none
   private
   public :: add_points_of_planes, elements_beside, parts

   integer, parameter :: parts = 2               !! of a face along each edge

   !> Stiffness of bonded faces for each area, in E'/h. Of 0.3 to 100 this leaves the least difference between places of the front in
   !> a cell (docs/explanation/solids.md).
   real(dp), parameter :: of_bonded = 1

   !> The same of faces that touch.
   real(dp), parameter :: of_contact = 3e4_dp

contains

   !> Add the points of all cracks.
   pure subroutine add_points_of_planes(interfaces, m)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      real(dp) :: low(2), high(2), part(2), area, middle(2)
      integer :: k, leaf, side, i, j
      do k = 1, size(m%grid%planes)
         associate (cut => m%grid%planes(k), forest => m%grid%forest)
            do leaf = 1, forest%leaf_count()
               do side = 1, faces
                  if (.not. is_of(m, cut, leaf, side)) cycle
                  call cut%rectangle_of(forest, leaf, low, high)
                  part = (high - low)/parts
                  do j = 1, parts
                     do i = 1, parts
                        associate (from => low + [i - 1, j - 1]*part)
                           call cut%unbonded(forest%level_of(leaf))%uncracked(from, from + part, area, middle)
                           if (area > 0) call add_point(interfaces, m, cut, k, bonded, side, middle, area)
                           if (cut%contact) call add_point(interfaces, m, cut, k, contact, side, from + part/2, product(part))
                        end associate
                     end do
                  end do
               end do
            end do
         end associate
      end do
   end subroutine add_points_of_planes

   !> Whether a crack has points on a face of a leaf in its plane: it has an open node, and of two faces at one place it is the finer one, or the upper.
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

   !> The elements with material above and below a place in the plane of a crack; 0 where there is none, and on a plane of symmetry on the other side.
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
   pure subroutine add_point(interfaces, m, cut, number, law, side, middle, area)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(plane_cut_t), intent(in) :: cut
      integer, intent(in) :: number              !! of the crack
      integer, intent(in) :: law                 !! `bonded` or `contact`
      integer, intent(in) :: side                !! see `elements_beside`
      real(dp), intent(in) :: middle(2)          !! in the plane [m]
      real(dp), intent(in) :: area               !! [m2]
      real(dp), parameter :: none = 1e-14_dp     ! share of a node
      real(dp) :: weight(m%grid%n_functions, most_nodes_of_leaf), share(most_nodes_of_leaf)
      integer :: e(faces), master(most_nodes_of_leaf), n, j, i, k
      e = elements_beside(m, cut, side, cut%in_space(middle))
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
         if (law == contact) point%line = number
         call find_half_stiffness(m, e, x, merge(of_contact, of_bonded, law == contact), point%cell, point%stiffness)
         point%stiffness = area*point%stiffness
         point%is_firm = law == contact
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
