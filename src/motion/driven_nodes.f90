!> Nodes that are moved in a given way, in explicit steps: whatever acts on them, in the step from t to t + dt they go from where they
!> are to be at t to where they are to be at t + dt, all of it with one velocity w.
module hampm_driven_nodes
   use hampm_kinds, only: dp, ndim
   use hampm_constraints, only: constraints_t
   use hampm_grid, only: grid_t
   use hampm_nodal_fields, only: nodal_fields_t, v_n, v_next
   implicit none
   private
   public :: driven_work_t, impose, drive

   !> What the constraints did in a step, by the forces at its start.
   type :: driven_work_t
      real(dp) :: dt = 0                         !! its length [s]
      real(dp) :: work = 0                       !! [J]
   end type driven_work_t

contains

   !> Give the fixed components of a velocity that has been found from momentum what they have by their constraints: that of the step
   !> before, or of the present one once that has been driven.
   subroutine impose(c, grid, time, last, f, which)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: time               !! at the start of the step [s]
      type(driven_work_t), intent(in) :: last    !! the last step that was driven
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: which               !! which velocity has been found: `v_n` or `v_mapped`
      real(dp), allocatable :: w(:, :)
      integer :: k
      if (which == v_n) then
         allocate (w, source=c%way(time))
         if (last%dt > 0) then
            w = (w - c%way(time - last%dt))/last%dt
         else
            w = 0
         end if
      else
         allocate (w, source=f%velocity(:, :grid%n_nodes, v_next))
      end if
      do k = 1, size(c%node)
         associate (i => c%node(k))
            where (c%fixed(:, i)) f%velocity(:, i, which) = w(:, i)
         end associate
      end do
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%velocity(:, :, which))
   end subroutine impose

   !> Set the velocities that move the particles, and the accelerations that lead to them, of fixed components, and add the work of
   !> what that takes: with lumped masses the force R = m (w - v)/dt - f. In a step it is (R(t) + R(t + dt))/2 . w dt, of which R(t + dt)
   !> is known in the next step only: until then R(t) stands for it.
   subroutine drive(c, grid, time, dt, f, last, work)
      type(constraints_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: time, dt           !! [s]
      type(nodal_fields_t), intent(inout) :: f
      type(driven_work_t), intent(inout) :: last !! of the step before; on return of this one
      real(dp), intent(inout) :: work            !! [J]
      real(dp), allocatable :: w(:, :)
      real(dp) :: late, now, force
      integer :: k, d
      allocate (w, source=(c%way(time + dt) - c%way(time))/dt)
      late = 0
      now = 0
      do k = 1, size(c%node)
         associate (i => c%node(k))
            do d = 1, ndim
               if (.not. c%fixed(d, i)) cycle
               f%acceleration(d, i) = (w(d, i) - f%velocity(d, i, v_n))/dt
               f%velocity(d, i, v_next) = w(d, i)
               force = f%mass_matrix%lumped(i)*f%acceleration(d, i) - f%force(d, i)
               late = late + force*f%velocity(d, i, v_n)*last%dt
               now = now + force*w(d, i)*dt
            end do
         end associate
      end do
      work = work + (late - last%work)/2 + now
      last = driven_work_t(dt, now)
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%acceleration)
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%velocity(:, :, v_next))
   end subroutine drive
end module hampm_driven_nodes
