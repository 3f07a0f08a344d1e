!> Values of a crack in the history: measurement, and the list of columns.
module hampm_crack_measurements
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hampm_kinds, only: dp, ndim, corners
   use hampm_tensors, only: norm
   use hampm_tolerance, only: bounded_ratio
   use hampm_crack_tip, only: crack_tip_t, frame_along
   use hampm_crack_values, only: crack_values_t, best_t, best_rate
   use hampm_cracks, only: cracks_t
   use hampm_estimated_errors, only: error_t, pace_t, follow, follow_speed, is_new_slot, is_sample, needs_sample, &
                                     waves_of
   use hampm_estimator, only: estimate_t
   use hampm_failure, only: failure_t
   use hampm_forest, only: corner_offset
   use hampm_history, only: history_t
   use hampm_loads, only: factors_at
   use hampm_mass_solver, only: mass_solver_t
   use hampm_material, only: material_t
   use hampm_moving_tip, only: rayleigh_speed
   use hampm_openings, only: opening_at, look_for_arrival
   use hampm_particles, only: particles_t
   use hampm_problem, only: problem_t
   use hampm_nodal_state, only: nodal_state_t
   use hampm_crack_tip_field, only: modes, tip_field_t
   use hampm_tip_domain, only: fields_at
   use hampm_tip_measurements, only: estimate_rates, error_of_rate, of_any_sign
   use hampm_turned_tips, only: turn_t, last_turn, turn_values
   implicit none
   private
   public :: measure_crack, look_at_tip, needs_values, record_crack

contains

   !> Measure, and find the energy release rate of all modes by the best of the chosen estimators [J/m2]; not allocated without any.
   !> Fails if the nodal equations cannot be solved.
   subroutine measure_crack(problem, cracks, number, state, extrapolation, values, g, failure, for_waves)
      type(problem_t), intent(inout) :: problem
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the tip
      type(nodal_state_t), intent(in) :: state   !! needed for a domain integral
      type(mass_solver_t), intent(inout) :: extrapolation !! solver without fixed components
      type(crack_values_t), intent(inout) :: values
      real(dp), allocatable, intent(out) :: g
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: for_waves !! whether for a sample alone
      real(dp), parameter :: middle(ndim) = 0    ! cells on both sides of the mouth count
      type(best_t) :: best
      type(tip_field_t) :: field(2)
      type(turn_t) :: turn
      logical :: agree                           ! whether J and K of the field are to be of one G
      logical :: by_j                            ! whether K has the size of J
      logical :: is_row                          ! whether openings may count, which have no error
      associate (p => problem%particles, grid => problem%grid, tip => cracks%tips(number), &
                 factors => factors_at(problem%loads, problem%state%time))
         if (tip%is_measured()) then
            if (size(tip%radii) > 0) turn = last_turn(cracks, number, tip%radii(1), grid%cut_cells%lines)
            if (abs(turn%angle) > 0) then
               call estimate_rates(problem, factors, turn%before, p, state, extrapolation, values, failure, for_waves)
            else
               call estimate_rates(problem, factors, tip, p, state, extrapolation, values, failure, for_waves)
            end if
            call turn_values(turn, tip%speed, problem%materials(tip%material_in(problem%materials)), values)
         end if
         is_row = .not. (present(for_waves) .and. values%in_sets)
         if (is_row) &
            values%mouth = opening_at(tip, grid%cut_cells%follow(cracks%crack(tip%crack)%mouth), middle, problem, p)
         if (.not. tip%is_measured()) return
         if (is_row) call find_openings_behind(tip, problem, p, values)
         if (tip%grown > 0 .and. .not. tip%has_layers) then ! K by fields has no certain sign near the speed of Rayleigh waves
            values%intensity(1) = sign(values%intensity(1), values%behind(1))
            values%domain(1) = sign(values%domain(1), values%behind(1))
            if (tip%may_close) then
               values%intensity(1) = max(values%intensity(1), 0.0_dp)
               values%domain(1) = max(values%domain(1), 0.0_dp)
            end if
         end if
         field = fields_at(problem%materials, tip)
         associate (material => problem%materials(tip%material_in(problem%materials)))
            agree = tip%nodes%in_cell .and. .not. (values%moves .or. values%is_closed .or. tip%grown > 0 .or. abs(turn%angle) > 0 &
                                                   .or. material%has_history .or. field(1)%is_at_interface)
            agree = agree .and. material%isotropic
            by_j = .not. (tip%nodes%in_cell .or. tip%grown > 0 .or. material%isotropic .or. material%has_history .or. &
                          values%is_closed .or. field(1)%is_at_interface)
            call follow_values(tip, field(1), rayleigh_speed(material), problem%state%time, pace_of(problem, tip, values), &
                               agree, by_j, material%is_finite, problem%runs_lumped(), values)
         end associate
         best = values%best(tip, problem%materials(tip%material_in(problem%materials))%isotropic)
         if (best%estimator /= '') g = best%rate
      end associate
   end subroutine measure_crack

   !> Find the opening and sliding one cell behind a tip.
   subroutine find_openings_behind(tip, problem, p, values)
      type(crack_tip_t), intent(in) :: tip
      type(problem_t), intent(in) :: problem
      type(particles_t), intent(in) :: p
      type(crack_values_t), intent(inout) :: values
      real(dp) :: at_node(modes)                 ! opening of the nodes behind the tip [m]
      associate (behind => tip%now - tip%nodes%spacing*tip%direction)
         if (tip%nodes%tip == 0 .or. tip%may_close) &
            values%behind = opening_at(tip, behind, -tip%direction, problem, p)
         if (tip%nodes%tip > 0) then
            at_node = opening_at(tip, tip%nodes%behind, problem, p)
            if (tip%may_close .and. values%behind(1) < 0) at_node(1) = values%behind(1)
            values%behind = at_node
         end if
      end associate
   end subroutine find_openings_behind

   !> When samples are taken of the values of a tip.
   pure type(pace_t) function pace_of(problem, tip, values) result(pace)
      type(problem_t), intent(in) :: problem
      type(crack_tip_t), intent(in) :: tip
      type(crack_values_t), intent(in) :: values
      pace%in_sets = values%in_sets
      pace%first = values%arrival%slot
      if (tip%grown > 0) pace%cells = 1          ! faces part behind it cell by cell
      if (values%moves) &
         pace%waves = waves_of(tip%nodes%spacing, problem%materials(tip%material_in(problem%materials))%shear_wave_speed())
   end function pace_of

   !> After a step, look whether a wave has arrived at a tip.
   pure subroutine look_at_tip(problem, tip, values)
      type(problem_t), intent(in) :: problem
      type(crack_tip_t), intent(in) :: tip
      type(crack_values_t), intent(inout) :: values
      real(dp), parameter :: ahead = 1.5_dp, beside = 0.237_dp ! cells, by which none is on its line, hardly one on an edge
      real(dp) :: places(ndim, corners)          ! beyond cells that it cuts, whose pieces may be all but empty [m]
      type(pace_t) :: pace
      integer :: k
      if (.not. (values%in_sets .and. tip%is_measured() .and. values%errors%are_known)) return
      pace = pace_of(problem, tip, values)
      if (.not. is_new_slot(values%arrival, problem%state%time, pace)) return
      do k = 1, corners
         places(:, k) = tip%now + tip%nodes%spacing*(ahead*tip%direction + beside*matmul(frame_along(tip%direction), &
                                                                                         2*corner_offset(k) - 1))
      end do
      call look_for_arrival(problem, places, pace, values%arrival)
   end subroutine look_at_tip

   !> Whether the errors of the next row need the present values of a tip.
   pure logical function needs_values(problem, tip, values, next_row, dt)
      type(problem_t), intent(in) :: problem
      type(crack_tip_t), intent(in) :: tip
      type(crack_values_t), intent(in) :: values
      real(dp), intent(in) :: next_row, dt       !! its time, and the step [s]
      type(pace_t) :: pace
      integer :: k
      needs_values = .false.
      if (.not. (tip%is_measured() .and. values%errors%are_known)) return
      pace = pace_of(problem, tip, values)
      if (allocated(values%j)) needs_values = needs_sample(values%errors%j%recent, problem%state%time, pace, next_row, dt)
      do k = 1, size(values%estimates)
         associate (of => values%estimates(k))
            if (.not. of%by%needs_mass) &
               needs_values = needs_values .or. any(needs_sample(of%error%recent, problem%state%time, pace, next_row, dt))
         end associate
      end do
      needs_values = needs_values .or. values%average%is_next(tip%grown, tip%nodes%spacing, &
                                                              tip%speed*(next_row - problem%state%time))
   end function needs_values

   !> Update the errors of the last measured values. Differences of J and K between domains are errors too.
   !>
   !> The error of a nodal force is its difference from J's part of its mode plus the error of that: where cells have been divided
   !> in motion, particles may have stresses that act on no node. Without J that error is unknown.
   !>
   !> At rest J of a tip in a cell is of the place where it acts, K of the place where it is: J is off by what both differ, give or
   !> take the error of K.
   pure subroutine follow_values(tip, field, wave, time, pace, agree, by_j, is_finite, is_lumped, values)
      type(crack_tip_t), intent(in) :: tip
      type(tip_field_t), intent(in) :: field     !! of the tip
      real(dp), intent(in) :: wave               !! speed of Rayleigh waves there [m/s]
      real(dp), intent(in) :: time               !! [s]
      type(pace_t), intent(in) :: pace
      logical, intent(in) :: agree               !! whether J and K of the field are to be of one G
      logical, intent(in) :: by_j                !! whether K has the size of J
      logical, intent(in) :: is_finite           !! whether J knows large strain, of which K knows nothing
      logical, intent(in) :: is_lumped           !! whether tips run through lumped masses, in explicit steps
      type(crack_values_t), intent(inout) :: values
      real(dp) :: j, spread_of_j, of_k(modes), part(modes), least(modes), apart(modes), late, kept, residual
      logical :: is_new
      integer :: n
      associate (v => values, errors => values%errors, scale => values%errors%with_cells(tip%nodes%spacing))
         if (allocated(v%j)) call know_swing(merge(v%average%swing(tip%nodes%spacing), 0.0_dp, tip%speed > 0), v)
         do n = 1, size(v%estimates)
            associate (of => v%estimates(n))
               call follow(of%error, merge(of%rate, sum(abs(of%rate)), errors%by_mode .or. of%by%needs_nodes), scale, &
                           of%uncertainty, time, merge(pace_t(in_sets=.true.), pace, of%by%needs_mass .and. pace%in_sets))
               if (of%by%needs_two_points .and. v%cells_divide .and. .not. allocated(v%j)) & ! nodal forces
                  of%error%now = ieee_value(0.0_dp, ieee_quiet_nan)
            end associate
         end do
         if (.not. allocated(v%j)) return
         j = sum(v%j)/size(v%j)
         spread_of_j = maxval(v%j) - minval(v%j) + v%uncertainty_of_j + tip%lost()*abs(j)
         apart = 0                               ! J and the interaction of a tip that grows, which sees where it is
         if (tip%grown > 0) apart = bounded_ratio(abs(v%by_fields - v%intensity), norm(v%intensity), 1.0_dp)
         is_new = is_sample(errors%j%recent, time, pace)
         call follow_speed(errors%seen, tip%speed, wave, tip%toughness, is_lumped, time, pace, is_new, late, kept)
         apart = kept*errors%apart + (1 - kept)*apart**2
         if (is_new) errors%apart = apart
         apart = sqrt(apart)
         if (tip%toughness > 0) then             ! by its law G is the toughness: speed, and K by that, are off
            residual = abs(j - tip%toughness)
         else                                    ! J is nearer than the interaction: half of what both differ by
            residual = norm(apart)*abs(j)
            apart = apart/2
         end if
         apart = norm(v%intensity)*apart
         call follow(errors%j, j, scale, max(spread_of_j, residual), time, pace)
         errors%j%now = errors%j%now + late*abs(j)
         part = 0
         if (sum(abs(v%domain)) > 0) part = abs(v%domain)/sum(abs(v%domain))
         if (errors%by_mode .and. .not. field%modes_couple()) then
            call follow(errors%domain, v%domain, scale, spread_of_j*part, time, pace)
            call follow(errors%intensity, v%intensity, scale, max(v%spread_of_k, apart), time, pace)
            errors%intensity%now = errors%intensity%now + late/2*abs(v%intensity)
         else                                    ! one mode turns into the other, too
            errors%domain%now = 0
            call follow(errors%intensity, norm(v%intensity), scale, max(maxval(v%spread_of_k), apart), time, pace)
            errors%intensity%now = errors%intensity%now + late/2*norm(v%intensity)
         end if
         if (by_j) errors%intensity%now = max(errors%intensity%now, &
                                              abs(field%of_rate(v%intensity, abs(j) + errors%j%now) - v%intensity))
         of_k = errors%intensity%now
         errors%of_rate = error_of_rate(field, v%intensity, of_k)
         associate (off => abs(v%g_of_k - j))
            if (agree) errors%j%now = max(spread_of_j, merge(0.0_dp, off, is_finite), min(errors%j%now, off + errors%of_rate))
         end associate
         errors%domain%now = max(errors%domain%now, part*errors%j%now &
                                  + error_of_shares(field, v%intensity, of_k)*sum(abs(v%domain)))
         do n = 1, size(v%estimates)
            if (.not. v%estimates(n)%by%differs_from_j) cycle
            associate (of => v%estimates(n))
               least = abs(abs(of%rate) - abs(v%domain)) + part*errors%j%now
               if (tip%has_layers) least = abs(sum(of%rate) - j)
               of%error%now = max(of%error%now, least)
            end associate
         end do
         call v%average%follow(tip%grown, tip%nodes%spacing, [best_rate(v, tip), errors%j%lasting + late*abs(j), &
                                                              errors%j%recent%scatter])
      end associate
   end subroutine follow_values

   !> Let errors of a tip that runs know what its values swing by as it crosses cells: a part of G, half of it of K.
   pure subroutine know_swing(part, values)
      real(dp), intent(in) :: part               !! [-]
      type(crack_values_t), intent(inout) :: values
      integer :: n
      associate (v => values, errors => values%errors)
         errors%j%recent%swing = part*sum(abs(v%j))/size(v%j)
         errors%domain%recent%swing = part*abs(v%domain)
         errors%intensity%recent%swing = part/2*norm(v%intensity)
         do n = 1, size(v%estimates)
            v%estimates(n)%error%recent%swing = part*abs(v%estimates(n)%rate)
         end do
      end associate
   end subroutine know_swing

   !> The largest change of the modes' shares of G by errors of K of any sign [-]: 1 if these are as large as K.
   pure real(dp) function error_of_shares(field, k, error) result(change)
      type(tip_field_t), intent(in) :: field
      real(dp), intent(in) :: k(modes), error(modes) !! [Pa sqrt(m)]
      real(dp) :: off(modes, 4)
      integer :: i
      change = 0
      if (norm(error) > 0) change = 1
      if (.not. norm(error) < norm(k)) return
      off = of_any_sign(error)
      change = maxval([(abs(field%shares(k + off(:, i)) - field%shares(k)), i = 1, 4)])
   end function error_of_shares

   !> Record the measured values. On a symmetry plane there is only mode I.
   subroutine record_crack(material, tip, values, may_grow, history)
      type(material_t), intent(in) :: material   !! at the tip
      type(crack_tip_t), intent(in) :: tip
      type(crack_values_t), intent(in) :: values
      logical, intent(in) :: may_grow            !! whether cracks of the run may grow
      type(history_t), intent(inout) :: history
      type(estimate_t) :: estimate
      type(best_t) :: best                       ! of both modes together, for a reader who wants one number
      integer :: recorded                        ! modes
      integer :: k
      recorded = merge(1, modes, tip%is_half())
      history%is_of_none = .not. tip%is_measured()
      associate (v => values)
         do k = 1, size(v%estimates)
            estimate = v%estimates(k)
            if (v%has_left_node .and. estimate%by%needs_nodes) then
               estimate%rate = ieee_value(0.0_dp, ieee_quiet_nan)
               estimate%error%now = estimate%rate
            end if
            associate (name => 'G_'//trim(estimate%by%name))
               call record_modes(name//'_', 'J/m2', trim(estimate%by%meaning), estimate%rate, 'estimated error of '//name, &
                                 estimate%error)
            end associate
         end do
         if (allocated(v%j)) then        ! J depends on the domain if material yields or creeps, and K are of elastic fields
            history%is_of_none = history%is_of_none .or. material%has_history .or. tip%has_layers .and. .not. tip%phase_length > 0
            if (v%recorded%parts) then
               call record_parts()
            else if (v%recorded%intensities) then
               call record_intensities()
            end if
            history%is_of_none = .not. tip%is_measured()
            call history%record('J', 'J/m2', 'J integral, mean over the domains', sum(v%j)/size(v%j))
            if (v%errors%are_known) call history%record('J_error', 'J/m2', 'estimated error of J', v%errors%j%now)
            call history%record('J_domain_dependence', 'J/m2', 'largest less smallest J of the domains', maxval(v%j) - minval(v%j))
            if (v%recorded%near_and_far) then
               call history%record('J_near_tip', 'J/m2', 'J integral of the smallest domain', v%j(1))
               call history%record('J_far_field', 'J/m2', 'J integral of the largest domain', v%j(size(v%j)))
            end if
            call history%record_radii('J_', 'J/m2', 'J integral', tip%radii, v%j, may_change=may_grow)
         end if
         best = v%best(tip, material%isotropic)
         history%is_of_none = history%is_of_none .or. material%has_history
         if (best%estimator /= '' .and. .not. v%recorded%near_and_far) then
            call history%record('G', 'J/m2', 'energy release rate, both modes, by the best of the chosen estimators: '// &
                                best%estimator, best%rate)
            if (v%errors%are_known) call history%record('G_error', 'J/m2', 'estimated error of G', best%error)
            if (v%errors%are_known .and. v%moves .and. may_grow .and. allocated(v%j)) &
               call v%average%record(history)
         end if
         history%is_of_none = .not. tip%is_measured()
         call history%record('crack_opening', 'm', 'opening one cell behind the tip', v%behind(1))
         if (recorded > 1) call history%record('crack_sliding', 'm', 'sliding one cell behind the tip', v%behind(2))
         history%is_of_none = .false.
         call history%record('mouth_opening', 'm', &
                             'opening at the mouth; with two tips half way, or of a line at a root node next to there', v%mouth(1))
         if (recorded > 1) call history%record('mouth_sliding', 'm', 'sliding there', v%mouth(2))
         history%is_of_none = .not. tip%is_measured()
         call history%record('tip_cell', 'm', 'size of the cells at the tip', tip%nodes%spacing)
         history%is_of_none = .false.
      end associate

   contains

      !> Record the parts of J by modes and the stress intensity factors.
      subroutine record_parts()
         associate (v => values)
            call record_modes('G_domain_', 'J/m2', 'energy release rate, part of J', v%domain, &
                              'estimated error of G_domain', v%errors%domain)
            call record_intensities()
            if (allocated(v%t_stress)) then
               call history%record('T_stress', 'Pa', 'stress along the crack at its tip beside the singular ones', &
                                   sum(v%t_stress)/size(v%t_stress))
               if (v%errors%are_known) call history%record('T_stress_error', 'Pa', 'estimated error of T_stress', &
                                                           v%error_of_t_stress(tip%radii))
            end if
         end associate
      end subroutine record_parts

      !> Record the stress intensity factors.
      subroutine record_intensities()
         associate (v => values)
            call record_modes('K_', 'Pa m^0.5', 'stress intensity factor, interaction integral', v%intensity, &
                              'estimated error of K', v%errors%intensity)
            if (recorded > 1) &
               call history%record('mode_mixity', 'rad', 'angle of (K_I, K_II)', atan2(v%intensity(2), v%intensity(1)))
            if (values%recorded%phase) &
               call history%record('oscillation_index', '1', 'epsilon of the interface at the tip', v%oscillation)
         end associate
      end subroutine record_intensities

      !> Record the value of each mode, and then the estimated error of each.
      subroutine record_modes(name, unit, meaning, value, meaning_of_error, error)
         character(*), intent(in) :: name, unit, meaning, meaning_of_error
         real(dp), intent(in) :: value(modes)    !! in this unit
         type(error_t), intent(in) :: error(modes)
         call history%record_modes(name, unit, meaning, value(:recorded))
         if (values%errors%are_known) call history%record_modes(name, unit, meaning_of_error, [error(:recorded)%now], '_error')
      end subroutine record_modes
   end subroutine record_crack
end module hampm_crack_measurements
