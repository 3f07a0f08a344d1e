!> Lists of nodes of a grid. Hanging nodes, which have no degrees of freedom of their own (`hampm_dofs`), stand after all others, as
!> they are often treated apart.
module hampm_node_list
   implicit none
   private
   public :: node_list_t, list_marked

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
end module hampm_node_list
