!> Points of a grid that have no degrees of freedom of their own: the middle of a side beside which there is no finer cell, and
!> the middle of a transition element. Their values are weighted means of values at nodes: x = T x_nodes. What is summed at
!> them belongs to these nodes by the same weights, T transposed.
!>
!> All weights are positive and those of a point add up to 1. So the lumped mass of a node is a sum of particle masses times
!> positive numbers, velocities stay in the range of the particles', and by convexity (T x)**2 <= T x**2 the time step that is
!> stable for all the small elements is stable for the transition element.
module hampm_dependents
   use hampm_kinds, only: dp
   implicit none
   private
   public :: dependents_t

   !> The dependent points of a grid, and the weights of their values.
   type :: dependents_t
      integer :: n = 0                           !! number of dependent points
      integer :: n_nodes = 0                     !! points are numbered on from the nodes
      integer, allocatable :: start(:)           !! first entry of each dependent point, (n + 1)
      integer, allocatable :: node(:)            !! node of each entry
      real(dp), allocatable :: weight(:)         !! its weight [-]
   contains
      procedure :: expand
      procedure :: collect
      procedure :: mark_parents
   end type dependents_t

contains

   !> Find the values of some dependent points from those of the nodes.
   pure subroutine expand(self, points, width, x)
      class(dependents_t), intent(in) :: self
      integer, intent(in) :: points(:)           !! dependent points, numbered on from the nodes
      integer, intent(in) :: width               !! components
      real(dp), intent(inout) :: x(width, *)     !! by point
      real(dp) :: total(width)
      integer :: k, j
      do k = 1, size(points)
         total = 0
         do j = self%start(points(k) - self%n_nodes), self%start(points(k) - self%n_nodes + 1) - 1
            total = total + self%weight(j)*x(:, self%node(j))
         end do
         x(:, points(k)) = total
      end do
   end subroutine expand

   !> Give the nodes what was summed at some dependent points, which are zero afterwards; where there is a `scale`, times that of
   !> the node.
   pure subroutine collect(self, points, width, x, scale)
      class(dependents_t), intent(in) :: self
      integer, intent(in) :: points(:)
      integer, intent(in) :: width
      real(dp), intent(inout) :: x(width, *)     !! by point
      real(dp), intent(in), optional :: scale(width, *)
      real(dp) :: share(width)
      integer :: k, j
      do k = 1, size(points)
         do j = self%start(points(k) - self%n_nodes), self%start(points(k) - self%n_nodes + 1) - 1
            share = self%weight(j)*x(:, points(k))
            if (present(scale)) share = scale(:, self%node(j))*share
            x(:, self%node(j)) = x(:, self%node(j)) + share
         end do
         x(:, points(k)) = 0
      end do
   end subroutine collect

   !> Mark the nodes that a dependent point depends on.
   pure subroutine mark_parents(self, point, marked)
      class(dependents_t), intent(in) :: self
      integer, intent(in) :: point
      logical, intent(inout) :: marked(:)        !! by point
      associate (k => point - self%n_nodes)
         marked(self%node(self%start(k):self%start(k + 1) - 1)) = .true.
      end associate
   end subroutine mark_parents
end module hampm_dependents
