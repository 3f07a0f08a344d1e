!> A sparse symmetric matrix by rows, both triangles stored, columns ascending.
module hampm_sparse
   use hampm_kinds, only: dp
   implicit none
   private
   public :: sparse_t, pattern_of_cliques

   !> Where each row begins, and column and value of its entries.
   type :: sparse_t
      integer :: n = 0                           !! number of rows
      integer, allocatable :: row_start(:)       !! first entry of each row, (n + 1)
      integer, allocatable :: column(:)          !! column of each entry, ascending within a row
      real(dp), allocatable :: value(:)          !! (entries)
      logical :: is_symmetric = .true.           !! its pattern always is
   contains
      procedure :: symmetric_part
      procedure :: add
      procedure :: add_block
      procedure :: has_pattern_of
      procedure :: move_to
      procedure :: multiply
      procedure :: rows
   end type sparse_t

contains

   !> The pattern of a matrix in which all members of each clique are coupled, as the nodes of an element are. Values are
   !> zero.
   pure subroutine pattern_of_cliques(n, cliques, matrix)
      integer, intent(in) :: n                   !! number of rows
      integer, intent(in) :: cliques(:, :)       !! members, 0 for none, (size of a clique, number of cliques)
      type(sparse_t), intent(out) :: matrix
      integer, allocatable :: first_clique(:), next_clique(:, :), mark(:), unsorted(:)
      integer :: i, k, c, m, entries
      allocate (first_clique(n), next_clique(size(cliques, 1), size(cliques, 2)), mark(n))
      first_clique = 0
      do k = size(cliques, 2), 1, -1             ! for each row a chained list of (member, clique)
         do c = 1, size(cliques, 1)
            if (cliques(c, k) == 0) cycle
            next_clique(c, k) = first_clique(cliques(c, k))
            first_clique(cliques(c, k)) = c + size(cliques, 1)*(k - 1)
         end do
      end do
      matrix%n = n
      allocate (matrix%row_start(n + 1), unsorted(32*n + 1)) ! the entries of all cliques may be more than can be numbered
      mark = 0
      entries = 0
      do i = 1, n
         matrix%row_start(i) = entries + 1
         m = first_clique(i)
         do while (m > 0)
            k = (m - 1)/size(cliques, 1) + 1
            do c = 1, size(cliques, 1)
               if (cliques(c, k) == 0) cycle
               if (mark(cliques(c, k)) == i) cycle
               mark(cliques(c, k)) = i
               if (entries == size(unsorted)) unsorted = [unsorted, unsorted]
               entries = entries + 1
               unsorted(entries) = cliques(c, k)
            end do
            m = next_clique(m - size(cliques, 1)*(k - 1), k)
         end do
      end do
      matrix%row_start(n + 1) = entries + 1
      allocate (matrix%column(entries))
      mark = matrix%row_start(:n)                ! the pattern is symmetric: each row comes into the rows of its columns, in order
      do i = 1, n
         do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
            associate (at => mark(unsorted(k)))
               matrix%column(at) = i
               at = at + 1
            end associate
         end do
      end do
      deallocate (unsorted)                      ! values take its room
      allocate (matrix%value(entries), source=0.0_dp)
   end subroutine pattern_of_cliques

   !> Half of the sum of the matrix and its transpose.
   pure type(sparse_t) function symmetric_part(self) result(part)
      class(sparse_t), intent(in) :: self
      integer :: i, k, other
      part%n = self%n
      allocate (part%row_start, source=self%row_start)
      allocate (part%column, source=self%column)
      allocate (part%value, source=self%value)
      do i = 1, self%n
         do k = self%row_start(i), self%row_start(i + 1) - 1
            associate (j => self%column(k))
               other = self%row_start(j) - 1 + findloc(self%column(self%row_start(j):self%row_start(j + 1) - 1), i, dim=1)
            end associate
            part%value(k) = (self%value(k) + self%value(other))/2
         end do
      end do
   end function symmetric_part

   !> Add to an entry of the pattern.
   pure subroutine add(self, i, j, value)
      class(sparse_t), intent(inout) :: self
      integer, intent(in) :: i, j
      real(dp), intent(in) :: value
      integer :: k
      do k = self%row_start(i), self%row_start(i + 1) - 1
         if (self%column(k) == j) then
            self%value(k) = self%value(k) + value
            return
         end if
      end do
   end subroutine add

   !> Add a full matrix of some rows and columns, which are coupled in the pattern: a walk along each row meets the columns in their
   !> order.
   pure subroutine add_block(self, index, block)
      class(sparse_t), intent(inout) :: self
      integer, intent(in) :: index(:)            !! row and column of each of the matrix, 0 for one that is left out
      real(dp), intent(in) :: block(:, :)        !! (size(index), size(index))
      integer :: order(size(index)), r, c, k
      order = ascending(index)
      do r = 1, size(index)
         if (index(r) == 0) cycle
         k = self%row_start(index(r))
         do c = 1, size(index)
            if (index(order(c)) == 0) cycle
            do while (self%column(k) < index(order(c)))
               k = k + 1
            end do
            self%value(k) = self%value(k) + block(r, order(c))
         end do
      end do
   end subroutine add_block

   !> Whether two matrices have entries at the same places.
   pure logical function has_pattern_of(self, other)
      class(sparse_t), intent(in) :: self
      type(sparse_t), intent(in) :: other
      has_pattern_of = .false.
      if (self%n /= other%n .or. .not. (allocated(self%column) .and. allocated(other%column))) return
      if (size(self%column) /= size(other%column)) return
      has_pattern_of = all(self%row_start == other%row_start)
      if (has_pattern_of) has_pattern_of = all(self%column == other%column)
   end function has_pattern_of

   !> Move all entries to another matrix, in place of its own: none is there twice.
   pure subroutine move_to(self, other)
      class(sparse_t), intent(inout) :: self
      type(sparse_t), intent(out) :: other
      other%n = self%n
      other%is_symmetric = self%is_symmetric
      call move_alloc(self%row_start, other%row_start)
      call move_alloc(self%column, other%column)
      call move_alloc(self%value, other%value)
   end subroutine move_to

   !> q = A p.
   subroutine multiply(self, p, q)
      class(sparse_t), intent(in) :: self
      real(dp), intent(in), contiguous :: p(:)
      real(dp), intent(out), contiguous :: q(:)
      real(dp) :: total
      integer :: i, k
      !$omp parallel do schedule(static) private(k, total)
      do i = 1, self%n
         total = 0
         do k = self%row_start(i), self%row_start(i + 1) - 1
            total = total + self%value(k)*p(self%column(k))
         end do
         q(i) = total
      end do
   end subroutine multiply

   !> Some rows as a matrix.
   pure type(sparse_t) function rows(self, first, last) result(part)
      class(sparse_t), intent(in) :: self
      integer, intent(in) :: first, last
      part%n = last - first + 1
      associate (from => self%row_start(first), to => self%row_start(last + 1) - 1)
         allocate (part%row_start, source=self%row_start(first:last + 1) - from + 1)
         allocate (part%column, source=self%column(from:to))
         allocate (part%value, source=self%value(from:to))
      end associate
   end function rows

   !> Places of some numbers in their ascending order, by insertion: they are few.
   pure function ascending(values) result(place)
      integer, intent(in) :: values(:)
      integer :: place(size(values))
      integer :: i, k
      do i = 1, size(values)
         k = i
         do while (k > 1)
            if (values(place(k - 1)) <= values(i)) exit
            place(k) = place(k - 1)
            k = k - 1
         end do
         place(k) = i
      end do
   end function ascending
end module hampm_sparse
