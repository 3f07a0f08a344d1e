!> The T-stress: the stress along a crack at its tip beside the singular ones (Williams 1957; Rice 1974), in elastic material at
!> small strain, from the interaction with the field of a force on the tip along the crack (Kfouri 1986), with the inertia as J and
!> K have it. With the displacement a and stress s of a unit force over the thickness, and w = u,1 - c,
!>
!>    I = (1/B) [ sum_p V { (P_iJ a_i,1 + s_iJ w_i) q,J - P_iJ a_i,J q,1 + rho d_i a_i,1 q } - sum_points f_i a_i,1 q ],
!>    e_11 = c_1 + I - P_22 b
!>
!> is the strain along the crack without the singular fields; c counts in I, as s is not balanced at the tip. With compliances a_ij
!> in the axes of the crack, face stresses s_22 and s_12 at the tip, and s0 of an eigenstrain in fixed material,
!>
!>    T = s0_11 + { e_11 - a_12 (s_22 - s0_22) - a_16 (s_12 - s0_12) }/a_11.
module hampm_t_stress
   use hampm_kinds, only: dp, ndim
   use hampm_closed_faces, only: closed_faces_t
   use hampm_crack_tip_field, only: modes
   use hampm_domain_integral, only: integrals_t
   use hampm_energy_momentum, only: ways, sample_t, interaction
   use hampm_particles, only: particles_t
   use hampm_tensors, only: norm, in_plane, quarter_turn
   use hampm_tip_domain, only: tip_domain_t, places_t
   implicit none
   private
   public :: t_stresses

contains

   !> T of each disc [Pa]. P_22 is the stress across the faces at the tip, where they are pressed or loaded, and b their constant
   !> opening by the force: balanced forces between faces have no other part in I, nor have cohesive faces ahead, which the force
   !> neither stresses nor opens. Around an axis and in graded material I has the terms of `interaction`, as K has: near the tip
   !> these are as r**(-3/2), from K and the force, unresolved by cells, and taken from K (`singular_part`); the force acts at the
   !> origin of K. The strain H_33 around the axis counts as -s_33 H_33 in e_11, with s_33 of a unit stress along the crack in plane
   !> strain, found without K's part.
   pure function t_stresses(domain, p, closed, places, found, k) result(t)
      type(tip_domain_t), intent(in) :: domain   !! with its field and frame
      type(particles_t), intent(in) :: p
      type(closed_faces_t), intent(in) :: closed !! tractions on the faces behind a closed tip
      type(places_t), intent(in) :: places       !! in the discs
      type(integrals_t), intent(in) :: found
      real(dp), intent(in) :: k(modes)           !! stress intensity factors [Pa sqrt(m)]
      real(dp), allocatable :: t(:)              !! by radius
      real(dp) :: on_faces(ndim), idle(ndim, ndim), axes(ndim, ndim), x(ndim)
      real(dp) :: volume, total, outward         ! of particles near the tip; sum of their radial displacement without K's
      integer :: n
      axes = domain%axes
      on_faces = found%on_faces
      if (closed%are_closed) on_faces = on_faces + domain%in_axes(closed%traction_at(0.0_dp))/domain%thickness &
                                                   *sign(1.0_dp, dot_product(closed%normal, quarter_turn(closed%direction)))
      t = found%of_force
      if (domain%is_ring .or. domain%material%is_graded()) t = t + singular_part(domain, k)
      t = domain%constant(1, 1) + merge(2, 1, domain%half)*t - on_faces(2)*domain%field%opening_of_force()
      on_faces(2) = on_faces(2) - domain%pressure ! subtracted from the stress of the particles
      if (domain%is_ring) then
         total = 0
         outward = 0
         do n = 1, size(places%list)
            associate (place => places%list(n), i => places%list(n)%particle)
               x = domain%from_tip(p%place_in_grid(i), p%total_frame)
               volume = p%volume(i)*max(0.0_dp, 1 - norm(x)/domain%inner_radius())
               total = total + volume
               outward = outward + volume*(p%hoop_of(i)*p%reference(i, 1) &
                                           - dot_product(axes(1, :), domain%displacement_of(place, x, k)))
            end associate
         end do
         t = t + domain%material%stress_across(matmul(axes(:, :1), transpose(axes(:, :1))))*outward/(total*domain%tip(1))
      end if
      idle = matmul(transpose(axes), matmul(domain%material%stress_at_first(), axes))
      t = idle(1, 1) + domain%field%stress_along(t, on_faces(1) - idle(1, 2), on_faces(2) - idle(2, 2))
   end function t_stresses

   !> The product of K and the force, with the curvature of rings or the change of the material, within the inner radius, weighted
   !> by the rest of `min(1, r/inner_radius)`: it is as r**(-3/2), so 4/3 of the square of that radius times its value there.
   pure real(dp) function singular_part(domain, k) result(part)
      type(tip_domain_t), intent(in) :: domain
      real(dp), intent(in) :: k(modes)           !! [Pa sqrt(m)]
      integer, parameter :: steps = 64           ! of the angle
      real(dp) :: x(ndim), a(ndim, ndim), h(ndim, ndim), axes(ndim, ndim), flux(ways, ndim), source(ways), angle, widest
      type(sample_t) :: s
      integer :: n, mode
      axes = domain%axes
      s%is_ring = domain%is_ring
      s%radius = domain%tip(1)
      s%outward = axes(1, :)
      s%hoop = 0
      s%divergence = 0
      s%is_graded = domain%material%is_graded()
      s%free_rate = 0
      s%direction = matmul(domain%material%slice%direction, axes)
      s%rate = domain%material%slice%rate*s%direction
      widest = acos(-1.0_dp)
      part = 0
      do n = 1, steps
         angle = domain%side*widest*(merge(n, 2*n - steps, domain%half) - merge(0.5_dp, 1.0_dp, domain%half))/steps
         x = domain%inner_radius()*in_plane(cos(angle), sin(angle))
         h = 0
         do mode = 1, modes
            h = h + k(mode)*domain%field%gradient(mode, x)
         end do
         s%slope(:, 1) = h(:, 1)
         s%stress = domain%field%stress(h)
         s%bare_stress = s%stress
         s%hoop_stress = domain%material%stress_across(matmul(axes, matmul(s%stress, transpose(axes))))
         s%radial_slope = dot_product(s%outward, h(:, 1))
         a = domain%field%gradient_of_force(x)
         call interaction(s, domain%frame_t, domain%material, a, domain%field%stress(a), flux, source)
         part = part + 4*domain%inner_radius()**2/3*source(1)*merge(1, 2, domain%half)*widest/steps
      end do
   end function singular_part
end module hampm_t_stress
