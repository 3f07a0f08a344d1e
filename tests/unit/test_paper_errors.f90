!> The errors that Tan and Nairn (2001) reckon with, (24)-(30): that of interpolating a quadratic field before and after a cell
!> refines, and that of lumping the mass matrix.
!>
!> docs/explanation/paper_estimates.md derives their figures, with what the paper's point (p) and its (30) are. Their c is the edge of a material point,
!> (15), and so half the edge of a cell with four of them. Second derivatives of one direction at a time are looked at, and the mixed one, as in
!> a sum the errors of both directions may cancel.
program test_paper_errors
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_mass_choice, only: mass_choice_t, new_mass_choice
   use hampm_matching, only: adopt_forest
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_samples, only: rectangle_t, place_bodies, start
   implicit none

   real(dp), parameter :: c = 0.35_dp            !! edge of a material point [m]
   real(dp), parameter :: lower(ndim) = [0.2_dp, -0.6_dp]
   real(dp), parameter :: rounding = 1.0e-13_dp

   !> A quadratic field.
   type :: quadratic_t
      real(dp) :: value = 0
      real(dp) :: slope(ndim) = 0
      real(dp) :: second(ndim) = 0               !! derivatives xx and yy
      real(dp) :: mixed = 0                      !! derivative xy
   end type quadratic_t

   call repeat_random_numbers()
   call interpolation()
   call opposite_curvatures()
   call lumping(0, 1.0_dp)
   call lumping(1, 0.25_dp)
   call finish()

contains

   !> Value at a place.
   pure real(dp) function at(q, x)
      type(quadratic_t), intent(in) :: q
      real(dp), intent(in) :: x(ndim)
      at = q%value + dot_product(q%slope, x) + 0.5_dp*dot_product(q%second, x**2) + q%mixed*x(1)*x(2)
   end function at

   !> A field with a random linear part and one of the three second derivatives.
   function random_field(which) result(q)
      integer, intent(in) :: which               !! 1: xx, 2: yy, 3: xy
      type(quadratic_t) :: q
      call random_number(q%value)
      call random_number(q%slope)
      if (which <= ndim) then
         q%second(which) = 1
      else
         q%mixed = 1
      end if
   end function random_field

   !> A body that fills `cells` root cells, each with four material points, refined `levels` times.
   subroutine new_body(cells, levels, m, mass)
      integer, intent(in) :: cells(ndim), levels
      type(problem_t), intent(out) :: m
      type(mass_choice_t), intent(in), optional :: mass
      type(forest_t) :: forest
      type(failure_t) :: failure
      integer, allocatable :: change(:)
      integer :: level
      forest = forest_t(lower, 2*c, cells)
      call place_bodies(forest, new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.3_dp), &
                        [rectangle_t(lower, lower + 2*c*cells, 2*cells)], m)
      m%particles%total_frame = .true.
      call start(m, 'usl', mass)
      do level = 1, levels
         allocate (change(forest%leaf_count()), source=1)
         call forest%adapt(change)
         deallocate (change)
         call adopt_forest(m, forest, failure)
         call check(.not. failure%failed(), 'the body refines')
      end do
   end subroutine new_body

   !> Error of interpolating a field at `x` from its values at the nodes.
   real(dp) function interpolation_error(grid, q, x) result(error)
      type(grid_t), intent(in) :: grid
      type(quadratic_t), intent(in) :: q
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer :: e, k
      e = grid%element_at(x)
      error = dot_product(shape_functions(grid%local_coordinate(e, x)), &
                          [(at(q, grid%node_position(:, grid%element_nodes(k, e))), k=1, corners)]) - at(q, x)
   end function interpolation_error

   !> One cell, and the four cells with 16 material points that it becomes.
   subroutine interpolation()
      type(problem_t) :: coarse, fine
      type(quadratic_t) :: q
      real(dp) :: middle(ndim), from_middle, before, after, wrong, least
      integer :: i, d, inner
      call new_body([1, 1], 0, coarse)
      call new_body([1, 1], 1, fine)
      middle = lower + c
      call check(coarse%particles%n == 4 .and. fine%particles%n == 16, '(26): 4 material points become 16')
      wrong = 0
      least = huge(least)
      inner = 0
      do i = 1, fine%particles%n
         associate (x => fine%particles%position(i))
            do d = 1, ndim
               q = random_field(d)
               before = interpolation_error(coarse%grid, q, x)/c**2
               after = interpolation_error(fine%grid, q, x)/c**2
               from_middle = abs(x(d) - middle(d))/c
               least = min(least, before/after)
               if (abs(from_middle - 0.25_dp) < rounding) then
                  inner = inner + 1
                  wrong = max(wrong, abs(before - 15.0_dp/32), abs(after - 3.0_dp/32))
               else
                  wrong = max(wrong, abs(from_middle - 0.75_dp), abs(before - 7.0_dp/32), abs(after - 3.0_dp/32))
               end if
            end do
            q = random_field(3)
            wrong = max(wrong, abs(interpolation_error(coarse%grid, q, x)), abs(interpolation_error(fine%grid, q, x)))
         end associate
      end do
      call check(inner == 16, '(26): in each direction half of the new points are a quarter of c from the middle')
      call check_close(wrong, 0.0_dp, rounding, '(26): 15/32 before and 3/32 after there, 7/32 and 3/32 at the others, '// &
                       'and none from the mixed derivative')
      call check_close(least, 7.0_dp/3, 100*rounding, 'at all new points refining reduces the error by 7/3 at least')
      do i = 1, coarse%particles%n
         q = random_field(1)
         associate (x => coarse%particles%position(i))
            call check_close(interpolation_error(coarse%grid, q, x)/c**2, 12.0_dp/32, rounding, 'at an old point it is 12/32')
            call check_close(interpolation_error(fine%grid, q, x)/c**2, 4.0_dp/32, rounding, 'and becomes 4/32')
         end associate
      end do
   end subroutine interpolation

   !> What the paper does not say: at a new point off the diagonals, errors of the coarse cell cancel for one ratio of curvatures of
   !> opposite signs, and refining makes the error larger. At those on the diagonals both directions have one factor.
   subroutine opposite_curvatures()
      type(problem_t) :: coarse, fine
      type(quadratic_t) :: q
      real(dp) :: x(ndim)
      call new_body([1, 1], 0, coarse)
      call new_body([1, 1], 1, fine)
      q = quadratic_t(second=[7.0_dp, -15.0_dp])
      x = lower + c*[1.25_dp, 1.75_dp]
      call check_close(interpolation_error(coarse%grid, q, x)/c**2, 0.0_dp, 10*rounding, &
                       'curvatures of opposite signs can leave no error in a coarse cell')
      call check_close(interpolation_error(fine%grid, q, x)/c**2, -24.0_dp/32, 10*rounding, 'and some in a fine one')
   end subroutine opposite_curvatures

   !> Two by two root cells, of which each has become 4**levels: the node in the middle has the eight around it in a regular mesh.
   !> The error is multiplied by `reduced`, as c**2 is.
   subroutine lumping(levels, reduced)
      integer, intent(in) :: levels
      real(dp), intent(in) :: reduced
      type(problem_t) :: m
      type(quadratic_t) :: q
      real(dp) :: expected(3), linear
      integer :: node, which
      call new_body([2, 2], levels, m, new_mass_choice('consistent', 'cg', 1, 0.0_dp, [0.0_dp, 0.0_dp], [0.0_dp, 0.0_dp]))
      call refresh_grid(m)
      node = m%grid%node_at(lower + 2*c)
      associate (mass => m%fields%mass_matrix%lumped(node), m_p => m%particles%mass(1))
         call check_close(mass/(4*m_p), 1.0_dp, rounding, 'the lumped mass of a node is that of four material points')
         expected = [0.75_dp, 0.75_dp, 0.0_dp]*c**2*reduced
         do which = 1, 3
            q = random_field(which)
            call check_close(lumping_error(m, node, q)/mass, expected(which), rounding, &
                             '(30): over the mass of the node, lumping errs by 3/4 c**2 (a_xx + a_yy)')
            call check_close(lumping_error(m, node, q), 4*m_p*expected(which), rounding, '(28): that is 3 m_p c**2')
         end do
         q = random_field(3)
         q%mixed = 0
         linear = lumping_error(m, node, q)
         call check_close(linear/mass, 0.0_dp, rounding, 'lumping does not err where the acceleration is linear')
      end associate
   end subroutine lumping

   !> The difference (28), of M a and D a at a node, with the sign turned; M is summed from the cells.
   real(dp) function lumping_error(m, node, q) result(error)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: node
      type(quadratic_t), intent(in) :: q
      integer :: e, k, j
      error = -m%fields%mass_matrix%lumped(node)*at(q, m%grid%node_position(:, node))
      do e = 1, m%grid%n_elements
         do k = 1, corners
            if (m%grid%element_nodes(k, e) /= node) cycle
            do j = 1, corners
               error = error + m%fields%mass_matrix%cell(j, k, e)*at(q, m%grid%node_position(:, m%grid%element_nodes(j, e)))
            end do
         end do
      end do
   end function lumping_error
end program test_paper_errors
