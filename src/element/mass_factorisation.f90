!> Factorised mass matrices of the directions, each without the degrees of freedom that are fixed in it. Directions share a factor
!> if each fixes either all nodes that any of them fixes, or only those that all of them fix, as on rollers: these are eliminated
!> last. Nodes with lumped cells only are no unknowns: each is divided by its own mass.
module hampm_mass_factorisation
   use hampm_archive, only: archive_t
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
   use hampm_text, only: to_text
   implicit none
   private
   public :: mass_factorisation_t

   !> The factorised matrix of some directions.
   type :: factor_t
      type(numbering_t) :: unknowns              !! of one of these
      type(sparse_t) :: matrix
      type(factorisation_t) :: factorised
      integer, allocatable :: directions(:)      !! that it is for
      logical, allocatable :: last(:)            !! unknowns that are fixed in some of these
      logical, allocatable :: without(:)         !! whether they are in this one, (directions)
      real(dp), allocatable :: b(:), x(:)        !! workspace of a solution: the directions side by side at each unknown
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
      procedure :: serialise
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
      if (.not. same_pattern(self, coupled)) call analyse(self, grid, coupled, fixed, .true.)
      do
         do k = 1, size(self%factors)
            if (failure%failed()) return
            associate (factor => self%factors(k))
               if (factor%unknowns%n == 0) cycle
               call fill(factor, grid, mass, coupled)
               call factorise_numbers(factor, failure)
            end associate
         end do
         if (self%is_definite() .or. size(self%factors) == ndim) exit
         call analyse(self, grid, coupled, fixed, .false.)
      end do
      self%factorisations = self%factorisations + 1
   end subroutine factorise

   !> Factorise the matrix of some directions, whose pattern has been analysed.
   subroutine factorise_numbers(factor, failure)
      type(factor_t), intent(inout) :: factor
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: part
      character(:), allocatable :: cause
      call factor%factorised%factorise(factor%matrix, part, factor%last)
      if (.not. part%failed()) return
      cause = 'masses of nodes are next to nothing, in cells with little material at an edge or a crack: use &method mass = '// &
              '''lumped''; or the run is unstable: reduce courant, or time_step of implicit steps; or the grid is too large '// &
              'for it: use &method solver = ''cg'''
      call failure%report(part%code, 'mass matrix: '//part%message//'. Likely cause: '//cause)
   end subroutine factorise_numbers

   !> Archive the numbers factorised last, and the number of factorisations. Numbers read are factorised, with the cells coupled
   !> then being of this grid.
   subroutine serialise(self, grid, fixed, is_factorised, archive)
      class(mass_factorisation_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: fixed(:, :)         !! which degrees of freedom are fixed, (ndim, n_nodes)
      logical, intent(inout) :: is_factorised
      class(archive_t), intent(inout) :: archive
      integer, allocatable :: coupled(:)
      integer :: analyses, factorisations, n_coupled, k
      logical :: is_shared
      analyses = self%analyses
      factorisations = self%factorisations
      call archive%serialise('analyses', analyses)
      call archive%serialise('factorisations', factorisations)
      if (is_factorised) then
         is_shared = .false.
         allocate (coupled(0))
         if (.not. archive%is_read) then
            is_shared = size(self%factors) < ndim
            coupled = self%coupled
         end if
         n_coupled = size(coupled)
         call archive%serialise('is_shared', is_shared)
         call archive%serialise('number_coupled', n_coupled)
         if (archive%is_read) then
            deallocate (coupled)
            allocate (coupled(n_coupled))
         end if
         call archive%archive_integers('coupled', n_coupled, coupled)
         if (archive%is_read .and. .not. archive%failure%failed()) then
            if (all(coupled >= 1 .and. coupled <= grid%n_elements)) then
               call analyse(self, grid, coupled, fixed, is_shared)
            else
               call archive%refuse('the factorised matrix does not fit the grid')
            end if
         end if
         do k = 1, merge(0, size(self%factors), archive%failure%failed())
            associate (factor => self%factors(k))
               if (factor%unknowns%n == 0) cycle
               call archive%archive_reals('values_'//to_text(k), size(factor%matrix%value), factor%matrix%value)
               if (archive%is_read .and. .not. archive%failure%failed()) call factorise_numbers(factor, archive%failure)
            end associate
         end do
         is_factorised = .not. archive%failure%failed()
      end if
      self%analyses = analyses
      self%factorisations = factorisations
   end subroutine serialise

   !> Whether the factorised matrix has the unknowns of a matrix, so that it may precondition it.
   pure logical function fits(self, mass)
      class(mass_factorisation_t), intent(in) :: self
      type(mass_matrix_t), intent(in) :: mass
      fits = same_pattern(self, coupled_cells(mass))
   end function fits

   !> Whether the factorised matrix is positive definite.
   pure logical function is_definite(self)
      class(mass_factorisation_t), intent(in) :: self
      integer :: k
      is_definite = all([(self%factors(k)%factorised%is_definite .or. self%factors(k)%unknowns%n == 0, k=1, size(self%factors))])
   end function is_definite

   !> Whether the coupled cells are the same as in the last analysis.
   pure logical function same_pattern(self, coupled)
      type(mass_factorisation_t), intent(in) :: self
      integer, intent(in) :: coupled(:)
      same_pattern = .false.
      if (.not. allocated(self%coupled)) return
      if (size(self%coupled) /= size(coupled)) return
      same_pattern = all(self%coupled == coupled)
   end function same_pattern

   !> Number the unknowns and find the pattern of their matrices.
   subroutine analyse(self, grid, coupled, fixed, may_share)
      class(mass_factorisation_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coupled(:)
      logical, intent(in) :: fixed(:, :)         !! (ndim, n_nodes)
      logical, intent(in) :: may_share           !! whether directions may share a factor: definite for different fixed nodes
      integer, allocatable :: nodes(:)
      logical, allocatable :: in_all(:, :)       ! the nodes that are fixed in all directions of a factor, (1, n_nodes)
      integer :: of_direction(ndim), d, k        ! which factor belongs to a direction
      logical :: together(ndim)
      call self%release()
      self%coupled = coupled
      call nodes_of_elements(grid, coupled, nodes)
      of_direction = 0
      do d = 1, ndim
         of_direction(d) = maxval(of_direction) + 1
         do k = merge(1, of_direction(d), may_share), of_direction(d) - 1
            together = of_direction == k
            together(d) = .true.
            if (fit_together(fixed, together)) exit
         end do
         of_direction(d) = k
      end do
      allocate (self%factors(maxval(of_direction)))
      allocate (in_all(1, size(fixed, 2)))
      do k = 1, size(self%factors)
         associate (factor => self%factors(k))
            factor%directions = pack([(d, d=1, ndim)], of_direction == k)
            in_all(1, :) = all(fixed(factor%directions, :), dim=1)
            call number_unknowns(nodes, in_all, factor%unknowns)
            if (factor%unknowns%n == 0) cycle
            factor%factorised%solves_often = .true.
            call pattern_of_elements(grid, coupled, factor%unknowns, factor%matrix, nodes_of_jumps(self%ghosts))
            associate (fixed_there => fixed(factor%directions, factor%unknowns%node))
               factor%last = any(fixed_there, dim=1)
               factor%without = any(fixed_there, dim=2)
            end associate
            associate (n => factor%unknowns%n*size(factor%directions))
               allocate (factor%b(n), factor%x(n))
            end associate
         end associate
      end do
      self%analyses = self%analyses + 1
   end subroutine analyse

   !> Whether directions may share a factor: each fixes only nodes that are fixed in all, or all that are fixed in any of them.
   pure logical function fit_together(fixed, these) result(fit)
      logical, intent(in) :: fixed(:, :)         !! which degrees of freedom are fixed, (ndim, n_nodes)
      logical, intent(in) :: these(ndim)         !! directions
      logical :: in_all(size(fixed, 2)), in_any(size(fixed, 2))
      integer :: d
      in_all = all(fixed .or. .not. spread(these, 2, size(fixed, 2)), dim=1)
      in_any = any(fixed .and. spread(these, 2, size(fixed, 2)), dim=1)
      fit = all([(.not. these(d) .or. all(fixed(d, :) .eqv. in_all) .or. all(fixed(d, :) .eqv. in_any), d=1, ndim)])
   end function fit_together

   !> Fill the matrix from its cells; the masses of other cells at its nodes are on the diagonal.
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
         associate (cell => mass%cell_of(coupled(k)))
            call matrix_by_masters(grid, coupled(k), 1, mass%cell(:, :, cell), n, masters, by_master)
         end associate
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
      integer :: k
      do k = 1, size(self%factors)
         associate (factor => self%factors(k), n => self%factors(k)%unknowns%n, width => size(self%factors(k)%directions))
            if (n == 0) cycle
            call gather(width, factor%directions, n, factor%unknowns%node, b, factor%b)
            call factor%factorised%solve(factor%b, factor%x, factor%without)
            call scatter(width, factor%directions, n, factor%unknowns%node, factor%x, x)
         end associate
      end do
   end subroutine solve

   !> Take some directions of a field at the unknowns.
   pure subroutine gather(width, directions, n, node, field, x)
      integer, intent(in) :: width, directions(width), n, node(n)
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp), intent(out) :: x(width, n)
      integer :: i, j
      do i = 1, n
         do j = 1, width
            x(j, i) = field(directions(j), node(i))
         end do
      end do
   end subroutine gather

   !> Set some directions of a field at the unknowns.
   pure subroutine scatter(width, directions, n, node, x, field)
      integer, intent(in) :: width, directions(width), n, node(n)
      real(dp), intent(in) :: x(width, n)
      real(dp), intent(inout) :: field(:, :)     !! (ndim, n_points)
      integer :: i, j
      do i = 1, n
         do j = 1, width
            field(directions(j), node(i)) = x(j, i)
         end do
      end do
   end subroutine scatter

   !> Release the memory.
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
