!> Linear viscoelasticity at small strain: elastic in its volume, and in shear a spring beside Maxwell elements, a Prony series of
!> the shear modulus,
!>
!>    G(t) = mu - sum of G_i + sum of G_i exp(-t/tau_i),   stress = kappa tr(eps) I + 2 (mu - sum of G_i) e + sum of q_i,
!>    q_i = 2 G_i (e - v_i),   v_i' = q_i/(2 eta_i),   eta_i = G_i tau_i,
!>
!> e being the deviator of eps = sym(H) and v_i the strain of the i-th dashpot. mu, and with it Young's modulus and Poisson's
!> ratio, are those of sudden strains. Where the sum of the G_i is mu nothing is left of the shear stress in the end, as in a
!> Maxwell fluid.
!>
!> Over a step e is taken to change at a constant rate, of which the update, with x = dt/tau_i, is the solution:
!>
!>    q_i <- exp(-x) q_i + 2 G_i (1 - exp(-x))/x (e' - e).
!>
!> In plane strain eps_33 = 0. In plane stress eps_33 follows from stress_33 = 0 at the end of the step, a linear equation.
!>
!> What a particle remembers: eps_11, eps_22, eps_12, eps_33, the energy that its dashpots have taken per volume, and for each
!> element v_11, v_22, v_12; v_33 = -(v_11 + v_22).
!>
!> Source: Taylor, Pister & Goudreau, Int. J. Numer. Meth. Engng 2 (1970) 45-59; Simo & Hughes, Computational Inelasticity (1998),
!> sections 10.2 and 10.3.
module hampm_viscoelastic
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: prony_t, most_branches, new_prony, prony_columns, prony_follow, prony_stress, prony_change, prony_energy_density, &
             prony_dissipation

   integer, parameter :: most_branches = 8       !! of a series
   integer, parameter :: first_branch = 6        !! number that a particle remembers of it
   integer, parameter :: n = 4                   !! components of a symmetric tensor: 11, 22, 12, 33
   real(dp), parameter :: weight(n) = [1, 1, 2, 1] !! of their products in the product of two tensors
   real(dp), parameter :: deviator_of_one(n) = [-1, -1, 0, 2]/3.0_dp !! of eps_33 = 1

   !> The constants of the law.
   type :: prony_t
      real(dp) :: kappa = 0                      !! bulk modulus [Pa]
      real(dp) :: mu = 0                         !! shear modulus of sudden strains [Pa]
      logical :: plane_stress = .true.           !! else plane strain
      integer :: branches = 0                    !! Maxwell elements
      real(dp) :: modulus(most_branches) = 0     !! G_i [Pa]
      real(dp) :: time(most_branches) = 0        !! tau_i [s]
      real(dp) :: rest = 0                       !! mu - sum of G_i [Pa]
   end type prony_t

contains

   !> The constants from those of sudden strains and those of the elements. Moduli whose sum is that of sudden strains but for
   !> what their decimals tell leave nothing.
   pure type(prony_t) function new_prony(kappa, mu, plane_stress, moduli, times) result(c)
      real(dp), intent(in) :: kappa              !! bulk modulus [Pa]
      real(dp), intent(in) :: mu                 !! shear modulus of sudden strains [Pa]
      logical, intent(in) :: plane_stress        !! else plane strain
      real(dp), intent(in) :: moduli(:)          !! G_i, at most `most_branches` [Pa]
      real(dp), intent(in) :: times(:)           !! tau_i [s]
      real(dp), parameter :: decimals = 1.0e-6_dp
      c%kappa = kappa
      c%mu = mu
      c%plane_stress = plane_stress
      c%branches = min(size(moduli), size(times), most_branches)
      c%modulus(:c%branches) = moduli(:c%branches)
      c%time(:c%branches) = times(:c%branches)
      c%rest = mu - sum(c%modulus)
      if (c%rest < decimals*mu) c%rest = 0
   end function new_prony

   !> How many numbers a particle remembers.
   pure integer function prony_columns(c)
      type(prony_t), intent(in) :: c
      prony_columns = first_branch - 1 + 3*c%branches
   end function prony_columns

   !> Remember a step of length `dt` at the end of which the displacement gradient is `h`.
   pure subroutine prony_follow(c, h, dt, past)
      type(prony_t), intent(in) :: c
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), contiguous, intent(inout) :: past(:) !! (prony_columns)
      real(dp) :: strain(n), before(n), change(n), q(n), v(n), x
      integer :: k
      strain = strain_of(c, h, dt, past)
      before = deviator(past(:n))
      change = deviator(strain) - before
      do k = 1, c%branches
         x = dt/c%time(k)
         v = dashpot(past, k)
         q = 2*c%modulus(k)*(before - v)
         past(n + 1) = past(n + 1) + taken(x, q, 2*c%modulus(k)*change)/(2*c%modulus(k))
         v = before + change - exp(-x)*(before - v) - relaxing(x)*change
         past(first_of(k):first_of(k) + 2) = v(:3)
      end do
      past(:n) = strain
   end subroutine prony_follow

   !> Stress of a displacement gradient at the end of a step of length `dt` [Pa].
   pure function prony_stress(c, h, dt, past) result(stress)
      type(prony_t), intent(in) :: c
      real(dp), intent(in) :: h(ndim, ndim), dt
      real(dp), contiguous, intent(in) :: past(:)
      real(dp) :: stress(ndim, ndim), s(n), strain(n)
      strain = strain_of(c, h, dt, past)
      s = deviatoric_stress(c, deviator(strain), dt, past)
      s([1, 2]) = s([1, 2]) + c%kappa*(strain(1) + strain(2) + strain(4))
      stress = reshape([s(1), s(3), s(3), s(2)], [ndim, ndim])
   end function prony_stress

   !> What a small change of H makes of the stress at the end of a step of length `dt`, which is linear in H [Pa].
   pure function prony_change(c, dh, dt) result(change)
      type(prony_t), intent(in) :: c
      real(dp), intent(in) :: dh(ndim, ndim), dt
      real(dp) :: change(ndim, ndim)
      real(dp) :: none(prony_columns(c))
      none = 0
      change = prony_stress(c, dh, dt, none)
   end function prony_change

   !> Energy that the springs store per volume after a step that has been remembered [J/m3].
   pure real(dp) function prony_energy_density(c, h, past) result(energy)
      type(prony_t), intent(in) :: c
      real(dp), intent(in) :: h(ndim, ndim)
      real(dp), contiguous, intent(in) :: past(:)
      real(dp) :: strain(n), e(n)
      integer :: k
      strain = strain_of(c, h, 0.0_dp, past)
      e = deviator(strain)
      energy = 0.5_dp*c%kappa*(strain(1) + strain(2) + strain(4))**2 + c%rest*sum(weight*e**2)
      do k = 1, c%branches
         energy = energy + c%modulus(k)*sum(weight*(e - dashpot(past, k))**2)
      end do
   end function prony_energy_density

   !> Energy that the dashpots have taken per volume, the integral of the sum of q_i : q_i/(2 eta_i) [J/m3].
   pure real(dp) function prony_dissipation(past) result(energy)
      real(dp), contiguous, intent(in) :: past(:)
      energy = past(n + 1)
   end function prony_dissipation

   !> Strain at the end of a step [-]; in plane stress with the eps_33 that leaves no stress_33.
   pure function strain_of(c, h, dt, past) result(strain)
      type(prony_t), intent(in) :: c
      real(dp), intent(in) :: h(ndim, ndim), dt
      real(dp), contiguous, intent(in) :: past(:)
      real(dp) :: strain(n), s(n), modulus
      integer :: k
      strain = [h(1, 1), h(2, 2), (h(1, 2) + h(2, 1))/2, 0.0_dp]
      if (.not. c%plane_stress) return
      s = deviatoric_stress(c, deviator(strain), dt, past)
      modulus = c%rest
      do k = 1, c%branches
         modulus = modulus + c%modulus(k)*relaxing(dt/c%time(k))
      end do
      strain(4) = -(s(4) + c%kappa*(strain(1) + strain(2)))/(c%kappa + 2*modulus*deviator_of_one(4))
   end function strain_of

   !> Deviator of the stress at the end of a step, by that of the strain [Pa].
   pure function deviatoric_stress(c, e, dt, past) result(s)
      type(prony_t), intent(in) :: c
      real(dp), intent(in) :: e(n), dt
      real(dp), contiguous, intent(in) :: past(:)
      real(dp) :: s(n), before(n)
      integer :: k
      before = deviator(past(:n))
      s = 2*c%rest*e
      do k = 1, c%branches
         associate (x => dt/c%time(k))
            s = s + 2*c%modulus(k)*(exp(-x)*(before - dashpot(past, k)) + relaxing(x)*(e - before))
         end associate
      end do
   end function deviatoric_stress

   !> Deviator of a strain [-].
   pure function deviator(strain)
      real(dp), intent(in) :: strain(n)
      real(dp) :: deviator(n)
      deviator = strain - [1, 1, 0, 1]*((strain(1) + strain(2) + strain(4))/3)
   end function deviator

   !> Strain of the k-th dashpot [-].
   pure function dashpot(past, k) result(v)
      real(dp), contiguous, intent(in) :: past(:)
      integer, intent(in) :: k
      real(dp) :: v(n)
      associate (in_plane => past(first_of(k):first_of(k) + 2))
         v = [in_plane(1), in_plane(2), in_plane(3), -(in_plane(1) + in_plane(2))]
      end associate
   end function dashpot

   !> Where the strain of the k-th dashpot begins.
   pure integer function first_of(k)
      integer, intent(in) :: k
      first_of = first_branch + 3*(k - 1)
   end function first_of

   !> (1 - exp(-x))/x with all digits of a small x.
   pure real(dp) function relaxing(x)
      real(dp), intent(in) :: x
      relaxing = 1
      if (x > 0) relaxing = 2*sinh(min(x, 1.0_dp)/2)*exp(-min(x, 1.0_dp)/2)/min(x, 1.0_dp)
      if (x > 1) relaxing = (1 - exp(-x))/x
   end function relaxing

   !> The integral of |q|**2 dt/tau over a step of length x tau through which q is driven at a constant rate: q exp(-s)
   !> + drive (1 - exp(-s))/x, drive being that of a sudden step. The last of its three parts loses its digits where x is small, and
   !> has a series there.
   pure real(dp) function taken(x, q, drive)
      real(dp), intent(in) :: x, q(n), drive(n)
      real(dp), parameter :: small = 0.01_dp
      real(dp) :: decayed, of_both, of_drive
      taken = 0
      if (.not. x > 0) return
      decayed = x*relaxing(2*x)
      of_both = x*relaxing(x)**2
      if (x < small) then
         of_drive = x*(1/3.0_dp - x*(1/4.0_dp - x*(7/60.0_dp - x*(1/24.0_dp - x*31/2520.0_dp))))
      else
         of_drive = (1 - 2*relaxing(x) + relaxing(2*x))/x
      end if
      taken = decayed*sum(weight*q**2) + of_both*sum(weight*q*drive) + of_drive*sum(weight*drive**2)
   end function taken
end module hampm_viscoelastic
