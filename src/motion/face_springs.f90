!> Springs between the two sides of cracks that cut cells (`hampm_cut_cells`): bonds, and contact.
!>
!> Bonds: a cell in which a crack ends is cut as a whole, and what of its cut lies ahead of the tip is held together by a layer of
!> springs. So the crack of the cells grows with that of the scene, and not by whole cells.
!>
!> Contact: where the faces would go through each other springs push them apart, and with friction they hold them along the face, up
!> to the coefficient times the pressure; what is beyond slides (return mapping). The overlap that presses is the compliance of the layer,
!> that of a third of a cell.
!>
!> The springs act at points along the crack. The opening at a point is what the shape functions there make of the displacements of
!> the nodes of both sides,
!>
!>    g = sum over nodes of c_j u_j,   force on node j   -c_j f(g),
!>
!> and follows these in every step, in the total frame. A node with little mass would tremble faster than any cell does: in explicit
!> steps springs are weaker where they must be, so that with M the lumped masses the largest eigenvalue of M**-1 K of all springs by
!> themselves is at most a part of that of the cells.
!>
!> Source: Wriggers, Computational Contact Mechanics (2006), sections 5.2 (penalty) and 10.5 (return mapping of friction).
module hampm_face_springs
   use hampm_kinds, only: dp, ndim, corners
   use hampm_archive, only: archive_t
   use hampm_basis, only: shape_functions
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_forest, only: outside
   use hampm_grid, only: grid_t
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: face_springs_t, rebuild_springs, look_at_openings, shorter_step, add_spring_forces, stretch_springs, settle_slip, &
             spring_energy, spring_states, spring_stiffness, have_friction, relax_springs, &
             look_at_faces, is_closed_at, keep_springs

   integer, parameter :: bond = 1, closed = 2    !! what a spring is for
   integer, parameter :: is_open = 0, sticks = 1, slides = 2 !! what it does

   integer, parameter :: points = 4              !! of a layer, those of Gauss
   real(dp), parameter :: outer = 0.8611363115940526_dp, inner = 0.3399810435848563_dp
   real(dp), parameter :: place(points) = [-outer, -inner, inner, outer] !! in a layer from -1 to 1
   real(dp), parameter :: of_outer = 0.3478548451374538_dp/2, of_inner = 0.6521451548625461_dp/2
   real(dp), parameter :: part(points) = [of_outer, of_inner, of_inner, of_outer] !! of the layer that each stands for

   !> Stiffness of a layer for each area, in E'/h. As bonds, of 0.3, 1, 3 and 10 the last two leave the least scatter of J between
   !> places of the tip (docs/cracks.md).
   real(dp), parameter :: firmness = 3

   !> The largest eigenvalue of the springs, over (c/h)**2 with c the speed of pressure waves; that of cells is 4 at least.
   real(dp), parameter :: most_of_cells = 1.2_dp

   !> Factor of the time step that is stable for whole cells, with cells that are cut, which multiply the largest eigenvalue by 1.27
   !> at most, and with springs: 1/sqrt(1.27 + 1.2/4).
   real(dp), parameter :: shorter_step = 0.79_dp

   !> All springs.
   type :: face_springs_t
      real(dp) :: thickness = 0                  !! of the plate [m]
      logical :: are_bounded = .true.            !! whether explicit steps have to be stable
      integer :: n = 0                           !! number of springs
      integer :: n_contact = 0                   !! of which are for contact
      integer, allocatable :: kind(:)            !! `bond` or `closed`
      integer, allocatable :: node(:, :)         !! whose displacement matters, 0 behind the last; (2 most_nodes_of_leaf, n)
      real(dp), allocatable :: share(:, :)       !! c_j [-]
      real(dp), allocatable :: stiffness(:)      !! s [N/m]
      real(dp), allocatable :: place(:, :)       !! on the line [m], (ndim, n)
      real(dp), allocatable :: length(:)         !! of the line that each stands for [m]
      real(dp), allocatable :: normal(:, :)      !! from the right to the left face, (ndim, n)
      real(dp), allocatable :: friction(:)       !! coefficient [-]
      real(dp), allocatable :: opening(:, :)     !! g, of the left face from the right one [m], (ndim, n)
      real(dp), allocatable :: slip(:)           !! sliding at which the faces hold each other without a force along them [m]
      real(dp), allocatable :: pressed(:)        !! by how much the faces overlapped after the last step [m]
      real(dp) :: loss = 0                       !! energy taken by friction [J]
   end type face_springs_t

contains

   !> Find the springs of a new grid; their openings are those of the particles beside them, and what has slid stays so.
   pure subroutine rebuild_springs(springs, grid, p, blocks, materials)
      type(face_springs_t), intent(inout) :: springs
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(material_t), intent(in) :: materials(:)
      integer :: k
      springs%n = 0
      springs%n_contact = 0
      if (.not. grid%cut_cells%are_there()) return
      if (.not. allocated(springs%kind)) call make_room(springs, 64)
      do k = 1, size(grid%cut_cells%ends)
         associate (end => grid%cut_cells%ends(k))
            if (end%leaf > 0) call add_layer(springs, grid, p, blocks, materials, bond, end%tip, end%front, 0.0_dp)
         end associate
      end do
      do k = 1, size(grid%cut_cells%lines)
         if (grid%cut_cells%lines(k)%contact) call add_contact(springs, grid, p, blocks, materials, k)
      end do
      if (springs%n > 0 .and. springs%are_bounded) call soften(springs, grid, p, blocks, materials)
   end subroutine rebuild_springs

   !> The least opening normal to a line, over the points where springs would be, and the largest jump between its faces [m]; 0 where
   !> there are none.
   pure subroutine look_at_openings(grid, p, blocks, materials, line, least, largest)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(material_t), intent(in) :: materials(:)
      integer, intent(in) :: line
      real(dp), intent(out) :: least, largest
      type(face_springs_t) :: springs
      integer :: k
      call make_room(springs, 64)
      call add_contact(springs, grid, p, blocks, materials, line)
      least = 0
      largest = 0
      do k = 1, springs%n
         least = min(least, dot_product(springs%normal(:, k), springs%opening(:, k)))
         largest = max(largest, norm2(springs%opening(:, k)))
      end do
   end subroutine look_at_openings

   !> Add contact along a line, leaf by leaf, up to its tips.
   pure subroutine add_contact(springs, grid, p, blocks, materials, line)
      type(face_springs_t), intent(inout) :: springs
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(material_t), intent(in) :: materials(:)
      integer, intent(in) :: line
      real(dp), parameter :: least_part = 1e-6_dp ! of a leaf
      real(dp) :: direction(ndim), aside(ndim), from, to, length, step
      integer :: i, leaf, d
      associate (points => grid%cut_cells%lines(line)%points, forest => grid%forest)
         do i = 2, size(points, 2)
            length = norm2(points(:, i) - points(:, i - 1))
            direction = (points(:, i) - points(:, i - 1))/length
            aside = least_part*forest%cell*([-direction(2), direction(1)] + direction)
            from = 0
            do while (from < length)
               leaf = forest%leaf_at(points(:, i - 1) + from*direction + aside)
               step = forest%cell/4
               if (leaf /= outside) then
                  step = 2*forest%size_of(leaf)
                  associate (lower => forest%position(forest%place_of(leaf)), x => points(:, i - 1) + from*direction + aside)
                     do d = 1, ndim
                        if (direction(d) > least_part) step = min(step, (lower(d) + forest%size_of(leaf) - x(d))/direction(d))
                        if (direction(d) < -least_part) step = min(step, (lower(d) - x(d))/direction(d))
                     end do
                  end associate
                  step = max(step, least_part*forest%size_of(leaf))
               end if
               to = min(from + step, length)
               if (leaf /= outside) call add_layer(springs, grid, p, blocks, materials, closed, points(:, i - 1) + from*direction, &
                                                   points(:, i - 1) + to*direction, grid%cut_cells%lines(line)%friction)
               from = to + least_part*forest%cell
            end do
         end do
      end associate
   end subroutine add_contact

   !> Add the springs of a layer between two places of a line in a leaf, where there is material on both of its sides.
   pure subroutine add_layer(springs, grid, p, blocks, materials, kind, from, to, friction)
      type(face_springs_t), intent(inout) :: springs
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(material_t), intent(in) :: materials(:)
      integer, intent(in) :: kind
      real(dp), intent(in) :: from(ndim), to(ndim) !! [m]
      real(dp), intent(in) :: friction
      real(dp), parameter :: beside = 1e-4_dp    ! root cells
      real(dp) :: x(ndim), normal(ndim), weight(corners, most_nodes_of_leaf)
      integer :: i, side, e(2), master(most_nodes_of_leaf), n, j
      if (.not. norm2(to - from) > 0) return
      normal = [-(to(2) - from(2)), to(1) - from(1)]/norm2(to - from)
      do i = 1, points
         x = (from + to)/2 + place(i)*(to - from)/2
         do side = 1, 2
            e(side) = grid%element_at(x + (3 - 2*side)*beside*grid%forest%cell*normal)
         end do
         if (any(e == 0) .or. e(1) == e(2)) cycle
         if (any(blocks%count_in(e) == 0)) cycle
         if (springs%n == size(springs%kind)) call make_room(springs, 2*springs%n)
         springs%n = springs%n + 1
         if (kind == closed) springs%n_contact = springs%n_contact + 1
         associate (s => springs%n)
            springs%kind(s) = kind
            springs%node(:, s) = 0
            springs%share(:, s) = 0
            springs%opening(:, s) = 0
            springs%place(:, s) = x
            springs%length(s) = part(i)*norm2(to - from)
            springs%normal(:, s) = normal
            springs%friction(s) = friction
            n = 0
            do side = 1, 2
               associate (element => e(side))
                  call grid%dofs%masters_of(grid%element_nodes(:, element), j, master, weight)
                  springs%node(n + 1:n + j, s) = master(:j)
                  springs%share(n + 1:n + j, s) = (3 - 2*side) &
                                                  *matmul(shape_functions(grid%local_coordinate(element, x)), weight(:, :j))
                  n = n + j
                  springs%opening(:, s) = springs%opening(:, s) + (3 - 2*side)*displacement_at(p, blocks, element, x)
               end associate
            end do
            springs%slip(s) = dot_product(along(springs, s), springs%opening(:, s))
            springs%pressed(s) = max(0.0_dp, -dot_product(normal, springs%opening(:, s)))
            associate (material => materials(p%material(blocks%first_in(e(1)))))
               springs%stiffness(s) = firmness*material%plane_modulus()/grid%leaf_size(e(1)) &
                                      *springs%thickness*part(i)*norm2(to - from)
            end associate
         end associate
      end do
   end subroutine add_layer

   !> Room for a number of springs; those that there are stay.
   pure subroutine make_room(springs, most)
      type(face_springs_t), intent(inout) :: springs
      integer, intent(in) :: most
      type(face_springs_t) :: more
      more%thickness = springs%thickness
      more%are_bounded = springs%are_bounded
      more%n = springs%n
      more%n_contact = springs%n_contact
      more%loss = springs%loss
      allocate (more%kind(most), more%node(2*most_nodes_of_leaf, most), more%share(2*most_nodes_of_leaf, most), &
                more%stiffness(most), more%place(ndim, most), more%length(most), more%normal(ndim, most), &
                more%friction(most), more%opening(ndim, most), more%slip(most), more%pressed(most))
      associate (n => springs%n)
         if (n > 0) then
            more%kind(:n) = springs%kind(:n)
            more%node(:, :n) = springs%node(:, :n)
            more%share(:, :n) = springs%share(:, :n)
            more%stiffness(:n) = springs%stiffness(:n)
            more%place(:, :n) = springs%place(:, :n)
            more%length(:n) = springs%length(:n)
            more%normal(:, :n) = springs%normal(:, :n)
            more%friction(:n) = springs%friction(:n)
            more%opening(:, :n) = springs%opening(:, :n)
            more%slip(:n) = springs%slip(:n)
            more%pressed(:n) = springs%pressed(:n)
         end if
      end associate
      springs = more
   end subroutine make_room

   !> Make springs weaker, so that no eigenvalue is too large: row sums bound them.
   pure subroutine soften(springs, grid, p, blocks, materials)
      type(face_springs_t), intent(inout) :: springs
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(material_t), intent(in) :: materials(:)
      integer, parameter :: turns = 4
      integer, allocatable :: first(:), user(:)
      real(dp) :: row(springs%n), most(springs%n), mass(grid%n_nodes)
      integer :: turn, k, l, i, j, u
      call list_users(springs, grid%n_nodes, first, user)
      mass = 0
      do i = 1, grid%n_nodes
         if (first(i + 1) > first(i)) mass(i) = mass_at(grid, p, blocks, i)
      end do
      do k = 1, springs%n
         associate (e => grid%dofs%elements_at(springs%node(1, k)))
            most(k) = most_of_cells*(fastest(materials)/maxval([(grid%leaf_size(e(i)), i=1, size(e))]))**2
         end associate
      end do
      do turn = 1, turns
         row = 0
         do k = 1, springs%n
            do i = 1, count(springs%node(:, k) > 0)
               associate (node => springs%node(i, k))
                  do u = first(node), first(node + 1) - 1
                     l = user(u)
                     do j = 1, count(springs%node(:, l) > 0)
                        if (springs%node(j, l) == node) row(k) = row(k) + abs(springs%share(i, k)*springs%share(j, l))/mass(node) &
                                                                 *sqrt(springs%stiffness(k)*springs%stiffness(l))
                     end do
                  end do
               end associate
            end do
         end do
         if (all(row <= most)) return
         where (row > most) springs%stiffness(:springs%n) = most/row*springs%stiffness(:springs%n)
      end do
   end subroutine soften

   !> The largest speed of pressure waves [m/s].
   pure real(dp) function fastest(materials)
      type(material_t), intent(in) :: materials(:)
      integer :: k
      fastest = maxval([(materials(k)%dilatational_wave_speed(), k=1, size(materials))])
   end function fastest

   !> The springs that each node belongs to, in rows.
   pure subroutine list_users(springs, n_nodes, first, user)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: n_nodes
      integer, allocatable, intent(out) :: first(:), user(:)
      integer :: k, j
      allocate (first(n_nodes + 1), source=0)
      do k = 1, springs%n
         do j = 1, count(springs%node(:, k) > 0)
            first(springs%node(j, k)) = first(springs%node(j, k)) + 1
         end do
      end do
      do k = 2, n_nodes + 1
         first(k) = first(k - 1) + first(k)
      end do
      allocate (user(first(n_nodes + 1)))
      do k = springs%n, 1, -1
         do j = count(springs%node(:, k) > 0), 1, -1
            user(first(springs%node(j, k))) = k
            first(springs%node(j, k)) = first(springs%node(j, k)) - 1
         end do
      end do
      first = first + 1
   end subroutine list_users

   !> Lumped mass of a node by the particles of the elements around it, without what hanging nodes would give it [kg].
   pure real(dp) function mass_at(grid, p, blocks, node) result(mass)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: node
      real(dp) :: shape(corners), x(ndim)
      integer :: k, i
      mass = tiny(mass)
      associate (elements => grid%dofs%elements_at(node), corner => grid%dofs%corners_at(node))
         do k = 1, size(elements)
            associate (e => elements(k))
               do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                  x = p%reference(i, :)
                  shape = shape_functions(grid%local_coordinate(e, x))
                  mass = mass + p%mass(i)*shape(corner(k))
               end do
            end associate
         end do
      end associate
   end function mass_at

   !> Displacement at a place by the particles of an element: the mean of what each tells [m].
   pure function displacement_at(p, blocks, e, x) result(u)
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: e
      real(dp), intent(in) :: x(ndim)            !! in the reference configuration [m]
      real(dp) :: u(ndim)
      integer :: i
      u = 0
      do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
         u = u + (p%displacement(i, :) + matmul(p%gradient_of(i), x - p%reference(i, :)))/blocks%count_in(e)
      end do
   end function displacement_at

   !> Unit vector along the line of a spring.
   pure function along(springs, k) result(t)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp) :: t(ndim)
      t = [springs%normal(2, k), -springs%normal(1, k)]
   end function along

   !> What a spring does.
   pure integer function state_of(springs, k) result(state)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp) :: pressed
      state = sticks
      if (springs%kind(k) == bond) return
      pressed = -dot_product(springs%normal(:, k), springs%opening(:, k))
      if (pressed < 0) then
         state = is_open
      else if (.not. springs%friction(k) > 0 .or. &
               abs(dot_product(along(springs, k), springs%opening(:, k)) - springs%slip(k)) > springs%friction(k)*pressed) then
         state = slides
      end if
   end function state_of

   !> What all springs do: a matrix that was factorised fits as long as this stays.
   pure function spring_states(springs) result(states)
      type(face_springs_t), intent(in) :: springs
      integer :: states(springs%n)
      integer :: k
      do k = 1, springs%n
         states(k) = state_of(springs, k)
      end do
   end function spring_states

   !> Force by which a spring resists its opening [N].
   pure function force_of(springs, k) result(force)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp) :: force(ndim)
      real(dp) :: across, sliding
      associate (g => springs%opening(:, k), n => springs%normal(:, k), s => springs%stiffness(k))
         if (springs%kind(k) == bond) then
            force = s*g
            return
         end if
         across = dot_product(n, g)
         sliding = dot_product(along(springs, k), g) - springs%slip(k)
         select case (state_of(springs, k))
          case (sticks)
            force = s*(across*n + sliding*along(springs, k))
          case (slides)
            force = s*(across*n + sign(springs%friction(k)*across, sliding)*along(springs, k))
          case default
            force = 0
         end select
      end associate
   end function force_of

   !> What a spring of contact tells of the faces there: the force by which they resist being parted, and the change of their opening along
   !> a direction, by that at its neighbours. `is_there` is false for bonds and where faces have parted.
   pure subroutine look_at_faces(springs, k, direction, force, slope, is_there)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      real(dp), intent(out) :: force(ndim)       !! [N]
      real(dp), intent(out) :: slope(ndim)       !! [-]
      logical, intent(out) :: is_there
      integer :: before, after
      real(dp) :: way
      force = 0
      slope = 0
      is_there = springs%kind(k) == closed
      if (is_there) is_there = state_of(springs, k) /= is_open
      if (.not. is_there) return
      force = force_of(springs, k)
      before = max(k - 1, 1)
      if (springs%kind(before) /= closed .or. norm2(springs%normal(:, before) - springs%normal(:, k)) > 1e-6_dp) before = k
      after = min(k + 1, springs%n)
      if (norm2(springs%normal(:, after) - springs%normal(:, k)) > 1e-6_dp) after = k
      way = dot_product(springs%place(:, after) - springs%place(:, before), direction)
      if (abs(way) > 0) slope = (springs%opening(:, after) - springs%opening(:, before))/way
   end subroutine look_at_faces

   !> Whether faces are pressed together along most of the part of a line within some distance of a place: a tip there is closed.
   pure logical function is_closed_at(springs, x, reach)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: reach              !! [m]
      integer :: k, there, pressed
      there = 0
      pressed = 0
      do k = 1, springs%n
         if (springs%kind(k) /= closed .or. norm2(springs%place(:, k) - x) > reach) cycle
         there = there + 1
         if (state_of(springs, k) /= is_open) pressed = pressed + 1
      end do
      is_closed_at = 2*pressed > there
   end function is_closed_at

   !> Change of that force with the opening, without what friction changes with the pressure, which is not symmetric [N/m].
   pure function spring_stiffness(springs, k) result(tangent)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp) :: tangent(ndim, ndim)
      integer :: i, j
      associate (n => springs%normal(:, k), t => along(springs, k), s => springs%stiffness(k))
         tangent = 0
         do j = 1, ndim
            do i = 1, ndim
               if (state_of(springs, k) /= is_open) tangent(i, j) = s*n(i)*n(j)
               if (state_of(springs, k) == sticks) tangent(i, j) = tangent(i, j) + s*t(i)*t(j)
            end do
         end do
      end associate
   end function spring_stiffness

   !> Add the forces of the springs on the nodes [N].
   pure subroutine add_spring_forces(springs, force)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(inout) :: force(:, :)     !! (ndim, n_points)
      real(dp) :: f(ndim)
      integer :: k, j
      do k = 1, springs%n
         f = force_of(springs, k)
         do j = 1, size(springs%node, 1)
            associate (node => springs%node(j, k))
               if (node > 0) force(:, node) = force(:, node) - springs%share(j, k)*f
            end associate
         end do
      end do
   end subroutine add_spring_forces

   !> Let the openings follow a displacement of the nodes, `scale` times a field.
   pure subroutine stretch_springs(springs, field, scale)
      type(face_springs_t), intent(inout) :: springs
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp), intent(in) :: scale
      integer :: k, j
      do k = 1, springs%n
         do j = 1, size(springs%node, 1)
            associate (node => springs%node(j, k))
               if (node > 0) springs%opening(:, k) = springs%opening(:, k) + scale*springs%share(j, k)*field(:, node)
            end associate
         end do
      end do
   end subroutine stretch_springs

   !> Whether there is friction.
   pure logical function have_friction(springs)
      type(face_springs_t), intent(in) :: springs
      have_friction = springs%n_contact > 0
      if (have_friction) have_friction = any(springs%friction(:springs%n) > 0)
   end function have_friction

   !> Let all be as before any load.
   pure subroutine relax_springs(springs)
      type(face_springs_t), intent(inout) :: springs
      if (springs%n == 0) return
      springs%opening = 0
      springs%slip = 0
      springs%pressed = 0
      springs%loss = 0
   end subroutine relax_springs

   !> After a step: what has slid stays so, under the mean of the friction at both ends of the step, and open faces hold each other
   !> where they will meet.
   pure subroutine settle_slip(springs)
      type(face_springs_t), intent(inout) :: springs
      real(dp) :: sliding, pressed
      integer :: k
      if (springs%n_contact == 0) return
      do k = 1, springs%n
         if (springs%kind(k) == bond) cycle
         associate (g => springs%opening(:, k), t => along(springs, k))
            pressed = max(0.0_dp, -dot_product(springs%normal(:, k), g))
            select case (state_of(springs, k))
             case (is_open)
               springs%slip(k) = dot_product(t, g)
             case (slides)
               sliding = dot_product(t, g) - springs%slip(k)
               sliding = sliding - sign(springs%friction(k)*pressed, sliding)
               springs%loss = springs%loss + springs%stiffness(k)*springs%friction(k)*(springs%pressed(k) + pressed)/2*abs(sliding)
               springs%slip(k) = springs%slip(k) + sliding
            end select
            springs%pressed(k) = pressed
         end associate
      end do
   end subroutine settle_slip

   !> Energy that the springs store [J].
   pure real(dp) function spring_energy(springs) result(energy)
      type(face_springs_t), intent(in) :: springs
      real(dp) :: f(ndim)
      integer :: k
      energy = 0
      do k = 1, springs%n
         f = force_of(springs, k)
         energy = energy + sum(f**2)/(2*springs%stiffness(k))
      end do
   end function spring_energy

   !> Keep what springs remember.
   subroutine keep_springs(springs, archive)
      type(face_springs_t), intent(inout) :: springs
      class(archive_t), intent(inout) :: archive
      if (springs%n == 0) return
      call archive%section('face_springs')
      call archive%keep('loss', springs%loss)
      call archive%keep_reals('opening', ndim*springs%n, springs%opening)
      call archive%keep_reals('slip', springs%n, springs%slip)
      call archive%keep_reals('pressed', springs%n, springs%pressed)
   end subroutine keep_springs
end module hampm_face_springs
