!> Polygons: what lines leave of them, areas and moments, what is inside, and where segments meet.
program test_polygon
   use hampm_kinds, only: dp
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_polygon, only: area_of, clip, clip_segment, clip_to, clip_to_box, cross, distance_to_line, distance_to_polygon, &
                            do_cross, find_crossing, find_meeting, is_in_polygon, moments_of, outward_normal, side_lengths, &
                            ways_along
   implicit none

   real(dp), parameter :: bracket(2, 6) = reshape([0.0_dp, 0.0_dp, 3.0_dp, 0.0_dp, 3.0_dp, 1.0_dp, 1.0_dp, 1.0_dp, 1.0_dp, 2.0_dp, &
                                                   0.0_dp, 2.0_dp], [2, 6])
   real(dp), parameter :: crossed(2, 4) = reshape([0.0_dp, 0.0_dp, 1.0_dp, 1.0_dp, 1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 4])
   integer :: i, j, turn

   call repeat_random_numbers()
   call check_close(area_of(bracket), 4.0_dp, 1e-15_dp, 'a bracket has the area of its two legs')
   call check_close(area_of(bracket(:, 6:1:-1)), -4.0_dp, 1e-15_dp, 'clockwise it is below zero')
   call check(maxval(abs(moments_of(bracket) - [4.0_dp, 5.0_dp, 3.0_dp])) < 1e-14_dp, 'and their first moments')
   call check(is_in_polygon([0.5_dp, 1.5_dp], bracket) .and. .not. is_in_polygon([1.5_dp, 1.5_dp], bracket), 'its corner is open')
   call check_close(distance_to_polygon([2.0_dp, 1.5_dp], bracket), 0.5_dp, 1e-15_dp, 'a place beside a side is as far from it')
   call check_close(distance_to_polygon([2.0_dp, 1.5_dp], bracket, [(i == 1, i=1, 6)]), 1.5_dp, 1e-15_dp, &
                    'or from the one that counts')
   call check_close(distance_to_polygon([-3.0_dp, -4.0_dp], bracket), 5.0_dp, 1e-15_dp, 'sides end at corners, the first')
   call check_close(distance_to_polygon([6.0_dp, 5.0_dp], bracket, [(i == 2, i=1, 6)]), 5.0_dp, 1e-15_dp, 'and the last')
   call check_close(distance_to_line([-3.0_dp, 4.0_dp], bracket(:, :2)), 5.0_dp, 1e-15_dp, 'a line ends at its points')
   call check(all(abs(side_lengths(bracket) - [3, 1, 2, 1, 1, 2]) <= 0), 'sides have lengths')
   call check(all(abs(ways_along(bracket) - [0, 3, 4, 6, 7, 8]) <= 0), 'which are the ways between corners')
   call check(maxval(abs(outward_normal(bracket, 6) - [-1, 0])) <= 0, 'normals point out of it')
   do turn = 1, 200
      call check_halves()
   end do
   call check_ties()
   call find_crossing(crossed, .true., i, j)
   call check(i == 1 .and. j == 3, 'sides one and three of a bow tie cross')
   call find_crossing(bracket, .true., i, j)
   call check(i == 0 .and. j == 0, 'those of a bracket do not')
   call find_crossing(crossed(:, :3), .false., i, j)
   call check(i == 0, 'neighbours have a point in common and do not cross')
   call check_meeting()
   call finish()

contains

   !> Both sides of a line have the whole together, of which a window and the box around it have the same.
   subroutine check_halves()
      real(dp), allocatable :: left(:, :), right(:, :), of_box(:, :), of_window(:, :)
      real(dp) :: on(2), normal(2), window(2, 4)
      call random_number(on)
      call random_number(normal)
      on = on*[3, 2]
      normal = normal - 0.5_dp
      left = bracket
      right = bracket
      call clip(left, on, normal)
      call clip(right, on, -normal)
      call check(maxval(abs(moments_of(left) + moments_of(right) - moments_of(bracket))) < 1e-13_dp, 'two halves are the whole')
      of_box = bracket
      of_window = bracket
      window = reshape([on(1) - 1, on(2) - 1, on(1) + 1, on(2) - 1, on(1) + 1, on(2) + 1, on(1) - 1, on(2) + 1], [2, 4])
      call clip_to_box(of_box, on - 1, on + 1)
      call clip_to(of_window, window)
      call check(maxval(abs(moments_of(of_box) - moments_of(of_window))) < 1e-13_dp, 'a box is a convex window')
      call check(all(of_box <= spread(on + 1, 2, size(of_box, 2))) .and. all(of_box >= spread(on - 1, 2, size(of_box, 2))), &
                 'new corners are on its sides to the last digit')
   end subroutine check_halves

   !> A line along a side keeps the whole on one side of it, and no area on the other.
   subroutine check_ties()
      real(dp), allocatable :: kept(:, :)
      kept = bracket
      call clip(kept, bracket(:, 1), [0.0_dp, 1.0_dp])
      call check(size(kept, 2) == 6, 'a line along a side adds no corner')
      kept = bracket(:, [1, 2, 3])
      call clip(kept, bracket(:, 1), [0.0_dp, -1.0_dp])
      call check(size(kept, 2) == 2, 'beyond it the side is left')
      kept = bracket
      call clip_to(kept, bracket(:, :0))
      call check(size(kept, 2) == 0, 'nothing is in no window')
   end subroutine check_ties

   !> Where a ray meets a segment, and what a rectangle has of one.
   subroutine check_meeting()
      real(dp) :: way, at
      call find_meeting([0.0_dp, 0.0_dp], [2.0_dp, 0.0_dp], [3.0_dp, -1.0_dp], [3.0_dp, 3.0_dp], way, at)
      call check(abs(way - 1.5_dp) + abs(at - 0.25_dp) < 1e-15_dp, 'a ray meets a segment')
      call find_meeting([0.0_dp, 0.0_dp], [2.0_dp, 0.0_dp], [0.0_dp, 1.0_dp], [3.0_dp, 1.0_dp], way, at)
      call check(way >= huge(way) .and. at >= huge(at), 'a parallel one is far away')
      call clip_segment([-1.0_dp, 0.5_dp], [3.0_dp, 0.5_dp], [0.0_dp, 0.0_dp], [1.0_dp, 1.0_dp], way, at)
      call check(abs(way - 0.25_dp) + abs(at - 0.5_dp) < 1e-15_dp, 'a rectangle has a part of a segment')
      call clip_segment([-1.0_dp, 2.0_dp], [3.0_dp, 2.0_dp], [0.0_dp, 0.0_dp], [1.0_dp, 1.0_dp], way, at)
      call check(at < way, 'or nothing')
      call check(do_cross([0.0_dp, 0.0_dp], [1.0_dp, 0.0_dp], [1.0_dp, 0.0_dp], [1.0_dp, 1.0_dp]) .and. .not. &
                 do_cross([0.0_dp, 0.0_dp], [1.0_dp, 0.0_dp], [2.0_dp, 0.0_dp], [3.0_dp, 0.0_dp]), &
                 'segments that touch have a point in common')
      call check(cross([1.0_dp, 0.0_dp], [0.0_dp, 1.0_dp]) > 0, 'left is above zero')
   end subroutine check_meeting
end program test_polygon
