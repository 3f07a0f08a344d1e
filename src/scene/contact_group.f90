!> The group &contact: its row in the table of groups, its keys, and their values in a scene.
module hampm_contact_group
   use hampm_kinds, only: dp, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, may, once, is_assumed, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: contact_group, contact_keys, body_contact_spec_t, fill_contact

   type(group_t), parameter :: contact_group = group_t('contact', once, is_assumed, 'how bodies that meet act on each other')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: contact_keys(*) = [ &
      key_t('contact', 'bodies', type_name, 1, 1, may, 'joined', '', '', &
            'joined|stick|frictionless|friction', &
            'joined: one velocity field, in which they stick; else one for each: those that touch stick, or slide'), &
      key_t('contact', 'friction', type_real, 1, 1, may, '0.0', '', '', &
            not_negative, 'of bodies = ''friction'': coefficient'), &
      key_t('contact', 'distance', type_real, 1, 1, may, '0.0', '', 'm', &
            not_negative, 'gap between their surfaces at which bodies touch')]

   !> &contact.
   type :: body_contact_spec_t
      character(name_len) :: bodies = 'joined'   !! 'joined', 'stick', 'frictionless' or 'friction'
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: distance = 0                   !! gap at which they touch [m]
   contains
      procedure :: is_wanted
   end type body_contact_spec_t

contains

   !> Whether bodies have velocity fields of their own.
   pure logical function is_wanted(self)
      class(body_contact_spec_t), intent(in) :: self
      is_wanted = self%bodies == 'stick' .or. self%bodies == 'frictionless' .or. self%bodies == 'friction'
   end function is_wanted

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_contact(settings, contact)
      type(settings_t), intent(in) :: settings
      type(body_contact_spec_t), intent(inout) :: contact
      integer :: entry
      entry = settings%find('contact', 1)
      contact%bodies = settings%text(entry, 'bodies')
      contact%friction = settings%number(entry, 'friction')
      contact%distance = settings%number(entry, 'distance')
   end subroutine fill_contact
end module hampm_contact_group
