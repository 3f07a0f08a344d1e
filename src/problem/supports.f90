!> Constraints that only push are supports. A component of a node is fixed while the material presses on the support, and free after
!> lift-off. A support pushes towards the material: all particles around a node of it are on one side.
!>
!> The fixed components are found by iterations (`hampm_balance`): release pulled ones, hold those that would penetrate the support.
!>
!> Source: Wriggers, Nonlinear Finite Element Methods (2008), chapter 10 (active sets).
module hampm_supports
   use hampm_kinds, only: dp, ndim
   use hampm_archive, only: archive_t
   use hampm_constraints, only: constraints_t
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_failure, only: failure_t, exit_input
   use hampm_problem, only: problem_t
   use hampm_text, only: point_text, without_rounding
   implicit none
   private
   public :: check_supports, find_wrong_supports, turn_supports, lift_by, press_on_supports, archive_supports

   real(dp), parameter :: through = 1e-12_dp     !! penetration of a node before it is held, over the largest lift

contains

   !> Fail where material stands on both sides of a support.
   subroutine check_supports(m, failure)
      type(problem_t), intent(in) :: m
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: side(:, :), other(:, :)
      real(dp) :: x(ndim)
      integer :: k, d
      allocate (side(ndim, m%grid%n_nodes), other(ndim, m%grid%n_nodes))
      if (.not. m%constraints%only_push()) return
      call weigh_sides(m, side, other)
      do k = 1, size(m%constraints%node)
         associate (node => m%constraints%node(k))
            do d = 1, ndim
               if (.not. m%constraints%supported(d, node) .or. min(side(d, node), other(d, node)) <= 0) cycle
               x = without_rounding(m%grid%node_position(:, node), maxval(m%grid%forest%cells)*m%grid%forest%cell)
               call failure%report(exit_input, '&constraint unilateral: the node at '//point_text(x)// &
                                   ' m has material on both sides in '//axis(d)//', so that the direction of its '// &
                                   'reaction is not known; a support must be at an edge normal to the component that it fixes')
               return
            end do
         end associate
      end do
   end subroutine check_supports

   !> Name of a direction.
   pure character function axis(d)
      integer, intent(in) :: d
      character(*), parameter :: axes = 'xyz'
      axis = axes(d:d)
   end function axis

   !> Mass above and below the supported components of nodes, by its part in these and in nodes hanging on them [kg].
   subroutine weigh_sides(m, above, below)
      type(problem_t), intent(in) :: m
      real(dp), intent(out) :: above(:, :), below(:, :) !! (ndim, n_nodes)
      real(dp) :: weight(m%grid%n_functions, most_nodes_of_leaf), part, offset(ndim)
      integer :: i, j, n, master(most_nodes_of_leaf)
      above = 0
      below = 0
      associate (p => m%particles)
         do i = 1, p%n
            call m%grid%dofs%masters_of(m%grid%support_of(p%cell(i)), n, master, weight)
            do j = 1, n
               part = p%mass(i)*abs(dot_product(weight(:, j), m%grid%functions_in(p%cell(i), &
                                                               m%grid%local_coordinate(p%cell(i), p%place_in_grid(i)))))
               offset = p%place_in_grid(i) - m%grid%node_position(:, master(j))
               above(:, master(j)) = above(:, master(j)) + merge(part, 0.0_dp, offset > 0)
               below(:, master(j)) = below(:, master(j)) + merge(part, 0.0_dp, offset < 0)
            end do
         end do
      end associate
   end subroutine weigh_sides

   !> Find which way from their supports the material is, once for a grid: in the total frame it stays there.
   subroutine find_sides(m)
      type(problem_t), intent(inout) :: m
      real(dp), allocatable :: above(:, :), below(:, :)
      allocate (above(ndim, m%grid%n_nodes), below(ndim, m%grid%n_nodes))
      if (allocated(m%constraints%up)) return
      call weigh_sides(m, above, below)
      m%constraints%up = merge(1.0_dp, -1.0_dp, above > below)
   end subroutine find_sides

   !> Fix all supported components of nodes.
   pure subroutine press_on_supports(c)
      type(constraints_t), intent(inout) :: c
      integer :: k, d
      c%lift = 0
      do k = 1, size(c%node)
         do d = 1, ndim
            if (c%supported(d, c%node(k))) call c%set_fixed(d, c%node(k), .true.)
         end do
      end do
   end subroutine press_on_supports

   !> Find the distances of the nodes from their supports, from their displacement, and hold those that are not above them.
   subroutine lift_by(m, u)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, n_points)
      integer :: k, d
      m%constraints%lift = u(:, :m%grid%n_nodes) - m%constraints%prescribed_at(m%state%time)
      call find_sides(m)
      do k = 1, size(m%constraints%node)
         associate (node => m%constraints%node(k))
            do d = 1, ndim
               if (.not. m%constraints%supported(d, node)) cycle
               call m%constraints%set_fixed(d, node, m%constraints%lift(d, node)*m%constraints%up(d, node) <= 0)
            end do
         end associate
      end do
   end subroutine lift_by

   !> Wrongly held or free components: pulled by their supports, or penetrating them.
   subroutine find_wrong_supports(m, r, rounding, wrong, pull)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: r(:, :)            !! the residual without the supports [N], (ndim, n_points)
      real(dp), intent(in) :: rounding           !! of that [N]
      logical, allocatable, intent(out) :: wrong(:, :) !! (ndim, n_nodes)
      real(dp), allocatable, intent(out) :: pull(:, :) !! tension of supports [N], (ndim, n_nodes)
      allocate (wrong(ndim, m%grid%n_nodes), pull(ndim, m%grid%n_nodes))
      wrong = .false.
      pull = 0
      if (.not. m%constraints%only_push()) return
      call find_sides(m)
      associate (c => m%constraints)
         where (c%supported .and. c%fixed)
            pull = r(:, :size(pull, 2))*c%up
            wrong = pull > rounding
         elsewhere (c%supported)
            wrong = c%lift*c%up < -through*largest_lift(c)
         end where
      end associate
   end subroutine find_wrong_supports

   !> Hold or free components at supports.
   pure subroutine turn_supports(c, some)
      type(constraints_t), intent(inout) :: c
      logical, intent(in) :: some(:, :)          !! (ndim, n_nodes)
      call c%fix(c%fixed .neqv. some)
   end subroutine turn_supports

   !> Largest distance of a component from its support [m].
   pure real(dp) function largest_lift(c)
      type(constraints_t), intent(in) :: c
      largest_lift = max(0.0_dp, maxval(abs(c%lift), mask=c%supported))
   end function largest_lift

   !> Save or restore the components held by supports, and the distances of the others.
   subroutine archive_supports(c, archive)
      type(constraints_t), intent(inout) :: c
      class(archive_t), intent(inout) :: archive
      integer :: k, d
      if (.not. c%only_push()) return
      call archive%section('supports')
      call archive%archive_reals('lift', size(c%lift), c%lift)
      call archive%archive_logicals('fixed', size(c%fixed), c%fixed)
      if (archive%failure%failed()) return
      do k = 1, size(c%node)
         do d = 1, ndim
            if (c%supported(d, c%node(k))) call c%set_fixed(d, c%node(k), c%fixed(d, c%node(k)))
         end do
      end do
   end subroutine archive_supports
end module hampm_supports
