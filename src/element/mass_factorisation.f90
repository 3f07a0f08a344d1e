!> Factorised mass matrices: one for each direction, without the degrees of freedom that are fixed in it. Directions with the same
!> fixed nodes share one. Nodes that only lumped cells touch are not among the unknowns: each is divided by its own mass.
module hampm_mass_factorisation
   use hampm_kinds, only: dp, ndim
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_element_assembly, only: pattern_of_elements, matrix_by_masters, add_element
   use hampm_factorisation, only: factorisation_t
   use hampm_failure, only: failure_t
   use hampm_grid, only: grid_t
   use hampm_jumps, only: jump_t, nodes_of_jumps
   use hampm_mass_matrix, only: mass_matrix_t, coupled_cells
   use hampm_mass_product, only: find_concentrated_mass
   use hampm_numbering, only: numbering_t, number_unknowns, nodes_of_elements
   use hampm_sparse, only: sparse_t
   implicit none
   private
   public :: mass_factorisation_t

   !> The factorised matrix of some directions.
   type :: factor_t
      type(numbering_t) :: unknowns              !! of one of these
      type(sparse_t) :: matrix
      type(factorisation_t) :: factorised
      integer, allocatable :: directions(:)      !! that it is for
      real(dp), allocatable :: b(:), x(:)        !! workspace of a solution: the unknowns of the directions, one after the other
   end type factor_t

   !> The factors of a mass matrix, and which direction uses which.
   type :: mass_factorisation_t
      integer :: analyses = 0                    !! how often the pattern has been analysed
      integer :: factorisations = 0              !! how often the numbers have been factorised
      type(jump_t), allocatable :: ghosts(:) !! of the matrix
      type(factor_t), allocatable, private :: factors(:)
      integer, allocatable :: coupled(:)         !! cells whose matrix is not lumped, each as its first element, when the pattern
                                                 !! was analysed
   contains
      procedure :: factorise
      procedure :: factorised_values
      procedure :: factorise_values
      procedure :: fits
      procedure :: is_definite
      procedure :: solve
      procedure :: release
   end type mass_factorisation_t

contains

   !> Factorise a matrix; its pattern is analysed anew only if it has changed.
   subroutine factorise(self, grid, mass, fixed, failure)
      class(mass_factorisation_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: mass
      logical, intent(in) :: fixed(:, :)         !! which degrees of freedom are fixed, (ndim, n_nodes)
      type(failure_t), intent(inout) :: failure
      integer, allocatable :: coupled(:)
      integer :: k
      allocate (coupled, source=coupled_cells(mass))
      if (.not. same_pattern(self, coupled)) call analyse(self, grid, coupled, fixed)
      do k = 1, size(self%factors)
         if (failure%failed()) return
         associate (factor => self%factors(k))
            if (factor%unknowns%n == 0) cycle
            call fill(factor, grid, mass, coupled)
            call factorise_numbers(factor, failure)
         end associate
      end do
      self%factorisations = self%factorisations + 1
   end subroutine factorise

   !> Factorise the matrix of some directions, whose pattern has been analysed.
   subroutine factorise_numbers(factor, failure)
      type(factor_t), intent(inout) :: factor
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: part
      character(:), allocatable :: cause
      call factor%factorised%factorise(factor%matrix, part)
      if (.not. part%failed()) return
      cause = 'masses of nodes are next to nothing, in cells with little material at an edge or a crack: use &method mass = '// &
              '''lumped''; or the run is unstable: reduce courant, or time_step of implicit steps; or the grid is too large '// &
              'for it: use &method solver = ''cg'''
      call failure%report(part%code, 'mass matrix: '//part%message//'. Likely cause: '//cause)
   end subroutine factorise_numbers

   !> The numbers that were factorised last: with `coupled` all that the factors come from.
   pure function factorised_values(self) result(values)
      class(mass_factorisation_t), intent(in) :: self
      real(dp), allocatable :: values(:)
      integer :: k
      allocate (values(0))
      do k = 1, size(self%factors)
         if (self%factors(k)%unknowns%n > 0) values = [values, self%factors(k)%matrix%value]
      end do
   end function factorised_values

   !> Factorise what was factorised before: the numbers of the cells that were coupled then. `fits` is false where these are not as
   !> many as they have to be.
   subroutine factorise_values(self, grid, coupled, values, fixed, fits, failure)
      class(mass_factorisation_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coupled(:)
      real(dp), intent(in) :: values(:)
      logical, intent(in) :: fixed(:, :)         !! which degrees of freedom are fixed, (ndim, n_nodes)
      logical, intent(out) :: fits
      type(failure_t), intent(inout) :: failure
      integer :: k, first
      call analyse(self, grid, coupled, fixed)
      first = 1
      do k = 1, size(self%factors)
         associate (factor => self%factors(k))
            if (factor%unknowns%n == 0) cycle
            associate (last => first + size(factor%matrix%value) - 1)
               fits = last <= size(values)
               if (.not. fits .or. failure%failed()) return
               factor%matrix%value = values(first:last)
            end associate
            call factorise_numbers(factor, failure)
            first = first + size(factor%matrix%value)
         end associate
      end do
      fits = first == size(values) + 1
   end subroutine factorise_values

   !> Whether the factorised matrix has the unknowns of a matrix, so that it may precondition it.
   pure logical function fits(self, mass)
      class(mass_factorisation_t), intent(in) :: self
      type(mass_matrix_t), intent(in) :: mass
      fits = same_pattern(self, coupled_cells(mass))
   end function fits

   !> Whether what was factorised is positive definite.
   pure logical function is_definite(self)
      class(mass_factorisation_t), intent(in) :: self
      integer :: k
      is_definite = all([(self%factors(k)%factorised%is_definite .or. self%factors(k)%unknowns%n == 0, k=1, size(self%factors))])
   end function is_definite

   !> Whether the coupled cells are those of the last analysis.
   pure logical function same_pattern(self, coupled)
      type(mass_factorisation_t), intent(in) :: self
      integer, intent(in) :: coupled(:)
      same_pattern = .false.
      if (.not. allocated(self%coupled)) return
      if (size(self%coupled) /= size(coupled)) return
      same_pattern = all(self%coupled == coupled)
   end function same_pattern

   !> Number the unknowns and find the pattern of their matrices.
   subroutine analyse(self, grid, coupled, fixed)
      class(mass_factorisation_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coupled(:)
      logical, intent(in) :: fixed(:, :)         !! (ndim, n_nodes)
      integer, allocatable :: nodes(:)
      integer :: of_direction(ndim), d, same, k  ! which factor belongs to a direction
      call self%release()
      self%coupled = coupled
      call nodes_of_elements(grid, coupled, nodes)
      k = 0
      do d = 1, ndim
         do same = 1, d
            if (all(fixed(same, :) .eqv. fixed(d, :))) exit
         end do
         if (same == d) k = k + 1
         of_direction(d) = merge(k, of_direction(same), same == d)
      end do
      allocate (self%factors(k))
      do k = 1, size(self%factors)
         d = findloc(of_direction, k, dim=1)
         associate (factor => self%factors(k))
            call number_unknowns(nodes, fixed(d:d, :), factor%unknowns)
            if (factor%unknowns%n == 0) cycle
            factor%factorised%cholmod%solves_often = .true.
            call pattern_of_elements(grid, coupled, factor%unknowns, factor%matrix, nodes_of_jumps(self%ghosts))
            factor%directions = pack([(d, d=1, ndim)], of_direction == k)
            associate (n => factor%unknowns%n*size(factor%directions))
               allocate (factor%b(n), factor%x(n))
            end associate
         end associate
      end do
      self%analyses = self%analyses + 1
   end subroutine analyse

   !> Fill the matrix from its cells; what other cells add to its nodes is on the diagonal.
   subroutine fill(factor, grid, mass, coupled)
      type(factor_t), intent(inout) :: factor
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: mass
      integer, intent(in) :: coupled(:)
      real(dp), allocatable :: rest(:)           ! (n_points)
      real(dp) :: by_master(most_nodes_of_leaf, most_nodes_of_leaf)
      integer :: masters(most_nodes_of_leaf), k, i, n
      factor%matrix%value = 0
      do k = 1, size(coupled)
         call matrix_by_masters(grid, coupled(k), 1, mass%cell(:, :, mass%cell_of(coupled(k))), n, masters, by_master)
         call add_element(factor%unknowns, masters(:n), by_master, factor%matrix)
      end do
      call find_concentrated_mass(grid, mass, rest)
      do i = 1, factor%unknowns%n
         call factor%matrix%add(i, i, rest(factor%unknowns%node(i)))
      end do
      do k = 1, size(mass%ghosts)
         associate (point => mass%ghosts(k))
            n = count(point%node > 0)
            call add_element(factor%unknowns, point%node(:n), &
                             point%mass*spread(point%share(:n), 1, n)*spread(point%share(:n), 2, n), factor%matrix)
         end associate
      end do
   end subroutine fill

   !> x = A^-1 b at the unknowns of A, the matrix that was factorised; `x` stays at the others.
   subroutine solve(self, b, x)
      class(mass_factorisation_t), intent(inout) :: self
      real(dp), intent(in) :: b(:, :)            !! (ndim, n_points)
      real(dp), intent(inout) :: x(:, :)         !! (ndim, n_points)
      integer :: k, j
      do k = 1, size(self%factors)
         associate (factor => self%factors(k), n => self%factors(k)%unknowns%n)
            if (n == 0) cycle
            do j = 1, size(factor%directions)
               associate (d => factor%directions(j))
                  factor%b((j - 1)*n + 1:j*n) = factor%unknowns%gather(b(d:d, :))
               end associate
            end do
            call factor%factorised%solve(factor%b, factor%x)
            do j = 1, size(factor%directions)
               associate (d => factor%directions(j))
                  call factor%unknowns%scatter(factor%x((j - 1)*n + 1:j*n), x(d:d, :))
               end associate
            end do
         end associate
      end do
   end subroutine solve

   !> Give back the memory.
   subroutine release(self)
      class(mass_factorisation_t), intent(inout) :: self
      integer :: k
      if (.not. allocated(self%factors)) return
      do k = 1, size(self%factors)
         call self%factors(k)%factorised%release()
      end do
      deallocate (self%factors, self%coupled)
   end subroutine release
end module hampm_mass_factorisation
