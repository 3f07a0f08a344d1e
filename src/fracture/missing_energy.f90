!> Strain energy that the cells of a mesh lack against the recovered stress around a place: the basis of the expected error of G.
module hampm_missing_energy
   use hampm_kinds, only: dp, ndim, corners
   use hampm_tensors, only: norm
   use hampm_forest, only: corner_offset
   use hampm_basis, only: shape_functions, shape_gradients
   use hampm_error_indicator, only: errors_at_particles, energy_of_stress, stress_components
   use hampm_material, only: material_t, are_of_one
   use hampm_problem, only: problem_t
   use hampm_particles, only: particles_t
   use hampm_recovery, only: recover
   use hampm_element_stiffness, only: stiff_points, derivatives_at, n_derivatives
   implicit none
   private
   public :: pair_t, missing_energies, displace, gradient_of, stress_of, gradient_by

   integer, parameter :: n_stress = ndim*ndim

   !> Part of its area by which the material of an element may differ from it to count as full.
   real(dp), parameter :: not_full = 1.0e-3_dp

   !> Two displacements whose product in the missing energy is sought, with itself for the energy, and the group of places at the
   !> nearest of which a cell counts.
   type :: pair_t
      integer :: of = 1, with = 1, group = 1
   end type pair_t

contains

   !> Energy that cells away from some places store too little under given forces [J], by pair and place: half of the
   !> squared error e in the energy norm, the difference of recovered and cell stress (Zienkiewicz & Zhu 1992), less the
   !> integration error of the particles in the energy of the cells' own field, which makes these softer; for quadratic cells it is
   !> nearly 0. Of two displacements it is their product in this energy.
   function missing_energies(m, places, radius, group, u, pairs) result(missing)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: places(:, :, :)    !! of cells that do not count [m], (ndim, places, displacements), or 1 for all
      real(dp), intent(in) :: radius(:)          !! around these [m], (places)
      integer, intent(in) :: group(:)            !! of each place; 0: of none
      real(dp), intent(in) :: u(:, :, :)         !! displacements of the points [m], (ndim, n_points, displacements)
      type(pair_t), intent(in) :: pairs(:)       !! each displacement is the first one of one at most
      real(dp) :: missing(size(pairs), size(places, 2))
      real(dp), allocatable :: stress(:, :), nodal(:, :), squared(:, :)
      real(dp) :: gradient(m%grid%n_functions, n_derivatives(m)), part(size(pairs))
      logical :: counts(size(pairs))
      integer :: at(m%grid%n_functions), nearest(size(pairs)), with(size(u, 3)), i, k, e, d
      missing = 0
      associate (p => m%particles, grid => m%grid, b => m%blocks, n => stress_components(m%particles))
         allocate (stress(n*size(u, 3), p%n), nodal(n*size(u, 3), grid%n_points))
         do i = 1, p%n
            at = grid%support_of(p%cell(i))
            gradient = derivatives_at(m, i)
            do d = 1, size(u, 3)
               stress(n*(d - 1) + 1:n*d, i) = stress_of(m%materials(p%material(i)), gradient_by(u(:, :, d), at, gradient))
            end do
         end do
         if (grid%is_quadratic()) then
            with = [(d, d=1, size(with))]
            with(pairs%of) = pairs%with
            call errors_at_particles(m, stress, squared, with)
            do i = 1, p%n
               call look_from(p%reference(i, :))
               call take(squared(i, pairs%of)/2)
            end do
            return
         end if
         do k = 1, size(m%materials)
            if (m%materials(k)%slice%number > 1) cycle
            call recover(m%matter_t, m%fields%mass_matrix, size(stress, 1), stress, nodal, material=k)
            do i = 1, b%n_occupied
               e = b%occupied(i)
               if (.not. are_of_one(m%materials, k, p%material(b%first_in(e)))) cycle
               call look_from(grid%element_lower(:, e) + grid%element_size(e)/2)
               part = 0
               call add_missing(m, e, n, counts, u, pairs, stress, nodal, part)
               call take(part)
            end do
         end do
      end associate

   contains

      !> Find for each pair whether a place counts, and the place of its group that is the nearest one.
      subroutine look_from(x)
         real(dp), intent(in) :: x(ndim)         !! [m]
         real(dp) :: square, least(0:maxval([group, pairs%group]))
         integer :: best(0:size(least) - 1), d, k
         logical :: is_near(size(places, 3))
         is_near = .false.
         least = huge(least)
         best = 0
         do k = 1, size(places, 2)
            do d = 1, size(places, 3)
               square = sum((x - places(:, k, d))**2)
               is_near(d) = is_near(d) .or. square < radius(k)**2
            end do
            if (square >= least(group(k))) cycle
            least(group(k)) = square
            best(group(k)) = k
         end do
         counts = .not. is_near(1)
         if (size(is_near) > 1) counts = .not. is_near(pairs%of)
         nearest = best(pairs%group)
      end subroutine look_from

      !> Add the energy of a cell or a particle.
      subroutine take(energy)
         real(dp), intent(in) :: energy(:)       !! [J], (pairs)
         integer :: d
         do d = 1, size(energy)
            if (counts(d) .and. nearest(d) > 0) missing(d, nearest(d)) = missing(d, nearest(d)) + energy(d)
         end do
      end subroutine take
   end function missing_energies

   !> Number of the material of an element; of a graded body at its middle.
   pure integer function material_of(m, e) result(k)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      integer :: d
      associate (p => m%particles, b => m%blocks)
         k = p%material(b%first_in(e))
         if (.not. m%materials(k)%is_graded()) return
         associate (all => p%reference(b%first_in(e):b%last_in(e):b%stride_in(e), :))
            k = k + m%materials(k)%slices_to([(sum(all(:, d))/size(all, 1), d=1, ndim)])
         end associate
      end associate
   end function material_of

   !> Add the energy of an element, for the pairs for which it counts. Where it is not full particles integrate the error.
   subroutine add_missing(m, e, n, counts, u, pairs, of_particles, recovered, missing)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e
      integer, intent(in) :: n                   !! components of a stress
      logical, intent(in) :: counts(:)           !! (pairs)
      real(dp), intent(in) :: u(:, :, :)         !! of the points [m], (ndim, n_points, displacements)
      type(pair_t), intent(in) :: pairs(:)
      real(dp), intent(in) :: of_particles(:, :) !! stresses of the particles, one after the other [Pa], (components, particles)
      real(dp), intent(in) :: recovered(:, :)    !! and at the points [Pa], (components, n_points)
      real(dp), intent(inout) :: missing(:)      !! [J], (pairs)
      real(dp), parameter :: off = sqrt(1/12.0_dp)       ! of Gauss points from the middle, in cells
      real(dp), allocatable :: gradient(:, :, :)
      real(dp) :: total, weight, shape(corners), slopes(corners, n_derivatives(m)), stress(n, size(u, 3))
      real(dp) :: gauss(ndim), x(ndim)
      integer :: i, k, at(corners), number       ! of the material
      if (.not. any(counts)) return
      at = m%grid%element_nodes(:, e)
      number = material_of(m, e)
      total = 0
      associate (p => m%particles, b => m%blocks)
         do i = b%first_in(e), b%last_in(e), b%stride_in(e)
            total = total + p%area_of(i)
         end do
         if (abs(total/m%grid%element_size(e)**ndim - 1) > not_full) then
            do i = b%first_in(e), b%last_in(e), b%stride_in(e)
               stress = reshape(of_particles(:, i), [n, size(u, 3)])
               call take_recovered(m%functions_of(i))
               call add(p%volume(i))
            end do
            return
         end if
         do i = b%first_in(e), b%last_in(e), b%stride_in(e)
            if (b%count_in(e) > 1) then
               stress = reshape(of_particles(:, i), [n, size(u, 3)])
               call add(p%volume(i))
               cycle
            end if
            call stiff_points(m, e, i, gradient)
            do k = 1, size(gradient, 3)
               call find_stress(gradient(:, :, k))
               call add(p%volume(i)/size(gradient, 3))
            end do
         end do
         do k = 1, corners
            gauss = 0.5_dp + off*(2*corner_offset(k) - 1)
            x = m%grid%element_lower(:, e) + gauss*m%grid%element_size(e)
            slopes(:, :ndim) = shape_gradients(gauss, 1/m%grid%element_size(e))
            shape = shape_functions(gauss)
            if (m%materials(number)%is_ring) slopes(:, ndim + 1) = shape/x(1)
            weight = total/corners*p%thickness%at(x)
            call find_stress(slopes)
            call add(-weight)
            call take_recovered(shape)
            call add(weight)
         end do
      end associate

   contains

      !> Stresses of the displacements by the derivatives of the functions.
      subroutine find_stress(derivatives)
         real(dp), intent(in) :: derivatives(:, :) !! [1/m]
         integer :: d
         do d = 1, size(stress, 2)
            stress(:, d) = stress_of(m%materials(number), gradient_by(u(:, :, d), at, derivatives))
         end do
      end subroutine find_stress

      !> Subtract the recovered stresses where the functions of the corners have these values.
      subroutine take_recovered(functions)
         real(dp), intent(in) :: functions(corners) !! [-]
         integer :: c, d
         do c = 1, corners
            do d = 1, size(stress, 2)
               stress(:, d) = stress(:, d) - functions(c)*recovered(n*(d - 1) + 1:n*d, at(c))
            end do
         end do
      end subroutine take_recovered

      !> Add the energy of the stresses in a volume.
      subroutine add(volume)
         real(dp), intent(in) :: volume          !! [m3]
         integer :: d
         do d = 1, size(missing)
            if (counts(d)) missing(d) = missing(d) + volume*energy_of_stress(m%materials(number), stress(:, pairs(d)%of), &
                                                                             stress(:, pairs(d)%with))
         end do
      end subroutine add
   end subroutine add_missing

   !> Gradient of a displacement of points by the derivatives of the functions of those at some of them [-].
   pure function gradient_by(u, at, derivatives) result(gradient)
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, points)
      integer, intent(in) :: at(:)
      real(dp), intent(in) :: derivatives(:, :)  !! [1/m], (size(at), derivatives)
      real(dp) :: gradient(ndim, size(derivatives, 2))
      integer :: k, j
      gradient = 0
      do j = 1, size(derivatives, 2)
         do k = 1, size(at)
            gradient(:, j) = gradient(:, j) + u(:, at(k))*derivatives(k, j)
         end do
      end do
   end function gradient_by

   !> Stress of a small displacement gradient, for any law, with stress_33 last in axisymmetric material [Pa].
   pure function stress_of(material, h) result(stress)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: h(:, :)            !! with a column for H_33 there [-]
      real(dp) :: stress(n_stress + size(h, 2) - ndim)
      real(dp) :: h_in_plane(ndim, ndim), in_plane(ndim, ndim), hoop
      h_in_plane = h(:, :ndim)
      hoop = 0
      if (size(h, 2) > ndim) hoop = h(1, ndim + 1)
      in_plane = material%small_strain_stress(h_in_plane, hoop)
      stress(:n_stress) = [in_plane]             ! reshape would be a call of the library
      if (size(h, 2) > ndim) stress(n_stress + 1) = material%small_hoop_stress(h_in_plane, hoop)
   end function stress_of

   !> Particles at the displaced points; with a list only those in it, others stay where they were. A part of a second displacement
   !> may be added.
   pure subroutine displace(m, u, p, among, second, part)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, n_points)
      type(particles_t), intent(inout) :: p      !! from here before, or none
      integer, intent(in), optional :: among(:)
      real(dp), intent(in), optional :: second(:, :) !! as `u`
      real(dp), intent(in), optional :: part     !! of it that is added
      real(dp) :: around(ndim, m%grid%n_functions), slopes(m%grid%n_functions, ndim), shape(m%grid%n_functions)
      real(dp) :: xi(ndim), moved(ndim)
      integer :: at(m%grid%n_functions), i, k, n, number
      if (p%n == 0) then
         p = m%particles
         p%velocity = 0
      end if
      number = p%n
      if (present(among)) number = size(among)
      do n = 1, number
         i = n
         if (present(among)) i = among(n)
         associate (e => p%cell(i))
            at = m%grid%support_of(e)
            xi = m%local_of(i)
            slopes = m%grid%gradients_in(e, xi)
            shape = m%grid%functions_in(e, xi)
            do k = 1, size(at)
               around(:, k) = u(:, at(k))
               if (present(second)) around(:, k) = around(:, k) + part*second(:, at(k))
            end do
            p%gradient(i, :, :) = matmul(around, slopes)
            moved = 0
            do k = 1, size(at)
               moved = moved + around(:, k)*shape(k)
            end do
            p%displacement(i, :) = moved
            if (allocated(p%widening)) p%widening(i) = p%displacement(i, 1)
         end associate
      end do
   end subroutine displace

   !> Gradient at a particle of a displacement of the points [-].
   pure function gradient_of(m, u, i) result(gradient)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: u(:, :)            !! [m], (ndim, n_points)
      integer, intent(in) :: i
      real(dp) :: gradient(ndim, ndim)
      gradient = gradient_by(u, m%grid%support_of(m%particles%cell(i)), m%gradients_of(i))
   end function gradient_of
end module hampm_missing_energy
