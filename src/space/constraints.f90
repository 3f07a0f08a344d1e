!> Dirichlet constraints: nodes whose velocity is fixed at zero in some directions. The user gives them as boxes, which are fitted
!> to each new grid. One grid may have several sets of them: extrapolations are solved without the constraints of the motion.
module hampm_constraints
   use hampm_kinds, only: dp, ndim
   use hampm_grid, only: grid_t
   use hampm_tolerance, only: position_tolerance
   implicit none
   private
   public :: constraints_t, constrain_box, rebuild_constraints, hold

   !> A box in which nodes are fixed.
   type :: box_t
      real(dp) :: lower(ndim) = 0, upper(ndim) = 0 !! its corners [m]
      logical :: components(ndim) = .false.      !! which components it fixes
   end type box_t

   !> Boxes, and the nodes of the present grid that are fixed in them.
   type :: constraints_t
      type(box_t), allocatable, private :: boxes(:)
      logical, allocatable :: fixed(:, :)        !! which component of which node, (ndim, n_nodes)
      real(dp), allocatable :: free(:, :)        !! 0 where a component is fixed, else 1; (ndim, n_points)
      integer, allocatable :: node(:)            !! nodes with a fixed component, ascending
   contains
      procedure :: holds
   end type constraints_t

contains

   !> Fix the `components` of all nodes within a box, its faces included.
   subroutine constrain_box(c, grid, lower, upper, components)
      type(constraints_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the box [m]
      logical, intent(in) :: components(ndim)
      if (.not. allocated(c%boxes)) allocate (c%boxes(0))
      c%boxes = [c%boxes, box_t(lower, upper, components)]
      if (.not. allocated(c%fixed)) then
         call rebuild_constraints(c, grid)
      else
         call hold_in_box(c, grid, size(c%boxes))
         call list_fixed(c, grid)
      end if
   end subroutine constrain_box

   !> Find the nodes of a grid that are in the boxes.
   subroutine rebuild_constraints(c, grid)
      type(constraints_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      integer :: k
      if (allocated(c%fixed)) deallocate (c%fixed, c%free)
      allocate (c%fixed(ndim, grid%n_nodes), source=.false.)
      allocate (c%free(ndim, grid%n_points), source=1.0_dp)
      if (.not. allocated(c%boxes)) allocate (c%boxes(0))
      do k = 1, size(c%boxes)
         call hold_in_box(c, grid, k)
      end do
      call list_fixed(c, grid)
   end subroutine rebuild_constraints

   !> Fix the nodes in the k-th box.
   pure subroutine hold_in_box(c, grid, k)
      type(constraints_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: k
      real(dp) :: margin
      integer :: i
      associate (f => grid%forest)
         margin = position_tolerance(f%cell, f%lower, f%lower + f%cell*f%cells)
      end associate
      do i = 1, grid%n_nodes
         associate (x => grid%node_position(:, i), box => c%boxes(k))
            if (all(x >= box%lower - margin .and. x <= box%upper + margin)) c%fixed(:, i) = c%fixed(:, i) .or. box%components
         end associate
      end do
   end subroutine hold_in_box

   !> What follows from the nodes that are fixed.
   pure subroutine list_fixed(c, grid)
      type(constraints_t), intent(inout) :: c
      type(grid_t), intent(in) :: grid
      integer :: i
      where (c%fixed) c%free(:, :grid%n_nodes) = 0
      c%node = pack([(i, i=1, grid%n_nodes)], any(c%fixed, dim=1))
   end subroutine list_fixed

   !> Whether a component of a node is fixed.
   pure logical function holds(self, node, component)
      class(constraints_t), intent(in) :: self
      integer, intent(in) :: node, component
      holds = .false.
      if (allocated(self%fixed)) holds = self%fixed(component, node)
   end function holds

   !> Set the fixed components of a nodal field to zero.
   pure subroutine hold(c, field)
      type(constraints_t), intent(in) :: c
      real(dp), intent(inout), contiguous :: field(:, :)  !! (ndim, n_points)
      integer :: k
      if (.not. allocated(c%node)) return
      do k = 1, size(c%node)
         where (c%fixed(:, c%node(k))) field(:, c%node(k)) = 0
      end do
   end subroutine hold
end module hampm_constraints
