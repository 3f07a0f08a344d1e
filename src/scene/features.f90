!> Features of a scene that no single key tells: predicates with names, by which rows of the table of rules (`hampm_rules`) mean them.
module hampm_features
   use hampm_kinds, only: dp
   use hampm_scene, only: scene_t, cuts_cells
   use hampm_settings, only: settings_t
   use hampm_values, only: parse_real
   implicit none
   private
   public :: has_feature, is_feature

   !> The names.
   character(*), parameter :: names(*) = [character(48) :: 'cells that are cut', 'several cracks', 'several bodies', &
                                          'edges that are no grid lines', 'samples at other times than load steps']

contains

   !> Whether a name is that of a feature.
   pure logical function is_feature(name)
      character(*), intent(in) :: name
      is_feature = any(names == name)
   end function is_feature

   !> Whether a scene has a feature.
   pure logical function has_feature(scene, settings, name) result(has)
      type(scene_t), intent(in) :: scene
      type(settings_t), intent(in) :: settings
      character(*), intent(in) :: name           !! one of `names`
      integer :: k
      has = .false.
      select case (name)
       case ('cells that are cut')               ! by cracks of kind 'path', polygons, circles and holes
         has = cuts_cells(scene)
       case ('several cracks')
         has = settings%count_of('crack') > 1
       case ('several bodies')
         has = size(scene%bodies) > 1
       case ('edges that are no grid lines')
         has = any([(scene%bodies(k)%outline%is_there(), k=1, size(scene%bodies))])
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
