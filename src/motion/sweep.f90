!> The one loop over the particles. A sweep visits each occupied cell, and in it each particle, once. It does what its
!> `sweep_t` asks for, always in this order:
!>
!>   1. kick:   v <- v + a dt;
!>   2. strain: H <- H + dt L (I + H), L = grad of a nodal velocity;
!>   3. map:    mass and momentum, internal force to the grid, from the new v and H: the sums over the particles of the
!>              cell are kept beside the cell, to be gathered by node;
!>   4. move:   u <- u + (v_i + a_i dt) dt, and look whether the particle has left its cell;
!>   5. map as in 3, now from the new positions, for the next step. It is void if any particle has left its cell.
!>
!> In the total frame the shape functions are always those at the reference positions, H <- H + dt L, and no particle leaves
!> its cell.
!>
!> The schemes USF, USL, USAVG and MUSL are short lists of such sweeps (`hampm_schemes`). Cells do not share what they
!> write: the result has the same bytes on any number of threads.
module hampm_sweep
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions, interpolate, interpolate_gradient, add_shares, add_divergence, inside_cell
   use hampm_grid, only: grid_t
   use hampm_linear_elastic, only: linear_stress
   use hampm_mass_matrix, only: prepare_cell
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   use hampm_nodal_fields, only: nodal_fields_t, at_start, new
   use hampm_tensors, only: product_of
   implicit none
   private
   public :: sweep_t, sweep_report_t, sweep_particles

   integer, parameter :: cells_per_block = 128   !! what a thread does at a time
   integer, parameter :: batch = 64              !! particles of a cell that are done together

   type :: sweep_t
      logical :: kick = .false.                  !! v <- v + a dt
      real(dp) :: strain_fraction = 0            !! part of the step over which to strain, 0: not at all
      integer :: strain_by = at_start            !! which nodal velocity strains the particles
      logical :: map_motion = .false.            !! mass and momentum to the grid, before moving
      logical :: map_matrix = .false.            !! mass matrix to the cells, before moving
      logical :: map_force = .false.             !! internal force to the grid, before moving
      logical :: move = .false.                  !! u <- u + (v_i + a_i dt) dt
      logical :: map_moved_motion = .false.      !! mass and momentum to the grid, after moving
      logical :: map_moved_matrix = .false.      !! mass matrix to the cells, after moving
      logical :: map_moved_force = .false.       !! internal force to the grid, after moving
   end type sweep_t

   !> What a sweep noticed and, for the energy audit, summed.
   type :: sweep_report_t
      logical :: left_cell = .false.             !! some particle has left its cell
      logical :: jumped = .false.                !! some particle moved past the next cell or is no longer a number
      real(dp) :: velocity_change_energy = 0     !! sum of m |dv|**2 / 2 [J]
      real(dp) :: stress_work = 0                !! sum of V times the integral of P : dH by Simpson's rule [J]
   end type sweep_report_t

contains

   !> Do one sweep. `audit` asks for the two sums of the report.
   subroutine sweep_particles(sweep, dt, grid, materials, p, f, audit, report)
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt                        !! time step [s]
      type(grid_t), intent(in) :: grid
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(nodal_fields_t), intent(inout) :: f
      logical, intent(in) :: audit
      type(sweep_report_t), intent(out) :: report
      logical :: left_cell, jumped
      integer :: block, first, last
      left_cell = .false.
      jumped = .false.
      !$omp parallel do schedule(static) private(first, last) reduction(.or.: left_cell, jumped)
      do block = 1, (p%n_occupied - 1)/cells_per_block + 1
         first = (block - 1)*cells_per_block + 1
         last = min(block*cells_per_block, p%n_occupied)
         call sweep_cells(sweep, dt, audit, materials, last - first + 1, p%occupied(first), &
                          grid%element_lower, grid%element_size, grid%element_nodes, p%first_in, p%last_in, p%stride_in, &
                          p%n, p%mass, p%volume, p%reference, p%displacement, p%velocity, p%gradient, p%material, &
                          f%acceleration, f%velocity(1, 1, new), f%velocity(1, 1, sweep%strain_by), &
                          f%cell_mass(1), f%cell_momentum(1, 1), f%cell_force(1, 1), f%cell_audit, p%total_frame, &
                          left_cell, jumped, f%mass_matrix%is_solved, f%mass_matrix%cell, f%mass_matrix%blend, &
                          f%mass_matrix%is_quarter)
      end do
      if (sweep%map_matrix .or. sweep%map_moved_matrix) f%mass_matrix%assembled = .false.
      report%left_cell = left_cell
      report%jumped = jumped
      if (audit) then
         do block = 1, p%n_occupied
            report%velocity_change_energy = report%velocity_change_energy + f%cell_audit(1, p%occupied(block))
            report%stress_work = report%stress_work + f%cell_audit(2, p%occupied(block))
         end do
      end if
   end subroutine sweep_particles

   !> The sweep over the particles of some elements. Arrays come bare, so that the compiler knows that they do not overlap.
   subroutine sweep_cells(sweep, dt, audit, materials, n_cells, cells, element_lower, element_size, element_nodes, &
                          first_in, last_in, stride_in, n_particles, mass, volume, reference, displacement, velocity, &
                          gradient, material, acceleration, new_velocity, strain_velocity, &
                          cell_mass, cell_momentum, cell_force, cell_audit, total_frame, left_cell, jumped, &
                          is_solved, cell_matrix, cell_blend, is_quarter)
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt
      logical, intent(in) :: audit
      type(material_t), intent(in) :: materials(:)
      integer, intent(in) :: n_cells, cells(n_cells)
      real(dp), intent(in) :: element_lower(ndim, *), element_size(*)
      integer, intent(in) :: element_nodes(corners, *), first_in(*), last_in(*), stride_in(*), n_particles, material(*)
      real(dp), intent(in) :: mass(*), volume(*), reference(n_particles, *)
      real(dp), intent(inout) :: displacement(n_particles, *), velocity(n_particles, *), gradient(n_particles, ndim, *)
      real(dp), intent(in) :: acceleration(ndim, *), new_velocity(ndim, *), strain_velocity(ndim, *)
      real(dp), intent(inout) :: cell_mass(corners, *), cell_momentum(ndim, corners, *), cell_force(ndim, corners, *)
      real(dp), intent(inout) :: cell_audit(2, *)
      logical, intent(in) :: total_frame
      logical, intent(inout) :: left_cell, jumped
      logical, intent(in) :: is_solved                  !! see `prepare_cell`
      real(dp), intent(inout), optional :: cell_matrix(corners, corners, *)  !! absent where all is lumped
      real(dp), intent(in), optional :: cell_blend(*)
      logical, intent(in), optional :: is_quarter(*)
      real(dp) :: xi(ndim, batch), at_corner(ndim, corners), edge
      real(dp) :: m(batch), v0(batch), x(ndim, batch), u(ndim, batch), v(ndim, batch), h(ndim, ndim, batch)
      integer :: k, e, i, last, stride, n, law(batch)
      do k = 1, n_cells
         e = cells(k)
         edge = element_size(e)
         stride = stride_in(e)
         if (sweep%map_motion .or. sweep%map_moved_motion) then
            cell_mass(:, e) = 0
            cell_momentum(:, :, e) = 0
         end if
         if (sweep%map_matrix .or. sweep%map_moved_matrix) cell_matrix(:, :, e) = 0
         if (sweep%map_force .or. sweep%map_moved_force) cell_force(:, :, e) = 0
         if (audit) cell_audit(:, e) = 0
         do i = first_in(e), last_in(e), batch*stride
            last = min(i + (batch - 1)*stride, last_in(e))
            n = (last - i)/stride + 1
            m(:n) = mass(i:last:stride)
            v0(:n) = volume(i:last:stride)
            law(:n) = material(i:last:stride)
            call take_batch(n, ndim, stride, n_particles, reference(i, 1), x)
            call take_batch(n, ndim, stride, n_particles, displacement(i, 1), u)
            call take_batch(n, ndim, stride, n_particles, velocity(i, 1), v)
            call take_batch(n, ndim*ndim, stride, n_particles, gradient(i, 1, 1), h)
            call find_local_coordinates(n, element_lower(:, e), 1/edge, x, u, total_frame, xi)
            if (sweep%kick) then
               call take_corners(dt, acceleration, element_nodes(:, e), at_corner)
               call kick(n, xi, at_corner, v)
               if (audit) call audit_kick(n, xi, at_corner, m, cell_audit(1, e))
            end if
            if (sweep%strain_fraction > 0) then
               call take_corners(sweep%strain_fraction*dt, strain_velocity, element_nodes(:, e), at_corner)
               if (audit) call audit_strain(n, xi, 1/edge, at_corner, materials, law, v0, h, total_frame, cell_audit(2, e))
               call strain(n, xi, 1/edge, at_corner, total_frame, h)
            end if
            if (sweep%map_motion) call map_motion(n, xi, m, v, cell_mass(1, e), cell_momentum(1, 1, e))
            if (sweep%map_matrix) call map_matrix(n, xi, m, cell_matrix(1, 1, e))
            if (sweep%map_force) call map_force(n, xi, 1/edge, materials, law, v0, h, total_frame, cell_force(1, 1, e))
            if (sweep%move) then
               call take_corners(dt, new_velocity, element_nodes(:, e), at_corner)
               call move(n, xi, at_corner, u)
               if (.not. total_frame) call look_around(n, element_lower(:, e), 1/edge, x, u, xi, left_cell, jumped)
            end if
            if (sweep%map_moved_motion) call map_motion(n, xi, m, v, cell_mass(1, e), cell_momentum(1, 1, e))
            if (sweep%map_moved_matrix) call map_matrix(n, xi, m, cell_matrix(1, 1, e))
            if (sweep%map_moved_force) call map_force(n, xi, 1/edge, materials, law, v0, h, total_frame, cell_force(1, 1, e))
            if (sweep%kick) call put_batch(n, ndim, stride, n_particles, v, velocity(i, 1))
            if (sweep%strain_fraction > 0) call put_batch(n, ndim*ndim, stride, n_particles, h, gradient(i, 1, 1))
            if (sweep%move) call put_batch(n, ndim, stride, n_particles, u, displacement(i, 1))
         end do
         if (sweep%map_matrix .or. sweep%map_moved_matrix) &
            call prepare_cell(cell_blend(e), is_solved, is_quarter(e), cell_matrix(:, :, e))
      end do
   end subroutine sweep_cells

   !> Copy the components of the `n` particles of a batch, the first of which is the first of `values`.
   pure subroutine take_batch(n, width, stride, n_particles, values, copy)
      integer, intent(in) :: n, width, stride, n_particles
      real(dp), intent(in) :: values(n_particles, *)
      real(dp), intent(out) :: copy(width, n)
      integer :: i, d
      do d = 1, width
         do i = 1, n
            copy(d, i) = values((i - 1)*stride + 1, d)
         end do
      end do
   end subroutine take_batch

   !> The reverse of `take_batch`.
   pure subroutine put_batch(n, width, stride, n_particles, copy, values)
      integer, intent(in) :: n, width, stride, n_particles
      real(dp), intent(in) :: copy(width, n)
      real(dp), intent(inout) :: values(n_particles, *)
      integer :: i, d
      do d = 1, width
         do i = 1, n
            values((i - 1)*stride + 1, d) = copy(d, i)
         end do
      end do
   end subroutine put_batch

   !> Local coordinates of `n` particles of a cell, kept inside it.
   pure subroutine find_local_coordinates(n, lower, inverse_size, reference, displacement, total_frame, xi)
      integer, intent(in) :: n
      real(dp), intent(in) :: lower(ndim), inverse_size, reference(ndim, n), displacement(ndim, n)
      logical, intent(in) :: total_frame
      real(dp), intent(out) :: xi(ndim, n)
      integer :: i
      if (total_frame) then
         do i = 1, n
            xi(:, i) = inside_cell((reference(:, i) - lower)*inverse_size)
         end do
      else
         do i = 1, n
            xi(:, i) = inside_cell(((reference(:, i) - lower) + displacement(:, i))*inverse_size)
         end do
      end if
   end subroutine find_local_coordinates

   !> A nodal field at the corners of a cell, times a factor.
   pure subroutine take_corners(factor, field, nodes, at_corner)
      real(dp), intent(in) :: factor, field(ndim, *)
      integer, intent(in) :: nodes(corners)
      real(dp), intent(out) :: at_corner(ndim, corners)
      integer :: c
      do c = 1, corners
         at_corner(:, c) = factor*field(:, nodes(c))
      end do
   end subroutine take_corners

   !> v <- v + change, which is interpolated from the corners [m/s].
   pure subroutine kick(n, xi, change, velocity)
      integer, intent(in) :: n
      real(dp), intent(in) :: xi(ndim, n), change(ndim, corners)
      real(dp), intent(inout) :: velocity(ndim, n)
      integer :: i
      do i = 1, n
         velocity(:, i) = velocity(:, i) + interpolate(xi(:, i), change)
      end do
   end subroutine kick

   !> Add the sum of m dv**2 / 2 [J].
   pure subroutine audit_kick(n, xi, change, mass, energy)
      integer, intent(in) :: n
      real(dp), intent(in) :: xi(ndim, n), change(ndim, corners), mass(n)
      real(dp), intent(inout) :: energy
      integer :: i
      do i = 1, n
         energy = energy + 0.5_dp*mass(i)*sum(interpolate(xi(:, i), change)**2)
      end do
   end subroutine audit_kick

   !> H <- H + dL (I + H), where dL is the gradient of the displacement `change` of the corners [m]; in the total frame
   !> H <- H + dL.
   pure subroutine strain(n, xi, inverse_size, change, total_frame, gradient)
      integer, intent(in) :: n
      real(dp), intent(in) :: xi(ndim, n), inverse_size, change(ndim, corners)
      logical, intent(in) :: total_frame
      real(dp), intent(inout) :: gradient(ndim, ndim, n)
      integer :: i
      if (total_frame) then
         do i = 1, n
            gradient(:, :, i) = gradient(:, :, i) + inverse_size*interpolate_gradient(xi(:, i), change)
         end do
      else
         do i = 1, n
            gradient(:, :, i) = gradient(:, :, i) + gradient_change(xi(:, i), inverse_size, change, gradient(:, :, i))
         end do
      end if
   end subroutine strain

   !> Add the work of the stress in the strain step that follows [J], by Simpson's rule.
   pure subroutine audit_strain(n, xi, inverse_size, change, materials, material, volume, gradient, total_frame, work)
      integer, intent(in) :: n, material(n)
      real(dp), intent(in) :: xi(ndim, n), inverse_size, change(ndim, corners), volume(n), gradient(ndim, ndim, n)
      type(material_t), intent(in) :: materials(:)
      logical, intent(in) :: total_frame
      real(dp), intent(inout) :: work
      real(dp) :: after(ndim, ndim, n), dh(ndim, ndim)
      integer :: i
      after = gradient
      call strain(n, xi, inverse_size, change, total_frame, after)
      do i = 1, n
         dh = after(:, :, i) - gradient(:, :, i)
         associate (m => materials(material(i)), h => gradient(:, :, i))
            work = work + volume(i)/6*sum(dh*(m%conjugate_stress(h) + 4*m%conjugate_stress(h + dh/2) &
                                              + m%conjugate_stress(h + dh)))
         end associate
      end do
   end subroutine audit_strain

   !> Add the mass matrix (6) of the particles to that of their cell.
   pure subroutine map_matrix(n, xi, mass, matrix)
      integer, intent(in) :: n
      real(dp), intent(in) :: xi(ndim, n), mass(n)
      real(dp), intent(inout) :: matrix(corners, corners)
      real(dp) :: shape(corners), sums(corners, corners)
      integer :: i, c
      sums = matrix
      do i = 1, n
         shape = shape_functions(xi(:, i))
         do c = 1, corners
            sums(:, c) = sums(:, c) + (mass(i)*shape(c))*shape
         end do
      end do
      matrix = sums
   end subroutine map_matrix

   !> Add the mass (9) and momentum (8) of the particles to the sums of their cell.
   pure subroutine map_motion(n, xi, mass, velocity, mass_sum, momentum_sum)
      integer, intent(in) :: n
      real(dp), intent(in) :: xi(ndim, n), mass(n), velocity(ndim, n)
      real(dp), intent(inout) :: mass_sum(corners), momentum_sum(ndim, corners)
      real(dp) :: m(corners), p(ndim, corners)
      integer :: i
      m = mass_sum
      p = momentum_sum
      do i = 1, n
         call add_shares(xi(:, i), mass(i), mass(i)*velocity(:, i), m, p)
      end do
      mass_sum = m
      momentum_sum = p
   end subroutine map_motion

   !> Add the internal force (7) of the particles to the sum of their cell.
   pure subroutine map_force(n, xi, inverse_size, materials, material, volume, gradient, total_frame, force_sum)
      integer, intent(in) :: n, material(n)
      real(dp), intent(in) :: xi(ndim, n), inverse_size, volume(n), gradient(ndim, ndim, n)
      type(material_t), intent(in) :: materials(:)
      logical, intent(in) :: total_frame
      real(dp), intent(inout) :: force_sum(ndim, corners)
      real(dp) :: f(ndim, corners), stress(ndim, ndim), weight
      integer :: i
      f = force_sum
      do i = 1, n
         weight = -inverse_size*volume(i)
         associate (m => materials(material(i)))
            if (m%linear) then
               stress = linear_stress(weight*m%lambda, weight*m%mu, gradient(:, :, i))
            else
               stress = weight*m%mapped_stress(gradient(:, :, i), total_frame)
            end if
         end associate
         call add_divergence(xi(:, i), stress, f)
      end do
      force_sum = f
   end subroutine map_force

   !> u <- u + change, which is interpolated from the corners [m].
   pure subroutine move(n, xi, change, displacement)
      integer, intent(in) :: n
      real(dp), intent(in) :: xi(ndim, n), change(ndim, corners)
      real(dp), intent(inout) :: displacement(ndim, n)
      integer :: i
      do i = 1, n
         displacement(:, i) = displacement(:, i) + interpolate(xi(:, i), change)
      end do
   end subroutine move

   !> Find the local coordinates of the moved particles, and see whether they have left the cell.
   pure subroutine look_around(n, lower, inverse_size, reference, displacement, xi, left_cell, jumped)
      integer, intent(in) :: n
      real(dp), intent(in) :: lower(ndim), inverse_size, reference(ndim, n), displacement(ndim, n)
      real(dp), intent(out) :: xi(ndim, n)
      logical, intent(inout) :: left_cell, jumped
      real(dp) :: new_xi(ndim)
      integer :: i
      do i = 1, n
         new_xi = ((reference(:, i) - lower) + displacement(:, i))*inverse_size
         xi(:, i) = inside_cell(new_xi)
         if (.not. all(new_xi >= 0 .and. new_xi < 1)) then
            left_cell = .true.
            jumped = jumped .or. .not. all(new_xi >= -1 .and. new_xi < 2)
         end if
      end do
   end subroutine look_around

   !> Change of H under the displacement `change` of the corners: dL (I + H).
   pure function gradient_change(xi, inverse_size, change, h) result(dh)
      real(dp), intent(in) :: xi(ndim), inverse_size, change(ndim, corners), h(ndim, ndim)
      real(dp) :: dh(ndim, ndim)
      dh = inverse_size*interpolate_gradient(xi, change)
      dh = dh + product_of(dh, h)
   end function gradient_change
end module hampm_sweep
