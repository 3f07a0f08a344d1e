!> The forest: a lattice of square root cells that covers the model, each the root of a quadtree. Its leaves are the cells of
!> the model, stored as one array: root by root, in Morton order within a root (a linear quadtree, as in p4est).
!>
!> Places are integer coordinates on the lattice of the finest cells that can be, `deepest` levels below the root: exact,
!> so that leaves and nodes are found by equality and never by comparing real numbers.
!>
!> Adapting and balancing are separate steps; nodes are numbered when a grid is built (`hampm_grid`).
module hampm_forest
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_tolerance, only: position_tolerance
   implicit none
   private
   public :: forest_t, outside, corner_offset, level_width, deepest

   integer, parameter :: outside = 0             !! the leaf of a place that the lattice does not cover
   integer, parameter :: deepest = merge(24, 20, ndim == 2) !! levels below the root of the finest lattice
   integer(long), parameter :: root_size = 2_long**deepest

   !> The leaves of all trees, in Morton order.
   type :: forest_t
      real(dp) :: lower(ndim) = 0                !! lower corner of the lattice [m]
      real(dp) :: cell = 0                       !! size of a root cell [m]
      integer :: cells(ndim) = 0                 !! number of root cells in each direction
      ! Not allocated as long as every root is a leaf
      integer, allocatable :: level(:)           !! of each leaf below its root, (leaves)
      integer(long), allocatable :: place(:, :)  !! lower corner of each leaf, (ndim, leaves)
      integer, allocatable :: first_leaf(:)      !! of each root, (roots + 1)
   contains
      procedure :: leaf_count
      procedure :: leaf_at
      procedure :: leaf_of
      procedure :: leaves_of_root
      procedure :: leaves_in
      procedure :: place_at
      procedure :: place_of
      procedure :: level_of
      procedure :: size_of
      procedure :: middle_of
      procedure :: way_out
      procedure :: finest_level
      procedure :: is_uniform
      procedure :: meets_finer
      procedure :: position
      procedure :: tolerance
      procedure :: adapt
      procedure :: balance
      procedure :: same_leaves
   end type forest_t

contains

   !> Number of leaves.
   pure integer function leaf_count(self)
      class(forest_t), intent(in) :: self
      if (self%is_uniform()) then
         leaf_count = product(self%cells)
      else
         leaf_count = size(self%level)
      end if
   end function leaf_count

   !> Whether every root is a leaf.
   pure logical function is_uniform(self)
      class(forest_t), intent(in) :: self
      is_uniform = .not. allocated(self%level)
   end function is_uniform

   !> The leaf that covers the place `x`; `outside` if there is none, or if `x` is NaN.
   pure integer function leaf_at(self, x)
      class(forest_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer(long) :: place(ndim)
      leaf_at = outside
      place = self%place_at(x)
      if (place(1) >= 0) leaf_at = self%leaf_of(place)
   end function leaf_at

   !> Integer coordinates of the finest cell that covers `x`; negative if there is none, or if `x` is NaN.
   pure function place_at(self, x) result(place)
      class(forest_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer(long) :: place(ndim)
      real(dp) :: lattice(ndim)
      lattice = (x - self%lower)/self%cell
      place = -1
      if (all(lattice >= 0 .and. lattice < self%cells)) place = int(lattice*root_size, long)
   end function place_at

   !> The leaf that covers the finest cell with the integer coordinates `place`, which is in the lattice.
   pure integer function leaf_of(self, place)
      class(forest_t), intent(in) :: self
      integer(long), intent(in) :: place(ndim)
      integer :: root, low, high, middle
      root = root_of(self, place)
      leaf_of = root
      if (self%is_uniform()) return
      low = self%first_leaf(root)
      high = self%first_leaf(root + 1) - 1
      do while (low < high)                      ! the last leaf that does not come after the place
         middle = (low + high + 1)/2
         if (precedes(place, self%place(:, middle))) then
            high = middle - 1
         else
            low = middle
         end if
      end do
      leaf_of = low
   end function leaf_of

   !> First and last leaf of the root cell with the lattice coordinates `c`, from 0.
   pure subroutine leaves_of_root(self, c, first, last)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: c(ndim)
      integer, intent(out) :: first, last
      integer :: root
      root = root_of(self, c*root_size)
      first = root
      last = root
      if (self%is_uniform()) return
      first = self%first_leaf(root)
      last = self%first_leaf(root + 1) - 1
   end subroutine leaves_of_root

   !> Leaves that a box meets, ascending.
   pure function leaves_in(self, lower, upper) result(leaves)
      class(forest_t), intent(in) :: self
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! corners of the box [m]
      integer, allocatable :: leaves(:)
      integer :: from(ndim), to(ndim), c(ndim), k, first, last, leaf, n
      real(dp) :: x(ndim), half
      from = int(min(max((lower - self%lower)/self%cell - 1, 0.0_dp), real(self%cells - 1, dp)))
      to = int(min(max((upper - self%lower)/self%cell + 1, 0.0_dp), real(self%cells - 1, dp)))
      n = 0
      do k = 1, product(to - from + 1)
         c = root_in_box(k)
         call self%leaves_of_root(c, first, last)
         n = n + last - first + 1
      end do
      allocate (leaves(n))
      n = 0
      do k = 1, product(to - from + 1)
         c = root_in_box(k)
         call self%leaves_of_root(c, first, last)
         do leaf = first, last
            x = self%middle_of(leaf)
            half = self%size_of(leaf)/2 + self%tolerance()
            if (any(x + half < lower .or. x - half > upper)) cycle
            n = n + 1
            leaves(n) = leaf
         end do
      end do
      leaves = leaves(:n)

   contains

      !> Lattice coordinates of one of the roots around the box.
      pure function root_in_box(k) result(c)
         integer, intent(in) :: k
         integer :: c(ndim), rest, d
         rest = k - 1
         do d = 1, ndim
            c(d) = from(d) + mod(rest, to(d) - from(d) + 1)
            rest = rest/(to(d) - from(d) + 1)
         end do
      end function root_in_box
   end function leaves_in

   !> Number of the root that covers a place.
   pure integer function root_of(self, place)
      class(forest_t), intent(in) :: self
      integer(long), intent(in) :: place(ndim)
      integer :: d
      root_of = 0
      do d = ndim, 1, -1
         root_of = root_of*self%cells(d) + int(place(d)/root_size)
      end do
      root_of = root_of + 1
   end function root_of

   !> Whether place `a` comes before `b` in Morton order: the highest bit in which they differ decides, of equal ones the bit of the
   !> last direction.
   pure logical function precedes(a, b)
      integer(long), intent(in) :: a(ndim), b(ndim)
      integer(long) :: difference, largest
      integer :: d, decisive
      decisive = 1
      largest = ieor(a(1), b(1))
      do d = 2, ndim
         difference = ieor(a(d), b(d))
         if (difference < largest .and. difference < ieor(difference, largest)) cycle
         decisive = d
         largest = difference
      end do
      precedes = a(decisive) < b(decisive)
   end function precedes

   !> Lower corner of a leaf.
   pure function place_of(self, leaf) result(place)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: leaf
      integer(long) :: place(ndim)
      integer :: rest, d
      if (.not. self%is_uniform()) then
         place = self%place(:, leaf)
         return
      end if
      rest = leaf - 1
      do d = 1, ndim
         place(d) = mod(rest, self%cells(d))*root_size
         rest = rest/self%cells(d)
      end do
   end function place_of

   !> Levels of a leaf below its root.
   pure integer function level_of(self, leaf)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: leaf
      level_of = 0
      if (.not. self%is_uniform()) level_of = self%level(leaf)
   end function level_of

   !> Edge length of a leaf [m].
   pure real(dp) function size_of(self, leaf)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: leaf
      size_of = self%cell/shiftl(1, self%level_of(leaf))
   end function size_of

   !> Distance of a place in a leaf, along a direction, from the edge at which it leaves the leaf [m]; huge for no direction.
   pure real(dp) function way_out(self, leaf, x, direction, none) result(way)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: leaf
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      real(dp), intent(in) :: none               !! component of the direction that counts as none
      real(dp) :: lower(ndim)
      integer :: d
      lower = self%position(self%place_of(leaf))
      way = huge(way)
      do d = 1, ndim
         if (abs(direction(d)) > none) &
            way = min(way, (lower(d) + merge(self%size_of(leaf), 0.0_dp, direction(d) > 0) - x(d))/direction(d))
      end do
   end function way_out

   !> Middle of a leaf [m].
   pure function middle_of(self, leaf) result(x)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: leaf
      real(dp) :: x(ndim)
      integer(long) :: lower(ndim)
      lower = self%place_of(leaf)
      x = self%position(lower) + self%size_of(leaf)/2
   end function middle_of

   !> The finest level of any leaf.
   pure integer function finest_level(self)
      class(forest_t), intent(in) :: self
      finest_level = 0
      if (.not. self%is_uniform()) finest_level = maxval(self%level)
   end function finest_level

   !> Position of the lattice point with integer coordinates `place` [m].
   pure function position(self, place) result(x)
      class(forest_t), intent(in) :: self
      integer(long), intent(in) :: place(ndim)
      real(dp) :: x(ndim)
      x = self%lower + place*(self%cell/root_size)
   end function position

   !> Distance below which two positions are the same [m].
   pure real(dp) function tolerance(self)
      class(forest_t), intent(in) :: self
      tolerance = position_tolerance(self%cell, self%lower, self%lower + self%cells*self%cell)
   end function tolerance

   !> Edge length of a cell of a level in integer coordinates.
   pure integer(long) function level_width(level)
      integer, intent(in) :: level
      level_width = shiftr(root_size, level)
   end function level_width

   !> Refine the leaves with `change` > 0 by one level, and recombine those with `change` < 0 by one, where all leaves of a
   !> family have it.
   pure subroutine adapt(self, change)
      class(forest_t), intent(inout) :: self
      integer, intent(in) :: change(:)           !! (leaves)
      integer, allocatable :: level(:)
      integer(long), allocatable :: place(:, :)
      integer :: leaf, n, c
      if (self%is_uniform()) call store_roots(self)
      n = size(change) + (corners - 1)*count(change > 0)
      allocate (level(n), place(ndim, n))
      n = 0
      leaf = 1
      do while (leaf <= size(change))
         if (change(leaf) > 0) then
            do c = 1, corners
               level(n + c) = self%level(leaf) + 1
               place(:, n + c) = self%place(:, leaf) + corner_offset(c)*level_width(self%level(leaf) + 1)
            end do
            n = n + corners
            leaf = leaf + 1
         else
            n = n + 1
            level(n) = self%level(leaf)
            place(:, n) = self%place(:, leaf)
            if (family_recombines(self, leaf, change)) then
               level(n) = level(n) - 1
               leaf = leaf + corners
            else
               leaf = leaf + 1
            end if
         end if
      end do
      self%level = level(:n)
      self%place = place(:, :n)
      call count_leaves(self)
   end subroutine adapt

   !> Whether a leaf is the first of a family of leaves that all recombine.
   pure logical function family_recombines(self, leaf, change) result(yes)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: leaf
      integer, intent(in) :: change(:)
      yes = .false.
      if (self%level(leaf) == 0 .or. leaf + corners - 1 > size(change)) return
      if (any(mod(self%place(:, leaf), level_width(self%level(leaf) - 1)) /= 0)) return
      yes = all(change(leaf:leaf + corners - 1) < 0) .and. all(self%level(leaf:leaf + corners - 1) == self%level(leaf))
   end function family_recombines

   !> Store the roots as leaves.
   pure subroutine store_roots(self)
      class(forest_t), intent(inout) :: self
      integer :: leaf, n
      n = self%leaf_count()
      allocate (self%place(ndim, n), self%first_leaf(n + 1))
      do leaf = 1, n
         self%place(:, leaf) = self%place_of(leaf)
      end do
      allocate (self%level(n), source=0)
   end subroutine store_roots

   !> Find the first leaf of each root.
   pure subroutine count_leaves(self)
      class(forest_t), intent(inout) :: self
      integer :: leaf, root
      self%first_leaf = 0
      do leaf = 1, size(self%level)
         root = root_of(self, self%place(:, leaf))
         self%first_leaf(root + 1) = self%first_leaf(root + 1) + 1
      end do
      self%first_leaf(1) = 1
      do root = 2, size(self%first_leaf)
         self%first_leaf(root) = self%first_leaf(root) + self%first_leaf(root - 1)
      end do
   end subroutine count_leaves

   !> Refine until leaves that touch, at an edge or a corner, differ by one level at most (2:1 balance).
   pure subroutine balance(self)
      class(forest_t), intent(inout) :: self
      integer, allocatable :: change(:)
      integer :: leaf
      if (self%is_uniform()) return
      do
         allocate (change(size(self%level)), source=0)
         do leaf = 1, size(self%level)
            if (self%level(leaf) > 1) call mark_coarse_neighbours(self, leaf, change)
         end do
         if (all(change == 0)) return
         call self%adapt(change)
         deallocate (change)
      end do
   end subroutine balance

   !> Whether a leaf of a balanced forest has finer ones across a side, in space also across an edge.
   pure logical function meets_finer(self, leaf) result(meets)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: leaf
      integer(long) :: place(ndim), width
      integer :: d, k, outward(ndim)
      meets = .false.
      if (self%is_uniform()) return
      width = level_width(self%level(leaf))
      do k = 0, 3**ndim - 1
         outward = [(mod(k/3**d, 3) - 1, d=0, ndim - 1)]
         if (all(outward == 0) .or. all(outward /= 0)) cycle
         place = self%place(:, leaf) + merge(merge(width, -1_long, outward > 0), width/2, outward /= 0)
         if (any(place < 0 .or. place >= self%cells*root_size)) cycle
         meets = meets .or. self%level(self%leaf_of(place)) > self%level(leaf)
      end do
   end function meets_finer

   !> Mark the leaves around a leaf that are more than one level coarser. They are at least as large as two parents of the leaf: one
   !> check in each of the parent's neighbours that touch the leaf suffices.
   pure subroutine mark_coarse_neighbours(self, leaf, change)
      class(forest_t), intent(in) :: self
      integer, intent(in) :: leaf
      integer, intent(inout) :: change(:)
      integer(long) :: place(ndim), width, outward(ndim)
      integer :: k, neighbour
      width = level_width(self%level(leaf))
      outward = 2*mod(self%place(:, leaf)/width, 2_long) - 1  ! away from the siblings
      do k = 2, corners
         place = self%place(:, leaf) + corner_offset(k)*outward*width
         if (any(place < 0 .or. place >= self%cells*root_size)) cycle
         neighbour = self%leaf_of(place)
         if (self%level(neighbour) < self%level(leaf) - 1) change(neighbour) = 1
      end do
   end subroutine mark_coarse_neighbours

   !> Whether another forest on the same lattice has the same leaves.
   pure logical function same_leaves(self, other)
      class(forest_t), intent(in) :: self
      type(forest_t), intent(in) :: other
      same_leaves = .false.
      if (self%leaf_count() /= other%leaf_count()) return
      if (self%is_uniform() .or. other%is_uniform()) then
         same_leaves = self%finest_level() == 0 .and. other%finest_level() == 0
      else
         same_leaves = all(self%level == other%level) .and. all(self%place == other%place)
      end if
   end function same_leaves

   !> Which corner or child: 0 on the lower and 1 on the upper side in each direction.
   pure function corner_offset(corner) result(offset)
      integer, intent(in) :: corner
      integer :: offset(ndim)
      integer :: d
      do d = 1, ndim
         offset(d) = ibits(corner - 1, d - 1, 1)
      end do
   end function corner_offset
end module hampm_forest
