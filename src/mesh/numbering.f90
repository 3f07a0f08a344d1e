!> Numbering of unknowns: the degrees of freedom of some nodes without those fixed by a Dirichlet constraint: one direction at a
!> time for a mass matrix, all directions together for a stiffness. Several may share an unknown, each a weight times it, as where
!> nodes turn together: with T the weights, the matrix is T transposed A T.
module hampm_numbering
   use hampm_kinds, only: dp
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_grid, only: grid_t
   implicit none
   private
   public :: numbering_t, number_unknowns, nodes_of_elements

   !> Unknowns by node and direction, and back.
   type :: numbering_t
      integer :: n = 0                           !! number of unknowns
      integer, allocatable :: dof(:, :)          !! unknown of each direction of each node, 0 where there is none;
                                                 !! (directions, n_nodes)
      integer, allocatable :: node(:)            !! nodes of the unknowns, (n) if none is shared
      integer, allocatable :: direction(:)       !! their directions
      real(dp), allocatable :: weight(:, :)      !! of each direction of each node [-]; not allocated where all are 1
   contains
      procedure :: gather
      procedure :: scatter
   end type numbering_t

contains

   !> Number the unknowns of some nodes: in the order of these, the directions of a node one after the other.
   pure subroutine number_unknowns(nodes, fixed, numbering, group, weight)
      integer, intent(in) :: nodes(:)            !! with degrees of freedom
      logical, intent(in) :: fixed(:, :)         !! which are no unknowns, (directions, n_nodes)
      type(numbering_t), intent(out) :: numbering
      integer, allocatable, intent(in), optional :: group(:, :) !! shared unknown of each, 0 for none, (directions, n_nodes)
      real(dp), allocatable, intent(in), optional :: weight(:, :) !! of these [-]
      integer, allocatable :: of_group(:)
      integer :: k, d, last, n_groups
      n_groups = 0
      last = count(.not. fixed(:, nodes))
      allocate (numbering%dof(size(fixed, 1), size(fixed, 2)), source=0)
      allocate (numbering%node(last), numbering%direction(last))
      if (present(group)) then
         if (allocated(group)) then
            allocate (numbering%weight, source=merge(weight, 1.0_dp, group > 0))
            n_groups = maxval(group)
         end if
      end if
      allocate (of_group(n_groups), source=0)
      numbering%n = 0
      last = 0
      do k = 1, size(nodes)
         do d = 1, size(fixed, 1)
            associate (dof => numbering%dof(d, nodes(k)))
               if (fixed(d, nodes(k))) cycle
               last = last + 1
               numbering%node(last) = nodes(k)
               numbering%direction(last) = d
               if (n_groups > 0) then
                  if (group(d, nodes(k)) > 0) dof = of_group(group(d, nodes(k)))
               end if
               if (dof > 0) cycle
               numbering%n = numbering%n + 1
               dof = numbering%n
               if (n_groups > 0) then
                  if (group(d, nodes(k)) > 0) of_group(group(d, nodes(k))) = dof
               end if
            end associate
         end do
      end do
   end subroutine number_unknowns

   !> Field of the nodes at the unknowns, shared ones weighted.
   pure function gather(self, field) result(x)
      class(numbering_t), intent(in) :: self
      real(dp), intent(in) :: field(:, :)        !! (directions, n_points)
      real(dp) :: x(self%n)
      integer :: i
      if (allocated(self%weight)) then
         x = 0
         do i = 1, size(self%node)
            associate (d => self%direction(i), node => self%node(i))
               x(self%dof(d, node)) = x(self%dof(d, node)) + self%weight(d, node)*field(d, node)
            end associate
         end do
         return
      end if
      do i = 1, self%n
         x(i) = field(self%direction(i), self%node(i))
      end do
   end function gather

   !> Set a field of the nodes to the unknowns; it stays elsewhere.
   pure subroutine scatter(self, x, field)
      class(numbering_t), intent(in) :: self
      real(dp), intent(in) :: x(:)
      real(dp), intent(inout) :: field(:, :)     !! (directions, n_points)
      integer :: i
      do i = 1, size(self%node)
         associate (d => self%direction(i), node => self%node(i))
            field(d, node) = x(self%dof(d, node))
            if (allocated(self%weight)) field(d, node) = self%weight(d, node)*field(d, node)
         end associate
      end do
   end subroutine scatter

   !> The nodes with degrees of freedom on which values in some elements depend, in the order of first occurrence.
   pure subroutine nodes_of_elements(grid, elements, nodes)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: elements(:)
      integer, allocatable, intent(out) :: nodes(:)
      logical, allocatable :: met(:)
      integer, allocatable :: list(:)
      real(dp) :: weight(grid%n_functions, most_nodes_of_leaf)
      integer :: masters(most_nodes_of_leaf), n_here, n, k, j
      allocate (met(grid%n_nodes), source=.false.)
      allocate (list(grid%n_nodes))
      n = 0
      do k = 1, size(elements)
         call grid%dofs%masters_of(grid%support_of(elements(k)), n_here, masters, weight)
         do j = 1, n_here
            if (met(masters(j))) cycle
            met(masters(j)) = .true.
            n = n + 1
            list(n) = masters(j)
         end do
      end do
      allocate (nodes, source=list(:n))
   end subroutine nodes_of_elements
end module hampm_numbering
