!> The forces of interface points in explicit steps. With the forces of the openings at the beginning of a step, nodes of next to no mass,
!> as cracks leave some, would need steps as short as one likes. They are those of the openings and of a part of what the accelerations of the step change
!> them by: so steps stay stable, and no shorter than those of the cells, however stiff the points and however light the nodes are.
!>
!> With C the shares of nodes in the openings g, forces -C' f change the accelerations of nodes by -A C' f, where A is what the run takes for the
!> inverse of the mass matrix, and those by which the particles are strained (`hampm_critical_step`) by -A M A C' f, M being the matrix of the
!> particles; of the scheme usl by -A C' f. With a the accelerations without these forces, and beta of Newmark's method,
!>
!>    f = law(g + beta dt**2 C A M a - W f),   W = beta dt**2 C A M A C'.
!>
!> With beta of 1/4 and more no mode of the points is faster than steps can be, however long: its squared frequency omega**2 becomes
!> omega**2/(1 + beta dt**2 omega**2). No energy is taken by that. Vibrations that steps resolve, and equilibrium, are as they were.
!>
!> The forces are found by Newton's method: where the law is linear by pieces, as of bonds and faces in contact, one solution does for as long as no point
!> changes what it does. Of unknowns whose force changes with their opening the matrix is W + 1/law', symmetric and positive definite, as
!> friction is held at limits that follow from the pressure before a pass, and passes are repeated; it is factorised where it changes only.
!>
!> Masses are lumped at the nodes of points, where faces may touch and where the material moves through the cells; elsewhere A is that of the run, and
!> its columns for the forces are found once for each mesh.
!>
!> Source: Hughes & Liu, Implicit-explicit finite elements in transient analysis, Journal of Applied Mechanics 45 (1978) 371-378.
module hampm_interface_step
   use hampm_kinds, only: dp, ndim
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_element_assembly, only: matrix_by_masters
   use hampm_factorisation, only: factorisation_t
   use hampm_failure, only: failure_t
   use hampm_interface_points, only: interfaces_t, along, interface_states, interface_stiffness, force_at, have_friction, &
                                     hold_friction, look_at_cohesion, cohesive, is_half
   use hampm_cohesive_law, only: cohesive_state_t
   use hampm_jumps, only: give_nodes
   use hampm_mass_matrix, only: mass_matrix_t
   use hampm_mass_solver, only: mass_solver_t, solve_aside
   use hampm_matter, only: matter_t
   use hampm_sparse, only: sparse_t, pattern_of_cliques
   implicit none
   private
   public :: interface_step_t, hold_faces, forget_faces

   real(dp), parameter :: beta = 0.3_dp          !! see above
   integer, parameter :: most_turns = 50         !! in which points find what they do; what they do then has to do for the step
   integer, parameter :: most_passes = 20        !! in which friction finds its limits
   integer, parameter :: most_looks = 10         !! for the least on a way
   real(dp), parameter :: near = 0.1_dp          !! part of a slope that is as good as none
   real(dp), parameter :: tolerance = 1e-9_dp    !! of forces, with friction
   real(dp), parameter :: of_cohesion = 1e-6_dp  !! the same where faces part by cohesion, which the next step goes on from
   real(dp), parameter :: lowered = 0.8_dp       !! part of a slope of cohesion from which on a matrix fits
   real(dp), parameter :: none = 1e-18_dp        !! part of the largest acceleration by a force that is not kept

   !> What a unit force of a point, normal or tangential, does: on some nodes the accelerations A C', and M A C', by which it feels others.
   type :: response_t
      integer, allocatable :: node(:)
      real(dp), allocatable :: acceleration(:, :) !! [1/kg], (ndim, nodes)
      real(dp), allocatable :: mapped(:, :)      !! [-], (ndim, nodes)
   end type response_t

   !> The masses of the particles of an element, between the nodes that have degrees of freedom.
   type :: element_t
      integer :: number = 0
      integer :: n = 0                           !! of nodes
      integer :: node(most_nodes_of_leaf) = 0
      real(dp) :: mass(most_nodes_of_leaf, most_nodes_of_leaf) = 0 !! [kg]
   end type element_t

   !> What a mesh has for this, what the matrix was factorised for, and workspace. Unknowns are the normal and the tangential force of each
   !> point.
   type :: interface_step_t
      private
      type(response_t), allocatable :: responses(:) !! (unknowns)
      type(sparse_t) :: compliance               !! W [m/N]
      type(sparse_t) :: matrix
      type(factorisation_t) :: factor
      integer, allocatable :: states(:)          !! what points did, (points)
      real(dp), allocatable :: slopes(:)         !! changes of their forces with their openings [N/m], (unknowns)
      real(dp) :: dt = 0                         !! [s]
      real(dp), allocatable :: opening(:, :)     !! at the beginning of the step [m], (ndim, points)
   end type interface_step_t

contains

   !> Forget a mesh.
   subroutine forget_faces(self)
      type(interface_step_t), intent(inout) :: self
      call self%factor%release()
      self = interface_step_t()
   end subroutine forget_faces

   !> Change velocities and accelerations at the end of a step by the forces of interface points, and add these to `force`. The openings are left as
   !> they were.
   subroutine hold_faces(self, interfaces, m, fixed, remaps, dt, masses, solver, velocity, acceleration, force, failure)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      logical, intent(in) :: fixed(:, :)         !! which components of nodes are given, (ndim, n_nodes)
      logical, intent(in) :: remaps              !! whether the velocities that strain the particles are mapped from these
      real(dp), intent(in) :: dt                 !! [s]
      type(mass_matrix_t), intent(in) :: masses
      type(mass_solver_t), intent(inout) :: solver
      real(dp), intent(inout) :: velocity(:, :)  !! [m/s], (ndim, n_points)
      real(dp), intent(inout) :: acceleration(:, :) !! [m/s2]
      real(dp), intent(inout) :: force(:, :)     !! [N]
      type(failure_t), intent(inout) :: failure
      real(dp) :: f(ndim*interfaces%n), before(ndim*interfaces%n), change(ndim)
      integer :: pass, k, j
      logical :: rubs, is_new
      is_new = .not. (allocated(self%responses) .and. m%particles%total_frame)
      if (is_new) call find_responses(self, interfaces, m, fixed, remaps, masses, solver, failure)
      if (failure%failed()) return
      is_new = is_new .or. abs(self%dt - dt) > 0
      self%dt = dt
      do k = 1, interfaces%n
         self%opening(:, k) = interfaces%list(k)%opening
      end do
      rubs = have_friction(interfaces)
      if (rubs) call hold_friction(interfaces)
      f = forces_of_law(interfaces)
      do k = 1, size(f)
         associate (of => self%responses(k))
            before(k) = 0
            do j = 1, size(of%node)
               before(k) = before(k) + dot_product(of%mapped(:, j), acceleration(:, of%node(j)))
            end do
         end associate
      end do
      call open_by(interfaces, beta*dt**2*before - opened_by(self, f))
      do pass = 1, most_passes
         before = f
         call find_forces(self, interfaces, f, is_new, failure)
         if (failure%failed() .or. .not. rubs) exit
         if (pass > 1 .and. maxval(abs(f - before)) <= tolerance*maxval(abs(f))) exit
         call hold_friction(interfaces)
      end do
      if (rubs) interfaces%list(:interfaces%n)%most_held = -1
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            point%felt = point%opening
            point%opening = self%opening(:, k)
            point%acting = f(ndim*k - 1)*point%normal + f(ndim*k)*along(point)
            call give_nodes(point%jump_t, -point%acting, force)
            if (point%lets_go) point%acting = point%acting - point%kept*point%held
         end associate
      end do
      do k = 1, size(f)
         associate (of => self%responses(k))
            do j = 1, size(of%node)
               change = -f(k)*of%acceleration(:, j)
               acceleration(:, of%node(j)) = acceleration(:, of%node(j)) + change
               velocity(:, of%node(j)) = velocity(:, of%node(j)) + dt*change
            end do
         end associate
      end do
   end subroutine hold_faces

   !> Find what unit forces of the points do, and W over beta dt**2.
   subroutine find_responses(self, interfaces, m, fixed, remaps, masses, solver, failure)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(in) :: interfaces
      type(matter_t), intent(in) :: m
      logical, intent(in) :: fixed(:, :)
      logical, intent(in) :: remaps
      type(mass_matrix_t), intent(in) :: masses
      type(mass_solver_t), intent(inout) :: solver
      type(failure_t), intent(inout) :: failure
      type(element_t), allocatable :: elements(:)
      integer, allocatable :: felt_by(:), reached(:) ! elements that have nodes of a point, and the nodes of these
      real(dp), allocatable, dimension(:, :) :: unit, moved, mapped ! C', A C' and M A C' of an unknown
      logical :: is_near(m%grid%n_points)
      integer :: k, j, e, unknown
      call self%factor%release()
      if (allocated(self%responses)) deallocate (self%responses, self%states, self%slopes, self%opening)
      allocate (self%responses(ndim*interfaces%n), self%states(interfaces%n), self%slopes(ndim*interfaces%n), &
                self%opening(ndim, interfaces%n))
      is_near = .not. interfaces%are_lumped
      do k = 1, interfaces%n
         is_near(pack(interfaces%list(k)%node, interfaces%list(k)%node > 0)) = .true.
      end do
      call gather_elements(m, is_near .and. remaps, elements)
      allocate (unit(ndim, m%grid%n_points), source=0.0_dp)
      allocate (moved, mapped, source=unit)
      felt_by = [(e, e=1, size(elements))]
      do unknown = 1, size(self%responses)
         associate (point => interfaces%list((unknown + 1)/ndim), is_normal => mod(unknown, ndim) == 1)
            associate (nodes => point%node(:count(point%node > 0)))
               call give_nodes(point%jump_t, merge(point%normal, along(point), is_normal), unit)
               if (interfaces%are_lumped) then
                  do j = 1, size(nodes)
                     if (masses%lumped(nodes(j)) > 0) &
                        moved(:, nodes(j)) = merge(0.0_dp, unit(:, nodes(j))/masses%lumped(nodes(j)), fixed(:, nodes(j)))
                  end do
                  if (is_normal) felt_by = pack([(e, e=1, size(elements))], [(have_common(elements(e)%node, nodes), &
                                                                              e=1, size(elements))])
               else
                  call solve_aside(solver, m%grid, masses, unit, moved, failure)
                  if (failure%failed()) return
               end if
               do k = 1, size(felt_by)
                  associate (element => elements(felt_by(k)))
                     associate (at => element%node(:element%n))
                        mapped(:, at) = mapped(:, at) + matmul(moved(:, at), element%mass(:size(at), :size(at)))
                     end associate
                  end associate
               end do
               do j = 1, size(nodes)             ! what is given there the particles do not change
                  where (fixed(:, nodes(j)) .or. .not. remaps) mapped(:, nodes(j)) = mapped(:, nodes(j)) + unit(:, nodes(j))
                  unit(:, nodes(j)) = 0
               end do
            end associate
         end associate
         if (interfaces%are_lumped) then
            if (mod(unknown, ndim) == 1) reached = nodes_of(elements(felt_by), interfaces%list((unknown + 1)/ndim)%node)
         else
            reached = [(j, j=1, m%grid%n_points)]
         end if
         call take_response(reached, moved, mapped, self%responses(unknown))
      end do
      call find_compliance(self, m%grid%n_points)
   end subroutine find_responses

   !> Whether two lists of nodes have any in common.
   pure logical function have_common(a, b)
      integer, intent(in) :: a(:), b(:)          !! no 0 in `b`
      integer :: k
      have_common = any([(any(a == b(k)), k=1, size(b))])
   end function have_common

   !> The nodes of some elements, and some others, each once, ascending.
   pure function nodes_of(elements, others) result(nodes)
      type(element_t), intent(in) :: elements(:)
      integer, intent(in) :: others(:)           !! 0 for none
      integer, allocatable :: nodes(:)
      integer :: list(most_nodes_of_leaf*size(elements) + size(others)), k, j, n, last, next
      do k = 1, size(elements)
         list(most_nodes_of_leaf*(k - 1) + 1:most_nodes_of_leaf*k) = elements(k)%node
      end do
      list(most_nodes_of_leaf*size(elements) + 1:) = others
      allocate (nodes(size(list)))
      n = 0
      last = 0
      do
         next = huge(next)
         do j = 1, size(list)
            if (list(j) > last .and. list(j) < next) next = list(j)
         end do
         if (next == huge(next)) exit
         n = n + 1
         nodes(n) = next
         last = next
      end do
      nodes = nodes(:n)
   end function nodes_of

   !> Take what is there of accelerations and of what they map to, and clear it.
   subroutine take_response(reached, moved, mapped, response)
      integer, intent(in) :: reached(:)          !! nodes that may have something
      real(dp), intent(inout) :: moved(:, :), mapped(:, :) !! (ndim, n_points)
      type(response_t), intent(out) :: response
      real(dp) :: least(2)
      integer :: k
      least = none*[maxval(abs(moved(:, reached))), maxval(abs(mapped(:, reached)))]
      response%node = pack(reached, [(any(abs(moved(:, reached(k))) > least(1)) .or. any(abs(mapped(:, reached(k))) > least(2)), &
                                      k=1, size(reached))])
      response%acceleration = moved(:, response%node)
      response%mapped = mapped(:, response%node)
      moved(:, reached) = 0
      mapped(:, reached) = 0
   end subroutine take_response

   !> Gather the elements with material that have some nodes, or hang on these, and their masses.
   subroutine gather_elements(m, is_wanted, elements)
      type(matter_t), intent(in) :: m
      logical, intent(in) :: is_wanted(:)        !! (n_points)
      type(element_t), allocatable, intent(out) :: elements(:)
      real(dp) :: by_node(m%grid%n_functions, m%grid%n_functions), n(m%grid%n_functions)
      integer :: i, c, e, k, found
      logical :: reaches(size(is_wanted))        ! or hangs on such a node
      reaches = is_wanted
      associate (dofs => m%grid%dofs)
         do k = 1, dofs%n_hanging
            reaches(dofs%n_nodes + k) = any(is_wanted(dofs%master(dofs%first_master(k):dofs%first_master(k + 1) - 1)))
         end do
      end associate
      associate (wanted => [(any(reaches(m%grid%element_nodes(:, e))) .and. m%blocks%count_in(e) > 0, e=1, m%grid%n_elements)])
         allocate (elements(count(wanted)))
         k = 0
         do e = 1, m%grid%n_elements
            if (.not. wanted(e)) cycle
            k = k + 1
            elements(k)%number = e
         end do
      end associate
      do found = 1, size(elements)
         e = elements(found)%number
         by_node = 0
         do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
            n = m%grid%functions_in(e, m%grid%local_coordinate(e, m%particles%place_in_grid(i)))
            do c = 1, size(n)
               by_node(:, c) = by_node(:, c) + m%particles%mass(i)*n(c)*n
            end do
         end do
         call matrix_by_masters(m%grid, e, 1, by_node, elements(found)%n, elements(found)%node, elements(found)%mass)
         elements(found)%node(elements(found)%n + 1:) = 0
      end do
   end subroutine gather_elements

   !> Find W over beta dt**2: by how much unit forces change the accelerations of the openings.
   subroutine find_compliance(self, n_points)
      type(interface_step_t), intent(inout) :: self
      integer, intent(in) :: n_points
      integer :: row, j, k, users(n_points), unknown
      integer, allocatable :: first(:), user(:), place(:), cliques(:, :)
      real(dp), allocatable :: of_row(:)
      users = 0                                  ! the unknowns that a node has something of, in rows
      do unknown = 1, size(self%responses)
         users(self%responses(unknown)%node) = users(self%responses(unknown)%node) + 1
      end do
      allocate (first(n_points + 1), source=1)
      do k = 1, n_points
         first(k + 1) = first(k) + users(k)
      end do
      allocate (user(first(n_points + 1) - 1), place(first(n_points + 1) - 1))
      allocate (cliques(maxval(users), count(users > 0)), source=0)
      users = 0
      do unknown = 1, size(self%responses)
         do j = 1, size(self%responses(unknown)%node)
            associate (node => self%responses(unknown)%node(j))
               user(first(node) + users(node)) = unknown
               place(first(node) + users(node)) = j
               users(node) = users(node) + 1
            end associate
         end do
      end do
      j = 0
      do k = 1, n_points
         if (users(k) == 0) cycle
         j = j + 1
         cliques(:users(k), j) = user(first(k):first(k + 1) - 1)
      end do
      call pattern_of_cliques(size(self%responses), cliques, self%compliance)
      allocate (of_row(size(self%responses)), source=0.0_dp)
      do row = 1, self%compliance%n
         associate (of => self%responses(row), columns => self%compliance%column(self%compliance%row_start(row): &
                                                                                self%compliance%row_start(row + 1) - 1))
            do j = 1, size(of%node)
               do k = first(of%node(j)), first(of%node(j) + 1) - 1
                  of_row(user(k)) = of_row(user(k)) + dot_product(of%mapped(:, j), &
                                                                  self%responses(user(k))%acceleration(:, place(k)))
               end do
            end do
            self%compliance%value(self%compliance%row_start(row):self%compliance%row_start(row + 1) - 1) = of_row(columns)
            of_row(columns) = 0
         end associate
      end do
      self%matrix = self%compliance
   end subroutine find_compliance

   !> Open the points.
   subroutine open_by(interfaces, way)
      type(interfaces_t), intent(inout) :: interfaces
      real(dp), intent(in) :: way(:)             !! normal and tangential, of all points [m]
      integer :: k
      do k = 1, interfaces%n
         associate (point => interfaces%list(k))
            point%opening = point%opening + way(ndim*k - 1)*point%normal + way(ndim*k)*along(point)
         end associate
      end do
   end subroutine open_by

   !> By how much forces open the points: W f [m].
   pure function opened_by(self, f) result(way)
      type(interface_step_t), intent(in) :: self
      real(dp), intent(in) :: f(:)               !! [N]
      real(dp) :: way(size(f))
      integer :: i
      associate (w => self%compliance)
         do i = 1, w%n
            associate (first => w%row_start(i), last => w%row_start(i + 1) - 1)
               way(i) = beta*self%dt**2*dot_product(w%value(first:last), f(w%column(first:last)))
            end associate
         end do
      end associate
   end function opened_by

   !> Normal and tangential forces of the points by their law, at their openings [N].
   pure function forces_of_law(interfaces) result(f)
      type(interfaces_t), intent(in) :: interfaces
      real(dp) :: f(ndim*interfaces%n), force(ndim)
      integer :: k
      do k = 1, interfaces%n
         force = force_at(interfaces, k)
         f(ndim*k - 1:ndim*k) = [dot_product(force, interfaces%list(k)%normal), dot_product(force, along(interfaces%list(k)))]
      end do
   end function forces_of_law

   !> Find the forces, with what friction holds at most as it is. They are where a convex potential is least, and a turn that goes beyond the least on
   !> its way goes back to that.
   subroutine find_forces(self, interfaces, f, is_new, failure)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(inout) :: interfaces !! opened by the step and by -f
      real(dp), intent(inout) :: f(:)            !! [N]
      logical, intent(inout) :: is_new           !! whether W is, to which the matrix has to be made
      type(failure_t), intent(inout) :: failure
      real(dp), dimension(size(f)) :: rest, turned, way, slopes
      real(dp) :: part, least, most, slope, of_least, of_most, last
      integer :: states(interfaces%n), turn, look
      logical :: is_done
      rest = forces_of_law(interfaces) - f
      do turn = 1, most_turns
         states = interface_states(interfaces)
         slopes = slopes_of_law(interfaces)
         is_new = is_new .or. any(states /= self%states) .or. any(slopes > self%slopes .or. slopes < lowered*self%slopes)
         if (is_new) call factorise(self, states, slopes, failure)
         if (failure%failed()) return
         is_new = .false.
         slopes = self%slopes
         where (.not. slopes > 0)
            way = rest
         elsewhere
            way = 0
         end where
         way = opened_by(self, way)
         where (slopes > 0)
            way = rest/slopes - way
         elsewhere
            way = rest
         end where
         call self%factor%solve(way, turned)
         way = -opened_by(self, turned)
         of_least = dot_product(way, rest)       ! the slope on the way, below 0 up to the least
         call go_by(1.0_dp)
         is_done = all(states == interface_states(interfaces))
         slope = dot_product(way, rest)
         if (.not. slope > -near*of_least) then
            if (is_done .and. interfaces%n_cohesive > 0) is_done = maxval(abs(rest)) <= of_cohesion*maxval(abs(f))
            if (is_done) return
            cycle
         end if
         least = 0
         most = 1
         of_most = slope
         part = 1
         do look = 1, most_looks
            last = part
            part = least + (most - least)*min(0.9_dp, max(0.1_dp, of_least/(of_least - of_most)))
            call go_by(part - last)
            slope = dot_product(way, rest)
            if (abs(slope) <= -near*of_least) exit
            if (slope > 0) then
               most = part
               of_most = slope
            else
               least = part
               of_least = slope
            end if
         end do
      end do
   contains
      !> Go a part of the way of a turn, and find what is out of balance there.
      subroutine go_by(step)
         real(dp), intent(in) :: step            !! [-]
         f = f + step*turned
         call open_by(interfaces, step*way)
         rest = forces_of_law(interfaces) - f
      end subroutine go_by
   end subroutine find_forces

   !> Changes of the normal and the tangential forces of the points with these components of their openings; of cohesion those on the way back to the
   !> origin, with which a turn never goes too far [N/m].
   pure function slopes_of_law(interfaces) result(slopes)
      type(interfaces_t), intent(in) :: interfaces
      real(dp) :: slopes(ndim*interfaces%n), tangent(ndim, ndim), area
      type(cohesive_state_t) :: answer
      integer :: k, halves
      do k = 1, interfaces%n
         associate (point => interfaces%list(k), n => interfaces%list(k)%normal, t => along(interfaces%list(k)))
            if (point%law == cohesive) then
               call look_at_cohesion(interfaces, k, answer, area, halves)
               slopes(ndim*k - 1:ndim*k) = area*halves*[answer%secant(2, 2), merge(0.0_dp, answer%secant(1, 1), is_half(point))]
            else
               tangent = interface_stiffness(interfaces, k)
               slopes(ndim*k - 1:ndim*k) = [dot_product(n, matmul(tangent, n)), dot_product(t, matmul(tangent, t))]
            end if
         end associate
      end do
   end function slopes_of_law

   !> Factorise W + 1/law' of the unknowns whose forces change with their openings.
   subroutine factorise(self, states, slopes, failure)
      type(interface_step_t), intent(inout) :: self
      integer, intent(in) :: states(:)
      real(dp), intent(in) :: slopes(:)
      type(failure_t), intent(inout) :: failure
      integer :: i
      self%states = states
      self%slopes = slopes
      self%matrix%value = beta*self%dt**2*self%compliance%value
      do i = 1, self%matrix%n
         associate (first => self%matrix%row_start(i), last => self%matrix%row_start(i + 1) - 1)
            where (.not. (slopes(self%matrix%column(first:last)) > 0 .and. slopes(i) > 0)) self%matrix%value(first:last) = 0
         end associate
         if (slopes(i) > 0) then
            call self%matrix%add(i, i, 1/slopes(i))
         else
            call self%matrix%add(i, i, 1.0_dp)
         end if
      end do
      call self%factor%factorise(self%matrix, failure)
   end subroutine factorise
end module hampm_interface_step
