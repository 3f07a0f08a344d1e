!> The refinement parameter R of Tan & Nairn, (20)-(23): how far the mean of a field around a node is from its value there.
module hampm_gradient_indicator
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions
   use hampm_cell_values, only: is_occupied
   use hampm_extrapolation, only: extrapolate_lumped
   use hampm_forest, only: outside
   use hampm_motion, only: motion_t, refresh_grid
   use hampm_recovery, only: recover
   implicit none
   private
   public :: nodal_field, refinement_parameter

contains

   !> A field at the points of the grid. 'energy_density' [J/m3] is the paper's and extrapolated as there, by the lumped mass
   !> matrix; 'stress_norm' [Pa] and 'speed' [m/s] are recovered by patches, which sees no kinks at edges of bodies and of cells.
   subroutine nodal_field(m, name, phi)
      type(motion_t), intent(inout) :: m
      character(*), intent(in) :: name
      real(dp), allocatable, intent(out) :: phi(:)  !! (n_points)
      real(dp), allocatable :: value(:)
      real(dp) :: h(ndim, ndim)
      logical :: is_energy, is_stress
      integer :: i
      is_energy = name == 'energy_density'
      is_stress = name == 'stress_norm'
      allocate (value(m%particles%n), phi(m%grid%n_points))
      do i = 1, m%particles%n
         h = m%particles%gradient_of(i)
         associate (material => m%materials(m%particles%material(i)))
            if (is_energy) then
               value(i) = material%energy_density(h, m%particles%history_of(i))
            else if (is_stress) then
               value(i) = norm2(material%kirchhoff_stress(h, m%particles%history_of(i)))
            else
               value(i) = norm2(m%particles%velocity(i, :))
            end if
         end associate
      end do
      call refresh_grid(m)
      if (is_energy) then
         call extrapolate_lumped(m%grid, m%particles, m%fields%mass_matrix, 1, value, phi)
      else
         call recover(m%grid, m%particles, m%blocks, m%fields%mass_matrix, 1, value, phi)
      end if
   end subroutine nodal_field

   !> R of each active node (23), 0 where the field is: the mean of phi at the distance of the smallest cell at the node to both
   !> sides in every direction, over phi at the node, less 1. Where no node stands there phi is interpolated. Beyond the edge of
   !> the body or a cut it is mirrored, which is exact on a symmetry plane. At other edges the energy density, which the lumped
   !> matrix has made flat there, is mirrored too; other fields go on linearly.
   subroutine refinement_parameter(m, name, phi, r)
      type(motion_t), intent(in) :: m
      character(*), intent(in) :: name           !! of the field
      real(dp), intent(in) :: phi(:)             !! nodal field, (n_points)
      real(dp), allocatable, intent(out) :: r(:) !! [-], (n_points)
      real(dp) :: mean
      logical :: is_energy
      integer :: a, d
      is_energy = name == 'energy_density'
      allocate (r(m%grid%n_points), source=0.0_dp)
      associate (all => m%fields%mass_matrix%all)
         do a = 1, all%n_nodes
            associate (node => all%nodes(a))
               if (.not. phi(node) > 0) cycle
               mean = 0
               do d = 1, ndim
                  mean = mean + mean_beside(m, is_energy .or. m%constraints%fixed(d, node), phi, node, d)/ndim
               end do
               r(node) = abs(mean/phi(node) - 1)
            end associate
         end do
      end associate
   end subroutine refinement_parameter

   !> Mean of phi on both sides of a node in direction `d`.
   real(dp) function mean_beside(m, mirrored, phi, node, d) result(mean)
      type(motion_t), intent(in) :: m
      logical, intent(in) :: mirrored            !! at an edge of the body; else linear
      real(dp), intent(in) :: phi(:)
      integer, intent(in) :: node, d
      real(dp) :: step(ndim), value(2), distance
      logical :: inside(2)
      integer :: side
      distance = m%grid%smallest_leaf_at(node)
      value = 0
      do side = 1, 2
         step = 0
         step(d) = (2*side - 3)*distance
         inside(side) = m%grid%has_element_toward(node, step)
         if (inside(side)) call value_at(m, phi, m%grid%node_position(:, node) + step, value(side), inside(side))
      end do
      if (all(inside)) then
         mean = sum(value)/2
      else if (any(inside) .and. mirrored) then
         mean = merge(value(1), value(2), inside(1))
      else
         mean = phi(node)
      end if
   end function mean_beside

   !> Value of a nodal field at a place, and whether the place is in or at the edge of an occupied cell.
   subroutine value_at(m, phi, x, value, inside)
      type(motion_t), intent(in) :: m
      real(dp), intent(in) :: phi(:)
      real(dp), intent(in) :: x(ndim)
      real(dp), intent(out) :: value
      logical, intent(out) :: inside
      real(dp) :: probe(ndim), shape(corners)
      integer :: k, d, e, c
      value = 0
      do k = 0, corners - 1                      ! a place on the edge between cells is in any of them
         do d = 1, ndim
            probe(d) = x(d) + (2*ibits(k, d - 1, 1) - 1)*1.0e-3_dp*m%grid%finest_cell
         end do
         e = m%grid%element_at(probe)
         inside = e /= outside
         if (inside) inside = is_occupied(m%grid, m%blocks, m%grid%element_leaf(e))
         if (.not. inside) cycle
         shape = shape_functions(m%grid%local_coordinate(e, x))
         do c = 1, corners
            value = value + shape(c)*phi(m%grid%element_nodes(c, e))
         end do
         return
      end do
   end subroutine value_at
end module hampm_gradient_indicator
