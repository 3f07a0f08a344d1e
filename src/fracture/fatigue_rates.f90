!> Growth by fatigue: advance of a tip in a load cycle, by the range of its stress intensity factor; and growth in time under loads
!> that are less than critical.
!>
!>    da/dN = C dK**m                               Paris & Erdogan, J. Basic Eng. 85 (1963) 528
!>    da/dN = C (dK/(1 - R)**(1 - w))**m            Walker, ASTM STP 462 (1970) 1
!>    da/dN = C dK**m/((1 - R) K_c - dK)            Forman, Kearney & Engle, J. Basic Eng. 89 (1967) 459
!>
!> with R = K_min/K_max, and K_c from the toughness. None grows where dK is not above the threshold. In time
!>
!>    da/dt = v (K/K_c)**n                          Charles, J. Appl. Phys. 29 (1958) 1549
!>    da/dt = v with toughness(v) = G               the law of tips in motion, whose inertia does not count
module hampm_fatigue_rates
   use hampm_kinds, only: dp
   use hampm_law, only: constant_t, value_of
   implicit none
   private
   public :: fatigue_rate, subcritical_rate, retardation

contains

   !> Way of a tip in a load cycle [m].
   pure real(dp) function fatigue_rate(constants, rate, range, ratio, part)
      type(constant_t), intent(in) :: constants(:) !! keys of &growth
      character(*), intent(in) :: rate           !! 'paris', 'walker' or 'forman'
      real(dp), intent(in) :: range              !! of K [Pa sqrt(m)]
      real(dp), intent(in) :: ratio              !! least over largest K, 0 at least [-]
      real(dp), intent(in) :: part               !! largest K over K_c, 0 if not given [-]
      real(dp) :: counting
      fatigue_rate = 0
      if (range <= value_of(constants, 'threshold', 0.0_dp)) return
      counting = range
      if (rate == 'walker') counting = range/(1 - ratio)**(1 - value_of(constants, 'walker_exponent', 1.0_dp))
      fatigue_rate = value_of(constants, 'rate_constant', 0.0_dp)*counting**value_of(constants, 'rate_exponent', 0.0_dp)
      if (rate == 'forman') fatigue_rate = fatigue_rate*part/(range*max(1 - part, epsilon(part)))
   end function fatigue_rate

   !> Speed of a tip [m/s]. By the toughness: for limit_speed; a table of speeds is inverted by `hampm_crack_groups`.
   pure real(dp) function subcritical_rate(constants, rate, range, ratio, part) result(speed)
      type(constant_t), intent(in) :: constants(:) !! keys of &growth
      character(*), intent(in) :: rate           !! 'charles' or 'toughness'
      real(dp), intent(in) :: range              !! K [Pa sqrt(m)]
      real(dp), intent(in) :: ratio              !! 0 [-]
      real(dp), intent(in) :: part               !! K over K_c at rest: sqrt(G/toughness) [-]
      speed = 0
      if (range <= value_of(constants, 'threshold', 0.0_dp)) return
      if (rate == 'charles') then
         speed = value_of(constants, 'speed', 0.0_dp)*part**value_of(constants, 'rate_exponent', 0.0_dp)
      else if (part > 1) then
         speed = value_of(constants, 'limit_speed', 0.0_dp)*(1 - 1/part**2)**(1/value_of(constants, 'exponent', 1.0_dp))
      end if
   end function subcritical_rate

   !> Retardation of a tip within the plastic zone of an overload: Wheeler, J. Basic Eng. 94 (1972) 181.
   pure real(dp) function retardation(constants, zone, left)
      type(constant_t), intent(in) :: constants(:)
      real(dp), intent(in) :: zone               !! length of the present zone [m]
      real(dp), intent(in) :: left               !! way to the end of the farthest zone [m]
      retardation = 1
      if (zone < left) retardation = (zone/left)**value_of(constants, 'wheeler_exponent', 0.0_dp)
   end function retardation
end module hampm_fatigue_rates
