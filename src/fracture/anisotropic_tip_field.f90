!> The singular fields at the tip of a crack in an anisotropic elastic plane (Sih, Paris & Irwin 1965), by the roots s_1 and s_2 of
!> Lekhnitskii's equation. Axes: the crack lies on the negative first axis and ends at the origin.
!>
!> With the compliances a_ij in these axes,
!>
!>    a_11 s**4 - 2 a_16 s**3 + (2 a_12 + a_66) s**2 - 2 a_26 s + a_22 = 0,   Im s_1, Im s_2 > 0,
!>    p(s) = a_11 s**2 + a_12 - a_16 s,   q(s) = a_12 s + a_22/s - a_26,   z(s) = x + s y,
!>    u_i = sqrt(2/pi) Re[ (s_1 w_i(s_2) sqrt(z_2) - s_2 w_i(s_1) sqrt(z_1))/(s_1 - s_2) ]    of a unit K_I,   w = (p, q),
!>    u_i = sqrt(2/pi) Re[ (w_i(s_2) sqrt(z_2) - w_i(s_1) sqrt(z_1))/(s_1 - s_2) ]             of a unit K_II.
!>
!> Both are divided differences of a function of s. Where s_1 and s_2 are nearly the same, as they are in an isotropic material, they are
!> its derivative in the middle between them.
module hampm_anisotropic_tip_field
   use hampm_kinds, only: dp, ndim
   use hampm_material, only: material_t
   use hampm_orthotropic, only: n_voigt, inverse_of, turned_stiffness, turned_compliance, voigt_stress
   implicit none
   private
   public :: anisotropic_tip_t, new_anisotropic_tip

   integer, parameter :: modes = 2               !! opening (I) and in-plane shear (II)
   real(dp), parameter :: pi = acos(-1.0_dp)

   !> Difference of the roots over their size below which they are taken as one: what the derivative misses is of its square, what
   !> rounding leaves of the difference is epsilon over it.
   real(dp), parameter :: same = 3.0e-5_dp

   !> The constants of the field.
   type :: anisotropic_tip_t
      complex(dp) :: root(2) = 0                           !! s_1 and s_2 [-]
      real(dp) :: compliance(n_voigt, n_voigt) = 0         !! a in the axes of the crack [1/Pa]
      real(dp) :: stiffness(n_voigt, n_voigt) = 0          !! its inverse [Pa]
      real(dp) :: rate(modes, modes) = 0                   !! Y of G = sum_mn K_m Y_mn K_n [1/Pa]
   contains
      procedure :: gradient
      procedure :: stress
   end type anisotropic_tip_t

contains

   !> The field at a tip in a material.
   pure type(anisotropic_tip_t) function new_anisotropic_tip(material, direction) result(tip)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: direction(ndim)    !! unit vector out of the crack
      real(dp) :: angle                          ! of axis 1 of the material from the direction of the crack [degrees]
      complex(dp) :: product
      angle = material%angle - atan2(direction(2), direction(1))*180/pi
      tip%compliance = turned_compliance(material%in_its_axes, angle)
      tip%stiffness = turned_stiffness(inverse_of(material%in_its_axes), angle)
      tip%root = turned_roots(roots_in_axes(material%in_its_axes), angle)
      product = tip%root(1)*tip%root(2)
      associate (a => tip%compliance)
         tip%rate(1, 1) = -a(2, 2)*aimag(sum(tip%root)/product)/2
         tip%rate(2, 2) = a(1, 1)*aimag(sum(tip%root))/2
         tip%rate(1, 2) = a(1, 1)*aimag(product)/2
         tip%rate(2, 1) = tip%rate(1, 2)
      end associate
   end function new_anisotropic_tip

   !> The roots in the axes of the material: with L = sqrt(a_22/a_11) and S = sqrt((2 a_12 + a_66)/a_11 + 2 L) they have the sum i S and
   !> the product -L.
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

   !> The roots in axes from which those of the material are turned by an angle.
   pure function turned_roots(root, angle) result(turned)
      complex(dp), intent(in) :: root(2)
      real(dp), intent(in) :: angle              !! [degrees]
      complex(dp) :: turned(2)
      associate (c => cos(angle*pi/180), s => sin(angle*pi/180))
         turned = (root*c + s)/(c - root*s)
      end associate
   end function turned_roots

   !> Displacement gradient for a unit stress intensity factor of a mode [1/(Pa sqrt(m))].
   pure function gradient(self, mode, x)
      class(anisotropic_tip_t), intent(in) :: self
      integer, intent(in) :: mode
      real(dp), intent(in) :: x(ndim)            !! place, not the tip itself [m]
      real(dp) :: gradient(ndim, ndim)
      complex(dp) :: f(ndim, ndim, 2), derivative(ndim, ndim), difference(ndim, ndim)
      difference(1, 1) = self%root(1) - self%root(2)
      if (abs(difference(1, 1)) > same*abs(self%root(1))) then
         call find_terms(self, mode, x, self%root(1), f(:, :, 1), derivative)
         call find_terms(self, mode, x, self%root(2), f(:, :, 2), derivative)
         difference = (f(:, :, 2) - f(:, :, 1))/difference(1, 1)
      else
         call find_terms(self, mode, x, sum(self%root)/2, f(:, :, 1), derivative)
         difference = -derivative
      end if
      if (mode == 1) difference = self%root(1)*self%root(2)*difference
      gradient = real(difference, dp)/sqrt(2*pi)
   end function gradient

   !> Of a root: w_i z,j/sqrt(z), in mode I over s, and its derivative with respect to s.
   pure subroutine find_terms(self, mode, x, s, f, derivative)
      class(anisotropic_tip_t), intent(in) :: self
      integer, intent(in) :: mode
      real(dp), intent(in) :: x(ndim)            !! [m]
      complex(dp), intent(in) :: s
      complex(dp), intent(out) :: f(ndim, ndim), derivative(ndim, ndim)
      complex(dp) :: w(ndim), dw(ndim), z
      associate (a => self%compliance)
         w = [a(1, 1)*s**2 + a(1, 2) - a(1, 3)*s, a(1, 2)*s + a(2, 2)/s - a(2, 3)]
         dw = [2*a(1, 1)*s - a(1, 3), a(1, 2) - a(2, 2)/s**2]
      end associate
      if (mode == 1) then
         dw = (dw - w/s)/s
         w = w/s
      end if
      z = cmplx(x(1) + real(s, dp)*x(2), aimag(s)*x(2), dp)  ! with the sign of a zero: it tells the face of the crack
      f(:, 1) = w/sqrt(z)
      f(:, 2) = s*f(:, 1)
      derivative(:, 1) = (dw - w*x(2)/(2*z))/sqrt(z)
      derivative(:, 2) = f(:, 1) + s*derivative(:, 1)
   end subroutine find_terms

   !> Stress of a displacement gradient at small strain [Pa].
   pure function stress(self, h)
      class(anisotropic_tip_t), intent(in) :: self
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp) :: stress(ndim, ndim)
      stress = voigt_stress(self%stiffness, h)
   end function stress
end module hampm_anisotropic_tip_field
