!> Closed forms for the double cantilever beam.
module hampm_dcb
   use hampm_kinds, only: dp
   implicit none
   private
   public :: dcb_energy_release_rate, chi_foundation

   real(dp), parameter :: chi_foundation = 2.0_dp/3.0_dp  !! chi of a beam on an elastic foundation, isotropic material

contains

   !> Static G of a double cantilever beam, (33): 12 P**2 (a + chi D)**2 / (E B**2 D**3) [J/m2]. With chi = 0 it is
   !> simple beam theory, with `chi_foundation` the beam on an elastic foundation (Kanninen 1973).
   pure real(dp) function dcb_energy_release_rate(force, crack_length, depth, thickness, young, chi) result(g)
      real(dp), intent(in) :: force              !! P, at the end of each arm [N]
      real(dp), intent(in) :: crack_length       !! a [m]
      real(dp), intent(in) :: depth              !! D, of one arm [m]
      real(dp), intent(in) :: thickness          !! B [m]
      real(dp), intent(in) :: young              !! E [Pa]
      real(dp), intent(in) :: chi                !! [-]
      g = 12*force**2*(crack_length + chi*depth)**2/(young*thickness**2*depth**3)
   end function dcb_energy_release_rate
end module hampm_dcb
