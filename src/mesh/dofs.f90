!> Degrees of freedom of the nodes of a grid, and hanging nodes without them, whose values are weighted means of some nodes, their
!> masters. The hanging nodes of a transition element are the middle of a side beside which there is no finer cell, and the middle
!> of the element. Of a quadratic cell the middle of a side beside a coarser cell hangs.
!>
!> Nodes with degrees of freedom are numbered first, hanging nodes after them. With T the weights, values are x = T x_nodes; sums at
!> hanging nodes belong to their masters by T transposed. The weights of a hanging node add up to 1, all positive except those of
!> quadratic cells (`hampm_grid`): lumped masses are positive, velocities stay in the range of the particles', and by convexity (T
!> x)**2 <= T x**2 a time step that is stable for all small elements is stable for the transition element.
!>
!> A slot is a corner of an element as one number; the slots of each node are stored in compressed rows, in the order of the
!> elements, in which all sums at nodes are taken.
module hampm_dofs
   use hampm_kinds, only: dp, ndim, corners
   use hampm_node_list, only: node_list_t
   implicit none
   private
   public :: dofs_t, list_slots, element_of_slot, corner_of_slot, most_nodes_of_leaf

   !> A leaf has four corners, up to four nodes in the middle of its sides and, if quadratic, one in its own middle. Where a node in
   !> the middle of a side of such a leaf hangs, one of its three masters is no node of the leaf and replaces it: no element depends
   !> on more.
   integer, parameter :: most_nodes_of_leaf = 3**ndim

   !> The nodes with degrees of freedom, the masters of the hanging nodes, and the elements around all nodes.
   type :: dofs_t
      integer :: n_nodes = 0                     !! number of nodes with degrees of freedom
      integer :: n_hanging = 0                   !! number of hanging nodes, which are numbered on from these
      integer, allocatable :: first_master(:)    !! first entry of each hanging node in the next two, (n_hanging + 1)
      integer, allocatable :: master(:)          !! its masters
      real(dp), allocatable :: weight(:)         !! their weights [-]
      integer, allocatable :: first_slot(:)      !! first entry of each node, hanging nodes included, in the next, (n_points + 1)
      integer, allocatable :: slot(:)            !! corner + corners (element - 1), ascending at each node, (corners n_elements)
   contains
      procedure :: set_masters
      procedure :: connect
      procedure :: elements_at
      procedure :: corners_at
      procedure :: masters_of
      procedure :: a_master_of
      procedure :: every_node
      procedure :: distribute
      procedure :: condense
      procedure :: mark_masters
      procedure :: mark_hanging
   end type dofs_t

contains

   !> Take the masters of all hanging nodes.
   pure subroutine set_masters(self, n_nodes, count_of, master, weight)
      class(dofs_t), intent(inout) :: self
      integer, intent(in) :: n_nodes             !! number of nodes with degrees of freedom
      integer, intent(in) :: count_of(:)         !! number of masters of each hanging node
      integer, intent(in) :: master(:, :)        !! masters, by hanging node
      real(dp), intent(in) :: weight(:, :)       !! their weights [-]
      integer :: k
      self%n_nodes = n_nodes
      self%n_hanging = size(count_of)
      if (allocated(self%first_master)) deallocate (self%first_master)
      allocate (self%first_master(self%n_hanging + 1))
      self%first_master(1) = 1
      do k = 1, self%n_hanging
         self%first_master(k + 1) = self%first_master(k) + count_of(k)
      end do
      self%master = [(master(:count_of(k), k), k=1, self%n_hanging)]
      self%weight = [(weight(:count_of(k), k), k=1, self%n_hanging)]
   end subroutine set_masters

   !> Find the slots at which the nodes stand. `status` is not zero where the memory does not suffice.
   subroutine connect(self, element_nodes, status)
      class(dofs_t), intent(inout) :: self
      integer, intent(in) :: element_nodes(:, :) !! node at each corner, (corners, n_elements)
      integer, intent(out) :: status
      if (allocated(self%slot)) deallocate (self%first_slot, self%slot)
      call list_slots(self%n_nodes + self%n_hanging, element_nodes, self%first_slot, self%slot, status)
   end subroutine connect

   !> The slots at which each of `n` nodes stands, in compressed rows, from the nodes of each cell. `status` is not zero where the
   !> memory does not suffice.
   pure subroutine list_slots(n, nodes, first, slot, status)
      integer, intent(in) :: n
      integer, intent(in) :: nodes(:, :)                !! (nodes of a cell, cells)
      integer, allocatable, intent(out) :: first(:)     !! first entry of each node in the next, (n + 1)
      integer, allocatable, intent(out) :: slot(:)      !! place in `nodes` as one number, ascending at each node, (size(nodes))
      integer, intent(out) :: status
      integer :: e, c, node
      allocate (first(n + 1), slot(size(nodes)), stat=status)
      if (status /= 0) return
      first = 0
      do e = 1, size(nodes, 2)
         do c = 1, size(nodes, 1)
            first(nodes(c, e)) = first(nodes(c, e)) + 1
         end do
      end do
      do node = 2, n + 1                         ! the last entry of each node
         first(node) = first(node - 1) + first(node)
      end do
      do e = size(nodes, 2), 1, -1
         do c = size(nodes, 1), 1, -1
            slot(first(nodes(c, e))) = c + size(nodes, 1)*(e - 1)
            first(nodes(c, e)) = first(nodes(c, e)) - 1
         end do
      end do
      first = first + 1
   end subroutine list_slots

   !> The elements around a node, ascending.
   pure function elements_at(self, node) result(elements)
      class(dofs_t), intent(in) :: self
      integer, intent(in) :: node
      integer :: elements(self%first_slot(node + 1) - self%first_slot(node))
      elements = element_of_slot(self%slot(self%first_slot(node):self%first_slot(node + 1) - 1))
   end function elements_at

   !> At which corner of each of these the node stands.
   pure function corners_at(self, node) result(corner)
      class(dofs_t), intent(in) :: self
      integer, intent(in) :: node
      integer :: corner(self%first_slot(node + 1) - self%first_slot(node))
      corner = corner_of_slot(self%slot(self%first_slot(node):self%first_slot(node + 1) - 1))
   end function corners_at

   !> The nodes with degrees of freedom on which values at some nodes depend, as at those of an element, and their weights:
   !>
   !>    value at nodes(c) = sum over k of weight(c, k) * value at master(k).
   !>
   !> A node that does not hang is its own master.
   pure subroutine masters_of(self, nodes, n, master, weight)
      class(dofs_t), intent(in) :: self
      integer, intent(in) :: nodes(:)
      integer, intent(out) :: n                         !! number of masters
      integer, intent(out) :: master(most_nodes_of_leaf)
      real(dp), intent(out) :: weight(size(nodes), most_nodes_of_leaf) !! [-]
      integer :: c, j, k
      n = 0
      weight = 0
      do c = 1, size(nodes)
         if (nodes(c) <= self%n_nodes) then
            call enter(nodes(c), n, master, k)
            weight(c, k) = weight(c, k) + 1
         else
            do j = self%first_master(nodes(c) - self%n_nodes), self%first_master(nodes(c) - self%n_nodes + 1) - 1
               call enter(self%master(j), n, master, k)
               weight(c, k) = weight(c, k) + self%weight(j)
            end do
         end if
      end do
   end subroutine masters_of

   !> A node with degrees of freedom at a point: itself or, of a hanging node, the first of its masters; 0 where it has none.
   pure integer function a_master_of(self, point) result(master)
      class(dofs_t), intent(in) :: self
      integer, intent(in) :: point
      master = point
      if (point <= self%n_nodes) return
      associate (k => point - self%n_nodes)
         master = 0
         if (self%first_master(k + 1) > self%first_master(k)) master = self%master(self%first_master(k))
      end associate
   end function a_master_of

   !> The place of a node in a list; a new node gets the next one.
   pure subroutine enter(node, n, list, place)
      integer, intent(in) :: node
      integer, intent(inout) :: n                       !! number of nodes in the list
      integer, intent(inout) :: list(:)
      integer, intent(out) :: place
      do place = 1, n
         if (list(place) == node) return
      end do
      n = place
      list(n) = node
   end subroutine enter

   !> Element of a slot.
   elemental integer function element_of_slot(slot) result(e)
      integer, intent(in) :: slot
      e = (slot + corners - 1)/corners
   end function element_of_slot

   !> Corner of a slot.
   elemental integer function corner_of_slot(slot) result(corner)
      integer, intent(in) :: slot
      corner = mod(slot - 1, corners) + 1
   end function corner_of_slot

   !> The list of all nodes.
   pure function every_node(self) result(list)
      class(dofs_t), intent(in) :: self
      type(node_list_t) :: list
      integer :: node
      list%n_nodes = self%n_nodes
      list%n_points = self%n_nodes + self%n_hanging
      allocate (list%nodes, source=[(node, node=1, list%n_points)])
   end function every_node

   !> Distribute values to the hanging nodes of a list: x = T x_nodes.
   pure subroutine distribute(self, list, width, x)
      class(dofs_t), intent(in) :: self
      class(node_list_t), intent(in) :: list
      integer, intent(in) :: width               !! components
      real(dp), intent(inout) :: x(width, *)     !! by node, hanging nodes included
      real(dp) :: total(width)
      integer :: k, j
      do k = list%n_nodes + 1, list%n_points
         associate (hanging => list%nodes(k))
            total = 0
            do j = self%first_master(hanging - self%n_nodes), self%first_master(hanging - self%n_nodes + 1) - 1
               total = total + self%weight(j)*x(:, self%master(j))
            end do
            x(:, hanging) = total
         end associate
      end do
   end subroutine distribute

   !> Condense sums at the hanging nodes of a list to their masters, by T transposed; they are zero afterwards. With a `scale`,
   !> masters get the sums times their own.
   pure subroutine condense(self, list, width, x, scale)
      class(dofs_t), intent(in) :: self
      class(node_list_t), intent(in) :: list
      integer, intent(in) :: width               !! components
      real(dp), intent(inout) :: x(width, *)     !! by node, hanging nodes included
      real(dp), intent(in), optional :: scale(width, *)  !! by node
      real(dp) :: part(width)
      integer :: k, j
      do k = list%n_nodes + 1, list%n_points
         associate (hanging => list%nodes(k))
            do j = self%first_master(hanging - self%n_nodes), self%first_master(hanging - self%n_nodes + 1) - 1
               part = self%weight(j)*x(:, hanging)
               if (present(scale)) part = scale(:, self%master(j))*part
               x(:, self%master(j)) = x(:, self%master(j)) + part
            end do
            x(:, hanging) = 0
         end associate
      end do
   end subroutine condense

   !> Mark the masters of the hanging nodes that are marked.
   pure subroutine mark_masters(self, marked)
      class(dofs_t), intent(in) :: self
      logical, intent(inout) :: marked(:)        !! by node, hanging nodes included
      integer :: k
      do k = 1, self%n_hanging
         if (marked(self%n_nodes + k)) marked(self%master(self%first_master(k):self%first_master(k + 1) - 1)) = .true.
      end do
   end subroutine mark_masters

   !> Mark the hanging nodes that have a marked master.
   pure subroutine mark_hanging(self, marked)
      class(dofs_t), intent(in) :: self
      logical, intent(inout) :: marked(:)        !! by node, hanging nodes included
      integer :: k
      do k = 1, self%n_hanging
         if (any(marked(self%master(self%first_master(k):self%first_master(k + 1) - 1)))) marked(self%n_nodes + k) = .true.
      end do
   end subroutine mark_hanging
end module hampm_dofs
