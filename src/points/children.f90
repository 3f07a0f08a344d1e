!> The children of a particle: how many there are, where they stand, and the part of the volume that each has.
!>
!> They stand at the quarter points of the parent's reference rectangle, X +- s/4, s being its edges: (15)-(18).
!>
!> A particle of a body with an outline (`hampm_outline`) is the part of the body in a box of a lattice. Its children are the parts
!> in the quarters of that box, at their centroids; a quarter without material makes no child.
!>
!> A particle with a crack through its middle is split into the two parts of its rectangle beside the crack, at their centroids.
!> These do not recombine. In finer cells such a half is split into the quarters of its parent on its side, and the halves there of
!> those on the crack: particles are the same whether the crack or the finer cells come first.
module hampm_children
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_tensors, only: norm
   use hampm_forest, only: corner_offset
   use hampm_outline, only: least_part
   use hampm_particles, only: particles_t, spacing_of
   implicit none
   private
   public :: is_half, middle_of_parent, times_split, children_of, litter_t, place_of_parent, quarters_of

   !> The children of a particle.
   type :: litter_t
      integer :: n = 0                           !! how many there are
      integer(long) :: path(corners) = 0         !! of each
      integer :: level(corners) = 1              !! splits of each beyond those of its parent
      real(dp) :: half(ndim, corners) = 0        !! of each, as in `particles_t`
      real(dp) :: offset(ndim, corners) = 0      !! where it stands from its parent: dX [m]
      real(dp) :: part(corners) = 0              !! its volume, over the parent's
   end type litter_t

contains

   !> How often the cells of a particle may be refined before it is to be split: a half of a particle is as coarse as a whole one.
   pure integer function times_split(p, i) result(times)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      times = p%level(i) - merge(1, 0, is_half(p, i))
   end function times_split

   !> Whether a particle is the half of another one.
   pure logical function is_half(p, i)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      is_half = .false.
      if (allocated(p%half)) is_half = any(abs(p%half(i, :)) > 0)
   end function is_half

   !> The children of a particle: their positions relative to it in the reference configuration, and their parts of its volume.
   pure type(litter_t) function children_of(p, i, normal) result(litter)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp), intent(in) :: normal(ndim)       !! of the crack through its middle; 0 if there is none
      real(dp) :: x(ndim)
      if (is_half(p, i)) then
         litter = children_of_half(p, i)
      else if (any(abs(normal) > 0)) then
         litter%n = 2
         litter%path(:2) = p%path(i)*corners + [0, 1]
         litter%part(:2) = 0.5_dp
         litter%half(:, 1) = normal/norm(normal)
         litter%half(:, 2) = -litter%half(:, 1)
         litter%offset(:, 1) = middle_of_half(spacing_of(p, i)/2, litter%half(:, 1))
         litter%offset(:, 2) = -litter%offset(:, 1)
      else
         x = p%reference(i, :)
         litter = quarters_of(p, p%body(i), x, spacing_of(p, i)/2, p%path(i))
      end if
   end function children_of

   !> The children of half a particle: the quarters of the whole on its side, and the halves on its side of quarters on the crack.
   pure type(litter_t) function children_of_half(p, i) result(litter)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      type(litter_t) :: whole
      real(dp), parameter :: on_crack = 1e-6_dp  ! part of the edges within which the middle of a quarter is on the crack
      real(dp) :: edges(ndim), toward(ndim), from_middle(ndim), height
      integer :: c
      edges = spacing_of(p, i)                   ! of a quarter
      toward = p%half(i, :)
      from_middle = middle_of_half(edges, toward)
      whole = quarters_of(p, p%body(i), p%reference(i, :) - from_middle, edges, p%path(i)/corners)
      do c = 1, whole%n
         height = dot_product(toward, whole%offset(:, c))
         if (height < -on_crack*norm(edges)) cycle
         litter%n = litter%n + 1
         associate (n => litter%n)
            litter%path(n) = whole%path(c)
            litter%level(n) = 0
            litter%part(n) = whole%part(c)
            litter%offset(:, n) = whole%offset(:, c) - from_middle
            if (height > on_crack*norm(edges)) cycle
            litter%path(n) = whole%path(c)*corners + mod(p%path(i), int(corners, long))
            litter%level(n) = 1
            litter%part(n) = whole%part(c)/2
            litter%offset(:, n) = litter%offset(:, n) + middle_of_half(edges/2, toward)
            litter%half(:, n) = toward
         end associate
      end do
      if (litter%n == 0) then                    ! the part of the body stays as it is
         litter%n = 1
         litter%path(1) = p%path(i)*corners
         litter%part(1) = 1
      end if
      litter%part(:litter%n) = litter%part(:litter%n)/sum(litter%part(:litter%n))
   end function children_of_half

   !> The quarters of a whole particle at a place.
   pure type(litter_t) function quarters_of(p, body, x, edges, path) result(litter)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: body
      real(dp), intent(in) :: x(ndim)            !! where it stands in the reference configuration [m]
      real(dp), intent(in) :: edges(ndim)        !! of a quarter [m]
      integer(long), intent(in) :: path          !! of the whole one
      real(dp) :: middle(ndim), m(0:ndim), part(corners), at(ndim, corners)
      integer :: c
      if (.not. p%has_outline(body)) then
         litter%n = corners
         litter%path = path*corners + [(c - 1, c=1, corners)]
         litter%part = 1/real(corners, dp)
         do c = 1, corners
            litter%offset(:, c) = (2*corner_offset(c) - 1)*edges/2
         end do
         return
      end if
      middle = middle_of_box(p, x, 2*edges)
      do c = 1, corners
         associate (lower => middle + (corner_offset(c) - 1)*edges)
            m = p%outlines(body)%moments(lower, lower + edges)
            part(c) = m(0)
            at(:, c) = lower
            if (m(0) > 0) at(:, c) = lower + m(1:)/m(0)
         end associate
      end do
      do c = 1, corners
         if (part(c) <= least_part*product(edges)) cycle
         litter%n = litter%n + 1
         litter%path(litter%n) = path*corners + (c - 1)
         litter%part(litter%n) = part(c)
         litter%offset(:, litter%n) = at(:, c)
      end do
      associate (n => litter%n)
         litter%part(:n) = litter%part(:n)/sum(litter%part(:n))
         middle = matmul(litter%offset(:, :n), litter%part(:n))
         litter%offset(:, :n) = litter%offset(:, :n) - spread(middle, 2, n)
      end associate
   end function quarters_of

   !> Centroid of the half of a rectangle, with its middle at 0, into which the normal of a line through that points [m].
   pure function middle_of_half(half, normal) result(x)
      real(dp), intent(in) :: half(ndim)         !! of its edges [m]
      real(dp), intent(in) :: normal(ndim)       !! of any length
      real(dp) :: x(ndim), n(ndim), slope
      integer :: d
      n = normal*half                            ! as in a square of edges of 2
      d = maxloc(abs(n), dim=1)
      slope = n(3 - d)/n(d)
      x(d) = sign(0.5_dp, n(d))*(1 - slope**2/3)
      x(3 - d) = sign(1.0_dp, n(d))*slope/3
      x = x*half
   end function middle_of_half

   !> Middle of the box of the lattice in which a place is [m].
   pure function middle_of_box(p, place, edges) result(x)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: place(ndim)        !! [m]
      real(dp), intent(in) :: edges(ndim)        !! of the box [m]
      real(dp) :: x(ndim)
      x = p%lattice + (floor((place - p%lattice)/edges) + 0.5_dp)*edges
   end function middle_of_box

   !> Reference position of the particle of which a particle is a child, or of the middle of its box [m].
   pure function middle_of_parent(p, i) result(x)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i                   !! a child
      real(dp) :: x(ndim), toward(ndim)
      x = p%reference(i, :)
      if (is_half(p, i)) then
         toward = p%half(i, :)
         x = x - middle_of_half(spacing_of(p, i), toward)
      else if (p%has_outline(p%body(i))) then
         x = middle_of_box(p, x, 2*spacing_of(p, i))
      else
         x = x - (2*corner_offset(int(mod(p%path(i), int(corners, long))) + 1) - 1)*spacing_of(p, i)/2
      end if
   end function middle_of_parent

   !> Reference position of a particle and its siblings together: the middle of their box, or the centroid of the body in it [m].
   pure function place_of_parent(p, i) result(x)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i                   !! a child
      real(dp) :: x(ndim), m(0:ndim), edges(ndim)
      x = middle_of_parent(p, i)
      if (.not. p%has_outline(p%body(i))) return
      edges = spacing_of(p, i)
      m = p%outlines(p%body(i))%moments(x - edges, x + edges)
      x = x - edges + m(1:)/m(0)
   end function place_of_parent
end module hampm_children
