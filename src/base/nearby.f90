!> Which of many places are near another one, each with a reach of its own. A table finds them in buckets of a lattice, one lattice
!> for each power of two of the reaches; a bucket of a coarse lattice has a second list, of the places of all finer ones. Building
!> takes a time linear in the number of places, a search one in the number of those near.
module hampm_nearby
   use hampm_kinds, only: dp, ndim, long
   use hampm_place_table, only: place_table_t
   implicit none
   private
   public :: nearby_t

   integer, parameter :: levels = 24             !! of lattices

   !> Places and their buckets.
   type :: nearby_t
      logical :: is_built = .false.
      real(dp), private :: edge = 0              !! half of that of the finest buckets [m]
      integer, private :: top = 0                !! the coarsest lattice
      real(dp), allocatable, private :: x(:, :), reach(:) !! [m]
      type(place_table_t), private :: lists
      integer, allocatable, private :: first(:)  !! entry of each list, 0 for none
      integer, allocatable, private :: next(:), place(:) !! of each entry: the next one in its list, 0 for none, and its place
   contains
      procedure :: sort
      procedure :: find
   end type nearby_t

contains

   !> Sort places into buckets.
   pure subroutine sort(self, x, reach)
      class(nearby_t), intent(inout) :: self
      real(dp), intent(in) :: x(:, :)            !! [m], (ndim, places)
      real(dp), intent(in) :: reach(:)           !! above 0 [m], (places)
      integer :: own(size(reach)), k, list, level, entry, status
      self%is_built = .true.
      allocate (self%x, source=x)
      allocate (self%reach, source=reach)
      self%edge = max(minval(reach), scale(maxval(reach), 2 - levels))
      own = level_of(self, reach)
      self%top = maxval(own)
      allocate (self%first(sum(self%top + 1 - own)), source=0)
      allocate (self%next(size(self%first)), self%place(size(self%first)))
      call self%lists%reserve(size(self%first), status)
      entry = 0
      do k = size(reach), 1, -1
         do level = own(k), self%top
            entry = entry + 1
            call self%lists%enter(key_of(level, level > own(k), bucket_at(self, level, x(:, k))), list)
            self%place(entry) = k
            self%next(entry) = self%first(list)
            self%first(list) = entry
         end do
      end do
   end subroutine sort

   !> Find the places that are nearer to x along each axis than a reach, or than their own, in the order of their numbers.
   pure subroutine find(self, x, reach, found, visits)
      class(nearby_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: reach              !! [m]
      integer, allocatable, intent(out) :: found(:)
      integer, intent(inout), optional :: visits !! places compared so far
      integer(long), dimension(ndim) :: from, to, at
      integer, allocatable :: more(:)
      integer :: least, level, k, d, list, n, i
      least = min(level_of(self, reach), self%top)
      allocate (found(16))
      n = 0
      do list = least - 1, self%top              ! first that of all places finer than the reach
         level = max(list, least)
         from = bucket_at(self, level, x - max(reach, scale(self%edge, level)))
         to = bucket_at(self, level, x + max(reach, scale(self%edge, level)))
         at = from
         do while (at(ndim) <= to(ndim))
            k = self%lists%number_of(key_of(level, list < least, at))
            if (k > 0) k = self%first(k)
            do while (k > 0)
               if (present(visits)) visits = visits + 1
               associate (place => self%place(k))
                  if (all(abs(self%x(:, place) - x) <= max(reach, self%reach(place)))) then
                     do i = n, 1, -1             ! the last one before it
                        if (found(i) <= place) exit
                     end do
                     if (n == size(found)) then
                        allocate (more(2*n))
                        more(:n) = found
                        call move_alloc(more, found)
                     end if
                     if (.not. any(found(max(1, i):i) == place)) then
                        found(i + 2:n + 1) = found(i + 1:n)
                        found(i + 1) = place
                        n = n + 1
                     end if
                  end if
               end associate
               k = self%next(k)
            end do
            do d = 1, ndim                       ! the next bucket, row by row
               at(d) = at(d) + 1
               if (at(d) <= to(d) .or. d == ndim) exit
               at(d) = from(d)
            end do
         end do
      end do
      found = found(:n)
   end subroutine find

   !> The lattice whose buckets are up to twice as long as a reach.
   elemental integer function level_of(self, reach) result(level)
      class(nearby_t), intent(in) :: self
      real(dp), intent(in) :: reach              !! [m]
      level = max(1, exponent(reach/self%edge))
   end function level_of

   !> The bucket of a level that a place is in.
   pure function bucket_at(self, level, x) result(bucket)
      class(nearby_t), intent(in) :: self
      integer, intent(in) :: level
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer(long) :: bucket(ndim)
      bucket = floor(x/scale(self%edge, level), long)
   end function bucket_at

   !> The place in the table of a list of a bucket.
   pure function key_of(level, is_of_finer, bucket) result(key)
      integer, intent(in) :: level
      logical, intent(in) :: is_of_finer
      integer(long), intent(in) :: bucket(ndim)
      integer(long) :: key(ndim)
      key = bucket
      key(1) = 2*(levels*key(1) + level - 1) + merge(1, 0, is_of_finer)
   end function key_of
end module hampm_nearby
