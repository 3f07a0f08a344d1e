!> Factorised mass matrices: one for each component, without the unknowns that are held in it. Components with the same held
!> nodes share one. Nodes that only lumped cells touch are not among the unknowns: each is divided by its own mass.
module hampm_direct
   use hampm_kinds, only: dp, ndim, corners
   use hampm_banded, only: banded_t
   use hampm_failure, only: failure_t
   use hampm_grid, only: grid_t, most_nodes_of_leaf
   use hampm_mass_matrix, only: mass_matrix_t, coupled_cells
   use hampm_sparse, only: sparse_t, pattern_of_cliques
   use hampm_umfpack, only: umfpack_t
   implicit none
   private
   public :: direct_t

   !> The factorised matrix of some components.
   type :: factor_t
      integer, allocatable :: node(:)            !! node of each unknown
      integer, allocatable :: unknown(:)         !! unknown of each node, 0 where it is none, (n_nodes)
      type(sparse_t) :: matrix
      real(dp), allocatable :: b(:), x(:)        !! workspace of a solution
      type(umfpack_t) :: umfpack
      type(banded_t) :: banded
   end type factor_t

   !> The factors of a mass matrix, and which component uses which.
   type :: direct_t
      logical :: by_umfpack = .true.             !! else by banded Cholesky
      integer :: analyses = 0                    !! how often the pattern has been analysed
      integer :: factorisations = 0              !! how often the numbers have been factorised
      integer, private :: of_component(ndim) = 0 !! which factor belongs to a component
      type(factor_t), allocatable, private :: factors(:)
      integer, allocatable :: coupled(:)         !! cells whose matrix is not lumped, when the pattern was analysed
   contains
      procedure :: factorise
      procedure :: factorised_values
      procedure :: factorise_values
      procedure :: fits
      procedure :: solve
      procedure :: bandwidth
      procedure :: release
   end type direct_t

contains

   !> Factorise a matrix; its pattern is analysed anew only if it has changed.
   subroutine factorise(self, grid, mass, held, failure)
      class(direct_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: mass
      logical, intent(in) :: held(:, :)          !! which components are held, (ndim, n_nodes)
      type(failure_t), intent(inout) :: failure
      integer, allocatable :: coupled(:)
      integer :: k
      allocate (coupled, source=coupled_cells(mass))
      if (.not. same_pattern(self, coupled)) call analyse(self, grid, coupled, held, failure)
      do k = 1, size(self%factors)
         if (failure%failed()) return
         associate (factor => self%factors(k))
            if (size(factor%node) == 0) cycle
            call fill(factor, grid, mass, coupled)
            call factorise_numbers(factor, self%by_umfpack, failure)
         end associate
      end do
      self%factorisations = self%factorisations + 1
   end subroutine factorise

   !> Factorise the matrix of some components, whose pattern has been analysed.
   subroutine factorise_numbers(factor, by_umfpack, failure)
      type(factor_t), intent(inout) :: factor
      logical, intent(in) :: by_umfpack
      type(failure_t), intent(inout) :: failure
      if (by_umfpack) then
         call factor%umfpack%factorise(factor%matrix, failure)
      else
         call factor%banded%factorise(factor%matrix, failure)
      end if
   end subroutine factorise_numbers

   !> The numbers that were factorised last: with `coupled` all that the factors come from.
   pure function factorised_values(self) result(values)
      class(direct_t), intent(in) :: self
      real(dp), allocatable :: values(:)
      integer :: k
      allocate (values(0))
      do k = 1, size(self%factors)
         if (size(self%factors(k)%node) > 0) values = [values, self%factors(k)%matrix%value]
      end do
   end function factorised_values

   !> Factorise what was factorised before: the numbers of the cells that were coupled then. `fits` is false where these are not as
   !> many as they have to be.
   subroutine factorise_values(self, grid, coupled, values, held, fits, failure)
      class(direct_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coupled(:)
      real(dp), intent(in) :: values(:)
      logical, intent(in) :: held(:, :)          !! which components are held, (ndim, n_nodes)
      logical, intent(out) :: fits
      type(failure_t), intent(inout) :: failure
      integer :: k, first
      call analyse(self, grid, coupled, held, failure)
      first = 1
      do k = 1, size(self%factors)
         associate (factor => self%factors(k))
            if (size(factor%node) == 0) cycle
            associate (last => first + size(factor%matrix%value) - 1)
               fits = last <= size(values)
               if (.not. fits .or. failure%failed()) return
               factor%matrix%value = values(first:last)
            end associate
            call factorise_numbers(factor, self%by_umfpack, failure)
            first = first + size(factor%matrix%value)
         end associate
      end do
      fits = first == size(values) + 1
   end subroutine factorise_values

   !> Whether the factorised matrix has the unknowns of a matrix, so that it may precondition it.
   pure logical function fits(self, mass)
      class(direct_t), intent(in) :: self
      type(mass_matrix_t), intent(in) :: mass
      fits = same_pattern(self, coupled_cells(mass))
   end function fits

   !> Whether the coupled cells are those of the last analysis.
   pure logical function same_pattern(self, coupled)
      type(direct_t), intent(in) :: self
      integer, intent(in) :: coupled(:)
      same_pattern = .false.
      if (.not. allocated(self%coupled)) return
      if (size(self%coupled) /= size(coupled)) return
      same_pattern = all(self%coupled == coupled)
   end function same_pattern

   !> Number the unknowns and analyse their pattern.
   subroutine analyse(self, grid, coupled, held, failure)
      class(direct_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coupled(:)
      logical, intent(in) :: held(:, :)
      type(failure_t), intent(inout) :: failure
      integer :: d, same, k
      call self%release()
      self%coupled = coupled
      k = 0
      do d = 1, ndim
         do same = 1, d
            if (all(held(same, :) .eqv. held(d, :))) exit
         end do
         if (same == d) k = k + 1
         self%of_component(d) = merge(k, self%of_component(same), same == d)
      end do
      allocate (self%factors(k))
      do d = 1, ndim
         associate (factor => self%factors(self%of_component(d)))
            if (allocated(factor%node)) cycle
            call number_unknowns(factor, grid, coupled, held(d, :))
            if (size(factor%node) == 0) cycle
            if (self%by_umfpack) then
               call factor%umfpack%analyse(factor%matrix, failure)
            else
               call factor%banded%analyse(factor%matrix)
            end if
         end associate
      end do
      self%analyses = self%analyses + 1
   end subroutine analyse

   !> The unknowns of a component and the pattern of their matrix.
   subroutine number_unknowns(factor, grid, coupled, held)
      type(factor_t), intent(inout) :: factor
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coupled(:)
      logical, intent(in) :: held(:)
      integer, allocatable :: cliques(:, :)
      integer :: nodes(most_nodes_of_leaf), k, c, n, n_here
      real(dp) :: part(corners, most_nodes_of_leaf)
      allocate (factor%unknown(grid%n_nodes), source=0)
      allocate (cliques(merge(corners, most_nodes_of_leaf, grid%dofs%n_hanging == 0), size(coupled)), source=0)
      n = 0
      do k = 1, size(coupled)
         call grid%element_matrix(coupled(k), n_here, nodes, part)
         do c = 1, n_here
            associate (node => nodes(c))
               if (factor%unknown(node) == 0 .and. .not. held(node)) then
                  n = n + 1
                  factor%unknown(node) = n
               end if
               cliques(c, k) = factor%unknown(node)
            end associate
         end do
      end do
      allocate (factor%node(n))
      do k = 1, grid%n_nodes
         if (factor%unknown(k) > 0) factor%node(factor%unknown(k)) = k
      end do
      call pattern_of_cliques(n, cliques, factor%matrix)
      allocate (factor%b(n), factor%x(n))
   end subroutine number_unknowns

   !> Fill the matrix from its cells; what other cells add to its nodes is on the diagonal.
   subroutine fill(factor, grid, mass, coupled)
      type(factor_t), intent(inout) :: factor
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: mass
      integer, intent(in) :: coupled(:)
      real(dp) :: rest(size(factor%node)), part(corners, most_nodes_of_leaf)
      real(dp) :: by_node(most_nodes_of_leaf, most_nodes_of_leaf)
      integer :: nodes(most_nodes_of_leaf), k, r, c, i, j, n
      factor%matrix%value = 0
      rest = mass%lumped(factor%node)
      do k = 1, size(coupled)
         call grid%element_matrix(coupled(k), n, nodes, part)
         by_node = matmul(transpose(part), matmul(mass%cell(:, :, coupled(k)), part))
         do c = 1, n
            j = factor%unknown(nodes(c))
            if (j == 0) cycle
            rest(j) = rest(j) - sum(by_node(:n, c))
            do r = 1, n
               i = factor%unknown(nodes(r))
               if (i > 0) call factor%matrix%add(i, j, by_node(r, c))
            end do
         end do
      end do
      do i = 1, size(rest)
         call factor%matrix%add(i, i, max(rest(i), 0.0_dp))
      end do
   end subroutine fill

   !> x = A^-1 b at the unknowns of A, the matrix that was factorised; the other nodes of `x` stay.
   subroutine solve(self, b, x)
      class(direct_t), intent(inout) :: self
      real(dp), intent(in) :: b(:, :)            !! (ndim, n_nodes)
      real(dp), intent(inout) :: x(:, :)         !! (ndim, n_nodes)
      integer :: d, i
      do d = 1, ndim
         associate (factor => self%factors(self%of_component(d)))
            if (size(factor%node) == 0) cycle
            do i = 1, size(factor%node)
               factor%b(i) = b(d, factor%node(i))
            end do
            if (self%by_umfpack) then
               call factor%umfpack%solve(factor%b, factor%x)
            else
               call factor%banded%solve(factor%b, factor%x)
            end if
            do i = 1, size(factor%node)
               x(d, factor%node(i)) = factor%x(i)
            end do
         end associate
      end do
   end subroutine solve

   !> Entries beside the diagonal of the banded matrices, to one side.
   pure integer function bandwidth(self)
      class(direct_t), intent(in) :: self
      bandwidth = 0
      if (allocated(self%factors)) bandwidth = maxval(self%factors%banded%bandwidth)
   end function bandwidth

   !> Give back the memory.
   subroutine release(self)
      class(direct_t), intent(inout) :: self
      integer :: k
      if (.not. allocated(self%factors)) return
      do k = 1, size(self%factors)
         call self%factors(k)%umfpack%release()
      end do
      deallocate (self%factors, self%coupled)
   end subroutine release
end module hampm_direct
