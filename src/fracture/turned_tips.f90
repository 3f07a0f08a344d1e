!> What is measured at a tip that has just turned sharply. Domains are wider than its way since the turn: they see the crack before
!> it, as if it ended at the turn, and K of the short kink follow from that (`hampm_kinks`).
module hampm_turned_tips
   use hampm_crack_tip, only: crack_tip_t, frame_along
   use hampm_crack_tip_field, only: modes
   use hampm_crack_values, only: crack_values_t
   use hampm_cracks, only: cracks_t, toward, way_in_grid
   use hampm_crack_lines, only: line_t
   use hampm_kinds, only: dp, ndim
   use hampm_kinks, only: after_kink
   use hampm_material, only: material_t
   use hampm_moving_tip, only: running_intensities, rayleigh_speed
   use hampm_tensors, only: norm
   implicit none
   private
   public :: turn_t, last_turn, turn_values, sharp

   real(dp), parameter :: sharp = 0.25_dp        !! least angle; domains hold weaker turns [rad]

   !> The last sharp turn of a tip that grows in motion.
   type :: turn_t
      real(dp) :: angle = 0                      !! to the left, of the tip with the crack before; 0: no such turn is near [rad]
      real(dp) :: way = 0                        !! of the tip since then [m]
      type(crack_tip_t) :: before                !! the tip, at rest at the turn
   end type turn_t

contains

   !> The last sharp turn of a tip within a length of its way.
   pure type(turn_t) function last_turn(cracks, number, within, lines) result(turn)
      type(cracks_t), intent(in) :: cracks
      integer, intent(in) :: number              !! of the tip
      real(dp), intent(in) :: within             !! [m]
      type(line_t), intent(in) :: lines(:)       !! of cracks in the grid
      real(dp), parameter :: rounding = 1e-9_dp
      real(dp), allocatable :: points(:, :)
      real(dp) :: axis(ndim, ndim), along(ndim), way
      integer :: n
      associate (tip => cracks%tips(number))
         if (.not. tip%grown > 0) return
         allocate (points, source=toward(cracks%crack(tip%crack)%open_part(), tip%end))
         way = 0
         do n = size(points, 2), 3, -1
            way = way + norm(points(:, n) - points(:, n - 1))
            if (way > min(within, tip%grown*(1 + rounding))) return
            axis = frame_along(outward(points(:, n - 2:n - 1)))
            along = matmul(outward(points(:, n - 1:n)), axis)
            if (abs(atan2(along(2), along(1))) > sharp) exit
         end do
         if (n < 3) return
         along = matmul(tip%axis(:, 1), axis)
         turn%angle = atan2(along(2), along(1))
         turn%way = way
         turn%before = tip
         turn%before%grown = 0
         turn%before%speed = 0
         turn%before%axis = axis
         turn%before%place = points(:, n - 1)
         if (cracks%carries(tip%crack)) then     ! with points between those of the crack
            points = way_in_grid(tip, lines(tip%crack))
            n = size(points, 2)
            do while (n > 3)
               way = way - norm(points(:, n) - points(:, n - 1))
               if (way < norm(points(:, n - 1) - points(:, n - 2))/2) exit
               n = n - 1
            end do
         end if
         turn%before%now = points(:, n - 1)
         turn%before%direction = outward(points(:, n - 2:n - 1))
      end associate
   contains
      !> Unit vector from a point to the next one.
      pure function outward(points)
         real(dp), intent(in) :: points(ndim, 2) !! [m]
         real(dp) :: outward(ndim)
         outward = points(:, 2) - points(:, 1)
         outward = outward/norm(outward)
      end function outward
   end function last_turn

   !> Make values of the crack before a turn those of the short kink at its speed: G of the kink at rest by its K, times 1 - v/c_R.
   !> The way since the turn, over the radius of the largest domain, is added to the uncertainties.
   pure subroutine turn_values(turn, speed, material, values)
      type(turn_t), intent(in) :: turn
      real(dp), intent(in) :: speed              !! of the tip [m/s]
      type(material_t), intent(in) :: material
      type(crack_values_t), intent(inout) :: values
      real(dp) :: k(modes), gain, part
      integer :: n
      values%is_turned = abs(turn%angle) > 0
      if (.not. values%is_turned) return
      k = after_kink(turn%angle, values%intensity)
      gain = sum(k**2)/max(sum(values%intensity**2), tiny(gain))*max(0.0_dp, 1 - speed/rayleigh_speed(material))
      part = turn%way/maxval(turn%before%radii)
      values%uncertainty_of_j = gain*(values%uncertainty_of_j + maxval(values%j) - minval(values%j) + part*abs(values%g_of_k))
      values%spread_of_k = sqrt(gain)*(norm(values%spread_of_k) + part*norm(values%intensity))
      values%g_of_k = gain*values%g_of_k
      values%j = values%g_of_k
      values%domain = values%g_of_k*sign(k**2, k)/max(sum(k**2), tiny(gain))
      values%by_fields = k*sqrt(gain*sum(values%intensity**2)/max(sum(k**2), tiny(gain)))
      values%intensity = running_intensities(material, speed, values%domain)
      do n = 1, size(values%estimates)
         values%estimates(n)%rate = gain*values%estimates(n)%rate
      end do
   end subroutine turn_values
end module hampm_turned_tips
