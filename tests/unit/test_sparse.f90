!> Sparse symmetric matrices: the pattern of cliques, renumbering for a small bandwidth, and the two factorisations.
program test_sparse
   use hampm_kinds, only: dp
   use hampm_banded, only: banded_t
   use hampm_cuthill_mckee, only: reverse_cuthill_mckee
   use hampm_failure, only: failure_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_sparse, only: sparse_t, pattern_of_cliques
   use hampm_umfpack, only: umfpack_t
   implicit none

   call repeat_random_numbers()
   call check_pattern()
   call check_bandwidth()
   call check_parts()
   call check_solutions()
   call check_refusal()
   call finish()

contains

   subroutine check_pattern()
      type(sparse_t) :: a
      ! 1 - 2 - 3 and 3 - 5; row 4 is in no clique, 0 is no member
      call pattern_of_cliques(5, reshape([3, 1, 2, 0, 5, 3, 2, 1, 0], [3, 3]), a)
      call check(a%n == 5, 'a pattern has as many rows as asked for')
      call check(all(a%row_start == [1, 4, 7, 11, 11, 13]), 'each row has its entries')
      call check(all(a%column == [1, 2, 3, 1, 2, 3, 1, 2, 3, 5, 3, 5]), 'couplings are found once, ascending')
      call check(all(abs(a%value) <= 0), 'values start at zero')
      call a%add(3, 5, 2.0_dp)
      call a%add(3, 5, 0.5_dp)
      call check_close(a%value(10), 2.5_dp, 0.0_dp, 'values are added to their entry')
      call check_close(sum(abs(a%value)), 2.5_dp, 0.0_dp, 'and to no other')
      call check(a%bandwidth([1, 2, 3, 4, 5]) == 2, 'the bandwidth is the largest distance from the diagonal')
      call check(a%bandwidth([5, 2, 1, 4, 3]) == 4, 'and follows the numbering')
   end subroutine check_pattern

   !> Nodes of a strip of 60 x 4 cells, numbered at random: the best possible bandwidth is that of numbering across.
   subroutine check_bandwidth()
      type(sparse_t) :: a
      integer :: place(61*5), across
      across = 5 + 1
      call strip(60, 4, a)
      place = reverse_cuthill_mckee(a)
      call check(is_permutation(place), 'reverse Cuthill-McKee permutes the rows')
      write (*, '(a,i0,a,i0,a)') 'strip of 60 x 4 cells: bandwidth ', a%bandwidth(place), ', numbered across ', across, &
         ', at random near 300'
      call check(a%bandwidth(place) <= 2*across, 'its bandwidth on a strip is that of the narrow side')
   end subroutine check_bandwidth

   !> Two parts that are not connected, and a row by itself.
   subroutine check_parts()
      type(sparse_t) :: a
      integer :: place(7)
      call pattern_of_cliques(7, reshape([1, 4, 4, 6, 2, 5, 7, 7], [2, 4]), a)
      place = reverse_cuthill_mckee(a)
      call check(is_permutation(place), 'parts that are not connected are numbered too')
      call check(a%bandwidth(place) == 1, 'each by itself')
   end subroutine check_parts

   subroutine check_solutions()
      type(sparse_t) :: a
      type(banded_t) :: banded
      type(umfpack_t) :: umfpack
      type(failure_t) :: failure
      real(dp), allocatable :: b(:), expected(:), x(:)
      integer :: trial
      call strip(20, 6, a)
      allocate (b(a%n), expected(a%n), x(a%n))
      call banded%analyse(a, failure)
      call umfpack%analyse(a, failure)
      do trial = 1, 3
         call fill_at_random(a)
         call random_number(expected)
         b = times(a, expected)
         call banded%factorise(a, failure)
         call umfpack%factorise(a, failure)
         call check(.not. failure%failed(), 'a positive definite matrix can be factorised')
         call banded%solve(b, x)
         call check_close(maxval(abs(x - expected)), 0.0_dp, 1.0e-12_dp, 'banded solves to rounding')
         call umfpack%solve(b, x)
         call check_close(maxval(abs(x - expected)), 0.0_dp, 1.0e-12_dp, 'umfpack solves to rounding')
      end do
      call umfpack%release()
   end subroutine check_solutions

   !> A singular matrix is refused, not solved.
   subroutine check_refusal()
      type(sparse_t) :: a
      type(banded_t) :: banded
      type(umfpack_t) :: umfpack
      type(failure_t) :: of_banded, of_umfpack
      call pattern_of_cliques(2, reshape([1, 2], [2, 1]), a)
      a%value = 1
      call banded%analyse(a, of_banded)
      call banded%factorise(a, of_banded)
      call check(of_banded%failed(), 'banded refuses a singular matrix')
      call umfpack%analyse(a, of_umfpack)
      call umfpack%factorise(a, of_umfpack)
      call check(of_umfpack%failed(), 'umfpack refuses a singular matrix')
      call umfpack%release()
   end subroutine check_refusal

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

   pure logical function is_permutation(place)
      integer, intent(in) :: place(:)
      integer :: i
      is_permutation = all([(count(place == i) == 1, i=1, size(place))])
   end function is_permutation
end program test_sparse
