!> The nodal equations M x = b, with the mass matrix and the way of solution that a run asks for:
!>
!>   lumped   x = D^-1 b, D the lumped matrix (9);
!>   fmpm     the first `order` terms of the series sum_j (I - D^-1 M)^j D^-1 b (Nairn & Hammerquist 2021);
!>   cg       conjugate gradients preconditioned by the inverses of the cells' matrices (see `precondition`);
!>   umfpack, banded   conjugate gradients preconditioned by a factorisation: one iterate while the matrix is the
!>            factorised one; when it has changed so much that more than a few are needed, it is factorised anew.
!>
!> What an iteration leaves is divided by D: the sum of M x is then the sum of b to rounding, so that momentum is exact.
!>
!> Held components are eliminated: their unknowns are zero and their equations are left out.
module hampm_mass_solver
   use hampm_kinds, only: dp, ndim, long
   use hampm_direct, only: direct_t
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: mass_matrix_t, region_t, nodes_per_block
   use hampm_nodal_rows, only: multiply_rows
   use hampm_text, only: to_text
   implicit none
   private
   public :: mass_solver_t, new_mass_solver, solve_mass, by_lumped, by_fmpm, by_cg, by_umfpack, by_banded

   integer, parameter :: by_lumped = 1, by_fmpm = 2, by_cg = 3, by_umfpack = 4, by_banded = 5

   real(dp), parameter :: tolerance = 1.0e-13_dp    !! of the residual over the right-hand side, in the norm of D^-1: the
                                                    !! particles' share of the error may be sqrt(20) times as large, and
                                                    !! the error at nodes of little mass far larger
   integer, parameter :: most_iterations = 1000
   integer, parameter :: patience = 6               !! iterations after which a factorisation is made anew

   type :: mass_solver_t
      integer :: by = by_lumped
      integer :: order = 1                          !! of fmpm
      integer, allocatable, private :: held_nodes(:)  !! nodes with a held component
      logical, allocatable, private :: held(:, :)     !! which components of these, (ndim, number of them)
      type(direct_t) :: direct
      integer(long) :: solutions = 0                !! so far
      integer(long) :: iterations = 0               !! of all solutions
      logical, private :: factorised = .false.
      integer, private :: layout = 0                !! that of the matrix that was solved last
      integer, private :: version = 0               !! that of the matrix that was solved last
      real(dp), allocatable, private :: inverse(:, :)     !! D^-1 where the matrix is coupled, 0 for held components,
                                                          !! (ndim, n_nodes)
      real(dp), allocatable, private :: r(:, :), z(:, :), d(:, :), q(:, :)  !! workspace, (ndim, n_nodes)
      real(dp), allocatable, private :: partial(:, :, :)  !! workspace of sums, (ndim, 2, blocks)
   contains
      procedure :: iterates
   end type mass_solver_t

contains

   !> A solver for a grid. `held` tells which components are zero. Fails where the memory does not suffice.
   subroutine new_mass_solver(by, order, grid, held, s, failure)
      integer, intent(in) :: by                     !! `by_lumped`, ...
      integer, intent(in) :: order                  !! of fmpm
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: held(:, :)             !! (ndim, n_nodes)
      type(mass_solver_t), intent(out) :: s
      type(failure_t), intent(inout) :: failure
      integer :: status
      s%by = by
      s%order = order
      s%direct%by_umfpack = by == by_umfpack
      s%held_nodes = pack([(status, status=1, grid%n_nodes)], any(held, dim=1))
      s%held = held(:, s%held_nodes)
      if (by == by_lumped) return
      associate (n => grid%n_nodes)
         allocate (s%inverse(ndim, n), s%r(ndim, n), s%z(ndim, n), s%d(ndim, n), s%q(ndim, n), &
                   s%partial(ndim, 2, n/nodes_per_block + 1), stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'mass matrix: not enough memory for this number of nodes')
         return
      end if
      s%r = 0
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
      if (s%by /= by_lumped .and. s%version /= matrix%version) call follow_matrix(s, matrix)
      select case (s%by)
      case (by_lumped)
         call divide(matrix%all%n_nodes, matrix%all%nodes, matrix%lumped, b, x)
         call hold(s, x)
      case (by_fmpm)
         call add_series(s, matrix, b, x)
      case default
         call divide(size(matrix%apart), matrix%apart, matrix%lumped, b, x)
         call hold(s, x)
         if (matrix%coupled%n_nodes > 0) call iterate(s, grid, matrix, b, x, failure)
      end select
   end subroutine solve_mass

   !> Prepare for a matrix that has changed.
   subroutine follow_matrix(s, matrix)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      integer :: a
      s%version = matrix%version
      !$omp parallel do schedule(static)
      do a = 1, matrix%coupled%n_nodes
         s%inverse(:, matrix%coupled%nodes(a)) = 1/matrix%lumped(matrix%coupled%nodes(a))
      end do
      call hold(s, s%inverse)
      if (s%layout /= matrix%layout .and. s%factorised) s%factorised = s%direct%fits(matrix)
      s%layout = matrix%layout
   end subroutine follow_matrix

   !> x = sum_{j < order} (I - D^-1 M)^j D^-1 b.
   subroutine add_series(s, matrix, b, x)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      real(dp) :: unused(ndim)
      integer :: j
      associate (nodes => matrix%coupled%nodes)
         call divide(size(nodes), nodes, matrix%lumped, b, x)
         call hold(s, x)
         if (s%order > 1) call copy(matrix%coupled, x, s%d)
         do j = 2, s%order
            call multiply(s, matrix, matrix%row, s%d, s%q, unused)
            call add_term(matrix%coupled, s%q, s%d, x)
         end do
      end associate
   end subroutine add_series

   !> Preconditioned conjugate gradients, each component by itself (Saad 2003, algorithm 9.1). The residual is kept divided
   !> by D: r = D^-1 (b - M x), and so is the product with the direction, q = D^-1 M d. Held components of either are 0.
   subroutine iterate(s, grid, matrix, b, x, failure)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      type(failure_t), intent(inout) :: failure
      real(dp), dimension(ndim) :: norm, rz, rz_last, dq, target
      integer :: k
      if (s%by /= by_cg .and. .not. s%factorised) call factorise(s, grid, matrix, failure)
      if (failure%failed()) return
      call start_residual(s, matrix, b, x, norm, target)
      rz_last = 0
      do k = 0, most_iterations
         if (all(norm <= target)) exit
         call precondition(s, matrix, rz)
         call add_to_direction(matrix%coupled, ratio(rz, rz_last), s%z, s%d)
         call multiply(s, matrix, matrix%row, s%d, s%q, dq)
         call step_along(s, matrix, ratio(rz, dq), x, norm)
         rz_last = rz
      end do
      call add(matrix%coupled, s%r, x)
      s%solutions = s%solutions + 1
      s%iterations = s%iterations + k
      if (k > most_iterations) call failure%report(exit_computation, 'mass matrix: conjugate gradients have not '// &
         'converged in '//to_text(most_iterations)//' iterations. Likely cause: the run is unstable; reduce &method courant')
      if (k > patience) s%factorised = .false.
   end subroutine iterate

   !> z = P^-1 D r, and z.D r. With a factorised matrix P, or of conjugate gradients
   !>
   !>    P^-1 = D^-1 (sum over cells of D_e M_e^-1 D_e) D^-1.
   !>
   !> The eigenvalues of P^-1 M are at least 1: any v is the sum of D^-1 D_e v_e, so that v.P v <= sum of v_e.M_e v_e = v.M v
   !> (the lemma of additive Schwarz methods; Toselli & Widlund 2005, section 2.2). At most they are the largest of
   !> M_e^-1 D_e. With the particles at the quarter points they lie between 1 and (25/16)**2, those of D^-1 M between 1/16
   !> and 1.
   subroutine precondition(s, matrix, rz)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(out) :: rz(ndim)
      if (s%by == by_cg) then
         call multiply(s, matrix, matrix%inverse_row, s%r, s%z, rz)
      else
         call weigh(matrix%coupled, matrix%lumped, s%r, s%q)
         call s%direct%solve(s%q, s%z)
         rz = dot(s, matrix%coupled, s%q, s%z)
      end if
   end subroutine precondition

   !> Factorise the matrix as it is now.
   subroutine factorise(s, grid, matrix, failure)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      type(failure_t), intent(inout) :: failure
      logical, allocatable :: held(:, :)
      allocate (held(ndim, grid%n_nodes), source=.false.)
      held(:, s%held_nodes) = s%held
      call s%direct%factorise(grid, matrix, held, failure)
      s%factorised = .true.
   end subroutine factorise

   !> y = D^-1 A x without held components, A being given by rows, and x.A x.
   subroutine multiply(s, matrix, row, x, y, xax)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: row(:, :)
      real(dp), intent(in), contiguous :: x(:, :)
      real(dp), intent(inout), contiguous :: y(:, :)
      real(dp), intent(out) :: xax(ndim)
      integer :: block, first
      associate (runs => matrix%runs, blocks => block_count(matrix%coupled))
         !$omp parallel do schedule(static) private(first)
         do block = 1, blocks
            first = runs%of_block(block)
            call multiply_rows(runs%of_block(block + 1) - first, runs%first(first), runs%last(first), runs%offset(1, first), &
                               row, s%inverse, x, y, s%partial(1, 1, block))
         end do
         xax = sum(s%partial(:, 1, :blocks), dim=2)
      end associate
   end subroutine multiply

   !> r = D^-1 (b - M x), the square of its norm r.D r, and that which is small enough.
   subroutine start_residual(s, matrix, b, x, norm, target)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :), x(:, :)
      real(dp), intent(out) :: norm(ndim), target(ndim)
      real(dp) :: sums(ndim, 2)
      integer :: block, first
      call multiply(s, matrix, matrix%row, x, s%q, norm)
      associate (region => matrix%coupled)
         !$omp parallel do schedule(static) private(first)
         do block = 1, block_count(region)
            first = (block - 1)*nodes_per_block + 1
            call start_nodes(block_size(region, block), region%nodes(first), matrix%lumped, s%inverse, b, s%q, s%r, &
                             s%partial(1, 1, block))
         end do
         sums = sum(s%partial(:, :, :block_count(region)), dim=3)
      end associate
      norm = sums(:, 1)
      target = tolerance**2*sums(:, 2)
   end subroutine start_residual

   !> `start_residual` at some nodes, with r.D r and b.D^-1 b.
   pure subroutine start_nodes(n, nodes, lumped, inverse, b, q, r, sums)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: lumped(*), inverse(ndim, *), b(ndim, *), q(ndim, *)
      real(dp), intent(inout) :: r(ndim, *)
      real(dp), intent(out) :: sums(ndim, 2)
      real(dp) :: x_lumped(ndim), r_i(ndim)
      integer :: a, i
      sums = 0
      do a = 1, n
         i = nodes(a)
         x_lumped = inverse(:, i)*b(:, i)
         r_i = x_lumped - q(:, i)
         r(:, i) = r_i
         sums(:, 1) = sums(:, 1) + lumped(i)*r_i*r_i
         sums(:, 2) = sums(:, 2) + lumped(i)*x_lumped*x_lumped
      end do
   end subroutine start_nodes

   !> x <- x + step d, r <- r - step q, and r.D r.
   subroutine step_along(s, matrix, step, x, norm)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: step(ndim)
      real(dp), intent(inout), contiguous :: x(:, :)
      real(dp), intent(out) :: norm(ndim)
      integer :: block, first
      associate (region => matrix%coupled)
         !$omp parallel do schedule(static) private(first)
         do block = 1, block_count(region)
            first = (block - 1)*nodes_per_block + 1
            call step_nodes(block_size(region, block), region%nodes(first), step, matrix%lumped, s%d, s%q, x, s%r, &
                            s%partial(1, 1, block))
         end do
         norm = sum(s%partial(:, 1, :block_count(region)), dim=2)
      end associate
   end subroutine step_along

   !> `step_along` at some nodes.
   pure subroutine step_nodes(n, nodes, step, lumped, d, q, x, r, norm)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: step(ndim), lumped(*), d(ndim, *), q(ndim, *)
      real(dp), intent(inout) :: x(ndim, *), r(ndim, *)
      real(dp), intent(out) :: norm(ndim)
      real(dp) :: r_i(ndim)
      integer :: a, i
      norm = 0
      do a = 1, n
         i = nodes(a)
         x(:, i) = x(:, i) + step*d(:, i)
         r_i = r(:, i) - step*q(:, i)
         r(:, i) = r_i
         norm = norm + lumped(i)*r_i*r_i
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

   !> Set the held components to zero.
   subroutine hold(s, x)
      type(mass_solver_t), intent(in) :: s
      real(dp), intent(inout), contiguous :: x(:, :)
      integer :: k
      do k = 1, size(s%held_nodes)
         where (s%held(:, k)) x(:, s%held_nodes(k)) = 0
      end do
   end subroutine hold

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
         call dot_of_nodes(block_size(region, block), region%nodes(first), x, y, s%partial(1, 1, block))
      end do
      total = sum(s%partial(:, 1, :block_count(region)), dim=2)
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

   !> x = D^-1 b at some nodes.
   subroutine divide(n, nodes, lumped, b, x)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: lumped(*), b(ndim, *)
      real(dp), intent(inout) :: x(ndim, *)
      real(dp) :: inverse
      integer :: a
      !$omp parallel do schedule(static) private(inverse)
      do a = 1, n
         inverse = 1/lumped(nodes(a))
         x(:, nodes(a)) = b(:, nodes(a))*inverse
      end do
   end subroutine divide

   !> y = D x.
   subroutine weigh(region, lumped, x, y)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: lumped(*), x(ndim, *)
      real(dp), intent(inout) :: y(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      do a = 1, region%n_nodes
         y(:, region%nodes(a)) = lumped(region%nodes(a))*x(:, region%nodes(a))
      end do
   end subroutine weigh

   !> d <- d - q, x <- x + d.
   subroutine add_term(region, q, d, x)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: q(ndim, *)
      real(dp), intent(inout) :: d(ndim, *), x(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      do a = 1, region%n_nodes
         associate (i => region%nodes(a))
            d(:, i) = d(:, i) - q(:, i)
            x(:, i) = x(:, i) + d(:, i)
         end associate
      end do
   end subroutine add_term

   !> y <- y + x.
   subroutine add(region, x, y)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: x(ndim, *)
      real(dp), intent(inout) :: y(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      do a = 1, region%n_nodes
         y(:, region%nodes(a)) = y(:, region%nodes(a)) + x(:, region%nodes(a))
      end do
   end subroutine add

   !> d <- z + factor d, by component.
   subroutine add_to_direction(region, factor, z, d)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: factor(ndim), z(ndim, *)
      real(dp), intent(inout) :: d(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      do a = 1, region%n_nodes
         d(:, region%nodes(a)) = z(:, region%nodes(a)) + factor*d(:, region%nodes(a))
      end do
   end subroutine add_to_direction

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
