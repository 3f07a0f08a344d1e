!> How a load or a prescribed motion varies with time: a factor for its force or its displacement.
module hampm_time_history
   use hampm_kinds, only: dp, name_len
   implicit none
   private
   public :: time_history_t, most_chords

   real(dp), parameter :: pi = acos(-1.0_dp)
   integer, parameter :: most_chords = 10000     !! straight pieces by which modes follow a history from row to row, at most

   !> A factor as a function of time.
   type :: time_history_t
      character(name_len) :: kind = 'step'       !! 'step', 'ramp', 'smooth_ramp', 'sine' or 'table'
      real(dp) :: start = 0                      !! before this time the factor is zero [s]
      real(dp) :: rise_time = 0                  !! time in which a ramp, of either kind, rises from 0 to 1 [s]
      real(dp) :: frequency = 0                  !! of a sine [Hz]
      real(dp), allocatable :: times(:)          !! of a table, after `start`, ascending [s]
      real(dp), allocatable :: factors(:)        !! of a table [-]
      real(dp) :: scale = 1                      !! factor of the whole history [-]
      logical :: held = .false.                  !! whether `scale` stays where loads of quasi-static growth are scaled
   contains
      procedure :: scale_to
      procedure :: factor
      procedure :: integral
      procedure :: time_to_constant
      procedure :: end_of_line
      procedure :: largest_factor
   end type time_history_t

contains

   !> Multiply all of it from now on, unless it is held.
   elemental subroutine scale_to(self, scale)
      class(time_history_t), intent(inout) :: self
      real(dp), intent(in) :: scale              !! relative to the input, not to the present scale [-]
      if (.not. self%held) self%scale = scale
   end subroutine scale_to

   !> The factor at a time [-].
   pure real(dp) function factor(self, time)
      class(time_history_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      real(dp) :: t
      t = time - self%start
      factor = 0
      if (t < 0) return
      select case (self%kind)
      case ('step')
         factor = 1
      case ('ramp')
         factor = min(t/self%rise_time, 1.0_dp)
      case ('smooth_ramp')
         factor = smooth_step(min(t/self%rise_time, 1.0_dp))
      case ('sine')
         factor = sin(2*pi*self%frequency*t)
      case ('table')
         factor = interpolate(self%times, self%factors, t)
      end select
      factor = self%scale*factor
   end function factor

   !> Integral of the factor from its start, or the start of the run if that is later, to a time [s].
   pure real(dp) function integral(self, time)
      class(time_history_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      real(dp) :: t, early, a, b
      integer :: k
      t = time - self%start
      early = max(0.0_dp, -self%start)           ! duration of a history before the start of the run [s]
      integral = 0
      if (t <= early) return
      select case (self%kind)
      case ('step')
         integral = t - early
      case ('ramp')
         integral = ramp_integral(self%rise_time, t) - ramp_integral(self%rise_time, early)
      case ('smooth_ramp')
         integral = smooth_integral(self%rise_time, t) - smooth_integral(self%rise_time, early)
      case ('sine')
         integral = (cos(2*pi*self%frequency*early) - cos(2*pi*self%frequency*t))/(2*pi*self%frequency)
      case ('table')
         a = early
         do k = 1, size(self%times) + 1          ! from corner to corner of the table
            b = t
            if (k <= size(self%times)) b = min(t, max(early, self%times(k)))
            integral = integral + (b - a)*(interpolate(self%times, self%factors, a) &
                                           + interpolate(self%times, self%factors, b))/2
            if (b >= t) exit
            a = b
         end do
      end select
      integral = self%scale*integral
   end function integral

   !> Integral of a ramp from 0 [s].
   pure real(dp) function ramp_integral(rise_time, t)
      real(dp), intent(in) :: rise_time, t       !! [s]
      ramp_integral = min(t, rise_time)**2/(2*rise_time) + max(0.0_dp, t - rise_time)
   end function ramp_integral

   !> From 0 at 0 to 1 at 1, with first and second derivatives of 0 at both: 10 x**3 - 15 x**4 + 6 x**5.
   pure real(dp) function smooth_step(x)
      real(dp), intent(in) :: x                  !! 0 to 1
      smooth_step = x**3*(10 - x*(15 - 6*x))
   end function smooth_step

   !> Integral of a smooth ramp from 0 [s].
   pure real(dp) function smooth_integral(rise_time, t)
      real(dp), intent(in) :: rise_time, t       !! [s]
      real(dp) :: x
      x = min(t/rise_time, 1.0_dp)
      smooth_integral = rise_time*x**4*(2.5_dp - x*(3 - x)) + max(0.0_dp, t - rise_time)
   end function smooth_integral

   !> Time from which on the factor is constant; huge if it never is [s].
   pure real(dp) function time_to_constant(self) result(time)
      class(time_history_t), intent(in) :: self
      time = self%start
      select case (self%kind)
      case ('ramp', 'smooth_ramp')
         time = time + self%rise_time
      case ('sine')
         time = huge(time)
      case ('table')
         time = time + self%times(size(self%times))
      end select
   end function time_to_constant

   !> Time up to which the factor is a straight line from a time on: its next corner or jump, on a curve the end of a chord, which
   !> is off by at most 2e-5 of its largest value; huge where no corner follows [s].
   elemental real(dp) function end_of_line(self, time) result(end)
      class(time_history_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      integer, parameter :: chords = 500         ! of a rise, or a period
      integer :: k
      end = huge(end)
      if (time < self%start) then
         end = self%start
         return
      end if
      select case (self%kind)
      case ('ramp')
         if (time < self%start + self%rise_time) end = self%start + self%rise_time
      case ('smooth_ramp')
         if (time < self%start + self%rise_time) end = min(self%start + self%rise_time, time + self%rise_time/chords)
      case ('sine')
         end = time + 1/(chords*self%frequency)
      case ('table')
         k = count(self%start + self%times <= time) + 1
         if (k <= size(self%times)) end = self%start + self%times(k)
      end select
   end function end_of_line

   !> Factor of largest magnitude, with its sign, without `scale` [-].
   pure real(dp) function largest_factor(self)
      class(time_history_t), intent(in) :: self
      largest_factor = 1
      if (self%kind == 'table') largest_factor = self%factors(maxloc(abs(self%factors), dim=1))
   end function largest_factor

   !> Piecewise linear interpolation, constant outside the table.
   pure real(dp) function interpolate(x, y, at)
      real(dp), intent(in) :: x(:)               !! ascending
      real(dp), intent(in) :: y(:)
      real(dp), intent(in) :: at
      integer :: k, beyond, middle
      k = 0                                      ! the last corner that is not beyond it, by bisection
      beyond = size(x) + 1
      do while (beyond - k > 1)
         middle = (k + beyond)/2
         if (x(middle) <= at) then
            k = middle
         else
            beyond = middle
         end if
      end do
      if (k == 0) then
         interpolate = y(1)
      else if (k == size(x)) then
         interpolate = y(k)
      else
         interpolate = y(k) + (y(k + 1) - y(k))*(at - x(k))/(x(k + 1) - x(k))
      end if
   end function interpolate
end module hampm_time_history
