!> What subcycling (`hampm_subcycled`) does at some nodes, and at the corners of a block of cells.
module hampm_subcycling_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: lanes
   use hampm_nodal_kernels, only: over_mass, damped
   implicit none
   private
   public :: add_impulses, push_some, divide_some, sum_kick, sum_way

contains

   !> Add the impulses of a load over the intervals of some nodes to the forces there.
   pure subroutine add_impulses(n, nodes, turn, force_interval, factor, load, force)
      integer, intent(in) :: n, nodes(n), turn, force_interval(*)
      real(dp), intent(in) :: factor(0:turn)            !! mean factor of the load in each interval
      real(dp), intent(in) :: load(ndim, *)             !! nodal forces with a factor of 1 [N]
      real(dp), intent(inout) :: force(ndim, *)
      integer :: k
      do k = 1, n
         associate (i => nodes(k))
            if (force_interval(i) <= turn) force(:, i) = force(:, i) + 2**force_interval(i)*(factor(force_interval(i))*load(:, i))
         end associate
      end do
   end subroutine add_impulses

   !> As `push_nodes` for some nodes: their accelerations, and how far they carry particles.
   pure subroutine push_some(n, nodes, turn, dt, damping_rate, free, inverse, force_interval, velocity_interval, force, velocity, &
                             acceleration, way)
      integer, intent(in) :: n, nodes(n), turn, force_interval(*), velocity_interval(*)
      real(dp), intent(in) :: dt, damping_rate, free(ndim, *), inverse(*), force(ndim, *), velocity(ndim, *)
      real(dp), intent(inout) :: acceleration(ndim, *)
      real(dp), intent(inout) :: way(ndim, *)           !! [m/s], to be multiplied by dt
      real(dp) :: after(ndim)
      integer :: k, i
      do k = 1, n
         i = nodes(k)
         after = velocity(:, i)
         if (force_interval(i) <= turn) then
            acceleration(:, i) = damped(over_mass(force(:, i), inverse(i), free(:, i)), 2**force_interval(i)*damping_rate, &
                                        velocity(:, i))
            after = after + dt*acceleration(:, i)
         end if
         way(:, i) = way(:, i) + 2**velocity_interval(i)*after
      end do
   end subroutine push_some

   !> Sum the accelerations of the nodes up at the corners of a block, and map what its particles will have by them.
   pure subroutine sum_kick(dt, acceleration, nodes, matrix, kick, momentum)
      real(dp), intent(in) :: dt, acceleration(ndim, *)
      integer, intent(in) :: nodes(corners, lanes)
      real(dp), intent(in) :: matrix(lanes, corners, corners)
      real(dp), intent(inout) :: kick(ndim, corners, lanes), momentum(lanes, corners, ndim)
      real(dp) :: a(lanes)
      integer :: l, c, j, d
      do j = 1, corners
         do d = 1, ndim
            do l = 1, lanes
               a(l) = acceleration(d, nodes(j, l))
               kick(d, j, l) = kick(d, j, l) + a(l)
            end do
            do c = 1, corners
               momentum(:, c, d) = momentum(:, c, d) + matrix(:, c, j)*(dt*a)
            end do
         end do
      end do
   end subroutine sum_kick

   !> As `find_velocities` for some nodes. The power of the damping over its rate is sum 2**n D w . (w + w')/2, w' being the new
   !> velocity [kg m2/s2]: by the mean velocity, as forces of different times only balance each other over a longest interval.
   pure subroutine divide_some(n, nodes, turn, free, inverse, lumped, force_interval, momentum, velocity, acceleration, power)
      integer, intent(in) :: n, nodes(n), turn, force_interval(*)
      real(dp), intent(in) :: free(ndim, *), inverse(*), lumped(*), momentum(ndim, *)
      real(dp), intent(inout) :: velocity(ndim, *), acceleration(ndim, *)
      real(dp), intent(out) :: power
      real(dp) :: w(ndim)
      integer :: k, i
      power = 0
      do k = 1, n
         i = nodes(k)
         w = over_mass(momentum(:, i), inverse(i), free(:, i))
         if (force_interval(i) <= turn) &
            power = power + 2**force_interval(i)*(0.5_dp*lumped(i))*dot_product(velocity(:, i), velocity(:, i) + w)
         velocity(:, i) = w
         acceleration(:, i) = 0
      end do
   end subroutine divide_some

   !> Sum the velocities of the corners of a block up, each as many times as it acts for dt.
   pure subroutine sum_way(turn, velocity_interval, velocity, nodes, way)
      integer, intent(in) :: turn, velocity_interval(*), nodes(corners, lanes)
      real(dp), intent(in) :: velocity(ndim, *)
      real(dp), intent(inout) :: way(ndim, corners, lanes)
      integer :: l, c
      do l = 1, lanes
         do c = 1, corners
            associate (i => nodes(c, l))
               if (velocity_interval(i) <= turn) way(:, c, l) = way(:, c, l) + 2**velocity_interval(i)*velocity(:, i)
            end associate
         end do
      end do
   end subroutine sum_way
end module hampm_subcycling_kernels
