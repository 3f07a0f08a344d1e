!> A small body at 10,000 positions within the cells (in slow builds, every eleventh), with 1, 2 and 4 particles a cell, for every
!> mass matrix and solver.
!>
!> Singular and nearly singular matrices are normal in the material point method. Whatever the position, nodal velocities
!> must keep the momentum and stay within a stated factor of the particles' own range, and a step must not fail.
!>
!> Let S be the shape functions at the n particles of mass m, v their velocities, M = S^T m S and D its row sums. Every mass
!> matrix maps a translation to itself, so that velocities may be counted from any one: take the middle of the particles'
!> range, c +- r.
!>
!>    lumped   Nodal velocities w = D^-1 S^T m v are means of the particles': they lie within c +- r, and so do the means S w
!>             that the particles get back.
!>
!>    solved   M' w = S^T m v, where M' is the sum of (1 - b) M + b D of the cells, b being the part that is lumped. A mean of
!>             squares is not less than the square of the mean: D >= M, so M' >= M. With the inequality of Schwarz
!>                w M' w = (S w) m v <= sqrt(w M w) sqrt(v m v) <= sqrt(w M' w) sqrt(v m v),
!>             hence w M w <= w M' w <= v m v: particles never get back more energy than they had, and one of them at most
!>             sqrt(n) r. As M' >= b D with b at least the floor, w D w <= v m v / b. At a node all of whose cells are lumped
!>             by b or more, its equation, divided by its mass, is b w + (1 - b) mean of S w = mean of v, so
!>             |w| <= (1 + (1 - b) sqrt(n)) r / b. A cell that is used as it is has M > floor D, therefore at each corner a
!>             particle whose shape function is above the floor and a mass above floor m: there |w| <= sqrt(n) r / floor by
!>             the norm, which is less.
!>
!>    fmpm k   With T = I - D^-1 M, w = (I + ... + T^(k-1)) D^-1 S^T m v. D^-1 M takes means, so max |T x| <= 2 max |x| and
!>             |w| <= (2^k - 1) r. With the eigenvalues mu of D^-1 M, in (0, 1], the parts of v are multiplied by
!>             (1 - (1-mu)^k)/sqrt(mu) <= min(1, k mu)/sqrt(mu) <= sqrt(k) at the nodes in the norm of D, and by
!>             1 - (1-mu)^k <= 1 at the particles.
!>
!> A step with usf follows from every fifth position: the nodal velocities strain the particles, and their stress makes forces at
!> nodes that may have a mass of 1e-28 of the body's. For it no bound is derived: particles must stay within twice their range.
!> Their momentum is kept but for rounding: interpolation is exact for translations, not for an acceleration that is all but
!> infinite at one corner, of which it loses eps/edge_margin.
program test_mass_positions
   use hampm_kinds, only: dp, ndim
   use hampm_basis, only: edge_margin, inside_cell, shape_functions
   use hampm_builds, only: is_slow
   use hampm_energy, only: linear_momentum
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, finish, repeat_random_numbers
   use hampm_mass_choice, only: mass_choice_t
   use hampm_mass_matrix, only: eigenvalue_floor
   use hampm_mass_samples, only: choice_of
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_nodal_fields, only: v_n, find_active_nodes
   use hampm_nodal_motion, only: find_velocity
   use hampm_samples, only: rectangle_t, place_bodies, start, run_steps
   use hampm_sorting, only: sort_into_cells
   use hampm_step, only: advance
   use hampm_text, only: to_text
   implicit none

   integer, parameter :: positions = 10000
   integer, parameter :: points(ndim, 3) = reshape([1, 1, 2, 1, 2, 2], [ndim, 3])  !! of a cell, in each direction
   character(6), parameter :: solvers(2) = ['cg    ', 'direct']
   real(dp), parameter :: slack = 1 + 1.0e-9_dp  !! for rounding
   real(dp), parameter :: drift(ndim) = [3.0_dp, -2.0_dp]
   integer :: n, k

   !> What nodal velocities may be at most; all are relative.
   type :: bound_t
      real(dp) :: node = 1                       !! |w - c| over r
      real(dp) :: norm = 1                       !! norm of D of w - c over that of m of v - c
      real(dp) :: particle = 1                   !! |S w - c| over r
      real(dp) :: momentum = 1.0e-14_dp          !! error of the momentum of the nodes over sum m |v|
      real(dp) :: translation = 1.0e-14_dp       !! norm of D of what a translation misses, over that of the translation
      real(dp) :: step = 2                       !! |v - c| over r after a step
      real(dp) :: step_momentum = epsilon(1.0_dp)/edge_margin  !! change of the momentum in a step over sum m |v|
   end type bound_t

   !> The largest that was seen at all positions.
   type, extends(bound_t) :: seen_t
      real(dp) :: energy = 0                     !! norm of m of S w - c over that of v - c; at most 1
   end type seen_t

   write (*, '(a,t19,a)') 'mass', 'points  |w-c|/r   bound     norm   bound   energy  |Sw-c|/r   bound  momentum  translation'// &
      '  step |v-c|/r  momentum'
   do n = 1, size(points, 2)
      call sweep_cell('lumped', choice_of('lumped'), bound_t())
      do k = 2, 4, 2
         call sweep_cell('fmpm '//to_text(k), choice_of('fmpm', order=k), &
                         bound_t(node=2.0_dp**k - 1, norm=sqrt(real(k, dp)), particle=root_of_particles()))
      end do
      do k = 1, size(solvers)
         call sweep_cell('full '//solvers(k), choice_of('consistent', solvers(k)), bounds_of_solved(eigenvalue_floor))
         call sweep_cell('partial '//solvers(k), choice_of('partial', solvers(k), lower=[-9.0_dp, -9.0_dp], &
                                                           upper=[1.0_dp, 9.0_dp]), bounds_of_solved(eigenvalue_floor))
         call sweep_cell('weighted '//solvers(k), choice_of('weighted', solvers(k), lumped_fraction=0.5_dp), &
                         bounds_of_solved(0.5_dp))
      end do
   end do
   call rest_on_lines('consistent', 0.0_dp)
   call rest_on_lines('weighted', 0.5_dp)
   call finish()

contains

   !> A body with a particle at each node vibrates in the total frame. Cells at its edge have particles on one side only, so
   !> that nodes behind it have a mass of `edge_margin` or its square; still all solvers give the same motion.
   subroutine rest_on_lines(name, b)
      character(*), intent(in) :: name
      real(dp), intent(in) :: b                  !! lumped part
      real(dp) :: velocity(ndim, 16, size(solvers)), difference
      integer :: k
      do k = 1, size(solvers)
         call vibrate(choice_of(name, solvers(k), lumped_fraction=b), velocity(:, :, k))
      end do
      difference = maxval(abs(velocity(:, :, 2) - velocity(:, :, 1)))/maxval(abs(velocity))
      write (*, '(2a,es9.1)') name, ': particles at the nodes, difference between solvers after 200 steps', difference
      call check(difference <= 1.0e-8_dp, name//': solvers agree with particles at the nodes')
   end subroutine rest_on_lines

   !> Velocities after some steps of 4 x 4 particles that start with a shear and a stretch.
   subroutine vibrate(mass, velocity)
      type(mass_choice_t), intent(in) :: mass
      real(dp), intent(out) :: velocity(:, :)
      type(problem_t) :: m
      call place_bodies(forest_t([-2.0_dp, -2.0_dp], 1.0_dp, [8, 8]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t([-0.5_dp, -0.5_dp], [3.5_dp, 3.5_dp], [4, 4])], m)
      m%particles%total_frame = .true.
      m%particles%velocity(:, 1) = sin(m%particles%reference(:, 1))
      m%particles%velocity(:, 2) = m%particles%reference(:, 1)
      call start(m, 'usavg', mass)
      call run_steps(m, 0.05_dp, 200)
      velocity = transpose(m%particles%velocity)
      call m%solver%direct%release()
   end subroutine vibrate

   !> The square root of the number of particles of the body.
   real(dp) function root_of_particles()
      root_of_particles = sqrt(real(4*product(points(:, n)), dp))
   end function root_of_particles

   !> The bounds where equations are solved and cells lumped by at least `b` where they are not used as they are. The residual
   !> is at most 1e-12 of the right-hand side in the norm of D^-1, of which momentum is a sum and M'^-1 D the error.
   type(bound_t) function bounds_of_solved(b)
      real(dp), intent(in) :: b
      bounds_of_solved = bound_t(node=(1 + (1 - b)*root_of_particles())/b, norm=1/sqrt(b), particle=root_of_particles(), &
                                 momentum=2.0e-12_dp, translation=1.0e-12_dp/b + 1.0e-14_dp)
   end function bounds_of_solved

   !> A body of 2 x 2 cells at all positions.
   subroutine sweep_cell(name, mass, bound)
      character(*), intent(in) :: name
      type(mass_choice_t), intent(in) :: mass
      type(bound_t), intent(in) :: bound
      type(problem_t) :: m
      type(seen_t) :: seen
      type(failure_t) :: failure
      real(dp) :: spacing(ndim)
      character(:), allocatable :: what
      integer :: k
      call repeat_random_numbers()
      spacing = 1.0_dp/points(:, n)
      call place_bodies(forest_t([-2.0_dp, -2.0_dp], 1.0_dp, [6, 6]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), &
                        [rectangle_t(-spacing/2, 2 - spacing/2, 2*points(:, n))], m)
      call start(m, 'usf', mass)
      seen = seen_t(0, 0, 0, 0, 0, 0, 0, 0)
      ! A stride of 11 comes to every kind of place that shift() knows, and steps from each
      do k = 1, positions, merge(11, 1, is_slow())
         call set_particles(m, shift(k), failure)
         call map(m, failure)
         if (failure%failed()) exit
         call look(m, seen)
         if (mod(k, 5) == 0) call do_step(m, seen, failure)
         if (failure%failed()) exit
      end do
      call m%solver%direct%release()
      what = trim(name)//' with '//to_text(product(points(:, n)))//' particles a cell: '
      if (failure%failed()) call check(.false., what//failure%message)
      write (*, '(a,t19,i6,2(f9.3,f8.3),f9.3,f10.3,f8.3,es10.1,es13.1,f14.3,es10.1)') name, product(points(:, n)), &
         seen%node, bound%node, seen%norm, bound%norm, seen%energy, seen%particle, bound%particle, seen%momentum, &
         seen%translation, seen%step, seen%step_momentum
      call check(seen%node <= bound%node*slack, what//'nodal velocities are bounded')
      call check(seen%norm <= bound%norm*slack, what//'nodal velocities are bounded in the norm of the lumped masses')
      call check(seen%energy <= slack, what//'particles get back no more energy than they had')
      call check(seen%particle <= bound%particle*slack, what//'velocities that particles get back are bounded')
      call check(seen%momentum <= bound%momentum, what//'the nodes have the momentum of the particles')
      call check(seen%translation <= bound%translation, what//'a translation stays one')
      call check(seen%step <= bound%step, what//'velocities of particles are bounded after a step')
      call check(seen%step_momentum <= bound%step_momentum, what//'a step keeps the momentum')
   end subroutine sweep_cell

   !> Place number `k` of the first particle against a cell edge: spread evenly over a cell, or at a distance between 1e-15 and
   !> 1e-3 from a line in x, in y or in both, on a logarithmic scale.
   pure function shift(k) result(x)
      integer, intent(in) :: k
      real(dp) :: x(ndim)
      real(dp), parameter :: ratio = 1.32471795724474602596_dp  ! ratio**3 = ratio + 1: multiples of its powers spread evenly
      integer :: d
      x = modulo(0.5_dp + (k/4)*[1/ratio, 1/ratio**2], 1.0_dp)
      do d = 1, ndim
         if (.not. btest(k, d - 1)) cycle
         x(d) = sign(10**(-15 + 12*modulo(2*x(d), 1.0_dp)), x(d) - 0.5_dp)
      end do
   end function shift

   !> Put the body at a place: along x each particle at one end of the range, along y a translation.
   subroutine set_particles(m, x, failure)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: x(ndim)
      type(failure_t), intent(inout) :: failure
      real(dp) :: at_random(m%particles%n)
      call random_number(at_random)
      at_random(1) = 0
      at_random(m%particles%n) = 1
      associate (p => m%particles)
         p%displacement(:, 1) = x(1)
         p%displacement(:, 2) = x(2)
         p%velocity(:, 1) = drift(1) + sign(1.0_dp, at_random - 0.5_dp)
         p%velocity(:, 2) = drift(2)
         p%gradient = 0
      end associate
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      call find_active_nodes(m%grid, m%blocks, m%fields, failure)
   end subroutine set_particles

   !> Nodal velocities from the particles', as at the start of a step; the guess is the velocity at the last position.
   subroutine map(m, failure)
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      m%cache%mapped = .false.
      call refresh_grid(m)
      call find_velocity(m%grid, m%solver, m%constraints%free, m%fields, v_n, v_n, failure)
   end subroutine map

   !> Look at the nodal velocities and at what the particles would get back.
   subroutine look(m, seen)
      type(problem_t), intent(in) :: m
      type(seen_t), intent(inout) :: seen
      real(dp) :: back(ndim, m%particles%n), c, r, norm
      integer :: i
      associate (p => m%particles, matrix => m%fields%mass_matrix)
         do i = 1, p%n
            associate (e => p%cell(i))
               back(:, i) = matmul(m%fields%velocity(:, m%grid%element_nodes(:, e), v_n), &
                                   shape_functions(inside_cell(m%grid%local_coordinate(e, p%position(i)))))
            end associate
         end do
         c = (maxval(p%velocity(:, 1)) + minval(p%velocity(:, 1)))/2
         r = (maxval(p%velocity(:, 1)) - minval(p%velocity(:, 1)))/2
         norm = norm2(sqrt(p%mass)*(p%velocity(:, 1) - c))
         associate (nodes => matrix%all%nodes(:matrix%all%n_nodes))
            associate (v => m%fields%velocity(:, nodes, v_n), d => matrix%lumped(nodes))
               call raise(seen%node, (v(1, :) - c)/r)
               call raise(seen%norm, [norm2(sqrt(d)*(v(1, :) - c))/norm])
               call raise(seen%momentum, (matmul(v, d) - linear_momentum(p))/sum(p%mass*abs(p%velocity(:, 1))))
               call raise(seen%translation, [norm2(sqrt(d)*(v(2, :)/drift(2) - 1))/sqrt(sum(d))])
            end associate
         end associate
         call raise(seen%energy, [norm2(sqrt(p%mass)*(back(1, :) - c))/norm])
         call raise(seen%particle, (back(1, :) - c)/r)
      end associate
   end subroutine look

   !> Let `largest` not be less than any of the `values`; one that is not a number counts as the largest there is.
   pure subroutine raise(largest, values)
      real(dp), intent(inout) :: largest
      real(dp), intent(in) :: values(:)
      largest = max(largest, maxval(abs(values)))
      if (.not. all(abs(values) <= huge(largest))) largest = huge(largest)
   end subroutine raise

   !> Do a step.
   subroutine do_step(m, seen, failure)
      type(problem_t), intent(inout) :: m
      type(seen_t), intent(inout) :: seen
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: dt = 0.1_dp         ! in cells of size 1 and with wave speed 1
      real(dp) :: before(ndim)
      associate (p => m%particles)
         before = linear_momentum(p)
         m%cache%mapped = .false.
         call advance(m, dt, failure)
         call raise(seen%step, p%velocity(:, 1) - drift(1))
         call raise(seen%step_momentum, (linear_momentum(p) - before)/sum(p%mass*abs(p%velocity(:, 1))))
      end associate
   end subroutine do_step
end program test_mass_positions
