!> The one loop over the particles. A sweep visits each block of cells, and in it the particles of its cells side by side. It
!> does what its `sweep_t` asks for, always in this order:
!>
!>   0. locate: find the local coordinates in the cells, which are kept for the sweeps that follow;
!>   1. kick:   v <- v + a dt;
!>   2. strain: H <- H + dt L (I + H), L = grad of a nodal velocity;
!>   3. move:   u <- u + (v_i + a_i dt) dt, and look whether the particle has left its cell;
!>   4. map:    mass and momentum, mass matrix, internal force to the grid, from the new u, v and H: the sums over the particles of
!>              a cell are kept beside the block, to be gathered by node. They are void if any particle has left its cell.
!>
!> In the total frame the shape functions are always those at the reference positions, H <- H + dt L, and no particle leaves
!> its cell.
!>
!> The schemes USF, USL, USAVG and MUSL are short lists of such sweeps (`hampm_schemes`). Blocks do not share what they
!> write: the result has the same bytes on any number of threads.
!>
!> Where the cells of a block have equal numbers of particles, these stand in the arrays as the kernels want them, and blocks
!> that follow each other with as many rows are done together, as a run. The particles of other blocks pass through a
!> buffer, in which cells with fewer are filled up with nothing: places without mass and volume.
module hampm_sweep
   use hampm_kinds, only: dp, ndim, corners
   use hampm_audit, only: kick_energy, strain_work
   use hampm_block_kernels, only: most_rows, clear, take_corners, locate_reference, locate_present, add_field, add_gradient, &
                                  add_gradient_product, add_mass, add_momentum, add_matrix, linear_forces, add_stress, divergence
   use hampm_basis, only: edge_margin
   use hampm_mass_matrix, only: mass_matrix_t, prepare_cell
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t, lanes
   use hampm_nodal_fields, only: nodal_fields_t, at_start, new, mass_share, momentum_share, shares
   implicit none
   private
   public :: sweep_t, sweep_report_t, sweep_particles, sweep_list, sweep_between, look_for_leavers, blocks_per_task

   integer, parameter :: blocks_per_task = 32    !! what a thread does at a time

   !> What a sweep does with each particle, in this order.
   type :: sweep_t
      logical :: locate = .false.                !! find the local coordinates; else they are those of the last sweep
      logical :: kick = .false.                  !! v <- v + a dt
      real(dp) :: strain_fraction = 0            !! part of the step over which to strain, 0: not at all
      integer :: strain_by = at_start            !! which nodal velocity strains the particles
      logical :: move = .false.                  !! u <- u + (v_i + a_i dt) dt
      logical :: map_mass = .false.              !! lumped mass to the grid
      logical :: map_momentum = .false.          !! momentum to the grid
      logical :: map_matrix = .false.            !! mass matrix to the cells
      logical :: map_force = .false.             !! internal force to the grid
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
   subroutine sweep_particles(sweep, dt, materials, p, f, audit, report)
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt                        !! time step [s]
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(nodal_fields_t), intent(inout) :: f
      logical, intent(in) :: audit
      type(sweep_report_t), intent(out) :: report
      integer :: task, b
      !$omp parallel do schedule(static)
      do task = 1, (p%n_blocks - 1)/blocks_per_task + 1
         call sweep_list(sweep, dt, materials, p, f, audit, &
                         [(b, b=blocks_per_task*(task - 1) + 1, min(blocks_per_task*task, p%n_blocks))])
      end do
      if (sweep%map_matrix) f%mass_matrix%assembled = .false.
      if (sweep%move .and. .not. p%total_frame) call look_for_leavers(p, f, report)
      if (.not. audit) return
      do b = 1, p%n_blocks
         report%velocity_change_energy = report%velocity_change_energy + f%audit(1, b)
         report%stress_work = report%stress_work + f%audit(2, b)
      end do
   end subroutine sweep_particles

   !> Do one sweep over some blocks.
   subroutine sweep_list(sweep, dt, materials, p, f, audit, blocks)
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt                        !! time step [s]
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(nodal_fields_t), intent(inout) :: f
      logical, intent(in) :: audit
      integer, intent(in) :: blocks(:)
      call sweep_between(sweep, dt, materials, p, f, audit, blocks, f%block_nodes, f%in_row, f%acceleration, &
                         f%velocity(1, 1, new), f%velocity(1, 1, sweep%strain_by))
   end subroutine sweep_list

   !> Do one sweep over some blocks by given fields of given points at the corners of the cells.
   subroutine sweep_between(sweep, dt, materials, p, f, audit, blocks, nodes, in_row, acceleration, new_velocity, &
                            strain_velocity)
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt                        !! time step [s]
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(nodal_fields_t), intent(inout) :: f
      logical, intent(in) :: audit
      integer, intent(in) :: blocks(:)
      integer, intent(in) :: nodes(corners, lanes, *)   !! by block
      logical, intent(in) :: in_row(*)                  !! as in `nodal_fields_t`, by block
      real(dp), intent(in) :: acceleration(ndim, *), new_velocity(ndim, *), strain_velocity(ndim, *)
      call sweep_blocks(sweep, dt, materials, audit, size(blocks), blocks, p%total_frame, p%n, p%mass, p%volume, p%reference, &
                        p%local, p%displacement, p%velocity, p%gradient, p%material, p%block_first, p%block_rows, &
                        p%block_is_even, p%block_material, p%first_in, p%count_in, p%block_cells, nodes, in_row, &
                        f%block_lower, f%block_inverse_size, acceleration, new_velocity, strain_velocity, &
                        f%share(1, 1, 1, 0), f%share(1, 1, 1, 1), f%left, f%audit, f%mass_matrix)
   end subroutine sweep_between

   !> Report whether particles have left their cells.
   subroutine look_for_leavers(p, f, report)
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(in) :: f
      type(sweep_report_t), intent(inout) :: report
      report%left_cell = any(f%left(:p%n_blocks))
      if (report%left_cell) report%jumped = any_has_jumped(p, f)
   end subroutine look_for_leavers

   !> The sweep over some blocks. Arrays of particles come bare, so that the compiler knows that they do not overlap.
   subroutine sweep_blocks(sweep, dt, materials, audit, n_listed, listed, total_frame, n, mass, volume, reference, local, &
                           displacement, velocity, gradient, material, block_first, block_rows, block_is_even, &
                           block_material, first_in, count_in, block_cells, nodes, in_row, lower, inverse_size, &
                           acceleration, new_velocity, strain_velocity, zeros, share, left, audited, matrix)
      type(sweep_t), intent(in) :: sweep
      real(dp), intent(in) :: dt
      type(material_t), intent(in) :: materials(:)
      logical, intent(in) :: audit
      integer, intent(in) :: n_listed, listed(n_listed) !! blocks
      logical, intent(in) :: total_frame
      integer, intent(in) :: n, material(n)             !! particles, and by particle:
      real(dp), intent(in) :: mass(n), volume(n), reference(n, ndim)
      real(dp), intent(inout) :: local(n, ndim), displacement(n, ndim), velocity(n, ndim), gradient(n, ndim, ndim)
      integer, intent(in) :: block_first(*), block_rows(*), block_material(*), first_in(*), count_in(*), block_cells(lanes, *)
      logical, intent(in) :: block_is_even(*), in_row(*)
      integer, intent(in) :: nodes(corners, lanes, *)
      real(dp), intent(in) :: lower(lanes, ndim, *), inverse_size(lanes, *)
      real(dp), intent(in) :: acceleration(ndim, *), new_velocity(ndim, *), strain_velocity(ndim, *)
      real(dp), intent(in) :: zeros(lanes)
      real(dp), intent(inout) :: share(lanes, corners, shares, *), audited(2, *)
      logical, intent(inout) :: left(*)
      type(mass_matrix_t), intent(inout) :: matrix
      integer, parameter :: room = lanes*most_rows
      real(dp) :: mass_of(room), volume_of(room), x(room, ndim), xi(room, ndim), u(room, ndim), v(room, ndim), h(room, ndim, ndim)
      integer :: material_of(room)
      real(dp), dimension(lanes, corners, ndim, most_rows) :: kick_by, strain_by, move_by
      real(dp), dimension(lanes, ndim*ndim, most_rows) :: total, moment
      real(dp) :: beyond(lanes, most_rows), step(lanes, most_rows), lambda, mu
      logical :: is_linear
      integer :: j, b, n_blocks, i, s, rows
      j = 1
      do while (j <= n_listed)
         b = listed(j)
         n_blocks = length_of_run()
         call start_run()
         s = 1
         do while (s <= block_rows(b))
            rows = min(most_rows, block_rows(b) - s + 1)
            if (block_is_even(b)) then
               i = block_first(b) + lanes*(s - 1)
               call sweep_rows(n, mass(i), volume(i), reference(i, 1), local(i, 1), displacement(i, 1), velocity(i, 1), &
                               gradient(i, 1, 1), material(i))
            else
               call load_rows()
               call sweep_rows(room, mass_of, volume_of, x, xi, u, v, h, material_of)
               call store_rows()
            end if
            s = s + rows
         end do
         call finish_run()
         j = j + n_blocks
      end do
   contains

      !> How many of the listed blocks, from the present one on, can be done together.
      pure integer function length_of_run() result(length)
         length = 1
         if (.not. block_is_even(b)) return
         do while (j + length <= n_listed .and. (length + 1)*block_rows(b) <= most_rows)
            associate (next => b + length)
               if (listed(j + length) /= next) exit
               if (.not. (block_is_even(next) .and. block_rows(next) == block_rows(b) .and. &
                          block_material(next) == block_material(b))) exit
            end associate
            length = length + 1
         end do
      end function length_of_run

      !> Prepare the nodal fields of a run and clear its sums.
      subroutine start_run()
         integer :: k, l
         step(:, :n_blocks) = dt
         if (sweep%kick) call take_corners(n_blocks, step, acceleration, nodes(1, 1, b), in_row(b), kick_by)
         if (sweep%move) call take_corners(n_blocks, step, new_velocity, nodes(1, 1, b), in_row(b), move_by)
         if (sweep%strain_fraction > 0) then
            step(:, :n_blocks) = (sweep%strain_fraction*dt)*inverse_size(:, b:b + n_blocks - 1)
            call take_corners(n_blocks, step, strain_velocity, nodes(1, 1, b), in_row(b), strain_by)
         end if
         if (sweep%map_mass) call clear(n_blocks, corners, corners*shares, zeros, share(1, 1, mass_share, b))
         if (sweep%map_momentum) call clear(n_blocks, corners*ndim, corners*shares, zeros, share(1, 1, momentum_share, b))
         if (sweep%map_force) then
            call clear(n_blocks, ndim*ndim, ndim*ndim, zeros, total)
            call clear(n_blocks, ndim*ndim, ndim*ndim, zeros, moment)
         end if
         if (sweep%move) call clear(n_blocks, 1, 1, zeros, beyond)
         if (sweep%map_matrix) then
            do k = b, b + n_blocks - 1
               do l = 1, lanes
                  if (block_cells(l, k) > 0) matrix%cell(:, :, block_cells(l, k)) = 0
               end do
            end do
         end if
         if (audit) audited(:, b:b + n_blocks - 1) = 0
         is_linear = block_material(b) > 0
         if (is_linear) then
            associate (m => materials(block_material(b)))
               is_linear = m%linear
               lambda = m%lambda
               mu = m%mu
            end associate
         end if
      end subroutine start_run

      !> Do some rows of particles of each block of a run, whose arrays have the leading dimension `ld`.
      subroutine sweep_rows(ld, mass, volume, x, xi, u, v, h, material)
         integer, intent(in) :: ld, material(ld)
         real(dp), intent(in) :: mass(ld), volume(ld), x(ld, ndim)
         real(dp), intent(inout) :: xi(ld, ndim), u(ld, ndim), v(ld, ndim), h(ld, ndim, ndim)
         real(dp) :: t(lanes, ndim*ndim, most_rows), outside(lanes, most_rows)
         integer :: k, first
         if (sweep%locate) then
            if (total_frame) then
               call locate_reference(n_blocks, rows, ld, lower(1, 1, b), inverse_size(1, b), x, xi)
            else
               outside(:, :n_blocks) = 0
               call locate_present(n_blocks, rows, ld, lower(1, 1, b), inverse_size(1, b), x, u, xi, outside)
            end if
         end if
         if (sweep%kick) then
            call add_field(n_blocks, rows, ld, xi, kick_by, v)
            if (audit) then
               do k = 1, n_blocks
                  first = lanes*rows*(k - 1) + 1
                  audited(1, b + k - 1) = audited(1, b + k - 1) + kick_energy(rows, ld, xi(first, 1), kick_by(1, 1, 1, k), &
                                                                              mass(first))
               end do
            end if
         end if
         if (sweep%strain_fraction > 0) then
            if (audit) then
               do k = 1, n_blocks
                  first = lanes*rows*(k - 1) + 1
                  audited(2, b + k - 1) = audited(2, b + k - 1) + strain_work(rows, ld, xi(first, 1), strain_by(1, 1, 1, k), &
                                                       materials, material(first), volume(first), h(first, 1, 1), total_frame)
               end do
            end if
            if (total_frame) then
               call add_gradient(n_blocks, rows, ld, xi, strain_by, h)
            else
               call add_gradient_product(n_blocks, rows, ld, xi, strain_by, h)
            end if
         end if
         if (sweep%move) then
            call add_field(n_blocks, rows, ld, xi, move_by, u)
            if (.not. total_frame) call locate_present(n_blocks, rows, ld, lower(1, 1, b), inverse_size(1, b), x, u, xi, beyond)
         end if
         if (sweep%map_mass) call add_mass(n_blocks, rows, ld, xi, mass, share(1, 1, 1, b))
         if (sweep%map_momentum) call add_momentum(n_blocks, rows, ld, xi, mass, v, share(1, 1, 1, b))
         if (sweep%map_matrix) then
            do k = 1, n_blocks
               first = lanes*rows*(k - 1) + 1
               call add_matrix(rows, ld, xi(first, 1), mass(first), block_cells(1, b + k - 1), matrix%cell)
            end do
         end if
         if (sweep%map_force) then
            if (is_linear) then
               call linear_forces(n_blocks*rows, ld, lambda, mu, volume, h, t)
            else
               call forces(n_blocks*rows, ld, materials, material, volume, h, total_frame, t)
            end if
            call add_stress(n_blocks, rows, ld, xi, t, total, moment)
         end if
      end subroutine sweep_rows

      !> Copy some rows of a block whose cells have different numbers of particles into the buffer.
      subroutine load_rows()
         integer :: l, r, k, i, e
         do l = 1, lanes
            e = block_cells(l, b)
            do r = 1, rows
               k = lanes*(r - 1) + l
               if (holds(e, s + r - 1)) then
                  i = first_in(e) + s + r - 2
                  mass_of(k) = mass(i)
                  volume_of(k) = volume(i)
                  x(k, :) = reference(i, :)
                  xi(k, :) = local(i, :)
                  u(k, :) = displacement(i, :)
                  v(k, :) = velocity(i, :)
                  h(k, :, :) = gradient(i, :, :)
                  material_of(k) = material(i)
               else
                  mass_of(k) = 0
                  volume_of(k) = 0
                  x(k, :) = lower(l, :, b) + 0.5_dp/inverse_size(l, b)
                  xi(k, :) = 0.5_dp
                  u(k, :) = 0
                  v(k, :) = 0
                  h(k, :, :) = 0
                  material_of(k) = 1
               end if
            end do
         end do
      end subroutine load_rows

      !> Copy back what a sweep can have changed.
      subroutine store_rows()
         integer :: l, r, k, i, e
         do l = 1, lanes
            e = block_cells(l, b)
            do r = 1, rows
               if (.not. holds(e, s + r - 1)) exit
               k = lanes*(r - 1) + l
               i = first_in(e) + s + r - 2
               if (sweep%locate .or. sweep%move) local(i, :) = xi(k, :)
               if (sweep%move) displacement(i, :) = u(k, :)
               if (sweep%kick) velocity(i, :) = v(k, :)
               if (sweep%strain_fraction > 0) gradient(i, :, :) = h(k, :, :)
            end do
         end do
      end subroutine store_rows

      !> Whether there is a k-th particle in a cell, 0 being none.
      pure logical function holds(e, k)
         integer, intent(in) :: e, k
         holds = .false.
         if (e > 0) holds = k <= count_in(e)
      end function holds

      !> Complete the sums of a run.
      subroutine finish_run()
         integer :: k, l
         if (sweep%map_force) call divergence(n_blocks, inverse_size(1, b), total, moment, share(1, 1, 1, b))
         do k = 1, n_blocks
            if (sweep%move) left(b + k - 1) = .not. all(beyond(:, k) <= 4*block_rows(b)*edge_margin)
            if (.not. sweep%map_matrix) cycle
            do l = 1, lanes
               associate (e => block_cells(l, b + k - 1))
                  if (e == 0) exit
                  matrix%cell_lumped(:, e) = sum(matrix%cell(:, :, e), dim=2)
                  call prepare_cell(matrix%blend(e), matrix%is_solved, matrix%is_quarter(e), matrix%cell(:, :, e))
               end associate
            end do
         end do
      end subroutine finish_run
   end subroutine sweep_blocks

   !> Volume times stress of particles of any materials, as `linear_forces`.
   pure subroutine forces(rows, ld, materials, material, volume, h, total_frame, t)
      integer, intent(in) :: rows, ld, material(ld)
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: volume(ld), h(ld, ndim, ndim)
      logical, intent(in) :: total_frame
      real(dp), intent(out) :: t(lanes, ndim*ndim, rows)
      real(dp) :: h_of(ndim, ndim)
      integer :: s, l, k
      do s = 1, rows
         do l = 1, lanes
            k = lanes*(s - 1) + l
            h_of = h(k, :, :)
            t(l, :, s) = volume(k)*reshape(materials(material(k))%mapped_stress(h_of, total_frame), [ndim*ndim])
         end do
      end do
   end subroutine forces

   !> Whether any particle of the blocks that one has left is no longer in its cell or one beside it.
   pure logical function any_has_jumped(p, f) result(jumped)
      type(particles_t), intent(in) :: p
      type(nodal_fields_t), intent(in) :: f
      real(dp) :: xi(ndim)
      integer :: b, l, i
      jumped = .false.
      do b = 1, p%n_blocks
         if (.not. f%left(b)) cycle
         do l = 1, lanes
            associate (e => p%block_cells(l, b))
               if (e == 0) cycle
               do i = p%first_in(e), p%last_in(e), p%stride_in(e)
                  xi = (p%position(i) - f%block_lower(l, :, b))*f%block_inverse_size(l, b)
                  jumped = jumped .or. .not. all(xi >= -1 .and. xi < 2)
               end do
            end associate
         end do
      end do
   end function any_has_jumped
end module hampm_sweep
