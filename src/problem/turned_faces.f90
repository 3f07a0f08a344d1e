!> Turning and stretch of faces under a pressure: da n = cof(F) dA N (Nanson).
!>
!> F is of the particle of a point. In the updated frame these need not be gradients of one motion, and edges that follow their own
!> particles leave gaps: a pressure around a spinning body then has a moment of a hundredth of that of one side. So neighbouring
!> points of segments, in space of rectangles, share their ends, at the mean of the places by their particles, and F is corrected to
!> map each segment to its ends: over a closed surface the area vectors sum to 0, the moments nearly so.
module hampm_turned_faces
   use hampm_kinds, only: dp, ndim, long
   use hampm_particles, only: particles_t
   use hampm_place_table, only: place_table_t
   use hampm_tensors, only: cofactors, identity, in_space, space
   implicit none
   private
   public :: deformation_at, cofactors_of, number_ends, place_of_end, n_ends

   integer, parameter :: n_ends = 2**(ndim - 1)  !! of a segment, or corners of a rectangle
   !> Side of each of them from its middle, along its directions.
   integer, parameter :: signs(2, 4) = reshape([-1, -1, 1, -1, 1, 1, -1, 1], [2, 4])

contains

   !> F of a particle, as a tensor of space [-]: in plane stress as if at constant thickness.
   pure function deformation_at(p, particle) result(f)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: particle
      real(dp) :: f(space, space)
      f = in_space(identity + p%gradient_of(particle))
      if (ndim < space) f(space, space) = 1 + p%hoop_of(particle)
   end function deformation_at

   !> From the middle to an end [m].
   pure function way_to_end(half, which) result(way)
      real(dp), intent(in) :: half(ndim)         !! of the segment, or from the middle of the rectangle to a corner [m]
      integer, intent(in) :: which
      real(dp) :: way(ndim)
      integer :: d, n
      way = signs(1, which)*half
      if (ndim == 2) return
      n = 0
      do d = 1, ndim
         if (.not. abs(half(d)) > 0) cycle
         n = n + 1
         way(d) = signs(min(n, 2), which)*half(d)
      end do
   end function way_to_end

   !> Number the ends of a point's segment in a table of places; 0 of a mere point.
   pure subroutine number_ends(p, particle, offset, half, quantum, table, numbers)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: particle
      real(dp), intent(in) :: offset(ndim), half(ndim) !! [m]
      real(dp), intent(in) :: quantum            !! distance below which places are the same [m]
      type(place_table_t), intent(inout) :: table
      integer, intent(out) :: numbers(n_ends)
      real(dp), parameter :: shift = 0.377_dp    ! no multiple of a simple fraction is half way between two numbers
      integer(long), parameter :: apart = 2_long**40
      integer(long) :: place(ndim)
      integer :: k
      numbers = 0
      if (count(abs(half) > 0) < merge(1, 2, ndim == 2)) return
      do k = 1, n_ends
         place = nint((p%reference(particle, :) + offset + way_to_end(half, k))/quantum + shift, long)
         place(1) = place(1) + apart*p%body(particle)
         call table%enter(place, numbers(k))
      end do
   end subroutine number_ends

   !> Place of an end by a particle [m].
   pure function place_of_end(p, particle, offset, half, which) result(x)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: particle
      real(dp), intent(in) :: offset(ndim), half(ndim) !! [m]
      integer, intent(in) :: which
      real(dp) :: x(ndim), way(ndim)
      way = offset + way_to_end(half, which)
      x = p%reference(particle, :) + p%displacement(particle, :) + way + matmul(p%gradient_of(particle), way)
   end function place_of_end

   !> Cofactors of F at points: of particles whose material `follows`; with `ends` corrected to map segments to their ends.
   pure function cofactors_of(p, follows, particle, half, ends, place) result(list)
      type(particles_t), intent(in) :: p
      logical, intent(in) :: follows(:)          !! by material
      integer, intent(in) :: particle(:)         !! of each point
      real(dp), intent(in), optional :: half(:, :) !! [m], (ndim, points)
      integer, intent(in), optional :: ends(:, :) !! their numbers, (n_ends, points)
      real(dp), intent(in), optional :: place(:, :) !! their places [m], (ndim, numbers)
      real(dp) :: list(ndim, ndim, size(particle))
      real(dp) :: f(space, space), cofactor(space, space), now(ndim), first(ndim)
      integer :: k, d
      do k = 1, size(particle)
         list(:, :, k) = identity
         if (.not. follows(p%material(particle(k)))) cycle
         f = deformation_at(p, particle(k))
         if (present(ends)) then
            if (ends(1, k) > 0) then
               do d = 1, n_ends/2                ! along each direction of the segment or the rectangle
                  now = sum(place(:, pack(ends(:, k), signs(d, :n_ends) > 0)), dim=2) &
                        - sum(place(:, pack(ends(:, k), signs(d, :n_ends) < 0)), dim=2)
                  first = 0
                  call along_direction(half(:, k), d, first)
                  now = now*2/n_ends
                  f(:ndim, :ndim) = f(:ndim, :ndim) + spread(now - matmul(f(:ndim, :ndim), first), 2, ndim) &
                                                     *spread(first/sum(first**2), 1, ndim)
               end do
            end if
         end if
         cofactor = cofactors(f)
         list(:, :, k) = cofactor(:ndim, :ndim)
      end do
   end function cofactors_of

   !> A segment, or the d-th direction of a rectangle, from end to end in the reference configuration [m].
   pure subroutine along_direction(half, d, way)
      real(dp), intent(in) :: half(ndim)         !! [m]
      integer, intent(in) :: d
      real(dp), intent(inout) :: way(ndim)       !! 0 before
      integer :: at(ndim), k
      if (ndim == 2) then
         way = 2*half
      else
         at(:count(abs(half) > 0)) = pack([(k, k=1, ndim)], abs(half) > 0)
         way(at(d)) = 2*half(at(d))
      end if
   end subroutine along_direction
end module hampm_turned_faces
