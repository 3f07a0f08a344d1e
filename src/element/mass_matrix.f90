!> The mass matrix (6) by cells: each occupied cell has the small matrix of its corners, sum of m_p N_i N_j over its particles, a
!> part of which may be lumped. Row sums, and so mass and momentum, are always those of (9).
!>
!> Cells with few particles, or one that has just entered, have (nearly) singular matrices. A cell matrix M is used as it is if M -
!> floor D is positive definite, D being its lumped matrix; else (1 - floor) M + floor D replaces it. All eigenvalues of D^-1 M are
!> then at least `eigenvalue_floor`: nodal values are at most 1/floor times the lumped ones in the norm of D
!> (docs/explanation/mass.md).
!>
!> A quadratic cell is stored as four elements, its quarters, consecutively, with one matrix of its nine nodes. Where such cells are
!> cut the functions of some nodes have integrals below 0: nothing is lumped, the ghost penalty (`hampm_ghost_penalty`) adds masses,
!> and residuals are weighted by the diagonal of M, as around an axis, where the integrals of functions of nodes on it are 0.
module hampm_mass_matrix
   use hampm_kinds, only: dp, ndim
   use hampm_grid, only: grid_t
   use hampm_jumps, only: jump_t
   use hampm_node_list, only: node_list_t, list_marked
   use hampm_nodal_rows, only: pattern_t, spans_t, find_spans, sum_rows
   implicit none
   private
   public :: lump_at, mass_matrix_t, region_t, find_coupled_region, prepare_cell, coupled_cells, has_matrix, &
             clear_empty_cells, invert_lumped, assemble, eigenvalue_floor, floor_of_domains, floor_of_quadratic, nodes_per_chunk

   real(dp), parameter :: eigenvalue_floor = merge(0.05_dp, 0.0112_dp, ndim == 2) !! below 4**(-ndim), of four or eight particles
   !> The same with domains, whose corners enter a cell one by one: lumping takes spin from material that turns, and the equations
   !> are solved as well (docs/explanation/domains.md)
   real(dp), parameter :: floor_of_domains = 1e-3_dp
   !> The same of quadratic cells
   real(dp), parameter :: floor_of_quadratic = 0.02_dp

   !> Sums over nodes are taken over chunks of this many nodes first, so that they do not depend on the number of threads.
   integer, parameter :: nodes_per_chunk = 512

   !> Some nodes, the hanging nodes of which they are masters, and the elements around all these, each ascending.
   type, extends(node_list_t) :: region_t
      integer :: n_cells = 0
      integer, allocatable :: cells(:)                  !! elements, (n_cells or more)
   end type region_t

   !> The matrix, and the data to multiply by it.
   type :: mass_matrix_t
      integer :: layout = 0                             !! how often the occupied cells have been listed anew
      logical :: is_solved = .false.                    !! whether equations are solved with M, else it is multiplied by
      type(region_t) :: all                             !! the occupied cells and their nodes
      type(region_t) :: coupled                         !! the nodes of cells that are not lumped, and the occupied cells
                                                        !! around them, each as its first element
      integer :: quarters = 1                           !! elements of a cell
      type(spans_t) :: spans                            !! its nodes, hanging nodes included, in chunks of
                                                        !! `nodes_per_chunk`
      integer, allocatable :: apart(:)                  !! the other nodes
      real(dp), allocatable :: lumped(:)                !! D, (9) [kg], (n_points)
      type(jump_t), allocatable :: ghosts(:)            !! with masses beside those of the cells; not allocated if all is lumped
      real(dp), allocatable :: diagonal(:)              !! of M [kg], (n_points); not allocated where D is above 0 everywhere
      real(dp), allocatable :: inverse_lumped(:)        !! D^-1 at the nodes of occupied cells [1/kg], (n_points)
      ! By cells (`cell_of`), not allocated where all is lumped
      real(dp), allocatable :: cell(:, :, :)            !! M [kg], (nodes of a cell, nodes of a cell, cells)
      real(dp), allocatable :: cell_lumped(:, :)        !! D [kg], (nodes of a cell, cells)
      real(dp), allocatable :: lumped_fraction(:)       !! part that is lumped, 0 to 1, (cells)
      integer, allocatable :: copies(:, :)              !! of each node for bodies that meet (`copies_of_nodes` of the grid): where
                                                        !! several have mass, all is lumped; not allocated without such bodies
      real(dp), allocatable :: lumped_apart(:)          !! `lumped_fraction` of cells in which no bodies meet
      logical, allocatable :: may_hang(:)               !! whether nodes may hang, (cells); not allocated if all is lumped
      real(dp), allocatable :: cell_inverse(:, :, :)    !! D_e M_e^-1 D_e by cells [kg], as `cell`; not allocated where
                                                        !! lumped masses need no solution with it
      integer :: version = 0                            !! how often the rows have been summed
      logical :: stays = .false.                        !! whether the masses of cells stay from step to step
      logical :: assembled = .false.                    !! whether the rows are the sums of the cells
      type(pattern_t) :: pattern                        !! of the rows
      real(dp), allocatable :: row(:, :)                !! M by rows of the coupled region [kg], (width, n_points)
      real(dp), allocatable :: inverse_row(:, :)        !! sum of D_e M_e^-1 D_e by such rows [kg]
   contains
      procedure :: cell_of
      procedure :: begins_cell
   end type mass_matrix_t

contains

   !> The cell to which an element belongs.
   elemental integer function cell_of(matrix, e)
      class(mass_matrix_t), intent(in) :: matrix
      integer, intent(in) :: e
      cell_of = (e - 1)/matrix%quarters + 1
   end function cell_of

   !> Whether an element is the first of its cell. Where a cell has material its first element has.
   elemental logical function begins_cell(matrix, e)
      class(mass_matrix_t), intent(in) :: matrix
      integer, intent(in) :: e
      begins_cell = mod(e - 1, matrix%quarters) == 0
   end function begins_cell

   !> The cells whose matrix is not lumped, each as its first element, ascending.
   pure function coupled_cells(matrix) result(cells)
      type(mass_matrix_t), intent(in) :: matrix
      integer, allocatable :: cells(:)
      associate (occupied => matrix%all%cells(:matrix%all%n_cells))
         cells = pack(occupied, has_matrix(matrix, occupied))
      end associate
   end function coupled_cells

   !> Whether with an element begins a cell that has a matrix that is not lumped.
   elemental logical function has_matrix(matrix, e)
      type(mass_matrix_t), intent(in) :: matrix
      integer, intent(in) :: e
      has_matrix = .false.
      if (allocated(matrix%lumped_fraction)) has_matrix = matrix%begins_cell(e) .and. matrix%lumped_fraction(matrix%cell_of(e)) < 1
   end function has_matrix

   !> Clear the matrices of cells without material.
   pure subroutine clear_empty_cells(n_elements, occupied, matrix)
      integer, intent(in) :: n_elements
      integer, intent(in) :: occupied(:)                !! elements, ascending
      type(mass_matrix_t), intent(inout) :: matrix
      integer :: e, k
      if (.not. allocated(matrix%cell)) return
      k = 1
      do e = 1, n_elements, matrix%quarters
         do while (k <= size(occupied))
            if (occupied(k) >= e) exit
            k = k + 1
         end do
         if (k <= size(occupied)) then
            if (occupied(k) == e) cycle
         end if
         associate (cell => matrix%cell_of(e))
            matrix%cell(:, :, cell) = 0
            matrix%cell_lumped(:, cell) = 0
            if (allocated(matrix%cell_inverse)) matrix%cell_inverse(:, :, cell) = 0
         end associate
      end do
   end subroutine clear_empty_cells

   !> Find the region in which equations are coupled, where there is a matrix that is not lumped.
   subroutine find_coupled_region(grid, matrix)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(inout) :: matrix
      logical, allocatable :: is_coupled(:)
      integer, allocatable :: cells(:)
      integer :: k
      matrix%layout = matrix%layout + 1
      if (.not. allocated(matrix%lumped_fraction)) return
      if (allocated(matrix%copies)) call lump_where_bodies_meet(grid, matrix)
      allocate (is_coupled(grid%n_points), source=.false.)
      cells = coupled_cells(matrix)
      do k = 1, size(cells)
         is_coupled(grid%support_of(cells(k))) = .true.
      end do
      call grid%dofs%mark_masters(is_coupled)
      call list_marked(grid%n_nodes, is_coupled, matrix%coupled)
      associate (nodes => matrix%all%nodes(:matrix%all%n_nodes), occupied => matrix%all%cells(:matrix%all%n_cells))
         matrix%apart = pack(nodes, .not. is_coupled(nodes))
         cells = pack(occupied, matrix%begins_cell(occupied))
      end associate
      matrix%coupled%cells = pack(cells, [(any(is_coupled(grid%support_of(cells(k)))), k=1, size(cells))])
      matrix%coupled%n_cells = size(matrix%coupled%cells)
      associate (region => matrix%coupled)
         call find_spans(matrix%pattern, region%nodes(:region%n_points), nodes_per_chunk, matrix%spans)
      end associate
   end subroutine find_coupled_region

   !> Lump the cells around some nodes, but no quadratic ones that are cut: integrals of their functions may be below 0.
   subroutine lump_at(matrix, grid, nodes)
      type(mass_matrix_t), intent(inout) :: matrix
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: nodes(:)
      integer, allocatable :: elements(:)
      integer :: k, i
      if (.not. allocated(matrix%lumped_fraction)) return
      do k = 1, size(nodes)
         elements = grid%dofs%elements_at(nodes(k))
         if (allocated(grid%correction)) &
            elements = pack(elements, [(all(.not. abs(grid%correction(:, :, (elements(i) - 1)/matrix%quarters + 1)) > 0), &
                                        i=1, size(elements))])
         associate (cells => matrix%cell_of(elements))
            matrix%lumped_fraction(cells) = 1
            if (allocated(matrix%lumped_apart)) matrix%lumped_apart(cells) = 1
         end associate
      end do
   end subroutine lump_at

   !> Lump the cells around nodes at which several bodies have mass: an impulse between the copies of a node then moves only these.
   subroutine lump_where_bodies_meet(grid, matrix)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(inout) :: matrix
      logical, allocatable :: is_active(:)
      integer :: node, k
      allocate (is_active(grid%n_points), source=.false.)
      is_active(matrix%all%nodes(:matrix%all%n_nodes)) = .true.
      matrix%lumped_fraction = matrix%lumped_apart
      do node = 1, size(matrix%copies, 2)
         associate (copies => matrix%copies(:, node))
            if (copies(1) == 0) cycle
            if (count(is_active(copies)) < 2) cycle
            do k = 1, size(copies)
               matrix%lumped_fraction(grid%dofs%elements_at(copies(k))) = 1
            end do
         end associate
      end do
   end subroutine lump_where_bodies_meet

   !> Lump the part `lumped_fraction` of a cell's matrix and, if equations are solved with it, what the rule above requires. The
   !> lumped part is put on the diagonal; if nodes of the cell may hang it is left out, for `assemble` to put it on the diagonal of
   !> the nodes.
   pure subroutine prepare_cell(n, lumped_fraction, is_solved, may_hang, m, least)
      integer, intent(in) :: n                   !! nodes of the cell
      real(dp), intent(in) :: lumped_fraction    !! 0: consistent, 1: lumped
      logical, intent(in) :: is_solved           !! else it is only multiplied by
      logical, intent(in) :: may_hang            !! some node
      real(dp), intent(inout) :: m(n, n)
      real(dp), intent(in), optional :: least    !! eigenvalue, instead of `eigenvalue_floor`
      real(dp) :: diagonal(n), floor
      if (lumped_fraction <= 0 .and. .not. is_solved) return
      diagonal = sum(m, dim=2)
      if (may_hang) diagonal = 0
      if (lumped_fraction > 0) call lump(n, lumped_fraction, diagonal, m)
      if (lumped_fraction < 1 .and. is_solved) then
         floor = eigenvalue_floor
         if (present(least)) floor = least
         if (may_hang .or. .not. is_well_determined(n, floor, diagonal, m)) call lump(n, floor, diagonal, m)
      end if
   end subroutine prepare_cell

   !> m <- (1 - lumped_fraction) m + lumped_fraction diag(diagonal).
   pure subroutine lump(n, lumped_fraction, diagonal, m)
      integer, intent(in) :: n
      real(dp), intent(in) :: lumped_fraction, diagonal(n)
      real(dp), intent(inout) :: m(n, n)
      integer :: c
      m = (1 - lumped_fraction)*m
      do c = 1, n
         m(c, c) = m(c, c) + lumped_fraction*diagonal(c)
      end do
   end subroutine lump

   !> Whether m - floor diag(diagonal) is positive definite up to rounding: elimination finds positive pivots only. A cell on an
   !> axis with two by two particles has the least eigenvalue 1/20.
   pure logical function is_well_determined(n, floor, diagonal, m) result(well)
      integer, intent(in) :: n
      real(dp), intent(in) :: floor, diagonal(n), m(n, n)
      real(dp), parameter :: rounding = 1e-9_dp
      real(dp) :: rest(n, n), factor
      integer :: i, j, c
      rest = m
      do c = 1, n
         rest(c, c) = rest(c, c) - floor*(1 - rounding)*diagonal(c)
      end do
      well = rest(1, 1) > 0
      do c = 1, n - 1
         if (.not. well) return
         do j = c + 1, n
            factor = rest(j, c)/rest(c, c)
            do i = j, n
               rest(i, j) = rest(i, j) - factor*rest(i, c)
            end do
         end do
         well = rest(c + 1, c + 1) > 0
      end do
   end function is_well_determined

   !> Find the inverse of the lumped matrix; 0 at nodes of quadratic cells without lumped mass: on an axis, or where functions of
   !> cut cells cancel up to rounding.
   subroutine invert_lumped(matrix, is_quadratic)
      type(mass_matrix_t), intent(inout) :: matrix
      logical, intent(in) :: is_quadratic        !! whether cells are
      real(dp), parameter :: rounding = 1e-14_dp
      real(dp) :: least
      integer :: a
      least = 0
      if (is_quadratic) least = rounding*maxval(matrix%lumped(matrix%all%nodes(:matrix%all%n_nodes)))
      associate (nodes => matrix%all%nodes)
         !$omp parallel do schedule(static)
         !GCC$ novector
         do a = 1, matrix%all%n_nodes
            matrix%inverse_lumped(nodes(a)) = 0
            if (abs(matrix%lumped(nodes(a))) > least) matrix%inverse_lumped(nodes(a)) = 1/matrix%lumped(nodes(a))
         end do
      end associate
   end subroutine invert_lumped

   !> Sum the cells into the rows of the coupled region, if they have changed.
   subroutine assemble(grid, matrix)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(inout) :: matrix
      integer :: k
      if (matrix%assembled .or. .not. allocated(matrix%cell)) return
      associate (region => matrix%coupled)
         call sum_rows(matrix%pattern, region%n_points, region%nodes, matrix%cell, matrix%row)
         if (allocated(matrix%cell_inverse)) then
            !$omp parallel do schedule(static)
            do k = 1, region%n_cells
               associate (cell => matrix%cell_of(region%cells(k)))
                  call invert_cell(size(matrix%cell, 1), matrix%cell_lumped(1, cell), matrix%cell(1, 1, cell), &
                                   matrix%cell_inverse(1, 1, cell))
               end associate
            end do
            call sum_rows(matrix%pattern, region%n_points, region%nodes, matrix%cell_inverse, matrix%inverse_row)
         end if
      end associate
      if (grid%dofs%n_hanging > 0) call add_left_out(grid, matrix)
      if (allocated(matrix%diagonal)) call find_diagonal(grid, matrix)
      matrix%assembled = .true.
      matrix%version = matrix%version + 1
   end subroutine assemble

   !> Find the diagonal of M at the nodes of the coupled region, with the contribution of each hanging node by itself.
   subroutine find_diagonal(grid, matrix)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(inout) :: matrix
      integer :: k, j
      matrix%diagonal = matrix%row(1, :)
      associate (region => matrix%coupled, dofs => grid%dofs)
         do k = region%n_nodes + 1, region%n_points
            associate (hanging => region%nodes(k))
               do j = dofs%first_master(hanging - dofs%n_nodes), dofs%first_master(hanging - dofs%n_nodes + 1) - 1
                  associate (total => matrix%diagonal(dofs%master(j)))
                     total = total + dofs%weight(j)**2*matrix%row(1, hanging)
                  end associate
               end do
            end associate
         end do
      end associate
      do k = 1, size(matrix%ghosts)
         associate (point => matrix%ghosts(k))
            do j = 1, count(point%node > 0)
               matrix%diagonal(point%node(j)) = matrix%diagonal(point%node(j)) + point%mass*point%share(j)**2
            end do
         end associate
      end do
   end subroutine find_diagonal

   !> Put the lumped parts of cells whose nodes may hang on the diagonals of the rows: they go to nodes first.
   subroutine add_left_out(grid, matrix)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(inout) :: matrix
      real(dp), allocatable :: lumped(:)
      integer :: nodes(grid%n_functions), k, a
      allocate (lumped(grid%n_points), source=0.0_dp)
      do k = 1, matrix%all%n_cells
         associate (e => matrix%all%cells(k))
            if (.not. matrix%begins_cell(e)) cycle
            associate (cell => matrix%cell_of(e))
               if (.not. matrix%may_hang(cell)) cycle
               nodes = grid%support_of(e)
               lumped(nodes) = lumped(nodes) + max(matrix%cell_lumped(:, cell) - sum(matrix%cell(:, :, cell), dim=1), 0.0_dp)
            end associate
         end associate
      end do
      call grid%dofs%condense(matrix%all, 1, lumped)
      associate (region => matrix%coupled)
         do a = 1, region%n_nodes
            associate (i => region%nodes(a))
               matrix%row(1, i) = matrix%row(1, i) + lumped(i)
               if (allocated(matrix%inverse_row)) matrix%inverse_row(1, i) = matrix%inverse_row(1, i) + lumped(i)
            end associate
         end do
      end associate
   end subroutine add_left_out

   !> D M^-1 D of a cell's matrix M, D being its lumped matrix, by Gauss-Jordan elimination in place. The part of M that has been
   !> left out, as where nodes of the cell may hang, is put on its diagonal.
   pure subroutine invert_cell(n, diagonal, m, inverse)
      integer, intent(in) :: n
      real(dp), intent(in) :: diagonal(n), m(n, n)
      real(dp), intent(out) :: inverse(n, n)
      real(dp) :: a(n, n), column(n), row(n)
      integer :: c, k
      a = m
      do c = 1, n
         a(c, c) = a(c, c) + max(diagonal(c) - sum(m(:, c)), 0.0_dp)
      end do
      do k = 1, n
         column = a(:, k)
         a(:, k) = 0
         a(k, k) = 1
         row = a(k, :)/column(k)
         column(k) = 0
         do c = 1, n
            a(:, c) = a(:, c) - row(c)*column
            a(k, c) = row(c)
         end do
      end do
      do c = 1, n
         inverse(:, c) = diagonal(c)*diagonal*a(:, c)
      end do
   end subroutine invert_cell
end module hampm_mass_matrix
