!> The group &crack: its row in the table of groups, its keys, and their values in a scene.
module hampm_crack_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, must, may, once, is_optional, any_number, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: crack_group, crack_keys, crack_spec_t, fill_crack

   type(group_t), parameter :: crack_group = group_t('crack', once, is_optional, &
      'the crack; without this group the scene has none')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: crack_keys(*) = [ &
      key_t('crack', 'kind', type_name, 1, 1, may, 'symmetry', '', '', &
            'symmetry|line', 'along the constrained edge of a symmetric half, or along a grid line inside the material'), &
      key_t('crack', 'tip', type_real, ndim, ndim, must, '', '0.05, 0.0', 'm', &
            any_number, 'crack tip, on a node of the lattice; of two tips the one that direction points out of'), &
      key_t('crack', 'direction', type_real, ndim, ndim, may, '1.0, 0.0', '', '', &
            any_number, 'direction of growth, along a grid line'), &
      key_t('crack', 'length', type_real, 1, 1, may, '0.0', '', 'm', &
            not_negative, 'of a line with two tips: from one to the other; 0: it reaches the edge of the material'), &
      key_t('crack', 'contact', type_name, 1, 1, may, 'none', '', '', &
            'none|frictionless', 'of a line: whether its faces press on each other or go through')]

   !> &crack: where it is.
   type :: crack_spec_t
      logical :: present = .false.               !! whether the scene has a crack
      character(name_len) :: kind = 'symmetry'   !! 'symmetry' or 'line'
      real(dp) :: tip(ndim) = 0                  !! [m]
      real(dp) :: direction(ndim) = 0            !! unit vector along a grid line, from the crack into the body
      real(dp) :: length = 0                     !! of a line: distance between its two tips, 0: it reaches the edge [m]
      logical :: contact = .false.               !! whether the faces of a line press on each other, without friction
   end type crack_spec_t

contains

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_crack(settings, crack)
      type(settings_t), intent(in) :: settings
      type(crack_spec_t), intent(inout) :: crack
      integer :: entry
      entry = settings%find('crack', 1)
      crack%present = entry > 0
      crack%kind = settings%text(entry, 'kind')
      crack%tip = settings%vector(entry, 'tip')
      crack%direction = settings%vector(entry, 'direction')
      crack%length = settings%number(entry, 'length')
      crack%contact = settings%text(entry, 'contact') == 'frictionless'
   end subroutine fill_crack
end module hampm_crack_group
