!> How a crack at rest changes as its tips move on: the derivative of the displacement by the place of each tip, from one solution for each with
!> the stiffness that is factorised.
!>
!> The cells and all that is in them are moved with v = q e, e being the direction of the tip, q 1 around it and 0 from the largest disc of its
!> integrals on. With M = I + a grad v the stiffness is that of the gradients grad u M**-1 in the volumes det M dV, and as K u = f holds for each
!> a, with loads that stay where they are,
!>
!>    K du/da = -K' u,   (K' u) . w = int { C : (-H G) + s div v - s G**T } : grad w dV,   H = grad u, G = grad v, s = C : H.
!>
!> In axisymmetric material H_33 = u_r/r, G_33 = v_r/r and the same of w are components of these gradients.
!>
!> Around the tip nothing is strained by v: there du/da is the change at places that move with the tip. Source: Lin & Abel (1988).
module hampm_tip_shift
   use hampm_kinds, only: dp, ndim
   use hampm_crack_tip, only: crack_tip_t
   use hampm_domain_integral, only: tip_domain_t, weight_nodes
   use hampm_expected_error, only: come_to_rest
   use hampm_loads, only: largest_factors
   use hampm_motion, only: motion_t
   use hampm_stiffness, only: stiffness_t, derivatives_at, n_derivatives
   use hampm_tensors, only: identity, trace
   implicit none
   private
   public :: tips_at_rest_t, find_tips_at_rest

   !> A scene at rest under its loads at their largest, scaled down to small gradients, and what changes there as its tips move.
   type :: tips_at_rest_t
      logical :: known = .false.
      real(dp) :: scale = 1                      !! by which these loads are scaled [-]
      real(dp), allocatable :: u(:, :)           !! displacement of the points [m], (ndim, n_points)
      real(dp), allocatable :: moved(:, :, :)    !! its derivative by the way of each tip [-], (ndim, n_points, tips)
   end type tips_at_rest_t

contains

   !> Find the tips at rest; `known` is false where nothing loads them and where there are too many unknowns.
   subroutine find_tips_at_rest(m, tips, at_rest)
      type(motion_t), intent(inout) :: m
      type(crack_tip_t), intent(in) :: tips(:)   !! all with radii
      type(tips_at_rest_t), intent(out) :: at_rest
      type(stiffness_t) :: rest
      real(dp), allocatable :: force(:, :), moved(:, :)
      real(dp) :: pressure
      integer :: k
      call come_to_rest(m, rest, at_rest%u, at_rest%scale, at_rest%known)
      if (at_rest%known) then
         allocate (at_rest%moved(ndim, m%grid%n_points, size(tips)))
         do k = 1, size(tips)
            pressure = at_rest%scale*sum(largest_factors(m%loads)*m%loads%pressure, mask=m%loads%line == tips(k)%crack)/(2*ndim)
            call find_force(m, at_rest%u, tips(k), pressure, force)
            call rest%solve(m, force, moved)
            at_rest%moved(:, :, k) = moved
         end do
      end if
      call rest%release()
   end subroutine find_tips_at_rest

   !> The forces -K' u of a tip [N/m], of the displacement beside the one that a strain without stress makes. Faces under pressure are free in the state to which the uniform stress p I is added.
   subroutine find_force(m, u, tip, pressure, force)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, n_points)
      type(crack_tip_t), intent(in) :: tip
      real(dp), intent(in) :: pressure           !! on its faces [Pa]
      real(dp), allocatable, intent(out) :: force(:, :) !! (ndim, n_points)
      type(tip_domain_t) :: domain
      real(dp), allocatable :: q(:, :)
      real(dp) :: gradient(m%grid%n_functions, n_derivatives(m)), with_hoop(ndim, n_derivatives(m))
      real(dp), dimension(ndim, ndim) :: h, g, stress
      real(dp) :: h_33, g_33, stress_33          ! 0 in a plane
      integer :: n, i
      domain%tip = tip%now
      domain%radius = [maxval(tip%radii)]
      call weight_nodes(domain, m%grid, q)
      allocate (force(ndim, m%grid%n_points), source=0.0_dp)
      associate (p => m%particles, b => m%blocks)
         do n = 1, b%n_occupied
            associate (e => b%occupied(n), at => m%grid%support_of(b%occupied(n)))
               if (.not. maxval(q(1, at)) > minval(q(1, at))) cycle
               do i = b%first_in(e), b%last_in(e), b%stride_in(e)
                  associate (material => m%materials(p%material(i)))
                     gradient = derivatives_at(m, i)
                     with_hoop = matmul(u(:, at), gradient)
                     h = with_hoop(:, :ndim) - material%free
                     h_33 = sum(with_hoop(1, ndim + 1:)) - material%free_hoop
                     with_hoop = spread(tip%direction, 2, n_derivatives(m))*spread(matmul(q(1, at), gradient), 1, ndim)
                     g = with_hoop(:, :ndim)
                     g_33 = sum(with_hoop(1, ndim + 1:))
                     stress = material%small_strain_stress(h, h_33) + pressure*identity
                     stress_33 = material%small_hoop_stress(h, h_33) + pressure
                     h = h + material%strain_of_pressure(pressure)*identity
                     if (material%is_ring) h_33 = h_33 + material%strain_of_pressure(pressure)
                     stress_33 = stress_33*trace(g) - material%small_hoop_stress(matmul(h, g), h_33*g_33)
                     stress = stress*(trace(g) + g_33) - matmul(stress, transpose(g)) &
                              - material%small_strain_stress(matmul(h, g), h_33*g_33)
                     force(:, at) = force(:, at) - p%volume(i)*matmul(stress, transpose(gradient(:, :ndim)))
                     if (material%is_ring) force(1, at) = force(1, at) - p%volume(i)*stress_33*gradient(:, ndim + 1)
                  end associate
               end do
            end associate
         end do
      end associate
   end subroutine find_force
end module hampm_tip_shift
