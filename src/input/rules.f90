!> The table of rules: which features of a model do not go together, what needs what, and which keys do nothing where. Validation, the
!> warnings of `--check` and of runs, `--rules` and docs/key_rules.md all come from it. What stays outside are checks of places and of
!> numbers against each other.
!>
!> A row is a condition, a verdict, another condition (both as in `hampm_conditions`), the kind of reason, the reason, and what may be
!> used instead. The message stands at the first key of the first condition. Conditions on the same group are about the same one of
!> several; a condition on another group that may stand several times `requires` it of all of these, and is met by any of them else.
!> Only materials of which there is a body, and bodies that are no holes count.
module hampm_rules
   use hampm_material_group, only: orthotropic_keys
   implicit none
   private
   public :: rule_t, rules, not_with, requires, no_effect_with, no_effect_without, warned_with, noted_with, mechanics, not_built, &
             by_meaning, with_history, for_any_strain

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
      character(96) :: subject                  !! condition
      integer :: verdict
      character(112) :: other                    !! condition; '' for one that always holds
      integer :: basis                           !! kind of reason
      character(176) :: reason                   !! '' where the conditions say it
      character(80) :: use                       !! a condition, or words; '' for nothing
   end type rule_t

   ! Of rows that differ by one word alone
   character(*), parameter :: corners(*) = ['lower', 'upper']
   character(*), parameter :: acting(*) = ['&constraint', '&load      ']
   character(*), parameter :: of_matter(*) = [character(11) :: 'material', 'velocity', 'spin', 'eigenstrain', 'part']
   character(*), parameter :: of_gradient(*) = [character(12) :: 'field', 'r_crit', 'r_coarsen', 'energy_floor']
   character(*), parameter :: of_looks(*) = ['start   ', 'interval']
   character(*), parameter :: with_forces(*) = [character(48) :: 'cracks that cut cells', &
                                                "&crack contact = 'frictionless' | 'friction'", '&cohesive']
   integer :: k

   ! Laws of a kind, which a unit test holds to what they say of themselves
   character(*), parameter :: with_history = "&material law = 'j2_plastic' | 'viscoelastic'"
   character(*), parameter :: for_any_strain = "&material law = 'neo_hookean' | 'mooney_rivlin'"

   ! Why nothing is kept at its toughness by J where material yields or creeps
   character(*), parameter :: no_rate = "J is no energy release rate where energy is dissipated around a tip that grows"

   type(rule_t), parameter :: of_rings(*) = [ &
      rule_t("&method mass = 'lumped' | 'partial' | 'fmpm' | 'blend'", not_with, &
             "a mass matrix that acts and quadratic cells at an axis", mechanics, &
             "nodes on the axis have a lumped mass of 0", "&method mass = 'full'"), &
      rule_t("&run plane = 'axisymmetric'", not_with, "&run thickness", by_meaning, &
             "that of a ring is its circumference", ""), &
      rule_t("&body spin", not_with, "&run plane = 'axisymmetric'", mechanics, &
             "a ring that turned in the plane of its section would be turned inside out", ""), &
      rule_t("&energy_release reference = 'dcb'", not_with, "&run plane = 'axisymmetric'", mechanics, &
             "a beam has no axis", ""), &
      rule_t("&run plane = 'axisymmetric'", not_with, "&method functions = 'cpdi'", not_built, &
             "the corners of a domain tell no stretch around the axis", "&method functions = 'linear'")]

   type(rule_t), parameter :: of_grids(*) = [ &
      rule_t("&grid order = 2", not_with, "&method time = 'explicit' | 'implicit' and &growth law = 'prescribed' | 'toughness'", &
             not_built, "only paths at rest grow through quadratic cells", "&grid order = 1"), &
      rule_t("&grid order = 2", not_with, "&crack kind = 'symmetry' and &growth", not_built, &
             "the bonds ahead of the tip are between nodes of bilinear cells", "&grid order = 1"), &
      rule_t("&grid order = 2", not_with, "&crack kind = 'symmetry' and &cohesive", not_built, "", "&grid order = 1")]

   type(rule_t), parameter :: of_materials(*) = [ &
      rule_t("&material law /= 'orthotropic'", requires, "&material young", &
             by_meaning, "", ""), &
      (rule_t("&material "//orthotropic_keys(k), requires, "&material law = 'orthotropic'", by_meaning, "", ""), &
       k=1, size(orthotropic_keys)), &
      rule_t("&material angle", requires, "&material law = 'orthotropic'", by_meaning, "other materials have no axes", ""), &
      rule_t("&material law = 'orthotropic'", requires, &
             "&material young_1 and &material young_2 and &material shear_12 and &material poisson_12", by_meaning, "", ""), &
      rule_t("&material law = 'orthotropic' and &run plane = 'strain' | 'axisymmetric'", requires, &
             "&material young_3 and &material poisson_13 and &material poisson_23", mechanics, &
             "the material is held across the plane", ""), &
      rule_t("&material young", not_with, "&material law = 'orthotropic'", by_meaning, "", "young_1 and young_2"), &
      rule_t("&material poisson", not_with, "&material law = 'orthotropic'", by_meaning, "", "poisson_12"), &
      rule_t("&material young_3", no_effect_with, "&run plane = 'stress'", mechanics, "the thickness is free", ""), &
      rule_t("&material poisson_13", no_effect_with, "&run plane = 'stress'", mechanics, "the thickness is free", ""), &
      rule_t("&material poisson_23", no_effect_with, "&run plane = 'stress'", mechanics, "the thickness is free", ""), &
      rule_t("&material law = 'j2_plastic'", requires, "&material yield_stress > 0", by_meaning, "", ""), &
      rule_t("&material yield_stress", requires, "&material law = 'j2_plastic'", by_meaning, "", ""), &
      rule_t("&material hardening", requires, "&material law = 'j2_plastic'", by_meaning, "", ""), &
      rule_t("&material saturation", requires, "&material law = 'j2_plastic' and &material saturation_strain", by_meaning, "", &
             ""), &
      rule_t("&material saturation_strain", requires, "&material saturation", by_meaning, "", ""), &
      rule_t("&material kinematic", requires, "&material law = 'j2_plastic'", by_meaning, "", ""), &
      rule_t("&material law = 'mooney_rivlin'", requires, "&material c01", by_meaning, "", ""), &
      rule_t("&material c01", requires, "&material law = 'mooney_rivlin'", by_meaning, "", ""), &
      rule_t("&material law = 'viscoelastic'", requires, "&material moduli and &material relaxation_times", by_meaning, "", ""), &
      rule_t("&material moduli", requires, "&material law = 'viscoelastic'", by_meaning, "", ""), &
      rule_t("&material relaxation_times", requires, "&material law = 'viscoelastic'", by_meaning, "", ""), &
      rule_t("&material dilatation = 'cell'", not_with, "&method time = 'static' | 'implicit' and "//for_any_strain, not_built, &
             "means of large strains have no tangent yet", "&material dilatation = 'point'"), &
      rule_t("&material dilatation = 'cell'", not_with, "&method functions = 'cpdi'", mechanics, &
             "the corners of a domain tell one dilatation", "&material dilatation = 'point'"), &
      rule_t("&material dilatation = 'cell'", no_effect_with, "&grid order = 2", mechanics, "quadratic cells do not lock", ""), &
      rule_t("&material dilatation = 'point'", warned_with, &
             "&material law = 'j2_plastic' and &run plane /= 'stress' and &grid order = 1", mechanics, &
             "cells that yield and cannot thin are too stiff, loads go on rising where the material has a limit", &
             "&material dilatation = 'cell'"), &
      rule_t(with_history, not_with, "&growth law = 'quasi_static'", mechanics, no_rate, ""), &
      rule_t(with_history, not_with, "&growth law = 'toughness' and &method time = 'implicit'", mechanics, no_rate, ""), &
      rule_t(with_history, not_with, "&growth direction = 'hoop_stress' | 'local_symmetry' | 'max_energy'", mechanics, &
             "there are no stress intensity factors to turn by", "&growth direction = 'straight'"), &
      rule_t("&material law = 'orthotropic'", not_with, "&growth law = 'prescribed' | 'toughness'", not_built, &
             "K and the limits of the speed of a moving tip are known of isotropic material only", ""), &
      rule_t("&material law = 'orthotropic'", not_with, "&growth direction = 'hoop_stress' | 'local_symmetry' | 'max_energy'", &
             mechanics, "where a crack goes hangs on the toughness in each direction, which is not known", &
             "&growth direction = 'straight'"), &
      rule_t("&material", no_effect_without, "a body of it", by_meaning, "", "")]

   type(rule_t), parameter :: of_bodies(*) = [ &
      rule_t("&body", requires, "&body material or &body hole = .true.", by_meaning, "", ""), &
      (rule_t("&body "//of_matter(k), not_with, "&body hole = .true.", by_meaning, "a hole has none", ""), k=1, size(of_matter)), &
      rule_t("&body points_per_cell", no_effect_with, "&body hole = .true.", by_meaning, "", ""), &
      rule_t("&body shape = 'rectangle'", requires, "&body lower and &body upper", by_meaning, "", ""), &
      rule_t("&body shape = 'polygon'", requires, "&body points", by_meaning, "", ""), &
      rule_t("&body shape = 'circle'", requires, "&body center and &body radius > 0", by_meaning, "", ""), &
      (rule_t("&body "//corners(k), requires, "&body shape = 'rectangle'", by_meaning, "", ""), k=1, 2), &
      rule_t("&body points", requires, "&body shape = 'polygon'", by_meaning, "", ""), &
      rule_t("&body center", requires, "&body shape = 'circle'", by_meaning, "", ""), &
      rule_t("&body radius", requires, "&body shape = 'circle'", by_meaning, "", ""), &
      rule_t("&body part", requires, "&contact bodies = 'stick' | 'frictionless' | 'friction'", by_meaning, &
             "parts are told apart by contact only", ""), &
      rule_t("&body part", no_effect_without, "another body of that part", mechanics, &
             "a body without a name is one by itself", ""), &
      rule_t("&body points_per_cell < 3", not_with, "&grid order = 2", mechanics, &
             "with fewer than 3 some motions of the nodes strain no particle", "&body points_per_cell = 3"), &
      rule_t("&body velocity", not_with, "&method time = 'static'", mechanics, "what rests has none", ""), &
      rule_t("&body spin", not_with, "&method time = 'static'", mechanics, "what rests has none", ""), &
      rule_t("&body eigenstrain and a shear of the eigenstrain", not_with, "&crack kind = 'symmetry'", mechanics, &
             "the other half would have the opposite shear, the third value", ""), &
      rule_t("&body eigenstrain", not_with, "&energy_release reference = 'dcb'", mechanics, "that is the closed form for forces", &
             ""), &
      rule_t("&body eigenstrain and a fourth value of the eigenstrain", warned_with, "&run plane = 'stress'", mechanics, &
             "the fourth value has no effect, as the thickness is free", "")]

   type(rule_t), parameter :: of_histories(*) = [ &
      (rule_t(trim(acting(k))//" rise_time", requires, trim(acting(k))//" history = 'ramp'", by_meaning, "", ""), &
       rule_t(trim(acting(k))//" frequency", requires, trim(acting(k))//" history = 'sine'", by_meaning, "", ""), &
       rule_t(trim(acting(k))//" times", requires, trim(acting(k))//" history = 'table'", by_meaning, "", ""), &
       rule_t(trim(acting(k))//" factors", requires, trim(acting(k))//" history = 'table'", by_meaning, "", ""), &
       rule_t(trim(acting(k))//" history = 'ramp'", requires, trim(acting(k))//" rise_time > 0", by_meaning, "", ""), &
       rule_t(trim(acting(k))//" history = 'sine'", requires, trim(acting(k))//" frequency > 0", by_meaning, "", ""), &
       rule_t(trim(acting(k))//" history = 'table'", requires, trim(acting(k))//" times and "//trim(acting(k))//" factors", &
              by_meaning, "", ""), k=1, size(acting))]

   type(rule_t), parameter :: of_constraints(*) = [ &
      rule_t("&constraint history", no_effect_without, "&constraint displacement or &constraint velocity", by_meaning, &
             "it is that of a motion, and none is given", ""), &
      rule_t("&constraint start", no_effect_without, "&constraint displacement or &constraint velocity", by_meaning, &
             "it is that of a motion, and none is given", ""), &
      rule_t("&constraint displacement and &constraint history = 'step'", not_with, "&method time = 'explicit' | 'implicit'", &
             mechanics, "nodes would jump", "history = 'ramp', or a velocity"), &
      rule_t("&constraint displacement", not_with, "&method time = 'explicit' and &method time_steps = 'local'", not_built, "", &
             "&method time_steps = 'global'"), &
      rule_t("&constraint velocity", not_with, "&method time = 'explicit' and &method time_steps = 'local'", not_built, "", &
             "&method time_steps = 'global'"), &
      rule_t("&constraint push_only = .true.", not_with, "&method time = 'explicit'", not_built, &
             "in explicit steps faces of a crack with contact part and meet again", "&method time = 'implicit'"), &
      rule_t("&constraint push_only = .true.", not_with, "&growth", not_built, &
             "loads are scaled, which is not what a support does", "")]

   type(rule_t), parameter :: of_loads(*) = [ &
      rule_t("&load kind = 'point' | 'traction' | 'body'", requires, "&load lower and &load upper and &load force", by_meaning, &
             "", ""), &
      rule_t("&load kind = 'pressure'", requires, "&load pressure", by_meaning, "", ""), &
      rule_t("&load kind = 'pressure' and &load on = 'edge'", requires, "&load lower and &load upper", by_meaning, "", ""), &
      rule_t("&load kind = 'gravity'", requires, "&load acceleration", by_meaning, "", ""), &
      (rule_t("&load "//corners(k), not_with, "&load kind = 'gravity'", by_meaning, "it acts on all bodies", "kind = 'body'"), &
       rule_t("&load "//corners(k), not_with, "&load kind = 'pressure' and &load on = 'crack'", by_meaning, &
              "it acts on the faces of the whole crack", ""), k=1, 2), &
      rule_t("&load force", not_with, "&load kind = 'pressure' | 'gravity'", by_meaning, "", ""), &
      rule_t("&load pressure", requires, "&load kind = 'pressure'", by_meaning, "", ""), &
      rule_t("&load acceleration", requires, "&load kind = 'gravity'", by_meaning, "", ""), &
      rule_t("&load on = 'crack'", requires, "&load kind = 'pressure'", by_meaning, "", ""), &
      rule_t("&load crack", requires, "&load kind = 'pressure' and &load on = 'crack'", by_meaning, "", ""), &
      rule_t("&load face = 'left' | 'right'", not_with, "&load kind = 'pressure' | 'gravity'", by_meaning, "", ""), &
      rule_t("&load on = 'crack'", requires, "&crack", by_meaning, "", ""), &
      rule_t("&load crack", requires, "&crack kind = 'line' | 'path'", by_meaning, "other cracks are the only one", ""), &
      rule_t("&load on = 'crack' and several cracks", requires, "&load crack", by_meaning, "it tells which is meant", ""), &
      rule_t("&load on = 'crack'", not_with, "a pressed path that grows in motion", not_built, &
             "bonds hold cells that are cut ahead of the tip, which must not be pressed", "law = 'quasi_static'"), &
      rule_t("&load start < 0", no_effect_with, "&load history = 'step'", by_meaning, &
             "what begins before the run is there from its beginning", "")]

   type(rule_t), parameter :: of_contact(*) = [ &
      rule_t("&contact bodies = 'friction'", requires, "&contact friction > 0", by_meaning, "", &
             "&contact bodies = 'frictionless'"), &
      rule_t("&contact friction", requires, "&contact bodies = 'friction'", by_meaning, "", ""), &
      rule_t("&contact distance", requires, "&contact bodies = 'stick' | 'frictionless' | 'friction'", by_meaning, &
             "joined bodies act on each other as soon as both have cells at a node", ""), &
      rule_t("&contact bodies = 'stick' | 'frictionless' | 'friction'", not_with, "&grid order = 2", not_built, "", &
             "&grid order = 1")]

   type(rule_t), parameter :: of_method(*) = [ &
      rule_t("&method time = 'static' | 'implicit'", not_with, "&contact bodies = 'stick' | 'frictionless' | 'friction'", &
             not_built, "whether bodies touch is found in each short step", "&method time = 'explicit'"), &
      rule_t("&method frame = 'total'", not_with, "&contact bodies = 'stick' | 'frictionless' | 'friction'", mechanics, &
             "in the total frame bodies never meet", "&method frame = 'updated'"), &
      rule_t("&method frame = 'updated'", not_with, "&method time = 'static'", not_built, &
             "equilibrium is found from where the material was at first", "&method frame = 'total'"), &
      rule_t("&method frame = 'updated'", not_with, "&method time = 'implicit'", not_built, &
             "the nodes keep their motion from step to step, and so their material", "&method frame = 'total'"), &
      rule_t("&method frame = 'updated'", not_with, "&grid order = 2", not_built, "particles stay where their weights are right", &
             "&method frame = 'total'"), &
      rule_t("&method frame = 'updated'", not_with, "&growth law = 'prescribed' | 'toughness'", not_built, &
             "bonds ahead of a tip are between nodes that keep their material", "&method frame = 'total'"), &
      rule_t("&method functions = 'cpdi'", requires, "&method frame = 'updated'", mechanics, &
             "in the total frame particles stay in their cells, whose own functions are the better ones", ""), &
      rule_t("&method time_steps = 'local'", requires, "&method frame = 'total'", mechanics, &
             "cells take their steps by mass matrices and moments that stay only where particles stay in their cells", ""), &
      rule_t("&method time_steps = 'local'", requires, "&method scheme = 'musl'", not_built, &
             "its coarse steps are of that scheme", ""), &
      rule_t("&method time_steps = 'local'", requires, "&method mass = 'lumped'", not_built, &
             "cells that step apart need masses of their own", ""), &
      rule_t("&method time_steps = 'local'", not_with, "&method time = 'static'", mechanics, "all cells rest at once", &
             "&method time_steps = 'global'"), &
      rule_t("&method time_steps = 'local'", not_with, "&method time = 'implicit'", mechanics, &
             "all nodes are solved for at once", "&method time_steps = 'global'"), &
      rule_t("&method time_steps = 'local'", not_with, "&grid order = 2 and &method time = 'explicit' | 'implicit'", not_built, &
             "", "&method time_steps = 'global'"), &
      rule_t("&method time_steps = 'local'", not_with, "&material law /= 'linear_elastic' | 'orthotropic'", mechanics, &
             "cells take their steps by a linear relation of forces to displacements", "&method time_steps = 'global'"), &
      rule_t("&method time_steps = 'local'", not_with, "&material dilatation = 'cell'", not_built, &
             "fine steps are those of cells by moments of their volume", "&material dilatation = 'point'"), &
      rule_t("&method time_steps = 'local'", not_with, "&refine indicator = 'gradient' | 'zz'", mechanics, &
             "where the mesh changes, vibrations of the small cells grow", "&method time_steps = 'global'"), &
      (rule_t("&method time_steps = 'local'", not_with, with_forces(k), not_built, &
              "forces act across faces between cells that step apart", "&method time_steps = 'global'"), k=1, 3), &
      rule_t("&method time_steps = 'local'", not_with, "&crack kind = 'symmetry' and &growth law = 'prescribed' | 'toughness'", &
             not_built, "bonds are let go in steps that are the same for all", "&method time_steps = 'global'"), &
      rule_t("&method time_steps = 'local'", not_with, "&energy_release estimators = 'energy_balance'", not_built, &
             "the loss of the method is not known with them", "&method time_steps = 'global'"), &
      rule_t("&method path = 'reference'", not_with, "&method time = 'static' | 'implicit'", by_meaning, "it is an explicit step", &
             "&method time = 'explicit'"), &
      rule_t("&method path = 'reference'", not_with, "&method time_steps = 'local'", by_meaning, "it is one step of all cells", &
             "&method time_steps = 'global'"), &
      rule_t("&method path = 'reference'", not_with, "&method functions = 'cpdi'", not_built, &
             "its particles are points of cells", "&method functions = 'linear'"), &
      rule_t("&method path = 'reference'", not_with, "&method mass = 'full' | 'partial' | 'fmpm' | 'blend'", not_built, &
             "it divides by the masses of nodes", "&method mass = 'lumped'"), &
      rule_t("&method path = 'reference'", not_with, "&material dilatation = 'cell'", not_built, &
             "its particles have a dilatation each", "&material dilatation = 'point'"), &
      rule_t("&constraint displacement", not_with, "&method path = 'reference'", not_built, "what it holds rests", &
             "&method path = 'fastest'"), &
      rule_t("&constraint velocity", not_with, "&method path = 'reference'", not_built, "what it holds rests", &
             "&method path = 'fastest'"), &
      rule_t("&method path = 'reference'", not_with, "&contact bodies = 'stick' | 'frictionless' | 'friction'", not_built, &
             "it has one velocity field", "&contact bodies = 'joined'"), &
      rule_t("&method path = 'reference'", not_with, "&crack contact = 'frictionless' | 'friction'", not_built, &
             "its faces do not touch", "&crack contact = 'none'"), &
      rule_t("&method path = 'reference'", not_with, "&growth", not_built, "its cracks stay", ""), &
      rule_t("&method path = 'reference'", not_with, "&energy_release estimators = 'energy_balance'", not_built, &
             "it books no losses of the method", ""), &
      rule_t("&method mass = 'fmpm'", not_with, "&method time = 'implicit'", mechanics, &
             "it is a series for the inverse, and these steps use the matrix", "&method mass = 'full'"), &
      rule_t("&method mass = 'lumped' | 'partial' | 'fmpm' | 'blend'", not_with, &
             "&grid order = 2 and &method time = 'explicit' | 'implicit' and cells that are cut", mechanics, &
             "some nodes would have a lumped mass below 0", "&method mass = 'full'"), &
      rule_t("&method solver = 'cg'", not_with, &
             "a mass matrix that acts and quadratic cells at an axis", mechanics, &
             "it begins with lumped masses, which nodes on the axis have not", "&method solver = 'direct'"), &
      rule_t("&method solver = 'cg'", not_with, &
             "&grid order = 2 and &method time = 'explicit' | 'implicit' and cells that are cut", not_built, &
             "it begins with inverses of the mass matrices of cells, and pieces of these may have none", &
             "&method solver = 'direct'"), &
      rule_t("&method time_step", requires, "&method time = 'implicit'", by_meaning, &
             "the step of 'explicit' is given by courant, those of 'static' by load_steps", ""), &
      rule_t("&method hht_alpha", requires, "&method time = 'implicit'", by_meaning, "", ""), &
      rule_t("&method time_step > 0", not_with, "&method time = 'implicit' and &method courant > 0", by_meaning, &
             "both are the length of a step", "one of both"), &
      rule_t("&method full_region = 'refined' and &method mass = 'partial'", requires, &
             "&refine indicator = 'tip' | 'zz' | 'gradient'", by_meaning, "it is full in the cells that are refined", ""), &
      rule_t("&method courant > 0", no_effect_with, "&method time = 'static'", mechanics, "a load step has no length to limit", &
             ""), &
      rule_t("&method scheme", no_effect_with, "&method time = 'static' | 'implicit'", mechanics, &
             "it orders the parts of an explicit step", ""), &
      rule_t("&method mass", no_effect_without, "a mass matrix that acts", mechanics, &
             "what rests needs no mass, but to extrapolate stress", ""), &
      rule_t("&method wave_speed", no_effect_with, "&method time = 'static'", mechanics, "a load step has no length to limit", &
             ""), &
      rule_t("&method wave_speed and &method time = 'explicit' | 'implicit'", no_effect_without, &
             "&method courant or &method frame = 'updated'", by_meaning, "the step is a part of the largest that is stable", ""), &
      rule_t("&method load_steps", no_effect_without, "&method time = 'static'", by_meaning, "", ""), &
      rule_t("&method order", no_effect_without, "&method mass = 'fmpm' and a mass matrix that acts", by_meaning, &
             "", ""), &
      rule_t("&method blend", no_effect_without, "&method mass = 'blend' and a mass matrix that acts", by_meaning, &
             "", ""), &
      rule_t("&method full_region", no_effect_without, "&method mass = 'partial' and a mass matrix that acts", &
             by_meaning, "", ""), &
      (rule_t("&method full_"//corners(k), no_effect_without, "&method mass = 'partial' and a mass matrix that acts", &
              by_meaning, "", ""), k=1, 2), &
      (rule_t("&method full_"//corners(k), no_effect_with, "&method mass = 'partial' and &method full_region = 'refined'", &
              by_meaning, "the region is that of the cells that are refined", ""), k=1, 2), &
      rule_t("&method solver = 'direct'", no_effect_with, &
             "&method time = 'explicit' and &method mass = 'lumped' | 'fmpm'", mechanics, "no equations are solved", ""), &
      rule_t("&damping rate", no_effect_with, "&method time = 'static'", mechanics, "what rests is not damped", ""), &
      rule_t("&output history_interval", no_effect_with, "samples at other times than load steps", by_meaning, &
             "at rest a row of the history is a load step", ""), &
      rule_t("&method scheme = 'usf'", warned_with, "&growth law = 'prescribed' | 'toughness'", mechanics, &
             "stresses are behind the tip of a crack that grows, J at a third of the speed of Rayleigh waves is 6 % low", &
             "&method scheme = 'musl'"), &
      rule_t("&method scheme = 'usavg'", warned_with, "&growth law = 'prescribed' | 'toughness'", mechanics, &
             "stresses are behind the tip of a crack that grows, J at a third of the speed of Rayleigh waves is 3 % low", &
             "&method scheme = 'musl'"), &
      rule_t("&method mass = 'lumped'", noted_with, "&growth law = 'prescribed' | 'toughness'", mechanics, &
             "K of a crack that grows at 0.6 of the speed of Rayleigh waves is up to 4 % low, and by its toughness it comes "// &
             "5 % less far", "&method mass = 'blend'")]

   type(rule_t), parameter :: of_refinement(*) = [ &
      rule_t("&refine indicator = 'tip'", requires, "&crack", by_meaning, "", ""), &
      rule_t("&refine indicator = 'gradient'", not_with, "&contact bodies = 'stick' | 'frictionless' | 'friction'", not_built, &
             "it takes all nodes of a cell for those of one body", "&refine indicator = 'zz'"), &
      rule_t("&refine indicator = 'zz' | 'gradient'", not_with, &
             "&grid order = 2 and &method time = 'explicit' | 'implicit' and cells that are cut", not_built, &
             "particles would have to be given to finer cells", "&refine indicator = 'tip'"), &
      rule_t("&refine max_level", no_effect_without, "&refine indicator = 'tip' | 'zz' | 'gradient'", by_meaning, &
             "cells refine by an indicator", ""), &
      (rule_t("&refine region_"//corners(k), no_effect_without, "&refine indicator = 'tip' | 'zz' | 'gradient'", by_meaning, "", &
              ""), k=1, 2), &
      rule_t("&refine max_particles", no_effect_without, "&refine indicator = 'tip' | 'zz' | 'gradient'", by_meaning, "", ""), &
      rule_t("&refine rings", no_effect_without, "&refine indicator = 'tip'", by_meaning, "", ""), &
      rule_t("&refine tolerance", no_effect_without, "&refine indicator = 'zz'", by_meaning, "", ""), &
      (rule_t("&refine "//of_gradient(k), no_effect_without, "&refine indicator = 'gradient'", by_meaning, "", ""), &
       k=1, size(of_gradient)), &
      (rule_t("&refine "//of_looks(k), no_effect_without, "&refine indicator = 'zz' | 'gradient'", by_meaning, &
              "by the distance to a tip cells refine before the first step", ""), &
       rule_t("&refine "//of_looks(k), no_effect_with, "&method time = 'static' and &refine indicator = 'zz' | 'gradient'", &
              mechanics, "cells refine between load steps", ""), k=1, 2)]

   type(rule_t), parameter :: of_cracks(*) = [ &
      rule_t("&crack kind = 'symmetry' | 'line'", requires, "&crack tip", by_meaning, "", ""), &
      rule_t("&crack kind = 'path'", requires, "&crack points", by_meaning, "", ""), &
      rule_t("&crack points", requires, "&crack kind = 'path'", by_meaning, "", ""), &
      rule_t("&crack tip", not_with, "&crack kind = 'path'", by_meaning, "the ends of a path inside the material are its tips", &
             ""), &
      rule_t("&crack name", no_effect_with, "&crack kind = 'symmetry'", by_meaning, "there is one crack, which needs no name", &
             ""), &
      rule_t("&crack direction", no_effect_with, "&crack kind = 'path'", by_meaning, "its points tell where it goes", ""), &
      rule_t("&crack kind = 'symmetry'", not_with, "several cracks", not_built, &
             "only cracks of the kinds line and path may be several", "a whole body and kind = 'line'"), &
      rule_t("&crack kind = 'symmetry'", not_with, "edges that are no grid lines", not_built, &
             "cells that edges cut are those of lines and paths", "a whole body and kind = 'line'"), &
      rule_t("&crack length", requires, "&crack kind = 'line'", by_meaning, &
             "on a symmetry plane the constraints tell where a crack is, of a path its points", ""), &
      rule_t("&crack contact = 'frictionless' | 'friction'", requires, "&crack kind = 'line' | 'path'", mechanics, &
             "at a symmetry plane there is one face, and no other to press on", ""), &
      rule_t("&crack contact = 'frictionless'", no_effect_with, "cohesion all along it", mechanics, &
             "faces that cohesion holds or has held press on each other", ""), &
      rule_t("&crack contact = 'friction'", requires, "&crack friction > 0", by_meaning, "", "&crack contact = 'frictionless'"), &
      rule_t("&crack friction", requires, "&crack contact = 'friction'", by_meaning, "", ""), &
      rule_t("&crack contact = 'friction'", not_with, "&growth and &method time = 'static'", not_built, &
             "tips grow before the loads follow, and what slides meanwhile does not slide back", &
             "&method time = 'implicit'")]

   type(rule_t), parameter :: of_cohesion(*) = [ &
      rule_t("&cohesive", requires, "&crack", by_meaning, "it tells how its faces hold each other", ""), &
      rule_t("&cohesive crack", not_with, "&crack kind = 'symmetry'", by_meaning, "such a crack is the only one", ""), &
      rule_t("&cohesive from", not_with, "&crack kind = 'symmetry'", by_meaning, "its tip tells it", ""), &
      rule_t("&cohesive strength_shear", no_effect_with, "&crack kind = 'symmetry'", mechanics, "its faces do not slide", ""), &
      rule_t("&cohesive toughness_shear", no_effect_with, "&crack kind = 'symmetry'", mechanics, "its faces do not slide", ""), &
      rule_t("&cohesive and several cracks", requires, "&cohesive crack", by_meaning, "it tells which is meant", ""), &
      rule_t("&cohesive", requires, "&method frame = 'total'", not_built, &
             "cells are cut anew as the faces move, and forget their damage", ""), &
      rule_t("&cohesive", not_with, "&growth law = 'quasi_static'", mechanics, &
             "loads are scaled as those of a linear body, which forgets them", ""), &
      rule_t("&cohesive law = 'linear' | 'bilinear'", requires, "&cohesive strength > 0 and &cohesive toughness > 0", by_meaning, &
             "", ""), &
      rule_t("&cohesive law = 'bilinear'", requires, "&cohesive opening > 0", by_meaning, "", ""), &
      rule_t("&cohesive law = 'table'", requires, "&cohesive openings and &cohesive tractions", by_meaning, "", ""), &
      rule_t("&cohesive strength", requires, "&cohesive law = 'linear' | 'bilinear'", by_meaning, "the points tell it", ""), &
      rule_t("&cohesive toughness", requires, "&cohesive law = 'linear' | 'bilinear'", by_meaning, "the points tell it", ""), &
      rule_t("&cohesive opening", requires, "&cohesive law = 'bilinear'", by_meaning, "", ""), &
      rule_t("&cohesive openings", requires, "&cohesive law = 'table'", by_meaning, "", ""), &
      rule_t("&cohesive tractions", requires, "&cohesive law = 'table'", by_meaning, "", ""), &
      rule_t("&cohesive exponent", no_effect_without, "&cohesive toughness_shear or &cohesive strength_shear", by_meaning, &
             "sliding takes what opening does", ""), &
      rule_t("&cohesive mixed_mode", no_effect_without, "&cohesive toughness_shear or &cohesive strength_shear", by_meaning, &
             "sliding takes what opening does", "")]

   type(rule_t), parameter :: of_growth(*) = [ &
      rule_t("&growth", requires, "&crack", by_meaning, "", ""), &
      rule_t("&growth", requires, "&energy_release estimators = 'domain_integral'", mechanics, &
             "a crack grows by G, K_I and K_II", ""), &
      rule_t("&growth crack", not_with, "&crack kind = 'symmetry'", by_meaning, "such a crack is the only one", ""), &
      rule_t("&growth and several cracks", requires, "&growth crack", by_meaning, "it tells which is meant", ""), &
      rule_t("&growth law = 'quasi_static'", not_with, "growth by laws of both kinds", not_built, "", &
             "law = 'quasi_static' of each or of none"), &
      rule_t("&growth law = 'quasi_static'", requires, "&method time = 'static'", by_meaning, "", ""), &
      rule_t("&growth law = 'prescribed' | 'toughness'", requires, "&method time = 'explicit' | 'implicit'", by_meaning, &
             "at rest there is no time", ""), &
      rule_t("&growth law = 'quasi_static'", requires, "&growth increment > 0 and &growth toughness > 0", by_meaning, "", ""), &
      rule_t("&growth law = 'prescribed'", requires, "&growth speed > 0", by_meaning, "", ""), &
      rule_t("&growth law = 'toughness'", requires, "&growth toughness > 0", by_meaning, "", ""), &
      rule_t("&growth toughness", not_with, "&growth law = 'prescribed'", by_meaning, "its speed is given", ""), &
      rule_t("&growth speed", requires, "&growth law = 'prescribed'", by_meaning, "else it follows from the toughness", ""), &
      rule_t("&growth increment", requires, "&growth law = 'quasi_static'", by_meaning, "in motion tips go on step by step", ""), &
      rule_t("&growth limit_speed", requires, "&growth law = 'toughness'", by_meaning, "", ""), &
      rule_t("&growth exponent", no_effect_without, "&growth limit_speed > 0", by_meaning, "", ""), &
      rule_t("&growth start", not_with, "&growth law = 'quasi_static'", by_meaning, "at rest there is no time", ""), &
      rule_t("&growth end", not_with, "&growth law = 'quasi_static'", by_meaning, "at rest there is no time", ""), &
      rule_t("&growth direction = 'path'", requires, "&growth points", by_meaning, "", ""), &
      rule_t("&growth points", requires, "&growth direction = 'path'", by_meaning, "", ""), &
      rule_t("&growth direction = 'path'", not_with, "&growth law = 'quasi_static'", not_built, &
             "at rest tips go where the criterion or their own line leads", ""), &
      rule_t("&growth direction = 'hoop_stress' | 'local_symmetry' | 'max_energy' | 'path'", not_with, &
             "&crack kind = 'symmetry'", mechanics, "it stays on its plane", "&growth direction = 'straight'"), &
      rule_t("&growth tips = 'last' | 'first'", not_with, "&growth law = 'quasi_static'", not_built, "", &
             "&growth tips = 'largest'"), &
      rule_t("&growth tips = 'largest'", requires, "&growth law = 'quasi_static'", not_built, "", "&growth tips = 'all'"), &
      rule_t("&growth tips = 'first'", not_with, "&crack kind = 'symmetry'", by_meaning, "it has one tip, the last point", ""), &
      rule_t("&growth tips = 'largest' | 'last'", no_effect_with, "&crack kind = 'symmetry'", mechanics, "it has one tip", "")]

   type(rule_t), parameter :: of_energies(*) = [ &
      rule_t("&energy_release estimators = {estimators}", requires, "&crack", by_meaning, "", ""), &
      rule_t("&energy_release estimators = {estimators at nodes}", not_with, "tips at no nodes", mechanics, &
             "by nodes these close a crack", "'domain_integral' or 'crack_closure'"), &
      rule_t("&energy_release estimators = {estimators at nodes}", not_with, "&growth and &crack kind = 'symmetry'", &
             mechanics, "the tip leaves the nodes, by which these close a crack", "'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators at nodes}", not_with, "&cohesive", &
             mechanics, "they take faces for free", "'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators of elastic material}", not_with, with_history, mechanics, &
             "closing a crack does not give back what its opening took", "'domain_integral'"), &
      rule_t("&energy_release estimators = 'stress_closure'", not_with, "&load on = 'crack'", mechanics, &
             "it has free faces in its derivation", "'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators of free faces}", not_with, &
             "&crack contact = 'frictionless' | 'friction'", mechanics, "it takes faces for free", "'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators of isotropic material}", not_with, "&material law = 'orthotropic'", &
             not_built, "its fields are those of isotropic material", "'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators of free faces}", not_with, "&load on = 'crack'", mechanics, &
             "it takes faces for free", "'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators of free faces}", not_with, "&load face = 'left' | 'right'", mechanics, &
             "it takes faces for free", "'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators of free faces}", not_with, "&cohesive", mechanics, &
             "it takes faces for free", "'domain_integral'"), &
      rule_t("&energy_release estimators = {estimators of tips that rest}", not_with, "&growth", not_built, &
             "it is for tips that rest", "'domain_integral'"), &
      rule_t("&energy_release estimators = 'domain_integral'", warned_with, with_history, &
             mechanics, &
             "where material yields or creeps J depends on its domain, K, modes and errors are not recorded; J_near_tip and "// &
             "J_far_field are those of the smallest and the largest one", ""), &
      rule_t("&energy_release radii", no_effect_without, "&energy_release estimators = {estimators by radii}", &
             by_meaning, "", ""), &
      rule_t("&energy_release reference = 'value'", requires, "&energy_release reference_value > 0", by_meaning, "", ""), &
      rule_t("&energy_release reference_value", requires, "&energy_release reference = 'value'", by_meaning, "", ""), &
      rule_t("&energy_release reference = 'dcb'", requires, "&crack kind = 'symmetry' | 'line'", mechanics, &
             "it is a closed form of a crack along the beam", ""), &
      rule_t("&energy_release reference = 'dcb'", not_with, "several bodies", mechanics, "it is a closed form of one beam", &
             "reference = 'value'"), &
      rule_t("&energy_release reference = 'dcb'", not_with, "&material law = 'orthotropic'", mechanics, &
             "it is a closed form of isotropic material", "reference = 'value'"), &
      rule_t("&energy_release reference = 'dcb'", not_with, "&load kind = 'pressure' | 'gravity'", mechanics, &
             "it is a closed form for forces", "reference = 'value'"), &
      rule_t("&energy_release reference = 'dcb'", not_with, "&growth", mechanics, "it is a closed form of a crack that rests", "")]

   !> All rows.
   type(rule_t), parameter :: rules(*) = [ &
      of_rings, of_grids, of_materials, of_bodies, of_histories(:size(of_histories)/2), of_constraints, &
      of_histories(size(of_histories)/2 + 1:), of_loads, of_contact, &
      of_method, of_refinement, of_cracks, of_cohesion, of_growth, of_energies]
end module hampm_rules
