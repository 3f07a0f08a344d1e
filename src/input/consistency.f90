!> Checks of keys against each other: grid, bodies and their materials, outputs; material constants against those of solids;
!> refinement against regions with material and room for more particles; contact between bodies against cells and cracks; cracks
!> against the domains of particles of `shape_functions = 'cpdi'`. A check whose input has an error already is skipped.
module hampm_consistency
   use hampm_body_group, only: body_t, profile_t
   use hampm_cohesive_consistency, only: check_cohesive
   use hampm_crack_consistency, only: check_crack, check_energy_release
   use hampm_growth_consistency, only: check_growth, check_nucleations
   use hampm_joints, only: groups_of_bodies, velocity_fields_of
   use hampm_kinds, only: dp, name_len, ndim
   use hampm_tensors, only: norm
   use hampm_load_consistency, only: check_constraints, check_loads, bodies_good
   use hampm_path_consistency, only: check_paths
   use hampm_plane_consistency, only: check_planes
   use hampm_probe_consistency, only: check_probes
   use hampm_placement, only: tolerance, upper_corner, within, overlap, on_node, particle_number, most_particles, point_text, &
                              spacing_of
   use hampm_model, only: model_t
   use hampm_settings, only: settings_t
   use hampm_shape_consistency, only: check_shape, check_holes
   use hampm_stability_consistency, only: check_stability
   use hampm_text, only: to_text, length_text, three_digits, did_you_mean
   use hampm_crack_placement, only: body_at
   use hampm_material_consistency, only: check_constants
   implicit none
   private
   public :: check_consistency


   integer, parameter :: most_velocity_fields = 16 !! each has all cells of the grid

   real(dp), parameter :: most_nodes = 5e8_dp       !! of the lattice: four times as many must fit an integer
   real(dp), parameter :: furthest = 1e9_dp         !! from the origin [cells]
   real(dp), parameter :: most_samples = 1e8_dp     !! of a history

   character(*), parameter :: factors_of_profile(*) = [character(19) :: 'profile_stiffness', 'profile_density', &
                                                       'profile_eigenstrain']

contains

   !> Check a whole model.
   subroutine check_consistency(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical :: has_grid, has_bodies
      integer :: before
      call check_materials(model, settings)
      call check_constants(model, settings)
      before = settings%errors%count
      call check_grid(model, settings, has_grid)
      call check_bodies(model, settings, has_grid)
      if (has_grid .and. settings%errors%count == before) call check_particle_number(model, settings)
      has_bodies = has_grid .and. bodies_good(settings) .and. settings%errors%count == before
      if (has_bodies) call check_joints(model, settings)
      call check_refine(model, settings, has_bodies)
      call check_constraints(model, settings, has_grid)
      call check_loads(model, settings, has_bodies)
      before = settings%errors%count
      call check_crack(model, settings, has_grid)
      call check_paths(model, settings, has_bodies)
      if (has_bodies) call check_planes(model, settings)
      call check_cohesive(model, settings)
      call check_growth(model, settings, has_bodies .and. settings%errors%count == before)
      call check_nucleations(model, settings, has_bodies .and. settings%errors%count == before)
      call check_energy_release(model, settings, has_bodies .and. settings%errors%count == before)
      call check_probes(model, settings, has_bodies .and. settings%errors%count == before)
      if (has_grid .and. model%method%mass == 'partial' .and. model%method%consistent_region == 'box') &
         call check_full_box(model, settings, settings%find('method', 1))
      call check_contact(model, settings)
      call check_functions(model, settings)
      if (has_bodies .and. model%grid%order == 2) call check_whole_cells(model, settings)
      call check_stability(model, settings)
      call check_output(model, settings)
   end subroutine check_consistency

   !> Rectangles fill the cells of a quadratic lattice.
   pure subroutine check_whole_cells(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer :: k
      do k = 1, size(model%bodies)
         associate (body => model%bodies(k))
            if (body%outline%is_there() .or. (on_node(model%grid, body%lower) .and. on_node(model%grid, body%upper))) cycle
            call settings%complain(settings%find('body', k), 'lower', 'and upper must be nodes of the lattice with '// &
                                   '&grid order = 2: bodies are to fill their cells')
         end associate
      end do
   end subroutine check_whole_cells

   !> The box in which a partial mass matrix is full has cells in it.
   pure subroutine check_full_box(model, settings, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry                 !! position of the group &method
      if (.not. (settings%good(entry, 'consistent_lower') .and. settings%good(entry, 'consistent_upper'))) return
      associate (grid => model%grid, lower => model%method%consistent_lower, upper => model%method%consistent_upper)
         if (any(upper - lower < grid%cell) .or. any(upper < grid%lower + grid%cell) &
             .or. any(lower > grid%lower + (grid%cells - 1)*grid%cell)) &
            call settings%complain(entry, 'consistent_upper', 'must give with consistent_lower a box of at least one cell '// &
                                   'within the grid, for mass = ''partial''')
      end associate
   end subroutine check_full_box

   !> Materials need different names, and bodies name one of them.
   pure subroutine check_materials(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      character(name_len) :: names(settings%count_of('material'))
      integer :: i, entry
      do i = 1, size(names)
         names(i) = settings%text(settings%find('material', i), 'name')
      end do
      do i = 2, size(names)
         entry = settings%find('material', i)
         if (.not. settings%good(entry, 'name')) cycle
         if (any(names(:i - 1) == names(i))) &
            call settings%complain(entry, 'name', 'must differ from the name of every other material')
      end do
      do i = 1, size(model%bodies)
         entry = settings%find('body', i)
         if (.not. settings%good(entry, 'material') .or. model%bodies(i)%material_index > 0) cycle
         if (model%bodies(i)%material == '') cycle ! a rule reports it
         call settings%complain(entry, 'material', 'must be the name of a &material'// &
                                did_you_mean(trim(model%bodies(i)%material), names))
      end do
   end subroutine check_materials

   !> The lattice must be of a size that can be stored, and its nodes must be different numbers.
   pure subroutine check_grid(model, settings, has_grid)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(out) :: has_grid             !! whether there is a lattice to check other things against
      integer :: entry
      entry = settings%find('grid', 1)
      has_grid = settings%good(entry, 'lower') .and. settings%good(entry, 'cell') .and. settings%good(entry, 'cells')
      if (settings%good(entry, 'cells')) then
         if (product(model%grid%cells + 1.0_dp) > most_nodes) then
            call settings%complain(entry, 'cells', 'they must have at most 5e8 nodes, a row and a column more than cells')
            has_grid = .false.
         end if
      end if
      if (.not. has_grid) return
      if (model%run%thickness%is_ring .and. model%grid%lower(1) < 0) then
         call settings%complain(entry, 'lower', 'must have no x below 0 with &run plane = ''axisymmetric'': x is the '// &
                                'radius. Where bodies reach the axis the lattice begins there')
         has_grid = .false.
         return
      end if
      if (maxval(abs(model%grid%lower)) <= furthest*model%grid%cell) return
      call settings%complain(entry, 'lower', 'must be within 1e9 cells of the origin, for nodes to differ in position')
      has_grid = .false.
   end subroutine check_grid

   !> Bodies have an extent, lie within the grid and do not overlap.
   pure subroutine check_bodies(model, settings, has_grid)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_grid
      logical :: usable(size(model%bodies))
      real(dp) :: tol
      integer :: i, j, entry
      tol = 0
      if (has_grid) tol = tolerance(model%grid)
      do i = 1, size(model%bodies)
         entry = settings%find('body', i)
         call check_profile(settings, entry, model%bodies(i)%profile)
         call check_shape(settings, entry, usable(i))
         if (.not. usable(i)) cycle
         associate (body => model%bodies(i))
            usable(i) = all(body%upper - body%lower > tol)
            if (.not. usable(i)) then
               select case (settings%text(entry, 'shape'))
                case ('polygon')
                  call settings%complain(entry, 'points', 'the corners are on one line')
                case ('circle', 'cylinder', 'sphere')
                  call settings%complain(entry, 'radius', 'must be above '//three_digits(tol/2)//' [m], by which '// &
                                         'places in cells of this size are the same')
                case default
                  call settings%complain(entry, 'upper', 'must be above lower = '//point_text(body%lower)// &
                                         ' in every direction')
               end select
               cycle
            end if
            if (has_grid) call check_within_grid(model, settings, i)
            do j = 1, i - 1
               if (.not. usable(j)) cycle
               if (body%overlaps(model%bodies(j), tol)) &
                  call settings%complain(entry, place_key(body), 'the body must not overlap body '//to_text(j))
            end do
         end associate
      end do
      call check_holes(model, settings)
   end subroutine check_bodies

   !> A graded body has places that increase, and as many factors.
   pure subroutine check_profile(settings, entry, profile)
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry               !! position of the group
      type(profile_t), intent(in) :: profile
      integer :: k
      associate (at => settings%numbers(entry, 'profile_at'))
         if (size(at) == 0) return
         if (size(at) < 2) then
            call settings%complain(entry, 'profile_at', 'must have two places at least')
         else if (any(at(2:) <= at(:size(at) - 1))) then
            call settings%complain(entry, 'profile_at', 'must increase from one to the next')
         end if
         do k = 1, size(factors_of_profile)
            associate (n => size(settings%numbers(entry, trim(factors_of_profile(k)))))
               if (n > 0 .and. n /= size(at)) call settings%complain(entry, trim(factors_of_profile(k)), &
                  'must have one value for each of the '//to_text(size(at))//' places of profile_at, not '//to_text(n))
            end associate
         end do
         if (.not. norm(profile%direction) > 0) call settings%complain(entry, 'profile_direction', 'must not be 0, 0')
      end associate
   end subroutine check_profile

   !> The key that gives the place of a body.
   pure function place_key(body) result(key)
      type(body_t), intent(in) :: body
      character(:), allocatable :: key
      key = 'lower'
      if (body%shape == 'polygon') key = 'points'
      if (any(body%shape == ['circle', 'sphere'])) key = 'center'
   end function place_key

   !> In the total frame material never meets other material than it began with: bodies apart from the first one would go through it
   !> or, less than a cell away, be joined to it.
   pure subroutine check_joints(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer :: first(size(model%bodies))
      real(dp) :: gap
      integer :: i, j
      if (.not. settings%good(settings%find('method', 1), 'frame') .or. model%method%frame /= 'total') return
      first = groups_of_bodies(model)
      do i = 2, size(first)
         if (first(i) < i) cycle
         gap = minval([(model%bodies(i)%gap_to(model%bodies(j)), j=1, size(first))], mask=first /= i)
         call settings%complain(settings%find('body', i), place_key(model%bodies(i)), &
                                'the body must touch the others with &method '// &
                                'frame = ''total'', not lie '//length_text(gap)//' m from the next: in that frame bodies never '// &
                                'come into contact, and interpenetrate. Use frame = ''updated'', or a file for each body')
      end do
   end subroutine check_joints

   !> Both corners of a body are in the grid.
   pure subroutine check_within_grid(model, settings, i)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: i                     !! number of the body
      character(:), allocatable :: extent
      real(dp) :: tol
      integer :: entry
      entry = settings%find('body', i)
      tol = tolerance(model%grid)
      associate (body => model%bodies(i), lower => model%grid%lower, upper => upper_corner(model%grid))
         extent = 'must be within the grid, from '//point_text(lower)//' to '//point_text(upper)
         if (body%shape /= 'rectangle') then
            if (.not. within(body%lower, body%upper, lower, upper, tol)) &
               call settings%complain(entry, place_key(body), extent)
            return
         end if
         if (.not. within(body%lower, body%lower, lower, upper, tol)) call settings%complain(entry, 'lower', extent)
         if (.not. within(body%upper, body%upper, lower, upper, tol)) call settings%complain(entry, 'upper', extent)
      end associate
   end subroutine check_within_grid

   !> The material points must be so few that an integer can count them.
   pure subroutine check_particle_number(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      real(dp) :: particles
      integer :: i, entry
      particles = 0
      do i = 1, size(model%bodies)
         entry = settings%find('body', i)
         if (.not. (settings%good(entry, 'lower') .and. settings%good(entry, 'upper') &
                    .and. settings%good(entry, 'points_per_cell'))) return
         particles = particles + particle_number(model, model%bodies(i))
         if (particles <= most_particles) cycle
         call settings%complain(entry, 'points_per_cell', 'there would be '//to_text(particles)// &
                                ' material points; their number must be in [1, 2e9]')
         return
      end do
   end subroutine check_particle_number

   !> The result file has a plain name, and samples fall within the run.
   pure subroutine check_output(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer :: entry
      entry = settings%find('output', 1)
      if (settings%good(entry, 'file')) then
         if (model%output%file == '' .or. model%output%file == '.' .or. model%output%file == '..' &
             .or. scan(model%output%file, '/\') > 0) call settings%complain(entry, 'file', &
            'must be the name of a file, not empty and without folders; the option --output gives the folder')
      end if
      if (.not. settings%good(settings%find('run', 1), 'end_time')) return
      call check_interval(model, settings, 'history_interval', model%output%history_interval)
      call check_interval(model, settings, 'snapshot_interval', model%output%snapshot_interval)
   end subroutine check_output

   !> An interval between outputs fits the length of the run.
   pure subroutine check_interval(model, settings, key, interval)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      character(*), intent(in) :: key
      real(dp), intent(in) :: interval             !! [s], 0 for no such output
      integer :: entry
      entry = settings%find('output', 1)
      if (.not. settings%good(entry, key) .or. interval <= 0) return
      if (interval > model%run%end_time) then
         call settings%complain(entry, key, 'must be in [0, end_time = '//to_text(model%run%end_time)//'] [s]')
      else if (model%run%end_time/interval > most_samples) then
         call settings%complain(entry, key, 'must be at least a 1e-8 part of end_time = '// &
                                to_text(model%run%end_time)//' [s]')
      end if
   end subroutine check_interval

   !> Check the group &refine. With indicator = 'none' its other keys have no effect.
   pure subroutine check_refine(model, settings, has_bodies)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      logical, intent(in) :: has_bodies            !! whether grid and bodies are without errors
      integer :: entry
      entry = settings%find('refine', 1)
      if (.not. settings%good(entry, 'indicator') .or. model%refine%by%name == '') return
      if (model%refine%by%name == 'gradient' .and. settings%good(entry, 'r_crit') .and. settings%good(entry, 'r_coarsen') &
          .and. settings%number(entry, 'r_coarsen') >= settings%number(entry, 'r_crit')) &
         call settings%complain(entry, 'r_coarsen', 'must be below r_crit = '//to_text(settings%number(entry, 'r_crit')))
      call check_region(model, settings, entry, has_bodies)
      if (has_bodies) call check_room(model, settings, entry)
   end subroutine check_refine

   !> The box in which cells may refine has an extent and holds material. An absent corner sets no limit.
   pure subroutine check_region(model, settings, entry, has_bodies)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry                 !! position of the group &refine, here and below
      logical, intent(in) :: has_bodies
      integer :: i
      if (.not. (settings%good(entry, 'region_lower') .and. settings%good(entry, 'region_upper'))) return
      associate (lower => model%refine%region_lower, upper => model%refine%region_upper)
         if (any(upper <= lower)) then
            call settings%complain(entry, 'region_upper', 'must be above region_lower = '//point_text(lower)// &
                                   ' in every direction')
            return
         end if
         if (.not. has_bodies) return
         do i = 1, size(model%bodies)
            if (overlap(lower, upper, model%bodies(i)%lower, model%bodies(i)%upper, tolerance(model%grid))) return
         end do
      end associate
      call settings%complain(entry, &
                             merge('region_lower', 'region_upper', size(settings%numbers(entry, 'region_lower')) > 0), &
                             'the box from region_lower to region_upper must contain material of a body')
   end subroutine check_region

   !> The material points that the model begins with are not too many already.
   pure subroutine check_room(model, settings, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, intent(in) :: entry
      real(dp) :: particles
      integer :: i
      if (.not. settings%good(entry, 'max_particles')) return
      particles = 0
      do i = 1, size(model%bodies)
         if (.not. settings%good(settings%find('body', i), 'points_per_cell')) return
         particles = particles + particle_number(model, model%bodies(i))
      end do
      if (model%refine%max_particles < particles) call settings%complain(entry, 'max_particles', &
         'must be at least the initial number of material points, '//to_text(nint(particles)))
   end subroutine check_room

   !> Check a model whose bodies meet; others have no use for the keys.
   pure subroutine check_contact(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer :: contact
      contact = settings%find('contact', 1)
      if (.not. settings%good(contact, 'bodies')) return
      if (.not. model%contact%is_wanted()) return
      if (settings%good(contact, 'distance') .and. model%contact%distance > model%grid%cell/2) &
         call settings%complain(contact, 'distance', 'must not be above half of a cell: '// &
                                'bodies farther apart have no nodes in common')
      call check_cracks(model, settings)
      if (maxval(velocity_fields_of(model)) > most_velocity_fields) call settings%complain(contact, 'bodies', 'must be '// &
         '''bonded'' where there are more than '//to_text(most_velocity_fields)// &
            ' bodies: each has a velocity field on the whole grid. '// &
         'Give the same &body contact_group to those that are not in contact')
   end subroutine check_contact

   !> Cracks are on the first velocity field: no straight part of one is in a body of another.
   pure subroutine check_cracks(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer, parameter :: places = 1000        ! sampled places of a part
      integer :: velocity_fields(0:size(model%bodies)), k, s, i
      velocity_fields = [1, velocity_fields_of(model)] ! 0 is no body
      do k = 1, size(model%paths)
         associate (path => model%paths(k), entry => settings%find('crack', k))
            if (.not. settings%good(entry, trim(path%key))) cycle
            do s = 2, size(path%points, 2)
               do i = 0, places
                  associate (from => path%points(:, s - 1), to => path%points(:, s))
                     if (velocity_fields(body_at(model, from + (i*(to - from))/places)) == 1) cycle
                  end associate
                  call settings%complain(entry, trim(path%key), 'must be in the first &body, or in one of its part, '// &
                                         'with &contact bodies: put the body with the crack first')
                  exit
               end do
            end do
         end associate
      end do
   end subroutine check_cracks

   !> A crack parts the domains of particles, where they have such: it runs along their edges.
   pure subroutine check_functions(model, settings)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      integer :: path, entry, k, j
      if (.not. settings%good(settings%find('method', 1), 'shape_functions') .or. .not. model%method%has_domains()) return
      paths: do path = 1, size(model%paths)
         entry = settings%find('crack', path)
         if (.not. settings%good(entry, 'points')) cycle
         do k = 2, size(model%paths(path)%points, 2)
            do j = 1, size(model%bodies)
               if (runs_along_domains(model, model%bodies(j), model%paths(path)%points(:, k - 1:k))) cycle
               associate (edges => spacing_of(model, model%bodies(j)))
                  call settings%complain(entry, 'points', 'must run along edges of the domains of particles with '// &
                                         '&method shape_functions = ''cpdi'', which are rectangles with the edges '// &
                                         to_text(edges(1))//', '//to_text(edges(2))//' m from the lower corner of the body '// &
                                         'on: a crack does not separate a domain')
               end associate
               cycle paths
            end do
         end do
      end do paths
   end subroutine check_functions

   !> Whether a segment runs along edges of the domains of a body, or past it.
   pure logical function runs_along_domains(model, body, ends) result(along)
      type(model_t), intent(in) :: model
      type(body_t), intent(in) :: body
      real(dp), intent(in) :: ends(ndim, 2)        !! [m]
      real(dp), parameter :: grace = 1e-6_dp       ! of an edge
      real(dp), dimension(ndim) :: first, edges
      real(dp) :: lines
      integer :: d
      first = merge(model%grid%lower, body%lower, body%outline%is_there())
      edges = spacing_of(model, body)
      along = any(maxval(ends, dim=2) <= body%lower .or. minval(ends, dim=2) >= body%upper)
      do d = 1, ndim
         if (along) return
         lines = (ends(d, 1) - first(d))/edges(d)
         along = abs(ends(d, 2) - ends(d, 1)) <= grace*edges(d) .and. abs(lines - anint(lines)) <= grace
      end do
   end function runs_along_domains
end module hampm_consistency
