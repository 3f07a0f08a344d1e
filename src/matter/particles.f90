!> The material points, as a structure of arrays kept sorted by the cell in which each point stands.
!>
!> Position is X + u and the deformation gradient I + H: keeping the displacement u and its gradient H, not the
!> position and F, keeps all digits of small strains.
module hampm_particles
   use hampm_kinds, only: dp, ndim, long
   use hampm_failure, only: failure_t, exit_computation
   use hampm_grid, only: grid_t
   use hampm_forest, only: outside
   use hampm_text, only: to_text
   implicit none
   private
   public :: particles_t, new_particles, fit_workspace, sort_into_cells, smallest_occupied_cell

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
      integer, allocatable :: cell(:)                   !! the element in which the particle stands, (n)
      ! The particles of element e are first_in(e), first_in(e) + stride_in(e), ... last_in(e). An empty one has 1, 0 and 1
      integer, allocatable :: first_in(:), last_in(:), stride_in(:) !! (n_elements)
      integer, allocatable :: count_in(:)               !! number of particles of each element, (n_elements)
      integer, allocatable :: occupied(:)               !! elements with particles, ascending, (n_occupied)
      integer :: n_occupied = 0
      ! Workspace of the sort
      integer, allocatable :: new_place(:)              !! where the last sort moved each particle, (n)
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
      if (allocated(p%first_in)) deallocate (p%first_in, p%last_in, p%stride_in, p%count_in, p%occupied, p%next, p%new_place, &
                                             p%integer_copy, p%real_copy)
      if (allocated(p%long_copy)) deallocate (p%long_copy)
      allocate (p%first_in(n_elements), p%last_in(n_elements), p%stride_in(n_elements), p%count_in(n_elements), &
                p%occupied(n_elements), p%next(n_elements), p%new_place(n), p%integer_copy(n), p%real_copy(n), stat=status)
      if (status == 0 .and. allocated(p%path)) allocate (p%long_copy(n), stat=status)
      if (status /= 0) call failure%report(exit_computation, too_many(n))
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
   !> tells where each particle went. Fails where a particle has left the grid or its position is not a number.
   subroutine sort_into_cells(p, grid, failure)
      type(particles_t), intent(inout) :: p
      type(grid_t), intent(in) :: grid
      type(failure_t), intent(inout) :: failure
      integer :: d, k
      call locate(p, grid, failure)
      if (failure%failed()) return
      call count_cells(p)
      call permute_reals(p, p%mass)
      call permute_reals(p, p%volume)
      do d = 1, ndim
         call permute_reals(p, p%reference(:, d))
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
   end subroutine sort_into_cells

   !> Set `cell` from the positions.
   subroutine locate(p, grid, failure)
      type(particles_t), intent(inout) :: p
      type(grid_t), intent(in) :: grid
      type(failure_t), intent(inout) :: failure
      integer :: i, lost
      lost = 0
      do i = 1, p%n
         p%cell(i) = grid%element_at(p%place_in_grid(i))
         if (p%cell(i) == outside .and. lost == 0) lost = i
      end do
      if (lost > 0) call failure%report(exit_computation, lost_particle(p, lost))
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

   !> Count the particles of each cell and decide the new place of each particle.
   subroutine count_cells(p)
      type(particles_t), intent(inout) :: p
      integer :: i, e, place
      p%count_in = 0
      do i = 1, p%n
         p%count_in(p%cell(i)) = p%count_in(p%cell(i)) + 1
      end do
      p%n_occupied = 0
      p%first_in = 1
      p%last_in = 0
      p%stride_in = 1
      place = 1
      do e = 1, size(p%count_in)
         if (p%count_in(e) == 0) cycle
         p%n_occupied = p%n_occupied + 1
         p%occupied(p%n_occupied) = e
         p%first_in(e) = place
         p%last_in(e) = place + (p%count_in(e) - 1)*p%stride_in(e)
         place = place + p%count_in(e)
      end do
      p%next = p%first_in
      do i = 1, p%n
         e = p%cell(i)
         p%new_place(i) = p%next(e)
         p%next(e) = p%next(e) + p%stride_in(e)
      end do
   end subroutine count_cells

   !> Move the values of an array to the new places.
   subroutine permute_reals(p, values)
      type(particles_t), intent(inout) :: p
      real(dp), intent(inout) :: values(p%n)
      integer :: i
      do i = 1, p%n
         p%real_copy(p%new_place(i)) = values(i)
      end do
      values = p%real_copy
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
