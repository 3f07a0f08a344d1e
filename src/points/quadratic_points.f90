!> Volumes of the particles of quadratic cells, as weights of a quadrature (docs/explanation/quadratic.md): those nearest to equal
!> ones that integrate a cubic exactly in a whole cell, of n points in each direction
!>
!>    w_k = (1 + c (q_k - mean q))/n,   q_k = (x_k - 1/2)**2,   c such that sum w q = 1/12.
!>
!> In cells that are cut or hold halves of particles, M w = m for each piece, with polynomials at the particles in M and their
!> moments in m (`hampm_piece_moments`), so that the sum of (w - w_0)**2 is least and no weight is below a part of the mean. The
!> residual of the integrals of shape function gradients is removed as a constant in each piece: uniform stress is in balance.
!>
!> Sources: Mueller, Kummer & Oberlack, Int. J. Numer. Meth. Engng 96 (2013) 512-528 (moment fitting); Chen, Hillman & Rueter, the
!> same 95 (2013) 387-418 (variationally consistent integration).
module hampm_quadratic_points
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: quadratic_functions, quadratic_gradients
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_grid, only: grid_t
   use hampm_matter, only: matter_t
   use hampm_piece_moments, only: moments_of_pieces, integrals_of_gradients, integrals_in_ring, polynomials_at, n_polynomials
   use hampm_tensors, only: norm, identity
   implicit none
   private
   public :: weights_along, weigh_points, correct_points, fewest_points

   integer, parameter :: exact(4) = [13, 8, 3, 1] !! how many polynomials are tried to be integrated exactly
   real(dp), parameter :: least = 0.1_dp         !! weight, over the mean of the weights
   real(dp), parameter :: close = 1e-9_dp        !! residual of the polynomials, over the area, and at the particles for
                                                 !! linearly dependent ones

   integer, parameter :: fewest_points = 3       !! in a cell and direction

contains

   !> Weights of n points on a line of length 1 [-]; of fewer than three they are equal.
   pure function weights_along(n) result(w)
      integer, intent(in) :: n
      real(dp) :: w(n)
      real(dp) :: q(n), mean
      integer :: k
      w = 1/real(n, dp)
      if (n < fewest_points) return
      q = [(((k - 0.5_dp)/n - 0.5_dp)**2, k=1, n)]
      mean = sum(q)/n
      w = (1 + (1/12.0_dp - mean)*n/sum((q - mean)*q)*(q - mean))/n
   end function weights_along

   !> Set volumes and masses of the particles of quadratic cells, in which they are sorted; in cells that are cut, or hold halves of
   !> particles, by their moments. Other cells that are not full, as some are while particles go to finer ones, stay as they are.
   subroutine weigh_points(m, fills)
      type(matter_t), intent(inout) :: m
      logical, intent(out), optional :: fills(:) !! by particle: whether it is of a lattice that fills its cell
      real(dp) :: x(ndim), xi(ndim)
      real(dp), allocatable :: w(:)
      integer :: leaf, e, i, n
      if (present(fills)) fills = .false.
      do leaf = 1, m%grid%forest%leaf_count()
         associate (first => m%grid%leaf_element(leaf), last => m%grid%leaf_element(leaf + 1) - 1)
            if (has_own_weights(m, leaf)) then
               call weigh_pieces(m, leaf)
               cycle
            end if
            n = nint(sqrt(real(sum(m%blocks%count_in(first:last)), dp)))
            if (n < fewest_points .or. n**2 /= sum(m%blocks%count_in(first:last))) cycle
            w = weights_along(n)
            do e = first, last
               do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
                  x = m%particles%reference(i, :)
                  xi = m%grid%in_leaf(e, m%grid%local_coordinate(e, x))
                  call give_area(m, i, m%grid%forest%size_of(leaf)**ndim*product(w(min(int(xi*n) + 1, n))))
                  if (present(fills)) fills(i) = .true.
               end do
            end do
         end associate
      end do
      call correct_points(m)
   end subroutine weigh_points

   !> Find the corrections of gradients in cells that are cut, for particles with the volumes that they have.
   subroutine correct_points(m)
      type(matter_t), intent(inout) :: m
      integer, allocatable :: bodies(:)
      real(dp), allocatable :: moments(:, :)
      integer :: leaf, piece, k
      if (allocated(m%grid%correction)) deallocate (m%grid%correction)
      do leaf = 1, m%grid%forest%leaf_count()
         if (.not. has_own_weights(m, leaf)) cycle
         if (.not. allocated(m%grid%correction)) &
            allocate (m%grid%correction(m%grid%n_functions, ndim, m%grid%n_elements/corners), source=0.0_dp)
         if (allocated(bodies)) deallocate (bodies)
         allocate (bodies, source=bodies_in(m, leaf))
         if (size(bodies) == 0) cycle
         allocate (moments, source=moments_of_body(m%grid, leaf, bodies(1)))
         do k = 2, size(bodies)
            moments = moments + moments_of_body(m%grid, leaf, bodies(k))
         end do
         do piece = 1, size(moments, 2)
            call correct_gradients(m, m%grid%leaf_element(leaf) + corners*(piece - 1), moments(:, piece))
         end do
         deallocate (moments)
      end do
   end subroutine correct_points

   !> Whether the particles of a leaf are no lattice that fills it: it is cut, or has halves left by a crack through coarser cells
   !> ahead of its tip.
   pure logical function has_own_weights(m, leaf)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: leaf
      has_own_weights = m%grid%is_cut(leaf)
      if (has_own_weights .or. .not. allocated(m%particles%half)) return
      associate (number => particles_in(m%blocks, m%grid%leaf_element(leaf), m%grid%leaf_element(leaf + 1) - 1))
         has_own_weights = any(abs(m%particles%half(number, :)) > 0)
      end associate
   end function has_own_weights

   !> The bodies that have particles in a leaf; where no outlines are known the first stands for all.
   pure function bodies_in(m, leaf) result(bodies)
      type(matter_t), intent(in) :: m
      integer, intent(in) :: leaf
      integer, allocatable :: bodies(:)
      integer :: k
      associate (number => particles_in(m%blocks, m%grid%leaf_element(leaf), m%grid%leaf_element(leaf + 1) - 1))
         bodies = [(k, k=1, merge(1, 0, size(number) > 0))]
         if (allocated(m%grid%bodies)) &
            bodies = pack([(k, k=1, size(m%grid%bodies))], [(any(m%particles%body(number) == k), k=1, size(m%grid%bodies))])
      end associate
   end function bodies_in

   !> The moments of a body in each piece of a leaf; without outlines of the whole pieces.
   pure function moments_of_body(grid, leaf, body) result(moments)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: leaf, body
      real(dp), allocatable :: moments(:, :)
      if (allocated(grid%bodies)) then
         moments = moments_of_pieces(grid%cut_cells, grid%forest, leaf, grid%bodies(body))
      else
         moments = moments_of_pieces(grid%cut_cells, grid%forest, leaf)
      end if
   end function moments_of_body

   !> The same in the pieces of a leaf that is cut by a crack or the edge of a body.
   subroutine weigh_pieces(m, leaf)
      type(matter_t), intent(inout) :: m
      integer, intent(in) :: leaf
      integer, allocatable :: bodies(:)
      integer :: k
      allocate (bodies, source=bodies_in(m, leaf))
      do k = 1, size(bodies)
         call fit_pieces(m, leaf, moments_of_body(m%grid, leaf, bodies(k)), bodies(k))
      end do
   end subroutine weigh_pieces

   !> Find the correction of gradients in a piece.
   subroutine correct_gradients(m, first, moments)
      type(matter_t), intent(inout) :: m
      integer, intent(in) :: first               !! element of the piece
      real(dp), intent(in) :: moments(:)         !! of the material in it
      real(dp) :: missing(m%grid%n_functions, ndim), volume, x(ndim)
      integer, allocatable :: number(:)
      integer :: k
      allocate (number, source=particles_in(m%blocks, first, first + corners - 1))
      if (size(number) == 0) return
      volume = sum(m%particles%volume(number))
      associate (lower => m%grid%element_lower(:, first), edge => m%grid%leaf_size(first))
         if (m%particles%thickness%is_ring) then
            x = identity(:, 1)
            missing = integrals_in_ring(moments, lower(1), edge)*edge*m%particles%thickness%at(x)
         else
            missing = integrals_of_gradients(moments)*edge**(ndim - 1)*m%particles%thickness%of_plate
         end if
         do k = 1, size(number)
            x = (m%particles%reference(number(k), :) - lower)/edge
            missing = missing - m%particles%volume(number(k))*quadratic_gradients(x, 1/edge)
            if (m%particles%thickness%is_ring) &
               missing(:, 1) = missing(:, 1) - m%particles%volume(number(k))*quadratic_functions(x) &
                  /m%particles%reference(number(k), 1)
         end do
      end associate
      m%grid%correction(:, :, (first - 1)/corners + 1) = missing/volume
   end subroutine correct_gradients

   !> Fit the volumes of the particles of a body, of all without known outlines, to the moments of the pieces of a leaf. The mass of
   !> pieces without particles passes to the others.
   subroutine fit_pieces(m, leaf, moments, body)
      type(matter_t), intent(inout) :: m
      integer, intent(in) :: leaf
      real(dp), intent(in) :: moments(:, :)      !! (polynomials, pieces)
      integer, intent(in) :: body
      real(dp), allocatable :: at_points(:, :)
      integer, allocatable :: number(:), all(:)
      real(dp) :: held                           ! area of the pieces with particles, over that of the leaf [-]
      integer :: piece, k
      allocate (all(0))
      held = 0
      do piece = 1, size(moments, 2)
         associate (first => m%grid%leaf_element(leaf) + corners*(piece - 1))
            number = particles_in(m%blocks, first, first + corners - 1)
            if (allocated(m%grid%bodies)) number = pack(number, m%particles%body(number) == body)
            if (size(number) == 0 .or. .not. moments(1, piece) > 0) cycle
            allocate (at_points(n_polynomials, size(number)))
            associate (edge => m%grid%forest%size_of(leaf), lower => m%grid%element_lower(:, first))
               do k = 1, size(number)
                  at_points(:, k) = polynomials_at((m%particles%reference(number(k), :) - lower)/edge)
               end do
               associate (w => fitted_weights(at_points, moments(:, piece)))
                  do k = 1, size(number)
                     call give_area(m, number(k), w(k)*edge**ndim)
                  end do
               end associate
            end associate
            deallocate (at_points)
            all = [all, number]
            held = held + moments(1, piece)
         end associate
      end do
      if (held > 0) m%particles%mass(all) = m%particles%mass(all)*sum(max(moments(1, :), 0.0_dp))/held
   end subroutine fit_pieces

   !> The particles in some elements.
   pure function particles_in(blocks, first, last) result(number)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: first, last         !! element
      integer, allocatable :: number(:)
      integer :: e, i
      number = [((i, i=blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)), e=first, last)]
   end function particles_in

   !> Give a particle an area in the plane [m2], and the volume and mass that go with it.
   subroutine give_area(m, i, area)
      type(matter_t), intent(inout) :: m
      integer, intent(in) :: i
      real(dp), intent(in) :: area
      real(dp) :: x(ndim)
      x = m%particles%reference(i, :)
      m%particles%volume(i) = area*m%particles%thickness%at(x)
      m%particles%mass(i) = m%materials(m%particles%material(i))%density*m%particles%volume(i)
   end subroutine give_area

   !> The weights of some points.
   pure function fitted_weights(at_points, moments) result(w)
      real(dp), intent(in) :: at_points(:, :)    !! polynomials at the points, (polynomials, points)
      real(dp), intent(in) :: moments(:)         !! their integrals; the first, of 1, is above 0
      real(dp) :: w(size(at_points, 2))
      logical :: found
      integer :: k
      w = moments(1)/size(w)
      do k = 1, size(exact)
         call fit(exact(k), at_points, moments, w, found)
         if (found) return
      end do
   end function fitted_weights

   !> Weights that integrate so many polynomials exactly, if there are.
   pure subroutine fit(n, at_points, moments, w, found)
      integer, intent(in) :: n
      real(dp), intent(in) :: at_points(:, :), moments(:)
      real(dp), intent(inout) :: w(:)
      logical, intent(out) :: found
      real(dp) :: trial(size(w)), equal
      logical :: is_free(size(w))
      integer :: turn
      found = .false.
      equal = moments(1)/size(w)
      trial = equal
      is_free = .true.
      do turn = 1, size(w)
         trial = trial + least_change(at_points(:n, :), moments(:n) - matmul(at_points(:n, :), trial), is_free)
         if (maxval(abs(matmul(at_points(:n, :), trial) - moments(:n))) > close*moments(1)) return
         if (all(trial >= least*equal .or. .not. is_free)) then
            w = trial
            found = .true.
            return
         end if
         where (is_free .and. trial < least*equal)
            is_free = .false.
            trial = least*equal
         end where
      end do
   end subroutine fit

   !> Least change of the weights of some points for a change of the integrals of the polynomials, by orthogonal sums of these (Gram
   !> & Schmidt).
   pure function least_change(at_points, missing, is_free) result(change)
      real(dp), intent(in) :: at_points(:, :)    !! polynomials at the points, (polynomials, points)
      real(dp), intent(in) :: missing(:)         !! of their integrals
      logical, intent(in) :: is_free(:)          !! whether the weight of each point may change
      real(dp) :: change(size(is_free))
      real(dp) :: basis(size(is_free), size(missing)), row(size(is_free))
      integer :: n, j, k, turn
      change = 0
      n = 0
      do j = 1, size(missing)
         row = merge(at_points(j, :), 0.0_dp, is_free)
         do turn = 1, 2                          ! the second pass removes rounding
            do k = 1, n
               row = row - dot_product(row, basis(:, k))*basis(:, k)
            end do
         end do
         if (norm(row) <= close*sqrt(real(size(is_free), dp))) cycle
         n = n + 1
         basis(:, n) = row/norm(row)
         change = change + (missing(j) - dot_product(at_points(j, :), change))/norm(row)*basis(:, n)
      end do
   end function least_change
end module hampm_quadratic_points
