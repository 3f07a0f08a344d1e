!> Parts of the edges of bodies, for loads. In solids parts of surfaces: rectangles of a lattice on flat sides, parts of half of its
!> spacing on cylinders, and on spheres parts of a lattice of angles on the sides of the surrounding cube, equal along all axes.
module hampm_edge_parts
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   implicit none
   private
   public :: edge_part_t, rectangles_of_side, parts_of_mantle, parts_of_sphere

   real(dp), parameter :: pi = acos(-1.0_dp)

   !> A straight part of an edge, or a short one of an arc.
   type :: edge_part_t
      real(dp) :: middle(ndim) = 0               !! [m]
      real(dp) :: half(ndim) = 0                 !! from there to its end; of a rectangle to its corner, else 0 [m]
      real(dp) :: normal(ndim) = 0               !! unit vector out of the material
      real(dp) :: area = 0                       !! of a part of the surface of a solid [m2]
      integer :: ring = 0                        !! of the outline, of which it is
      integer :: side = 0                        !! of the polygon, from its corner of this number as written to the next; 0: none
   end type edge_part_t

contains

   !> The parts of the upper or lower side of a box, between the lines of a lattice.
   pure function rectangles_of_side(lower, upper, d, is_upper, origin, spacing) result(parts)
      real(dp), intent(in) :: lower(ndim), upper(ndim) !! corners of the box [m]
      integer, intent(in) :: d                   !! direction of the normal
      logical, intent(in) :: is_upper
      real(dp), intent(in) :: origin(ndim), spacing !! of the lattice [m]
      type(edge_part_t), allocatable :: parts(:)
      real(dp), dimension(ndim) :: from, to
      integer :: first(ndim), n(ndim), at(ndim), k, i
      from = lower
      to = upper
      from(d) = merge(upper(d), lower(d), is_upper)
      to(d) = from(d)
      first = floor((from - origin)/spacing + 1e-9_dp)
      n = max(ceiling((to - origin)/spacing - 1e-9_dp) - first, 1)
      n(d) = 1
      if (any(to < from)) n = 0
      allocate (parts(product(n)))
      do k = 1, size(parts)
         at = first + [(mod((k - 1)/product(n(:i - 1)), n(i)), i=1, ndim)]
         associate (a => max(from, origin + at*spacing), b => min(to, origin + (at + 1)*spacing))
            parts(k)%middle = (a + b)/2
            parts(k)%half = (b - a)/2
         end associate
         parts(k)%middle(d) = from(d)
         parts(k)%half(d) = 0
         parts(k)%normal(d) = merge(1, -1, is_upper)
         parts(k)%area = product(pack(2*parts(k)%half, [(i, i=1, ndim)] /= d))
      end do
   end function rectangles_of_side

   !> The parts of the round side of a cylinder, with normals away from its axis.
   pure function parts_of_mantle(center, radius, axis, ends, spacing) result(parts)
      real(dp), intent(in) :: center(ndim), radius, ends(2), spacing !! [m]
      integer, intent(in) :: axis
      type(edge_part_t), allocatable :: parts(:)
      real(dp) :: angle, length
      integer :: round, along, k
      round = 8*max(8, ceiling(pi*radius/spacing/2))
      along = max(1, ceiling(2*(ends(2) - ends(1))/spacing - 1e-9_dp))
      if (ends(2) <= ends(1)) along = 0
      length = (ends(2) - ends(1))/max(along, 1)
      allocate (parts(round*along))
      do k = 0, size(parts) - 1
         angle = 2*pi*(mod(k, round) + 0.5_dp)/round
         associate (part => parts(k + 1))
            part%normal(1 + mod(axis, ndim)) = cos(angle)
            part%normal(1 + mod(axis + 1, ndim)) = sin(angle)
            part%middle = center + radius*part%normal
            part%middle(axis) = ends(1) + (k/round + 0.5_dp)*length
            part%area = 2*pi*radius/round*length
         end associate
      end do
   end function parts_of_mantle

   !> The parts of a sphere, with outward normals. A rectangle from the middle of a side of the surrounding cube to a, b, in halves
   !> of that side, has the solid angle atan(a b/sqrt(1 + a**2 + b**2)) from the middle of the cube.
   pure function parts_of_sphere(center, radius, spacing) result(parts)
      real(dp), intent(in) :: center(ndim), radius, spacing !! [m]
      type(edge_part_t), allocatable :: parts(:)
      real(dp) :: angle(2)
      integer :: n, k, d, i, j
      n = 2*max(4, ceiling(pi/2*radius/spacing))
      allocate (parts(2*ndim*n*n))
      do k = 0, size(parts) - 1
         i = mod(k, n)
         j = mod(k/n, n)
         d = 1 + mod(k/n**2, ndim)
         angle = pi/2*(([i, j] + 0.5_dp)/n - 0.5_dp)
         associate (part => parts(k + 1))
            part%normal(d) = merge(1, -1, k < size(parts)/2)
            part%normal(1 + mod(d, ndim)) = tan(angle(1))
            part%normal(1 + mod(d + 1, ndim)) = tan(angle(2))
            part%normal = part%normal/norm(part%normal)
            part%middle = center + radius*part%normal
            part%area = radius**2*(seen(i + 1, j + 1) - seen(i, j + 1) - seen(i + 1, j) + seen(i, j))
         end associate
      end do

   contains

      !> Solid angle of the corner from the middle of the side of the cube to a node of the lattice.
      pure real(dp) function seen(i, j)
         integer, intent(in) :: i, j
         associate (a => tan(pi/2*(real(i, dp)/n - 0.5_dp)), b => tan(pi/2*(real(j, dp)/n - 0.5_dp)))
            seen = atan(a*b/sqrt(1 + a**2 + b**2))
         end associate
      end function seen
   end function parts_of_sphere
end module hampm_edge_parts
