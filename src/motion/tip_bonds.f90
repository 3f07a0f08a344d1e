!> Bonds at the tips of cracks that end inside a cell. Such a cell is cut as a whole (`hampm_cut_cells`), and what of its cut lies ahead
!> of the tip is held together by a layer of springs between the two sides, E'/h times a number stiff for each area. So the crack of
!> the cells grows with that of the scene, and not by whole cells.
!>
!> The springs act at points along that part. The opening at a point is what the shape functions there make of the displacements of
!> the nodes of both sides,
!>
!>    g = sum over nodes of c_j u_j,   force on node j   -s c_j g,   energy   s g . g/2,
!>
!> and follows these in every step, in the total frame. A node with little mass would tremble faster than any cell does: where they
!> must, all springs of a layer are weaker, so that with M the lumped masses the largest eigenvalue of M**-1 K of the layer by itself is
!> at most a part of that of the cells.
module hampm_tip_bonds
   use hampm_kinds, only: dp, ndim, corners
   use hampm_archive, only: archive_t
   use hampm_basis, only: shape_functions
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_grid, only: grid_t
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: tip_bonds_t, rebuild_bonds, shorter_step, add_bond_forces, stretch_bonds, bond_energy, keep_bonds

   integer, parameter :: points = 4              !! of a layer, those of Gauss
   real(dp), parameter :: outer = 0.8611363115940526_dp, inner = 0.3399810435848563_dp
   real(dp), parameter :: place(points) = [-outer, -inner, inner, outer] !! in a layer from -1 to 1
   real(dp), parameter :: of_outer = 0.3478548451374538_dp/2, of_inner = 0.6521451548625461_dp/2
   real(dp), parameter :: part(points) = [of_outer, of_inner, of_inner, of_outer] !! of the layer that each stands for

   !> Stiffness of the layer in E'/h. Of 0.3, 1, 3 and 10 the last two leave the least scatter of J between places of the tip
   !> (docs/cracks.md).
   real(dp), parameter :: firmness = 3

   !> The largest eigenvalue of a layer, over (c/h)**2 with c the speed of pressure waves; that of cells is 4 at least.
   real(dp), parameter :: most_of_cells = 1.2_dp

   !> Factor of the time step that is stable for whole cells, with cells that are cut, which multiply the largest eigenvalue by 1.27
   !> at most, and with bonds: 1/sqrt(1.27 + 1.2/4).
   real(dp), parameter :: shorter_step = 0.79_dp

   !> All springs.
   type :: tip_bonds_t
      real(dp) :: thickness = 0                  !! of the plate [m]
      integer :: n = 0                           !! number of springs
      integer, allocatable :: node(:, :)         !! whose displacement matters, 0 behind the last; (2 most_nodes_of_leaf, n)
      real(dp), allocatable :: share(:, :)       !! c_j [-]
      real(dp), allocatable :: stiffness(:)      !! s [N/m]
      real(dp), allocatable :: opening(:, :)     !! g [m], (ndim, n)
   end type tip_bonds_t

contains

   !> Find the springs of a new grid; their openings are those of the particles beside them.
   pure subroutine rebuild_bonds(bonds, grid, p, blocks, materials)
      type(tip_bonds_t), intent(inout) :: bonds
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(material_t), intent(in) :: materials(:)
      integer :: k, i, most, first
      bonds%n = 0
      if (.not. grid%cut_cells%are_there()) return
      most = points*size(grid%cut_cells%ends)
      if (allocated(bonds%node)) deallocate (bonds%node, bonds%share, bonds%stiffness, bonds%opening)
      allocate (bonds%node(2*most_nodes_of_leaf, most), bonds%share(2*most_nodes_of_leaf, most), bonds%stiffness(most), &
                bonds%opening(ndim, most))
      do k = 1, size(grid%cut_cells%ends)
         if (grid%cut_cells%ends(k)%leaf == 0) cycle
         first = bonds%n + 1
         do i = 1, points
            call add_spring(bonds, grid, p, blocks, materials, k, i)
         end do
         if (bonds%n < first) cycle
         associate (of_tip => materials(p%material(blocks%first_in(grid%element_at(grid%cut_cells%ends(k)%tip)))), &
                    cell => grid%forest%size_of(grid%cut_cells%ends(k)%leaf))
            call soften(bonds, first, grid, p, blocks, most_of_cells*(of_tip%dilatational_wave_speed()/cell)**2)
         end associate
      end do
   end subroutine rebuild_bonds

   !> Make the springs from the `first` on weaker, so that no eigenvalue is larger than `most`: row sums bound them.
   pure subroutine soften(bonds, first, grid, p, blocks, most)
      type(tip_bonds_t), intent(inout) :: bonds
      integer, intent(in) :: first
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      real(dp), intent(in) :: most               !! [1/s2]
      real(dp) :: largest, row
      integer :: k, l, i, j
      largest = 0
      do k = first, bonds%n
         row = 0
         do l = first, bonds%n
            do i = 1, count(bonds%node(:, k) > 0)
               do j = 1, count(bonds%node(:, l) > 0)
                  if (bonds%node(i, k) /= bonds%node(j, l)) cycle
                  row = row + sqrt(bonds%stiffness(k)*bonds%stiffness(l))*abs(bonds%share(i, k)*bonds%share(j, l)) &
                        /mass_at(grid, p, blocks, bonds%node(i, k))
               end do
            end do
         end do
         largest = max(largest, row)
      end do
      if (largest > most) bonds%stiffness(first:bonds%n) = most/largest*bonds%stiffness(first:bonds%n)
   end subroutine soften

   !> Lumped mass of a node by the particles of the elements around it, without what hanging nodes would give it [kg].
   pure real(dp) function mass_at(grid, p, blocks, node) result(mass)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: node
      real(dp) :: shape(corners)
      integer :: k, i
      mass = tiny(mass)
      associate (elements => grid%dofs%elements_at(node), corner => grid%dofs%corners_at(node))
         do k = 1, size(elements)
            associate (e => elements(k))
               do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                  shape = shape_functions(grid%local_coordinate(e, p%reference(i, :)))
                  mass = mass + p%mass(i)*shape(corner(k))
               end do
            end associate
         end do
      end associate
   end function mass_at

   !> Add the spring at a point of a layer, unless there is no material on one of its sides.
   pure subroutine add_spring(bonds, grid, p, blocks, materials, end, point)
      type(tip_bonds_t), intent(inout) :: bonds
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(material_t), intent(in) :: materials(:)
      integer, intent(in) :: end                 !! of a line, at which the layer is
      integer, intent(in) :: point
      real(dp), parameter :: beside = 1e-4_dp    ! cells
      real(dp) :: x(ndim), along(ndim), normal(ndim), weight(corners, most_nodes_of_leaf)
      integer :: side, e(2), master(most_nodes_of_leaf), n, j
      associate (tip => grid%cut_cells%ends(end)%tip, front => grid%cut_cells%ends(end)%front, b => bonds%n)
         along = front - tip
         normal = [-along(2), along(1)]/norm2(along)
         x = tip + (1 + place(point))/2*along
         do side = 1, 2
            e(side) = grid%element_at(x + (3 - 2*side)*beside*grid%forest%size_of(grid%cut_cells%ends(end)%leaf)*normal)
         end do
         if (any(e == 0) .or. e(1) == e(2)) return
         if (any(blocks%count_in(e) == 0)) return
         b = b + 1
         bonds%node(:, b) = 0
         bonds%share(:, b) = 0
         bonds%opening(:, b) = 0
         n = 0
         do side = 1, 2
            associate (element => e(side))
               call grid%dofs%masters_of(grid%element_nodes(:, element), j, master, weight)
               bonds%node(n + 1:n + j, b) = master(:j)
               bonds%share(n + 1:n + j, b) = (3 - 2*side)*matmul(shape_functions(grid%local_coordinate(element, x)), weight(:, :j))
               n = n + j
               bonds%opening(:, b) = bonds%opening(:, b) + (3 - 2*side)*displacement_at(p, blocks, element, x)
            end associate
         end do
         associate (material => materials(p%material(blocks%first_in(e(1)))))
            bonds%stiffness(b) = firmness*material%plane_modulus()/grid%leaf_size(e(1))*bonds%thickness &
                                 *part(point)*norm2(along)
         end associate
      end associate
   end subroutine add_spring

   !> Displacement at a place by the particles of an element: the mean of what each tells [m].
   pure function displacement_at(p, blocks, e, x) result(u)
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: e
      real(dp), intent(in) :: x(ndim)            !! in the reference configuration [m]
      real(dp) :: u(ndim)
      integer :: i
      u = 0
      do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
         u = u + (p%displacement(i, :) + matmul(p%gradient_of(i), x - p%reference(i, :)))/blocks%count_in(e)
      end do
   end function displacement_at

   !> Add the forces of the springs on the nodes [N].
   pure subroutine add_bond_forces(bonds, force)
      type(tip_bonds_t), intent(in) :: bonds
      real(dp), intent(inout) :: force(:, :)     !! (ndim, n_points)
      integer :: k, j
      do k = 1, bonds%n
         do j = 1, size(bonds%node, 1)
            associate (node => bonds%node(j, k))
               if (node > 0) force(:, node) = force(:, node) - bonds%stiffness(k)*bonds%share(j, k)*bonds%opening(:, k)
            end associate
         end do
      end do
   end subroutine add_bond_forces

   !> Let the openings follow a displacement of the nodes, `scale` times a field.
   pure subroutine stretch_bonds(bonds, field, scale)
      type(tip_bonds_t), intent(inout) :: bonds
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp), intent(in) :: scale
      integer :: k, j
      do k = 1, bonds%n
         do j = 1, size(bonds%node, 1)
            associate (node => bonds%node(j, k))
               if (node > 0) bonds%opening(:, k) = bonds%opening(:, k) + scale*bonds%share(j, k)*field(:, node)
            end associate
         end do
      end do
   end subroutine stretch_bonds

   !> Energy that the springs store [J].
   pure real(dp) function bond_energy(bonds) result(energy)
      type(tip_bonds_t), intent(in) :: bonds
      integer :: k
      energy = 0
      do k = 1, bonds%n
         energy = energy + bonds%stiffness(k)*sum(bonds%opening(:, k)**2)/2
      end do
   end function bond_energy

   !> Keep the openings.
   subroutine keep_bonds(bonds, archive)
      type(tip_bonds_t), intent(inout) :: bonds
      class(archive_t), intent(inout) :: archive
      if (bonds%n == 0) return
      call archive%section('tip_bonds')
      call archive%keep_reals('opening', ndim*bonds%n, bonds%opening)
   end subroutine keep_bonds
end module hampm_tip_bonds
