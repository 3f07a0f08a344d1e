!> Reverse Cuthill-McKee numbering (George & Liu 1981): a small bandwidth for sparse symmetric matrices.
module hampm_cuthill_mckee
   use hampm_sparse, only: sparse_t
   implicit none
   private
   public :: reverse_cuthill_mckee

contains

   !> The new place of each row. Every connected part starts at a row that is far from the others of its part.
   pure function reverse_cuthill_mckee(matrix) result(place)
      type(sparse_t), intent(in) :: matrix
      integer :: place(matrix%n)
      integer :: order(matrix%n), seed, first, last
      logical :: visited(matrix%n)
      visited = .false.
      last = 0
      do seed = 1, matrix%n
         if (visited(seed)) cycle
         first = last + 1
         call visit_breadth_first(matrix, peripheral(matrix, seed), visited, order, last)
      end do
      place(order) = [(matrix%n + 1 - first, first=1, matrix%n)]
   end function reverse_cuthill_mckee

   !> A row at the end of a longest path from `seed`: the last of a breadth-first visit, twice.
   pure integer function peripheral(matrix, seed) result(row)
      type(sparse_t), intent(in) :: matrix
      integer, intent(in) :: seed
      logical :: visited(matrix%n)
      integer :: order(matrix%n), repeat, last
      row = seed
      do repeat = 1, 2
         visited = .false.
         last = 0
         call visit_breadth_first(matrix, row, visited, order, last)
         row = order(last)
      end do
   end function peripheral

   !> Visit a connected part from `start`, neighbours of a row in the order of their degree; `order` grows from `last`.
   pure subroutine visit_breadth_first(matrix, start, visited, order, last)
      type(sparse_t), intent(in) :: matrix
      integer, intent(in) :: start
      logical, intent(inout) :: visited(:)
      integer, intent(inout) :: order(:), last
      integer :: head, i, k, m, first, j
      last = last + 1
      order(last) = start
      visited(start) = .true.
      head = last
      do while (head <= last)
         i = order(head)
         first = last + 1
         do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
            j = matrix%column(k)
            if (visited(j)) cycle
            visited(j) = .true.
            last = last + 1
            m = last
            do while (m > first)
               if (degree(matrix, order(m - 1)) <= degree(matrix, j)) exit
               order(m) = order(m - 1)
               m = m - 1
            end do
            order(m) = j
         end do
         head = head + 1
      end do
   end subroutine visit_breadth_first

   !> Number of entries of a row.
   pure integer function degree(matrix, row)
      type(sparse_t), intent(in) :: matrix
      integer, intent(in) :: row
      degree = matrix%row_start(row + 1) - matrix%row_start(row)
   end function degree
end module hampm_cuthill_mckee
