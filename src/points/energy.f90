!> Energies, momenta and extremes of the particles.
module hampm_energy
   use hampm_kinds, only: dp, ndim
   use hampm_domains, only: kinetic_energy_of, spin_of
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: norm, determinant, identity, product_of, trace
   implicit none
   private
   public :: kinetic_energy, energy_density_of, strain_energy, dissipation, linear_momentum, angular_momentum, n_turns, &
              largest_displacement, largest_gradient, largest_strain, stretches_of, most_crushed_particle, determinant_of, &
              liveliest_particle

   integer, parameter :: n_turns = ndim*(ndim - 1)/2 !! axes around which bodies turn: z or, in space, x, y and z
   integer, parameter :: from_to(2, 3) = reshape([2, 3, 3, 1, 1, 2], [2, 3])
   integer, parameter :: turns(2, n_turns) = from_to(:, 4 - n_turns:) !! for each the axis that turns to the other

   !> Sums over particles are taken over blocks of this many first, so that they do not depend on the number of threads.
   integer, parameter :: particles_per_block = 2048

contains

   !> Kinetic energy, sum of m v**2 / 2 [J].
   real(dp) function kinetic_energy(p) result(energy)
      type(particles_t), intent(in) :: p
      real(dp) :: partial((p%n - 1)/particles_per_block + 1)
      integer :: block, i
      !$omp parallel do schedule(static) private(i)
      do block = 1, size(partial)
         partial(block) = 0
         associate (first => (block - 1)*particles_per_block + 1, last => min(block*particles_per_block, p%n))
            if (.not. allocated(p%corner_velocity)) then
               partial(block) = kinetic_energy_of_row(last - first + 1, p%mass(first), p%velocity(first, 1), p%velocity(first, 2))
               if (ndim > 2) partial(block) = partial(block) + sum(p%mass(first:last)*p%velocity(first:last, ndim)**2)/2
            else
               do i = first, last
                  partial(block) = partial(block) + kinetic_energy_of(p, i)
               end do
            end if
         end associate
      end do
      energy = sum(partial)
   end function kinetic_energy

   !> The same of particles that stand one after the other.
   pure real(dp) function kinetic_energy_of_row(n, mass, u, v) result(energy)
      integer, intent(in) :: n
      real(dp), intent(in) :: mass(n), u(n), v(n)  !! [kg]; components of their velocities [m/s]
      integer :: i
      energy = 0
      !$omp simd reduction(+: energy)
      do i = 1, n
         energy = energy + 0.5_dp*mass(i)*(u(i)**2 + v(i)**2)
      end do
   end function kinetic_energy_of_row

   !> Elastic energy of the particles, sum of V W(H) [J].
   real(dp) function strain_energy(p, materials) result(energy)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      real(dp) :: partial((p%n - 1)/particles_per_block + 1)
      integer :: block, i
      !$omp parallel do schedule(static) private(i)
      do block = 1, size(partial)
         partial(block) = 0
         associate (first => (block - 1)*particles_per_block + 1, last => min(block*particles_per_block, p%n), h => p%gradient)
            associate (material => materials(p%material(first)))
               if (ndim == 2 .and. material%linear .and. .not. material%is_ring .and. &
                   all(p%material(first:last) == p%material(first))) then
                  partial(block) = strain_energy_of_row(material, last - first + 1, p%volume(first), h(first, 1, 1), &
                                                        h(first, 2, 1), h(first, 1, 2), h(first, 2, 2))
               else
                  do i = first, last
                     partial(block) = partial(block) + p%volume(i)*energy_density_of(p, materials, i)
                  end do
               end if
            end associate
         end associate
      end do
      energy = sum(partial)
   end function strain_energy

   !> The same of particles of one linear material that stand one after the other: of its stiffness c, quadratic in the strain.
   pure real(dp) function strain_energy_of_row(material, n, volume, h_11, h_21, h_12, h_22) result(energy)
      type(material_t), intent(in) :: material
      integer, intent(in) :: n
      real(dp), intent(in) :: volume(n)          !! [m3]
      real(dp), intent(in), dimension(n) :: h_11, h_21, h_12, h_22 !! displacement gradients [-]
      real(dp) :: x, y, shear, across
      integer :: i
      energy = 0
      across = material%energy_density(material%free, [real(dp) ::])
      associate (c => material%stiffness, free => material%free)
         !$omp simd reduction(+: energy) private(x, y, shear)
         do i = 1, n
            x = h_11(i) - free(1, 1)
            y = h_22(i) - free(2, 2)
            shear = h_21(i) + h_12(i) - (free(2, 1) + free(1, 2))
            energy = energy + volume(i)*(across + (c(1, 1)*x**2 + c(2, 2)*y**2 + c(3, 3)*shear**2)/2 + c(1, 2)*x*y &
                                         + (c(1, 3)*x + c(2, 3)*y)*shear)
         end do
      end associate
   end function strain_energy_of_row

   !> Elastic energy of a particle per reference volume [J/m3].
   pure real(dp) function energy_density_of(p, materials, i) result(density)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      integer, intent(in) :: i
      density = materials(p%material(i))%energy_density(p%gradient_of(i), p%history_of(i), p%hoop_of(i))
   end function energy_density_of

   !> Dissipation in the material of the particles: plastic work, or viscous dissipation [J].
   real(dp) function dissipation(p, materials, plastic) result(energy)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      logical, intent(in) :: plastic
      integer :: i
      energy = 0
      do i = 1, merge(p%n, 0, any(materials%has_history))
         associate (material => materials(p%material(i)))
            if (material%yields .eqv. plastic) &
               energy = energy + p%volume(i)*material%dissipation(p%gradient_of(i), p%history_of(i), p%hoop_of(i))
         end associate
      end do
   end function dissipation

   !> Linear momentum, sum of m v [kg m/s].
   pure function linear_momentum(p) result(momentum)
      type(particles_t), intent(in) :: p
      real(dp) :: momentum(ndim)
      integer :: i
      momentum = 0
      do i = 1, p%n
         momentum = momentum + p%mass(i)*p%velocity(i, :)
      end do
   end function linear_momentum

   !> Angular momentum around the centre of mass, of the plane around z, and the sum of the particles' largest parts, m |x| |v|,
   !> with the rounding of a common velocity [kg m2/s].
   pure subroutine angular_momentum(p, total, largest)
      type(particles_t), intent(in) :: p
      real(dp), intent(out) :: total(n_turns)
      real(dp), intent(out), optional :: largest
      real(dp), parameter :: rounding = 1.0e-9_dp
      real(dp) :: middle(ndim), velocity(ndim), x(ndim), v(ndim), mass
      integer :: i, d
      mass = sum(p%mass(:p%n))
      velocity = linear_momentum(p)/mass
      middle = 0
      do i = 1, p%n
         middle = middle + p%mass(i)/mass*p%position(i)
      end do
      total = 0
      if (present(largest)) largest = 0
      do i = 1, p%n
         x = p%position(i) - middle
         v = p%velocity(i, :) - velocity
         do d = 1, n_turns
            associate (j => turns(1, d), k => turns(2, d))
               total(d) = total(d) + p%mass(i)*(x(j)*v(k) - x(k)*v(j)) + spin_of(p, i)
            end associate
         end do
         if (present(largest)) largest = largest + p%mass(i)*norm(x)*(norm(v) + rounding*norm(p%velocity(i, :)))
      end do
   end subroutine angular_momentum

   !> Largest component of the displacement gradients of particles with laws for small strains [-]; 0 if there are none.
   pure real(dp) function largest_gradient(p, materials) result(largest)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      integer :: i
      largest = 0
      if (.not. any(materials%is_finite)) then
         largest = largest_of(size(p%gradient), p%gradient)
         return
      end if
      do i = 1, p%n
         if (.not. materials(p%material(i))%is_finite) largest = max(largest, maxval(abs(p%gradient(i, :, :))))
      end do
   end function largest_gradient

   !> Largest component of a displacement, in size [m].
   pure real(dp) function largest_displacement(p) result(largest)
      type(particles_t), intent(in) :: p
      integer :: d
      largest = 0
      do d = 1, ndim
         if (p%n > 0) largest = max(largest, largest_of(p%n, p%displacement(1, d)))
      end do
   end function largest_displacement

   !> The largest of some numbers in size.
   pure real(dp) function largest_of(n, values) result(largest)
      integer, intent(in) :: n
      real(dp), intent(in) :: values(n)
      integer :: i
      largest = 0
      !$omp simd reduction(max: largest)
      do i = 1, n
         largest = max(largest, abs(values(i)))
      end do
   end function largest_of

   !> Least and largest principal stretch of a particle, the roots of eigenvalues of F^T F [-].
   pure function stretches_of(p, i) result(stretch)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp), parameter :: third = 2*acos(-1.0_dp)/3 ! of a turn
      real(dp) :: stretch(2), f(ndim, ndim), transposed(ndim, ndim), c(ndim, ndim), mean, size_of, angle
      f = identity + p%gradient_of(i)
      transposed = transpose(f)
      c = product_of(transposed, f)
      mean = trace(c)/ndim
      c = c - mean*identity
      if (ndim == 2) then
         stretch = hypot(c(1, 1), c(1, 2))*[-1, 1]
      else
         size_of = sqrt(sum(c**2)/6)
         angle = acos(min(max(determinant(c)/max(2*size_of**3, tiny(mean)), -1.0_dp), 1.0_dp))/3
         stretch = 2*size_of*cos(angle + [third, 0.0_dp])
      end if
      stretch = sqrt(max(mean + stretch, 0.0_dp))
   end function stretches_of

   !> Largest strain of a particle, of what is stretched or compressed [-].
   pure real(dp) function largest_strain(p, i)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      largest_strain = maxval(abs(stretches_of(p, i) - 1))
   end function largest_strain

   !> The particle with the smallest determinant of F among those whose law needs it positive; 0 if there are none.
   pure integer function most_crushed_particle(p, materials) result(crushed)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      real(dp) :: smallest
      integer :: i
      crushed = 0
      if (.not. any(materials%is_finite)) return
      smallest = huge(smallest)
      do i = 1, p%n
         if (.not. materials(p%material(i))%is_finite) cycle
         if (crushed > 0 .and. determinant_of(p, i) >= smallest) cycle
         crushed = i
         smallest = determinant_of(p, i)
      end do
   end function most_crushed_particle

   !> Determinant of F of a particle [-].
   pure real(dp) function determinant_of(p, i)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      determinant_of = determinant(identity + p%gradient_of(i))*(1 + p%hoop_of(i))
   end function determinant_of

   !> The particle with the most kinetic and elastic energy; the first whose energy is not a number.
   pure integer function liveliest_particle(p, materials) result(liveliest)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      real(dp) :: energy, most
      integer :: i
      liveliest = 1
      most = -1
      do i = 1, p%n
         energy = kinetic_energy_of(p, i) + p%volume(i)*energy_density_of(p, materials, i)
         if (energy <= most) cycle
         liveliest = i
         if (.not. energy <= huge(energy)) return
         most = energy
      end do
   end function liveliest_particle
end module hampm_energy
