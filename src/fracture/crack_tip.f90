!> The tip of a crack: its place, surroundings, and the nodes around it in the present grid.
!>
!> Its frame: direction 1 points out of the crack, direction 2 is 90 degrees to the left of it. The upper face is on the side of
!> direction 2, the lower face on the other. On a symmetry plane there is one face; the other is its mirror image.
module hampm_crack_tip
   use hampm_kinds, only: dp, ndim, corners
   use hampm_archive, only: archive_t
   use hampm_cut_cells, only: end_leaf_t
   use hampm_crack_lines, only: left_face, right_face, both_faces
   use hampm_forest, only: outside, corner_offset
   use hampm_grid, only: grid_t
   use hampm_material, only: material_t
   use hampm_tensors, only: norm, quarter_turn
   implicit none
   private
   public :: crack_tip_t, tip_nodes_t, frame_along, face_nodes, upper, lower, archive_surroundings

   integer, parameter :: upper = 1, lower = 2    !! the faces

   !> The nodes at and around a tip, and at the mouth of its crack. `behind`, `tip` and `ahead` are the nodes (1), (1'), (2) and (3)
   !> of Fig. 2 of Tan & Nairn. They follow from the tip and the grid.
   type :: tip_nodes_t
      integer :: behind(2) = 0                   !! nodes of the faces one cell behind the tip, 0 where there is no face
      integer :: tip = 0                         !! node at the tip
      integer :: ahead = 0                       !! node one cell ahead of it
      integer :: half_behind(2) = 0              !! of quadratic cells, as `behind` half a cell behind the tip
      integer :: half_ahead = 0                  !! and half a cell ahead
      logical :: in_cell = .false.               !! whether the tip is inside a cut cell, at no node
      real(dp) :: spacing = 0                    !! distance between the nodes around the tip: the smallest cell there [m]
   end type tip_nodes_t

   !> A tip.
   type :: crack_tip_t
      integer :: crack = 0                       !! number of its crack
      integer :: end = 0                         !! 1 where it is the first point of that, 2 the last
      real(dp) :: place(ndim) = 0                !! in the reference configuration [m]
      real(dp) :: now(ndim) = 0                  !! in the grid [m]
      real(dp) :: direction(ndim) = 0            !! unit vector out of the crack there
      real(dp) :: axis(ndim, ndim) = 0           !! unit vectors of its frame: axis(:, k) is direction k
      logical :: face(2) = .true.                !! present faces: one on a symmetry plane, else both
      logical :: has_zone = .false.              !! whether cohesion holds the faces ahead of it
      logical :: has_ended = .false.             !! whether it has run to a surface or another crack: there is no tip any more
      logical :: has_no_domain = .false.         !! whether it runs to its end and no domain of a cell is left around it
      logical :: may_close = .false.             !! whether interface points keep the faces from interpenetrating
      real(dp) :: grown = 0                      !! advance since the start of the run, by dynamic growth [m]
      real(dp) :: speed = 0                      !! at which it grows in motion [m/s]
      real(dp) :: toughness = 0                  !! to which its G is equal as it runs; 0 where that is not so [J/m2]
      integer :: material = 0                    !! number of its material; with K of an interface of the one above the crack
      integer :: below = 0                       !! and of that below it
      real(dp) :: phase_length = 0               !! reference length of K of an interface; 0 if not measured [m]
      logical :: has_layers = .false.            !! whether its radii reach other materials in layers along the crack: J is valid,
                                                 !! its parts and K are not
      logical, allocatable :: ends_at(:)         !! by body: whether it is another material within the radii, no layer:
                                                 !! domains end where it begins; not allocated: none is
      real(dp) :: to_other = huge(1.0_dp)        !! distance to the nearest of these [m]
      real(dp), allocatable :: radii(:)          !! of the domain integral, ascending; none where that is not taken [m]
      type(tip_nodes_t) :: nodes
   contains
      procedure :: material_in
      procedure :: is_measured
      procedure :: lost
      procedure :: is_half
      procedure :: only_face
      procedure :: into_half
      procedure :: find_nodes
      procedure :: find_cells
   end type crack_tip_t

contains

   !> The unit vectors of the frame of a tip, one a column.
   pure function frame_along(direction) result(axis)
      real(dp), intent(in) :: direction(ndim)    !! unit vector out of the crack
      real(dp) :: axis(ndim, ndim)
      axis(:, 1) = direction
      axis(:, 2) = quarter_turn(direction)
   end function frame_along

   !> Number of its material; in a graded body at its place.
   pure integer function material_in(self, materials)
      class(crack_tip_t), intent(in) :: self
      type(material_t), intent(in) :: materials(:)
      material_in = self%material + materials(self%material)%slices_to(self%place)
   end function material_in

   !> Relative error of G as another material begins near the tip, whose field cells do not resolve between, and as material has
   !> carried it through cells, which are cut anew as it goes [-].
   !>
   !> Across seams with ratios of stiffness 3 and 1/3, J was off by 0.22, 0.06, 0.02 and 0.01 at 0.9, 1.1, 1.3 and 2 cells, before
   !> and behind. J of loaded plates that fly is too large, by up to a quarter of the root of the cells crossed most often
   !> (docs/explanation/cracks.md); within half a cell it begins to be.
   pure real(dp) function lost(self) result(part)
      class(crack_tip_t), intent(in) :: self
      real(dp), parameter :: by_root = 0.25_dp, few = 0.5_dp
      associate (crossed => norm(self%now - self%place)/self%nodes%spacing)
         part = by_root*sqrt(crossed)*min(1.0_dp, crossed/few)
      end associate
      part = part/(1 + part) + min(1.0_dp, (self%nodes%spacing/max(self%to_other, tiny(part)**0.25_dp))**2/3)
   end function lost

   !> Whether G, J and K are measured at it.
   pure logical function is_measured(self)
      class(crack_tip_t), intent(in) :: self
      is_measured = .not. (self%has_ended .or. self%has_no_domain)
   end function is_measured

   !> Whether the crack is on a symmetry plane, so that there is only half of the body.
   pure logical function is_half(self)
      class(crack_tip_t), intent(in) :: self
      is_half = .not. all(self%face)
   end function is_half

   !> The only face of the line of its crack, seen along the line.
   pure integer function only_face(self)
      class(crack_tip_t), intent(in) :: self
      only_face = both_faces
      if (self%is_half()) only_face = merge(left_face, right_face, self%face(upper) .eqv. self%end == 2)
   end function only_face

   !> Unit vector normal to the crack into the half of the body that there is; 0 where there are both.
   pure function into_half(self) result(inward)
      class(crack_tip_t), intent(in) :: self
      real(dp) :: inward(ndim)
      inward = 0
      if (self%is_half()) inward = merge(1, -1, self%face(upper))*self%axis(:, 2)
   end function into_half

   !> Find the nodes in a grid. `found`: all of them are there; else nothing changes.
   pure subroutine find_nodes(self, grid, found)
      class(crack_tip_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      logical, intent(out) :: found
      type(tip_nodes_t) :: before
      before = self%nodes
      self%nodes = tip_nodes_t(tip=grid%node_at(self%place))
      associate (nodes => self%nodes)
         if (nodes%tip > 0) then
            nodes%spacing = grid%smallest_leaf_at(nodes%tip)
            nodes%behind = face_nodes(self, grid, self%place - nodes%spacing*self%axis(:, 1))
            nodes%ahead = grid%node_at(self%place + nodes%spacing*self%axis(:, 1))
            if (grid%is_quadratic()) then
               nodes%half_behind = face_nodes(self, grid, self%place - nodes%spacing/2*self%axis(:, 1))
               nodes%half_ahead = grid%node_at(self%place + nodes%spacing/2*self%axis(:, 1))
            end if
         end if
         found = min(nodes%tip, nodes%ahead) > 0 .and. all(nodes%behind > 0 .or. .not. self%face)
      end associate
      if (.not. found) self%nodes = before
   end subroutine find_nodes

   !> Find the cells at the tip of a path, the smallest of them, and whether it is inside one. The grid has the place of a tip
   !> carried by the material; other places are from the points of the crack, also when a step with growth is undone.
   pure subroutine find_cells(self, end, is_carried, grid)
      class(crack_tip_t), intent(inout) :: self
      type(end_leaf_t), intent(in) :: end        !! of the line of this crack in the grid
      logical, intent(in) :: is_carried
      type(grid_t), intent(in) :: grid
      integer :: k, leaf
      if (is_carried) then
         self%now = end%tip
         self%direction = end%direction
      end if
      self%nodes = tip_nodes_t(spacing=grid%forest%cell)
      do k = 1, corners
         leaf = grid%forest%leaf_at(self%now + grid%forest%tolerance()*(2*corner_offset(k) - 1))
         if (leaf /= outside) self%nodes%spacing = min(self%nodes%spacing, grid%forest%size_of(leaf))
      end do
      self%nodes%in_cell = end%leaf > 0
   end subroutine find_cells

   !> Nodes of the faces at a place behind the tip, of the cells towards it: at a kink cells behind belong to either face; 0 if
   !> there is none.
   pure function face_nodes(self, grid, x) result(nodes)
      class(crack_tip_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer :: nodes(2)
      nodes = 0
      if (self%face(upper)) nodes(upper) = grid%node_at(x, self%axis(:, 1) + self%axis(:, 2))
      if (self%face(lower)) nodes(lower) = grid%node_at(x, self%axis(:, 1) - self%axis(:, 2))
   end function face_nodes

   !> Save or restore the data of a tip; the materials around it follow from its place, but not out of the material, where it waits.
   subroutine archive_surroundings(tip, archive)
      type(crack_tip_t), intent(inout) :: tip
      class(archive_t), intent(inout) :: archive
      integer :: n
      call archive%serialise('grown', tip%grown)
      call archive%serialise('speed', tip%speed)
      call archive%serialise('toughness', tip%toughness)
      call archive%serialise('material', tip%material)
      call archive%serialise('has_no_domain', tip%has_no_domain)
      n = size(tip%radii)
      call archive%serialise('number_radii', n)
      if (n == 0 .or. archive%failure%failed()) return
      if (archive%is_read) then
         deallocate (tip%radii)
         allocate (tip%radii(n))
      end if
      call archive%archive_reals('radii', n, tip%radii)
   end subroutine archive_surroundings
end module hampm_crack_tip
