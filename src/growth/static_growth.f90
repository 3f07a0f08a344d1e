!> Static crack growth by increments: in each load step tips advance; then scaled loads and prescribed motions make the largest G
!> over toughness 1 (`hampm_load_search`), or follow load cycles or time (`hampm_fatigue`).
module hampm_static_growth
   use hampm_kinds, only: dp, ndim
   use hampm_crack_values, only: crack_values_t
   use hampm_crack_placement, only: least_radius, way_to_toughness
   use hampm_crack_tip, only: crack_tip_t
   use hampm_failure, only: failure_t
   use hampm_fatigue, only: advances_of
   use hampm_cracks, only: cracks_t
   use hampm_growing, only: growing_t, next_t, fitting
   use hampm_growth_room, only: see_around_tips, see_surroundings, room_of_material, room_of_tip, is_free, why_no_room, &
                               find_end, plan_end, end_tips
   use hampm_load_search, only: nothing
   use hampm_kinks, only: slope_of_mixity
   use hampm_load_work, only: load_state_t, find_load_state, find_frame, work_between
   use hampm_problem, only: problem_t
   use hampm_model, only: model_t
   use hampm_symmetric_turns, only: symmetric_turns_t, begin_turns
   use hampm_tensors, only: norm, in_plane
   use hampm_text, only: three_digits, length_text
   implicit none
   private
   public :: advance_tips, begin_to_turn, mixities_of, turn_tips, take_back, has_held_drive, loads_change, &
             has_scaled_drive, book_work, measure_load_frame


   real(dp), parameter :: to_and_fro = 0.2_dp    !! kinks in turn to both sides that are too large [rad]
   real(dp), parameter :: small = 0.01_dp        !! atan(K_II/K_I) at which a tip may advance if less is not attainable [rad]

contains

   !> Advance tips by an increment, or by a part of it after some attempts. `have_moved`: any has; `message`: why some are stopped.
   subroutine advance_tips(growing, model, cracks, values, next, attempts, have_moved, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(inout) :: cracks
      type(crack_values_t), intent(in) :: values(:) !! of each tip
      type(next_t), intent(in) :: next(:)        !! of each tip
      integer, intent(in) :: attempts(:)         !! of each tip, 0 for the first
      logical, intent(out) :: have_moved
      character(:), allocatable, intent(inout) :: message
      real(dp), parameter :: reached = 1 - 1e-4_dp ! part of the toughness
      real(dp), dimension(size(values)) :: ratios !! G over its toughness, if the largest advances; else below 0
      real(dp), dimension(size(values)) :: drive !! G over the sum of it and its toughness, of each tip [-]
      real(dp), dimension(size(values)) :: least !! way of a tip that turns [m]
      real(dp), dimension(size(values)) :: wanted !! way of each tip [m]
      integer :: order(size(values)), i, k, have_stopped
      growing%points%advance = 0
      growing%points%has_come = .false.
      drive = 0
      least = 0
      wanted = 0
      do k = 1, size(values)
         associate (tip => cracks%tips(k))
            ratios(k) = -1
            if (.not. growing%is_growing(k)) cycle
            if (next(k)%rate > 0) drive(k) = next(k)%rate/(next(k)%rate + next(k)%toughness)
            associate (law => model%growth(growing%points(k)%law))
               if (law%only_largest .and. next(k)%hindrance == 0) ratios(k) = next(k)%rate/next(k)%toughness
               wanted(k) = law%increment
               least(k) = least_radius(model)*merge(0.01_dp, 1.0_dp, law%direction == 'straight')
            end associate
         end associate
      end do
      if (growing%has_rates) wanted = advances_of(growing%fatigue, model, [(growing%is_growing(k), k=1, size(values))], least)
      order = cracks%by_drive(drive)
      do
         have_stopped = count(growing%points%has_stopped .and. .not. growing%points%advance > 0)
         do i = 1, size(order)
            k = order(i)
            if (growing%is_growing(k) .and. .not. growing%points(k)%advance > 0) call advance_where_due(k)
         end do
         if (count(growing%points%has_stopped .and. .not. growing%points%advance > 0) == have_stopped) exit ! or another leads
      end do
      have_moved = any(growing%points%advance > 0)
   contains
      !> Advance a tip if it is its turn and something opens it.
      subroutine advance_where_due(k)
         integer, intent(in) :: k
         associate (law => model%growth(growing%points(k)%law), tip => cracks%tips(k))
            if (.not. wanted(k) > 0) return
            if (growing%hold_still .and. next(k)%rate < reached*next(k)%toughness) return
            if (next(k)%hindrance > 0) then
               if (values(k)%is_closed .or. norm(values(k)%intensity) > 0 .or. any(abs(values(k)%j) > 0)) & ! else no load yet
                  call growing%warn_of_waiting(k, next(k)%hindrance, message)
               return
            end if
            if (growing%have_no_load .and. next(k)%rate < reached*next(k)%toughness) then
               call growing%warn_of_waiting(k, 0, message)
               return
            end if
            if (.not. next(k)%rate > nothing*next(k)%toughness) return ! there is no load yet
            if (law%only_largest) then
               if (k /= first_of_largest(ratios, growing%points%advance > 0 .or. .not. growing%points%has_stopped)) return
            end if
            call try_to_advance(k)
         end associate
      end subroutine advance_where_due

      !> Advance a tip, unless it would come too near to something or be too long.
      subroutine try_to_advance(k)
         integer, intent(in) :: k
         real(dp), allocatable :: before(:, :)
         character(:), allocatable :: why
         real(dp) :: angle, most, length, from(ndim), to(ndim), way(ndim)
         logical :: runs_through
         associate (law => model%growth(growing%points(k)%law), tip => cracks%tips(k))
            length = max(part_of_increment(attempts(k))*growing%part*wanted(k), min(wanted(k), least(k)))
            if (law%direction == 'straight') length = growing%part*wanted(k) ! no kink is in the way of a domain integral
            if (law%max_length > 0 .and. cracks%crack(tip%crack)%length() + length > law%max_length*(1 + 1e-9_dp)) then
               call growing%stop_points([k], 'the crack has its max_length', message)
               return
            end if
            angle = next(k)%kink
            call come_to_seam(k, angle, length)
            before = cracks%crack(tip%crack)%points
            if (angle*growing%points(k)%kink < 0 .and. min(abs(angle), abs(growing%points(k)%kink)) > to_and_fro .and. &
                .not. law%factors%of_angle%is_there()) & ! along weak planes it does
               call growing%warn_once(k, &
               'turns to and fro: by '//three_digits(180/acos(-1.0_dp)*abs(angle))//' degrees where it was seen first: its '// &
               'increments are too long for its direction. Take shorter ones, or direction = ''local_symmetry''', message)
            growing%points(k)%kink = angle
            if (law%direction == 'local_symmetry') growing%points(k)%slope = slope_of_mixity(angle, values(k)%intensity)
            from = tip%place
            call cracks%extend(k, length, angle)
            call see_around_tips(model, cracks, tip%crack)
            most = room_of_tip(model, cracks, tip)
            if (.not. is_free(model, cracks, tip%crack, from, tip%place)) most = 0
            if (most < least_radius(model)*(1 - 1e-9_dp)) then
               why = 'a step further '//why_no_room(model, tip%place)
               call cracks%place(tip%crack, before)
               call see_around_tips(model, cracks, tip%crack)
               call find_end(model, cracks, tip%crack, tip%place, matmul(tip%axis, in_plane(cos(angle), sin(angle))), &
                             length + 2*least_radius(model), to, runs_through)
               way = matmul(to - tip%place, tip%axis)
               if (.not. runs_through) then
                  call growing%stop_points([k], why, message)
               else if (law%max_length > 0 .and. &
                        cracks%crack(tip%crack)%length() + norm(way) > law%max_length*(1 + 1e-9_dp)) then
                  call growing%stop_points([k], 'the crack has its max_length', message)
               else
                  growing%points(k)%advance = norm(way)
                  call cracks%extend(k, norm(way), atan2(way(2), way(1)))
                  call plan_end(model, cracks, k)
                  call end_tips(growing, model, cracks, message)
               end if
               return
            end if
            call fit_domains(model, growing%points(k)%usual_radii, most, tip)
            growing%points(k)%advance = length
         end associate
      end subroutine try_to_advance

      !> Let an advance end where a body of another toughness begins, and the one before it so that there is room for that.
      subroutine come_to_seam(k, angle, length)
         integer, intent(in) :: k
         real(dp), intent(in) :: angle           !! [rad]
         real(dp), intent(inout) :: length       !! [m]
         real(dp), parameter :: turned = 1.1_dp  ! over `least`, as the tip turns before it goes on
         real(dp) :: way, rest
         rest = turned*least(k)
         associate (tip => cracks%tips(k))
            way = way_to_toughness(model, tip%place, matmul(tip%axis, in_plane(cos(angle), sin(angle))), length + rest)
            if (way > length + merge(0.0_dp, rest, growing%part < 1) .or. way < least(k)) return
            growing%points(k)%has_come = way <= length .or. way < least(k) + rest
            length = merge(way, way - rest, growing%points(k)%has_come)
         end associate
      end subroutine come_to_seam
   end subroutine advance_tips

   !> Give a tip its usual radii, or smaller ones for its room, also before another material.
   pure subroutine fit_domains(model, usual, most, tip)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: usual(:), most     !! [m]
      type(crack_tip_t), intent(inout) :: tip
      tip%radii = fitting(usual, least_radius(model), min(most, room_of_material(model, tip)))
      call see_surroundings(model, tip)
   end subroutine fit_domains

   !> Begin to turn the last increments of the tips that have advanced by local symmetry until they have no K_II.
   pure subroutine begin_to_turn(growing, model, cracks, turns)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(symmetric_turns_t), intent(out) :: turns
      logical :: does_turn(size(cracks%tips))
      integer :: k
      does_turn = .false.
      do k = 1, size(does_turn)
         if (growing%points(k)%grows .and. growing%points(k)%advance > 0 .and. .not. cracks%tips(k)%has_ended) &
            does_turn(k) = model%growth(growing%points(k)%law)%direction == 'local_symmetry'
      end do
      call begin_turns(turns, pack([(k, k=1, size(does_turn))], does_turn), pack(growing%points(:size(does_turn))%slope, does_turn))
   end subroutine begin_to_turn

   !> How much K_II tips have: atan2(K_II, K_I) [rad].
   pure function mixities_of(values, tip) result(mixity)
      type(crack_values_t), intent(in) :: values(:) !! of all tips
      integer, intent(in) :: tip(:)              !! numbers of the requested ones
      real(dp) :: mixity(size(tip))
      integer :: k
      mixity = [(atan2(values(tip(k))%intensity(2), values(tip(k))%intensity(1)), k=1, size(tip))]
   end function mixities_of

   !> Turn the last increments of tips. `is_in_the_way` is the number of a tip that has no room there, 0 for none.
   subroutine turn_tips(growing, model, cracks, tip, turn, is_in_the_way)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(inout) :: cracks
      integer, intent(in) :: tip(:)              !! their numbers
      real(dp), intent(in) :: turn(:)            !! to the left [rad]
      integer, intent(out) :: is_in_the_way
      real(dp) :: most
      integer :: k
      is_in_the_way = 0
      do k = 1, size(tip)
         associate (of => cracks%tips(tip(k)))
            call cracks%turn(tip(k), turn(k))
            call see_around_tips(model, cracks, of%crack)
            most = room_of_tip(model, cracks, of)
            if (most < least_radius(model)*(1 - 1e-9_dp)) is_in_the_way = tip(k)
            call fit_domains(model, growing%points(tip(k))%usual_radii, max(most, least_radius(model)), of)
         end associate
      end do
   end subroutine turn_tips

   !> Part of an increment after some attempts: at first nearly the same, which is enough if the place of the tip in its cell was
   !> the reason.
   pure real(dp) function part_of_increment(attempt) result(part)
      integer, intent(in) :: attempt             !! 0 for the first
      part = 1
      if (attempt > 0) part = max(0.0_dp, 1 - 0.01_dp*3.0_dp**(attempt - 1))
   end function part_of_increment

   !> Tips have advanced and some have K_II in any direction. Undo the advance of all tips and repeat it with a smaller part of the
   !> increments of these, at least two of the finest cells. If that was tried: accept (`is_over`) where K_II is small, or stop
   !> these tips.
   subroutine take_back(growing, model, cracks, before, turns, attempts, is_over, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(inout) :: cracks
      type(cracks_t), intent(in) :: before       !! the cracks before the load step
      type(symmetric_turns_t), intent(in) :: turns
      integer, intent(inout) :: attempts(:)      !! of each tip
      logical, intent(out) :: is_over
      character(:), allocatable, intent(inout) :: message
      integer :: k
      is_over = .true.
      do k = 1, size(turns%tip)
         if (.not. turns%has_found(k)) is_over = is_over .and. .not. may_be_shorter(k) .and. abs(turns%mixity(k)) <= small
      end do
      do k = 1, size(turns%tip)
         if (turns%has_found(k)) cycle
         associate (tip => turns%tip(k))
            if (may_be_shorter(k)) then
               attempts(tip) = attempts(tip) + 1
               call growing%warn_once(tip, 'has advanced by less than its increment in one load step at least, as by that it '// &
                                     'has K_II in any direction', message)
            else if (abs(turns%mixity(k)) <= small) then
               call growing%warn_once(tip, 'has K_II in any direction in one load step at least: where it was seen first, '// &
                                     part_of_two(k)//'. In finer cells there may be less', message)
            else
               call growing%stop_points([tip], 'by '//length_text(growing%points(tip)%advance)//' m, two of the finest cells, '// &
                                        'it has K_II in any direction: '//part_of_two(k)//'. In finer cells increments may be '// &
                                        'smaller', message)
            end if
         end associate
      end do
      if (is_over) return
      where (cracks%tips%has_ended .and. .not. before%tips%has_ended)
         growing%points%has_stopped = .false.
         growing%points%has_ended = .false.
      end where
      cracks = before
      call see_around_tips(model, cracks)
   contains
      !> Whether the k-th tip has advanced by more than the least.
      pure logical function may_be_shorter(k)
         integer, intent(in) :: k
         may_be_shorter = growing%points(turns%tip(k))%advance > least_radius(model)*(1 + 1e-9_dp)
      end function may_be_shorter

      !> The K_II that the k-th tip has at best, in words.
      function part_of_two(k) result(text)
         integer, intent(in) :: k
         character(:), allocatable :: text
         text = 'K_II is '//three_digits(abs(tan(turns%mixity(k))))//' of K_I'
      end function part_of_two
   end subroutine take_back

   !> The first of some tips with the largest rate, up to rounding, as of symmetric tips.
   pure integer function first_of_largest(rates, some)
      real(dp), intent(in) :: rates(:)           !! over the toughness [-]
      logical, intent(in) :: some(:)             !! one at least
      real(dp), parameter :: rounding = 1e-7_dp  !! over the rate
      real(dp) :: largest
      largest = maxval(rates, mask=some)
      first_of_largest = findloc(some .and. rates >= largest - rounding*abs(largest), .true., dim=1)
   end function first_of_largest

   !> Whether held loads, prescribed motions or eigenstrains act beside the scaled ones.
   pure logical function has_held_drive(m)
      type(problem_t), intent(in) :: m
      has_held_drive = any(m%materials%has_eigenstrain .and. .not. m%materials%is_scaled) .or. m%constraints%have_held_ways()
      if (size(m%loads) > 0) has_held_drive = has_held_drive .or. any(m%loads%history%held)
   end function has_held_drive

   !> Whether any scaled load drives a body now.
   pure logical function has_scaled_drive(m)
      type(problem_t), intent(in) :: m
      integer :: k
      has_scaled_drive = m%constraints%have_scaled_ways(m%state%time) .or. any(m%materials%is_scaled)
      do k = 1, size(m%loads)
         has_scaled_drive = has_scaled_drive .or. .not. m%loads(k)%history%held .and. &
                            abs(m%loads(k)%history%factor(m%state%time)) > 0
      end do
   end function has_scaled_drive

   !> Whether loads or prescribed motions at a time are not those at another.
   pure logical function loads_change(m, first, last)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: first, last        !! [s]
      integer :: k
      loads_change = any(abs(m%constraints%ways_at(last) - m%constraints%ways_at(first)) > 0)
      do k = 1, size(m%loads)
         loads_change = loads_change .or. abs(m%loads(k)%history%factor(last) - m%loads(k)%history%factor(first)) > 0
      end do
   end function loads_change

   !> Add the work of a load step, on a path on which tips and loads change together.
   subroutine book_work(growing, m, failure)
      type(growing_t), intent(inout) :: growing
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      type(load_state_t) :: now
      real(dp) :: booked
      call find_load_state(m, now, failure)
      if (failure%failed()) return
      if (allocated(growing%loads%factor)) then
         booked = m%energies%external_work
         m%energies%external_work = growing%work
         if (.not. growing%is_adrift) m%energies%external_work = growing%work + work_between(growing%loads, now)
         if (m%audit) m%energies%numerical_loss = m%energies%numerical_loss + (m%energies%external_work - booked)
      end if
      growing%loads = now
      growing%work = m%energies%external_work
   end subroutine book_work

   !> Find the load of a load frame and its displacement.
   subroutine measure_load_frame(growing, m, stiffness, failure)
      type(growing_t), intent(inout) :: growing
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: stiffness          !! of the frame, 0: rigid [N/m]
      type(failure_t), intent(inout) :: failure
      type(load_state_t) :: now
      if (failure%failed()) return
      growing%load = 0
      growing%displacement = growing%controlled
      growing%frame_displacement = growing%controlled
      if (growing%is_adrift) return
      call find_load_state(m, now, failure)
      if (failure%failed()) return
      call find_frame(m, now, growing%load_factor, growing%load, growing%displacement)
      growing%frame_displacement = growing%displacement
      if (stiffness > 0) growing%frame_displacement = growing%displacement + growing%load/stiffness
   end subroutine measure_load_frame
end module hampm_static_growth
