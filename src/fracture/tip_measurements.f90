!> Measurement of the chosen estimators, and of the domain integral, at a tip.
module hampm_tip_measurements
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_closed_faces, only: closed_faces_t, sample_behind_tip
   use hampm_crack_tip, only: crack_tip_t, upper
   use hampm_crack_values, only: crack_values_t
   use hampm_cut_cells, only: side_of_ties
   use hampm_domain_integral, only: integrals_t, domain_integrals, shares_of_modes
   use hampm_failure, only: failure_t
   use hampm_loads, only: place_loads
   use hampm_mass_solver, only: mass_solver_t
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_moving_tip, only: energy_factors, running_intensities
   use hampm_nodal_state, only: nodal_state_t
   use hampm_particles, only: particles_t
   use hampm_quadratic_tip_offset, only: quadratic_tip_offset
   use hampm_crack_tip_field, only: modes, tip_field_t, let_run
   use hampm_t_stress, only: t_stresses
   use hampm_tip_domain, only: tip_domain_t, fields_at
   implicit none
   private
   public :: estimate_rates, measure_domain, error_of_rate, of_any_sign

contains

   !> The chosen energy release rates and stress intensity factors, for particles at the places of the motion's.
   subroutine estimate_rates(problem, factors, tip, p, state, extrapolation, values, failure, for_waves)
      type(problem_t), intent(inout) :: problem
      real(dp), intent(in) :: factors(:)         !! of the loads [-]
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(nodal_state_t), intent(in) :: state   !! of these particles, where there is a domain integral
      type(mass_solver_t), intent(inout) :: extrapolation
      type(crack_values_t), intent(inout) :: values
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: for_waves !! whether without those that cost much and are off by more than waves
      integer :: k
      call place_loads(problem%loads, problem%grid, p)
      values%has_left_node = tip%nodes%tip == 0 .and. any(values%estimates%by%needs_nodes)
      do k = 1, size(values%estimates)
         associate (of => values%estimates(k), by => values%estimates(k)%by)
            if (by%needs_mass .and. present(for_waves)) cycle
            if (by%needs_mass) call refresh_grid(problem)
            of%uncertainty = 0
            if (.not. (by%needs_nodes .and. values%has_left_node)) &
               call by%find(problem, factors, tip, p, extrapolation, of%rate, of%uncertainty, failure)
            of%uncertainty = of%uncertainty + tip%lost()*abs(of%rate)
         end associate
      end do
      if (allocated(values%j)) call measure_domain(problem, factors, tip, p, state, values)
   end subroutine estimate_rates

   !> Measure the domain integrals: J of each domain, and means over them.
   !>
   !> The offset of an effective tip depends on the anisotropy of the material: there K has the ratio of modes of the interaction
   !> integrals, and its size from J, which needs no origin.
   subroutine measure_domain(problem, factors, tip, p, state, values, shift)
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: factors(:)         !! of the loads [-]
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(nodal_state_t), intent(in) :: state
      type(crack_values_t), intent(inout) :: values
      real(dp), intent(in), optional :: shift(ndim) !! from the tip to its assumed place [m]
      type(tip_domain_t) :: domain
      type(tip_field_t) :: field, fields(2)
      type(closed_faces_t) :: closed
      type(integrals_t) :: found
      real(dp) :: k(modes, size(values%j)), k_uncertainty(modes, size(values%j)), most, left
      integer :: i
      domain%tip = tip%now
      fields = fields_at(problem%materials, tip)
      if (tip%grown > 0) call let_run(fields(1), problem%materials(tip%material_in(problem%materials)), tip%speed)
      if (fields(1)%is_running) domain%speed = tip%speed
      field = fields(1)
      domain%field = fields(1)
      domain%below = fields(2)
      if (present(shift)) domain%tip = domain%tip + shift
      if (present(shift)) domain%is_beside = any(abs(shift) > 0)
      domain%axes = tip%axis
      domain%cell = merge(0.0_dp, tip%nodes%spacing, tip%nodes%in_cell .or. tip%grown > 0)
      domain%spacing = tip%nodes%spacing
      domain%quadratic = problem%grid%is_quadratic()
      domain%tip_offset = quadratic_tip_offset(problem, tip)
      domain%face_of_line = side_of_ties(tip%direction)
      domain%half = tip%is_half()
      if (domain%half) domain%side = merge(1, -1, tip%face(upper))
      domain%has_zone = tip%has_zone
      do i = 1, size(problem%grid%cut_cells%ends)
         if (problem%grid%cut_cells%ends(i)%line == tip%crack .and. problem%grid%cut_cells%ends(i)%end == tip%end) domain%number = i
      end do
      domain%thickness = p%thickness%at(tip%now)
      domain%is_ring = p%thickness%is_ring
      domain%material = problem%materials(tip%material_in(problem%materials))
      domain%radius = tip%radii
      if (allocated(tip%ends_at)) domain%ends_at = tip%ends_at
      ! A pressure on such faces is a load for each direction along the axes
      domain%pressure = sum(factors*problem%loads%pressure, mask=problem%loads%line == tip%crack)/(2*ndim)
      if (tip%may_close) closed = sample_behind_tip(problem%interfaces, tip%now, tip%direction, tip%nodes%spacing)
      domain%has_force = allocated(values%t_stress)
      call domain_integrals(domain, problem, factors, p, state, closed, values%places, found)
      values%j = found%j
      k = found%k
      k_uncertainty = found%k_uncertainty
      if (allocated(values%t_stress)) then
         values%t_stress = t_stresses(domain, p, closed, values%places, found, sum(k, dim=2)/size(values%j))
         values%uncertainty_of_t_stress = 0
         if (closed%are_closed) values%uncertainty_of_t_stress = norm(closed%uncertainty_at(0.0_dp))/domain%thickness
      end if
      if (domain%cell > 0 .and. (field%is_at_interface .or. .not. domain%material%isotropic)) then
         do i = 1, size(values%j)
            k(:, i) = field%of_rate(k(:, i), values%j(i))
         end do
      end if
      left = 0                                   ! by the pressure there: an error, and K_II of a crack in cells has one like it
      if (tip%nodes%in_cell) left = sum(abs(k(1, :)))/size(values%j)
      if (tip%may_close .and. .not. tip%grown > 0) k(1, :) = max(k(1, :), 0.0_dp)
      if (closed%are_closed) then                ! faces that stick are no crack
         k(1, :) = 0
         most = closed%largest_intensity(domain%material%plane_modulus())
         k(2, :) = sign(min(abs(k(2, :)), most), k(2, :))
         k_uncertainty(2, :) = min(hypot(k_uncertainty(2, :), left), most)
         values%j = sign(min(abs(values%j), field%rate_of([0.0_dp, most])), values%j)
      end if
      values%spread_of_k = maxval(k, dim=2) - minval(k, dim=2) + sum(k_uncertainty, dim=2)/size(values%j)
      values%intensity = sum(k, dim=2)/size(values%j)
      if (closed%are_closed) values%spread_of_k = [0.0_dp, values%spread_of_k(2) + abs(values%intensity(2)) &
               *values%errors%with_cells(tip%nodes%spacing)*values%errors%intensity(2)%relative] ! independent errors
      values%oscillation = field%oscillation
      values%g_of_k = field%rate_of(values%intensity)
      if (domain%material%has_history) values%g_of_k = sum(values%j)/size(values%j) ! K is of elastic fields
      values%is_closed = closed%are_closed
      values%uncertainty_of_j = 0
      if (closed%are_closed) values%uncertainty_of_j = hypot(sum(values%j)/size(values%j) - values%g_of_k, &
                                                             error_of_rate(field, values%intensity, values%spread_of_k))
      values%domain = shares_of_modes(field, sum(values%j)/size(values%j), values%intensity)
      values%by_fields = values%intensity
      if (tip%grown > 0) then                    ! J sees no origin of the fields
         if (any(energy_factors(domain%material, tip%speed) >= huge(tip%speed))) values%by_fields = 0
         values%intensity = running_intensities(domain%material, tip%speed, values%domain)
         values%g_of_k = sum(values%j)/size(values%j)
      end if
      values%spread_of_k = values%spread_of_k + tip%lost()/2*norm(values%intensity)
   end subroutine measure_domain

   !> The largest change of G by errors of K of any sign [J/m2].
   pure real(dp) function error_of_rate(field, k, error)
      type(tip_field_t), intent(in) :: field
      real(dp), intent(in) :: k(modes), error(modes) !! [Pa sqrt(m)]
      real(dp) :: off(modes, 4)
      integer :: i
      off = of_any_sign(error)
      error_of_rate = maxval([(abs(field%rate_of(k + off(:, i)) - field%rate_of(k)), i = 1, 4)])
   end function error_of_rate

   !> Errors of K with each sign.
   pure function of_any_sign(error) result(off)
      real(dp), intent(in) :: error(modes)       !! [Pa sqrt(m)]
      real(dp) :: off(modes, 4)
      off = reshape([error, -error, error(1), -error(2), -error(1), error(2)], [modes, 4])
   end function of_any_sign
end module hampm_tip_measurements
