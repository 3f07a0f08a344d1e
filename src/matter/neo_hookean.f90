!> Compressible neo-Hookean elasticity for any rotation and stretch:
!>
!>    W = mu/2 (tr b - 3 - 2 ln J) + lambda/2 (ln J)**2,    b = F F^T,
!>    Kirchhoff stress tau = mu (b - I) + lambda ln J I.
!>
!> For small strains it is linear elasticity with the same lambda and mu. In plane strain F_33 = 1. In plane stress
!> F_33 follows from tau_33 = mu (F_33**2 - 1) + lambda ln(J_2 F_33) = 0, J_2 being the determinant in the plane; with
!> y = ln F_33 the left side rises and is convex in y, so that Newton's iteration always converges.
!> (Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed., section 6.4.3.)
module hampm_neo_hookean
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: determinant, trace, identity, inverse_transpose
   implicit none
   private
   public :: neo_hookean_kirchhoff, neo_hookean_energy_density, neo_hookean_first_piola, neo_hookean_piola_change

contains

   !> Kirchhoff stress [Pa]. Zero where the material is turned inside out (det F <= 0), which the caller notices.
   pure function neo_hookean_kirchhoff(lambda, mu, plane_stress, h) result(tau)
      real(dp), intent(in) :: lambda             !! Lame constant of the solid [Pa]
      real(dp), intent(in) :: mu                 !! shear modulus [Pa]
      logical, intent(in) :: plane_stress        !! else plane strain
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp) :: tau(ndim, ndim)
      real(dp) :: log_j
      tau = 0
      if (turned_over(h)) return
      log_j = log_plane(h)
      log_j = log_j + log_thickness(lambda, mu, plane_stress, log_j)
      ! b - I = H + H^T + H H^T keeps the digits of a small strain
      tau = mu*(h + transpose(h) + matmul(h, transpose(h))) + lambda*log_j*identity
   end function neo_hookean_kirchhoff

   !> First Piola stress tau F^-T [Pa], conjugate to H.
   pure function neo_hookean_first_piola(lambda, mu, plane_stress, h) result(piola)
      real(dp), intent(in) :: lambda, mu, h(ndim, ndim)
      logical, intent(in) :: plane_stress
      real(dp) :: piola(ndim, ndim)
      piola = 0
      if (turned_over(h)) return
      piola = matmul(neo_hookean_kirchhoff(lambda, mu, plane_stress, h), inverse_transpose(identity + h))
   end function neo_hookean_first_piola

   !> Change of the first Piola stress P = mu (F - F^-T) + lambda ln J F^-T by a small change of H [Pa]:
   !>
   !>    dP = mu dF + (mu - lambda ln J) F^-T dF^T F^-T + lambda d(ln J) F^-T,
   !>    d(ln J) = (1 + dy/d(ln J_2)) F^-T : dF,   dy/d(ln J_2) = -lambda/(2 mu exp(2 y) + lambda) in plane stress, else 0.
   !>
   !> Zero where the material is turned inside out.
   pure function neo_hookean_piola_change(lambda, mu, plane_stress, h, dh) result(change)
      real(dp), intent(in) :: lambda, mu, h(ndim, ndim)
      logical, intent(in) :: plane_stress
      real(dp), intent(in) :: dh(ndim, ndim)     !! change of the displacement gradient [-]
      real(dp) :: change(ndim, ndim)
      real(dp) :: inverse(ndim, ndim), log_j, y, part
      change = 0
      if (turned_over(h)) return
      inverse = inverse_transpose(identity + h)
      log_j = log_plane(h)
      y = log_thickness(lambda, mu, plane_stress, log_j)
      part = 1
      if (plane_stress) part = 2*mu*exp(2*y)/(2*mu*exp(2*y) + lambda)
      change = mu*dh + (mu - lambda*(log_j + y))*matmul(inverse, matmul(transpose(dh), inverse)) &
               + lambda*part*sum(inverse*dh)*inverse
   end function neo_hookean_piola_change

   !> Energy per reference volume [J/m3].
   pure real(dp) function neo_hookean_energy_density(lambda, mu, plane_stress, h) result(energy)
      real(dp), intent(in) :: lambda, mu, h(ndim, ndim)
      logical, intent(in) :: plane_stress
      real(dp) :: y, log_j, distortion, x
      energy = 0
      if (turned_over(h)) return
      log_j = log_plane(h)
      y = log_thickness(lambda, mu, plane_stress, log_j)
      log_j = log_j + y
      ! tr(b) - 3 - 2 ln J is of the second order in H: terms of the first cancel before they are computed
      x = trace(h) + determinant(h)              ! det(I + H) - 1
      distortion = (h(1, 1) - h(2, 2))**2 + (h(1, 2) + h(2, 1))**2 + 2*beyond_log(x) + beyond_exp(2*y)
      energy = 0.5_dp*mu*distortion + 0.5_dp*lambda*log_j**2
   end function neo_hookean_energy_density

   !> Whether det F <= 0.
   pure logical function turned_over(h)
      real(dp), intent(in) :: h(ndim, ndim)
      turned_over = .not. determinant(identity + h) > 0
   end function turned_over

   !> ln det(I + H), with all digits of a small H.
   pure real(dp) function log_plane(h)
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp) :: x, one_plus_x
      x = trace(h) + determinant(h)              ! det(I + H) - 1
      one_plus_x = 1 + x
      log_plane = x
      if (abs(one_plus_x - 1) > 0) log_plane = log(one_plus_x)*(x/(one_plus_x - 1))
   end function log_plane

   !> exp(x) - 1 with all digits of a small x.
   pure real(dp) function exp_minus_one(x)
      real(dp), intent(in) :: x
      exp_minus_one = 2*sinh(x/2)*exp(x/2)
   end function exp_minus_one

   !> x - ln(1 + x) with all digits of a small x: with s = x/(2 + x), ln(1 + x) = 2 (s + s**3/3 + s**5/5 + ...).
   pure real(dp) function beyond_log(x)
      real(dp), intent(in) :: x
      real(dp) :: s, rest
      integer :: k
      if (abs(x) > 0.1_dp) then
         beyond_log = x - log(1 + x)
         return
      end if
      s = x/(2 + x)
      rest = 0
      do k = 13, 3, -2
         rest = s**2*(rest + 1.0_dp/k)
      end do
      beyond_log = x*s - 2*s*rest
   end function beyond_log

   !> exp(x) - 1 - x with all digits of a small x.
   pure real(dp) function beyond_exp(x)
      real(dp), intent(in) :: x
      integer :: k
      if (abs(x) > 0.1_dp) then
         beyond_exp = exp_minus_one(x) - x
         return
      end if
      beyond_exp = 0
      do k = 11, 2, -1
         beyond_exp = x/k*(1 + beyond_exp)
      end do
      beyond_exp = x*beyond_exp
   end function beyond_exp

   !> y = ln F_33 from mu (exp(2 y) - 1) + lambda (ln J_2 + y) = 0; 0 in plane strain.
   pure real(dp) function log_thickness(lambda, mu, plane_stress, log_j_plane) result(y)
      real(dp), intent(in) :: lambda, mu, log_j_plane
      logical, intent(in) :: plane_stress
      integer, parameter :: most_iterations = 50
      real(dp) :: stress, slope, change
      integer :: k
      y = 0
      if (.not. plane_stress) return
      do k = 1, most_iterations
         stress = mu*exp_minus_one(2*y) + lambda*(log_j_plane + y)
         slope = 2*mu*exp(2*y) + lambda
         change = -stress/slope
         y = y + change
         if (abs(change) <= 4*epsilon(y)*abs(y)) exit
      end do
   end function log_thickness
end module hampm_neo_hookean
