!> Energies, momenta and extremes of the particles.
module hampm_energy
   use hampm_kinds, only: dp, ndim
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: determinant, identity
   implicit none
   private
   public :: kinetic_energy, strain_energy, linear_momentum, largest_gradient, smallest_determinant, liveliest_particle

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
         do i = (block - 1)*particles_per_block + 1, min(block*particles_per_block, p%n)
            partial(block) = partial(block) + 0.5_dp*p%mass(i)*sum(p%velocity(:, i)**2)
         end do
      end do
      energy = sum(partial)
   end function kinetic_energy

   !> Elastic energy of the particles, sum of V W(H) [J].
   real(dp) function strain_energy(p, materials) result(energy)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      real(dp) :: partial((p%n - 1)/particles_per_block + 1)
      integer :: block, i
      !$omp parallel do schedule(static) private(i)
      do block = 1, size(partial)
         partial(block) = 0
         do i = (block - 1)*particles_per_block + 1, min(block*particles_per_block, p%n)
            partial(block) = partial(block) + p%volume(i)*materials(p%material(i))%energy_density(p%gradient(:, :, i))
         end do
      end do
      energy = sum(partial)
   end function strain_energy

   !> Linear momentum, sum of m v [kg m/s].
   pure function linear_momentum(p) result(momentum)
      type(particles_t), intent(in) :: p
      real(dp) :: momentum(ndim)
      integer :: i
      momentum = 0
      do i = 1, p%n
         momentum = momentum + p%mass(i)*p%velocity(:, i)
      end do
   end function linear_momentum

   !> Largest component of the displacement gradients of the particles of the linear law [-]; 0 where there are none.
   pure real(dp) function largest_gradient(p, materials) result(largest)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      integer :: i
      largest = 0
      do i = 1, p%n
         if (materials(p%material(i))%linear) largest = max(largest, maxval(abs(p%gradient(:, :, i))))
      end do
   end function largest_gradient

   !> Smallest determinant of F of the particles whose law needs it positive [-]; 1 where there are none.
   pure real(dp) function smallest_determinant(p, materials) result(smallest)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      integer :: i
      smallest = 1
      do i = 1, p%n
         if (.not. materials(p%material(i))%linear) smallest = min(smallest, determinant(identity + p%gradient(:, :, i)))
      end do
   end function smallest_determinant

   !> The particle with the most kinetic and elastic energy.
   pure integer function liveliest_particle(p, materials) result(liveliest)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      real(dp) :: energy, most
      integer :: i
      liveliest = 1
      most = -1
      do i = 1, p%n
         energy = 0.5_dp*p%mass(i)*sum(p%velocity(:, i)**2) &
                  + p%volume(i)*materials(p%material(i))%energy_density(p%gradient(:, :, i))
         if (energy <= most) cycle
         liveliest = i
         most = energy
      end do
   end function liveliest_particle
end module hampm_energy
