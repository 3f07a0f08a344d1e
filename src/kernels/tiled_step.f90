!> The step of a scene in which nodes need no more than the cells around them, tile by tile (`hampm_tiling`): masses are
!> lumped, no node hangs, and no faces touch.
module hampm_tiled_step
   use hampm_kinds, only: dp, ndim
   use hampm_cell_blocks, only: cell_blocks_t, n_sums, of_mass, of_momentum, of_force
   use hampm_element_operators, only: element_operators_t, add_up, pass_or_apply
   use hampm_material, only: material_t
   use hampm_mass_matrix, only: nodes_per_chunk
   use hampm_nodal_fields, only: nodal_fields_t, v_n, v_next, v_mapped
   use hampm_nodal_kernels, only: find_masses, find_velocities, find_accelerations, damping_product, exchange_crowded
   use hampm_particles, only: particles_t
   use hampm_pass, only: scheme_t
   use hampm_tiling, only: tiling_t
   implicit none
   private
   public :: step_in_tiles

   integer, parameter :: items_at_a_time = 64    !! that a thread does, of those of no region

   !> What a stage of the nodes finds.
   type :: task_t
      logical :: mass = .false.
      logical :: velocity = .false.
      logical :: acceleration = .false.
      integer :: which = v_n                !! of the velocities
   end type task_t

contains

   !> Do the nodal sums and the passes of a step.
   subroutine step_in_tiles(plan, scheme, dt, damping_rate, materials, free, new_masses, p, blocks, f, operators, damping_loss)
      type(tiling_t), intent(in) :: plan
      type(scheme_t), intent(in) :: scheme
      real(dp), intent(in) :: dt                        !! [s]
      real(dp), intent(in) :: damping_rate              !! alpha of the force -alpha m v [1/s]
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: free(:, :)                !! 0 for fixed components of nodes, else 1; (ndim, n_points)
      logical, intent(in) :: new_masses                 !! whether nodal masses have changed since the last step
      type(particles_t), intent(inout) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      type(element_operators_t), intent(inout) :: operators
      real(dp), intent(out) :: damping_loss             !! what the damping takes, dt sum alpha m v^n . v^(n+1) [J]
      integer :: region, tile
      call do_across(0)
      !$omp parallel do schedule(static, 1) private(tile)
      do region = 1, plan%n_regions
         do tile = plan%first_tile(region), plan%first_tile(region + 1) - 1
            call do_tile(tile)
         end do
      end do
      call do_across(plan%n_tiles + 1)
      damping_loss = 0
      if (damping_rate > 0) damping_loss = dt*damping_rate*sum_of_damping(f)
   contains
      !> Do what is ready in a tile, stage by stage.
      subroutine do_tile(t)
         integer, intent(in) :: t
         integer :: s
         do s = 1, size(plan%stages)
            call do_items(s, plan%stages(s)%start(t), plan%stages(s)%start(t + 1) - 1)
         end do
      end subroutine do_tile

      !> Do what belongs to no region, stage by stage, each by all threads.
      subroutine do_across(t)
         integer, intent(in) :: t
         integer :: s, k
         do s = 1, size(plan%stages)
            associate (first => plan%stages(s)%start(t), last => plan%stages(s)%start(t + 1) - 1)
               if (last < first) cycle
               !$omp parallel do schedule(static)
               do k = first, last, items_at_a_time
                  call do_items(s, k, min(k + items_at_a_time - 1, last))
               end do
            end associate
         end do
      end subroutine do_across

      !> Do some items of a stage.
      subroutine do_items(s, first, last)
         integer, intent(in) :: s, first, last
         associate (items => plan%stages(s)%item)
            if (mod(s, 2) == 0) then
               call pass_or_apply(operators, scheme%passes(s/2), dt, materials, p, blocks, f, items(first:last))
            else
               call do_nodes(task_of_stage(scheme, s, new_masses), dt, damping_rate, items(first:last), free, blocks, f)
               if (operators%is_active) call add_up(scheme%passes((s + 1)/2), dt, items(first:last), f, operators)
            end if
         end associate
      end subroutine do_items
   end subroutine step_in_tiles

   !> What the nodes find before the first pass, or between two.
   pure type(task_t) function task_of_stage(scheme, stage, new_masses) result(task)
      type(scheme_t), intent(in) :: scheme
      integer, intent(in) :: stage
      logical, intent(in) :: new_masses
      if (stage == 1) then
         task = task_t(new_masses, .true., scheme%map_at_start%map_force, v_n)
      else
         associate (pass => scheme%passes(stage/2))
            task = task_t(.false., pass%map_momentum, pass%map_force, v_mapped)
         end associate
      end if
   end function task_of_stage

   !> Do a stage of some nodes.
   subroutine do_nodes(task, dt, damping_rate, nodes, free, blocks, f)
      type(task_t), intent(in) :: task
      real(dp), intent(in) :: dt, damping_rate
      integer, intent(in) :: nodes(:)
      real(dp), intent(in) :: free(:, :)
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      real(dp) :: before(n_sums, size(blocks%crowded, 2)) ! what crowded nodes have in their last slot
      call exchange(back=.false.)
      associate (n => size(nodes), inverse => f%mass_matrix%inverse_lumped)
         if (task%mass) call find_masses(n, nodes, blocks%slot, f%contribution(1, 1, of_mass, 0), f%mass_matrix%lumped, inverse)
         if (task%velocity) call find_velocities(n, nodes, blocks%slot, f%contribution(1, 1, of_momentum, 0), free, inverse, &
                                                 f%velocity(1, 1, task%which))
         if (task%acceleration) &
            call find_accelerations(n, nodes, blocks%slot, f%contribution(1, 1, of_force, 0), dt, damping_rate, free, inverse, &
                                    f%external, f%velocity(1, 1, v_n), f%acceleration, f%velocity(1, 1, v_next))
      end associate
      call exchange(back=.true.)
   contains
      !> Let crowded nodes have all of their contributions in their slots or, `back`, as these were.
      subroutine exchange(back)
         logical, intent(in) :: back
         if (.not. allocated(blocks%is_crowded)) return
         if (task%mass) call exchange_sums(of_mass, of_mass, back)
         if (task%velocity) call exchange_sums(of_momentum, of_momentum + ndim - 1, back)
         if (task%acceleration) call exchange_sums(of_force, of_force + ndim - 1, back)
      end subroutine exchange

      !> The same of some sums.
      subroutine exchange_sums(first, last, back)
         integer, intent(in) :: first, last
         logical, intent(in) :: back
         call exchange_crowded(blocks%crowded, blocks%slot, blocks%is_crowded, nodes, back, f%contribution(1, 1, first, 0), &
                               before(first:last, :))
      end subroutine exchange_sums
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
end module hampm_tiled_step
