!> Pressure on the faces of cracks that cut cells in any direction (`hampm_cut_cells`).
!>
!> The particles on both sides of the crack fill rectangles whose common edges are stairs along it, on which the pressure acts.
!> Nodal forces then are exactly those of the particles under a uniform stress of the same size: faces under a pressure p and a body
!> under a remote tension p have the same K up to rounding, for any place and direction of the crack; with pressure along the line
!> they would differ by the place error of the cells. At a mouth the stairs continue along the edge of the body to the crack, where
!> loads on that edge begin (`hampm_edge_loads`): the part of a particle beyond the crack is pressed too, and its other side the
!> opposite way. So the resultant of each face is that of its line. A particle cut through its middle is two halves of its
!> rectangle.
!>
!> A cell with a crack end is cut, and pressed, as a whole: the bonded points ahead of the tip are pressed equally from both sides.
!> The edges, between particles in the reference configuration, move with these (`hampm_turned_faces`).
module hampm_pressed_faces
   use hampm_kinds, only: dp, ndim, plane
   use hampm_polygon, only: distance_to_segment
   use hampm_cut_cells, only: cut_cells_t, divides
   use hampm_dofs, only: list_slots
   use hampm_edge_loads, only: carriers_of, pieces_are_weak
   use hampm_loads, only: load_t, note_particles
   use hampm_matter, only: matter_t
   use hampm_plane_cuts, only: plane_cut_t, has_face_in
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t, spacing_of
   use hampm_children, only: is_half, middle_of_parent
   use hampm_tensors, only: quarter_turn
   implicit none
   private
   public :: press_faces

   real(dp), parameter :: touching = 1e-3_dp     !! gap of touching rectangles, as part of a particle

   !> An edge of a particle that is on a crack face.
   type :: edge_t
      integer :: particle = 0                    !! the pressed particle
      real(dp) :: into(ndim) = 0                 !! unit vector into it
      real(dp) :: offset(ndim) = 0               !! of the middle of the edge from it [m]
      real(dp) :: half(ndim) = 0                 !! half of the edge [m]
      real(dp) :: length = 0                     !! of the edge across that vector [m], of solids the area of the face [m2]
   end type edge_t

   !> Some edges.
   type :: edges_t
      integer :: n = 0
      type(edge_t), allocatable :: list(:)       !! (n and more)
   end type edges_t

contains

   !> Place the pressures on faces, on the present cut cells and particles.
   subroutine press_faces(m)
      type(problem_t), intent(inout) :: m
      type(edges_t) :: edges
      integer :: k, found
      found = 0
      do k = 1, size(m%loads)
         if (m%loads(k)%line == 0) cycle
         if (m%loads(k)%line /= found .and. ndim == plane) &
            call find_edges(m%matter_t, m%loads(k)%line, edges)
         if (m%loads(k)%line /= found .and. ndim > plane) call find_faces(m%matter_t, m%grid%planes(m%loads(k)%line), edges)
         found = m%loads(k)%line
         call take_edges(m, edges, m%loads(k))
      end do
   end subroutine press_faces

   !> Find, in solids, the faces of particles in the plane of a crack: those next to the plane in all cells with an open node, for
   !> any rows of particles in the cells. Both sides ahead of the front are pressed equally.
   pure subroutine find_faces(m, cut, edges)
      type(matter_t), intent(in) :: m
      type(plane_cut_t), intent(in) :: cut
      type(edges_t), intent(out) :: edges
      logical :: is_pressed(2, m%grid%forest%leaf_count())
      real(dp) :: nearest(2, m%grid%forest%leaf_count()) ! particle in each leaf, from either side of the plane [m]
      real(dp) :: spacing(ndim), side, middle(ndim)
      integer :: leaf, i, k
      do leaf = 1, size(is_pressed, 2)
         is_pressed(:, leaf) = [(has_face_in(cut, m%grid%forest, leaf, k), k=1, 2)]
         if (any(is_pressed(:, leaf))) is_pressed(:, leaf) = is_pressed(:, leaf) .and. cut%opens_face(m%grid%forest, leaf)
      end do
      nearest = huge(nearest)
      do i = 1, m%particles%n
         side = cut%plane - m%particles%reference(i, cut%axis)
         associate (least => nearest(merge(1, 2, side < 0), m%grid%element_leaf(m%particles%cell(i))))
            least = min(least, abs(side))
         end associate
      end do
      allocate (edges%list(64))
      do i = 1, m%particles%n
         side = cut%plane - m%particles%reference(i, cut%axis)
         k = merge(1, 2, side < 0)
         leaf = m%grid%element_leaf(m%particles%cell(i))
         if (.not. is_pressed(k, leaf)) cycle
         spacing = spacing_of(m%particles, i)
         if (abs(side) > min((1 + touching)*spacing(cut%axis), nearest(k, leaf) + spacing(cut%axis)/2)) cycle
         middle = m%particles%reference(i, :)
         middle(cut%axis) = cut%plane
         call add_edge(m%particles, i, cut%axis, -sign(1.0_dp, side), middle, 0*middle, product(spacing(cut%along)), edges)
      end do
   end subroutine find_faces

   !> Apply a load to the edges on which it pushes in its direction.
   subroutine take_edges(m, edges, load)
      type(problem_t), intent(inout) :: m
      type(edges_t), intent(in) :: edges
      type(load_t), intent(inout) :: load
      real(dp), allocatable :: of_edge(:)        ! areas [m2]
      real(dp) :: area                           ! of all of them together [m2]
      type(edge_t), allocatable :: chosen(:)
      integer :: i, n
      chosen = pack(edges%list(:edges%n), [(dot_product(edges%list(i)%into, load%into) > 0.5_dp, i=1, edges%n)])
      n = size(chosen)
      of_edge = [(chosen(i)%length*m%interfaces%thickness%at(m%particles%reference(chosen(i)%particle, :) + chosen(i)%offset), &
                  i=1, n)]
      area = sum(of_edge)
      load%force = load%pressure*area*load%into
      if (allocated(load%particle)) then         ! as in a checkpoint, or on an unchanged mesh
         if (size(load%particle) == n) then
            if (all(load%particle == chosen%particle) .and. &
                .not. any([(abs(load%offset(:, i) - chosen(i)%offset) > 0, i=1, n)])) return
         end if
      end if
      load%particle = chosen%particle
      load%offset = reshape([(chosen(i)%offset, i=1, n)], [ndim, n])
      load%half = reshape([(chosen(i)%half, i=1, n)], [ndim, n])
      load%fraction = of_edge/merge(area, 1.0_dp, area > 0)
      call note_particles(load, m%particles)
      m%cache%mapped = .false.                   ! operators of cells depend on the particles
   end subroutine take_edges

   !> Find the edges between particles on different sides of a line, in the order of the particles, with their edges at mouths.
   subroutine find_edges(m, line, edges)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: line
      type(edges_t), intent(out) :: edges
      real(dp), allocatable :: points(:, :)
      integer, allocatable :: near(:), first(:), bin(:), order(:)
      logical, allocatable :: is_weak(:)
      real(dp) :: lower(ndim), upper(ndim), width
      logical :: is_inner(2, ndim)
      integer :: axis, a, b, n_bins, status
      points = m%grid%cut_cells%cut_part(line)
      call list_near(m%particles, points, near, width)
      allocate (edges%list(64))
      if (size(near) == 0) return
      is_weak = pieces_are_weak(m)
      lower = minval(m%particles%reference(near, :), dim=1)
      upper = maxval(m%particles%reference(near, :), dim=1)
      axis = maxloc(upper - lower, dim=1)
      n_bins = min(int((upper(axis) - lower(axis))/width) + 1, size(near))
      width = max(width, (upper(axis) - lower(axis))/n_bins)
      allocate (bin(size(near)))
      bin = min(int((m%particles%reference(near, axis) - lower(axis))/width) + 1, n_bins)
      call list_slots(n_bins, reshape(bin, [1, size(bin)]), first, order, status)
      do a = 1, size(near)
         is_inner = .false.
         do b = first(max(bin(a) - 1, 1)), first(min(bin(a) + 1, n_bins) + 1) - 1
            if (order(b) /= a) call press_pair(m%particles, m%grid%cut_cells, points, near(a), near(order(b)), is_inner, edges)
         end do
         call press_mouth(m, points, near(a), is_inner, is_weak, edges)
      end do
   end subroutine find_edges

   !> Add the outer sides of a particle beyond a line, beside its mouth, to the edges of the particle, and the opposite way to those
   !> of the particles that carry loads on that part of the edge of the body.
   subroutine press_mouth(m, points, i, is_inner, is_weak, edges)
      type(matter_t), intent(in) :: m
      real(dp), intent(in) :: points(:, :)       !! of the line [m]
      integer, intent(in) :: i
      logical, intent(in) :: is_inner(2, ndim)   !! whether there is another particle beside its lower and upper sides
      logical, allocatable, intent(in) :: is_weak(:) !! as in `nearest_particles`
      type(edges_t), intent(inout) :: edges
      real(dp), parameter :: least = 1e-12_dp    ! of a particle
      real(dp), dimension(ndim) :: middle, size_i, half, x, normal, moved
      integer, allocatable :: carriers(:)
      real(dp) :: ends(2), inner, outer, at
      integer :: d, o, k, c
      call find_rectangle(m%particles, i, middle, size_i)
      do d = 1, ndim
         o = 3 - d
         do k = 1, 2
            if (is_inner(k, d)) cycle
            normal = 0
            normal(d) = 2*k - 3
            x = middle + normal*size_i/2
            ends = [-1, 1]*size_i(o)/2
            if (is_half(m%particles, i)) call clip(m%particles%half(i, :), d, x(d) - middle(d), 0.0_dp, ends(1), ends(2))
            if (ends(2) - ends(1) <= least*size_i(o)) cycle
            if (is_beyond(ends(1)) .eqv. is_beyond(ends(2))) cycle
            if (is_beyond(ends(1))) ends = ends([2, 1])
            inner = ends(1)
            outer = ends(2)
            do while (abs(outer - inner) > least*size_i(o))
               at = (inner + outer)/2
               if (is_beyond(at)) then
                  outer = at
               else
                  inner = at
               end if
            end do
            x(o) = middle(o) + (outer + ends(2))/2
            half = 0
            half(o) = abs(ends(2) - outer)/2
            call add_edge(m%particles, i, d, -normal(d), x, half, 2*half(o), edges)
            moved = m%particles%place_in_grid(i) + x - m%particles%reference(i, :)
            if (.not. m%particles%total_frame) moved = moved + matmul(m%particles%gradient_of(i), x - m%particles%reference(i, :))
            allocate (carriers, source=carriers_of(m, moved, normal, is_weak))
            do c = 1, size(carriers)
               call add_edge(m%particles, carriers(c), d, normal(d), x, half, 2*half(o)/size(carriers), edges)
            end do
            deallocate (carriers)
         end do
      end do

   contains

      !> Whether the line runs between the particle and a place along its side.
      pure logical function is_beyond(along)
         real(dp), intent(in) :: along           !! from the middle of the rectangle [m]
         real(dp) :: place(ndim)
         place = x
         place(o) = middle(o) + along
         is_beyond = divides(points, m%particles%reference(i, :), place, m%grid%cut_cells%slack)
      end function is_beyond
   end subroutine press_mouth

   !> List the particles near a polyline, and the largest edge of any of them [m].
   pure subroutine list_near(p, points, near, width)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: points(:, :)       !! [m]
      integer, allocatable, intent(out) :: near(:)
      real(dp), intent(out) :: width
      logical, allocatable :: is_near(:)
      real(dp) :: edges(ndim), edge, x(ndim)
      integer :: i, k
      allocate (is_near(p%n))
      width = 0
      do i = 1, p%n
         is_near(i) = .false.
         call find_rectangle(p, i, x, edges)
         edge = maxval(edges)
         do k = 2, size(points, 2)
            is_near(i) = distance_to_segment(x, points(:, k - 1), points(:, k)) < 3*edge
            if (is_near(i)) exit
         end do
         if (is_near(i)) width = max(width, edge)
      end do
      width = 1.5_dp*width                       ! centroids of halves are aside of the middle of their rectangles
      near = pack([(i, i=1, p%n)], is_near)
   end subroutine list_near

   !> The rectangle of a particle, or the one of which it is half.
   pure subroutine find_rectangle(p, i, middle, edges)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp), intent(out) :: middle(ndim), edges(ndim) !! [m]
      middle = p%reference(i, :)
      edges = spacing_of(p, i)
      if (.not. is_half(p, i)) return
      middle = middle_of_parent(p, i)
      edges = 2*edges
   end subroutine find_rectangle

   !> Add the common edge of two particles, if a line runs between them.
   pure subroutine press_pair(p, cut, points, i, j, is_inner, edges)
      type(particles_t), intent(in) :: p
      type(cut_cells_t), intent(in) :: cut
      real(dp), intent(in) :: points(:, :)       !! of the line [m]
      integer, intent(in) :: i, j                !! the pressed particle, the other
      logical, intent(inout) :: is_inner(2, ndim) !! whether there is another particle beside the lower and upper sides of that
      type(edges_t), intent(inout) :: edges
      real(dp), dimension(ndim) :: size_i, size_j, x_i, x_j, apart, middle, half
      real(dp) :: from, to, side
      integer :: d, o
      call find_rectangle(p, i, x_i, size_i)
      call find_rectangle(p, j, x_j, size_j)
      apart = x_j - x_i
      if (any(abs(apart) > (1 + touching)*(size_i + size_j)/2)) return
      if (all(abs(apart) <= touching*size_i)) then
         call add_chord(p, i, x_i, size_i, edges)
         return
      end if
      do d = 1, ndim
         if (abs(abs(apart(d)) - (size_i(d) + size_j(d))/2) > touching*min(size_i(d), size_j(d))) cycle
         o = 3 - d
         from = max(-size_i(o)/2, apart(o) - size_j(o)/2)
         to = min(size_i(o)/2, apart(o) + size_j(o)/2)
         side = sign(size_i(d)/2, apart(d))
         if (is_half(p, i)) call clip(p%half(i, :), d, side, 0.0_dp, from, to)
         if (is_half(p, j)) call clip(p%half(j, :), d, side - apart(d), apart(o), from, to)
         if (to - from <= touching*min(size_i(o), size_j(o))) cycle
         is_inner(merge(1, 2, apart(d) < 0), d) = .true.
         ! Beside the end of a line rounding may select one side only: faces are pressed in pairs
         if (.not. divides(points, p%reference(i, :), p%reference(j, :), cut%slack)) return
         if (.not. divides(points, p%reference(j, :), p%reference(i, :), cut%slack)) return
         middle(d) = side
         middle(o) = (from + to)/2
         half = 0
         half(o) = (to - from)/2
         call add_edge(p, i, d, -sign(1.0_dp, apart(d)), x_i + middle, half, to - from, edges)
      end do
   end subroutine press_pair

   !> Clip a part of a side of a rectangle to one half of the rectangle.
   pure subroutine clip(normal, d, side, middle, from, to)
      real(dp), intent(in) :: normal(ndim)       !! into the half
      integer, intent(in) :: d                   !! direction across the side
      real(dp), intent(in) :: side               !! its distance from the middle of the rectangle [m]
      real(dp), intent(in) :: middle             !! of the rectangle along the side, as the ends below [m]
      real(dp), intent(inout) :: from, to        !! ends of the part [m]
      real(dp), parameter :: along = 1e-12_dp    ! of a normal across which a side lies wholly on one side
      real(dp) :: at
      if (abs(normal(3 - d)) <= along) then
         if (normal(d)*side < 0) to = from
         return
      end if
      at = middle - normal(d)*side/normal(3 - d)
      if (normal(3 - d) > 0) then
         from = max(from, at)
      else
         to = min(to, at)
      end if
   end subroutine clip

   !> Add the edge between two halves of a rectangle, the crack through its middle: its components across each axis, at two Gauss
   !> points, as shape functions of bilinear cells are of second order along it.
   pure subroutine add_chord(p, i, middle, size, edges)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i                   !! a half
      real(dp), intent(in) :: middle(ndim), size(ndim) !! of the rectangle, and its edges [m]
      type(edges_t), intent(inout) :: edges
      real(dp), parameter :: along = 1e-12_dp    ! of a normal without a component
      real(dp), parameter :: gauss = 1/sqrt(3.0_dp)
      real(dp) :: normal(ndim), half(ndim)
      integer :: d, k
      normal = p%half(i, :)
      half = quarter_turn(normal)
      half = half*minval(size/2/max(abs(half), along))
      do d = 1, ndim
         if (abs(normal(d)) <= along) cycle
         do k = -1, 1, 2
            call add_edge(p, i, d, sign(1.0_dp, normal(d)), middle + k*gauss*half, half/2, abs(half(3 - d)), edges)
         end do
      end do
   end subroutine add_chord

   !> Add an edge.
   pure subroutine add_edge(p, i, d, into, middle, half, length, edges)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i, d                !! the pressed particle, and the direction
      real(dp), intent(in) :: into               !! sign of that
      real(dp), intent(in) :: middle(ndim), half(ndim) !! of the edge [m]
      real(dp), intent(in) :: length             !! across the direction [m]
      type(edges_t), intent(inout) :: edges
      type(edge_t) :: edge
      edge%particle = i
      edge%into(d) = into
      edge%offset = middle - p%reference(i, :)
      edge%half = half
      edge%length = length
      if (edges%n == size(edges%list)) edges%list = [edges%list, edges%list]
      edges%n = edges%n + 1
      edges%list(edges%n) = edge
   end subroutine add_edge
end module hampm_pressed_faces
