!> The step of a scene in which nodes need no more than the cells around them, tile by tile (`hampm_pipeline`): masses are
!> lumped, no point depends on others, and no faces touch.
module hampm_tiled_step
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_response, only: cell_response_t, add_up, respond
   use hampm_material, only: material_t
   use hampm_nodal_fields, only: nodal_fields_t, at_start, new, mapped, mass_share, momentum_share, force_share, around, stride
   use hampm_particles, only: particles_t
   use hampm_pipeline, only: pipeline_t
   use hampm_schemes, only: scheme_t
   implicit none
   private
   public :: step_in_tiles

   integer, parameter :: items_at_a_time = 64    !! that a thread does, of those of no region

   !> What a stage of the nodes finds.
   type :: task_t
      logical :: mass = .false.
      logical :: velocity = .false.
      logical :: acceleration = .false.
      integer :: which = at_start                !! of the velocities
   end type task_t

contains

   !> Do the nodal sums and the sweeps of a step.
   subroutine step_in_tiles(plan, scheme, dt, damping_rate, materials, free, new_masses, p, f, response, damping_power)
      type(pipeline_t), intent(in) :: plan
      type(scheme_t), intent(in) :: scheme
      real(dp), intent(in) :: dt                        !! [s]
      real(dp), intent(in) :: damping_rate              !! alpha of the force -alpha m v [1/s]
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: free(:, :)                !! 0 for components of nodes that are held, else 1; (ndim, n_points)
      logical, intent(in) :: new_masses                 !! whether nodal masses have changed since the last step
      type(particles_t), intent(inout) :: p
      type(nodal_fields_t), intent(inout) :: f          !! whose `force` holds that of the loads
      type(cell_response_t), intent(inout) :: response
      real(dp), intent(out) :: damping_power            !! sum alpha m v_i . (v_i + a_i dt) [W]
      real(dp) :: power(plan%n_tiles)
      integer :: region, tile
      power = 0
      damping_power = 0
      call do_across(0)
      !$omp parallel do schedule(static, 1) private(tile)
      do region = 1, plan%n_regions
         do tile = plan%first_tile(region), plan%first_tile(region + 1) - 1
            call do_tile(tile)
         end do
      end do
      damping_power = damping_power + sum(power)
      call do_across(plan%n_tiles + 1)
   contains
      !> Do what is ready in a tile, stage by stage.
      subroutine do_tile(t)
         integer, intent(in) :: t
         integer :: s
         do s = 1, size(plan%stages)
            associate (first => plan%stages(s)%start(t), last => plan%stages(s)%start(t + 1) - 1)
               call do_items(s, first, last, power(t))
            end associate
         end do
      end subroutine do_tile

      !> Do what belongs to no region, stage by stage, each by all threads.
      subroutine do_across(t)
         integer, intent(in) :: t
         real(dp), allocatable :: part(:)
         integer :: s, k
         do s = 1, size(plan%stages)
            associate (first => plan%stages(s)%start(t), last => plan%stages(s)%start(t + 1) - 1)
               if (last < first) cycle
               allocate (part((last - first)/items_at_a_time + 1), source=0.0_dp)
               !$omp parallel do schedule(static)
               do k = 1, size(part)
                  call do_items(s, first + items_at_a_time*(k - 1), min(first + items_at_a_time*k - 1, last), part(k))
               end do
               damping_power = damping_power + sum(part)
               deallocate (part)
            end associate
         end do
      end subroutine do_across

      !> Do some items of a stage, and add to the damping power.
      subroutine do_items(s, first, last, power)
         integer, intent(in) :: s, first, last
         real(dp), intent(inout) :: power
         associate (items => plan%stages(s)%item)
            if (mod(s, 2) == 0) then
               call respond(response, scheme%sweeps(s/2), dt, materials, p, f, items(first:last))
            else
               call do_nodes(task_of_stage(scheme, s, new_masses), dt, damping_rate, items(first:last), free, f, power)
               if (response%is_active) call add_up(scheme%sweeps((s + 1)/2), dt, items(first:last), f, response)
            end if
         end associate
      end subroutine do_items
   end subroutine step_in_tiles

   !> What the nodes find before the first sweep, or between two.
   pure type(task_t) function task_of_stage(scheme, stage, new_masses) result(task)
      type(scheme_t), intent(in) :: scheme
      integer, intent(in) :: stage
      logical, intent(in) :: new_masses
      if (stage == 1) then
         task = task_t(new_masses, .true., scheme%map_at_start%map_force, at_start)
      else
         associate (sweep => scheme%sweeps(stage/2))
            task = task_t(.false., sweep%map_momentum, sweep%map_force, mapped)
         end associate
      end if
   end function task_of_stage

   !> Do a stage of some nodes, and add to the damping power.
   subroutine do_nodes(task, dt, damping_rate, nodes, free, f, power)
      type(task_t), intent(in) :: task
      real(dp), intent(in) :: dt, damping_rate
      integer, intent(in) :: nodes(:)
      real(dp), intent(in) :: free(:, :)
      type(nodal_fields_t), intent(inout) :: f
      real(dp), intent(inout) :: power
      associate (n => size(nodes), mass => f%mass_matrix%lumped, inverse => f%mass_matrix%inverse_lumped)
         if (task%mass) call find_masses(n, nodes, f%slot, f%share(1, 1, mass_share, 0), mass, inverse)
         if (task%velocity) &
            call find_velocities(n, nodes, f%slot, f%share(1, 1, momentum_share, 0), free, inverse, f%velocity(1, 1, task%which))
         if (.not. task%acceleration) return
         call find_accelerations(n, nodes, f%slot, f%share(1, 1, force_share, 0), dt, damping_rate, free, inverse, f%external, &
                                 f%velocity(1, 1, at_start), f%acceleration, f%velocity(1, 1, new))
         if (damping_rate > 0) &
            call add_damping_power(n, nodes, damping_rate, mass, f%velocity(1, 1, at_start), f%velocity(1, 1, new), power)
      end associate
   end subroutine do_nodes

   !> Masses (9) of some nodes, from the shares of the cells.
   pure subroutine find_masses(n, nodes, slot, share, mass, inverse)
      integer, intent(in) :: n, nodes(n), slot(corners, *)
      real(dp), intent(in) :: share(*)
      real(dp), intent(inout) :: mass(*), inverse(*)    !! by point
      integer :: j
      !GCC$ novector
      do j = 1, n
         associate (i => nodes(j))
            mass(i) = around(share, slot(1, i), slot(2, i), slot(3, i), slot(4, i))
            inverse(i) = 1/mass(i)
         end associate
      end do
   end subroutine find_masses

   !> Velocities (8) of some nodes, from the shares of the cells in the momenta.
   pure subroutine find_velocities(n, nodes, slot, share, free, inverse, velocity)
      integer, intent(in) :: n, nodes(n), slot(corners, *)
      real(dp), intent(in) :: share(*), free(ndim, *), inverse(*)
      real(dp), intent(inout) :: velocity(ndim, *)      !! by point
      integer :: j, i, k1, k2, k3, k4
      !GCC$ novector
      do j = 1, n
         i = nodes(j)
         k1 = slot(1, i)
         k2 = slot(2, i)
         k3 = slot(3, i)
         k4 = slot(4, i)
         velocity(1, i) = (inverse(i)*free(1, i))*around(share, k1, k2, k3, k4)
         velocity(2, i) = (inverse(i)*free(2, i))*around(share(1 + stride), k1, k2, k3, k4)
      end do
   end subroutine find_velocities

   !> Accelerations (5) of some nodes, from the shares of the cells in the forces, and the velocities v + a dt.
   pure subroutine find_accelerations(n, nodes, slot, share, dt, damping_rate, free, inverse, external, velocity, acceleration, new)
      integer, intent(in) :: n, nodes(n), slot(corners, *)
      real(dp), intent(in) :: share(*), dt, damping_rate, free(ndim, *), inverse(*), external(ndim, *), velocity(ndim, *)
      real(dp), intent(inout) :: acceleration(ndim, *), new(ndim, *) !! by point
      integer :: j, i, k1, k2, k3, k4
      !GCC$ novector
      do j = 1, n
         i = nodes(j)
         k1 = slot(1, i)
         k2 = slot(2, i)
         k3 = slot(3, i)
         k4 = slot(4, i)
         acceleration(1, i) = (inverse(i)*free(1, i))*(around(share, k1, k2, k3, k4) + external(1, i)) &
                              - damping_rate*velocity(1, i)
         acceleration(2, i) = (inverse(i)*free(2, i))*(around(share(1 + stride), k1, k2, k3, k4) + external(2, i)) &
                              - damping_rate*velocity(2, i)
         new(1, i) = velocity(1, i) + dt*acceleration(1, i)
         new(2, i) = velocity(2, i) + dt*acceleration(2, i)
      end do
   end subroutine find_accelerations

   !> Add the power of the damping at some nodes.
   pure subroutine add_damping_power(n, nodes, damping_rate, mass, velocity, new, power)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: damping_rate, mass(*), velocity(ndim, *), new(ndim, *)
      real(dp), intent(inout) :: power
      integer :: j
      do j = 1, n
         associate (i => nodes(j))
            power = power + damping_rate*mass(i)*sum(velocity(:, i)*new(:, i))
         end associate
      end do
   end subroutine add_damping_power
end module hampm_tiled_step
