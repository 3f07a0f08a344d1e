!> Unconstrained rigid-body modes. Connected material in static equilibrium needs three held: two directions and the turning; in
!> space six: three directions and turning around their axes. If constraints hold less, rigid-body constraints at nodes hold the
!> rest: without force if the loads balance each other; else there is no equilibrium. Loads of fixed direction balance on the
!> deformed material, after it has turned: the rigid-body constraints do not affect the angle.
module hampm_rigid_motions
   use hampm_kinds, only: dp, ndim, corners
   use hampm_tensors, only: norm
   use hampm_basis, only: points_of_quadratic
   use hampm_constraints, only: hold
   use hampm_disjoint_sets, only: disjoint_sets_t, singletons
   use hampm_failure, only: failure_t, exit_computation
   use hampm_interface_points, only: is_half, pulls
   use hampm_lapack, only: dposv, dsyev
   use hampm_problem, only: problem_t
   use hampm_text, only: to_text, three_digits, point_text, without_rounding
   implicit none
   private
   public :: rigid_constraint_t, find_rigid_constraints, check_rigid_constraints, turn_with, free_motions_t, find_free_motions, &
             take_inertia, take_motion_as_whole, number_of_pieces, motions, motions_at

   integer, parameter :: motions = ndim*(ndim + 1)/2 !! of a piece of material: along each axis, then turnings between two axes
   real(dp), parameter :: not_held = 1e-10_dp    !! motion of held components below which a mode is free

   !> A direction of a node, held in place of a constraint.
   type :: rigid_constraint_t
      integer :: node = 0
      integer :: direction = 0
      integer :: piece = 0                       !! that it holds
      integer :: body = 0                        !! of this
      integer :: motion = 0                      !! of which it holds this
      real(dp) :: free(motions) = 0              !! that motion
   contains
      procedure :: turns
   end type rigid_constraint_t

   !> The motions as a whole that nothing holds on a mesh.
   type :: free_motions_t
      type(rigid_constraint_t), allocatable :: rigid_constraints(:) !! one for each
      real(dp), allocatable, private :: motion(:, :, :)   !! of the points [-], (ndim, n_points, motions)
      real(dp), allocatable, private :: momentum(:, :, :) !! mass times these [kg], (ndim, n_points, motions)
      real(dp), allocatable, private :: mass(:, :)        !! products of both [kg], (motions, motions)
   contains
      procedure :: are_pushed
   end type free_motions_t

contains

   !> Whether it holds how a piece turns.
   pure logical function turns(self)
      class(rigid_constraint_t), intent(in) :: self
      turns = self%motion > ndim
   end function turns

   !> Constraints of rigid-body modes that the constraints leave free. Faces that may press on each other count as connected.
   subroutine find_rigid_constraints(m, rigid_constraints)
      type(problem_t), intent(in) :: m
      type(rigid_constraint_t), allocatable, intent(out) :: rigid_constraints(:)
      type(rigid_constraint_t) :: constraint
      integer, allocatable :: piece(:), body(:)
      real(dp), allocatable :: held(:, :, :)
      real(dp) :: free(motions)
      integer :: k, root
      allocate (rigid_constraints(0))
      call find_pieces(m, piece)
      call find_what_is_held(m, piece, held)
      allocate (body(m%grid%n_nodes), source=0)
      do k = 1, m%blocks%n_occupied
         associate (e => m%blocks%occupied(k))
            root = piece(first_master(m, e))
            if (body(root) > 0) cycle
            body(root) = m%particles%body(m%blocks%first_in(e))
         end associate
         do
            call find_free_motion(held(:, :, root), free, constraint%motion)
            if (constraint%motion == 0) exit
            call find_best_constraint(m, piece == root, free, constraint)
            constraint%piece = root
            constraint%body = body(root)
            constraint%free = free
            rigid_constraints = [rigid_constraints, constraint]
            call add_row(row_of(m, constraint%node, constraint%direction), held(:, :, root))
         end do
      end do
   end subroutine find_rigid_constraints

   !> A rigid-body mode that moves nothing held, and the direction, or `motions` for turning, that names it; 0 if there is none.
   pure subroutine find_free_motion(held, free, motion)
      real(dp), intent(in) :: held(motions, motions)
      real(dp), intent(out) :: free(motions)
      integer, intent(out) :: motion
      real(dp) :: cross(motions, motions), value(motions), work(8*motions)
      integer :: k
      free = 0
      do motion = 1, ndim
         if (held(motion, motion) > 0) cycle
         free(motion) = 1
         return
      end do
      if (ndim > 2) then
         cross = held
         call dsyev('V', 'U', motions, cross, motions, value, work, size(work), k)
         free = cross(:, 1)
         motion = merge(motions, 0, value(1) <= not_held*maxval([(held(k, k), k=1, motions)]))
         return
      end if
      do k = 1, motions
         associate (a => held(:, mod(k, motions) + 1), b => held(:, mod(k + 1, motions) + 1))
            cross(:, k) = cshift(a, 1)*cshift(b, 2) - cshift(a, 2)*cshift(b, 1)
         end associate
      end do
      free = cross(:, maxloc(sum(cross**2, dim=1), dim=1))
      free = free/norm(free)
      motion = merge(motions, 0, dot_product(free, matmul(held, free)) <= not_held*maxval([(held(k, k), k=1, motions)]))
   end subroutine find_free_motion

   !> The direction of a node of a piece that a motion moves most.
   pure subroutine find_best_constraint(m, in_piece, free, constraint)
      type(problem_t), intent(in) :: m
      logical, intent(in) :: in_piece(:)         !! by node
      real(dp), intent(in) :: free(motions)
      type(rigid_constraint_t), intent(inout) :: constraint
      real(dp) :: most, moved
      integer :: k, d
      most = -1
      do k = 1, m%fields%mass_matrix%all%n_nodes
         associate (node => m%fields%mass_matrix%all%nodes(k))
            if (.not. in_piece(node)) cycle
            do d = 1, ndim
               if (m%constraints%fixed(d, node)) cycle
               moved = abs(dot_product(row_of(m, node, d), free))
               if (moved <= most*(1 + not_held)) cycle
               most = moved
               constraint%node = node
               constraint%direction = d
            end do
         end associate
      end do
   end subroutine find_best_constraint

   !> Displacements of a node in a direction by the modes.
   pure function row_of(m, node, direction) result(row)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: node, direction
      real(dp) :: row(motions)
      row = row_at(m, m%grid%node_position(:, node), direction)
   end function row_of

   !> The same at a place [m]; lengths are over the extent of the grid.
   pure function row_at(m, place, direction) result(row)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: place(ndim)
      integer, intent(in) :: direction
      real(dp) :: row(motions)
      row = motions_at((place - m%grid%forest%lower)/(maxval(m%grid%forest%cells)*m%grid%forest%cell), direction)
   end function row_at

   !> Displacements of a place in a direction by the modes.
   pure function motions_at(x, direction) result(moves)
      real(dp), intent(in) :: x(ndim)
      integer, intent(in) :: direction
      real(dp) :: moves(motions)
      integer :: a, b, n
      moves = 0
      moves(direction) = 1
      n = ndim
      do b = 2, ndim
         do a = 1, b - 1                         ! turning from axis a to axis b
            n = n + 1
            if (direction == a) moves(n) = -x(b)
            if (direction == b) moves(n) = x(a)
         end do
      end do
   end function motions_at

   !> The rigid-body mode of a rigid-body constraint, with a displacement of 1 of its node in its direction [-].
   subroutine turn_with(m, constraint, u)
      type(problem_t), intent(in) :: m
      type(rigid_constraint_t), intent(in) :: constraint
      real(dp), allocatable, intent(out) :: u(:, :) !! (ndim, n_points)
      integer, allocatable :: piece(:)
      allocate (u(ndim, m%grid%n_points))
      call find_pieces(m, piece)
      call turn_piece(m, piece, constraint, u)
   end subroutine turn_with

   !> The same where the piece of each node is known.
   subroutine turn_piece(m, piece, constraint, u)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: piece(:)
      type(rigid_constraint_t), intent(in) :: constraint
      real(dp), intent(out) :: u(:, :)           !! (ndim, n_points)
      real(dp) :: moved
      integer :: k, d
      u = 0
      moved = dot_product(row_of(m, constraint%node, constraint%direction), constraint%free)
      do k = 1, m%grid%n_nodes
         if (piece(k) /= constraint%piece) cycle
         do d = 1, ndim
            u(d, k) = dot_product(row_of(m, k, d), constraint%free)/moved
         end do
      end do
      call hold(m%constraints, u)                ! up to rounding
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, u)
   end subroutine turn_piece

   !> Find the motions as a whole that nothing holds, and their momenta.
   subroutine find_free_motions(m, free, rigid_constraints)
      type(problem_t), intent(in) :: m
      type(free_motions_t), intent(out) :: free
      type(rigid_constraint_t), intent(in), optional :: rigid_constraints(:) !! if they are known
      integer, allocatable :: piece(:)
      integer :: i, k, n
      if (present(rigid_constraints)) then
         free%rigid_constraints = rigid_constraints
      else
         call find_rigid_constraints(m, free%rigid_constraints)
      end if
      n = size(free%rigid_constraints)
      allocate (free%motion(ndim, m%grid%n_points, n), free%momentum(ndim, m%grid%n_points, n), free%mass(n, n), source=0.0_dp)
      if (n == 0) return
      call find_pieces(m, piece)
      do k = 1, n
         call turn_piece(m, piece, free%rigid_constraints(k), free%motion(:, :, k))
      end do
      call add_momenta(m, free%motion, free%momentum)
      do k = 1, n
         free%mass(:, k) = [(sum(free%motion(:, :, i)*free%momentum(:, :, k)), i=1, n)]
      end do
   end subroutine find_free_motions

   !> Add products of motions with the mass matrices of the cells.
   pure subroutine add_momenta(m, motion, momentum)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: motion(:, :, :)    !! (ndim, n_points, motions)
      real(dp), intent(inout) :: momentum(:, :, :) !! [kg], as these
      real(dp) :: shape(points_of_quadratic), mass(points_of_quadratic, points_of_quadratic), sum_of(ndim)
      integer :: at(points_of_quadratic), i, j, k, l, c
      associate (p => m%particles, b => m%blocks, n => m%grid%n_functions)
         do k = 1, b%n_occupied
            associate (e => b%occupied(k))
               mass(:n, :n) = 0
               do i = b%first_in(e), b%last_in(e), b%stride_in(e)
                  call m%grid%shape_functions_in(e, m%local_of(i), at, shape)
                  do j = 1, n
                     mass(:n, j) = mass(:n, j) + p%mass(i)*shape(j)*shape(:n)
                  end do
               end do
               if (b%count_in(e) == 0) cycle
               do c = 1, size(motion, 3)
                  do j = 1, n
                     sum_of = 0
                     do l = 1, n
                        sum_of = sum_of + mass(l, j)*motion(:, at(l), c)
                     end do
                     momentum(:, at(j), c) = momentum(:, at(j), c) + sum_of
                  end do
               end do
            end associate
         end do
      end associate
   end subroutine add_momenta

   !> Whether forces do work on the modes, above a part of the work of their magnitudes.
   pure logical function are_pushed(self, force, part)
      class(free_motions_t), intent(in) :: self
      real(dp), intent(in) :: force(:, :)        !! [N], (ndim, n_points)
      real(dp), intent(in) :: part               !! [-]
      integer :: k
      are_pushed = .false.
      do k = 1, size(self%mass, 1)
         are_pushed = are_pushed .or. abs(sum(force*self%motion(:, :, k))) > part*sum(abs(force*self%motion(:, :, k)))
      end do
   end function are_pushed

   !> Subtract from forces the rigid-body acceleration of free material times its mass: it causes no strain.
   subroutine take_inertia(free, force, acceleration)
      type(free_motions_t), intent(in) :: free
      real(dp), intent(inout) :: force(:, :)     !! [N], (ndim, n_points)
      real(dp), allocatable, intent(out) :: acceleration(:, :) !! of the points [m/s2], (ndim, n_points)
      real(dp) :: share(size(free%mass, 1))
      integer :: k
      allocate (acceleration, source=0*force)
      share = shares_of(free, [(sum(force*free%motion(:, :, k)), k=1, size(share))])
      do k = 1, size(share)
         acceleration = acceleration + share(k)*free%motion(:, :, k)
         force = force - share(k)*free%momentum(:, :, k)
      end do
   end subroutine take_inertia

   !> Subtract free rigid-body modes from a displacement: their rounding in a solution of K u = f turns the material, and with it
   !> the error of J in its path independence.
   subroutine take_motion_as_whole(free, u)
      type(free_motions_t), intent(in) :: free
      real(dp), intent(inout) :: u(:, :)         !! [m], (ndim, n_points)
      real(dp) :: share(size(free%mass, 1))
      integer :: k
      share = shares_of(free, [(sum(u*free%momentum(:, :, k)), k=1, size(share))])
      do k = 1, size(share)
         u = u - share(k)*free%motion(:, :, k)
      end do
   end subroutine take_motion_as_whole

   !> Share of each mode in a motion with given products with their momenta; 0 if their masses are singular.
   pure function shares_of(free, products) result(share)
      type(free_motions_t), intent(in) :: free
      real(dp), intent(in) :: products(:)
      real(dp) :: share(size(products)), matrix(size(products), size(products)), solution(size(products), 1)
      integer :: info
      matrix = free%mass
      solution(:, 1) = products
      call dposv('L', size(products), 1, matrix, max(1, size(products)), solution, max(1, size(products)), info)
      share = merge(solution(:, 1), 0.0_dp, info == 0)
   end function shares_of

   !> Add a held component.
   pure subroutine add_row(row, held)
      real(dp), intent(in) :: row(motions)
      real(dp), intent(inout) :: held(motions, motions)
      held = held + spread(row, 2, motions)*spread(row, 1, motions)
   end subroutine add_row

   !> Fail where rigid-body constraints take a force: the constrained mode moves.
   subroutine check_rigid_constraints(m, rigid_constraints, residual, rounding, failure)
      type(problem_t), intent(in) :: m
      type(rigid_constraint_t), intent(in) :: rigid_constraints(:)
      real(dp), intent(in) :: residual(:, :)       !! forces on the nodes [N], (ndim, n_points)
      real(dp), intent(in) :: rounding           !! of these [N]
      type(failure_t), intent(inout) :: failure
      real(dp) :: force(size(rigid_constraints)) ! on the rigid-body constraints [N]
      real(dp) :: total
      integer :: k
      force = [(residual(rigid_constraints(k)%direction, rigid_constraints(k)%node), k=1, size(rigid_constraints))]
      do k = 1, size(rigid_constraints)
         associate (constraint => rigid_constraints(k), x => without_rounding(m%grid%node_position(:, rigid_constraints(k)%node), &
                                                                              maxval(m%grid%forest%cells)*m%grid%forest%cell))
            total = force(k)
            if (constraint%motion <= ndim) total = sum(force, mask=rigid_constraints%piece == constraint%piece .and. &
                                                       rigid_constraints%direction == constraint%motion)
            if (abs(total) <= rounding) cycle
            call failure%report(exit_computation, 'the piece of body '//to_text(constraint%body)//' with the node at '// &
                                point_text(x)//' m has no equilibrium: it '// &
                                   motion_text(constraint, total)// &
                                ', or use &method time = ''explicit''')
            return
         end associate
      end do
   end subroutine check_rigid_constraints

   !> In words: the motion by the loads that a rigid-body constraint prevents, and a constraint that would hold it.
   function motion_text(constraint, force) result(text)
      type(rigid_constraint_t), intent(in) :: constraint
      real(dp), intent(in) :: force              !! [N]
      character(:), allocatable :: text
      character(*), parameter :: axis = 'xyz'
      if (constraint%turns()) then
         text = 'turns, as the loads have a moment and its constraints hold it at one point or along one line only. '// &
                'Hold another node by a &constraint'
      else
         text = 'moves along '//axis(constraint%motion:constraint%motion)//', as the loads push with '//three_digits(abs(force))// &
                ' N and no &constraint with fix = '''//axis(constraint%motion:constraint%motion)//''' holds a node of it. Add one'
      end if
   end function motion_text

   !> A node of an element that does not hang, or a master of one.
   pure integer function first_master(m, e) result(node)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      integer :: c
      do c = 1, corners
         node = m%grid%dofs%a_master_of(m%grid%element_nodes(c, e))
         if (node > 0) return
      end do
   end function first_master

   !> Number of pieces of all material. Faces that only press on each other, or without remaining cohesion, are apart.
   integer function number_of_pieces(m) result(number)
      type(problem_t), intent(in) :: m
      integer, allocatable :: piece(:)
      logical, allocatable :: is_one(:)
      integer :: k
      call find_pieces(m, piece, firmly=.true.)
      allocate (is_one(size(piece)), source=.false.)
      do k = 1, m%blocks%n_occupied
         is_one(piece(first_master(m, m%blocks%occupied(k)))) = .true.
      end do
      number = count(is_one)
   end function number_of_pieces

   !> Number of the piece of each node: nodes that share an element are in one piece.
   subroutine find_pieces(m, piece, firmly)
      type(problem_t), intent(in) :: m
      integer, allocatable, intent(out) :: piece(:)
      logical, intent(in), optional :: firmly    !! whether faces are connected only where they hold each other
      type(disjoint_sets_t) :: sets
      integer :: at(m%grid%n_functions), first, master, k, j
      call singletons(m%grid%n_nodes, sets)
      associate (dofs => m%grid%dofs, all => m%fields%mass_matrix%all)
         do k = all%n_nodes + 1, all%n_points    ! hanging nodes
            associate (hanging => all%nodes(k) - m%grid%n_nodes)
               do j = dofs%first_master(hanging) + 1, dofs%first_master(hanging + 1) - 1
                  call sets%join(dofs%master(j - 1), dofs%master(j))
               end do
            end associate
         end do
      end associate
      do k = 1, m%blocks%n_occupied
         first = first_master(m, m%blocks%occupied(k))
         at = m%grid%support_of(m%blocks%occupied(k))
         do j = 1, size(at)
            master = m%grid%dofs%a_master_of(at(j))
            if (master > 0 .and. master /= first) call sets%join(first, master)
         end do
      end do
      do k = 1, m%interfaces%n
         if (present(firmly)) then
            if (firmly .and. .not. pulls(m%interfaces%list(k))) cycle
         end if
         do j = 2, count(m%interfaces%list(k)%jump%node > 0)
            call sets%join(m%interfaces%list(k)%jump%node(1), m%interfaces%list(k)%jump%node(j))
         end do
      end do
      piece = [(sets%least_of(k), k=1, m%grid%n_nodes)]
   end subroutine find_pieces

   !> Sum, over the held components of each piece, of the squares of their displacements by its rigid-body modes. A symmetry plane
   !> holds what is bonded to it, or still coheres, across it.
   pure subroutine find_what_is_held(m, piece, held)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: piece(:)
      real(dp), allocatable, intent(out) :: held(:, :, :)  !! (motions, motions, nodes)
      real(dp) :: row(motions)
      integer :: k, d
      allocate (held(motions, motions, m%grid%n_nodes), source=0.0_dp)
      if (m%particles%thickness%is_ring) then    ! it strains as it moves along x or turns
         held(1, 1, :) = 1
         held(motions, motions, :) = 1
      end if
      do k = 1, size(m%constraints%node)
         associate (node => m%constraints%node(k))
            do d = 1, ndim
               if (m%constraints%fixed(d, node)) &
                  call add_row(row_at(m, m%constraints%held_at(m%grid, node, d), d), held(:, :, piece(node)))
            end do
         end associate
      end do
      do k = 1, m%interfaces%n
         associate (point => m%interfaces%list(k))
            if (.not. (is_half(point) .and. pulls(point))) cycle
            row = 0
            do d = 1, ndim
               row = row + point%normal(d)*row_at(m, point%middle, d)
            end do
            call add_row(row, held(:, :, piece(point%jump%node(1))))
         end associate
      end do
   end subroutine find_what_is_held
end module hampm_rigid_motions
