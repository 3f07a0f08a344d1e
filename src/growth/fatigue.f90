!> Growth by rates, as cracks grow by increments: fatigue, in load cycles, and subcritical growth, in time. What is counted are
!> cycles, or seconds.
!>
!> The first tip to grow by its increment does so; the others advance in proportion to their rates. K of each tip is linear between
!> the rows before and after; the growth laws are integrated over it, through all blocks of cycles. The difference from a tip's
!> actual advance is kept as a deficit and added in the next step. So cycles and places are of second order in the increment. In
!> time K is linear in the way and, by loads that vary, in time (`pass_time`).
module hampm_fatigue
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hampm_kinds, only: dp
   use hampm_tensors, only: norm
   use hampm_archive, only: archive_t
   use hampm_crack_tip_field, only: modes
   use hampm_cycles_group, only: cycles_t
   use hampm_fatigue_rates, only: retardation
   use hampm_history, only: history_t
   use hampm_model, only: model_t
   implicit none
   private
   public :: time_error
   public :: fatigue_t, new_fatigue, advances_of, count_cycles, pass_time, has_fractured, has_loads, largest_loads, record_cycle, &
             rates_of, errors_of_rates, way_error, &
             archive_fatigue

   integer, parameter :: parts = 128             !! of an increment, in each of which rates are constant
   real(dp), parameter :: slowest = 1e-20_dp     !! least rate over the increment: fewer cycles in a part; such K may be rounding
   integer, parameter :: of_part = modes + 1     !! values of a tip: K of the modes [Pa sqrt(m)], K/K_c = sqrt(G/toughness) [-]

   !> The cycles so far, and the tips in them.
   type :: fatigue_t
      real(dp) :: cycles = 0, error = 0          !! and the estimated error of that; in time both in s
      integer :: block = 1                       !! the present one
      real(dp) :: done = 0                       !! cycles of it so far
      real(dp) :: life = -1                      !! cycles to fracture; below 0: no fracture
      integer, allocatable :: law(:)             !! number of the &growth of each tip; 0: it does not grow
      real(dp), allocatable :: advance_deficit(:) !! advance deficit of each tip [m]
      real(dp), allocatable :: slope(:)          !! in time: by what the speed of each tip rose with its last way [1/s]
      real(dp), allocatable :: zone(:)           !! from each tip to the end of the farthest plastic zone [m]
      real(dp), allocatable :: level(:)          !! factors of the loads at which K is needed; the first is 1 [-]
      integer, allocatable :: top(:), bottom(:)  !! numbers of the levels of each block
      real(dp), allocatable :: at(:, :, :)       !! K and K/K_c at the levels, (`of_part`, levels, tips)
      logical :: is_in_time = .false.            !! whether seconds are counted; loads have one level then, and one endless block
      real(dp) :: until = 0                      !! end of the present interval of time, at the latest [s]
      real(dp), allocatable :: later(:, :, :)    !! as `at`, for the loads at that end
      real(dp) :: off = 0                        !! part of K by which it may be off, last measured [-]
   end type fatigue_t

contains

   !> No cycle yet.
   subroutine new_fatigue(cycles, law, is_in_time, fatigue)
      type(cycles_t), intent(in) :: cycles
      integer, intent(in) :: law(:)              !! number of the &growth of each tip, 0 for none
      logical, intent(in) :: is_in_time
      type(fatigue_t), intent(out) :: fatigue
      integer :: k
      fatigue%level = [1.0_dp]
      allocate (fatigue%top(size(cycles%number)), fatigue%bottom(size(cycles%number)))
      do k = 1, size(cycles%number)
         call add(cycles%factor(k), fatigue%top(k))
         fatigue%bottom(k) = 0
         if (.not. is_in_time) call add(cycles%factor(k)*cycles%ratio(k), fatigue%bottom(k))
      end do
      fatigue%law = law
      fatigue%is_in_time = is_in_time
      allocate (fatigue%advance_deficit(size(law)), fatigue%zone(size(law)), fatigue%slope(size(law)), source=0.0_dp)
      allocate (fatigue%at(of_part, size(fatigue%level), size(law)), source=0.0_dp)
   contains
      !> Find the number of a level, which is added where it is new.
      subroutine add(level, number)
         real(dp), intent(in) :: level
         integer, intent(out) :: number
         number = findloc(.not. abs(fatigue%level - level) > 0, .true., dim=1)
         if (number > 0) return
         fatigue%level = [fatigue%level, level]
         number = size(fatigue%level)
      end subroutine add
   end subroutine new_fatigue

   !> Range of K, ratio of least to largest K, and largest K/K_c of a tip in a block, of both modes. The largest K is the larger one
   !> of both ends of the cycle: at the least load if a held load opens the crack and the cyclic loads close it. In time the
   !> range is K.
   pure subroutine find_cycle(fatigue, at, block, range, ratio, part)
      type(fatigue_t), intent(in) :: fatigue
      real(dp), intent(in) :: at(:, :)           !! of the tip, (`of_part`, levels)
      integer, intent(in) :: block
      real(dp), intent(out) :: range             !! [Pa sqrt(m)]
      real(dp), intent(out) :: ratio, part       !! [-]
      real(dp), dimension(modes) :: largest, least
      integer :: upper
      range = 0
      ratio = 0
      part = 0
      upper = largest_end(fatigue, at, block)
      if (upper == 0) return
      largest = open_part(at(:, upper))
      least = 0
      if (.not. fatigue%is_in_time) least = open_part(at(:, fatigue%top(block) + fatigue%bottom(block) - upper))
      range = norm(largest - least)
      ratio = max(0.0_dp, min(1.0_dp, dot_product(least, largest)/sum(largest**2)))
      part = at(of_part, upper)
   end subroutine find_cycle

   !> Number of the load at the end of a cycle at which a tip has the larger K; 0 where it may grow at neither.
   pure integer function largest_end(fatigue, at, block) result(load)
      type(fatigue_t), intent(in) :: fatigue
      real(dp), intent(in) :: at(:, :)           !! of the tip, (`of_part`, levels)
      integer, intent(in) :: block
      real(dp) :: largest, of_end                ! K [Pa sqrt(m)]
      integer :: ends(2), k
      ends = [fatigue%top(block), fatigue%bottom(block)]
      load = 0
      largest = 0
      do k = 1, merge(1, 2, fatigue%is_in_time)
         of_end = merge(norm(open_part(at(:, ends(k)))), 0.0_dp, may_grow(at(:, ends(k))))
         if (of_end > largest) load = ends(k)
         largest = max(largest, of_end)
      end do
   end function largest_end

   !> Number of the load, in the present block or the first after it, with the largest K of each tip; 1 if no tip grows.
   pure function largest_loads(fatigue) result(loads)
      type(fatigue_t), intent(in) :: fatigue
      integer :: loads(size(fatigue%law)), k, b
      do k = 1, size(loads)
         loads(k) = 0
         do b = fatigue%block, fatigue%block + size(fatigue%top) - 1
            if (loads(k) == 0) loads(k) = largest_end(fatigue, fatigue%at(:, :, k), modulo(b - 1, size(fatigue%top)) + 1)
         end do
         loads(k) = max(1, loads(k))
      end do
   end function largest_loads

   !> Whether loads open or shear a tip that grows, at either end of any cycle.
   pure logical function has_loads(fatigue)
      type(fatigue_t), intent(in) :: fatigue
      integer :: k, b
      has_loads = any([((fatigue%law(k) > 0 .and. largest_end(fatigue, fatigue%at(:, :, k), b) > 0, b=1, size(fatigue%top)), &
                        k=1, size(fatigue%law))])
   end function has_loads

   !> K of which K_I below 0 counts as 0: faces are pressed on each other then, and shear alone lets a tip grow [Pa sqrt(m)].
   pure function open_part(k)
      real(dp), intent(in) :: k(:)               !! K, and that over K_c
      real(dp) :: open_part(modes)
      open_part = [max(k(1), 0.0_dp), k(2:modes)]
   end function open_part

   !> Whether a tip is opened, or sheared more than it is pressed shut.
   pure logical function may_grow(k)
      real(dp), intent(in) :: k(:)               !! K, and that over K_c
      may_grow = k(1) > 0 .or. abs(k(2)) > -k(1)
   end function may_grow

   !> Way of each tip in a cycle of a block [m].
   pure function rates_of(fatigue, model, at, block) result(rates)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: at(:, :, :)        !! (`of_part`, levels, tips)
      integer, intent(in) :: block
      real(dp) :: rates(size(at, 3)), range, ratio, part
      integer :: k
      rates = 0
      do k = 1, size(rates)
         if (fatigue%law(k) == 0) cycle
         associate (growth => model%growth(fatigue%law(k)))
            call find_cycle(fatigue, at(:, :, k), block, range, ratio, part)
            rates(k) = growth%rate_at(range, ratio, part)
            if (.not. rates(k) > slowest*growth%increment) rates(k) = 0
            rates(k) = rates(k)*retardation(growth%constants, zone_of(fatigue, model, at, block, k), fatigue%zone(k))
         end associate
      end do
   end function rates_of

   !> Length of the plastic zone of a tip at the largest load of a block, by Irwin; 0 where there is no retardation [m].
   pure real(dp) function zone_of(fatigue, model, at, block, tip) result(zone)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: at(:, :, :)
      integer, intent(in) :: block, tip
      real(dp) :: yield_stress
      integer :: upper
      zone = 0
      yield_stress = model%growth(fatigue%law(tip))%yield_stress()
      upper = largest_end(fatigue, at(:, :, tip), block)
      if (yield_stress > 0 .and. upper > 0) zone = (norm(open_part(at(:, upper, tip)))/yield_stress)**2/acos(-1.0_dp) &
                                                   /merge(1, 3, model%run%plane == 'stress')
   end function zone_of

   !> Advance of each tip that grows in the next cycles [m]: in the first in which one does, or the mean of all blocks if these
   !> repeat.
   pure function next_rates(fatigue, model, at, grows) result(rates)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: at(:, :, :)
      logical, intent(in) :: grows(:)            !! whether each tip still does
      real(dp) :: rates(size(at, 3))
      integer :: b
      rates = 0
      if (model%cycles%repeats) then
         do b = 1, size(fatigue%top)
            rates = rates + model%cycles%number(b)/sum(model%cycles%number)*merge(rates_of(fatigue, model, at, b), 0.0_dp, grows)
         end do
      else
         do b = fatigue%block, size(fatigue%top)
            rates = merge(rates_of(fatigue, model, at, b), 0.0_dp, grows)
            if (any(rates > 0)) return
         end do
      end if
   end function next_rates

   !> Advance of each tip in the next step, 0 or at least `least` [m].
   pure function advances_of(fatigue, model, grows, least) result(ways)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      logical, intent(in) :: grows(:)            !! whether each tip still does
      real(dp), intent(in) :: least(:)           !! [m]
      real(dp) :: ways(size(grows)), cycles
      integer :: k
      if (fatigue%is_in_time) then
         ways = merge(ways_in_time(fatigue, model, grows), 0.0_dp, grows)
         ways = merge(0.0_dp, max(ways, least), ways < least/2 .or. .not. ways > 0)
         return
      end if
      ways = next_rates(fatigue, model, fatigue%at, grows)
      if (.not. any(ways > 0)) return
      cycles = huge(cycles)
      do k = 1, size(ways)
         if (ways(k) > 0) cycles = min(cycles, model%growth(fatigue%law(k))%increment/ways(k))
      end do
      where (ways > 0)
         ways = ways*cycles + fatigue%advance_deficit
         ways = merge(0.0_dp, max(ways, least), ways < least/2)
      end where
   end function advances_of

   !> Advance of each tip up to the end of the interval of time, or until the first has gone by its increment, with K of its present
   !> place [m].
   pure function ways_in_time(fatigue, model, grows) result(ways)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      logical, intent(in) :: grows(:)            !! whether each tip still does
      real(dp), dimension(size(grows)) :: ways, rates
      real(dp) :: whole, time                    ! of a part of the interval [s]
      integer :: k, part
      ways = fatigue%advance_deficit
      whole = (fatigue%until - fatigue%cycles)/parts
      do part = 1, parts
         rates = rates_of(fatigue, model, fatigue%at + (part - 0.5_dp)/parts*(fatigue%later - fatigue%at), 1)
         time = whole
         do k = 1, size(ways)
            if (.not. grows(k)) rates(k) = 0
            if (rates(k) > 0) time = min(time, max(0.0_dp, model%growth(fatigue%law(k))%increment - ways(k))/rates(k))
         end do
         ways = ways + time*rates
         if (time < whole) return
      end do
   end function ways_in_time

   !> Whether K reaches K_c at the present place of a tip in the present block.
   pure logical function has_fractured(fatigue, model)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      has_fractured = .not. part_to_fracture(fatigue, model, fatigue%at, fatigue%at, fatigue%block) > 0
   end function has_fractured

   !> Part of a step at which K of a tip reaches K_c in a block; huge if it does not [-]. From below, K rises faster with the
   !> advance than an R-curve: the crack runs on.
   pure real(dp) function part_to_fracture(fatigue, model, before, after, block) result(part)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: before(:, :, :), after(:, :, :)
      integer, intent(in) :: block
      real(dp) :: most
      integer :: k, upper
      part = huge(part)
      do k = 1, size(fatigue%law)
         upper = largest_end(fatigue, before(:, :, k), block)
         if (fatigue%law(k) == 0 .or. upper == 0) cycle
         most = model%growth(fatigue%law(k))%largest_part()
         associate (first => before(of_part, upper, k), last => after(of_part, upper, k))
            if (first >= most) part = 0
            if (last > max(first, most)) part = min(part, max(0.0_dp, (most - first)/(last - first)))
         end associate
      end do
   end function part_to_fracture

   !> Count the cycles in which tips have advanced, from K before to K now. If K reaches K_c on the way, `life` is known.
   !> `have_arrested`: no block lets tips advance as far as they have.
   !>
   !> The error of the cycles: those that K less its relative error and dK**2/(12 K) takes more, the latter for K that is not linear
   !> between two places, with K''da**2 about dK**2/K. NaN if tips do not grow then.
   subroutine count_cycles(fatigue, model, ways, now, off, have_arrested)
      type(fatigue_t), intent(inout) :: fatigue
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: ways(:)            !! advances of tips [m]
      real(dp), intent(in) :: now(:, :, :)       !! as `at`
      real(dp), intent(in) :: off                !! part of K by which it may be off [-]
      logical, intent(out) :: have_arrested
      real(dp), dimension(size(ways)) :: rates, mean, slower
      real(dp) :: way, from, to, end, fracture, cycles, left, times, less, counted, part_more
      integer :: lead, idle, b
      have_arrested = .false.
      fatigue%off = off
      call choose_lead(fatigue, model, ways, lead, way)
      fatigue%advance_deficit = fatigue%advance_deficit - ways
      less = off + rise_of(fatigue%at(:, :, lead), now(:, :, lead))**2/12
      from = 0
      idle = 0
      part_more = 0
      do while (from < 1)
         end = min(1.0_dp, (floor(from*parts*(1 + epsilon(from))) + 1)/real(parts, dp))
         fracture = part_to_fracture(fatigue, model, fatigue%at, now, fatigue%block)
         if (fracture <= from) exit
         to = min(end, fracture)
         rates = rates_of(fatigue, model, between((from + to)/2), fatigue%block)
         slower = rates_of(fatigue, model, (1 - less)*between((from + to)/2), fatigue%block)
         left = huge(left)
         if (fatigue%block < size(fatigue%top) .or. model%cycles%repeats) left = model%cycles%number(fatigue%block) - fatigue%done
         if (rates(lead) > 0) then
            idle = 0
            cycles = way*(to - from)/rates(lead)
            if (cycles > left) then
               cycles = left
               to = from + left*rates(lead)/way
            end if
         else
            idle = idle + 1
            have_arrested = left >= huge(left) .or. idle > size(fatigue%top)
            if (have_arrested) return
            cycles = left
            to = from
         end if
         if (rates(lead) > 0) then
            part_more = excess_of_time(rates(lead), slower(lead))
            fatigue%error = fatigue%error + cycles*part_more
         end if
         call go_on(cycles, rates, fatigue%block)
         fatigue%done = fatigue%done + cycles
         from = to
         if (cycles < left) cycle
         fatigue%done = 0
         fatigue%block = modulo(fatigue%block, size(fatigue%top)) + 1
         if (fatigue%block > 1) cycle
         mean = 0                                ! all blocks, as often as they fit
         do b = 1, size(fatigue%top)
            if (part_to_fracture(fatigue, model, fatigue%at, now, b) <= end) exit
            mean = mean + model%cycles%number(b)*rates_of(fatigue, model, between((from + end)/2), b)
         end do
         if (b <= size(fatigue%top) .or. .not. mean(lead) > 0) cycle
         times = floor(way*(end - from)/mean(lead))
         if (times < 1) cycle
         from = from + times*mean(lead)/way
         counted = fatigue%cycles
         do b = 1, size(fatigue%top)
            call go_on(times*model%cycles%number(b), mean/sum(model%cycles%number), b)
         end do
         fatigue%error = fatigue%error + (fatigue%cycles - counted)*part_more
      end do
      if (from < 1) fatigue%life = fatigue%cycles
      fatigue%at = now
   contains
      !> K, and that over K_c, at a part of the step.
      pure function between(part) result(at)
         real(dp), intent(in) :: part
         real(dp) :: at(size(now, 1), size(now, 2), size(now, 3))
         at = fatigue%at + part*(now - fatigue%at)
      end function between

      !> Let cycles of a block pass.
      subroutine go_on(cycles, rates, block)
         real(dp), intent(in) :: cycles, rates(:)
         integer, intent(in) :: block
         integer :: k
         fatigue%cycles = fatigue%cycles + cycles
         fatigue%advance_deficit = fatigue%advance_deficit + cycles*rates
         do k = 1, size(fatigue%law)
            if (fatigue%law(k) > 0) fatigue%zone(k) = max(fatigue%zone(k) - cycles*rates(k), &
                                                          zone_of(fatigue, model, between(to), block, k))
         end do
      end subroutine go_on
   end subroutine count_cycles

   !> The tip that is the first to go by its increment, and its way by the rates of this step; the rest is an earlier deficit.
   pure subroutine choose_lead(fatigue, model, ways, lead, way)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: ways(:)            !! advances of tips [m]
      integer, intent(out) :: lead
      real(dp), intent(out) :: way
      real(dp) :: part(size(ways))
      integer :: k
      part = [(ways(k)/max(merge(model%growth(max(1, fatigue%law(k)))%increment, huge(way), fatigue%law(k) > 0), tiny(way)), &
               k=1, size(ways))]
      lead = maxloc(part, dim=1)
      way = ways(lead) - fatigue%advance_deficit(lead)
      if (way < ways(lead)/2) way = ways(lead)
   end subroutine choose_lead

   !> Change of the largest K of a tip in a step, over it [-].
   pure real(dp) function rise_of(before, now) result(rise)
      real(dp), intent(in) :: before(:, :), now(:, :) !! (`of_part`, levels)
      associate (first => maxval(abs(before(:modes, :))), last => maxval(abs(now(:modes, :))))
         rise = 0
         if (first > 0) rise = min(1.0_dp, abs(last/first - 1))
      end associate
   end function rise_of

   !> Part by which a way takes more cycles, or time, at a lower rate; NaN where there is no growth at that [-].
   pure real(dp) function excess_of_time(rate, slower) result(excess)
      real(dp), intent(in) :: rate, slower
      excess = ieee_value(rate, ieee_quiet_nan)
      if (slower > 0) excess = rate/slower - 1
   end function excess_of_time

   !> Let time pass while tips go their ways, from K before to K now, which is of the end of the interval: until the first has gone
   !> its way, or the interval is over, or nearly so. K is the sum of what it changes by with the way and, at the old places, with
   !> time; both are linear. If K reaches K_c in this time, `life` is known. The error is that of `count_cycles`; where there is no
   !> growth at the lower K the time for a way may be all of it, or what the rate gains at the higher K.
   subroutine pass_time(fatigue, model, ways, now, off)
      type(fatigue_t), intent(inout) :: fatigue
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: ways(:)            !! advances of tips [m]
      real(dp), intent(in) :: now(:, :, :)       !! as `at`
      real(dp), intent(in) :: off                !! part of K by which it may be off [-]
      real(dp), parameter :: part_late = 0.1_dp, least_late = 0.01_dp ! of the way; of an increment
      real(dp) :: late                           ! way by which a tip may be late at the end of the interval [m]
      real(dp) :: rates(size(ways)), slower(size(ways)), faster(size(ways)), way, done, part, start, whole, time, less
      integer :: lead, half
      fatigue%off = off
      call choose_lead(fatigue, model, ways, lead, way)
      where (ways > 0) fatigue%slope = max(0.0_dp, rates_of(fatigue, model, now, 1) - rates_of(fatigue, model, fatigue%later, 1)) &
                                       /max(ways, tiny(way))
      fatigue%advance_deficit = fatigue%advance_deficit - ways
      less = off + rise_of(fatigue%later(:, :, lead), now(:, :, lead))**2/12
      late = part_late*way
      if (fatigue%law(lead) > 0) late = max(late, least_late*model%growth(fatigue%law(lead))%increment)
      start = fatigue%cycles
      whole = fatigue%until - start
      done = 0
      rates = 0
      do while (fatigue%cycles < fatigue%until)
         if (.not. done < 1 .and. (fatigue%until - fatigue%cycles)*rates(lead) > late) exit
         if (.not. part_to_fracture(fatigue, model, between(done, fatigue%cycles), between(done, fatigue%cycles), 1) > 0) then
            fatigue%life = fatigue%cycles
            exit
         end if
         part = 0
         time = 0
         do half = 1, 2                          ! by the rates of the start, then by those of the middle
            rates = rates_of(fatigue, model, between(done + part/2, fatigue%cycles + time/2), 1)
            time = min(whole/parts, fatigue%until - fatigue%cycles)
            part = 0
            if (.not. (way > 0 .and. rates(lead) > 0 .and. done < 1)) cycle
            part = min(1.0_dp/parts, 1 - done)
            if (part*way <= time*rates(lead)) then
               time = part*way/rates(lead)
            else
               part = time*rates(lead)/way
            end if
         end do
         slower = rates_of(fatigue, model, (1 - less)*between(done + part/2, fatigue%cycles + time/2), 1)
         if (part > 0) then
            faster = rates_of(fatigue, model, (1 + less)*between(done + part/2, fatigue%cycles + time/2), 1)
            faster(lead) = max(1.0_dp, faster(lead)/rates(lead) - 1)
            if (slower(lead) > 0) faster(lead) = min(faster(lead), rates(lead)/slower(lead) - 1)
            fatigue%error = fatigue%error + time*faster(lead)
         end if
         fatigue%advance_deficit = fatigue%advance_deficit + time*rates
         fatigue%cycles = fatigue%cycles + time
         done = done + part
         if (1 - done < epsilon(done)*parts) done = 1
         if (fatigue%until - fatigue%cycles <= epsilon(whole)*parts*fatigue%until) fatigue%cycles = fatigue%until
      end do
   contains
      !> K, and that over K_c, after a part of the way, and at a time.
      pure function between(part, time) result(at)
         real(dp), intent(in) :: part, time      !! [-], [s]
         real(dp) :: at(size(now, 1), size(now, 2), size(now, 3))
         at = fatigue%at + part*(now - fatigue%later)
         if (whole > 0) at = at + (time - start)/whole*(fatigue%later - fatigue%at)
      end function between
   end subroutine pass_time

   !> Record the cycle that a tip is in, or its speed and the errors of that and of its place.
   subroutine record_cycle(fatigue, model, tip, with_errors, history)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      integer, intent(in) :: tip
      logical, intent(in) :: with_errors
      type(history_t), intent(inout) :: history
      real(dp) :: range, ratio, part, rates(size(fatigue%law)), errors(size(fatigue%law))
      rates = rates_of(fatigue, model, fatigue%at, fatigue%block)
      if (with_errors) errors = errors_of_rates(fatigue, model)
      if (fatigue%is_in_time) then
         call history%record('tip_speed', 'm/s', 'speed at which the tip grows', rates(tip))
         if (.not. with_errors) return
         call history%record('tip_speed_error', 'm/s', 'estimated error of tip_speed', errors(tip))
         call history%record('crack_length_error', 'm', 'estimated error of crack_length at this time, by this tip', &
                             way_error(fatigue, tip, rates(tip)))
         return
      end if
      call find_cycle(fatigue, fatigue%at(:, :, tip), fatigue%block, range, ratio, part)
      call history%record('delta_K', 'Pa m^0.5', 'range of the stress intensity factor in the present load cycle', range)
      call history%record('ratio_of_K', '1', 'least over largest stress intensity factor in it', ratio)
      call history%record('growth_rate', 'm', 'way of the tip in that load cycle', rates(tip))
      if (.not. with_errors) return
      call history%record('delta_K_error', 'Pa m^0.5', 'estimated error of delta_K', fatigue%off*range)
      call history%record('growth_rate_error', 'm', 'estimated error of growth_rate', errors(tip))
   end subroutine record_cycle

   !> Error of the way of a tip at a time: what it goes in the error dt of that, and what it has not gone yet [m]. A speed that
   !> rises with the way as in the last step, dv/da = s, gives v (exp(s dt) - 1)/s.
   elemental real(dp) function way_error(fatigue, tip, rate)
      type(fatigue_t), intent(in) :: fatigue
      integer, intent(in) :: tip
      real(dp), intent(in) :: rate               !! its speed [m/s]
      real(dp), parameter :: most = 20           ! so that nothing overflows
      real(dp), parameter :: linear = 1e-4_dp    ! below which the next term is less than this
      way_error = rate*fatigue%error
      associate (rise => min(most, fatigue%slope(tip)*fatigue%error))
         if (rise > linear) way_error = way_error*(exp(rise) - 1)/rise
      end associate
      way_error = way_error + abs(fatigue%advance_deficit(tip))
   end function way_error

   !> Error of the time at which the tips are where they are: from K and the increments, and what the fastest one has not gone yet,
   !> or too far, over its speed [s].
   pure real(dp) function time_error(fatigue, model)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      time_error = fatigue%error
      associate (now => rates_of(fatigue, model, fatigue%at, fatigue%block))
         if (any(now > 0)) time_error = time_error + abs(fatigue%advance_deficit(maxloc(now, dim=1)))/maxval(now)
      end associate
   end function time_error

   !> What the rate of each tip changes by where K is off by its error [m], or in time [m/s].
   pure function errors_of_rates(fatigue, model) result(errors)
      type(fatigue_t), intent(in) :: fatigue
      type(model_t), intent(in) :: model
      real(dp) :: errors(size(fatigue%law))
      associate (now => rates_of(fatigue, model, fatigue%at, fatigue%block))
         errors = max(rates_of(fatigue, model, (1 + fatigue%off)*fatigue%at, fatigue%block) - now, &
                      now - rates_of(fatigue, model, (1 - fatigue%off)*fatigue%at, fatigue%block))
      end associate
   end function errors_of_rates

   !> Keep the cycles so far.
   subroutine archive_fatigue(fatigue, archive)
      type(fatigue_t), intent(inout) :: fatigue
      class(archive_t), intent(inout) :: archive
      call archive%serialise('cycles', fatigue%cycles)
      call archive%serialise('cycles_error', fatigue%error)
      call archive%serialise('block', fatigue%block)
      call archive%serialise('done', fatigue%done)
      call archive%serialise('off', fatigue%off)
      call archive%archive_reals('advance_deficit', size(fatigue%advance_deficit), fatigue%advance_deficit)
      call archive%archive_reals('slope', size(fatigue%slope), fatigue%slope)
      call archive%archive_reals('zone', size(fatigue%zone), fatigue%zone)
      call archive%archive_reals('at', size(fatigue%at), fatigue%at)
   end subroutine archive_fatigue
end module hampm_fatigue
