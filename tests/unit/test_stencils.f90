!> Stencils of points are their rows in the assembled mass and stiffness matrices, and points with equal ones are found as runs: in a
!> box, around a hole, between materials and between levels of refinement.
program test_stencils
   use hampm_kinds, only: dp, ndim, corners
   use hampm_element_operators, only: keeps_sums
   use hampm_element_stiffness, only: element_stiffness
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_material, only: material_t, new_material
   use hampm_pass, only: pass_t
   use hampm_problem, only: problem_t, map_to_grid
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t, place_bodies, start
   use hampm_sorting, only: sort_into_cells
   use hampm_failure, only: failure_t
   use hampm_stencils, only: apply_stencils
   implicit none
   real(dp), parameter :: cell = 0.1_dp
   integer, parameter :: along = 16, across = 9  !! cells of the body
   type(forest_t) :: forest
   type(problem_t) :: m

   call repeat_random_numbers()
   forest = forest_t([0.0_dp, 0.0_dp], cell, [along + 4, across + 4])

   call place(forest, [rectangle(2, 2, along, across)], m)
   call check(size(m%cache%operators%runs) == 3*(across + 1), 'a row of a box is a run between its ends')
   call check(count(m%cache%operators%runs%n == along - 1) == across + 1, 'which has all nodes between these')
   call check(maxval(m%cache%operators%runs%stencil) == 9, 'a box has the stencils of its inside, four sides and four corners')
   call check_products(m, 'a box')

   call place(forest, [rectangle(2, 2, along, 3), rectangle(2, 5, 4, 3), rectangle(9, 5, 9, 3), rectangle(2, 8, along, 3)], m)
   call check(count(m%cache%operators%runs%n == along - 1) == 6, 'rows of a box with a hole are whole above and below it')
   call check(count(m%cache%operators%runs%n == 3) == 4 .and. count(m%cache%operators%runs%n == 8) == 4, &
              'beside it they end at its edges')
   call check_products(m, 'a box with a hole')

   call place(forest, [rectangle(2, 2, along, across)], m, other='linear_elastic')
   call check(count(m%cache%operators%runs%n == along/2 - 1) == 2*(across + 1), 'rows end where the material is another one')
   call check(size(m%cache%operators%storing) == (along + 1)*(across + 1), 'where laws are linear all points keep their sums')
   call check_products(m, 'two materials')

   call place(forest, [rectangle(2, 2, along, across)], m, other='neo_hookean')
   call check(size(m%cache%operators%storing) > 0 .and. any(m%cache%operators%runs%home > 0), &
              'at cells of a nonlinear law points gather their sums')
   call check_products(m, 'a linear and a nonlinear material')

   call refine_box(forest, [0.5_dp, 0.5_dp], [1.0_dp, 0.8_dp], 1)
   call place(forest, [rectangle(2, 2, along, across)], m)
   call check(m%grid%dofs%n_hanging > 0, 'the mesh is refined')
   call check_products(m, 'two levels')
   call finish()

contains

   !> A rectangle of whole cells, filled with sixteen particles each.
   type(rectangle_t) function rectangle(column, row, width, height)
      integer, intent(in) :: column, row         !! cells on the left of it and below it
      integer, intent(in) :: width, height       !! in cells
      rectangle = rectangle_t(cell*[column, row], cell*[column + width, row + height], 4*[width, height])
   end function rectangle

   !> A body of rectangles, the right half of which may have another material, mapped.
   subroutine place(forest, rectangles, m, other)
      type(forest_t), intent(in) :: forest
      type(rectangle_t), intent(in) :: rectangles(:)
      type(problem_t), intent(out) :: m
      character(*), intent(in), optional :: other
      type(material_t), allocatable :: first(:)
      type(failure_t) :: failure
      call place_bodies(forest, new_material('', 'linear_elastic', .true., 1.0_dp, 0.3_dp, 1.0_dp), rectangles, m)
      if (present(other)) then
         call move_alloc(m%materials, first)    ! a constructor of an array would leak in gfortran 12
         allocate (m%materials(2))
         m%materials(1) = first(1)
         m%materials(2) = new_material('', other, .true., 3.0_dp, 0.1_dp, 2.0_dp)
         where (m%particles%reference(:, 1) > cell*(2 + along/2)) m%particles%material = 2
         call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      end if
      m%particles%total_frame = .true.
      call start(m, 'usl')
      call map_to_grid(m)
   end subroutine place

   !> Each point is in one run, and what its stencil gives is what the matrices of the cells give.
   subroutine check_products(m, what)
      type(problem_t), intent(inout) :: m
      character(*), intent(in) :: what
      real(dp), dimension(ndim, m%grid%n_points) :: a, v, momentum, force, by_momentum, by_force
      real(dp) :: stiffness(ndim*corners, ndim*corners)
      integer :: times(m%grid%n_points), k, e, c
      call random_number(a)
      call random_number(v)
      momentum = 0
      force = 0
      m%fields%contribution = 0
      associate (operators => m%cache%operators)
         call apply_stencils(operators%stencils, operators%runs, pass_t(kick=.true., strain_fraction=0.5_dp), 2.0_dp, &
                             m%grid%n_points, a, v, momentum, force, m%fields%contribution(1, 1, 1, 0))
         call gather_home(m, momentum, force)
         times = 0
         do k = 1, size(operators%runs)
            associate (run => operators%runs(k))
               times(run%first:run%first + run%n - 1) = times(run%first:run%first + run%n - 1) + 1
            end associate
         end do
         by_momentum = 0
         by_force = 0
         do k = 1, size(operators%with)
            do c = 1, count(m%blocks%cells(:, operators%with(k)) > 0)
               e = m%blocks%cells(c, operators%with(k))
               associate (nodes => m%grid%element_nodes(:, e))
                  call element_stiffness(m%matter_t, [e], .true., 0.0_dp, stiffness)
                  by_force(:, nodes) = by_force(:, nodes) - reshape(matmul(stiffness, reshape(v(:, nodes), [ndim*corners])), &
                                                                    [ndim, corners])
                  by_momentum(:, nodes) = by_momentum(:, nodes) + 2*matmul(a(:, nodes), mass_of(m, e))
                  call check(all(times(nodes) == 1), what//': a point of a cell with an operator is in one run')
               end associate
            end do
         end do
         call check(all(keeps_sums(operators, operators%storing)), what//': listed points keep their sums')
      end associate
      call check_close(maxval(abs(force - by_force)), 0.0_dp, 1e-13_dp*maxval(abs(by_force)), what//': forces')
      call check_close(maxval(abs(momentum - by_momentum)), 0.0_dp, 1e-13_dp*maxval(abs(by_momentum)), what//': momenta')
   end subroutine check_products

   !> Add what points have in the contributions of their cells.
   subroutine gather_home(m, momentum, force)
      type(problem_t), intent(in) :: m
      real(dp), intent(inout) :: momentum(:, :), force(:, :)
      integer :: b, l, c
      do b = 1, m%blocks%n
         do l = 1, count(m%blocks%cells(:, b) > 0)
            do c = 1, corners
               associate (point => m%blocks%nodes(c, l, b))
                  momentum(:, point) = momentum(:, point) + m%fields%contribution(l, c, 2:3, b)
                  force(:, point) = force(:, point) + m%fields%contribution(l, c, 4:5, b)
               end associate
            end do
         end do
      end do
   end subroutine gather_home

   !> Mass matrix of a cell.
   function mass_of(m, e) result(mass)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      real(dp) :: mass(corners, corners), n(corners)
      integer :: i
      mass = 0
      do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
         n = m%functions_of(i)
         mass = mass + m%particles%mass(i)*spread(n, 1, corners)*spread(n, 2, corners)
      end do
   end function mass_of
end program test_stencils
