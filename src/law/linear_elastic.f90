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
   public :: linear_stress, small_gradient

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
end module hampm_linear_elastic
