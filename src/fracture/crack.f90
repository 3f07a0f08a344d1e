!> A crack along a line of nodes, in the grid: the nodes at and around its tip and at its mouth.
!>
!> Its frame is that of its tip: direction 1 is that of growth, direction 2 is 90 degrees to the left of it. The faces are the one
!> towards direction 2, the upper one, and the one away from it, the lower one. On a symmetry plane there is one face; what is
!> missing is its mirror image.
module hampm_crack
   use hampm_kinds, only: dp, ndim
   use hampm_failure, only: failure_t, exit_input
   use hampm_grid, only: grid_t
   implicit none
   private
   public :: crack_t, crack_line_t, find_crack, upper, lower

   integer, parameter :: upper = 1, lower = 2    !! the faces

   !> Where a crack is.
   type :: crack_line_t
      real(dp) :: tip(ndim) = 0                  !! [m]
      real(dp) :: mouth(ndim) = 0                !! where the opening at the mouth is measured, on the crack or its end [m]
      real(dp) :: axis(ndim, ndim) = 0           !! unit vectors of its frame, along grid lines: axis(:, k) is direction k
      logical :: face(2) = .true.                !! which faces there are: one on a symmetry plane, else both
   contains
      procedure :: is_half
   end type crack_line_t

   !> A crack in a grid. `behind`, `tip` and `ahead` are the nodes (1), (1'), (2) and (3) of Fig. 2 of Tan & Nairn.
   type :: crack_t
      type(crack_line_t) :: line
      integer :: behind(2) = 0                   !! nodes of the faces one cell behind the tip, 0 where there is no face
      integer :: tip = 0                         !! node at the tip
      integer :: ahead = 0                       !! node one cell ahead of it
      integer :: mouth(2) = 0                    !! nodes of the faces at the mouth, 0 where there is no face
      real(dp) :: step = 0                       !! distance between the nodes around the tip: the smallest cell there [m]
   end type crack_t

contains

   !> Whether the crack is on a symmetry plane, so that there is only half of the body.
   pure logical function is_half(self)
      class(crack_line_t), intent(in) :: self
      is_half = .not. all(self%face)
   end function is_half

   !> Find the nodes of a crack in a grid. Fails where there are none.
   subroutine find_crack(grid, line, crack, failure)
      type(grid_t), intent(in) :: grid
      type(crack_line_t), intent(in) :: line
      type(crack_t), intent(out) :: crack
      type(failure_t), intent(inout) :: failure
      crack%line = line
      crack%tip = grid%node_at(line%tip)
      if (crack%tip > 0) then
         crack%step = grid%smallest_leaf_at(crack%tip)
         crack%behind = face_nodes(grid, line, line%tip - crack%step*line%axis(:, 1))
         crack%ahead = grid%node_at(line%tip + crack%step*line%axis(:, 1))
         crack%mouth = face_nodes(grid, line, line%mouth)
      end if
      if (min(crack%tip, crack%ahead) == 0 .or. any(min(crack%behind, crack%mouth) == 0 .and. line%face)) &
         call failure%report(exit_input, &
         '&crack tip: must be at a grid node, with a node of the grid one cell behind it and one ahead of it')
   end subroutine find_crack

   !> The nodes of the faces at a place; 0 where there is none.
   pure function face_nodes(grid, line, x) result(nodes)
      type(grid_t), intent(in) :: grid
      type(crack_line_t), intent(in) :: line
      real(dp), intent(in) :: x(ndim)            !! [m]
      integer :: nodes(2)
      nodes = 0
      if (line%face(upper)) nodes(upper) = grid%node_at(x, line%axis(:, 2))
      if (line%face(lower)) nodes(lower) = grid%node_at(x, -line%axis(:, 2))
   end function face_nodes
end module hampm_crack
