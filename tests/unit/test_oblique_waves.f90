!> Dispersion of waves that cross square cells along their diagonal, for all mass matrices.
!>
!> A wave vector q (cos theta, sin theta) in cells, particles at (1/2 -+ s) of a cell in each direction, t = 1 - 4 s^2 and
!> S_i = sin^2(q_i/2). As in test_dispersion, but
!>
!>    mass        mu = (1 - t S_1) (1 - t S_2)
!>    stiffness   [L A_1 + G A_2, (L - G) sin q_1 sin q_2; the same, L A_2 + G A_1],
!>                A_1 = 4 S_1 (1 - t S_2), A_2 = 4 S_2 (1 - t S_1)
!>
!> with L = lambda + 2 mu and the shear modulus G: a strain is uniform along its own direction only. On the diagonal its vectors
!> are (1, 1) and (1, -1), the dilatational and the shear wave. The relative error of omega begins with
!>
!>    ((1-2b) t/4 - 1/12 - d)/2 q^2
!>    dilatational    d = (1/12 - G/(4 L) + t (L + G)/(4 L)) cos^2 sin^2
!>    shear           d = (1/12 - L/(4 G) + t (L + G)/(4 G)) cos^2 sin^2
!>
!> for blend b: the mass matrix errs alike in all directions, the stiffness most along the diagonal.
program test_oblique_waves
   use hampm_kinds, only: dp
   use hampm_constraints, only: constrain_box
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish
   use hampm_mass_choice, only: mass_choice_t
   use hampm_mass_samples, only: choice_of
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t
   use hampm_samples, only: rectangle_t, place_bodies, start, run_steps
   use hampm_threads, only: use_threads
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: t = 0.75_dp             !! particles at the quarter points
   real(dp), parameter :: nu = 0.3_dp             !! plane stress
   real(dp), parameter :: stiff(2) = [1.0_dp, (1 - nu)/2]  !! L and G, with density 1
   character(12), parameter :: waves(2) = ['dilatational', 'shear       ']
   integer, parameter :: signs(2) = [1, -1]       !! of the motion across, the one along being 1

   call use_threads(1, 1)
   write (*, '(a)') 'mass          wave          to theory  coefficient of q^2  theory'
   call study('lumped', choice_of('lumped'), 1, 1.0_dp)
   call study('fmpm 2', choice_of('fmpm', order=2), 2, 0.0_dp)
   call study('weighted 0.5', choice_of('weighted', lumped_fraction=0.5_dp), 0, 0.5_dp)
   call study('weighted 5/18', choice_of('weighted', lumped_fraction=5/18.0_dp), 0, 5/18.0_dp)
   call study('weighted 0.25', choice_of('weighted', lumped_fraction=0.25_dp), 0, 0.25_dp)
   call study('consistent', choice_of('consistent'), 0, 0.0_dp)
   call finish()

contains

   !> Both waves of one mass matrix.
   subroutine study(name, mass, terms, b)
      character(*), intent(in) :: name
      type(mass_choice_t), intent(in) :: mass
      integer, intent(in) :: terms               !! of the series, or 0 where equations are solved
      real(dp), intent(in) :: b                  !! lumped part
      integer, parameter :: half_waves(3) = [1, 3, 5], n = 6
      real(dp) :: deviation, q, leading
      integer :: k, j
      do k = 1, size(waves)
         deviation = 0
         do j = 1, size(half_waves)
            q = pi*half_waves(j)/n
            deviation = max(deviation, abs(frequency(mass, n, half_waves(j), signs(k))/theory(q, k, terms, b) - 1))
         end do
         call check(deviation <= 1.0e-12_dp, name//', '//trim(waves(k))//' wave has the frequency of theory')
         q = 2.0e-3_dp
         leading = (theory(q, k, terms, b)/(q*sqrt(2*stiff(k))) - 1)/(2*q**2)
         write (*, '(a,t15,a,es11.1,2f14.4)') name, waves(k), deviation, leading, expansion(k, b)
         call check_close(leading, expansion(k, b), 1.0e-5_dp, name//', '//trim(waves(k))//' wave: the leading error')
      end do
   end subroutine study

   !> omega of the discrete equations, h and the dilatational wave speed being 1, for q_1 = q_2 = q.
   pure real(dp) function theory(q, k, terms, b)
      real(dp), intent(in) :: q, b
      integer, intent(in) :: k, terms
      real(dp) :: mu, x
      associate (s => sin(q/2)**2, total => sum(stiff), difference => stiff(1) - stiff(2))
         mu = (1 - t*s)**2
         if (terms > 0) then
            x = (1 - (1 - mu)**terms)/mu
         else
            x = 1/((1 - b)*mu + b)
         end if
         theory = sqrt((total*4*s*(1 - t*s) + signs(k)*difference*sin(q)**2)*mu)*x
      end associate
   end function theory

   !> Coefficient of the leading relative error, theta = 45 degrees; lumped as b = 1, fmpm as b = 0.
   pure real(dp) function expansion(k, b)
      integer, intent(in) :: k
      real(dp), intent(in) :: b
      associate (own => stiff(k), other => stiff(3 - k))
         expansion = ((1 - 2*b)*t/4 - 1/12.0_dp - (1/12.0_dp - other/(4*own) + t*(own + other)/(4*own))/4)/2
      end associate
   end function expansion

   !> omega of a standing wave in a square of `n` cells with smooth rigid walls, without the error in time (see test_dispersion).
   real(dp) function frequency(mass, n, half_waves, sign_across)
      type(mass_choice_t), intent(in) :: mass
      integer, intent(in) :: n, half_waves, sign_across
      real(dp), parameter :: dt = 0.2_dp
      integer, parameter :: steps = 40
      type(problem_t) :: m
      real(dp) :: a(0:steps), side, q
      integer :: i, k
      q = pi*half_waves/n
      side = n
      call place_bodies(forest_t([0.0_dp, 0.0_dp], 1.0_dp, [n, n]), &
                        new_material('', 'linear_elastic', .true., 1 - nu**2, nu, 1.0_dp), &
                        [rectangle_t([0.0_dp, 0.0_dp], [side, side], [2*n, 2*n])], m)
      call constrain_box(m%constraints, m%grid, [0.0_dp, 0.0_dp], [0.0_dp, side], [.true., .false.])
      call constrain_box(m%constraints, m%grid, [side, 0.0_dp], [side, side], [.true., .false.])
      call constrain_box(m%constraints, m%grid, [0.0_dp, 0.0_dp], [side, 0.0_dp], [.false., .true.])
      call constrain_box(m%constraints, m%grid, [0.0_dp, side], [side, side], [.false., .true.])
      associate (p => m%particles)
         p%total_frame = .true.
         do i = 1, p%n
            p%velocity(i, :2) = mode(q, sign_across, p%reference(i, 1), p%reference(i, 2))
         end do
      end associate
      call start(m, 'musl', mass)
      a(0) = amplitude(m, q, sign_across)
      do k = 1, steps
         call run_steps(m, dt, 1)
         a(k) = amplitude(m, q, sign_across)
      end do
      associate (middle => a(1:steps - 1))
         frequency = sqrt(-sum((a(2:) - 2*middle + a(:steps - 2))*middle)/sum(middle**2))/dt
      end associate
   end function frequency

   !> Amplitude of a mode in the velocity of the particles.
   real(dp) function amplitude(m, q, sign_across)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: q
      integer, intent(in) :: sign_across
      integer :: i
      amplitude = 0
      associate (p => m%particles)
         do i = 1, p%n
            amplitude = amplitude + dot_product(p%velocity(i, :2), mode(q, sign_across, p%reference(i, 1), p%reference(i, 2)))
         end do
      end associate
   end function amplitude

   !> (sin q x cos q y, +-cos q x sin q y) at the nodes, bilinear between them.
   pure function mode(q, sign_across, x, y) result(u)
      real(dp), intent(in) :: q, x, y
      integer, intent(in) :: sign_across
      real(dp) :: u(2)
      u = [linear(sin(q*floor(x)), sin(q*(floor(x) + 1)), x)*linear(cos(q*floor(y)), cos(q*(floor(y) + 1)), y), &
           sign_across*linear(cos(q*floor(x)), cos(q*(floor(x) + 1)), x)*linear(sin(q*floor(y)), sin(q*(floor(y) + 1)), y)]
   end function mode

   !> A value between those at the two nodes beside x.
   pure real(dp) function linear(left, right, x)
      real(dp), intent(in) :: left, right, x
      linear = left + (right - left)*(x - floor(x))
   end function linear
end program test_oblique_waves
