!> Integrals of polynomials over the part of a body in each piece of a leaf: the area and the moments for the weights of particles
!> of quadratic cells (`hampm_quadratic_points`).
!>
!> The square of the leaf is quartered until few straight lines, of cracks or edges, run through each square: these cut it into
!> convex polygons, over which polynomials are integrated exactly. A circle is a polygon of its area.
module hampm_piece_moments
   use hampm_kinds, only: dp, ndim, plane
   use hampm_basis, only: points_of_quadratic, quadratic_functions, quadratic_gradients
   use hampm_cut_cells, only: cut_cells_t
   use hampm_forest, only: forest_t, corner_offset
   use hampm_outline, only: outline_t, ring_t
   use hampm_polygon, only: clip, clip_segment, twice_area
   use hampm_tensors, only: norm, in_plane, quarter_turn
   implicit none
   private
   public :: polynomials_at, moments_of_pieces, integrals_of_gradients, integrals_in_ring, n_polynomials

   integer, parameter :: n_polynomials = 13, n_of_gradients = 8

   !> Degrees in x and y of the polynomials, products of Legendre polynomials. The first eight span gradients of biquadratic
   !> functions; all together span products of linear stress with these.
   integer, parameter :: degree(plane, n_polynomials) = reshape([0, 0, 1, 0, 0, 1, 1, 1, 2, 0, 0, 2, 2, 1, 1, 2, &
                                                               2, 2, 3, 0, 0, 3, 3, 1, 1, 3], [plane, n_polynomials])
   integer, parameter :: most_divisions = 7      !! of a leaf
   integer, parameter :: most_lines = 3          !! through a square that is not divided
   integer, parameter :: sides_of_circle = 32    !! for each edge of a leaf along it

   ! A rule of six points for a triangle, exact to the fourth degree (Dunavant 1985)
   real(dp), parameter :: outer = 0.091576213509770743_dp, outer_weight = 0.109951743655321868_dp
   real(dp), parameter :: inner = 0.445948490915964886_dp, inner_weight = 0.223381589678011466_dp

contains

   !> The polynomials at a place in a leaf.
   pure function polynomials_at(xi) result(value)
      real(dp), intent(in) :: xi(ndim)           !! local coordinate in the leaf, 0 to 1
      real(dp) :: value(n_polynomials)
      real(dp) :: p(0:3, ndim)
      integer :: k
      associate (x => 2*xi - 1)
         p(0, :) = 1
         p(1, :) = x
         p(2, :) = (3*x**2 - 1)/2
         p(3, :) = (5*x**3 - 3*x)/2
      end associate
      value = [(p(degree(1, k), 1)*p(degree(2, k), 2), k=1, n_polynomials)]
   end function polynomials_at

   !> Integrals of the gradients of the biquadratic functions, by local coordinates, over a region with these moments, over the area
   !> of the leaf [-]: by their coefficients, from integrals over the whole leaf by three points in each direction.
   pure function integrals_of_gradients(moments) result(integrals)
      real(dp), intent(in) :: moments(:)         !! of the polynomials [-]
      real(dp) :: integrals(points_of_quadratic, ndim)
      real(dp), parameter :: at(3) = 0.5_dp + [-0.5_dp, 0.0_dp, 0.5_dp]*sqrt(0.6_dp), weight(3) = [5, 8, 5]/18.0_dp
      integer :: i, j
      integrals = 0
      do j = 1, 3
         do i = 1, 3
            integrals = integrals + weight(i)*weight(j)*quadratic_gradients(in_plane(at(i), at(j)), 1.0_dp) &
                        *sum((2*degree(1, :n_of_gradients) + 1)*(2*degree(2, :n_of_gradients) + 1) &
                             *first_polynomials(in_plane(at(i), at(j)))*moments(:n_of_gradients))
         end do
      end do
   contains
      !> Polynomials that span gradients.
      pure function first_polynomials(xi) result(value)
         real(dp), intent(in) :: xi(ndim)
         real(dp) :: value(n_of_gradients), every(n_polynomials)
         every = polynomials_at(xi)
         value = every(:n_of_gradients)
      end function first_polynomials
   end function integrals_of_gradients

   !> The same around an axis: integrals of r times the gradients plus, in the first direction, the functions, over the area of the
   !> leaf [m]: forces on the points by uniform stress, equal in both directions of the first row. All polynomials are needed.
   pure function integrals_in_ring(moments, lower, edge) result(integrals)
      real(dp), intent(in) :: moments(:)         !! of the polynomials [-]
      real(dp), intent(in) :: lower, edge        !! least radius of the leaf, and its size [m]
      real(dp) :: integrals(points_of_quadratic, ndim)
      real(dp), parameter :: near = 0.339981043584856265_dp, far = 0.861136311594052575_dp, part = 0.326072577431273071_dp
      real(dp), parameter :: at(4) = 0.5_dp + [-far, -near, near, far]/2, weight(4) = [0.5_dp - part, part, part, 0.5_dp - part]
      real(dp) :: value(points_of_quadratic, ndim)
      integer :: i, j
      integrals = 0
      do j = 1, 4
         do i = 1, 4
            value = (lower + edge*at(i))*quadratic_gradients(in_plane(at(i), at(j)), 1.0_dp)
            value(:, 1) = value(:, 1) + edge*quadratic_functions(in_plane(at(i), at(j)))
            integrals = integrals + weight(i)*weight(j)*value &
                        *sum((2*degree(1, :) + 1)*(2*degree(2, :) + 1)*polynomials_at(in_plane(at(i), at(j)))*moments)
         end do
      end do
   end function integrals_in_ring

   !> Integrals of the polynomials over each piece of a leaf, within a body if its outline is given, over the area of the leaf [-],
   !> (polynomials, pieces).
   pure function moments_of_pieces(cut, forest, leaf, body) result(moments)
      type(cut_cells_t), intent(in) :: cut
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      type(outline_t), intent(in), optional :: body
      real(dp), allocatable :: moments(:, :)
      real(dp), allocatable :: segment(:, :, :)
      integer :: k
      allocate (moments(n_polynomials, cut%pieces_of(leaf)), source=0.0_dp)
      segment = cut%segments_near(leaf)
      if (present(body)) then
         do k = 1, size(body%rings)
            call add_sides(body%rings(k), forest%position(forest%place_of(leaf)), forest%size_of(leaf), segment)
         end do
      end if
      do k = 1, size(segment, 3)
         segment(:, :, k) = (segment(:, :, k) - spread(forest%position(forest%place_of(leaf)), 2, 2))/forest%size_of(leaf)
      end do
      call add_square(cut, forest, leaf, segment, in_plane(0.0_dp, 0.0_dp), 1.0_dp, most_divisions, moments, body)
   end function moments_of_pieces

   !> Add the sides of a ring that may meet a square.
   pure subroutine add_sides(ring, lower, edge, segment)
      type(ring_t), intent(in) :: ring
      real(dp), intent(in) :: lower(ndim), edge  !! of the square [m]
      real(dp), allocatable, intent(inout) :: segment(:, :, :) !! [m], (ndim, 2, segments)
      real(dp), parameter :: pi = acos(-1.0_dp)
      real(dp), allocatable :: corner(:, :)
      integer :: n, k, next
      if (ring%is_circle) then
         if (abs(norm(lower + edge/2 - ring%center) - ring%radius) > edge) return
         n = max(64, sides_of_circle*ceiling(2*pi*ring%radius/edge))
         corner = ring%corners(n)
         do k = 1, n
            corner(:, k) = ring%center + sqrt(2*pi/(n*sin(2*pi/n)))*(corner(:, k) - ring%center)
         end do
      else
         corner = ring%points
      end if
      do k = 1, size(corner, 2)
         next = mod(k, size(corner, 2)) + 1
         if (any(max(corner(:, k), corner(:, next)) < lower .or. min(corner(:, k), corner(:, next)) > lower + edge)) cycle
         segment = reshape([segment, corner(:, k), corner(:, next)], [ndim, 2, size(segment, 3) + 1])
      end do
   end subroutine add_sides

   !> Add the material in a square of a leaf.
   pure recursive subroutine add_square(cut, forest, leaf, segment, lower, edge, divisions, moments, body)
      type(cut_cells_t), intent(in) :: cut
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      real(dp), intent(in) :: segment(:, :, :)   !! of lines, in local coordinates, (ndim, 2, segments)
      real(dp), intent(in) :: lower(ndim), edge  !! of the square
      integer, intent(in) :: divisions           !! that are left
      real(dp), intent(inout) :: moments(:, :)
      type(outline_t), intent(in), optional :: body
      real(dp) :: corner(ndim, 4)
      integer :: k
      integer, allocatable :: met(:)
      met = pack([(k, k=1, size(segment, 3))], [(meets(segment(:, :, k), lower, edge), k=1, size(segment, 3))])
      if (size(met) > most_lines .and. divisions > 0) then
         do k = 1, 4
            call add_square(cut, forest, leaf, segment, lower + edge/2*corner_offset(k), edge/2, divisions - 1, moments, body)
         end do
         return
      end if
      corner = spread(lower, 2, 4)
      corner(1, 2:3) = corner(1, 2:3) + edge
      corner(2, 3:) = corner(2, 3:) + edge
      call add_parts(cut, forest, leaf, corner, segment(:, :, met), moments, body)
   end subroutine add_square

   !> Add the parts into which lines divide a convex polygon. A line that ends in it divides all of it: each part is in one piece.
   pure recursive subroutine add_parts(cut, forest, leaf, points, line, moments, body)
      type(cut_cells_t), intent(in) :: cut
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      real(dp), intent(in) :: points(:, :)       !! in local coordinates, anticlockwise, (ndim, 3 or more)
      real(dp), intent(in) :: line(:, :, :)      !! in local coordinates, (ndim, 2, lines)
      real(dp), intent(inout) :: moments(:, :)
      type(outline_t), intent(in), optional :: body
      real(dp), allocatable :: part(:, :)
      integer :: side
      if (size(line, 3) == 0) then
         call add_polygon(cut, forest, leaf, points, moments, body)
         return
      end if
      do side = -1, 1, 2
         part = points
         call clip(part, line(:, 1, 1), side*quarter_turn(line(:, 2, 1) - line(:, 1, 1)))
         if (size(part, 2) > 2) call add_parts(cut, forest, leaf, part, line(:, :, 2:), moments, body)
      end do
   end subroutine add_parts

   !> Whether a segment runs through the inside of a square.
   pure logical function meets(segment, lower, edge)
      real(dp), intent(in) :: segment(ndim, 2), lower(ndim), edge
      real(dp), parameter :: hair = 1e-9_dp
      real(dp) :: from, to
      call clip_segment(segment(:, 1), segment(:, 2), lower + hair*edge, lower + (1 - hair)*edge, from, to)
      meets = to > from .and. any(abs(segment(:, 2) - segment(:, 1)) > hair*edge)
   end function meets

   !> Add the integrals over a convex polygon to those of the piece in which its middle is, if that is in the body.
   pure subroutine add_polygon(cut, forest, leaf, points, moments, body)
      type(cut_cells_t), intent(in) :: cut
      type(forest_t), intent(in) :: forest
      integer, intent(in) :: leaf
      real(dp), intent(in) :: points(:, :)       !! in local coordinates, anticlockwise, (ndim, 3 or more)
      real(dp), intent(inout) :: moments(:, :)
      type(outline_t), intent(in), optional :: body
      real(dp) :: x(ndim)
      integer :: piece, i
      x = forest%position(forest%place_of(leaf)) + forest%size_of(leaf)*sum(points, dim=2)/size(points, 2)
      if (present(body)) then
         if (.not. body%covers(x)) return
      end if
      piece = 1
      if (cut%pieces_of(leaf) > 1) piece = cut%piece_at(forest, leaf, x)
      do i = 3, size(points, 2)
         moments(:, piece) = moments(:, piece) + twice_area(points(:, 1), points(:, i - 1), points(:, i))/2*( &
                             outer_weight*mean_over(points(:, [1, i - 1, i]), outer) &
                             + inner_weight*mean_over(points(:, [1, i - 1, i]), inner))
      end do
   end subroutine add_polygon

   !> The sum of the polynomials over the three points of a triangle of which two coordinates are the same.
   pure function mean_over(corner, part) result(value)
      real(dp), intent(in) :: corner(ndim, 3)
      real(dp), intent(in) :: part               !! the coordinates that are the same
      real(dp) :: value(n_polynomials)
      integer :: k
      value = 0
      do k = 1, 3
         value = value + polynomials_at(part*sum(corner, dim=2) + (1 - 3*part)*corner(:, k))
      end do
   end function mean_over
end module hampm_piece_moments
