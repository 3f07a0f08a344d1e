!> The change of volume of material as the mean over a cell, for laws that ask for it in plane strain. Where material hardly
!> changes its volume, as in plastic flow, a bilinear cell with 2 by 2 particles has as many constraints as displacements, and no
!> limit load (Nagtegaal, Parks & Rice, Comput. Meth. Appl. Mech. Engng 4 (1974) 153-177). With one dilatation a cell it can flow.
!>
!> The strain of the particles p of a cell, and the stress that acts on the nodes, are
!>
!>    H_p + (mean tr(H) - tr(H_p))/2 I,    stress_p + (mean pi - pi_p) I,    pi = (stress_11 + stress_22)/2,
!>
!> with means over the volume: the second belongs to the first by the work of the stress.
!>
!> Source: Hughes, Int. J. Numer. Meth. Engng 15 (1980) 1413-1418 (B-bar), in the plane.
module hampm_mean_dilatation
   use hampm_kinds, only: dp, ndim
   use hampm_cell_blocks, only: cell_blocks_t, lanes
   use hampm_material, only: material_t
   use hampm_remembering, only: remember
   use hampm_particles, only: particles_t
   use hampm_tensors, only: identity, trace
   implicit none
   private
   public :: n_pressures, share_dilatation, add_pressures, share_pressures

   integer, parameter :: n_pressures = 6         !! sums of V, V pi, V xi (2) and V xi pi (2)

contains

   !> Give the particles of cells, which have been strained in a step `dt`, the mean dilatation of their cell, and keep their states
   !> where that is due.
   pure subroutine share_dilatation(materials, p, blocks, listed, keeps_history, dt)
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      type(cell_blocks_t), intent(in) :: blocks
      integer, intent(in) :: listed(:)           !! blocks
      logical, intent(in) :: keeps_history
      real(dp), intent(in) :: dt                 !! [s]
      integer :: k, l, i
      do k = 1, size(listed)
         do l = 1, count(blocks%cells(:, listed(k)) > 0)
            associate (e => blocks%cells(l, listed(k)))
               call share_in_cell(materials, p, blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e))
               if (.not. keeps_history) cycle
               do i = blocks%first_in(e), blocks%last_in(e), blocks%stride_in(e)
                  call remember(materials(p%material(i)), dt, p, i)
               end do
            end associate
         end do
      end do
   end subroutine share_dilatation

   !> Share the dilatation of the particles of a cell whose laws ask for it.
   pure subroutine share_in_cell(materials, p, first, last, stride)
      type(material_t), intent(in) :: materials(:)
      type(particles_t), intent(inout) :: p
      integer, intent(in) :: first, last, stride
      real(dp) :: volume, dilatation
      integer :: i
      volume = 0
      dilatation = 0
      do i = first, last, stride
         if (.not. materials(p%material(i))%mean_dilatation) cycle
         volume = volume + p%volume(i)
         dilatation = dilatation + p%volume(i)*trace(p%gradient_of(i))
      end do
      do i = first, last, stride
         if (.not. materials(p%material(i))%mean_dilatation) cycle
         p%gradient(i, :, :) = p%gradient(i, :, :) + (dilatation/volume - trace(p%gradient_of(i)))/2*identity
      end do
   end subroutine share_in_cell

   !> Add to the sums over cells that `share_pressures` needs.
   pure subroutine add_pressures(n, rows, ld, materials, material, volume, xi, t, pressures)
      integer, intent(in) :: n, rows, ld, material(ld)
      type(material_t), intent(in) :: materials(:)
      real(dp), intent(in) :: volume(ld), xi(ld, ndim)
      real(dp), intent(in) :: t(lanes, ndim*ndim, rows, n) !! volume times stress: 11, 21, 12, 22
      real(dp), intent(inout) :: pressures(lanes, n_pressures, n)
      real(dp) :: pi
      integer :: b, s, l, k
      do b = 1, n
         do s = 1, rows
            do l = 1, lanes
               k = lanes*(rows*(b - 1) + s - 1) + l
               if (.not. materials(material(k))%mean_dilatation) cycle
               pi = (t(l, 1, s, b) + t(l, 4, s, b))/2
               pressures(l, :, b) = pressures(l, :, b) + [volume(k), pi, volume(k)*xi(k, :), pi*xi(k, :)]
            end do
         end do
      end do
   end subroutine add_pressures

   !> Share the pressures in the sums from which the internal forces follow (`add_stress` of `hampm_particle_kernels`).
   pure subroutine share_pressures(n, pressures, moment)
      integer, intent(in) :: n
      real(dp), intent(in) :: pressures(lanes, n_pressures, n)
      real(dp), intent(inout) :: moment(lanes, ndim*ndim, n)
      real(dp) :: mean
      integer :: b, l
      do b = 1, n
         do l = 1, lanes
            if (.not. pressures(l, 1, b) > 0) cycle
            mean = pressures(l, 2, b)/pressures(l, 1, b)
            moment(l, 1, b) = moment(l, 1, b) + mean*pressures(l, 4, b) - pressures(l, 6, b)
            moment(l, 4, b) = moment(l, 4, b) + mean*pressures(l, 3, b) - pressures(l, 5, b)
         end do
      end do
   end subroutine share_pressures
end module hampm_mean_dilatation
