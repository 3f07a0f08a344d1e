!> How the bodies of a scene hang together before anything moves. On a grid material knows other material by the nodes that both
!> have: bodies that touch are joined, and bodies that do not touch, but have cells at a common node, act on each other all the
!> same.
module hampm_joints
   use hampm_kinds, only: dp, ndim
   use hampm_body_group, only: body_t, area_in_box, outline_of
   use hampm_outline, only: outline_t
   use hampm_placement, only: tolerance
   use hampm_scene, only: scene_t
   implicit none
   private
   public :: do_touch, share_nodes, gap_between, groups_of_bodies, sheets_of_bodies, holds_material

contains

   !> Whether two bodies of a scene have a common point.
   pure logical function do_touch(scene, i, j)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: i, j                !! which bodies
      do_touch = gap_between(scene, i, j) <= tolerance(scene%grid)
   end function do_touch

   !> Distance between two bodies of a scene [m].
   pure real(dp) function gap_between(scene, i, j) result(gap)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: i, j                !! which bodies
      associate (a => scene%bodies(i), b => scene%bodies(j))
         gap = norm2(max(a%lower - b%upper, b%lower - a%upper, 0.0_dp))
         if (a%outline%is_there() .or. b%outline%is_there()) gap = max(gap, gap_of_outlines(outline_of(a), outline_of(b)))
      end associate
   end function gap_between

   !> Distance between the lines of two outlines [m].
   pure real(dp) function gap_of_outlines(a, b) result(gap)
      type(outline_t), intent(in) :: a, b
      integer :: i, j, k
      gap = huge(gap)
      do i = 1, size(a%rings)
         do j = 1, size(b%rings)
            associate (p => a%rings(i), q => b%rings(j))
               if (p%is_circle) then
                  gap = min(gap, abs(q%distance(p%center) - p%radius))
               else if (q%is_circle) then
                  gap = min(gap, abs(p%distance(q%center) - q%radius))
               else
                  gap = min(gap, minval([(q%distance(p%points(:, k)), k=1, size(p%points, 2))]), &
                            minval([(p%distance(q%points(:, k)), k=1, size(q%points, 2))]))
               end if
            end associate
         end do
      end do
   end function gap_of_outlines

   !> Whether cells of the lattice that two bodies reach into have a common node.
   pure logical function share_nodes(scene, i, j)
      type(scene_t), intent(in) :: scene
      integer, intent(in) :: i, j                !! which bodies
      share_nodes = all(first_node(scene, scene%bodies(i)) <= last_node(scene, scene%bodies(j)) .and. &
                        first_node(scene, scene%bodies(j)) <= last_node(scene, scene%bodies(i)))
   end function share_nodes

   !> Whether a box holds a node, of the lattice, of a cell that any body reaches into.
   pure logical function holds_material(scene, lower, upper)
      type(scene_t), intent(in) :: scene
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the box [m]
      real(dp), dimension(ndim) :: first, last   ! nodes of the box, from the lower corner of the lattice [cells]
      real(dp), dimension(ndim) :: from, to      ! those of them at the cells around a body
      integer :: i
      associate (grid => scene%grid, tol => tolerance(scene%grid))
         first = (lower - tol - grid%lower)/grid%cell
         last = (upper + tol - grid%lower)/grid%cell
      end associate
      holds_material = .false.
      do i = 1, size(scene%bodies)
         associate (body => scene%bodies(i))
            from = first_whole(max(first, first_node(scene, body)))
            to = aint(min(last, last_node(scene, body)))
            if (any(from > to)) cycle
            holds_material = holds_material .or. .not. body%outline%is_there()
            if (.not. holds_material) holds_material = area_in_box(body, scene%grid%lower + (from - 1)*scene%grid%cell, &
                                                                   scene%grid%lower + (to + 1)*scene%grid%cell) > 0
         end associate
      end do
   end function holds_material

   !> Lower corner of the cells that a body reaches into, from the lower corner of the lattice [cells].
   pure function first_node(scene, body) result(node)
      type(scene_t), intent(in) :: scene
      type(body_t), intent(in) :: body
      real(dp) :: node(ndim)
      node = aint((body%lower - scene%grid%lower + tolerance(scene%grid))/scene%grid%cell)
   end function first_node

   !> Their upper corner.
   pure function last_node(scene, body) result(node)
      type(scene_t), intent(in) :: scene
      type(body_t), intent(in) :: body
      real(dp) :: node(ndim)
      node = first_whole((body%upper - scene%grid%lower - tolerance(scene%grid))/scene%grid%cell)
   end function last_node

   !> The first whole number that is not below a number, which may be too large for an integer.
   elemental real(dp) function first_whole(x)
      real(dp), intent(in) :: x
      first_whole = aint(x)
      if (first_whole < x) first_whole = first_whole + 1
   end function first_whole

   !> For each body the first one that it is joined to, by itself or through others that touch.
   pure function groups_of_bodies(scene) result(first)
      type(scene_t), intent(in) :: scene
      integer :: first(size(scene%bodies))
      integer :: i, j
      do i = 1, size(first)
         first(i) = i
         do j = 1, i - 1
            if (.not. do_touch(scene, i, j)) cycle
            where (first(:i) == max(first(i), first(j))) first(:i) = min(first(i), first(j))
         end do
      end do
   end function groups_of_bodies

   !> The sheet of the grid, that is the velocity field, on which each body is: those of one part, or all without contact between
   !> bodies, are on the same.
   pure function sheets_of_bodies(scene) result(sheet)
      type(scene_t), intent(in) :: scene
      integer :: sheet(size(scene%bodies))
      integer :: i, j
      sheet = 1
      if (.not. scene%contact%is_wanted()) return
      do i = 1, size(sheet)
         sheet(i) = maxval([0, sheet(:i - 1)]) + 1
         if (scene%bodies(i)%part == '') cycle
         do j = 1, i - 1
            if (scene%bodies(j)%part == scene%bodies(i)%part) sheet(i) = sheet(j)
         end do
      end do
   end function sheets_of_bodies
end module hampm_joints
