!> The discs of a domain integral around a crack tip, and the particles in them. In the total frame the weight and singular fields
!> of a particle in a disc stay while mesh and tip stay.
module hampm_tip_domain
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: points_of_quadratic, inside_cell
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes, tip_field_t, new_tip_field, new_interface_fields
   use hampm_energy_momentum, only: frame_t, plateau, weight_at
   use hampm_grid, only: grid_t
   use hampm_material, only: material_t
   use hampm_node_list, only: node_list_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: norm, in_plane, identity
   implicit none
   private
   public :: fields, tip_domain_t, place_t, places_t, fields_at, weight_nodes, elements_of, particles_in, list_places, &
             fill_places, nodes_at_others, weights_at

   real(dp), parameter :: on_line = 1.0e-9_dp    !! part of an element within which of the crack's line a particle counts as on it
   real(dp), parameter :: singular = 1.0e-3_dp   !! part of an element within which of a tip a particle counts as at the tip

   real(dp), parameter :: inner = 4              !! cells around a tip

   integer, parameter :: fields = modes + 1      !! of a unit K of each mode, and of a unit force on the tip along the crack

   !> Offset of the effective tip behind its node, in cells there, by mode. The field of bilinear cells around a node is of a
   !> slightly shorter crack, equally at every size, like the field. Measurements: docs/explanation/energy_release_rate.md, by
   !> `bench/effective_tip.py`.
   real(dp), parameter :: tip_offset(modes) = [0.20_dp, 0.31_dp]

   !> The tip of a straight crack, and the discs around it. The axes of the frame are those of the reference configuration.
   type, extends(frame_t) :: tip_domain_t
      real(dp) :: tip(ndim) = 0                  !! its place in the grid [m]
      real(dp) :: face_of_line = 1               !! 1: material on the line of the crack is on the upper face, -1: the lower
      logical :: is_beside = .false.             !! whether the tip is ahead or behind: particles on the line may be on both faces
      integer :: number = -1                     !! of the tip among those of cut cells, -1 if none ends there
      logical :: has_zone = .false.              !! whether cohesion holds faces ahead of it
      logical :: half = .false.                  !! whether the crack is on a symmetry plane and one side of it is modelled
      real(dp) :: side = 1                       !! which: 1 the upper, -1 the lower one
      real(dp) :: thickness = 0                  !! B; of a crack around an axis the length of its front, 2 pi a [m]
      logical :: is_ring = .false.               !! whether it is one
      type(material_t) :: material               !! in which the tip is
      logical, allocatable :: ends_at(:)         !! by body: whether the discs end where it begins; not allocated: at none
      real(dp), allocatable :: radius(:)         !! of each disc [m]
      real(dp) :: cell = 0                       !! size of the cells at the tip; 0 for an exact field [m]
      real(dp) :: spacing = 0                    !! of these cells, of any tip [m]
      type(tip_field_t) :: field                 !! singular fields by material and direction; at an interface those above it
      type(tip_field_t) :: below                 !! and those below it
      real(dp) :: speed = 0                      !! of the tip, with the fields of which it runs [m/s]
      real(dp) :: carried(ndim) = 0              !! then, mean velocity of the material in the discs, in the axes [m/s]
      logical :: quadratic = .false.             !! whether cells are quadratic
      real(dp) :: tip_offset(modes) = 0          !! of these, else 0 [cells]
      logical :: has_force = .false.             !! whether the interaction with a force is asked for, which tells T
   contains
      procedure :: tip_offset_of
      procedure :: from_tip
      procedure :: displacement_of
      procedure :: inner_radius
   end type tip_domain_t

   !> A particle in the discs. Vectors are in the axes of the crack, the first of which is its direction.
   type :: place_t
      integer :: particle
      integer :: point(points_of_quadratic)      !! points of its values, as many as there are functions
      real(dp) :: shape(points_of_quadratic)     !! their functions there [-]
      real(dp) :: weight                         !! in means over the discs, besides its volume [-]
      real(dp) :: unit(ndim, ndim, fields)       !! displacement gradient of a unit K of each mode, 0 at the tip
                                                 !! itself [1/(Pa sqrt(m))], and of the force [1/(N/m)]
      real(dp) :: unit_stress(ndim, ndim, fields) !! and its stress [1/sqrt(m)]
      real(dp) :: resolved                       !! part of the source of the interaction with the force that is left to particles
   end type place_t

   !> All particles in the discs of a tip.
   type :: places_t
      type(place_t), allocatable :: list(:)
      real(dp), allocatable :: q(:, :)           !! weight in each disc [-], (radii, places)
      real(dp), allocatable :: dq(:, :, :)       !! and its gradient [1/m], (ndim, radii, places)
      integer :: bounds(2) = [1, 0]              !! first and last point of the grid that may have a weight
      integer, allocatable :: point(:)           !! those with one
      real(dp), allocatable :: nodal(:, :)       !! theirs [-], (radii, size(point))
      integer, private :: layout = -1            !! of the blocks that they are in
      real(dp), allocatable, private :: key(:)   !! of the tip that they are of, see `key_of`
   contains
      procedure :: weigh_points
      procedure, private :: stay
   end type places_t

contains

   !> The singular fields at a tip: those above and below its crack.
   pure function fields_at(materials, tip) result(fields)
      type(material_t), intent(in) :: materials(:)
      type(crack_tip_t), intent(in) :: tip
      type(tip_field_t) :: fields(2)
      if (tip%phase_length > 0) then
         fields = new_interface_fields(materials(tip%material), materials(tip%below), tip%axis(:, 1), tip%phase_length)
      else
         fields = new_tip_field(materials(tip%material_in(materials)), tip%axis(:, 1))
      end if
   end function fields_at

   !> q at the points of the grid: 1 up to a part of the radius, then a cubic with level ends, 0 from the radius on.
   !>
   !> Between them q has the shape functions of the grid. That makes J nearly independent of the disc: the equilibrium of the nodes
   !> holds for weights of just that kind, and the particles integrate them as they integrate the nodal forces. Only leaves around
   !> the tip are looked at, and in uniform grids only their points have a place in q: there may be many tips.
   pure subroutine weight_nodes(domain, grid, q, leaves, level)
      type(tip_domain_t), intent(in) :: domain
      type(grid_t), intent(in) :: grid
      real(dp), allocatable, intent(out) :: q(:, :)  !! [-], (radii, from the first to the last point, see `weights_at`)
      integer, allocatable, intent(out) :: leaves(:) !! all that have a point with a weight, ascending
      real(dp), intent(in), optional :: level    !! up to which q is 1, else half of each radius [m]
      real(dp) :: inner(size(domain%radius)), x(ndim), reach, lower(ndim), upper(ndim)
      integer :: i, k, e, c, first, last, radii
      reach = maxval(domain%radius)
      inner = plateau*domain%radius
      if (present(level)) inner = level
      lower = domain%tip - reach
      upper = domain%tip + reach
      leaves = grid%forest%leaves_in(lower, upper)
      first = 1
      last = grid%n_points
      if (grid%dofs%n_hanging == 0) then
         last = 0
         do k = 1, size(leaves)
            associate (nodes => grid%element_nodes(:, grid%leaf_element(leaves(k)):grid%leaf_element(leaves(k) + 1) - 1))
               first = merge(minval(nodes), min(first, minval(nodes)), last == 0)
               last = max(last, maxval(nodes))
            end associate
         end do
      end if
      radii = size(domain%radius)
      allocate (q(radii, first:last), source=0.0_dp)
      do k = 1, size(leaves)
         do e = grid%leaf_element(leaves(k)), grid%leaf_element(leaves(k) + 1) - 1
            do c = 1, corners
               i = grid%element_nodes(c, e)
               if (i > grid%n_nodes) cycle
               x = grid%node_position(:, i) - domain%tip
               if (abs(x(1)) >= reach .or. abs(x(2)) >= reach) cycle
               q(:, i) = weight_at(norm(x), domain%radius, inner)
            end do
         end do
      end do
      if (grid%dofs%n_hanging == 0) return
      call spread_to_hanging(grid, q)
      do i = grid%n_nodes + 1, grid%n_points     ! which may be farther out
         if (.not. any(abs(q(:, i)) > 0)) cycle
         lower = min(lower, grid%node_position(:, i))
         upper = max(upper, grid%node_position(:, i))
      end do
      leaves = grid%forest%leaves_in(lower, upper)
   end subroutine weight_nodes

   !> The weights at a point; 0 at those that have no place in q.
   pure function weights_at(q, point) result(weights)
      real(dp), allocatable, intent(in) :: q(:, :) !! [-], (radii, points)
      integer, intent(in) :: point
      real(dp) :: weights(size(q, 1))
      weights = 0
      if (point >= lbound(q, 2) .and. point <= ubound(q, 2)) weights = q(:, point)
   end function weights_at

   !> Give hanging points the weights of their masters.
   pure subroutine spread_to_hanging(grid, q)
      type(grid_t), intent(in) :: grid
      real(dp), intent(inout) :: q(:, :)         !! [-], (radii, n_points)
      type(node_list_t) :: all
      if (grid%dofs%n_hanging == 0) return
      all = grid%dofs%every_node()
      call grid%dofs%distribute(all, size(q, 1), q)
   end subroutine spread_to_hanging

   !> Elements of some leaves with particles, in the same order.
   pure function elements_of(leaves, grid, blocks) result(elements)
      integer, intent(in) :: leaves(:)
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      integer, allocatable :: elements(:)
      integer :: k, e, n
      allocate (elements(sum(grid%leaf_element(leaves + 1) - grid%leaf_element(leaves))))
      n = 0
      do k = 1, size(leaves)
         do e = grid%leaf_element(leaves(k)), grid%leaf_element(leaves(k) + 1) - 1
            if (blocks%count_in(e) == 0) cycle
            n = n + 1
            elements(n) = e
         end do
      end do
      elements = elements(:n)
   end function elements_of

   !> Particles in cells with a part in the square around a disc, and in cells with a node that hangs from such a cell.
   pure function particles_in(tip, radius, grid, blocks) result(particles)
      real(dp), intent(in) :: tip(ndim), radius  !! [m]
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      integer, allocatable :: particles(:), elements(:)
      real(dp) :: reach                          ! [m]
      integer :: k, i, n
      reach = radius
      if (grid%dofs%n_hanging > 0) &
         reach = radius + maxval(grid%element_size(grid%leaf_element(grid%forest%leaves_in(tip - radius, tip + radius))))
      elements = elements_of(grid%forest%leaves_in(tip - reach, tip + reach), grid, blocks)
      allocate (particles(sum(blocks%count_in(elements))))
      n = 0
      do k = 1, size(elements)
         do i = blocks%first_in(elements(k)), blocks%last_in(elements(k)), blocks%stride_in(elements(k))
            n = n + 1
            particles(n) = i
         end do
      end do
   end function particles_in

   !> End the discs where bodies of other materials begin: within a disc their material forces would count as the tip's.
   pure subroutine end_at_others(domain, grid, p, q)
      type(tip_domain_t), intent(in) :: domain
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      real(dp), allocatable, intent(inout) :: q(:, :) !! [-], (radii, points)
      logical :: is_at_other(grid%n_points)
      integer :: i
      is_at_other = nodes_at_others(domain%tip, domain%spacing, domain%ends_at, grid, p)
      do i = lbound(q, 2), min(grid%n_nodes, ubound(q, 2))
         if (is_at_other(i)) q(:, i) = 0
      end do
      call spread_to_hanging(grid, q)
   end subroutine end_at_others

   !> Points of cells with particles of some bodies, without those of the cell of a tip.
   pure function nodes_at_others(tip, spacing, bodies, grid, p) result(are)
      real(dp), intent(in) :: tip(ndim)          !! its place in the grid [m]
      real(dp), intent(in) :: spacing            !! of the cells there [m]
      logical, intent(in) :: bodies(:)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      logical :: are(grid%n_points)
      integer :: i
      are = .false.
      do i = 1, p%n
         if (bodies(p%body(i))) are(grid%support_of(p%cell(i))) = .true.
      end do
      call grid%dofs%mark_masters(are)
      do i = 1, grid%n_nodes
         if (maxval(abs(grid%node_position(:, i) - tip)) < spacing*(1 - on_line)) are(i) = .false.
      end do
   end function nodes_at_others

   !> List the particles in the discs of a tip, with their weights in means; found ones stay where nothing has moved.
   pure subroutine list_places(domain, grid, blocks, p, places)
      type(tip_domain_t), intent(in) :: domain
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      type(particles_t), intent(in) :: p
      type(places_t), intent(inout) :: places
      real(dp), allocatable :: q(:, :)           ! of points of the grid [-], (radii, points)
      real(dp), allocatable :: weight(:)         ! of elements there
      integer, allocatable :: leaves(:), elements(:), inside(:)
      integer :: at(grid%n_functions), k, i, n, found, largest
      if (places%stay(domain, blocks, p)) return
      places%layout = -1
      call weight_nodes(domain, grid, q, leaves)
      if (allocated(domain%ends_at)) call end_at_others(domain, grid, p, q)
      call keep_points(leaves, grid, q, places)
      largest = maxloc(domain%radius, dim=1)
      elements = elements_of(leaves, grid, blocks)
      allocate (weight(size(elements)), inside(size(elements)))
      n = 0
      do k = 1, size(elements)
         associate (e => elements(k))
            at = grid%support_of(e)
            if (.not. any(abs(q(largest, at)) > 0)) cycle
            if (.not. grid%is_in_first_field(e)) cycle ! bodies that meet the cracked one are not part of it
            inside(n + 1) = e
            weight(n + 1) = sum(q(:, at))
            if (weight(n + 1) > 0) n = n + 1
         end associate
      end do
      if (allocated(places%list)) deallocate (places%list)
      allocate (places%list(sum(blocks%count_in(inside(:n)))))
      found = n
      n = 0
      do k = 1, found
         associate (e => inside(k))
            do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
               n = n + 1
               places%list(n)%particle = i
               places%list(n)%weight = weight(k)
            end do
         end associate
      end do
   end subroutine list_places

   !> Keep the weights of the points of some leaves that have any.
   pure subroutine keep_points(leaves, grid, q, places)
      integer, intent(in) :: leaves(:)
      type(grid_t), intent(in) :: grid
      real(dp), allocatable, intent(inout) :: q(:, :) !! [-], (radii, points); the same at the end
      type(places_t), intent(inout) :: places
      real(dp), allocatable :: nodal(:, :)
      integer, allocatable :: point(:)
      integer :: k, e, c, n
      n = corners*sum(grid%leaf_element(leaves + 1) - grid%leaf_element(leaves))
      allocate (point(n), nodal(size(q, 1), n))
      n = 0
      do k = 1, size(leaves)
         do e = grid%leaf_element(leaves(k)), grid%leaf_element(leaves(k) + 1) - 1
            do c = 1, corners
               associate (i => grid%element_nodes(c, e))
                  if (.not. any(abs(q(:, i)) > 0)) cycle
                  n = n + 1
                  point(n) = i
                  nodal(:, n) = q(:, i)
                  q(:, i) = 0                    ! it is listed once
               end associate
            end do
         end do
      end do
      places%bounds = [lbound(q, 2), ubound(q, 2)]
      places%point = point(:n)
      places%nodal = nodal(:, :n)
      q(:, places%point) = places%nodal
   end subroutine keep_points

   !> Weights at the points of the grid.
   pure subroutine weigh_points(self, q)
      class(places_t), intent(in) :: self
      real(dp), allocatable, intent(out) :: q(:, :) !! [-], (radii, points, see `weights_at`)
      integer :: radii
      radii = size(self%nodal, 1)
      allocate (q(radii, self%bounds(1):self%bounds(2)), source=0.0_dp)
      q(:, self%point) = self%nodal
   end subroutine weigh_points

   !> Fill the listed places with their values in the discs, which may turn in the updated frame.
   pure subroutine fill_places(domain, grid, blocks, p, nodal, places)
      type(tip_domain_t), intent(in) :: domain
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      type(particles_t), intent(in) :: p
      real(dp), allocatable, intent(in) :: nodal(:, :) !! weights at the points [-], (radii, points)
      type(places_t), intent(inout) :: places
      integer :: n
      if (places%stay(domain, blocks, p)) return
      if (allocated(places%q)) deallocate (places%q, places%dq)
      allocate (places%q(size(domain%radius), size(places%list)), places%dq(ndim, size(domain%radius), size(places%list)))
      do n = 1, size(places%list)
         call fill_place(domain, grid, p, nodal, places%list(n), places%q(:, n), places%dq(:, :, n))
      end do
      places%layout = blocks%layout
      places%key = key_of(domain)
   end subroutine fill_places

   !> Values of a particle in the discs.
   pure subroutine fill_place(domain, grid, p, nodal, place, q, dq)
      type(tip_domain_t), intent(in) :: domain
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      real(dp), allocatable, intent(in) :: nodal(:, :) !! (radii, points)
      type(place_t), intent(inout) :: place
      real(dp), intent(out) :: q(:), dq(:, :)    !! (radii), (ndim, radii)
      real(dp), dimension(grid%n_functions, ndim) :: gradient, in_grid
      real(dp) :: to_reference(ndim, ndim), deformation(ndim, ndim), xi(ndim), x(ndim)
      integer :: k, r
      associate (i => place%particle, e => p%cell(place%particle))
         to_reference = domain%axes
         if (.not. p%total_frame) then
            deformation = identity + p%gradient_of(i)
            to_reference = matmul(deformation, domain%axes)
         end if
         xi = inside_cell(grid%local_coordinate(e, p%place_in_grid(i)))
         call grid%shape_functions_in(e, xi, place%point, place%shape)
         in_grid = grid%gradients_in(e, xi)
         gradient = matmul(in_grid, to_reference)
         q = 0
         dq = 0
         do k = 1, grid%n_functions
            do r = 1, size(q)
               associate (at => nodal(r, place%point(k)))
                  q(r) = q(r) + at*place%shape(k)
                  dq(:, r) = dq(:, r) + at*gradient(k, :)
               end associate
            end do
         end do
         x = domain%from_tip(p%place_in_grid(i), p%total_frame)
         associate (size => grid%element_size(e))
            if (abs(x(2)) <= on_line*size) x(2) = sign(x(2), domain%face_of_line)
            call fill_fields(domain, merge(domain%below, domain%field, domain%field%is_at_interface .and. x(2) < 0), x, size, place)
         end associate
      end associate
   end subroutine fill_place

   !> The fields of each mode at a place, and of the force. With a singular part (`hampm_t_stress`) that acts at the origin of K.
   pure subroutine fill_fields(domain, field, x, size, place)
      type(tip_domain_t), intent(in) :: domain
      type(tip_field_t), intent(in) :: field     !! on this side of the crack
      real(dp), intent(in) :: x(ndim), size      !! from the tip in the axes of the crack, and of the element [m]
      type(place_t), intent(inout) :: place
      real(dp) :: from_mode(ndim)
      integer :: mode
      place%unit = 0
      do mode = 1, modes
         from_mode = in_plane(x(1) + domain%tip_offset_of(mode), x(2)) ! the sign of a zero second component gives the face
         associate (a => place%unit(:, :, mode))
            if (norm(from_mode) >= singular*size) then
               a = field%gradient(mode, from_mode)
               if (domain%is_beside .and. abs(x(2)) <= on_line*size) & ! it is on both faces
                  a = (a + field%gradient(mode, in_plane(from_mode(1), -x(2))))/2
            end if
            place%unit_stress(:, :, mode) = field%stress(a)
         end associate
      end do
      if (.not. domain%has_force) return
      place%resolved = 1
      from_mode = x
      if (domain%is_ring .or. domain%material%is_graded()) then
         from_mode(1) = x(1) + domain%tip_offset_of(1)
         place%resolved = min(1.0_dp, norm(from_mode)/domain%inner_radius())
      end if
      if (norm(from_mode) > 0) place%unit(:, :, fields) = domain%field%gradient_of_force(from_mode)
      place%unit_stress(:, :, fields) = domain%field%stress(place%unit(:, :, fields))
   end subroutine fill_fields

   !> Whether places found are still those of a tip.
   pure logical function stay(self, domain, blocks, p)
      class(places_t), intent(in) :: self
      type(tip_domain_t), intent(in) :: domain
      type(cell_blocks_t), intent(in) :: blocks
      type(particles_t), intent(in) :: p
      stay = .false.
      if (.not. p%total_frame .or. self%layout /= blocks%layout) return
      associate (key => key_of(domain))
         if (size(self%key) == size(key)) stay = .not. any(abs(self%key - key) > 0)
      end associate
   end function stay

   !> Key of the tip on which places depend.
   pure function key_of(domain) result(key)
      type(tip_domain_t), intent(in) :: domain
      real(dp), allocatable :: key(:)
      key = [domain%tip, domain%axes(:, 1), domain%cell, domain%tip_offset, domain%face_of_line, &
             merge(1.0_dp, 0.0_dp, [domain%is_beside, domain%has_force]), domain%speed, domain%radius]
   end function key_of

   !> Offset of the effective tip behind its node in a mode [m].
   pure real(dp) function tip_offset_of(self, mode)
      class(tip_domain_t), intent(in) :: self
      integer, intent(in) :: mode
      tip_offset_of = merge(self%tip_offset(mode), tip_offset(mode), self%tip_offset(mode) > 0)*self%cell
      if (self%field%is_at_interface) & ! either K has both modes
         tip_offset_of = sum(merge(self%tip_offset, tip_offset, self%tip_offset > 0))/modes*self%cell
   end function tip_offset_of

   !> Position of a place in the grid relative to the tip, in the axes of the crack [m].
   pure function from_tip(self, x, total_frame)
      class(tip_domain_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      logical, intent(in) :: total_frame         !! whether the grid is of the reference configuration
      real(dp) :: from_tip(ndim)
      if (total_frame) then
         from_tip = matmul(x - self%tip, self%axes)
      else
         from_tip = self%in_axes(x - self%tip)
      end if
   end function from_tip

   !> Displacement by the singular fields at a place, in crack axes: of order 1/2, twice its radial gradient times distance [m].
   pure function displacement_of(self, place, x, k)
      class(tip_domain_t), intent(in) :: self
      type(place_t), intent(in) :: place
      real(dp), intent(in) :: x(ndim)            !! from the tip, in the axes of the crack [m]
      real(dp), intent(in) :: k(modes)           !! [Pa sqrt(m)]
      real(dp) :: displacement_of(ndim)
      integer :: mode
      displacement_of = 0
      do mode = 1, modes
         displacement_of = displacement_of + 2*k(mode)*matmul(place%unit(:, :, mode), x + self%tip_offset_of(mode)*identity(:, 1))
      end do
   end function displacement_of

   !> Distance from the tip within which products of singular fields, unresolved by cells, are not left to particles: some cells, at
   !> most half of the least radius, where q is 1 [m].
   pure real(dp) function inner_radius(self)
      class(tip_domain_t), intent(in) :: self
      inner_radius = min(minval(self%radius)/2, inner*self%spacing)
   end function inner_radius
end module hampm_tip_domain
