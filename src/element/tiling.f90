!> The order in which the parts of a step are done so that they find their data in the cache.
!>
!> A step is a sequence of stages, by turns of nodes and of blocks (`hampm_particle_pass`): a node needs the blocks around it to
!> have done the stage before, a block its nodes. Stage by stage, each would move all data through the memory. Instead
!> `blocks_per_tile` blocks are done at a time, and then at once, stage by stage, all that is ready. In the order of the grid most
!> of it is in the same or the last tiles. The order of the parts changes no number.
!>
!> A thread does regions: some tiles in succession. Nodes of the first stage that several regions need are done before, and items
!> that need several regions, after all these. Regions do not depend on the number of threads, so that sums by tile do not.
!>
!> This is for models in which nodes need only the cells around them: lumped masses, no hanging nodes, no faces in contact. Some
!> nodes may wait: their accelerations are there after the first part of a step, and all that needs these comes in the second.
module hampm_tiling
   use hampm_kinds, only: corners, dp, ndim
   use hampm_cell_blocks, only: cell_blocks_t, n_sums, of_mass, of_momentum, of_force
   use hampm_dofs, only: list_slots
   use hampm_element_operators, only: element_operators_t, keeps_sums, add_up, add_up_from, apply_to_runs
   use hampm_mass_matrix, only: nodes_per_chunk
   use hampm_matter, only: matter_t
   use hampm_nodal_fields, only: nodal_fields_t, exchange, v_n, v_next, v_mapped
   use hampm_nodal_kernels, only: find_masses, find_velocities, find_accelerations, find_kept_velocities, find_kept_accelerations, &
                                  damping_product
   use hampm_particle_pass, only: pass_over_blocks
   use hampm_pass, only: scheme_t
   use hampm_stencils, only: run_t, find_next
   implicit none
   private
   public :: tiling_t, plan_tiles, is_planned, step_in_tiles

   integer, parameter :: items_at_a_time = 64    !! that a thread does, of items of no region
   integer, parameter :: runs_at_a_time = 8      !! the same of runs
   integer, parameter :: blocks_per_tile = merge(128, 32, ndim == 2) !! whose particles fit into the second cache

   !> Items of one stage in the order in which they are done: those from start(t) to start(t + 1) - 1 in tile t.
   type :: stage_t
      integer, allocatable :: start(:), item(:)
      integer, allocatable :: first_run(:)       !! the same of the runs
      type(run_t), allocatable :: runs(:)        !! points with stencils, where there are element operators
   end type stage_t

   !> The tiles and regions of a grid, and the items of each of them at each stage.
   type :: tiling_t
      integer :: n_tiles = 0
      integer :: n_regions = 0
      integer, allocatable :: first_tile(:)      !! of each region, (n_regions + 1)
      integer, allocatable, private :: region(:) !! of each tile, (0:n_tiles + 1)
      type(stage_t), allocatable :: stages(:)    !! nodes, blocks, nodes and so on, last the nodes with stencils; tile 0
                                                 !! comes first, n_tiles + 1 last
      integer, private :: layout = 0             !! of the blocks for which it was made
      logical, private :: is_lasting = .false.   !! whether for more than one step
      logical, allocatable, private :: waits(:)  !! which nodes do, (n_points); not allocated where none does
   end type tiling_t

contains

   !> Plan steps of `n_passes` passes, each after a stage of the nodes, for the present blocks, if not done. A plan costs more than
   !> it saves in one step: new blocks, which may change with the next step, are one tile.
   subroutine plan_tiles(blocks, active, n_passes, operators, plan, waits)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: active(:)           !! the nodes of occupied cells
      integer, intent(in) :: n_passes
      type(element_operators_t), intent(in) :: operators
      type(tiling_t), intent(inout) :: plan
      logical, intent(in), optional :: waits(:)  !! nodes that do, (n_points): then it is planned for more than one step
      if (is_planned(plan, blocks)) return
      plan%is_lasting = plan%layout == blocks%layout .or. blocks%n <= blocks_per_tile .or. present(waits)
      plan%layout = blocks%layout
      if (present(waits)) plan%waits = waits
      if (allocated(plan%stages)) deallocate (plan%stages)
      if (allocated(plan%region)) deallocate (plan%region)
      allocate (plan%stages(2*n_passes + 1))
      if (plan%is_lasting) then
         call plan_in_tiles(blocks, n_passes, operators, plan)
      else
         call plan_whole(blocks, active, operators, plan)
      end if
   end subroutine plan_tiles

   !> Whether a plan is for the present blocks, and for more than one step.
   pure logical function is_planned(plan, blocks)
      type(tiling_t), intent(in) :: plan
      type(cell_blocks_t), intent(in) :: blocks
      is_planned = plan%layout == blocks%layout .and. plan%is_lasting
   end function is_planned

   !> Plan steps in one tile.
   subroutine plan_whole(blocks, active, operators, plan)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: active(:)
      type(element_operators_t), intent(in) :: operators
      type(tiling_t), intent(inout) :: plan
      integer :: b, s
      plan%n_tiles = 1
      plan%n_regions = 1
      plan%first_tile = [1, 2]
      do s = 1, size(plan%stages)
         associate (stage => plan%stages(s))
            allocate (stage%start(0:3), stage%first_run(0:3), source=1)
            allocate (stage%runs(0))
            if (operators%is_active) then
               if (mod(s, 2) == 1) stage%runs = operators%runs
               stage%item = operators%gather
               if (mod(s, 2) == 0) stage%item = operators%without
            else
               stage%item = active
               if (mod(s, 2) == 0) stage%item = [(b, b=1, blocks%n)]
            end if
            stage%start(2:) = size(stage%item) + 1
            stage%first_run(2:) = size(stage%runs) + 1
         end associate
      end do
   end subroutine plan_whole

   !> Plan steps in tiles. The nodes between two regions, which wait for both, are about a row of the grid, in space a plane: the
   !> root of all, or the cubic root squared. With the number of regions growing as that root of the number of tiles, the waiting
   !> part of the work is constant. The number is even: two threads have equal shares.
   subroutine plan_in_tiles(blocks, n_passes, operators, plan)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: n_passes
      type(element_operators_t), intent(in) :: operators
      type(tiling_t), intent(inout) :: plan
      integer, allocatable :: node_tile(:), block_tile(:), first_tile(:)
      integer :: b, r, s
      plan%n_tiles = (blocks%n - 1)/blocks_per_tile + 1
      plan%n_regions = max(1, 2*nint(real(plan%n_tiles)**(1.0/ndim)/4))
      plan%first_tile = [((r - 1)*plan%n_tiles/plan%n_regions + 1, r=1, plan%n_regions + 1)]
      allocate (plan%region(0:plan%n_tiles + 1), source=[(count(plan%first_tile <= b), b=0, plan%n_tiles + 1)])
      first_tile = [((b - 1)/blocks_per_tile + 1, b=1, blocks%n)]
      allocate (node_tile(blocks%n_points))
      block_tile = first_tile
      do s = 1, n_passes + 1
         call place_nodes(plan, blocks, block_tile, s == 1, node_tile)
         if (operators%is_active) call place_runs(plan, operators%runs, s == 1, node_tile)
         call sort_nodes(plan, operators, node_tile, plan%stages(2*s - 1))
         if (s > n_passes) exit
         block_tile = first_tile
         if (s > 1) call place_blocks(plan, blocks, node_tile, block_tile)
         associate (stage => plan%stages(2*s))
            if (operators%is_active) then
               call sort_items(plan, merge(-1, block_tile, operators%material > 0), stage%start, stage%item)
            else
               call sort_items(plan, block_tile, stage%start, stage%item)
            end if
            allocate (stage%first_run(0:plan%n_tiles + 2), source=1)
         end associate
      end do
   end subroutine plan_in_tiles

   !> When runs are done, as a whole: in the first stage with the first of their nodes, later with the last.
   pure subroutine place_runs(plan, runs, is_first, node_tile)
      type(tiling_t), intent(in) :: plan
      type(run_t), intent(in) :: runs(:)
      logical, intent(in) :: is_first
      integer, intent(inout) :: node_tile(:)
      integer :: r
      do r = 1, size(runs)
         associate (tiles => node_tile(runs(r)%first:runs(r)%first + runs(r)%n - 1))
            if (any(plan%region(tiles) /= plan%region(tiles(1)))) then
               tiles = merge(0, plan%n_tiles + 1, is_first)
            else
               tiles = merge(minval(tiles), maxval(tiles), is_first)
            end if
         end associate
      end do
   end subroutine place_runs

   !> Order of nodes: in the first stage with the first tile that needs them, before all if several regions do, in others as soon as
   !> their blocks are done. -1 for nodes without blocks.
   subroutine place_nodes(plan, blocks, block_tile, is_first, node_tile)
      type(tiling_t), intent(in) :: plan
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: block_tile(:)
      logical, intent(in) :: is_first
      integer, intent(out) :: node_tile(:)
      integer, allocatable :: around(:)
      integer :: b, k
      node_tile = -1
      do b = 1, blocks%n
         around = nodes_of(blocks, b)
         associate (of_block => block_tile(b))
            do k = 1, size(around)
               associate (t => node_tile(around(k)))
                  if (t == -1) then
                     t = of_block
                     if (allocated(plan%waits)) then
                        if (plan%waits(around(k))) t = merge(0, plan%n_tiles + 1, is_first)
                     end if
                  else if (plan%region(t) /= plan%region(of_block)) then
                     t = merge(0, plan%n_tiles + 1, is_first)
                  else if (.not. is_first) then
                     t = max(t, of_block)
                  end if
               end associate
            end do
         end associate
      end do
   end subroutine place_nodes

   !> When blocks, which were ready before, can be done after their nodes.
   subroutine place_blocks(plan, blocks, node_tile, block_tile)
      type(tiling_t), intent(in) :: plan
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: node_tile(:)
      integer, intent(inout) :: block_tile(:)
      integer, allocatable :: around(:)
      integer :: b, k
      do b = 1, blocks%n
         around = nodes_of(blocks, b)
         do k = 1, size(around)
            associate (t => block_tile(b), after => node_tile(around(k)))
               t = merge(max(t, after), plan%n_tiles + 1, plan%region(t) == plan%region(after))
            end associate
         end do
      end do
   end subroutine place_blocks

   !> The nodes around the cells of a block, each once for each cell.
   pure function nodes_of(blocks, block) result(nodes)
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: block
      integer :: nodes(corners*count(blocks%cells(:, block) > 0))
      nodes = reshape(blocks%nodes(:, :count(blocks%cells(:, block) > 0), block), [size(nodes)])
   end function nodes_of

   !> Sort nodes by tile: those that keep their sums by runs, and the others.
   subroutine sort_nodes(plan, operators, node_tile, stage)
      type(tiling_t), intent(in) :: plan
      type(element_operators_t), intent(in) :: operators
      integer, intent(in) :: node_tile(:)
      type(stage_t), intent(inout) :: stage
      integer, allocatable :: order(:)
      integer :: node
      if (operators%is_active) then
         call sort_items(plan, node_tile(operators%runs%first), stage%first_run, order)
         stage%runs = operators%runs(order)
         call sort_items(plan, [(merge(-1, node_tile(node), keeps_sums(operators, node)), node=1, size(node_tile))], stage%start, &
                         stage%item)
      else
         call sort_items(plan, node_tile, stage%start, stage%item)
         allocate (stage%first_run(0:plan%n_tiles + 2), source=1)
      end if
   end subroutine sort_nodes

   !> Sort items by tile; items of tile -1 come last.
   subroutine sort_items(plan, tile, start, item)
      type(tiling_t), intent(in) :: plan
      integer, intent(in) :: tile(:)
      integer, allocatable, intent(out) :: start(:), item(:)
      integer, allocatable :: first(:)
      integer :: status
      associate (n => plan%n_tiles + 3)
         call list_slots(n, reshape(merge(tile + 1, n, tile >= 0), [1, size(tile)]), first, item, status)
         allocate (start(0:n - 1), source=first(:n))
      end associate
   end subroutine sort_items

   !> Do the nodal sums and the passes of a step, or of its parts before and after the accelerations of waiting nodes. Items before
   !> all regions are in the first tile, those after them in the last; in one of these is the stage between the parts.
   subroutine step_in_tiles(plan, scheme, dt, damping_rate, m, free, new_masses, f, operators, damping_loss, part)
      type(tiling_t), intent(in) :: plan
      type(scheme_t), intent(in) :: scheme
      real(dp), intent(in) :: dt                        !! [s]
      real(dp), intent(in) :: damping_rate              !! alpha of the force -alpha m v [1/s]
      type(matter_t), intent(inout) :: m
      real(dp), intent(in) :: free(:, :)                !! 0 for fixed components of nodes, else 1; (ndim, n_points)
      logical, intent(in) :: new_masses                 !! whether nodal masses have changed since the last step
      type(nodal_fields_t), intent(inout) :: f
      type(element_operators_t), intent(inout) :: operators
      real(dp), intent(out) :: damping_loss             !! dissipation of the damping, dt sum alpha m v^n . v^(n+1) [J]
      integer, intent(in) :: part                       !! 1 or 2; 0: both
      integer :: last                                   ! stage with accelerations
      logical :: is_waiting                             ! whether items that need these are in the other part
      integer :: phase, between, region, tile, s
      damping_loss = 0
      last = 1
      if (.not. scheme%map_at_start%map_force) last = 2*findloc(scheme%passes%map_force, .true., dim=1) + 1
      between = merge(1, 3, last == 1)
      do phase = 1, 3
         if (part == 1 .and. phase > between .or. part == 2 .and. phase < between) cycle
         is_waiting = part == 1 .and. phase == between
         if (phase == 2) then
            !$omp parallel do schedule(static, 1) private(tile, s)
            do region = 1, plan%n_regions
               do tile = plan%first_tile(region), plan%first_tile(region + 1) - 1
                  do s = 1, size(plan%stages)
                     associate (stage => plan%stages(s))
                        call do_runs(s, stage%first_run(tile), stage%first_run(tile + 1) - 1)
                        call do_items(s, stage%start(tile), stage%start(tile + 1) - 1)
                     end associate
                  end do
               end do
            end do
         else
            tile = merge(0, plan%n_tiles + 1, phase == 1)
            s = 1
            if (part == 2 .and. phase == between) then
               associate (stage => plan%stages(last))
                  call add_up_runs(last, stage%first_run(tile), stage%first_run(tile + 1) - 1)
                  call add_up_items(last, stage%start(tile), stage%start(tile + 1) - 1)
               end associate
               s = last + 1
            end if
            call do_across(tile, s, merge(last, size(plan%stages), is_waiting))
         end if
      end do
      if (part /= 1 .and. damping_rate > 0) damping_loss = dt*damping_rate*sum_of_damping(f)
   contains
      !> Do the items of no region, stage by stage, each by all threads.
      subroutine do_across(t, from, to)
         integer, intent(in) :: t
         integer, intent(in) :: from, to         !! stages
         integer :: s, k
         do s = from, to
            associate (first => plan%stages(s)%first_run(t), last_run => plan%stages(s)%first_run(t + 1) - 1)
               if (last_run >= first) then
                  !$omp parallel do schedule(static)
                  do k = first, last_run, runs_at_a_time
                     call do_runs(s, k, min(k + runs_at_a_time - 1, last_run))
                  end do
               end if
            end associate
            associate (first => plan%stages(s)%start(t), last_item => plan%stages(s)%start(t + 1) - 1)
               if (last_item < first) cycle
               !$omp parallel do schedule(static)
               do k = first, last_item, items_at_a_time
                  call do_items(s, k, min(k + items_at_a_time - 1, last_item))
               end do
            end associate
         end do
      end subroutine do_across

      !> Do some items of a stage.
      subroutine do_items(s, first, last_item)
         integer, intent(in) :: s, first, last_item
         if (last_item < first .or. s == size(plan%stages)) return
         associate (items => plan%stages(s)%item)
            if (mod(s, 2) == 0) then
               associate (pass => scheme%passes(s/2))
                  call pass_over_blocks(pass, dt, m, f, items(first:last_item), f%acceleration, f%velocity(1, 1, v_next), &
                                        f%velocity(1, 1, pass%strain_by))
               end associate
            else
               call do_nodes(s == 1 .and. new_masses, finds_velocity(s), merge(v_n, v_mapped, s == 1), finds_acceleration(s), dt, &
                             damping_rate, items(first:last_item), free, m%blocks, f)
               if (.not. (is_waiting .and. s == last)) call add_up_items(s, first, last_item)
            end if
         end associate
      end subroutine do_items

      !> Do some runs of a stage: the pass before it, and the equations of points that keep their sums.
      subroutine do_runs(s, first, last_run)
         integer, intent(in) :: s, first, last_run
         integer :: r, i, n
         if (last_run < first) return
         associate (runs => plan%stages(s)%runs(first:last_run))
            if (s > 1) call apply_to_runs(operators, runs, scheme%passes(s/2), dt, f)
            if (s == size(plan%stages)) return
            r = 1
            do while (r <= size(runs))
               call find_next(runs, r, i, n)
               if (n == 0) exit
               if (finds_velocity(s)) call find_kept_velocities(ndim*n, operators%mobility(1, i), operators%momentum(1, i), &
                                                                f%velocity(1, i, merge(v_n, v_mapped, s == 1)))
               if (finds_acceleration(s)) &
                  call find_kept_accelerations(ndim*n, dt, damping_rate, operators%mobility(1, i), operators%force(1, i), &
                                               f%external(1, i), f%velocity(1, i, v_n), f%acceleration(1, i), &
                                               f%velocity(1, i, v_next))
            end do
            if (.not. (is_waiting .and. s == last)) call add_up_runs(s, first, last_run)
         end associate
      end subroutine do_runs

      !> Whether nodes find their velocities at a stage.
      pure logical function finds_velocity(s)
         integer, intent(in) :: s
         finds_velocity = s == 1 .or. scheme%passes(max(1, s/2))%map_momentum
      end function finds_velocity

      !> Whether nodes find their accelerations at a stage.
      pure logical function finds_acceleration(s)
         integer, intent(in) :: s
         finds_acceleration = merge(scheme%map_at_start%map_force, scheme%passes(max(1, s/2))%map_force, s == 1)
      end function finds_acceleration

      !> Add up the nodal increments of a stage for the operators.
      subroutine add_up_items(s, first, last_item)
         integer, intent(in) :: s, first, last_item
         if (operators%is_active) call add_up(scheme%passes((s + 1)/2), dt, plan%stages(s)%item(first:last_item), f, operators)
      end subroutine add_up_items

      !> The same of points that keep their sums.
      subroutine add_up_runs(s, first, last_run)
         integer, intent(in) :: s, first, last_run
         integer :: r, i, n
         associate (runs => plan%stages(s)%runs(first:last_run))
            r = 1
            do while (r <= size(runs))
               call find_next(runs, r, i, n)
               if (n > 0) call add_up_from(scheme%passes((s + 1)/2), dt, i, n, f, operators)
            end do
         end associate
      end subroutine add_up_runs
   end subroutine step_in_tiles

   !> Find, of some nodes, masses, which of the velocities, accelerations.
   subroutine do_nodes(mass, velocity, which, acceleration, dt, damping_rate, nodes, free, blocks, f)
      logical, intent(in) :: mass, velocity, acceleration
      integer, intent(in) :: which, nodes(:)
      real(dp), intent(in) :: dt, damping_rate
      real(dp), intent(in) :: free(:, :)
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      real(dp) :: before(n_sums, size(blocks%high_valence, 2)) ! last slots of high-valence nodes
      if (allocated(blocks%is_high_valence)) call exchange([mass, velocity, acceleration], nodes, .false., blocks, f, before)
      associate (n => size(nodes), inverse => f%mass_matrix%inverse_lumped)
         if (mass) call find_masses(n, nodes, blocks%slot, f%contribution(1, 1, of_mass, 0), f%mass_matrix%lumped, inverse)
         if (velocity) call find_velocities(n, nodes, blocks%slot, f%contribution(1, 1, of_momentum, 0), free, inverse, &
                                            f%velocity(1, 1, which))
         if (acceleration) &
            call find_accelerations(n, nodes, blocks%slot, f%contribution(1, 1, of_force, 0), dt, damping_rate, free, inverse, &
                                    f%external, f%velocity(1, 1, v_n), f%acceleration, f%velocity(1, 1, v_next))
      end associate
      if (allocated(blocks%is_high_valence)) call exchange([mass, velocity, acceleration], nodes, .true., blocks, f, before)
   end subroutine do_nodes

   !> Sum of m v^n . v^(n+1) over the nodes [J], always in the same order.
   real(dp) function sum_of_damping(f) result(total)
      type(nodal_fields_t), intent(inout) :: f
      integer :: k, first
      associate (all => f%mass_matrix%all)
         !$omp parallel do schedule(static) private(first)
         do k = 1, (all%n_nodes - 1)/nodes_per_chunk + 1
            first = (k - 1)*nodes_per_chunk + 1
            f%partial_power(1, k) = damping_product(min(nodes_per_chunk, all%n_nodes - first + 1), all%nodes(first), &
                                                    f%mass_matrix%lumped, f%velocity(1, 1, v_n), f%velocity(1, 1, v_next))
         end do
         total = sum(f%partial_power(1, :(all%n_nodes - 1)/nodes_per_chunk + 1))
      end associate
   end function sum_of_damping
end module hampm_tiling
