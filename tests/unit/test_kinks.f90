!> Kink angles and stress intensity factors of short kinks, against tables that were made apart from this program: those of an integral
!> equation for a crack with a kink, good to 1e-6 up to 75 degrees, and angles from these to 1e-3 degrees.
program test_kinks
   use hampm_kinds, only: dp
   use hampm_crack_tip_field, only: modes
   use hampm_kinks, only: kink_angle, after_kink, is_opened, slope_of_mixity
   use hampm_symmetric_turns, only: symmetric_turns_t, begin_turns
   use hampm_harness, only: check, check_close, finish
   implicit none
   real(dp), parameter :: degree = acos(-1.0_dp)/180

   call check_factors()
   call check_angles()
   call check_pure_shear()
   call check_turns()
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

   !> In pure mode II the hoop stress is largest at 70.53 degrees, and the short kink has no K_II where F22 is 0, at 77.3: to the side where it
   !> opens. A tip that is pressed shut is opened by none.
   subroutine check_pure_shear()
      real(dp) :: k(modes), of_kink(modes)
      integer :: side
      do side = -1, 1, 2
         k = [0.0_dp, real(side, dp)]
         call check_close(kink_angle('hoop_stress', k)/degree, -side*70.528779_dp, 1.0e-5_dp, 'pure mode II, hoop stress')
         call check_close(kink_angle('local_symmetry', k)/degree, -side*77.3_dp, 0.1_dp, 'pure mode II, local symmetry')
         of_kink = after_kink(kink_angle('local_symmetry', k), k)
         call check(of_kink(1) > 0, 'the kink opens')
         call check(is_opened('hoop_stress', k) .and. is_opened('local_symmetry', k), 'pure mode II opens a kink')
      end do
      call check(.not. is_opened('hoop_stress', [-1.0_dp, 0.0_dp]), 'nothing opens a crack that is pressed shut')
      call check(.not. is_opened('local_symmetry', [-1.0_dp, 0.1_dp]), 'nor by local symmetry')
   end subroutine check_pure_shear

   !> Two increments, each of which turns the mixity of the other too, with slopes that are guessed wrong by a factor of 2 and of a half.
   subroutine check_turns()
      type(symmetric_turns_t) :: turns
      real(dp) :: turn(2), angle(2)
      logical :: are_over
      integer :: trial
      angle = 0
      call begin_turns(turns, [1, 2], [1.2_dp, 0.3_dp])
      do trial = 1, 8
         call turns%note([sin(0.6_dp*angle(1) - 0.1_dp*angle(2) + 0.2_dp), &
                          0.15_dp*angle(1) + 0.6_dp*angle(2) - 0.1_dp*angle(2)**2 - 0.1_dp])
         if (turns%have_found()) exit
         call turns%choose(turn, are_over)
         angle = angle + turn
      end do
      call check(turns%have_found(), 'Broyden''s method finds directions of two tips')
      call check(slope_of_mixity(0.0_dp, [1.0_dp, 0.0_dp]) > 0.45_dp .and. slope_of_mixity(0.0_dp, [1.0_dp, 0.0_dp]) < 0.55_dp, &
                 'a small kink changes K_II by K_I/2 for each rad')
   end subroutine check_turns
end program test_kinks
