!> The longest time step that is stable.
module hampm_time_step
   use hampm_kinds, only: dp
   use hampm_material, only: material_t
   implicit none
   private
   public :: stable_time_step

contains

   !> The time step (31): courant times the size of the smallest cell over the largest wave speed [s].
   pure real(dp) function stable_time_step(cell, materials, courant, wave_speed) result(dt)
      real(dp), intent(in) :: cell               !! size of the smallest cell with particles [m]
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: courant            !! [-]
      character(*), intent(in) :: wave_speed     !! 'shear', as in (32), or 'dilatational'
      real(dp) :: speed
      integer :: k
      speed = 0
      do k = 1, size(materials)
         if (wave_speed == 'shear') then
            speed = max(speed, materials(k)%shear_wave_speed())
         else
            speed = max(speed, materials(k)%dilatational_wave_speed())
         end if
      end do
      dt = courant*cell/speed
   end function stable_time_step
end module hampm_time_step
