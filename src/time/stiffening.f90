!> Ratio of wave speeds in the cells of finite-strain material to unstrained material: compressed rubber is stiffer, and its time
!> step shorter.
!>
!> In the direction N of the grid rho_0 c**2 are the eigenvalues of the acoustic tensor Q_ik = A_iJkL N_J N_L, A = dP/dF (Ogden
!> 1997, section 6.4). For material that moves through the cells N is a direction in space, F^T n in the reference.
module hampm_stiffening
   use hampm_kinds, only: dp, ndim
   use hampm_element_stiffness, only: change_of_stress
   use hampm_energy, only: determinant_of, stretches_of
   use hampm_law, only: most_columns
   use hampm_material, only: material_t
   use hampm_particles, only: particles_t
   use hampm_tensors, only: norm, n_voigt
   implicit none
   private
   public :: stiffening_of

contains

   !> Largest wave speed over the unstrained one, among the particles of each finite-strain law with the largest compression,
   !> stretch and least volume; 1 where none is faster [-].
   pure real(dp) function stiffening_of(p, materials) result(stiffening)
      type(particles_t), intent(in) :: p
      type(material_t), intent(in) :: materials(:)
      integer, parameter :: kinds = 3
      integer :: worst(kinds, size(materials)), i, k, n
      real(dp) :: value(kinds, size(materials)), now(kinds), zero(ndim, ndim), none(most_columns), of_volume, unstrained
      stiffening = 1
      worst = 0
      value = -huge(value)
      do i = 1, p%n
         if (.not. materials(p%material(i))%is_finite) cycle
         of_volume = determinant_of(p, i)
         if (.not. of_volume > 0) cycle          ! a run-time check tells
         now = [stretches_of(p, i), 1/of_volume]
         now(1) = 1/now(1)
         associate (m => p%material(i))
            where (now > value(:, m))
               worst(:, m) = i
               value(:, m) = now
            end where
         end associate
      end do
      zero = 0
      none = 0
      do n = 1, size(materials)
         if (.not. any(worst(:, n) > 0)) cycle
         unstrained = stiffest(materials(n), zero, none, 0.0_dp, p%total_frame)
         do k = 1, kinds
            if (worst(k, n) == 0) cycle
            associate (i => worst(k, n))
               stiffening = max(stiffening, sqrt(stiffest(materials(n), p%gradient_of(i), p%history_of(i), p%hoop_of(i), &
                                                          p%total_frame)/unstrained))
            end associate
         end do
      end do
   end function stiffening_of

   !> The largest norm of the acoustic tensor in the directions of the axes of the grid and between them [Pa].
   pure real(dp) function stiffest(material, h, history, hoop, total_frame)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: history(:)         !! state variables
      real(dp), intent(in) :: hoop               !! H_33 [-]
      logical, intent(in) :: total_frame         !! whether the grid is in the reference configuration
      real(dp) :: direction(ndim), gradient(ndim, ndim), q(ndim, ndim), axes(n_voigt, ndim)
      integer :: a, b, d, k
      axes = 0
      k = ndim
      do b = 1, ndim
         axes(b, b) = 1
      end do
      do b = 2, ndim
         do a = 1, b - 1
            k = k + 1
            axes(k, [a, b]) = sqrt(0.5_dp)
         end do
      end do
      stiffest = 0
      do k = 1, n_voigt
         direction = axes(k, :)
         if (.not. total_frame) direction = direction + matmul(direction, h)
         do d = 1, ndim
            gradient = 0
            gradient(d, :) = direction
            q(:, d) = matmul(change_of_stress(material, h, gradient, history, hoop), direction)
         end do
         stiffest = max(stiffest, norm(q))
      end do
   end function stiffest
end module hampm_stiffening
