!> The element operators of the cells of a block, side by side in `lanes` as in `hampm_particle_kernels`: how the contributions of a
!> cell to momentum and internal force change with the motion of its corners. And what the nodes sum up. See
!> `hampm_element_operators`.
module hampm_element_kernels
   use hampm_kinds, only: dp, ndim, corners
   use hampm_cell_blocks, only: lanes, of_momentum, of_force, n_sums
   use hampm_material, only: material_t
   use hampm_particle_kernels, only: take_corners, divergence
   use hampm_pass, only: pass_t
   implicit none
   private
   public :: n_masses, n_moments, apply_operators, apply_mass, isotropic_stress, anisotropic_stress, add_divergence, add_to_sum

   integer, parameter :: n_masses = corners*(corners + 1)/2   !! of a symmetric mass matrix: 11 21 31 41 22 32 42 33 43 44
   integer, parameter :: n_moments = 6           !! of the volume: 1, xi, eta, xi**2, xi eta, eta**2

contains

   !> Add to the contributions of those of some blocks that have operators what a pass does: its kick and its strain in one loop,
   !> over arrays whose addresses stay.
   pure subroutine apply_operators(listed, material, pass, dt, acceleration, velocity, materials, nodes, in_row, inverse_size, &
                                   integrals, contribution)
      integer, intent(in) :: listed(:)                  !! blocks, and by block:
      integer, intent(in) :: material(*)                !! 0: none, it has no operator
      integer, intent(in) :: nodes(corners, lanes, *)
      logical, intent(in) :: in_row(*)
      real(dp), intent(in) :: inverse_size(lanes, *), integrals(lanes, n_masses + n_moments, *)
      real(dp), intent(inout) :: contribution(lanes, corners, n_sums, *)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                        !! [s]
      real(dp), intent(in) :: acceleration(ndim, *), velocity(ndim, *)   !! at the points: that kicks, and that strains
      type(material_t), intent(in) :: materials(:)
      real(dp) :: factor(lanes), a(lanes, corners, ndim), total(lanes, ndim*ndim), moment(lanes, ndim*ndim)
      integer :: j, b
      do j = 1, size(listed)
         b = listed(j)
         if (material(b) == 0) cycle
         if (pass%kick) then
            factor = dt
            call take_corners(1, factor, acceleration, nodes(1, 1, b), in_row(b), a)
            call apply_mass(a, integrals(1, 1, b), contribution(1, 1, of_momentum, b))
         end if
         if (pass%strain_fraction > 0) then
            factor = pass%strain_fraction*dt*inverse_size(:, b)
            call take_corners(1, factor, velocity, nodes(1, 1, b), in_row(b), a)
            associate (law => materials(material(b)))
               if (law%isotropic) then
                  call isotropic_stress(law%lambda, law%mu, a, integrals(1, n_masses + 1, b), total, moment)
                  call add_divergence(inverse_size(1, b), total, moment, contribution(1, 1, of_force, b))
               else
                  call anisotropic_stress(law%stiffness, a, integrals(1, n_masses + 1, b), total, moment)
                  call add_divergence(inverse_size(1, b), total, moment, contribution(1, 1, of_force, b))
               end if
            end associate
         end if
      end do
   end subroutine apply_operators

   !> Add to the momenta what a kick of the particles does, p_i <- p_i + sum_j M_ij dv_j, dv being the polynomials `a` in the cells.
   pure subroutine apply_mass(a, masses, sums)
      real(dp), intent(in) :: a(lanes, corners, ndim), masses(lanes, n_masses)
      real(dp), intent(inout) :: sums(lanes, corners, ndim)
      real(dp) :: v1, v2, v3, v4
      integer :: l, d
      do d = 1, ndim
         !$omp simd private(v1, v2, v3, v4)
         do l = 1, lanes
            v1 = a(l, 1, d)
            v2 = v1 + a(l, 2, d)
            v3 = v1 + a(l, 3, d)
            v4 = v3 + (a(l, 2, d) + a(l, 4, d))
            sums(l, 1, d) = sums(l, 1, d) + (masses(l, 1)*v1 + masses(l, 2)*v2 + (masses(l, 3)*v3 + masses(l, 4)*v4))
            sums(l, 2, d) = sums(l, 2, d) + (masses(l, 2)*v1 + masses(l, 5)*v2 + (masses(l, 6)*v3 + masses(l, 7)*v4))
            sums(l, 3, d) = sums(l, 3, d) + (masses(l, 3)*v1 + masses(l, 6)*v2 + (masses(l, 8)*v3 + masses(l, 9)*v4))
            sums(l, 4, d) = sums(l, 4, d) + (masses(l, 4)*v1 + masses(l, 7)*v2 + (masses(l, 9)*v3 + masses(l, 10)*v4))
         end do
      end do
   end subroutine apply_mass

   !> Sums of V times stress, and of the same times the local coordinate across its direction, of linear elastic particles of one
   !> material, which internal forces (7) are made of (`add_divergence`). L = grad of a field is linear in the local coordinates, so that
   !> these sums need the moments of V only.
   pure subroutine isotropic_stress(lambda, mu, a, moments, total, moment)
      real(dp), intent(in) :: lambda, mu                !! [Pa]
      real(dp), intent(in) :: a(lanes, corners, ndim)   !! the field as by `take_corners`, over the size of the cell
      real(dp), intent(in) :: moments(lanes, n_moments) !! [m3]
      real(dp), intent(out) :: total(lanes, ndim*ndim), moment(lanes, ndim*ndim)
      real(dp) :: l11, l21, l12, l22
      integer :: l
      !$omp simd private(l11, l21, l12, l22)
      do l = 1, lanes
         l11 = a(l, 2, 1)*moments(l, 1) + a(l, 4, 1)*moments(l, 3)
         l21 = a(l, 2, 2)*moments(l, 1) + a(l, 4, 2)*moments(l, 3)
         l12 = a(l, 3, 1)*moments(l, 1) + a(l, 4, 1)*moments(l, 2)
         l22 = a(l, 3, 2)*moments(l, 1) + a(l, 4, 2)*moments(l, 2)
         total(l, 1) = (lambda + 2*mu)*l11 + lambda*l22
         total(l, 2) = mu*(l12 + l21)
         total(l, 3) = total(l, 2)
         total(l, 4) = (lambda + 2*mu)*l22 + lambda*l11
         ! times eta
         l11 = a(l, 2, 1)*moments(l, 3) + a(l, 4, 1)*moments(l, 6)
         l21 = a(l, 2, 2)*moments(l, 3) + a(l, 4, 2)*moments(l, 6)
         l12 = a(l, 3, 1)*moments(l, 3) + a(l, 4, 1)*moments(l, 5)
         l22 = a(l, 3, 2)*moments(l, 3) + a(l, 4, 2)*moments(l, 5)
         moment(l, 1) = (lambda + 2*mu)*l11 + lambda*l22
         moment(l, 2) = mu*(l12 + l21)
         ! times xi
         l11 = a(l, 2, 1)*moments(l, 2) + a(l, 4, 1)*moments(l, 5)
         l21 = a(l, 2, 2)*moments(l, 2) + a(l, 4, 2)*moments(l, 5)
         l12 = a(l, 3, 1)*moments(l, 2) + a(l, 4, 1)*moments(l, 4)
         l22 = a(l, 3, 2)*moments(l, 2) + a(l, 4, 2)*moments(l, 4)
         moment(l, 3) = mu*(l12 + l21)
         moment(l, 4) = (lambda + 2*mu)*l22 + lambda*l11
      end do
   end subroutine isotropic_stress

   !> The same by a stiffness of the columns (11, 22, 12).
   pure subroutine anisotropic_stress(c, a, moments, total, moment)
      real(dp), intent(in) :: c(3, 3)                   !! [Pa]
      real(dp), intent(in) :: a(lanes, corners, ndim)   !! the field as by `take_corners`, over the size of the cell
      real(dp), intent(in) :: moments(lanes, n_moments) !! [m3]
      real(dp), intent(out) :: total(lanes, ndim*ndim), moment(lanes, ndim*ndim)
      integer, parameter :: with(3, 3) = reshape([1, 3, 2, 3, 6, 5, 2, 5, 4], [3, 3]) !! moments of 1, eta, xi with 1, eta and xi
      real(dp) :: stress(lanes, 3, 3)
      real(dp) :: l11, l22, shear
      integer :: l, k
      do k = 1, 3                                       ! times 1, eta and xi
         !$omp simd private(l11, l22, shear)
         do l = 1, lanes
            l11 = a(l, 2, 1)*moments(l, with(1, k)) + a(l, 4, 1)*moments(l, with(2, k))
            l22 = a(l, 3, 2)*moments(l, with(1, k)) + a(l, 4, 2)*moments(l, with(3, k))
            shear = a(l, 2, 2)*moments(l, with(1, k)) + a(l, 4, 2)*moments(l, with(2, k)) &
                    + (a(l, 3, 1)*moments(l, with(1, k)) + a(l, 4, 1)*moments(l, with(3, k)))
            stress(l, 1, k) = c(1, 1)*l11 + c(1, 2)*l22 + c(1, 3)*shear
            stress(l, 2, k) = c(1, 3)*l11 + c(2, 3)*l22 + c(3, 3)*shear
            stress(l, 3, k) = c(1, 2)*l11 + c(2, 2)*l22 + c(2, 3)*shear
         end do
      end do
      total = stress(:, [1, 2, 2, 3], 1)
      moment(:, :2) = stress(:, :2, 2)
      moment(:, 3:) = stress(:, 2:, 3)
   end subroutine anisotropic_stress

   !> Add the internal forces of the sums of V times stress, and of the same times the local coordinate across its direction.
   pure subroutine add_divergence(inverse_size, total, moment, sums)
      real(dp), intent(in) :: inverse_size(lanes)       !! [1/m]
      real(dp), intent(in) :: total(lanes, ndim*ndim), moment(lanes, ndim*ndim)
      real(dp), intent(inout) :: sums(lanes, corners, ndim)
      real(dp) :: change(lanes, corners, n_sums)
      integer :: l, c, d
      call divergence(1, inverse_size, total, moment, change)
      do d = 1, ndim
         do c = 1, corners
            !$omp simd
            do l = 1, lanes
               sums(l, c, d) = sums(l, c, d) + change(l, c, of_force + d - 1)
            end do
         end do
      end do
   end subroutine add_divergence

   !> Add a factor times a nodal field to a sum at some points.
   pure subroutine add_to_sum(factor, n, points, field, total)
      real(dp), intent(in) :: factor
      integer, intent(in) :: n, points(n)
      real(dp), intent(in) :: field(ndim, *)            !! by point
      real(dp), intent(inout) :: total(ndim, *)
      integer :: k
      do k = 1, n
         total(:, points(k)) = total(:, points(k)) + factor*field(:, points(k))
      end do
   end subroutine add_to_sum
end module hampm_element_kernels
