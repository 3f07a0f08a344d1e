!> Growth of tips and fronts in a run, by one of five drivers: a load factor or a load frame at rest (`hampm_growth_at_rest`), load
!> cycles or time at rest (`hampm_growth_in_cycles`), and steps in motion (`hampm_growth_in_motion`).
module hampm_growth
   use hampm_failure, only: failure_t
   use hampm_growing, only: by_cycles, by_frame, by_load, by_steps, by_time
   use hampm_growth_at_rest, only: arrive, book_step, follow_control, grow, load_in_symmetry, load_to_onset
   use hampm_growth_in_cycles, only: follow_cycles, follow_time, grow_in_cycles
   use hampm_growth_in_motion, only: follow_motion, prepare_motion
   use hampm_interface_points, only: have_friction
   use hampm_rigid_motions, only: number_of_pieces
   use hampm_simulation, only: measure_state, simulation_t
   implicit none
   private
   public :: start_growth, prepare_growth, follow_growth

contains

   !> At a static start: as after a load step.
   subroutine start_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (s%growing%are_there()) s%growing%pieces = number_of_pieces(s%problem)
      if (.not. s%growing%is_static) return
      call measure_state(s, failure, in_passing=.true.)
      if (s%growing%driver == by_frame) s%growing%controlled = s%model%control%target_at(s%problem%state%time)
      if (s%growing%driver == by_cycles) call load_to_onset(s, failure)
      call drive(s, failure)
   end subroutine start_growth

   !> Before a step: let points grow in equilibrium, or prepare their advance in motion.
   subroutine prepare_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed() .or. .not. s%growing%are_there()) return
      select case (s%growing%driver)
       case (by_frame)                           ! they grow as the load frame moves
         s%problem%interfaces%keep_slip = have_friction(s%problem%interfaces)
       case (by_load)
         call grow(s, failure)
       case (by_cycles, by_time)
         call grow_in_cycles(s, failure)
       case (by_steps)
         call prepare_motion(s, failure)
      end select
   end subroutine prepare_growth

   !> After a step.
   subroutine follow_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed() .or. .not. s%growing%are_there()) return
      if (s%growing%is_static) call measure_state(s, failure)
      call drive(s, failure)
   end subroutine follow_growth

   !> Scale loads to the toughness in equilibrium, count cycles, let time pass, or let points move.
   subroutine drive(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      select case (s%growing%driver)
       case (by_frame)
         call follow_control(s, failure)
       case (by_load)
         call arrive(s, failure)
         call load_in_symmetry(s, failure)
         call load_to_onset(s, failure)
         call book_step(s, failure)
       case (by_cycles)
         call follow_cycles(s, failure)
       case (by_time)
         call follow_time(s, failure)
       case (by_steps)
         call follow_motion(s, failure)
      end select
   end subroutine drive
end module hampm_growth
