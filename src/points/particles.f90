!> The material points, as a structure of arrays. In which order they stand, `hampm_cell_blocks` tells.
!>
!> Position is X + u and the deformation gradient I + H: keeping the displacement u and its gradient H, not the
!> position and F, keeps all digits of small strains.
!>
!> A field of the particles, a column of numbers for each, is declared in `particles_t`, allocated in `new_particles`, moved in
!> `move_particles` and listed in `visit_columns`. All uniform treatment of fields uses that list: sorting, splitting, recombining,
!> checkpoints.
module hampm_particles
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_archive, only: archive_t
   use hampm_column_visitor, only: column_visitor_t
   use hampm_failure, only: failure_t, exit_computation
   use hampm_forest, only: outside
   use hampm_large_pages, only: prefer_large_pages
   use hampm_law, only: most_columns
   use hampm_outline, only: outline_t
   use hampm_text, only: to_text
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: particles_t, new_particles, add_history, take_particles, archive_particles, spacing_of

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
      real(dp), allocatable :: widening(:)              !! H_33 R of axisymmetric material, the radial displacement by the straining
                                                        !! velocities, as H [m], (n); not allocated in a plane
      real(dp), allocatable :: local(:, :)              !! where in its cell it was when it was mapped last, 0 to 1, and kept a
                                                        !! little away from the edges; (n, ndim)
      real(dp), allocatable :: history(:, :)            !! state variables of laws; not allocated where none does. (n, columns)
      ! Where particles have domains (`hampm_domains`), each with a quarter of the mass at a corner. Not allocated elsewhere
      real(dp), allocatable :: corner_displacement(:, :, :) !! [m], (n, ndim, corners)
      real(dp), allocatable :: corner_velocity(:, :, :) !! [m/s], (n, ndim, corners)
      integer, allocatable :: material(:)               !! index of the material, (n)
      integer, allocatable :: body(:)                   !! index of the body, (n)
      integer, allocatable :: id(:)                     !! number that stays with the particle, (n)
      integer, allocatable :: cell(:)                   !! the element in which the particle stands, (n)
      ! Where cells refine: how a particle came from one that the body began with. Not allocated elsewhere
      integer, allocatable :: level(:)                  !! how often it was split, (n)
      integer(long), allocatable :: path(:)             !! which child it is of each split: a digit of base 2**ndim for each,
                                                        !! the last split last; (n)
      real(dp), allocatable :: half(:, :)               !! unit vector into the half that a particle beside a crack is, normal to
                                                        !! the crack; 0 of a whole one; (n, ndim)
      real(dp), allocatable :: spacing(:, :)            !! distance between unsplit particles of a body [m], (ndim, bodies)
      ! Where bodies are no mere rectangles. Not allocated elsewhere
      type(outline_t), allocatable :: outlines(:)       !! in the reference configuration, (bodies)
      real(dp) :: lattice(ndim) = 0                     !! a corner of the lattice whose boxes have particles [m]
      type(thickness_t) :: thickness                    !! of the material
   contains
      procedure :: has_outline
      procedure :: position
      procedure :: place_in_grid
      procedure :: gradient_of
      procedure :: hoop_of
      procedure :: area_of
      procedure :: weights_of
      procedure :: history_of
      procedure :: columns
      procedure :: visit_columns
   end type particles_t

   !> A column on its way to other particles: packed from the old ones by `origin`, then unpacked to the new ones. One at a time, as
   !> all of them would take as much memory as the particles.
   type, extends(column_visitor_t) :: transfer_t
      logical :: packs = .true.                         !! else unpacks
      integer :: wanted = 0                             !! which of the columns, in the order of the visit
      integer :: seen = 0                               !! how many have been visited
      integer, allocatable :: origin(:)                 !! which old particle each new one is made of
      real(dp), allocatable :: real_values(:, :)
      integer(long), allocatable :: whole_values(:)
   contains
      procedure :: reals => transfer_reals
      procedure :: integers => transfer_integers
      procedure :: longs => transfer_longs
   end type transfer_t

contains

   !> Room for `n` particles. Fails where the memory does not suffice.
   subroutine new_particles(n, p, failure)
      integer, intent(in) :: n
      type(particles_t), intent(out) :: p
      type(failure_t), intent(inout) :: failure
      integer :: status
      allocate (p%mass(n), p%volume(n), p%reference(n, ndim), p%displacement(n, ndim), p%velocity(n, ndim), &
                p%gradient(n, ndim, ndim), p%local(n, ndim), p%material(n), p%body(n), p%id(n), p%cell(n), stat=status)
      if (status /= 0) then
         call failure%report(exit_computation, 'particles: not enough memory for '//to_text(n)//' particles')
         return
      end if
      call prefer_large_pages(size(p%mass), p%mass)
      call prefer_large_pages(size(p%volume), p%volume)
      call prefer_large_pages(size(p%reference), p%reference)
      call prefer_large_pages(size(p%displacement), p%displacement)
      call prefer_large_pages(size(p%velocity), p%velocity)
      call prefer_large_pages(size(p%gradient), p%gradient)
      call prefer_large_pages(size(p%local), p%local)
      p%n = n
      p%displacement = 0
      p%velocity = 0
      p%gradient = 0
      p%local = 0                                       ! a checkpoint has it also where nothing has been mapped yet
      p%cell = outside
   end subroutine new_particles

   !> Give each particle columns of state variables, all zero.
   subroutine add_history(p, columns)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: columns
      allocate (p%history(p%n, columns), source=0.0_dp)
   end subroutine add_history

   !> Whether a body is not a mere rectangle.
   pure logical function has_outline(self, body)
      class(particles_t), intent(in) :: self
      integer, intent(in) :: body
      has_outline = .false.
      if (allocated(self%outlines)) has_outline = self%outlines(body)%is_there()
   end function has_outline

   !> Visit all fields, always in the same order.
   subroutine visit_columns(self, visitor)
      class(particles_t), intent(inout) :: self
      class(column_visitor_t), intent(inout) :: visitor
      call real_field('mass', 1, self%mass)
      call real_field('volume', 1, self%volume)
      call real_field('reference', ndim, self%reference)
      call real_field('displacement', ndim, self%displacement)
      call real_field('velocity', ndim, self%velocity)
      call real_field('gradient', ndim*ndim, self%gradient)
      call real_field('local', ndim, self%local)
      if (allocated(self%widening)) call real_field('widening', 1, self%widening)
      if (allocated(self%history)) call real_field('history', size(self%history, 2), self%history)
      if (allocated(self%corner_displacement)) then
         call real_field('corner_displacement', ndim*corners, self%corner_displacement)
         call real_field('corner_velocity', ndim*corners, self%corner_velocity)
      end if
      call integer_field('material', self%material)
      call integer_field('body', self%body)
      call integer_field('id', self%id)
      call integer_field('cell', self%cell)
      if (allocated(self%level)) call integer_field('level', self%level)
      if (allocated(self%path)) then
         visitor%name = 'path'
         call visitor%longs(self%n, self%path)
      end if
      if (allocated(self%half)) call real_field('half', ndim, self%half)
   contains
      !> Visit a field of real numbers.
      subroutine real_field(name, width, values)
         character(*), intent(in) :: name
         integer, intent(in) :: width
         real(dp), intent(inout) :: values(self%n, width)
         visitor%name = name
         call visitor%reals(self%n, width, values)
      end subroutine real_field

      !> Visit a field of integers.
      subroutine integer_field(name, values)
         character(*), intent(in) :: name
         integer, intent(inout) :: values(self%n)
         visitor%name = name
         call visitor%integers(self%n, values)
      end subroutine integer_field
   end subroutine visit_columns

   !> Keep the particles, in their order, in an archive.
   subroutine archive_particles(p, archive)
      type(particles_t), intent(inout) :: p
      class(archive_t), intent(inout) :: archive
      type(particles_t) :: fresh
      integer :: n, columns
      logical :: has_families
      n = p%n
      has_families = allocated(p%level)
      columns = p%columns()
      call archive%section('particles')
      call archive%serialise('number', n)
      call archive%serialise('have_families', has_families)
      call archive%serialise('history_columns', columns)
      if (archive%failure%failed()) return
      if (archive%is_read) then
         call make_room(n, has_families, columns, p, fresh, archive%failure)
         if (archive%failure%failed()) return
         call move_particles(fresh, p)
      end if
      call p%visit_columns(archive)
   end subroutine archive_particles

   !> Room for another number of particles of the same kind.
   subroutine make_room(n, has_families, columns, p, fresh, failure)
      integer, intent(in) :: n
      logical, intent(in) :: has_families        !! whether particles are split
      integer, intent(in) :: columns             !! of the history of laws
      type(particles_t), intent(in) :: p
      type(particles_t), intent(out) :: fresh
      type(failure_t), intent(inout) :: failure
      call new_particles(n, fresh, failure)
      if (failure%failed()) return
      fresh%total_frame = p%total_frame
      if (allocated(p%spacing)) fresh%spacing = p%spacing
      if (allocated(p%outlines)) fresh%outlines = p%outlines
      fresh%lattice = p%lattice
      fresh%thickness = p%thickness
      if (has_families) allocate (fresh%level(n), fresh%path(n), fresh%half(n, ndim))
      if (allocated(p%widening)) allocate (fresh%widening(n), source=0.0_dp)
      if (columns > 0) call add_history(fresh, columns)
      if (allocated(p%corner_velocity)) &
         allocate (fresh%corner_displacement(n, ndim, corners), fresh%corner_velocity(n, ndim, corners), source=0.0_dp)
   end subroutine make_room

   !> Copy particle origin(k) to particle k, for any number of these. Fails where the memory does not suffice.
   subroutine take_particles(p, origin, failure)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: origin(:)
      type(failure_t), intent(inout) :: failure
      type(particles_t) :: fresh
      type(transfer_t) :: transfer
      integer :: k
      call make_room(size(origin), allocated(p%level), p%columns(), p, fresh, failure)
      if (failure%failed()) return
      allocate (transfer%origin, source=origin)
      call p%visit_columns(transfer)                    ! wants none, but counts
      do k = 1, transfer%seen
         transfer%wanted = k
         transfer%packs = .true.
         transfer%seen = 0
         call p%visit_columns(transfer)
         transfer%packs = .false.
         transfer%seen = 0
         call fresh%visit_columns(transfer)
      end do
      call move_particles(fresh, p)
   end subroutine take_particles

   !> Put particles in the place of others, which are gone.
   subroutine move_particles(from, to)
      type(particles_t), intent(inout) :: from, to
      to%n = from%n
      to%total_frame = from%total_frame
      call move_alloc(from%mass, to%mass)
      call move_alloc(from%volume, to%volume)
      call move_alloc(from%reference, to%reference)
      call move_alloc(from%displacement, to%displacement)
      call move_alloc(from%velocity, to%velocity)
      call move_alloc(from%gradient, to%gradient)
      call move_alloc(from%widening, to%widening)
      call move_alloc(from%local, to%local)
      call move_alloc(from%history, to%history)
      call move_alloc(from%corner_displacement, to%corner_displacement)
      call move_alloc(from%corner_velocity, to%corner_velocity)
      call move_alloc(from%material, to%material)
      call move_alloc(from%body, to%body)
      call move_alloc(from%id, to%id)
      call move_alloc(from%cell, to%cell)
      call move_alloc(from%level, to%level)
      call move_alloc(from%path, to%path)
      call move_alloc(from%half, to%half)
      call move_alloc(from%spacing, to%spacing)
      call move_alloc(from%outlines, to%outlines)
      to%lattice = from%lattice
      to%thickness = from%thickness
   end subroutine move_particles

   !> Pack or unpack a field of real numbers, if it is wanted.
   subroutine transfer_reals(self, n, width, values)
      class(transfer_t), intent(inout) :: self
      integer, intent(in) :: n, width
      real(dp), intent(inout) :: values(n, width)
      integer :: d, i
      self%seen = self%seen + 1
      if (self%seen /= self%wanted) return
      if (.not. self%packs) then
         values = self%real_values
         return
      end if
      if (allocated(self%real_values)) deallocate (self%real_values)
      allocate (self%real_values(size(self%origin), width))
      do d = 1, width
         do i = 1, size(self%origin)
            self%real_values(i, d) = values(self%origin(i), d)
         end do
      end do
   end subroutine transfer_reals

   !> Pack or unpack a field of integers, if it is wanted.
   subroutine transfer_integers(self, n, values)
      class(transfer_t), intent(inout) :: self
      integer, intent(in) :: n
      integer, intent(inout) :: values(n)
      self%seen = self%seen + 1
      if (self%seen /= self%wanted) return
      if (self%packs) then
         self%whole_values = values(self%origin)
      else
         values = int(self%whole_values)
      end if
   end subroutine transfer_integers

   !> Pack or unpack a field of long integers, if it is wanted.
   subroutine transfer_longs(self, n, values)
      class(transfer_t), intent(inout) :: self
      integer, intent(in) :: n
      integer(long), intent(inout) :: values(n)
      self%seen = self%seen + 1
      if (self%seen /= self%wanted) return
      if (self%packs) then
         self%whole_values = values(self%origin)
      else
         values = self%whole_values
      end if
   end subroutine transfer_longs

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

   !> H_33 of particle `i`, u_r/R of axisymmetric material [-]; 0 in a plane.
   pure real(dp) function hoop_of(self, i) result(hoop)
      class(particles_t), intent(in) :: self
      integer, intent(in) :: i
      hoop = 0
      if (self%thickness%is_ring) hoop = self%widening(i)/self%reference(i, 1)
   end function hoop_of

   !> Area in the plane for which particle `i` stands [m2].
   pure real(dp) function area_of(self, i) result(area)
      class(particles_t), intent(in) :: self
      integer, intent(in) :: i
      real(dp) :: x(ndim)                        ! in one piece
      x = self%reference(i, :)
      area = self%volume(i)/self%thickness%at(x)
   end function area_of

   !> Weights of some particles in means over places, in proportion to areas in the plane for particles of one material, sum 1 [-]:
   !> masses, of rings over their radii.
   pure function weights_of(self, members) result(weight)
      class(particles_t), intent(in) :: self
      integer, intent(in) :: members(:)
      real(dp) :: weight(size(members))
      weight = self%mass(members)
      if (self%thickness%is_ring) weight = weight/self%reference(members, 1)
      weight = weight/sum(weight)
   end function weights_of

   !> State variables of particle `i`, the first `columns` numbers: zeros for number 0, none where no law has a history. Its size is
   !> the longest history, so that it needs no room of its own.
   pure function history_of(self, i) result(state)
      class(particles_t), intent(in) :: self
      integer, intent(in) :: i
      real(dp) :: state(most_columns)
      if (.not. allocated(self%history)) return
      state(:self%columns()) = 0
      if (i > 0) state(:self%columns()) = self%history(i, :)
   end function history_of

   !> Edges of the reference rectangle of a particle [m].
   pure function spacing_of(p, i) result(spacing)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: spacing(ndim)
      spacing = p%spacing(:, p%body(i))
      if (allocated(p%level)) spacing = scale(spacing, -p%level(i))
   end function spacing_of

   !> Number of state variables of a particle.
   pure integer function columns(self)
      class(particles_t), intent(in) :: self
      columns = 0
      if (allocated(self%history)) columns = size(self%history, 2)
   end function columns
end module hampm_particles
