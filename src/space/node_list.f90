!> Lists of nodes of a grid. Hanging nodes, which have no degrees of freedom of their own (`hampm_dofs`), stand after all others, as
!> they are often treated apart.
module hampm_node_list
   use hampm_kinds, only: dp
   implicit none
   private
   public :: node_list_t, list_marked, lists_by_interval, clear_hanging

   !> Some nodes: those with degrees of freedom, and after these hanging nodes.
   type :: node_list_t
      integer :: n_nodes = 0                     !! number of nodes with degrees of freedom
      integer :: n_points = 0                    !! number of all, hanging nodes included
      integer, allocatable :: nodes(:)           !! the nodes, (n_points or more)
   end type node_list_t

contains

   !> List the nodes that are marked, ascending. Room that the list has is kept.
   pure subroutine list_marked(n_nodes, marked, list)
      integer, intent(in) :: n_nodes             !! number of the last node with degrees of freedom
      logical, intent(in) :: marked(:)           !! by node, hanging nodes included
      class(node_list_t), intent(inout) :: list
      integer :: node, n
      n = count(marked)
      if (allocated(list%nodes)) then
         if (size(list%nodes) < n) deallocate (list%nodes)
      end if
      if (.not. allocated(list%nodes)) allocate (list%nodes(n))
      n = 0
      list%n_nodes = 0
      do node = 1, size(marked)
         if (.not. marked(node)) cycle
         n = n + 1
         list%nodes(n) = node
         if (node <= n_nodes) list%n_nodes = n
      end do
      list%n_points = n
   end subroutine list_marked

   !> The nodes of a list whose interval is not above r, by interval, for each r.
   pure subroutine lists_by_interval(list, interval, largest, lists)
      class(node_list_t), intent(in) :: list
      integer, intent(in) :: interval(:)             !! 0 or more, by node
      integer, intent(in) :: largest             !! of the intervals
      type(node_list_t), allocatable, intent(out) :: lists(:)  !! (0:largest)
      integer, allocatable :: nodes(:), hanging(:)
      integer :: nodes_until(0:largest), hanging_until(0:largest), r
      call order_by_interval(list%nodes(:list%n_nodes), interval, nodes, nodes_until)
      call order_by_interval(list%nodes(list%n_nodes + 1:list%n_points), interval, hanging, hanging_until)
      allocate (lists(0:largest))
      do r = 0, largest
         lists(r)%n_nodes = nodes_until(r)
         lists(r)%n_points = nodes_until(r) + hanging_until(r)
         lists(r)%nodes = [nodes(:nodes_until(r)), hanging(:hanging_until(r))]
      end do
   end subroutine lists_by_interval

   !> Order nodes by a interval, and count those up to each.
   pure subroutine order_by_interval(nodes, interval, ordered, until)
      integer, intent(in) :: nodes(:)
      integer, intent(in) :: interval(:)             !! by node
      integer, allocatable, intent(out) :: ordered(:)  !! the nodes
      integer, intent(out) :: until(0:)          !! by interval
      integer :: k, r, largest
      allocate (ordered(size(nodes)))
      largest = ubound(until, 1)
      until = 0
      do k = 1, size(nodes)
         until(interval(nodes(k))) = until(interval(nodes(k))) + 1
      end do
      do r = 1, largest
         until(r) = until(r) + until(r - 1)
      end do
      do k = size(nodes), 1, -1
         associate (place => until(interval(nodes(k))))
            ordered(place) = nodes(k)
            place = place - 1
         end associate
      end do
      until(:largest - 1) = until(1:)
      until(largest) = size(nodes)
   end subroutine order_by_interval

   !> Set a field to zero at the hanging nodes of a list.
   pure subroutine clear_hanging(list, width, field)
      class(node_list_t), intent(in) :: list
      integer, intent(in) :: width               !! components
      real(dp), intent(inout) :: field(width, *) !! by node
      integer :: k
      do k = list%n_nodes + 1, list%n_points
         field(:, list%nodes(k)) = 0
      end do
   end subroutine clear_hanging
end module hampm_node_list
