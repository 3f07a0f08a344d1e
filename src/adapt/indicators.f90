!> The table of indicators of refinement.
module hampm_indicators
   use hampm_error_indicator, only: mark_by_error
   use hampm_gradient_indicator, only: mark_by_gradient
   use hampm_indicator, only: indicator_t, indicator_row_t
   use hampm_tip_indicator, only: mark_around_tips
   implicit none
   private
   public :: indicators

contains

   !> All rows.
   pure function indicators() result(rows)
      type(indicator_row_t), allocatable :: rows(:)
      allocate (rows, source=[ &
         indicator_row_t(indicator_t=indicator_t('gradient', 'largest_R', 'largest mean R of the cells in the region', &
                                                 'a larger r_crit', is_of_one_body=.true.), mark=mark_by_gradient), &
         indicator_row_t(indicator_t=indicator_t('zz', 'error_estimate', 'estimated relative error in the energy norm', &
                                                 'a larger tolerance'), mark=mark_by_error), &
         indicator_row_t(indicator_t=indicator_t('tip', advice='fewer rings', reach='rings', is_of_places=.true.), &
                         mark=mark_around_tips)])
   end function indicators
end module hampm_indicators
