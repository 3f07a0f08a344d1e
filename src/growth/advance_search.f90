!> Advance by toughness in an implicit step so long that bonded points would fail all at once: G at the end of the step is equal
!> to the toughness. Trials of the step use the rule of false position on G of the trials before (Illinois: the value at an end that
!> stays is halved each time). A tip does not move if G is below the toughness without any advance.
module hampm_advance_search
   use hampm_kinds, only: dp
   use hampm_cracks, only: cracks_t
   use hampm_growing, only: growing_t
   implicit none
   private
   public :: advance_search_t, begin_search, follow_search

   real(dp), parameter :: close_enough = 1e-2_dp !! relative tolerance of G against the toughness
   real(dp), parameter :: same_way = 1e-3_dp     !! ways that differ by less are the same, in cells: G jumps between them
   real(dp), parameter :: usual_fall = 0.1_dp    !! relative decrease of G with an advance of one cell, if unknown
   integer, parameter :: most_trials = 8

   !> Trials of a tip in a step.
   type :: trials_t
      real(dp) :: short = -1, long = huge(1.0_dp) !! ways with which G is above and below the toughness [m]
      real(dp) :: above = 0, below = 0           !! their relative differences of G from the toughness
      real(dp) :: last = -1, of_last = 0         !! the last trial advance, and its relative difference
   end type trials_t

   !> Trials in a step.
   type :: advance_search_t
      type(trials_t), allocatable :: tips(:)
      integer :: trials = 0
   end type advance_search_t

contains

   !> Begin a step: first tips are tried to go as fast as in the last one.
   subroutine begin_search(growing, dt, search)
      type(growing_t), intent(inout) :: growing
      real(dp), intent(in) :: dt                 !! of the step [s]
      type(advance_search_t), intent(out) :: search
      growing%points%trial = growing%points%speed*dt
      allocate (search%tips(size(growing%points)))
   end subroutine begin_search

   !> After a trial: choose the next advances. `is_over`: none are needed.
   subroutine follow_search(search, growing, cracks, dt, is_over)
      type(advance_search_t), intent(inout) :: search
      type(growing_t), intent(inout) :: growing
      type(cracks_t), intent(in) :: cracks
      real(dp), intent(in) :: dt                 !! of the step [s]
      logical, intent(out) :: is_over
      integer :: k
      search%trials = search%trials + 1
      is_over = .true.
      do k = 1, size(growing%points)
         if (.not. (growing%points(k)%is_running .and. growing%is_growing(k))) cycle
         associate (way => growing%points(k)%speed*dt, off => growing%points(k)%excess, cell => cracks%tips(k)%nodes%spacing)
            call note(search%tips(k), way, off, cell, growing%points(k)%fall)
            if (abs(off) <= close_enough .or. off > 0 .and. growing%points(k)%is_held .or. off < 0 .and. .not. way > 0) cycle
            if (search%tips(k)%long - search%tips(k)%short < same_way*cell) cycle
            associate (tried => search%tips(k))
               growing%points(k)%trial = max(0.0_dp, way + off/growing%points(k)%fall)
               if (tried%short >= 0 .and. tried%long < huge(1.0_dp)) &
                  growing%points(k)%trial = tried%short + (tried%long - tried%short)*tried%above/(tried%above + tried%below)
            end associate
            is_over = .false.
         end associate
      end do
      is_over = is_over .or. search%trials == most_trials
   end subroutine follow_search

   !> Record G of a trial advance.
   subroutine note(tried, way, off, cell, fall)
      type(trials_t), intent(inout) :: tried
      real(dp), intent(in) :: way                !! [m]
      real(dp), intent(in) :: off                !! relative excess of G over the toughness
      real(dp), intent(in) :: cell               !! [m]
      real(dp), intent(inout) :: fall            !! of G with the way, as parts of the toughness [1/m]
      if (.not. fall > 0) fall = usual_fall/cell
      if (tried%last >= 0 .and. abs(way - tried%last) > same_way*cell) then
         associate (slope => (tried%of_last - off)/(way - tried%last))
            fall = min(max(slope, fall/4), 4*fall)
         end associate
      end if
      if (off > 0) then
         if (tried%of_last > 0) tried%below = tried%below/2
         tried%short = way
         tried%above = off
      else
         if (tried%of_last < 0) tried%above = tried%above/2
         tried%long = way
         tried%below = -off
      end if
      tried%last = way
      tried%of_last = off
   end subroutine note
end module hampm_advance_search
