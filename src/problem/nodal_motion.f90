!> The equations of motion of the nodes, with any mass matrix.
module hampm_nodal_motion
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: mass_matrix_t, nodes_per_chunk
   use hampm_mass_solver, only: mass_solver_t, solve_mass, by_lumped
   use hampm_nodal_fields, only: nodal_fields_t, v_n, v_next
   use hampm_nodal_kernels, only: divide_by_mass, advance_velocities, sum_of_products
   implicit none
   private
   public :: find_velocity, accelerate, find_powers

contains

   !> Nodal velocities (8) from the mapped momentum [m/s]. The guess is the last nodal velocity: the solution up to the change of
   !> the matrix since then and the filter of a partly lumped matrix.
   subroutine find_velocity(grid, solver, free, f, which, latest, failure)
      type(grid_t), intent(in) :: grid
      type(mass_solver_t), intent(inout) :: solver
      real(dp), intent(in), contiguous :: free(:, :)    !! 0 for fixed components of nodes, else 1; (ndim, n_points)
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: which                      !! velocity to set: `v_n` or `v_mapped`
      integer, intent(in) :: latest                     !! the velocity that was found last
      type(failure_t), intent(inout) :: failure
      if (solver%iterates()) f%velocity(:, :, which) = f%velocity(:, :, latest)
      call solve(grid, solver, free, f%mass_matrix, f%momentum, f%velocity(:, :, which), failure)
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%velocity(:, :, which))
   end subroutine find_velocity

   !> Solve M x = b at the nodes. On entry `x` holds a guess.
   subroutine solve(grid, solver, free, matrix, b, x, failure)
      type(grid_t), intent(in) :: grid
      type(mass_solver_t), intent(inout) :: solver
      real(dp), intent(in), contiguous :: free(:, :)
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in), contiguous :: b(:, :)       !! (ndim, n_points)
      real(dp), intent(inout), contiguous :: x(:, :)    !! (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      if (solver%by == by_lumped) then
         call divide_by_mass(matrix%all%n_nodes, matrix%all%nodes, free, matrix%inverse_lumped, b, x)
         call solver%hold_or_turn(matrix, b, x)
      else
         call solve_mass(solver, grid, matrix, b, x, failure)
      end if
   end subroutine solve

   !> Nodal accelerations (5) with the damping force -alpha m v, and the velocities v + a dt that move the particles.
   !>
   !> Also the power of the damping, and for the energy balance
   !>    mapping_power = dt sum F_i . a_i - sum f_i . (v_i + a_i dt),   F the total force, f the same without damping:
   !> with sum_p m dv**2/2 of the particles its first term is the loss of kinetic energy between nodes and
   !> particles, and with the stress work and the work of the loads its second the energy that the scheme loses.
   subroutine accelerate(grid, solver, free, damping_rate, dt, with_powers, is_known, f, damping_power, mapping_power, &
                         failure)
      type(grid_t), intent(in) :: grid
      type(mass_solver_t), intent(inout) :: solver
      real(dp), intent(in), contiguous :: free(:, :)    !! 0 for fixed components of nodes, else 1; (ndim, n_points)
      real(dp), intent(in) :: damping_rate              !! alpha [1/s]
      real(dp), intent(in) :: dt                        !! [s]
      logical, intent(in) :: with_powers                !! whether these are wanted; else they are 0
      logical, intent(in) :: is_known                   !! whether `acceleration` is the solution for these forces
      type(nodal_fields_t), intent(inout) :: f
      real(dp), intent(out) :: damping_power            !! sum alpha p_i . (v_i + a_i dt) [W]
      real(dp), intent(out) :: mapping_power            !! the above powers [W]
      type(failure_t), intent(inout) :: failure
      integer :: chunk, chunks, first
      logical :: iterates                        ! a resumed run would, not knowing that its factors are of this matrix
      iterates = solver%iterates() .and. .not. is_known
      if (iterates) then                         ! from the line through the last two solutions on
         if (.not. allocated(f%earlier)) allocate (f%earlier(ndim, size(f%acceleration, 2), 2), source=0.0_dp)
         f%acceleration = 2*f%earlier(:, :, 1) - f%earlier(:, :, 2)
      end if
      if (.not. is_known) call solve(grid, solver, free, f%mass_matrix, f%force, f%acceleration, failure)
      if (iterates) then
         f%earlier(:, :, 2) = f%earlier(:, :, 1)
         f%earlier(:, :, 1) = f%acceleration
      end if
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%acceleration)
      chunks = (f%mass_matrix%all%n_points - 1)/nodes_per_chunk + 1
      !$omp parallel do schedule(static) private(first)
      do chunk = 1, chunks
         first = (chunk - 1)*nodes_per_chunk + 1
         call advance_velocities(min(nodes_per_chunk, f%mass_matrix%all%n_points - first + 1), f%mass_matrix%all%nodes(first), &
                                 damping_rate, dt, with_powers, f%momentum, f%force, f%velocity(1, 1, v_n), &
                                 f%acceleration, f%velocity(1, 1, v_next), f%partial_power(1, chunk))
      end do
      damping_power = damping_rate*sum(f%partial_power(1, :chunks))
      mapping_power = sum(f%partial_power(2, :chunks))
   end subroutine accelerate

   !> The same if nodes have prescribed motions or are kept apart, by their velocities and accelerations then: with the mapped
   !> momentum p a step changes the kinetic energy by dt sum p . a + sum m_p |dv_p|**2/2 for any a, so that the energy balance is
   !> closed by -sum p . a - sum alpha p . w. It is the same if M v = p and M a = f - alpha M v.
   pure subroutine find_powers(f, damping_rate, damping_power, mapping_power)
      type(nodal_fields_t), intent(in) :: f
      real(dp), intent(in) :: damping_rate              !! alpha [1/s]
      real(dp), intent(out) :: damping_power, mapping_power !! [W]
      associate (all => f%mass_matrix%all)
         damping_power = damping_rate*sum_of_products(all%n_nodes, all%nodes, f%momentum, f%velocity(1, 1, v_next))
         mapping_power = -sum_of_products(all%n_nodes, all%nodes, f%momentum, f%acceleration) - damping_power
      end associate
   end subroutine find_powers
end module hampm_nodal_motion
