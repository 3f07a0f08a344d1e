!> Matrices by rows of nodes, hanging nodes included. The row of a node has a place for each node of the cells around it, zero
!> places for the node itself if there are fewer. A matrix by cells, as in `mass_matrix_t`, is summed into its rows once, and
!> multiplied by often: along spans of nodes whose neighbours are numbered alike, without index look-up.
module hampm_nodal_rows
   use hampm_kinds, only: dp, ndim, corners, neighbours
   use hampm_basis, only: points_of_quadratic
   use hampm_dofs, only: list_slots
   use hampm_grid, only: grid_t
   implicit none
   private
   public :: pattern_t, spans_t, unlike_neighbours, pattern_of_grid, find_spans, sum_rows, multiply_rows

   !> Nodes of four cells around a node, of any sizes
   integer, parameter :: unlike_neighbours = corners*(corners - 1) + 1

   !> Where the entries of the rows stand.
   type :: pattern_t
      integer :: width = 0                       !! places of a row
      integer, allocatable :: neighbour(:, :)    !! node of each place of a row, (width, n_points)
      integer, allocatable :: first_slot(:)      !! first entry of each node in the next, (n_points + 1)
      integer, allocatable :: slot(:)            !! where it stands in a cell: its place there + (nodes of a cell)*(cell - 1)
      integer, allocatable :: place(:, :)        !! in the row of the node at a slot, the place of each node of the slot's
                                                 !! cell, (nodes of a cell, slots)
   end type pattern_t

   !> Some nodes as spans of consecutive numbers, for all nodes of which a place of the row means the node at the same distance.
   type :: spans_t
      integer, allocatable :: of_chunk(:)        !! first span of each chunk of nodes, (chunks + 1)
      integer, allocatable :: first(:)           !! first node of each span
      integer, allocatable :: last(:)            !! last node of each span
      integer, allocatable :: offset(:, :)       !! from a node to the one of each place of its row, (width, spans)
   end type spans_t

contains

   !> The pattern of a grid. `status` is not zero where the memory does not suffice.
   subroutine pattern_of_grid(grid, pattern, status)
      type(grid_t), intent(in) :: grid
      type(pattern_t), intent(out) :: pattern
      integer, intent(out) :: status
      integer, allocatable :: nodes(:, :)        ! of each cell: an element or, of quadratic ones, four
      integer, allocatable :: row(:)
      integer :: node, cell, n, quarters
      quarters = merge(corners, 1, grid%is_quadratic())
      allocate (nodes(grid%n_functions, grid%n_elements/quarters), stat=status)
      if (status /= 0) return
      do cell = 1, size(nodes, 2)
         nodes(:, cell) = grid%support_of(quarters*(cell - 1) + 1)
      end do
      call list_slots(grid%n_points, nodes, pattern%first_slot, pattern%slot, status)
      if (status /= 0) return
      associate (first => pattern%first_slot)
         allocate (row(1 + (size(nodes, 1) - 1)*maxval(first(2:) - first(:grid%n_points))))
      end associate
      do node = 1, grid%n_points
         call find_neighbours(pattern, nodes, node, row, n)
         pattern%width = max(pattern%width, n)
      end do
      ! Products are fast where the compiler knows the width
      if (pattern%width <= unlike_neighbours) pattern%width = merge(neighbours, unlike_neighbours, pattern%width <= neighbours)
      allocate (pattern%neighbour(pattern%width, grid%n_points), pattern%place(size(nodes, 1), size(nodes)), stat=status)
      if (status /= 0) return
      do node = 1, grid%n_points
         call find_neighbours(pattern, nodes, node, row, n)
         pattern%neighbour(:n, node) = row(:n)
         pattern%neighbour(n + 1:, node) = node
         call find_places(pattern, nodes, node, row(:n))
      end do
   end subroutine pattern_of_grid

   !> The nodes of the cells around a node, the node itself first.
   pure subroutine find_neighbours(pattern, nodes, node, row, n)
      type(pattern_t), intent(in) :: pattern
      integer, intent(in) :: nodes(:, :)                !! of each cell
      integer, intent(in) :: node
      integer, intent(inout) :: row(:)
      integer, intent(out) :: n                         !! how many they are
      integer :: j, k
      row(1) = node
      n = 1
      do j = pattern%first_slot(node), pattern%first_slot(node + 1) - 1
         do k = 1, size(nodes, 1)
            associate (other => nodes(k, (pattern%slot(j) - 1)/size(nodes, 1) + 1))
               if (any(row(:n) == other)) cycle
               n = n + 1
               row(n) = other
            end associate
         end do
      end do
   end subroutine find_neighbours

   !> The places of the nodes of the cells around a node in its row.
   pure subroutine find_places(pattern, nodes, node, row)
      type(pattern_t), intent(inout) :: pattern
      integer, intent(in) :: nodes(:, :)                !! of each cell
      integer, intent(in) :: node
      integer, intent(in) :: row(:)                     !! its neighbours
      integer :: j, k
      do j = pattern%first_slot(node), pattern%first_slot(node + 1) - 1
         associate (slot => pattern%slot(j))
            do k = 1, size(nodes, 1)
               pattern%place(k, slot) = findloc(row, nodes(k, (slot - 1)/size(nodes, 1) + 1), dim=1)
            end do
         end associate
      end do
   end subroutine find_places

   !> The rows of some nodes from a matrix by cells, always summed in the order of the cells.
   subroutine sum_rows(pattern, n, nodes, cell, row)
      type(pattern_t), intent(in) :: pattern
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in), contiguous :: cell(:, :, :) !! symmetric, (nodes of a cell, nodes of a cell, cells)
      real(dp), intent(inout), contiguous :: row(:, :)  !! (width, n_points)
      if (size(cell, 1) == corners) then         ! constants, for which the compiler unrolls
         call sum_rows_of(corners, n, nodes, pattern%first_slot, pattern%slot, pattern%place, cell, size(row, 1), row)
      else
         call sum_rows_of(points_of_quadratic, n, nodes, pattern%first_slot, pattern%slot, pattern%place, cell, size(row, 1), row)
      end if
   end subroutine sum_rows

   !> `sum_rows` of cells with a given number of nodes.
   subroutine sum_rows_of(functions, n, nodes, first_slot, slots, place, cell, width, row)
      integer, intent(in) :: functions                  !! nodes of a cell
      integer, intent(in) :: n, nodes(n)
      integer, intent(in) :: first_slot(*), slots(*), place(functions, *)  !! see `pattern_t`
      real(dp), intent(in) :: cell(functions, *)        !! by slot
      integer, intent(in) :: width
      real(dp), intent(inout) :: row(width, *)          !! by node
      real(dp) :: total(width)
      integer :: a, j, k, slot
      !$omp parallel do schedule(static) private(total, j, k, slot)
      do a = 1, n
         total = 0
         do j = first_slot(nodes(a)), first_slot(nodes(a) + 1) - 1
            slot = slots(j)
            do k = 1, functions
               total(place(k, slot)) = total(place(k, slot)) + cell(k, slot)
            end do
         end do
         row(:, nodes(a)) = total
      end do
   end subroutine sum_rows_of

   !> The spans of some nodes, which are taken in chunks.
   pure subroutine find_spans(pattern, nodes, per_chunk, spans)
      type(pattern_t), intent(in) :: pattern
      integer, intent(in) :: nodes(:)
      integer, intent(in) :: per_chunk                  !! nodes of a chunk
      type(spans_t), intent(out) :: spans
      integer, dimension(size(pattern%neighbour, 1)) :: offset, last_offset
      integer :: place(size(nodes) + 1), a, n
      n = 0
      allocate (spans%of_chunk((size(nodes) + per_chunk - 1)/per_chunk + 1))
      last_offset = 0
      do a = 1, size(nodes)
         offset = pattern%neighbour(:, nodes(a)) - nodes(a)
         if (mod(a - 1, per_chunk) == 0) then
            spans%of_chunk((a - 1)/per_chunk + 1) = n + 1
            last_offset = 0                      ! spans end with their chunk
         end if
         if (a > 1 .and. all(offset == last_offset)) then
            if (nodes(a) == nodes(a - 1) + 1) cycle
         end if
         n = n + 1
         place(n) = a
         last_offset = offset
      end do
      spans%of_chunk(size(spans%of_chunk)) = n + 1
      place(n + 1) = size(nodes) + 1
      spans%first = nodes(place(:n))
      spans%last = nodes(place(2:n + 1) - 1)
      allocate (spans%offset(size(offset), n))
      do a = 1, n
         spans%offset(:, a) = pattern%neighbour(:, spans%first(a)) - spans%first(a)
      end do
   end subroutine find_spans

   !> y = S A x at the nodes of some spans, S being diagonal, and the sum of x.A x, by component.
   pure subroutine multiply_rows(width, n, first, last, offset, row, scale, x, y, xax)
      integer, intent(in) :: width                      !! places of a row
      integer, intent(in) :: n, first(n), last(n), offset(width, n)  !! see `spans_t`
      real(dp), intent(in) :: row(width, *)             !! A, by node
      real(dp), intent(in) :: scale(ndim, *)            !! S, by node
      real(dp), intent(in) :: x(ndim, *)
      real(dp), intent(inout) :: y(ndim, *)
      real(dp), intent(out) :: xax(ndim)
      real(dp) :: total(ndim)
      integer :: span, i, k
      xax = 0
      do span = 1, n
         do i = first(span), last(span)
            total = 0
            do k = 1, width
               total = total + row(k, i)*x(:, i + offset(k, span))
            end do
            y(:, i) = scale(:, i)*total
            xax = xax + total*x(:, i)
         end do
      end do
   end subroutine multiply_rows
end module hampm_nodal_rows
