!> State variables of particles with history-dependent laws, and the hoop resistance of axisymmetric ones.
module hampm_state_update
   use hampm_kinds, only: dp
   use hampm_law, only: most_columns
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: update_particle_state, hoop_resistance

contains

   !> Update the state of a particle that was strained in a step `dt`, if its law has a history.
   pure subroutine update_particle_state(material, dt, p, i)
      type(material_t), intent(in) :: material   !! of the particle
      real(dp), intent(in) :: dt                 !! [s]
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: i                   !! number of the particle
      real(dp) :: state(most_columns)
      if (.not. material%has_history) return
      state = p%history_of(i)
      call material%update_state(p%gradient_of(i), dt, state, p%hoop_of(i))
      p%history(i, :) = state(:p%columns())
   end subroutine update_particle_state

   !> P_33/R of a particle of axisymmetric material [Pa/m]: times volume and shape function the inward radial force on a node.
   pure real(dp) function hoop_resistance(material, p, i) result(stress)
      type(material_t), intent(in) :: material   !! of the particle
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      stress = material%hoop_stress(p%gradient_of(i), p%history_of(i), p%hoop_of(i))/p%reference(i, 1)
   end function hoop_resistance
end module hampm_state_update
