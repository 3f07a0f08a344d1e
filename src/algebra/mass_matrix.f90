!> The mass matrix (6) by cells: each occupied cell has the small matrix of its corners, sum of m_p N_i N_j over its
!> particles, in which part of it may be lumped. Row sums, and so mass and momentum, are always those of (9).
!>
!> Cells whose particles hardly determine the values at their corners are normal in the material point method: one that a
!> particle has just entered, or one with fewer particles than corners. Their matrix is singular or nearly so. The rule:
!> a cell matrix M is used as it is where M - floor D is positive definite, D being its lumped matrix; elsewhere
!> (1 - floor) M + floor D takes its place. All eigenvalues of D^-1 M are then at least `eigenvalue_floor`, of every cell
!> and so of the whole matrix: nothing is divided by a mass that is not there, and nodal values are at most 1/floor times
!> the lumped ones. Four particles at the quarter points, with the eigenvalue 1/16, are used as they are.
module hampm_mass_matrix
   use hampm_kinds, only: dp, ndim, corners
   implicit none
   private
   public :: mass_matrix_t, prepare_cell, coupled_cells, multiply_cells, gather_slots, eigenvalue_floor

   real(dp), parameter :: eigenvalue_floor = 0.05_dp

   !> The matrix with what is needed to multiply by it.
   type :: mass_matrix_t
      integer :: n_active = 0                           !! number of nodes of occupied cells
      integer, allocatable :: active(:)                 !! these, ascending
      integer :: n_cells = 0                            !! number of occupied cells
      integer, allocatable :: cells(:)                  !! these, ascending
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
      cells = pack(matrix%cells(:matrix%n_cells), matrix%blend(matrix%cells(:matrix%n_cells)) < 1)
   end function coupled_cells

   !> Lump the part `blend` of a cell's matrix, and what the rule above asks for.
   pure subroutine prepare_cell(blend, m)
      real(dp), intent(in) :: blend              !! 0: full, 1: lumped
      real(dp), intent(inout) :: m(corners, corners)
      real(dp) :: diagonal(corners)
      diagonal = sum(m, dim=2)
      if (blend > 0) call lump(blend, diagonal, m)
      if (blend < 1) then
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

   !> Whether m - floor diag(diagonal) is positive definite: whether its Cholesky factorisation exists.
   pure logical function is_well_determined(diagonal, m) result(well)
      real(dp), intent(in) :: diagonal(corners), m(corners, corners)
      real(dp) :: l(corners, corners), pivot
      integer :: i, j
      well = .false.
      do j = 1, corners
         pivot = m(j, j) - eigenvalue_floor*diagonal(j) - sum(l(j, :j - 1)**2)
         if (.not. pivot > 0) return
         l(j, j) = sqrt(pivot)
         do i = j + 1, corners
            l(i, j) = (m(i, j) - sum(l(i, :j - 1)*l(j, :j - 1)))/l(j, j)
         end do
      end do
      well = .true.
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

   !> Nodal vectors from the cells' shares, always summed in the order of the cells.
   subroutine gather_slots(n_active, active, node_slot, share, nodal)
      integer, intent(in) :: n_active, active(n_active) !! nodes to sum for
      integer, intent(in) :: node_slot(corners, *)      !! see `grid_t`
      real(dp), intent(in) :: share(ndim, 0:*)          !! by slot
      real(dp), intent(inout) :: nodal(ndim, *)         !! by node
      integer :: a, c
      real(dp) :: total(ndim)
      !$omp parallel do schedule(static) private(total, c)
      do a = 1, n_active
         total = 0
         do c = 1, corners
            total = total + share(:, node_slot(c, active(a)))
         end do
         nodal(:, active(a)) = total
      end do
   end subroutine gather_slots
end module hampm_mass_matrix
