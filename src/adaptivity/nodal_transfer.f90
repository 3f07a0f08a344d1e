!> What nodes keep from step to step, carried to another mesh: the field that it was on the old one, at the places of the new nodes. Where cells
!> get finer it is exactly the same field.
module hampm_nodal_transfer
   use hampm_kinds, only: dp, ndim
   use hampm_grid, only: grid_t
   use hampm_motion, only: motion_t
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
      type(motion_t), intent(in) :: m
      type(old_mesh_t), allocatable, intent(out) :: old
      if (.not. (allocated(m%nodal_displacement) .or. allocated(m%nodal_velocity))) return
      allocate (old)
      old%grid = m%grid
      old%cell = m%particles%cell(:m%particles%n)
   end subroutine leave_mesh

   !> Carry what nodes keep to the present mesh, into which the particles have just been sorted.
   subroutine carry_nodes(old, m)
      type(old_mesh_t), intent(inout) :: old
      type(motion_t), intent(inout) :: m
      old%cell(m%sorting%new_place(:size(old%cell))) = old%cell
      if (allocated(m%nodal_displacement)) call carry_field(old, m, m%nodal_displacement)
      if (allocated(m%nodal_velocity)) call carry_field(old, m, m%nodal_velocity)
      if (allocated(m%nodal_acceleration)) call carry_field(old, m, m%nodal_acceleration)
   end subroutine carry_nodes

   !> Carry a nodal field. A node has, of each element around it, the value of the old element in which its particle next to the node was (or of several,
   !> which are equally near, the mean), so that both faces of a crack have their own; and the mean of these.
   subroutine carry_field(old, m, field)
      type(old_mesh_t), intent(in) :: old
      type(motion_t), intent(in) :: m
      real(dp), allocatable, intent(inout) :: field(:, :) !! (ndim, n_points)
      real(dp), parameter :: alike = 1e-9_dp     ! part of a distance by which others are as near
      real(dp) :: carried(ndim, m%grid%n_points), value(ndim)
      real(dp), allocatable :: distance(:)       ! of the particles of an element from a node [m]
      integer :: times(m%grid%n_points), k, c, i
      logical, allocatable :: is_nearest(:)
      carried = 0
      times = 0
      do k = 1, m%blocks%n_occupied
         associate (e => m%blocks%occupied(k), at => m%grid%support_of(m%blocks%occupied(k)))
            associate (list => [(i, i=m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e))])
               if (size(list) == 0) cycle        ! a quarter of a quadratic cell without particles, whose nodes those of the others have
               do c = 1, size(at)
                  associate (place => m%grid%node_position(:, at(c)))
                     distance = [(norm2(m%particles%place_in_grid(list(i)) - place), i=1, size(list))]
                     is_nearest = distance <= minval(distance)*(1 + alike)
                     value = 0
                     do i = 1, size(list)
                        if (is_nearest(i)) value = value + value_at(old%cell(list(i)), place)
                     end do
                     carried(:, at(c)) = carried(:, at(c)) + value/count(is_nearest)
                  end associate
                  times(at(c)) = times(at(c)) + 1
               end do
            end associate
         end associate
      end do
      do k = 1, size(times)
         if (times(k) > 1) carried(:, k) = carried(:, k)/times(k)
      end do
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, carried)
      field = carried
   contains
      !> The field in an old element, at a place or where that is nearest to it.
      pure function value_at(e, place) result(value)
         integer, intent(in) :: e
         real(dp), intent(in) :: place(:)        !! [m]
         real(dp) :: value(ndim)
         value = matmul(field(:, old%grid%support_of(e)), &
                        old%grid%functions_in(e, min(1.0_dp, max(0.0_dp, old%grid%local_coordinate(e, place)))))
      end function value_at
   end subroutine carry_field
end module hampm_nodal_transfer
