!> Assembly of a stiffness, which couples the directions, on a mesh with hanging nodes, and its solution by factorisation.
!>
!> The stiffness of a linear elastic material in plane stress, with the shape functions of the elements:
!>
!>    K(d i, j k) = integral of lambda N_i,d N_k,j + mu N_i,j N_k,d + mu delta_dj grad N_i . grad N_k.
program test_element_assembly
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_gradients
   use hampm_constraints, only: constraints_t, constrain_box
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_element_assembly, only: pattern_of_elements, matrix_by_masters, add_element
   use hampm_factorisation, only: factorisation_t
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_grid, only: grid_t
   use hampm_grid_building, only: build_grid
   use hampm_harness, only: check, check_close, finish
   use hampm_numbering, only: numbering_t, number_unknowns, nodes_of_elements
   use hampm_refined, only: refine_box
   use hampm_sparse, only: sparse_t
   implicit none

   real(dp), parameter :: e_modulus = 3.0_dp, nu = 0.3_dp
   real(dp), parameter :: lambda = e_modulus*nu/(1 - nu**2), mu = e_modulus/(2*(1 + nu))
   type(grid_t) :: grid
   integer, allocatable :: nodes(:), elements(:)
   integer :: levels

   do levels = 0, 2, 2
      call build(levels)
      call check_stiffness()
      call check_patch()
   end do
   call check_messages()
   deallocate (nodes, elements)
   call finish()

contains

   !> A grid of 4 x 3 cells, those around the middle refined.
   subroutine build(levels)
      integer, intent(in) :: levels
      type(forest_t) :: forest
      type(failure_t) :: failure
      integer :: e
      forest = forest_t([0.5_dp, -1.0_dp], 0.5_dp, [4, 3])
      call refine_box(forest, [1.0_dp, -0.5_dp], [1.5_dp, 0.0_dp], levels)
      call build_grid(forest, grid, failure)
      call check(.not. failure%failed() .and. (grid%dofs%n_hanging > 0 .eqv. levels > 0), 'a refined grid has hanging nodes')
      elements = [(e, e=1, grid%n_elements)]
      call nodes_of_elements(grid, elements, nodes)
   end subroutine build

   !> Stiffness of the grid without fixed degrees of freedom.
   subroutine assemble(fixed, numbering, stiffness)
      logical, intent(in) :: fixed(:, :)
      type(numbering_t), intent(out) :: numbering
      type(sparse_t), intent(out) :: stiffness
      real(dp) :: by_corner(ndim*corners, ndim*corners), by_master(ndim*most_nodes_of_leaf, ndim*most_nodes_of_leaf)
      integer :: masters(most_nodes_of_leaf), n, e
      call number_unknowns(nodes, fixed, numbering)
      call pattern_of_elements(grid, elements, numbering, stiffness)
      do e = 1, grid%n_elements
         by_corner = element_stiffness(grid%element_size(e))
         call matrix_by_masters(grid, e, ndim, by_corner, n, masters, by_master)
         call add_element(numbering, masters(:n), by_master, stiffness)
      end do
   end subroutine assemble

   !> Stiffness of an element by its corners, by Gauss' rule of two points a direction, which is exact.
   function element_stiffness(size) result(k)
      real(dp), intent(in) :: size
      real(dp) :: k(ndim*corners, ndim*corners)
      real(dp), parameter :: points(2) = [0.5_dp - sqrt(1/12.0_dp), 0.5_dp + sqrt(1/12.0_dp)]
      real(dp) :: dn(corners, ndim)
      integer :: p, q, c, b, d, j
      k = 0
      do p = 1, 2
         do q = 1, 2
            dn = shape_gradients([points(p), points(q)], 1/size)
            do c = 1, corners
               do b = 1, corners
                  do j = 1, ndim
                     do d = 1, ndim
                        associate (entry => k(d + ndim*(c - 1), j + ndim*(b - 1)))
                           entry = entry + size**2/4*(lambda*dn(c, d)*dn(b, j) + mu*dn(c, j)*dn(b, d))
                           if (d == j) entry = entry + size**2/4*mu*dot_product(dn(c, :), dn(b, :))
                        end associate
                     end do
                  end do
               end do
            end do
         end do
      end do
   end function element_stiffness

   !> Without constraints it is symmetric, rigid motions need no force, and energies of linear fields are those of their strains.
   subroutine check_stiffness()
      type(numbering_t) :: numbering
      type(sparse_t) :: stiffness
      real(dp), allocatable :: u(:, :), f(:, :), dense(:, :)
      logical, allocatable :: fixed(:, :)
      real(dp) :: scale, area
      integer :: i, k
      allocate (fixed(ndim, grid%n_nodes), source=.false.)
      call assemble(fixed, numbering, stiffness)
      allocate (dense(stiffness%n, stiffness%n), source=0.0_dp)
      do i = 1, stiffness%n
         do k = stiffness%row_start(i), stiffness%row_start(i + 1) - 1
            dense(i, stiffness%column(k)) = stiffness%value(k)
         end do
      end do
      scale = maxval(abs(dense))
      call check_close(maxval(abs(dense - transpose(dense))), 0.0_dp, 1.0e-14_dp*scale, 'the stiffness is symmetric')
      associate (x => grid%node_position(:, :grid%n_nodes))
         allocate (u, f, mold=x)
         u(1, :) = 1
         u(2, :) = -2
         f = force(numbering, stiffness, u)
         call check_close(maxval(abs(f)), 0.0_dp, 1.0e-14_dp*scale, 'a translation needs no force')
         u(1, :) = -x(2, :)
         u(2, :) = x(1, :)
         f = force(numbering, stiffness, u)
         call check_close(maxval(abs(f)), 0.0_dp, 1.0e-14_dp*scale, 'nor does a small rotation')
         u(1, :) = x(1, :)
         u(2, :) = 0
         area = product(grid%forest%cells*grid%forest%cell)
         call check_close(sum(u*force(numbering, stiffness, u)), area*e_modulus/(1 - nu**2), 1.0e-13_dp*area*e_modulus, &
                          'the energy of a uniform strain is that of the material')
      end associate
   end subroutine check_stiffness

   !> Patch test: with a linear field held at the edges of the grid, it is the solution everywhere.
   subroutine check_patch()
      type(constraints_t) :: edges
      type(numbering_t) :: all_dofs, unknowns
      type(sparse_t) :: whole, stiffness
      type(factorisation_t) :: factorised
      type(failure_t) :: failure
      real(dp), allocatable :: expected(:, :), u(:, :), f(:, :), b(:), x(:)
      logical, allocatable :: free(:, :)
      integer :: i
      associate (from => grid%forest%lower, to => grid%forest%lower + grid%forest%cells*grid%forest%cell)
         call constrain_box(edges, grid, from, [from(1), to(2)], [.true., .true.])
         call constrain_box(edges, grid, from, [to(1), from(2)], [.true., .true.])
         call constrain_box(edges, grid, [to(1), from(2)], to, [.true., .true.])
         call constrain_box(edges, grid, [from(1), to(2)], to, [.true., .true.])
      end associate
      allocate (free(ndim, grid%n_nodes), source=.false.)
      call assemble(free, all_dofs, whole)
      call assemble(edges%fixed, unknowns, stiffness)
      allocate (expected(ndim, grid%n_nodes))
      expected(1, :) = 0.3_dp + 0.2_dp*grid%node_position(1, :grid%n_nodes) - 0.7_dp*grid%node_position(2, :grid%n_nodes)
      expected(2, :) = -0.1_dp + 0.5_dp*grid%node_position(1, :grid%n_nodes) + 0.4_dp*grid%node_position(2, :grid%n_nodes)
      u = merge(expected, 0.0_dp, edges%fixed)
      f = force(all_dofs, whole, u)
      allocate (b(unknowns%n), x(unknowns%n))
      b = [(-f(unknowns%direction(i), unknowns%node(i)), i=1, unknowns%n)]
      call factorised%factorise(stiffness, failure)
      call check(.not. failure%failed(), 'a stiffness with held edges is factorised')
      call factorised%solve(b, x)
      do i = 1, unknowns%n
         u(unknowns%direction(i), unknowns%node(i)) = x(i)
      end do
      call check_close(maxval(abs(u - expected)), 0.0_dp, 1.0e-14_dp, 'a linear field is the solution between its edges')
      call factorised%release()
   end subroutine check_patch

   !> K u by node.
   function force(numbering, stiffness, u) result(f)
      type(numbering_t), intent(in) :: numbering
      type(sparse_t), intent(in) :: stiffness
      real(dp), intent(in) :: u(:, :)
      real(dp) :: f(size(u, 1), size(u, 2))
      integer :: i, k
      f = 0
      do i = 1, stiffness%n
         associate (total => f(numbering%direction(i), numbering%node(i)))
            do k = stiffness%row_start(i), stiffness%row_start(i + 1) - 1
               associate (j => stiffness%column(k))
                  total = total + stiffness%value(k)*u(numbering%direction(j), numbering%node(j))
               end associate
            end do
         end associate
      end do
   end function force

   !> A failure says what is the matter with the matrix and leaves it to the caller to say whose it is.
   subroutine check_messages()
      type(numbering_t) :: numbering
      type(sparse_t) :: stiffness
      type(factorisation_t) :: factorised
      type(failure_t) :: failure
      logical, allocatable :: fixed(:, :)
      allocate (fixed(ndim, grid%n_nodes), source=.false.)
      call assemble(fixed, numbering, stiffness)
      stiffness%value = 0
      call factorised%factorise(stiffness, failure)
      call check(failure%failed(), 'a singular matrix is refused')
      call check(index(failure%message, 'mass') == 0 .and. index(failure%message, '&') == 0, &
                 'the message knows of no mass and of no key')
   end subroutine check_messages
end program test_element_assembly
