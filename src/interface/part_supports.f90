!> Supports that end between two nodes. Nodes in the box are fixed; springs, one for each component, hold the next node to the last.
!> With S the stiffness of the material against a displacement of that node alone, a spring
!>
!>    k = S w/(1 - w)
!>
!> leaves the part 1 - w of its displacement: displacements, reactions, energies and K are means of their values for supports that
!> end at either node, with the weight w, the part of the distance between these up to the end of the box. They are smooth functions
!> of the end of a support, with an error of second order in the cell. Springs move with their supports and contribute to reactions.
!>
!> S is taken at the first free node beside a support on the edge of a half plane, in E' times the thickness, for half of its cells:
!> for Poisson's ratios from 0 to 0.4 it is within 0.05 and 0.13 of these numbers, and w off by less than 0.05. Elsewhere it scales
!> with the material of the cells around the node.
module hampm_part_supports
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constraints_t
   use hampm_interface_points, only: interfaces_t, support, add_interface_point
   use hampm_matter, only: matter_t
   use hampm_patch, only: patch_t, patch_around, fitted_displacement
   use hampm_tensors, only: identity
   implicit none
   private
   public :: hold_ends_of_supports

   real(dp), parameter :: onward = 0.6_dp        !! S/E' along the edge, over the end of the support
   real(dp), parameter :: across = 0.42_dp       !! across the edge
   real(dp), parameter :: aside = 0.3_dp         !! along the end of the support, in solids and where a box has a width
   real(dp), parameter :: beyond = 0.25_dp       !! of the distance of nodes, by energies of plates whose support ends there
   real(dp), parameter :: least = 1e-3_dp        !! of the distance of nodes: a box that ends nearer beyond a node ends there,
                                                 !! nearer before one is so far from it

contains

   !> Add the springs of all supports.
   pure subroutine hold_ends_of_supports(interfaces, m, c)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(constraints_t), intent(in) :: c
      integer, allocatable :: nodes(:)
      integer :: k, i, e, j, d
      real(dp) :: way(ndim), from, to, part
      do k = 1, c%number()
         associate (box => c%boxes(k))
            if (box%motion%unilateral .or. box%motion%turns .or. .not. ends_between_nodes(box%reach)) cycle
            do i = 1, size(c%node)
               if (.not. any(c%box(:, c%node(i)) == k)) cycle
               nodes = neighbours_of(m, c%node(i))
               do j = 1, size(nodes)
                  way = m%grid%node_position(:, nodes(j)) - m%grid%node_position(:, c%node(i))
                  d = maxloc(abs(way), dim=1)
                  e = merge(1, 2, way(d) < 0)
                  from = end_of_held(c%node(i), d, way(d))
                  to = end_of_held(nodes(j), d, way(d))
                  part = (box%reach(d, e) - from)/(to - from)
                  if (part < least .or. part > 1) cycle
                  call add_springs(interfaces, m, c, k, c%node(i), nodes(j), d, min(part, 1 - least))
               end do
            end do
         end associate
      end do

   contains

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

      !> Whether a box ends between lines of the coarsest cells, which have nodes wherever they refine.
      pure logical function ends_between_nodes(corners) result(ends)
         real(dp), intent(in) :: corners(ndim, 2) !! [m]
         real(dp) :: at(ndim, 2)                 ! [their nodes]
         at = (corners - spread(m%grid%forest%lower, 2, 2))/m%grid%forest%cell*merge(2, 1, m%grid%is_quadratic())
         associate (tolerance => m%grid%forest%tolerance())
            ends = any(abs(at - anint(at)) > tolerance/m%grid%forest%cell .and. &
                       spread(corners(:, 2) - corners(:, 1) > tolerance, 2, 2))
         end associate
      end function ends_between_nodes
   end subroutine hold_ends_of_supports

   !> The nodes next to a node along lines between cells with material; no hanging ones.
   pure function neighbours_of(m, node) result(neighbours)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: node
      integer, allocatable :: neighbours(:)
      integer :: nodes(m%grid%n_functions), k, j
      real(dp) :: way(ndim)
      allocate (neighbours(0))
      associate (around => m%grid%dofs%elements_at(node), tolerance => m%grid%forest%tolerance())
         do k = 1, size(around)
            if (m%blocks%count_in(around(k)) == 0) cycle
            nodes = m%grid%support_of(around(k))
            do j = 1, size(nodes)
               if (nodes(j) > m%grid%n_nodes .or. any(neighbours == nodes(j))) cycle
               way = abs(m%grid%node_position(:, nodes(j)) - m%grid%node_position(:, node))
               if (count(way > tolerance) /= 1 .or. abs(maxval(way) - m%grid%element_size(around(k))) > tolerance) cycle
               neighbours = [neighbours, nodes(j)]
            end do
         end do
      end associate
   end function neighbours_of

   !> Hold a node by springs from the last one in a box, in the components that this holds.
   pure subroutine add_springs(interfaces, m, c, k, last, next, direction, part)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      type(constraints_t), intent(in) :: c
      integer, intent(in) :: k                   !! the box
      integer, intent(in) :: last, next          !! nodes
      integer, intent(in) :: direction           !! from the last to the next
      real(dp), intent(in) :: part               !! of the way between them to where the box ends [-]
      real(dp) :: stiffness, of_component, opening(ndim)
      integer :: d
      stiffness = 0
      associate (box => c%boxes(k), x => m%grid%node_position(:, next))
         do d = 1, ndim
            if (c%box(d, last) /= k .or. c%box(d, next) > 0) cycle
            if (stiffness <= 0) then
               stiffness = part/(1 - part)*stiffness_around(m, next)
               opening = displacement_of(next) - displacement_of(last)
            end if
            of_component = across
            if (box%upper(d) - box%lower(d) > m%grid%forest%tolerance()) of_component = aside
            if (d == direction) of_component = onward
            call add_interface_point(interfaces, support)
            associate (point => interfaces%list(interfaces%n))
               point%jump%node(:2) = [next, last]
               point%jump%share(:2) = [1, -1]
               point%n_left = 1
               point%normal = identity(:, d)
               point%stiffness = of_component*stiffness
               point%opening = opening
               point%place = x
               point%middle = x
               point%origin = x
               point%cell = m%grid%smallest_leaf_at(next)
               point%length = part*point%cell
            end associate
         end do
      end associate

   contains

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
   pure real(dp) function stiffness_around(m, node) result(stiffness)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: node
      integer :: e, i
      stiffness = 0
      associate (around => m%grid%dofs%elements_at(node))
         do e = 1, size(around)
            do i = m%blocks%first_in(around(e)), m%blocks%last_in(around(e)), m%blocks%stride_in(around(e))
               stiffness = stiffness + m%materials(m%particles%material(i))%plane_modulus()* &
                           m%particles%volume(i)/(2**(ndim - 1)*m%grid%element_size(around(e))**2)
            end do
         end do
      end associate
   end function stiffness_around
end module hampm_part_supports
