!> Values measured along the front of a plane crack, and their results, of solids only.
!>
!> G and K are means over the domains. The estimated error of G has the range over domains, the difference from G of K, with which
!> cells have other errors, and the place error of the front in the cells. Where a front ends on a side, the field is not of plane
!> strain and K is undefined: the modes share G as at the next node. Values are means over hat functions: along a front on the
!> lattice over a cell to each side. Other fronts cut cells irregularly, in effect a polygon of the lattice: means over three cells
!> remove most of that.
module hampm_front_values
   use hampm_kinds, only: dp, ndim, corners
   use hampm_tensors, only: identity, norm, edge_of
   use hampm_archive, only: archive_t
   use hampm_estimated_errors, only: recent_t, pace_t, arrival_t, seen_speed_t, is_new_slot, add_recent, is_sample, needs_sample, &
                                     follow_speed, waves_of, archive_recent, archive_arrival, archive_seen
   use hampm_front, only: front_t, room_of
   use hampm_front_closure, only: closure_rates
   use hampm_front_integral, only: front_domain_t, front_modes, front_integrals, cell_at
   use hampm_forest, only: corner_offset
   use hampm_hat_errors, only: ends_t, lost_in_hats, scatter_along
   use hampm_history, only: history_t
   use hampm_loads, only: factors_at
   use hampm_material, only: are_of_one
   use hampm_moving_average, only: moving_average_t, archive_average
   use hampm_moving_tip, only: rayleigh_speed
   use hampm_nodal_state, only: nodal_state_t
   use hampm_openings, only: opening_at, look_for_arrival
   use hampm_problem, only: problem_t
   use hampm_snapshots, only: piece_t, add_field, vtk_line
   use hampm_text, only: to_text
   implicit none
   private
   public :: front_values_t, renew_front_values, archive_front_values, measure_front, find_scatter, look_at_front, &
             needs_front, record_front, mean_rate, front_fields, jumps_behind, part_along, between_hats, parts_of, place_hats, &
             lasting_error, sample_error, error_of_largest

   real(dp), parameter :: default_radii(3) = [4, 5, 6] !! cells
   real(dp), parameter :: of_room = 0.9_dp       !! part of the room that the largest takes

   !> Place error of the front in cells: where it runs with the lattice, the same all along, and where it crosses it. Where one that
   !> crosses it turns with the lattice it lies behind its slanted parts: K by interaction is too large by 0.16 to 0.26 cells over
   !> the radius of curvature, K by G by 0.06 to 0.13 of these. Both know what they differ by, and this part
   real(dp), parameter :: astray_along = 0.03_dp, astray_across = 0.07_dp, astray_in_turns = 0.13_dp
   real(dp), parameter :: least_part = 0.5_dp    !! of these radii, for growing fronts near sides, rounded: G is known, K less so
   real(dp), parameter :: cells_of_hats = 3      !! to each side, of fronts that do not run with the lattice
   logical, parameter :: no_odd(2) = .false.

   !> Last measured values, by hat function, with their errors.
   type :: measured_t
      real(dp), allocatable :: g(:), g_error(:)  !! [J/m2]
      real(dp), allocatable :: k(:, :), k_error(:, :) !! [Pa sqrt(m)], (modes, nodes)
      real(dp), allocatable :: closure(:, :), closure_error(:, :) !! G of each mode by closure [J/m2], (modes, nodes)
      real(dp) :: closure_mean_error(front_modes) = 0 !! of the means of these [J/m2]
      real(dp) :: mean_error = 0                 !! of the mean of G [J/m2]
      real(dp) :: k_mean_error(front_modes) = 0  !! of the means of K [Pa sqrt(m)]
      type(recent_t) :: of_mean                  !! recent means of G, in motion
      type(recent_t), allocatable :: of_hats(:)  !! the same by hat
      type(arrival_t) :: arrival                 !! of waves
      real(dp) :: toughness = 0                  !! to which the mean of G is equal as it runs; 0 where that is not so [J/m2]
      real(dp) :: speed = 0                      !! as it grows in motion, mean [m/s]
      type(seen_speed_t) :: seen                 !! that of which domains see waves
      real(dp) :: off = 0                        !! part of G by which it is off at a given speed: late waves, lumped masses [-]
      real(dp) :: way = 0, time = -1             !! of this speed so far, and up to when; below 0: not yet [m], [s]
      type(moving_average_t) :: average          !! of the mean of G over the last cells of this way
   end type measured_t

   !> That, and where it was measured.
   type, extends(measured_t) :: front_values_t
      type(front_domain_t) :: domain
      logical :: by_domain = .true., by_closure = .false. !! chosen estimators, of which the first gives G
      real(dp) :: room = 0                       !! around the front [m]
      logical :: has_ended = .false.             !! whether the crack has run through: there is no front any more
      integer, allocatable :: material(:)        !! number of the material at each hat
      logical :: is_free(2) = .false.            !! whether its ends are on sides that nothing holds
      logical :: is_odd(front_modes, 2) = .false. !! modes that symmetry excludes there
      real(dp), allocatable :: arc(:), at(:, :)  !! of the middles of the hats: way along the front, and place [m]
      real(dp), allocatable :: outward(:, :)     !! there, unit vectors out of the crack, (ndim, hats)
      real(dp), allocatable :: mean_of(:, :)     !! part of each node of the front in each hat, (hats, nodes)
      real(dp), allocatable :: of_g(:, :)        !! K of opening and of sliding, which have their parts of G [Pa sqrt(m)], (2, hats)
   contains
      procedure :: follow_growth
   end type front_values_t

contains

   !> Let values follow fronts: new fronts have none yet, the values of others stay with as many places of each until the next
   !> measurement; ended fronts have 0.
   pure subroutine renew_front_values(fronts, problem, names, radii, grows, values)
      type(front_t), intent(in) :: fronts(:)
      type(problem_t), intent(in) :: problem
      character(*), intent(in) :: names(:)       !! of estimators
      real(dp), intent(in) :: radii(:)           !! of domains [m]; empty: as many cells
      logical, intent(in) :: grows(:)            !! for each crack, whether its fronts may run across the lattice
      type(front_values_t), allocatable, intent(inout) :: values(:)
      type(front_values_t), allocatable :: old(:)
      logical :: is_old
      integer :: k, hats
      call move_alloc(values, old)
      allocate (values(max(size(fronts), size(old))))
      do k = 1, size(values)
         is_old = k <= size(old)
         if (is_old) values(k) = old(k)
         values(k)%has_ended = .true.
         if (k <= size(fronts)) values(k)%has_ended = fronts(k)%n() == 0
         if (values(k)%has_ended) then
            if (k <= size(fronts)) values(k)%domain%front%grid_plane_t = fronts(k)%grid_plane_t
            values(k)%measured_t = nothing_measured(size(values(k)%arc))
            cycle
         end if
         hats = 0
         if (is_old) hats = size(old(k)%arc)
         call new_front_values(fronts, k, problem, grows(fronts(k)%crack), hats, values(k))
         if (size(radii) > 0) values(k)%domain%radius = radii
         values(k)%by_domain = any(names == 'domain_integral')
         values(k)%by_closure = any(names == 'vcct')
         if (is_old) values(k)%measured_t = old(k)%measured_t
      end do
   end subroutine renew_front_values

   !> Zeros at a number of hat functions.
   pure type(measured_t) function nothing_measured(hats) result(measured)
      integer, intent(in) :: hats
      allocate (measured%g(hats), measured%g_error(hats), source=0.0_dp)
      allocate (measured%k(front_modes, hats), source=0.0_dp)
      allocate (measured%k_error, measured%closure, measured%closure_error, source=measured%k)
      allocate (measured%of_hats(hats))
   end function nothing_measured

   !> Save or restore the values along moving fronts.
   subroutine archive_front_values(values, archive)
      type(front_values_t), allocatable, intent(inout) :: values(:)
      class(archive_t), intent(inout) :: archive
      type(front_values_t), allocatable :: at_start(:)
      integer :: n, k, i, hats
      n = size(values)
      call archive%serialise('number', n)
      if (archive%failure%failed()) return
      if (archive%is_read) then
         call move_alloc(values, at_start)
         allocate (values(n))
         values(:min(n, size(at_start))) = at_start(:min(n, size(at_start))) ! values of ended fronts stay
      end if
      do k = 1, n
         hats = 0
         if (.not. archive%is_read) hats = size(values(k)%arc)
         call archive%section('front_values_'//to_text(k))
         call archive%serialise('hats', hats)
         call archive%serialise('is_closed', values(k)%domain%front%is_closed)
         if (archive%is_read) then
            if (k <= size(at_start)) deallocate (values(k)%arc, values(k)%at)
            allocate (values(k)%arc(hats), values(k)%at(ndim, hats))
            values(k)%measured_t = nothing_measured(hats)
         end if
         call archive%serialise('has_ended', values(k)%has_ended)
         call archive%serialise('mean_error', values(k)%mean_error)
         call archive%archive_reals('K_mean_error', front_modes, values(k)%k_mean_error)
         call archive%archive_reals('arc', hats, values(k)%arc)
         call archive%archive_reals('at', ndim*hats, values(k)%at)
         call archive%archive_reals('G', hats, values(k)%g)
         call archive%archive_reals('G_error', hats, values(k)%g_error)
         call archive%archive_reals('K', front_modes*hats, values(k)%k)
         call archive%archive_reals('K_error', front_modes*hats, values(k)%k_error)
         call archive%archive_reals('closure', front_modes*hats, values(k)%closure)
         call archive%archive_reals('closure_error', front_modes*hats, values(k)%closure_error)
         call archive%archive_reals('closure_mean_error', front_modes, values(k)%closure_mean_error)
         call archive_recent(values(k)%of_mean, 'mean', archive)
         call archive_arrival(values(k)%arrival, archive)
         call archive%serialise('speed', values(k)%speed)
         call archive_seen(values(k)%seen, archive)
         call archive%serialise('way', values(k)%way)
         call archive%serialise('time_of_way', values(k)%time)
         call archive_average(values(k)%average, 'average', archive)
         do i = 1, hats
            call archive_recent(values(k)%of_hats(i), 'hat_'//to_text(i), archive)
         end do
      end do
   end subroutine archive_front_values

   !> Nothing measured yet of one of the fronts.
   pure subroutine new_front_values(fronts, number, problem, grows, hats, values)
      type(front_t), intent(in) :: fronts(:)
      integer, intent(in) :: number
      type(problem_t), intent(in) :: problem
      logical, intent(in) :: grows
      integer, intent(in) :: hats                !! number of places; 0: as many as suit it
      type(front_values_t), intent(out) :: values
      real(dp) :: room
      integer :: i, node
      associate (front => fronts(number), domain => values%domain, p => problem%particles)
         call place_hats(front, grows, hats, values)
         values%measured_t = nothing_measured(size(values%arc))
         allocate (values%of_g(2, size(values%arc)), source=0.0_dp)
         domain%front = front
         domain%across = spread(identity(:, front%axis), 1, ndim)*spread(identity(:, front%axis), 2, ndim)
         domain%lower = minval(p%reference(:p%n, :), dim=1)
         domain%upper = maxval(p%reference(:p%n, :), dim=1)
         do i = 1, p%n                           ! particles are in the middle of their volume
            associate (half => edge_of(p%volume(i))/2)
               domain%lower = min(domain%lower, p%reference(i, :) - half)
               domain%upper = max(domain%upper, p%reference(i, :) + half)
            end associate
         end do
         if (.not. front%is_closed) then
            values%is_free = [(.not. any(held_at(domain, problem, i)), i=1, front%n(), front%n() - 1)]
            values%is_odd = reshape([(odd_modes(front, i, held_at(domain, problem, i)), i=1, front%n(), front%n() - 1)], &
                                    [front_modes, 2])
         end if
         values%room = room_of(fronts, number, domain%lower, domain%upper)
         i = front%n()/2 + 1                     ! the middle one, and the particle next to it
         i = minloc(sum((p%reference(:p%n, :) - spread(front%at(:, i), 1, p%n))**2, dim=2), dim=1)
         domain%material = p%material(i)
         values%material = spread(domain%material, 1, size(values%arc))
         room = values%room
         do i = 1, p%n                           ! domains have one material
            if (are_of_one(problem%materials, domain%material, p%material(i))) cycle
            room = min(room, sqrt(minval(sum((front%at - spread(p%reference(i, :), 2, front%n()))**2, dim=1))) &
                             - edge_of(p%volume(i)))
         end do
         domain%walls = problem%grid%planes(front%crack)%all_walls()
         do i = 1, size(domain%walls)            ! nor holes and other cracks, but those at which it ends
            associate (wall => domain%walls(i))
               if (wall%is_hole .and. .not. front%ends_at(wall)) &
                  room = min(room, minval([(wall%distance(front%at(:, node)), node=1, front%n())]))
            end associate
         end do
         domain%cell = problem%grid%finest_cell
         domain%radius = default_radii*min(cell_at(front, problem), of_room*max(room, 0.0_dp)/maxval(default_radii))
         if (grows) domain%radius = max(domain%radius, least_part*default_radii*cell_at(front, problem))
         associate (material => problem%materials(domain%material))
            domain%has_modes = material%linear .and. material%isotropic .and. .not. (material%has_history .or. material%is_graded())
         end associate
      end associate
   end subroutine new_front_values

   !> The axes of the plane of a crack along which constraints hold the side of the material at a node of its front.
   pure function held_at(domain, problem, node) result(held)
      type(front_domain_t), intent(in) :: domain
      type(problem_t), intent(in) :: problem
      integer, intent(in) :: node
      logical :: held(2)
      real(dp), parameter :: beside = 1e-6_dp    ! cells
      real(dp) :: x(ndim)
      integer :: d, k, e
      held = .false.
      associate (grid => problem%grid, front => domain%front)
         associate (near => beside*grid%finest_cell)
            x = min(max(front%at(:, node), domain%lower + near), domain%upper - near)
            x(front%axis) = front%plane + merge(near, -near, domain%upper(front%axis) - front%plane > 2*near)
            e = max(grid%element_at(x), 1)
            associate (nodes => grid%element_nodes(:, e))
               do k = 1, size(nodes)
                  if (nodes(k) > grid%n_nodes .or. .not. any(abs(grid%node_position(:, nodes(k)) - x) < 2*near &
                                                     .and. abs(front%at(:, node) - x) > near/2)) cycle
                  do d = 1, size(front%along)
                     held(d) = held(d) .or. problem%constraints%holds(nodes(k), front%along(d))
                  end do
               end do
            end associate
         end associate
      end associate
   end function held_at

   !> The modes that are odd across the side at an end of a front: III where it holds the motion along the front, a plane of
   !> symmetry; I and II where it holds that along the normal of the front alone, one of antisymmetry.
   pure function odd_modes(front, node, held) result(is_odd)
      type(front_t), intent(in) :: front
      integer, intent(in) :: node
      logical, intent(in) :: held(2)             !! along the axes of the plane
      logical :: is_odd(front_modes)
      associate (ahead => maxloc(abs(front%outward(front%along, node)), dim=1))
         is_odd = held(ahead) .and. .not. held(3 - ahead)
         is_odd(front_modes) = held(3 - ahead)
      end associate
   end function odd_modes

   !> Place the hats evenly along a front.
   pure subroutine place_hats(front, grows, hats, values)
      type(front_t), intent(in) :: front
      logical, intent(in) :: grows               !! whether it may run across the lattice
      integer, intent(in) :: hats                !! their number; 0: as many as suit it
      type(front_values_t), intent(inout) :: values
      real(dp) :: step, along
      integer :: parts, n, i, j, from, next
      parts = front%n() - merge(0, 1, front%is_closed)
      n = parts
      if (grows .or. .not. runs_with_lattice(front)) n = 4*max(1, nint(parts/(4*cells_of_hats)))
      if (grows .and. .not. front%is_closed) n = max(4, nint(parts/cells_of_hats))
      if (hats > 0) n = hats - merge(0, 1, front%is_closed)
      step = front%length/n
      allocate (values%arc(n + merge(0, 1, front%is_closed)))
      allocate (values%at(ndim, size(values%arc)), values%outward(ndim, size(values%arc)))
      allocate (values%mean_of(size(values%arc), front%n()))
      do j = 1, size(values%arc)
         values%arc(j) = (j - 1)*step
         along = real((j - 1)*parts, dp)/n
         from = min(int(along), parts - 1) + 1
         next = modulo(from, front%n()) + 1
         values%at(:, j) = front%at(:, from) + (along - from + 1)*(front%at(:, next) - front%at(:, from))
         values%outward(:, j) = front%outward(:, from) + (along - from + 1)*(front%outward(:, next) - front%outward(:, from))
         values%outward(:, j) = values%outward(:, j)/norm(values%outward(:, j))
         do i = 1, front%n()
            along = abs(front%arc(i) - values%arc(j))
            if (front%is_closed) along = min(along, front%length - along)
            values%mean_of(j, i) = max(1 - along/max(step, front%length/parts), 0.0_dp)*front%weight(i)
         end do
         values%mean_of(j, :) = values%mean_of(j, :)/sum(values%mean_of(j, :))
      end do
   end subroutine place_hats

   !> Measure.
   subroutine measure_front(problem, state, values)
      type(problem_t), intent(in) :: problem
      type(nodal_state_t), intent(in) :: state
      type(front_values_t), intent(inout) :: values
      real(dp), allocatable :: jumps(:, :)       ! [m]
      if (values%has_ended) return
      if (values%by_domain) call measure_domains(problem, state, values)
      if (values%by_closure) call measure_closure(problem, values)
      if (.not. (values%by_domain .and. values%domain%has_modes)) then ! of which only the size was found
         jumps = jumps_behind(problem, values)
         where (jumps(1, :) < 0) values%of_g(1, :) = -values%of_g(1, :)
      end if
      if (values%by_closure) where (values%of_g(1, :) < 0) values%closure(1, :) = -values%closure(1, :)
   end subroutine measure_front

   !> After a step in motion, follow how the points of the front grow.
   pure subroutine follow_growth(self, width, speed, toughness, time)
      class(front_values_t), intent(inout) :: self
      real(dp), intent(in) :: width(:), speed(:), toughness(:) !! by point [m], [m/s]; 0 if it does not run by it [J/m2]
      real(dp), intent(in) :: time               !! [s]
      self%toughness = 0
      self%speed = 0
      if (any(width > 0)) then
         self%speed = sum(width*speed)/sum(width)
         if (all(toughness > 0 .or. .not. width > 0)) self%toughness = sum(width*toughness)/sum(width) ! all of it runs
      end if
      if (self%time >= 0) self%way = self%way + self%speed*(time - self%time)
      self%time = time
   end subroutine follow_growth

   !> Find by what the last samples stray, in waves that cells cannot carry.
   pure subroutine find_scatter(problem, in_sets, values)
      type(problem_t), intent(in) :: problem
      logical, intent(in) :: in_sets             !! as in `pace_t`
      type(front_values_t), intent(inout) :: values
      type(pace_t) :: pace
      real(dp) :: unused
      if (values%has_ended) return
      pace = pace_of(problem, in_sets, values)
      if (problem%grid%planes(values%domain%front%crack)%moves) call follow_speed(values%seen, values%speed, &
         rayleigh_speed(problem%materials(values%domain%material)), values%toughness, problem%runs_lumped(), problem%state%time, &
         pace, is_sample(values%of_mean, problem%state%time, pace), values%off, unused)
      call add_recent(values%of_mean, problem%state%time, mean_rate(values), pace)
      call add_recent(values%of_hats, problem%state%time, values%g, pace)
      call values%average%follow(values%way, cell_at(values%domain%front, problem), &
                                 [mean_rate(values), lasting_error(values), values%of_mean%scatter])
      associate (part => merge(values%average%swing(cell_at(values%domain%front, problem)), 0.0_dp, values%speed > 0))
         values%of_mean%swing = part*abs(mean_rate(values))
         values%of_hats%swing = part*abs(values%g)
      end associate
   end subroutine find_scatter

   !> After a step, look whether a wave has arrived at a front.
   pure subroutine look_at_front(problem, in_sets, values)
      type(problem_t), intent(in) :: problem
      logical, intent(in) :: in_sets             !! as in `pace_t`
      type(front_values_t), intent(inout) :: values
      type(pace_t) :: pace
      real(dp), parameter :: beside = 0.237_dp   ! cells, by which no place is on an edge
      integer :: i, k
      if (values%has_ended .or. .not. in_sets) return
      pace = pace_of(problem, in_sets, values)
      if (.not. pace%in_sets) return
      if (.not. is_new_slot(values%arrival, problem%state%time, pace)) return
      associate (front => values%domain%front)
         call look_for_arrival(problem, reshape([((front%at(:, i) + beside*problem%grid%finest_cell*(2*corner_offset(k) - 1), &
                                                   k=1, corners), i=1, front%n())], [ndim, corners*front%n()]), &
                               pace, values%arrival)
      end associate
   end subroutine look_at_front

   !> Whether the errors of the next row need the present values along a front.
   pure logical function needs_front(problem, in_sets, values, next_row, dt)
      type(problem_t), intent(in) :: problem
      logical, intent(in) :: in_sets             !! as in `pace_t`
      type(front_values_t), intent(in) :: values
      real(dp), intent(in) :: next_row, dt       !! its time, and the step [s]
      needs_front = .false.
      if (values%has_ended) return
      needs_front = needs_sample(values%of_mean, problem%state%time, pace_of(problem, in_sets, values), next_row, dt)
      needs_front = needs_front .or. values%average%is_next(values%way, cell_at(values%domain%front, problem), &
                                                            values%speed*(next_row - problem%state%time))
   end function needs_front

   !> When samples are taken of a front.
   pure type(pace_t) function pace_of(problem, in_sets, values) result(pace)
      type(problem_t), intent(in) :: problem
      logical, intent(in) :: in_sets
      type(front_values_t), intent(in) :: values
      associate (moves => problem%grid%planes(values%domain%front%crack)%moves)
         pace%in_sets = in_sets .and. .not. moves
         if (moves) pace%cells = 1
      end associate
      pace%first = values%arrival%slot
      pace%waves = waves_of(cell_at(values%domain%front, problem), problem%materials(values%domain%material)%shear_wave_speed())
   end function pace_of

   !> Opening and sliding of the faces behind each hat [m], (modes, hats).
   function jumps_behind(problem, values) result(jumps)
      type(problem_t), intent(in) :: problem
      type(front_values_t), intent(in) :: values
      real(dp) :: jumps(2, size(values%arc))
      real(dp), parameter :: behind = 1.5_dp     ! cells
      real(dp) :: opening(ndim)
      real(dp), allocatable :: u(:, :)           ! displacements of nodes, where known
      integer :: j
      associate (front => values%domain%front)
         do j = 1, size(values%arc)
            opening = opening_at(values%domain, values%at(:, j) - behind*cell_at(front, problem)*values%outward(:, j), problem, u)
            jumps(:, j) = [opening(front%axis), 0.0_dp]
            if (.not. front%is_symmetry) jumps(2, j) = norm(opening(front%along))
         end do
      end associate
   end function jumps_behind

   !> By closure. The crack is closed by one cell. The difference from closing two is the first-order error of the cells.
   subroutine measure_closure(problem, values)
      type(problem_t), intent(in) :: problem
      type(front_values_t), intent(inout) :: values
      real(dp), allocatable :: rate(:, :, :), twice(:, :)
      real(dp) :: off(size(values%arc))          ! from the domain integral
      integer :: mode, i
      call closure_rates(values%domain, problem, rate)
      allocate (twice, source=values%closure)
      do mode = 1, front_modes
         values%closure(mode, :) = matmul(values%mean_of, rate(mode, :, 1))
         twice(mode, :) = matmul(values%mean_of, rate(mode, :, 2))
      end do
      if (.not. values%by_domain) then
         values%g = sum(values%closure, dim=1)
         do i = 1, size(values%arc)
            associate (modulus => problem%materials(values%material(i))%plane_modulus(), rate => values%closure(:, i))
               values%of_g(:, i) = sqrt(modulus*max([rate(1), sum(rate(2:))], 0.0_dp))
            end associate
         end do
      end if
      off = abs(sum(values%closure, dim=1) - values%g)
      associate (part => parts_of(values), place => off_by_place(problem, values), of_mean => mean_off_by_place(problem, values))
         do mode = 1, front_modes
            associate (share => abs(values%closure(mode, :))/max(sum(abs(values%closure), dim=1), tiny(off)), &
                       difference => values%closure(mode, :) - twice(mode, :))
               values%closure_error(mode, :) = max(abs(difference), share*off) &
                                               + off_along(values, values%closure(mode, :), share*place, no_odd)
               values%closure_mean_error(mode) = max(abs(dot_product(part, difference)), abs(dot_product(part, share*( &
                                                 sum(values%closure, dim=1) - values%g)))) + dot_product(part, share)*of_mean
            end associate
         end do
      end associate
      if (values%by_domain) then
         values%g_error = max(values%g_error, off)
      else
         values%g_error = sum(values%closure_error, dim=1)
         values%mean_error = sum(values%closure_mean_error)
      end if
   end subroutine measure_closure

   !> Error of G by the place of the front of the cells: with G as the square of the least length around it, and at the end of a
   !> front, which on a side falls within a cell, by the difference from the next hat function [J/m2].
   pure function off_by_place(problem, values) result(off)
      type(problem_t), intent(in) :: problem
      type(front_values_t), intent(in) :: values
      real(dp) :: off(size(values%arc))
      associate (cell => cell_at(values%domain%front, problem), &
                 astray => merge(astray_along, astray_across, runs_with_lattice(values%domain%front)))
         off = abs(values%g)*2*(astray/max(values%room/cell, 1.0_dp) + astray_in_turns*min(cell*turns(values), 1.0_dp))
      end associate
      associate (g => values%g, n => size(off))
         off([1, n]) = off([1, n]) + merge(abs(g([1, n]) - g([2, n - 1])), 0.0_dp, values%is_free)
      end associate
   end function off_by_place

   !> Curvature at the hats of a front where it turns with the lattice that it crosses: they cross one row of cells at most [1/m].
   pure function turns(values)
      type(front_values_t), intent(in) :: values
      real(dp) :: turns(size(values%arc))
      real(dp), parameter :: rounding = 1e-9_dp  ! of the length of a front
      integer :: i, before, behind
      turns = 0
      associate (front => values%domain%front)
         if (runs_with_lattice(front)) return
         do i = 1, size(turns)
            if (minval(abs(values%outward(front%along, i))) >= 1/(2*cells_of_hats)) cycle
            before = max(1, count(front%arc < values%arc(i) - rounding*front%length))
            behind = min(front%n(), front%n() + 1 - count(front%arc > values%arc(i) + rounding*front%length))
            turns(i) = norm(front%outward(:, behind) - front%outward(:, before))/norm(front%at(:, behind) - front%at(:, before))
         end do
      end associate
   end function turns

   !> Error of values along a front by its place, at least their scatter where it crosses the lattice, and by what means over hats
   !> have lost.
   pure function off_along(values, of_hats, by_place, is_odd) result(off)
      type(front_values_t), intent(in) :: values
      real(dp), intent(in) :: of_hats(:)
      real(dp), intent(in) :: by_place(:)        !! in the unit of these
      logical, intent(in) :: is_odd(2)           !! whether the mirror images at held ends have the other sign
      real(dp) :: off(size(of_hats))
      off = by_place
      if (runs_with_lattice(values%domain%front)) return
      associate (ends => ends_t(values%domain%front%is_closed, .not. values%is_free, is_odd))
         off = max(off, scatter_along(of_hats, ends)) + lost_in_hats(of_hats, ends)
      end associate
   end function off_along

   !> Error of the mean of G by the place of the front: if it crosses the lattice the place is off in each row of cells
   !> independently, and the mean of n rows by 1/sqrt(n) of that [J/m2].
   pure real(dp) function mean_off_by_place(problem, values) result(off)
      type(problem_t), intent(in) :: problem
      type(front_values_t), intent(in) :: values
      real(dp) :: rows
      integer :: i, next
      off = dot_product(parts_of(values), off_by_place(problem, values))
      rows = 0
      associate (front => values%domain%front)
         do i = 1, front%n() - merge(0, 1, front%is_closed)
            next = modulo(i, front%n()) + 1
            associate (across => maxloc(abs(front%outward(:, i) + front%outward(:, next)), dim=1)) ! of either way along the front
               rows = rows + abs(front%at(across, next) - front%at(across, i))/cell_at(front, problem)
            end associate
         end do
      end associate
      off = off/sqrt(max(1.0_dp, rows))
   end function mean_off_by_place

   !> Whether a front is normal to an axis all along.
   pure logical function runs_with_lattice(front)
      type(front_t), intent(in) :: front
      runs_with_lattice = all(maxval(abs(front%outward), dim=1) > 1 - 1e-9_dp)
   end function runs_with_lattice

   !> By domain integrals.
   subroutine measure_domains(problem, state, values)
      type(problem_t), intent(in) :: problem
      type(nodal_state_t), intent(in) :: state
      type(front_values_t), intent(inout) :: values
      real(dp), allocatable :: g(:, :), k(:, :, :), beside(:, :), of_mode(:, :)
      logical, allocatable :: at_free_end(:, :)
      real(dp) :: of_k(size(values%arc))         ! G of K
      real(dp) :: part(size(values%arc)), of_hats(front_modes, size(values%arc)) ! K as means
      real(dp) :: sliding(size(values%arc))      ! K_II with the G of K_II and K_III
      integer :: mode
      values%domain%pressure = sum(factors_at(problem%loads, problem%state%time)*problem%loads%pressure, &
                                   mask=problem%loads%line == values%domain%front%crack)/(2*ndim) ! loads in all directions
      call front_integrals(values%domain, problem, state, g, k)
      part = parts_of(values)
      associate (front => values%domain%front, material => problem%materials(values%domain%material), radii => size(g, 2))
         values%mean_error = spread_of(matmul(front%weight, g)/front%length)
         beside = g
         if (.not. front%is_closed) then         ! modes at ends are as beside them, and on free sides share G so
            beside([1, front%n()], :) = g([2, front%n() - 1], :)
            do mode = 1, front_modes             ! which are 0 where symmetry excludes them: half a domain has flux of theirs
               if (values%is_odd(mode, 1)) k(mode, 1, :) = 0
               if (values%is_odd(mode, 2)) k(mode, front%n(), :) = 0
            end do
            k(:, [1, front%n()], :) = k(:, [2, front%n() - 1], :)
         end if
         beside = matmul(values%mean_of, beside)
         allocate (at_free_end(size(beside, 1), radii), source=.false.)
         if (values%is_free(1)) at_free_end(1, :) = .true.
         if (values%is_free(2)) at_free_end(size(beside, 1), :) = .true.
         g = matmul(values%mean_of, g)
         values%g = sum(g, dim=2)/radii
         values%g_error = maxval(g, dim=2) - minval(g, dim=2) &
                          + off_along(values, values%g, off_by_place(problem, values), no_odd)
         values%mean_error = values%mean_error + mean_off_by_place(problem, values)
         values%of_g(1, :) = sqrt(material%plane_modulus()*max(values%g, 0.0_dp))
         if (.not. values%domain%has_modes) return
         do mode = 1, front_modes
            of_mode = matmul(values%mean_of, k(mode, :, :))
            where (beside > 0 .and. at_free_end) of_mode = of_mode*sqrt(max(g, 0.0_dp)/beside)
            values%k_mean_error(mode) = spread_of(matmul(part, of_mode))
            of_hats(mode, :) = sum(of_mode, dim=2)/radii
            if (values%is_odd(mode, 1)) of_mode(1, :) = 0 ! at the place, G is of the half hat
            if (values%is_odd(mode, 2)) of_mode(size(part), :) = 0
            associate (place => off_by_place(problem, values))
               values%k(mode, :) = sum(of_mode, dim=2)/radii
               values%k_error(mode, :) = maxval(of_mode, dim=2) - minval(of_mode, dim=2) &
                                         + off_along(values, values%k(mode, :), abs(values%k(mode, :))*place &
                                                     /max(2*values%g, place, tiny(of_k)), values%is_odd(mode, :))
            end associate
         end do
         of_k = (sum(of_hats(:2, :)**2, dim=1)*(1 - material%poisson) + of_hats(3, :)**2)/(2*material%mu)
         associate (k_1 => of_hats(1, :), k_2 => of_hats(2, :), k_3 => of_hats(3, :), amount => values%of_g(1, :))
            sliding = sign(sqrt(k_2**2 + k_3**2/(1 - material%poisson)), merge(k_2, k_3, abs(k_2) >= abs(k_3)))
            amount = amount/max(sqrt(k_1**2 + sliding**2), tiny(1.0_dp))
            values%of_g(2, :) = amount*sliding
            values%of_g(1, :) = amount*k_1
         end associate
         values%g_error = values%g_error + abs(values%g - of_k)
         do mode = 1, front_modes
            where (of_k > 0) values%k_error(mode, :) = values%k_error(mode, :) &
                                                       + abs(values%k(mode, :))*abs(values%g - of_k)/(2*of_k)
            associate (of_mean => abs(dot_product(part, values%g - of_k)) + mean_off_by_place(problem, values), &
                       mean => abs(dot_product(part, values%g)))
               values%k_mean_error(mode) = values%k_mean_error(mode) &
                                           + dot_product(part, abs(values%k(mode, :)))*of_mean/max(2*mean, of_mean, tiny(mean))
            end associate
         end do
      end associate

   contains

      !> Largest less smallest value.
      pure real(dp) function spread_of(list)
         real(dp), intent(in) :: list(:)
         spread_of = maxval(list) - minval(list)
      end function spread_of
   end subroutine measure_domains

   !> Mean of G along the front [J/m2].
   pure real(dp) function mean_rate(values)
      type(front_values_t), intent(in) :: values
      mean_rate = dot_product(parts_of(values), values%g)
   end function mean_rate

   !> How many modes there are.
   pure integer function modes_of(values)
      type(front_values_t), intent(in) :: values
      modes_of = 0
      if (values%by_domain .and. values%domain%has_modes) modes_of = merge(1, front_modes, values%domain%front%is_symmetry)
   end function modes_of

   !> The present fronts, as lines between the middles of hat functions, with the number of the front, G and K: absent modes are 0.
   subroutine front_fields(fronts, output)
      type(front_values_t), intent(in) :: fronts(:)
      type(piece_t), intent(out) :: output
      real(dp), allocatable :: number(:), g(:), k(:, :)
      integer :: f, i, n, before, mode
      n = sum([(merge(0, size(fronts(f)%arc), fronts(f)%has_ended), f=1, size(fronts))])
      allocate (output%points(ndim, n), output%connectivity(0), number(n), g(n), k(front_modes, n))
      output%name = 'fronts'
      before = 0
      do f = 1, size(fronts)
         associate (front => fronts(f))
            if (front%has_ended) cycle
            n = size(front%arc)
            number(before + 1:before + n) = f
            output%points(:, before + 1:before + n) = front%at
            g(before + 1:before + n) = front%g
            k(:, before + 1:before + n) = front%k
            do i = 1, n - merge(0, 1, front%domain%front%is_closed)
               output%connectivity = [output%connectivity, before + i - 1, before + modulo(i, n)]
            end do
            before = before + n
         end associate
      end do
      output%offsets = [(i, i=0, size(output%connectivity), 2)]
      output%cell_types = spread(vtk_line, 1, size(output%connectivity)/2)
      call add_field(output%point_fields, 'front', reshape(number, [1, before]))
      call add_field(output%point_fields, 'G', reshape(g, [1, before]), 'J/m2')
      do mode = 1, maxval([(modes_of(fronts(f)), f=1, size(fronts))])
         call add_field(output%point_fields, 'K_'//repeat('I', mode), k(mode:mode, :), 'Pa m^0.5')
      end do
   end subroutine front_fields

   !> Position of each place along its front, at the nearest place of the front: in hat functions from the first on.
   pure function part_along(values, places) result(at)
      type(front_values_t), intent(in) :: values
      real(dp), intent(in) :: places(:, :)       !! [m], (ndim, any)
      real(dp) :: at(size(places, 2)), least, part, away
      integer :: i, k, next
      associate (front => values%domain%front)
         do i = 1, size(at)
            least = huge(least)
            do k = 1, front%n() - merge(0, 1, front%is_closed)
               next = modulo(k, front%n()) + 1
               associate (way => front%at(:, next) - front%at(:, k), from => places(:, i) - front%at(:, k))
                  part = min(max(dot_product(from, way)/sum(way**2), 0.0_dp), 1.0_dp)
                  away = norm(from - part*way)
                  if (away >= least) cycle
                  least = away
                  at(i) = front%arc(k) + part*(merge(front%arc(next), front%length, next > k) - front%arc(k))
                  at(i) = at(i)/(values%arc(2) - values%arc(1))
               end associate
            end do
         end do
      end associate
   end function part_along

   !> A value of hats at a place between them, by lines.
   pure real(dp) function between_hats(values, is_closed, along) result(value)
      real(dp), intent(in) :: values(:)          !! of all hats of a front
      logical, intent(in) :: is_closed           !! whether the last hat is followed by the first
      real(dp), intent(in) :: along              !! in hats from the first on
      integer :: k
      k = min(int(along), size(values) - merge(1, 2, is_closed))
      value = values(k + 1) + (along - k)*(values(modulo(k + 1, size(values)) + 1) - values(k + 1))
   end function between_hats

   !> Error of the mean of G without waves that cells cannot carry [J/m2]. By its law G is the toughness.
   pure real(dp) function lasting_error(values) result(error)
      type(front_values_t), intent(in) :: values
      error = max(values%mean_error, values%of_mean%change)
      if (values%toughness > 0) error = max(error, abs(mean_rate(values) - values%toughness))
      error = error + values%off*abs(mean_rate(values))
   end function lasting_error

   !> Error of a single sample of the mean of G [J/m2].
   pure real(dp) function sample_error(values) result(error)
      type(front_values_t), intent(in) :: values
      error = values%of_mean%with_waves(lasting_error(values))
   end function sample_error

   !> Error of the largest G along the front, which any place may have, by those of its places [J/m2].
   pure real(dp) function error_of_largest(values, errors) result(error)
      type(front_values_t), intent(in) :: values
      real(dp), intent(in) :: errors(:)          !! by hat [J/m2]
      error = max(maxval(values%g + errors) - maxval(values%g), maxval(values%g) - maxval(values%g - errors))
   end function error_of_largest

   !> The part of the front of each hat function.
   pure function parts_of(values) result(part)
      type(front_values_t), intent(in) :: values
      real(dp) :: part(size(values%arc))
      part = 1
      if (.not. values%domain%front%is_closed) part([1, size(part)]) = 0.5_dp
      part = part/sum(part)
   end function parts_of

   !> Record it: means in the history, and all values along the front.
   subroutine record_front(values, moves, history)
      type(front_values_t), intent(in) :: values
      logical, intent(in) :: moves               !! whether fronts of the run grow in motion
      type(history_t), intent(inout) :: history
      character(*), parameter :: closed = 'energy release rate, virtual crack closure'
      real(dp) :: part_of_modes(front_modes), of_hats(size(values%arc))
      integer :: d, last
      last = modes_of(values)
      of_hats = values%of_hats%with_waves(values%g_error + values%off*abs(values%g))
      part_of_modes = matmul(values%closure, parts_of(values))
      part_of_modes = part_of_modes/max(sum(abs(part_of_modes)), tiny(1.0_dp))
      history%is_of_none = values%has_ended
      call history%record('G_mean', 'J/m2', 'energy release rate, mean along the front', mean_rate(values))
      call history%record('G_mean_error', 'J/m2', 'estimated error of G_mean', sample_error(values))
      if (moves) call values%average%record(history)
      call history%record('G_largest', 'J/m2', 'largest energy release rate along the front', maxval(values%g))
      call history%record('G_largest_error', 'J/m2', 'estimated error of G_largest', error_of_largest(values, of_hats))
      call history%record_modes('K_', 'Pa m^0.5', 'stress intensity factor, mean along the front', &
                                matmul(values%k(:last, :), parts_of(values)))
      call history%record_modes('K_', 'Pa m^0.5', 'estimated error of that', values%k_mean_error(:last) &
                                + matmul(abs(values%k(:last, :)), parts_of(values))*values%of_mean%with_waves(0.0_dp) &
                                /max(2*mean_rate(values), values%of_mean%with_waves(0.0_dp), tiny(1.0_dp)), behind='_error')
      call history%record_along_front('arc', 'm', 'way along the front', values%arc)
      do d = 1, ndim
         call history%record_along_front('xyz'(d:d), 'm', 'place on the front', values%at(d, :))
      end do
      call history%record_along_front('G', 'J/m2', 'energy release rate', values%g)
      call history%record_along_front('G_error', 'J/m2', 'estimated error of it', of_hats)
      do d = 1, last
         associate (name => 'K_'//repeat('I', d))
            call history%record_along_front(name, 'Pa m^0.5', 'stress intensity factor, mode '//repeat('I', d), values%k(d, :))
            call history%record_along_front(name//'_error', 'Pa m^0.5', 'estimated error of it', values%k_error(d, :) + &
                                            abs(values%k(d, :))*(values%off/2 + values%of_hats%with_waves(0.0_dp) &
                                            /max(2*values%g, values%of_hats%with_waves(0.0_dp), tiny(1.0_dp))))
         end associate
      end do
      if (values%by_closure) then
         associate (modes => merge(1, front_modes, values%domain%front%is_symmetry))
            call history%record_modes('G_vcct_', 'J/m2', closed//', mean along the front', &
                                      matmul(values%closure(:modes, :), parts_of(values)))
            call history%record_modes('G_vcct_', 'J/m2', 'estimated error of that', values%closure_mean_error(:modes) + &
                                      values%of_mean%with_waves(0.0_dp)*abs(part_of_modes(:modes)), &
                                      behind='_error')
         end associate
         do d = 1, merge(1, front_modes, values%domain%front%is_symmetry)
            associate (name => 'G_vcct_'//repeat('I', d))
               call history%record_along_front(name, 'J/m2', closed//', mode '//repeat('I', d), values%closure(d, :))
               call history%record_along_front(name//'_error', 'J/m2', 'estimated error of it', values%closure_error(d, :) &
                                               + values%of_hats%with_waves(0.0_dp)*abs(values%closure(d, :)) &
                                               /max(sum(abs(values%closure), dim=1), tiny(1.0_dp)))
            end associate
         end do
      end if
      history%is_of_none = .false.
   end subroutine record_front
end module hampm_front_values
