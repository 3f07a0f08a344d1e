!> The nodal equations M x = b, with the mass matrix and the solver of a run:
!>
!>   lumped   x = D^-1 b, D the lumped matrix (9);
!>   fmpm     the first `order` terms of the series sum_j (I - D^-1 M)^j D^-1 b (Nairn & Hammerquist 2021);
!>   cg       conjugate gradients preconditioned by the inverses of the cells' matrices (see `precondition`);
!>   direct   factors of the matrix; they precondition conjugate gradients while it has changed little, else it is factorised anew.
!>
!> The residual of an iteration is divided by D: the sum of M x is the sum of b to rounding, so that momentum is exact. Components
!> fixed by a Dirichlet constraint are eliminated.
!>
!> Vectors of the nodes of a region, for iterations. Sums are taken over chunks of nodes first: independent of the number of
!> threads.
module hampm_mass_solver
   use hampm_kinds, only: dp, ndim, neighbours, long
   use hampm_archive, only: archive_t
   use hampm_constraints, only: constraints_t, hold, let_turn
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_mass_factorisation, only: mass_factorisation_t
   use hampm_mass_matrix, only: mass_matrix_t, region_t, nodes_per_chunk
   use hampm_jumps, only: jump_t, add_mass_product
   use hampm_nodal_rows, only: unlike_neighbours, multiply_rows
   use hampm_text, only: to_text
   implicit none
   private
   public :: mass_solver_t, new_mass_solver, solve_mass, solve_aside, by_lumped, by_fmpm, by_cg, by_direct, archive_solver

   integer, parameter :: by_lumped = 1, by_fmpm = 2, by_cg = 3, by_direct = 4

   real(dp), parameter :: light = 1.0e-3_dp         !! mass of a light node over the mean mass of the nodes
   real(dp), parameter :: tolerance = 1.0e-13_dp    !! of the residual over the right-hand side, in the norm of D^-1: the
                                                    !! error at the particles may be sqrt(20) times as large, and
                                                    !! the error at nodes of little mass far larger
   integer, parameter :: norms = 2                  !! in which the residual is measured, see `start_residual`
   integer, parameter :: most_iterations = 1000
   real(dp), parameter :: zero(ndim) = 0, one(ndim) = 1
   integer, parameter :: patience = 6               !! iterations after which a factorisation is made anew
   character(*), parameter :: no_numbers = 'momenta or forces of the nodes are too large or no longer numbers. Likely cause: '// &
                              'the run is unstable; reduce &method courant, or time_step of implicit steps'

   !> Solution of nodal equations, with the data kept from one solution to the next.
   type :: mass_solver_t
      integer :: by = by_lumped
      integer :: order = 1                          !! of fmpm
      type(constraints_t), private :: constraints   !! which components are fixed
      type(mass_factorisation_t) :: direct
      integer(long) :: solutions = 0                !! so far
      integer(long) :: iterations = 0               !! of all solutions
      logical :: factorised = .false.               !! whether `direct` holds a factorisation to precondition with
      integer, private :: layout = 0                !! of the matrix solved last
      integer, private :: version = 0               !! of the matrix solved last
      integer, private :: factorised_version = -1   !! of the matrix factorised last, if constant, else -1
      real(dp), private :: light_mass = 0           !! [kg]
      real(dp), allocatable, private :: inverse(:, :)     !! D^-1 where the matrix is coupled, 0 for fixed components,
                                                          !! 1 at hanging nodes, (ndim, n_points)
      real(dp), allocatable, private :: r(:, :), z(:, :), d(:, :), q(:, :)  !! workspace, (ndim, n_points)
      real(dp), allocatable, private :: partial(:, :, :)  !! workspace of sums, (ndim, 2 norms, chunks)
   contains
      procedure :: hold_or_turn
      procedure :: iterates
      procedure, private :: is_factorised_as_it_is
   end type mass_solver_t

contains

   !> A solver for a grid, new or replacing one for another grid, whose counts continue. Fails where the memory does not suffice.
   subroutine new_mass_solver(by, order, grid, constraints, s, failure, ghosts)
      integer, intent(in) :: by                     !! `by_lumped`, ...
      integer, intent(in) :: order                  !! of fmpm
      type(grid_t), intent(in) :: grid
      type(constraints_t), intent(in) :: constraints
      type(mass_solver_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(jump_t), allocatable, intent(in), optional :: ghosts(:) !! of the matrix
      type(mass_solver_t) :: fresh
      integer :: status
      fresh%solutions = s%solutions
      fresh%iterations = s%iterations
      fresh%direct%analyses = s%direct%analyses
      fresh%direct%factorisations = s%direct%factorisations
      call s%direct%release()
      s = fresh
      s%by = by
      s%order = order
      allocate (s%direct%ghosts(0))
      if (present(ghosts)) then
         if (allocated(ghosts)) s%direct%ghosts = ghosts
      end if
      s%constraints = constraints
      if (.not. allocated(s%constraints%fixed)) allocate (s%constraints%fixed(ndim, grid%n_nodes), source=.false.)
      if (by == by_lumped) return
      associate (n => grid%n_points)
         allocate (s%inverse(ndim, n), s%r(ndim, n), s%z(ndim, n), s%d(ndim, n), s%q(ndim, n), &
                   s%partial(ndim, 2*norms, n/nodes_per_chunk + 1), stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'mass matrix: not enough memory for this number of nodes')
         return
      end if
      s%inverse = 1
      s%r = 0
      s%d = 0
      s%z = 0
   end subroutine new_mass_solver

   !> Whether a guess helps.
   pure logical function iterates(self)
      class(mass_solver_t), intent(in) :: self
      iterates = self%by /= by_lumped .and. self%by /= by_fmpm .and. .not. self%is_factorised_as_it_is()
   end function iterates

   !> Whether the matrix that was solved last is the one that is factorised.
   pure logical function is_factorised_as_it_is(self) result(is)
      class(mass_solver_t), intent(in) :: self
      is = self%factorised .and. self%factorised_version == self%version
   end function is_factorised_as_it_is

   !> Solve M x = b at the nodes of the matrix. On entry `x` holds a guess, from which cg and the direct solvers start. Fails
   !> where the iteration does not converge or the factorisation does not exist.
   subroutine solve_mass(s, grid, matrix, b, x, failure)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)   !! (ndim, n_points)
      real(dp), intent(inout), contiguous :: x(:, :)  !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      if (s%by /= by_lumped .and. s%version /= matrix%version) call follow_matrix(s, matrix)
      select case (s%by)
      case (by_lumped)
         call divide(matrix%all%n_nodes, matrix%all%nodes, matrix%inverse_lumped, b, x)
         call s%hold_or_turn(matrix, b, x)
      case (by_fmpm)
         call add_series(s, grid, matrix, b, x)
      case default
         call divide(size(matrix%apart), matrix%apart, matrix%inverse_lumped, b, x)
         call s%hold_or_turn(matrix, b, x)
         if (matrix%coupled%n_nodes == 0) return
         if (s%by == by_direct .and. .not. s%factorised) call factorise(s, grid, matrix, failure)
         if (failure%failed()) return
         if (s%is_factorised_as_it_is()) then
            call solve_by_factors(s, matrix, b, x, failure)
         else if (allocated(matrix%diagonal)) then
            call iterate(s, grid, matrix, matrix%diagonal, b, x, failure)
         else
            call iterate(s, grid, matrix, matrix%lumped, b, x, failure)
         end if
      end select
   end subroutine solve_mass

   !> Set fixed components to zero or, where they turn with others, to the turning by b: their masses are lumped.
   pure subroutine hold_or_turn(self, matrix, b, x)
      class(mass_solver_t), intent(in) :: self
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: b(:, :)               !! (ndim, n_points)
      real(dp), intent(inout), contiguous :: x(:, :) !! (ndim, n_points)
      call hold(self%constraints, x)
      if (allocated(self%constraints%turning)) call let_turn(self%constraints, matrix%lumped, b, x)
   end subroutine hold_or_turn

   !> Solve M x = b between steps, as `solve_mass` does, and leave a new factorisation of the matrix to the steps: these do not
   !> depend on solutions between them.
   subroutine solve_aside(s, grid, matrix, b, x, failure)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)   !! (ndim, n_points)
      real(dp), intent(inout), contiguous :: x(:, :)  !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      logical :: was_factorised
      was_factorised = s%factorised
      call solve_mass(s, grid, matrix, b, x, failure)
      s%factorised = s%factorised .or. was_factorised
   end subroutine solve_aside

   !> Prepare for a matrix that has changed.
   subroutine follow_matrix(s, matrix)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      integer :: a
      s%version = matrix%version
      s%light_mass = light*sum(matrix%lumped(matrix%coupled%nodes(:matrix%coupled%n_nodes)))/max(1, matrix%coupled%n_nodes)
      !$omp parallel do schedule(static)
      do a = 1, matrix%coupled%n_nodes
         s%inverse(:, matrix%coupled%nodes(a)) = matrix%inverse_lumped(matrix%coupled%nodes(a))
      end do
      if (allocated(matrix%diagonal)) then
         do a = 1, matrix%coupled%n_nodes
            s%inverse(:, matrix%coupled%nodes(a)) = 1/matrix%diagonal(matrix%coupled%nodes(a))
         end do
      end if
      call hold(s%constraints, s%inverse)
      if (s%layout /= matrix%layout .and. s%factorised) s%factorised = s%direct%fits(matrix)
      s%layout = matrix%layout
   end subroutine follow_matrix

   !> x = sum_{j < order} (I - D^-1 M)^j D^-1 b.
   subroutine add_series(s, grid, matrix, b, x)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      real(dp) :: unused(ndim)
      integer :: j
      associate (region => matrix%coupled)
         call divide(size(matrix%apart), matrix%apart, matrix%inverse_lumped, b, x)
         call divide(region%n_nodes, region%nodes, matrix%inverse_lumped, b, x)
         call s%hold_or_turn(matrix, b, x)
         if (s%order > 1) call combine(region, one, x, zero, s%d)
         do j = 2, s%order
            call multiply(s, grid, matrix, matrix%row, s%d, s%q, unused)
            call combine(region, -one, s%q, one, s%d)
            call combine(region, one, s%d, one, x)
         end do
      end associate
   end subroutine add_series

   !> Factorise the matrix.
   subroutine factorise(s, grid, matrix, failure)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      type(failure_t), intent(inout) :: failure
      call s%direct%factorise(grid, matrix, s%constraints%fixed, failure)
      s%factorised = .not. failure%failed()
      s%factorised_version = merge(matrix%version, -1, matrix%stays .and. s%direct%is_definite())
   end subroutine factorise

   !> x = M^-1 b by the factors of M.
   subroutine solve_by_factors(s, matrix, b, x, failure)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      type(failure_t), intent(inout) :: failure
      real(dp) :: total
      integer :: a
      call hold(s%constraints, x)
      call s%direct%solve(b, x)
      s%solutions = s%solutions + 1
      s%iterations = s%iterations + 1
      total = 0
      do a = 1, matrix%coupled%n_nodes
         total = total + sum(abs(x(:, matrix%coupled%nodes(a))))
      end do
      if (.not. total <= huge(total)) call failure%report(exit_computation, 'mass matrix: '//no_numbers)
   end subroutine solve_by_factors

   !> Preconditioned conjugate gradients, each component by itself (Saad 2003, algorithm 9.1). The residual is kept divided
   !> by D: r = D^-1 (b - M x), and so is the product with the direction, q = D^-1 M d. Fixed components of either are 0.
   subroutine iterate(s, grid, matrix, diagonal, b, x, failure)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: diagonal(:)           !! D: the lumped masses or, where these may be below 0, the diagonal of M [kg],
                                                    !! (n_points)
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      type(failure_t), intent(inout) :: failure
      real(dp), dimension(ndim, norms) :: norm, target
      real(dp), dimension(ndim) :: rz, rz_last, dq
      integer :: k
      call hold(s%constraints, x)
      call start_residual(s, grid, matrix, diagonal, b, x, norm, target)
      if (any(norm > target)) then               ! no guess is better than one that is worse than none
         call clear(matrix%coupled, any(norm > target, dim=2), x)
         call start_residual(s, grid, matrix, diagonal, b, x, norm, target)
      end if
      target = tolerance**2*target
      rz_last = 0
      do k = 0, most_iterations
         if (all(norm <= target) .or. .not. all(norm <= huge(norm))) exit
         call precondition(s, grid, matrix, diagonal, rz)
         call combine(matrix%coupled, one, s%z, ratio(rz, rz_last), s%d)
         call multiply(s, grid, matrix, matrix%row, s%d, s%q, dq)
         call step_along(s, matrix, diagonal, ratio(rz, dq), x, norm)
         rz_last = rz
      end do
      call combine(matrix%coupled, one, s%r, one, x)
      s%solutions = s%solutions + 1
      s%iterations = s%iterations + k
      if (.not. all(norm <= target)) call report_divergence(min(k, most_iterations), norm, target, failure)
      if (k > patience) s%factorised = .false.
   end subroutine iterate

   !> Fail because the iteration does not end, with its progress.
   subroutine report_divergence(iterations, norm, target, failure)
      integer, intent(in) :: iterations
      real(dp), intent(in) :: norm(:, :), target(:, :)  !! squares, as of `start_residual`
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: found
      found = no_numbers
      if (all(norm <= huge(norm)) .and. all(target > 0)) &
         found = 'the residual is still '//to_text(tolerance*sqrt(maxval(norm/target)))//' of the right-hand side. Likely '// &
                 'cause: nodes of cells with little material, at an edge or a crack; use &method solver = ''direct'' or '// &
                 'mass = ''lumped'''
      call failure%report(exit_computation, 'mass matrix: the nodal equations are not solved after '//to_text(iterations)// &
                          ' iterations: '//found)
   end subroutine report_divergence

   !> z = P^-1 D r, and z.D r. With a factorised matrix P, or of conjugate gradients
   !>
   !>    P^-1 = D^-1 (sum over cells of D_e M_e^-1 D_e) D^-1.
   !>
   !> The eigenvalues of P^-1 M are at least 1: any v is the sum of D^-1 D_e v_e, so that v.P v <= sum of v_e.M_e v_e = v.M v
   !> (the lemma of additive Schwarz methods; Toselli & Widlund 2005, section 2.2). At most they are the largest of
   !> M_e^-1 D_e. With the particles at the quarter points they lie between 1 and (25/16)**2, those of D^-1 M between 1/16
   !> and 1.
   subroutine precondition(s, grid, matrix, diagonal, rz)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: diagonal(:)
      real(dp), intent(out) :: rz(ndim)
      if (s%by == by_cg) then
         call multiply(s, grid, matrix, matrix%inverse_row, s%r, s%z, rz)
      else
         call weigh(matrix%coupled, diagonal, s%r, s%q)
         call s%direct%solve(s%q, s%z)
         rz = dot(s, matrix%coupled, s%q, s%z)
      end if
   end subroutine precondition

   !> y = D^-1 A x without fixed components, A being given by rows of nodes, hanging nodes included, and x.A x. Values of `x` are
   !> distributed on the way.
   subroutine multiply(s, grid, matrix, row, x, y, xax)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: row(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      real(dp), intent(inout), contiguous :: y(:, :)
      real(dp), intent(out) :: xax(ndim)
      real(dp) :: of_ghosts(ndim)
      integer :: chunk, first
      associate (spans => matrix%spans, chunks => size(matrix%spans%of_chunk) - 1, region => matrix%coupled)
         call grid%dofs%distribute(region, ndim, x)
         !$omp parallel do schedule(static) private(first)
         do chunk = 1, chunks
            first = spans%of_chunk(chunk)
            associate (n => spans%of_chunk(chunk + 1) - first)
               select case (size(row, 1))
               case (neighbours)                 ! a constant, for which the compiler unrolls
                  call multiply_rows(neighbours, n, spans%first(first), spans%last(first), spans%offset(1, first), row, s%inverse, &
                                     x, y, s%partial(1, 1, chunk))
               case (unlike_neighbours)
                  call multiply_rows(unlike_neighbours, n, spans%first(first), spans%last(first), spans%offset(1, first), row, &
                                     s%inverse, x, y, s%partial(1, 1, chunk))
               case default
                  call multiply_rows(size(row, 1), n, spans%first(first), spans%last(first), spans%offset(1, first), row, &
                                     s%inverse, x, y, s%partial(1, 1, chunk))
               end select
            end associate
         end do
         xax = sum(s%partial(:, 1, :chunks), dim=2)
         call grid%dofs%condense(region, ndim, y, s%inverse)
      end associate
      if (.not. allocated(matrix%ghosts)) return
      call add_mass_product(matrix%ghosts, x, y, of_ghosts, s%inverse)
      xax = xax + of_ghosts
   end subroutine multiply

   !> r = D^-1 (b - M x), the squares of its norms, and those of D^-1 b.
   !>
   !> There are two norms: of D, and one in which a node with hardly any mass counts as if it had a `light` one. A force at a node
   !> that a particle has just touched is beyond all bounds in the first and would hide the residual at all other nodes; in the
   !> second such nodes themselves are hidden.
   subroutine start_residual(s, grid, matrix, diagonal, b, x, norm, norm_of_b)
      type(mass_solver_t), intent(inout) :: s
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: diagonal(:)
      real(dp), intent(in), contiguous :: b(:, :)
      real(dp), intent(inout), contiguous :: x(:, :)
      real(dp), intent(out) :: norm(ndim, norms), norm_of_b(ndim, norms)
      real(dp) :: sums(ndim, 2*norms), unused(ndim)
      integer :: chunk, first
      call multiply(s, grid, matrix, matrix%row, x, s%q, unused)
      associate (region => matrix%coupled)
         !$omp parallel do schedule(static) private(first)
         do chunk = 1, chunk_count(region)
            first = (chunk - 1)*nodes_per_chunk + 1
            call start_nodes(chunk_size(region, chunk), region%nodes(first), diagonal, s%light_mass, s%inverse, b, s%q, s%r, &
                             s%partial(1, 1, chunk))
         end do
         sums = sum(s%partial(:, :, :chunk_count(region)), dim=3)
      end associate
      norm = sums(:, :norms)
      norm_of_b = sums(:, norms + 1:)
   end subroutine start_residual

   !> `start_residual` at some nodes, with both sums.
   pure subroutine start_nodes(n, nodes, lumped, light_mass, inverse, b, q, r, sums)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: lumped(*), light_mass, inverse(ndim, *), b(ndim, *), q(ndim, *)
      real(dp), intent(inout) :: r(ndim, *)
      real(dp), intent(out) :: sums(ndim, 2*norms)
      real(dp) :: x_lumped(ndim), r_i(ndim)
      integer :: a, i
      sums = 0
      do a = 1, n
         i = nodes(a)
         x_lumped = inverse(:, i)*b(:, i)
         r_i = x_lumped - q(:, i)
         r(:, i) = r_i
         call add_norms(lumped(i), light_mass, r_i, sums(:, :norms))
         call add_norms(lumped(i), light_mass, x_lumped, sums(:, norms + 1:))
      end do
   end subroutine start_nodes

   !> Add the contributions of a node to the squares of both norms.
   pure subroutine add_norms(mass, light_mass, r, norm)
      real(dp), intent(in) :: mass, light_mass, r(ndim)
      real(dp), intent(inout) :: norm(ndim, norms)
      real(dp) :: energy(ndim)
      energy = mass*r*r
      norm(:, 1) = norm(:, 1) + energy
      norm(:, 2) = norm(:, 2) + min(mass/light_mass, 1.0_dp)*energy
   end subroutine add_norms

   !> x <- x + step d, r <- r - step q, and the squares of the norms of r.
   subroutine step_along(s, matrix, diagonal, step, x, norm)
      type(mass_solver_t), intent(inout) :: s
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: diagonal(:)
      real(dp), intent(in) :: step(ndim)
      real(dp), intent(inout), contiguous :: x(:, :)
      real(dp), intent(out) :: norm(ndim, norms)
      integer :: chunk, first
      associate (region => matrix%coupled)
         !$omp parallel do schedule(static) private(first)
         do chunk = 1, chunk_count(region)
            first = (chunk - 1)*nodes_per_chunk + 1
            call step_nodes(chunk_size(region, chunk), region%nodes(first), step, diagonal, s%light_mass, s%d, s%q, x, s%r, &
                            s%partial(1, 1, chunk))
         end do
         norm = sum(s%partial(:, :norms, :chunk_count(region)), dim=3)
      end associate
   end subroutine step_along

   !> `step_along` at some nodes.
   pure subroutine step_nodes(n, nodes, step, lumped, light_mass, d, q, x, r, norm)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: step(ndim), lumped(*), light_mass, d(ndim, *), q(ndim, *)
      real(dp), intent(inout) :: x(ndim, *), r(ndim, *)
      real(dp), intent(out) :: norm(ndim, norms)
      real(dp) :: r_i(ndim)
      integer :: a, i
      norm = 0
      do a = 1, n
         i = nodes(a)
         x(:, i) = x(:, i) + step*d(:, i)
         r_i = r(:, i) - step*q(:, i)
         r(:, i) = r_i
         call add_norms(lumped(i), light_mass, r_i, norm)
      end do
   end subroutine step_nodes

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
      integer :: chunk, a
      !$omp parallel do schedule(static) private(a)
      do chunk = 1, chunk_count(region)
         s%partial(:, 1, chunk) = 0
         do a = (chunk - 1)*nodes_per_chunk + 1, min(chunk*nodes_per_chunk, region%n_nodes)
            s%partial(:, 1, chunk) = s%partial(:, 1, chunk) + x(:, region%nodes(a))*y(:, region%nodes(a))
         end do
      end do
      total = sum(s%partial(:, 1, :chunk_count(region)), dim=2)
   end function dot

   !> Archive the factorisation of a solver, and its counts.
   subroutine archive_solver(solver, name, grid, stays, matrix, archive)
      character(*), intent(in) :: name
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: stays                  !! whether the next step has the same matrix
      type(mass_matrix_t), intent(in) :: matrix     !! the present one
      type(mass_solver_t), intent(inout) :: solver
      class(archive_t), intent(inout) :: archive
      logical :: as_it_is
      call archive%section(name)
      call archive%serialise('factorised', solver%factorised)
      call solver%direct%serialise(grid, solver%constraints%fixed, solver%factorised, archive)
      as_it_is = stays .and. solver%factorised_version == matrix%version
      call archive%serialise('factorised_as_it_is', as_it_is)
      if (archive%is_read) solver%factorised_version = merge(matrix%version, -1, as_it_is)
      call archive%serialise('solutions', solver%solutions)
      call archive%serialise('iterations', solver%iterations)
   end subroutine archive_solver

   !> Number of chunks of nodes.
   pure integer function chunk_count(region)
      type(region_t), intent(in) :: region
      chunk_count = (region%n_nodes - 1)/nodes_per_chunk + 1
   end function chunk_count

   !> Number of nodes of a chunk.
   pure integer function chunk_size(region, chunk)
      type(region_t), intent(in) :: region
      integer, intent(in) :: chunk
      chunk_size = min(nodes_per_chunk, region%n_nodes - (chunk - 1)*nodes_per_chunk)
   end function chunk_size

   !> x = D^-1 b at some nodes.
   subroutine divide(n, nodes, inverse, b, x)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: inverse(*), b(ndim, *)    !! D^-1 and b
      real(dp), intent(inout) :: x(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      !GCC$ novector
      do a = 1, n
         x(:, nodes(a)) = b(:, nodes(a))*inverse(nodes(a))
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

   !> y <- a x + b y, by component. `y` has to be finite also where b is 0.
   subroutine combine(region, a, x, b, y)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: a(ndim), x(ndim, *), b(ndim)
      real(dp), intent(inout) :: y(ndim, *)
      integer :: k
      !$omp parallel do schedule(static)
      do k = 1, region%n_nodes
         y(:, region%nodes(k)) = a*x(:, region%nodes(k)) + b*y(:, region%nodes(k))
      end do
   end subroutine combine

   !> x = 0 in some components.
   subroutine clear(region, components, x)
      type(region_t), intent(in) :: region
      logical, intent(in) :: components(ndim)
      real(dp), intent(inout) :: x(ndim, *)
      integer :: a
      do a = 1, region%n_nodes
         where (components) x(:, region%nodes(a)) = 0
      end do
   end subroutine clear
end module hampm_mass_solver
