!> Contribution of a particle to the integrals around tips and fronts, in any dimension: for motions q_m of places along axes m the
!> factors of q_m,J and of q_m, with w_m = u,m - c_m and a displacement a with the stress s in balance,
!>
!>    energy-momentum: w_m,i P_iJ - W d_mJ,                          (div P)_i w_m,i - W,m,
!>    interaction:     P_iJ a_i,m + s_iJ w_m,i - P_kL a_kL d_mJ,      (div P)_i a_i,m,
!>
!> W,m by the explicit dependence on the place. Graded material and rings add terms, for which see `domain_integrals`.
module hampm_energy_momentum
   use hampm_kinds, only: dp, ndim, plane
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: cofactors, identity, in_space, product_of, space, trace_of, unit_tensor, volume_change
   implicit none
   private
   public :: ways, plateau, frame_t, sample_t, take_sample, energy_momentum, interaction, weight_at

   integer, parameter :: ways = merge(1, ndim, ndim == plane) !! axes m: in the plane the first of a frame, in solids all
   real(dp), parameter :: plateau = 0.5_dp       !! part of the radius of a domain within which its weight is 1

   !> Frame of the sums. Its axes are those of the grid in solids, where fronts turn along themselves.
   type :: frame_t
      real(dp) :: axes(ndim, ndim) = identity    !! in the plane the first points out of the crack
      real(dp) :: turn(ndim, ndim) = 0           !! R - I, R being the rotation of the material around the tip
      real(dp) :: constant(ndim, ways) = 0       !! c, in these axes [-]
      real(dp) :: mu = 0                         !! shear modulus that the stress of fields is for, of graded material [Pa]
      real(dp) :: pressure = 0                   !! on the faces of a crack that cuts cells, along their normals [Pa]
      real(dp) :: across(ndim, ndim) = identity  !! tension of the body that leaves faces free of a unit pressure [-]
   contains
      procedure :: in_axes
   end type frame_t

   !> A particle, in the axes of a frame, which turn with the material.
   type :: sample_t
      real(dp) :: volume                         !! reference volume [m3]
      real(dp) :: stress(ndim, ndim)             !! P, conjugate to the displacement gradient [Pa]
      real(dp) :: slope(ndim, ways)              !! w [-]
      real(dp) :: energy                         !! W, with the work that has been dissipated [J/m3]
      real(dp) :: divergence(ndim)               !! div P [N/m3]
      ! Of axisymmetric material
      logical :: is_ring = .false.
      real(dp) :: radius                         !! R [m]
      real(dp) :: outward(ndim)                  !! the direction of the radius, (e_R)_i
      real(dp) :: hoop_stress, hoop              !! P_33 [Pa], H_33 [-]
      real(dp) :: radial_slope                   !! u_R,1 [-]
      real(dp) :: radial_constant                !! radial component of c in u,1, before it is turned back [-]
      ! Of graded material
      logical :: is_graded = .false.
      real(dp) :: bare_stress(ndim, ndim)        !! P without the pressure on faces [Pa]
      real(dp) :: energy_rate(ways)              !! W,m by its explicit dependence on the place [N/m3]
      real(dp) :: rate(ndim)                     !! gradient of the logarithm of the moduli [1/m]
      real(dp) :: direction(ndim)                !! of that, a unit vector
      real(dp) :: free_rate(ndim, ndim)          !! change of the strain without stress along it [1/m]
   end type sample_t

contains

   !> Weight of a domain: 1 up to a part of its radius, then a cubic with level ends, 0 from the radius on.
   pure elemental real(dp) function weight_at(distance, radius, inner) result(weight)
      real(dp), intent(in) :: distance           !! from the tip or the front [m]
      real(dp), intent(in) :: radius, inner      !! of the domain, and up to which it is 1 [m]
      associate (t => min(max((distance - inner)/(radius - inner), 0.0_dp), 1.0_dp))
         weight = 1 - t**2*(3 - 2*t)
      end associate
   end function weight_at

   !> Fields of a particle. The stress of a law for small rotation is of the unrotated gradient, and turned back itself.
   pure subroutine take_sample(frame, material, p, i, acceleration, s)
      type(frame_t), intent(in) :: frame
      type(material_t), intent(in) :: material   !! of the particle
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp), intent(in) :: acceleration(ndim) !! div P over the density [m/s2]
      type(sample_t), intent(out) :: s
      real(dp) :: h(ndim, ndim), turned(ndim, ndim), stress(ndim, ndim), constant(ndim), along(ndim)
      logical :: is_turned
      is_turned = any(abs(frame%turn) > 0)
      associate (history => p%history_of(i))
         h = p%gradient_of(i)
         turned = h
         if (is_turned) turned = h + matmul(transpose(frame%turn), identity + h)
         s%volume = p%volume(i)
         s%hoop = p%hoop_of(i)
         s%radial_slope = dot_product(h(1, :), frame%axes(:, 1))
         if (material%is_finite) h = turned
         stress = material%first_piola_stress(h, history, s%hoop)
         s%energy = material%energy_density(h, history, s%hoop)
         if (material%has_history) s%energy = s%energy + material%dissipation(h, history, s%hoop)
         ! Energy stored without stress in the plane is constant over the domain: it adds nothing but the error of the sums
         if (material%has_eigenstrain) s%energy = s%energy - material%idle_energy
         s%is_ring = p%thickness%is_ring
         if (s%is_ring) then
            s%hoop_stress = material%hoop_stress(h, history, s%hoop)
            s%radius = p%reference(i, 1)
            s%outward = frame%axes(1, :)
            constant = matmul(frame%axes, frame%constant(:, 1)) + frame%axes(:, 1)
            constant = constant + matmul(frame%turn, constant) - frame%axes(:, 1)
            s%radial_constant = constant(1)
         end if
      end associate
      s%is_graded = material%is_graded()
      if (s%is_graded) then
         s%bare_stress = components(stress)
         s%direction = material%slice%direction
         s%free_rate = material%slice%free_rate
         if (ndim == plane) then
            s%direction = matmul(s%direction, frame%axes)
            s%free_rate = matmul(transpose(frame%axes), matmul(s%free_rate, frame%axes))
         end if
         s%rate = material%slice%rate*s%direction
         s%energy_rate = s%direction(:ways)*(material%slice%rate*s%energy - sum(s%bare_stress*s%free_rate))
      end if
      if (abs(frame%pressure) > 0) call take_off_pressure(frame, material%is_finite .or. .not. p%total_frame, h, stress, s)
      s%stress = components(stress)
      s%slope = turned(:, :ways)
      if (ndim == plane) then
         along = turned(:, 1)*frame%axes(1, 1) + turned(:, 2)*frame%axes(2, 1)
         s%slope(:, 1) = matmul(along, frame%axes) - frame%constant(:, 1)
      end if
      s%divergence = material%density*frame%in_axes(acceleration)

   contains

      !> Components in the axes, of a tensor of the material.
      pure function components(tensor) result(t)
         real(dp), intent(in) :: tensor(ndim, ndim)
         real(dp) :: t(ndim, ndim), column(ndim)
         integer :: d
         t = tensor
         if (ndim > plane) return
         t = product_of(t, frame%axes)
         if (is_turned .and. .not. material%is_finite) t = t + matmul(transpose(frame%turn), t)
         do d = 1, plane
            column = t(:, d)
            t(1, d) = frame%axes(1, 1)*column(1) + frame%axes(2, 1)*column(2)
            t(2, d) = frame%axes(1, 2)*column(1) + frame%axes(2, 2)*column(2)
         end do
      end function components
   end subroutine take_sample

   !> Superpose a tension on a particle, as in a body without pressure p on faces: p N, N = `across`, with the work p N:H, and where
   !> the pressure follows the faces p (cof(F) - I) and p (det F - 1 - trace(H)) more.
   pure subroutine take_off_pressure(frame, follows, h, stress, s)
      type(frame_t), intent(in) :: frame
      logical, intent(in) :: follows             !! whether it acts on the present faces, else on the initial ones
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(inout) :: stress(ndim, ndim) !! P [Pa]
      type(sample_t), intent(inout) :: s
      real(dp) :: f(space, space), change(space, space)
      stress = stress + frame%pressure*frame%across
      s%energy = s%energy + frame%pressure*(sum(frame%across*h) + s%hoop)
      if (s%is_ring) s%hoop_stress = s%hoop_stress + frame%pressure
      if (.not. follows) return
      f = in_space(identity + h)
      if (s%is_ring) f(space, space) = 1 + s%hoop
      change = frame%pressure*(cofactors(f) - unit_tensor)
      stress = stress + change(:ndim, :ndim)
      s%energy = s%energy + frame%pressure*(volume_change(f - unit_tensor) - trace_of(f - unit_tensor))
      if (s%is_ring) s%hoop_stress = s%hoop_stress + change(space, space)
   end subroutine take_off_pressure

   !> The factors of q_m,J and of q_m in the change of energy by a motion of places.
   pure subroutine energy_momentum(s, flux, source)
      type(sample_t), intent(in) :: s
      real(dp), intent(out) :: flux(ways, ndim), source(ways)
      integer :: m, d
      do d = 1, ndim
         do m = 1, ways
            flux(m, d) = dot_product(s%slope(:, m), s%stress(:, d))
         end do
      end do
      do m = 1, ways
         flux(m, m) = flux(m, m) - s%energy
         source(m) = dot_product(s%divergence, s%slope(:, m))
      end do
      if (s%is_ring) source(1) = source(1) + (s%hoop_stress*(s%hoop*s%outward(1) - s%radial_constant) &
                                              - s%energy*s%outward(1))/s%radius
      if (s%is_graded) source = source - s%energy_rate
   end subroutine energy_momentum

   !> The same of the interaction with a field with free faces.
   pure subroutine interaction(s, frame, material, a, stress_of_a, flux, source)
      type(sample_t), intent(in) :: s
      type(frame_t), intent(in) :: frame
      type(material_t), intent(in) :: material   !! of the particle
      real(dp), intent(in) :: a(ndim, ndim)      !! displacement gradient of the field, in the axes
      real(dp), intent(in) :: stress_of_a(ndim, ndim) !! and its stress with the constants of the frame
      real(dp), intent(out) :: flux(ways, ndim), source(ways)
      real(dp) :: stress(ndim, ndim), work
      integer :: m, d
      stress = stress_of_a
      if (s%is_graded) stress = material%mu/frame%mu*stress
      work = sum(s%stress*a)
      do d = 1, ndim
         do m = 1, ways
            flux(m, d) = sum(a(:, m)*s%stress(:, d) + s%slope(:, m)*stress(:, d))
         end do
      end do
      do m = 1, ways
         flux(m, m) = flux(m, m) - work
         source(m) = dot_product(s%divergence, a(:, m))
      end do
      if (s%is_graded) source = source + matmul(matmul(stress, s%rate), s%slope) - s%rate(:ways)*sum(s%bare_stress*a) &
                                + s%direction(:ways)*sum(stress*s%free_rate)
      if (.not. s%is_ring) return
      source(1) = source(1) + (s%hoop_stress*dot_product(a(:, 1), s%outward) &
                               + dot_product(matmul(stress, s%outward), s%slope(:, 1)) - work*s%outward(1) &
                               - material%stress_across(matmul(frame%axes, matmul(stress, transpose(frame%axes)))) &
                               *(s%radial_slope - s%hoop*s%outward(1)))/s%radius
   end subroutine interaction

   !> A vector in the present configuration, turned back with the material, in the axes.
   pure function in_axes(self, vector)
      class(frame_t), intent(in) :: self
      real(dp), intent(in) :: vector(ndim)
      real(dp) :: in_axes(ndim)
      in_axes = vector
      if (ndim == plane) in_axes = matmul(vector + matmul(vector, self%turn), self%axes)
   end function in_axes
end module hampm_energy_momentum
