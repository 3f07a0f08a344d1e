!> Filling bodies with material points.
module hampm_bodies
   use hampm_kinds, only: dp, ndim, corners
   use hampm_domains, only: reference_corners
   use hampm_outline, only: outline_t, least_part
   use hampm_particles, only: particles_t
   use hampm_tensors, only: quarter_turn
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: points_along, points_off_lines, pieces_t, cut_into_pieces, fill_rectangle, fill_outline, add_spin

   !> The parts of a body in the boxes of a lattice.
   type :: pieces_t
      integer :: n = 0
      real(dp), allocatable :: area(:)           !! [m2], in solids volume [m3]; (n and more)
      real(dp), allocatable :: centroid(:, :)    !! [m], (ndim, n and more)
      real(dp) :: spacing = 0                    !! of the lattice [m]
   end type pieces_t

contains

   !> Number of points in each direction of a rectangle with about `points_per_cell` points in each cell and direction.
   pure function points_along(lower, upper, cell, points_per_cell) result(n)
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the rectangle [m]
      real(dp), intent(in) :: cell                      !! size of a cell [m]
      integer, intent(in) :: points_per_cell
      integer :: n(ndim)
      n = nint(max(1.0_dp, (upper - lower)/(cell/points_per_cell)))
   end function points_along

   !> The same without points on a grid line, where the strain is taken from the cell on one side: as few more points per cell as
   !> that takes, one where the body begins half a cell beside a line and their number is odd.
   pure function points_off_lines(lower, upper, cell, points_per_cell, origin) result(n)
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the rectangle [m]
      real(dp), intent(in) :: cell                      !! size of a cell [m]
      integer, intent(in) :: points_per_cell
      real(dp), intent(in) :: origin(ndim)              !! a node [m]
      integer, parameter :: most = 16                   ! that are added; few are for any body but a slit
      integer :: n(ndim)
      integer :: more, d
      n = points_along(lower, upper, cell, points_per_cell)
      do d = 1, ndim
         do more = 1, most
            if (n(d) == huge(n)) exit
            if (.not. any_on_line((lower(d) - origin(d))/cell, (upper(d) - lower(d))/cell, n(d))) exit
            n(d) = nint(min(max(n(d) + 1.0_dp, (upper(d) - lower(d))/(cell/(points_per_cell + more))), real(huge(n), dp)))
         end do
      end do
   end function points_off_lines

   !> Whether any of `n` points, evenly along a body, is on a grid line.
   pure logical function any_on_line(begin, length, n) result(is)
      real(dp), intent(in) :: begin                     !! of the body, from a node on [cells]
      real(dp), intent(in) :: length                    !! [cells]
      integer, intent(in) :: n
      integer, parameter :: looked_at = 10000           ! of the points of a very long body
      real(dp), parameter :: grace = 1e-9_dp            ! [cells]
      real(dp) :: x
      integer :: k
      is = .true.
      do k = 0, min(n, looked_at) - 1
         x = begin + (k + 0.5_dp)*length/n
         if (abs(x - anint(x)) <= grace) return
      end do
      is = .false.
   end function any_on_line

   !> Place points at the centres of the `n` equal parts of a rectangle. They are numbered on from `first`, at rest
   !> relative to `velocity`, and share the area of the rectangle equally, whether or not it ends on cell edges.
   pure subroutine fill_rectangle(p, first, n, lower, upper, thickness, density, velocity, material, body)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: first                      !! number of the first particle to set
      integer, intent(in) :: n(ndim)                    !! points in each direction
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the rectangle [m]
      type(thickness_t), intent(in) :: thickness
      real(dp), intent(in) :: density                   !! [kg/m3]
      real(dp), intent(in) :: velocity(ndim)            !! [m/s]
      integer, intent(in) :: material, body             !! their indices
      real(dp) :: spacing(ndim)
      integer :: i, k, d, rest, c(ndim)
      spacing = (upper - lower)/n
      call note_spacing(p, body, spacing)
      do k = 0, product(n) - 1
         rest = k
         do d = 1, ndim
            c(d) = mod(rest, n(d))
            rest = rest/n(d)
         end do
         i = first + k
         p%reference(i, :) = lower + (c + 0.5_dp)*spacing
         p%volume(i) = product(spacing)*thickness%at(p%reference(i, :))
         p%mass(i) = density*p%volume(i)
         p%velocity(i, :) = velocity
         p%material(i) = material
         p%body(i) = body
         p%id(i) = i
      end do
   end subroutine fill_rectangle

   !> Cut the inside of an outline into its parts in boxes of a lattice.
   pure subroutine cut_into_pieces(outline, origin, cell, points_per_cell, pieces)
      type(outline_t), intent(in) :: outline
      real(dp), intent(in) :: origin(ndim)       !! a corner of a cell [m]
      real(dp), intent(in) :: cell               !! size of a cell [m]
      integer, intent(in) :: points_per_cell     !! boxes of the lattice in a cell and direction
      type(pieces_t), intent(out) :: pieces
      real(dp) :: m(0:ndim), lower(ndim)
      integer :: first(ndim), last(ndim), along(ndim), i, d, room
      pieces%spacing = cell/points_per_cell
      associate (spacing => pieces%spacing, outer => outline%rings(1))
         first = floor((outer%lower() - origin)/spacing)
         last = ceiling((outer%upper() - origin)/spacing) - 1
         along = last - first + 1
         room = product(along)
         allocate (pieces%area(room), pieces%centroid(ndim, room))
         do i = 0, room - 1
            lower = origin + [(real(first(d) + mod(i/product(along(:d - 1)), along(d)), dp), d=1, ndim)]*spacing
            m = outline%moments(lower, lower + spacing)
            if (m(0) <= least_part*spacing**ndim) cycle
            pieces%n = pieces%n + 1
            pieces%area(pieces%n) = m(0)
            pieces%centroid(:, pieces%n) = lower + m(1:)/m(0)
         end do
      end associate
   end subroutine cut_into_pieces

   !> Place a point at the centroid of each piece of a body, as `fill_rectangle`.
   pure subroutine fill_outline(p, first, pieces, thickness, density, velocity, material, body)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: first               !! number of the first particle to set
      type(pieces_t), intent(in) :: pieces
      type(thickness_t), intent(in) :: thickness
      real(dp), intent(in) :: density            !! [kg/m3]
      real(dp), intent(in) :: velocity(ndim)     !! [m/s]
      integer, intent(in) :: material, body      !! their indices
      integer :: i, k
      call note_spacing(p, body, spread(pieces%spacing, 1, ndim))
      do k = 1, pieces%n
         i = first + k - 1
         p%reference(i, :) = pieces%centroid(:, k)
         p%volume(i) = pieces%area(k)*thickness%at(p%reference(i, :))
         p%mass(i) = density*p%volume(i)
         p%velocity(i, :) = velocity
         p%material(i) = material
         p%body(i) = body
         p%id(i) = i
      end do
   end subroutine fill_outline

   !> Let a body turn around its centre of mass, in addition to the velocity of its particles, and the corners of their domains.
   pure subroutine add_spin(p, body, spin)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: body
      real(dp), intent(in) :: spin(:)            !! anticlockwise, of a solid around each axis [rad/s]
      real(dp) :: centre(ndim), mass, arm(ndim), arms(ndim, corners)
      integer :: i
      centre = 0
      mass = 0
      do i = 1, p%n
         if (p%body(i) /= body) cycle
         mass = mass + p%mass(i)
         centre = centre + p%mass(i)*p%reference(i, :)
      end do
      centre = centre/mass
      do i = 1, p%n
         if (p%body(i) /= body) cycle
         arm = p%reference(i, :) - centre
         if (ndim > 2) then
            p%velocity(i, :) = p%velocity(i, :) + cshift(spin, 1)*cshift(arm, -1) - cshift(spin, -1)*cshift(arm, 1)
            cycle
         end if
         p%velocity(i, :) = p%velocity(i, :) + spin(1)*quarter_turn(arm)
         if (.not. allocated(p%corner_velocity)) cycle
         arms = reference_corners(p, i) - spread(centre, 2, corners)
         p%corner_velocity(i, 1, :) = p%corner_velocity(i, 1, :) - spin(1)*arms(2, :)
         p%corner_velocity(i, 2, :) = p%corner_velocity(i, 2, :) + spin(1)*arms(1, :)
      end do
   end subroutine add_spin

   !> Record the spacing of the points of a body.
   pure subroutine note_spacing(p, body, spacing)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: body
      real(dp), intent(in) :: spacing(ndim)
      real(dp), allocatable :: longer(:, :)
      if (.not. allocated(p%spacing)) allocate (p%spacing(ndim, 0))
      if (size(p%spacing, 2) < body) then
         allocate (longer(ndim, body), source=0.0_dp)
         longer(:, :size(p%spacing, 2)) = p%spacing
         call move_alloc(longer, p%spacing)
      end if
      p%spacing(:, body) = spacing
   end subroutine note_spacing
end module hampm_bodies
