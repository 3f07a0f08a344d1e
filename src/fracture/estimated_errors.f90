!> The estimated error of each column of G, J and K: a part of the value that is known before the first step, and that follows the
!> value in time.
module hampm_estimated_errors
   use hampm_kinds, only: dp
   use hampm_archive, only: archive_t
   use hampm_crack_tip_field, only: modes
   use hampm_moving_tip, only: lost_to_lumping
   use hampm_vectors, only: fit_line
   implicit none
   private
   public :: error_t, estimated_errors_t, seen_speed_t, static_columns_t, relative_errors, in_all, follow, follow_speed, &
             book_largest, archive_errors, archive_column, hardly, uncertainty, recent_t, pace_t, arrival_t, is_new_slot, slot_of, &
             add_recent, is_sample, needs_sample, waves_of, archive_recent, archive_arrival, archive_seen

   !> Part of the largest value so far of which there is always the relative error: where a value passes through zero, a small
   !> shift in time is an error of the size of its neighbours.
   real(dp), parameter :: floor_of_values = 0.1_dp

   !> Relative uncertainty of the correction: how much too short a crack is depends on particles a cell, Poisson's ratio and plane
   !> condition, from 0.20 to 0.30 cells, and the correction is for 0.21.
   real(dp), parameter :: uncertainty = 0.35_dp

   !> K of a mode over that of the other below which it is nearly absent: its crack closure is next to rounding. For energy release
   !> rates the square of it.
   real(dp), parameter :: hardly = 1.0e-3_dp

   integer, parameter :: most_recent = 8         !! samples that are kept
   integer, parameter :: least_recent = 6        !! that tell of waves
   real(dp), parameter :: cells_of_waves = 4     !! that a shear wave crosses in the time over which samples swing about a line
   real(dp), parameter :: longest = 2.5_dp       !! times that, samples are too far apart
   integer, parameter :: a_wave = 8              !! slots in that time: a sample is the first value of one
   integer, parameter :: from_set_to_set = 128   !! slots from one set of samples to the next
   integer, parameter :: of_set = 16             !! the first of these, with the samples of a set: steps may be longer than slots
   real(dp), parameter :: rounding = 1e-6_dp     !! of times, in slots

   !> The last samples of a value in motion, which swings with the waves that cells cannot carry. They are taken when time and cells
   !> say, whichever rows there are.
   type :: recent_t
      integer :: n = 0
      real(dp) :: time(most_recent) = 0, value(most_recent) = 0 !! [s], and in the unit of the value
      real(dp) :: scatter = 0                    !! of them about a line, twice their standard deviation, in that unit
      real(dp) :: swing = 0                      !! of values of a tip that runs, as it crosses cells, in that unit
      real(dp) :: change = 0                     !! along it, in the time to which fronts of waves are known, in that unit
   contains
      procedure :: with_waves
   end type recent_t

   !> When the last wave has arrived that strains material faster than all before it, of which samples tell nothing.
   type :: arrival_t
      real(dp) :: slot = 0                       !! number of its slot
      real(dp) :: last_look = -1                 !! of that of the last look
      real(dp) :: rate = 0                       !! difference of velocities in a cell then [m/s]
   end type arrival_t

   !> When samples are taken.
   type :: pace_t
      real(dp) :: waves = 0                      !! `waves_of` the cells; 0: never [s]
      logical :: in_sets = .false.               !! whether only some of the time, where nothing else needs values of each step
      real(dp) :: first = 0                      !! slot from which sets are counted
      real(dp) :: cells = 0.5_dp                 !! that a shear wave crosses in the time to which fronts of waves are known
   end type pace_t

   !> The speed of which domains see waves.
   type :: seen_speed_t
      real(dp) :: time = -1                      !! of the last sample; below 0: none [s]
      real(dp) :: speed = 0                      !! then [m/s]
   end type seen_speed_t

   !> The estimated error of a column.
   type :: error_t
      type(recent_t) :: recent                   !! values, in motion
      real(dp) :: relative = 0                   !! with the cells of the start [-]
      real(dp) :: largest = 0                    !! size of the largest value so far, in the unit of the column
      real(dp) :: booked = 0                     !! the same, of states of the run alone: at rest loads are tried
      real(dp) :: lasting = 0                    !! of the latest value, without waves that cells cannot carry, in that unit
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
      type(seen_speed_t) :: seen                 !! speed of the tip of which domains see waves
      real(dp) :: apart(modes) = 0               !! mean square of what K by J and by fields differ by, over K**2 [-]
   contains
      procedure :: with_cells
   end type estimated_errors_t

   !> Columns, by mode, as the energy of a static solution tells them.
   type :: static_columns_t
      real(dp), allocatable :: own(:)            !! of the same cells as a value, in the unit of the column
      real(dp), allocatable :: deficit(:)        !! that these may lack of it [-]
      real(dp), allocatable :: best(:)           !! best estimate, in the same unit
      real(dp), allocatable :: correction(:)     !! its relative correction [-]
   end type static_columns_t

contains

   !> Relative errors of columns that are `value` in the static solution of the same cells: what they differ from its energy by is
   !> an error beside what that lacks, whatever its sign. And not less than against the best estimate, up to a part of its
   !> correction. A mode that is nearly absent, in the energy or as a value, has the relative error of the other.
   pure function relative_errors(columns, value, least) result(relative)
      type(static_columns_t), intent(in) :: columns
      real(dp), intent(in) :: value(:)           !! by mode, in the unit of the column; only their sizes count
      real(dp), intent(in) :: least              !! least ratio of a present mode to the other [-]
      real(dp) :: relative(size(value))          !! [-]
      relative = max(errors_against(columns%own, columns%deficit), errors_against(columns%best, uncertainty*columns%correction))

   contains

      !> Relative errors against values that are themselves uncertain.
      pure function errors_against(right, uncertain) result(errors)
         real(dp), intent(in) :: right(:), uncertain(:) !! in the unit of the column, [-]
         real(dp) :: errors(size(value))
         logical :: there(size(value))
         there = abs(right) > least*maxval(abs(right)) .and. abs(value) > least*maxval(abs(value))
         errors = 0
         where (there) errors = abs(abs(right/value) - 1) + uncertain*abs(right/value)
         where (.not. there) errors = maxval(errors)
      end function errors_against
   end function relative_errors

   !> The same of the sum of both modes.
   pure type(static_columns_t) function in_all(columns)
      type(static_columns_t), intent(in) :: columns
      associate (own => sum(columns%own), best => sum(columns%best))
         in_all = static_columns_t([own], [sum(columns%deficit*columns%own)/own], &
                                   [best], [sum(columns%correction*columns%best)/best])
      end associate
   end function in_all

   !> How long samples swing about a line in the waves that cells cannot carry [s].
   pure elemental real(dp) function waves_of(cell, speed)
      real(dp), intent(in) :: cell, speed        !! at the tip, and of shear waves there [m], [m/s]
      waves_of = cells_of_waves*cell/speed
   end function waves_of

   !> Whether a value at some time is the next sample; it replaces one of a step that is done again.
   pure elemental logical function is_sample(recent, time, pace)
      type(recent_t), intent(in) :: recent
      real(dp), intent(in) :: time               !! [s]
      type(pace_t), intent(in) :: pace
      integer :: n
      is_sample = pace%waves > 0
      if (.not. is_sample) return
      n = samples_before(recent, time, pace)
      if (n > 0) is_sample = slot_of(time, pace) > slot_of(recent%time(n), pace)
      if (.not. (pace%in_sets .and. is_sample)) return
      associate (place => place_in_set(time, pace), slots => slot_of(time, pace) - slot_of(recent%time(:n), pace))
         is_sample = place < of_set .and. count(slots <= place) < most_recent
      end associate
   end function is_sample

   !> Number of the samples before a time; that of a step whose time was rounded since is none.
   pure elemental integer function samples_before(recent, time, pace) result(n)
      type(recent_t), intent(in) :: recent
      real(dp), intent(in) :: time               !! [s]
      type(pace_t), intent(in) :: pace
      n = count(recent%time(:recent%n) < time - rounding*pace%waves/a_wave)
   end function samples_before

   !> Whether a value has to be found for a sample that counts in the next row, which is one itself. The first one of a set tells of
   !> the largest value. Without sets each slot with a step has a sample.
   pure elemental logical function needs_sample(recent, time, pace, next_row, dt)
      type(recent_t), intent(in) :: recent
      real(dp), intent(in) :: time, next_row     !! [s]
      type(pace_t), intent(in) :: pace
      real(dp), intent(in) :: dt                 !! of the steps until then [s]
      needs_sample = is_sample(recent, time, pace)
      if (.not. needs_sample) return
      associate (place => place_in_set(time, pace), ahead => slot_of(next_row, pace) - slot_of(time, pace))
         if (pace%in_sets) then
            needs_sample = place < 1 .or. ahead + place < slots_of_set(time, pace) + of_set
         else
            needs_sample = ahead <= longest*a_wave .and. min(ahead, anint((next_row - time)/dt)) < most_recent
         end if
      end associate
   end function needs_sample

   !> Number of the slot of a time.
   pure elemental real(dp) function slot_of(time, pace) result(slot)
      real(dp), intent(in) :: time               !! [s]
      type(pace_t), intent(in) :: pace
      slot = aint(a_wave*time/pace%waves + rounding)
   end function slot_of

   !> Number of the slot of a time in its set, from 0 on.
   pure elemental real(dp) function place_in_set(time, pace) result(place)
      real(dp), intent(in) :: time               !! [s]
      type(pace_t), intent(in) :: pace
      real(dp) :: first
      call find_set(time, pace, first, next=place)
      place = slot_of(time, pace) - pace%first - first
   end function place_in_set

   !> Number of slots from the set of a time to the next.
   pure elemental real(dp) function slots_of_set(time, pace) result(slots)
      real(dp), intent(in) :: time               !! [s]
      type(pace_t), intent(in) :: pace
      real(dp) :: first
      call find_set(time, pace, first, slots)
      slots = slots - first
   end function slots_of_set

   !> Slots of the set of a time and of the next, from the arrival of a wave on: values settle as it passes, so that early sets are
   !> close to each other.
   pure subroutine find_set(time, pace, first, next)
      real(dp), intent(in) :: time               !! [s]
      type(pace_t), intent(in) :: pace
      real(dp), intent(out) :: first, next
      associate (slot => slot_of(time, pace) - pace%first)
         first = slot - mod(slot, real(from_set_to_set, dp))
         next = first + from_set_to_set
         if (first > 0) return
         next = of_set
         do while (next <= slot)
            first = next
            next = 2*next
         end do
      end associate
   end subroutine find_set

   !> Whether a time is in another slot than the last look at waves.
   pure logical function is_new_slot(arrival, time, pace)
      type(arrival_t), intent(in) :: arrival
      real(dp), intent(in) :: time               !! [s]
      type(pace_t), intent(in) :: pace
      is_new_slot = pace%waves > 0
      if (is_new_slot) is_new_slot = slot_of(time, pace) > arrival%last_look
   end function is_new_slot

   !> Add a value that is the next sample, and find the scatter of the recent ones and their change; these stay where too few lie
   !> within the time in which the right value is nearly linear. Half of what the first ones of a wave differ by is scatter.
   pure elemental subroutine add_recent(recent, time, value, pace)
      type(recent_t), intent(inout) :: recent
      real(dp), intent(in) :: time, value        !! [s]
      type(pace_t), intent(in) :: pace
      real(dp) :: slope
      integer :: n
      if (.not. is_sample(recent, time, pace)) return
      if (pace%in_sets .and. recent%n > 0) then
         if (slot_of(recent%time(recent%n), pace) < pace%first) recent = recent_t()
      end if
      n = samples_before(recent, time, pace)
      if (n == most_recent) then
         recent%time = eoshift(recent%time, 1)
         recent%value = eoshift(recent%value, 1)
         n = n - 1
      end if
      n = n + 1
      recent%n = n
      recent%time(n) = time
      recent%value(n) = value
      n = count(recent%time(:n) >= time - longest*pace%waves)
      if (pace%in_sets .and. recent%n < least_recent) recent%scatter = (maxval(recent%value(:recent%n)) &
                                                                        - minval(recent%value(:recent%n)))/2
      if (n < least_recent) return
      call fit_line(recent%time(recent%n - n + 1:recent%n), recent%value(recent%n - n + 1:recent%n), slope, recent%scatter)
      recent%change = abs(slope)*pace%cells*pace%waves/cells_of_waves
   end subroutine add_recent

   !> The error of a value in motion: that of the cells, at least what it changes in the time to which they know fronts of waves;
   !> and the waves that they cannot carry, or what a tip swings by more slowly than these, which are independent of it.
   pure elemental real(dp) function with_waves(self, of_cells) result(error)
      class(recent_t), intent(in) :: self
      real(dp), intent(in) :: of_cells           !! in the unit of the value
      associate (waves => max(self%scatter, self%swing))
         error = of_cells
         if (max(self%change, waves) > 0) error = hypot(max(of_cells, self%change), waves)
      end associate
   end function with_waves

   !> Follow a value: its error is a part of it, or of the largest so far, and at least `least`; in motion with waves.
   pure elemental subroutine follow(error, value, scale, least, time, pace)
      type(error_t), intent(inout) :: error
      real(dp), intent(in) :: value              !! in the unit of the column, as the next but one
      real(dp), intent(in) :: scale              !! of the relative error [-]
      real(dp), intent(in) :: least
      real(dp), intent(in) :: time               !! [s]
      type(pace_t), intent(in) :: pace
      logical :: counts                          ! whether the value may be the largest so far
      counts = .not. pace%in_sets
      if (.not. counts .and. is_sample(error%recent, time, pace)) counts = place_in_set(time, pace) < 1
      if (counts) error%largest = max(error%largest, abs(value))
      call add_recent(error%recent, time, value, pace)
      error%lasting = max(scale*error%relative*max(abs(value), floor_of_values*error%largest), least, error%recent%change)
      error%now = error%recent%with_waves(error%lasting)
   end subroutine follow

   !> Book the largest value so far as one of the run, or forget what has been tried since the last booking.
   pure elemental subroutine book_largest(error, is_of_run)
      type(error_t), intent(inout) :: error
      logical, intent(in) :: is_of_run
      if (is_of_run) error%booked = error%largest
      error%largest = error%booked
   end subroutine book_largest

   !> Follow the speed of a tip or a front, and find the part of G by which domains are off: they see its waves late, about as shear
   !> waves cross three cells, as G is nearly 1 - v/c of that at rest (Freund 1990, section 6.4); and lumped masses lose some. By
   !> its law G is the toughness.
   pure subroutine follow_speed(seen, speed, wave, toughness, is_lumped, time, pace, is_new, late, kept)
      type(seen_speed_t), intent(inout) :: seen
      real(dp), intent(in) :: speed, wave        !! of the tip, and of Rayleigh waves [m/s]
      real(dp), intent(in) :: toughness          !! 0 at a given speed [J/m2]
      logical, intent(in) :: is_lumped           !! whether it runs through lumped masses, in explicit steps
      real(dp), intent(in) :: time               !! [s]
      type(pace_t), intent(in) :: pace
      logical, intent(in) :: is_new              !! whether a sample is taken
      real(dp), intent(out) :: late              !! the part of G [-]
      real(dp), intent(out) :: kept              !! the part of the last sample in the present value [-]
      real(dp), parameter :: slower = 0.999_dp, cells = 3
      real(dp) :: now
      kept = 0
      if (seen%time >= 0 .and. pace%waves > 0) kept = exp(-(time - seen%time)*cells_of_waves/(cells*pace%waves))
      now = kept*seen%speed + (1 - kept)*min(speed, slower*wave)
      if (is_new) seen = seen_speed_t(time, now)
      late = 0
      if (toughness > 0) return
      late = abs((wave - min(speed, slower*wave))/(wave - now) - 1)
      if (is_lumped) late = late + lost_to_lumping(speed, wave)
   end subroutine follow_speed

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
      if (archive%is_read) call book_largest(errors%j, is_of_run=.true.)
      call archive_recent(errors%j%recent, 'j', archive)
      call archive_seen(errors%seen, archive)
      call archive%archive_reals('apart', modes, errors%apart)
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
      if (archive%is_read) call book_largest(errors, is_of_run=.true.)
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
      call archive%serialise(name//'_scatter', recent%scatter)
      call archive%serialise(name//'_change', recent%change)
   end subroutine archive_recent

   !> Keep the speed of which domains see waves.
   subroutine archive_seen(seen, archive)
      type(seen_speed_t), intent(inout) :: seen
      class(archive_t), intent(inout) :: archive
      call archive%serialise('time_of_speed', seen%time)
      call archive%serialise('speed_seen', seen%speed)
   end subroutine archive_seen

   !> Keep when a wave has arrived.
   subroutine archive_arrival(arrival, archive)
      type(arrival_t), intent(inout) :: arrival
      class(archive_t), intent(inout) :: archive
      call archive%serialise('arrival', arrival%slot)
      call archive%serialise('last_look', arrival%last_look)
      call archive%serialise('rate_at_arrival', arrival%rate)
   end subroutine archive_arrival
end module hampm_estimated_errors
