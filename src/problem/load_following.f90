!> Loads whose particles split or recombine: resultant, moment and the material that carries them stay.
!>
!> A point follows the nearest child. A segment of a traction is halved, to be as fine as the cells under it; a segment of a body
!> force is shared by the children. Recombination joins halves to their segment, whatever parts of other segments are there.
module hampm_load_following
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_loads, only: load_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: follow_split, follow_recombination

contains

   !> After a split.
   subroutine follow_split(loads, tolerance, p, marked, first_child)
      type(load_t), intent(inout) :: loads(:)
      real(dp), intent(in) :: tolerance          !! distance below which places are the same [m]
      type(particles_t), intent(in) :: p         !! the present particles
      logical, intent(in) :: marked(:)           !! split particles, by their old numbers
      integer, intent(in) :: first_child(:)      !! new place of each particle or its first child, and behind the last
      type(load_t) :: old
      integer :: l, k, n, c, first, last
      do l = 1, size(loads)
         if (loads(l)%by_mass) cycle             ! see `share_by_mass`
         old = loads(l)
         call resize(loads(l), sum(merge(pieces(old, first_child), 1, marked(old%particle))))
         n = 0
         do k = 1, size(old%particle)
            associate (particle => old%particle(k))
               first = first_child(particle)
               last = first_child(particle + 1) - 1
               if (.not. marked(particle)) then
                  call put(loads(l), n, old%fraction(k), first, old%offset(:, k), old%half(:, k))
               else if (any(abs(old%half(:, k)) > 0)) then
                  associate (signs => halves_of(old%half(:, k)))
                     do c = 1, size(signs, 2)
                        call put_on_children(loads(l), n, old%fraction(k)*(1 + signs(1, c)*longer(p, first_child, old, k)) &
                                             /size(signs, 2), first, last, old%offset(:, k) + signs(:, c)*old%half(:, k)/2, &
                                             old%half(:, k)/2, tolerance, p)
                     end do
                  end associate
               else
                  call put_on_children(loads(l), n, old%fraction(k), first, last, old%offset(:, k), old%half(:, k), tolerance, p)
               end if
            end associate
         end do
         call cut_off(loads(l), n)
      end do
   end subroutine follow_split

   !> Side of each part of a segment from its middle: halves of a line in the plane, quarters of a rectangle in space.
   pure function halves_of(half) result(signs)
      real(dp), intent(in) :: half(ndim)         !! [m]
      integer, allocatable :: signs(:, :)
      integer :: d, n
      if (ndim == 2) then
         allocate (signs, source=reshape([(sign(1, 2*(n - ndim) - 1), n=1, 2*ndim)], [ndim, 2]))
         return
      end if
      allocate (signs, source=reshape([(0, d=1, ndim)], [ndim, 1]))
      do d = 1, ndim
         if (.not. abs(half(d)) > 0) cycle
         n = size(signs, 2)
         signs = reshape([signs, signs], [ndim, 2*n])
         signs(d, :n) = -1
         signs(d, n + 1:) = 1
      end do
   end function halves_of

   !> Relative excess of the circumference in the middle of one half of a segment over its own, for a ring [-].
   pure real(dp) function longer(p, first_child, load, k)
      type(particles_t), intent(in) :: p         !! after the split
      integer, intent(in) :: first_child(:)
      type(load_t), intent(in) :: load           !! before it
      integer, intent(in) :: k                   !! point
      real(dp) :: radius
      integer :: c
      longer = 0
      if (.not. p%thickness%is_ring) return
      associate (first => first_child(load%particle(k)), last => first_child(load%particle(k) + 1) - 1)
         radius = dot_product(p%weights_of([(c, c=first, last)]), p%reference(first:last, 1)) + load%offset(1, k)
      end associate
      if (radius > 0) longer = load%half(1, k)/2/radius ! on the axis there is no load
   end function longer

   !> How many points each point of a load becomes at most when its particle splits.
   pure function pieces(load, first_child)
      type(load_t), intent(in) :: load
      integer, intent(in) :: first_child(:)
      integer :: pieces(size(load%particle))
      integer :: k
      pieces = first_child(load%particle + 1) - first_child(load%particle)
      pieces = pieces*[(merge(size(halves_of(load%half(:, k)), 2), 1, any(abs(load%half(:, k)) > 0)), &
                                                  k=1, size(load%particle))]
   end function pieces

   !> Put a point on the nearest child of a particle, or in equal parts on several that are as near.
   subroutine put_on_children(load, n, fraction, first, last, offset, half, tolerance, p)
      type(load_t), intent(inout) :: load
      integer, intent(inout) :: n                !! number of points so far
      real(dp), intent(in) :: fraction
      integer, intent(in) :: first, last         !! child
      real(dp), intent(in) :: offset(ndim)       !! from the parent [m]
      real(dp), intent(in) :: half(ndim)
      real(dp), intent(in) :: tolerance          !! [m]
      type(particles_t), intent(in) :: p
      real(dp) :: x(ndim), distance(first:last), weight(first:last)
      logical :: is_nearest(first:last)
      integer :: c
      weight = p%weights_of([(c, c=first, last)])
      x = matmul(weight, p%reference(first:last, :)) + offset
      distance = [(norm(x - p%reference(c, :)), c=first, last)]
      is_nearest = distance <= minval(distance) + tolerance
      do c = first, last
         if (is_nearest(c)) call put(load, n, fraction/count(is_nearest), c, x - p%reference(c, :), half)
      end do
   end subroutine put_on_children

   !> Append a point.
   subroutine put(load, n, fraction, particle, offset, half)
      type(load_t), intent(inout) :: load
      integer, intent(inout) :: n
      real(dp), intent(in) :: fraction
      integer, intent(in) :: particle
      real(dp), intent(in) :: offset(ndim), half(ndim)
      n = n + 1
      load%fraction(n) = fraction
      load%particle(n) = particle
      load%offset(:, n) = offset
      load%half(:, n) = half
   end subroutine put

   !> Room for `n` points.
   subroutine resize(load, n)
      type(load_t), intent(inout) :: load
      integer, intent(in) :: n
      deallocate (load%fraction, load%particle, load%offset, load%half)
      allocate (load%fraction(n), load%particle(n), load%offset(ndim, n), load%half(ndim, n))
   end subroutine resize

   !> Leave the first `n` points.
   subroutine cut_off(load, n)
      type(load_t), intent(inout) :: load
      integer, intent(in) :: n
      if (allocated(load%ends)) deallocate (load%ends)
      if (allocated(load%cofactor)) deallocate (load%cofactor)
      if (allocated(load%last_cofactor)) deallocate (load%last_cofactor)
      load%fraction = load%fraction(:n)
      load%particle = load%particle(:n)
      load%offset = load%offset(:, :n)
      load%half = load%half(:, :n)
   end subroutine cut_off

   !> After a recombination: undo the split of points.
   subroutine follow_recombination(loads, tolerance, p, reference, level, new_number)
      type(load_t), intent(inout) :: loads(:)
      real(dp), intent(in) :: tolerance          !! distance below which places are the same [m]
      type(particles_t), intent(in) :: p         !! the present particles
      real(dp), intent(in) :: reference(:, :)    !! positions before it [m], (old number of particles, ndim)
      integer, intent(in) :: level(:)            !! how often particles had been split
      integer, intent(in) :: new_number(:)       !! of each particle, or of the one that it is part of
      logical, allocatable :: is_open(:)         ! points that may be joined to another one
      integer, parameter :: all_directions(ndim) = 1
      integer :: along(ndim), d, l, k
      do l = 1, size(loads)
         if (loads(l)%by_mass) cycle
         associate (load => loads(l))
            is_open = level(load%particle) > p%level(new_number(load%particle))
            do k = 1, size(load%particle)
               associate (particle => new_number(load%particle(k)))
                  load%offset(:, k) = load%offset(:, k) + reference(load%particle(k), :) - p%reference(particle, :)
                  load%particle(k) = particle
               end associate
            end do
            call join(load, 0, all_directions, tolerance, is_open)
            if (ndim == 2) call join(load, 2, all_directions, tolerance, is_open)
            if (ndim == 2) cycle
            do d = 1, ndim
               along = 0
               along(d) = 1
               call join(load, 2, along, tolerance, is_open)
            end do
         end associate
      end do
   end subroutine follow_recombination

   !> Join the points of each particle at the same place, or in the middles of both halves of a segment. The halves of several
   !> segments in line follow each other.
   subroutine join(load, halves, along, tolerance, is_open)
      type(load_t), intent(inout) :: load
      integer, intent(in) :: halves              !! by how many halves of their segments points are apart: 0 or 2
      integer, intent(in) :: along(ndim)         !! 1 in the directions in which they are
      real(dp), intent(in) :: tolerance          !! [m]
      logical, allocatable, intent(inout) :: is_open(:) !! by point, which may be joined, and afterwards to others
      logical :: is_joined(size(load%particle))  ! by point
      integer :: last(maxval([load%particle, 0])), before(size(load%particle)) ! point of a particle, and the one before it
      type(load_t) :: old
      integer :: k, n, at
      old = load
      n = 0
      last = 0
      do k = 1, size(old%particle)
         associate (particle => old%particle(k), x => old%offset(:, k), half => old%half(:, k))
            at = merge(last(particle), 0, is_open(k))
            do while (at > 0)
               associate (apart => x - load%offset(:, at))
                  if (is_open(at) .and. .not. is_joined(at) .and. all(abs(half - load%half(:, at)) <= tolerance) .and. &
                      min(maxval(abs(apart - halves*along*half)), maxval(abs(apart + halves*along*half))) <= tolerance) exit
               end associate
               at = before(at)
            end do
            if (at > 0) then
               load%fraction(at) = load%fraction(at) + old%fraction(k)
               load%offset(:, at) = (load%offset(:, at) + x)/2
               load%half(:, at) = (1 + halves/2*along)*load%half(:, at)
               is_joined(at) = halves > 0
            else
               call put(load, n, old%fraction(k), particle, x, half)
               is_open(n) = is_open(k)
               is_joined(n) = .false.
               before(n) = last(particle)
               last(particle) = n
            end if
         end associate
      end do
      call cut_off(load, n)
      is_open = is_open(:n)
   end subroutine join
end module hampm_load_following
