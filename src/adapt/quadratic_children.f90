!> Fields of the particles in the finer cells of a divided quadratic cell, or in the cell that four become.
!>
!> Displacement, its gradient and velocity of the n x n particles of a quadratic cell are biquadratic, each component: in the total
!> frame they follow the nodes of their cell. The biquadratic function that fits them best (through them where n = 3) is that field,
!> and its values at the children's places are one field again, exact in the finer cells. For 2n x 2n particles in four cells that
!> become one it is the nearest field, and the original one if the cell was divided before. The weights of the particles in the fit
!> keep momentum: they integrate the function exactly in coarse and finer cells. State variables are fitted too, so that stress
!> jumps only with strain; those of one sign in the cell keep it, as the equivalent plastic strain.
module hampm_quadratic_children
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_forest, only: corner_offset
   use hampm_lapack, only: dposv
   use hampm_problem, only: problem_t
   use hampm_place_table, only: place_table_t
   use hampm_quadratic_points, only: weights_along
   implicit none
   private
   public :: values_of_children, values_of_parents, give_to_children, give_to_parents

   integer, parameter :: n_fields = 2*ndim + ndim**2  !! u, v and H; behind them is the state variables of particles
   integer, parameter :: terms = 3                    !! of a quadratic function of one coordinate

contains

   !> Values of the children of the marked particles, (values, corners, marked). Children of particles that do not fill a cell (in
   !> no divided cell) have linear extrapolations.
   function values_of_children(m, marked) result(values)
      type(problem_t), intent(in) :: m
      logical, intent(in) :: marked(:)                   !! (particles)
      real(dp), allocatable :: values(:, :, :)
      logical :: fill(count(marked))
      values = values_by_cells(m, marked, 0, fill)
   end function values_of_children

   !> Values of the parents of the marked particles, (values, 1, marked). Particles that do not fill the parents' cell yet, as
   !> others have to recombine before, are unmarked.
   subroutine values_of_parents(m, marked, values)
      type(problem_t), intent(in) :: m
      logical, intent(inout) :: marked(:)                !! (particles)
      real(dp), allocatable, intent(out) :: values(:, :, :)
      logical :: fill(count(marked))
      integer :: k
      values = values_by_cells(m, marked, 1, fill)
      values = values(:, :, pack([(k, k=1, size(fill))], fill))
      marked = unpack(fill, marked, .false.)
   end subroutine values_of_parents

   !> The values of the children of the marked particles, or of their parents, by the function that fits them best in each cell.
   function values_by_cells(m, marked, levels, fill) result(values)
      type(problem_t), intent(in) :: m
      logical, intent(in) :: marked(:)                   !! (particles)
      integer, intent(in) :: levels                      !! levels by which cells are coarser than the particles' own: 0 or 1
      logical, intent(out) :: fill(:)                    !! whether each is one of as many as fill its cell, (marked)
      real(dp), allocatable :: values(:, :, :)           !! (values, corners or 1, marked)
      type(place_table_t) :: cells
      integer, allocatable :: cell_of(:), particle(:), last(:), place(:)
      integer :: i, k, cell, status
      particle = pack([(i, i=1, m%particles%n)], marked)
      allocate (values(n_fields + m%particles%columns(), merge(corners, 1, levels == 0), size(particle)), cell_of(size(particle)), &
                place(size(particle)))
      call cells%reserve(size(particle), status)
      do k = 1, size(particle)
         call cells%enter(place_of_cell(m, particle(k), levels), cell_of(k))
      end do
      allocate (last(0:cells%n), source=0)               ! places of the particles of each cell, one cell after the other
      do k = 1, size(particle)
         last(cell_of(k)) = last(cell_of(k)) + 1
      end do
      do cell = 1, cells%n
         last(cell) = last(cell - 1) + last(cell)
      end do
      do k = size(particle), 1, -1
         place(last(cell_of(k))) = k
         last(cell_of(k)) = last(cell_of(k)) - 1
      end do
      do cell = 1, cells%n
         associate (first => last(cell) + 1, end => merge(last(min(cell + 1, cells%n)), size(particle), cell < cells%n))
            values(:, :, place(first:end)) = values_in_cell(m, particle(place(first:end)), levels)
            fill(place(first:end)) = end - first + 1 == ((1 + levels)*points_along(m, particle(place(first))))**2
         end associate
      end do
   end function values_by_cells

   !> Cell of the size that fits a particle, or coarser by some levels: its level and place in a lattice of such cells, as numbers.
   pure function place_of_cell(m, i, levels) result(place)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i, levels
      integer(long) :: place(ndim)
      associate (p => m%particles)
         place = floor((p%reference(i, :) - m%grid%forest%lower)/size_of_cell(m, i, levels), long)
         place(1) = 32*place(1) + p%level(i)
      end associate
   end function place_of_cell

   !> Size of that cell [m].
   pure real(dp) function size_of_cell(m, i, levels)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i, levels
      size_of_cell = scale(m%grid%forest%cell, levels - m%particles%level(i))
   end function size_of_cell

   !> How many particles as one stand along a cell that fits them.
   pure integer function points_along(m, i)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i
      points_along = nint(m%grid%forest%cell/m%particles%spacing(1, m%particles%body(i)))
   end function points_along

   !> The values of the children of the particles of a cell, (values, corners, members), or of their parents, (values, 1, members).
   function values_in_cell(m, members, levels) result(values)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: members(:)
      integer, intent(in) :: levels                      !! levels by which the cell is coarser than the particles' own: 0 or 1
      real(dp) :: values(n_fields + m%particles%columns(), merge(corners, 1, levels == 0), size(members))
      real(dp), allocatable :: rows(:, :)
      real(dp) :: own(size(values, 1), size(members)), xi(ndim), size_of
      integer :: at(ndim, size(members)), to(ndim), n, k, j, c
      n = (1 + levels)*points_along(m, members(1))
      size_of = size_of_cell(m, members(1), levels)
      do k = 1, size(members)
         associate (p => m%particles, i => members(k))
            own(:n_fields, k) = [p%displacement(i, :), p%velocity(i, :), p%gradient_of(i)]
            if (p%columns() > 0) own(n_fields + 1:, k) = p%history(i, :)
            xi = (p%reference(i, :) - m%grid%forest%lower)/size_of
            at(:, k) = min(int((xi - floor(xi))*n), n - 1)
         end associate
      end do
      if (n**2 /= size(members)) then
         do k = 1, size(members)
            do c = 1, size(values, 2)
               values(:, c, k) = own(:, k)
               if (levels == 0) values(:ndim, c, k) = own(:ndim, k) + matmul(m%particles%gradient_of(members(k)), &
                                                                             (corner_offset(c) - 0.5_dp)*size_of/(2*n))
            end do
         end do
         return
      end if
      rows = rows_of_fit(n, levels)
      values = 0
      do k = 1, size(members)
         do c = 1, size(values, 2)
            to = merge(2*at(:, k) + corner_offset(c), at(:, k)/2, levels == 0) + 1
            do j = 1, size(members)
               values(:, c, k) = values(:, c, k) + rows(to(1), at(1, j) + 1)*rows(to(2), at(2, j) + 1)*own(:, j)
            end do
         end do
      end do
      do j = n_fields + 1, size(values, 1)
         if (all(own(j, :) >= 0)) values(j, :, :) = max(values(j, :, :), 0.0_dp)
         if (all(own(j, :) <= 0)) values(j, :, :) = min(values(j, :, :), 0.0_dp)
      end do
   end function values_in_cell

   !> Values at 2n even places along a line, or at n/2, as sums of values at n even places: by the quadratic function of best fit,
   !> with the weights of the points of one cell or of two.
   function rows_of_fit(n, levels) result(rows)
      integer, intent(in) :: n
      integer, intent(in) :: levels                      !! 0: at 2n places, 1: at n/2
      real(dp), allocatable :: rows(:, :)
      real(dp) :: at(n, terms), normal(terms, terms), fitted(terms, n), w(n)
      integer :: k, info
      w = [(weights_along(n/(1 + levels)), k=0, levels)]
      do k = 1, n
         at(k, :) = powers((k - 0.5_dp)/n)
      end do
      fitted = transpose(at)*spread(w, 1, terms)
      normal = matmul(fitted, at)
      call dposv('L', terms, n, normal, terms, fitted, terms, info)
      allocate (rows(merge(2*n, n/2, levels == 0), n))
      do k = 1, size(rows, 1)
         rows(k, :) = matmul(powers((k - 0.5_dp)/size(rows, 1)), fitted)
      end do
   end function rows_of_fit

   !> The terms of a quadratic function.
   pure function powers(x)
      real(dp), intent(in) :: x                          !! from 0 to 1
      real(dp) :: powers(terms)
      powers = [1.0_dp, x - 0.5_dp, (x - 0.5_dp)**2]
   end function powers

   !> Give particles that four have become the values of the parents.
   subroutine give_to_parents(values, marked, level, new_number, m)
      real(dp), intent(in) :: values(:, :, :)            !! (values, 1, marked)
      logical, intent(in) :: marked(:)                   !! the particles that might recombine
      integer, intent(in) :: level(:)                    !! of each then
      integer, intent(in) :: new_number(:)               !! see `recombine`
      type(problem_t), intent(inout) :: m
      integer :: i, k
      k = 0
      do i = 1, size(marked)
         if (.not. marked(i)) cycle
         k = k + 1
         if (m%particles%level(new_number(i)) < level(i)) call take_values(m, new_number(i), values(:, 1, k))
      end do
   end subroutine give_to_parents

   !> Give these values to the children.
   subroutine give_to_children(values, marked, first_child, m)
      real(dp), intent(in) :: values(:, :, :)            !! (values, corners, marked)
      logical, intent(in) :: marked(:)                   !! the particles that were split
      integer, intent(in) :: first_child(:)              !! see `split`
      type(problem_t), intent(inout) :: m
      integer :: i, k, c
      k = 0
      do i = 1, size(marked)
         if (.not. marked(i)) cycle
         k = k + 1
         do c = 1, corners
            call take_values(m, first_child(i) + c - 1, values(:, c, k))
         end do
      end do
   end subroutine give_to_children

   !> Give a particle values.
   subroutine take_values(m, i, values)
      type(problem_t), intent(inout) :: m
      integer, intent(in) :: i                           !! particle
      real(dp), intent(in) :: values(:)                  !! as `values_in_cell`
      associate (p => m%particles)
         if (allocated(p%widening)) p%widening(i) = p%widening(i) + values(1) - p%displacement(i, 1)
         p%displacement(i, :) = values(:ndim)
         p%velocity(i, :) = values(ndim + 1:2*ndim)
         p%gradient(i, :, :) = reshape(values(2*ndim + 1:n_fields), [ndim, ndim])
         if (allocated(p%history)) p%history(i, :) = values(n_fields + 1:)
      end associate
   end subroutine take_values
end module hampm_quadratic_children
