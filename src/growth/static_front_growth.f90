!> Static growth of fronts of plane cracks, of solids only: the advance of each front point in a load step. A point is the middle of
!> a hat function of `hampm_front_values`; after each load step the points are evenly spaced along the front again.
!>
!> By toughness G is, to first order, the toughness along all moving points, and below it elsewhere. With r, the present G over the
!> toughness, and the operator A of a straight front, whose G falls as dG/G = -|k| da for an advance da = cos(k s) (Rice, J. Appl.
!> Mech. 52 (1985) 571), advances are the least w >= 0 with
!>
!>    r (1 - A w) <= t,        w = 0 where that is less,
!>
!> and t such that the largest is an increment; loads are scaled afterwards. Errors of A show in r and are corrected in the next
!> load step. In load cycles advances are proportional to expected rates; front waves shorter than increments then do not grow.
module hampm_static_front_growth
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_crack_placement, only: body_at, finest_cell, distance_to_loads, least_radius, way_to_toughness
   use hampm_cracks, only: cracks_t
   use hampm_fatigue, only: advances_of, errors_of_rates, rates_of, way_error
   use hampm_front, only: front_t, region_t
   use hampm_front_values, only: front_values_t, part_along, between_hats, parts_of, place_hats
   use hampm_growing, only: by_cycles, by_time, front_ahead, growing_t, next_t, add_once
   use hampm_lapack, only: dposv
   use hampm_law, only: value_of
   use hampm_load_search, only: nothing
   use hampm_model, only: model_t
   use hampm_moving_front, only: advance_region, fronts_of
   use hampm_outline, only: wall_t
   use hampm_history, only: history_t
   use hampm_text, only: to_text
   implicit none
   private
   public :: advance_points, at_points, even_out_points, record_points

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: floor_of_fall = 0.1_dp !! -dG/G for a uniform advance over the front length, no mode of A [-]

   integer, parameter :: a_side = 1, a_wall = 2, a_crack = 3 !! boundaries that a front may meet
   character(*), parameter :: has_met(3) = [character(26) :: 'met a side', 'come to the wall of a hole', 'come to another crack']
   real(dp), parameter :: to_walls = 3           !! finest cells: the largest of the least domains of fronts that grow

   !> A of a front.
   type :: fall_t
      real(dp), allocatable :: of(:, :)          !! [1/m], (points, points)
      real(dp), allocatable :: part(:)           !! of the front at each point [-]
      real(dp) :: least = 0                      !! of a way of the whole front, by toughness [1/m]
      integer :: before = 0                      !! points of the fronts before it
   end type fall_t

contains

   !> Advance fronts by the advances of their points. `have_moved`: any has.
   subroutine advance_points(growing, model, next, fronts, cracks, have_moved, message)
      type(growing_t), intent(inout) :: growing
      type(model_t), intent(in) :: model
      type(next_t), intent(in) :: next(:)        !! of all points
      type(front_values_t), intent(in) :: fronts(:)
      type(cracks_t), intent(inout) :: cracks
      logical, intent(out) :: have_moved
      character(:), allocatable, intent(inout) :: message
      type(cracks_t) :: before_it
      real(dp) :: way(size(growing%points)), to_seam(size(growing%points))
      real(dp), allocatable :: of_nodes(:)
      logical :: meets_itself
      integer, allocatable :: have_met(:), of_crack(:)
      integer :: c, f, i, n, before
      to_seam = [(ways_to_seam(fronts(f)%at, fronts(f)%outward), f=1, size(fronts))]
      call find_advances(growing, model, next, fronts, to_seam, way, message)
      have_moved = any(way > 0)
      growing%points%advance = 0
      growing%points%has_come = way >= to_seam
      if (.not. have_moved) return
      call record_advances(growing, fronts, way)
      do c = 1, size(cracks%regions)
         before = 0
         of_nodes = [real(dp) ::]
         do f = 1, size(fronts)
            n = size(fronts(f)%arc)
            if (cracks%fronts(f)%crack == c) then
               of_nodes = [of_nodes, min(ways_to_seam(cracks%fronts(f)%at, cracks%fronts(f)%outward), &
                  [(between_hats(way(before + 1:before + n), fronts(f)%domain%front%is_closed, &
                                 cracks%fronts(f)%arc(i)/(fronts(f)%arc(2) - fronts(f)%arc(1))), i=1, cracks%fronts(f)%n())])]
            end if
            before = before + n
         end do
         if (.not. any(of_nodes > 0)) cycle
         of_crack = pack([(f, f=1, size(cracks%fronts))], cracks%fronts%crack == c)
         call reach_sides(cracks%regions(c), cracks%fronts(of_crack), &
                          maxval([to_walls*finest_cell(model), model%energy_release%radii]), of_nodes, have_met)
         do i = 1, size(of_crack)
            if (have_met(i) > 0) call add_once(message, name_of(of_crack(i))//' has '//trim(has_met(have_met(i)))// &
                                               ', and ends there as far as it goes on')
         end do
         before_it = cracks
         call advance_region(cracks%regions(c), cracks%fronts(of_crack), of_nodes, meets_itself)
         if (.not. meets_itself) call fronts_of(cracks%regions, cracks%fronts)
         if (meets_itself) then
            call stop_fronts('it would meet itself')
         else if (.not. all([(has_room(f), f=1, size(cracks%fronts))])) then
            cracks = before_it
            call stop_fronts('a step further it has less than two of the finest cells to another front or '// &
                             'less than six to a load, or two to a hole beside its plane')
         else
            call end_fronts
         end if
      end do
      do f = size(fronts) + 1, size(cracks%fronts)
         call place_points(growing, f, cracks%fronts(f))
      end do
      have_moved = any(growing%points%advance > 0)

   contains

      !> Ways of places along a front to a body of another toughness: huge beyond the longest increment, and from within what a
      !> front is beside a seam at which it has come [m].
      pure function ways_to_seam(at, outward) result(ways)
         real(dp), intent(in) :: at(:, :), outward(:, :)
         real(dp) :: ways(size(at, 2))
         integer :: j
         ways = [(way_to_toughness(model, at(:, j), outward(:, j), maxval(model%growth%increment)), j=1, size(ways))]
         where (ways <= front_ahead*finest_cell(model)) ways = huge(ways)
      end function ways_to_seam

      !> A front in words.
      function name_of(number) result(name)
         integer, intent(in) :: number
         character(:), allocatable :: name
         name = 'front '//to_text(number)
      end function name_of

      !> Whether a front is inside of the material, with room for the integrals around it.
      logical function has_room(number)
         integer, intent(in) :: number
         real(dp), parameter :: least = 2, to_loads = 6 ! finest cells
         integer :: node, other
         has_room = .true.
         associate (front => cracks%fronts(number))
            if (front%crack /= c) return
            do other = 1, size(cracks%fronts)
               if (other == number .or. cracks%fronts(other)%axis /= front%axis) cycle
               do node = 1, cracks%fronts(other)%n()
                  has_room = has_room .and. all(sum((front%at - spread(cracks%fronts(other)%at(:, node), 2, front%n()))**2, dim=1) &
                                                >= (least*finest_cell(model))**2)
               end do
            end do
            do node = 1, front%n()
               has_room = has_room .and. body_at(model, front%at(:, node)) > 0 &
                          .and. distance_to_loads(model, front%at(:, node)) >= to_loads*finest_cell(model)
            end do
            do other = 1, size(cracks%regions(c)%walls) ! the front ends at holes in the plane
               associate (wall => cracks%regions(c)%walls(other))
                  if (wall%is_hole .and. size(wall%section(front%axis, front%plane)) == 0) has_room = has_room .and. &
                     all([(wall%distance(front%at(:, node)) >= least_radius(model), node=1, front%n())])
               end associate
            end do
         end associate
      end function has_room

      !> Numbers of the points of a front.
      pure function points_of(number) result(points)
         integer, intent(in) :: number
         integer, allocatable :: points(:)
         integer :: k
         points = pack([(k, k=1, size(growing%points))], growing%points%front == number)
      end function points_of

      !> Stop fronts of the crack permanently.
      subroutine stop_fronts(why)
         character(*), intent(in) :: why
         do i = 1, size(of_crack)
            if (cracks%fronts(of_crack(i))%n() > 0) &
               call growing%stop_points(points_of(of_crack(i)), why, message, name_of(of_crack(i)))
         end do
      end subroutine stop_fronts

      !> Find which fronts of the crack have ended, and which are new.
      subroutine end_fronts
         character(:), allocatable :: how
         logical :: is_left
         is_left = any([(cracks%fronts(f)%crack == c .and. cracks%fronts(f)%n() > 0, f=1, size(cracks%fronts))])
         do i = 1, size(of_crack)
            if (cracks%fronts(of_crack(i))%n() > 0 .or. before_it%fronts(of_crack(i))%n() == 0) cycle
            how = 'has run through all of the material'
            if (is_left) how = 'has run through, or become part of another'
            if (have_met(i) == a_wall) how = 'has come to holes with all of its length, and has ended'
            if (have_met(i) == a_crack) how = 'has come to another crack, and has ended'
            call growing%stop_points(points_of(of_crack(i)), how, message, name_of(of_crack(i)), have_ended=.true.)
         end do
         do f = size(before_it%fronts) + 1, size(cracks%fronts)
            call add_once(message, name_of(f)//' is new, where another has divided, and is in no column')
         end do
      end subroutine end_fronts
   end subroutine advance_points

   !> Give a new front its points, as copies of the nearest ones; they share the earlier length of these.
   subroutine place_points(growing, number, front)
      type(growing_t), intent(inout) :: growing
      integer, intent(in) :: number              !! of the front
      type(front_t), intent(in) :: front
      type(front_values_t) :: values
      real(dp) :: away(size(growing%points))       ! [m]
      integer, allocatable :: like(:)
      integer :: before, j, k
      call place_hats(front, .true., 0, values)
      before = size(away)
      allocate (like(size(values%arc)))
      do j = 1, size(like)
         away = [(norm(growing%points(k)%place - values%at(:, j)), k=1, before)]
         like(j) = minloc(away, dim=1)
      end do
      call growing%add_points(like)
      do j = 1, size(like)
         growing%points(before + j)%place = values%at(:, j)
      end do
      growing%points(before + 1:)%front = number
      growing%points(before + 1:)%width = 0
   end subroutine place_points

   !> Move nodes beyond a side if they would be too near to it for cells to resolve the rest, or too near to the wall of a hole that
   !> would lie in their domains.
   pure subroutine reach_sides(region, fronts, near_walls, ways, have_met)
      type(region_t), intent(in) :: region
      type(front_t), intent(in) :: fronts(:)
      real(dp), intent(in) :: near_walls         !! [m]
      real(dp), intent(inout) :: ways(:)         !! of the nodes of all fronts, one after another [m]
      integer, allocatable, intent(out) :: have_met(:) !! contacts of nodes of each front: a side, the wall of a hole, or 0
      real(dp), parameter :: near = 1.5_dp, beyond = 1 ! cells
      real(dp), parameter :: slanted = 0.5_dp
      real(dp), parameter :: inside = 1e-6_dp    ! cells
      type(wall_t), allocatable :: walls(:)
      integer :: f, i, k, d, w
      real(dp) :: way, chord
      k = 0
      walls = region%all_walls()
      allocate (have_met(size(fronts)), source=0)
      do f = 1, size(fronts)
         do i = 1, fronts(f)%n()
            k = k + 1
            do d = 1, ndim
               associate (out => fronts(f)%outward(d, i))
                  if (abs(out) < slanted) cycle
                  way = (merge(region%upper(d), region%lower(d), out > 0) - fronts(f)%at(d, i))/out
                  if (way - ways(k) >= near*region%spacing) cycle
                  ways(k) = max(ways(k), way + beyond*region%spacing)
                  have_met(f) = a_side
               end associate
            end do
            do w = 1, size(walls)
               associate (wall => walls(w), at => fronts(f)%at(:, i), out => fronts(f)%outward(:, i))
                  if (.not. (wall%is_hole .or. wall%is_circle)) cycle
                  way = wall%way_to(at, out)
                  if (way - ways(k) >= near_walls) cycle
                  if (abs(dot_product(wall%normal_at(at + way*out), out)) < slanted) cycle
                  if ((dot_product(wall%normal_at(at + way*out), out) > 0) .eqv. wall%is_hole) cycle
                  chord = huge(chord)
                  if (wall%is_hole) chord = wall%way_to(at + (way + inside*region%spacing)*out, out)
                  ways(k) = max(ways(k), way + min(beyond*region%spacing, chord/2))
                  if (wall%is_hole) ways(k) = min(ways(k), way + chord/2) ! not to behind it
                  have_met(f) = merge(merge(a_crack, a_wall, w > size(region%walls)), a_side, wall%is_hole)
               end associate
            end do
         end do
      end do
   end subroutine reach_sides

   !> Find the way of each point in the next load step, which ends where another toughness begins [m].
   subroutine find_advances(growing, model, next, fronts, to_seam, way, message)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(next_t), intent(in) :: next(:)        !! of all points
      type(front_values_t), intent(in) :: fronts(:)
      real(dp), intent(in) :: to_seam(:)         !! of each point [m]
      real(dp), intent(out) :: way(:)
      character(:), allocatable, intent(inout) :: message
      real(dp), parameter :: reached = 1 - 1e-4_dp ! part of the toughness
      integer, parameter :: turns = 50
      type(fall_t) :: fall(size(fronts))
      real(dp), dimension(size(growing%points)) :: ratio, increment
      logical :: grows(size(growing%points))
      real(dp) :: low, high
      integer :: f, k
      k = 0
      do f = 1, size(fronts)
         fall(f) = fall_t(fall_of(fronts(f)), parts_of(fronts(f)), floor_of_fall/fronts(f)%domain%front%length, k)
         k = k + size(fronts(f)%arc)
      end do
      grows = [(growing%is_growing(k), k=1, size(way))]
      if (growing%has_rates) then
         way = advances_of(growing%fatigue, model, grows, 0*way)
         do f = 1, size(fronts)
            call slow_down(fall(f))
         end do
         way = min(way, to_seam)
         return
      end if
      ratio = 0
      where (grows .and. next%hindrance == 0) ratio = next%rate/next%toughness
      way = 0
      high = maxval(ratio)
      k = findloc(grows .and. next%hindrance > 0 .and. next%rate > merge(reached*next%toughness, 0*ratio, growing%hold_still), &
                  .true., dim=1)
      if (.not. high > nothing .and. k > 0) then
         call growing%warn_of_waiting(k, next(k)%hindrance, message)
      else if (growing%have_no_load .and. high < reached) then
         call growing%warn_of_waiting(1, 0, message)
      end if
      if (.not. high > nothing .or. (growing%hold_still .or. growing%have_no_load) .and. high < reached) return
      increment = huge(low)
      where (grows) increment = growing%part*model%growth(max(1, growing%points%law))%increment
      low = 0
      do k = 1, turns
         way = advances_with((low + high)/2)
         if (any(way > increment)) then
            low = (low + high)/2
         else
            high = (low + high)/2
         end if
      end do
      way = advances_with(high)

   contains

      !> The least ways with which no ratio is more than that.
      function advances_with(most) result(way)
         real(dp), intent(in) :: most
         real(dp) :: way(size(ratio))
         integer :: f
         do f = 1, size(fall)
            associate (first => fall(f)%before + 1, last => fall(f)%before + size(fall(f)%of, 1))
               way(first:last) = least_advances(fall(f), 1 - most/max(ratio(first:last), nothing), to_seam(first:last))
            end associate
         end do
      end function advances_with

      !> Take for the ways in cycles the rates that points will have with them, K**m.
      subroutine slow_down(fall)
         type(fall_t), intent(in) :: fall
         real(dp) :: matrix(size(fall%of, 1), size(fall%of, 1)), right(size(fall%of, 1)), exponent
         integer :: i, info
         associate (to => way(fall%before + 1:fall%before + size(right)))
            if (.not. any(to > 0)) return
            exponent = value_of(model%growth(growing%points(fall%before + 1)%law)%constants, 'rate_exponent', 0.0_dp)/2
            matrix = exponent*spread(fall%part, 2, size(right))*fall%of
            right = fall%part
            do i = 1, size(right)
               if (to(i) > 0) then
                  matrix(i, i) = matrix(i, i) + right(i)/to(i)
               else
                  matrix(:, i) = 0
                  matrix(i, :) = 0
                  matrix(i, i) = 1
                  right(i) = 0
               end if
            end do
            call dposv('U', size(right), 1, matrix, size(right), right, size(right), info)
            if (info == 0) to = right
         end associate
      end subroutine slow_down
   end subroutine find_advances

   !> The least w >= 0 with A w >= g, equal where w > 0, or as far as w may be: A has no positive elements off its diagonal, so that
   !> points are released, held or stopped from iteration to iteration.
   pure function least_advances(fall, g, most) result(w)
      type(fall_t), intent(in) :: fall
      real(dp), intent(in) :: g(:), most(:)      !! [-], [m]
      real(dp) :: w(size(g)), matrix(size(g), size(g)), fixed(size(g))
      logical :: moves(size(g)), before(size(g))
      integer :: turn, i, info
      moves = g > 0
      fixed = 0
      do turn = 1, 2*size(g) + 1
         w = merge(fall%part*(g - matmul(fall%of, fixed)), fixed, moves)
         matrix = spread(fall%part, 2, size(g))*fall%of
         do i = 1, size(g)
            matrix(i, i) = matrix(i, i) + fall%part(i)*fall%least
            if (moves(i)) cycle
            matrix(i, :) = 0
            matrix(:, i) = 0
            matrix(i, i) = 1
         end do
         call dposv('U', size(g), 1, matrix, size(g), w, size(g), info)
         before = moves
         associate (rest => g - matmul(fall%of, w) - fall%least*w)
            moves = merge(w > 0 .and. w < most, merge(rest < -1e-12_dp, rest > 1e-12_dp, fixed > 0), before)
         end associate
         fixed = merge(0.0_dp, merge(most, fixed, before .and. w >= most), moves .or. w <= 0)
         if (all(moves .eqv. before)) exit
      end do
      w = max(w, 0.0_dp)
   end function least_advances

   !> A of a front for advances that are cosine sums. An open front is continued by its mirror image.
   pure function fall_of(front) result(a)
      type(front_values_t), intent(in) :: front
      real(dp) :: a(size(front%arc), size(front%arc)), around, of_way
      integer :: n, m, i, j
      n = size(front%arc)
      m = merge(n, 2*(n - 1), front%domain%front%is_closed)
      around = front%domain%front%length*merge(1, 2, front%domain%front%is_closed)
      a = 0
      do i = 1, n
         do j = 1, m - 1, 2                      ! to all points at an odd distance
            of_way = 2*pi/(m*around*sin(pi*j/m)**2)
            associate (other => modulo(i - 1 + j, m) + 1)
               a(i, i) = a(i, i) + of_way
               a(i, merge(other, m + 2 - other, other <= n)) = a(i, merge(other, m + 2 - other, other <= n)) - of_way
            end associate
         end do
      end do
   end function fall_of

   !> Record the advances of all points, and their new places.
   pure subroutine record_advances(growing, fronts, way)
      type(growing_t), intent(inout) :: growing
      type(front_values_t), intent(in) :: fronts(:)
      real(dp), intent(in) :: way(:)             !! [m]
      integer :: f, j, k
      growing%points%advance = way
      k = 0
      do f = 1, size(fronts)
         do j = 1, size(fronts(f)%arc)
            k = k + 1
            growing%points(k)%place = fronts(f)%at(:, j) + way(k)*fronts(f)%outward(:, j)
         end do
      end do
   end subroutine record_advances

   !> Values of hat functions at the new places of the points.
   pure function at_points(growing, fronts, values) result(at)
      type(growing_t), intent(in) :: growing
      type(front_values_t), intent(in) :: fronts(:)
      real(dp), intent(in) :: values(:, :)       !! (any, points)
      real(dp) :: at(size(values, 1), size(values, 2)), along(size(values, 2))
      integer :: f, j, i, before, n
      before = 0
      do f = 1, size(fronts)
         n = size(fronts(f)%arc)
         along(:n) = part_along(fronts(f), places_of(growing, before, n))
         do j = 1, n
            at(:, before + j) = [(between_hats(values(i, before + 1:before + n), fronts(f)%domain%front%is_closed, along(j)), &
                                  i=1, size(values, 1))]
         end do
         before = before + n
      end do
   end function at_points

   !> After a load step: transfer the data of the points to evenly spaced ones.
   pure subroutine even_out_points(growing, fronts, values)
      type(growing_t), intent(in) :: growing
      type(front_values_t), intent(in) :: fronts(:)
      real(dp), intent(inout) :: values(:)       !! of the points
      real(dp) :: old(size(values)), along(size(values)), ahead(size(values)), behind(size(values)), part
      integer :: f, i, n, before, first, second
      n = 0
      before = 0
      do f = 1, size(fronts)
         before = before + n
         n = size(fronts(f)%arc)
         if (fronts(f)%has_ended) cycle
         old(:n) = values(before + 1:before + n)
         along(:n) = part_along(fronts(f), places_of(growing, before, n))
         do i = 1, n
            behind(:n) = i - 1 - along(:n)
            ahead(:n) = -behind(:n)
            if (fronts(f)%domain%front%is_closed) behind(:n) = modulo(behind(:n), real(n, dp))
            if (fronts(f)%domain%front%is_closed) ahead(:n) = modulo(ahead(:n), real(n, dp))
            first = minloc(behind(:n), dim=1, mask=behind(:n) >= 0)
            second = minloc(ahead(:n), dim=1, mask=ahead(:n) >= 0)
            if (first == 0) first = second
            if (second == 0) second = first
            part = abs(behind(first)) + abs(ahead(second))
            if (part > 0) part = abs(behind(first))/part
            values(before + i) = old(first) + part*(old(second) - old(first))
         end do
      end do
   end subroutine even_out_points

   !> The new places of the points of a front.
   pure function places_of(growing, before, n) result(places)
      type(growing_t), intent(in) :: growing
      integer, intent(in) :: before, n           !! points before its first, and its own
      real(dp) :: places(ndim, n)
      integer :: j
      do j = 1, n
         places(:, j) = growing%points(before + j)%place
      end do
   end function places_of

   !> Record how a front stands.
   subroutine record_points(growing, model, next, cracks, fronts, number, has_reach, off_ways, history)
      type(growing_t), intent(in) :: growing
      type(model_t), intent(in) :: model
      type(next_t), intent(in) :: next(:)        !! of all points
      type(cracks_t), intent(in) :: cracks
      type(front_values_t), intent(in) :: fronts(:)
      integer, intent(in) :: number              !! of the front
      logical, intent(in) :: has_reach           !! whether ways follow a load frame and have these errors
      real(dp), intent(in) :: off_ways(:)        !! of all points then [m]
      type(history_t), intent(inout) :: history
      real(dp), dimension(size(growing%points)) :: speeds, off
      integer :: first, last, k
      last = sum([(size(fronts(first)%arc), first=1, number)])
      first = last - size(fronts(number)%arc) + 1
      if (.not. growing%points(first)%grows) return
      call history%record('crack_area', 'm2', 'area of the crack, in the box around all material', &
                          cracks%regions(fronts(number)%domain%front%crack)%cracked_area())
      call history%record_along_front('extension', 'm', 'way that the front has grown there', growing%points(first:last)%extension)
      if (growing%driver == by_cycles) return
      call history%record_along_front('toughness', 'J/m2', 'energy release rate at which the front grows there', &
                                      next(first:last)%toughness)
      if (.not. (growing%driver == by_time .or. has_reach)) return
      associate (fatigue => growing%fatigue, front => fronts(number))
         off = off_ways
         if (growing%driver == by_time) then
            speeds = rates_of(fatigue, model, fatigue%at, 1)
            off = way_error(fatigue, [(k, k=1, size(off))], speeds)
            call history%record_along_front('speed', 'm/s', 'speed at which the front grows there', speeds(first:last))
         end if
         call history%record('crack_area_error', 'm2', 'estimated error of crack_area at this time', &
                             front%domain%front%length*sum(parts_of(front)*off(first:last)))
         call history%record_along_front('extension_error', 'm', 'estimated error of extension', off(first:last))
         if (has_reach) return
         off = errors_of_rates(fatigue, model)
         call history%record_along_front('speed_error', 'm/s', 'estimated error of speed', off(first:last))
      end associate
   end subroutine record_points
end module hampm_static_front_growth
