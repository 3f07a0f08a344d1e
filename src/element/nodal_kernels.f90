!> Assembly of nodal sums from the contributions of the cells, and the nodal equations with lumped masses,
!>
!>    v = p/m (8), (10),     a = f/m - alpha v (5),     v^(n+1) = v^n + a dt,
!>
!> fixed components being 0: functions of one component of one node. Steps in tiles and in stages differ in the list of nodes, and
!> in whether the sums are assembled on the way.
module hampm_nodal_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: lanes, of_mass, of_momentum, of_force
   implicit none
   private
   public :: assemble_sums, exchange_high_valence, find_masses, find_velocities, find_accelerations, find_kept_velocities, &
             find_kept_accelerations, divide_by_mass, advance_velocities, damping_product, sum_of_products, over_mass, damped

   integer, parameter :: stride = lanes*corners  !! among contributions from one sum to the next

contains

   !> M x = b at a node with a lumped mass: x = b/m, or 0 in a fixed component.
   elemental real(dp) function over_mass(b, inverse_mass, free) result(x)
      real(dp), intent(in) :: b
      real(dp), intent(in) :: inverse_mass       !! 1/m [1/kg]
      real(dp), intent(in) :: free               !! 0 for a fixed component, else 1
      x = (inverse_mass*free)*b
   end function over_mass

   !> The acceleration by all forces, from the one without damping and the damping force -alpha m v [m/s2].
   elemental real(dp) function damped(acceleration, damping_rate, velocity)
      real(dp), intent(in) :: acceleration       !! without damping [m/s2]
      real(dp), intent(in) :: damping_rate       !! alpha [1/s]
      real(dp), intent(in) :: velocity           !! [m/s]
      damped = acceleration - damping_rate*velocity
   end function damped

   !> Sum of the contributions of the cells around a point, always in the order of the cells.
   pure real(dp) function around(contribution, k1, k2, k3, k4, slot)
      real(dp), intent(in) :: contribution(*)
      integer, intent(in) :: k1, k2, k3, k4      !! where the first stand
      integer, intent(in) :: slot(corners)       !! and all
      around = ((contribution(k1) + contribution(k2)) + contribution(k3)) + contribution(k4)
      if (corners > 4) around = around + sum(contribution(slot(5:)))
   end function around

   !> Assemble the sums at some points that are asked for.
   subroutine assemble_sums(n, points, slot, contribution, with_mass, with_momentum, with_force, mass, momentum, force)
      integer, intent(in) :: n, points(n)
      integer, intent(in) :: slot(corners, *)    !! see `cell_blocks_t`, by point
      real(dp), intent(in) :: contribution(*)    !! see `nodal_fields_t`
      logical, intent(in) :: with_mass, with_momentum, with_force
      real(dp), intent(inout) :: mass(*), momentum(ndim, *), force(ndim, *)  !! by point
      integer, parameter :: to_momentum = stride*(of_momentum - of_mass), to_force = stride*(of_force - of_mass)
      integer :: a, i, d, k1, k2, k3, k4
      !$omp parallel do schedule(static) private(i, d, k1, k2, k3, k4)
      !GCC$ novector
      do a = 1, n
         i = points(a)
         k1 = slot(1, i)
         k2 = slot(2, i)
         k3 = slot(3, i)
         k4 = slot(4, i)
         if (with_mass) mass(i) = around(contribution, k1, k2, k3, k4, slot(1, i))
         if (with_momentum) then
            do d = 1, ndim
               momentum(d, i) = around(contribution(1 + to_momentum + stride*(d - 1)), k1, k2, k3, k4, slot(1, i))
            end do
         end if
         if (with_force) then
            do d = 1, ndim
               force(d, i) = around(contribution(1 + to_force + stride*(d - 1)), k1, k2, k3, k4, slot(1, i))
            end do
         end if
      end do
   end subroutine assemble_sums

   !> For nodes with more cells than `slot` has room for: add the contributions of the other cells to the last slot or, if `back`,
   !> restore the last slot.
   pure subroutine exchange_high_valence(high_valence, slot, is_high_valence, nodes, back, contribution, before)
      integer, intent(in) :: high_valence(:, :)  !! see `cell_blocks_t`
      integer, intent(in) :: slot(:, :)          !! (corners, n_points)
      logical, intent(in) :: is_high_valence(:)  !! by node
      integer, intent(in) :: nodes(:)
      logical, intent(in) :: back
      real(dp), intent(inout) :: contribution(*) !! from the first of the sums on that are exchanged
      real(dp), intent(inout) :: before(:, :)    !! (sums, as `high_valence`)
      integer :: j, k, d
      do j = 1, size(nodes)
         if (.not. is_high_valence(nodes(j))) cycle
         do k = 1, size(high_valence, 2)
            if (high_valence(1, k) /= nodes(j)) cycle
            do d = 1, size(before, 1)
               associate (kept => contribution(slot(corners, nodes(j)) + stride*(d - 1)))
                  if (back) then
                     kept = before(d, findloc(high_valence(1, :), nodes(j), dim=1))
                  else
                     before(d, k) = kept
                     kept = kept + contribution(high_valence(2, k) + stride*(d - 1))
                  end if
               end associate
            end do
         end do
      end do
   end subroutine exchange_high_valence

   !> Assemble the masses (9) of some nodes.
   pure subroutine find_masses(n, nodes, slot, contribution, mass, inverse)
      integer, intent(in) :: n, nodes(n), slot(corners, *)
      real(dp), intent(in) :: contribution(*)    !! from the masses on
      real(dp), intent(inout) :: mass(*), inverse(*)    !! [kg], [1/kg], by point
      integer :: j
      !GCC$ novector
      do j = 1, n
         associate (i => nodes(j))
            mass(i) = around(contribution, slot(1, i), slot(2, i), slot(3, i), slot(4, i), slot(1, i))
            inverse(i) = 1/mass(i)
         end associate
      end do
   end subroutine find_masses

   !> Assemble the momenta of some nodes and find their velocities.
   pure subroutine find_velocities(n, nodes, slot, contribution, free, inverse, velocity)
      integer, intent(in) :: n, nodes(n), slot(corners, *)
      real(dp), intent(in) :: contribution(*)    !! from the momenta on
      real(dp), intent(in) :: free(ndim, *), inverse(*)
      real(dp), intent(inout) :: velocity(ndim, *)      !! [m/s], by point
      integer :: j, i, d, k1, k2, k3, k4
      !GCC$ novector
      do j = 1, n
         i = nodes(j)
         k1 = slot(1, i)
         k2 = slot(2, i)
         k3 = slot(3, i)
         k4 = slot(4, i)
         do d = 1, ndim
            velocity(d, i) = over_mass(around(contribution(1 + stride*(d - 1)), k1, k2, k3, k4, slot(1, i)), inverse(i), free(d, i))
         end do
      end do
   end subroutine find_velocities

   !> Assemble the forces of some nodes and find their accelerations and new velocities.
   pure subroutine find_accelerations(n, nodes, slot, contribution, dt, damping_rate, free, inverse, external, v_n, acceleration, &
                                      v_next)
      integer, intent(in) :: n, nodes(n), slot(corners, *)
      real(dp), intent(in) :: contribution(*)    !! from the forces on
      real(dp), intent(in) :: dt, damping_rate, free(ndim, *), inverse(*), external(ndim, *), v_n(ndim, *)
      real(dp), intent(inout) :: acceleration(ndim, *), v_next(ndim, *)  !! by point
      integer :: j, i, d, k1, k2, k3, k4
      !GCC$ novector
      do j = 1, n
         i = nodes(j)
         k1 = slot(1, i)
         k2 = slot(2, i)
         k3 = slot(3, i)
         k4 = slot(4, i)
         do d = 1, ndim
            acceleration(d, i) = damped(over_mass(around(contribution(1 + stride*(d - 1)), k1, k2, k3, k4, slot(1, i)) &
                                                  + external(d, i), inverse(i), free(d, i)), damping_rate, v_n(d, i))
            v_next(d, i) = v_n(d, i) + dt*acceleration(d, i)
         end do
      end do
   end subroutine find_accelerations

   !> Find the velocities of points numbered on that keep their momenta.
   pure subroutine find_kept_velocities(n, mobility, momentum, velocity)
      integer, intent(in) :: n                   !! components of the points
      real(dp), intent(in) :: mobility(n)        !! 1/m, or 0 in a fixed component [1/kg]
      real(dp), intent(in) :: momentum(n)        !! [kg m/s]
      real(dp), intent(inout) :: velocity(n)     !! [m/s]
      integer :: i
      !$omp simd
      do i = 1, n
         velocity(i) = mobility(i)*momentum(i)
      end do
   end subroutine find_kept_velocities

   !> Find the accelerations and new velocities of points numbered on that keep their forces.
   pure subroutine find_kept_accelerations(n, dt, damping_rate, mobility, force, external, v_n, acceleration, v_next)
      integer, intent(in) :: n                   !! components of the points
      real(dp), intent(in) :: dt, damping_rate, mobility(n), force(n), external(n), v_n(n)
      real(dp), intent(inout) :: acceleration(n), v_next(n)
      integer :: i
      !$omp simd
      do i = 1, n
         acceleration(i) = mobility(i)*(force(i) + external(i))
      end do
      if (damping_rate > 0) acceleration = damped(acceleration, damping_rate, v_n)
      !$omp simd
      do i = 1, n
         v_next(i) = v_n(i) + dt*acceleration(i)
      end do
   end subroutine find_kept_accelerations

   !> Solve M x = b with the lumped masses at some nodes.
   subroutine divide_by_mass(n, nodes, free, inverse, b, x)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: free(ndim, *), inverse(*), b(ndim, *)
      real(dp), intent(inout) :: x(ndim, *)
      integer :: j
      !$omp parallel do schedule(static)
      !GCC$ novector
      do j = 1, n
         x(:, nodes(j)) = over_mass(b(:, nodes(j)), inverse(nodes(j)), free(:, nodes(j)))
      end do
   end subroutine divide_by_mass

   !> Damp the accelerations of some points and find their new velocities and, where wanted, their contributions to the powers of
   !> `accelerate`.
   pure subroutine advance_velocities(n, nodes, damping_rate, dt, with_power, momentum, force, v_n, acceleration, v_next, power)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: damping_rate, dt, momentum(ndim, *), force(ndim, *), v_n(ndim, *)
      logical, intent(in) :: with_power
      real(dp), intent(inout) :: acceleration(ndim, *), v_next(ndim, *)
      real(dp), intent(out) :: power(2)
      real(dp) :: a(ndim), v(ndim)
      integer :: k, i, d
      power = 0
      !GCC$ novector
      do k = 1, n
         i = nodes(k)
         a = damped(acceleration(:, i), damping_rate, v_n(:, i))
         v = v_n(:, i) + dt*a
         acceleration(:, i) = a
         v_next(:, i) = v
         if (.not. with_power) cycle
         do d = 1, ndim
            power(1) = power(1) + momentum(d, i)*v(d)
            power(2) = power(2) + dt*(force(d, i) - damping_rate*momentum(d, i))*a(d) - force(d, i)*v(d)
         end do
      end do
   end subroutine advance_velocities

   !> Sum of a . b over some nodes.
   pure real(dp) function sum_of_products(n, nodes, a, b) result(total)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: a(ndim, *), b(ndim, *)
      integer :: j
      total = 0
      do j = 1, n
         associate (i => nodes(j))
            total = total + sum(a(:, i)*b(:, i))
         end associate
      end do
   end function sum_of_products

   !> Sum of m v^n . v^(n+1) over some nodes: the dissipation of damping, over its rate and dt [J].
   pure real(dp) function damping_product(n, nodes, mass, v_n, v_next) result(total)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: mass(*), v_n(ndim, *), v_next(ndim, *)
      integer :: j
      total = 0
      do j = 1, n
         associate (i => nodes(j))
            total = total + mass(i)*sum(v_n(:, i)*v_next(:, i))
         end associate
      end do
   end function damping_product
end module hampm_nodal_kernels
