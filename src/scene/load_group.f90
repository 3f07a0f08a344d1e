!> The group &load: its row in the table of groups, its keys, and their values in a scene.
module hampm_load_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_history_values, only: history_keys, fill_history
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, type_text, must, may, repeats, is_optional, any_number
   use hampm_settings, only: settings_t
   use hampm_time_history, only: time_history_t
   implicit none
   private
   public :: load_group, load_keys, load_spec_t, fill_loads

   type(group_t), parameter :: load_group = group_t('load', repeats, is_optional, &
      'a force on the material, with its history in time')

   integer :: i                                  !! counts in the following table only

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: load_keys(*) = [ &
      key_t('load', 'kind', type_name, 1, 1, must, '', 'traction', '', &
            'point|traction|body|pressure|gravity', &
            'acts at a point, on a part of an edge, on material in a box, normal to an edge or crack, or on all material'), &
      key_t('load', 'lower', type_real, 0, ndim, may, '', '0.0, 0.0', 'm', &
            any_number, 'lower corner of where it acts; none of gravity and of pressure on a crack'), &
      key_t('load', 'upper', type_real, 0, ndim, may, '', '0.0, 0.01', 'm', &
            any_number, 'upper corner of where it acts, for a point equal to the lower one; none where lower is none'), &
      key_t('load', 'force', type_real, 0, ndim, may, '', '0.0, 1.0', 'N', &
            any_number, 'of a point, traction or body: resultant of the whole load where its factor is 1'), &
      key_t('load', 'pressure', type_real, 1, 1, may, '0.0', '', 'Pa', &
            any_number, 'of a pressure: force on each area where its factor is 1, positive into the material'), &
      key_t('load', 'on', type_name, 1, 1, may, 'edge', '', '', &
            'edge|crack', 'of a pressure: whether on a part of a body''s edge or on all faces of a crack'), &
      key_t('load', 'crack', type_text, 1, 1, may, '', '', '', &
            '', 'of a pressure on a crack: its name, not needed where there is only one'), &
      key_t('load', 'acceleration', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm/s2', &
            any_number, 'of gravity: force on each mass where its factor is 1'), &
      key_t('load', 'face', type_name, 1, 1, may, 'none', '', '', &
            'none|left|right', 'of a point or traction on a crack of kind line: its face, as one looks towards the tip'), &
      (key_t('load', history_keys(i)%name, history_keys(i)%value_type, history_keys(i)%fewest, history_keys(i)%most, &
             history_keys(i)%required, history_keys(i)%default, history_keys(i)%example, history_keys(i)%unit, &
             history_keys(i)%allowed, history_keys(i)%meaning), i=1, size(history_keys))]

   !> &load: a force and its history.
   type :: load_spec_t
      character(name_len) :: kind = ''           !! 'point', 'traction', 'body', 'pressure' or 'gravity'
      logical :: has_place = .true.              !! whether it acts in a box, else on all material or on a crack
      real(dp) :: lower(ndim) = 0                !! [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      real(dp) :: force(ndim) = 0                !! resultant of the whole load [N]
      character(name_len) :: face = ''           !! of a crack: 'none', 'left' or 'right'
      real(dp) :: pressure = 0                   !! positive into the material [Pa]
      character(name_len) :: crack = ''          !! name of the crack that the pressure is on
      real(dp) :: acceleration(ndim) = 0         !! [m/s2]
      type(time_history_t) :: history            !! of its factor
   end type load_spec_t

contains

   !> Take all groups of this name; values are 0, '' or empty where they are mistaken.
   pure subroutine fill_loads(settings, loads)
      type(settings_t), intent(in) :: settings
      type(load_spec_t), allocatable, intent(out) :: loads(:)
      integer :: i, entry
      allocate (loads(settings%count_of('load')))
      do i = 1, size(loads)
         entry = settings%find('load', i)
         associate (load => loads(i))
            load%kind = settings%text(entry, 'kind')
            load%has_place = load%kind /= 'gravity' .and. &
                             .not. (load%kind == 'pressure' .and. settings%text(entry, 'on') == 'crack')
            if (size(settings%numbers(entry, 'lower')) == ndim) load%lower = settings%vector(entry, 'lower')
            if (size(settings%numbers(entry, 'upper')) == ndim) load%upper = settings%vector(entry, 'upper')
            if (size(settings%numbers(entry, 'force')) == ndim) load%force = settings%vector(entry, 'force')
            load%pressure = settings%number(entry, 'pressure')
            load%crack = settings%text(entry, 'crack')
            load%acceleration = settings%vector(entry, 'acceleration')
            load%face = settings%text(entry, 'face')
            call fill_history(settings, entry, load%history)
         end associate
      end do
   end subroutine fill_loads
end module hampm_load_group
