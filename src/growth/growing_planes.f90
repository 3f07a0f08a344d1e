!> Cracks in planes that grow in motion, of solids only: their records as wholes.
module hampm_growing_planes
   use hampm_archive, only: archive_t
   use hampm_cracks, only: cracks_t
   use hampm_front, only: region_t
   use hampm_history, only: history_t
   use hampm_kinds, only: dp
   use hampm_material, only: material_t
   use hampm_model, only: model_t
   use hampm_moving_tip, only: rayleigh_speed
   use hampm_text, only: add_line, to_text, three_digits
   implicit none
   private
   public :: growing_plane_t, new_growing_planes, note_state, record_plane, archive_planes

   real(dp), parameter :: standing = 1e-6_dp     !! part of the Rayleigh wave speed below which a front stands still

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

   !> The state of all cracks at the start.
   function new_growing_planes(model, cracks) result(planes)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(in) :: cracks
      type(growing_plane_t) :: planes(size(model%planes))
      integer :: k
      do k = 1, size(planes)
         planes(k)%grows = any(model%growth%path == k)
         planes(k)%fronts = count(cracks%fronts%crack == k)
         planes(k)%open_ends = count(cracks%fronts%crack == k .and. .not. cracks%fronts%is_closed)
         planes(k)%is_at_hole = ends_at_hole(cracks, k)
      end do
   end function new_growing_planes

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
   subroutine archive_planes(planes, archive)
      type(growing_plane_t), intent(inout) :: planes(:)
      class(archive_t), intent(inout) :: archive
      associate (n => size(planes))
         call archive%archive_logicals('plane_has_stopped', n, planes%has_stopped)
         call archive%archive_logicals('plane_is_running', n, planes%is_running)
         call archive%archive_integers('plane_fronts', n, planes%fronts)
         call archive%archive_integers('plane_open_ends', n, planes%open_ends)
         call archive%archive_reals('plane_onset', n, planes%onset)
         call archive%archive_reals('plane_last_motion', n, planes%last_motion)
         call archive%archive_reals('plane_mean', n, planes%mean)
         call archive%archive_reals('plane_largest', n, planes%largest)
      end associate
   end subroutine archive_planes
end module hampm_growing_planes
