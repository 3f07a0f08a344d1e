!> Energy release rate by crack closure: the force transmitted at the tip times the separation of the faces behind it.
!> Mode 1 opens the faces, mode 2 slides them. On a symmetry plane there is no mode 2.
module hampm_crack_closure
   use hampm_kinds, only: dp, ndim
   use hampm_crack_tip, only: crack_tip_t, upper, lower
   use hampm_crack_tip_field, only: modes
   use hampm_extrapolation, only: extrapolate
   use hampm_failure, only: failure_t
   use hampm_loads, only: force_at_node
   use hampm_mass_solver, only: mass_solver_t, by_lumped
   use hampm_material, only: material_t
   use hampm_openings, only: in_modes, opening_at
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t
   use hampm_patch, only: patch_t, patch_around, internal_force, patch_mass
   implicit none
   private
   public :: stress_closure, virtual_crack_closure

   ! Integrals over a side of products of its shape functions, for ends and middle: of the node behind and half a cell behind, which
   ! close on the tip, with those at the tip, half a cell ahead and ahead
   real(dp), parameter :: of_quadratic(2, 3) = reshape([4, 2, 2, 16, -1, 2], [2, 3])/30.0_dp

contains

   !> G by stress closure, (12)-(14), of each mode: displacements of nodes (1) and (1') and stresses at nodes (2) and (3), each
   !> extrapolated with the mass matrix of the run [J/m2]. It tends to a constant times G as cells become small: the constant is
   !> about 0.33 with the lumped and 0.52 with the full matrix, because the near-tip fields are alike at every cell size.
   !> `virtual_crack_closure` tends to G. Signed like the opening and the sliding. Fails where the equations cannot be solved.
   !>
   !> It is the work over a cell of tractions ahead of the tip on the separation as far behind it, over twice its length. On
   !> quadratic cells both are quadratic functions of three nodes of a side; the faces are together at the tip.
   subroutine stress_closure(problem, factors, tip, p, extrapolation, rate, uncertainty, failure)
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: factors(:)
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(mass_solver_t), intent(inout) :: extrapolation
      real(dp), intent(inout) :: rate(modes), uncertainty(modes)
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: displacement(:, :), traction(:, :), of_particles(:, :)
      logical :: counts(problem%grid%n_elements)
      real(dp) :: opening(modes, 2), closing(modes, 3) ! node behind and half a cell behind; tip, half a cell ahead and ahead
      integer :: i
      associate (grid => problem%grid, matrix => problem%fields%mass_matrix)
         counts = .true.
         if (extrapolation%by == by_lumped .and. .not. allocated(p%corner_velocity)) &
            counts = elements_around([tip%nodes%behind, tip%nodes%half_behind, tip%nodes%tip, tip%nodes%half_ahead, &
                                      tip%nodes%ahead], problem)
         allocate (displacement(ndim, grid%n_points), traction(ndim, grid%n_points), of_particles(ndim, p%n))
         do i = 1, p%n
            if (counts(p%cell(i))) of_particles(:, i) = p%displacement(i, :)
         end do
         call extrapolate(grid, p, matrix, extrapolation, of_particles, displacement, failure, counts)
         do i = 1, p%n
            if (counts(p%cell(i))) of_particles(:, i) = traction_of(problem%materials(p%material(i)), p, i, tip%axis(:, 2))
         end do
         call extrapolate(grid, p, matrix, extrapolation, of_particles, traction, failure, counts)
      end associate
      opening(:, 1) = parted_at(tip%nodes%behind)
      closing(:, 1) = closing_at(tip%nodes%tip)
      closing(:, 3) = closing_at(tip%nodes%ahead)
      if (tip%nodes%half_ahead > 0) then
         opening(:, 2) = parted_at(tip%nodes%half_behind)
         closing(:, 2) = closing_at(tip%nodes%half_ahead)
         rate = [(sign(dot_product(opening(i, :), matmul(of_quadratic, closing(i, :)))/2, opening(i, 1)), i=1, modes)]
      else
         rate = [(opening(i, 1)/12*abs(2*closing(i, 1) + closing(i, 3)), i=1, modes)]
      end if

   contains

      !> Opening and sliding at nodes of the faces [m].
      pure function parted_at(face) result(opening)
         integer, intent(in) :: face(2)
         real(dp) :: opening(modes), apart(ndim)
         apart = 0
         if (face(upper) > 0) apart = displacement(:, face(upper))
         if (face(lower) > 0) apart = apart - displacement(:, face(lower))
         opening = in_modes(apart, tip%axis, tip%is_half())
      end function parted_at

      !> Traction at a node, across the crack and along it [Pa].
      pure function closing_at(node) result(closing)
         integer, intent(in) :: node
         real(dp) :: closing(modes)
         closing = matmul(traction(:, node), tip%axis(:, [2, 1]))
      end function closing_at
   end subroutine stress_closure

   !> The elements whose particles have a part in the values of some nodes by lumped masses: those around them, and around points
   !> that hang on them or are their masters.
   pure function elements_around(nodes, problem) result(are)
      integer, intent(in) :: nodes(:)            !! 0: none
      type(problem_t), intent(in) :: problem
      logical :: are(problem%grid%n_elements)
      logical :: counts(problem%grid%n_points)
      integer :: k
      counts = .false.
      counts(pack(nodes, nodes > 0)) = .true.
      call problem%grid%dofs%mark_masters(counts)
      call problem%grid%dofs%mark_hanging(counts)
      are = .false.
      do k = 1, problem%blocks%n_occupied
         associate (e => problem%blocks%occupied(k))
            are(e) = any(counts(problem%grid%support_of(e)))
         end associate
      end do
   end function elements_around

   !> Traction of a particle on planes with a normal [Pa].
   pure function traction_of(material, p, i, normal) result(traction)
      type(material_t), intent(in) :: material
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp), intent(in) :: normal(ndim)
      real(dp) :: traction(ndim), stress(ndim, ndim)
      stress = material%kirchhoff_stress(p%gradient_of(i), p%history_of(i), p%hoop_of(i))
      traction = matmul(stress, normal)
   end function traction_of

   !> G by nodal force closure (Rybicki & Kanninen 1977) of each mode: the force that the tip node transmits from face to face
   !> times the separation of the faces one cell behind it, over twice the area of that cell's face [J/m2]. Signed like opening and
   !> sliding; between two materials, where each force also works on the other opening, they are the works, with the sum G.
   !>
   !> Quadratic cells have a further node in the middle of the side ahead of the tip, whose force closes the opening of the node in
   !> the middle of the side behind it (Raju 1987).
   !>
   !> Tractions on the faces are taken as uniform over the cell behind the tip: the face of the cell ahead, once open, adds as much
   !> to the tip node, and to the node half a cell ahead, as that behind. By superposition G is then that of the same crack without
   !> tractions on its faces under a uniform stress.
   subroutine virtual_crack_closure(problem, factors, tip, p, extrapolation, rate, uncertainty, failure)
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: factors(:)
      type(crack_tip_t), intent(in) :: tip
      type(particles_t), intent(in) :: p
      type(mass_solver_t), intent(inout) :: extrapolation
      real(dp), intent(inout) :: rate(modes), uncertainty(modes)
      type(failure_t), intent(inout) :: failure
      real(dp) :: work(modes)
      work = force_at(tip%nodes%tip, 2*tractions_at([tip%nodes%tip, tip%nodes%tip]))*parted_at(tip%nodes%behind)
      if (tip%nodes%half_ahead > 0) &
         work = work + force_at(tip%nodes%half_ahead, tractions_at(tip%nodes%half_behind))*parted_at(tip%nodes%half_behind)
      rate = work/(2*tip%nodes%spacing*p%thickness%at(tip%now))

   contains

      !> Opening and sliding at nodes of the faces; the overlap of pressed faces is the compliance of their layer [m].
      pure function parted_at(face) result(opening)
         integer, intent(in) :: face(2)
         real(dp) :: opening(modes)
         opening = opening_at(tip, face, problem, p)
         if (tip%may_close) opening(1) = max(opening(1), 0.0_dp)
      end function parted_at

      !> Force through a node across the crack and along it [N], between two materials with its sign, else its size.
      pure function force_at(node, applied) result(force)
         integer, intent(in) :: node
         real(dp), intent(in) :: applied(ndim, 2) !! force from outside on the part of each face [N]
         real(dp) :: force(modes), total(ndim)
         total = transmitted_force(tip, node, problem, p, applied)
         force = [dot_product(total, tip%axis(:, 2)), dot_product(total, tip%axis(:, 1))]
         if (.not. tip%has_layers) force = abs(force)
      end function force_at

      !> Force on nodes of the upper and the lower face from the tractions on it [N].
      pure function tractions_at(nodes) result(force)
         integer, intent(in) :: nodes(2)         !! 0: none
         real(dp) :: force(ndim, 2)
         integer :: k
         force = 0
         do k = 1, 2
            if (nodes(k) > 0) force(:, k) = force_at_node(problem%loads, factors, problem%grid, p, nodes(k), &
                                                          (3 - 2*k)*tip%axis(:, 2))
         end do
      end function tractions_at
   end subroutine virtual_crack_closure

   !> Force of the material above the crack's line on that below it through a node at the tip [N]: its action on the node beyond the
   !> inertia of its own part of the mass there,
   !>    m+ a = f+ - F,  m- a = f- + F   so   F = (m- f+ - m+ f-)/(m+ + m-),
   !> for any mass-proportional damping. On a symmetry plane, where a = 0 in the normal direction, it is the internal force
   !> of the half that is modelled, which the constraint answers. External forces on the node count with the internal force of its
   !> side.
   pure function transmitted_force(tip, node, problem, p, applied) result(force)
      type(crack_tip_t), intent(in) :: tip
      integer, intent(in) :: node
      type(problem_t), intent(in) :: problem
      type(particles_t), intent(in) :: p
      real(dp), intent(in) :: applied(ndim, 2)   !! force from outside on the part of each face [N]
      real(dp) :: force(ndim)
      type(patch_t) :: patch
      real(dp) :: f(ndim, 2), mass(2)
      integer :: k
      f = 0
      mass = 0
      do k = 1, 2
         if (.not. tip%face(k)) cycle
         call patch_around(problem%grid, p, problem%blocks, node, patch, toward=(3 - 2*k)*tip%axis(:, 2))
         f(:, k) = internal_force(patch, p, problem%materials) + applied(:, k)
         mass(k) = patch_mass(patch, p)
      end do
      if (tip%is_half()) then
         force = f(:, upper) - f(:, lower)
      else
         force = (mass(lower)*f(:, upper) - mass(upper)*f(:, lower))/sum(mass)
      end if
   end function transmitted_force
end module hampm_crack_closure
