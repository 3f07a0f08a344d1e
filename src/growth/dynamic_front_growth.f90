!> How fronts of cracks in planes grow in motion, of solids only: each node of a front at its own speed, by law = toughness that of
!> `hampm_equation_of_motion` for the G and the toughness of its place.
module hampm_dynamic_front_growth
   use hampm_archive, only: archive_t
   use hampm_crack_placement, only: take_toughness
   use hampm_cracks, only: cracks_t
   use hampm_equation_of_motion, only: speed_by_toughness, followed
   use hampm_front, only: region_t
   use hampm_front_values, only: front_values_t, between_hats
   use hampm_history, only: history_t
   use hampm_kinds, only: dp, ndim
   use hampm_material, only: material_t
   use hampm_model, only: model_t
   use hampm_moving_tip, only: rayleigh_speed
   use hampm_text, only: add_line, to_text, three_digits
   use hampm_toughness, only: advance_t
   implicit none
   private
   public :: growing_front_t, growing_plane_t, new_growing_planes, law_of_plane, ways_of_fronts, find_speeds, note_state, &
             record_plane, archive_planes

   real(dp), parameter :: standing = 1e-6_dp     !! part of the Rayleigh wave speed below which a front stands still

   !> A front, as it was measured last.
   type :: growing_front_t
      logical :: is_closed = .false.
      real(dp), allocatable :: speed(:)          !! of its hats, none of one that has ended [m/s]
      real(dp), allocatable :: felt(:)           !! those to which the measured G belongs [m/s]
      real(dp), allocatable :: at(:, :)          !! their places then [m], (ndim, hats)
   end type growing_front_t

   !> A crack in a plane.
   type :: growing_plane_t
      logical :: grows = .false.                 !! whether there is a &growth for it
      logical :: has_stopped = .false.           !! whether it has stopped permanently
      logical :: is_running = .false.            !! whether some of its front has moved in the last step
      integer :: fronts = 0                      !! how many it had then
      integer :: open_ends = 0                   !! of which had ends on sides
      logical :: is_at_hole = .false.            !! whether one of these is at the wall of a hole
      real(dp) :: onset = -1                     !! when it began to move; below 0: it has not [s]
      real(dp) :: last_motion = -1               !! when it moved last [s]
      real(dp) :: mean = 0, largest = 0          !! of the speed of its fronts in the last step [m/s]
   end type growing_plane_t

contains

   !> The growth state of fronts in a dynamic model.
   subroutine new_growing_planes(model, cracks, planes, fronts)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(growing_plane_t), allocatable, intent(out) :: planes(:)
      type(growing_front_t), allocatable, intent(out) :: fronts(:)
      integer :: k
      allocate (planes(size(model%planes)), fronts(0))
      do k = 1, size(planes)
         planes(k)%grows = any(model%growth%path == k)
         planes(k)%fronts = count(cracks%fronts%crack == k)
         planes(k)%open_ends = count(cracks%fronts%crack == k .and. .not. cracks%fronts%is_closed)
         planes(k)%is_at_hole = ends_at_hole(cracks, k)
      end do
   end subroutine new_growing_planes

   !> Number of the &growth that applies to a crack at a time, the last one in a step from there on; 0 for none.
   pure integer function law_of_plane(model, planes, number, time, step) result(law)
      type(model_t), intent(in) :: model
      type(growing_plane_t), intent(in) :: planes(:)
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: time, step         !! [s]
      integer :: k
      law = 0
      if (planes(number)%has_stopped) return
      do k = 1, size(model%growth)
         associate (growth => model%growth(k))
            if (growth%path == number .and. time + step*(1 - 1e-9_dp) >= growth%start .and. time < growth%end) law = k
         end associate
      end do
   end function law_of_plane

   !> Ways of the nodes of all fronts of a crack in a step [m].
   function ways_of_fronts(model, cracks, planes, fronts, number, time, step) result(ways)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(growing_plane_t), intent(in) :: planes(:)
      type(growing_front_t), intent(in) :: fronts(:)
      integer, intent(in) :: number              !! of the crack
      real(dp), intent(in) :: time, step         !! [s]
      real(dp), allocatable :: ways(:)
      integer :: law, f, k
      real(dp) :: given
      given = 0
      if (.not. planes(number)%has_stopped) then
         do k = 1, size(model%growth)
            associate (growth => model%growth(k))
               if (growth%path /= number .or. .not. growth%law%gives_speed()) cycle
               associate (from => max(time, growth%start), to => min(time + step, growth%end))
                  given = given + growth%speed_at((from + to)/2)*max(0.0_dp, to - from)
               end associate
            end associate
         end do
      end if
      law = law_of_plane(model, planes, number, time, step)
      allocate (ways(0))
      do f = 1, size(cracks%fronts)
         associate (front => cracks%fronts(f))
            if (front%crack /= number) cycle
            if (law > 0 .and. size(fronts) > 0) then
               if (.not. model%growth(law)%law%gives_speed()) then
                  ways = [ways, (step*speed_there(fronts, f, front%is_closed, front%arc(k)/front%length, front%at(:, k), .false.), &
                                 k=1, front%n())]
                  cycle
               end if
            end if
            ways = [ways, spread(given, 1, front%n())]
         end associate
      end do
   end function ways_of_fronts

   !> Speed of a place of a front; if its place was closed before, or the front is new, the speed of the nearest place.
   pure real(dp) function speed_there(fronts, number, is_closed, part, x, is_felt) result(speed)
      type(growing_front_t), intent(in) :: fronts(:)
      integer, intent(in) :: number              !! of the front
      logical, intent(in) :: is_closed
      real(dp), intent(in) :: part               !! of the way along the front [-]
      real(dp), intent(in) :: x(ndim)            !! [m]
      logical, intent(in) :: is_felt             !! whether it is that to which G belongs
      real(dp) :: least
      integer :: i
      if (number <= size(fronts)) then
         if (fronts(number)%is_closed .eqv. is_closed) then
            associate (hats => merge(fronts(number)%felt, fronts(number)%speed, is_felt))
               speed = between_hats(hats, is_closed, part*(size(hats) - merge(0, 1, is_closed)))
            end associate
            return
         end if
      end if
      speed = 0
      least = huge(least)
      do i = 1, size(fronts)
         associate (distance => sqrt(sum((fronts(i)%at - spread(x, 2, size(fronts(i)%speed)))**2, dim=1)))
            if (minval(distance) < least) &
               speed = merge(fronts(i)%felt(minloc(distance, dim=1)), fronts(i)%speed(minloc(distance, dim=1)), is_felt)
            least = min(least, minval(distance))
         end associate
      end do
   end function speed_there

   !> Find the speeds of fronts in a step from the values measured along them at its start.
   subroutine find_speeds(model, materials, cracks, values, time, step, cell, planes, fronts)
      type(model_t), intent(in) :: model
      type(material_t), intent(in) :: materials(:)
      type(cracks_t), intent(in) :: cracks
      type(front_values_t), intent(in) :: values(:)
      real(dp), intent(in) :: time, step         !! [s]
      real(dp), intent(in) :: cell               !! the finest [m]
      type(growing_plane_t), intent(in) :: planes(:)
      type(growing_front_t), allocatable, intent(inout) :: fronts(:)
      type(growing_front_t), allocatable :: new(:)
      type(advance_t) :: advance
      integer :: f, j, law
      allocate (new(size(cracks%fronts)))
      do f = 1, size(new)
         associate (measured => values(f))
            associate (hats => merge(0, size(measured%arc), measured%has_ended))
               allocate (new(f)%speed(hats), new(f)%felt(hats), source=0.0_dp)
               new(f)%at = measured%at(:, :hats)
            end associate
            if (measured%has_ended) cycle
            new(f)%is_closed = measured%domain%front%is_closed
            law = law_of_plane(model, planes, cracks%fronts(f)%crack, time, step)
            if (law == 0) cycle
            if (model%growth(law)%law%gives_speed()) cycle
            do j = 1, size(new(f)%speed)
               associate (material => materials(measured%material(j)), x => measured%at(:, j), speed => new(f)%speed(j), &
                          felt => new(f)%felt(j), part => measured%arc(j)/measured%domain%front%length)
                  felt = followed(speed_there(fronts, f, new(f)%is_closed, part, x, .true.), &
                                  speed_there(fronts, f, new(f)%is_closed, part, x, .false.), step, &
                                  material%shear_wave_speed(), cell)
                  advance = advance_t()
                  call take_toughness(model, x, x, advance)
                  speed = speed_by_toughness(model%growth(law), advance, measured%g(j), felt, rayleigh_speed(material))
               end associate
            end do
         end associate
      end do
      call move_alloc(new, fronts)
   end subroutine find_speeds

   !> Note the motion of the fronts of a crack in a step, and add messages.
   subroutine note_state(plane, number, cracks, ways, material, time, step, meets_itself, message)
      type(growing_plane_t), intent(inout) :: plane
      integer, intent(in) :: number              !! of the crack
      type(cracks_t), intent(in) :: cracks       !! after the step
      real(dp), intent(in) :: ways(:)            !! of the nodes that the fronts had before [m]
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: time, step         !! at its start [s]
      logical, intent(in) :: meets_itself
      character(:), allocatable, intent(inout) :: message
      integer :: fronts, open_ends, k
      logical :: at_hole
      plane%mean = sum(ways)/(max(1, size(ways))*step)
      plane%largest = 0
      if (size(ways) > 0) plane%largest = maxval(ways)/step
      plane%is_running = plane%largest > standing*rayleigh_speed(material) .and. .not. meets_itself
      if (plane%is_running) then
         if (plane%onset < 0) plane%onset = time
         plane%last_motion = time + step
      end if
      fronts = count([(cracks%fronts(k)%crack == number .and. cracks%fronts(k)%n() > 0, k=1, size(cracks%fronts))])
      open_ends = count([(cracks%fronts(k)%crack == number .and. cracks%fronts(k)%n() > 0 .and. .not. cracks%fronts(k)%is_closed, &
                          k=1, size(cracks%fronts))])
      at_hole = ends_at_hole(cracks, number)
      if (meets_itself) then
         call tell('no longer grows: its front has met itself around a part that is not cracked')
      else if (fronts == 0 .and. plane%fronts > 0) then
         call tell('has run through'//trim(merge(', or to holes', '             ', allocated(cracks%regions(number)%bodies))))
      else if (fronts /= plane%fronts .or. open_ends /= plane%open_ends) then
         call tell('has met a side of the material, or its fronts have met')
      else if (at_hole .and. .not. plane%is_at_hole) then
         call tell('has come to the wall of a hole, and its front ends there')
      end if
      if (meets_itself .or. fronts == 0) plane%has_stopped = .true.
      plane%fronts = fronts
      plane%open_ends = open_ends
      plane%is_at_hole = at_hole

   contains

      !> Add a message about the crack, once.
      subroutine tell(what)
         character(*), intent(in) :: what
         if (.not. allocated(message)) message = ''
         associate (text => 'crack '//to_text(number)//' '//what)
            if (index(message, text) == 0) call add_line(message, text//' at t = '//three_digits(time)//' s')
         end associate
      end subroutine tell
   end subroutine note_state

   !> Whether a front of a crack ends at the wall of a hole.
   pure logical function ends_at_hole(cracks, number) result(is)
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the crack
      integer :: f, w
      associate (walls => cracks%regions(number)%walls)
         is = any([((cracks%fronts(f)%crack == number .and. walls(w)%is_hole .and. cracks%fronts(f)%ends_at(walls(w)), &
                     w=1, size(walls)), f=1, size(cracks%fronts))])
      end associate
   end function ends_at_hole

   !> Record how a crack stands.
   subroutine record_plane(plane, region, history)
      type(growing_plane_t), intent(in) :: plane
      type(region_t), intent(in) :: region
      type(history_t), intent(inout) :: history
      call history%record('crack_area', 'm2', 'area of the crack, in the box around all material', region%cracked_area())
      call history%record('front_speed', 'm/s', 'speed at which its fronts grow, mean', plane%mean)
      call history%record('front_speed_largest', 'm/s', 'the largest along them', plane%largest)
   end subroutine record_plane

   !> Keep how they have grown.
   subroutine archive_planes(planes, fronts, archive)
      type(growing_plane_t), intent(inout) :: planes(:)
      type(growing_front_t), allocatable, intent(inout) :: fronts(:)
      class(archive_t), intent(inout) :: archive
      integer :: n, m, f
      n = size(planes)
      call archive%archive_logicals('plane_has_stopped', n, planes%has_stopped)
      call archive%archive_logicals('plane_is_running', n, planes%is_running)
      call archive%archive_integers('plane_fronts', n, planes%fronts)
      call archive%archive_integers('plane_open_ends', n, planes%open_ends)
      call archive%archive_reals('plane_onset', n, planes%onset)
      call archive%archive_reals('plane_last_motion', n, planes%last_motion)
      call archive%archive_reals('plane_mean', n, planes%mean)
      call archive%archive_reals('plane_largest', n, planes%largest)
      n = size(fronts)
      call archive%serialise('front_speeds', n)
      if (archive%failure%failed()) return
      if (archive%is_read) then
         deallocate (fronts)
         allocate (fronts(n))
      end if
      do f = 1, n
         m = 0
         if (.not. archive%is_read) m = size(fronts(f)%speed)
         call archive%serialise('hats_'//to_text(f), m)
         call archive%serialise('is_closed_'//to_text(f), fronts(f)%is_closed)
         if (archive%is_read) allocate (fronts(f)%speed(m), fronts(f)%felt(m), fronts(f)%at(ndim, m))
         call archive%archive_reals('speed_'//to_text(f), m, fronts(f)%speed)
         call archive%archive_reals('felt_'//to_text(f), m, fronts(f)%felt)
         call archive%archive_reals('at_'//to_text(f), ndim*m, fronts(f)%at)
      end do
   end subroutine archive_planes
end module hampm_dynamic_front_growth
