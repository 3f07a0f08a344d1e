!> Features of a scene that no single key tells: predicates with names, by which rows of the table of rules (`hampm_rules`) mean them.
module hampm_features
   use hampm_kinds, only: dp
   use hampm_load_placement, only: pressed_path, is_on_faces
   use hampm_scene, only: scene_t, cuts_cells, mass_acts
   use hampm_settings, only: settings_t
   use hampm_values, only: parse_real
   implicit none
   private
   public :: has_feature, is_feature

   !> The names.
   character(*), parameter :: names(*) = [character(48) :: &
      'cells that are cut', 'several cracks', 'several bodies', 'edges that are no grid lines', 'growth by laws of both kinds', &
      'a shear of the eigenstrain', 'a fourth value of the eigenstrain', &
      'a pressed path that grows in motion', 'samples at other times than load steps', 'a body of it', &
      'another body of that part', 'a mass matrix that acts', 'quadratic cells at an axis']

contains

   !> Whether a name is that of a feature.
   pure logical function is_feature(name)
      character(*), intent(in) :: name
      is_feature = any(names == name)
   end function is_feature

   !> Whether a scene, or one of its groups where the feature is about such, has a feature.
   pure logical function has_feature(scene, settings, name, entry) result(has)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      character(*), intent(in) :: name           !! one of `names`
      integer, intent(in) :: entry               !! position of the group that the rule is about
      real(dp), allocatable :: strain(:)
      integer :: k
      has = .false.
      select case (name)
       case ('cells that are cut')               ! by cracks of kind 'path', polygons, circles and holes
         has = cuts_cells(scene)
       case ('a mass matrix that acts')
         has = mass_acts(scene)
       case ('quadratic cells at an axis')
         has = scene%run%thickness%is_ring .and. scene%grid%order > 1 .and. .not. scene%grid%lower(1) > 0
       case ('several cracks')
         has = settings%count_of('crack') > 1
       case ('several bodies')
         has = size(scene%bodies) > 1
       case ('edges that are no grid lines')
         has = any([(scene%bodies(k)%outline%is_there(), k=1, size(scene%bodies))])
       case ('growth by laws of both kinds')
         has = any(scene%growth%is_at_rest()) .and. .not. all(scene%growth%is_at_rest())
       case ('a body of it')                     ! of a material
         has = any(scene%materials%name == settings%text(entry, 'name'))
       case ('another body of that part')
         has = count(scene%bodies%part == settings%text(entry, 'part')) > 1
       case ('a shear of the eigenstrain', 'a fourth value of the eigenstrain')
         strain = settings%numbers(entry, 'eigenstrain')
         k = merge(3, 4, name == 'a shear of the eigenstrain')
         if (size(strain) >= k) has = abs(strain(k)) > 0
       case ('a pressed path that grows in motion')
         do k = 1, size(scene%loads)
            if (.not. is_on_faces(scene%loads(k)) .or. pressed_path(scene, scene%loads(k)) == 0) cycle
            has = has .or. any(scene%growth%path == pressed_path(scene, scene%loads(k)) .and. .not. scene%growth%is_at_rest())
         end do
       case ('samples at other times than load steps')
         has = scene%method%time == 'static' .and. asks_for_other_samples(settings, settings%find('output', 1))
      end select
   end function has_feature

   !> Whether the interval of the samples is not that of the load steps, by which it was replaced.
   pure logical function asks_for_other_samples(settings, output) result(asks)
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: output              !! position of the group, 0 for none
      real(dp), parameter :: alike = 1e-9_dp
      real(dp) :: wanted
      integer :: status
      asks = .false.
      if (.not. (settings%given(output, 'history_interval') .and. settings%good(output, 'history_interval'))) return
      associate (group => settings%entries(output))
         call parse_real(group%settings(findloc(group%keys == 'history_interval', .true., dim=1))%values(1)%text, wanted, status)
      end associate
      asks = wanted > 0 .and. abs(wanted - settings%number(output, 'history_interval')) > alike*wanted
   end function asks_for_other_samples
end module hampm_features
