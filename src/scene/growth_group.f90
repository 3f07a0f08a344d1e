!> The group &growth: its row in the table of groups, its keys, and their values in a scene.
module hampm_growth_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, type_text, must, may, repeats, is_optional, positive, &
                             not_negative, any_number, max_values
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: growth_group, growth_keys, growth_t, fill_growth

   type(group_t), parameter :: growth_group = group_t('growth', repeats, is_optional, &
      'how a crack of kind path or symmetry grows; without this group cracks stay as they are', is_apart=.true.)

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: growth_keys(*) = [ &
      key_t('growth', 'crack', type_text, 1, 1, may, '', 'a', '', &
            '', 'name of the crack; may be left out where there is one crack'), &
      key_t('growth', 'law', type_name, 1, 1, may, 'quasi_static', '', '', &
            'quasi_static|prescribed|toughness', &
            'at rest, by increments under loads that are scaled; in motion, at a given speed or as the toughness lets it'), &
      key_t('growth', 'direction', type_name, 1, 1, may, 'hoop_stress', '', '', &
            'straight|hoop_stress|local_symmetry|max_energy|path', 'where tips go to; path: along points'), &
      key_t('growth', 'points', type_real, 0, max_values, may, '', '', 'm', &
            any_number, 'of direction = path: x, y of each point, in the order in which the tip comes to them'), &
      key_t('growth', 'toughness', type_real, 1, 1, may, '0.0', '100.0', 'J/m2', &
            not_negative, 'energy release rate at which the crack grows, of the laws quasi_static and toughness'), &
      key_t('growth', 'limit_speed', type_real, 1, 1, may, '0.0', '', 'm/s', &
            not_negative, 'of law = toughness, which at speed v is toughness/(1 - (v/limit_speed)**exponent); '// &
            '0: it is constant'), &
      key_t('growth', 'exponent', type_real, 1, 1, may, '1.0', '', '', &
            positive, 'of that'), &
      key_t('growth', 'speed', type_real, 1, 1, may, '0.0', '', 'm/s', &
            not_negative, 'of law = prescribed'), &
      key_t('growth', 'start', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'from when on this &growth applies, in motion'), &
      key_t('growth', 'end', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'until when; 0: to the end of the run'), &
      key_t('growth', 'increment', type_real, 1, 1, may, '0.0', '1e-3', 'm', &
            not_negative, 'of law = quasi_static: by which a tip advances in a load step'), &
      key_t('growth', 'max_length', type_real, 1, 1, may, '0.0', '', 'm', &
            not_negative, 'length of the whole crack at which it stops; 0: none'), &
      key_t('growth', 'tips', type_name, 1, 1, may, 'all', '', '', &
            'all|largest|last|first', &
            'which tips go on: all, at rest that with the largest G, in motion that at the last or the first point')]

   !> &growth: how a crack grows.
   type :: growth_t
      character(name_len) :: crack = ''          !! name of the crack; '' where there is one
      integer :: path = 0                        !! number of the path, or 1 of a crack on a symmetry plane; 0: there is no such one
      character(name_len) :: law = ''            !! 'quasi_static', 'prescribed' or 'toughness'
      character(name_len) :: direction = ''      !! 'straight', 'hoop_stress', 'local_symmetry', 'max_energy' or 'path'
      real(dp), allocatable :: points(:, :)      !! of 'path' [m], (ndim, any)
      real(dp) :: limit_speed = 0                !! 0: the toughness is constant [m/s]
      real(dp) :: exponent = 1
      real(dp) :: speed = 0                      !! [m/s]
      real(dp) :: start = 0                      !! from when on it applies [s]
      real(dp) :: end = huge(1.0_dp)             !! until when [s]
      real(dp) :: toughness = 0                  !! [J/m2]
      real(dp) :: increment = 0                  !! [m]
      real(dp) :: max_length = 0                 !! 0: none [m]
      logical :: only_largest = .false.          !! whether only the tip with the largest G advances
      logical :: of_end(2) = .true.              !! whether the tip at the first and that at the last point do
   contains
      procedure :: is_at_rest
      procedure :: toughness_at
      procedure :: turns
   end type growth_t

contains

   !> Whether the crack grows at rest, by increments.
   pure elemental logical function is_at_rest(self)
      class(growth_t), intent(in) :: self
      is_at_rest = self%law == 'quasi_static'
   end function is_at_rest

   !> Whether the crack turns by itself, as its modes have it.
   pure logical function turns(self)
      class(growth_t), intent(in) :: self
      turns = self%direction /= 'straight' .and. self%direction /= 'path'
   end function turns

   !> Toughness at a speed [J/m2]; huge from `limit_speed` on.
   pure real(dp) function toughness_at(self, speed)
      class(growth_t), intent(in) :: self
      real(dp), intent(in) :: speed              !! [m/s]
      real(dp), parameter :: least = 1e-12_dp    ! so that nothing overflows
      toughness_at = self%toughness
      if (self%limit_speed > 0) toughness_at = toughness_at/max(1 - min(speed/self%limit_speed, 1.0_dp)**self%exponent, least)
   end function toughness_at

   !> Take all groups of this name.
   pure subroutine fill_growth(settings, growth)
      type(settings_t), intent(in) :: settings
      type(growth_t), allocatable, intent(out) :: growth(:)
      real(dp), allocatable :: numbers(:)
      integer :: k, entry
      allocate (growth(settings%count_of('growth')))
      do k = 1, size(growth)
         entry = settings%find('growth', k)
         growth(k)%crack = settings%text(entry, 'crack')
         growth(k)%law = settings%text(entry, 'law')
         growth(k)%direction = settings%text(entry, 'direction')
         numbers = settings%numbers(entry, 'points')
         growth(k)%points = reshape(numbers, [ndim, size(numbers)/ndim])
         growth(k)%toughness = settings%number(entry, 'toughness')
         growth(k)%limit_speed = settings%number(entry, 'limit_speed')
         growth(k)%exponent = settings%number(entry, 'exponent')
         growth(k)%speed = settings%number(entry, 'speed')
         growth(k)%start = settings%number(entry, 'start')
         if (settings%number(entry, 'end') > 0) growth(k)%end = settings%number(entry, 'end')
         growth(k)%increment = settings%number(entry, 'increment')
         growth(k)%max_length = settings%number(entry, 'max_length')
         growth(k)%only_largest = settings%text(entry, 'tips') == 'largest'
         growth(k)%of_end = [settings%text(entry, 'tips') /= 'last', settings%text(entry, 'tips') /= 'first']
      end do
   end subroutine fill_growth
end module hampm_growth_group
