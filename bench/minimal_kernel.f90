!> The least that a plain model needs a step: MUSL, lumped mass, updated frame, bilinear, one linear elastic material, any number
!> of particles a cell, which may move to other cells. One thread. See docs/evidence/performance.md.
!>
!> Cells stand in blocks of `w` neighbours in the order of the grid, and the particles of a block in rows: row s holds the s-th
!> particle of each of the w cells, side by side. So the loop over the cells of a block is the vector loop. It
!> reads and writes with unit stride, and sums over the particles of a cell stay in registers. A cell with fewer particles than
!> its block has rows has empty places at its end: their mass is zero and they stay as they are. w = 1 is the plain loop over
!> the particles of one cell after the other.
module hampm_minimal_kernel
   use hampm_kinds, only: dp, long, ndim, corners
   use hampm_basis, only: edge_margin
   use hampm_dofs, only: element_of_slot, corner_of_slot
   use hampm_grid, only: grid_t
   use hampm_problem, only: problem_t
   implicit none
   private
   public :: blocks_t, set_up, step, place_of, energy, w, bytes

   integer, parameter :: w = 4                       !! lanes: cells of a block
   integer, parameter :: tile = 128                  !! blocks of a tile: its particles fit into the second cache
   integer, parameter :: columns = 12                !! X1 X2 u1 u2 v1 v2 H11 H21 H12 H22 m V
   integer, parameter :: sums = 5*corners            !! of a cell: mass, two momenta, two forces; corner by corner

   !> Items of which those from start(t) to start(t + 1) - 1 belong to the tile t.
   type :: list_t
      integer, allocatable :: start(:), item(:)
   end type list_t

   !> Particles in blocks, and the grid as the kernels need it.
   type :: blocks_t
      integer :: n = 0                               !! blocks
      integer :: free = 0                            !! first place that belongs to no block
      integer, allocatable :: first(:), rows(:), room(:) !! of each block: place before its first, rows used, rows
      integer, allocatable :: count_of(:)            !! particles of each cell
      real(dp), allocatable :: p(:, :)               !! particles, (places, columns)
      integer, allocatable :: id(:)                  !! (places)
      integer, allocatable :: nodes(:, :)            !! at the corners of each cell
      real(dp), allocatable :: lower(:, :), inverse(:) !! lower corner of each cell, inverse of its size
      real(dp), allocatable :: share(:)              !! sums of the cells, (w, sums, n) and one zero block more
      integer, allocatable :: slot(:, :)             !! where in `share` the shares of a node begin, (corners, nodes)
      real(dp), allocatable :: inverse_mass(:)       !! of the nodes
      type(list_t) :: nodes_mapped, blocks_strained, nodes_accelerated !! see `plan`
      logical, allocatable :: left(:)                !! whether a particle has left its cell, by block
      real(dp), allocatable :: a(:, :), v_new(:, :), v(:, :) !! of the nodes: a dt, v dt of the move and of the strain
      real(dp) :: lambda = 0, mu = 0
      integer(long) :: moved = 0                     !! particles that changed their cell
   end type blocks_t
   integer, parameter :: bytes = 8*(9 + 18)          !! of particle data, read and written in a step

contains

   !> MUSL, first half: v <- v + a dt, and the momentum of the new velocities to the cells of a block.
   subroutine kick_and_map(rows, nodes, lower, inverse, x1, x2, u1, u2, v1, v2, m, change, share)
      integer, intent(in) :: rows, nodes(corners, w)
      real(dp), intent(in) :: lower(ndim, w), inverse(w), x1(w, rows), x2(w, rows), u1(w, rows), u2(w, rows), m(w, rows)
      real(dp), intent(inout) :: v1(w, rows), v2(w, rows)
      real(dp), intent(in) :: change(ndim, *)           !! a dt of the nodes [m/s]
      real(dp), intent(inout) :: share(w, sums)
      real(dp) :: a(w, 8), b(w, 2), xi, eta, left, right, s1, s2, s3, s4, vx, vy
      integer :: l, s
      call take_corners(nodes, change, a)
      do l = 1, w
         b(l, 1) = lower(1, l)
         b(l, 2) = lower(2, l)
      end do
      share(:, 5:12) = 0
      do s = 1, rows
         !$omp simd private(xi, eta, left, right, s1, s2, s3, s4, vx, vy)
         do l = 1, w
            xi = ((x1(l, s) - b(l, 1)) + u1(l, s))*inverse(l)
            eta = ((x2(l, s) - b(l, 2)) + u2(l, s))*inverse(l)
            xi = min(max(xi, edge_margin), 1 - edge_margin)
            eta = min(max(eta, edge_margin), 1 - edge_margin)
            vx = v1(l, s) + (a(l, 1) + xi*a(l, 2) + eta*(a(l, 3) + xi*a(l, 4)))
            vy = v2(l, s) + (a(l, 5) + xi*a(l, 6) + eta*(a(l, 7) + xi*a(l, 8)))
            v1(l, s) = vx
            v2(l, s) = vy
            right = xi*m(l, s)
            left = m(l, s) - right
            s3 = left*eta
            s1 = left - s3
            s4 = right*eta
            s2 = right - s4
            share(l, 5) = share(l, 5) + s1*vx
            share(l, 6) = share(l, 6) + s2*vx
            share(l, 7) = share(l, 7) + s3*vx
            share(l, 8) = share(l, 8) + s4*vx
            share(l, 9) = share(l, 9) + s1*vy
            share(l, 10) = share(l, 10) + s2*vy
            share(l, 11) = share(l, 11) + s3*vy
            share(l, 12) = share(l, 12) + s4*vy
         end do
      end do
   end subroutine kick_and_map

   !> MUSL, second half: H <- H + dt L (I + H), u <- u + v dt, then mass, momentum and internal force to the cells of a block.
   subroutine strain_move_and_map(rows, lambda, mu, nodes, lower, inverse, x1, x2, u1, u2, v1, v2, h11, h21, h12, h22, m, &
                                  volume, strain_by, move_by, share, gone)
      integer, intent(in) :: rows, nodes(corners, w)
      real(dp), intent(in) :: lambda, mu, lower(ndim, w), inverse(w), x1(w, rows), x2(w, rows), v1(w, rows), v2(w, rows), &
                              m(w, rows), volume(w, rows)
      real(dp), intent(inout) :: u1(w, rows), u2(w, rows), h11(w, rows), h21(w, rows), h12(w, rows), h22(w, rows)
      real(dp), intent(in) :: strain_by(ndim, *), move_by(ndim, *) !! displacements of the nodes [m]
      real(dp), intent(inout) :: share(w, sums)
      logical, intent(out) :: gone                      !! whether a particle stands outside its cell
      real(dp) :: a(w, 8), c(w, 8), b(w, 2), f(w, 7), outside(w)
      real(dp) :: xi, eta, left, right, s1, s2, s3, s4, q, l11, l12, l21, l22, g11, g12, g21, g22, &
                  t11, t12, t22, x, y
      integer :: l, s
      call take_corners(nodes, strain_by, a)
      call take_corners(nodes, move_by, c)
      do l = 1, w
         b(l, 1) = lower(1, l)
         b(l, 2) = lower(2, l)
         a(l, :) = a(l, :)*inverse(l)
      end do
      share(:, :12) = 0
      f(:w, :) = 0
      outside(:w) = 0
      do s = 1, rows
         !$omp simd private(xi, eta, left, right, s1, s2, s3, s4, q, l11, l12, l21, l22, g11, g12, g21, g22, t11, t12, t22, x, y)
         do l = 1, w
            xi = ((x1(l, s) - b(l, 1)) + u1(l, s))*inverse(l)
            eta = ((x2(l, s) - b(l, 2)) + u2(l, s))*inverse(l)
            xi = min(max(xi, edge_margin), 1 - edge_margin)
            eta = min(max(eta, edge_margin), 1 - edge_margin)
            q = merge(1.0_dp, 0.0_dp, m(l, s) > 0)
            l11 = q*(a(l, 2) + eta*a(l, 4))
            l12 = q*(a(l, 3) + xi*a(l, 4))
            l21 = q*(a(l, 6) + eta*a(l, 8))
            l22 = q*(a(l, 7) + xi*a(l, 8))
            g11 = h11(l, s) + (l11 + (l11*h11(l, s) + l12*h21(l, s)))
            g21 = h21(l, s) + (l21 + (l21*h11(l, s) + l22*h21(l, s)))
            g12 = h12(l, s) + (l12 + (l11*h12(l, s) + l12*h22(l, s)))
            g22 = h22(l, s) + (l22 + (l21*h12(l, s) + l22*h22(l, s)))
            h11(l, s) = g11
            h21(l, s) = g21
            h12(l, s) = g12
            h22(l, s) = g22
            t12 = volume(l, s)*(mu*(g12 + g21))
            t11 = volume(l, s)*(lambda*(g11 + g22) + 2*mu*g11)
            t22 = volume(l, s)*(lambda*(g11 + g22) + 2*mu*g22)
            x = u1(l, s) + q*(c(l, 1) + xi*c(l, 2) + eta*(c(l, 3) + xi*c(l, 4)))
            y = u2(l, s) + q*(c(l, 5) + xi*c(l, 6) + eta*(c(l, 7) + xi*c(l, 8)))
            u1(l, s) = x
            u2(l, s) = y
            xi = ((x1(l, s) - b(l, 1)) + x)*inverse(l)
            eta = ((x2(l, s) - b(l, 2)) + y)*inverse(l)
            outside(l) = max(outside(l), merge(0.0_dp, 1.0_dp, xi >= 0), merge(0.0_dp, 1.0_dp, xi < 1), &
                             merge(0.0_dp, 1.0_dp, eta >= 0), merge(0.0_dp, 1.0_dp, eta < 1))
            xi = min(max(xi, edge_margin), 1 - edge_margin)
            eta = min(max(eta, edge_margin), 1 - edge_margin)
            right = xi*m(l, s)
            left = m(l, s) - right
            s3 = left*eta
            s1 = left - s3
            s4 = right*eta
            s2 = right - s4
            share(l, 1) = share(l, 1) + s1
            share(l, 2) = share(l, 2) + s2
            share(l, 3) = share(l, 3) + s3
            share(l, 4) = share(l, 4) + s4
            share(l, 5) = share(l, 5) + s1*v1(l, s)
            share(l, 6) = share(l, 6) + s2*v1(l, s)
            share(l, 7) = share(l, 7) + s3*v1(l, s)
            share(l, 8) = share(l, 8) + s4*v1(l, s)
            share(l, 9) = share(l, 9) + s1*v2(l, s)
            share(l, 10) = share(l, 10) + s2*v2(l, s)
            share(l, 11) = share(l, 11) + s3*v2(l, s)
            share(l, 12) = share(l, 12) + s4*v2(l, s)
            f(l, 1) = f(l, 1) + t11
            f(l, 2) = f(l, 2) + eta*t11
            f(l, 3) = f(l, 3) + t12
            f(l, 4) = f(l, 4) + eta*t12
            f(l, 5) = f(l, 5) + xi*t12
            f(l, 6) = f(l, 6) + t22
            f(l, 7) = f(l, 7) + xi*t22
         end do
      end do
      do l = 1, w
         f(l, :) = -inverse(l)*f(l, :)
         share(l, 13) = (f(l, 2) - f(l, 1)) + (f(l, 5) - f(l, 3))
         share(l, 14) = (f(l, 1) - f(l, 2)) - f(l, 5)
         share(l, 15) = (f(l, 3) - f(l, 5)) - f(l, 2)
         share(l, 16) = f(l, 2) + f(l, 5)
         share(l, 17) = (f(l, 4) - f(l, 3)) + (f(l, 7) - f(l, 6))
         share(l, 18) = (f(l, 3) - f(l, 4)) - f(l, 7)
         share(l, 19) = (f(l, 6) - f(l, 7)) - f(l, 4)
         share(l, 20) = f(l, 4) + f(l, 7)
      end do
      gone = any(outside(:w) > 0)
   end subroutine strain_move_and_map

   !> A nodal vector in each cell of a block as the polynomial a1 + a2 xi + a3 eta + a4 xi eta, of both components.
   pure subroutine take_corners(nodes, field, a)
      integer, intent(in) :: nodes(corners, w)
      real(dp), intent(in) :: field(ndim, *)
      real(dp), intent(out) :: a(w, 8)
      real(dp) :: f(ndim, corners)
      integer :: l, k
      !GCC$ novector
      do l = 1, w
         do k = 1, corners
            f(:, k) = field(:, nodes(k, l))
         end do
         do k = 1, ndim
            a(l, 4*k - 3) = f(k, 1)
            a(l, 4*k - 2) = f(k, 2) - f(k, 1)
            a(l, 4*k - 1) = f(k, 3) - f(k, 1)
            a(l, 4*k) = (f(k, 4) - f(k, 3)) - (f(k, 2) - f(k, 1))
         end do
      end do
   end subroutine take_corners

   !> From the cells' shares the nodal velocity and acceleration: a dt, and the displacement that moves the particles. (Vectors
   !> of gathered numbers are slower than one number after the other.)
   pure subroutine accelerate(dt, n, nodes, slot, share, inverse_mass, a, move)
      integer, intent(in) :: n, nodes(n), slot(corners, *)
      real(dp), intent(in) :: dt, share(*)
      real(dp), intent(inout) :: inverse_mass(*), a(ndim, *), move(ndim, *)
      real(dp) :: m, p1, p2, f1, f2
      integer :: i, j, c, k
      !GCC$ novector
      do j = 1, n
         i = nodes(j)
         m = 0
         p1 = 0
         p2 = 0
         f1 = 0
         f2 = 0
         do c = 1, corners
            k = slot(c, i)
            m = m + share(k)
            p1 = p1 + share(k + corners*w)
            p2 = p2 + share(k + 2*corners*w)
            f1 = f1 + share(k + 3*corners*w)
            f2 = f2 + share(k + 4*corners*w)
         end do
         inverse_mass(i) = merge(1/m, 0.0_dp, m > 0)
         a(1, i) = dt*f1*inverse_mass(i)
         a(2, i) = dt*f2*inverse_mass(i)
         move(1, i) = dt*(p1*inverse_mass(i) + a(1, i))
         move(2, i) = dt*(p2*inverse_mass(i) + a(2, i))
      end do
   end subroutine accelerate

   !> From the cells' shares the nodal displacement v dt, v being mapped from the new velocities of the particles.
   pure subroutine map_velocity(dt, n, nodes, slot, share, inverse_mass, strain_by)
      integer, intent(in) :: n, nodes(n), slot(corners, *)
      real(dp), intent(in) :: dt, share(*), inverse_mass(*)
      real(dp), intent(inout) :: strain_by(ndim, *)
      real(dp) :: p1, p2
      integer :: i, j, c, k
      !GCC$ novector
      do j = 1, n
         i = nodes(j)
         p1 = 0
         p2 = 0
         do c = 1, corners
            k = slot(c, i)
            p1 = p1 + share(k + corners*w)
            p2 = p2 + share(k + 2*corners*w)
         end do
         strain_by(1, i) = dt*inverse_mass(i)*p1
         strain_by(2, i) = dt*inverse_mass(i)*p2
      end do
   end subroutine map_velocity

   !> One step of MUSL, tile after tile. Each part is done as soon as what it needs is there, while its data are still in the
   !> cache: the order does not change the numbers.
   subroutine step(dt, grid, g)
      real(dp), intent(in) :: dt
      type(grid_t), intent(in) :: grid
      type(blocks_t), intent(inout) :: g
      integer :: t, b, k
      logical :: left
      left = .false.
      g%left = .false.
      do t = 1, size(g%nodes_mapped%start) - 1
         do b = tile*(t - 1) + 1, min(tile*t, g%n)
            if (g%rows(b) > 0) call first_half(g, b, g%first(b), w*(b - 1) + 1)
         end do
         associate (l => g%nodes_mapped)
            call map_velocity(dt, l%start(t + 1) - l%start(t), l%item(l%start(t):), g%slot, g%share, g%inverse_mass, g%v)
         end associate
         do k = g%blocks_strained%start(t), g%blocks_strained%start(t + 1) - 1
            b = g%blocks_strained%item(k)
            if (g%rows(b) == 0) cycle
            call second_half(g, b, g%first(b), w*(b - 1) + 1, g%v, g%v_new)
            left = left .or. g%left(b)
         end do
         if (.not. left) call accelerate_nodes(dt, g, t)
      end do
      if (.not. left) return
      call change_cells(grid, g)
      do t = 1, size(g%nodes_mapped%start) - 1
         call accelerate_nodes(dt, g, t)
      end do
   end subroutine step

   !> Accelerate the nodes of a tile.
   subroutine accelerate_nodes(dt, g, t)
      real(dp), intent(in) :: dt
      type(blocks_t), intent(inout) :: g
      integer, intent(in) :: t
      associate (l => g%nodes_accelerated)
         call accelerate(dt, l%start(t + 1) - l%start(t), l%item(l%start(t):), g%slot, g%share, g%inverse_mass, g%a, g%v_new)
      end associate
   end subroutine accelerate_nodes

   !> Items sorted by the tile after which they can be done.
   pure function new_list(tile_of, tiles) result(list)
      integer, intent(in) :: tile_of(:), tiles
      type(list_t) :: list
      integer :: i, t
      allocate (list%start(tiles + 1), list%item(size(tile_of) + 1))
      list%start = 0
      do i = 1, size(tile_of)
         list%start(tile_of(i)) = list%start(tile_of(i)) + 1
      end do
      list%start(tiles + 1) = size(tile_of) + 1
      do t = tiles, 1, -1
         list%start(t) = list%start(t + 1) - list%start(t)
      end do
      do i = 1, size(tile_of)
         list%item(list%start(tile_of(i))) = i
         list%start(tile_of(i)) = list%start(tile_of(i)) + 1
      end do
      list%start = [1, list%start(:tiles)]
   end function new_list

   !> Plan a step: when the velocity of a node can be mapped, when a block can do its second half, and when a node can be
   !> accelerated for the next step.
   subroutine plan(grid, g)
      type(grid_t), intent(in) :: grid
      type(blocks_t), intent(inout) :: g
      integer :: mapped(grid%n_nodes), strained(g%n), accelerated(grid%n_nodes), e, c, b, tiles
      tiles = (g%n - 1)/tile + 1
      mapped = 1
      strained = 1
      accelerated = 1
      do e = 1, grid%n_elements
         do c = 1, corners
            mapped(g%nodes(c, e)) = max(mapped(g%nodes(c, e)), (e - 1)/(w*tile) + 1)
         end do
      end do
      do e = 1, grid%n_elements
         b = (e - 1)/w + 1
         strained(b) = max(strained(b), maxval(mapped(g%nodes(:, e))))
      end do
      do e = 1, grid%n_elements
         b = (e - 1)/w + 1
         do c = 1, corners
            accelerated(g%nodes(c, e)) = max(accelerated(g%nodes(c, e)), strained(b))
         end do
      end do
      g%nodes_mapped = new_list(mapped, tiles)
      g%blocks_strained = new_list(strained, tiles)
      g%nodes_accelerated = new_list(accelerated, tiles)
   end subroutine plan

   !> The first half of a step for the block `b`.
   subroutine first_half(g, b, i, e)
      type(blocks_t), intent(inout) :: g
      integer, intent(in) :: b, i, e                    !! block, its first place, its first cell
      associate (p => g%p)
         call kick_and_map(g%rows(b), g%nodes(1, e), g%lower(1, e), g%inverse(e), p(i, 1), p(i, 2), p(i, 3), p(i, 4), &
                           p(i, 5), p(i, 6), p(i, 11), g%a, g%share(w*sums*(b - 1) + 1))
      end associate
   end subroutine first_half

   !> The second half of a step for the block `b`.
   subroutine second_half(g, b, i, e, strain_by, move_by)
      type(blocks_t), intent(inout) :: g
      integer, intent(in) :: b, i, e
      real(dp), intent(in) :: strain_by(:, :), move_by(:, :)
      associate (p => g%p)
         call strain_move_and_map(g%rows(b), g%lambda, g%mu, g%nodes(1, e), g%lower(1, e), g%inverse(e), p(i, 1), &
                                  p(i, 2), p(i, 3), p(i, 4), p(i, 5), p(i, 6), p(i, 7), p(i, 8), p(i, 9), p(i, 10), &
                                  p(i, 11), p(i, 12), strain_by, move_by, g%share(w*sums*(b - 1) + 1), g%left(b))
      end associate
   end subroutine second_half

   !> Move the particles that have left their cells, block after block, and map anew the blocks that they leave or enter.
   subroutine change_cells(grid, g)
      type(grid_t), intent(in) :: grid
      type(blocks_t), intent(inout) :: g
      logical :: touched(g%n)
      real(dp) :: is_static(ndim, size(g%a, 2))
      integer :: b, e, s, from, to, d, target
      touched = g%left
      do b = 1, g%n
         if (.not. g%left(b)) cycle
         do e = w*(b - 1) + 1, min(w*b, size(grid%element_size))
            s = 1
            do while (s <= g%count_of(e))
               from = place_of(g, e, s)
               target = grid%element_at([(g%p(from, d) + g%p(from, d + ndim), d=1, ndim)])
               s = s + 1
               if (target == e) cycle
               if (target < 1) error stop 'a particle has left the grid'
               call make_room(g, target)
               to = place_of(g, target, g%count_of(target))
               from = place_of(g, e, s - 1)
               call copy_place(g, from, to)
               s = s - 1
               call copy_place(g, place_of(g, e, g%count_of(e)), from)
               call empty_place(g, e, g%count_of(e))
               g%count_of(e) = g%count_of(e) - 1
               g%moved = g%moved + 1
               touched((target - 1)/w + 1) = .true.
            end do
         end do
      end do
      is_static = 0
      do b = 1, g%n
         if (.not. touched(b)) cycle
         g%rows(b) = maxval(g%count_of(w*(b - 1) + 1:w*b))
         call second_half(g, b, g%first(b), w*(b - 1) + 1, is_static, is_static)
      end do
   end subroutine change_cells

   !> Place of the s-th particle of cell `e`.
   pure integer function place_of(g, e, s)
      type(blocks_t), intent(in) :: g
      integer, intent(in) :: e, s
      place_of = g%first((e - 1)/w + 1) + w*(s - 1) + mod(e - 1, w)
   end function place_of

   !> Count one particle more in cell `e`. A block without room for it moves to the end, with two rows more.
   subroutine make_room(g, e)
      type(blocks_t), intent(inout) :: g
      integer, intent(in) :: e
      real(dp), allocatable :: p(:, :)
      integer, allocatable :: id(:)
      integer :: b, k, s, size_needed
      b = (e - 1)/w + 1
      g%count_of(e) = g%count_of(e) + 1
      if (g%count_of(e) <= g%room(b)) return
      g%room(b) = g%room(b) + 2
      size_needed = g%free + w*g%room(b) - 1
      if (size_needed > size(g%id)) then
         allocate (p(2*size_needed, columns), id(2*size_needed))
         p(:size(g%id), :) = g%p
         id(:size(g%id)) = g%id
         call move_alloc(p, g%p)
         call move_alloc(id, g%id)
      end if
      do k = 0, w*(g%room(b) - 2) - 1
         call copy_place(g, g%first(b) + k, g%free + k)
      end do
      g%first(b) = g%free
      g%free = size_needed + 1
      do k = w*(b - 1) + 1, w*b
         do s = g%room(b) - 1, g%room(b)
            call empty_place(g, k, s)
         end do
      end do
   end subroutine make_room

   !> Copy a particle to another place.
   subroutine copy_place(g, from, to)
      type(blocks_t), intent(inout) :: g
      integer, intent(in) :: from, to
      g%p(to, :) = g%p(from, :)
      g%id(to) = g%id(from)
   end subroutine copy_place

   !> Make a place empty: nothing, in the middle of the cell.
   subroutine empty_place(g, e, s)
      type(blocks_t), intent(inout) :: g
      integer, intent(in) :: e, s
      integer :: place
      place = place_of(g, e, s)
      g%p(place, :) = 0
      g%p(place, :ndim) = g%lower(:, e) + 0.5_dp/g%inverse(e)
      g%id(place) = 0
   end subroutine empty_place

   !> Blocks of `w` cells with the particles of `motion`, mapped for the first step.
   subroutine set_up(dt, problem, g)
      real(dp), intent(in) :: dt
      type(problem_t), intent(in) :: problem
      type(blocks_t), intent(out) :: g
      integer :: b, e, s, i, c, cells
      real(dp), allocatable :: is_static(:, :)
      associate (grid => problem%grid, q => problem%particles)
         cells = grid%n_elements
         g%n = (cells - 1)/w + 1
         g%lambda = problem%materials(1)%lambda
         g%mu = problem%materials(1)%mu
         allocate (g%first(g%n), g%rows(g%n), g%left(g%n), g%count_of(w*g%n), g%nodes(corners, w*g%n), &
                   g%lower(ndim, w*g%n), g%inverse(w*g%n), g%share(w*sums*(g%n + 1)), g%slot(corners, grid%n_nodes), &
                   g%a(ndim, grid%n_nodes), g%v_new(ndim, grid%n_nodes), g%v(ndim, grid%n_nodes), g%inverse_mass(grid%n_nodes))
         g%count_of = 0
         g%count_of(:cells) = problem%blocks%count_in
         g%nodes = 1
         g%nodes(:, :cells) = grid%element_nodes
         g%lower = 0
         g%lower(:, :cells) = grid%element_lower
         g%inverse = 1
         g%inverse(:cells) = 1/grid%element_size
         g%share = 0
         g%left = .false.
         g%free = 1
         do b = 1, g%n
            g%rows(b) = maxval(g%count_of(w*(b - 1) + 1:w*b))
            g%first(b) = g%free
            g%free = g%free + w*g%rows(b)
         end do
         g%room = g%rows
         allocate (g%p(g%free + 64, columns), g%id(g%free + 64))
         do e = 1, w*g%n
            do s = 1, g%rows((e - 1)/w + 1)
               call empty_place(g, e, s)
               if (s > g%count_of(e)) cycle
               i = problem%blocks%first_in(e) + (s - 1)*problem%blocks%stride_in(e)
               g%p(place_of(g, e, s), :) = [q%reference(i, :), q%displacement(i, :), q%velocity(i, :), q%gradient(i, :, :), &
                                            q%mass(i), q%volume(i)]
               g%id(place_of(g, e, s)) = q%id(i)
            end do
         end do
         g%slot(:, :grid%n_nodes) = w*sums*g%n + 1
         do i = 1, grid%n_nodes
            do c = grid%dofs%first_slot(i), grid%dofs%first_slot(i + 1) - 1
               e = element_of_slot(grid%dofs%slot(c)) - 1
               g%slot(c - grid%dofs%first_slot(i) + 1, i) = w*sums*(e/w) + w*(corner_of_slot(grid%dofs%slot(c)) - 1) &
                                                            + mod(e, w) + 1
            end do
         end do
         allocate (is_static(ndim, grid%n_nodes), source=0.0_dp)
         do b = 1, g%n
            call second_half(g, b, g%first(b), w*(b - 1) + 1, is_static, is_static)
         end do
         call plan(grid, g)
         do b = 1, size(g%nodes_mapped%start) - 1
            call accelerate_nodes(dt, g, b)
         end do
      end associate
   end subroutine set_up

   !> Kinetic and strain energy [J].
   pure real(dp) function energy(g)
      type(blocks_t), intent(in) :: g
      integer :: e, s
      energy = 0
      do e = 1, w*g%n
         do s = 1, g%count_of(e)
            associate (q => g%p(place_of(g, e, s), :))
               energy = energy + 0.5_dp*(q(11)*sum(q(5:6)**2) + q(12)*(g%lambda*(q(7) + q(10))**2 &
                                                                     + 2*g%mu*(q(7)**2 + q(10)**2) + g%mu*(q(8) + q(9))**2))
            end associate
         end do
      end do
   end function energy
end module hampm_minimal_kernel
