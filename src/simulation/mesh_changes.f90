!> Changes of the mesh during a run: cells refine and recombine, and cracks that grow or are carried cut them anew.
module hampm_mesh_changes
   use hampm_kinds, only: long
   use hampm_crack_carrying, only: carried_cracks_t, follow_cracks, place_cracks
   use hampm_cracks, only: open_planes
   use hampm_failure, only: failure_t
   use hampm_matching, only: adopt_lines
   use hampm_measurements, only: renew_fronts
   use hampm_problem, only: update_particles
   use hampm_refinement, only: refine, follow_particles
   use hampm_simulation, only: simulation_t, rebuild_on_mesh, limit_time_step
   use hampm_crack_lines, only: line_t
   implicit none
   private
   public :: adapt, adapt_static, carry_cracks, cut_anew, change_cut

contains

   !> After a step in motion: let particles and, at its interval, mesh follow the motion.
   subroutine adapt(s, steps_before, failure)
      type(simulation_t), intent(inout) :: s
      integer(long), intent(in) :: steps_before  !! how many steps had been done before it
      type(failure_t), intent(inout) :: failure
      type(carried_cracks_t) :: carried          ! as it fits the lines along which cells are cut
      type(line_t), allocatable :: lines(:)
      logical :: adapted
      if (failure%failed() .or. s%integrator%is_static) return
      if (.not. (s%refinement%is_active() .or. s%problem%has_domains())) return
      if (s%problem%cache%sorted) then
         call follow_particles(s%problem, failure)
         if (failure%failed()) return
         call limit_time_step(s)
      end if
      if (.not. s%refinement%is_due(s%problem%state%time, steps_before, s%problem%state%steps)) return
      call update_particles(s%problem)
      if (s%growing%are_there()) then            ! cells that are cut anew are so with the tips where they are now
         carried = s%carried
         allocate (lines, source=present_lines(s))
         call refine(s%refinement, s%problem, s%cracks%tip_places(), adapted, failure, lines)
         if (.not. adapted) s%carried = carried
      else
         call refine(s%refinement, s%problem, s%cracks%tip_places(), adapted, failure)
      end if
      if (adapted .and. .not. failure%failed()) call rebuild_on_mesh(s, failure)
      if (adapted .and. .not. failure%failed()) call s%integrator%initialise(s%problem, s%dt, failure)
   end subroutine adapt

   !> In equilibrium: refine the mesh and solve on it until the indicator asks for no more.
   subroutine adapt_static(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: adapted
      if (.not. s%integrator%is_static) return
      do while (s%refinement%follows_motion() .and. .not. failure%failed())
         call refine(s%refinement, s%problem, s%cracks%tip_places(), adapted, failure)
         if (failure%failed() .or. .not. adapted) return
         call rebuild_on_mesh(s, failure)
         if (.not. failure%failed()) call s%integrator%initialise(s%problem, s%longest_step, failure)
      end do
   end subroutine adapt_static

   !> After a step: let cracks that the material carries follow it.
   subroutine carry_cracks(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: moved
      type(line_t), allocatable :: lines(:)
      if (failure%failed() .or. .not. s%carried%are_there()) return
      lines = s%cracks%lines()
      call follow_cracks(s%carried, s%problem, lines, moved, failure)
      if (moved .and. .not. failure%failed()) call rebuild_on_mesh(s, failure)
   end subroutine carry_cracks

   !> Cut cells along cracks that have changed, let the mesh follow their tips, and find equilibrium.
   subroutine cut_anew(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      call change_cut(s, failure)
      if (.not. failure%failed()) call s%integrator%initialise(s%problem, s%longest_step, failure)
   end subroutine cut_anew

   !> The lines of the cracks where they are in the grid.
   function present_lines(s) result(lines)
      type(simulation_t), intent(inout) :: s
      type(line_t), allocatable :: lines(:)
      lines = s%cracks%lines()
      call place_cracks(s%carried, s%problem, lines)
   end function present_lines

   !> Cut cells along cracks that have changed, and let the mesh follow their tips.
   subroutine change_cut(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(line_t), allocatable :: lines(:)
      logical :: adapted
      call open_planes(s%cracks, s%problem%grid%planes)
      allocate (lines, source=present_lines(s))
      adapted = s%refinement%by%is_of_places
      if (adapted) call refine(s%refinement, s%problem, s%cracks%tip_places(), adapted, failure, lines)
      if (.not. adapted) call adopt_lines(s%problem, lines, failure)
      do while (adapted .and. .not. failure%failed())
         call refine(s%refinement, s%problem, s%cracks%tip_places(), adapted, failure)
      end do
      if (.not. failure%failed()) call rebuild_on_mesh(s, failure)
      if (.not. failure%failed()) call renew_fronts(s%model, s%problem, s%cracks, s%measurements)
   end subroutine change_cut
end module hampm_mesh_changes
