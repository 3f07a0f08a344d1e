!> Lumped masses of the nodes that springs between the faces of cracks hang on, and the forces on these.
module hampm_nodes_of_springs
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions, shape_gradients
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_face_springs, only: face_springs_t, add_spring_forces
   use hampm_grid, only: grid_t
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   use hampm_remembering, only: hoop_resistance
   implicit none
   private
   public :: masses_of, load_nodes

contains

   !> Lumped masses of the nodes of springs, and the forces of the particles and the springs on them.
   pure subroutine load_nodes(springs, grid, p, blocks, materials, mass, force)
      type(face_springs_t), intent(in) :: springs
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(out) :: mass(:)           !! [kg]
      real(dp), intent(out) :: force(:, :)       !! [N], (ndim, nodes)
      logical :: is_wanted(size(mass))
      real(dp) :: weight(1, most_nodes_of_leaf)
      integer :: node, n, k, j, master(most_nodes_of_leaf)
      is_wanted = .false.
      do k = 1, springs%n
         is_wanted(pack(springs%list(k)%node, springs%list(k)%node > 0)) = .true.
      end do
      mass = masses_of(grid, p, blocks, is_wanted)
      force = 0
      do node = 1, grid%n_nodes
         if (is_wanted(node)) force(:, node) = force_at(grid, p, blocks, materials, node)
      end do
      do node = grid%n_nodes + 1, grid%n_nodes + grid%dofs%n_hanging
         call grid%dofs%masters_of([node], n, master, weight)
         if (.not. any(is_wanted(master(:n)))) cycle
         do j = 1, n
            force(:, master(j)) = force(:, master(j)) + weight(1, j)*force_at(grid, p, blocks, materials, node)
         end do
      end do
      call add_spring_forces(springs, force)
   end subroutine load_nodes

   !> Masses of some nodes, with what hanging nodes give them; 0 of the others [kg].
   pure function masses_of(grid, p, blocks, is_wanted) result(mass)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      logical, intent(in) :: is_wanted(:)        !! (nodes)
      real(dp) :: mass(grid%n_nodes)
      real(dp) :: weight(1, most_nodes_of_leaf)
      integer :: node, n, master(most_nodes_of_leaf)
      mass = 0
      do node = 1, grid%n_nodes
         if (is_wanted(node)) mass(node) = mass_at(grid, p, blocks, node)
      end do
      do node = grid%n_nodes + 1, grid%n_nodes + grid%dofs%n_hanging
         call grid%dofs%masters_of([node], n, master, weight)
         if (any(is_wanted(master(:n)))) mass(master(:n)) = mass(master(:n)) + weight(1, :n)*mass_at(grid, p, blocks, node)
      end do
      ! Particles on an edge of a cell give nothing to the nodes at the other one, and what is next to nothing must not be divided by
      where (is_wanted) mass = max(mass, epsilon(mass)*maxval(mass), tiny(mass))
   end function masses_of

   !> Force of the particles of the elements around a node on it [N].
   pure function force_at(grid, p, blocks, materials, node) result(force)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(material_t), intent(in) :: materials(:)
      integer, intent(in) :: node
      real(dp) :: force(ndim), gradient(corners, ndim), shape(corners), x(ndim)
      integer :: k, i
      force = 0
      associate (elements => grid%dofs%elements_at(node), corner => grid%dofs%corners_at(node))
         do k = 1, size(elements)
            associate (e => elements(k))
               do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                  x = p%place_in_grid(i)
                  gradient = shape_gradients(grid%local_coordinate(e, x), 1/grid%leaf_size(e))
                  force = force - p%volume(i)*matmul(materials(p%material(i))%mapped_stress(p%gradient_of(i), p%total_frame, &
                                                                                           p%history_of(i), p%hoop_of(i)), &
                                                     gradient(corner(k), :))
                  if (.not. p%thickness%is_ring) cycle
                  shape = shape_functions(grid%local_coordinate(e, x))
                  force(1) = force(1) - p%volume(i)*shape(corner(k))*hoop_resistance(materials(p%material(i)), p, i)
               end do
            end associate
         end do
      end associate
   end function force_at

   !> Lumped mass of a node by the particles of the elements around it, without what hanging nodes would give it [kg].
   pure real(dp) function mass_at(grid, p, blocks, node) result(mass)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: node
      real(dp) :: shape(corners), x(ndim)
      integer :: k, i
      mass = 0
      associate (elements => grid%dofs%elements_at(node), corner => grid%dofs%corners_at(node))
         do k = 1, size(elements)
            associate (e => elements(k))
               do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                  x = p%place_in_grid(i)
                  shape = shape_functions(grid%local_coordinate(e, x))
                  mass = mass + p%mass(i)*shape(corner(k))
               end do
            end associate
         end do
      end associate
   end function mass_at
end module hampm_nodes_of_springs
