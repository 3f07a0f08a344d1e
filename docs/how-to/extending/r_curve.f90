!> Growth at rest by a resistance curve: toughness + (plateau - toughness) (1 - exp(-(a - notch)/rise)) of a crack of length a.
module hampm_r_curve
   use hampm_kinds, only: dp
   use hampm_law, only: constant_t, value_of
   implicit none
   private
   public :: r_curve

contains

   !> Energy release rate that a tip takes [J/m2].
   pure real(dp) function r_curve(constants, speed, length) result(toughness)
      type(constant_t), intent(in) :: constants(:)
      real(dp), intent(in) :: speed, length
      toughness = value_of(constants, 'toughness', 0.0_dp)
      associate (way => max(0.0_dp, length - value_of(constants, 'notch', 0.0_dp)))
         toughness = toughness + (value_of(constants, 'plateau', 0.0_dp) - toughness) &
                                 *(1 - exp(-way/value_of(constants, 'rise', 1.0_dp)))
      end associate
   end function r_curve
end module hampm_r_curve
