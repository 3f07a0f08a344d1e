!> How tips grow in a run: at rest by increments, under loads that are scaled until G is the toughness (`hampm_static_growth`); in
!> motion along ways for which the cells are cut in advance (`hampm_dynamic_growth`), in implicit steps at the pace that keeps G at
!> the toughness (`hampm_growth_pace`).
module hampm_growth
   use hampm_kinds, only: dp
   use hampm_crack_values, only: crack_values_t
   use hampm_cracks, only: cracks_t
   use hampm_failure, only: failure_t, exit_computation
   use hampm_growing, only: growing_t
   use hampm_static_growth, only: advance_tips, begin_to_turn, mixities_of, turn_tips, take_back, book_fracture, &
                                  factor_to_toughness, freed, correct_work, scale_loads
   use hampm_dynamic_growth, only: plan_ways, move_tips, must_check, start_tips, note_check
   use hampm_growth_pace, only: pace_t, begin_pace, follow_pace
   use hampm_measurements, only: measurements_t
   use hampm_mesh_changes, only: cut_anew, change_cut
   use hampm_problem, only: stored_energy, update_particles
   use hampm_simulation, only: simulation_t, measure_state
   use hampm_symmetric_turns, only: symmetric_turns_t
   implicit none
   private
   public :: start_growth, prepare_growth, advance_in_pace, follow_growth

contains

   !> At the start, at rest: scale the loads to the toughness.
   subroutine start_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (.not. s%growing%is_static) return
      call measure_state(s, failure)
      call load_to_toughness(s, failure)
   end subroutine start_growth

   !> Before a step: let tips grow at rest, or plan their ways in motion.
   subroutine prepare_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed() .or. .not. s%growing%are_there()) return
      if (s%growing%is_static) then
         call grow(s, failure)
         s%growing%stored_grown = stored_energy(s%problem)
         return
      end if
      if (must_check(s%growing, s%model, s%problem, s%cracks)) call check_tips(s, failure)
      if (.not. s%growing%is_paced) call plan_growth(s, failure)
   end subroutine prepare_growth

   !> Plan the ways of tips, and cut cells along them.
   subroutine plan_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: have_planned
      if (failure%failed()) return
      call plan_ways(s%growing, s%model, s%problem, s%cracks, s%dt, have_planned, s%warning)
      if (.not. have_planned) return
      call update_particles(s%problem)
      call change_cut(s, failure)
      if (.not. failure%failed()) call s%integrator%initialise(s%problem, s%dt, failure)
   end subroutine plan_growth

   !> Advance by an implicit step with tips that grow: tried with other ways until G keeps to the toughness (`hampm_growth_pace`).
   subroutine advance_in_pace(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(growing_t) :: growing
      type(cracks_t) :: cracks
      type(measurements_t) :: measurements
      type(pace_t) :: pace
      character(:), allocatable :: warning
      logical :: is_over
      warning = ''
      call begin_pace(s%growing, s%dt, pace)
      call update_particles(s%problem)
      do
         call plan_growth(s, failure)
         if (failure%failed()) return
         call s%integrator%note_start(s%problem)
         if (allocated(s%warning)) warning = s%warning
         measurements = s%measurements
         cracks = s%cracks
         growing = s%growing
         call move_tips(s%growing, s%model, s%problem, s%cracks, s%problem%state%time, s%dt, s%warning)
         call s%integrator%advance(s%problem, s%dt, failure)
         call check_tips(s, failure)
         if (failure%failed()) return
         call follow_pace(pace, s%growing, s%cracks, s%dt, is_over)
         if (is_over) exit
         growing%tips%way = s%growing%tips%way
         growing%tips%fall = s%growing%tips%fall
         growing%tips%is_running = s%growing%tips%is_running
         growing%tips%memory = s%growing%tips%memory
         s%growing = growing
         s%cracks = cracks
         s%measurements = measurements
         if (allocated(s%warning)) deallocate (s%warning)
         if (len(warning) > 0) s%warning = warning
         call s%integrator%go_to_start(s%problem)
      end do
   end subroutine advance_in_pace

   !> In motion: measure G and K, and let tips start whose loading has reached the toughness.
   subroutine check_tips(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed()) return
      call update_particles(s%problem)
      call measure_state(s, failure)
      if (failure%failed()) return
      call note_check(s%growing, s%cracks, s%measurements%crack)
      call start_tips(s%growing, s%model, s%problem, s%cracks, s%measurements%crack)
   end subroutine check_tips

   !> After a step: scale loads to the toughness at rest, or let tips move.
   subroutine follow_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(symmetric_turns_t) :: turns
      if (failure%failed() .or. .not. s%growing%are_there()) return
      if (s%growing%is_static) then
         call measure_state(s, failure)
         call turn_to_symmetry(s, turns, failure) ! loads that do not all change alike, and finer cells, have changed K_II
         call load_to_toughness(s, failure)
      else if (.not. s%growing%is_paced) then
         call move_tips(s%growing, s%model, s%problem, s%cracks, s%problem%state%time - s%dt, s%dt, s%warning)
      end if
   end subroutine follow_growth

   !> Before a load step: let tips advance, and find equilibrium with them where they are.
   subroutine grow(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(cracks_t) :: before
      type(crack_values_t), allocatable :: values(:)
      type(symmetric_turns_t) :: turns
      integer, allocatable :: attempts(:)
      logical :: have_moved, have_cut, is_over
      call measure_state(s, failure)
      if (failure%failed()) return
      before = s%cracks
      values = s%measurements%crack
      allocate (attempts(size(values)), source=0)
      have_cut = .false.
      do
         call advance_tips(s%growing, s%model, s%cracks, values, attempts, have_moved, s%warning)
         if (have_moved .or. have_cut) call cut_anew(s, failure)
         if (.not. have_moved .or. failure%failed()) return
         have_cut = .true.
         call measure_state(s, failure)
         call turn_to_symmetry(s, turns, failure)
         if (failure%failed() .or. turns%have_found()) return
         call take_back(s%growing, s%model, s%cracks, before, turns, attempts, is_over, s%warning)
         if (is_over) return
      end do
   end subroutine grow

   !> By local symmetry: turn the last increments of the tips until these have no K_II, from what was measured last, and measure.
   subroutine turn_to_symmetry(s, turns, failure)
      type(simulation_t), intent(inout) :: s
      type(symmetric_turns_t), intent(out) :: turns
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: turn(:)
      integer :: is_in_the_way
      logical :: are_over
      call begin_to_turn(s%growing, s%model, s%cracks, turns)
      allocate (turn(size(turns%tip)))
      are_over = .false.
      do
         if (failure%failed()) return
         if (.not. are_over) call turns%note(mixities_of(s%measurements%crack, turns%tip))
         if (turns%have_found() .or. are_over) return
         call turns%choose(turn, are_over)
         call turn_tips(s%model, s%cracks, turns%tip, turn, is_in_the_way)
         call cut_anew(s, failure)
         call measure_state(s, failure)
      end do
   end subroutine turn_to_symmetry

   !> After a load step, or at the start, when all is measured: scale the loads until the largest G is the toughness: as if the root of G were
   !> proportional to them, which it is in a linear body that they alone drive, then by the secant through what the last two factors gave.
   subroutine load_to_toughness(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: near = 1e-6_dp      ! of the factor
      integer, parameter :: most = 30
      real(dp) :: factor, before, by_advance, change, root, last_root, last_factor
      integer :: attempt
      if (failure%failed()) return
      before = s%growing%load_factor
      last_root = 0
      last_factor = 1
      by_advance = freed(s%growing, s%problem)
      change = 1
      do attempt = 1, most
         factor = factor_to_toughness(s%growing, s%model, s%cracks, s%measurements%crack)
         if (attempt > 1 .and. abs(factor - 1) < near) exit
         root = 1/factor
         if (attempt > 1) factor = by_secant(last_factor, last_root, root)
         last_root = root
         last_factor = factor
         call correct_work(s%growing, factor*s%growing%load_factor/before, by_advance, change, s%problem)
         call s%integrator%rescale(s%problem, factor, failure)
         if (failure%failed()) return
         s%growing%load_factor = factor*s%growing%load_factor
         call scale_loads(s%growing, s%problem)
         call measure_state(s, failure)
         if (failure%failed()) return
      end do
      if (attempt > most) then
         call failure%report(exit_computation, s%problem%state%when()//'no factor of the loads was found that '// &
                             'brings G to the toughness: G hardly depends on them, as where an eigenstrain opens the crack')
         return
      end if
      call book_fracture(s%growing, s%model, s%cracks, s%measurements%crack, s%problem)
   end subroutine load_to_toughness

   !> By what to multiply a load so that the root of G over the toughness, a function of the load, is 1, by the secant through its last two values: by
   !> no more than `farthest` and no less than its inverse, and never less of a load that does not suffice, where it closes a tip.
   pure real(dp) function by_secant(last_factor, last_root, root) result(factor)
      real(dp), intent(in) :: last_factor        !! by which the load was multiplied last
      real(dp), intent(in) :: last_root          !! before that
      real(dp), intent(in) :: root               !! after it
      real(dp), parameter :: farthest = 3
      real(dp) :: rise, change
      factor = 1/root
      rise = root - last_root
      if (abs(rise) < epsilon(rise)) return
      change = (1 - root)*(1 - 1/last_factor)/rise         ! of the load, in parts of it
      if (root > 1 .or. change > 0) factor = max(1/farthest, min(farthest, 1 + change))
   end function by_secant
end module hampm_growth
