!> Constraints hold the chosen components of the nodes in their boxes, and nothing else.
program test_constraints
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constraints_t, given_motion_t, constrain_box, add_box, rebuild_constraints, hold
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish
   use hampm_time_history, only: time_history_t
   implicit none

   type(grid_t) :: grid
   type(constraints_t) :: c
   type(failure_t) :: failure
   real(dp) :: field(ndim, 6*4)
   real(dp) :: way(ndim, 6*4)
   logical :: bottom, left, right
   integer :: node, wrong

   call build_grid(forest_t(lower=[0.0_dp, 0.0_dp], cell=0.1_dp, cells=[5, 3]), grid, failure)
   field = 1
   call check(.not. c%holds(1, 1), 'without constraints no node is held')
   call hold(c, field)
   call check_close(minval(field), 1.0_dp, 0.0_dp, 'and no field is changed')

   call constrain_box(c, grid, [0.0_dp, 0.0_dp], [0.5_dp, 0.0_dp], [.false., .true.])
   call constrain_box(c, grid, [0.0_dp, 0.1_dp], [0.0_dp, 0.3_dp], [.true., .false.])
   call constrain_box(c, grid, [0.0_dp, 0.0_dp], [0.0_dp, 0.0_dp], [.true., .false.])
   call hold(c, field)
   wrong = 0
   do node = 1, grid%n_nodes
      bottom = grid%node_position(2, node) < 0.05_dp
      left = grid%node_position(1, node) < 0.05_dp
      if ((c%holds(node, 1) .neqv. left) .or. (c%holds(node, 2) .neqv. bottom)) wrong = wrong + 1
      if (any(abs(field(:, node) - merge(0.0_dp, 1.0_dp, [left, bottom])) > 0)) wrong = wrong + 1
   end do
   call check(wrong == 0, 'the nodes on the faces of the boxes are held in the chosen components, the others are free')
   call check(size(c%node) == 9 .and. all(c%node(2:) > c%node(:8)), 'each held node is listed once, in ascending order')

   call check(.not. c%move(), 'nothing moves that is only held')
   call add_box(c, [0.5_dp, 0.0_dp], [0.5_dp, 0.3_dp], [.true., .false.], &
                given_motion_t([0.2_dp, 0.0_dp], [0.1_dp, 0.0_dp], time_history_t('ramp', rise_time=2.0_dp)))
   call rebuild_constraints(c, grid)
   call check(c%move(), 'a box with a motion moves its nodes')
   way = c%prescribed_at(3.0_dp)
   wrong = 0
   do node = 1, grid%n_nodes
      right = grid%node_position(1, node) > 0.45_dp
      if (abs(way(1, node) - merge(0.2_dp + 0.1_dp*2, 0.0_dp, right)) > 1e-15_dp .or. abs(way(2, node)) > 0) wrong = wrong + 1
   end do
   call check(wrong == 0, 'by its displacement times the factor and its velocity times the integral of that, and no others')
   call finish()
end program test_constraints
