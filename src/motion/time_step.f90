!> The longest time step that is stable.
module hampm_time_step
   use hampm_kinds, only: dp
   use hampm_material, only: material_t
   implicit none
   private
   public :: stable_time_step, largest_wave_speed

contains

   !> The time step (31): courant times the size of the smallest cell over the largest wave speed [s].
   pure real(dp) function stable_time_step(cell, materials, courant, wave_speed) result(dt)
      real(dp), intent(in) :: cell               !! size of the smallest cell with particles [m]
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: courant            !! [-]
      character(*), intent(in) :: wave_speed     !! 'shear', as in (32), or 'dilatational'
      dt = courant*cell/largest_wave_speed(materials, wave_speed)
   end function stable_time_step

   !> The largest wave speed of some materials [m/s].
   pure real(dp) function largest_wave_speed(materials, wave_speed) result(speed)
      type(material_t), intent(in) :: materials(:)
      character(*), intent(in) :: wave_speed     !! 'shear' or 'dilatational'
      integer :: k
      speed = 0
      do k = 1, size(materials)
         if (wave_speed == 'shear') then
            speed = max(speed, materials(k)%shear_wave_speed())
         else
            speed = max(speed, materials(k)%dilatational_wave_speed())
         end if
      end do
   end function largest_wave_speed
end module hampm_time_step
