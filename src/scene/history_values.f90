!> The keys by which a group tells how something varies with time: history, start, rise_time, frequency, times, factors.
module hampm_history_values
   use hampm_key_rows, only: key_t, type_real, type_name, may, any_number, not_negative, max_values
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   use hampm_time_history, only: time_history_t
   implicit none
   private
   public :: history_keys, fill_history, check_history

   ! group, which each group puts in, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: history_keys(*) = [ &
      key_t('', 'history', type_name, 1, 1, may, 'step', '', '', &
            'step|ramp|sine|table', &
            'factor over time: 1, rising to 1, sin(2 pi frequency t), or a table; t counts from start'), &
      key_t('', 'start', type_real, 1, 1, may, '0.0', '', 's', &
            any_number, 'time at which the history begins; before it the factor is 0'), &
      key_t('', 'rise_time', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'of a ramp: time in which the factor rises from 0 to 1; needed there'), &
      key_t('', 'frequency', type_real, 1, 1, may, '0.0', '', 'Hz', &
            not_negative, 'of a sine: its frequency; needed there'), &
      key_t('', 'times', type_real, 0, max_values, may, '', '', 's', &
            any_number, 'of a table: increasing, counted from start; linear between, constant outside'), &
      key_t('', 'factors', type_real, 0, max_values, may, '', '', '', &
            any_number, 'of a table: factors at its times, as many as these')]

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

   !> The times of a table increase, and have as many factors.
   pure subroutine check_history(history, entry, settings)
      type(time_history_t), intent(in) :: history
      integer, intent(in) :: entry                 !! position of the group
      type(settings_t), intent(inout) :: settings
      integer :: n
      if (.not. (settings%good(entry, 'history') .and. settings%good(entry, 'times')) .or. history%kind /= 'table') return
      n = size(history%times)
      if (n < 2) then
         call settings%complain(entry, 'times', 'must have at least 2 values for history = ''table''')
      else if (any(history%times(2:) <= history%times(:n - 1))) then
         call settings%complain(entry, 'times', 'must increase from value to value')
      end if
      if (settings%good(entry, 'factors') .and. size(history%factors) /= n) &
         call settings%complain(entry, 'factors', 'must have as many values as times, '//to_text(n)//', not '// &
                                to_text(size(history%factors)))
   end subroutine check_history
end module hampm_history_values
