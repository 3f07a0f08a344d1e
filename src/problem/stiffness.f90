!> The stiffness of a motion's material at small strain, by its particles as they stand in the grid, and solutions of K u = f with it:
!> the place at which the motion comes to rest, if it does, and what changes there by other forces.
!>
!> Where nothing holds a body, a part of K is singular. So K may be that of bodies on very soft interface points, everywhere in proportion
!> to the mass: forces that balance each other do not feel them, others accelerate the body as a whole.
!>
!> Of axisymmetric material N_a/R is a third derivative of a shape function, by which displacements in direction 1 give H_33: displacement gradients and
!> stresses then have a third column with that and stress_33 in direction 1.
!>
!> For equilibrium of any law K is the tangent: how internal forces change with the displacement from the particles' present state.
!> For implicit steps a multiple of the mass matrix is added to it.
module hampm_stiffness
   use hampm_kinds, only: dp, ndim, corners, name_len
   use hampm_basis, only: inside_cell, points_of_quadratic
   use hampm_conjugate_gradients, only: solve_by_cg
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_element_assembly, only: pattern_of_elements, matrix_by_masters, add_element
   use hampm_factorisation, only: factorisation_t
   use hampm_interface_points, only: interface_stiffness
   use hampm_jumps, only: nodes_of_jumps
   use hampm_failure, only: failure_t
   use hampm_loads, only: add_load, place_loads
   use hampm_mass_matrix, only: has_matrix
   use hampm_mass_product, only: find_concentrated_mass
   use hampm_law, only: most_columns
   use hampm_material, only: material_t
   use hampm_problem, only: problem_t
   use hampm_numbering, only: numbering_t, number_unknowns, nodes_of_elements
   use hampm_rigid_motions, only: rigid_constraint_t
   use hampm_sparse, only: sparse_t
   use hampm_tensors, only: identity, trace
   implicit none
   private
   public :: stiffness_t, stiffness_kind_t, new_stiffness, factorise_stiffness, forces_of, full_loads, stiff_points, gradient_at, &
             derivatives_at, n_derivatives, local_of

   !> Squared frequency of the interface points over that of a wave that crosses the bodies: far below that of the first bending of an arm
   !> of a hundred times its depth, far above rounding.
   real(dp), parameter :: softness = 1.0e-8_dp
   real(dp), parameter :: hardly = 1e-10_dp      !! over the stiffness of a piece of a cell, that which keeps it from being singular

   !> Which stiffness is wanted.
   type :: stiffness_kind_t
      logical :: is_tangent = .false.            !! that of the present state, with every particle as one point; else that of small
                                                 !! strain, where a particle alone in its cell is four points
      logical :: on_interfaces = .true.             !! see above
      character(name_len) :: solver = 'direct'   !! 'direct' or 'cg'
      type(rigid_constraint_t), allocatable :: rigid_constraints(:) !! what is held beside what the constraints hold
      real(dp) :: mass_factor = 0                !! c of K + c M, M being the mass matrix of the run [1/s2]
   end type stiffness_kind_t

   !> A factorised stiffness.
   type :: stiffness_t
      type(stiffness_kind_t), private :: kind
      integer, allocatable, private :: nodes(:)  !! those of occupied cells
      type(numbering_t), private :: unknowns
      real(dp) :: point = 0                     !! squared frequency of the interface points [1/s2]
      type(factorisation_t), private :: factorised
      type(sparse_t), private :: matrix          !! of which the pattern alone is kept where it is factorised
   contains
      procedure :: solve
      procedure :: on_unknowns
      procedure :: is_stable
      procedure :: release
   end type stiffness_t

contains

   !> Assemble and factorise the stiffness of small strain on interface points, of at most so many unknowns. `done` is false where there are more unknowns or memory does
   !> not suffice.
   subroutine new_stiffness(m, most_unknowns, stiffness, done)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: most_unknowns
      type(stiffness_t), intent(inout) :: stiffness
      logical, intent(out) :: done
      type(failure_t) :: failure                 ! nobody is told: without a solution there is only no estimate
      call stiffness%release()
      stiffness%kind = stiffness_kind_t()
      call number(m, stiffness)
      done = stiffness%unknowns%n > 0 .and. stiffness%unknowns%n <= most_unknowns
      if (.not. done) return
      call assemble_and_factorise(m, stiffness, failure)
      done = .not. failure%failed()
   end subroutine new_stiffness

   !> Assemble and factorise, or make ready for iteration, a stiffness of some kind. Fails where it
   !> is singular or memory does not suffice.
   subroutine factorise_stiffness(m, kind, stiffness, failure)
      type(problem_t), intent(in) :: m
      type(stiffness_kind_t), intent(in) :: kind
      type(stiffness_t), intent(inout) :: stiffness
      type(failure_t), intent(inout) :: failure
      stiffness%kind = kind
      call number(m, stiffness)
      if (stiffness%unknowns%n > 0) call assemble_and_factorise(m, stiffness, failure)
   end subroutine factorise_stiffness

   !> Assemble and factorise the stiffness of the unknowns that there are. What CHOLMOD found out of the pattern of the last one is
   !> kept as long as that stays.
   subroutine assemble_and_factorise(m, stiffness, failure)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(inout) :: stiffness
      type(failure_t), intent(inout) :: failure
      type(sparse_t) :: matrix
      associate (cells => m%fields%mass_matrix%all%cells(:m%fields%mass_matrix%all%n_cells))
         call pattern_of_elements(m%grid, cells, stiffness%unknowns, matrix, &
                                  nodes_of_jumps(m%interfaces%list(:m%interfaces%n)%jump_t))
         call fill(m, cells, stiffness, matrix)
      end associate
      if (stiffness%kind%solver /= 'cg') then
         if (.not. matrix%has_pattern_of(stiffness%matrix)) call stiffness%factorised%release()
         call stiffness%factorised%factorise(matrix, failure)
         deallocate (matrix%value)
      end if
      stiffness%matrix = matrix
   end subroutine assemble_and_factorise

   !> Number the unknowns.
   pure subroutine number(m, stiffness)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(inout) :: stiffness
      logical, allocatable :: fixed(:, :)
      integer :: k
      associate (all => m%fields%mass_matrix%all)
         call nodes_of_elements(m%grid, all%cells(:all%n_cells), stiffness%nodes)
      end associate
      allocate (fixed, source=m%constraints%fixed)
      if (allocated(stiffness%kind%rigid_constraints)) then
         do k = 1, size(stiffness%kind%rigid_constraints)
            fixed(stiffness%kind%rigid_constraints(k)%direction, stiffness%kind%rigid_constraints(k)%node) = .true.
         end do
      end if
      call number_unknowns(stiffness%nodes, fixed, stiffness%unknowns)
   end subroutine number

   !> Add the stiffness of all cells. Where few particles are, nodes have motions that strain nothing: these are hardly held, to have some
   !> solution.
   subroutine fill(m, cells, stiffness, matrix)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: cells(:)            !! the occupied elements
      type(stiffness_t), intent(inout) :: stiffness
      type(sparse_t), intent(inout) :: matrix
      real(dp) :: by_corner(ndim*m%grid%n_functions, ndim*m%grid%n_functions), &
                  by_master(ndim*most_nodes_of_leaf, ndim*most_nodes_of_leaf)
      integer :: masters(most_nodes_of_leaf), n, k, d
      stiffness%point = 0
      if (stiffness%kind%on_interfaces) &
         stiffness%point = softness*(maxval([(m%materials(k)%shear_wave_speed(), k=1, size(m%materials))])/extent(m))**2
      do k = 1, size(cells)
         call element_stiffness(m, cells(k), stiffness, by_corner)
         if (stiffness%kind%mass_factor > 0 .and. has_matrix(m%fields%mass_matrix, cells(k))) then
            associate (mass => m%fields%mass_matrix%cell(:, :, m%fields%mass_matrix%cell_of(cells(k))))
               do d = 1, ndim
                  by_corner(d::ndim, d::ndim) = by_corner(d::ndim, d::ndim) + stiffness%kind%mass_factor*mass
               end do
            end associate
         end if
         call matrix_by_masters(m%grid, cells(k), ndim, by_corner, n, masters, by_master)
         if (m%grid%is_quadratic() .and. stiffness%kind%mass_factor > 0) then
            continue                             ! the ghost penalty holds them, and its masses
         else if (may_be_loose(m, cells(k))) then
            do d = 1, ndim*n
               by_master(d, d) = by_master(d, d) + hardly*maxval(by_corner)
            end do
         end if
         call add_element(stiffness%unknowns, masters(:n), by_master(:ndim*n, :ndim*n), matrix)
      end do
      if (stiffness%kind%mass_factor > 0) call add_concentrated_mass(m, stiffness, matrix)
      call add_interfaces(m, stiffness%kind%mass_factor, stiffness%unknowns, matrix)
   end subroutine fill

   !> Whether nodes of an element may move without straining a particle: of a piece of a leaf, as a crack or the edge of a body cuts it, and
   !> of a leaf beside finer ones that is partly empty, whose far nodes only the hanging one in its middle may have.
   pure logical function may_be_loose(m, e)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      may_be_loose = m%grid%is_piece(e) .or. (allocated(m%grid%bodies) .and. m%blocks%count_in(e) < corners)
      if (may_be_loose) return
      associate (leaf => m%grid%element_leaf(e))
         may_be_loose = any(m%blocks%count_in(m%grid%leaf_element(leaf):m%grid%leaf_element(leaf + 1) - 1) == 0)
      end associate
   end function may_be_loose

   !> Add the stiffness of interface points between faces: c_i c_j times that of the opening, and so many times their masses.
   subroutine add_interfaces(m, mass_factor, unknowns, matrix)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: mass_factor        !! [1/s2]
      type(numbering_t), intent(in) :: unknowns
      type(sparse_t), intent(inout) :: matrix
      real(dp), parameter :: rounding = 1e-12_dp ! part of a tangent that counts as none
      real(dp) :: tangent(ndim, ndim)
      integer :: k, i, j, d, c
      do k = 1, m%interfaces%n
         tangent = interface_stiffness(m%interfaces, k) + mass_factor*m%interfaces%list(k)%mass*identity
         matrix%is_symmetric = matrix%is_symmetric .and. abs(tangent(1, 2) - tangent(2, 1)) <= rounding*maxval(abs(tangent))
         associate (node => m%interfaces%list(k)%node, share => m%interfaces%list(k)%share)
            do j = 1, count(node > 0)
               do i = 1, count(node > 0)
                  do d = 1, ndim
                     do c = 1, ndim
                        if (min(unknowns%dof(c, node(i)), unknowns%dof(d, node(j))) == 0) cycle
                        call matrix%add(unknowns%dof(c, node(i)), unknowns%dof(d, node(j)), tangent(c, d)*share(i)*share(j))
                     end do
                  end do
               end do
            end do
         end associate
      end do
   end subroutine add_interfaces

   !> Add what of the mass matrix is on its diagonal beside the matrices of the cells.
   subroutine add_concentrated_mass(m, stiffness, matrix)
      type(problem_t), intent(in) :: m
      type(stiffness_t), intent(in) :: stiffness
      type(sparse_t), intent(inout) :: matrix
      real(dp), allocatable :: mass(:)
      integer :: k, d
      call find_concentrated_mass(m%grid, m%fields%mass_matrix, mass)
      associate (all => m%fields%mass_matrix%all, dof => stiffness%unknowns%dof)
         do k = 1, all%n_nodes                   ! two of a tied pair have one unknown
            do d = 1, ndim
               associate (i => dof(d, all%nodes(k)))
                  if (i > 0) call matrix%add(i, i, stiffness%kind%mass_factor*mass(all%nodes(k)))
               end associate
            end do
         end do
      end associate
   end subroutine add_concentrated_mass

   !> The longer side of the box around all particles [m].
   pure real(dp) function extent(m)
      type(problem_t), intent(in) :: m
      associate (x => m%particles%reference(:m%particles%n, :))
         extent = max(maxval(maxval(x, dim=1) - minval(x, dim=1)), m%grid%finest_cell)
      end associate
   end function extent

   !> Stiffness of an element, by corner, its directions one after the other [N/m]. Particles of the same moduli, as those of a material
   !> at small strain have, need only the sum of the products of their gradients.
   pure subroutine element_stiffness(m, e, stiffness, matrix)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      type(stiffness_t), intent(in) :: stiffness !! its kind and its interface points
      real(dp), intent(out) :: matrix(:, :)
      real(dp), allocatable :: gradient(:, :, :)
      real(dp) :: products(n_derivatives(m)*m%grid%n_functions, n_derivatives(m)*m%grid%n_functions), h(ndim, ndim), hoop, &
                  old_state(most_columns)
      integer :: i, k
      logical :: is_last
      matrix = 0
      if (stiffness%kind%is_tangent .and. shares_dilatation(m, e)) then
         call tangent_by_means(m, e, matrix)
         return
      end if
      if (stiffness%kind%is_tangent) allocate (gradient(m%grid%n_functions, n_derivatives(m), 1))
      products = 0
      h = 0
      hoop = 0
      old_state = 0
      associate (p => m%particles, b => m%blocks, is_tangent => stiffness%kind%is_tangent)
         do i = b%first_in(e), b%last_in(e), b%stride_in(e)
            if (is_tangent) then
               gradient(:, :, 1) = derivatives_at(m, i)
            else
               call stiff_points(m, e, i, gradient)
            end if
            do k = 1, size(gradient, 3)
               call sum_products(p%volume(i)/size(gradient, 3), gradient(:, :, k), products)
            end do
            do k = 1, size(matrix, 1)
               matrix(k, k) = matrix(k, k) + stiffness%point*p%mass(i)/m%grid%n_functions
            end do
            associate (material => m%materials(p%material(i)))
               is_last = i == b%last_in(e) .or. is_tangent .and. .not. material%linear
               if (.not. is_last) is_last = p%material(i + b%stride_in(e)) /= p%material(i)
               if (.not. is_last) cycle
               if (is_tangent) h = p%gradient_of(i)
               if (is_tangent) hoop = p%hoop_of(i)
               if (is_tangent) old_state = p%history_of(i)
               call add_products(moduli_of(material, n_derivatives(m), h, old_state, hoop), products, matrix)
               products = 0
            end associate
         end do
      end associate
   end subroutine element_stiffness

   !> Whether particles of an element share their dilatation.
   pure logical function shares_dilatation(m, e) result(shares)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      shares = any(m%materials%mean_dilatation)
      if (shares) shares = any(m%materials(m%particles%material(m%blocks%first_in(e):m%blocks%last_in(e): &
                                                               m%blocks%stride_in(e)))%mean_dilatation)
   end function shares_dilatation

   !> Mean gradients of the shape functions over the particles of an element that share their dilatation [1/m].
   pure function mean_gradient_in(m, e) result(mean)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      real(dp) :: mean(m%grid%n_functions, n_derivatives(m)), volume
      integer :: i
      mean = 0
      volume = 0
      if (.not. shares_dilatation(m, e)) return
      associate (p => m%particles, b => m%blocks)
         do i = b%first_in(e), b%last_in(e), b%stride_in(e)
            if (.not. m%materials(p%material(i))%mean_dilatation) cycle
            mean = mean + p%volume(i)*derivatives_at(m, i)
            volume = volume + p%volume(i)
         end do
      end associate
      mean = mean/volume
   end function mean_gradient_in

   !> Tangent of an element whose particles share their dilatation, as `element_stiffness`: forces by the displacement of each
   !> corner in each direction.
   pure subroutine tangent_by_means(m, e, matrix)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      real(dp), intent(inout) :: matrix(:, :)
      real(dp), dimension(m%grid%n_functions, n_derivatives(m)) :: gradient, mean
      real(dp) :: moduli(ndim, n_derivatives(m), ndim, n_derivatives(m)), u(ndim, m%grid%n_functions), &
                  stress(ndim, n_derivatives(m))
      integer :: i, j, k, dofs
      dofs = size(matrix, 1)
      mean = mean_gradient_in(m, e)
      associate (p => m%particles, b => m%blocks)
         do i = b%first_in(e), b%last_in(e), b%stride_in(e)
            associate (material => m%materials(p%material(i)))
               gradient = derivatives_at(m, i)
               moduli = moduli_of(material, n_derivatives(m), p%gradient_of(i), p%history_of(i), p%hoop_of(i))
               do k = 1, dofs
                  u = reshape([(merge(1.0_dp, 0.0_dp, j == k), j=1, dofs)], [ndim, m%grid%n_functions])
                  stress = product_of_moduli(moduli, strain_by(u, gradient, mean, material%mean_dilatation))
                  matrix(:, k) = matrix(:, k) + p%volume(i)*reshape(forces_by(stress, gradient, mean, material%mean_dilatation), &
                                                                    [dofs])
               end do
            end associate
         end do
      end associate
   end subroutine tangent_by_means

   !> Stress of moduli and a displacement gradient [Pa].
   pure function product_of_moduli(moduli, h) result(stress)
      real(dp), intent(in) :: moduli(:, :, :, :), h(:, :)
      real(dp) :: stress(ndim, size(h, 2))
      integer :: j, k
      stress = 0
      do k = 1, size(h, 2)
         do j = 1, ndim
            stress = stress + moduli(:, :, j, k)*h(j, k)
         end do
      end do
   end function product_of_moduli

   !> Displacement gradient at a particle by displacements of the corners, whose trace is the mean where it is shared [-].
   pure function strain_by(u, gradient, mean, shares) result(h)
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, corners)
      real(dp), intent(in) :: gradient(:, :), mean(:, :) !! [1/m], (corners, derivatives)
      logical, intent(in) :: shares
      real(dp) :: h(ndim, size(gradient, 2)), missing
      integer :: c
      h = 0
      missing = 0
      do c = 1, size(u, 2)
         h = h + spread(u(:, c), 2, size(gradient, 2))*spread(gradient(c, :), 1, ndim)
         missing = missing + dot_product(u(:, c), of_trace(mean(c, :) - gradient(c, :)))
      end do
      if (shares) h(:, :ndim) = h(:, :ndim) + missing/2*identity
   end function strain_by

   !> What the derivatives of a shape function give to the trace of H by a displacement in each direction [1/m].
   pure function of_trace(derivatives) result(part)
      real(dp), intent(in) :: derivatives(:)     !! [1/m]
      real(dp) :: part(ndim)
      part = derivatives(:ndim)
      part(1) = part(1) + sum(derivatives(ndim + 1:))
   end function of_trace

   !> Forces on the corners by the stress at a particle, per volume [N/m3]: the transpose of `strain_by`.
   pure function forces_by(stress, gradient, mean, shares) result(force)
      real(dp), intent(in) :: stress(:, :)       !! [Pa], (ndim, derivatives)
      real(dp), intent(in) :: gradient(:, :), mean(:, :) !! [1/m], (corners, derivatives)
      logical, intent(in) :: shares
      real(dp) :: force(ndim, size(gradient, 1))
      integer :: c
      do c = 1, size(gradient, 1)
         force(:, c) = matmul(stress, gradient(c, :))
         if (shares) force(:, c) = force(:, c) + trace(stress(:, :ndim))/2*of_trace(mean(c, :) - gradient(c, :))
      end do
   end function forces_by

   !> Add the products V N_a,k N_b,l of the gradients at a point.
   pure subroutine sum_products(volume, gradient, products)
      real(dp), intent(in) :: volume             !! [m3]
      real(dp), intent(in) :: gradient(:, :)     !! [1/m], (corners, derivatives)
      real(dp), intent(inout) :: products(:, :)  !! by corner, the derivatives of a corner one after the other [m]
      real(dp) :: by_corner(points_of_quadratic*(ndim + 1))
      integer :: k, n
      n = size(gradient, 2)
      do k = 1, size(gradient, 1)
         by_corner(n*(k - 1) + 1:n*k) = gradient(k, :)
      end do
      do k = 1, size(gradient)
         products(:, k) = products(:, k) + (volume*by_corner(k))*by_corner(:size(gradient))
      end do
   end subroutine sum_products

   !> Change of the stress, its components first, with those of the displacement gradient [Pa].
   pure function moduli_of(material, n, h, old_state, hoop) result(moduli)
      type(material_t), intent(in) :: material
      integer, intent(in) :: n                   !! derivatives of a shape function
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), contiguous, intent(in) :: old_state(:) !! what the particle remembers
      real(dp), intent(in) :: hoop               !! H_33 [-]
      real(dp) :: moduli(ndim, n, ndim, n)
      real(dp) :: unit(ndim, n)
      integer :: j, k
      do k = 1, n
         do j = 1, ndim
            unit = 0
            unit(j, k) = 1
            moduli(:, :, j, k) = change_of_stress(material, h, unit, old_state, hoop)
         end do
      end do
   end function moduli_of

   !> What a small change of H makes of the stress, both with a column of the hoop where material is axisymmetric, whose direction 2 has no part [Pa].
   pure function change_of_stress(material, h, dh, old_state, hoop) result(change)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: dh(:, :)           !! its change [-], (ndim, derivatives)
      real(dp), contiguous, intent(in) :: old_state(:) !! what the particle remembers
      real(dp), intent(in) :: hoop               !! H_33 [-]
      real(dp) :: change(ndim, size(dh, 2)), in_plane(ndim, ndim)
      in_plane = dh(:, :ndim)
      if (size(dh, 2) == ndim) then
         change = material%first_piola_change(h, in_plane, old_state)
      else
         change(:, :ndim) = material%first_piola_change(h, in_plane, old_state, hoop, dh(1, ndim + 1))
         change(:, ndim + 1) = 0
         change(1, ndim + 1) = material%hoop_change(h, in_plane, old_state, hoop, dh(1, ndim + 1))
      end if
   end function change_of_stress

   !> Add the stiffness of material of the same moduli: the force on corner a in direction i by a displacement of corner b in direction
   !> j is the sum over k and l of moduli_ikjl times that of V N_a,k N_b,l.
   pure subroutine add_products(moduli, products, matrix)
      real(dp), intent(in) :: moduli(:, :, :, :)
      real(dp), intent(in) :: products(:, :)     !! by corner, the derivatives of a corner one after the other [m]
      real(dp), intent(inout) :: matrix(:, :)
      integer :: i, j, k, l, n
      n = size(moduli, 2)
      do j = 1, ndim
         do l = 1, n
            do i = 1, ndim
               do k = 1, n
                  matrix(i::ndim, j::ndim) = matrix(i::ndim, j::ndim) + moduli(i, k, j, l)*products(k::n, l::n)
               end do
            end do
         end do
      end do
   end subroutine add_products

   !> Derivatives of the shape functions at the points by which a particle is stiff [1/m], (corners, derivatives, points): where it stands.
   !> One particle alone in its cell does not feel how that is bent; four points near it keep the stiffness from being singular.
   pure subroutine stiff_points(m, e, i, gradient)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e, i
      real(dp), allocatable, intent(out) :: gradient(:, :, :)
      real(dp), parameter :: near = 0.05_dp      ! in cells: a twenty-fifth of the stiffness of four particles in bending
      real(dp), parameter :: around(ndim, 4) = near*reshape([-1, -1, 1, -1, -1, 1, 1, 1], [ndim, 4])
      integer :: k
      allocate (gradient(m%grid%n_functions, n_derivatives(m), &
                         merge(4, 1, m%blocks%count_in(e) == 1 .and. .not. m%grid%is_quadratic())))
      gradient(:, :, 1) = derivatives_at(m, i)
      if (size(gradient, 3) == 1) return
      do k = 1, 4
         gradient(:, :ndim, k) = m%grid%gradients_in(e, inside_cell(local_of(m, i) + around(:, k)))
         gradient(:, ndim + 1:, k) = gradient(:, ndim + 1:, 1)
      end do
   end subroutine stiff_points

   !> Gradients of the shape functions at a particle [1/m].
   pure function gradient_at(m, i) result(gradient)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp) :: gradient(m%grid%n_functions, ndim)
      gradient = m%grid%gradients_in(m%particles%cell(i), local_of(m, i))
   end function gradient_at

   !> How many derivatives a shape function has: in axisymmetric material N/R is one.
   pure integer function n_derivatives(m)
      type(problem_t), intent(in) :: m
      n_derivatives = merge(ndim + 1, ndim, m%particles%thickness%is_ring)
   end function n_derivatives

   !> The derivatives of the shape functions at a particle [1/m], (corners, derivatives).
   pure function derivatives_at(m, i) result(derivatives)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp) :: derivatives(m%grid%n_functions, n_derivatives(m))
      derivatives(:, :ndim) = gradient_at(m, i)
      if (n_derivatives(m) > ndim) &
         derivatives(:, ndim + 1) = m%grid%functions_in(m%particles%cell(i), local_of(m, i))/m%particles%reference(i, 1)
   end function derivatives_at

   !> Place of a particle in its cell, 0 to 1.
   pure function local_of(m, i) result(xi)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp) :: xi(ndim)
      xi = inside_cell(m%grid%local_coordinate(m%particles%cell(i), m%particles%place_in_grid(i)))
   end function local_of

   !> The forces of all loads at their largest or, where there is no load, those that stop the bodies as they move at first, in a
   !> second [N], (ndim, n_points).
   subroutine full_loads(m, force)
      type(problem_t), intent(inout) :: m
      real(dp), allocatable, intent(out) :: force(:, :)
      integer :: k, i
      allocate (force(ndim, m%grid%n_points), source=0.0_dp)
      call place_loads(m%loads, m%grid, m%particles)
      do k = 1, size(m%loads)
         call add_load(m%loads(k), m%loads(k)%history%largest_factor(), force)
      end do
      if (size(m%loads) > 0) return
      associate (p => m%particles)
         do i = 1, p%n
            associate (at => m%grid%support_of(p%cell(i)))
               force(:, at) = force(:, at) - p%mass(i)*spread(p%velocity(i, :), 2, size(at)) &
                              *spread(m%grid%functions_in(p%cell(i), local_of(m, i)), 1, ndim)
            end associate
         end do
      end associate
   end subroutine full_loads

   !> Displacement of the points by forces on them; forces on hanging nodes go to their masters [m]. Fails where
   !> an iteration does not end.
   subroutine solve(self, m, force, u, failure)
      class(stiffness_t), intent(inout) :: self
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: force(:, :)        !! [N], (ndim, n_points)
      real(dp), allocatable, intent(out) :: u(:, :)  !! (ndim, n_points)
      type(failure_t), intent(inout), optional :: failure !! without it there is no iteration
      real(dp), allocatable :: condensed(:, :), x(:)
      integer :: k, d
      allocate (condensed, source=force)
      allocate (u(ndim, m%grid%n_points), source=0.0_dp)
      allocate (x(self%unknowns%n))
      associate (all => m%fields%mass_matrix%all, dof => self%unknowns%dof)
         call m%grid%dofs%condense(all, ndim, condensed)
         if (self%kind%solver == 'cg' .and. present(failure)) then
            call solve_by_cg(self%matrix, self%on_unknowns(condensed), x, failure)
         else if (self%unknowns%n > 0) then
            call self%factorised%solve(self%on_unknowns(condensed), x)
         end if
         do k = 1, size(self%nodes)
            do d = 1, ndim
               associate (node => self%nodes(k), unknown => dof(d, self%nodes(k)))
                  if (unknown > 0) u(d, node) = x(unknown)
               end associate
            end do
         end do
         call m%grid%dofs%distribute(all, ndim, u)
      end associate
   end subroutine solve

   !> What forces on the nodes, condensed, are on the unknowns.
   pure function on_unknowns(self, force) result(b)
      class(stiffness_t), intent(in) :: self
      real(dp), intent(in) :: force(:, :)        !! [N], (ndim, n_points)
      real(dp) :: b(self%unknowns%n)
      integer :: k, d
      b = 0
      do k = 1, size(self%nodes)
         do d = 1, ndim
            associate (node => self%nodes(k), unknown => self%unknowns%dof(d, self%nodes(k)))
               if (unknown > 0) b(unknown) = b(unknown) + force(d, node)
            end associate
         end do
      end do
   end function on_unknowns

   !> Whether an equilibrium with this stiffness is stable: it is positive definite. (An iteration fails where it is not.)
   pure logical function is_stable(self)
      class(stiffness_t), intent(in) :: self
      is_stable = self%unknowns%n == 0 .or. self%kind%solver == 'cg' .or. self%factorised%is_definite
   end function is_stable

   !> Forces by which the nodes resist a small displacement from the present state, K u, without interface points, condensed [N].
   subroutine forces_of(m, u, force)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: u(:, :)            !! of the points [m], (ndim, n_points)
      real(dp), allocatable, intent(out) :: force(:, :) !! (ndim, n_points)
      real(dp), dimension(m%grid%n_functions, n_derivatives(m)) :: gradient, mean
      integer :: k, i
      allocate (force(ndim, m%grid%n_points), source=0.0_dp)
      associate (p => m%particles, b => m%blocks)
         do k = 1, b%n_occupied
            associate (e => b%occupied(k), at => m%grid%support_of(b%occupied(k)))
               if (.not. any(abs(u(:, at)) > 0)) cycle
               mean = mean_gradient_in(m, e)
               do i = b%first_in(e), b%last_in(e), b%stride_in(e)
                  gradient = derivatives_at(m, i)
                  associate (material => m%materials(p%material(i)))
                     force(:, at) = force(:, at) + p%volume(i)*forces_by(change_of_stress(material, p%gradient_of(i), &
                                    strain_by(u(:, at), gradient, mean, material%mean_dilatation), p%history_of(i), &
                                    p%hoop_of(i)), gradient, mean, material%mean_dilatation)
                  end associate
               end do
            end associate
         end do
      end associate
      call m%grid%dofs%condense(m%fields%mass_matrix%all, ndim, force)
   end subroutine forces_of

   !> Give back the memory.
   subroutine release(self)
      class(stiffness_t), intent(inout) :: self
      call self%factorised%release()
      self%matrix = sparse_t()
   end subroutine release
end module hampm_stiffness
