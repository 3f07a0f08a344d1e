!> The energy release rate and the stress intensity factors of a crack in motion, by integrals over a disc around its tip. Their
!> derivation is in docs/energy_release_rate.md.
module hampm_domain_integral
   use hampm_kinds, only: dp, ndim
   use hampm_basis, only: interpolate, interpolate_gradient, inside_cell
   use hampm_crack_tip_field, only: modes, effective_modulus, tip_gradient, tip_stress
   use hampm_grid, only: grid_t
   use hampm_material, only: material_t
   use hampm_nodal_state, only: nodal_state_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: identity
   implicit none
   private
   public :: tip_domain_t, domain_integrals

   real(dp), parameter :: plateau = 0.5_dp       !! part of the radius within which q is 1
   real(dp), parameter :: singular = 1.0e-3_dp   !! part of the smallest radius within which a particle counts as at the tip

   !> The tip of a straight crack with traction-free faces, and the discs around it.
   type :: tip_domain_t
      real(dp) :: tip(ndim) = 0                  !! reference position [m]
      real(dp) :: direction(ndim) = 0            !! unit vector from the crack into the body
      logical :: half = .false.                  !! whether the crack is on a symmetry plane and one side of it is modelled
      real(dp) :: thickness = 0                  !! B [m]
      type(material_t) :: material               !! in which the tip is
      real(dp), allocatable :: radius(:)         !! of each disc [m]
   end type tip_domain_t

   !> What a particle brings to the integrals, in the axes of the crack: the first is its direction, the origin the tip.
   type :: sample_t
      real(dp) :: x(ndim)                        !! reference position [m]
      real(dp) :: r                              !! distance from the tip [m]
      real(dp) :: h(ndim, ndim)                  !! displacement gradient [-]
      real(dp) :: stress(ndim, ndim)             !! P, conjugate to h [Pa]
      real(dp) :: energy                         !! W + rho v**2/2 [J/m3]
      real(dp) :: energy_slope                   !! rho v . v,1 [J/m4]
      real(dp) :: divergence(ndim)               !! div P [N/m3]
   end type sample_t

contains

   !> J, and K_I and K_II, of each disc:
   !>
   !>    J = (1/B) sum_p V { P_iJ u_i,1 q,J - (W + rho v**2/2) q,1 + (rho d_i u_i,1 - rho v_i v_i,1) q },
   !>    K = E'/(2 B) sum_p V { (P_iJ a_i,1 + s_iJ u_i,1) q,J - P_iJ a_i,J q,1 + rho d_i a_i,1 q },
   !>
   !> in the reference configuration, with rho d = div P and the displacement a and stress s of a unit K of the mode. J holds for
   !> any elastic law (Nakamura, Shih & Freund 1985), K for linear elasticity (Yau, Wang & Corten 1980).
   pure subroutine domain_integrals(domain, grid, p, materials, state, j, k)
      type(tip_domain_t), intent(in) :: domain
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      type(nodal_state_t), intent(in) :: state   !! of these particles
      real(dp), intent(out) :: j(:)              !! [J/m2], by radius
      real(dp), intent(out) :: k(:, :)           !! [Pa sqrt(m)], (modes, by radius); K_II is 0 in a half model
      type(sample_t) :: s
      real(dp) :: axes(ndim, ndim), h_aux(ndim, ndim, modes), stress_aux(ndim, ndim, modes), q, dq(ndim), largest, smallest
      integer :: i, n, mode
      axes = crack_axes(domain%direction)
      largest = maxval(domain%radius)
      smallest = singular*minval(domain%radius)
      j = 0
      k = 0
      do i = 1, p%n
         s%x = matmul(p%reference(:, i) - domain%tip, axes)
         s%r = norm2(s%x)
         if (s%r >= largest .or. s%r < smallest) cycle
         call take_sample(grid, p, i, materials(p%material(i)), state, axes, s)
         do mode = 1, modes
            h_aux(:, :, mode) = tip_gradient(domain%material, mode, s%x)
            stress_aux(:, :, mode) = tip_stress(domain%material, h_aux(:, :, mode))
         end do
         do n = 1, size(domain%radius)
            if (s%r >= domain%radius(n)) cycle
            call weight_function(s, domain%radius(n), q, dq)
            j(n) = j(n) + p%volume(i)*j_density(s, q, dq)
            do mode = 1, modes
               k(mode, n) = k(mode, n) + p%volume(i)*interaction_density(s, h_aux(:, :, mode), stress_aux(:, :, mode), q, dq)
            end do
         end do
      end do
      j = j/domain%thickness
      k = k*effective_modulus(domain%material)/(2*domain%thickness)
      if (domain%half) then
         j = 2*j
         k(1, :) = 2*k(1, :)
         k(2, :) = 0
      end if
   end subroutine domain_integrals

   !> The axes of a crack: the first along its direction, the second to the left of it.
   pure function crack_axes(direction) result(axes)
      real(dp), intent(in) :: direction(ndim)
      real(dp) :: axes(ndim, ndim)               !! one a column
      axes(:, 1) = direction
      axes(:, 2) = [-direction(2), direction(1)]
   end function crack_axes

   !> Fields of particle `i`.
   pure subroutine take_sample(grid, p, i, material, state, axes, s)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      type(material_t), intent(in) :: material
      type(nodal_state_t), intent(in) :: state
      real(dp), intent(in) :: axes(ndim, ndim)
      type(sample_t), intent(inout) :: s
      real(dp) :: xi(ndim), velocity_slope(ndim)
      associate (e => p%cell(i), h => p%gradient(:, :, i))
         xi = inside_cell(grid%local_coordinate(e, p%place_in_grid(i)))
         s%h = turn(h, axes)
         s%stress = turn(material%conjugate_stress(h), axes)
         s%energy = material%energy_density(h) + 0.5_dp*material%density*sum(p%velocity(:, i)**2)
         s%divergence = material%density*matmul(interpolate(xi, state%divergence(:, grid%element_nodes(:, e))), axes)
         velocity_slope = material_gradient(interpolate_gradient(xi, state%velocity(:, grid%element_nodes(:, e))) &
                                            /grid%element_size(e), h, axes(:, 1), p%total_frame)
         s%energy_slope = material%density*dot_product(p%velocity(:, i), velocity_slope)
      end associate
   end subroutine take_sample

   !> Derivative of a field with respect to the reference position in a direction, from its gradient in the grid.
   pure function material_gradient(gradient, h, direction, total_frame) result(slope)
      real(dp), intent(in) :: gradient(ndim, ndim), h(ndim, ndim), direction(ndim)
      logical, intent(in) :: total_frame         !! whether the grid is that of the reference positions
      real(dp) :: slope(ndim)
      if (total_frame) then
         slope = matmul(gradient, direction)
      else
         slope = matmul(gradient, matmul(identity + h, direction))
      end if
   end function material_gradient

   !> A tensor in the axes of the crack.
   pure function turn(tensor, axes) result(turned)
      real(dp), intent(in) :: tensor(ndim, ndim), axes(ndim, ndim)
      real(dp) :: turned(ndim, ndim)
      turned = matmul(matmul(transpose(axes), tensor), axes)
   end function turn

   !> q and its gradient at a particle: 1 up to a part of the radius, then a cubic with level ends, 0 from the radius on.
   pure subroutine weight_function(s, radius, q, dq)
      type(sample_t), intent(in) :: s
      real(dp), intent(in) :: radius             !! [m]
      real(dp), intent(out) :: q                 !! [-]
      real(dp), intent(out) :: dq(ndim)          !! [1/m]
      real(dp) :: t
      t = max(0.0_dp, (s%r/radius - plateau)/(1 - plateau))
      q = 1 - t**2*(3 - 2*t)
      dq = -6*t*(1 - t)/((1 - plateau)*radius)*s%x/s%r
   end subroutine weight_function

   !> Integrand of J [N/m2].
   pure real(dp) function j_density(s, q, dq) result(density)
      type(sample_t), intent(in) :: s
      real(dp), intent(in) :: q, dq(ndim)
      density = dot_product(matmul(s%stress, dq), s%h(:, 1)) - s%energy*dq(1) &
                + (dot_product(s%divergence, s%h(:, 1)) - s%energy_slope)*q
   end function j_density

   !> Integrand of the interaction with an auxiliary field [sqrt(m)/m2].
   pure real(dp) function interaction_density(s, h_aux, stress_aux, q, dq) result(density)
      type(sample_t), intent(in) :: s
      real(dp), intent(in) :: h_aux(ndim, ndim), stress_aux(ndim, ndim), q, dq(ndim)
      density = dot_product(matmul(s%stress, dq), h_aux(:, 1)) + dot_product(matmul(stress_aux, dq), s%h(:, 1)) &
                - sum(s%stress*h_aux)*dq(1) + dot_product(s%divergence, h_aux(:, 1))*q
   end function interaction_density
end module hampm_domain_integral
