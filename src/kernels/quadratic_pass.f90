!> The passes over the particles (`hampm_particle_pass`) where cells are quadratic: each cell acts on its nine points, and these on its
!> particles, which are at fixed places of it (the total frame).
!>
!> What a cell gives to its points is kept as the contributions of its quarters, at one corner of one quarter for each point and zero at
!> the other corners, so that sums at the nodes are assembled as ever. Cells do not share what they write: the result has the same
!> bytes on any number of threads.
module hampm_quadratic_pass
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: points_of_quadratic, quarter_of_point, corner_of_point, quadratic_functions, quadratic_gradients
   use hampm_cell_blocks, only: cell_blocks_t, quadratic_cell_t, of_mass, of_momentum, of_force
   use hampm_material, only: material_t
   use hampm_nodal_fields, only: nodal_fields_t, v_next
   use hampm_particles, only: particles_t
   use hampm_pass, only: pass_t
   implicit none
   private
   public :: pass_over_quadratic

   integer, parameter :: n_points = points_of_quadratic

   !> What the particles of a cell give to its points.
   type :: sums_t
      real(dp) :: mass(n_points) = 0             !! [kg]
      real(dp) :: momentum(ndim, n_points) = 0   !! [kg m/s]
      real(dp) :: force(ndim, n_points) = 0      !! [N]
   end type sums_t

contains

   !> Do a pass over all quadratic cells.
   subroutine pass_over_quadratic(pass, dt, materials, p, blocks, f)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! time step [s]
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(nodal_fields_t), intent(inout) :: f
      type(sums_t) :: sums
      integer :: k, e, i
      !$omp parallel do schedule(static) private(sums, e, i)
      do k = 1, size(blocks%quadratic)
         associate (cell => blocks%quadratic(k))
            sums = sums_t()
            do e = cell%first, cell%first + corners - 1
               do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                  call pass_particle(pass, dt, materials(p%material(i)), cell, f, p, i, sums)
               end do
            end do
            call store(pass, cell, sums, f)
         end associate
      end do
   end subroutine pass_over_quadratic

   !> Do the pass with one particle.
   pure subroutine pass_particle(pass, dt, material, cell, f, p, i, sums)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      type(material_t), intent(in) :: material
      type(quadratic_cell_t), intent(in) :: cell
      type(nodal_fields_t), intent(in) :: f
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: i
      type(sums_t), intent(inout) :: sums
      real(dp) :: n(n_points), gradient(n_points, ndim), xi(ndim), t(ndim, ndim)
      xi = (p%reference(i, :) - cell%lower)*cell%inverse_size
      n = quadratic_functions(xi)
      gradient = quadratic_gradients(xi, cell%inverse_size)
      if (pass%kick) p%velocity(i, :) = p%velocity(i, :) + dt*matmul(f%acceleration(:, cell%points), n)
      if (pass%strain_fraction > 0) p%gradient(i, :, :) = p%gradient(i, :, :) &
         + pass%strain_fraction*dt*matmul(f%velocity(:, cell%points, pass%strain_by), gradient)
      if (pass%move) p%displacement(i, :) = p%displacement(i, :) + dt*matmul(f%velocity(:, cell%points, v_next), n)
      if (pass%map_mass) sums%mass = sums%mass + p%mass(i)*n
      if (pass%map_momentum) sums%momentum = sums%momentum + p%mass(i)*spread(p%velocity(i, :), 2, n_points)*spread(n, 1, ndim)
      if (pass%map_force) then
         t = p%volume(i)*material%conjugate_stress(p%gradient_of(i), p%history_of(i))
         sums%force = sums%force - matmul(t, transpose(gradient))
      end if
   end subroutine pass_particle

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
