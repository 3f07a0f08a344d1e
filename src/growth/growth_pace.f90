!> How far tips grow by a toughness in a step that is implicit, so long that cohesive points would fail all at once: as far as G, at the end of the step,
!> is the toughness. The step is tried with one way after the other, each found by the rule of false position from what G was with those before
!> (the value at an end that stays halved each time: Illinois). A tip rests where G is below the toughness with no way at all.
module hampm_growth_pace
   use hampm_kinds, only: dp
   use hampm_cracks, only: cracks_t
   use hampm_growing, only: growing_t
   implicit none
   private
   public :: pace_t, begin_pace, follow_pace

   real(dp), parameter :: close_enough = 1e-2_dp !! part by which G may be off the toughness
   real(dp), parameter :: same_way = 1e-3_dp     !! ways that differ by less are the same, in cells: G jumps between them
   real(dp), parameter :: usual_fall = 0.1_dp    !! part by which G falls with the way of a cell, where that is not known
   integer, parameter :: most_trials = 8

   !> What has been tried in a step. (tips)
   type :: pace_t
      real(dp), allocatable :: short(:), long(:) !! ways with which G is above and below the toughness [m]
      real(dp), allocatable :: above(:), below(:) !! by how much it is, as a part of it
      real(dp), allocatable :: last(:), of_last(:) !! the way tried last, and by how much it was off then
      integer :: trials = 0
   end type pace_t

contains

   !> Begin a step: first tips are tried to go as fast as in the last one.
   subroutine begin_pace(growing, dt, pace)
      type(growing_t), intent(inout) :: growing
      real(dp), intent(in) :: dt                 !! of the step [s]
      type(pace_t), intent(out) :: pace
      growing%way = growing%speed*dt
      allocate (pace%short(size(growing%way)), pace%last(size(growing%way)), source=-1.0_dp)
      allocate (pace%long(size(growing%way)), source=huge(1.0_dp))
      allocate (pace%above(size(growing%way)), pace%below(size(growing%way)), pace%of_last(size(growing%way)), source=0.0_dp)
   end subroutine begin_pace

   !> After a trial: choose the ways of the next one. `is_over` tells that none is needed.
   subroutine follow_pace(pace, growing, cracks, dt, is_over)
      type(pace_t), intent(inout) :: pace
      type(growing_t), intent(inout) :: growing
      type(cracks_t), intent(in) :: cracks
      real(dp), intent(in) :: dt                 !! of the step [s]
      logical, intent(out) :: is_over
      integer :: k
      pace%trials = pace%trials + 1
      is_over = .true.
      do k = 1, size(growing%way)
         if (.not. (growing%is_running(k) .and. growing%is_growing(k))) cycle
         associate (way => growing%speed(k)*dt, off => growing%excess(k), cell => cracks%tips(k)%nodes%spacing)
            call note(pace, k, way, off, cell, growing%fall(k))
            if (abs(off) <= close_enough .or. off > 0 .and. growing%is_held(k) .or. off < 0 .and. .not. way > 0) cycle
            if (pace%long(k) - pace%short(k) < same_way*cell) cycle
            growing%way(k) = next_way(pace, k, way, off, growing%fall(k))
            is_over = .false.
         end associate
      end do
      is_over = is_over .or. pace%trials == most_trials
   end subroutine follow_pace

   !> Note what G was with a way.
   subroutine note(pace, k, way, off, cell, fall)
      type(pace_t), intent(inout) :: pace
      integer, intent(in) :: k                   !! tip
      real(dp), intent(in) :: way                !! [m]
      real(dp), intent(in) :: off                !! by how much G is above the toughness, as a part of it
      real(dp), intent(in) :: cell               !! [m]
      real(dp), intent(inout) :: fall            !! of G with the way, as parts of the toughness [1/m]
      if (.not. fall > 0) fall = usual_fall/cell
      if (pace%last(k) >= 0 .and. abs(way - pace%last(k)) > same_way*cell) then
         associate (slope => (pace%of_last(k) - off)/(way - pace%last(k)))
            fall = min(max(slope, fall/4), 4*fall)
         end associate
      end if
      if (off > 0) then
         if (pace%of_last(k) > 0) pace%below(k) = pace%below(k)/2
         pace%short(k) = way
         pace%above(k) = off
      else
         if (pace%of_last(k) < 0) pace%above(k) = pace%above(k)/2
         pace%long(k) = way
         pace%below(k) = -off
      end if
      pace%last(k) = way
      pace%of_last(k) = off
   end subroutine note

   !> The way to be tried next [m].
   pure real(dp) function next_way(pace, k, way, off, fall) result(next)
      type(pace_t), intent(in) :: pace
      integer, intent(in) :: k                   !! tip
      real(dp), intent(in) :: way, off, fall     !! [m], part of the toughness, part of it for a way [1/m]
      if (pace%short(k) >= 0 .and. pace%long(k) < huge(1.0_dp)) then
         next = pace%short(k) + (pace%long(k) - pace%short(k))*pace%above(k)/(pace%above(k) + pace%below(k))
      else
         next = max(0.0_dp, way + off/fall)
      end if
   end function next_way
end module hampm_growth_pace
