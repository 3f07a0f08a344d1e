!> Growth at rest: tips or points of fronts advance by increments, cells are cut anew, and equilibrium is found; then loads are
!> scaled until the largest G is the toughness or a crack appears, or follow a load frame that is given its load or displacement.
!> Load cycles (`hampm_growth_in_cycles`) have steps in common with this.
module hampm_growth_at_rest
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hampm_crack_values, only: crack_values_t
   use hampm_cracks, only: cracks_t
   use hampm_failure, only: exit_computation, failure_t
   use hampm_fatigue, only: largest_loads
   use hampm_front_values, only: front_values_t
   use hampm_growing, only: by_frame, by_time, close_control, growing_t, next_t
   use hampm_growth_points, only: book_fracture, next_of_points
   use hampm_growth_room, only: is_plane_open, see_around_tips
   use hampm_instant, only: go_back_to, instant_t, save_instant
   use hampm_interface_points, only: commit_slip, have_friction
   use hampm_kinds, only: dp
   use hampm_load_search, only: load_search_t, nothing
   use hampm_measurements, only: measurements_t
   use hampm_mesh_changes, only: change_cut, cut_anew
   use hampm_nucleation, only: book_onset, find_onset, insert_crack
   use hampm_outer_forces, only: scale_loads
   use hampm_problem, only: problem_t, stored_energy
   use hampm_rigid_motions, only: number_of_pieces
   use hampm_simulation, only: measure_state, simulation_t
   use hampm_state, only: energies_t
   use hampm_static_front_growth, only: advance_points, even_out_points
   use hampm_static_growth, only: advance_tips, begin_to_turn, book_work, has_held_drive, has_scaled_drive, &
                  measure_load_frame, mixities_of, take_back, turn_tips
   use hampm_symmetric_turns, only: is_symmetric, symmetric_turns_t
   use hampm_text, only: add_line, digits_text, to_text
   use hampm_tolerance, only: bounded_ratio
   implicit none
   private
   public :: at_load_t, grow, arrive, rescale, note_separation, turn_to_symmetry, measure_at_loads, book_step, has_fronts, &
             load_in_symmetry, load_to_onset, follow_control

   real(dp), parameter :: near = 1e-6_dp         !! part of the toughness, and of the controlled quantity
   real(dp), parameter :: reached = 1 - 1e-4_dp  !! part of the toughness from which on tips advance

   !> Measurements at a load of the cycles.
   type :: at_load_t
      type(crack_values_t), allocatable :: crack(:)
      type(front_values_t), allocatable :: fronts(:)
      real(dp) :: factor = 1                     !! to multiply them with [-]
   end type at_load_t

contains

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
      real(dp) :: stored                         ! energy without a crack that appears [J]
      integer :: stopped
      logical :: have_moved, have_cut, is_over
      if (present(has_grown)) has_grown = .false.
      s%problem%interfaces%keep_slip = have_friction(s%problem%interfaces)
      if (.not. (has_scaled_drive(s%problem) .or. s%growing%driver == by_time)) return
      if (s%growing%onset_crack > 0) then        ! it appears at the load of the step before
         stored = stored_energy(s%problem)
         call insert_crack(s)
         call cut_at_rest(s, failure)
         if (.not. (failure%failed() .or. s%is_over)) call book_onset(s, stored, failure)
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
         stopped = count(s%growing%points%has_stopped)
         if (has_fronts(s)) then
            call advance_points(s%growing, s%model, next, s%measurements%fronts, s%cracks, have_moved, s%warning)
         else
            call advance_tips(s%growing, s%model, s%cracks, values, next, attempts, have_moved, s%warning)
         end if
         if (.not. have_moved .and. count(s%growing%points%has_stopped) > stopped) cycle ! others may go on, in later cycles too
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

   !> In equilibrium: cut cells along cracks that have grown, and solve. Where a body has separated and a piece has no equilibrium
   !> the run is over; where a displacement is prescribed the piece moves with the load frame, without load, from where it was.
   subroutine cut_at_rest(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: of_pieces
      type(instant_t) :: before
      call change_cut(s, failure)
      if (failure%failed()) return
      call note_separation(s, s%problem%state%time + merge(0.0_dp, s%dt, s%growing%driver == by_frame)) ! which grows after its step
      if (s%growing%separated >= 0) call save_instant(s%problem, before)
      call s%integrator%initialise(s%problem, s%longest_step, of_pieces)
      if (s%growing%separated >= 0 .and. .not. of_pieces%failed()) call find_flown(s%problem, of_pieces)
      if (.not. of_pieces%failed()) return
      if (s%growing%separated >= 0 .and. s%model%control%leads() .and. s%model%control%quantity == 'displacement') then
         s%growing%is_adrift = .true.
         s%growing%load_factor = 0
         call go_back_to(before, s%problem)
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

   !> Fail where small strain has moved material farther than the grid is long: nothing but open faces held it, and the iteration
   !> has ended at rounding.
   subroutine find_flown(m, failure)
      type(problem_t), intent(in) :: m
      type(failure_t), intent(inout) :: failure
      if (any(m%materials%is_finite)) return
      associate (way => maxval(abs(m%particles%displacement(:m%particles%n, :))))
         if (way > maxval(m%grid%forest%cells)*m%grid%forest%cell) call failure%report(exit_computation, m%state%when()// &
            'the faces of a piece that nothing else holds do not press on each other, and the loads move it')
      end associate
   end subroutine find_flown

   !> Record whether cracks have separated a body.
   subroutine note_separation(s, time)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: time               !! [s]
      character(:), allocatable :: how
      integer :: pieces, k
      s%growing%must_cut = .false.
      if (s%growing%separated >= 0 .or. .not. (any(s%cracks%tips%has_ended) .or. any(s%growing%points%has_ended))) return
      pieces = number_of_pieces(s%problem)
      if (is_plane_open(s%model, s%cracks) .or. any([(s%cracks%regions(k)%is_symmetry .and. &
            all(s%growing%points%has_ended .or. s%growing%points%crack /= k), k=1, size(s%model%planes))])) then
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

   !> Measurements at tips that are about to advance or turn: in load cycles at the load at which K of each is the largest.
   subroutine values_of_growth(s, values, failure)
      type(simulation_t), intent(inout) :: s
      type(crack_values_t), allocatable, intent(out) :: values(:)
      type(failure_t), intent(inout) :: failure
      type(at_load_t), allocatable :: at(:)
      integer, allocatable :: load(:)
      integer :: k, l
      values = s%measurements%crack
      if (failure%failed() .or. .not. s%growing%has_rates) return
      load = largest_loads(s%growing%fatigue)
      load = load(:size(values))
      if (all(load == 1)) return
      call measure_at_loads(s, [(any(load == l), l=1, size(s%growing%fatigue%level))], at, failure)
      if (failure%failed()) return
      do k = 1, size(values)
         values(k) = at(load(k))%crack(k)%times(at(load(k))%factor)
      end do
   end subroutine values_of_growth

   !> Measure at some loads of the cycles. One solution gives all if the model is proportional to the loads, else each load takes
   !> one; faces then slide from their present state.
   subroutine measure_at_loads(s, wanted, at, failure)
      type(simulation_t), intent(inout) :: s
      logical, intent(in) :: wanted(:)           !! at which; the first is that of the model
      type(at_load_t), allocatable, intent(out) :: at(:)
      type(failure_t), intent(inout) :: failure
      type(measurements_t) :: measurements
      type(energies_t) :: energies
      logical :: one_tells
      integer :: l
      associate (m => s%problem)
         one_tells = all(m%materials%linear) .and. m%interfaces%n_contact == 0 .and. &
                     .not. (has_held_drive(m) .or. m%constraints%only_push())
      end associate
      measurements = s%measurements
      energies = s%problem%energies
      allocate (at(size(wanted)))
      do l = 1, size(wanted)
         if (.not. wanted(l)) cycle
         at(l)%factor = s%growing%fatigue%level(l)
         if (l > 1 .and. .not. one_tells) then
            at(l)%factor = 1
            s%problem%interfaces%keep_slip = have_friction(s%problem%interfaces)
            call rescale(s, s%growing%fatigue%level(l), failure)
            if (failure%failed()) return
         end if
         at(l)%crack = s%measurements%crack
         at(l)%fronts = s%measurements%fronts
      end do
      if (one_tells .or. .not. any(wanted(2:))) return
      call rescale(s, 1.0_dp, failure)           ! the load of the model
      s%problem%interfaces%keep_slip = .false.
      s%measurements = measurements
      s%problem%energies = energies
   end subroutine measure_at_loads

   !> After growth, measured: book the step to where points have come to a body of another toughness, at the load at which they do.
   subroutine arrive(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed() .or. .not. any(s%growing%points%has_come)) return
      s%growing%looks_back = .true.
      call load_in_symmetry(s, failure)
      call book_step(s, failure)
      s%growing%looks_back = .false.
      s%growing%points%has_come = .false.
   end subroutine arrive

   !> Scale the loads, now or at another time, and measure.
   subroutine rescale(s, factor, failure, time)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: factor             !! load factor [-]
      type(failure_t), intent(inout) :: failure
      real(dp), intent(in), optional :: time     !! [s]
      s%growing%load_factor = factor
      call s%integrator%rescale(s%problem, factor, failure, time)
      call s%measurements%crack%book(is_of_run=.false.)
      call measure_state(s, failure, in_passing=.true.)
      if (s%model%control%leads()) call measure_load_frame(s%growing, s%problem, s%model%control%stiffness, failure)
   end subroutine rescale

   !> Book the work of a load step that ends now, the loss of faces that slide from their state before it, and the energy taken by
   !> new faces.
   subroutine book_step(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      if (failure%failed()) return
      s%problem%interfaces%keep_slip = .false.
      call commit_slip(s%problem%interfaces)
      call s%measurements%crack%book(is_of_run=.true.)
      call book_work(s%growing, s%problem, failure)
      if (s%model%control%is_there()) call measure_load_frame(s%growing, s%problem, s%model%control%stiffness, failure)
      call book_fracture(s%growing, s%model, s%cracks, s%measurements%crack, s%measurements%fronts, s%problem)
      if (has_fronts(s)) call even_out_points(s%growing, s%measurements%fronts, s%growing%points%extension)
   end subroutine book_step

   !> Whether fronts grow, of solids.
   pure logical function has_fronts(s)
      type(simulation_t), intent(in) :: s
      has_fronts = size(s%measurements%fronts) > 0
   end function has_fronts

   !> G over the toughness of each point that still grows; 0 where growth is hindered, unless `whatever`.
   pure function ratios(s, whatever)
      type(simulation_t), intent(in) :: s
      logical, intent(in), optional :: whatever  !! default: .false.
      real(dp), parameter :: most = 1e30_dp
      real(dp), allocatable :: ratios(:)
      type(next_t) :: next(size(s%growing%points))
      logical :: counts(size(next))
      integer :: k
      next = next_of_points(s%growing, s%model, s%cracks, s%measurements%crack, s%measurements%fronts)
      counts = next%hindrance == 0
      if (present(whatever)) counts = counts .or. whatever
      ratios = pack(merge(bounded_ratio(next%rate, next%toughness, most), 0.0_dp, counts), &
                    [(s%growing%is_growing(k), k=1, size(next))])
   end function ratios

   !> With all measured: scale the loads until the largest G is the toughness. Beside held loads G is a polynomial of the load
   !> factor for all tips; the solution counts only tips that are not hindered. If there are none the loads stay.
   subroutine load_to_toughness(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      integer, parameter :: most = 40
      type(load_search_t) :: search
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
      if (attempt > most) call s%growing%warn_once(turns%tip(1), 'has K_II in one load step at least: the direction '// &
         'without any and the load factor change each other', s%warning)
   end subroutine load_in_symmetry

   !> When loads are scaled so that tips are about to grow: scale them so that a crack is about to appear, where that comes first.
   subroutine load_to_onset(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      real(dp) :: factor
      if (failure%failed() .or. .not. s%growing%have_onsets) return
      call find_onset(s, any(ratios(s) > nothing), factor, failure)
      if (.not. failure%failed()) call rescale(s, factor, failure)
   end subroutine load_to_onset

   !> After a load step, measured: bring the controlled quantity to its target, while tips grow.
   !>
   !> Tips advance by increments at G = toughness while the quantity rises. Where it would fall, growth is unstable: the quantity
   !> stays and G exceeds the toughness. The last increment ends where G is the toughness, unless a tip has run through by it: what
   !> it has parted is not joined again. A tip that has come to a tougher body by less than that body's toughness rests there.
   subroutine follow_control(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(cracks_t) :: before
      real(dp) :: target, now                    ! the quantity in the end, and on the way
      real(dp) :: critical, last                 ! at which G is the toughness, and the same an increment before
      real(dp) :: factor
      type(symmetric_turns_t) :: turns
      integer :: ended                           ! points before an increment
      logical :: has_grown
      target = s%model%control%target_at(s%problem%state%time)
      now = s%growing%controlled
      s%growing%controlled = target
      s%growing%hold_still = .true.
      s%growing%looks_back = .true.
      s%growing%points%has_come = .false.
      call load_to(s, target, failure)
      has_grown = .not. failure%failed()
      if (has_grown) has_grown = any(ratios(s, whatever=.true.) > 1 + 2*near)
      if (has_grown .and. .not. any(ratios(s) > 1 + 2*near)) call grow(s, failure, has_grown) ! which says why tips wait
      if (has_grown) call load_in_symmetry(s, failure)
      do while (has_grown .and. .not. failure%failed())
         critical = controlled(s)
         now = sign(min(abs(target), max(sign(1.0_dp, target)*now, sign(1.0_dp, target)*critical)), target)
         if (abs(critical - now) > near*abs(now)) then
            call s%growing%warn_once(maxloc(s%growing%points%rate, dim=1), 'runs by itself in one load step at least, as its '// &
               'growth is not stable there: G is above the toughness, and the rest of fracture_energy is lost', s%warning)
            call load_to(s, now, failure)
         end if
         call book_step(s, failure)
         if (any(s%growing%points%has_come)) then
            s%growing%points%has_come = .false.
            call load_in_symmetry(s, failure)
            if (abs(controlled(s)) >= abs(target)) exit
            cycle
         end if
         before = s%cracks
         last = critical
         factor = s%growing%load_factor
         ended = count(s%growing%points%has_ended)
         call grow(s, failure, has_grown)
         if (s%is_over) return
         if (s%growing%is_adrift .or. .not. has_grown .or. count(s%growing%points%has_ended) > ended) exit
         call load_in_symmetry(s, failure)
         if (failure%failed()) return
         critical = controlled(s)
         call note_reach(s%growing, last, critical)
         if (abs(critical) < abs(target)) cycle
         call shorten_increment(s, before, factor, last, target, failure)
         if (s%is_over) return
         exit
      end do
      s%growing%looks_back = .false.
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
      integer, parameter :: most = 5
      real(dp) :: part(2), off(2), now
      integer :: trial, side, ended
      part = [0.0_dp, min(1.0_dp, maxval(s%growing%points%advance/s%model%growth(max(1, s%growing%points%law))%increment))]
      off = [first, controlled(s)] - (1 + close_control)*target ! G is hardly below the toughness: no more growth there
      now = off(2)
      do trial = 1, most
         if (abs(now) <= close_control*abs(target)) exit
         s%growing%part = part(1) - off(1)*(part(2) - part(1))/(off(2) - off(1))
         ended = count(s%growing%points%has_ended)
         s%cracks = before                       ! as before that increment, with the loads there
         s%growing%points%advance = 0            ! the toughness there is not that of its end
         s%growing%points%has_come = .false.
         call see_around_tips(s%model, s%cracks)
         call cut_anew(s, failure)
         call rescale(s, factor, failure)
         if (failure%failed()) return
         if (.not. any(ratios(s) >= reached)) call load_to_toughness(s, failure) ! in cells that have followed the tip and come back
         if (.not. failure%failed()) call grow(s, failure)
         if (s%is_over .or. s%growing%is_adrift .or. count(s%growing%points%has_ended) > ended) exit
         call load_in_symmetry(s, failure)
         if (failure%failed()) return
         now = controlled(s) - (1 + close_control)*target
         side = merge(1, 2, now*off(1) > 0)
         off(3 - side) = off(3 - side)/2
         part(side) = s%growing%part
         off(side) = now
      end do
      s%growing%part = 1
   end subroutine shorten_increment

   !> Note by how much the controlled quantity at which G is the toughness rises with the way of points that have advanced: in the
   !> last increment or, if that is less, since they first grew. NaN where it does not rise.
   subroutine note_reach(growing, last, now)
      type(growing_t), intent(inout) :: growing
      real(dp), intent(in) :: last, now          !! the quantity before and after the increment
      real(dp) :: rise, rise_of_all
      integer :: k
      if (.not. abs(growing%first_critical) > 0) growing%first_critical = last
      rise = abs(now) - abs(last)
      rise_of_all = abs(now) - abs(growing%first_critical)
      do k = 1, size(growing%points)
         associate (point => growing%points(k))
            if (.not. point%advance > 0) cycle
            point%reach = ieee_value(rise, ieee_quiet_nan)
            if (rise > 0 .and. rise_of_all > 0) &
               point%reach = abs(now)*max(point%advance/rise, (point%extension + point%advance)/rise_of_all)
         end associate
      end do
   end subroutine note_reach

   !> The controlled quantity, with the load frame measured.
   pure real(dp) function controlled(s)
      type(simulation_t), intent(in) :: s
      controlled = s%growing%load_factor
      if (s%model%control%quantity == 'displacement') controlled = s%growing%frame_displacement
   end function controlled

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
      call measure_load_frame(s%growing, s%problem, s%model%control%stiffness, failure)
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
end module hampm_growth_at_rest
