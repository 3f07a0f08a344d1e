!> Masses that quadratic cells have beside those of their particles, where cracks or edges cut them: on how far a node of a small piece is
!> from where the functions of a fuller cell beside it are continued to,
!>
!>    M <- M + sum over ties of m c c^T,   c.u = u_node - sum of the functions of the cell there times its nodes' u.
!>
!> No quadratic field has any of it. So mass, momentum and energy of such motions stay what they are, and M is as well-conditioned as that
!> of whole cells, however little is left of one.
!>
!> Source: Sticko & Kreiss, A stabilized Nitsche cut element method for the wave equation, Computer Methods in Applied Mechanics and
!> Engineering 309 (2016) 364-387.
module hampm_mass_ties
   use hampm_kinds, only: dp, ndim
   implicit none
   private
   public :: mass_ties_t, add_tied_product, nodes_of_ties

   !> All ties.
   type :: mass_ties_t
      integer :: n = 0
      integer, allocatable :: node(:, :)         !! no hanging ones, 0 behind the last of a tie; (nodes of a tie, n)
      real(dp), allocatable :: share(:, :)       !! c [-], (nodes of a tie, n)
      real(dp), allocatable :: mass(:)           !! m [kg], (n)
   end type mass_ties_t

contains

   !> y <- y + sum of m c (c.x), times given factors of the components of the nodes, and the sum of m (c.x)**2.
   pure subroutine add_tied_product(ties, x, y, xax, factor)
      type(mass_ties_t), intent(in) :: ties
      real(dp), intent(in) :: x(:, :)            !! (ndim, n_points)
      real(dp), intent(inout) :: y(:, :)         !! (ndim, n_points)
      real(dp), intent(out) :: xax(ndim)
      real(dp), intent(in), optional :: factor(:, :) !! (ndim, n_points)
      real(dp) :: along(ndim), part(ndim)
      integer :: k, j
      xax = 0
      do k = 1, ties%n
         associate (node => ties%node(:count(ties%node(:, k) > 0), k), share => ties%share(:, k))
            along = 0
            do j = 1, size(node)
               along = along + share(j)*x(:, node(j))
            end do
            do j = 1, size(node)
               part = ties%mass(k)*share(j)*along
               if (present(factor)) part = part*factor(:, node(j))
               y(:, node(j)) = y(:, node(j)) + part
            end do
            xax = xax + ties%mass(k)*along**2
         end associate
      end do
   end subroutine add_tied_product

   !> The nodes of each tie, 0 behind the last.
   pure function nodes_of_ties(ties) result(nodes)
      type(mass_ties_t), intent(in) :: ties
      integer, allocatable :: nodes(:, :)
      if (ties%n == 0) then
         allocate (nodes(0, 0))
      else
         nodes = ties%node
      end if
   end function nodes_of_ties
end module hampm_mass_ties
