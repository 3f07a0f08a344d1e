!> Algebraic multigrid by smoothed aggregation (Vanek, Mandel & Brezina, Computing 56 (1996) 179-196); a cycle preconditions
!> conjugate gradients. Neighbouring nodes form an aggregate; its unknowns are amplitudes of the motions of least energy, as of
!> rigid bodies; a step of Jacobi smooths these, P = (I - 4/(3 lambda) D^-1 A) T, and the matrix of the coarse unknowns is P^T A P,
!> down to a few rows, which are factorised. Polynomials of Chebyshev in D^-1 A before and after reduce errors that change from node
!> to node (Adams, Brezina, Hu & Tuminaro, J. Comput. Phys. 188 (2003) 593-610).
!>
!> Each row is the work of one thread, and sums are taken in a fixed order: the result has the same bytes on any number of threads.
module hampm_multigrid
   use hampm_kinds, only: dp
   use hampm_tensors, only: norm
   use hampm_failure, only: failure_t, exit_computation
   use hampm_factorisation, only: factorisation_t
   use hampm_sparse, only: sparse_t
   implicit none
   private
   public :: multigrid_t

   integer, parameter :: most_levels = 12, most_factorised = 3000 !! rows
   integer, parameter :: degree = 2              !! of the polynomials
   real(dp), parameter :: smoothed = 8.0_dp      !! the largest eigenvalue over the least that they take out
   integer, parameter :: power_steps = 12        !! to find the largest eigenvalue
   real(dp), parameter :: safety = 1.1_dp        !! bound of the largest eigenvalue over its estimate
   real(dp), parameter :: weak = 0.01_dp         !! coupling over the root of the product of the stiffnesses, that is neglected
   integer, parameter :: strip = 16384           !! rows whose product with P is there at once
   integer, parameter :: at_once = 64            !! rows of a thread one after the other
   real(dp), parameter :: dependent = 1e-8_dp    !! part of a motion that is left beside others where it is one of them

   !> A level: its smoother, and the transfer to the next one.
   type :: level_t
      real(dp), allocatable :: inverse(:)        !! of the diagonal
      real(dp) :: largest = 0                    !! eigenvalue of D^-1 A
      type(sparse_t) :: prolong, restrict        !! P and its transpose
      type(sparse_t) :: coarse                   !! the matrix of the next level
      real(dp), allocatable :: r(:), d(:), b(:), x(:) !! workspace: of this level, of the next one
   end type level_t

   !> The levels of a matrix.
   type :: multigrid_t
      type(level_t), allocatable, private :: level(:)
      integer, private :: n = 0                  !! levels that are smoothed
      type(factorisation_t), private :: coarsest
   contains
      procedure :: make_levels
      procedure :: precondition
      procedure :: release
   end type multigrid_t

contains

   !> Make the levels of a symmetric positive definite matrix. Fails where a diagonal is not positive or the coarsest has no factor.
   subroutine make_levels(self, matrix, first, motions, failure)
      class(multigrid_t), intent(inout) :: self
      type(sparse_t), intent(in) :: matrix
      integer, intent(in) :: first(:)            !! first unknown of each node, and behind the last one; (nodes + 1)
      real(dp), intent(in) :: motions(:, :)      !! of the least energy, (motions, unknowns)
      type(failure_t), intent(inout) :: failure
      integer, allocatable :: start(:)
      real(dp), allocatable :: b(:, :)
      logical :: is_coarser
      call self%release()
      allocate (self%level(most_levels))
      allocate (start, source=first)
      allocate (b, source=motions)
      do while (self%n < most_levels .and. size(b, 2) > most_factorised)
         if (self%n == 0) then
            call add_level(self%level(1), matrix, start, b, is_coarser, failure)
         else
            call add_level(self%level(self%n + 1), self%level(self%n)%coarse, start, b, is_coarser, failure)
         end if
         if (failure%failed()) return
         if (.not. is_coarser) exit
         self%n = self%n + 1
      end do
      if (self%n == 0) call self%coarsest%factorise(matrix, failure)
      if (self%n > 0) call self%coarsest%factorise(self%level(self%n)%coarse, failure)
      if (.not. failure%failed() .and. .not. self%coarsest%is_definite) &
         call failure%report(exit_computation, 'it is not positive definite')
   end subroutine make_levels

   !> Make a level, and the nodes and motions of the next one.
   subroutine add_level(level, a, start, b, is_coarser, failure)
      type(level_t), intent(inout) :: level
      type(sparse_t), intent(in) :: a
      integer, allocatable, intent(inout) :: start(:)
      real(dp), allocatable, intent(inout) :: b(:, :)
      logical, intent(out) :: is_coarser
      type(failure_t), intent(inout) :: failure
      integer, allocatable :: next_start(:), aggregate(:)
      real(dp), allocatable :: next_b(:, :)
      type(sparse_t) :: tentative, rows, product, before ! product: of the strips up to here
      integer :: i, last
      is_coarser = .false.
      call find_diagonal(a, level, failure)
      if (failure%failed()) return
      call aggregate_nodes(a, start, aggregate)
      call find_tentative(start, aggregate, b, tentative, next_start, next_b)
      associate (n => size(next_b, 2))
         is_coarser = 2*n <= a%n
         if (.not. is_coarser) return
         call find_prolongation(a, tentative, n, level)
         level%restrict = transposed(level%prolong, n)
         do i = 1, a%n, strip                    ! A P is never there as a whole
            last = min(i + strip - 1, a%n)
            rows = product_of(a%rows(i, last), level%prolong, n)
            call product%move_to(before)
            product = product_of(transposed(level%prolong%rows(i, last), n), rows, n, before)
         end do
         rows = sparse_t()
         before = sparse_t()
         level%coarse = transposed(product, n)   ! it is symmetric; a transpose has its columns in order
         allocate (level%r(a%n), level%d(a%n), level%b(n), level%x(n))
      end associate
      call move_alloc(next_start, start)
      call move_alloc(next_b, b)
   end subroutine add_level

   !> Invert the diagonal, and find the largest eigenvalue of D^-1 A by the power method.
   subroutine find_diagonal(a, level, failure)
      type(sparse_t), intent(in) :: a
      type(level_t), intent(inout) :: level
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: v(:), w(:)
      integer :: i, k
      allocate (level%inverse(a%n), source=0.0_dp)
      do i = 1, a%n
         do k = a%row_start(i), a%row_start(i + 1) - 1
            if (a%column(k) == i .and. a%value(k) > 0) level%inverse(i) = 1/a%value(k)
         end do
      end do
      if (any(level%inverse <= 0)) then
         call failure%report(exit_computation, 'it is not positive definite')
         return
      end if
      allocate (v(a%n), w(a%n))
      do i = 1, a%n
         v(i) = 1 + 0.5_dp*sin(2.3_dp*i*i)       ! anything with all modes in it, which change sign from node to node
         if (mod(i, 2) == 0) v(i) = -v(i)
      end do
      do k = 1, power_steps
         v = v/maxval(abs(v))
         call a%multiply(v, w)
         v = level%inverse*w
      end do
      level%largest = safety*maxval(abs(v))
   end subroutine find_diagonal

   !> Gather the nodes in aggregates: a node with all of its neighbours where none of these is in another one; nodes that are left
   !> join a neighbour or, without one, are an aggregate.
   subroutine aggregate_nodes(a, start, aggregate)
      type(sparse_t), intent(in) :: a
      integer, intent(in) :: start(:)            !! first unknown of each node
      integer, allocatable, intent(out) :: aggregate(:)
      integer, allocatable :: first(:), neighbour(:), before(:)
      integer :: i, k, n
      call find_neighbours(a, start, first, neighbour)
      associate (nodes => size(start) - 1)
         allocate (aggregate(nodes), source=0)
         n = 0
         do i = 1, nodes
            associate (around => neighbour(first(i):first(i + 1) - 1))
               if (aggregate(i) > 0 .or. any(aggregate(around) > 0)) cycle
               n = n + 1
               aggregate(i) = n
               aggregate(around) = n
            end associate
         end do
         allocate (before, source=aggregate)
         do i = 1, nodes
            do k = first(i), first(i + 1) - 1
               if (aggregate(i) == 0) aggregate(i) = before(neighbour(k))
            end do
         end do
         do i = 1, nodes
            if (aggregate(i) > 0) cycle
            n = n + 1
            aggregate(i) = n
            do k = first(i), first(i + 1) - 1
               if (aggregate(neighbour(k)) == 0) aggregate(neighbour(k)) = n
            end do
         end do
      end associate
   end subroutine aggregate_nodes

   !> The nodes with which each one is coupled, but weakly.
   subroutine find_neighbours(a, start, first, neighbour)
      type(sparse_t), intent(in) :: a
      integer, intent(in) :: start(:)            !! first unknown of each node
      integer, allocatable, intent(out) :: first(:), neighbour(:) !! first neighbour of each node in the second
      integer, allocatable :: node(:), place(:), list(:)
      real(dp), allocatable :: square(:), own(:)
      integer :: i, k, row, n
      associate (nodes => size(start) - 1)
         allocate (node(a%n), place(nodes), list(nodes), square(nodes), first(nodes + 1), own(nodes))
         do i = 1, nodes
            node(start(i):start(i + 1) - 1) = i
         end do
         do i = 1, nodes
            own(i) = 0
            do row = start(i), start(i + 1) - 1
               do k = a%row_start(row), a%row_start(row + 1) - 1
                  if (node(a%column(k)) == i) own(i) = own(i) + a%value(k)**2
               end do
            end do
         end do
         n = 0                                   ! rows of a node have about the same columns
         do i = 1, nodes
            n = n + max(0, maxval(a%row_start(start(i) + 1:start(i + 1)) - a%row_start(start(i):start(i + 1) - 1)))
         end do
         allocate (neighbour(n))
         place = 0
         first(1) = 1
         do i = 1, nodes
            n = 0
            do row = start(i), start(i + 1) - 1
               do k = a%row_start(row), a%row_start(row + 1) - 1
                  associate (other => node(a%column(k)))
                     if (place(other) /= i) then
                        place(other) = i
                        n = n + 1
                        list(n) = other
                        square(other) = 0
                     end if
                     square(other) = square(other) + a%value(k)**2
                  end associate
               end do
            end do
            first(i + 1) = first(i)
            do k = 1, n
               if (list(k) == i .or. square(list(k)) <= weak**2*sqrt(own(i)*own(list(k)))) cycle
               neighbour(first(i + 1)) = list(k)
               first(i + 1) = first(i + 1) + 1
            end do
         end do
      end associate
   end subroutine find_neighbours

   !> The motions in each aggregate, orthogonal and of norm 1: T; and the amplitudes of the motions of the whole in them.
   subroutine find_tentative(start, aggregate, b, tentative, next_start, next_b)
      integer, intent(in) :: start(:), aggregate(:)
      real(dp), intent(in) :: b(:, :)            !! (motions, unknowns)
      type(sparse_t), intent(out) :: tentative
      integer, allocatable, intent(out) :: next_start(:)
      real(dp), allocatable, intent(out) :: next_b(:, :)
      integer, allocatable :: place(:), member(:), rows(:)
      real(dp), allocatable :: q(:, :), all_b(:, :)
      real(dp) :: length, part
      integer :: g, i, j, k, n, rank, again
      associate (motions => size(b, 1), unknowns => size(b, 2), groups => maxval(aggregate))
         allocate (place(groups + 1), next_start(groups + 1), source=0)
         do i = 1, size(aggregate)
            place(aggregate(i)) = place(aggregate(i)) + 1
         end do
         n = 1
         do g = 1, groups + 1                    ! first member of each
            k = place(g)
            place(g) = n
            n = n + k
         end do
         allocate (member(size(aggregate)))
         do i = 1, size(aggregate)
            member(place(aggregate(i))) = i
            place(aggregate(i)) = place(aggregate(i)) + 1
         end do
         tentative%n = unknowns
         allocate (tentative%row_start(unknowns + 1), source=0)
         allocate (tentative%column(motions*unknowns), source=0)
         allocate (tentative%value(motions*unknowns), source=0.0_dp)
         allocate (all_b(motions, motions*groups), source=0.0_dp)
         next_start(1) = 1
         do g = 1, groups
            i = 1
            if (g > 1) i = place(g - 1)
            rows = [integer ::]
            do k = i, place(g) - 1
               rows = [rows, (j, j=start(member(k)), start(member(k) + 1) - 1)]
            end do
            allocate (q(size(rows), motions))
            q = transpose(b(:, rows))
            rank = 0
            do j = 1, motions
               length = norm(q(:, j))
               q(:, rank + 1) = q(:, j)
               do again = 1, 2
                  do k = 1, rank
                     part = dot_product(q(:, k), q(:, rank + 1))
                     q(:, rank + 1) = q(:, rank + 1) - part*q(:, k)
                     all_b(j, next_start(g) + k - 1) = all_b(j, next_start(g) + k - 1) + part
                  end do
               end do
               part = norm(q(:, rank + 1))
               if (part <= dependent*length) cycle
               rank = rank + 1
               q(:, rank) = q(:, rank)/part
               all_b(j, next_start(g) + rank - 1) = part
            end do
            next_start(g + 1) = next_start(g) + rank
            do k = 1, size(rows)
               tentative%row_start(rows(k)) = rank
               do j = 1, rank
                  tentative%column(motions*(rows(k) - 1) + j) = next_start(g) + j - 1
                  tentative%value(motions*(rows(k) - 1) + j) = q(k, j)
               end do
            end do
            deallocate (q)
         end do
         allocate (next_b, source=all_b(:, :next_start(groups + 1) - 1))
         n = 1                                   ! close the gaps
         do i = 1, unknowns
            k = tentative%row_start(i)
            tentative%row_start(i) = n
            tentative%column(n:n + k - 1) = tentative%column(motions*(i - 1) + 1:motions*(i - 1) + k)
            tentative%value(n:n + k - 1) = tentative%value(motions*(i - 1) + 1:motions*(i - 1) + k)
            n = n + k
         end do
         tentative%row_start(unknowns + 1) = n
      end associate
   end subroutine find_tentative

   !> P = (I - 4/(3 lambda) D^-1 A) T.
   subroutine find_prolongation(a, tentative, n, level)
      type(sparse_t), intent(in) :: a, tentative
      integer, intent(in) :: n                   !! columns
      type(level_t), intent(inout) :: level
      integer :: i, j, k
      level%prolong = product_of(a, tentative, n)
      associate (p => level%prolong)
         !$omp parallel do schedule(static) private(j, k)
         do i = 1, a%n
            do k = p%row_start(i), p%row_start(i + 1) - 1
               p%value(k) = -4*level%inverse(i)/(3*level%largest/safety)*p%value(k)
               do j = tentative%row_start(i), tentative%row_start(i + 1) - 1
                  if (tentative%column(j) == p%column(k)) p%value(k) = p%value(k) + tentative%value(j)
               end do
            end do
         end do
      end associate
   end subroutine find_prolongation

   !> The product of two matrices, the second of which has so many columns, and a third one. Columns of a row come as they are met.
   type(sparse_t) function product_of(a, b, columns, third) result(c)
      type(sparse_t), intent(in) :: a, b
      integer, intent(in) :: columns
      type(sparse_t), intent(in), optional :: third !! that is added, if it has any rows
      integer, allocatable :: place(:)
      logical :: adds
      integer :: i, j, k, n
      adds = .false.
      if (present(third)) adds = third%n > 0
      c%n = a%n
      allocate (c%row_start(a%n + 1))
      !$omp parallel private(place, j, k, n)
      allocate (place(columns), source=0)
      !$omp do schedule(static, at_once)
      do i = 1, a%n
         n = 0
         if (adds) then
            n = third%row_start(i + 1) - third%row_start(i)
            place(third%column(third%row_start(i):third%row_start(i + 1) - 1)) = i
         end if
         do j = a%row_start(i), a%row_start(i + 1) - 1
            do k = b%row_start(a%column(j)), b%row_start(a%column(j) + 1) - 1
               if (place(b%column(k)) == i) cycle
               place(b%column(k)) = i
               n = n + 1
            end do
         end do
         c%row_start(i + 1) = n
      end do
      !$omp single
      c%row_start(1) = 1
      do i = 1, a%n
         c%row_start(i + 1) = c%row_start(i + 1) + c%row_start(i)
      end do
      allocate (c%column(c%row_start(a%n + 1) - 1), c%value(c%row_start(a%n + 1) - 1))
      !$omp end single
      place = 0
      !$omp do schedule(static, at_once)
      do i = 1, a%n
         n = c%row_start(i) - 1
         if (adds) then
            do k = third%row_start(i), third%row_start(i + 1) - 1
               n = n + 1
               place(third%column(k)) = n
               c%column(n) = third%column(k)
               c%value(n) = third%value(k)
            end do
         end if
         do j = a%row_start(i), a%row_start(i + 1) - 1
            do k = b%row_start(a%column(j)), b%row_start(a%column(j) + 1) - 1
               associate (at => place(b%column(k)))
                  if (at < c%row_start(i)) then
                     n = n + 1
                     at = n
                     c%column(n) = b%column(k)
                     c%value(n) = 0
                  end if
                  c%value(at) = c%value(at) + a%value(j)*b%value(k)
               end associate
            end do
         end do
      end do
      !$omp end parallel
   end function product_of

   !> The transpose of a matrix that has so many columns; columns of a row are in order.
   type(sparse_t) function transposed(a, columns) result(c)
      type(sparse_t), intent(in) :: a
      integer, intent(in) :: columns
      integer, allocatable :: place(:)
      integer :: i, k
      c%n = columns
      allocate (c%row_start(columns + 1), source=0)
      allocate (c%column(size(a%column)), c%value(size(a%column)))
      do k = 1, size(a%column)
         c%row_start(a%column(k) + 1) = c%row_start(a%column(k) + 1) + 1
      end do
      c%row_start(1) = 1
      do i = 1, columns
         c%row_start(i + 1) = c%row_start(i + 1) + c%row_start(i)
      end do
      allocate (place, source=c%row_start(:columns))
      do i = 1, a%n
         do k = a%row_start(i), a%row_start(i + 1) - 1
            associate (at => place(a%column(k)))
               c%column(at) = i
               c%value(at) = a%value(k)
               at = at + 1
            end associate
         end do
      end do
   end function transposed

   !> z = B r, with B about A^-1, symmetric and positive definite: one cycle from level to level and back.
   recursive subroutine precondition(self, matrix, r, z, l)
      class(multigrid_t), intent(inout) :: self
      type(sparse_t), intent(in) :: matrix       !! of this level
      real(dp), intent(in), contiguous :: r(:)
      real(dp), intent(out), contiguous :: z(:)
      integer, intent(in) :: l                   !! level, 1 from outside
      if (l > self%n) then
         call self%coarsest%solve(r, z)
         return
      end if
      associate (level => self%level(l))
         z = 0
         call smooth(matrix, level, r, z, .true.)
         call matrix%multiply(z, level%d)
         level%r = r - level%d
         call level%restrict%multiply(level%r, level%b)
         call self%precondition(level%coarse, level%b, level%x, l + 1)
         call level%prolong%multiply(level%x, level%d)
         z = z + level%d
         call smooth(matrix, level, r, z, .false.)
      end associate
   end subroutine precondition

   !> Smooth by a polynomial of Chebyshev: z <- z + p(D^-1 A) D^-1 (r - A z).
   subroutine smooth(a, level, r, z, is_zero)
      type(sparse_t), intent(in) :: a
      type(level_t), intent(inout) :: level
      real(dp), intent(in), contiguous :: r(:)
      real(dp), intent(inout), contiguous :: z(:)
      logical, intent(in) :: is_zero             !! whether z is
      real(dp) :: middle, half, rho, last
      integer :: k
      half = (level%largest - level%largest/smoothed)/2
      middle = (level%largest + level%largest/smoothed)/2
      rho = half/middle
      do k = 1, degree
         if (k == 1 .and. is_zero) then
            level%r = r
         else
            call a%multiply(z, level%r)
            level%r = r - level%r
         end if
         if (k == 1) then
            level%d = level%inverse*level%r/middle
         else
            last = rho
            rho = 1/(2*middle/half - last)
            level%d = rho*last*level%d + 2*rho/half*level%inverse*level%r
         end if
         z = z + level%d
      end do
   end subroutine smooth

   !> Release the memory.
   subroutine release(self)
      class(multigrid_t), intent(inout) :: self
      call self%coarsest%release()
      if (allocated(self%level)) deallocate (self%level)
      self%n = 0
   end subroutine release
end module hampm_multigrid
