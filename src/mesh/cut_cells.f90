!> Cells that lines in any direction cut. A leaf that a line divides falls into pieces: over the square of the leaf there is one
!> element for each. A particle belongs to the piece in which it stands, and so to its element; a node around which the pieces are not
!> all connected has a copy for each part that is. All else follows from that: mass
!> matrices come apart, and forces do not cross.
!>
!> Which parts of a leaf are connected is found on a lattice of samples in it: neighbours are, unless a line runs between them. Leaves
!> are connected in the same way across their common edge. So lines may cross, meet, turn, run along grid lines and through corners. A
!> sliver that has no sample does not count; as samples are much denser than particles, hardly a particle is in one, and that which is
!> belongs to a neighbour. A point on a line belongs to one side, whichever end of the line is the first (`side_of_ties`); particles there are
!> split (`hampm_matching`).
!>
!> A line that ends in a leaf does not divide that. An end that is a tip is moved on along the line to where its leaf ends, and bonds
!> (`hampm_interface_points`) hold the part that is not cut. Where a line along a grid line ends between leaves, it stays.
module hampm_cut_cells
   use hampm_kinds, only: dp, ndim, long
   use hampm_disjoint_sets, only: disjoint_sets_t, singletons
   use hampm_forest, only: forest_t, outside, level_width
   implicit none
   private
   public :: line_t, length_of, cut_cells_t, end_leaf_t, find_cut_cells, place_of_copy, divides, side_of_ties, both_faces, &
             left_face, right_face

   integer, parameter :: both_faces = 0, left_face = 1, right_face = 2 !! which faces of a line have material

   integer, parameter :: samples = 16            !! of a leaf in each direction
   integer, parameter :: near = 2                !! samples from a point within which one tells its piece
   integer, parameter :: around = 4              !! leaves at a place, at most
   real(dp), parameter :: on_line = 1e-9_dp      !! distance within which a point is on a line, in cells of the lattice of roots
   real(dp), parameter :: nearly_none = 1e-6_dp  !! part of the way through a leaf that counts as none

   !> A polyline that cuts.
   type :: line_t
      real(dp), allocatable :: points(:, :)      !! [m], (ndim, 2 or more)
      real(dp), allocatable :: origin(:, :)      !! the same in the reference configuration, where the material carries the line [m]
      logical :: is_tip(2) = .false.             !! whether its first and its last point end inside the material
      logical :: contact = .false.               !! whether its sides press on each other
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: bonded(2) = 0                  !! how far behind its first and its last point the tips are that grow in motion: cells
                                                 !! are cut ahead of them, and bonds hold these [m]
      real(dp) :: grown(2) = 0                   !! how far each of these tips has moved so far [m]
      integer :: cohesion = 0                    !! number of the law by which its faces hold each other, 0 for none
      real(dp) :: held(2) = 0                    !! ways from its first point from and to which they do [m]
      integer :: face = both_faces               !! which faces have material: one on a symmetry plane
      real(dp) :: began(ndim) = 0                !! on a symmetry plane: where the tip at its last point was at first [m]
   contains
      procedure :: open_part
      procedure :: new_part
      procedure :: held_part
      procedure :: free_part
   end type line_t

   !> The leaf in which a line ends at a tip. Where cells are cut ahead of a tip, it is the last of them.
   type :: end_leaf_t
      integer :: line = 0
      integer :: end = 0                         !! 1 its first, 2 its last point
      integer :: leaf = 0                        !! 0 where the line ends where leaves meet: nothing is cut beyond it
      real(dp) :: tip(ndim) = 0                  !! [m]
      real(dp) :: direction(ndim) = 0            !! unit vector out of the line
      real(dp) :: front(ndim) = 0                !! where the line, going on, leaves the leaf [m]
   end type end_leaf_t

   !> The leaves at lines and their pieces.
   type :: cut_cells_t
      type(line_t), allocatable :: lines(:)
      type(end_leaf_t), allocatable :: ends(:)   !! one for each tip, in the order of the lines, the last point first
      real(dp), allocatable, private :: segment(:, :, :) !! of the lines, with their ends moved [m], (ndim, 2, segments)
      real(dp), allocatable, private :: side_of_ties(:) !! of each segment: 1 where what is on it is to its left, else -1
      integer, allocatable, private :: entry(:)  !! of each leaf in the tables below, 0 where no line is near; (leaves)
      integer, allocatable, private :: first_near(:), near(:) !! the segments near each entry, in rows
      integer, allocatable, private :: n_pieces(:) !! of each entry
      integer, allocatable, private :: piece(:, :, :) !! in which each sample is, (samples, samples, entries)
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
   end type cut_cells_t

contains

   !> Find the leaves of a forest that lines cut, and their pieces.
   pure subroutine find_cut_cells(forest, lines, goes_on, cut)
      type(forest_t), intent(in) :: forest
      type(line_t), intent(in) :: lines(:)
      logical, intent(in) :: goes_on             !! whether leaves ahead of tips are cut where their faces share a node behind these: linear
                                                 !! ones, as nodes in the middles of sides part the faces of quadratic ones
      type(cut_cells_t), intent(out) :: cut
      integer, allocatable :: leaf(:)            ! of each entry
      integer :: k
      cut%slack = on_line*forest%cell
      allocate (cut%lines(size(lines)))
      do k = 1, size(lines)                      ! as a whole it would leak in gfortran 12
         cut%lines(k) = lines(k)
      end do
      call find_segments(forest, goes_on, cut)
      if (.not. cut%are_there()) return
      call find_leaves(forest, cut, leaf)
      do k = 1, size(leaf)
         call find_pieces(forest, leaf(k), cut)
      end do
   end subroutine find_cut_cells

   !> Whether there are any lines.
   pure logical function are_there(self)
      class(cut_cells_t), intent(in) :: self
      are_there = .false.
      if (allocated(self%segment)) are_there = size(self%segment, 3) > 0
   end function are_there

   !> The segments of all lines; ends at tips are moved.
   pure subroutine find_segments(forest, goes_on, cut)
      type(forest_t), intent(in) :: forest
      logical, intent(in) :: goes_on             !! as in `find_cut_cells`
      type(cut_cells_t), intent(inout) :: cut
      real(dp), allocatable :: points(:, :), open(:, :)
      type(end_leaf_t) :: end
      integer :: line, k, n, e
      n = 0
      e = 0
      allocate (cut%segment(ndim, 2, sum([(size(cut%lines(line)%points, 2) - 1, line=1, size(cut%lines))])))
      allocate (cut%side_of_ties(size(cut%segment, 3)))
      allocate (cut%ends(sum([(count(cut%lines(line)%is_tip), line=1, size(cut%lines))])))
      do line = 1, size(cut%lines)
         points = cut%lines(line)%points
         do k = 2, 1, -1
            if (.not. cut%lines(line)%is_tip(k)) cycle
            end = end_leaf_t(line, k)
            if (k == 2) then
               call move_end(forest, cut%lines(line)%face, points(:, size(points, 2) - 1), points(:, size(points, 2)), end)
               if (goes_on .and. .not. cut%lines(line)%bonded(k) > 0) call cut_ahead(forest, points(:, size(points, 2)), end)
            else
               call move_end(forest, cut%lines(line)%face, points(:, 2), points(:, 1), end)
               if (goes_on .and. .not. cut%lines(line)%bonded(k) > 0) call cut_ahead(forest, points(:, 1), end)
            end if
            if (cut%lines(line)%bonded(k) > 0) then
               open = cut%lines(line)%open_part()
               end%tip = open(:, merge(1, size(open, 2), k == 1))
               end%direction = end%tip - open(:, merge(2, size(open, 2) - 1, k == 1))
               end%direction = end%direction/norm2(end%direction)
            end if
            e = e + 1
            cut%ends(e) = end
         end do
         do k = 2, size(points, 2)
            n = n + 1
            cut%segment(:, :, n) = points(:, k - 1:k)
            if (allocated(cut%lines(line)%origin)) then
               cut%side_of_ties(n) = side_of_ties(cut%lines(line)%origin(:, k) - cut%lines(line)%origin(:, k - 1))
            else
               cut%side_of_ties(n) = side_of_ties(points(:, k) - points(:, k - 1))
            end if
         end do
      end do
   end subroutine find_segments

   !> The line up to its tips, without what is bonded ahead of them [m].
   pure function open_part(self) result(points)
      class(line_t), intent(in) :: self
      real(dp), allocatable :: points(:, :)
      points = shortened(shortened(self%points, self%bonded(2)), self%bonded(1), from_first=.true.)
   end function open_part

   !> The line from where a tip was at first to the end of the line that is nearest to it, in the direction in which the tip moves [m].
   pure function new_part(self, end) result(points)
      class(line_t), intent(in) :: self
      integer, intent(in) :: end                 !! 1 its first, 2 its last point
      real(dp), allocatable :: points(:, :)
      real(dp) :: old
      old = length_of(self%points) - self%bonded(end) - self%grown(end)
      points = shortened(self%points, old, from_first=end == 2)
      if (end == 1) points = points(:, size(points, 2):1:-1)
   end function new_part

   !> The part of the line whose faces hold each other by cohesion [m].
   pure function held_part(self) result(points)
      class(line_t), intent(in) :: self
      real(dp), allocatable :: points(:, :)
      points = shortened(shortened(self%points, length_of(self%points) - self%held(2)), self%held(1), from_first=.true.)
   end function held_part

   !> The line up to its tips, without what cohesion holds or has held [m].
   pure function free_part(self) result(points)
      class(line_t), intent(in) :: self
      real(dp), allocatable :: points(:, :)
      points = self%open_part()
      if (self%cohesion > 0) points = shortened(self%points, length_of(self%points) - self%held(1))
   end function free_part

   !> Length of a polyline [m].
   pure real(dp) function length_of(points) result(length)
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, 2 or more)
      integer :: k
      length = sum([(norm2(points(:, k) - points(:, k - 1)), k=2, size(points, 2))])
   end function length_of

   !> A polyline without the last part of a length, or without the first [m].
   pure function shortened(points, by, from_first) result(shorter)
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, 2 or more)
      real(dp), intent(in) :: by                 !! [m]
      logical, intent(in), optional :: from_first
      real(dp), allocatable :: shorter(:, :)
      real(dp), parameter :: rounding = 1e-9_dp  ! part of a segment below which nothing of it is left: it would have no direction
      real(dp) :: left, length
      integer :: n
      shorter = points
      if (.not. by > 0) return
      if (present(from_first)) then
         if (from_first) shorter = points(:, size(points, 2):1:-1)
      end if
      left = by
      n = size(shorter, 2)
      do
         length = norm2(shorter(:, n) - shorter(:, n - 1))
         if (length*(1 - rounding) > left .or. n == 2) exit
         left = max(0.0_dp, left - length)
         n = n - 1
      end do
      shorter(:, n) = shorter(:, n) - min(left/length, 1 - epsilon(left))*(shorter(:, n) - shorter(:, n - 1))
      shorter = shorter(:, :n)
      if (present(from_first)) then
         if (from_first) shorter = shorter(:, n:1:-1)
      end if
   end function shortened

   !> Move an end to where its leaf ends, along the segment that comes from `from`.
   pure subroutine move_end(forest, face, from, tip, end)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: face                !! which one has material
      real(dp), intent(in) :: from(ndim)         !! [m]
      real(dp), intent(inout) :: tip(ndim)       !! [m]
      type(end_leaf_t), intent(inout) :: end
      real(dp) :: direction(ndim), lower(ndim), ahead, behind
      integer :: leaf, d
      end%tip = tip
      end%front = tip
      direction = (tip - from)/norm2(tip - from)
      end%direction = direction
      leaf = forest%leaf_at(tip + nearly_none*forest%cell*(direction + into_half(direction, face)))
      if (leaf == outside) return
      lower = forest%position(forest%place_of(leaf))
      ahead = huge(ahead)
      behind = huge(behind)
      do d = 1, ndim
         if (abs(direction(d)) <= nearly_none) cycle
         associate (to_lower => (tip(d) - lower(d))/abs(direction(d)), &
                    to_upper => (lower(d) + forest%size_of(leaf) - tip(d))/abs(direction(d)))
            ahead = min(ahead, merge(to_upper, to_lower, direction(d) > 0))
            behind = min(behind, merge(to_lower, to_upper, direction(d) > 0))
         end associate
      end do
      if (behind <= 2*nearly_none*forest%cell .and. count(abs(direction) > nearly_none) == 1) then
         tip = tip - behind*direction
         return
      end if
      end%leaf = leaf
      end%front = tip + ahead*direction
      tip = end%front
   end subroutine move_end

   !> Cut leaves ahead of the tip, one after the other, as long as of the edge at which the cut ends a node is behind the tip: both faces
   !> share it, and hold the crack together there.
   pure subroutine cut_ahead(forest, front, end)
      type(forest_t), intent(in) :: forest
      real(dp), intent(inout) :: front(ndim)     !! where the cut ends [m]
      type(end_leaf_t), intent(inout) :: end
      integer, parameter :: most = 4             ! leaves; a line meets no more before an edge across it
      real(dp) :: lower(ndim), node(ndim), off(ndim), ahead
      integer :: turn, leaf, d, across
      if (end%leaf == 0) return
      do turn = 1, most
         lower = forest%position(forest%place_of(end%leaf))
         associate (size => forest%size_of(end%leaf), direction => end%direction)
            off = [(min(abs(front(d) - lower(d)), abs(front(d) - lower(d) - size)), d=1, ndim)]
            if (all(off <= 2*nearly_none*forest%cell)) return ! at a node
            across = minloc(off, dim=1)
            node = front
            node(ndim + 1 - across) = lower(ndim + 1 - across) + merge(0.0_dp, size, direction(ndim + 1 - across) > 0)
            if (dot_product(node - end%tip, direction) >= 0) return
            leaf = forest%leaf_at(front + nearly_none*forest%cell*direction)
            if (leaf == outside .or. leaf == end%leaf) return
            end%leaf = leaf
         end associate
         lower = forest%position(forest%place_of(leaf))
         ahead = huge(ahead)
         do d = 1, ndim
            if (abs(end%direction(d)) <= nearly_none) cycle
            ahead = min(ahead, (lower(d) + merge(forest%size_of(leaf), 0.0_dp, end%direction(d) > 0) - front(d))/end%direction(d))
         end do
         front = front + max(ahead, nearly_none*forest%cell)*end%direction
         end%front = front
      end do
   end subroutine cut_ahead

   !> Unit vector normal to a direction, towards the only face that has material; 0 where both have.
   pure function into_half(direction, face) result(inward)
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      integer, intent(in) :: face
      real(dp) :: inward(ndim)
      inward = 0
      if (face == left_face) inward = [-direction(2), direction(1)]
      if (face == right_face) inward = [direction(2), -direction(1)]
   end function into_half

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
            if (norm2(x - line%began - way*end%direction) > self%slack) cycle
            freed = freed .or. .not. abs(end%direction) > 0
         end associate
      end do
   end function freed_at

   !> List the leaves near lines, and the segments that are near each.
   pure subroutine find_leaves(forest, cut, leaf)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(inout) :: cut
      integer, allocatable, intent(out) :: leaf(:) !! of each entry
      real(dp) :: lower(ndim), upper(ndim)
      integer :: n, k, s
      allocate (cut%entry(forest%leaf_count()), source=0)
      do s = 1, size(cut%segment, 3)
         call mark_along(forest, cut%segment(:, 1, s), cut%segment(:, 2, s), cut%entry)
      end do
      leaf = pack([(k, k=1, size(cut%entry))], cut%entry > 0)
      n = size(leaf)
      cut%entry(leaf) = [(k, k=1, n)]
      allocate (cut%n_pieces(n), cut%first_near(n + 1), cut%near(0))
      allocate (cut%piece(samples, samples, n), source=1)
      do k = 1, n
         cut%first_near(k) = size(cut%near) + 1
         associate (width => forest%size_of(leaf(k)))
            lower = forest%position(forest%place_of(leaf(k))) - width/2
            upper = lower + 2*width
         end associate
         cut%near = [cut%near, pack([(s, s=1, size(cut%segment, 3))], &
                                    [(all(minval(cut%segment(:, :, s), dim=2) <= upper) .and. &
                                      all(maxval(cut%segment(:, :, s), dim=2) >= lower), s=1, size(cut%segment, 3))])]
      end do
      cut%first_near(n + 1) = size(cut%near) + 1
   end subroutine find_leaves

   !> Mark the leaves along a segment, and those that are very near to it.
   pure subroutine mark_along(forest, from, to, marked)
      type(forest_t), intent(in) :: forest
      real(dp), intent(in) :: from(ndim), to(ndim) !! [m]
      integer, intent(inout) :: marked(:)        !! 1 for these, (leaves)
      real(dp), parameter :: part = 0.125_dp     ! of a leaf, from one place to the next
      real(dp) :: way, length, step, x(ndim), y(ndim)
      integer :: leaf, i, j
      length = norm2(to - from)
      way = 0
      do
         x = from + min(way, length)/length*(to - from)
         leaf = forest%leaf_at(x)
         step = part*forest%cell
         if (leaf /= outside) step = part*forest%size_of(leaf)
         do j = -1, 1
            do i = -1, 1
               y = x + [i, j]*step
               leaf = forest%leaf_at(y)
               if (leaf /= outside) marked(leaf) = 1
            end do
         end do
         if (way >= length) exit
         leaf = forest%leaf_at(x)
         way = way + merge(step, step/2, leaf /= outside)
      end do
   end subroutine mark_along

   !> Find the pieces of a leaf.
   pure subroutine find_pieces(forest, leaf, cut)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      type(cut_cells_t), intent(inout) :: cut
      type(disjoint_sets_t) :: sets
      integer :: number(samples*samples)
      integer :: i, j, k
      call singletons(size(number), sets)
      do j = 1, samples
         do i = 1, samples
            if (i < samples) call link(cut, forest, leaf, [i, j], [i + 1, j], sets)
            if (j < samples) call link(cut, forest, leaf, [i, j], [i, j + 1], sets)
         end do
      end do
      number = 0
      associate (entry => cut%entry(leaf))
         cut%n_pieces(entry) = 0
         do k = 1, size(number)
            associate (least => sets%least_of(k))
               if (number(least) == 0) then
                  cut%n_pieces(entry) = cut%n_pieces(entry) + 1
                  number(least) = cut%n_pieces(entry)
               end if
               j = 1 + (k - 1)/samples
               cut%piece(k - samples*(j - 1), j, entry) = number(least)
            end associate
         end do
      end associate
   end subroutine find_pieces

   !> Connect two samples, unless a line runs between them.
   pure subroutine link(cut, forest, leaf, a, b, sets)
      type(cut_cells_t), intent(in) :: cut
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      integer, intent(in) :: a(ndim), b(ndim)
      type(disjoint_sets_t), intent(inout) :: sets
      if (.not. is_between(cut, leaf, sample(forest, leaf, a(1), a(2)), sample(forest, leaf, b(1), b(2)))) &
         call sets%join(a(1) + samples*(a(2) - 1), b(1) + samples*(b(2) - 1))
   end subroutine link

   !> Place of a sample [m].
   pure function sample(forest, leaf, i, j) result(x)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf, i, j
      real(dp) :: x(ndim)
      x = forest%position(forest%place_of(leaf)) + ([i, j] - 0.5_dp)/samples*forest%size_of(leaf)
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

   !> To which side of a segment belongs what is on it: that above, of a vertical one that at its left in the picture, whichever of its ends is the
   !> first; 1 where that is to the left as one walks along the segment, else -1.
   pure real(dp) function side_of_ties(direction) result(side)
      real(dp), intent(in) :: direction(ndim)    !! of the segment, of any length
      logical :: is_vertical
      is_vertical = abs(direction(1)) <= nearly_none*abs(direction(2))
      side = merge(1, -1, merge(direction(2) > 0, direction(1) > 0, is_vertical))
   end function side_of_ties

   !> Whether a point is to the left of the line from a to b, or within `slack` of it; where that is below 0, farther to the left than it.
   pure logical function is_left(a, b, p, slack)
      real(dp), intent(in) :: a(ndim), b(ndim), p(ndim) !! [m]
      real(dp), intent(in) :: slack              !! [m]
      is_left = (b(1) - a(1))*(p(2) - a(2)) - (b(2) - a(2))*(p(1) - a(1)) >= -slack*norm2(b - a)
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

   !> The piece of a leaf in which a point is: that of the nearest sample from which no line divides it or, where there is none near, of
   !> the nearest. Of a point outside of the leaf it is the piece on its side.
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

   !> The place where the material that began at `origin` would be if it had kept its distance from the line next to it, and so its side,
   !> however far the faces have parted or gone through each other [m]. Where lines stay, that is `origin`.
   pure function follow(self, origin) result(x)
      class(cut_cells_t), intent(in) :: self
      real(dp), intent(in) :: origin(ndim)       !! in the reference configuration [m]
      real(dp) :: x(ndim)
      real(dp) :: nearest, distance, along, across
      integer :: line, k
      x = origin
      nearest = huge(nearest)
      do line = 1, size(self%lines)
         if (.not. allocated(self%lines(line)%origin)) cycle
         do k = 2, size(self%lines(line)%origin, 2)
            associate (a => self%lines(line)%origin(:, k - 1), b => self%lines(line)%origin(:, k), &
                       from => self%lines(line)%points(:, k - 1), to => self%lines(line)%points(:, k))
               along = dot_product(origin - a, b - a)/sum((b - a)**2)
               distance = norm2(origin - a - min(max(along, 0.0_dp), 1.0_dp)*(b - a))
               if (distance >= nearest) cycle
               nearest = distance
               across = ((b(1) - a(1))*(origin(2) - a(2)) - (b(2) - a(2))*(origin(1) - a(1)))/norm2(b - a)
               x = from + along*(to - from) + across*[from(2) - to(2), to(1) - from(1)]/norm2(to - from)
            end associate
         end do
      end do
   end function follow

   !> Where a place on a line was in the reference configuration [m]. Where lines stay, that is the place.
   pure function origin_of(self, line, x) result(origin)
      class(cut_cells_t), intent(in) :: self
      integer, intent(in) :: line
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: origin(ndim)
      real(dp) :: nearest, distance, along
      integer :: k
      origin = x
      nearest = huge(nearest)
      associate (of => self%lines(line))
         if (.not. allocated(of%origin)) return
         do k = 2, size(of%points, 2)
            associate (a => of%points(:, k - 1), b => of%points(:, k))
               along = dot_product(x - a, b - a)/sum((b - a)**2)
               distance = norm2(x - a - min(max(along, 0.0_dp), 1.0_dp)*(b - a))
               if (distance >= nearest) cycle
               nearest = distance
               origin = of%origin(:, k - 1) + along*(of%origin(:, k) - of%origin(:, k - 1))
            end associate
         end do
      end associate
   end function origin_of

   !> The nearest point of all lines, or of one, to a place, and the unit vector to the left of its line.
   pure subroutine find_nearest(self, x, point, normal, of)
      class(cut_cells_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(out) :: point(ndim)       !! [m]
      real(dp), intent(out) :: normal(ndim)
      integer, intent(in), optional :: of        !! this line only
      real(dp) :: nearest, distance, along
      integer :: line, k
      point = x
      normal = 0
      nearest = huge(nearest)
      do line = 1, size(self%lines)
         if (present(of)) then
            if (line /= of) cycle
         end if
         associate (points => self%lines(line)%points)
            do k = 2, size(points, 2)
               associate (a => points(:, k - 1), b => points(:, k))
                  along = min(max(dot_product(x - a, b - a)/sum((b - a)**2), 0.0_dp), 1.0_dp)
                  distance = norm2(x - a - along*(b - a))
                  if (distance >= nearest) cycle
                  nearest = distance
                  point = a + along*(b - a)
                  normal = [a(2) - b(2), b(1) - a(1)]/norm2(b - a)
               end associate
            end do
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
                  points(:, last) = points(:, last) + dot_product(end%front - end%tip, end%direction)*out/norm2(out)
               end associate
            else
               points(:, last) = end%front
            end if
         end associate
      end do
   end function cut_part

   !> Whether a polyline runs between two points.
   pure logical function divides(points, p, q, slack)
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, 2 or more)
      real(dp), intent(in) :: p(ndim), q(ndim)   !! [m]
      real(dp), intent(in) :: slack              !! [m]
      integer :: k
      divides = .false.
      do k = 2, size(points, 2)
         divides = runs_between(points(:, k - 1), points(:, k), p, q, slack*side_of_ties(points(:, k) - points(:, k - 1)))
         if (divides) return
      end do
   end function divides

   !> On which side of the nearest line a point of a leaf is: 1 to the left as one walks along the points of the line, -1 to the
   !> right; 0 in a leaf that is not divided. Where a kink is nearest, that of its two segments tells from which, as a straight
   !> line, the point is farther.
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
            along = (b - a)/norm2(b - a)
            place = min(max(dot_product(x - a, along), 0.0_dp), norm2(b - a))
            distance = norm2(x - a - place*along)
            height = abs(along(1)*(x(2) - a(2)) - along(2)*(x(1) - a(1)))
            if (distance > nearest + self%slack) cycle
            if (distance > nearest - self%slack .and. height <= farthest) cycle
            nearest = distance
            farthest = height
            side = merge(1, -1, is_left(a, b, x, self%slack*self%side_of_ties(self%near(k))))
         end associate
      end do
   end function side_at

   !> Whether material of a leaf that lines divide is on one of them, or on where it will go on to.
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
         is_on_line = distance_to(self%segment(:, :, self%near(k)), x) <= self%slack
         if (is_on_line) return
      end do
   end function is_on_line

   !> Normal of the line on which material of a leaf is, of any length: at a kink the sum of both, which the order of its points turns around and
   !> nothing else; 0 where that is no line, or several.
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
            if (distance_to(self%segment(:, :, self%near(k)), x) > self%slack) cycle
            left = [a(2) - b(2), b(1) - a(1)]/norm2(b - a)
            if (last == 0) then
               normal = left
            else if (last == self%near(k) - 1 .and. norm2(self%segment(:, 2, max(last, 1)) - a) <= self%slack) then
               normal = normal + left
            else if (abs(normal(1)*left(2) - normal(2)*left(1)) > nearly_none*norm2(normal)) then
               normal = 0
               return
            end if
            last = self%near(k)
         end associate
      end do
   end function normal_at

   !> Distance of a point from a segment [m].
   pure real(dp) function distance_to(segment, x) result(distance)
      real(dp), intent(in) :: segment(ndim, 2)   !! its ends [m]
      real(dp), intent(in) :: x(ndim)            !! [m]
      associate (a => segment(:, 1), b => segment(:, 2))
         distance = norm2(x - a - min(max(dot_product(x - a, b - a)/sum((b - a)**2), 0.0_dp), 1.0_dp)*(b - a))
      end associate
   end function distance_to

   !> The sample in whose part of a leaf a point is.
   pure function sample_at(forest, leaf, x) result(at)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer :: at(ndim)
      at = ceiling((x - forest%position(forest%place_of(leaf)))/forest%size_of(leaf)*samples)
      at = min(max(at, 1), samples)
   end function sample_at

   !> The piece of a leaf in which a point is: that of the nearest sample within `reach` from which no line divides it; 0 for none.
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
            distance = norm2(sample(forest, leaf, i, j) - x)
            if (distance >= nearest) cycle
            if (is_between(self, leaf, x, sample(forest, leaf, i, j))) cycle
            nearest = distance
            piece = self%piece(i, j, self%entry(leaf))
         end do
      end do
   end function certain_piece_at

   !> Which copy of the node, or hanging node, at a place a piece of a leaf has, from 0 on: pieces of the leaves around the place that are
   !> connected there have the same. With `joined` the pieces of that leaf are taken as one.
   pure integer function copy_at(self, forest, place, leaf, piece, joined) result(copy)
      class(cut_cells_t), intent(in) :: self
      type(forest_t), intent(in) :: forest
      integer(long), intent(in) :: place(ndim)   !! in integer coordinates of the forest
      integer, intent(in) :: leaf, piece
      integer, intent(in), optional :: joined
      integer :: leaves(around)                  ! below left, below right, above left, above right; 0 where there is none
      integer :: first(around)                   ! member of the set: the first piece of each
      type(disjoint_sets_t) :: sets
      integer :: k, i, n
      copy = 0
      leaves = [leaf_beside(forest, place - [1, 1]), leaf_beside(forest, place - [0, 1]), &
                leaf_beside(forest, place - [1, 0]), leaf_beside(forest, place)]
      if (.not. any([(self%is_near(leaves(k)), k=1, around)])) return
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
      if (present(joined)) then
         do k = 1, around
            if (leaves(k) /= joined) cycle
            do i = 1, self%pieces_of(joined) - 1
               call sets%join(first(k), first(k) + i)
            end do
         end do
      end if
      copy = sets%how_many(below=sets%least_of(first(findloc(leaves, leaf, dim=1)) + piece - 1))
   end function copy_at

   !> Connect the pieces of two leaves across their common edge, which begins at a place.
   pure subroutine connect(cut, forest, place, leaf, first, normal, sense, sets)
      type(cut_cells_t), intent(in) :: cut
      type(forest_t), intent(in) :: forest
      integer(long), intent(in) :: place(ndim)
      integer, intent(in) :: leaf(2)             !! below or left of the edge, and above or right of it; 0 for none
      integer, intent(in) :: first(2)            !! member for the first piece of each
      integer, intent(in) :: normal              !! direction normal to the edge
      integer, intent(in) :: sense               !! in which the edge goes from the place, 1 or -1
      type(disjoint_sets_t), intent(inout) :: sets
      real(dp) :: x(ndim), lower(ndim), p(ndim), q(ndim), width(2), length
      logical :: are_whole
      integer :: i, along, piece(2)
      if (any(leaf == 0) .or. leaf(1) == leaf(2)) return
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

   !> The leaf that has the smallest square above and to the right of a place; 0 where there is none.
   pure integer function leaf_beside(forest, place) result(leaf)
      type(forest_t), intent(in) :: forest
      integer(long), intent(in) :: place(ndim)
      leaf = outside
      if (any(place < 0) .or. any(place >= forest%cells*level_width(0))) return
      leaf = forest%leaf_of(place)
   end function leaf_beside

   !> Whether a line is near a leaf; 0 is none.
   pure logical function is_near(self, leaf)
      class(cut_cells_t), intent(in) :: self
      integer, intent(in) :: leaf
      is_near = .false.
      if (leaf > 0 .and. allocated(self%entry)) is_near = self%entry(leaf) > 0
   end function is_near

   !> The place by which a copy of the node at a place is told from the others: copies but the first have one far outside the lattice.
   pure function place_of_copy(place, copy) result(seen)
      integer(long), intent(in) :: place(ndim)
      integer, intent(in) :: copy                !! from 0 on
      integer(long) :: seen(ndim)
      integer(long), parameter :: far = 2_long**48
      seen = place
      seen(1) = seen(1) + copy*far
   end function place_of_copy
end module hampm_cut_cells
