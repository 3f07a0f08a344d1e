!> What holds small pieces of linear cells, as cracks or edges of bodies leave them: one or two particles resist next to nothing of how the nodes
!> of a piece may move, and a load on it would move these without end.
!>
!> On a side that a small piece has in common with another one, the jump of the derivative of the displacement normal to the side is held by
!> interface points, at the points of Gauss:
!>
!>    energy = gamma E' t h/3 integral over the side of |du/dn of one - du/dn of the other|**2 ds/2,
!>
!> E' being the modulus of the plane, t the thickness and h the size of the cell. So the displacement of a full cell is continued into the pieces
!> beside it, and by these to others. A linear displacement has no such jump: nothing holds it, nor the motion of rigid bodies.
!> By h/3 the energy is that of the difference of both continued fields in a cell, times gamma.
!>
!> This is for rest and implicit steps: in explicit ones the stiffness would need a mass like it.
!>
!> Source: Burman, Ghost penalty, Comptes Rendus Mathematique 348 (2010) 1217-1220.
module hampm_ghost_penalty
   use hampm_kinds, only: dp, ndim, corners
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_interface_points, only: interfaces_t, ghost, add_interface_point
   use hampm_forest, only: corner_offset
   use hampm_grid, only: grid_t
   use hampm_matter, only: matter_t
   use hampm_tolerance, only: part_of_cell
   implicit none
   private
   public :: hold_small_pieces, fills_of_pieces, enough

   real(dp), parameter :: enough = 0.9_dp        !! part of a cell from which on a piece holds itself
   real(dp), parameter :: at_cracks = 0.01_dp    !! gamma of pieces that cracks leave, which hold a particle at least: ten times less lets nodes move
                                                 !! by 1.4 times as much, ten times more makes cracks shorter by a tenth of a cell
   real(dp), parameter :: at_edges = 0.1_dp      !! of those at edges of bodies, which may be as thin as one likes under all of a load, less what they fill: a
                                                 !! piece has that part of the stiffness of a cell by itself. With ten times less the energy of
                                                 !! rings with three levels was up to 5 % too large (docs/cracks.md)
   real(dp), parameter :: at_thick_edges = 0.02_dp !! the least of them: few particles leave motions of the nodes free. 0.1 at all makes beams across the
                                                 !! grid stiffer by 0.2 % and the stress at small holes lower by 2 %
   real(dp), parameter :: gauss(ndim) = 0.5_dp + [-0.5_dp, 0.5_dp]/sqrt(3.0_dp) !! points of a side, from 0 to 1

contains

   !> Part of its cell that the particles of each piece of a leaf fill, by its first element; 0 of the other elements.
   pure function fills_of_pieces(m) result(fill)
      type(matter_t), intent(in) :: m
      real(dp) :: fill(m%grid%n_elements)
      integer :: i
      fill = 0
      do i = 1, m%particles%n
         associate (first => m%grid%first_of_piece(m%particles%cell(i)))
            fill(first) = fill(first) + m%particles%area_of(i)/m%grid%leaf_size(first)**ndim
         end associate
      end do
      fill = part_of_cell(fill)
   end function fills_of_pieces

   !> Add the interface points on the sides of small pieces.
   pure subroutine hold_small_pieces(interfaces, m)
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      real(dp) :: fill(m%grid%n_elements), modulus(m%grid%n_elements), gamma(m%grid%n_elements)
      logical :: moves(m%grid%n_points), is_held(m%grid%n_elements), is_filled(m%grid%n_elements)
      integer, allocatable :: others(:)
      integer :: e, i, k, side
      fill = fills_of_pieces(m)
      moves = .false.
      is_filled = .false.
      modulus = 0
      do i = 1, m%particles%n
         associate (first => m%grid%first_of_piece(m%particles%cell(i)))
            modulus(first) = max(modulus(first), m%materials(m%particles%material(i))%plane_modulus())
         end associate
         moves(m%grid%element_nodes(:, m%particles%cell(i))) = .true.
         is_filled(m%particles%cell(i)) = .true.
      end do
      do e = 1, m%grid%n_elements
         associate (first => m%grid%first_of_piece(e), at => m%grid%element_nodes(:, e))
            modulus(e) = modulus(first)
            gamma(e) = 0
            if (fill(first) < enough .and. .not. m%grid%outer_nodes%has_host(m%grid%element_leaf(e))) gamma(e) = gamma_of(e)
            is_held(e) = is_filled(e) .or. all(moves(at) .and. at <= m%grid%n_nodes) ! an empty one passes on, but not to nodes that nothing moves
         end associate
      end do
      do e = 1, m%grid%n_elements
         do side = 1, ndim
            others = beyond(m%grid, e, side)
            do k = 1, size(others)
               associate (other => others(k))
                  if (max(gamma(e), gamma(other)) > 0 .and. is_held(e) .and. is_held(other)) &
                     call hold_side(interfaces, m%grid, max(gamma(e), gamma(other))*max(modulus(e), modulus(other)), e, other, side)
               end associate
            end do
         end do
      end do
   contains
      !> Gamma of a leaf that is cut; 0 of others.
      pure real(dp) function gamma_of(element)
         integer, intent(in) :: element
         associate (leaf => m%grid%element_leaf(element))
            gamma_of = 0
            if (m%grid%is_cut(leaf)) gamma_of = at_cracks
            if (allocated(m%grid%is_full)) then
               if (m%grid%is_met(leaf) .and. .not. m%grid%is_full(leaf)) &
                  gamma_of = max(at_thick_edges, at_edges - fill(m%grid%first_of_piece(element)))
            end if
         end associate
      end function gamma_of
   end subroutine hold_small_pieces

   !> The elements beyond the upper side of an element in a direction whose material is joined to its: those that have both ends of the side in
   !> common with it. Ahead of a crack there are two, the pieces of the cell in which it ends.
   pure function beyond(grid, e, direction) result(others)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: e
      integer, intent(in) :: direction           !! normal to the side
      integer, allocatable :: others(:)
      integer :: here(2), there(2), k
      here = ends_of_side(direction, 1)
      there = ends_of_side(direction, 0)
      associate (nodes => grid%element_nodes(:, e))
         associate (around => grid%dofs%elements_at(nodes(here(1))))
            others = pack(around, [(all(grid%element_nodes(there, around(k)) == nodes(here)), k=1, size(around))])
         end associate
      end associate
   end function beyond

   !> The corners of an element at the ends of its lower or upper side in a direction.
   pure function ends_of_side(direction, upper) result(ends)
      integer, intent(in) :: direction
      integer, intent(in) :: upper               !! 0 the lower, 1 the upper side
      integer :: ends(2)
      integer :: corner, offset(ndim), n
      n = 0
      ends = 0
      do corner = 1, corners
         offset = corner_offset(corner)
         if (offset(direction) /= upper) cycle
         n = n + 1
         ends(n) = corner
      end do
   end function ends_of_side

   !> Hold the jump of the normal derivative on a side between two elements.
   pure subroutine hold_side(interfaces, grid, modulus, e, other, direction)
      type(interfaces_t), intent(inout) :: interfaces
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: modulus            !! gamma E' [Pa]
      integer, intent(in) :: e, other            !! below the side, and beyond it
      integer, intent(in) :: direction           !! normal to it
      real(dp) :: weight(corners, most_nodes_of_leaf), xi(ndim)
      integer :: master(most_nodes_of_leaf), n, j, k
      do k = 1, size(gauss)
         call add_interface_point(interfaces, ghost)
         associate (s => interfaces%n)
            xi(direction) = 1
            xi(3 - direction) = gauss(k)
            interfaces%list(s)%place = grid%element_lower(:, e) + xi*grid%element_size(e)
            call grid%dofs%masters_of(grid%element_nodes(:, e), n, master, weight)
            interfaces%list(s)%node(:n) = master(:n)
            interfaces%list(s)%share(:n) = normal_derivative(e, xi, weight(:, :n))
            interfaces%list(s)%n_left = n
            xi(direction) = 0
            call grid%dofs%masters_of(grid%element_nodes(:, other), j, master, weight)
            interfaces%list(s)%node(n + 1:n + j) = master(:j)
            interfaces%list(s)%share(n + 1:n + j) = -normal_derivative(other, xi, weight(:, :j))
            interfaces%list(s)%stiffness = modulus*interfaces%thickness%at(interfaces%list(s)%place)/(3*size(gauss))
            interfaces%list(s)%length = grid%element_size(e)/size(gauss)
            interfaces%list(s)%cell = grid%leaf_size(e)
         end associate
      end do
   contains
      !> Derivatives of functions normal to the side, times the size of the cell [-].
      pure function normal_derivative(element, at, of_master) result(derivative)
         integer, intent(in) :: element
         real(dp), intent(in) :: at(ndim)        !! local coordinate [-]
         real(dp), intent(in) :: of_master(:, :) !! weights of masters, (corners, masters)
         real(dp) :: derivative(size(of_master, 2))
         real(dp) :: gradient(corners, ndim)
         gradient = grid%gradients_in(element, at)
         derivative = grid%element_size(element)*matmul(gradient(:, direction), of_master)
      end function normal_derivative
   end subroutine hold_side
end module hampm_ghost_penalty
