!> The domains of particles: each particle stands for a quadrilateral of material, whose corners are carried along by the motion
!> (`shape_functions = 'cpdi'`, docs/explanation/domains.md).
!>
!> A corner has a quarter of the particle's mass, its own displacement and velocity, and moves as a point of the mesh's velocity
!> field. Over the domain the displacement is bilinear between the corners, which give the state of the particle:
!>
!>    u = sum of u_c / 4,   v = sum of v_c / 4,   H = sum of u_c (x) G_c,
!>
!> G_c being the gradient of the function of a corner at the centre of the reference domain, a rectangle of edges e: +-1/(2 e). So
!> the function of a particle is the mean over the corners of its domain of the mesh's functions (Sadeghirad, Brannon & Burghardt
!> 2011), and neighbours that share a corner at first share it for good, as their corners have the same velocity.
module hampm_domains
   use hampm_kinds, only: dp, ndim, corners
   use hampm_forest, only: corner_offset
   use hampm_particles, only: particles_t, spacing_of
   implicit none
   private
   public :: start_domains, displace_corners, edges_of_domain, corner_gradients, reference_corners, corner_places, follow_corners, &
             weights_in_domain, longest_edge, is_tangled, kinetic_energy_of, spin_of

   !> Least edge of a domain over the uncut one of a particle: a sliver would need equally short steps.
   real(dp), parameter :: least_edge = 0.5_dp

contains

   !> Give the particles, which are as their bodies begin, domains.
   subroutine start_domains(p)
      type(particles_t), intent(inout) :: p
      allocate (p%corner_displacement(p%n, ndim, corners), source=0.0_dp)
      p%corner_velocity = spread(p%velocity(:p%n, :), 3, corners)
   end subroutine start_domains

   !> Displace the corners as the strain of their particles has it, by u + H dX.
   subroutine displace_corners(p)
      type(particles_t), intent(inout) :: p
      real(dp) :: x(ndim, corners)
      integer :: i, c
      do i = 1, p%n
         x = reference_corners(p, i)
         do c = 1, corners
            p%corner_displacement(i, :, c) = p%displacement(i, :) + matmul(p%gradient_of(i), x(:, c) - p%reference(i, :))
         end do
      end do
   end subroutine displace_corners

   !> Edges of the reference domain of a particle [m]: of a smaller rectangle, if an edge of the body cuts it.
   pure function edges_of_domain(p, i) result(edges)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: edges(ndim)
      edges = spacing_of(p, i)
      if (p%has_outline(p%body(i))) edges = edges*min(1.0_dp, max(least_edge, sqrt(p%area_of(i)/product(edges))))
   end function edges_of_domain

   !> The gradients G_c: derivatives of H by displacements of the corners of a domain [1/m].
   pure function corner_gradients(p, i) result(g)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: g(ndim, corners)
      real(dp) :: edges(ndim)
      integer :: c
      edges = edges_of_domain(p, i)
      do c = 1, corners
         g(:, c) = (corner_offset(c) - 0.5_dp)/edges
      end do
   end function corner_gradients

   !> Places of the corners in the reference configuration [m].
   pure function reference_corners(p, i) result(x)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: x(ndim, corners)
      real(dp) :: edges(ndim)
      integer :: c
      edges = edges_of_domain(p, i)
      do c = 1, corners
         x(:, c) = p%reference(i, :) + (corner_offset(c) - 0.5_dp)*edges
      end do
   end function reference_corners

   !> Places of the corners now [m].
   pure function corner_places(p, i) result(x)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: x(ndim, corners)
      x = reference_corners(p, i) + p%corner_displacement(i, :, :)
   end function corner_places

   !> Bilinear functions of the corners of a domain at a material place, which may be outside of it [-].
   pure function weights_in_domain(offset, edges) result(n)
      real(dp), intent(in) :: offset(ndim)       !! dX from the particle [m]
      real(dp), intent(in) :: edges(ndim)        !! of the domain [m]
      real(dp) :: n(corners)
      real(dp) :: xi(ndim)
      integer :: c
      xi = offset/edges
      do c = 1, corners
         n(c) = product(0.5_dp + 2*(corner_offset(c) - 0.5_dp)*xi)
      end do
   end function weights_in_domain

   !> Update displacement, velocity and H of a particle from its corners.
   pure subroutine follow_corners(p, i)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: i
      real(dp) :: g(ndim, corners)
      integer :: d
      g = corner_gradients(p, i)
      do d = 1, ndim
         p%displacement(i, d) = sum(p%corner_displacement(i, d, :))/corners
         p%velocity(i, d) = sum(p%corner_velocity(i, d, :))/corners
         p%gradient(i, d, 1) = sum(p%corner_displacement(i, d, :)*g(1, :))
         p%gradient(i, d, 2) = sum(p%corner_displacement(i, d, :)*g(2, :))
      end do
   end subroutine follow_corners

   !> The longest edge of a domain now [m].
   pure real(dp) function longest_edge(p, i) result(length)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: x(ndim, corners)
      x = corners_around(p, i)
      length = sqrt(maxval(sum((cshift(x, 1, dim=2) - x)**2, dim=1)))
   end function longest_edge

   !> Whether a domain is turned over at one of its corners.
   pure logical function is_tangled(p, i) result(tangled)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: x(ndim, corners), ahead(ndim, corners), behind(ndim, corners)
      x = corners_around(p, i)
      ahead = cshift(x, 1, dim=2) - x
      behind = cshift(x, -1, dim=2) - x
      tangled = .not. all(ahead(1, :)*behind(2, :) - ahead(2, :)*behind(1, :) > 0)
   end function is_tangled

   !> Places of the corners of a domain, anticlockwise [m].
   pure function corners_around(p, i) result(x)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: x(ndim, corners)
      integer, parameter :: order(4) = [1, 2, 4, 3]
      x = corner_places(p, i)
      x(:, :size(order)) = x(:, order)
   end function corners_around

   !> Kinetic energy of a particle: of the corners of its domain, where it has one [J].
   pure real(dp) function kinetic_energy_of(p, i) result(energy)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      if (allocated(p%corner_velocity)) then
         energy = 0.5_dp*p%mass(i)/corners*sum(p%corner_velocity(i, :, :)**2)
      else
         energy = 0.5_dp*p%mass(i)*sum(p%velocity(i, :)**2)
      end if
   end function kinetic_energy_of

   !> Angular momentum of the corners of a domain around its centre [kg m2/s]; 0 without domains.
   pure real(dp) function spin_of(p, i) result(spin)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: arm(ndim, corners)
      spin = 0
      if (.not. allocated(p%corner_velocity)) return
      arm = corner_places(p, i) - spread(p%position(i), 2, corners)
      spin = p%mass(i)/corners*sum(arm(1, :)*p%corner_velocity(i, 2, :) - arm(2, :)*p%corner_velocity(i, 1, :))
   end function spin_of
end module hampm_domains
