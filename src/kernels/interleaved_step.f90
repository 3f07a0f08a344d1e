!> The step with interleaved particles (`hampm_interleaved`), tile by tile (`hampm_tiling`).
!>
!> A batch of blocks adds what it gives to the sums at its nodes, and a node that takes a sum sets it back to zero. In a tile and in
!> a region that is one after the other. What several regions share comes after them, on one thread, so that no two add at once
!> to a node, and always in the same order.
module hampm_interleaved_step
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: lanes, of_mass, of_momentum, of_force, n_sums
   use hampm_interleaved, only: interleaved_t
   use hampm_interleaved_kernels, only: pass_over_rows, most_blocks, largest_rounding
   use hampm_mass_matrix, only: nodes_per_chunk
   use hampm_nodal_fields, only: v_n, v_next, v_mapped
   use hampm_nodal_kernels, only: over_mass, damped
   use hampm_pass, only: pass_t, scheme_t
   implicit none
   private
   public :: step_interleaved, map_interleaved

   integer, parameter :: nodes_at_a_time = 256   !! that a thread does, of those of no region

contains

   !> Map what a step begins with.
   subroutine map_interleaved(scheme, self)
      type(scheme_t), intent(in) :: scheme
      type(interleaved_t), intent(inout) :: self
      integer :: b
      call pass_blocks(scheme%map_at_start, 0.0_dp, [(b, b=1, self%blocks%n)], self)
   end subroutine map_interleaved

   !> Do the nodal sums and the passes of a step.
   subroutine step_interleaved(scheme, dt, damping_rate, self, damping_loss)
      type(scheme_t), intent(in) :: scheme
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(in) :: damping_rate       !! alpha of the force -alpha m v [1/s]
      type(interleaved_t), intent(inout) :: self
      real(dp), intent(out) :: damping_loss      !! what the damping takes, dt sum alpha m v^n . v^(n+1) [J]
      integer :: region, tile, s, k
      associate (plan => self%plan)
         associate (shared => plan%stages(1))
            !$omp parallel do schedule(static)
            do k = shared%start(0), shared%start(1) - 1, nodes_at_a_time
               call do_items(1, k, min(k + nodes_at_a_time, shared%start(1)) - 1)
            end do
         end associate
         !$omp parallel do schedule(static, 1) private(tile, s)
         do region = 1, plan%n_regions
            do tile = plan%first_tile(region), plan%first_tile(region + 1) - 1
               do s = 1, size(plan%stages)
                  call do_items(s, plan%stages(s)%start(tile), plan%stages(s)%start(tile + 1) - 1)
               end do
            end do
         end do
         do s = 1, size(plan%stages)
            call do_items(s, plan%stages(s)%start(plan%n_tiles + 1), plan%stages(s)%start(plan%n_tiles + 2) - 1)
         end do
      end associate
      damping_loss = 0
      if (damping_rate > 0) damping_loss = dt*damping_rate*sum_of_damping(dt, self)
   contains
      !> Do some items of a stage.
      subroutine do_items(s, first, last)
         integer, intent(in) :: s, first, last
         if (last < first) return
         associate (items => self%plan%stages(s)%item)
            if (mod(s, 2) == 0) then
               call pass_blocks(scheme%passes(s/2), dt, items(first:last), self)
            else
               call do_nodes(scheme, s, damping_rate, items(first:last), self)
            end if
         end associate
      end subroutine do_items
   end subroutine step_interleaved

   !> Do a stage of listed nodes, in stretches that are numbered on.
   subroutine do_nodes(scheme, stage, damping_rate, listed, self)
      type(scheme_t), intent(in) :: scheme
      integer, intent(in) :: stage
      real(dp), intent(in) :: damping_rate
      integer, intent(in) :: listed(:)           !! ascending
      type(interleaved_t), intent(inout) :: self
      integer :: first, last
      logical :: with_velocity, with_force
      if (stage == 1) then
         with_velocity = .true.
         with_force = scheme%map_at_start%map_force
      else
         with_velocity = scheme%passes(stage/2)%map_momentum
         with_force = scheme%passes(stage/2)%map_force
      end if
      first = 1
      do while (first <= size(listed))
         last = first
         do while (last < size(listed))
            if (listed(last + 1) /= listed(last) + 1) exit
            last = last + 1
         end do
         call do_stretch(listed(first), last - first + 1)
         first = last + 1
      end do
   contains
      !> Do nodes that are numbered on, and those of them that are fixed.
      subroutine do_stretch(i, n)
         integer, intent(in) :: i, n             !! the first, and how many
         integer :: d, k
         if (stage == 1) call invert(n, self%mass(i), self%inverse_mass(i))
         do d = 1, ndim
            if (with_velocity .and. stage == 1) &
               call find_velocities(n, self%inverse_mass(i), self%momentum(i, d), self%velocity(i, d))
            if (with_velocity .and. stage > 1) &
               call find_velocities(n, self%inverse_mass(i), self%momentum(i, d), self%remapped(i, d))
            if (with_force) call find_accelerations(n, damping_rate, self%inverse_mass(i), self%velocity(i, d), &
                                                    self%force(i, d), self%acceleration(i, d))
         end do
         do k = first_not_before(i, self%fixed), size(self%fixed)
            if (self%fixed(k) >= i + n) exit
            do d = 1, ndim
               if (.not. self%is_fixed(d, k)) cycle
               self%velocity(self%fixed(k), d) = 0
               self%acceleration(self%fixed(k), d) = 0
               if (stage > 1 .and. with_velocity) self%remapped(self%fixed(k), d) = 0
            end do
         end do
      end subroutine do_stretch
   end subroutine do_nodes

   !> Where among ascending numbers the first is that is not smaller than another one.
   pure integer function first_not_before(number, ascending) result(low)
      integer, intent(in) :: number, ascending(:)
      integer :: high, middle
      low = 1
      high = size(ascending) + 1
      do while (low < high)
         middle = (low + high)/2
         if (ascending(middle) < number) then
            low = middle + 1
         else
            high = middle
         end if
      end do
   end function first_not_before

   !> Take the masses of some nodes.
   pure subroutine invert(n, mass, inverse)
      integer, intent(in) :: n
      real(dp), intent(inout) :: mass(n), inverse(n)
      integer :: i
      !$omp simd
      do i = 1, n
         inverse(i) = merge(1/max(mass(i), tiny(mass)), 0.0_dp, mass(i) > 0)
         mass(i) = 0
      end do
   end subroutine invert

   !> Take one component of the momenta of some nodes, and find their velocities.
   pure subroutine find_velocities(n, inverse, momentum, velocity)
      integer, intent(in) :: n
      real(dp), intent(in) :: inverse(n)
      real(dp), intent(inout) :: momentum(n), velocity(n)
      integer :: i
      !$omp simd
      do i = 1, n
         velocity(i) = over_mass(momentum(i), inverse(i), 1.0_dp)
         momentum(i) = 0
      end do
   end subroutine find_velocities

   !> Take one component of the forces of some nodes, and find their accelerations.
   pure subroutine find_accelerations(n, damping_rate, inverse, v_n, force, acceleration)
      integer, intent(in) :: n
      real(dp), intent(in) :: damping_rate, inverse(n), v_n(n)
      real(dp), intent(inout) :: force(n), acceleration(n)
      integer :: i
      !$omp simd
      do i = 1, n
         acceleration(i) = damped(over_mass(force(i), inverse(i), 1.0_dp), damping_rate, v_n(i))
         force(i) = 0
      end do
   end subroutine find_accelerations

   !> Do a pass over listed blocks, in batches of those that follow each other and are alike.
   subroutine pass_blocks(pass, dt, listed, self)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      integer, intent(in) :: listed(:)           !! ascending
      type(interleaved_t), intent(inout) :: self
      real(dp), dimension(lanes, corners, ndim, most_blocks) :: kick_by, strain_by, move_by
      real(dp) :: contribution(lanes, corners, n_sums, most_blocks), beyond(lanes, most_blocks), zeros(lanes)
      integer :: j, n, b
      zeros = 0
      j = 1
      do while (j <= size(listed))
         b = listed(j)
         n = length_of_batch()
         if (self%blocks%rows(b) > 0) call do_batch(self%corner(b))
         j = j + n
      end do
   contains
      !> How many of the listed blocks can be done together from the present one on.
      pure integer function length_of_batch() result(length)
         length = 1
         associate (blocks => self%blocks)
            do while (length < most_blocks .and. j + length <= size(listed))
               associate (next => listed(j + length))
                  if (next /= b + length) exit
                  if (blocks%rows(next) /= blocks%rows(b) .or. self%room(next) /= self%room(b) &
                      .or. blocks%first(next) /= blocks%first(b) + length*self%room(b) &
                      .or. self%rows_of_constants(next) /= self%rows_of_constants(b)) exit
               end associate
               length = length + 1
            end do
         end associate
      end function length_of_batch

      !> Do a batch.
      subroutine do_batch(corner)
         integer, intent(in) :: corner(n)        !! the lower left node of each block
         integer :: k, d
         associate (stride => self%stride, by => pass%strain_fraction*dt*self%inverse_size)
            do d = 1, ndim
               associate (v => self%velocity(:, d), a => self%acceleration(:, d))
                  if (pass%kick) call take(n, corner, stride, d, dt, a, kick_by)
                  if (pass%move) call take_sum(n, corner, stride, d, dt, v, dt**2, a, move_by)
                  if (pass%strain_fraction > 0) then
                     if (pass%strain_by == v_n) call take(n, corner, stride, d, by, v, strain_by)
                     if (pass%strain_by == v_mapped) call take(n, corner, stride, d, by, self%remapped(1, d), strain_by)
                     if (pass%strain_by == v_next) call take_sum(n, corner, stride, d, by, v, by*dt, a, strain_by)
                  end if
               end associate
            end do
            call pass_over_rows(pass, n, self%blocks%rows(b), self%room(b), self%inverse_size, zeros, kick_by, strain_by, move_by, &
                                self%rows_of_constants(b), self%constant(1, 1, self%first_constant(b)), &
                                self%row(1, 1, self%blocks%first(b)), contribution, beyond)
            if (pass%map_mass) call add_to_nodes(n, corner, stride, contribution(1, 1, of_mass, 1), self%mass)
            do d = 1, ndim
               if (pass%map_momentum) call add_to_nodes(n, corner, stride, contribution(1, 1, of_momentum + d - 1, 1), &
                                                        self%momentum(1, d))
               if (pass%map_force) call add_to_nodes(n, corner, stride, contribution(1, 1, of_force + d - 1, 1), self%force(1, d))
            end do
         end associate
         if (.not. pass%move) return
         do k = 1, n
            self%left(b + k - 1) = .not. all(beyond(:, k) <= largest_rounding)
         end do
      end subroutine do_batch
   end subroutine pass_blocks

   !> The polynomials of one component of a nodal field in the cells of a batch, times a factor.
   pure subroutine take(n, corner, stride, d, factor, field, a)
      integer, intent(in) :: n, corner(n)        !! blocks, and the lower left node of each
      integer, intent(in) :: stride              !! from a node to the one above it
      integer, intent(in) :: d                   !! the component
      real(dp), intent(in) :: factor, field(*)   !! by node
      real(dp), intent(inout) :: a(lanes, corners, ndim, n)
      integer :: k
      do k = 1, n
         call take_lanes(factor, field(corner(k)), field(corner(k) + stride), a(1, 1, d, k))
      end do
   end subroutine take

   !> The same of the sum of two fields, each times a factor.
   pure subroutine take_sum(n, corner, stride, d, factor, field, second_factor, second, a)
      integer, intent(in) :: n, corner(n), stride, d
      real(dp), intent(in) :: factor, field(*), second_factor, second(*)
      real(dp), intent(inout) :: a(lanes, corners, ndim, n)
      real(dp) :: f1, f2, f3, f4
      integer :: k, l
      do k = 1, n
         associate (i => corner(k) - 1, j => corner(k) - 1 + stride)
            !$omp simd private(f1, f2, f3, f4)
            do l = 1, lanes
               f1 = factor*field(i + l) + second_factor*second(i + l)
               f2 = factor*field(i + l + 1) + second_factor*second(i + l + 1)
               f3 = factor*field(j + l) + second_factor*second(j + l)
               f4 = factor*field(j + l + 1) + second_factor*second(j + l + 1)
               a(l, 1, d, k) = f1
               a(l, 2, d, k) = f2 - f1
               a(l, 3, d, k) = f3 - f1
               a(l, 4, d, k) = (f4 - f3) - (f2 - f1)
            end do
         end associate
      end do
   end subroutine take_sum

   !> The polynomials a1 + a2 xi + a3 eta + a4 xi eta of one component of a nodal field in the cells of a block, times a factor,
   !> from the nodes at its lower and at its upper edge, each numbered on.
   pure subroutine take_lanes(factor, lower, upper, a)
      real(dp), intent(in) :: factor, lower(lanes + 1), upper(lanes + 1)
      real(dp), intent(out) :: a(lanes, corners)
      real(dp) :: f1, f2, f3, f4
      integer :: l
      !$omp simd private(f1, f2, f3, f4)
      do l = 1, lanes
         f1 = factor*lower(l)
         f2 = factor*lower(l + 1)
         f3 = factor*upper(l)
         f4 = factor*upper(l + 1)
         a(l, 1) = f1
         a(l, 2) = f2 - f1
         a(l, 3) = f3 - f1
         a(l, 4) = (f4 - f3) - (f2 - f1)
      end do
   end subroutine take_lanes

   !> Add what a batch gives to one sum at its nodes. A sum that is loaded right after a part of it was stored would have to wait: so
   !> corner by corner over all blocks.
   pure subroutine add_to_nodes(n, corner, stride, contribution, sums)
      integer, intent(in) :: n, corner(n), stride
      real(dp), intent(in) :: contribution(lanes, corners, n_sums, *)   !! from the wanted sum on
      real(dp), intent(inout) :: sums(*)         !! by node
      integer :: k
      do k = 1, n
         call add_lanes(contribution(1, 1, 1, k), sums(corner(k)))
      end do
      do k = 1, n
         call add_lanes(contribution(1, 3, 1, k), sums(corner(k) + stride))
      end do
      do k = 1, n
         call add_lanes(contribution(1, 2, 1, k), sums(corner(k) + 1))
      end do
      do k = 1, n
         call add_lanes(contribution(1, 4, 1, k), sums(corner(k) + stride + 1))
      end do
   end subroutine add_to_nodes

   !> Add what the lanes of a block give to as many nodes that are numbered on.
   pure subroutine add_lanes(given, sums)
      real(dp), intent(in) :: given(lanes)
      real(dp), intent(inout) :: sums(lanes)
      integer :: l
      !$omp simd
      do l = 1, lanes
         sums(l) = sums(l) + given(l)
      end do
   end subroutine add_lanes

   !> Sum of m v^n . v^(n+1) over the nodes [J], always in the same order.
   real(dp) function sum_of_damping(dt, self) result(total)
      real(dp), intent(in) :: dt                 !! [s]
      type(interleaved_t), intent(in) :: self
      real(dp), allocatable :: part(:)
      integer :: k, i
      allocate (part((self%blocks%n_points - 1)/nodes_per_chunk + 1), source=0.0_dp)
      !$omp parallel do schedule(static) private(i)
      do k = 1, size(part)
         do i = (k - 1)*nodes_per_chunk + 1, min(k*nodes_per_chunk, self%blocks%n_points)
            if (.not. self%inverse_mass(i) > 0) cycle
            part(k) = part(k) + sum(self%velocity(i, :)*(self%velocity(i, :) + dt*self%acceleration(i, :)))/self%inverse_mass(i)
         end do
      end do
      total = sum(part)
   end function sum_of_damping
end module hampm_interleaved_step
