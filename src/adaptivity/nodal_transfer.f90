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

   !> Carry a nodal field. A node has, of each element around it, the value of the old element in which its particle next to the node was, so
   !> that both faces of a crack have their own; and the mean of these.
   subroutine carry_field(old, m, field)
      type(old_mesh_t), intent(in) :: old
      type(motion_t), intent(in) :: m
      real(dp), allocatable, intent(inout) :: field(:, :) !! (ndim, n_points)
      real(dp) :: carried(ndim, m%grid%n_points)
      integer :: times(m%grid%n_points), k, c, i, nearest
      real(dp) :: least, distance, xi(ndim)
      carried = 0
      times = 0
      do k = 1, m%blocks%n_occupied
         associate (e => m%blocks%occupied(k), at => m%grid%support_of(m%blocks%occupied(k)))
            do c = 1, size(at)
               associate (place => m%grid%node_position(:, at(c)))
                  least = huge(least)
                  do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
                     distance = norm2(m%particles%place_in_grid(i) - place)
                     if (distance < least) nearest = i
                     least = min(distance, least)
                  end do
                  associate (from => old%cell(nearest))
                     xi = min(1.0_dp, max(0.0_dp, old%grid%local_coordinate(from, place)))
                     carried(:, at(c)) = carried(:, at(c)) + matmul(field(:, old%grid%support_of(from)), &
                                                                    old%grid%functions_in(from, xi))
                  end associate
               end associate
               times(at(c)) = times(at(c)) + 1
            end do
         end associate
      end do
      do k = 1, size(times)
         if (times(k) > 1) carried(:, k) = carried(:, k)/times(k)
      end do
      call m%grid%dofs%distribute(m%fields%mass_matrix%all, ndim, carried)
      field = carried
   end subroutine carry_field
end module hampm_nodal_transfer
