!> The keys by which a group tells how something varies with time: history, start, rise_time, frequency, times, factors.
module hampm_history_values
   use hampm_mistakes, only: mistakes_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   use hampm_time_history, only: time_history_t
   implicit none
   private
   public :: fill_history, check_history

contains

   !> Take the values of these keys of one group; 0, '' or empty where they are mistaken.
   pure subroutine fill_history(settings, entry, history)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group
      type(time_history_t), intent(inout) :: history
      history%kind = settings%text(entry, 'history')
      history%start = settings%number(entry, 'start')
      history%rise_time = settings%number(entry, 'rise_time')
      history%frequency = settings%number(entry, 'frequency')
      history%times = settings%numbers(entry, 'times')
      history%factors = settings%numbers(entry, 'factors')
   end subroutine fill_history

   !> A history needs the keys that belong to it.
   pure subroutine check_history(history, entry, settings, mistakes)
      type(time_history_t), intent(in) :: history
      integer, intent(in) :: entry                 !! position of the group
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: n
      if (.not. settings%good(entry, 'history')) return
      select case (history%kind)
       case ('ramp')
         if (settings%good(entry, 'rise_time') .and. history%rise_time <= 0) &
            call settings%complain(mistakes, entry, 'rise_time', 'must be in (0, inf) [s] for history = ''ramp''')
       case ('sine')
         if (settings%good(entry, 'frequency') .and. history%frequency <= 0) &
            call settings%complain(mistakes, entry, 'frequency', 'must be in (0, inf) [Hz] for history = ''sine''')
       case ('table')
         n = size(history%times)
         if (.not. settings%good(entry, 'times')) return
         if (n < 2) then
            call settings%complain(mistakes, entry, 'times', 'must have at least 2 values for history = ''table''')
         else if (any(history%times(2:) <= history%times(:n - 1))) then
            call settings%complain(mistakes, entry, 'times', 'must increase from value to value')
         end if
         if (settings%good(entry, 'factors') .and. size(history%factors) /= n) &
            call settings%complain(mistakes, entry, 'factors', 'must have as many values as times, '//to_text(n)//', not '// &
                                   to_text(size(history%factors)))
      end select
   end subroutine check_history
end module hampm_history_values
