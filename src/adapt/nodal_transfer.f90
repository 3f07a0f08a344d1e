!> Transfer of nodal fields to another mesh: the field of the old one at the places of the new nodes. In finer cells it is exactly
!> the same field.
module hampm_nodal_transfer
   use hampm_kinds, only: dp, ndim
   use hampm_tensors, only: norm
   use hampm_basis, only: points_of_quadratic
   use hampm_dofs, only: most_nodes_of_leaf
   use hampm_grid, only: grid_t
   use hampm_problem, only: problem_t
   implicit none
   private
   public :: old_mesh_t, leave_mesh, carry_nodes

   !> A mesh that is left.
   type :: old_mesh_t
      type(grid_t) :: grid
      integer, allocatable :: cell(:)            !! element of each particle there, in the order that they have now
   end type old_mesh_t

contains

   !> Keep the present mesh, where nodes keep anything.
   subroutine leave_mesh(m, old)
      type(problem_t), intent(in) :: m
      type(old_mesh_t), allocatable, intent(out) :: old
      if (.not. (allocated(m%state%displacement) .or. allocated(m%state%velocity))) return
      allocate (old)
      old%grid = m%grid
      old%cell = m%particles%cell(:m%particles%n)
   end subroutine leave_mesh

   !> Transfer nodal fields to the present mesh, into which the particles have just been sorted.
   subroutine carry_nodes(old, m)
      type(old_mesh_t), intent(inout) :: old
      type(problem_t), intent(inout) :: m
      real(dp), allocatable :: kept(:, :)        ! fields, the components of one after those of another, (components, n_points)
      allocate (kept(0, old%grid%n_points))
      old%cell(m%cache%sorting%new_place(:size(old%cell))) = old%cell
      call put(m%state%displacement)
      call put(m%state%velocity)
      call put(m%state%acceleration)
      call carry(old, m, kept)
      call take(m%state%acceleration)            ! the last one first
      call take(m%state%velocity)
      call take(m%state%displacement)
   contains
      !> Put a field that nodes keep behind the others.
      subroutine put(field)
         real(dp), allocatable, intent(in) :: field(:, :)
         real(dp), allocatable :: more(:, :)
         if (.not. allocated(field)) return
         associate (n => size(kept, 1))
            allocate (more(n + ndim, size(kept, 2)))
            more(:n, :) = kept
            more(n + 1:, :) = field
         end associate
         call move_alloc(more, kept)
      end subroutine put

      !> Take the last one off.
      subroutine take(field)
         real(dp), allocatable, intent(inout) :: field(:, :)
         if (.not. allocated(field)) return
         associate (n => size(kept, 1) - ndim)
            field = kept(n + 1:, :)
            kept = kept(:n, :)
         end associate
      end subroutine take
   end subroutine carry_nodes

   !> Transfer nodal fields. Each element around a node gives the value of the old element of its particle next to the node (or the
   !> mean of those equally near), so that each face of a crack has its own values; the node has the mean of these. A node that is
   !> of no element with particles, but a master of a hanging node of one, has the values of the old elements there, extrapolated.
   subroutine carry(old, m, fields)
      type(old_mesh_t), intent(in) :: old
      type(problem_t), intent(in) :: m
      real(dp), allocatable, intent(inout) :: fields(:, :) !! (components, n_points)
      real(dp), allocatable :: carried(:, :), beyond(:, :)
      integer, allocatable :: times(:), times_beyond(:)
      real(dp) :: weight(points_of_quadratic, most_nodes_of_leaf)
      integer :: masters(most_nodes_of_leaf), k, c, j, n
      allocate (times(m%grid%n_points), times_beyond(m%grid%n_nodes))
      allocate (carried(size(fields, 1), m%grid%n_points), beyond(size(fields, 1), m%grid%n_nodes), source=0.0_dp)
      times = 0
      times_beyond = 0
      do k = 1, m%blocks%n_occupied
         associate (e => m%blocks%occupied(k), at => m%grid%support_of(m%blocks%occupied(k)), b => m%blocks)
            if (b%count_in(e) == 0) cycle        ! an empty quarter of a quadratic cell: the others have its nodes
            do c = 1, size(at)
               carried(:, at(c)) = carried(:, at(c)) + value_at(e, m%grid%node_position(:, at(c)), .true.)
               times(at(c)) = times(at(c)) + 1
            end do
            if (all(at <= m%grid%n_nodes)) cycle
            call m%grid%dofs%masters_of(at, n, masters, weight(:size(at), :))
            do j = 1, n
               if (any(at == masters(j))) cycle
               beyond(:, masters(j)) = beyond(:, masters(j)) + value_at(e, m%grid%node_position(:, masters(j)), .false.)
               times_beyond(masters(j)) = times_beyond(masters(j)) + 1
            end do
         end associate
      end do
      do k = 1, size(times)
         if (times(k) > 1) carried(:, k) = carried(:, k)/times(k)
         if (times(k) > 0 .or. k > size(times_beyond)) cycle
         if (times_beyond(k) > 0) carried(:, k) = beyond(:, k)/times_beyond(k)
      end do
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, size(fields, 1), carried)
      call move_alloc(carried, fields)

   contains

      !> The fields at a place, by the old elements of the particles of an element that are nearest to it: in these, or beyond.
      function value_at(e, place, within) result(value)
         integer, intent(in) :: e
         real(dp), intent(in) :: place(ndim)     !! [m]
         logical, intent(in) :: within           !! whether the place counts as in the old element, at its nearest point
         real(dp) :: value(size(fields, 1))
         real(dp), parameter :: alike = 1e-9_dp  ! relative difference of distances that count as equal
         real(dp) :: least, local(ndim), shape(points_of_quadratic)
         integer :: points(points_of_quadratic), i, n, j
         least = huge(least)
         do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
            least = min(least, norm(m%particles%place_in_grid(i) - place))
         end do
         value = 0
         n = 0
         do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
            if (norm(m%particles%place_in_grid(i) - place) > least*(1 + alike)) cycle
            local = old%grid%local_coordinate(old%cell(i), place)
            if (within) local = min(1.0_dp, max(0.0_dp, local))
            call old%grid%shape_functions_in(old%cell(i), local, points, shape)
            do j = 1, old%grid%n_functions
               value = value + shape(j)*fields(:, points(j))
            end do
            n = n + 1
         end do
         value = value/n
      end function value_at
   end subroutine carry
end module hampm_nodal_transfer
