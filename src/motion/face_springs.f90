!> Springs between the two sides of cracks that cut cells (`hampm_cut_cells`): bonds, and contact. Where they are is found by
!> `hampm_spring_placement`.
!>
!> Bonds: a cell in which a crack ends is cut as a whole, and what of its cut lies ahead of the tip is held together by a layer of
!> springs. So the crack of the cells grows with that of the scene, and not by whole cells.
!>
!> Ahead of a tip that grows in motion more than one cell may be cut. A bond there begins with the traction that the material had, holds
!> on as a spring, and lets go when the tip has come to it; how its force then falls is `hampm_bond_release`'s matter.
!>
!> On a symmetry plane there is one face, and what it is bonded to is its mirror image: the opening g of such a half bond is the
!> displacement of the face, half of that of the whole crack, only its part normal to the plane has a force, and its energy is that
!> of the half.
!>
!> Contact: where the faces would go through each other springs push them apart, and with friction they hold them along the face, up
!> to the coefficient times the pressure; what is beyond slides (return mapping). The overlap that presses is the compliance of the
!> layer, that of a third of a cell. While equilibrium is looked for what friction can hold may be given (`hold_friction`): then forces
!> have a convex potential.
!>
!> The springs act at points along the crack. The opening at a point is what the shape functions there make of the displacements of
!> the nodes of both sides,
!>
!>    g = sum over nodes of c_j u_j,   force on node j   -c_j f(g),
!>
!> and follows these in every step, in the total frame.
!>
!> Springs that hold the nodes of small pieces of quadratic cells (`hampm_small_pieces`) may have a mass m too, which moves with the rate w
!> of their opening as particles do with the velocity: it gives m c_j w to the momentum of node j, and w gains c.a dt.
!>
!> Source: Wriggers, Computational Contact Mechanics (2006), sections 5.2 (penalty) and 10.5 (return mapping of friction).
module hampm_face_springs
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_mass_ties, only: mass_ties_t
   use hampm_text, only: to_text
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: face_springs_t, spring_t, bond, contact, along, add_spring_forces, stretch_springs, open_springs, settle_slip, &
             spring_energy, &
             spring_states, spring_stiffness, force_of, face_force, overlap_of, energy_of, relax_springs, look_at_faces, &
             is_pressed, &
             have_friction, hold_friction, keep_springs, add_spring, is_half, &
             mass_ties_of, add_spring_momentum, kick_springs, energy_of_rates, add_spring_resistance

   integer, parameter :: bond = 1, contact = 2   !! what a spring is for
   integer, parameter :: is_open = 0, sticks = 1, slides = 2 !! what it does
   integer, parameter :: sticks_apart = 3        !! and as long as what friction holds is given: faces that have parted are held along

   !> A spring.
   type :: spring_t
      integer :: kind = bond                     !! or `contact`
      integer :: node(2*most_nodes_of_leaf) = 0  !! whose displacement matters, 0 behind the last
      integer :: n_left = 0                      !! how many of them are those of the left face, which come first
      real(dp) :: share(2*most_nodes_of_leaf) = 0 !! c_j [-]
      real(dp) :: stiffness = 0                  !! s [N/m]
      real(dp) :: place(ndim) = 0                !! on the line [m]
      real(dp) :: length = 0                     !! of the line that it stands for [m]
      real(dp) :: normal(ndim) = [1, 0]          !! from the right to the left face
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: opening(ndim) = 0              !! g, of the left face from the right one [m]
      real(dp) :: touch = -huge(1.0_dp)          !! opening across the faces below which they press on each other [m]
      real(dp) :: slip = 0                       !! sliding at which they hold each other without a force along them [m]
      real(dp) :: pressed = 0                    !! by how much the faces overlapped after the last step [m]
      real(dp) :: most_held = -1                 !! what friction holds at most, over the stiffness; below 0 where that follows the
                                                 !! pressure [m]
      integer :: line = 0                        !! number of the crack whose faces may touch there, 0 for none
      integer :: tip = 0                         !! number of the tip that moves over a bond, 0 for none
      real(dp) :: way = 0                        !! of that tip from where it was at first to the bond [m]
      real(dp) :: cell = 0                       !! size of the cell there [m]
      real(dp) :: held(ndim) = 0                 !! force of a bond at the opening `start` [N]
      real(dp) :: start(ndim) = 0                !! [m]
      logical :: lets_go = .false.               !! whether a bond has begun to let go: its force is then `kept` of `held`, and that of faces that touch
      real(dp) :: kept = 1                       !! [-]
      real(dp) :: reached = 0                    !! largest opening since then along the force, of law = toughness [m]
      real(dp) :: mass = 0                       !! m [kg]
      real(dp) :: rate(ndim) = 0                 !! w [m/s]
      real(dp) :: stored = 0                     !! energy of a bond at the opening `start`, or that it had when it began to let go [J]
   end type spring_t

   !> All springs.
   type :: face_springs_t
      type(thickness_t) :: thickness             !! of the material
      logical :: are_bounded = .true.            !! whether explicit steps have to be stable
      real(dp) :: most = 0                       !! largest eigenvalue that the steps of the run leave them then, over (c/h)**2 [-]
      real(dp) :: wanted = 0                     !! the one that they would have with all of their stiffness, the same [-]
      real(dp) :: weakest = 1                    !! part of its stiffness that the weakest bond has [-]
      real(dp) :: weakest_contact = 1            !! and the weakest spring for contact [-]
      logical :: are_moving = .true.             !! whether they have masses, where they may
      integer :: alone = 0                       !! first element of a piece too small to move with no fuller one beside it, 0
                                                 !! for none
      integer :: n = 0                           !! number of springs
      integer :: n_contact = 0                   !! of which are for contact
      real(dp) :: caution = 0                    !! part of the stiffness that the tangent of faces has at least, whatever they do [-]
      real(dp) :: loss = 0                       !! energy taken by friction [J]
      type(spring_t), allocatable :: list(:)     !! (n at least)
   end type face_springs_t

contains

   !> Unit vector along the line of a spring.
   pure function along(spring) result(t)
      type(spring_t), intent(in) :: spring
      real(dp) :: t(ndim)
      t = [spring%normal(2), -spring%normal(1)]
   end function along

   !> Whether a bond is one to the mirror image of a face: the nodes of the other face are missing.
   pure logical function is_half(spring)
      type(spring_t), intent(in) :: spring
      is_half = spring%n_left == 0 .or. spring%node(spring%n_left + 1) == 0
   end function is_half

   !> How far a bond has been stretched since it began [m].
   pure function stretch_of(spring) result(stretch)
      type(spring_t), intent(in) :: spring
      real(dp) :: stretch(ndim)
      stretch = spring%opening - spring%start
      if (is_half(spring)) stretch = dot_product(stretch, spring%normal)*spring%normal
   end function stretch_of

   !> Whether a spring is one of faces that are free to part.
   pure logical function is_free(spring)
      type(spring_t), intent(in) :: spring
      is_free = spring%kind == contact .or. spring%lets_go
   end function is_free

   !> What a spring does.
   pure integer function state_of(spring) result(state)
      type(spring_t), intent(in) :: spring
      logical :: holds
      state = sticks
      if (.not. is_free(spring)) return
      holds = spring%friction > 0
      if (holds) holds = abs(sliding_of(spring)) <= limit_of(spring)
      if (.not. holds) state = slides
      if (overlap_of(spring) < 0) state = merge(sticks_apart, is_open, holds .and. spring%most_held >= 0)
   end function state_of

   !> By how much faces overlap; below 0 where they have parted [m].
   pure real(dp) function overlap_of(spring) result(overlap)
      type(spring_t), intent(in) :: spring
      overlap = spring%touch - dot_product(spring%normal, spring%opening)
   end function overlap_of

   !> How far faces have slid from where they would hold each other without a force along them [m].
   pure real(dp) function sliding_of(spring) result(sliding)
      type(spring_t), intent(in) :: spring
      sliding = dot_product(along(spring), spring%opening) - spring%slip
   end function sliding_of

   !> What friction holds at most, over the stiffness [m].
   pure real(dp) function limit_of(spring) result(limit)
      type(spring_t), intent(in) :: spring
      limit = spring%friction*max(overlap_of(spring), 0.0_dp)
      if (spring%most_held >= 0) limit = spring%most_held
   end function limit_of

   !> Force by which faces that touch resist to be parted [N].
   pure function face_force(spring) result(force)
      type(spring_t), intent(in) :: spring
      real(dp) :: force(ndim), sliding
      sliding = sliding_of(spring)
      force = spring%stiffness*(sign(min(limit_of(spring), abs(sliding)), sliding)*along(spring) &
                                - max(overlap_of(spring), 0.0_dp)*spring%normal)
   end function face_force

   !> Let friction hold no more than what follows from the present pressure, whatever that becomes.
   pure subroutine hold_friction(springs)
      type(face_springs_t), intent(inout) :: springs
      integer :: k
      do k = 1, springs%n
         associate (spring => springs%list(k))
            spring%most_held = spring%friction*max(0.0_dp, overlap_of(spring))
         end associate
      end do
   end subroutine hold_friction

   !> Whether there is friction.
   pure logical function have_friction(springs)
      type(face_springs_t), intent(in) :: springs
      have_friction = springs%n_contact > 0
      if (have_friction) have_friction = any(springs%list(:springs%n)%friction > 0)
   end function have_friction

   !> What all springs do: a matrix that was factorised fits as long as this stays.
   pure function spring_states(springs) result(states)
      type(face_springs_t), intent(in) :: springs
      integer :: states(springs%n), k
      states = [(state_of(springs%list(k)), k=1, springs%n)]
   end function spring_states

   !> Force by which a spring resists its opening [N].
   pure function force_of(spring) result(force)
      type(spring_t), intent(in) :: spring
      real(dp) :: force(ndim)
      if (.not. is_free(spring)) then
         force = spring%held + spring%stiffness*stretch_of(spring)
      else
         force = face_force(spring)
         if (spring%lets_go) force = force + spring%kept*spring%held
      end if
   end function force_of

   !> What a spring of contact tells of the faces there: the force by which they resist being parted, and the change of their opening
   !> along a direction, by that at its neighbours. `is_there` is false for bonds and where faces have parted.
   pure subroutine look_at_faces(springs, k, direction, force, slope, is_there)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp), intent(in) :: direction(ndim)    !! unit vector
      real(dp), intent(out) :: force(ndim)       !! [N]
      real(dp), intent(out) :: slope(ndim)       !! [-]
      logical, intent(out) :: is_there
      integer :: before, after
      real(dp) :: way
      force = 0
      slope = 0
      is_there = is_free(springs%list(k))
      if (is_there) is_there = state_of(springs%list(k)) /= is_open
      if (.not. is_there) return
      force = face_force(springs%list(k))
      before = merge(k - 1, k, is_next(max(k - 1, 1)))
      after = merge(k + 1, k, is_next(min(k + 1, springs%n)))
      way = dot_product(springs%list(after)%place - springs%list(before)%place, direction)
      if (abs(way) > 0) slope = (springs%list(after)%opening - springs%list(before)%opening)/way

   contains

      !> Whether another spring is one of the same crack, on the same straight part of it.
      pure logical function is_next(other)
         integer, intent(in) :: other
         is_next = other /= k .and. is_free(springs%list(other)) .and. springs%list(other)%line == springs%list(k)%line &
                   .and. norm2(springs%list(other)%normal - springs%list(k)%normal) <= 1e-6_dp
      end function is_next
   end subroutine look_at_faces

   !> Whether a spring is for contact and its faces press on each other.
   pure logical function is_pressed(spring)
      type(spring_t), intent(in) :: spring
      is_pressed = spring%kind == contact
      if (is_pressed) is_pressed = state_of(spring) /= is_open
   end function is_pressed

   !> Change of that force with the opening, without what friction changes with the pressure, which is not symmetric [N/m].
   pure function spring_stiffness(spring, caution) result(tangent)
      type(spring_t), intent(in) :: spring
      real(dp) :: tangent(ndim, ndim)
      real(dp) :: of_normal, of_tangent          ! parts of the stiffness
      real(dp), intent(in) :: caution            !! see `face_springs_t`
      integer :: i, j, state
      tangent = 0
      state = state_of(spring)
      if (spring%lets_go .and. state == is_open) return
      of_normal = merge(1.0_dp, caution, state == sticks .or. state == slides)
      of_tangent = merge(1.0_dp, caution, state == sticks .or. state == sticks_apart)
      if (is_half(spring)) of_tangent = 0
      associate (n => spring%normal, t => along(spring), s => spring%stiffness)
         do j = 1, ndim
            do i = 1, ndim
               tangent(i, j) = s*(of_normal*n(i)*n(j) + of_tangent*t(i)*t(j))
            end do
         end do
      end associate
   end function spring_stiffness

   !> Add the forces of the springs on the nodes [N].
   pure subroutine add_spring_forces(springs, force)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(inout) :: force(:, :)     !! (ndim, n_points)
      integer :: k
      do k = 1, springs%n
         call give_nodes(springs%list(k), -force_of(springs%list(k)), force)
      end do
   end subroutine add_spring_forces

   !> Give the nodes of a spring their shares of something.
   pure subroutine give_nodes(spring, what, field)
      type(spring_t), intent(in) :: spring
      real(dp), intent(in) :: what(ndim)
      real(dp), intent(inout) :: field(:, :)     !! (ndim, n_points)
      integer :: j
      do j = 1, count(spring%node > 0)
         field(:, spring%node(j)) = field(:, spring%node(j)) + spring%share(j)*what
      end do
   end subroutine give_nodes

   !> Add the forces by which springs, as they are, resist a small displacement of the nodes [N].
   pure subroutine add_spring_resistance(springs, u, force)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, n_points)
      real(dp), intent(inout) :: force(:, :)     !! (ndim, n_points)
      integer :: k
      do k = 1, springs%n
         associate (spring => springs%list(k))
            call give_nodes(spring, matmul(spring_stiffness(spring, springs%caution), opening_by(spring, u)), force)
         end associate
      end do
   end subroutine add_spring_resistance

   !> What opens a spring of a field of the nodes.
   pure function opening_by(spring, field) result(opening)
      type(spring_t), intent(in) :: spring
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp) :: opening(ndim)
      integer :: j
      opening = 0
      do j = 1, count(spring%node > 0)
         opening = opening + spring%share(j)*field(:, spring%node(j))
      end do
   end function opening_by

   !> Let the openings follow a displacement of the nodes, `scale` times a field.
   pure subroutine stretch_springs(springs, field, scale)
      type(face_springs_t), intent(inout) :: springs
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp), intent(in) :: scale
      integer :: k
      do k = 1, springs%n
         springs%list(k)%opening = springs%list(k)%opening + scale*opening_by(springs%list(k), field)
      end do
   end subroutine stretch_springs

   !> Open the bonds that no tip lets go as far as a displacement of the nodes since the start does. Those that are new on a mesh do not begin with what
   !> the field bears there, and of two at one place, on pieces of either side of a crack, each has its own.
   pure subroutine open_springs(springs, displacement)
      type(face_springs_t), intent(inout) :: springs
      real(dp), intent(in) :: displacement(:, :) !! [m], (ndim, n_points)
      integer :: k
      do k = 1, springs%n
         associate (spring => springs%list(k))
            if (spring%kind == bond .and. spring%tip == 0) spring%opening = opening_by(spring, displacement)
         end associate
      end do
   end subroutine open_springs

   !> The masses of springs, as those that a mass matrix has beside the particles.
   pure function mass_ties_of(springs) result(ties)
      type(face_springs_t), intent(in) :: springs
      type(mass_ties_t) :: ties
      integer :: k
      if (springs%n > 0) ties%n = count(springs%list(:springs%n)%mass > 0)
      if (ties%n == 0) return
      allocate (ties%node(2*most_nodes_of_leaf, ties%n), ties%share(2*most_nodes_of_leaf, ties%n))
      ties%mass = pack(springs%list(:springs%n)%mass, springs%list(:springs%n)%mass > 0)
      ties%n = 0
      do k = 1, springs%n
         if (.not. springs%list(k)%mass > 0) cycle
         ties%n = ties%n + 1
         ties%node(:, ties%n) = springs%list(k)%node
         ties%share(:, ties%n) = springs%list(k)%share
      end do
   end function mass_ties_of

   !> Add the momentum of the springs at the nodes [kg m/s].
   pure subroutine add_spring_momentum(springs, momentum)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(inout) :: momentum(:, :)  !! (ndim, n_points)
      integer :: k
      do k = 1, springs%n
         associate (spring => springs%list(k))
            if (spring%mass > 0) call give_nodes(spring, spring%mass*spring%rate, momentum)
         end associate
      end do
   end subroutine add_spring_momentum

   !> Let the masses of springs follow an acceleration of the nodes. `energy` is the sum of m |dw|**2/2 [J].
   pure subroutine kick_springs(springs, acceleration, dt, energy)
      type(face_springs_t), intent(inout) :: springs
      real(dp), intent(in) :: acceleration(:, :) !! [m/s2], (ndim, n_points)
      real(dp), intent(in) :: dt                 !! [s]
      real(dp), intent(out) :: energy
      real(dp) :: gain(ndim)
      integer :: k
      energy = 0
      do k = 1, springs%n
         if (.not. springs%list(k)%mass > 0) cycle
         gain = dt*opening_by(springs%list(k), acceleration)
         springs%list(k)%rate = springs%list(k)%rate + gain
         energy = energy + springs%list(k)%mass*sum(gain**2)/2
      end do
   end subroutine kick_springs

   !> Kinetic energy of the masses of springs [J].
   pure real(dp) function energy_of_rates(springs) result(energy)
      type(face_springs_t), intent(in) :: springs
      integer :: k
      energy = sum([(springs%list(k)%mass*sum(springs%list(k)%rate**2)/2, k=1, springs%n)])
   end function energy_of_rates

   !> Let all be as before any load.
   pure subroutine relax_springs(springs)
      type(face_springs_t), intent(inout) :: springs
      integer :: k
      if (springs%n == 0) return
      do k = 1, springs%n
         springs%list(k)%opening = 0
         springs%list(k)%slip = 0
         springs%list(k)%pressed = 0
      end do
      springs%loss = 0
   end subroutine relax_springs

   !> After a step: what has slid stays so, under the mean of the friction at both ends of the step, and open faces hold each other
   !> where they will meet.
   pure subroutine settle_slip(springs)
      type(face_springs_t), intent(inout) :: springs
      real(dp) :: sliding, pressed
      integer :: k
      if (springs%n_contact == 0) return
      do k = 1, springs%n
         associate (spring => springs%list(k))
            if (.not. is_free(spring)) cycle
            sliding = sliding_of(spring)
            pressed = max(0.0_dp, overlap_of(spring))
            select case (state_of(spring))
             case (is_open)
               spring%slip = dot_product(along(spring), spring%opening)
             case (slides)
               sliding = sliding - sign(spring%friction*pressed, sliding)
               springs%loss = springs%loss + spring%stiffness*spring%friction*(spring%pressed + pressed)/2*abs(sliding)
               spring%slip = spring%slip + sliding
            end select
            spring%pressed = pressed
         end associate
      end do
   end subroutine settle_slip

   !> Energy that the springs store [J].
   pure real(dp) function spring_energy(springs) result(energy)
      type(face_springs_t), intent(in) :: springs
      integer :: k
      energy = sum([(energy_of(springs%list(k)), k=1, springs%n)])
   end function spring_energy

   !> Energy that a spring stores [J]: that of a bond since it began. One that has begun to let go stores none but that of faces that press on each other,
   !> what it takes is lost.
   pure real(dp) function energy_of(spring) result(energy)
      type(spring_t), intent(in) :: spring
      associate (stretch => stretch_of(spring), s => spring%stiffness)
         if (is_free(spring)) then
            energy = sum(face_force(spring)**2)/(2*s)
         else
            energy = spring%stored + dot_product(spring%held, stretch) + s*sum(stretch**2)/2
         end if
      end associate
   end function energy_of

   !> Add a spring that nothing has stretched, without nodes.
   pure subroutine add_spring(springs, kind)
      type(face_springs_t), intent(inout) :: springs
      integer, intent(in) :: kind
      type(spring_t), allocatable :: more(:)
      if (.not. allocated(springs%list)) allocate (springs%list(64))
      if (springs%n == size(springs%list)) then
         allocate (more(2*springs%n))
         more(:springs%n) = springs%list
         call move_alloc(more, springs%list)
      end if
      springs%n = springs%n + 1
      springs%list(springs%n) = spring_t(kind=kind)
      if (kind /= contact) return
      springs%list(springs%n)%touch = 0
      springs%n_contact = springs%n_contact + 1
   end subroutine add_spring

   !> Keep springs: in the updated frame they are where faces were when cells were cut last, and what they remember.
   subroutine keep_springs(springs, archive)
      type(face_springs_t), intent(inout) :: springs
      class(archive_t), intent(inout) :: archive
      integer :: n, j, d
      n = springs%n
      call archive%section('face_springs')
      call archive%keep('number', n)
      if (n == 0 .or. archive%failure%failed()) return
      if (archive%is_read) then
         springs%n = n
         if (allocated(springs%list)) deallocate (springs%list)
         allocate (springs%list(max(n, 64)))
      end if
      call archive%keep('n_contact', springs%n_contact)
      call archive%keep('loss', springs%loss)
      associate (of => springs%list(:n))
         call archive%keep_integers('kind', n, of%kind)
         call archive%keep_integers('n_left', n, of%n_left)
         do j = 1, 2*most_nodes_of_leaf
            call archive%keep_integers('node_'//to_text(j), n, of%node(j))
            call archive%keep_reals('share_'//to_text(j), n, of%share(j))
         end do
         do d = 1, ndim
            call archive%keep_reals('place_'//to_text(d), n, of%place(d))
            call archive%keep_reals('normal_'//to_text(d), n, of%normal(d))
            call archive%keep_reals('opening_'//to_text(d), n, of%opening(d))
            call archive%keep_reals('held_'//to_text(d), n, of%held(d))
            call archive%keep_reals('start_'//to_text(d), n, of%start(d))
            call archive%keep_reals('rate_'//to_text(d), n, of%rate(d))
         end do
         call archive%keep_reals('stiffness', n, of%stiffness)
         call archive%keep_reals('length', n, of%length)
         call archive%keep_reals('friction', n, of%friction)
         call archive%keep_reals('pressed', n, of%pressed)
         call archive%keep_integers('line', n, of%line)
         call archive%keep_integers('tip', n, of%tip)
         call archive%keep_reals('way', n, of%way)
         call archive%keep_reals('cell', n, of%cell)
         call archive%keep_logicals('lets_go', n, of%lets_go)
         call archive%keep_reals('kept', n, of%kept)
         call archive%keep_reals('touch', n, of%touch)
         call archive%keep_reals('slip', n, of%slip)
         call archive%keep_reals('reached', n, of%reached)
         call archive%keep_reals('stored', n, of%stored)
         call archive%keep_reals('mass', n, of%mass)
      end associate
   end subroutine keep_springs
end module hampm_face_springs
