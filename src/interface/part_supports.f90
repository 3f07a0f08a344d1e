!> Supports that end between two nodes. Nodes in the box are fixed; springs, one for each component, hold the next node to the last.
!> With S the stiffness of the material against a displacement of that node alone, a spring
!>
!>    k = S w/(1 - w)
!>
!> leaves the part 1 - w of its displacement: displacements, reactions, energies and K are means of their values for supports that
!> end at either node, with the weight w, the part of the distance up to the end of the box. A corner of the box in a cell holds the
!> node across it with w = w_1 w_2, its part of the cell. Results are smooth functions of the end of a support, with an error of
!> second order in the cell. Springs move with their supports and contribute to reactions.
!>
!> S is that of the first free node beside a support on the edge of a half plane, in E' times thickness and half of its cells: for
!> Poisson's ratios from 0 to 0.4 within 0.05 and 0.13, w off by less than 0.05. Elsewhere it scales with the material around.
module hampm_part_supports
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constraints_t, box_t
   use hampm_forest, only: forest_t
   use hampm_interface_points, only: interfaces_t, interface_point_t, support, add_interface_point
   use hampm_matter, only: matter_t
   use hampm_patch, only: patch_t, patch_around, fitted_displacement
   use hampm_tensors, only: identity, norm
   implicit none
   private
   public :: hold_ends_of_supports, keep_cells_at_ends

   real(dp), parameter :: onward = 0.6_dp        !! S/E' along the edge, over the end of the support
   real(dp), parameter :: across = 0.42_dp       !! across the edge
   real(dp), parameter :: aside = 0.3_dp         !! along the end of the support, in solids and where a box has a width
   real(dp), parameter :: beyond = 0.25_dp       !! of the distance of nodes, by energies of plates whose support ends there
   real(dp), parameter :: least = 1e-3_dp        !! of the distance of nodes: a box that ends nearer beyond a node ends there,
                                                 !! nearer before one is so far from it

contains

   !> Add the springs of all supports: the old ones, once anything has stretched them in motion, then new ones where there are none.
   pure subroutine hold_ends_of_supports(interfaces, m, c, old)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(constraints_t), intent(in) :: c
      type(interfaces_t), intent(in) :: old      !! those on the mesh before
      integer, allocatable :: nodes(:)
      integer :: k, i, j, d, kept
      real(dp) :: way(ndim), parts(ndim)         ! of the way along each axis up to the end of the box
      if (interfaces%are_moving) call keep_springs(interfaces, m, c, old)
      kept = interfaces%n
      do k = 1, c%number()
         associate (box => c%boxes(k))
            if (.not. has_springs(box, m%grid%forest, m%grid%is_quadratic())) cycle
            do i = 1, size(c%node)
               if (.not. any(c%box(:, c%node(i)) == k)) cycle
               nodes = neighbours_of(m, c%node(i))
               do j = 1, size(nodes)
                  way = m%grid%node_position(:, nodes(j)) - m%grid%node_position(:, c%node(i))
                  parts = [(part_of_way(box, c%node(i), nodes(j), d, way(d)), d=1, ndim)]
                  if (any(abs(way) > m%grid%forest%tolerance() .and. (parts < least .or. parts > 1))) cycle
                  where (abs(way) > m%grid%forest%tolerance()) parts = min(parts, 1 - least)
                  call add_springs(interfaces, kept, m, c, k, c%node(i), nodes(j), parts)
               end do
            end do
         end associate
      end do

   contains

      !> Part of the way from a node to another one up to the end of a box in one direction; 1 where that leads nowhere.
      pure real(dp) function part_of_way(box, last, next, d, way) result(part)
         type(box_t), intent(in) :: box
         integer, intent(in) :: last, next, d    !! nodes, and the direction
         real(dp), intent(in) :: way             !! along that [m]
         real(dp) :: from
         part = 1
         if (abs(way) <= m%grid%forest%tolerance()) return
         from = end_of_held(last, d, way)
         part = (box%reach(d, merge(1, 2, way < 0)) - from)/(end_of_held(next, d, way) - from)
      end function part_of_way

      !> Place up to which a node and those behind it hold an edge [m]: the node, or `beyond` further at a middle of quadratic
      !> sides.
      pure real(dp) function end_of_held(node, d, way) result(at)
         integer, intent(in) :: node, d          !! and the direction of the edge
         real(dp), intent(in) :: way             !! along that to or from the next node [m]
         real(dp) :: halves
         at = m%grid%node_position(d, node)
         if (.not. m%grid%is_quadratic()) return
         halves = (at - m%grid%forest%lower(d))/way
         if (modulo(nint(halves), 2) == 1) at = at + beyond*way
      end function end_of_held
   end subroutine hold_ends_of_supports

   !> Whether the ends of a box have springs: where they are between lines of the coarsest cells, which have nodes wherever they
   !> refine.
   pure logical function has_springs(box, forest, is_quadratic) result(ends)
      type(box_t), intent(in) :: box
      type(forest_t), intent(in) :: forest
      logical, intent(in) :: is_quadratic
      real(dp) :: at(ndim, 2)                    ! [their nodes]
      ends = .not. (box%motion%unilateral .or. box%motion%turns)
      if (.not. ends) return
      at = (box%reach - spread(forest%lower, 2, 2))/forest%cell*merge(2, 1, is_quadratic)
      ends = any(abs(at - anint(at)) > forest%tolerance()/forest%cell .and. &
                 spread(box%reach(:, 2) - box%reach(:, 1) > forest%tolerance(), 2, 2))
   end function has_springs

   !> In motion keep springs that anything has stretched, between the nodes that are at their places now, with stiffness and state:
   !> others would hold another force, and energy that nothing has given. Of nodes at one place, as on both sides of a crack or of
   !> bodies that meet, it is that with the material on the side of the spring's. At rest, where springs follow the displacement
   !> since the start, each mesh has its own.
   pure subroutine keep_springs(interfaces, m, c, old)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(constraints_t), intent(in) :: c
      type(interfaces_t), intent(in) :: old
      integer, allocatable :: nodes(:)
      integer :: k, j, d, last, next, first
      real(dp) :: stiffness, side(ndim), farthest
      first = interfaces%n + 1
      if (.not. any([(old%list(k)%law == support .and. any(abs(old%list(k)%opening) > 0), k=1, old%n)])) return
      do k = 1, old%n
         associate (spring => old%list(k))
            if (spring%law /= support) cycle
            d = maxloc(abs(spring%normal), dim=1)
            last = findloc([(c%box(d, c%node(j)) > 0 .and. is_at(c%node(j), spring%middle), j=1, size(c%node))], .true., dim=1)
            if (last == 0) cycle
            nodes = pack([(j, j=1, m%grid%n_nodes)], [(is_at(j, spring%origin), j=1, m%grid%n_nodes)])
            farthest = huge(farthest)
            next = 0
            do j = 1, size(nodes)
               if (is_taken(spring, nodes(j))) cycle
               call look_around(m, nodes(j), stiffness, side)
               if (.not. stiffness > 0) cycle    ! no material
               side = side - (spring%place - spring%origin)/spring%cell
               if (norm(side) >= farthest) cycle
               farthest = norm(side)
               next = nodes(j)
            end do
            if (next == 0) cycle
            call add_interface_point(interfaces, support)
            interfaces%list(interfaces%n) = spring
            interfaces%list(interfaces%n)%jump%node(:2) = [next, c%node(last)]
         end associate
      end do

   contains

      !> Whether a node is held, or has such a spring: between two supports it has one to either.
      pure logical function is_taken(spring, node)
         type(interface_point_t), intent(in) :: spring
         integer, intent(in) :: node
         integer :: i
         is_taken = c%box(d, node) > 0
         do i = first, interfaces%n              ! the springs kept so far
            if (is_taken) return
            associate (other => interfaces%list(i))
               is_taken = abs(other%normal(d)) > 0 .and. other%jump%node(1) == node .and. &
                          all(abs(other%middle - spring%middle) <= m%grid%forest%tolerance())
            end associate
         end do
      end function is_taken

      !> Whether a node is at a place.
      pure logical function is_at(node, x)
         integer, intent(in) :: node
         real(dp), intent(in) :: x(ndim)         !! [m]
         is_at = all(abs(m%grid%node_position(:, node) - x) <= m%grid%forest%tolerance())
      end function is_at
   end subroutine keep_springs

   !> Let no cells recombine in motion to one that has the end of a support with springs between its nodes: the last nodes of the
   !> support, or those that its springs hold, would vanish.
   pure subroutine keep_cells_at_ends(forest, is_quadratic, c, change)
      type(forest_t), intent(in) :: forest
      logical, intent(in) :: is_quadratic
      type(constraints_t), intent(in) :: c
      integer, intent(inout) :: change(:)        !! by leaf: -1 where it may be recombined
      real(dp) :: lower(ndim), size_of, at(ndim, 2)
      integer :: leaf, k, nodes
      nodes = merge(2, 1, is_quadratic)
      do k = 1, c%number()
         associate (box => c%boxes(k), tolerance => forest%tolerance())
            if (.not. has_springs(box, forest, is_quadratic)) cycle
            do leaf = 1, size(change)
               if (change(leaf) >= 0) cycle
               size_of = 2*forest%size_of(leaf)  ! of the cell that it would be in
               lower = forest%lower + floor((forest%middle_of(leaf) - forest%lower)/size_of)*size_of
               if (any(box%reach(:, 1) > lower + size_of + tolerance .or. box%reach(:, 2) < lower - tolerance)) cycle
               at = (box%reach - spread(lower, 2, 2))/size_of*nodes
               if (any(at > 0 .and. at < nodes .and. abs(at - anint(at)) > tolerance/size_of)) change(leaf) = 0
            end do
         end associate
      end do
   end subroutine keep_cells_at_ends

   !> The nodes next to a node along lines between cells with material, and across these; no hanging ones.
   pure function neighbours_of(m, node) result(neighbours)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: node
      integer, allocatable :: neighbours(:)
      integer :: nodes(m%grid%n_functions), k, e, j
      real(dp) :: way(ndim)
      allocate (neighbours(0))
      associate (around => m%grid%dofs%elements_at(node), tolerance => m%grid%forest%tolerance())
         do k = 1, size(around)
            associate (first => m%grid%first_of_piece(around(k)), last => m%grid%last_of_piece(around(k)))
               if (all([(m%blocks%count_in(e) == 0, e=first, last)])) cycle
               do e = first, last                ! a cell beside finer ones has pieces, whose nodes between its corners hang
                  nodes = m%grid%support_of(e)
                  do j = 1, size(nodes)
                     if (nodes(j) > m%grid%n_nodes .or. any(neighbours == nodes(j))) cycle
                     way = abs(m%grid%node_position(:, nodes(j)) - m%grid%node_position(:, node))
                     if (all(way <= tolerance)) cycle
                     if (any(min(way, abs(way - m%grid%leaf_size(e)/merge(2, 1, m%grid%is_quadratic()))) > tolerance)) cycle
                     neighbours = [neighbours, nodes(j)]
                  end do
               end do
            end associate
         end do
      end associate
   end function neighbours_of

   !> Hold a node by springs from the last one in a box, in the components that this holds.
   pure subroutine add_springs(interfaces, kept, m, c, k, last, next, parts)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: kept                !! number of springs that were there
      type(matter_t), intent(in) :: m
      type(constraints_t), intent(in) :: c
      integer, intent(in) :: k                   !! the box
      integer, intent(in) :: last, next          !! nodes
      real(dp), intent(in) :: parts(ndim)        !! of the way between them to where the box ends, 1 where they are abreast [-]
      real(dp) :: part, share, stiffness, of_component, opening(ndim), side(ndim)
      integer :: d, i
      stiffness = 0
      part = product(parts)
      associate (box => c%boxes(k), x => m%grid%node_position(:, next))
         do d = 1, ndim
            if (c%box(d, last) /= k .or. c%box(d, next) > 0 .or. spring_of(d, kept + 1, interfaces%n) > 0) cycle
            if (count(parts < 1) > 1) then
               if (is_held_between(d)) cycle
            end if
            if (stiffness <= 0) then
               call look_around(m, next, stiffness, side)
               stiffness = part/(1 - part)*stiffness
               opening = displacement_of(next) - displacement_of(last)
            end if
            of_component = across
            if (box%upper(d) - box%lower(d) > m%grid%forest%tolerance()) of_component = aside
            share = (1 - parts(d))/sum(1 - parts) ! so corners go over into ends along either edge
            of_component = share*onward + (1 - share)*of_component
            i = spring_of(d, 1, kept)
            if (i > 0 .and. .not. m%particles%total_frame) then ! as material moves into its cells it grows firmer under its force
               associate (point => interfaces%list(i))
                  if (of_component*stiffness > point%stiffness) then
                     point%opening = point%stiffness/(of_component*stiffness)*point%opening
                     point%stiffness = of_component*stiffness
                  end if
               end associate
            end if
            if (i > 0 .or. any([(is_near(interfaces%list(i)), i=1, kept)])) cycle
            call add_interface_point(interfaces, support)
            associate (point => interfaces%list(interfaces%n))
               point%jump%node(:2) = [next, last]
               point%jump%share(:2) = [1, -1]
               point%n_left = 1
               point%normal = identity(:, d)
               point%stiffness = of_component*stiffness
               point%opening = opening
               point%middle = m%grid%node_position(:, last)
               point%origin = x
               point%cell = m%grid%smallest_leaf_at(next)
               point%place = x + point%cell*side
               point%length = part*point%cell
            end associate
         end do
      end associate

   contains

      !> Number of the spring of this component from the place of the last node to the next one, of some springs; 0: none.
      pure integer function spring_of(d, first, final)
         integer, intent(in) :: d                !! component
         integer, intent(in) :: first, final     !! numbers of the springs
         do spring_of = final, first, -1
            associate (spring => interfaces%list(spring_of))
               if (spring%jump%node(1) == next .and. abs(spring%normal(d)) > 0 .and. &
                   all(abs(spring%middle - m%grid%node_position(:, last)) <= m%grid%forest%tolerance())) return
            end associate
         end do
         spring_of = 0
      end function spring_of

      !> Whether a node beside both is held in this component, from which an edge leads to the next one: a corner is none then.
      pure logical function is_held_between(d) result(is_held)
         integer, intent(in) :: d                !! component
         integer, allocatable :: nodes(:)
         real(dp) :: way(ndim), to(ndim)
         integer :: i
         is_held = .false.
         nodes = neighbours_of(m, next)
         way = m%grid%node_position(:, last) - m%grid%node_position(:, next)
         do i = 1, size(nodes)
            if (c%box(d, nodes(i)) == 0) cycle
            to = m%grid%node_position(:, nodes(i)) - m%grid%node_position(:, next)
            is_held = is_held .or. all(min(abs(to), abs(to - way)) <= m%grid%forest%tolerance()) .and. &
                      sum(abs(to)) < sum(abs(way)) - m%grid%forest%tolerance()
         end do
      end function is_held_between

      !> Whether a spring of this component is nearer to the node than to its own last one.
      pure logical function is_near(spring)
         type(interface_point_t), intent(in) :: spring
         is_near = abs(spring%normal(d)) > 0 .and. maxval(abs(spring%origin - m%grid%node_position(:, next))) < &
                   maxval(abs(spring%origin - spring%middle)) - m%grid%forest%tolerance()
      end function is_near

      !> Displacement of a node, by the particles around it [m].
      pure function displacement_of(node) result(u)
         integer, intent(in) :: node
         real(dp) :: u(ndim)
         type(patch_t) :: patch
         call patch_around(m%grid, m%particles, m%blocks, node, patch)
         u = fitted_displacement(patch, m%particles)
      end function displacement_of
   end subroutine add_springs

   !> E' of the material around a node times the thickness, times the filled part of half of its cells; in solids times size [N/m].
   !> A quarter of a quadratic cell is filled as the cell is: an odd number of particles stand on the lines between quarters. And
   !> the mean way from the node to this material, in sizes of its cells [-].
   pure subroutine look_around(m, node, stiffness, side)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: node
      real(dp), intent(out) :: stiffness, side(ndim)
      real(dp) :: part
      integer :: e, i, k
      stiffness = 0
      side = 0
      associate (around => m%grid%dofs%elements_at(node), b => m%blocks, x => m%grid%node_position(:, node))
         do k = 1, size(around)
            associate (first => m%grid%first_of_piece(around(k)), last => m%grid%last_of_piece(around(k)), &
                       cell => m%grid%element_size(around(k)))
               do e = first, last
                  do i = b%first_in(e), b%last_in(e), b%stride_in(e)
                     part = m%materials(m%particles%material(i))%plane_modulus()*m%particles%volume(i) &
                            /(2**(ndim - 1)*cell**2*(last - first + 1))
                     stiffness = stiffness + part
                     side = side + part*(m%particles%place_in_grid(i) - x)/cell
                  end do
               end do
            end associate
         end do
      end associate
      if (stiffness > 0) side = side/stiffness
   end subroutine look_around
end module hampm_part_supports
