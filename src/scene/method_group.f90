!> The group &method: its row in the table of groups, its keys, and their values in a scene.
module hampm_method_group
   use hampm_kinds, only: dp, ndim, name_len
   use hampm_key_rows, only: group_t, key_t, type_real, type_integer, type_name, may, once, is_assumed, any_number, not_negative
   use hampm_settings, only: settings_t
   implicit none
   private
   public :: method_group, method_keys, method_t, fill_method

   type(group_t), parameter :: method_group = group_t('method', once, is_assumed, 'how the equations of motion are integrated')

   ! group, name, type, fewest values, most values, required, default, example, unit,
   !    allowed, meaning
   type(key_t), parameter :: method_keys(*) = [ &
      key_t('method', 'time', type_name, 1, 1, may, 'explicit', '', '', &
            'explicit|implicit|static', &
            'how motion is followed: by short explicit steps, by implicit ones, or from equilibrium to equilibrium'), &
      key_t('method', 'time_step', type_real, 1, 1, may, '0.0', '', 's', &
            not_negative, 'of time = ''implicit'': longest time step; 0: by courant, and 1/1000 of end_time where that is 0'), &
      key_t('method', 'hht_alpha', type_real, 1, 1, may, '0.0', '', '', &
            '[-0.33334, 0]', 'of time = ''implicit'': 0 for average acceleration; below it steps damp what they do not resolve'), &
      key_t('method', 'load_steps', type_integer, 1, 1, may, '1', '', '', &
            '[1, 100000]', 'of time = ''static'': equal steps of the time, by which loads vary, up to end_time'), &
      key_t('method', 'scheme', type_name, 1, 1, may, 'musl', '', '', &
            'usf|usl|usavg|musl', &
            'when a step updates the stress: first, last, half and half, or last by velocities mapped anew'), &
      key_t('method', 'courant', type_real, 1, 1, may, '0.0', '', '', &
            '[0, 1000]', 'time step over cell size / wave speed; 0: 0.9 of the limit, in the updated frame 0.1 or less'), &
      key_t('method', 'path', type_name, 1, 1, may, 'fastest', '', '', &
            'fastest|reference', 'of explicit steps: the fastest one for the scene, or the step that is there to be read'), &
      key_t('method', 'wave_speed', type_name, 1, 1, may, 'shear', '', '', &
            'shear|dilatational', 'which wave speed courant refers to'), &
      key_t('method', 'time_steps', type_name, 1, 1, may, 'global', '', '', &
            'global|local', 'one for all cells, that of the smallest, or longer ones for larger cells'), &
      key_t('method', 'frame', type_name, 1, 1, may, 'total', '', '', &
            'updated|total', 'shape functions at the present positions, for bodies that meet, or always at the initial ones'), &
      key_t('method', 'functions', type_name, 1, 1, may, 'linear', '', '', &
            'linear|cpdi', 'of a particle in frame = ''updated'': of its place, or the mean over the corners of its domain'), &
      key_t('method', 'mass', type_name, 1, 1, may, 'lumped', '', '', &
            'lumped|full|partial|fmpm|blend', &
            'mass matrix: by row sums, consistent, so in some cells, a series for its inverse, or a mean of both'), &
      key_t('method', 'order', type_integer, 1, 1, may, '2', '', '', &
            '[1, 100]', 'of mass = ''fmpm'': number of terms of the series; 1 is lumped'), &
      key_t('method', 'blend', type_real, 1, 1, may, '0.2778', '', '', &
            '[0, 1]', 'of mass = ''blend'': part that is lumped; 5/18 has the least dispersion in short steps'), &
      key_t('method', 'full_region', type_name, 1, 1, may, 'box', '', '', &
            'box|refined', 'of mass = ''partial'': it is full in a box, or in the cells that are refined'), &
      key_t('method', 'full_lower', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm', &
            any_number, 'of full_region = ''box'': lower corner of the box in which mass = ''partial'' is full'), &
      key_t('method', 'full_upper', type_real, ndim, ndim, may, '0.0, 0.0', '', 'm', &
            any_number, 'of full_region = ''box'': upper corner of this box; needed there'), &
      key_t('method', 'solver', type_name, 1, 1, may, 'auto', '', '', &
            'auto|cg|direct', &
            'of mass matrices that are not lumped and of equilibrium: iterative, or a factorisation; auto: cg, direct')]

   !> &method: how the equations of motion are integrated.
   type :: method_t
      character(name_len) :: time = 'explicit'   !! 'explicit', 'implicit' or 'static'
      real(dp) :: time_step = 0                  !! of 'implicit': longest, 0 where courant gives it [s]
      real(dp) :: hht_alpha = 0                  !! of 'implicit' [-]
      integer :: load_steps = 1                  !! of 'static'
      character(name_len) :: scheme = ''         !! 'usf', 'usl', 'usavg' or 'musl'
      character(name_len) :: path = 'fastest'    !! 'fastest' or 'reference'
      real(dp) :: courant = 0                    !! [-]
      character(name_len) :: wave_speed = ''     !! 'shear' or 'dilatational'
      character(name_len) :: time_steps = 'global' !! 'global' or 'local'
      character(name_len) :: frame = 'total'     !! 'updated' or 'total'
      character(name_len) :: functions = 'linear' !! 'linear' or 'cpdi'
      character(name_len) :: mass = 'lumped'     !! 'lumped', 'full', 'partial', 'fmpm' or 'blend'
      integer :: order = 1                       !! of fmpm
      real(dp) :: blend = 0                      !! lumped part [-]
      character(name_len) :: full_region = 'box' !! of a partial mass matrix: 'box' or 'refined'
      real(dp) :: full_lower(ndim) = 0           !! box in which it is full [m]
      real(dp) :: full_upper(ndim) = 0           !! [m]
      character(name_len) :: solver = 'auto'     !! 'auto', 'cg' or 'direct'
   contains
      procedure :: has_domains
   end type method_t

contains

   !> Whether particles have domains (`hampm_domains`).
   elemental logical function has_domains(self)
      class(method_t), intent(in) :: self
      has_domains = self%functions == 'cpdi'
   end function has_domains

   !> Take the values of the keys; 0, '' or empty where they are absent or mistaken.
   pure subroutine fill_method(settings, method)
      type(settings_t), intent(in) :: settings
      type(method_t), intent(inout) :: method
      integer :: entry
      entry = settings%find('method', 1)
      method%time = settings%text(entry, 'time')
      method%time_step = settings%number(entry, 'time_step')
      method%hht_alpha = settings%number(entry, 'hht_alpha')
      method%load_steps = nint(settings%number(entry, 'load_steps'))
      method%scheme = settings%text(entry, 'scheme')
      method%path = settings%text(entry, 'path')
      method%courant = settings%number(entry, 'courant')
      method%wave_speed = settings%text(entry, 'wave_speed')
      method%time_steps = settings%text(entry, 'time_steps')
      method%frame = settings%text(entry, 'frame')
      method%functions = settings%text(entry, 'functions')
      method%mass = settings%text(entry, 'mass')
      method%order = nint(settings%number(entry, 'order'))
      method%blend = settings%number(entry, 'blend')
      method%full_region = settings%text(entry, 'full_region')
      method%full_lower = settings%vector(entry, 'full_lower')
      method%full_upper = settings%vector(entry, 'full_upper')
      method%solver = settings%text(entry, 'solver')
   end subroutine fill_method
end module hampm_method_group
