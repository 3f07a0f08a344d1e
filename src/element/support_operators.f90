!> Element operators (`hampm_element_operators`) of cells that are passed by supports: change of the contributions of a cell to
!> momentum and internal force with the motion of its points.
!>
!> In two dimensions the stiffness of a square does not depend on its size, in three it is proportional to the size of a cube; the
!> mass matrix over the mass depends on neither. All cells of one material (in space of one size) with as many particles share them
!> if the particles stand at the same places: in quadratic cells they do, in bilinear ones the mass matrix tells. Each cut cell has
!> its own; in solids none.
module hampm_support_operators
   use hampm_kinds, only: dp, ndim, plane, corners
   use hampm_basis, only: points_of_quadratic
   use hampm_cell_blocks, only: cell_blocks_t, support_t, lanes, of_momentum, of_force
   use hampm_element_stiffness, only: element_stiffness
   use hampm_matter, only: matter_t
   use hampm_nodal_fields, only: nodal_fields_t
   use hampm_pass, only: pass_t
   use hampm_support_pass, only: mass_of_cell
   implicit none
   private
   public :: support_operators_t, find_support_operators, apply_support_operators, least_part

   integer, parameter :: most_dofs = ndim*points_of_quadratic
   integer, parameter :: rows = most_dofs + modulo(-most_dofs, lanes) !! of matrices: full vectors
   !> Least mass of each corner of a bilinear cell, over the mass of the cell: a particle is then at least about this part of the
   !> nodal sums that give it, and keeps ten of their sixteen digits.
   real(dp), parameter :: least_part = 1.0e-6_dp
   real(dp), parameter :: alike = 1e-9_dp        !! relative difference of volumes, and of masses, that is rounding

   !> Common data of the cells of a kind.
   type :: kind_t
      logical :: is_own = .false.                !! of one cell only, which is cut
      integer :: material = 0, particles = 0
      real(dp) :: volume = 0                     !! of their particles over the square of the size: thickness, of a solid size [m]
      ! Of (x, y) of each point, one after the other
      real(dp) :: mass(rows, most_dofs) = 0      !! over the mass of a cell [-]
      real(dp) :: stiffness(rows, most_dofs) = 0 !! [N/m]
   end type kind_t

   !> The kinds, and the kind of each cell, 0 where it is passed particle by particle.
   type :: support_operators_t
      type(kind_t), allocatable :: kinds(:)
      integer, allocatable :: kind_of(:)         !! (cells)
      real(dp), allocatable :: cell_mass(:)      !! [kg], (cells)
      integer, allocatable :: with(:), without(:) !! the cells that have operators, and the others
   end type support_operators_t

contains

   !> Find the operators of cells with a linear law, one material, and no particle that carries a load.
   pure subroutine find_support_operators(m, is_loaded, operators)
      type(matter_t), intent(in) :: m
      logical, intent(in) :: is_loaded(:)        !! whether a particle of the element carries a load
      type(support_operators_t), intent(out) :: operators
      type(kind_t) :: kind
      real(dp) :: stiffness(ndim*m%grid%n_functions, ndim*m%grid%n_functions) ! of an element [N/m]
      integer :: k, j, n, e
      allocate (operators%kinds(8), operators%kind_of(size(m%blocks%supports)), operators%cell_mass(size(m%blocks%supports)))
      n = 0
      operators%kind_of = 0
      do k = 1, size(m%blocks%supports)
         associate (cell => m%blocks%supports(k))
            if (any(is_loaded(cell%first:cell%last))) cycle
            call find_cell_kind(m, cell, kind, operators%cell_mass(k))
            if (kind%material == 0) cycle
            if (.not. m%materials(kind%material)%linear) cycle
            if (cell%n == corners) then
               call find_mass(m, cell, operators%cell_mass(k), kind)
               if (minval(sum(kind%mass(:ndim*cell%n, :ndim*cell%n), dim=2)) < least_part) cycle
            end if
            do j = merge(n + 1, 1, kind%is_own), n
               if (is_alike(kind, operators%kinds(j))) exit
            end do
            if (j > n) then
               if (cell%n > corners) call find_mass(m, cell, operators%cell_mass(k), kind)
               do e = cell%first, cell%last
                  call element_stiffness(m, [e], .true., 0.0_dp, stiffness)
                  kind%stiffness(:ndim*cell%n, :ndim*cell%n) = kind%stiffness(:ndim*cell%n, :ndim*cell%n) + stiffness
               end do
               if (n == size(operators%kinds)) operators%kinds = [operators%kinds, operators%kinds]
               n = n + 1
               operators%kinds(n) = kind
            end if
            operators%kind_of(k) = j
         end associate
      end do
      operators%with = pack([(k, k=1, size(operators%kind_of))], operators%kind_of > 0)
      operators%without = pack([(k, k=1, size(operators%kind_of))], operators%kind_of == 0)
   end subroutine find_support_operators

   !> Find the mass matrix of cells of a kind, from one of them.
   pure subroutine find_mass(m, cell, cell_mass, kind)
      type(matter_t), intent(in) :: m
      type(support_t), intent(in) :: cell
      real(dp), intent(in) :: cell_mass          !! [kg]
      type(kind_t), intent(inout) :: kind
      real(dp) :: own(cell%n, cell%n)
      integer :: d
      own = mass_of_cell(m, cell)/cell_mass
      do d = 1, ndim
         kind%mass(d:ndim*cell%n:ndim, d:ndim*cell%n:ndim) = own
      end do
   end subroutine find_mass

   !> Material (0 if several), number of particles and volume, the kind of a cell, and its mass [kg].
   pure subroutine find_cell_kind(m, cell, kind, mass)
      type(matter_t), intent(in) :: m
      type(support_t), intent(in) :: cell
      type(kind_t), intent(out) :: kind
      real(dp), intent(out) :: mass
      integer :: e, i, root
      mass = 0
      do e = cell%first, cell%last
         do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
            if (kind%particles == 0) kind%material = m%particles%material(i)
            if (kind%material /= m%particles%material(i)) kind%material = 0
            kind%particles = kind%particles + 1
            kind%volume = kind%volume + m%particles%volume(i)*cell%inverse_size**plane
            mass = mass + m%particles%mass(i)
         end do
      end do
      kind%is_own = cell%is_cut
      if (kind%is_own .and. ndim > 2) kind%material = 0 ! a matrix for each would be large
      root = nint(sqrt(real(kind%particles, dp)))
      if (root**2 /= kind%particles .and. .not. kind%is_own .and. cell%n > corners) kind%material = 0
   end subroutine find_cell_kind

   !> Whether two kinds are the same.
   pure logical function is_alike(a, b)
      type(kind_t), intent(in) :: a, b
      is_alike = .not. b%is_own .and. a%material == b%material .and. a%particles == b%particles &
                 .and. abs(a%volume - b%volume) <= alike*b%volume
      if (any(abs(a%mass) > 0)) is_alike = is_alike .and. all(abs(a%mass - b%mass) <= alike)
   end function is_alike

   !> Add the effect of a pass to the contributions of the cells with operators.
   subroutine apply_support_operators(operators, pass, dt, blocks, f)
      type(support_operators_t), intent(in) :: operators
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      integer :: k
      !$omp parallel do schedule(static)
      do k = 1, size(operators%with)
         call apply_to_cell(operators, operators%with(k), pass, dt, blocks%supports(operators%with(k)), f)
      end do
   end subroutine apply_support_operators

   !> The same of one cell.
   pure subroutine apply_to_cell(operators, k, pass, dt, cell, f)
      type(support_operators_t), intent(in) :: operators
      integer, intent(in) :: k
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      type(support_t), intent(in) :: cell
      type(nodal_fields_t), intent(inout) :: f
      associate (kind => operators%kinds(operators%kind_of(k)))
         if (pass%kick) call add_product(cell, dt*operators%cell_mass(k), kind%mass, f%acceleration, of_momentum, f%contribution)
         if (pass%strain_fraction > 0) call add_product(cell, -pass%strain_fraction*dt, kind%stiffness, &
                                                        f%velocity(:, :, pass%strain_by), of_force, f%contribution)
      end associate
   end subroutine apply_to_cell

   !> Add a factor times the product of a matrix with a field of the points to the contributions of a cell, which are stored by its
   !> elements.
   pure subroutine add_product(cell, factor, matrix, field, first, contribution)
      type(support_t), intent(in) :: cell
      real(dp), intent(in) :: factor
      real(dp), intent(in) :: matrix(rows, most_dofs)
      real(dp), intent(in), contiguous :: field(:, :) !! (ndim, n_points)
      integer, intent(in) :: first               !! of_momentum or of_force
      real(dp), intent(inout), contiguous :: contribution(:, :, :, 0:) !! see `nodal_fields_t`
      real(dp) :: x, change(rows)
      integer :: c, d, i
      change = 0
      do c = 1, cell%n
         do d = 1, ndim
            x = factor*field(d, cell%points(c))
            !$omp simd
            do i = 1, rows
               change(i) = change(i) + matrix(i, ndim*(c - 1) + d)*x
            end do
         end do
      end do
      do c = 1, cell%n
         associate (q => cell%element_of(c))
            do d = 1, ndim
               associate (sum => contribution(cell%lane(q), cell%corner_of(c), first + d - 1, cell%block(q)))
                  sum = sum + change(ndim*(c - 1) + d)
               end associate
            end do
         end associate
      end do
   end subroutine add_product
end module hampm_support_operators
