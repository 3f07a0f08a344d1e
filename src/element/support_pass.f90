!> The passes over the particles (`hampm_particle_pass`) cell by cell, as the equations have them: a cell acts on the points of its support,
!> the four of a bilinear or the nine of a quadratic one, and these on its particles, by their shape functions N and gradients. Models go this
!> way whose cells are quadratic, whose particles are rings, or share the dilatation of their cell; for others `hampm_particle_pass` is faster.
!>
!> **Mean dilatation.** Where material hardly changes its volume, as in plastic flow, a bilinear cell with 2 by 2 particles has as many
!> constraints as displacements, and no limit load (Nagtegaal, Parks & Rice, Comput. Meth. Appl. Mech. Engng 4 (1974) 153-177). With one
!> dilatation a cell it can flow (B-bar; Hughes, Int. J. Numer. Meth. Engng 15 (1980) 1413-1418, in the plane). By gradients g_c of the
!> functions of the points c with respect to position, and their mean over the particles that share, weighted by volume, the velocities v_c strain a
!> particle by L, and its stress acts on the points by f_c, which do the same work:
!>
!>    L = sum_c v_c (x) g_c + (sum_c v_c . (mean g_c - g_c))/2 I,    f_c = -V (stress g_c + (stress_11 + stress_22)/2 (mean g_c - g_c)).
!>
!> Of a ring N_c/r comes to the radial component of g_c in these traces.
!>
!> Laws for small strain have g_c = grad N_c in their frame. Those for any strain have the Kirchhoff stress, and gradients with respect to
!> present positions in both frames, F^-T grad N_c in the total one: F-bar (de Souza Neto et al., Int. J. Solids Struct. 33 (1996) 3277-3296)
!> step by step.
!>
!> What a cell gives to its points is kept as contributions of its elements at their corners, so that sums at the nodes are assembled as ever. Cells
!> do not share what they write: the result has the same bytes on any number of threads.
module hampm_support_pass
   use hampm_kinds, only: dp, ndim, corners
   use hampm_basis, only: inside_cell, edge_margin
   use hampm_audit_kernels, only: work_of_change, work_of_hoop
   use hampm_cell_blocks, only: support_t, of_mass, of_momentum, of_force
   use hampm_mass_matrix, only: mass_matrix_t, prepare_cell, floor_of_quadratic
   use hampm_material, only: material_t
   use hampm_matter, only: matter_t
   use hampm_state_update, only: update_particle_state, hoop_resistance
   use hampm_nodal_fields, only: nodal_fields_t
   use hampm_particles, only: particles_t
   use hampm_pass, only: pass_t
   use hampm_tensors, only: identity, trace, determinant, inverse_transpose, product_of
   implicit none
   private
   public :: pass_by_supports, mass_of_cell

   real(dp), parameter :: rounding = 1e-12_dp    !! of masses of points, over that of a cell

contains

   !> Do a pass over some cells by given fields at the points.
   subroutine pass_by_supports(pass, dt, m, f, listed, acceleration, new_velocity, strain_velocity, audit)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! time step [s]
      type(matter_t), intent(inout) :: m
      type(nodal_fields_t), intent(inout) :: f
      integer, intent(in) :: listed(:)           !! numbers of cells among the supports
      real(dp), intent(in) :: acceleration(ndim, *), new_velocity(ndim, *), strain_velocity(ndim, *)
      real(dp), intent(out), optional :: audit(2) !! if the pass is to: sum of m |dv|**2 / 2, and of V times the integral of P : dH [J]
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

   !> Do the pass with the particles of one cell. Those that share their dilatation are all strained before any of them acts on the points.
   subroutine pass_cell(pass, dt, m, cell, acceleration, new_velocity, strain_velocity, f, audit, has_left)
      type(pass_t), intent(in) :: pass
      real(dp), intent(in) :: dt                 !! [s]
      type(matter_t), intent(inout) :: m
      type(support_t), intent(in) :: cell
      real(dp), intent(in) :: acceleration(ndim, *), new_velocity(ndim, *), strain_velocity(ndim, *)
      type(nodal_fields_t), intent(inout) :: f
      real(dp), intent(out) :: audit(2)          !! [J]
      logical, intent(out) :: has_left           !! whether a particle is no longer in the cell
      logical :: all_updated_first
      real(dp) :: mass(cell%n), momentum(ndim, cell%n), force(ndim, cell%n) ! sums [kg, kg m/s, N]
      real(dp) :: n(cell%n), gradient(cell%n, ndim), mean(cell%n, ndim)
      integer :: e, i
      mass = 0
      momentum = 0
      force = 0
      audit = 0
      has_left = .false.
      all_updated_first = shares_dilatation(m, cell)
      if (all_updated_first) mean = mean_gradients(m, cell)
      do e = cell%first, cell%last
         do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
            call find_particle_support(m%particles, cell, i, n, gradient)
            call update_particle(i)
            if (all_updated_first) cycle
            if (pass%move .and. .not. m%particles%total_frame) call find_particle_support(m%particles, cell, i, n, gradient)
            call give(i)
         end do
      end do
      if (all_updated_first) then
         mean = mean_gradients(m, cell)
         do e = cell%first, cell%last
            do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
               call find_particle_support(m%particles, cell, i, n, gradient)
               call give(i)
            end do
         end do
      end if
      if (m%particles%thickness%is_ring .and. cell%n > corners) where (abs(mass) <= rounding*sum(mass)) mass = 0 ! on the axis
      call store(pass, cell, mass, momentum, force, f)
   contains

      !> Give a particle what the points do to it (G2P).
      subroutine update_particle(i)
         integer, intent(in) :: i
         real(dp) :: dv(ndim), v(ndim, cell%n), change(ndim, ndim), xi(ndim), hoop, missing
         associate (material => m%materials(m%particles%material(i)))
            if (pass%kick) then
               dv = dt*matmul(acceleration(:, cell%points(:cell%n)), n)
               if (pass%audit) audit(1) = audit(1) + 0.5_dp*m%particles%mass(i)*sum(dv**2)
               m%particles%velocity(i, :) = m%particles%velocity(i, :) + dv
            end if
            if (pass%move) then
               m%particles%displacement(i, :) = m%particles%displacement(i, :) + dt*matmul(new_velocity(:, cell%points(:cell%n)), n)
               xi = (m%particles%place_in_grid(i) - cell%lower)*cell%inverse_size
               has_left = has_left .or. .not. all(abs(xi - inside_cell(xi)) <= edge_margin)
            end if
            if (pass%strain_fraction > 0) then
               v = pass%strain_fraction*dt*strain_velocity(:, cell%points(:cell%n))
               if (material%is_ring) then
                  hoop = m%particles%hoop_of(i)
                  m%particles%widening(i) = m%particles%widening(i) + dot_product(v(1, :), n)
                  if (pass%audit) audit(2) = audit(2) + m%particles%volume(i)*work_of_hoop(material, hoop, m%particles, i)
               end if
               change = matmul(v, gradients_by_place(material, m%particles, i, gradient))
               if (material%mean_dilatation) then
                  missing = sum(v*transpose(mean)) - trace(change)
                  if (material%is_ring) missing = missing - dot_product(v(1, :), n)/radius_of(material, m%particles, i)
                  change = change + missing/2*identity
               end if
               if (.not. m%particles%total_frame .or. is_by_place(material, m%particles)) &
                  change = change + product_of(change, m%particles%gradient_of(i))
               if (pass%audit) &
                  audit(2) = audit(2) + m%particles%volume(i)*work_of_change(material, m%particles%gradient_of(i), change, &
                                                                             pass%strain_fraction*dt, m%particles, i, &
                                                                             m%particles%hoop_of(i))
               m%particles%gradient(i, :, :) = m%particles%gradient(i, :, :) + change
               if (pass%updates_state) call update_particle_state(material, pass%strain_fraction*dt, m%particles, i)
            end if
         end associate
      end subroutine update_particle

      !> Give the points what a particle does to them (P2G).
      subroutine give(i)
         integer, intent(in) :: i
         real(dp) :: t(ndim, ndim), g(cell%n, ndim), v(ndim)
         integer :: c
         if (pass%map_mass) mass = mass + m%particles%mass(i)*n
         if (pass%map_momentum) then
            v = m%particles%mass(i)*m%particles%velocity(i, :)
            do c = 1, cell%n
               momentum(:, c) = momentum(:, c) + n(c)*v
            end do
         end if
         if (.not. pass%map_force) return
         associate (material => m%materials(m%particles%material(i)))
            t = m%particles%volume(i)*material%mapped_stress(m%particles%gradient_of(i), m%particles%total_frame &
                                                             .and. .not. is_by_place(material, m%particles), &
                                                             m%particles%history_of(i), m%particles%hoop_of(i))
            g = gradients_by_place(material, m%particles, i, gradient)
            force = force - matmul(t, transpose(g))
            if (material%is_ring) force(1, :) = force(1, :) - m%particles%volume(i)*hoop_resistance(material, m%particles, i)*n
            if (.not. material%mean_dilatation) return
            if (material%is_ring) g(:, 1) = g(:, 1) + n/radius_of(material, m%particles, i)
         end associate
         do c = 1, cell%n
            force(:, c) = force(:, c) - trace(t)/2*(mean(c, :) - g(c, :))
         end do
      end subroutine give
   end subroutine pass_cell

   !> Functions of the points of a cell, and their gradients, where a particle stands.
   pure subroutine find_particle_support(p, cell, i, n, gradient)
      type(particles_t), intent(in) :: p
      type(support_t), intent(in) :: cell
      integer, intent(in) :: i
      real(dp), intent(out) :: n(:)              !! (points)
      real(dp), intent(out) :: gradient(:, :)    !! [1/m], (points, ndim)
      real(dp) :: xi(ndim)
      xi = inside_cell((p%place_in_grid(i) - cell%lower)*cell%inverse_size)
      n = cell%functions(xi)
      gradient = cell%gradients(xi)
   end subroutine find_particle_support

   !> Whether a material is strained by gradients with respect to the present position although the frame is total.
   pure logical function is_by_place(material, p)
      type(material_t), intent(in) :: material
      type(particles_t), intent(in) :: p
      is_by_place = material%mean_dilatation .and. p%total_frame .and. material%is_finite
   end function is_by_place

   !> The gradients by which a particle is strained [1/m], (points, ndim): those of its frame or, above, F^-T times these.
   pure function gradients_by_place(material, p, i, gradient) result(g)
      type(material_t), intent(in) :: material
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      real(dp), intent(in) :: gradient(:, :)     !! those of the frame
      real(dp) :: g(size(gradient, 1), ndim)
      g = gradient
      if (is_by_place(material, p)) g = matmul(g, transpose(inverse_transpose(identity + p%gradient_of(i))))
   end function gradients_by_place

   !> The radius that goes with these gradients [m].
   pure real(dp) function radius_of(material, p, i) result(radius)
      type(material_t), intent(in) :: material
      type(particles_t), intent(in) :: p
      integer, intent(in) :: i
      radius = p%reference(i, 1)
      if (.not. p%total_frame .or. is_by_place(material, p)) radius = radius + p%displacement(i, 1)
   end function radius_of

   !> Whether particles of a cell share their dilatation.
   pure logical function shares_dilatation(m, cell) result(shares)
      type(matter_t), intent(in) :: m
      type(support_t), intent(in) :: cell
      integer :: e
      shares = .false.
      if (.not. any(m%materials%mean_dilatation)) return
      do e = cell%first, cell%last
         associate (first => m%blocks%first_in(e), last => m%blocks%last_in(e), stride => m%blocks%stride_in(e))
            shares = shares .or. any(m%materials(m%particles%material(first:last:stride))%mean_dilatation)
         end associate
      end do
   end function shares_dilatation

   !> Means of the gradients over the particles of a cell that share their dilatation, weighted by present volume [1/m], (points, ndim).
   pure function mean_gradients(m, cell) result(mean)
      type(matter_t), intent(in) :: m
      type(support_t), intent(in) :: cell
      real(dp) :: mean(cell%n, ndim), n(cell%n), gradient(cell%n, ndim), weight, total
      integer :: e, i
      mean = 0
      total = 0
      do e = cell%first, cell%last
         do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
            associate (material => m%materials(m%particles%material(i)))
               if (.not. material%mean_dilatation) cycle
               call find_particle_support(m%particles, cell, i, n, gradient)
               weight = m%particles%volume(i)
               if (material%is_finite) &
                  weight = weight*determinant(identity + m%particles%gradient_of(i))*(1 + m%particles%hoop_of(i))
               mean = mean + weight*gradients_by_place(material, m%particles, i, gradient)
               if (material%is_ring) mean(:, 1) = mean(:, 1) + weight*n/radius_of(material, m%particles, i)
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
      real(dp) :: n(cell%n), gradient(cell%n, ndim), own(cell%n, cell%n)
      integer :: e, i, c
      own = 0
      do e = cell%first, cell%last
         do i = m%blocks%first_in(e), m%blocks%last_in(e), m%blocks%stride_in(e)
            call find_particle_support(m%particles, cell, i, n, gradient)
            do c = 1, cell%n
               own(:, c) = own(:, c) + m%particles%mass(i)*n(c)*n
            end do
         end do
      end do
   end function mass_of_cell

   !> Find the mass matrix of a cell, and what of it is lumped.
   pure subroutine find_matrix(m, cell, matrix)
      type(matter_t), intent(in) :: m
      type(support_t), intent(in) :: cell
      type(mass_matrix_t), intent(inout) :: matrix
      real(dp) :: own(cell%n, cell%n)
      own = mass_of_cell(m, cell)
      associate (k => matrix%cell_of(cell%first))
         matrix%cell_lumped(:, k) = sum(own, dim=2)
         if (cell%n == corners) then
            call prepare_cell(corners, matrix%lumped_fraction(k), matrix%is_solved, matrix%may_hang(k), own)
         else if (.not. allocated(matrix%diagonal)) then
            call prepare_cell(cell%n, matrix%lumped_fraction(k), matrix%is_solved, matrix%may_hang(k), own, floor_of_quadratic)
         end if
         matrix%cell(:, :, k) = own
      end associate
   end subroutine find_matrix

   !> Store what a cell gives to its points as contributions of its elements.
   pure subroutine store(pass, cell, mass, momentum, force, f)
      type(pass_t), intent(in) :: pass
      type(support_t), intent(in) :: cell
      real(dp), intent(in) :: mass(:), momentum(:, :), force(:, :)
      type(nodal_fields_t), intent(inout) :: f
      integer :: e, k
      do e = 1, cell%last - cell%first + 1
         associate (given => f%contribution(cell%lane(e), :, :, cell%block(e)))
            if (pass%map_mass) given(:, of_mass) = 0
            if (pass%map_momentum) given(:, of_momentum:of_momentum + ndim - 1) = 0
            if (pass%map_force) given(:, of_force:of_force + ndim - 1) = 0
         end associate
      end do
      do k = 1, cell%n
         associate (given => f%contribution(cell%lane(cell%element_of(k)), cell%corner_of(k), :, cell%block(cell%element_of(k))))
            if (pass%map_mass) given(of_mass) = mass(k)
            if (pass%map_momentum) given(of_momentum:of_momentum + ndim - 1) = momentum(:, k)
            if (pass%map_force) given(of_force:of_force + ndim - 1) = force(:, k)
         end associate
      end do
   end subroutine store
end module hampm_support_pass
