!> Ghost penalty of small cut cells, at cracks or edges of bodies: their few particles leave motions of nodes nearly free, with next
!> to no mass (docs/explanation/interfaces.md).
!>
!> On a side between a small piece and another one, interface points at the points of Gauss hold the jumps of the normal derivatives
!> of the displacement up to the order p of the cells, and have a mass in motion:
!>
!>    energy = g E' t sum over k of c_k h**(2 k - 1) integral over side of |jump of d^k u/dn^k|**2 ds/2,   c_1 = 1/3, c_2 = 1/20,
!>    and with the velocity, g rho t and h**(2 k + 1) in the place of these.
!>
!> E' is the plane modulus, t the thickness, h the size of the finer cell; of two materials the larger modulus and density count. A
!> polynomial of the order of the cells has no jump. Sources: Burman, Comptes Rendus Mathematique 348 (2010) 1217-1220; Sticko &
!> Kreiss, Computer Methods in Applied Mechanics and Engineering 309 (2016) 364-387.
module hampm_ghost_penalty
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: derivatives_along, hourglass_functions, n_hourglasses, hourglass_directions
   use hampm_disjoint_sets, only: disjoint_sets_t, singletons
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_interface_points, only: interfaces_t, interface_point_t, ghost, add_interface_point
   use hampm_grid, only: grid_t, side_corner
   use hampm_matter, only: matter_t
   use hampm_aggregated_nodes, only: least_fill
   use hampm_tolerance, only: part_of_cell
   implicit none
   private
   public :: stabilise_small_cut_cells, hold_lone_particles, fills_of_pieces, are_nearly_empty, enough_alone

   real(dp), parameter :: enough = 0.9_dp        !! part of a cell from which on a piece holds itself
   real(dp), parameter :: enough_alone = 0.6_dp  !! the same of a quadratic one with no fuller one on its side
   real(dp), parameter :: at_cracks = 0.01_dp    !! g of pieces at cracks, and of all pieces of quadratic cells: a tenth
                                                 !! of it is too soft, ten times shorten cracks (docs/explanation/cracks.md)
   real(dp), parameter :: at_edges = 0.1_dp      !! g of linear pieces at edges of bodies, less their filled part: these
                                                 !! may be arbitrarily thin under all of a load (docs/explanation/cracks.md)
   real(dp), parameter :: in_steps = 1.0_dp      !! g in explicit steps of usl of pieces filled by less than `least_fill`:
                                                 !! their nodes have little mass and must follow the extrapolated field
   real(dp), parameter :: lightness = 0.3_dp     !! g of the mass over g of the stiffness, of quadratic cells, which resolve
                                                 !! waves of the frequency c/h (docs/explanation/quadratic_cut.md)
   real(dp), parameter :: soft = 0.05_dp         !! part of the modulus against bending of cells with one particle if
                                                 !! it yields or relaxes: work of a plastic beam +35 % with 1, -1 % with this
   real(dp), parameter :: part_of_jump(2) = [1/3.0_dp, 1/20.0_dp] !! c_k

   !> Points of Gauss of a side, from 0 to 1, by the order p of the cells, and their weights.
   real(dp), parameter :: far(2) = [sqrt(1/12.0_dp), sqrt(3/20.0_dp)]
   real(dp), parameter :: gauss(3, 2) = 0.5_dp + reshape([-far(1), far(1), 0.0_dp, -far(2), 0.0_dp, far(2)], [3, 2])
   real(dp), parameter :: weight(3, 2) = reshape([9, 9, 0, 5, 8, 5], [3, 2])/18.0_dp

contains

   !> Part of its cell that the particles of each piece of a leaf fill, by its first element; 0 of the other elements.
   pure function fills_of_pieces(m) result(fill)
      type(matter_t), intent(in) :: m
      real(dp), allocatable :: fill(:)
      integer :: i
      allocate (fill(m%grid%n_elements))
      fill = 0
      do i = 1, m%particles%n
         associate (first => m%grid%first_of_piece(m%particles%cell(i)))
            fill(first) = fill(first) + m%particles%area_of(i)/m%grid%leaf_size(first)**ndim
         end associate
      end do
      fill = part_of_cell(fill)
   end function fills_of_pieces

   !> Which bilinear elements are of cells that the edges of bodies leave nearly empty, and have nodes of their own.
   pure function are_nearly_empty(m) result(are)
      type(matter_t), intent(in) :: m
      logical, allocatable :: are(:)
      real(dp), allocatable :: fill(:)
      integer :: e
      allocate (fill(m%grid%n_elements), are(m%grid%n_elements))
      are = .false.
      if (.not. allocated(m%grid%is_full) .or. m%grid%is_quadratic()) return
      fill = fills_of_pieces(m)
      do e = 1, size(are)
         associate (leaf => m%grid%element_leaf(e))
            are(e) = m%grid%is_met(leaf) .and. .not. m%grid%is_full(leaf) .and. fill(m%grid%first_of_piece(e)) < least_fill &
                     .and. .not. m%grid%aggregated_nodes%has_root_cell(leaf)
         end associate
      end do
   end function are_nearly_empty

   !> Add the interface points on the sides of small cut cells, and note whether one that is to move is alone.
   pure subroutine stabilise_small_cut_cells(interfaces, m)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      real(dp), allocatable :: fill(:), modulus(:), density(:), g(:)
      logical, allocatable :: moves(:), is_held(:), is_filled(:), thin(:), at_small(:)
      type(disjoint_sets_t) :: held
      logical :: has_mass, is_in_steps
      integer, allocatable :: others(:)
      integer :: at(m%grid%n_functions), cell, e, i, k, side
      allocate (at_small(m%grid%n_points), source=.false.)
      allocate (moves(m%grid%n_points), is_held(m%grid%n_elements), is_filled(m%grid%n_elements), thin(m%grid%n_elements))
      allocate (fill(m%grid%n_elements), modulus(m%grid%n_elements), density(m%grid%n_elements), g(m%grid%n_elements))
      has_mass = interfaces%are_moving .and. m%grid%is_quadratic()
      is_in_steps = interfaces%are_bounded .and. .not. m%grid%is_quadratic()
      cell = merge(corners, 1, m%grid%is_quadratic()) ! elements of one
      fill = fills_of_pieces(m)
      thin = are_nearly_empty(m)
      moves = .false.
      is_filled = .false.
      modulus = 0
      density = 0
      g = 0
      do i = 1, m%particles%n
         associate (first => m%grid%first_of_piece(m%particles%cell(i)), k => m%particles%material(i))
            modulus(first) = max(modulus(first), m%materials(k)%plane_modulus())
            if (has_mass) density(first) = max(density(first), m%materials(k)%density)
            is_filled(m%particles%cell(i) - mod(m%particles%cell(i) - 1, cell)) = .true.
         end associate
      end do
      do e = 1, m%grid%n_elements, cell
         if (.not. is_filled(e)) cycle
         at = m%grid%support_of(e)
         moves(at) = .true.
      end do
      do e = 1, m%grid%n_elements, cell
         at = m%grid%support_of(e)
         associate (first => m%grid%first_of_piece(e))
            modulus(e) = modulus(first)
            density(e) = density(first)
            if (fill(first) < enough .and. .not. m%grid%aggregated_nodes%has_root_cell(m%grid%element_leaf(e))) g(e) = g_of(e)
            if (g(e) > 0) at_small(at) = .true.
            is_held(e) = is_filled(e)            ! empty cells pass on, but not to free nodes, nor around a crack tip in a hole
            if (.not. is_held(e)) is_held(e) = all(moves(at) .and. at <= m%grid%n_nodes) .and. &
                                               .not. m%grid%is_cut(m%grid%element_leaf(e))
         end associate
      end do
      call singletons(m%grid%n_elements, held)
      do e = 1, m%grid%n_elements, cell
         at = m%grid%support_of(e)
         if (.not. any(at_small(at))) cycle
         do side = 1, 2*ndim
            others = beyond(m%grid, e, side)
            do k = 1, size(others)
               associate (other => others(k))
                  if (.not. (max(g(e), g(other)) > 0 .and. is_held(e) .and. is_held(other))) cycle
                  call held%join(e, other)
                  call hold_side(interfaces, m%grid, max(g(e), g(other))*max(modulus(e), modulus(other)), &
                                 merge(lightness, 1.0_dp, m%grid%is_quadratic())*max(g(e), g(other))* &
                                 max(density(e), density(other)), e, other, side)
               end associate
            end do
         end do
      end do
      interfaces%alone = 0
      if (interfaces%are_moving .and. m%grid%is_quadratic()) &
         interfaces%alone = alone_of(held, is_filled, g > 0 .and. fill < enough_alone)

   contains

      !> g of a cell that is cut; 0 of others.
      pure real(dp) function g_of(element)
         integer, intent(in) :: element
         associate (leaf => m%grid%element_leaf(element))
            g_of = 0
            if (is_in_steps) g_of = merge(in_steps, 0.0_dp, thin(element))
            if (is_in_steps) return
            if (m%grid%is_cut(leaf)) g_of = at_cracks
            if (allocated(m%grid%is_full) .and. .not. m%grid%is_quadratic()) then
               if (m%grid%is_met(leaf) .and. .not. m%grid%is_full(leaf)) &
                  g_of = max(at_cracks, at_edges - fill(m%grid%first_of_piece(element)))
            end if
         end associate
      end function g_of
   end subroutine stabilise_small_cut_cells

   !> Hold the bending of cells with one particle, which gives it no stress, in equilibrium and implicit steps: with the plane
   !> modulus a cell bends as its material, without locking by shear or nu. Linear fields are free. Source: Belytschko & Bindeman,
   !> Computer Methods in Applied Mechanics and Engineering 88 (1991) 311-340 (assumed strain stabilization).
   pure subroutine hold_lone_particles(interfaces, m)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      logical :: are_aggregated                  !! nodes of cells that are nearly empty, so that no cut cell has a penalty
      integer :: i, k
      are_aggregated = ndim > 2 .and. allocated(m%grid%bodies)
      do i = 1, m%particles%n
         associate (e => m%particles%cell(i), at => m%grid%element_lower(:, m%particles%cell(i)), &
                    h => m%grid%leaf_size(m%particles%cell(i)), area => m%particles%area_of(i))
            if (m%blocks%count_in(e) > 1 .or. area < h**ndim*merge(least_fill, 0.5_dp, are_aggregated)) cycle
            if (m%grid%is_cut(m%grid%element_leaf(e)) .and. .not. are_aggregated) cycle
            do k = 1, n_hourglasses
               call add_interface_point(interfaces, ghost)
               associate (point => interfaces%list(interfaces%n), bends => popcnt(hourglass_directions(k)) - 1)
                  call add_shares(point, m%grid, e, hourglass_functions(k, spread(0.5_dp, 1, ndim)))
                  point%n_left = count(point%jump%node > 0)
                  point%place = at + h/2
                  point%origin = point%place
                  point%length = h
                  point%cell = h
                  associate (material => m%materials(m%particles%material(i)))
                     point%stiffness = merge(soft, 1.0_dp, material%has_history)*material%plane_modulus()*(area/h**ndim)**2 &
                                       /12**bends*interfaces%thickness%at(point%place)*h**(ndim - 2)
                  end associate
               end associate
            end do
         end associate
      end do
   end subroutine hold_lone_particles

   !> The last small cell with material that is joined to no larger one; 0 if there is none.
   pure integer function alone_of(held, is_filled, is_small) result(alone)
      type(disjoint_sets_t), intent(in) :: held  !! sets of cells that are joined
      logical, intent(in) :: is_filled(:), is_small(:) !! by the first element of each cell
      logical :: is_firm(size(is_small))
      integer :: e
      is_firm = .false.
      do e = 1, size(is_small)
         if (is_filled(e) .and. .not. is_small(e)) is_firm(held%least_of(e)) = .true.
      end do
      alone = 0
      do e = 1, size(is_small)
         if (is_filled(e) .and. .not. is_firm(held%least_of(e))) alone = e
      end do
   end function alone_of

   !> The cells beyond a side of a cell, with material joined to its own: they share both ends of the side, or the nodes on which
   !> these hang, and are larger or, if equal, above: each side, or part of one beside finer cells, is found once. Ahead of a crack
   !> there are two, the pieces of the cell in which it ends.
   pure function beyond(grid, e, side) result(others)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: e                   !! a linear element, or the first of a quadratic cell
      integer, intent(in) :: side                !! as in `side_corner`
      integer, allocatable :: others(:)
      integer, parameter :: of_quadratic(4) = [1, 3, 7, 9] ! corners among the nodes
      integer :: nodes(grid%n_functions), ends(2), k, other
      real(dp) :: way(ndim)
      ends = [side_corner(side, 1), side_corner(side, 2)]
      if (grid%is_quadratic()) ends = of_quadratic(ends)
      nodes = grid%support_of(e)
      ends = nodes(ends)
      allocate (others(0))
      k = grid%dofs%a_master_of(ends(1))
      if (k == 0) return
      associate (around => [grid%dofs%elements_at(ends(1)), grid%dofs%elements_at(k)], own => size_of_cell(grid, e), &
                 axis => (side + 1)/2)
         do k = 1, size(around)
            other = around(k)
            if (grid%is_quadratic()) other = grid%first_of_piece(other)
            if (any(others == other) .or. .not. (reaches(grid, other, ends(1)) .and. reaches(grid, other, ends(2)))) cycle
            associate (more => size_of_cell(grid, other) - own)
               way = grid%element_lower(:, other) - grid%element_lower(:, e) + more/2 ! from middle to middle
               if (mod(side, 2) == 1) way(axis) = -way(axis)
               if (way(axis) > own/2 .and. abs(way(3 - axis)) < own/2 + more/2 .and. (mod(side, 2) == 0 .or. more > own/2)) &
                  others = [others, other]
            end associate
         end do
      end associate
   end function beyond

   !> Whether a cell depends on a point, or on all the nodes on which that hangs.
   pure logical function reaches(grid, cell, point)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                !! as in `beyond`
      integer, intent(in) :: point
      real(dp) :: weight(1, most_nodes_of_leaf)
      integer :: nodes(grid%n_functions), master(most_nodes_of_leaf), n, k
      nodes = grid%support_of(cell)
      reaches = any(nodes == point)
      if (reaches .or. point <= grid%n_nodes) return
      call grid%dofs%masters_of([point], n, master, weight)
      reaches = n > 0 .and. all([(any(nodes == master(k)), k=1, n)])
   end function reaches

   !> Size of a linear element, or of the quadratic cell that begins with one [m].
   pure real(dp) function size_of_cell(grid, e) result(edge)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: e
      edge = grid%element_size(e)
      if (grid%is_quadratic()) edge = grid%leaf_size(e)
   end function size_of_cell

   !> Hold the jumps of the normal derivatives on the side between two cells.
   pure subroutine hold_side(interfaces, grid, firmness, heaviness, e, other, side)
      type(interfaces_t), intent(inout) :: interfaces
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: firmness           !! g E' [Pa]
      real(dp), intent(in) :: heaviness          !! g rho [kg/m3]
      integer, intent(in) :: e, other            !! cells as in `beyond`
      integer, intent(in) :: side                !! of the first
      real(dp) :: xi(ndim), way
      integer :: p, k, i
      p = merge(2, 1, grid%is_quadratic())
      way = merge(1.0_dp, -1.0_dp, mod(side, 2) == 0) ! jumps are of the lower cell less the upper one, whichever is the first
      associate (h => size_of_cell(grid, e), of_other => size_of_cell(grid, other), direction => (side + 1)/2)
         do i = 1, p + 1
            xi(direction) = mod(side - 1, 2)
            xi(3 - direction) = gauss(i, p)
            do k = 1, p
               call add_interface_point(interfaces, ghost)
               associate (point => interfaces%list(interfaces%n))
                  point%place = grid%element_lower(:, e) + xi*h
                  point%origin = point%place
                  call add_shares(point, grid, e, way*derivatives_along(grid%n_functions, direction, k, xi))
                  point%n_left = count(point%jump%node > 0)
                  call add_shares(point, grid, other, -way*(h/of_other)**k* &
                                  derivatives_along(grid%n_functions, direction, k, &
                                                    (point%place - grid%element_lower(:, other))/of_other))
                  associate (factor => part_of_jump(k)*weight(i, p)*interfaces%thickness%at(point%place))
                     point%stiffness = factor*firmness
                     point%jump%mass = factor*heaviness*h**ndim
                  end associate
                  point%length = weight(i, p)*h
                  point%cell = grid%leaf_size(e)
               end associate
            end do
         end do
      end associate
   end subroutine hold_side

   !> Add derivatives of the functions of a cell to the shares of the nodes of an interface point.
   pure subroutine add_shares(point, grid, cell, derivative)
      type(interface_point_t), intent(inout) :: point
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell
      real(dp), intent(in) :: derivative(grid%n_functions)
      real(dp) :: of_master(grid%n_functions, most_nodes_of_leaf)
      integer :: master(most_nodes_of_leaf), n, j, at
      call grid%dofs%masters_of(grid%support_of(cell), n, master, of_master)
      do j = 1, n
         do at = 1, size(point%jump%node)
            if (point%jump%node(at) == master(j) .or. point%jump%node(at) == 0) exit
         end do
         point%jump%node(at) = master(j)
         point%jump%share(at) = point%jump%share(at) + dot_product(derivative, of_master(:, j))
      end do
   end subroutine add_shares
end module hampm_ghost_penalty
