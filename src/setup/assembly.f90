!> Assembly of the problem from a model: grid, materials, particles, constraints, loads and cracks.
module hampm_assembly
   use hampm_kinds, only: dp, ndim, plane
   use hampm_basis, only: edge_margin
   use hampm_bodies, only: pieces_t, cut_into_pieces, fill_rectangle, fill_outline
   use hampm_constraints, only: add_box, rebuild_constraints, hold_axis
   use hampm_crack_placement, only: distance_in_material, held_ahead, region_in, least_radius
   use hampm_crack_tip, only: frame_along
   use hampm_cracks, only: crack_t, cracks_t, last_point, take_planes
   use hampm_domains, only: start_domains
   use hampm_equilibrium, only: equilibrium_t
   use hampm_failure, only: failure_t, exit_input
   use hampm_forest, only: forest_t, deepest
   use hampm_grid_building, only: build_grid
   use hampm_plane_cuts, only: plane_cut_t
   use hampm_integrator, only: integrator_t
   use hampm_load_placement, only: into_half
   use hampm_joints, only: velocity_fields_of
   use hampm_outline, only: outline_t
   use hampm_mass_choice, only: new_mass_choice
   use hampm_modal, only: modal_t
   use hampm_newmark, only: newmark_t
   use hampm_problem, only: problem_t, start_problem, weigh_particles
   use hampm_particles, only: particles_t, new_particles, add_history
   use hampm_growth_room, only: see_surroundings
   use hampm_path_placement, only: path_tips, path_reaches, path_mouth, path_outside, path_radii, held_part, to_surface, &
                                    place_along
   use hampm_placement, only: tolerance, points_of, reach_of
   use hampm_quadratic_points, only: weigh_points
   use hampm_reference_step, only: reference_t
   use hampm_step, only: explicit_t
   use hampm_indicator, only: refinement_t
   use hampm_model, only: model_t, mass_used, has_shapes
   use hampm_grading, only: give_materials_of_places
   use hampm_model_materials, only: materials_of, material_of_body
   use hampm_sorting, only: sort_into_cells
   use hampm_supports, only: check_supports
   use hampm_text, only: to_text
   use hampm_crack_lines, only: left_face, right_face, length_of
   use hampm_load_assembly, only: place_loads
   implicit none
   private
   public :: assemble, choose_integrator

contains

   !> Build the motion of a model, its cracks and its refinement. Fails where memory does not suffice or a part of the model meets
   !> nothing.
   subroutine assemble(model, problem, cracks, refinement, failure)
      type(model_t), intent(in) :: model
      type(problem_t), intent(out) :: problem
      type(cracks_t), intent(out) :: cracks
      type(refinement_t), intent(out) :: refinement
      type(failure_t), intent(inout) :: failure
      type(forest_t) :: forest
      type(outline_t), allocatable :: bodies(:)  ! whose edges cut cells
      integer, allocatable :: velocity_fields(:) ! of bodies that have their own velocity fields
      real(dp), allocatable :: solids(:, :, :)   ! where cells are quadratic
      character(:), allocatable :: scheme
      type(plane_cut_t), allocatable :: planes(:)
      integer :: k
      refinement = refinement_of(model)
      call place_cracks(model, cracks)
      forest = forest_t(model%grid%lower, model%grid%cell, model%grid%cells)
      if (has_shapes(model) .and. model%method%frame == 'total') then
         allocate (bodies(size(model%bodies)))
         do k = 1, size(bodies)
            bodies(k) = model%bodies(k)%whole_outline()
         end do
      end if
      if (model%contact%is_wanted()) allocate (velocity_fields, source=velocity_fields_of(model))
      if (model%grid%order > 1) then
         allocate (solids(ndim, 2, size(model%bodies)))
         do k = 1, size(model%bodies)
            solids(:, 1, k) = model%bodies(k)%lower
            solids(:, 2, k) = model%bodies(k)%upper
         end do
      end if
      call place_planes(model, cracks, planes)
      call build_grid(forest, problem%grid, failure, cracks%lines(), bodies, velocity_fields, solids, planes=planes)
      if (failure%failed()) return
      problem%materials = materials_of(model)
      problem%interfaces%thickness = model%run%thickness
      problem%interfaces%cohesion = [(model%cohesive(k)%law(), k=1, size(model%cohesive))]
      problem%interfaces%are_bounded = model%method%time == 'explicit'
      problem%is_explicit = model%method%time == 'explicit'
      problem%interfaces%are_moving = model%method%time /= 'static'
      call place_particles(model, problem, failure)
      if (failure%failed()) return
      call check_masses(problem%particles, failure)
      if (failure%failed()) return
      do k = 1, size(model%constraints)
         associate (c => model%constraints(k))
            call add_box(problem%constraints, c%lower, c%upper, c%fixed, c%motion, reach_of(model, c%lower, c%upper))
         end associate
      end do
      call rebuild_constraints(problem%constraints, problem%grid)
      if (model%run%thickness%is_ring) call hold_axis(problem%constraints, problem%grid)
      call check_supports(problem, failure)
      if (failure%failed()) return
      call place_loads(model, problem, failure)
      if (failure%failed()) return
      if (problem%grid%is_quadratic() .and. any(problem%loads%by_mass)) call weigh_particles(problem)
      problem%damping_rate = model%damping%rate
      problem%body_contact%wanted = model%contact%is_wanted()
      problem%body_contact%always_sticks = model%contact%bodies == 'stick'
      problem%body_contact%friction = model%contact%friction
      problem%body_contact%distance = model%contact%distance
      problem%audit = model%energy_release%energy_balance
      scheme = trim(model%method%scheme)
      if (model%method%time /= 'explicit') scheme = 'musl' ! cells then hold the forces of the present stress
      associate (method => model%method)
         call start_problem(problem, scheme, failure, new_mass_choice(mass_used(model), method%solver, method%order, &
                                                                              method%lumped_fraction, method%consistent_lower, &
                                                                              method%consistent_upper, &
                                                                              method%consistent_region == 'refined'))
      end associate
   end subroutine assemble

   !> The integrator of a model.
   subroutine choose_integrator(model, integrator)
      type(model_t), intent(in) :: model
      class(integrator_t), allocatable, intent(out) :: integrator
      type(equilibrium_t) :: static
      type(newmark_t) :: implicit
      type(modal_t) :: modal
      if (model%method%time == 'static') then
         static%newton%solver = model%method%solver
         static%is_static = .true.
         static%carries = ndim == plane
         static%forgets_mesh = size(model%growth) == 0 .or. any(model%growth%law%is_static)
         static%fixed_step = model%output%history_interval
         allocate (integrator, source=static)
      else if (model%method%time == 'implicit') then
         implicit%newton%solver = model%method%solver
         implicit%alpha = max(model%method%hht_alpha, -1/3.0_dp)
         implicit%fixed_step = model%method%time_step
         implicit%ends_at_rows = .false.
         allocate (integrator, source=implicit)
      else if (model%method%time == 'modal') then
         modal%asked = model%method%modes
         modal%fixed_step = model%output%history_interval
         allocate (integrator, source=modal)
      else if (model%method%path == 'reference') then
         allocate (reference_t :: integrator)
      else
         allocate (explicit_t :: integrator)
      end if
   end subroutine choose_integrator

   !> Fail where the part of some node in the mass of a particle, which may stand at the very edge of a cell and be split, would
   !> be no normal number.
   subroutine check_masses(p, failure)
      type(particles_t), intent(in) :: p
      type(failure_t), intent(inout) :: failure
      real(dp), parameter :: least = tiny(1.0_dp)*2.0_dp**(ndim*deepest)/edge_margin**2, most = huge(1.0_dp)*epsilon(1.0_dp)
      integer :: i
      do i = 1, p%n
         if (p%mass(i) >= least .and. p%mass(i) <= most) cycle
         call failure%report(exit_input, '&material density: a particle would have a mass of '//to_text(p%mass(i))// &
                             ' kg, from which nothing can be computed; masses are to be between '//to_text(least)//' and '// &
                             to_text(most)//' kg')
         return
      end do
   end subroutine check_masses

   !> The cracks of a model, and the surroundings of their tips.
   pure subroutine place_cracks(model, cracks)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(out) :: cracks
      integer :: k
      allocate (cracks%crack(size(model%paths)))
      do k = 1, size(model%paths)
         call place_crack(model, k, cracks%crack(k))
      end do
      if (model%method%frame /= 'total') cracks%spacing = model%grid%cell/2
      call cracks%list_tips()
      do k = 1, size(cracks%tips)
         associate (tip => cracks%tips(k))
            if (any(model%energy_release%chosen%needs_radii)) tip%radii = path_radii(model, tip%crack, tip%end)
            call see_surroundings(model, tip)
         end associate
      end do
      do k = 1, size(model%nucleations)
         call let_wait(model, model%nucleations(k)%path, cracks)
      end do
   end subroutine place_cracks

   !> The cracks of solids, and their fronts, whose nodes are as far apart as the finest cells around them.
   pure subroutine place_planes(model, cracks, planes)
      type(model_t), intent(in) :: model
      type(cracks_t), intent(inout) :: cracks
      type(plane_cut_t), allocatable, intent(out) :: planes(:)
      integer :: k
      if (size(model%planes) == 0) return
      allocate (planes(size(model%planes)))
      do k = 1, size(planes)
         associate (plane => planes(k))
            plane%region_t = region_in(model, model%planes(k))
            plane%at_start = plane%region_t
            plane%contact = model%planes(k)%contact
            plane%friction = model%planes(k)%friction
            plane%moves = any(model%growth%path == k .and. .not. model%growth%law%is_static)
         end associate
      end do
      call take_planes(cracks, planes)
   end subroutine place_planes

   !> Let a crack that may appear wait for that.
   pure subroutine let_wait(model, path, cracks)
      type(model_t), intent(in) :: model
      integer, intent(in) :: path                !! its number
      type(cracks_t), intent(inout) :: cracks
      real(dp), parameter :: farther = 2         ! than the width of the grid
      integer :: k, n
      associate (crack => cracks%crack(path), grid => model%grid)
         crack%given = crack%points
         crack%covered = held_part(model, path)
         crack%aside(1) = farther*grid%cell*grid%cells(1) + grid%lower(1) - minval(crack%points(1, :))
         n = ceiling((crack%covered(2) - crack%covered(1))/(least_radius(model)/2))
         crack%places = reshape([(place_along(crack%given, (crack%covered(1) + real(k, dp)/n*(crack%covered(2) &
            - crack%covered(1)))/length_of(crack%given)), k=0, n)], [ndim, n + 1])
      end associate
      call cracks%hide(path)
   end subroutine let_wait

   !> The k-th crack of a model.
   pure subroutine place_crack(model, k, crack)
      type(model_t), intent(in) :: model
      integer, intent(in) :: k
      type(crack_t), intent(out) :: crack
      crack%kind = model%paths(k)%kind
      crack%name = model%paths(k)%name
      crack%points = model%paths(k)%points
      crack%contact = model%paths(k)%contact
      crack%friction = model%paths(k)%friction
      crack%grows = any(model%growth%path == k) .or. any(model%nucleations%path == k)
      crack%is_tip = path_tips(model, k)
      crack%mouth = path_mouth(model, k)
      crack%cohesion = findloc(model%cohesive%path, k, dim=1)
      if (model%is_half()) then
         call place_on_plane(model, crack)
         return
      end if
      crack%beyond = path_reaches(model, k)
      if (crack%cohesion > 0) then
         crack%held = held_part(model, k)
         if (crack%is_tip(last_point) .and. model%paths(k)%held_from > 0) &
            crack%bonded(last_point) = crack%length() - crack%held(1)
      end if
      crack%outside = sum(path_outside(model, k))
   end subroutine place_crack

   !> Data of a crack on a symmetry plane: one face, and cohesion as far as constraints hold the plane.
   pure subroutine place_on_plane(model, crack)
      type(model_t), intent(in) :: model
      type(crack_t), intent(inout) :: crack
      real(dp) :: axis(ndim, ndim), tip(ndim), ahead
      tip = crack%points(:, 2)
      axis = frame_along(model%paths(1)%direction)
      crack%face = merge(left_face, right_face, dot_product(into_half(model), axis(:, 2)) > 0)
      crack%began = tip
      if (crack%cohesion == 0) return
      ahead = distance_in_material(model, tip, axis(:, 1))
      if (held_ahead(model, tip) > ahead - tolerance(model%grid)) crack%beyond(last_point) = to_surface*model%grid%cell
      ahead = min(ahead, held_ahead(model, tip))
      crack%held = [0.0_dp, ahead] + crack%length()
      crack%points(:, 2) = tip + ahead*axis(:, 1)
      crack%bonded(last_point) = ahead
   end subroutine place_on_plane

   !> How the cells of a model refine.
   pure function refinement_of(model) result(r)
      type(model_t), intent(in) :: model
      type(refinement_t) :: r
      r%refine_t = model%refine
      r%tips_move = (model%method%frame /= 'total' .and. .not. all(model%paths%is_symmetry)) &
                    .or. size(model%growth) + size(model%nucleations) > 0 .or. any(model%cohesive%from > 0) &
                    .or. model%is_half() .and. size(model%cohesive) > 0
      r%is_static = model%method%time == 'static'
   end function refinement_of

   !> Fill the bodies with particles and sort these into the cells.
   subroutine place_particles(model, m, failure)
      type(model_t), intent(in) :: model
      type(problem_t), intent(inout) :: m
      type(failure_t), intent(inout) :: failure
      type(pieces_t) :: pieces(size(model%bodies))
      integer :: points(ndim, size(model%bodies)), number(size(model%bodies)), k, first
      do k = 1, size(model%bodies)
         associate (b => model%bodies(k))
            points(:, k) = points_of(model, b)
            number(k) = product(points(:, k))
            if (.not. b%outline%is_there()) cycle
            call cut_into_pieces(b%outline, model%grid%lower, model%grid%cell, b%points_per_cell, pieces(k))
            number(k) = pieces(k)%n
         end associate
      end do
      call new_particles(sum(number), m%particles, failure)
      if (failure%failed()) return
      if (any(m%materials%has_history)) call add_history(m%particles, maxval(m%materials%columns))
      m%materials%is_trial = model%method%time /= 'explicit'
      allocate (m%particles%spacing(ndim, size(model%bodies)), source=0.0_dp)
      if (has_shapes(model)) then
         allocate (m%particles%outlines(size(model%bodies)))
         do k = 1, size(model%bodies)
            if (model%bodies(k)%outline%is_there()) m%particles%outlines(k) = model%bodies(k)%outline
         end do
         m%particles%lattice = model%grid%lower
      end if
      m%particles%thickness = model%run%thickness
      if (model%run%thickness%is_ring) allocate (m%particles%widening(m%particles%n), source=0.0_dp)
      m%particles%total_frame = model%method%frame == 'total'
      first = 1
      do k = 1, size(model%bodies)
         associate (b => model%bodies(k))
            if (b%outline%is_there()) then
               call fill_outline(m%particles, first, pieces(k), model%run%thickness, &
                                 model%materials(b%material_index)%density, b%velocity, material_of_body(model, k), k)
            else
               call fill_rectangle(m%particles, first, points(:, k), b%lower, b%upper, model%run%thickness, &
                                   model%materials(b%material_index)%density, b%velocity, material_of_body(model, k), k)
            end if
         end associate
         first = first + number(k)
      end do
      call give_materials_of_places(m%particles, m%materials)
      do first = 1, m%particles%n
         if (m%materials(m%particles%material(first))%is_graded()) &
            m%particles%mass(first) = m%materials(m%particles%material(first))%density*m%particles%volume(first)
      end do
      if (model%method%has_domains()) call start_domains(m%particles)
      call sort_into_cells(m%cache%sorting, m%particles, m%grid, m%blocks, failure)
      if (m%grid%is_quadratic() .and. .not. failure%failed()) call weigh_points(m%matter_t)
   end subroutine place_particles
end module hampm_assembly
