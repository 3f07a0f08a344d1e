!> Energy release rate by material forces: minus the sum of the forces on the nodes around the tip, along the crack, of node a
!>
!>    g_a = sum_p V { (W I - H^T P)_1J N_a,J + W,1 N_a } + h_a . f_a, f_a = sum_p V P_iJ N_a,J, h_a = sum_p V N_a u,1/sum_p V N_a,
!>
!> in the reference configuration, with W,1 by the explicit dependence of the moduli on the place. The nodal stress force f_a, less
!> the ties of cut cells, balances inertia, damping and body loads, without an acceleration; in equilibrium it is 0. A constant
!> slope in u,1, as of a rotation, cancels in each g_a. All g_a of a disc count equally: no weight falls with the radius. Rings add
!> terms in 1/R.
!>
!> W has the dissipated work D: by parts the dissipative material force of D,1. The rest, P:H,1 - W,1, of material that unloads or
!> whose stress turns, is left out. The modes share the force by the separation of the faces behind the tip. Source: Eshelby (1951);
!> Steinmann (2000); Mueller & Maugin (2002).
module hampm_material_force
   use hampm_kinds, only: dp, ndim
   use hampm_basis, only: points_of_quadratic, inside_cell
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_tip_field, only: modes, tip_field_t
   use hampm_energy_momentum, only: ways, frame_t, sample_t, take_sample, energy_momentum
   use hampm_failure, only: failure_t
   use hampm_interface_points, only: add_interface_forces
   use hampm_mass_solver, only: mass_solver_t
   use hampm_material, only: material_t
   use hampm_openings, only: opening_at
   use hampm_particles, only: particles_t
   use hampm_problem, only: problem_t
   use hampm_tensors, only: norm, identity, in_plane, quarter_turn
   use hampm_tip_domain, only: fields_at, nodes_at_others
   implicit none
   private
   public :: material_force

   integer, parameter :: at_volume = ndim + 2, sums = 2*ndim + 2 !! of a node: g, f, V and V u,1
   real(dp), parameter :: cells_beyond = 4       !! cells beyond the disc whose particles act on its nodes, hanging ones included
   real(dp), parameter :: even = 1.0e-6_dp       !! part of a length within which lengths count as the same

contains

   !> G of each mode, the mean over the discs, with their range as uncertainty.
   subroutine material_force(problem, factors, tip, p, extrapolation, rate, uncertainty, failure)
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: factors(:)
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(mass_solver_t), intent(inout) :: extrapolation
      real(dp), intent(inout) :: rate(modes), uncertainty(modes)
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: of_node(:, :)     ! (sums, n_points)
      real(dp), allocatable :: held(:, :)        ! ties of nodes of cut cells [N], (ndim, n_points)
      real(dp) :: g(size(tip%radii)), rates(modes, size(tip%radii)), x(ndim), distance, force(ndim)
      logical, allocatable :: is_at_other(:)     ! nodes on which the change of material acts, too
      integer :: i
      allocate (of_node(sums, problem%grid%n_points), held(ndim, problem%grid%n_points), source=0.0_dp)
      do i = 1, p%n
         associate (e => p%cell(i))
            if (.not. problem%grid%is_in_first_field(e)) cycle ! bodies that meet the cracked one are not part of it
            if (maxval(abs(p%place_in_grid(i) - tip%now)) > maxval(tip%radii) + cells_beyond*problem%grid%element_size(e)) cycle
         end associate
         call add_particle(problem, tip, p, i, of_node)
      end do
      call add_interface_forces(problem%interfaces, 1, held)
      of_node(2:ndim + 1, :) = of_node(2:ndim + 1, :) - matmul(transpose(tip%axis), held)
      call problem%grid%dofs%condense(problem%grid%dofs%every_node(), sums, of_node)
      allocate (is_at_other(problem%grid%n_points), source=.false.)
      if (allocated(tip%ends_at)) is_at_other = nodes_at_others(tip%now, tip%nodes%spacing, tip%ends_at, problem%grid, p)
      g = 0
      do i = 1, problem%grid%n_nodes
         if (.not. of_node(at_volume, i) > 0 .or. is_at_other(i)) cycle
         x = matmul(problem%grid%node_position(:, i) - tip%now, tip%axis)
         distance = (1 + even)*norm(x)
         if (distance >= maxval(tip%radii)) cycle
         force = of_node(2:ndim + 1, i)
         if (tip%is_half() .and. minval([x(1), -abs(x(2))]) >= -even*tip%nodes%spacing) &
            force(2) = 0                         ! the plane holds it
         where (distance < tip%radii) g = g + of_node(1, i) - dot_product(force, of_node(at_volume + 1:, i))/of_node(at_volume, i)
      end do
      g = merge(2, 1, tip%is_half())/p%thickness%at(tip%now)*g
      do i = 1, size(g)
         rates(:, i) = abs(g(i))*parts_of_modes(problem, tip, tip%radii(i), p)
      end do
      rate = sum(rates, dim=2)/size(g)
      uncertainty = maxval(rates, dim=2) - minval(rates, dim=2)
   end subroutine material_force

   !> Add a particle's contribution to the nodes.
   pure subroutine add_particle(problem, tip, p, i, of_node)
      type(problem_t), intent(in) :: problem
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp), intent(inout) :: of_node(:, :)   !! (sums, n_points)
      real(dp) :: shape(points_of_quadratic), gradient(problem%grid%n_functions, ndim), to_reference(ndim, ndim), xi(ndim)
      real(dp) :: flux(ways, ndim), source(ways), force(ndim)
      type(sample_t) :: s
      integer :: point(points_of_quadratic), k
      associate (grid => problem%grid, e => p%cell(i), v => p%volume(i))
         to_reference = tip%axis
         if (.not. p%total_frame) to_reference = matmul(identity + p%gradient_of(i), tip%axis)
         xi = inside_cell(grid%local_coordinate(e, p%place_in_grid(i)))
         call grid%shape_functions_in(e, xi, point, shape)
         gradient = matmul(grid%gradients_in(e, xi), to_reference)
         call take_sample(frame_t(axes=tip%axis), problem%materials(p%material(i)), p, i, 0*xi, s) ! inertia is in the force
         call energy_momentum(s, flux, source)
         force = 0
         if (s%is_ring) force = s%hoop_stress/s%radius*s%outward
         do k = 1, grid%n_functions
            associate (at => of_node(:, point(k)))
               at(1) = at(1) + v*(dot_product(flux(1, :), gradient(k, :)) + source(1)*shape(k))
               at(2:ndim + 1) = at(2:ndim + 1) + v*(matmul(s%stress, gradient(k, :)) + force*shape(k))
               at(at_volume) = at(at_volume) + v*shape(k)
               at(at_volume + 1:) = at(at_volume + 1:) + v*shape(k)*s%slope(:, 1)
            end associate
         end do
      end associate
   end subroutine add_particle

   !> Share of each mode in G, signed as the separation of the faces: of K whose field has their mean opening and sliding in the
   !> cells up to a distance behind the tip. For laws of finite rotation the frame turns with the mean of F there.
   pure function parts_of_modes(problem, tip, reach, p) result(part)
      type(problem_t), intent(in) :: problem
      type(crack_tip_t), intent(in) :: tip
      real(dp), intent(in) :: reach              !! [m]
      type(particles_t), intent(in) :: p
      real(dp) :: part(modes), axes(ndim, ndim), opening(modes), k(modes)
      type(tip_field_t) :: field(2)
      integer :: n
      part = [1, 0]
      axes = tip%axis
      if (.not. tip%is_half()) axes = matmul(rotation_around(tip, p, problem%materials, (1 + even)*reach), axes)
      opening = 0
      do n = 1, nint(reach/tip%nodes%spacing)
         associate (behind => (n - 0.5_dp)*tip%nodes%spacing)
            opening = opening + opening_at(tip, tip%now - behind*tip%direction, -tip%direction, problem, p, axes)
         end associate
      end do
      field = fields_at(problem%materials, tip)
      k = field(1)%intensities_of(opening, 1.0_dp)
      if (field(1)%rate_of(k) > 0) part = field(1)%shares(k)*sign(1.0_dp, k)
   end function parts_of_modes

   !> Rotation in the mean of F around a tip; none where all laws there are for small ones.
   pure function rotation_around(tip, p, materials, reach) result(turn)
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: reach              !! [m]
      real(dp) :: turn(ndim, ndim)
      real(dp) :: mean(ndim, ndim), c, s
      logical :: turns
      integer :: i
      turn = identity
      mean = 0
      turns = .false.
      do i = 1, p%n
         if (norm(p%reference(i, :) - tip%place) > reach) cycle
         mean = mean + p%volume(i)*(identity + p%gradient_of(i))
         turns = turns .or. materials(p%material(i))%is_finite
      end do
      if (.not. turns) return
      c = mean(1, 1) + mean(2, 2)
      s = mean(2, 1) - mean(1, 2)
      turn(:, 1) = in_plane(c, s)/max(hypot(c, s), tiny(c))
      turn(:, 2) = quarter_turn(turn(:, 1))
   end function rotation_around
end module hampm_material_force
