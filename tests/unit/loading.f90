!> Loads at some places, as unit tests have them, that hang on the nearest particles: what `hampm_edge_loads` makes of parts that nothing cuts.
module loading
   use hampm_kinds, only: dp, ndim
   use hampm_edge_parts, only: edge_part_t
   use hampm_load_sharing, only: nearest_particles
   use hampm_loads, only: load_t
   use hampm_matter, only: matter_t
   implicit none
   private
   public :: load_on_points, load_on_parts

contains

   !> A load shared equally by some places, each the middle of a segment that reaches by `half` to both sides.
   subroutine load_on_points(m, points, half, load)
      type(matter_t), intent(in) :: m
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, points)
      real(dp), intent(in) :: half(ndim)         !! 0 for mere points [m]
      type(load_t), intent(inout) :: load
      type(edge_part_t) :: parts(size(points, 2))
      real(dp) :: thickness(size(points, 2))
      integer :: k
      do k = 1, size(parts)
         parts(k)%middle = points(:, k)
         parts(k)%half = half
         thickness(k) = 1
         if (m%particles%thickness%is_ring) thickness(k) = points(1, k)
      end do
      call load_on_parts(m, parts, thickness/sum(thickness), load)
   end subroutine load_on_points

   !> A load of which parts of edges have shares.
   subroutine load_on_parts(m, parts, share, load)
      type(matter_t), intent(in) :: m
      type(edge_part_t), intent(in) :: parts(:)
      real(dp), intent(in) :: share(:)
      type(load_t), intent(inout) :: load
      logical, allocatable :: no_cracks(:)
      integer, allocatable :: carriers(:)
      integer :: k, i
      allocate (load%fraction(0), load%particle(0), load%offset(ndim, 0), load%half(ndim, 0))
      do k = 1, size(parts)
         carriers = nearest_particles(m, parts(k)%middle, parts(k)%middle, no_cracks)
         load%particle = [load%particle, carriers]
         load%fraction = [load%fraction, spread(share(k)/size(carriers), 1, size(carriers))]
         load%offset = reshape([load%offset, [(parts(k)%middle - m%particles%reference(carriers(i), :), i=1, size(carriers))]], &
                               [ndim, size(load%particle)])
         load%half = reshape([load%half, spread(parts(k)%half, 2, size(carriers))], [ndim, size(load%particle)])
      end do
   end subroutine load_on_parts
end module loading
