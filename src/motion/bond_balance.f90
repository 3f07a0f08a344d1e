!> The forces with which bonds begin where cells are cut through material that bears something: such that the cut changes nothing at that moment.
!> With them the nodes of both faces have accelerations that do not part them. Of the forces that do this they are those that
!> differ least from the traction of the material there, whose mean in a cell is less than half of what the node at a tip bears: with that alone
!> the node would be let go by half at once, and K would ring.
!>
!>    C M**-1 C' x = C M**-1 S f
!>
!> with C the shares of the nodes in the openings, M their lumped masses, f the forces on them, S the parts of them that are held, and x what the
!> forces of the bonds lack. A node is held by bonds as far as its function reaches along them, over what this is along a side of a
!> cell: what is behind the tip is free. Least squares of x over the lengths of the bonds, by conjugate gradients, damped where bonds
!> are much shorter than a cell and could hold nodes only by tractions without bounds.
module hampm_bond_balance
   use hampm_kinds, only: dp, ndim
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_face_springs, only: face_springs_t
   use hampm_grid, only: grid_t
   use hampm_material, only: material_t
   use hampm_nodes_of_springs, only: load_nodes
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: balance_bonds

contains

   !> Let bonds that begin hold their faces together as the uncut cells did.
   pure subroutine balance_bonds(springs, begins, grid, p, blocks, materials)
      type(face_springs_t), intent(inout) :: springs
      logical, intent(in) :: begins(:)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(material_t), intent(in) :: materials(:)
      real(dp), parameter :: little = 1e-12_dp   ! part of the first residual
      real(dp), parameter :: firm = 0.005_dp     ! damping of least squares, over C M**-1 C' of a side of a cell: next to nothing but for short layers
      real(dp) :: mass(grid%n_nodes), force(ndim, grid%n_nodes), held(grid%n_nodes), length(springs%n)
      real(dp), dimension(ndim, springs%n) :: x, r, direction, product
      real(dp) :: first, norm, new, damping
      integer :: i
      call load_nodes(springs, grid, p, blocks, materials, mass, force)
      length = merge(springs%length(:springs%n), 0.0_dp, begins)
      held = parts_held(springs, length, grid%n_nodes)
      do i = 1, grid%n_nodes
         force(:, i) = held(i)*force(:, i)
      end do
      x = 0
      r = opened_by(springs, force, mass, length)
      direction = r
      norm = sum(r**2)
      first = norm
      damping = 0
      do i = 1, springs%n
         if (.not. begins(i)) cycle
         associate (n => count(springs%node(:, i) > 0))
            damping = max(damping, firm*springs%cell(i)*sum(springs%share(:n, i)**2/mass(springs%node(:n, i))))
         end associate
      end do
      do i = 1, 2*size(r)
         if (.not. norm > little**2*first) exit
         product = opened_by(springs, closed_by(springs, direction, length, grid%n_nodes), mass, length) &
                   + damping*direction
         x = x + norm/sum(direction*product)*direction
         r = r - norm/sum(direction*product)*product
         new = sum(r**2)
         direction = r + new/norm*direction
         norm = new
      end do
      do i = 1, springs%n
         springs%held(:, i) = springs%held(:, i) + sqrt(length(i))*x(:, i)
      end do
   end subroutine balance_bonds

   !> The parts of nodes that springs hold: of the function of a node along them, over that on a side of a cell.
   pure function parts_held(springs, length, n_nodes) result(held)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(in) :: length(:)          !! [m], 0 of springs that do not matter
      integer, intent(in) :: n_nodes
      real(dp) :: held(n_nodes)
      integer :: k, j
      held = 0
      do k = 1, springs%n
         do j = 1, count(springs%node(:, k) > 0)
            associate (of_node => held(springs%node(j, k)))
               of_node = of_node + abs(springs%share(j, k))*length(k)/(springs%cell(k)/2)
            end associate
         end do
      end do
      held = min(1.0_dp, held)
   end function parts_held

   !> How fast nodal forces open springs, times the root of a length of each [m**1.5/s2].
   pure function opened_by(springs, force, mass, length) result(opened)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(in) :: force(:, :)        !! [N], (ndim, nodes)
      real(dp), intent(in) :: mass(:)            !! [kg]
      real(dp), intent(in) :: length(:)          !! [m], 0 of springs that do not matter
      real(dp) :: opened(ndim, springs%n)
      integer :: k, j
      opened = 0
      do k = 1, springs%n
         if (.not. length(k) > 0) cycle
         do j = 1, count(springs%node(:, k) > 0)
            associate (node => springs%node(j, k))
               opened(:, k) = opened(:, k) + sqrt(length(k))*springs%share(j, k)*force(:, node)/mass(node)
            end associate
         end do
      end do
   end function opened_by

   !> The nodal forces by which springs that resist, with a force over the root of a length each, push apart what they hold [N].
   pure function closed_by(springs, resistance, length, n_nodes) result(force)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(in) :: resistance(:, :)   !! [N/m**0.5], (ndim, n)
      real(dp), intent(in) :: length(:)          !! [m]
      integer, intent(in) :: n_nodes
      real(dp) :: force(ndim, n_nodes)
      integer :: k, j
      force = 0
      do k = 1, springs%n
         if (.not. length(k) > 0) cycle
         do j = 1, count(springs%node(:, k) > 0)
            associate (of_node => force(:, springs%node(j, k)))
               of_node = of_node + sqrt(length(k))*springs%share(j, k)*resistance(:, k)
            end associate
         end do
      end do
   end function closed_by
end module hampm_bond_balance
