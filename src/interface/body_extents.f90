!> How near two bodies are to each other around a node, and in which direction, by the extents of their particles.
!>
!> A particle reaches from its place as far as the part of the body that it stands for, deformed with it: a parallelogram with the half
!> sides h_d = F e_d l_d/2, which in a direction n reaches sum_d |n . h_d|, and no farther than the outline of the body, where it has one.
!>
!> The direction is that in which the particles of both bodies around the node can be told apart best: the normal of the line
!> between them that leaves the widest margin. It is one for both, so that what they exchange is, too (collinear, as Lemiale, Hurmane &
!> Nairn 2010 and Nairn 2013 make the normals). Gradients of mass or volume (Bardenhagen, Guilkey, Roessig, Brackbill, Witzel & Foster
!> 2001) turn by ten degrees and more at corners and wherever a row of particles changes cells, and with them friction does. A line
!> between particles is that of Nairn, Hammerquist & Smith (2020), who find theirs by logistic regression.
!>
!> The gap is the distance of the surfaces of both bodies, in that direction, where the line through the node meets them: of each the
!> upper hull of what its particles reach to. The widest margin would be less, where surfaces curve, by what they curve in a cell.
module hampm_body_extents
   use hampm_kinds, only: dp, ndim
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_domain_pass, only: corner_map_t
   use hampm_dofs, only: element_of_slot
   use hampm_grid, only: grid_t
   use hampm_particles, only: particles_t, spacing_of
   use hampm_tensors, only: in_plane, identity
   implicit none
   private
   public :: extents_t, gather_extents, find_normal_and_gap

   !> How far a particle reaches.
   type :: extent_t
      integer :: particle = 0                    !! its number
      real(dp) :: place(ndim) = 0                !! from the node [m]
      real(dp) :: half(ndim, ndim) = 0           !! half sides [m]
      real(dp) :: reach(ndim) = 0                !! in the last direction asked for: along it and across [m]
   end type extent_t

   !> The particles of a body around a node.
   type :: extents_t
      integer :: n = 0                           !! their number
      type(extent_t), allocatable :: list(:)     !! (n and more)
      real(dp) :: toward(ndim) = 0               !! sum of place times volume [m4]
   end type extents_t

   real(dp), parameter :: pi = acos(-1.0_dp)
   integer, parameter :: looks = 8               !! for the normal, on each side of the way from the middle of one to that of the other
   real(dp), parameter :: turn = pi/(2*looks)    !! from one to the next [rad]
   integer, parameter :: sections = 36           !! of the angle around the best of these, by the golden section: to rounding
   real(dp), parameter :: far = 0.5_dp           !! cells: bodies farther apart do not meet in a step

contains

   !> Gather the particles in the elements at a node; where they have domains, those of which a corner is there.
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
      associate (elements => grid%dofs%elements_at(node), here => grid%node_position(:, node))
         if (allocated(p%corner_velocity)) then
            do k = 1, size(elements)
               do i = map%first(elements(k)), map%first(elements(k) + 1) - 1
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

   !> Add a particle that is not yet there.
   subroutine add_particle(p, i, here, e)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp), intent(in) :: here(ndim)         !! place of the node [m]
      type(extents_t), intent(inout) :: e
      real(dp) :: side(ndim)                     ! of the rectangle that it stands for, in the reference configuration [m]
      if (.not. allocated(e%list)) allocate (e%list(16))
      if (any(e%list(:e%n)%particle == i)) return
      if (e%n == size(e%list)) e%list = [e%list, e%list]
      e%n = e%n + 1
      side = spacing_of(p, i)
      if (p%has_outline(p%body(i))) side = side*sqrt(p%area_of(i)/product(side)) ! where an outline cuts it, one with as much area
      associate (new => e%list(e%n))
         new%particle = i
         new%place = p%position(i) - here
         new%half = (identity + p%gradient_of(i))*spread(side/2, 1, ndim)
         e%toward = e%toward + p%volume(i)*new%place
      end associate
   end subroutine add_particle

   !> How far the particles of a body reach in a direction, each by itself.
   subroutine find_reach(p, normal, e)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: normal(ndim)
      type(extents_t), intent(inout) :: e
      real(dp) :: box, origin(ndim)
      integer :: k
      do k = 1, e%n
         associate (of => e%list(k), i => e%list(k)%particle)
            box = sum(abs(matmul(normal, of%half)))
            if (p%has_outline(p%body(i))) then
               origin = p%reference(i, :)
               box = min(box, p%outlines(p%body(i))%way_out(origin, back(p%gradient_of(i), normal)))
            end if
            of%reach = in_plane(dot_product(of%place, normal) + box, normal(1)*of%place(2) - normal(2)*of%place(1))
         end associate
      end do
   end subroutine find_reach

   !> What becomes a vector in the deformed body: F**(-1) v.
   pure function back(h, v) result(origin)
      real(dp), intent(in) :: h(ndim, ndim)      !! F - I
      real(dp), intent(in) :: v(ndim)
      real(dp) :: origin(ndim)
      associate (f => identity + h)
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

   !> A unit vector.
   pure function direction(angle) result(normal)
      real(dp), intent(in) :: angle              !! from the x axis [rad]
      real(dp) :: normal(ndim)
      normal = in_plane(cos(angle), sin(angle))
   end function direction

   !> Height of the surface of a body over a node: the upper hull of what its particles reach to. Where all are on one side, what they
   !> reach to at most [m].
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
