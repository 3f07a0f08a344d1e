!> The nodal equations M x = b, with the mass matrix and the way of solution that a run asks for:
!>
!>   lumped   x = D^-1 b, D the lumped matrix (9);
!>   fmpm     the first `order` terms of the series sum_j (I - D^-1 M)^j D^-1 b (Nairn & Hammerquist 2021);
!>   cg       conjugate gradients preconditioned by D, from x + D^-1 (b - M x), x being the guess: the sum of M x is then
!>            the sum of b at every iterate, so that momentum is exact;
!>   umfpack, banded   conjugate gradients preconditioned by a factorisation: one iterate while the matrix is the
!>            factorised one; when it has changed so much that more than a few are needed, it is factorised anew.
!>
!> Held components are eliminated: their unknowns are zero and their equations are left out.
module hampm_mass_solver
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_direct, only: direct_t
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: mass_matrix_t, multiply_cells, gather_slots
   use hampm_text, only: to_text
   implicit none
   private
   public :: mass_solver_t, new_mass_solver, solve_mass, by_lumped, by_fmpm, by_cg, by_umfpack, by_banded

   integer, parameter :: by_lumped = 1, by_fmpm = 2, by_cg = 3, by_umfpack = 4, by_banded = 5

   real(dp), parameter :: tolerance = 1.0e-12_dp    !! of the residual over the right-hand side, in the norm of D^-1
   integer, parameter :: most_iterations = 1000
   integer, parameter :: patience = 6               !! iterations after which a factorisation is made anew
   integer, parameter :: nodes_per_block = 512      !! sums over nodes are taken over blocks of this many first

   type :: mass_solver_t
      integer :: by = by_lumped
      integer :: order = 1                          !! of fmpm
      integer, allocatable, private :: held_nodes(:)  !! nodes with a held component
      logical, allocatable, private :: held(:, :)     !! which components of these, (ndim, number of them)
      type(direct_t) :: direct
      integer(long) :: solutions = 0                !! so far
      integer(long) :: iterations = 0               !! of all solutions
      logical, private :: factorised = .false.
      real(dp), allocatable, private :: r(:, :), z(:, :), d(:, :), q(:, :)  !! workspace, (ndim, n_nodes)
      real(dp), allocatable, private :: product(:, :)     !! workspace by slot, (ndim, 0:corners*n_elements)
      real(dp), allocatable, private :: partial(:, :)     !! workspace of sums, (ndim, blocks)
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
         allocate (s%r(ndim, n), s%z(ndim, n), s%d(ndim, n), s%q(ndim, n), s%product(ndim, 0:corners*grid%n_elements), &
                   s%partial(ndim, n/nodes_per_block + 1), stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'mass matrix: not enough memory for this number of nodes')
         return
      end if
      s%product = 0
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
      select case (s%by)
      case (by_lumped)
         call divide(matrix, b, x)
         call hold(s, x)
      case (by_fmpm)
         call add_series(s, grid, matrix, b, x)
      case default
         call iterate(s, grid, matrix, b, x, failure)
      end select
   end subroutine solve_mass

   !> x = sum_{j < order} (I - D^-1 M)^j D^-1 b.
   subroutine add_series(s, grid, matrix, b, x)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      integer :: j
      call divide(matrix, b, x)
      call hold(s, x)
      if (s%order > 1) call copy(matrix, x, s%d)
      do j = 2, s%order
         call multiply(s, grid, matrix, s%d, s%q)
         call divide(matrix, s%q, s%z)
         call hold(s, s%z)
         call add(matrix, [-1.0_dp, -1.0_dp], s%z, s%d)
         call add(matrix, [1.0_dp, 1.0_dp], s%d, x)
      end do
   end subroutine add_series

   !> Preconditioned conjugate gradients, each component by itself (Saad 2003, algorithm 9.1).
   subroutine iterate(s, grid, matrix, b, x, failure)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      type(failure_t), intent(inout) :: failure
      real(dp), dimension(ndim) :: rz, rz_new, step, target
      integer :: k
      if (s%by /= by_cg .and. .not. s%factorised) call factorise(s, grid, matrix, failure)
      if (failure%failed()) return
      call hold(s, x)
      call residual(s, grid, matrix, b, x, target)
      if (s%by == by_cg) call correct_by_lumped(s, grid, matrix, x)
      do k = 0, most_iterations
         call divide(matrix, s%r, s%z)
         rz_new = dot(s, matrix, s%r, s%z)
         if (all(rz_new <= target)) exit
         if (s%by /= by_cg) then
            call s%direct%solve(s%r, s%z)
            rz_new = dot(s, matrix, s%r, s%z)
         end if
         if (k == 0) then
            call copy(matrix, s%z, s%d)
         else
            call add_to_direction(matrix, ratio(rz_new, rz), s%z, s%d)
         end if
         rz = rz_new
         call multiply(s, grid, matrix, s%d, s%q)
         call hold(s, s%q)
         step = ratio(rz, dot(s, matrix, s%d, s%q))
         call add(matrix, step, s%d, x)
         call add(matrix, -step, s%q, s%r)
      end do
      s%solutions = s%solutions + 1
      s%iterations = s%iterations + k
      if (k > most_iterations) call failure%report(exit_computation, 'mass matrix: conjugate gradients have not '// &
         'converged in '//to_text(most_iterations)//' iterations. Likely cause: the run is unstable; reduce &method courant')
      if (k > patience) s%factorised = .false.
   end subroutine iterate

   !> r = b - M x without held components, and the square of the residual that is small enough, in the norm of D^-1.
   subroutine residual(s, grid, matrix, b, x, target)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :), x(:, :)
      real(dp), intent(out) :: target(ndim)
      call copy(matrix, b, s%r)
      call hold(s, s%r)
      call divide(matrix, s%r, s%z)
      target = tolerance**2*dot(s, matrix, s%r, s%z)
      call multiply(s, grid, matrix, x, s%q)
      call hold(s, s%q)
      call add(matrix, [-1.0_dp, -1.0_dp], s%q, s%r)
   end subroutine residual

   !> x <- x + D^-1 r: whatever the guess was, the sum of M x is then the sum of b, and stays so under iteration.
   subroutine correct_by_lumped(s, grid, matrix, x)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(inout), contiguous :: x(:, :)
      call divide(matrix, s%r, s%z)
      call add(matrix, [1.0_dp, 1.0_dp], s%z, x)
      call multiply(s, grid, matrix, s%z, s%q)
      call hold(s, s%q)
      call add(matrix, [-1.0_dp, -1.0_dp], s%q, s%r)
   end subroutine correct_by_lumped

   !> Factorise the matrix as it is now.
   subroutine factorise(s, grid, matrix, failure)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      type(failure_t), intent(inout) :: failure
      logical :: held(ndim, grid%n_nodes)
      held = .false.
      held(:, s%held_nodes) = s%held
      call s%direct%factorise(grid, matrix, held, failure)
      s%factorised = .true.
   end subroutine factorise

   !> y = M x.
   subroutine multiply(s, grid, matrix, x, y)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: x(:, :)
      real(dp), intent(inout), contiguous :: y(:, :)
      call multiply_cells(matrix%n_cells, matrix%cells, grid%element_nodes, matrix%cell, x, s%product(1, 1))
      call gather_slots(matrix%n_active, matrix%active, grid%node_slot, s%product, y)
   end subroutine multiply

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
   function dot(s, matrix, x, y) result(total)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: x(:, :), y(:, :)
      real(dp) :: total(ndim)
      integer :: block, blocks, first
      blocks = (matrix%n_active - 1)/nodes_per_block + 1
      !$omp parallel do schedule(static) private(first)
      do block = 1, blocks
         first = (block - 1)*nodes_per_block + 1
         call dot_of_nodes(min(nodes_per_block, matrix%n_active - first + 1), matrix%active(first), x, y, &
                           s%partial(1, block))
      end do
      total = sum(s%partial(:, :blocks), dim=2)
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
   subroutine divide(matrix, b, x)
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: b(ndim, *)
      real(dp), intent(inout) :: x(ndim, *)
      real(dp) :: inverse
      integer :: a
      !$omp parallel do schedule(static) private(inverse)
      do a = 1, matrix%n_active
         associate (i => matrix%active(a))
            inverse = 1/matrix%lumped(i)
            x(:, i) = b(:, i)*inverse
         end associate
      end do
   end subroutine divide

   !> y <- y + factor x, by component.
   subroutine add(matrix, factor, x, y)
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: factor(ndim), x(ndim, *)
      real(dp), intent(inout) :: y(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      do a = 1, matrix%n_active
         y(:, matrix%active(a)) = y(:, matrix%active(a)) + factor*x(:, matrix%active(a))
      end do
   end subroutine add

   !> d <- z + factor d, by component.
   subroutine add_to_direction(matrix, factor, z, d)
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: factor(ndim), z(ndim, *)
      real(dp), intent(inout) :: d(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      do a = 1, matrix%n_active
         d(:, matrix%active(a)) = z(:, matrix%active(a)) + factor*d(:, matrix%active(a))
      end do
   end subroutine add_to_direction

   !> y = x.
   subroutine copy(matrix, x, y)
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: x(ndim, *)
      real(dp), intent(inout) :: y(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      do a = 1, matrix%n_active
         y(:, matrix%active(a)) = x(:, matrix%active(a))
      end do
   end subroutine copy
end module hampm_mass_solver
