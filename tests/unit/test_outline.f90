!> What a box has of a polygon, of a circle, and of these with holes: areas and first moments, against sums over finer boxes, the whole, and
!> what is known in closed form.
program test_outline
   use hampm_kinds, only: dp, ndim
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use hampm_edge_parts, only: edge_part_t
   use hampm_outline, only: outline_t, ring_t, polygon_ring, circle_ring
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: tol = 1e-10_dp         !! below which two positions are the same place
   type(outline_t) :: star, ring
   integer :: turn

   call repeat_random_numbers()
   allocate (star%rings(1), ring%rings(2))
   star%rings(1) = polygon_ring(reshape([0.0_dp, -1.0_dp, 0.3_dp, -0.2_dp, 1.1_dp, 0.1_dp, 0.2_dp, 0.3_dp, 0.1_dp, 1.2_dp, &
                                         -0.2_dp, 0.25_dp, -0.9_dp, 0.0_dp, -0.15_dp, -0.3_dp], [ndim, 8]))
   ring%rings(1) = circle_ring([0.1_dp, -0.2_dp], 0.9_dp)
   ring%rings(2) = circle_ring([0.2_dp, 0.1_dp], 0.4_dp)
   call check_close(ring%area(), pi*(0.81_dp - 0.16_dp), 1e-14_dp, 'a ring has the area of its circles')
   call check_whole(star, 'star')
   call check_whole(ring, 'ring')
   do turn = 1, 200
      call check_halves(star, 'star')
      call check_halves(ring, 'ring')
   end do
   call check_half_disc()
   call check_cap()
   call check_edges()
   do turn = -9, 0
      call check_tilted(10.0_dp**turn)
   end do
   call check(star%covers([0.0_dp, 0.0_dp]) .and. .not. star%covers([0.8_dp, 0.8_dp]), 'a star covers its middle')
   call check(ring%covers([-0.5_dp, -0.5_dp]) .and. .not. ring%covers([0.2_dp, 0.1_dp]), 'a ring does not cover its hole')
   call check_close(ring%distance([0.2_dp, 0.1_dp]), 0.4_dp, 1e-14_dp, 'the middle of the hole is its radius away')
   call finish()

contains

   !> The boxes of a lattice have all of it together.
   subroutine check_whole(outline, name)
      type(outline_t), intent(in) :: outline
      character(*), intent(in) :: name
      real(dp), parameter :: h = 0.07_dp
      real(dp) :: m(0:ndim), all(0:ndim), box(0:ndim)
      integer :: i, j
      all = 0
      do j = -30, 30
         do i = -30, 30
            m = outline%moments([i, j]*h, [i + 1, j + 1]*h)
            all = all + [m(0), m(1:) + m(0)*[i, j]*h]
         end do
      end do
      box = outline%moments([-2.1_dp, -2.1_dp], [2.17_dp, 2.17_dp])
      call check_close(all(0), outline%area(), 1e-13_dp, name//': its pieces have its area')
      call check(maxval(abs(all(1:) - (box(1:) - 2.1_dp*box(0)))) < 1e-13_dp, name//': and its first moments')
   end subroutine check_whole

   !> A cap of a circle that is 2^-30 of its radius high, on each side, is a piece of a parabola.
   subroutine check_cap()
      real(dp), parameter :: high = 2.0_dp**(-30), wide = 2.0_dp**(-14)
      real(dp) :: m(0:ndim, 4), area
      type(outline_t) :: disc
      integer :: k
      allocate (disc%rings(1))
      disc%rings(1) = circle_ring([0.0_dp, 0.0_dp], 1.0_dp)
      m(:, 1) = disc%moments([-wide, 1 - high], [wide, 1 + wide])
      m(:, 2) = disc%moments([-wide, -1 - wide], [wide, high - 1])
      m(:, 3) = disc%moments([1 - high, -wide], [1 + wide, wide])
      m(:, 4) = disc%moments([-1 - wide, -wide], [high - 1, wide])
      m(2, 2) = (wide + high)*m(0, 2) - m(2, 2)  ! from the side that is in the circle
      m(1, 4) = (wide + high)*m(0, 4) - m(1, 4)
      area = 4*sqrt(2*high)*high/3
      do k = 1, 4
         call check_close(m(0, k), area, 1e-8_dp*area, 'the area of a cap')
         call check_close(m(merge(2, 1, k <= 2), k), 0.4_dp*high*area, 1e-6_dp*high*area, 'its height')
         call check_close(m(merge(1, 2, k <= 2), k), wide*area, 1e-8_dp*wide*area, 'its middle')
      end do
   end subroutine check_cap

   !> A box has what its two halves have.
   subroutine check_halves(outline, name)
      type(outline_t), intent(in) :: outline
      character(*), intent(in) :: name
      real(dp) :: x(5), whole(0:ndim), left(0:ndim), right(0:ndim), middle
      call random_number(x)
      associate (lower => 3*x(1:2) - 1.5_dp, upper => 3*x(1:2) - 1.5_dp + x(3:4))
         middle = lower(1) + x(5)*(upper(1) - lower(1))
         whole = outline%moments(lower, upper)
         left = outline%moments(lower, [middle, upper(2)])
         right = outline%moments([middle, lower(2)], upper)
         right(1) = right(1) + (middle - lower(1))*right(0)
         call check(maxval(abs(whole - left - right)) < 1e-14_dp, name//': a box has what its halves have')
         call check(whole(0) > -1e-15_dp .and. whole(0) <= product(upper - lower)*(1 + 1e-14_dp), &
                    name//': and not more than it holds')
      end associate
   end subroutine check_halves

   !> The centroid of half a disc is 4 r/(3 pi) from its straight side.
   subroutine check_half_disc()
      type(ring_t) :: disc
      real(dp) :: m(0:ndim)
      disc = circle_ring([0.0_dp, 0.0_dp], 2.0_dp)
      m = disc%moments([-3.0_dp, 0.0_dp], [3.0_dp, 3.0_dp])
      call check_close(m(0), 2*pi, 1e-14_dp, 'half a disc: area')
      call check_close(m(2)/m(0), 8/(3*pi), 1e-14_dp, 'half a disc: centroid')
      call check_close(m(1)/m(0), 3.0_dp, 1e-14_dp, 'half a disc: symmetry')
   end subroutine check_half_disc

   !> The parts of edges have their lengths, and normals that point outwards: by Gauss's theorem their sum over x.n is twice the area.
   subroutine check_edges()
      type(edge_part_t), allocatable :: parts(:)
      real(dp) :: twice
      integer :: k
      allocate (parts, source=star%parts_in_box([-2.0_dp, -2.0_dp], [2.0_dp, 2.0_dp], tol, [0.013_dp, 0.017_dp], 0.1_dp, 0))
      twice = sum([(2*norm2(parts(k)%half)*dot_product(parts(k)%middle, parts(k)%normal), k=1, size(parts))])
      call check_close(twice/2, star%area(), 1e-13_dp, 'edges of a polygon')
      parts = ring%parts_in_box([-2.0_dp, -2.0_dp], [2.0_dp, 2.0_dp], tol, [0.0_dp, 0.0_dp], 0.1_dp, 0)
      twice = sum([(2*norm2(parts(k)%half)*dot_product(parts(k)%middle, parts(k)%normal), k=1, size(parts))])
      call check_close(twice/2, ring%area(), 1e-13_dp, 'edges of circles')
      parts = star%parts_in_box([0.0_dp, -1.0_dp], [0.3_dp, -0.2_dp], tol, [0.0_dp, 0.0_dp], 0.1_dp, 0)
      twice = sum([(2*norm2(parts(k)%half), k=1, size(parts))])
      call check_close(twice, norm2([0.3_dp, 0.8_dp]), 1e-13_dp, 'a box around a side has this side')
   end subroutine check_edges

   !> A box around a side of a strip has this side, however little it is tilted, and nothing of the neighbours that leave the box at that angle.
   subroutine check_tilted(angle)
      real(dp), intent(in) :: angle              !! [rad]
      type(outline_t) :: strip
      type(edge_part_t), allocatable :: parts(:)
      real(dp), parameter :: left = 1e-8_dp      ! square root of the rounding of coordinates: neighbours by which they leave the box [m]
      real(dp) :: length, off(ndim)
      integer :: k
      allocate (strip%rings(1))
      strip%rings(1) = polygon_ring(matmul(reshape([cos(angle), sin(angle), -sin(angle), cos(angle)], [ndim, ndim]), &
                                           reshape([-4, -1, 4, -1, 4, 1, -4, 1]/2.0_dp, [ndim, 4])))
      associate (a => strip%rings(1)%points(:, 2), b => strip%rings(1)%points(:, 3))
         allocate (parts, source=strip%parts_in_box(min(a, b), max(a, b), tol, [0.013_dp, 0.017_dp], 0.1_dp, 0))
         length = sum([(2*norm2(parts(k)%half), k=1, size(parts))])
         off = -(a + b)/2
         do k = 1, size(parts)
            off = off + 2*norm2(parts(k)%half)/length*parts(k)%middle
         end do
         call check_close(length, 1.0_dp, left, 'a box around a side of a tilted strip has this side')
         call check(norm2(off) < left, 'and its middle is that of the side')
      end associate
   end subroutine check_tilted
end program test_outline
