!> Dirichlet constraints: nodes that are held, or moved as prescribed, in some directions. The user gives them as boxes, which are
!> fitted to each new grid. One grid may have several sets of them: extrapolations are solved without the constraints of the motion.
!> Of those that only push (`hampm_supports`) a component is fixed while the material presses on it.
!>
!> A box that turns freely is a pin, or a roller if it fixes one component: its nodes, i, move as a rigid body about its middle:
!>
!>    u_i = U(t) + theta t_i,     t_i = e_z x (x_i - middle)/largest,     in the components that are fixed,
!>
!> and the one unknown theta is such that the reactions have no moment, sum over i of t_i . R_i = 0.
module hampm_constraints
   use hampm_kinds, only: dp, ndim, corners
   use hampm_forest, only: corner_offset
   use hampm_grid, only: grid_t
   use hampm_tensors, only: identity, quarter_turn
   use hampm_time_history, only: time_history_t
   use hampm_tolerance, only: position_tolerance
   implicit none
   private
   public :: constraints_t, box_t, given_motion_t, constrain_box, add_box, hold_axis, rebuild_constraints, find_levers, hold, &
             let_turn

   !> How held nodes are moved.
   type :: given_motion_t
      real(dp) :: displacement(ndim) = 0         !! displacement at the factor 1 [m]
      real(dp) :: velocity(ndim) = 0             !! and with which [m/s]
      type(time_history_t) :: history            !! of that factor
      logical :: unilateral = .false.            !! whether nothing keeps the material from leaving them
      logical :: turns = .false.                 !! whether nothing keeps them from turning, as a rigid body
   end type given_motion_t

   !> A box in which nodes are fixed.
   type :: box_t
      real(dp) :: lower(ndim) = 0, upper(ndim) = 0 !! its corners [m]
      real(dp) :: reach(ndim, 2) = 0             !! corners of the box in which it holds nodes [m]
      logical :: components(ndim) = .false.      !! which components it fixes
      type(given_motion_t) :: motion             !! how it moves them
   end type box_t

   !> Boxes, and the nodes of the present grid that are fixed in them.
   type :: constraints_t
      type(box_t), allocatable :: boxes(:)
      logical, private :: has_axis = .false.     !! whether material is axisymmetric: then nothing leaves the axis x = 0
      logical, allocatable :: fixed(:, :)        !! which component of which node, (ndim, n_nodes)
      real(dp), allocatable :: free(:, :)        !! 0 where a component is fixed, else 1; (ndim, n_points)
      integer, allocatable :: node(:)            !! nodes with a component in a box, ascending
      integer, allocatable :: box(:, :)          !! the last box that holds a component, 0 for none, (ndim, n_nodes)
      logical, allocatable :: supported(:, :)    !! whether that only pushes, (ndim, n_nodes)
      real(dp), allocatable :: lift(:, :)        !! offset of a component from its support [m], (ndim, n_nodes)
      real(dp), allocatable :: up(:, :)          !! 1 or -1: which way from its support the material is, (ndim, n_nodes); not
                                                 !! allocated until that is asked
      integer, allocatable :: turning(:, :)      !! the box with which a component turns, 0 for none, (ndim, n_nodes); not allocated
                                                 !! where none does
      real(dp), allocatable :: lever(:, :)       !! t of these [-], (ndim, n_nodes)
   contains
      procedure :: holds
      procedure :: number
      procedure :: move
      procedure :: only_push
      procedure :: supporting
      procedure :: set_fixed
      procedure :: fix
      procedure :: prescribed_at
      procedure :: prescribed_of_nodes
      procedure :: by_ways
      procedure :: prescribed_of_box
      procedure :: largest_prescribed
      procedure :: scale_ways
      procedure :: ways_at
      procedure :: have_held_ways
      procedure :: scaled_units
      procedure :: have_scaled_ways
      procedure :: nodes_that_turn
      procedure :: turned
      procedure :: held_at
   end type constraints_t

contains

   !> Multiply all given motions that are not held.
   pure subroutine scale_ways(self, factor)
      class(constraints_t), intent(inout) :: self
      real(dp), intent(in) :: factor             !! relative to the model, not to the present value [-]
      if (allocated(self%boxes)) call self%boxes%motion%history%scale_to(factor)
   end subroutine scale_ways

   !> Fix or move the `components` of all nodes within a box, its faces included; where boxes overlap the last one counts.
   subroutine constrain_box(c, grid, lower, upper, components)
      type(constraints_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the box [m]
      logical, intent(in) :: components(ndim)
      call add_box(c, lower, upper, components)
      call rebuild_constraints(c, grid)
   end subroutine constrain_box

   !> Add a box to those whose nodes the next rebuild finds. Nodes within `reach`, if given, are held as well: beyond the end of a
   !> body, where its last cells have nodes.
   pure subroutine add_box(c, lower, upper, components, motion, reach)
      type(constraints_t), intent(inout) :: c
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the box [m]
      logical, intent(in) :: components(ndim)
      type(given_motion_t), intent(in), optional :: motion
      real(dp), intent(in), optional :: reach(ndim, 2) !! corners of the box [m]
      type(box_t), allocatable :: boxes(:)
      integer :: k
      if (.not. allocated(c%boxes)) allocate (c%boxes(0))
      allocate (boxes(size(c%boxes) + 1))        ! [c%boxes, box] would leak in gfortran 12
      do k = 1, size(c%boxes)
         boxes(k) = c%boxes(k)
      end do
      boxes(size(boxes))%lower = lower
      boxes(size(boxes))%upper = upper
      boxes(size(boxes))%reach(:, 1) = lower
      boxes(size(boxes))%reach(:, 2) = upper
      if (present(reach)) boxes(size(boxes))%reach = reach
      boxes(size(boxes))%components = components
      if (present(motion)) boxes(size(boxes))%motion = motion
      call move_alloc(boxes, c%boxes)
   end subroutine add_box

   !> Hold all nodes on the axis of axisymmetric material in the direction of the radius.
   subroutine hold_axis(c, grid)
      type(constraints_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      c%has_axis = .true.
      call rebuild_constraints(c, grid)
   end subroutine hold_axis

   !> Find the nodes of a grid that are in the boxes.
   subroutine rebuild_constraints(c, grid)
      type(constraints_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      integer :: k
      if (allocated(c%fixed)) deallocate (c%fixed, c%free, c%box, c%supported, c%lift)
      if (allocated(c%up)) deallocate (c%up)
      if (allocated(c%turning)) deallocate (c%turning, c%lever)
      allocate (c%fixed(ndim, grid%n_nodes), source=.false.)
      allocate (c%box(ndim, grid%n_nodes), source=0)
      allocate (c%free(ndim, grid%n_points), source=1.0_dp)
      allocate (c%supported(ndim, grid%n_nodes), source=.false.)
      allocate (c%lift(ndim, grid%n_nodes), source=0.0_dp)
      if (.not. allocated(c%boxes)) allocate (c%boxes(0))
      do k = 1, size(c%boxes)
         call hold_in_box(c, grid, k)
      end do
      if (c%has_axis) where (abs(grid%node_position(1, :grid%n_nodes)) <= grid%forest%tolerance()) c%fixed(1, :) = .true.
      where (c%fixed) c%free(:, :grid%n_nodes) = 0
      c%node = pack([(k, k=1, grid%n_nodes)], any(c%fixed, dim=1))
   end subroutine rebuild_constraints

   !> After a rebuild, find the components that turn with their boxes, and their levers: of nodes that have material, or may have
   !> it. Boxes whose nodes define no rotation, as a single one, are held.
   pure subroutine find_levers(c, grid, has_material)
      type(constraints_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      logical, intent(in) :: has_material(:)     !! by node
      real(dp), parameter :: rounding = 1e-9_dp  ! of a lever
      real(dp) :: across(ndim), arm(ndim)
      integer :: i, k, a
      if (.not. any(c%boxes%motion%turns)) return
      allocate (c%turning, mold=c%box)
      allocate (c%lever(ndim, grid%n_nodes), source=0.0_dp)
      c%turning = 0
      do k = 1, size(c%boxes)
         if (.not. c%boxes(k)%motion%turns) cycle
         do i = 1, grid%n_nodes
            if (.not. has_material(i)) cycle
            where (c%box(:, i) == k) c%turning(:, i) = k
            arm = grid%node_position(:, i) - (c%boxes(k)%lower + c%boxes(k)%upper)/2
            if (ndim > 2) then                   ! around the direction that is free
               a = findloc(c%boxes(k)%components, .false., dim=1)
               across = cshift(identity(:, a), 1)*cshift(arm, -1) - cshift(identity(:, a), -1)*cshift(arm, 1)
            else
               across = quarter_turn(arm)
            end if
            where (c%box(:, i) == k) c%lever(:, i) = across
         end do
         associate (largest => maxval(abs(c%lever), mask=c%turning == k))
            if (all([(spread_of(pack(c%lever(i, :), c%turning(i, :) == k)), i=1, ndim)] <= rounding*grid%forest%cell)) then
               where (c%turning == k) c%turning = 0
            else
               where (c%turning == k) c%lever = c%lever/largest
            end if
         end associate
      end do
   end subroutine find_levers

   !> Range of some numbers; 0 if there are none.
   pure real(dp) function spread_of(values)
      real(dp), intent(in) :: values(:)
      spread_of = 0
      if (size(values) > 0) spread_of = maxval(values) - minval(values)
   end function spread_of

   !> The nodes with a component that turns.
   pure function nodes_that_turn(self) result(nodes)
      class(constraints_t), intent(in) :: self
      integer, allocatable :: nodes(:)
      integer :: k
      nodes = [integer ::]
      if (allocated(self%turning)) nodes = pack(self%node, [(any(self%turning(:, self%node(k)) > 0), k=1, size(self%node))])
   end function nodes_that_turn

   !> Rotation of the boxes in a nodal field, at the nodes with a component in a box: theta t by least squares, independent of the
   !> mean of the field in a box; (ndim, these nodes).
   pure function turned(self, x) result(turn)
      class(constraints_t), intent(in) :: self
      real(dp), intent(in) :: x(:, :)            !! (ndim, n_points)
      real(dp) :: turn(ndim, size(self%node))
      real(dp), dimension(ndim, size(self%boxes)) :: n, of_t, of_x
      real(dp), dimension(size(self%boxes)) :: of_tx, of_tt
      integer :: i, d
      turn = 0
      if (.not. allocated(self%turning)) return
      n = 0
      of_t = 0
      of_x = 0
      do i = 1, size(self%node)
         do d = 1, ndim
            associate (node => self%node(i), k => self%turning(d, self%node(i)))
               if (k == 0) cycle
               n(d, k) = n(d, k) + 1
               of_t(d, k) = of_t(d, k) + self%lever(d, node)
               of_x(d, k) = of_x(d, k) + x(d, node)
            end associate
         end do
      end do
      of_t = of_t/max(n, 1.0_dp)
      of_x = of_x/max(n, 1.0_dp)
      of_tx = 0
      of_tt = 0
      do i = 1, size(self%node)
         do d = 1, ndim
            associate (node => self%node(i), k => self%turning(d, self%node(i)))
               if (k == 0) cycle
               of_tx(k) = of_tx(k) + (self%lever(d, node) - of_t(d, k))*(x(d, node) - of_x(d, k))
               of_tt(k) = of_tt(k) + (self%lever(d, node) - of_t(d, k))**2
            end associate
         end do
      end do
      do i = 1, size(self%node)
         do d = 1, ndim
            associate (node => self%node(i), k => self%turning(d, self%node(i)))
               if (k > 0) turn(d, i) = of_tx(k)/of_tt(k)*self%lever(d, node)
            end associate
         end do
      end do
   end function turned

   !> Turn the boxes by the forces on them: their nodes are theta t with theta = sum of t . b/sum of m t**2.
   pure subroutine let_turn(c, mass, b, x)
      type(constraints_t), intent(in) :: c
      real(dp), intent(in) :: mass(:)            !! m of the nodes, which are lumped, 0 where there is no material [kg]
      real(dp), intent(in) :: b(:, :)            !! (ndim, n_points)
      real(dp), intent(inout) :: x(:, :)         !! (ndim, n_points)
      real(dp), dimension(size(c%boxes)) :: of_tb, of_tt
      integer :: i, d
      of_tb = 0
      of_tt = 0
      do i = 1, size(c%node)
         do d = 1, ndim
            associate (node => c%node(i), k => c%turning(d, c%node(i)))
               if (k == 0) cycle
               of_tb(k) = of_tb(k) + c%lever(d, node)*b(d, node)
               of_tt(k) = of_tt(k) + max(mass(node), 0.0_dp)*c%lever(d, node)**2
            end associate
         end do
      end do
      do i = 1, size(c%node)
         do d = 1, ndim
            associate (node => c%node(i), k => c%turning(d, c%node(i)))
               if (k > 0) x(d, node) = of_tb(k)/max(of_tt(k), tiny(1.0_dp))*c%lever(d, node)
            end associate
         end do
      end do
   end subroutine let_turn

   !> Where a component of a node is held: where that is, or in the middle of the box with which it turns [m].
   pure function held_at(self, grid, node, component) result(x)
      class(constraints_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: node, component
      real(dp) :: x(ndim)
      x = grid%node_position(:, node)
      if (.not. allocated(self%turning)) return
      associate (k => self%turning(component, node))
         if (k == 0) return
         where (self%boxes(k)%components .or. ndim == 2) x = (self%boxes(k)%lower + self%boxes(k)%upper)/2
      end associate
   end function held_at

   !> Fix the nodes in the k-th box, but where a crack on a symmetry plane has grown.
   pure subroutine hold_in_box(c, grid, k)
      type(constraints_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: k
      real(dp) :: margin
      logical :: held(ndim)
      integer :: i
      associate (f => grid%forest)
         margin = position_tolerance(f%cell, f%lower, f%lower + f%cell*f%cells)
      end associate
      do i = 1, grid%n_nodes
         associate (x => grid%node_position(:, i), box => c%boxes(k))
            if (x(1) < box%reach(1, 1) - margin .or. x(1) > box%reach(1, 2) + margin) cycle ! most are apart in one direction
            if (.not. all(x >= box%reach(:, 1) - margin .and. x <= box%reach(:, 2) + margin)) cycle
            if (.not. is_beside(grid, i, box, margin)) cycle
            held = box%components .and. .not. (grid%cut_cells%freed_at(x) .or. freed_by_planes(grid, x))
            c%fixed(:, i) = c%fixed(:, i) .or. held
            where (held) c%box(:, i) = k
            where (held) c%supported(:, i) = box%motion%unilateral
         end associate
      end do
   end subroutine hold_in_box

   !> Which components of a node at a place a crack in a plane of symmetry has freed.
   pure function freed_by_planes(grid, x) result(freed)
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: x(ndim)            !! [m]
      logical :: freed(ndim)
      integer :: k
      freed = .false.
      if (.not. allocated(grid%planes)) return
      do k = 1, size(grid%planes)
         associate (plane => grid%planes(k))
            if (plane%is_symmetry) freed(plane%axis) = freed(plane%axis) .or. plane%opens_at(grid%forest, x)
         end associate
      end do
   end function freed_by_planes

   !> Whether a node in a box belongs to material that reaches into it. Where a box ends at a crack, the nodes of the other face, at
   !> the same places, do not; nor do, beyond the edge of a body, nodes of cells with material out of the box alone.
   pure logical function is_beside(grid, node, box, margin) result(is)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: node
      type(box_t), intent(in) :: box
      real(dp), intent(in) :: margin             !! [m]
      real(dp), parameter :: aside = 1e-3_dp     ! smallest cell at the node
      real(dp) :: x(ndim)
      integer :: i, e, velocity_field
      logical :: is_wide(ndim), looks            ! whether the material in the cells is looked at
      is = .true.
      is_wide = box%upper - box%lower > 2*margin
      looks = allocated(grid%bodies) .and. all(is_wide)
      if (looks) looks = any([(is_cut_toward(i), i=1, corners)])
      if (.not. (looks .or. grid%cut_cells%are_there() .or. allocated(grid%planes))) return
      do i = 1, corners
         x = toward(i)
         if (any(is_wide .and. (x < box%reach(:, 1) .or. x > box%reach(:, 2))) .and. .not. looks) cycle
         e = grid%element_at(x)
         if (e == 0) cycle
         if (looks) then
            if (.not. reaches_into_box(e)) cycle
         end if
         do velocity_field = 1, grid%n_velocity_fields
            if (any(grid%element_nodes(:, grid%copy_on(e, velocity_field)) == node)) return
         end do
      end do
      is = .false.

   contains

      !> A place in the i-th cell around the node [m].
      pure function toward(i) result(x)
         integer, intent(in) :: i
         real(dp) :: x(ndim)
         x = grid%node_position(:, node) + aside*grid%smallest_leaf_at(node)*(2*corner_offset(i) - 1)
      end function toward

      !> Whether that cell is cut.
      pure logical function is_cut_toward(i) result(is_cut)
         integer, intent(in) :: i
         integer :: e
         e = grid%element_at(toward(i))
         is_cut = e > 0
         if (is_cut) is_cut = grid%is_cut(grid%element_leaf(e))
      end function is_cut_toward

      !> Whether the bodies in a cell reach into the box.
      pure logical function reaches_into_box(e) result(reaches)
         integer, intent(in) :: e
         real(dp), parameter :: least = 1e-9_dp  ! part of a cell
         real(dp) :: moments(0:ndim), corner(ndim, 2), edge
         integer :: first, k
         first = grid%first_of_piece(e)
         edge = grid%leaf_size(e)
         corner(:, 1) = max(grid%element_lower(:, first), box%reach(:, 1) - aside*edge)
         corner(:, 2) = min(grid%element_lower(:, first) + edge, box%reach(:, 2) + aside*edge)
         reaches = .false.
         if (any(corner(:, 2) <= corner(:, 1))) return
         do k = 1, size(grid%bodies)
            moments = grid%bodies(k)%moments(corner(:, 1), corner(:, 2))
            reaches = reaches .or. moments(0) > least*edge**ndim
         end do
      end function reaches_into_box
   end function is_beside

   !> Whether a component of a node is fixed.
   pure logical function holds(self, node, component)
      class(constraints_t), intent(in) :: self
      integer, intent(in) :: node, component
      holds = .false.
      if (allocated(self%fixed)) holds = self%fixed(component, node)
   end function holds

   !> How many boxes there are.
   pure integer function number(self)
      class(constraints_t), intent(in) :: self
      number = 0
      if (allocated(self%boxes)) number = size(self%boxes)
   end function number

   !> Whether anything that is fixed is moved, or turns.
   pure logical function move(self)
      class(constraints_t), intent(in) :: self
      integer :: k
      move = .false.
      if (.not. allocated(self%boxes)) return
      do k = 1, size(self%boxes)
         move = move .or. any(abs(self%boxes(k)%motion%displacement) + abs(self%boxes(k)%motion%velocity) > 0) &
                .or. self%boxes(k)%motion%turns
      end do
   end function move

   !> Whether any only push.
   pure logical function only_push(self)
      class(constraints_t), intent(in) :: self
      integer :: k
      only_push = .false.
      if (.not. allocated(self%boxes)) return
      do k = 1, size(self%boxes)
         only_push = only_push .or. self%boxes(k)%motion%unilateral
      end do
   end function only_push

   !> The nodes that have such a support.
   pure function supporting(self) result(nodes)
      class(constraints_t), intent(in) :: self
      integer, allocatable :: nodes(:)
      integer :: k
      nodes = pack(self%node, [(any(self%supported(:, self%node(k))), k=1, size(self%node))])
   end function supporting

   !> Let a component that is in a box be fixed, or not.
   pure subroutine set_fixed(self, component, node, fixed)
      class(constraints_t), intent(inout) :: self
      integer, intent(in) :: component, node
      logical, intent(in) :: fixed
      self%fixed(component, node) = fixed
      self%free(component, node) = merge(0, 1, fixed)
   end subroutine set_fixed

   !> Let these components be fixed, all others not.
   pure subroutine fix(self, fixed)
      class(constraints_t), intent(inout) :: self
      logical, intent(in) :: fixed(:, :)         !! (ndim, n_nodes)
      self%fixed = fixed
      self%free(:, :size(fixed, 2)) = merge(0.0_dp, 1.0_dp, fixed)
   end subroutine fix

   !> Prescribed displacement of components in boxes at a time; 0 for the others [m], (ndim, n_nodes).
   pure function prescribed_at(self, time) result(u)
      class(constraints_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      real(dp) :: u(ndim, size(self%fixed, 2))
      u = 0
      u(:, self%node) = self%prescribed_of_nodes(time)
   end function prescribed_at

   !> Displacement of the nodes by the largest factors of those that are given, without velocities [m], (ndim, n_nodes).
   pure function largest_prescribed(self) result(u)
      class(constraints_t), intent(in) :: self
      real(dp) :: u(ndim, size(self%fixed, 2))
      real(dp) :: ways(ndim, self%number())
      integer :: k
      u = 0
      if (self%number() == 0) return
      do k = 1, size(ways, 2)
         associate (motion => self%boxes(k)%motion)
            ways(:, k) = motion%displacement*motion%history%largest_factor()
         end associate
      end do
      u(:, self%node) = self%by_ways(ways)
   end function largest_prescribed

   !> The same of the nodes with a component in a box [m], (ndim, these nodes).
   pure function prescribed_of_nodes(self, time) result(u)
      class(constraints_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      real(dp) :: u(ndim, size(self%node))
      u = self%by_ways(self%ways_at(time))
   end function prescribed_of_nodes

   !> Ways of the boxes, by the nodes with a component in one [m], (ndim, these nodes).
   pure function by_ways(self, ways) result(u)
      class(constraints_t), intent(in) :: self
      real(dp), intent(in) :: ways(:, :)         !! [m], (ndim, boxes)
      real(dp) :: u(ndim, size(self%node))
      real(dp) :: of_box(ndim, 0:size(self%boxes))
      integer :: i, d
      of_box(:, 0) = 0
      of_box(:, 1:) = ways
      do i = 1, size(self%node)
         do d = 1, ndim
            u(d, i) = of_box(d, self%box(d, self%node(i)))
         end do
      end do
   end function by_ways

   !> Prescribed displacement of each box at a time [m], (ndim, boxes).
   pure function ways_at(self, time) result(ways)
      class(constraints_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      real(dp) :: ways(ndim, self%number())
      integer :: k
      do k = 1, size(ways, 2)
         ways(:, k) = self%prescribed_of_box(k, time)
      end do
   end function ways_at

   !> Whether any box moves by its history, independent of the scale of others.
   pure logical function have_held_ways(self) result(have)
      class(constraints_t), intent(in) :: self
      integer :: k
      have = .false.
      do k = 1, self%number()
         associate (motion => self%boxes(k)%motion)
            have = have .or. motion%history%held .and. any(abs(motion%displacement) + abs(motion%velocity) > 0)
         end associate
      end do
   end function have_held_ways

   !> Displacement of each box at factor 1, 0 where it is held [m], (ndim, boxes).
   pure function scaled_units(self) result(units)
      class(constraints_t), intent(in) :: self
      real(dp) :: units(ndim, self%number())
      integer :: k
      do k = 1, size(units, 2)
         associate (motion => self%boxes(k)%motion)
            units(:, k) = merge(0.0_dp, motion%displacement, motion%history%held)
         end associate
      end do
   end function scaled_units

   !> Whether any box whose way is scaled has been moved at a time.
   pure logical function have_scaled_ways(self, time) result(have)
      class(constraints_t), intent(in) :: self
      real(dp), intent(in) :: time               !! [s]
      have = .false.
      if (self%number() > 0) have = any(any(abs(self%ways_at(time)) > 0, dim=1) .and. .not. self%boxes%motion%history%held)
   end function have_scaled_ways

   !> Prescribed displacement of box `k` at a time [m].
   pure function prescribed_of_box(self, k, time) result(u)
      class(constraints_t), intent(in) :: self
      integer, intent(in) :: k
      real(dp), intent(in) :: time               !! [s]
      real(dp) :: u(ndim)
      associate (motion => self%boxes(k)%motion)
         u = motion%displacement*motion%history%factor(time) + motion%velocity*motion%history%integral(time)
      end associate
   end function prescribed_of_box

   !> Set the fixed components of a nodal field to zero, except those that turn.
   pure subroutine hold(c, field)
      type(constraints_t), intent(in) :: c
      real(dp), intent(inout), contiguous :: field(:, :)  !! (ndim, n_points)
      integer :: k
      if (.not. allocated(c%node)) return
      do k = 1, size(c%node)
         if (allocated(c%turning)) then
            where (c%fixed(:, c%node(k)) .and. c%turning(:, c%node(k)) == 0) field(:, c%node(k)) = 0
         else
            where (c%fixed(:, c%node(k))) field(:, c%node(k)) = 0
         end if
      end do
   end subroutine hold
end module hampm_constraints
