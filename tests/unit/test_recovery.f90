!> Patch recovery holds linear fields at every node, edges of bodies and nodes beside cells of other sizes included; it keeps
!> materials apart; and what rests on it: no estimated error where the stress is linear.
program test_recovery
   use hampm_kinds, only: dp, ndim
   use hampm_error_indicator, only: estimate_errors
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish
   use hampm_matching, only: adopt_forest
   use hampm_material, only: material_t, new_material
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_recovery, only: recover
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t, place_bodies, start
   implicit none

   real(dp), parameter :: slope(ndim) = [0.7_dp, -0.3_dp], rounding = 1.0e-11_dp
   type(problem_t) :: m

   call build(m)
   call linear_field()
   call two_materials()
   call linear_stress()
   call finish()

contains

   !> A body of 4 by 2 root cells, refined by two levels in a corner and in the middle.
   subroutine build(m)
      type(problem_t), intent(out) :: m
      type(forest_t) :: forest
      type(failure_t) :: failure
      forest = forest_t([0.0_dp, 0.0_dp], 1.0_dp, [5, 3])
      call place_bodies(forest, new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.3_dp), &
                        [rectangle_t([0.0_dp, 0.0_dp], [4.0_dp, 2.0_dp], [8, 4])], m)
      call start(m, 'musl')
      call refine_box(forest, [0.0_dp, 0.0_dp], [0.7_dp, 0.7_dp], 2)
      call refine_box(forest, [2.0_dp, 1.0_dp], [3.0_dp, 1.6_dp], 2)
      call adopt_forest(m, forest, failure)
      call check(.not. failure%failed(), 'the mesh is refined')
      call refresh_grid(m)
   end subroutine build

   subroutine linear_field()
      real(dp), allocatable :: value(:), nodal(:)
      integer :: i
      allocate (nodal(m%grid%n_points))
      value = [(3 + dot_product(slope, m%particles%place_in_grid(i)), i=1, m%particles%n)]
      call recover(m%matter_t, m%fields%mass_matrix, 1, value, nodal)
      associate (all => m%fields%mass_matrix%all)
         do i = 1, all%n_nodes
            call check_close(nodal(all%nodes(i)), 3 + dot_product(slope, m%grid%node_position(:, all%nodes(i))), &
                             rounding, 'a linear field is recovered at every node')
         end do
      end associate
   end subroutine linear_field

   !> The other material has another value, which is not to be seen.
   subroutine two_materials()
      real(dp), allocatable :: value(:), nodal(:)
      integer :: i
      allocate (nodal(m%grid%n_points))
      do i = 1, m%particles%n
         m%particles%material(i) = merge(1, 2, m%particles%reference(i, 1) < 1.5_dp)
      end do
      value = merge(1.0_dp, 5.0_dp, m%particles%material(:m%particles%n) == 1)
      call recover(m%matter_t, m%fields%mass_matrix, 1, value, nodal, material=1)
      do i = 1, m%grid%n_nodes
         associate (x => m%grid%node_position(:, i))
            if (x(1) <= 1.5_dp .and. x(2) <= 2) call check_close(nodal(i), 1.0_dp, rounding, 'the value of the one material')
         end associate
      end do
      m%particles%material(:m%particles%n) = 1
   end subroutine two_materials

   subroutine linear_stress()
      real(dp), allocatable :: squared(:)
      real(dp) :: norm
      integer :: i
      do i = 1, m%particles%n
         m%particles%gradient(i, :, :) = 1.0e-6_dp*dot_product(slope, m%particles%place_in_grid(i))
      end do
      call estimate_errors(m, squared, norm)
      call check_close(sum(squared)/norm, 0.0_dp, rounding, 'a linear stress has no estimated error')
   end subroutine linear_stress
end program test_recovery
