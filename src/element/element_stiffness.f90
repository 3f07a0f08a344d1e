!> The stiffness of an element, integrated at its particles, or at four points if a particle is alone.
!>
!> Of axisymmetric material N_a/R is a third derivative of a shape function (displacements in direction 1 give H_33): displacement
!> gradients and stresses have a third column with H_33 or stress_33 in direction 1.
module hampm_element_stiffness
   use hampm_kinds, only: dp, ndim, corners
   use hampm_forest, only: corner_offset
   use hampm_basis, only: inside_cell, points_of_quadratic
   use hampm_law, only: most_columns
   use hampm_material, only: material_t
   use hampm_matter, only: matter_t
   use hampm_tensors, only: identity
   implicit none
   private
   public :: stiff_points, derivatives_at, n_derivatives, change_of_stress, element_stiffness, mean_gradient_in, strains_by_corners

contains

   !> Stiffness of elements with the same functions, as the quarters of a quadratic cell, by corner, its directions consecutive
   !> [N/m]. Particles of the same moduli, as of a material at small strain, need only the sum of the products of their gradients.
   pure subroutine element_stiffness(m, elements, is_tangent, point, matrix)
      class(matter_t), intent(in) :: m
      integer, intent(in) :: elements(:)         !! of which more than one are quarters, which share no dilatation
      logical, intent(in) :: is_tangent          !! whether of the present state, see `stiffness_kind_t`
      real(dp), intent(in) :: point              !! squared frequency of soft interface points [1/s2]
      real(dp), intent(out) :: matrix(:, :)
      real(dp), allocatable :: gradient(:, :, :)
      real(dp) :: products(n_derivatives(m)*m%grid%n_functions, n_derivatives(m)*m%grid%n_functions)
      integer :: i, k, n, last
      matrix = 0
      if (is_tangent .and. shares_dilatation(m, elements(1))) then
         call tangent_by_means(m, elements(1), matrix)
         return
      end if
      if (is_tangent) allocate (gradient(m%grid%n_functions, n_derivatives(m), 1))
      products = 0
      last = 0
      associate (p => m%particles, b => m%blocks)
         do n = 1, size(elements)
            associate (e => elements(n))
               do i = b%first_in(e), b%last_in(e), b%stride_in(e)
                  if (last > 0) then
                     if (p%material(i) /= p%material(last) .or. is_tangent .and. .not. m%materials(p%material(i))%linear) &
                        call close_products(m, last, is_tangent, products, matrix)
                  end if
                  last = i
                  if (is_tangent) then
                     gradient(:, :, 1) = derivatives_at(m, i)
                  else
                     call stiff_points(m, e, i, gradient)
                  end if
                  do k = 1, size(gradient, 3)
                     call sum_products(p%volume(i)/size(gradient, 3), gradient(:, :, k), products)
                  end do
                  do k = 1, size(matrix, 1)
                     matrix(k, k) = matrix(k, k) + point*p%mass(i)/m%grid%n_functions
                  end do
               end do
            end associate
         end do
      end associate
      if (last > 0) call close_products(m, last, is_tangent, products, matrix)
   end subroutine element_stiffness

   !> Add the products up to a particle, times its moduli, and begin anew.
   pure subroutine close_products(m, i, is_tangent, products, matrix)
      class(matter_t), intent(in) :: m
      integer, intent(in) :: i
      logical, intent(in) :: is_tangent          !! as in `element_stiffness`
      real(dp), intent(inout) :: products(:, :), matrix(:, :)
      real(dp) :: h(ndim, ndim), hoop, old_state(most_columns)
      h = 0
      hoop = 0
      old_state = 0
      associate (p => m%particles)
         if (is_tangent) h = p%gradient_of(i)
         if (is_tangent) hoop = p%hoop_of(i)
         if (is_tangent) old_state = p%history_of(i)
         call add_products(moduli_of(m%materials(p%material(i)), n_derivatives(m), h, old_state, hoop), products, matrix)
      end associate
      products = 0
   end subroutine close_products

   !> Whether particles of an element share their dilatation.
   pure logical function shares_dilatation(m, e) result(shares)
      class(matter_t), intent(in) :: m
      integer, intent(in) :: e
      shares = any(m%materials%mean_dilatation)
      if (shares) shares = any(m%materials(m%particles%material(m%blocks%first_in(e):m%blocks%last_in(e): &
                                                               m%blocks%stride_in(e)))%mean_dilatation)
   end function shares_dilatation

   !> Mean gradients of the shape functions over the particles of an element that share their dilatation [1/m].
   pure function mean_gradient_in(m, e) result(mean)
      class(matter_t), intent(in) :: m
      integer, intent(in) :: e
      real(dp) :: mean(m%grid%n_functions, n_derivatives(m)), volume
      integer :: i
      mean = 0
      volume = 0
      if (.not. shares_dilatation(m, e)) return
      associate (p => m%particles, b => m%blocks)
         do i = b%first_in(e), b%last_in(e), b%stride_in(e)
            if (.not. m%materials(p%material(i))%mean_dilatation) cycle
            mean = mean + p%volume(i)*derivatives_at(m, i)
            volume = volume + p%volume(i)
         end do
      end associate
      mean = mean/volume
   end function mean_gradient_in

   !> Tangent of an element whose particles share their dilatation, as `element_stiffness`: forces by the displacement of each
   !> corner in each direction.
   pure subroutine tangent_by_means(m, e, matrix)
      class(matter_t), intent(in) :: m
      integer, intent(in) :: e
      real(dp), intent(inout) :: matrix(:, :)
      real(dp), dimension(m%grid%n_functions, n_derivatives(m)) :: gradient, mean
      real(dp) :: strain(ndim*n_derivatives(m), size(matrix, 1)), moduli(ndim*n_derivatives(m), ndim*n_derivatives(m))
      integer :: i
      mean = mean_gradient_in(m, e)
      associate (p => m%particles, b => m%blocks)
         do i = b%first_in(e), b%last_in(e), b%stride_in(e)
            associate (material => m%materials(p%material(i)))
               gradient = derivatives_at(m, i)
               moduli = reshape(moduli_of(material, n_derivatives(m), p%gradient_of(i), p%history_of(i), p%hoop_of(i)), &
                                shape(moduli))
               strain = strains_by_corners(gradient, mean, material%mean_dilatation)
               matrix = matrix + p%volume(i)*matmul(transpose(strain), matmul(moduli, strain))
            end associate
         end do
      end associate
   end subroutine tangent_by_means

   !> Displacement gradients at a particle, their components consecutive, by a unit displacement of each corner in each direction
   !> [1/m]; their trace is the mean where it is shared. Transposed it gives the forces on the corners by the stress, per volume.
   pure function strains_by_corners(gradient, mean, shares) result(strain)
      real(dp), intent(in) :: gradient(:, :), mean(:, :) !! [1/m], (corners, derivatives)
      logical, intent(in) :: shares
      real(dp) :: strain(size(gradient, 2)*ndim, ndim*size(gradient, 1)), h(ndim, size(gradient, 2)), missing(ndim)
      integer :: c, i
      do c = 1, size(gradient, 1)
         missing = 0
         if (shares) missing = of_trace(mean(c, :) - gradient(c, :))/ndim
         do i = 1, ndim
            h = 0
            h(i, :) = gradient(c, :)
            h(:, :ndim) = h(:, :ndim) + missing(i)*identity
            strain(:, ndim*(c - 1) + i) = reshape(h, [size(h)])
         end do
      end do
   end function strains_by_corners

   !> Derivative of the trace of H by a displacement in each direction, from the derivatives of a shape function [1/m].
   pure function of_trace(derivatives) result(part)
      real(dp), intent(in) :: derivatives(:)     !! [1/m]
      real(dp) :: part(ndim)
      part = derivatives(:ndim)
      part(1) = part(1) + sum(derivatives(ndim + 1:))
   end function of_trace

   !> Add the products V N_a,k N_b,l of the gradients at a point.
   pure subroutine sum_products(volume, gradient, products)
      real(dp), intent(in) :: volume             !! [m3]
      real(dp), intent(in) :: gradient(:, :)     !! [1/m], (corners, derivatives)
      real(dp), intent(inout) :: products(:, :)  !! by corner, the derivatives of a corner one after the other [m]
      real(dp) :: by_corner(points_of_quadratic*(ndim + 1))
      integer :: k, n
      n = size(gradient, 2)
      do k = 1, size(gradient, 1)
         by_corner(n*(k - 1) + 1:n*k) = gradient(k, :)
      end do
      do k = 1, size(gradient)
         products(:, k) = products(:, k) + (volume*by_corner(k))*by_corner(:size(gradient))
      end do
   end subroutine sum_products

   !> Change of the stress, components first, with the components of the displacement gradient [Pa].
   pure function moduli_of(material, n, h, old_state, hoop) result(moduli)
      type(material_t), intent(in) :: material
      integer, intent(in) :: n                   !! derivatives of a shape function
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), contiguous, intent(in) :: old_state(:) !! state variables of the particle
      real(dp), intent(in) :: hoop               !! H_33 [-]
      real(dp) :: moduli(ndim, n, ndim, n)
      real(dp) :: unit(ndim, n)
      integer :: j, k
      do k = 1, n
         do j = 1, ndim
            unit = 0
            unit(j, k) = 1
            moduli(:, :, j, k) = change_of_stress(material, h, unit, old_state, hoop)
         end do
      end do
   end function moduli_of

   !> Change of the stress by a small change of H [Pa], both with a column of the hoop (no direction 2) if axisymmetric; without
   !> it H_33 stays.
   pure function change_of_stress(material, h, dh, old_state, hoop) result(change)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: h(ndim, ndim)      !! displacement gradient [-]
      real(dp), intent(in) :: dh(:, :)           !! its change [-], (ndim, derivatives)
      real(dp), contiguous, intent(in) :: old_state(:) !! state variables of the particle
      real(dp), intent(in) :: hoop               !! H_33 [-]
      real(dp) :: change(ndim, size(dh, 2)), in_plane(ndim, ndim)
      in_plane = dh(:, :ndim)
      if (size(dh, 2) == ndim) then
         change = material%first_piola_change(h, in_plane, old_state, hoop, 0.0_dp)
      else
         change(:, :ndim) = material%first_piola_change(h, in_plane, old_state, hoop, dh(1, ndim + 1))
         change(:, ndim + 1) = 0
         change(1, ndim + 1) = material%hoop_change(h, in_plane, old_state, hoop, dh(1, ndim + 1))
      end if
   end function change_of_stress

   !> Add the stiffness of material of the same moduli: the force on corner a in direction i by a displacement of corner b in
   !> direction j is the sum over k and l of moduli_ikjl times the one of V N_a,k N_b,l.
   pure subroutine add_products(moduli, products, matrix)
      real(dp), intent(in) :: moduli(:, :, :, :)
      real(dp), intent(in) :: products(:, :)     !! by corner, the derivatives of a corner one after the other [m]
      real(dp), intent(inout) :: matrix(:, :)
      integer :: i, j, k, l, n
      n = size(moduli, 2)
      do j = 1, ndim
         do l = 1, n
            do i = 1, ndim
               do k = 1, n
                  if (.not. abs(moduli(i, k, j, l)) > 0) cycle
                  matrix(i::ndim, j::ndim) = matrix(i::ndim, j::ndim) + moduli(i, k, j, l)*products(k::n, l::n)
               end do
            end do
         end do
      end do
   end subroutine add_products

   !> Derivatives of the shape functions at the integration points of a particle [1/m], (corners, derivatives, points): its
   !> position. A particle alone in its cell does not resist bending; four points near it keep the stiffness from being singular.
   pure subroutine stiff_points(m, e, i, gradient)
      class(matter_t), intent(in) :: m
      integer, intent(in) :: e, i
      real(dp), allocatable, intent(out) :: gradient(:, :, :)
      real(dp), parameter :: near = 0.05_dp      ! in cells: a twenty-fifth of the stiffness of four particles in bending
      integer :: k
      allocate (gradient(m%grid%n_functions, n_derivatives(m), &
                         merge(corners, 1, m%blocks%count_in(e) == 1 .and. .not. m%grid%is_quadratic())))
      gradient(:, :, 1) = derivatives_at(m, i)
      if (size(gradient, 3) == 1) return
      do k = 1, corners
         gradient(:, :ndim, k) = m%grid%gradients_in(e, inside_cell(m%local_of(i) + near*(2*corner_offset(k) - 1)))
         gradient(:, ndim + 1:, k) = gradient(:, ndim + 1:, 1)
      end do
   end subroutine stiff_points

   !> How many derivatives a shape function has: in axisymmetric material N/R is one.
   pure integer function n_derivatives(m)
      class(matter_t), intent(in) :: m
      n_derivatives = merge(ndim + 1, ndim, m%particles%thickness%is_ring)
   end function n_derivatives

   !> The derivatives of the shape functions at a particle [1/m], (corners, derivatives).
   pure function derivatives_at(m, i) result(derivatives)
      class(matter_t), intent(in) :: m
      integer, intent(in) :: i
      real(dp) :: derivatives(m%grid%n_functions, n_derivatives(m))
      derivatives(:, :ndim) = m%gradients_of(i)
      if (n_derivatives(m) > ndim) derivatives(:, ndim + 1) = m%functions_of(i)/m%particles%reference(i, 1)
   end function derivatives_at
end module hampm_element_stiffness
