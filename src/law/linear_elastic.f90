!> Isotropic linear elasticity for small strains: stress = lambda tr(eps) I + 2 mu eps, eps = sym(H).
!>
!> In plane strain eps_33 = 0. In plane stress eps_33 follows from stress_33 = 0, which leaves the same form with
!> lambda' = 2 lambda mu / (lambda + 2 mu). Rotations count as strain to second order: the law is meant for
!> displacement gradients below `small_gradient`; larger ones are for `hampm_neo_hookean`.
module hampm_linear_elastic
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: trace
   implicit none
   private
   public :: linear_stress, linear_energy_density, linear_stress_energy_density, small_gradient

   real(dp), parameter :: small_gradient = 0.05_dp   !! largest |H| for which this law is meant [-]

contains

   !> Stress [Pa].
   pure function linear_stress(lambda, mu, h) result(stress)
      real(dp), intent(in) :: lambda             !! Lame constant, lambda' in plane stress [Pa]
      real(dp), intent(in) :: mu                 !! shear modulus [Pa]
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp) :: stress(ndim, ndim)
      real(dp) :: pressure
      integer :: i, j
      pressure = lambda*trace(h)
      do j = 1, ndim
         do i = 1, ndim
            stress(i, j) = mu*(h(i, j) + h(j, i))
         end do
         stress(j, j) = stress(j, j) + pressure
      end do
   end function linear_stress

   !> Energy density stress : eps / 2 [J/m3].
   pure real(dp) function linear_energy_density(lambda, mu, h)
      real(dp), intent(in) :: lambda, mu, h(ndim, ndim)
      linear_energy_density = 0.5_dp*sum(linear_stress(lambda, mu, h)*h)
   end function linear_energy_density

   !> Energy density of a stress, stress : eps / 2 [J/m3].
   pure real(dp) function linear_stress_energy_density(lambda, mu, stress) result(density)
      real(dp), intent(in) :: lambda, mu         !! as in `linear_stress` [Pa]
      real(dp), intent(in) :: stress(ndim, ndim) !! symmetric [Pa]
      density = (sum(stress**2) - lambda/(2*mu + ndim*lambda)*trace(stress)**2)/(4*mu)
   end function linear_stress_energy_density
end module hampm_linear_elastic
