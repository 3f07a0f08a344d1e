!> Compressible Mooney-Rivlin elasticity for any rotation and stretch:
!>
!>    W = c10 (I_1 - 3) + c01 (I_2 - 3) - (2 c10 + 4 c01) ln J + lambda'/2 (ln J)**2,
!>    I_1 = tr b,   I_2 = (I_1**2 - tr b**2)/2,   b = F F^T,
!>    Kirchhoff stress tau = 2 c10 b + 2 c01 (I_1 b - b**2) - (2 c10 + 4 c01) I + lambda' ln J I.
!>
!> For small strains it is linear elasticity with mu = 2 (c10 + c01), lambda = lambda' + 4 c01; c01 = 0 is the neo-Hookean law.
!>
!> Source: Mooney, Journal of Applied Physics 11 (1940) 582-592; Holzapfel, Nonlinear Solid Mechanics (2000), section 6.5.
module hampm_mooney_rivlin
   use hampm_kinds, only: dp
   use hampm_law, only: law_t, constant_t, flaw_t, add_flaw, value_of
   use hampm_neo_hookean, only: log_of, isochoric_change
   use hampm_tensors, only: space, unit_tensor, trace_of, volume_change, inverse_transpose_of
   use hampm_text, only: to_text
   implicit none
   private
   public :: mooney_rivlin_t, new_mooney_rivlin, check_mooney_rivlin

   type, extends(law_t) :: mooney_rivlin_t
      real(dp) :: lambda = 0                     !! lambda' [Pa]
      real(dp) :: c10 = 0, c01 = 0               !! [Pa]
   contains
      procedure :: stress
      procedure :: tangent
      procedure :: energy
   end type mooney_rivlin_t

contains

   !> The law of these constants.
   subroutine new_mooney_rivlin(lambda, mu, constants, law)
      real(dp), intent(in) :: lambda, mu
      type(constant_t), intent(in) :: constants(:)
      class(law_t), allocatable, intent(out) :: law
      type(mooney_rivlin_t) :: this
      associate (c01 => value_of(constants, 'c01', 0.0_dp))
         this%is_finite = .true.
         this%lambda = lambda - 4*c01
         this%c10 = mu/2 - c01
         this%c01 = c01
         allocate (law, source=this)
      end associate
   end subroutine new_mooney_rivlin

   !> Check that c01 leaves c10 and lambda' not below 0.
   pure subroutine check_mooney_rivlin(young, poisson, plane_stress, constants, flaws)
      real(dp), intent(in) :: young, poisson
      logical, intent(in) :: plane_stress
      type(constant_t), intent(in) :: constants(:)
      type(flaw_t), allocatable, intent(out) :: flaws(:)
      real(dp) :: most
      most = young/(4*(1 + poisson))*min(1.0_dp, poisson/(1 - 2*poisson))
      allocate (flaws(0))
      if (value_of(constants, 'c01', 0.0_dp) > most) call add_flaw(flaws, 'c01', 'must be at most '// &
         to_text(max(most, 0.0_dp))//' [Pa], the less of mu/2 and lambda/4 of young and poisson: else c10, or the stiffness '// &
         'of the volume, is below 0')
   end subroutine check_mooney_rivlin

   !> Kirchhoff stress [Pa].
   pure function stress(self, h, state)
      class(mooney_rivlin_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp) :: stress(space, space), e(space, space), t, x
      stress = 0
      x = volume_change(h)
      if (.not. 1 + x > 0) return
      e = stretch(h)
      t = trace_of(e)
      stress = 2*self%c10*e + 2*self%c01*(t*unit_tensor + (1 + t)*e - matmul(e, e)) + self%lambda*log_of(x)*unit_tensor
   end function stress

   !> Change of the first Piola stress by a small change of H, (d tau - P dF^T) F^-T [Pa].
   pure function tangent(self, h, dh, state, dt) result(change)
      class(mooney_rivlin_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), dh(space, space), state(:)
      real(dp), intent(in), optional :: dt
      real(dp), dimension(space, space) :: change, e, de, inverse
      real(dp) :: t, x
      change = 0
      x = volume_change(h)
      if (.not. 1 + x > 0) return
      inverse = inverse_transpose_of(unit_tensor + h)
      e = stretch(h)
      t = trace_of(e)
      de = matmul(dh, transpose(unit_tensor + h))
      de = de + transpose(de)
      change = 2*self%c10*de + 2*self%c01*(trace_of(de)*(unit_tensor + e) + (1 + t)*de - matmul(de, e) - matmul(e, de)) &
               + self%lambda*sum(inverse*dh)*unit_tensor
      change = matmul(change - matmul(matmul(self%stress(h, state), inverse), transpose(dh)), inverse)
   end function tangent

   !> Energy per reference volume; with e = b - I, I_2 - 3 = 2 tr e + ((tr e)**2 - |e|**2)/2 [J/m3].
   pure real(dp) function energy(self, h, state)
      class(mooney_rivlin_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp) :: e(space, space), x
      energy = 0
      x = volume_change(h)
      if (.not. 1 + x > 0) return
      e = stretch(h)
      energy = (self%c10 + 2*self%c01)*isochoric_change(h) + self%c01/2*(trace_of(e)**2 - sum(e**2)) + self%lambda/2*log_of(x)**2
   end function energy

   !> b - I, with all digits of a small H.
   pure function stretch(h) result(e)
      real(dp), intent(in) :: h(space, space)
      real(dp) :: e(space, space)
      e = h + transpose(h) + matmul(h, transpose(h))
   end function stretch
end module hampm_mooney_rivlin
