!> Time resolution of loads and prescribed motions: changes between two steps have no effect.
module hampm_history_resolution
   use hampm_kinds, only: dp
   use hampm_largest_step, only: chosen_speed, smallest_cell
   use hampm_model, only: model_t
   use hampm_settings, only: settings_t
   use hampm_text, only: add_line, to_text, three_digits
   use hampm_time_history, only: time_history_t, most_chords
   implicit none
   private
   public :: check_resolution, coarse_histories, begins_too_late

   ! A sine that is constant over each of n steps a period has work and amplitude off by (2 pi/n)**2/12: 3.3 % at 10, 0.8 % at 20
   real(dp), parameter :: least_steps = 10       !! of a period, in motion
   real(dp), parameter :: good_steps = 20        !! of a period, without a warning
   real(dp), parameter :: none = -huge(1.0_dp)   !! no such time
   real(dp), parameter :: most_missed = 0.5_dp   !! excess of a peak over its value at steps, as a part of the largest factor

contains

   !> Refuse a sine that the steps of a motion do not resolve: they would see another one.
   subroutine check_resolution(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer :: k
      if (model%method%time == 'static') return
      do k = 1, size(model%loads)
         call check_sine(model, settings, 'load', k, model%loads(k)%history)
      end do
      do k = 1, size(model%constraints)
         call check_sine(model, settings, 'constraint', k, model%constraints(k)%motion%history)
      end do
   end subroutine check_resolution

   !> Check one of them.
   subroutine check_sine(model, settings, group, number, history)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      character(*), intent(in) :: group
      integer, intent(in) :: number
      type(time_history_t), intent(in) :: history
      character(:), allocatable :: key
      integer :: entry
      entry = settings%find(group, number)
      if (history%kind /= 'sine' .or. .not. settings%good(entry, 'frequency')) return
      associate (dt => longest_step_of(model))
         if (history%frequency*dt*least_steps <= 1) return
         key = '&method courant'
         if (model%method%time_step > 0) key = '&method time_step'
         if (model%method%time == 'modal') key = '&output history_interval'
         call settings%complain(entry, 'frequency', 'must be at most '//to_text(1/(least_steps*dt))//' [Hz], not '// &
                                to_text(history%frequency)//', with time steps of '//three_digits(dt)//' s: '// &
                                three_digits(1/(history%frequency*dt))//' of them to a period do not resolve it, '// &
                                to_text(nint(least_steps))//' do. Reduce it or '//key)
      end associate
   end subroutine check_sine

   !> Histories of a model that its steps resolve hardly or not, a line each; '' for none.
   function coarse_histories(model) result(text)
      type(model_t), intent(in) :: model
      character(:), allocatable :: text
      integer :: k
      text = ''
      do k = 1, size(model%loads)
         call check_history(model, '&load '//to_text(k), model%loads(k)%history, longest_step_of(model), text)
      end do
      do k = 1, size(model%constraints)
         call check_history(model, '&constraint '//to_text(k), model%constraints(k)%motion%history, longest_step_of(model), text)
      end do
      if (model%control%leads()) call check_history(model, '&control', model%control%history, longest_step_of(model), text)
   end function coarse_histories

   !> Check one history.
   pure subroutine check_history(model, name, history, dt, text)
      type(model_t), intent(in) :: model
      character(*), intent(in) :: name
      type(time_history_t), intent(in) :: history
      real(dp), intent(in) :: dt                 !! [s]
      character(:), allocatable, intent(inout) :: text
      character(:), allocatable :: line
      real(dp) :: peak                           ! [s]
      line = ''
      if (begins_too_late(model, history%start)) then
         line = name//': its history begins at '//to_text(history%start)//' s, and the run ends at '// &
                to_text(model%run%end_time)//' s: it does nothing'
      else if (history%kind == 'sine') then
         if (history%frequency*dt*good_steps <= 1) return
         line = name//': steps of '//three_digits(dt)//' s take '//three_digits(1/(history%frequency*dt))// &
                ' points of a period of its sine of '//to_text(history%frequency)// &
                   ' Hz: load values between these points have no effect. '// &
                'Take '//to_text(nint(good_steps))//' or more'
      else if (history%kind == 'table' .and. acts_too_long(model, history, dt)) then
         line = name//': its factor of '//to_text(history%factor(0.0_dp))//' at the start acts for a whole step of '// &
                three_digits(dt)//' s, and is there for less than half of it. Take shorter steps, or leave it out'
      else if (history%kind == 'table') then
         peak = missed_peak(history, dt, model%method%time == 'static')
         if (peak <= none) return
         line = name//': steps of '//three_digits(dt)//' s may pass by its factor at '// &
                three_digits(peak)//' s, which is there for less than two of them'
      end if
      if (line /= '') call add_line(text, line)
   end subroutine check_history

   !> Whether the initial factor of a motion, held for the first step, exceeds the impulse of a table there. In static steps, and
   !> where motion begins from equilibrium, it is the factor of the initial equilibrium.
   pure logical function acts_too_long(model, history, dt)
      type(model_t), intent(in) :: model
      type(time_history_t), intent(in) :: history
      real(dp), intent(in) :: dt                 !! [s]
      acts_too_long = model%method%time /= 'static' .and. model%method%start /= 'static' .and. &
                      abs(history%factor(0.0_dp)) - abs(history%integral(dt))/dt > most_missed*maxval(abs(history%factors))
   end function acts_too_long

   !> Whether a load that begins at a time never acts: the last static load step is at the end of the run, a dynamic step before it.
   pure logical function begins_too_late(model, start)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: start              !! [s]
      begins_too_late = start > model%run%end_time .or. &
                        (model%method%time /= 'static' .and. start >= model%run%end_time)
   end function begins_too_late

   !> The longest step that a run can take at first [s]. Explicit ones end at rows.
   real(dp) function longest_step_of(model) result(dt)
      type(model_t), intent(in) :: model
      if (model%method%time == 'static' .or. model%method%time == 'modal') then
         dt = model%run%end_time/max(model%method%load_steps, 1)
         if (model%method%time == 'modal') dt = min(model%output%history_interval, model%run%end_time)/most_chords
         return
      end if
      dt = model%method%time_step
      if (.not. dt > 0) dt = model%method%courant*smallest_cell(model)/chosen_speed(model)
      if (model%method%time == 'explicit' .and. model%output%history_interval > 0) dt = min(dt, model%output%history_interval)
   end function longest_step_of

   !> Time of a corner of a table, from its start, whose factor is far from that one step before, or at the beginning of the run,
   !> and one step after it; `none` for none [s]. If times of steps are known, far from the values at the two around it.
   pure real(dp) function missed_peak(history, dt, are_known) result(time)
      type(time_history_t), intent(in) :: history
      real(dp), intent(in) :: dt                 !! [s]
      logical, intent(in) :: are_known           !! whether steps are at the multiples of dt
      real(dp), parameter :: rounding = 1e-9_dp  ! part of a step
      real(dp) :: beside(2), largest
      integer :: k
      time = none
      largest = maxval(abs(history%factors))
      do k = 1, size(history%times) - 1
         associate (at => history%start + history%times(k))
            if (at <= 0) cycle
            beside = [max(at - dt, 0.0_dp), at + dt]
            if (are_known) then
               if (abs(at/dt - anint(at/dt)) <= rounding) cycle
               beside = dt*[aint(at/dt), aint(at/dt) + 1]
            end if
            beside = [history%factor(beside(1)), history%factor(beside(2))]
         end associate
         if (history%factors(k) - maxval(beside) <= most_missed*largest .and. &
             minval(beside) - history%factors(k) <= most_missed*largest) cycle
         time = history%times(k)
         return
      end do
   end function missed_peak
end module hampm_history_resolution
