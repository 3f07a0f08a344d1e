!> Splitting particles into children and recombining these.
!>
!> The children stand at the quarter points of the parent's reference rectangle, X +- s/4, s being its edges: (15)-(18). They
!> carry u + H dX + t dx1 dx2 and v + L dx, and the parent's H with its change along dx that t gives. Here t is the twist of the
!> bilinear displacement field of the coarse cell, its mixed second derivative: with it the children's strains are those of
!> one displacement field that the finer cells can represent. Children that copied H would keep the steps between them for good, as
!> initial strains that nothing removes. Mass, volume, linear momentum and the mean of H and u stay, and angular
!> momentum to second order in s; strain energy stays where t is 0. Recombining gives the sums of mass, volume and momentum, the
!> mean position, and the volume-weighted H and history of the laws.
!>
!> What an unsplit particle's number and the path of splits below it are stays with its children, so that siblings
!> find each other wherever they have moved.
module hampm_splitting
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t, corner_offset, outside, deepest
   use hampm_particles, only: particles_t, take_particles
   use hampm_place_table, only: place_table_t
   use hampm_tensors, only: identity
   implicit none
   private
   public :: start_families, split, recombine, child_offset, middle_of_parent, spacing_of

   real(dp), parameter :: reach = 2              !! siblings further from their mean, in edges of the parent, stay apart

contains

   !> Begin to keep account of splits.
   subroutine start_families(p)
      type(particles_t), intent(inout) :: p
      if (allocated(p%level)) return
      allocate (p%level(p%n), source=0)
      allocate (p%path(p%n), source=0_long)
   end subroutine start_families

   !> Edges of the reference rectangle of a particle [m].
   pure function spacing_of(p, i) result(spacing)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp) :: spacing(ndim)
      spacing = p%spacing(:, p%body(i))
      if (allocated(p%level)) spacing = scale(spacing, -p%level(i))
   end function spacing_of

   !> Where child `c` of particle `i` stands from it in the reference configuration: dX [m].
   pure function child_offset(p, i, c) result(offset)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i, c
      real(dp) :: offset(ndim)
      offset = (2*corner_offset(c) - 1)*spacing_of(p, i)/4
   end function child_offset

   !> Reference position of the particle of which a particle is a child [m].
   pure function middle_of_parent(p, i) result(x)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i                   !! a child
      real(dp) :: x(ndim)
      x = p%reference(i, :) - (2*corner_offset(int(mod(p%path(i), int(corners, long))) + 1) - 1)*spacing_of(p, i)/2
   end function middle_of_parent

   !> Split the marked particles. The children of a particle stand together where it stood. The particles have to be sorted
   !> afterwards. Fails where the memory does not suffice.
   subroutine split(p, marked, velocity_gradient, twist, first_child, failure)
      type(particles_t), intent(inout) :: p
      logical, intent(in) :: marked(:)                     !! (n)
      real(dp), intent(in) :: velocity_gradient(:, :, :)   !! L of the marked ones, in space; in the total frame in the
                                                           !! reference configuration [1/s]; (ndim, ndim, marked)
      real(dp), intent(in) :: twist(:, :)                  !! t of the marked ones, in space; in the total frame in the
                                                           !! reference configuration [1/m]; (ndim, marked)
      integer, allocatable, intent(out) :: first_child(:)  !! new place of each particle or of its first child, (n)
      type(failure_t), intent(inout) :: failure
      integer, allocatable :: origin(:)
      integer :: i, c, k, marks
      allocate (first_child(p%n), origin(p%n + (corners - 1)*count(marked)))
      k = 0
      do i = 1, p%n
         first_child(i) = k + 1
         do c = 1, merge(corners, 1, marked(i))
            k = k + 1
            origin(k) = i
         end do
      end do
      call take_particles(p, origin, failure)
      if (failure%failed()) return
      marks = 0
      do i = 1, size(marked)
         if (.not. marked(i)) cycle
         marks = marks + 1
         do c = 1, corners
            call become_child(p, first_child(i) + c - 1, c, velocity_gradient(:, :, marks), twist(:, marks))
         end do
      end do
   end subroutine split

   !> Make particle `k`, a copy of its parent, child `c`.
   subroutine become_child(p, k, c, l, twist)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: k, c
      real(dp), intent(in) :: l(ndim, ndim)      !! L [1/s]
      real(dp), intent(in) :: twist(ndim)        !! [1/m]
      real(dp) :: offset(ndim), apart(ndim), f(ndim, ndim), extent(ndim), change(ndim, ndim)
      offset = child_offset(p, k, c)
      f = identity
      if (.not. p%total_frame) f = f + p%gradient(k, :, :)
      apart = matmul(f, offset)                  ! dx, and in the total frame dX
      extent = abs(offset)
      change(:, 1) = twist*apart(2)
      change(:, 2) = twist*apart(1)
      p%reference(k, :) = p%reference(k, :) + offset
      ! Of t dx1 dx2 its mean over the children is taken off, so that their centre stays where the parent is
      p%displacement(k, :) = p%displacement(k, :) + matmul(p%gradient(k, :, :), offset) &
                             + twist*(product(apart) - sum(f(1, :)*f(2, :)*extent**2))
      p%gradient(k, :, :) = p%gradient(k, :, :) + matmul(f, matmul(change, f))
      p%velocity(k, :) = p%velocity(k, :) + matmul(l, apart)
      p%mass(k) = p%mass(k)/corners
      p%volume(k) = p%volume(k)/corners
      p%level(k) = p%level(k) + 1
      p%path(k) = p%path(k)*corners + (c - 1)
   end subroutine become_child

   !> Recombine the families of siblings of which all are marked, and near each other, where that makes a particle as fine as the
   !> leaf in which it then stands. The particles have to be sorted afterwards. Fails where the memory does not suffice.
   subroutine recombine(p, marked, forest, families, new_number, failure)
      type(particles_t), intent(inout) :: p
      logical, intent(in) :: marked(:)                   !! (n)
      type(forest_t), intent(in) :: forest
      integer, intent(out) :: families                   !! how many were recombined
      integer, allocatable, intent(out) :: new_number(:) !! new place of each particle, or of the one that it is part of; (n)
      type(failure_t), intent(inout) :: failure
      integer, allocatable :: member(:, :), origin(:)
      integer :: i, k, f
      call find_families(p, marked, forest, member, families)
      if (families == 0) return
      allocate (new_number(p%n), source=-1)
      do f = 1, families
         call merge_into_first(p, member(:, f))
         new_number(member(2:, f)) = 0           ! no place of their own
      end do
      origin = pack([(i, i=1, p%n)], new_number /= 0)
      do k = 1, size(origin)
         new_number(origin(k)) = k
      end do
      do f = 1, families
         new_number(member(2:, f)) = new_number(member(1, f))
      end do
      call take_particles(p, origin, failure)
   end subroutine recombine

   !> The families that recombine, in the order of their first members.
   subroutine find_families(p, marked, forest, member, families)
      type(particles_t), intent(in) :: p
      logical, intent(in) :: marked(:)
      type(forest_t), intent(in) :: forest
      integer, allocatable, intent(out) :: member(:, :)  !! (corners, families and more)
      integer, intent(out) :: families
      type(place_table_t) :: table
      integer, allocatable :: found(:)
      integer :: i, f, status
      integer(long) :: key(ndim)
      allocate (member(corners, count(marked)), source=0)
      allocate (found(count(marked)), source=0)
      families = 0
      if (size(found) == 0) return
      call table%reserve(size(found), status)
      key = 0
      do i = 1, p%n
         if (.not. marked(i) .or. p%level(i) == 0) cycle
         key(1) = p%id(i)*(deepest + 1_long) + p%level(i) ! a number for each pair of both
         key(2) = p%path(i)/corners
         call table%enter(key, f)
         found(f) = found(f) + 1
         member(int(mod(p%path(i), int(corners, long))) + 1, f) = i
      end do
      do f = 1, table%n
         if (found(f) < corners) cycle
         if (.not. is_together(p, member(:, f))) cycle
         if (.not. fits_between(p, member(:, f), forest)) cycle
         families = families + 1
         member(:, families) = member(:, f)
      end do
   end subroutine find_families

   !> Whether siblings are near each other.
   pure logical function is_together(p, siblings)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: siblings(corners)
      real(dp) :: x(ndim, corners), middle(ndim)
      integer :: c
      do c = 1, corners
         x(:, c) = p%position(siblings(c))
      end do
      middle = sum(x, dim=2)/corners
      is_together = maxval(abs(x - spread(middle, 2, corners))) <= reach*2*maxval(spacing_of(p, siblings(1)))
   end function is_together

   !> Whether what siblings are together is as fine as the leaf in their middle. It may not be though their own leaves are coarse:
   !> a family that is much stretched may stand around a fine cell.
   pure logical function fits_between(p, siblings, forest) result(fits)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: siblings(corners)
      type(forest_t), intent(in) :: forest
      real(dp) :: x(ndim)
      integer :: leaf
      x = mean_of(p%reference, siblings)
      if (.not. p%total_frame) x = x + mean_of(p%displacement, siblings)
      leaf = forest%leaf_at(x)
      fits = leaf /= outside
      if (fits) fits = forest%level_of(leaf) < p%level(siblings(1))
   end function fits_between

   !> Mean of a vector over siblings.
   pure function mean_of(vector, siblings) result(mean)
      real(dp), intent(in) :: vector(:, :)       !! (n, ndim)
      integer, intent(in) :: siblings(corners)
      real(dp) :: mean(ndim)
      mean = sum(vector(siblings, :), dim=1)/corners
   end function mean_of

   !> Make the first of some siblings what all are together.
   subroutine merge_into_first(p, siblings)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: siblings(corners)
      real(dp) :: momentum(ndim), mass, volume, gradient(ndim, ndim)
      integer :: c
      mass = sum(p%mass(siblings))
      volume = sum(p%volume(siblings))
      momentum = 0
      gradient = 0
      do c = 1, corners
         momentum = momentum + p%mass(siblings(c))*p%velocity(siblings(c), :)
         gradient = gradient + p%volume(siblings(c))*p%gradient(siblings(c), :, :)
      end do
      associate (k => siblings(1))
         p%reference(k, :) = mean_of(p%reference, siblings)
         p%displacement(k, :) = mean_of(p%displacement, siblings)
         p%velocity(k, :) = momentum/mass
         p%gradient(k, :, :) = gradient/volume
         if (allocated(p%history)) p%history(k, :) = matmul(p%volume(siblings), p%history(siblings, :))/volume
         p%mass(k) = mass
         p%volume(k) = volume
         p%level(k) = p%level(k) - 1
         p%path(k) = p%path(k)/corners
      end associate
   end subroutine merge_into_first
end module hampm_splitting
