!> The passes over the particles (`hampm_particle_pass`) cell by cell: a cell acts on the points of its support, four of a bilinear,
!> nine of a quadratic one, and these on its particles, by shape functions N and gradients. For cells that are quadratic,
!> axisymmetric, or share their dilatation; others are faster there. Results have the same bytes on any number of threads.
!>
!> Mean dilatation (B-bar; Nagtegaal, Parks & Rice, Comput. Meth. Appl. Mech. Engng 4 (1974) 153-177; Hughes, Int. J. Numer. Meth.
!> Engng 15 (1980) 1413-1418): with gradients g_c and their mean over the particles that share, weighted by volume,
!>
!>    L = sum_c v_c (x) g_c + (sum_c v_c . (mean g_c - g_c))/2 I, f_c = -V (stress g_c + (stress_11 + stress_22)/2 (mean g_c - g_c))
!>
!> N_c/r of axisymmetric material is added to the radial component of g_c in these traces. g_c = grad N_c for small strains; else
!> present gradients, with the Kirchhoff stress: F-bar (de Souza Neto et al., Int. J. Solids Struct. 33 (1996) 3277-3296).
module hampm_support_pass
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: inside_cell, edge_margin, points_of_quadratic
   use hampm_audit_kernels, only: work_of_change, work_of_hoop
   use hampm_cell_blocks, only: support_t, lanes, of_mass, of_momentum, of_force
   use hampm_mass_matrix, only: mass_matrix_t, prepare_cell, floor_of_quadratic
   use hampm_material, only: material_t
   use hampm_matter, only: matter_t
   use hampm_state_update, only: update_particle_state, hoop_resistance
   use hampm_nodal_fields, only: nodal_fields_t
   use hampm_particle_kernels, only: anisotropic_forces
   use hampm_particles, only: particles_t
   use hampm_pass, only: pass_t
   use hampm_tensors, only: identity, trace, determinant, inverse_transpose, product_of
   implicit none
   private
   public :: pass_by_supports, mass_of_cell

   real(dp), parameter :: rounding = 1e-12_dp    !! of masses of points, over the mass of a cell

   !> Some particles of a cell side by side, and the functions of its points where they are.
   type :: group_t
      integer :: n = 0                           !! number of particles
      integer :: particle(lanes) = 0             !! these, and the last one again behind them
      real(dp) :: functions(lanes, points_of_quadratic)
      real(dp) :: gradients(lanes, points_of_quadratic, ndim) !! straining: of their frame, or F^-T times these [1/m]
   end type group_t

contains

   !> Points of a cell; of a solid a constant, for which the compiler unrolls.
   pure integer function points_in(cell)
      type(support_t), intent(in) :: cell
      points_in = corners
      if (ndim == 2) points_in = cell%n
   end function points_in

   !> Do a pass over some cells by given fields at the points.
   subroutine pass_by_supports(pass, dt, m, f, listed, acceleration, new_velocity, strain_velocity, audit)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! time step [s]
      type(matter_t), intent(inout) :: m
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: listed(:)           !! numbers of cells among the supports
      real(dp), intent(in) :: acceleration(ndim, *), new_velocity(ndim, *), strain_velocity(ndim, *)
      real(dp), intent(out), optional :: audit(2) !! if asked for: sum of m |dv|**2 / 2, and of V times the integral of P : dH [J]
      real(dp), allocatable :: of_cell(:, :)
      logical, allocatable :: has_left(:)
      integer :: k
      allocate (of_cell(2, size(listed)), has_left(size(listed)))
      !$omp parallel do schedule(static)
      do k = 1, size(listed)
         associate (cell => m%blocks%supports(listed(k)))
            call pass_cell(pass, dt, m, cell, acceleration, new_velocity, strain_velocity, f, of_cell(:, k), has_left(k))
            if (pass%map_matrix) call find_matrix(m, cell, f%mass_matrix)
         end associate
      end do
      if (present(audit)) audit = sum(of_cell, dim=2)
      if (.not. pass%move .or. m%particles%total_frame) return
      f%left(m%blocks%supports(listed)%block(1)) = .false.
      do k = 1, size(listed)
         if (has_left(k)) f%left(m%blocks%supports(listed(k))%block(1)) = .true.
      end do
   end subroutine pass_by_supports

   !> Do the pass with the particles of one cell, some of them side by side. Those that share their dilatation are all strained
   !> before any of them acts on the points.
   subroutine pass_cell(pass, dt, m, cell, acceleration, new_velocity, strain_velocity, f, audit, has_left)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      type(matter_t), intent(inout) :: m
      type(support_t), intent(in) :: cell
      real(dp), intent(in) :: acceleration(ndim, *), new_velocity(ndim, *), strain_velocity(ndim, *)
      type(nodal_fields_t), intent(inout) :: f
      real(dp), intent(out) :: audit(2)          !! [J]
      logical, intent(out) :: has_left           !! whether a particle is no longer in the cell
      real(dp), dimension(ndim, points_in(cell)) :: kick_by, move_by, strain_by ! of the points [m/s, m, m]
      real(dp) :: mass(lanes, points_in(cell)) ! sums [kg, kg m/s, N]
      real(dp), dimension(lanes, points_in(cell), ndim) :: momentum, force
      real(dp) :: mean(points_in(cell), ndim)
      integer :: particles(sum(m%blocks%count_in(cell%first:cell%last))), k
      logical :: all_updated_first
      type(group_t) :: group
      particles = particles_of(m, cell, size(particles))
      mass = 0
      momentum = 0
      force = 0
      audit = 0
      has_left = .false.
      if (pass%kick) kick_by = dt*acceleration(:, cell%points(:points_in(cell)))
      if (pass%move) move_by = dt*new_velocity(:, cell%points(:points_in(cell)))
      if (pass%strain_fraction > 0) strain_by = pass%strain_fraction*dt*strain_velocity(:, cell%points(:points_in(cell)))
      all_updated_first = any(m%materials%mean_dilatation)
      if (all_updated_first) all_updated_first = any(m%materials(m%particles%material(particles))%mean_dilatation)
      if (all_updated_first) mean = mean_gradients(m, cell, particles)
      do k = 1, size(particles), lanes
         call take_group(m, cell, particles(k:), group)
         call update_particles()
         if (all_updated_first) cycle
         if (pass%move .and. .not. m%particles%total_frame) call take_group(m, cell, particles(k:), group)
         call give()
      end do
      if (all_updated_first) then
         mean = mean_gradients(m, cell, particles)
         do k = 1, size(particles), lanes
            call take_group(m, cell, particles(k:), group)
            call give()
         end do
      end if
      call store(pass, cell, m%particles%thickness%is_ring, mass, momentum, force, f)
   contains

      !> Update the particles by the values of the points (G2P).
      subroutine update_particles()
         real(dp) :: change(lanes, ndim, ndim), x(lanes, ndim), xi(ndim)
         integer :: l
         if (pass%kick) then
            call interpolate(points_in(cell), group%functions, kick_by, x)
            do l = 1, group%n
               associate (i => group%particle(l), v => m%particles%velocity)
                  if (pass%audit) audit(1) = audit(1) + 0.5_dp*m%particles%mass(i)*sum(x(l, :)**2)
                  v(i, :) = v(i, :) + x(l, :)
               end associate
            end do
         end if
         if (pass%move) then
            call interpolate(points_in(cell), group%functions, move_by, x)
            do l = 1, group%n
               associate (i => group%particle(l), u => m%particles%displacement)
                  u(i, :) = u(i, :) + x(l, :)
                  if (m%particles%total_frame) cycle
                  xi = (m%particles%place_in_grid(i) - cell%lower)*cell%inverse_size
                  has_left = has_left .or. .not. all(abs(xi - inside_cell(xi)) <= edge_margin)
               end associate
            end do
         end if
         if (.not. pass%strain_fraction > 0) return
         call interpolate(points_in(cell), group%functions, strain_by, x)
         do l = 1, ndim
            call interpolate(points_in(cell), group%gradients(:, :, l), strain_by, change(:, :, l))
         end do
         do l = 1, group%n
            call strain_particle(m%materials(m%particles%material(group%particle(l))), group%particle(l), x(l, 1), change(l, :, :))
         end do
      end subroutine update_particles

      !> Strain a particle.
      subroutine strain_particle(material, i, along_radius, change_of_points)
         type(material_t), intent(in) :: material
         integer, intent(in) :: i
         real(dp), intent(in) :: along_radius    !! displacement along x [m]
         real(dp), intent(in) :: change_of_points(ndim, ndim) !! gradient of the displacement of the points
         real(dp) :: change(ndim, ndim), hoop, missing
         change = change_of_points
         if (material%is_ring) then
            hoop = m%particles%hoop_of(i)
            m%particles%widening(i) = m%particles%widening(i) + along_radius
            if (pass%audit) audit(2) = audit(2) + m%particles%volume(i)*work_of_hoop(material, hoop, m%particles, i)
         end if
         if (material%mean_dilatation) then
            missing = sum(strain_by*transpose(mean)) - trace(change)
            if (material%is_ring) missing = missing - along_radius/radius_of(material, m%particles, i)
            change = change + missing/ndim*identity
         end if
         if (.not. m%particles%total_frame .or. is_by_place(material, m%particles)) &
            change = change + product_of(change, m%particles%gradient_of(i))
         if (pass%audit) &
            audit(2) = audit(2) + m%particles%volume(i)*work_of_change(material, m%particles%gradient_of(i), change, &
                                                                       pass%strain_fraction*dt, m%particles, i, &
                                                                       m%particles%hoop_of(i))
         m%particles%gradient(i, :, :) = m%particles%gradient(i, :, :) + change
         if (pass%updates_state) call update_particle_state(material, pass%strain_fraction*dt, m%particles, i)
      end subroutine strain_particle

      !> Add the contributions of the particles to the points (P2G).
      subroutine give()
         real(dp), dimension(lanes) :: m_p, hoop, half, radius
         real(dp) :: t(lanes, ndim, ndim)
         integer :: l, c, d
         associate (p => m%particles, n => group%n, particle => group%particle)
            if (pass%map_mass .or. pass%map_momentum) then
               m_p = 0
               m_p(:n) = p%mass(particle(:n))
               if (pass%map_mass) call add_to_points(points_in(cell), group%functions, m_p, mass)
               if (pass%map_momentum) then
                  do d = 1, ndim
                     call add_to_points(points_in(cell), group%functions, m_p*p%velocity(particle, d), momentum(:, :, d))
                  end do
               end if
            end if
            if (.not. pass%map_force) return
            call find_forces(m, group, t)
            do c = 1, ndim
               do d = 1, ndim
                  call add_to_points(points_in(cell), group%gradients(:, :, c), -t(:, d, c), force(:, :, d))
               end do
            end do
            if (p%thickness%is_ring) then
               hoop = 0
               do l = 1, n
                  if (m%materials(p%material(particle(l)))%is_ring) &
                     hoop(l) = -p%volume(particle(l))*hoop_resistance(m%materials(p%material(particle(l))), p, particle(l))
               end do
               call add_to_points(points_in(cell), group%functions, hoop, force(:, :, 1))
            end if
            if (.not. all_updated_first) return
            half = 0
            radius = 1
            do l = 1, n
               associate (material => m%materials(p%material(particle(l))))
                  if (.not. material%mean_dilatation) cycle
                  half(l) = trace(t(l, :, :))/ndim
                  radius(l) = radius_of(material, p, particle(l))
               end associate
            end do
            do d = 1, ndim
               do c = 1, points_in(cell)
                  force(:, c, d) = force(:, c, d) - half*(mean(c, d) - group%gradients(:, c, d))
               end do
            end do
            if (.not. p%thickness%is_ring) return
            call add_to_points(points_in(cell), group%functions, half/radius, force(:, :, 1))
         end associate
      end subroutine give
   end subroutine pass_cell

   !> The particles of a cell.
   pure function particles_of(m, cell, n) result(particles)
      type(matter_t), intent(in) :: m
      type(support_t), intent(in) :: cell
      integer, intent(in) :: n                   !! their number
      integer :: particles(n)
      integer :: e, i, k
      k = 0
      do e = cell%first, cell%last
         do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
            k = k + 1
            particles(k) = i
         end do
      end do
   end function particles_of

   !> Take the first of some particles of a cell, as many as stand side by side, with the functions of the points where they are.
   pure subroutine take_group(m, cell, particles, group)
      type(matter_t), intent(in) :: m
      type(support_t), intent(in) :: cell
      integer, intent(in) :: particles(:)
      type(group_t), intent(out) :: group
      real(dp) :: xi(lanes, ndim)
      integer :: l
      group%n = min(lanes, size(particles))
      group%particle = particles(group%n)
      group%particle(:group%n) = particles(:group%n)
      do l = 1, lanes
         xi(l, :) = inside_cell((m%particles%place_in_grid(group%particle(l)) - cell%lower)*cell%inverse_size)
      end do
      call cell%find_functions(xi, group%functions, group%gradients)
      if (.not. (any(m%materials%mean_dilatation) .and. m%particles%total_frame)) return
      do l = 1, group%n
         associate (i => group%particle(l), g => group%gradients)
            if (is_by_place(m%materials(m%particles%material(i)), m%particles)) &
               g(l, :points_in(cell), :) = matmul(g(l, :points_in(cell), :), &
                                                  transpose(inverse_transpose(identity + m%particles%gradient_of(i))))
         end associate
      end do
   end subroutine take_group

   !> Values of a field of the points at particles or, by the gradients of the functions in one direction, its derivatives.
   pure subroutine interpolate(points, functions, field, at)
      integer, intent(in) :: points
      real(dp), intent(in) :: functions(lanes, points), field(ndim, points)
      real(dp), intent(out) :: at(lanes, ndim)
      integer :: c, d, l
      at = 0
      do c = 1, points
         do d = 1, ndim
            !$omp simd
            do l = 1, lanes
               at(l, d) = at(l, d) + functions(l, c)*field(d, c)
            end do
         end do
      end do
   end subroutine interpolate

   !> Add values of particles, by the functions of the points or their gradients, to sums by lane at these.
   pure subroutine add_to_points(points, functions, x, sums)
      integer, intent(in) :: points
      real(dp), intent(in) :: functions(lanes, points), x(lanes)
      real(dp), intent(inout) :: sums(lanes, points)
      integer :: c, l
      do c = 1, points
         !$omp simd
         do l = 1, lanes
            sums(l, c) = sums(l, c) + functions(l, c)*x(l)
         end do
      end do
   end subroutine add_to_points

   !> Volume times stress of particles [N m], 0 behind the last.
   pure subroutine find_forces(m, group, t)
      type(matter_t), intent(in) :: m
      type(group_t), intent(in) :: group
      real(dp), intent(out) :: t(lanes, ndim, ndim)
      real(dp) :: volume(lanes), h(lanes, ndim, ndim)
      integer :: l
      associate (p => m%particles, particle => group%particle, material => m%materials(m%particles%material(group%particle(1))))
         volume = 0
         volume(:group%n) = p%volume(particle(:group%n))
         if (material%linear .and. .not. material%is_ring .and. all(p%material(particle) == p%material(particle(1)))) then
            do l = 1, lanes
               h(l, :, :) = p%gradient(particle(l), :, :) - material%free
            end do
            call anisotropic_forces(1, lanes, material%stiffness, volume, h, t)
            return
         end if
      end associate
      do l = 1, lanes
         associate (p => m%particles, i => group%particle(l), material => m%materials(m%particles%material(group%particle(l))))
            t(l, :, :) = volume(l)*material%mapped_stress(p%gradient_of(i), p%total_frame .and. .not. is_by_place(material, p), &
                                                          p%history_of(i), p%hoop_of(i))
         end associate
      end do
   end subroutine find_forces

   !> Whether a material is strained by gradients with respect to the present position although the frame is total.
   pure logical function is_by_place(material, p)
      type(material_t), intent(in) :: material
      type(particles_t), intent(in) :: p
      is_by_place = material%mean_dilatation .and. p%total_frame .and. material%is_finite
   end function is_by_place

   !> The radius for these gradients [m].
   pure real(dp) function radius_of(material, p, i) result(radius)
      type(material_t), intent(in) :: material
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      radius = p%reference(i, 1)
      if (.not. p%total_frame .or. is_by_place(material, p)) radius = radius + p%displacement(i, 1)
   end function radius_of

   !> Volume-weighted means of the gradients over the particles of a cell with one dilatation [1/m], (points, ndim).
   pure function mean_gradients(m, cell, particles) result(mean)
      type(matter_t), intent(in) :: m
      type(support_t), intent(in) :: cell
      integer, intent(in) :: particles(:)        !! of the cell
      real(dp) :: mean(points_in(cell), ndim), weight, total
      type(group_t) :: group
      integer :: k, l
      mean = 0
      total = 0
      do k = 1, size(particles), lanes
         call take_group(m, cell, particles(k:), group)
         do l = 1, group%n
            associate (i => group%particle(l), material => m%materials(m%particles%material(group%particle(l))))
               if (.not. material%mean_dilatation) cycle
               weight = m%particles%volume(i)
               if (material%is_finite) &
                  weight = weight*determinant(identity + m%particles%gradient_of(i))*(1 + m%particles%hoop_of(i))
               mean = mean + weight*group%gradients(l, :points_in(cell), :)
               if (material%is_ring) &
                  mean(:, 1) = mean(:, 1) + weight*group%functions(l, :points_in(cell))/radius_of(material, m%particles, i)
               total = total + weight
            end associate
         end do
      end do
      if (total > 0) mean = mean/total
   end function mean_gradients

   !> The mass matrix (6) of a cell, by its points [kg].
   pure function mass_of_cell(m, cell) result(own)
      type(matter_t), intent(in) :: m
      type(support_t), intent(in) :: cell
      real(dp) :: own(points_in(cell), points_in(cell))
      type(group_t) :: group
      integer :: particles(sum(m%blocks%count_in(cell%first:cell%last))), k, l, c
      particles = particles_of(m, cell, size(particles))
      own = 0
      do k = 1, size(particles), lanes
         call take_group(m, cell, particles(k:), group)
         do l = 1, group%n
            do c = 1, points_in(cell)
               own(:, c) = own(:, c) + m%particles%mass(group%particle(l))*group%functions(l, c) &
                           *group%functions(l, :points_in(cell))
            end do
         end do
      end do
   end function mass_of_cell

   !> Find the mass matrix of a cell, and its lumped part.
   pure subroutine find_matrix(m, cell, matrix)
      type(matter_t), intent(in) :: m
      type(support_t), intent(in) :: cell
      type(mass_matrix_t), intent(inout) :: matrix
      real(dp) :: own(points_in(cell), points_in(cell))
      own = mass_of_cell(m, cell)
      associate (k => matrix%cell_of(cell%first))
         matrix%cell_lumped(:, k) = sum(own, dim=2)
         if (points_in(cell) == corners) then
            call prepare_cell(corners, matrix%lumped_fraction(k), matrix%is_solved, matrix%may_hang(k), own)
         else if (.not. allocated(matrix%diagonal)) then
            call prepare_cell(points_in(cell), matrix%lumped_fraction(k), matrix%is_solved, matrix%may_hang(k), own, &
                              floor_of_quadratic)
         end if
         matrix%cell(:, :, k) = own
      end associate
   end subroutine find_matrix

   !> Store the contributions of a cell to its points, summed over the lanes, by its elements. Points on an axis have no mass.
   pure subroutine store(pass, cell, is_ring, mass, momentum, force, f)
      type(pass_t), intent(in) :: pass
      type(support_t), intent(in) :: cell
      logical, intent(in) :: is_ring             !! whether there may be such points
      real(dp), intent(in) :: mass(:, :), momentum(:, :, :), force(:, :, :)
      type(nodal_fields_t), intent(inout) :: f
      real(dp) :: of_point
      integer :: e, k, d
      do e = 1, cell%last - cell%first + 1
         associate (given => f%contribution(cell%lane(e), :, :, cell%block(e)))
            if (pass%map_mass) given(:, of_mass) = 0
            if (pass%map_momentum) given(:, of_momentum:of_momentum + ndim - 1) = 0
            if (pass%map_force) given(:, of_force:of_force + ndim - 1) = 0
         end associate
      end do
      do k = 1, points_in(cell)
         associate (given => f%contribution(cell%lane(cell%element_of(k)), cell%corner_of(k), :, cell%block(cell%element_of(k))))
            if (pass%map_mass) then
               of_point = sum(mass(:, k))
               if (is_ring .and. points_in(cell) > corners) of_point = merge(0.0_dp, of_point, abs(of_point) <= rounding*sum(mass))
               given(of_mass) = of_point
            end if
            do d = 1, ndim
               if (pass%map_momentum) given(of_momentum + d - 1) = sum(momentum(:, k, d))
               if (pass%map_force) given(of_force + d - 1) = sum(force(:, k, d))
            end do
         end associate
      end do
   end subroutine store
end module hampm_support_pass
