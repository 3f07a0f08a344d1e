!> Quadratic cells as the indicators look at them: fields have values at the corners of cells, as in bilinear cells of the same size.
!> The other nodes of a cell, in the middle of its sides and inside it, get what follows from its corners. One in the middle of a
!> side that is a corner of finer cells has a value of its own, as in the bilinear transition element.
!>
!> In a grid of bilinear cells all nodes are corners, and nothing here has anything to do.
module hampm_corner_values
   use hampm_kinds, only: dp, corners
   use hampm_basis, only: points_of_quadratic
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_grid, only: grid_t
   implicit none
   private
   public :: are_corners, gather_at_corners, spread_from_corners, sides_of_cell, middle_of_cell

   !> Of the points of a quadratic cell, along x one after the other: a node in the middle of each side, and the ends of that
   integer, parameter :: sides_of_cell(3, 4) = reshape([2, 1, 3, 4, 1, 7, 6, 3, 9, 8, 7, 9], [3, 4])
   integer, parameter :: middle_of_cell = 5

contains

   !> Whether each point is a corner of a cell with particles; all points of bilinear cells are taken for such.
   pure function are_corners(grid, blocks) result(is_corner)
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      logical :: is_corner(grid%n_points)
      integer :: e, q
      is_corner = .not. grid%is_quadratic()
      if (.not. grid%is_quadratic()) return
      do e = 1, grid%n_elements, corners
         if (all(blocks%count_in(e:e + corners - 1) == 0)) cycle
         do q = 1, corners
            is_corner(grid%element_nodes(q, e + q - 1)) = .true.
         end do
      end do
   end function are_corners

   !> Give sums at the other points, as masses are, to the corners: those in the middle of a cell to its sides, those of sides to
   !> their ends.
   pure subroutine gather_at_corners(grid, is_corner, sums)
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: is_corner(:)
      real(dp), intent(inout) :: sums(:)         !! (n_points)
      integer :: at(points_of_quadratic), e, k
      if (.not. grid%is_quadratic()) return
      do e = 1, grid%n_elements, corners
         at = grid%support_of(e)
         sums(at(sides_of_cell(1, :))) = sums(at(sides_of_cell(1, :))) + sums(at(middle_of_cell))/4
         sums(at(middle_of_cell)) = 0
      end do
      do e = 1, grid%n_elements, corners
         at = grid%support_of(e)
         do k = 1, size(sides_of_cell, 2)
            associate (middle => at(sides_of_cell(1, k)), ends => at(sides_of_cell(2:, k)))
               if (is_corner(middle)) cycle
               sums(ends) = sums(ends) + sums(middle)/2
               sums(middle) = 0                  ! the cell on the other side of it has nothing left to give
            end associate
         end do
      end do
   end subroutine gather_at_corners

   !> Give the other points the mean of the ends of their side, and those in the middle of cells that of their sides: the function
   !> that is bilinear in the cell.
   pure subroutine spread_from_corners(grid, is_corner, values)
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: is_corner(:)
      real(dp), intent(inout) :: values(:)       !! (n_points)
      integer :: at(points_of_quadratic), e, k
      if (.not. grid%is_quadratic()) return
      do e = 1, grid%n_elements, corners
         at = grid%support_of(e)
         do k = 1, size(sides_of_cell, 2)
            associate (middle => at(sides_of_cell(1, k)), ends => at(sides_of_cell(2:, k)))
               if (.not. is_corner(middle)) values(middle) = sum(values(ends))/2
            end associate
         end do
         values(at(middle_of_cell)) = sum(values(at(sides_of_cell(1, :))))/4
      end do
   end subroutine spread_from_corners
end module hampm_corner_values
