!> Laws of crack growth: the toughness, static or dynamic, that a tip dissipates for its advance, its prescribed dynamic speed, or
!> its way in a load cycle or, in equilibrium, in time.
!>
!> A new law is a file with one of these procedures and a row in this table, which gives its choice in `&growth`, its column of the
!> history, and the rules on its combinations. Keys of its own stand in src/input/schema/growth.toml.
module hampm_growth_laws
   use hampm_fatigue_rates, only: fatigue_rate, subcritical_rate
   use hampm_kinds, only: dp, name_len
   use hampm_law, only: constant_t, value_of
   implicit none
   private
   public :: growth_law_t, growth_laws

   !> A row of the table.
   type :: growth_law_t
      character(name_len) :: name = ''           !! in model files
      logical :: is_static = .false.             !! whether tips advance in static increments: by scaled loads, cycles or time
      logical :: is_in_time = .false.            !! whether these take time, in which loads follow their histories
      procedure(toughness_of), pointer, nopass :: toughness => null() !! of a law that gives this
      procedure(speed_of), pointer, nopass :: speed => null() !! or this
      procedure(rate_of), pointer, nopass :: rate => null() !! of a law of load cycles or of time
   contains
      procedure :: gives_speed
      procedure :: has_rate
      procedure :: is_cyclic
      procedure :: scales_loads
   end type growth_law_t

   abstract interface
      !> Energy release rate that a tip takes [J/m2].
      pure real(dp) function toughness_of(constants, speed, length) result(toughness)
         import :: dp, constant_t
         type(constant_t), intent(in) :: constants(:) !! toughness, limit_speed and exponent of &growth, and the keys of laws
         real(dp), intent(in) :: speed           !! of the tip, 0 in static growth [m/s]
         real(dp), intent(in) :: length          !! of the whole crack [m]
      end function toughness_of

      !> Speed of a tip [m/s].
      pure real(dp) function speed_of(constants, time) result(speed)
         import :: dp, constant_t
         type(constant_t), intent(in) :: constants(:)
         real(dp), intent(in) :: time            !! [s]
      end function speed_of

      !> Way of a tip in a load cycle [m], or in a second [m/s].
      pure real(dp) function rate_of(constants, rate, range, ratio, part)
         import :: dp, constant_t
         type(constant_t), intent(in) :: constants(:)
         character(*), intent(in) :: rate        !! of &growth
         real(dp), intent(in) :: range           !! of K; in time K [Pa sqrt(m)]
         real(dp), intent(in) :: ratio           !! least over largest K; in time 0 [-]
         real(dp), intent(in) :: part            !! largest K over K_c [-]
      end function rate_of
   end interface

contains

   !> All rows.
   pure function growth_laws() result(rows)
      type(growth_law_t), allocatable :: rows(:)
      allocate (rows, source=[ &
         growth_law_t('quasi_static', is_static=.true., toughness=toughness_at_speed), &
         growth_law_t('prescribed', speed=prescribed_speed), &
         growth_law_t('toughness', toughness=toughness_at_speed), &
         growth_law_t('fatigue', is_static=.true., toughness=toughness_at_speed, rate=fatigue_rate), &
         growth_law_t('subcritical', is_static=.true., is_in_time=.true., toughness=toughness_at_speed, rate=subcritical_rate)])
   end function growth_laws

   !> Whether a law gives the speed, else the toughness.
   elemental logical function gives_speed(self)
      class(growth_law_t), intent(in) :: self
      gives_speed = associated(self%speed)
   end function gives_speed

   !> Whether a law gives a rate, in load cycles or in time.
   elemental logical function has_rate(self)
      class(growth_law_t), intent(in) :: self
      has_rate = associated(self%rate)
   end function has_rate

   !> Whether that is of load cycles.
   elemental logical function is_cyclic(self)
      class(growth_law_t), intent(in) :: self
      is_cyclic = self%has_rate() .and. .not. self%is_in_time
   end function is_cyclic

   !> Whether growth scales the loads that are not held.
   elemental logical function scales_loads(self)
      class(growth_law_t), intent(in) :: self
      scales_loads = self%is_static .and. .not. self%is_in_time
   end function scales_loads

   !> Constant speed [m/s].
   pure real(dp) function prescribed_speed(constants, time) result(speed)
      type(constant_t), intent(in) :: constants(:)
      real(dp), intent(in) :: time
      speed = value_of(constants, 'speed', 0.0_dp)
   end function prescribed_speed

   !> Constant toughness, or one that rises with the speed, without bound at `limit_speed` [J/m2].
   pure real(dp) function toughness_at_speed(constants, speed, length) result(toughness)
      type(constant_t), intent(in) :: constants(:)
      real(dp), intent(in) :: speed, length
      real(dp), parameter :: least = 1e-12_dp    ! so that nothing overflows
      toughness = value_of(constants, 'toughness', 0.0_dp)
      associate (limit => value_of(constants, 'limit_speed', 0.0_dp))
         if (limit > 0) toughness = toughness/max(1 - min(speed/limit, 1.0_dp)**value_of(constants, 'exponent', 1.0_dp), least)
      end associate
   end function toughness_at_speed
end module hampm_growth_laws
