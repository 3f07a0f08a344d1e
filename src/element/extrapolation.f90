!> Nodal values of fields that the particles carry, by a mass matrix, as velocities are in (8) and (10).
module hampm_extrapolation
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: inside_cell, points_of_quadratic
   use hampm_domain_pass, only: find_corners
   use hampm_failure, only: failure_t
   use hampm_forest, only: outside
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: mass_matrix_t
   use hampm_mass_solver, only: mass_solver_t, solve_mass
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: extrapolate, extrapolate_lumped

contains

   !> Nodal values of a vector field by the mass matrix of a run. Fails where the equations cannot be solved.
   subroutine extrapolate(grid, p, matrix, solver, field, nodal, failure, counts)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(mass_matrix_t), intent(in) :: matrix
      type(mass_solver_t), intent(inout) :: solver
      real(dp), intent(in), contiguous :: field(:, :)   !! values of the particles, (ndim, n)
      real(dp), intent(out), contiguous :: nodal(:, :)  !! values of the points, 0 where there are no particles, (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: counts(:)        !! whether the particles of an element count; default: all
      real(dp), allocatable :: rhs(:, :)
      allocate (rhs(ndim, grid%n_points))
      call map_field(grid, p, matrix, ndim, field, rhs, counts)
      nodal = 0
      call solve_mass(solver, grid, matrix, rhs, nodal, failure)
      call grid%dofs%distribute(matrix%all, ndim, nodal)
   end subroutine extrapolate

   !> Nodal values of a field of `width` components by the lumped mass matrix.
   subroutine extrapolate_lumped(grid, p, matrix, width, field, nodal)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(mass_matrix_t), intent(in) :: matrix
      integer, intent(in) :: width
      real(dp), intent(in) :: field(width, *)           !! values of the particles, (width, n)
      real(dp), intent(out) :: nodal(width, *)          !! values of the points, 0 where there are no particles, (width, n_points)
      integer :: a
      call map_field(grid, p, matrix, width, field, nodal)
      associate (all => matrix%all)
         do a = 1, all%n_nodes
            associate (i => all%nodes(a))
               if (matrix%lumped(i) > 0) nodal(:, i) = nodal(:, i)/matrix%lumped(i)
            end associate
         end do
         call grid%dofs%distribute(all, width, nodal)
      end associate
   end subroutine extrapolate_lumped

   !> The sums over the particles of mass times shape function times value, at the nodes.
   subroutine map_field(grid, p, matrix, width, field, sums, counts)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(mass_matrix_t), intent(in) :: matrix
      integer, intent(in) :: width
      real(dp), intent(in) :: field(width, *)
      real(dp), intent(out) :: sums(width, *)
      logical, intent(in), optional :: counts(:)        !! whether the particles of an element count
      real(dp) :: local(ndim), at(ndim, corners)
      integer :: i, c, element(corners)
      sums(:, :grid%n_points) = 0
      do i = 1, p%n
         if (present(counts)) then
            if (.not. counts(p%cell(i))) cycle
         end if
         if (.not. allocated(p%corner_velocity)) then
            local = inside_cell(grid%local_coordinate(p%cell(i), p%place_in_grid(i)))
            call add_value(p%cell(i), local, p%mass(i), field(:, i))
            cycle
         end if
         element = outside
         call find_corners(p, grid, i, element, at)
         do c = 1, corners                       ! as those that the masses of the nodes are of
            if (element(c) /= outside) call add_value(element(c), at(:, c), p%mass(i)/corners, field(:, i))
         end do
      end do
      call grid%dofs%condense(matrix%all, width, sums)
   contains
      !> Add a value times a mass and the functions of an element, at a place in it, to the points of these.
      subroutine add_value(element, local, mass, value)
         integer, intent(in) :: element
         real(dp), intent(in) :: local(ndim), mass   ! local coordinate [-]; [kg]
         real(dp), intent(in) :: value(width)
         real(dp) :: n(points_of_quadratic)
         integer :: points(points_of_quadratic), k
         call grid%shape_functions_in(element, local, points, n)
         do k = 1, grid%n_functions
            sums(:, points(k)) = sums(:, points(k)) + mass*n(k)*value
         end do
      end subroutine add_value
   end subroutine map_field
end module hampm_extrapolation
