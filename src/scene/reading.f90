!> From a namelist file to a scene. Files of scenes are read here and nowhere else.
module hampm_reading
   use hampm_consistency, only: check_consistency
   use hampm_failure, only: failure_t
   use hampm_kinds, only: dp, ndim
   use hampm_namelist_file, only: read_text, scan_namelist
   use hampm_namelist_text, only: canonical_text
   use hampm_overrides, only: override
   use hampm_rule_check, only: check_rules
   use hampm_scene, only: scene_t, fill_scene
   use hampm_settings, only: settings_t
   use hampm_stability_consistency, only: choose_courant
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
      integer :: i
      settings%file = path
      call scan_namelist(path, text, settings)
      do i = 1, size(overrides)
         call override(overrides(i)%text, settings)
      end do
      call validate(settings)
      call resolve(settings)
      call fill_scene(settings, scene)
      call choose_courant(scene, settings)
      scene%warned = ''
      scene%noted = ''
      call check_rules(scene, settings, scene%warned, scene%noted)
      call check_consistency(scene, settings)
      call settings%mistakes%tell(failure)
      if (.not. failure%failed()) scene%as_used = canonical_text(settings)
   end subroutine understand_scene

   !> Replace values that stand for another one by that one.
   pure subroutine resolve(settings)
      type(settings_t), intent(inout) :: settings
      real(dp) :: direction(ndim)
      character(:), allocatable :: solver, time
      integer :: run, output, crack, method
      run = settings%find('run', 1)
      output = settings%find('output', 1)
      crack = settings%find('crack', 1)
      method = settings%find('method', 1)
      time = settings%text(method, 'time')
      if (.not. settings%given(output, 'file')) call settings%set_text(output, 'file', result_file(settings%file))
      if (settings%good(output, 'history_interval') .and. settings%good(run, 'end_time')) then
         if (settings%number(output, 'history_interval') <= 0) &
            call settings%set_numbers(output, 'history_interval', [max(settings%number(run, 'end_time')/1000, least_magnitude)])
         if (time == 'static' .and. settings%good(method, 'load_steps')) &
            call settings%set_numbers(output, 'history_interval', [max(settings%number(run, 'end_time') &
                                                                       /settings%number(method, 'load_steps'), least_magnitude)])
      end if
      if (time == 'implicit' .and. settings%good(run, 'end_time') .and. settings%good(method, 'time_step') &
          .and. settings%good(method, 'courant')) then
         if (settings%number(method, 'time_step') <= 0 .and. settings%number(method, 'courant') <= 0) &
            call settings%set_numbers(method, 'time_step', [max(settings%number(run, 'end_time')/1000, least_magnitude)])
      end if
      if (settings%text(method, 'solver') == 'auto') then
         solver = 'cg'
         if (time == 'static' .or. time == 'implicit' .or. cuts_quadratic_cells(settings)) solver = 'direct'
         call settings%set_text(method, 'solver', solver)
      end if
      if (settings%good(crack, 'direction')) then
         direction = settings%numbers(crack, 'direction')
         direction = direction/max(maxval(abs(direction)), least_magnitude)
         where (abs(direction) < 1e-9_dp) direction = 0
         call settings%set_numbers(crack, 'direction', direction)
      end if
   end subroutine resolve

   !> Whether cells are quadratic, and cracks or edges cut them: iterations that take each cell by itself are not for these.
   pure logical function cuts_quadratic_cells(settings) result(cuts)
      type(settings_t), intent(in) :: settings
      integer :: k
      cuts = .false.
      if (.not. settings%good(settings%find('grid', 1), 'order')) return
      if (settings%number(settings%find('grid', 1), 'order') < 2) return
      cuts = any([(settings%text(settings%find('crack', k), 'kind') == 'path', k=1, settings%count_of('crack'))]) .or. &
             any([(settings%text(settings%find('body', k), 'shape') /= 'rectangle' .or. &
                   settings%flag(settings%find('body', k), 'hole'), k=1, settings%count_of('body'))])
   end function cuts_quadratic_cells

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
end module hampm_reading
