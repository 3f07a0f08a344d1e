!> Values by leaf from values by node or particle.
module hampm_cell_values
   use hampm_kinds, only: dp, corners
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_grid, only: grid_t
   implicit none
   private
   public :: mean_of_nodes, is_occupied, sum_over_particles

contains

   !> Mean of nodal values over the nodes of a leaf, of all its pieces where it is cut: its corners and the nodes in the middle of
   !> its sides, without hanging nodes, whose values are means of others; over these if there are no others.
   pure real(dp) function mean_of_nodes(grid, leaf, nodal) result(mean)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf
      real(dp), intent(in) :: nodal(:)           !! (n_points)
      integer :: node(corners*(grid%leaf_element(leaf + 1) - grid%leaf_element(leaf))), n, e, c
      logical :: counts(size(node))
      n = 0
      do e = grid%leaf_element(leaf), grid%leaf_element(leaf + 1) - 1
         do c = 1, corners
            associate (point => grid%element_nodes(c, e))
               if (any(node(:n) == point)) cycle
               n = n + 1
               node(n) = point
            end associate
         end do
      end do
      counts(:n) = node(:n) <= grid%n_nodes
      if (.not. any(counts(:n))) counts(:n) = .true.
      mean = sum(nodal(node(:n)), mask=counts(:n))/count(counts(:n))
   end function mean_of_nodes

   !> Whether there are particles in a leaf.
   pure logical function is_occupied(grid, blocks, leaf)
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: leaf
      is_occupied = any(blocks%count_in(grid%leaf_element(leaf):grid%leaf_element(leaf + 1) - 1) > 0)
   end function is_occupied

   !> Sum of a value over the particles of a leaf.
   pure real(dp) function sum_over_particles(grid, blocks, leaf, value) result(total)
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: leaf
      real(dp), intent(in) :: value(:)           !! (n)
      integer :: e, i
      total = 0
      do e = grid%leaf_element(leaf), grid%leaf_element(leaf + 1) - 1
         do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
            total = total + value(i)
         end do
      end do
   end function sum_over_particles
end module hampm_cell_values
