!> The group &probe: its row in the table of groups, its keys, and their values in a model.
module hampm_probe_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, type_text, repeats, is_optional, any_number, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: probe_group, probe_keys, probe_t, fill_probes

   type(group_t), parameter :: probe_group = group_t('probe', repeats, is_optional, &
      'what the history records at a point, along a line, of a crack, or of a load', is_apart=.true.)

   integer, parameter :: most_quantities = 4

   type(key_t), parameter :: probe_keys(*) = [ &
      key_t('name', type_text, 'what the names of its columns end with, before x, y, xx, yy, xy or zz', example='gauge', &
            required=.true.), &
      key_t('quantity', type_name, 'what is recorded, one or several', example='strain', required=.true., most=most_quantities, &
            allowed='displacement|velocity|stress|strain|opening|volume|load_line'), &
      key_t('at', type_real, 'a material point, x, y; or a straight line from x1, y1 to x2, y2, of which the mean is recorded', &
            example='0.02, 0.01, 0.03, 0.01', unit='m', allowed=any_number, fewest=0, most=2*ndim), &
      key_t('face', type_name, 'of a point on a crack: its face, as one walks to the tip or last point of the crack', &
            default='none', allowed='none|left|right'), &
      key_t('of', type_text, 'of opening or volume: name of the crack; of load_line: of the load or constraint, and of another '// &
            'it moves from', fewest=0, most=2), &
      key_t('tip', type_name, 'of opening: at which end of its crack the tip is', default='last', allowed='last|first'), &
      key_t('distance', type_real, 'of opening: how far behind that tip, along the crack', default='0.0', unit='m', &
            allowed=not_negative)]

   !> &probe.
   type :: probe_t
      character(name_len) :: name = ''
      character(name_len) :: quantities(most_quantities) = '' !! '' behind the last one
      real(dp), allocatable :: at(:, :)          !! [m], (ndim, 0 to 2)
      character(name_len) :: face = 'none'       !! 'none', 'left' or 'right'
      character(name_len) :: of(2) = ''
      character(name_len) :: tip = 'last'
      real(dp) :: distance = 0                   !! [m]
   contains
      procedure :: gives
   end type probe_t

contains

   !> Whether it records a quantity.
   pure logical function gives(self, quantity)
      class(probe_t), intent(in) :: self
      character(*), intent(in) :: quantity
      gives = any(self%quantities == quantity)
   end function gives

   !> Take all groups of this name. An odd number of coordinates leaves the last one out.
   pure subroutine fill_probes(settings, probes)
      type(settings_t), intent(in) :: settings
      type(probe_t), allocatable, intent(out) :: probes(:)
      real(dp), allocatable :: numbers(:)
      integer :: k, i, entry
      allocate (probes(settings%count_of('probe')))
      do k = 1, size(probes)
         entry = settings%find('probe', k)
         associate (probe => probes(k))
            probe%name = settings%text(entry, 'name')
            do i = 1, most_quantities
               probe%quantities(i) = settings%text(entry, 'quantity', i)
            end do
            do i = 1, 2
               probe%of(i) = settings%text(entry, 'of', i)
            end do
            numbers = settings%numbers(entry, 'at')
            probe%at = reshape(numbers, [ndim, size(numbers)/ndim])
            probe%face = settings%text(entry, 'face')
            probe%tip = settings%text(entry, 'tip')
            probe%distance = settings%number(entry, 'distance')
         end associate
      end do
   end subroutine fill_probes
end module hampm_probe_group
