!> Matrices by rows of nodes. The row of a node has a place for each node of the cells around it: for the node itself where
!> there are fewer, with nothing in it. A matrix that is known by cells, as `mass_matrix_t` has it, is summed into its rows
!> once, and multiplied by often: along runs of nodes whose neighbours are numbered as they are, so that no index is looked up.
module hampm_nodal_rows
   use hampm_kinds, only: dp, ndim, corners, neighbours, most_neighbours
   use hampm_grid, only: grid_t, element_of_slot
   implicit none
   private
   public :: pattern_t, runs_t, row_width, pattern_of_grid, find_runs, sum_rows, multiply_rows

   !> Where the entries of the rows stand.
   type :: pattern_t
      integer, allocatable :: neighbour(:, :)    !! point of each place of a row, (width, n_points)
      integer, allocatable :: place(:, :)        !! in the row of the node at a slot, the place of each corner of the slot's
                                                 !! element, (corners, corners*n_elements)
   end type pattern_t

   !> Some nodes as runs of consecutive numbers, for all nodes of which a place of the row means the node at the same distance.
   type :: runs_t
      integer, allocatable :: of_block(:)        !! first run of each block of nodes, (blocks + 1)
      integer, allocatable :: first(:)           !! first node of each run
      integer, allocatable :: last(:)            !! last node of each run
      integer, allocatable :: offset(:, :)       !! from a node to the one of each place of its row, (width, runs)
   end type runs_t

contains

   !> Places of a row: on a grid with cells of different sizes or with cuts there are more.
   pure integer function row_width(grid)
      type(grid_t), intent(in) :: grid
      row_width = merge(neighbours, most_neighbours, grid%dofs%n_hanging == 0 .and. size(grid%cuts) == 0)
   end function row_width

   !> The pattern of a grid.
   pure subroutine pattern_of_grid(grid, pattern)
      type(grid_t), intent(in) :: grid
      type(pattern_t), intent(out) :: pattern
      integer :: node, c, k, slot, n, e
      allocate (pattern%neighbour(row_width(grid), grid%n_points), pattern%place(corners, corners*grid%n_elements))
      do node = 1, grid%n_points
         associate (row => pattern%neighbour(:, node))
            row = node
            n = 1
            do c = 1, corners
               slot = grid%node_slot(c, node)
               if (slot == 0) exit
               e = element_of_slot(slot)
               do k = 1, corners
                  if (all(row(:n) /= grid%element_nodes(k, e))) then
                     n = n + 1
                     row(n) = grid%element_nodes(k, e)
                  end if
                  pattern%place(k, slot) = place_of(row, grid%element_nodes(k, e))
               end do
            end do
         end associate
      end do
   end subroutine pattern_of_grid

   !> The place of a value among `values`.
   pure integer function place_of(values, value) result(place)
      integer, intent(in) :: values(:), value
      do place = 1, size(values)
         if (values(place) == value) return
      end do
   end function place_of

   !> The rows of some nodes from a matrix by cells, always summed in the order of the cells.
   subroutine sum_rows(n, nodes, node_slot, place, cell, width, row)
      integer, intent(in) :: n, nodes(n)
      integer, intent(in) :: node_slot(corners, *)      !! see `grid_t`
      integer, intent(in) :: place(corners, *)          !! see `pattern_t`
      real(dp), intent(in) :: cell(corners, *)          !! symmetric matrices, by slot
      integer, intent(in) :: width
      real(dp), intent(inout) :: row(width, *)          !! by node
      real(dp) :: total(width)
      integer :: a, c, k, slot
      !$omp parallel do schedule(static) private(total, c, k, slot)
      do a = 1, n
         total = 0
         do c = 1, corners
            slot = node_slot(c, nodes(a))
            if (slot == 0) exit
            do k = 1, corners
               total(place(k, slot)) = total(place(k, slot)) + cell(k, slot)
            end do
         end do
         row(:, nodes(a)) = total
      end do
   end subroutine sum_rows

   !> The runs of some nodes, in blocks of `block` nodes.
   pure subroutine find_runs(pattern, nodes, block, runs)
      type(pattern_t), intent(in) :: pattern
      integer, intent(in) :: nodes(:), block
      type(runs_t), intent(out) :: runs
      integer, dimension(size(pattern%neighbour, 1)) :: offset, last_offset
      integer :: place(size(nodes) + 1), a, n
      n = 0
      allocate (runs%of_block((size(nodes) - 1)/block + 2))
      last_offset = 0
      do a = 1, size(nodes)
         offset = pattern%neighbour(:, nodes(a)) - nodes(a)
         if (mod(a - 1, block) == 0) then
            runs%of_block((a - 1)/block + 1) = n + 1
            last_offset = 0                      ! no run goes on from block to block
         end if
         if (a > 1 .and. all(offset == last_offset)) then
            if (nodes(a) == nodes(a - 1) + 1) cycle
         end if
         n = n + 1
         place(n) = a
         last_offset = offset
      end do
      runs%of_block(size(runs%of_block)) = n + 1
      place(n + 1) = size(nodes) + 1
      runs%first = nodes(place(:n))
      runs%last = nodes(place(2:n + 1) - 1)
      allocate (runs%offset(size(offset), n))
      do a = 1, n
         runs%offset(:, a) = pattern%neighbour(:, runs%first(a)) - runs%first(a)
      end do
   end subroutine find_runs

   !> y = S A x at the nodes of some runs, S being diagonal, and the sum of x.A x, by component.
   pure subroutine multiply_rows(width, n, first, last, offset, row, scale, x, y, xax)
      integer, intent(in) :: width                      !! places of a row
      integer, intent(in) :: n, first(n), last(n), offset(width, n)  !! see `runs_t`
      real(dp), intent(in) :: row(width, *)             !! A, by node
      real(dp), intent(in) :: scale(ndim, *)            !! S, by node
      real(dp), intent(in) :: x(ndim, *)
      real(dp), intent(inout) :: y(ndim, *)
      real(dp), intent(out) :: xax(ndim)
      real(dp) :: total(ndim)
      integer :: run, i, k
      xax = 0
      do run = 1, n
         do i = first(run), last(run)
            total = 0
            do k = 1, width
               total = total + row(k, i)*x(:, i + offset(k, run))
            end do
            y(:, i) = scale(:, i)*total
            xax = xax + total*x(:, i)
         end do
      end do
   end subroutine multiply_rows
end module hampm_nodal_rows
