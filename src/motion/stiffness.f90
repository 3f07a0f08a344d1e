!> The stiffness of a motion's material on its grid, by the particles as points of quadrature,
!>
!>    K_ij = sum_p V_p (grad N_i)' C (grad N_j),
!>
!> with the laws linearised about zero strain, and solutions with it. Unknowns are the degrees of freedom of the nodes with material
!> that no constraint fixes.
!>
!> What nothing holds has rigid motions, against which K is no resistance. So what is factorised is K + shift M with the lumped
!> masses M, the shift so small that it matters to nothing else.
module hampm_stiffness
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_gradients, inside_cell
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_element_assembly, only: pattern_of_elements, matrix_by_masters, add_element
   use hampm_factorisation, only: factorisation_t
   use hampm_failure, only: failure_t
   use hampm_motion, only: motion_t
   use hampm_numbering, only: numbering_t, number_unknowns, nodes_of_elements
   use hampm_sparse, only: sparse_t
   implicit none
   private
   public :: stiffness_t, new_stiffness

   !> Shift over the largest K_ii/M_ii: an eigenvalue of a rigid motion is then a thousand times the rounding of a factorisation, and
   !> that of a slender body with a thousand cells along it still a thousand times the shift.
   real(dp), parameter :: relative_shift = 1e-13_dp

   !> A stiffness that can be solved with.
   type :: stiffness_t
      type(numbering_t) :: numbering             !! of the unknowns
      real(dp), allocatable :: mass(:)           !! lumped, of each unknown [kg], (n)
      real(dp) :: shift = 0                      !! [1/s2]
      type(factorisation_t), private :: factorised
   contains
      procedure :: solve
      procedure :: gather
      procedure :: release
   end type stiffness_t

contains

   !> Assemble and factorise the stiffness of a motion whose particles are up to date and whose nodes have their masses. Fails where
   !> the memory does not suffice.
   subroutine new_stiffness(m, s, failure)
      type(motion_t), intent(in) :: m
      type(stiffness_t), intent(out) :: s
      type(failure_t), intent(inout) :: failure
      type(sparse_t) :: matrix
      integer, allocatable :: elements(:), nodes(:)
      real(dp), allocatable :: diagonal(:)
      logical, allocatable :: fixed(:, :)
      real(dp) :: weight(corners, most_nodes_of_leaf)
      integer :: masters(most_nodes_of_leaf), n, k, i
      associate (grid => m%grid, lumped => m%fields%mass_matrix%lumped)
         elements = pack([(k, k=1, grid%n_elements)], m%blocks%count_in > 0)
         call nodes_of_elements(grid, elements, nodes)
         allocate (fixed, source=m%constraints%fixed)
         do k = 1, size(nodes)
            if (.not. lumped(nodes(k)) > 0) fixed(:, nodes(k)) = .true.
         end do
         call number_unknowns(nodes, fixed, s%numbering)
         call pattern_of_elements(grid, elements, s%numbering, matrix)
         do k = 1, size(elements)
            call grid%dofs%masters_of(grid%element_nodes(:, elements(k)), n, masters, weight)
            call add_element(s%numbering, masters(:n), matrix_by_masters(ndim, weight, stiffness_of_cell(m, elements(k))), matrix)
         end do
         s%mass = lumped(s%numbering%node)
      end associate
      if (s%numbering%n == 0) return
      allocate (diagonal(matrix%n))
      do i = 1, matrix%n
         associate (row => [(k, k=matrix%row_start(i), matrix%row_start(i + 1) - 1)])
            diagonal(i) = sum(matrix%value(row), mask=matrix%column(row) == i)
         end associate
      end do
      s%shift = relative_shift*maxval(diagonal/s%mass)
      do i = 1, matrix%n
         call matrix%add(i, i, s%shift*s%mass(i))
      end do
      call s%factorised%analyse(matrix, failure)
      if (.not. failure%failed()) call s%factorised%factorise(matrix, failure)
   end subroutine new_stiffness

   !> Stiffness of a cell by its corners, the directions of a corner one after the other [N/m].
   pure function stiffness_of_cell(m, e) result(k)
      type(motion_t), intent(in) :: m
      integer, intent(in) :: e                   !! the element
      real(dp) :: k(ndim*corners, ndim*corners)
      real(dp) :: dn(ndim, corners), lambda, mu
      integer :: i, a, b
      k = 0
      do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
         associate (p => m%particles, material => m%materials(m%particles%material(i)))
            dn = transpose(shape_gradients(inside_cell(m%grid%local_coordinate(e, p%place_in_grid(i))), &
                                           1/m%grid%element_size(e)))
            lambda = p%volume(i)*material%small_strain_lambda()
            mu = p%volume(i)*material%mu
         end associate
         do b = 1, corners
            do a = 1, corners
               k(ndim*a - 1:ndim*a, ndim*b - 1:ndim*b) = k(ndim*a - 1:ndim*a, ndim*b - 1:ndim*b) + coupling(dn(:, a), dn(:, b))
            end do
         end do
      end do
   contains
      !> lambda g h' + mu (h g' + g . h I) of two gradients of shape functions.
      pure function coupling(g, h) result(c)
         real(dp), intent(in) :: g(ndim), h(ndim)
         real(dp) :: c(ndim, ndim)
         integer :: d, j
         do j = 1, ndim
            do d = 1, ndim
               c(d, j) = lambda*g(d)*h(j) + mu*h(d)*g(j)
            end do
            c(j, j) = c(j, j) + mu*dot_product(g, h)
         end do
      end function coupling
   end function stiffness_of_cell

   !> x with (K + shift M) x = b, by unknown.
   subroutine solve(self, b, x)
      class(stiffness_t), intent(in) :: self
      real(dp), intent(in) :: b(:)
      real(dp), intent(out) :: x(:)
      call self%factorised%solve(b, x)
   end subroutine solve

   !> The unknowns' part of a nodal field.
   pure function gather(self, field) result(x)
      class(stiffness_t), intent(in) :: self
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp) :: x(self%numbering%n)
      integer :: i
      do i = 1, self%numbering%n
         x(i) = field(self%numbering%direction(i), self%numbering%node(i))
      end do
   end function gather

   !> Give back the memory.
   subroutine release(self)
      class(stiffness_t), intent(inout) :: self
      call self%factorised%release()
   end subroutine release
end module hampm_stiffness
