!> Stiffness of the material of a motion at small strain, by its particles as they stand in the grid, and solutions of K u = f: the
!> equilibrium of the motion, if any, and its change by other forces.
!>
!> Without supports K is partly singular. K may then be that of bodies on very soft interface points, proportional to the mass:
!> balanced forces do not load them, others accelerate the body as a whole.
!>
!> Of axisymmetric material N_a/R is a third derivative of a shape function, which gives H_33 from displacements in direction 1:
!> displacement gradients and stresses then have a third column with H_33 and stress_33 in direction 1.
!>
!> For equilibrium of any law K is the tangent: the change of internal forces with the displacement from the particles' present
!> state. For implicit steps a multiple of the mass matrix is added to it.
module hampm_stiffness
   use hampm_kinds, only: dp, ndim, corners, name_len
   use hampm_conjugate_gradients, only: solve_by_cg
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_element_assembly, only: pattern_of_elements, next_support, matrix_by_masters, add_element
   use hampm_factorisation, only: factorisation_t
   use hampm_interface_points, only: interface_states, interface_stiffness
   use hampm_jumps, only: nodes_of_jumps
   use hampm_failure, only: failure_t
   use hampm_loads, only: load_t, add_load, place_loads
   use hampm_mass_matrix, only: has_matrix
   use hampm_mass_product, only: find_concentrated_mass
   use hampm_multigrid, only: multigrid_t
   use hampm_problem, only: problem_t
   use hampm_numbering, only: numbering_t, number_unknowns, nodes_of_elements
   use hampm_rigid_motions, only: rigid_constraint_t, motions, motions_at
   use hampm_sparse, only: sparse_t
   use hampm_tensors, only: change_of_cofactors, identity, space
   use hampm_turned_faces, only: deformation_at
   use hampm_element_stiffness, only: change_of_stress, derivatives_at, element_stiffness, mean_gradient_in, n_derivatives, &
                                      strains_by_corners
   use hampm_vectors, only: multiply
   implicit none
   private
   public :: stiffness_t, stiffness_kind_t, usual_solver, most_direct, kind_at_rest, is_larger, new_stiffness, &
             factorise_stiffness, forces_of, full_loads

   !> Squared frequency of the interface points over that of a wave across the bodies: far below the first bending mode of an arm a
   !> hundred times its depth, far above rounding.
   real(dp), parameter :: softness = 1.0e-8_dp
   real(dp), parameter :: hardly = 1e-10_dp      !! over the stiffness of a piece of a cell, that which keeps it from being singular

   !> Factors of a solid take time as the square of the unknowns, and conjugate gradients with a multigrid hardly more iterations
   !> for more of them. Factors of a plane are cheaper up to the memory of a machine.
   character(*), parameter :: usual_solver = merge('auto  ', 'direct', ndim == 3)
   integer, parameter :: most_direct = 30000     !! unknowns of a solid that solver = 'auto' factorises

   !> Kind of a stiffness.
   type :: stiffness_kind_t
      logical :: is_tangent = .false.            !! of the present state, with every particle as one point; else of small
                                                 !! strain, where a particle alone in its cell is four points
      logical :: on_interfaces = .true.             !! soft interface points
      character(name_len) :: solver = usual_solver !! 'direct', 'cg' or, of solids, 'auto'
      type(rigid_constraint_t), allocatable :: rigid_constraints(:) !! constraints beside those of the model
      real(dp) :: mass_factor = 0                !! c of K + c M + b D, M being the mass matrix of the run [1/s2]
      real(dp) :: dashpot_factor = 0             !! b, with the matrix D of dashpots on edges [1/s]
      real(dp), allocatable :: factor(:)         !! of each load, if those that follow faces have their tangent [-]; else absent
   contains
      procedure, private :: has_form_of
   end type stiffness_kind_t

   !> A factorised stiffness, and its kind.
   type :: stiffness_t
      type(stiffness_kind_t), private :: kind
      integer, private :: layout = -1            !! of the blocks then; -1: none
      logical, allocatable, private :: fixed(:, :) !! the components that were fixed
      integer, allocatable, private :: states(:) !! states of interface points
      real(dp), private :: tangent_floor = 0     !! see `interfaces_t`
      type(numbering_t) :: unknowns
      real(dp) :: point = 0                     !! squared frequency of the interface points [1/s2]
      logical, private :: iterates = .false.     !! by conjugate gradients
      type(factorisation_t), private :: factorised
      type(multigrid_t), private :: multigrid    !! of a solid, for iterations
      type(sparse_t), private :: matrix          !! of which the pattern alone is kept where it is factorised
   contains
      procedure :: solve
      procedure :: solve_for_all
      procedure :: solve_for_unknowns
      procedure :: is_stable
      procedure :: release
      procedure, private :: fits
   end type stiffness_t

contains

   !> The stiffness that gives the equilibrium of unstrained material: the first tangent if a run finds equilibrium by it, to have
   !> the same factors, else on soft interface points.
   pure type(stiffness_kind_t) function kind_at_rest(m, rigid_constraints) result(kind)
      type(problem_t), intent(in) :: m
      type(rigid_constraint_t), intent(in) :: rigid_constraints(:)
      if (m%interfaces%are_moving .or. any(m%materials%mean_dilatation) .or. .not. all(m%materials%linear)) return
      kind%is_tangent = .true.
      kind%on_interfaces = .false.
      allocate (kind%rigid_constraints, source=rigid_constraints)
   end function kind_at_rest

   !> Assemble and factorise a stiffness of at most so many unknowns: of a kind, if present, else of small strain on interface
   !> points. `done` is false if there are more unknowns or memory is insufficient.
   subroutine new_stiffness(m, most_unknowns, stiffness, done, kind)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: most_unknowns
      type(stiffness_t), intent(inout) :: stiffness
      logical, intent(out) :: done
      type(stiffness_kind_t), intent(in), optional :: kind
      type(failure_t) :: failure                 ! ignored: without a solution there is only no estimate
      done = .not. is_larger(m, most_unknowns)
      if (.not. done) return
      if (present(kind)) then
         call factorise_stiffness(m, kind, stiffness, failure)
      else
         call stiffness%release()                ! it may belong to another problem
         call factorise_stiffness(m, stiffness_kind_t(), stiffness, failure)
      end if
      done = stiffness%unknowns%n > 0 .and. .not. failure%failed()
   end subroutine new_stiffness

   !> Whether there are more unknowns than that.
   pure logical function is_larger(m, most_unknowns)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: most_unknowns
      associate (all => m%fields%mass_matrix%all)
         is_larger = count(.not. m%constraints%fixed(:, all%nodes(:all%n_nodes))) > most_unknowns
      end associate
   end function is_larger

   !> Assemble and factorise, or make ready for iteration, a stiffness of some kind, unless it is there. Fails where it
   !> is singular or memory does not suffice.
   subroutine factorise_stiffness(m, kind, stiffness, failure)
      type(problem_t), intent(in) :: m
      type(stiffness_kind_t), intent(in) :: kind
      type(stiffness_t), intent(inout) :: stiffness
      type(failure_t), intent(inout) :: failure
      type(failure_t) :: unsolved
      if (stiffness%fits(m, kind)) return
      stiffness%kind = kind
      stiffness%fixed = m%constraints%fixed
      stiffness%states = interface_states(m%interfaces)
      stiffness%tangent_floor = m%interfaces%tangent_floor
      call number(m, stiffness)
      if (stiffness%unknowns%n > 0) call assemble_and_factorise(m, stiffness, unsolved)
      stiffness%layout = merge(-1, m%fields%layout, unsolved%failed())
      if (unsolved%failed()) call failure%report(unsolved%code, unsolved%message)
   end subroutine factorise_stiffness

   !> Whether a stiffness is still of a kind: of material with a constant tangent, with the same fixed components and states of
   !> interface points.
   pure logical function fits(self, m, kind)
      class(stiffness_t), intent(in) :: self
      type(problem_t), intent(in) :: m
      type(stiffness_kind_t), intent(in) :: kind
      fits = self%layout == m%fields%layout .and. all(m%materials%linear) .and. m%interfaces%n_cohesive == 0 .and. &
             self%kind%has_form_of(kind)
      if (fits) fits = all(self%fixed .eqv. m%constraints%fixed) .and. abs(self%tangent_floor - m%interfaces%tangent_floor) <= 0
      if (fits) fits = all(self%states == interface_states(m%interfaces))
   end function fits

   !> Whether two kinds are the same; on one mesh rigid-body constraints are the same if they hold the same components.
   pure logical function has_form_of(self, other)
      class(stiffness_kind_t), intent(in) :: self
      type(stiffness_kind_t), intent(in) :: other
      has_form_of = (self%is_tangent .eqv. other%is_tangent) .and. (self%on_interfaces .eqv. other%on_interfaces) .and. &
                    self%solver == other%solver .and. .not. abs(self%mass_factor - other%mass_factor) > 0
   end function has_form_of

   !> Assemble and factorise the stiffness of the present unknowns. CHOLMOD's symbolic analysis is reused while the pattern stays.
   subroutine assemble_and_factorise(m, stiffness, failure)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(inout) :: stiffness
      type(failure_t), intent(inout) :: failure
      type(sparse_t) :: matrix
      stiffness%iterates = stiffness%kind%solver == 'cg' .or. &
                           stiffness%kind%solver == 'auto' .and. stiffness%unknowns%n > most_direct
      if (stiffness%iterates) call stiffness%release() ! a matrix of before is not there beside the new one
      associate (cells => m%fields%mass_matrix%all%cells(:m%fields%mass_matrix%all%n_cells))
         call pattern_of_elements(m%grid, cells, stiffness%unknowns, matrix, &
                                  nodes_of_jumps(m%interfaces%list(:m%interfaces%n)%jump))
         call fill(m, cells, stiffness, matrix)
      end associate
      if (.not. stiffness%iterates) then
         if (.not. matrix%has_pattern_of(stiffness%matrix)) call stiffness%factorised%release()
         stiffness%factorised%solves_often = stiffness%kind%mass_factor > 0 .and. all(m%materials%linear) ! in a solution each step
         if (allocated(m%grid%planes)) & ! fronts that move open nodes in nearly each step: one solution with each factor
            stiffness%factorised%solves_often = stiffness%factorised%solves_often .and. .not. any(m%grid%planes%moves)
         call stiffness%factorised%factorise(matrix, failure)
         deallocate (matrix%value)
      end if
      call matrix%move_to(stiffness%matrix)
      if (stiffness%iterates .and. ndim == 3) call build_multigrid(m, stiffness, failure)
   end subroutine assemble_and_factorise

   !> Make the levels of the multigrid: rigid motions cost no energy.
   subroutine build_multigrid(m, stiffness, failure)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(inout) :: stiffness
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: motion(:, :)
      integer :: first(stiffness%unknowns%n + 1), i, n, nodes, last
      associate (unknowns => stiffness%unknowns)
         allocate (motion(motions, unknowns%n), source=0.0_dp)
         n = 0
         nodes = 0
         last = 0
         do i = 1, size(unknowns%node)
            associate (d => unknowns%direction(i), node => unknowns%node(i))
               if (unknowns%dof(d, node) <= n) cycle ! another node with the same motion
               n = n + 1
               if (node /= last) then
                  nodes = nodes + 1
                  first(nodes) = n
                  last = node
               end if
               motion(:, n) = motions_at(m%grid%node_position(:, node), d)
               if (allocated(unknowns%weight)) motion(:, n) = motion(:, n)/unknowns%weight(d, node)
            end associate
         end do
         first(nodes + 1) = n + 1
         call stiffness%multigrid%make_levels(stiffness%matrix, first(:nodes + 1), motion, failure)
      end associate
   end subroutine build_multigrid

   !> Number the unknowns.
   pure subroutine number(m, stiffness)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(inout) :: stiffness
      logical, allocatable :: fixed(:, :)
      integer, allocatable :: nodes(:)           ! nodes of occupied cells
      integer :: k
      associate (all => m%fields%mass_matrix%all)
         call nodes_of_elements(m%grid, all%cells(:all%n_cells), nodes)
      end associate
      allocate (fixed, source=m%constraints%fixed)
      if (allocated(m%constraints%turning)) fixed = fixed .and. m%constraints%turning == 0
      if (allocated(stiffness%kind%rigid_constraints)) then
         do k = 1, size(stiffness%kind%rigid_constraints)
            fixed(stiffness%kind%rigid_constraints(k)%direction, stiffness%kind%rigid_constraints(k)%node) = .true.
         end do
      end if
      call number_unknowns(nodes, fixed, stiffness%unknowns, m%constraints%turning, m%constraints%lever)
   end subroutine number

   !> Add the stiffness of all cells. Where few particles are, nodes have strain-free motions: these are weakly held, to be
   !> solvable.
   subroutine fill(m, cells, stiffness, matrix)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: cells(:)            !! the occupied elements
      type(stiffness_t), intent(inout) :: stiffness
      type(sparse_t), intent(inout) :: matrix
      real(dp), dimension(ndim*m%grid%n_functions, ndim*m%grid%n_functions) :: of_material, by_corner
      real(dp) :: by_master(ndim*most_nodes_of_leaf, ndim*most_nodes_of_leaf)
      integer :: masters(most_nodes_of_leaf), n, k, next, j, d, last ! the cell whose material this is
      stiffness%point = 0
      if (stiffness%kind%on_interfaces) &
         stiffness%point = softness*(maxval([(m%materials(k)%shear_wave_speed(), k=1, size(m%materials))])/extent(m))**2
      next = 1
      last = 0
      do while (next <= size(cells))
         k = next
         next = next_support(m%grid, cells, k)
         if (.not. are_alike(m, last, cells(k))) &
            call element_stiffness(m, cells(k:next - 1), stiffness%kind%is_tangent, stiffness%point, of_material)
         last = cells(k)
         by_corner = of_material
         do j = k, next - 1
            if (.not. (stiffness%kind%mass_factor > 0 .and. has_matrix(m%fields%mass_matrix, cells(j)))) cycle
            associate (mass => m%fields%mass_matrix, cell => m%fields%mass_matrix%cell_of(cells(j)))
               do d = 1, ndim
                  by_corner(d::ndim, d::ndim) = by_corner(d::ndim, d::ndim) + stiffness%kind%mass_factor*mass%cell(:, :, cell)
               end do
            end associate
         end do
         call matrix_by_masters(m%grid, cells(k), ndim, by_corner, n, masters, by_master)
         if (m%grid%is_quadratic() .and. stiffness%kind%mass_factor > 0) then
            continue                             ! the ghost penalty holds them, and its masses
         else if (any([(may_be_loose(m, cells(j)), j=k, next - 1)])) then
            do d = 1, ndim*n
               by_master(d, d) = by_master(d, d) + hardly*maxval(by_corner)
            end do
         end if
         call add_element(stiffness%unknowns, masters(:n), by_master(:ndim*n, :ndim*n), matrix)
      end do
      if (stiffness%kind%mass_factor > 0) call add_concentrated_mass(m, stiffness, matrix)
      if (stiffness%kind%dashpot_factor > 0) call add_dashpots(m, stiffness, matrix)
      call add_interfaces(m, stiffness%kind%mass_factor, stiffness%unknowns, matrix)
      if (allocated(stiffness%kind%factor)) call add_followers(m, stiffness, matrix)
   end subroutine fill

   !> Add the tangent of loads that follow faces, in iterations its symmetric part: the whole is symmetric for a closed surface
   !> under one pressure.
   subroutine add_followers(m, stiffness, matrix)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(in) :: stiffness
      type(sparse_t), intent(inout) :: matrix
      real(dp) :: by_corner(ndim*m%grid%n_functions, ndim*m%grid%n_functions)
      real(dp) :: by_master(ndim*most_nodes_of_leaf, ndim*most_nodes_of_leaf)
      integer :: masters(most_nodes_of_leaf), n, l, k
      do l = 1, size(m%loads)
         if (.not. allocated(m%loads(l)%follows)) cycle
         matrix%is_symmetric = matrix%is_symmetric .and. stiffness%iterates
         do k = 1, size(m%loads(l)%particle)
            associate (cell => m%particles%cell(m%loads(l)%particle(k)))
               by_corner = follower_tangent(m, m%loads(l), k, stiffness%kind%factor(l))
               if (stiffness%iterates) by_corner = (by_corner + transpose(by_corner))/2
               call matrix_by_masters(m%grid, cell, ndim, by_corner, n, masters, by_master)
            end associate
            call add_element(stiffness%unknowns, masters(:n), by_master(:ndim*n, :ndim*n), matrix)
         end do
      end do
   end subroutine add_followers

   !> Decrease of a point's force of a load that follows faces, by displacements of its cell's corners [N/m]: cof(F) is quadratic.
   pure function follower_tangent(m, load, k, factor) result(matrix)
      type(problem_t), intent(in) :: m
      type(load_t), intent(in) :: load
      integer, intent(in) :: k                   !! the point
      real(dp), intent(in) :: factor             !! of the load [-]
      real(dp) :: matrix(ndim*m%grid%n_functions, ndim*m%grid%n_functions)
      real(dp) :: strain(ndim*n_derivatives(m), ndim*m%grid%n_functions), dh(ndim, n_derivatives(m)), force(ndim)
      real(dp), dimension(space, space) :: f, df, change
      integer :: j, n
      n = size(matrix, 1)
      matrix = 0
      associate (i => load%particle(k), p => m%particles)
         if (.not. load%follows(p%material(i))) return
         strain = strains_by_corners(derivatives_at(m, i), mean_gradient_in(m, p%cell(i)), &
                                     m%materials(p%material(i))%mean_dilatation)
         f = deformation_at(p, i)
         do j = 1, n
            dh = reshape(strain(:, j), shape(dh))
            df = 0
            df(:ndim, :ndim) = dh(:, :ndim)
            if (size(dh, 2) > ndim) df(space, space) = dh(1, ndim + 1)
            change = change_of_cofactors(f, df)
            force = factor*load%fraction(k)*matmul(change(:ndim, :ndim), load%force)
            matrix(:, j) = -reshape(spread(force, 2, n/ndim)*spread(load%shape(:, k), 1, ndim), [n])
         end do
      end associate
   end function follower_tangent

   !> Whether two bilinear cells have the same stiffness by the same linear material at the same places.
   pure logical function are_alike(m, a, b)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: a, b                !! elements; of the first 0 for none
      real(dp), parameter :: same = 1e-12_dp     ! of places, in cells, and of a particle's columns
      integer :: n, i, j
      are_alike = .false.
      if (a == 0 .or. m%grid%is_quadratic() .or. m%particles%thickness%is_ring .or. .not. all(m%materials%linear)) return
      associate (p => m%particles, of => m%blocks, size => m%grid%element_size, lower => m%grid%element_lower)
         if (abs(size(a) - size(b)) > same*size(a) .or. of%count_in(a) /= of%count_in(b)) return
         do n = 0, of%count_in(a) - 1
            i = of%first_in(a) + n*of%stride_in(a)
            j = of%first_in(b) + n*of%stride_in(b)
            if (p%material(i) /= p%material(j) .or. abs(p%volume(i) - p%volume(j)) > same*p%volume(i) .or. &
                abs(p%mass(i) - p%mass(j)) > same*p%mass(i)) return
            if (any(abs(p%place_in_grid(i) - lower(:, a) - p%place_in_grid(j) + lower(:, b)) > same*size(a))) return
         end do
      end associate
      are_alike = .true.
   end function are_alike

   !> Whether nodes of an element may move without straining a particle: of a cut piece of a leaf, and of a partly empty leaf beside
   !> finer ones, whose far nodes may belong to the hanging node in its middle alone.
   pure logical function may_be_loose(m, e)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      may_be_loose = m%grid%is_piece(e) .or. (allocated(m%grid%bodies) .and. m%blocks%count_in(e) < corners)
      if (may_be_loose) return
      associate (leaf => m%grid%element_leaf(e))
         may_be_loose = any(m%blocks%count_in(m%grid%leaf_element(leaf):m%grid%leaf_element(leaf + 1) - 1) == 0)
      end associate
   end function may_be_loose

   !> Add the stiffness of interface points between faces: c_i c_j times that of the opening, and a multiple of their masses.
   subroutine add_interfaces(m, mass_factor, unknowns, matrix)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: mass_factor        !! [1/s2]
      type(numbering_t), intent(in) :: unknowns
      type(sparse_t), intent(inout) :: matrix
      real(dp), parameter :: rounding = 1e-12_dp ! part of a tangent that counts as none
      real(dp) :: tangent(ndim, ndim), by_node(2*ndim*most_nodes_of_leaf, 2*ndim*most_nodes_of_leaf)
      integer :: k, i, j, n
      do k = 1, m%interfaces%n
         tangent = interface_stiffness(m%interfaces, k) + mass_factor*m%interfaces%list(k)%jump%mass*identity
         matrix%is_symmetric = matrix%is_symmetric .and. abs(tangent(1, 2) - tangent(2, 1)) <= rounding*maxval(abs(tangent))
         associate (node => m%interfaces%list(k)%jump%node, share => m%interfaces%list(k)%jump%share)
            n = count(node > 0)
            do j = 1, n
               do i = 1, n
                  by_node(ndim*(i - 1) + 1:ndim*i, ndim*(j - 1) + 1:ndim*j) = tangent*share(i)*share(j)
               end do
            end do
            call add_element(unknowns, node(:n), by_node(:ndim*n, :ndim*n), matrix)
         end associate
      end do
   end subroutine add_interfaces

   !> Add the diagonal part of the mass matrix beside the matrices of cells.
   subroutine add_concentrated_mass(m, stiffness, matrix)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(in) :: stiffness
      type(sparse_t), intent(inout) :: matrix
      real(dp), allocatable :: mass(:)
      real(dp), allocatable :: square(:, :)      ! of weights
      integer :: i
      call find_concentrated_mass(m%grid, m%fields%mass_matrix, mass)
      allocate (square(ndim, m%grid%n_nodes), source=1.0_dp)
      associate (unknowns => stiffness%unknowns)
         if (allocated(unknowns%weight)) square = unknowns%weight**2
         do i = 1, size(unknowns%node)
            associate (d => unknowns%direction(i), node => unknowns%node(i))
               call matrix%add(unknowns%dof(d, node), unknowns%dof(d, node), stiffness%kind%mass_factor*square(d, node)*mass(node))
            end associate
         end do
      end associate
   end subroutine add_concentrated_mass

   !> Add the dashpots on edges.
   subroutine add_dashpots(m, stiffness, matrix)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(in) :: stiffness
      type(sparse_t), intent(inout) :: matrix
      integer :: k
      do k = 1, m%absorbing%n
         call add_element(stiffness%unknowns, m%absorbing%node(k:k), stiffness%kind%dashpot_factor*m%absorbing%d(:, :, k), matrix)
      end do
   end subroutine add_dashpots

   !> The longer side of the box around all particles [m].
   pure real(dp) function extent(m)
      type(problem_t), intent(in) :: m
      associate (x => m%particles%reference(:m%particles%n, :))
         extent = max(maxval(maxval(x, dim=1) - minval(x, dim=1)), m%grid%finest_cell)
      end associate
   end function extent

   !> The forces of all loads at their largest or, where there is no load, those that stop the bodies as they move at first, in the
   !> time in which a wave runs through them [N], (ndim, n_points).
   subroutine full_loads(m, force, factors)
      type(problem_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: force(:, :)
      real(dp), intent(in), optional :: factors(:) !! of the loads in place of their largest ones [-]
      real(dp) :: rate                           ! [1/s]
      integer :: k, i
      allocate (force(ndim, m%grid%n_points), source=0.0_dp)
      call place_loads(m%loads, m%grid, m%particles)
      do k = 1, size(m%loads)
         if (present(factors)) call add_load(m%loads(k), factors(k), force)
         if (.not. present(factors)) call add_load(m%loads(k), m%loads(k)%history%largest_factor(), force)
      end do
      if (size(m%loads) > 0) return
      rate = maxval([(m%materials(k)%dilatational_wave_speed(), k=1, size(m%materials))])/extent(m)
      associate (p => m%particles)
         do i = 1, p%n
            associate (at => m%nodes_of(i))
               force(:, at) = force(:, at) - rate*p%mass(i)*spread(p%velocity(i, :), 2, size(at))*spread(m%functions_of(i), 1, ndim)
            end associate
         end do
      end associate
   end subroutine full_loads

   !> Displacement of the points by forces on them [m]; forces on hanging nodes are condensed to their masters. Fails if an
   !> iteration does not converge.
   subroutine solve(self, m, force, u, failure)
      class(stiffness_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      real(dp), intent(in), contiguous :: force(:, :) !! [N], (ndim, n_points)
      real(dp), allocatable, intent(out) :: u(:, :)  !! (ndim, n_points)
      type(failure_t), intent(inout), optional :: failure !! absent in estimates
      type(failure_t) :: unsolved
      real(dp), allocatable :: condensed(:, :), x(:)
      allocate (condensed, mold=force)
      allocate (u(ndim, m%grid%n_points), source=0.0_dp)
      call multiply(size(force), 1.0_dp, force, condensed)
      allocate (x(self%unknowns%n))
      associate (all => m%fields%mass_matrix%all)
         call m%grid%dofs%condense(all, ndim, condensed)
         if (self%unknowns%n > 0) call solve_for_unknowns(self, self%unknowns%gather(condensed), x, unsolved)
         if (present(failure) .and. unsolved%failed()) call failure%report(unsolved%code, &
            'the stiffness cannot be solved with: '//unsolved%message//'; use &method solver = ''direct''')
         call self%unknowns%scatter(x, u)
         call m%grid%dofs%distribute(all, ndim, u)
      end associate
   end subroutine solve

   !> x = K^-1 b. Fails where an iteration does not end.
   subroutine solve_for_unknowns(self, b, x, failure)
      class(stiffness_t), intent(inout) :: self
      real(dp), intent(in), contiguous :: b(:)
      real(dp), intent(out), contiguous :: x(:)
      type(failure_t), intent(inout) :: failure
      if (.not. self%iterates) then
         call self%factorised%solve(b, x)
      else if (ndim == 3) then
         call solve_by_cg(self%matrix, b, x, failure, self%multigrid)
      else
         call solve_by_cg(self%matrix, b, x, failure)
      end if
   end subroutine solve_for_unknowns

   !> The same for several forces by the factors, which takes less time than one after the other.
   subroutine solve_for_all(self, m, force, u)
      class(stiffness_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: force(:, :, :)     !! [N], (ndim, n_points, forces)
      real(dp), allocatable, intent(out) :: u(:, :, :) !! (ndim, n_points, forces)
      real(dp), allocatable :: b(:), x(:)        ! side by side at each unknown
      real(dp) :: of_one(merge(self%unknowns%n, 0, self%iterates))
      type(failure_t) :: unsolved                ! ignored: these are estimates
      integer :: k
      allocate (u, source=force)
      associate (n => self%unknowns%n, width => size(force, 3), all => m%fields%mass_matrix%all)
         allocate (b(n*width), x(n*width))
         do k = 1, width
            call m%grid%dofs%condense(all, ndim, u(:, :, k))
            b(k::width) = self%unknowns%gather(u(:, :, k))
         end do
         if (self%iterates) then
            do k = 1, width
               call solve_for_unknowns(self, b(k::width), of_one, unsolved)
               x(k::width) = of_one
            end do
         else if (size(b) > 0) then
            call self%factorised%solve(b, x)
         end if
         u = 0
         do k = 1, width
            call self%unknowns%scatter(x(k::width), u(:, :, k))
            call m%grid%dofs%distribute(all, ndim, u(:, :, k))
         end do
      end associate
   end subroutine solve_for_all

   !> Whether an equilibrium with this stiffness is stable: it is positive definite. (An iteration fails where it is not.)
   pure logical function is_stable(self)
      class(stiffness_t), intent(in) :: self
      is_stable = self%unknowns%n == 0 .or. self%iterates .or. self%factorised%is_definite
   end function is_stable

   !> Nodal forces against a small displacement from the present state, K u, without interface points, condensed [N].
   subroutine forces_of(m, u, force, factor)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: u(:, :)            !! of the points [m], (ndim, n_points)
      real(dp), allocatable, intent(out) :: force(:, :) !! (ndim, n_points)
      real(dp), intent(in), optional :: factor(:) !! of each load, for those that follow faces [-]
      real(dp) :: strain(ndim*n_derivatives(m), ndim*m%grid%n_functions), dh(ndim, n_derivatives(m)), &
                  mean(m%grid%n_functions, n_derivatives(m))
      integer :: k, i, l
      allocate (force(ndim, m%grid%n_points), source=0.0_dp)
      associate (p => m%particles, b => m%blocks)
         do k = 1, b%n_occupied
            associate (e => b%occupied(k), at => m%grid%support_of(b%occupied(k)))
               if (.not. any(abs(u(:, at)) > 0)) cycle
               mean = mean_gradient_in(m, e)
               do i = b%first_in(e), b%last_in(e), b%stride_in(e)
                  associate (material => m%materials(p%material(i)))
                     strain = strains_by_corners(derivatives_at(m, i), mean, material%mean_dilatation)
                     dh = reshape(matmul(strain, reshape(u(:, at), [size(strain, 2)])), shape(dh))
                     dh = change_of_stress(material, p%gradient_of(i), dh, p%history_of(i), p%hoop_of(i))
                     force(:, at) = force(:, at) + p%volume(i)*reshape(matmul(reshape(dh, [size(dh)]), strain), [ndim, size(at)])
                  end associate
               end do
            end associate
         end do
         do l = 1, merge(size(m%loads), 0, present(factor))
            if (.not. allocated(m%loads(l)%follows)) cycle
            do i = 1, size(m%loads(l)%particle)
               associate (at => m%grid%support_of(p%cell(m%loads(l)%particle(i))))
                  force(:, at) = force(:, at) + reshape(matmul(follower_tangent(m, m%loads(l), i, factor(l)), &
                                                               reshape(u(:, at), [size(u(:, at))])), [ndim, size(at)])
               end associate
            end do
         end do
      end associate
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, force)
   end subroutine forces_of

   !> Free the memory.
   subroutine release(self)
      class(stiffness_t), intent(inout) :: self
      call self%factorised%release()
      call self%multigrid%release()
      self%matrix = sparse_t()
      self%layout = -1
   end subroutine release
end module hampm_stiffness
