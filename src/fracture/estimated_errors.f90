!> The estimated error of each column of G, J and K: a part of the value that is known before the first step, and that follows the
!> value in time.
module hampm_estimated_errors
   use hampm_kinds, only: dp
   use hampm_archive, only: archive_t
   use hampm_crack_tip_field, only: modes
   implicit none
   private
   public :: error_t, estimated_errors_t, relative_errors, follow, archive_errors, archive_column, hardly, uncertainty, &
             recent_t, add_recent, waves_of, archive_recent

   !> Part of the largest value so far of which there is always the relative error: where a value passes through zero, a small
   !> shift in time is an error of the size of its neighbours.
   real(dp), parameter :: floor_of_values = 0.1_dp

   !> Relative uncertainty of the correction: how much too short a crack is depends on particles a cell, Poisson's ratio and plane
   !> condition, from 0.20 to 0.30 cells, and the correction is for 0.21.
   real(dp), parameter :: uncertainty = 0.35_dp

   !> K of a mode over that of the other below which it is nearly absent: its crack closure is next to rounding. For energy release
   !> rates the square of it.
   real(dp), parameter :: hardly = 1.0e-3_dp

   integer, parameter :: most_recent = 16        !! samples that are kept
   integer, parameter :: least_recent = 6        !! that tell of waves
   real(dp), parameter :: cells_of_waves = 4     !! that a shear wave crosses in the time over which samples swing about a line
   real(dp), parameter :: longest = 2.5_dp       !! times that, samples are too far apart

   !> The last samples of a value in motion, which swings with the waves that cells cannot carry.
   type :: recent_t
      integer :: n = 0
      real(dp) :: time(most_recent) = 0, value(most_recent) = 0 !! [s], and in the unit of the value
   end type recent_t

   !> The estimated error of a column.
   type :: error_t
      type(recent_t) :: recent                   !! values, in motion
      real(dp) :: relative = 0                   !! with the cells of the start [-]
      real(dp) :: largest = 0                    !! size of the largest value so far, in the unit of the column
      real(dp) :: now = 0                        !! of the latest value, in the unit of the column
   end type error_t

   !> Errors of all columns.
   type :: estimated_errors_t
      type(error_t) :: domain(modes)
      type(error_t) :: intensity(modes)
      type(error_t) :: j
      real(dp) :: of_rate = 0                    !! now, of G by K [J/m2]
      logical :: are_known = .false.             !! whether there are any
      logical :: by_mode = .false.               !! whether each mode has an error of its own
      real(dp) :: of_tip = 1                     !! part of the estimate due to the cells at the tip [-]
      real(dp) :: cell = 0                       !! size of these at the start [m]
   contains
      procedure :: with_cells
   end type estimated_errors_t

contains

   !> Relative errors of columns that are `value` in the static solution against the estimate `best`, up to its part `correction`. A
   !> nearly absent mode, in `best` or as a value, has the relative error of the other. For values as good as the basis of `best`,
   !> itself extrapolated along the crack, each may lack all of the correction.
   pure function relative_errors(value, best, correction, are_exact, least) result(relative)
      real(dp), intent(in) :: value(:), best(:)  !! by mode, in the unit of the column; only their sizes count
      real(dp), intent(in) :: correction(:)      !! relative correction of `best` in the estimate [-]
      logical, intent(in) :: are_exact           !! whether values are exact up to the correction, as of quadratic cells
      real(dp), intent(in) :: least              !! least ratio of a present mode to the other [-]
      real(dp) :: relative(size(value))          !! [-]
      logical :: there(size(value))
      there = abs(best) > least*maxval(abs(best)) .and. abs(value) > least*maxval(abs(value))
      relative = 0
      where (there) relative = abs(abs(best/value) - 1) + uncertainty*correction*abs(best/value)
      if (are_exact) relative = merge(max(relative, (1 + uncertainty)*correction), relative, there)
      where (.not. there) relative = maxval(relative)
   end function relative_errors

   !> How long samples swing about a line in the waves that cells cannot carry [s].
   pure elemental real(dp) function waves_of(cell, speed)
      real(dp), intent(in) :: cell, speed        !! at the tip, and of shear waves there [m], [m/s]
      waves_of = cells_of_waves*cell/speed
   end function waves_of

   !> Add a sample, and find the scatter of the recent ones about a line, twice their standard deviation; 0 if too few lie within
   !> the time in which the right value is nearly linear.
   pure subroutine add_recent(recent, time, value, waves, scatter)
      type(recent_t), intent(inout) :: recent
      real(dp), intent(in) :: time, value        !! [s]
      real(dp), intent(in) :: waves              !! [s]
      real(dp), intent(out) :: scatter           !! in the unit of the value
      real(dp), allocatable :: t(:), y(:)
      real(dp) :: slope
      integer :: n, first
      n = recent%n
      if (n > 1) then                            ! one too near to that before it makes room
         if (time - recent%time(n - 1) < waves/(most_recent - 2)) n = n - 1
      end if
      if (n > 0) then
         if (time <= recent%time(n)) n = n - 1
      end if
      if (n == most_recent) then
         recent%time = eoshift(recent%time, 1)
         recent%value = eoshift(recent%value, 1)
         n = n - 1
      end if
      n = n + 1
      recent%n = n
      recent%time(n) = time
      recent%value(n) = value
      scatter = 0
      if (n < least_recent) return
      first = min(count(recent%time(:n) < time - waves) + 1, n - least_recent + 1)
      if (time - recent%time(first) > longest*waves) return
      t = recent%time(first:n) - sum(recent%time(first:n))/(n - first + 1)
      y = recent%value(first:n) - sum(recent%value(first:n))/(n - first + 1)
      slope = dot_product(t, y)/dot_product(t, t)
      scatter = 2*sqrt(sum((y - slope*t)**2)/(size(t) - 2))
   end subroutine add_recent

   !> Follow a value: its error is a part of it, or of the largest so far, and at least `least`; in motion plus the scatter.
   pure elemental subroutine follow(error, value, scale, least, time, waves)
      type(error_t), intent(inout) :: error
      real(dp), intent(in) :: value              !! in the unit of the column, as the next but one
      real(dp), intent(in) :: scale              !! of the relative error [-]
      real(dp), intent(in) :: least
      real(dp), intent(in) :: time, waves        !! of `add_recent`, the latter 0 at rest [s]
      real(dp) :: scatter
      error%largest = max(error%largest, abs(value))
      error%now = max(scale*error%relative*max(abs(value), floor_of_values*error%largest), least)
      if (.not. waves > 0) return
      call add_recent(error%recent, time, value, waves, scatter)
      error%now = error%now + scatter
   end subroutine follow

   !> Factor of the initial relative errors with the present cells at the tip [-].
   pure real(dp) function with_cells(self, cell) result(scale)
      class(estimated_errors_t), intent(in) :: self
      real(dp), intent(in) :: cell               !! [m]
      scale = 1
      if (self%cell > 0) scale = 1 - self%of_tip*(1 - cell/self%cell)
   end function with_cells

   !> Save or restore values for the next errors.
   subroutine archive_errors(errors, archive)
      type(estimated_errors_t), intent(inout) :: errors
      class(archive_t), intent(inout) :: archive
      call archive_column(errors%domain, 'domain', archive)
      call archive_column(errors%intensity, 'intensity', archive)
      call archive%serialise('j_relative', errors%j%relative)
      call archive%serialise('j_largest', errors%j%largest)
      call archive_recent(errors%j%recent, 'j', archive)
      call archive%serialise('of_tip', errors%of_tip)
      call archive%serialise('error_cell', errors%cell)
      call archive%serialise('errors_are_known', errors%are_known)
      call archive%serialise('errors_by_mode', errors%by_mode)
   end subroutine archive_errors

   !> Save or restore the errors of the columns of an estimator.
   subroutine archive_column(errors, name, archive)
      type(error_t), intent(inout) :: errors(modes)
      character(*), intent(in) :: name
      class(archive_t), intent(inout) :: archive
      integer :: mode
      call archive%archive_reals(name//'_relative', modes, errors%relative)
      call archive%archive_reals(name//'_largest', modes, errors%largest)
      do mode = 1, modes
         call archive_recent(errors(mode)%recent, name//repeat('_I', mode), archive)
      end do
   end subroutine archive_column

   !> Keep the last samples of a value.
   subroutine archive_recent(recent, name, archive)
      type(recent_t), intent(inout) :: recent
      character(*), intent(in) :: name
      class(archive_t), intent(inout) :: archive
      call archive%serialise(name//'_samples', recent%n)
      call archive%archive_reals(name//'_times', most_recent, recent%time)
      call archive%archive_reals(name//'_values', most_recent, recent%value)
   end subroutine archive_recent
end module hampm_estimated_errors
