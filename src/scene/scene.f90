!> What the user asked for: one type for each group of the namelist, after validation, in SI units.
!> The meaning, unit, default and range of each field is in the table of `hampm_keys`.
module hampm_scene
   use hampm_kinds, only: dp, ndim, name_len, path_len
   implicit none
   private
   public :: scene_t, run_t, grid_spec_t, material_spec_t, body_t, constraint_spec_t, load_spec_t, &
             damping_t, method_t, refine_t, crack_spec_t, energy_release_t, output_t

   !> &run: what is computed, and for how long.
   type :: run_t
      character(path_len) :: title = ''
      character(name_len) :: plane = ''          !! 'stress' or 'strain'
      real(dp) :: thickness = 0                  !! [m]
      real(dp) :: end_time = 0                   !! [s]
   end type run_t

   !> &grid: the lattice of root cells.
   type :: grid_spec_t
      real(dp) :: lower(ndim) = 0                !! lower corner of the lattice [m]
      real(dp) :: cell = 0                       !! size of a root cell [m]
      integer :: cells(ndim) = 0                 !! number of root cells
   end type grid_spec_t

   !> &material: a law and its constants.
   type :: material_spec_t
      character(name_len) :: name = ''
      character(name_len) :: law = ''            !! 'linear_elastic' or 'neo_hookean'
      real(dp) :: young = 0                      !! [Pa]
      real(dp) :: poisson = 0                    !! [-]
      real(dp) :: density = 0                    !! [kg/m3]
   end type material_spec_t

   !> &body: a piece of material.
   type :: body_t
      character(name_len) :: material = ''       !! name of its material
      integer :: material_index = 0              !! position of that material in `scene_t%materials`
      character(name_len) :: shape = ''          !! 'rectangle'
      real(dp) :: lower(ndim) = 0                !! [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      integer :: points_per_cell = 0             !! material points per cell and direction
      real(dp) :: velocity(ndim) = 0             !! initial velocity [m/s]
   end type body_t

   !> &constraint: nodes that are held.
   type :: constraint_spec_t
      real(dp) :: lower(ndim) = 0                !! [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      logical :: fixed(ndim) = .false.           !! which components are held
   end type constraint_spec_t

   !> &load: a force and its history.
   type :: load_spec_t
      character(name_len) :: kind = ''           !! 'point', 'traction' or 'body'
      real(dp) :: lower(ndim) = 0                !! [m]
      real(dp) :: upper(ndim) = 0                !! [m]
      real(dp) :: force(ndim) = 0                !! resultant of the whole load [N]
      character(name_len) :: history = ''        !! 'step', 'ramp', 'sine' or 'table'
      real(dp) :: start = 0                      !! time at which it begins [s]
      real(dp) :: rise_time = 0                  !! of a ramp [s]
      real(dp) :: frequency = 0                  !! of a sine [Hz]
      real(dp), allocatable :: times(:)          !! of a table, relative to `start` [s]
      real(dp), allocatable :: factors(:)        !! of a table [-]
   end type load_spec_t

   !> &damping.
   type :: damping_t
      real(dp) :: rate = 0                       !! alpha of the force -alpha m v [1/s]
   end type damping_t

   !> &method: how the equations of motion are integrated.
   type :: method_t
      character(name_len) :: scheme = ''         !! 'usf', 'usl', 'usavg' or 'musl'
      real(dp) :: courant = 0                    !! [-]
      character(name_len) :: wave_speed = ''     !! 'shear' or 'dilatational'
      character(name_len) :: time_steps = 'global' !! 'global' or 'local'
      character(name_len) :: frame = 'updated'   !! 'updated' or 'total'
      character(name_len) :: mass = 'lumped'     !! 'lumped', 'full', 'partial', 'fmpm' or 'blend'
      integer :: order = 1                       !! of fmpm
      real(dp) :: blend = 0                      !! lumped part [-]
      character(name_len) :: full_region = 'box' !! of a partial mass matrix: 'box' or 'refined'
      real(dp) :: full_lower(ndim) = 0           !! box in which it is full [m]
      real(dp) :: full_upper(ndim) = 0           !! [m]
      character(name_len) :: solver = 'cg'       !! 'cg', 'umfpack' or 'banded'
   end type method_t

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

   !> &crack: where it is.
   type :: crack_spec_t
      logical :: present = .false.               !! whether the scene has a crack
      character(name_len) :: kind = 'symmetry'   !! 'symmetry' or 'line'
      real(dp) :: tip(ndim) = 0                  !! [m]
      real(dp) :: direction(ndim) = 0            !! unit vector along a grid line, from the crack into the body
      real(dp) :: length = 0                     !! of a line: distance between its two tips, 0: it reaches the edge [m]
      logical :: contact = .false.               !! whether the faces of a line press on each other, without friction
   end type crack_spec_t

   !> &energy_release: what is recorded of energy.
   type :: energy_release_t
      logical :: nodal_force = .false.           !! which estimators
      logical :: stress_closure = .false.
      logical :: domain_integral = .false.
      logical :: energy_balance = .false.
      real(dp), allocatable :: radii(:)          !! of the domain integral, ascending [m]
      character(name_len) :: reference = ''      !! 'none', 'dcb' or 'value'
      real(dp) :: reference_value = 0            !! G_ref where reference = 'value' [J/m2]
   end type energy_release_t

   !> &output: what is written, and how often.
   type :: output_t
      character(path_len) :: file = ''           !! name of the result file, within the output folder
      real(dp) :: history_interval = 0           !! [s], always > 0 after validation
      real(dp) :: snapshot_interval = 0          !! [s], 0: no snapshots
      real(dp) :: checkpoint_interval = 0        !! wall time [s], 0: none
      integer :: checkpoint_steps = 0            !! 0: none
   end type output_t

   !> All of them.
   type :: scene_t
      type(run_t) :: run
      type(grid_spec_t) :: grid
      type(material_spec_t), allocatable :: materials(:)
      type(body_t), allocatable :: bodies(:)
      type(constraint_spec_t), allocatable :: constraints(:)
      type(load_spec_t), allocatable :: loads(:)
      type(damping_t) :: damping
      type(method_t) :: method
      type(refine_t) :: refine
      type(crack_spec_t) :: crack
      type(energy_release_t) :: energy_release
      type(output_t) :: output
      character(:), allocatable :: as_used       !! complete namelist text: every key with the value in force
   end type scene_t
end module hampm_scene
