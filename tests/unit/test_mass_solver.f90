!> The mass matrices of a body of randomly displaced particles, and all ways of solving with them.
program test_mass_solver
   use hampm_kinds, only: dp, ndim, long
   use hampm_constraints, only: constrain_box
   use hampm_failure, only: failure_t, exit_computation
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_mass_choice, only: mass_choice_t
   use hampm_mass_matrix, only: eigenvalue_floor, prepare_cell
   use hampm_mass_samples, only: choice_of, map_mass, displace, dense_matrix, solution
   use hampm_mass_solver, only: solve_mass
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, place_bodies, start, run_steps
   use hampm_step, only: advance
   use hampm_text, only: to_text
   implicit none

   real(dp), parameter :: cell = 0.1_dp
   character(6), parameter :: solvers(2) = ['cg    ', 'direct']
   real(dp), parameter :: lower(ndim) = [0.05_dp, 0.05_dp], upper(ndim) = [0.45_dp, 0.9_dp]  !! box of partial
   integer :: k

   call repeat_random_numbers()
   call check_agreement('consistent', choice_of('consistent'))
   call check_agreement('partial', choice_of('partial', lower=lower, upper=upper))
   call check_agreement('weighted', choice_of('weighted', lumped_fraction=0.4_dp))
   call check_all_held()
   call check_momentum()
   call check_limits()
   call check_series()
   call check_row_sums()
   do k = 1, size(solvers)
      call check_message(trim(solvers(k)))
   end do
   do k = 2, size(solvers)
      call check_reuse_in_the_total_frame(trim(solvers(k)))
      call check_reuse_in_the_updated_frame(trim(solvers(k)))
   end do
   call finish()

contains

   !> A body of 2 x 2 particles per cell, displaced at random.
   subroutine random_body(m, range)
      type(problem_t), intent(out) :: m
      real(dp), intent(in) :: range              !! of the displacements, in cells
      call place_bodies(forest_t([0.0_dp, 0.0_dp], cell, [12, 9]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([0.2_dp, 0.3_dp], [1.0_dp, 0.6_dp], [16, 6])], m)
      call displace(m, range*cell, [0.0_dp, 0.0_dp])
      call random_number(m%particles%velocity)
      m%particles%velocity = 2*m%particles%velocity - 1
   end subroutine random_body

   !> The sample with the x component held along a line, and both at a corner.
   subroutine hold_some(m)
      type(problem_t), intent(inout) :: m
      call constrain_box(m%constraints, m%grid, [0.2_dp, 0.0_dp], [0.2_dp, 0.9_dp], [.true., .false.])
      call constrain_box(m%constraints, m%grid, [0.9_dp, 0.3_dp], [1.1_dp, 0.4_dp], [.true., .true.])
   end subroutine hold_some

   !> M x = b at the free components, whichever way it is solved, from any guess.
   subroutine check_agreement(name, mass)
      character(*), intent(in) :: name
      type(mass_choice_t), intent(in) :: mass
      type(mass_choice_t) :: choice
      type(problem_t) :: m
      real(dp), allocatable :: a(:, :), b(:, :), guess(:, :), x(:, :, :), residual(:, :)
      real(dp) :: scale
      integer :: k
      call random_body(m, 0.5_dp)
      call hold_some(m)
      call map_mass(m, mass)
      allocate (b, guess, residual, mold=m%fields%momentum)
      allocate (x(ndim, m%grid%n_nodes, size(solvers)), a(m%grid%n_nodes, m%grid%n_nodes))
      call random_number(b)
      call random_number(guess)
      do k = 1, m%grid%n_nodes                   ! loads of the size of the masses: solutions of size 1
         b(:, k) = b(:, k)*m%fields%mass_matrix%lumped(k)
      end do
      do k = 1, size(solvers)
         choice = choice_of('consistent', solvers(k))
         choice%lumped_inside = mass%lumped_inside
         choice%lumped_outside = mass%lumped_outside
         choice%lower = mass%lower
         choice%upper = mass%upper
         call map_mass(m, choice)
         a = dense_matrix(m)
         x(:, :, k) = solution(m, b, guess)
         residual = b - matmul(x(:, :, k), a)
         where (m%constraints%fixed) residual = 0
         call check_close(maxval(abs(residual))/maxval(abs(b)), 0.0_dp, 1.0e-11_dp, name//', '//solvers(k)//': M x = b')
         call check(.not. any(m%constraints%fixed .and. abs(x(:, :, k)) > 0), name//', '//solvers(k)//': held nodes stay')
         call check(m%solver%iterations < 60, name//', '//solvers(k)//': few iterations')
      end do
      scale = maxval(abs(x(:, :, 1)))
      write (*, '(2a,es9.1)') name, ': difference of direct to cg', maxval(abs(x(:, :, 2) - x(:, :, 1)))/scale
      call check_close(maxval(abs(x(:, :, 2) - x(:, :, 1)))/scale, 0.0_dp, 1.0e-10_dp, name//': direct agrees with cg')
   end subroutine check_agreement

   !> A component that is held everywhere has no unknowns: as of a bar in a slot.
   subroutine check_all_held()
      type(problem_t) :: m
      real(dp), allocatable :: x(:, :)
      integer :: k
      call random_body(m, 0.5_dp)
      allocate (x(ndim, m%grid%n_nodes))
      call constrain_box(m%constraints, m%grid, [0.0_dp, 0.0_dp], [1.2_dp, 0.9_dp], [.false., .true.])
      do k = 1, size(solvers)
         call map_mass(m, choice_of('consistent', solvers(k)))
         x = solution(m, m%fields%momentum, 0*m%fields%momentum)
         call check(all(abs(x(2, :)) <= 0), solvers(k)//': a component that is held everywhere stays')
         call check_close(maxval(abs(matmul(x(1:1, :), dense_matrix(m)) - m%fields%momentum(1:1, :))), 0.0_dp, 1.0e-13_dp, &
                          solvers(k)//': beside it the other is solved')
      end do
   end subroutine check_all_held

   !> The sum of M x is the sum of b, for every kind and also after a bad guess: to the rounding of the numbers that are
   !> summed, which are of the size of the momenta or of what the guess makes of them.
   subroutine check_momentum()
      type(problem_t) :: m
      character(10), parameter :: kinds(5) = ['lumped    ', 'fmpm      ', 'consistent', 'partial   ', 'weighted  ']
      real(dp), parameter :: guesses(3) = [0.0_dp, 1.0e3_dp, 1.0e6_dp]
      real(dp), allocatable :: a(:, :), x(:, :), guess(:, :)
      real(dp) :: error, scale, worst
      integer :: i, j, k
      call random_body(m, 0.5_dp)
      allocate (a(m%grid%n_nodes, m%grid%n_nodes), x(ndim, m%grid%n_nodes), guess(ndim, m%grid%n_nodes))
      worst = 0
      do i = 1, size(kinds)
         do j = 1, size(solvers)
            call map_mass(m, choice_of(trim(kinds(i)), solvers(j), order=3, lumped_fraction=0.5_dp, lower=lower, upper=upper))
            a = dense_matrix(m)
            do k = 1, size(guesses)
               call random_number(guess)
               guess = guesses(k)*guess
               x = solution(m, m%fields%momentum, guess)
               error = maxval(abs(sum(matmul(x, a), dim=2) - sum(m%fields%momentum, dim=2)))
               scale = sum(abs(m%fields%momentum)) + sum(matmul(guess, a))
               worst = max(worst, error/scale)
               call check_close(error/scale, 0.0_dp, 1.0e-14_dp, &
                                trim(kinds(i))//', '//solvers(j)//': momentum is kept, guess '//to_text(guesses(k)))
            end do
         end do
      end do
      write (*, '(a,es9.1)') 'momentum: largest error of the sum of M x', worst
   end subroutine check_momentum

   !> Kinds that are others at the ends of their range.
   subroutine check_limits()
      type(problem_t) :: m
      real(dp), allocatable :: lumped(:, :), full(:, :), zero(:, :)
      integer :: k
      call random_body(m, 0.5_dp)
      call hold_some(m)
      call map_mass(m, choice_of('lumped'))
      allocate (zero, lumped, full, mold=m%fields%momentum)
      zero = 0
      lumped = solution(m, m%fields%momentum, zero)
      call map_mass(m, choice_of('consistent'))
      full = solution(m, m%fields%momentum, zero)
      call check(maxval(abs(full - lumped)) > 0.1_dp, 'full and lumped differ')
      call map_mass(m, choice_of('fmpm', order=1))
      call check(all(transfer(solution(m, m%fields%momentum, zero), [0_long]) == transfer(lumped, [0_long])), &
                 'fmpm of order 1 is lumped bit for bit')
      do k = 1, size(solvers)
         call map_mass(m, choice_of('weighted', solvers(k), lumped_fraction=1.0_dp))
         call check(all(transfer(solution(m, m%fields%momentum, zero), [0_long]) == transfer(lumped, [0_long])), &
                    solvers(k)//': blend 1 is lumped bit for bit')
         call map_mass(m, choice_of('partial', solvers(k), lower=[2.0_dp, 2.0_dp], upper=[3.0_dp, 3.0_dp]))
         call check(all(transfer(solution(m, m%fields%momentum, zero), [0_long]) == transfer(lumped, [0_long])), &
                    solvers(k)//': partial with nothing in its box is lumped bit for bit')
         call map_mass(m, choice_of('weighted', solvers(k), lumped_fraction=0.0_dp))
         call check_close(maxval(abs(solution(m, m%fields%momentum, zero) - full)), 0.0_dp, 1.0e-10_dp, &
                          solvers(k)//': blend 0 is full')
         call map_mass(m, choice_of('partial', solvers(k)))
         call check_close(maxval(abs(solution(m, m%fields%momentum, zero) - full)), 0.0_dp, 1.0e-10_dp, &
                          solvers(k)//': partial with everything in its box is full')
      end do
   end subroutine check_limits

   !> fmpm of order k is x_k = x - (I - D^-1 M)^k x. In the norm of D its error falls with every order, each time at least by
   !> 1 - the smallest eigenvalue of D^-1 M, which is near 1/16, that of four particles at the quarter points.
   subroutine check_series()
      type(problem_t) :: m
      real(dp), allocatable :: zero(:, :), full(:, :), x(:, :), before(:, :)
      real(dp) :: error, initial, previous, rate
      integer :: k
      call random_body(m, 0.02_dp)
      call map_mass(m, choice_of('fmpm', order=1))
      allocate (zero, full, x, mold=m%fields%momentum)
      allocate (before(m%grid%n_nodes, m%grid%n_nodes))
      zero = 0
      before = dense_matrix(m)
      call map_mass(m, choice_of('consistent'))
      call check(all(abs(dense_matrix(m) - before) <= 0), 'where four particles stand well the full matrix is used as it is')
      full = solution(m, m%fields%momentum, zero)
      rate = 1 - eigenvalue_floor
      initial = norm(m, full)
      previous = initial
      do k = 0, 8
         call map_mass(m, choice_of('fmpm', order=2**k))
         x = solution(m, m%fields%momentum, zero)
         error = norm(m, x - full)
         write (*, '(a,i4,2(a,es9.2))') 'fmpm of order', 2**k, ': distance to full', error/initial, '  bound', rate**2**k
         call check(error < previous, 'fmpm: the error falls with the order')
         call check(error <= rate**2**k*initial + 1.0e-11_dp*initial, 'fmpm: and as fast as the eigenvalues tell')
         previous = error
      end do
      ! Held components as well
      call hold_some(m)
      call map_mass(m, choice_of('consistent'))
      full = solution(m, m%fields%momentum, zero)
      call map_mass(m, choice_of('fmpm', order=600))
      call check_close(norm(m, solution(m, m%fields%momentum, zero) - full)/initial, 0.0_dp, 1.0e-10_dp, &
                       'fmpm tends to full where components are held')
   end subroutine check_series

   !> Square root of x.D x.
   real(dp) function norm(m, x)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: x(:, :)
      norm = sqrt(sum(sum(x**2, dim=1)*m%fields%mass_matrix%lumped))
   end function norm

   !> However a cell is prepared, its row sums stay, it stays symmetric, and its eigenvalues are not below the floor.
   subroutine check_row_sums()
      real(dp) :: before(4, 4), after(4, 4), row(4), n(4), xi(ndim), blend
      integer :: trial, i, particles, c
      do trial = 1, 2000
         particles = 1 + mod(trial, 4)
         before = 0
         do i = 1, particles
            call random_number(xi)
            if (mod(trial, 7) == 0) xi = 1.0e-14_dp + xi*1.0e-6_dp
            n = [(1 - xi(1))*(1 - xi(2)), xi(1)*(1 - xi(2)), (1 - xi(1))*xi(2), xi(1)*xi(2)]
            do c = 1, 4
               before(:, c) = before(:, c) + n(c)*n
            end do
         end do
         row = sum(before, dim=2)
         after = before
         blend = merge(0.3_dp, 0.0_dp, mod(trial, 2) == 0)
         call prepare_cell(4, blend, .true., .false., after)
         if (any(abs(sum(after, dim=2) - row) > 1.0e-14_dp*row)) call check(.false., 'row sums of a prepared cell stay')
         if (any(abs(after - transpose(after)) > 0)) call check(.false., 'a prepared cell is symmetric')
         do c = 1, 4
            after(c, c) = after(c, c) - 0.999_dp*eigenvalue_floor*row(c)
            after(:, c) = after(:, c)/sqrt(row(c))
         end do
         do c = 1, 4
            after(c, :) = after(c, :)/sqrt(row(c))
         end do
         if (.not. is_positive(after)) call check(.false., 'eigenvalues of a prepared cell are above the floor')
      end do
      call check(.true., 'prepared cells')
   end subroutine check_row_sums

   !> Whether Cholesky's factorisation exists.
   logical function is_positive(a)
      real(dp), intent(in) :: a(:, :)
      real(dp) :: l(size(a, 1), size(a, 1)), pivot
      integer :: i, j
      l = 0
      is_positive = .false.
      do j = 1, size(a, 1)
         pivot = a(j, j) - sum(l(j, :j - 1)**2)
         if (.not. pivot > 0) return
         l(j, j) = sqrt(pivot)
         do i = j + 1, size(a, 1)
            l(i, j) = (a(i, j) - dot_product(l(i, :j - 1), l(j, :j - 1)))/l(j, j)
         end do
      end do
      is_positive = .true.
   end function is_positive

   !> A matrix that is not positive definite, as none that is mapped is, cannot be solved with.
   subroutine check_message(solver)
      character(*), intent(in) :: solver
      type(problem_t) :: m
      type(failure_t) :: failure
      real(dp), allocatable :: x(:, :)
      call random_body(m, 0.5_dp)
      call map_mass(m, choice_of('consistent', solver))
      m%fields%mass_matrix%cell = -m%fields%mass_matrix%cell
      m%fields%mass_matrix%row = -m%fields%mass_matrix%row
      allocate (x, source=m%fields%momentum)
      call solve_mass(m%solver, m%grid, m%fields%mass_matrix, m%fields%momentum, x, failure)
      call check(failure%code == exit_computation, solver//': equations that are not solved are a failure')
      call check(index(failure%message, 'mass matrix: ') == 1, solver//': its message says where')
      call check(index(failure%message, 'mass = ''lumped''') > 0, solver//': and which key to change')
      call m%solver%direct%release()
   end subroutine check_message

   !> In the total frame one factorisation serves for ever, in one iteration a solution.
   subroutine check_reuse_in_the_total_frame(solver)
      character(*), intent(in) :: solver
      type(problem_t) :: m
      call random_body(m, 0.02_dp)
      m%particles%total_frame = .true.
      call start(m, 'musl', choice_of('consistent', solver))
      call run_steps(m, 0.05_dp*cell, 50)
      call check(m%solver%direct%factorisations == 1, solver//', total frame: the matrix is factorised once')
      call check(m%solver%iterations <= m%solver%solutions, solver//', total frame: and solved in one iteration')
      call m%solver%direct%release()
   end subroutine check_reuse_in_the_total_frame

   !> In the updated frame the pattern is analysed anew only when other cells are occupied, and the matrix is factorised anew
   !> only where the old factors do not serve any more.
   subroutine check_reuse_in_the_updated_frame(solver)
      character(*), intent(in) :: solver
      type(problem_t) :: m
      type(failure_t) :: failure
      integer, allocatable :: occupied(:)
      integer :: changes
      call random_body(m, 0.02_dp)
      m%particles%velocity = 0.003_dp*m%particles%velocity
      m%particles%velocity(:, 1) = m%particles%velocity(:, 1) + 0.03_dp
      call start(m, 'musl', choice_of('consistent', solver))
      changes = 0
      allocate (occupied, source=m%blocks%occupied(:m%blocks%n_occupied))
      do while (m%state%steps < 600 .and. .not. failure%failed())
         call advance(m, 0.05_dp*cell, failure)
         if (size(occupied) == m%blocks%n_occupied) then
            if (all(occupied == m%blocks%occupied(:m%blocks%n_occupied))) cycle
         end if
         changes = changes + 1
         occupied = m%blocks%occupied(:m%blocks%n_occupied)
      end do
      if (failure%failed()) call check(.false., failure%message)
      write (*, '(a,4(i0,a))') solver//', updated frame: ', m%solver%solutions, ' solutions, ', &
         m%solver%direct%factorisations, ' factorisations, ', m%solver%direct%analyses, ' analyses, ', changes, &
         ' changes of the occupied cells'
      call check(changes > 2, solver//': the body moves through the cells')
      call check(m%solver%direct%analyses <= 1 + changes, solver//': the pattern is analysed only when it changes')
      call check(5*m%solver%direct%factorisations < m%solver%solutions, solver//': factors serve again')
      call check(m%solver%direct%analyses <= m%solver%direct%factorisations, solver//': analyses are for factorisations')
      call m%solver%direct%release()
   end subroutine check_reuse_in_the_updated_frame
end program test_mass_solver
