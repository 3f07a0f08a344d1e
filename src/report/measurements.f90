!> Measurements of the history, and the list of its columns.
!>
!> Interpenetration of the faces of a crack: without contact nothing prevents it, and the results at the tip are then not physical:
!> K_I is below zero.
!>
!> Closed forms for the double cantilever beam.
module hampm_measurements
   use hampm_kinds, only: dp, ndim, long
   use hampm_tensors, only: norm
   use hampm_tolerance, only: bounded_ratio
   use hampm_archive, only: archive_t
   use hampm_cell_blocks, only: smallest_occupied_cell
   use hampm_constraints, only: constraints_t
   use hampm_crack_measurements, only: measure_crack, look_at_tip, needs_values, record_crack
   use hampm_crack_placement, only: body_at, distance_in_material
   use hampm_crack_tip, only: crack_tip_t
   use hampm_crack_values, only: crack_values_t, best_t, new_crack_values, keep_crack_values
   use hampm_cohesive_zone, only: zone_length, root_opening
   use hampm_cracks, only: cracks_t
   use hampm_estimated_errors, only: recent_t, pace_t, add_recent, waves_of, archive_recent
   use hampm_energy, only: linear_momentum, angular_momentum, n_turns, dissipation, largest_displacement
   use hampm_failure, only: failure_t
   use hampm_dynamic_front_growth, only: record_motion
   use hampm_growth_points, only: next_of_points
   use hampm_static_front_growth, only: record_points
   use hampm_static_growth, only: has_held_drive
   use hampm_fatigue, only: time_error
   use hampm_growing, only: by_cycles, by_frame, by_load, by_time, close_control, growing_t, record_growth, record_frame, &
                            record_place, record_onset
   use hampm_front_values, only: front_values_t, renew_front_values, archive_front_values, measure_front, find_scatter, &
                                 look_at_front, needs_front, jumps_behind, record_front, mean_rate, &
                                 error_of_largest
   use hampm_history, only: history_t
   use hampm_joints, only: groups_of_bodies, velocity_fields_of
   use hampm_loads, only: load_t
   use hampm_mass_solver, only: mass_solver_t, new_mass_solver, archive_solver
   use hampm_problem, only: problem_t, is_weighed, stored_energy, kinetic_energy
   use hampm_nodal_state, only: nodal_state_t, find_nodal_state, find_lone_node
   use hampm_particles, only: particles_t
   use hampm_probes, only: record_probes
   use hampm_results, only: results_t
   use hampm_model_materials, only: material_of_body
   use hampm_model, only: model_t
   use hampm_interface_placement, only: openings_t, find_openings
   use hampm_text, only: to_text
   implicit none
   private
   public :: measurements_t, new_measurements, renew_fronts, note_initial_energy, rebuild_extrapolation, measure, measure_tips, &
             has_measured_tips, take_row, declare_columns, energy_residual, archive_measurements, dcb_energy_release_rate, &
             chi_foundation, have_errors, part_of_rate, look_for_waves, need_sample, follow_waves

   real(dp), parameter :: chi_foundation = 2.0_dp/3.0_dp  !! chi of a beam on an elastic foundation, isotropic material

   !> Overlap over the largest displacement of the faces against each other in the run, above which it is reported [-]. Waves cause
   !> more: before a beam opens, the first bending waves press its arms together by a hundredth of that, or by a thirtieth of their
   !> opening by then. In equilibrium only the residual motion limits it.
   real(dp), parameter :: noticed_in_motion = 0.1_dp, noticed_static = 1e-3_dp

   !> The most that was seen, by the opening one cell behind the tip and at the mouth.
   type :: face_overlap_t
      real(dp) :: largest_jump = 0               !! largest opening, overlap or sliding [m]
      real(dp) :: overlap = 0                    !! largest overlap [m]
      real(dp) :: time = 0                       !! when that was [s]
      real(dp) :: last = 0                       !! overlap at the last sample; below 0 where the faces are separate [m]
      real(dp) :: last_time = 0                  !! when that was [s]
      type(openings_t) :: openings               !! places of the samples
   contains
      procedure :: look
      procedure :: is_notable
   end type face_overlap_t

   !> The last measurements, with all that the next one needs.
   type :: measurements_t
      real(dp) :: initial_energy = 0             !! kinetic energy of the bodies at the start [J]
      real(dp) :: largest_energy = 0             !! largest of kinetic + strain energy and external work so far [J]
      real(dp) :: rounding_energy = 0            !! below which energies are not told from rounding [J]
      real(dp) :: initial_angular_momentum(n_turns) = 0 !! angular momentum around the middle of mass at the start [kg m2/s]
      real(dp) :: largest_inner_energy = 0       !! the same, without kinetic energy of the motion as a whole [J]
      real(dp) :: kinetic_energy = 0             !! [J]
      real(dp) :: strain_energy = 0              !! [J]
      real(dp) :: plastic_dissipation = 0        !! [J]
      real(dp) :: viscous_dissipation = 0        !! [J]
      real(dp) :: g_ref = 0                      !! reference value, 0 if absent [J/m2]
      real(dp) :: g_beam_on_foundation = 0       !! (33) with chi = 2/3 and E', 0 where it does not apply [J/m2]
      real(dp), allocatable :: rate              !! G of the first tip by the best chosen estimator, if there is one [J/m2]
      type(mass_solver_t) :: extrapolation       !! solver of the extrapolations, without fixed components
      real(dp) :: indicator = 0                  !! its value when the mesh was last checked [-]
      type(crack_values_t), allocatable :: crack(:) !! measurements at each tip
      type(front_values_t), allocatable :: fronts(:) !! and along the front of each plane crack of a solid
      integer :: recorded_fronts = 0             !! how many of them there were at the start
      type(face_overlap_t), allocatable :: overlap(:) !! of the faces of each crack
      real(dp) :: reaction(ndim) = 0             !! force of all constraints on the bodies, where there is a crack [N]
      real(dp), allocatable :: reactions(:, :)   !! of the constraints, where one has a name [N], (ndim, constraints)
      real(dp) :: lone_part = 0                  !! as in `nodal_state_t`, where a result depends on that node [-]
      real(dp) :: lone_place(ndim) = 0           !! of it [m]
      integer, allocatable :: joined(:)          !! by body, bodies in touch without contact are one; where there
                                                 !! are probes
      type(recent_t) :: of_contact(ndim)         !! forces of bodies that meet, in motion
      type(pace_t) :: pace_of_contact            !! when samples of these are taken
      integer :: layout_of_pace = -1             !! of the blocks then
      integer(long) :: steps = -1                !! after which tips were measured last
      integer :: layout = -1                     !! of the blocks then
      type(history_t) :: history                 !! the columns and the latest row
   end type measurements_t

contains

   !> Ready for the first measurement.
   subroutine new_measurements(model, problem, cracks, m)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      type(measurements_t), intent(inout) :: m
      real(dp) :: force, length, depth, largest
      logical :: in_sets
      integer :: k
      call note_initial_energy(problem, m)
      m%rounding_energy = energy_of_rounding(model, problem%loads)
      if (size(model%probes) > 0) m%joined = groups_of_bodies(model) + size(model%bodies)*(velocity_fields_of(model) - 1)
      call angular_momentum(problem%particles, m%initial_angular_momentum, largest)
      allocate (m%crack(size(cracks%tips)), m%overlap(size(cracks%crack) + size(model%planes)))
      call renew_fronts(model, problem, cracks, m)
      m%recorded_fronts = size(m%fronts)
      in_sets = model%method%time == 'explicit' .and. size(model%growth) + size(model%nucleations) == 0
      do k = 1, size(m%crack)
         call new_crack_values(model%energy_release%chosen, model%energy_release%t_stress, cracks%tips(k), &
                               problem%materials(cracks%tips(k)%material_in(problem%materials)), &
                               model%method%time /= 'static', in_sets, &
                               model%method%time /= 'static' .and. model%refine%looks_at_motion(), m%crack(k))
      end do
      select case (model%energy_release%reference)
      case ('value')
         m%g_ref = model%energy_release%reference_value
      case ('dcb')
         call dcb_dimensions(model, cracks%tips(1), force, length, depth)
         associate (material => problem%materials(cracks%tips(1)%material_in(problem%materials)))
            m%g_ref = dcb_energy_release_rate(force, length, depth, model%run%thickness%of_plate, material%young, 0.0_dp)
            m%g_beam_on_foundation = dcb_energy_release_rate(force, length, depth, model%run%thickness%of_plate, &
                                                             material%plane_modulus(), chi_foundation)
         end associate
      end select
   end subroutine new_measurements

   !> Let measurements along the fronts of cracks of solids, where an estimator is chosen, follow them.
   pure subroutine renew_fronts(model, problem, cracks, m)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      type(measurements_t), intent(inout) :: m
      real(dp), parameter :: ahead = 1e-6_dp     ! cells
      integer :: k, j, body
      if (.not. allocated(m%fronts)) allocate (m%fronts(0))
      if (.not. allocated(cracks%fronts) .or. size(model%energy_release%chosen) == 0) return
      call renew_front_values(cracks%fronts, problem, model%energy_release%chosen%name, model%energy_release%radii, &
                              [(any(model%growth%path == k), k=1, size(model%planes))], m%fronts)
      if (size(model%bodies) == 1) return
      do k = 1, size(m%fronts)
         if (m%fronts(k)%has_ended) cycle
         do j = 1, size(m%fronts(k)%arc)         ! the material that is just ahead
            body = body_at(model, m%fronts(k)%at(:, j) + ahead*model%grid%cell*m%fronts(k)%outward(:, j))
            if (body > 0) m%fronts(k)%material(j) = material_of_body(model, body)
         end do
      end do
   end subroutine renew_fronts

   !> Record the energy at the start of the run: kinetic, and stored by eigenstrains. A run that begins in static equilibrium leaves
   !> out the energy put in by the loads.
   subroutine note_initial_energy(problem, m)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(inout) :: m
      m%initial_energy = kinetic_energy(problem)
      if (any(problem%materials%has_eigenstrain)) &
         m%initial_energy = m%initial_energy + stored_energy(problem) - problem%energies%external_work
   end subroutine note_initial_energy

   !> The energy below which nothing is told from rounding [J]. A force F on a plate of thickness B and any size stores an energy of
   !> the order of F**2/(E B). Where forces cancel, the sums at the nodes leave a part epsilon of them, which alone stores
   !> epsilon**2 of that energy, moves a free body with (c t/L)**2 of it, and does work of up to epsilon on the displacement of
   !> other forces. Loads of a sound run store 15 orders of magnitude more. A node that is moved by u takes up to E B u.
   pure real(dp) function energy_of_rounding(model, loads) result(energy)
      type(model_t), intent(in) :: model
      type(load_t), intent(in) :: loads(:)
      integer, parameter :: wide = selected_real_kind(15, 1000)   !! products of numbers as large as a namelist may have
      real(wide) :: force, stiffness
      integer :: k
      associate (far => model%grid%lower + model%grid%cell*model%grid%cells)
         stiffness = minval(model%materials%least_young())*real(model%run%thickness%at(far), wide) &
                     *maxval(far - model%grid%lower)**(ndim - 2)
      end associate
      force = 0
      do k = 1, size(loads)
         force = force + sqrt(sum(real(loads(k)%force, wide)**2))*abs(loads(k)%history%largest_factor())
      end do
      do k = 1, size(model%constraints)
         associate (motion => model%constraints(k)%motion)
            force = force + abs(motion%history%largest_factor())*stiffness &
                    *(norm(motion%displacement) + norm(motion%velocity)*real(model%run%end_time, wide))
         end associate
      end do
      do k = 1, size(model%bodies)               ! what a body swells by, though it may be free to
         associate (body => model%bodies(k), far => model%grid%lower + model%grid%cell*model%grid%cells)
            force = force + stiffness*maxval(abs(body%eigenstrain))*maxval(abs([1.0_dp, body%profile%eigenstrain])) &
                    *maxval(far - model%grid%lower)
         end associate
      end do
      energy = real(min(epsilon(energy)*force**2/stiffness, real(huge(energy), wide)), dp)
   end function energy_of_rounding

   !> Make the solver of the extrapolations fit a new mesh. Fails where the memory does not suffice.
   subroutine rebuild_extrapolation(problem, m, failure)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      call new_mass_solver(problem%mass%by, problem%mass%order, problem%grid, constraints_t(), m%extrapolation, failure, &
                           problem%fields%mass_matrix%ghosts)
   end subroutine rebuild_extrapolation

   !> Load of an arm, crack length and depth of an arm of a double cantilever beam, from the model: the resultant of the loads
   !> normal to the crack, without their sign and shared by both arms where both are there, the distance from the first load to the
   !> tip, and the distance from the tip to the edge of the body normal to the crack.
   pure subroutine dcb_dimensions(model, tip, force, length, depth)
      type(model_t), intent(in) :: model
      type(crack_tip_t), intent(in) :: tip
      real(dp), intent(out) :: force, length, depth
      integer :: k
      force = 0
      do k = 1, size(model%loads)
         force = force + merge(1.0_dp, 0.5_dp, tip%is_half())*abs(dot_product(model%loads(k)%force, tip%axis(:, 2)))
      end do
      associate (load => model%loads(1))
         length = abs(dot_product(tip%place - (load%lower + load%upper)/2, tip%axis(:, 1)))
      end associate
      depth = max(distance_in_material(model, tip%place, tip%axis(:, 2)), distance_in_material(model, tip%place, -tip%axis(:, 2)))
   end subroutine dcb_dimensions

   !> Declare the columns in the results, as a first pass through their list finds them, and their attributes.
   subroutine declare_columns(model, problem, cracks, growing, m, results, failure)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      type(growing_t), intent(in) :: growing
      type(measurements_t), intent(inout) :: m
      type(results_t), intent(inout) :: results
      type(failure_t), intent(inout) :: failure
      integer :: i
      call take_row(model, problem, cracks, growing, 0.0_dp, m)
      do i = 1, size(m%history%columns)
         associate (column => m%history%columns(i))
            if (column%is_along_front) then
               call results%add_column(column%name, column%unit, column%meaning, failure, along_front=column%n)
            else
               call results%add_column(column%name, column%unit, column%meaning, failure, column%integer_valued)
            end if
         end associate
      end do
      if (m%g_ref > 0) call results%add_attribute('/history', 'G_ref', m%g_ref, failure)
      if (m%g_beam_on_foundation > 0) call results%add_attribute('/history', 'G_beam_on_foundation', &
                                                                 m%g_beam_on_foundation, failure)
   end subroutine declare_columns

   !> Measure all that rows, run-time checks and progress line need. Fails where the nodal equations cannot be solved.
   subroutine measure(model, problem, cracks, m, failure)
      type(model_t), intent(in) :: model
      type(problem_t), intent(inout) :: problem
      type(cracks_t), intent(in) :: cracks
      type(measurements_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: rounding = 1e-12_dp ! of displacements
      real(dp), allocatable :: jumps(:)          ! opening and sliding behind fronts [m]
      real(dp) :: least, largest
      integer :: k, tip
      m%kinetic_energy = kinetic_energy(problem)
      m%strain_energy = stored_energy(problem)
      m%plastic_dissipation = dissipation(problem%particles, problem%materials, plastic=.true.)
      m%viscous_dissipation = dissipation(problem%particles, problem%materials, plastic=.false.)
      m%largest_energy = max(m%largest_energy, m%kinetic_energy + m%strain_energy, abs(problem%energies%external_work))
      m%largest_inner_energy = max(m%largest_inner_energy, abs(problem%energies%external_work), &
                                   m%kinetic_energy + m%strain_energy - energy_of_flight(problem))
      call measure_tips(model, problem, cracks, m, failure)
      if (failure%failed()) return
      do k = 1, size(cracks%crack)
         if (cracks%crack(k)%contact) cycle
         call find_openings(problem%matter_t, k, m%overlap(k)%openings, least, largest)
         do tip = 1, size(cracks%tips)
            if (cracks%tips(tip)%crack /= k) cycle
            least = min(least, m%crack(tip)%behind(1), m%crack(tip)%mouth(1))
            largest = max(largest, norm(m%crack(tip)%behind), norm(m%crack(tip)%mouth))
         end do
         largest = max(largest, rounding*largest_displacement(problem%particles))
         call m%overlap(k)%look(reshape([least, 0.0_dp, largest, 0.0_dp], [2, 2]), problem%state%time)
      end do
      do k = 1, size(model%planes)
         if (model%planes(k)%contact) cycle
         jumps = [0.0_dp, rounding*largest_displacement(problem%particles)]
         do tip = 1, size(m%fronts)
            if (m%fronts(tip)%domain%front%crack == k .and. .not. m%fronts(tip)%has_ended) &
               jumps = [jumps, reshape(jumps_behind(problem, m%fronts(tip)), [2*size(m%fronts(tip)%arc)])]
         end do
         call m%overlap(k)%look(reshape(jumps, [2, size(jumps)/2]), problem%state%time)
      end do
   end subroutine measure

   !> Measure the tips, which is all that growth asks for between rows, and reactions.
   subroutine measure_tips(model, problem, cracks, m, failure, for_waves)
      type(model_t), intent(in) :: model
      type(problem_t), intent(inout) :: problem
      type(cracks_t), intent(in) :: cracks
      type(measurements_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      logical, intent(in), optional :: for_waves !! whether for samples alone
      type(nodal_state_t) :: state
      logical :: has_domain, asks_way           ! asks: whether results depend on the displacement of supports
      integer :: k
      has_domain = any(model%energy_release%chosen%name == 'domain_integral')
      asks_way = any([(any(abs(model%constraints(k)%motion%displacement) + abs(model%constraints(k)%motion%velocity) > 0), &
                       k=1, size(model%constraints)), (model%probes(k)%gives('load_line'), k=1, size(model%probes))])
      if (has_domain .or. asks_way .or. any(model%constraints%name /= '') .or. &
          (size(model%paths) > 0 .and. size(model%constraints) > 0)) &
         call find_nodal_state(problem, state, failure, reactions_only=.not. has_domain)
      if (failure%failed()) return
      if (allocated(problem%grid%planes)) then
         if (any(problem%grid%planes%moves)) call renew_fronts(model, problem, cracks, m)
      end if
      do k = 1, size(m%fronts)
         call measure_front(problem, state, m%fronts(k))
      end do
      if (size(m%fronts) > 0) m%rate = mean_rate(m%fronts(1))
      m%reaction = state%reaction
      if (asks_way) then
         call find_lone_node(problem, state)
         m%lone_part = state%lone_part
         m%lone_place = state%lone_place
      end if
      if (any(model%constraints%name /= '')) m%reactions = state%reactions
      do k = size(m%crack), 1, -1                ! the first tip is the last, as its G is that which is shown
         call measure_crack(problem, cracks, k, state, m%extrapolation, m%crack(k), m%rate, failure, for_waves)
      end do
      if (present(for_waves) .and. any(model%energy_release%chosen%needs_mass)) return
      m%steps = problem%state%steps
      m%layout = problem%blocks%layout
   end subroutine measure_tips

   !> Whether errors are estimated of all that is measured at tips and along fronts.
   pure logical function have_errors(m)
      type(measurements_t), intent(in) :: m
      have_errors = size(m%crack) + size(m%fronts) > 0 .and. all(m%crack%errors%are_known)
   end function have_errors

   !> The largest relative error of G of tips, or along the front, of those with at least half of the largest G [-]; 0 if G is not
   !> above its error: nothing grows then, and the loads are those of the model.
   real(dp) function part_of_rate(problem, cracks, m) result(part)
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      type(measurements_t), intent(in) :: m
      type(best_t) :: best
      real(dp) :: rate(size(m%crack) + size(m%fronts)), error(size(rate))
      integer :: k
      rate = 0
      error = 0
      do k = 1, size(m%crack)
         associate (tip => cracks%tips(k))
            if (.not. tip%is_measured()) cycle
            best = m%crack(k)%best(tip, problem%materials(tip%material_in(problem%materials))%isotropic)
            rate(k) = best%rate
            error(k) = best%error
         end associate
      end do
      do k = 1, size(m%fronts)
         if (m%fronts(k)%has_ended) cycle
         rate(size(m%crack) + k) = maxval(m%fronts(k)%g)  ! a front grows by it
         error(size(m%crack) + k) = error_of_largest(m%fronts(k), m%fronts(k)%g_error)
      end do
      part = 0
      if (any(rate > 0)) part = maxval(bounded_ratio(error, rate, 1.0_dp), mask=rate >= maxval(rate)/2)
      if (part >= 1) part = 0
   end function part_of_rate

   !> Whether tips have been measured after the last step, with the cells as they are.
   pure logical function has_measured_tips(problem, m)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(in) :: m
      has_measured_tips = m%steps == problem%state%steps .and. m%layout == problem%blocks%layout
   end function has_measured_tips

   !> After an explicit step, look whether waves have arrived at tips or fronts, whichever rows there are.
   pure subroutine look_for_waves(model, problem, cracks, m)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      type(measurements_t), intent(inout) :: m
      logical, parameter :: in_sets = .true.
      integer :: k
      if (model%method%time /= 'explicit' .or. model%refine%max_level > 0) return ! velocities at nodes of changed cells lag
      do k = 1, size(m%crack)
         call look_at_tip(problem, cracks%tips(k), m%crack(k))
      end do
      do k = 1, size(m%fronts)
         call look_at_front(problem, in_sets, m%fronts(k))
      end do
   end subroutine look_for_waves

   !> Whether the errors of the next row need the present values of tips or fronts.
   pure logical function need_sample(model, problem, cracks, m, next_row, dt)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      type(measurements_t), intent(in) :: m
      real(dp), intent(in) :: next_row, dt       !! its time, and the step [s]
      logical, parameter :: in_sets = .true.
      integer :: k
      need_sample = .false.
      if (model%method%time /= 'explicit') return
      do k = 1, size(m%crack)
         need_sample = need_sample .or. needs_values(problem, cracks%tips(k), m%crack(k), next_row, dt)
      end do
      do k = 1, size(m%fronts)
         need_sample = need_sample .or. needs_front(problem, in_sets, m%fronts(k), next_row, dt)
      end do
   end function need_sample

   !> After a step of a motion: find the scatter of values along fronts, where they are those of this step, and of forces of body
   !> contact, by particles that change cells and by waves that cells cannot carry.
   subroutine follow_waves(model, problem, growing, has_measured, m)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(growing_t), intent(in) :: growing
      logical, intent(in) :: has_measured
      type(measurements_t), intent(inout) :: m
      real(dp), parameter :: longer = 1.5_dp     ! forces swing with the length of nine cells
      integer :: k
      if (model%method%time == 'static') return
      do k = 1, size(m%fronts)
         if (allocated(growing%points)) &
            call m%fronts(k)%follow_growth(pack(growing%points%width, growing%points%front == k), &
                                           pack(growing%points%speed, growing%points%front == k), &
                                           pack(growing%points%toughness, growing%points%front == k), problem%state%time)
         if (has_measured) call find_scatter(problem, model%method%time == 'explicit', m%fronts(k))
      end do
      if (.not. model%contact%is_wanted()) return
      if (m%layout_of_pace /= problem%blocks%layout) &
         m%pace_of_contact%waves = longer*waves_of(smallest_occupied_cell(problem%grid, problem%blocks), &
                                                   minval([(problem%materials(k)%shear_wave_speed(), &
                                                            k=1, size(problem%materials))]))
      m%layout_of_pace = problem%blocks%layout
      call add_recent(m%of_contact, problem%state%time, problem%body_contact%force, m%pace_of_contact)
   end subroutine follow_waves

   !> Record a row of the last measurements: this is the list of all columns.
   subroutine take_row(model, problem, cracks, growing, dt, m)
      type(model_t), intent(in) :: model
      type(problem_t), intent(in) :: problem
      type(cracks_t), intent(in) :: cracks
      type(growing_t), intent(in) :: growing
      real(dp), intent(in) :: dt                 !! length of the last step [s]
      type(measurements_t), intent(inout) :: m
      real(dp) :: off                            ! error of the load over it [-]
      logical :: has_reach
      integer :: k
      off = 0
      has_reach = .false.
      associate (history => m%history, p => problem%particles, grid => problem%grid)
         call history%begin_row()
         call history%record('time', 's', 'time', problem%state%time)
         call history%record('step', '1', 'steps done', problem%state%steps)
         call history%record('dt', 's', 'time step', dt)
         call history%record('particles', '1', 'number of particles', p%n)
         call history%record('cells', '1', 'number of cells', grid%forest%leaf_count())
         call history%record('finest_cell', 'm', 'size of the smallest occupied cell', smallest_occupied_cell(grid, problem%blocks))
         call history%record('kinetic_energy', 'J', 'kinetic energy', m%kinetic_energy)
         call history%record('strain_energy', 'J', 'strain energy', m%strain_energy)
         call history%record('external_work', 'J', 'work of the loads and of constraints that move', problem%energies%external_work)
         call history%record('damping_loss', 'J', 'energy taken by the damping', problem%energies%damping_loss)
         if (any(problem%loads%absorbs > 0)) call history%record('absorbed_energy', 'J', 'energy taken by absorbing edges', &
                                                                 problem%energies%absorbed_energy)
         if (.not. p%total_frame) call record_momentum(p, history)
         if (any(problem%materials%yields)) call history%record('plastic_dissipation', 'J', &
                                                                'work of the stress on the plastic strain', &
                                                                m%plastic_dissipation)
         if (any(problem%materials%has_history .and. .not. problem%materials%yields)) &
            call history%record('viscous_dissipation', 'J', 'energy taken by the viscosity of the material', m%viscous_dissipation)
         if (any(model%paths%friction > 0) .or. any(model%planes%friction > 0) .or. model%contact%is_wanted()) &
            call history%record('friction_loss', 'J', 'energy taken by friction', &
                                problem%interfaces%loss - problem%interfaces%of_cohesion + problem%body_contact%friction_loss)
         if (problem%interfaces%n_cohesive > 0) &
            call history%record('cohesive_energy', 'J', 'energy dissipated in cohesive zones', &
                                problem%interfaces%of_cohesion)
         if (model%contact%is_wanted()) then
            call history%record('contact_loss', 'J', 'energy that bodies have lost by meeting', problem%body_contact%loss)
            call history%record_vector('contact_force', 'N', 'force of the first body, or part, on all others', &
                                       problem%body_contact%force)
            if (model%method%time /= 'static') then
               do k = 1, ndim
                  call history%record('contact_force_'//'xyz'(k:k)//'_error', 'N', 'estimated error of single samples of that', &
                                      m%of_contact(k)%scatter)
               end do
            end if
         end if
         if (growing%are_there()) then
            if (growing%is_static .and. growing%driver /= by_time) call history%record('load_factor', '1', &
                                                       'by which loads, motions and eigenstrains are multiplied unless held', &
                                                       growing%load_factor)
            if (growing%have_onsets) call record_onset(growing, history)
            if (growing%driver == by_time .and. have_errors(m)) call history%record('time_error', 's', &
                  'estimated error of the time at which the crack is as it is', time_error(growing%fatigue, model))
            if (growing%driver == by_cycles) then
               call history%record('cycles', '1', 'load cycles so far', growing%fatigue%cycles)
               if (have_errors(m)) call history%record('cycles_error', '1', 'estimated error of cycles', growing%fatigue%error)
            end if
            if (model%control%is_there()) call record_frame(growing, model%control%stiffness, history)
            if (growing%is_static .and. .not. growing%has_rates .and. have_errors(m) .and. .not. has_held_drive(problem)) then
               off = part_of_rate(problem, cracks, m)/merge(2, 1, all(problem%materials%linear))
               has_reach = growing%driver == by_frame
               call history%record('load_factor_error', '1', 'estimated error of load_factor, where growth sets it', &
                                   off*abs(growing%load_factor))
               if (model%control%is_there()) call history%record('load_error', 'N', 'estimated error of load', &
                                                                 off*abs(growing%load))
               if (model%control%is_there() .and. growing%driver == by_load) &
                  call history%record('load_displacement_error', 'm', 'estimated error of load_displacement', &
                                      off*abs(growing%displacement))
            end if
            call history%record('fracture_energy', 'J', 'energy dissipated by growth: static, the integral of G over the new '// &
                                'area; dynamic, the work of nodal release; half of it on a symmetry plane', &
                                problem%energies%fracture_energy)
            if (.not. (growing%is_static .or. any(problem%materials%has_history) .or. size(model%planes) > 0)) &
               call history%record('integral_of_G', 'J', 'integral of G over the area of new faces, by cells that tips pass, '// &
                                   'or implicit steps; on a symmetry plane half of it', growing%integral + growing%since_booked)
         end if
         if (model%energy_release%energy_balance) &
            call history%record('numerical_loss', 'J', 'energy lost by the method', problem%energies%numerical_loss)
         do k = 1, size(m%crack)
            if (k > 1) history%of_tip = '_tip'//to_text(k)
            call record_crack(problem%materials(cracks%tips(k)%material_in(problem%materials)), cracks%tips(k), m%crack(k), &
                              size(model%growth) + size(model%nucleations) > 0, history)
            if (growing%are_there()) &
               call record_growth(growing, model, problem%materials(cracks%tips(k)%material_in(problem%materials)), cracks, k, &
                                  m%crack(k), problem%state%time, history)
            if (has_reach) call history%record('crack_length_error', 'm', 'estimated error of crack_length at this time, by '// &
                                               'this tip', (off + 2*close_control)*growing%points(k)%reach)
            if (cracks%tips(k)%has_zone) then
               if (.not. growing%are_there()) call record_place(cracks, cracks%tips(k), history)
               call history%record('zone_length', 'm', 'length of the faces ahead of the tip that are damaged', &
                                   zone_length(problem%interfaces, cracks%tips(k)%crack))
               call history%record('root_opening', 'm', 'opening of the faces where cohesion begins', &
                                   root_opening(problem%interfaces, cracks%tips(k)%crack))
            end if
         end do
         do k = 1, m%recorded_fronts
            if (k > 1) history%of_tip = '_front'//to_text(k)
            call record_front(m%fronts(k), growing%are_there() .and. .not. growing%is_static, history)
            if (growing%are_there() .and. growing%is_static) &
               call record_points(growing, model, next_of_points(growing, model, cracks, m%crack, m%fronts), cracks, &
                                  m%fronts, k, has_reach, (off + 2*close_control)*growing%points%reach, history)
         end do
         do k = 1, merge(size(model%planes), 0, growing%are_there() .and. .not. growing%is_static)
            if (.not. any(growing%points%crack == k .and. growing%points%grows)) cycle
            history%of_tip = ''
            if (k > 1) history%of_tip = '_crack'//to_text(k)
            call record_motion(pack(growing%points, growing%points%crack == k), cracks%regions(k), &
                               have_errors(m) .and. .not. all(model%growth%law%gives_speed()), history)
         end do
         history%of_tip = ''
         if (size(m%crack) > 0 .and. size(model%constraints) > 0) &
            call history%record_vector('reaction', 'N', 'force of the constraints on the bodies', m%reaction)
         call record_reactions(model, m)
         if (size(model%probes) > 0) call record_probes(model, problem, cracks, m%joined, m%reactions, history)
         associate (by => model%refine%by)
            if (by%column /= '') call history%record(trim(by%column), '1', trim(by%meaning), m%indicator)
         end associate
         call history%end_row()
      end associate
   end subroutine take_row

   !> Record linear momentum, and angular momentum around the middle of mass; of rings, which have no other, that along the axis.
   subroutine record_momentum(p, history)
      type(particles_t), intent(in) :: p
      type(history_t), intent(inout) :: history
      character(*), parameter :: around = 'angular momentum around the centre of mass'
      real(dp) :: momentum(ndim), spin(n_turns)
      momentum = linear_momentum(p)
      call angular_momentum(p, spin)
      if (p%thickness%is_ring) then
         call history%record('momentum_y', 'kg m/s', 'linear momentum', momentum(2))
         return
      end if
      call history%record_vector('momentum', 'kg m/s', 'linear momentum', momentum)
      if (ndim == 2) call history%record('angular_momentum', 'kg m2/s', around, spin(1))
      if (ndim > 2) call history%record_vector('angular_momentum', 'kg m2/s', around, spin)
   end subroutine record_momentum

   !> Record the force of each constraint that has a name, on the bodies.
   subroutine record_reactions(model, m)
      type(model_t), intent(in) :: model
      type(measurements_t), intent(inout) :: m
      integer :: k
      if (.not. allocated(m%reactions)) allocate (m%reactions(ndim, size(model%constraints)), source=0.0_dp)
      do k = 1, size(model%constraints)
         associate (name => model%constraints(k)%name)
            if (name == '') cycle
            call m%history%record_vector('reaction_'//trim(name), 'N', 'force of this constraint on the bodies', m%reactions(:, k))
         end associate
      end do
   end subroutine record_reactions

   !> Kinetic energy of the motion as a whole, which is nobody else's where nothing holds the material [J].
   pure real(dp) function energy_of_flight(problem) result(energy)
      type(problem_t), intent(in) :: problem
      energy = 0
      if (size(problem%constraints%node) > 0) return
      associate (p => problem%particles)
         energy = sum(linear_momentum(p)**2)/(2*sum(p%mass(:p%n)))
      end associate
   end function energy_of_flight

   !> Error of the energy balance, over the largest energy so far; without the energy balance the numerical loss [-]. 0 where there
   !> is only rounding.
   pure real(dp) function energy_residual(problem, m) result(residual)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(in) :: m
      residual = 0
      if (m%largest_energy <= m%rounding_energy) return
      residual = (problem%energies%external_work + m%initial_energy - m%kinetic_energy - m%strain_energy - &
                  problem%energies%damping_loss - problem%energies%absorbed_energy &
                  - problem%energies%numerical_loss - problem%interfaces%loss - problem%energies%fracture_energy &
                  - problem%body_contact%loss - problem%body_contact%friction_loss &
                  - m%plastic_dissipation - m%viscous_dissipation)/m%largest_energy
   end function energy_residual

   !> Archive the data that rows of the history need of the rows before.
   subroutine archive_measurements(problem, m, archive)
      type(problem_t), intent(in) :: problem
      type(measurements_t), intent(inout) :: m
      class(archive_t), intent(inout) :: archive
      integer :: k
      logical :: has_measured                    ! tips in this step: growth goes on with their values, to the bit
      call archive%section('measurements')
      has_measured = has_measured_tips(problem, m) .and. size(m%fronts) == 0
      call archive%serialise('has_measured', has_measured)
      if (archive%is_read .and. has_measured) then
         m%steps = problem%state%steps
         m%layout = problem%blocks%layout
      end if
      call archive%serialise('initial_energy', m%initial_energy)
      call archive%serialise('largest_energy', m%largest_energy)
      call archive%serialise('kinetic_energy', m%kinetic_energy)
      call archive%serialise('strain_energy', m%strain_energy)
      call archive%serialise('plastic_dissipation', m%plastic_dissipation)
      call archive%serialise('viscous_dissipation', m%viscous_dissipation)
      call archive%archive_reals('initial_angular_momentum', n_turns, m%initial_angular_momentum)
      call archive%serialise('largest_inner_energy', m%largest_inner_energy)
      do k = 1, size(m%overlap)
         call archive%section('face_overlap_'//to_text(k))
         call archive_overlap(m%overlap(k), archive)
      end do
      do k = 1, size(m%crack)
         call archive%section('errors_'//to_text(k))
         call keep_crack_values(m%crack(k), archive)
      end do
      if (allocated(problem%grid%planes)) call archive_front_values(m%fronts, archive)
      call archive%section('contact_forces')
      do k = 1, ndim
         call archive_recent(m%of_contact(k), 'force_'//to_text(k), archive)
      end do
      call archive%section('extrapolation')
      call archive_solver(m%extrapolation, 'extrapolation', problem%grid, is_weighed(problem), problem%fields%mass_matrix, &
                          archive)
   end subroutine archive_measurements

   !> Sample the openings and slidings of the faces at some places.
   pure subroutine look(self, jumps, time)
      class(face_overlap_t), intent(inout) :: self
      real(dp), intent(in) :: jumps(:, :)        !! opening, sliding [m], (modes, places)
      real(dp), intent(in) :: time               !! [s]
      self%largest_jump = max(self%largest_jump, maxval(abs(jumps)))
      self%last = maxval(-jumps(1, :))
      self%last_time = time
      if (self%last <= self%overlap) return
      self%overlap = self%last
      self%time = time
   end subroutine look

   !> Whether there was an overlap beyond rounding and passing waves.
   pure logical function is_notable(self, is_static)
      class(face_overlap_t), intent(in) :: self
      logical, intent(in) :: is_static           !! whether the motion has reached static equilibrium
      is_notable = self%overlap > noticed_in_motion*self%largest_jump
      if (is_static) is_notable = is_notable .or. self%last > noticed_static*self%largest_jump
   end function is_notable

   !> Keep it in a section of an archive.
   subroutine archive_overlap(overlap, archive)
      type(face_overlap_t), intent(inout) :: overlap
      class(archive_t), intent(inout) :: archive
      call archive%serialise('largest_jump', overlap%largest_jump)
      call archive%serialise('overlap', overlap%overlap)
      call archive%serialise('time', overlap%time)
      call archive%serialise('last', overlap%last)
      call archive%serialise('last_time', overlap%last_time)
   end subroutine archive_overlap

   !> Static G of a double cantilever beam, (33): 12 P**2 (a + chi D)**2 / (E B**2 D**3) [J/m2]. With chi = 0 it is
   !> simple beam theory, with `chi_foundation` the beam on an elastic foundation (Kanninen 1973).
   pure real(dp) function dcb_energy_release_rate(force, crack_length, depth, thickness, young, chi) result(g)
      real(dp), intent(in) :: force              !! P, at the end of each arm [N]
      real(dp), intent(in) :: crack_length       !! a [m]
      real(dp), intent(in) :: depth              !! D, of one arm [m]
      real(dp), intent(in) :: thickness          !! B [m]
      real(dp), intent(in) :: young              !! E [Pa]
      real(dp), intent(in) :: chi                !! [-]
      g = 12*force**2*(crack_length + chi*depth)**2/(young*thickness**2*depth**3)
   end function dcb_energy_release_rate
end module hampm_measurements
