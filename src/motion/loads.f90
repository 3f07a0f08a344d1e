!> Loads, the forces that act on material.
!>
!> A load is carried by points. Each point belongs to a particle, its host, and stands at the material place X_host + dX,
!> that is at x_host + (I + H) dX. Its force goes to the nodes of the host's cell by their shape functions, extrapolated
!> where the point stands outside. So the resultant and its moment are exact, a traction acts on the very edge of the
!> body, no force meets a node without mass, and nothing depends on how the load and the cells lie to each other.
module hampm_loads
   use hampm_kinds, only: dp, ndim, corners
   use hampm_archive, only: archive_t
   use hampm_basis, only: shape_functions
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_grid, only: grid_t
   use hampm_load_history, only: load_history_t
   use hampm_particles, only: particles_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: load_t, load_on_points, load_on_particles, follow_sort, add_loads, add_load, book_work, point_displacement, keep_loads

   !> A load: its points, the particles on which they hang, and its history.
   type :: load_t
      real(dp) :: force(ndim) = 0                !! resultant of the whole load [N]
      type(load_history_t) :: history
      real(dp), allocatable :: fraction(:)       !! part of the resultant at each point [-], (points)
      integer, allocatable :: host(:)            !! particle to which each point belongs, (points)
      real(dp), allocatable :: offset(:, :)      !! dX of each point [m], (ndim, points)
      logical :: by_mass = .false.               !! whether it acts on all material of its hosts, else at the points
      real(dp), allocatable :: half(:, :)        !! half of the segment of which a point is the middle, 0 for a mere point [m],
                                                 !! (ndim, points)
      real(dp), allocatable :: moved(:, :)       !! displacement of each point at the last `book_work` [m], (ndim, points)
   end type load_t

contains

   !> A load shared equally by the material places `points`, each hosted by the nearest particle and the middle of a segment that
   !> reaches by `half` to both sides.
   subroutine load_on_points(p, grid, blocks, points, half, load)
      type(particles_t), intent(in) :: p
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      real(dp), intent(in) :: points(:, :)       !! [m], (ndim, points)
      real(dp), intent(in) :: half(ndim)         !! 0 for mere points [m]
      type(load_t), intent(inout) :: load
      integer :: k, n
      n = size(points, 2)
      allocate (load%fraction(n), source=1/real(n, dp))
      allocate (load%host(n), load%offset(ndim, n))
      allocate (load%half(ndim, n), source=spread(half, 2, n))
      allocate (load%moved(ndim, n), source=0.0_dp)
      do k = 1, n
         load%host(k) = nearest_particle(p, grid, blocks, points(:, k))
         load%offset(:, k) = points(:, k) - p%reference(load%host(k), :)
      end do
   end subroutine load_on_points

   !> A load shared by the particles within a box in proportion to their mass.
   subroutine load_on_particles(p, lower, upper, load)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the box [m]
      type(load_t), intent(inout) :: load
      integer :: i
      load%host = pack([(i, i=1, p%n)], [(all(p%reference(i, :) >= lower .and. p%reference(i, :) <= upper), i=1, p%n)])
      load%fraction = p%mass(load%host)/sum(p%mass(load%host))
      load%by_mass = .true.
      allocate (load%offset(ndim, size(load%host)), load%half(ndim, size(load%host)), source=0.0_dp)
      allocate (load%moved(ndim, size(load%host)), source=0.0_dp)
   end subroutine load_on_particles

   !> After a sort of the particles: follow the hosts to their new places.
   subroutine follow_sort(loads, new_place)
      type(load_t), intent(inout) :: loads(:)
      integer, intent(in) :: new_place(:)        !! where the sort moved each particle
      integer :: k
      do k = 1, size(loads)
         loads(k)%host = new_place(loads(k)%host)
      end do
   end subroutine follow_sort

   !> Add the loads at a time to the nodal `force` [N].
   subroutine add_loads(loads, time, grid, p, force)
      type(load_t), intent(in) :: loads(:)
      real(dp), intent(in) :: time               !! [s]
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      real(dp), intent(inout), contiguous :: force(:, :)  !! (ndim, n_points)
      integer :: l
      do l = 1, size(loads)
         call add_load(loads(l), loads(l)%history%factor(time), grid, p, force)
      end do
   end subroutine add_loads

   !> Add one load times a factor to the nodal `force` [N].
   subroutine add_load(load, factor, grid, p, force)
      type(load_t), intent(in) :: load
      real(dp), intent(in) :: factor
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      real(dp), intent(inout), contiguous :: force(:, :)  !! (ndim, n_points)
      real(dp) :: n(corners), point_force(ndim)
      integer :: k, c, node
      do k = 1, size(load%host)
         n = weights(load, k, grid, p)
         point_force = load%fraction(k)*factor*load%force
         do c = 1, corners
            node = grid%element_nodes(c, p%cell(load%host(k)))
            force(:, node) = force(:, node) + n(c)*point_force
         end do
      end do
   end subroutine add_load

   !> Book the work of the loads [J] in the step that began at `time`: the force there times the way that the loaded
   !> material has gone. It is not the power on the nodes: a node that has little mass may have any velocity. Where particles
   !> were moved for several steps `dt` at once, the force is the mean of theirs.
   pure subroutine book_work(loads, time, p, work, dt, steps)
      type(load_t), intent(inout) :: loads(:)
      real(dp), intent(in) :: time               !! [s]
      type(particles_t), intent(in) :: p
      real(dp), intent(out) :: work
      real(dp), intent(in), optional :: dt       !! [s]
      integer, intent(in), optional :: steps
      real(dp) :: u(ndim), factor
      integer :: l, k
      work = 0
      do l = 1, size(loads)
         associate (load => loads(l))
            factor = load%history%factor(time)
            if (present(steps)) factor = sum([(load%history%factor(time + k*dt), k=0, steps - 1)])/steps
            do k = 1, size(load%host)
               u = point_displacement(load, k, p)
               work = work + load%fraction(k)*factor*dot_product(load%force, u - load%moved(:, k))
               load%moved(:, k) = u
            end do
         end associate
      end do
   end subroutine book_work

   !> Displacement of the material at point `k` of a load [m].
   pure function point_displacement(load, k, p) result(u)
      type(load_t), intent(in) :: load
      integer, intent(in) :: k
      type(particles_t), intent(in) :: p
      real(dp) :: u(ndim)
      u = p%displacement(load%host(k), :) + matmul(p%gradient(load%host(k), :, :), load%offset(:, k))
   end function point_displacement

   !> Shape functions of the nodes of the host's cell at point `k` of a load.
   pure function weights(load, k, grid, p) result(n)
      type(load_t), intent(in) :: load
      integer, intent(in) :: k
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      real(dp) :: n(corners)
      real(dp) :: x(ndim)
      associate (host => load%host(k))
         x = p%place_in_grid(host) + load%offset(:, k)
         if (.not. p%total_frame) x = x + matmul(p%gradient(host, :, :), load%offset(:, k))
         n = shape_functions(grid%local_coordinate(p%cell(host), x))
      end associate
   end function weights

   !> The particle nearest to a place: rings of cells around it are searched until one ring more cannot help.
   integer function nearest_particle(p, grid, blocks, x) result(nearest)
      type(particles_t), intent(in) :: p
      type(grid_t), intent(in) :: grid
      type(cell_blocks_t), intent(in) :: blocks
      real(dp), intent(in) :: x(ndim)            !! [m]
      real(dp) :: distance, best
      integer :: ring, home(ndim), offset(ndim), k, i, e, first, last
      associate (forest => grid%forest)
         home = min(max(int((x - forest%lower)/forest%cell), 0), forest%cells - 1)
         nearest = 0
         best = huge(best)
         do ring = 0, maxval(forest%cells)
            if (nearest > 0 .and. best <= ((ring - 1)*forest%cell)**2) exit
            do k = 0, (2*ring + 1)**ndim - 1
               offset = box_offset(k, ring)
               if (maxval(abs(offset)) /= ring) cycle
               if (any(home + offset < 0 .or. home + offset >= forest%cells)) cycle
               call forest%leaves_of_root(home + offset, first, last)
               do e = grid%leaf_element(first), grid%leaf_element(last + 1) - 1
                  do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                     distance = sum((p%position(i) - x)**2)
                     if (distance < best) then
                        best = distance
                        nearest = i
                     end if
                  end do
               end do
            end do
         end do
      end associate
   end function nearest_particle

   !> The `k`-th integer offset, from 0, within a box that reaches `ring` cells to each side.
   pure function box_offset(k, ring) result(offset)
      integer, intent(in) :: k, ring
      integer :: offset(ndim)
      integer :: d, rest
      rest = k
      do d = 1, ndim
         offset(d) = mod(rest, 2*ring + 1) - ring
         rest = rest/(2*ring + 1)
      end do
   end function box_offset

   !> Keep which particles carry the loads, and how far these have moved.
   subroutine keep_loads(loads, archive)
      type(load_t), intent(inout) :: loads(:)
      class(archive_t), intent(inout) :: archive
      integer :: l, n
      do l = 1, size(loads)
         associate (load => loads(l))
            n = size(load%host)
            call archive%section('load_'//to_text(l))
            call archive%keep('points', n)
            if (archive%failure%failed()) return
            if (archive%is_read) then
               deallocate (load%fraction, load%host, load%offset, load%half, load%moved)
               allocate (load%fraction(n), load%host(n), load%offset(ndim, n), load%half(ndim, n), load%moved(ndim, n))
            end if
            call archive%keep_reals('fraction', n, load%fraction)
            call archive%keep_integers('host', n, load%host)
            call archive%keep_reals('offset', size(load%offset), load%offset)
            call archive%keep_reals('half', size(load%half), load%half)
            call archive%keep_reals('moved', size(load%moved), load%moved)
         end associate
      end do
   end subroutine keep_loads
end module hampm_loads
