!> Plasticity of metals at small strain: von Mises' yield condition, the associated flow rule and linear isotropic hardening,
!>
!>    |s| <= sqrt(2/3) (yield_stress + hardening alpha),   eps_p' = gamma' s/|s|,   alpha' = sqrt(2/3) gamma',
!>
!> s being the deviator of stress = C (eps - eps_p), eps = sym(H), and alpha the equivalent plastic strain. Over a step the flow
!> rule is integrated by the implicit rule of Euler, which returns the trial stress to the yield surface: along its radius in
!> plane strain, where eps_33 = 0; by an equation for gamma in plane stress, where stress_33 = 0.
!>
!> What a particle remembers: eps_p,11, eps_p,22, eps_p,12 and alpha; eps_p,33 = -(eps_p,11 + eps_p,22). The stress of a strain that
!> has been remembered is elastic, C (eps - eps_p).
!>
!> Source: Simo & Hughes, Computational Inelasticity (1998), boxes 3.1 and 3.2, and 3.4.1 with the tangents consistent with them.
module hampm_j2_plastic
   use hampm_kinds, only: dp, ndim
   use hampm_linear_elastic, only: linear_stress, linear_stress_energy_density
   use hampm_tensors, only: identity, trace
   implicit none
   private
   public :: j2_constants_t, j2_columns, j2_equivalent, j2_follow, j2_stress, j2_change, j2_energy_density, j2_dissipation

   integer, parameter :: j2_columns = 4          !! numbers that a particle remembers
   integer, parameter :: j2_equivalent = 4       !! which of them is alpha

   real(dp), parameter :: rounding = 1.0e-13_dp  !! part of the yield stress by which a stress may be above it
   integer, parameter :: most_iterations = 50    !! of an iteration that rises to its end

   !> The constants of the law.
   type :: j2_constants_t
      real(dp) :: lambda = 0                     !! Lame constant of the solid [Pa]
      real(dp) :: mu = 0                         !! shear modulus [Pa]
      logical :: plane_stress = .true.           !! else plane strain
      real(dp) :: yield_stress = 0               !! in uniaxial tension, at first [Pa]
      real(dp) :: hardening = 0                  !! by which it rises with alpha, not negative [Pa]
   contains
      procedure :: lambda_in_plane
      procedure :: radius
   end type j2_constants_t

   !> Where a step ends.
   type :: return_t
      logical :: flows = .false.                 !! else it is elastic
      real(dp) :: gamma = 0                      !! flow of the step; in plane stress over |s| [-, 1/Pa]
      real(dp) :: trial(ndim, ndim) = 0          !! deviator of the trial stress in plane strain, else the stress at the end [Pa]
      real(dp) :: size = 0                       !! |s| of `trial` [Pa]
   end type return_t

contains

   !> Remember what flows when the displacement gradient becomes `h`.
   pure subroutine j2_follow(c, h, past)
      type(j2_constants_t), intent(in) :: c
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(inout) :: past(j2_columns)
      type(return_t) :: r
      real(dp) :: flow(ndim, ndim)
      r = returned(c, h, past)
      if (.not. r%flows) return
      if (c%plane_stress) then
         flow = r%gamma*deviator(r%trial)
         past(4) = past(4) + sqrt(2/3.0_dp)*r%gamma*r%size
      else
         flow = r%gamma/r%size*r%trial
         past(4) = past(4) + sqrt(2/3.0_dp)*r%gamma
      end if
      past(:3) = past(:3) + [flow(1, 1), flow(2, 2), flow(1, 2)]
   end subroutine j2_follow

   !> Stress of a strain that has been remembered [Pa].
   pure function j2_stress(c, h, past) result(stress)
      type(j2_constants_t), intent(in) :: c
      real(dp), intent(in) :: h(ndim, ndim), past(j2_columns)
      real(dp) :: stress(ndim, ndim)
      ! tr(eps_p) = 0 in space: what flows in the plane adds pressure to the linear stress of the rest of the strain
      stress = linear_stress(c%lambda_in_plane(), c%mu, h - plastic(past))
      if (.not. c%plane_stress) stress = stress + c%lambda*(past(1) + past(2))*identity
   end function j2_stress

   !> What a small change of H makes of the stress at the end of a step from `past` to `h`: the tangent consistent with the return
   !> [Pa].
   pure function j2_change(c, h, dh, past) result(change)
      type(j2_constants_t), intent(in) :: c
      real(dp), intent(in) :: h(ndim, ndim), dh(ndim, ndim), past(j2_columns)
      real(dp) :: change(ndim, ndim)
      type(return_t) :: r
      r = returned(c, h, past)
      if (.not. r%flows) then
         change = linear_stress(c%lambda_in_plane(), c%mu, dh)
      else if (c%plane_stress) then
         change = change_in_plane_stress(c, r, dh)
      else
         change = change_in_plane_strain(c, r, dh)
      end if
   end function j2_change

   !> Elastic energy per volume of a strain that has been remembered [J/m3].
   pure real(dp) function j2_energy_density(c, h, past) result(energy)
      type(j2_constants_t), intent(in) :: c
      real(dp), intent(in) :: h(ndim, ndim), past(j2_columns)
      real(dp) :: elastic(ndim, ndim)
      if (c%plane_stress) then
         energy = linear_stress_energy_density(c%lambda_in_plane(), c%mu, j2_stress(c, h, past))
         return
      end if
      elastic = (h + transpose(h))/2 - plastic(past)
      energy = 0.5_dp*c%lambda*trace(h)**2 + c%mu*(sum(elastic**2) + (past(1) + past(2))**2)
   end function j2_energy_density

   !> Work of the stress on the plastic strain per volume, the integral of stress : d eps_p = (yield_stress + hardening alpha) d
   !> alpha [J/m3].
   pure real(dp) function j2_dissipation(c, past) result(work)
      type(j2_constants_t), intent(in) :: c
      real(dp), intent(in) :: past(j2_columns)
      work = (c%yield_stress + c%hardening*past(4)/2)*past(4)
   end function j2_dissipation

   !> Lame constant of the linear law in the plane [Pa].
   pure real(dp) function lambda_in_plane(self)
      class(j2_constants_t), intent(in) :: self
      lambda_in_plane = self%lambda
      if (self%plane_stress) lambda_in_plane = 2*self%lambda*self%mu/(self%lambda + 2*self%mu)
   end function lambda_in_plane

   !> Radius of the yield surface in the space of deviators [Pa].
   pure real(dp) function radius(self, alpha)
      class(j2_constants_t), intent(in) :: self
      real(dp), intent(in) :: alpha              !! equivalent plastic strain [-]
      radius = sqrt(2/3.0_dp)*(self%yield_stress + self%hardening*alpha)
   end function radius

   !> Plastic strain in the plane [-].
   pure function plastic(past)
      real(dp), intent(in) :: past(j2_columns)
      real(dp) :: plastic(ndim, ndim)
      plastic = reshape([past(1), past(3), past(3), past(2)], [ndim, ndim])
   end function plastic

   !> The part in the plane of the deviator of a plane stress [Pa].
   pure function deviator(stress)
      real(dp), intent(in) :: stress(ndim, ndim)
      real(dp) :: deviator(ndim, ndim)
      deviator = stress - trace(stress)/3*identity
   end function deviator

   !> |s| of a deviator by its part in the plane [Pa].
   pure real(dp) function size_of(s)
      real(dp), intent(in) :: s(ndim, ndim)
      size_of = sqrt(sum(s**2) + trace(s)**2)
   end function size_of

   !> Return the trial stress of a step.
   pure type(return_t) function returned(c, h, past) result(r)
      type(j2_constants_t), intent(in) :: c
      real(dp), intent(in) :: h(ndim, ndim), past(j2_columns)
      real(dp) :: excess
      if (c%plane_stress) then
         call return_in_plane_stress(c, j2_stress(c, h, past), past(4), r)
         return
      end if
      r%trial = 2*c%mu*((h + transpose(h))/2 - trace(h)/3*identity - plastic(past))
      r%size = size_of(r%trial)
      excess = r%size - c%radius(past(4))
      r%flows = excess > rounding*c%radius(past(4))
      if (r%flows) r%gamma = excess/(2*c%mu + 2*c%hardening/3)
   end function returned

   !> Return a plane stress. Its parts a, b, c, the sum and difference of the normal stresses over sqrt(2) and the shear stress,
   !> fall to a/(1 + A gamma), b/(1 + 2 mu gamma) and c/(1 + 2 mu gamma), with A = 2 (lambda' + mu)/3; |s|**2 = a**2/3 + b**2 + 2
   !> c**2. The equation for gamma, |s| (1 - 2/3 hardening gamma) = radius, has a left side that falls and is convex as long as it
   !> is positive: Newton's iteration rises to the solution.
   pure subroutine return_in_plane_stress(c, trial, alpha, r)
      type(j2_constants_t), intent(in) :: c
      real(dp), intent(in) :: trial(ndim, ndim), alpha
      type(return_t), intent(inout) :: r
      real(dp) :: parts(3), fall(3), rate(3), weight(3), goal, left, slope, value, next
      integer :: k
      parts = [trial(1, 1) + trial(2, 2), trial(2, 2) - trial(1, 1), sqrt(2.0_dp)*trial(1, 2)]/sqrt(2.0_dp)
      weight = [1/3.0_dp, 1.0_dp, 2.0_dp]
      rate = [2*(c%lambda_in_plane() + c%mu)/3, 2*c%mu, 2*c%mu]
      goal = c%radius(alpha)
      r%trial = trial
      r%size = sqrt(sum(weight*parts**2))
      r%flows = r%size > (1 + rounding)*goal
      if (.not. r%flows) return
      do k = 1, most_iterations
         fall = 1/(1 + rate*r%gamma)
         value = sqrt(sum(weight*(parts*fall)**2))
         left = 1 - 2*c%hardening*r%gamma/3
         slope = -sum(weight*rate*(parts*fall)**2*fall)/value*left - 2*c%hardening/3*value
         next = r%gamma - (value*left - goal)/slope
         if (.not. next > r%gamma) exit
         r%gamma = next
      end do
      parts = parts/(1 + rate*r%gamma)
      r%size = sqrt(sum(weight*parts**2))
      r%trial = reshape([(parts(1) - parts(2))/sqrt(2.0_dp), parts(3), parts(3), (parts(1) + parts(2))/sqrt(2.0_dp)], &
                        [ndim, ndim])
   end subroutine return_in_plane_stress

   !> Consistent tangent of plane strain, times a change of H [Pa].
   pure function change_in_plane_strain(c, r, dh) result(change)
      type(j2_constants_t), intent(in) :: c
      type(return_t), intent(in) :: r
      real(dp), intent(in) :: dh(ndim, ndim)
      real(dp) :: change(ndim, ndim), n(ndim, ndim), de(ndim, ndim), kept
      de = (dh + transpose(dh))/2 - trace(dh)/3*identity
      n = r%trial/r%size
      kept = 1 - 2*c%mu*r%gamma/r%size
      change = (c%lambda + 2*c%mu/3)*trace(dh)*identity + 2*c%mu*kept*de &
               - 2*c%mu*(1/(1 + c%hardening/(3*c%mu)) - 1 + kept)*(sum(n*de) + trace(n)*trace(de))*n
   end function change_in_plane_strain

   !> Consistent tangent of plane stress, times a change of H [Pa].
   pure function change_in_plane_stress(c, r, dh) result(change)
      type(j2_constants_t), intent(in) :: c
      type(return_t), intent(in) :: r
      real(dp), intent(in) :: dh(ndim, ndim)
      real(dp) :: change(ndim, ndim), w(ndim, ndim), s(ndim, ndim)
      s = deviator(r%trial)
      w = softened(c, r%gamma, s)
      change = softened(c, r%gamma, (dh + transpose(dh))/2) &
               - sum(w*dh)/(sum(w*s) + 2*c%hardening*r%size**2/(3 - 2*c%hardening*r%gamma))*w
   end function change_in_plane_stress

   !> (C**-1 + gamma P)**-1 times a strain, P being that which makes the deviator of a plane stress [Pa].
   pure function softened(c, gamma, strain) result(stress)
      type(j2_constants_t), intent(in) :: c
      real(dp), intent(in) :: gamma              !! [1/Pa]
      real(dp), intent(in) :: strain(ndim, ndim) !! symmetric [-]
      real(dp) :: stress(ndim, ndim), mean
      mean = trace(strain)/2
      stress = 2*c%mu/(1 + 2*c%mu*gamma)*(strain - mean*identity) &
               + 2*(c%lambda_in_plane() + c%mu)/(1 + 2*(c%lambda_in_plane() + c%mu)*gamma/3)*mean*identity
   end function softened
end module hampm_j2_plastic
