!> Splitting the domains of particles and recombining them. The corners of the children's domains are points of the parent's bilinear
!> fields: these stay as they are. The corners of a particle that four children make are theirs that were the parent's, so that what
!> was split and has not moved since comes back to the last digit. Momentum is kept.
!>
!> As four corners carry the mass of a rectangle, its moment of inertia is three times the true one, and that of its four children
!> together 3/2 of it: splitting takes angular momentum from material that turns, and recombining gives it back.
module hampm_domain_splitting
   use hampm_kinds, only: dp, ndim, corners
   use hampm_domains, only: edges_of_domain, weights_in_domain, reference_corners, corner_gradients, follow_corners
   use hampm_forest, only: corner_offset
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: domain_t, domain_of, divide_domain, joined_domain, take_domain

   !> The bilinear fields of a domain.
   type :: domain_t
      real(dp) :: middle(ndim) = 0               !! reference position of the particle [m]
      real(dp) :: edges(ndim) = 0                !! of the reference domain [m]
      real(dp) :: displacement(ndim, corners) = 0 !! of the corners [m]
      real(dp) :: velocity(ndim, corners) = 0    !! of the corners [m/s]
   end type domain_t

contains

   !> The domain of a particle.
   pure type(domain_t) function domain_of(p, i) result(domain)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      domain%middle = p%reference(i, :)
      domain%edges = edges_of_domain(p, i)
      domain%displacement = p%corner_displacement(i, :, :)
      domain%velocity = p%corner_velocity(i, :, :)
   end function domain_of

   !> Give children, which stand next to each other and are where they belong, their parts of the parent's domain. Where they are not
   !> alike, the products of the coordinates do not cancel: what momentum is missing all children share.
   pure subroutine divide_domain(p, first, last, parent)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: first, last         !! the children
      type(domain_t), intent(in) :: parent
      real(dp) :: missing(ndim)
      integer :: k
      missing = sum(parent%velocity, dim=2)/corners
      do k = first, last
         call take_domain(p, k, parent)
         missing = missing - p%mass(k)/sum(p%mass(first:last))*p%velocity(k, :)
      end do
      do k = first, last
         p%corner_velocity(k, :, :) = p%corner_velocity(k, :, :) + spread(missing, 2, corners)
         call follow_corners(p, k)
      end do
   end subroutine divide_domain

   !> Let the corners of a particle be points of the fields of a domain.
   pure subroutine take_domain(p, k, domain)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: k
      type(domain_t), intent(in) :: domain
      real(dp) :: n(corners), x(ndim, corners)
      integer :: c
      x = reference_corners(p, k)
      do c = 1, corners
         n = weights_in_domain(x(:, c) - domain%middle, domain%edges)
         p%corner_displacement(k, :, c) = matmul(domain%displacement, n)
         p%corner_velocity(k, :, c) = matmul(domain%velocity, n)
      end do
      call follow_corners(p, k)
   end subroutine take_domain

   !> The domain that siblings make together, around their mean: by the corners that were the parent's where there are all four children
   !> of a rectangle, else linear fields by the means of theirs.
   pure type(domain_t) function joined_domain(p, siblings, middle) result(domain)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: siblings(:)         !! in the order of the quarters that they are
      real(dp), intent(in) :: middle(ndim)       !! their mean in the reference configuration [m]
      real(dp) :: part(size(siblings)), velocity(ndim), u(ndim), h(ndim, ndim), l(ndim, ndim)
      integer :: c
      domain%middle = middle
      domain%edges = 2*edges_of_domain(p, siblings(1))
      part = p%mass(siblings)/sum(p%mass(siblings))
      velocity = matmul(part, p%velocity(siblings, :))
      if (size(siblings) == corners .and. .not. p%has_outline(p%body(siblings(1)))) then
         do c = 1, corners
            domain%displacement(:, c) = p%corner_displacement(siblings(c), :, c)
            domain%velocity(:, c) = p%corner_velocity(siblings(c), :, c)
         end do
      else
         u = matmul(part, p%displacement(siblings, :))
         h = 0
         l = 0
         do c = 1, size(siblings)
            associate (k => siblings(c))
               h = h + part(c)*p%gradient(k, :, :)
               l = l + part(c)*matmul(p%corner_velocity(k, :, :), transpose(corner_gradients(p, k)))
            end associate
         end do
         do c = 1, corners
            associate (offset => domain%edges*(corner_offset(c) - 0.5_dp))
               domain%displacement(:, c) = u + matmul(h, offset)
               domain%velocity(:, c) = matmul(l, offset)
            end associate
         end do
      end if
      velocity = velocity - sum(domain%velocity, dim=2)/corners
      domain%velocity = domain%velocity + spread(velocity, 2, corners)
   end function joined_domain
end module hampm_domain_splitting
