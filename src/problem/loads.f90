!> Loads, the forces that act on material.
!>
!> A load is carried by points. Each point belongs to a particle, and stands at the material place X_p + dX, in space x_p + (I + H)
!> dX. Its force goes to the nodes of the particle's cell by their shape functions, extrapolated outside. So resultant and moment
!> are exact, a traction acts on the very edge of the body, no force is on a node without mass, and relative positions of load and
!> cells do not matter. A place equally near to several particles has a point on each of them: the first alone would break mirror
!> symmetry. `hampm_edge_loads` finds the points.
module hampm_loads
   use hampm_kinds, only: dp, ndim, corners
   use hampm_archive, only: archive_t
   use hampm_grid, only: grid_t
   use hampm_time_history, only: time_history_t
   use hampm_edge_parts, only: edge_part_t
   use hampm_particles, only: particles_t, spacing_of
   use hampm_place_table, only: place_table_t
   use hampm_turned_faces, only: cofactors_of, number_ends, place_of_end, n_ends
   use hampm_text, only: to_text
   use hampm_load_sharing, only: share_by_cell, share_by_corners
   implicit none
   private
   public :: load_t, load_on_particles, follow_sort, share_by_mass, place_loads, add_loads, &
             add_load, book_work, book_work_late, work_of_step, force_at_node, factors_at, largest_factors, all_become_constant, &
             time_to_constant_value, note_particles, archive_loads, turn_loads

   !> A load: its points, the particles on which they hang, and its history.
   type :: load_t
      integer :: number = 0                      !! of the load of the model of which it is the whole or a part
      real(dp) :: force(ndim) = 0                !! resultant of the whole load [N]
      type(time_history_t) :: history
      ! Of a load on edges, on faces along grid lines or at a point: `hampm_edge_loads` finds its points
      type(edge_part_t), allocatable :: edges(:) !! where it acts; `area`: part of the resultant [-], dashpots: area; else absent
      integer :: per_cell = 1                    !! points along a cell: as many as the densest body has particles
      real(dp), allocatable :: fraction(:)       !! part of the resultant at each point [-], (points)
      integer, allocatable :: particle(:)        !! particle to which each point belongs, (points)
      real(dp), allocatable :: offset(:, :)      !! dX of each point [m], (ndim, points)
      logical :: by_mass = .false.               !! whether it acts on all material in a box, else at the points
      real(dp) :: box(ndim, 2) = 0               !! corners of that [m]
      real(dp), allocatable :: half(:, :)        !! half of the segment, by mass of the rectangle, of which a point is the middle,
                                                 !! 0 for a mere point [m], (ndim, points)
      ! Of a pressure on the faces of a crack that cuts cells: `hampm_pressed_faces` finds its points
      integer :: line = 0                        !! number of the crack, 0 for other loads
      real(dp) :: pressure = 0                   !! [Pa]
      real(dp) :: into(ndim) = 0                 !! unit vector into the material on which it presses
      logical, allocatable :: follows(:)         !! of a pressure, by material: whether it follows the present faces, else
                                                 !! the initial ones; not allocated if all loads keep their direction
      integer :: absorbs = 0                     !! of dashpots (`hampm_absorbing_edges`): component of area times Z
                                                 !! at its points [kg/s]; 0 for other loads
      ! Its points in the grid at the last `place_loads`
      integer, allocatable :: node(:, :)         !! nodes of the cell of each point, with domains of the cells of
                                                 !! all corners of its particle; (nodes, points)
      real(dp), allocatable :: shape(:, :)       !! their shape functions there [-], as `node`
      real(dp), allocatable :: cofactor(:, :, :) !! of F at each point, allocated with `follows`: it maps normal times area [-]
      integer, allocatable :: ends(:, :)         !! ends of their segments or rectangles (`hampm_turned_faces`), (ends, points)
      ! Values of the step before for `book_work_late` [m/s]
      logical :: begun = .false.                 !! whether there was one
      real(dp) :: particle_velocity(ndim) = 0    !! of the particles after it, the mean by the parts of the load
      real(dp) :: guess(ndim) = 0                !! estimated velocity of the points
      real(dp), allocatable :: last_cofactor(:, :, :) !! at the start of that step
   contains
      procedure :: force_at
   end type load_t

contains

   !> A load shared by the particles by their mass within a box; each acts in the middle of the part of its rectangle in the box. In
   !> quadratic cells that the box cuts, where masses are weights of points for whole cells, they share it by the volumes of these
   !> parts, each with the mean of the functions over its part.
   pure subroutine load_on_particles(p, lower, upper, load, grid, fills)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the box [m]
      type(load_t), intent(inout) :: load
      type(grid_t), intent(in), optional :: grid
      logical, intent(in), optional :: fills(:)  !! by particle: whether it is of a lattice that fills its quadratic cell
      real(dp), parameter :: rounding = 1e-9_dp  ! part of a particle
      real(dp), allocatable :: part(:), middle(:, :), mass(:), half_of_part(:, :)
      real(dp) :: half(ndim), ends(ndim, 2)
      integer :: i, first
      allocate (part(p%n), middle(ndim, p%n))
      allocate (half_of_part(ndim, p%n), source=0.0_dp)
      mass = p%mass(:p%n)
      do i = 1, p%n
         half = spacing_of(p, i)/2
         ends(:, 1) = max(lower - p%reference(i, :), -half)
         ends(:, 2) = min(upper - p%reference(i, :), half)
         part(i) = product(max(ends(:, 2) - ends(:, 1), 0.0_dp)/(2*half))
         middle(:, i) = (ends(:, 1) + ends(:, 2))/2
         if (.not. present(fills)) cycle
         if (.not. fills(i) .or. part(i) <= rounding) cycle
         first = grid%first_of_piece(p%cell(i))
         associate (corner => grid%element_lower(:, first), edge => grid%leaf_size(first))
            if (all(corner >= lower - rounding*edge .and. corner + edge <= upper + rounding*edge)) cycle
         end associate
         half_of_part(:, i) = (ends(:, 2) - ends(:, 1))/2
         mass(i) = mass(i)/p%volume(i)*product(2*half)*p%thickness%at(p%reference(i, :) + middle(:, i))
      end do
      load%particle = pack([(i, i=1, p%n)], part > rounding)
      where (part > 1 - rounding) part = 1
      load%fraction = part(load%particle)*mass(load%particle)
      load%fraction = load%fraction/sum(load%fraction)
      load%offset = middle(:, load%particle)
      load%half = half_of_part(:, load%particle)
      load%by_mass = .true.
      load%box(:, 1) = lower
      load%box(:, 2) = upper
   end subroutine load_on_particles

   !> Note how the particles move, after points of a load have been found anew.
   subroutine note_particles(load, p)
      type(load_t), intent(inout) :: load
      type(particles_t), intent(in) :: p
      if (allocated(load%follows)) load%cofactor = cofactors_of(p, load%follows, load%particle)
      if (allocated(load%last_cofactor)) deallocate (load%last_cofactor)
      if (load%begun) load%particle_velocity = velocity_of_particles(load, p)
   end subroutine note_particles

   !> After a sort of the particles: follow them to their new places.
   subroutine follow_sort(loads, new_place)
      type(load_t), intent(inout) :: loads(:)
      integer, intent(in) :: new_place(:)        !! new places after the sort
      integer :: k
      do k = 1, size(loads)
         loads(k)%particle = new_place(loads(k)%particle)
      end do
   end subroutine follow_sort

   !> After particles or their masses have changed: share the loads on all material in proportion to these.
   pure subroutine share_by_mass(loads, p, grid, fills)
      type(load_t), intent(inout) :: loads(:)
      type(particles_t), intent(in) :: p
      type(grid_t), intent(in), optional :: grid
      logical, intent(in), optional :: fills(:)  !! as `load_on_particles`
      integer :: k
      do k = 1, size(loads)
         if (loads(k)%by_mass) call load_on_particles(p, loads(k)%box(:, 1), loads(k)%box(:, 2), loads(k), grid, fills)
      end do
   end subroutine share_by_mass

   !> Find where the points of the loads are in the grid, now that the particles are where they are.
   pure subroutine place_loads(loads, grid, p)
      type(load_t), intent(inout) :: loads(:)
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      integer :: l, k, n, nodes
      call turn_loads(loads, p)
      do l = 1, size(loads)
         associate (load => loads(l))
            n = size(load%particle)
            nodes = merge(corners**2, grid%n_functions, allocated(p%corner_velocity))
            if (allocated(load%node)) then
               if (any(shape(load%node) /= [nodes, n])) deallocate (load%node, load%shape)
            end if
            if (.not. allocated(load%node)) allocate (load%node(nodes, n), load%shape(nodes, n))
            if (.not. load%begun) load%particle_velocity = velocity_of_particles(load, p)
            load%begun = .true.
            do k = 1, n
               if (allocated(p%corner_velocity)) then
                  call share_by_corners(p, grid, load%particle(k), load%offset(:, k), load%node(:, k), load%shape(:, k))
               else
                  call share_by_cell(p, grid, load%particle(k), load%offset(:, k), load%half(:, k), load%by_mass, &
                                     load%node(:, k), load%shape(:, k))
               end if
            end do
         end associate
      end do
   end subroutine place_loads

   !> Turn pressures with their faces. If particles keep no cells the edges are between points that neighbours share: the pressure
   !> on a closed surface then has no resultant and no moment, for any F of the particles.
   pure subroutine turn_loads(loads, p)
      type(load_t), intent(inout) :: loads(:)
      type(particles_t), intent(in) :: p
      real(dp), allocatable :: place(:, :)       ! of the ends [m], (ndim, ends)
      integer :: l
      if (.not. any([(allocated(loads(l)%follows), l=1, size(loads))])) return
      if (.not. p%total_frame) call place_ends(loads, p, place)
      do l = 1, size(loads)
         associate (load => loads(l))
            if (.not. allocated(load%follows)) cycle
            if (allocated(load%ends) .and. .not. p%total_frame) then
               load%cofactor = cofactors_of(p, load%follows, load%particle, load%half, load%ends, place)
            else
               load%cofactor = cofactors_of(p, load%follows, load%particle)
            end if
         end associate
      end do
   end subroutine turn_loads

   !> Number the ends of the segments on which pressures act, unless they are, and find where they are.
   pure subroutine place_ends(loads, p, place)
      type(load_t), intent(inout) :: loads(:)
      type(particles_t), intent(in) :: p
      real(dp), allocatable, intent(out) :: place(:, :) !! [m], (ndim, ends)
      real(dp), parameter :: same = 1e-7_dp      ! of the distance between particles
      type(place_table_t) :: table
      integer, allocatable :: met(:)             ! how many points have each end
      integer :: l, k, c, n, status
      logical :: are_known
      are_known = all([(allocated(loads(l)%ends) .or. .not. is_edge(loads(l)), l=1, size(loads))])
      call table%reserve(64, status)
      do l = 1, size(loads)
         if (are_known .or. .not. is_edge(loads(l))) cycle
         associate (load => loads(l))
            if (allocated(load%ends)) deallocate (load%ends)
            allocate (load%ends(n_ends, size(load%particle)))
            do k = 1, size(load%particle)
               call number_ends(p, load%particle(k), load%offset(:, k), load%half(:, k), same*minval(p%spacing), table, &
                                load%ends(:, k))
            end do
         end associate
      end do
      n = 0
      do l = 1, size(loads)
         if (is_edge(loads(l))) n = max(n, maxval(loads(l)%ends))
      end do
      allocate (met(n))
      allocate (place(ndim, size(met)))
      met = 0
      place = 0
      do l = 1, size(loads)
         if (.not. is_edge(loads(l))) cycle
         associate (load => loads(l))
            do k = 1, size(load%particle)
               do c = 1, merge(n_ends, 0, load%ends(1, k) > 0)
                  associate (end => load%ends(c, k))
                     met(end) = met(end) + 1
                     place(:, end) = place(:, end) + place_of_end(p, load%particle(k), load%offset(:, k), load%half(:, k), c)
                  end associate
               end do
            end do
         end associate
      end do
      place = place/spread(met, 1, ndim)
   end subroutine place_ends

   !> Whether a load follows an edge of bodies: faces of cracks that have closed would share their ends.
   pure logical function is_edge(load)
      type(load_t), intent(in) :: load
      is_edge = allocated(load%follows) .and. load%line == 0
   end function is_edge

   !> Force at a point of a load whose factor is 1 [N].
   pure function force_at(self, k) result(force)
      class(load_t), intent(in) :: self
      integer, intent(in) :: k
      real(dp) :: force(ndim)
      force = self%fraction(k)*self%force
      if (allocated(self%cofactor)) force = matmul(self%cofactor(:, :, k), force)
   end function force_at

   !> Force on a node by the tractions on the material at one side of it, in the direction `toward` [N].
   pure function force_at_node(loads, factors, grid, p, node, toward) result(force)
      type(load_t), intent(in) :: loads(:)       !! as placed by `place_loads`
      real(dp), intent(in) :: factors(:)         !! by load [-]
      type(grid_t), intent(in) :: grid
      type(particles_t), intent(in) :: p
      integer, intent(in) :: node
      real(dp), intent(in) :: toward(ndim)
      real(dp) :: force(ndim)
      integer :: l, k
      force = 0
      do l = 1, size(loads)
         associate (load => loads(l))
            do k = 1, size(load%particle)
               if (.not. (any(load%node(:, k) == node) .and. any(abs(load%half(:, k)) > 0))) cycle
               if (dot_product(p%place_in_grid(load%particle(k)) - grid%node_position(:, node), toward) <= 0) cycle
               force = force + factors(l)*load%force_at(k) &
                               *sum(load%shape(:, k), mask=load%node(:, k) == node)
            end do
         end associate
      end do
   end function force_at_node

   !> Add the loads at a time, where `place_loads` has found them, to the nodal `force` [N].
   pure subroutine add_loads(loads, time, force)
      type(load_t), intent(in) :: loads(:)
      real(dp), intent(in) :: time               !! [s]
      real(dp), intent(inout), contiguous :: force(:, :)  !! (ndim, n_points)
      integer :: l
      do l = 1, size(loads)
         call add_load(loads(l), loads(l)%history%factor(time), force)
      end do
   end subroutine add_loads

   !> Add one load times a factor to the nodal `force` [N].
   pure subroutine add_load(load, factor, force)
      type(load_t), intent(in) :: load
      real(dp), intent(in) :: factor
      real(dp), intent(inout), contiguous :: force(:, :)  !! (ndim, n_points)
      real(dp) :: point_force(ndim)
      integer :: k, c
      do k = 1, size(load%particle)
         point_force = load%fraction(k)*factor*load%force
         if (allocated(load%cofactor)) point_force = factor*load%force_at(k)
         do c = 1, size(load%node, 1)
            associate (node => load%node(c, k))
               force(:, node) = force(:, node) + load%shape(c, k)*point_force
            end associate
         end do
      end do
   end subroutine add_load

   !> Add the work of the loads [J] from `time` to `time + dt`, in which the particles' velocities, mapped to the nodes, are
   !> `velocity`: mean force of both ends times dt times the velocity of the points, by the shape functions of the forces. It is of
   !> second order in dt, and equal to the gain of the particles' kinetic energy up to half a step at the ends
   !> (docs/explanation/energy_balance.md). Velocities that move particles are unsuitable: a node of little mass may have any.
   pure subroutine book_work(loads, p, time, dt, velocity, work)
      type(load_t), intent(inout) :: loads(:)    !! as placed by `place_loads` before the step
      type(particles_t), intent(in) :: p         !! after the step
      real(dp), intent(in) :: time, dt           !! [s]
      real(dp), intent(in) :: velocity(:, :)     !! (ndim, n_points)
      real(dp), intent(out) :: work
      real(dp) :: at_start(ndim, size(loads))
      integer :: l
      do l = 1, size(loads)
         at_start(:, l) = velocity_of_points(loads(l), velocity, loads(l)%cofactor)
      end do
      call turn_loads(loads, p)
      work = 0
      do l = 1, size(loads)
         work = work + work_over(loads(l), time, dt, at_start(:, l), velocity_of_points(loads(l), velocity, loads(l)%cofactor))
      end do
   end subroutine book_work

   !> The same if that velocity is known in the next step only. Added now: the work of the step before, from `time - last_dt` to
   !> `time`, less its estimate then, plus an estimate for this step, by the velocity of the step before and the gain of the
   !> particles. So errors of the estimate do not accumulate.
   pure subroutine book_work_late(loads, p, time, dt, last_dt, velocity, work)
      type(load_t), intent(inout) :: loads(:)    !! as placed by `place_loads` before the step
      type(particles_t), intent(in) :: p         !! after the step
      real(dp), intent(in) :: time, dt           !! [s]
      real(dp), intent(in) :: last_dt            !! 0 in the first step [s]
      real(dp), intent(in) :: velocity(:, :)     !! of the step before, (ndim, n_points)
      real(dp), intent(out) :: work
      real(dp) :: v(ndim), now(ndim)
      integer :: l
      work = 0
      do l = 1, size(loads)
         associate (load => loads(l))
            v = velocity_of_points(load, velocity, load%cofactor)
            if (allocated(load%last_cofactor)) then
               work = work + work_over(load, time - last_dt, last_dt, &
                                       velocity_of_points(load, velocity, load%last_cofactor) - load%guess, v - load%guess)
            else
               work = work + work_over(load, time - last_dt, last_dt, v - load%guess, v - load%guess)
            end if
            if (allocated(load%cofactor)) load%last_cofactor = load%cofactor
            now = velocity_of_particles(load, p)
            load%guess = v + (now - load%particle_velocity)
            load%particle_velocity = now
            work = work + work_over(load, time, dt, load%guess, load%guess)
         end associate
      end do
   end subroutine book_work_late

   !> Work of a load from `time` to `time + dt` at the points' velocity [J].
   pure real(dp) function work_over(load, time, dt, at_start, at_end)
      type(load_t), intent(in) :: load
      real(dp), intent(in) :: time, dt           !! [s]
      real(dp), intent(in) :: at_start(ndim), at_end(ndim) !! at which the first force has the power of each end [m/s]
      if (allocated(load%follows)) then
         work_over = 0.5_dp*dt*dot_product(load%force, load%history%factor(time)*at_start + load%history%factor(time + dt)*at_end)
      else
         work_over = 0.5_dp*(load%history%factor(time) + load%history%factor(time + dt))*dt*dot_product(load%force, at_start)
      end if
   end function work_over

   !> Work of the loads in the last step, each counted as if it put energy in [J]: a bound of the error of a step's work, as the
   !> forces at its two ends differ.
   pure real(dp) function work_of_step(loads, p, time, dt) result(work)
      type(load_t), intent(in) :: loads(:)
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: time               !! at the end of the step [s]
      real(dp), intent(in) :: dt                 !! [s]
      integer :: l
      work = 0
      do l = 1, size(loads)
         associate (history => loads(l)%history)
            work = work + max(abs(history%factor(time - dt)), abs(history%factor(time))) &
                   *abs(dot_product(loads(l)%force, velocity_of_particles(loads(l), p)))*dt
         end associate
      end do
   end function work_of_step

   !> The factors of loads at a time [-].
   pure function factors_at(loads, time) result(factors)
      type(load_t), intent(in) :: loads(:)
      real(dp), intent(in) :: time               !! [s]
      real(dp) :: factors(size(loads))
      integer :: l
      factors = [(loads(l)%history%factor(time), l=1, size(loads))]
   end function factors_at

   !> The factors of largest size that loads ever have [-].
   pure function largest_factors(loads) result(factors)
      type(load_t), intent(in) :: loads(:)
      real(dp) :: factors(size(loads))
      integer :: l
      factors = [(loads(l)%history%largest_factor(), l=1, size(loads))]
   end function largest_factors

   !> Whether every load becomes constant.
   pure logical function all_become_constant(loads)
      type(load_t), intent(in) :: loads(:)
      integer :: l
      all_become_constant = all([(loads(l)%history%time_to_constant() < huge(1.0_dp), l=1, size(loads))])
   end function all_become_constant

   !> Time from which all loads are constant, without those that never settle; 0 without any [s].
   pure real(dp) function time_to_constant_value(loads) result(time)
      type(load_t), intent(in) :: loads(:)
      integer :: l
      time = 0
      do l = 1, size(loads)
         if (all_become_constant(loads(l:l))) time = max(time, loads(l)%history%time_to_constant())
      end do
   end function time_to_constant_value

   !> Velocity of the particles of a load, the mean by its parts [m/s], as `velocity_of_points`.
   pure function velocity_of_particles(load, p) result(v)
      type(load_t), intent(in) :: load
      type(particles_t), intent(in) :: p
      real(dp) :: v(ndim)
      integer :: k
      v = 0
      do k = 1, size(load%particle)
         if (allocated(load%cofactor)) then
            v = v + load%fraction(k)*matmul(p%velocity(load%particle(k), :), load%cofactor(:, :, k))
         else
            v = v + load%fraction(k)*p%velocity(load%particle(k), :)
         end if
      end do
   end function velocity_of_particles

   !> Velocity of the points of a load, weighted by their parts of the load [m/s]; if it follows faces, the velocity along which
   !> these parts of its first force do the work of the present parts.
   pure function velocity_of_points(load, velocity, cofactor) result(v)
      type(load_t), intent(in) :: load
      real(dp), intent(in) :: velocity(:, :)     !! [m/s], (ndim, n_points)
      real(dp), intent(in), optional :: cofactor(:, :, :) !! of F at the points [-], (ndim, ndim, points)
      real(dp) :: v(ndim)
      integer :: k, c
      v = 0
      do k = 1, size(load%particle)
         do c = 1, size(load%node, 1)
            if (present(cofactor)) then
               v = v + load%fraction(k)*load%shape(c, k)*matmul(velocity(:, load%node(c, k)), cofactor(:, :, k))
            else
               v = v + load%fraction(k)*load%shape(c, k)*velocity(:, load%node(c, k))
            end if
         end do
      end do
   end function velocity_of_points

   !> Save or restore the particles that carry the loads, and data for their work.
   subroutine archive_loads(loads, archive)
      type(load_t), intent(inout) :: loads(:)
      class(archive_t), intent(inout) :: archive
      integer :: l, n
      logical :: turned
      do l = 1, size(loads)
         associate (load => loads(l))
            n = size(load%particle)
            call archive%section('load_'//to_text(l))
            call archive%serialise('points', n)
            if (archive%failure%failed()) return
            if (archive%is_read) then
               if (allocated(load%ends)) deallocate (load%ends) ! numbered anew
               deallocate (load%fraction, load%particle, load%offset, load%half)
               allocate (load%fraction(n), load%particle(n), load%offset(ndim, n), load%half(ndim, n))
            end if
            call archive%archive_reals('fraction', n, load%fraction)
            call archive%archive_integers('host', n, load%particle)
            call archive%archive_reals('offset', size(load%offset), load%offset)
            call archive%archive_reals('half', size(load%half), load%half)
            call archive%serialise('begun', load%begun)
            call archive%archive_reals('host_velocity', ndim, load%particle_velocity)
            call archive%archive_reals('guess', ndim, load%guess)
            if (.not. allocated(load%follows)) cycle
            turned = allocated(load%last_cofactor)
            call archive%serialise('turned', turned)
            if (turned .and. archive%is_read) allocate (load%last_cofactor(ndim, ndim, n))
            if (turned) call archive%archive_reals('last_cofactor', size(load%last_cofactor), load%last_cofactor)
         end associate
      end do
   end subroutine archive_loads
end module hampm_loads
