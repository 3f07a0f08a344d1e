!> Checks, at every sample, that the numbers of a run are still valid.
!>
!> The check whether a piece of a cell, cut off by a crack or the edge of a body, is nearly loose: then the load on it has strained
!> it far more than the cells beside it, and results that depend on it are invalid. The measure does not depend on the cause: in a
!> firm piece strains are those beside it up to a factor of its place (2.6 in slivers at rings under pressure); loose ones have
!> hundreds of times these.
module hampm_run_time_checks
   use hampm_kinds, only: dp, long, name_len, ndim
   use hampm_tensors, only: norm
   use hampm_crack_tip, only: crack_tip_t
   use hampm_interface_points, only: is_pressed
   use hampm_crack_lines, only: both_faces
   use hampm_face_jumps, only: faces, faces_at, turn_between
   use hampm_crack_groups, only: crack_spec_t
   use hampm_cracks, only: crack_t
   use hampm_domains, only: is_tangled
   use hampm_energy, only: energy_density_of, angular_momentum, n_turns, largest_gradient, largest_strain, most_crushed_particle, &
                           stretches_of, liveliest_particle, determinant_of, largest_displacement
   use hampm_failure, only: failure_t, exit_computation
   use hampm_linear_elastic, only: small_gradient
   use hampm_loads, only: work_of_step
   use hampm_measurements, only: measurements_t, energy_residual
   use hampm_problem, only: problem_t
   use hampm_particles, only: spacing_of
   use hampm_patch, only: patch_t, patch_around, fitted_displacement
   use hampm_text, only: add_line, to_text, three_digits, point_text
   use hampm_error_context, only: origin
   use hampm_ghost_penalty, only: fills_of_pieces
   implicit none
   private
   public :: check_state, check_tip, check_step, check_faces, check_modes, check_normals, check_rest

   real(dp), parameter :: most = 20              !! strain of a piece over the largest beside it
   real(dp), parameter :: firm = 0.5_dp          !! part of a cell from which on a piece is firm: an incoming wave strains it first

   ! Within the limit of the time step the energy swings, as velocity and strain are half a step apart: near the limit by 11 % of
   ! the stored energy, with zero mean (docs/evidence/stability.md). A larger gain is reported. Half of the largest energy exceeds
   ! any swing: an unstable run, which multiplies its energy in a few steps, is soon there, a stable one never.
   real(dp), parameter :: largest_gain = 0.5_dp  !! of energy without work, over the largest energy so far [-]
   ! The limit of bodies whose edges cut cells is found on a sample of such cells: others are nearer to it, and swing by more
   real(dp), parameter :: largest_gain_of_shapes = 0.9_dp
   real(dp), parameter :: noticed_gain = 0.1_dp  !! gain or loss over the largest energy of deformation and work, to report [-]
   real(dp), parameter :: noticed_error = 0.1_dp !! of the strain energy that stretched material may have in it, to be reported [-]
   real(dp), parameter :: rounding = 1e-9_dp     !! part of the largest energy that a long run may gain by rounding [-]
   real(dp), parameter :: turned_by_contact = 0.01_dp !! the same by bodies that meet
   real(dp), parameter :: noticed_turn = 0.1_dp  !! change of the angular momentum without cause, over its possible size [-]
   real(dp), parameter :: far_and_strained = 0.05_dp !! cells travelled times strain, to be reported [-]
   real(dp), parameter :: most_strain = 0.1_dp   !! that counts then [-]
   real(dp), parameter :: noticed_residual = 0.01_dp !! of the largest energy: error of the balance to be reported [-]
   real(dp), parameter :: noticed_release = 1e-6_dp !! of the largest energy, by a cell of a crack that is loaded [-]
   real(dp), parameter :: hardly = 1e-12_dp      !! of the kinetic energy: what is rounding of it [-]
   real(dp), parameter :: noticed_part = 0.05_dp !! of the load that a single node may carry, to be reported [-]
   real(dp), parameter :: modest_strain = 0.05_dp !! around a tip, up to which K**2/E' is J to 4 %, to be reported [-]
   real(dp), parameter :: absurd_gradient = 10   !! of the displacement, which neither rotations nor materials have [-]
   real(dp), parameter :: largest_turn = 0.1_dp  !! of faces that press on each other, up to which their normals are right [rad]
   character(*), parameter :: strained = 'a displacement gradient has reached ', gained = 'the energy has grown by ', &
                              fallen = 'the energy has fallen by ', &
                              by_meeting = 'bodies that meet have changed their angular momentum by ', &
                              slowed = 'the angular momentum has changed by ', &
                              mixed = 'valid for small strain only', &
                              overlapped = ' interpenetrate, ', &
                              travelled = 'strained material has travelled through the cells', &
                              unbalanced = 'the energy balance has an error of ', &
                              carried = 'the tip of a crack away from its node', &
                              resting = 'the loads have done no work', &
                              lone = 'the single held node at ', &
                              flown = 'the material has carried a crack through the cells', &
                              crossed = 'stretched material has passed from cell to cell'

contains

   !> Fail where material is inverted, an energy is NaN or has grown without work, by more than rounding. Add to `warning` where it
   !> has grown less, and where a law, a frame or a mass matrix is used beyond its range.
   subroutine check_state(problem, time, measurements, warning, failure)
      type(problem_t), intent(in) :: problem
      character(*), intent(in) :: time           !! how it steps: 'explicit', 'implicit' or 'static'
      type(measurements_t), intent(in) :: measurements
      character(:), allocatable, intent(inout) :: warning
      type(failure_t), intent(inout) :: failure
      real(dp) :: gain, stored, largest
      integer :: crushed
      stored = measurements%kinetic_energy + measurements%strain_energy
      gain = stored + measurements%plastic_dissipation + measurements%viscous_dissipation + problem%energies%damping_loss &
             + problem%energies%absorbed_energy - problem%energies%external_work - measurements%initial_energy &
             - uncertain_work(problem)
      if (allocated(problem%state%velocity)) gain = min(gain, 0.0_dp) ! they overshoot stably (docs/explanation/implicit.md)
      largest = merge(largest_gain_of_shapes, largest_gain, allocated(problem%grid%bodies))
      crushed = most_crushed_particle(problem%particles, problem%materials)
      if (crushed > 0) then
         if (.not. determinant_of(problem%particles, crushed) > 0) then
            call failure%report(exit_computation, problem%state%when()//'the material that started at '// &
                                origin(problem%grid, problem%particles, crushed)// &
                                ' is turned inside out (det F = '//to_text(determinant_of(problem%particles, crushed))// &
                                '). Likely cause: a load is too large for the material: reduce it'//or_unstable(time))
            return
         end if
      end if
      if (problem%has_domains()) call check_domains(problem, time, failure)
      if (failure%failed()) return
      if (.not. stored <= huge(stored)) then
         call failure%report(exit_computation, problem%state%when()// &
                             'the energy of the material that started at '//liveliest(problem)// &
                             ' is no longer a number'//of_step(problem, time))
      else if (time == 'explicit' .and. gain > max(largest*max(measurements%largest_energy, measurements%initial_energy), &
                                                   measurements%rounding_energy)) then
         call failure%report(exit_computation, problem%state%when()//'the energy has grown by '//three_digits(gain)// &
                             ' J more than the loads have done work; most of it is near the particle that started at '// &
                             liveliest(problem)//of_step(problem, time))
      else
         call check_energy_gain(problem, time, measurements, gain, warning)
         call check_energy_loss(problem, time, measurements, warning)
         call check_energy_balance(problem, time, measurements, warning)
         call check_strain(problem, warning)
         call check_stretch(problem, measurements, warning)
         call check_travel(problem, measurements, warning)
         call check_flight(problem, measurements, warning)
         call check_angular_momentum(problem, measurements, warning)
         if (measurements%lone_part > noticed_part) &
            call warn(problem%state%when()//lone//point_text(measurements%lone_place)//' m carries '// &
                      three_digits(100*measurements%lone_part)//' % of the load. It gives way the more the smaller its cells '// &
                      'are: displacements, energies and G depend on them, and no estimated error knows of it. Hold or move a '// &
                      'part of an edge, some cells long', lone, warning)
         if (any(measurements%crack%has_left_node)) &
            call warn(problem%state%when()//'the material has carried '//carried//': ''vcct'' and ''stress_closure'' '// &
                      'are not numbers from now on. Use &energy_release estimators = ''domain_integral'', or '// &
                      '&method frame = ''total''', carried, warning)
      end if
      if (.not. problem%interfaces%are_bounded .and. .not. failure%failed()) call check_pieces(problem, failure)
   end subroutine check_state

   !> Fail where a time step is too small to be added to the time.
   subroutine check_step(problem, step, failure)
      type(problem_t), intent(in) :: problem
      real(dp), intent(in) :: step               !! the longest that is stable [s]
      type(failure_t), intent(inout) :: failure
      if (step > 4*spacing(problem%state%time)) return
      call failure%report(exit_computation, problem%state%when()//'the time step, '//three_digits(step)// &
                          ' s, is too small to be added to the time. Likely cause: cells have become too small; reduce &refine '// &
                          'max_level, or the end time')
   end subroutine check_step

   !> Warn, once, where energy has grown without work by a notable part of the stored energy. The motion of the bodies as a whole is
   !> no measure: its energy would hide any gain of the material in flight.
   subroutine check_energy_gain(problem, time, measurements, gain, warning)
      type(problem_t), intent(in) :: problem
      character(*), intent(in) :: time
      type(measurements_t), intent(in) :: measurements
      real(dp), intent(in) :: gain               !! [J]
      character(:), allocatable, intent(inout) :: warning
      character(:), allocatable :: cause
      if (gain <= noticed_gain*measurements%largest_inner_energy) return
      if (gain <= rounding*max(measurements%largest_energy, measurements%initial_energy)) return
      if (gain <= measurements%rounding_energy) return
      if (time == 'explicit') then
         cause = 'the time step is near or beyond its limit; reduce &method courant'//other_scheme(problem)
      else                                       ! equilibrium has no steps: the work is of another mesh
         cause = 'new nodes of finer cells are constrained after they have moved, or '// &
                 'the load steps are too long for the law: the state is in balance, and external_work is not its work. '// &
                 'Give boxes of a &constraint that end on nodes, or more &method load_steps'
      end if
      call warn(problem%state%when()//gained//three_digits(gain)//' J more than the loads have done work'// &
                of_stored(gain, measurements)//'. Likely cause: '//cause, gained, warning)
   end subroutine check_energy_gain

   !> Warn, once, where energy has been lost by a notable part of the stored energy, also where the energy balance books it: usl
   !> damps waves of few cells, and cells that recombine average velocities.
   subroutine check_energy_loss(problem, time, measurements, warning)
      type(problem_t), intent(in) :: problem
      character(*), intent(in) :: time
      type(measurements_t), intent(in) :: measurements
      character(:), allocatable, intent(inout) :: warning
      real(dp) :: lost                           ! [J]
      if (time /= 'explicit') return
      ! With a damping x a step its loss, x m v^n.v^(n+1), is 1 - x of x m v^n.v^n, and what the velocity loses 1 - x/2 of it
      associate (a_step => problem%damping_rate*problem%state%time/max(problem%state%steps, 1_long))
         if (a_step >= 1) return
         lost = missing_energy(problem, measurements) - uncertain_work(problem) &
                - problem%energies%damping_loss*a_step/(2*(1 - a_step))
      end associate
      if (lost <= noticed_gain*max(measurements%largest_inner_energy, problem%energies%damping_loss)) return
      if (lost <= max(rounding*max(measurements%largest_energy, measurements%initial_energy), measurements%rounding_energy)) return
      call warn(problem%state%when()//fallen//three_digits(lost)//' J more than work and dissipation tell'// &
                of_stored(lost, measurements)//': vibrations are too small. Likely cause: waves of few cells are damped, as by '// &
                'cells that recombine; use smaller &grid cell'//other_scheme(problem), fallen, warning)
   end subroutine check_energy_loss

   !> An energy as a part of what the material stores, if that is not 0.
   function of_stored(energy, measurements) result(text)
      real(dp), intent(in) :: energy             !! [J]
      type(measurements_t), intent(in) :: measurements
      character(:), allocatable :: text
      text = ''
      if (measurements%largest_inner_energy > 0) &
         text = ', '//three_digits(100*energy/measurements%largest_inner_energy)//' % of what the material stores'
   end function of_stored

   !> What the energies of a run lack of the work on it and its first energy, also what the energy balance books as lost [J].
   pure real(dp) function missing_energy(problem, measurements) result(missing)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(in) :: measurements
      missing = energy_residual(problem, measurements)*measurements%largest_energy + problem%energies%numerical_loss
   end function missing_energy

   !> Work that a step may have too much or too little: half of that of prescribed motion waits for the next step's forces [J].
   pure real(dp) function uncertain_work(problem) result(work)
      type(problem_t), intent(in) :: problem
      work = abs(problem%energies%prescribed%work) &
             + work_of_step(problem%loads, problem%particles, problem%state%time, problem%state%last_dt)
   end function uncertain_work

   !> Warn, once, where the energy balance has an error of a notable part of the energy: the work on a particle in a step is by the
   !> mean of its stresses before and after, wrong where one step strains it by much, as a node with next to no mass does with usl.
   subroutine check_energy_balance(problem, time, measurements, warning)
      type(problem_t), intent(in) :: problem
      character(*), intent(in) :: time
      type(measurements_t), intent(in) :: measurements
      character(:), allocatable, intent(inout) :: warning
      real(dp) :: residual
      if (.not. problem%audit .or. time /= 'explicit') return ! in equilibrium the residual is booked as the loss
      residual = abs(energy_residual(problem, measurements))
      if (residual <= noticed_residual) return
      call warn(problem%state%when()// &
                unbalanced//three_digits(100*residual)//' % of the largest energy. Likely cause: a step was '// &
                'too long for some material; reduce &method courant'//other_scheme(problem), unbalanced, warning)
   end subroutine check_energy_balance

   !> Fail where the domain of a particle is turned over at a corner: its material would be in two places, and in one twice.
   subroutine check_domains(problem, time, failure)
      type(problem_t), intent(in) :: problem
      character(*), intent(in) :: time
      type(failure_t), intent(inout) :: failure
      integer :: i
      do i = 1, problem%particles%n
         if (.not. is_tangled(problem%particles, i)) cycle
         call failure%report(exit_computation, problem%state%when()//'the domain of the particle that started at '// &
                             origin(problem%grid, problem%particles, i)//' is turned over at a corner. Likely cause: the '// &
                             'material is sheared further than its domains follow: give &body more points_per_cell'// &
                             or_unstable(time))
         return
      end do
   end subroutine check_domains

   !> Warn, once, where material is stretched through the cells of the grid, so that its energy can be wrong by a notable part.
   !> Its particles carry the stress to the nodes, however many of them stand in a cell: that number is now one too large and now
   !> one too small for the stretch, and as the force that passes is the same everywhere, the stress jumps from cell to cell. With n
   !> particles in a row of a cell the energy of a stretch s is off by up to 4 (s - 1)/n (docs/evidence/stability.md).
   subroutine check_stretch(problem, measurements, warning)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(in) :: measurements
      character(:), allocatable, intent(inout) :: warning
      real(dp) :: uncertain, off                 ! energy that may be wrong [J], and relative error of a particle's [-]
      real(dp) :: start(ndim)                    ! where a particle started [m]
      logical :: crosses
      integer :: i
      if (is_reported(crossed, warning)) return
      associate (p => problem%particles, laws => problem%materials)
         if (p%total_frame .or. problem%has_domains() .or. .not. any(laws%is_finite)) return
         uncertain = 0
         crosses = .false.
         do i = 1, p%n
            if (.not. laws(p%material(i))%is_finite) cycle
            off = min(1.0_dp, 4*(maxval(stretches_of(p, i)) - 1)*spacing_in_cell(problem, i))
            if (off < noticed_error/10) cycle
            uncertain = uncertain + off*p%volume(i)*energy_density_of(p, laws, i)
            start = p%reference(i, :)
            crosses = crosses .or. any(abs(problem%grid%local_coordinate(p%cell(i), start) - 0.5_dp) > 0.5_dp)
         end do
      end associate
      if (.not. crosses .or. uncertain <= noticed_error*measurements%strain_energy) return
      call warn(problem%state%when()// &
                crossed//', and its stresses and energies may be wrong by more than a tenth. Likely cause: cells hold too '// &
                'many or too few particles for the stretch; use &method frame = ''total'' or more &body points_per_cell', &
                crossed, warning)
   end subroutine check_stretch

   !> Warn, once, where strained material has travelled through so many cells of the updated frame that the forces which it loses
   !> and gains at their edges are likely to add up: bilinear functions have other gradients in the next cell, and a particle that
   !> crosses carries its stress over at once. The measure is the mean of strain times cells, weighted with the strain energy: a
   !> cantilever that bends by 0.6 of its length sank too far by 30 and 35 % at 0.10 and 0.18 (4 and 8 cells over its depth), a
   !> pressed block that turns stored 35 % too much at 0.05. Of more than a tenth of strain a tenth counts: a bar that is shortened
   !> by 0.3 was off by 3.2 %.
   subroutine check_travel(problem, measurements, warning)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(in) :: measurements
      character(:), allocatable, intent(inout) :: warning
      real(dp) :: product, cells
      integer :: i
      associate (p => problem%particles)
         if (p%total_frame .or. problem%has_domains()) return
         if (.not. measurements%strain_energy > 0 .or. is_reported(travelled, warning)) return
         if (maxval(abs(p%displacement(:p%n, :))) < problem%grid%finest_cell) return
         product = 0
         do i = 1, p%n
            cells = norm(p%displacement(i, :))/problem%grid%element_size(p%cell(i))
            if (cells < 1) cycle
            product = product + cells*min(largest_strain(p, i), most_strain)*p%volume(i) &
                      *energy_density_of(p, problem%materials, i)
         end do
      end associate
      if (product <= far_and_strained*measurements%strain_energy) return
      call warn(problem%state%when()// &
                travelled//', '//three_digits(product/measurements%strain_energy)//' cells times strain in the mean: '// &
                'forces that are lost and gained at the edges of cells may make stresses, energies and displacements wrong by '// &
                'tens of percent, and finer cells make it worse. Use &method frame = ''total'' where bodies '// &
                'do not have to come into contact', travelled, warning)
   end subroutine check_travel

   !> Warn, once, where a loaded crack was carried through cells, cut anew as it goes, by more than half of one: J of a plate that
   !> flies at 10, 30, 72 m/s is then 15, 20, 28 % too large, later up to 2.3 times. Without G the energy balance tells.
   subroutine check_flight(problem, measurements, warning)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(in) :: measurements
      character(:), allocatable, intent(inout) :: warning
      real(dp) :: far                            ! that it has been carried [m]
      real(dp) :: missing                        ! [J]
      real(dp) :: rounding                       ! of energies, also by that of the flight [J]
      real(dp) :: noticed_rate                   ! [J/m2]
      integer :: k
      if (problem%particles%total_frame .or. is_reported(flown, warning)) return
      far = 0
      associate (lines => problem%grid%cut_cells%lines)
         if (.not. allocated(problem%grid%cut_cells%lines)) return
         do k = 1, size(lines)
            if (allocated(lines(k)%origin)) far = max(far, maxval(sqrt(sum((lines(k)%points - lines(k)%origin)**2, dim=1))))
         end do
         if (far <= problem%grid%finest_cell/2) return
         missing = abs(missing_energy(problem, measurements)) - uncertain_work(problem)
         noticed_rate = noticed_release*measurements%largest_inner_energy &
                        /(problem%grid%finest_cell*problem%particles%thickness%at(lines(1)%points(:, 1)))
      end associate
      missing = max(missing, 0.0_dp)
      rounding = max(measurements%rounding_energy, hardly*measurements%kinetic_energy)
      if (.not. measurements%largest_inner_energy > rounding) return ! of a body without strain
      if (.not. (missing > max(noticed_residual*measurements%largest_inner_energy, rounding) &
                 .or. any(measurements%crack%g_of_k > noticed_rate))) return
      call warn(problem%state%when()//flown//', by '//three_digits(far/problem%grid%finest_cell)//' of their sizes, and '// &
                three_digits(missing)//' J are missing, '//three_digits(100*missing/measurements%largest_inner_energy)// &
                ' % of what it stores: G, J, K and energies may be wrong by tens of percent, J by a factor of two, as their '// &
                'estimated errors say. Use &method frame = ''total'' where bodies do not have to come into contact', flown, warning)
   end subroutine check_flight

   !> Distance between particles in the reference configuration over the size of the cell in which particle `i` stands [-].
   pure real(dp) function spacing_in_cell(problem, i)
      type(problem_t), intent(in) :: problem
      integer, intent(in) :: i
      real(dp) :: spacing(ndim)                  ! [m]
      associate (p => problem%particles)
         spacing = p%spacing(:, p%body(i))
         if (allocated(p%level)) spacing = spacing_of(p, i)
         spacing_in_cell = maxval(spacing)/problem%grid%element_size(p%cell(i))
      end associate
   end function spacing_in_cell

   !> Warn, once, where the material around a tip is strained so much that stress intensities and modes of a linear material differ
   !> from J: K**2/E' is 14 % off J where a specimen is stretched by 1.2, 33 % by 1.7. The measure is the root of the mean square,
   !> over the particles within the domains, of their largest strain.
   subroutine check_modes(problem, tip, warning)
      type(problem_t), intent(in) :: problem
      type(crack_tip_t), intent(in) :: tip
      character(:), allocatable, intent(inout) :: warning
      real(dp) :: square, off
      integer :: i, n
      if (size(tip%radii) == 0 .or. is_reported(mixed, warning)) return
      if (.not. problem%materials(tip%material)%is_finite) return
      square = 0
      n = 0
      associate (p => problem%particles)
         do i = 1, p%n
            if (norm(p%reference(i, :) - tip%place) > tip%radii(size(tip%radii))) cycle
            square = square + largest_strain(p, i)**2
            n = n + 1
         end do
      end associate
      off = sqrt(square/max(n, 1))
      if (off <= modest_strain) return
      call warn(problem%state%when()//'around the tip the strain has reached '//three_digits(100*off)// &
                ' %: K_I, K_II, mode_mixity and J by modes are '//mixed//'; J remains valid', mixed, warning)
   end subroutine check_modes

   !> Fail where faces of a path that press on each other have turned: contact keeps their first normals, and so would push and
   !> slide in wrong directions. At 0.1 rad it is off by a tenth of the pressure along the faces, and by half a percent of it.
   subroutine check_normals(problem, failure)
      type(problem_t), intent(in) :: problem
      type(failure_t), intent(inout) :: failure
      real(dp) :: turn, x(ndim), normal(ndim)
      integer :: k, elements(faces)
      associate (interfaces => problem%interfaces, blocks => problem%blocks)
         if (interfaces%n_contact == 0) return
         do k = 1, interfaces%n
            if (.not. is_pressed(interfaces%list(k))) cycle
            x = interfaces%list(k)%place
            normal = interfaces%list(k)%normal
            elements = faces_at(problem%matter_t, x, normal, both_faces)
            if (any(elements == 0)) cycle
            turn = turn_between(problem%matter_t, elements, normal)
            if (abs(turn) <= largest_turn) cycle
            call failure%report(exit_computation, problem%state%when()//'crack faces in contact '// &
                                'at '//point_text(x)//' m have turned by '// &
                                three_digits(turn)//' rad, and &crack contact has fixed normals: contact forces '// &
                                'are wrong beyond '//to_text(largest_turn)//' rad. Keep the body from turning, or load it less')
            return
         end do
      end associate
   end subroutine check_normals

   !> Warn of each crack whose faces have interpenetrated in the run.
   subroutine check_faces(measurements, cracks, planes, is_static, warning)
      type(measurements_t), intent(in) :: measurements
      type(crack_t), intent(in) :: cracks(:)
      type(crack_spec_t), intent(in) :: planes(:) !! cracks of solids
      logical, intent(in) :: is_static           !! whether the motion has reached static equilibrium
      character(:), allocatable, intent(inout) :: warning
      character(:), allocatable :: remedy, which
      character(name_len), allocatable :: names(:)
      logical, allocatable :: touch(:), are_halves(:)
      integer :: k
      names = [cracks%name, planes%name]
      touch = [cracks%contact, planes%contact]
      are_halves = [cracks%face /= both_faces, planes%kind == 'symmetry']
      do k = 1, size(names)
         associate (overlap => measurements%overlap(k))
            if (touch(k) .or. .not. overlap%is_notable(is_static)) cycle
            which = 'the faces of the crack'
            if (names(k) /= '') then
               which = which//' '''//trim(names(k))//''''
            else if (size(names) > 1) then
               which = which//' number '//to_text(k)
            end if
            remedy = '&crack contact = ''frictionless'''
            if (are_halves(k)) remedy = 'a whole body with a &crack of kind = ''plane'' and contact = ''frictionless'''
            call warn(which//overlapped//'by up to '//three_digits(overlap%overlap)//' m, '// &
                      three_digits(100*overlap%overlap/overlap%largest_jump)//' % of their largest relative displacement'// &
                      ', at '//three_digits(overlap%time)//' s: G and K then have no physical meaning. Use '// &
                      remedy, which//overlapped, warning)
         end associate
      end do
   end subroutine check_faces

   !> Warn, once, where the small-strain law is used beyond its range.
   subroutine check_strain(problem, warning)
      type(problem_t), intent(in) :: problem
      character(:), allocatable, intent(inout) :: warning
      character(:), allocatable :: advice
      real(dp) :: largest
      integer :: law
      largest = largest_gradient(problem%particles, problem%materials)
      if (largest <= small_gradient) return
      law = findloc(problem%materials%is_finite, .false., dim=1)
      advice = ''
      if (problem%materials(law)%linear) advice = '. Use law = ''neo_hookean'''
      if (largest > absurd_gradient) advice = '. Likely cause: a load, a length or a modulus in other units than m, N and Pa'
      call warn(problem%state%when()//strained//three_digits(largest)//'; the law '''//trim(problem%materials(law)%law_name)// &
                ''' is for small strains and rotations (below '//to_text(small_gradient)//')'//advice, strained, warning)
   end subroutine check_strain

   !> Warn, once, where the angular momentum of free bodies has changed. The lumped mass matrix keeps it only where particles stand
   !> evenly around nodes: at free edges they do not. Contact changes it too: an impulse and its reaction act at one node, but move
   !> the particles around it, whose middles are on either side of the surface.
   subroutine check_angular_momentum(problem, measurements, warning)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(in) :: measurements
      character(:), allocatable, intent(inout) :: warning
      real(dp) :: total(n_turns), largest
      if (size(problem%loads) > 0 .or. problem%damping_rate > 0 .or. size(problem%constraints%node) > 0) return
      if (problem%particles%thickness%is_ring) return ! rings have none
      call angular_momentum(problem%particles, total, largest)
      total = total - measurements%initial_angular_momentum
      if (problem%body_contact%loss + problem%body_contact%friction_loss > 0 .and. maxval(abs(total)) > turned_by_contact*largest) &
         call warn(problem%state%when()//by_meeting//to_text(total(maxloc(abs(total), dim=1)))//' kg m2/s, '// &
                   three_digits(100*maxval(abs(total))/largest)//' % of what the motion allows: impulses of nodes act beside '// &
                   'where bodies touch, by a part of a cell. Use smaller &grid cell', by_meeting, warning)
      if (maxval(abs(total)) <= noticed_turn*largest) return
      call warn(problem%state%when()// &
                slowed//to_text(total(maxloc(abs(total), dim=1)))//' kg m2/s without external forces, '// &
                'more than a tenth of what the motion allows. Likely cause: a turning body has few cells for its '// &
                'mass matrix; use smaller &grid cell or &method mass = ''consistent''', slowed, warning)
   end subroutine check_angular_momentum

   !> Warn where there are loads but no energy above rounding at any sample of a run, and nothing is elsewhere at its end.
   subroutine check_rest(problem, measurements, warning)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(in) :: measurements
      character(:), allocatable, intent(inout) :: warning
      real(dp), parameter :: little = 1e-8_dp    ! of a cell, which rounding does not move a body
      integer :: k
      if (.not. any([(norm(problem%loads(k)%force) > 0, k=1, size(problem%loads))])) return
      if (max(measurements%largest_energy, measurements%initial_energy) > measurements%rounding_energy) return
      if (largest_displacement(problem%particles) > little*problem%grid%forest%cell) return
      call warn('the loads have done no work, and nothing has moved. Likely cause: they cancel each other, push on what a '// &
                '&constraint holds, or their histories are 0 in all of the run', resting, warning)
   end subroutine check_rest

   !> Add a warning, unless one with the same phrase is there already.
   subroutine warn(text, phrase, warning)
      character(*), intent(in) :: text, phrase
      character(:), allocatable, intent(inout) :: warning
      if (.not. is_reported(phrase, warning)) call add_line(warning, text)
   end subroutine warn

   !> Whether a warning with a phrase is there.
   pure logical function is_reported(phrase, warning)
      character(*), intent(in) :: phrase
      character(*), intent(in) :: warning
      is_reported = index(warning, phrase) > 0
   end function is_reported

   !> Fail where the tip of a crack is no longer where it was in the material: it is fixed in the grid, and in the updated frame the
   !> material moves through that.
   subroutine check_tip(problem, tip, failure)
      type(problem_t), intent(in) :: problem
      type(crack_tip_t), intent(in) :: tip
      type(failure_t), intent(inout) :: failure
      type(patch_t) :: patch
      real(dp) :: moved(ndim)                    !! of the material at the tip [m]
      if (problem%particles%total_frame .or. .not. tip%is_half()) return ! others go with the material
      call patch_around(problem%grid, problem%particles, problem%blocks, tip%nodes%tip, patch)
      moved = fitted_displacement(patch, problem%particles)
      if (patch%n > 0 .and. norm(moved) <= tip%nodes%spacing) return
      call failure%report(exit_computation, problem%state%when()//'the material at the tip of the crack has moved '// &
                          'by more than a cell there, '//to_text(tip%nodes%spacing)//' m, and the crack, which is fixed in '// &
                          'the grid, is elsewhere in the material now. Likely cause: the body moves as a whole or deforms '// &
                          'much; use &method frame = ''total''')
   end subroutine check_tip

   !> Where the particle with the most energy started, for messages.
   function liveliest(problem) result(text)
      type(problem_t), intent(in) :: problem
      character(:), allocatable :: text
      text = origin(problem%grid, problem%particles, liveliest_particle(problem%particles, problem%materials))
   end function liveliest

   !> The likely cause of energy without a source, and a remedy, by the kind of steps.
   function of_step(problem, time) result(text)
      type(problem_t), intent(in) :: problem
      character(*), intent(in) :: time
      character(:), allocatable :: text
      text = '. Likely cause: '
      select case (time)
      case ('explicit')
         text = text//'the run is unstable: reduce &method courant, from steps of '// &
            three_digits(problem%state%last_dt)//' s now'// &
                other_scheme(problem)
      case ('implicit')
         text = text//'loads, or the motion by them, are too large for numbers, or the steps for the motion: reduce &method '// &
                'time_step, of '//three_digits(problem%state%last_dt)//' s now, or the loads'
      case default
         text = text//'loads, or the displacements by them, are too large for numbers: look at the units of loads and '// &
                '&material young'
      end select
   end function of_step

   !> The same as a second cause, where an unstable step may be one.
   pure function or_unstable(time) result(text)
      character(*), intent(in) :: time
      character(:), allocatable :: text
      text = ''
      if (time == 'explicit') text = '; or the run is unstable: reduce &method courant'
      if (time == 'implicit') text = '; or the steps are too long for the motion: reduce &method time_step'
   end function or_unstable

   !> A further advice where the scheme is the one that is known to be unstable.
   function other_scheme(problem) result(text)
      type(problem_t), intent(in) :: problem
      character(:), allocatable :: text
      text = ''
      if (problem%scheme%name == 'usl') text = ', or choose another &method scheme than ''usl'''
   end function other_scheme

   !> Fail where a piece is loose, and name the place.
   subroutine check_pieces(m, failure)
      type(problem_t), intent(in) :: m
      type(failure_t), intent(inout) :: failure
      real(dp), allocatable :: fill(:), strain(:)
      real(dp) :: beside
      integer :: i, e
      if (.not. any([(m%grid%is_cut(i), i=1, m%grid%forest%leaf_count())])) return
      allocate (fill(m%grid%n_elements), strain(m%grid%n_elements))
      fill = fills_of_pieces(m%matter_t)
      strain = 0
      do i = 1, m%particles%n
         associate (first => m%grid%first_of_piece(m%particles%cell(i)))
            strain(first) = max(strain(first), strain_of(m%particles%gradient_of(i)))
         end associate
      end do
      do e = 1, m%grid%n_elements
         if (.not. fill(e) > 0 .or. fill(e) >= firm .or. .not. m%grid%is_cut(m%grid%element_leaf(e))) cycle
         beside = largest_beside(m, e, fill, strain)
         if (.not. (beside > 0 .and. strain(e) > most*beside)) cycle
         associate (x => m%grid%element_lower(:, e) + m%grid%leaf_size(e)/2)
            call failure%report(exit_computation, m%state%when()// &
                                'material in the cell around '//point_text(x)// &
                                ' m, of which a crack or an edge leaves '//three_digits(100*fill(e))//' %, has a strain of '// &
                                three_digits(strain(e))//', '//three_digits(strain(e)/beside)//' times that of the cells '// &
                                'beside it: the material there is almost unsupported. Move the crack, the edge or the load, '// &
                                'or use smaller &grid cell')
         end associate
         return
      end do
   end subroutine check_pieces

   !> The largest strain in fuller pieces that share a node with a piece; 0 if there are none.
   pure real(dp) function largest_beside(m, e, fill, strain) result(largest)
      type(problem_t), intent(in) :: m
      integer, intent(in) :: e                   !! the first element of the piece
      real(dp), intent(in) :: fill(:), strain(:) !! by the first element of each piece
      integer :: element, c, k, other
      largest = 0
      do element = e, m%grid%last_of_piece(e)
         do c = 1, size(m%grid%element_nodes, 1)
            associate (around => m%grid%dofs%elements_at(m%grid%element_nodes(c, element)))
               do k = 1, size(around)
                  other = m%grid%first_of_piece(around(k))
                  if (fill(other) > fill(e)) largest = max(largest, strain(other))
               end do
            end associate
         end do
      end do
   end function largest_beside

   !> Norm of the strain of Green and Lagrange [-].
   pure real(dp) function strain_of(gradient) result(strain)
      real(dp), intent(in) :: gradient(ndim, ndim) !! of the displacement [-]
      strain = norm(gradient + transpose(gradient) + matmul(transpose(gradient), gradient))/2
   end function strain_of
end module hampm_run_time_checks
