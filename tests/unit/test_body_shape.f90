!> Bodies against places, boxes, holes and each other: rectangles without an outline, polygons and circles.
program test_body_shape
   use hampm_kinds, only: dp, ndim
   use hampm_harness, only: check, check_close, finish
   use hampm_body_shape, only: body_shape_t, rectangle_ring
   use hampm_outline, only: circle_ring, polygon_ring, ring_t
   implicit none

   real(dp), parameter :: near = 1e-9_dp, tiny_part = 1e-13_dp
   type(body_shape_t) :: box, beside, wedge, disc, ring

   box = of_ring(rectangle_ring([0.0_dp, 0.0_dp], [2.0_dp, 1.0_dp]))
   deallocate (box%outline%rings)                ! as the namelist has it
   beside = of_ring(rectangle_ring([2.0_dp, 0.5_dp], [3.0_dp, 3.0_dp]))
   wedge = of_ring(polygon_ring(reshape([0.0_dp, 1.0_dp, 2.0_dp, 1.0_dp, 0.0_dp, 3.0_dp], [ndim, 3])))
   disc = of_ring(circle_ring([4.0_dp, 0.5_dp], 1.0_dp))
   ring = box
   call ring%add_hole(circle_ring([1.0_dp, 0.5_dp], 0.25_dp))

   call check_close(ring%area_in([-1.0_dp, -1.0_dp], [3.0_dp, 3.0_dp]), 2 - acos(-1.0_dp)/16, tiny_part, 'a hole is no material')
   call check_close(box%area_in([1.5_dp, -1.0_dp], [9.0_dp, 0.5_dp]), 0.25_dp, tiny_part, 'a box has a part of a rectangle')
   call check(box%holds([2.0_dp, 0.3_dp], near) .and. .not. box%holds([2.1_dp, 0.3_dp], near), 'an edge is in a body')
   call check(.not. ring%holds([1.0_dp, 0.5_dp], near) .and. ring%holds([1.25_dp, 0.5_dp], near), &
              'so is the wall of a hole, not its inside')
   call check_close(disc%room_beside([4.0_dp, 2.5_dp]), 1.0_dp, 1e-12_dp, 'a square fits beside a disc')
   call check_close(box%room_beside([1.0_dp, 0.5_dp]), 0.0_dp, tiny_part, 'none in a body')

   call check_close(box%gap_to(beside), 0.0_dp, tiny_part, 'bodies that touch are together')
   call check_close(box%gap_to(disc), 1.0_dp, tiny_part, 'a disc is as far from a rectangle')
   call check_close(disc%gap_to(box), box%gap_to(disc), tiny_part, 'as that from it')
   call check_close(wedge%gap_to(disc), abs(norm2([4.0_dp, 0.5_dp] - [2.0_dp, 1.0_dp]) - 1), 1e-12_dp, 'and from a corner')
   call check(.not. box%overlaps(beside, near) .and. .not. box%overlaps(wedge, near), &
              'bodies with an edge in common do not overlap')
   call check(wedge%overlaps(of_ring(circle_ring([1.5_dp, 2.0_dp], 0.6_dp)), near), 'a disc through a slanted side does')
   call check(.not. ring%overlaps(of_ring(circle_ring([1.0_dp, 0.5_dp], 0.2_dp)), near), 'one in a hole does not')

   call check(box%surrounds(circle_ring([1.0_dp, 0.5_dp], 0.4_dp)), 'a hole is inside')
   call check(.not. box%surrounds(circle_ring([1.0_dp, 0.5_dp], 0.5_dp)), 'one that touches an edge is not')
   call check(.not. wedge%surrounds(circle_ring([1.5_dp, 2.0_dp], 0.2_dp)), 'nor one outside of a slanted side')
   call finish()

contains

   !> A body inside a ring.
   type(body_shape_t) function of_ring(ring) result(shape)
      type(ring_t), intent(in) :: ring
      shape%lower = ring%lower()
      shape%upper = ring%upper()
      allocate (shape%outline%rings(1))
      shape%outline%rings(1) = ring
   end function of_ring
end program test_body_shape
