!> Cracks in planes of a grid, as the grid has them; of solids only.
!>
!> A face of a leaf in the plane is bonded where it is not cracked, by points (`hampm_plane_points`). Nodes of faces that are
!> cracked in part are open: inside of a body they have a copy for the material below the plane, and on a plane of symmetry nothing
!> holds them along the normal. All other nodes hold the faces together by themselves.
!>
!> The bonded part begins behind the front, by a part of a cell: with points as soft as cells, which give the least difference
!> between places of the front in a cell, the crack is longer than without by just this (docs/explanation/solids.md).
!>
!> A front that moves releases places from where it was at the start on as a tip does, over `release_length` and with the same lead.
!> Nodes open before that.
module hampm_plane_cuts
   use hampm_kinds, only: dp, ndim, long
   use hampm_forest, only: forest_t, level_width
   use hampm_front, only: region_t
   use hampm_moving_tip, only: lead_of_release, release_length
   use hampm_place_table, only: place_table_t
   implicit none
   private
   public :: plane_cut_t, find_open_nodes, find_unbonded, open_more, has_face_in, seen_beside

   real(dp), parameter :: margin = 0.27_dp       !! reach of the bonded part behind the front [cells]

   !> A crack in a plane.
   type, extends(region_t) :: plane_cut_t
      logical :: contact = .false.               !! whether its faces press on each other
      logical :: moves = .false.                 !! whether its fronts do while the mesh stays
      real(dp) :: friction = 0                   !! coefficient [-]
      integer(long) :: at = 0                    !! place of the plane along its axis
      type(region_t) :: at_start                 !! the cracked region when it begins
      real(dp) :: beyond = 0                     !! way by which its places go on to be released once no front is left [m]
      type(region_t), allocatable :: unbonded(:) !! of faces of each level, from 0 on: the part not bonded
      type(region_t), allocatable :: first(:)    !! the same at the start
      type(region_t), allocatable :: opened(:)   !! the same: the part that opens the nodes of a face
      type(place_table_t) :: open                !! places of the nodes that are open, and of middles of edges and faces
   contains
      procedure :: is_open
      procedure :: opens_at
      procedure :: rectangle_of
      procedure :: opens_face
      procedure :: way_to
      procedure :: held_part
   end type plane_cut_t

contains

   !> Find the unbonded part of the faces of each level, and where their nodes are open.
   pure subroutine find_unbonded(cut, forest)
      type(plane_cut_t), intent(inout) :: cut
      type(forest_t), intent(in) :: forest
      type(region_t) :: with_ends                ! also where the front has ended at other cracks: nodes stay open ahead of there
      logical :: has_moved
      integer :: level
      if (allocated(cut%unbonded)) deallocate (cut%unbonded, cut%opened, cut%first)
      allocate (cut%unbonded(0:forest%finest_level()), cut%opened(0:forest%finest_level()), cut%first(0:forest%finest_level()))
      has_moved = cut%moves
      if (has_moved) has_moved = size(cut%outline) /= size(cut%at_start%outline)
      if (cut%moves .and. .not. has_moved) has_moved = any(abs(cut%outline - cut%at_start%outline) > 0)
      with_ends = cut%region_t
      if (allocated(cut%cuts)) with_ends%may_be_front = with_ends%may_be_front .or. size(cut%cuts) > 0
      do level = 0, forest%finest_level()
         associate (cell => scale(forest%cell, -level))
            cut%unbonded(level) = cut%shrunk(margin*cell)
            cut%opened(level) = cut%unbonded(level)
            if (has_moved) cut%opened(level) = with_ends%shrunk(-release_length/3*cell)
            if (cut%moves) cut%first(level) = cut%at_start%shrunk(margin*cell)
         end associate
      end do
   end subroutine find_unbonded

   !> Way of the front from the start to a place, in a cell of a level; below 0 behind that [m].
   pure real(dp) function way_to(self, level, x)
      class(plane_cut_t), intent(in) :: self
      integer, intent(in) :: level
      real(dp), intent(in) :: x(ndim)            !! [m]
      way_to = self%first(level)%distance(x)
   end function way_to

   !> Part of the force that the front leaves at a place; at a node the mean by its function across the front. At the start springs
   !> have given way by as much as if the front had gone on by `margin`; the release catches up on that while it passes them.
   pure real(dp) function held_part(self, level, cell, x, way_to, is_node)
      class(plane_cut_t), intent(in) :: self
      integer, intent(in) :: level
      real(dp), intent(in) :: cell               !! of the level [m]
      real(dp), intent(in) :: x(ndim), way_to    !! [m]
      logical, intent(in) :: is_node
      real(dp), parameter :: places(4) = [-0.75_dp, -0.25_dp, 0.25_dp, 0.75_dp], weights(4) = [1, 3, 3, 1]/8.0_dp
      real(dp) :: way
      integer :: k
      associate (length => release_length*cell)
         way = way_to - self%unbonded(level)%distance(x) + self%beyond
         if (self%beyond > 0) way = max(way, self%beyond)
         way = way + lead_of_release(way, length) + margin*cell*min(1.0_dp, max(0.0_dp, way/length))
         if (.not. is_node) then
            held_part = of(max(0.0_dp, way_to))
         else
            held_part = 0
            do k = 1, size(places)
               if (way_to + places(k)*cell > 0) held_part = held_part + weights(k)*of(way_to + places(k)*cell)
            end do
         end if
      end associate

   contains

      !> That of one to which the front goes by some way.
      pure real(dp) function of(to)
         real(dp), intent(in) :: to              !! [m]
         of = min(1.0_dp, max(0.0_dp, 1 - (way - to)/(release_length*cell)))
      end function of
   end function held_part

   !> Whether growth opens nodes that were closed when the mesh was made. Newly reached faces have an open node already.
   pure logical function open_more(cuts, forest) result(more)
      type(plane_cut_t), intent(in) :: cuts(:)
      type(forest_t), intent(in) :: forest
      real(dp) :: low(2), high(2), area, middle(2)
      integer :: k, leaf, side
      more = .true.
      do k = 1, size(cuts)
         if (.not. cuts(k)%moves) cycle
         do leaf = 1, forest%leaf_count()
            do side = 1, 2
               if (.not. has_face_in(cuts(k), forest, leaf, side)) cycle
               if (.not. cuts(k)%opens_face(forest, leaf) .or. cuts(k)%opens_face(forest, leaf, wholly=.true.)) cycle
               call cuts(k)%rectangle_of(forest, leaf, low, high)
               call cuts(k)%opened(forest%level_of(leaf))%uncracked(low, high, area, middle)
               if (area < product(high - low)) return
            end do
         end do
      end do
      more = .false.
   end function open_more

   !> Find the nodes of a forest that cracks open.
   pure subroutine find_open_nodes(cuts, forest, status)
      type(plane_cut_t), intent(inout) :: cuts(:)
      type(forest_t), intent(in) :: forest
      integer, intent(out) :: status             !! not 0 where the memory does not suffice
      type(place_table_t) :: none
      real(dp) :: low(2), high(2), area, middle(2)
      integer(long) :: place(ndim)
      integer :: k, leaf, side, i, j, number
      status = 0
      do k = 1, size(cuts)
         associate (cut => cuts(k))
            cut%open = none
            call cut%open%reserve(64, status)
            if (status /= 0) return
            cut%at = nint((cut%plane - forest%lower(cut%axis))/forest%cell*level_width(0), long)
            call find_unbonded(cut, forest)
            do leaf = 1, forest%leaf_count()
               do side = 1, 2
                  if (.not. has_face_in(cut, forest, leaf, side)) cycle
                  call cut%rectangle_of(forest, leaf, low, high)
                  call cut%opened(forest%level_of(leaf))%uncracked(low, high, area, middle)
                  if (.not. area < product(high - low)) cycle
                  place = forest%place_of(leaf)
                  place(cut%axis) = cut%at
                  do j = 0, 2
                     do i = 0, 2
                        associate (half => level_width(forest%level_of(leaf))/2)
                           call cut%open%enter(moved(place, cut%along, [i*half, j*half]), number)
                        end associate
                     end do
                  end do
               end do
            end do
         end associate
      end do
   end subroutine find_open_nodes

   !> A place moved along two axes.
   pure function moved(place, along, by)
      integer(long), intent(in) :: place(ndim), by(2)
      integer, intent(in) :: along(2)
      integer(long) :: moved(ndim)
      moved = place
      moved(along) = moved(along) + by
   end function moved

   !> Whether a leaf has a face in the plane and is above it, side 1, or below it, side 2.
   pure logical function has_face_in(cut, forest, leaf, side) result(has)
      type(plane_cut_t), intent(in) :: cut
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf, side
      integer(long) :: place(ndim)
      place = forest%place_of(leaf)
      has = place(cut%axis) + (side - 1)*level_width(forest%level_of(leaf)) == cut%at
   end function has_face_in

   !> The face of a leaf in the plane [m].
   pure subroutine rectangle_of(self, forest, leaf, low, high)
      class(plane_cut_t), intent(in) :: self
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      real(dp), intent(out) :: low(2), high(2)
      low = self%in_plane(forest%position(forest%place_of(leaf)))
      high = self%in_plane(forest%position(forest%place_of(leaf) + level_width(forest%level_of(leaf))))
   end subroutine rectangle_of

   !> Whether the face of a leaf in the plane has an open node, or open ones only.
   pure logical function opens_face(self, forest, leaf, wholly) result(opens)
      class(plane_cut_t), intent(in) :: self
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      logical, intent(in), optional :: wholly
      integer(long) :: place(ndim), half
      integer :: i, j
      half = level_width(forest%level_of(leaf))/2
      place = forest%place_of(leaf)
      place(self%axis) = self%at
      opens = present(wholly)
      do j = 0, 2
         do i = 0, 2
            associate (is_open => self%is_open(moved(place, self%along, [i, j]*half)))
               opens = merge(opens .and. is_open, opens .or. is_open, present(wholly))
            end associate
         end do
      end do
   end function opens_face

   !> Place of a node as a leaf sees it: below an open crack that of a copy, deeper than any level has nodes.
   pure function seen_beside(cuts, forest, leaf, place) result(seen)
      type(plane_cut_t), intent(in) :: cuts(:)
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      integer(long), intent(in) :: place(ndim)
      integer(long) :: seen(ndim), lower(ndim)
      integer :: k
      seen = place
      do k = 1, size(cuts)
         if (cuts(k)%is_symmetry .or. .not. cuts(k)%is_open(place)) cycle
         lower = forest%place_of(leaf)
         if (lower(cuts(k)%axis) < cuts(k)%at) seen(cuts(k)%axis) = seen(cuts(k)%axis) - 1
      end do
   end function seen_beside

   !> Whether a node at a place is open.
   pure logical function is_open(self, place)
      class(plane_cut_t), intent(in) :: self
      integer(long), intent(in) :: place(ndim)
      is_open = place(self%axis) == self%at
      if (is_open) is_open = self%open%number_of(place) > 0
   end function is_open

   !> The same by where the node is.
   pure logical function opens_at(self, forest, x) result(is_open)
      class(plane_cut_t), intent(in) :: self
      type(forest_t), intent(in) :: forest
      real(dp), intent(in) :: x(ndim)            !! [m]
      is_open = self%is_open(nint((x - forest%lower)/forest%cell*level_width(0), long))
   end function opens_at
end module hampm_plane_cuts
