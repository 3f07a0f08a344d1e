!> Every place belongs to exactly one leaf, or to none outside the lattice.
program test_forest
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf
   use, intrinsic :: ieee_exceptions, only: ieee_set_halting_mode, ieee_set_flag, ieee_invalid
   use hampm_kinds, only: dp, ndim, long
   use hampm_forest, only: forest_t, outside, level_width, deepest
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   implicit none

   type(forest_t) :: forest, far
   real(dp) :: upper(ndim), inside(ndim), x(ndim)
   integer(long) :: place(ndim)
   integer :: leaf, d, wrong

   call repeat_random_numbers()
   forest = forest_t(lower=[-1.0_dp, 0.5_dp], cell=0.25_dp, cells=[7, 3])
   upper = forest%lower + forest%cells*forest%cell
   inside = forest%lower + 0.6_dp*forest%cell

   call check(forest%leaf_count() == 21, 'as many leaves as cells')
   wrong = 0
   do leaf = 1, forest%leaf_count()
      place = forest%place_of(leaf)
      call random_number(x)
      if (forest%leaf_at(forest%position(place) + x*forest%cell) /= leaf) wrong = wrong + 1
      if (forest%leaf_at(forest%position(place)) /= leaf) wrong = wrong + 1
      if (any(place < 0 .or. place >= forest%cells*level_width(0))) wrong = wrong + 1
   end do
   call check(wrong == 0, 'a leaf covers its inside and its lower edges')
   call check_close(maxval(abs(forest%position(forest%cells*level_width(0)) - upper)), 0.0_dp, 0.0_dp, &
                    'the last corner is the upper corner of the lattice')
   call check(forest%tolerance() < 0.5_dp*forest%cell/2**deepest, 'neighbours on the finest lattice are different places')
   far = forest_t(lower=[3.0e7_dp, -3.0e7_dp]/7, cell=1/7.0_dp, cells=[40, 40])
   wrong = 0
   do d = 0, 40
      x = far%lower + d*far%cell
      if (any(abs(far%lower + far%cells*far%cell - (far%cells - d)*far%cell - x) > far%tolerance())) wrong = wrong + 1
   end do
   call check(wrong == 0 .and. far%tolerance() < 0.01_dp*far%cell, &
              'far from the origin too a node is one place, counted from either end of the lattice')
   do d = 1, ndim
      x = inside
      x(d) = upper(d) - 1.0e-12_dp*forest%cell
      call check(forest%leaf_at(x) /= outside, 'a place just below the upper edge is inside')
      x(d) = upper(d)
      call check(forest%leaf_at(x) == outside, 'the upper edge is outside')
      x(d) = forest%lower(d) - 1.0e-12_dp*forest%cell
      call check(forest%leaf_at(x) == outside, 'a place below the lower edge is outside')
      x(d) = 1.0e300_dp
      call check(forest%leaf_at(x) == outside, 'so is a place far away')
      x(d) = ieee_value(1.0_dp, ieee_positive_inf)
      call check(forest%leaf_at(x) == outside, 'and one at infinity')
   end do
   call ieee_set_halting_mode(ieee_invalid, .false.)
   do d = 1, ndim
      x = inside
      x(d) = ieee_value(1.0_dp, ieee_quiet_nan)
      call check(forest%leaf_at(x) == outside, 'a place that is not a number is outside')
   end do
   call ieee_set_flag(ieee_invalid, .false.)
   call finish()
end program test_forest
