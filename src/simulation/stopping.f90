!> Stop of a run before its end time by `&run stop_when`: a crack has reached a length or separated a body, cracks have arrested, or
!> the load has dropped. The check is at each sample of the history, which then is the last.
module hampm_stopping
   use hampm_kinds, only: dp
   use hampm_tensors, only: norm
   use hampm_simulation, only: simulation_t
   use hampm_text, only: three_digits
   implicit none
   private
   public :: check_stop

contains

   !> Note why the run ends with the present sample, if it does.
   subroutine check_stop(s)
      type(simulation_t), intent(inout) :: s
      real(dp), parameter :: rounding = 1e-9_dp
      real(dp) :: length, load
      integer :: k
      associate (run => s%model%run)
         if (all(run%stop_when == '')) return
         if (any(run%stop_when == 'crack_length')) then
            length = maxval([(s%cracks%crack(k)%length(), k=1, size(s%cracks%crack))])
            if (length >= run%stop_length*(1 - rounding)) &
               s%stopped_when = 'crack_length: a crack is '//three_digits(length)//' m long'
         end if
         if (any(run%stop_when == 'arrested')) then
            if (have_arrested(s)) s%stopped_when = 'arrested: no crack grows any more'
         end if
         if (any(run%stop_when == 'load_dropped')) then
            load = present_load(s)
            s%largest_load = max(s%largest_load, load)
            if (load < run%stop_load*s%largest_load) &
               s%stopped_when = 'load_dropped: the load is '//three_digits(load/s%largest_load)//' of its largest value'
         end if
         if (any(run%stop_when == 'separated') .and. s%growing%separated >= 0) &
            s%stopped_when = 'separated: a crack has parted a body'
      end associate
   end subroutine check_stop

   !> Whether some tip has grown, and all that may grow have stopped: in motion for the given time, in equilibrium for good.
   pure logical function have_arrested(s)
      type(simulation_t), intent(in) :: s
      integer :: k
      associate (tips => s%growing%points, now => s%problem%state%time)
         if (s%growing%is_static) then
            have_arrested = all(tips%has_stopped .or. .not. tips%grows)
            return
         end if
         have_arrested = any(tips%onset >= 0)
         do k = 1, size(tips)
            if (tips(k)%onset < 0) cycle
            have_arrested = have_arrested .and. tips(k)%has_arrested(now, s%dt) .and. &
                            now - tips(k)%last_motion >= s%model%run%stop_rest
         end do
      end associate
   end function have_arrested

   !> The load: the largest force of a named constraint [N] or, if none is named, the load factor of static growth [-].
   pure real(dp) function present_load(s) result(load)
      type(simulation_t), intent(in) :: s
      integer :: k
      load = abs(s%growing%load_factor)
      if (.not. any(s%model%constraints%name /= '')) return
      load = 0
      do k = 1, size(s%model%constraints)
         if (s%model%constraints(k)%name /= '') load = max(load, norm(s%measurements%reactions(:, k)))
      end do
   end function present_load
end module hampm_stopping
