!> The domains of particles: each particle stands for a quadrilateral of material, whose corners are carried along by the motion
!> (`functions = 'cpdi'`, docs/domains.md).
!>
!> A corner has a quarter of the particle's mass, a displacement and a velocity of its own, and moves as a point of the mesh's own
!> velocity field. Over the domain the displacement is bilinear between the corners; what the particle knows follows from them:
!>
!>    u = sum of u_c / 4,   v = sum of v_c / 4,   H = sum of u_c (x) G_c,
!>
!> G_c being the gradient of the function of a corner at the centre of the reference domain, a rectangle of edges e: +-1/(2 e). So the
!> function of a particle is the mean over the corners of its domain of the mesh's functions (Sadeghirad, Brannon & Burghardt 2011),
!> and neighbours that share a corner at first share it for good, as their corners have the same velocity.
module hampm_domains
   use hampm_kinds, only: dp, ndim, corners
   use hampm_forest, only: corner_offset
   use hampm_particles, only: particles_t, spacing_of
   implicit none
   private
   public :: start_domains, edges_of_domain, corner_gradients, reference_corner, corner_place, follow_corners, weights_in_domain, &
             kinetic_energy_of, spin_of

   !> Least edge of a domain over that of a particle that no edge of the body cuts: a sliver would need steps that are as short.
   real(dp), parameter :: least_edge = 0.5_dp

contains

   !> Give the particles, which are as their bodies begin, domains.
   subroutine start_domains(p, spin)
      type(particles_t), intent(inout) :: p
      real(dp), intent(in) :: spin(:)            !! of each body, anticlockwise [rad/s]
      real(dp) :: arm(ndim)
      integer :: i, c
      allocate (p%corner_displacement(p%n, ndim, corners), source=0.0_dp)
      allocate (p%corner_velocity(p%n, ndim, corners))
      do c = 1, corners
         do i = 1, p%n
            arm = reference_corner(p, i, c) - p%reference(i, :)
            p%corner_velocity(i, :, c) = p%velocity(i, :) + spin(p%body(i))*[-arm(2), arm(1)]
         end do
      end do
   end subroutine start_domains

   !> Edges of the reference domain of a particle [m]: of one that an edge of the body cuts those of a smaller rectangle.
   pure function edges_of_domain(p, i) result(edges)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: edges(ndim)
      edges = spacing_of(p, i)
      if (p%has_outline(p%body(i))) edges = edges*min(1.0_dp, max(least_edge, sqrt(p%volume(i)/(p%thickness*product(edges)))))
   end function edges_of_domain

   !> G_c: what displacements of the corners of a domain give to H [1/m].
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

   !> Place of a corner in the reference configuration [m].
   pure function reference_corner(p, i, c) result(x)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i, c                !! particle, corner
      real(dp) :: x(ndim)
      x = p%reference(i, :) + (corner_offset(c) - 0.5_dp)*edges_of_domain(p, i)
   end function reference_corner

   !> Place of a corner now [m].
   pure function corner_place(p, i, c) result(x)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i, c                !! particle, corner
      real(dp) :: x(ndim)
      x = reference_corner(p, i, c) + p%corner_displacement(i, :, c)
   end function corner_place

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

   !> Bring displacement, velocity and H of a particle to those of its corners.
   pure subroutine follow_corners(p, i)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: i
      real(dp) :: u(ndim, corners), v(ndim, corners)
      u = p%corner_displacement(i, :, :)
      v = p%corner_velocity(i, :, :)
      p%displacement(i, :) = sum(u, dim=2)/corners
      p%velocity(i, :) = sum(v, dim=2)/corners
      p%gradient(i, :, :) = matmul(u, transpose(corner_gradients(p, i)))
   end subroutine follow_corners

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
      real(dp) :: arm(ndim)
      integer :: c
      spin = 0
      if (.not. allocated(p%corner_velocity)) return
      do c = 1, corners
         arm = corner_place(p, i, c) - p%position(i)
         spin = spin + p%mass(i)/corners*(arm(1)*p%corner_velocity(i, 2, c) - arm(2)*p%corner_velocity(i, 1, c))
      end do
   end function spin_of
end module hampm_domains
