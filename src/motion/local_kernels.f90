!> What local time steps (`hampm_local_steps`) do at some nodes, and at the corners of a block of cells.
module hampm_local_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_nodal_fields, only: around, stride
   use hampm_particles, only: lanes
   implicit none
   private
   public :: gather_at, push_some, divide_some, clear, sum_kick, sum_way

contains

   !> Sum the shares of the cells in a vector at some points.
   subroutine gather_at(n, points, slot, share, nodal)
      integer, intent(in) :: n, points(n), slot(corners, *)
      real(dp), intent(in) :: share(*)                  !! from the first component on
      real(dp), intent(inout) :: nodal(ndim, *)         !! by point
      integer :: a, d
      !$omp parallel do schedule(static) private(d)
      do a = 1, n
         associate (k => slot(:, points(a)))
            do d = 1, ndim
               nodal(d, points(a)) = around(share(1 + stride*(d - 1)), k(1), k(2), k(3), k(4))
            end do
         end associate
      end do
   end subroutine gather_at

   !> As `push_nodes` for some nodes: their accelerations, and how far they carry particles.
   pure subroutine push_some(n, nodes, turn, dt, damping_rate, free, inverse, force_rate, velocity_rate, n_loads, factor, load, &
                             n_points, force, velocity, acceleration, way)
      integer, intent(in) :: n, nodes(n), turn, force_rate(*), velocity_rate(*), n_loads, n_points
      real(dp), intent(in) :: dt, damping_rate, free(ndim, *), inverse(*), factor(n_loads, 0:*), load(ndim, n_points, n_loads)
      real(dp), intent(in) :: force(ndim, *), velocity(ndim, *)
      real(dp), intent(inout) :: acceleration(ndim, *)
      real(dp), intent(inout) :: way(ndim, *)           !! [m/s], to be multiplied by dt
      real(dp) :: total(ndim), after(ndim), interval
      integer :: k, i, l
      do k = 1, n
         i = nodes(k)
         after = velocity(:, i)
         if (force_rate(i) <= turn) then
            interval = 2**force_rate(i)
            total = force(:, i)
            do l = 1, n_loads
               total = total + interval*(factor(l, force_rate(i))*load(:, i, l))
            end do
            acceleration(:, i) = free(:, i)*(total*inverse(i)) - interval*damping_rate*velocity(:, i)
            after = after + dt*acceleration(:, i)
         end if
         way(:, i) = way(:, i) + 2**velocity_rate(i)*after
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
   pure subroutine divide_some(n, nodes, turn, free, inverse, lumped, force_rate, momentum, velocity, acceleration, power)
      integer, intent(in) :: n, nodes(n), turn, force_rate(*)
      real(dp), intent(in) :: free(ndim, *), inverse(*), lumped(*), momentum(ndim, *)
      real(dp), intent(inout) :: velocity(ndim, *), acceleration(ndim, *)
      real(dp), intent(out) :: power
      real(dp) :: w(ndim)
      integer :: k, i
      power = 0
      do k = 1, n
         i = nodes(k)
         w = free(:, i)*(momentum(:, i)*inverse(i))
         if (force_rate(i) <= turn) &
            power = power + 2**force_rate(i)*(0.5_dp*lumped(i))*dot_product(velocity(:, i), velocity(:, i) + w)
         velocity(:, i) = w
      end do
      call clear(n, nodes, acceleration)
   end subroutine divide_some

   !> Set a field to zero at some points.
   pure subroutine clear(n, points, field)
      integer, intent(in) :: n, points(n)
      real(dp), intent(inout) :: field(ndim, *)
      integer :: k
      do k = 1, n
         field(:, points(k)) = 0
      end do
   end subroutine clear

   !> Sum the velocities of the corners of a block up, each as many times as it acts for dt.
   pure subroutine sum_way(turn, velocity_rate, velocity, nodes, way)
      integer, intent(in) :: turn, velocity_rate(*), nodes(corners, lanes)
      real(dp), intent(in) :: velocity(ndim, *)
      real(dp), intent(inout) :: way(ndim, corners, lanes)
      integer :: l, c
      do l = 1, lanes
         do c = 1, corners
            associate (i => nodes(c, l))
               if (velocity_rate(i) <= turn) way(:, c, l) = way(:, c, l) + 2**velocity_rate(i)*velocity(:, i)
            end associate
         end do
      end do
   end subroutine sum_way
end module hampm_local_kernels
