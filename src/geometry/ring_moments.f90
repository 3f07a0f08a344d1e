!> Area and first moments of the intersection of a rectangle and a circle, in closed form. In solids volume and first moments of the
!> intersection of a box with a box or a cylinder along an axis, in closed form, and with a sphere, by its slices.
module hampm_ring_moments
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm, in_plane, quarter_turn
   implicit none
   private
   public :: moments_of_circle, moments_of_box, moments_of_cylinder, moments_of_sphere, sort_few

   !> Points of Gauss, from 0 to 1, and their weights.
   real(dp), parameter :: far(6) = [0.9815606342467192_dp, 0.9041172563704748_dp, 0.7699026741943047_dp, &
                                    0.5873179542866175_dp, 0.3678314989981802_dp, 0.1252334085114689_dp]
   real(dp), parameter :: heavy(6) = [0.0471753363865120_dp, 0.1069393259953189_dp, 0.1600783285433461_dp, &
                                      0.2031674267230656_dp, 0.2334925365383546_dp, 0.2491470458134027_dp]
   real(dp), parameter :: gauss(12) = ([-far, far] + 1)/2, weight(12) = [heavy, heavy]/2

contains

   !> Area of a circle around the origin in a box, and its first moments around the lower corner of the box: between intersections
   !> of arc and sides, the inside is bounded by the arcs y = +-s(x), s = sqrt(r^2 - x^2), and the sides. No term is as large as the
   !> circle, whose rounding would be much of a sliver.
   pure function moments_of_circle(lower, upper, r) result(m)
      real(dp), intent(in) :: lower(ndim), upper(ndim), r
      real(dp) :: m(0:ndim)
      real(dp) :: x(6), from, to, s(2), middle
      integer :: k
      m = 0
      x(1) = min(max(lower(1), -r), r)
      x(2) = min(max(upper(1), -r), r)
      x(3:4) = [-1, 1]*sqrt(max(r**2 - lower(2)**2, 0.0_dp))
      x(5:6) = [-1, 1]*sqrt(max(r**2 - upper(2)**2, 0.0_dp))
      x(3:) = min(max(x(3:), x(1)), x(2))
      call sort_few(x)
      do k = 2, size(x)
         from = x(k - 1)
         to = x(k)
         middle = sqrt(max(r**2 - ((from + to)/2)**2, 0.0_dp))
         if (.not. (to > from .and. min(upper(2), middle) > max(lower(2), -middle))) cycle
         s = sqrt(max(r**2 - [from, to]**2, 0.0_dp))
         if (upper(2) < middle) then
            m = m + below_chord(in_plane(from, upper(2)) - lower, in_plane(to, upper(2)) - lower)
         else
            m = m + below_chord(in_plane(from, s(1)) - lower, in_plane(to, s(2)) - lower) &
                + segment(in_plane(from, s(1)), in_plane(to, s(2)), r, lower)
         end if
         if (lower(2) <= -middle) &
            m = m - below_chord(in_plane(from, -s(1)) - lower, in_plane(to, -s(2)) - lower) &
                + segment(in_plane(to, -s(2)), in_plane(from, -s(1)), r, lower)
      end do
   end function moments_of_circle

   !> Volume of the intersection of two boxes, and its first moments around the lower corner of the first.
   pure function moments_of_box(lower, upper, from, to) result(m)
      real(dp), intent(in) :: lower(ndim), upper(ndim), from(ndim), to(ndim)
      real(dp) :: m(0:ndim)
      real(dp) :: first(ndim), last(ndim)
      first = max(lower, from)
      last = min(upper, to)
      m(0) = product(max(last - first, 0.0_dp))
      m(1:) = m(0)*((first + last)/2 - lower)
   end function moments_of_box

   !> The same of a cylinder around an axis through the origin.
   pure function moments_of_cylinder(lower, upper, r, axis, ends) result(m)
      real(dp), intent(in) :: lower(ndim), upper(ndim), r
      integer, intent(in) :: axis                !! its direction
      real(dp), intent(in) :: ends(2)            !! along it
      real(dp) :: m(0:ndim)
      real(dp) :: section(0:ndim), from, to
      integer :: o(2)
      m = 0
      from = max(lower(axis), ends(1))
      to = min(upper(axis), ends(2))
      if (to <= from) return
      o = [1, ndim] + merge([1, 0], [0, merge(-1, 0, axis == ndim)], axis == 1)
      section = moments_of_circle(in_plane(lower(o(1)), lower(o(2))), in_plane(upper(o(1)), upper(o(2))), r)
      m(0) = section(0)*(to - from)
      m(o) = section(1:2)*(to - from)
      m(axis) = m(0)*((from + to)/2 - lower(axis))
   end function moments_of_cylinder

   !> The same of a sphere around the origin: between the heights at which sides and edges of the box leave it, its slices are as
   !> smooth as powers 3/2 of the distance, which a parabolic substitution makes smooth.
   pure function moments_of_sphere(lower, upper, r) result(m)
      real(dp), intent(in) :: lower(ndim), upper(ndim), r
      real(dp) :: m(0:ndim)
      real(dp) :: z(18), slice(0:ndim), at, part, squares(8)
      integer :: k, g
      m = 0
      squares = [lower(:2)**2, upper(:2)**2, lower(1)**2 + [lower(2), upper(2)]**2, upper(1)**2 + [lower(2), upper(2)]**2]
      z(:8) = sqrt(max(r**2 - squares, 0.0_dp))
      z(9:16) = -z(:8)
      z = min(max([z(:16), lower(ndim), upper(ndim)], max(lower(ndim), -r)), min(upper(ndim), r))
      call sort_few(z)
      do k = 2, size(z)
         if (.not. z(k) > z(k - 1)) cycle
         do g = 1, size(gauss)
            at = z(k - 1) + (z(k) - z(k - 1))*gauss(g)**2*(3 - 2*gauss(g))
            part = (z(k) - z(k - 1))*6*gauss(g)*(1 - gauss(g))*weight(g)
            slice = moments_of_circle(in_plane(lower(1), lower(2)), in_plane(upper(1), upper(2)), sqrt(max(r**2 - at**2, 0.0_dp)))
            m(0) = m(0) + part*slice(0)
            m(1:2) = m(1:2) + part*slice(1:2)
            m(ndim) = m(ndim) + part*slice(0)*(at - lower(ndim))
         end do
      end do
   end function moments_of_sphere

   !> Area between the x axis and a chord from a to b, and its first moments.
   pure function below_chord(a, b) result(m)
      real(dp), intent(in) :: a(ndim), b(ndim)
      real(dp) :: m(0:ndim)
      m(0) = (b(1) - a(1))/6*(3*(a(2) + b(2)))
      m(1:) = (b(1) - a(1))/6*in_plane(a(1)*(2*a(2) + b(2)) + b(1)*(a(2) + 2*b(2)), a(2)**2 + a(2)*b(2) + b(2)**2)
   end function below_chord

   !> Area between a chord of a circle around the origin and the arc on its left, no more than half of the circle, and its first
   !> moments around another place: r^2 (angle - sin(angle))/2, and around the middle of the circle (chord)^3/12.
   pure function segment(a, b, r, place) result(m)
      real(dp), intent(in) :: a(ndim), b(ndim), r, place(ndim)
      real(dp) :: m(0:ndim)
      real(dp) :: chord, angle, square, rest
      chord = norm(b - a)
      angle = 2*atan2(chord, norm(a + b))
      square = angle**2
      rest = angle - sin(angle)
      if (angle < 0.5_dp) rest = angle*square/6*(1 - square/20*(1 - square/42*(1 - square/72*(1 - square/110*(1 - square/156)))))
      m(0) = r**2*rest/2
      m(1:) = chord**2*quarter_turn(b - a)/12 - m(0)*place
   end function segment

   !> Put a few numbers into ascending order.
   pure subroutine sort_few(x)
      real(dp), intent(inout) :: x(:)
      real(dp) :: next
      integer :: i, k
      do i = 2, size(x)
         next = x(i)
         k = i - 1
         do while (k >= 1)
            if (x(k) <= next) exit
            x(k + 1) = x(k)
            k = k - 1
         end do
         x(k + 1) = next
      end do
   end subroutine sort_few
end module hampm_ring_moments
