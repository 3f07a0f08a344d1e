!> Growth of tips in a run: quasi-static by increments, under loads that are scaled until G is the toughness, or in load cycles
!> (`hampm_static_growth`); in motion along paths whose cells are cut in advance (`hampm_dynamic_growth`), in implicit steps at the
!> advance that keeps G at the toughness (`hampm_growth_pace`).
module hampm_growth
   use hampm_kinds, only: dp
   use hampm_crack_tip_field, only: modes
   use hampm_crack_values, only: crack_values_t
   use hampm_cracks, only: cracks_t
   use hampm_failure, only: failure_t, exit_computation
   use hampm_dynamic_front_growth, only: law_of_plane, ways_of_fronts, find_speeds, note_state
   use hampm_moving_front, only: advance_region, fronts_of
   use hampm_nodal_state, only: internal_force, external_force
   use hampm_plane_cuts, only: find_unbonded, open_more
   use hampm_plane_points, only: follow_fronts, late_release
   use hampm_fatigue, only: count_cycles, has_fractured, has_loads, largest_loads
   use hampm_static_front_growth, only: advance_points, at_points, even_out_points
   use hampm_growing, only: growing_t, next_t
   use hampm_growth_points, only: next_of_points, ratios_of, book_fracture
   use hampm_growth_room, only: see_around_tips
   use hampm_load_search, only: load_search_t, nothing
   use hampm_static_growth, only: advance_tips, begin_to_turn, mixities_of, turn_tips, take_back, &
                                  has_held_drive, has_scaled_drive, book_work, look_at_frame
   use hampm_dynamic_growth, only: plan_ways, move_tips, must_check, start_tips, note_check
   use hampm_growth_room, only: is_plane_open, find_loose_tips
   use hampm_growth_pace, only: pace_t, begin_pace, follow_pace
   use hampm_interface_points, only: have_friction, commit_slip, is_half
   use hampm_measurements, only: measurements_t, measure_tips, has_measured_tips, part_of_rate
   use hampm_mesh_changes, only: cut_anew, change_cut
   use hampm_nucleation, only: find_onset, let_appear, book_onset
   use hampm_problem, only: problem_t, stored_energy, update_particles, refresh_grid
   use hampm_rigid_motions, only: number_of_pieces
   use hampm_outer_forces, only: scale_loads
   use hampm_state, only: energies_t
   use hampm_simulation, only: simulation_t, measure_state
   use hampm_symmetric_turns, only: symmetric_turns_t, is_symmetric
   use hampm_text, only: add_line, digits_text, three_digits, to_text
   implicit none
   private
   real(dp), parameter :: near = 1e-6_dp         !! part of the toughness, and of the controlled quantity

   public :: start_growth, prepare_growth, advance_in_pace, follow_growth

contains

   !> At a static start: scale the loads to the toughness.
   subroutine start_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (s%growing%are_there()) s%growing%pieces = number_of_pieces(s%problem)
      if (.not. s%growing%is_static) return
      call measure_state(s, failure, in_passing=.true.)
      if (s%model%control%leads()) then
         s%growing%controlled = s%model%control%target_at(s%problem%state%time)
         call follow_control(s, failure)
      else
         if (.not. s%growing%is_cyclic) call load_to_toughness(s, failure)
         call load_to_onset(s, failure)
         call book_step(s, failure)
         if (s%growing%is_cyclic) call look_at_cycles(s, s%growing%fatigue%at, failure)
      end if
   end subroutine start_growth

   !> Before a step: let tips grow in equilibrium, or plan their paths in motion.
   subroutine prepare_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed() .or. .not. s%growing%are_there()) return
      if (s%growing%is_static) then
         s%problem%interfaces%keep_slip = have_friction(s%problem%interfaces)
         if (s%growing%is_cyclic) then
            call grow_in_cycles(s, failure)
         else if (.not. s%model%control%leads()) then
            call grow(s, failure)
         end if
         return
      end if
      if (allocated(s%growing%planes)) then
         if (s%problem%interfaces%are_bounded) return
         call check_fronts(s, failure)
         if (.not. failure%failed()) call move_fronts(s, s%problem%state%time, failure)
         return
      end if
      if (must_check(s%growing, s%model, s%problem, s%cracks)) call check_tips(s, failure)
      if (.not. s%growing%is_paced) call plan_growth(s, failure)
   end subroutine prepare_growth

   !> Advance the fronts of plane cracks in a step and release the points behind them: after an explicit step, before an implicit
   !> one, which ends in balance with them.
   subroutine move_fronts(s, time, failure)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: time               !! at its start [s]
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: ways(:)
      real(dp) :: dropped, released
      logical :: meets_itself, have_moved
      integer :: k
      associate (m => s%problem)
         have_moved = .false.
         do k = 1, size(m%grid%planes)
            associate (plane => m%grid%planes(k), growing => s%growing%planes(k))
               if (growing%has_stopped) then
                  growing%is_running = .false.
                  growing%mean = 0
                  growing%largest = 0
               end if
               if (.not. growing%grows .or. growing%has_stopped) cycle
               ways = ways_of_fronts(s%model, s%cracks, s%growing%planes, s%growing%fronts, k, time, s%dt)
               call advance_region(s%cracks%regions(k), pack(s%cracks%fronts, s%cracks%fronts%crack == k), ways, meets_itself)
               plane%region_t = s%cracks%regions(k)
               have_moved = have_moved .or. any(ways > 0)
               call find_unbonded(plane, m%grid%forest)
               call fronts_of(s%cracks%regions, s%cracks%fronts)
               call note_state(growing, k, s%cracks, ways, m%materials(1), time, s%dt, meets_itself, s%warning)
            end associate
         end do
         if (.not. have_moved) return
         call follow_fronts(m%interfaces, m%matter_t, m%interfaces%are_bounded, dropped, released)
         m%energies%fracture_energy = m%energies%fracture_energy + released
         if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss + (dropped - released)
         if (.not. open_more(m%grid%planes, m%grid%forest)) return
         call update_particles(m)
         call change_cut(s, failure)
         if (.not. failure%failed()) call s%integrator%initialise(m, s%dt, failure)
         if (.not. failure%failed()) call hold_new_nodes(m)
      end associate
   end subroutine move_fronts

   !> Measure along fronts, and find the speeds for the next step of the fronts that grow by their toughness: after an explicit step
   !> has moved them, before an implicit one does. Fronts that do not grow in it rest.
   subroutine check_fronts(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      integer :: k
      if (failure%failed() .or. all(s%model%growth%law%gives_speed())) return
      associate (m => s%problem, now => s%problem%state%time)
         if (all([(law_of_plane(s%model, s%growing%planes, k, now, s%dt) == 0, k=1, size(m%grid%planes))])) then
            if (size(s%growing%fronts) > 0) deallocate (s%growing%fronts)
            if (.not. allocated(s%growing%fronts)) allocate (s%growing%fronts(0))
            return
         end if
         call update_particles(m)
         call measure_tips(s%model, m, s%cracks, s%measurements, failure)
         if (.not. failure%failed()) &
            call find_speeds(s%model, m%materials, s%cracks, s%measurements%fronts, now, s%dt, m%grid%finest_cell, &
                             s%growing%planes, s%growing%fronts)
      end associate
   end subroutine check_fronts

   !> Hold nodes that have become open by points with the force that keeps the material on both sides together.
   subroutine hold_new_nodes(m)
      type(problem_t), intent(inout) :: m
      real(dp), allocatable :: force(:, :), loads(:, :), mass(:, :)
      real(dp) :: weight, light
      integer :: k, side
      if (.not. any(m%interfaces%list(:m%interfaces%n)%is_new)) return
      call refresh_grid(m)
      call internal_force(m, force)
      call external_force(m, m%state%time, loads)
      force = force + loads
      allocate (mass(1, m%grid%n_points), source=0.0_dp)
      do k = 1, m%particles%n
         mass(1, m%nodes_of(k)) = mass(1, m%nodes_of(k)) + m%particles%mass(k)*m%functions_of(k)
      end do
      call m%grid%dofs%condense(m%fields%mass_matrix%all, 1, mass)
      do k = 1, m%interfaces%n
         associate (point => m%interfaces%list(k))
            if (.not. point%is_new) cycle
            point%is_new = .false.
            weight = 0
            do side = 1, count(point%jump%node > 0)
               light = 1/mass(1, point%jump%node(side))
               weight = weight + light
               point%initial_force = point%initial_force + point%jump%share(side)*light*force(:, point%jump%node(side))
            end do
            point%initial_force = point%initial_force/weight
            if (is_half(point)) point%initial_force = dot_product(point%initial_force, point%normal)*point%normal
         end associate
      end do
   end subroutine hold_new_nodes

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

   !> In motion: measure G and K, unless a row has done so, and let tips start whose loading has reached the toughness.
   subroutine check_tips(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed()) return
      if (s%growing%is_paced .or. .not. has_measured_tips(s%problem, s%measurements)) then ! a pace is tried more than once
         call update_particles(s%problem)
         call measure_tips(s%model, s%problem, s%cracks, s%measurements, failure)
      end if
      if (failure%failed()) return
      call note_check(s%growing, s%cracks, s%measurements%crack)
      call start_tips(s%growing, s%model, s%problem, s%cracks, s%measurements%crack, s%dt, s%warning)
   end subroutine check_tips

   !> After a step: scale loads to the toughness in equilibrium, or let tips move.
   subroutine follow_growth(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      real(dp) :: late                           ! released by fronts in an implicit step beyond the value at its start [J]
      if (failure%failed() .or. .not. s%growing%are_there()) return
      if (s%growing%is_static) then
         call measure_state(s, failure)
         if (s%model%control%leads()) then
            call follow_control(s, failure)
         else if (s%growing%is_cyclic) then
            call follow_cycles(s, failure)
         else
            call load_in_symmetry(s, failure)
            call load_to_onset(s, failure)
            call book_step(s, failure)
         end if
      else if (allocated(s%growing%planes)) then
         if (s%problem%interfaces%are_bounded) then
            call move_fronts(s, s%problem%state%time - s%dt, failure)
            call check_fronts(s, failure)
            return
         end if
         late = late_release(s%problem%interfaces)
         s%problem%energies%fracture_energy = s%problem%energies%fracture_energy + late
         if (s%problem%audit) s%problem%energies%numerical_loss = s%problem%energies%numerical_loss - late
         return
      else if (.not. s%growing%is_paced) then
         call move_tips(s%growing, s%model, s%problem, s%cracks, s%problem%state%time - s%dt, s%dt, s%warning)
      end if
      if (.not. s%growing%is_static) call follow_ends(s, failure)
   end subroutine follow_growth

   !> In motion, after a step: cut cells anew where tips have ended, and check whether bodies separate where all points failed.
   subroutine follow_ends(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: is_new
      if (s%growing%has_new_end) then
         s%growing%has_new_end = .false.
         call update_particles(s%problem)
         call change_cut(s, failure)
         if (.not. failure%failed()) call s%integrator%initialise(s%problem, s%dt, failure)
      end if
      call find_loose_tips(s%growing, s%problem%interfaces, is_new)
      if (is_new .and. .not. failure%failed()) call note_separation(s, s%problem%state%time)
   end subroutine follow_ends

   !> Before a load step: let tips advance, and find equilibrium with them where they are.
   subroutine grow(s, failure, has_grown)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical, intent(out), optional :: has_grown !! whether a tip has advanced
      type(cracks_t) :: before
      type(crack_values_t), allocatable :: values(:)
      type(next_t), allocatable :: next(:)
      type(symmetric_turns_t) :: turns
      integer, allocatable :: attempts(:)
      integer :: stopped
      logical :: have_moved, have_cut, is_over
      if (present(has_grown)) has_grown = .false.
      s%problem%interfaces%keep_slip = have_friction(s%problem%interfaces)
      if (.not. has_scaled_drive(s%problem)) return
      if (s%growing%onset_crack > 0) then
         call appear(s, failure)
         return
      end if
      call measure_state(s, failure)
      if (failure%failed()) return
      before = s%cracks
      call values_of_growth(s, values, failure)
      if (failure%failed()) return
      next = next_of_points(s%growing, s%model, s%cracks, values, s%measurements%fronts)
      allocate (attempts(size(values)), source=0)
      have_cut = .false.
      do
         stopped = count(s%growing%tips%has_stopped)
         if (has_fronts(s)) then
            call advance_points(s%growing, s%model, next, s%measurements%fronts, s%cracks, have_moved, s%warning)
         else
            call advance_tips(s%growing, s%model, s%cracks, values, next, attempts, have_moved, s%warning)
         end if
         if (.not. have_moved .and. count(s%growing%tips%has_stopped) > stopped) cycle ! others may go on, in later cycles too
         if (have_moved .or. have_cut) call cut_at_rest(s, failure)
         if (.not. have_moved .or. failure%failed() .or. s%is_over) return
         have_cut = .true.
         if (present(has_grown)) has_grown = .true.
         call measure_state(s, failure)
         call turn_to_symmetry(s, turns, failure)
         if (failure%failed() .or. turns%have_found()) return
         call take_back(s%growing, s%model, s%cracks, before, turns, attempts, is_over, s%warning)
         if (is_over) return
      end do
   end subroutine grow

   !> Before a load step: let a crack appear at the load of the step before.
   subroutine appear(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      real(dp) :: stored
      stored = stored_energy(s%problem)
      call let_appear(s)
      call cut_at_rest(s, failure)
      if (.not. (failure%failed() .or. s%is_over)) call book_onset(s, stored, failure)
   end subroutine appear

   !> When loads are scaled so that tips are about to grow: scale them so that a crack is about to appear, where that comes first.
   subroutine load_to_onset(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      real(dp) :: factor
      if (failure%failed() .or. .not. s%growing%have_onsets) return
      call find_onset(s, any(ratios(s) > nothing), factor, failure)
      if (.not. failure%failed()) call rescale(s, factor, failure)
   end subroutine load_to_onset

   !> Before a load step with cycles: let tips advance. Where none does, or one breaks, the run is over.
   subroutine grow_in_cycles(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: has_grown
      if (has_fractured(s%growing%fatigue)) then
         s%is_over = .true.
         s%growing%fatigue%life = s%growing%fatigue%cycles
         call tell_fracture(s)
         return
      end if
      call grow(s, failure, has_grown)
      if (.not. (failure%failed() .or. s%is_over .or. has_grown)) then
         s%is_over = .true.
         call add_line(s%warning, 'the run ends before end_time, as no tip grows any more in the load cycles that follow'// &
                       trim(merge(repeat(' ', 48), ': the loads close the crack at both ends of each', &
                                  has_loads(s%growing%fatigue))))
      end if
   end subroutine grow_in_cycles

   !> After a load step with cycles, when all is measured: count the cycles that tips have taken for their ways.
   subroutine follow_cycles(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(symmetric_turns_t) :: turns
      real(dp), allocatable :: ways(:), now(:, :, :)
      real(dp) :: before                         ! cycles
      real(dp) :: off                            ! part of K by which it may be [-]
      logical :: have_arrested
      before = s%growing%fatigue%cycles
      call turn_to_symmetry(s, turns, failure)
      ways = s%growing%tips%advance
      call book_step(s, failure)
      now = s%growing%fatigue%at
      call look_at_cycles(s, now, failure)
      if (failure%failed()) return
      off = part_of_rate(s%problem, s%cracks, s%measurements)/2
      if (has_fronts(s)) then
         call follow_points()
      else
         call count_cycles(s%growing%fatigue, s%model, ways, now, off, have_arrested)
      end if
      s%is_over = have_arrested .or. s%growing%fatigue%life >= 0
      if (s%growing%fatigue%life >= 0) then
         call tell_fracture(s)
      else if (have_arrested) then
         call add_line(s%warning, 'the run ends before end_time, as tips arrest within the next increment: their range of K '// &
                       'falls to the threshold')
      else if (s%growing%fatigue%cycles - before < 1) then
         call tell_fast_growth()
      end if

   contains

      !> Warn once that an increment took less than a cycle: no law of cycles there, or its constants are for other units.
      subroutine tell_fast_growth()
         character(*), parameter :: fast = 'an increment of growth has taken less than one load cycle'
         if (allocated(s%warning)) then
            if (index(s%warning, fast) > 0) return
         end if
         call add_line(s%warning, s%problem%state%when()//fast//', '//three_digits(s%growing%fatigue%cycles - before)// &
                       ' of it for '//three_digits(maxval(ways))//' m, where K is '// &
                       three_digits(sqrt(maxval(sum(s%growing%fatigue%at(:modes, 1, :)**2, dim=1))))// &
                       ' Pa m^0.5: the law of growth is not for such K. Likely cause: &growth rate_constant is for K in '// &
                       'MPa m^0.5 or ways in mm, not in Pa m^0.5 and m; or loads are too large')
      end subroutine tell_fast_growth

      !> Count the cycles at points of fronts: at their present places, once these are evenly spaced again.
      subroutine follow_points()
         real(dp) :: there(size(now, 1), size(now, 2), size(now, 3))
         integer :: l
         do l = 1, size(now, 2)
            there(:, l, :) = at_points(s%growing, s%measurements%fronts, now(:, l, :))
         end do
         call count_cycles(s%growing%fatigue, s%model, ways, there, off, have_arrested)
         s%growing%fatigue%at = now
         call even_out_points(s%growing, s%measurements%fronts, s%growing%fatigue%owed)
         call even_out_points(s%growing, s%measurements%fronts, s%growing%fatigue%zone)
      end subroutine follow_points
   end subroutine follow_cycles

   !> Tell after how many cycles a crack breaks through.
   subroutine tell_fracture(s)
      type(simulation_t), intent(inout) :: s
      call add_line(s%warning, 'fracture after '//digits_text(s%growing%fatigue%life, 6)//' cycles: the largest K reaches that '// &
                    'of the toughness; the run ends before end_time')
   end subroutine tell_fracture

   !> After a load step, measured and booked: find K and K over K_c at each load of the cycles. One solution gives all if the model
   !> is proportional to the loads, else each load takes one; faces then slide from their state at the largest load.
   subroutine look_at_cycles(s, now, failure)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(inout) :: now(:, :, :)    !! (modes and part of K_c, loads, tips)
      type(failure_t), intent(inout) :: failure
      type(measurements_t) :: measurements
      type(energies_t) :: energies
      integer :: l
      if (failure%failed()) return
      measurements = s%measurements
      energies = s%problem%energies
      call take(1, 1.0_dp)
      do l = 2, size(s%growing%fatigue%level)
         if (one_load_tells(s)) then
            call take(l, s%growing%fatigue%level(l))
         else
            call go_to_load(s, s%growing%fatigue%level(l), failure)
            if (failure%failed()) return
            call take(l, 1.0_dp)
         end if
      end do
      if (size(s%growing%fatigue%level) > 1) call go_back(s, measurements, energies, failure)
   contains
      !> Take the measurements, times a factor, for a load.
      subroutine take(l, factor)
         integer, intent(in) :: l                !! number of the load
         real(dp), intent(in) :: factor          !! [-]
         type(next_t) :: next(size(now, 3))
         integer :: k
         next = next_of_points(s%growing, s%model, s%cracks, s%measurements%crack, s%measurements%fronts, factor)
         do k = 1, size(next)
            if (.not. next(k)%is_there) cycle
            now(:modes, l, k) = next(k)%intensity
            if (next(k)%toughness > 0) now(modes + 1, l, k) = sqrt(max(0.0_dp, next(k)%rate)/next(k)%toughness)
         end do
      end subroutine take
   end subroutine look_at_cycles

   !> Measurements at tips that are about to advance or turn: in load cycles at the load at which K of each is the largest.
   subroutine values_of_growth(s, values, failure)
      type(simulation_t), intent(inout) :: s
      type(crack_values_t), allocatable, intent(out) :: values(:)
      type(failure_t), intent(inout) :: failure
      type(measurements_t) :: measurements
      type(energies_t) :: energies
      real(dp) :: factor                         ! of K over the measured one [-]
      integer :: load(size(s%growing%tips)), l, k
      values = s%measurements%crack
      if (failure%failed() .or. .not. s%growing%is_cyclic) return
      load = largest_loads(s%growing%fatigue)
      if (all(load(:size(values)) == 1)) return
      measurements = s%measurements
      energies = s%problem%energies
      do l = 2, size(s%growing%fatigue%level)
         if (.not. any(load(:size(values)) == l)) cycle
         factor = s%growing%fatigue%level(l)
         if (.not. one_load_tells(s)) then
            call go_to_load(s, factor, failure)
            if (failure%failed()) return
            factor = 1
         end if
         do k = 1, size(values)
            if (load(k) == l) values(k) = s%measurements%crack(k)%times(factor)
         end do
      end do
      call go_back(s, measurements, energies, failure)
   end subroutine values_of_growth

   !> Whether all is proportional to the loads.
   pure logical function one_load_tells(s)
      type(simulation_t), intent(in) :: s
      associate (m => s%problem)
         one_load_tells = all(m%materials%linear) .and. m%interfaces%n_contact == 0 .and. &
                          .not. (has_held_drive(m) .or. m%constraints%only_push())
      end associate
   end function one_load_tells

   !> Solve at another load of the cycles; faces slide from their present state.
   subroutine go_to_load(s, factor, failure)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: factor             !! [-]
      type(failure_t), intent(inout) :: failure
      s%problem%interfaces%keep_slip = have_friction(s%problem%interfaces)
      call rescale(s, factor, failure)
   end subroutine go_to_load

   !> Return to the load of the model after solutions at others.
   subroutine go_back(s, measurements, energies, failure)
      type(simulation_t), intent(inout) :: s
      type(measurements_t), intent(in) :: measurements !! of before
      type(energies_t), intent(in) :: energies   !! the same
      type(failure_t), intent(inout) :: failure
      if (one_load_tells(s)) return
      call rescale(s, 1.0_dp, failure)
      s%problem%interfaces%keep_slip = .false.
      s%measurements = measurements
      s%problem%energies = energies
   end subroutine go_back

   !> In equilibrium: cut cells along cracks that have grown, and solve. Where a body has separated and a piece has no equilibrium
   !> the run is over; where a displacement is prescribed the piece moves with the load frame, without load.
   subroutine cut_at_rest(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: of_pieces
      call change_cut(s, failure)
      if (failure%failed()) return
      call note_separation(s, s%problem%state%time + s%dt)
      call s%integrator%initialise(s%problem, s%longest_step, of_pieces)
      if (.not. of_pieces%failed()) return
      if (s%growing%separated >= 0 .and. s%model%control%leads() .and. s%model%control%quantity == 'displacement') then
         s%growing%is_adrift = .true.
         s%growing%load_factor = 0
         call scale_loads(s%problem, 0.0_dp)
         of_pieces = failure
         call s%integrator%initialise(s%problem, s%longest_step, of_pieces)
         if (.not. of_pieces%failed()) return
      end if
      s%is_over = s%growing%separated >= 0
      if (s%is_over) then
         call add_line(s%warning, 'the run ends before end_time, as pieces have no equilibrium: '//of_pieces%message)
      else
         failure = of_pieces
      end if
   end subroutine cut_at_rest

   !> Record whether cracks have separated a body.
   subroutine note_separation(s, time)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: time               !! [s]
      character(:), allocatable :: how
      integer :: pieces
      s%growing%has_new_end = .false.
      if (s%growing%separated >= 0 .or. .not. (any(s%cracks%tips%has_ended) .or. any(s%growing%tips%has_ended))) return
      pieces = number_of_pieces(s%problem)
      if (is_plane_open(s%model, s%cracks) .or. any(s%measurements%fronts%has_ended .and. &
                                                      s%measurements%fronts%domain%front%is_symmetry)) then
         how = 'nothing joins the half body to its mirror image'
      else if (pieces > s%growing%pieces) then
         how = 'all material is in '//to_text(pieces)//' pieces, in '//to_text(s%growing%pieces)//' at the start'
      else
         return
      end if
      s%growing%separated = time
      call add_line(s%warning, 'separated at t = '//digits_text(time, 6)//' s: '//how)
   end subroutine note_separation

   !> By local symmetry: turn the last increments of the tips until these have no K_II, from the last measurements, and measure.
   subroutine turn_to_symmetry(s, turns, failure)
      type(simulation_t), intent(inout) :: s
      type(symmetric_turns_t), intent(out) :: turns
      type(failure_t), intent(inout) :: failure
      type(crack_values_t), allocatable :: values(:)
      real(dp), allocatable :: turn(:)
      integer :: is_in_the_way
      logical :: are_over
      call begin_to_turn(s%growing, s%model, s%cracks, turns)
      allocate (turn(size(turns%tip)))
      are_over = .false.
      do
         if (failure%failed()) return
         call values_of_growth(s, values, failure)
         if (.not. are_over) call turns%note(mixities_of(values, turns%tip))
         if (turns%have_found() .or. are_over) return
         call turns%choose(turn, are_over)
         call turn_tips(s%growing, s%model, s%cracks, turns%tip, turn, is_in_the_way)
         call cut_anew(s, failure)
         call measure_state(s, failure)
      end do
   end subroutine turn_to_symmetry

   !> After a load step, measured: turn tips to local symmetry, which loads that do not change in proportion and finer cells have
   !> changed, and scale the loads to the toughness, in turns until both hold: with held loads K_II depends on the load factor.
   subroutine load_in_symmetry(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      integer, parameter :: most = 12
      type(symmetric_turns_t) :: turns
      integer :: attempt
      do attempt = 1, most
         call turn_to_symmetry(s, turns, failure)
         call load_to_toughness(s, failure)
         if (failure%failed() .or. .not. has_held_drive(s%problem)) exit
         if (.not. turns%have_found()) exit      ! by no direction: as in a load step before
         if (is_symmetric(mixities_of(s%measurements%crack, turns%tip))) exit
      end do
      if (failure%failed()) return
      if (attempt > most) call s%growing%note_tip(turns%tip(1), 'has K_II in one load step at least: the direction '// &
         'without any and the load factor change each other', s%warning)
   end subroutine load_in_symmetry

   !> Book the work of a load step that ends now, the loss of faces that slide from their state before it, and the energy taken by
   !> new faces.
   subroutine book_step(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed()) return
      s%problem%interfaces%keep_slip = .false.
      call commit_slip(s%problem%interfaces)
      call book_work(s%growing, s%problem, failure)
      if (s%model%control%is_there()) call look_at_frame(s%growing, s%problem, s%model%control%stiffness, failure)
      call book_fracture(s%growing, s%model, s%cracks, s%measurements%crack, s%measurements%fronts, s%problem)
      if (has_fronts(s)) call even_out_points(s%growing, s%measurements%fronts, s%growing%tips%extension)
   end subroutine book_step

   !> Whether fronts grow, of solids.
   pure logical function has_fronts(s)
      type(simulation_t), intent(in) :: s
      has_fronts = size(s%measurements%fronts) > 0
   end function has_fronts

   !> G over the toughness of each tip, or point of a front, that still grows; 0 where growth is hindered, unless `whatever`.
   pure function ratios(s, whatever)
      type(simulation_t), intent(in) :: s
      logical, intent(in), optional :: whatever  !! default: .false.
      real(dp), allocatable :: ratios(:)
      logical :: all_of_them
      all_of_them = .false.
      if (present(whatever)) all_of_them = whatever
      ratios = ratios_of(s%growing, s%model, s%cracks, s%measurements%crack, s%measurements%fronts, all_of_them)
   end function ratios

   !> With all measured: scale the loads until the largest G is the toughness. Beside held loads G is a polynomial of the load
   !> factor for all tips; the solution counts only tips that are not hindered. If there are none the loads stay.
   subroutine load_to_toughness(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      integer, parameter :: most = 40
      type(load_search_t) :: search
      real(dp), parameter :: reached = 1 - 1e-4_dp ! part of the toughness
      real(dp), allocatable :: now(:)
      logical, allocatable :: counts(:)
      real(dp) :: factor, before
      integer :: attempt
      logical :: is_found
      if (failure%failed()) return
      if (s%growing%have_onsets .and. size(ratios(s)) == 0) return
      search%is_proportional = .not. has_held_drive(s%problem)
      before = s%growing%load_factor
      s%growing%have_no_load = .false.
      allocate (counts(size(ratios(s))), source=.true.)
      do attempt = 1, most
         now = merge(ratios(s, whatever=.not. search%is_proportional), 0.0_dp, counts)
         call search%note(s%growing%load_factor, now)
         call search%choose(factor, is_found)
         if (.not. has_scaled_drive(s%problem)) then
            is_found = attempt > 1
            factor = s%growing%load_factor
            if (any(ratios(s) > 1)) exit
         end if
         if (is_found) then
            if (search%is_proportional .or. maxval(now) < reached .or. any(ratios(s) >= reached .and. counts)) return
            counts = counts .and. now < reached  ! without tips that reach it where something hinders them
            s%growing%have_no_load = .not. any(counts)
            if (s%growing%have_no_load) factor = before
            search = load_search_t(is_proportional=.false.)
         end if
         call rescale(s, factor, failure)
         if (failure%failed() .or. s%growing%have_no_load) return
      end do
      call failure%report(exit_computation, s%problem%state%when()//'no factor of the loads was found that '// &
                          'brings G to the toughness: G hardly depends on them, as where held loads or an '// &
                          'eigenstrain open the crack')
   end subroutine load_to_toughness

   !> Scale the loads, and measure.
   subroutine rescale(s, factor, failure)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: factor             !! load factor [-]
      type(failure_t), intent(inout) :: failure
      s%growing%load_factor = factor
      call s%integrator%rescale(s%problem, factor, failure)
      call measure_state(s, failure, in_passing=.true.)
      if (s%model%control%leads()) call look_at_frame(s%growing, s%problem, s%model%control%stiffness, failure)
   end subroutine rescale

   !> After a load step, measured: bring the controlled quantity to its target, while tips grow.
   !>
   !> Tips advance by increments at G = toughness while the quantity rises. Where it would fall, growth is unstable: the quantity
   !> stays and G exceeds the toughness. The last increment ends where G is the toughness.
   subroutine follow_control(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(cracks_t) :: before
      real(dp) :: target, now                    ! the quantity in the end, and on the way
      real(dp) :: critical, last                 ! at which G is the toughness, and the same an increment before
      real(dp) :: factor
      type(symmetric_turns_t) :: turns
      logical :: has_grown
      target = s%model%control%target_at(s%problem%state%time)
      now = s%growing%controlled
      s%growing%controlled = target
      s%growing%waits = .true.
      call load_to(s, target, failure)
      has_grown = .not. failure%failed()
      if (has_grown) has_grown = any(ratios(s, whatever=.true.) > 1 + 2*near)
      if (has_grown .and. .not. exceeds_toughness(s)) call grow(s, failure, has_grown) ! which says why tips wait
      if (has_grown) call load_in_symmetry(s, failure)
      do while (has_grown .and. .not. failure%failed())
         critical = controlled(s)
         now = sign(min(abs(target), max(sign(1.0_dp, target)*now, sign(1.0_dp, target)*critical)), target)
         if (abs(critical - now) > near*abs(now)) then
            call s%growing%note_tip(maxloc(s%growing%tips%rate, dim=1), 'runs by itself in one load step at least, as its '// &
               'growth is not stable there: G is above the toughness, and the rest of fracture_energy is lost', s%warning)
            call load_to(s, now, failure)
         end if
         call book_step(s, failure)
         before = s%cracks
         last = critical
         factor = s%growing%load_factor
         call grow(s, failure, has_grown)
         if (s%is_over) return
         if (s%growing%is_adrift .or. .not. has_grown) exit
         call load_in_symmetry(s, failure)
         if (failure%failed()) return
         critical = controlled(s)
         if (abs(critical) < abs(target)) cycle
         call shorten_increment(s, before, factor, last, target, failure)
         if (s%is_over) return
         exit
      end do
      call load_to(s, target, failure)
      if (has_grown .and. has_held_drive(s%problem)) then ! whose K_II is another one for each load factor
         call turn_to_symmetry(s, turns, failure)
         call load_to(s, target, failure)
      end if
      call book_step(s, failure)
   end subroutine follow_control

   !> Repeat the last advance of the tips by the part of it with which G is the toughness at the target of the controlled quantity,
   !> by the rule of false position, the value at an end that stays halved each time (Illinois).
   subroutine shorten_increment(s, before, factor, first, target, failure)
      type(simulation_t), intent(inout) :: s
      type(cracks_t), intent(in) :: before       !! before that increment
      real(dp), intent(in) :: factor             !! load factor then [-]
      real(dp), intent(in) :: first              !! the quantity at G = toughness then; afterwards the present one
      real(dp), intent(in) :: target
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: close = 1e-3_dp     ! of the quantity: K of a tip varies as much with its place in a cell
      integer, parameter :: most = 5
      real(dp) :: part(2), off(2), now
      integer :: trial, side
      part = [0, 1]
      off = [first, controlled(s)] - (1 + close)*target ! G is hardly below the toughness: no more growth there
      now = off(2)
      do trial = 1, most
         if (abs(now) <= close*abs(target)) exit
         s%growing%part = part(1) - off(1)*(part(2) - part(1))/(off(2) - off(1))
         call put_back(s, before, factor, failure)
         if (.not. failure%failed()) call grow(s, failure)
         if (s%is_over .or. s%growing%is_adrift) exit
         call load_in_symmetry(s, failure)
         if (failure%failed()) return
         now = controlled(s) - (1 + close)*target
         side = merge(1, 2, now*off(1) > 0)
         off(3 - side) = off(3 - side)/2
         part(side) = s%growing%part
         off(side) = now
      end do
      s%growing%part = 1
   end subroutine shorten_increment

   !> Whether G of a tip that grows is above its toughness.
   logical function exceeds_toughness(s)
      type(simulation_t), intent(in) :: s
      exceeds_toughness = any(ratios(s) > 1 + 2*near)
   end function exceeds_toughness

   !> The controlled quantity, with the load frame measured.
   pure real(dp) function controlled(s)
      type(simulation_t), intent(in) :: s
      controlled = s%growing%load_factor
      if (s%model%control%quantity == 'displacement') controlled = s%growing%frame_way
   end function controlled

   !> Put cracks back to where they were before an increment, with the loads there.
   subroutine put_back(s, before, factor, failure)
      type(simulation_t), intent(inout) :: s
      type(cracks_t), intent(in) :: before
      real(dp), intent(in) :: factor             !! load factor [-]
      type(failure_t), intent(inout) :: failure
      s%cracks = before
      call see_around_tips(s%model, s%cracks)
      call cut_anew(s, failure)
      call rescale(s, factor, failure)
   end subroutine put_back

   !> Scale the loads until the quantity that is controlled has a value: by the secant rule, which is exact in a linear body.
   subroutine load_to(s, target, failure)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: target
      type(failure_t), intent(inout) :: failure
      integer, parameter :: most = 40
      real(dp), parameter :: close = 1e-10_dp
      real(dp) :: factor, value, change, rise
      integer :: attempt
      if (failure%failed()) return
      if (s%model%control%quantity == 'load') then
         call rescale(s, target, failure)
         return
      end if
      call look_at_frame(s%growing, s%problem, s%model%control%stiffness, failure)
      if (s%growing%is_adrift) return
      do attempt = 1, most
         factor = s%growing%load_factor
         value = controlled(s)
         associate (compliance => s%growing%compliance)
            if (abs(value - target) <= close*max(abs(s%model%control%displacement), abs(target), abs(compliance*factor))) return
            if (.not. abs(compliance) > 0 .and. abs(factor) > 0) compliance = value/factor
            if (.not. abs(compliance) > 0) exit
            change = (target - value)/compliance
            call rescale(s, factor + change, failure)
            if (failure%failed()) return
            rise = controlled(s) - value
            if (abs(rise) > close*abs(value)) compliance = rise/change
         end associate
      end do
      call failure%report(exit_computation, s%problem%state%when()//'no load was found that brings the load frame to its '// &
                          'displacement: what is scaled hardly moves it')
   end subroutine load_to
end module hampm_growth
