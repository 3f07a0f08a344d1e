!> A crack on a symmetry plane along a line of nodes: the tip and the nodes on both sides of it.
module hampm_crack
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t, exit_input
   use hampm_grid, only: grid_t
   implicit none
   private
   public :: crack_t, find_crack

   !> The nodes of Fig. 2 of Tan & Nairn: (1) one cell behind the tip, (2) the tip, (3) one cell ahead of it.
   type :: crack_t
      integer :: node_behind = 0
      integer :: node_tip = 0
      integer :: node_ahead = 0
      integer :: normal = 0                      !! the direction normal to the crack
      real(dp) :: side = 0                       !! sign of the side of the plane on which the material is
      real(dp) :: step = 0                       !! distance between these nodes [m]
   end type crack_t

contains

   !> Find the nodes around the tip of a crack on a symmetry plane. Fails where there are none.
   subroutine find_crack(grid, tip, direction, material_place, crack, failure)
      type(grid_t), intent(in) :: grid
      real(dp), intent(in) :: tip(ndim)          !! [m]
      real(dp), intent(in) :: direction(ndim)    !! unit vector along a grid line, from the crack into the body
      real(dp), intent(in) :: material_place(ndim) !! some place in the body, to know its side of the plane [m]
      type(crack_t), intent(out) :: crack
      type(failure_t), intent(inout) :: failure
      crack%node_tip = grid%node_at(tip)
      if (crack%node_tip > 0) crack%step = grid%smallest_leaf_at(crack%node_tip)
      crack%normal = minloc(abs(direction), dim=1)
      crack%side = sign(1.0_dp, material_place(crack%normal) - tip(crack%normal))
      crack%node_behind = grid%node_at(tip - crack%step*direction)
      crack%node_ahead = grid%node_at(tip + crack%step*direction)
      if (min(crack%node_behind, crack%node_tip, crack%node_ahead) == 0) call failure%report(exit_input, &
         '&crack tip: must be at a grid node, with a node of the grid one cell behind it and one ahead of it')
   end subroutine find_crack
end module hampm_crack
