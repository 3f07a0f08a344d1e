!> The mass matrix (6) by cells: each occupied cell has the small matrix of its corners, sum of m_p N_i N_j over its
!> particles, in which part of it may be lumped. Row sums, and so mass and momentum, are always those of (9).
!>
!> Cells whose particles hardly determine the values at their corners are normal in the material point method: one that a
!> particle has just entered, or one with fewer particles than corners. Their matrix is singular or nearly so. The rule:
!> a cell matrix M is used as it is where M - floor D is positive definite, D being its lumped matrix; elsewhere
!> (1 - floor) M + floor D takes its place. All eigenvalues of D^-1 M are then at least `eigenvalue_floor`, of every cell
!> and so of the whole matrix: nothing is divided by a mass that is not there, and in the norm of D nodal values are at most
!> 1/floor times the lumped ones. Four particles at the quarter points, with the eigenvalue 1/16, are used as they are.
module hampm_mass_matrix
   use hampm_kinds, only: dp, ndim, corners
   use hampm_grid, only: grid_t
   implicit none
   private
   public :: mass_matrix_t, region_t, find_coupled_region, prepare_cell, coupled_cells, multiply_cells, gather_slots, &
             eigenvalue_floor, nodes_per_block

   real(dp), parameter :: eigenvalue_floor = 0.05_dp

   !> Sums over nodes are taken over blocks of this many nodes first, so that they do not depend on the number of threads.
   integer, parameter :: nodes_per_block = 512

   !> Some nodes, the dependent points of which they are parents, and the elements around all these, each ascending.
   type :: region_t
      integer :: n_nodes = 0
      integer :: n_points = 0
      integer, allocatable :: nodes(:)                  !! nodes and, after these, dependent points, (n_points)
      integer :: n_cells = 0
      integer, allocatable :: cells(:)
   end type region_t

   !> The matrix with what is needed to multiply by it.
   type :: mass_matrix_t
      integer :: layout = 0                             !! how often the occupied cells have been listed anew
      logical :: is_solved = .false.                    !! whether equations are solved with M, else it is multiplied by
      type(region_t) :: all                             !! the occupied cells and their nodes
      type(region_t) :: coupled                         !! the nodes of cells that are not lumped, and the occupied cells
                                                        !! around them
      real(dp), allocatable :: lumped(:)                !! D, (9) [kg], (n_nodes)
      real(dp), allocatable :: cell(:, :, :)            !! M by cells [kg], (corners, corners, n_elements); not
                                                        !! allocated where all is lumped
      real(dp), allocatable :: blend(:)                 !! part of each cell that is lumped, 0 to 1, (n_elements);
                                                        !! not allocated where all is lumped
   end type mass_matrix_t

contains

   !> The elements whose matrix is not lumped, ascending.
   pure function coupled_cells(matrix) result(cells)
      type(mass_matrix_t), intent(in) :: matrix
      integer, allocatable :: cells(:)
      associate (occupied => matrix%all%cells(:matrix%all%n_cells))
         cells = pack(occupied, matrix%blend(occupied) < 1)
      end associate
   end function coupled_cells

   !> Find the region in which equations are coupled, where there is a matrix that is not lumped.
   subroutine find_coupled_region(grid, matrix)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(inout) :: matrix
      logical, allocatable :: is_coupled(:)
      integer :: k
      matrix%layout = matrix%layout + 1
      if (.not. allocated(matrix%blend)) return
      allocate (is_coupled(grid%n_nodes), source=.false.)
      do k = 1, matrix%all%n_cells
         associate (e => matrix%all%cells(k))
            if (matrix%blend(e) < 1) is_coupled(grid%element_nodes(:, e)) = .true.
         end associate
      end do
      associate (nodes => matrix%all%nodes(:matrix%all%n_nodes), cells => matrix%all%cells(:matrix%all%n_cells))
         matrix%coupled%nodes = pack(nodes, is_coupled(nodes))
         matrix%coupled%cells = pack(cells, [(any(is_coupled(grid%element_nodes(:, cells(k)))), k=1, size(cells))])
      end associate
      matrix%coupled%n_nodes = size(matrix%coupled%nodes)
      matrix%coupled%n_cells = size(matrix%coupled%cells)
   end subroutine find_coupled_region

   !> Lump the part `blend` of a cell's matrix and, where equations are solved with it, what the rule above asks for.
   pure subroutine prepare_cell(blend, is_solved, m)
      real(dp), intent(in) :: blend              !! 0: full, 1: lumped
      logical, intent(in) :: is_solved           !! else it is only multiplied by
      real(dp), intent(inout) :: m(corners, corners)
      real(dp) :: diagonal(corners)
      if (blend <= 0 .and. .not. is_solved) return
      diagonal = sum(m, dim=2)
      if (blend > 0) call lump(blend, diagonal, m)
      if (blend < 1 .and. is_solved) then
         if (.not. is_well_determined(diagonal, m)) call lump(eigenvalue_floor, diagonal, m)
      end if
   end subroutine prepare_cell

   !> m <- (1 - blend) m + blend diag(diagonal).
   pure subroutine lump(blend, diagonal, m)
      real(dp), intent(in) :: blend, diagonal(corners)
      real(dp), intent(inout) :: m(corners, corners)
      integer :: c
      m = (1 - blend)*m
      do c = 1, corners
         m(c, c) = m(c, c) + blend*diagonal(c)
      end do
   end subroutine lump

   !> Whether m - floor diag(diagonal) is positive definite: whether elimination finds positive pivots only.
   pure logical function is_well_determined(diagonal, m) result(well)
      real(dp), intent(in) :: diagonal(corners), m(corners, corners)
      real(dp) :: rest(corners, corners), factor
      integer :: i, j, c
      rest = m
      do c = 1, corners
         rest(c, c) = rest(c, c) - eigenvalue_floor*diagonal(c)
      end do
      well = rest(1, 1) > 0
      do c = 1, corners - 1
         if (.not. well) return
         do j = c + 1, corners
            factor = rest(j, c)/rest(c, c)
            do i = j, corners
               rest(i, j) = rest(i, j) - factor*rest(i, c)
            end do
         end do
         well = rest(c + 1, c + 1) > 0
      end do
   end function is_well_determined

   !> Products of the cell matrices with a nodal vector field, by slot (see `grid_t`).
   subroutine multiply_cells(n_cells, cells, element_nodes, matrix, x, product)
      integer, intent(in) :: n_cells, cells(n_cells)
      integer, intent(in) :: element_nodes(corners, *)
      real(dp), intent(in) :: matrix(corners, corners, *)
      real(dp), intent(in) :: x(ndim, *)                    !! by node
      real(dp), intent(inout) :: product(ndim, corners, *)  !! by element
      real(dp) :: y(ndim)
      integer :: k, e, c, r
      !$omp parallel do schedule(static) private(e, c, r, y)
      do k = 1, n_cells
         e = cells(k)
         do r = 1, corners
            y = 0
            do c = 1, corners
               y = y + matrix(c, r, e)*x(:, element_nodes(c, e))
            end do
            product(:, r, e) = y
         end do
      end do
   end subroutine multiply_cells

   !> Vectors y of some nodes from the cells' shares, always summed in the order of the cells, and x.y by component.
   pure subroutine gather_slots(n, nodes, node_slot, share, x, y, xy)
      integer, intent(in) :: n, nodes(n)
      integer, intent(in) :: node_slot(corners, *)      !! see `grid_t`
      real(dp), intent(in) :: share(ndim, 0:*)          !! by slot
      real(dp), intent(in) :: x(ndim, *)                !! by node
      real(dp), intent(inout) :: y(ndim, *)             !! by node
      real(dp), intent(out) :: xy(ndim)
      integer :: a, c
      real(dp) :: total(ndim)
      xy = 0
      do a = 1, n
         total = 0
         do c = 1, corners
            total = total + share(:, node_slot(c, nodes(a)))
         end do
         y(:, nodes(a)) = total
         xy = xy + total*x(:, nodes(a))
      end do
   end subroutine gather_slots
end module hampm_mass_matrix
