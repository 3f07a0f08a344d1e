!> Loads on edges of bodies and faces of cracks, and at points: where their forces act on the mesh.
!>
!> A load is given once, as parts of edges with shares of its resultant. Each mesh cuts these at lines between cells, lines between
!> particles, and cracks. A part acts on the nearest particle of its piece of a cell, with the shape functions of its side of a
!> crack; if that piece has no particle, or too few to be stiff, on the nearest one of a stiffer piece on the same side of all
!> cracks, whose functions are extrapolated. So each side of a crack has the traction of its own edge, up to the mouth: with whole
!> widths of particles K of a slanted crack had an error proportional to their spacing at the mouth, at any refinement of the tip.
module hampm_edge_loads
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_absorbing_edges, only: impedance
   use hampm_edge_parts, only: edge_part_t
   use hampm_aggregated_nodes, only: least_fill
   use hampm_forest, only: outside
   use hampm_ghost_penalty, only: fills_of_pieces
   use hampm_grid, only: grid_t
   use hampm_load_sharing, only: nearest_particles
   use hampm_loads, only: load_t, note_particles
   use hampm_matter, only: matter_t
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: lay_loads, cut_parts, pieces_are_weak, carriers_of

   real(dp), parameter :: inward = 1e-6_dp       !! of the finest cell: distance beside an edge at which its material is sampled
   real(dp), parameter :: least = 1e-9_dp        !! of a cell, that a part has at least

contains

   !> Place the loads on the present mesh; `changed` if one acts on other points than before. In the updated frame they follow their
   !> particles once these have moved.
   subroutine lay_loads(loads, m, changed)
      type(load_t), intent(inout) :: loads(:)
      type(matter_t), intent(in) :: m
      logical, intent(inout) :: changed
      type(load_t), allocatable :: new
      logical, allocatable :: is_weak(:)
      integer :: l
      if (.not. m%particles%total_frame) then
         if (any(abs(m%particles%displacement(:m%particles%n, :)) > 0)) return
      end if
      if (m%grid%cut_cells%are_there()) is_weak = pieces_are_weak(m)
      do l = 1, size(loads)
         if (.not. allocated(loads(l)%edges)) cycle
         allocate (new)
         new%absorbs = loads(l)%absorbs
         if (allocated(loads(l)%follows)) new%follows = loads(l)%follows
         call lay(m, loads(l)%edges, loads(l)%per_cell, is_weak, new)
         if (allocated(loads(l)%particle)) then  ! as in a checkpoint, or on an unchanged mesh
            if (same_points(loads(l), new)) deallocate (new)
            if (.not. allocated(new)) cycle
         end if
         changed = .true.
         call move_alloc(new%fraction, loads(l)%fraction)
         call move_alloc(new%particle, loads(l)%particle)
         call move_alloc(new%offset, loads(l)%offset)
         call move_alloc(new%half, loads(l)%half)
         if (allocated(loads(l)%ends)) deallocate (loads(l)%ends)
         deallocate (new)
         call note_particles(loads(l), m%particles)
      end do
   end subroutine lay_loads

   !> Cut pieces of linear cells, by their first elements, with so few particles that a load on their edge moves them by nearly
   !> unresisted bending: the energy of a slanted edge crack with a piece of one particle at its mouth was 4 % too large.
   pure function pieces_are_weak(m) result(are)
      type(matter_t), intent(in) :: m
      logical, allocatable :: are(:)
      real(dp), allocatable :: fill(:)
      integer :: e
      allocate (are(m%grid%n_elements), source=.false.)
      if (m%grid%is_quadratic()) return          ! their cut cells have particles enough, and functions that leave the body by far
      allocate (fill(m%grid%n_elements))
      fill = fills_of_pieces(m)
      are = [(m%grid%is_piece(e) .and. fill(e) > 0 .and. fill(e) <= least_fill, e=1, m%grid%n_elements)]
   end function pieces_are_weak

   !> Whether two loads have the same points.
   pure logical function same_points(a, b) result(same)
      type(load_t), intent(in) :: a, b
      same = size(a%particle) == size(b%particle)
      if (same) same = all(a%particle == b%particle) .and. .not. any(abs(a%fraction - b%fraction) > 0) &
                       .and. .not. (any(abs(a%offset - b%offset) > 0) .or. any(abs(a%half - b%half) > 0))
   end function same_points

   !> The points of a load: middles of parts along the grid, and in quadratic cells of all parts, which stand for the whole part
   !> there; else two Gauss points. Nodal forces are then exact. A pressure that follows edges in the updated frame has the middles
   !> of halves, whose ends neighbours share (`hampm_turned_faces`). Equally near particles share a point.
   subroutine lay(m, edges, per_cell, is_weak, load)
      type(matter_t), intent(in) :: m
      type(edge_part_t), intent(in) :: edges(:)  !! `area`: share of the resultant, times the areas for dashpots
      integer, intent(in) :: per_cell            !! particles along a cell
      logical, allocatable, intent(in) :: is_weak(:) !! as in `nearest_particles`
      type(load_t), intent(inout) :: load
      real(dp) :: at(2)                          ! of two points, from -1 to 1
      type(edge_part_t), allocatable :: parts(:)
      integer, allocatable :: carriers(:)
      real(dp) :: x(ndim), share
      integer :: points, k, i, c, n
      at = [-1, 1]*merge(0.5_dp, 1/sqrt(3.0_dp), allocated(load%follows) .and. .not. m%particles%total_frame)
      call cut_parts(m%grid, m%particles%thickness, edges, per_cell, parts)
      allocate (load%fraction(4*size(parts)), load%particle(4*size(parts)), load%offset(ndim, 4*size(parts)), &
                load%half(ndim, 4*size(parts)))
      n = 0
      do k = 1, size(parts)
         points = merge(2, 1, count(abs(parts(k)%half) > least*m%grid%finest_cell) == ndim .and. .not. m%grid%is_quadratic())
         do i = 1, points
            x = parts(k)%middle
            if (points == 2) x = x + at(i)*parts(k)%half
            share = parts(k)%area/points
            if (m%particles%thickness%is_ring .and. parts(k)%middle(1) > 0) share = share*x(1)/parts(k)%middle(1)
            allocate (carriers, source=carriers_of(m, x, parts(k)%normal, is_weak))
            if (n + size(carriers) > size(load%particle)) call widen(load, n + size(carriers))
            do c = 1, size(carriers)
               n = n + 1
               load%particle(n) = carriers(c)
               load%fraction(n) = share/size(carriers)
               if (load%absorbs > 0) load%fraction(n) = load%fraction(n)*z_at(carriers(c), parts(k)%normal)
               load%offset(:, n) = x - m%particles%reference(carriers(c), :)
               load%half(:, n) = parts(k)%half/points
            end do
            deallocate (carriers)
         end do
      end do
      load%fraction = load%fraction(:n)
      load%particle = load%particle(:n)
      load%offset = load%offset(:, :n)
      load%half = load%half(:, :n)

   contains

      !> The component of Z of a dashpot.
      pure real(dp) function z_at(particle, normal) result(z)
         integer, intent(in) :: particle
         real(dp), intent(in) :: normal(ndim)
         associate (all => impedance(m%materials(m%particles%material(particle)), normal))
            z = all(load%absorbs)
         end associate
      end function z_at
   end subroutine lay

   !> More room for the points of a load.
   pure subroutine widen(load, n)
      type(load_t), intent(inout) :: load
      integer, intent(in) :: n                   !! how many there are to be at least
      integer :: more
      more = n                                   ! as many again
      load%particle = [load%particle, spread(0, 1, more)]
      load%fraction = [load%fraction, spread(0.0_dp, 1, more)]
      load%offset = reshape([load%offset], [ndim, size(load%particle)], pad=[0.0_dp])
      load%half = reshape([load%half], [ndim, size(load%particle)], pad=[0.0_dp])
   end subroutine widen

   !> The particles that carry a place at an edge, all equally near ones: of the piece beside it, or of all pieces if that is weak.
   function carriers_of(m, x, normal, is_weak) result(carriers)
      type(matter_t), intent(in) :: m
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: normal(ndim)       !! unit vector out of the material; 0 of a point in it
      logical, allocatable, intent(in) :: is_weak(:) !! as in `nearest_particles`
      integer, allocatable :: carriers(:)
      real(dp) :: beside(ndim), distance, nearest
      integer :: first, last, velocity_field, e, i
      beside = x - inward*m%grid%finest_cell*normal
      allocate (carriers(0))
      nearest = huge(nearest)
      first = outside
      if (any(abs(normal) > 0)) first = m%grid%element_of_face(beside)
      if (first /= outside .and. allocated(is_weak)) then
         if (is_weak(m%grid%first_of_piece(first))) first = outside
      end if
      if (first /= outside) then
         last = first
         if (m%grid%is_quadratic()) then         ! its quarters have the same functions
            first = m%grid%first_of_piece(first)
            last = m%grid%last_of_piece(first)
         end if
         do velocity_field = 1, m%grid%n_velocity_fields
            do e = m%grid%copy_on(first, velocity_field), m%grid%copy_on(last, velocity_field)
               do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
                  distance = norm(m%particles%place_in_grid(i) - x)
                  if (distance > nearest + m%grid%forest%tolerance()) cycle
                  if (distance < nearest - m%grid%forest%tolerance()) carriers = [integer ::]
                  carriers = [carriers, i]
                  nearest = min(nearest, distance)
               end do
            end do
         end do
      end if
      if (size(carriers) == 0) carriers = nearest_particles(m, x, beside, is_weak)
   end function carriers_of

   !> Cut parts of edges at lines between cells or their particles, and at cracks. Shares are proportional to areas.
   subroutine cut_parts(grid, thickness, edges, per_cell, parts)
      type(grid_t), intent(in) :: grid
      type(thickness_t), intent(in) :: thickness
      type(edge_part_t), intent(in) :: edges(:)
      integer, intent(in) :: per_cell
      type(edge_part_t), allocatable, intent(out) :: parts(:)
      type(edge_part_t), allocatable :: wider(:)
      integer :: n, k
      allocate (parts(2*size(edges) + 64))
      n = 0
      do k = 1, size(edges)
         call cut(edges(k))
      end do
      parts = parts(:n)

   contains

      !> Cut a part in two where it crosses something, and these again; else keep it.
      recursive subroutine cut(part)
         type(edge_part_t), intent(in) :: part
         type(edge_part_t) :: pieces(2)
         real(dp) :: at, along(ndim)
         integer :: i
         call find_crossing(grid, per_cell, part, at, along)
         if (.not. any(abs(along) > 0)) then
            if (n == size(parts)) then
               allocate (wider(2*n))
               wider(:n) = parts
               call move_alloc(wider, parts)
            end if
            n = n + 1
            parts(n) = part
            return
         end if
         do i = 1, 2
            pieces(i) = part
            associate (sense => 2*i - 3)         ! from there to the lower or the upper end
               pieces(i)%middle = part%middle + (sense + at)/2*along
               pieces(i)%half = part%half - (1 + sense*at)/2*along
               pieces(i)%area = part%area*(1 - sense*at)/2
            end associate
            if (thickness%is_ring .and. part%middle(1) > 0) pieces(i)%area = pieces(i)%area*pieces(i)%middle(1)/part%middle(1)
            call cut(pieces(i))
         end do
      end subroutine cut
   end subroutine cut_parts

   !> Crossing of a part with a middle line of the cell or a crack, nearest to its middle: `at`, -1 to 1 of the vector `along`, its
   !> half or the component in one direction; 0 if there is none.
   subroutine find_crossing(grid, per_cell, part, at, along)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: per_cell
      type(edge_part_t), intent(in) :: part
      real(dp), intent(out) :: at, along(ndim)
      real(dp), allocatable :: segments(:, :, :)
      real(dp) :: lower(ndim), edge
      integer :: leaf, lines, d, i
      at = 1
      along = 0
      if (.not. any(abs(part%half) > 0)) return
      leaf = grid%forest%leaf_at(part%middle - inward*grid%finest_cell*part%normal)
      if (leaf == outside) return
      lower = grid%forest%position(grid%forest%place_of(leaf))
      edge = grid%forest%size_of(leaf)
      lines = per_cell
      if (grid%is_transition(leaf) .and. .not. grid%is_quadratic()) lines = per_cell*(1 + modulo(per_cell, 2)) ! of quarters
      do d = 1, ndim
         if (abs(part%half(d)) <= least*edge) cycle
         do i = 0, lines
            call take((lower(d) + i*edge/lines - part%middle(d))/part%half(d), d)
         end do
      end do
      if (ndim > 2 .or. .not. grid%cut_cells%are_there()) return
      segments = grid%cut_cells%segments_near(leaf)
      do i = 1, size(segments, 3)
         associate (a => segments(:, 1, i) - part%middle, b => segments(:, 2, i) - segments(:, 1, i), c => part%half)
            associate (across => c(1)*b(2) - c(2)*b(1))
               if (abs(across) <= least*norm(b)*norm(c)) cycle
               if (abs((a(1)*c(2) - a(2)*c(1))/across - 0.5_dp) > 0.5_dp + least) cycle
               call take((a(1)*b(2) - a(2)*b(1))/across, 1)
            end associate
         end associate
      end do

   contains

      !> Take a crossing nearer to the middle.
      subroutine take(t, direction)
         real(dp), intent(in) :: t
         integer, intent(in) :: direction        !! in which a rectangle is cut
         real(dp) :: way(ndim)
         if (abs(t) >= abs(at)) return
         way = part%half
         if (ndim > 2) then
            way = 0
            way(direction) = part%half(direction)
         end if
         if ((1 - abs(t))*norm(way) <= least*edge) return
         at = t
         along = way
      end subroutine take
   end subroutine find_crossing
end module hampm_edge_loads
