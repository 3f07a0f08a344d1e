!> Whether the keys of a scene agree with each other: the grid, the bodies and their materials, the outputs.
!> A check whose ingredients were already found to be wrong is passed over.
module hampm_consistency
   use hampm_body_group, only: body_t, outline_of
   use hampm_contact_consistency, only: check_contact
   use hampm_crack_consistency, only: check_crack, check_energy_release
   use hampm_function_consistency, only: check_functions
   use hampm_growth_consistency, only: check_growth
   use hampm_joints, only: gap_between, groups_of_bodies
   use hampm_kinds, only: dp, name_len
   use hampm_load_consistency, only: check_constraints, check_loads, bodies_good
   use hampm_material_consistency, only: check_constants
   use hampm_mistakes, only: mistakes_t
   use hampm_path_consistency, only: check_paths
   use hampm_placement, only: tolerance, upper_corner, within, overlap, on_node, particle_number, most_particles, &
                                point_text, length_text
   use hampm_refine_consistency, only: check_refine
   use hampm_scene, only: scene_t
   use hampm_settings, only: settings_t
   use hampm_shape_consistency, only: check_shape, check_holes, outlines_overlap
   use hampm_stability_consistency, only: check_stability
   use hampm_text, only: to_text, three_digits, did_you_mean
   implicit none
   private
   public :: check_consistency

   real(dp), parameter :: most_nodes = 5e8_dp       !! of the lattice: four times as many must fit an integer
   real(dp), parameter :: furthest = 1e9_dp         !! from the origin [cells]
   real(dp), parameter :: most_samples = 1e8_dp     !! of a history

contains

   !> Check a whole scene.
   pure subroutine check_consistency(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      logical :: has_grid, has_bodies
      integer :: before
      call check_materials(scene, settings, mistakes)
      call check_constants(scene, settings, mistakes)
      before = mistakes%count
      call check_grid(scene, settings, mistakes, has_grid)
      call check_bodies(scene, settings, has_grid, mistakes)
      if (has_grid .and. mistakes%count == before) call check_particle_number(scene, settings, mistakes)
      has_bodies = has_grid .and. bodies_good(settings) .and. mistakes%count == before
      if (has_bodies) call check_joints(scene, settings, mistakes)
      call check_refine(scene, settings, has_bodies, mistakes)
      call check_constraints(scene, settings, has_grid, mistakes)
      call check_loads(scene, settings, has_bodies, mistakes)
      before = mistakes%count
      call check_crack(scene, settings, has_grid, mistakes)
      call check_paths(scene, settings, has_bodies, mistakes)
      call check_growth(scene, settings, has_bodies .and. mistakes%count == before, mistakes)
      call check_energy_release(scene, settings, has_bodies .and. mistakes%count == before, mistakes)
      if (has_grid .and. scene%method%mass == 'partial' .and. scene%method%full_region == 'box') &
         call check_full_box(scene, settings, settings%find('method', 1), mistakes)
      call check_contact(scene, settings, mistakes)
      call check_functions(scene, settings, mistakes)
      if (has_bodies .and. scene%grid%order == 2) call check_whole_cells(scene, settings, mistakes)
      call check_stability(scene, settings, mistakes)
      call check_output(scene, settings, mistakes)
   end subroutine check_consistency

   !> Rectangles fill the cells of a quadratic lattice.
   pure subroutine check_whole_cells(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: k
      do k = 1, size(scene%bodies)
         associate (body => scene%bodies(k))
            if (body%outline%is_there() .or. (on_node(scene%grid, body%lower) .and. on_node(scene%grid, body%upper))) cycle
            call settings%complain(mistakes, settings%find('body', k), 'lower', 'and upper must be nodes of the lattice with '// &
                                   '&grid order = 2: bodies are to fill their cells')
         end associate
      end do
   end subroutine check_whole_cells

   !> The box in which a partial mass matrix is full has cells in it.
   pure subroutine check_full_box(scene, settings, entry, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group &method
      type(mistakes_t), intent(inout) :: mistakes
      if (.not. (settings%good(entry, 'full_lower') .and. settings%good(entry, 'full_upper'))) return
      associate (grid => scene%grid, lower => scene%method%full_lower, upper => scene%method%full_upper)
         if (any(upper - lower < grid%cell) .or. any(upper < grid%lower + grid%cell) &
             .or. any(lower > grid%lower + (grid%cells - 1)*grid%cell)) &
            call settings%complain(mistakes, entry, 'full_upper', 'must give with full_lower a box of at least one cell '// &
                                   'within the grid, for mass = ''partial''')
      end associate
   end subroutine check_full_box

   !> Materials need different names, and bodies name one of them.
   pure subroutine check_materials(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      character(name_len) :: names(settings%count_of('material'))
      integer :: i, entry
      do i = 1, size(names)
         names(i) = settings%text(settings%find('material', i), 'name')
      end do
      do i = 2, size(names)
         entry = settings%find('material', i)
         if (.not. settings%good(entry, 'name')) cycle
         if (any(names(:i - 1) == names(i))) &
            call settings%complain(mistakes, entry, 'name', 'must differ from the name of every other material')
      end do
      do i = 1, size(scene%bodies)
         entry = settings%find('body', i)
         if (.not. settings%good(entry, 'material') .or. scene%bodies(i)%material_index > 0) cycle
         if (scene%bodies(i)%material == '') cycle ! told by a rule
         call settings%complain(mistakes, entry, 'material', 'must be the name of a &material'// &
                                did_you_mean(trim(scene%bodies(i)%material), names))
      end do
   end subroutine check_materials

   !> The lattice must be of a size that can be stored, and its nodes must be different numbers.
   pure subroutine check_grid(scene, settings, mistakes, has_grid)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      logical, intent(out) :: has_grid             !! whether there is a lattice to check other things against
      integer :: entry
      entry = settings%find('grid', 1)
      has_grid = settings%good(entry, 'lower') .and. settings%good(entry, 'cell') .and. settings%good(entry, 'cells')
      if (settings%good(entry, 'cells')) then
         if (product(scene%grid%cells + 1.0_dp) > most_nodes) then
            call settings%complain(mistakes, entry, 'cells', 'they must have at most 5e8 nodes, a row and a column more than cells')
            has_grid = .false.
         end if
      end if
      if (.not. has_grid) return
      if (scene%run%thickness%is_ring .and. scene%grid%lower(1) < 0) then
         call settings%complain(mistakes, entry, 'lower', 'must have no x below 0 with &run plane = ''axisymmetric'': x is the '// &
                                'radius. Where bodies reach the axis the lattice begins there')
         has_grid = .false.
         return
      end if
      if (maxval(abs(scene%grid%lower)) <= furthest*scene%grid%cell) return
      call settings%complain(mistakes, entry, 'lower', 'must be within 1e9 cells of the origin, for nodes to differ in position')
      has_grid = .false.
   end subroutine check_grid

   !> Bodies have an extent, lie within the grid and do not overlap.
   pure subroutine check_bodies(scene, settings, has_grid, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      logical, intent(in) :: has_grid
      type(mistakes_t), intent(inout) :: mistakes
      logical :: usable(size(scene%bodies))
      real(dp) :: tol
      integer :: i, j, entry
      tol = 0
      if (has_grid) tol = tolerance(scene%grid)
      do i = 1, size(scene%bodies)
         entry = settings%find('body', i)
         call check_shape(settings, entry, mistakes, usable(i))
         if (.not. usable(i)) cycle
         associate (body => scene%bodies(i))
            usable(i) = all(body%upper - body%lower > tol)
            if (.not. usable(i)) then
               select case (settings%text(entry, 'shape'))
                case ('polygon')
                  call settings%complain(mistakes, entry, 'points', 'the corners are on one line')
                case ('circle')
                  call settings%complain(mistakes, entry, 'radius', 'must be above '//three_digits(tol/2)//' [m], by which '// &
                                         'places in cells of this size are the same')
                case default
                  call settings%complain(mistakes, entry, 'upper', 'must be above lower = '//point_text(body%lower)// &
                                         ' in every direction')
               end select
               cycle
            end if
            if (has_grid) call check_within_grid(scene, settings, i, mistakes)
            do j = 1, i - 1
               if (.not. usable(j)) cycle
               if (.not. overlap(body%lower, body%upper, scene%bodies(j)%lower, scene%bodies(j)%upper, tol)) cycle
               if (body%outline%is_there() .or. scene%bodies(j)%outline%is_there()) then
                  if (.not. outlines_overlap(outline_of(body), outline_of(scene%bodies(j)), tol)) cycle
               end if
               call settings%complain(mistakes, entry, place_key(body), 'the body must not overlap body '//to_text(j))
            end do
         end associate
      end do
      call check_holes(scene, settings, mistakes)
   end subroutine check_bodies

   !> The key that tells where a body is.
   pure function place_key(body) result(key)
      type(body_t), intent(in) :: body
      character(:), allocatable :: key
      key = 'lower'
      if (body%shape == 'polygon') key = 'points'
      if (body%shape == 'circle') key = 'center'
   end function place_key

   !> In the total frame material never meets other material than it began with: bodies apart from the first one would go through it
   !> or, less than a cell away, be joined to it.
   pure subroutine check_joints(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: first(size(scene%bodies))
      real(dp) :: gap
      integer :: i, j
      if (.not. settings%good(settings%find('method', 1), 'frame') .or. scene%method%frame /= 'total') return
      first = groups_of_bodies(scene)
      do i = 2, size(first)
         if (first(i) < i) cycle
         gap = minval([(gap_between(scene, i, j), j=1, size(first))], mask=first /= i)
         call settings%complain(mistakes, settings%find('body', i), place_key(scene%bodies(i)), &
                                'the body must touch the others with &method '// &
                                'frame = ''total'', not lie '//length_text(gap)//' m from the next: in that frame bodies never '// &
                                'meet, and go through each other. Use frame = ''updated'', or a file for each body')
      end do
   end subroutine check_joints

   !> Both corners of a body are in the grid.
   pure subroutine check_within_grid(scene, settings, i, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: i                     !! which body
      type(mistakes_t), intent(inout) :: mistakes
      character(:), allocatable :: extent
      real(dp) :: tol
      integer :: entry
      entry = settings%find('body', i)
      tol = tolerance(scene%grid)
      associate (body => scene%bodies(i), lower => scene%grid%lower, upper => upper_corner(scene%grid))
         extent = 'must be within the grid, from '//point_text(lower)//' to '//point_text(upper)
         if (body%shape /= 'rectangle') then
            if (.not. within(body%lower, body%upper, lower, upper, tol)) &
               call settings%complain(mistakes, entry, place_key(body), extent)
            return
         end if
         if (.not. within(body%lower, body%lower, lower, upper, tol)) call settings%complain(mistakes, entry, 'lower', extent)
         if (.not. within(body%upper, body%upper, lower, upper, tol)) call settings%complain(mistakes, entry, 'upper', extent)
      end associate
   end subroutine check_within_grid

   !> The material points must be so few that an integer can count them.
   pure subroutine check_particle_number(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      real(dp) :: particles
      integer :: i, entry
      particles = 0
      do i = 1, size(scene%bodies)
         entry = settings%find('body', i)
         if (.not. (settings%good(entry, 'lower') .and. settings%good(entry, 'upper') &
                    .and. settings%good(entry, 'points_per_cell'))) return
         particles = particles + particle_number(scene, scene%bodies(i))
         if (particles <= most_particles) cycle
         call settings%complain(mistakes, entry, 'points_per_cell', 'there would be '//to_text(particles)// &
                                ' material points; their number must be in [1, 2e9]')
         return
      end do
   end subroutine check_particle_number

   !> The result file has a plain name, and samples fall within the run.
   pure subroutine check_output(scene, settings, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      type(mistakes_t), intent(inout) :: mistakes
      integer :: entry
      entry = settings%find('output', 1)
      if (settings%good(entry, 'file')) then
         if (scene%output%file == '' .or. scene%output%file == '.' .or. scene%output%file == '..' &
             .or. scan(scene%output%file, '/\') > 0) call settings%complain(mistakes, entry, 'file', &
            'must be the name of a file, not empty and without folders; the option --output gives the folder')
      end if
      if (.not. settings%good(settings%find('run', 1), 'end_time')) return
      call check_interval(scene, settings, 'history_interval', scene%output%history_interval, mistakes)
      call check_interval(scene, settings, 'snapshot_interval', scene%output%snapshot_interval, mistakes)
   end subroutine check_output

   !> An interval between outputs fits the length of the run.
   pure subroutine check_interval(scene, settings, key, interval, mistakes)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      character(*), intent(in) :: key
      real(dp), intent(in) :: interval             !! [s], 0 for no such output
      type(mistakes_t), intent(inout) :: mistakes
      integer :: entry
      entry = settings%find('output', 1)
      if (.not. settings%good(entry, key) .or. interval <= 0) return
      if (interval > scene%run%end_time) then
         call settings%complain(mistakes, entry, key, 'must be in [0, end_time = '//to_text(scene%run%end_time)//'] [s]')
      else if (scene%run%end_time/interval > most_samples) then
         call settings%complain(mistakes, entry, key, 'must be at least a 1e-8 part of end_time = '// &
                                to_text(scene%run%end_time)//' [s]')
      end if
   end subroutine check_interval
end module hampm_consistency
