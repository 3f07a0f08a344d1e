!> Vectors of the nodes of a region: what iterations do with them. Sums are taken over chunks of nodes first, so that they do not
!> depend on the number of threads.
module hampm_nodal_vectors
   use hampm_kinds, only: dp, ndim
   use hampm_mass_matrix, only: region_t, nodes_per_chunk
   implicit none
   private
   public :: chunk_count, chunk_size, dot_of_nodes, divide, weigh, combine, clear

contains

   !> Number of chunks of nodes.
   pure integer function chunk_count(region)
      type(region_t), intent(in) :: region
      chunk_count = (region%n_nodes - 1)/nodes_per_chunk + 1
   end function chunk_count

   !> Number of nodes of a chunk.
   pure integer function chunk_size(region, chunk)
      type(region_t), intent(in) :: region
      integer, intent(in) :: chunk
      chunk_size = min(nodes_per_chunk, region%n_nodes - (chunk - 1)*nodes_per_chunk)
   end function chunk_size

   !> Sum of x y over some nodes, by component.
   pure subroutine dot_of_nodes(n, nodes, x, y, total)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: x(ndim, *), y(ndim, *)
      real(dp), intent(out) :: total(ndim)
      integer :: a
      total = 0
      do a = 1, n
         total = total + x(:, nodes(a))*y(:, nodes(a))
      end do
   end subroutine dot_of_nodes

   !> x = D^-1 b at some nodes.
   subroutine divide(n, nodes, inverse, b, x)
      integer, intent(in) :: n, nodes(n)
      real(dp), intent(in) :: inverse(*), b(ndim, *)    !! D^-1 and b
      real(dp), intent(inout) :: x(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      !GCC$ novector
      do a = 1, n
         x(:, nodes(a)) = b(:, nodes(a))*inverse(nodes(a))
      end do
   end subroutine divide

   !> y = D x.
   subroutine weigh(region, lumped, x, y)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: lumped(*), x(ndim, *)
      real(dp), intent(inout) :: y(ndim, *)
      integer :: a
      !$omp parallel do schedule(static)
      do a = 1, region%n_nodes
         y(:, region%nodes(a)) = lumped(region%nodes(a))*x(:, region%nodes(a))
      end do
   end subroutine weigh

   !> y <- a x + b y, by component. `y` has to be finite also where b is 0.
   subroutine combine(region, a, x, b, y)
      type(region_t), intent(in) :: region
      real(dp), intent(in) :: a(ndim), x(ndim, *), b(ndim)
      real(dp), intent(inout) :: y(ndim, *)
      integer :: k
      !$omp parallel do schedule(static)
      do k = 1, region%n_nodes
         y(:, region%nodes(k)) = a*x(:, region%nodes(k)) + b*y(:, region%nodes(k))
      end do
   end subroutine combine

   !> x = 0 in some components.
   subroutine clear(region, components, x)
      type(region_t), intent(in) :: region
      logical, intent(in) :: components(ndim)
      real(dp), intent(inout) :: x(ndim, *)
      integer :: a
      do a = 1, region%n_nodes
         where (components) x(:, region%nodes(a)) = 0
      end do
   end subroutine clear
end module hampm_nodal_vectors
