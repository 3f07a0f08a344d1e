!> The table of rules: which features of a model do not go together, what needs what, and which keys do nothing where. Validation, the
!> warnings of `--check` and of runs, `--rules` and docs/reference/key_rules.md all come from it. What stays outside are checks of places and of
!> numbers against each other.
!>
!> A row is a condition, a verdict, another condition (both as in `hampm_conditions`), the kind of reason, the reason, and what may be
!> used instead. The message stands at the first key of the first condition. Conditions on the same group are about the same one of
!> several; a condition on another group that may stand several times `requires` it of all of these, and is met by any of them else.
!> Only materials of which there is a body, and bodies that are no holes count.
module hampm_rules
   use hampm_growth_laws, only: growth_law_keys
   use hampm_indicators, only: indicator_keys
   use hampm_laws, only: law_keys
   implicit none
   private
   public :: rule_t, rules, not_with, requires, no_effect_with, no_effect_without, warned_with, noted_with, mechanics, not_built, &
             by_meaning

   integer, parameter :: not_with = 1            !! verdicts: the model is refused where both conditions hold,
   integer, parameter :: requires = 2            !! or where the first holds and the second does not;
   integer, parameter :: no_effect_with = 3      !! the user is warned where both hold, as the first does nothing there,
   integer, parameter :: no_effect_without = 4   !! or where the first holds and the second does not, for the same reason;
   integer, parameter :: warned_with = 5         !! the user is warned where both hold,
   integer, parameter :: noted_with = 6          !! or told

   integer, parameter :: mechanics = 1           !! kinds of reasons: no program could,
   integer, parameter :: not_built = 2           !! this one does not yet,
   integer, parameter :: by_meaning = 3          !! or it follows from what the keys mean

   !> A row of the table.
   type :: rule_t
      character(104) :: subject                 !! condition
      integer :: verdict
      character(112) :: other                    !! condition; '' for one that always holds
      integer :: basis = by_meaning             !! kind of reason
      character(176) :: reason = ''             !! '' where the conditions say it
      character(80) :: use = ''                 !! a condition, or words; '' for nothing
   end type rule_t

   ! Of rows that differ by one word alone
   character(*), parameter :: corners(*) = ['lower', 'upper']
   character(*), parameter :: of_space(*) = ['shear_13', 'shear_23']
   character(*), parameter :: acting(*) = ['&constraint', '&load      ']
   character(*), parameter :: in_time(*) = ['&constraint', '&load      ', '&control   ']
   character(*), parameter :: of_profile(*) = [character(19) :: 'profile_stiffness', 'profile_density', 'profile_eigenstrain']
   character(*), parameter :: of_matter(*) = [character(19) :: 'material', 'velocity', 'spin', 'eigenstrain', 'contact_group', &
                                              'toughness', 'profile_at', 'profile_direction', of_profile]
   character(*), parameter :: of_toughness(*) = [character(17) :: 'extensions', 'speeds', 'angles', 'mixed_mode']
   character(*), parameter :: of_tips(*) = [character(10) :: 'extensions', 'angles']
   character(*), parameter :: of_planes(*) = [character(22) :: 'normal', "front /= 'straight'", 'center', 'radii']
   character(*), parameter :: but_domains = "'series_fit' | 'material_force' | 'stress_closure'"
   character(*), parameter :: of_looks(*) = ['start   ', 'interval']
   character(*), parameter :: moved_by(*) = ['displacement', 'velocity    ', 'turns       ']
   character(*), parameter :: of_blocks(*) = ['factors', 'ratios ', 'repeat ']
   character(*), parameter :: of_frame(*) = ['history', 'start  ']
   character(*), parameter :: of_factor(*) = ['history', 'start  ', 'held   ']
   character(*), parameter :: of_shear(*) = ['exponent  ', 'mixed_mode']
   character(*), parameter :: on_faces(*) = [character(48) :: "&crack contact = 'frictionless' | 'friction'", &
                                             "&load on = 'crack'", "&load face = 'left' | 'right'", '&cohesive']
   character(*), parameter :: with_forces(*) = [character(48) :: 'cracks that cut cells', &
                                                "&crack contact = 'frictionless' | 'friction'", '&cohesive']
   character(*), parameter :: of_place(*) = [character(12) :: 'displacement', 'velocity', 'stress', 'strain']
   integer :: k

   character(*), parameter :: with_history = "&material law = {laws with a history}"

   character(*), parameter :: stiff_cells = "nearly incompressible cells lock: displacements, G, J and K are too small"
   ! Why nothing is kept at its toughness by J where material yields or creeps
   character(*), parameter :: no_rate = "J is not the energy release rate where material around a growing tip dissipates energy"

   type(rule_t), parameter :: of_rings(*) = [ &
      rule_t("&method mass = 'lumped' | 'partial' | 'fmpm' | 'weighted'", not_with, &
             "a mass matrix that acts and quadratic cells at an axis", mechanics, "nodes on the axis have a lumped mass of 0", &
             use="&method mass = 'consistent'"), &
      rule_t("&run plane = 'axisymmetric'", not_with, "&run thickness", reason="the thickness of a ring is its circumference"), &
      rule_t("&body spin", not_with, "&run plane = 'axisymmetric'", mechanics, &
             "a ring cannot rotate in the plane of its section"), &
      rule_t("&energy_release reference = 'dcb'", not_with, "&run plane = 'axisymmetric'", mechanics, "a beam has no axis"), &
      rule_t("&run plane = 'axisymmetric'", not_with, "&method shape_functions = 'cpdi'", not_built, &
             "corners of a domain do not give the hoop stretch", use="&method shape_functions = 'linear'")]

   ! What the program for solids does not know yet, and what solids do not have
   type(rule_t), parameter :: of_solids(*) = [ &
      rule_t("&run plane = 'axisymmetric'", not_with, "a solid", mechanics, "a solid has no plane"), &
      rule_t("&run plane", no_effect_with, "a solid", mechanics, "a solid has no plane"), &
      rule_t("&run thickness", no_effect_with, "a solid", mechanics, "a solid is as thick as its bodies"), &
      rule_t("&grid order = 2", not_with, "a solid", not_built, use="&grid order = 1"), &
      rule_t("&material law = 'orthotropic' and a solid", requires, &
             "&material young_3 and &material poisson_13 and &material poisson_23"), &
      (rule_t("&material law = 'orthotropic' and a solid", requires, "&material "//of_space(k)), k=1, 2), &
      (rule_t("&material "//of_space(k), requires, "a solid", mechanics, "a plane has no shear across it"), k=1, 2), &
      rule_t("&body shape = 'polygon' | 'circle'", not_with, "a solid", not_built, "solids are boxes, cylinders and spheres", &
             use="&body shape = 'cylinder'"), &
      rule_t("&body points_per_cell < 2", not_with, "a solid and &method start = 'static' and &method time = 'explicit'", &
             mechanics, "explicit steps do not hold how cells with one point are bent", use="&body points_per_cell = 2"), &
      rule_t("&constraint turns = .true.", not_with, "a pin without an axis", mechanics, &
             "that of a solid fixes two components, and turns around the third direction"), &
      rule_t("&crack kind = 'line' | 'path'", not_with, "a solid", not_built, "cracks of solids are in planes of the grid", &
             use="&crack kind = 'plane'"), &
      rule_t("&crack kind = 'plane'", requires, "a solid", mechanics, "in a plane a crack is a line", use="&crack kind = 'line'"), &
      (rule_t("&crack "//of_planes(k), requires, "a solid", mechanics, "in a plane a crack is a line"), k=1, size(of_planes)), &
      rule_t("&crack and &method frame = 'updated'", not_with, "a solid", not_built, &
             "planes of cracks stay where they are in the grid", use="&method frame = 'total'"), &
      rule_t("&cohesive", not_with, "a solid", not_built, "cohesion is along lines"), &
      rule_t("&crack contact = 'frictionless' and &growth law = {growth laws in motion}", not_with, "a solid", not_built, &
             "fronts move between free faces", use="&crack contact = 'none'"), &
      rule_t("&crack contact = 'friction' and &growth", not_with, "a solid", not_built, &
             "what faces have slid is not kept where fronts grow", use="&crack contact = 'none'"), &
      rule_t("&growth direction = 'hoop_stress' | 'local_symmetry' | 'max_energy' | 'path'", not_with, "a solid", mechanics, &
             "cracks stay in their planes", use="&growth direction = 'straight'"), &
      rule_t("&growth law = {growth laws in motion} and &growth mixed_mode = 'hutchinson_suo' | 'benzeggagh_kenane'", not_with, &
             "a solid", not_built, "of fronts in motion it is not", use="&growth mixed_mode = 'none'"), &
      (rule_t("&growth law = {growth laws in motion} and &growth "//trim(of_tips(k)), not_with, "a solid", not_built, &
              "of fronts in motion it is not"), k=1, size(of_tips)), &
      rule_t("&growth max_length", not_with, "a solid", mechanics, "a crack in a plane has an area"), &
      rule_t("&growth tips = 'largest' | 'last' | 'first'", not_with, "a solid", mechanics, "a front has no tips", &
             use="&growth tips = 'all'"), &
      rule_t("&energy_release estimators = "//but_domains, not_with, "a solid", not_built, use="'domain_integral' or 'vcct'"), &
      rule_t("&energy_release t_stress = .true.", not_with, "a solid", not_built, "along fronts G and K are found"), &
      rule_t("&energy_release phase_length", not_with, "a solid", not_built, "K along fronts are those of one material"), &
      rule_t("&energy_release reference = 'dcb'", not_with, "a solid", mechanics, "the closed form is for a plane", &
             use="&energy_release reference = 'value'"), &
      rule_t("&nucleation", not_with, "a solid", not_built, "a crack is a line in a plane"), &
      rule_t("&method shape_functions = 'cpdi'", not_with, "a solid", not_built, use="&method shape_functions = 'linear'"), &
      rule_t("&method time_steps = 'local'", not_with, "a solid", not_built, use="&method time_steps = 'global'")]

   type(rule_t), parameter :: of_grids(*) = [ &
      rule_t("&grid order = 2", not_with, "&method time = 'explicit' | 'implicit' and &growth law = {growth laws in motion}", &
             not_built, "growth through quadratic cells is static only", use="&grid order = 1"), &
      rule_t("&grid order = 2", not_with, "&crack kind = 'symmetry' and &growth", not_built, &
             "cohesive points ahead of the tip join nodes of bilinear cells", use="&grid order = 1"), &
      rule_t("&grid order = 2", not_with, "&crack kind = 'symmetry' and &cohesive", not_built, use="&grid order = 1")]

   type(rule_t), parameter :: of_materials(*) = [ &
      rule_t("&material law /= 'orthotropic'", requires, "&material young"), &
      (rule_t("&material "//trim(law_keys(k)%name), requires, "&material "//law_keys(k)%only_with), &
       k=1, size(law_keys)), &
      rule_t("&material law = 'orthotropic'", requires, &
             "&material young_1 and &material young_2 and &material shear_12 and &material poisson_12"), &
      rule_t("&material law = 'orthotropic' and &run plane = 'strain' | 'axisymmetric'", requires, &
             "&material young_3 and &material poisson_13 and &material poisson_23", mechanics, &
             "strain across the plane is constrained"), &
      rule_t("&material young", not_with, "&material law = 'orthotropic'", use="young_1 and young_2"), &
      rule_t("&material poisson", not_with, "&material law = 'orthotropic'", use="poisson_12"), &
      rule_t("&material young_3", no_effect_with, "&run plane = 'stress' and a plane", mechanics, "the thickness is free"), &
      rule_t("&material poisson_13", no_effect_with, "&run plane = 'stress' and a plane", mechanics, "the thickness is free"), &
      rule_t("&material poisson_23", no_effect_with, "&run plane = 'stress' and a plane", mechanics, "the thickness is free"), &
      rule_t("&material law = 'j2_plastic'", requires, "&material yield_stress > 0"), &
      rule_t("&material saturation", requires, "&material saturation_strain"), &
      rule_t("&material law = 'mooney_rivlin'", requires, "&material c01"), &
      rule_t("&material law = 'viscoelastic'", requires, "&material moduli and &material relaxation_times"), &
      rule_t("&material volumetric = 'b_bar'", not_with, &
             "&method time = 'static' | 'implicit' and &material law = {laws of any strain}", not_built, &
             "the mean of large strains has no tangent yet", use="&material volumetric = 'standard'"), &
      rule_t("&material volumetric = 'b_bar'", not_with, "&method shape_functions = 'cpdi'", mechanics, &
             "a domain has one dilatation", use="&material volumetric = 'standard'"), &
      rule_t("&material volumetric = 'b_bar'", no_effect_with, "&grid order = 2", mechanics, "quadratic cells do not lock"), &
      rule_t("&material volumetric = 'standard'", warned_with, &
             "&material poisson > 0.4899 and &run plane /= 'stress' and &grid order = 1", mechanics, stiff_cells, &
             use="&material volumetric = 'b_bar'"), &
      rule_t("&material volumetric = 'standard'", warned_with, "&material poisson > 0.4899 and a solid", mechanics, &
             stiff_cells, use="&material volumetric = 'b_bar'"), &
      rule_t("&material volumetric = 'standard'", warned_with, &
             "&material law = 'j2_plastic' and &run plane /= 'stress' and &grid order = 1", mechanics, &
             "yielding cells lock: they are too stiff, and loads rise beyond the limit load", &
             use="&material volumetric = 'b_bar'"), &
      rule_t("&material volumetric = 'standard'", warned_with, "&material law = 'j2_plastic' and a solid", mechanics, &
             "yielding cells lock: they are too stiff, and loads rise beyond the limit load", &
             use="&material volumetric = 'b_bar'"), &
      rule_t(with_history, not_with, "&growth law = {growth laws at rest}", mechanics, no_rate), &
      rule_t(with_history, not_with, "&growth law = {growth laws in motion by toughness} and &method time = 'implicit'", &
             mechanics, no_rate), &
      rule_t(with_history, not_with, "&growth direction = 'hoop_stress' | 'local_symmetry' | 'max_energy'", mechanics, &
             "the direction needs stress intensity factors, which the law does not have", use="&growth direction = 'straight'"), &
      rule_t(with_history, not_with, "&growth mixed_mode = 'hutchinson_suo' | 'benzeggagh_kenane'", mechanics, &
             "the law has no shares of modes", use="&growth mixed_mode = 'none'"), &
      rule_t("&material law = 'orthotropic'", not_with, "&growth law = {growth laws in motion}", not_built, &
             "K and the limiting speed of a moving tip are known for isotropic material only"), &
      rule_t("&material law = 'orthotropic'", not_with, "&growth direction = 'hoop_stress' | 'local_symmetry' | 'max_energy'", &
             not_built, "the stress intensity factors of short kinks are known for isotropic material only", &
             use="&growth direction = 'straight'"), &
      rule_t("&material", no_effect_without, "a body of it")]

   type(rule_t), parameter :: of_bodies(*) = [ &
      rule_t("&body", requires, "&body material or &body hole = .true."), &
      (rule_t("&body "//trim(of_matter(k)), not_with, "&body hole = .true.", reason="a hole has none"), k=1, size(of_matter)), &
      rule_t("&body points_per_cell", no_effect_with, "&body hole = .true."), &
      rule_t("&body shape = 'rectangle'", requires, "&body lower and &body upper"), &
      rule_t("&body shape = 'polygon'", requires, "&body points"), &
      rule_t("&body shape = 'circle'", requires, "&body center and &body radius > 0"), &
      rule_t("&body shape = 'cylinder' | 'sphere'", requires, "a solid", mechanics, "they are no shapes of a plane", &
             use="&body shape = 'circle'"), &
      rule_t("&body shape = 'cylinder'", requires, "&body lower and &body upper and &body radius > 0"), &
      rule_t("&body shape = 'sphere'", requires, "&body center and &body radius > 0"), &
      (rule_t("&body "//corners(k), requires, "&body shape = 'rectangle' or &body shape = 'cylinder'"), k=1, 2), &
      rule_t("&body points", requires, "&body shape = 'polygon'"), &
      rule_t("&body center", requires, "&body shape = 'circle' or &body shape = 'sphere'"), &
      rule_t("&body radius", requires, "&body shape = 'circle' or &body shape = 'cylinder' or &body shape = 'sphere'"), &
      rule_t("&body contact_group", requires, "&contact bodies = 'stick' | 'frictionless' | 'friction'", &
             reason="contact groups have an effect in contact only"), &
      rule_t("&body contact_group", no_effect_without, "another body of that group", mechanics, &
             "a body without this key is a contact group by itself"), &
      rule_t("&body points_per_cell < 3", not_with, "&grid order = 2", mechanics, &
             "fewer than 3 leave hourglass motions of the nodes without strain of a particle", use="&body points_per_cell = 3"), &
      rule_t("&body velocity", not_with, "&method time = 'static'", mechanics, "a static model has no velocity"), &
      rule_t("&body spin", not_with, "&method time = 'static'", mechanics, "a static model has no velocity"), &
      rule_t("&body spin", not_with, "&method start = 'static'", mechanics, "a body that rotates is not in static equilibrium"), &
      rule_t("&body eigenstrain and a shear of the eigenstrain", not_with, "&crack kind = 'symmetry'", mechanics, &
             "the other half would have the opposite shear, the third value"), &
      rule_t("&body eigenstrain", not_with, "&energy_release reference = 'dcb'", mechanics, "the closed form is for forces"), &
      rule_t("&body held = .false.", requires, "&body eigenstrain", reason="growth scales the eigenstrain"), &
      rule_t("&body held = .false.", no_effect_without, "&growth law = {growth laws at rest}", mechanics, &
             "only growth at rest scales what acts"), &
      rule_t("&body held = .false.", not_with, "&control", not_built, "a load frame has a force and a displacement"), &
      (rule_t("&body "//trim(of_profile(k)), requires, "&body profile_at"), k=1, size(of_profile)), &
      rule_t("&body profile_at", requires, "&body profile_stiffness or &body profile_density or &body profile_eigenstrain"), &
      rule_t("&body profile_direction", no_effect_without, "&body profile_at"), &
      rule_t("&body profile_eigenstrain", requires, "&body eigenstrain"), &
      rule_t("&body profile_eigenstrain", not_with, "&material law = {laws of any strain}", not_built, &
             "J does not know how such an eigenstrain changes"), &
      rule_t("&body profile_eigenstrain", not_with, "&run plane = 'axisymmetric'", not_built, &
             "J does not know how an eigenstrain around the axis changes"), &
      rule_t("&body profile_at", not_with, "&energy_release phase_length", not_built, &
             "the fields that the integral is with are those of uniform materials"), &
      rule_t("&body profile_at", not_with, "&energy_release estimators = 'series_fit'", mechanics, &
             "the series is that of uniform material", use="'domain_integral'"), &
      rule_t("&body profile_at", not_with, "&energy_release reference = 'dcb'", mechanics, &
             "the closed form is of uniform material"), &
      rule_t("&body profile_eigenstrain", not_with, "&body held = .false.", not_built, &
             "a load factor does not reach how an eigenstrain changes", use="&body held = .true."), &
      rule_t("&body eigenstrain and a fourth value of the eigenstrain", warned_with, "&run plane = 'stress' and a plane", &
             mechanics, "the fourth value has no effect, as the thickness is free")]

   type(rule_t), parameter :: of_ends(*) = [ &
      rule_t("&run stop_when = 'separated'", requires, "&growth", not_built, &
             "what cohesion lets part is not looked at"), &
      rule_t("&run stop_when = 'crack_length'", requires, "&run stop_length > 0"), &
      rule_t("&run stop_when = 'crack_length'", requires, "&crack"), &
      rule_t("&run stop_when = 'crack_length'", not_with, "a solid", not_built, "cracks of solids have fronts and no length"), &
      rule_t("&run stop_when = 'arrested'", requires, "&growth"), &
      rule_t("&run stop_when = 'load_dropped'", requires, "a load that is recorded", &
             reason="it is the force of a constraint with a name, or the load factor of growth at rest"), &
      rule_t("&run stop_length", requires, "&run stop_when = 'crack_length'"), &
      rule_t("&run stop_load", requires, "&run stop_when = 'load_dropped'"), &
      rule_t("&run stop_rest", requires, "&run stop_when = 'arrested'"), &
      rule_t("&run stop_rest", no_effect_with, "&method time = 'static'", mechanics, "a static model has no time")]

   type(rule_t), parameter :: of_histories(*) = [ &
      (rule_t(trim(in_time(k))//" rise_time", requires, trim(in_time(k))//" history = 'ramp' | 'smooth_ramp'"), &
       rule_t(trim(in_time(k))//" frequency", requires, trim(in_time(k))//" history = 'sine'"), &
       rule_t(trim(in_time(k))//" times", requires, trim(in_time(k))//" history = 'table'"), &
       rule_t(trim(in_time(k))//" factors", requires, trim(in_time(k))//" history = 'table'"), &
       rule_t(trim(in_time(k))//" history = 'ramp' | 'smooth_ramp'", requires, trim(in_time(k))//" rise_time > 0"), &
       rule_t(trim(in_time(k))//" history = 'sine'", requires, trim(in_time(k))//" frequency > 0"), &
       rule_t(trim(in_time(k))//" history = 'table'", requires, &
              trim(in_time(k))//" times and "//trim(in_time(k))//" factors"), k=1, size(in_time))]

   type(rule_t), parameter :: of_constraints(*) = [ &
      (rule_t("&constraint "//trim(of_factor(k)), no_effect_without, "&constraint displacement or &constraint velocity", &
              reason="the factor applies to a prescribed motion, and none is given"), k=1, size(of_factor)), &
      rule_t("&constraint displacement and &constraint history = 'step'", not_with, &
             "&method time = 'explicit' | 'implicit' and &method start = 'undeformed'", mechanics, &
             "prescribed nodes would jump", use="history = 'smooth_ramp', or a velocity"), &
      rule_t("&constraint displacement and &constraint history = 'step' and &constraint start > 0", not_with, &
             "&method time = 'explicit' | 'implicit' and &method start = 'static'", mechanics, &
             "prescribed nodes would jump", use="history = 'smooth_ramp', or a velocity"), &
      (rule_t("&constraint "//moved_by(k), not_with, "&method time = 'explicit' and &method time_steps = 'local'", not_built, &
              use="&method time_steps = 'global'"), k=1, size(moved_by)), &
      rule_t("&constraint unilateral = .true.", not_with, "&method time = 'explicit'", not_built, &
             "faces with contact separate and touch again in explicit steps", use="&method time = 'implicit'"), &
      rule_t("&constraint turns = .true.", not_with, "&constraint unilateral = .true.", not_built, &
             "nodes of a support part one by one, and no rigid body does", use="&constraint unilateral = .false."), &
      rule_t("&constraint turns = .true.", not_with, "&run plane = 'axisymmetric'", mechanics, &
             "a ring does not turn in the plane of its section without strain"), &
      rule_t("&constraint turns = .true.", not_with, "&contact bodies = 'stick' | 'frictionless' | 'friction'", not_built, &
             "an impulse between bodies at its nodes would not turn it"), &
      rule_t("&constraint turns = .true.", not_with, "&load kind = 'absorbing'", not_built, &
             "a dashpot at its nodes would not turn it")]

   type(rule_t), parameter :: of_loads(*) = [ &
      rule_t("&load kind = 'point' | 'body'", requires, "&load lower and &load upper and &load force"), &
      rule_t("&load kind = 'traction'", requires, "&load force"), &
      rule_t("&load kind = 'pressure'", requires, "&load pressure"), &
      rule_t("&load kind = 'traction' | 'absorbing'", requires, "&load lower and &load upper or &load side"), &
      rule_t("&load kind = 'pressure' and &load on = 'edge'", requires, "&load lower and &load upper or &load side"), &
      rule_t("&load side and &load lower", requires, "&load upper"), &
      rule_t("&load side and &load upper", requires, "&load lower"), &
      rule_t("&load side", requires, "&load kind = 'traction' | 'pressure' | 'absorbing'"), &
      rule_t("&load side", not_with, "&load on = 'crack'"), &
      rule_t("&load side", not_with, "&load face = 'left' | 'right'", reason="faces of cracks are no sides of polygons"), &
      rule_t("&load side", not_with, "a solid", reason="sides of solids are flat along the grid, or round: give the box of one"), &
      rule_t("&load kind = 'gravity'", requires, "&load acceleration"), &
      (rule_t("&load "//corners(k), not_with, "&load kind = 'gravity'", reason="gravity acts on all bodies", use="kind = 'body'"), &
       rule_t("&load "//corners(k), not_with, "&load kind = 'pressure' and &load on = 'crack'", &
              reason="the pressure acts on both faces of the whole crack"), k=1, 2), &
      rule_t("&load force", not_with, "&load kind = 'pressure' | 'gravity' | 'absorbing'"), &
      (rule_t("&load "//of_factor(k), not_with, "&load kind = 'absorbing'", &
              reason="velocities of the edge give its force"), k=1, 2), &
      rule_t("&load kind = 'absorbing'", not_with, "&method time = 'static'", mechanics, "a static model has no velocity"), &
      rule_t("&load kind = 'absorbing'", not_with, "&method time_steps = 'local'", not_built, &
             use="&method time_steps = 'global'"), &
      rule_t("&load kind = 'absorbing'", not_with, "&method path = 'reference'", not_built, "the reference step has no dashpots", &
             use="&method path = 'fastest'"), &
      rule_t("&load kind = 'absorbing'", not_with, "&grid order = 2 and cells that are cut", not_built, &
             "dashpots act on lumped masses", use="&grid order = 1"), &
      rule_t("&load pressure", requires, "&load kind = 'pressure'"), &
      rule_t("&load acceleration", requires, "&load kind = 'gravity'"), &
      rule_t("&load on = 'crack'", requires, "&load kind = 'pressure'"), &
      rule_t("&load crack", requires, "&load kind = 'pressure' and &load on = 'crack'"), &
      rule_t("&load face = 'left' | 'right'", not_with, "&load kind = 'pressure' | 'gravity' | 'absorbing'"), &
      rule_t("&load on = 'crack'", requires, "&crack"), &
      rule_t("&load crack", requires, "&crack kind = 'line' | 'path' | 'plane'", reason="other cracks are the only one"), &
      rule_t("&load on = 'crack' and several cracks", requires, "&load crack", reason="the name selects the crack"), &
      rule_t("&load on = 'crack'", not_with, "a pressed path that grows in motion", not_built, &
             "cohesive points join cells that are cut ahead of the tip; pressure must not act there", use="law = 'quasi_static'"), &
      rule_t("&load start < 0", no_effect_with, "&load history = 'step'", &
             reason="a step load that begins before the run acts from its beginning")]

   type(rule_t), parameter :: of_contact(*) = [ &
      rule_t("&contact bodies = 'friction'", requires, "&contact friction > 0", use="&contact bodies = 'frictionless'"), &
      rule_t("&contact friction", requires, "&contact bodies = 'friction'"), &
      rule_t("&contact distance", requires, "&contact bodies = 'stick' | 'frictionless' | 'friction'", &
             reason="bonded bodies interact as soon as both have cells at a node"), &
      rule_t("&contact bodies = 'stick' | 'frictionless' | 'friction'", not_with, "&grid order = 2", not_built, &
             use="&grid order = 1")]

   type(rule_t), parameter :: of_method(*) = [ &
      rule_t("&method time = 'static' | 'implicit'", not_with, "&contact bodies = 'stick' | 'frictionless' | 'friction'", &
             not_built, "bodies that come near each other are found in explicit steps; those that touch from the start "// &
             "may have a &crack with contact along their common face", use="&method time = 'explicit'"), &
      rule_t("&method frame = 'total'", not_with, "&contact bodies = 'stick' | 'frictionless' | 'friction'", mechanics, &
             "bodies never come into contact in the total Lagrangian frame", use="&method frame = 'updated'"), &
      rule_t("&method frame = 'updated'", not_with, "&method time = 'static'", not_built, &
             "static equilibrium is found in the reference configuration", use="&method frame = 'total'"), &
      rule_t("&method frame = 'updated'", not_with, "&method time = 'implicit'", not_built, &
             "nodes keep velocity and acceleration from step to step, so they must keep their material", &
             use="&method frame = 'total'"), &
      rule_t("&method frame = 'updated'", not_with, "&grid order = 2", not_built, &
             "quadrature weights of particles hold at their reference positions only", use="&method frame = 'total'"), &
      rule_t("&method frame = 'updated'", not_with, "&crack kind = 'symmetry' and &growth law = {growth laws in motion}", &
             not_built, "the crack stays in the grid, and the material ahead of its tip moves", use="&method frame = 'total'"), &
      rule_t("&method shape_functions = 'cpdi'", requires, "&method frame = 'updated'", mechanics, &
             "particles stay in their cells in the total Lagrangian frame, where shape functions of cells are more accurate"), &
      rule_t("&method time_steps = 'local'", requires, "&method frame = 'total'", mechanics, &
             "local steps use mass matrices and moments of cells, which are constant only where particles stay in their cells"), &
      rule_t("&method time_steps = 'local'", requires, "&method scheme = 'musl'", not_built, "coarse steps have that scheme"), &
      rule_t("&method time_steps = 'local'", requires, "&method mass = 'lumped'", not_built, &
             "cells with different steps need masses of their own"), &
      rule_t("&method time_steps = 'local'", not_with, "&method time = 'static'", mechanics, &
             "equilibrium is found for all cells together", use="&method time_steps = 'global'"), &
      rule_t("&method time_steps = 'local'", not_with, "&method time = 'implicit'", mechanics, &
             "implicit steps solve for all nodes together", use="&method time_steps = 'global'"), &
      rule_t("&method time_steps = 'local'", not_with, "&grid order = 2 and &method time = 'explicit' | 'implicit'", not_built, &
             use="&method time_steps = 'global'"), &
      rule_t("&method time_steps = 'local'", not_with, "&material law /= 'linear_elastic' | 'orthotropic'", mechanics, &
             "local steps need a linear relation of forces to displacements", use="&method time_steps = 'global'"), &
      rule_t("&method time_steps = 'local'", not_with, "&material volumetric = 'b_bar'", not_built, &
             "fine steps use moments of the volume of cells", use="&material volumetric = 'standard'"), &
      rule_t("&method time_steps = 'local'", not_with, "&refine indicator = {indicators of the motion}", mechanics, &
             "vibrations of small cells grow where the mesh changes", use="&method time_steps = 'global'"), &
      (rule_t("&method time_steps = 'local'", not_with, with_forces(k), not_built, &
              "forces across faces would join cells with different steps", use="&method time_steps = 'global'"), k=1, 3), &
      rule_t("&method time_steps = 'local'", not_with, "&crack kind = 'symmetry' and &growth law = {growth laws in motion}", &
             not_built, "nodal release needs steps that are the same for all cells", use="&method time_steps = 'global'"), &
      rule_t("&method time_steps = 'local'", not_with, "&energy_release energy_balance = .true.", not_built, &
             "the numerical loss of local steps is not known", use="&method time_steps = 'global'"), &
      rule_t("&method path = 'reference'", not_with, "&method time = 'static' | 'implicit'", &
             reason="the reference step is explicit", use="&method time = 'explicit'"), &
      rule_t("&method path = 'reference'", not_with, "&method time_steps = 'local'", &
             reason="the reference step is one step of all cells", use="&method time_steps = 'global'"), &
      rule_t("&method path = 'reference'", not_with, "&method shape_functions = 'cpdi'", not_built, &
             "particles of the reference step are points of cells", use="&method shape_functions = 'linear'"), &
      rule_t("&method path = 'reference'", not_with, "&method mass = 'consistent' | 'partial' | 'fmpm' | 'weighted'", not_built, &
             "the reference step divides by lumped masses", use="&method mass = 'lumped'"), &
      rule_t("&method path = 'reference'", not_with, "&material volumetric = 'b_bar'", not_built, &
             "particles of the reference step have their own dilatation", use="&material volumetric = 'standard'"), &
      (rule_t("&constraint "//moved_by(k), not_with, "&method path = 'reference'", not_built, &
              "the reference step has no prescribed motion", use="&method path = 'fastest'"), k=1, size(moved_by)), &
      rule_t("&method path = 'reference'", not_with, "&contact bodies = 'stick' | 'frictionless' | 'friction'", not_built, &
             "the reference step has one velocity field", use="&contact bodies = 'bonded'"), &
      rule_t("&method path = 'reference'", not_with, "&crack contact = 'frictionless' | 'friction'", not_built, &
             "the reference step has no contact of faces", use="&crack contact = 'none'"), &
      rule_t("&method path = 'reference'", not_with, "&growth", not_built, "the reference step has no growth"), &
      rule_t("&method path = 'reference'", not_with, "&energy_release energy_balance = .true.", not_built, &
             "the reference step does not record numerical losses"), &
      rule_t("&method mass = 'fmpm'", not_with, "&method time = 'implicit'", mechanics, &
             "fmpm is a series for the inverse, and implicit steps use the matrix", use="&method mass = 'consistent'"), &
      rule_t("&method mass = 'lumped' | 'partial' | 'fmpm' | 'weighted'", not_with, &
             "&grid order = 2 and &method time = 'explicit' | 'implicit' and cells that are cut", mechanics, &
             "some nodes would have a lumped mass below 0", use="&method mass = 'consistent'"), &
      rule_t("&method solver = 'cg'", not_with, "a mass matrix that acts and quadratic cells at an axis", mechanics, &
             "cg is preconditioned by lumped masses, which are 0 on the axis", use="&method solver = 'direct'"), &
      rule_t("&method solver = 'cg'", not_with, &
             "&grid order = 2 and &method time = 'explicit' | 'implicit' and cells that are cut", not_built, &
             "cg is preconditioned by inverses of mass matrices of cells, and those of small cut cells may be singular", &
             use="&method solver = 'direct'"), &
      rule_t("&method time_step", requires, "&method time = 'implicit'", &
             reason="courant gives the step of 'explicit', load_steps those of 'static'"), &
      rule_t("&method hht_alpha", requires, "&method time = 'implicit'"), &
      rule_t("&method time_step > 0", not_with, "&method time = 'implicit' and &method courant > 0", &
             reason="both give the time step", use="one of both"), &
      rule_t("&method consistent_region = 'refined' and &method mass = 'partial'", requires, &
             "&refine indicator = {indicators}", reason="the matrix is consistent in refined cells"), &
      rule_t("&method courant > 0", no_effect_with, "&method time = 'static'", mechanics, "a load step has no length to limit"), &
      rule_t("&method scheme", no_effect_with, "&method time = 'static' | 'implicit'", mechanics, &
             "the scheme is the order of updates in an explicit step"), &
      rule_t("&method mass", no_effect_without, "a mass matrix that acts", mechanics, &
             "a static model needs mass to extrapolate stress only"), &
      rule_t("&method wave_speed", no_effect_with, "&method time = 'static'", mechanics, "a load step has no length to limit"), &
      rule_t("&method wave_speed and &method time = 'explicit' | 'implicit'", no_effect_without, &
             "&method courant or &method frame = 'updated'", reason="the step is a fraction of the largest stable one"), &
      rule_t("&method load_steps", no_effect_without, "&method time = 'static'"), &
      rule_t("&method start = 'static'", not_with, "&contact bodies = 'stick' | 'frictionless' | 'friction'", not_built, &
             "bodies that come near each other are found in explicit steps", use="&method start = 'undeformed'"), &
      rule_t("&method start = 'static'", not_with, "&material volumetric = 'b_bar' and &material law = {laws of any strain}", &
             not_built, "the mean of large strains has no tangent yet", use="&material volumetric = 'standard'"), &
      rule_t("&method start", no_effect_with, "&method time = 'static'", mechanics, "all states are in static equilibrium"), &
      rule_t("&method start", no_effect_without, "&load or &constraint displacement or &body eigenstrain", &
             reason="nothing acts at time 0"), &
      rule_t("&method time = 'static'", no_effect_without, &
             "&load or &constraint displacement or &constraint velocity or &body eigenstrain", &
             reason="nothing loads the model, and all displacements stay 0"), &
      rule_t("&method order", no_effect_without, "&method mass = 'fmpm' and a mass matrix that acts"), &
      rule_t("&method lumped_fraction", no_effect_without, "&method mass = 'weighted' and a mass matrix that acts"), &
      rule_t("&method consistent_region", no_effect_without, "&method mass = 'partial' and a mass matrix that acts"), &
      (rule_t("&method consistent_"//corners(k), no_effect_without, &
              "&method mass = 'partial' and a mass matrix that acts"), k=1, 2), &
      (rule_t("&method consistent_"//corners(k), no_effect_with, &
              "&method mass = 'partial' and &method consistent_region = 'refined'", &
              reason="the region consists of the refined cells"), k=1, 2), &
      rule_t("&method solver = 'direct'", no_effect_with, "&method time = 'explicit' and &method mass = 'lumped' | 'fmpm'", &
             mechanics, "lumped masses need no solution"), &
      rule_t("&damping rate", no_effect_with, "&method time = 'static'", mechanics, "a static model has no damping"), &
      rule_t("&output history_interval", no_effect_with, "samples apart from load steps", &
             reason="a row of a static history is a load step"), &
      rule_t("&method scheme = 'usf'", warned_with, "&growth law = {growth laws in motion}", mechanics, &
             "stresses lag behind a growing tip: J is 6 % low at a third of the speed of Rayleigh waves", &
             use="&method scheme = 'musl'"), &
      rule_t("&method scheme = 'usavg'", warned_with, "&growth law = {growth laws in motion}", mechanics, &
             "stresses lag behind a growing tip: J is 3 % low at a third of the speed of Rayleigh waves", &
             use="&method scheme = 'musl'"), &
      rule_t("&method mass = 'lumped'", noted_with, "&growth law = {growth laws in motion}", mechanics, &
             "K of a tip at 0.6 of the speed of Rayleigh waves is up to 4 % low, and a crack that grows by its toughness "// &
             "comes 5 % less far", use="&method mass = 'weighted'")]

   type(rule_t), parameter :: of_refinement(*) = [ &
      rule_t("&refine indicator = 'tip'", requires, "&crack"), &
      rule_t("&refine indicator = {indicators of one body}", not_with, "&contact bodies = 'stick' | 'frictionless' | 'friction'", &
             not_built, "the indicator takes all nodes of a cell for those of one body", use="&refine indicator = 'zz'"), &
      rule_t("&refine indicator = {indicators of the motion}", not_with, &
             "&grid order = 2 and &method time = 'explicit' | 'implicit' and cells that are cut", not_built, &
             "particles would have to move to finer cells", use="&refine indicator = 'tip'"), &
      rule_t("&refine max_level", no_effect_without, "&refine indicator = {indicators}", &
             reason="an indicator selects the cells to refine"), &
      (rule_t("&refine region_"//corners(k), no_effect_without, "&refine indicator = {indicators}"), k=1, 2), &
      rule_t("&refine max_particles", no_effect_without, "&refine indicator = {indicators}"), &
      rule_t("&refine field", no_effect_without, "&refine indicator = 'gradient'"), &
      (rule_t("&refine "//trim(indicator_keys(k)%name), no_effect_without, "&refine "//indicator_keys(k)%only_with), &
       k=1, size(indicator_keys)), &
      (rule_t("&refine "//of_looks(k), no_effect_without, "&refine indicator = {indicators of the motion}", &
              reason="the indicator tip refines before the first step"), &
       rule_t("&refine "//of_looks(k), no_effect_with, &
              "&method time = 'static' and &refine indicator = {indicators of the motion}", &
              mechanics, "static refinement is between load steps"), k=1, 2)]

   type(rule_t), parameter :: of_cracks(*) = [ &
      rule_t("&crack kind = 'symmetry' | 'line' | 'plane' and &crack front = 'straight'", requires, "&crack tip"), &
      rule_t("&crack front = 'disc' | 'ellipse'", requires, "&crack center and &crack radii"), &
      rule_t("&crack front = 'polygon'", requires, "&crack points"), &
      rule_t("&crack tip", requires, "&crack front = 'straight'", reason="others have a place by center or points"), &
      rule_t("&crack center", requires, "&crack front = 'disc' | 'ellipse'"), &
      rule_t("&crack radii", requires, "&crack front = 'disc' | 'ellipse'"), &
      rule_t("&crack direction", no_effect_with, "&crack front = 'disc' | 'ellipse' | 'polygon'", reason="they are closed"), &
      rule_t("&crack kind = 'path'", requires, "&crack points"), &
      rule_t("&crack points", requires, "&crack kind = 'path' or &crack front = 'polygon'"), &
      rule_t("&crack tip", not_with, "&crack kind = 'path'", reason="the ends of a path inside the material are its tips"), &
      rule_t("&crack name", no_effect_with, "&crack kind = 'symmetry'", reason="the crack is the only one and needs no name"), &
      rule_t("&crack direction", no_effect_with, "&crack kind = 'path'", reason="its points give its direction"), &
      rule_t("&crack kind = 'symmetry'", not_with, "several cracks", not_built, &
             "only cracks of the kinds line, path and plane may be several", use="a whole body and kind = 'line'"), &
      rule_t("&crack kind = 'symmetry'", not_with, "edges that are no grid lines", not_built, &
             "cells that edges cut are those of lines and paths", use="a whole body and kind = 'line'"), &
      rule_t("&crack length", requires, "&crack kind = 'line'", &
             reason="constraints give the place of a crack on a symmetry plane, points that of a path"), &
      rule_t("&crack contact = 'frictionless' | 'friction'", requires, "&crack kind = 'line' | 'path' | 'plane'", mechanics, &
             "a symmetry plane has one face, which cannot be in contact with another"), &
      rule_t("&crack contact = 'frictionless'", no_effect_with, "cohesion all along it", mechanics, &
             "faces with a cohesive zone are in contact anyway"), &
      rule_t("&crack contact = 'friction'", requires, "&crack friction > 0", use="&crack contact = 'frictionless'"), &
      rule_t("&crack friction", requires, "&crack contact = 'friction'")]

   type(rule_t), parameter :: of_cohesion(*) = [ &
      rule_t("&cohesive", requires, "&crack", reason="the group is a law for the faces of a crack"), &
      rule_t("&cohesive crack", not_with, "&crack kind = 'symmetry'", reason="such a crack is the only one"), &
      rule_t("&cohesive from", not_with, "&crack kind = 'symmetry'", reason="the tip of the crack gives it"), &
      rule_t("&cohesive strength_shear", no_effect_with, "&crack kind = 'symmetry'", mechanics, "its faces do not slide"), &
      rule_t("&cohesive toughness_shear", no_effect_with, "&crack kind = 'symmetry'", mechanics, "its faces do not slide"), &
      rule_t("&cohesive and several cracks", requires, "&cohesive crack", reason="the name selects the crack"), &
      rule_t("&cohesive", requires, "&method frame = 'total'", not_built, &
             "damage is lost where cells are cut again as faces move"), &
      rule_t("&cohesive", not_with, "&growth law = {growth laws at rest}", mechanics, &
             "growth scales loads as in a linear body, but cohesion depends on the history"), &
      rule_t("&cohesive law = 'linear' | 'bilinear'", requires, "&cohesive strength > 0 and &cohesive toughness > 0"), &
      rule_t("&cohesive law = 'bilinear'", requires, "&cohesive opening > 0"), &
      rule_t("&cohesive law = 'table'", requires, "&cohesive openings and &cohesive tractions"), &
      rule_t("&cohesive strength", requires, "&cohesive law = 'linear' | 'bilinear'", reason="the points of the table give it"), &
      rule_t("&cohesive toughness", requires, "&cohesive law = 'linear' | 'bilinear'", reason="the points of the table give it"), &
      rule_t("&cohesive opening", requires, "&cohesive law = 'bilinear'"), &
      rule_t("&cohesive openings", requires, "&cohesive law = 'table'"), &
      rule_t("&cohesive tractions", requires, "&cohesive law = 'table'"), &
      (rule_t("&cohesive "//of_shear(k), no_effect_without, "&cohesive toughness_shear or &cohesive strength_shear", &
              reason="mode II has the values of mode I"), k=1, 2)]

   type(rule_t), parameter :: of_growth(*) = [ &
      rule_t("&growth", requires, "&crack"), &
      rule_t("&growth", requires, "&energy_release estimators = 'domain_integral'", mechanics, &
             "a crack grows by G, K_I and K_II"), &
      rule_t("&growth crack", not_with, "&crack kind = 'symmetry'", reason="such a crack is the only one"), &
      rule_t("&growth and several cracks", requires, "&growth crack", reason="the name selects the crack"), &
      rule_t("&growth law = {growth laws at rest}", not_with, "growth by laws of both kinds", not_built, &
             use="laws of one kind"), &
      rule_t("&growth law = {growth laws at rest}", requires, "&method time = 'static'"), &
      rule_t("&growth law = {growth laws in motion}", requires, "&method time = 'explicit' | 'implicit'", &
             reason="a static model has no time"), &
      rule_t("&growth law = {growth laws at rest by toughness}", requires, "&growth increment > 0 and &growth toughness > 0"), &
      rule_t("&growth law = {growth laws in cycles}", requires, &
             "&growth increment > 0 and &growth rate_constant > 0 and &growth rate_exponent > 0"), &
      rule_t("&growth law = {growth laws in cycles}", requires, "something that growth scales", mechanics, &
             "loads and motions that are held do not change in a cycle"), &
      rule_t("&growth rate = 'walker' | 'forman'", requires, "&growth law = {growth laws in cycles}"), &
      rule_t("&growth rate = 'walker'", requires, "&growth walker_exponent"), &
      rule_t("&growth rate = 'forman'", requires, "&growth toughness > 0", mechanics, "its rate is infinite there"), &
      rule_t("&growth wheeler_exponent", requires, "&growth wheeler_stress > 0", mechanics, "plastic zones depend on it"), &
      rule_t("&growth wheeler_stress", no_effect_without, "&growth wheeler_exponent > 0"), &
      rule_t("&growth tips = 'largest'", not_with, "&growth law = {growth laws in cycles}", mechanics, &
             "each tip has a rate of its own", use="&growth tips = 'all'"), &
      rule_t("&cycles", requires, "&growth law = {growth laws in cycles}"), &
      (rule_t("&cycles "//trim(of_blocks(k)), requires, "&cycles blocks"), k=1, size(of_blocks)), &
      rule_t("&cycles ratio", no_effect_with, "&cycles ratios", reason="they tell it of each block"), &
      (rule_t(trim(acting(k))//" history = 'ramp' | 'smooth_ramp' | 'sine' | 'table' and "//trim(acting(k))// &
              " held = .false.", not_with, "&growth law = {growth laws in cycles}", mechanics, &
              "&cycles tells how loads change"), &
       rule_t(trim(acting(k))//" start and "//trim(acting(k))//" held = .false.", not_with, &
              "&growth law = {growth laws in cycles}", mechanics, "&cycles tells how loads change"), k=1, size(acting)), &
      rule_t("&constraint velocity and &constraint held = .false.", not_with, "&growth law = {growth laws in cycles}", mechanics, &
             "&cycles tells how much is moved; give a displacement"), &
      rule_t("&control quantity = 'load' | 'displacement'", not_with, "&growth law = {growth laws in cycles}", mechanics, &
             "&cycles tells how loads change", use="&control quantity = 'growth'"), &
      (rule_t(trim(acting(k))//" held", no_effect_without, "&growth law = {growth laws at rest} or &nucleation", mechanics, &
              "only growth at rest scales loads and motions"), k=1, size(acting)), &
      (rule_t(trim(acting(k))//" held and &growth law = {growth laws at rest}", requires, "something that growth scales", &
              mechanics, "growth scales loads and motions that are not held, so that G is the toughness"), k=1, size(acting)), &
      rule_t("&control", requires, "&growth law = {growth laws at rest}", not_built, &
             "a load frame follows cracks that grow at rest; a &constraint with a displacement moves others"), &
      rule_t("&control displacement", requires, "&control quantity = 'displacement'"), &
      rule_t("&control quantity = 'displacement'", requires, "&control displacement"), &
      (rule_t("&control "//trim(of_frame(k)), no_effect_with, "&control quantity = 'growth'", mechanics, &
              "load and displacement follow the crack"), k=1, size(of_frame)), &
      rule_t("&control", not_with, "growth scales forces beside motions", mechanics, &
             "the load of a frame and its displacement are one pair; hold the others, with held = .true."), &
      rule_t("&constraint velocity and &constraint held = .false.", not_with, "&control", mechanics, &
             "the frame tells how much is moved; give a displacement"), &
      (rule_t(trim(acting(k))//" history = 'ramp' | 'smooth_ramp' | 'sine' | 'table' and "//trim(acting(k))// &
              " held = .false.", not_with, &
              "&control", mechanics, "the frame tells how loads change, by its history"), &
       rule_t(trim(acting(k))//" start and "//trim(acting(k))//" held = .false.", not_with, &
              "&control", mechanics, "the frame tells how loads change, by its start"), k=1, size(acting)), &
      rule_t("&load on = 'crack' and &load held = .false.", not_with, "&control", not_built, &
             "the area that is pressed grows with the crack, so that there is no load of a frame"), &
      rule_t("&growth law = 'prescribed'", requires, "&growth speed > 0"), &
      rule_t("&growth law = {growth laws in motion by toughness}", requires, "&growth toughness > 0"), &
      rule_t("&growth toughness", not_with, "&growth law = {growth laws by speed}", reason="its speed is given"), &
      (rule_t("&growth "//trim(growth_law_keys(k)%name), requires, "&growth "//growth_law_keys(k)%only_with), &
       k=1, size(growth_law_keys)), &
      rule_t("&growth increment", requires, "&growth law = {growth laws at rest}", &
             reason="dynamic growth advances in each time step"), &
      rule_t("&growth limit_speed", requires, "&growth law = {growth laws in motion by toughness}"), &
      rule_t("&growth exponent", no_effect_without, "&growth limit_speed > 0"), &
      (rule_t("&growth "//trim(of_toughness(k)), not_with, "&growth law = {growth laws by speed}", reason="its speed is given"), &
       k=1, size(of_toughness)), &
      rule_t("&growth speeds", requires, "&growth law = {growth laws in motion by toughness}", &
             reason="a tip at rest has no speed"), &
      rule_t("&growth mixed_mode", no_effect_with, "&crack kind = 'symmetry'", mechanics, "the crack is in mode I"), &
      rule_t("&growth lambda", requires, "&growth mixed_mode = 'hutchinson_suo'"), &
      rule_t("&growth toughness_shear", requires, "&growth mixed_mode = 'benzeggagh_kenane'"), &
      rule_t("&growth mixed_mode_exponent", requires, "&growth mixed_mode = 'benzeggagh_kenane'"), &
      rule_t("&growth mixed_mode = 'benzeggagh_kenane'", requires, "&growth toughness_shear > 0"), &
      rule_t("&body toughness", no_effect_without, "&growth toughness > 0"), &
      rule_t("&growth start", not_with, "&growth law = {growth laws at rest}", reason="a static model has no time"), &
      rule_t("&growth end", not_with, "&growth law = {growth laws at rest}", reason="a static model has no time"), &
      rule_t("&growth direction = 'path'", requires, "&growth points"), &
      rule_t("&growth points", requires, "&growth direction = 'path'"), &
      rule_t("&growth direction = 'path'", not_with, "&growth law = {growth laws at rest}", not_built, &
             "static growth follows a criterion or the crack's own line"), &
      rule_t("&growth direction = 'hoop_stress' | 'local_symmetry' | 'max_energy' | 'path'", not_with, "&crack kind = 'symmetry'", &
             mechanics, "the crack stays on its symmetry plane", use="&growth direction = 'straight'"), &
      rule_t("&growth tips = 'last' | 'first'", not_with, "&growth law = {growth laws at rest}", not_built, &
             use="&growth tips = 'largest'"), &
      rule_t("&growth tips = 'largest'", requires, "&growth law = {growth laws at rest}", not_built, use="&growth tips = 'all'"), &
      rule_t("&growth tips = 'first'", not_with, "&crack kind = 'symmetry'", reason="the crack has one tip, its last point"), &
      rule_t("&growth tips = 'largest' | 'last'", no_effect_with, "&crack kind = 'symmetry'", mechanics, "the crack has one tip")]

   type(rule_t), parameter :: of_nucleation(*) = [ &
      rule_t("&nucleation", requires, "&crack", reason="that says where a crack may appear"), &
      rule_t("&nucleation and several cracks", requires, "&nucleation crack", reason="the name selects the crack"), &
      rule_t("&nucleation", requires, "&nucleation toughness > 0"), &
      rule_t("&nucleation", requires, "&method time = 'static'", not_built, &
             "cracks appear at rest; in motion &cohesive parts faces"), &
      rule_t("&nucleation", requires, "something that growth scales", mechanics, &
             "loads and motions that are not held are scaled until the crack appears"), &
      rule_t("&nucleation", not_with, "&crack kind = 'symmetry'", not_built, "the whole body tells the energy of a new crack"), &
      rule_t("&nucleation", not_with, "&control", not_built, "what a new crack releases depends on the stiffness of the frame"), &
      rule_t("&nucleation", not_with, "&cohesive", not_built, "the energy of cohesive faces depends on their history"), &
      rule_t("&nucleation", not_with, "&load on = 'crack'", not_built, &
             "a pressure does work on the faces of a new crack at once"), &
      rule_t("&nucleation", not_with, "&crack contact = 'frictionless' | 'friction'", not_built, &
             "energies are taken to be quadratic in the load factor", use="&crack contact = 'none'"), &
      rule_t("&nucleation", not_with, "&constraint unilateral = .true.", not_built, &
             "energies are taken to be quadratic in the load factor", use="&constraint unilateral = .false."), &
      rule_t("&nucleation", not_with, "&material law = {laws of any strain}", not_built, &
             "energies are taken to be quadratic in the load factor", use="&material law = 'linear_elastic' | 'orthotropic'"), &
      rule_t("&nucleation", not_with, with_history, mechanics, &
             "what is stored before and after does not tell what a new crack releases", &
             use="&material law = 'linear_elastic' | 'orthotropic'")]

   type(rule_t), parameter :: of_energies(*) = [ &
      rule_t("&energy_release estimators = {estimators}", requires, "&crack"), &
      rule_t("&energy_release estimators = {estimators at nodes}", not_with, "tips at no nodes", mechanics, &
             "virtual crack closure needs a tip at a node", use="'domain_integral' or 'series_fit'"), &
      rule_t("&energy_release estimators = {estimators at nodes}", not_with, &
             "&growth and &crack kind = 'symmetry' and a plane", mechanics, &
             "virtual crack closure needs a tip at a node, and a growing tip is between nodes", use="'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators at nodes}", not_with, "&cohesive", mechanics, &
             "virtual crack closure assumes traction-free crack faces", use="'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators of elastic material}", not_with, with_history, mechanics, &
             "the work of closing a crack is not that of opening it", use="'domain_integral'"), &
      rule_t("&energy_release estimators = 'stress_closure'", not_with, "&load on = 'crack'", mechanics, &
             "the derivation assumes traction-free crack faces", use="'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators of isotropic material}", not_with, "&material law = 'orthotropic'", &
             not_built, "the near-tip fields are those of isotropic material", use="'domain_integral'"), &
      (rule_t("&energy_release estimators = {estimators for traction-free faces}", not_with, on_faces(k), mechanics, &
              "the estimator assumes traction-free crack faces", use="'domain_integral'"), k=1, 4), &
      rule_t("&energy_release estimators = {estimators for stationary tips}", not_with, "&growth", not_built, &
             "the estimator is for stationary tips", use="'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators for stationary tips}", not_with, "&nucleation", not_built, &
             "the estimator is for tips that are there from the start", use="'domain_integral'"), &
      rule_t("&energy_release estimators = 'domain_integral'", warned_with, with_history, mechanics, &
             "J depends on its domain where material yields or creeps; K, modes and errors are not recorded; J_near_tip and "// &
             "J_far_field are those of the smallest and the largest one"), &
      rule_t("&energy_release estimators = 'material_force'", warned_with, with_history, mechanics, &
             "the material force depends on its disc where material yields or creeps; errors are not recorded"), &
      rule_t("&energy_release t_stress = .true.", requires, "&energy_release estimators = 'domain_integral'", mechanics, &
             "the T-stress is an interaction integral"), &
      rule_t("&energy_release t_stress = .true.", not_with, with_history, mechanics, &
             "the fields that the integral is with are those of elastic material"), &
      rule_t("&energy_release t_stress = .true.", not_with, "&growth law = {growth laws in motion}", mechanics, &
             "at a running tip the product of K and the inertia of the force that tells T is not integrable"), &
      rule_t("&energy_release phase_length", requires, "&energy_release estimators = 'domain_integral'", mechanics, &
             "K of an interface is an interaction integral"), &
      rule_t("&energy_release phase_length", not_with, with_history, mechanics, &
             "the fields that the integral is with are those of elastic material"), &
      rule_t("&energy_release phase_length", not_with, "&material law = 'orthotropic'", not_built, &
             "the fields that the integral is with are those of isotropic materials"), &
      rule_t("&energy_release phase_length", not_with, "&crack kind = 'symmetry'", mechanics, &
             "beyond a symmetry plane is the same material"), &
      rule_t("&energy_release phase_length", not_with, "&crack contact = 'frictionless' | 'friction'", mechanics, &
             "faces that touch at an interface have other fields at the tip"), &
      rule_t("&energy_release phase_length", not_with, "&growth law = {growth laws in motion}", not_built, &
             "the fields that the integral is with are those of a tip at rest"), &
      rule_t("&energy_release radii", no_effect_without, "&energy_release estimators = {estimators by radii}"), &
      rule_t("&energy_release reference = 'value'", requires, "&energy_release reference_value > 0"), &
      rule_t("&energy_release reference_value", requires, "&energy_release reference = 'value'"), &
      rule_t("&energy_release reference = 'dcb'", requires, "&crack kind = 'symmetry' | 'line'", mechanics, &
             "the closed form is for a crack along the beam"), &
      rule_t("&energy_release reference = 'dcb'", not_with, "several bodies", mechanics, "the closed form is for one beam", &
             use="reference = 'value'"), &
      rule_t("&energy_release reference = 'dcb'", not_with, "&material law = 'orthotropic'", mechanics, &
             "the closed form is for isotropic material", use="reference = 'value'"), &
      rule_t("&energy_release reference = 'dcb'", not_with, "&load kind = 'pressure' | 'gravity'", mechanics, &
             "the closed form is for forces", use="reference = 'value'"), &
      rule_t("&energy_release reference = 'dcb'", not_with, "&growth", mechanics, "the closed form is for a stationary crack")]

   type(rule_t), parameter :: of_probes(*) = [ &
      (rule_t("&probe quantity = '"//trim(of_place(k))//"'", requires, "&probe at"), k=1, size(of_place)), &
      rule_t("&probe at", requires, "&probe quantity = 'displacement' | 'velocity' | 'stress' | 'strain'"), &
      rule_t("&probe quantity = 'velocity'", not_with, "&method time = 'static'", mechanics, "a static model has no velocity"), &
      rule_t("&probe face = 'left' | 'right'", requires, "&probe at"), &
      rule_t("&probe quantity = 'opening' | 'volume'", requires, "&crack"), &
      rule_t("&probe quantity = 'opening' | 'volume' and several cracks", requires, "&probe of", &
             reason="the name selects the crack"), &
      rule_t("&probe quantity = 'load_line'", requires, "&probe of", reason="the name selects the load or constraint"), &
      rule_t("&probe quantity = 'load_line'", not_with, "&probe quantity = 'opening' | 'volume'", &
             reason="of is a crack there", use="two probes"), &
      rule_t("&probe of", requires, "&probe quantity = 'opening' | 'volume' | 'load_line'"), &
      rule_t("&probe quantity = 'opening'", requires, "&probe distance > 0"), &
      rule_t("&probe distance", requires, "&probe quantity = 'opening'"), &
      rule_t("&load name", no_effect_without, "&probe quantity = 'load_line'"), &
      rule_t("&probe tip = 'first'", requires, "&probe quantity = 'opening'")]

   integer, parameter :: of_a_group = 7          !! rows of histories

   !> All rows.
   type(rule_t), parameter :: rules(*) = [ &
      of_ends, of_rings, of_solids, of_grids, of_materials, of_bodies, of_histories(:of_a_group), of_constraints, &
      of_histories(of_a_group + 1:), of_loads, of_contact, of_method, of_refinement, of_cracks, of_cohesion, of_growth, &
      of_nucleation, of_energies, of_probes]
end module hampm_rules
