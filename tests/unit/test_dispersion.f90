!> Dispersion: the frequency of waves along a bar against that of the discrete equations, and the order of its error, for all
!> mass matrices.
!>
!> In a bar of cells of size h, with two particles a cell in each direction at (1/2 -+ s) h, take motions cos(k x) of the
!> nodes. With q = k h and S = sin^2(q/2), the nodal matrices over the lumped mass are numbers:
!>
!>    mass        mu = 1 - t S,  t = 1 - 4 s^2: 3/4 at the quarter points, 2/3 at the Gauss points
!>    stiffness   (c/h)^2 4 S: that of linear elements, whatever s, as the strain of a cell is uniform
!>    inverse     x = 1 (lumped), (1 - (1-mu)^k)/mu (fmpm k), 1/((1-b) mu + b) (blend b), 1/mu (full, which is blend 0)
!>
!> Finite elements have omega^2 = (c/h)^2 4 S x. The material point method maps to the nodes and back in each step: usf, usavg
!> and musl are leapfrog schemes of omega^2 = (c/h)^2 4 S mu x^2. With q^2 = 4 S (1 + S/3 + 8/45 S^2 + ...) the relative error
!> of omega begins with
!>
!>    ((1-b) t/4 - 1/12) q^2/2    elements of blend b,
!>    ((1-2b) t/4 - 1/12) q^2/2   material points of blend b; lumped as b = 1, full and fmpm as b = 0.
!>
!> It vanishes with b = 1/2 - 1/(6 t): 5/18 at the quarter points and 1/4 at the Gauss points (1 - 1/(3 t) for elements: 5/9,
!> and 1/2 at the Gauss points, Goudreau 1970). What then remains is ((t/2 + 1/6) (1-t)/2 - 8/45) q^4/32.
program test_dispersion
   use hampm_kinds, only: dp
   use hampm_constraints, only: constrain_box
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish
   use hampm_mass_choice, only: mass_choice_t
   use hampm_mass_samples, only: choice_of
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, place_bodies, start, run_steps
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp)
   character(5), parameter :: leapfrogs(3) = ['usf  ', 'usavg', 'musl ']
   real(dp), parameter :: quarter = 0.25_dp, gauss = 0.5_dp/sqrt(3.0_dp)  !! distance of particles to the middle [cells]

   write (*, '(a,t13,a)') 'mass', 'points   to theory  elements  material points: error with 16, 32, 64 cells a wave,'// &
      ' order, shortest wave'
   call study_points('quarter', quarter)
   call study_points('Gauss', gauss)
   call finish()

contains

   !> All mass matrices with particles at `s` from the middle of the cells.
   subroutine study_points(points, s)
      character(*), intent(in) :: points
      real(dp), intent(in) :: s
      real(dp) :: t, best
      t = 1 - 4*s**2
      best = 0.5_dp - 1/(6*t)
      call study(points, s, 'lumped', choice_of('lumped'), 1, 1.0_dp)
      call study(points, s, 'fmpm 2', choice_of('fmpm', order=2), 2, 0.0_dp)
      call study(points, s, 'fmpm 4', choice_of('fmpm', order=4), 4, 0.0_dp)
      call study(points, s, 'weighted 0.75', choice_of('weighted', lumped_fraction=0.75_dp), 0, 0.75_dp)
      call study(points, s, 'weighted 0.5', choice_of('weighted', lumped_fraction=0.5_dp), 0, 0.5_dp)
      call study(points, s, 'weighted best', choice_of('weighted', lumped_fraction=best), 0, best)
      call study(points, s, 'consistent', choice_of('consistent'), 0, 0.0_dp)
   end subroutine study_points

   !> One mass matrix: all waves of a bar of 12 cells, and the longest of bars of 8, 16 and 32 cells.
   subroutine study(points, s, name, mass, terms, b)
      character(*), intent(in) :: points, name
      real(dp), intent(in) :: s
      type(mass_choice_t), intent(in) :: mass
      integer, intent(in) :: terms               !! of the series, or 0 where equations are solved
      real(dp), intent(in) :: b                  !! lumped part
      integer, parameter :: cells(3) = [8, 16, 32]
      real(dp) :: error(3), order(2), t, deviation, second, fourth
      character(:), allocatable :: what
      integer :: k, j
      what = name//', '//points//' points: '
      t = 1 - 4*s**2
      second = ((1 - 2*b)*t/4 - 1/12.0_dp)/2
      fourth = ((t/2 + 1/6.0_dp)*(1 - t)/2 - 8/45.0_dp)/32
      deviation = 0
      do k = 1, size(leapfrogs)
         do j = 1, 12
            deviation = max(deviation, abs(frequency(leapfrogs(k), mass, s, 12, j)/theory(pi*j/12, t, terms, b) - 1))
         end do
      end do
      do k = 1, size(cells)
         error(k) = frequency('musl', mass, s, cells(k), 1)/(pi/cells(k)) - 1
      end do
      order = log(error(:2)/error(2:))/log(2.0_dp)
      write (*, '(a,t13,a,t20,es11.1,f9.4,a,f8.4,a,3es12.3,2f7.3,f8.4)') name, points, deviation, ((1 - b)*t/4 - 1/12.0_dp)/2, &
         ' q^2 ', second, ' q^2', error, order, frequency('musl', mass, s, 12, 12)
      call check(deviation <= 1.0e-12_dp, what//'waves have the frequency of theory')
      if (abs(second) > 1.0e-10_dp) then
         call check_close(order(2), 2.0_dp, 0.05_dp, what//'the error is of second order')
         call check_close(error(3)/(pi/cells(3))**2, second, 1.0e-3_dp, what//'the leading error is that of theory')
      else
         call check_close(order(2), 4.0_dp, 0.05_dp, what//'the error is of fourth order')
         call check_close(error(3)/(pi/cells(3))**4, fourth, 1.0e-5_dp, what//'the leading error is that of theory')
      end if
   end subroutine study

   !> omega h/c of the discrete equations.
   pure real(dp) function theory(q, t, terms, b)
      real(dp), intent(in) :: q, t, b
      integer, intent(in) :: terms
      real(dp) :: mu, x
      mu = 1 - t*sin(q/2)**2
      if (terms > 0) then
         x = (1 - (1 - mu)**terms)/mu
      else
         x = 1/((1 - b)*mu + b)
      end if
      theory = 2*sin(q/2)*sqrt(mu)*x
   end function theory

   !> omega h/c of the mode with `half_waves` in a free bar of `n` cells, without the error in time: the amplitudes a of a
   !> leapfrog scheme have a(n+1) - 2 a(n) + a(n-1) = -(omega dt)^2 a(n).
   real(dp) function frequency(scheme, mass, s, n, half_waves)
      character(*), intent(in) :: scheme
      type(mass_choice_t), intent(in) :: mass
      real(dp), intent(in) :: s
      integer, intent(in) :: n, half_waves
      real(dp), parameter :: dt = 0.2_dp             ! in cells of size 1 and with wave speed 1
      integer, parameter :: steps = 40
      type(problem_t) :: m
      real(dp) :: a(0:steps), q
      integer :: i, k
      q = pi*half_waves/n
      call place_bodies(forest_t([0.0_dp, 0.0_dp], 1.0_dp, [n, 1]), &
                        new_material('', 'linear_elastic', .true., 1.0_dp, 0.0_dp, 1.0_dp), &
                        [rectangle_t([0.0_dp, 0.0_dp], [real(n, dp), 1.0_dp], [2*n, 2])], m)
      call constrain_box(m%constraints, m%grid, [0.0_dp, 0.0_dp], [real(n, dp), 1.0_dp], [.false., .true.])
      associate (p => m%particles)
         p%total_frame = .true.
         do i = 1, p%n
            p%reference(i, :) = floor(p%reference(i, :)) + 0.5_dp + sign(s, modulo(p%reference(i, :), 1.0_dp) - 0.5_dp)
            p%velocity(i, 1) = mode(q, p%reference(i, 1))
         end do
      end associate
      call start(m, scheme, mass)
      a(0) = amplitude(m, q)
      do k = 1, steps
         call run_steps(m, dt, 1)
         a(k) = amplitude(m, q)
      end do
      associate (middle => a(1:steps - 1))
         frequency = sqrt(-sum((a(2:) - 2*middle + a(:steps - 2))*middle)/sum(middle**2))/dt
      end associate
   end function frequency

   !> Amplitude of a mode in the velocity of the particles.
   real(dp) function amplitude(m, q)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: q
      integer :: i
      amplitude = 0
      do i = 1, m%particles%n
         amplitude = amplitude + m%particles%velocity(i, 1)*mode(q, m%particles%reference(i, 1))
      end do
   end function amplitude

   !> cos(q x) at the nodes, linear between them.
   pure real(dp) function mode(q, x)
      real(dp), intent(in) :: q, x
      associate (left => real(floor(x), dp))
         mode = (left + 1 - x)*cos(q*left) + (x - left)*cos(q*(left + 1))
      end associate
   end function mode
end program test_dispersion
