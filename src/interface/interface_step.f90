!> Forces of interface points in explicit steps: implicit in the opening, so that steps are stable and as long as for the cells, for
!> any stiffness of the points and mass of the nodes (docs/explanation/interfaces.md). With the weights C of nodes in the
!> openings g, A the inverse of the mass matrix, M the matrix of the particles, a the accelerations without these forces, and beta,
!>
!>    f = law(g + beta dt**2 C A M a - W f),   W = beta dt**2 C A M A C'   (Newmark's method).
!>
!> Faces that are free to part have the opening at the end of the step: g + dt C v in place of g, with beta 1. In usl beta is 1, and
!> A M A replaces A. Newton's method needs one solution while no point changes its state; W + 1/law' is symmetric positive definite,
!> with friction limits by the pressure of the last pass. Where faces of linear cells may touch masses are lumped; where material
!> moves through the cells W has the nodes near the points only, as columns fall by 4 to 6 times per cell. Sources: Hughes & Liu,
!> J. Appl. Mech. 45 (1978) 371-378; Carpenter, Taylor & Katona, Int. J. Numer. Meth. Engng 32 (1991) 103-128.
module hampm_interface_step
   use hampm_archive, only: archive_t
   use hampm_carried_forces, only: carry_forces
   use hampm_kinds, only: dp, ndim, corners
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_domain_pass, only: corner_map_t
   use hampm_element_assembly, only: pattern_of_elements, matrix_by_masters, add_element
   use hampm_factorisation, only: factorisation_t
   use hampm_failure, only: failure_t
   use hampm_interface_points, only: interfaces_t, interface_point_t, releasing, direction_of, components_of, vector_of, &
                                     interface_states, stiffness_in_directions, force_at, have_friction, &
                                     hold_friction, commit_slip, cohesion_at, holds, are_apart
   use hampm_cohesive_law, only: cohesive_state_t
   use hampm_jumps, only: jump_of, give_nodes, add_mass_product
   use hampm_mass_factorisation, only: mass_factorisation_t
   use hampm_mass_matrix, only: mass_matrix_t
   use hampm_mass_solver, only: mass_solver_t, solve_aside, solve_mass
   use hampm_matter, only: matter_t
   use hampm_nearby, only: nearby_t
   use hampm_numbering, only: numbering_t, number_unknowns, nodes_of_elements
   use hampm_sparse, only: sparse_t, pattern_of_cliques
   implicit none
   private
   public :: interface_step_t, hold_faces, commit_faces, accelerate_by_faces, forget_faces, archive_faces

   real(dp), parameter :: of_newmark = 0.3_dp    !! beta, see above
   integer, parameter :: most_turns = 50         !! in which points find their states, for the whole step
   integer, parameter :: most_passes = 20        !! in which friction finds its limits
   integer, parameter :: most_trials = 10        !! for the least on a way
   real(dp), parameter :: near = 0.1_dp          !! part of a slope that is as good as none
   real(dp), parameter :: tolerance = 1e-9_dp    !! of forces, with friction
   real(dp), parameter :: of_cohesion = 1e-6_dp  !! the same with cohesion, the state of the next step
   real(dp), parameter :: lowered = 0.8_dp       !! part of a slope of cohesion from which on a matrix fits
   integer, parameter :: rings = 4               !! of cells around points in W, where the material moves through the cells
   real(dp), parameter :: none = 1e-18_dp        !! part of the largest acceleration by a force that is not kept

   !> Response to unit forces of a point, along x and along y: accelerations A C' of some nodes, and M A C', by which other points
   !> are affected and which a point with a given force does without.
   type :: response_t
      integer, allocatable :: node(:)
      real(dp), allocatable :: acceleration(:, :) !! of the first of these, others have none [1/kg], (ndim, nodes)
      real(dp), allocatable :: mapped(:, :)      !! [-], (ndim, nodes), or none
   end type response_t

   !> Data of a mesh, of the factorised matrix, and workspace. Unknowns are the normal and the tangential force of each point. Where
   !> material moves through the cells numbers change in each step, but not the pattern.
   type :: interface_step_t
      private
      type(response_t), allocatable :: responses(:) !! (points)
      logical :: are_new = .false.               !! whether no step has used these
      integer, allocatable :: elements(:)        !! elements through which points affect each other
      integer, allocatable :: nodes(:)           !! of these
      logical :: are_near = .false.              !! whether W is by the nodes near the points alone
      logical, allocatable :: is_beyond(:, :)    !! components not moved by points, where material moves, (ndim, n_nodes)
      type(mass_factorisation_t) :: around       !! the masses of the others
      type(numbering_t) :: numbering             !! of all nodes that have degrees of freedom, as they are
      type(sparse_t) :: masses                   !! of the particles of these elements [kg]
      type(sparse_t) :: compliance               !! W [m/N]
      type(sparse_t) :: matrix
      type(factorisation_t) :: factor
      integer, allocatable :: states(:)          !! states of points, (points)
      real(dp), allocatable :: slopes(:)         !! changes of their forces with their openings [N/m], (unknowns)
      real(dp) :: dt = 0                         !! [s]
      real(dp), allocatable :: beta(:)           !! 1 where the faces are free to part, (points)
      real(dp), allocatable :: opening(:, :)     !! at the beginning of the step [m], (ndim, points)
      type(nearby_t) :: near                     !! table of the points, as in `find_points`
      real(dp), allocatable, dimension(:, :) :: unit, moved, mapped !! 0, where C', A C' and M A C' are found, (ndim, n_points)
   end type interface_step_t

contains

   !> Forget a mesh.
   subroutine forget_faces(self)
      type(interface_step_t), intent(inout) :: self
      type(interface_step_t) :: new
      call self%factor%release()
      call self%around%release()
      self = new
   end subroutine forget_faces

   !> Change velocities and accelerations at the end of a step by the forces of interface points, and add these to `force`. The
   !> openings are unchanged.
   subroutine hold_faces(self, interfaces, m, fixed, map, dt, masses, solver, velocity, acceleration, force, failure)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(inout) :: interfaces
      type(matter_t), intent(in) :: m
      logical, intent(in) :: fixed(:, :)         !! which components of nodes are given, (ndim, n_nodes)
      type(corner_map_t), intent(in) :: map      !! of the domains of the particles, if they have some
      real(dp), intent(in) :: dt                 !! [s]
      type(mass_matrix_t), intent(in) :: masses
      type(mass_solver_t), intent(inout) :: solver
      real(dp), intent(inout) :: velocity(:, :)  !! [m/s], (ndim, n_points)
      real(dp), intent(inout) :: acceleration(:, :) !! [m/s2]
      real(dp), intent(inout) :: force(:, :)     !! [N]
      type(failure_t), intent(inout) :: failure
      real(dp) :: f(ndim*interfaces%n_at_end), before(ndim*interfaces%n_at_end), change(ndim), &
                  acting(ndim, interfaces%n_at_end), unused
      integer :: pass, k, j
      logical :: rubs, is_new, is_kept           ! whether the matrix data are from a checkpoint
      is_kept = m%particles%total_frame .and. allocated(self%slopes)
      call find_responses(self, interfaces, m, fixed, map, masses, solver, failure)
      is_new = self%are_new
      self%are_new = .false.
      if (is_kept .and. is_new .and. .not. failure%failed()) call factorise(self, failure)
      if (failure%failed()) return
      if (.not. allocated(self%slopes)) allocate (self%states(interfaces%n), self%slopes(ndim*interfaces%n_at_end))
      is_new = is_new .and. .not. is_kept .or. abs(self%dt - dt) > 0
      self%dt = dt
      do k = 1, interfaces%n_at_end
         self%opening(:, k) = interfaces%list(k)%opening
         self%beta(k) = merge(1.0_dp, of_newmark, are_apart(interfaces%list(k)) .or. interfaces%strain_last)
      end do
      rubs = have_friction(interfaces)
      if (rubs) call hold_friction(interfaces)
      f = forces_of_law(interfaces)
      do k = 1, interfaces%n_at_end
         associate (of => self%responses(k), point => interfaces%list(k))
            change = 0
            do j = 1, size(of%mapped, 2)
               change = change + of%mapped(:, j)*acceleration(:, of%node(j))
            end do
            change = dt*change
            if (are_apart(point)) change = change + jump_of(point%jump, velocity) - dt*jump_of(point%jump, acceleration)
            before(ndim*(k - 1) + 1:ndim*k) = dt*components_of(point, change)
         end associate
      end do
      call open_by(self, interfaces, before - opened_by(self, f))
      do pass = 1, most_passes
         before = f
         call find_forces(self, interfaces, f, is_new, failure)
         if (failure%failed() .or. .not. rubs) exit
         if (pass > 1 .and. maxval(abs(f - before)) <= tolerance*maxval(abs(f))) exit
         if (pass == 1) call carry_forces(interfaces, self%near, .false., .true., unused)
         call hold_friction(interfaces)
      end do
      if (rubs) interfaces%list(:interfaces%n)%friction_limit = -1
      do k = 1, interfaces%n_at_end
         associate (point => interfaces%list(k))
            point%effective_opening = merge(self%opening(:, k), point%opening, has_given_force(point))
            point%opening = self%opening(:, k)
            point%before = point%opening
            acting(:, k) = vector_of(point, f(ndim*(k - 1) + 1:ndim*k))
            call give_nodes(point%jump, -acting(:, k), force)
         end associate
      end do
      call move_nodes(self, interfaces, m, acting, masses, solver, failure)
      call take_moved(self, acceleration, dt, velocity)
   end subroutine hold_faces

   !> After a step: commit slip where mean tractions reach the cone of friction, and damage. Points give back what they have to
   !> spare here alone, where they slide by it and friction takes its energy.
   pure subroutine commit_faces(self, interfaces)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(inout) :: interfaces
      real(dp) :: unused
      if (have_friction(interfaces)) call carry_forces(interfaces, self%near, .false., .false., unused)
      call commit_slip(interfaces)
   end subroutine commit_faces

   !> Add the accelerations by the forces of the points at their present openings, between steps.
   subroutine accelerate_by_faces(self, interfaces, m, fixed, map, masses, solver, acceleration, failure)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(in) :: interfaces
      type(matter_t), intent(in) :: m
      logical, intent(in) :: fixed(:, :)         !! which components of nodes are given, (ndim, n_nodes)
      type(corner_map_t), intent(in) :: map      !! of the domains of the particles, if they have some
      type(mass_matrix_t), intent(in) :: masses
      type(mass_solver_t), intent(inout) :: solver
      real(dp), intent(inout) :: acceleration(:, :) !! [m/s2], (ndim, n_points)
      type(failure_t), intent(inout) :: failure
      real(dp) :: acting(ndim, interfaces%n_at_end)
      integer :: k
      call find_responses(self, interfaces, m, fixed, map, masses, solver, failure)
      if (failure%failed()) return
      do k = 1, interfaces%n_at_end
         acting(:, k) = force_at(interfaces, k)
      end do
      call move_nodes(self, interfaces, m, acting, masses, solver, failure, is_aside=.true.)
      call take_moved(self, acceleration)
   end subroutine accelerate_by_faces

   !> Add `moved` to the accelerations, and to velocities what it makes of them in a step, and clear it.
   pure subroutine take_moved(self, acceleration, dt, velocity)
      type(interface_step_t), intent(inout) :: self
      real(dp), intent(inout) :: acceleration(:, :) !! [m/s2], (ndim, n_points)
      real(dp), intent(in), optional :: dt       !! [s]
      real(dp), intent(inout), optional :: velocity(:, :) !! [m/s]
      integer :: k, j
      if (self%are_near) then                    ! all nodes
         acceleration = acceleration + self%moved
         if (present(velocity)) velocity = velocity + dt*self%moved
         self%moved = 0
         return
      end if
      do k = 1, size(self%responses)
         do j = 1, size(self%responses(k)%acceleration, 2)
            associate (i => self%responses(k)%node(j))
               acceleration(:, i) = acceleration(:, i) + self%moved(:, i)
               if (present(velocity)) velocity(:, i) = velocity(:, i) + dt*self%moved(:, i)
               self%moved(:, i) = 0              ! other points name it, too
            end associate
         end do
      end do
   end subroutine take_moved

   !> Find -A C' f, in `moved`, which is 0 before.
   subroutine move_nodes(self, interfaces, m, acting, masses, solver, failure, is_aside)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(in) :: interfaces
      type(matter_t), intent(in) :: m
      real(dp), intent(in) :: acting(:, :)       !! f [N], (ndim, n_at_end)
      type(mass_matrix_t), intent(in) :: masses
      type(mass_solver_t), intent(inout) :: solver
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: is_aside  !! whether it is found between steps, which must not depend on it
      integer :: k, j
      do k = 1, interfaces%n_at_end
         associate (of => self%responses(k))
            do j = 1, size(of%acceleration, 2)
               self%moved(:, of%node(j)) = self%moved(:, of%node(j)) - acting(:, k)*of%acceleration(:, j)
            end do
            if (self%are_near) call give_nodes(interfaces%list(k)%jump, -acting(:, k), self%unit)
         end associate
      end do
      if (.not. self%are_near) return
      if (present(is_aside)) then
         call solve_aside(solver, m%grid, masses, self%unit, self%moved, failure)
      else
         call solve_mass(solver, m%grid, masses, self%unit, self%moved, failure)
      end if
      self%unit = 0
   end subroutine move_nodes

   !> Find the responses to unit forces of the points, and W over beta dt**2, unless they are there and stay.
   subroutine find_responses(self, interfaces, m, fixed, map, masses, solver, failure)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(in) :: interfaces
      type(matter_t), intent(in) :: m
      logical, intent(in) :: fixed(:, :)
      type(corner_map_t), intent(in) :: map
      type(mass_matrix_t), intent(in) :: masses
      type(mass_solver_t), intent(inout) :: solver
      type(failure_t), intent(inout) :: failure
      integer :: k, j
      real(dp) :: unused(ndim)
      logical :: is_new
      is_new = .not. allocated(self%responses)
      if (.not. is_new .and. m%particles%total_frame) return
      self%are_new = .true.
      if (is_new) call prepare(self, interfaces, m, fixed)
      call weigh_elements(self, m, map)
      if (self%are_near) call self%around%factorise(m%grid, masses, self%is_beyond, failure)
      if (failure%failed()) return
      do k = 1, interfaces%n_at_end
         associate (point => interfaces%list(k), of => self%responses(k))
            associate (nodes => point%jump%node(:count(point%jump%node > 0)))
               call give_nodes(point%jump, spread(1.0_dp, 1, ndim), self%unit)
               if (interfaces%are_lumped .or. self%are_near) then
                  do j = 1, size(nodes)
                     if (masses%lumped(nodes(j)) > 0) &
                        self%moved(:, nodes(j)) = merge(0.0_dp, self%unit(:, nodes(j))/masses%lumped(nodes(j)), fixed(:, nodes(j)))
                  end do
                  if (self%are_near) call self%around%solve(self%unit, self%moved)
               else
                  call solve_aside(solver, m%grid, masses, self%unit, self%moved, failure)
                  if (failure%failed()) return
               end if
               if (interfaces%are_lumped) then
                  call map_by(self%masses, of%node, self%moved, self%mapped)
               else
                  call map_by(self%masses, self%numbering%node, self%moved, self%mapped)
               end if
               if (allocated(masses%ghosts)) call add_mass_product(masses%ghosts, self%moved, self%mapped, unused)
               do j = 1, size(nodes)             ! particles do not change prescribed motion
                  where (fixed(:, nodes(j))) &
                     self%mapped(:, nodes(j)) = self%mapped(:, nodes(j)) + self%unit(:, nodes(j))
               end do
               if (.not. interfaces%are_lumped) & ! those with accelerations, or something that they map to
                  of%node = pack(self%nodes, &
                                 maxval(abs(self%moved(:, self%nodes)), dim=1) > none*maxval(abs(self%moved(:, self%nodes))) .or. &
                                 maxval(abs(self%mapped(:, self%nodes)), dim=1) > none*maxval(abs(self%mapped(:, self%nodes))))
               j = size(of%node)
               if (interfaces%are_lumped) j = min(j, size(nodes)) ! one on both faces is named twice
               of%acceleration = self%moved(:, of%node(:j))
            end associate
            of%mapped = self%mapped(:, of%node)
            if (interfaces%strain_last) of%mapped = self%unit(:, of%node)
            if (has_given_force(point)) of%mapped = of%mapped(:, :0)
            self%unit(:, of%node) = 0
            self%moved(:, of%node) = 0
            self%mapped(:, of%node) = 0
            if (interfaces%are_lumped) cycle
            self%moved(:, self%nodes) = 0
            self%mapped(:, self%nodes) = 0
         end associate
      end do
      if (is_new) call find_pattern(self, interfaces%are_lumped, m%grid%n_points)
      if (is_new) self%matrix = self%compliance
      call find_compliance(self, interfaces)
   end subroutine find_responses

   !> Find the elements that transmit forces and, with lumped masses, the nodes reached by the forces of each point.
   subroutine prepare(self, interfaces, m, fixed)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(in) :: interfaces
      type(matter_t), intent(in) :: m
      logical, intent(in) :: fixed(:, :)
      integer :: j, k
      allocate (self%responses(interfaces%n_at_end), self%opening(ndim, interfaces%n_at_end), self%beta(interfaces%n_at_end))
      allocate (self%unit(ndim, m%grid%n_points), self%moved(ndim, m%grid%n_points), self%mapped(ndim, m%grid%n_points), &
                source=0.0_dp)
      self%are_near = .not. (interfaces%are_lumped .or. m%particles%total_frame)
      call gather_elements(m, interfaces, self%elements)
      self%nodes = [(k, k=1, m%grid%n_points)]
      if (self%are_near) then
         call nodes_of_elements(m%grid, self%elements, self%nodes)
         allocate (self%is_beyond, source=fixed)
         self%is_beyond = .true.
         self%is_beyond(:, self%nodes) = fixed(:, self%nodes)
         allocate (self%around%ghosts(0))
      end if
      call number_unknowns([(k, k=1, m%grid%n_nodes)], spread([(.false., k=1, m%grid%n_nodes)], 1, 1), self%numbering)
      call pattern_of_elements(m%grid, self%elements, self%numbering, self%masses)
      if (.not. interfaces%are_lumped) return
      do k = 1, interfaces%n_at_end
         associate (node => interfaces%list(k)%jump%node, at => self%masses%row_start, of => self%responses(k))
            of%node = node(:count(node > 0))
            do j = 1, count(node > 0)
               of%node = [of%node, self%masses%column(at(node(j)):at(node(j) + 1) - 1)]
            end do
            of%node = pack(of%node, [(all(of%node(:j - 1) /= of%node(j)), j=1, size(of%node))])
         end associate
      end do
   end subroutine prepare

   !> Add masses times accelerations, of which most are 0.
   pure subroutine map_by(masses, nodes, acceleration, mapped)
      type(sparse_t), intent(in) :: masses
      integer, intent(in) :: nodes(:)            !! others have no acceleration
      real(dp), intent(in) :: acceleration(:, :) !! (ndim, n_points)
      real(dp), intent(inout) :: mapped(:, :)
      integer :: j, k
      do j = 1, size(nodes)
         associate (a => acceleration(:, nodes(j)))
            if (.not. any(abs(a) > 0)) cycle
            do k = masses%row_start(nodes(j)), masses%row_start(nodes(j) + 1) - 1
               mapped(:, masses%column(k)) = mapped(:, masses%column(k)) + masses%value(k)*a
            end do
         end associate
      end do
   end subroutine map_by

   !> Gather the elements, with material or open to it, that have nodes of points, or nodes hanging on these, or are near them: if
   !> masses are not lumped and not all move.
   pure subroutine gather_elements(m, interfaces, elements)
      type(matter_t), intent(in) :: m
      type(interfaces_t), intent(in) :: interfaces
      integer, allocatable, intent(out) :: elements(:)
      integer :: e, k, ring
      integer, allocatable :: nodes(:)
      logical, allocatable :: is_near(:)
      allocate (is_near(m%grid%n_points))
      is_near = .not. interfaces%are_lumped .and. m%particles%total_frame
      do k = 1, interfaces%n_at_end
         is_near(pack(interfaces%list(k)%jump%node, interfaces%list(k)%jump%node > 0)) = .true.
      end do
      do ring = 0, merge(0, rings, interfaces%are_lumped .or. m%particles%total_frame)
         if (ring > 0) then
            call nodes_of_elements(m%grid, pack([(e, e=1, m%grid%n_elements)], &
                                                [(any(is_near(m%grid%support_of(e))), e=1, m%grid%n_elements)]), nodes)
            is_near(nodes) = .true.
         end if
         associate (dofs => m%grid%dofs)
            do k = 1, dofs%n_hanging
               is_near(dofs%n_nodes + k) = any(is_near(dofs%master(dofs%first_master(k):dofs%first_master(k + 1) - 1)))
            end do
         end associate
      end do
      elements = pack([(e, e=1, m%grid%n_elements)], &
                      [(any(is_near(m%grid%support_of(e))) .and. &
                        (m%blocks%count_in(e) > 0 .or. .not. m%particles%total_frame), e=1, m%grid%n_elements)])
   end subroutine gather_elements

   !> Find the masses of the elements, of domains at their corners.
   pure subroutine weigh_elements(self, m, map)
      type(interface_step_t), intent(inout) :: self
      type(matter_t), intent(in) :: m
      type(corner_map_t), intent(in) :: map
      real(dp) :: by_node(m%grid%n_functions, m%grid%n_functions), by_master(most_nodes_of_leaf, most_nodes_of_leaf)
      integer :: i, e, found, n, masters(most_nodes_of_leaf)
      self%masses%value = 0
      do found = 1, size(self%elements)
         e = self%elements(found)
         by_node = 0
         if (allocated(m%particles%corner_velocity)) then
            do i = map%first(e), map%first(e + 1) - 1
               associate (of => (map%slot(i) - 1)/corners + 1, c => mod(map%slot(i) - 1, corners) + 1)
                  call add_mass(m%particles%mass(of)/corners, m%grid%functions_in(e, map%local(:, c, of)), by_node)
               end associate
            end do
         else
            do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
               call add_mass(m%particles%mass(i), &
                             m%grid%functions_in(e, m%grid%local_coordinate(e, m%particles%place_in_grid(i))), by_node)
            end do
         end if
         call matrix_by_masters(m%grid, e, 1, by_node, n, masters, by_master)
         call add_element(self%numbering, masters(:n), by_master(:n, :n), self%masses)
      end do
   contains
      !> Add a mass at a place with these functions of the nodes.
      pure subroutine add_mass(mass, n, by_node)
         real(dp), intent(in) :: mass            !! [kg]
         real(dp), intent(in) :: n(:)
         real(dp), intent(inout) :: by_node(:, :)
         integer :: c
         do c = 1, size(n)
            by_node(:, c) = by_node(:, c) + mass*n(c)*n
         end do
      end subroutine add_mass
   end subroutine weigh_elements

   !> Find which forces change which openings: those that reach a node in common, all where masses are not lumped.
   subroutine find_pattern(self, are_lumped, n_points)
      type(interface_step_t), intent(inout) :: self
      logical, intent(in) :: are_lumped
      integer, intent(in) :: n_points
      integer, dimension(n_points) :: users, place ! of a node: how many unknowns reach it, and which clique they are
      integer, allocatable :: cliques(:, :)
      integer :: i, k, j, n
      if (.not. are_lumped) then
         n = ndim*size(self%responses)
         call pattern_of_cliques(n, reshape([(k, k=1, n)], [n, 1]), self%compliance)
         return
      end if
      users = 0
      do k = 1, size(self%responses)
         users(self%responses(k)%node) = users(self%responses(k)%node) + ndim
      end do
      n = 0
      do k = 1, n_points
         if (users(k) > 0) n = n + 1
         place(k) = n
      end do
      allocate (cliques(maxval(users), n), source=0)
      users = 0
      do k = 1, size(self%responses)
         do j = 1, size(self%responses(k)%node)
            associate (node => self%responses(k)%node(j))
               cliques(users(node) + 1:users(node) + ndim, place(node)) = ndim*(k - 1) + [(i, i=1, ndim)]
               users(node) = users(node) + ndim
            end associate
         end do
      end do
      call pattern_of_cliques(ndim*size(self%responses), cliques, self%compliance)
   end subroutine find_pattern

   !> Whether the force of a point does not depend on its opening, as long as the mesh stays: of those that a front has reached.
   pure logical function has_given_force(point)
      type(interface_point_t), intent(in) :: point
      has_given_force = point%law == releasing .and. point%plane > 0
   end function has_given_force

   !> Find W over beta dt**2: changes of the accelerations of the openings by unit forces. Openings by which no force changes have
   !> none.
   pure subroutine find_compliance(self, interfaces)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(in) :: interfaces
      real(dp) :: by_axis(ndim)
      integer :: row, k, j, d, c
      do row = 1, interfaces%n_at_end
         associate (of => self%responses(row), point => interfaces%list(row), w => self%compliance)
            if (size(of%mapped, 2) == 0) then
               w%value(w%row_start(ndim*(row - 1) + 1):w%row_start(ndim*row + 1) - 1) = 0
               cycle
            end if
            self%mapped(:, of%node) = of%mapped
            associate (first => w%row_start(ndim*(row - 1) + 1), &
                       n => w%row_start(ndim*(row - 1) + 2) - w%row_start(ndim*(row - 1) + 1))
               do k = 0, n - 1, ndim             ! columns of all unknowns of a point are beside each other
                  associate (other => self%responses(w%column(first + k + ndim - 1)/ndim), &
                             at => interfaces%list(w%column(first + k + ndim - 1)/ndim))
                     by_axis = 0
                     do j = 1, size(other%acceleration, 2)
                        by_axis = by_axis + self%mapped(:, other%node(j))*other%acceleration(:, j)
                     end do
                     do d = 1, ndim
                        do c = 1, ndim
                           w%value(first + (d - 1)*n + k + c - 1) = sum(by_axis*direction_of(point, d)*direction_of(at, c))
                        end do
                     end do
                  end associate
               end do
            end associate
            self%mapped(:, of%node) = 0
         end associate
      end do
   end subroutine find_compliance

   !> Open the points.
   subroutine open_by(self, interfaces, direction)
      type(interface_step_t), intent(in) :: self
      type(interfaces_t), intent(inout) :: interfaces
      real(dp), intent(in) :: direction(:)       !! normal and tangential, of all points, over beta [m]
      integer :: k
      do k = 1, interfaces%n_at_end
         associate (point => interfaces%list(k))
            point%opening = point%opening + self%beta(k)*vector_of(point, direction(ndim*(k - 1) + 1:ndim*k))
         end associate
      end do
   end subroutine open_by

   !> Openings of the points by forces: W f [m].
   pure function opened_by(self, f) result(direction)
      type(interface_step_t), intent(in) :: self
      real(dp), intent(in) :: f(:)               !! [N]
      real(dp) :: direction(size(f))
      integer :: i
      associate (w => self%compliance)
         do i = 1, w%n
            associate (first => w%row_start(i), last => w%row_start(i + 1) - 1)
               direction(i) = self%dt**2*dot_product(w%value(first:last), f(w%column(first:last)))
            end associate
         end do
      end associate
   end function opened_by

   !> Normal and tangential forces of the points by their law, at their openings [N].
   pure function forces_of_law(interfaces) result(f)
      type(interfaces_t), intent(in) :: interfaces
      real(dp) :: f(ndim*interfaces%n_at_end), force(ndim)
      integer :: k
      do k = 1, interfaces%n_at_end
         force = force_at(interfaces, k)
         f(ndim*(k - 1) + 1:ndim*k) = components_of(interfaces%list(k), force)
      end do
   end function forces_of_law

   !> Find the forces, with given friction limits. They are at the minimum of a convex potential, and an iteration that passes the
   !> minimum on its line returns to it.
   subroutine find_forces(self, interfaces, f, is_new, failure)
      type(interface_step_t), intent(inout) :: self
      type(interfaces_t), intent(inout) :: interfaces !! opened by the step and by -f
      real(dp), intent(inout) :: f(:)            !! [N]
      logical, intent(inout) :: is_new           !! whether W is, to which the matrix has to be made
      type(failure_t), intent(inout) :: failure
      real(dp), dimension(size(f)) :: rest, turned, direction, slopes
      real(dp) :: part, least, most, slope, of_least, of_most, last
      integer, allocatable :: states(:)
      integer :: turn, trial
      logical :: is_done
      allocate (states(interfaces%n))
      rest = forces_of_law(interfaces) - f
      do turn = 1, most_turns
         states = interface_states(interfaces)
         slopes = slopes_of_law(self, interfaces)
         is_new = is_new .or. any(states /= self%states) .or. any(slopes > self%slopes .or. slopes < lowered*self%slopes)
         if (is_new) then
            self%states = states
            self%slopes = slopes
            call factorise(self, failure)
            if (failure%failed()) return
         end if
         is_new = .false.
         slopes = self%slopes
         where (.not. slopes > 0)
            direction = rest
         elsewhere
            direction = 0
         end where
         direction = opened_by(self, direction)
         where (slopes > 0)
            direction = rest/slopes - direction
         elsewhere
            direction = rest
         end where
         call self%factor%solve(direction, turned)
         direction = -opened_by(self, turned)
         of_least = dot_product(direction, rest) ! the slope on the way, below 0 up to the least
         call go_by(1.0_dp)
         is_done = all(states == interface_states(interfaces))
         slope = dot_product(direction, rest)
         if (.not. (of_least < 0 .and. slope > -near*of_least)) then ! at 0 it is rounding
            if (is_done .and. (interfaces%n_cohesive > 0 .or. ndim > 2)) & ! not piecewise linear
               is_done = maxval(abs(rest)) <= of_cohesion*maxval(abs(f))
            if (is_done) return
            cycle
         end if
         least = 0
         most = 1
         of_most = slope
         part = 1
         do trial = 1, most_trials
            last = part
            part = least + (most - least)*min(0.9_dp, max(0.1_dp, of_least/(of_least - of_most)))
            call go_by(part - last)
            slope = dot_product(direction, rest)
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
      !> Go a part of the way of a turn, and find the residual there.
      subroutine go_by(step)
         real(dp), intent(in) :: step            !! [-]
         f = f + step*turned
         call open_by(self, interfaces, step*direction)
         rest = forces_of_law(interfaces) - f
      end subroutine go_by
   end subroutine find_forces

   !> Changes of the normal and the tangential forces of the points with these components of their openings [N/m]; of cohesion the
   !> secants, with which an iteration never overshoots.
   pure function slopes_of_law(self, interfaces) result(slopes)
      type(interface_step_t), intent(in) :: self
      type(interfaces_t), intent(in) :: interfaces
      real(dp) :: slopes(ndim*interfaces%n_at_end), tangent(ndim, ndim)
      type(cohesive_state_t) :: answer
      integer :: k, d
      do k = 1, interfaces%n_at_end
         tangent = stiffness_in_directions(interfaces, k)
         if (holds(interfaces%list(k))) then
            answer = cohesion_at(interfaces, k)
            tangent(:2, :2) = answer%secant(2:1:-1, 2:1:-1)
         end if
         do d = 1, ndim
            slopes(ndim*(k - 1) + d) = self%beta(k)*tangent(d, d)
         end do
      end do
   end function slopes_of_law

   !> Factorise W + 1/law' of the unknowns whose forces change with their openings.
   subroutine factorise(self, failure)
      type(interface_step_t), intent(inout) :: self
      type(failure_t), intent(inout) :: failure
      integer :: i
      self%matrix%value = self%dt**2*self%compliance%value
      do i = 1, self%matrix%n
         associate (first => self%matrix%row_start(i), last => self%matrix%row_start(i + 1) - 1, slopes => self%slopes)
            where (.not. (slopes(self%matrix%column(first:last)) > 0 .and. slopes(i) > 0)) self%matrix%value(first:last) = 0
         end associate
         if (self%slopes(i) > 0) then
            call self%matrix%add(i, i, 1/self%slopes(i))
         else
            call self%matrix%add(i, i, 1.0_dp)
         end if
      end do
      call self%factor%factorise(self%matrix, failure)
   end subroutine factorise

   !> Archive the data of the factorised matrix: forces by cohesion are found to a tolerance, and the iteration depends on it.
   subroutine archive_faces(self, archive)
      type(interface_step_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      integer :: points, unknowns
      points = 0
      unknowns = 0
      if (allocated(self%slopes)) points = size(self%states)
      if (allocated(self%slopes)) unknowns = size(self%slopes)
      call archive%section('interface_step')
      call archive%serialise('points', points)
      call archive%serialise('unknowns', unknowns)
      if (unknowns == 0 .or. archive%failure%failed()) return
      if (archive%is_read) allocate (self%states(points), self%slopes(unknowns))
      call archive%serialise('dt', self%dt)
      call archive%archive_integers('states', points, self%states)
      call archive%archive_reals('slopes', unknowns, self%slopes)
   end subroutine archive_faces
end module hampm_interface_step
