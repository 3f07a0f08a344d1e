!> The singular fields at the tip of a crack in an isotropic elastic plane (Williams 1957), which the stress intensity factors
!> multiply. Axes: the crack lies on the negative first axis and ends at the origin.
module hampm_crack_tip_field
   use hampm_kinds, only: dp, ndim
   use hampm_linear_elastic, only: linear_stress
   use hampm_material, only: material_t
   implicit none
   private
   public :: modes, effective_modulus, tip_gradient, tip_stress, tip_opening, kolosov

   integer, parameter :: modes = 2               !! opening (I) and in-plane shear (II)
   real(dp), parameter :: pi = acos(-1.0_dp)

contains

   !> E' of J = (K_I**2 + K_II**2)/E' [Pa]: E in plane stress, E/(1 - nu**2) in plane strain.
   pure real(dp) function effective_modulus(material) result(modulus)
      type(material_t), intent(in) :: material
      modulus = material%plane_modulus()
   end function effective_modulus

   !> Displacement gradient for a unit stress intensity factor of a mode [1/(Pa sqrt(m))]:
   !>
   !>    u = sqrt(r/(2 pi)) g(theta)/(2 mu),
   !>    mode I:  g = (kappa - cos theta) (cos theta/2, sin theta/2),
   !>    mode II: g = ((kappa + 2 + cos theta) sin theta/2, -(kappa - 2 + cos theta) cos theta/2).
   pure function tip_gradient(material, mode, x) result(gradient)
      type(material_t), intent(in) :: material
      integer, intent(in) :: mode
      real(dp), intent(in) :: x(ndim)            !! place, not the tip itself [m]
      real(dp) :: gradient(ndim, ndim)
      real(dp) :: r, c, s, half_c, half_s, kappa, g(ndim), slope(ndim)
      kappa = kolosov(material)
      r = norm2(x)
      c = x(1)/r
      s = x(2)/r
      half_c = cos(atan2(x(2), x(1))/2)
      half_s = sin(atan2(x(2), x(1))/2)
      if (mode == 1) then
         g = (kappa - c)*[half_c, half_s]
         slope = 0.5_dp*(kappa - c)*[-half_s, half_c] + s*[half_c, half_s]
      else
         g = [(kappa + 2 + c)*half_s, -(kappa - 2 + c)*half_c]
         slope = [0.5_dp*(kappa + 2 + c)*half_c - s*half_s, 0.5_dp*(kappa - 2 + c)*half_s + s*half_c]
      end if
      gradient(:, 1) = 0.5_dp*g*c - slope*s
      gradient(:, 2) = 0.5_dp*g*s + slope*c
      gradient = gradient/(2*material%mu*sqrt(2*pi*r))
   end function tip_gradient

   !> Stress of a displacement gradient at small strain [Pa].
   pure function tip_stress(material, gradient) result(stress)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: gradient(ndim, ndim)
      real(dp) :: stress(ndim, ndim)
      real(dp) :: kappa
      kappa = kolosov(material)
      stress = linear_stress(material%mu*(3 - kappa)/(kappa - 1), material%mu, gradient)
   end function tip_stress

   !> Opening behind the tip for a unit K_I [sqrt(m)/Pa]: 8/E' sqrt(r/(2 pi)). K_II opens nothing.
   pure real(dp) function tip_opening(material, r)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: r                  !! distance from the tip [m]
      tip_opening = 8/effective_modulus(material)*sqrt(r/(2*pi))
   end function tip_opening

   !> Kolosov's constant kappa of the plane condition [-].
   pure real(dp) function kolosov(material)
      type(material_t), intent(in) :: material
      if (material%plane_stress) then
         kolosov = (3 - material%poisson)/(1 + material%poisson)
      else
         kolosov = 3 - 4*material%poisson
      end if
   end function kolosov
end module hampm_crack_tip_field
