!> The times at which a run writes.
module hampm_output_times
   use hampm_kinds, only: dp
   use hampm_scene, only: scene_t
   implicit none
   private
   public :: time_between_outputs

   real(dp), parameter :: same = 1e-9_dp         !! part of a time by which a multiple of another may be off

contains

   !> The longest time of which the times between samples and between snapshots are multiples, 0 if it is less than a thousandth of
   !> one of them [s].
   pure real(dp) function time_between_outputs(scene) result(time)
      type(scene_t), intent(in) :: scene
      integer, parameter :: most = 1000
      real(dp) :: times(2), rest, next
      associate (output => scene%output)
         times = output%history_interval
         if (output%snapshot_interval > 0) times(2) = output%snapshot_interval
         times = min(times, scene%run%end_time)
      end associate
      time = 0
      if (.not. all(times > 0)) return           ! mistakes in the namelist
      time = minval(times)
      next = maxval(times)
      do                                         ! Euclid
         rest = abs(next - anint(next/time)*time)
         if (rest <= same*maxval(times)) exit
         next = time
         time = rest
      end do
      associate (parts => anint(minval(times)/time))
         time = merge(minval(times)/parts, 0.0_dp, parts <= most)
      end associate
   end function time_between_outputs
end module hampm_output_times
