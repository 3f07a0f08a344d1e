!> The table of rules: which features of a scene do not go together, what needs what, and which keys do nothing where. Validation, the
!> warnings of `--check` and of runs, `--rules` and docs/key_rules.md all come from it. What stays outside are checks of places and of
!> numbers against each other.
!>
!> A row is a condition, a verdict, another condition (both as in `hampm_conditions`), the kind of reason, the reason, and what may be
!> used instead. The message stands at the first key of the first condition. Conditions on the same group are about the same one of
!> several; a condition on another group that may stand several times `requires` it of all of these, and is met by any of them else.
!> Only materials of which there is a body count.
module hampm_rules
   implicit none
   private
   public :: rule_t, rules, not_with, requires, no_effect_with, no_effect_without, warned_with, noted_with, mechanics, not_built, &
             by_meaning

   integer, parameter :: not_with = 1            !! verdicts: the scene is refused where both conditions hold,
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
      character(128) :: subject                  !! condition
      integer :: verdict
      character(160) :: other                    !! condition; '' for one that always holds
      integer :: basis                           !! kind of reason
      character(192) :: reason                   !! '' where the conditions say it
      character(96) :: use                       !! a condition, or words; '' for nothing
   end type rule_t

   type(rule_t), parameter :: of_histories(*) = [ &
      rule_t("&load rise_time", requires, "&load history = 'ramp'", by_meaning, "", ""), &
      rule_t("&load frequency", requires, "&load history = 'sine'", by_meaning, "", ""), &
      rule_t("&load times", requires, "&load history = 'table'", by_meaning, "", ""), &
      rule_t("&load factors", requires, "&load history = 'table'", by_meaning, "", ""), &
      rule_t("&load history = 'ramp'", requires, "&load rise_time > 0", by_meaning, "", ""), &
      rule_t("&load history = 'sine'", requires, "&load frequency > 0", by_meaning, "", ""), &
      rule_t("&load history = 'table'", requires, "&load times and &load factors", by_meaning, "", ""), &
      rule_t("&constraint rise_time", requires, "&constraint history = 'ramp'", by_meaning, "", ""), &
      rule_t("&constraint frequency", requires, "&constraint history = 'sine'", by_meaning, "", ""), &
      rule_t("&constraint times", requires, "&constraint history = 'table'", by_meaning, "", ""), &
      rule_t("&constraint factors", requires, "&constraint history = 'table'", by_meaning, "", ""), &
      rule_t("&constraint history = 'ramp'", requires, "&constraint rise_time > 0", by_meaning, "", ""), &
      rule_t("&constraint history = 'sine'", requires, "&constraint frequency > 0", by_meaning, "", ""), &
      rule_t("&constraint history = 'table'", requires, "&constraint times and &constraint factors", by_meaning, "", ""), &
      rule_t("&constraint history", no_effect_without, "&constraint displacement or &constraint velocity", by_meaning, &
             "it is that of a motion, and none is given", ""), &
      rule_t("&constraint start", no_effect_without, "&constraint displacement or &constraint velocity", by_meaning, &
             "it is that of a motion, and none is given", "")]

   type(rule_t), parameter :: of_refinement(*) = [ &
      rule_t("&refine indicator = 'tip'", requires, "&crack", by_meaning, "", ""), &
      rule_t("&refine max_level", no_effect_without, "&refine indicator = 'tip' | 'zz' | 'gradient'", by_meaning, &
             "cells refine by an indicator", ""), &
      rule_t("&refine rings", no_effect_without, "&refine indicator = 'tip'", by_meaning, "", ""), &
      rule_t("&refine tolerance", no_effect_without, "&refine indicator = 'zz'", by_meaning, "", ""), &
      rule_t("&refine field", no_effect_without, "&refine indicator = 'gradient'", by_meaning, "", ""), &
      rule_t("&refine r_crit", no_effect_without, "&refine indicator = 'gradient'", by_meaning, "", ""), &
      rule_t("&refine r_coarsen", no_effect_without, "&refine indicator = 'gradient'", by_meaning, "", ""), &
      rule_t("&refine energy_floor", no_effect_without, "&refine indicator = 'gradient'", by_meaning, "", ""), &
      rule_t("&refine region_lower", no_effect_without, "&refine indicator = 'tip' | 'zz' | 'gradient'", by_meaning, "", ""), &
      rule_t("&refine region_upper", no_effect_without, "&refine indicator = 'tip' | 'zz' | 'gradient'", by_meaning, "", ""), &
      rule_t("&refine max_particles", no_effect_without, "&refine indicator = 'tip' | 'zz' | 'gradient'", by_meaning, "", ""), &
      rule_t("&refine start", no_effect_without, "&refine indicator = 'zz' | 'gradient'", by_meaning, &
             "by the distance to a tip cells refine before the first step", ""), &
      rule_t("&refine interval", no_effect_without, "&refine indicator = 'zz' | 'gradient'", by_meaning, &
             "by the distance to a tip cells refine before the first step", ""), &
      rule_t("&refine start", no_effect_with, "&method time = 'static' and &refine indicator = 'zz' | 'gradient'", mechanics, &
             "cells refine between load steps", ""), &
      rule_t("&refine interval", no_effect_with, "&method time = 'static' and &refine indicator = 'zz' | 'gradient'", mechanics, &
             "cells refine between load steps", ""), &
      rule_t("&body points_per_cell = 1 | 3 | 5 | 7 | 9 | 11 | 13 | 15", not_with, &
             "&refine indicator = 'tip' | 'zz' | 'gradient' and &refine max_level > 0 and &grid order = 1", not_built, &
             "quarters of cells beside finer ones need points of their own", "points_per_cell = 2")]

   type(rule_t), parameter :: of_steps(*) = [ &
      rule_t("&method frame = 'updated'", not_with, "&method time = 'static'", not_built, &
             "equilibrium is found from where the material was at first", "&method frame = 'total'"), &
      rule_t("&method time_steps = 'local'", not_with, "&method time = 'static'", mechanics, "all cells rest at once", &
             "&method time_steps = 'global'"), &
      rule_t("&body velocity", not_with, "&method time = 'static'", mechanics, "what rests has none", ""), &
      rule_t("&body spin", not_with, "&method time = 'static'", mechanics, "what rests has none", ""), &
      rule_t("&body points_per_cell = 1", not_with, "&method time = 'static'", mechanics, &
             "one particle in a cell does not feel how that is bent, and nothing else holds its nodes", "points_per_cell = 2"), &
      rule_t("&method courant > 0", no_effect_with, "&method time = 'static'", mechanics, "a load step has no length to limit", &
             ""), &
      rule_t("&damping rate", no_effect_with, "&method time = 'static'", mechanics, "what rests is not damped", ""), &
      rule_t("&method scheme", no_effect_with, "&method time = 'static' | 'implicit'", mechanics, &
             "it orders the parts of an explicit step", ""), &
      rule_t("&method load_steps", no_effect_without, "&method time = 'static'", by_meaning, "", ""), &
      rule_t("&method time_step", requires, "&method time = 'implicit'", by_meaning, &
             "the step of 'explicit' is given by courant, those of 'static' by load_steps", ""), &
      rule_t("&method hht_alpha", requires, "&method time = 'implicit'", by_meaning, "", "")]

   type(rule_t), parameter :: of_cracks(*) = [ &
      rule_t("&crack kind = 'symmetry' | 'line'", not_with, "several cracks", not_built, &
             "only cracks of kind 'path' may be several", "kind = 'path' and its points"), &
      rule_t("&crack length", requires, "&crack kind = 'line'", by_meaning, &
             "on a symmetry plane the constraints tell where a crack is, of a path its points", ""), &
      rule_t("&crack contact = 'frictionless'", requires, "&crack kind = 'line' | 'path'", mechanics, &
             "at a symmetry plane there is one face, and no other to press on", ""), &
      rule_t("&crack contact = 'friction'", requires, "&crack kind = 'path'", not_built, &
             "pairs of nodes on a grid line hold each other across it only", ""), &
      rule_t("&crack contact = 'friction'", not_with, "&refine indicator = 'zz' | 'gradient' and &refine max_level > 0", &
             not_built, "cells that change in the run forget how far the faces have slid and what holds them", &
             "&refine indicator = 'tip'"), &
      rule_t("&crack contact = 'friction'", requires, "&crack friction > 0", by_meaning, "", "&crack contact = 'frictionless'"), &
      rule_t("&crack friction", requires, "&crack contact = 'friction'", by_meaning, "", "")]

   type(rule_t), parameter :: of_choices(*) = [ &
      rule_t("&method wave_speed", no_effect_without, "&method courant", &
             by_meaning, "the step is a part of the largest that is stable", ""), &
      rule_t("&method wave_speed", no_effect_with, "&method time = 'static' and &method courant", &
             mechanics, "a load step has no length to limit", ""), &
      rule_t("&method order", no_effect_without, "&method mass = 'fmpm'", by_meaning, "", ""), &
      rule_t("&method blend", no_effect_without, "&method mass = 'blend'", by_meaning, "", ""), &
      rule_t("&method full_region", no_effect_without, "&method mass = 'partial'", by_meaning, "", ""), &
      rule_t("&method full_lower", no_effect_without, "&method mass = 'partial' and &method full_region = 'box'", &
             by_meaning, "", ""), &
      rule_t("&method full_upper", no_effect_without, "&method mass = 'partial' and &method full_region = 'box'", &
             by_meaning, "", ""), &
      rule_t("&method solver = 'umfpack' | 'banded'", no_effect_without, &
             "&method mass = 'full' | 'partial' | 'blend' or &method time = 'static' | 'implicit'", &
             by_meaning, "there are no equations to solve", ""), &
      rule_t("&energy_release radii", no_effect_without, "&energy_release estimators = 'domain_integral' | 'crack_closure'", &
             by_meaning, "", ""), &
      rule_t("&energy_release reference_value", no_effect_without, "&energy_release reference = 'value'", by_meaning, "", ""), &
      rule_t("&output history_interval", no_effect_with, "samples at other times than load steps", &
             by_meaning, "at rest a row of the history is a load step", ""), &
      rule_t("&load start < 0", no_effect_with, "&load history = 'step'", &
             by_meaning, "what begins before the run is there from its beginning", ""), &
      rule_t("&growth limit_speed", no_effect_without, "&growth law = 'toughness'", by_meaning, "", ""), &
      rule_t("&growth exponent", no_effect_without, "&growth law = 'toughness' and &growth limit_speed > 0", &
             by_meaning, "", ""), &
      rule_t("&growth tips", no_effect_with, "&crack kind = 'symmetry'", mechanics, "it has one tip", ""), &
      rule_t("&crack direction", no_effect_without, "&crack kind = 'symmetry' | 'line'", &
             by_meaning, "a path goes along its points", ""), &
      rule_t("&crack name", no_effect_without, "&crack kind = 'path'", &
             by_meaning, "there is one crack, which needs no name", "")]

   !> All rows.
   type(rule_t), parameter :: rules(*) = [of_histories, of_refinement, of_steps, of_cracks, of_choices]
end module hampm_rules
