!> The refinement parameter R of Tan & Nairn, (20)-(23): the difference of the mean of a field around a node from its value there.
!> Quadratic cells have it at their corners, over distances of whole cells, equal to bilinear cells of the same size.
module hampm_gradient_indicator
   use hampm_kinds, only: dp, ndim, corners
   use hampm_tensors, only: norm
   use hampm_basis, only: shape_functions, inside_cell, points_of_quadratic
   use hampm_cell_values, only: is_occupied, mean_of_nodes
   use hampm_extrapolation, only: extrapolate_lumped
   use hampm_forest, only: outside
   use hampm_grid, only: grid_t
   use hampm_indicator, only: refinement_t, may_refine, is_in_box
   use hampm_law, only: value_of
   use hampm_loads, only: largest_factors
   use hampm_problem, only: problem_t, refresh_grid
   use hampm_recovery, only: recover, recover_quadratic, terms_at, n_terms, are_corners, gather_at_corners, spread_from_corners, &
                             sides_of_cell, middle_of_cell
   implicit none
   private
   public :: nodal_field, refinement_parameter, mark_by_gradient, rounding_of

contains

   !> Refine the leaves with a mean R above `r_crit`, and recombine those with one below `r_coarsen`.
   subroutine mark_by_gradient(r, m, tips, change)
      type(refinement_t), intent(inout) :: r
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: tips(:, :)
      integer, intent(inout) :: change(:)
      real(dp), allocatable :: phi(:), parameter(:)
      real(dp) :: mean, least, r_crit, r_coarsen
      integer :: leaf
      r_crit = value_of(r%constants, 'r_crit', 0.0_dp)
      r_coarsen = value_of(r%constants, 'r_coarsen', 0.0_dp)
      call nodal_field(m, r%field, phi)
      call refinement_parameter(m, r%field, phi, parameter)
      least = max(value_of(r%constants, 'energy_floor', 0.0_dp)*maxval(phi), rounding_of(m, r%field))
      r%value = 0
      do leaf = 1, size(change)
         if (.not. is_occupied(m%grid, m%blocks, leaf)) then
            if (r_coarsen > 0) change(leaf) = -1
            cycle
         end if
         mean = mean_of_nodes(m%grid, leaf, parameter)
         if (mean_of_nodes(m%grid, leaf, phi) <= least) mean = 0
         if (is_in_box(r, m, leaf)) r%value = max(r%value, mean)
         if (mean > r_crit) then
            if (may_refine(r, m, leaf)) change(leaf) = 1
         else if (mean < r_coarsen) then
            change(leaf) = -1
         end if
      end do
   end subroutine mark_by_gradient

   !> Rounding of displacements, eigenstrains and loads in a field of the gradient indicator: it must not refine cells, as of a body
   !> that falls freely, or of one held where all of the load is.
   pure real(dp) function rounding_of(m, field) result(value)
      type(problem_t), intent(in) :: m
      character(*), intent(in) :: field
      real(dp), parameter :: rounding = 1e-12_dp ! over many steps
      real(dp) :: strain, speed, stiffness, loads
      integer :: k
      associate (p => m%particles)
         stiffness = minval([(m%materials(k)%plane_modulus(), k=1, size(m%materials))])*maxval(p%volume(:p%n))/m%grid%finest_cell
         loads = sum(abs(largest_factors(m%loads))*[(norm(m%loads(k)%force), k=1, size(m%loads))])
         strain = rounding*(maxval(abs(p%displacement(:p%n, :)))/m%grid%finest_cell + loads/stiffness &
                            + maxval([(maxval(abs(m%materials(k)%free)), k=1, size(m%materials))]))
         speed = maxval([(m%materials(k)%shear_wave_speed(), k=1, size(m%materials))])
         value = strain*speed
         if (field /= 'speed') value = strain*speed**2*maxval(p%mass(:p%n)/p%volume(:p%n))
         if (field == 'energy_density') value = strain*value
      end associate
   end function rounding_of

   !> A field at the points of the grid. 'energy_density' [J/m3] is the paper's and extrapolated as there, by the lumped mass
   !> matrix; 'stress_norm' [Pa] and 'speed' [m/s] are recovered by patches, which sees no kinks at edges of bodies and of cells.
   !> In quadratic cells the former has the lumped masses of bilinear cells of their size, the latter are recovered by quadratic
   !> functions.
   subroutine nodal_field(m, name, phi)
      type(problem_t), intent(inout) :: m
      character(*), intent(in) :: name
      real(dp), allocatable, intent(out) :: phi(:)  !! (n_points)
      real(dp), allocatable :: value(:)
      real(dp) :: h(ndim, ndim)
      logical :: is_energy, is_stress
      integer :: i
      is_energy = name == 'energy_density'
      is_stress = name == 'stress_norm'
      allocate (value(m%particles%n), phi(m%grid%n_points))
      do i = 1, m%particles%n
         h = m%particles%gradient_of(i)
         associate (material => m%materials(m%particles%material(i)))
            if (is_energy) then
               value(i) = material%energy_density(h, m%particles%history_of(i), m%particles%hoop_of(i))
            else if (is_stress) then
               value(i) = norm(material%kirchhoff_stress(h, m%particles%history_of(i), m%particles%hoop_of(i)))
            else
               value(i) = norm(m%particles%velocity(i, :))
            end if
         end associate
      end do
      call refresh_grid(m)
      if (m%grid%is_quadratic()) then
         if (is_energy) then
            call lumped_at_corners(m, value, phi)
         else
            call recovered_at_corners(m, value, phi)
         end if
      else if (is_energy) then
         call extrapolate_lumped(m%grid, m%particles, m%fields%mass_matrix, 1, value, phi)
      else
         call recover(m%matter_t, m%fields%mass_matrix, 1, value, phi)
      end if
   end subroutine nodal_field

   !> Means of a field, weighted by mass and the bilinear functions of quadratic cells, at the corners of these; bilinear between
   !> them.
   subroutine lumped_at_corners(m, value, phi)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: value(:)           !! at the particles
      real(dp), intent(out) :: phi(:)            !! (n_points)
      real(dp), allocatable :: mass(:)
      real(dp) :: n(corners)
      logical, allocatable :: is_corner(:)
      integer :: i
      allocate (is_corner(m%grid%n_points), mass(m%grid%n_points))
      phi = 0
      mass = 0
      associate (grid => m%grid, p => m%particles)
         do i = 1, p%n
            n = p%mass(i)*shape_functions(inside_cell(grid%local_coordinate(p%cell(i), p%place_in_grid(i))))
            associate (at => grid%element_nodes(:, p%cell(i)))
               phi(at) = phi(at) + n*value(i)
               mass(at) = mass(at) + n
            end associate
         end do
         is_corner = are_corners(m%matter_t)
         call gather_at_corners(grid, is_corner, phi)
         call gather_at_corners(grid, is_corner, mass)
         where (mass > 0) phi = phi/mass
         call spread_from_corners(grid, is_corner, phi)
      end associate
   end subroutine lumped_at_corners

   !> A field that is recovered at the corners of quadratic cells by quadratic functions, whose means are the values at the other
   !> nodes.
   subroutine recovered_at_corners(m, value, phi)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: value(:)           !! at the particles
      real(dp), intent(out) :: phi(:)            !! (n_points)
      real(dp), allocatable :: coefficient(:, :, :), edge(:)
      logical, allocatable :: is_corner(:)
      integer :: at(points_of_quadratic), e, k
      allocate (is_corner(m%grid%n_points), coefficient(n_terms, 1, m%grid%n_nodes), edge(m%grid%n_nodes))
      phi = 0
      associate (grid => m%grid)
         call recover_quadratic(m%matter_t, 1, value, coefficient, edge)
         is_corner = are_corners(m%matter_t)
         where (is_corner(:grid%n_nodes)) phi(:grid%n_nodes) = coefficient(1, 1, :)
         do e = 1, grid%n_elements, corners
            if (all(m%blocks%count_in(e:e + corners - 1) == 0)) cycle
            at = grid%support_of(e)
            do k = 1, size(sides_of_cell, 2)
               associate (middle => sides_of_cell(1, k))
                  if (.not. is_corner(at(middle))) phi(at(middle)) = mean_at(middle, sides_of_cell(2:, k))
               end associate
            end do
            phi(at(middle_of_cell)) = mean_at(middle_of_cell, [1, 3, 7, 9])
         end do
      end associate
   contains
      !> Mean at a point of the cell of the functions at some of its corners.
      real(dp) function mean_at(point, of) result(mean)
         integer, intent(in) :: point, of(:)
         real(dp) :: x(ndim)
         integer :: c
         mean = 0
         do c = 1, size(of)
            associate (corner => at(of(c)))
               x = (m%grid%node_position(:, at(point)) - m%grid%node_position(:, corner))/edge(corner)
               mean = mean + dot_product(terms_at(x), coefficient(:, 1, corner))/size(of)
            end associate
         end do
      end function mean_at
   end subroutine recovered_at_corners

   !> R of each active node (23), in quadratic cells of each corner and interpolated between these, 0 where the field is: the mean
   !> of phi at the distance of the smallest cell at the node to both sides in every direction, over phi at the node, less 1.
   !> Without a node there phi is interpolated. Beyond the edge of the body or a cut it is mirrored, which is exact on a symmetry
   !> plane. At other edges the energy density, which the lumped matrix has made flat there, is mirrored too; other fields are
   !> extrapolated linearly.
   subroutine refinement_parameter(m, name, phi, r)
      type(problem_t), intent(in) :: m
      character(*), intent(in) :: name           !! of the field
      real(dp), intent(in) :: phi(:)             !! nodal field, (n_points)
      real(dp), allocatable, intent(out) :: r(:) !! [-], (n_points)
      real(dp) :: mean
      logical, allocatable :: is_corner(:)
      logical :: is_energy
      integer :: a, d
      allocate (is_corner(m%grid%n_points))
      is_energy = name == 'energy_density'
      allocate (r(m%grid%n_points), source=0.0_dp)
      is_corner = are_corners(m%matter_t)
      associate (all => m%fields%mass_matrix%all)
         do a = 1, all%n_nodes
            associate (node => all%nodes(a))
               if (.not. (phi(node) > 0 .and. is_corner(node))) cycle
               mean = 0
               do d = 1, ndim
                  mean = mean + mean_beside(m, is_energy .or. m%constraints%fixed(d, node), phi, node, d)/ndim
               end do
               r(node) = abs(mean/phi(node) - 1)
            end associate
         end do
      end associate
      call spread_from_corners(m%grid, is_corner, r)
   end subroutine refinement_parameter

   !> Mean of phi on both sides of a node in direction `d`.
   real(dp) function mean_beside(m, mirrored, phi, node, d) result(mean)
      type(problem_t), intent(in) :: m
      logical, intent(in) :: mirrored            !! at an edge of the body; else linear
      real(dp), intent(in) :: phi(:)
      integer, intent(in) :: node, d
      real(dp) :: step(ndim), value(2), distance
      logical :: inside(2)
      integer :: side
      distance = reach_at(m%grid, node)
      value = 0
      do side = 1, 2
         step = 0
         step(d) = (2*side - 3)*distance
         inside(side) = m%grid%has_element_toward(node, step)
         if (inside(side)) call value_at(m, phi, node, m%grid%node_position(:, node) + step, value(side), inside(side))
      end do
      if (all(inside)) then
         mean = sum(value)/2
      else if (any(inside) .and. mirrored) then
         mean = merge(value(1), value(2), inside(1))
      else
         mean = phi(node)
      end if
   end function mean_beside

   !> Size of the smallest cell at a node or half of it, where the node is in the middle of its side: as the finer cells there,
   !> which may be on the other side of a crack [m].
   pure real(dp) function reach_at(grid, node) result(reach)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: node
      integer :: k
      reach = huge(reach)
      associate (elements => grid%dofs%elements_at(node))
         do k = 1, size(elements)
            associate (size_of_leaf => grid%leaf_size(elements(k)))
               reach = min(reach, merge(size_of_leaf, size_of_leaf/2, is_corner_of(grid, elements(k), node)))
            end associate
         end do
      end associate
   end function reach_at

   !> Whether a node is a corner of the leaf of an element at which it stands.
   pure logical function is_corner_of(grid, e, node) result(is)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: e, node
      real(dp) :: in_leaf(ndim)
      in_leaf = (grid%node_position(:, node) - grid%element_lower(:, grid%first_of_piece(e)))/grid%leaf_size(e)
      is = all(abs(in_leaf - 0.5_dp) > 0.25_dp)
   end function is_corner_of

   !> Value of a nodal field at a place beside a node, and whether an occupied cell of that node contains the place or has it at its
   !> edge: the mean of these cells. Other cells may be on the other side of a crack at the place.
   subroutine value_at(m, phi, node, x, value, inside)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: phi(:)
      integer, intent(in) :: node
      real(dp), intent(in) :: x(ndim)
      real(dp), intent(out) :: value
      logical, intent(out) :: inside
      integer :: k, e, n, first, before
      value = 0
      n = 0
      before = outside
      associate (grid => m%grid, elements => m%grid%dofs%elements_at(node))
         do k = 1, size(elements)
            first = grid%first_of_piece(elements(k))
            if (first == before) cycle           ! two quarters of a cell, one after the other
            before = first
            e = part_at(grid, first, x)
            if (e == outside) cycle
            if (.not. is_occupied(grid, m%blocks, grid%element_leaf(e))) cycle
            value = value + dot_product(grid%functions_in(e, grid%local_coordinate(e, x)), phi(grid%support_of(e)))
            n = n + 1
         end do
      end associate
      inside = n > 0
      if (inside) value = value/n
   end subroutine value_at

   !> The element at a place, among those of a leaf or of its piece; `outside` if the leaf does not contain the place.
   pure integer function part_at(grid, first, x) result(e)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first               !! of these elements
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), parameter :: beside = 1.0e-3_dp  ! leaves
      real(dp) :: in_leaf(ndim)
      integer :: d
      e = outside
      in_leaf = (x - grid%element_lower(:, first))/grid%leaf_size(first)
      if (any(abs(in_leaf - 0.5_dp) > 0.5_dp + beside)) return
      e = first
      if (.not. grid%is_transition(grid%element_leaf(first))) return
      e = first + sum([(merge(2**(d - 1), 0, in_leaf(d) > 0.5_dp), d=1, ndim)])
   end function part_at
end module hampm_gradient_indicator
