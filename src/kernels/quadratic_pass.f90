!> The passes over the particles (`hampm_particle_pass`) where cells are quadratic: each cell acts on its nine points, and these on its
!> particles, which are at fixed places of it (the total frame).
!>
!> What a cell gives to its points is kept as the contributions of its quarters, at one corner of one quarter for each point and zero at
!> the other corners, so that sums at the nodes are assembled as ever. Cells do not share what they write: the result has the same
!> bytes on any number of threads.
module hampm_quadratic_pass
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: points_of_quadratic, quarter_of_point, corner_of_point, quadratic_functions, quadratic_gradients
   use hampm_audit_kernels, only: work_of_change, work_of_hoop
   use hampm_cell_blocks, only: cell_blocks_t, quadratic_cell_t, of_mass, of_momentum, of_force
   use hampm_mass_matrix, only: mass_matrix_t, prepare_cell, floor_of_quadratic
   use hampm_material, only: material_t
   use hampm_remembering, only: remember, hoop_resistance
   use hampm_nodal_fields, only: nodal_fields_t, v_next
   use hampm_particles, only: particles_t
   use hampm_pass, only: pass_t
   implicit none
   private
   public :: pass_over_quadratic, pass_between_quadratic

   integer, parameter :: n_points = points_of_quadratic
   real(dp), parameter :: rounding = 1e-12_dp    !! of masses of points, over that of a cell

   !> What the particles of a cell give to its points.
   type :: sums_t
      real(dp) :: mass(n_points) = 0             !! [kg]
      real(dp) :: momentum(ndim, n_points) = 0   !! [kg m/s]
      real(dp) :: force(ndim, n_points) = 0      !! [N]
      real(dp) :: kick_energy = 0                !! sum of m |dv|**2 / 2 [J]
      real(dp) :: stress_work = 0                !! sum of V times the integral of P : dH [J]
   end type sums_t

contains

   !> Do a pass over all quadratic cells. `audit` is what the pass has summed for the energy audit, if it was to: of m |dv|**2 / 2 and of
   !> the work of the stress [J].
   subroutine pass_over_quadratic(pass, dt, materials, p, blocks, f, audit)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! time step [s]
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      real(dp), intent(out) :: audit(2)
      real(dp) :: of_cell(2, size(blocks%quadratic))
      integer :: k
      call pass_between_quadratic(pass, dt, materials, p, blocks, f, [(k, k=1, size(blocks%quadratic))], f%acceleration, &
                                  f%velocity(1, 1, v_next), f%velocity(1, 1, pass%strain_by), of_cell)
      if (pass%map_matrix) f%mass_matrix%assembled = .false.
      audit = sum(of_cell, dim=2)
   end subroutine pass_over_quadratic

   !> Do a pass over some of them by given fields at the points.
   subroutine pass_between_quadratic(pass, dt, materials, p, blocks, f, listed, acceleration, new_velocity, strain_velocity, audit)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! time step [s]
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: listed(:)           !! numbers of cells
      real(dp), intent(in) :: acceleration(ndim, *), new_velocity(ndim, *), strain_velocity(ndim, *)
      real(dp), intent(out) :: audit(:, :)       !! as above, by cell, (2, listed)
      type(sums_t) :: sums
      integer :: k, e, i
      !$omp parallel do schedule(static) private(sums, e, i)
      do k = 1, size(listed)
         associate (cell => blocks%quadratic(listed(k)))
            sums = sums_t()
            do e = cell%first, cell%first + corners - 1
               do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                  call pass_particle(pass, dt, materials(p%material(i)), cell, acceleration, new_velocity, &
                                     strain_velocity, p, i, sums)
               end do
            end do
            if (p%thickness%is_ring) where (abs(sums%mass) <= rounding*sum(sums%mass)) sums%mass = 0 ! on the axis
            call store(pass, cell, sums, f)
            audit(:, k) = [sums%kick_energy, sums%stress_work]
            if (pass%map_matrix) call find_matrix(p, blocks, cell, f%mass_matrix)
         end associate
      end do
   end subroutine pass_between_quadratic

   !> Do the pass with one particle.
   pure subroutine pass_particle(pass, dt, material, cell, acceleration, new_velocity, strain_velocity, p, i, sums)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      type(material_t), intent(in) :: material
      type(quadratic_cell_t), intent(in) :: cell
      real(dp), intent(in) :: acceleration(ndim, *), new_velocity(ndim, *), strain_velocity(ndim, *)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: i
      type(sums_t), intent(inout) :: sums
      real(dp) :: n(n_points), gradient(n_points, ndim), xi(ndim), t(ndim, ndim), change(ndim, ndim), dv(ndim), hoop
      xi = (p%reference(i, :) - cell%lower)*cell%inverse_size
      n = quadratic_functions(xi)
      gradient = quadratic_gradients(xi, cell%inverse_size) + cell%correction
      if (pass%kick) then
         dv = dt*matmul(acceleration(:, cell%points), n)
         if (pass%audit) sums%kick_energy = sums%kick_energy + 0.5_dp*p%mass(i)*sum(dv**2)
         p%velocity(i, :) = p%velocity(i, :) + dv
      end if
      if (pass%move) then                        ! before it is strained: its hoop has part in that
         hoop = p%hoop_of(i)
         p%displacement(i, :) = p%displacement(i, :) + dt*matmul(new_velocity(:, cell%points), n)
         if (pass%audit .and. material%is_ring) sums%stress_work = sums%stress_work + p%volume(i)*work_of_hoop(material, hoop, p, i)
      end if
      if (pass%strain_fraction > 0) then
         change = pass%strain_fraction*dt*matmul(strain_velocity(:, cell%points), gradient)
         if (pass%audit) sums%stress_work = sums%stress_work + p%volume(i)*work_of_change(material, p%gradient_of(i), change, &
                                                                   pass%strain_fraction*dt, p, i, p%hoop_of(i))
         p%gradient(i, :, :) = p%gradient(i, :, :) + change
         if (pass%keeps_history) call remember(material, pass%strain_fraction*dt, p, i)
      end if
      if (pass%map_mass) sums%mass = sums%mass + p%mass(i)*n
      if (pass%map_momentum) sums%momentum = sums%momentum + p%mass(i)*spread(p%velocity(i, :), 2, n_points)*spread(n, 1, ndim)
      if (pass%map_force) then
         t = p%volume(i)*material%conjugate_stress(p%gradient_of(i), p%history_of(i), p%hoop_of(i))
         sums%force = sums%force - matmul(t, transpose(gradient))
         if (material%is_ring) sums%force(1, :) = sums%force(1, :) - p%volume(i)*hoop_resistance(material, p, i)*n
      end if
   end subroutine pass_particle

   !> The mass matrix (6) of a cell, by its points.
   pure subroutine find_matrix(p, blocks, cell, matrix)
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(quadratic_cell_t), intent(in) :: cell
      type(mass_matrix_t), intent(inout) :: matrix
      real(dp) :: n(n_points), m(n_points, n_points)
      integer :: e, i, c
      m = 0
      do e = cell%first, cell%first + corners - 1
         do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
            n = quadratic_functions((p%reference(i, :) - cell%lower)*cell%inverse_size)
            do c = 1, n_points
               m(:, c) = m(:, c) + p%mass(i)*n(c)*n
            end do
         end do
      end do
      associate (k => matrix%cell_of(cell%first))
         matrix%cell_lumped(:, k) = sum(m, dim=2)
         if (.not. allocated(matrix%diagonal)) call prepare_cell(n_points, matrix%blend(k), matrix%is_solved, matrix%may_hang(k), &
                                                                 m, floor_of_quadratic)
         matrix%cell(:, :, k) = m
      end associate
   end subroutine find_matrix

   !> Store what a cell gives to its points as contributions of its quarters.
   pure subroutine store(pass, cell, sums, f)
      type(pass_t), intent(in) :: pass
      type(quadratic_cell_t), intent(in) :: cell
      type(sums_t), intent(in) :: sums
      type(nodal_fields_t), intent(inout) :: f
      integer :: q, k
      do q = 1, corners
         if (cell%block(q) == 0) cycle
         associate (given => f%contribution(cell%lane(q), :, :, cell%block(q)))
            if (pass%map_mass) given(:, of_mass) = 0
            if (pass%map_momentum) given(:, of_momentum:of_momentum + ndim - 1) = 0
            if (pass%map_force) given(:, of_force:of_force + ndim - 1) = 0
            do k = 1, n_points
               if (quarter_of_point(k) /= q) cycle
               associate (c => corner_of_point(k))
                  if (pass%map_mass) given(c, of_mass) = sums%mass(k)
                  if (pass%map_momentum) given(c, of_momentum:of_momentum + ndim - 1) = sums%momentum(:, k)
                  if (pass%map_force) given(c, of_force:of_force + ndim - 1) = sums%force(:, k)
               end associate
            end do
         end associate
      end do
   end subroutine store
end module hampm_quadratic_pass
