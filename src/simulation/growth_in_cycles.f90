!> Growth at rest in load cycles, or in time (`hampm_fatigue`).
module hampm_growth_in_cycles
   use hampm_crack_tip_field, only: modes
   use hampm_failure, only: failure_t
   use hampm_fatigue, only: count_cycles, has_fractured, has_loads, pass_time
   use hampm_growing, only: by_time, next_t
   use hampm_growth_at_rest, only: at_load_t, book_step, grow, has_fronts, measure_at_loads, rescale, turn_to_symmetry
   use hampm_growth_points, only: next_of_points
   use hampm_interface_points, only: have_friction
   use hampm_kinds, only: dp
   use hampm_measurements, only: part_of_rate
   use hampm_simulation, only: simulation_t
   use hampm_static_front_growth, only: at_points, even_out_points
   use hampm_static_growth, only: loads_change
   use hampm_symmetric_turns, only: symmetric_turns_t
   use hampm_text, only: add_line, digits_text, three_digits
   implicit none
   private
   public :: grow_in_cycles, follow_cycles, follow_time

contains

   !> Before a load step with cycles: let tips advance. Where none does, or one breaks, the run is over.
   subroutine grow_in_cycles(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      logical :: has_grown
      if (has_fractured(s%growing%fatigue, s%model)) then
         s%is_over = .true.
         s%growing%fatigue%life = s%growing%fatigue%cycles
         call tell_fracture(s)
         return
      end if
      if (s%growing%driver == by_time) then      ! tips advance once it is known what loads do in the step
         s%problem%interfaces%keep_slip = have_friction(s%problem%interfaces)
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

   !> After a load step with cycles, or at the start, when all is measured: count the cycles that tips have taken for their ways.
   subroutine follow_cycles(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(symmetric_turns_t) :: turns
      real(dp), allocatable :: ways(:), now(:, :, :), there(:, :, :)
      real(dp) :: before                         ! cycles
      real(dp) :: off                            ! part of K by which it may be [-]
      logical :: have_arrested
      before = s%growing%fatigue%cycles
      call turn_to_symmetry(s, turns, failure)
      ways = s%growing%points%advance
      call book_step(s, failure)
      now = s%growing%fatigue%at
      call measure_cycles(s, now, failure, there)
      if (.not. any(ways > 0)) s%growing%fatigue%at = now
      off = part_of_rate(s%problem, s%cracks, s%measurements)/2
      s%growing%fatigue%off = off
      if (failure%failed() .or. .not. any(ways > 0)) return
      if (has_fronts(s)) then
         call follow_points()
      else
         call count_cycles(s%growing%fatigue, s%model, ways, there, off, have_arrested)
         s%growing%fatigue%at = now
      end if
      s%is_over = have_arrested .or. s%growing%fatigue%life >= 0
      if (s%growing%fatigue%life >= 0) then
         call tell_fracture(s)
      else if (have_arrested) then
         call add_line(s%warning, 'the run ends before end_time, as tips arrest within the next increment: their range of K '// &
                       'falls to the threshold')
      else
         call look_at_rate()
      end if

   contains

      !> Warn once of an increment that took less than a cycle, and of a first one that took so few that a tip went on by more than
      !> it opens in a cycle, K**2/(4 E yield stress), or so many that no test has lasted as long: it is not for a law of cycles, or
      !> its constants are for other units.
      subroutine look_at_rate()
         character(*), parameter :: increment = 'an increment of growth has taken '
         real(dp), parameter :: softest = 1e3_dp  ! metal: modulus over yield stress
         real(dp), parameter :: most = 1e12_dp    ! cycles
         character(:), allocatable :: why
         real(dp) :: k, opening
         integer :: j
         if (index(s%warning, increment) > 0) return
         k = sqrt(maxval(sum(s%growing%fatigue%at(:modes, 1, :)**2, dim=1)))
         opening = softest/4*(k/minval([(s%problem%materials(j)%plane_modulus(), j=1, size(s%problem%materials))]))**2
         associate (cycles => s%growing%fatigue%cycles - before)
            if (cycles < 1) then
               why = 'less than one load cycle, '//three_digits(cycles)//' of it'
            else if (before > 0) then
               return
            else if (maxval(ways) > opening*cycles) then
               why = 'no more than '//three_digits(cycles)// &
                     ' load cycles, in each of which a tip went on by more than it opens in metals'
            else if (cycles > most) then
               why = three_digits(cycles)//' load cycles, more than any test'
            else
               return
            end if
         end associate
         call add_line(s%warning, s%problem%state%when()//increment//why//', for '//three_digits(maxval(ways))// &
                       ' m, where K is '//three_digits(k)//' Pa m^0.5: the law of growth is not for such K. Likely cause: '// &
                       '&growth rate_constant is for K in MPa m^0.5 or ways in mm, not in Pa m^0.5 and m; or loads are not '// &
                       'those of the law')
      end subroutine look_at_rate

      !> Count the cycles at points of fronts: at their present places, once these are evenly spaced again.
      subroutine follow_points()
         integer :: l
         do l = 1, size(now, 2)
            there(:, l, :) = at_points(s%growing, s%measurements%fronts, there(:, l, :))
         end do
         call count_cycles(s%growing%fatigue, s%model, ways, there, off, have_arrested)
         s%growing%fatigue%at = now
         call even_out_points(s%growing, s%measurements%fronts, s%growing%fatigue%advance_deficit)
         call even_out_points(s%growing, s%measurements%fronts, s%growing%fatigue%zone)
      end subroutine follow_points
   end subroutine follow_cycles

   !> After a step of time, or at the start, when all is measured: let tips advance for this time, or, where one has gone by its
   !> increment before, to then. The state is that of the end, with tips where they were.
   subroutine follow_time(s, failure)
      type(simulation_t), intent(inout) :: s
      type(failure_t), intent(inout) :: failure
      type(symmetric_turns_t) :: turns
      real(dp), allocatable :: ways(:), now(:, :, :), there(:, :, :)
      logical :: has_grown
      if (failure%failed()) return
      associate (fatigue => s%growing%fatigue, time => s%problem%state%time)
         fatigue%until = time
         now = fatigue%at
         call measure_cycles(s, now, failure)
         there = now
         fatigue%later = now
         if (s%problem%state%steps > 0 .and. .not. failure%failed()) then
            call grow(s, failure, has_grown)
            if (s%is_over) return
            ways = s%growing%points%advance
            if (has_grown) then
               call turn_to_symmetry(s, turns, failure)
               ways = s%growing%points%advance
               call measure_cycles(s, now, failure, there)
            end if
            if (failure%failed()) return
            call pass(s, ways, there)
            s%is_over = fatigue%life >= 0
            if (s%is_over) call tell_fracture(s)
            if (fatigue%cycles < time) then
               if (loads_change(s%problem, fatigue%cycles, time)) then
                  call rescale(s, 1.0_dp, failure, fatigue%cycles)
                  call measure_cycles(s, now, failure)
               end if
               time = fatigue%cycles
            end if
         end if
         fatigue%cycles = time
         fatigue%at = now
         fatigue%off = part_of_rate(s%problem, s%cracks, s%measurements)/2
         call book_step(s, failure)
         if (has_fronts(s) .and. s%problem%state%steps > 0) then
            call even_out_points(s%growing, s%measurements%fronts, fatigue%advance_deficit)
            call even_out_points(s%growing, s%measurements%fronts, fatigue%slope)
         end if
      end associate
   end subroutine follow_time

   !> Let time pass from the state before a step to that with K now: of fronts at the present places of their points.
   subroutine pass(s, ways, now)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(in) :: ways(:)            !! advances of points [m]
      real(dp), intent(in) :: now(:, :, :)       !! (modes and part of K_c, loads, points)
      real(dp) :: there(size(now, 1), size(now, 2), size(now, 3))
      there = now
      if (has_fronts(s) .and. any(ways > 0)) there(:, 1, :) = at_points(s%growing, s%measurements%fronts, now(:, 1, :))
      call pass_time(s%growing%fatigue, s%model, ways, there, part_of_rate(s%problem, s%cracks, s%measurements)/2)
   end subroutine pass

   !> Tell after how many cycles, or when, a crack breaks through.
   subroutine tell_fracture(s)
      type(simulation_t), intent(inout) :: s
      character(:), allocatable :: when
      when = 'after '//digits_text(s%growing%fatigue%life, 6)//' cycles'
      if (s%growing%driver == by_time) when = 'at t = '//digits_text(s%growing%fatigue%life, 6)//' s'
      call add_line(s%warning, 'fracture '//when//': the largest K reaches that of the toughness; the run ends before end_time')
   end subroutine tell_fracture

   !> After a load step, measured and booked: find K and K over K_c at each load of the cycles; `before` with the toughness of the
   !> body from which a tip has come.
   subroutine measure_cycles(s, now, failure, before)
      type(simulation_t), intent(inout) :: s
      real(dp), intent(inout) :: now(:, :, :)    !! (modes and part of K_c, loads, tips)
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable, intent(out), optional :: before(:, :, :)
      type(at_load_t), allocatable :: at(:)
      type(next_t) :: next(size(now, 3))
      integer :: l
      if (present(before)) before = now
      if (failure%failed()) return
      call measure_at_loads(s, spread(.true., 1, size(now, 2)), at, failure)
      if (failure%failed()) return
      do l = 1, size(at)
         if (present(before)) then
            s%growing%looks_back = .true.
            call take(before(:, l, :))
            s%growing%looks_back = .false.
         end if
         call take(now(:, l, :))
      end do
   contains
      !> K and K over K_c of all points at a load.
      subroutine take(of)
         real(dp), intent(inout) :: of(:, :)
         integer :: k
         next = next_of_points(s%growing, s%model, s%cracks, at(l)%crack, at(l)%fronts, at(l)%factor)
         do k = 1, size(next)
            if (.not. next(k)%is_there) cycle
            of(:modes, k) = next(k)%intensity
            if (next(k)%toughness > 0) of(modes + 1, k) = sqrt(max(0.0_dp, next(k)%rate)/next(k)%toughness)
         end do
      end subroutine take
   end subroutine measure_cycles
end module hampm_growth_in_cycles
