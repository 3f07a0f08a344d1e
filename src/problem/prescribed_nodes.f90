!> Nodes of prescribed motion, in explicit steps: whatever acts on them, in the step from t to t + dt they go from where they
!> are to be at t to where they are to be at t + dt, all of it with one velocity w.
module hampm_prescribed_nodes
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constraints_t
   use hampm_grid, only: grid_t
   use hampm_mass_product, only: by_mass
   use hampm_nodal_fields, only: nodal_fields_t, v_n, v_next
   implicit none
   private
   public :: prescribed_work_t, prescribed_velocity, prescribed_acceleration, move_prescribed, find_work

   !> What the constraints did in a step, by the forces at its start.
   type :: prescribed_work_t
      real(dp) :: dt = 0                         !! its length [s]
      real(dp) :: work = 0                       !! [J]
   end type prescribed_work_t

contains

   !> The velocities of fixed components by their constraints, 0 of others [m/s], (ndim, n_points): for `v_n` that of the step before, else of the present
   !> one, which is prescribed.
   pure function prescribed_velocity(c, grid, time, last, f, which) result(v)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: time               !! at the start of the step [s]
      type(prescribed_work_t), intent(in) :: last !! the last step with prescribed motion
      type(nodal_fields_t), intent(in) :: f
      integer, intent(in) :: which               !! which velocity has been found: `v_n` or `v_mapped`
      real(dp), allocatable :: v(:, :), w(:, :)
      allocate (v(ndim, grid%n_points), w(ndim, grid%n_nodes))
      w = 0
      if (which /= v_n) then
         w = f%velocity(:, :grid%n_nodes, v_next)
      else if (last%dt > 0) then
         w = (c%prescribed_at(time) - c%prescribed_at(time - last%dt))/last%dt
      end if
      v = on_prescribed(c, grid, f, w)
   end function prescribed_velocity

   !> The accelerations of fixed components in a step from t to t + dt, 0 of others [m/s2], (ndim, n_points).
   pure function prescribed_acceleration(c, grid, time, dt, f) result(a)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: time, dt           !! [s]
      type(nodal_fields_t), intent(in) :: f
      real(dp), allocatable :: a(:, :)
      allocate (a(ndim, grid%n_points))
      a = on_prescribed(c, grid, f, ((c%prescribed_at(time + dt) - c%prescribed_at(time))/dt &
                                     - f%velocity(:, :grid%n_nodes, v_n))/dt)
   end function prescribed_acceleration

   !> What fixed components have of some values; 0 of others.
   pure function on_prescribed(c, grid, f, x) result(y)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(in) :: f
      real(dp), intent(in) :: x(:, :)            !! (ndim, n_nodes)
      real(dp), allocatable :: y(:, :)
      integer :: k
      allocate (y(ndim, grid%n_points))
      y = 0
      do k = 1, size(c%node)
         associate (i => c%node(k))
            where (c%fixed(:, i)) y(:, i) = x(:, i)
         end associate
      end do
      call grid%dofs%distribute(f%mass_matrix%all, ndim, y)
   end function on_prescribed

   !> Set the velocities that move the particles, and the accelerations that lead to them, of fixed components.
   subroutine move_prescribed(c, grid, dt, prescribed, f)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: prescribed(:, :)   !! `prescribed_acceleration`
      type(nodal_fields_t), intent(inout) :: f
      integer :: k
      do k = 1, size(c%node)
         associate (i => c%node(k))
            where (c%fixed(:, i)) f%acceleration(:, i) = prescribed(:, i)
            where (c%fixed(:, i)) f%velocity(:, i, v_next) = f%velocity(:, i, v_n) + dt*prescribed(:, i)
         end associate
      end do
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%acceleration)
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%velocity(:, :, v_next))
   end subroutine move_prescribed

   !> Find the work of what moves fixed components: the force R = M a - f + alpha p, f being the force without damping and p the momentum. In a step
   !> it is (R(t) + R(t + dt))/2 . w dt, of which R(t + dt) is known in the next step only: until then R(t) stands for it.
   subroutine find_work(c, grid, dt, damping_rate, f, last, work)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: damping_rate       !! alpha [1/s]
      type(nodal_fields_t), intent(in) :: f
      type(prescribed_work_t), intent(inout) :: last !! of the step before; on return of this one
      real(dp), intent(out) :: work              !! [J]
      real(dp), allocatable :: inertia(:, :)
      real(dp) :: late, now
      integer :: k, d
      allocate (inertia, source=by_mass(grid, f%mass_matrix, f%acceleration))
      late = 0
      now = 0
      do k = 1, size(c%node)
         associate (i => c%node(k))
            do d = 1, ndim
               if (.not. c%fixed(d, i)) cycle
               associate (force => inertia(d, i) - f%force(d, i) + damping_rate*f%momentum(d, i))
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
