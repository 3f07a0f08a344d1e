!> How a force on a place is shared by the particles around it, or by the corners of their domains.
module hampm_load_sharing
   use hampm_kinds, only: dp, ndim, corners
   use hampm_tensors, only: identity, norm
   use hampm_basis, only: shape_functions
   use hampm_domain_pass, only: find_corners
   use hampm_domains, only: edges_of_domain, weights_in_domain
   use hampm_forest, only: outside
   use hampm_grid, only: grid_t
   use hampm_matter, only: matter_t
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: nearest_particles, share_by_cell, share_by_corners

contains

   !> Nodes of the cells with the corners of a domain, and their shape functions there times those of the corners at a material
   !> place: the function of this place in the domain.
   pure subroutine share_by_corners(p, grid, particle, offset, node, shape)
      type(particles_t), intent(in) :: p
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: particle
      real(dp), intent(in) :: offset(ndim)       !! of the place from its particle [m]
      integer, intent(out) :: node(corners, corners)
      real(dp), intent(out) :: shape(corners, corners)
      real(dp) :: part(corners), local(ndim, corners)
      integer :: c, element(corners)
      part = weights_in_domain(offset, edges_of_domain(p, particle))
      element = outside
      call find_corners(p, grid, particle, element, local)
      do c = 1, corners
         node(:, c) = 1
         shape(:, c) = 0
         if (element(c) == outside) cycle        ! the next step finds it
         node(:, c) = grid%element_nodes(:, element(c))
         shape(:, c) = part(c)*shape_functions(local(:, c))
      end do
   end subroutine share_by_corners

   !> Nodes of the particle's cell, and their shape functions at a place; in quadratic cells their mean over its segment, by three
   !> Gauss points, exact also on slanted segments, or over its rectangle.
   pure subroutine share_by_cell(p, grid, particle, offset, half, is_rectangle, node, shape)
      type(particles_t), intent(in) :: p
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: particle
      real(dp), intent(in) :: offset(ndim)       !! of the place from its particle [m]
      real(dp), intent(in) :: half(ndim)         !! of the segment or rectangle [m]
      logical, intent(in) :: is_rectangle
      integer, intent(out) :: node(:)
      real(dp), intent(out) :: shape(:)
      real(dp), parameter :: gauss = sqrt(0.6_dp), weights(-1:1) = [5, 8, 5]/18.0_dp
      real(dp) :: x(ndim), ways(ndim, ndim), place(ndim), weight
      integer :: n, k, d, at(ndim)
      associate (e => p%cell(particle))
         x = p%place_in_grid(particle) + offset
         if (.not. p%total_frame) x = x + matmul(p%gradient_of(particle), offset)
         call grid%shape_functions_in(e, grid%local_coordinate(e, x), node, shape)
         if (.not. grid%is_quadratic() .or. all(abs(half) <= 0)) return
         ways = 0
         ways(:, 1) = gauss*half
         if (is_rectangle) ways = identity*spread(gauss*half, 2, ndim)
         n = merge(ndim, 1, is_rectangle)
         shape = 0
         do k = 0, 3**n - 1                      ! a ring has more circumference farther out
            at = [(mod(k/3**d, 3) - 1, d=0, ndim - 1)]
            place = x + matmul(ways, at)
            weight = product(weights(at(:n)))
            if (p%thickness%is_ring .and. x(1) > 0) weight = weight*place(1)/x(1)
            shape = shape + weight*grid%functions_in(e, grid%local_coordinate(e, place))
         end do
      end associate
   end subroutine share_by_cell

   !> The nearest particles to a place, all equally near ones: rings of cells around it are searched until one more ring cannot
   !> help. Weak pieces of cells count as farther by a cell, particles beyond a crack as farther than all others.
   function nearest_particles(m, x, beside, is_weak) result(nearest)
      type(matter_t), intent(in) :: m
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp), intent(in) :: beside(ndim)       !! the same on its side of a crack [m]
      logical, allocatable, intent(in) :: is_weak(:) !! by the first element of each piece; not allocated where there are no cracks
      integer, allocatable :: nearest(:)
      real(dp) :: distance, best, at(ndim)
      integer :: ring, home(ndim), offset(ndim), j, k, i, e, first, last
      associate (forest => m%grid%forest, tolerance => m%grid%forest%tolerance())
         home = min(max(int((x - forest%lower)/forest%cell), 0), forest%cells - 1)
         allocate (nearest(0))
         best = huge(best)
         do ring = 0, maxval(forest%cells)
            if (size(nearest) > 0 .and. best + tolerance <= (ring - 1)*forest%cell) exit
            do k = 0, (2*ring + 1)**ndim - 1
               offset = [(mod(k/(2*ring + 1)**j, 2*ring + 1) - ring, j=0, ndim - 1)]
               if (maxval(abs(offset)) /= ring) cycle
               if (any(home + offset < 0 .or. home + offset >= forest%cells)) cycle
               call forest%leaves_of_root(home + offset, first, last)
               do e = m%grid%leaf_element(first), m%grid%leaf_element(last + 1) - 1
                  do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
                     at = m%particles%place_in_grid(i)
                     distance = norm(at - x)
                     if (distance > best + tolerance) cycle
                     if (allocated(is_weak)) then
                        if (is_weak(m%grid%first_of_piece(e))) distance = distance + m%grid%leaf_size(e)
                        if (m%grid%cut_cells%divide(at, beside)) distance = distance + sum(forest%cells)*forest%cell
                     end if
                     if (distance > best + tolerance) cycle
                     if (distance < best - tolerance) nearest = [integer ::]
                     nearest = [nearest, i]
                     best = min(best, distance)
                  end do
               end do
            end do
         end do
      end associate
   end function nearest_particles
end module hampm_load_sharing
