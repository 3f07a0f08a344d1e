!> Values measured at a crack tip, and G by the best of the chosen estimators.
module hampm_crack_values
   use hampm_kinds, only: dp
   use hampm_tensors, only: norm
   use hampm_archive, only: archive_t
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes
   use hampm_material, only: material_t
   use hampm_estimated_errors, only: estimated_errors_t, arrival_t, archive_errors, archive_column, archive_arrival, book_largest, &
                                     hardly
   use hampm_estimator, only: estimator_t, estimate_t, total
   use hampm_moving_average, only: moving_average_t, archive_average
   use hampm_tip_domain, only: places_t
   implicit none
   private
   public :: crack_values_t, best_t, new_crack_values, best_rate, is_pressed, keep_crack_values

   !> Columns of a tip, by its initial surroundings; where other material makes them invalid, they are NaN.
   type :: recorded_t
      logical :: intensities = .false.           !! K, and with them
      logical :: parts = .false.                 !! the parts of J, and T
      logical :: phase = .false.                 !! epsilon of an interface
      logical :: near_and_far = .false.          !! J of smallest and largest domain, not G, for history-dependent material
      logical :: by_fields = .false.             !! K by the fields of a tip that runs
   end type recorded_t

   !> Last measured values; those of the domain integral are 0 if it is not chosen.
   type :: crack_values_t
      type(estimate_t), allocatable :: estimates(:) !! of the chosen estimators, but the domain integral
      logical :: has_left_node = .false.         !! whether the material has carried the tip off the node that some need: NaN
      logical :: moves = .false.                 !! whether there is inertia
      logical :: in_sets = .false.               !! whether samples of waves are taken only some of the time
      type(arrival_t) :: arrival                 !! of waves, where they are taken so
      logical :: cells_divide = .false.          !! whether cells are divided in motion
      logical :: is_closed = .false.             !! whether faces behind the tip press on each other
      logical :: is_turned = .false.             !! whether they follow from those before a sharp turn (`hampm_turned_tips`)
      real(dp) :: domain(modes) = 0              !! energy release rates, the parts of J [J/m2]
      real(dp) :: intensity(modes) = 0           !! stress intensity factors [Pa sqrt(m)]
      real(dp) :: by_fields(modes) = 0           !! the same by the interaction integral, of growing tips beside J [Pa sqrt(m)]
      real(dp) :: oscillation = 0                !! epsilon at an interface [-]
      real(dp) :: g_of_k = 0                     !! energy release rate of these [J/m2]
      real(dp) :: spread_of_k(modes) = 0         !! range over domains; of closed tips with all uncertainties [Pa sqrt(m)]
      real(dp) :: uncertainty_of_j = 0           !! difference of K and J at a closed tip [J/m2]
      real(dp), allocatable :: j(:)              !! J of each domain, by the radii of the tip [J/m2]; empty if not chosen
      real(dp), allocatable :: t_stress(:)       !! of each domain [Pa]; none where it is not asked for
      real(dp) :: uncertainty_of_t_stress = 0    !! by the tractions behind a closed tip [Pa]
      type(places_t) :: places                   !! of its domains
      real(dp) :: behind(modes) = 0              !! opening and sliding one cell behind the tip [m]
      real(dp) :: mouth(modes) = 0               !! the same at the mouth [m]
      type(estimated_errors_t) :: errors         !! of the domain integral
      type(moving_average_t) :: average          !! of G over the last cells of advance, in motion
      type(recorded_t) :: recorded
   contains
      procedure :: best
      procedure :: book
      procedure :: error_of_t_stress
      procedure :: times
      procedure :: is_above_error
      procedure :: presses
   end type crack_values_t

   !> G by the best of the chosen estimators.
   type :: best_t
      character(:), allocatable :: estimator     !! '' where none is chosen
      real(dp) :: rate = 0                       !! [J/m2]
      real(dp) :: error = 0                      !! estimated [J/m2]
   end type best_t

contains

   !> Book the values so far as those of the run, of which errors have a part, or forget which have been tried since.
   pure elemental subroutine book(self, is_of_run)
      class(crack_values_t), intent(inout) :: self
      logical, intent(in) :: is_of_run
      integer :: k
      associate (errors => self%errors)
         call book_largest(errors%domain, is_of_run)
         call book_largest(errors%intensity, is_of_run)
         call book_largest(errors%j, is_of_run)
      end associate
      do k = 1, size(self%estimates)
         call book_largest(self%estimates(k)%error, is_of_run)
      end do
   end subroutine book

   !> Nothing measured yet.
   subroutine new_crack_values(chosen, t_stress, tip, material, moves, in_sets, cells_divide, values)
      type(estimator_t), intent(in) :: chosen(:) !! estimators, the best one first
      logical, intent(in) :: t_stress            !! whether the T-stress is measured
      type(crack_tip_t), intent(in) :: tip
      type(material_t), intent(in) :: material   !! at it
      logical, intent(in) :: moves               !! whether there is inertia
      logical, intent(in) :: in_sets             !! as in `pace_t`
      logical, intent(in) :: cells_divide        !! in motion
      type(crack_values_t), intent(out) :: values
      type(estimate_t) :: estimate
      integer :: k
      values%moves = moves
      values%in_sets = in_sets
      values%cells_divide = cells_divide
      values%estimates = [estimate_t ::]
      do k = 1, size(chosen)
         estimate%by = chosen(k)
         if (associated(estimate%by%find)) values%estimates = [values%estimates, estimate]
      end do
      if (size(values%estimates) < size(chosen)) allocate (values%j(size(tip%radii)), source=0.0_dp)
      if (allocated(values%j) .and. t_stress) allocate (values%t_stress(size(tip%radii)), source=0.0_dp)
      associate (has_parts => allocated(values%j) .and. .not. (tip%has_layers .or. material%has_history))
         values%recorded = recorded_t(intensities=has_parts .or. allocated(values%j) .and. tip%phase_length > 0, parts=has_parts, &
                                      phase=tip%phase_length > 0, near_and_far=material%has_history, &
                                      by_fields=has_parts .and. material%isotropic)
      end associate
   end subroutine new_crack_values

   !> G of all modes by the most accurate of the chosen estimators: at a tip inside a cell K has less error than J.
   function best(self, tip, isotropic)
      class(crack_values_t), intent(in) :: self
      type(crack_tip_t), intent(in) :: tip
      logical, intent(in) :: isotropic           !! whether the material is
      type(best_t) :: best
      best%estimator = ''
      if (allocated(self%j)) then
         best = best_t('domain_integral', best_rate(self, tip), self%errors%j%now)
         if (.not. is_by_k(tip)) return
         best%error = self%errors%of_rate
         best%estimator = best%estimator//trim(merge(', (K_I**2 + K_II**2)/E''', ', of K_I and K_II      ', isotropic))
      else if (size(self%estimates) > 0) then
         associate (first => self%estimates(1))
            best = best_t(trim(first%by%name), total(first%rate), sum(first%error%now))
            if (tip%has_layers .and. first%by%differs_from_j) best%rate = sum(first%rate)
         end associate
      end if
   end function best

   !> The same under loads that are multiplied by a factor, of a linear body.
   pure function times(self, factor) result(values)
      class(crack_values_t), intent(in) :: self
      real(dp), intent(in) :: factor             !! [-]
      type(crack_values_t) :: values
      values = self
      if (.not. abs(factor - 1) > 0) return
      values%domain = factor*abs(factor)*self%domain
      values%intensity = factor*self%intensity
      values%g_of_k = factor**2*self%g_of_k
      values%spread_of_k = abs(factor)*self%spread_of_k
      values%uncertainty_of_j = factor**2*self%uncertainty_of_j
      values%behind = factor*self%behind
      if (allocated(self%j)) values%j = factor**2*self%j
      if (allocated(self%t_stress)) values%t_stress = factor*self%t_stress
   end function times

   !> Whether G is above its own measured error, without that expected of the cells: else it may be all error, as of closed faces.
   !> Both J and G of K have to be.
   pure logical function is_above_error(self, tip)
      class(crack_values_t), intent(in) :: self
      type(crack_tip_t), intent(in) :: tip
      real(dp) :: least                          ! [J/m2]
      least = sum(self%j)/size(self%j)
      if (self%uncertainty_of_j > 0) least = min(least, self%g_of_k)
      is_above_error = best_rate(self, tip) > 0 .and. least > maxval(self%j) - minval(self%j) + self%uncertainty_of_j
   end function is_above_error

   !> Whether loads press the faces at a tip, or make them interpenetrate. With layers, where K_I is undefined or depends on a
   !> length, the opening behind it counts.
   pure logical function presses(self, tip)
      class(crack_values_t), intent(in) :: self
      type(crack_tip_t), intent(in) :: tip
      presses = is_pressed(self%intensity, self%spread_of_k(1))
      if (tip%has_layers) presses = is_pressed(self%behind, 0.0_dp)
   end function presses

   !> Whether the opening mode is below 0 by more than its error, and that beside the other mode.
   pure logical function is_pressed(of_mode, error)
      real(dp), intent(in) :: of_mode(modes)     !! K, or opening, of the modes
      real(dp), intent(in) :: error              !! of the first
      real(dp), parameter :: off = 0.02_dp       ! as part of the other mode
      is_pressed = -of_mode(1) > error + off*abs(of_mode(2))
   end function is_pressed

   !> Estimated error of the T-stress [Pa]: the range over domains, the stress by the errors of K at the end of the largest domain,
   !> and the error of T by K if there is K: a tension along the crack has T alone, which is uniform.
   pure real(dp) function error_of_t_stress(self, radii) result(error)
      class(crack_values_t), intent(in) :: self
      real(dp), intent(in) :: radii(:)           !! of the domains, ascending [m]
      real(dp) :: by_k(2)                        ! stress there by K, and by its errors [Pa]
      by_k = [norm(self%intensity), norm(self%errors%intensity%now)]/sqrt(2*acos(-1.0_dp)*radii(size(radii)))
      error = maxval(self%t_stress) - minval(self%t_stress) + self%uncertainty_of_t_stress &
              + by_k(2)
      associate (t => abs(sum(self%t_stress)/size(self%t_stress)))
         if (by_k(1) > hardly*t) error = error + min(1.0_dp, by_k(2)/by_k(1))*t
      end associate
   end function error_of_t_stress

   !> Energy release rate of all modes by the domain integral: by K at a tip inside a cell, where its error is less than J's, else J
   !> [J/m2].
   pure real(dp) function best_rate(v, tip)
      class(crack_values_t), intent(in) :: v
      type(crack_tip_t), intent(in) :: tip
      best_rate = sum(v%j)/size(v%j)
      if (is_by_k(tip)) best_rate = v%g_of_k
   end function best_rate

   !> Whether that is by K, which is missing for a growing tip and beside layers.
   pure logical function is_by_k(tip)
      type(crack_tip_t), intent(in) :: tip
      is_by_k = tip%nodes%in_cell .and. .not. tip%grown > 0 .and. (tip%phase_length > 0 .or. .not. tip%has_layers)
   end function is_by_k

   !> Save or restore values for the next errors.
   subroutine keep_crack_values(values, archive)
      type(crack_values_t), intent(inout) :: values
      class(archive_t), intent(inout) :: archive
      integer :: k, n
      call archive_errors(values%errors, archive)
      call archive_arrival(values%arrival, archive)
      call archive_average(values%average, 'average', archive)
      call archive%serialise('is_closed', values%is_closed)
      call archive%serialise('is_turned', values%is_turned)
      call archive%archive_reals('domain', modes, values%domain)
      call archive%archive_reals('intensity', modes, values%intensity)
      call archive%archive_reals('by_fields', modes, values%by_fields)
      call archive%archive_reals('behind', modes, values%behind)
      call archive%archive_reals('spread_of_k', modes, values%spread_of_k)
      call archive%serialise('g_of_k', values%g_of_k)
      call archive%serialise('uncertainty_of_j', values%uncertainty_of_j)
      if (allocated(values%j)) then
         n = size(values%j)
         call archive%serialise('domains', n)
         if (n /= size(values%j)) then           ! as many as there is room for
            deallocate (values%j)
            allocate (values%j(n))
         end if
         call archive%archive_reals('J', n, values%j)
      end if
      do k = 1, size(values%estimates)
         call archive%archive_reals('rate_'//trim(values%estimates(k)%by%name), modes, values%estimates(k)%rate)
         call archive_column(values%estimates(k)%error, trim(values%estimates(k)%by%name), archive)
      end do
   end subroutine keep_crack_values
end module hampm_crack_values
