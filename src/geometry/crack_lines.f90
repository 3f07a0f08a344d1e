!> A polyline along which cells are cut: its points, its tips, and the parts of it that are open, new, held by cohesion or free.
module hampm_crack_lines
   use hampm_kinds, only: dp, ndim
   use hampm_polygon, only: distance_to_segment
   use hampm_tensors, only: norm
   implicit none
   private
   public :: line_t, length_of, find_nearest_segment, segment_at, room_on_line, both_faces, left_face, right_face, &
             first_point, last_point

   integer, parameter :: first_point = 1, last_point = 2 !! the ends of a line
   integer, parameter :: both_faces = 0, left_face = 1, right_face = 2 !! faces of a line with material

   !> A polyline that cuts.
   type :: line_t
      real(dp), allocatable :: points(:, :)      !! [m], (ndim, 2 or more)
      real(dp), allocatable :: origin(:, :)      !! the same in the reference configuration, where the material carries the line [m]
      logical :: is_tip(2) = .false.             !! whether its first and its last point end inside the material
      logical :: is_through(2) = .false.         !! whether it ends there at a surface or another crack, reached by a tip: cells
                                                 !! are cut to the end of the line
      real(dp) :: beyond(2) = 0                  !! length beyond ends that are no tips, without material [m]
      logical :: contact = .false.               !! whether its sides press on each other
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: bonded(2) = 0                  !! distance of moving tips behind the first and last point: cells
                                                 !! are cut ahead of them, and bonded points hold these; distances are in the
                                                 !! reference configuration [m]
      real(dp) :: grown(2) = 0                   !! advance of each of these tips so far [m]
      integer :: cohesion = 0                    !! number of the cohesive law of its faces; 0: none
      real(dp) :: held(2) = 0                    !! distances from its first point between which it acts [m]
      integer :: face = both_faces               !! faces with material: one on a symmetry plane
      real(dp) :: began(ndim) = 0                !! on a symmetry plane: initial place of the tip at its last point [m]
   contains
      procedure :: open_part
      procedure :: new_part
      procedure :: held_part
      procedure, private :: with_ways
      procedure :: free_part
   end type line_t

contains

   !> The points of the line [m], and below them the points of the reference configuration that define its arc length, if different.
   pure function with_ways(self) result(points)
      class(line_t), intent(in) :: self
      real(dp), allocatable :: points(:, :)
      if (allocated(self%origin)) then
         allocate (points(2*ndim, size(self%points, 2)))
         points(:ndim, :) = self%points
         points(ndim + 1:, :) = self%origin
      else
         points = self%points
      end if
   end function with_ways

   !> The line up to its tips, without the bonded part ahead of them [m].
   pure function open_part(self) result(points)
      class(line_t), intent(in) :: self
      real(dp), allocatable :: points(:, :)
      points = shortened(shortened(self%with_ways(), self%bonded(2)), self%bonded(1), from_first=.true.)
      points = points(:ndim, :)
   end function open_part

   !> The line from the start of a tip, or a distance from it on, to the end of the line that is nearest to the tip, in its
   !> direction of motion [m].
   pure function new_part(self, end, from) result(points)
      class(line_t), intent(in) :: self
      integer, intent(in) :: end                 !! 1 its first, 2 its last point
      real(dp), intent(in), optional :: from     !! [m]
      real(dp), allocatable :: points(:, :)
      real(dp) :: old
      points = self%with_ways()
      old = length_of(points(size(points, 1) - ndim + 1:, :)) - self%bonded(end) - self%grown(end)
      if (present(from)) old = old + from
      points = shortened(points, old, from_first=end == 2)
      if (end == 1) points = points(:, size(points, 2):1:-1)
      points = points(:ndim, :)
   end function new_part

   !> The part of the line whose faces hold each other by cohesion [m].
   pure function held_part(self) result(points)
      class(line_t), intent(in) :: self
      real(dp), allocatable :: points(:, :)
      points = shortened(shortened(self%points, length_of(self%points) - self%held(2)), self%held(1), from_first=.true.)
   end function held_part

   !> The line up to its tips, without the part that cohesion holds or has held [m].
   pure function free_part(self) result(points)
      class(line_t), intent(in) :: self
      real(dp), allocatable :: points(:, :)
      points = self%open_part()
      if (self%cohesion > 0) points = shortened(self%points, length_of(self%points) - self%held(1))
   end function free_part

   !> Length of a polyline [m].
   pure real(dp) function length_of(points) result(length)
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, 2 or more)
      integer :: k
      length = sum([(norm(points(:, k) - points(:, k - 1)), k=2, size(points, 2))])
   end function length_of

   !> The segment of a polyline that is nearest to a place, if nearer than the one found before.
   pure subroutine find_nearest_segment(points, x, nearest, last, along)
      real(dp), intent(in) :: points(:, :), x(ndim) !! [m]
      real(dp), intent(inout) :: nearest         !! the least distance so far [m]
      integer, intent(out) :: last               !! number of the last point of the segment; 0 where none is nearer
      real(dp), intent(out) :: along             !! position along it, from 0 at its first point to 1 at its last [-]
      real(dp) :: distance, way
      integer :: k
      last = 0
      along = 0
      do k = 2, size(points, 2)
         associate (a => points(:, k - 1), b => points(:, k))
            way = dot_product(x - a, b - a)/sum((b - a)**2)
            distance = norm(x - a - min(max(way, 0.0_dp), 1.0_dp)*(b - a))
         end associate
         if (distance >= nearest) cycle
         nearest = distance
         last = k
         along = way
      end do
   end subroutine find_nearest_segment

   !> The first segment of a polyline that two places are on, by its last point; 0 where they are on none.
   pure integer function segment_at(points, x, y, tolerance) result(k)
      real(dp), intent(in) :: points(:, :), x(ndim), y(ndim), tolerance !! [m]
      do k = 2, size(points, 2)
         if (max(distance_to_segment(x, points(:, k - 1), points(:, k)), distance_to_segment(y, points(:, k - 1), points(:, k))) &
             <= tolerance) return
      end do
      k = 0
   end function segment_at

   !> The largest radius around a place on a segment of a polyline free of the rest of it and of the end of this segment [m].
   pure real(dp) function room_on_line(points, x, last, at_first) result(radius)
      real(dp), intent(in) :: points(:, :), x(ndim) !! [m]
      integer, intent(in) :: last                !! number of the last point of the segment
      logical, intent(in) :: at_first            !! whether the place is towards its first point
      integer :: k
      radius = norm(x - points(:, merge(last, last - 1, at_first)))
      do k = 2, size(points, 2)
         if (k /= last) radius = min(radius, distance_to_segment(x, points(:, k - 1), points(:, k)))
      end do
   end function room_on_line

   !> A polyline without the last part of a length, or without the first [m]; with more than two rows the last two give the length.
   pure function shortened(points, by, from_first) result(shorter)
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim or more, 2 or more)
      real(dp), intent(in) :: by                 !! [m]
      logical, intent(in), optional :: from_first
      real(dp), allocatable :: shorter(:, :)
      real(dp), parameter :: rounding = 1e-9_dp  ! part of a segment below which nothing of it is left: it would have no direction
      real(dp) :: left, length
      integer :: n, row
      shorter = points
      if (.not. by > 0) return
      row = size(points, 1) - ndim + 1
      if (present(from_first)) then
         if (from_first) shorter = points(:, size(points, 2):1:-1)
      end if
      left = by
      n = size(shorter, 2)
      do
         length = norm(shorter(row:, n) - shorter(row:, n - 1))
         if (length*(1 - rounding) > left .or. n == 2) exit
         left = max(0.0_dp, left - length)
         n = n - 1
      end do
      shorter(:, n) = shorter(:, n) - min(left/length, 1 - epsilon(left))*(shorter(:, n) - shorter(:, n - 1))
      shorter = shorter(:, :n)
      if (present(from_first)) then
         if (from_first) shorter = shorter(:, n:1:-1)
      end if
   end function shortened
end module hampm_crack_lines
