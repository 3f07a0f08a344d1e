!> The group &refine: its row in the table of groups, its keys, and their values in a scene.
module hampm_refine_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_integer, type_name, may, once, is_optional, any_number, &
                             positive, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: refine_group, refine_keys, refine_t, fill_refine

   type(group_t), parameter :: refine_group = group_t('refine', once, is_optional, &
      'where cells refine; without this group they never do')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: refine_keys(*) = [ &
      key_t('refine', 'indicator', type_name, 1, 1, may, 'none', 'tip', '', &
            'none|gradient|zz|tip', 'what tells which cells refine: gradients, the estimated error, the distance to the tip'), &
      key_t('refine', 'field', type_name, 1, 1, may, 'energy_density', '', '', &
            'energy_density|stress_norm|speed', 'of indicator = ''gradient'': the field whose gradients count'), &
      key_t('refine', 'r_crit', type_real, 1, 1, may, '0.03', '', '', &
            positive, 'of ''gradient'': cells whose mean R is above it refine'), &
      key_t('refine', 'r_coarsen', type_real, 1, 1, may, '0.0', '', '', &
            not_negative, 'of ''gradient'': cells whose mean R is below it recombine; 0: never; below r_crit'), &
      key_t('refine', 'tolerance', type_real, 1, 1, may, '0.02', '', '', &
            '(0, 1)', 'of ''zz'': relative error in the energy norm that is aimed at'), &
      key_t('refine', 'rings', type_integer, 1, 1, may, '4', '', '', &
            '[1, 1000]', 'of ''tip'': cells within so many cells of a crack tip refine, level by level'), &
      key_t('refine', 'max_level', type_integer, 1, 1, may, '4', '2', '', &
            '[0, 20]', 'how often a root cell may be divided; its size is halved each time'), &
      key_t('refine', 'energy_floor', type_real, 1, 1, may, '1e-3', '', '', &
            '[0, 1)', 'of ''gradient'': cells whose field is below this part of its largest value do not refine'), &
      key_t('refine', 'region_lower', type_real, 0, ndim, may, '', '0.04, 0.0', 'm', &
            any_number, 'lower corner of the box in which cells may refine; without limit by default'), &
      key_t('refine', 'region_upper', type_real, 0, ndim, may, '', '0.06, 0.01', 'm', &
            any_number, 'upper corner of the box in which cells may refine; without limit by default'), &
      key_t('refine', 'start', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'time of the first look at gradient or zz: loads that begin make steep fronts'), &
      key_t('refine', 'interval', type_integer, 1, 1, may, '100', '', '', &
            '[1, inf)', 'steps between looks at the indicator'), &
      key_t('refine', 'max_particles', type_integer, 1, 1, may, '1000000', '', '', &
            '[1, 2e9]', 'most material points; where there would be more, refinement ends with a warning')]

   !> &refine: where cells refine.
   type :: refine_t
      logical :: present = .false.               !! whether the scene has the group
      character(name_len) :: indicator = 'none'  !! 'none', 'gradient', 'zz' or 'tip'; 'none' where the group is absent
      character(name_len) :: field = ''          !! of gradient: 'energy_density', 'stress_norm' or 'speed'
      real(dp) :: r_crit = 0                     !! of gradient: mean R of a cell above which it refines [-]
      real(dp) :: r_coarsen = 0                  !! of gradient: R below which families recombine, 0: never [-]
      real(dp) :: tolerance = 0                  !! of zz: relative error in the energy norm [-]
      integer :: rings = 0                       !! of tip: distance from the tip, in cells of each level
      integer :: max_level = 0                   !! level of the finest cells, 0: the root cells
      real(dp) :: energy_floor = 0               !! of gradient: part of its largest value below which the field is not looked at
      real(dp) :: region_lower(ndim) = -huge(1.0_dp)   !! box in which cells may refine [m]; -huge and huge where it has no
      real(dp) :: region_upper(ndim) = huge(1.0_dp)    !! limit: compare with them, their difference overflows
      real(dp) :: start = 0                      !! time of the first look at gradient or zz [s]
      integer :: interval = 1                    !! steps between looks at the indicator
      integer :: max_particles = 0               !! refinement ends where there would be more particles
   end type refine_t

contains

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_refine(settings, refine)
      type(settings_t), intent(in) :: settings
      type(refine_t), intent(inout) :: refine
      integer :: entry
      entry = settings%find('refine', 1)
      refine%present = entry > 0
      if (.not. refine%present) return
      refine%indicator = settings%text(entry, 'indicator')
      refine%field = settings%text(entry, 'field')
      refine%r_crit = settings%number(entry, 'r_crit')
      refine%r_coarsen = settings%number(entry, 'r_coarsen')
      refine%tolerance = settings%number(entry, 'tolerance')
      refine%rings = nint(settings%number(entry, 'rings'))
      refine%max_level = nint(settings%number(entry, 'max_level'))
      refine%energy_floor = settings%number(entry, 'energy_floor')
      if (size(settings%numbers(entry, 'region_lower')) == ndim) refine%region_lower = settings%numbers(entry, 'region_lower')
      if (size(settings%numbers(entry, 'region_upper')) == ndim) refine%region_upper = settings%numbers(entry, 'region_upper')
      refine%start = settings%number(entry, 'start')
      refine%interval = nint(settings%number(entry, 'interval'))
      refine%max_particles = nint(settings%number(entry, 'max_particles'))
   end subroutine fill_refine
end module hampm_refine_group
