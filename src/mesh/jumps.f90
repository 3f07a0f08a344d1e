!> Jumps of a nodal field, as of the displacement between the sides of an interface: sums over nodes of c_j u_j. One may have a mass
!> m beside the particles' (`hampm_ghost_penalty`):
!>
!>    M <- M + m c c^T.
module hampm_jumps
   use hampm_kinds, only: dp, ndim
   use hampm_dofs, only: most_nodes_of_leaf
   implicit none
   private
   public :: jump_t, jump_of, give_nodes, add_mass_product, nodes_of_jumps

   !> A jump.
   type :: jump_t
      integer :: node(2*most_nodes_of_leaf) = 0  !! no hanging ones, 0 behind the last
      real(dp) :: share(2*most_nodes_of_leaf) = 0 !! c_j [-]
      real(dp) :: mass = 0                       !! m [kg]
   end type jump_t

contains

   !> The jump of a field.
   pure function jump_of(jump, field) result(of_field)
      type(jump_t), intent(in) :: jump
      real(dp), intent(in) :: field(:, :)        !! (ndim, n_points)
      real(dp) :: of_field(ndim)
      integer :: j
      of_field = 0
      do j = 1, count(jump%node > 0)
         of_field = of_field + jump%share(j)*field(:, jump%node(j))
      end do
   end function jump_of

   !> Give the nodes of a jump their shares of something, times given factors of their components.
   pure subroutine give_nodes(jump, what, field, factor)
      type(jump_t), intent(in) :: jump
      real(dp), intent(in) :: what(ndim)
      real(dp), intent(inout) :: field(:, :)     !! (ndim, n_points)
      real(dp), intent(in), optional :: factor(:, :) !! (ndim, n_points)
      real(dp) :: part(ndim)
      integer :: j
      do j = 1, count(jump%node > 0)
         part = jump%share(j)*what
         if (present(factor)) part = part*factor(:, jump%node(j))
         field(:, jump%node(j)) = field(:, jump%node(j)) + part
      end do
   end subroutine give_nodes

   !> y <- y + sum of m c (c.x), times given factors of the components of the nodes, and the sum of m (c.x)**2.
   pure subroutine add_mass_product(jumps, x, y, xax, factor)
      type(jump_t), intent(in) :: jumps(:)
      real(dp), intent(in) :: x(:, :)            !! (ndim, n_points)
      real(dp), intent(inout) :: y(:, :)         !! (ndim, n_points)
      real(dp), intent(out) :: xax(ndim)
      real(dp), intent(in), optional :: factor(:, :) !! (ndim, n_points)
      real(dp) :: of_x(ndim)
      integer :: k
      xax = 0
      do k = 1, size(jumps)
         of_x = jump_of(jumps(k), x)
         call give_nodes(jumps(k), jumps(k)%mass*of_x, y, factor)
         xax = xax + jumps(k)%mass*of_x**2
      end do
   end subroutine add_mass_product

   !> The nodes of jumps, 0 behind the last of each.
   pure function nodes_of_jumps(jumps) result(nodes)
      type(jump_t), intent(in) :: jumps(:)
      integer :: nodes(2*most_nodes_of_leaf, size(jumps)), k
      do k = 1, size(jumps)
         nodes(:, k) = jumps(k)%node
      end do
   end function nodes_of_jumps
end module hampm_jumps
