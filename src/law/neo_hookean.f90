!> Compressible neo-Hookean elasticity for any rotation and stretch:
!>
!>    W = mu/2 (tr b - 3 - 2 ln J) + lambda/2 (ln J)**2,    b = F F^T,
!>    Kirchhoff stress tau = mu (b - I) + lambda ln J I.
!>
!> For small strains it is linear elasticity with the same lambda and mu. In plane stress F_33 follows from
!> tau_33 = mu (F_33**2 - 1) + lambda ln(J_2 F_33) = 0, J_2 being the determinant in the plane; the left side rises and is convex in
!> y = ln F_33: Newton's iteration always converges.
!> (Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed., section 6.4.3.)
module hampm_neo_hookean
   use hampm_kinds, only: dp
   use hampm_law, only: law_t, constant_t
   use hampm_tensors, only: space, unit_tensor, volume_change, determinant_of, inverse_transpose_of
   implicit none
   private
   public :: neo_hookean_t, new_neo_hookean, log_of, isochoric_change

   type, extends(law_t) :: neo_hookean_t
      real(dp) :: lambda = 0, mu = 0             !! Lame constants at small strain [Pa]
   contains
      procedure :: stress
      procedure :: tangent
      procedure :: energy
      procedure :: across
   end type neo_hookean_t

contains

   !> The law of these Lame constants.
   subroutine new_neo_hookean(lambda, mu, constants, law)
      real(dp), intent(in) :: lambda, mu
      type(constant_t), intent(in) :: constants(:)
      class(law_t), allocatable, intent(out) :: law
      type(neo_hookean_t) :: this
      this%is_finite = .true.
      this%lambda = lambda
      this%mu = mu
      allocate (law, source=this)
   end subroutine new_neo_hookean

   !> Kirchhoff stress [Pa].
   pure function stress(self, h, state)
      class(neo_hookean_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp) :: stress(space, space), x
      stress = 0
      x = volume_change(h)
      ! b - I = H + H^T + H H^T keeps the digits of a small strain
      if (1 + x > 0) stress = self%mu*(h + transpose(h) + matmul(h, transpose(h))) + self%lambda*log_of(x)*unit_tensor
   end function stress

   !> Change of the first Piola stress P = mu (F - F^-T) + lambda ln J F^-T by a small change of H [Pa]:
   !>
   !>    dP = mu dF + (mu - lambda ln J) F^-T dF^T F^-T + lambda (F^-T : dF) F^-T.
   pure function tangent(self, h, dh, state, dt) result(change)
      class(neo_hookean_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), dh(space, space), state(:)
      real(dp), intent(in), optional :: dt
      real(dp) :: change(space, space), inverse(space, space), x
      change = 0
      x = volume_change(h)
      if (.not. 1 + x > 0) return
      inverse = inverse_transpose_of(unit_tensor + h)
      change = self%mu*dh + (self%mu - self%lambda*log_of(x))*matmul(inverse, matmul(transpose(dh), inverse)) &
               + self%lambda*sum(inverse*dh)*inverse
   end function tangent

   !> Energy per reference volume [J/m3].
   pure real(dp) function energy(self, h, state)
      class(neo_hookean_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp) :: x
      energy = 0
      x = volume_change(h)
      if (1 + x > 0) energy = 0.5_dp*self%mu*isochoric_change(h) + 0.5_dp*self%lambda*log_of(x)**2
   end function energy

   !> tr b - 3 - 2 ln J, which is of the second order in H: terms of the first cancel before they are computed [-].
   pure real(dp) function isochoric_change(h) result(change)
      real(dp), intent(in) :: h(space, space)
      change = (h(1, 1) - h(2, 2))**2 + (h(1, 2) + h(2, 1))**2 + (h(1, 3) + h(3, 1))**2 + (h(2, 3) + h(3, 2))**2 + h(3, 3)**2 &
               - 2*(h(3, 3)*(h(1, 1) + h(2, 2)) + determinant_of(h)) + 2*beyond_log(volume_change(h))
   end function isochoric_change

   !> H_33 from mu (exp(2 y) - 1) + lambda (ln J_2 + y) = 0, y = ln F_33.
   pure real(dp) function across(self, h, state, dt) result(h_33)
      class(neo_hookean_t), intent(in) :: self
      real(dp), intent(in) :: h(space, space), state(:)
      real(dp), intent(in), optional :: dt
      integer, parameter :: most_iterations = 50
      real(dp) :: in_plane(space, space), log_j, y, change, stretched
      integer :: k
      in_plane = h
      in_plane(3, 3) = 0
      h_33 = 0
      if (.not. 1 + volume_change(in_plane) > 0) return
      log_j = log_of(volume_change(in_plane))
      y = -self%lambda*log_j/(2*self%mu + self%lambda) ! Newton's first value from y = 0
      do k = 1, most_iterations
         stretched = exp_minus_one(2*y)
         change = -(self%mu*stretched + self%lambda*(log_j + y))/(2*self%mu*(1 + stretched) + self%lambda)
         y = y + change
         if (change**2 <= epsilon(y)*abs(y)) exit   ! the error is less than change**2
      end do
      h_33 = exp_minus_one(y)
   end function across

   !> ln(1 + x), with all digits of a small x.
   pure real(dp) function log_of(x)
      real(dp), intent(in) :: x
      real(dp) :: one_plus_x
      one_plus_x = 1 + x
      log_of = x
      if (abs(one_plus_x - 1) > 0) log_of = log(one_plus_x)*(x/(one_plus_x - 1))
   end function log_of

   !> exp(x) - 1 with all digits of a small x.
   pure real(dp) function exp_minus_one(x)
      real(dp), intent(in) :: x
      integer :: k
      if (abs(x) > 0.1_dp) then
         exp_minus_one = exp(x) - 1
         return
      end if
      exp_minus_one = 1
      do k = 11, 2, -1
         exp_minus_one = 1 + x*(1.0_dp/k)*exp_minus_one
      end do
      exp_minus_one = x*exp_minus_one
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
end module hampm_neo_hookean
