!> Refinement where much energy is stored: in cells whose mean energy density is above so many times that of all material.
module hampm_energy_indicator
   use hampm_kinds, only: dp
   use hampm_cell_values, only: is_occupied, sum_over_particles
   use hampm_indicator, only: refinement_t, may_refine
   use hampm_law, only: value_of
   use hampm_problem, only: problem_t, refresh_grid
   implicit none
   private
   public :: mark_by_energy

contains

   !> Mark the cells with more, and find the largest.
   subroutine mark_by_energy(r, m, tips, change)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: tips(:, :)
      integer, intent(inout) :: change(:)
      real(dp), allocatable :: energy(:)
      real(dp) :: mean, times
      integer :: i, leaf
      call refresh_grid(m)
      associate (p => m%particles)
         energy = [(p%volume(i)*m%materials(p%material(i))%energy_density(p%gradient_of(i), p%history_of(i), p%hoop_of(i)), &
                    i=1, p%n)]
         mean = sum(energy)/sum(p%volume(:p%n))
         r%value = 0
         if (.not. mean > 0) return
         do leaf = 1, size(change)
            if (.not. is_occupied(m%grid, m%blocks, leaf)) cycle
            times = sum_over_particles(m%grid, m%blocks, leaf, energy)/(mean*sum_over_particles(m%grid, m%blocks, leaf, p%volume))
            r%value = max(r%value, times)
            if (.not. times > value_of(r%constants, 'times_mean', 0.0_dp)) cycle
            if (may_refine(r, m, leaf)) change(leaf) = 1
         end do
      end associate
   end subroutine mark_by_energy
end module hampm_energy_indicator
