!> The groups that stand once, &run, &grid, &damping, &output, &contact, &method and &refine: their rows in the table of groups, their
!> keys, and their values in a model, in components with the names of the keys; those of &refine are in `hampm_refinement`.
module hampm_plain_groups
   use hampm_kinds, only: dp, ndim, name_len, path_len
   use hampm_indicators, only: indicator_keys
   use hampm_key_rows, only: zeros, near_side, far_side, group_t, key_t, type_real, type_integer, once, is_required, &
                             any_number, positive, &
                             type_name, type_text, is_assumed, not_negative, is_optional
   use hampm_thickness, only: thickness_t
   implicit none
   private
   public :: grid_group, grid_keys, grid_spec_t, run_group, run_keys, run_t, damping_group, damping_keys, damping_t, output_group, &
             output_keys, output_t, contact_group, contact_keys, body_contact_spec_t, method_group, method_keys, method_t, &
             refine_group, refine_keys

   type(group_t), parameter :: contact_group = group_t('contact', once, is_assumed, 'how bodies that meet act on each other')

   type(key_t), parameter :: contact_keys(*) = [ &
      key_t('bodies', type_name, &
            'bonded: one velocity field, in which they stick; else one for each: those that touch stick, or slide', &
            default='bonded', allowed='bonded|stick|frictionless|friction'), &
      key_t('friction', type_real, 'of bodies = ''friction'': coefficient', default='0.0', allowed=not_negative), &
      key_t('distance', type_real, 'gap between their surfaces at which bodies touch', default='0.0', unit='m', &
            allowed=not_negative)]

   !> &contact.
   type :: body_contact_spec_t
      character(name_len) :: bodies = 'bonded'   !! 'bonded', 'stick', 'frictionless' or 'friction'
      real(dp) :: friction = 0                   !! coefficient [-]
      real(dp) :: distance = 0                   !! gap at which they touch [m]
   contains
      procedure :: is_wanted
   end type body_contact_spec_t

   type(group_t), parameter :: output_group = group_t('output', once, is_assumed, 'what is written, and how often')

   type(key_t), parameter :: output_keys(*) = [ &
      key_t('file', type_text, 'result file in the output folder; by default named after the namelist file', example='dcb.h5'), &
      key_t('history_interval', type_real, &
            'time between samples of the history, where explicit steps end; 0: a thousandth of end_time', default='0.0', &
            unit='s', allowed=not_negative), &
      key_t('snapshot_interval', type_real, &
            'time between snapshots of particles and mesh, taken at the end of the step or load step in which it comes; '// &
            '0: none', default='0.0', unit='s', allowed=not_negative), &
      key_t('checkpoint_interval', type_real, 'wall time between checkpoints, from which --resume goes on; 0: none', &
            default='0.0', unit='s', allowed=not_negative), &
      key_t('checkpoint_steps', type_integer, 'steps between checkpoints; 0: none', default='0', allowed='[0, inf)')]

   !> &output: what is written, and how often.
   type :: output_t
      character(path_len) :: file = ''           !! name of the result file, within the output folder
      real(dp) :: history_interval = 0           !! [s], always > 0 after validation
      real(dp) :: snapshot_interval = 0          !! [s], 0: no snapshots
      real(dp) :: checkpoint_interval = 0        !! wall time [s], 0: none
      integer :: checkpoint_steps = 0            !! 0: none
   end type output_t

   type(group_t), parameter :: damping_group = group_t('damping', once, is_assumed, 'a force -rate m v on all material')

   type(key_t), parameter :: damping_keys(*) = [ &
      key_t('rate', type_real, 'damping force over mass times velocity', default='0.0', example='1.0e4', unit='1/s', &
            allowed=not_negative)]

   !> &damping.
   type :: damping_t
      real(dp) :: rate = 0                       !! alpha of the force -alpha m v [1/s]
   end type damping_t

   type(group_t), parameter :: run_group = group_t('run', once, is_required, 'what is computed, and for how long')

   integer, parameter :: most_ends = 4           !! of a run, before its time

   type(key_t), parameter :: run_keys(*) = [ &
      key_t('title', type_text, 'what the run is about; the result keeps it', example='DCB, suddenly loaded'), &
      key_t('plane', type_name, 'plane stress, plane strain, or material around the axis x = 0, where x is the radius', &
            default='stress', allowed='stress|strain|axisymmetric'), &
      key_t('thickness', type_real, 'thickness of the plane; forces and energies are those of all of it', default='1.0', &
            example=merge('0.01', '    ', ndim == 2), unit='m', allowed=positive), &
      key_t('end_time', type_real, 'the run goes from time 0 to this time', example='1.5e-3', unit='s', allowed=positive, &
            required=.true.), &
      key_t('stop_when', type_name, 'what ends the run before that, at a sample; none by default', &
            allowed='arrested|load_dropped|crack_length|separated', fewest=0, most=most_ends), &
      key_t('stop_length', type_real, 'of crack_length: length of a whole crack', default='0.0', unit='m', allowed=not_negative), &
      key_t('stop_load', type_real, 'of load_dropped: part of the largest load so far', default='0.5', allowed='(0, 1)'), &
      key_t('stop_rest', type_real, 'of arrested, in motion: time for which no tip has grown', default='0.0', unit='s', &
            allowed=not_negative)]

   !> &run: what is computed, and for how long.
   type :: run_t
      character(path_len) :: title = ''
      character(name_len) :: plane = ''          !! 'stress', 'strain' or 'axisymmetric'
      type(thickness_t) :: thickness
      real(dp) :: end_time = 0                   !! [s]
      character(name_len) :: stop_when(most_ends) = '' !! those of its key; '' for none
      real(dp) :: stop_length = 0                !! of a crack [m]
      real(dp) :: stop_load = 0                  !! over the largest so far [-]
      real(dp) :: stop_rest = 0                  !! of tips [s]
   end type run_t

   type(group_t), parameter :: grid_group = group_t('grid', once, is_required, &
      'the lattice of square root cells that the material moves through')

   type(key_t), parameter :: grid_keys(*) = [ &
      key_t('lower', type_real, 'lower corner of the lattice', default=zeros, unit='m', allowed=any_number, fewest=ndim, &
            most=ndim), &
      key_t('cell', type_real, 'size of a root cell, the same in both directions', unit='m', allowed=positive, &
            example=merge('1.25e-3', '2.5e-3 ', ndim == 2), required=.true.), &
      key_t('cells', type_integer, 'number of root cells in each direction', allowed='[1, inf)', fewest=ndim, &
            example=merge('80, 9   ', '40, 5, 4', ndim == 2), most=ndim, required=.true.), &
      key_t('order', type_integer, 'of the shape functions: 1 bilinear, 2 biquadratic cells with nine nodes', default='1', &
            allowed='[1, 2]')]

   !> &grid: the lattice of root cells.
   type :: grid_spec_t
      real(dp) :: lower(ndim) = 0                !! lower corner of the lattice [m]
      real(dp) :: cell = 0                       !! size of a root cell [m]
      integer :: cells(ndim) = 0                 !! number of root cells
      integer :: order = 1                       !! of the shape functions
   end type grid_spec_t

   type(group_t), parameter :: method_group = group_t('method', once, is_assumed, 'how the equations of motion are integrated')

   type(key_t), parameter :: method_keys(*) = [ &
      key_t('time', type_name, &
            'how motion is followed: by short explicit steps, by implicit ones, or from equilibrium to equilibrium', &
            default='explicit', allowed='explicit|implicit|static'), &
      key_t('time_step', type_real, &
            'of time = ''implicit'': longest time step; 0: by courant, and 1/1000 of end_time where that is 0', default='0.0', &
            unit='s', allowed=not_negative), &
      key_t('hht_alpha', type_real, &
            'of time = ''implicit'': 0 for average acceleration; below it steps damp what they do not resolve', default='0.0', &
            allowed='[-0.33334, 0]'), &
      key_t('start', type_name, &
            'of motion: from undeformed bodies, or from the static equilibrium of what acts at time 0', default='undeformed', &
            allowed='undeformed|static'), &
      key_t('load_steps', type_integer, 'of time = ''static'': equal steps of the time, by which loads vary, up to end_time', &
            default='1', allowed='[1, 100000]'), &
      key_t('scheme', type_name, 'when a step updates the stress: first, last, half and half, or last by velocities mapped anew', &
            default='musl', allowed='usf|usl|usavg|musl'), &
      key_t('courant', type_real, 'time step over cell size / wave speed; 0: 0.9 of the limit, in the updated frame 0.1 or less', &
            default='0.0', allowed='[0, 1000]'), &
      key_t('path', type_name, 'of explicit steps: the fastest one for the model, or the plain reference step', default='fastest', &
            allowed='fastest|reference'), &
      key_t('wave_speed', type_name, 'which wave speed courant refers to', default='shear', allowed='shear|dilatational'), &
      key_t('time_steps', type_name, 'one for all cells, that of the smallest, or longer ones for larger cells', default='global', &
            allowed='global|local'), &
      key_t('frame', type_name, 'shape functions at the present positions, for bodies that meet, or always at the initial ones', &
            default='total', allowed='updated|total'), &
      key_t('shape_functions', type_name, &
            'of a particle in frame = ''updated'': of its place, or the mean over the corners of its domain', default='linear', &
            allowed='linear|cpdi'), &
      key_t('mass', type_name, &
            'mass matrix: by row sums, consistent, so in some cells, a series for its inverse, or a weighted mean of both', &
            default='lumped', allowed='lumped|consistent|partial|fmpm|weighted'), &
      key_t('order', type_integer, 'of mass = ''fmpm'': number of terms of the series; 1 is lumped', default='2', &
            allowed='[1, 100]'), &
      key_t('lumped_fraction', type_real, &
            'of mass = ''weighted'': weight of the lumped matrix; 5/18 has the least dispersion in short steps', default='0.2778', &
            allowed='[0, 1]'), &
      key_t('consistent_region', type_name, 'of mass = ''partial'': it is consistent in a box, or in the cells that are refined', &
            default='box', allowed='box|refined'), &
      key_t('consistent_lower', type_real, &
            'of consistent_region = ''box'': lower corner of the box in which mass = ''partial'' is consistent', &
            default=zeros, unit='m', allowed=any_number, fewest=ndim, most=ndim), &
      key_t('consistent_upper', type_real, 'of consistent_region = ''box'': upper corner of this box; needed there', &
            default=zeros, unit='m', allowed=any_number, fewest=ndim, most=ndim), &
      key_t('solver', type_name, &
            'of mass matrices that are not lumped and of equilibrium; auto: direct; '// &
            'cg for masses on 1e6 cells, solids of 3e4 or more', &
            default='auto', allowed='auto|cg|direct')]

   !> &method: how the equations of motion are integrated.
   type :: method_t
      character(name_len) :: time = 'explicit'   !! 'explicit', 'implicit' or 'static'
      real(dp) :: time_step = 0                  !! of 'implicit': longest, 0 where courant gives it [s]
      real(dp) :: hht_alpha = 0                  !! of 'implicit' [-]
      character(name_len) :: start = 'undeformed' !! of motion: 'undeformed' or 'static'
      integer :: load_steps = 1                  !! of 'static'
      character(name_len) :: scheme = ''         !! 'usf', 'usl', 'usavg' or 'musl'
      character(name_len) :: path = 'fastest'    !! 'fastest' or 'reference'
      real(dp) :: courant = 0                    !! [-]
      real(dp) :: courant_limit = 0              !! the largest that is stable, where the namelist gives none [-]
      character(name_len) :: wave_speed = ''     !! 'shear' or 'dilatational'
      character(name_len) :: time_steps = 'global' !! 'global' or 'local'
      character(name_len) :: frame = 'total'     !! 'updated' or 'total'
      character(name_len) :: shape_functions = 'linear' !! 'linear' or 'cpdi'
      character(name_len) :: mass = 'lumped'     !! 'lumped', 'consistent', 'partial', 'fmpm' or 'weighted'
      integer :: order = 1                       !! of fmpm
      real(dp) :: lumped_fraction = 0            !! of 'weighted' [-]
      character(name_len) :: consistent_region = 'box' !! of a partial mass matrix: 'box' or 'refined'
      real(dp) :: consistent_lower(ndim) = 0     !! box in which it is consistent [m]
      real(dp) :: consistent_upper(ndim) = 0     !! [m]
      character(name_len) :: solver = 'auto'     !! 'auto', 'cg' or 'direct'
   contains
      procedure :: has_domains
   end type method_t

   type(group_t), parameter :: refine_group = group_t('refine', once, is_optional, &
      'where cells refine; without this group they never do')

   type(key_t), parameter :: refine_keys(*) = [ &
      key_t('indicator', type_name, 'what tells which cells refine: gradients, the estimated error, the distance to the tip', &
            default='none', example='tip', allowed='none|{indicators}'), &
      key_t('field', type_name, 'of indicator = ''gradient'': the field whose gradients count', default='energy_density', &
            allowed='energy_density|stress_norm|speed'), &
      indicator_keys, &
      key_t('max_level', type_integer, 'how often a root cell may be divided; its size is halved each time', default='4', &
            example=merge('2', '1', ndim == 2), allowed='[0, 20]'), &
      key_t('region_lower', type_real, 'lower corner of the box in which cells may refine; without limit by default', &
            example='0.04, 0.0'//near_side, unit='m', allowed=any_number, fewest=0, most=ndim), &
      key_t('region_upper', type_real, 'upper corner of the box in which cells may refine; without limit by default', &
            example='0.06, 0.01'//far_side, unit='m', allowed=any_number, fewest=0, most=ndim), &
      key_t('start', type_real, 'time of the first look at gradient or zz: loads that begin make steep fronts', default='0.0', &
            unit='s', allowed=not_negative), &
      key_t('interval', type_integer, 'steps between looks at the indicator', default='100', allowed='[1, inf)'), &
      key_t('max_particles', type_integer, 'most material points; where there would be more, refinement ends with a warning', &
            default='1000000', allowed='[1, 2e9]')]

contains

   !> Whether bodies have velocity fields of their own.
   pure logical function is_wanted(self)
      class(body_contact_spec_t), intent(in) :: self
      is_wanted = self%bodies == 'stick' .or. self%bodies == 'frictionless' .or. self%bodies == 'friction'
   end function is_wanted

   !> Whether particles have domains (`hampm_domains`).
   elemental logical function has_domains(self)
      class(method_t), intent(in) :: self
      has_domains = self%shape_functions == 'cpdi'
   end function has_domains
end module hampm_plain_groups
