!> The nodal equations M x = b, with the mass matrix and the way of solution that a run asks for:
!>
!>   lumped   x = D^-1 b, D the lumped matrix (9);
!>   fmpm     the first `order` terms of the series sum_j (I - D^-1 M)^j D^-1 b (Nairn & Hammerquist 2021);
!>   cg       conjugate gradients preconditioned by D;
!>   umfpack, banded   conjugate gradients preconditioned by a factorisation: one iterate while the matrix is the
!>            factorised one; when it has changed so much that more than a few are needed, it is factorised anew.
!>
!> Iteration ends with x + D^-1 (b - M x): the sum of M x is then the sum of b to rounding, so that momentum is exact,
!> whatever the tolerance is.
!>
!> Held components are eliminated: their unknowns are zero and their equations are left out.
module hampm_mass_solver
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_constraints, only: constraints_t, hold
   use hampm_direct, only: direct_t
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: mass_matrix_t, region_t, multiply_cells, gather_slots, nodes_per_block
   use hampm_text, only: to_text
   implicit none
   private
   public :: mass_solver_t, new_mass_solver, solve_mass, by_lumped, by_fmpm, by_cg, by_umfpack, by_banded

   integer, parameter :: by_lumped = 1, by_fmpm = 2, by_cg = 3, by_umfpack = 4, by_banded = 5

   real(dp), parameter :: tolerance = 1.0e-12_dp    !! of the residual over the right-hand side, in the norm of D^-1
   integer, parameter :: most_iterations = 1000
   integer, parameter :: patience = 6               !! iterations after which a factorisation is made anew

   type :: mass_solver_t
      integer :: by = by_lumped
      integer :: order = 1                          !! of fmpm
      type(constraints_t), private :: constraints   !! which components are held
      type(direct_t) :: direct
      integer(long) :: solutions = 0                !! so far
      integer(long) :: iterations = 0               !! of all solutions
      logical, private :: factorised = .false.
      integer, private :: layout = 0                !! that of the matrix that was solved last
      real(dp), allocatable, private :: r(:, :), z(:, :), d(:, :), q(:, :)  !! workspace, (ndim, n_nodes)
      real(dp), allocatable, private :: product(:, :)     !! workspace by slot, (ndim, 0:corners*n_elements)
      real(dp), allocatable, private :: partial(:, :)     !! workspace of sums, (ndim, blocks)
   contains
      procedure :: iterates
   end type mass_solver_t

contains

   !> A solver for a grid. Fails where the memory does not suffice.
   subroutine new_mass_solver(by, order, grid, constraints, s, failure)
      integer, intent(in) :: by                     !! `by_lumped`, ...
      integer, intent(in) :: order                  !! of fmpm
      type(grid_t), intent(in) :: grid
      type(constraints_t), intent(in) :: constraints
      type(mass_solver_t), intent(out) :: s
      type(failure_t), intent(inout) :: failure
      integer :: status
      s%by = by
      s%order = order
      s%direct%by_umfpack = by == by_umfpack
      s%constraints = constraints
      if (.not. allocated(s%constraints%fixed)) allocate (s%constraints%fixed(ndim, grid%n_nodes), source=.false.)
      if (by == by_lumped) return
      associate (n => grid%n_nodes)
         allocate (s%r(ndim, n), s%z(ndim, n), s%d(ndim, n), s%q(ndim, n), s%product(ndim, 0:corners*grid%n_elements), &
                   s%partial(ndim, n/nodes_per_block + 1), stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'mass matrix: not enough memory for this number of nodes')
         return
      end if
      s%product = 0
      s%d = 0
      s%z = 0
   end subroutine new_mass_solver

   !> Whether a guess helps.
   pure logical function iterates(self)
      class(mass_solver_t), intent(in) :: self
      iterates = self%by /= by_lumped .and. self%by /= by_fmpm
   end function iterates

   !> Solve M x = b at the nodes of the matrix. On entry `x` holds a guess, from which cg and the direct solvers start. Fails
   !> where the iteration does not converge or the factorisation does not exist.
   subroutine solve_mass(s, grid, matrix, b, x, failure)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)   !! (ndim, n_nodes)
      real(dp), intent(inout), contiguous :: x(:, :)  !! (ndim, n_nodes)
      type(failure_t), intent(inout) :: failure
      if (s%layout /= matrix%layout .and. s%by /= by_lumped) then
         s%product = 0                              ! cells that have lost their last particle have no products
         s%layout = matrix%layout
         if (s%factorised) s%factorised = s%direct%fits(matrix)
      end if
      select case (s%by)
      case (by_lumped)
         call divide(matrix%all, matrix, b, x)
         call hold(s%constraints, x)
      case (by_fmpm)
         call add_series(s, grid, matrix, b, x)
      case default
         if (matrix%coupled%n_nodes < matrix%all%n_nodes) call solve_lumped_part(s, matrix, b, x)
         if (matrix%coupled%n_nodes > 0) call iterate(s, grid, matrix%coupled, matrix, b, x, failure)
      end select
   end subroutine solve_mass

   !> x = D^-1 b at the nodes that only lumped cells touch; the guess elsewhere stays.
   subroutine solve_lumped_part(s, matrix, b, x)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      call copy(matrix%coupled, x, s%z)
      call divide(matrix%all, matrix, b, x)
      call hold(s%constraints, x)
      call copy(matrix%coupled, s%z, x)
   end subroutine solve_lumped_part

   !> x = sum_{j < order} (I - D^-1 M)^j D^-1 b.
   subroutine add_series(s, grid, matrix, b, x)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      real(dp) :: unused(ndim)
      integer :: j
      call divide(matrix%all, matrix, b, x)
      call hold(s%constraints, x)
      if (s%order > 1) call copy(matrix%all, x, s%d)
      do j = 2, s%order
         call multiply(s, grid, matrix%all, matrix, s%d, s%q, unused)
         call add_term(matrix%all, matrix, s%q, s%d, x)
      end do
   end subroutine add_series

   !> Preconditioned conjugate gradients, each component by itself (Saad 2003, algorithm 9.1).
   subroutine iterate(s, grid, region, matrix, b, x, failure)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(region_t), intent(in) :: region
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      type(failure_t), intent(inout) :: failure
      real(dp), dimension(ndim) :: norm, rz, rz_new, target
      integer :: k
      if (s%by /= by_cg .and. .not. s%factorised) then
         call s%direct%factorise(grid, matrix, s%constraints%fixed, failure)
         if (failure%failed()) return
         s%factorised = .true.
      end if
      call hold(s%constraints, x)
      call start_residual(s, grid, region, matrix, b, x, norm, target)
      rz = 0                                        ! the first direction is z
      do k = 0, most_iterations
         if (all(norm <= target) .or. .not. all(norm <= huge(norm))) exit
         rz_new = norm
         if (s%by /= by_cg) then
            call s%direct%solve(s%r, s%z)
            rz_new = dot(s, region, s%r, s%z)
         end if
         call combine(region, [1.0_dp, 1.0_dp], s%z, ratio(rz_new, rz), s%d)
         call multiply(s, grid, region, matrix, s%d, s%q, rz)
         call step_along(s, region, matrix, ratio(rz_new, rz), x, norm)
         rz = rz_new
      end do
      call combine(region, [1.0_dp, 1.0_dp], s%z, [1.0_dp, 1.0_dp], x)    ! now the sum of M x is that of b, see above
      s%solutions = s%solutions + 1
      s%iterations = s%iterations + k
      if (.not. all(norm <= target)) call report_divergence(min(k, most_iterations), norm, target, failure)
      if (k > patience) s%factorised = .false.
   end subroutine iterate

   !> Fail because the iteration does not come to an end, telling how far it came.
   subroutine report_divergence(iterations, norm, target, failure)
      integer, intent(in) :: iterations
      real(dp), intent(in) :: norm(ndim), target(ndim)  !! squares, as of `start_residual`
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: found
      found = 'momenta or forces of the nodes are too large or no longer numbers'
      if (all(norm <= huge(norm)) .and. all(target > 0)) &
         found = 'the residual is still '//to_text(tolerance*sqrt(maxval(norm/target)))//' of the right-hand side'
      call failure%report(exit_computation, 'mass matrix: the nodal equations are not solved after '//to_text(iterations)// &
                          ' iterations: '//found//'. Likely cause: the run is unstable; reduce &method courant')
   end subroutine report_divergence

   !> r = b - M x without held components, z = D^-1 r, the square of the norm of r, r.z, and that which is small enough.
   subroutine start_residual(s, grid, region, matrix, b, x, norm, target)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(region_t), intent(in) :: region
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :), x(:, :)
      real(dp), intent(out) :: norm(ndim), target(ndim)
      call copy(region, b, s%r)
      call hold(s%constraints, s%r)
      call divide(region, matrix, s%r, s%z)
      target = tolerance**2*dot(s, region, s%r, s%z)
      call multiply(s, grid, region, matrix, x, s%q, norm)
      call combine(region, [-1.0_dp, -1.0_dp], s%q, [1.0_dp, 1.0_dp], s%r)
      call divide(region, matrix, s%r, s%z)
      norm = dot(s, region, s%r, s%z)
   end subroutine start_residual

   !> y = M x without held components, and x.y.
   subroutine multiply(s, grid, region, matrix, x, y, xy)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(region_t), intent(in) :: region
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: x(:, :)
      real(dp), intent(inout), contiguous :: y(:, :)
      real(dp), intent(out) :: xy(ndim)
      integer :: block, first
      call multiply_cells(region%n_cells, region%cells, grid%element_nodes, matrix%cell, x, s%product(1, 1))
      !$omp parallel do schedule(static) private(first)
      do block = 1, block_count(region)
         first = (block - 1)*nodes_per_block + 1
         call gather_slots(block_size(region, block), region%nodes(first), grid%node_slot, s%product, x, y, &
                           s%partial(1, block))
      end do
      xy = sum(s%partial(:, :block_count(region)), dim=2)
      call hold(s%constraints, y)
   end subroutine multiply

   !> x <- x + step d, r <- r - step q, z = D^-1 r, and r.z.
   subroutine step_along(s, region, matrix, step, x, rz)
      type(mass_solver_t), intent(inout) :: s
      type(region_t), intent(in) :: region
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: step(ndim)
      real(dp), intent(inout), contiguous :: x(:, :)
      real(dp), intent(out) :: rz(ndim)
      integer :: block, first
      !$omp parallel do schedule(static) private(first)
      do block = 1, block_count(region)
         first = (block - 1)*nodes_per_block + 1
         call step_nodes(block_size(region, block), region%nodes(first), step, matrix%lumped, s%d, s%q, x, s%r, s%z, &
                         s%partial(1, block))
      end do
      rz = sum(s%partial(:, :block_count(region)), dim=2)
   end subroutine step_along

   !> `step_along` at some nodes.
   pure subroutine step_nodes(n, nodes, step, lumped, d, q, x, r, z, rz)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: step(ndim), lumped(*), d(ndim, *), q(ndim, *)
      real(dp), intent(inout) :: x(ndim, *), r(ndim, *), z(ndim, *)
      real(dp), intent(out) :: rz(ndim)
      real(dp) :: inverse, r_i(ndim)
      integer :: a, i
      rz = 0
      do a = 1, n
         i = nodes(a)
         inverse = 1/lumped(i)
         x(:, i) = x(:, i) + step*d(:, i)
         r_i = r(:, i) - step*q(:, i)
         r(:, i) = r_i
         z(:, i) = r_i*inverse
         rz = rz + r_i*r_i*inverse
      end do
   end subroutine step_nodes

   !> Number of blocks of nodes.
   pure integer function block_count(region)
      type(region_t), intent(in) :: region
      block_count = (region%n_nodes - 1)/nodes_per_block + 1
   end function block_count

   !> Number of nodes of a block.
   pure integer function block_size(region, block)
      type(region_t), intent(in) :: region
      integer, intent(in) :: block
      block_size = min(nodes_per_block, region%n_nodes - (block - 1)*nodes_per_block)
   end function block_size

   !> a/b by component, 0 where there is nothing left to do.
   pure function ratio(a, b)
      real(dp), intent(in) :: a(ndim), b(ndim)
      real(dp) :: ratio(ndim)
      ratio = 0
      where (b > 0) ratio = a/b
   end function ratio

   !> Sum over the nodes of x y, by component; always in the same order.
   function dot(s, region, x, y) result(total)
      type(mass_solver_t), intent(inout) :: s
      type(region_t), intent(in) :: region
      real(dp), intent(in), contiguous :: x(:, :), y(:, :)
      real(dp) :: total(ndim)
      integer :: block, first
      !$omp parallel do schedule(static) private(first)
      do block = 1, block_count(region)
         first = (block - 1)*nodes_per_block + 1
         call dot_of_nodes(block_size(region, block), region%nodes(first), x, y, s%partial(1, block))
      end do
      total = sum(s%partial(:, :block_count(region)), dim=2)
   end function dot

   !> The part of `dot` of some nodes.
   pure subroutine dot_of_nodes(n, nodes, x, y, total)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: x(ndim, *), y(ndim, *)
      real(dp), intent(out) :: total(ndim)
      integer :: a
      total = 0
      do a = 1, n
         total = total + x(:, nodes(a))*y(:, nodes(a))
      end do
   end subroutine dot_of_nodes

   !> x = D^-1 b.
   subroutine divide(region, matrix, b, x)
      type(region_t), intent(in) :: region
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: b(ndim, *)
      real(dp), intent(inout) :: x(ndim, *)
      real(dp) :: inverse
      integer :: a
      !$omp parallel do schedule(static) private(inverse)
      do a = 1, region%n_nodes
         associate (i => region%nodes(a))
            inverse = 1/matrix%lumped(i)
            x(:, i) = b(:, i)*inverse
         end associate
      end do
   end subroutine divide

   !> d <- d - D^-1 q, x <- x + d.
   subroutine add_term(region, matrix, q, d, x)
      type(region_t), intent(in) :: region
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: q(ndim, *)
      real(dp), intent(inout) :: d(ndim, *), x(ndim, *)
      real(dp) :: inverse
      integer :: a
      !$omp parallel do schedule(static) private(inverse)
      do a = 1, region%n_nodes
         associate (i => region%nodes(a))
            inverse = 1/matrix%lumped(i)
            d(:, i) = d(:, i) - q(:, i)*inverse
            x(:, i) = x(:, i) + d(:, i)
         end associate
      end do
   end subroutine add_term

   !> y <- a x + b y, by component.
   subroutine combine(region, a, x, b, y)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: a(ndim), x(ndim, *), b(ndim)
      real(dp), intent(inout) :: y(ndim, *)
      integer :: k
      !$omp parallel do schedule(static)
      do k = 1, region%n_nodes
         associate (i => region%nodes(k))
            y(:, i) = a*x(:, i) + b*y(:, i)
         end associate
      end do
   end subroutine combine

   !> y = x.
   subroutine copy(region, x, y)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: x(ndim, *)
      real(dp), intent(inout) :: y(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      do a = 1, region%n_nodes
         y(:, region%nodes(a)) = x(:, region%nodes(a))
      end do
   end subroutine copy
end module hampm_mass_solver
