!> Speed of a tip, or of a place of a front, in motion: that at which its energy release rate is its toughness.
!>
!> Of a straight front in a body without other sides G = g(v) G_0 (Freund, Dynamic fracture mechanics, 1990, section 6.4): g falls
!> from 1 at rest to 0 at the Rayleigh wave speed c, nearly as 1 - v/c, and G_0 depends on the loads and on the place of the front,
!> not on its speed v. The measured G is that of a speed w which follows v by `delay`: cells need that time to bring waves of the
!> tip about. The speed of a step solves (1 - v/c)/(1 - w/c) G = toughness(v), 0 where G_0 is below the toughness at rest. In
!> steady motion w = v and G is the toughness; while v changes they differ by what g changes in the delay. Explicit steps take G of
!> their start. Trials of implicit ones of tips take that of their end: where these are long w = v, and G is the toughness.
module hampm_equation_of_motion
   use hampm_crack_groups, only: growth_t
   use hampm_kinds, only: dp
   use hampm_law, only: value_of
   use hampm_toughness, only: advance_t
   implicit none
   private
   public :: speed_by_toughness, excess_of, followed, speed_off

   real(dp), parameter :: delay = 0.5_dp         !! of the measured G, in travel times of shear waves through a cell

contains

   !> Speed at which the energy release rate is the toughness [m/s].
   pure real(dp) function speed_by_toughness(of, advance, rate, before, wave) result(speed)
      type(growth_t), intent(in) :: of
      type(advance_t), intent(in) :: advance     !! for which the toughness is asked, at any speed
      real(dp), intent(in) :: rate               !! energy release rate, measured [J/m2]
      real(dp), intent(in) :: before             !! speed to which that belongs, below `wave` [m/s]
      real(dp), intent(in) :: wave               !! speed of Rayleigh waves [m/s]
      integer, parameter :: parts = 64           ! of a speed, down which the toughness may be reached first
      real(dp) :: high
      integer :: i
      high = value_of(of%constants, 'limit_speed', 0.0_dp)
      high = merge(min(high, wave), wave, high > 0)
      do i = parts, 0, -1                        ! a toughness that falls with the speed may be reached at several: the next one
         speed = before*i/parts
         if (exceeds(speed)) exit
         high = speed
      end do
      do i = 1, digits(high)
         if (.not. speed < high) exit
         if (exceeds((speed + high)/2)) then
            speed = (speed + high)/2
         else
            high = (speed + high)/2
         end if
      end do

   contains
      !> Whether the energy release rate of a speed exceeds the toughness.
      pure logical function exceeds(at)
         real(dp), intent(in) :: at              !! [m/s]
         type(advance_t) :: there
         there = advance
         there%speed = at
         exceeds = excess_of(rate, of%toughness_at(there), at, before, wave) > 0
      end function exceeds
   end function speed_by_toughness

   !> By how much the speed differs where the energy release rate is off by a part of it, the larger way [m/s]. A tip that is some
   !> way ahead, or behind, for that has the toughness of its own place.
   pure real(dp) function speed_off(of, advance, rate, part, ahead, before, wave) result(off)
      type(growth_t), intent(in) :: of
      type(advance_t), intent(in) :: advance     !! as in `speed_by_toughness`
      real(dp), intent(in) :: rate               !! measured [J/m2]
      real(dp), intent(in) :: part               !! its error over it [-]
      real(dp), intent(in) :: ahead              !! [m]
      real(dp), intent(in) :: before, wave       !! as there [m/s]
      real(dp) :: speed
      speed = speed_by_toughness(of, advance, rate, before, wave)
      off = max(speed_by_toughness(of, moved(ahead), (1 + part)*rate, before, wave) - speed, &
                speed - speed_by_toughness(of, moved(-ahead), max(0.0_dp, 1 - part)*rate, before, wave))

   contains
      !> The arguments of the toughness after a way more.
      pure type(advance_t) function moved(way)
         real(dp), intent(in) :: way             !! [m]
         moved = advance
         moved%extension = max(0.0_dp, advance%extension + way)
         moved%length = max(0.0_dp, advance%length + way)
      end function moved
   end function speed_off

   !> Energy release rate at a speed over the toughness, less 1 [-].
   elemental real(dp) function excess_of(rate, toughness, speed, before, wave) result(excess)
      real(dp), intent(in) :: rate, toughness    !! measured; at the speed [J/m2]
      real(dp), intent(in) :: speed              !! [m/s]
      real(dp), intent(in) :: before             !! that to which the measured one belongs, below `wave` [m/s]
      real(dp), intent(in) :: wave               !! speed of Rayleigh waves [m/s]
      excess = (wave - speed)/(wave - before)*rate/toughness - 1
   end function excess_of

   !> Speed to which the energy release rate belongs that is measured after a step at a speed [m/s].
   elemental real(dp) function followed(before, speed, step, shear_wave, cell)
      real(dp), intent(in) :: before             !! the same before the step [m/s]
      real(dp), intent(in) :: speed              !! in the step [m/s]
      real(dp), intent(in) :: step               !! [s]
      real(dp), intent(in) :: shear_wave         !! speed of shear waves [m/s]
      real(dp), intent(in) :: cell               !! [m]
      followed = before + (speed - before)*(1 - exp(-step*shear_wave/(delay*cell)))
   end function followed
end module hampm_equation_of_motion
