!> The table numbers places in the order in which they come, whatever they are, and finds them again.
program test_place_table
   use hampm_kinds, only: dp, ndim, long
   use hampm_harness, only: check, finish, repeat_random_numbers
   use hampm_place_table, only: place_table_t
   implicit none

   call repeat_random_numbers()
   call empty_table()
   call lattice_of(1_long)
   call lattice_of(2_long**24)
   call lattice_of(2_long**31)
   call lattice_of(2_long**31 - 1)
   call corners_of_a_lattice()
   call random_places()
   call equal_hashes()
   call finish()

contains

   subroutine empty_table()
      type(place_table_t) :: table
      integer :: status
      call table%reserve(0, status)
      call check(status == 0 .and. table%n == 0, 'a table begins empty')
      call check(table%number_of([0_long, 0_long]) == 0, 'and finds nothing, not even the origin')
   end subroutine empty_table

   !> All places of a lattice with this distance, which grows a table that was made for one place some 13 times.
   subroutine lattice_of(distance)
      integer(long), intent(in) :: distance
      integer, parameter :: edge = 200
      type(place_table_t) :: table
      integer :: status, i, j, number, wrong
      call table%reserve(1, status)
      wrong = 0
      do j = 0, edge - 1
         do i = 0, edge - 1
            call table%enter([i, j]*distance, number)
            if (number /= 1 + i + edge*j .or. table%n /= number) wrong = wrong + 1
         end do
      end do
      call check(wrong == 0, 'new places get the next number, while the table grows')
      wrong = 0
      do j = edge, 0, -1
         do i = edge, 0, -1
            number = merge(1 + i + edge*j, 0, max(i, j) < edge)
            if (table%number_of([i, j]*distance) /= number) wrong = wrong + 1
            if (number == 0) cycle
            call table%enter([i, j]*distance, number)
            if (number /= 1 + i + edge*j) wrong = wrong + 1
         end do
      end do
      call check(wrong == 0, 'known places keep their number, and unknown ones have none')
      call check(table%n == edge**2, 'which looking does not change')
   end subroutine lattice_of

   !> Corners, some of them and other places in any order, have the numbers of a table that knows of no lattice.
   subroutine corners_of_a_lattice()
      integer(long), parameter :: width = 8
      integer, parameter :: cells(ndim) = [7, 3]
      type(place_table_t) :: plain, table
      integer(long) :: place(ndim)
      real(dp) :: r(ndim)
      integer :: status, k, i, j, expected, number, wrong
      call plain%reserve(1, status)
      call table%reserve(1, status, cells, width)
      wrong = 0
      do k = 1, 4000
         call random_number(r)
         place = nint(r*90 - 20, long)           ! some before, some behind the lattice
         if (mod(k, 3) == 0) place = width*nint(r*11 - 2)
         if (plain%number_of(place) /= table%number_of(place)) wrong = wrong + 1
         if (mod(k, 5) == 0) cycle
         call plain%enter(place, expected)
         call table%enter(place, number)
         if (number /= expected .or. table%n /= plain%n .or. table%number_of(place) /= expected) wrong = wrong + 1
      end do
      call check(wrong == 0, 'the corners of a lattice have the numbers that they have without it')
      call table%number_by_rows()
      expected = 0
      wrong = 0
      do j = -30, 80
         do i = -30, 80
            number = table%number_of([integer(long) :: i, j])
            if (number == 0) cycle
            expected = expected + 1
            if (number /= expected) wrong = wrong + 1
         end do
      end do
      call check(wrong == 0 .and. expected == table%n, 'and row by row they follow each other')
   end subroutine corners_of_a_lattice

   !> Places all over the range of a forest, many of them twice, compared with a list that is searched through.
   subroutine random_places()
      integer, parameter :: n = 2000
      type(place_table_t) :: table
      integer(long) :: place(ndim), known(ndim, n)
      real(dp) :: r(ndim)
      integer :: status, k, j, distinct, number, wrong
      call table%reserve(n, status)
      distinct = 0
      wrong = 0
      do k = 1, n
         call random_number(r)
         if (k > n/2) r = anint(40*r)/40
         place = int(scale(r, 40), long)
         do j = 1, distinct
            if (all(known(:, j) == place)) exit
         end do
         distinct = max(distinct, j)
         known(:, j) = place
         call table%enter(place, number)
         if (number /= j) wrong = wrong + 1
      end do
      call check(wrong == 0 .and. table%n == distinct, 'random places are numbered as a plain list numbers them')
      call check(distinct < n, 'and some came twice')
   end subroutine random_places

   !> The table reckons modulo the prime 2**31 - 1, so that in the last direction it cannot tell that coordinate from 0 when it
   !> looks for a seat. Such places have to be told apart by themselves.
   subroutine equal_hashes()
      integer(long), parameter :: prime = 2_long**31 - 1
      integer, parameter :: n = 5000
      type(place_table_t) :: table
      integer :: status, k, number, wrong
      call table%reserve(1, status)
      wrong = 0
      do k = 1, n
         call table%enter([int(k, long), 0_long], number)
         if (number /= 2*k - 1) wrong = wrong + 1
         if (table%number_of([int(k, long), prime]) /= 0) wrong = wrong + 1
         call table%enter([int(k, long), prime], number)
         if (number /= 2*k) wrong = wrong + 1
      end do
      do k = 1, n
         if (table%number_of([int(k, long), 0_long]) /= 2*k - 1) wrong = wrong + 1
         if (table%number_of([int(k, long), prime]) /= 2*k) wrong = wrong + 1
      end do
      call check(wrong == 0, 'places that begin to look at the same seat are told apart')
   end subroutine equal_hashes
end program test_place_table
