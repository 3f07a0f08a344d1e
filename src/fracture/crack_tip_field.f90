!> Singular fields at a crack tip in an elastic plane, multiplied by the stress intensity factors (Sih, Paris & Irwin 1965), with
!> the roots s_1, s_2 of Lekhnitskii's equation, and G. The crack lies on the negative first axis and ends at the origin. With the
!> compliances a_ij in these axes, and Im s_1, Im s_2 > 0,
!>
!>    a_11 s**4 - 2 a_16 s**3 + (2 a_12 + a_66) s**2 - 2 a_26 s + a_22 = 0,   z(s) = x + s y,   w = (p, q),
!>    p(s) = a_11 s**2 + a_12 - a_16 s,   q(s) = a_12 s + a_22/s - a_26,   and for unit K_I, K_II
!>    u_i = sqrt(2/pi) Re[ (s_1 w_i(s_2) sqrt(z_2) - s_2 w_i(s_1) sqrt(z_1))/(s_1 - s_2) ],
!>    u_i = sqrt(2/pi) Re[ (w_i(s_2) sqrt(z_2) - w_i(s_1) sqrt(z_1))/(s_1 - s_2) ].
!>
!> For nearly equal roots these divided differences become derivatives at their middle, isotropic, s = i: Williams (1957). G =
!> sum_mn K_m Y_mn K_n, isotropic Y = I/E'; opening and sliding r behind the tip = 8 sqrt(r/(2 pi)) sum_n Y_mn K_n.
module hampm_crack_tip_field
   use hampm_kinds, only: dp, ndim
   use hampm_material, only: material_t
   use hampm_moving_tip, only: energy_factors
   use hampm_orthotropic, only: turned_stiffness, turned_compliance, voigt_stress
   use hampm_tensors, only: n_voigt
   implicit none
   private
   public :: modes, tip_field_t, new_tip_field, new_interface_fields, let_run

   integer, parameter :: modes = 2               !! opening (I) and in-plane shear (II)
   real(dp), parameter :: pi = acos(-1.0_dp)

   !> Relative difference of roots below which they are taken as one: the error of the derivative is of its square, the rounding of
   !> the difference epsilon over it.
   real(dp), parameter :: same = 3.0e-5_dp

   real(dp), parameter :: same_rate = 1e-6_dp    !! well above the rounding of the field of nearly equal roots, 1e-10

   !> A tip in a material.
   type :: tip_field_t
      private
      complex(dp) :: root(2) = 0                 !! s_1 and s_2, both in the middle between them where they are nearly the same [-]
      logical :: apart = .false.                 !! whether they are not
      complex(dp) :: w(ndim, modes, 2) = 0       !! w of each root, mode I over s, times the mode's factor without sqrt(2 pi) [1/Pa]
      complex(dp) :: dw(ndim, modes) = 0         !! and its derivative with respect to the first [1/Pa]
      real(dp) :: compliance(n_voigt, n_voigt) = 0 !! a in the axes of the crack [1/Pa]
      real(dp) :: stiffness(n_voigt, n_voigt) = 0 !! its inverse [Pa]
      real(dp) :: rate(modes, modes) = 0         !! Y [1/Pa]
      ! Of a tip that runs in isotropic material
      logical, public :: is_running = .false.
      real(dp) :: speed = 0                      !! [m/s]
      real(dp) :: density = 0                    !! [kg/m3]
      real(dp) :: a(2) = 1                       !! a_d and a_s [-]
      real(dp) :: over = 0                       !! sqrt(2 pi) mu D [Pa]
      ! Of a tip between two materials: on one side of it
      logical, public :: is_at_interface = .false.
      real(dp), public :: oscillation = 0        !! eps [-]
      real(dp), public :: part_of_opening = 0.5_dp !! this side's part of the opening [-]
      real(dp) :: length = 1                     !! l [m]
      real(dp) :: part = 0.5_dp                  !! p [-]
      real(dp) :: kappa = 0                      !! (lambda + 3 mu)/(lambda + mu) in the plane [-]
      real(dp) :: mu = 0                         !! [Pa]
   contains
      procedure :: gradient
      procedure :: inertia
      procedure :: gradient_of_force
      procedure :: stress
      procedure :: opening_of_force
      procedure :: stress_along
      procedure :: opening
      procedure :: rate_of
      procedure :: modes_couple
      procedure :: narrowing
      procedure :: widening
      procedure :: intensities_of
      procedure :: of_rate
      procedure :: shares
      procedure :: typical_intensities
   end type tip_field_t

contains

   !> The field at a tip.
   pure type(tip_field_t) function new_tip_field(material, direction) result(field)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: direction(ndim)    !! unit vector out of the crack
      real(dp) :: angle                          ! of the direction of the crack from x [degrees]
      complex(dp) :: product
      angle = atan2(direction(2), direction(1))*180/pi
      field%compliance = turned_compliance(material%in_its_axes, material%angle - angle)
      field%stiffness = turned_stiffness(material%stiffness, -angle)
      field%root = turned_roots(roots_in_axes(material%in_its_axes), material%angle - angle)
      product = field%root(1)*field%root(2)
      associate (a => field%compliance)
         field%rate(1, 1) = -a(2, 2)*aimag(sum(field%root)/product)/2
         field%rate(2, 2) = a(1, 1)*aimag(sum(field%root))/2
         field%rate(1, 2) = a(1, 1)*aimag(product)/2
         field%rate(2, 1) = field%rate(1, 2)
      end associate
      call find_factors(field)
   end function new_tip_field

   !> Make a tip in isotropic material run, below the speed of Rayleigh waves.
   pure subroutine let_run(field, material, speed)
      type(tip_field_t), intent(inout) :: field
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: speed              !! [m/s]
      real(dp) :: factors(modes)
      factors = energy_factors(material, speed)
      field%is_running = material%isotropic .and. .not. field%is_at_interface .and. any(factors > 1) &
                         .and. .not. any(factors >= huge(speed))
      if (.not. field%is_running) return
      field%speed = speed
      field%density = material%density
      field%a = sqrt(1 - (speed/[material%dilatational_wave_speed(), material%shear_wave_speed()])**2)
      field%over = sqrt(2*pi)*material%mu*(4*product(field%a) - (1 + field%a(2)**2)**2)
      field%rate(1, 1) = factors(1)*field%rate(1, 1)
      field%rate(2, 2) = factors(2)*field%rate(2, 2)
   end subroutine let_run

   !> The fields above and below a tip between two isotropic materials, with oscillating stress and opening (Williams 1959; Rice &
   !> Sih 1965; Rice 1988). In complex numbers, with K at a length l, mu above and mu' below,
   !>
   !>    s_22 + i s_12 = K (r/l)**(i eps)/sqrt(2 pi r) ahead,   K = K_1 + i K_2,   u = u_1 + i u_2,
   !>    2 mu u,1 = kappa f - g - 2 i y conj(f'),   2 mu u,2 = i (kappa f + g - 2 conj(f) + 2 i y conj(f')),
   !>    f = p conj(K) (z/l)**(-i eps)/sqrt(2 pi z),   g = (1 - p) conj(K) (conj(z)/l)**(-i eps)/sqrt(2 pi conj(z)),
   !>    p = exp(-pi eps)/(2 cosh(pi eps)) above, 1 - p below,   2 pi eps = log((kappa/mu + 1/mu')/(kappa'/mu' + 1/mu)),
   !>    [u_2] + i [u_1] = 8 K sqrt(r/(2 pi)) (r/l)**(i eps)/((1 + 2 i eps) E* cosh(pi eps)),
   !>    Y = 1/(E* cosh(pi eps)**2),   2/E* = 1/E' + 1/E''.
   pure function new_interface_fields(above, below, direction, length) result(fields)
      type(material_t), intent(in) :: above, below
      real(dp), intent(in) :: direction(ndim)    !! unit vector out of the crack, above to the left of it
      real(dp), intent(in) :: length             !! reference length of K [m]
      type(tip_field_t) :: fields(2)
      real(dp) :: compliance(2)                  ! 1/E'
      fields = [new_tip_field(above, direction), new_tip_field(below, direction)]
      fields%is_at_interface = .true.
      fields%length = length
      fields%mu = [above%mu, below%mu]
      fields%kappa = [above%small_strain_lambda(), below%small_strain_lambda()]/fields%mu
      fields%kappa = (fields%kappa + 3)/(fields%kappa + 1)
      compliance = (fields%kappa + 1)/(8*fields%mu)
      fields%oscillation = log((fields(1)%kappa/above%mu + 1/below%mu)/(fields(2)%kappa/below%mu + 1/above%mu))/(2*pi)
      fields%part = 1/(1 + exp([2, -2]*pi*fields%oscillation))
      fields%part_of_opening = compliance/sum(compliance)
      fields%rate(1, 1) = sum(compliance)/2/cosh(pi*fields%oscillation)**2
      fields%rate(2, 2) = fields%rate(1, 1)
   end function new_interface_fields

   !> The roots in the axes of the material: with L = sqrt(a_22/a_11) and S = sqrt((2 a_12 + a_66)/a_11 + 2 L) their sum is i S and
   !> their product -L.
   pure function roots_in_axes(a) result(root)
      real(dp), intent(in) :: a(n_voigt, n_voigt)
      complex(dp) :: root(2)
      real(dp) :: l, s
      complex(dp) :: half
      l = sqrt(a(2, 2)/a(1, 1))
      s = sqrt((2*a(1, 2) + a(3, 3))/a(1, 1) + 2*l)
      half = sqrt(cmplx(4*l - s**2, 0, dp))/2
      root = cmplx(0, s/2, dp) + [half, -half]
   end function roots_in_axes

   !> The roots in axes turned by an angle against the material's.
   pure function turned_roots(root, angle) result(turned)
      complex(dp), intent(in) :: root(2)
      real(dp), intent(in) :: angle              !! [degrees]
      complex(dp) :: turned(2)
      associate (c => cos(angle*pi/180), s => sin(angle*pi/180))
         turned = (root*c + s)/(c - root*s)
      end associate
   end function turned_roots

   !> Find the factors of the displacement gradients: w of the roots, divided by their difference if they are distinct.
   pure subroutine find_factors(field)
      type(tip_field_t), intent(inout) :: field
      complex(dp) :: factor(modes)
      integer :: k
      factor = [field%root(1)*field%root(2), cmplx(1, 0, dp)]/sqrt(2*pi)
      field%apart = abs(field%root(1) - field%root(2)) > same*abs(field%root(1))
      if (field%apart) factor = factor/(field%root(1) - field%root(2))
      if (.not. field%apart) field%root = sum(field%root)/2
      associate (a => field%compliance, s => field%root, w => field%w, dw => field%dw)
         do k = 1, 2
            w(:2, 2, k) = [a(1, 1)*s(k)**2 + a(1, 2) - a(1, 3)*s(k), a(1, 2)*s(k) + a(2, 2)/s(k) - a(2, 3)]
            w(:, 1, k) = w(:, 2, k)/s(k)
         end do
         dw(:2, 2) = [2*a(1, 1)*s(1) - a(1, 3), a(1, 2) - a(2, 2)/s(1)**2]
         dw(:, 1) = (dw(:, 2) - w(:, 1, 1))/s(1)
         do k = 1, modes
            w(:, k, :) = factor(k)*w(:, k, :)
            dw(:, k) = factor(k)*dw(:, k)
         end do
      end associate
   end subroutine find_factors

   !> Displacement gradient for a unit stress intensity factor of a mode: the divided difference of w_i z,j/sqrt(z), or the
   !> derivative with opposite sign [1/(Pa sqrt(m))].
   pure function gradient(self, mode, x)
      class(tip_field_t), intent(in) :: self
      integer, intent(in) :: mode
      real(dp), intent(in) :: x(ndim)            !! place, not the tip itself [m]
      real(dp) :: gradient(ndim, ndim)
      complex(dp) :: z, over_root(2), f(ndim), difference(ndim)
      integer :: k
      if (self%is_running) then
         gradient = of_running(self, mode, 0, x)
         return
      else if (self%is_at_interface) then
         gradient = gradient_at_interface(self, mode, x)
         return
      end if
      do k = 1, merge(2, 1, self%apart)
         z = sqrt(cmplx(x(1) + real(self%root(k), dp)*x(2), aimag(self%root(k))*x(2), dp)) ! a signed zero gives the face
         over_root(k) = conjg(z)/(real(z, dp)**2 + aimag(z)**2)
      end do
      f = self%w(:, mode, 1)*over_root(1)
      if (self%apart) then
         difference = self%w(:, mode, 2)*over_root(2)
         gradient(:, 1) = real(difference - f, dp)
         gradient(:, 2) = real(self%root(2)*difference - self%root(1)*f, dp)
      else
         difference = f*over_root(1)**2*(x(2)/2) - self%dw(:, mode)*over_root(1)
         gradient(:, 1) = real(difference, dp)
         gradient(:, 2) = real(self%root(1)*difference - f, dp)
      end if
   end function gradient

   !> Displacement gradient of a unit K of a mode of a running tip, for f = z**(-1/2) with z_k = x + i a_k y; for another power of z
   !> of a field that is its derivative, up to a factor.
   pure function of_running(self, mode, more, x) result(gradient)
      class(tip_field_t), intent(in) :: self
      integer, intent(in) :: mode, more          !! more: -1/2 less the power
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: gradient(ndim, ndim)
      complex(dp) :: f(2), z
      integer :: k
      do k = 1, 2
         z = cmplx(x(1), self%a(k)*x(2), dp)
         f(k) = 1/(sqrt(z)*z**more)              ! with the sign of a zero, for the face of the crack
      end do
      gradient = 0
      associate (d => self%a(1), s => self%a(2), re => real(f, dp), im => aimag(f))
         associate (both => 1 + s**2)
            if (mode == 1) then
               gradient(1, :2) = [both*re(1) - 2*d*s*re(2), 2*d*s**2*im(2) - both*d*im(1)]
               gradient(2, :2) = -d*[both*im(1) - 2*im(2), both*d*re(1) - 2*s*re(2)]
            else
               gradient(1, :2) = s*[2*im(1) - both*im(2), 2*d*re(1) - both*s*re(2)]
               gradient(2, :2) = [2*d*s*re(1) - both*re(2), both*s*im(2) - 2*d**2*s*im(1)]
            end if
         end associate
      end associate
      gradient = gradient/self%over
   end function of_running

   !> Its density times acceleration, rho v**2 u,11: the divergence of its stress [1/(m**2 sqrt(m))].
   pure function inertia(self, mode, x)
      class(tip_field_t), intent(in) :: self
      integer, intent(in) :: mode
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: inertia(ndim), change(ndim, ndim)
      change = of_running(self, mode, 1, x)
      inertia = -self%density*self%speed**2/2*change(:, 1)
   end function inertia

   !> The same on one side of an interface.
   pure function gradient_at_interface(self, mode, x) result(gradient)
      type(tip_field_t), intent(in) :: self
      integer, intent(in) :: mode
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: gradient(ndim, ndim)
      complex(dp), parameter :: i = (0.0_dp, 1.0_dp)
      complex(dp) :: z, f, g, slope, u(ndim)
      z = cmplx(x(1), x(2), dp)
      f = unit_of(mode)*over_root(self, z)
      g = (1 - self%part)*unit_of(mode)*over_root(self, conjg(z))
      slope = 2*i*x(2)*conjg(-self%part*f*cmplx(0.5_dp, self%oscillation, dp)/z)
      f = self%part*f
      u(1) = (self%kappa*f - g - slope)/(2*self%mu)
      u(2) = i*(self%kappa*f + g - 2*conjg(f) + slope)/(2*self%mu)
      gradient(1, :) = real(u, dp)
      gradient(2, :) = aimag(u)
   end function gradient_at_interface

   !> conj(K) of a unit K of a mode at an interface.
   pure complex(dp) function unit_of(mode)
      integer, intent(in) :: mode
      unit_of = merge((1.0_dp, 0.0_dp), (0.0_dp, -1.0_dp), mode == 1)
   end function unit_of

   !> (z/l)**(-i eps)/sqrt(2 pi z), with the sign of a zero of its imaginary part.
   pure complex(dp) function over_root(self, z)
      type(tip_field_t), intent(in) :: self
      complex(dp), intent(in) :: z               !! [m]
      over_root = exp(cmplx(-0.5_dp, -self%oscillation, dp)*log(z/self%length))/sqrt(2*pi*self%length)
   end function over_root

   !> Displacement gradient of a unit force over the thickness on the tip along the crack, with free faces: the divided difference
   !> of w_i z,j/z, or the derivative (Lekhnitskii 1963). Its isotropic stress is -cos(theta)/(pi r) along the radius [m/N].
   pure function gradient_of_force(self, x) result(gradient)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: x(ndim)            !! place, not the tip itself [m]
      real(dp) :: gradient(ndim, ndim)
      complex(dp) :: z(2), f(ndim, 2), difference(ndim)
      integer :: k
      z = cmplx(x(1) + real(self%root, dp)*x(2), aimag(self%root)*x(2), dp)
      do k = 1, 2
         f(:, k) = cmplx(0, 1/sqrt(2*pi), dp)*self%w(:, 2, k)/z(k)
      end do
      if (self%apart) then
         gradient(:, 1) = real(f(:, 1) - f(:, 2), dp)
         gradient(:, 2) = real(self%root(1)*f(:, 1) - self%root(2)*f(:, 2), dp)
      else
         difference = (cmplx(0, 1/sqrt(2*pi), dp)*self%dw(:, 2) - f(:, 1)*x(2))/z(1)
         gradient(:, 1) = real(difference, dp)
         gradient(:, 2) = real(self%root(1)*difference + f(:, 1), dp)
      end if
   end function gradient_of_force

   !> Opening of the faces by that force, the same everywhere: the body ahead turns [m2/N].
   pure real(dp) function opening_of_force(self)
      class(tip_field_t), intent(in) :: self
      opening_of_force = self%compliance(2, 2)*real(1/(self%root(1)*self%root(2)), dp) - self%compliance(1, 2)
   end function opening_of_force

   !> Stress of a displacement gradient at small strain [Pa].
   pure function stress(self, h)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp) :: stress(ndim, ndim)
      stress = voigt_stress(self%stiffness, h)
   end function stress

   !> Stress along the crack of a strain along it and the stresses s_12 and s_22 of its faces [Pa].
   pure elemental real(dp) function stress_along(self, strain, s_12, s_22)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: strain             !! [-]
      real(dp), intent(in) :: s_12, s_22         !! [Pa]
      associate (a => self%compliance)
         stress_along = (strain - a(1, 2)*s_22 - a(1, 3)*s_12)/a(1, 1)
      end associate
   end function stress_along

   !> Opening (1) or sliding (2) behind the tip for a unit stress intensity factor of a mode [sqrt(m)/Pa].
   pure real(dp) function opening(self, component, mode, r)
      class(tip_field_t), intent(in) :: self
      integer, intent(in) :: component, mode
      real(dp), intent(in) :: r                  !! distance from the tip [m]
      complex(dp) :: both                        ! opening + i sliding
      opening = 8*self%rate(component, mode)*sqrt(r/(2*pi))
      if (.not. (self%is_at_interface .and. r > 0)) return
      both = 8*self%rate(1, 1)*cosh(pi*self%oscillation)*sqrt(r/(2*pi))*conjg(unit_of(mode))/cmplx(1, 2*self%oscillation, dp) &
             *exp(cmplx(0, self%oscillation*log(r/self%length), dp))
      opening = merge(real(both, dp), aimag(both), component == 1)
   end function opening

   !> G of stress intensity factors [J/m2].
   pure real(dp) function rate_of(self, k)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: k(modes)           !! [Pa sqrt(m)]
      rate_of = dot_product(k, matmul(self%rate, k))
   end function rate_of

   !> Whether modes are coupled: G has a mixed term if a crack lies across the axes of a material; at an interface both modes
   !> oscillate.
   pure logical function modes_couple(self)
      class(tip_field_t), intent(in) :: self
      associate (y => self%rate)
         modes_couple = abs(y(1, 2)) > same_rate*(y(1, 1) + y(2, 2)) .or. self%is_at_interface
      end associate
   end function modes_couple

   !> Narrowing of the field across the crack against isotropic material: the larger imaginary part of the roots, as the field of
   !> each is one of x + s y [-].
   pure real(dp) function narrowing(self)
      class(tip_field_t), intent(in) :: self
      narrowing = maxval(aimag(self%root))
   end function narrowing

   !> How many times as far as in isotropic material the faces slide at the same K_II, over the compliance along them: mean of the
   !> imaginary parts of the roots [-].
   pure real(dp) function widening(self)
      class(tip_field_t), intent(in) :: self
      widening = sum(aimag(self%root))/size(self%root)
   end function widening

   !> Stress intensity factors from the interactions 2 sum_n Y_mn K_n with fields of unit K, divided by `over` [Pa sqrt(m)].
   pure function intensities_of(self, interaction, over) result(k)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: interaction(modes)
      real(dp), intent(in) :: over               !! factor in the interactions
      real(dp) :: k(modes)
      associate (y => self%rate)
         k = [y(2, 2)*interaction(1) - y(1, 2)*interaction(2), y(1, 1)*interaction(2) - y(1, 2)*interaction(1)] &
             /(2*over*(y(1, 1)*y(2, 2) - y(1, 2)**2))
      end associate
   end function intensities_of

   !> Stress intensity factors with the ratio of given ones and the size of G, of any sign: k may be rounding alone [Pa sqrt(m)].
   pure function of_rate(self, k, g)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: k(modes)           !! [Pa sqrt(m)]
      real(dp), intent(in) :: g                  !! [J/m2]
      real(dp) :: of_rate(modes)
      of_rate = k
      if (self%rate_of(k) > 0) of_rate = k*sqrt(abs(g)/self%rate_of(k))
   end function of_rate

   !> Share of each mode in G, with the sum 1: work of the tractions across the crack on its opening, and along it on its sliding.
   !> In an anisotropic material, where each K opens and slides the faces, one may be below 0.
   pure function shares(self, k) result(part)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: k(modes)           !! not both 0 [Pa sqrt(m)]
      real(dp) :: part(modes)
      part = k*matmul(self%rate, k)/self%rate_of(k)
   end function shares

   !> Sizes of the stress intensity factors that go with parts of G by mode [Pa sqrt(m)]; where modes couple as if they did not.
   pure function typical_intensities(self, g) result(k)
      class(tip_field_t), intent(in) :: self
      real(dp), intent(in) :: g(modes)           !! [J/m2]
      real(dp) :: k(modes)
      k = sqrt(abs(g)/[self%rate(1, 1), self%rate(2, 2)])
   end function typical_intensities
end module hampm_crack_tip_field
