!> Compressible elasticity after Blatz and Ko (f = 1) for any rotation and stretch:
!>
!>    W = mu/2 (tr b - 3 + (J**(-2 beta) - 1)/beta),   beta = lambda/(2 mu) = nu/(1 - 2 nu),   b = F F^T,
!>    Kirchhoff stress tau = mu (b - J**(-2 beta) I).
!>
!> A bar that is pulled to s times its length has 1/s**nu of its width, at any stretch, and the nominal stress mu (s - s**(-1 - 2 nu)).
!>
!> Source: Blatz & Ko, Transactions of the Society of Rheology 6 (1962) 223-252.
module hampm_blatz_ko
   use hampm_kinds, only: dp
   use hampm_law, only: law_t, constant_t
   use hampm_neo_hookean, only: log_of, isochoric_change
   use hampm_tensors, only: space, unit_tensor, volume_change, inverse_transpose_of
   implicit none
   private
   public :: new_blatz_ko

   type, extends(law_t) :: blatz_ko_t
      real(dp) :: mu = 0                         !! shear modulus [Pa]
      real(dp) :: beta = 0                       !! nu/(1 - 2 nu) [-]
   contains
      procedure :: stress
      procedure :: tangent
      procedure :: energy
      procedure, private :: less_one
   end type blatz_ko_t

contains

   !> The law of these Lame constants.
   subroutine new_blatz_ko(lambda, mu, constants, law)
      real(dp), intent(in) :: lambda, mu
      type(constant_t), intent(in) :: constants(:)
      class(law_t), allocatable, intent(out) :: law
      allocate (law, source=blatz_ko_t(is_finite=.true., mu=mu, beta=lambda/(2*mu)))
   end subroutine new_blatz_ko

   !> Kirchhoff stress [Pa], with the digits of a small H.
   pure function stress(self, h, state)
      class(blatz_ko_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp) :: stress(space, space)
      stress = 0
      if (1 + volume_change(h) > 0) &
         stress = self%mu*(h + transpose(h) + matmul(h, transpose(h)) - self%less_one(h)*unit_tensor)
   end function stress

   !> Change of the first Piola stress P = mu (F - J**(-2 beta) F^-T) by a small change of H [Pa]:
   !>
   !>    dP = mu dF + mu J**(-2 beta) (F^-T dF^T F^-T + 2 beta (F^-T : dF) F^-T).
   pure function tangent(self, h, dh, state, dt) result(change)
      class(blatz_ko_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), dh(space, space), state(:)
      real(dp), intent(in), optional :: dt
      real(dp) :: change(space, space), inverse(space, space)
      change = 0
      if (.not. 1 + volume_change(h) > 0) return
      inverse = inverse_transpose_of(unit_tensor + h)
      change = self%mu*dh + self%mu*(1 + self%less_one(h))*(matmul(inverse, matmul(transpose(dh), inverse)) &
                                                            + 2*self%beta*sum(inverse*dh)*inverse)
   end function tangent

   !> Energy per reference volume [J/m3].
   pure real(dp) function energy(self, h, state)
      class(blatz_ko_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      energy = 0
      if (.not. 1 + volume_change(h) > 0) return
      energy = self%mu/2*isochoric_change(h)     ! tr b - 3 - 2 ln J
      if (abs(self%beta) > 0) energy = energy + self%mu/2*(2*log_of(volume_change(h)) + self%less_one(h)/self%beta)
   end function energy

   !> J**(-2 beta) - 1, with the digits of a small H: exp(2 x) - 1 = 2 exp(x) sinh(x).
   pure real(dp) function less_one(self, h)
      class(blatz_ko_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space)
      real(dp) :: x
      x = -self%beta*log_of(volume_change(h))
      less_one = 2*exp(x)*sinh(x)
   end function less_one
end module hampm_blatz_ko
