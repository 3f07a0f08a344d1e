!> The material points, as a structure of arrays kept sorted by the cell in which each point stands.
!>
!> Cells with particles are taken in blocks of `lanes`, in the order of the grid: a sweep does the cells of a block side by side.
!> Where the time step fits the size of the cells, those of a block are of one group, and blocks stand in the order of the groups.
!> Where all cells of a block have the same number of particles, these stand in rows: the first of each cell, then the second of
!> each, and so on. In other blocks they stand cell after cell. So the particles of a cell e are always those from `first_in(e)` to
!> `last_in(e)` at a stride of `stride_in(e)`.
!>
!> Position is X + u and the deformation gradient I + H: keeping the displacement u and its gradient H, not the
!> position and F, keeps all digits of small strains.
module hampm_particles
   use hampm_kinds, only: dp, ndim, long
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_forest, only: outside, deepest
   use hampm_large_pages, only: prefer_large_pages
   use hampm_step_groups, only: step_groups_t, find_groups, plain, waiting
   use hampm_text, only: to_text
   implicit none
   private
   public :: particles_t, lanes, new_particles, fit_workspace, sort_into_cells, take_order, smallest_occupied_cell

   integer, parameter :: lanes = 4                      !! cells of a block

   !> All material points: the first `n` entries of each array are used.
   type :: particles_t
      integer :: n = 0                                  !! number of particles
      logical :: total_frame = .false.                  !! whether they stand in the grid at X, else at X + u
      real(dp), allocatable :: mass(:)                  !! m [kg], (n)
      real(dp), allocatable :: volume(:)                !! reference volume V [m3], (n)
      real(dp), allocatable :: reference(:, :)          !! reference position X [m], (n, ndim)
      real(dp), allocatable :: displacement(:, :)       !! u [m], (n, ndim)
      real(dp), allocatable :: velocity(:, :)           !! v [m/s], (n, ndim)
      real(dp), allocatable :: gradient(:, :, :)        !! displacement gradient H = du/dX [-], (n, ndim, ndim)
      integer, allocatable :: material(:)               !! index of the material, (n)
      integer, allocatable :: body(:)                   !! index of the body, (n)
      integer, allocatable :: id(:)                     !! number that stays with the particle, (n)
      ! Where cells refine: how a particle came from one that the body began with. Not allocated elsewhere
      integer, allocatable :: level(:)                  !! how often it was split, (n)
      integer(long), allocatable :: path(:)             !! which child it is of each split: a digit of base 2**ndim for each,
                                                        !! the last split last; (n)
      real(dp), allocatable :: spacing(:, :)            !! distance between unsplit particles of a body [m], (ndim, bodies)
      real(dp), allocatable :: local(:, :)              !! where in its cell it was when it was mapped last, 0 to 1, and kept a
                                                        !! little away from the edges; (n, ndim)
      integer, allocatable :: cell(:)                   !! the element in which the particle stands, (n)
      integer, allocatable :: count_in(:)               !! number of particles of each element, (n_elements)
      integer, allocatable :: first_in(:), last_in(:)   !! where the first and the last stand, 1 and 0 in empty ones, (n_elements)
      integer, allocatable :: stride_in(:)              !! distance from one to the next, (n_elements)
      integer, allocatable :: occupied(:)               !! elements with particles, ascending, (n_occupied)
      integer :: n_occupied = 0
      logical :: by_group = .false.                     !! whether blocks are those of `groups`
      type(step_groups_t) :: groups                     !! of the cells, if so
      integer :: sorts = 0                              !! how often blocks have been formed
      integer :: n_blocks = 0
      integer, allocatable :: block_cells(:, :)         !! elements of each block, 0 after the last, (lanes, n_blocks)
      integer, allocatable :: block_first(:)            !! its first particle, (n_blocks)
      integer, allocatable :: block_rows(:)             !! largest number of particles of its cells, (n_blocks)
      logical, allocatable :: block_is_even(:)          !! whether they have equal numbers, (n_blocks)
      integer, allocatable :: block_material(:)         !! the material of all its particles, if it is linear elastic; else 0,
                                                        !! (n_blocks)
      logical, allocatable :: changed(:)                !! elements that particles have left or entered since the sort before the
                                                        !! last, where only leavers were looked for; (n_elements)
      ! Workspace of the sort
      integer, allocatable :: new_place(:)              !! where the last sort moved each particle, (n)
      integer :: n_runs = 0                             !! of particles that move together to other places
      integer, allocatable, private :: run_from(:), run_to(:), run_length(:)
      integer, allocatable, private :: next(:), integer_copy(:)
      integer(long), allocatable, private :: long_copy(:)
      real(dp), allocatable, private :: real_copy(:)
   contains
      procedure :: position
      procedure :: place_in_grid
      procedure :: gradient_of
   end type particles_t

contains

   !> Room for `n` particles in a grid of `n_elements` elements. Fails where the memory does not suffice.
   subroutine new_particles(n, n_elements, p, failure)
      integer, intent(in) :: n, n_elements
      type(particles_t), intent(out) :: p
      type(failure_t), intent(inout) :: failure
      integer :: status
      allocate (p%mass(n), p%volume(n), p%reference(n, ndim), p%displacement(n, ndim), p%velocity(n, ndim), &
                p%gradient(n, ndim, ndim), p%material(n), p%body(n), p%id(n), p%cell(n), stat=status)
      if (status /= 0) then
         call failure%report(exit_computation, too_many(n))
         return
      end if
      call fit_workspace(p, n, n_elements, failure)
      if (failure%failed()) return
      call prefer_large_pages(size(p%mass), p%mass)
      call prefer_large_pages(size(p%volume), p%volume)
      call prefer_large_pages(size(p%reference), p%reference)
      call prefer_large_pages(size(p%displacement), p%displacement)
      call prefer_large_pages(size(p%velocity), p%velocity)
      call prefer_large_pages(size(p%gradient), p%gradient)
      p%displacement = 0
      p%velocity = 0
      p%gradient = 0
      p%cell = outside
   end subroutine new_particles

   !> Make what depends on the numbers of particles and of elements fit to these numbers; a sort has to follow. Fails where the
   !> memory does not suffice.
   subroutine fit_workspace(p, n, n_elements, failure)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: n, n_elements
      type(failure_t), intent(inout) :: failure
      integer :: status
      p%n = n
      if (allocated(p%first_in)) deallocate (p%local, p%first_in, p%last_in, p%stride_in, p%count_in, p%changed, p%occupied, &
                                             p%block_cells, p%block_first, p%block_rows, p%block_is_even, p%block_material, &
                                             p%next, p%new_place, p%run_from, p%run_to, p%run_length, p%integer_copy, &
                                             p%real_copy)
      if (allocated(p%long_copy)) deallocate (p%long_copy)
      associate (blocks => (n_elements - 1)/lanes + 1 + deepest)
         allocate (p%local(n, ndim), p%first_in(n_elements), p%last_in(n_elements), p%stride_in(n_elements), &
                   p%count_in(n_elements), p%changed(n_elements), p%occupied(n_elements), p%block_cells(lanes, blocks), &
                   p%block_first(blocks), p%block_rows(blocks), p%block_is_even(blocks), p%block_material(blocks), &
                   p%next(n_elements), p%new_place(n), p%run_from(n), p%run_to(n), p%run_length(n), p%integer_copy(n), &
                   p%real_copy(n), stat=status)
      end associate
      if (status == 0 .and. allocated(p%path)) allocate (p%long_copy(n), stat=status)
      if (status /= 0) then
         call failure%report(exit_computation, too_many(n))
         return
      end if
      call prefer_large_pages(size(p%local), p%local)
      p%local = 0                                ! a checkpoint has it also where nothing has been mapped yet
   end subroutine fit_workspace

   !> Message about a lack of memory.
   function too_many(n) result(message)
      integer, intent(in) :: n
      character(:), allocatable :: message
      message = 'particles: not enough memory for '//to_text(n)//' particles'
   end function too_many

   !> Position of particle `i` [m].
   pure function position(self, i) result(x)
      class(particles_t), intent(in) :: self
      integer, intent(in) :: i
      real(dp) :: x(ndim)
      x = self%reference(i, :) + self%displacement(i, :)
   end function position

   !> Where particle `i` stands in the grid [m]: the place at which shape functions are taken.
   pure function place_in_grid(self, i) result(x)
      class(particles_t), intent(in) :: self
      integer, intent(in) :: i
      real(dp) :: x(ndim)
      x = self%reference(i, :)
      if (.not. self%total_frame) x = x + self%displacement(i, :)
   end function place_in_grid

   !> H of particle `i` [-], which the array does not hold in one piece.
   pure function gradient_of(self, i) result(h)
      class(particles_t), intent(in) :: self
      integer, intent(in) :: i
      real(dp) :: h(ndim, ndim)
      h = self%gradient(i, :, :)
   end function gradient_of

   !> Find the cell of every particle and sort all arrays by cell, keeping the order within a cell. `new_place` then
   !> tells where each particle went. Where it is known which blocks some particle has left, no other is looked at, and `changed`
   !> tells which cells are no longer as they were. Fails where a particle has left the grid or its position is not a number.
   subroutine sort_into_cells(p, grid, failure, left)
      type(particles_t), intent(inout) :: p
      type(grid_t), intent(in) :: grid
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: left(:)          !! by block
      integer :: d, k
      call locate(p, grid, failure, left)
      if (failure%failed()) return
      call count_cells(p)
      call take_cells(p, grid)
      call find_places(p)
      call permute_reals(p, p%mass)
      call permute_reals(p, p%volume)
      do d = 1, ndim
         call permute_reals(p, p%reference(:, d))
         call permute_reals(p, p%local(:, d))
         call permute_reals(p, p%displacement(:, d))
         call permute_reals(p, p%velocity(:, d))
         do k = 1, ndim
            call permute_reals(p, p%gradient(:, k, d))
         end do
      end do
      call permute_integers(p, p%material)
      call permute_integers(p, p%body)
      call permute_integers(p, p%id)
      call permute_integers(p, p%cell)
      if (allocated(p%level)) call permute_integers(p, p%level)
      if (allocated(p%path)) call permute_longs(p, p%path)
      call find_block_materials(p)
   end subroutine sort_into_cells

   !> Form the blocks of particles that stand in the order of a sort, each in its `cell`. `fits` is false where they do not.
   subroutine take_order(p, grid, fits)
      type(particles_t), intent(inout) :: p
      type(grid_t), intent(in) :: grid
      logical, intent(out) :: fits
      integer :: i
      fits = p%n > 0 .and. all(p%cell >= 1 .and. p%cell <= grid%n_elements)
      if (.not. fits) return
      call count_cells(p)
      call take_cells(p, grid)
      call find_places(p)
      fits = all(p%new_place == [(i, i=1, p%n)])
      call find_block_materials(p)
   end subroutine take_order

   !> Set `cell` from the positions.
   subroutine locate(p, grid, failure, left)
      type(particles_t), intent(inout) :: p
      type(grid_t), intent(in) :: grid
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: left(:)
      integer :: b, i, lost
      lost = 0
      if (present(left)) then
         p%changed = .false.
         do b = 1, p%n_blocks
            if (.not. left(b)) cycle
            do i = p%block_first(b), last_of(p, b)
               call locate_particle(i)
            end do
         end do
      else
         do i = 1, p%n
            call locate_particle(i)
         end do
      end if
      if (lost > 0) call failure%report(exit_computation, lost_particle(p, lost))
   contains
      !> Set the cell of a particle.
      subroutine locate_particle(i)
         integer, intent(in) :: i
         integer :: e
         e = grid%element_at(p%place_in_grid(i))
         if (e == outside) then
            if (lost == 0) lost = i
         else if (present(left) .and. e /= p%cell(i)) then
            p%changed(e) = .true.
            p%changed(p%cell(i)) = .true.
         end if
         p%cell(i) = e
      end subroutine locate_particle
   end subroutine locate

   !> Size of the smallest element that holds particles [m].
   pure real(dp) function smallest_occupied_cell(grid, p) result(smallest)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      smallest = minval(grid%element_size(p%occupied(:p%n_occupied)))
   end function smallest_occupied_cell

   !> Message about a particle that is no longer in the grid.
   function lost_particle(p, i) result(message)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      character(:), allocatable :: message
      real(dp) :: x(ndim)
      x = p%position(i)
      if (any(.not. abs(x) <= huge(x))) then
         message = 'the position of particle '//to_text(p%id(i))//' is no longer a number; it started at ('// &
                   to_text(p%reference(i, 1))//', '//to_text(p%reference(i, 2))// &
                   ') m. Likely cause: the run is unstable; reduce &method courant'
      else
         message = 'particle '//to_text(p%id(i))//' left the grid at ('//to_text(x(1))//', '//to_text(x(2))// &
                   ') m; it started at ('//to_text(p%reference(i, 1))//', '//to_text(p%reference(i, 2))// &
                   ') m. Likely cause: the body moves beyond the grid: give &grid more cells or add a &constraint; '// &
                   'or the run is unstable: reduce &method courant'
      end if
   end function lost_particle

   !> Count the particles of each cell.
   subroutine count_cells(p)
      type(particles_t), intent(inout) :: p
      integer :: i, e
      p%count_in = 0
      do i = 1, p%n
         p%count_in(p%cell(i)) = p%count_in(p%cell(i)) + 1
      end do
      p%n_occupied = 0
      do e = 1, size(p%count_in)
         if (p%count_in(e) == 0) cycle
         p%n_occupied = p%n_occupied + 1
         p%occupied(p%n_occupied) = e
      end do
   end subroutine count_cells

   !> Take the cells with particles in blocks, by group if need be.
   subroutine take_cells(p, grid)
      type(particles_t), intent(inout) :: p
      type(grid_t), intent(in) :: grid
      integer, allocatable :: cells(:)
      integer :: n
      p%sorts = p%sorts + 1
      if (p%by_group) then
         call find_groups(grid, p%occupied(:p%n_occupied), p%groups)
         call order_by_group(p%groups, p%occupied(:p%n_occupied), cells, n)
         call form_blocks(p, n, cells)
      else
         call form_blocks(p, p%n_occupied, p%occupied)
      end if
   end subroutine take_cells

   !> Order cells by group, the finest first, and in a group those that wait first. The last block of a group is filled up with 0.
   pure subroutine order_by_group(groups, occupied, cells, n)
      type(step_groups_t), intent(in) :: groups
      integer, intent(in) :: occupied(:)
      integer, allocatable, intent(out) :: cells(:)
      integer, intent(out) :: n                         !! number of `cells`, with those that are 0
      integer :: next(plain:waiting, 0:groups%largest)  ! where the next cell of a kind of a group stands
      integer :: g, kind, k
      next = 0
      do k = 1, size(occupied)
         associate (total => next(groups%kind(occupied(k)), groups%of_cell(occupied(k))))
            total = total + 1
         end associate
      end do
      n = 0
      do g = 0, groups%largest
         do kind = waiting, plain, -1
            k = next(kind, g)
            next(kind, g) = n + 1
            n = n + k
         end do
         n = lanes*((n + lanes - 1)/lanes)
      end do
      allocate (cells(n), source=0)
      do k = 1, size(occupied)
         associate (place => next(groups%kind(occupied(k)), groups%of_cell(occupied(k))))
            cells(place) = occupied(k)
            place = place + 1
         end associate
      end do
   end subroutine order_by_group

   !> Form blocks of listed cells, and find where their particles will stand.
   subroutine form_blocks(p, n, listed)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: n
      integer, intent(in) :: listed(*)                  !! 0 for none
      integer :: b, l, e, place, cells(lanes), counts(lanes)
      p%n_blocks = (n - 1)/lanes + 1
      p%first_in = 1
      p%last_in = 0
      p%stride_in = 1
      place = 1
      do b = 1, p%n_blocks
         cells = 0
         l = min(lanes*b, n)
         cells(:l - lanes*(b - 1)) = listed(lanes*(b - 1) + 1:l)
         p%block_cells(:, b) = cells
         p%block_first(b) = place
         do l = 1, lanes
            counts(l) = 0
            if (cells(l) > 0) counts(l) = p%count_in(cells(l))
         end do
         p%block_rows(b) = maxval(counts)
         p%block_is_even(b) = all(counts == p%block_rows(b))
         do l = 1, lanes
            e = cells(l)
            if (e == 0) exit
            if (p%block_is_even(b)) then
               p%stride_in(e) = lanes
               p%first_in(e) = p%block_first(b) + l - 1
            else
               p%first_in(e) = place
            end if
            p%last_in(e) = p%first_in(e) + (p%count_in(e) - 1)*p%stride_in(e)
            place = place + p%count_in(e)
         end do
      end do
   end subroutine form_blocks

   !> Decide the new place of each particle, and which of them move together.
   subroutine find_places(p)
      type(particles_t), intent(inout) :: p
      integer :: i, e
      p%next = p%first_in
      p%n_runs = 0
      do i = 1, p%n
         e = p%cell(i)
         p%new_place(i) = p%next(e)
         p%next(e) = p%next(e) + p%stride_in(e)
      end do
      do i = 1, p%n
         if (p%new_place(i) == i) cycle
         if (p%n_runs > 0) then
            associate (r => p%n_runs)
               if (p%run_from(r) + p%run_length(r) == i .and. p%run_to(r) + p%run_length(r) == p%new_place(i)) then
                  p%run_length(r) = p%run_length(r) + 1
                  cycle
               end if
            end associate
         end if
         p%n_runs = p%n_runs + 1
         p%run_from(p%n_runs) = i
         p%run_to(p%n_runs) = p%new_place(i)
         p%run_length(p%n_runs) = 1
      end do
   end subroutine find_places

   !> Find the blocks of one material.
   subroutine find_block_materials(p)
      type(particles_t), intent(inout) :: p
      integer :: b
      do b = 1, p%n_blocks
         associate (materials => p%material(p%block_first(b):last_of(p, b)))
            p%block_material(b) = merge(materials(1), 0, all(materials == materials(1)))
         end associate
      end do
   end subroutine find_block_materials

   !> The last particle of a block.
   pure integer function last_of(p, block)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: block
      last_of = p%n
      if (block < p%n_blocks) last_of = p%block_first(block + 1) - 1
   end function last_of

   !> Move the values of an array to the new places.
   subroutine permute_reals(p, values)
      type(particles_t), intent(inout) :: p
      real(dp), intent(inout) :: values(p%n)
      integer :: r
      do r = 1, p%n_runs
         associate (from => p%run_from(r), to => p%run_to(r), length => p%run_length(r))
            p%real_copy(to:to + length - 1) = values(from:from + length - 1)
         end associate
      end do
      do r = 1, p%n_runs
         associate (to => p%run_to(r), length => p%run_length(r))
            values(to:to + length - 1) = p%real_copy(to:to + length - 1)
         end associate
      end do
   end subroutine permute_reals

   !> As `permute_reals`, of integers.
   subroutine permute_integers(p, values)
      type(particles_t), intent(inout) :: p
      integer, intent(inout) :: values(:)
      p%integer_copy(p%new_place) = values
      values = p%integer_copy
   end subroutine permute_integers

   !> As `permute_reals`, of long integers.
   subroutine permute_longs(p, values)
      type(particles_t), intent(inout) :: p
      integer(long), intent(inout) :: values(:)
      if (.not. allocated(p%long_copy)) allocate (p%long_copy(p%n))   ! `path` came after the workspace
      p%long_copy(p%new_place) = values
      values = p%long_copy
   end subroutine permute_longs
end module hampm_particles
