!> The group &crack: its row in the table of groups, its keys, and their values in a scene.
module hampm_crack_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_name, type_text, may, repeats, is_optional, any_number, not_negative, &
                             max_values
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: crack_group, crack_keys, crack_spec_t, path_spec_t, fill_crack, fill_paths

   type(group_t), parameter :: crack_group = group_t('crack', repeats, is_optional, &
      'a crack; without this group the scene has none. Only those of kind path may be several')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: crack_keys(*) = [ &
      key_t('crack', 'kind', type_name, 1, 1, may, 'symmetry', '', '', &
            'symmetry|line|path', &
            'along the constrained edge of a symmetric half, or in the material along a grid line, or anywhere'), &
      key_t('crack', 'tip', type_real, 0, ndim, may, '', '0.05, 0.0', 'm', &
            any_number, 'crack tip, on a node of the lattice; of two tips the one that direction points out of; none of a path'), &
      key_t('crack', 'direction', type_real, ndim, ndim, may, '1.0, 0.0', '', '', &
            any_number, 'direction of growth, along a grid line'), &
      key_t('crack', 'length', type_real, 1, 1, may, '0.0', '', 'm', &
            not_negative, 'of a line with two tips: from one to the other; 0: it reaches the edge of the material'), &
      key_t('crack', 'contact', type_name, 1, 1, may, 'none', '', '', &
            'none|frictionless|friction', &
            'of a line, without friction, or a path: whether faces press on each other or go through'), &
      key_t('crack', 'friction', type_real, 1, 1, may, '0.0', '', '', &
            not_negative, 'of a path with contact = ''friction'': coefficient'), &
      key_t('crack', 'points', type_real, 0, max_values, may, '', '', 'm', &
            any_number, 'of a path: x1, y1, x2, y2, ..., as one walks along it; ends inside the material are tips'), &
      key_t('crack', 'name', type_text, 1, 1, may, '', '', '', &
            '', 'of a path: by which other groups mean it')]

   !> &crack: where it is.
   type :: crack_spec_t
      logical :: present = .false.               !! whether the scene has a crack
      character(name_len) :: kind = ''           !! 'symmetry' or 'line'
      real(dp) :: tip(ndim) = 0                  !! [m]
      real(dp) :: direction(ndim) = 0            !! unit vector along a grid line, from the crack into the body
      real(dp) :: length = 0                     !! of a line: distance between its two tips, 0: it reaches the edge [m]
      logical :: contact = .false.               !! whether the faces of a line press on each other, without friction
   end type crack_spec_t

   !> &crack of kind 'path'.
   type :: path_spec_t
      character(name_len) :: name = ''           !! '' for none
      integer :: number = 0                      !! of the group, among all &crack
      logical :: contact = .false.               !! whether its faces press on each other
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp), allocatable :: points(:, :)      !! [m], (ndim, points)
   end type path_spec_t

contains

   !> Take the values of the keys of the crack that is no path; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_crack(settings, crack)
      type(settings_t), intent(in) :: settings
      type(crack_spec_t), intent(inout) :: crack
      integer :: entry
      entry = settings%find('crack', 1)
      crack%present = entry > 0
      if (entry > 0) crack%present = settings%text(entry, 'kind') /= 'path'
      if (.not. crack%present) return
      crack%kind = settings%text(entry, 'kind')
      if (size(settings%numbers(entry, 'tip')) == ndim) crack%tip = settings%vector(entry, 'tip')
      crack%direction = settings%vector(entry, 'direction')
      crack%length = settings%number(entry, 'length')
      crack%contact = settings%text(entry, 'contact') == 'frictionless'
   end subroutine fill_crack

   !> Take all groups of kind 'path'. An odd number of coordinates leaves the last one out.
   pure subroutine fill_paths(settings, paths)
      type(settings_t), intent(in) :: settings
      type(path_spec_t), allocatable, intent(out) :: paths(:)
      integer :: k, n, entry
      n = 0
      do k = 1, settings%count_of('crack')
         if (settings%text(settings%find('crack', k), 'kind') == 'path') n = n + 1
      end do
      allocate (paths(n))
      n = 0
      do k = 1, settings%count_of('crack')
         entry = settings%find('crack', k)
         if (settings%text(entry, 'kind') /= 'path') cycle
         n = n + 1
         paths(n)%name = settings%text(entry, 'name')
         paths(n)%number = k
         paths(n)%contact = settings%text(entry, 'contact') /= 'none'
         if (settings%text(entry, 'contact') == 'friction') paths(n)%friction = settings%number(entry, 'friction')
         associate (numbers => settings%numbers(entry, 'points'))
            paths(n)%points = reshape(numbers, [ndim, size(numbers)/ndim])
         end associate
      end do
   end subroutine fill_paths
end module hampm_crack_group
