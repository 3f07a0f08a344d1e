!> Plasticity of metals at small strain: von Mises' yield condition, associated flow, isotropic hardening (linear and, after Voce,
!> saturating) and linear kinematic hardening (Prager), integrated over a step by the implicit rule of Euler (radial return):
!>
!>    |s - q| <= sqrt(2/3) Y(alpha),   Y = yield_stress + hardening alpha + saturation (1 - exp(-alpha/saturation_strain)),
!>    eps_p' = gamma' n,   alpha' = sqrt(2/3) gamma',   q = 2/3 kinematic eps_p,   n = (s - q)/|s - q|
!>
!> s is the deviator of stress = C (eps - eps_p), eps = sym(H); alpha is the equivalent plastic strain. The back stress q stores the
!> energy kinematic |eps_p|**2/3. A particle stores eps_p without its last component, and alpha. The stress of a state is elastic.
!>
!> Source: Simo & Hughes, Computational Inelasticity (1998), boxes 3.1 and 3.2, with the consistent tangent.
module hampm_j2_plastic
   use hampm_kinds, only: dp
   use hampm_law, only: law_t, constant_t, value_of
   use hampm_tensors, only: norm, space, unit_tensor, trace_of, symmetric, deviator, n_deviator, components_of, deviator_of
   implicit none
   private
   public :: j2_plastic_t, new_j2_plastic

   integer, parameter :: equivalent = n_deviator + 1 !! which state variable is alpha
   real(dp), parameter :: rounding = 1.0e-13_dp  !! largest excess of a stress over the yield stress, relative
   integer, parameter :: most_iterations = 50    !! of an iteration that rises to its root

   type, extends(law_t) :: j2_plastic_t
      real(dp) :: lambda = 0, mu = 0             !! Lame constants [Pa]
      real(dp) :: yield_stress = 0               !! in uniaxial tension, at first [Pa]
      real(dp) :: hardening = 0                  !! rise of the yield stress with alpha, not negative [Pa]
      real(dp) :: saturation = 0                 !! largest further rise of the yield stress, not negative [Pa]
      real(dp) :: saturation_strain = 1          !! alpha at which 1 - 1/e of that is reached [-]
      real(dp) :: kinematic = 0                  !! modulus of the back stress, not negative [Pa]
   contains
      procedure :: update
      procedure :: stress
      procedure :: tangent
      procedure :: energy
      procedure :: dissipation
      procedure :: plastic_strain
      procedure, private :: radius
      procedure, private :: slope
      procedure, private :: returned
   end type j2_plastic_t

   !> Where a step ends.
   type :: return_t
      real(dp) :: gamma = 0                      !! flow of the step; 0 where it is elastic [-]
      real(dp) :: normal(space, space) = 0       !! n [-]
      real(dp) :: size = 0                       !! |s - q| of the trial stress [Pa]
      real(dp) :: alpha = 0                      !! at the end [-]
   end type return_t

contains

   !> The law of these constants.
   subroutine new_j2_plastic(lambda, mu, constants, law)
      real(dp), intent(in) :: lambda, mu
      type(constant_t), intent(in) :: constants(:) !! without a yield stress it does not yield
      class(law_t), allocatable, intent(out) :: law
      type(j2_plastic_t) :: this
      this%columns = equivalent
      this%yields = .true.
      this%lambda = lambda
      this%mu = mu
      this%yield_stress = value_of(constants, 'yield_stress', sqrt(huge(1.0_dp)))
      this%hardening = value_of(constants, 'hardening', 0.0_dp)
      this%saturation = value_of(constants, 'saturation', 0.0_dp)
      this%saturation_strain = value_of(constants, 'saturation_strain', 1.0_dp)
      this%kinematic = value_of(constants, 'kinematic_hardening', 0.0_dp)
      allocate (law, source=this)
   end subroutine new_j2_plastic

   !> Plastic flow of a step.
   pure subroutine update(self, h, dt, state)
      class(j2_plastic_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space)
      real(dp), intent(in) :: dt
      real(dp), intent(inout) :: state(:)
      type(return_t) :: r
      r = self%returned(h, state)
      if (.not. r%gamma > 0) return
      state(:n_deviator) = state(:n_deviator) + components_of(r%gamma*r%normal)
      state(equivalent) = r%alpha
   end subroutine update

   !> Stress [Pa].
   pure function stress(self, h, state)
      class(j2_plastic_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp) :: stress(space, space)
      stress = self%lambda*trace_of(h)*unit_tensor + 2*self%mu*(symmetric(h) - deviator_of(state(:n_deviator)))
   end function stress

   !> The tangent that is consistent with the return; without a step the elastic one [Pa].
   pure function tangent(self, h, dh, state, dt) result(change)
      class(j2_plastic_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), dh(space, space), state(:)
      real(dp), intent(in), optional :: dt
      real(dp) :: change(space, space), kept, along
      type(return_t) :: r
      change = self%lambda*trace_of(dh)*unit_tensor + 2*self%mu*symmetric(dh)
      if (.not. present(dt)) return
      r = self%returned(h, state)
      if (.not. r%gamma > 0) return
      kept = 1 - 2*self%mu*r%gamma/r%size
      along = 1/(1 + (self%slope(r%alpha) + self%kinematic)/(3*self%mu)) - 1 + kept
      change = (self%lambda + 2*self%mu/3)*trace_of(dh)*unit_tensor &
               + 2*self%mu*(kept*deviator(symmetric(dh)) - along*sum(r%normal*dh)*r%normal)
   end function tangent

   !> Energy of the elastic strain and of the back stress [J/m3].
   pure real(dp) function energy(self, h, state)
      class(j2_plastic_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp) :: plastic(space, space)
      plastic = deviator_of(state(:n_deviator))
      energy = 0.5_dp*self%lambda*trace_of(h)**2 + self%mu*sum((symmetric(h) - plastic)**2) + self%kinematic*sum(plastic**2)/3
   end function energy

   !> Work of s - q on the plastic strain, the integral of Y d alpha [J/m3].
   pure real(dp) function dissipation(self, state)
      class(j2_plastic_t), intent(in) :: self
      real(dp), intent(in) :: state(:)
      associate (alpha => state(equivalent))
         dissipation = (self%yield_stress + self%hardening*alpha/2)*alpha
         if (self%saturation > 0) &
            dissipation = dissipation + self%saturation*self%saturation_strain*beyond(alpha/self%saturation_strain)
      end associate
   end function dissipation

   !> Equivalent plastic strain, alpha [-].
   pure real(dp) function plastic_strain(self, state)
      class(j2_plastic_t), intent(in) :: self
      real(dp), intent(in) :: state(:)
      plastic_strain = state(equivalent)
   end function plastic_strain

   !> Radius of the yield surface in the space of deviators [Pa].
   pure real(dp) function radius(self, alpha)
      class(j2_plastic_t), intent(in) :: self
      real(dp), intent(in) :: alpha              !! equivalent plastic strain [-]
      radius = sqrt(2/3.0_dp)*(self%yield_stress + self%hardening*alpha)
      if (self%saturation > 0) radius = radius &
         + sqrt(2/3.0_dp)*self%saturation*(alpha/self%saturation_strain - beyond(alpha/self%saturation_strain))
   end function radius

   !> Y' [Pa].
   pure real(dp) function slope(self, alpha)
      class(j2_plastic_t), intent(in) :: self
      real(dp), intent(in) :: alpha
      slope = self%hardening
      if (self%saturation > 0) slope = slope + self%saturation/self%saturation_strain*exp(-alpha/self%saturation_strain)
   end function slope

   !> x - 1 + exp(-x), with all digits of a small x.
   pure real(dp) function beyond(x)
      real(dp), intent(in) :: x
      integer :: k
      if (x > 0.1_dp) then
         beyond = x - 1 + exp(-x)
         return
      end if
      beyond = 0
      do k = 12, 2, -1
         beyond = x/k*(1 - beyond)
      end do
      beyond = x*beyond
   end function beyond

   !> Return the trial stress: Newton's iteration for |s - q| of the trial - (2 mu + 2/3 kinematic) gamma - sqrt(2/3) Y = 0, convex.
   pure type(return_t) function returned(self, h, state) result(r)
      class(j2_plastic_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp) :: trial(space, space), plastic(space, space), stiffness, excess, next
      integer :: k
      plastic = deviator_of(state(:n_deviator))
      trial = 2*self%mu*(deviator(symmetric(h)) - plastic) - 2*self%kinematic/3*plastic
      stiffness = 2*self%mu + 2*self%kinematic/3
      r%alpha = state(equivalent)
      r%size = norm(trial)
      if (.not. r%size - self%radius(r%alpha) > rounding*self%radius(r%alpha)) return
      do k = 1, most_iterations
         excess = r%size - stiffness*r%gamma - self%radius(r%alpha)
         next = r%gamma + excess/(stiffness + 2*self%slope(r%alpha)/3)
         if (.not. next > r%gamma) exit
         r%gamma = next
         r%alpha = state(equivalent) + sqrt(2/3.0_dp)*r%gamma
         if (.not. self%saturation > 0) exit
      end do
      r%normal = trial/r%size
   end function returned
end module hampm_j2_plastic
