!> Which cells take which time step, where it fits their size: cells of group g take 2**g of the finest steps at once.
!>
!> A cell's group is the binary logarithm of its size over the smallest one with particles. Next to cells of the next finer group a
!> layer of cells takes the step of that group: a buffer, without which the stable step would be shorter. So groups of cells that
!> share a node differ by one at most.
!>
!> The intervals of nodes follow: a node gets forces as often as the finest cell around it exerts them, and its velocity changes as
!> often as the velocity of any particle around it is known to.
module hampm_step_groups
   use hampm_grid, only: grid_t
   implicit none
   private
   public :: step_groups_t, find_groups, limit_groups

   !> Groups and, as exponents of 2, the intervals in finest steps. A turn of g comes every 2**g of these.
   type :: step_groups_t
      integer :: largest = 0                     !! group of the coarsest cells
      integer, allocatable :: by_size(:)         !! group of each cell with particles, (n_elements)
      integer, allocatable :: of_cell(:)         !! the same, not above a limit, (n_elements)
      integer, allocatable :: kick_interval(:)   !! when forces meet a node of the cell, (n_elements)
      integer, allocatable :: force_interval(:)  !! when forces act on a node, (n_points)
      integer, allocatable :: velocity_interval(:) !! when the velocity of a node changes, (n_points)
   end type step_groups_t

contains

   !> Find the groups of the cells with particles.
   pure subroutine find_groups(grid, occupied, groups)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: occupied(:)         !! cells with particles
      type(step_groups_t), intent(inout) :: groups
      integer, allocatable :: least(:)           ! group at a point
      integer :: k, finest
      if (allocated(groups%by_size)) deallocate (groups%by_size, groups%of_cell, groups%kick_interval, &
                                                 groups%force_interval, groups%velocity_interval)
      allocate (groups%by_size(grid%n_elements), groups%of_cell(grid%n_elements), groups%kick_interval(grid%n_elements), &
                source=0)
      allocate (least(grid%n_points), groups%force_interval(grid%n_points), groups%velocity_interval(grid%n_points), source=0)
      finest = exponent(minval(grid%element_size(occupied)))
      do k = 1, size(occupied)
         groups%by_size(occupied(k)) = exponent(grid%element_size(occupied(k))) - finest
      end do
      call least_at_points(grid, occupied, groups%by_size, least)
      do k = 1, size(occupied)
         associate (e => occupied(k))
            if (minval(least(grid%element_nodes(:, e))) < groups%by_size(e)) groups%by_size(e) = groups%by_size(e) - 1
         end associate
      end do
      groups%largest = maxval(groups%by_size(occupied))
      call limit_groups(grid, occupied, groups%largest, groups)
   end subroutine find_groups

   !> Limit the steps of cells to the step of a group, and find the intervals.
   pure subroutine limit_groups(grid, occupied, limit, groups)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: occupied(:)
      integer, intent(in) :: limit
      type(step_groups_t), intent(inout) :: groups
      integer :: k
      groups%of_cell = min(groups%by_size, limit)
      call least_at_points(grid, occupied, groups%of_cell, groups%force_interval)
      do k = 1, size(occupied)
         groups%kick_interval(occupied(k)) = minval(groups%force_interval(grid%element_nodes(:, occupied(k))))
      end do
      call least_at_points(grid, occupied, groups%kick_interval, groups%velocity_interval)
   end subroutine limit_groups

   !> The least value of the cells around each node. Those around a hanging node are around its masters, too, and its value is the
   !> least of theirs.
   pure subroutine least_at_points(grid, occupied, value, least)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: occupied(:)
      integer, intent(in) :: value(:)            !! by element
      integer, intent(out) :: least(:)           !! by node, hanging nodes included; huge where there are no particles
      integer :: k, c, i
      least = huge(least)
      do k = 1, size(occupied)
         do c = 1, size(grid%element_nodes, 1)
            i = grid%element_nodes(c, occupied(k))
            least(i) = min(least(i), value(occupied(k)))
         end do
      end do
      call grid%dofs%share_least(least)
   end subroutine least_at_points
end module hampm_step_groups
