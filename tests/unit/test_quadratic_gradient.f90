!> The refinement parameter R of quadratic cells. Of a stress whose norm is quadratic it is the closed form at every corner inside,
!> whatever the sizes of
!> the cells around: (h**2/2) (s_xx + s_yy)/2 over s, where h is the smallest of them, as in bilinear cells of this size, in which
!> phi would be exact. Of a
!> quadratic energy density it is that of the paper's means, which bilinear cells of this size have: phi is the density plus
!> h**2/12 (e_xx + e_yy).
program test_quadratic_gradient
   use hampm_kinds, only: dp, ndim
   use hampm_cell_values, only: mean_of_nodes
   use hampm_recovery, only: are_corners
   use hampm_forest, only: forest_t
   use hampm_gradient_indicator, only: nodal_field, refinement_parameter
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_problem, only: problem_t
   use hampm_quadratic_samples, only: fill_with_quadratic
   use hampm_random_forests, only: change_at_random, random_integer
   use hampm_threads, only: use_threads
   implicit none

   real(dp), parameter :: cell = 0.25_dp, rounding = 1.0e-12_dp
   real(dp), parameter :: ridge = 1.0e-6_dp      ! what the fit of `hampm_recovery` leaves, which keeps open terms small by 1e-9 of its sums
   integer, parameter :: roots = 4, meshes = 200
   integer :: k, looked_at = 0

   call repeat_random_numbers()
   call use_threads(1, 0)
   do k = 1, meshes
      call stress_on_random_mesh(3 + mod(k, 3))
   end do
   call check(looked_at > 10*meshes, 'corners inside are looked at')
   call energy_on_uniform_mesh()
   call finish()

contains

   !> 4 + x**2 + x y/2 + 2 y**2, of which the second derivatives are 2 and 4.
   pure real(dp) function quadratic(x)
      real(dp), intent(in) :: x(ndim)
      quadratic = 4 + x(1)**2 + x(1)*x(2)/2 + 2*x(2)**2
   end function quadratic

   subroutine stress_on_random_mesh(n)
      integer, intent(in) :: n                   !! particles a cell and direction
      type(problem_t) :: m
      type(forest_t) :: forest
      real(dp), allocatable :: phi(:), r(:)
      real(dp) :: factor, asked
      integer :: i
      forest = forest_t([0.0_dp, 0.0_dp], cell, [roots, roots])
      do i = 1, random_integer(1, 3)
         call change_at_random(forest, 0.2_dp, 0.1_dp, 3)
      end do
      call fill_with_quadratic(forest, n, roots*cell, 3.0_dp, 1.0_dp, m)
      do i = 1, m%particles%n
         m%particles%gradient(i, :, :) = 0
         m%particles%gradient(i, 1, 1) = 1.0e-6_dp*quadratic(m%particles%place_in_grid(i))
      end do
      factor = norm2(m%materials(1)%kirchhoff_stress(reshape([1.0e-6_dp, 0.0_dp, 0.0_dp, 0.0_dp], [ndim, ndim])))
      call nodal_field(m, 'stress_norm', phi)
      call refinement_parameter(m, 'stress_norm', phi, r)
      associate (is_corner => are_corners(m%matter_t))
         do i = 1, m%grid%n_nodes
            associate (x => m%grid%node_position(:, i), h => m%grid%smallest_leaf_at(i))
               call check_close(phi(i), factor*quadratic(x), ridge*factor*4, 'a quadratic field is recovered at every node')
               if (.not. is_corner(i) .or. any(x < h/2 .or. x > roots*cell - h/2)) cycle
               asked = h**2/2*(2 + 4)/2/quadratic(x)
               call check_close(r(i), asked, ridge, 'R is the closed form beside cells of any size')
               looked_at = looked_at + 1
            end associate
         end do
      end associate
   end subroutine stress_on_random_mesh

   !> A strain that is linear in x and y has a quadratic energy density.
   subroutine energy_on_uniform_mesh()
      type(problem_t) :: m
      real(dp), parameter :: slope(ndim) = [0.7_dp, -0.3_dp], h = cell
      real(dp), allocatable :: phi(:), r(:)
      real(dp) :: unit, strain, bend, mean
      integer :: i
      call fill_with_quadratic(forest_t([0.0_dp, 0.0_dp], cell, [roots, roots]), 3, roots*cell, 3.0_dp, 1.0_dp, m)
      do i = 1, m%particles%n
         m%particles%gradient(i, :, :) = 0
         m%particles%gradient(i, 1, 1) = 1.0e-3_dp*(2 + dot_product(slope, m%particles%place_in_grid(i)))
      end do
      unit = m%materials(1)%energy_density(reshape([1.0e-3_dp, 0.0_dp, 0.0_dp, 0.0_dp], [ndim, ndim]))
      call nodal_field(m, 'energy_density', phi)
      call refinement_parameter(m, 'energy_density', phi, r)
      bend = h**2*sum(slope**2)                  ! h**2/2 (e_xx + e_yy), over `unit`
      associate (is_corner => are_corners(m%matter_t))
         do i = 1, m%grid%n_nodes
            associate (x => m%grid%node_position(:, i))
               if (.not. is_corner(i) .or. any(x < 1.5_dp*h .or. x > (roots - 1.5_dp)*h)) cycle
               strain = 2 + dot_product(slope, x)
               call check_close(phi(i)/unit, strain**2 + bend/6, rounding, 'the energy density is the mean around a node')
               call check_close(r(i), bend/2/(strain**2 + bend/6), rounding, 'R of the paper')
            end associate
         end do
      end associate
      mean = (r(m%grid%element_nodes(1, 1)) + r(m%grid%element_nodes(2, 2)) + r(m%grid%element_nodes(3, 3)) &
              + r(m%grid%element_nodes(4, 4)))/4
      call check_close(mean_of_nodes(m%grid, 1, r), mean, rounding, 'the mean R of a cell is that of its corners')
   end subroutine energy_on_uniform_mesh
end program test_quadratic_gradient
