!> What a finest step does with the cells and nodes that have their turn (`hampm_fine_region`), all of which stand side by side: in
!> loops over the first of them.
module hampm_fine_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: lanes
   use hampm_element_kernels, only: n_masses, n_moments, apply_mass, apply_stiffness, apply_anisotropic_stiffness
   use hampm_material, only: material_t
   use hampm_particle_kernels, only: take_corners
   implicit none
   private
   public :: place_nodes, force_cells, kick_cells, gather, add_scaled, add_product

   integer, parameter :: stride = lanes*corners  !! among what cells hold, from one component to the next

contains

   !> How far nodes are displaced: from where an interval began, by a constant acceleration in its first half. It is the mean of
   !> those in that half, a0 + (sum now - sum then)/steps. Both are kept for the intervals that begin now.
   pure subroutine place_nodes(n, factor, share, a0, sum_then, sum_now, d_then, d, kept_sum, kept_d)
      integer, intent(in) :: n                          !! components of the nodes
      real(dp), intent(in) :: factor                    !! by which the acceleration displaces [s2]
      real(dp), intent(in) :: share                     !! 1/steps
      real(dp), intent(in) :: a0(n)                     !! where no node is displaced [m/s2]
      real(dp), intent(in) :: sum_then(n), sum_now(n)   !! of what it changes by, over the finest steps [m/s2]
      real(dp), intent(in) :: d_then(n)                 !! [m]
      real(dp), intent(out) :: d(n)                     !! [m]
      real(dp), intent(out) :: kept_sum(n), kept_d(n)
      integer :: k
      !$omp simd
      do k = 1, n
         d(k) = d_then(k) + factor*(a0(k) + share*(sum_now(k) - sum_then(k)))
         kept_d(k) = d(k)
         kept_sum(k) = sum_now(k)
      end do
   end subroutine place_nodes

   !> The change of the forces of cells whose corners are displaced. A block has parts, of one material each.
   pure subroutine force_cells(first, last, first_part, material, materials, moments, inverse_size, nodes, in_row, d, force)
      integer, intent(in) :: first, last                !! blocks
      integer, intent(in) :: first_part(*)              !! by block
      integer, intent(in) :: material(*)                !! by part
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: moments(lanes, n_moments, *) !! by part [m3]
      real(dp), intent(in) :: inverse_size(lanes, *)    !! by block [1/m]
      integer, intent(in) :: nodes(corners, lanes, *)   !! by block
      logical, intent(in) :: in_row(*)                  !! by block
      real(dp), intent(in) :: d(ndim, *)                !! displacement, by point [m]
      real(dp), intent(inout) :: force(lanes, corners, ndim, 0:*) !! by block [N]
      real(dp) :: a(lanes, corners, ndim)
      integer :: b, k
      do b = first, last
         force(:, :, :, b) = 0
         call take_corners(1, inverse_size(1, b), d, nodes(1, 1, b), in_row(b), a)
         do k = first_part(b), first_part(b + 1) - 1
            associate (law => materials(material(k)))
               if (law%isotropic) then
                  call apply_stiffness(law%lambda, law%mu, inverse_size(1, b), a, moments(1, 1, k), force(1, 1, 1, b))
               else
                  call apply_anisotropic_stiffness(law%stiffness, inverse_size(1, b), a, moments(1, 1, k), force(1, 1, 1, b))
               end if
            end associate
         end do
      end do
   end subroutine force_cells

   !> What cells give to the momenta at their corners per time when these are kicked: M a.
   pure subroutine kick_cells(first, last, masses, nodes, in_row, acceleration, momentum)
      integer, intent(in) :: first, last                !! blocks
      real(dp), intent(in) :: masses(lanes, n_masses, *) !! by block [kg]
      integer, intent(in) :: nodes(corners, lanes, *)   !! by block
      logical, intent(in) :: in_row(*)                  !! by block
      real(dp), intent(in) :: acceleration(ndim, *)     !! by point [m/s2]
      real(dp), intent(inout) :: momentum(lanes, corners, ndim, 0:*) !! by block [N]
      real(dp) :: a(lanes, corners, ndim)
      real(dp), parameter :: factor(lanes) = 1
      integer :: b
      do b = first, last
         momentum(:, :, :, b) = 0
         call take_corners(1, factor, acceleration, nodes(1, 1, b), in_row(b), a)
         call apply_mass(a, masses(1, 1, b), momentum(1, 1, 1, b))
      end do
   end subroutine kick_cells

   !> Sum at some points what the cells around them hold, always in the order of the cells.
   pure subroutine gather(first, last, place, held, total)
      integer, intent(in) :: first, last                !! points
      integer, intent(in) :: place(corners, *)          !! where it stands, by point
      real(dp), intent(in) :: held(*)
      real(dp), intent(inout) :: total(ndim, *)         !! by point
      integer :: i
      !GCC$ novector
      do i = first, last
         associate (k1 => place(1, i), k2 => place(2, i), k3 => place(3, i), k4 => place(4, i))
            total(1, i) = ((held(k1) + held(k2)) + held(k3)) + held(k4)
            total(2, i) = ((held(k1 + stride) + held(k2 + stride)) + held(k3 + stride)) + held(k4 + stride)
         end associate
      end do
   end subroutine gather

   !> total <- total + factor x.
   pure subroutine add_scaled(n, factor, x, total)
      integer, intent(in) :: n
      real(dp), intent(in) :: factor, x(n)
      real(dp), intent(inout) :: total(n)
      integer :: k
      !$omp simd
      do k = 1, n
         total(k) = total(k) + factor*x(k)
      end do
   end subroutine add_scaled

   !> total <- total + factor a b.
   pure subroutine add_product(n, factor, a, b, total)
      integer, intent(in) :: n
      real(dp), intent(in) :: factor, a(n), b(n)
      real(dp), intent(inout) :: total(n)
      integer :: k
      !$omp simd
      do k = 1, n
         total(k) = total(k) + factor*(a(k)*b(k))
      end do
   end subroutine add_product
end module hampm_fine_kernels
