!> The kinetic energy of a motion, whoever carries it.
module hampm_kinetic
   use hampm_kinds, only: dp
   use hampm_energy, only: energy_of_particles => kinetic_energy
   use hampm_face_springs, only: energy_of_rates
   use hampm_mass_product, only: find_concentrated_mass, multiply_by_mass
   use hampm_motion, only: motion_t
   implicit none
   private
   public :: kinetic_energy

contains

   !> Kinetic energy [J]: of the particles, sum of m v**2/2; where nodes keep their velocities between implicit steps v.M v/2 of
   !> these, which is what such steps conserve.
   real(dp) function kinetic_energy(m) result(energy)
      type(motion_t), intent(in) :: m
      real(dp), allocatable :: mass(:), momentum(:, :)
      if (.not. allocated(m%nodal_velocity)) then
         energy = energy_of_particles(m%particles) + energy_of_rates(m%springs)
         return
      end if
      allocate (momentum, mold=m%nodal_velocity)
      call find_concentrated_mass(m%grid, m%fields%mass_matrix, mass)
      call multiply_by_mass(m%grid, m%fields%mass_matrix, mass, m%nodal_velocity, momentum)
      energy = sum(m%nodal_velocity*momentum)/2
   end function kinetic_energy
end module hampm_kinetic
