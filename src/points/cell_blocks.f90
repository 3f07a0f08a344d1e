!> Order of the particles of the cells in memory, for fast passes over them (`hampm_particle_pass`): its only owner.
!>
!> Cells with particles form blocks of `lanes`, in the order of the grid: a pass does the cells of a block side by side. If all
!> cells of a block have the same number of particles, these stand in rows: the first of each cell, then the second of each, and so
!> on; else cell after cell. The particles of a cell e are always those from `first_in(e)` to `last_in(e)` by `stride_in(e)`;
!> nothing outside the kernels needs to know more.
module hampm_cell_blocks
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: points_of_quadratic, quarter_of_point, corner_of_point
   use hampm_failure, only: failure_t, exit_computation
   use hampm_dofs, only: element_of_slot, corner_of_slot
   use hampm_grid, only: grid_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: cell_blocks_t, support_t, resize_to_elements, form_blocks, place_blocks, find_materials, &
             smallest_occupied_cell, lanes, of_mass, of_momentum, of_force, n_sums

   integer, parameter :: lanes = 4               !! cells of a block

   ! Contributions of a cell to the nodal sums at its corners
   integer, parameter :: of_mass = 1
   integer, parameter :: of_momentum = 2                   !! the first component
   integer, parameter :: of_force = of_momentum + ndim     !! the first component
   integer, parameter :: n_sums = of_force + ndim - 1

   !> A cell with particles, or a piece of one, and the points on which these act: the four of a bilinear cell, or the nine of a
   !> quadratic one, which is stored as its quarters.
   type :: support_t
      integer :: n = 0                                  !! number of points
      integer :: first = 0, last = 0                    !! its elements
      integer :: points(points_of_quadratic) = 0        !! 0 behind the last
      real(dp) :: lower(ndim) = 0                       !! its lower corner [m]
      real(dp) :: inverse_size = 0                      !! 1 / its edge length [1/m]
      integer :: block(corners) = 0                     !! in which each of its elements is
      integer :: lane(corners) = 0                      !! and where in it
      integer :: element_of(points_of_quadratic) = 0    !! of which of them each point is a corner, 1 to 4
      integer :: corner_of(points_of_quadratic) = 0     !! and which corner
      logical :: is_cut = .false.                       !! by a crack or the edge of a body
      real(dp) :: correction(points_of_quadratic, ndim) = 0 !! of the gradients of its functions, where it is cut [1/m]
   contains
      procedure :: find_functions
   end type support_t

   !> The cells with particles, in blocks.
   type :: cell_blocks_t
      ! The particles of each element
      integer, allocatable :: count_in(:)               !! their number, (n_elements)
      integer, allocatable :: first_in(:), last_in(:)   !! where the first and the last stand, 1 and 0 in empty ones, (n_elements)
      integer, allocatable :: stride_in(:)              !! distance from one to the next, (n_elements)
      integer :: n_occupied = 0
      integer, allocatable :: occupied(:)               !! elements with particles, ascending; of quadratic cells all quarters, also
                                                        !! those that have none as a piece is elsewhere. (n_occupied)
      ! The blocks
      integer :: n = 0                                  !! number of blocks
      integer :: layout = 0                             !! how often their cells have changed
      integer, allocatable :: cells(:, :)               !! elements of each block, 0 after the last, (lanes, n)
      integer, allocatable :: first(:)                  !! its first particle, (n)
      integer, allocatable :: rows(:)                   !! largest number of particles of its cells, (n)
      logical, allocatable :: is_even(:)                !! whether these have equal numbers, (n)
      integer, allocatable :: material(:)               !! the material of all its particles, 0 where there are several, (n)
      integer, allocatable :: alike(:)                  !! how many blocks, from this one on, are even and have as many rows of the
                                                        !! same material: these can be done at once; (n)
      ! Where they are in the grid
      integer :: n_points = 0                           !! points of that
      integer, allocatable :: nodes(:, :, :)            !! points at the corners of the cells, those of another cell where there is
                                                        !! none; (corners, lanes, n)
      logical, allocatable :: in_row(:)                 !! whether these points are 2 (in space 4) rows of consecutive numbers; (n)
      real(dp), allocatable :: lower(:, :, :)           !! lower corners of the cells [m], (lanes, ndim, n)
      real(dp), allocatable :: inverse_size(:, :)       !! 1 / edge length of the cells [1/m], (lanes, n)
      integer, allocatable :: slot(:, :)                !! where among the contributions of all blocks those of the cells around a
                                                        !! point to its mass stand, in the order of the cells; where there are
                                                        !! fewer, 1, which is zero; (corners, n_points)
      integer, allocatable :: high_valence(:, :)        !! nodes with more than `corners` occupied cells, and where the
                                                        !! contributions of the others to the mass stand, in order; (2, cells)
      logical, allocatable :: is_high_valence(:)        !! whether a node is one of these; not allocated if there are none
      ! Passes by supports (`hampm_support_pass`)
      logical :: by_supports = .false.                  !! whether bilinear cells are passed so, too
      type(support_t), allocatable :: supports(:)       !! the cells with particles, where they are; else not allocated
      integer :: sorts = 0                              !! how often blocks have been formed
   contains
      procedure :: last
   end type cell_blocks_t

contains

   !> Room for the elements of a grid. Fails where the memory does not suffice.
   subroutine resize_to_elements(blocks, n_elements, failure)
      type(cell_blocks_t), intent(inout) :: blocks
      integer, intent(in) :: n_elements
      type(failure_t), intent(inout) :: failure
      integer :: status
      if (allocated(blocks%count_in)) then
         if (size(blocks%count_in) == n_elements) return
         deallocate (blocks%count_in, blocks%first_in, blocks%last_in, blocks%stride_in, blocks%occupied, blocks%cells, &
                     blocks%first, blocks%rows, blocks%is_even, blocks%material, blocks%alike)
      end if
      blocks%n = 0
      associate (most => (n_elements - 1)/lanes + 1)
         allocate (blocks%count_in(n_elements), blocks%first_in(n_elements), blocks%last_in(n_elements), &
                   blocks%stride_in(n_elements), blocks%occupied(n_elements), blocks%cells(lanes, most), blocks%first(most), &
                   blocks%rows(most), blocks%is_even(most), blocks%material(most), blocks%alike(most), stat=status)
      end associate
      if (status /= 0) call report_lack(failure)
   end subroutine resize_to_elements

   !> Fail because the memory does not suffice.
   subroutine report_lack(failure)
      type(failure_t), intent(inout) :: failure
      call failure%report(exit_computation, 'grid: not enough memory for its cells')
   end subroutine report_lack

   !> Form the blocks of the cells with particles, and find where these will stand.
   subroutine form_blocks(blocks, grid, cell_of)
      type(cell_blocks_t), intent(inout) :: blocks
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell_of(:)          !! the element of each particle
      call count_cells(blocks, cell_of, merge(corners, 1, grid%is_quadratic()))
      blocks%sorts = blocks%sorts + 1
      call fill_blocks(blocks)
   end subroutine form_blocks

   !> Count the particles of each cell. Elements that belong together, the quarters of a quadratic cell, are all occupied if one is:
   !> they act on the points of the whole cell.
   subroutine count_cells(blocks, cell_of, together)
      type(cell_blocks_t), intent(inout) :: blocks
      integer, intent(in) :: cell_of(:)
      integer, intent(in) :: together            !! elements that belong together
      integer :: i, e, first
      blocks%count_in = 0
      do i = 1, size(cell_of)
         blocks%count_in(cell_of(i)) = blocks%count_in(cell_of(i)) + 1
      end do
      blocks%n_occupied = 0
      do e = 1, size(blocks%count_in)
         first = e - mod(e - 1, together)
         if (all(blocks%count_in(first:first + together - 1) == 0)) cycle
         blocks%n_occupied = blocks%n_occupied + 1
         blocks%occupied(blocks%n_occupied) = e
      end do
   end subroutine count_cells

   !> Fill blocks with the occupied cells, note whether that changes them, and find where the particles of these will stand.
   subroutine fill_blocks(blocks)
      type(cell_blocks_t), intent(inout) :: blocks
      integer :: b, l, e, place, cells(lanes), counts(lanes)
      logical :: changed
      changed = blocks%n /= (blocks%n_occupied - 1)/lanes + 1
      blocks%n = (blocks%n_occupied - 1)/lanes + 1
      blocks%first_in = 1
      blocks%last_in = 0
      blocks%stride_in = 1
      place = 1
      do b = 1, blocks%n
         cells = 0
         l = min(lanes*b, blocks%n_occupied)
         cells(:l - lanes*(b - 1)) = blocks%occupied(lanes*(b - 1) + 1:l)
         if (.not. changed) changed = any(blocks%cells(:, b) /= cells)
         blocks%cells(:, b) = cells
         blocks%first(b) = place
         do l = 1, lanes
            counts(l) = 0
            if (cells(l) > 0) counts(l) = blocks%count_in(cells(l))
         end do
         blocks%rows(b) = maxval(counts)
         blocks%is_even(b) = all(counts == blocks%rows(b))
         do l = 1, lanes
            e = cells(l)
            if (e == 0) exit
            if (blocks%is_even(b)) then
               blocks%stride_in(e) = lanes
               blocks%first_in(e) = blocks%first(b) + l - 1
            else
               blocks%first_in(e) = place
            end if
            blocks%last_in(e) = blocks%first_in(e) + (blocks%count_in(e) - 1)*blocks%stride_in(e)
            place = place + blocks%count_in(e)
         end do
      end do
      if (changed) blocks%layout = blocks%layout + 1
   end subroutine fill_blocks

   !> Find the blocks of one material, and those that follow each other and are alike, once the particles stand in their order.
   subroutine find_materials(blocks, material)
      type(cell_blocks_t), intent(inout) :: blocks
      integer, intent(in) :: material(:)         !! of each particle
      integer :: b, from
      do b = 1, blocks%n
         from = blocks%first(b)
         blocks%material(b) = 0
         if (blocks%last(b) < from) cycle
         if (all(material(from:blocks%last(b)) == material(from))) blocks%material(b) = material(from)
      end do
      do b = blocks%n, 1, -1
         blocks%alike(b) = 1
         if (b == blocks%n .or. .not. blocks%is_even(b)) cycle
         if (blocks%is_even(b + 1) .and. blocks%rows(b + 1) == blocks%rows(b) .and. blocks%material(b + 1) == blocks%material(b)) &
            blocks%alike(b) = blocks%alike(b + 1) + 1
      end do
   end subroutine find_materials

   !> The last particle of a block.
   pure integer function last(self, block)
      class(cell_blocks_t), intent(in) :: self
      integer, intent(in) :: block
      if (block < self%n) then
         last = self%first(block + 1) - 1
      else
         last = maxval(self%last_in(pack(self%cells(:, block), self%cells(:, block) > 0)))
      end if
   end function last

   !> Find where the blocks are in the grid, and where the contributions of the cells around each point stand. Fails where the
   !> memory does not suffice.
   subroutine place_blocks(blocks, grid, failure)
      type(cell_blocks_t), intent(inout) :: blocks
      type(grid_t), intent(in) :: grid
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: most_blocks = real(huge(1), dp)/(lanes*corners*n_sums) - 1  ! places of contributions are numbered
      integer :: b, l, e
      if (blocks%n > most_blocks) then
         call failure%report(exit_computation, 'grid: '//to_text(count(blocks%cells(:, :blocks%n) > 0))//' cells with material '// &
                             'are too many, '//to_text(lanes*int(most_blocks))//' at most can be numbered; use a larger &grid cell')
         return
      end if
      call resize_to_grid(blocks, grid%n_points, failure)
      if (failure%failed()) return
      do b = 1, blocks%n
         do l = 1, lanes
            e = blocks%cells(l, b)
            if (e == 0) e = blocks%cells(1, b)
            blocks%nodes(:, l, b) = grid%element_nodes(:, e)
            blocks%lower(l, :, b) = grid%element_lower(:, e)
            blocks%inverse_size(l, b) = 1/grid%element_size(e)
         end do
         blocks%in_row(b) = are_in_row(blocks%nodes(:, :, b))
      end do
      call find_slots(blocks, grid)
      if (grid%is_quadratic() .or. blocks%by_supports) call place_supports(blocks, grid)
   end subroutine place_blocks

   !> Find the cells with particles, or their pieces: their points, and where their contributions stand.
   subroutine place_supports(blocks, grid)
      type(cell_blocks_t), intent(inout) :: blocks
      type(grid_t), intent(in) :: grid
      integer, allocatable :: block_of(:), lane_of(:)
      integer :: b, l, e, k, n, together
      allocate (block_of(grid%n_elements), lane_of(grid%n_elements))
      block_of = 0
      lane_of = 0
      do b = 1, blocks%n
         do l = 1, count(blocks%cells(:, b) > 0)
            block_of(blocks%cells(l, b)) = b
            lane_of(blocks%cells(l, b)) = l
         end do
      end do
      together = merge(corners, 1, grid%is_quadratic())
      if (allocated(blocks%supports)) deallocate (blocks%supports)
      allocate (blocks%supports(count(block_of(::together) > 0)))
      n = 0
      do e = 1, grid%n_elements, together
         if (block_of(e) == 0) cycle
         n = n + 1
         associate (s => blocks%supports(n))
            s%n = grid%n_functions
            s%first = e
            s%last = e + together - 1
            s%points(:s%n) = grid%support_of(e)
            s%lower = grid%element_lower(:, e)
            s%inverse_size = 1/(grid%element_size(e)*merge(2, 1, grid%is_quadratic()))
            s%block(:together) = block_of(e:s%last)
            s%lane(:together) = lane_of(e:s%last)
            if (grid%is_quadratic()) then
               s%element_of = quarter_of_point
               s%corner_of = corner_of_point
            else
               s%element_of(:corners) = 1
               s%corner_of(:corners) = [(k, k=1, corners)]
            end if
            s%is_cut = grid%is_cut(grid%element_leaf(e))
            if (allocated(grid%correction)) s%correction = grid%correction(:, :, (e - 1)/corners + 1)
         end associate
      end do
   end subroutine place_supports

   !> Shape functions of a cell's points at some places, side by side, and their gradients: products of functions along x and y.
   pure subroutine find_functions(self, xi, n, gradient)
      class(support_t), intent(in) :: self
      real(dp), intent(in) :: xi(lanes, ndim)           !! places in the cell, 0 to 1
      real(dp), intent(out) :: n(lanes, points_of_quadratic), gradient(lanes, points_of_quadratic, ndim) !! [1/m]
      real(dp) :: along(lanes, 3, ndim), slope(lanes, 3, ndim)
      integer :: i, j, k, c, d, n_along, n_points
      n_points = corners                         ! constants of a solid, for which the compiler unrolls
      if (ndim == 2) n_points = self%n
      n_along = 2
      if (n_points > corners) n_along = 3
      do d = 1, ndim
         if (n_points == corners) then
            along(:, 1, d) = 1 - xi(:, d)
            along(:, 2, d) = xi(:, d)
            slope(:, 1, d) = -1
            slope(:, 2, d) = 1
         else
            along(:, 1, d) = (1 - xi(:, d))*(1 - 2*xi(:, d))
            along(:, 2, d) = 4*xi(:, d)*(1 - xi(:, d))
            along(:, 3, d) = xi(:, d)*(2*xi(:, d) - 1)
            slope(:, 1, d) = 4*xi(:, d) - 3
            slope(:, 2, d) = 4 - 8*xi(:, d)
            slope(:, 3, d) = 4*xi(:, d) - 1
         end if
      end do
      do c = 1, n_points
         i = c - 1
         n(:, c) = 1
         gradient(:, c, :) = 1
         do d = 1, ndim
            k = mod(i, n_along) + 1
            i = i/n_along
            do j = 1, ndim
               if (j /= d) gradient(:, c, j) = gradient(:, c, j)*along(:, k, d)
               if (j == d) gradient(:, c, j) = gradient(:, c, j)*slope(:, k, d)
            end do
            n(:, c) = n(:, c)*along(:, k, d)
         end do
         do d = 1, ndim
            gradient(:, c, d) = gradient(:, c, d)*self%inverse_size + self%correction(c, d)
         end do
      end do
   end subroutine find_functions

   !> Room for where the blocks and the points around them are.
   subroutine resize_to_grid(blocks, n_points, failure)
      type(cell_blocks_t), intent(inout) :: blocks
      integer, intent(in) :: n_points
      type(failure_t), intent(inout) :: failure
      integer :: n, status
      status = 0
      blocks%n_points = n_points
      if (allocated(blocks%slot)) then
         if (size(blocks%slot, 2) /= n_points) deallocate (blocks%slot)
      end if
      if (.not. allocated(blocks%slot)) allocate (blocks%slot(corners, n_points), stat=status)
      if (allocated(blocks%nodes)) then
         if (size(blocks%nodes, 3) < blocks%n) deallocate (blocks%nodes, blocks%in_row, blocks%lower, blocks%inverse_size)
      end if
      if (status == 0 .and. .not. allocated(blocks%nodes)) then
         n = blocks%n + blocks%n/8
         allocate (blocks%nodes(corners, lanes, n), blocks%in_row(n), blocks%lower(lanes, ndim, n), &
                   blocks%inverse_size(lanes, n), stat=status)
      end if
      if (status /= 0) call report_lack(failure)
   end subroutine resize_to_grid

   !> Where around each node the contributions of its cells stand.
   subroutine find_slots(blocks, grid)
      type(cell_blocks_t), intent(inout) :: blocks
      type(grid_t), intent(in) :: grid
      integer, allocatable :: first_slot(:)
      integer, allocatable :: places(:)
      integer :: b, l, node, k
      allocate (first_slot(grid%n_elements), source=0)
      do b = 1, blocks%n
         do l = 1, lanes
            if (blocks%cells(l, b) > 0) first_slot(blocks%cells(l, b)) = lanes*corners*n_sums*b + l
         end do
      end do
      blocks%high_valence = reshape([integer ::], [2, 0])
      if (allocated(blocks%is_high_valence)) deallocate (blocks%is_high_valence)
      do node = 1, grid%n_points
         associate (first => grid%dofs%first_slot(node), next => grid%dofs%first_slot(node + 1))
            if (next - first > corners) then
               places = [(place_of(grid%dofs%slot(k)), k=first, next - 1)]
               places = pack(places, places > 1)
               blocks%slot(:, node) = 1
               blocks%slot(:min(size(places), corners), node) = places(:min(size(places), corners))
               if (size(places) > corners) call note_high_valence(node, places(corners + 1:))
               cycle
            end if
            do k = first, next - 1
               blocks%slot(k - first + 1, node) = place_of(grid%dofs%slot(k))
            end do
            blocks%slot(next - first + 1:, node) = 1
         end associate
      end do
   contains
      !> Note that a node has more cells than four, and where the contributions of the others stand.
      subroutine note_high_valence(node, others)
         integer, intent(in) :: node
         integer, intent(in) :: others(:)
         integer :: k
         if (.not. allocated(blocks%is_high_valence)) allocate (blocks%is_high_valence(grid%n_points), source=.false.)
         blocks%is_high_valence(node) = .true.
         blocks%high_valence = reshape([blocks%high_valence, [(node, others(k), k=1, size(others))]], &
                                       [2, size(blocks%high_valence, 2) + size(others)])
      end subroutine note_high_valence

      !> Where the contribution of a cell to the mass at one of its corners stands; where the cell has no particles, a zero.
      pure integer function place_of(slot)
         integer, intent(in) :: slot
         place_of = first_slot(element_of_slot(slot))
         if (place_of == 0) then
            place_of = 1
         else
            place_of = place_of + lanes*(corner_of_slot(slot) - 1)
         end if
      end function place_of
   end subroutine find_slots

   !> Whether the points of a block belong to cells side by side, with consecutive numbers at each of their edges.
   pure logical function are_in_row(nodes)
      integer, intent(in) :: nodes(corners, lanes)
      integer :: l, c
      are_in_row = .true.
      do l = 1, lanes
         do c = 1, corners, 2
            are_in_row = are_in_row .and. all(nodes(c:c + 1, l) == nodes(c, 1) + [l - 1, l])
         end do
      end do
   end function are_in_row

   !> Size of the smallest element that holds particles or, where cells are quadratic and whole, of the smallest of these [m].
   pure real(dp) function smallest_occupied_cell(grid, blocks) result(smallest)
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      smallest = minval(grid%element_size(blocks%occupied(:blocks%n_occupied)))
      if (grid%is_quadratic()) smallest = 2*smallest
   end function smallest_occupied_cell
end module hampm_cell_blocks
