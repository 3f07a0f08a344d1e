!> How a crack at rest changes as its tips move on: the derivative of the displacement by the place of each tip, from one solution for each with
!> the stiffness that is factorised.
!>
!> The cells and all that is in them are moved with v = q e, e being the direction of the tip, q 1 around it and 0 from the largest disc of its
!> integrals on. With M = I + a grad v the stiffness is that of the gradients grad u M**-1 in the volumes det M dV, and as K u = f holds for each
!> a, with loads that stay where they are,
!>
!>    K du/da = -K' u,   (K' u) . w = int { C : (-H G) + s div v - s G**T } : grad w dV,   H = grad u, G = grad v, s = C : H.
!>
!> Around the tip nothing is strained by v: there du/da is the change at places that move with the tip. Source: Lin & Abel (1988).
module hampm_tip_shift
   use hampm_kinds, only: dp, ndim
   use hampm_crack_tip, only: crack_tip_t
   use hampm_domain_integral, only: tip_domain_t, weight_nodes
   use hampm_expected_error, only: come_to_rest
   use hampm_loads, only: largest_factors
   use hampm_motion, only: motion_t
   use hampm_stiffness, only: stiffness_t, small_stress, gradient_at
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
      real(dp) :: gradient(m%grid%n_functions, ndim), h(ndim, ndim), g(ndim, ndim), stress(ndim, ndim)
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
                     gradient = gradient_at(m, i)
                     h = matmul(u(:, at), gradient) - material%free
                     g = spread(tip%direction, 2, ndim)*spread(matmul(q(1, at), gradient), 1, ndim)
                     stress = small_stress(material, h) + pressure*identity
                     if (abs(pressure) > 0) h = h + pressure/(2*(material%lambda + material%mu))*identity
                     stress = stress*trace(g) - matmul(stress, transpose(g)) - small_stress(material, matmul(h, g))
                     force(:, at) = force(:, at) - p%volume(i)*matmul(stress, transpose(gradient))
                  end associate
               end do
            end associate
         end do
      end associate
   end subroutine find_force
end module hampm_tip_shift
