!> How the bodies of a model hang together before anything moves. On a grid material knows other material by the nodes that both
!> have: bodies that touch are joined, and bodies that do not touch, but have cells at a common node, act on each other all the
!> same.
module hampm_joints
   use hampm_kinds, only: dp, ndim
   use hampm_body_group, only: body_t
   use hampm_disjoint_sets, only: disjoint_sets_t, singletons
   use hampm_nearby, only: nearby_t
   use hampm_placement, only: tolerance
   use hampm_model, only: model_t
   implicit none
   private
   public :: near_pairs, do_touch, share_nodes, groups_of_bodies, velocity_fields_of, holds_material

contains

   !> The pairs of bodies with less than three cells between the boxes around them, (2, pairs): the numbers i of a body and j < i,
   !> in the order of i and then of j. No others touch or share nodes.
   pure function near_pairs(model) result(pairs)
      type(model_t), intent(in) :: model
      integer, allocatable :: pairs(:, :)
      type(nearby_t) :: table
      real(dp) :: middle(ndim, size(model%bodies)), reach(size(model%bodies)) ! [m]
      integer, allocatable :: found(:), more(:, :)
      integer :: i, k, n
      allocate (pairs(2, 4*size(reach)))
      n = 0
      do i = 1, size(reach)
         associate (body => model%bodies(i))
            middle(:, i) = (body%lower + body%upper)/2
            reach(i) = maxval(body%upper - body%lower) + 4*model%grid%cell
         end associate
      end do
      if (size(reach) > 1) call table%sort(middle, reach)
      do i = 2, size(reach)
         call table%find(middle(:, i), reach(i), found)
         do k = 1, size(found)
            if (found(k) >= i) exit
            if (are_apart(model, i, found(k))) cycle
            if (n == size(pairs, 2)) then
               allocate (more(2, 2*n))
               more(:, :n) = pairs
               call move_alloc(more, pairs)
            end if
            n = n + 1
            pairs(:, n) = [i, found(k)]
         end do
      end do
      pairs = pairs(:, :n)
   end function near_pairs

   !> Whether two bodies of a model have a common point.
   pure logical function do_touch(model, i, j)
      type(model_t), intent(in) :: model
      integer, intent(in) :: i, j                !! numbers of the bodies
      do_touch = .not. are_apart(model, i, j)
      if (do_touch) do_touch = model%bodies(i)%gap_to(model%bodies(j)) <= tolerance(model%grid)
   end function do_touch

   !> Whether cells of the lattice that two bodies reach into have a common node.
   pure logical function share_nodes(model, i, j)
      type(model_t), intent(in) :: model
      integer, intent(in) :: i, j                !! numbers of the bodies
      share_nodes = .not. are_apart(model, i, j)
      if (share_nodes) share_nodes = all(first_node(model, model%bodies(i)) <= last_node(model, model%bodies(j)) .and. &
                                         first_node(model, model%bodies(j)) <= last_node(model, model%bodies(i)))
   end function share_nodes

   !> Whether three cells or more are between the boxes around two bodies: most pairs are told apart by this alone.
   pure logical function are_apart(model, i, j)
      type(model_t), intent(in) :: model
      integer, intent(in) :: i, j                !! numbers of the bodies
      associate (a => model%bodies(i), b => model%bodies(j), way => 3*model%grid%cell)
         are_apart = any(a%lower > b%upper + way .or. b%lower > a%upper + way)
      end associate
   end function are_apart

   !> Whether a box holds a node, of the lattice, of a cell that any body reaches into.
   pure logical function holds_material(model, lower, upper)
      type(model_t), intent(in) :: model
      real(dp), intent(in) :: lower(ndim), upper(ndim)  !! corners of the box [m]
      real(dp), dimension(ndim) :: first, last   ! nodes of the box, from the lower corner of the lattice [cells]
      real(dp), dimension(ndim) :: from, to      ! nodes of it at the cells around a body
      integer :: i
      associate (grid => model%grid, tol => tolerance(model%grid))
         first = (lower - tol - grid%lower)/grid%cell
         last = (upper + tol - grid%lower)/grid%cell
      end associate
      holds_material = .false.
      do i = 1, size(model%bodies)
         associate (body => model%bodies(i))
            associate (parts => max(1, model%grid%order)) ! quadratic cells have nodes in the middle of their sides
               from = first_whole(parts*max(first, first_node(model, body)))/parts
               to = aint(parts*min(last, last_node(model, body)))/parts
            end associate
            if (any(from > to)) cycle
            holds_material = holds_material .or. .not. body%outline%is_there()
            if (.not. holds_material) holds_material = body%area_in(model%grid%lower + (from - 1)*model%grid%cell, &
                                                                    model%grid%lower + (to + 1)*model%grid%cell) > 0
         end associate
      end do
   end function holds_material

   !> Lower corner of the cells that a body reaches into, from the lower corner of the lattice [cells].
   pure function first_node(model, body) result(node)
      type(model_t), intent(in) :: model
      type(body_t), intent(in) :: body
      real(dp) :: node(ndim)
      node = aint((body%lower - model%grid%lower + tolerance(model%grid))/model%grid%cell)
   end function first_node

   !> Their upper corner.
   pure function last_node(model, body) result(node)
      type(model_t), intent(in) :: model
      type(body_t), intent(in) :: body
      real(dp) :: node(ndim)
      node = first_whole((body%upper - model%grid%lower - tolerance(model%grid))/model%grid%cell)
   end function last_node

   !> The least whole number not below a number, which may be too large for an integer.
   elemental real(dp) function first_whole(x)
      real(dp), intent(in) :: x
      first_whole = aint(x)
      if (first_whole < x) first_whole = first_whole + 1
   end function first_whole

   !> For each body the first one that it is joined to, by itself or through others that touch.
   pure function groups_of_bodies(model) result(first)
      type(model_t), intent(in) :: model
      integer :: first(size(model%bodies))
      type(disjoint_sets_t) :: sets
      integer, allocatable :: pairs(:, :)
      integer :: i
      call singletons(size(first), sets)
      pairs = near_pairs(model)
      do i = 1, size(pairs, 2)
         if (do_touch(model, pairs(1, i), pairs(2, i))) call sets%join(pairs(1, i), pairs(2, i))
      end do
      first = [(sets%least_of(i), i=1, size(first))]
   end function groups_of_bodies

   !> Velocity field of each body: bodies of one contact group, or all bodies without contact, share one.
   pure function velocity_fields_of(model) result(velocity_field)
      type(model_t), intent(in) :: model
      integer :: velocity_field(size(model%bodies))
      integer :: i, j
      velocity_field = 1
      if (.not. model%contact%is_wanted()) return
      do i = 1, size(velocity_field)
         velocity_field(i) = maxval([0, velocity_field(:i - 1)]) + 1
         if (model%bodies(i)%contact_group == '') cycle
         do j = 1, i - 1
            if (model%bodies(j)%contact_group == model%bodies(i)%contact_group) velocity_field(i) = velocity_field(j)
         end do
      end do
   end function velocity_fields_of
end module hampm_joints
