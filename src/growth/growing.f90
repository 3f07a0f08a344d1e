!> Growth state of the tips of a run, static (`hampm_static_growth`) and dynamic (`hampm_dynamic_growth`): the data of both.
module hampm_growing
   use hampm_kinds, only: dp, long, ndim
   use hampm_tensors, only: norm
   use hampm_archive, only: archive_t
   use hampm_branching, only: branching_t, criteria_of, record_branching, why_it_may_branch
   use hampm_crack_groups, only: growth_t
   use hampm_crack_placement, only: take_toughness
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes
   use hampm_crack_values, only: crack_values_t, best_rate, best_t
   use hampm_cracks, only: cracks_t
   use hampm_equation_of_motion, only: speed_off
   use hampm_fatigue, only: fatigue_t, new_fatigue, record_cycle, archive_fatigue
   use hampm_front_values, only: front_values_t, parts_of
   use hampm_history, only: history_t
   use hampm_kinks, only: kink_t, best_kink, is_opened, kink_angle
   use hampm_load_work, only: load_state_t, archive_load_state
   use hampm_material, only: material_t
   use hampm_model, only: model_t
   use hampm_moving_tip, only: rayleigh_speed
   use hampm_text, only: add_line, to_text, three_digits
   use hampm_tolerance, only: bounded_ratio
   use hampm_toughness, only: advance_t, direction_of
   implicit none
   private
   public :: growing_t, growing_point_t, point_search_t, next_t, law_of, prescribed_advance, share_of_shear, new_growing, &
             record_growth, note_branching, record_frame, record_place, record_onset, archive_growing, fitting, &
             note_taken, tell_taken, part_of_crack, widths_of, add_once

   real(dp), parameter :: of_step = 1e-9_dp      !! part of a step in which growth has not begun
   !> How close a controlled quantity comes, over it: K of a tip varies as much with its place in a cell.
   real(dp), parameter, public :: close_control = 1e-3_dp

   integer, parameter, public :: by_load = 1     !! at rest: loads are scaled until the largest G is the toughness
   integer, parameter, public :: by_frame = 2    !! at rest: as a load frame moves
   integer, parameter, public :: by_cycles = 3   !! at rest: load cycles
   integer, parameter, public :: by_time = 4     !! at rest: time, in which loads follow their histories
   integer, parameter, public :: by_steps = 5    !! in motion: steps in time

   !> State of a point that trials of an implicit step (`hampm_advance_search`) leave to the next one.
   type :: point_search_t
      real(dp) :: trial = 0                      !! advance in a step, which is tried [m]
      real(dp) :: fall = 0                       !! decrease of the excess with the advance; 0: not known [1/m]
      real(dp) :: memory = 0                     !! time without motion after which it has arrested [s]
      logical :: is_running = .false.            !! of law = toughness: whether it has reached that
   end type point_search_t

   !> How a tip grows, a front of one point, or a point of a front of solids.
   type, extends(point_search_t) :: growing_point_t
      integer :: crack = 0                       !! number of its crack
      integer :: end = 1                         !! at which end of that a tip is
      integer :: front = 0                       !! number of its front; 0: of a tip, in motion of fronts that have ended too
      logical :: is_closed = .false.             !! whether that had no ends
      integer :: material = 0                    !! number of its material, in motion
      logical :: grows = .false.                 !! whether there is a &growth for it
      logical :: has_stopped = .false.           !! whether it has stopped permanently
      logical :: has_ended = .false.             !! whether it has reached its end and a message says so: it is no longer a tip
      logical :: is_loose = .false.              !! in motion: whether nothing holds the faces on its way any more since then
      real(dp) :: rate = 0                       !! energy release rate, last measured; static: of the step before [J/m2]
      ! Static growth
      real(dp) :: advance = 0                    !! advance in the last load step [m]
      logical :: has_come = .false.              !! whether that ended at a body of another toughness
      real(dp) :: extension = 0                  !! advance in the load steps before [m]
      real(dp) :: kink = 0                       !! angle of its last kink, to the left [rad]
      real(dp) :: slope = 0                      !! change of atan(K_II/K_I) with the angle of that, of a short kink
      real(dp) :: place(ndim) = 0                !! place of a front point: after the last load step, or as last measured [m]
      real(dp) :: width = 0                      !! of a front point: its length of the front, last measured [m]
      real(dp) :: off_path = 0                   !! sum of squares of what its ways are off in direction [m2]
      real(dp) :: beside = 0                        !! by which straight increments are beside a path that turns [m]
      real(dp) :: heading = 0                    !! direction of the last, from x to the left [rad]
      real(dp) :: reach = 0                      !! way in which a quantity that is controlled changes by all of itself [m]
      ! In motion, of tips of law = toughness in implicit steps, which search for their advance
      real(dp) :: excess = 0                     !! G over the toughness, less 1, after the last step [-]
      real(dp) :: lagged_excess = -1             !! the same, explicit: as it follows in the time for which a cut shakes cells [-]
      logical :: is_held = .false.               !! whether it can go no further in the step
      ! In motion
      real(dp) :: onset = -1                     !! when it, or a front of its crack, began to move; below 0: it has not [s]
      real(dp) :: onset_error = -1               !! of that, by the error of G and how fast it rises; below 0: not known [s]
      real(dp) :: off_way = 0                    !! law = toughness: error of its way by those of its speed; of fronts the mean [m]
      real(dp) :: off_speed = 0                  !! of a front: error of its speed, in the mean [m/s]
      real(dp) :: last_motion = -1               !! when it, or a front of its crack, moved last [s]
      integer :: law = 0                         !! number of its present or last &growth; 0: none so far
      real(dp) :: unloading_length = 0                      !! given speed, after arrest: unloading length of bonded points [m]
      logical :: has_no_room = .false.           !! whether its way is planned to where there is no more room for it
      real(dp) :: speed = 0                      !! of the same: recent speed [m/s]
      real(dp) :: lagged_speed = 0               !! that to which its measured G belongs [m/s]
      real(dp) :: toughness = 0                  !! to which its G is equal as it runs; 0 where that is not so [J/m2]
      real(dp) :: driving = 0                    !! G at its speed, of law = toughness, last measured [J/m2]
      real(dp) :: driving_of_forces = 0          !! that to which the forces of failing points belong [J/m2]
      real(dp) :: share = 1                      !! of J that its faces take, where material dissipates [-]
      real(dp) :: work = 0                       !! of failing points, of its crack, since the last search for speeds [J]
      real(dp) :: ahead = 0                      !! all work of these over the toughness, less its way [m]
      real(dp) :: reserve = 0                    !! rest of its planned path at which the next is planned [m]
      integer :: next_of_path = 1                !! direction = path: number of the next point
      integer :: n_k_samples = 0                       !! how often K was taken since the last turn
      real(dp) :: sum_of_k(modes) = 0            !! sum of these samples [Pa sqrt(m)]
      real(dp) :: shear = 0                      !! mode II share of G at the last measurement [-]
      real(dp) :: last_turn = -huge(1.0_dp)      !! its advance at the last turn too strong for a domain integral [m]; below 0: none
      logical :: is_sharp = .false.              !! whether that is so sharp that its values follow from those before it
      real(dp) :: room = 0                       !! around it for these [m]
      real(dp), allocatable :: usual_radii(:)    !! of its domain integrals [m]
      real(dp) :: booked = 0                     !! its way for which the integral of G is booked [m]
      type(branching_t) :: branching             !! at the last sample
   contains
      procedure :: has_arrested
   end type growing_point_t

   !> The next advance of a point.
   type :: next_t
      real(dp) :: kink = 0                       !! kink angle, to the left [rad]
      real(dp) :: rate = 0                       !! driving energy release rate, for `max_energy` of the kink [J/m2]
      real(dp) :: toughness = 0                  !! that it meets there [J/m2]
      logical :: is_there = .false.              !! whether there is a law for it, and it has not reached its end
      type(advance_t) :: advance                 !! arguments of its toughness straight on
      real(dp) :: intensity(modes) = 0           !! K; 0 where G is not above its own error [Pa sqrt(m)]
      integer :: hindrance = 0                   !! static: reason of `warn_of_waiting` for no advance at any load factor; 0: none
   end type next_t

   !> What faces have taken as all points in motion grew by their toughness.
   type :: taken_t
      real(dp) :: due = 0                        !! toughness times the new area [J]
      real(dp) :: way = 0                        !! of the points that are the fastest [cells]
      real(dp) :: part = 1                       !! taken, of that [-]
      real(dp) :: since = -1                     !! time from which on that differs; below 0: it does not [s]
      real(dp) :: from(ndim) = 0                 !! where points were then [m]
   end type taken_t

   !> All that grows.
   type :: growing_t
      type(growing_point_t), allocatable :: points(:) !! all tips, then points of fronts; not allocated without any &growth
      integer :: driver = by_steps               !! of growth
      logical :: is_static = .false.             !! whether tips advance by increments, under loads that are scaled
      ! Static growth
      type(fatigue_t) :: fatigue                 !! of law = fatigue and subcritical
      logical :: has_rates = .false.             !! whether by these
      real(dp) :: load_factor = 1                !! scale factor of loads and prescribed motions that are not held
      real(dp) :: work = 0                       !! of the loads at the end of the step before [J]
      type(load_state_t) :: loads                !! their state then
      real(dp) :: load = 0                       !! of a load frame [N]
      real(dp) :: displacement = 0               !! its displacement at the specimen [m]
      real(dp) :: frame_displacement = 0         !! that at its other end [m]
      real(dp) :: controlled = 0                 !! of the controlled quantity, at the end of the step before
      real(dp) :: first_critical = 0             !! the same as a point first grew; 0: none has
      real(dp) :: compliance = 0                 !! change of `frame_displacement` with the load factor; 0: not known [m]
      real(dp) :: part = 1                       !! part of an increment for the advance of tips
      logical :: have_onsets = .false.           !! whether cracks may appear
      integer :: onset_crack = 0                 !! number of the next one; 0: none
      real(dp) :: onset_length = 0               !! length with which it does [m]
      real(dp) :: onset_released = 0             !! energy that it releases then, over its area [J/m2]
      logical :: hold_still = .false.            !! whether tips below their toughness do not advance
      logical :: looks_back = .false.            !! whether points that have come to another body have the toughness before it
      logical :: have_no_load = .false.          !! the same in the next load step, as no load was found that brings a tip to it
      ! In motion
      logical :: is_implicit = .false.           !! whether tips of law = toughness search for their advance, in implicit steps
      integer(long) :: searched = -1             !! steps before the last search for speeds; below 0: none
      real(dp) :: integral = 0                   !! of G over the new area, up to where tips were booked last [J]
      real(dp) :: since_booked = 0               !! the same from there to the last row [J]
      type(taken_t) :: taken                     !! by faces that open by the toughness
      logical :: must_cut = .false.              !! whether cells are to be cut anew, where ways are planned or end, or fronts move
      integer :: pieces = 0                      !! in how many all material was at the start
      logical :: is_adrift = .false.             !! whether a separated piece moves with the load frame and carries no load
      real(dp) :: separated = -1                 !! time at which a crack has separated a body; below 0: not yet [s]
   contains
      procedure :: are_there
      procedure :: is_growing
      procedure :: add_points
      procedure :: law_at
      procedure :: cells_ahead
      procedure :: advance_of
      procedure :: next_of
      procedure :: kink_of
      procedure :: to_next_point
      procedure :: fit_radii
      procedure :: stop_points
      procedure, nopass :: warn_once
      procedure, nopass :: warn_of_waiting
   end type growing_t

   real(dp), parameter :: just_ahead = 1e-3_dp   !! cells
   real(dp), parameter, public :: front_ahead = 0.1_dp !! of points of fronts at rest [cells]
   real(dp), parameter :: off_toughness = 0.05_dp !! of what faces take in motion over toughness times area: it is told
   real(dp), parameter :: first_cells = 4        !! in which points of a starting tip take more or less than that

contains

   !> Whether any tip is to grow, or a crack to appear.
   pure logical function are_there(self)
      class(growing_t), intent(in) :: self
      are_there = self%have_onsets
      if (allocated(self%points)) are_there = are_there .or. any(self%points%grows)
   end function are_there

   !> Whether a point still grows.
   pure logical function is_growing(self, point)
      class(growing_t), intent(in) :: self
      integer, intent(in) :: point
      is_growing = self%points(point)%grows .and. .not. self%points(point)%has_stopped
   end function is_growing

   !> Number of the &growth that applies to a point at a time, the last one in a step from there on; 0 for none.
   pure integer function law_at(self, model, point, time, step) result(law)
      class(growing_t), intent(in) :: self
      type(model_t), intent(in) :: model
      integer, intent(in) :: point
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(in), optional :: step     !! [s]
      law = 0
      if (self%is_growing(point)) law = law_of(model, self%points(point)%crack, self%points(point)%end, time, step)
   end function law_at

   !> The same for an end of a crack.
   pure integer function law_of(model, crack, end, time, step) result(law)
      type(model_t), intent(in) :: model
      integer, intent(in) :: crack, end          !! their numbers; a plane is its first end
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(in), optional :: step     !! [s]
      real(dp), parameter :: rounding = 1e-12_dp ! of a time that is a number of steps
      real(dp) :: last
      integer :: k
      law = 0
      last = time*(1 + rounding)
      if (present(step)) last = time + step*(1 - of_step)
      do k = 1, size(model%growth)
         if (is_of(model%growth(k), crack, end) .and. last >= model%growth(k)%start .and. &
             time < model%growth(k)%end*(1 - rounding)) law = k
      end do
   end function law_of

   !> Advance of an end of a crack at given speeds in a step [m].
   pure real(dp) function prescribed_advance(model, crack, end, time, step) result(advance)
      type(model_t), intent(in) :: model
      integer, intent(in) :: crack, end          !! their numbers
      real(dp), intent(in) :: time, step         !! [s]
      integer :: k
      advance = 0
      do k = 1, size(model%growth)
         associate (growth => model%growth(k))
            if (.not. (is_of(growth, crack, end) .and. growth%law%gives_speed())) cycle
            associate (from => max(time, growth%start), to => min(time + step, growth%end))
               if (to - from > of_step*step) advance = advance + growth%speed_at((from + to)/2)*(to - from)
            end associate
         end associate
      end do
   end function prescribed_advance

   !> Whether a &growth is for an end of a crack.
   pure logical function is_of(growth, crack, end)
      type(growth_t), intent(in) :: growth
      integer, intent(in) :: crack, end          !! their numbers
      is_of = growth%path == crack .and. growth%of_end(end)
   end function is_of

   !> Arguments of the toughness of a tip that grows straight; the body is the one just ahead of it.
   pure function advance_of(self, model, cracks, tip) result(advance)
      class(growing_t), intent(in) :: self
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: tip
      type(advance_t) :: advance
      associate (of => cracks%tips(tip))
         advance = advance_t(speed=of%speed, length=cracks%crack(of%crack)%length(), &
                             extension=of%grown + self%points(tip)%extension + self%points(tip)%advance, &
                             angle=direction_of(of%axis(:, 1)), shear=self%points(tip)%shear)
         call take_toughness(model, of%place + self%cells_ahead(tip)*of%nodes%spacing*of%axis(:, 1), of%place, &
                             advance)
      end associate
   end function advance_of

   !> How far ahead of a point its body is asked for [cells]; behind, where it has just come to another one and looks back. Fronts
   !> at rest end at seams by their nodes, between which they are some part of a cell beside a curved one.
   pure real(dp) function cells_ahead(self, point)
      class(growing_t), intent(in) :: self
      integer, intent(in) :: point
      cells_ahead = merge(front_ahead, just_ahead, self%is_static .and. self%points(point)%front > 0)
      if (self%looks_back .and. self%points(point)%has_come) cells_ahead = -cells_ahead
   end function cells_ahead

   !> Next advance of a tip by the direction of a &growth, from its measured values; straight in dynamics, once the tip runs.
   pure function next_of(self, model, cracks, tip, growth, values) result(next)
      class(growing_t), intent(in) :: self
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: tip
      type(growth_t), intent(in) :: growth
      type(crack_values_t), intent(in) :: values
      type(next_t) :: next
      type(advance_t) :: advance
      type(kink_t) :: kink
      advance = self%advance_of(model, cracks, tip)
      next%advance = advance
      next%is_there = .true.
      next%intensity = values%intensity
      if (cracks%tips(tip)%is_half()) next%intensity(2:) = 0
      if (.not. cracks%tips(tip)%has_ended) then ! else there are values of before it has
         if (self%is_static) advance%shear = share_of_shear(values)
         next%rate = best_rate(values, cracks%tips(tip))
      end if
      if (.not. (cracks%tips(tip)%has_ended .or. self%points(tip)%is_running)) then
         kink = self%kink_of(model, cracks, tip, growth, values%intensity, t_stress_of(values))
         next%kink = kink%angle
         if (growth%direction == 'max_energy') then
            next%rate = next%rate*kink%gain
            advance%shear = kink%shear
         end if
         advance%angle = advance%angle + kink%angle
      end if
      next%toughness = growth%toughness_at(advance)
      if (.not. self%is_static .or. cracks%tips(tip)%has_ended) return
      if (.not. values%is_above_error(cracks%tips(tip))) then
         next%hindrance = 2
         next%intensity = 0
      end if
      if (growth%direction == 'straight') then
         if (values%presses(cracks%tips(tip))) next%hindrance = 1
      else if (.not. is_opened(trim(growth%direction), values%intensity)) then
         next%hindrance = 1
      end if
   end function next_of

   !> Kink of a tip by the direction of a &growth.
   pure type(kink_t) function kink_of(self, model, cracks, tip, growth, k, t_stress) result(kink)
      class(growing_t), intent(in) :: self
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: tip
      type(growth_t), intent(in) :: growth
      real(dp), intent(in) :: k(modes)           !! [Pa sqrt(m)]
      real(dp), intent(in) :: t_stress           !! [Pa]
      if (growth%direction == 'max_energy') then
         kink = best_kink(k, t_stress*sqrt(growth%increment), self%advance_of(model, cracks, tip), growth%factors)
      else
         kink%angle = kink_angle(trim(growth%direction), k)
      end if
   end function kink_of

   !> T-stress, where it is measured [Pa].
   pure real(dp) function t_stress_of(values) result(t_stress)
      type(crack_values_t), intent(in) :: values
      t_stress = 0
      if (allocated(values%t_stress)) t_stress = sum(values%t_stress)/size(values%t_stress)
   end function t_stress_of

   !> Share of mode II in G [-].
   pure real(dp) function share_of_shear(values) result(share)
      type(crack_values_t), intent(in) :: values
      share = abs(values%domain(2))/max(sum(abs(values%domain)), tiny(share))
   end function share_of_shear

   !> The growth state of a model.
   subroutine new_growing(model, cracks, fronts, growing)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(front_values_t), intent(in) :: fronts(:)
      type(growing_t), intent(out) :: growing
      integer :: k, i, n
      growing%have_onsets = size(model%nucleations) > 0
      if (size(model%growth) == 0 .and. .not. growing%have_onsets) return
      growing%is_static = any(model%growth%law%is_static) .or. growing%have_onsets
      n = size(cracks%tips)
      growing%is_implicit = model%method%time == 'implicit' .and. n > 0
      allocate (growing%points(n + sum([(size(fronts(k)%arc), k=1, size(fronts))])))
      do k = 1, size(fronts)
         i = size(fronts(k)%arc)
         growing%points(n + 1:n + i)%crack = fronts(k)%domain%front%crack
         growing%points(n + 1:n + i)%front = k
         growing%points(n + 1:n + i)%is_closed = fronts(k)%domain%front%is_closed
         growing%points(n + 1:n + i)%width = widths_of(fronts(k))
         growing%points(n + 1:n + i)%law = findloc(model%growth%path, fronts(k)%domain%front%crack, dim=1)
         n = n + i
      end do
      growing%points%grows = growing%points%law > 0
      do k = 1, size(cracks%tips)
         growing%points(k)%crack = cracks%tips(k)%crack
         growing%points(k)%end = cracks%tips(k)%end
         do i = size(model%growth), 1, -1
            if (.not. is_of(model%growth(i), cracks%tips(k)%crack, cracks%tips(k)%end)) cycle
            growing%points(k)%grows = .true.
            if (growing%is_static) growing%points(k)%law = i
         end do
         growing%points(k)%usual_radii = cracks%tips(k)%radii
         growing%points(k)%has_ended = cracks%crack(cracks%tips(k)%crack)%waits
         growing%points(k)%has_stopped = growing%points(k)%has_ended
      end do
      growing%has_rates = any(model%growth%law%has_rate())
      if (growing%is_static) growing%driver = by_load
      if (growing%is_static .and. model%control%leads()) growing%driver = by_frame
      if (.not. growing%has_rates) return
      growing%driver = merge(by_time, by_cycles, any(model%growth%law%is_in_time))
      call new_fatigue(model%cycles, growing%points%law, growing%driver == by_time, growing%fatigue)
   end subroutine new_growing

   !> Direction from a place to the next point of a given path beyond it; straight on after the last one.
   function to_next_point(self, tip, points, from, before) result(direction)
      class(growing_t), intent(inout) :: self
      integer, intent(in) :: tip
      real(dp), intent(in) :: points(:, :)       !! of the path [m]
      real(dp), intent(in) :: from(ndim)         !! [m]
      real(dp), intent(in) :: before(ndim)       !! direction so far
      real(dp) :: direction(ndim)
      real(dp), parameter :: nothing = 1e-9_dp   ! of the first radius
      direction = before
      do while (self%points(tip)%next_of_path <= size(points, 2))
         associate (way => points(:, self%points(tip)%next_of_path) - from)
            if (norm(way) > nothing*self%points(tip)%usual_radii(1)) then
               direction = way/norm(way)
               return
            end if
         end associate
         self%points(tip)%next_of_path = self%points(tip)%next_of_path + 1
      end do
   end function to_next_point

   !> Give a tip its usual radii if there is room for them without a strong turn of its crack, or right behind a sharp one.
   subroutine fit_radii(self, number, least, tip)
      class(growing_t), intent(in) :: self
      integer, intent(in) :: number              !! of the tip
      real(dp), intent(in) :: least              !! radius [m]
      type(crack_tip_t), intent(inout) :: tip
      real(dp) :: most
      associate (point => self%points(number))
         most = tip%grown - point%last_turn
         if (point%is_sharp .and. most < least) most = huge(most)
         most = min(point%room, max(least, most))
         tip%radii = fitting(point%usual_radii, least, most)
      end associate
   end subroutine fit_radii

   !> As many radii as before, between the least and the largest that there may be [m].
   pure function fitting(radii, least, most)
      real(dp), intent(in) :: radii(:), least, most
      real(dp) :: fitting(size(radii))
      real(dp) :: first, last
      integer :: k
      fitting = radii
      if (all(radii <= most)) return
      last = max(0.8_dp*most, least)
      first = min(max(0.4_dp*most, least), last)
      fitting = [(first + (k - 1)*(last - first)/max(1, size(radii) - 1), k=1, size(radii))]
   end function fitting

   !> Length of the front of each hat function; half of it on a symmetry plane, as energies are those of the half body [m].
   pure function widths_of(values) result(width)
      type(front_values_t), intent(in) :: values
      real(dp) :: width(size(values%arc))
      width = values%domain%front%length*parts_of(values)*merge(0.5_dp, 1.0_dp, values%domain%front%is_symmetry)
   end function widths_of

   !> Part of a crack's dissipation that the body supplies: one half on a symmetry plane, as energies are those of the half body.
   pure real(dp) function part_of_crack(tip) result(part)
      type(crack_tip_t), intent(in) :: tip
      part = merge(0.5_dp, 1.0_dp, tip%is_half())
   end function part_of_crack

   !> Stop points permanently, and say why once, or how they have ended: they are no longer tips, or points of a front.
   subroutine stop_points(self, points, why, message, name, at, have_ended)
      class(growing_t), intent(inout) :: self
      integer, intent(in) :: points(:)           !! their numbers
      character(*), intent(in) :: why
      character(:), allocatable, intent(inout) :: message !! to the user, a line each
      character(*), intent(in), optional :: name !! of their front or crack; default: that of the tip
      character(*), intent(in), optional :: at   !! end of the message
      logical, intent(in), optional :: have_ended
      character(:), allocatable :: text
      self%points(points)%has_stopped = .true.
      text = ' no longer grows: '//why
      if (present(have_ended)) then
         self%points(points)%has_ended = .true.
         text = ' '//why
      else
         self%points(points)%advance = 0
      end if
      if (present(name)) then
         call add_once(message, name//text, at)
      else
         call warn_once(points(1), text(2:), message)
      end if
   end subroutine stop_points

   !> Add a line, with more at its end, unless its beginning up to a colon is there already.
   pure subroutine add_once(text, line, more)
      character(:), allocatable, intent(inout) :: text
      character(*), intent(in) :: line
      character(*), intent(in), optional :: more
      if (index(text, line(:index(line//':', ':') - 1)) > 0) return
      call add_line(text, line)
      if (present(more)) text = text//more
   end subroutine add_once

   !> Note something of a tip, once.
   subroutine warn_once(number, what, message)
      integer, intent(in) :: number
      character(*), intent(in) :: what
      character(:), allocatable, intent(inout) :: message !! to the user, a line each
      character(:), allocatable :: text
      text = 'tip '//to_text(number)//' '//what
      if (ndim > 2) text = 'a front '//what      ! numbers are those of front points
      call add_once(message, text)
   end subroutine warn_once

   !> Note that a tip, or a front, waits in static growth.
   subroutine warn_of_waiting(number, hindrance, message)
      integer, intent(in) :: number
      integer, intent(in) :: hindrance           !! of it: 1 closed, 2 only by errors, 0 by neither
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: why
      why = ''
      if (hindrance == 1) why = 'nothing opens it in the direction that it would take, and '
      if (hindrance == 2) why = 'its G is not above its own error, as of faces that are closed, and '
      call warn_once(number, 'has waited in one load step at least: '//why//'no load factor brings it to its toughness', message)
   end subroutine warn_of_waiting

   !> Note, after a step, what faces have taken so far, and where that has left the toughness times the new area: after some cells,
   !> as points ahead of a tip have taken a part before it comes.
   pure subroutine note_taken(taken, fracture_energy, time, place)
      type(taken_t), intent(inout) :: taken
      real(dp), intent(in) :: fracture_energy    !! [J]
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(in) :: place(ndim)        !! of the points [m]
      if (.not. taken%due > 0) return
      taken%part = fracture_energy/taken%due
      if (abs(taken%part - 1) <= off_toughness .or. taken%way < first_cells) then
         taken%since = -1
      else if (taken%since < 0) then
         taken%since = time
         taken%from = place
      end if
   end subroutine note_taken

   !> Say at the end of a run that faces have not taken the toughness times their area.
   subroutine tell_taken(taken, message)
      type(taken_t), intent(in) :: taken
      character(:), allocatable, intent(inout) :: message
      character(:), allocatable :: where
      integer :: k
      if (taken%since < 0) return
      where = ''
      do k = 1, ndim
         where = where//merge('(', ' ', k == 1)//three_digits(taken%from(k))//merge(')', ',', k == ndim)
      end do
      call add_line(message, 'faces have taken '//three_digits(taken%part)//' of the toughness times the new area, off by more '// &
                    'than 5 % since t = '//three_digits(taken%since)//' s, from '//where//' m on: speeds and lengths may be '// &
                    'off as much. Smaller cells there and &method mass = ''weighted'' bring it nearer')
   end subroutine tell_taken

   !> Whether a tip that has grown has arrested at the end of a step: no motion in the step nor recently.
   elemental logical function has_arrested(self, time, dt)
      class(growing_point_t), intent(in) :: self
      real(dp), intent(in) :: time               !! at the end [s]
      real(dp), intent(in) :: dt                 !! of the step [s]
      has_arrested = self%last_motion >= 0 .and. time - self%last_motion > max(self%memory, dt/2)
   end function has_arrested

   !> Record where a tip is.
   subroutine record_place(cracks, tip, history)
      type(cracks_t), intent(in) :: cracks
      type(crack_tip_t), intent(in) :: tip
      type(history_t), intent(inout) :: history
      real(dp), parameter :: degree = acos(-1.0_dp)/180
      call history%record('crack_length', 'm', 'length of the whole crack in the material', cracks%crack(tip%crack)%length())
      history%is_of_none = cracks%crack(tip%crack)%waits
      call history%record('tip_x', 'm', 'place of the tip', tip%place(1))
      call history%record('tip_y', 'm', 'place of the tip', tip%place(2))
      call history%record('tip_angle', 'deg', 'direction out of the crack, from x to the left', &
                          atan2(tip%axis(2, 1), tip%axis(1, 1))/degree)
      history%is_of_none = .false.
   end subroutine record_place

   !> Record which crack is about to appear.
   subroutine record_onset(growing, history)
      type(growing_t), intent(in) :: growing
      type(history_t), intent(inout) :: history
      call history%record('onset_crack', '1', 'number of the crack that is about to appear; 0: none', growing%onset_crack)
      call history%record('onset_length', 'm', 'length with which it does', growing%onset_length)
      call history%record('onset_energy', 'J/m2', 'energy that it releases, over its area', growing%onset_released)
   end subroutine record_onset

   !> Record the load of a load frame, and its displacement.
   subroutine record_frame(growing, stiffness, history)
      type(growing_t), intent(in) :: growing
      real(dp), intent(in) :: stiffness          !! of the frame, 0: rigid [N/m]
      type(history_t), intent(inout) :: history
      call history%record('load', 'N', 'load of the frame: the largest of the forces that are scaled', growing%load)
      call history%record('load_displacement', 'm', 'its displacement at the specimen, with which its work is load times '// &
                          'displacement', growing%displacement)
      call history%record('frame_displacement', 'm', 'the same with what the load frame gives way', growing%frame_displacement)
      if (stiffness > 0) call history%record('frame_energy', 'J', 'energy that the load frame stores', &
                                             growing%load**2/(2*stiffness))
   end subroutine record_frame

   !> Record how a tip stands.
   subroutine record_growth(growing, model, material, cracks, tip, values, time, history)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(material_t), intent(in) :: material   !! at the tip
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: tip
      type(crack_values_t), intent(in) :: values !! of it
      real(dp), intent(in) :: time               !! [s]
      type(history_t), intent(inout) :: history
      type(next_t) :: next
      integer :: law
      associate (of => cracks%tips(tip))
         call record_place(cracks, of, history)
         if (.not. growing%is_static) call history%record('tip_speed', 'm/s', 'speed at which the tip grows', of%speed)
         if (.not. growing%points(tip)%grows) return
         law = growing%points(tip)%law
         if (.not. growing%is_static) law = growing%law_at(model, tip, time)
         if (law > 0) next = growing%next_of(model, cracks, tip, model%growth(law), values)
         if (.not. all(model%growth%law%gives_speed())) &
            call history%record('toughness', 'J/m2', 'energy release rate at which the crack grows; 0 while none applies', &
                                next%toughness)
         history%is_of_none = .not. of%is_measured()
         if (.not. growing%is_static .and. values%errors%are_known .and. .not. all(model%growth%law%gives_speed())) &
            call record_speed_off(growing%points(tip), of, model%growth(max(1, law)), next, values, material, history)
         if (growing%has_rates) call record_cycle(growing%fatigue, model, tip, values%errors%are_known, history)
         history%is_of_none = history%is_of_none .or. .not. material%isotropic .or. material%has_history .or. of%has_layers
         if (values%recorded%by_fields .and. .not. growing%is_static) call record_by_fields(of, values, history)
         history%is_of_none = .false.
         if (.not. growing%is_static) call record_branching(growing%points(tip)%branching, &
                                                            .not. all(model%growth%law%gives_speed()), history)
         if (.not. growing%is_static .or. law == 0) return
         if (model%growth(law)%direction /= 'straight' .and. values%errors%are_known) &
            call history%record('path_error', 'm', 'estimated distance of the tip from its path, across it', &
                                sqrt(growing%points(tip)%off_path) + abs(growing%points(tip)%beside))
         if (model%growth(law)%direction /= 'max_energy') return
         call history%record('G_kink', 'J/m2', 'energy release rate of the kink by which the tip goes on, by max_energy', next%rate)
         call history%record('kink_angle', 'deg', 'angle of that kink, to the left', next%kink*180/acos(-1.0_dp))
      end associate
   end subroutine record_growth

   !> Record the errors of the speed of a tip in motion, by that of G, and of its way: by those of its speed so far and its start.
   subroutine record_speed_off(point, tip, of, next, values, material, history)
      type(growing_point_t), intent(in) :: point
      type(crack_tip_t), intent(in) :: tip
      type(growth_t), intent(in) :: of           !! its law now
      type(next_t), intent(in) :: next
      type(crack_values_t), intent(in) :: values
      type(material_t), intent(in) :: material   !! at the tip
      type(history_t), intent(inout) :: history
      real(dp) :: off
      type(best_t) :: best
      off = 0
      best = values%best(tip, material%isotropic)
      if (point%is_running .and. .not. of%law%gives_speed()) off = speed_off(of, next%advance, next%rate, &
         bounded_ratio(best%error, best%rate, 1.0_dp), 0.0_dp, point%lagged_speed, rayleigh_speed(material))
      call history%record('tip_speed_error', 'm/s', 'estimated error of tip_speed', off)
      call history%record('crack_length_error', 'm', 'estimated error of crack_length at this time, by this tip', &
                          point%off_way + tip%speed*max(0.0_dp, point%onset_error))
   end subroutine record_speed_off

   !> Record K by the interaction integral with the fields of a running tip, beside J. Its error: difference of both and of domains.
   subroutine record_by_fields(tip, values, history)
      type(crack_tip_t), intent(in) :: tip
      type(crack_values_t), intent(in) :: values
      type(history_t), intent(inout) :: history
      integer :: n
      n = merge(1, modes, tip%is_half())
      call history%record_modes('K_', 'Pa m^0.5', 'stress intensity factor by the fields of a tip that runs', &
                                values%by_fields(:n), '_by_fields')
      associate (error => abs(values%by_fields - values%intensity) + values%errors%intensity%now)
         call history%record_modes('K_', 'Pa m^0.5', 'estimated error of that', error(:n), '_by_fields_error')
      end associate
   end subroutine record_by_fields

   !> Find the criteria of branching of tips in motion, none while no &growth applies, and note tips that may branch.
   subroutine note_branching(growing, model, materials, cracks, values, time, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(material_t), intent(in) :: materials(:)
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:) !! of all tips
      real(dp), intent(in) :: time               !! [s]
      character(:), allocatable, intent(inout) :: message
      real(dp) :: rate
      character(:), allocatable :: why
      integer :: k, i, law
      if (growing%is_static .or. .not. growing%are_there()) return
      do k = 1, size(cracks%tips)
         law = growing%law_at(model, k, time)
         growing%points(k)%branching = branching_t()
         if (law == 0) cycle
         rate = 0                                ! of a tip that is no longer measured
         if (cracks%tips(k)%is_measured()) rate = best_rate(values(k), cracks%tips(k))
         growing%points(k)%branching = criteria_of(materials(cracks%tips(k)%material_in(materials)), cracks%tips(k), &
                                                 model%growth(law), growing%advance_of(model, cracks, k), rate)
         if (.not. cracks%tips(k)%is_measured()) cycle
         do i = 1, 2
            why = why_it_may_branch(growing%points(k)%branching, by_energy=i == 1)
            if (why /= '') call warn_once(k, why//' and at t = '//three_digits(time)//' s; here it stays one', message)
         end do
      end do
   end subroutine note_branching

   !> Add points of static fronts, as copies of others.
   subroutine add_points(self, like)
      class(growing_t), intent(inout) :: self
      integer, intent(in) :: like(:)             !! the number of the other, of each
      type(growing_point_t), allocatable :: points(:)
      integer :: k, n
      n = size(self%points)
      allocate (points(n + size(like)))
      points(:n) = self%points
      do k = 1, size(like)
         points(n + k) = self%points(like(k))
      end do
      call move_alloc(points, self%points)
      if (.not. self%has_rates) return
      associate (fatigue => self%fatigue)
         fatigue%law = [fatigue%law, fatigue%law(like)]
         fatigue%advance_deficit = [fatigue%advance_deficit, fatigue%advance_deficit(like)]
         fatigue%zone = [fatigue%zone, fatigue%zone(like)]
         fatigue%slope = [fatigue%slope, fatigue%slope(like)]
         fatigue%at = reshape([fatigue%at, fatigue%at(:, :, like)], [shape(fatigue%at(:, :, 1)), size(fatigue%law)])
      end associate
   end subroutine add_points

   !> Keep how tips have grown.
   subroutine archive_growing(growing, archive)
      type(growing_t), intent(inout) :: growing
      class(archive_t), intent(inout) :: archive
      integer :: n, k
      if (.not. growing%are_there()) return
      n = size(growing%points)
      call archive%section('growth')
      call archive%serialise('points', n)
      if (archive%failure%failed()) return
      if (n > size(growing%points)) call growing%add_points(spread(size(growing%points), 1, n - size(growing%points)))
      if (n < size(growing%points)) growing%points = growing%points(:n)
      call archive%serialise('load_factor', growing%load_factor)
      call archive%serialise('work', growing%work)
      if (growing%is_static) call archive_load_state(growing%loads, archive)
      if (growing%has_rates) call archive_fatigue(growing%fatigue, archive)
      call archive%serialise('controlled', growing%controlled)
      call archive%serialise('first_critical', growing%first_critical)
      call archive%serialise('compliance', growing%compliance)
      call archive%serialise('have_no_load', growing%have_no_load)
      call archive%serialise('onset_crack', growing%onset_crack)
      call archive%serialise('onset_length', growing%onset_length)
      call archive%serialise('onset_released', growing%onset_released)
      call archive%serialise('searched', growing%searched)
      call archive%serialise('integral', growing%integral)
      call archive%serialise('taken_due', growing%taken%due)
      call archive%serialise('taken_way', growing%taken%way)
      call archive%serialise('taken_part', growing%taken%part)
      call archive%serialise('taken_since', growing%taken%since)
      call archive%archive_reals('taken_from', ndim, growing%taken%from)
      call archive%serialise('pieces', growing%pieces)
      call archive%serialise('separated', growing%separated)
      call archive%serialise('is_adrift', growing%is_adrift)
      call archive%archive_logicals('grows', n, growing%points%grows)
      call archive%archive_logicals('is_closed', n, growing%points%is_closed)
      call archive%archive_integers('crack', n, growing%points%crack)
      call archive%archive_integers('front', n, growing%points%front)
      do k = 1, ndim
         call archive%archive_reals('place_'//to_text(k), n, growing%points%place(k))
      end do
      call archive%archive_logicals('has_stopped', n, growing%points%has_stopped)
      call archive%archive_logicals('has_ended', n, growing%points%has_ended)
      call archive%archive_logicals('is_loose', n, growing%points%is_loose)
      call archive%archive_logicals('is_running', n, growing%points%is_running)
      call archive%archive_logicals('has_no_room', n, growing%points%has_no_room)
      call archive%archive_reals('rate', n, growing%points%rate)
      call archive%archive_reals('kink', n, growing%points%kink)
      call archive%archive_reals('extension', n, growing%points%extension)
      call archive%archive_reals('off_path', n, growing%points%off_path)
      call archive%archive_reals('beside', n, growing%points%beside)
      call archive%archive_reals('heading', n, growing%points%heading)
      call archive%archive_reals('reach', n, growing%points%reach)
      call archive%archive_reals('width', n, growing%points%width)
      call archive%archive_reals('shear', n, growing%points%shear)
      call archive%archive_reals('speed', n, growing%points%speed)
      call archive%archive_reals('lagged_speed', n, growing%points%lagged_speed)
      call archive%archive_reals('onset_error', n, growing%points%onset_error)
      call archive%archive_reals('off_way', n, growing%points%off_way)
      call archive%archive_reals('off_speed', n, growing%points%off_speed)
      call archive%archive_reals('excess', n, growing%points%excess)
      call archive%archive_reals('lagged_excess', n, growing%points%lagged_excess)
      call archive%archive_reals('toughness', n, growing%points%toughness)
      call archive%archive_reals('driving', n, growing%points%driving)
      call archive%archive_reals('driving_of_forces', n, growing%points%driving_of_forces)
      call archive%archive_reals('share', n, growing%points%share)
      call archive%archive_reals('work_of_points', n, growing%points%work)
      call archive%archive_reals('ahead', n, growing%points%ahead)
      call archive%archive_reals('memory', n, growing%points%memory)
      call archive%archive_reals('fall', n, growing%points%fall)
      call archive%archive_reals('reserve', n, growing%points%reserve)
      call archive%archive_reals('last_turn', n, growing%points%last_turn)
      call archive%archive_logicals('is_sharp', n, growing%points%is_sharp)
      call archive%archive_reals('room', n, growing%points%room)
      call archive%archive_reals('booked', n, growing%points%booked)
      call archive%archive_reals('onset', n, growing%points%onset)
      call archive%archive_reals('last_motion', n, growing%points%last_motion)
      do k = 1, modes
         call archive%archive_reals('sum_of_k_'//to_text(k), n, growing%points%sum_of_k(k))
      end do
      call archive%archive_integers('n_k_samples', n, growing%points%n_k_samples)
      call archive%archive_integers('law', n, growing%points%law)
      call archive%archive_reals('unloading_length', n, growing%points%unloading_length)
      call archive%archive_integers('next_of_path', n, growing%points%next_of_path)
   end subroutine archive_growing
end module hampm_growing
