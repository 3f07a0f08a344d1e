!> Features of a scene that no single key tells: predicates with names, by which rows of the table of rules (`hampm_rules`) mean them.
module hampm_features
   use hampm_scene, only: scene_t, cuts_cells
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: has_feature, is_feature

   !> The names.
   character(*), parameter :: names(*) = [character(48) :: 'cells that are cut', 'several cracks', 'several bodies', &
                                          'edges that are no grid lines']

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
      end select
   end function has_feature
end module hampm_features
