!> Frictionless contact of the faces of cuts: they press on each other and slide, but do not go through each other.
!>
!> The two nodes at one place on both sides of a cut are a pair. Its gap g is how far the upper one has moved from the lower one in
!> the direction normal to the cut. It begins with zero and follows the velocities w that move the particles,
!>
!>    g <- g + dt (w+ - w-).
!>
!> Where that would be negative, the velocities are changed by equal and opposite impulses, so that the faces just meet:
!> w+ - w- = -g/dt. With the lumped masses, their mean by mass stays. The particles are kicked by the change over dt; as
!> sum_p m_p N_i is the lumped mass whatever the mass matrix, momentum is exact with each. Gaps are never negative, and those of
!> pressed pairs are zero and not nearly so: such a pair stays for as long as the forces press, and parts as soon as they pull.
!>
!> In the total frame g is the distance of the faces of the particles' displacement field, but for rounding; in the updated one but
!> for what the sideways motion of the particles through the grid carries along.
!>
!> In a smooth field the mapped velocities of a pair differ, as each is a mean over its own side. Those of a pressed pair are one
!> velocity: two pressed sides then move as one piece does. Whatever the mass matrix of the run, the cells at pairs are lumped: a
!> force between the nodes of a pair moves only these, so that it can be found without solving for those of all pairs together.
!>
!> A node that has no partner, as beside cells of another size where the cut is not `matched`, is free.
module hampm_contact
   use hampm_kinds, only: dp, ndim, long
   use hampm_archive, only: archive_t
   use hampm_cuts, only: cut_t, is_within
   use hampm_grid, only: grid_t
   use hampm_mass_matrix, only: mass_matrix_t
   use hampm_nodal_fields, only: nodal_fields_t, v_n, v_next
   use hampm_place_table, only: place_table_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: contact_t, rebuild_contact, lump_at_touch, share_velocity, pressing_forces, pressed_pairs, share_normal, keep_apart, &
             keep_contact

   integer, parameter :: sides = 2               !! of a cut: upper, lower

   !> The pairs of nodes at the faces of cuts, and their gaps.
   type :: contact_t
      logical :: wanted = .false.                !! whether the faces of cuts touch; without, there are no pairs
      integer :: n = 0                           !! number of pairs
      integer, allocatable :: node(:, :)         !! the upper and the lower node of each pair, (sides, n)
      integer, allocatable :: cut(:)             !! on which cut it is, (n)
      integer, allocatable :: normal(:)          !! the direction normal to that, (n)
      integer(long), allocatable :: along(:)     !! place along that, in integer coordinates of the forest, (n)
      real(dp), allocatable :: gap(:)            !! g [m], (n)
      logical, allocatable :: touches(:)         !! whether it was pressed together in the last step, (n)
   end type contact_t

contains

   !> Find the pairs of a new grid. Their gaps are those of the last grid, linear between its pairs and zero at tips,
   !> or quadratic over the three of a quadratic cell.
   subroutine rebuild_contact(c, grid)
      type(contact_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      type(contact_t) :: old
      integer :: k
      if (.not. c%wanted) return
      old = c
      call find_pairs(c, grid)
      if (old%n == 0) return
      do k = 1, c%n
         call take_over(old, grid%cuts(c%cut(k)), c%cut(k), c%along(k), grid%is_quadratic(), c%gap(k), c%touches(k))
      end do
   end subroutine rebuild_contact

   !> List the pairs of nodes of a grid, by their places.
   subroutine find_pairs(c, grid)
      type(contact_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      type(place_table_t) :: places
      integer, allocatable :: node(:, :), copies(:, :)
      integer(long) :: place(ndim)
      real(dp) :: up(ndim)
      integer :: cut, i, k, status
      call places%reserve(16, status)
      allocate (node(sides, grid%n_nodes), source=0)
      c%cut = [integer ::]
      c%n = 0
      call grid%copies_of_nodes(copies)
      do cut = 1, size(grid%cuts)
         up = 0
         up(grid%cuts(cut)%normal) = 1
         do i = 1, grid%n_nodes
            place = grid%forest%nearest_place(grid%node_position(:, i))
            if (copies(1, i) == 0 .or. .not. is_within(grid%cuts(cut), place)) cycle ! cuts are on the first sheet only
            call places%enter(place, k)
            node(merge(1, 2, grid%has_element_toward(i, up)), k) = i
         end do
         c%cut = [c%cut, [(cut, k=size(c%cut) + 1, places%n)]]
      end do
      associate (paired => [(all(node(:, k) > 0), k=1, places%n)])
         c%n = count(paired)
         c%cut = pack(c%cut, paired)
         c%node = reshape(pack(node(:, :places%n), spread(paired, 1, sides)), [sides, c%n])
      end associate
      c%normal = grid%cuts(c%cut)%normal
      if (allocated(c%along)) deallocate (c%along)
      allocate (c%along(c%n))
      do k = 1, c%n
         place = grid%forest%nearest_place(grid%node_position(:, c%node(1, k)))
         c%along(k) = place(mod(c%normal(k), ndim) + 1)
      end do
      c%gap = [(0.0_dp, k=1, c%n)]
      c%touches = [(.false., k=1, c%n)]
   end subroutine find_pairs

   !> Gap at a place along a cut from the pairs at and around it. It touches where these do.
   pure subroutine take_over(old, cut, number, along, is_quadratic, gap, touches)
      type(contact_t), intent(in) :: old
      type(cut_t), intent(in) :: cut
      integer, intent(in) :: number              !! of the cut
      integer(long), intent(in) :: along
      logical, intent(in) :: is_quadratic        !! whether the cells are
      real(dp), intent(out) :: gap               !! [m]
      logical, intent(out) :: touches
      integer(long) :: place(2), apart
      real(dp) :: gaps(2), third, t
      integer :: k, neighbour(2)
      neighbour = [maxloc(old%along, dim=1, mask=old%cut == number .and. old%along <= along), &
                   minloc(old%along, dim=1, mask=old%cut == number .and. old%along >= along)]
      place = [cut%lower(mod(cut%normal, ndim) + 1), cut%upper(mod(cut%normal, ndim) + 1)]
      gaps = 0
      touches = .true.
      do k = 1, 2
         if (neighbour(k) == 0) cycle            ! between the last pair and a tip
         place(k) = old%along(neighbour(k))
         gaps(k) = old%gap(neighbour(k))
         touches = touches .and. old%touches(neighbour(k))
      end do
      gap = gaps(1)
      apart = place(2) - place(1)
      if (apart <= 0) return
      t = real(along - place(1), dp)/apart
      gap = gaps(1) + t*(gaps(2) - gaps(1))
      if (.not. is_quadratic) return
      k = merge(2, 1, mod(place(1), 2*apart) == 0) ! next to the middle of the cell, which is between two of its nodes
      third = sum(old%gap, mask=old%cut == number .and. old%along == 2*place(k) - place(3 - k))
      gap = max(gap - t*(1 - t)/2*(gaps(3 - k) - 2*gaps(k) + third), 0.0_dp)
   end subroutine take_over

   !> Lump the cells at pairs, and at other nodes that may touch something.
   subroutine lump_at_touch(c, others, grid, matrix)
      type(contact_t), intent(in) :: c
      integer, intent(in) :: others(:)
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(inout) :: matrix
      integer :: k
      if (.not. allocated(matrix%blend)) return
      associate (nodes => [(c%node(:, k), k=1, c%n), others])
         do k = 1, size(nodes)
            matrix%blend(matrix%cell_of(grid%dofs%elements_at(nodes(k)))) = 1
         end do
      end associate
   end subroutine lump_at_touch

   !> Let the sides of pressed pairs have one normal velocity, `v_n` or `v_mapped`.
   subroutine share_velocity(c, grid, f, which)
      type(contact_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: which
      call share_normal(c, grid, f%mass_matrix, f%velocity(:, :, which))
   end subroutine share_velocity

   !> Which pairs are pressed together.
   pure function pressed_pairs(c) result(pressed)
      type(contact_t), intent(in) :: c
      logical :: pressed(c%n)
      if (c%n > 0) pressed = c%touches
   end function pressed_pairs

   !> The forces with which the faces have to press on each other at each pair, for accelerations that they have without to become
   !> one where they touch [N]; 0 at the other pairs.
   pure function pressing_forces(c, matrix, acceleration) result(forces)
      type(contact_t), intent(in) :: c
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: acceleration(:, :) !! [m/s2], (ndim, n_points)
      real(dp) :: forces(c%n)
      real(dp), dimension(sides) :: force
      integer :: k
      do k = 1, c%n
         associate (i => c%node(:, k), a => acceleration(c%normal(k), c%node(:, k)))
            force = matrix%lumped(i)*(shared_values(c, k, matrix, a) - a)
         end associate
         forces(k) = force(1)
      end do
   end function pressing_forces

   !> Set the normal components of a nodal field at pressed pairs to their mean by lumped mass.
   subroutine share_normal(c, grid, matrix, field)
      type(contact_t), intent(in) :: c
      type(grid_t), intent(in) :: grid
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(inout), contiguous :: field(:, :)  !! (ndim, n_points)
      integer :: k
      do k = 1, c%n
         associate (i => c%node(:, k), d => c%normal(k))
            field(d, i) = shared_values(c, k, matrix, field(d, i))
         end associate
      end do
      if (any(c%touches)) call grid%dofs%distribute(matrix%all, ndim, field)
   end subroutine share_normal

   !> The values at a pair; where it is pressed, their mean by lumped mass.
   pure function shared_values(c, k, matrix, values) result(shared)
      type(contact_t), intent(in) :: c
      integer, intent(in) :: k                   !! the pair
      type(mass_matrix_t), intent(in) :: matrix
      real(dp), intent(in) :: values(sides)
      real(dp) :: shared(sides)
      shared = values
      associate (m => matrix%lumped(c%node(:, k)))
         if (c%touches(k) .and. all(m > 0)) shared = sum(m*values)/sum(m)
      end associate
   end function shared_values

   !> Keep the faces from going through each other: follow the gaps over a step, and change accelerations and new velocities of the
   !> pairs that would overlap, by more than rounding of their own motion.
   subroutine keep_apart(c, grid, dt, f)
      type(contact_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: dt                 !! [s]
      type(nodal_fields_t), intent(inout) :: f
      real(dp), parameter :: rounding = 1e-12_dp
      real(dp), dimension(sides) :: w, change
      real(dp) :: gap
      integer :: k
      do k = 1, c%n
         associate (i => c%node(:, k), d => c%normal(k))
            c%touches(k) = .false.
            associate (m => f%mass_matrix%lumped(i))
               if (.not. all(m > 0)) cycle
               w = f%velocity(d, i, v_next)
               gap = c%gap(k) + dt*(w(1) - w(2))
               if (gap < -rounding*dt*sum(abs(w))) then
                  change = (sum(m*w) - [m(2), -m(1)]*(c%gap(k)/dt))/sum(m) - w
                  c%touches(k) = .true.
                  f%velocity(d, i, v_next) = w + change
                  f%acceleration(d, i) = f%acceleration(d, i) + change/dt
               end if
               c%gap(k) = max(gap, 0.0_dp)
            end associate
         end associate
      end do
      if (.not. any(c%touches)) return
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%acceleration)
      call grid%dofs%distribute(f%mass_matrix%all, ndim, f%velocity(:, :, v_next))
   end subroutine keep_apart

   !> Keep the gaps of faces that may touch.
   subroutine keep_contact(contact, archive)
      type(contact_t), intent(inout) :: contact
      class(archive_t), intent(inout) :: archive
      integer :: n
      n = contact%n
      call archive%section('contact')
      call archive%keep('pairs', n)
      if (n /= contact%n) call archive%refuse('it has '//to_text(n)//' pairs of nodes on faces, the grid has '//to_text(contact%n))
      if (n == 0 .or. archive%failure%failed()) return
      call archive%keep_reals('gap', size(contact%gap), contact%gap)
      call archive%keep_logicals('touches', size(contact%touches), contact%touches)
   end subroutine keep_contact
end module hampm_contact
