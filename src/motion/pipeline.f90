!> The order in which the parts of a step are done so that they find their data in the cache.
!>
!> A step is a sequence of stages, by turns of nodes and of blocks (`hampm_sweep`): a node needs the blocks around it to have done
!> the stage before, a block its nodes. Done one stage after the other, each moves all data through the memory. Instead
!> `blocks_per_tile` blocks are done at a time, and then at once, stage by stage, whatever is ready. In the order of the grid
!> most of that lies in the same or in the last tiles. The order of the parts changes no number.
!>
!> A thread does regions: some tiles in succession. Nodes of the first stage that several regions need are done before, and what
!> needs several regions, after all these. Regions do not depend on the number of threads, so that sums by tile do not.
module hampm_pipeline
   use hampm_kinds, only: corners
   use hampm_nodal_fields, only: nodal_fields_t
   implicit none
   private
   public :: pipeline_t, plan_pipeline

   integer, parameter :: blocks_per_tile = 128   !! whose particles fit into the second cache

   !> Items of one stage in the order in which they are done: those from start(t) to start(t + 1) - 1 in tile t.
   type :: stage_t
      integer, allocatable :: start(:), item(:)
   end type stage_t

   !> The tiles and regions of a grid, and what is done in each of them at each stage.
   type :: pipeline_t
      integer :: n_tiles = 0
      integer :: n_regions = 0
      integer, allocatable :: first_tile(:)      !! of each region, (n_regions + 1)
      type(stage_t), allocatable :: stages(:)    !! nodes, blocks, nodes and so on; tile 0 comes first, n_tiles + 1 last
      integer, private :: layout = 0             !! that of the blocks for which it was made
      logical, private :: is_lasting = .false.   !! whether for more than one step
   contains
      procedure :: fits
      procedure :: times_planned
   end type pipeline_t

contains

   !> Whether it was made for the present blocks, and need not be made better.
   pure logical function fits(self, f)
      class(pipeline_t), intent(in) :: self
      type(nodal_fields_t), intent(in) :: f
      fits = self%layout == f%layout .and. self%is_lasting
   end function fits

   !> How often steps have been planned for the present blocks: 0, 1, or 2 where that need not be made better. The order of sums
   !> depends on it.
   pure integer function times_planned(self, f)
      class(pipeline_t), intent(in) :: self
      type(nodal_fields_t), intent(in) :: f
      times_planned = 0
      if (self%layout == f%layout) times_planned = merge(2, 1, self%is_lasting)
   end function times_planned

   !> Plan steps of `n_sweeps` sweeps, each after a stage of the nodes, for the present blocks. A plan takes longer than it saves in
   !> one step: for blocks that are seen for the first time, and may change with the next step, all is one tile.
   subroutine plan_pipeline(f, n_sweeps, plan)
      type(nodal_fields_t), intent(in) :: f
      integer, intent(in) :: n_sweeps
      type(pipeline_t), intent(inout) :: plan
      integer, allocatable :: nodes(:), blocks(:), tile_of_block(:)
      integer :: b, r, s
      plan%is_lasting = plan%layout == f%layout .or. f%n_blocks <= blocks_per_tile
      plan%layout = f%layout
      if (allocated(plan%stages)) deallocate (plan%stages)
      if (.not. plan%is_lasting) then
         call plan_whole(f, n_sweeps, plan)
         return
      end if
      plan%n_tiles = (f%n_blocks - 1)/blocks_per_tile + 1
      plan%n_regions = max(1, 2*nint(sqrt(real(plan%n_tiles))/4))
      plan%first_tile = [((r - 1)*plan%n_tiles/plan%n_regions + 1, r=1, plan%n_regions + 1)]
      tile_of_block = [((b - 1)/blocks_per_tile + 1, b=1, f%n_blocks)]
      allocate (plan%stages(2*n_sweeps), nodes(size(f%slot, 2)))
      call nodes_first(plan, f, tile_of_block, nodes)
      blocks = tile_of_block
      do s = 1, n_sweeps
         if (s > 1) then
            call nodes_after_blocks(plan, f, blocks, nodes)
            blocks = tile_of_block
            call blocks_after_nodes(plan, f, nodes, blocks)
         end if
         call sort_items(plan, nodes, plan%stages(2*s - 1))
         call sort_items(plan, blocks, plan%stages(2*s))
      end do
   end subroutine plan_pipeline

   !> Plan steps in one tile.
   subroutine plan_whole(f, n_sweeps, plan)
      type(nodal_fields_t), intent(in) :: f
      integer, intent(in) :: n_sweeps
      type(pipeline_t), intent(inout) :: plan
      integer :: b, s
      plan%n_tiles = 1
      plan%n_regions = 1
      plan%first_tile = [1, 2]
      allocate (plan%stages(2*n_sweeps))
      associate (all => f%mass_matrix%all)
         do s = 1, n_sweeps
            plan%stages(2*s - 1)%item = all%nodes(:all%n_nodes)
            plan%stages(2*s)%item = [(b, b=1, f%n_blocks)]
         end do
      end associate
      do s = 1, size(plan%stages)
         allocate (plan%stages(s)%start(0:3), source=1)
         plan%stages(s)%start(2:) = size(plan%stages(s)%item) + 1
      end do
   end subroutine plan_whole

   !> When nodes are done in the first stage: with the first tile that needs them, before all where several regions do. -1 for
   !> nodes without blocks.
   subroutine nodes_first(plan, f, tile_of_block, tile)
      type(pipeline_t), intent(in) :: plan
      type(nodal_fields_t), intent(in) :: f
      integer, intent(in) :: tile_of_block(:)
      integer, intent(out) :: tile(:)
      integer :: b, k
      tile = -1
      do b = 1, f%n_blocks
         associate (around => nodes_of(f, b))
            do k = 1, size(around)
               associate (t => tile(around(k)))
                  if (t == -1) then
                     t = tile_of_block(b)
                  else if (t > 0) then
                     if (region_of(plan, t) /= region_of(plan, tile_of_block(b))) t = 0
                  end if
               end associate
            end do
         end associate
      end do
   end subroutine nodes_first

   !> When nodes can be done after their blocks.
   subroutine nodes_after_blocks(plan, f, blocks, nodes)
      type(pipeline_t), intent(in) :: plan
      type(nodal_fields_t), intent(in) :: f
      integer, intent(in) :: blocks(:)
      integer, intent(out) :: nodes(:)
      integer :: b, k
      nodes = -1
      do b = 1, f%n_blocks
         associate (around => nodes_of(f, b))
            do k = 1, size(around)
               nodes(around(k)) = after_both(plan, nodes(around(k)), blocks(b))
            end do
         end associate
      end do
   end subroutine nodes_after_blocks

   !> When blocks, which were ready before, can be done after their nodes.
   subroutine blocks_after_nodes(plan, f, nodes, blocks)
      type(pipeline_t), intent(in) :: plan
      type(nodal_fields_t), intent(in) :: f
      integer, intent(in) :: nodes(:)
      integer, intent(inout) :: blocks(:)
      integer :: b, k
      do b = 1, f%n_blocks
         associate (around => nodes_of(f, b))
            do k = 1, size(around)
               blocks(b) = after_both(plan, blocks(b), nodes(around(k)))
            end do
         end associate
      end do
   end subroutine blocks_after_nodes

   !> The nodes around the cells of a block, each once for each cell.
   pure function nodes_of(f, block) result(nodes)
      type(nodal_fields_t), intent(in) :: f
      integer, intent(in) :: block
      integer :: nodes(corners*count(f%block_cells(:, block) > 0))
      nodes = reshape(f%block_nodes(:, :count(f%block_cells(:, block) > 0), block), [size(nodes)])
   end function nodes_of

   !> The tile in which something can be done after what is done in the tiles a and b; a may be -1, nothing.
   pure integer function after_both(plan, a, b) result(tile)
      type(pipeline_t), intent(in) :: plan
      integer, intent(in) :: a, b
      tile = max(a, b)
      if (a == -1 .or. tile > plan%n_tiles) return
      if (region_of(plan, a) /= region_of(plan, b)) tile = plan%n_tiles + 1
   end function after_both

   !> The region of a tile.
   pure integer function region_of(plan, tile)
      type(pipeline_t), intent(in) :: plan
      integer, intent(in) :: tile
      region_of = count(plan%first_tile <= tile)
   end function region_of

   !> Sort items by tile, those of -1 left out.
   subroutine sort_items(plan, tile, stage)
      type(pipeline_t), intent(in) :: plan
      integer, intent(in) :: tile(:)
      type(stage_t), intent(out) :: stage
      integer, allocatable :: next(:)
      integer :: i, t
      allocate (next(0:plan%n_tiles + 1), source=0)
      do i = 1, size(tile)
         if (tile(i) >= 0) next(tile(i)) = next(tile(i)) + 1
      end do
      allocate (stage%start(0:plan%n_tiles + 2), stage%item(sum(next)))
      stage%start(0) = 1
      do t = 0, plan%n_tiles + 1
         stage%start(t + 1) = stage%start(t) + next(t)
      end do
      next = stage%start(:plan%n_tiles + 1)
      do i = 1, size(tile)
         if (tile(i) < 0) cycle
         stage%item(next(tile(i))) = i
         next(tile(i)) = next(tile(i)) + 1
      end do
   end subroutine sort_items
end module hampm_pipeline
