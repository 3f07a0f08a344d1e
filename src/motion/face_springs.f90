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
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: face_springs_t, bond, contact, along, add_spring_forces, stretch_springs, settle_slip, spring_energy, spring_states, &
             spring_stiffness, force_of, energy_of, relax_springs, look_at_faces, is_pressed, &
             have_friction, hold_friction, free_friction, keep_springs, make_room, add_spring, is_half, have_mass, &
             mass_ties_of, add_spring_momentum, kick_springs, energy_of_rates, add_spring_resistance

   integer, parameter :: bond = 1, contact = 2   !! what a spring is for
   integer, parameter :: is_open = 0, sticks = 1, slides = 2 !! what it does
   integer, parameter :: sticks_apart = 3        !! and as long as what friction holds is given: faces that have parted are held along

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
      integer, allocatable :: kind(:)            !! `bond` or `contact`
      integer, allocatable :: node(:, :)         !! whose displacement matters, 0 behind the last; (2 most_nodes_of_leaf, n)
      integer, allocatable :: n_left(:)          !! how many of them are those of the left face, which come first; (n)
      real(dp), allocatable :: share(:, :)       !! c_j [-]
      real(dp), allocatable :: stiffness(:)      !! s [N/m]
      real(dp), allocatable :: place(:, :)       !! on the line [m], (ndim, n)
      real(dp), allocatable :: length(:)         !! of the line that each stands for [m]
      real(dp), allocatable :: normal(:, :)      !! from the right to the left face, (ndim, n)
      real(dp), allocatable :: friction(:)       !! coefficient [-]
      real(dp), allocatable :: opening(:, :)     !! g, of the left face from the right one [m], (ndim, n)
      real(dp), allocatable :: slip(:)           !! sliding at which the faces hold each other without a force along them [m]
      real(dp), allocatable :: pressed(:)        !! by how much the faces overlapped after the last step [m]
      real(dp) :: caution = 0                    !! part of the stiffness that the tangent of faces has at least, whatever they do [-]
      real(dp), allocatable :: most_held(:)      !! what friction holds at most, over the stiffness; not allocated where that follows
                                                 !! the pressure [m]
      integer, allocatable :: line(:)            !! number of the crack whose faces may touch there, 0 for bonds
      integer, allocatable :: tip(:)             !! number of the tip that moves over a bond, 0 for none
      real(dp), allocatable :: way(:)            !! of that tip from where it was at first to the bond [m]
      real(dp), allocatable :: cell(:)           !! size of the cell there [m]
      real(dp), allocatable :: held(:, :)        !! force of a bond at the opening `start` [N], (ndim, n)
      real(dp), allocatable :: start(:, :)       !! [m], (ndim, n)
      logical, allocatable :: lets_go(:)         !! whether a bond has begun to let go: its force is then `kept` of `held`
      real(dp), allocatable :: kept(:)           !! [-]
      real(dp), allocatable :: reached(:)        !! largest opening since then along the force, of law = toughness [m]
      real(dp), allocatable :: mass(:)           !! m [kg]
      real(dp), allocatable :: rate(:, :)        !! w [m/s], (ndim, n)
      real(dp), allocatable :: stored(:)         !! energy of a bond at the opening `start`, or that it had when it began to let go [J]
      real(dp) :: loss = 0                       !! energy taken by friction [J]
   end type face_springs_t

contains

   !> Unit vector along the line of a spring.
   pure function along(springs, k) result(t)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp) :: t(ndim)
      t = [springs%normal(2, k), -springs%normal(1, k)]
   end function along

   !> Whether a bond is one to the mirror image of a face: the nodes of the other face are missing.
   pure logical function is_half(springs, k)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      is_half = springs%n_left(k) == 0 .or. springs%node(springs%n_left(k) + 1, k) == 0
   end function is_half

   !> How far a bond has been stretched since it began [m].
   pure function stretch_of(springs, k) result(stretch)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp) :: stretch(ndim)
      stretch = springs%opening(:, k) - springs%start(:, k)
      if (is_half(springs, k)) stretch = dot_product(stretch, springs%normal(:, k))*springs%normal(:, k)
   end function stretch_of

   !> What a spring does.
   pure integer function state_of(springs, k) result(state)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp) :: pressed
      logical :: holds
      state = sticks
      if (springs%kind(k) == bond) return
      pressed = -dot_product(springs%normal(:, k), springs%opening(:, k))
      holds = springs%friction(k) > 0
      if (holds) holds = abs(dot_product(along(springs, k), springs%opening(:, k)) - springs%slip(k)) &
                         <= limit_of(springs, k, pressed)
      if (.not. holds) state = slides
      if (pressed < 0) state = merge(sticks_apart, is_open, holds .and. allocated(springs%most_held))
   end function state_of

   !> What friction holds at most, over the stiffness [m].
   pure real(dp) function limit_of(springs, k, pressed) result(limit)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp), intent(in) :: pressed            !! overlap [m]
      limit = springs%friction(k)*max(pressed, 0.0_dp)
      if (allocated(springs%most_held)) limit = springs%most_held(k)
   end function limit_of

   !> Let friction hold no more than what follows from the present pressure, whatever that becomes.
   pure subroutine hold_friction(springs)
      type(face_springs_t), intent(inout) :: springs
      integer :: k
      springs%most_held = [(springs%friction(k)*max(0.0_dp, -dot_product(springs%normal(:, k), springs%opening(:, k))), &
                            k=1, springs%n)]
   end subroutine hold_friction

   !> Let what friction holds follow the pressure.
   pure subroutine free_friction(springs)
      type(face_springs_t), intent(inout) :: springs
      if (allocated(springs%most_held)) deallocate (springs%most_held)
   end subroutine free_friction

   !> Whether there is friction.
   pure logical function have_friction(springs)
      type(face_springs_t), intent(in) :: springs
      have_friction = springs%n_contact > 0
      if (have_friction) have_friction = any(springs%friction(:springs%n) > 0)
   end function have_friction

   !> What all springs do: a matrix that was factorised fits as long as this stays.
   pure function spring_states(springs) result(states)
      type(face_springs_t), intent(in) :: springs
      integer :: states(springs%n)
      integer :: k
      do k = 1, springs%n
         states(k) = state_of(springs, k)
      end do
   end function spring_states

   !> Force by which a spring resists its opening [N].
   pure function force_of(springs, k) result(force)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp) :: force(ndim)
      real(dp) :: across, sliding
      associate (g => springs%opening(:, k), n => springs%normal(:, k), s => springs%stiffness(k))
         if (springs%kind(k) == bond) then
            force = springs%held(:, k) + s*stretch_of(springs, k)
            if (springs%lets_go(k)) force = springs%kept(k)*springs%held(:, k)
            return
         end if
         across = dot_product(n, g)
         sliding = dot_product(along(springs, k), g) - springs%slip(k)
         force = s*(min(across, 0.0_dp)*n + sign(min(limit_of(springs, k, -across), abs(sliding)), sliding)*along(springs, k))
      end associate
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
      is_there = springs%kind(k) == contact
      if (is_there) is_there = state_of(springs, k) /= is_open
      if (.not. is_there) return
      force = force_of(springs, k)
      before = merge(k - 1, k, is_next(max(k - 1, 1)))
      after = merge(k + 1, k, is_next(min(k + 1, springs%n)))
      way = dot_product(springs%place(:, after) - springs%place(:, before), direction)
      if (abs(way) > 0) slope = (springs%opening(:, after) - springs%opening(:, before))/way

   contains

      !> Whether another spring is one of the same crack, on the same straight part of it.
      pure logical function is_next(other)
         integer, intent(in) :: other
         is_next = other /= k .and. springs%kind(other) == contact .and. springs%line(other) == springs%line(k) &
                   .and. norm2(springs%normal(:, other) - springs%normal(:, k)) <= 1e-6_dp
      end function is_next
   end subroutine look_at_faces

   !> Whether a spring is for contact and its faces press on each other.
   pure logical function is_pressed(springs, k)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      is_pressed = springs%kind(k) == contact
      if (is_pressed) is_pressed = state_of(springs, k) /= is_open
   end function is_pressed

   !> Change of that force with the opening, without what friction changes with the pressure, which is not symmetric [N/m].
   pure function spring_stiffness(springs, k) result(tangent)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp) :: tangent(ndim, ndim)
      real(dp) :: of_normal, of_tangent          ! parts of the stiffness
      integer :: i, j, state
      tangent = 0
      if (springs%lets_go(k)) return
      state = state_of(springs, k)
      of_normal = merge(1.0_dp, springs%caution, state == sticks .or. state == slides)
      of_tangent = merge(1.0_dp, springs%caution, state == sticks .or. state == sticks_apart)
      if (is_half(springs, k)) of_tangent = 0
      associate (n => springs%normal(:, k), t => along(springs, k), s => springs%stiffness(k))
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
      real(dp) :: f(ndim)
      integer :: k, j
      do k = 1, springs%n
         f = force_of(springs, k)
         do j = 1, size(springs%node, 1)
            associate (node => springs%node(j, k))
               if (node > 0) force(:, node) = force(:, node) - springs%share(j, k)*f
            end associate
         end do
      end do
   end subroutine add_spring_forces

   !> Add the forces by which springs, as they are, resist a small displacement of the nodes [N].
   pure subroutine add_spring_resistance(springs, u, force)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, n_points)
      real(dp), intent(inout) :: force(:, :)     !! (ndim, n_points)
      real(dp) :: f(ndim)
      integer :: k, j
      do k = 1, springs%n
         f = matmul(spring_stiffness(springs, k), opening_by(springs, k, u))
         do j = 1, count(springs%node(:, k) > 0)
            associate (of_node => force(:, springs%node(j, k)))
               of_node = of_node + springs%share(j, k)*f
            end associate
         end do
      end do
   end subroutine add_spring_resistance

   !> What opens a spring of a field of the nodes.
   pure function opening_by(springs, k, field) result(opening)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp) :: opening(ndim)
      integer :: j
      opening = 0
      do j = 1, count(springs%node(:, k) > 0)
         opening = opening + springs%share(j, k)*field(:, springs%node(j, k))
      end do
   end function opening_by

   !> Let the openings follow a displacement of the nodes, `scale` times a field.
   pure subroutine stretch_springs(springs, field, scale)
      type(face_springs_t), intent(inout) :: springs
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp), intent(in) :: scale
      integer :: k, j
      do k = 1, springs%n
         do j = 1, size(springs%node, 1)
            associate (node => springs%node(j, k))
               if (node > 0) springs%opening(:, k) = springs%opening(:, k) + scale*springs%share(j, k)*field(:, node)
            end associate
         end do
      end do
   end subroutine stretch_springs

   !> Whether springs have a mass.
   pure logical function have_mass(springs)
      type(face_springs_t), intent(in) :: springs
      have_mass = springs%n > 0
      if (have_mass) have_mass = any(springs%mass(:springs%n) > 0)
   end function have_mass

   !> The masses of springs, as those that a mass matrix has beside the particles.
   pure function mass_ties_of(springs) result(ties)
      type(face_springs_t), intent(in) :: springs
      type(mass_ties_t) :: ties
      integer, allocatable :: with(:)
      integer :: k
      if (.not. have_mass(springs)) return
      with = pack([(k, k=1, springs%n)], springs%mass(:springs%n) > 0)
      ties%n = size(with)
      ties%node = springs%node(:, with)
      ties%share = springs%share(:, with)
      ties%mass = springs%mass(with)
   end function mass_ties_of

   !> Add the momentum of the springs at the nodes [kg m/s].
   pure subroutine add_spring_momentum(springs, momentum)
      type(face_springs_t), intent(in) :: springs
      real(dp), intent(inout) :: momentum(:, :)  !! (ndim, n_points)
      integer :: k, j
      do k = 1, springs%n
         if (.not. springs%mass(k) > 0) cycle
         do j = 1, count(springs%node(:, k) > 0)
            associate (of_node => momentum(:, springs%node(j, k)))
               of_node = of_node + springs%mass(k)*springs%share(j, k)*springs%rate(:, k)
            end associate
         end do
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
         if (.not. springs%mass(k) > 0) cycle
         gain = dt*opening_by(springs, k, acceleration)
         springs%rate(:, k) = springs%rate(:, k) + gain
         energy = energy + springs%mass(k)*sum(gain**2)/2
      end do
   end subroutine kick_springs

   !> Kinetic energy of the masses of springs [J].
   pure real(dp) function energy_of_rates(springs) result(energy)
      type(face_springs_t), intent(in) :: springs
      integer :: k
      energy = 0
      do k = 1, springs%n
         if (springs%mass(k) > 0) energy = energy + springs%mass(k)*sum(springs%rate(:, k)**2)/2
      end do
   end function energy_of_rates

   !> Let all be as before any load.
   pure subroutine relax_springs(springs)
      type(face_springs_t), intent(inout) :: springs
      if (springs%n == 0) return
      springs%opening = 0
      springs%slip = 0
      springs%pressed = 0
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
         if (springs%kind(k) == bond) cycle
         associate (g => springs%opening(:, k), t => along(springs, k))
            pressed = max(0.0_dp, -dot_product(springs%normal(:, k), g))
            select case (state_of(springs, k))
             case (is_open)
               springs%slip(k) = dot_product(t, g)
             case (slides)
               sliding = dot_product(t, g) - springs%slip(k)
               sliding = sliding - sign(springs%friction(k)*pressed, sliding)
               springs%loss = springs%loss + springs%stiffness(k)*springs%friction(k)*(springs%pressed(k) + pressed)/2*abs(sliding)
               springs%slip(k) = springs%slip(k) + sliding
            end select
            springs%pressed(k) = pressed
         end associate
      end do
   end subroutine settle_slip

   !> Energy that the springs store [J].
   pure real(dp) function spring_energy(springs) result(energy)
      type(face_springs_t), intent(in) :: springs
      integer :: k
      energy = 0
      do k = 1, springs%n
         energy = energy + energy_of(springs, k)
      end do
   end function spring_energy

   !> Energy that a spring stores [J]: that of a bond since it began. One that has begun to let go stores none, what it takes is lost.
   pure real(dp) function energy_of(springs, k) result(energy)
      type(face_springs_t), intent(in) :: springs
      integer, intent(in) :: k
      associate (stretch => stretch_of(springs, k), s => springs%stiffness(k))
         if (springs%kind(k) /= bond) then
            energy = sum(force_of(springs, k)**2)/(2*s)
         else if (springs%lets_go(k)) then
            energy = 0
         else
            energy = springs%stored(k) + dot_product(springs%held(:, k), stretch) + s*sum(stretch**2)/2
         end if
      end associate
   end function energy_of

   !> Add a spring that nothing has stretched, without nodes.
   pure subroutine add_spring(springs, kind)
      type(face_springs_t), intent(inout) :: springs
      integer, intent(in) :: kind
      if (springs%n == size(springs%kind)) call make_room(springs, 2*springs%n)
      springs%n = springs%n + 1
      if (kind == contact) springs%n_contact = springs%n_contact + 1
      associate (s => springs%n)
         springs%kind(s) = kind
         springs%node(:, s) = 0
         springs%n_left(s) = 0
         springs%share(:, s) = 0
         springs%normal(:, s) = [1, 0]
         springs%friction(s) = 0
         springs%opening(:, s) = 0
         springs%slip(s) = 0
         springs%pressed(s) = 0
         springs%line(s) = 0
         springs%tip(s) = 0
         springs%way(s) = 0
         springs%held(:, s) = 0
         springs%start(:, s) = 0
         springs%lets_go(s) = .false.
         springs%kept(s) = 1
         springs%reached(s) = 0
         springs%stored(s) = 0
         springs%mass(s) = 0
         springs%rate(:, s) = 0
      end associate
   end subroutine add_spring

   !> Room for a number of springs; those that there are stay.
   pure subroutine make_room(springs, most)
      type(face_springs_t), intent(inout) :: springs
      integer, intent(in) :: most
      type(face_springs_t) :: more
      more%thickness = springs%thickness
      more%are_bounded = springs%are_bounded
      more%most = springs%most
      more%wanted = springs%wanted
      more%weakest = springs%weakest
      more%weakest_contact = springs%weakest_contact
      more%are_moving = springs%are_moving
      more%alone = springs%alone
      more%n = springs%n
      more%n_contact = springs%n_contact
      more%loss = springs%loss
      allocate (more%kind(most), more%node(2*most_nodes_of_leaf, most), more%n_left(most), more%share(2*most_nodes_of_leaf, most), &
                more%stiffness(most), more%place(ndim, most), more%length(most), more%normal(ndim, most), &
                more%friction(most), more%opening(ndim, most), more%slip(most), more%pressed(most))
      allocate (more%line(most), more%tip(most), more%way(most), &
                more%cell(most), more%held(ndim, most), more%start(ndim, most), more%stored(most))
      allocate (more%lets_go(most), more%kept(most), more%reached(most), more%mass(most), more%rate(ndim, most))
      associate (n => springs%n)
         if (n > 0) then
            more%kind(:n) = springs%kind(:n)
            more%node(:, :n) = springs%node(:, :n)
            more%n_left(:n) = springs%n_left(:n)
            more%share(:, :n) = springs%share(:, :n)
            more%stiffness(:n) = springs%stiffness(:n)
            more%place(:, :n) = springs%place(:, :n)
            more%length(:n) = springs%length(:n)
            more%normal(:, :n) = springs%normal(:, :n)
            more%friction(:n) = springs%friction(:n)
            more%opening(:, :n) = springs%opening(:, :n)
            more%slip(:n) = springs%slip(:n)
            more%pressed(:n) = springs%pressed(:n)
            more%line(:n) = springs%line(:n)
            more%tip(:n) = springs%tip(:n)
            more%way(:n) = springs%way(:n)
            more%cell(:n) = springs%cell(:n)
            more%held(:, :n) = springs%held(:, :n)
            more%start(:, :n) = springs%start(:, :n)
            more%lets_go(:n) = springs%lets_go(:n)
            more%kept(:n) = springs%kept(:n)
            more%reached(:n) = springs%reached(:n)
            more%stored(:n) = springs%stored(:n)
            more%mass(:n) = springs%mass(:n)
            more%rate(:, :n) = springs%rate(:, :n)
         end if
      end associate
      springs = more
   end subroutine make_room

   !> Keep springs: in the updated frame they are where faces were when cells were cut last, and what they remember.
   subroutine keep_springs(springs, archive)
      type(face_springs_t), intent(inout) :: springs
      class(archive_t), intent(inout) :: archive
      integer :: n
      n = springs%n
      call archive%section('face_springs')
      call archive%keep('number', n)
      if (n == 0 .or. archive%failure%failed()) return
      if (archive%is_read) then
         springs%n = 0
         call make_room(springs, max(n, 64))
         springs%n = n
      end if
      call archive%keep('n_contact', springs%n_contact)
      call archive%keep('loss', springs%loss)
      call archive%keep_integers('kind', n, springs%kind)
      call archive%keep_integers('node', n*size(springs%node, 1), springs%node)
      call archive%keep_integers('n_left', n, springs%n_left)
      call archive%keep_reals('share', n*size(springs%share, 1), springs%share)
      call archive%keep_reals('stiffness', n, springs%stiffness)
      call archive%keep_reals('place', ndim*n, springs%place)
      call archive%keep_reals('length', n, springs%length)
      call archive%keep_reals('normal', ndim*n, springs%normal)
      call archive%keep_reals('friction', n, springs%friction)
      call archive%keep_reals('opening', ndim*n, springs%opening)
      call archive%keep_reals('slip', n, springs%slip)
      call archive%keep_reals('pressed', n, springs%pressed)
      call archive%keep_integers('line', n, springs%line)
      call archive%keep_integers('tip', n, springs%tip)
      call archive%keep_reals('way', n, springs%way)
      call archive%keep_reals('cell', n, springs%cell)
      call archive%keep_reals('held', ndim*n, springs%held)
      call archive%keep_reals('start', ndim*n, springs%start)
      call archive%keep_logicals('lets_go', n, springs%lets_go)
      call archive%keep_reals('kept', n, springs%kept)
      call archive%keep_reals('reached', n, springs%reached)
      call archive%keep_reals('stored', n, springs%stored)
      call archive%keep_reals('mass', n, springs%mass)
      call archive%keep_reals('rate', ndim*n, springs%rate)
   end subroutine keep_springs
end module hampm_face_springs
