!> The passes over the particles (`hampm_particle_pass`) with domains (`hampm_domains`): nodes and particles exchange values by the
!> corners of the domains, each of which is in some element. The force on a corner is -V P G_c, with the first Piola stress P.
!>
!> A pass does what its `pass_t` asks for in the order
!>
!>   1. G2P     kick:   v_c <- v_c + a dt;
!>   2.         strain: u_c <- u_c + v dt: the corners move with the straining velocity, as they give the strain;
!>   3. P2G     map:    mass and momentum, mass matrix, internal force to the elements, once `locate_corners` has found these.
!>
!> Sums are taken in the order of the particles: the result has the same bytes on any number of threads.
module hampm_domain_pass
   use hampm_kinds, only: dp, ndim, corners
   use hampm_audit_kernels, only: work_of_change
   use hampm_basis, only: shape_functions, inside_cell
   use hampm_domains, only: corner_gradients, reference_corners, follow_corners
   use hampm_dofs, only: list_slots, element_of_slot, corner_of_slot
   use hampm_failure, only: failure_t, exit_computation
   use hampm_forest, only: outside
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: prepare_cell, floor_of_domains
   use hampm_matter, only: matter_t
   use hampm_state_update, only: update_particle_state
   use hampm_nodal_fields, only: nodal_fields_t, list_active_nodes, finish_sums
   use hampm_particle_pass, only: pass_report_t
   use hampm_particles, only: particles_t
   use hampm_pass, only: pass_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: corner_map_t, locate_corners, find_corners, move_corners, map_corners, assemble_corners

   !> Part of the distance to the particle by which the place of a corner is moved inwards: a corner on the side of an element
   !> belongs to the element of the material. Of the size of the rounding of positions.
   real(dp), parameter :: inwards = 1e-9_dp
   !> The same in the reference configuration where a line of a crack tells to which side a corner belongs
   real(dp), parameter :: to_its_side = 0.01_dp
   !> Part of an element so near to its sides that rounding could take a corner to another one
   real(dp), parameter :: near_side = 1e-11_dp

   !> Places of the corners of the domains in the grid, and their contributions to its elements.
   type :: corner_map_t
      integer, allocatable :: element(:, :)             !! in which each corner stands, (corners, n)
      real(dp), allocatable :: local(:, :, :)           !! where in it, 0 to 1, (ndim, corners, n)
      integer :: n_cells = 0
      integer, allocatable :: cells(:)                  !! elements with corners, ascending, (n_elements)
      integer, allocatable :: number(:)                 !! of each element in `cells`, 0 for the others, (n_elements)
      integer, allocatable :: first(:)                  !! first entry of each element in the next, (n_elements + 1)
      integer, allocatable :: slot(:)                   !! corner + corners (particle - 1), by element and ascending, (corners n)
      integer :: layout = -1                            !! of the mass matrix when `cells` were listed
      real(dp), allocatable :: mass(:, :)               !! contributions to the corners of the elements [kg], (corners, n_cells)
      real(dp), allocatable :: momentum(:, :, :)        !! [kg m/s], (ndim, corners, n_cells)
      real(dp), allocatable :: force(:, :, :)           !! [N], as `momentum`
   end type corner_map_t

contains

   !> Find the elements in which the corners stand, and the nodes of these. Fails where a corner has left the grid.
   subroutine locate_corners(map, m, f, failure)
      type(corner_map_t), intent(inout) :: map
      type(matter_t), intent(in) :: m
      type(nodal_fields_t), intent(inout) :: f
      type(failure_t), intent(inout) :: failure
      integer :: i, lost
      if (allocated(map%element)) then
         if (size(map%element, 2) /= m%particles%n) deallocate (map%element, map%local)
      end if
      if (.not. allocated(map%element)) then
         allocate (map%element(corners, m%particles%n), source=outside)
         allocate (map%local(ndim, corners, m%particles%n))
      end if
      lost = 0
      !$omp parallel do schedule(static) reduction(max: lost)
      do i = 1, m%particles%n
         call find_corners(m%particles, m%grid, i, map%element(:, i), map%local(:, :, i))
         if (any(map%element(:, i) == outside)) lost = max(lost, i)
      end do
      if (lost > 0) then
         call failure%report(exit_computation, 'a corner of the domain of particle '//to_text(m%particles%id(lost))// &
            ', which started at ('//to_text(m%particles%reference(lost, 1))//', '//to_text(m%particles%reference(lost, 2))// &
            ') m, left the grid or is no longer a number. Likely cause: the body moves beyond the grid: give &grid more cells '// &
            'or add a &constraint; or the run is unstable: reduce &method courant')
         return
      end if
      call list_corners(map, m%grid, f, failure)
   end subroutine locate_corners

   !> The elements in which the corners of a domain stand, `outside` for none, and where in them.
   pure subroutine find_corners(p, grid, i, element, local)
      type(particles_t), intent(in) :: p
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: i                   !! particle
      integer, intent(inout) :: element(corners) !! before: in which they may be; else `outside`
      real(dp), intent(out) :: local(ndim, corners) !! 0 to 1
      real(dp) :: origin(ndim, corners), x(ndim), beside(ndim), middle(ndim), xi(ndim)
      logical :: by_place
      integer :: c
      by_place = grid%n_velocity_fields == 1 .and. .not. grid%cut_cells%are_there()
      origin = reference_corners(p, i)
      middle = p%position(i)
      do c = 1, corners
         x = origin(:, c) + p%corner_displacement(i, :, c)
         beside = x + inwards*(middle - x)
         if (by_place .and. element(c) /= outside) then
            xi = grid%local_coordinate(element(c), beside)
            if (any(xi < near_side .or. xi > 1 - near_side)) element(c) = grid%element_at(beside)
         else if (grid%cut_cells%are_there()) then
            element(c) = grid%element_on_side(beside, origin(:, c) + to_its_side*(p%reference(i, :) - origin(:, c)), p%body(i))
         else
            element(c) = grid%element_at(beside, body=p%body(i))
         end if
         local(:, c) = 0
         if (element(c) == outside) cycle
         xi = grid%local_coordinate(element(c), x)
         local(:, c) = inside_cell(xi)
         if (any(abs(xi - 0.5_dp) > 0.5_dp + 2*inwards)) local(:, c) = xi  ! extrapolated in a sliver beside the element
      end do
   end subroutine find_corners

   !> List the corners by element, and the nodes of the elements where these are no longer the same.
   subroutine list_corners(map, grid, f, failure)
      type(corner_map_t), intent(inout) :: map
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(inout) :: f
      type(failure_t), intent(inout) :: failure
      integer :: e, k, status
      logical :: is_new
      call list_slots(grid%n_elements, map%element, map%first, map%slot, status)
      if (status /= 0) call failure%report(exit_computation, 'domains: not enough memory for their corners')
      if (failure%failed()) return
      associate (has_corners => map%first(2:) > map%first(:grid%n_elements))
         is_new = map%layout /= f%mass_matrix%layout .or. .not. allocated(map%number)
         if (.not. is_new) is_new = size(map%number) /= grid%n_elements
         if (.not. is_new) is_new = any(has_corners .neqv. (map%number > 0))
         if (.not. is_new) return
         map%cells = pack([(e, e=1, grid%n_elements)], has_corners)
         map%number = unpack([(k, k=1, size(map%cells))], has_corners, 0)
      end associate
      map%n_cells = size(map%cells)
      if (allocated(map%mass)) deallocate (map%mass, map%momentum, map%force)
      allocate (map%mass(corners, map%n_cells))
      allocate (map%momentum(ndim, corners, map%n_cells), map%force(ndim, corners, map%n_cells))
      call list_active_nodes(grid, map%cells, f)
      map%layout = f%mass_matrix%layout
   end subroutine list_corners

   !> Do the part of a pass in which the nodes act on the particles. `report` tells whether any has then left its cell.
   subroutine move_corners(pass, dt, m, map, f, report)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      type(matter_t), intent(inout) :: m
      type(corner_map_t), intent(in) :: map
      type(nodal_fields_t), intent(in) :: f
      type(pass_report_t), intent(out) :: report
      real(dp), allocatable :: kicked(:), strained(:)
      real(dp) :: n(corners), change(ndim), before(ndim, ndim), at(ndim)
      logical :: left, jumped
      integer :: i, c
      left = .false.
      jumped = .false.
      if (.not. (pass%kick .or. pass%strain_fraction > 0)) return
      allocate (kicked(m%particles%n), strained(m%particles%n))
      !$omp parallel do schedule(static) private(c, n, change, before, at) reduction(.or.: left, jumped)
      do i = 1, m%particles%n
         kicked(i) = 0
         before = m%particles%gradient(i, :, :)
         do c = 1, corners
            associate (nodes => m%grid%element_nodes(:, map%element(c, i)))
               n = shape_functions(map%local(:, c, i))
               if (pass%kick) then
                  change = dt*matmul(f%acceleration(:, nodes), n)
                  m%particles%corner_velocity(i, :, c) = m%particles%corner_velocity(i, :, c) + change
                  kicked(i) = kicked(i) + 0.5_dp*m%particles%mass(i)/corners*sum(change**2)
               end if
               if (pass%strain_fraction > 0) &
                  m%particles%corner_displacement(i, :, c) = m%particles%corner_displacement(i, :, &
                     c) + pass%strain_fraction*dt*matmul(f%velocity(:, nodes, pass%strain_by), n)
            end associate
         end do
         call follow_corners(m%particles, i)
         strained(i) = 0
         if (pass%audit .and. pass%strain_fraction > 0) &
            strained(i) = m%particles%volume(i)*work_of_change(m%materials(m%particles%material(i)), before, &
                                                               m%particles%gradient_of(i) - before, pass%strain_fraction*dt, &
                                                               m%particles, i)
         if (pass%strain_fraction > 0) call update_particle_state(m%materials(m%particles%material(i)), pass%strain_fraction*dt, &
                                                                  m%particles, i)
         at = m%grid%local_coordinate(m%particles%cell(i), m%particles%position(i))
         left = left .or. .not. all(at >= 0 .and. at < 1)
         jumped = jumped .or. .not. all(at >= -1 .and. at < 2)
      end do
      report%left_cell = left
      report%jumped = jumped
      if (.not. pass%audit) return
      report%velocity_change_energy = sum(kicked)
      report%stress_work = sum(strained)
   end subroutine move_corners

   !> Do the part of a pass in which the particles act on the elements in which `locate_corners` has found their corners.
   subroutine map_corners(pass, m, map, f)
      type(pass_t), intent(in) :: pass
      type(matter_t), intent(in) :: m
      type(corner_map_t), intent(inout) :: map
      type(nodal_fields_t), intent(inout) :: f
      real(dp), allocatable :: pull(:, :, :)     ! force on the corners of each domain [N], (ndim, corners, n)
      real(dp) :: n(corners), mass
      integer :: i, c, j, k, a
      if (pass%map_force) then
         allocate (pull(ndim, corners, m%particles%n))
         !$omp parallel do schedule(static)
         do i = 1, m%particles%n
            associate (material => m%materials(m%particles%material(i)))
               pull(:, :, i) = -m%particles%volume(i)*matmul(material%first_piola_stress(m%particles%gradient_of(i), &
                                                                                         m%particles%history_of(i)), &
                                                             corner_gradients(m%particles, i))
            end associate
         end do
      end if
      !$omp parallel do schedule(static) private(j, i, c, a, n, mass)
      do k = 1, map%n_cells
         if (pass%map_mass) map%mass(:, k) = 0
         if (pass%map_momentum) map%momentum(:, :, k) = 0
         if (pass%map_force) map%force(:, :, k) = 0
         if (pass%map_matrix) f%mass_matrix%cell(:, :, map%cells(k)) = 0
         do j = map%first(map%cells(k)), map%first(map%cells(k) + 1) - 1
            i = element_of_slot(map%slot(j))
            c = corner_of_slot(map%slot(j))
            n = shape_functions(map%local(:, c, i))
            mass = m%particles%mass(i)/corners
            if (pass%map_mass) map%mass(:, k) = map%mass(:, k) + mass*n
            do a = 1, corners
               if (pass%map_momentum) map%momentum(:, a, k) = map%momentum(:, a, k) + mass*n(a)*m%particles%corner_velocity(i, :, c)
               if (pass%map_force) map%force(:, a, k) = map%force(:, a, k) + n(a)*pull(:, c, i)
               if (pass%map_matrix) f%mass_matrix%cell(:, a, map%cells(k)) = f%mass_matrix%cell(:, a, map%cells(k)) + mass*n(a)*n
            end do
         end do
         if (.not. pass%map_matrix) cycle
         associate (matrix => f%mass_matrix, e => map%cells(k))
            matrix%cell_lumped(:, e) = sum(matrix%cell(:, :, e), dim=2)
            call prepare_cell(corners, matrix%lumped_fraction(e), matrix%is_solved, matrix%may_hang(e), matrix%cell(1, 1, e), &
                              floor_of_domains)
         end associate
      end do
      if (pass%map_matrix) f%mass_matrix%assembled = .false.
   end subroutine map_corners

   !> Nodal sums from sums of the elements, as in `assemble`.
   subroutine assemble_corners(map, grid, f, mass, momentum, force)
      type(corner_map_t), intent(in) :: map
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(inout) :: f
      logical, intent(in) :: mass, momentum, force
      integer :: a, j, k, c
      associate (matrix => f%mass_matrix, all => f%mass_matrix%all, dofs => grid%dofs)
         !$omp parallel do schedule(static) private(j, k, c)
         do a = 1, all%n_points
            associate (node => all%nodes(a))
               if (mass) matrix%lumped(node) = 0
               if (momentum) f%momentum(:, node) = 0
               if (force) f%force(:, node) = 0
               do j = dofs%first_slot(node), dofs%first_slot(node + 1) - 1
                  k = map%number(element_of_slot(dofs%slot(j)))
                  if (k == 0) cycle
                  c = corner_of_slot(dofs%slot(j))
                  if (mass) matrix%lumped(node) = matrix%lumped(node) + map%mass(c, k)
                  if (momentum) f%momentum(:, node) = f%momentum(:, node) + map%momentum(:, c, k)
                  if (force) f%force(:, node) = f%force(:, node) + map%force(:, c, k)
               end do
            end associate
         end do
      end associate
      call finish_sums(grid, f, mass, momentum)
   end subroutine assemble_corners
end module hampm_domain_pass
