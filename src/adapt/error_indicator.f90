!> The error estimate of Zienkiewicz & Zhu (1987): the energy norm of the difference between the stress recovered at the nodes and
!> the stress of the particles. Stress is recovered in each material by itself: across an interface it may jump. In quadratic cells
!> the recovery is by quadratic functions.
module hampm_error_indicator
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions, inside_cell
   use hampm_cell_values, only: sum_over_particles
   use hampm_gradient_indicator, only: rounding_of
   use hampm_indicator, only: refinement_t, may_refine, is_in_box
   use hampm_law, only: value_of
   use hampm_material, only: material_t, are_of_one
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_particles, only: particles_t
   use hampm_recovery, only: recover, recover_quadratic, terms_at, n_terms
   implicit none
   private
   public :: mark_by_error, estimate_errors, errors_at_particles, energy_of_stress, stress_components

   real(dp), parameter :: marked_part = 0.5_dp   !! of the squared error, in the cells that are refined at once (Doerfler 1996)
   real(dp), parameter :: most_static = 0.8_dp   !! the same where each mesh takes a solution: few of them cost less than few cells

   integer, parameter :: n_stress = ndim*ndim

contains

   !> As long as the estimated relative error is above `tolerance`, refine the leaves with the largest errors, as few as hold a part
   !> `marked_part` of its square, and those with errors equal to the least of them up to rounding: of two leaves that mirror each
   !> other rounding would choose one.
   subroutine mark_by_error(r, m, tips, change)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: tips(:, :)
      integer, intent(inout) :: change(:)
      real(dp), allocatable :: squared(:)
      logical, allocatable :: open(:)
      real(dp), parameter :: alike = sqrt(epsilon(1.0_dp))  ! squares that differ by less, as a part of them, are the same
      real(dp) :: norm, total, part, low, high, middle, tolerance
      integer :: leaf, k
      tolerance = value_of(r%constants, 'tolerance', 0.0_dp)
      call estimate_errors(m, squared, norm)
      total = sum(squared)
      r%value = 0
      if (norm + total > sum(m%particles%volume(:m%particles%n))*rounding_of(m, 'energy_density')) &
         r%value = sqrt(total/(norm + total))
      if (r%value <= tolerance) return
      allocate (open(size(squared)))
      do leaf = 1, size(squared)
         open(leaf) = squared(leaf) > 0 .and. is_in_box(r, m, leaf)
      end do
      if (.not. any(open)) return                ! no material in the box, or none strained there
      total = sum(squared, mask=open)
      part = marked_part
      ! In equilibrium no more than needed: halved cells leave a quarter of the error where the solution is smooth
      if (r%is_static) part = min(most_static, max(0.3_dp, (1 - (tolerance/r%value)**2)*4/3))
      low = 0
      high = maxval(squared, mask=open)
      do k = 1, digits(high)                     ! the leaves above `low` hold the part, those above `high` do not
         middle = (low + high)/2
         if (sum(squared, mask=open .and. squared >= middle) >= part*total) then
            low = middle
         else
            high = middle
         end if
      end do
      do leaf = 1, size(squared)
         if (open(leaf) .and. squared(leaf) >= (1 - alike)*low) then
            if (may_refine(r, m, leaf)) change(leaf) = 1
         end if
      end do
   end subroutine mark_by_error

   !> Estimated squared error of each leaf in the energy norm [J], and the squared energy norm of the solution, which is twice
   !> the strain energy [J].
   subroutine estimate_errors(m, squared, norm)
      type(problem_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: squared(:)   !! (leaves)
      real(dp), intent(out) :: norm
      real(dp), allocatable :: stress(:, :), error(:, :)
      integer :: i, leaf
      associate (p => m%particles, grid => m%grid)
         allocate (stress(stress_components(p), p%n), squared(grid%forest%leaf_count()))
         norm = 0
         do i = 1, p%n
            associate (material => m%materials(p%material(i)))
               stress(:n_stress, i) = reshape(material%kirchhoff_stress(p%gradient_of(i), p%history_of(i), p%hoop_of(i)), &
                                              [n_stress])
               if (material%is_ring) stress(n_stress + 1, i) = material%hoop_stress(p%gradient_of(i), p%history_of(i), p%hoop_of(i))
               norm = norm + p%volume(i)*2*energy_of_stress(material, stress(:, i))
            end associate
         end do
         call refresh_grid(m)
         call errors_at_particles(m, stress, error)
         do leaf = 1, size(squared)
            squared(leaf) = sum_over_particles(grid, m%blocks, leaf, error(:, 1))
         end do
      end associate
   end subroutine estimate_errors

   !> Components of stress that are kept: in the plane, and stress_33 of axisymmetric material.
   pure integer function stress_components(p)
      type(particles_t), intent(in) :: p
      stress_components = merge(n_stress + 1, n_stress, p%thickness%is_ring)
   end function stress_components

   !> Elastic energy per volume of a small stress of so many components; or its product with another stress in that energy [J/m3].
   pure real(dp) function energy_of_stress(material, stress, other) result(energy)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: stress(:)          !! [Pa]
      real(dp), intent(in), optional :: other(:) !! [Pa]
      if (present(other)) then
         energy = material%stress_energy_density(in_plane_of(stress), stress(size(stress)), in_plane_of(other), other(size(other)))
      else
         energy = material%stress_energy_density(in_plane_of(stress), stress(size(stress)))
      end if
   end function energy_of_stress

   !> The components in the plane.
   pure function in_plane_of(stress) result(in_plane)
      real(dp), intent(in) :: stress(:)          !! [Pa]
      real(dp) :: in_plane(ndim, ndim)
      integer :: j
      do j = 1, ndim                             ! reshape would be a call of the library
         in_plane(:, j) = stress((j - 1)*ndim + 1:j*ndim)
      end do
   end function in_plane_of

   !> The squared error of stress at each particle in the energy norm, with its volume [J], for each of some fields of stress, or
   !> its product with that of another field.
   subroutine errors_at_particles(m, stress, error, with)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: stress(:, :)               !! of the particles, a field after the other [Pa], (components, particles)
      real(dp), allocatable, intent(out) :: error(:, :)  !! (particles, fields)
      integer, intent(in), optional :: with(:)           !! which other field, (fields)
      real(dp), allocatable :: nodal(:, :), coefficient(:, :, :), edge(:)
      integer, allocatable :: sides(:)
      real(dp) :: off(size(stress, 1))
      integer :: i, k, field, other
      associate (p => m%particles, grid => m%grid, n => stress_components(m%particles))
         allocate (nodal(size(stress, 1), grid%n_points), error(p%n, size(stress, 1)/n))
         if (grid%is_quadratic()) &
            allocate (coefficient(n_terms, size(stress, 1), grid%n_nodes), edge(grid%n_nodes), sides(grid%n_nodes))
         do k = 1, size(m%materials)
            if (m%materials(k)%slice%number > 1) cycle
            if (grid%is_quadratic()) then
               call recover_quadratic(m%matter_t, size(stress, 1), stress, coefficient, edge, k, sides)
            else
               call recover(m%matter_t, m%fields%mass_matrix, size(stress, 1), stress, nodal, material=k)
            end if
            do i = 1, p%n
               if (.not. are_of_one(m%materials, k, p%material(i))) cycle
               if (grid%is_quadratic()) then
                  off = blended(m, i, coefficient, edge, sides) - stress(:, i)
               else
                  associate (e => p%cell(i))
                     off = matmul(nodal(:, grid%element_nodes(:, e)), &
                                  shape_functions(inside_cell(grid%local_coordinate(e, p%place_in_grid(i))))) - stress(:, i)
                  end associate
               end if
               do field = 1, size(error, 2)
                  other = field
                  if (present(with)) other = with(field)
                  error(i, field) = p%volume(i)*2*energy_of_stress(m%materials(p%material(i)), off(n*(field - 1) + 1:n*field), &
                                                                   off(n*(other - 1) + 1:n*other))
               end do
            end do
         end do
      end associate
   end subroutine errors_at_particles

   !> Value at a particle of a quadratic cell: the quadratic functions recovered at the four corners, weighted by the bilinear
   !> functions of these; the field is continuous (Zienkiewicz & Zhu 1992 take their means at the nodes). A cell at the corner of a
   !> body has those of nodes inside alone, as there: one that fits its own stress does not see how far that is off.
   pure function blended(m, i, coefficient, edge, sides) result(value)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp), intent(in) :: coefficient(:, :, :), edge(:)
      integer, intent(in) :: sides(:)
      real(dp) :: value(size(coefficient, 2))
      real(dp) :: shape(corners), x(ndim), term(n_terms)
      integer :: first, q, k, around(corners)
      x = m%particles%place_in_grid(i)
      associate (grid => m%grid, e => m%particles%cell(i))
         first = grid%first_of_piece(e)
         shape = shape_functions(grid%in_leaf(e, grid%local_coordinate(e, x)))
         around = sides([(grid%element_nodes(q, first + q - 1), q=1, corners)])
         if (maxval(around) == ndim .and. minval(around) == 0) then
            where (around > 0) shape = 0
            shape = shape/sum(shape)
         end if
         value = 0
         do q = 1, corners
            associate (node => grid%element_nodes(q, first + q - 1))
               term = terms_at((x - grid%node_position(:, node))/edge(node))
               do k = 1, size(value)
                  value(k) = value(k) + shape(q)*dot_product(term, coefficient(:, k, node))
               end do
            end associate
         end do
      end associate
   end function blended
end module hampm_error_indicator
