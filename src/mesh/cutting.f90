!> Finding the cells that lines cut, and their pieces (`hampm_cut_cells`).
module hampm_cutting
   use hampm_kinds, only: dp, ndim
   use hampm_disjoint_sets, only: disjoint_sets_t, singletons
   use hampm_forest, only: forest_t, outside
   use hampm_crack_lines, only: line_t, left_face, right_face
   use hampm_cut_cells, only: cut_cells_t, end_leaf_t, is_between, nearly_none, on_line, sample, samples, &
                              side_of_ties
   use hampm_tensors, only: norm, in_plane, quarter_turn
   implicit none
   private
   public :: find_cut_cells

   !> Least distance of a tip from the end of the cut, over the size of the leaf there: nearer nodes hold the crack together as if
   !> it ended up to a quarter of a cell behind its tip.
   real(dp), parameter :: least = 0.5_dp

contains

   !> Find the leaves of a forest that lines cut, and their pieces.
   pure subroutine find_cut_cells(forest, lines, cut)
      type(forest_t), intent(in) :: forest
      type(line_t), intent(in) :: lines(:)
      type(cut_cells_t), intent(out) :: cut
      integer, allocatable :: leaf(:)            ! of each entry
      integer :: k
      cut%slack = on_line*forest%cell
      allocate (cut%lines(size(lines)))
      do k = 1, size(lines)                      ! as a whole it would leak in gfortran 12
         cut%lines(k) = lines(k)
      end do
      call find_segments(forest, cut)
      if (.not. cut%are_there()) return
      call find_leaves(forest, cut, leaf)
      do k = 1, size(leaf)
         call find_pieces(forest, leaf(k), cut)
      end do
   end subroutine find_cut_cells

   !> The segments of all lines; ends at tips are moved.
   pure subroutine find_segments(forest, cut)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(inout) :: cut
      real(dp), allocatable :: points(:, :)
      type(end_leaf_t) :: end
      integer :: line, k, n, e, last
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
            last = merge(size(points, 2), 1, k == 2)
            if (cut%lines(line)%is_through(k)) then
               end%tip = points(:, last)
               end%front = end%tip
               end%direction = end%tip - points(:, merge(last - 1, 2, k == 2))
               end%direction = end%direction/norm(end%direction)
            else
               call move_end(forest, cut%lines(line)%face, points(:, merge(last - 1, 2, k == 2)), points(:, last), end)
               if (.not. cut%lines(line)%bonded(k) > 0) call cut_ahead(forest, points(:, last), end)
            end if
            if (cut%lines(line)%bonded(k) > 0) then
               associate (open => cut%lines(line)%open_part())
                  end%tip = open(:, merge(1, size(open, 2), k == 1))
                  end%direction = end%tip - open(:, merge(2, size(open, 2) - 1, k == 1))
               end associate
               end%direction = end%direction/norm(end%direction)
               if (cut%lines(line)%is_through(k)) end%leaf = forest%leaf_at(end%tip + nearly_none*forest%cell &
                                                     *(into_half(end%direction, cut%lines(line)%face) - end%direction))
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

   !> Move an end to where its leaf ends, along the segment that comes from `from`. At a corner of leaves it stays; on an edge
   !> between two corners it is in the leaf ahead: shape functions of that edge would close the crack behind it.
   pure subroutine move_end(forest, face, from, tip, end)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: face                !! which one has material
      real(dp), intent(in) :: from(ndim)         !! [m]
      real(dp), intent(inout) :: tip(ndim)       !! [m]
      type(end_leaf_t), intent(inout) :: end
      real(dp) :: direction(ndim), behind
      integer :: leaf
      end%tip = tip
      end%front = tip
      direction = (tip - from)/norm(tip - from)
      end%direction = direction
      leaf = forest%leaf_at(tip + nearly_none*forest%cell*(direction + into_half(direction, face)))
      if (leaf == outside) return
      behind = forest%way_out(leaf, tip, -direction, nearly_none)
      if (behind <= 2*nearly_none*forest%cell .and. count(abs(direction) > nearly_none) == 1 .and. &
          (is_on_line(leaf) .or. is_on_line(forest%leaf_at(tip + nearly_none*forest%cell &
                                                           *(into_half(direction, face) - direction))))) then
         tip = tip - behind*direction
         return
      end if
      end%leaf = leaf
      tip = tip + forest%way_out(leaf, tip, direction, nearly_none)*direction
      end%front = tip

   contains

      !> Whether the tip is beside no leaf, or on a side of it along the crack.
      pure logical function is_on_line(leaf)
         integer, intent(in) :: leaf
         real(dp) :: lower(ndim)
         integer :: d
         is_on_line = leaf == outside
         if (is_on_line) return
         d = minloc(abs(direction), dim=1)       ! across the crack
         lower = forest%position(forest%place_of(leaf))
         is_on_line = min(abs(tip(d) - lower(d)), abs(tip(d) - lower(d) - forest%size_of(leaf))) <= 2*nearly_none*forest%cell
      end function is_on_line
   end subroutine move_end

   !> Cut leaves ahead of the tip, one by one, while a node of the edge at which the cut ends is behind the tip, or that edge is
   !> near: both faces share its nodes, which hold the crack together.
   pure subroutine cut_ahead(forest, front, end)
      type(forest_t), intent(in) :: forest
      real(dp), intent(inout) :: front(ndim)     !! where the cut ends [m]
      type(end_leaf_t), intent(inout) :: end
      integer, parameter :: most = 4             ! leaves; a line meets no more before an edge across it
      real(dp) :: lower(ndim), node(ndim), off(ndim)
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
            if (dot_product(node - end%tip, direction) >= 0 .and. norm(front - end%tip) >= least*size) return
            leaf = forest%leaf_at(front + nearly_none*forest%cell*direction)
            if (leaf == outside .or. leaf == end%leaf) return
            end%leaf = leaf
         end associate
         front = front + max(forest%way_out(leaf, front, end%direction, nearly_none), nearly_none*forest%cell)*end%direction
         end%front = front
      end do
   end subroutine cut_ahead

   !> Unit vector normal to a direction, towards the only face that has material; 0 where both have.
   pure function into_half(direction, face) result(inward)
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      integer, intent(in) :: face
      real(dp) :: inward(ndim)
      inward = 0
      if (face == left_face) inward = quarter_turn(direction)
      if (face == right_face) inward = quarter_turn(-direction)
   end function into_half

   !> List the leaves near lines, and the segments that are near each: of those in a row only where the box around them is.
   pure subroutine find_leaves(forest, cut, leaf)
      type(forest_t), intent(in) :: forest
      type(cut_cells_t), intent(inout) :: cut
      integer, allocatable, intent(out) :: leaf(:) !! of each entry
      real(dp), dimension(ndim, size(cut%segment, 3)) :: least, largest ! corners of the box around each segment [m]
      real(dp), allocatable :: of_rows(:, :, :)  ! the same of rows of segments [m], (ndim, 2, rows)
      real(dp) :: lower(ndim), upper(ndim)
      integer, allocatable :: more(:)
      integer :: n, k, s, row, length, listed
      allocate (cut%entry(forest%leaf_count()), source=0)
      do s = 1, size(cut%segment, 3)
         call mark_along(forest, cut%segment(:, 1, s), cut%segment(:, 2, s), cut%entry)
         least(:, s) = minval(cut%segment(:, :, s), dim=2)
         largest(:, s) = maxval(cut%segment(:, :, s), dim=2)
      end do
      leaf = pack([(k, k=1, size(cut%entry))], cut%entry > 0)
      n = size(leaf)
      cut%entry(leaf) = [(k, k=1, n)]
      allocate (cut%n_pieces(n), cut%first_near(n + 1), cut%near(2*n))
      allocate (cut%piece(samples, samples, n), source=1)
      length = max(1, nint(sqrt(real(size(least, 2), dp))))
      allocate (of_rows(ndim, 2, (size(least, 2) + length - 1)/length))
      do row = 1, size(of_rows, 3)
         associate (first => 1 + (row - 1)*length, last => min(row*length, size(least, 2)))
            of_rows(:, 1, row) = minval(least(:, first:last), dim=2)
            of_rows(:, 2, row) = maxval(largest(:, first:last), dim=2)
         end associate
      end do
      listed = 0
      do k = 1, n
         cut%first_near(k) = listed + 1
         associate (width => forest%size_of(leaf(k)))
            lower = forest%position(forest%place_of(leaf(k))) - width/2
            upper = lower + 2*width
         end associate
         do row = 1, size(of_rows, 3)
            if (any(of_rows(:, 1, row) > upper .or. of_rows(:, 2, row) < lower)) cycle
            do s = 1 + (row - 1)*length, min(row*length, size(least, 2))
               if (any(least(:, s) > upper .or. largest(:, s) < lower)) cycle
               if (listed == size(cut%near)) then
                  allocate (more(2*listed))
                  more(:listed) = cut%near
                  call move_alloc(more, cut%near)
               end if
               listed = listed + 1
               cut%near(listed) = s
            end do
         end do
      end do
      cut%near = cut%near(:listed)
      cut%first_near(n + 1) = listed + 1
   end subroutine find_leaves

   !> Mark the leaves along a segment, and those that are very near to it.
   pure subroutine mark_along(forest, from, to, marked)
      type(forest_t), intent(in) :: forest
      real(dp), intent(in) :: from(ndim), to(ndim) !! [m]
      integer, intent(inout) :: marked(:)        !! 1 for these, (leaves)
      real(dp), parameter :: part = 0.125_dp     ! of a leaf, from one place to the next
      real(dp) :: way, length, step, x(ndim), y(ndim)
      integer :: leaf, i, j
      length = norm(to - from)
      way = 0
      do
         x = from + min(way, length)/length*(to - from)
         leaf = forest%leaf_at(x)
         step = part*forest%cell
         if (leaf /= outside) step = part*forest%size_of(leaf)
         do j = -1, 1
            do i = -1, 1
               y = x + in_plane(i*step, j*step)
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
      real(dp) :: x(ndim, samples, samples)      ! places of the samples [m]
      integer :: number(samples*samples)
      integer :: i, j, k
      do j = 1, samples
         do i = 1, samples
            x(:, i, j) = sample(forest, leaf, i, j)
         end do
      end do
      call singletons(size(number), sets)
      do j = 1, samples
         do i = 1, samples                       ! neighbours are connected, unless a line runs between them
            k = i + samples*(j - 1)
            if (i < samples) then
               if (.not. is_between(cut, leaf, x(:, i, j), x(:, i + 1, j))) call sets%join(k, k + 1)
            end if
            if (j < samples) then
               if (.not. is_between(cut, leaf, x(:, i, j), x(:, i, j + 1))) call sets%join(k, k + samples)
            end if
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
end module hampm_cutting
