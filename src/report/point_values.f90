!> Values at a material point: a polynomial is fitted to the particles around it by weighted least squares (moving least squares;
!> Lancaster & Salkauskas, Mathematics of Computation 37 (1981) 141-158). The weights fall to zero at a radius of a few cells:
!> nothing jumps where the point passes from cell to cell.
!>
!> A fit to the displacement is quadratic: particles move with the nodes, and shape functions differ from a smooth field by the
!> second order in the cell. A fit to strain and stress is linear, to the means over cells: within a cell they oscillate around a
!> smooth field by the first order, but not in the middle of a cell (Zienkiewicz & Zhu, International Journal for Numerical Methods
!> in Engineering 33 (1992) 1331-1364); in quadratic cells by the second order. Both are exact where the field is linear.
!>
!> Only particles of the material of the point take part, of bodies that are joined there, and of these only the ones that no crack
!> hides from it. All distances are in the reference configuration: a point keeps its material in either frame.
module hampm_point_values
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_crack_lines, only: both_faces
   use hampm_polygon, only: distance_to_segment, area => twice_area
   use hampm_cracks, only: cracks_t
   use hampm_material, only: are_of_one
   use hampm_matter, only: matter_t
   implicit none
   private
   public :: view_t, surroundings_t, new_view, look_around, weights_of, weights_of_cells, quadratic_fit

   integer, parameter :: linear_fit = 1 + ndim, quadratic_fit = linear_fit + ndim*(ndim + 1)/2 !! numbers of terms

   real(dp), parameter :: radius = 2 + 1e-6_dp   !! of the weights, of linear cells, by a little more than round numbers [cells]
   real(dp), parameter :: radius_quadratic = 1 + 1e-6_dp !! the same of quadratic ones, which have more particles
   integer, parameter :: fewest = 3**ndim        !! particles within it: it grows until there are so many, or
   real(dp), parameter :: farthest = 3           !! is as large [cells],
   real(dp), parameter :: growth = 1.26_dp       !! by this factor each time

   !> The open part of a crack with two faces, in the reference configuration.
   type :: face_lines_t
      real(dp), allocatable :: points(:, :)      !! [m], (ndim, 2 or more)
   end type face_lines_t

   !> The particles that give the values at some points, and the cracks that separate them.
   type :: view_t
      integer, allocatable :: particle(:)
      integer, allocatable :: joined(:)          !! by body, which of them are one
      type(face_lines_t), allocatable :: lines(:) !! cracks
   end type view_t

   !> The particles around a point.
   type :: surroundings_t
      integer, allocatable :: particle(:)
      real(dp), allocatable :: from_point(:, :)  !! over the radius of the weights [-], (ndim, particles); some above 1, for
                                                 !! the means over cells
   end type surroundings_t

contains

   !> View of a box: all cracks with two faces, and all particles so near that `look_around` may use them.
   pure subroutine new_view(m, cracks, joined, lower, upper, view)
      type(matter_t), intent(in) :: m
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: joined(:)           !! by body, which of them are one
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! corners of the box in the reference configuration [m]
      type(view_t), intent(out) :: view
      real(dp), parameter :: margin = 4          ! cells
      integer :: is_near(m%particles%n), k, i, n
      view%joined = joined
      n = 0
      allocate (view%lines(count([(cracks%crack(k)%face == both_faces, k=1, size(cracks%crack))])))
      do k = 1, size(cracks%crack)
         if (cracks%crack(k)%face /= both_faces) cycle
         n = n + 1
         view%lines(n)%points = cracks%crack(k)%open_part()
      end do
      n = 0
      associate (x => m%particles%reference, from => lower - margin*m%grid%forest%cell, to => upper + margin*m%grid%forest%cell)
         do i = 1, m%particles%n                 ! in one direction first: most are apart there
            if (x(i, 1) < from(1) .or. x(i, 1) > to(1)) cycle
            if (any(x(i, :) < from .or. x(i, :) > to)) cycle
            n = n + 1
            is_near(n) = i
         end do
      end associate
      view%particle = is_near(:n)
   end subroutine new_view

   !> Find the particles around a point: of the nearest one's material and of bodies that are one with its own; on the interface of
   !> two materials of both, as they are equally near.
   pure subroutine look_around(m, view, x, toward, around)
      type(matter_t), intent(in) :: m
      type(view_t), intent(in) :: view
      real(dp), intent(in) :: x(ndim)            !! in the reference configuration [m]
      real(dp), intent(in) :: toward(ndim)       !! of a point on a crack: unit vector to the side of its material; else 0
      type(surroundings_t), intent(out) :: around
      real(dp), parameter :: aside = 1e-6_dp     ! cells
      integer, parameter :: most_alike = 8       ! particles that are as near as the nearest one
      real(dp), parameter :: beyond = 2          ! additional reach of the particles of cells [cells]
      real(dp) :: eye(ndim), nearest, reach, cell
      integer, allocatable :: seen(:)
      integer :: i, k, j, n, within, nearby(most_alike)
      eye = x + aside*m%grid%finest_cell*toward
      nearest = huge(nearest)
      do k = 1, size(view%particle)
         if (distance(view%particle(k)) >= nearest) cycle
         if (.not. is_hidden(view%particle(k))) nearest = distance(view%particle(k))
      end do
      j = 0
      cell = huge(cell)
      do k = 1, size(view%particle)
         if (distance(view%particle(k)) > nearest + aside*m%grid%finest_cell) cycle
         if (is_hidden(view%particle(k))) cycle
         if (j < most_alike) then
            j = j + 1
            nearby(j) = view%particle(k)
         end if
         cell = min(cell, m%grid%leaf_size(m%particles%cell(view%particle(k))))
      end do
      allocate (seen(size(view%particle)))
      reach = cell*merge(radius_quadratic, radius, m%grid%is_quadratic())
      do
         n = 0
         within = 0
         do k = 1, size(view%particle)
            if (distance(view%particle(k)) >= reach + beyond*cell) cycle
            if (.not. any([(are_alike(view%particle(k), nearby(i)), i=1, j)])) cycle
            if (is_hidden(view%particle(k))) cycle
            n = n + 1
            seen(n) = view%particle(k)
            if (distance(view%particle(k)) < reach) within = within + 1
         end do
         if (within >= fewest .or. reach > farthest*cell) exit
         reach = growth*reach
      end do
      around%particle = seen(:n)
      allocate (around%from_point(ndim, n))
      do k = 1, n
         around%from_point(:, k) = (m%particles%reference(seen(k), :) - x)/reach
      end do

   contains

      !> Distance of a particle from the point [m].
      pure real(dp) function distance(i)
         integer, intent(in) :: i
         distance = hypot(m%particles%reference(i, 1) - x(1), m%particles%reference(i, 2) - x(2))
         if (ndim > 2) distance = hypot(distance, m%particles%reference(i, ndim) - x(ndim))
      end function distance

      !> Whether two particles are of one material and of bodies that are one.
      pure logical function are_alike(i, j)
         integer, intent(in) :: i, j
         associate (p => m%particles)
            are_alike = are_of_one(m%materials, p%material(i), p%material(j)) .and. view%joined(p%body(i)) == view%joined(p%body(j))
         end associate
      end function are_alike

      !> Whether a crack separates a particle from the point, or passes through it: rounding decides its side.
      pure logical function is_hidden(i)
         integer, intent(in) :: i
         real(dp) :: x_of(ndim)
         integer :: k, j
         is_hidden = .false.
         x_of = m%particles%reference(i, :)
         do k = 1, size(view%lines)
            do j = 2, size(view%lines(k)%points, 2)
               associate (points => view%lines(k)%points)
                  is_hidden = is_between(points(:, j - 1), points(:, j), eye, x_of) .or. &
                              distance_to_segment(x_of, points(:, j - 1), points(:, j)) <= aside*m%grid%finest_cell
               end associate
               if (is_hidden) return
            end do
         end do
      end function is_hidden
   end subroutine look_around

   !> Whether a segment from a to b is between two places, none of which is on its line.
   pure logical function is_between(a, b, x, y)
      real(dp), dimension(ndim), intent(in) :: a, b, x, y !! [m]
      real(dp), parameter :: rounding = 1e-10_dp !! of the areas of triangles, over the squares of the distances
      real(dp) :: slack, of_x, of_y
      of_x = area(a, b, x)
      of_y = area(a, b, y)
      slack = rounding*norm(b - a)*norm(y - x)
      is_between = .false.
      if (of_x*of_y >= 0 .or. min(abs(of_x), abs(of_y)) <= slack) return
      is_between = area(x, y, a)*area(x, y, b) <= 0
   end function is_between

   !> Weights of the particles around a point for the value there of a linear function, fitted to their means over cells, in
   !> quadratic cells to themselves.
   pure function weights_of_cells(m, around) result(weights)
      type(matter_t), intent(in) :: m
      type(surroundings_t), intent(in) :: around
      real(dp), allocatable :: weights(:), volume(:), of_cells(:)
      type(surroundings_t) :: cells
      integer, allocatable :: cell(:), first(:)  ! of each particle, and the first particle of each
      integer :: k, c, n
      if (m%grid%is_quadratic()) then
         weights = weights_of(around, linear_fit)
         return
      end if
      allocate (cell(size(around%particle)), first(size(around%particle)), volume(size(around%particle)))
      allocate (cells%from_point(ndim, size(around%particle)))
      n = 0
      do k = 1, size(around%particle)
         associate (p => m%particles, i => around%particle(k))
            do c = 1, n
               if (p%cell(i) == p%cell(first(c)) .and. are_of_one(m%materials, p%material(i), p%material(first(c)))) exit
            end do
            if (c > n) then
               n = c
               first(c) = i
               volume(c) = 0
               cells%from_point(:, c) = 0
            end if
            cell(k) = c
            volume(c) = volume(c) + p%volume(i)
            associate (x => cells%from_point(:, c))
               x = x + p%volume(i)/volume(c)*(around%from_point(:, k) - x)
            end associate
         end associate
      end do
      cells%from_point = cells%from_point(:, :n)
      of_cells = weights_of(cells, linear_fit)
      weights = of_cells(cell)*m%particles%volume(around%particle)/volume(cell)
   end function weights_of_cells

   !> Weights of the particles around a point for the value there: the value of the polynomial that is fitted to them. Terms that
   !> depend on others at these particles, as where they stand in few rows, are left out.
   !>
   !> With A the terms at the particles and W the weights, W**(1/2) A = Q R by Gram and Schmidt, twice; the value at the point, the
   !> first unknown, is z . Q^T W**(1/2) f with R^T z = (1, 0, ...).
   pure function weights_of(around, terms) result(weights)
      type(surroundings_t), intent(in) :: around
      integer, intent(in) :: terms               !! `linear_fit` or `quadratic_fit`
      real(dp), allocatable :: weights(:), q(:, :), root(:), term(:)
      real(dp), parameter :: no_more = 1e-3_dp   ! of a term is left where it is others
      real(dp) :: r(terms, terms), z(terms), size_of_term, part
      integer :: i, j, a, b, again
      associate (x => around%from_point, n => size(around%from_point, 2))
         allocate (q(n, terms), root(n), term(n), weights(n))
         root = 1
         do a = 1, ndim
            root = root - x(a, :)**2
         end do
         root = max(0.0_dp, root)
         a = 1
         b = 0
         weights = 0
         r = 0
         z = 0
         do j = 1, terms
            if (j == 1) then
               term = root
            else if (j <= linear_fit) then
               term = root*x(j - 1, :)
            else                                 ! products of directions a and b
               b = b + 1
               if (b > ndim) a = a + 1
               if (b > ndim) b = a
               term = merge(root*x(a, :)**2, root*x(a, :)*x(b, :), a == b)
            end if
            size_of_term = norm(term)
            do again = 1, 2
               do i = 1, j - 1
                  part = dot_product(q(:, i), term)
                  r(i, j) = r(i, j) + part
                  term = term - part*q(:, i)
               end do
            end do
            q(:, j) = 0
            r(j, j) = norm(term)
            if (r(j, j) <= no_more*size_of_term) cycle
            q(:, j) = term/r(j, j)
            z(j) = (merge(1.0_dp, 0.0_dp, j == 1) - dot_product(r(:j - 1, j), z(:j - 1)))/r(j, j)
            weights = weights + z(j)*q(:, j)
         end do
         weights = root*weights
      end associate
   end function weights_of
end module hampm_point_values
