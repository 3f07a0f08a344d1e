!> The domain integrals find the K and J of the singular fields at a tip, and nothing where there is no crack, however the
!> material moves.
program test_domain_integral
   use hampm_kinds, only: dp, ndim
   use hampm_crack_tip_field, only: modes, tip_field_t, new_tip_field, let_run
   use hampm_closed_faces, only: closed_faces_t
   use hampm_crack_lines, only: line_t
   use hampm_crack_tip, only: frame_along
   use hampm_domain_integral, only: integrals_t, domain_integrals, shares_of_modes
   use hampm_tip_domain, only: tip_domain_t, places_t
   use hampm_failure, only: failure_t
   use hampm_forest, only: forest_t
   use hampm_harness, only: check, check_close, finish
   use hampm_matching, only: adopt_forest
   use hampm_material, only: material_t, new_material
   use hampm_problem, only: problem_t
   use hampm_nodal_state, only: nodal_state_t, find_nodal_state
   use hampm_refined, only: refine_box
   use hampm_samples, only: rectangle_t, place_bodies, start, nodal_velocity, thickness
   use hampm_sorting, only: sort_into_cells
   use hampm_tensors, only: identity
   implicit none

   real(dp), parameter :: pi = acos(-1.0_dp)
   real(dp), parameter :: edge = 1.0_dp                       !! of every body [m]
   real(dp), parameter :: tip(ndim) = 0.5_dp*edge
   real(dp), parameter :: directions(ndim, 4) = reshape([1.0_dp, 0.0_dp, -1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp, 0.0_dp, -1.0_dp], &
                                                        [ndim, 4])
   real(dp), parameter :: k_known(modes) = [2.0e6_dp, -1.3e6_dp]  !! [Pa sqrt(m)]
   type(material_t) :: stress, strain, rubber
   integer :: d

   stress = new_material('', 'linear_elastic', .true., 70.0e9_dp, 0.3_dp, 2700.0_dp)
   strain = new_material('', 'linear_elastic', .false., 70.0e9_dp, 0.3_dp, 2700.0_dp)
   rubber = new_material('', 'neo_hookean', .false., 70.0e9_dp, 0.3_dp, 2700.0_dp)
   call stress_of_the_tip_field(stress)
   call stress_of_the_tip_field(strain)
   call tip_field_of_the_other_law()
   call field_of_a_tip_that_runs(stress)
   call field_of_a_tip_that_runs(strain)
   do d = 1, size(directions, 2)
      call known_factors(stress, directions(:, d), .false.)
      call known_factors(strain, directions(:, d), .false.)
      call known_factors(strain, directions(:, d), .true.)
      call waves(strain, directions(:, d), 0.0_dp)
      call pressed_faces(directions(:, d))
   end do
   call waves(stress, directions(:, 1), 0.0_dp)
   call waves(rubber, directions(:, 1), 0.0_dp)
   call waves(strain, directions(:, 1), 3.0e4_dp)
   call wave_along_the_crack()
   call factors_by_radius()
   call factors_in_a_refined_mesh()
   call rigid_motion()
   call turned_crack(.false.)
   call turned_crack(.true.)
   call shares()
   call finish()

contains

   !> Stresses of both modes against those of the textbooks (Anderson, Fracture Mechanics, table 2.1), which do not depend on
   !> the elastic constants.
   subroutine stress_of_the_tip_field(material)
      type(material_t), intent(in) :: material
      real(dp) :: t, r, expected(3, modes), found(ndim, ndim), scale
      type(tip_field_t) :: field
      integer :: n, mode
      field = new_tip_field(material, [1.0_dp, 0.0_dp])
      r = 0.37_dp
      scale = 1/sqrt(2*pi*r)
      do n = -4, 4
         t = 0.7_dp*n
         associate (c => cos(t/2), s => sin(t/2), c3 => cos(3*t/2), s3 => sin(3*t/2))
            expected(:, 1) = scale*[c*(1 - s*s3), c*(1 + s*s3), s*c*c3]
            expected(:, 2) = scale*[-s*(2 + c*c3), s*c*c3, c*(1 - s*s3)]
         end associate
         do mode = 1, modes
            found = field%stress(field%gradient(mode, r*[cos(t), sin(t)]))
            call check_close(maxval(abs([found(1, 1), found(2, 2), found(1, 2)] - expected(:, mode))), 0.0_dp, &
                             1.0e-13_dp*scale, 'the tip field has the stresses of the textbooks')
         end do
      end do
   end subroutine stress_of_the_tip_field

   !> The stress of the tip field is that of a small strain, also where the law of the material is another one.
   subroutine tip_field_of_the_other_law()
      real(dp), parameter :: h(ndim, ndim) = 1.0e-7_dp*reshape([1.0_dp, 0.3_dp, -0.5_dp, 0.8_dp], [ndim, ndim])
      type(material_t) :: material
      type(tip_field_t) :: field
      integer :: k
      do k = 1, 2
         material = new_material('', 'neo_hookean', k == 1, 70.0e9_dp, 0.3_dp, 2700.0_dp)
         field = new_tip_field(material, [1.0_dp, 0.0_dp])
         call check_close(maxval(abs(field%stress(h) - material%first_piola_stress(h))), 0.0_dp, 1.0e-2_dp, &
                          'the stress of the tip field is that of a neo-Hookean material at small strain')
      end do
   end subroutine tip_field_of_the_other_law

   !> A tip that runs: its faces are free and open as its factor A has it, its stress is in balance with its inertia and has the K ahead that it is for, and at a low speed
   !> the field is that of a tip at rest.
   subroutine field_of_a_tip_that_runs(material)
      type(material_t), intent(in) :: material
      real(dp), parameter :: x(ndim) = [-0.21_dp, 0.34_dp], dx = 1.0e-4_dp, behind = 0.4_dp
      real(dp) :: stresses(ndim, ndim, -1:1, ndim), balance(ndim), at(ndim), h(ndim, ndim)
      type(tip_field_t) :: rest, slow, field
      integer :: mode, n, d
      rest = new_tip_field(material, [1.0_dp, 0.0_dp])
      slow = rest
      field = rest
      call let_run(slow, material, 0.01_dp*material%shear_wave_speed())
      call let_run(field, material, 0.6_dp*material%shear_wave_speed())
      call check(slow%is_running .and. field%is_running, 'a tip runs')
      do mode = 1, modes
         call check(maxval(abs(slow%gradient(mode, x) - rest%gradient(mode, x))) < 1.0e-3_dp*maxval(abs(rest%gradient(mode, x))), &
                    'a slow tip has the field of one at rest')
         do d = 1, ndim
            do n = -1, 1, 2
               at = x + n*dx*identity(:, d)
               stresses(:, :, n, d) = field%stress(field%gradient(mode, at))
            end do
         end do
         balance = (stresses(:, 1, 1, 1) - stresses(:, 1, -1, 1) + stresses(:, 2, 1, 2) - stresses(:, 2, -1, 2))/(2*dx)
         call check(maxval(abs(balance - field%inertia(mode, x))) < 1.0e-5_dp*maxval(abs(balance)), &
                    'its stress is in balance with its inertia')
         h = field%stress(field%gradient(mode, [-behind, 0.0_dp]))
         call check(maxval(abs(h(:, 2))) < 1.0e-12_dp, 'its faces are free')
         h = field%stress(field%gradient(mode, [behind, 0.0_dp]))
         call check_close(h(3 - mode, 2)*sqrt(2*pi*behind), 1.0_dp, 1.0e-12_dp, 'and it has a unit K ahead')
         h = field%gradient(mode, [-behind, 0.0_dp])
         call check_close(-h(3 - mode, 1)*4*behind/field%opening(mode, mode, behind), 1.0_dp, 1.0e-12_dp, &
                          'and they open as the energy release rate has it')
      end do
      field = rest
      call let_run(field, material, 0.95_dp*material%shear_wave_speed())
      call check(.not. field%is_running, 'no tip of K runs faster than Rayleigh waves')
   end subroutine field_of_a_tip_that_runs

   !> A square of `cells` by `cells`, or that half of it to the left of the crack, 2 by 2 particles a cell.
   subroutine place_square(material, cells, direction, half, m, lines)
      type(material_t), intent(in) :: material
      integer, intent(in) :: cells
      real(dp), intent(in) :: direction(ndim)
      logical, intent(in) :: half
      type(problem_t), intent(out) :: m
      type(line_t), intent(in), optional :: lines(:)
      type(rectangle_t) :: square
      real(dp) :: left(ndim)
      square = rectangle_t([0.0_dp, 0.0_dp], [edge, edge], [2*cells, 2*cells])
      if (half) then
         left = [-direction(2), direction(1)]
         square%lower = square%lower + 0.5_dp*edge*max(left, 0.0_dp)
         square%upper = square%upper + 0.5_dp*edge*min(left, 0.0_dp)
         square%points = nint(2*cells*(square%upper - square%lower)/edge)
      end if
      call place_bodies(forest_t([0.0_dp, 0.0_dp], edge/cells, [cells, cells]), material, [square], m, lines)
      allocate (m%loads(0))
   end subroutine place_square

   !> Give all particles the strain of the tip fields.
   subroutine open_crack(m, direction, k)
      type(problem_t), intent(inout) :: m
      real(dp), intent(in) :: direction(ndim), k(modes)
      real(dp) :: axes(ndim, ndim), h(ndim, ndim)
      type(tip_field_t) :: field
      integer :: i, mode
      axes = reshape([direction(1), direction(2), -direction(2), direction(1)], [ndim, ndim])
      field = new_tip_field(m%materials(1), direction)
      do i = 1, m%particles%n
         h = 0
         do mode = 1, modes
            h = h + k(mode)*field%gradient(mode, matmul(m%particles%reference(i, :) - tip, axes))
         end do
         m%particles%gradient(i, :, :) = matmul(matmul(axes, h), transpose(axes))
      end do
   end subroutine open_crack

   !> Nodes at rest without forces, as they are in equilibrium.
   pure type(nodal_state_t) function rest(m)
      type(problem_t), intent(in) :: m
      allocate (rest%divergence(ndim, m%grid%n_points), source=0.0_dp)
   end function rest

   !> J and K, in one column a radius.
   function integrals(m, direction, half, radius, state) result(found)
      type(problem_t), intent(in) :: m
      real(dp), intent(in) :: direction(ndim), radius(:)
      logical, intent(in) :: half
      type(nodal_state_t), intent(in) :: state
      real(dp) :: found(1 + modes, size(radius))
      type(tip_domain_t) :: domain
      type(integrals_t) :: of
      type(places_t) :: places
      domain = tip_domain_t(tip=tip, axes=frame_along(direction), half=half, thickness=thickness, material=m%materials(1), &
                            radius=radius, field=new_tip_field(m%materials(1), direction))
      call domain_integrals(domain, m, [real(dp) ::], m%particles, state, closed_faces_t(), places, of)
      found(1, :) = of%j
      found(2:, :) = of%k
   end function integrals

   !> Given fields of known factors: they are found, the better the more cells there are in a disc.
   subroutine known_factors(material, direction, half)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: direction(ndim)
      logical, intent(in) :: half
      integer, parameter :: cells(4) = [8, 16, 32, 64]
      real(dp), parameter :: radius(2) = [0.48_dp, 0.3_dp]
      real(dp) :: k(modes), found(1 + modes, size(radius)), expected(1 + modes), error(1 + modes, size(cells))
      type(problem_t) :: m
      integer :: n
      k = k_known
      if (half) k(2) = 0
      expected = [sum(k**2)/material%plane_modulus(), k]
      do n = 1, size(cells)
         call place_square(material, cells(n), direction, half, m)
         call open_crack(m, direction, k)
         found = integrals(m, direction, half, radius, rest(m))
         error(:, n) = (found(:, 1) - expected)/[expected(1), expected(2), expected(2)]
      end do
      write (*, '(a,2f5.1,2l2,a,*(3es10.2,:," |"))') 'direction', direction, half, material%plane_stress, &
         ': errors of J, K_I, K_II in discs of 4, 8, 15 and 31 cells', error
      call check(all(abs(error(:, 1)) < 1.0e-3_dp), 'J and K are found by discs of few cells')
      call check(all(abs(error(:, 2:)) < 1.0e-4_dp), 'and better by discs of more')
      call check(maxval(abs(found(:, 2)/found(:, 1) - 1), abs(expected) > 0) < 1.0e-4_dp, 'from any disc the same')
   end subroutine known_factors

   !> Discs of few cells: printed, with a bound.
   subroutine factors_by_radius()
      integer, parameter :: cells = 12
      real(dp), parameter :: radius(7) = [2.0_dp, 2.5_dp, 3.0_dp, 3.5_dp, 4.0_dp, 4.5_dp, 5.0_dp]*edge/cells
      real(dp) :: found(1 + modes, size(radius)), expected(1 + modes)
      type(problem_t) :: m
      integer :: n
      expected = [sum(k_known**2)/strain%plane_modulus(), k_known]
      call place_square(strain, cells, directions(:, 1), .false., m)
      call open_crack(m, directions(:, 1), k_known)
      found = integrals(m, directions(:, 1), .false., radius, rest(m))
      do n = 1, size(radius)
         write (*, '(a,f4.1,a,3es10.2)') 'disc of', cells*radius(n)/edge, ' cells: errors of J, K_I, K_II', &
            found(:, n)/expected - 1
      end do
      call check(maxval(abs(found(1, :)/expected(1) - 1)) < 0.02_dp, 'J is found from discs of two cells on')
      call check(maxval(abs(found(1, 2:)/expected(1) - 1)) < 1.0e-3_dp, 'and well from discs of more')
   end subroutine factors_by_radius

   !> In a mesh with cells of three sizes around the tip it is the particles in the disc that count.
   subroutine factors_in_a_refined_mesh()
      real(dp), parameter :: radius(2) = [0.3_dp, 0.45_dp]
      real(dp) :: found(1 + modes, size(radius)), expected(1 + modes)
      type(problem_t) :: m
      type(forest_t) :: forest
      type(failure_t) :: failure
      integer :: n
      call place_square(strain, 12, directions(:, 1), .false., m)
      call start(m, 'musl')
      forest = m%grid%forest
      call refine_box(forest, tip - 0.12_dp, tip + 0.12_dp, 2)
      call adopt_forest(m, forest, failure)
      call check(.not. failure%failed() .and. m%grid%dofs%n_hanging > 0, 'the mesh is refined around the tip')
      call open_crack(m, directions(:, 1), k_known)
      expected = [sum(k_known**2)/strain%plane_modulus(), k_known]
      found = integrals(m, directions(:, 1), .false., radius, rest(m))
      do n = 1, size(radius)
         write (*, '(a,3es10.2)') 'refined mesh: errors of J, K_I, K_II', found(:, n)/expected - 1
         call check(maxval(abs(found(:, n)/expected - 1)) < 5.0e-3_dp, 'J and K are found in a refined mesh')
      end do
   end subroutine factors_in_a_refined_mesh

   !> Two plane waves that cross, without a crack: J vanishes for every disc to discretisation error, since the inertia of the
   !> material is in it. Damping changes nothing: what enters is the divergence of the stress, not the acceleration.
   subroutine waves(material, direction, damping_rate)
      type(material_t), intent(in) :: material
      real(dp), intent(in) :: direction(ndim)
      real(dp), intent(in) :: damping_rate       !! [1/s]
      integer, parameter :: cells(3) = [10, 20, 40]
      real(dp), parameter :: radius(2) = [0.45_dp, 0.3_dp]
      real(dp) :: found(1 + modes, size(radius)), still(1 + modes, size(radius)), damped(1 + modes, size(radius))
      real(dp) :: error(size(radius), size(cells)), order
      type(problem_t) :: m
      type(nodal_state_t) :: state
      type(failure_t) :: failure
      integer :: n
      do n = 1, size(cells)
         call place_square(material, cells(n), direction, .false., m)
         call start(m, 'musl')
         m%damping_rate = damping_rate
         call set_waves(m)
         call find_nodal_state(m, state, failure)
         call check(.not. failure%failed(), 'there is a nodal state')
         found = integrals(m, direction, .false., radius, state)
         damped = integrals(m, direction, .false., radius, nodal_state_t(state%divergence - damping_rate*nodal_velocity(m)))
         still = integrals(m, direction, .false., radius, nodal_state_t(0*state%divergence))
         error(:, n) = abs(found(1, :)/still(1, :))
      end do
      order = log(maxval(error(:, 2))/maxval(error(:, 3)))/log(2.0_dp)
      write (*, '(2a,es9.1,a,*(2es9.1,:," |"))') trim(merge('stress', 'strain', material%plane_stress)), ', damping', &
         damping_rate, ': J of waves over that without inertia', error
      write (*, '(a,f5.2,a,es9.1)') '   order', order, ', with the acceleration instead', damped(1, 1)/still(1, 1)
      call check(maxval(error(:, 3)) < 0.02_dp, 'waves without a crack have no J')
      call check(order > 1.8_dp, 'to the second order of the cell')
      call check(abs(still(1, 1) - still(1, 2)) > 0.2_dp*maxval(abs(still(1, :))), 'without inertia J depends on the disc')
      if (damping_rate > 0) call check(abs(damped(1, 1)/still(1, 1)) > 10*maxval(error(:, 3)), &
                                       'the acceleration of a damped motion would not do')
   end subroutine waves

   !> A plate that is bent across the line of a crack while pressed together, so that the crack is not felt: it has no K_I, if the
   !> integral knows how the faces press on each other.
   subroutine pressed_faces(direction)
      real(dp), intent(in) :: direction(ndim)
      integer, parameter :: cells(3) = [10, 20, 40]
      real(dp), parameter :: radius(2) = [0.45_dp, 0.3_dp], pressure = 1.0e5_dp ! [Pa]
      real(dp) :: found(1 + modes, size(radius)), error(size(radius), size(cells)), unaware
      real(dp) :: axes(ndim, ndim), x(ndim), h(ndim, ndim)
      type(problem_t) :: m
      type(line_t) :: line
      integer :: n, i
      axes = reshape([direction, -direction(2), direction(1)], [ndim, ndim])
      line%points = reshape([tip - 2*edge*direction, tip], [ndim, 2])
      line%is_tip = [.false., .true.]
      line%contact = .true.
      do n = 1, size(cells)
         call place_square(stress, cells(n), direction, .false., m, [line])
         m%interfaces%are_moving = .false.       ! the layer hardly gives way
         call start(m, 'musl')
         associate (p => m%particles, strain_0 => -pressure/stress%young)
            do i = 1, p%n
               x = matmul(p%reference(i, :) - tip, axes)
               h(:, 1) = strain_0*[-stress%poisson*(1 - x(1)), -x(2)]
               h(:, 2) = strain_0*[x(2), 1 - x(1)]
               p%gradient(i, :, :) = matmul(matmul(axes, h), transpose(axes))
            end do
         end associate
         found = integrals(m, direction, .false., radius, rest(m))
         unaware = minval(abs(found(2, :)))
         do i = 1, m%interfaces%n
            associate (point => m%interfaces%list(i))
               point%opening = -pressure*(1 + norm2(point%place - tip))*thickness*point%length/point%stiffness*point%normal
            end associate
         end do
         found = integrals(m, direction, .false., radius, rest(m))
         error(:, n) = abs(found(2, :))/(pressure*sqrt(pi*radius))
         call check(maxval(abs(found(3, :))) < 1.0e-10_dp*unaware, 'pressed faces have no K_II')
         call check(maxval(abs(found(1, :))) < 1.0e-4_dp*unaware**2/stress%young, 'and no J')
      end do
      write (*, '(a,*(2es9.1,:," |"))') 'K_I of pressed faces over that of the pressure', error
      call check(unaware > 0.3_dp*pressure*sqrt(pi*minval(radius)), 'K_I is one of the pressure where it is not known')
      call check(maxval(error(:, 3)) < 3.0e-4_dp, 'pressed faces have no K_I')
      call check(maxval(error(:, 3)) < maxval(error(:, 2))/2, 'to more than the first order of the cell')
   end subroutine pressed_faces

   !> A wave along the crack in a material without Poisson's ratio leaves its faces free of traction: it has no K. (Other waves
   !> do not know of a crack and have tractions on its faces.)
   subroutine wave_along_the_crack()
      integer, parameter :: cells(3) = [10, 20, 40]
      real(dp), parameter :: radius(2) = [0.45_dp, 0.3_dp], number = 7.0_dp, amplitude = 1.0e-7_dp
      real(dp) :: found(1 + modes, size(radius)), still(1 + modes, size(radius)), error(size(radius), size(cells))
      type(problem_t) :: m
      type(nodal_state_t) :: state
      type(failure_t) :: failure
      integer :: n
      do n = 1, size(cells)
         call place_square(new_material('', 'linear_elastic', .false., 70.0e9_dp, 0.0_dp, 2700.0_dp), cells(n), directions(:, 1), &
                           .false., m)
         m%particles%gradient(:, 1, 1) = amplitude*number*cos(number*m%particles%reference(:, 1))
         call start(m, 'musl')
         call find_nodal_state(m, state, failure)
         call check(.not. failure%failed(), 'there is a nodal state')
         found = integrals(m, directions(:, 1), .false., radius, state)
         still = integrals(m, directions(:, 1), .false., radius, rest(m))
         error(:, n) = maxval(abs(found(2:, :)), 1)/maxval(abs(still(2:, :)), 1)
      end do
      write (*, '(a,*(2es9.1,:," |"))') 'K of a wave along the crack over that without inertia', error
      call check(maxval(error(:, 3)) < 0.02_dp, 'a wave along the crack has no K')
      call check(maxval(error(:, 3)) < maxval(error(:, 2))/3, 'to the second order of the cell')
   end subroutine wave_along_the_crack

   !> A dilatational and a shear wave, each travelling in a direction of its own, as the particles have them at an instant.
   subroutine set_waves(m)
      type(problem_t), intent(inout) :: m
      real(dp), parameter :: amplitude = 1.0e-7_dp, number = 7.0_dp ! [m], [1/m]
      real(dp), parameter :: ways(ndim, 2) = reshape([0.8_dp, 0.6_dp, -0.28_dp, 0.96_dp], [ndim, 2])
      real(dp) :: speed(2), motion(ndim, 2), phase
      type(failure_t) :: failure
      integer :: i, w, a
      speed = [m%materials(1)%dilatational_wave_speed(), m%materials(1)%shear_wave_speed()]
      motion = reshape([ways(:, 1), -ways(2, 2), ways(1, 2)], [ndim, 2])
      associate (p => m%particles)
         do i = 1, p%n
            p%displacement(i, :) = 0
            p%gradient(i, :, :) = 0
            p%velocity(i, :) = 0
            do w = 1, size(speed)
               phase = number*dot_product(ways(:, w), p%reference(i, :)) + w
               p%displacement(i, :) = p%displacement(i, :) + amplitude*sin(phase)*motion(:, w)
               p%velocity(i, :) = p%velocity(i, :) - amplitude*number*speed(w)*cos(phase)*motion(:, w)
               do a = 1, ndim
                  p%gradient(i, :, a) = p%gradient(i, :, a) + amplitude*number*cos(phase)*ways(a, w)*motion(:, w)
               end do
            end do
         end do
         call sort_into_cells(m%cache%sorting, p, m%grid, m%blocks, failure)
      end associate
      call check(.not. failure%failed(), 'the waves stay in the grid')
      m%cache%mapped = .false.
   end subroutine set_waves

   !> A cracked body that has turned by a large angle has the J of one that has not, in either frame.
   subroutine turned_crack(total_frame)
      logical, intent(in) :: total_frame
      real(dp), parameter :: angle = 0.4_dp, radius(2) = [0.3_dp, 0.45_dp]
      real(dp) :: rotation(ndim, ndim), found(1 + modes, size(radius)), expected
      type(problem_t) :: m
      type(failure_t) :: failure
      integer :: i
      rotation = reshape([cos(angle), sin(angle), -sin(angle), cos(angle)], [ndim, ndim])
      call place_bodies(forest_t([-0.5_dp, -0.5_dp], 0.05_dp, [40, 40]), rubber, &
                        [rectangle_t([0.0_dp, 0.0_dp], [edge, edge], [40, 40])], m)
      allocate (m%loads(0))
      call open_crack(m, directions(:, 1), k_known)
      associate (p => m%particles)
         do i = 1, p%n
            p%gradient(i, :, :) = matmul(rotation, identity + p%gradient(i, :, :)) - identity
            p%displacement(i, :) = matmul(rotation - identity, p%reference(i, :) - tip)
         end do
         p%total_frame = total_frame
         call sort_into_cells(m%cache%sorting, p, m%grid, m%blocks, failure)
      end associate
      call check(.not. failure%failed(), 'the turned body is in the grid')
      found = integrals(m, directions(:, 1), .false., radius, rest(m))
      expected = sum(k_known**2)/rubber%plane_modulus()
      write (*, '(a,l2,a,*(es10.2))') 'turned crack, total frame', total_frame, ': errors of J', found(1, :)/expected - 1
      call check(maxval(abs(found(1, :)/expected - 1)) < 1.0e-2_dp, 'a turned crack has the J of one that has not turned')
   end subroutine turned_crack

   !> The modes share J as the squares of K do, with the signs of K.
   subroutine shares()
      real(dp) :: g(modes)
      g = shares_of_modes(new_tip_field(stress, directions(:, 1)), 10.0_dp, [-3.0_dp, 1.0_dp])
      call check_close(g(1), -9.0_dp, 1.0e-14_dp, 'a mode has its share of J, signed like its K')
      call check_close(sum(abs(g)), 10.0_dp, 1.0e-14_dp, 'and the shares add up to J')
      call check_close(maxval(abs(shares_of_modes(new_tip_field(stress, directions(:, 1)), 0.0_dp, [0.0_dp, 0.0_dp]))), 0.0_dp, &
                       0.0_dp, 'nothing is shared at rest')
   end subroutine shares

   !> A body that has turned by a large angle, and turns and drifts: its J is next to nothing beside its kinetic energy.
   subroutine rigid_motion()
      real(dp), parameter :: angle = 0.4_dp, spin = 3.0_dp, drift(ndim) = [5.0_dp, -2.0_dp], radius(2) = [0.3_dp, 0.45_dp]
      real(dp) :: rotation(ndim, ndim), x(ndim), found(1 + modes, size(radius)), scale
      type(problem_t) :: m
      type(nodal_state_t) :: state
      type(failure_t) :: failure
      integer :: i
      rotation = reshape([cos(angle), sin(angle), -sin(angle), cos(angle)], [ndim, ndim])
      call place_bodies(forest_t([-0.5_dp, -0.5_dp], 0.05_dp, [40, 40]), rubber, &
                        [rectangle_t([0.0_dp, 0.0_dp], [edge, edge], [40, 40])], m)
      allocate (m%loads(0))
      associate (p => m%particles)
         do i = 1, p%n
            x = matmul(rotation, p%reference(i, :) - tip)
            p%gradient(i, :, :) = rotation - identity
            p%displacement(i, :) = x + tip - p%reference(i, :)
            p%velocity(i, :) = drift + spin*[-x(2), x(1)]
         end do
         call sort_into_cells(m%cache%sorting, p, m%grid, m%blocks, failure)
         scale = 0.5_dp*rubber%density*maxval(sum(p%velocity**2, 2))*maxval(radius)
      end associate
      call check(.not. failure%failed(), 'the turned body is in the grid')
      call start(m, 'musl')
      call find_nodal_state(m, state, failure)
      found = integrals(m, directions(:, 1), .false., radius, state)
      write (*, '(a,*(es9.1))') 'rigid motion: J over kinetic energy density times radius', found(1, :)/scale
      call check(maxval(abs(found(1, :))) < 1.0e-3_dp*scale, 'rigid motion has no J')
   end subroutine rigid_motion
end program test_domain_integral
