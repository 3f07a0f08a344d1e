!> A table that numbers integer places in the order of first occurrence, by open addressing with linear probing. Where most places
!> are corners of a lattice, an array has their numbers.
module hampm_place_table
   use hampm_kinds, only: ndim, long
   implicit none
   private
   public :: place_table_t

   !> The places met so far, and where their numbers are found.
   type :: place_table_t
      integer :: n = 0                                  !! places numbered so far
      integer, allocatable, private :: corner(:)        !! number of each lattice corner, row by row from 0 on; 0 if none
      integer, private :: extent(ndim) = 0              !! corners of the lattice in each direction
      integer, private :: bits = 0                      !! binary logarithm of its width
      integer, private :: seated = 0                    !! places that are no such corners
      integer, allocatable, private :: number(:)        !! number in each seat, 0 where it is free, (seats), a power of 2
      integer(long), allocatable, private :: place(:, :) !! place in each seat, (ndim, seats)
   contains
      procedure :: reserve
      procedure :: enter
      procedure :: number_of
      procedure :: number_by_rows
   end type place_table_t

contains

   !> Room for `n` places at first. `status` is not 0 where the memory does not suffice.
   pure subroutine reserve(self, n, status, cells, width)
      class(place_table_t), intent(inout) :: self
      integer, intent(in) :: n
      integer, intent(out) :: status
      integer, intent(in), optional :: cells(ndim)      !! of the lattice in each direction
      integer(long), intent(in), optional :: width      !! of these, a power of 2
      integer, parameter :: most_seats = 2**30
      integer :: seats
      status = 0
      if (present(cells) .and. present(width)) then
         self%bits = trailz(width)
         self%extent = cells + 1
         allocate (self%corner(0:product(self%extent) - 1), stat=status)
         if (status /= 0) return
         self%corner = 0
      end if
      seats = 16
      do while (seats/2 < n - corners_in(self) .and. seats < most_seats)
         seats = 2*seats
      end do
      allocate (self%number(0:seats - 1), self%place(ndim, 0:seats - 1), stat=status)
      if (status == 0) self%number = 0
   end subroutine reserve

   !> Number of corners in the array.
   pure integer function corners_in(self)
      class(place_table_t), intent(in) :: self
      corners_in = 0
      if (allocated(self%corner)) corners_in = size(self%corner)
   end function corners_in

   !> Where in the array a place is; negative where it is not.
   pure integer function in_array(self, place) result(at)
      class(place_table_t), intent(in) :: self
      integer(long), intent(in) :: place(ndim)
      integer :: d
      at = -1
      if (.not. allocated(self%corner)) return
      if (any(place < 0 .or. shiftl(shiftr(place, self%bits), self%bits) /= place)) return
      if (any(shiftr(place, self%bits) >= self%extent)) return
      at = 0
      do d = ndim, 1, -1
         at = at*self%extent(d) + int(shiftr(place(d), self%bits))
      end do
   end function in_array

   !> The place of a corner of the array.
   pure function place_of_corner(self, at) result(place)
      class(place_table_t), intent(in) :: self
      integer, intent(in) :: at
      integer(long) :: place(ndim)
      integer :: d, rest
      rest = at
      do d = 1, ndim
         place(d) = shiftl(int(mod(rest, self%extent(d)), long), self%bits)
         rest = rest/self%extent(d)
      end do
   end function place_of_corner

   !> Number of a place, which gets the next one where it is new.
   pure subroutine enter(self, place, number)
      class(place_table_t), intent(inout) :: self
      integer(long), intent(in) :: place(ndim)
      integer, intent(out) :: number
      integer :: seat, at
      at = in_array(self, place)
      if (at >= 0) then
         if (self%corner(at) == 0) then
            self%n = self%n + 1
            self%corner(at) = self%n
         end if
         number = self%corner(at)
         return
      end if
      seat = seat_of(self, place)
      if (self%number(seat) == 0) then
         self%n = self%n + 1
         self%seated = self%seated + 1
         self%number(seat) = self%n
         self%place(:, seat) = place
         number = self%n
         if (self%seated > size(self%number)/2) call grow(self)
      else
         number = self%number(seat)
      end if
   end subroutine enter

   !> Number the places met so far anew, row by row: then those beside each other have numbers that follow each other.
   pure subroutine number_by_rows(self)
      class(place_table_t), intent(inout) :: self
      integer(long), allocatable :: place(:, :)         ! by number
      integer, allocatable :: order(:), merged(:), number(:)
      integer :: i, j, k, first, middle, last, width
      allocate (place(ndim, self%n), number(self%n))
      if (allocated(self%corner)) then
         do i = 0, size(self%corner) - 1
            if (self%corner(i) > 0) place(:, self%corner(i)) = place_of_corner(self, i)
         end do
      end if
      do k = 0, size(self%number) - 1
         if (self%number(k) > 0) place(:, self%number(k)) = self%place(:, k)
      end do
      order = [(k, k=1, self%n)]
      merged = order
      width = 1
      do while (width < self%n)                         ! merge sorted pieces of that width
         do first = 1, self%n, 2*width
            middle = min(first + width, self%n + 1)
            last = min(first + 2*width, self%n + 1) - 1
            if (middle <= last) then
               i = first
               j = middle
               do k = first, last
                  if (j > last) then
                     merged(k:last) = order(i:middle - 1)
                     exit
                  else if (i == middle) then
                     merged(k:last) = order(j:last)
                     exit
                  else if (is_before(place(:, order(j)), place(:, order(i)))) then
                     merged(k) = order(j)
                     j = j + 1
                  else
                     merged(k) = order(i)
                     i = i + 1
                  end if
               end do
            else
               merged(first:last) = order(first:last)
            end if
         end do
         order = merged
         width = 2*width
      end do
      number(order) = [(k, k=1, self%n)]
      if (allocated(self%corner)) then
         do i = 0, size(self%corner) - 1
            if (self%corner(i) > 0) self%corner(i) = number(self%corner(i))
         end do
      end if
      do k = 0, size(self%number) - 1
         if (self%number(k) > 0) self%number(k) = number(self%number(k))
      end do
   end subroutine number_by_rows

   !> Whether a place comes before another one, row by row.
   pure logical function is_before(a, b)
      integer(long), intent(in) :: a(ndim), b(ndim)
      integer :: d
      do d = ndim, 2, -1
         if (a(d) /= b(d)) exit
      end do
      is_before = a(d) < b(d)
   end function is_before

   !> Double the number of seats.
   pure subroutine grow(self)
      class(place_table_t), intent(inout) :: self
      integer, allocatable :: number(:)
      integer(long), allocatable :: place(:, :)
      integer :: k, seat
      call move_alloc(self%number, number)
      call move_alloc(self%place, place)
      allocate (self%number(0:2*size(number) - 1), source=0)
      allocate (self%place(ndim, 0:2*size(number) - 1))
      do k = 0, size(number) - 1
         if (number(k) == 0) cycle
         seat = seat_of(self, place(:, k))
         self%number(seat) = number(k)
         self%place(:, seat) = place(:, k)
      end do
   end subroutine grow

   !> Number of a place, 0 where it has none.
   pure integer function number_of(self, place)
      class(place_table_t), intent(in) :: self
      integer(long), intent(in) :: place(ndim)
      integer :: at
      at = in_array(self, place)
      if (at >= 0) then
         number_of = self%corner(at)
      else
         number_of = self%number(seat_of(self, place))
      end if
   end function number_of

   !> The seat that holds a place, or the free one where it would be.
   pure integer function seat_of(self, place) result(seat)
      class(place_table_t), intent(in) :: self
      integer(long), intent(in) :: place(ndim)
      integer(long), parameter :: prime = 2147483647_long, factor = 48271_long, low_bits = 2_long**31 - 1
      integer(long) :: mixed
      integer :: d
      mixed = 0
      do d = 1, ndim
         mixed = mod(mixed*factor + iand(place(d), low_bits), prime)
         mixed = mod(mixed*factor + ishft(place(d), -31), prime)
      end do
      seat = int(iand(mod(mixed*factor, prime), int(size(self%number) - 1, long)))
      do while (self%number(seat) /= 0)
         if (all(self%place(:, seat) == place)) return
         seat = mod(seat + 1, size(self%number))
      end do
   end function seat_of
end module hampm_place_table
