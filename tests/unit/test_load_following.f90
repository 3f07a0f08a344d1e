!> Loads keep their resultant, their moment and their distribution while their particles split and recombine.
program test_load_following
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish, repeat_random_numbers
   use loading, only: load_on_points, load_on_parts
   use hampm_loads, only: load_t, load_on_particles, place_loads, add_loads, book_work
   use hampm_matching, only: adopt_forest
   use hampm_material, only: new_material
   use hampm_problem, only: problem_t, sort_anew
   use hampm_node_list, only: node_list_t
   use hampm_edge_parts, only: edge_part_t
   use hampm_samples, only: rectangle_t, place_bodies, start
   use hampm_particles, only: spacing_of
   use hampm_splitting, only: start_families
   use hampm_tensors, only: identity
   use hampm_text, only: to_text
   implicit none

   real(dp), parameter :: cell = 0.1_dp, force(ndim) = [3.0_dp, -7.0_dp]
   real(dp), parameter :: lower(ndim) = [0.3_dp, 0.3_dp], upper(ndim) = [0.7_dp, 0.5_dp], centre(ndim) = (lower + upper)/2
   integer, parameter :: points(ndim) = [8, 4]
   real(dp), parameter :: place_of_force(ndim) = [0.37_dp, 0.5_dp]
   real(dp), parameter :: rounding = 1.0e-13_dp
   integer, parameter :: traction = 1, at_point = 2, body = 3, deepest_tried = 3
   real(dp) :: shift(ndim)
   integer :: k

   call repeat_random_numbers()
   do k = 1, 5
      call random_number(shift)
      call loads_through_levels(cell*shift, .false.)
      call loads_through_levels(cell*shift, .true.)
   end do
   call pressure_around_an_arc()
   call random_meshes()
   call work_of_a_way()
   call finish()

contains

   !> A body with a traction on its right edge, a force at a place on its upper edge and a body force, on a grid that is shifted
   !> against it.
   subroutine place(shift, m)
      real(dp), intent(in) :: shift(ndim)
      type(problem_t), intent(out) :: m
      real(dp) :: edge(ndim, 4)
      integer :: i
      call place_bodies(forest_t(-shift, cell, [14, 13]), new_material('', 'neo_hookean', .true., 1.0_dp, 0.3_dp, 2.0_dp), &
                        [rectangle_t(lower, upper, points)], m)
      allocate (m%loads(3))
      edge(1, :) = upper(1)
      edge(2, :) = [(lower(2) + (i - 0.5_dp)/4*(upper(2) - lower(2)), i=1, 4)]
      call load_on_points(m%matter_t, edge, [0.0_dp, (upper(2) - lower(2))/8], m%loads(traction))
      call load_on_points(m%matter_t, reshape(place_of_force, [ndim, 1]), [0.0_dp, 0.0_dp], m%loads(at_point))
      call load_on_particles(m%particles, lower, upper, m%loads(body))
      call start_families(m%particles)
      call start(m, 'musl')
   end subroutine place

   !> Move the body by u = b + A X, a stretch and a rotation of 40 degrees.
   subroutine deform(m, b, a)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: b(ndim), a(ndim, ndim)
      type(failure_t) :: failure
      integer :: i
      do i = 1, m%particles%n
         m%particles%displacement(i, :) = b + matmul(a, m%particles%reference(i, :))
         m%particles%gradient(i, :, :) = a
      end do
      call sort_anew(m, failure)
      call check(.not. failure%failed(), 'the deformed body is in the grid')
   end subroutine deform

   !> Refine or recombine leaves of the grid, and make the particles fit.
   subroutine change_mesh(m, change)
      type(problem_t), intent(inout) :: m
      integer, intent(in) :: change(:)           !! (leaves)
      type(failure_t) :: failure
      type(forest_t) :: forest
      forest = m%grid%forest
      call forest%adapt(change)
      call forest%balance()
      call adopt_forest(m, forest, failure)
      call check(.not. failure%failed(), 'the particles fit the new mesh')
   end subroutine change_mesh

   !> Leaves that are near the places at which the loads act.
   function leaves_at_loads(m) result(change)
      type(problem_t), intent(in) :: m
      integer, allocatable :: change(:)
      integer :: l, k
      allocate (change(m%grid%forest%leaf_count()), source=0)
      do l = traction, at_point
         do k = 1, size(m%loads(l)%particle)
            change(m%grid%element_leaf(m%particles%cell(m%loads(l)%particle(k)))) = 1
         end do
      end do
   end function leaves_at_loads

   !> The nodal forces of each load alone have the resultant and the moment that they should; their shares add up to 1, at particles
   !> that there are.
   subroutine check_resultants(m, b, a, what)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: b(ndim), a(ndim, ndim)  !! u = b + A X
      character(*), intent(in) :: what
      type(load_t) :: load(1)
      type(node_list_t) :: all_nodes
      real(dp) :: f(ndim, m%grid%n_points), moment, at(ndim, 3)
      integer :: l
      at(:, traction) = [upper(1), centre(2)]
      at(:, at_point) = place_of_force
      at(:, body) = centre
      do l = 1, 3
         load(1) = m%loads(l)
         load(1)%force = force
         call check(all(load(1)%particle >= 1 .and. load(1)%particle <= m%particles%n) .and. &
                    size(load(1)%fraction) == size(load(1)%particle), &
                    what//': there is a particle for each point of load '//to_text(l))
         call check_close(sum(load(1)%fraction), 1.0_dp, 1.0e-14_dp, what//': fractions of load '//to_text(l))
         f = 0
         call place_loads(load, m%grid, m%particles)
         call add_loads(load, 0.0_dp, f)
         all_nodes = m%grid%dofs%every_node()
         call m%grid%dofs%condense(all_nodes, ndim, f)
         moment = sum(m%grid%node_position(1, :)*f(2, :) - m%grid%node_position(2, :)*f(1, :))
         call check_close(maxval(abs(sum(f, dim=2) - force)), 0.0_dp, rounding*norm2(force), &
                          what//': resultant of load '//to_text(l))
         associate (x => at(:, l) + b + matmul(a, at(:, l)))
            call check_close(moment, x(1)*force(2) - x(2)*force(1), rounding*norm2(force), what//': moment of load '//to_text(l))
         end associate
      end do
      call check_bodily(m, what)
      call check_uniform(m, what)
   end subroutine check_resultants

   !> A body force acts on every particle, in proportion to its mass.
   subroutine check_bodily(m, what)
      type(problem_t), intent(in) :: m
      character(*), intent(in) :: what
      real(dp) :: share(m%particles%n)
      integer :: k
      share = 0
      associate (load => m%loads(body))
         do k = 1, size(load%particle)
            share(load%particle(k)) = share(load%particle(k)) + load%fraction(k)
         end do
         call check_close(maxval(abs(share/(m%particles%mass/sum(m%particles%mass)) - 1)), 0.0_dp, rounding, &
                          what//': a body force acts in proportion to the mass')
         call check(size(load%particle) == m%particles%n, what//': and each particle has one point of it')
      end associate
   end subroutine check_bodily

   !> The segments of the traction lie one behind the other along the edge, from end to end, with shares in proportion to their
   !> lengths, each on the particle at the edge of which it is a side.
   subroutine check_uniform(m, what)
      type(problem_t), intent(in) :: m
      character(*), intent(in) :: what
      real(dp) :: reached, error, spacing(ndim), fit, middle(ndim, size(m%loads(traction)%particle))
      logical :: open(size(m%loads(traction)%particle))
      integer :: n, k
      reached = lower(2)
      error = 0
      fit = 0
      open = .true.
      associate (load => m%loads(traction), p => m%particles)
         middle = transpose(p%reference(load%particle, :)) + load%offset
         do n = 1, size(load%particle)
            k = minloc(middle(2, :), dim=1, mask=open)
            open(k) = .false.
            spacing = spacing_of(p, load%particle(k))
            error = max(error, abs(middle(1, k) - upper(1)), abs(middle(2, k) - load%half(2, k) - reached), &
                        abs(load%fraction(k) - 2*load%half(2, k)/(upper(2) - lower(2))), abs(load%half(1, k)))
            fit = max(fit, maxval(abs(load%offset(:, k) - [spacing(1)/2, 0.0_dp])), abs(2*load%half(2, k) - spacing(2)))
            reached = middle(2, k) + load%half(2, k)
         end do
      end associate
      call check_close(max(error, abs(reached - upper(2))), 0.0_dp, 1.0e-14_dp, what//': a traction is uniform')
      call check_close(fit, 0.0_dp, 1.0e-14_dp, what//': and as fine as the particles at the edge')
   end subroutine check_uniform

   !> Refine where the loads act, level by level, and recombine again.
   subroutine loads_through_levels(shift, deformed)
      real(dp), intent(in) :: shift(ndim)
      logical, intent(in) :: deformed
      type(problem_t) :: m
      type(load_t) :: initial(3)
      real(dp) :: b(ndim), a(ndim, ndim)
      real(dp), parameter :: angle = 0.7_dp
      integer :: level, l, unsplit
      call place(shift, m)
      b = 0
      a = 0
      if (deformed) then
         b = [0.26_dp, -0.19_dp]
         a = reshape([1.1_dp*cos(angle), 1.1_dp*sin(angle), -0.95_dp*sin(angle), 0.95_dp*cos(angle)], [ndim, ndim]) - identity
         call deform(m, b, a)
      end if
      initial = m%loads
      unsplit = m%particles%n
      call check_resultants(m, b, a, 'before')
      do level = 1, deepest_tried
         call change_mesh(m, leaves_at_loads(m))
         call check(maxval(m%particles%level(m%loads(traction)%particle)) >= max(1, level - 1), 'particles are split')
         call check_resultants(m, b, a, 'level '//to_text(level))
      end do
      if (.not. deformed) call check(size(m%loads(traction)%particle) > 8, 'the traction has more points')
      call check(size(m%loads(at_point)%particle) == 1, 'a force at a place stays at one place')
      do level = deepest_tried, 1, -1
         call change_mesh(m, spread(-1, 1, m%grid%forest%leaf_count()))
         call check_resultants(m, b, a, 'back from level '//to_text(level))
      end do
      call check(m%particles%n == unsplit, 'all particles are recombined')
      do l = 1, 3
         call check(size(m%loads(l)%particle) == size(initial(l)%particle), 'load '//to_text(l)//' has as many points as before')
         if (l /= body) call check_same(m%loads(l), initial(l), 'load '//to_text(l))
      end do
   end subroutine loads_through_levels

   !> Points of a load are what they were, on particles that may have other numbers.
   subroutine check_same(load, was, what)
      type(load_t), intent(in) :: load, was
      character(*), intent(in) :: what
      logical :: same
      same = size(load%particle) == size(was%particle)
      if (same) same = maxval(abs(load%fraction - was%fraction)) < 1e-14_dp .and. maxval(abs(load%offset - was%offset)) < 1e-14_dp &
                       .and. maxval(abs(load%half - was%half)) < 1e-14_dp
      call check(same, what//' is what it was')
   end subroutine check_same

   !> A component of the pressure around an arc, whose parts go along the edge by and by and have both signs: what refines and recombines
   !> has the points that it had.
   subroutine pressure_around_an_arc()
      type(problem_t) :: m
      type(edge_part_t) :: arc(24)
      type(load_t) :: initial, refined
      integer :: i
      call place([0.033_dp, 0.057_dp], m)
      do i = 1, size(arc)
         associate (angle => (i - 0.5_dp)*acos(-1.0_dp)/12, radius => 0.08_dp)
            arc(i)%normal = [cos(angle), sin(angle)]
            arc(i)%middle = centre + radius*arc(i)%normal
            arc(i)%half = radius*acos(-1.0_dp)/24*[-sin(angle), cos(angle)]
         end associate
      end do
      deallocate (m%loads)
      allocate (m%loads(1))
      call load_on_parts(m%matter_t, arc, [(arc(i)%normal(1), i=1, size(arc))], m%loads(1))
      initial = m%loads(1)
      call change_mesh(m, spread(1, 1, m%grid%forest%leaf_count()))
      refined = m%loads(1)
      call change_mesh(m, spread(-1, 1, m%grid%forest%leaf_count()))
      call check_same(m%loads(1), initial, 'the pressure around an arc')
      call change_mesh(m, spread(1, 1, m%grid%forest%leaf_count()))
      call check_same(m%loads(1), refined, 'the pressure around a refined arc')
   end subroutine pressure_around_an_arc

   !> Meshes that refine and recombine at random, up to three levels.
   subroutine random_meshes()
      type(problem_t) :: m
      real(dp), allocatable :: chance(:)
      real(dp), parameter :: zero(ndim, ndim) = 0
      integer, allocatable :: change(:)
      integer :: n, leaf
      call place([0.033_dp, 0.057_dp], m)
      do n = 1, 40
         associate (forest => m%grid%forest)
            allocate (chance(forest%leaf_count()))
            call random_number(chance)
            change = merge(1, merge(0, -1, chance < 0.2_dp), chance < 0.1_dp)
            do leaf = 1, size(change)
               if (forest%level_of(leaf) >= deepest_tried .and. change(leaf) > 0) change(leaf) = 0
            end do
         end associate
         call change_mesh(m, change)
         call check_resultants(m, [0.0_dp, 0.0_dp], zero, 'mesh '//to_text(n))
         deallocate (chance)
      end do
   end subroutine random_meshes

   !> The work of a way is the same whether or not particles split and recombine on it.
   subroutine work_of_a_way()
      type(problem_t) :: m
      real(dp), parameter :: way(ndim) = [0.03_dp, 0.04_dp]
      real(dp) :: work, total
      integer :: l, step
      call place([0.033_dp, 0.057_dp], m)
      do l = 1, 3
         m%loads(l)%force = l*force
      end do
      total = 0
      do step = 1, 4
         call place_loads(m%loads, m%grid, m%particles)
         call book_work(m%loads, m%particles, 0.0_dp, 0.25_dp, spread(way, 2, m%grid%n_points), work)
         total = total + work
         if (step < 3) then
            call change_mesh(m, leaves_at_loads(m))
         else
            call change_mesh(m, spread(-1, 1, m%grid%forest%leaf_count()))
         end if
      end do
      call check_close(total, 6*dot_product(force, way), 1.0e-13_dp, 'the work of a way is the force times the way')
   end subroutine work_of_a_way
end program test_load_following
