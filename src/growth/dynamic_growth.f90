!> Dynamic crack growth. A tip advances within a cell that is already cut, step by step, and bonded points fail behind it
!> (`hampm_nodal_release`). Its path is planned to a little beyond the next cell, or some cells ahead if the tip does not turn by
!> itself. There cells are cut anew, at the angle that the mode mix gives.
module hampm_dynamic_growth
   use hampm_kinds, only: dp, long, ndim
   use hampm_nodal_release, only: fail_behind, scale_failing
   use hampm_crack_values, only: best_t, crack_values_t
   use hampm_crack_placement, only: least_radius, body_at
   use hampm_crack_tip, only: crack_tip_t
   use hampm_cracks, only: cracks_t, last_point
   use hampm_equation_of_motion, only: speed_by_toughness, excess_of, followed, speed_off
   use hampm_forest, only: outside
   use hampm_front_values, only: front_values_t, error_of_largest, lasting_error, mean_rate, sample_error
   use hampm_growing, only: growing_t, growing_point_t, next_t, prescribed_advance, share_of_shear, part_of_crack
   use hampm_growth_points, only: next_of_points
   use hampm_growth_room, only: see_around_tips, see_surroundings, room_of_material, room_for, is_free, why_no_room, find_end, &
                               plan_end, end_tips, &
                                  shrink_domains
   use hampm_kinks, only: kink_t, hoop_intensity, is_opened
   use hampm_crack_groups, only: growth_t
   use hampm_particles, only: particles_t
   use hampm_problem, only: problem_t
   use hampm_moving_tip, only: rayleigh_speed, lead_of_release, release_length
   use hampm_model, only: model_t
   use hampm_tensors, only: norm, in_plane
   use hampm_tolerance, only: bounded_ratio
   use hampm_text, only: three_digits
   use hampm_turned_tips, only: sharp
   implicit none
   private
   public :: plan_ways, move_tips, must_check, find_speeds, note_check

   !> Length by which a planned path enters the next cell, which is cut then, in cells.
   real(dp), parameter :: into_next = 1e-3_dp

   !> The same if material moves through the cells: points that have begun to fail must stay where cells are cut.
   real(dp), parameter :: into_next_of_moving = 0.5_dp

   !> How many cells at once are planned where a crack does not turn by itself: to cut cells takes the time of some ten steps.
   integer, parameter :: straight_on = 4

   real(dp), parameter :: far_above = 2, from_start = 3 !! G over the toughness of a tip whose cells cannot follow it, cells later
   real(dp), parameter :: off_onset = 0.05_dp    !! error of the time at which a tip starts, of that: it is told
   real(dp), parameter :: late = 2               !! travel times of shear waves through a cell without motion: a tip has arrested

   real(dp), parameter :: straight = 0.2_dp*acos(-1.0_dp)/180 !! angle below which a crack grows straight [rad]
   real(dp), parameter :: most_turn = 0.2_dp     !! the same from one cell to the next, once a crack grows [rad]
   real(dp), parameter :: strong_turn = 0.1_dp   !! too strong to be in a domain integral [rad]
   integer, parameter :: steps_between_samples = 5 !! at G and K, where they decide on anything
   real(dp), parameter :: near_start = -0.75_dp  !! excess of G over the toughness above which there is a look before each step
   real(dp), parameter :: settling = 4           !! of cells that have been cut, in travel times of shear waves through a cell

contains

   !> Before a step: plan paths of tips that have reached the end of their plan, of the fastest first.
   subroutine plan_ways(growing, model, m, cracks, dt, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: m
      type(cracks_t), intent(inout) :: cracks
      real(dp), intent(in) :: dt                 !! of the step [s]
      character(:), allocatable, intent(inout) :: message
      logical :: has_planned(size(cracks%tips))
      integer :: order(size(cracks%tips)), i, k, law
      has_planned = .false.
      do k = 1, size(cracks%tips)
         law = growing%law_at(model, k, m%state%time, dt)
         if (law == 0 .or. growing%points(k)%has_no_room) cycle
         associate (of => model%growth(law), tip => cracks%tips(k))
            if (of%turns() .and. growing%points(k)%law /= law .and. growing%points(k)%law > 0) call cracks%forget_way(k)
            growing%points(k)%law = law
            if (.not. of%law%gives_speed()) then
               if (.not. growing%points(k)%is_running) then ! a cut shakes cells, also those of a tip that is about to start
                  if (growing%is_implicit .or. of%turns() .or. .not. is_about_to_start(growing%points(k))) cycle
               end if
               if (cracks%crack(tip%crack)%bonded(tip%end) > &
                   growing%points(k)%reserve + growing%points(k)%trial + lead_of(tip)) cycle
            else if (prescribed_advance(model, tip%crack, tip%end, m%state%time, dt) <= &
                     cracks%crack(tip%crack)%bonded(tip%end)) then
               cycle
            end if
            has_planned(k) = .true.
         end associate
      end do
      if (.not. any(has_planned)) return
      order = cracks%by_drive([(max(prescribed_advance(model, cracks%tips(k)%crack, cracks%tips(k)%end, m%state%time, dt), &
                                    growing%points(k)%speed*dt), k=1, size(order))])
      do i = 1, size(order)
         k = order(i)
         if (.not. has_planned(k)) cycle
         call plan(growing, model, m, cracks, k, model%growth(growing%points(k)%law), message)
         has_planned(k) = .not. growing%points(k)%has_no_room
      end do
      do k = 1, size(cracks%tips)                ! with all that has been planned: domains know no order of tips
         if (.not. has_planned(k)) cycle
         growing%points(k)%room = min(room_for(model, cracks, cracks%tips(k)%crack, cracks%end_place(k)), &
                                      room_of_material(model, cracks%tips(k)))
         call growing%fit_radii(k, least_radius(model), cracks%tips(k))
         call see_around_tips(model, cracks, cracks%tips(k)%crack)
      end do
   end subroutine plan_ways

   !> Whether G of a tip, as it grows now, reaches its toughness by the time at which cells that are cut now have settled.
   pure logical function is_about_to_start(point)
      type(growing_point_t), intent(in) :: point
      is_about_to_start = 2*point%excess - point%lagged_excess > 0
   end function is_about_to_start

   !> Plan the way of a tip to a little beyond the next cell, unless it would come too near to something, and ask to cut cells.
   subroutine plan(growing, model, m, cracks, k, of, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: m
      type(cracks_t), intent(inout) :: cracks
      integer, intent(in) :: k
      type(growth_t), intent(in) :: of
      character(:), allocatable, intent(inout) :: message
      real(dp), allocatable :: before(:, :)
      real(dp) :: from(ndim), to(ndim), direction(ndim), ahead(ndim), present(ndim), bonded, room, angle, beyond
      integer :: cells, next
      logical :: at_kink, is_clear, runs_through
      associate (tip => cracks%tips(k))
         allocate (before, source=cracks%crack(tip%crack)%points)
         bonded = cracks%crack(tip%crack)%bonded(tip%end)
         present = cracks%end_direction(k)
         next = growing%points(k)%next_of_path
         do cells = merge(1, straight_on, of%turns()), 1, -1 ! as many as there is room for
            growing%points(k)%next_of_path = next
            from = before(:, merge(size(before, 2), 1, tip%end == last_point))
            call choose_direction(growing, model, cracks, k, of, from, direction)
            ahead = direction
            is_clear = .true.
            do
               call next_point(m, cracks, growing, k, of, from, direction, cells, to, beyond, at_kink)
               if (is_clear) is_clear = is_free(model, cracks, tip%crack, from, to)
               call cracks%plan_way(k, to)
               if (.not. at_kink) exit
               from = to
               direction = growing%to_next_point(k, of%points, from, direction)
            end do
            room = merge(room_for(model, cracks, tip%crack, to), 0.0_dp, is_clear)
            if (room >= least_radius(model)*(1 - 1e-9_dp)) exit
            cracks%crack(tip%crack)%bonded(tip%end) = bonded
            call cracks%place(tip%crack, before)
         end do
         if (room < least_radius(model)*(1 - 1e-9_dp)) then
            growing%points(k)%has_no_room = .true. ! the tip stops where its way ends
            growing%points(k)%next_of_path = next
            from = before(:, merge(size(before, 2), 1, tip%end == last_point))
            call find_end(model, cracks, tip%crack, from, ahead, norm(to - from) + 2*least_radius(model), to, runs_through)
            if (runs_through) then
               if (norm(to - from) > m%grid%forest%tolerance()) call cracks%plan_way(k, to)
               call plan_end(model, cracks, k)
               growing%must_cut = .true.
            else if (.not. bonded > 0) then
               call growing%stop_points([k], why_it_stops(model, cracks, k), message)
            end if
            return
         end if
         growing%points(k)%reserve = beyond
         angle = acos(min(1.0_dp, dot_product(present, direction)))
         if (angle > strong_turn) then
            growing%points(k)%last_turn = tip%grown + bonded
            growing%points(k)%is_sharp = angle > sharp
         end if
      end associate
      growing%must_cut = .true.
   end subroutine plan

   !> Direction of a tip from the end of its planned path.
   subroutine choose_direction(growing, model, cracks, k, of, from, direction)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: k
      type(growth_t), intent(in) :: of
      real(dp), intent(in) :: from(ndim)         !! [m]
      real(dp), intent(out) :: direction(ndim)   !! unit vector
      real(dp) :: present(ndim), along(ndim), most
      real(dp) :: angle                          ! to the left of where the tip points to [rad]
      type(kink_t) :: kink
      associate (tip => cracks%tips(k))
         direction = tip%axis(:, 1)
         angle = 0
         select case (of%direction)
          case ('straight')
            return
          case ('path')
            direction = growing%to_next_point(k, of%points, from, direction)
          case default
            if (growing%points(k)%n_k_samples > 0) then
               kink = growing%kink_of(model, cracks, k, of, growing%points(k)%sum_of_k/growing%points(k)%n_k_samples, 0.0_dp)
               angle = kink%angle
            end if
            growing%points(k)%n_k_samples = 0
            growing%points(k)%sum_of_k = 0
            if (tip%grown > 0) then
               present = cracks%end_direction(k)
               along = matmul(present, tip%axis)
               most = most_turn
               angle = min(max(angle, atan2(along(2), along(1)) - most), atan2(along(2), along(1)) + most)
               if (abs(angle - atan2(along(2), along(1))) < straight) then
                  direction = present
                  return
               end if
            else if (abs(angle) < straight) then
               angle = 0
            end if
            direction = matmul(tip%axis, in_plane(cos(angle), sin(angle)))
         end select
      end associate
   end subroutine choose_direction

   !> The next point of a path: a little beyond the leaf or, if nearer, a point of a given path (`at_kink`).
   subroutine next_point(m, cracks, growing, k, of, from, direction, cells, to, beyond, at_kink)
      type(problem_t), intent(in) :: m
      type(cracks_t), intent(in) :: cracks
      type(growing_t), intent(inout) :: growing
      integer, intent(in) :: k
      type(growth_t), intent(in) :: of
      real(dp), intent(in) :: from(ndim), direction(ndim) !! in the reference configuration
      integer, intent(in) :: cells               !! how many are planned
      real(dp), intent(out) :: to(ndim)
      real(dp), intent(out) :: beyond            !! its length within the next leaf [m]
      logical, intent(out) :: at_kink
      real(dp) :: x(ndim), along(ndim), way, stretch, part
      integer :: leaf
      x = from
      along = direction
      stretch = 1
      part = into_next
      if (cracks%carries(cracks%tips(k)%crack)) then
         call find_in_grid(m%particles, m%grid%cut_cells%slack, x, along)
         stretch = norm(along)
         along = along/stretch
         part = into_next_of_moving
      end if
      associate (forest => m%grid%forest)
         leaf = forest%leaf_at(x + forest%tolerance()*(along + cracks%tips(k)%into_half()))
         way = forest%cell
         beyond = part*forest%cell
         if (leaf /= outside) then
            beyond = part*forest%size_of(leaf)
            way = forest%way_out(leaf, x, along, 1e-9_dp) + beyond + (cells - 1)*forest%size_of(leaf)
         end if
      end associate
      way = way/stretch
      to = from + way*direction
      at_kink = .false.
      if (of%direction /= 'path' .or. growing%points(k)%next_of_path > size(of%points, 2)) return
      if (norm(of%points(:, growing%points(k)%next_of_path) - from) > way) return
      to = of%points(:, growing%points(k)%next_of_path)
      growing%points(k)%next_of_path = growing%points(k)%next_of_path + 1
      at_kink = .true.
   end subroutine next_point

   !> Grid position of a place of the reference configuration, and of a direction there: the mean of the nearest particles.
   pure subroutine find_in_grid(p, slack, x, along)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: slack              !! distances that differ by less count as equal [m]
      real(dp), intent(inout) :: x(ndim)         !! [m]
      real(dp), intent(inout) :: along(ndim)     !! as long as the material makes it, of one that was a unit vector
      real(dp) :: distance, nearest, away(ndim), change(ndim), gradient(ndim, ndim)
      integer :: i, as_near
      nearest = huge(nearest)
      change = 0
      gradient = 0
      as_near = 0
      do i = 1, p%n
         away = x - p%reference(i, :)
         distance = norm(away)
         if (distance > nearest + slack) cycle
         if (distance < nearest - slack) as_near = 0
         nearest = min(distance, nearest)
         as_near = as_near + 1
         if (as_near == 1) change = 0
         if (as_near == 1) gradient = 0
         change = change + (p%displacement(i, :) + matmul(p%gradient_of(i), away) - change)/as_near
         gradient = gradient + (p%gradient_of(i) - gradient)/as_near
      end do
      x = x + change
      along = along + matmul(gradient, along)
   end subroutine find_in_grid

   !> Move tips in a step and fail the bonded points behind them: after an explicit step, before an implicit one, at whose end all
   !> is in equilibrium with them.
   subroutine move_tips(growing, model, m, cracks, time, dt, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(problem_t), intent(inout) :: m
      type(cracks_t), intent(inout) :: cracks
      real(dp), intent(in) :: time               !! at its start [s]
      real(dp), intent(in) :: dt                 !! its length [s]
      character(:), allocatable, intent(inout) :: message
      real(dp) :: way, taken, most(size(cracks%tips)), grown
      integer :: k, law
      most = largest_advances(growing, model, cracks, time, dt)
      do k = 1, size(cracks%tips)
         law = growing%law_at(model, k, time, dt)
         if (law > 0) growing%points(k)%law = law
         if (growing%points(k)%law == 0) cycle
         associate (of => model%growth(growing%points(k)%law), tip => cracks%tips(k))
            taken = 0
            grown = tip%grown
            if (of%law%gives_speed()) then
               way = min(prescribed_advance(model, tip%crack, tip%end, time, dt), most(k))
               call cracks%move_tip(k, way, m%grid%cut_cells%lines)
               tip%speed = way/dt
               associate (length => growing%points(k)%unloading_length)
                  length = merge(0.0_dp, length + of%speed_at(time)*dt, way > 0)
               end associate
               if (tip%has_ended) then           ! points beyond the end fail as if the tip advanced further
                  call fail_behind(m%interfaces, k, tip%grown + growing%points(k)%unloading_length, 0.0_dp, taken)
               else
                  call fail_behind(m%interfaces, k, tip%grown, growing%points(k)%unloading_length, taken)
               end if
            else if (growing%points(k)%is_running) then
               if (growing%is_implicit .and. runs_out(growing, model, cracks, k)) growing%points(k)%trial = most(k)
               if (.not. growing%is_implicit) growing%points(k)%trial = growing%points(k)%speed*dt
               call try_advance(growing, m, cracks, k, dt, most(k), taken)
            end if
            m%energies%fracture_energy = m%energies%fracture_energy + taken
            tip%toughness = 0
            if (tip%speed > 0 .and. .not. of%law%gives_speed()) &
               tip%toughness = of%toughness_at(growing%advance_of(model, cracks, k))
            if (tip%grown > grown) then
               if (growing%points(k)%onset < 0) growing%points(k)%onset = time
               growing%points(k)%last_motion = time + dt
               call see_surroundings(model, tip)
               if (growing%points(k)%is_sharp) call growing%fit_radii(k, least_radius(model), tip)
            end if
            if (tip%has_ended) tip%speed = 0
            call shrink_domains(growing, model, cracks, k, message)
         end associate
      end do
      do k = 1, size(cracks%tips)
         law = growing%law_at(model, k, time, dt)
         if (law == 0) cycle
         associate (of => model%growth(law), crack => cracks%crack(cracks%tips(k)%crack))
            if (of%max_length > 0 .and. crack%length() >= of%max_length*(1 - 1e-9_dp)) then
               call growing%stop_points([k], 'the crack has its max_length', message)
            else if (cracks%tips(k)%has_ended) then
               call end_tips(growing, model, cracks, message)
            else if (growing%points(k)%has_no_room .and. .not. crack%bonded(cracks%tips(k)%end) > 0) then
               call growing%stop_points([k], why_it_stops(model, cracks, k), message)
            end if
         end associate
      end do
   end subroutine move_tips

   !> Largest advance of each tip in a step [m], up to the end of its planned path. The tips of a crack share the rest of its
   !> max_length in proportion to their next advances, if these are more than half of it: no tip has precedence.
   function largest_advances(growing, model, cracks, time, dt) result(most)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      real(dp), intent(in) :: time, dt           !! [s]
      real(dp), dimension(size(cracks%tips)) :: most, way
      real(dp) :: left, of_all                   ! of the length of a crack, and to go for its tips [m]
      integer :: k, law(size(cracks%tips))
      most = 0
      way = merge(growing%points%trial, growing%points%speed*dt, growing%is_implicit)
      do k = 1, size(most)
         law(k) = growing%law_at(model, k, time, dt)
         if (law(k) == 0) cycle
         most(k) = cracks%crack(cracks%tips(k)%crack)%bonded(cracks%tips(k)%end)
         if (model%growth(law(k))%law%gives_speed()) &
            way(k) = prescribed_advance(model, cracks%tips(k)%crack, cracks%tips(k)%end, time, dt)
      end do
      way = min(way, most)
      do k = 1, size(most)
         if (law(k) == 0) cycle
         if (.not. model%growth(law(k))%max_length > 0) cycle
         left = max(0.0_dp, model%growth(law(k))%max_length - cracks%crack(cracks%tips(k)%crack)%length())
         of_all = sum(way, mask=cracks%tips%crack == cracks%tips(k)%crack)
         if (2*of_all > left) left = left*(way(k)/of_all)
         most(k) = min(most(k), left)
      end do
   end function largest_advances

   !> Advance a tip by its toughness: in explicit steps at its speed (`hampm_equation_of_motion`), in implicit ones by a trial
   !> advance (`hampm_advance_search`). Cohesive points fail behind it as for a given speed. While it rests their forces follow K
   !> as waves settle, as stresses around it do: what has failed in part would else yield to a load that rises, and the tip run on
   !> for nothing.
   subroutine try_advance(growing, m, cracks, k, dt, most, taken)
      type(growing_t), intent(inout) :: growing
      type(problem_t), intent(inout) :: m
      type(cracks_t), intent(inout) :: cracks
      integer, intent(in) :: k                   !! number of the tip
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: most               !! that it may move [m]
      real(dp), intent(out) :: taken             !! stored energy of bonded points that fail [J]
      real(dp), parameter :: least = 1e-3_dp     ! part of G to which forces follow it: they could not rise from 0
      real(dp) :: way, further, work, factor
      associate (tip => cracks%tips(k), wave => rayleigh_speed(m%materials(cracks%tips(k)%material_in(m%materials))))
         way = min(growing%points(k)%trial, wave*dt, most)
         growing%points(k)%is_held = way < growing%points(k)%trial .and. &
                                   (growing%points(k)%has_no_room .or. way < cracks%crack(tip%crack)%bonded(tip%end))
         call cracks%move_tip(k, way, m%grid%cut_cells%lines)
         growing%points(k)%speed = way/dt
         tip%speed = growing%points(k)%speed
         further = 0                             ! a step after the last one no point holds any more
         if (tip%has_ended .and. .not. way > 0) further = 2*release_length*tip%nodes%spacing
         if (tip%has_ended .and. .not. growing%is_implicit) then
            growing%points(k)%unloading_length = growing%points(k)%unloading_length + wave*dt
            further = growing%points(k)%unloading_length
         end if
         associate (point => growing%points(k))
            if (way > 0 .or. tip%has_ended) then
               point%driving_of_forces = point%driving
            else if (point%driving > least*point%driving_of_forces .and. point%driving_of_forces > 0) then
               factor = 1 + (point%driving/point%driving_of_forces - 1)*(1 - exp(-dt/(settling/late*point%memory)))
               call scale_failing(m%interfaces, k, sqrt(factor))
               point%driving_of_forces = factor*point%driving_of_forces
            end if
         end associate
         call fail_behind(m%interfaces, k, tip%grown + lead_of(tip) + further, 0.0_dp, taken, work)
         growing%points(k)%work = growing%points(k)%work + work
      end associate
   end subroutine try_advance

   !> How far the release of bonded points is ahead of a tip of law = toughness [m].
   pure real(dp) function lead_of(tip)
      type(crack_tip_t), intent(in) :: tip
      lead_of = lead_of_release(tip%grown, release_length*tip%nodes%spacing)
   end function lead_of

   !> Whether a tip is so near to the end of its crack that it advances to it at any G: no radius of a domain integral fits.
   pure logical function runs_out(growing, model, cracks, k)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: k                   !! its number
      runs_out = cracks%crack(cracks%tips(k)%crack)%is_through(cracks%tips(k)%end) .and. &
                 growing%points(k)%room < least_radius(model)*(1 - 1e-9_dp)
   end function runs_out

   !> Why a tip stops at the end of its way. Where a surface is ahead of it the body is all but in two.
   function why_it_stops(model, cracks, k) result(why)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: k                   !! its number
      character(:), allocatable :: why
      integer, parameter :: steps = 32           ! of the search for material
      real(dp) :: ahead
      integer :: step
      associate (tip => cracks%tips(k))
         why = 'a cell further '//why_no_room(model, tip%place + least_radius(model)/2*tip%axis(:, 1))
         do step = 1, steps
            ahead = 4*step*least_radius(model)/steps
            if (body_at(model, tip%place + ahead*tip%axis(:, 1)) > 0) cycle
            why = why//'. There are '//three_digits(ahead)//' m of material ahead of it: a real specimen would have separated '// &
                  'here, this one is still joined by it, and results from now on are of little use'
            return
         end do
      end associate
   end function why_it_stops

   !> Whether G and K have to be measured before the next step, as they decide on the advance or direction of a point.
   logical function must_check(growing, model, m, dt)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: dt                 !! of the step [s]
      integer :: k, law
      must_check = .false.
      if (growing%is_implicit) return               ! these are measured after each step
      do k = 1, size(growing%points)
         associate (point => growing%points(k))
            law = growing%law_at(model, k, m%state%time, dt)
            if (law == 0) then
               must_check = must_check .or. point%front > 0 .and. point%is_running ! its speed is 0 then
               cycle
            end if
            associate (of => model%growth(law), now_and_then => mod(m%state%steps, int(steps_between_samples, long)) == 0)
               if (of%law%gives_speed()) then
                  must_check = must_check .or. now_and_then .and. of%turns()
               else                              ! a tip that has arrested may run again
                  must_check = must_check .or. now_and_then .or. point%excess > near_start
               end if
            end associate
         end associate
      end do
   end function must_check

   !> Note K of tips for their direction.
   subroutine note_check(growing, cracks, values)
      type(growing_t), intent(inout) :: growing
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:)
      integer :: k
      do k = 1, size(cracks%tips)
         if (.not. cracks%tips(k)%is_measured()) cycle
         growing%points(k)%shear = share_of_shear(values(k))
         if (values(k)%is_turned) cycle          ! it goes straight on until domains see its kink
         if (cracks%tips(k)%grown > 0) then
            growing%points(k)%n_k_samples = growing%points(k)%n_k_samples + 1
            growing%points(k)%sum_of_k = growing%points(k)%sum_of_k + values(k)%intensity
         else
            growing%points(k)%n_k_samples = 1
            growing%points(k)%sum_of_k = values(k)%intensity
         end if
      end do
   end subroutine note_check

   !> Find the speeds of all points that grow by their toughness, tips and points of fronts alike, from what has been measured: K of
   !> the largest hoop stress for `hoop_stress`, else G. In implicit steps of tips find how far off their trial advances are.
   subroutine find_speeds(growing, model, m, cracks, values, fronts, dt, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: m
      type(cracks_t), intent(in) :: cracks
      type(crack_values_t), intent(in) :: values(:)
      type(front_values_t), intent(in) :: fronts(:)
      real(dp), intent(in) :: dt                 !! of a step [s]
      character(:), allocatable, intent(inout) :: message
      real(dp), parameter :: slower = 0.999_dp   ! than Rayleigh waves
      type(next_t) :: next(size(growing%points))
      real(dp) :: since                          ! the last search [s]
      real(dp) :: speed, wave, cell, start       ! [m/s], [m], [s]
      real(dp) :: left                           ! of a change, until the next search [-]
      integer :: k, j, law(size(next))
      logical :: is_measured, is_first, has_moved, by_toughness(size(next))
      start = m%state%time
      is_first = growing%searched < 0
      if (growing%is_implicit) start = start - dt ! of the step that has been tried
      since = dt
      if (.not. growing%is_implicit .and. growing%searched >= 0) since = max(1_long, m%state%steps - growing%searched)*dt
      growing%searched = m%state%steps
      law = [(growing%law_at(model, k, start, dt), k=1, size(law))]
      next = next_of_points(growing, model, cracks, values, fronts, law=law)
      by_toughness = law > 0
      do k = 1, size(next)
         if (by_toughness(k)) by_toughness(k) = .not. model%growth(law(k))%law%gives_speed()
         if (.not. by_toughness(k)) cycle
         associate (point => growing%points(k), direction => model%growth(law(k))%direction, rate => next(k)%rate)
            has_moved = point%is_running
            if (k <= size(cracks%tips)) then
               point%material = cracks%tips(k)%material_in(m%materials)
               has_moved = has_moved .and. cracks%tips(k)%grown > 0
            end if
            if (direction == 'hoop_stress' .and. .not. has_moved) then
               rate = max(hoop_intensity(next(k)%intensity), 0.0_dp)**2/m%materials(point%material)%plane_modulus()
            else if (.not. is_opened(trim(direction), next(k)%intensity)) then
               rate = 0
            end if
         end associate
      end do
      growing%points%excess = -1                 ! a point that may not grow rests
      growing%points%toughness = 0
      do k = 1, size(next)
         associate (point => growing%points(k), of => model%growth(max(1, law(k))))
            if (.not. by_toughness(k)) then
               if (point%front == 0) cycle
               point%speed = 0
               point%lagged_speed = 0
               point%is_running = .false.
               cycle
            end if
            is_measured = k > size(cracks%tips)
            cell = m%grid%finest_cell
            if (.not. is_measured) then
               is_measured = cracks%tips(k)%is_measured()
               cell = cracks%tips(k)%nodes%spacing
            end if
            associate (material => m%materials(point%material), rate => next(k)%rate)
               if (material%has_history) call take_share(pack([(j, j=1, size(next))], by_toughness .and. &
                  merge(growing%points%crack == point%crack, [(j == k, j=1, size(next))], point%front > 0)), k, cell)
               wave = rayleigh_speed(material)
               left = exp(-since*material%shear_wave_speed()/(settling*cell))
               speed = min(point%speed, slower*wave)
               point%lagged_speed = followed(point%lagged_speed, speed, since, material%shear_wave_speed(), cell)
               if (point%front == 0) then        ! what follows from before a turn is of its speed
                  if (values(k)%is_turned) point%lagged_speed = speed
               end if
               point%excess = excess_of(rate, next(k)%toughness, speed, point%lagged_speed, wave)
               point%driving = (1 + point%excess)*next(k)%toughness
               if (is_first) point%lagged_excess = point%excess
               if (rate >= next(k)%toughness .and. .not. (point%is_running .or. point%onset >= 0)) call note_onset(k, &
                  (point%excess - point%lagged_excess)*(1 - left)/since, cell/material%shear_wave_speed())
               point%lagged_excess = point%excess + (point%lagged_excess - point%excess)*left
               point%is_running = point%is_running .or. rate >= next(k)%toughness
               point%memory = late*cell/material%shear_wave_speed()
               if (point%front == 0) then
                  if (runs_out(growing, model, cracks, k)) point%excess = 0
                  if (point%is_running .and. .not. growing%is_implicit) &
                     call note_coarse_cells([k], cracks%tips(k)%grown/cracks%tips(k)%nodes%spacing)
               end if
               if (point%is_running .and. point%front == 0) point%off_way = max(0.0_dp, point%off_way + since* &
                  speed_off(of, next(k)%advance, rate, bounded_ratio(values(k)%average%error, values(k)%average%mean, 1.0_dp) + &
                            merge(abs(point%excess), 0.0_dp, growing%is_implicit), point%off_way, point%lagged_speed, wave))
               if (.not. point%is_running .or. growing%is_implicit) cycle
               if (is_measured) then
                  point%speed = speed_by_toughness(of, next(k)%advance, rate, point%lagged_speed, wave)
               else if (.not. point%speed > 0) then
                  point%speed = wave
               end if
               point%trial = point%speed*dt
               if (point%speed > 0) point%toughness = next(k)%toughness
            end associate
         end associate
      end do
      do j = 1, size(fronts)
         associate (of => pack([(k, k=1, size(next))], growing%points%front == j .and. growing%points%is_running))
            call follow_errors(of, fronts(j))
            if (any(growing%points(of)%onset >= 0)) call note_coarse_cells(of, maxval(growing%points(of)%speed)* &
                                                                         (start - growing%points(of(1))%onset)/m%grid%finest_cell)
         end associate
      end do

   contains

      !> Follow the errors of the speed and the way of a front in the mean: by that of G, and by those of G that last over cells.
      subroutine follow_errors(of, front)
         integer, intent(in) :: of(:)            !! numbers of its points that run
         type(front_values_t), intent(in) :: front
         growing%points(of)%off_speed = mean_off(of, bounded_ratio(sample_error(front), mean_rate(front), 1.0_dp), 0.0_dp)
         if (size(of) > 0) growing%points(of)%off_way = max(0.0_dp, growing%points(of)%off_way + since* &
            mean_off(of, bounded_ratio(lasting_error(front), mean_rate(front), 1.0_dp), growing%points(of(1))%off_way))
      end subroutine follow_errors

      !> The mean error of the speed of points of a front where G is off by a part [m/s].
      pure real(dp) function mean_off(of, part, ahead)
         integer, intent(in) :: of(:)            !! their numbers
         real(dp), intent(in) :: part            !! [-]
         real(dp), intent(in) :: ahead           !! way that they would have gone more, see `speed_off` [m]
         real(dp) :: off(size(of))
         off = [(speed_off(model%growth(law(of(k))), next(of(k))%advance, next(of(k))%rate, part, ahead, &
                           growing%points(of(k))%lagged_speed, rayleigh_speed(m%materials(growing%points(of(k))%material))), &
                 k=1, size(of))]
         mean_off = sum(growing%points(of)%width*off)/max(sum(growing%points(of)%width), tiny(1.0_dp))
      end function mean_off

      !> Note a tip, or the points of a front in the mean, that runs far above its toughness.
      subroutine note_coarse_cells(of, way)
         integer, intent(in) :: of(:)            !! numbers of the points
         real(dp), intent(in) :: way             !! since the start [cells]
         real(dp) :: part                        ! G over the toughness [-]
         part = sum(next(of)%rate)/sum(next(of)%toughness)
         if (way > from_start .and. part > far_above) &
            call growing%warn_once(of(1), 'is in cells that are too coarse for its toughness: it runs with a G of '// &
                                  three_digits(part)//' times that at t = '//three_digits(m%state%time)// &
                                  ' s. Its speed and fracture_energy may be off; take smaller cells there', message)
      end subroutine note_coarse_cells

      !> Note, as a point or the first of a crack with fronts starts, the error of its time: that of G over how fast it rises, that
      !> of waves in cells, and a step, as root of a sum of squares. It is told where the time is off by a twentieth.
      subroutine note_onset(k, rise, of_waves)
         integer, intent(in) :: k                !! number of the point
         real(dp), intent(in) :: rise            !! of G over the toughness [1/s]
         real(dp), intent(in) :: of_waves        !! time of a shear wave through a cell [s]
         type(best_t) :: best
         real(dp) :: part                        ! error of G over G [-]
         associate (point => growing%points(k))
            if (point%front > 0) then
               part = error_of_largest(fronts(point%front), fronts(point%front)%g_error)/maxval(fronts(point%front)%g)
            else
               best = values(k)%best(cracks%tips(k), m%materials(point%material)%isotropic)
               part = best%error/best%rate
            end if
            point%onset_error = hypot(since, of_waves)
            if (rise > 0) point%onset_error = hypot(point%onset_error, part*(1 + point%excess)/rise)
            if (point%front > 0) then
               where (growing%points%crack == point%crack) growing%points%onset_error = point%onset_error
            end if
            if (.not. point%onset_error > off_onset*m%state%time .or. is_first) return
            call growing%warn_once(k, 'starts at t = '//three_digits(m%state%time)//' s, with an error of '// &
                                  three_digits(point%onset_error)//' s: its cells are too coarse for how its load rises', message)
         end associate
      end subroutine note_onset

      !> Take of J of a tip, or of the points of a crack with fronts, the share that faces take where material dissipates: the work
      !> of failing points over J times the new area, averaged over half a cell of the way. It stays at rest. The work so far, over
      !> the toughness and less the way, is given back within a cell. All points of a crack have one share.
      subroutine take_share(of, k, cell)
         integer, intent(in) :: of(:)            !! their numbers
         integer, intent(in) :: k                !! one of them: the first finds the share
         real(dp), intent(in) :: cell            !! [m]
         real(dp), dimension(size(of)) :: width, way ! [m]
         if (k /= of(1)) return
         width = growing%points(of)%width
         way = growing%points(of)%speed*since
         if (k <= size(cracks%tips)) then
            width = part_of_crack(cracks%tips(k))*model%run%thickness%at(cracks%tips(k)%now)
            way = cracks%tips(k)%speed*since
         end if
         associate (point => growing%points(k), total => sum(width*next(of)%rate))
            if (total > 0) point%share = max(0.0_dp, point%share + (point%work - point%share*sum(width*next(of)%rate*way))/ &
                                                                 (total*cell/2))
            point%ahead = point%ahead + point%work/sum(width*next(of)%toughness) - sum(width*way)/sum(width)
            growing%points(of)%share = point%share
            growing%points(of)%ahead = point%ahead
            growing%points(of)%work = 0
            next(of)%rate = point%share*next(of)%rate*max(0.0_dp, 1 + point%ahead/cell)
         end associate
      end subroutine take_share
   end subroutine find_speeds
end module hampm_dynamic_growth
