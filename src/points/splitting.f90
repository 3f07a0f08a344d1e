!> Splitting particles into children (`hampm_children`) and recombining these; docs/explanation/hierarchy.md.
!>
!> The children carry u + H dX + t dx1 dx2 and v + L dx, and the parent's H with its change along dx by t, the hourglass of the
!> bilinear displacement field of the coarse cell (its mixed second derivative; in space one of four): one displacement field of the
!> finer cells. Mass, volume, linear momentum and the mean of H and u stay, angular momentum to second order in s, strain energy
!> where t is 0. Recombining gives the sums of mass, volume and momentum, the parent's place, and the mass-weighted mean of H and
!> history. Number and path of splits of the unsplit particle stay with its children: siblings find each other wherever they are.
!>
!> Corners of the children's domains are points of the parent's bilinear fields, and those that were the parent's return to it
!> unchanged. Four corners with the mass of a rectangle have three times its moment of inertia, those of four children 3/2 of it:
!> splitting takes angular momentum from material that turns, and recombining gives it back.
module hampm_splitting
   use hampm_kinds, only: dp, ndim, corners, long
   use hampm_failure, only: failure_t
   use hampm_basis, only: n_hourglasses, hourglass_directions
   use hampm_forest, only: forest_t, corner_offset, outside, deepest
   use hampm_particles, only: particles_t, take_particles, spacing_of
   use hampm_place_table, only: place_table_t
   use hampm_tensors, only: identity
   use hampm_domains, only: edges_of_domain, weights_in_domain, reference_corners, corner_gradients, follow_corners
   use hampm_children, only: children_of, is_half, litter_t, place_of_parent, quarters_of
   implicit none
   private
   public :: start_families, split, recombine

   !> The bilinear fields of a domain.
   type :: domain_t
      real(dp) :: middle(ndim) = 0               !! reference position of the particle [m]
      real(dp) :: edges(ndim) = 0                !! of the reference domain [m]
      real(dp) :: displacement(ndim, corners) = 0 !! of the corners [m]
      real(dp) :: velocity(ndim, corners) = 0    !! of the corners [m/s]
   end type domain_t

   real(dp), parameter :: reach = 2              !! siblings further from their mean, in edges of the parent, stay apart

contains

   !> Begin to keep account of splits.
   subroutine start_families(p)
      type(particles_t), intent(inout) :: p
      if (allocated(p%level)) return
      allocate (p%level(p%n), source=0)
      allocate (p%path(p%n), source=0_long)
      allocate (p%half(p%n, ndim), source=0.0_dp)
   end subroutine start_families

   !> Split the marked particles. The children of a particle stand together where it stood. The particles have to be sorted
   !> afterwards. Fails where the memory does not suffice.
   subroutine split(p, marked, velocity_gradient, hourglasses, normal, first_child, failure)
      type(particles_t), intent(inout) :: p
      logical, intent(in) :: marked(:)                     !! (n)
      real(dp), intent(in) :: velocity_gradient(:, :, :)   !! L of the marked ones, in space; in the total frame in the
                                                           !! reference configuration [1/s]; (ndim, ndim, marked)
      real(dp), intent(in) :: hourglasses(:, :, :)              !! t of the marked ones, in space; in the total frame in the
                                                           !! reference configuration [1/m]; (ndim, n_hourglasses, marked)
      real(dp), intent(in) :: normal(:, :)                 !! of the cracks through the middles of the marked ones, 0 where there
                                                           !! if none; (ndim, marked)
      integer, allocatable, intent(out) :: first_child(:)  !! new place of each particle or of its first child, and behind the last;
                                                           !! (n + 1)
      type(failure_t), intent(inout) :: failure
      type(litter_t), allocatable :: litter(:)
      type(domain_t) :: parent
      integer, allocatable :: origin(:)
      integer :: i, c, marks
      allocate (litter(count(marked)), first_child(p%n + 1))
      first_child(1) = 1
      marks = 0
      do i = 1, p%n
         first_child(i + 1) = first_child(i) + 1
         if (.not. marked(i)) cycle
         marks = marks + 1
         litter(marks) = children_of(p, i, normal(:, marks))
         first_child(i + 1) = first_child(i) + litter(marks)%n
      end do
      allocate (origin(first_child(p%n + 1) - 1))
      do i = 1, p%n
         origin(first_child(i):first_child(i + 1) - 1) = i
      end do
      call take_particles(p, origin, failure)
      if (failure%failed()) return
      marks = 0
      do i = 1, size(marked)
         if (.not. marked(i)) cycle
         marks = marks + 1
         if (allocated(p%corner_velocity)) parent = domain_of(p, first_child(i))
         do c = 1, litter(marks)%n
            call become_child(p, first_child(i) + c - 1, c, litter(marks), velocity_gradient(:, :, marks), hourglasses(:, :, marks))
         end do
         if (allocated(p%corner_velocity)) call divide_domain(p, first_child(i), first_child(i + 1) - 1, parent)
      end do
   end subroutine split

   !> Make particle `k`, a copy of its parent, the c-th child of a litter.
   subroutine become_child(p, k, c, litter, l, hourglasses)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: k, c
      type(litter_t), intent(in) :: litter
      real(dp), intent(in) :: l(ndim, ndim)      !! L [1/s]
      real(dp), intent(in) :: hourglasses(ndim, n_hourglasses) !! [1/m], in three directions [1/m2]
      real(dp) :: apart(ndim, corners), middle(ndim), f(ndim, ndim), change(ndim, ndim), part(corners), displaced(ndim)
      real(dp) :: products(corners), others
      integer :: d, j, s
      f = identity
      if (.not. p%total_frame) f = f + p%gradient(k, :, :)
      apart = matmul(f, litter%offset)           ! dx, and in the total frame dX
      ! The quarters beside a slanted crack may not have the centroid of their half: velocities are corrected by the difference
      part = litter%part                         ! of rings those that are wider have more
      if (p%thickness%is_ring) part = part*(1 + litter%offset(1, :)/p%reference(k, 1))
      middle = matmul(apart, part)
      p%reference(k, :) = p%reference(k, :) + litter%offset(:, c)
      displaced = matmul(p%gradient(k, :, :), litter%offset(:, c))
      change = 0
      do s = 1, n_hourglasses
         products = litter%part
         do d = 1, ndim
            if (.not. btest(hourglass_directions(s), d - 1)) cycle
            products = products*apart(d, :)
            others = product(apart(:, c), mask=[(j /= d .and. btest(hourglass_directions(s), j - 1), j=1, ndim)])
            change(:, d) = change(:, d) + hourglasses(:, s)*others
         end do
         ! Of t dx1 dx2 its mean over the children is taken off, so that their centre stays where the parent is
         others = product(apart(:, c), mask=[(btest(hourglass_directions(s), j - 1), j=1, ndim)])
         displaced = displaced + hourglasses(:, s)*(others - sum(products))
      end do
      p%displacement(k, :) = p%displacement(k, :) + displaced
      if (allocated(p%widening)) p%widening(k) = p%widening(k) + displaced(1)
      p%gradient(k, :, :) = p%gradient(k, :, :) + matmul(f, matmul(change, f))
      p%velocity(k, :) = p%velocity(k, :) + matmul(l, apart(:, c) - middle)
      p%mass(k) = p%mass(k)*part(c)
      p%volume(k) = p%volume(k)*part(c)
      p%level(k) = p%level(k) + litter%level(c)
      p%path(k) = litter%path(c)
      p%half(k, :) = litter%half(:, c)
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
      integer :: i, k, f, n
      call find_families(p, marked, forest, member, families)
      if (families == 0) return
      allocate (new_number(p%n), source=-1)
      do f = 1, families
         n = count(member(:, f) > 0)
         call merge_into_first(p, member(:n, f))
         new_number(member(2:n, f)) = 0          ! no place of their own
      end do
      origin = pack([(i, i=1, p%n)], new_number /= 0)
      do k = 1, size(origin)
         new_number(origin(k)) = k
      end do
      do f = 1, families
         n = count(member(:, f) > 0)
         new_number(member(2:n, f)) = new_number(member(1, f))
      end do
      call take_particles(p, origin, failure)
   end subroutine recombine

   !> The families that recombine, in the order of their first members.
   subroutine find_families(p, marked, forest, member, families)
      type(particles_t), intent(in) :: p
      logical, intent(in) :: marked(:)
      type(forest_t), intent(in) :: forest
      integer, allocatable, intent(out) :: member(:, :)  !! 0 behind the last, (corners, families and more)
      integer, intent(out) :: families
      type(place_table_t) :: table
      type(litter_t) :: parent
      real(dp) :: x(ndim)
      integer :: siblings(corners), n
      integer :: i, f, status
      integer(long) :: key(ndim)
      allocate (member(corners, count(marked)), source=0)
      families = 0
      if (size(member, 2) == 0) return
      call table%reserve(size(member, 2), status)
      key = 0
      do i = 1, p%n
         if (.not. marked(i) .or. p%level(i) == 0 .or. is_half(p, i)) cycle
         key(1) = p%id(i)*(deepest + 1_long) + p%level(i) ! a number for each pair of both
         key(2) = p%path(i)/corners
         call table%enter(key, f)
         member(int(mod(p%path(i), int(corners, long))) + 1, f) = i
      end do
      do f = 1, table%n
         n = count(member(:, f) > 0)
         siblings(:n) = pack(member(:, f), member(:, f) > 0)
         x = p%reference(siblings(1), :)
         parent = quarters_of(p, p%body(siblings(1)), x, spacing_of(p, siblings(1)), 0_long)
         if (n < parent%n) cycle
         if (.not. is_together(p, siblings(:n))) cycle
         if (.not. fits_between(p, siblings(:n), forest)) cycle
         families = families + 1
         member(:, families) = 0
         member(:n, families) = siblings(:n)
      end do
   end subroutine find_families

   !> Whether siblings are near each other in the grid.
   pure logical function is_together(p, siblings)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: siblings(:)
      real(dp) :: x(ndim, size(siblings)), middle(ndim)
      integer :: c
      do c = 1, size(siblings)
         x(:, c) = p%place_in_grid(siblings(c))
      end do
      middle = sum(x, dim=2)/size(siblings)
      is_together = maxval(abs(x - spread(middle, 2, size(siblings)))) <= reach*2*maxval(spacing_of(p, siblings(1)))
   end function is_together

   !> Whether the parent of siblings is as fine as the leaf in their middle. It may not be even if their own leaves are coarse: a
   !> family that is much stretched may stand around a fine cell.
   pure logical function fits_between(p, siblings, forest) result(fits)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: siblings(:)
      type(forest_t), intent(in) :: forest
      real(dp) :: x(ndim)
      integer :: leaf
      x = place_of_parent(p, siblings(1))
      if (.not. p%total_frame) x = x + mean_of(p, p%displacement, siblings)
      leaf = forest%leaf_at(x)
      fits = leaf /= outside
      if (fits) fits = forest%level_of(leaf) < p%level(siblings(1))
   end function fits_between

   !> Mean of a vector over siblings.
   pure function mean_of(p, vector, siblings) result(mean)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: vector(:, :)       !! (n, ndim)
      integer, intent(in) :: siblings(:)
      real(dp) :: mean(ndim), weight(size(siblings)), of_each(size(siblings), ndim)
      weight = p%weights_of(siblings)
      of_each = vector(siblings, :)
      mean = matmul(weight, of_each)
   end function mean_of

   !> Make the first of some siblings their parent.
   subroutine merge_into_first(p, siblings)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: siblings(:)
      type(domain_t) :: domain
      real(dp) :: momentum(ndim), mass, volume, gradient(ndim, ndim), displacement(ndim), place(ndim), aside(ndim)
      integer :: c
      mass = sum(p%mass(siblings))
      volume = sum(p%volume(siblings))
      momentum = 0
      gradient = 0
      do c = 1, size(siblings)
         momentum = momentum + p%mass(siblings(c))*p%velocity(siblings(c), :)
         gradient = gradient + p%mass(siblings(c))*p%gradient(siblings(c), :, :)
      end do
      place = place_of_parent(p, siblings(1))
      if (allocated(p%corner_velocity)) domain = joined_domain(p, siblings, place)
      associate (k => siblings(1))
         aside = matmul(gradient/mass, place - mean_of(p, p%reference, siblings)) ! weights of a quadrature have another mean
         displacement = mean_of(p, p%displacement, siblings) + aside
         if (allocated(p%widening)) p%widening(k) = dot_product(p%weights_of(siblings), p%widening(siblings)) + aside(1)
         p%reference(k, :) = place
         p%displacement(k, :) = displacement
         p%velocity(k, :) = momentum/mass
         p%gradient(k, :, :) = gradient/mass
         if (allocated(p%history)) p%history(k, :) = matmul(p%mass(siblings), p%history(siblings, :))/mass
         p%mass(k) = mass
         p%volume(k) = volume
         p%level(k) = p%level(k) - 1
         p%path(k) = p%path(k)/corners
         if (allocated(p%corner_velocity)) call take_domain(p, k, domain)
      end associate
   end subroutine merge_into_first

   !> The domain of a particle.
   pure type(domain_t) function domain_of(p, i) result(domain)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      domain%middle = p%reference(i, :)
      domain%edges = edges_of_domain(p, i)
      domain%displacement = p%corner_displacement(i, :, :)
      domain%velocity = p%corner_velocity(i, :, :)
   end function domain_of

   !> Give children, side by side and in place, their parts of the parent's domain. Where they are not alike, the products of the
   !> coordinates do not cancel: all children share the missing momentum.
   pure subroutine divide_domain(p, first, last, parent)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: first, last         !! the children
      type(domain_t), intent(in) :: parent
      real(dp) :: missing(ndim)
      integer :: k
      missing = sum(parent%velocity, dim=2)/corners
      do k = first, last
         call take_domain(p, k, parent)
         missing = missing - p%mass(k)/sum(p%mass(first:last))*p%velocity(k, :)
      end do
      do k = first, last
         p%corner_velocity(k, :, :) = p%corner_velocity(k, :, :) + spread(missing, 2, corners)
         call follow_corners(p, k)
      end do
   end subroutine divide_domain

   !> Let the corners of a particle be points of the fields of a domain.
   pure subroutine take_domain(p, k, domain)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: k
      type(domain_t), intent(in) :: domain
      real(dp) :: n(corners), x(ndim, corners)
      integer :: c
      x = reference_corners(p, k)
      do c = 1, corners
         n = weights_in_domain(x(:, c) - domain%middle, domain%edges)
         p%corner_displacement(k, :, c) = matmul(domain%displacement, n)
         p%corner_velocity(k, :, c) = matmul(domain%velocity, n)
      end do
      call follow_corners(p, k)
   end subroutine take_domain

   !> The common domain of siblings, around their mean: by the corners that were the parent's if there are all four children of a
   !> rectangle, else linear fields by their means.
   pure type(domain_t) function joined_domain(p, siblings, middle) result(domain)
      type(particles_t), intent(in) :: p
      integer, intent(in) :: siblings(:)         !! in the order of the quarters that they are
      real(dp), intent(in) :: middle(ndim)       !! their mean in the reference configuration [m]
      real(dp) :: part(size(siblings)), velocity(ndim), u(ndim), h(ndim, ndim), l(ndim, ndim)
      integer :: c
      domain%middle = middle
      domain%edges = 2*edges_of_domain(p, siblings(1))
      part = p%mass(siblings)/sum(p%mass(siblings))
      velocity = matmul(part, p%velocity(siblings, :))
      if (size(siblings) == corners .and. .not. p%has_outline(p%body(siblings(1)))) then
         do c = 1, corners
            domain%displacement(:, c) = p%corner_displacement(siblings(c), :, c)
            domain%velocity(:, c) = p%corner_velocity(siblings(c), :, c)
         end do
      else
         u = matmul(part, p%displacement(siblings, :))
         h = 0
         l = 0
         do c = 1, size(siblings)
            associate (k => siblings(c))
               h = h + part(c)*p%gradient(k, :, :)
               l = l + part(c)*matmul(p%corner_velocity(k, :, :), transpose(corner_gradients(p, k)))
            end associate
         end do
         do c = 1, corners
            associate (offset => domain%edges*(corner_offset(c) - 0.5_dp))
               domain%displacement(:, c) = u + matmul(h, offset)
               domain%velocity(:, c) = matmul(l, offset)
            end associate
         end do
      end if
      velocity = velocity - sum(domain%velocity, dim=2)/corners
      domain%velocity = domain%velocity + spread(velocity, 2, corners)
   end function joined_domain
end module hampm_splitting
