!> Meshes of quadratic cells that change: what the particles carry into finer cells and back is the field that they had, and momentum and mass stay,
!> whatever field they carry into coarser cells.
program test_quadratic_children
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_matching, only: adopt_forest
   use hampm_problem, only: problem_t
   use hampm_newton, only: displace
   use hampm_quadratic_samples, only: fill_with_quadratic
   use hampm_random_forests, only: random_integer
   use hampm_threads, only: use_threads
   implicit none

   real(dp), parameter :: thickness = 0.5_dp, density = 3.0_dp, cell = 0.25_dp
   integer, parameter :: roots = 3, meshes = 200
   real(dp) :: field, momentum, mass
   integer :: k, refined

   call repeat_random_numbers()
   call use_threads(1, 0)                        ! meshes are too small for more
   field = 0
   momentum = 0
   mass = 0
   refined = 0
   do k = 1, meshes
      call look_at_change(3 + mod(k, 3))
   end do
   call check(refined > meshes/2, 'most meshes refine')
   call check_close(field, 0.0_dp, 1e-12_dp, 'displacement, its gradient and velocity are those of one field')
   call check_close(momentum, 0.0_dp, 1e-13_dp, 'linear momentum stays')
   call check_close(mass, 0.0_dp, 1e-13_dp, 'mass stays')
   call finish()

contains

   !> A random field on a random mesh with n particles a cell and direction, which then refines, by one level and more.
   subroutine look_at_change(n)
      integer, intent(in) :: n
      type(problem_t) :: m, before
      type(forest_t) :: forest
      type(failure_t) :: failure
      real(dp), allocatable :: u(:, :)
      real(dp) :: total(ndim)
      integer :: i
      forest = forest_t([0.0_dp, 0.0_dp], cell, [roots, roots])
      call fill_with_quadratic(forest, n, roots*cell, density, thickness, m)
      call refine_at_random(forest)
      call adopt_forest(m, forest, failure)
      allocate (u(ndim, m%grid%n_points))
      call random_number(u)
      call m%grid%dofs%distribute(m%grid%dofs%every_node(), ndim, u)
      call displace(m, u)
      m%particles%velocity = 2*m%particles%displacement
      total = momentum_of(m)
      before = m
      do i = 1, random_integer(1, 2)
         call refine_at_random(forest)
      end do
      call adopt_forest(m, forest, failure)
      call check(.not. failure%failed(), 'the mesh changes')
      if (m%particles%n > before%particles%n) refined = refined + 1
      do i = 1, m%particles%n
         call compare(before, u, m, i)
      end do
      momentum = max(momentum, maxval(abs(momentum_of(m) - total)))
      call adopt_forest(m, before%grid%forest, failure)
      call check(.not. failure%failed() .and. m%particles%n == before%particles%n, 'cells recombine')
      do i = 1, m%particles%n
         call compare(before, u, m, i)
      end do
      momentum = max(momentum, maxval(abs(momentum_of(m) - total)))
      call adopt_forest(m, forest, failure)
      call random_number(m%particles%velocity)
      total = momentum_of(m)
      call adopt_forest(m, before%grid%forest, failure)
      momentum = max(momentum, maxval(abs(momentum_of(m) - total)))
      mass = max(mass, abs(sum(m%particles%mass(:m%particles%n)) - density*thickness*(roots*cell)**2))
   end subroutine look_at_change

   !> Divide some leaves, one in four.
   subroutine refine_at_random(forest)
      type(forest_t), intent(inout) :: forest
      integer :: change(forest%leaf_count()), k
      change = [(merge(1, 0, random_integer(1, 4) == 1 .and. forest%level_of(k) < 4), k=1, size(change))]
      call forest%adapt(change)
      call forest%balance()
   end subroutine refine_at_random

   !> Linear momentum [kg m/s].
   function momentum_of(m) result(total)
      type(problem_t), intent(in) :: m
      real(dp) :: total(ndim)
      total = matmul(m%particles%mass(:m%particles%n), m%particles%velocity(:m%particles%n, :))
   end function momentum_of

   !> A particle against the field of the nodes of the mesh before.
   subroutine compare(before, u, m, i)
      type(problem_t), intent(in) :: before, m
      real(dp), intent(in) :: u(:, :)
      integer, intent(in) :: i
      real(dp) :: exact(ndim), h(ndim, ndim), xi(ndim), x(ndim)
      real(dp), allocatable :: of_cell(:, :)
      integer :: e
      x = m%particles%reference(i, :)
      e = before%grid%element_at(x)
      xi = before%grid%local_coordinate(e, x)
      allocate (of_cell, source=u(:, before%grid%support_of(e)))
      exact = matmul(of_cell, before%grid%functions_in(e, xi))
      h = matmul(of_cell, before%grid%gradients_in(e, xi))
      field = max(field, maxval(abs(m%particles%displacement(i, :) - exact)), maxval(abs(m%particles%velocity(i, :) - 2*exact)), &
                  cell/8*maxval(abs(m%particles%gradient_of(i) - h)))
   end subroutine compare
end program test_quadratic_children
