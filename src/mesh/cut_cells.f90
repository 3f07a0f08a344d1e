!> Cells that are cut by lines in any direction. A leaf that a line divides falls into pieces: each has an element over the square
!> of the leaf. A particle belongs to the piece at its place, and so to its element; a node has a copy for each connected part of
!> the pieces around it. So mass matrices decouple, and forces do not cross.
!>
!> Connected parts of a leaf are found on a lattice of samples: neighbours are connected unless a line runs between them, also
!> across the common edge of leaves. Lines may cross, meet, turn, run along grid lines and through corners. A sliver without a
!> sample does not count: a particle in it, a rare case, belongs to a neighbour. A point on a line belongs to one side, independent
!> of the order of the ends (`side_of_ties`); particles there are split (`hampm_matching`).
!>
!> A line that ends in a leaf does not divide it. A tip is moved on along the line to the edge of its leaf, and bonded points
!> (`hampm_interface_points`) hold the part that is not cut. A line along a grid line that ends between leaves stays.
module hampm_cut_cells
   use hampm_kinds, only: dp, ndim, long
   use hampm_disjoint_sets, only: disjoint_sets_t, singletons
   use hampm_forest, only: corner_offset, forest_t, outside, level_width
   use hampm_crack_lines, only: both_faces, find_nearest_segment, line_t
   use hampm_polygon, only: distance_to_segment, twice_area
   use hampm_tensors, only: norm, quarter_turn, in_plane
   implicit none
   private
   public :: cut_cells_t, end_leaf_t, place_of_copy, divides, side_of_ties, is_between, nearly_none, on_line, sample, &
             samples

   integer, parameter :: samples = 16            !! of a leaf in each direction
   integer, parameter :: near = 2                !! samples from a point within which one tells its piece
   integer, parameter :: around = 4              !! leaves at a place, at most
   integer, parameter :: nodes_along = 3         !! places at which a leaf may have nodes in each direction
   real(dp), parameter :: on_line = 1e-9_dp      !! distance within which a point is on a line, in cells of the lattice of roots
   real(dp), parameter :: nearly_none = 1e-6_dp  !! part of the way through a leaf that counts as none

   !> The leaf in which a line ends at a tip. Where cells are cut ahead of a tip, it is the last of them.
   type :: end_leaf_t
      integer :: line = 0
      integer :: end = 0                         !! 1 its first, 2 its last point
      integer :: leaf = 0                        !! 0 where the line ends where leaves meet: nothing is cut beyond it
      real(dp) :: tip(ndim) = 0                  !! [m]
      real(dp) :: direction(ndim) = 0            !! unit vector out of the line
      real(dp) :: front(ndim) = 0                !! where the extended line leaves the leaf [m]
   end type end_leaf_t

   !> The leaves at lines and their pieces.
   type :: cut_cells_t
      type(line_t), allocatable :: lines(:)
      type(end_leaf_t), allocatable :: ends(:)   !! one for each tip, in the order of the lines, the last point first
      real(dp), allocatable :: segment(:, :, :) !! of the lines, with their ends moved [m], (ndim, 2, segments)
      real(dp), allocatable :: side_of_ties(:) !! of each segment: 1 if points on it are to its left, else -1
      integer, allocatable :: entry(:)  !! of each leaf in the tables below, 0 where no line is near; (leaves)
      integer, allocatable :: first_near(:), near(:) !! the segments near each entry, in rows
      integer, allocatable :: n_pieces(:) !! of each entry
      integer, allocatable :: piece(:, :, :) !! in which each sample is, (samples, samples, entries)
      integer, allocatable, private :: first_piece(:) !! of each leaf with an entry, or beside one, in the next; 0 of others
      integer, allocatable, private :: copy(:, :, :) !! which copy of the nodes at its places each piece has; below 0
                                                 !! where no place of a leaf with an entry is; (nodes_along, nodes_along, pieces)
      real(dp) :: slack = 0                      !! distance within which a point is on a line [m]
   contains
      procedure :: are_there
      procedure :: pieces_of
      procedure :: segments_near
      procedure :: piece_at
      procedure :: is_in_sliver
      procedure :: follow
      procedure :: origin_of
      procedure :: find_nearest
      procedure :: freed_at
      procedure :: divide
      procedure :: cut_part
      procedure :: side_at
      procedure :: is_on_line
      procedure :: normal_at
      procedure, private :: certain_piece_at
      procedure, private :: is_near
      procedure :: copy_at
      procedure :: find_copies
   end type cut_cells_t

contains

   !> Whether there are any lines.
   pure logical function are_there(self)
      class(cut_cells_t), intent(in) :: self
      are_there = .false.
      if (allocated(self%segment)) are_there = size(self%segment, 3) > 0
   end function are_there

   !> Which components of a node at a place the growth of a crack on a symmetry plane has freed: the normal one, from where its tip
   !> was at first to where the cells that are cut end.
   pure function freed_at(self, x) result(freed)
      class(cut_cells_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      logical :: freed(ndim)
      real(dp) :: way
      integer :: k
      freed = .false.
      if (.not. self%are_there()) return
      do k = 1, size(self%ends)
         associate (end => self%ends(k), line => self%lines(self%ends(k)%line))
            if (line%face == both_faces) cycle
            way = dot_product(x - line%began, end%direction)
            if (way < -self%slack .or. way > dot_product(end%front - line%began, end%direction) - self%slack) cycle
            if (norm(x - line%began - way*end%direction) > self%slack) cycle
            freed = freed .or. .not. abs(end%direction) > 0
         end associate
      end do
   end function freed_at

   !> Place of a sample [m].
   pure function sample(forest, leaf, i, j) result(x)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf, i, j
      real(dp) :: x(ndim)
      x = forest%position(forest%place_of(leaf)) + in_plane(i - 0.5_dp, j - 0.5_dp)/samples*forest%size_of(leaf)
   end function sample

   !> Whether a line that is near a leaf runs between two points.
   pure logical function is_between(cut, leaf, p, q)
      type(cut_cells_t), intent(in) :: cut
      integer, intent(in) :: leaf
      real(dp), intent(in) :: p(ndim), q(ndim)   !! [m]
      integer :: k
      is_between = .false.
      if (cut%entry(leaf) == 0) return
      do k = cut%first_near(cut%entry(leaf)), cut%first_near(cut%entry(leaf) + 1) - 1
         associate (a => cut%segment(:, 1, cut%near(k)), b => cut%segment(:, 2, cut%near(k)))
            is_between = runs_between(a, b, p, q, cut%slack*cut%side_of_ties(cut%near(k)))
            if (is_between) return
         end associate
      end do
   end function is_between

   !> Whether the segment from a to b runs between two points: one that ends on the way between them does.
   pure logical function runs_between(a, b, p, q, slack) result(runs)
      real(dp), intent(in) :: a(ndim), b(ndim), p(ndim), q(ndim) !! [m]
      real(dp), intent(in) :: slack              !! as in `is_left` [m]
      runs = all(min(a, b) - abs(slack) <= max(p, q)) .and. all(max(a, b) + abs(slack) >= min(p, q))
      if (runs) runs = is_left(a, b, p, slack) .neqv. is_left(a, b, q, slack)
      if (runs) runs = (is_left(p, q, a, abs(slack)) .or. is_left(p, q, b, abs(slack))) .and. &
                       .not. (is_left(p, q, a, -abs(slack)) .and. is_left(p, q, b, -abs(slack)))
   end function runs_between

   !> The side of a segment to which points on it belong: above it, or to the left of a vertical one, whichever end is the first; 1
   !> where that is to the left in the direction of the segment, else -1.
   pure real(dp) function side_of_ties(direction) result(side)
      real(dp), intent(in) :: direction(ndim)    !! of the segment, of any length
      logical :: is_vertical
      is_vertical = abs(direction(1)) <= nearly_none*abs(direction(2))
      side = merge(1, -1, merge(direction(2) > 0, direction(1) > 0, is_vertical))
   end function side_of_ties

   !> Whether a point is to the left of the line from a to b, or within `slack` of it; if that is below 0, beyond it.
   pure logical function is_left(a, b, p, slack)
      real(dp), intent(in) :: a(ndim), b(ndim), p(ndim) !! [m]
      real(dp), intent(in) :: slack              !! [m]
      is_left = (b(1) - a(1))*(p(2) - a(2)) - (b(2) - a(2))*(p(1) - a(1)) >= -slack*norm(b - a)
   end function is_left

   !> Number of pieces of a leaf.
   pure integer function pieces_of(self, leaf)
      class(cut_cells_t), intent(in) :: self
      integer, intent(in) :: leaf
      pieces_of = 1
      if (.not. allocated(self%entry)) return
      if (self%entry(leaf) > 0) pieces_of = self%n_pieces(self%entry(leaf))
   end function pieces_of

   !> The segments of lines, with their ends where cells are cut, that are near a leaf [m], (ndim, 2, segments).
   pure function segments_near(self, leaf) result(segments)
      class(cut_cells_t), intent(in) :: self
      integer, intent(in) :: leaf
      real(dp), allocatable :: segments(:, :, :)
      if (self%is_near(leaf)) then
         segments = self%segment(:, :, self%near(self%first_near(self%entry(leaf)):self%first_near(self%entry(leaf) + 1) - 1))
      else
         allocate (segments(ndim, 2, 0))
      end if
   end function segments_near

   !> The piece of a leaf at a point: the piece of the nearest sample without a line between or, if none is near, of the nearest
   !> sample. A point outside of the leaf has the piece on its side.
   pure integer function piece_at(self, forest, leaf, x) result(piece)
      class(cut_cells_t), intent(in) :: self
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer :: at(ndim)
      piece = self%certain_piece_at(forest, leaf, x, near)
      if (piece == 0) piece = self%certain_piece_at(forest, leaf, x, samples)
      if (piece > 0) return
      at = sample_at(forest, leaf, x)
      piece = self%piece(at(1), at(2), self%entry(leaf))
   end function piece_at

   !> Whether a place is in a sliver of a leaf: a line divides it from all samples there, so that it is in none of the pieces.
   pure logical function is_in_sliver(self, forest, leaf, x)
      class(cut_cells_t), intent(in) :: self
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      real(dp), intent(in) :: x(ndim)            !! [m]
      is_in_sliver = .false.
      if (.not. self%is_near(leaf)) return
      if (self%certain_piece_at(forest, leaf, x, near) > 0) return
      is_in_sliver = self%certain_piece_at(forest, leaf, x, samples) == 0
   end function is_in_sliver

   !> The place of material that began at `origin` if it had kept its distance from the line next to it, and so its side, for any
   !> opening or interpenetration of the faces [m]. Where lines stay, it is `origin`.
   pure function follow(self, origin) result(x)
      class(cut_cells_t), intent(in) :: self
      real(dp), intent(in) :: origin(ndim)       !! in the reference configuration [m]
      real(dp) :: x(ndim)
      real(dp) :: nearest, along, across
      integer :: line, k
      x = origin
      nearest = huge(nearest)
      do line = 1, size(self%lines)
         if (.not. allocated(self%lines(line)%origin)) cycle
         call find_nearest_segment(self%lines(line)%origin, origin, nearest, k, along)
         if (k == 0) cycle
         associate (a => self%lines(line)%origin(:, k - 1), b => self%lines(line)%origin(:, k), &
                    from => self%lines(line)%points(:, k - 1), to => self%lines(line)%points(:, k))
            across = twice_area(a, b, origin)/norm(b - a)
            x = from + along*(to - from) + across*quarter_turn(to - from)/norm(to - from)
         end associate
      end do
   end function follow

   !> Where a place on a line was in the reference configuration [m]. Where lines stay, that is the place.
   pure function origin_of(self, line, x) result(origin)
      class(cut_cells_t), intent(in) :: self
      integer, intent(in) :: line
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: origin(ndim)
      real(dp) :: nearest, along
      integer :: k
      origin = x
      nearest = huge(nearest)
      associate (of => self%lines(line))
         if (.not. allocated(of%origin)) return
         call find_nearest_segment(of%points, x, nearest, k, along)
         if (k > 0) origin = of%origin(:, k - 1) + along*(of%origin(:, k) - of%origin(:, k - 1))
      end associate
   end function origin_of

   !> The nearest point of all lines, or of one, to a place, and the unit vector to the left of its line.
   pure subroutine find_nearest(self, x, point, normal, of)
      class(cut_cells_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(out) :: point(ndim)       !! [m]
      real(dp), intent(out) :: normal(ndim)
      integer, intent(in), optional :: of        !! this line only
      real(dp) :: nearest, along
      integer :: line, k, first, last
      point = x
      normal = 0
      nearest = huge(nearest)
      first = 1
      last = size(self%lines)
      if (present(of)) first = of
      if (present(of)) last = of
      do line = first, last
         call find_nearest_segment(self%lines(line)%points, x, nearest, k, along)
         if (k == 0) cycle
         associate (a => self%lines(line)%points(:, k - 1), b => self%lines(line)%points(:, k))
            point = a + min(max(along, 0.0_dp), 1.0_dp)*(b - a)
            normal = quarter_turn(b - a)/norm(b - a)
         end associate
      end do
   end subroutine find_nearest

   !> Whether a line runs between two places in the reference configuration.
   pure logical function divide(self, p, q)
      class(cut_cells_t), intent(in) :: self
      real(dp), intent(in) :: p(ndim), q(ndim)   !! [m]
      integer :: line
      divide = .false.
      do line = 1, size(self%lines)
         if (allocated(self%lines(line)%origin)) then
            divide = divides(self%lines(line)%origin, p, q, self%slack)
         else
            divide = divides(self%lines(line)%points, p, q, self%slack)
         end if
         if (divide) return
      end do
   end function divide

   !> A line in the reference configuration, with its ends where the cut of the cells ends [m].
   pure function cut_part(self, line) result(points)
      class(cut_cells_t), intent(in) :: self
      integer, intent(in) :: line
      real(dp), allocatable :: points(:, :)
      integer :: k, last
      points = self%lines(line)%points
      if (allocated(self%lines(line)%origin)) points = self%lines(line)%origin
      do k = 1, size(self%ends)
         associate (end => self%ends(k))
            if (end%line /= line .or. end%leaf == 0) cycle
            last = merge(1, size(points, 2), end%end == 1)
            if (allocated(self%lines(line)%origin)) then ! as far ahead of the tip as it is now
               associate (out => points(:, last) - points(:, merge(2, last - 1, end%end == 1)))
                  points(:, last) = points(:, last) + dot_product(end%front - end%tip, end%direction)*out/norm(out)
               end associate
            else
               points(:, last) = end%front
            end if
         end associate
      end do
   end function cut_part

   !> Whether a polyline runs between two points.
   pure logical function divides(points, p, q, slack)
      real(dp), contiguous, intent(in) :: points(:, :) !! [m], (ndim, 2 or more)
      real(dp), intent(in) :: p(ndim), q(ndim)   !! [m]
      real(dp), intent(in) :: slack              !! [m]
      real(dp) :: along(ndim)
      integer :: k
      divides = .false.
      do k = 2, size(points, 2)
         along = points(:, k) - points(:, k - 1)
         divides = runs_between(points(:, k - 1), points(:, k), p, q, slack*side_of_ties(along))
         if (divides) return
      end do
   end function divides

   !> Side of the nearest line on which a point of a leaf is: 1 to the left in the order of the points of the line, -1 to the right;
   !> 0 in a leaf that is not divided. Where a kink is nearest, its segment decides that, as a straight line, is farther from the
   !> point.
   pure integer function side_at(self, leaf, x) result(side)
      class(cut_cells_t), intent(in) :: self
      integer, intent(in) :: leaf
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: along(ndim), place, distance, nearest, height, farthest
      integer :: k
      side = 0
      if (self%pieces_of(leaf) < 2) return
      nearest = huge(nearest)
      farthest = 0
      do k = self%first_near(self%entry(leaf)), self%first_near(self%entry(leaf) + 1) - 1
         associate (a => self%segment(:, 1, self%near(k)), b => self%segment(:, 2, self%near(k)))
            along = (b - a)/norm(b - a)
            place = min(max(dot_product(x - a, along), 0.0_dp), norm(b - a))
            distance = norm(x - a - place*along)
            height = abs(along(1)*(x(2) - a(2)) - along(2)*(x(1) - a(1)))
            if (distance > nearest + self%slack) cycle
            if (distance > nearest - self%slack .and. height <= farthest) cycle
            nearest = distance
            farthest = height
            side = merge(1, -1, is_left(a, b, x, self%slack*self%side_of_ties(self%near(k))))
         end associate
      end do
   end function side_at

   !> Whether material of a leaf that lines divide is on one of them, or on its planned extension.
   pure logical function is_on_line(self, leaf, origin)
      class(cut_cells_t), intent(in) :: self
      integer, intent(in) :: leaf
      real(dp), intent(in) :: origin(ndim)       !! in the reference configuration [m]
      real(dp) :: x(ndim)
      integer :: k
      is_on_line = .false.
      if (self%pieces_of(leaf) < 2) return
      x = self%follow(origin)
      do k = self%first_near(self%entry(leaf)), self%first_near(self%entry(leaf) + 1) - 1
         is_on_line = distance_to_segment(x, self%segment(:, 1, self%near(k)), self%segment(:, 2, self%near(k))) <= self%slack
         if (is_on_line) return
      end do
   end function is_on_line

   !> Normal of the line on which material of a leaf is, of any length: at a kink the sum of both, of which only the sign depends on
   !> the order of its points; 0 on no line, or several.
   pure function normal_at(self, leaf, origin) result(normal)
      class(cut_cells_t), intent(in) :: self
      integer, intent(in) :: leaf
      real(dp), intent(in) :: origin(ndim)       !! in the reference configuration [m]
      real(dp) :: normal(ndim), left(ndim), x(ndim)
      integer :: k, last
      normal = 0
      if (.not. self%is_on_line(leaf, origin)) return
      x = self%follow(origin)
      last = 0
      do k = self%first_near(self%entry(leaf)), self%first_near(self%entry(leaf) + 1) - 1
         associate (a => self%segment(:, 1, self%near(k)), b => self%segment(:, 2, self%near(k)))
            if (distance_to_segment(x, self%segment(:, 1, self%near(k)), self%segment(:, 2, self%near(k))) > self%slack) cycle
            left = quarter_turn(b - a)/norm(b - a)
            if (last == 0) then
               normal = left
            else if (last == self%near(k) - 1 .and. norm(self%segment(:, 2, max(last, 1)) - a) <= self%slack) then
               normal = normal + left
            else if (abs(normal(1)*left(2) - normal(2)*left(1)) > nearly_none*norm(normal)) then
               normal = 0
               return
            end if
            last = self%near(k)
         end associate
      end do
   end function normal_at

   !> The sample in whose part of a leaf a point is.
   pure function sample_at(forest, leaf, x) result(at)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer :: at(ndim)
      at = ceiling((x - forest%position(forest%place_of(leaf)))/forest%size_of(leaf)*samples)
      at = min(max(at, 1), samples)
   end function sample_at

   !> The piece of a leaf at a point: of the nearest sample within `reach` without a line between; 0 for none.
   pure integer function certain_piece_at(self, forest, leaf, x, reach) result(piece)
      class(cut_cells_t), intent(in) :: self
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer, intent(in) :: reach               !! samples
      real(dp) :: distance, nearest
      integer :: middle(ndim), i, j
      piece = 1
      if (.not. self%is_near(leaf)) return
      middle = sample_at(forest, leaf, x)        ! no other is nearer
      piece = self%piece(middle(1), middle(2), self%entry(leaf))
      if (.not. is_between(self, leaf, x, sample(forest, leaf, middle(1), middle(2)))) return
      piece = 0
      nearest = huge(nearest)
      do j = max(middle(2) - reach, 1), min(middle(2) + reach, samples)
         do i = max(middle(1) - reach, 1), min(middle(1) + reach, samples)
            distance = norm(sample(forest, leaf, i, j) - x)
            if (distance >= nearest) cycle
            if (is_between(self, leaf, x, sample(forest, leaf, i, j))) cycle
            nearest = distance
            piece = self%piece(i, j, self%entry(leaf))
         end do
      end do
   end function certain_piece_at

   !> Number, from 0 on, of the copy of the node, or hanging node, at a place that a piece of a leaf has: connected pieces of the
   !> leaves around the place have the same.
   pure integer function copy_at(self, forest, place, leaf, piece) result(copy)
      class(cut_cells_t), intent(in) :: self
      type(forest_t), intent(in) :: forest
      integer(long), intent(in) :: place(ndim)   !! in integer coordinates of the forest
      integer, intent(in) :: leaf, piece
      integer :: leaves(around), first(around), at(ndim)
      type(disjoint_sets_t) :: sets
      copy = 0
      if (self%first_piece(leaf) == 0) return
      at = place_in_leaf(forest, leaf, place)
      if (all(at > 0)) then
         copy = self%copy(at(1), at(2), self%first_piece(leaf) + piece - 1)
         if (copy >= 0) return
      end if
      leaves = leaves_around(forest, place)
      call connect_around(self, forest, place, leaves, first, sets)
      copy = sets%how_many(below=sets%least_of(first(findloc(leaves, leaf, dim=1)) + piece - 1))
   end function copy_at

   !> Find the copies of nodes at corners, and in the middle of sides and of leaves, that pieces near lines have.
   pure subroutine find_copies(self, forest)
      class(cut_cells_t), intent(inout) :: self
      type(forest_t), intent(in) :: forest
      integer :: leaves(around), first(around), at(ndim), leaf, i, j, k, n, piece
      integer(long) :: place(ndim)
      type(disjoint_sets_t) :: sets
      allocate (self%first_piece(size(self%entry)), source=0)
      n = 0
      do leaf = 1, size(self%entry)
         if (.not. self%is_near(leaf)) cycle
         do j = 1, nodes_along
            do i = 1, nodes_along
               leaves = leaves_around(forest, node_place(leaf, i, j))
               do k = 1, around
                  if (leaves(k) == outside) cycle
                  if (self%first_piece(leaves(k)) > 0) cycle
                  self%first_piece(leaves(k)) = n + 1
                  n = n + self%pieces_of(leaves(k))
               end do
            end do
         end do
      end do
      allocate (self%copy(nodes_along, nodes_along, n), source=-1)
      do leaf = 1, size(self%entry)
         if (.not. self%is_near(leaf)) cycle
         do j = 1, nodes_along
            do i = 1, nodes_along
               if (self%copy(i, j, self%first_piece(leaf)) >= 0) cycle
               place = node_place(leaf, i, j)
               leaves = leaves_around(forest, place)
               call connect_around(self, forest, place, leaves, first, sets)
               do k = 1, around
                  if (leaves(k) == outside) cycle
                  at = place_in_leaf(forest, leaves(k), place)
                  if (any(at == 0)) cycle
                  do piece = 1, self%pieces_of(leaves(k))
                     self%copy(at(1), at(2), self%first_piece(leaves(k)) + piece - 1) = &
                        sets%how_many(below=sets%least_of(first(k) + piece - 1))
                  end do
               end do
            end do
         end do
      end do
   contains
      !> One of the places of a leaf at which it may have nodes.
      pure function node_place(leaf, i, j) result(place)
         integer, intent(in) :: leaf, i, j       !! leaf, and which place along x and y
         integer(long) :: place(ndim)
         place = forest%place_of(leaf)
         place(:2) = place(:2) + [i - 1, j - 1]*(level_width(forest%level_of(leaf))/(nodes_along - 1))
      end function node_place
   end subroutine find_copies

   !> Index of a place among the possible nodes of a leaf, along x and y; 0 if it is none of them.
   pure function place_in_leaf(forest, leaf, place) result(at)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      integer(long), intent(in) :: place(ndim)
      integer :: at(ndim)
      integer(long) :: off(ndim), step
      off = place - forest%place_of(leaf)
      step = level_width(forest%level_of(leaf))/(nodes_along - 1)
      at = 0
      if (all(mod(off, step) == 0)) at = int(off/step) + 1
   end function place_in_leaf

   !> Connect the pieces of the leaves around a place.
   pure subroutine connect_around(self, forest, place, leaves, first, sets)
      class(cut_cells_t), intent(in) :: self
      type(forest_t), intent(in) :: forest
      integer(long), intent(in) :: place(ndim)
      integer, intent(in) :: leaves(around)      !! as `leaves_around` has them
      integer, intent(out) :: first(around)      !! member of the sets: the first piece of each
      type(disjoint_sets_t), intent(out) :: sets
      integer :: k, n
      n = 0
      do k = 1, around
         first(k) = 0
         if (leaves(k) == 0) cycle
         if (any(leaves(:k - 1) == leaves(k))) then
            first(k) = first(findloc(leaves(:k - 1), leaves(k), dim=1))
            cycle
         end if
         first(k) = n + 1
         n = n + self%pieces_of(leaves(k))
      end do
      call singletons(n, sets)
      call connect(self, forest, place, leaves([1, 2]), first([1, 2]), 1, -1, sets)
      call connect(self, forest, place, leaves([3, 4]), first([3, 4]), 1, 1, sets)
      call connect(self, forest, place, leaves([1, 3]), first([1, 3]), 2, -1, sets)
      call connect(self, forest, place, leaves([2, 4]), first([2, 4]), 2, 1, sets)
   end subroutine connect_around

   !> The leaves around a place: below left, below right, above left, above right; 0 if there is none.
   pure function leaves_around(forest, place) result(leaves)
      type(forest_t), intent(in) :: forest
      integer(long), intent(in) :: place(ndim)
      integer :: leaves(around)
      integer :: k
      leaves = [(leaf_beside(forest, place - 1 + corner_offset(k)), k=1, around)]
   end function leaves_around

   !> Connect the pieces of two leaves across their common edge, which begins at a place.
   pure subroutine connect(cut, forest, place, leaf, first, normal, sense, sets)
      type(cut_cells_t), intent(in) :: cut
      type(forest_t), intent(in) :: forest
      integer(long), intent(in) :: place(ndim)
      integer, intent(in) :: leaf(2)             !! below or left of the edge, and above or right of it; 0 for none
      integer, intent(in) :: first(2)            !! member for the first piece of each
      integer, intent(in) :: normal              !! direction normal to the edge
      integer, intent(in) :: sense               !! of the edge from the place, 1 or -1
      type(disjoint_sets_t), intent(inout) :: sets
      real(dp) :: x(ndim), lower(ndim), p(ndim), q(ndim), width(2), length
      logical :: are_whole
      integer :: i, along, piece(2)
      if (any(leaf == 0) .or. leaf(1) == leaf(2)) return
      if (.not. (cut%is_near(leaf(1)) .or. cut%is_near(leaf(2)))) then
         call sets%join(first(1), first(2))
         return
      end if
      are_whole = max(cut%pieces_of(leaf(1)), cut%pieces_of(leaf(2))) == 1
      width = [forest%size_of(leaf(1)), forest%size_of(leaf(2))]
      x = forest%position(place)
      along = 3 - normal
      length = huge(length)
      do i = 1, 2
         lower = forest%position(forest%place_of(leaf(i)))
         length = min(length, merge(lower(along) + width(i) - x(along), x(along) - lower(along), sense > 0))
      end do
      do i = 1, samples
         p = x
         p(along) = x(along) + sense*(i - 0.5_dp)/samples*length
         q = p
         p(normal) = p(normal) - 0.5_dp/samples*width(1)
         q(normal) = q(normal) + 0.5_dp/samples*width(2)
         if (is_between(cut, leaf(1), p, q)) cycle
         if (is_between(cut, leaf(2), p, q)) cycle
         piece = [cut%certain_piece_at(forest, leaf(1), p, near), cut%certain_piece_at(forest, leaf(2), q, near)]
         if (.not. all(piece > 0)) cycle
         call sets%join(first(1) + piece(1) - 1, first(2) + piece(2) - 1)
         if (are_whole) return
      end do
   end subroutine connect

   !> The leaf with the smallest square above and to the right of a place; 0 if there is none.
   pure integer function leaf_beside(forest, place) result(leaf)
      type(forest_t), intent(in) :: forest
      integer(long), intent(in) :: place(ndim)
      leaf = outside
      if (any(place < 0) .or. any(place >= forest%cells*level_width(0))) return
      leaf = forest%leaf_of(place)
   end function leaf_beside

   !> Whether a line is near a leaf; 0: no leaf.
   pure logical function is_near(self, leaf)
      class(cut_cells_t), intent(in) :: self
      integer, intent(in) :: leaf
      is_near = .false.
      if (leaf > 0 .and. allocated(self%entry)) is_near = self%entry(leaf) > 0
   end function is_near

   !> The place that identifies a copy of the node at a place: copies but the first have one far outside the lattice.
   pure function place_of_copy(place, copy) result(seen)
      integer(long), intent(in) :: place(ndim)
      integer, intent(in) :: copy                !! from 0 on
      integer(long) :: seen(ndim)
      integer(long), parameter :: far = 2_long**48
      seen = place
      seen(1) = seen(1) + copy*far
   end function place_of_copy
end module hampm_cut_cells
