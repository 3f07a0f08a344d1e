!> The start of a motion from static equilibrium: before the first step the displacement is found at which internal forces balance
!> loads, prescribed displacements and eigenstrains at time 0. Constant ones make no waves.
!>
!> It is the equilibrium of a static model (`hampm_equilibrium`) on the cells of the motion, with shape functions at the reference
!> positions. In the updated frame particles then move by their displacements and are sorted into the cells there.
module hampm_static_start
   use hampm_domains, only: start_domains, displace_corners
   use hampm_equilibrium, only: equilibrium_t
   use hampm_failure, only: failure_t
   use hampm_integrator, only: integrator_t
   use hampm_mesh_changes, only: adapt_static, carry_cracks
   use hampm_problem, only: start_problem, sort_anew
   use hampm_simulation, only: simulation_t, rebuild_on_mesh
   implicit none
   private
   public :: begin_at_rest

contains

   !> Bring a simulation to the equilibrium at its present time, if its model asks for that. Fails if there is none.
   subroutine begin_at_rest(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      class(integrator_t), allocatable :: motion
      type(equilibrium_t) :: rest
      logical :: in_total_frame
      if (s%model%method%start /= 'static' .or. s%integrator%is_static) return
      in_total_frame = s%problem%particles%total_frame
      call move_alloc(s%integrator, motion)
      rest%newton%solver = s%model%method%solver
      rest%is_static = .true.
      rest%forgets_mesh = .true.
      allocate (s%integrator, source=rest)
      call switch(s, .true., .true., failure)
      if (.not. failure%failed()) call s%integrator%initialise(s%problem, s%longest_step, failure)
      call adapt_static(s, failure)
      call move_alloc(motion, s%integrator)
      if (failure%failed()) return
      if (s%model%method%time == 'explicit') deallocate (s%problem%state%displacement)
      call switch(s, .false., in_total_frame, failure)
      call carry_cracks(s, failure)
   end subroutine begin_at_rest

   !> Make a simulation one of rest or of motion, on the same cells.
   subroutine switch(s, is_static, in_total_frame, failure)
      type(simulation_t), intent(inout) :: s
      logical, intent(in) :: is_static, in_total_frame
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: scheme
      associate (m => s%problem, p => s%problem%particles)
         scheme = trim(m%scheme%name)
         m%is_explicit = s%model%method%time == 'explicit' .and. .not. is_static
         m%interfaces%are_moving = .not. is_static
         m%materials%is_trial = is_static .or. s%model%method%time /= 'explicit'
         m%materials%time_increment = 0
         s%refinement%is_static = is_static
         p%total_frame = in_total_frame
         if (is_static .and. m%has_domains()) then
            deallocate (p%corner_displacement, p%corner_velocity)
         else if (s%model%method%has_domains()) then
            call start_domains(p)
            call displace_corners(p)
         end if
         call sort_anew(m, failure)
         if (.not. failure%failed()) call start_problem(m, scheme, failure)
      end associate
      if (.not. failure%failed()) call rebuild_on_mesh(s, failure)
   end subroutine switch
end module hampm_static_start
