!> Toughness by its factors, and the kink with the most energy over it.
program test_toughness
   use hampm_kinds, only: dp
   use hampm_crack_tip_field, only: modes
   use hampm_kinks, only: kink_t, best_kink, after_kink, of_t_stress
   use hampm_toughness, only: advance_t, factors_t, table_t
   use hampm_harness, only: check, check_close, finish
   implicit none
   real(dp), parameter :: degree = acos(-1.0_dp)/180

   call check_tables()
   call check_mixes()
   call check_t_stress()
   call check_weak_planes()
   call check_kink_by_t_stress()
   call finish()

contains

   !> Linear between points, constant beyond them, and periodic where it is of directions.
   subroutine check_tables()
      type(factors_t) :: factors
      factors%of_extension = table_t([1.0_dp, 3.0_dp], [1.0_dp, 2.0_dp])
      call check_close(factors%product_at(advance_t(extension=0.0_dp)), 1.0_dp, 0.0_dp, 'before the first point')
      call check_close(factors%product_at(advance_t(extension=2.0_dp)), 1.5_dp, 1e-15_dp, 'between points')
      call check_close(factors%product_at(advance_t(extension=9.0_dp)), 2.0_dp, 0.0_dp, 'behind the last point')
      factors%of_angle = table_t([-30.0_dp, 30.0_dp, 90.0_dp], [1.0_dp, 2.0_dp, 4.0_dp])
      call check_close(factors%product_at(advance_t(angle=60*degree)), 3.0_dp, 1e-14_dp, 'a direction')
      call check_close(factors%product_at(advance_t(angle=-120*degree)), 3.0_dp, 1e-14_dp, 'the opposite direction')
      call check_close(factors%product_at(advance_t(angle=120*degree)), 2.5_dp, 1e-14_dp, 'between the last point and the first')
   end subroutine check_tables

   !> Hutchinson & Suo: 1 + tan((1 - lambda) psi)**2; Benzeggagh & Kenane: from one toughness to the other.
   subroutine check_mixes()
      type(factors_t) :: factors
      factors%mixed_mode = 'hutchinson_suo'
      factors%lambda = 0.3_dp
      call check_close(factors%of_mix(0.0_dp), 1.0_dp, 1e-15_dp, 'mode I')
      call check_close(factors%of_mix(0.5_dp), 1 + tan(0.7_dp*45*degree)**2, 1e-14_dp, 'as much of both modes')
      call check_close(factors%of_mix(1.0_dp), 1 + tan(0.7_dp*90*degree)**2, 1e-14_dp, 'mode II')
      factors%lambda = 0
      call check_close(factors%of_mix(0.75_dp), 4.0_dp, 1e-14_dp, 'lambda = 0: the part of mode I counts')
      factors = factors_t(mixed_mode='benzeggagh_kenane', of_shear=3.0_dp, exponent=2.0_dp)
      call check_close(factors%of_mix(0.0_dp), 1.0_dp, 0.0_dp, 'mode I')
      call check_close(factors%of_mix(0.5_dp), 1.5_dp, 1e-15_dp, 'as much of both modes')
      call check_close(factors%of_mix(1.0_dp), 3.0_dp, 0.0_dp, 'mode II')
   end subroutine check_mixes

   !> K of a kink by a T-stress alone, against an integral equation for a crack with a short kink (tests/reference/growth/kink_t_stress.csv).
   subroutine check_t_stress()
      real(dp), parameter :: table(3, 6) = reshape([ & ! angle, K_I and K_II over T times the root of the length
         15.0_dp, 0.10708_dp, -0.40060_dp, 30.0_dp, 0.40185_dp, -0.70372_dp, 45.0_dp, 0.81197_dp, -0.83787_dp, &
         60.0_dp, 1.23838_dp, -0.77602_dp, 75.0_dp, 1.58088_dp, -0.54153_dp, 90.0_dp, 1.76283_dp, -0.20021_dp], [3, 6])
      real(dp) :: left(modes), right(modes)
      integer :: i
      do i = 1, size(table, 2)
         left = of_t_stress(table(1, i)*degree)
         right = of_t_stress(-table(1, i)*degree)
         call check_close(maxval(abs(left - table(2:, i))), 0.0_dp, 4e-4_dp, 'K of a kink by the T-stress')
         call check_close(maxval(abs(right - [left(1), -left(2)])), 0.0_dp, 1e-15_dp, 'to the right it is mirrored')
      end do
   end subroutine check_t_stress

   !> Weak planes at 40 degrees to either side: a tip kinks to one of them, goes on along it, and turns to the other one where a kink of 80 degrees has
   !> as much G as it has straight on.
   subroutine check_weak_planes()
      type(factors_t) :: factors
      type(kink_t) :: kink
      type(advance_t) :: ahead
      real(dp) :: mixity, low, high, of_kink(modes)
      integer :: i
      factors%of_angle = table_t([-40.0_dp, 0.0_dp, 40.0_dp, 90.0_dp], [1.0_dp, 1.6_dp, 1.0_dp, 3.0_dp])
      kink = best_kink([1.0_dp, -1e-3_dp], 0.0_dp, ahead, factors)
      call check_close(kink%angle, 40*degree, 1e-12_dp, 'to the plane to the left')
      kink = best_kink([1.0_dp, 1e-3_dp], 0.0_dp, ahead, factors)
      call check_close(kink%angle, -40*degree, 1e-12_dp, 'to that to the right')
      low = 0
      high = 1
      do i = 1, digits(low)
         mixity = (low + high)/2
         of_kink = after_kink(-80*degree, [1.0_dp, mixity])
         if (sum(of_kink**2) < 1 + mixity**2) then
            low = mixity
         else
            high = mixity
         end if
      end do
      call check_close(mixity, 0.460_dp, 1e-3_dp, 'K_II/K_I at which it turns')
      ahead%angle = 40*degree
      kink = best_kink([1.0_dp, mixity - 1e-3_dp], 0.0_dp, ahead, factors)
      call check_close(kink%angle, 0.0_dp, 1e-12_dp, 'with less it goes on')
      kink = best_kink([1.0_dp, mixity + 1e-3_dp], 0.0_dp, ahead, factors)
      call check_close(kink%angle, -80*degree, 1e-12_dp, 'with more it turns')
      call check_close(kink%gain, 1.0_dp, 3e-3_dp, 'by a kink with as much G')
   end subroutine check_weak_planes

   !> In mode I a T-stress turns a tip from its line where b = sqrt(8/pi) T sqrt(s)/K_I is above (sqrt(3) - 1)/2: to the second order in the angle the
   !> kink has (1 - 3/8 angle**2 + b angle**2)**2 + (angle/2 - b angle)**2 = 1 + (b**2 + b - 1/2) angle**2 of G.
   subroutine check_kink_by_t_stress()
      real(dp), parameter :: least = (sqrt(3.0_dp) - 1)/2/sqrt(8/acos(-1.0_dp))
      type(factors_t) :: same
      type(kink_t) :: kink
      kink = best_kink([1.0_dp, 0.0_dp], 0.98_dp*least, advance_t(), same)
      call check_close(kink%angle, 0.0_dp, 1e-6_dp, 'a small T-stress leaves a crack on its line')
      kink = best_kink([1.0_dp, 0.0_dp], 1.1_dp*least, advance_t(), same)
      call check(abs(kink%angle) > 1*degree, 'a larger one turns it')
   end subroutine check_kink_by_t_stress
end program test_toughness
