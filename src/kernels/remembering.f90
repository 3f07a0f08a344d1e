!> What particles remember, where their law has a history.
module hampm_remembering
   use hampm_kinds, only: dp
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: remember

contains

   !> Keep the state of a particle that has been strained in a step `dt`; where its law has no history there is none.
   pure subroutine remember(material, dt, p, i)
      type(material_t), intent(in) :: material   !! of the particle
      real(dp), intent(in) :: dt                 !! [s]
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: i                   !! number of the particle
      real(dp) :: past(p%columns())
      if (.not. material%has_history()) return
      past = p%history(i, :)
      call material%follow(p%gradient_of(i), dt, past)
      p%history(i, :) = past
   end subroutine remember
end module hampm_remembering
