!> The least that a plain scene needs a step: MUSL and USF, lumped mass, updated frame, bilinear, linear elastic, any number of
!> particles a cell, which may move to other cells. What the library needs beside it is measured in the same run, and both
!> must agree. See docs/performance.md.
!>
!> Cells stand in blocks of `w` neighbours in the order of the grid, and the particles of a block in rows: row s holds the s-th
!> particle of each of the w cells, side by side. So the loop over the cells of a block is the vector loop. It
!> reads and writes with unit stride, and sums over the particles of a cell stay in registers. A cell with fewer particles than
!> its block has rows has empty places at its end: their mass is zero and they stay as they are. w = 1 is the plain loop over
!> the particles of one cell after the other.
program minimal_step
   use, intrinsic :: iso_fortran_env, only: output_unit
   use, intrinsic :: ieee_arithmetic, only: ieee_set_underflow_mode
   use hampm_kinds, only: dp, long, ndim, corners
   use hampm_assembly, only: assemble
   use hampm_basis, only: edge_margin
   use hampm_energy, only: kinetic_energy, strain_energy, linear_momentum
   use hampm_failure, only: failure_t
   use hampm_grid, only: element_of_slot, corner_of_slot
   use hampm_refinement, only: refinement_t
   use hampm_scene, only: scene_t
   use hampm_step, only: motion_t, advance, stable_time_step
   use hampm_threads, only: use_threads
   implicit none

   integer, parameter :: most_lanes = 64
   integer, parameter :: columns = 12                !! X1 X2 u1 u2 v1 v2 H11 H21 H12 H22 m V
   integer, parameter :: sums = 5*corners            !! of a cell: mass, two momenta, two forces; corner by corner

   !> Particles in blocks, and the grid as the kernels need it.
   type :: blocks_t
      integer :: w = 1, n = 0                        !! lanes of a block, blocks
      integer :: free = 0                            !! first place that belongs to no block
      integer, allocatable :: first(:), rows(:), room(:) !! of each block: place before its first, rows used, rows
      integer, allocatable :: count_of(:)            !! particles of each cell
      real(dp), allocatable :: p(:, :)               !! particles, (places, columns)
      integer, allocatable :: id(:)                  !! (places)
      integer, allocatable :: nodes(:, :)            !! at the corners of each cell
      real(dp), allocatable :: lower(:, :), inverse(:) !! lower corner of each cell, inverse of its size
      real(dp), allocatable :: share(:)              !! sums of the cells, (w, sums, n) and one zero block more
      integer, allocatable :: slot(:, :)             !! where in `share` the shares of a node begin, (corners, nodes)
      logical, allocatable :: left(:)                !! whether a particle has left its cell, by block
      real(dp), allocatable :: a(:, :), v_new(:, :), v(:, :) !! of the nodes: a dt, v dt of the move and of the strain
      real(dp) :: lambda = 0, mu = 0
      integer(long) :: moved = 0                     !! particles that changed their cell
   end type blocks_t
   integer, parameter :: bytes = 8*(9 + 18)          !! of particle data, read and written in a step
   type(motion_t) :: motion
   integer :: k

   call use_threads(1, 1)
   do k = 1, 3
      call compare(8**(k - 1))
   end do
   print '(a9, 99a9)', 'particles', 'library', 'w=1', 'w=4', 'w=8', 'w=16', 'w=32', 'w=64', 'copy', 'GB/s'
   call measure(50)
   call measure(158)
   call measure(500)

contains

   !> MUSL, first half: v <- v + a dt, and the momentum of the new velocities to the cells of a block.
   subroutine kick_and_map(w, rows, nodes, lower, inverse, x1, x2, u1, u2, v1, v2, m, change, share)
      integer, intent(in) :: w, rows, nodes(corners, w)
      real(dp), intent(in) :: lower(ndim, w), inverse(w), x1(w, rows), x2(w, rows), u1(w, rows), u2(w, rows), m(w, rows)
      real(dp), intent(inout) :: v1(w, rows), v2(w, rows)
      real(dp), intent(in) :: change(ndim, *)           !! a dt of the nodes [m/s]
      real(dp), intent(inout) :: share(w, sums)
      real(dp) :: a(most_lanes, 8), b(most_lanes, 2), xi, eta, left, right, s1, s2, s3, s4, &
                  p11, p12, p13, p14, p21, p22, p23, p24
      integer :: l, s
      call take_corners(w, nodes, change, a)
      do l = 1, w
         b(l, 1) = lower(1, l)
         b(l, 2) = lower(2, l)
      end do
      !$omp simd private(s, xi, eta, left, right, s1, s2, s3, s4, p11, p12, p13, p14, p21, p22, p23, p24)
      do l = 1, w
         p11 = 0; p12 = 0; p13 = 0; p14 = 0; p21 = 0; p22 = 0; p23 = 0; p24 = 0
         do s = 1, rows
            xi = ((x1(l, s) - b(l, 1)) + u1(l, s))*inverse(l)
            eta = ((x2(l, s) - b(l, 2)) + u2(l, s))*inverse(l)
            xi = min(max(xi, edge_margin), 1 - edge_margin)
            eta = min(max(eta, edge_margin), 1 - edge_margin)
            v1(l, s) = v1(l, s) + (a(l, 1) + xi*a(l, 2) + eta*(a(l, 3) + xi*a(l, 4)))
            v2(l, s) = v2(l, s) + (a(l, 5) + xi*a(l, 6) + eta*(a(l, 7) + xi*a(l, 8)))
            right = xi*m(l, s)
            left = m(l, s) - right
            s3 = left*eta; s1 = left - s3
            s4 = right*eta; s2 = right - s4
            p11 = p11 + s1*v1(l, s); p12 = p12 + s2*v1(l, s); p13 = p13 + s3*v1(l, s); p14 = p14 + s4*v1(l, s)
            p21 = p21 + s1*v2(l, s); p22 = p22 + s2*v2(l, s); p23 = p23 + s3*v2(l, s); p24 = p24 + s4*v2(l, s)
         end do
         share(l, 5) = p11; share(l, 6) = p12; share(l, 7) = p13; share(l, 8) = p14
         share(l, 9) = p21; share(l, 10) = p22; share(l, 11) = p23; share(l, 12) = p24
      end do
   end subroutine kick_and_map

   !> MUSL, second half: H <- H + dt L (I + H), u <- u + v dt, then mass, momentum and internal force to the cells of a block.
   subroutine strain_move_and_map(w, rows, lambda, mu, nodes, lower, inverse, x1, x2, u1, u2, v1, v2, h11, h21, h12, h22, m, &
                                  volume, strain_by, move_by, share, gone)
      integer, intent(in) :: w, rows, nodes(corners, w)
      real(dp), intent(in) :: lambda, mu, lower(ndim, w), inverse(w), x1(w, rows), x2(w, rows), v1(w, rows), v2(w, rows), &
                              m(w, rows), volume(w, rows)
      real(dp), intent(inout) :: u1(w, rows), u2(w, rows), h11(w, rows), h21(w, rows), h12(w, rows), h22(w, rows)
      real(dp), intent(in) :: strain_by(ndim, *), move_by(ndim, *) !! displacements of the nodes [m]
      real(dp), intent(inout) :: share(w, sums)
      integer, intent(out) :: gone                      !! how often a particle has been found outside its cell
      real(dp) :: a(most_lanes, 8), c(most_lanes, 8), b(most_lanes, 2), xi, eta, left, right, s1, s2, s3, s4, q, &
                  p11, p12, p13, p14, p21, p22, p23, p24, m1, m2, m3, m4, l11, l12, l21, l22, g11, g12, g21, g22, &
                  t11, t12, t22, f11, f11e, f12, f12e, f12x, f22, f22x, du1, du2, xn, en
      integer :: l, s
      call take_corners(w, nodes, strain_by, a)
      call take_corners(w, nodes, move_by, c)
      do l = 1, w
         b(l, 1) = lower(1, l)
         b(l, 2) = lower(2, l)
      end do
      gone = 0
      !$omp simd private(s, xi, eta, left, right, s1, s2, s3, s4, p11, p12, p13, p14, p21, p22, p23, p24) &
      !$omp& private(m1, m2, m3, m4, l11, l12, l21, l22, g11, g12, g21, g22, t11, t12, t22, f11, f11e, f12, f12e, f12x) &
      !$omp& private(f22, f22x, du1, du2, xn, en, q) reduction(+: gone)
      do l = 1, w
         p11 = 0; p12 = 0; p13 = 0; p14 = 0; p21 = 0; p22 = 0; p23 = 0; p24 = 0; m1 = 0; m2 = 0; m3 = 0; m4 = 0
         f11 = 0; f11e = 0; f12 = 0; f12e = 0; f12x = 0; f22 = 0; f22x = 0
         do s = 1, rows
            xi = ((x1(l, s) - b(l, 1)) + u1(l, s))*inverse(l)
            eta = ((x2(l, s) - b(l, 2)) + u2(l, s))*inverse(l)
            xi = min(max(xi, edge_margin), 1 - edge_margin)
            eta = min(max(eta, edge_margin), 1 - edge_margin)
            q = merge(1.0_dp, 0.0_dp, m(l, s) > 0)
            l11 = (a(l, 2) + eta*a(l, 4))*(inverse(l)*q)
            l12 = (a(l, 3) + xi*a(l, 4))*(inverse(l)*q)
            l21 = (a(l, 6) + eta*a(l, 8))*(inverse(l)*q)
            l22 = (a(l, 7) + xi*a(l, 8))*(inverse(l)*q)
            g11 = h11(l, s); g12 = h12(l, s); g21 = h21(l, s); g22 = h22(l, s)
            g11 = g11 + (l11 + (l11*h11(l, s) + l12*h21(l, s)))
            g21 = g21 + (l21 + (l21*h11(l, s) + l22*h21(l, s)))
            g12 = g12 + (l12 + (l11*h12(l, s) + l12*h22(l, s)))
            g22 = g22 + (l22 + (l21*h12(l, s) + l22*h22(l, s)))
            h11(l, s) = g11; h21(l, s) = g21; h12(l, s) = g12; h22(l, s) = g22
            t11 = -volume(l, s)*inverse(l)
            t12 = t11*mu*(g12 + g21)
            t22 = t11*(lambda*(g11 + g22) + 2*mu*g22)
            t11 = t11*(lambda*(g11 + g22) + 2*mu*g11)
            du1 = c(l, 1) + xi*c(l, 2) + eta*(c(l, 3) + xi*c(l, 4))
            du2 = c(l, 5) + xi*c(l, 6) + eta*(c(l, 7) + xi*c(l, 8))
            u1(l, s) = u1(l, s) + q*du1
            u2(l, s) = u2(l, s) + q*du2
            xn = ((x1(l, s) - b(l, 1)) + u1(l, s))*inverse(l)
            en = ((x2(l, s) - b(l, 2)) + u2(l, s))*inverse(l)
            xi = min(max(xn, edge_margin), 1 - edge_margin)
            eta = min(max(en, edge_margin), 1 - edge_margin)
            gone = gone + merge(0, 1, xn >= 0 .and. xn < 1 .and. en >= 0 .and. en < 1)
            right = xi*m(l, s)
            left = m(l, s) - right
            s3 = left*eta; s1 = left - s3
            s4 = right*eta; s2 = right - s4
            m1 = m1 + s1; m2 = m2 + s2; m3 = m3 + s3; m4 = m4 + s4
            p11 = p11 + s1*v1(l, s); p12 = p12 + s2*v1(l, s); p13 = p13 + s3*v1(l, s); p14 = p14 + s4*v1(l, s)
            p21 = p21 + s1*v2(l, s); p22 = p22 + s2*v2(l, s); p23 = p23 + s3*v2(l, s); p24 = p24 + s4*v2(l, s)
            f11 = f11 + t11; f11e = f11e + eta*t11
            f12 = f12 + t12; f12e = f12e + eta*t12; f12x = f12x + xi*t12
            f22 = f22 + t22; f22x = f22x + xi*t22
         end do
         share(l, 1) = m1; share(l, 2) = m2; share(l, 3) = m3; share(l, 4) = m4
         share(l, 5) = p11; share(l, 6) = p12; share(l, 7) = p13; share(l, 8) = p14
         share(l, 9) = p21; share(l, 10) = p22; share(l, 11) = p23; share(l, 12) = p24
         share(l, 13) = -(f11 - f11e) - (f12 - f12x)
         share(l, 14) = (f11 - f11e) - f12x
         share(l, 15) = (f12 - f12x) - f11e
         share(l, 16) = f11e + f12x
         share(l, 17) = -(f12 - f12e) - (f22 - f22x)
         share(l, 18) = (f12 - f12e) - f22x
         share(l, 19) = (f22 - f22x) - f12e
         share(l, 20) = f12e + f22x
      end do
   end subroutine strain_move_and_map

   !> A nodal vector in each cell of a block as the polynomial a1 + a2 xi + a3 eta + a4 xi eta, of both components.
   pure subroutine take_corners(w, nodes, field, a)
      integer, intent(in) :: w, nodes(corners, w)
      real(dp), intent(in) :: field(ndim, *)
      real(dp), intent(out) :: a(most_lanes, 8)
      real(dp) :: f(ndim, corners)
      integer :: l, k
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

   !> From the cells' shares the nodal velocity and acceleration: a dt, and the displacement that moves the particles.
   pure subroutine accelerate(w, dt, n, slot, share, a, move)
      integer, intent(in) :: w, n, slot(corners, n)
      real(dp), intent(in) :: dt, share(*)
      real(dp), intent(out) :: a(ndim, n), move(ndim, n)
      real(dp) :: m, p1, p2, f1, f2
      integer :: i, c, k, stride
      stride = corners*w
      do i = 1, n
         m = 0; p1 = 0; p2 = 0; f1 = 0; f2 = 0
         do c = 1, corners
            k = slot(c, i)
            m = m + share(k)
            p1 = p1 + share(k + stride)
            p2 = p2 + share(k + 2*stride)
            f1 = f1 + share(k + 3*stride)
            f2 = f2 + share(k + 4*stride)
         end do
         m = merge(1/m, 0.0_dp, m > 0)
         a(1, i) = (m*dt)*f1
         a(2, i) = (m*dt)*f2
         move(1, i) = dt*(m*p1 + a(1, i))
         move(2, i) = dt*(m*p2 + a(2, i))
      end do
   end subroutine accelerate

   !> From the cells' shares the nodal displacement v dt, v being mapped from the new velocities of the particles.
   pure subroutine map_velocity(w, dt, n, slot, share, strain_by)
      integer, intent(in) :: w, n, slot(corners, n)
      real(dp), intent(in) :: dt, share(*)
      real(dp), intent(out) :: strain_by(ndim, n)
      real(dp) :: m, p1, p2
      integer :: i, c, k, stride
      stride = corners*w
      do i = 1, n
         m = 0; p1 = 0; p2 = 0
         do c = 1, corners
            k = slot(c, i)
            m = m + share(k)
            p1 = p1 + share(k + stride)
            p2 = p2 + share(k + 2*stride)
         end do
         m = merge(dt/m, 0.0_dp, m > 0)
         strain_by(1, i) = m*p1
         strain_by(2, i) = m*p2
      end do
   end subroutine map_velocity

   !> One step of MUSL.
   subroutine step(dt, g)
      real(dp), intent(in) :: dt
      type(blocks_t), intent(inout) :: g
      integer :: b
      call accelerate(g%w, dt, size(g%a, 2), g%slot, g%share, g%a, g%v_new)
      !$omp parallel do schedule(static)
      do b = 1, g%n
         call first_half(g, b, g%first(b), g%w*(b - 1) + 1)
      end do
      call map_velocity(g%w, dt, size(g%a, 2), g%slot, g%share, g%v)
      !$omp parallel do schedule(static)
      do b = 1, g%n
         call second_half(g, b, g%first(b), g%w*(b - 1) + 1, g%v, g%v_new)
      end do
      if (any(g%left)) call change_cells(g)
   end subroutine step

   !> The first half of a step for the block `b`.
   subroutine first_half(g, b, i, e)
      type(blocks_t), intent(inout) :: g
      integer, intent(in) :: b, i, e                    !! block, its first place, its first cell
      associate (p => g%p)
         call kick_and_map(g%w, g%rows(b), g%nodes(1, e), g%lower(1, e), g%inverse(e), p(i, 1), p(i, 2), p(i, 3), p(i, 4), &
                           p(i, 5), p(i, 6), p(i, 11), g%a, g%share(g%w*sums*(b - 1) + 1))
      end associate
   end subroutine first_half

   !> The second half of a step for the block `b`.
   subroutine second_half(g, b, i, e, strain_by, move_by)
      type(blocks_t), intent(inout) :: g
      integer, intent(in) :: b, i, e
      real(dp), intent(in) :: strain_by(:, :), move_by(:, :)
      integer :: gone
      associate (p => g%p)
         call strain_move_and_map(g%w, g%rows(b), g%lambda, g%mu, g%nodes(1, e), g%lower(1, e), g%inverse(e), p(i, 1), &
                                  p(i, 2), p(i, 3), p(i, 4), p(i, 5), p(i, 6), p(i, 7), p(i, 8), p(i, 9), p(i, 10), &
                                  p(i, 11), p(i, 12), strain_by, move_by, g%share(g%w*sums*(b - 1) + 1), gone)
      end associate
      g%left(b) = gone > 0
   end subroutine second_half

   !> Move the particles that have left their cells, block after block, and map anew the blocks that they leave or enter.
   subroutine change_cells(g)
      type(blocks_t), intent(inout) :: g
      logical :: touched(g%n)
      real(dp) :: at_rest(ndim, size(g%a, 2))
      integer :: b, e, s, from, to, d, target
      touched = g%left
      do b = 1, g%n
         if (.not. g%left(b)) cycle
         do e = g%w*(b - 1) + 1, min(g%w*b, size(motion%grid%element_size))
            s = 1
            do while (s <= g%count_of(e))
               from = place_of(g, e, s)
               target = motion%grid%element_at([(g%p(from, d) + g%p(from, d + ndim), d=1, ndim)])
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
               touched((target - 1)/g%w + 1) = .true.
            end do
         end do
      end do
      at_rest = 0
      do b = 1, g%n
         if (.not. touched(b)) cycle
         g%rows(b) = maxval(g%count_of(g%w*(b - 1) + 1:g%w*b))
         call second_half(g, b, g%first(b), g%w*(b - 1) + 1, at_rest, at_rest)
      end do
   end subroutine change_cells

   !> Place of the s-th particle of cell `e`.
   pure integer function place_of(g, e, s)
      type(blocks_t), intent(in) :: g
      integer, intent(in) :: e, s
      place_of = g%first((e - 1)/g%w + 1) + g%w*(s - 1) + mod(e - 1, g%w)
   end function place_of

   !> Count one particle more in cell `e`. A block without room for it moves to the end, with two rows more.
   subroutine make_room(g, e)
      type(blocks_t), intent(inout) :: g
      integer, intent(in) :: e
      real(dp), allocatable :: p(:, :)
      integer, allocatable :: id(:)
      integer :: b, k, s, size_needed
      b = (e - 1)/g%w + 1
      g%count_of(e) = g%count_of(e) + 1
      if (g%count_of(e) <= g%room(b)) return
      g%room(b) = g%room(b) + 2
      size_needed = g%free + g%w*g%room(b) - 1
      if (size_needed > size(g%id)) then
         allocate (p(2*size_needed, columns), id(2*size_needed))
         p(:size(g%id), :) = g%p
         id(:size(g%id)) = g%id
         call move_alloc(p, g%p)
         call move_alloc(id, g%id)
      end if
      do k = 0, g%w*(g%room(b) - 2) - 1
         call copy_place(g, g%first(b) + k, g%free + k)
      end do
      g%first(b) = g%free
      g%free = size_needed + 1
      do k = g%w*(b - 1) + 1, g%w*b
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
   subroutine set_up(w, g)
      integer, intent(in) :: w
      type(blocks_t), intent(out) :: g
      integer :: b, e, s, i, c, cells
      real(dp), allocatable :: at_rest(:, :)
      associate (grid => motion%grid, q => motion%particles)
         cells = grid%n_elements
         g%w = w
         g%n = (cells - 1)/w + 1
         g%lambda = motion%materials(1)%lambda
         g%mu = motion%materials(1)%mu
         allocate (g%first(g%n), g%rows(g%n), g%left(g%n), g%count_of(w*g%n), g%nodes(corners, w*g%n), &
                   g%lower(ndim, w*g%n), g%inverse(w*g%n), g%share(w*sums*(g%n + 1)), g%slot(corners, grid%n_nodes), &
                   g%a(ndim, grid%n_nodes), g%v_new(ndim, grid%n_nodes), g%v(ndim, grid%n_nodes))
         g%count_of = 0
         g%count_of(:cells) = q%cell_start(2:cells + 1) - q%cell_start(:cells)
         g%nodes = 1
         g%nodes(:, :cells) = grid%element_nodes
         g%lower = 0
         g%lower(:, :cells) = grid%element_lower
         g%inverse = 1
         g%inverse(:cells) = 1/grid%element_size
         g%share = 0
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
               i = q%cell_start(e) + s - 1
               g%p(place_of(g, e, s), :) = [q%reference(:, i), q%displacement(:, i), q%velocity(:, i), q%gradient(:, :, i), &
                                            q%mass(i), q%volume(i)]
               g%id(place_of(g, e, s)) = q%id(i)
            end do
         end do
         do i = 1, grid%n_nodes
            do c = 1, corners
               g%slot(c, i) = w*sums*g%n + 1
               if (grid%node_slot(c, i) == 0) cycle
               e = element_of_slot(grid%node_slot(c, i)) - 1
               g%slot(c, i) = w*sums*(e/w) + w*(corner_of_slot(grid%node_slot(c, i)) - 1) + mod(e, w) + 1
            end do
         end do
         allocate (at_rest(ndim, grid%n_nodes), source=0.0_dp)
         do b = 1, g%n
            call second_half(g, b, g%first(b), w*(b - 1) + 1, at_rest, at_rest)
         end do
      end associate
   end subroutine set_up

   !> A box filled with particles in a smooth small motion, which also turns and flies where `fast`.
   subroutine filled_box(cells, fast)
      integer, intent(in) :: cells
      logical, intent(in) :: fast
      type(scene_t) :: scene
      type(refinement_t) :: refinement
      type(failure_t) :: failure
      real(dp), parameter :: cell = 1.0e-3_dp
      integer :: i
      scene%run%plane = 'stress'
      scene%run%thickness = 1
      scene%grid%cell = cell
      scene%grid%cells = cells
      scene%method%scheme = 'musl'
      allocate (scene%materials(1), scene%bodies(1), scene%constraints(0), scene%loads(0))
      scene%materials(1)%law = 'linear_elastic'
      scene%materials(1)%young = merge(70e6_dp, 70e9_dp, fast)
      scene%materials(1)%poisson = 0.3_dp
      scene%materials(1)%density = 2700
      scene%bodies(1)%material_index = 1
      scene%bodies(1)%lower = merge(cells/4, 0, fast)*cell
      scene%bodies(1)%upper = merge(cells/2, cells, fast)*cell
      scene%bodies(1)%points_per_cell = 2
      call assemble(scene, motion, refinement, failure)
      if (failure%failed()) error stop 'the scene cannot be built'
      motion%mapped = .false.
      associate (p => motion%particles)
         p%velocity = 1.0e-3_dp*sin(200*p%reference)
         if (.not. fast) return
         do i = 1, p%n
            p%velocity(:, i) = p%velocity(:, i) + [3.0_dp, 2.0_dp] &
                               + 300*[0.375_dp*cells*cell - p%reference(2, i), p%reference(1, i) - 0.375_dp*cells*cell]
         end do
      end associate
   end subroutine filled_box

   !> Compare with the library after some steps of a flying, turning, vibrating block.
   subroutine compare(w)
      integer, intent(in) :: w
      type(blocks_t) :: g
      type(failure_t) :: failure
      real(dp) :: dt, u, worst_u, worst_v, worst_h, momentum(ndim)
      integer :: k, i, e, s, by_id(4096)
      call filled_box(32, .true.)
      call set_up(w, g)
      dt = stable_time_step(1.0e-3_dp, motion%materials, 0.4_dp, 'dilatational')
      do k = 1, 500
         call advance(motion, dt, failure)
         if (failure%failed()) error stop 'the library has failed'
         call step(dt, g)
      end do
      associate (p => motion%particles)
         by_id(p%id) = [(i, i=1, p%n)]
         u = maxval(abs(p%displacement))
         worst_u = 0
         worst_v = 0
         worst_h = 0
         momentum = 0
         do e = 1, motion%grid%n_elements
            do s = 1, g%count_of(e)
               associate (q => g%p(place_of(g, e, s), :))
                  i = by_id(g%id(place_of(g, e, s)))
                  if (p%cell(i) /= e) error stop 'a particle stands in another cell than in the library'
                  worst_u = max(worst_u, maxval(abs(q(3:4) - p%displacement(:, i))))
                  worst_v = max(worst_v, maxval(abs(q(5:6) - p%velocity(:, i))))
                  worst_h = max(worst_h, maxval(abs(q(7:10) - [p%gradient(:, :, i)])))
                  momentum = momentum + q(11)*q(5:6)
               end associate
            end do
         end do
         print '(a, i3, a, i0, a, i0, a, 4es9.1)', 'w =', w, ': particles ', p%n, ', changes of cell ', g%moved, &
            ', |u| max, worst difference of u, v, H', u, worst_u, worst_v, worst_h
         print '(a, 3es24.15)', '  momentum, energy  ', linear_momentum(p), kinetic_energy(p) + strain_energy(p, motion%materials)
         print '(a, 3es24.15)', '  minimal           ', momentum, energy(g)
      end associate
   end subroutine compare

   !> Kinetic and strain energy [J].
   pure real(dp) function energy(g)
      type(blocks_t), intent(in) :: g
      integer :: e, s
      energy = 0
      do e = 1, g%w*g%n
         do s = 1, g%count_of(e)
            associate (q => g%p(place_of(g, e, s), :))
               energy = energy + 0.5_dp*(q(11)*sum(q(5:6)**2) + q(12)*(g%lambda*(q(7) + q(10))**2 &
                                                                     + 2*g%mu*(q(7)**2 + q(10)**2) + g%mu*(q(8) + q(9))**2))
            end associate
         end do
      end do
   end function energy

   !> Measure one size of scene: the library, then blocks of some widths, beside the speed of a copy.
   subroutine measure(cells)
      integer, intent(in) :: cells
      integer, parameter :: widths(*) = [1, 4, 8, 16, 32, 64], repetitions = 7
      type(blocks_t) :: g(size(widths))
      real(dp) :: t(repetitions, 0:size(widths) + 1), dt
      type(failure_t) :: failure
      integer :: k, r, steps, j
      call filled_box(cells, .false.)
      do k = 1, size(widths)
         call set_up(widths(k), g(k))
      end do
      dt = stable_time_step(1.0e-3_dp, motion%materials, 0.1_dp, 'shear')
      steps = max(3, 1000000/motion%particles%n)
      do r = 1, repetitions
         t(r, 0) = seconds()
         do j = 1, steps
            call advance(motion, dt, failure)
         end do
         t(r, 0) = seconds() - t(r, 0)
         do k = 1, size(widths)
            t(r, k) = seconds()
            do j = 1, steps
               call step(dt, g(k))
            end do
            t(r, k) = seconds() - t(r, k)
         end do
         t(r, size(widths) + 1) = time_to_move(motion%particles%n, bytes, steps)
      end do
      t = 1e9_dp*t/steps/motion%particles%n
      print '(i9, 99f9.1)', motion%particles%n, [(median(t(:, k)), k=0, size(widths) + 1)], &
         2*bytes/(2*median(t(:, size(widths) + 1)))
      flush (output_unit)
   end subroutine measure

   !> Time to read half and write half of `bytes` for each of `n` items, `steps` times [s].
   real(dp) function time_to_move(n, bytes, steps) result(time)
      integer, intent(in) :: n, bytes, steps
      real(dp), allocatable :: from(:), to(:)
      integer(long) :: words, i
      integer :: k
      words = int(n, long)*bytes/16
      allocate (from(words), to(words), source=0.0_dp)
      time = seconds()
      do k = 1, steps
         !$omp parallel do schedule(static)
         do i = 1, words
            to(i) = from(i) + k
         end do
      end do
      time = seconds() - time
      if (to(words) < 0) print *, to(words)      ! the copy is used
   end function time_to_move

   !> Processor time [s].
   real(dp) function seconds()
      call cpu_time(seconds)
   end function seconds

   !> Median of a few numbers.
   pure real(dp) function median(values)
      real(dp), intent(in) :: values(:)
      real(dp) :: rest(size(values))
      integer :: k
      rest = values
      do k = 1, size(values)/2
         rest(maxloc(rest, dim=1)) = -huge(median)
      end do
      median = maxval(rest)
   end function median
end program minimal_step
