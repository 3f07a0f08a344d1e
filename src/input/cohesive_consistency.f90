!> Whether faces can hold each other by cohesion as a model asks for.
module hampm_cohesive_consistency
   use hampm_kinds, only: dp
   use hampm_crack_lines, only: length_of
   use hampm_model, only: model_t
   use hampm_settings, only: settings_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: check_cohesive

contains

   !> Check all groups &cohesive.
   pure subroutine check_cohesive(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer :: k, entry
      do k = 1, size(model%cohesive)
         entry = settings%find('cohesive', k)
         associate (path => model%cohesive(k)%path)
            if (path == 0 .and. model%cohesive(k)%crack /= '') then
               call settings%complain(entry, 'crack', 'there is no &crack of this name')
            else if (path > 0) then
               if (any(model%growth%path == path)) &
                  call settings%complain(entry, 'crack', 'is the crack of a &growth: choose another crack')
               if (any(model%cohesive(:k - 1)%path == path)) &
                  call settings%complain(entry, 'crack', 'is the crack of another &cohesive: choose another crack')
               if (model%cohesive(k)%from > max(length_of(model%paths(path)%points) - model%grid%cell, 0.0_dp)) &
                  call settings%complain(entry, 'from', 'must be less than the length of the crack, '// &
                                         to_text(length_of(model%paths(path)%points))//' m, by a cell at least')
            end if
         end associate
         call check_curve(model, settings, k, entry)
      end do
   end subroutine check_cohesive

   !> Check the curve of the k-th: with a traction that would grow faster than its opening, damage would heal.
   pure subroutine check_curve(model, settings, k, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: k
      integer, intent(in) :: entry
      logical :: is_table
      is_table = settings%text(entry, 'law') == 'table'
      associate (o => model%cohesive(k)%openings, t => model%cohesive(k)%tractions, n => size(model%cohesive(k)%openings))
         if (n /= size(t)) then
            call settings%complain(entry, 'tractions', 'must be as many as there are openings')
         else if (n < 2) then
            if (n == 1) call settings%complain(entry, 'openings', 'must be two at least')
         else if (any(o(2:) <= o(:n - 1)) .and. t(1) > 0) then
            call settings%complain(entry, trim(merge('openings', 'opening ', is_table)), &
                                   'must ascend to where faces have parted, '//to_text(o(n))//' m')
         else if (any(t(:n - 1) <= 0) .or. t(n) > 0) then
            if (is_table) call settings%complain(entry, 'tractions', 'must be above 0, but the last, which is 0')
         else if (any(t(2:)*o(:n - 1) >= t(:n - 1)*o(2:))) then ! that it gives way, o(1)/t(1)*t, cancels
            call settings%complain(entry, 'tractions', 'must rise less than the openings do, as damage cannot heal: '// &
                                   'traction over opening falls from point to point, without what the first point gives way')
         end if
      end associate
   end subroutine check_curve
end module hampm_cohesive_consistency
