!> Factorisations of sparse symmetric matrices: CHOLMOD beside LAPACK's Cholesky, and UMFPACK where there is none.
program test_cholmod
   use omp_lib, only: omp_get_max_active_levels
   use hampm_kinds, only: dp
   use hampm_cholmod, only: cholmod_t
   use hampm_factorisation, only: factorisation_t
   use hampm_failure, only: failure_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_lapack, only: dposv, dsyev
   use hampm_sparse, only: sparse_t, pattern_of_cliques
   use hampm_text, only: to_text
   use hampm_umfpack, only: umfpack_t
   implicit none

   call repeat_random_numbers()
   call check_random_matrices()
   call check_many_solutions()
   call check_signs()
   call check_patterns()
   call check_small_ones()
   call check_singular()
   call finish()

contains

   !> Strips of cells of several sizes, column by column and by blocks, with new values again and again.
   subroutine check_random_matrices()
      type(sparse_t) :: a
      type(cholmod_t) :: cholmod
      type(umfpack_t) :: umfpack
      type(failure_t) :: failure
      real(dp), allocatable :: b(:), by_lapack(:), x(:), y(:)
      logical :: definite, all_definite
      real(dp) :: difference
      integer :: trial, k, levels
      integer, parameter :: sides(2, 4) = reshape([2, 1, 20, 6, 60, 4, 40, 40], [2, 4])
      levels = omp_get_max_active_levels()
      do k = 1, size(sides, 2)
         call strip(sides(1, k), sides(2, k), a)
         if (allocated(b)) deallocate (b, x, y)
         allocate (b(a%n), x(a%n), y(a%n))
         difference = 0
         all_definite = .true.
         do trial = 1, 3
            call fill_at_random(a)
            call random_number(b)
            by_lapack = dense_solution(a, b)
            call cholmod%factorise(a, definite, failure)
            all_definite = all_definite .and. definite
            call cholmod%solve(b, x)
            call umfpack%factorise(a, failure)
            call umfpack%solve(b, y)
            difference = max(difference, maxval(abs(x - by_lapack)), maxval(abs(y - by_lapack)))
         end do
         call check(all_definite .and. .not. failure%failed(), to_text(a%n)//' rows: positive definite matrices are found to be')
         call check_close(difference, 0.0_dp, 1.0e-12_dp, to_text(a%n)//' rows: CHOLMOD and UMFPACK solve as LAPACK does')
         call cholmod%release()
         call umfpack%release()
      end do
      call check(omp_get_max_active_levels() == levels, 'threads are as many as before')
   end subroutine check_random_matrices

   !> A factor that is kept for many solutions gives those of several right-hand sides, some of them without the rows that are eliminated last, as LAPACK
   !> does by the matrix without these; also where the factor has numbers that are less than rounding, and with new values.
   subroutine check_many_solutions()
      type(sparse_t) :: a
      type(factorisation_t) :: factorised
      type(failure_t) :: failure
      real(dp), allocatable :: b(:, :), x(:, :), flat(:), given(:)
      logical, allocatable :: last(:)
      logical :: without(3)
      real(dp) :: difference
      integer :: k, i, j, trial, width
      integer, parameter :: sides(2, 4) = reshape([1, 1, 5, 3, 37, 6, 40, 40], [2, 4])
      factorised%solves_often = .true.
      do k = 1, size(sides, 2)
         call strip(sides(1, k), sides(2, k), a)
         allocate (last(a%n), given(a%n))
         last = [(mod(i, 7) == 3, i=1, a%n)]
         difference = 0
         do trial = 1, 2
            call fill_at_random(a)
            a%value = sign(merge(abs(a%value), 0.05_dp*abs(a%value), abs(a%value) > 8), a%value) ! far from the diagonal the factor decays
            call factorised%factorise(a, failure, last)
            do width = 1, 3
               allocate (b(width, a%n), x(width, a%n))
               call random_number(b)
               without = [.true., .false., .true.]
               allocate (flat(size(b)))
               call factorised%solve(reshape(b, [size(b)]), flat, without(:width))
               x = reshape(flat, shape(x))
               do j = 1, width
                  given = dense_solution(held(a, last .and. without(j)), merge(0.0_dp, b(j, :), last .and. without(j)))
                  difference = max(difference, maxval(abs(x(j, :) - given)))
               end do
               deallocate (b, x, flat)
            end do
         end do
         call check_close(difference, 0.0_dp, 1e-14_dp, to_text(a%n)//' rows: many solutions are those of LAPACK')
         call factorised%release()
         deallocate (last, given)
      end do
      call check(.not. failure%failed(), 'factors for many solutions are found')
   end subroutine check_many_solutions

   !> A matrix in which some rows and columns are those of the unit matrix.
   function held(a, rows) result(b)
      type(sparse_t), intent(in) :: a
      logical, intent(in) :: rows(:)
      type(sparse_t) :: b
      integer :: i, k
      b = a
      do i = 1, a%n
         do k = a%row_start(i), a%row_start(i + 1) - 1
            if (rows(i) .or. rows(a%column(k))) b%value(k) = merge(1.0_dp, 0.0_dp, a%column(k) == i)
         end do
      end do
   end function held

   !> A matrix is definite if its least eigenvalue is positive: shifted to just above and just below it, and far below.
   subroutine check_signs()
      type(sparse_t) :: a
      type(factorisation_t) :: factorised
      type(failure_t) :: failure
      real(dp), allocatable :: eigenvalues(:), b(:), x(:)
      real(dp) :: shift, last
      integer :: k, i, j
      integer, parameter :: sides(2, 2) = reshape([6, 4, 24, 20], [2, 2])
      do k = 1, size(sides, 2)
         call strip(sides(1, k), sides(2, k), a)
         call fill_at_random(a)
         if (allocated(eigenvalues)) deallocate (eigenvalues)
         allocate (eigenvalues, source=eigenvalues_of(a))
         allocate (b(a%n), x(a%n))
         last = 0
         do j = 1, 4
            select case (j)
            case (1)
               shift = eigenvalues(1)*(1 - 1e-9_dp)
            case (2)
               shift = eigenvalues(1)*(1 + 1e-9_dp)
            case (3)                             ! two negative eigenvalues: the determinant is positive again
               shift = (eigenvalues(2) + eigenvalues(3))/2
            case (4)
               shift = eigenvalues(a%n) + 1
            end select
            do i = 1, a%n
               call a%add(i, i, last - shift)
            end do
            last = shift
            call factorised%factorise(a, failure)
            call check(factorised%is_definite .eqv. j == 1, to_text(a%n)//' rows: the sign of the least eigenvalue is found, '// &
                       to_text(j))
            call random_number(b)
            call factorised%solve(b, x)
            call check_close(maxval(abs(times(a, x) - b)), 0.0_dp, 1e-13_dp*maxval(abs(x))*9 + 1e-12_dp, &
                             to_text(a%n)//' rows: it is solved all the same, '//to_text(j))
         end do
         call check(.not. failure%failed(), 'an indefinite matrix is no failure')
         call factorised%release()
         deallocate (b, x)
      end do
   end subroutine check_signs

   !> After its release a factorisation takes another pattern, definite or not.
   subroutine check_patterns()
      type(sparse_t) :: a
      type(factorisation_t) :: factorised
      type(failure_t) :: failure
      real(dp), allocatable :: b(:), x(:)
      integer :: k
      do k = 1, 6
         call strip(3*k, k, a)
         call fill_at_random(a)
         if (mod(k, 2) == 0) a%value = -a%value
         allocate (b(a%n), x(a%n))
         call random_number(b)
         call factorised%factorise(a, failure)
         call factorised%solve(b, x)
         call check_close(maxval(abs(times(a, x) - b)), 0.0_dp, 1e-13_dp, 'pattern '//to_text(k)//' is solved')
         call factorised%release()
         deallocate (b, x)
      end do
      call factorised%release()
      call check(.not. failure%failed(), 'a factorisation serves for one pattern after the other')
   end subroutine check_patterns

   !> One row, and none.
   subroutine check_small_ones()
      type(sparse_t) :: a
      type(factorisation_t) :: factorised
      type(failure_t) :: failure
      real(dp) :: x(1), nothing(0)
      call pattern_of_cliques(1, reshape([1], [1, 1]), a)
      a%value = 4
      call factorised%factorise(a, failure)
      call factorised%solve([2.0_dp], x)
      call check(factorised%is_definite .and. .not. abs(x(1) - 0.5_dp) > 0, 'one row is solved')
      a%value = -4
      call factorised%factorise(a, failure)
      call factorised%solve([2.0_dp], x)
      call check(.not. (factorised%is_definite .or. abs(x(1) + 0.5_dp) > 0), 'one row with a negative number is not definite')
      call factorised%release()
      call pattern_of_cliques(0, reshape([integer ::], [1, 0]), a)
      call factorised%factorise(a, failure)
      call factorised%solve([real(dp) ::], nothing)
      call check(factorised%is_definite .and. .not. failure%failed(), 'no rows are solved')
      call factorised%release()
   end subroutine check_small_ones

   !> A singular matrix is refused, not solved.
   subroutine check_singular()
      type(sparse_t) :: a
      type(factorisation_t) :: factorised
      type(failure_t) :: failure
      call pattern_of_cliques(2, reshape([1, 2], [2, 1]), a)
      a%value = 1
      call factorised%factorise(a, failure)
      call check(failure%failed() .and. .not. factorised%is_definite, 'a singular matrix is refused')
      call factorised%release()
   end subroutine check_singular

   !> The solution by LAPACK's Cholesky factorisation of the full matrix.
   function dense_solution(a, b) result(x)
      type(sparse_t), intent(in) :: a
      real(dp), intent(in) :: b(:)
      real(dp) :: x(size(b))
      real(dp), allocatable :: full(:, :)
      integer :: info
      allocate (full, source=full_matrix(a))
      x = b
      call dposv('L', a%n, 1, full, a%n, x, a%n, info)
      call check(info == 0, 'LAPACK finds it positive definite')
   end function dense_solution

   !> All eigenvalues, ascending.
   function eigenvalues_of(a) result(eigenvalues)
      type(sparse_t), intent(in) :: a
      real(dp), allocatable :: eigenvalues(:)
      real(dp), allocatable :: full(:, :), work(:)
      integer :: info
      allocate (full, source=full_matrix(a))
      allocate (eigenvalues(a%n), work(34*a%n))
      call dsyev('N', 'L', a%n, full, a%n, eigenvalues, work, size(work), info)
      call check(info == 0, 'LAPACK finds the eigenvalues')
   end function eigenvalues_of

   !> With all zeros.
   pure function full_matrix(a) result(full)
      type(sparse_t), intent(in) :: a
      real(dp), allocatable :: full(:, :)
      integer :: i
      allocate (full(a%n, a%n), source=0.0_dp)
      do i = 1, a%n
         associate (first => a%row_start(i), last => a%row_start(i + 1) - 1)
            full(i, a%column(first:last)) = a%value(first:last)
         end associate
      end do
   end function full_matrix

   !> The pattern of the nodes of nx x ny cells, numbered at random.
   subroutine strip(nx, ny, a)
      integer, intent(in) :: nx, ny
      type(sparse_t), intent(out) :: a
      integer :: cliques(4, nx*ny), name((nx + 1)*(ny + 1)), i, j, k, swap
      real(dp) :: r
      name = [(i, i=1, size(name))]
      do i = size(name), 2, -1
         call random_number(r)
         k = 1 + int(r*i)
         swap = name(i)
         name(i) = name(k)
         name(k) = swap
      end do
      do j = 0, ny - 1
         do i = 0, nx - 1
            k = i + 1 + j*(nx + 1)
            cliques(:, i + 1 + j*nx) = name([k, k + 1, k + nx + 1, k + nx + 2])
         end do
      end do
      call pattern_of_cliques(size(name), cliques, a)
   end subroutine strip

   !> Random symmetric values with a dominant diagonal.
   subroutine fill_at_random(a)
      type(sparse_t), intent(inout) :: a
      real(dp) :: r
      integer :: i, k
      a%value = 0
      do i = 1, a%n
         do k = a%row_start(i), a%row_start(i + 1) - 1
            if (a%column(k) >= i) cycle
            call random_number(r)
            call a%add(i, a%column(k), 2*r - 1)
            call a%add(a%column(k), i, 2*r - 1)
         end do
         call a%add(i, i, 9.0_dp)
      end do
   end subroutine fill_at_random

   !> A x.
   function times(a, x) result(y)
      type(sparse_t), intent(in) :: a
      real(dp), intent(in) :: x(:)
      real(dp) :: y(size(x))
      integer :: i
      do i = 1, a%n
         associate (first => a%row_start(i), last => a%row_start(i + 1) - 1)
            y(i) = dot_product(a%value(first:last), x(a%column(first:last)))
         end associate
      end do
   end function times
end program test_cholmod
