!> Contact between bodies, each on its own velocity field of the grid (`hampm_grid`).
!>
!> Copies of a node on two velocity fields that both have mass are a pair, with one normal n, from the first body to the second, and
!> a gap g, both by the extents of their particles at t^n (`hampm_body_extents`). Where the velocities w that move the particles
!> would close the gap, equal and opposite impulses J change w by the lumped masses so that the bodies just meet (momentum is
!> exact):
!>
!>    (w2 - w1) . n = -g/dt,   and 0 where they touch or overlap.
!>
!> Tangentially the impulse is what sticking needs, with friction at most the coefficient times the normal one. Mapped velocities of
!> a pair in touch get their common part, or they would act as a viscosity of the surface. J takes -J . ((v2 - v1)^n + (w2 - w1))/2
!> of the energy: tangentially by friction, normally as nodes that meet do so inelastically (docs/explanation/contact.md).
module hampm_body_contact
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_archive, only: archive_t
   use hampm_body_extents, only: extents_t, gather_extents, find_normal_and_gap
   use hampm_cell_blocks, only: cell_blocks_t
   use hampm_domain_pass, only: corner_map_t
   use hampm_grid, only: grid_t
   use hampm_nodal_fields, only: nodal_fields_t, v_n, v_next
   use hampm_particles, only: particles_t
   implicit none
   private
   public :: body_contact_t, rebuild_body_contact, find_body_pairs, find_gaps, share_between_bodies, separate_bodies, &
             archive_body_contact

   ! How a pair is after a step
   integer, parameter :: apart = 0, slides = 1, sticks = 2

   !> Copies of a node, of the body on the lower velocity field and of that on the upper one.
   type :: body_pair_t
      integer :: node(2) = 0
      logical :: of_first = .false.              !! whether one of the two is on the first velocity field
      integer :: state = apart                   !! or `slides` or `sticks`
      real(dp) :: normal(ndim) = 0               !! from the first to the second
      real(dp) :: gap = 0                        !! less `distance`, huge where bodies are too far apart to meet [m]
      real(dp) :: slip(ndim) = 0                 !! v2 - v1 at t^n [m/s]
   end type body_pair_t

   !> The pairs of nodes of bodies that are near each other.
   type :: body_contact_t
      logical :: wanted = .false.                !! whether bodies have velocity fields of their own; without, there are no pairs
      logical :: always_sticks = .false.         !! whether bodies that touch do not slide
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: distance = 0                   !! gap at which they touch [m]
      integer :: n = 0                           !! number of pairs
      type(body_pair_t), allocatable :: pair(:)  !! (n)
      integer, allocatable :: first(:)           !! pairs at one place follow each other: the first of each place, and n + 1
      real(dp) :: force(ndim) = 0                !! on all others of the bodies on the first velocity field, in the last step [N]
      real(dp) :: loss = 0                       !! energy that bodies have lost by meeting [J]
      real(dp) :: friction_loss = 0              !! energy taken by friction [J]
      integer, private :: layout = -1            !! of the mass matrix when the pairs were listed
      integer, allocatable, private :: copies(:, :)  !! see `copies_of_nodes` of the grid
      type(extents_t), private :: sides(2)       !! workspace
   end type body_contact_t

   integer, parameter :: most_sweeps = 8         !! over the pairs at a place where three bodies meet

contains

   !> Forget the pairs of the last grid.
   subroutine rebuild_body_contact(c, grid)
      type(body_contact_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      if (.not. c%wanted) return
      c%n = 0
      c%layout = -1
      c%pair = [body_pair_t ::]
      call grid%copies_of_nodes(c%copies)
   end subroutine rebuild_body_contact

   !> List the pairs, after particles have changed cells. Old pairs are unchanged.
   subroutine find_body_pairs(c, grid, f)
      type(body_contact_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(in) :: f
      type(body_pair_t), allocatable :: pair(:)
      integer, allocatable :: first(:)
      integer :: i, a, b, n, old, places
      if (c%layout == f%mass_matrix%layout) return
      c%layout = f%mass_matrix%layout
      n = 0
      places = 0
      do i = 1, grid%n_nodes
         a = count_active(c%copies(:, i), f%is_active)
         if (a > 1) places = places + 1
         n = n + (a*(a - 1))/2
      end do
      allocate (pair(n), first(places + 1))
      n = 0
      places = 0
      old = 1
      do i = 1, grid%n_nodes
         if (count_active(c%copies(:, i), f%is_active) < 2) cycle
         places = places + 1
         first(places) = n + 1
         do a = 1, size(c%copies, 1)
            if (.not. f%is_active(c%copies(a, i))) cycle
            do b = a + 1, size(c%copies, 1)
               if (.not. f%is_active(c%copies(b, i))) cycle
               n = n + 1
               pair(n)%node = c%copies([a, b], i)
               pair(n)%of_first = a == 1
               call find_in(c, pair(n)%node, old)
               if (old <= c%n) pair(n)%state = c%pair(old)%state
            end do
         end do
      end do
      first(places + 1) = n + 1
      c%n = n
      call move_alloc(pair, c%pair)
      call move_alloc(first, c%first)
   end subroutine find_body_pairs

   !> How many of the copies of a node are active; none of a point that is no node of the first velocity field.
   pure integer function count_active(copies, is_active) result(n)
      integer, intent(in) :: copies(:)
      logical, intent(in) :: is_active(:)
      n = 0
      if (copies(1) > 0) n = count(is_active(copies))
   end function count_active

   !> Find a pair among those that there were, from a place on and then from the first; their number and one where it was not.
   pure subroutine find_in(c, node, at)
      type(body_contact_t), intent(in) :: c
      integer, intent(in) :: node(2)
      integer, intent(inout) :: at
      integer :: k, from
      from = at
      do k = 0, c%n - 1
         at = 1 + modulo(from - 1 + k, c%n)
         if (all(c%pair(at)%node == node)) return
      end do
      at = c%n + 1
   end subroutine find_in

   !> Find the normals and gaps of the pairs, now that the particles are where they are.
   subroutine find_gaps(c, grid, p, blocks, map)
      type(body_contact_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      type(cell_blocks_t), intent(in) :: blocks
      type(corner_map_t), intent(in) :: map      !! of domains, where particles have any
      integer :: k, side
      do k = 1, c%n
         associate (pair => c%pair(k))
            do side = 1, 2
               call gather_extents(grid, p, blocks, map, pair%node(side), c%sides(side))
            end do
            pair%gap = huge(pair%gap)
            if (any(c%sides%n == 0)) cycle
            call find_normal_and_gap(p, grid%smallest_leaf_at(pair%node(1)), c%sides(1), c%sides(2), pair%normal, pair%gap)
            if (pair%gap < huge(pair%gap)) pair%gap = pair%gap - c%distance
         end associate
      end do
   end subroutine find_gaps

   !> Give pairs in touch their common part of a mapped velocity, `v_n` or `v_mapped`: the normal component, and all where they
   !> stick.
   subroutine share_between_bodies(c, grid, free, f, which)
      type(body_contact_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in), contiguous :: free(:, :) !! 0 for fixed components of nodes, else 1; (ndim, n_points)
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: which
      real(dp) :: impulse(ndim), give(ndim)
      integer :: k
      associate (v => f%velocity(:, :, which))
         do k = 1, c%n
            associate (pair => c%pair(k), a => c%pair(k)%node(1), b => c%pair(k)%node(2), n => c%pair(k)%normal)
               impulse = 0
               if (pair%state /= apart .and. pair%gap < huge(pair%gap)) then
                  give = yielding(a, b, free, f)
                  if (pair%state == sticks) then
                     impulse = impulse_to_stick(give, v(:, b) - v(:, a), spread(0.0_dp, 1, ndim))
                  else
                     impulse = n*impulse_along(n, n, give, dot_product(v(:, b) - v(:, a), n), 0.0_dp)
                  end if
                  call push(a, b, free, f, impulse, v)
               end if
               if (which == v_n) pair%slip = v(:, b) - v(:, a)
            end associate
         end do
      end associate
      if (any(c%pair%state /= apart)) call grid%dofs%distribute(f%mass_matrix%all, ndim, f%velocity(:, :, which))
   end subroutine share_between_bodies

   !> Keep the bodies from interpenetrating: change accelerations and new velocities of the pairs that would, and book the loss of
   !> the bodies.
   subroutine separate_bodies(c, grid, free, dt, f)
      type(body_contact_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in), contiguous :: free(:, :) !! 0 for fixed components of nodes, else 1; (ndim, n_points)
      real(dp), intent(in) :: dt                 !! [s]
      type(nodal_fields_t), intent(inout) :: f
      real(dp) :: impulse(ndim)
      integer :: place, sweep, k
      logical :: acts
      c%force = 0
      c%pair%state = apart
      do place = 1, size(c%first) - 1
         do sweep = 1, most_sweeps
            acts = .false.
            do k = c%first(place), c%first(place + 1) - 1
               call meet(c, k, free, dt, f, impulse)
               acts = acts .or. any(abs(impulse) > 0)
            end do
            if (.not. acts .or. c%first(place + 1) - c%first(place) == 1) exit
         end do
      end do
      if (all(c%pair%state == apart)) return
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%acceleration)
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%velocity(:, :, v_next))
   end subroutine separate_bodies

   !> Let a pair meet, if it does.
   subroutine meet(c, k, free, dt, f, impulse)
      type(body_contact_t), intent(inout) :: c
      integer, intent(in) :: k                   !! the pair
      real(dp), intent(in), contiguous :: free(:, :)
      real(dp), intent(in) :: dt
      type(nodal_fields_t), intent(inout) :: f
      real(dp), intent(out) :: impulse(ndim)     !! on the second node [N s]; 0 where the pair does not meet
      real(dp), dimension(ndim) :: give, w, along, way
      real(dp) :: closing
      impulse = 0
      associate (pair => c%pair(k), a => c%pair(k)%node(1), b => c%pair(k)%node(2), n => c%pair(k)%normal, &
                 velocity => f%velocity(:, :, v_next))
         if (.not. pair%gap < huge(pair%gap)) return
         give = yielding(a, b, free, f)
         w = velocity(:, b) - velocity(:, a)
         closing = -max(pair%gap, 0.0_dp)/dt
         if (.not. dot_product(w, n) < closing) return
         pair%state = slides
         impulse = n*impulse_along(n, n, give, dot_product(w, n), closing)
         if (c%always_sticks .or. c%friction > 0) then
            impulse = impulse_to_stick(give, w, closing*n)
            along = impulse - dot_product(impulse, n)*n
            if (c%always_sticks .or. norm(along) <= c%friction*dot_product(impulse, n)) then
               pair%state = sticks
            else
               along = n + c%friction*along/norm(along)
               impulse = along*impulse_along(n, along, give, dot_product(w, n), closing)
            end if
         end if
         call push(a, b, free, f, impulse, velocity)
         call push(a, b, free, f, impulse/dt, f%acceleration)
         way = (pair%slip + velocity(:, b) - velocity(:, a))/2
         along = dot_product(impulse, n)*n
         if (c%always_sticks) along = impulse    ! nothing slides: all loss is by meeting
         c%loss = c%loss - dot_product(along, way)
         c%friction_loss = c%friction_loss - dot_product(impulse - along, way)
         if (pair%of_first) c%force = c%force + impulse/dt
      end associate
   end subroutine meet

   !> Change of the relative velocity of two nodes under a unit impulse in each direction; 0 for nodes that are held [1/kg].
   pure function yielding(a, b, free, f) result(give)
      integer, intent(in) :: a, b
      real(dp), intent(in) :: free(:, :)
      type(nodal_fields_t), intent(in) :: f
      real(dp) :: give(ndim)
      give = free(:, a)*f%mass_matrix%inverse_lumped(a) + free(:, b)*f%mass_matrix%inverse_lumped(b)
   end function yielding

   !> The impulse along a direction that changes the relative velocity in the direction n from `before` to `after` [N s]; 0 where
   !> nothing yields.
   pure real(dp) function impulse_along(n, direction, give, before, after) result(impulse)
      real(dp), intent(in) :: n(ndim), direction(ndim)
      real(dp), intent(in) :: give(ndim)         !! see `yielding`
      real(dp), intent(in) :: before, after      !! [m/s]
      impulse = 0
      if (dot_product(n, give*direction) > 0) impulse = (after - before)/dot_product(n, give*direction)
   end function impulse_along

   !> The impulse that changes the relative velocity from one to another [N s]; 0 for components in which nothing yields.
   pure function impulse_to_stick(give, before, after) result(impulse)
      real(dp), intent(in) :: give(ndim)         !! see `yielding`
      real(dp), intent(in) :: before(ndim), after(ndim) !! [m/s]
      real(dp) :: impulse(ndim)
      impulse = 0
      where (give > 0) impulse = (after - before)/give
   end function impulse_to_stick

   !> Change a nodal field at a pair by an impulse on the second node, and an opposite one on the first.
   pure subroutine push(a, b, free, f, impulse, field)
      integer, intent(in) :: a, b
      real(dp), intent(in) :: free(:, :)
      type(nodal_fields_t), intent(in) :: f
      real(dp), intent(in) :: impulse(ndim)      !! [N s]
      real(dp), intent(inout) :: field(:, :)     !! (ndim, n_points)
      field(:, a) = field(:, a) - free(:, a)*f%mass_matrix%inverse_lumped(a)*impulse
      field(:, b) = field(:, b) + free(:, b)*f%mass_matrix%inverse_lumped(b)*impulse
   end subroutine push

   !> Archive the pairs in touch, and the losses of contact.
   subroutine archive_body_contact(c, archive)
      type(body_contact_t), intent(inout) :: c
      class(archive_t), intent(inout) :: archive
      if (.not. c%wanted) return
      call archive%section('body_contact')
      call archive%serialise('loss', c%loss)
      call archive%serialise('friction_loss', c%friction_loss)
      call archive%archive_reals('force', ndim, c%force)
      call archive%serialise('pairs', c%n)
      if (archive%failure%failed()) return
      if (archive%is_read) then
         c%pair = spread(body_pair_t(), 1, c%n)
         c%layout = -1
      end if
      call archive%archive_integers('node_1', c%n, c%pair%node(1))
      call archive%archive_integers('node_2', c%n, c%pair%node(2))
      call archive%archive_integers('state', c%n, c%pair%state)
   end subroutine archive_body_contact
end module hampm_body_contact
