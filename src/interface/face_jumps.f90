!> The jump of the displacement across a crack that cuts cells, by the particles on both of its sides.
!>
!> A small piece of a cell may have no particle. Particles of the cells next to it on its side represent it then.
module hampm_face_jumps
   use hampm_kinds, only: dp, ndim
   use hampm_crack_lines, only: both_faces
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_interface_point, only: interface_point_t
   use hampm_matter, only: matter_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: norm, quarter_turn, identity, inverse_transpose
   implicit none
   private
   public :: faces, place_of_faces_t, faces_at, nearest_carrier, place_between, jump_between, turn_between, place_point

   integer, parameter :: faces = 2               !! the left one first

   !> A place on a line, and the particles that tell how its faces move there.
   type :: place_of_faces_t
      real(dp) :: x(ndim)                        !! in the grid [m]
      real(dp) :: normal(ndim)                   !! unit vector to the left of the line
      integer, allocatable :: left(:), right(:)
   contains
      procedure :: jump
   end type place_of_faces_t

contains

   !> The elements on both sides of a line; 0 where there is no line or no material on one of the sides. On a symmetry plane
   !> that on the only side that there is, and 0 for its mirror image.
   pure function faces_at(m, x, normal, only, by_edges) result(elements)
      type(matter_t), intent(in) :: m
      real(dp), intent(in) :: x(ndim)            !! on the line [m]
      real(dp), intent(in) :: normal(ndim)       !! unit vector to its left
      integer, intent(in) :: only                !! which face there is, or `both_faces`
      logical, intent(in), optional :: by_edges  !! whether cells with an edge in common have to tell how they move
      integer :: elements(faces)
      real(dp), parameter :: beside = 1e-4_dp    ! root cells
      integer :: face
      elements = [(m%grid%element_of_face(x + (3 - 2*face)*beside*m%grid%forest%cell*normal), face=1, faces)]
      if (only /= both_faces) then
         elements(3 - only) = 0
         if (elements(only) == 0) return
         if (size(carriers_of(m, elements(only), by_edges)) == 0) elements = 0
      else if (any(elements == 0) .or. elements(1) == elements(2)) then
         elements = 0
      else if (any([(size(carriers_of(m, elements(face), by_edges)), face=1, faces)] == 0)) then
         elements = 0
      end if
   end function faces_at

   !> The elements whose particles give the motion of an element: itself or, if empty, the other quarters of its piece (of quadratic
   !> cells and beside finer ones), or else elements of other leaves that share an edge with it or, if none does, a corner.
   pure function carriers_of(m, e, by_edges) result(carriers)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: e
      logical, intent(in), optional :: by_edges
      integer, allocatable :: carriers(:)
      integer :: corner, k, c, least             ! nodes in common
      carriers = [e]
      if (m%blocks%count_in(e) > 0) return
      carriers = [(k, k=m%grid%first_of_piece(e), m%grid%last_of_piece(e))]
      carriers = pack(carriers, m%blocks%count_in(carriers) > 0)
      if (size(carriers) > 0) return
      associate (nodes => m%grid%support_of(e))
         do least = 2, 1, -1
            do corner = 1, size(nodes)
               associate (others => m%grid%dofs%elements_at(nodes(corner)))
                  do k = 1, size(others)
                     if (m%blocks%count_in(others(k)) == 0 .or. any(carriers == others(k))) cycle
                     if (m%grid%element_leaf(others(k)) == m%grid%element_leaf(e)) cycle
                     if (count([(any(m%grid%element_nodes(:, others(k)) == nodes(c)), c=1, size(nodes))]) >= least) &
                        carriers = [carriers, others(k)]
                  end do
               end associate
            end do
            if (size(carriers) > 0) return
            if (.not. present(by_edges)) cycle
            if (by_edges) return
         end do
      end associate
   end function carriers_of

   !> The element whose nodes move a place in an element: itself or, if empty, the nearest of its carriers. Its shape functions,
   !> extrapolated, are still exact for linear fields.
   pure integer function nearest_carrier(m, e, x) result(nearest)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: e
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer :: k
      associate (carriers => carriers_of(m, e))
         nearest = carriers(minloc([(norm(m%grid%local_coordinate(carriers(k), x) - 0.5_dp), k=1, size(carriers))], dim=1))
      end associate
   end function nearest_carrier

   !> A place on a line between two elements.
   pure type(place_of_faces_t) function place_between(m, elements, x, normal) result(place)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: elements(faces)     !! see `faces_at`
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: normal(ndim)       !! unit vector to its left
      place%x = x
      place%normal = normal
      allocate (place%left, source=particles_of(m, elements(1)))
      allocate (place%right, source=particles_of(m, elements(2)))
   end function place_between

   !> Displacement of the left face less the right one [m]; on a symmetry plane of the only face, half of the opening.
   pure function jump(self, p)
      class(place_of_faces_t), intent(in) :: self
      type(particles_t), intent(in) :: p
      real(dp) :: jump(ndim)
      real(dp) :: origin(ndim)
      origin = self%x
      if (.not. p%total_frame) origin = origin_of(p, [self%left, self%right], self%x)
      jump = displacement_at(p, self%left, origin) - displacement_at(p, self%right, origin)
   end function jump

   !> The same between two elements.
   pure function jump_between(m, elements, x) result(jump)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: elements(faces)     !! see `faces_at`
      real(dp), intent(in) :: x(ndim)            !! in the grid [m]
      real(dp) :: jump(ndim)
      type(place_of_faces_t) :: place
      place = place_between(m, elements, x, 0*x)
      jump = place%jump(m%particles)
   end function jump_between

   !> Mean size of the cells at a place between faces, and stiffness of a layer there per area: of its halves in series, each of the
   !> material and the cell of its face. On a symmetry plane there is one of them.
   pure subroutine find_half_stiffness(m, e, x, firmness, cell, stiffness)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: e(faces)            !! see `faces_at`
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: firmness           !! of the layer [E'/cell]
      real(dp), intent(out) :: cell              !! [m]
      real(dp), intent(out) :: stiffness         !! [Pa/m]
      real(dp) :: compliance
      integer :: side, first, of_place           ! a particle there, and the material
      cell = 0
      compliance = 0
      do side = 1, faces
         if (e(side) == 0) cycle
         cell = cell + m%grid%leaf_size(e(side))/count(e > 0)
         first = m%blocks%first_in(nearest_carrier(m, e(side), x))
         of_place = m%particles%material(first)
         if (m%materials(of_place)%is_graded()) of_place = of_place + m%materials(of_place)%slices_to( &
                                                           x + m%particles%reference(first, :) - m%particles%place_in_grid(first))
         associate (material => m%materials(of_place))
            compliance = compliance + m%grid%leaf_size(e(side))/(2*firmness*material%plane_modulus())
         end associate
      end do
      stiffness = merge(2, 1, m%grid%is_quadratic())/compliance
   end subroutine find_half_stiffness

   !> Complete an interface point of given place and normal between two elements: its layer, opening and nodes.
   pure subroutine place_point(point, m, e, firmness, area, least_share)
      type(interface_point_t), intent(inout) :: point
      type(matter_t), intent(in) :: m
      integer, intent(in) :: e(faces)            !! see `faces_at`
      real(dp), intent(in) :: firmness           !! of the layer [E'/cell]
      real(dp), intent(in) :: area               !! [m2]
      real(dp), intent(in), optional :: least_share !! of a node, to be one of the point
      real(dp) :: weight(m%grid%n_functions, most_nodes_of_leaf), share(most_nodes_of_leaf)
      integer :: master(most_nodes_of_leaf), side, n, j, i
      associate (x => point%place)
         point%middle = x
         point%origin = x
         point%opening = jump_between(m, e, x)
         point%pressed = max(0.0_dp, -dot_product(point%normal, point%opening))
         point%area = area
         call find_half_stiffness(m, e, x, firmness, point%cell, point%stiffness)
         point%stiffness = area*point%stiffness
         n = 0
         do side = 1, faces
            if (e(side) == 0) cycle
            associate (element => nearest_carrier(m, e(side), x))
               call m%grid%dofs%masters_of(m%grid%support_of(element), j, master, weight)
               share(:j) = (3 - 2*side)*matmul(m%grid%functions_in(element, m%grid%local_coordinate(element, x)), weight(:, :j))
            end associate
            do i = 1, j
               if (present(least_share)) then
                  if (abs(share(i)) < least_share) cycle
               end if
               n = n + 1
               point%jump%node(n) = master(i)
               point%jump%share(n) = share(i)
            end do
            if (side == 1) point%n_left = n
         end do
      end associate
   end subroutine place_point

   !> Rotation of the faces of a line, in the mean of the particles beside them, counter-clockwise [rad].
   pure real(dp) function turn_between(m, elements, normal) result(turn)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: elements(faces)     !! see `faces_at`
      real(dp), intent(in) :: normal(ndim)       !! unit vector to its left
      real(dp) :: first(ndim), now(ndim)         ! unit vector along the line, at first and now
      integer, allocatable :: list(:)
      integer :: i
      first = quarter_turn(-normal)
      now = 0
      allocate (list, source=[particles_of(m, elements(1)), particles_of(m, elements(2))])
      do i = 1, size(list)
         now = now + first + matmul(m%particles%gradient_of(list(i)), first)
      end do
      turn = atan2(first(1)*now(2) - first(2)*now(1), dot_product(first, now))
   end function turn_between

   !> The particles that give the motion of an element; none without an element. Those of a quarter of a quadratic cell include the
   !> ones on its edges, whichever quarter has them by rounding.
   pure function particles_of(m, e) result(list)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: e                   !! 0 for none
      integer, allocatable :: list(:)
      integer, allocatable :: carriers(:)
      integer :: k
      list = [integer ::]
      if (e == 0) return
      if (m%grid%is_quadratic()) call add_particles(m, e, list)
      if (size(list) > 0) return
      carriers = carriers_of(m, e)
      do k = 1, size(carriers)
         call add_particles(m, carriers(k), list)
      end do
   end function particles_of

   !> Add the particles in an element to a list, without doubles; in a quarter of a quadratic cell also those on its edges.
   pure subroutine add_particles(m, element, list)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: element
      integer, allocatable, intent(inout) :: list(:)
      real(dp), parameter :: on_edge = 1e-6_dp   ! part of an element
      integer :: e, i, first, last
      first = element
      last = element
      if (m%grid%is_quadratic()) then
         first = m%grid%first_of_piece(element)
         last = m%grid%last_of_piece(element)
      end if
      do e = first, last
         do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
            if (m%grid%is_quadratic()) then
               if (any(abs(m%grid%local_coordinate(element, m%particles%place_in_grid(i)) - 0.5_dp) > 0.5_dp + on_edge)) cycle
               if (any(list == i)) cycle
            end if
            list = [list, i]
         end do
      end do
   end subroutine add_particles

   !> Reference position of a place, by some particles: the mean of their estimates [m].
   pure function origin_of(p, list, x) result(origin)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: list(:)             !! their numbers
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: origin(ndim)
      integer :: k
      origin = 0
      do k = 1, size(list)
         associate (i => list(k))
            origin = origin + (p%reference(i, :) + matmul(x - p%position(i), inverse_transpose(identity + p%gradient_of(i)))) &
                     /size(list)
         end associate
      end do
   end function origin_of

   !> Displacement at a place by some particles: the mean of their estimates [m].
   pure function displacement_at(p, list, x) result(u)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: list(:)             !! their numbers
      real(dp), intent(in) :: x(ndim)            !! in the reference configuration [m]
      real(dp) :: u(ndim), from(ndim)            ! place of the particle to there
      integer :: k
      u = 0
      do k = 1, size(list)
         associate (i => list(k))
            from = x - p%reference(i, :)
            u = u + p%displacement(i, :) + p%gradient(i, :, 1)*from(1) + p%gradient(i, :, 2)*from(2)
            if (ndim > 2) u = u + p%gradient(i, :, ndim)*from(ndim)
         end associate
      end do
      u = u/max(1, size(list))
   end function displacement_at
end module hampm_face_jumps
