!> Largest stable time step of a body in small motion, from the matrices of a sample (docs/explanation/time_step.md).
!>
!> A step changes the nodal momentum p = S^T m v and the sum u of the displacements that strain the particles by
!>
!>    p <- p - dt M A K u,    u <- u + dt w,    w = A p, before or after the change of p; usl: w = A p - dt A K u,
!>
!> S being the shape functions at the particles of mass m, M = S^T m S, K the stiffness, A the approximate inverse of M. Limit:
!>
!>    (4/dt^2) u = Q K u,    Q = A M A, and with usl Q = 2 A - A M A;    damping of a rate: (4 - 2 rate dt)/dt^2 for 4/dt^2.
!>
!> Modes at free edges and corners are faster than waves in an infinite body: the sample is the body or, if large, its corners.
module hampm_critical_step
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions, shape_gradients, quadratic_functions, quadratic_gradients, points_of_quadratic
   use hampm_forest, only: corner_offset
   use hampm_lapack, only: dpotrf, dpotri, dsyev
   use hampm_mass_choice, only: mass_choice_t
   use hampm_mass_matrix, only: prepare_cell, eigenvalue_floor, floor_of_domains, floor_of_quadratic
   use hampm_mass_solver, only: by_lumped, by_fmpm
   use hampm_material, only: material_t
   use hampm_quadratic_points, only: weights_along
   use hampm_tensors, only: voigt, n_voigt
   implicit none
   private
   public :: stable_time_step, largest_wave_speed, row_t, ring_t, row_of_points, row_of_cut_cells, shifted, &
             largest_courant, sample_cells

   integer, parameter :: sample_cells = merge(8, 5, ndim == 2) !! that a sample has at most in each direction

   !> Distance to the edge of a cell, at least [cells]: nodes of next to no mass keep their digits
   real(dp), parameter :: margin = 1e-6_dp

   !> The positions of the particles of a body in one direction.
   type :: row_t
      real(dp), allocatable :: x(:)              !! in cells, from a node on, ascending
      real(dp), allocatable :: length(:)         !! that each stands for [cells]
      real(dp) :: spacing = 0                    !! between them [cells]
   end type row_t

   !> Additional data of an axisymmetric sample.
   type :: ring_t
      real(dp) :: axis = 0                       !! where the axis is, from the node from which the first row is measured [cells]
      real(dp) :: moduli(n_voigt + 1) = 0        !! stress 11, 22, 12 and 33 by H_33, over rho c**2 of dilatational waves [-]
   end type ring_t

   !> The matrices of a sample, in cells of size 1, with density 1 and the dilatational wave speed 1.
   type :: sample_t
      integer :: cells(ndim) = 0
      real(dp), allocatable :: cell(:, :, :)     !! mass matrix of each cell, (nodes of a cell, nodes of a cell, cells)
      integer, allocatable :: nodes(:, :)        !! of each cell, (nodes of a cell, cells)
      real(dp), allocatable :: mass(:, :)        !! M, (nodes, nodes)
      real(dp), allocatable :: lumped(:)         !! its row sums, (nodes)
      real(dp), allocatable :: stiffness(:, :)   !! K, (ndim nodes, ndim nodes); first all x components
   end type sample_t

contains

   !> The time step (31): courant times the size of the smallest cell over the largest wave speed [s].
   pure real(dp) function stable_time_step(cell, materials, courant, wave_speed) result(dt)
      real(dp), intent(in) :: cell               !! size of the smallest cell with particles [m]
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: courant            !! [-]
      character(*), intent(in) :: wave_speed     !! 'shear', as in (32), or 'dilatational'
      dt = courant*cell/largest_wave_speed(materials, wave_speed)
   end function stable_time_step

   !> The largest wave speed of some materials [m/s].
   pure real(dp) function largest_wave_speed(materials, wave_speed) result(speed)
      type(material_t), intent(in) :: materials(:)
      character(*), intent(in) :: wave_speed     !! 'shear' or 'dilatational'
      integer :: k
      speed = 0
      do k = 1, size(materials)
         if (wave_speed == 'shear') then
            speed = max(speed, materials(k)%shear_wave_speed())
         else
            speed = max(speed, materials(k)%dilatational_wave_speed())
         end if
      end do
   end function largest_wave_speed

   !> The particles of a body along one direction: `n` of them, evenly, from `lower` to `upper`. Of more than `most` cells those in
   !> the middle are left out.
   pure type(row_t) function row_of_points(lower, upper, n, most) result(row)
      real(dp), intent(in) :: lower, upper       !! ends of the body, from a node on [cells]
      integer, intent(in) :: n, most
      real(dp) :: x, position
      integer :: first, surplus, gap, k
      row%spacing = (upper - lower)/n
      first = floor(lower + 0.5_dp*row%spacing)
      surplus = max(0, floor(upper - 0.5_dp*row%spacing) - first + 1 - most)
      gap = first + most/2                       ! the first cell that may be left out
      allocate (row%x(0))
      k = 0
      do while (k < n)
         position = lower + (k + 0.5_dp)*row%spacing
         if (surplus > 0 .and. position >= gap .and. position < gap + surplus) then
            k = max(k + 1, ceiling((gap + surplus - lower)/row%spacing - 0.5_dp))
            cycle
         end if
         x = position - first
         if (position >= gap + surplus) x = x - surplus
         row%x = [row%x, x]
         k = k + 1
      end do
      row%length = spread(row%spacing, 1, size(row%x))
   end function row_of_points

   !> The particles of a body of two cells and, on both sides, a part of a cell, on a lattice whose end particles may be cut.
   pure type(row_t) function row_of_cut_cells(fill, points_per_cell) result(row)
      real(dp), intent(in) :: fill               !! the part of the cells at the ends [cells]
      integer, intent(in) :: points_per_cell
      real(dp) :: from, to
      integer :: k
      row%spacing = 1/real(points_per_cell, dp)
      allocate (row%x(0), row%length(0))
      do k = 0, 4*points_per_cell - 1
         from = max(k*row%spacing, 1 - fill)
         to = min((k + 1)*row%spacing, 3 + fill)
         if (to - from <= margin) cycle
         row%x = [row%x, (from + to)/2]
         row%length = [row%length, to - from]
      end do
   end function row_of_cut_cells

   !> A row somewhere else in the cells.
   elemental type(row_t) function shifted(row, by)
      type(row_t), intent(in) :: row
      real(dp), intent(in) :: by                 !! [cells], not below 0
      shifted = row
      shifted%x = row%x + by
   end function shifted

   !> Largest stable time step, times the dilatational wave speed over the size of a cell [-]; huge where nothing has a stiffness.
   pure real(dp) function largest_courant(rows, moduli, mass, strains_last, damping, have_domains, are_quadratic, ring) &
      result(courant)
      type(row_t), intent(in) :: rows(ndim)      !! the particles in each direction
      real(dp), intent(in) :: moduli(n_voigt, n_voigt) !! stiffness of (11, 22, 12) over rho c**2 of dilatational waves [-]
      type(mass_choice_t), intent(in) :: mass    !! of a partial matrix the full part counts: it is the faster one
      logical, intent(in) :: strains_last        !! usl
      real(dp), intent(in) :: damping            !! rate times cell size over dilatational wave speed [-]
      logical, intent(in) :: have_domains        !! whether particles have domains
      logical, intent(in), optional :: are_quadratic !! whether cells are, whose particles are then weighted
      type(ring_t), intent(in), optional :: ring !! of axisymmetric material
      type(sample_t) :: sample
      real(dp), allocatable :: inverse(:, :), q(:, :), root(:)
      real(dp) :: square
      integer :: d, i, k, n
      logical :: quadratic
      quadratic = .false.
      if (present(are_quadratic)) quadratic = are_quadratic
      if (have_domains) then
         call build_sample_of_domains(rows, moduli, sample)
         call build_inverse(sample, mass, floor_of_domains, inverse)
      else
         call build_sample(rows, moduli, quadratic, sample, ring)
         call build_inverse(sample, mass, merge(floor_of_quadratic, eigenvalue_floor, quadratic), inverse)
      end if
      q = matmul(inverse, matmul(sample%mass, inverse))
      if (strains_last) q = 2*inverse - q
      allocate (root, source=sqrt(where_mass(sample%lumped)))    ! with D of 1, nodes of little mass keep their digits
      n = size(root)
      do i = 1, n
         q(:, i) = root*q(:, i)*root(i)
         do d = 0, ndim - 1
            sample%stiffness(:, d*n + i) = sample%stiffness(:, d*n + i)/[(root, k=1, ndim)]/root(i)
         end do
      end do
      square = largest_eigenvalue(q, sample%stiffness)
      courant = huge(courant)
      if (square > 0) courant = 4/(damping + sqrt(damping**2 + 4*square))
   end function largest_courant

   !> Sum the particles into the matrices: of bilinear cells or, with weights, of quadratic ones.
   pure subroutine build_sample(rows, moduli, quadratic, s, ring)
      type(row_t), intent(in) :: rows(ndim)
      real(dp), intent(in) :: moduli(n_voigt, n_voigt)
      logical, intent(in) :: quadratic
      type(sample_t), intent(out) :: s
      type(ring_t), intent(in), optional :: ring
      real(dp) :: xi(ndim), weight, n(merge(points_of_quadratic, corners, quadratic)), gradient(size(n), ndim)
      integer :: nodes(size(n)), k, d, at(ndim), i(ndim), n_points(ndim)
      call make_room([(floor(maxval(rows(d)%x)) + 1, d=1, ndim)], merge(2, 1, quadratic), s)
      n_points = [(size(rows(d)%x), d=1, ndim)]
      do k = 1, product(n_points)
         i = place_in(n_points, k)
         call locate([(rows(d)%x(i(d)), d=1, ndim)], at, xi)
         if (quadratic) then
            weight = product([(weight_at(rows(d)%spacing, xi(d)), d=1, ndim)])
            n = quadratic_functions(xi)
            gradient = quadratic_gradients(xi, 1.0_dp)
         else
            weight = product([(rows(d)%length(i(d)), d=1, ndim)])
            n = shape_functions(xi)
            gradient = shape_gradients(xi, 1.0_dp)
         end if
         if (present(ring)) weight = weight*(rows(1)%x(i(1)) - ring%axis)
         nodes = s%nodes(:, number_of(at, s))
         call add_mass(weight, n, number_of(at, s), s)
         call add_stiffness(weight*moduli, gradient, nodes, size(s%lumped), s%stiffness)
         if (present(ring)) call add_hoops(weight*ring%moduli, n/(rows(1)%x(i(1)) - ring%axis), gradient, nodes, s)
      end do
      if (present(ring)) call hold_axis(ring, s)
      call sum_cells(s)
   end subroutine build_sample

   !> The k-th place of a lattice, from 1 on in each direction, those along x one after the other.
   pure function place_in(n, k) result(place)
      integer, intent(in) :: n(ndim), k
      integer :: place(ndim)
      integer :: d
      place = [(mod((k - 1)/product(n(:d - 1)), n(d)) + 1, d=1, ndim)]
   end function place_in

   !> Weight of a particle in one direction, by the distance between particles and the place in its cell.
   pure real(dp) function weight_at(spacing, xi) result(weight)
      real(dp), intent(in) :: spacing, xi        !! [cells]
      real(dp) :: w(nint(1/spacing))
      w = weights_along(size(w))
      weight = w(min(int(xi*size(w)) + 1, size(w)))
   end function weight_at

   !> The same for particles with domains, which act on the nodes by their corners.
   pure subroutine build_sample_of_domains(rows, moduli, s)
      type(row_t), intent(in) :: rows(ndim)
      real(dp), intent(in) :: moduli(n_voigt, n_voigt)
      type(sample_t), intent(out) :: s
      real(dp) :: xi(ndim), length(ndim), toward(ndim), shape(corners), weight
      real(dp), allocatable :: gradient(:, :)    ! of the function of a particle [1/cells], (nodes, ndim)
      integer, allocatable :: nodes(:)
      integer :: i(ndim), n_points(ndim), c, d, j, k, at(ndim), first(ndim)
      first = [(floor(minval(rows(d)%x - rows(d)%length/2) + margin), d=1, ndim)] ! domains reach beyond the cells of the particles
      call make_room([(floor(maxval(rows(d)%x + rows(d)%length/2) - margin) + 1, d=1, ndim)] - first, 1, s)
      allocate (gradient(size(s%lumped), ndim))
      n_points = [(size(rows(d)%x), d=1, ndim)]
      do j = 1, product(n_points)
         i = place_in(n_points, j)
         length = [(rows(d)%length(i(d)), d=1, ndim)]
         weight = product(length)
         gradient = 0
         do c = 1, corners
            toward = corner_offset(c) - 0.5_dp
            call locate([(rows(d)%x(i(d)), d=1, ndim)] - first + (1 - margin)*toward*length, at, xi)
            shape = shape_functions(xi)
            k = number_of(at, s)
            call add_mass(weight/corners, shape, k, s)
            do d = 1, ndim
               gradient(s%nodes(:, k), d) = gradient(s%nodes(:, k), d) + shape*toward(d)/length(d)
            end do
         end do
         nodes = pack([(k, k=1, size(s%lumped))], sum(abs(gradient), dim=2) > 0)
         call add_stiffness(weight*moduli, gradient(nodes, :), nodes, size(s%lumped), s%stiffness)
      end do
      call sum_cells(s)
   end subroutine build_sample_of_domains

   !> An empty sample.
   pure subroutine make_room(cells, order, s)
      integer, intent(in) :: cells(ndim)
      integer, intent(in) :: order               !! of the cells: 1 bilinear, 2 quadratic
      type(sample_t), intent(inout) :: s
      integer :: k, a
      s%cells = cells
      associate (n => product(order*cells + 1), m => product(cells), f => (order + 1)**ndim)
         allocate (s%cell(f, f, m), s%mass(n, n), s%lumped(n), s%stiffness(ndim*n, ndim*n), source=0.0_dp)
         allocate (s%nodes(f, m))
      end associate
      do k = 1, product(cells)
         associate (n => order*cells + 1, first => order*(place_in(cells, k) - 1))
            s%nodes(:, k) = [(node_number(n, first + place_in(spread(order + 1, 1, ndim), a)), a=1, size(s%nodes, 1))]
         end associate
      end do
   contains
      !> Number of the node at a place, from 1 on in each direction.
      pure integer function node_number(n, place)
         integer, intent(in) :: n(:), place(:)
         integer :: d
         node_number = 1 + sum([((place(d) - 1)*product(n(:d - 1)), d=1, ndim)])
      end function node_number
   end subroutine make_room

   !> Number of the cell at a place.
   pure integer function number_of(at, s)
      integer, intent(in) :: at(ndim)            !! from 0 on
      type(sample_t), intent(in) :: s
      integer :: d
      number_of = 1 + sum([(at(d)*product(s%cells(:d - 1)), d=1, ndim)])
   end function number_of

   !> The cell of a place, and where in it that is.
   pure subroutine locate(x, at, xi)
      real(dp), intent(in) :: x(ndim)            !! [cells]
      integer, intent(out) :: at(ndim)
      real(dp), intent(out) :: xi(ndim)
      at = floor(x)
      xi = min(max(x - at, margin), 1 - margin)
   end subroutine locate

   !> Add a mass to the matrix of its cell.
   pure subroutine add_mass(mass, shape, cell, s)
      real(dp), intent(in) :: mass
      real(dp), intent(in) :: shape(:)           !! functions of the nodes of the cell there
      integer, intent(in) :: cell
      type(sample_t), intent(inout) :: s
      integer :: c
      do c = 1, size(shape)
         s%cell(:, c, cell) = s%cell(:, c, cell) + mass*shape(c)*shape
      end do
   end subroutine add_mass

   !> Sum the mass matrices of the cells.
   pure subroutine sum_cells(s)
      type(sample_t), intent(inout) :: s
      integer :: k
      do k = 1, size(s%cell, 3)
         associate (nodes => s%nodes(:, k))
            s%mass(nodes, nodes) = s%mass(nodes, nodes) + s%cell(:, :, k)
         end associate
      end do
      s%lumped = sum(s%mass, dim=1)
   end subroutine sum_cells

   !> Add the contribution of a particle to the stiffness: B^T C B.
   pure subroutine add_stiffness(moduli, gradient, nodes, n, stiffness)
      real(dp), intent(in) :: moduli(n_voigt, n_voigt), gradient(:, :)  !! (nodes, ndim)
      integer, intent(in) :: nodes(:), n
      real(dp), intent(inout) :: stiffness(:, :)
      real(dp) :: stress(ndim)                   ! on planes of either direction, of a unit displacement in direction k
      integer :: a, c, d, k
      do c = 1, size(nodes)
         do k = 1, ndim
            do d = 1, ndim
               stress = matmul(moduli(voigt(:, d), voigt(:, k)), gradient(c, :))
               associate (column => stiffness((d - 1)*n + 1:d*n, nodes(c) + (k - 1)*n))
                  do a = 1, size(nodes)
                     column(nodes(a)) = column(nodes(a)) + dot_product(gradient(a, :), stress)
                  end do
               end associate
            end do
         end do
      end do
   end subroutine add_stiffness

   !> Add the contribution of the hoop of a particle to the stiffness, and of the stress in the plane by it.
   pure subroutine add_hoops(moduli, stretch, gradient, nodes, s)
      real(dp), intent(in) :: moduli(n_voigt + 1)
      real(dp), intent(in) :: stretch(:), gradient(:, :) !! N/R and grad N [1/cells], (nodes) and (nodes, ndim)
      integer, intent(in) :: nodes(:)
      type(sample_t), intent(inout) :: s
      real(dp) :: by_hoop(size(nodes), ndim)     ! forces of a unit H_33, by the stress in the plane
      integer :: c, d
      do d = 1, ndim
         by_hoop(:, d) = matmul(gradient, moduli(voigt(:, d)))
      end do
      associate (n => size(s%lumped), k => s%stiffness)
         do c = 1, size(nodes)
            do d = 1, ndim
               k(nodes + (d - 1)*n, nodes(c)) = k(nodes + (d - 1)*n, nodes(c)) + by_hoop(:, d)*stretch(c)
               k(nodes, nodes(c) + (d - 1)*n) = k(nodes, nodes(c) + (d - 1)*n) + stretch*by_hoop(c, d)
            end do
            k(nodes, nodes(c)) = k(nodes, nodes(c)) + moduli(n_voigt + 1)*stretch*stretch(c)
         end do
      end associate
   end subroutine add_hoops

   !> Hold the nodes of the axis in the direction of the radius: nothing resists there.
   pure subroutine hold_axis(ring, s)
      type(ring_t), intent(in) :: ring
      type(sample_t), intent(inout) :: s
      integer :: e, c, held, per_side
      per_side = nint(sqrt(real(size(s%nodes, 1), dp)))
      do e = 1, size(s%nodes, 2)
         if (abs(mod(e - 1, s%cells(1)) - ring%axis) > margin) cycle
         do c = 1, size(s%nodes, 1), per_side
            held = s%nodes(c, e)
            s%stiffness(held, :) = 0
            s%stiffness(:, held) = 0
         end do
      end do
   end subroutine hold_axis

   !> Inverse of M as the run approximates it, by the rule of `hampm_mass_matrix`.
   pure subroutine build_inverse(s, mass, least, inverse)
      type(sample_t), intent(in) :: s
      type(mass_choice_t), intent(in) :: mass
      real(dp), intent(in) :: least              !! eigenvalue of the matrices of cells
      real(dp), allocatable, intent(out) :: inverse(:, :)
      real(dp) :: cell(size(s%cell, 1), size(s%cell, 1))
      integer :: n, i, k, info
      n = size(s%lumped)
      allocate (inverse(n, n), source=0.0_dp)
      if (mass%by == by_lumped) then
         call add_diagonal(1/where_mass(s%lumped), inverse)
      else if (mass%by == by_fmpm) then
         call sum_series(s, mass%order, inverse)
      else
         do k = 1, size(s%cell, 3)
            cell = s%cell(:, :, k)
            call prepare_cell(size(cell, 1), mass%lumped_inside, .true., .false., cell, least)
            associate (nodes => s%nodes(:, k))
               inverse(nodes, nodes) = inverse(nodes, nodes) + cell
            end associate
         end do
         call add_diagonal([(merge(0.0_dp, 1.0_dp, s%mass(i, i) > 0), i=1, n)], inverse) ! nodes on an axis have no row sums
         call dpotrf('U', n, inverse, n, info)
         call dpotri('U', n, inverse, n, info)
         do i = 1, n
            inverse(i + 1:, i) = inverse(i, i + 1:)
         end do
      end if
   end subroutine build_inverse

   !> The series of `mass = 'fmpm'` for the inverse.
   pure subroutine sum_series(s, order, inverse)
      type(sample_t), intent(in) :: s
      integer, intent(in) :: order
      real(dp), intent(inout) :: inverse(:, :)
      real(dp) :: rest(size(inverse, 1), size(inverse, 1)), term(size(inverse, 1), size(inverse, 1))
      real(dp) :: divisor(size(inverse, 1))
      integer :: k
      divisor = where_mass(s%lumped)
      rest = -s%mass/spread(divisor, 2, size(divisor))
      call add_diagonal(spread(1.0_dp, 1, size(divisor)), rest)
      term = 0
      call add_diagonal(1/divisor, term)
      inverse = term
      do k = 2, order
         term = matmul(rest, term)
         inverse = inverse + term
      end do
   end subroutine sum_series

   !> Masses, 1 where 0.
   elemental real(dp) function where_mass(lumped)
      real(dp), intent(in) :: lumped
      where_mass = merge(lumped, 1.0_dp, lumped > 0)
   end function where_mass

   !> Add to the diagonal of a matrix.
   pure subroutine add_diagonal(diagonal, matrix)
      real(dp), intent(in) :: diagonal(:)
      real(dp), intent(inout) :: matrix(:, :)
      integer :: i
      do i = 1, size(diagonal)
         matrix(i, i) = matrix(i, i) + diagonal(i)
      end do
   end subroutine add_diagonal

   !> Largest eigenvalue of Q K, Q acting on each component by itself: with Q = U^T U it is the one of U K U^T.
   pure real(dp) function largest_eigenvalue(q, k) result(largest)
      real(dp), intent(in) :: q(:, :), k(:, :)   !! symmetric, none below zero
      real(dp) :: u(size(q, 1), size(q, 1)), both(size(k, 1), size(k, 1)), value(size(k, 1)), work(4*size(k, 1))
      real(dp), parameter :: little = 1e-12_dp   ! part of the diagonal that makes Q positive definite where M is singular
      logical :: is_diagonal
      integer :: n, i, j, info
      n = size(q, 1)
      is_diagonal = .true.
      do i = 2, n
         is_diagonal = is_diagonal .and. .not. any(abs(q(:i - 1, i)) > 0)
      end do
      u = q
      call add_diagonal(little*[(q(i, i), i=1, n)], u)
      call dpotrf('U', n, u, n, info)
      do i = 1, n - 1
         u(i + 1:, i) = 0
      end do
      if (is_diagonal) then                      ! of lumped masses
         do j = 0, (ndim - 1)*n, n
            do i = 1, n
               both(:, i + j) = k(:, i + j)*u(i, i)
            end do
         end do
         do j = 0, (ndim - 1)*n, n
            do i = 1, n
               both(i + j, :) = u(i, i)*both(i + j, :)
            end do
         end do
      else
         do i = 0, (ndim - 1)*n, n               ! the upper triangle is read
            do j = i, (ndim - 1)*n, n
               both(i + 1:i + n, j + 1:j + n) = matmul(u, matmul(k(i + 1:i + n, j + 1:j + n), transpose(u)))
            end do
         end do
      end if
      call dsyev('N', 'U', ndim*n, both, ndim*n, value, work, size(work), info)
      largest = value(ndim*n)
   end function largest_eigenvalue
end module hampm_critical_step
