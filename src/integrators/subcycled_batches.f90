!> What has its turns together with subcycling (`hampm_step_groups`): blocks of cells side by side, which
!> a pass takes at once.
module hampm_subcycled_batches
   use hampm_cell_blocks, only: cell_blocks_t, lanes
   use hampm_step_groups, only: plain
   implicit none
   private
   public :: batch_t, find_batches

   !> Blocks side by side whose cells have their turns together.
   type :: batch_t
      integer :: group = 0
      integer :: role = plain                    !! the highest of the roles of its cells: all are treated so
      integer :: kick_interval = 0               !! when the first of its cells get forces
      integer :: velocity_interval = 0           !! and when the velocity of the first of their corners changes
      integer :: blocks(2) = 0                   !! the first and the last
   end type batch_t

contains

   !> Find the batches of the blocks.
   pure subroutine find_batches(blocks, batches)
      type(cell_blocks_t), intent(in) :: blocks
      type(batch_t), allocatable, intent(out) :: batches(:)
      type(batch_t), allocatable :: found(:)
      type(batch_t) :: next
      integer :: b, n
      allocate (found(blocks%n))
      n = 0
      do b = 1, blocks%n
         next = batch_of_block(blocks, b)
         if (n > 0) then
            if (found(n)%group == next%group .and. found(n)%role == next%role) then
               found(n)%blocks(2) = b
               found(n)%kick_interval = min(found(n)%kick_interval, next%kick_interval)
               found(n)%velocity_interval = min(found(n)%velocity_interval, next%velocity_interval)
               cycle
            end if
         end if
         n = n + 1
         found(n) = next
      end do
      batches = found(:n)
   end subroutine find_batches

   !> A batch of one block.
   pure type(batch_t) function batch_of_block(blocks, b) result(batch)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: b
      integer :: l, e
      batch%blocks = b
      batch%group = blocks%groups%of_cell(blocks%cells(1, b))
      batch%kick_interval = batch%group
      batch%velocity_interval = batch%group
      do l = 1, lanes
         e = blocks%cells(l, b)
         if (e == 0) exit
         batch%role = max(batch%role, blocks%groups%role(e))
         batch%kick_interval = min(batch%kick_interval, blocks%groups%kick_interval(e))
         batch%velocity_interval = min(batch%velocity_interval, minval(blocks%groups%velocity_interval(blocks%nodes(:, l, b))))
      end do
   end function batch_of_block
end module hampm_subcycled_batches
