!> The passes over the particles: nodal values go to the particles (G2P), sums over the particles to the nodes (P2G), by blocks of
!> cells with particles side by side, in batches of blocks with equal rows (others through a padded buffer). A pass does what its
!> `pass_t` asks for, in this order:
!>
!>   0. locate: find the local coordinates in the cells, which are kept for the passes that follow;
!>   1. G2P     kick:   v <- v + a dt;
!>   2.         strain: H <- H + dt L (I + H), L = grad of a nodal velocity; in the total frame H <- H + dt L;
!>   3.         move:   u <- u + v^(n+1) dt, and check whether the particle has left its cell (never in the total frame);
!>   4. P2G     map:    mass, momentum, mass matrix, internal force from the new u, v, H, as cell contributions; void if any left.
!>
!> The schemes USF, USL, USAVG and MUSL are short lists of such passes (`hampm_problem`). Blocks do not share what they write: the
!> result has the same bytes on any number of threads.
module hampm_particle_pass
   use hampm_kinds, only: dp, ndim, corners
   use hampm_audit_kernels, only: kick_energy, strain_work
   use hampm_basis, only: edge_margin
   use hampm_cell_blocks, only: cell_blocks_t, lanes, of_mass, of_momentum, n_sums
   use hampm_mass_matrix, only: prepare_cell
   use hampm_material, only: material_t
   use hampm_matter, only: matter_t
   use hampm_nodal_fields, only: nodal_fields_t, v_next
   use hampm_particle_kernels, only: most_blocks, most_rows, n_across, clear, take_corners, locate_reference, locate_present, &
                                     add_field, add_gradient, add_mass, add_momentum, add_matrix, linear_forces, &
                                     anisotropic_forces, add_stress, divergence
   use hampm_particles, only: particles_t
   use hampm_pass, only: pass_t
   use hampm_support_pass, only: pass_by_supports
   implicit none
   private
   public :: pass_report_t, pass_over_all, pass_over, pass_over_blocks, cell_matrices, find_crossing_particles, blocks_per_task

   integer, parameter :: blocks_per_task = 32    !! size of a thread's task
   integer, parameter :: room = lanes*most_rows  !! places of the buffer

   !> Events in a pass and its sums for the energy balance.
   type :: pass_report_t
      logical :: left_cell = .false.             !! some particle has left its cell
      logical :: jumped = .false.                !! some particle moved past the next cell or is no longer a number
      real(dp) :: velocity_change_energy = 0     !! sum of m |dv|**2 / 2 [J]
      real(dp) :: stress_work = 0                !! sum of V times the integral of P : dH by Gauss's rule [J]
   end type pass_report_t

contains

   !> Do a pass over all blocks.
   subroutine pass_over_all(pass, dt, m, f, report)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                        !! time step [s]
      type(matter_t), intent(inout) :: m
      type(nodal_fields_t), intent(inout) :: f
      type(pass_report_t), intent(out) :: report
      integer :: first, b
      real(dp) :: audit(2)
      if (allocated(m%blocks%supports)) then
         call pass_by_supports(pass, dt, m, f, [(b, b=1, size(m%blocks%supports))], f%acceleration, f%velocity(1, 1, v_next), &
                               f%velocity(1, 1, pass%strain_by), audit)
      else
         !$omp parallel do schedule(static)
         do first = 1, m%blocks%n, blocks_per_task
            call pass_over_blocks(pass, dt, m, f, [(b, b=first, min(first + blocks_per_task - 1, m%blocks%n))], f%acceleration, &
                                  f%velocity(1, 1, v_next), f%velocity(1, 1, pass%strain_by))
         end do
         if (pass%audit) audit = [(sum([(f%audit(first, b), b=1, m%blocks%n)]), first=1, 2)]
      end if
      if (pass%map_matrix) f%mass_matrix%assembled = .false.
      if (pass%map_momentum .or. pass%map_force) f%maps = f%maps + 1
      if (pass%move .and. .not. m%particles%total_frame) call find_crossing_particles(m, f, report)
      if (pass%audit) report%velocity_change_energy = audit(1)
      if (pass%audit) report%stress_work = audit(2)
   end subroutine pass_over_all

   !> Do a pass over some blocks.
   subroutine pass_over(pass, dt, m, f, listed)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                        !! time step [s]
      type(matter_t), intent(inout) :: m
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: listed(:)                  !! blocks
      logical, allocatable :: is_listed(:)              ! (blocks)
      integer :: k
      if (allocated(m%blocks%supports)) then
         allocate (is_listed(m%blocks%n), source=.false.)
         is_listed(listed) = .true.
         call pass_by_supports(pass, dt, m, f, pack([(k, k=1, size(m%blocks%supports))], is_listed(m%blocks%supports%block(1))), &
                               f%acceleration, f%velocity(1, 1, v_next), f%velocity(1, 1, pass%strain_by))
         if (pass%map_matrix) f%mass_matrix%assembled = .false.
      else
         call pass_over_blocks(pass, dt, m, f, listed, f%acceleration, f%velocity(1, 1, v_next), &
                               f%velocity(1, 1, pass%strain_by))
      end if
   end subroutine pass_over

   !> Report whether particles have left their cells.
   subroutine find_crossing_particles(m, f, report)
      type(matter_t), intent(in) :: m
      type(nodal_fields_t), intent(in) :: f
      type(pass_report_t), intent(inout) :: report
      report%left_cell = any(f%left(:m%blocks%n))
      if (report%left_cell) report%jumped = any_has_jumped(m, f)
   end subroutine find_crossing_particles

   !> Do a pass over some blocks by given fields at the points.
   subroutine pass_over_blocks(pass, dt, m, f, listed, acceleration, new_velocity, strain_velocity)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                        !! time step [s]
      type(matter_t), intent(inout) :: m
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: listed(:)                  !! blocks
      real(dp), intent(in) :: acceleration(ndim, *), new_velocity(ndim, *), strain_velocity(ndim, *)
      real(dp) :: mass_of(room), volume_of(room), x(room, ndim), xi(room, ndim), u(room, ndim), v(room, ndim), h(room, ndim, ndim)
      integer :: material_of(room), number_of(room)
      real(dp), dimension(lanes, corners, ndim, most_blocks) :: kick_by, strain_by, move_by
      real(dp) :: moments(lanes, ndim*ndim*n_across, most_blocks) ! of the stress
      real(dp) :: beyond(lanes, most_blocks), step(lanes, most_blocks), zeros(lanes), lambda, mu
      logical :: is_linear, is_isotropic
      integer :: j, b, n, i, k, s, rows
      zeros = f%contribution(:, 1, 1, 0)
      j = 1
      do while (j <= size(listed))
         b = listed(j)
         n = min(m%blocks%alike(b), size(listed) - j + 1, max(1, most_rows/m%blocks%rows(b)))
         if (most_rows > most_blocks) n = min(n, most_blocks)
         do while (listed(j + n - 1) /= b + n - 1) ! listed blocks are ascending
            n = n - 1
         end do
         step(:, :n) = dt
         if (pass%kick) call take_corners(n, step, acceleration, m%blocks%nodes(1, 1, b), m%blocks%in_row(b), kick_by)
         if (pass%move) call take_corners(n, step, new_velocity, m%blocks%nodes(1, 1, b), m%blocks%in_row(b), move_by)
         if (pass%strain_fraction > 0) then
            step(:, :n) = (pass%strain_fraction*dt)*m%blocks%inverse_size(:, b:b + n - 1)
            call take_corners(n, step, strain_velocity, m%blocks%nodes(1, 1, b), m%blocks%in_row(b), strain_by)
         end if
         if (pass%map_mass) call clear(n, corners, corners*n_sums, zeros, f%contribution(1, 1, of_mass, b))
         if (pass%map_momentum) call clear(n, corners*ndim, corners*n_sums, zeros, f%contribution(1, 1, of_momentum, b))
         if (pass%map_force) then
            call clear(n, ndim*ndim*n_across, ndim*ndim*n_across, zeros, moments)
            call find_law()
         end if
         if (pass%move) call clear(n, 1, 1, zeros, beyond)
         if (pass%map_matrix) call clear_matrices()
         if (pass%audit) f%audit(:, b:b + n - 1) = 0
         s = 1
         do while (s <= m%blocks%rows(b))
            rows = min(most_rows, m%blocks%rows(b) - s + 1)
            if (m%blocks%is_even(b)) then
               i = m%blocks%first(b) + lanes*(s - 1)
               if (allocated(m%particles%history)) number_of(:lanes*rows*n) = [(k, k=i, i + lanes*rows*n - 1)]
               call pass_rows(m%particles%n, m%particles%mass(i), m%particles%volume(i), m%particles%reference(i, 1), &
                              m%particles%local(i, 1), m%particles%displacement(i, 1), m%particles%velocity(i, 1), &
                              m%particles%gradient(i, 1, 1), m%particles%material(i))
            else
               call load_rows()
               call pass_rows(room, mass_of, volume_of, x, xi, u, v, h, material_of)
               call store_rows()
            end if
            s = s + rows
         end do
         if (pass%map_force) call divergence(n, m%blocks%inverse_size(1, b), moments, f%contribution(1, 1, 1, b))
         if (pass%move) then
            do k = 1, n
               f%left(b + k - 1) = .not. all(beyond(:, k) <= 2*ndim*m%blocks%rows(b)*edge_margin)
            end do
         end if
         if (pass%map_matrix) call finish_matrices()
         j = j + n
      end do
   contains

      !> Find the law of a batch, if it is one linear law.
      subroutine find_law()
         is_linear = m%blocks%material(b) > 0
         if (.not. is_linear) return
         associate (material => m%materials(m%blocks%material(b)))
            is_linear = material%linear .and. .not. material%has_eigenstrain
            is_isotropic = material%isotropic
            lambda = material%lambda
            mu = material%mu
         end associate
      end subroutine find_law

      !> Do some rows of particles of each block of a batch, whose arrays have the leading dimension `ld`.
      subroutine pass_rows(ld, mass, volume, x, xi, u, v, h, material)
         integer, intent(in) :: ld, material(ld)
         real(dp), intent(in) :: mass(ld), volume(ld), x(ld, ndim)
         real(dp), intent(inout) :: xi(ld, ndim), u(ld, ndim), v(ld, ndim), h(ld, ndim, ndim)
         real(dp) :: t(lanes, ndim*ndim, most_rows), outside(lanes, most_blocks)
         integer :: k, first
         if (pass%locate) then
            if (m%particles%total_frame) then
               call locate_reference(n, rows, ld, m%blocks%lower(1, 1, b), m%blocks%inverse_size(1, b), x, xi)
            else
               outside(:, :n) = 0
               call locate_present(n, rows, ld, m%blocks%lower(1, 1, b), m%blocks%inverse_size(1, b), x, u, xi, outside)
            end if
         end if
         if (pass%kick) then
            call add_field(n, rows, ld, xi, kick_by, v)
            if (pass%audit) then
               do k = 1, n
                  first = lanes*rows*(k - 1) + 1
                  f%audit(1, b + k - 1) = f%audit(1, b + k - 1) + kick_energy(rows, ld, xi(first, 1), kick_by(1, 1, 1, k), &
                                                                              mass(first))
               end do
            end if
         end if
         if (pass%strain_fraction > 0) then
            if (pass%audit) then
               do k = 1, n
                  first = lanes*rows*(k - 1) + 1
                  f%audit(2, b + k - 1) = f%audit(2, b + k - 1) + strain_work(rows, ld, xi(first, 1), strain_by(1, 1, 1, k), &
                                                                              m%materials, material(first), volume(first), &
                                                                              h(first, 1, 1), m%particles%total_frame, &
                                                                              pass%strain_fraction*dt, m%particles, &
                                                                              number_of(first))
               end do
            end if
            if (m%particles%total_frame) then
               call add_gradient(n, rows, ld, .false., xi, strain_by, h)
            else
               call add_gradient(n, rows, ld, .true., xi, strain_by, h)
            end if
            if (allocated(m%particles%history) .and. pass%updates_state) &
               call archive_history(n*rows, ld, m%materials, material, h, pass%strain_fraction*dt, number_of, m%particles%history)
         end if
         if (pass%move) then
            call add_field(n, rows, ld, xi, move_by, u)
            if (.not. m%particles%total_frame) &
               call locate_present(n, rows, ld, m%blocks%lower(1, 1, b), m%blocks%inverse_size(1, b), x, u, xi, beyond)
         end if
         if (pass%map_mass) call add_mass(n, rows, ld, xi, mass, f%contribution(1, 1, 1, b))
         if (pass%map_momentum) call add_momentum(n, rows, ld, xi, mass, v, f%contribution(1, 1, 1, b))
         if (pass%map_matrix) then
            do k = 1, n
               first = lanes*rows*(k - 1) + 1
               call add_block_matrices(rows, ld, xi(first, 1), mass(first), b + k - 1)
            end do
         end if
         if (pass%map_force) then
            if (is_linear .and. is_isotropic) then
               call linear_forces(n*rows, ld, lambda, mu, volume, h, t)
            else if (is_linear) then
               call anisotropic_forces(n*rows, ld, m%materials(m%blocks%material(b))%stiffness, volume, h, t)
            else
               call forces(n*rows, ld, m%materials, material, volume, h, m%particles, number_of, t)
            end if
            call add_stress(n, rows, ld, xi, t, moments)
         end if
      end subroutine pass_rows

      !> Begin the mass matrices of the cells of a batch.
      subroutine clear_matrices()
         integer :: k, l
         do k = b, b + n - 1
            do l = 1, lanes
               if (m%blocks%cells(l, k) > 0) f%mass_matrix%cell(:, :, m%blocks%cells(l, k)) = 0
            end do
         end do
      end subroutine clear_matrices

      !> Add the mass matrices of some rows of a block to the matrices of its cells.
      subroutine add_block_matrices(rows, ld, xi, mass, block)
         integer, intent(in) :: rows, ld, block
         real(dp), intent(in) :: xi(ld, ndim), mass(ld)
         real(dp) :: matrix(lanes, corners, corners)
         integer :: l
         matrix = 0
         call add_matrix(rows, ld, xi, mass, matrix)
         do l = 1, lanes
            associate (e => m%blocks%cells(l, block))
               if (e > 0) f%mass_matrix%cell(:, :, e) = f%mass_matrix%cell(:, :, e) + matrix(l, :, :)
            end associate
         end do
      end subroutine add_block_matrices

      !> Complete the mass matrices of the cells of a batch.
      subroutine finish_matrices()
         integer :: k, l, c
         do k = b, b + n - 1
            do l = 1, lanes
               associate (e => m%blocks%cells(l, k), matrix => f%mass_matrix)
                  if (e == 0) exit
                  do c = 1, corners              ! to sum all at a time would allocate
                     matrix%cell_lumped(c, e) = sum(matrix%cell(c, :, e))
                  end do
                  call prepare_cell(corners, matrix%lumped_fraction(e), matrix%is_solved, matrix%may_hang(e), matrix%cell(1, 1, e))
               end associate
            end do
         end do
      end subroutine finish_matrices

      !> Copy some rows of a block whose cells have different numbers of particles into the buffer.
      subroutine load_rows()
         integer :: l, r, k, i, e
         do l = 1, lanes
            e = m%blocks%cells(l, b)
            do r = 1, rows
               k = lanes*(r - 1) + l
               if (holds(e, s + r - 1)) then
                  i = m%blocks%first_in(e) + s + r - 2
                  mass_of(k) = m%particles%mass(i)
                  volume_of(k) = m%particles%volume(i)
                  x(k, :) = m%particles%reference(i, :)
                  xi(k, :) = m%particles%local(i, :)
                  u(k, :) = m%particles%displacement(i, :)
                  v(k, :) = m%particles%velocity(i, :)
                  h(k, :, :) = m%particles%gradient(i, :, :)
                  material_of(k) = m%particles%material(i)
                  number_of(k) = i
               else
                  mass_of(k) = 0
                  volume_of(k) = 0
                  x(k, :) = m%blocks%lower(l, :, b) + 0.5_dp/m%blocks%inverse_size(l, b)
                  xi(k, :) = 0.5_dp
                  u(k, :) = 0
                  v(k, :) = 0
                  h(k, :, :) = 0
                  material_of(k) = 1
                  number_of(k) = 0
               end if
            end do
         end do
      end subroutine load_rows

      !> Copy back the columns that a pass can have changed.
      subroutine store_rows()
         integer :: l, r, k, i, e
         do l = 1, lanes
            e = m%blocks%cells(l, b)
            do r = 1, rows
               if (.not. holds(e, s + r - 1)) exit
               k = lanes*(r - 1) + l
               i = m%blocks%first_in(e) + s + r - 2
               if (pass%locate .or. pass%move) m%particles%local(i, :) = xi(k, :)
               if (pass%move) m%particles%displacement(i, :) = u(k, :)
               if (pass%kick) m%particles%velocity(i, :) = v(k, :)
               if (pass%strain_fraction > 0) m%particles%gradient(i, :, :) = h(k, :, :)
            end do
         end do
      end subroutine store_rows

      !> Whether there is a k-th particle in a cell, 0 being none.
      pure logical function holds(e, k)
         integer, intent(in) :: e, k
         holds = .false.
         if (e > 0) holds = k <= m%blocks%count_in(e)
      end function holds
   end subroutine pass_over_blocks

   !> The mass matrices (6) of the cells of a block, whose particles have been located, by lane [kg].
   pure subroutine cell_matrices(p, blocks, b, matrix)
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: b
      real(dp), intent(out) :: matrix(lanes, corners, corners)
      real(dp) :: xi(lanes, ndim), mass(lanes)
      integer :: s, l, i
      matrix = 0
      do s = 1, blocks%rows(b)
         mass = 0
         xi = 0
         do l = 1, count(blocks%cells(:, b) > 0)
            associate (e => blocks%cells(l, b))
               if (s > blocks%count_in(e)) cycle
               i = blocks%first_in(e) + (s - 1)*blocks%stride_in(e)
               mass(l) = p%mass(i)
               xi(l, :) = p%local(i, :)
            end associate
         end do
         call add_matrix(1, lanes, xi, mass, matrix)
      end do
   end subroutine cell_matrices

   !> Volume times stress of particles of any materials, as `linear_forces`.
   pure subroutine forces(rows, ld, materials, material, volume, h, p, number, t)
      integer, intent(in) :: rows, ld, material(ld)
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: volume(ld), h(ld, ndim, ndim)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: number(lanes*rows)         !! of the particles, 0 for none; not set where no law has a history
      real(dp), intent(out) :: t(lanes, ndim*ndim, rows)
      real(dp) :: h_of(ndim, ndim)
      integer :: s, l, k
      do s = 1, rows
         do l = 1, lanes
            k = lanes*(s - 1) + l
            h_of = h(k, :, :)
            t(l, :, s) = volume(k)*[materials(material(k))%mapped_stress(h_of, p%total_frame, p%history_of(number(k)))]
         end do
      end do
   end subroutine forces

   !> Keep the states of particles that have been strained in a step `dt`, where their law has a history.
   pure subroutine archive_history(rows, ld, materials, material, h, dt, number, history)
      integer, intent(in) :: rows, ld, material(ld)
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: h(ld, ndim, ndim), dt
      integer, intent(in) :: number(lanes*rows)         !! of the particles, 0 for none
      real(dp), intent(inout) :: history(:, :)
      real(dp) :: h_of(ndim, ndim), state(size(history, 2))
      integer :: k
      do k = 1, lanes*rows
         if (number(k) == 0) cycle
         if (.not. materials(material(k))%has_history) cycle
         h_of = h(k, :, :)
         state = history(number(k), :)
         call materials(material(k))%update_state(h_of, dt, state)
         history(number(k), :) = state
      end do
   end subroutine archive_history

   !> Whether any particle of the blocks that one has left is no longer in its cell or one beside it.
   pure logical function any_has_jumped(m, f) result(jumped)
      type(matter_t), intent(in) :: m
      type(nodal_fields_t), intent(in) :: f
      real(dp) :: xi(ndim)
      integer :: b, l, i
      jumped = .false.
      do b = 1, m%blocks%n
         if (.not. f%left(b)) cycle
         do l = 1, lanes
            associate (e => m%blocks%cells(l, b))
               if (e == 0) cycle
               do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
                  xi = (m%particles%position(i) - m%blocks%lower(l, :, b))*m%blocks%inverse_size(l, b)
                  jumped = jumped .or. .not. all(xi >= -1 .and. xi < 2)
               end do
            end associate
         end do
      end do
   end function any_has_jumped
end module hampm_particle_pass
