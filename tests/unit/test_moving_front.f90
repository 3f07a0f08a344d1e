!> Fronts that advance: discs stay discs, ellipses become their parallel curves, kinks round off, fronts slide along sides and end.
program test_moving_front
   use hampm_kinds, only: dp, ndim
   use hampm_harness, only: check, check_close, finish
   use hampm_front, only: region_t, front_t, crack_shape_t, region_of, find_fronts
   use hampm_moving_front, only: advance_region
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp), h = 0.1_dp
   real(dp), parameter :: low(ndim) = 0, wide(ndim) = -9

   call check_disc(wide, 'a disc')
   call check_disc(low, 'a quarter of a disc')
   call check_ellipse()
   call check_lines()
   call check_polygons()
   call check_ends()
   call finish()

contains

   !> A region with its fronts in a box.
   function shape_of(front, center, radii, points) result(region)
      character(*), intent(in) :: front
      real(dp), intent(in) :: center(ndim), radii(:)
      real(dp), intent(in), optional :: points(:, :)
      type(region_t) :: region
      type(crack_shape_t) :: shape
      shape%front = front
      shape%center = center
      shape%radii = radii
      shape%direction = [0.0_dp, 1.0_dp]
      if (present(points)) shape%points = points
      region = region_of(shape, low, low + 3, h)
   end function shape_of

   !> Let a region advance by a way that is a function of the normal and the place along the first axis.
   subroutine advance(region, lower, upper, way, n, meets)
      type(region_t), intent(inout) :: region
      real(dp), intent(in) :: lower(ndim), upper(ndim)
      real(dp), intent(in) :: way(3)             !! w = way(1) + way(2) outward(1)**2 + way(3) x
      integer, intent(in) :: n                   !! how often
      logical, intent(out) :: meets
      type(front_t), allocatable :: fronts(:)
      real(dp), allocatable :: ways(:)
      integer :: i, f, k
      region%lower = lower
      region%upper = upper
      do i = 1, n
         call find_fronts(region, fronts)
         ways = [real(dp) ::]
         do f = 1, size(fronts)
            ways = [ways, (way(1) + way(2)*fronts(f)%outward(1, k)**2 + way(3)*place(fronts(f)%on_outline(k), region), &
                           k=1, fronts(f)%n())]
         end do
         call advance_region(region, fronts, ways, meets)
         if (meets) return
      end do
   end subroutine advance

   !> First coordinate of a place along an outline.
   real(dp) function place(on, region)
      real(dp), intent(in) :: on
      type(region_t), intent(in) :: region
      real(dp) :: left, length
      integer :: k, next
      left = on
      place = 0
      do k = 1, size(region%outline, 2)
         next = modulo(k, size(region%outline, 2)) + 1
         length = norm2(region%outline(:, next) - region%outline(:, k))
         place = region%outline(1, k) + left/length*(region%outline(1, next) - region%outline(1, k))
         if (left <= length) return
         left = left - length
      end do
   end function place

   !> Area of a region in a box.
   real(dp) function area_in(region, lower, upper) result(area)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: lower(ndim), upper(ndim)
      real(dp) :: middle(2), rest
      call region%uncracked(lower, upper, rest, middle)
      area = product(upper - lower) - rest
   end function area_in

   !> All its nodes advance alike.
   subroutine check_disc(lower, name)
      real(dp), intent(in) :: lower(ndim)
      character(*), intent(in) :: name
      type(region_t) :: region
      logical :: meets
      real(dp) :: r(2)
      region = shape_of('disc', low, [0.6_dp])
      call advance(region, lower, -lower + merge(3, 0, lower(1) >= 0), [0.012_dp, 0.0_dp, 0.0_dp], 100, meets)
      call check_close(area_in(region, low, low + 3), pi*1.8_dp**2/4, 1e-4_dp, name//' that advances everywhere alike')
      r = [minval(norm2(region%outline, dim=1)), maxval(norm2(region%outline, dim=1))]
      call check(maxval(abs(r - 1.8_dp)) < 2e-3_dp, name//' stays one')
   end subroutine check_disc

   !> The support function of a convex region grows by the way of each normal.
   subroutine check_ellipse()
      type(region_t) :: region
      logical :: meets
      real(dp) :: support, normal(2), off
      integer :: k
      region = shape_of('ellipse', low, [1.0_dp, 0.5_dp])
      call advance(region, wide, -wide, [0.005_dp, 0.0_dp, 0.0_dp], 100, meets)
      off = 0
      do k = 0, 90
         normal = [cos(k*pi/180), sin(k*pi/180)]
         support = sqrt(normal(1)**2 + 0.25_dp*normal(2)**2) + 0.5_dp
         off = max(off, abs(maxval(matmul(normal, region%outline)) - support))
      end do
      call check(off < 3e-3_dp, 'an ellipse that advances everywhere alike is its parallel curve')
      region = shape_of('ellipse', low, [1.0_dp, 0.5_dp])
      call advance(region, wide, -wide, [0.01_dp, -0.01_dp, 0.0_dp], 50, meets)
      call check_close(maxval(region%outline(1, :)), 1.0_dp, 5e-3_dp, 'where its way is 0 it stays')
      call check_close(maxval(region%outline(2, :)), 1.0_dp, 1e-3_dp, 'and goes on elsewhere')
   end subroutine check_ellipse

   !> Half planes.
   subroutine check_lines()
      type(region_t) :: region
      logical :: meets
      real(dp), allocatable :: inside(:)
      region = shape_of('straight', [0.0_dp, 1.0_dp], [0.0_dp])
      call advance(region, low, low + 3, [0.0123_dp, 0.0_dp, 0.0_dp], 50, meets)
      inside = pack(region%outline(2, :), region%outline(1, :) > -0.1_dp .and. region%outline(1, :) < 3.1_dp)
      call check(maxval(abs(inside - 1 - 50*0.0123_dp)) < 1e-13_dp, 'a straight front stays straight')
      region = shape_of('straight', [0.0_dp, 1.0_dp], [0.0_dp])
      call advance(region, low, low + 3, [0.0_dp, 0.0_dp, 0.002_dp], 20, meets)
      call check_close(area_in(region, low, low + 3), 3 + 0.04_dp*4.5_dp, 1e-3_dp, 'one that goes faster at one end turns')
   end subroutine check_lines

   !> A square becomes one with round corners, and a notch stays sharp.
   subroutine check_polygons()
      type(region_t) :: region
      logical :: meets
      region = shape_of('polygon', low, [0.0_dp], reshape([1.0_dp, 1.0_dp, 2.0_dp, 1.0_dp, 2.0_dp, 2.0_dp, 1.0_dp, 2.0_dp], [2, 4]))
      call advance(region, low, low + 3, [0.02_dp, 0.0_dp, 0.0_dp], 20, meets)
      call check_close(area_in(region, low, low + 3), 1 + 4*0.4_dp + pi*0.16_dp, 1e-4_dp, 'a square gets round corners')
      region = shape_of('polygon', low, [0.0_dp], reshape([0.0_dp, 0.0_dp, 2.0_dp, 0.0_dp, 2.0_dp, 1.0_dp, 1.0_dp, 1.0_dp, &
                                                           1.0_dp, 2.0_dp, 0.0_dp, 2.0_dp], [2, 6]))
      call advance(region, wide, -wide, [0.02_dp, 0.0_dp, 0.0_dp], 20, meets)
      call check(.not. meets, 'a concave region does not meet itself at once')
      call check_close(area_in(region, wide, -wide), 3 + 8*0.4_dp + 5*pi*0.16_dp/4 - 0.16_dp, 1e-3_dp, &
                       'a concave corner stays one')
   end subroutine check_polygons

   !> A disc opens to the sides it meets, and a body is cracked through in the end.
   subroutine check_ends()
      type(region_t) :: region
      type(front_t), allocatable :: fronts(:)
      logical :: meets
      region = shape_of('disc', low + 1.2_dp, [0.6_dp])
      region%upper = [3.0_dp, 2.0_dp]
      call find_fronts(region, fronts)
      call check(size(fronts) == 1 .and. fronts(1)%is_closed, 'a disc inside')
      call check_close(sum(fronts(1)%weight), fronts(1)%length, 1e-13_dp, 'its nodes have its length together')
      call advance(region, low, [3.0_dp, 2.0_dp], [0.05_dp, 0.0_dp, 0.0_dp], 5, meets)
      call find_fronts(region, fronts)
      call check(size(fronts) == 1 .and. .not. fronts(1)%is_closed, 'is open where it has met a side')
      call advance(region, low, [3.0_dp, 2.0_dp], [0.05_dp, 0.0_dp, 0.0_dp], 40, meets)
      call find_fronts(region, fronts)
      call check(size(fronts) == 0 .and. .not. meets, 'and has no front where it has run through')
      call check_close(area_in(region, low, [3.0_dp, 2.0_dp]), 6.0_dp, 1e-12_dp, 'all is cracked then')
      region = shape_of('polygon', low, [0.0_dp], reshape([0.0_dp, 0.0_dp, 3.0_dp, 0.0_dp, 3.0_dp, 2.0_dp, 2.6_dp, 2.0_dp, &
                                                           2.0_dp, 0.5_dp, 1.0_dp, 0.5_dp, 0.4_dp, 2.0_dp, 0.0_dp, 2.0_dp], [2, 8]))
      call advance(region, wide, -wide, [0.2_dp, 0.0_dp, 0.0_dp], 10, meets)
call check(.not. meets .and. maxval(region%outline(2, :)) > 3.9_dp, 'a notch closes from its bottom')
      call check_close(area_in(region, wide, -wide), 26 + 4*pi - (4.4_dp - 4*asin(0.55_dp) - 1.1_dp*sqrt(2.79_dp)), &
                       0.01_dp, 'and is gone in the end')
      region = shape_of('polygon', low, [0.0_dp], reshape([0.0_dp, 0.0_dp, 3.0_dp, 0.0_dp, 3.0_dp, 2.0_dp, 1.6_dp, 2.0_dp, 1.6_dp, &
                                                           1.9_dp, 2.6_dp, 1.0_dp, 0.4_dp, 1.0_dp, 1.4_dp, 1.9_dp, 1.4_dp, 2.0_dp, &
                                                           0.0_dp, 2.0_dp], [2, 10]))
      call advance(region, wide, -wide, [0.2_dp, 0.0_dp, 0.0_dp], 10, meets)
      call check(meets, 'one that closes at its mouth does not')
   end subroutine check_ends
end program test_moving_front
