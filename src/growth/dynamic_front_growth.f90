!> Points along fronts that grow in motion, of solids only. Fronts change their length and number: the points are laid anew at the
!> hats of each measurement, with the speeds of their places.
module hampm_dynamic_front_growth
   use hampm_cracks, only: cracks_t
   use hampm_front_values, only: front_values_t, between_hats
   use hampm_growing, only: growing_t, growing_point_t, law_of, prescribed_advance
   use hampm_kinds, only: dp, ndim
   use hampm_model, only: model_t
   implicit none
   private
   public :: lay_points, advances_of_nodes

contains

   !> Lay the points at the hats of fronts that have just been measured.
   pure subroutine lay_points(growing, fronts)
      type(growing_t), intent(inout) :: growing
      type(front_values_t), intent(in) :: fronts(:)
      type(growing_point_t), allocatable :: new(:)
      real(dp) :: speeds(2)
      integer :: f, j, k
      allocate (new(sum([(size(fronts(f)%arc), f=1, size(fronts))])))
      k = 0
      do f = 1, size(fronts)
         associate (front => fronts(f)%domain%front)
            do j = 1, size(fronts(f)%arc)
               k = k + 1
               new(k)%crack = front%crack
               new(k)%has_ended = fronts(f)%has_ended
               new(k)%grows = growing%planes(front%crack)%grows
               new(k)%has_stopped = growing%planes(front%crack)%has_stopped .or. new(k)%has_ended
               if (new(k)%has_ended) cycle
               new(k)%front = f
               new(k)%is_closed = front%is_closed
               new(k)%place = fronts(f)%at(:, j)
               new(k)%material = fronts(f)%material(j)
               speeds = speeds_there(growing%points, f, front%is_closed, fronts(f)%arc(j)/front%length, new(k)%place)
               new(k)%speed = speeds(1)
               new(k)%lagged_speed = speeds(2)
               new(k)%is_running = speeds(1) > 0
            end do
         end associate
      end do
      call move_alloc(new, growing%points)
   end subroutine lay_points

   !> Speed of a place of a front, and that to which its measured G belongs [m/s]; if the front is new, or its place was closed or
   !> open before, those of the nearest point.
   pure function speeds_there(points, number, is_closed, part, x) result(speeds)
      type(growing_point_t), intent(in) :: points(:)
      integer, intent(in) :: number              !! of the front
      logical, intent(in) :: is_closed
      real(dp), intent(in) :: part               !! of the way along the front [-]
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: speeds(2), along
      integer :: first, n, k
      speeds = 0
      n = count(points%front == number .and. (points%is_closed .eqv. is_closed))
      if (n > 0) then
         first = findloc(points%front, number, dim=1)
         along = part*(n - merge(0, 1, is_closed))
         speeds(1) = between_hats(points(first:first + n - 1)%speed, is_closed, along)
         speeds(2) = between_hats(points(first:first + n - 1)%lagged_speed, is_closed, along)
      else if (any(points%front > 0)) then
         k = minloc([(sum((points(k)%place - x)**2), k=1, size(points))], dim=1, mask=points%front > 0)
         speeds = [points(k)%speed, points(k)%lagged_speed]
      end if
   end function speeds_there

   !> Advances of the nodes of all fronts of a crack in a step [m].
   function advances_of_nodes(growing, model, cracks, number, time, step) result(advances)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: time, step         !! [s]
      real(dp), allocatable :: advances(:)
      real(dp) :: given, speeds(2)
      integer :: law, f, k
      logical :: by_toughness
      law = law_of(model, number, 1, time, step)
      by_toughness = .false.
      if (law > 0) by_toughness = .not. model%growth(law)%law%gives_speed()
      given = prescribed_advance(model, number, 1, time, step)
      speeds = 0
      allocate (advances(0))
      do f = 1, size(cracks%fronts)
         associate (front => cracks%fronts(f))
            if (front%crack /= number) cycle
            do k = 1, front%n()
               if (by_toughness) speeds = speeds_there(growing%points, f, front%is_closed, front%arc(k)/front%length, &
                                                       front%at(:, k))
               advances = [advances, merge(step*speeds(1), given, by_toughness)]
            end do
         end associate
      end do
   end function advances_of_nodes
end module hampm_dynamic_front_growth
