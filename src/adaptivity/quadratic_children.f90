!> What particles carry into the finer cells of a quadratic cell that is divided.
!>
!> Displacement, its gradient and velocity of the n x n particles of a quadratic cell are biquadratic there, each component: in the total
!> frame they follow the nodes of their cell from the start. So the biquadratic function that fits them best, which is the one through
!> them where n = 3, is that field, and its values at the children's places are again those of one field, which the finer cells
!> represent. Momentum stays, as the weights of the particles integrate it exactly in the coarse cell and in the finer ones. What particles
!> remember goes the same way, so that stress does not jump where strain does not; of it what has one sign in the cell keeps it, as the
!> equivalent plastic strain does.
module hampm_quadratic_children
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_forest, only: corner_offset
   use hampm_lapack, only: dposv
   use hampm_motion, only: motion_t
   use hampm_place_table, only: place_table_t
   use hampm_quadratic_points, only: fewest_points
   implicit none
   private
   public :: values_of_children, give_to_children

   integer, parameter :: n_fields = 2*ndim + ndim**2  !! u, v and H; behind them is what particles remember
   integer, parameter :: terms = 3                    !! of a quadratic function of one coordinate

contains

   !> The values of the children of the marked particles, (values, corners, marked). Of particles that do not fill a cell, as none are
   !> whose cells are divided, the children have what extrapolates them linearly.
   function values_of_children(m, marked) result(values)
      type(motion_t), intent(in) :: m
      logical, intent(in) :: marked(:)                   !! (particles)
      real(dp), allocatable :: values(:, :, :)
      type(place_table_t) :: cells
      integer, allocatable :: cell_of(:), particle(:), last(:), place(:)
      integer :: i, k, cell, status
      particle = pack([(i, i=1, m%particles%n)], marked)
      allocate (values(n_fields + m%particles%columns(), corners, size(particle)), cell_of(size(particle)), place(size(particle)))
      call cells%reserve(size(particle), status)
      do k = 1, size(particle)
         call cells%enter(place_of_cell(m, particle(k)), cell_of(k))
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
            values(:, :, place(first:end)) = children_in_cell(m, particle(place(first:end)))
         end associate
      end do
   end function values_of_children

   !> The cell of the size that fits a particle, by its level and its place in a lattice of such cells, as numbers.
   pure function place_of_cell(m, i) result(place)
      type(motion_t), intent(in) :: m
      integer, intent(in) :: i
      integer(long) :: place(ndim)
      associate (p => m%particles)
         place = floor((p%reference(i, :) - m%grid%forest%lower)/size_of_cell(m, i), long)
         place(1) = 32*place(1) + p%level(i)
      end associate
   end function place_of_cell

   !> Size of that cell [m].
   pure real(dp) function size_of_cell(m, i)
      type(motion_t), intent(in) :: m
      integer, intent(in) :: i
      size_of_cell = scale(m%grid%forest%cell, -m%particles%level(i))
   end function size_of_cell

   !> The values of the children of the particles of a cell, (values, corners, members).
   function children_in_cell(m, members) result(values)
      type(motion_t), intent(in) :: m
      integer, intent(in) :: members(:)
      real(dp) :: values(n_fields + m%particles%columns(), corners, size(members))
      real(dp) :: rows(2*nint(sqrt(real(size(members), dp))), nint(sqrt(real(size(members), dp))))
      real(dp) :: own(size(values, 1), size(members)), xi(ndim), size_of
      integer :: at(ndim, size(members)), child(ndim), n, k, j, c
      n = size(rows, 2)
      size_of = size_of_cell(m, members(1))
      do k = 1, size(members)
         associate (p => m%particles, i => members(k))
            own(:, k) = [p%displacement(i, :), p%velocity(i, :), reshape(p%gradient_of(i), [ndim**2]), p%history_of(i)]
            xi = (p%reference(i, :) - m%grid%forest%lower)/size_of
            at(:, k) = min(int((xi - floor(xi))*n), n - 1)
         end associate
      end do
      if (n < fewest_points .or. n**2 /= size(members)) then
         do k = 1, size(members)
            do c = 1, corners
               values(:, c, k) = own(:, k)
               values(:ndim, c, k) = own(:ndim, k) + matmul(m%particles%gradient_of(members(k)), &
                                                            (corner_offset(c) - 0.5_dp)*size_of/(2*n))
            end do
         end do
         return
      end if
      rows = rows_of_children(n)
      values = 0
      do k = 1, size(members)
         do c = 1, corners
            child = 2*at(:, k) + corner_offset(c) + 1
            do j = 1, size(members)
               values(:, c, k) = values(:, c, k) + rows(child(1), at(1, j) + 1)*rows(child(2), at(2, j) + 1)*own(:, j)
            end do
         end do
      end do
      do j = n_fields + 1, size(values, 1)
         if (all(own(j, :) >= 0)) values(j, :, :) = max(values(j, :, :), 0.0_dp)
         if (all(own(j, :) <= 0)) values(j, :, :) = min(values(j, :, :), 0.0_dp)
      end do
   end function children_in_cell

   !> Values at 2n even places along a line, as sums of those at n even places: by the quadratic function that fits these best.
   function rows_of_children(n) result(rows)
      integer, intent(in) :: n
      real(dp) :: rows(2*n, n)
      real(dp) :: at_parents(n, terms), normal(terms, terms), fitted(terms, n)
      integer :: k, info
      do k = 1, n
         at_parents(k, :) = powers((k - 0.5_dp)/n)
      end do
      normal = matmul(transpose(at_parents), at_parents)
      fitted = transpose(at_parents)
      call dposv('L', terms, n, normal, terms, fitted, terms, info)
      do k = 1, 2*n
         rows(k, :) = matmul(powers((k - 0.5_dp)/(2*n)), fitted)
      end do
   end function rows_of_children

   !> The terms of a quadratic function.
   pure function powers(x)
      real(dp), intent(in) :: x                          !! from 0 to 1
      real(dp) :: powers(terms)
      powers = [1.0_dp, x - 0.5_dp, (x - 0.5_dp)**2]
   end function powers

   !> Give these values to the children.
   subroutine give_to_children(values, marked, first_child, m)
      real(dp), intent(in) :: values(:, :, :)            !! (values, corners, marked)
      logical, intent(in) :: marked(:)                   !! the particles that were split
      integer, intent(in) :: first_child(:)              !! see `split`
      type(motion_t), intent(inout) :: m
      integer :: i, k, c
      k = 0
      do i = 1, size(marked)
         if (.not. marked(i)) cycle
         k = k + 1
         do c = 1, corners
            associate (p => m%particles, child => first_child(i) + c - 1)
               if (allocated(p%widening)) p%widening(child) = p%widening(child) + values(1, c, k) - p%displacement(child, 1)
               p%displacement(child, :) = values(:ndim, c, k)
               p%velocity(child, :) = values(ndim + 1:2*ndim, c, k)
               p%gradient(child, :, :) = reshape(values(2*ndim + 1:n_fields, c, k), [ndim, ndim])
               if (allocated(p%history)) p%history(child, :) = values(n_fields + 1:, c, k)
            end associate
         end do
      end do
   end subroutine give_to_children
end module hampm_quadratic_children
