!> Energy release rate of a stress intensity factor at the tip of a crack that grows at a speed v, and the largest speed.
!>
!>    G = (A_I(v) K_I**2 + A_II(v) K_II**2)/E',    A_I = a_d v**2/((1 - nu) c_s**2 D),   A_II = a_s v**2/((1 - nu) c_s**2 D),
!>    a_d**2 = 1 - v**2/c_d**2,   a_s**2 = 1 - v**2/c_s**2,   D = 4 a_d a_s - (1 + a_s**2)**2
!>
!> in plane strain; in plane stress with nu/(1 + nu) for nu, and the speed of pressure waves of a plate. D is 0 at the Rayleigh wave
!> speed, which no crack of mode I reaches. Source: Freund, Dynamic Fracture Mechanics (1990), sections 4.3, 5.3 and 6.4; Yoffe,
!> Phil. Mag. 42 (1951) 739 (hoop stress).
module hampm_moving_tip
   use hampm_kinds, only: dp
   use hampm_material, only: material_t
   implicit none
   private
   public :: energy_factors, running_intensities, rayleigh_speed, share_of_rest, hoop_angle, lead_of_release, lost_to_lumping, &
             release_length

   real(dp), parameter :: pi = acos(-1.0_dp)

   !> Advance of a tip or a front, in cells, in which the force of a place behind it falls to 0.
   real(dp), parameter :: release_length = 2

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

   !> K of the parts of G of modes I and II, with their signs; 0 from the speed of Rayleigh waves on [Pa sqrt(m)].
   pure function running_intensities(material, speed, rates) result(k)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: speed              !! of the tip [m/s]
      real(dp), intent(in) :: rates(2)           !! parts of G [J/m2]
      real(dp) :: k(2), a(2)
      a = energy_factors(material, speed)
      k = 0
      where (a < huge(speed)) k = sign(sqrt(material%plane_modulus()*abs(rates)/a), rates)
   end function running_intensities

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

   !> The part of G that a tip loses as it runs through lumped masses in explicit steps [-]. Forces that fall over `release_length`
   !> cells are half a period of waves with k h = pi v/(release_length c), which such masses slow by (k h)**2/24
   !> (docs/explanation/mass.md); and G is nearly 1 - v/c of that at rest.
   pure elemental real(dp) function lost_to_lumping(speed, wave) result(part)
      real(dp), intent(in) :: speed, wave        !! of the tip, and c of Rayleigh waves [m/s]
      real(dp) :: slowed                         ! c in these cells [m/s]
      slowed = wave*(1 - (pi*speed/(release_length*wave))**2/24)
      part = 1
      if (speed < slowed) part = 1 - (1 - speed/slowed)/(1 - speed/wave)
   end function lost_to_lumping

   !> Energy release rate of mode I over its value at a tip at rest under the same loads, g = A_I k**2, with the universal function
   !>   k = (1 - v/c_R)/sqrt(1 - v/c_d)
   !>       exp(1/pi int_a^b atan(4 e**2 sqrt((e**2 - a**2)(b**2 - e**2))/(b**2 - 2 e**2)**2)/(1/v - e) de),
   !> a = 1/c_d, b = 1/c_s; 0 from the Rayleigh wave speed on.
   pure real(dp) function share_of_rest(material, speed) result(g)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: speed              !! of the tip [m/s]
      integer, parameter :: steps = 64           ! e from a to b by the sine squared of an angle: no roots at the ends
      real(dp) :: a, b, e, angle, integral, factors(2)
      integer :: i
      g = 1
      if (speed <= static_speed*material%shear_wave_speed()) return
      g = 0
      if (speed >= rayleigh_speed(material)) return
      a = 1/material%dilatational_wave_speed()
      b = 1/material%shear_wave_speed()
      integral = 0
      do i = 1, steps
         angle = (i - 0.5_dp)*pi/(2*steps)
         e = a + (b - a)*sin(angle)**2
         integral = integral + atan2(4*e**2*sqrt((e**2 - a**2)*(b**2 - e**2)), (b**2 - 2*e**2)**2)/(1/speed - e) &
                               *(b - a)*sin(2*angle)*pi/(2*steps)
      end do
      factors = energy_factors(material, speed)
      g = factors(1)*(1 - speed/rayleigh_speed(material))**2/(1 - a*speed)*exp(2*integral/pi)
   end function share_of_rest

   !> Angle of the largest hoop stress around a tip of mode I, 0 where that is straight ahead [rad].
   pure real(dp) function hoop_angle(material, speed) result(angle)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: speed              !! of the tip [m/s]
      integer, parameter :: steps = 360
      integer :: i
      angle = 0
      if (speed <= static_speed*material%shear_wave_speed() .or. .not. rayleigh_function(material, speed) > 0) return
      associate (looked_at => [(hoop_stress(material, speed, i*pi/(2*steps)), i=0, steps)])
         angle = (maxloc(looked_at, dim=1) - 1)*pi/(2*steps)
      end associate
   end function hoop_angle

   !> Hoop stress around a tip of mode I, times D sqrt(2 pi r)/K_I, at an angle of 90 degrees at most.
   pure real(dp) function hoop_stress(material, speed, angle) result(stress)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: speed              !! of the tip [m/s]
      real(dp), intent(in) :: angle              !! [rad]
      real(dp), dimension(2) :: part, turned     ! of pressure and shear waves
      associate (ratio => speed/[material%dilatational_wave_speed(), material%shear_wave_speed()], s => sin(angle), c => cos(angle))
         part = sqrt(1 - ratio**2)
         turned = atan2(part*s, c)/2
         associate (root => (1 - (ratio*s)**2)**0.25_dp, a_d => part(1), a_s => part(2))
            associate (even => cos(turned)/root, odd => sin(turned)/root)
               stress = ((1 + a_s**2)*(1 + 2*a_d**2 - a_s**2)*even(1) - 4*a_d*a_s*even(2))*s**2 &
                        + (4*a_d*a_s*even(2) - (1 + a_s**2)**2*even(1))*c**2 &
                        - 4*a_d*(1 + a_s**2)*(odd(1) - odd(2))*s*c
            end associate
         end associate
      end associate
   end function hoop_stress

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

   !> How far the release of places is ahead of a tip or a front [m]. A place with a part f of its force has taken 1 - f**2 of what
   !> it takes. All of them have taken the way w of the tip if the first one keeps 1 - y, with y**2 - y**3/3 = w/l for a length l in
   !> which forces fall: y = 1 at two thirds of that, and later places have a lead of one third.
   pure real(dp) function lead_of_release(way, length) result(lead)
      real(dp), intent(in) :: way, length        !! w and l [m]
      lead = length/3
      if (way < length - lead) lead = length*(1 + 2*cos((2*pi - acos(1 - 1.5_dp*max(way, 0.0_dp)/length))/3)) - max(way, 0.0_dp)
   end function lead_of_release
end module hampm_moving_tip
