!> From a namelist file to a scene. Files of scenes are read here and nowhere else.
module hampm_reading
   use hampm_consistency, only: check_consistency
   use hampm_failure, only: failure_t
   use hampm_kinds, only: dp, ndim
   use hampm_mistakes, only: mistakes_t
   use hampm_namelist_file, only: read_text, scan_namelist
   use hampm_namelist_text, only: canonical_text
   use hampm_overrides, only: override
   use hampm_scene, only: scene_t, material_spec_t, body_t, constraint_spec_t, load_spec_t, refine_t
   use hampm_settings, only: settings_t
   use hampm_text, only: string_t
   use hampm_validation, only: validate
   use hampm_values, only: least_magnitude
   implicit none
   private
   public :: read_scene, understand_scene

contains

   !> Read a scene. Every mistake in the file and in the overrides is reported, not only the first.
   subroutine read_scene(path, overrides, scene, failure)
      character(*), intent(in) :: path
      type(string_t), intent(in) :: overrides(:)   !! `group.key=value`; later ones win
      type(scene_t), intent(out) :: scene
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: text
      call read_text(path, text, failure)
      if (.not. failure%failed()) call understand_scene(path, text, overrides, scene, failure)
   end subroutine read_scene

   !> The scene that a namelist text and overrides describe.
   pure subroutine understand_scene(path, text, overrides, scene, failure)
      character(*), intent(in) :: path             !! of the file that the text comes from, for messages
      character(*), intent(in) :: text
      type(string_t), intent(in) :: overrides(:)   !! `group.key=value`; later ones win
      type(scene_t), intent(out) :: scene
      type(failure_t), intent(inout) :: failure
      type(settings_t) :: settings
      type(mistakes_t) :: mistakes
      integer :: i
      settings%file = path
      call scan_namelist(path, text, settings, mistakes)
      do i = 1, size(overrides)
         call override(overrides(i)%text, settings, mistakes)
      end do
      call validate(settings, mistakes)
      call resolve(settings)
      call fill(settings, scene)
      call check_consistency(scene, settings, mistakes)
      call mistakes%tell(failure)
      if (.not. failure%failed()) scene%as_used = canonical_text(settings)
   end subroutine understand_scene

   !> Replace values that stand for another one by that one.
   pure subroutine resolve(settings)
      type(settings_t), intent(inout) :: settings
      real(dp) :: direction(ndim)
      integer :: run, method, output, crack
      run = settings%find('run', 1)
      method = settings%find('method', 1)
      output = settings%find('output', 1)
      crack = settings%find('crack', 1)
      if (.not. settings%given(output, 'file')) call settings%set_text(output, 'file', result_file(settings%file))
      if (settings%good(output, 'history_interval') .and. settings%good(run, 'end_time')) then
         if (settings%number(output, 'history_interval') <= 0) &
            call settings%set_numbers(output, 'history_interval', [max(settings%number(run, 'end_time')/1000, least_magnitude)])
      end if
      if (settings%good(method, 'courant')) then
         if (settings%number(method, 'courant') <= 0) &
            call settings%set_numbers(method, 'courant', &
                                      [safe_courant(settings%text(method, 'frame'), settings%text(method, 'mass'))])
      end if
      if (settings%good(crack, 'direction')) then
         direction = settings%numbers(crack, 'direction')
         direction = direction/max(maxval(abs(direction)), least_magnitude)
         where (abs(direction) < 1e-9_dp) direction = 0
         call settings%set_numbers(crack, 'direction', direction)
      end if
   end subroutine resolve

   !> Courant number that is stable also for free edges that cross cells, see docs/mass.md.
   pure real(dp) function safe_courant(frame, mass)
      character(*), intent(in) :: frame, mass
      safe_courant = 0.1_dp
      if (frame == 'updated' .and. (mass == 'full' .or. mass == 'partial')) safe_courant = 0.05_dp
   end function safe_courant

   !> Name of the result file of a namelist file: without folder, `.h5` instead of its ending.
   pure function result_file(path) result(name)
      character(*), intent(in) :: path
      character(:), allocatable :: name
      integer :: dot
      name = path(index(path, '/', back=.true.) + 1:)
      dot = index(name, '.', back=.true.)
      if (dot > 1) name = name(:dot - 1)
      name = name//'.h5'
   end function result_file

   !> One assignment for each key. What is absent or mistaken stays 0, '' or empty.
   pure subroutine fill(settings, scene)
      type(settings_t), intent(in) :: settings
      type(scene_t), intent(inout) :: scene
      integer :: i
      allocate (scene%materials(settings%count_of('material')))
      allocate (scene%bodies(settings%count_of('body')))
      allocate (scene%constraints(settings%count_of('constraint')))
      allocate (scene%loads(settings%count_of('load')))
      call fill_single(settings, scene)
      do i = 1, size(scene%materials)
         call fill_material(settings, settings%find('material', i), scene%materials(i))
      end do
      do i = 1, size(scene%bodies)
         call fill_body(settings, settings%find('body', i), scene%bodies(i))
         scene%bodies(i)%material_index = material_index(scene, scene%bodies(i)%material)
      end do
      do i = 1, size(scene%constraints)
         call fill_constraint(settings, settings%find('constraint', i), scene%constraints(i))
      end do
      do i = 1, size(scene%loads)
         call fill_load(settings, settings%find('load', i), scene%loads(i))
      end do
   end subroutine fill

   !> The groups that stand at most once.
   pure subroutine fill_single(settings, scene)
      type(settings_t), intent(in) :: settings
      type(scene_t), intent(inout) :: scene
      integer :: entry
      entry = settings%find('run', 1)
      scene%run%title = settings%text(entry, 'title')
      scene%run%plane = settings%text(entry, 'plane')
      scene%run%thickness = settings%number(entry, 'thickness')
      scene%run%end_time = settings%number(entry, 'end_time')
      entry = settings%find('grid', 1)
      scene%grid%lower = vector(settings, entry, 'lower')
      scene%grid%cell = settings%number(entry, 'cell')
      scene%grid%cells = nint(vector(settings, entry, 'cells'))
      entry = settings%find('damping', 1)
      scene%damping%rate = settings%number(entry, 'rate')
      entry = settings%find('method', 1)
      scene%method%scheme = settings%text(entry, 'scheme')
      scene%method%courant = settings%number(entry, 'courant')
      scene%method%wave_speed = settings%text(entry, 'wave_speed')
      scene%method%time_steps = settings%text(entry, 'time_steps')
      scene%method%frame = settings%text(entry, 'frame')
      scene%method%mass = settings%text(entry, 'mass')
      scene%method%order = nint(settings%number(entry, 'order'))
      scene%method%blend = settings%number(entry, 'blend')
      scene%method%full_region = settings%text(entry, 'full_region')
      scene%method%full_lower = vector(settings, entry, 'full_lower')
      scene%method%full_upper = vector(settings, entry, 'full_upper')
      scene%method%solver = settings%text(entry, 'solver')
      call fill_refine(settings, settings%find('refine', 1), scene%refine)
      entry = settings%find('crack', 1)
      scene%crack%present = entry > 0
      scene%crack%kind = settings%text(entry, 'kind')
      scene%crack%tip = vector(settings, entry, 'tip')
      scene%crack%direction = vector(settings, entry, 'direction')
      scene%crack%length = settings%number(entry, 'length')
      scene%crack%contact = settings%text(entry, 'contact') == 'frictionless'
      entry = settings%find('energy_release', 1)
      scene%energy_release%nodal_force = settings%texts(entry, 'estimators', 'nodal_force')
      scene%energy_release%stress_closure = settings%texts(entry, 'estimators', 'stress_closure')
      scene%energy_release%domain_integral = settings%texts(entry, 'estimators', 'domain_integral')
      scene%energy_release%radii = settings%numbers(entry, 'radii')
      scene%energy_release%energy_balance = settings%texts(entry, 'estimators', 'energy_balance')
      scene%energy_release%reference = settings%text(entry, 'reference')
      scene%energy_release%reference_value = settings%number(entry, 'reference_value')
      entry = settings%find('output', 1)
      scene%output%file = settings%text(entry, 'file')
      scene%output%history_interval = settings%number(entry, 'history_interval')
      scene%output%snapshot_interval = settings%number(entry, 'snapshot_interval')
      scene%output%checkpoint_interval = settings%number(entry, 'checkpoint_interval')
      scene%output%checkpoint_steps = nint(settings%number(entry, 'checkpoint_steps'))
   end subroutine fill_single

   !> How cells refine. Without the group nothing is set: no indicator, no limit of the region.
   pure subroutine fill_refine(settings, entry, refine)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry                 !! position of the group, here and below
      type(refine_t), intent(inout) :: refine
      refine%present = entry > 0
      if (.not. refine%present) return
      refine%indicator = settings%text(entry, 'indicator')
      refine%field = settings%text(entry, 'field')
      refine%r_crit = settings%number(entry, 'r_crit')
      refine%r_coarsen = settings%number(entry, 'r_coarsen')
      refine%tolerance = settings%number(entry, 'tolerance')
      refine%rings = nint(settings%number(entry, 'rings'))
      refine%max_level = nint(settings%number(entry, 'max_level'))
      refine%energy_floor = settings%number(entry, 'energy_floor')
      if (size(settings%numbers(entry, 'region_lower')) == ndim) refine%region_lower = settings%numbers(entry, 'region_lower')
      if (size(settings%numbers(entry, 'region_upper')) == ndim) refine%region_upper = settings%numbers(entry, 'region_upper')
      refine%start = settings%number(entry, 'start')
      refine%interval = nint(settings%number(entry, 'interval'))
      refine%max_particles = nint(settings%number(entry, 'max_particles'))
   end subroutine fill_refine

   !> One material.
   pure subroutine fill_material(settings, entry, material)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      type(material_spec_t), intent(inout) :: material
      material%name = settings%text(entry, 'name')
      material%law = settings%text(entry, 'law')
      material%young = settings%number(entry, 'young')
      material%poisson = settings%number(entry, 'poisson')
      material%density = settings%number(entry, 'density')
   end subroutine fill_material

   !> One body, but for the position of its material.
   pure subroutine fill_body(settings, entry, body)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      type(body_t), intent(inout) :: body
      body%material = settings%text(entry, 'material')
      body%shape = settings%text(entry, 'shape')
      body%lower = vector(settings, entry, 'lower')
      body%upper = vector(settings, entry, 'upper')
      body%points_per_cell = nint(settings%number(entry, 'points_per_cell'))
      body%velocity = vector(settings, entry, 'velocity')
   end subroutine fill_body

   !> Position of the material of this name, 0 where there is none.
   pure integer function material_index(scene, name)
      type(scene_t), intent(in) :: scene
      character(*), intent(in) :: name
      do material_index = size(scene%materials), 1, -1
         if (scene%materials(material_index)%name == name) return
      end do
   end function material_index

   !> One constraint.
   pure subroutine fill_constraint(settings, entry, constraint)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      type(constraint_spec_t), intent(inout) :: constraint
      character(*), parameter :: axis = 'xyz'
      character(:), allocatable :: fix
      integer :: d
      constraint%lower = vector(settings, entry, 'lower')
      constraint%upper = vector(settings, entry, 'upper')
      fix = settings%text(entry, 'fix')
      constraint%fixed = [(index(fix, axis(d:d)) > 0, d=1, ndim)]
   end subroutine fill_constraint

   !> One load.
   pure subroutine fill_load(settings, entry, load)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      type(load_spec_t), intent(inout) :: load
      load%kind = settings%text(entry, 'kind')
      load%lower = vector(settings, entry, 'lower')
      load%upper = vector(settings, entry, 'upper')
      load%force = vector(settings, entry, 'force')
      load%history = settings%text(entry, 'history')
      load%start = settings%number(entry, 'start')
      load%rise_time = settings%number(entry, 'rise_time')
      load%frequency = settings%number(entry, 'frequency')
      load%times = settings%numbers(entry, 'times')
      load%factors = settings%numbers(entry, 'factors')
   end subroutine fill_load

   !> The components of a vector that a key holds.
   pure function vector(settings, entry, key)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      character(*), intent(in) :: key
      real(dp) :: vector(ndim)
      vector = 0
      if (settings%good(entry, key)) vector = settings%numbers(entry, key)
   end function vector
end module hampm_reading
