!> What changes at the tip of a crack that grows at a speed: the energy release rate of a stress intensity factor, and the largest speed.
!>
!>    G = (A_I(v) K_I**2 + A_II(v) K_II**2)/E',    A_I = a_d v**2/((1 - nu) c_s**2 D),   A_II = a_s v**2/((1 - nu) c_s**2 D),
!>    a_d**2 = 1 - v**2/c_d**2,   a_s**2 = 1 - v**2/c_s**2,   D = 4 a_d a_s - (1 + a_s**2)**2
!>
!> in plane strain; in plane stress with nu/(1 + nu) for nu, and the speed of pressure waves of a plate. D is 0 at the speed of Rayleigh
!> waves, which no crack of mode I reaches. Source: Freund, Dynamic Fracture Mechanics (1990), section 5.3.
module hampm_moving_tip
   use hampm_kinds, only: dp
   use hampm_material, only: material_t
   implicit none
   private
   public :: energy_factors, rayleigh_speed

   real(dp), parameter :: static_speed = 1e-4_dp !! part of the speed of shear waves below which a tip is taken to be at rest

contains

   !> A_I and A_II; 1 at rest, huge from the speed of Rayleigh waves on.
   pure function energy_factors(material, speed) result(a)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: speed              !! of the tip [m/s]
      real(dp) :: a(2)                           !! of modes I and II
      real(dp) :: nu, of_pressure, of_shear, d
      a = 1
      associate (shear => material%shear_wave_speed())
         if (speed <= static_speed*shear) return
         d = rayleigh_function(material, speed)
         a = huge(speed)
         if (.not. d > 0) return
         nu = material%poisson
         if (material%plane_stress) nu = nu/(1 + nu)
         of_pressure = sqrt(1 - (speed/material%dilatational_wave_speed())**2)
         of_shear = sqrt(1 - (speed/shear)**2)
         a = [of_pressure, of_shear]*(speed/shear)**2/((1 - nu)*d)
      end associate
   end function energy_factors

   !> D of a speed; 0 from the speed of shear waves on.
   pure real(dp) function rayleigh_function(material, speed) result(d)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: speed              !! [m/s]
      real(dp) :: of_pressure, of_shear
      d = 0
      if (speed >= material%shear_wave_speed()) return
      of_pressure = sqrt(1 - (speed/material%dilatational_wave_speed())**2)
      of_shear = sqrt(1 - (speed/material%shear_wave_speed())**2)
      d = 4*of_pressure*of_shear - (1 + of_shear**2)**2
   end function rayleigh_function

   !> Speed of Rayleigh waves [m/s].
   pure real(dp) function rayleigh_speed(material) result(speed)
      type(material_t), intent(in) :: material
      real(dp) :: low, high
      integer :: i
      low = 0.5_dp*material%shear_wave_speed()   ! 0.69 of it in a material of Poisson's ratio -1
      high = material%shear_wave_speed()
      do i = 1, digits(low)
         speed = (low + high)/2
         if (rayleigh_function(material, speed) > 0) then
            low = speed
         else
            high = speed
         end if
      end do
   end function rayleigh_speed
end module hampm_moving_tip
