!> Kink angles and stress intensity factors of short kinks, against tables that were made apart from this program: those of an integral
!> equation for a crack with a kink, good to 1e-6 up to 75 degrees, and angles from these to 1e-3 degrees.
program test_kinks
   use hampm_kinds, only: dp
   use hampm_crack_tip_field, only: modes
   use hampm_kinks, only: kink_angle, after_kink
   use hampm_harness, only: check, check_close, finish
   implicit none
   real(dp), parameter :: degree = acos(-1.0_dp)/180

   call check_factors()
   call check_angles()
   call finish()

contains

   !> k of the kink for K_I = 1 and for K_II = 1.
   subroutine check_factors()
      real(dp), parameter :: table(5, 5) = reshape([ & ! angle, F11, F12, F21, F22
         15.0_dp, 0.97458826_dp, -0.38557774_dp, 0.12812832_dp, 0.94722715_dp, &
         30.0_dp, 0.90173822_dp, -0.72984211_dp, 0.24024852_dp, 0.79716149_dp, &
         45.0_dp, 0.79089845_dp, -0.99820315_dp, 0.32327981_dp, 0.57290309_dp, &
         60.0_dp, 0.6556703_dp, -1.1679919_dp, 0.36925005_dp, 0.30787119_dp, &
         80.0_dp, 0.46359116_dp, -1.2290478_dp, 0.37043512_dp, -0.044256518_dp], [5, 5])
      real(dp) :: of_one(modes), of_two(modes)
      integer :: i
      do i = 1, size(table, 2)
         of_one = after_kink(table(1, i)*degree, [1.0_dp, 0.0_dp])
         of_two = after_kink(table(1, i)*degree, [0.0_dp, 1.0_dp])
         call check_close(maxval(abs([of_one(1), of_two(1), of_one(2), of_two(2)] - table(2:, i))), 0.0_dp, 1.0e-6_dp, &
                          'stress intensity factors of a short kink')
         of_one = after_kink(-table(1, i)*degree, [1.0_dp, 0.0_dp])
         call check_close(of_one(2), -table(4, i), 1.0e-6_dp, 'to the right they are mirrored')
      end do
   end subroutine check_factors

   !> The angles of three criteria, by the mixity.
   subroutine check_angles()
      real(dp), parameter :: table(4, 8) = reshape([ & ! mixity, hoop stress, local symmetry, most energy
         0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, &
         5.0_dp, -9.8521662_dp, -9.885332_dp, -9.8852539_dp, &
         15.0_dp, -26.739558_dp, -27.362749_dp, -27.350666_dp, &
         30.0_dp, -43.221345_dp, -45.535047_dp, -45.395798_dp, &
         45.0_dp, -53.130102_dp, -56.957967_dp, -56.565422_dp, &
         60.0_dp, -60.0_dp, -64.998634_dp, -64.283666_dp, &
         70.0_dp, -63.758661_dp, -69.409849_dp, -68.448001_dp, &
         80.0_dp, -67.199948_dp, -73.442798_dp, -72.20037_dp], [4, 8])
      character(*), parameter :: criteria(3) = [character(14) :: 'hoop_stress', 'local_symmetry', 'max_energy']
      real(dp) :: k(modes)
      integer :: i, c, side
      do i = 1, size(table, 2)
         do c = 1, size(criteria)
            do side = -1, 1, 2
               k = 1.0e6_dp*[cos(table(1, i)*degree), side*sin(table(1, i)*degree)]
               call check_close(kink_angle(trim(criteria(c)), k)/degree, side*table(1 + c, i), 2.0e-3_dp, trim(criteria(c)))
            end do
         end do
      end do
      call check(.not. abs(kink_angle('straight', [1.0_dp, 1.0_dp])) > 0, 'straight on')
   end subroutine check_angles
end program test_kinks
