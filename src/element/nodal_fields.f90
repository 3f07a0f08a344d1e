!> Fields of the grid during one step: one value a node, and the contributions of the cells, from which the nodal sums are
!> assembled.
module hampm_nodal_fields
   use hampm_kinds, only: dp, ndim, corners
   use hampm_archive, only: archive_t
   use hampm_cell_blocks, only: cell_blocks_t, place_blocks, lanes, of_mass, of_momentum, of_force, n_sums
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_large_pages, only: prefer_large_pages
   use hampm_mass_matrix, only: mass_matrix_t, find_coupled_region, clear_empty_cells, invert_lumped, assemble_rows => assemble, &
                                nodes_per_chunk
   use hampm_nodal_kernels, only: assemble_sums, exchange_high_valence
   use hampm_node_list, only: list_marked
   implicit none
   private
   public :: nodal_fields_t, new_nodal_fields, find_active_nodes, list_active_nodes, assemble_at, exchange, finish_sums, &
             v_n, v_next, v_mapped, archive_fields

   ! The velocities of a node during a step
   integer, parameter :: v_n = 1                 !! v^n, mapped from the particles at the start of the step, (10)
   integer, parameter :: v_next = 2              !! v^(n+1) = v^n + a dt, which moves the particles
   integer, parameter :: v_mapped = 3            !! v^(n+1) as it is mapped anew from the velocities of the particles

   !> Arrays by node include the hanging nodes (`hampm_dofs`): values are distributed to them, and their sums condensed.
   type :: nodal_fields_t
      type(mass_matrix_t) :: mass_matrix                !! M and D of the nodes of occupied cells
      real(dp), allocatable :: momentum(:, :)           !! right-hand side of (8) [kg m/s], (ndim, n_points)
      real(dp), allocatable :: force(:, :)              !! (7), internal and of the loads, without damping [N], (ndim, n_points)
      real(dp), allocatable :: external(:, :)           !! force of the loads at t^n, already condensed [N], (ndim, n_points)
      real(dp), allocatable :: acceleration(:, :)       !! a_i, (10) [m/s2], (ndim, n_points)
      real(dp), allocatable :: velocity(:, :, :)        !! `v_n`, `v_next` and `v_mapped` [m/s], (ndim, n_points, 3)
      real(dp), allocatable :: earlier(:, :, :)         !! last two accelerations without damping, where they are guessed;
                                                        !! (ndim, n_points, 2)
      ! By blocks of cells (`hampm_cell_blocks`)
      integer :: layout = 0                             !! of the blocks that the following fits
      real(dp), allocatable :: contribution(:, :, :, :) !! of cells to the sums at their corners: of mass [kg], momentum
                                                        !! [kg m/s] and internal force [N]; of block 0 zero;
                                                        !! (lanes, corners, n_sums, 0:blocks)
      integer :: maps = 0                               !! how often all particles have been mapped
      logical, allocatable :: left(:)                   !! whether a particle has left its cell in the last pass, (blocks)
      real(dp), allocatable :: audit(:, :)              !! sums of the last pass for the energy balance [J], (2, blocks)
      logical, allocatable :: is_active(:)              !! whether each is one of elements with material, (n_points)
      real(dp), allocatable :: partial_power(:, :)      !! workspace of sums over nodes, (2, number of chunks of nodes)
   end type nodal_fields_t

contains

   !> Nodal fields of a grid, all zero. Fails where the memory does not suffice.
   subroutine new_nodal_fields(grid, f, failure)
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(out) :: f
      type(failure_t), intent(inout) :: failure
      integer :: status
      associate (n => grid%n_points, m => grid%n_elements)
         allocate (f%is_active(n), f%mass_matrix%lumped(n), f%mass_matrix%inverse_lumped(n), &
                   f%mass_matrix%all%nodes(n), f%mass_matrix%all%cells(m), f%momentum(ndim, n), &
                   f%force(ndim, n), f%external(ndim, n), f%acceleration(ndim, n), f%velocity(ndim, n, 3), &
                   f%partial_power(2, n/nodes_per_chunk + 1), stat=status)
      end associate
      if (status /= 0) then
         call failure%report(exit_computation, 'grid: not enough memory for its nodes')
         return
      end if
      f%mass_matrix%lumped = 0
      f%mass_matrix%inverse_lumped = 0
      f%momentum = 0
      f%force = 0
      f%external = 0
      f%acceleration = 0
      f%velocity = 0
   end subroutine new_nodal_fields

   !> After a sort, if it has changed the cells of the blocks: place these in the grid, list the nodes of occupied cells, and clear
   !> the values of cells and nodes without particles. Fails where the memory does not suffice.
   subroutine find_active_nodes(grid, blocks, f, failure)
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(inout) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      type(failure_t), intent(inout) :: failure
      if (f%layout == blocks%layout) return
      call place_blocks(blocks, grid, failure)
      if (.not. failure%failed()) call resize_to_blocks(blocks%n, f, failure)
      if (failure%failed()) return
      f%layout = blocks%layout
      call list_active_nodes(grid, blocks%occupied(:blocks%n_occupied), f)
   end subroutine find_active_nodes

   !> List the nodes of elements with material, and clear the values of other elements and nodes.
   subroutine list_active_nodes(grid, occupied, f)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: occupied(:)         !! elements, ascending
      type(nodal_fields_t), intent(inout) :: f
      integer :: node, k
      call clear_empty_cells(grid%n_elements, occupied, f%mass_matrix)
      f%is_active = .false.
      do k = 1, size(occupied)
         f%is_active(grid%element_nodes(:, occupied(k))) = .true.
      end do
      call grid%dofs%mark_masters(f%is_active)
      associate (matrix => f%mass_matrix)
         matrix%all%n_cells = size(occupied)
         matrix%all%cells(:size(occupied)) = occupied
         call list_marked(grid%n_nodes, f%is_active, matrix%all)
         do node = 1, grid%n_points
            if (f%is_active(node)) cycle
            matrix%lumped(node) = 0
            f%velocity(:, node, :) = 0
            f%acceleration(:, node) = 0
            f%momentum(:, node) = 0
            f%force(:, node) = 0
            if (allocated(f%earlier)) f%earlier(:, node, :) = 0
         end do
         call find_coupled_region(grid, matrix)
      end associate
   end subroutine list_active_nodes

   !> Room for the contributions of a number of blocks.
   subroutine resize_to_blocks(n_blocks, f, failure)
      integer, intent(in) :: n_blocks
      type(nodal_fields_t), intent(inout) :: f
      type(failure_t), intent(inout) :: failure
      integer :: n, status
      if (allocated(f%left)) then
         if (size(f%left) >= n_blocks) return
         deallocate (f%contribution, f%left, f%audit)
      end if
      n = n_blocks + n_blocks/8
      allocate (f%contribution(lanes, corners, n_sums, 0:n), f%left(n), f%audit(2, n), stat=status)
      if (status /= 0) then
         call failure%report(exit_computation, 'grid: not enough memory for its cells')
         return
      end if
      call prefer_large_pages(size(f%contribution), f%contribution)
      f%contribution = 0
      f%left = .false.
      f%audit = 0
   end subroutine resize_to_blocks

   !> Sum the contributions of the cells around some points. High-valence nodes have all of theirs in their slots meanwhile: sums
   !> have the order, and the last bits, of `hampm_tiling`.
   subroutine assemble_at(points, blocks, f, mass, momentum, force)
      integer, intent(in) :: points(:)
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      logical, intent(in) :: mass, momentum, force
      real(dp) :: before(n_sums, size(blocks%high_valence, 2)) ! last slots of high-valence nodes
      if (allocated(blocks%is_high_valence)) call exchange([mass, momentum, force], points, .false., blocks, f, before)
      call assemble_sums(size(points), points, blocks%slot, f%contribution, mass, momentum, force, f%mass_matrix%lumped, &
                         f%momentum, f%force)
      if (allocated(blocks%is_high_valence)) call exchange([mass, momentum, force], points, .true., blocks, f, before)
   end subroutine assemble_at

   !> Let the high-valence ones of some nodes have all of their contributions to some sums in their slots or, `back`, as these were.
   subroutine exchange(sums, nodes, back, blocks, f, before)
      logical, intent(in) :: sums(3)             !! of mass, momentum and force
      integer, intent(in) :: nodes(:)
      logical, intent(in) :: back
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      real(dp), intent(inout) :: before(:, :)    !! (sums, cells), see `exchange_high_valence`
      integer, parameter :: first(*) = [of_mass, of_momentum, of_force], last(*) = first + [0, ndim - 1, ndim - 1]
      integer :: k
      do k = 1, size(sums)
         if (sums(k)) call exchange_high_valence(blocks%high_valence, blocks%slot, blocks%is_high_valence, nodes, back, &
                                                 f%contribution(1, 1, first(k), 0), before(first(k):last(k), :))
      end do
   end subroutine exchange

   !> Distribute sums at hanging nodes to their masters, and find the fields that follow from the masses.
   subroutine finish_sums(grid, f, mass, momentum)
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(inout) :: f
      logical, intent(in) :: mass, momentum
      associate (matrix => f%mass_matrix, all => f%mass_matrix%all)
         if (mass) call grid%dofs%condense(all, 1, matrix%lumped)
         if (momentum) call grid%dofs%condense(all, ndim, f%momentum)
         if (mass) call invert_lumped(matrix, grid%is_quadratic())
         if (mass) call assemble_rows(grid, matrix)
      end associate
   end subroutine finish_sums

   !> Archive the nodal values of the last step that the next one needs, and the contributions of the cells.
   subroutine archive_fields(f, grid, n_blocks, mapped, archive)
      type(nodal_fields_t), intent(inout) :: f
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: n_blocks            !! blocks of cells
      logical, intent(inout) :: mapped           !! whether the cells hold the contributions for the next step
      class(archive_t), intent(inout) :: archive
      logical :: has_earlier
      call archive%section('fields')
      call archive%archive_reals('velocity', size(f%velocity), f%velocity)
      call archive%archive_reals('acceleration', size(f%acceleration), f%acceleration)
      has_earlier = allocated(f%earlier)
      call archive%serialise('have_past', has_earlier)
      if (has_earlier .and. .not. allocated(f%earlier)) allocate (f%earlier(ndim, size(f%acceleration, 2), 2))
      if (has_earlier) call archive%archive_reals('past', size(f%earlier), f%earlier)
      associate (matrix => f%mass_matrix)
         if (allocated(matrix%lumped_fraction)) then
            call archive%archive_reals('lumped_fraction', size(matrix%lumped_fraction), matrix%lumped_fraction)
            if (allocated(matrix%lumped_apart)) &
               call archive%archive_reals('lumped_apart', size(matrix%lumped_apart), matrix%lumped_apart)
            if (archive%is_read) call find_coupled_region(grid, matrix)
         end if
      end associate
      call archive%serialise('are_mapped', mapped)
      if (.not. mapped) return
      call archive%archive_reals('contribution', size(f%contribution(:, :, :, 1))*n_blocks, f%contribution(1, 1, 1, 1))
      associate (matrix => f%mass_matrix)
         if (.not. allocated(matrix%cell)) return
         call archive%archive_reals('matrix', size(matrix%cell), matrix%cell)
         call archive%archive_reals('lumped_matrix', size(matrix%cell_lumped), matrix%cell_lumped)
      end associate
   end subroutine archive_fields
end module hampm_nodal_fields
