!> Estimated errors of tip values before the first step.
module hampm_crack_errors
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_values, only: crack_values_t
   use hampm_cracks, only: cracks_t, first_point
   use hampm_estimated_errors, only: static_columns_t, relative_errors, in_all, hardly, uncertainty
   use hampm_expected_error, only: static_model_t, find_equilibrium, static_crack_t, find_static_crack, static_tips_t, &
                                   find_static_tips, error_by_lengths, place_of_tip, lost_by_locking, disc_of_shifts, no_work, &
                                   weight_moved
   use hampm_failure, only: failure_t
   use hampm_mass_solver, only: mass_solver_t
   use hampm_problem, only: problem_t
   use hampm_nodal_state, only: nodal_state_t
   use hampm_particles, only: particles_t
   use hampm_crack_tip_field, only: modes, tip_field_t
   use hampm_stiffness, only: stiffness_t
   use hampm_threads, only: thread_count
   use hampm_tip_domain, only: fields_at, particles_in
   use hampm_tip_measurements, only: estimate_rates, measure_domain
   use hampm_missing_energy, only: pair_t, missing_energies, displace
   implicit none
   private
   public :: estimate_errors

   !> Relative error of an estimate by values extrapolated to nodes, without a better bound: it is a third to a half of G.
   real(dp), parameter :: of_extrapolation = 2

contains

   !> Before the first step: estimate the relative errors of the chosen estimators at each tip, from the static solution. For
   !> history-dependent material, or an absent crack, none is known.
   subroutine estimate_errors(problem, cracks, rest, extrapolation, values, failure, time)
      type(problem_t), intent(inout) :: problem
      type(cracks_t), intent(in) :: cracks
      type(stiffness_t), intent(inout) :: rest   !! that is factorised
      type(mass_solver_t), intent(inout) :: extrapolation
      type(crack_values_t), intent(inout) :: values(:) !! by tip
      type(failure_t), intent(inout) :: failure
      real(dp), intent(in), optional :: time     !! of the loads; else their largest factors count [s]
      type(static_model_t) :: model
      type(static_tips_t) :: static_tips
      logical :: at_nodes
      real(dp) :: lost
      real(dp), allocatable :: far(:, :)         ! errors of K by other cells, by mode and tip [Pa sqrt(m)]
      integer :: k, threads
      if (size(values) == 0) return
      if (size(values(1)%estimates) == 0 .and. .not. allocated(values(1)%j)) return
      if (any(problem%materials(problem%particles%material(:problem%particles%n))%has_history)) return
      if (any(cracks%crack%waits)) return
      associate (tips => cracks%tips(:size(values)))
         at_nodes = all(tips%nodes%tip > 0)
         call find_equilibrium(problem, rest, model, time)
         if (present(time) .and. .not. model%known) call find_equilibrium(problem, rest, model)
         if (.not. at_nodes) call find_static_tips(problem, rest, model, tips, static_tips)
         do k = 1, size(values)
            values(k)%errors%cell = tips(k)%nodes%spacing
            values(k)%errors%are_known = .true.
            if (at_nodes) then
               call estimate_at_node(problem, cracks, k, rest, model, extrapolation, values(k), failure)
            else if (.not. static_tips%known) then
               call estimate_by_lengths(problem, cracks, k, values(k))
            end if
         end do
         if (static_tips%known) then
            far = errors_by_cells(problem, tips, static_tips)
            threads = min(thread_count(), size(values))
            !$omp parallel do schedule(static, 1)
            do k = 1, threads
               call estimate_some_by_shifts(problem, tips, k, threads, static_tips, far, values)
            end do
         end if
      end associate
      do k = 1, size(values)
         if (tells_nothing(values(k), present(time))) call estimate_by_lengths(problem, cracks, k, values(k))
      end do
      if (.not. model%known) return
      lost = lost_by_locking(problem, model%u, model%energy)
      do k = 1, size(values)
         if (lost > 0) call add_to_all(values(k), lost)
      end do
   end subroutine estimate_errors

   !> Change of the phase of K of an interface over that of the logarithm of the crack length: 2 epsilon, at least 0.1 [rad].
   pure real(dp) function turn_of(field)
      type(tip_field_t), intent(in) :: field
      turn_of = max(0.1_dp, 2*abs(field%oscillation))
   end function turn_of

   !> Whether a static solution tells nothing of the errors of a tip: it does not load it, or in motion, where waves may load it, so
   !> little that the errors of J, or without it of all estimators, are as large as their values.
   pure logical function tells_nothing(values, at_equilibrium)
      type(crack_values_t), intent(in) :: values
      logical, intent(in) :: at_equilibrium
      real(dp) :: relative
      integer :: k
      relative = huge(relative)
      do k = 1, size(values%estimates)
         relative = min(relative, maxval(values%estimates(k)%error%relative))
      end do
      if (allocated(values%j)) relative = values%errors%j%relative
      tells_nothing = .not. (relative > 0 .and. (relative < 1 .or. at_equilibrium))
   end function tells_nothing

   !> Add a part of G to the estimated errors of all that tells of it.
   pure subroutine add_to_all(values, lost)
      type(crack_values_t), intent(inout) :: values
      real(dp), intent(in) :: lost               !! [-]
      integer :: k
      associate (errors => values%errors)
         errors%domain%relative = errors%domain%relative + lost
         errors%j%relative = errors%j%relative + lost
         errors%intensity%relative = errors%intensity%relative + lost/2
      end associate
      do k = 1, size(values%estimates)
         values%estimates(k)%error%relative = values%estimates(k)%error%relative + lost
      end do
   end subroutine add_to_all

   !> Estimate where nothing is known but lengths.
   subroutine estimate_by_lengths(problem, cracks, number, values)
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the tip
      type(crack_values_t), intent(inout) :: values
      real(dp) :: from(ndim)                     ! [m]
      integer :: k
      associate (tip => cracks%tips(number), crack => cracks%crack(cracks%tips(number)%crack))
         from = crack%mouth
         if (.not. tip%is_half()) from = crack%points(:, merge(size(crack%points, 2), 1, tip%end == first_point)) ! its other end
      end associate
      associate (errors => values%errors, relative => error_by_lengths(problem, cracks%tips(number), from))
         errors%of_tip = 1
         errors%domain%relative = relative
         errors%j%relative = relative
         errors%intensity%relative = relative/2
         do k = 1, size(values%estimates)
            values%estimates(k)%error%relative = merge(of_extrapolation, relative, values%estimates(k)%by%needs_mass)
         end do
      end associate
   end subroutine estimate_by_lengths

   !> Estimate for a tip at a node, by closing the crack behind it.
   subroutine estimate_at_node(problem, cracks, number, rest, model, extrapolation, values, failure)
      type(problem_t), intent(inout) :: problem
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the tip
      type(stiffness_t), intent(inout) :: rest   !! that was factorised for it
      type(static_model_t), intent(in) :: model  !! static
      type(mass_solver_t), intent(inout) :: extrapolation
      type(crack_values_t), intent(inout) :: values
      type(failure_t), intent(inout) :: failure
      type(static_crack_t) :: crack
      type(crack_values_t) :: found
      type(particles_t) :: p
      integer :: k
      type(tip_field_t) :: field(2)
      type(static_columns_t) :: by_rate, by_intensity, total
      associate (tip => cracks%tips(number), errors => values%errors)
         call find_static_crack(problem, rest, model, cracks%tips, number, problem%particles%thickness%at(tip%now), crack)
         if (.not. crack%known) then
            call estimate_by_lengths(problem, cracks, number, values)
            return
         end if
         call displace(problem, crack%u, p)
         found = values
         call estimate_rates(problem, crack%scale*crack%factors, tip, p, &
                             nodal_state_t(divergence=crack%divergence), extrapolation, found, failure)
         if (failure%failed()) return
         errors%by_mode = .true.
         errors%of_tip = crack%part_of_tip()
         field = fields_at(problem%materials, tip)
         by_rate = static_columns_t(crack%g, crack%deficit(), crack%best(), crack%correction())
         total = in_all(by_rate)
         do k = 1, size(values%estimates)
            values%estimates(k)%error%relative = relative_errors(by_rate, found%estimates(k)%rate, hardly**2)* &
                                                 merge(1 + uncertainty, 1.0_dp, values%estimates(k)%by%needs_mass)
         end do
         errors%domain%relative = relative_errors(by_rate, found%domain, hardly**2)
         ! In material whose modes turn into each other both have the relative error of either, unless one of them is small
         by_intensity = static_columns_t(field(1)%typical_intensities(by_rate%own), by_rate%deficit/2, &
                                         field(1)%typical_intensities(by_rate%best), by_rate%correction/2)
         errors%intensity%relative = relative_errors(by_intensity, found%intensity, &
                                     merge(hardly, 10*hardly, problem%materials(tip%material)%isotropic))
         if (.not. problem%materials(tip%material)%isotropic) errors%intensity%relative = maxval(errors%intensity%relative)
         ! Across its axes the cells at the tip share G otherwise than its field: both modes have the error of G
         if (field(1)%modes_couple() .and. .not. field(1)%is_at_interface) then
            associate (of_rate => relative_errors(total, [field(1)%rate_of(found%intensity)], hardly**2))
               errors%domain%relative = of_rate(1)*sum(abs(found%domain))/max(abs(found%domain), tiny(1.0_dp))
               errors%intensity%relative = of_rate(1)/2*norm(found%intensity)/max(abs(found%intensity), tiny(1.0_dp))
            end associate
         end if
         ! Between two materials the share of each mode depends on the cell size
         if (tip%phase_length > 0) then
            by_intensity = static_columns_t([norm(field(1)%typical_intensities([total%own, 0.0_dp]))], total%deficit/2, &
                                            [norm(field(1)%typical_intensities([total%best, 0.0_dp]))], total%correction/2)
            errors%intensity%relative = maxval(relative_errors(by_intensity, [norm(found%intensity)], hardly)) &
                                        *(turn_of(field(1)) + abs(found%intensity)/max(norm(found%intensity), tiny(1.0_dp)))
         end if
         if (allocated(found%j)) &
            errors%j%relative = maxval(relative_errors(total, [sum(found%j)/size(found%j)], hardly**2))
      end associate
   end subroutine estimate_at_node

   !> Estimate for each of so many tips, as one thread does, with particles of its own.
   subroutine estimate_some_by_shifts(problem, tips, first, of, static_tips, by_cells, values)
      type(problem_t), intent(in) :: problem
      type(crack_tip_t), intent(in) :: tips(:)
      integer, intent(in) :: first, of           !! tip, and from one to the next
      type(static_tips_t), intent(in) :: static_tips
      real(dp), intent(in) :: by_cells(:, :)     !! [Pa sqrt(m)], (modes, tips)
      type(crack_values_t), intent(inout) :: values(:)
      type(particles_t) :: p
      integer :: k
      do k = first, size(values), of
         call estimate_by_shifts(problem, tips, k, static_tips, by_cells(:, k), p, values(k))
      end do
   end subroutine estimate_some_by_shifts

   !> Estimate for a tip of a path: it acts near its place, so that J is of a longer or shorter crack, K of the fields around the
   !> true place; nearby tips have place errors too. Modes share the error in the disc. That of the other cells is added.
   !>
   !> The change of K for a tip that acts at d ahead of the assumed place is d dK/da less the change of K evaluated at d. Of another
   !> tip K sees, as J does, a longer or shorter crack. Places are independent but for the part that all tips have.
   subroutine estimate_by_shifts(problem, tips, number, static_tips, by_cells, p, values)
      type(problem_t), intent(in) :: problem
      type(crack_tip_t), intent(in) :: tips(:)
      integer, intent(in) :: number              !! of the tip
      type(static_tips_t), intent(in) :: static_tips
      real(dp), intent(in) :: by_cells(modes)    !! error of K by those apart from the tips [Pa sqrt(m)]
      type(particles_t), intent(inout) :: p      !! displaced around the tip; from another one before, or none
      type(crack_values_t), intent(inout) :: values
      real(dp), parameter :: no_shift(ndim) = 0
      real(dp), parameter :: common = 0.3_dp     ! part of place errors that all tips have: cracks are short by it
      integer, parameter :: most_others = 4      ! that are counted: what others change falls with the square of their distance
      real(dp) :: k(modes), k_there(modes), k_here(modes), j, j_there, j_here
      real(dp) :: of_k(modes), of_j, far(modes), far_of_j
      real(dp) :: change, together_of_j          ! of J by the place of a tip, and by those of all [J/m2]
      real(dp) :: together_of_k(modes), beside   ! of K by those of all, and its error by the fields beside [Pa sqrt(m)]
      real(dp) :: off_of_j(modes), off_of_k(modes), in_disc
      real(dp) :: distance(size(tips)), nearest(0:most_others) ! of those that are counted, the least first
      logical :: has_moved(size(static_tips%moved, 3))
      type(crack_values_t) :: found(2)           ! with the tip sought at its own place, and beside it
      type(tip_field_t) :: field(2)
      integer, allocatable :: near(:)            ! particles whose displacement counts
      real(dp) :: rotation(ndim, ndim)           ! mean of the particles near by
      real(dp), allocatable :: q(:, :)           ! way of the nodes over that of a tip that moves [-]
      integer, allocatable :: leaves(:)
      integer :: t, d
      allocate (found(1)%j(1), found(2)%j(1))
      of_k = 0
      of_j = 0
      beside = 0
      together_of_k = 0
      together_of_j = 0
      associate (h => tips(number)%nodes%spacing)
         near = particles_in(tips(number)%now, disc_of_shifts(tips(number)) + h/2, problem%grid, problem%blocks)
         call find(1, 0.0_dp, no_shift, k, j)
         rotation = sum(p%gradient(near, :, :), dim=1)/size(near)
         rotation = (rotation - transpose(rotation))/2
         nearest = huge(nearest)
         do d = 1, size(tips)
            distance(d) = norm(tips(d)%place - tips(number)%place)
            if (.not. distance(d) < nearest(most_others)) cycle
            t = count(nearest <= distance(d))
            nearest(t + 1:) = nearest(t:most_others - 1)
            nearest(t) = distance(d)
         end do
         has_moved = .false.
         has_moved(static_tips%group(number)) = .true. ! with itself
         do t = 1, size(tips)
            if (distance(t) > nearest(most_others)) cycle
            if (t /= number .and. has_moved(static_tips%group(t))) cycle
            has_moved(static_tips%group(t)) = .true.
            call place_of_tip(problem, tips(t), off_of_j, off_of_k, in_disc)
            if (t == number .and. .not. tips(t)%phase_length > 0) beside = in_disc*norm(k)
            call weight_moved(problem, tips(t), q, leaves)
            call find(static_tips%group(t), h, no_shift, k_there, j_there, tips(t)%direction)
            call find(static_tips%group(t), -h, no_shift, k_here, j_here, tips(t)%direction)
            change = sum(off_of_j*k**2)/max(sum(k**2), tiny(j))*(j_there - j_here)/2
            together_of_j = together_of_j + change
            of_j = hypot(of_j, change)
            k_there = k_there - k_here
            if (t == number .and. tips(t)%nodes%in_cell) then
               call find(1, 0.0_dp, h/2*tips(t)%direction, k_here, j_here)
               k_there = k_there - 2*k_here
               call find(1, 0.0_dp, -h/2*tips(t)%direction, k_here, j_here)
               k_there = k_there + 2*k_here
            end if
            if (t /= number) off_of_k = off_of_j ! by the whole change, of which no part cancels
            k_there = off_of_k*k_there/2
            together_of_k = together_of_k + k_there
            of_k = hypot(of_k, k_there)
         end do
      end associate
      if (.not. (abs(j)*problem%particles%thickness%at(tips(number)%now)*tips(number)%nodes%spacing > no_work*static_tips%energy &
                 .and. norm(k) > 0)) return
      of_k = hypot(common*abs(together_of_k) + (1 - common)*of_k, beside)
      of_j = common*abs(together_of_j) + (1 - common)*of_j
      far = by_cells
      if (tips(number)%is_half()) far(2) = 0
      field = fields_at(problem%materials, tips(number))
      far_of_j = abs(field(1)%rate_of(k + far) - field(1)%rate_of(k - far))/2
      associate (errors => values%errors)
         errors%of_tip = of_j/(of_j + far_of_j + tiny(1.0_dp))
         errors%j%relative = (of_j + far_of_j)/abs(j)
         errors%intensity%relative = (of_k + merge(abs(far), maxval(abs(far)), .not. field(1)%modes_couple()))/norm(k)
         if (tips(number)%phase_length > 0) & ! along which the tip is: it is astray ahead and behind alone
            errors%intensity%relative = (of_k + turn_of(field(1))*norm(of_k))/norm(k) &
                                        + norm(far)/norm(k)*(turn_of(field(1)) + abs(k)/norm(k))
         do t = 1, size(values%estimates)
            values%estimates(t)%error%relative = errors%j%relative
         end do
      end associate

   contains

      !> K and J of the static displacement with the tips of a group moved, evaluated for a tip beside its own place.
      !> Where cells change their shape as they move by v = way q e, a rotation of all must not strain them: its part of H grad v is
      !> left out.
      subroutine find(group, way, shift, k, j, direction)
         integer, intent(in) :: group
         real(dp), intent(in) :: way             !! of its tips [m]
         real(dp), intent(in) :: shift(ndim)     !! [m]
         real(dp), intent(out) :: k(modes)       !! [Pa sqrt(m)]
         real(dp), intent(out) :: j              !! [J/m2]
         real(dp), intent(in), optional :: direction(ndim) !! e
         type(crack_tip_t) :: tip
         real(dp) :: weight(problem%grid%n_functions)
         integer :: n, c
         tip = tips(number)
         tip%may_close = .false.
         tip%radii = [disc_of_shifts(tip)]
         call displace(problem, static_tips%u, p, near, static_tips%moved(:, :, group), way)
         if (present(direction)) then
            do n = 1, size(near)
               associate (at => problem%grid%support_of(p%cell(near(n))))
                  weight = 0
                  do c = 1, size(at)
                     if (at(c) >= lbound(q, 2) .and. at(c) <= ubound(q, 2)) weight(c) = q(1, at(c))
                  end do
               end associate
               p%gradient(near(n), :, :) = p%gradient(near(n), :, :) - way*spread(matmul(rotation, direction), 2, ndim) &
                                           *spread(matmul(weight, problem%gradients_of(near(n))), 1, ndim)
            end do
         end if
         associate (values => found(merge(2, 1, any(abs(shift) > 0))))
            call measure_domain(problem, static_tips%scale*static_tips%factors, tip, p, &
                                nodal_state_t(divergence=static_tips%divergence), values, shift)
            k = values%intensity
            j = values%j(1)
         end associate
      end subroutine find
   end subroutine estimate_by_shifts

   !> Errors of K of the tips by the cells apart from all of them, by mode [Pa sqrt(m)]: the product a(e, e') of the errors of the
   !> displacement and of the dual one of K in these cells (Becker & Rannacher 2001), with the uncertainty of that.
   function errors_by_cells(problem, tips, static_tips) result(far)
      type(problem_t), intent(in) :: problem
      type(crack_tip_t), intent(in) :: tips(:)
      type(static_tips_t), intent(in) :: static_tips
      real(dp) :: far(modes, size(tips))
      real(dp), parameter :: apart = 5 + 1e-6_dp ! cells from the tip: nearer ones have a part in the error of its place
      integer, parameter :: most = 16            ! groups of tips at a time, whose stresses are there together
      real(dp), allocatable :: u(:, :, :), products(:, :)
      real(dp) :: places(ndim, size(tips), 1)
      integer :: k, first, last, group(size(tips))
      do k = 1, size(tips)
         places(:, k, 1) = tips(k)%place
      end do
      do first = 1, size(static_tips%moved, 3), most
         last = min(first + most - 1, size(static_tips%moved, 3))
         allocate (u(ndim, size(static_tips%u, 2), 0:modes*(last - first + 1)))
         u(:, :, 0) = static_tips%u
         u(:, :, 1:) = reshape(static_tips%dual(:, :, :, first:last), shape(u(:, :, 1:)))
         group = static_tips%group - first + 1   ! of others no displacement is there
         where (group > last - first + 1) group = 0
         products = missing_energies(problem, places, apart*tips%nodes%spacing, max(group, 0), u, &
                                     [(pair_t(1 + k, 1, (k - 1)/modes + 1), k=1, size(u, 3) - 1)])
         do k = 1, size(tips)                    ! an energy is half of the product
            if (group(k) > 0) far(:, k) = 2*(1 + uncertainty)*products(modes*(group(k) - 1) + 1:modes*group(k), k)
         end do
         deallocate (u)
      end do
   end function errors_by_cells
end module hampm_crack_errors
