!> Progress of a run for the user: on a terminal one line that is refreshed, in a file or pipe a line now and then, in the quiet
!> mode nothing.
module hampm_progress
   use, intrinsic :: iso_c_binding, only: c_int
   use, intrinsic :: iso_fortran_env, only: output_unit
   use hampm_kinds, only: dp, long
   use hampm_text, only: to_text, digits_text
   implicit none
   private
   public :: progress_t, standing_t

   real(dp), parameter :: terminal_interval = 0.2_dp   !! least time between two lines on a terminal [s]
   real(dp), parameter :: file_interval = 10.0_dp      !! and in a file or pipe [s]
   real(dp), parameter :: not_there = -huge(1.0_dp)
   integer, parameter :: longest_line = 132            !! characters
   character(*), parameter :: escape = achar(27)
   character(*), parameter :: line_start = achar(13)//escape//'[?7l' !! to the first column; cut long lines, do not wrap
   character(*), parameter :: line_end = escape//'[K'//escape//'[?7h' !! erase the rest; wrap again

   !> The progress shown so far, and its times.
   type :: progress_t
      private
      real(dp) :: end_time = 0.0_dp              !! of the simulation [s]
      logical :: quiet = .true.
      logical :: terminal = .false.
      integer(long) :: clock_start = 0           !! ticks at the start
      integer(long) :: clock_last = 0            !! ticks at the last line
      integer(long) :: clock_rate = 1            !! ticks a second
      logical :: begun = .false.                 !! whether `first_time` and `last_step` are known
      real(dp) :: first_time = 0.0_dp            !! simulated time when this run began [s]: not 0 where one was resumed
      integer(long) :: last_step = 0             !! step of the last line
      real(dp) :: particle_steps = 0.0_dp        !! sum of particles over the steps of this run
   contains
      procedure :: start
      procedure :: show
   end type progress_t

   interface
      integer(c_int) function c_isatty(descriptor) bind(c, name='isatty')
         import :: c_int
         integer(c_int), value :: descriptor
      end function c_isatty
   end interface

   !> State of a run. Values that are `not_there` are not shown.
   type :: standing_t
      real(dp) :: time                           !! simulated time [s]
      integer(long) :: step
      integer :: cells, particles, finest_level
      real(dp) :: energy_residual = not_there    !! error of the energy balance, relative
      real(dp) :: rate = not_there               !! energy release rate of the first tip [J/m2]
      real(dp) :: reference = 0                  !! divisor of `rate`, where above 0 [J/m2]
      real(dp) :: crack_length = not_there       !! of all cracks together, where some grow [m]
      real(dp) :: tip_speed = not_there          !! of the fastest tip, where some grow in motion [m/s]
   end type standing_t

contains

   !> Start the clock; find out whether the standard output is a terminal.
   subroutine start(self, end_time, quiet)
      class(progress_t), intent(out) :: self
      real(dp), intent(in) :: end_time           !! of the simulation [s]
      logical, intent(in) :: quiet               !! print nothing at all
      integer(c_int), parameter :: standard_output = 1
      self%end_time = end_time
      self%quiet = quiet
      self%terminal = c_isatty(standard_output) /= 0
      call system_clock(self%clock_start, self%clock_rate)
      self%clock_last = self%clock_start
   end subroutine start

   !> Print the progress, if the last time was long enough ago. The first call is before the first step; the last call, before any
   !> other output and also when the run has failed, always prints a line.
   subroutine show(self, now, last)
      class(progress_t), intent(inout) :: self
      type(standing_t), intent(in) :: now
      logical, intent(in) :: last
      integer(long) :: clock
      if (self%quiet) return
      if (.not. self%begun) then
         self%first_time = now%time
         self%last_step = now%step
         self%begun = .true.
      end if
      call system_clock(clock)
      if (.not. last .and. seconds_between(self, self%clock_last, clock) < &
          merge(terminal_interval, file_interval, self%terminal)) return
      self%particle_steps = self%particle_steps + real(now%step - self%last_step, dp)*now%particles
      self%last_step = now%step
      call print_line(self, line(self, clock, now))
      self%clock_last = clock
      if (.not. (last .and. self%terminal)) return
      write (output_unit, '(a)') ''
      flush (output_unit)
   end subroutine show

   !> Print a line: over the last one on a terminal, below it elsewhere.
   subroutine print_line(self, text)
      class(progress_t), intent(in) :: self
      character(*), intent(in) :: text
      associate (cut => text(:min(len(text), longest_line)))
         if (self%terminal) then
            write (output_unit, '(a)', advance='no') line_start//cut//line_end
         else
            write (output_unit, '(a)') cut
         end if
      end associate
      flush (output_unit)
   end subroutine print_line

   !> The progress line, in order of importance. Mp/s are millions of particles times steps a second.
   function line(self, clock, now) result(text)
      class(progress_t), intent(in) :: self
      integer(long), intent(in) :: clock
      type(standing_t), intent(in) :: now
      character(:), allocatable :: text, left
      real(dp) :: elapsed
      elapsed = seconds_between(self, self%clock_start, clock)
      left = '-'                                 ! wall time, if the rest takes as long as before
      if (now%time > self%first_time) &
         left = clock_text(elapsed*max(self%end_time - now%time, 0.0_dp)/(now%time - self%first_time))
      text = number(100.0_dp*now%time/self%end_time, '(f12.1)')//'%'
      text = repeat(' ', max(0, 6 - len(text)))//text//' '// &
             in_unit(now%time, self%end_time, ['s ', 'ms', 'us', 'ns'], '(f20.4)')//' '//left//' left'
      if (now%rate > not_there .and. now%reference > 0) then
         text = text//' G/Gref '//number(now%rate/now%reference, '(f12.4)')
      else if (now%rate > not_there) then
         text = text//' G '//digits_text(now%rate, 4)//' J/m2'
      end if
      associate (length => now%crack_length)
         if (length > not_there) text = text//' crack '//in_unit(length, length, ['m ', 'mm', 'um'], &
                                                                 merge('(f20.4)', '(f20.3)', length >= 1))
      end associate
      if (now%tip_speed > not_there) text = text//' at '//to_text(nint(now%tip_speed, long))//' m/s'
      text = text//' step '//to_text(now%step)
      if (now%energy_residual > not_there) text = text//' energy missing '//number(100*now%energy_residual, '(es12.1)')//' %'
      text = text//' cells '//to_text(now%cells)//' particles '//to_text(now%particles)//' level '//to_text(now%finest_level)
      if (elapsed > 0.0_dp) text = text//' '//number(1.0e-6_dp*self%particle_steps/elapsed, '(f12.1)')//' Mp/s'
   end function line

   !> Time between two readings of the clock [s].
   pure real(dp) function seconds_between(self, earlier, later)
      class(progress_t), intent(in) :: self
      integer(long), intent(in) :: earlier, later
      seconds_between = real(later - earlier, dp)/real(self%clock_rate, dp)
   end function seconds_between

   !> A time or a length in the unit that suits it, or another one, as in '0.634 ms'.
   function in_unit(value, suited, units, format) result(text)
      real(dp), intent(in) :: value, suited      !! in the first of the units
      character(*), intent(in) :: units(:)       !! each a thousandth of the one before
      character(*), intent(in) :: format
      character(:), allocatable :: text
      integer :: k
      do k = 1, size(units) - 1
         if (suited*1000.0_dp**(k - 1) >= 1) exit
      end do
      text = number(value*1000.0_dp**(k - 1), format)//' '//trim(units(k))
   end function in_unit

   !> A wall time as h:mm:ss.
   function clock_text(seconds) result(text)
      real(dp), intent(in) :: seconds
      character(:), allocatable :: text
      real(dp), parameter :: longest = 1.0e9_dp  !! 30 years: more is not worth an overflow [s]
      character(32) :: buffer
      integer :: s
      s = nint(min(seconds, longest))
      write (buffer, '(i0,":",i2.2,":",i2.2)') s/3600, mod(s/60, 60), mod(s, 60)
      text = trim(buffer)
   end function clock_text

   !> A real number in the given format, without blanks.
   function number(value, format) result(text)
      real(dp), intent(in) :: value
      character(*), intent(in) :: format
      character(:), allocatable :: text
      character(32) :: buffer
      write (buffer, format) value
      text = trim(adjustl(buffer))
   end function number
end module hampm_progress
