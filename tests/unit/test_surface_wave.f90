!> The speed of a Rayleigh wave along the surface of a half plane, for all mass matrices, against the exact one.
!>
!> With k = 1, the wave u = (U(y) sin x, V(y) cos x), y being the depth, is a sum of exp(-alpha y) and exp(-beta y),
!>
!>    U = -exp(-alpha y) - beta psi exp(-beta y),   V = -alpha exp(-alpha y) - psi exp(-beta y),   psi = -2 alpha/(1 + beta^2),
!>    alpha^2 = 1 - (c/c_d)^2,  beta^2 = 1 - (c/c_s)^2,  (2 - (c/c_s)^2)^2 = 4 alpha beta (Rayleigh 1885).
!>
!> The discrete equations are those of K and of (A M A)^-1 for a mass (test_dispersion), which is D + (1-2b) (M - D) up to the cell
!> size squared: M the mass matrix, D its row sums, b the lumped part. The mode is stationary in the quotient of both, so that the
!> leading error of omega^2 is that of the quotient with the exact wave at the nodes. In cells of size h, with particles at
!> (1/2 -+ s) h and t = 1 - 4 s^2, and f' being d/dy, the sums over cells are integrals over the depth, and of the surface:
!>
!>    sum over nodes of f g            int f g - h^2/12 (f g)'(0)                       half a cell at the surface
!>    sum over particles of f^2        the same of f^2 - t h^2/4 int f'^2
!>    of f'^2                          int f'^2 + h^2/12 (f' f''(0) + int f' f''')      differences of nodes
!>    of f g'                          int f g' + h^2 ((f g')'(0)/24 + int (f'' g'/8 + f g'''/24))
!>    along x                          1 - t h^2/4 where nothing is differentiated, 1 - h^2/12 twice, 1 - h^2/6 once.
program test_surface_wave
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

   !> The wave: of each sum of the two exponentials their factors.
   type :: wave_t
      real(dp) :: rate(2) = 0                    !! alpha, beta
      real(dp) :: u(2) = 0, v(2) = 0             !! factors in U and V
      real(dp) :: speed = 0                      !! over that of dilatational waves
   end type wave_t

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: t = 0.75_dp            !! particles at the quarter points
   real(dp), parameter :: nu = 0.3_dp            !! plane strain
   real(dp), parameter :: shear = (1 - 2*nu)/(2 - 2*nu)  !! G over lambda + 2 mu = 1, the density being 1
   type(wave_t) :: wave

   call use_threads(1, 1)
   wave = rayleigh_wave()
   call check_close(wave%speed/sqrt(shear), 0.9274_dp, 5.0e-5_dp, 'the Rayleigh wave has 0.9274 of the shear wave''s speed')
   call check_close(quotient(wave), wave%speed**2, 1.0e-14_dp, 'the quotient of the energies of the wave is its frequency')
   write (*, '(a)') 'mass         error with 10 and 20 cells a wave   coefficient of q^2   theory'
   call study('lumped', choice_of('lumped'), 1.0_dp)
   call study('weighted 0.5', choice_of('weighted', 'direct', lumped_fraction=0.5_dp), 0.5_dp)
   call study('weighted 5/18', choice_of('weighted', 'direct', lumped_fraction=5/18.0_dp), 5/18.0_dp)
   call study('weighted 0.25', choice_of('weighted', 'direct', lumped_fraction=0.25_dp), 0.25_dp)
   call study('consistent', choice_of('consistent', 'direct'), 0.0_dp)
   call check(abs(leading_error(wave, 5/18.0_dp)) < 0.1_dp*abs(leading_error(wave, 1.0_dp)), &
              'a blend of 5/18 has less than a tenth of the error of the lumped matrix')
   call finish()

contains

   !> One mass matrix on two sizes of cells. Of what they leave over q^2 the part that goes with q is taken away.
   subroutine study(name, mass, b)
      character(*), intent(in) :: name
      type(mass_choice_t), intent(in) :: mass
      real(dp), intent(in) :: b                  !! lumped part
      integer, parameter :: half(2) = [5, 10]    !! cells of half a wave
      real(dp) :: error(2), coefficient(2), limit
      integer :: k
      do k = 1, 2
         error(k) = frequency(mass, half(k))/(wave%speed*pi/half(k)) - 1
         coefficient(k) = error(k)/(pi/half(k))**2
      end do
      limit = 2*coefficient(2) - coefficient(1)
      write (*, '(a,t14,2es12.2,2f16.4)') name, error, limit, leading_error(wave, b)
      call check_close(limit, leading_error(wave, b), 1.5e-3_dp, name//': the leading error of the Rayleigh wave is that of theory')
   end subroutine study

   !> The wave of a free surface.
   pure type(wave_t) function rayleigh_wave() result(w)
      real(dp) :: low, high, x, psi
      integer :: i
      low = 0.5_dp                               ! of c/c_s
      high = 1
      do i = 1, 60
         x = (low + high)/2
         if ((2 - x**2)**2 < 4*sqrt((1 - x**2)*(1 - x**2*shear))) then
            low = x
         else
            high = x
         end if
      end do
      w%speed = x*sqrt(shear)
      w%rate = sqrt([1 - x**2*shear, 1 - x**2])
      psi = -2*w%rate(1)/(1 + w%rate(2)**2)
      w%u = -[1.0_dp, w%rate(2)*psi]
      w%v = -[w%rate(1), psi]
   end function rayleigh_wave

   !> Elastic over kinetic energy of the exact wave: omega^2.
   pure real(dp) function quotient(w)
      type(wave_t), intent(in) :: w
      associate (u => w%u, v => w%v, u1 => d(w, w%u, 1), v1 => d(w, w%v, 1))
         quotient = (integral(w, u, u) + integral(w, v1, v1) + 2*(1 - 2*shear)*integral(w, u, v1) &
                     + shear*(integral(w, u1, u1) - 2*integral(w, v, u1) + integral(w, v, v))) &
                    /(integral(w, u, u) + integral(w, v, v))
      end associate
   end function quotient

   !> Coefficient of h^2 in the relative error of omega.
   pure real(dp) function leading_error(w, b)
      type(wave_t), intent(in) :: w
      real(dp), intent(in) :: b                  !! lumped part
      real(dp) :: elastic, inertia, spread
      associate (u => w%u, v => w%v, u1 => d(w, w%u, 1), v1 => d(w, w%v, 1))
         elastic = square(w, u) + slope(w, v) + 2*(1 - 2*shear)*mixed(w, u, v) &
                   + shear*(slope(w, u) - 2*mixed(w, v, u) + square(w, v))
         spread = integral(w, u, u) + integral(w, v, v) + integral(w, u1, u1) + integral(w, v1, v1)
         inertia = -(sum(u)*sum(u1) + sum(v)*sum(v1))/6 - (1 - 2*b)*t/4*spread
         leading_error = (elastic/w%speed**2 - inertia)/(2*(integral(w, u, u) + integral(w, v, v)))
      end associate
   end function leading_error

   !> What cells change of the integral of f^2 that is differentiated along x twice, over h^2.
   pure real(dp) function square(w, f)
      type(wave_t), intent(in) :: w
      real(dp), intent(in) :: f(2)
      associate (f1 => d(w, f, 1))
         square = -integral(w, f, f)/12 - sum(f)*sum(f1)/6 - t/4*integral(w, f1, f1)
      end associate
   end function square

   !> The same of f'^2.
   pure real(dp) function slope(w, f)
      type(wave_t), intent(in) :: w
      real(dp), intent(in) :: f(2)
      associate (f1 => d(w, f, 1))
         slope = -t/4*integral(w, f1, f1) + (sum(f1)*sum(d(w, f, 2)) + integral(w, f1, d(w, f, 3)))/12
      end associate
   end function slope

   !> The same of f g', differentiated along x once.
   pure real(dp) function mixed(w, f, g)
      type(wave_t), intent(in) :: w
      real(dp), intent(in) :: f(2), g(2)
      associate (f1 => d(w, f, 1), f2 => d(w, f, 2), g1 => d(w, g, 1), g2 => d(w, g, 2), g3 => d(w, g, 3))
         mixed = -integral(w, f, g1)/6 + (sum(f1)*sum(g1) + sum(f)*sum(g2))/24 + integral(w, f2, g1)/8 + integral(w, f, g3)/24
      end associate
   end function mixed

   !> Factors of the n-th derivative.
   pure function d(w, f, n)
      type(wave_t), intent(in) :: w
      real(dp), intent(in) :: f(2)
      integer, intent(in) :: n
      real(dp) :: d(2)
      d = f*(-w%rate)**n
   end function d

   !> Integral of the product of two sums of exponentials over the depth.
   pure real(dp) function integral(w, f, g)
      type(wave_t), intent(in) :: w
      real(dp), intent(in) :: f(2), g(2)
      integer :: i
      integral = sum([(f(i)*g/(w%rate(i) + w%rate), i=1, 2)])
   end function integral

   !> omega of the standing wave in a strip that is half a wave wide and 2.5 deep, of cells of size 1, without the error in time.
   !> The phase of the amplitude, seen through one window and through a later one, tells it; other waves are below the square of
   !> the cell size in it, and change their phase.
   real(dp) function frequency(mass, half)
      type(mass_choice_t), intent(in) :: mass
      integer, intent(in) :: half                !! cells of half a wave
      real(dp), parameter :: dt = 0.4_dp
      integer, parameter :: depth = 5            !! half waves
      type(problem_t) :: m
      real(dp), allocatable :: mode(:, :)
      real(dp) :: a, q, omega, weight, width, down, window
      complex(dp) :: seen(2)
      integer :: i, n, steps
      q = pi/half
      omega = wave%speed*q
      width = half
      down = depth*half
      call place_bodies(forest_t([0.0_dp, 0.0_dp], 1.0_dp, [half, depth*half]), &
                        new_material('', 'linear_elastic', .false., (1 + nu)*(1 - 2*nu)/(1 - nu), nu, 1.0_dp), &
                        [rectangle_t([0.0_dp, 0.0_dp], [width, down], [2*half, 2*depth*half])], m)
      call constrain_box(m%constraints, m%grid, [0.0_dp, 0.0_dp], [0.0_dp, down], [.true., .false.])
      call constrain_box(m%constraints, m%grid, [width, 0.0_dp], [width, down], [.true., .false.])
      call constrain_box(m%constraints, m%grid, [0.0_dp, down], [width, down], [.false., .true.])
      associate (p => m%particles)
         p%total_frame = .true.
         allocate (mode(p%n, 2))
         do i = 1, p%n
            mode(i, :) = motion_at(q, p%reference(i, 1), p%reference(i, 2))
         end do
         p%velocity(:p%n, :2) = mode             ! in the total frame particles stay where they are in the list
      end associate
      call start(m, 'musl', mass)
      steps = nint(4*2*pi/omega/dt)/2            ! in each window: four periods
      seen = 0
      do n = 0, 2*steps - 1
         a = sum(m%particles%velocity(:m%particles%n, :2)*mode)
         window = modulo(n, steps) + 0.5_dp
         weight = sin(pi*window/steps)**2
         i = 1 + n/steps
         seen(i) = seen(i) + weight*a*exp(cmplx(0.0_dp, -omega*dt*n, dp))
         call run_steps(m, dt, 1)
      end do
      omega = omega + aimag(log(seen(2)/seen(1)))/(steps*dt)
      frequency = 2/dt*sin(omega*dt/2)
   end function frequency

   !> The wave at the nodes, bilinear between them.
   pure function motion_at(q, x, y) result(u)
      real(dp), intent(in) :: q, x, y
      real(dp) :: u(2)
      integer :: i, j
      u = 0
      do j = floor(y), floor(y) + 1
         do i = floor(x), floor(x) + 1
            u = u + (1 - abs(x - i))*(1 - abs(y - j))*[sum(wave%u*exp(-wave%rate*q*j))*sin(q*i), &
                                                       sum(wave%v*exp(-wave%rate*q*j))*cos(q*i)]
         end do
      end do
   end function motion_at
end program test_surface_wave
