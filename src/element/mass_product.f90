!> Products with the whole mass matrix of a run, from its cells and the lumped masses:
!>
!>    M = sum over the cells that are not lumped of T^T M_e T + diag(c),
!>
!> T being the weights of hanging nodes, c the rest of the lumped masses of the nodes; and with the masses of interface points.
module hampm_mass_product
   use hampm_kinds, only: dp, ndim
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: mass_matrix_t, coupled_cells
   use hampm_jumps, only: add_mass_product
   implicit none
   private
   public :: find_concentrated_mass, multiply_by_mass, by_mass, by_mass_at

contains

   !> The part c of the nodes' masses that is on the diagonal beside the matrices of the cells [kg], (n_points).
   pure subroutine find_concentrated_mass(grid, matrix, mass)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), allocatable, intent(out) :: mass(:)
      integer, allocatable :: cells(:)
      integer :: nodes(grid%n_functions), k
      allocate (mass(grid%n_points), source=0.0_dp)
      associate (all => matrix%all)
         allocate (cells, source=coupled_cells(matrix))
         do k = 1, size(cells)
            nodes = grid%support_of(cells(k))
            associate (cell => matrix%cell_of(cells(k)))
               mass(nodes) = mass(nodes) + sum(matrix%cell(:, :, cell), dim=1)
            end associate
         end do
         call grid%dofs%condense(all, 1, mass)
         do k = 1, all%n_nodes
            mass(all%nodes(k)) = matrix%lumped(all%nodes(k)) - mass(all%nodes(k))
         end do
      end associate
   end subroutine find_concentrated_mass

   !> y = M x at the nodes, 0 at hanging ones. Values of `x` are there at the hanging nodes too.
   pure subroutine multiply_by_mass(grid, matrix, mass, x, y)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: mass(:)            !! c [kg], (n_points)
      real(dp), intent(in), contiguous :: x(:, :) !! (ndim, n_points)
      real(dp), intent(out), contiguous :: y(:, :) !! (ndim, n_points)
      integer, allocatable :: cells(:)
      integer :: at(grid%n_functions), k, c, b
      real(dp) :: unused(ndim)
      y = 0
      associate (all => matrix%all)
         allocate (cells, source=coupled_cells(matrix))
         do k = 1, size(cells)
            at = grid%support_of(cells(k))
            associate (cell => matrix%cell_of(cells(k)))
               do c = 1, size(at)
                  do b = 1, size(at)
                     y(:, at(c)) = y(:, at(c)) + matrix%cell(b, c, cell)*x(:, at(b))
                  end do
               end do
            end associate
         end do
         call grid%dofs%condense(all, ndim, y)
         do k = 1, all%n_nodes
            do c = 1, ndim
               y(c, all%nodes(k)) = y(c, all%nodes(k)) + mass(all%nodes(k))*x(c, all%nodes(k))
            end do
         end do
         if (allocated(matrix%ghosts)) call add_mass_product(matrix%ghosts, x, y, unused)
      end associate
   end subroutine multiply_by_mass

   !> Product of the mass matrix with values of all components: M x, 0 at hanging nodes. (ndim, n_points)
   pure function by_mass(grid, matrix, x) result(y)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: x(:, :) !! also at hanging nodes, (ndim, n_points)
      real(dp), allocatable :: y(:, :), concentrated(:)
      allocate (y(ndim, grid%n_points))
      call find_concentrated_mass(grid, matrix, concentrated)
      call multiply_by_mass(grid, matrix, concentrated, x, y)
   end function by_mass

   !> The same at some nodes. (ndim, these nodes)
   pure function by_mass_at(grid, matrix, nodes, x) result(y)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      integer, intent(in) :: nodes(:)
      real(dp), intent(in), contiguous :: x(:, :) !! also at hanging nodes, (ndim, n_points)
      real(dp) :: y(ndim, size(nodes))
      real(dp), allocatable :: all(:, :)
      if (allocated(matrix%cell)) then
         allocate (all, source=by_mass(grid, matrix, x))
         y = all(:, nodes)
      else
         y = spread(matrix%lumped(nodes), 1, ndim)*x(:, nodes)
      end if
   end function by_mass_at
end module hampm_mass_product
