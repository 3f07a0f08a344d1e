!> Gap and normal of two bodies around a node, by the extents of their particles (docs/explanation/contact.md, solids.md).
!>
!> A particle reaches as far as its part of the body, deformed with it: a parallelogram with the half sides h_d = F e_d l_d/2, which
!> in a direction n reaches sum_d |n . h_d|, and no farther than the outline of the body. The normal is that of the line which
!> separates the particles of both bodies with the widest margin, one for both (collinear, as Lemiale, Hurmane & Nairn 2010 and
!> Nairn 2013 make the normals; gradients of mass or volume, Bardenhagen et al. 2001, turn by ten degrees and more; Nairn,
!> Hammerquist & Smith 2020 find such a line by logistic regression). The gap is the distance of both surfaces in that direction, on
!> the line through the node: upper hulls of the extents. The widest margin would be less where surfaces curve.
!>
!> In space the simplex method finds both (`hull_t`). The margin in a direction n + g is the least (n + g) . v of all places v of
!> one body from places of the other; it is greatest for the highest plane, of those below all v, over the origin, which gives the g
!> to turn n by.
module hampm_body_extents
   use hampm_kinds, only: dp, ndim
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_domain_pass, only: corner_map_t
   use hampm_dofs, only: element_of_slot
   use hampm_grid, only: grid_t
   use hampm_particles, only: particles_t, spacing_of
   use hampm_tensors, only: norm, in_plane, identity, inverse_transpose
   implicit none
   private
   public :: extents_t, gather_extents, find_normal_and_gap

   !> Extent of a particle.
   type :: extent_t
      integer :: particle = 0                    !! its number
      real(dp) :: place(ndim) = 0                !! from the node [m]
      real(dp) :: half(ndim, ndim) = 0           !! half sides [m]
      real(dp) :: reach(ndim) = 0                !! in the last direction asked for: along it and across; in space, where it is [m]
   end type extent_t

   !> The particles of a body around a node.
   type :: extents_t
      integer :: n = 0                           !! their number
      type(extent_t), allocatable :: list(:)     !! (n and more)
      real(dp) :: toward(ndim) = 0               !! sum of place times volume [m4]
   end type extents_t

   !> The part of a hull over the origin, of `ndim` corners, and its plane. Low corners far away bound the slopes of the plane.
   type :: hull_t
      real(dp) :: way = 0, low = 0               !! place along an axis, either way, and height of the far ones [m]
      real(dp) :: corner(ndim, ndim) = 0         !! 1 and the place [m], of each
      real(dp) :: height(ndim) = 0               !! of each [m]
      integer :: axis(ndim) = 0                  !! of those that are far ones, 0 for none
      real(dp) :: plane(ndim) = 0                !! height over the origin [m] and slopes [-]
   end type hull_t

   real(dp), parameter :: pi = acos(-1.0_dp)
   integer, parameter :: looks = 8               !! directions tried, on each side of the line from middle to middle
   real(dp), parameter :: turn = pi/(2*looks)    !! from one to the next [rad]
   integer, parameter :: sections = 36           !! of the angle around the best of these, by the golden section: to rounding
   real(dp), parameter :: far = 0.5_dp           !! cells: bodies farther apart do not meet in a step
   integer, parameter :: most_turns = 12         !! of a normal in space
   integer, parameter :: most_corners = 60       !! that a hull tries
   real(dp), parameter :: rounding = 1e-13_dp    !! cells

contains

   !> Gather the particles in the elements at a node; with domains, the ones with a corner there.
   subroutine gather_extents(grid, p, blocks, map, node, e)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(corner_map_t), intent(in) :: map      !! of domains, where particles have any
      integer, intent(in) :: node
      type(extents_t), intent(inout) :: e
      integer :: k, i
      e%toward = 0
      e%n = 0
      if (.not. allocated(e%list)) allocate (e%list(16))
      associate (elements => grid%dofs%elements_at(node), here => grid%node_position(:, node))
         if (allocated(p%corner_velocity)) then
            do k = 1, size(elements)
               do i = map%first(elements(k)), map%first(elements(k) + 1) - 1
                  if (all(e%list(:e%n)%particle /= element_of_slot(map%slot(i)))) &
                     call add_particle(p, element_of_slot(map%slot(i)), here, e)
               end do
            end do
         else
            do k = 1, size(elements)
               do i = blocks%first_in(elements(k)), blocks%last_in(elements(k)), blocks%stride_in(elements(k))
                  call add_particle(p, i, here, e)
               end do
            end do
         end if
      end associate
   end subroutine gather_extents

   !> Add a particle.
   subroutine add_particle(p, i, here, e)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp), intent(in) :: here(ndim)         !! place of the node [m]
      type(extents_t), intent(inout) :: e
      real(dp) :: side(ndim)                     ! of the rectangle that it stands for, in the reference configuration [m]
      if (e%n == size(e%list)) e%list = [e%list, e%list]
      e%n = e%n + 1
      side = spacing_of(p, i)
      if (p%has_outline(p%body(i)) .and. ndim == 2) side = side*sqrt(p%area_of(i)/product(side)) ! cut by an outline: of equal area
      associate (new => e%list(e%n))
         new%particle = i
         new%place = p%position(i) - here
         new%half = (identity + p%gradient_of(i))*spread(side/2, 1, ndim)
         e%toward = e%toward + p%volume(i)*new%place
      end associate
   end subroutine add_particle

   !> Extent of the particles of a body in a direction, each by itself.
   subroutine find_reach(p, normal, e)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: normal(ndim)
      type(extents_t), intent(inout) :: e
      real(dp) :: box, way, origin(ndim)
      integer :: k
      do k = 1, e%n
         associate (of => e%list(k), i => e%list(k)%particle)
            box = sum(abs(matmul(normal, of%half)))
            way = huge(way)
            if (p%has_outline(p%body(i))) then
               origin = p%reference(i, :)
               way = p%outlines(p%body(i))%way_out(origin, back(p%gradient_of(i), normal))
               box = min(box, way)
            end if
            if (ndim > 2) then
               of%reach = of%place
               if (way > box) then
                  of%reach = of%reach + matmul(of%half, sign(1.0_dp, matmul(normal, of%half)))
               else
                  of%reach = of%reach + way*normal
               end if
               cycle
            end if
            of%reach = in_plane(dot_product(of%place, normal) + box, normal(1)*of%place(2) - normal(2)*of%place(1))
         end associate
      end do
   end subroutine find_reach

   !> Inverse map of a vector of the deformed body: F**(-1) v.
   pure function back(h, v) result(origin)
      real(dp), intent(in) :: h(ndim, ndim)      !! F - I
      real(dp), intent(in) :: v(ndim)
      real(dp) :: origin(ndim)
      associate (f => identity + h)
         if (ndim > 2) then
            origin = matmul(v, inverse_transpose(f))
            return
         end if
         origin = in_plane(f(2, 2)*v(1) - f(1, 2)*v(2), f(1, 1)*v(2) - f(2, 1)*v(1))/(f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1))
      end associate
   end function back

   !> Margin between two bodies in a direction, from the first to the second: negative where they overlap [m].
   real(dp) function margin(p, a, b, normal)
      type(particles_t), intent(in) :: p
      type(extents_t), intent(inout) :: a, b
      real(dp), intent(in) :: normal(ndim)
      call find_reach(p, normal, a)
      call find_reach(p, -normal, b)
      if (ndim > 2) then
         margin = dot_product(normal, reached_by(b, -normal) - reached_by(a, normal))
         return
      end if
      margin = -maxval(a%list(:a%n)%reach(1)) - maxval(b%list(:b%n)%reach(1))
   end function margin

   !> The normal from one body to another around a node, and their gap.
   subroutine find_normal_and_gap(p, cell, a, b, normal, gap)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: cell               !! size of the smallest cell at the node [m]
      type(extents_t), intent(inout) :: a, b
      real(dp), intent(out) :: normal(ndim)      !! unit vector from a to b
      real(dp), intent(out) :: gap               !! negative where they overlap, huge where they are too far apart to meet [m]
      real(dp), parameter :: golden = (sqrt(5.0_dp) - 1)/2
      real(dp) :: between(ndim)                  ! centres [m]
      real(dp) :: first, angle, widest, best, low, high, left, right, of_left, of_right
      integer :: k
      gap = huge(gap)
      if (ndim > 2) then
         call find_in_space(p, cell, a, b, normal, gap)
         return
      end if
      between = b%toward/sum(p%volume(b%list(:b%n)%particle)) - a%toward/sum(p%volume(a%list(:a%n)%particle))
      first = atan2(between(2), between(1))
      angle = first
      best = -huge(best)
      do k = 0, 2*looks
         low = first + (k + 1)/2*turn*(1 - 2*mod(k, 2))
         normal = direction(low)
         widest = margin(p, a, b, normal)
         if (widest > far*cell) return
         if (widest <= best) cycle
         best = widest
         angle = low
      end do
      low = angle - turn
      high = angle + turn
      left = high - golden*(high - low)
      right = low + golden*(high - low)
      of_left = margin(p, a, b, direction(left))
      of_right = margin(p, a, b, direction(right))
      do k = 1, sections
         if (of_left >= of_right) then
            high = right
            right = left
            of_right = of_left
            left = high - golden*(high - low)
            of_left = margin(p, a, b, direction(left))
         else
            low = left
            left = right
            of_left = of_right
            right = low + golden*(high - low)
            of_right = margin(p, a, b, direction(right))
         end if
      end do
      normal = direction((low + high)/2)
      if (margin(p, a, b, normal) <= far*cell) gap = -surface(a) - surface(b)
   end subroutine find_normal_and_gap

   !> The place to which a body reaches farthest in a direction [m].
   pure function reached_by(e, normal) result(place)
      type(extents_t), intent(in) :: e
      real(dp), intent(in) :: normal(ndim)
      real(dp) :: place(ndim)
      integer :: k
      place = e%list(1)%reach
      do k = 2, e%n
         if (dot_product(normal, e%list(k)%reach) > dot_product(normal, place)) place = e%list(k)%reach
      end do
   end function reached_by

   !> The same in space: n is turned as long as that widens the margin.
   subroutine find_in_space(p, cell, a, b, normal, gap)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: cell
      type(extents_t), intent(inout) :: a, b
      real(dp), intent(out) :: normal(ndim), gap
      real(dp), parameter :: wide = 8            ! cells: beyond all places of two bodies around a node
      type(hull_t) :: hull
      real(dp) :: turned(ndim), v(ndim), most, widest, found
      integer :: turn, k
      logical :: is_done
      gap = huge(gap)
      normal = b%toward/sum(p%volume(b%list(:b%n)%particle)) - a%toward/sum(p%volume(a%list(:a%n)%particle))
      normal = normal/norm(normal)
      widest = margin(p, a, b, normal)
      most = 1
      do turn = 1, most_turns
         if (widest > far*cell) return
         hull = far_corners(wide*cell, -widest - most*wide*cell)
         turned = normal
         do k = 1, most_corners
            if (k > 1) found = margin(p, a, b, turned)
            v = reached_by(b, -turned) - reached_by(a, turned)
            call take_corner(hull, across(normal, v), -dot_product(normal, v), rounding*cell, is_done)
            if (is_done) exit
            turned = normal + from_across(normal, hull%plane(2:))
            turned = turned/norm(turned)
         end do
         if (-hull%plane(1) <= widest + 2*rounding*cell) exit
         found = margin(p, a, b, turned)
         if (found > widest) then
            normal = turned
            widest = found
         else
            most = most/4
         end if
      end do
      call find_reach(p, normal, a)
      call find_reach(p, -normal, b)
      gap = -height_over(a, normal, cell) - height_over(b, -normal, cell)
   end subroutine find_in_space

   !> Components of a vector across a direction, along two axes at right angles to it, turned with it from those of the grid.
   pure function across(normal, v) result(components)
      real(dp), intent(in) :: normal(ndim), v(ndim)
      real(dp) :: components(ndim - 1)
      integer :: d, axis
      axis = maxloc(abs(normal), dim=1)
      do d = 1, ndim - 1
         associate (other => mod(axis + d - 1, ndim) + 1)
            components(d) = v(other) - normal(other)*(dot_product(normal, v) + sign(1.0_dp, normal(axis))*v(axis)) &
                            /(1 + abs(normal(axis)))
         end associate
      end do
   end function across

   !> The vector with these components.
   pure function from_across(normal, components) result(v)
      real(dp), intent(in) :: normal(ndim), components(ndim - 1)
      real(dp) :: v(ndim)
      integer :: d
      v = [(dot_product(components, across(normal, identity(:, d))), d=1, ndim)]
   end function from_across

   !> A hull of far corners.
   pure type(hull_t) function far_corners(way, low) result(hull)
      real(dp), intent(in) :: way, low           !! [m]
      integer :: k
      hull%way = way
      hull%low = low
      hull%axis = [(max(1, k - 1), k=1, ndim)]
      hull%corner(1, :) = 1
      hull%corner(2, 1) = way
      hull%corner(2, 2) = -way
      if (ndim > 2) hull%corner(ndim, ndim) = way
      hull%height = low
      hull%plane(1) = low
   end function far_corners

   !> Take the place of a corner, if this or a far one is above the plane, so that the corners are around the origin.
   pure subroutine take_corner(hull, place, height, tolerance, is_done)
      type(hull_t), intent(inout) :: hull
      real(dp), intent(in) :: place(ndim - 1), height !! [m]
      real(dp), intent(in) :: tolerance          !! [m]
      logical, intent(out) :: is_done            !! whether none is above
      real(dp) :: inverse(ndim, ndim), corner(ndim), part(ndim), ratio(ndim), above
      integer :: k, axis
      corner = [1.0_dp, place]
      above = height - dot_product(hull%plane, corner)
      axis = maxloc(abs(hull%plane(2:)), dim=1)
      if (hull%low - hull%plane(1) + hull%way*abs(hull%plane(axis + 1)) > above) then
         above = hull%low - hull%plane(1) + hull%way*abs(hull%plane(axis + 1))
         corner(2:) = 0
         corner(axis + 1) = -sign(hull%way, hull%plane(axis + 1))
      else
         axis = 0
      end if
      is_done = above <= tolerance
      if (is_done) return
      inverse = inverse_transpose(hull%corner)
      part = matmul(corner, inverse)
      ratio = huge(ratio)
      where (part > epsilon(part)) ratio = max(inverse(1, :), 0.0_dp)/part
      k = minloc(ratio, dim=1)
      hull%corner(:, k) = corner
      hull%height(k) = merge(hull%low, height, axis > 0)
      hull%axis(k) = axis
      hull%plane = matmul(inverse_transpose(hull%corner), hull%height)
   end subroutine take_corner

   !> Height of the surface of a body over a node, as `surface` in a plane: beyond the last particles along an axis the largest [m].
   pure real(dp) function height_over(e, normal, cell) result(height)
      type(extents_t), intent(in) :: e
      real(dp), intent(in) :: normal(ndim), cell
      real(dp), parameter :: wide = 100, low = -3e3_dp ! cells
      type(hull_t) :: hull
      integer :: i, k, turn, best
      real(dp) :: place(ndim - 1, e%n), above(e%n), inverse(ndim, ndim)
      logical :: is_done
      do i = 1, e%n
         place(:, i) = across(normal, e%list(i)%place)
      end do
      do turn = 1, ndim
         hull = far_corners(wide*cell, low*cell)
         do k = 1, most_corners
            do i = 1, e%n
               above(i) = dot_product(normal, e%list(i)%reach) - dot_product(hull%plane(2:), place(:, i))
            end do
            best = maxloc(above, dim=1)
            call take_corner(hull, place(:, best), dot_product(normal, e%list(best)%reach), rounding*cell, is_done)
            if (is_done) exit
         end do
         inverse = inverse_transpose(hull%corner)
         is_done = .true.
         do k = 1, ndim
            if (hull%axis(k) == 0 .or. inverse(1, k) <= rounding) cycle
            place(hull%axis(k), :) = 0
            is_done = .false.
         end do
         if (is_done) exit
      end do
      height = hull%plane(1)
   end function height_over

   !> A unit vector.
   pure function direction(angle) result(normal)
      real(dp), intent(in) :: angle              !! from the x axis [rad]
      real(dp) :: normal(ndim)
      normal = in_plane(cos(angle), sin(angle))
   end function direction

   !> Height of the surface of a body over a node: the upper hull of the extents of its particles. If all are on one side, their
   !> largest extent [m].
   pure real(dp) function surface(e)
      type(extents_t), intent(in) :: e
      integer :: i, j
      surface = -huge(surface)
      do i = 1, e%n
         if (e%list(i)%reach(2) > 0) cycle
         do j = 1, e%n
            if (e%list(j)%reach(2) <= 0) cycle
            associate (left => -e%list(i)%reach(2), right => e%list(j)%reach(2))
               surface = max(surface, (right*e%list(i)%reach(1) + left*e%list(j)%reach(1))/(left + right))
            end associate
         end do
      end do
      if (.not. surface > -huge(surface)) surface = maxval(e%list(:e%n)%reach(1))
   end function surface
end module hampm_body_extents
