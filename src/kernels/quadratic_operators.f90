!> Element operators (`hampm_element_operators`) of quadratic cells: how the contributions of a cell to momentum and internal force change
!> with the motion of its nine points.
!>
!> In two dimensions the stiffness of a square does not depend on its size, and its mass matrix over its mass does not either. So all
!> cells of one material with as many particles share them, as the particles stand at the same places in each.
!> Of cells that are cut each has its own.
module hampm_quadratic_operators
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: points_of_quadratic, quarter_of_point, corner_of_point, quadratic_functions, quadratic_gradients
   use hampm_cell_blocks, only: cell_blocks_t, quadratic_cell_t, of_momentum, of_force
   use hampm_material, only: material_t
   use hampm_nodal_fields, only: nodal_fields_t
   use hampm_orthotropic, only: n_voigt
   use hampm_particles, only: particles_t
   use hampm_pass, only: pass_t
   implicit none
   private
   public :: quadratic_operators_t, find_quadratic_operators, apply_quadratic_operators

   integer, parameter :: n_points = points_of_quadratic, n_dofs = ndim*n_points
   real(dp), parameter :: alike = 1e-9_dp        !! relative difference of volumes that is rounding

   !> What cells of a kind have in common.
   type :: kind_t
      logical :: is_own = .false.                !! of one cell only, which is cut
      integer :: material = 0, particles = 0
      real(dp) :: volume = 0                     !! of their particles over the square of their size: the thickness [m]
      real(dp) :: mass(n_points, n_points) = 0   !! over the mass of a cell [-]
      real(dp) :: stiffness(n_dofs, n_dofs) = 0  !! of (x, y) of each point, one after the other [N/m]
   end type kind_t

   !> The kinds, and the kind of each quadratic cell, 0 where it is passed particle by particle.
   type :: quadratic_operators_t
      type(kind_t), allocatable :: kinds(:)
      integer, allocatable :: kind_of(:)         !! (cells)
      real(dp), allocatable :: cell_mass(:)      !! [kg], (cells)
      integer, allocatable :: with(:), without(:) !! the cells that have operators, and the others
   end type quadratic_operators_t

contains

   !> Find the operators of cells with a linear law, one material, and no particle that carries a load.
   pure subroutine find_quadratic_operators(materials, is_loaded, p, blocks, operators)
      type(material_t), intent(in) :: materials(:)
      logical, intent(in) :: is_loaded(:)        !! whether a particle of the element carries a load
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(quadratic_operators_t), intent(out) :: operators
      type(kind_t) :: kind
      integer :: k, j, n
      allocate (operators%kinds(8), operators%kind_of(size(blocks%quadratic)), operators%cell_mass(size(blocks%quadratic)))
      n = 0
      operators%kind_of = 0
      do k = 1, size(blocks%quadratic)
         associate (cell => blocks%quadratic(k))
            if (any(is_loaded(cell%first:cell%first + corners - 1))) cycle
            call look_at_cell(p, blocks, cell, kind, operators%cell_mass(k))
            if (kind%material == 0) cycle
            if (.not. materials(kind%material)%linear) cycle
            do j = 1, n
               if (is_alike(kind, operators%kinds(j))) exit
            end do
            if (j > n) then
               call sum_matrices(materials(kind%material), p, blocks, cell, operators%cell_mass(k), kind)
               if (n == size(operators%kinds)) operators%kinds = [operators%kinds, operators%kinds]
               n = n + 1
               operators%kinds(n) = kind
            end if
            operators%kind_of(k) = j
         end associate
      end do
      operators%with = pack([(k, k=1, size(operators%kind_of))], operators%kind_of > 0)
      operators%without = pack([(k, k=1, size(operators%kind_of))], operators%kind_of == 0)
   end subroutine find_quadratic_operators

   !> The material, 0 where there are several, the number of particles and the volume that make the kind of a cell, and its mass [kg].
   pure subroutine look_at_cell(p, blocks, cell, kind, mass)
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(quadratic_cell_t), intent(in) :: cell
      type(kind_t), intent(out) :: kind
      real(dp), intent(out) :: mass
      integer :: e, i, root
      mass = 0
      do e = cell%first, cell%first + corners - 1
         do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
            if (kind%particles == 0) kind%material = p%material(i)
            if (kind%material /= p%material(i)) kind%material = 0
            kind%particles = kind%particles + 1
            kind%volume = kind%volume + p%volume(i)*cell%inverse_size**ndim
            mass = mass + p%mass(i)
         end do
      end do
      kind%is_own = cell%is_cut
      root = nint(sqrt(real(kind%particles, dp)))
      if (root**2 /= kind%particles .and. .not. kind%is_own) kind%material = 0
   end subroutine look_at_cell

   !> Whether two kinds are the same.
   pure logical function is_alike(a, b)
      type(kind_t), intent(in) :: a, b
      is_alike = .not. (a%is_own .or. b%is_own) .and. a%material == b%material .and. a%particles == b%particles &
                 .and. abs(a%volume - b%volume) <= alike*b%volume
   end function is_alike

   !> Sum the matrices of a kind over the particles of a cell of it.
   pure subroutine sum_matrices(material, p, blocks, cell, mass, kind)
      type(material_t), intent(in) :: material
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(quadratic_cell_t), intent(in) :: cell
      real(dp), intent(in) :: mass               !! [kg]
      type(kind_t), intent(inout) :: kind
      real(dp) :: n(n_points), gradient(n_points, ndim), strain(n_voigt, n_dofs), xi(ndim)
      integer :: e, i, c
      strain = 0
      do e = cell%first, cell%first + corners - 1
         do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
            xi = (p%reference(i, :) - cell%lower)*cell%inverse_size
            n = quadratic_functions(xi)
            gradient = quadratic_gradients(xi, cell%inverse_size) + cell%correction
            do c = 1, n_points
               kind%mass(:, c) = kind%mass(:, c) + p%mass(i)/mass*n(c)*n
            end do
            strain(1, 1::ndim) = gradient(:, 1)
            strain(2, 2::ndim) = gradient(:, 2)
            strain(3, 1::ndim) = gradient(:, 2)
            strain(3, 2::ndim) = gradient(:, 1)
            kind%stiffness = kind%stiffness + p%volume(i)*matmul(transpose(strain), matmul(material%small_strain_moduli(), strain))
         end do
      end do
   end subroutine sum_matrices

   !> Add to the contributions of the cells that have operators what a pass does.
   subroutine apply_quadratic_operators(operators, pass, dt, blocks, f)
      type(quadratic_operators_t), intent(in) :: operators
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      integer :: k
      !$omp parallel do schedule(static)
      do k = 1, size(operators%with)
         call apply_to_cell(operators, operators%with(k), pass, dt, blocks%quadratic(operators%with(k)), f)
      end do
   end subroutine apply_quadratic_operators

   !> The same of one cell.
   pure subroutine apply_to_cell(operators, k, pass, dt, cell, f)
      type(quadratic_operators_t), intent(in) :: operators
      integer, intent(in) :: k
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      type(quadratic_cell_t), intent(in) :: cell
      type(nodal_fields_t), intent(inout) :: f
      real(dp) :: change(n_dofs), by_point(ndim, n_points), factor
      integer :: c
      associate (kind => operators%kinds(operators%kind_of(k)))
         if (pass%kick) then
            factor = dt*operators%cell_mass(k)
            by_point = 0
            do c = 1, n_points
               associate (a => factor*f%acceleration(:, cell%points(c)))
                  by_point(1, :) = by_point(1, :) + kind%mass(:, c)*a(1)
                  by_point(2, :) = by_point(2, :) + kind%mass(:, c)*a(2)
               end associate
            end do
            call add_to(cell, of_momentum, by_point, f)
         end if
         if (pass%strain_fraction > 0) then
            factor = -pass%strain_fraction*dt
            change = 0
            do c = 1, n_points
               associate (v => factor*f%velocity(:, cell%points(c), pass%strain_by))
                  change = change + (kind%stiffness(:, ndim*c - 1)*v(1) + kind%stiffness(:, ndim*c)*v(2))
               end associate
            end do
            call add_to(cell, of_force, reshape(change, [ndim, n_points]), f)
         end if
      end associate
   end subroutine apply_to_cell

   !> Add to what a cell gives to its points, which is kept as contributions of its quarters.
   pure subroutine add_to(cell, first, by_point, f)
      type(quadratic_cell_t), intent(in) :: cell
      integer, intent(in) :: first               !! of_momentum or of_force
      real(dp), intent(in) :: by_point(ndim, n_points)
      type(nodal_fields_t), intent(inout) :: f
      integer :: c, d
      do c = 1, n_points
         associate (q => quarter_of_point(c))
            do d = 1, ndim
               associate (sum => f%contribution(cell%lane(q), corner_of_point(c), first + d - 1, cell%block(q)))
                  sum = sum + by_point(d, c)
               end associate
            end do
         end associate
      end do
   end subroutine add_to
end module hampm_quadratic_operators
