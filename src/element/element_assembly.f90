!> Assembly of sparse matrices from matrices of elements, of any number of directions. The unknowns of an element belong to its
!> corners or, if these are hanging nodes, to their masters.
module hampm_element_assembly
   use hampm_kinds, only: dp
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_grid, only: grid_t
   use hampm_numbering, only: numbering_t
   use hampm_sparse, only: sparse_t, pattern_of_cliques
   implicit none
   private
   public :: pattern_of_elements, next_support, matrix_by_masters, add_element

contains

   !> The pattern of a matrix that couples all unknowns of each of some elements, and of each of some other groups of nodes. Values
   !> are zero.
   subroutine pattern_of_elements(grid, elements, numbering, matrix, groups)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: elements(:)
      type(numbering_t), intent(in) :: numbering
      type(sparse_t), intent(out) :: matrix
      integer, intent(in), optional :: groups(:, :) !! nodes with degrees of freedom, 0 behind the last of each
      integer, allocatable :: cliques(:, :)
      real(dp) :: weight(grid%n_functions, most_nodes_of_leaf)
      integer :: masters(most_nodes_of_leaf), n, k, n_cliques, n_groups, most
      n_groups = 0
      most = merge(grid%n_functions, most_nodes_of_leaf, grid%dofs%n_hanging == 0)
      if (present(groups)) n_groups = size(groups, 2)
      if (n_groups > 0) most = max(most, size(groups, 1))
      associate (directions => size(numbering%dof, 1))
         allocate (cliques(directions*most, size(elements) + n_groups), source=0)
         n_cliques = 0
         k = 1
         do while (k <= size(elements))
            call grid%dofs%masters_of(grid%support_of(elements(k)), n, masters, weight)
            n_cliques = n_cliques + 1
            cliques(:directions*n, n_cliques) = reshape(numbering%dof(:, masters(:n)), [directions*n])
            k = next_support(grid, elements, k)
         end do
         do k = 1, n_groups
            n = count(groups(:, k) > 0)
            cliques(:directions*n, n_cliques + k) = reshape(numbering%dof(:, groups(:n, k)), [directions*n])
         end do
      end associate
      call pattern_of_cliques(numbering%n, cliques(:, :n_cliques + n_groups), matrix)
   end subroutine pattern_of_elements

   !> The first element behind the k-th that has other functions: quarters of a quadratic cell, or of its piece, have the same.
   pure integer function next_support(grid, elements, k) result(next)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: elements(:)         !! ascending
      integer, intent(in) :: k
      integer :: last
      next = k + 1
      if (.not. grid%is_quadratic()) return
      last = grid%last_of_piece(elements(k))
      do while (next <= size(elements))
         if (elements(next) < elements(k) .or. elements(next) > last) return
         next = next + 1
      end do
   end function next_support

   !> The matrix of an element by masters, T transposed A T with A by its nodes and T their weights (`masters_of`). Rows and columns
   !> are by node, the directions of a node consecutive.
   pure subroutine matrix_by_masters(grid, e, directions, by_node, n, masters, by_master)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: e                   !! the element
      integer, intent(in) :: directions
      real(dp), intent(in) :: by_node(directions*grid%n_functions, directions*grid%n_functions)
      integer, intent(out) :: n                  !! number of masters
      integer, intent(out) :: masters(most_nodes_of_leaf)
      real(dp), intent(out) :: by_master(directions*most_nodes_of_leaf, directions*most_nodes_of_leaf) !! as far as masters exist
      real(dp) :: weight(grid%n_functions, most_nodes_of_leaf), half(directions*grid%n_functions), part(directions)
      integer :: of(grid%n_functions, most_nodes_of_leaf), n_of(most_nodes_of_leaf) ! functions that a master has a weight in
      integer :: c, i, j, k, l
      associate (at => grid%support_of(e))
         if (all(at <= grid%n_nodes)) then
            n = size(at)
            masters(:n) = at
            by_master(:directions*n, :directions*n) = by_node
            return
         end if
         call grid%dofs%masters_of(at, n, masters, weight)
      end associate
      n_of = 0
      do k = 1, n
         do c = 1, grid%n_functions
            if (.not. abs(weight(c, k)) > 0) cycle
            n_of(k) = n_of(k) + 1
            of(n_of(k), k) = c
         end do
      end do
      do k = 1, n
         do j = 1, directions
            half = 0
            do i = 1, n_of(k)
               c = of(i, k)
               half = half + by_node(:, directions*(c - 1) + j)*weight(c, k)
            end do
            do l = 1, n
               part = 0
               do i = 1, n_of(l)
                  c = of(i, l)
                  part = part + weight(c, l)*half(directions*(c - 1) + 1:directions*c)
               end do
               by_master(directions*(l - 1) + 1:directions*l, directions*(k - 1) + j) = part
            end do
         end do
      end do
   end subroutine matrix_by_masters

   !> Add the matrix of an element, without the rows and columns of fixed degrees of freedom.
   pure subroutine add_element(numbering, masters, by_master, matrix)
      type(numbering_t), intent(in) :: numbering
      integer, intent(in) :: masters(:)          !! of the element
      real(dp), intent(in) :: by_master(:, :)    !! see `matrix_by_masters`
      type(sparse_t), intent(inout) :: matrix
      integer :: unknown(size(numbering%dof, 1)*size(masters))
      unknown = reshape(numbering%dof(:, masters), [size(unknown)])
      if (allocated(numbering%weight)) then
         associate (weight => reshape(numbering%weight(:, masters), [size(unknown)]))
            call matrix%add_block(unknown, by_master*spread(weight, 1, size(unknown))*spread(weight, 2, size(unknown)))
         end associate
      else
         call matrix%add_block(unknown, by_master)
      end if
   end subroutine add_element
end module hampm_element_assembly
