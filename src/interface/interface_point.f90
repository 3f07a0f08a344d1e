!> An interface point, and the list of all: a quadrature point with two sides, each a set of nodes with weights c_j in its opening
!>
!>    g = sum over nodes of c_j u_j.
!>
!> The laws of its force are in `hampm_interface_points`. A point is three types, one in the other: the state of its law, its place,
!> and what it joins. State and place are real numbers, columns to those that keep, copy or interpolate points: a component of
!> these types needs no other list.
module hampm_interface_point
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_cohesive_law, only: cohesive_law_t
   use hampm_jumps, only: jump_t
   use hampm_nearby, only: nearby_t
   use hampm_tensors, only: norm, identity, quarter_turn
   use hampm_text, only: to_text
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: interfaces_t, interface_point_t, face_state_t, bonded, releasing, contact, ghost, cohesive, support, is_half, &
             along, along_faces, length_along, in_direction_of, direction_of, components_of, vector_of, turned, interpolated, &
             add_interface_point, find_points, find_points_at_tip, sort_for_tips, archive_interfaces

   integer, parameter :: bonded = 1, contact = 2, ghost = 3, cohesive = 4, support = 5, releasing = 6 !! law of an interface point

   !> State of the law of an interface point. Each law leaves the columns of the others as they begin.
   type :: face_state_t
      real(dp) :: opening(ndim) = 0              !! g, of the left face from the right one [m]
      real(dp) :: before(ndim) = 0               !! opening before the last step [m]
      real(dp) :: effective_opening(ndim) = 0    !! opening with the force of the last step, for forces at its end [m]
      real(dp) :: start(ndim) = 0                !! opening with `initial_force`; of `contact` without effect after a change of the
                                                 !! mesh [m]
      real(dp) :: initial_force(ndim) = 0        !! of a bonded point at the opening `start` [N]
      real(dp) :: stored = 0                     !! its energy there, or at the start of its release [J]
      real(dp) :: fraction_left = 1              !! of `releasing`: part of the initial force that is left [-]
      real(dp) :: fraction_before = 1            !! the same, in the forces at the start of an implicit step [-]
      real(dp) :: reached = 0                    !! of that: opening since then along the force, when last looked at [m]
      real(dp) :: contact_offset = -huge(1.0_dp) !! opening across the faces below which they press on each other [m]
      real(dp) :: slip(ndim - 1) = 0             !! sliding at which they hold each other without a force along them [m]
      real(dp) :: slid(ndim - 1) = 0             !! sliding not held by friction so far; all of it if separate [m]
      real(dp) :: pressed = 0                    !! overlap of the faces after the last step [m]
      real(dp) :: carried(ndim) = 0              !! force of `contact` without overlap and elastic sliding, over the stiffness [m]
      real(dp) :: spare = 0                      !! friction limit beyond that of its own pressure, over the stiffness [m]
      real(dp) :: friction_limit = -1            !! over the stiffness; below 0 if it follows the pressure [m]
      real(dp) :: damage = 0                     !! of `cohesive`, 1 where it has failed [-]
      real(dp) :: dissipated(2) = 0              !! of that, by opening and by sliding [J/m2]
      real(dp) :: rate(ndim) = 0                 !! of `ghost`: w [m/s]
   end type face_state_t

   !> Place of an interface point.
   type, extends(face_state_t) :: face_place_t
      real(dp) :: stiffness = 0                  !! s [N/m]
      real(dp) :: place(ndim) = 0                !! on the line [m]
      real(dp) :: middle(ndim) = 0               !! of the part of the line that it stands for [m]
      real(dp) :: origin(ndim) = 0               !! in the reference configuration, of faces; of `ghost` place in the grid [m]
      real(dp) :: length = 0                     !! of the line that it stands for [m]
      real(dp) :: area = 0                       !! of faces that it stands for [m2]
      real(dp) :: normal(ndim) = identity(:, 1)  !! from the right to the left face
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: way = 0                        !! of its tip from its start to the point; of `cohesive` to its start [m]
      real(dp) :: cell = 0                       !! size of the cell there [m]
   end type face_place_t

   !> An interface point.
   type, extends(face_place_t) :: interface_point_t
      type(jump_t) :: jump                       !! nodes and weights, of the left face first, and mass
      integer :: law = bonded                    !! `bonded`, `releasing`, `contact`, `ghost`, `cohesive` or `support`
      integer :: n_left = 0                      !! number of nodes of the left face
      integer :: line = 0                        !! number of the crack whose faces may touch there, 0 for none
      integer :: tip = 0                         !! number of the tip that moves over a bonded point, 0 for none
      integer :: plane = 0                       !! number of the crack in a plane whose front moves over its square, 0 for none
      integer :: cohesion = 0                    !! number of the law of `cohesive`
      logical :: is_new = .false.                !! under a moving front: whether it is at a node whose force it is to take
      logical :: is_penalty = .false.            !! whether the layer is far stiffer than the cells beside it
      logical :: follows_leaf = .false.          !! whether its place is one in a leaf, else in the material
   end type interface_point_t

   !> All interface points.
   type :: interfaces_t
      type(thickness_t) :: thickness             !! of the material
      logical :: are_bounded = .true.            !! whether explicit steps have to be stable
      integer :: n_at_end = 0                    !! number of the first points with forces that depend on the step
      logical :: strain_last = .false.           !! whether velocities that particles do not keep open them (usl)
      logical :: are_lumped = .true.             !! whether the masses of their nodes are lumped then
      logical :: are_moving = .true.             !! whether they have masses, where they may
      integer :: alone = 0                       !! first element of a piece too small to move with no fuller one beside it, 0
                                                 !! for none
      integer :: n = 0                           !! number of interface points
      integer :: n_contact = 0                   !! of which are for contact
      real(dp) :: weight = 1                     !! of the forces of penalty faces, in an implicit step (`hampm_newmark`) [-]
      logical :: keep_slip = .false.             !! whether slip is not yet committed: its load is still searched
      real(dp) :: tangent_floor = 0              !! least part of the stiffness in the tangent of faces [-]
      integer :: n_cohesive = 0                  !! and of which are `cohesive`
      type(cohesive_law_t), allocatable :: cohesion(:) !! the laws
      real(dp) :: loss = 0                       !! energy taken by friction and by cohesion [J]
      real(dp) :: of_cohesion = 0                !! of which is taken by cohesion [J]
      type(interface_point_t), allocatable :: list(:)     !! (n at least)
      type(nearby_t) :: at_tips                  !! table of their middles, where many tips look for those of their discs
      real(dp) :: largest_cell = 0               !! of these [m]
   end type interfaces_t

contains

   !> The d-th direction of an interface point, a unit vector: the first across its faces, the others along them, in space along
   !> axes of the grid.
   pure function direction_of(point, d) result(t)
      type(interface_point_t), intent(in) :: point
      integer, intent(in) :: d
      real(dp) :: t(ndim)
      if (d == 1) then
         t = point%normal
      else if (ndim == 2) then
         t = quarter_turn(-point%normal)
      else
         t = identity(:, mod(maxloc(abs(point%normal), dim=1) + d - 2, ndim) + 1)
      end if
   end function direction_of

   !> Unit vector along the line of an interface point.
   pure function along(point) result(t)
      type(interface_point_t), intent(in) :: point
      real(dp) :: t(ndim)
      t = direction_of(point, 2)
   end function along

   !> Components of a vector in the directions of a point.
   pure function components_of(point, vector) result(components)
      type(interface_point_t), intent(in) :: point
      real(dp), intent(in) :: vector(ndim)
      real(dp) :: components(ndim)
      integer :: d
      do d = 1, ndim
         components(d) = dot_product(vector, direction_of(point, d))
      end do
   end function components_of

   !> Components of a vector along the faces.
   pure function along_faces(point, vector) result(components)
      type(interface_point_t), intent(in) :: point
      real(dp), intent(in) :: vector(ndim)
      real(dp) :: components(ndim - 1)
      integer :: d
      do d = 2, ndim
         components(d - 1) = dot_product(direction_of(point, d), vector)
      end do
   end function along_faces

   !> The vector with these components.
   pure function vector_of(point, components) result(vector)
      type(interface_point_t), intent(in) :: point
      real(dp), intent(in) :: components(ndim)
      real(dp) :: vector(ndim)
      integer :: d
      vector = components(1)*point%normal
      do d = 2, ndim
         vector = vector + components(d)*direction_of(point, d)
      end do
   end function vector_of

   !> Rotate a vector at an old point, across and along the faces, to its successor: material may have rotated it, and bonded points
   !> follow the path of their tip, contact the points of its crack.
   pure function turned(vector, before, point)
      real(dp), intent(in) :: vector(ndim)
      type(interface_point_t), intent(in) :: before, point
      real(dp) :: turned(ndim)
      turned = vector_of(point, components_of(before, vector))
   end function turned

   !> How long a vector along faces is.
   pure real(dp) function length_along(components) result(length)
      real(dp), intent(in) :: components(ndim - 1)
      length = merge(abs(components(1)), norm(components), ndim == 2)
   end function length_along

   !> Vector of the length of a limit in the direction of a sliding.
   pure function in_direction_of(sliding, limit) result(components)
      real(dp), intent(in) :: sliding(ndim - 1), limit
      real(dp) :: components(ndim - 1)
      if (ndim == 2) then
         components = sign(limit, sliding)
      else
         components = limit/max(norm(sliding), tiny(limit))*sliding
      end if
   end function in_direction_of

   !> Whether a point lies between a face and its mirror image: nodes of the other face are missing. Both sides of a ghost penalty
   !> may have the same nodes. A support, which holds along the normal alone, counts as half.
   pure logical function is_half(point)
      type(interface_point_t), intent(in) :: point
      is_half = point%law == support .or. &
                point%law /= ghost .and. (point%n_left == 0 .or. point%jump%node(point%n_left + 1) == 0)
   end function is_half

   !> The state that is a part of the way from one to another.
   pure type(face_state_t) function interpolated(one, other, part) result(between)
      type(face_state_t), intent(in) :: one, other
      real(dp), intent(in) :: part
      associate (a => transfer(one, [part]), b => transfer(other, [part]))
         between = transfer(a + part*(b - a), one)
      end associate
   end function interpolated

   !> Add an interface point that nothing has stretched, without nodes.
   pure subroutine add_interface_point(interfaces, law)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: law
      type(interface_point_t) :: new             ! its constructor ends flang 19
      type(interface_point_t), allocatable :: more(:)
      if (.not. allocated(interfaces%list)) allocate (interfaces%list(64))
      if (interfaces%n == size(interfaces%list)) then
         allocate (more(2*interfaces%n))
         more(:interfaces%n) = interfaces%list
         call move_alloc(more, interfaces%list)
      end if
      interfaces%n = interfaces%n + 1
      new%law = law
      if (law == cohesive) interfaces%n_cohesive = interfaces%n_cohesive + 1
      if (law == contact) interfaces%n_contact = interfaces%n_contact + 1
      if (law == contact .or. law == cohesive) new%contact_offset = 0
      interfaces%list(interfaces%n) = new
   end subroutine add_interface_point

   !> Find the points that are nearer to a place than a reach along each axis, or than two of their own cells or lengths.
   pure subroutine find_points(interfaces, near, origin, reach, found, visits)
      type(interfaces_t), intent(in) :: interfaces
      type(nearby_t), intent(inout) :: near      !! table of their places, made here when it is first asked
      real(dp), intent(in) :: origin(ndim)       !! in the reference configuration [m]
      real(dp), intent(in) :: reach              !! [m]
      integer, allocatable, intent(out) :: found(:) !! in the order of their numbers
      integer, intent(inout), optional :: visits !! places compared so far
      real(dp) :: places(ndim, interfaces%n)
      integer :: k
      allocate (found(0))
      if (interfaces%n == 0) return
      if (.not. near%is_built) then
         do k = 1, interfaces%n
            places(:, k) = interfaces%list(k)%origin
         end do
         call near%sort(places, 2*max(interfaces%list(:interfaces%n)%cell, interfaces%list(:interfaces%n)%length))
      end if
      call near%find(origin, reach, found, visits)
   end subroutine find_points

   !> Make the table by which many tips find the points of their discs.
   pure subroutine sort_for_tips(interfaces, tips)
      type(interfaces_t), intent(inout) :: interfaces
      integer, intent(in) :: tips                !! how many there are that release no points, whose zones may be long
      integer, parameter :: many = 8
      real(dp) :: places(ndim, interfaces%n)
      integer :: k
      interfaces%at_tips = nearby_t()
      if (tips <= many .or. interfaces%n == 0) return
      associate (of => interfaces%list(:interfaces%n))
         do k = 1, interfaces%n
            places(:, k) = of(k)%middle
         end do
         interfaces%largest_cell = maxval(of%cell)
         call interfaces%at_tips%sort(places, max(of%cell, of%length))
      end associate
   end subroutine sort_for_tips

   !> The points whose middles may be nearer to a tip along each axis than a distance and some of their own cells, ascending.
   pure subroutine find_points_at_tip(interfaces, tip, distance, cells, found)
      type(interfaces_t), intent(in) :: interfaces
      real(dp), intent(in) :: tip(ndim)          !! [m]
      real(dp), intent(in) :: distance, cells    !! [m], [-]
      integer, allocatable, intent(out) :: found(:)
      integer :: k
      if (interfaces%at_tips%is_built) then
         call interfaces%at_tips%find(tip, distance + cells*interfaces%largest_cell, found)
      else
         found = [(k, k=1, interfaces%n)]
      end if
   end subroutine find_points_at_tip

   !> Archive interface points: in the updated frame their places at the last cut of cells, and their state.
   subroutine archive_interfaces(interfaces, archive)
      type(interfaces_t), intent(inout) :: interfaces
      class(archive_t), intent(inout) :: archive
      real(dp), allocatable :: columns(:, :)     ! of state and place, (columns, points)
      type(interface_point_t) :: new
      integer :: n, j
      n = interfaces%n
      call archive%section('interface_points')
      call archive%serialise('number', n)
      call archive%serialise('n_at_end', interfaces%n_at_end)
      if (n == 0 .or. archive%failure%failed()) return
      if (archive%is_read) then
         interfaces%n = n
         if (allocated(interfaces%list)) deallocate (interfaces%list)
         allocate (interfaces%list(max(n, 64)))
      end if
      call archive%serialise('n_contact', interfaces%n_contact)
      call archive%serialise('n_cohesive', interfaces%n_cohesive)
      call archive%serialise('loss', interfaces%loss)
      call archive%serialise('of_cohesion', interfaces%of_cohesion)
      associate (of => interfaces%list(:n))
         allocate (columns(size(transfer(new%face_place_t, [0.0_dp])), n))
         do j = 1, n
            columns(:, j) = transfer(of(j)%face_place_t, columns)
         end do
         call archive%archive_reals('columns', size(columns), columns)
         do j = 1, n
            of(j)%face_place_t = transfer(columns(:, j), new%face_place_t)
         end do
         call archive%archive_integers('law', n, of%law)
         call archive%archive_integers('n_left', n, of%n_left)
         call archive%archive_integers('line', n, of%line)
         call archive%archive_integers('tip', n, of%tip)
         call archive%archive_integers('plane', n, of%plane)
         call archive%archive_integers('cohesion', n, of%cohesion)
         call archive%archive_logicals('is_penalty', n, of%is_penalty)
         call archive%archive_logicals('follows_leaf', n, of%follows_leaf)
         call archive%archive_reals('mass', n, of%jump%mass)
         do j = 1, size(new%jump%node)
            call archive%archive_integers('node_'//to_text(j), n, of%jump%node(j))
            call archive%archive_reals('share_'//to_text(j), n, of%jump%share(j))
         end do
      end associate
   end subroutine archive_interfaces
end module hampm_interface_point
