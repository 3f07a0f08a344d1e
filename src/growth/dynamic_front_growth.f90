!> Fronts that grow in motion, of solids only. The state of a crack is that of its points. Fronts change their length and number:
!> points are laid anew at the hats of each measurement, with the speeds of their places and the rest of their crack.
module hampm_dynamic_front_growth
   use hampm_cracks, only: cracks_t
   use hampm_front, only: region_t
   use hampm_front_values, only: front_values_t, between_hats
   use hampm_growing, only: growing_t, growing_point_t, add_once, law_of, prescribed_advance, widths_of
   use hampm_history, only: history_t
   use hampm_kinds, only: dp, ndim
   use hampm_model, only: model_t
   use hampm_moving_front, only: advance_region, fronts_of
   use hampm_moving_tip, only: rayleigh_speed
   use hampm_plane_cuts, only: find_unbonded, open_more
   use hampm_plane_points, only: follow_fronts
   use hampm_problem, only: problem_t
   use hampm_text, only: to_text, three_digits
   implicit none
   private
   public :: lay_points, move_fronts, record_motion

   real(dp), parameter :: standing = 1e-6_dp     !! part of the Rayleigh wave speed below which a front stands still

contains

   !> Lay the points at the hats of fronts that have just been measured.
   pure subroutine lay_points(growing, fronts)
      type(growing_t), intent(inout) :: growing
      type(front_values_t), intent(in) :: fronts(:)
      type(growing_point_t), allocatable :: new(:)
      real(dp) :: state(3)
      integer :: f, j, k, like
      if (size(fronts) == 0) return
      allocate (new(sum([(size(fronts(f)%arc), f=1, size(fronts))])))
      k = 0
      do f = 1, size(fronts)
         associate (front => fronts(f)%domain%front, has_ended => fronts(f)%has_ended)
            like = findloc(growing%points%crack == front%crack .and. .not. growing%points%has_ended, .true., dim=1)
            if (like == 0) like = findloc(growing%points%crack, front%crack, dim=1)
            do j = 1, size(fronts(f)%arc)
               k = k + 1
               new(k) = growing%points(max(1, like))
               new(k)%has_ended = has_ended
               new(k)%has_stopped = new(k)%has_stopped .or. has_ended
               new(k)%is_loose = has_ended
               new(k)%front = merge(0, f, has_ended)
               new(k)%width = 0
               state = 0
               if (.not. has_ended) then
                  new(k)%place = fronts(f)%at(:, j)
                  new(k)%material = fronts(f)%material(j)
                  state = state_there(growing%points, f, front%is_closed, fronts(f)%arc(j)/front%length, new(k)%place)
               end if
               new(k)%is_closed = front%is_closed
               new(k)%speed = state(1)
               new(k)%lagged_speed = state(2)
               new(k)%extension = state(3)
               new(k)%is_running = state(1) > 0
            end do
            if (.not. has_ended) new(k - size(fronts(f)%arc) + 1:k)%width = widths_of(fronts(f))
         end associate
      end do
      call move_alloc(new, growing%points)
   end subroutine lay_points

   !> Speed of a place of a front, that to which its measured G belongs [m/s], and the way that it has grown [m]. If the front is
   !> new, or its place was closed or open before, those of the nearest point.
   pure function state_there(points, number, is_closed, part, x) result(state)
      type(growing_point_t), intent(in) :: points(:)
      integer, intent(in) :: number              !! of the front
      logical, intent(in) :: is_closed
      real(dp), intent(in) :: part               !! of the way along the front [-]
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: state(3), along
      integer :: first, n, k
      state = 0
      n = count(points%front == number .and. (points%is_closed .eqv. is_closed))
      if (n > 0) then
         first = findloc(points%front, number, dim=1)
         along = part*(n - merge(0, 1, is_closed))
         state(1) = between_hats(points(first:first + n - 1)%speed, is_closed, along)
         state(2) = between_hats(points(first:first + n - 1)%lagged_speed, is_closed, along)
         state(3) = between_hats(points(first:first + n - 1)%extension, is_closed, along)
      else if (any(points%front > 0)) then
         k = minloc([(sum((points(k)%place - x)**2), k=1, size(points))], dim=1, mask=points%front > 0)
         state = [points(k)%speed, points(k)%lagged_speed, points(k)%extension]
      end if
   end function state_there

   !> Advance the fronts in a step and release the interface points behind them: after an explicit step, before an implicit one,
   !> which ends in balance with them.
   subroutine move_fronts(growing, model, m, cracks, time, step, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(problem_t), intent(inout) :: m
      type(cracks_t), intent(inout) :: cracks
      real(dp), intent(in) :: time, step         !! at its start [s]
      character(:), allocatable, intent(inout) :: message
      real(dp), allocatable :: advances(:)       ! of the nodes of all fronts of a crack [m]
      real(dp) :: taken(size(model%planes)), work(size(model%planes))
      integer, allocatable :: of(:)              ! points of a crack
      integer :: before(3), now(3), k, j
      logical :: have_moved, meets_itself
      have_moved = .false.
      do k = 1, size(model%planes)
         of = pack([(j, j=1, size(growing%points))], growing%points%crack == k)
         if (.not. any([(growing%is_growing(of(j)), j=1, size(of))])) then
            growing%points(of)%speed = 0
            if (goes_on(m, cracks, k, step)) have_moved = .true.
            cycle
         end if
         call find_advances(growing, model, cracks, k, time, step, advances)
         growing%points(of)%extension = growing%points(of)%extension + growing%points(of)%speed*step
         before = ends_of(cracks, k)
         call advance_region(cracks%regions(k), pack(cracks%fronts, cracks%fronts%crack == k), advances, meets_itself)
         m%grid%planes(k)%region_t = cracks%regions(k)
         have_moved = have_moved .or. any(advances > 0)
         call find_unbonded(m%grid%planes(k), m%grid%forest)
         call fronts_of(cracks%regions, cracks%fronts)
         now = ends_of(cracks, k)
         if (maxval([0.0_dp, advances]) > standing*rayleigh_speed(m%materials(1))*step .and. .not. meets_itself) then
            where (growing%points%crack == k .and. growing%points%onset < 0) growing%points%onset = time
            growing%points(of)%last_motion = time + step
         end if
         associate (name => 'crack '//to_text(k), at => ' at t = '//three_digits(time)//' s')
            if (meets_itself) then
               call growing%stop_points(of, 'its front has met itself around a part that is not cracked', message, name, at)
            else if (now(1) == 0) then
               call growing%stop_points(of, 'has run through'//trim(merge(', or to holes', '             ', &
                                        allocated(cracks%regions(k)%bodies)))//trim(merge(', or to other cracks', repeat(' ', 20), &
                                        size(cracks%regions(k)%cuts) > 0)), message, name, at, have_ended=.true.)
            else if (any(now(:2) /= before(:2))) then
               call add_once(message, name//' has met a side of the material, or its fronts have met', at)
            else if (now(3) > before(3)) then
               call add_once(message, name//' has come to the wall of a hole'//trim(merge(' or to another crack', repeat(' ', 20), &
                                             size(cracks%regions(k)%cuts) > 0))//', and its front ends there', at)
            end if
         end associate
      end do
      if (.not. have_moved) return
      call follow_fronts(m%interfaces, m%matter_t, taken, work)
      m%energies%fracture_energy = m%energies%fracture_energy + sum(taken)
      do k = 1, size(work)
         where (growing%points%crack == k) growing%points%work = growing%points%work + work(k)
      end do
      if (open_more(m%grid%planes, m%grid%forest)) growing%must_cut = .true.
   end subroutine move_fronts

   !> Whether what a crack whose fronts have run through has left behind them still holds: it is released at the speed of Rayleigh
   !> waves, as that of tips.
   logical function goes_on(m, cracks, number, step)
      type(problem_t), intent(inout) :: m
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: step               !! [s]
      integer :: ends(3)
      ends = ends_of(cracks, number)
      goes_on = m%grid%planes(number)%moves .and. ends(1) == 0
      if (goes_on) goes_on = any(m%interfaces%list(:m%interfaces%n)%plane == number .and. &
                                 m%interfaces%list(:m%interfaces%n)%fraction_left > 0)
      if (goes_on) m%grid%planes(number)%beyond = m%grid%planes(number)%beyond + rayleigh_speed(m%materials(1))*step
   end function goes_on

   !> Find the advances of the nodes of all fronts of a crack in a step [m].
   subroutine find_advances(growing, model, cracks, number, time, step, advances)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: time, step         !! [s]
      real(dp), allocatable, intent(out) :: advances(:)
      real(dp) :: given, state(3)
      integer :: law, f, k
      logical :: by_toughness
      law = law_of(model, number, 1, time, step)
      by_toughness = .false.
      if (law > 0) by_toughness = .not. model%growth(law)%law%gives_speed()
      given = prescribed_advance(model, number, 1, time, step)
      if (.not. by_toughness) then
         where (growing%points%crack == number) growing%points%speed = given/step
      end if
      state = 0
      allocate (advances(0))
      do f = 1, size(cracks%fronts)
         associate (front => cracks%fronts(f))
            if (front%crack /= number) cycle
            do k = 1, front%n()
               if (by_toughness) state = state_there(growing%points, f, front%is_closed, front%arc(k)/front%length, front%at(:, k))
               advances = [advances, merge(step*state(1), given, by_toughness)]
            end do
         end associate
      end do
   end subroutine find_advances

   !> Number of fronts of a crack, of those with ends on sides, and of ends at the walls of holes.
   pure function ends_of(cracks, number) result(ends)
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the crack
      integer :: ends(3), f, w
      ends = 0
      do f = 1, size(cracks%fronts)
         associate (front => cracks%fronts(f), walls => cracks%regions(number)%all_walls())
            if (front%crack /= number .or. front%n() == 0) cycle
            ends = ends + [1, merge(0, 1, front%is_closed), &
                           count([(walls(w)%is_hole .and. front%ends_at(walls(w)), w=1, size(walls))])]
         end associate
      end do
   end function ends_of

   !> Record how a crack stands.
   subroutine record_motion(points, region, with_errors, history)
      type(growing_point_t), intent(in) :: points(:) !! of the crack
      type(region_t), intent(in) :: region
      logical, intent(in) :: with_errors         !! whether a law tells speeds by G, whose errors are known
      type(history_t), intent(inout) :: history
      call history%record('crack_area', 'm2', 'area of the crack, in the box around all material', region%cracked_area())
      call history%record('front_speed', 'm/s', 'speed at which its fronts grow, mean', &
                          sum(points%width*points%speed)/max(sum(points%width), tiny(1.0_dp)))
      if (with_errors) call history%record('front_speed_error', 'm/s', 'estimated error of front_speed', &
                                           sum(points%width*points%off_speed)/max(sum(points%width), tiny(1.0_dp)))
      if (with_errors) call history%record('crack_area_error', 'm2', 'estimated error of crack_area at this time', &
                                           sum(points%width*(points%off_way + points%speed*max(0.0_dp, points%onset_error))))
      call history%record('front_speed_largest', 'm/s', 'the largest along them', maxval(points%speed))
   end subroutine record_motion
end module hampm_dynamic_front_growth
