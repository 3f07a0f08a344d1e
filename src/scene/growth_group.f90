!> The group &growth: its row in the table of groups, its keys, and their values in a scene.
module hampm_growth_group
   use hampm_kinds, only: dp, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, type_text, must, may, repeats, is_optional, positive, &
                             not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: growth_group, growth_keys, growth_t, fill_growth

   type(group_t), parameter :: growth_group = group_t('growth', repeats, is_optional, &
      'how a crack of kind path grows; without this group cracks stay as they are', is_apart=.true.)

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: growth_keys(*) = [ &
      key_t('growth', 'crack', type_text, 1, 1, may, '', 'a', '', &
            '', 'name of the crack; may be left out where there is one crack'), &
      key_t('growth', 'law', type_name, 1, 1, may, 'quasi_static', '', '', &
            'quasi_static', 'by increments, under loads that are scaled so that the largest G is the toughness'), &
      key_t('growth', 'direction', type_name, 1, 1, may, 'hoop_stress', '', '', &
            'straight|hoop_stress|local_symmetry|max_energy', 'where tips go to'), &
      key_t('growth', 'toughness', type_real, 1, 1, must, '', '100.0', 'J/m2', &
            positive, 'energy release rate at which the crack grows'), &
      key_t('growth', 'increment', type_real, 1, 1, must, '', '1e-3', 'm', &
            positive, 'by which a tip advances in a load step'), &
      key_t('growth', 'max_length', type_real, 1, 1, may, '0.0', '', 'm', &
            not_negative, 'length of the whole crack at which it stops; 0: none'), &
      key_t('growth', 'tips', type_name, 1, 1, may, 'all', '', '', &
            'all|largest', 'which tips of the crack advance: all, or the one with the largest G')]

   !> &growth: how a crack grows.
   type :: growth_t
      character(name_len) :: crack = ''          !! name of the crack; '' where there is one
      integer :: path = 0                        !! its number among the paths of the scene, 0 where there is none of the name
      character(name_len) :: law = ''            !! 'quasi_static'
      character(name_len) :: direction = ''      !! 'straight', 'hoop_stress', 'local_symmetry' or 'max_energy'
      real(dp) :: toughness = 0                  !! [J/m2]
      real(dp) :: increment = 0                  !! [m]
      real(dp) :: max_length = 0                 !! 0: none [m]
      logical :: only_largest = .false.          !! whether only the tip with the largest G advances
   end type growth_t

contains

   !> Take all groups of this name.
   pure subroutine fill_growth(settings, growth)
      type(settings_t), intent(in) :: settings
      type(growth_t), allocatable, intent(out) :: growth(:)
      integer :: k, entry
      allocate (growth(settings%count_of('growth')))
      do k = 1, size(growth)
         entry = settings%find('growth', k)
         growth(k)%crack = settings%text(entry, 'crack')
         growth(k)%law = settings%text(entry, 'law')
         growth(k)%direction = settings%text(entry, 'direction')
         growth(k)%toughness = settings%number(entry, 'toughness')
         growth(k)%increment = settings%number(entry, 'increment')
         growth(k)%max_length = settings%number(entry, 'max_length')
         growth(k)%only_largest = settings%text(entry, 'tips') == 'largest'
      end do
   end subroutine fill_growth
end module hampm_growth_group
