!> Nodes of prescribed motion in explicit steps: under any forces they go from their place at t to that at t + dt, with one velocity
!> w. Nodes that turn with their box (`hampm_constraints`) have the velocity and the turning of it.
module hampm_prescribed_nodes
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constraints_t
   use hampm_grid, only: grid_t
   use hampm_mass_product, only: by_mass, by_mass_at
   use hampm_nodal_fields, only: nodal_fields_t, v_n, v_next
   implicit none
   private
   public :: prescribed_work_t, prescribed_velocity, prescribed_acceleration, coupled_to_prescribed, set_prescribed, &
             move_prescribed, find_work

   !> Work of the constraints in a step, by the forces at its start.
   type :: prescribed_work_t
      real(dp) :: dt = 0                         !! its length [s]
      real(dp) :: work = 0                       !! [J]
   end type prescribed_work_t

contains

   !> The velocities of the nodes of the constraints [m/s], (ndim, these nodes): for `v_n` those of the step before, in the first
   !> step the initial velocities of the material; else the present prescribed ones.
   pure function prescribed_velocity(c, time, last, f, which) result(v)
      type(constraints_t), intent(in) :: c
      real(dp), intent(in) :: time               !! at the start of the step [s]
      type(prescribed_work_t), intent(in) :: last !! the last step with prescribed motion
      type(nodal_fields_t), intent(in) :: f
      integer, intent(in) :: which               !! velocity found: `v_n` or `v_mapped`
      real(dp) :: v(ndim, size(c%node))
      integer :: k
      v = 0
      if (which /= v_n) then
         v = f%velocity(:, c%node, v_next)
      else if (last%dt > 0) then
         v = (c%prescribed_of_nodes(time) - c%prescribed_of_nodes(time - last%dt))/last%dt
      else                                       ! as the material begins to move
         do k = 1, size(c%node)
            associate (mass => f%mass_matrix%lumped(c%node(k)))
               if (mass > 0) v(:, k) = f%momentum(:, c%node(k))/mass
            end associate
         end do
      end if
   end function prescribed_velocity

   !> The accelerations of the nodes of the constraints in a step from t to t + dt [m/s2], (ndim, these nodes).
   pure function prescribed_acceleration(c, time, dt, f) result(a)
      type(constraints_t), intent(in) :: c
      real(dp), intent(in) :: time, dt           !! [s]
      type(nodal_fields_t), intent(in) :: f
      real(dp) :: a(ndim, size(c%node))
      a = ((c%prescribed_of_nodes(time + dt) - c%prescribed_of_nodes(time))/dt &
           - (f%velocity(:, c%node, v_n) - c%turned(f%velocity(:, :, v_n))))/dt
   end function prescribed_acceleration

   !> Contribution of fixed components with values of the nodes of the constraints to the nodal equations: M x, (ndim, n_points).
   pure function coupled_to_prescribed(c, grid, f, values) result(mx)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(in) :: f
      real(dp), intent(in) :: values(:, :)       !! (ndim, nodes of the constraints)
      real(dp), allocatable :: mx(:, :), x(:, :)
      allocate (x(ndim, grid%n_points), source=0.0_dp)
      call set_prescribed(c, grid, f, values, x)
      allocate (mx, source=by_mass(grid, f%mass_matrix, x))
   end function coupled_to_prescribed

   !> Set fixed components of a field to values of the nodes of the constraints, turning ones by the turning.
   pure subroutine set_prescribed(c, grid, f, values, x)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(in) :: f
      real(dp), intent(in) :: values(:, :)       !! (ndim, nodes of the constraints)
      real(dp), intent(inout), contiguous :: x(:, :) !! (ndim, n_points)
      real(dp) :: turn(ndim, size(c%node))
      integer :: k
      turn = c%turned(x)
      do k = 1, size(c%node)
         associate (i => c%node(k))
            where (c%fixed(:, i)) x(:, i) = values(:, k) + turn(:, k)
         end associate
      end do
      call grid%dofs%distribute(f%mass_matrix%all, ndim, x)
   end subroutine set_prescribed

   !> Set the velocities that move the particles, and the accelerations that lead to them, of fixed components.
   pure subroutine move_prescribed(c, grid, dt, acceleration, f)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: acceleration(:, :) !! `prescribed_acceleration`
      type(nodal_fields_t), intent(inout) :: f
      integer :: k
      call set_prescribed(c, grid, f, acceleration, f%acceleration)
      do k = 1, size(c%node)
         associate (i => c%node(k))
            where (c%fixed(:, i)) f%velocity(:, i, v_next) = f%velocity(:, i, v_n) + dt*f%acceleration(:, i)
         end associate
      end do
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%velocity(:, :, v_next))
   end subroutine move_prescribed

   !> Find the work of moving fixed components: of the force R = M a - f + alpha p, with f without damping and the momentum p. In a
   !> step it is (R(t) + R(t + dt))/2 . w dt; R(t + dt) is known in the next step only: R(t) replaces it until then.
   subroutine find_work(c, grid, dt, damping_rate, f, last, work)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: damping_rate       !! alpha [1/s]
      type(nodal_fields_t), intent(in) :: f
      type(prescribed_work_t), intent(inout) :: last !! of the step before; on return of this one
      real(dp), intent(out) :: work              !! [J]
      real(dp) :: inertia(ndim, size(c%node)), late, now
      integer :: k, d
      inertia = by_mass_at(grid, f%mass_matrix, c%node, f%acceleration)
      late = 0
      now = 0
      do k = 1, size(c%node)
         associate (i => c%node(k))
            do d = 1, ndim
               if (.not. c%fixed(d, i)) cycle
               associate (force => inertia(d, k) - f%force(d, i) + damping_rate*f%momentum(d, i))
                  late = late + force*f%velocity(d, i, v_n)*last%dt
                  now = now + force*f%velocity(d, i, v_next)*dt
               end associate
            end do
         end associate
      end do
      work = (late - last%work)/2 + now
      last = prescribed_work_t(dt, now)
   end subroutine find_work
end module hampm_prescribed_nodes
