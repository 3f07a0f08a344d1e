!> What the history records of a crack: what is measured there, and the list of its columns.
module hampm_crack_measurements
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use hampm_kinds, only: dp, ndim
   use hampm_closed_faces, only: closed_faces_t, look_behind_tip
   use hampm_crack_closure, only: crack_opening, path_opening, stress_closure, nodal_force_closure
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes, effective_modulus
   use hampm_cracks, only: cracks_t, first_point
   use hampm_cut_cells, only: side_of_ties
   use hampm_domain_integral, only: tip_domain_t, domain_integrals, shares_of_modes
   use hampm_estimated_errors, only: error_t, estimated_errors_t, relative_errors, follow, hardly
   use hampm_expected_error, only: crack_at_rest_t, find_crack_at_rest, missing_energy, displace, error_by_lengths, &
                                   place_of_tip, tip_zone, tips_at_rest_t, find_tips_at_rest
   use hampm_failure, only: failure_t
   use hampm_history, only: history_t
   use hampm_loads, only: place_loads, force_at_node, factors_at, largest_factors
   use hampm_mass_solver, only: mass_solver_t
   use hampm_material, only: material_t
   use hampm_motion, only: motion_t, refresh_grid
   use hampm_moving_tip, only: energy_factors
   use hampm_nodal_state, only: nodal_state_t
   use hampm_particles, only: particles_t
   use hampm_quadratic_setback, only: setback_of_quadratic
   use hampm_path_closure, only: path_closure
   use hampm_scene, only: scene_t
   use hampm_tip_field, only: tip_field_t, new_tip_field
   implicit none
   private
   public :: crack_values_t, new_crack_values, estimate_errors, measure_crack, record_crack, best_rate

   !> Estimated error of the stress closure over its value, where nothing better is known: it is a third to a half of G.
   real(dp), parameter :: of_stress_closure = 2

   !> What was measured last; that of estimators that are not chosen is 0.
   type :: crack_values_t
      real(dp) :: nodal_force(modes) = 0         !! energy release rates, nodal force closure [J/m2]
      real(dp) :: stress_closure(modes) = 0      !! the same, stress closure [J/m2]
      logical :: has_left_node = .false.         !! whether the material has carried the tip from the node that these need: they are no numbers then
      real(dp) :: crack_closure(modes) = 0       !! the same, closure along any direction [J/m2]
      real(dp) :: spread_of_closure(modes) = 0   !! by what tractions and openings differ there [J/m2]
      real(dp) :: domain(modes) = 0              !! the same, the parts of J [J/m2]
      real(dp) :: intensity(modes) = 0           !! stress intensity factors [Pa sqrt(m)]
      real(dp) :: g_of_k = 0                     !! energy release rate that goes with these [J/m2]
      real(dp) :: spread_of_k(modes) = 0         !! largest less smallest of the domains; of closed tips with all that is in doubt [Pa sqrt(m)]
      real(dp) :: doubt_of_j = 0                 !! by what K and J differ at a closed tip [J/m2]
      real(dp), allocatable :: j(:)              !! J integral of each domain, by the radii of the tip [J/m2]
      real(dp) :: behind(modes) = 0              !! opening and sliding one cell behind the tip [m]
      real(dp) :: mouth(modes) = 0               !! the same at the mouth [m]
      type(estimated_errors_t) :: errors         !! of all these
   end type crack_values_t

   !> G by the best of the chosen estimators.
   type :: best_t
      character(:), allocatable :: estimator     !! '' where none is chosen
      real(dp) :: rate = 0                       !! [J/m2]
      real(dp) :: error = 0                      !! estimated [J/m2]
   end type best_t

contains

   !> Nothing measured yet.
   subroutine new_crack_values(scene, tip, values)
      type(scene_t), intent(in) :: scene
      type(crack_tip_t), intent(in) :: tip
      type(crack_values_t), intent(out) :: values
      if (.not. scene%energy_release%domain_integral) return
      allocate (values%j(size(tip%radii)), source=0.0_dp)
   end subroutine new_crack_values

   !> Measure, and find the energy release rate of both modes together, by the best of the chosen estimators [J/m2]; not allocated where none
   !> is chosen. Fails where the nodal equations cannot be solved.
   subroutine measure_crack(scene, motion, cracks, number, state, extrapolation, values, g, failure)
      type(scene_t), intent(in) :: scene
      type(motion_t), intent(inout) :: motion
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the tip
      type(nodal_state_t), intent(in) :: state   !! where there is a domain integral
      type(mass_solver_t), intent(inout) :: extrapolation !! solver without fixed components
      type(crack_values_t), intent(inout) :: values
      real(dp), allocatable, intent(out) :: g
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: middle(ndim) = 0    ! cells on both sides of the mouth tell
      real(dp) :: at_node(modes)                 ! opening of the nodes behind the tip [m]
      type(best_t) :: best
      type(tip_field_t) :: field
      associate (p => motion%particles, grid => motion%grid, chosen => scene%energy_release, tip => cracks%tips(number))
         if (chosen%stress_closure) call refresh_grid(motion)
         call estimate_rates(scene, motion, factors_at(motion%loads, motion%time), tip, p, state, extrapolation, values, failure)
         associate (behind => tip%now - tip%nodes%spacing*tip%direction, &
                    mouth => grid%cut_cells%follow(cracks%crack(tip%crack)%mouth))
            if (tip%nodes%tip == 0 .or. tip%may_close) &
               values%behind = path_opening(tip, behind, -tip%direction, motion%matter_t, motion%interfaces)
            if (tip%nodes%tip > 0) then
               at_node = crack_opening(tip, tip%nodes%behind, grid, p, motion%blocks)
               if (tip%may_close .and. values%behind(1) < 0) at_node(1) = values%behind(1)
               values%behind = at_node
            end if
            values%mouth = path_opening(tip, mouth, middle, motion%matter_t, motion%interfaces)
         end associate
         field = new_tip_field(motion%materials(tip%material), tip%direction)
         call follow_values(scene, tip, field, values)
         call find_best(scene, tip, values, best)
         if (best%estimator /= '') g = best%rate
      end associate
   end subroutine measure_crack

   !> The chosen energy release rates and stress intensity factors, of some particles that stand where those of the motion do.
   subroutine estimate_rates(scene, motion, factors, tip, p, state, extrapolation, values, failure)
      type(scene_t), intent(in) :: scene
      type(motion_t), intent(inout) :: motion
      real(dp), intent(in) :: factors(:)         !! of the loads [-]
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(nodal_state_t), intent(in) :: state   !! of these particles, where there is a domain integral
      type(mass_solver_t), intent(inout) :: extrapolation
      type(crack_values_t), intent(inout) :: values
      type(failure_t), intent(inout) :: failure
      associate (grid => motion%grid, chosen => scene%energy_release)
         call place_loads(motion%loads, grid, p)
         values%has_left_node = tip%nodes%tip == 0 .and. chosen%is_by_nodes()
         if (chosen%nodal_force .and. .not. values%has_left_node) then
            values%nodal_force = nodal_force_closure(tip, grid, p, motion%blocks, motion%materials, &
                                                     scene%run%thickness%at(tip%now), &
                                                     tractions_at([tip%nodes%tip, tip%nodes%tip]), &
                                                     tractions_at(tip%nodes%half_behind))
         end if
         if (chosen%stress_closure .and. .not. values%has_left_node) &
            call stress_closure(tip, grid, p, motion%materials, motion%fields%mass_matrix, extrapolation, &
                                values%stress_closure, failure)
         if (chosen%domain_integral) call measure_domain(scene, motion, factors, tip, p, state, values)
         if (chosen%crack_closure) call path_closure(tip, p, motion%materials, values%crack_closure, &
                                                       values%spread_of_closure, failure)
      end associate

   contains

      !> Force on nodes of the upper and the lower face from the tractions on it [N].
      function tractions_at(nodes) result(force)
         integer, intent(in) :: nodes(2)         !! 0: none
         real(dp) :: force(ndim, 2)
         integer :: k
         force = 0
         do k = 1, 2
            if (nodes(k) > 0) force(:, k) = force_at_node(motion%loads, factors, motion%grid, p, nodes(k), (3 - 2*k)*tip%axis(:, 2))
         end do
      end function tractions_at
   end subroutine estimate_rates

   !> Before the first step: estimate by which part of their values the chosen estimators are off at each tip, from what they find at rest. Where
   !> material remembers, nothing is known of that.
   subroutine estimate_errors(scene, motion, cracks, extrapolation, values, failure)
      type(scene_t), intent(in) :: scene
      type(motion_t), intent(inout) :: motion
      type(cracks_t), intent(in) :: cracks
      type(mass_solver_t), intent(inout) :: extrapolation
      type(crack_values_t), intent(inout) :: values(:) !! by tip
      type(failure_t), intent(inout) :: failure
      type(tips_at_rest_t) :: at_rest
      logical :: at_nodes
      integer :: k
      if (.not. scene%energy_release%needs_crack() .or. size(values) == 0) return
      if (any(motion%materials(motion%particles%material(:motion%particles%n))%has_history())) return
      associate (tips => cracks%tips(:size(values)))
         at_nodes = all(tips%nodes%tip > 0)
         if (.not. at_nodes) call find_tips_at_rest(motion, tips, at_rest)
         do k = 1, size(values)
            values(k)%errors%cell = tips(k)%nodes%spacing
            values(k)%errors%are_known = .true.
            if (at_nodes) then
               call estimate_at_node(scene, motion, cracks, k, extrapolation, values(k), failure)
            else if (at_rest%known) then
               call estimate_by_shifts(scene, motion, tips, k, at_rest, values(k)%errors)
            else
               call estimate_by_lengths(motion, cracks, k, values(k)%errors)
            end if
         end do
      end associate
   end subroutine estimate_errors

   !> Estimate where nothing is known but lengths.
   subroutine estimate_by_lengths(motion, cracks, number, errors)
      type(motion_t), intent(in) :: motion
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the tip
      type(estimated_errors_t), intent(inout) :: errors
      errors%nodal_force%relative = error_by_lengths(motion, cracks%tips(number), other_end(cracks, cracks%tips(number)))
      errors%domain = errors%nodal_force
      errors%crack_closure = errors%nodal_force
      errors%j = errors%domain(1)
      errors%intensity%relative = errors%domain%relative/2
      errors%stress_closure%relative = of_stress_closure
   end subroutine estimate_by_lengths

   !> Estimate for a tip at a node, by closing the crack behind it.
   subroutine estimate_at_node(scene, motion, cracks, number, extrapolation, values, failure)
      type(scene_t), intent(in) :: scene
      type(motion_t), intent(inout) :: motion
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the tip
      type(mass_solver_t), intent(inout) :: extrapolation
      type(crack_values_t), intent(inout) :: values
      type(failure_t), intent(inout) :: failure
      type(crack_at_rest_t) :: crack
      type(crack_values_t) :: found
      type(particles_t) :: p
      type(tip_field_t) :: field                 ! an associate name of what a function returns would free its law twice in gfortran 12
      associate (tip => cracks%tips(number), errors => values%errors, chosen => scene%energy_release)
         call find_crack_at_rest(motion, cracks%tips, number, scene%run%thickness%at(tip%now), crack)
         if (.not. crack%known) then
            call estimate_by_lengths(motion, cracks, number, errors)
            return
         end if
         call displace(motion, crack%u, p)
         if (chosen%stress_closure) call refresh_grid(motion)
         call new_crack_values(scene, tip, found)
         call estimate_rates(scene, motion, crack%scale*largest_factors(motion%loads), tip, p, &
                             resting(motion, crack%acceleration), extrapolation, found, failure)
         if (failure%failed()) return
         errors%by_mode = .true.
         errors%of_tip = crack%part_of_tip()
         field = new_tip_field(motion%materials(tip%material), tip%direction)
         associate (best => crack%best(), doubt => crack%doubt(), own => motion%grid%is_quadratic())
            errors%nodal_force%relative = relative_errors(found%nodal_force, best, doubt, own, hardly**2)
            errors%stress_closure%relative = relative_errors(found%stress_closure, best, doubt, own, hardly**2)
            errors%crack_closure%relative = relative_errors(found%crack_closure, best, doubt, own, hardly**2)
            errors%domain%relative = relative_errors(found%domain, best, doubt, own, hardly**2)
            ! In material whose modes turn into each other both have the relative error of either, unless one of them is small
            errors%intensity%relative = relative_errors(found%intensity, field%typical_intensities(best), doubt/2, own, &
                                                        merge(hardly, 10*hardly, motion%materials(tip%material)%isotropic))
            if (.not. motion%materials(tip%material)%isotropic) errors%intensity%relative = maxval(errors%intensity%relative)
            if (chosen%domain_integral) errors%j%relative = maxval(relative_errors([sum(found%j)/size(found%j)], [sum(best)], &
                                                                                [sum(doubt*best)/sum(best)], own, hardly**2))
         end associate
      end associate
   end subroutine estimate_at_node

   !> Estimate for a tip of a path: it acts somewhere near its place, so that J is that of a crack that is longer or shorter, and K what the
   !> fields of the true place find around it; other tips near it are astray too. To this comes what the other cells lack.
   !>
   !> What K changes by as the tip acts at d ahead of where it is sought is d dK/da, less what it changes by as it is sought at d.
   subroutine estimate_by_shifts(scene, motion, tips, number, at_rest, errors)
      type(scene_t), intent(in) :: scene
      type(motion_t), intent(in) :: motion
      type(crack_tip_t), intent(in) :: tips(:)
      integer, intent(in) :: number              !! of the tip
      type(tips_at_rest_t), intent(in) :: at_rest
      type(estimated_errors_t), intent(inout) :: errors
      real(dp), parameter :: no_shift(ndim) = 0
      integer, parameter :: most_others = 4      ! that are counted: what others change falls with the square of their distance
      real(dp) :: k(modes), k_there(modes), k_here(modes), j, j_there, j_here, of_k(modes), of_j, by_cells
      real(dp) :: off_of_j(modes), off_of_k(modes)
      real(dp) :: places(ndim, size(tips)), distance
      integer :: t, d
      of_k = 0
      of_j = 0
      associate (h => tips(number)%nodes%spacing)
         call find(0.0_dp*at_rest%moved(:, :, 1), no_shift, k, j)
         do t = 1, size(tips)
            distance = norm2(tips(t)%place - tips(number)%place)
            if (count([(norm2(tips(d)%place - tips(number)%place) < distance, d=1, size(tips))]) > most_others) cycle
            call place_of_tip(motion, tips(t), off_of_j, off_of_k)
            call find(h*at_rest%moved(:, :, t), no_shift, k_there, j_there)
            call find(-h*at_rest%moved(:, :, t), no_shift, k_here, j_here)
            of_j = of_j + maxval(off_of_j)*abs(j_there - j_here)/2
            k_there = k_there - k_here
            if (t == number .and. tips(t)%nodes%in_cell) then
               call find(0.0_dp*at_rest%moved(:, :, 1), h/2*tips(t)%direction, k_here, j_here)
               k_there = k_there - 2*k_here
               call find(0.0_dp*at_rest%moved(:, :, 1), -h/2*tips(t)%direction, k_here, j_here)
               k_there = k_there + 2*k_here
            end if
            of_k = of_k + off_of_k*abs(k_there)/2
         end do
         do d = 1, size(tips)
            places(:, d) = tips(d)%place
         end do
         associate (moved => at_rest%moved(:, :, number))
            by_cells = abs(missing_energy(motion, places, tip_zone*h, at_rest%u + h*moved) &
                           - missing_energy(motion, places, tip_zone*h, at_rest%u - h*moved)) &
                       /(2*h*scene%run%thickness%at(tips(number)%now))
            if (tips(number)%is_half()) by_cells = 2*by_cells
         end associate
      end associate
      if (.not. (abs(j) > 0 .and. norm2(k) > 0)) return
      errors%of_tip = of_j/(of_j + by_cells + tiny(1.0_dp))
      errors%j%relative = (of_j + by_cells)/abs(j)
      errors%crack_closure = errors%j
      errors%intensity%relative = maxval(of_k)/norm2(k) + by_cells/(2*abs(j))

   contains

      !> K and J of a displacement beside that at rest, with the tip sought at a place beside its own.
      subroutine find(u, shift, k, j)
         real(dp), intent(in) :: u(:, :)         !! [m], (ndim, n_points)
         real(dp), intent(in) :: shift(ndim)     !! [m]
         real(dp), intent(out) :: k(modes)       !! [Pa sqrt(m)]
         real(dp), intent(out) :: j              !! [J/m2]
         type(crack_tip_t) :: tip
         type(crack_values_t) :: found
         type(particles_t) :: p
         tip = tips(number)
         tip%may_close = .false.
         tip%radii = [max(min(minval(tip%radii), maxval(tip%radii)/2), min(2*tip%nodes%spacing, maxval(tip%radii)))]
         call displace(motion, at_rest%u + u, p)
         allocate (found%j(1))
         call measure_domain(scene, motion, at_rest%scale*largest_factors(motion%loads), tip, p, &
                             resting(motion, at_rest%acceleration), found, shift)
         k = found%intensity
         j = found%j(1)
      end subroutine find
   end subroutine estimate_by_shifts

   !> The nodes of a motion that rests but for its motion as a whole, without weight.
   pure type(nodal_state_t) function resting(motion, acceleration) result(state)
      type(motion_t), intent(in) :: motion
      real(dp), intent(in) :: acceleration(:, :) !! [m/s2], (ndim, n_points)
      allocate (state%velocity(ndim, motion%grid%n_points), source=0.0_dp)
      allocate (state%divergence, source=acceleration)
   end function resting

   !> The other end of the crack of a tip, or its mouth [m].
   pure function other_end(cracks, tip) result(x)
      type(cracks_t), intent(in) :: cracks
      type(crack_tip_t), intent(in) :: tip
      real(dp) :: x(ndim)
      associate (crack => cracks%crack(tip%crack))
         x = crack%mouth
         if (.not. tip%is_half()) x = crack%points(:, merge(size(crack%points, 2), 1, tip%end == first_point))
      end associate
   end function other_end

   !> Follow the values that were measured last with their errors. What J and K differ by from domain to domain is an error too.
   !>
   !> The nodal force is off by what it differs by from the part of J of its mode, and by what that part is off: where cells have been divided in
   !> motion, particles may have stresses that no node feels. Without J nothing is known of that.
   pure subroutine follow_values(scene, tip, field, values)
      type(scene_t), intent(in) :: scene
      type(crack_tip_t), intent(in) :: tip
      type(tip_field_t), intent(in) :: field     !! of the tip
      type(crack_values_t), intent(inout) :: values
      real(dp) :: j, spread_of_j, of_k(modes), part(modes), least(modes)
      associate (v => values, errors => values%errors, scale => values%errors%with_cells(tip%nodes%spacing))
         call follow(errors%stress_closure, v%stress_closure, scale, 0.0_dp)
         call follow(errors%crack_closure, merge(v%crack_closure, sum(abs(v%crack_closure)), errors%by_mode), scale, &
                     v%spread_of_closure)
         if (.not. scene%energy_release%domain_integral) then
            call follow(errors%nodal_force, v%nodal_force, scale, 0.0_dp)
            if (any(scene%refine%indicator == ['gradient', 'zz      ']) .and. scene%method%time /= 'static') &
               errors%nodal_force%now = ieee_value(0.0_dp, ieee_quiet_nan)
            return
         end if
         j = sum(v%j)/size(v%j)
         spread_of_j = maxval(v%j) - minval(v%j) + v%doubt_of_j
         call follow(errors%j, j, scale, spread_of_j)
         part = 0
         if (sum(abs(v%domain)) > 0) part = abs(v%domain)/sum(abs(v%domain))
         if (errors%by_mode .and. .not. field%modes_couple()) then
            call follow(errors%domain, v%domain, scale, spread_of_j*part)
            call follow(errors%intensity, v%intensity, scale, v%spread_of_k)
         else                                    ! one mode turns into the other, too
            errors%domain%now = 0
            call follow(errors%intensity, norm2(v%intensity), scale, maxval(v%spread_of_k))
         end if
         of_k = errors%intensity%now
         errors%of_rate = error_of_rate(field, v%intensity, of_k)
         errors%domain%now = max(errors%domain%now, part*errors%j%now &
                                  + error_of_shares(field, v%intensity, of_k)*sum(abs(v%domain)))
         least = abs(abs(v%nodal_force) - abs(v%domain)) + part*errors%j%now
         if (tip%has_layers) least = abs(sum(v%nodal_force) - j)
         call follow(errors%nodal_force, v%nodal_force, scale, least)
      end associate
   end subroutine follow_values

   !> The largest change of G by errors of K of any sign [J/m2].
   pure real(dp) function error_of_rate(field, k, error)
      type(tip_field_t), intent(in) :: field
      real(dp), intent(in) :: k(modes), error(modes) !! [Pa sqrt(m)]
      real(dp) :: off(modes, 4)
      integer :: i
      off = of_any_sign(error)
      error_of_rate = maxval([(abs(field%rate_of(k + off(:, i)) - field%rate_of(k)), i = 1, 4)])
   end function error_of_rate

   !> The largest change of what each mode has of G by errors of K of any sign [-]: 1 where these are as large as K.
   pure real(dp) function error_of_shares(field, k, error) result(change)
      type(tip_field_t), intent(in) :: field
      real(dp), intent(in) :: k(modes), error(modes) !! [Pa sqrt(m)]
      real(dp) :: off(modes, 4)
      integer :: i
      change = 0
      if (norm2(error) > 0) change = 1
      if (.not. norm2(error) < norm2(k)) return
      off = of_any_sign(error)
      change = maxval([(abs(field%shares(k + off(:, i)) - field%shares(k)), i = 1, 4)])
   end function error_of_shares

   !> Errors of K with each sign.
   pure function of_any_sign(error) result(off)
      real(dp), intent(in) :: error(modes)       !! [Pa sqrt(m)]
      real(dp) :: off(modes, 4)
      off = reshape([error, -error, error(1), -error(2), -error(1), error(2)], [modes, 4])
   end function of_any_sign

   !> Record what was measured. On a symmetry plane there is only mode I.
   subroutine record_crack(scene, material, tip, values, history)
      type(scene_t), intent(in) :: scene
      type(material_t), intent(in) :: material   !! at the tip
      type(crack_tip_t), intent(in) :: tip
      type(crack_values_t), intent(in) :: values
      type(history_t), intent(inout) :: history
      type(crack_values_t) :: v
      integer :: recorded                        ! modes
      recorded = merge(1, modes, tip%is_half())
      v = values
      if (v%has_left_node) then
         v%nodal_force = ieee_value(0.0_dp, ieee_quiet_nan)
         v%stress_closure = v%nodal_force
         v%errors%nodal_force%now = v%nodal_force
         v%errors%stress_closure%now = v%nodal_force
      end if
      associate (chosen => scene%energy_release)
         if (chosen%nodal_force) &
            call record_modes('G_nodal_force_', 'J/m2', 'energy release rate, nodal force closure', v%nodal_force, &
                              'estimated error of G_nodal_force', v%errors%nodal_force)
         if (chosen%stress_closure) &
            call record_modes('G_stress_closure_', 'J/m2', 'energy release rate, stress closure', v%stress_closure, &
                              'estimated error of G_stress_closure', v%errors%stress_closure)
         if (chosen%crack_closure) &
            call record_modes('G_crack_closure_', 'J/m2', 'energy release rate, crack closure along any direction', &
                              v%crack_closure, 'estimated error of G_crack_closure', v%errors%crack_closure)
         if (chosen%domain_integral) then        ! where material yields or creeps J depends on the domain, and K are of elastic fields
            if (.not. (tip%has_layers .or. material%has_history())) call record_parts()
            call history%record('J', 'J/m2', 'J integral, mean over the domains', sum(v%j)/size(v%j))
            if (v%errors%are_known) call history%record('J_error', 'J/m2', 'estimated error of J', v%errors%j%now)
            call history%record('J_spread', 'J/m2', 'largest less smallest J of the domains', maxval(v%j) - minval(v%j))
            if (material%has_history()) then
               call history%record('J_near_tip', 'J/m2', 'J integral of the smallest domain', v%j(1))
               call history%record('J_far_field', 'J/m2', 'J integral of the largest domain', v%j(size(v%j)))
            end if
            call history%record_radii('J_', 'J/m2', 'J integral', tip%radii, v%j, may_change=size(scene%growth) > 0)
         end if
         if (.not. material%has_history()) call record_best(scene, tip, v, history)
         call history%record('crack_opening', 'm', 'opening one cell behind the tip', v%behind(1))
         if (recorded > 1) call history%record('crack_sliding', 'm', 'sliding one cell behind the tip', v%behind(2))
         call history%record('mouth_opening', 'm', &
                             'opening at the mouth; with two tips half way, or of a line at a root node next to there', v%mouth(1))
         if (recorded > 1) call history%record('mouth_sliding', 'm', 'sliding there', v%mouth(2))
         call history%record('tip_cell', 'm', 'size of the cells at the tip', tip%nodes%spacing)
      end associate

   contains

      !> Record the parts of J by modes and the stress intensity factors.
      subroutine record_parts()
         associate (v => values)
            call record_modes('G_domain_', 'J/m2', 'energy release rate, part of J', v%domain, &
                              'estimated error of G_domain', v%errors%domain)
            call record_modes('K_', 'Pa m^0.5', 'stress intensity factor, interaction integral', v%intensity, &
                              'estimated error of K', v%errors%intensity)
            if (recorded > 1) &
               call history%record('mode_mixity', 'rad', 'angle of (K_I, K_II)', atan2(v%intensity(2), v%intensity(1)))
         end associate
      end subroutine record_parts

      !> Record the value of each mode, and then the estimated error of each.
      subroutine record_modes(name, unit, meaning, value, meaning_of_error, error)
         character(*), intent(in) :: name, unit, meaning, meaning_of_error
         real(dp), intent(in) :: value(modes)    !! in this unit
         type(error_t), intent(in) :: error(modes)
         call history%record_modes(name, unit, meaning, value(:recorded))
         call history%record_modes(name, unit, meaning_of_error, [error(:recorded)%now], '_error')
      end subroutine record_modes
   end subroutine record_crack

   !> Record G of both modes together by the best of the chosen estimators, for a reader who wants one number.
   subroutine record_best(scene, tip, v, history)
      type(scene_t), intent(in) :: scene
      type(crack_tip_t), intent(in) :: tip
      type(crack_values_t), intent(in) :: v
      type(history_t), intent(inout) :: history
      type(best_t) :: best
      call find_best(scene, tip, v, best)
      if (best%estimator == '') return
      call history%record('G', 'J/m2', 'energy release rate, both modes, by the best of the chosen estimators: '//best%estimator, &
                          best%rate)
      if (v%errors%are_known) call history%record('G_error', 'J/m2', 'estimated error of G', best%error)
   end subroutine record_best

   !> G of both modes together by the estimator that is nearest to the truth of those that are chosen: at a tip inside a cell K is less off than J.
   pure subroutine find_best(scene, tip, v, best)
      type(scene_t), intent(in) :: scene
      type(crack_tip_t), intent(in) :: tip
      type(crack_values_t), intent(in) :: v
      type(best_t), intent(out) :: best
      associate (chosen => scene%energy_release, errors => v%errors)
         if (chosen%domain_integral .and. tip%nodes%in_cell .and. .not. tip%grown > 0) then
            best = best_t('domain_integral, (K_I**2 + K_II**2)/E''', v%g_of_k, errors%of_rate)
            if (any(scene%materials%law == 'orthotropic')) best%estimator = 'domain_integral, of K_I and K_II'
         else if (chosen%domain_integral) then
            best = best_t('domain_integral', sum(v%j)/size(v%j), errors%j%now)
         else if (chosen%nodal_force) then
            best = best_t('nodal_force', merge(sum(v%nodal_force), total(v%nodal_force), tip%has_layers), &
                          sum(errors%nodal_force%now))
         else if (chosen%crack_closure) then
            best = best_t('crack_closure', total(v%crack_closure), sum(errors%crack_closure%now))
         else if (chosen%stress_closure) then
            best = best_t('stress_closure', total(v%stress_closure), sum(errors%stress_closure%now))
         else
            best%estimator = ''
         end if
      end associate
   end subroutine find_best

   !> Energy release rate of both modes together by the domain integral: by K at a tip inside a cell, where that is less off than J, else
   !> J [J/m2].
   pure real(dp) function best_rate(v, tip)
      type(crack_values_t), intent(in) :: v
      type(crack_tip_t), intent(in) :: tip
      best_rate = sum(v%j)/size(v%j)
      if (tip%nodes%in_cell .and. .not. tip%grown > 0) best_rate = v%g_of_k
   end function best_rate

   !> Energy release rate of both modes together [J/m2]: the sign of mode II tells only which way the faces slide.
   pure real(dp) function total(g)
      real(dp), intent(in) :: g(modes)           !! [J/m2]
      total = g(1) + abs(g(2))
   end function total

   !> Measure what the domain integrals give: J of each domain, and means over them.
   !>
   !> How far behind its node a tip acts depends on the anisotropy of the material: there K has the ratio of modes by the
   !> interaction integrals, and its size by J, which sees no origin.
   subroutine measure_domain(scene, motion, factors, tip, p, state, values, shift)
      type(scene_t), intent(in) :: scene
      type(motion_t), intent(in) :: motion
      real(dp), intent(in) :: factors(:)         !! of the loads [-]
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(nodal_state_t), intent(in) :: state
      type(crack_values_t), intent(inout) :: values
      real(dp), intent(in), optional :: shift(ndim) !! from the tip to where it is sought [m]
      type(tip_domain_t) :: domain
      type(tip_field_t) :: field
      type(closed_faces_t) :: closed
      real(dp) :: k(modes, size(values%j)), k_doubt(modes, size(values%j))
      integer :: i
      domain%tip = tip%now
      if (present(shift)) domain%tip = domain%tip + shift
      if (present(shift)) domain%is_beside = any(abs(shift) > 0)
      domain%direction = tip%axis(:, 1)
      domain%cell = merge(0.0_dp, tip%nodes%spacing, tip%nodes%in_cell .or. tip%grown > 0)
      domain%quadratic = motion%grid%is_quadratic()
      domain%setback = setback_of_quadratic(motion, tip)
      domain%face_of_line = side_of_ties(tip%direction)
      domain%half = tip%is_half()
      domain%has_zone = tip%has_zone
      domain%thickness = scene%run%thickness%at(tip%now)
      domain%is_ring = scene%run%thickness%is_ring
      domain%material = motion%materials(tip%material)
      domain%radius = tip%radii
      ! A pressure on such faces is a load for each direction along the axes
      domain%pressure = sum(factors*motion%loads%pressure, mask=motion%loads%line == tip%crack)/(2*ndim)
      if (tip%may_close) closed = look_behind_tip(motion%interfaces, tip%now, tip%direction, tip%nodes%spacing)
      call domain_integrals(domain, motion, factors, p, state, closed, values%j, k, k_doubt)
      field = new_tip_field(domain%material, domain%direction)
      if (domain%cell > 0 .and. .not. domain%material%isotropic) then
         do i = 1, size(values%j)
            k(:, i) = field%of_rate(k(:, i), values%j(i))
         end do
      end if
      if (tip%may_close) then                    ! what the pressure there leaves of K_I is an error
         k(1, :) = max(k(1, :), 0.0_dp)
         if (closed%are_closed) k(1, :) = 0
      end if
      values%spread_of_k = maxval(k, dim=2) - minval(k, dim=2) + sum(k_doubt, dim=2)/size(values%j)
      values%intensity = sum(k, dim=2)/size(values%j)
      if (closed%are_closed) values%spread_of_k = [0.0_dp, values%spread_of_k(2) + abs(values%intensity(2)) &
               *values%errors%with_cells(tip%nodes%spacing)*values%errors%intensity(2)%relative] ! tractions and the place of the tip err apart
      values%g_of_k = field%rate_of(values%intensity)
      if (domain%material%has_history()) values%g_of_k = sum(values%j)/size(values%j) ! K is of elastic fields
      values%doubt_of_j = 0
      if (closed%are_closed) values%doubt_of_j = hypot(sum(values%j)/size(values%j) - values%g_of_k, &
                                                       error_of_rate(field, values%intensity, values%spread_of_k))
      values%domain = shares_of_modes(field, sum(values%j)/size(values%j), values%intensity)
      if (tip%grown > 0) then                    ! the fields of the interaction integral are those of a tip at rest
         values%intensity = sign(sqrt(effective_modulus(domain%material)*abs(values%domain) &
                                      /energy_factors(domain%material, tip%speed)), values%domain)
         values%g_of_k = sum(values%j)/size(values%j)
      end if
   end subroutine measure_domain
end module hampm_crack_measurements
