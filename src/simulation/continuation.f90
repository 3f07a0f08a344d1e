!> Stop of a run before its end and its continuation, as if it had never stopped: its checkpoints, written and read.
module hampm_continuation
   use hampm_assembly, only: assemble, choose_integrator
   use hampm_checkpoint, only: checkpoint_t, checkpoint_name
   use hampm_crack_carrying, only: attach_cracks, archive_carried
   use hampm_cracks, only: archive_cracks, take_planes
   use hampm_failure, only: failure_t, exit_stopped
   use hampm_growing, only: new_growing, archive_growing
   use hampm_outer_forces, only: scale_loads
   use hampm_growth_room, only: see_around_tips
   use hampm_measurements, only: new_measurements, renew_fronts, archive_measurements
   use hampm_refinement, only: archive_refinement
   use hampm_model, only: model_t
   use hampm_simulation, only: simulation_t, rebuild_on_mesh
   use hampm_problem_checkpoint, only: keep_problem
   use hampm_text, only: to_text
   use hampm_threads, only: use_threads
   use hampm_version, only: program_name
   implicit none
   private
   public :: check_interruption, rebuild

contains

   !> Before a step: write a checkpoint where it is time, and stop where that is asked for.
   subroutine check_interruption(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: reason
      logical :: is_time
      if (failure%failed()) return
      reason = s%interruption%reason_to_stop(s%problem%state%steps)
      is_time = s%interruption%wants_checkpoint(s%problem%state%steps)
      if (reason /= '' .or. is_time) call write_checkpoint(s, reason /= '', failure)
      if (reason /= '' .and. .not. failure%failed()) call failure%report(exit_stopped, s%problem%state%when()// &
         'stopped by '//reason//'. To go on: '//program_name//' --resume '//checkpoint_name(s%results%path))
   end subroutine check_interruption

   !> Bring the result up to date, for the last time or not, and then write a checkpoint that continues it.
   subroutine write_checkpoint(s, is_last, failure)
      type(simulation_t), intent(inout) :: s
      logical, intent(in) :: is_last
      type(failure_t), intent(inout) :: failure
      type(checkpoint_t) :: checkpoint
      if (is_last) then
         call s%results%close(failure)
      else
         call s%results%flush(failure)
      end if
      if (failure%failed()) return
      s%lengths = s%results%lengths()
      call checkpoint%create(checkpoint_name(s%results%path))
      call checkpoint%archive_text('scene', s%model%as_used)
      call checkpoint%archive_text('scene_of_result', s%model%as_begun)
      call archive_cracks(s%cracks, checkpoint)
      call archive_growing(s%growing, checkpoint)
      call keep_problem(checkpoint, s%cracks, s%problem)
      call archive_rest(checkpoint, s)
      call checkpoint%finish(failure)
      call s%interruption%note_checkpoint(s%problem%state%steps)
   end subroutine write_checkpoint

   !> Build the simulation of a model as it was when a checkpoint of it was written.
   subroutine rebuild(model, threads, checkpoint, s, failure)
      type(model_t), intent(in) :: model
      integer, intent(in) :: threads
      type(checkpoint_t), intent(inout) :: checkpoint  !! open; it is closed
      type(simulation_t), intent(out) :: s
      type(failure_t), intent(inout) :: failure
      s%model = model
      s%warning = ''
      call assemble(model, s%problem, s%cracks, s%refinement, failure)
      call choose_integrator(model, s%integrator)
      if (.not. failure%failed()) then
         call attach_cracks(s%carried, s%problem, any(model%energy_release%chosen%needs_nodes))
         call new_measurements(model, s%problem, s%cracks, s%measurements) ! of the start, as G_ref is
         call new_growing(model, s%cracks, s%measurements%fronts, s%growing)
         call archive_cracks(s%cracks, checkpoint)
         call archive_growing(s%growing, checkpoint)
         call see_around_tips(model, s%cracks)
         if (s%growing%are_there() .and. s%growing%is_static) call scale_loads(s%problem, s%growing%load_factor)
         call keep_problem(checkpoint, s%cracks, s%problem)
         if (allocated(s%problem%grid%planes)) call take_planes(s%cracks, s%problem%grid%planes)
      end if
      if (.not. (failure%failed() .or. checkpoint%failure%failed())) then
         call use_threads(threads, s%problem%particles%n)
         call rebuild_on_mesh(s, failure)
         call archive_rest(checkpoint, s)
         if (.not. checkpoint%failure%failed()) call renew_fronts(s%model, s%problem, s%cracks, s%measurements)
      end if
      call checkpoint%finish(failure)
   end subroutine rebuild

   !> Archive all data beside the motion.
   subroutine archive_rest(checkpoint, s)
      type(checkpoint_t), intent(inout) :: checkpoint
      type(simulation_t), intent(inout) :: s
      integer :: n, k
      call archive_refinement(s%refinement, checkpoint)
      if (s%growing%are_there()) call archive_carried(s%carried, checkpoint)
      call archive_measurements(s%problem, s%measurements, checkpoint)
      call checkpoint%section('run')
      do k = 1, size(s%cracks%tips)              ! of the cells where tips were when the mesh changed last
         call checkpoint%serialise('spacing_'//to_text(k), s%cracks%tips(k)%nodes%spacing)
      end do
      call checkpoint%serialise('longest_step', s%longest_step)
      call checkpoint%serialise('stiffening', s%stiffening)
      call checkpoint%serialise('limit', s%limit)
      call checkpoint%serialise('steps_left', s%steps_left)
      call checkpoint%serialise('dt', s%dt)
      call s%integrator%serialise(s%problem, checkpoint)
      call checkpoint%serialise('samples', s%samples)
      call checkpoint%serialise('snapshots', s%snapshots)
      call checkpoint%serialise('largest_load', s%largest_load)
      if (size(s%model%accuracy) > 0 .and. .not. allocated(s%asked)) allocate (s%asked(size(s%model%accuracy)))
      do k = 1, size(s%model%accuracy)
         call s%asked(k)%serialise(checkpoint, 'asked_'//to_text(k))
      end do
      n = 0
      if (.not. checkpoint%is_read) n = size(s%lengths)
      call checkpoint%serialise('number_lengths', n)
      if (checkpoint%is_read) allocate (s%lengths(n))
      call checkpoint%archive_longs('lengths', n, s%lengths)
      call checkpoint%archive_text('warning', s%warning)
   end subroutine archive_rest
end module hampm_continuation
