!> Unknowns are numbered without the fixed degrees of freedom, one direction at a time or all together, and found again.
program test_numbering
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constraints_t, constrain_box
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, finish
   use hampm_numbering, only: numbering_t, number_unknowns, nodes_of_elements
   use hampm_refined, only: refine_box
   implicit none

   type(grid_t) :: grid
   type(constraints_t) :: constraints
   integer, allocatable :: nodes(:)
   integer :: d

   call build()
   call nodes_are_met_in_order()
   do d = 1, ndim
      call check_numbering('direction by direction', constraints%fixed(d:d, :))
   end do
   call check_numbering('together', constraints%fixed)
   call check_turning()
   call elements_of_hanging_nodes()
   deallocate (nodes)
   call finish()

contains

   !> A refined grid with an edge fixed in x, and a corner in both directions; the nodes of its elements.
   subroutine build()
      type(forest_t) :: forest
      type(failure_t) :: failure
      integer :: e
      forest = forest_t([0.0_dp, 0.0_dp], 1.0_dp, [4, 3])
      call refine_box(forest, [1.0_dp, 1.0_dp], [2.0_dp, 2.0_dp], 2)
      call build_grid(forest, grid, failure)
      call check(.not. failure%failed() .and. grid%dofs%n_hanging > 0, 'the grid has hanging nodes')
      call constrain_box(constraints, grid, [0.0_dp, 0.0_dp], [0.0_dp, 3.0_dp], [.true., .false.])
      call constrain_box(constraints, grid, [0.0_dp, 0.0_dp], [0.0_dp, 0.0_dp], [.true., .true.])
      call nodes_of_elements(grid, [(e, e=1, grid%n_elements)], nodes)
   end subroutine build

   !> All elements have all nodes with degrees of freedom, each once; the first four are the corners of the first element.
   subroutine nodes_are_met_in_order()
      integer :: node
      call check(size(nodes) == grid%n_nodes .and. all([(any(nodes == node), node=1, grid%n_nodes)]), &
                 'the elements have every node, once')
      call check(all(nodes(:4) == grid%element_nodes(:, 1)), 'in the order of the elements and of their corners')
   end subroutine nodes_are_met_in_order

   !> The edge in x turns with one unknown: what is scattered is that times the weights, what is gathered its moment.
   subroutine check_turning()
      type(constraints_t) :: pin
      type(numbering_t) :: numbering
      integer, allocatable :: group(:, :)
      real(dp), allocatable :: weight(:, :), field(:, :), x(:)
      pin = constraints
      allocate (group(ndim, grid%n_nodes), source=merge(2, 0, pin%fixed .and. pin%box == 1))
      allocate (weight(ndim, grid%n_nodes), source=spread(1 - grid%node_position(2, :grid%n_nodes), 1, ndim))
      call number_unknowns(nodes, pin%fixed .and. group == 0, numbering, group, weight)
      call check(count(group > 0) > 1 .and. numbering%n == count(.not. pin%fixed) + 1, 'components that turn are one unknown')
      allocate (field(ndim, grid%n_points), source=0.0_dp)
      allocate (x(numbering%n), source=0.0_dp)
      x(maxval(pack(numbering%dof, group > 0))) = 3
      call numbering%scatter(x, field)
      call check(all(abs(field(:, :grid%n_nodes) - merge(3*weight, 0.0_dp, group > 0)) <= 0), 'each by its weight')
      x = numbering%gather(field)
      call check(abs(sum(x) - 3*sum(weight**2, mask=group > 0)) <= 1e-12_dp, 'and its equation is theirs by the same weights')
   end subroutine check_turning

   subroutine check_numbering(what, fixed)
      character(*), intent(in) :: what
      logical, intent(in) :: fixed(:, :)
      type(numbering_t) :: numbering
      integer :: i, k, d, last
      call number_unknowns(nodes, fixed, numbering)
      call check(numbering%n == count(.not. fixed) .and. maxval(numbering%dof) == numbering%n, &
                 what//': there are as many unknowns as degrees of freedom that are not fixed')
      call check(all((numbering%dof == 0) .eqv. fixed), what//': those that are fixed have no number')
      call check(all([(numbering%dof(numbering%direction(i), numbering%node(i)) == i, i=1, numbering%n)]), &
                 what//': each number leads to its node and direction and back')
      last = 0
      do k = 1, size(nodes)
         do d = 1, size(fixed, 1)
            if (fixed(d, nodes(k))) cycle
            last = last + 1
            if (numbering%dof(d, nodes(k)) /= last) call check(.false., what//': numbers follow the nodes')
         end do
      end do
      call check(last == numbering%n, what//': without gaps')
   end subroutine check_numbering

   !> Of some nodes only: the others have no unknowns. The nodes of an element with hanging nodes are the masters of these.
   subroutine elements_of_hanging_nodes()
      type(numbering_t) :: numbering
      integer :: e
      do e = 1, grid%n_elements
         if (any(grid%element_nodes(:, e) > grid%n_nodes)) exit
      end do
      call nodes_of_elements(grid, [e], nodes)
      call check(all(nodes <= grid%n_nodes) .and. size(nodes) > count(grid%element_nodes(:, e) <= grid%n_nodes), &
                 'an element with hanging nodes has their masters')
      call number_unknowns(nodes, constraints%fixed, numbering)
      call check(all(numbering%dof(:, nodes) > 0 .or. constraints%fixed(:, nodes)) .and. &
                 count(numbering%dof > 0) == numbering%n, 'other nodes have no unknowns')
   end subroutine elements_of_hanging_nodes
end program test_numbering
