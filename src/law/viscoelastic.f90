!> Linear viscoelasticity at small strain: elastic volume, and in shear a spring beside Maxwell elements (Prony series),
!>
!>    G(t) = mu - sum of G_i + sum of G_i exp(-t/tau_i),   stress = kappa tr(eps) I + 2 (mu - sum of G_i) e + sum of q_i,
!>    q_i = 2 G_i (e - v_i),   v_i' = q_i/(2 eta_i),   eta_i = G_i tau_i;   over a step, x = dt/tau_i:
!>    q_i <- exp(-x) q_i + 2 G_i (1 - exp(-x))/x (e' - e).
!>
!> e is the deviator of eps = sym(H), v_i the strain of dashpot i; e changes at a constant rate in a step. mu, Young's modulus and
!> Poisson's ratio are instantaneous. Where the sum of the G_i is mu all shear stress relaxes. A particle stores the deviator of its
!> strain, the energy per volume dissipated by its dashpots, and the deviators v_i, each without its last component.
!>
!> Source: Taylor, Pister & Goudreau, Int. J. Numer. Meth. Engng 2 (1970) 45-59; Simo & Hughes, Computational Inelasticity (1998),
!> sections 10.2 and 10.3.
module hampm_viscoelastic
   use hampm_kinds, only: dp
   use hampm_law, only: law_t, constant_t, flaw_t, add_flaw, values_of, most_values
   use hampm_tensors, only: space, unit_tensor, trace_of, symmetric, deviator, n_deviator, components_of, deviator_of
   use hampm_text, only: to_text
   implicit none
   private
   public :: viscoelastic_t, new_viscoelastic, check_viscoelastic, most_branches

   integer, parameter :: most_branches = most_values !! of a series
   integer, parameter :: taken_energy = n_deviator + 1 !! which state variable it is
   real(dp), parameter :: decimals = 1.0e-6_dp   !! of constants that are given by their decimals

   type, extends(law_t) :: viscoelastic_t
      real(dp) :: kappa = 0                      !! bulk modulus [Pa]
      real(dp) :: mu = 0                         !! shear modulus of instantaneous strain [Pa]
      integer :: branches = 0                    !! Maxwell elements
      real(dp) :: modulus(most_branches) = 0     !! G_i [Pa]
      real(dp) :: time(most_branches) = 0        !! tau_i [s]
      real(dp) :: rest = 0                       !! mu - sum of G_i [Pa]
   contains
      procedure :: update
      procedure :: stress
      procedure :: tangent
      procedure :: energy
      procedure :: dissipation
   end type viscoelastic_t

contains

   !> Make the law of the instantaneous constants and of the Maxwell elements. Moduli whose sum is mu up to the decimals given leave
   !> no shear stress.
   subroutine new_viscoelastic(lambda, mu, constants, law)
      real(dp), intent(in) :: lambda, mu         !! of instantaneous strain
      type(constant_t), intent(in) :: constants(:)
      class(law_t), allocatable, intent(out) :: law
      type(viscoelastic_t) :: this
      this%kappa = lambda + 2*mu/3
      this%mu = mu
      associate (moduli => values_of(constants, 'moduli'), times => values_of(constants, 'relaxation_times'))
         this%branches = min(size(moduli), size(times), most_branches)
         this%modulus(:this%branches) = moduli(:this%branches)
         this%time(:this%branches) = times(:this%branches)
      end associate
      this%rest = mu - sum(this%modulus)
      if (this%rest < decimals*mu) this%rest = 0
      this%columns = taken_energy + n_deviator*this%branches
      allocate (law, source=this)
   end subroutine new_viscoelastic

   !> No more can relax than there is.
   pure subroutine check_viscoelastic(young, poisson, plane_stress, constants, flaws)
      real(dp), intent(in) :: young, poisson
      logical, intent(in) :: plane_stress
      type(constant_t), intent(in) :: constants(:)
      type(flaw_t), allocatable, intent(out) :: flaws(:)
      associate (moduli => values_of(constants, 'moduli'), mu => young/(2*(1 + poisson)))
         allocate (flaws(0))
         if (size(moduli) /= size(values_of(constants, 'relaxation_times'))) &
            call add_flaw(flaws, 'relaxation_times', 'must be as many as moduli: '//to_text(size(moduli)))
         if (sum(moduli) > (1 + decimals)*mu) call add_flaw(flaws, 'moduli', 'must have a sum of at most '//to_text(mu)// &
            ' [Pa], the instantaneous shear modulus, young/(2 (1 + poisson)); theirs is '//to_text(sum(moduli)))
      end associate
   end subroutine check_viscoelastic

   !> Let the dashpots yield in a step.
   pure subroutine update(self, h, dt, state)
      class(viscoelastic_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space)
      real(dp), intent(in) :: dt
      real(dp), intent(inout) :: state(:)
      real(dp), dimension(space, space) :: before, change, q, v
      real(dp) :: x
      integer :: k
      before = deviator_of(state(:n_deviator))
      change = deviator(symmetric(h)) - before
      do k = 1, self%branches
         x = dt/self%time(k)
         v = dashpot(state, k)
         q = 2*self%modulus(k)*(before - v)
         state(taken_energy) = state(taken_energy) + taken(x, q, 2*self%modulus(k)*change)/(2*self%modulus(k))
         state(first_of(k):first_of(k + 1) - 1) = components_of(before + change - exp(-x)*(before - v) - relaxing(x)*change)
      end do
      state(:n_deviator) = components_of(before + change)
   end subroutine update

   !> Stress [Pa]; instantaneous if the strain is not that of the state.
   pure function stress(self, h, state)
      class(viscoelastic_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp) :: stress(space, space), e(space, space)
      integer :: k
      e = deviator(symmetric(h))
      stress = self%kappa*trace_of(h)*unit_tensor + 2*self%rest*e
      do k = 1, self%branches
         stress = stress + 2*self%modulus(k)*(e - dashpot(state, k))
      end do
   end function stress

   !> The tangent of a step, in which stress is linear in H; without one the instantaneous one [Pa].
   pure function tangent(self, h, dh, state, dt) result(change)
      class(viscoelastic_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), dh(space, space), state(:)
      real(dp), intent(in), optional :: dt
      real(dp) :: change(space, space), modulus
      integer :: k
      modulus = self%mu
      if (present(dt)) modulus = self%rest + sum([(self%modulus(k)*relaxing(dt/self%time(k)), k=1, self%branches)])
      change = self%kappa*trace_of(dh)*unit_tensor + 2*modulus*deviator(symmetric(dh))
   end function tangent

   !> Energy that the springs store [J/m3].
   pure real(dp) function energy(self, h, state)
      class(viscoelastic_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp) :: e(space, space)
      integer :: k
      e = deviator(symmetric(h))
      energy = 0.5_dp*self%kappa*trace_of(h)**2 + self%rest*sum(e**2)
      do k = 1, self%branches
         energy = energy + self%modulus(k)*sum((e - dashpot(state, k))**2)
      end do
   end function energy

   !> Energy that the dashpots have taken, the integral of the sum of q_i : q_i/(2 eta_i) [J/m3].
   pure real(dp) function dissipation(self, state)
      class(viscoelastic_t), intent(in) :: self
      real(dp), intent(in) :: state(:)
      dissipation = state(taken_energy)
   end function dissipation

   !> Strain of the k-th dashpot [-].
   pure function dashpot(state, k) result(v)
      real(dp), intent(in) :: state(:)
      integer, intent(in) :: k
      real(dp) :: v(space, space)
      v = deviator_of(state(first_of(k):first_of(k + 1) - 1))
   end function dashpot

   !> Where the strain of the k-th dashpot begins.
   pure integer function first_of(k)
      integer, intent(in) :: k
      first_of = taken_energy + 1 + n_deviator*(k - 1)
   end function first_of

   !> (1 - exp(-x))/x with all digits of a small x.
   pure real(dp) function relaxing(x)
      real(dp), intent(in) :: x
      relaxing = 1
      if (x > 0) relaxing = 2*sinh(min(x, 1.0_dp)/2)*exp(-min(x, 1.0_dp)/2)/min(x, 1.0_dp)
      if (x > 1) relaxing = (1 - exp(-x))/x
   end function relaxing

   !> Integral of |q|**2 dt/tau over a step of length x tau at a constant rate: q exp(-s) + drive (1 - exp(-s))/x, where `drive`
   !> belongs to a sudden step. The last of its three parts loses digits at small x and has a series there.
   pure real(dp) function taken(x, q, drive)
      real(dp), intent(in) :: x, q(space, space), drive(space, space)
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
      taken = decayed*sum(q**2) + of_both*sum(q*drive) + of_drive*sum(drive**2)
   end function taken
end module hampm_viscoelastic
