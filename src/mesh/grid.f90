!> The grid built from a forest: nodes, elements, and which element touches which node (docs/explanation/hierarchy.md).
!>
!> A leaf is one bilinear element of its corners. A transition leaf, beside finer ones, has up to four nodes more, in the middle of
!> its sides: its functions are piecewise linear on the sides, the mean in the middle, and never negative. It is stored as its four
!> quarters, bilinear elements like any other; their corners without a node of the leaf are hanging nodes (`hampm_dofs`), numbered
!> after the nodes, as are nodes of nearly empty cells (`hampm_aggregated_nodes`). A leaf that a line divides (`hampm_cut_cells`)
!> has such elements for each piece, and its nodes have copies. A quadratic leaf is stored as its quarters, all corners of which are
!> nodes of its support; beside a coarser leaf with material the node in the middle of a side hangs, with the weights 3/8, 3/4 and
!> -1/8.
!>
!> With several velocity fields (`hampm_body_contact`) all leaves have their elements and nodes once on each, one field after the
!> other. A particle is in an element of the field of its body. Cracks are on the first field only.
module hampm_grid
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_tensors, only: norm
   use hampm_basis, only: points_of_quadratic, quarter_of_point, corner_of_point, shape_functions, shape_gradients, &
                          quadratic_functions, quadratic_gradients
   use hampm_cut_cells, only: cut_cells_t
   use hampm_dofs, only: dofs_t
   use hampm_forest, only: forest_t, outside, corner_offset, level_width
   use hampm_aggregated_nodes, only: aggregated_nodes_t
   use hampm_outline, only: outline_t
   use hampm_plane_cuts, only: plane_cut_t
   implicit none
   private
   public :: grid_t, is_toward, side_corner, sides

   integer, parameter :: sides = 2*ndim

   !> Nodes and elements of a forest.
   type :: grid_t
      type(forest_t) :: forest                          !! source of the grid
      type(cut_cells_t) :: cut_cells                    !! and where it was cut then
      type(plane_cut_t), allocatable :: planes(:)       !! cracks in planes of it, of solids; else not allocated
      type(outline_t), allocatable :: bodies(:)         !! in it, where edges of bodies may cut cells; else not allocated
      logical, allocatable :: is_full(:)                !! whether one of them fills each leaf, (leaves); not allocated if none
      logical, allocatable :: is_met(:)                 !! whether any of them has a part of each leaf; as above, (leaves)
      type(aggregated_nodes_t) :: aggregated_nodes      !! of cells that these nearly leave empty
      integer, allocatable :: field_of_body(:)          !! the velocity field of each body; not allocated if there is only one
      integer :: n_velocity_fields = 1
      real(dp), allocatable :: solids(:, :, :)          !! corners of the rectangles that are filled with material, where cells are
                                                        !! quadratic; else not allocated [m], (ndim, 2, number)
      integer :: n_functions = corners                  !! shape functions in an element
      real(dp), allocatable :: correction(:, :, :)      !! of the gradients of functions in cut quadratic cells, or pieces of them
                                                        !! (`hampm_quadratic_points`); not allocated where none are [1/m],
                                                        !! (functions, ndim, cells)
      integer :: n_nodes = 0                            !! number of nodes with degrees of freedom
      integer :: n_points = 0                           !! number of nodes, hanging nodes included
      integer :: n_elements = 0
      real(dp) :: finest_cell = 0                       !! size of the smallest leaf [m]
      real(dp), allocatable :: node_position(:, :)      !! [m], (ndim, n_points)
      real(dp), allocatable :: element_lower(:, :)      !! lower corner [m], (ndim, n_elements)
      real(dp), allocatable :: element_size(:)          !! edge length [m], (n_elements)
      integer, allocatable :: element_nodes(:, :)       !! node at each corner, (corners, n_elements)
      integer, allocatable :: element_leaf(:)           !! its leaf, of which it is the whole, a quarter or a piece, (n_elements)
      integer, allocatable :: leaf_element(:)           !! first element of each leaf, (leaves + 1)
      type(dofs_t) :: dofs                              !! which nodes hang and on which others, and the elements around each
   contains
      procedure :: node_at
      procedure :: has_element_toward
      procedure :: element_at
      procedure :: element_on_side
      procedure :: element_of_face
      procedure :: local_coordinate
      procedure :: is_transition
      procedure :: quarters_of
      procedure :: is_piece
      procedure :: piece_of
      procedure :: first_of_piece
      procedure :: last_of_piece
      procedure :: leaf_size
      procedure :: smallest_leaf_at
      procedure :: velocity_field_of
      procedure :: copy_on
      procedure :: is_in_first_field
      procedure :: copies_of_nodes
      procedure :: is_quadratic
      procedure :: is_cut
      procedure :: support_of
      procedure :: functions_in
      procedure :: shape_functions_in
      procedure :: gradients_in
      procedure :: in_leaf
      procedure :: all_pieces
   end type grid_t

contains

   !> Whether a leaf is cut by a line, or by the edge of a body: its particles do not represent all of it.
   pure logical function is_cut(self, leaf)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: leaf
      is_cut = self%cut_cells%pieces_of(leaf) > 1
      if (allocated(self%is_full) .and. .not. is_cut) is_cut = self%is_met(leaf) .and. .not. self%is_full(leaf)
   end function is_cut

   !> The corner at one end, 1 or 2, of a side of a leaf: sides are lower and upper in x, then in y.
   pure integer function side_corner(side, end)
      integer, intent(in) :: side, end
      integer :: bit                             ! that all corners of the side have in common
      bit = (side - 1)/2
      side_corner = 1 + ibits(end - 1, 0, bit) + shiftl(mod(side - 1, 2), bit) + shiftl(shiftr(end - 1, bit), bit + 1)
   end function side_corner

   !> Whether a leaf is a transition element.
   pure logical function is_transition(self, leaf)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: leaf
      is_transition = self%quarters_of(leaf) > 1
   end function is_transition

   !> Number of elements of each piece of a leaf: 1, or its quarters.
   pure integer function quarters_of(self, leaf)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: leaf
      quarters_of = (self%leaf_element(leaf + 1) - self%leaf_element(leaf))/self%all_pieces(leaf)
   end function quarters_of

   !> Number of pieces of a leaf on all velocity fields.
   pure integer function all_pieces(self, leaf)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: leaf
      all_pieces = self%n_velocity_fields*self%cut_cells%pieces_of(leaf)
   end function all_pieces

   !> The velocity field on which a body is.
   pure integer function velocity_field_of(self, body) result(velocity_field)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: body
      velocity_field = 1
      if (allocated(self%field_of_body)) velocity_field = self%field_of_body(body)
   end function velocity_field_of

   !> Whether an element is on the first velocity field.
   pure logical function is_in_first_field(self, e) result(is)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      associate (leaf => self%element_leaf(e))
         is = e - self%leaf_element(leaf) < (self%leaf_element(leaf + 1) - self%leaf_element(leaf))/self%n_velocity_fields
      end associate
   end function is_in_first_field

   !> Number on a velocity field of an element of the first one.
   pure integer function copy_on(self, e, velocity_field) result(copy)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e, velocity_field
      associate (leaf => self%element_leaf(e))
         copy = e + (velocity_field - 1)*((self%leaf_element(leaf + 1) - self%leaf_element(leaf))/self%n_velocity_fields)
      end associate
   end function copy_on

   !> Copies of each node on all velocity fields, by its copy on the first one; 0 for other points. (velocity fields, points)
   pure subroutine copies_of_nodes(self, copies)
      class(grid_t), intent(in) :: self
      integer, allocatable, intent(out) :: copies(:, :)
      integer :: leaf, first, e, c, velocity_field
      allocate (copies(self%n_velocity_fields, self%n_points), source=0)
      do leaf = 1, self%forest%leaf_count()
         first = self%leaf_element(leaf)
         do e = first, first + (self%leaf_element(leaf + 1) - first)/self%n_velocity_fields - 1
            do c = 1, corners
               copies(:, self%element_nodes(c, e)) = [(self%element_nodes(c, self%copy_on(e, velocity_field)), velocity_field=1, &
                                                       self%n_velocity_fields)]
            end do
         end do
      end do
   end subroutine copies_of_nodes

   !> Whether the cells are quadratic.
   pure logical function is_quadratic(self)
      class(grid_t), intent(in) :: self
      is_quadratic = allocated(self%solids)
   end function is_quadratic

   !> The points on which values in an element depend: its corners or, in quadratic cells, all points of its leaf, numbered along x
   !> first.
   pure function support_of(self, e) result(points)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      integer :: points(self%n_functions)
      integer :: k
      if (self%is_quadratic()) then
         associate (first => self%first_of_piece(e))
            points = [(self%element_nodes(corner_of_point(k), first + quarter_of_point(k) - 1), k=1, points_of_quadratic)]
         end associate
      else
         points = self%element_nodes(:, e)
      end if
   end function support_of

   !> The functions of these points at a place in an element.
   pure function functions_in(self, e, xi) result(n)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: xi(ndim)           !! local coordinate in the element [-]
      real(dp) :: n(self%n_functions)
      if (self%is_quadratic()) then
         n = quadratic_functions(self%in_leaf(e, xi))
      else
         n = shape_functions(xi)
      end if
   end function functions_in

   !> Both at once, the first `n_functions` of the arrays, which need no room of their own.
   pure subroutine shape_functions_in(self, e, xi, points, n)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: xi(ndim)           !! local coordinate in the element [-]
      integer, intent(out) :: points(:)
      real(dp), intent(out) :: n(:)
      if (self%is_quadratic()) then
         points(:self%n_functions) = self%support_of(e)
         n(:points_of_quadratic) = quadratic_functions(self%in_leaf(e, xi))
      else
         points(:corners) = self%element_nodes(:, e)
         n(:corners) = shape_functions(xi)
      end if
   end subroutine shape_functions_in

   !> Gradients of these functions with respect to position.
   pure function gradients_in(self, e, xi) result(gradient)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: xi(ndim)           !! local coordinate in the element [-]
      real(dp) :: gradient(self%n_functions, ndim) !! [1/m]
      if (self%is_quadratic()) then
         gradient = quadratic_gradients(self%in_leaf(e, xi), 0.5_dp/self%element_size(e))
         if (allocated(self%correction)) gradient = gradient + self%correction(:, :, (e - 1)/corners + 1)
      else
         gradient = shape_gradients(xi, 1/self%element_size(e))
      end if
   end function gradients_in

   !> Local coordinate in the leaf of which an element is a quarter.
   pure function in_leaf(self, e, xi) result(of_leaf)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: xi(ndim)           !! local coordinate in the element [-]
      real(dp) :: of_leaf(ndim)
      of_leaf = (corner_offset(e - self%first_of_piece(e) + 1) + xi)/2
   end function in_leaf

   !> The first element of the leaf of an element or, where that is cut, of its piece.
   pure integer function first_of_piece(self, e) result(first)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      associate (of_leaf => self%leaf_element(self%element_leaf(e)), quarters => self%quarters_of(self%element_leaf(e)))
         first = of_leaf + (e - of_leaf)/quarters*quarters
      end associate
   end function first_of_piece

   !> The last one.
   pure integer function last_of_piece(self, e) result(last)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      last = self%first_of_piece(e) + self%quarters_of(self%element_leaf(e)) - 1
   end function last_of_piece

   !> Whether an element is of a piece of a leaf that is cut.
   pure logical function is_piece(self, e)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      is_piece = self%cut_cells%pieces_of(self%element_leaf(e)) > 1
   end function is_piece

   !> Which piece of its leaf an element is of, from 1 on; 0 where that is not cut.
   pure integer function piece_of(self, e) result(piece)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      piece = 0
      if (.not. self%is_piece(e)) return
      associate (leaf => self%element_leaf(e))
         piece = 1 + mod((e - self%leaf_element(leaf))/self%quarters_of(leaf), self%cut_cells%pieces_of(leaf))
      end associate
   end function piece_of

   !> Size of the leaf of an element [m].
   pure real(dp) function leaf_size(self, e)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      leaf_size = self%forest%size_of(self%element_leaf(e))
   end function leaf_size

   !> Size of the smallest leaf at a node [m].
   pure real(dp) function smallest_leaf_at(self, node) result(smallest)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: node
      integer :: k
      associate (elements => self%dofs%elements_at(node))
         smallest = minval([(self%leaf_size(elements(k)), k=1, size(elements))])
      end associate
   end function smallest_leaf_at

   !> The node that stands at the place `x`; 0 where none does. Where there are two, on both sides of a cut, `toward` tells which is
   !> meant: it has an element on that side.
   pure integer function node_at(self, x, toward)
      class(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in), optional :: toward(ndim)
      real(dp) :: tolerance
      tolerance = self%forest%tolerance()
      do node_at = self%n_nodes, 1, -1
         if (.not. all(abs(self%node_position(:, node_at) - x) <= tolerance)) cycle
         if (self%n_velocity_fields > 1) then
            associate (elements => self%dofs%elements_at(node_at))
               if (.not. self%is_in_first_field(elements(1))) cycle
            end associate
         end if
         if (.not. present(toward)) return
         if (self%has_element_toward(node_at, toward)) return
      end do
   end function node_at

   !> Whether a node has an element on one side: one whose centre is in the direction `toward`, along the grid or a diagonal.
   pure logical function has_element_toward(self, node, toward) result(has)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: node
      real(dp), intent(in) :: toward(ndim)
      integer :: k
      associate (corner => self%dofs%corners_at(node))
         has = any([(is_toward(corner(k), toward), k=1, size(corner))])
      end associate
   end function has_element_toward

   !> Whether an element is on one side of the node at one of its corners, in the direction `toward`.
   pure logical function is_toward(corner, toward)
      integer, intent(in) :: corner
      real(dp), intent(in) :: toward(ndim)
      is_toward = dot_product(0.5_dp - corner_offset(corner), toward) > 0.25_dp*norm(toward) ! 0 of a cell beside a diagonal
   end function is_toward

   !> The element that covers the place `x`, of its piece if there are several; `outside` if there is none, or if `x` is NaN. Where
   !> lines move, the piece follows from the `origin` of the material. Of several velocity fields it is that of the `body`, by
   !> default the first.
   pure integer function element_at(self, x, origin, body) result(e)
      class(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in), optional :: origin(ndim) !! in the reference configuration [m]
      integer, intent(in), optional :: body
      real(dp) :: beside(ndim)
      integer(long) :: place(ndim)
      integer :: leaf, d
      e = outside
      place = self%forest%place_at(x)
      if (place(1) < 0) return
      leaf = self%forest%leaf_of(place)
      e = self%leaf_element(leaf)
      if (self%leaf_element(leaf + 1) == e + 1) return
      if (self%cut_cells%pieces_of(leaf) > 1) then
         beside = x
         if (present(origin)) beside = self%cut_cells%follow(origin)
         e = e + (self%cut_cells%piece_at(self%forest, leaf, beside) - 1)*self%quarters_of(leaf)
      end if
      if (present(body) .and. self%n_velocity_fields > 1) e = self%copy_on(e, self%velocity_field_of(body))
      if (.not. self%is_transition(leaf)) return
      place = (place - self%forest%place_of(leaf))/(level_width(self%forest%level_of(leaf))/2)
      do d = 1, ndim
         e = e + int(place(d))*2**(d - 1)
      end do
   end function element_at

   !> The element of material on a face of a crack, from a place beside it: as `element_at` or, if the place is in a sliver (part of
   !> the piece beyond the crack), the piece from which the sliver is cut off, up to an eighth away.
   pure integer function element_on_side(self, x, origin, body) result(e)
      class(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: origin(ndim)       !! in the reference configuration, beside the crack [m]
      integer, intent(in) :: body
      e = self%element_at(out_of_sliver(self, x, self%cut_cells%follow(origin)), origin, body)
   end function element_on_side

   !> The element that a face of a crack belongs to, from a place beside it: as `element_on_side`.
   pure integer function element_of_face(self, x) result(e)
      class(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      e = self%element_at(out_of_sliver(self, x, x))
   end function element_of_face

   !> A place or, if it is in a sliver of its leaf, one farther away from the crack, beyond the sliver [m].
   pure function out_of_sliver(self, x, beside) result(place)
      type(grid_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: beside(ndim)       !! where it would be if it had kept its distance from the crack [m]
      real(dp), parameter :: beyond_slivers = 0.125_dp ! of a leaf: two samples
      real(dp) :: place(ndim), point(ndim), normal(ndim)
      integer :: leaf
      place = x
      leaf = self%forest%leaf_at(x)
      if (leaf == outside) return
      if (.not. self%cut_cells%is_in_sliver(self%forest, leaf, beside)) return
      call self%cut_cells%find_nearest(beside, point, normal)
      place = x + sign(beyond_slivers*self%forest%size_of(leaf), dot_product(beside - point, normal))*normal
   end function out_of_sliver

   !> Local coordinate of the place `x` in element `e`, in [0, 1] inside it.
   pure function local_coordinate(self, e, x) result(xi)
      class(grid_t), intent(in) :: self
      integer, intent(in) :: e
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: xi(ndim)
      xi = (x - self%element_lower(:, e))/self%element_size(e)
   end function local_coordinate
end module hampm_grid
