!> Values at one node from the particles in the cells around it.
module hampm_patch
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: inside_cell
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_grid, only: grid_t, is_toward
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   use hampm_state_update, only: hoop_resistance
   implicit none
   private
   public :: patch_t, patch_around, patch_of_face, fitted_displacement, internal_force, patch_mass

   !> The particles in the cells around a node, each with its shape functions.
   type :: patch_t
      integer :: n_nodes = 0
      integer, allocatable :: node(:)            !! nodes of these cells; the first is the one in the middle. (n_nodes or more)
      integer :: n = 0                           !! number of particles
      integer, allocatable :: particle(:)        !! (n)
      real(dp), allocatable :: shape(:, :)       !! shape functions, (n_nodes or more, n)
      real(dp), allocatable :: gradient(:, :)    !! gradient of the function of the middle node [1/m], (ndim, n)
   end type patch_t

contains

   !> Collect the patch of occupied cells around a node, or on one side of it, in the direction `toward`; or of the particles, of
   !> bodies in which cracks can be, with reference positions there, with the shape functions there.
   pure subroutine patch_around(grid, p, blocks, node, patch, toward, at_reference)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: node
      type(patch_t), intent(out) :: patch
      real(dp), intent(in), optional :: toward(ndim)
      logical, intent(in), optional :: at_reference
      logical, allocatable :: wanted(:)
      integer, allocatable :: elements(:), members(:)
      integer :: k, i, room, local(grid%n_functions), together, numbered
      real(dp) :: place(ndim)
      logical :: is_now
      is_now = .true.
      if (present(at_reference)) is_now = .not. at_reference
      associate (around => grid%dofs%elements_at(node), corner => grid%dofs%corners_at(node))
         allocate (elements, source=around)
         if (is_now) then
            allocate (wanted, source=blocks%count_in(around) > 0)
            if (present(toward)) wanted = wanted .and. [(is_toward(corner(k), toward), k=1, size(corner))]
            elements = whole_cells(grid, pack(around, wanted))
         end if
      end associate
      room = sum(blocks%count_in(elements))
      if (.not. is_now) room = p%n
      together = merge(corners, 1, grid%is_quadratic()) ! elements with the same nodes
      numbered = -1
      associate (nodes => 1 + (grid%n_functions - 1)*size(elements))
         allocate (patch%node(nodes), patch%particle(room), patch%gradient(ndim, room))
         allocate (patch%shape(nodes, room), source=0.0_dp)
      end associate
      patch%n_nodes = 1
      patch%node(1) = node
      do k = 1, size(elements)
         members = members_of(elements(k))
         if (size(members) == 0) cycle
         if ((k - 1)/together /= numbered) call number_nodes(grid, elements(k), patch, local)
         numbered = (k - 1)/together
         do i = 1, size(members)
            place = p%reference(members(i), :)
            if (is_now) place = p%place_in_grid(members(i))
            call add_particle(grid, elements(k), local, members(i), place, patch)
         end do
      end do

   contains

      !> The particles of an element.
      pure function members_of(e) result(members)
         integer, intent(in) :: e
         integer, allocatable :: members(:)
         integer :: i
         if (is_now) then
            members = [(i, i=blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e))]
         else
            members = pack([(i, i=1, p%n)], [(began_in(e, i), i=1, p%n)])
         end if
      end function members_of

      !> Whether a particle's reference position is in an element.
      pure logical function began_in(e, i)
         integer, intent(in) :: e, i
         real(dp) :: x(ndim)
         x = p%reference(i, :)
         began_in = grid%velocity_field_of(p%body(i)) == 1 .and. all(abs(grid%local_coordinate(e, x) - 0.5_dp) < 0.5_dp)
      end function began_in
   end subroutine patch_around

   !> The elements whose values depend on a node, from those around it: the same or, in quadratic cells, all quarters of their
   !> leaves.
   pure function whole_cells(grid, around) result(elements)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: around(:)
      integer, allocatable :: elements(:)
      integer :: first(size(around)), k, q
      elements = around
      if (.not. grid%is_quadratic()) return
      first = [(grid%first_of_piece(around(k)), k=1, size(around))]
      elements = [([(first(k) + q, q=0, corners - 1)], k=1, size(around))]
      elements = pack(elements, [(all(first(:k - 1) /= first(k)), all(first(:k - 1) /= first(k)), &
                                  all(first(:k - 1) /= first(k)), all(first(:k - 1) /= first(k)), k=1, size(around))])
   end function whole_cells

   !> The patch for the displacement of a node of the crack's faces: around it or, where its material has moved by more than a small
   !> part of a cell, the particles that were in the cells around it at the beginning.
   pure subroutine patch_of_face(grid, p, blocks, node, patch)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: node
      type(patch_t), intent(out) :: patch
      real(dp), parameter :: small = 0.1_dp      !! part of a cell
      real(dp) :: cell
      call patch_around(grid, p, blocks, node, patch)
      if (p%total_frame) return
      cell = grid%smallest_leaf_at(node)
      if (patch%n > 0) then
         if (all(abs(p%displacement(patch%particle(:patch%n), :)) < small*cell)) return
      end if
      call patch_around(grid, p, blocks, node, patch, at_reference=.true.)
   end subroutine patch_of_face

   !> Numbers of the nodes of an element within the patch; a new node gets the next number.
   pure subroutine number_nodes(grid, e, patch, local)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: e
      type(patch_t), intent(inout) :: patch
      integer, intent(out) :: local(:)
      integer :: support(grid%n_functions), c
      support = grid%support_of(e)
      do c = 1, size(support)
         local(c) = findloc(patch%node(:patch%n_nodes), support(c), dim=1)
         if (local(c) > 0) cycle
         patch%n_nodes = patch%n_nodes + 1
         patch%node(patch%n_nodes) = support(c)
         local(c) = patch%n_nodes
      end do
   end subroutine number_nodes

   !> Add a particle at a place in an element whose values depend on the middle node, the first of the patch.
   pure subroutine add_particle(grid, e, local, i, place, patch)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: e
      integer, intent(in) :: local(:)            !! numbers of the nodes within the patch
      integer, intent(in) :: i                   !! the particle
      real(dp), intent(in) :: place(ndim)        !! [m]
      type(patch_t), intent(inout) :: patch
      real(dp) :: xi(ndim), dn(grid%n_functions, ndim)
      xi = inside_cell(grid%local_coordinate(e, place))
      dn = grid%gradients_in(e, xi)
      patch%n = patch%n + 1
      patch%particle(patch%n) = i
      patch%shape(local, patch%n) = grid%functions_in(e, xi)
      patch%gradient(:, patch%n) = dn(findloc(local, 1, dim=1), :)
   end subroutine add_particle

   !> Force of the material of the patch on the middle node, (7) [N].
   pure function internal_force(patch, p, materials) result(force)
      type(patch_t), intent(in) :: patch
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      real(dp) :: force(ndim)
      integer :: k
      force = 0
      do k = 1, patch%n
         associate (i => patch%particle(k))
            force = force - p%volume(i)*matmul(materials(p%material(i))%mapped_stress(p%gradient_of(i), p%total_frame, &
                                                                                      p%history_of(i), p%hoop_of(i)), &
                                               patch%gradient(:, k))
            if (p%thickness%is_ring) &
               force(1) = force(1) - p%volume(i)*patch%shape(1, k)*hoop_resistance(materials(p%material(i)), p, i)
         end associate
      end do
   end function internal_force

   !> Mass of the patch at the middle node, (9) [kg].
   pure real(dp) function patch_mass(patch, p)
      type(patch_t), intent(in) :: patch
      type(particles_t), intent(in) :: p
      patch_mass = sum(p%mass(patch%particle(:patch%n))*patch%shape(1, :patch%n))
   end function patch_mass

   !> Displacement of the middle node from the mass-weighted least squares fit of the shape functions to the particles of the patch
   !> [m]. Where the particles move with the grid's own field it returns the nodal value itself, not a smoothed one. The normal
   !> equations are solved by conjugate gradients from the lumped values on: components that few particles do not determine keep
   !> their lumped values.
   pure function fitted_displacement(patch, p) result(u)
      type(patch_t), intent(in) :: patch
      type(particles_t), intent(in) :: p
      real(dp) :: u(ndim)
      real(dp) :: matrix(patch%n_nodes, patch%n_nodes), rhs(patch%n_nodes, ndim)
      integer :: k, b, d
      matrix = 0
      rhs = 0
      do k = 1, patch%n
         associate (shape => patch%shape(:patch%n_nodes, k), i => patch%particle(k))
            do b = 1, patch%n_nodes
               if (abs(shape(b)) > 0) matrix(:, b) = matrix(:, b) + (p%mass(i)*shape(b))*shape
            end do
            do d = 1, ndim
               rhs(:, d) = rhs(:, d) + (p%mass(i)*p%displacement(i, d))*shape
            end do
         end associate
      end do
      do d = 1, ndim
         u(d) = first_unknown(matrix, sum(matrix, dim=2), rhs(:, d))
      end do
   end function fitted_displacement

   !> First unknown of a small positive semi-definite system by conjugate gradients, preconditioned by the row sums. They end well
   !> above rounding: its residual in directions of the null space, over no curvature, would be a long step.
   pure real(dp) function first_unknown(matrix, row_sum, rhs) result(first)
      real(dp), intent(in), contiguous :: matrix(:, :), row_sum(:), rhs(:)
      real(dp), dimension(size(rhs)) :: x, r, z, direction, image
      real(dp), parameter :: solved = 1e-13_dp   ! residual, over the right side
      real(dp), parameter :: unseen = 1e-10_dp   ! curvature along such a direction, over the row sums' curvature
      real(dp) :: rz, rz_new, curvature, target
      integer :: k
      first = 0
      if (.not. all(row_sum > 0)) return
      x = rhs/row_sum
      r = rhs - matmul(matrix, x)
      z = r/row_sum
      direction = z
      rz = dot_product(r, z)
      target = solved**2*sum(rhs**2/row_sum)
      do k = 1, 4*size(rhs)
         if (rz <= target) exit
         image = matmul(matrix, direction)
         curvature = dot_product(direction, image)
         if (curvature <= unseen*sum(row_sum*direction**2)) exit
         x = x + rz/curvature*direction
         r = r - rz/curvature*image
         z = r/row_sum
         rz_new = dot_product(r, z)
         direction = z + rz_new/rz*direction
         rz = rz_new
      end do
      first = x(1)
   end function first_unknown
end module hampm_patch
