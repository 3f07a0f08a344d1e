!> The strain energy that the cells of a mesh lack beside the recovered stress, around a place: what an error expected of G is made of.
module hampm_missing_energy
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: shape_functions, shape_gradients
   use hampm_error_indicator, only: errors_at_particles, energy_of_stress, stress_components
   use hampm_material, only: material_t
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t
   use hampm_recovery, only: recover
   use hampm_element_stiffness, only: stiff_points, derivatives_at, n_derivatives
   implicit none
   private
   public :: missing_energy, displace, gradient_of, stress_of

   integer, parameter :: n_stress = ndim*ndim

   !> How far, in cells, the middle of the material of an element that counts as full may be from that of the element.
   real(dp), parameter :: not_full = 1.0e-3_dp

contains

   !> Energy that the cells away from some places store too little under given forces [J]: half of the squared error e in the energy
   !> norm, where e is the difference of the recovered stress from that of the cells (Zienkiewicz & Zhu 1992), less what the
   !> particles miss of the energy of the cells' own field, which makes these softer. Those of quadratic cells miss next to nothing.
   real(dp) function missing_energy(m, places, radius, u) result(missing)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: places(:, :), radius !! around which cells do not count, and how far [m]
      real(dp), intent(in) :: u(:, :)            !! displacement of the points [m], (ndim, n_points)
      real(dp), allocatable :: stress(:, :), nodal(:, :), squared(:)
      integer :: i, k, e, k_place
      missing = 0
      allocate (stress(stress_components(m%particles), m%particles%n), nodal(stress_components(m%particles), m%grid%n_points))
      associate (p => m%particles, grid => m%grid, b => m%blocks)
         do i = 1, p%n
            stress(:, i) = stress_of(m%materials(p%material(i)), matmul(u(:, grid%support_of(p%cell(i))), derivatives_at(m, i)))
         end do
         if (grid%is_quadratic()) then
            call errors_at_particles(m, stress, squared)
            do k = 1, size(places, 2)
               do i = 1, p%n
                  if (norm2(p%reference(i, :) - places(:, k)) < radius) squared(i) = 0
               end do
            end do
            missing = sum(squared)/2
            return
         end if
         do k = 1, size(m%materials)
            call recover(m%matter_t, m%fields%mass_matrix, size(stress, 1), stress, nodal, material=k)
            do i = 1, b%n_occupied
               e = b%occupied(i)
               if (p%material(b%first_in(e)) /= k) cycle
               associate (middle => grid%element_lower(:, e) + grid%element_size(e)/2)
                  if (any([(norm2(middle - places(:, k_place)) < radius, k_place=1, size(places, 2))])) cycle
               end associate
               missing = missing + missing_in_element(m, e, u(:, grid%element_nodes(:, e)), nodal(:, grid%element_nodes(:, e)))
            end do
         end do
      end associate
   end function missing_energy

   !> The same of an element that is full of material; of others nothing is known [J].
   pure real(dp) function missing_in_element(m, e, u, recovered) result(missing)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      real(dp), intent(in) :: u(ndim, corners)           !! [m]
      real(dp), intent(in) :: recovered(:, :)            !! stress at its nodes [Pa], (components, corners)
      real(dp), parameter :: off = sqrt(1/12.0_dp)       ! of Gauss points from the middle, in cells
      real(dp), parameter :: gauss(ndim, 4) = 0.5_dp + off*reshape([-1, -1, 1, -1, -1, 1, 1, 1], [ndim, 4])
      real(dp), allocatable :: gradient(:, :, :)
      real(dp) :: total, middle(ndim), x(ndim), area, weight, stress(size(recovered, 1)), gradient_there(corners, n_derivatives(m))
      integer :: i, k
      missing = 0
      total = 0
      middle = 0
      associate (p => m%particles, b => m%blocks, material => m%materials(m%particles%material(m%blocks%first_in(e))))
         do i = b%first_in(e), b%last_in(e), b%stride_in(e)
            area = p%area_of(i)
            total = total + area
            middle = middle + area*(m%local_of(i) - 0.5_dp)
            call stiff_points(m, e, i, gradient)
            do k = 1, size(gradient, 3)
               missing = missing + p%volume(i)/size(gradient, 3)*energy_of_stress(material, stress_of(material, &
                                                                                        matmul(u, gradient(:, :, k))))
            end do
         end do
         if (any(abs(middle) > not_full*total)) missing = 0
         if (any(abs(middle) > not_full*total)) return
         do k = 1, 4
            x = m%grid%element_lower(:, e) + gauss(:, k)*m%grid%element_size(e)
            gradient_there(:, :ndim) = shape_gradients(gauss(:, k), 1/m%grid%element_size(e))
            if (material%is_ring) gradient_there(:, ndim + 1) = shape_functions(gauss(:, k))/x(1)
            stress = stress_of(material, matmul(u, gradient_there))
            weight = total/4*p%thickness%at(x)
            missing = missing - weight*energy_of_stress(material, stress)
            missing = missing + weight*energy_of_stress(material, matmul(recovered, shape_functions(gauss(:, k))) - stress)
         end do
      end associate
   end function missing_in_element

   !> Stress of a small displacement gradient, whatever the law, with stress_33 behind it where material is axisymmetric [Pa].
   pure function stress_of(material, h) result(stress)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: h(:, :)            !! with a column for H_33 there [-]
      real(dp) :: stress(n_stress + size(h, 2) - ndim)
      real(dp) :: in_plane(ndim, ndim)
      in_plane = h(:, :ndim)
      if (size(h, 2) == ndim) then
         stress = reshape(material%small_strain_stress(in_plane), [n_stress])
      else
         stress = [reshape(material%small_strain_stress(in_plane, h(1, ndim + 1)), [n_stress]), &
                   material%small_hoop_stress(in_plane, h(1, ndim + 1))]
      end if
   end function stress_of

   !> Particles as they are where their points have a displacement; with a place only those in cells nearer to it than a distance.
   pure subroutine displace(m, u, p, place, distance)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, n_points)
      type(particles_t), intent(out) :: p
      real(dp), intent(in), optional :: place(ndim), distance !! in the reference configuration [m]
      real(dp) :: of_support(ndim, m%grid%n_functions), slopes(m%grid%n_functions, ndim), shape(m%grid%n_functions), xi(ndim)
      real(dp), parameter :: reach = 8           ! of a point in elements, over hanging ones of quadratic cells
      integer :: i
      p = m%particles
      p%velocity = 0
      do i = 1, p%n
         associate (e => p%cell(i))
            if (present(place)) then
               if (norm2(p%reference(i, :) - place) > distance + reach*m%grid%element_size(e)) cycle
            end if
            of_support = u(:, m%grid%support_of(e))
            xi = m%local_of(i)
            slopes = m%grid%gradients_in(e, xi)
            shape = m%grid%functions_in(e, xi)
            p%gradient(i, :, :) = matmul(of_support, slopes)
            p%displacement(i, :) = matmul(of_support, shape)
            if (allocated(p%widening)) p%widening(i) = p%displacement(i, 1)
         end associate
      end do
   end subroutine displace

   !> Gradient at a particle of a displacement of the points [-].
   pure function gradient_of(m, u, i) result(gradient)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, n_points)
      integer, intent(in) :: i
      real(dp) :: gradient(ndim, ndim), of_support(ndim, m%grid%n_functions), slopes(m%grid%n_functions, ndim)
      of_support = u(:, m%grid%support_of(m%particles%cell(i)))
      slopes = m%gradients_of(i)
      gradient = matmul(of_support, slopes)
   end function gradient_of
end module hampm_missing_energy
