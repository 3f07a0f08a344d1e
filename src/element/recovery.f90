!> Nodal values by superconvergent patch recovery (Zienkiewicz & Zhu 1992): at each node the linear function that fits best, by
!> least squares, the particles of the cells around it.
!>
!> Linear fields come out exactly, at edges of bodies and beside cells of another size too, where the lumped mass matrix errs in
!> the first order.
!>
!> Quadratic cells for indicators: fields have values at the corners of cells, as in bilinear cells of the same size. The other
!> nodes of a cell, in the middle of its sides and inside it, get interpolated values. One in the middle of a side that is a corner
!> of finer cells has a value of its own, as in the bilinear transition element.
!>
!> In a grid of bilinear cells all nodes are corners, and this step is empty.
module hampm_recovery
   use hampm_kinds, only: dp, ndim, corners
   use hampm_dofs, only: element_of_slot
   use hampm_grid, only: grid_t
   use hampm_lapack, only: dposv
   use hampm_material, only: are_of_one
   use hampm_mass_matrix, only: mass_matrix_t
   use hampm_basis, only: points_of_quadratic
   use hampm_matter, only: matter_t
   use hampm_tensors, only: in_plane, identity, inverse_transpose, determinant_of_matrix => determinant
   implicit none
   private
   public :: recover, recover_quadratic, terms_at, n_terms, are_corners, gather_at_corners, spread_from_corners, sides_of_cell, &
             middle_of_cell, slope_weights

   !> Of the points of a quadratic cell, along x one after the other: a node in the middle of each side, and the ends of that
   integer, parameter :: sides_of_cell(3, 4) = reshape([2, 1, 3, 4, 1, 7, 6, 3, 9, 8, 7, 9], [3, 4])
   integer, parameter :: middle_of_cell = 5

   integer, parameter :: n_terms = 6             !! of a quadratic function of two coordinates

   !> Variance of the places of the particles, over the square of the smallest cell around, below which a slope is not trusted but
   !> kept small: of particles evenly on a tenth of a cell it is w**2/12 with w = 0.11.
   real(dp), parameter :: least_spread = 1.0e-3_dp

   !> Mean place of particles around a node, in edges of the smallest cell there, from which on they are on one side of it: it is
   !> 1/2 at straight edges, 1/6 at corners that point inwards, and at most 1/4 beside cells of half the size.
   real(dp), parameter :: one_sided = 0.4_dp

contains

   !> Nodal values of a field of `width` components, from all particles or from particles of one material.
   subroutine recover(m, matrix, width, field, nodal, material)
      type(matter_t), intent(in) :: m
      type(mass_matrix_t), intent(in) :: matrix
      integer, intent(in) :: width
      real(dp), intent(in) :: field(width, *)    !! values of the particles, (width, n)
      real(dp), intent(out) :: nodal(width, *)   !! values of the points, 0 where there are no particles, (width, n_points)
      integer, intent(in), optional :: material
      integer, allocatable :: number(:)
      integer :: a
      allocate (number(m%particles%n))
      nodal(:, :m%grid%n_points) = 0
      associate (all => matrix%all)
         do a = 1, all%n_nodes
            call fit(m, all%nodes(a), width, field, nodal(:, all%nodes(a)), number, material)
         end do
      end associate
      call m%grid%dofs%distribute(matrix%all, width, nodal)
   end subroutine recover

   !> Coefficients at the corners of quadratic cells, of 1, x, y, x**2, x y and y**2 with x and y from the node in edges of the
   !> smallest cell there, of the best quadratic fit to the particles of the cells around it: one order more than the stress of such
   !> cells. From all particles or from particles of one material.
   subroutine recover_quadratic(m, width, field, coefficient, edge, material, sides)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: width
      real(dp), intent(in) :: field(width, *)    !! values of the particles, (width, n)
      real(dp), intent(out) :: coefficient(:, :, :) !! 0 where there are no particles, (n_terms, width, n_nodes)
      real(dp), intent(out) :: edge(:)           !! of the smallest cell at the node [m], (n_nodes)
      integer, intent(in), optional :: material
      integer, intent(out), optional :: sides(:) !! 0 with particles all around, 1 at an edge, 2 at a corner of a body, (n_nodes)
      logical, allocatable :: is_corner(:)
      integer, allocatable :: number(:)
      integer :: node, n_sides
      allocate (is_corner(m%grid%n_points), number(m%particles%n))
      is_corner = are_corners(m)
      coefficient = 0
      edge = 1
      if (present(sides)) sides = 0
      do node = 1, m%grid%n_nodes
         if (.not. is_corner(node)) cycle
         call fit_quadratic(m, node, width, field, coefficient(:, :, node), edge(node), n_sides, number, material)
         if (present(sides)) sides(node) = n_sides
      end do
   end subroutine recover_quadratic

   !> The same at one node, by the normal equations. Components that few particles do not determine are kept small.
   subroutine fit_quadratic(m, node, width, field, coefficient, edge, n_sides, number, material)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: node, width
      real(dp), intent(in) :: field(width, *)
      real(dp), intent(out) :: coefficient(n_terms, width), edge
      integer, intent(out) :: n_sides            !! directions in which particles are on one side
      integer, intent(inout) :: number(:)        !! room for all particles
      integer, intent(in), optional :: material
      real(dp), parameter :: ridge = 1e-9_dp
      real(dp) :: matrix(n_terms, n_terms), term(n_terms)
      integer :: n, j, k, info
      call find_surroundings(m, node, material, n, number, edge)
      matrix = 0
      coefficient = 0
      do k = 1, n
         term = terms_at((m%particles%place_in_grid(number(k)) - m%grid%node_position(:, node))/edge)
         do j = 1, n_terms
            matrix(:, j) = matrix(:, j) + term*term(j)
         end do
         do j = 1, width
            coefficient(:, j) = coefficient(:, j) + term*field(j, number(k))
         end do
      end do
      n_sides = count(abs(matrix(2:1 + ndim, 1)) > one_sided*matrix(1, 1))
      if (.not. matrix(1, 1) > 0) return
      do k = 1, n_terms
         matrix(k, k) = matrix(k, k) + ridge*matrix(1, 1)
      end do
      call dposv('L', n_terms, width, matrix, n_terms, coefficient, n_terms, info)
      if (info /= 0) coefficient = 0
   end subroutine fit_quadratic

   !> The terms of a quadratic function.
   pure function terms_at(x) result(term)
      real(dp), intent(in) :: x(ndim)
      real(dp) :: term(n_terms)
      term = [1.0_dp, x(1), x(2), x(1)**2, x(1)*x(2), x(2)**2]
   end function terms_at

   !> Value at a node of the linear function that fits the particles around it.
   subroutine fit(m, node, width, field, value, number, material)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: node, width
      real(dp), intent(in) :: field(width, *)
      real(dp), intent(out) :: value(width)
      integer, intent(inout) :: number(:)        !! room for all particles
      integer, intent(in), optional :: material
      real(dp) :: x(ndim), mean_x(ndim), spread_x(ndim, ndim), mean(width), moment(width, ndim), edge
      integer :: n, k, d
      call find_surroundings(m, node, material, n, number, edge)
      mean_x = 0
      spread_x = 0
      mean = 0
      moment = 0
      value = 0
      if (n == 0) return
      do k = 1, n
         x = (m%particles%place_in_grid(number(k)) - m%grid%node_position(:, node))/edge
         mean_x = mean_x + x
         mean = mean + field(:, number(k))
         do d = 1, ndim
            spread_x(:, d) = spread_x(:, d) + x*x(d)
            moment(:, d) = moment(:, d) + field(:, number(k))*x(d)
         end do
      end do
      mean_x = mean_x/n
      mean = mean/n
      do d = 1, ndim
         spread_x(:, d) = spread_x(:, d)/n - mean_x*mean_x(d)
         moment(:, d) = moment(:, d)/n - mean*mean_x(d)
      end do
      value = mean - matmul(moment, slope_weights(spread_x, mean_x))
   end subroutine fit

   !> The particles in the leaves (or pieces) at a node, of one material if present, and the edge of the smallest leaf [m].
   pure subroutine find_surroundings(m, node, material, n, number, edge)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: node
      integer, intent(in), optional :: material
      integer, intent(out) :: n                  !! how many there are
      integer, intent(inout) :: number(:)        !! the first n are theirs
      real(dp), intent(out) :: edge
      integer :: first, last, k, e, i
      n = 0
      last = 0
      edge = huge(edge)
      associate (dofs => m%grid%dofs, b => m%blocks)
         do k = dofs%first_slot(node), dofs%first_slot(node + 1) - 1 ! elements ascend, and those of a piece follow each other
            first = m%grid%first_of_piece(element_of_slot(dofs%slot(k)))
            if (first <= last) cycle
            last = m%grid%last_of_piece(first)
            edge = min(edge, m%grid%leaf_size(first))
            do e = first, last
               do i = b%first_in(e), b%last_in(e), b%stride_in(e)
                  if (present(material)) then
                     if (.not. are_of_one(m%materials, material, m%particles%material(i))) cycle
                  end if
                  n = n + 1
                  number(n) = i
               end do
            end do
         end do
      end associate
   end subroutine find_surroundings

   !> S^-1 x of the matrix S of the spread of the places.
   pure function slope_weights(spread_x, x) result(weights)
      real(dp), intent(in) :: spread_x(ndim, ndim), x(ndim)
      real(dp) :: weights(ndim)
      real(dp) :: s(ndim, ndim), half_trace, determinant
      integer :: d
      if (ndim > 2) then
         s = spread_x - least_spread*identity    ! positive definite where no eigenvalue is too small
         if (s(1, 1) > 0 .and. s(1, 1)*s(2, 2) > s(1, 2)*s(2, 1) .and. determinant_of_matrix(s) > 0) then
            s = spread_x
         else
            s = spread_x + least_spread*identity
         end if
         weights = matmul(inverse_transpose(s), x)
         return
      end if
      s = spread_x
      half_trace = (s(1, 1) + s(2, 2))/2
      determinant = s(1, 1)*s(2, 2) - s(1, 2)*s(2, 1)
      if (half_trace - sqrt(max(0.0_dp, half_trace**2 - determinant)) < least_spread) then
         do d = 1, ndim
            s(d, d) = s(d, d) + least_spread
         end do
         determinant = s(1, 1)*s(2, 2) - s(1, 2)*s(2, 1)
      end if
      weights = in_plane(s(2, 2)*x(1) - s(1, 2)*x(2), s(1, 1)*x(2) - s(2, 1)*x(1))/determinant
   end function slope_weights

   !> Whether each point is a corner of a cell with particles; all points of bilinear cells are taken for such.
   pure function are_corners(m) result(is_corner)
      type(matter_t), intent(in) :: m
      logical, allocatable :: is_corner(:)
      integer :: e, q
      allocate (is_corner(m%grid%n_points))
      is_corner = .not. m%grid%is_quadratic()
      if (.not. m%grid%is_quadratic()) return
      do e = 1, m%grid%n_elements, corners
         if (all(m%blocks%count_in(e:e + corners - 1) == 0)) cycle
         do q = 1, corners
            is_corner(m%grid%element_nodes(q, e + q - 1)) = .true.
         end do
      end do
   end function are_corners

   !> Distribute sums at the other points, such as masses, to the corners: from the middle of a cell to its sides, from sides to
   !> their ends.
   pure subroutine gather_at_corners(grid, is_corner, sums)
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: is_corner(:)
      real(dp), intent(inout) :: sums(:)         !! (n_points)
      integer :: at(points_of_quadratic), e, k
      if (.not. grid%is_quadratic()) return
      do e = 1, grid%n_elements, corners
         at = grid%support_of(e)
         sums(at(sides_of_cell(1, :))) = sums(at(sides_of_cell(1, :))) + sums(at(middle_of_cell))/4
         sums(at(middle_of_cell)) = 0
      end do
      do e = 1, grid%n_elements, corners
         at = grid%support_of(e)
         do k = 1, size(sides_of_cell, 2)
            associate (middle => at(sides_of_cell(1, k)), ends => at(sides_of_cell(2:, k)))
               if (is_corner(middle)) cycle
               sums(ends) = sums(ends) + sums(middle)/2
               sums(middle) = 0                  ! the cell on the other side of it has nothing left to give
            end associate
         end do
      end do
   end subroutine gather_at_corners

   !> Interpolate the other points from the corners: on a side the mean of its ends, in the middle of a cell the mean of its sides:
   !> the bilinear function of the cell.
   pure subroutine spread_from_corners(grid, is_corner, values)
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: is_corner(:)
      real(dp), intent(inout) :: values(:)       !! (n_points)
      integer :: at(points_of_quadratic), e, k
      if (.not. grid%is_quadratic()) return
      do e = 1, grid%n_elements, corners
         at = grid%support_of(e)
         do k = 1, size(sides_of_cell, 2)
            associate (middle => at(sides_of_cell(1, k)), ends => at(sides_of_cell(2:, k)))
               if (.not. is_corner(middle)) values(middle) = sum(values(ends))/2
            end associate
         end do
         values(at(middle_of_cell)) = sum(values(at(sides_of_cell(1, :))))/4
      end do
   end subroutine spread_from_corners
end module hampm_recovery
