"""Every mistake of a user ends with exit code 2 (or 4 for files) and a message that says where, what and what is right."""

import os
import re

import h5py
import pytest
from base_case import GOOD, LINE, REFINE, changed, line_of
from paths import ROOT

BODY = "  lower = 0.0, 0.0\n  upper = 0.1, 0.01\n"
TRACTION = "  kind = 'traction'\n  lower = 0.0, 0.0\n  upper = 0.0, 0.01\n"
HELD = "  lower = 0.05, 0.0\n  upper = 0.1, 0.0\n  fix = 'y'\n"


def assert_refused(result, code, *phrases):
    """The program stopped with this code and these phrases, and not by an accident of its own."""
    assert result.returncode == code, result.stderr
    assert result.stdout == ""
    for line in result.stderr.splitlines():
        assert line.startswith("hampm: "), result.stderr
    for accident in ("backtrace", "Fortran runtime", "At line", "Sanitizer", "SIG"):
        assert accident not in result.stderr
    for phrase in phrases:
        assert phrase in result.stderr, result.stderr


# One replacement in the good scene; a fragment that finds the line the message must name; phrases of the message.
VALUES = [
    ("young = 70e9", "young = -70e9", "young", "&material young = -70e9: must be in (0, inf) [Pa]"),
    ("young = 70e9", "young = 0", "young", "&material young = 0: must be in (0, inf) [Pa]"),
    ("young = 70e9", "young = nan", "young", "young = nan: must be in (0, inf) [Pa], finite"),
    ("young = 70e9", "young = +Infinity", "young", "young = +Infinity: must be in (0, inf) [Pa], finite"),
    ("young = 70e9", "young = 1e999", "young", "young = 1e999: must be in (0, inf) [Pa], finite"),
    ("young = 70e9", "young = 1e-99999999999999", "young", "finite and in size 0 or from 1e-100 to 1e100"),
    ("young = 70e9", "young = 70e9Pa", "young", "young = 70e9Pa: must be in (0, inf) [Pa] (it is no number)"),
    ("young = 70e9", "young = 70e", "young", "young = 70e: must be in (0, inf) [Pa] (it is no number)"),
    ("young = 70e9", "young = .", "young", "young = .: must be in (0, inf) [Pa] (it is no number)"),
    ("young = 70e9", "young = '70e9'", "young", "young = '70e9': must be in (0, inf) [Pa] (it is no number)"),
    ("young = 70e9", "young = .true.", "young", "(it is no number)"),
    ("young = 70e9", "young =", "law =", "&material 'aluminium' law = 'linear_elastic' requires young"),
    ("young = 70e9", "young = 70e9 71e9", "young", "may have at most 1 value"),
    ("young = 70e9", "young = 1000*70e9 70e9", "young", "may have at most 1 value"),
    ("young = 70e9", "young = " + "7" * 5000, "young", "(it is no number)"),
    ("poisson = 0.3", "poisson = 0.5", "poisson", "poisson = 0.5: must be in (-1, 0.5)"),
    ("poisson = 0.3", "poisson = -1", "poisson", "poisson = -1: must be in (-1, 0.5)"),
    ("density = 2700", "density = (2700)", "density", "density = (2700): must be in (0, inf) [kg/m3] (it is no number)"),
    ("thickness = 0.01", "thickness = -0.01", "thickness", "&run thickness = -0.01: must be in (0, inf) [m]"),
    ("cells = 80, 9", "cells = 80, 0", "cells", "cells = 80, 0: value 2 must be an integer in [1, inf)"),
    ("cells = 80, 9", "cells = 80.5, 9", "cells", "value 1 must be an integer in [1, inf) (it is no integer)"),
    ("cells = 80, 9", "cells = 80", "cells", "must have 2 values, not 1; each must be an integer in [1, inf)"),
    ("cells = 80, 9", "cells = 99999999999, 9", "cells", "value 1 must be an integer in [1, inf) and at most 2147483647"),
    ("cells = 80, 9", "cells = 2147483648, 9", "cells", "value 1 must be an integer in [1, inf) and at most 2147483647"),
    ("cells = 80, 9", "cells = 2147483647, 9", "cells", "they must have at most 5e8 nodes"),
    ("cells = 80, 9", "cells = 100000, 100000", "cells", "they must have at most 5e8 nodes"),
    ("points_per_cell = 2", "points_per_cell = 17", "points", "must be an integer in [1, 16]"),
    ("points_per_cell = 2", "points_per_cell = 2.0", "points", "points_per_cell = 2.0: must be an integer"),
    ("courant = 0.1", "courant = 1000.5", "courant", "&method courant = 1000.5: must be in [0, 1000]"),
    ("courant = 0.1", "courant = 0.1 time_step = -1e-6", "time_step", "&method time_step = -1e-6: must be in [0, inf) [s]"),
    ("courant = 0.1", "courant = 0.1 hht_alpha = -0.4", "hht_alpha", "&method hht_alpha = -0.4: must be in [-0.33334, 0]"),
    ("courant = 0.1", "courant = 0.1 hht_alpha = 0.1", "hht_alpha", "&method hht_alpha = 0.1: must be in [-0.33334, 0]"),
    ("courant = 0.1", "courant = 0.1 time = 'implict'", "time =", "must be 'explicit', 'implicit', 'static' or 'modal'; did you mean 'implicit'?"),
    ("rate = 1e4", "rate = -1", "rate =", "&damping rate = -1: must be in [0, inf) [1/s]"),
    ("'musl'", "'mulsl'", "scheme", "scheme = 'mulsl': must be 'usf', 'usl', 'usavg' or 'musl'; did you mean 'musl'?"),
    ("'musl'", "musl", "scheme", "scheme = musl: must be in quotes: 'musl'"),
    ("'musl'", "''", "scheme", "scheme = '': must be 'usf', 'usl', 'usavg' or 'musl'"),
    ("'musl'", "7", "scheme", "scheme = 7: must be in quotes"),
    ("fix = 'y'", "fix = 'z'", "fix", "&constraint fix = 'z': must be 'x', 'y' or 'xy'"),
    ("plane = 'stress'", "plane = 'strian'", "plane", "did you mean 'strain'?"),
    ("'vcct',", "'nodal_forces',", "estimators", "value 1 must be 'domain_integral', 'vcct', 'material_force'"),
    ("'vcct',", "10*'vcct',", "estimators", "may have at most "),
    ("title = 'beam'", "title = '" + "x" * 1100 + "'", "title", "must not be longer than 1024 characters"),
    ("title = 'beam'", "title = 'a\x07b'", "title", "title = 'a?b': must not contain control characters"),
    ("name = 'aluminium'", "name = '" + "x" * 70 + "'", "name", "must not be longer than 64 characters"),
    ("name = 'aluminium'", "name = ''", "name", "&material name = '': must not be empty"),
]

SYNTAX = [
    ("young = 70e9", "yuong = 70e9", "yuong", "&material has no key 'yuong'; did you mean 'young'?"),
    ("young = 70e9", "thickness = 1", "= 1\n  poisson", "&material has no key 'thickness'; 'thickness' is a key of &run"),
    ("young = 70e9", "young 70e9", "young", "&material young: '=' is missing behind the key"),
    ("young = 70e9", "young = = 70e9", "young", "'= 70e9' stands where a key is expected"),
    ("young = 70e9", "young = 70e9, young = 71e9", "young", "&material young: is given twice in this group"),
    ("young = 70e9", "young = ,70e9", "young", "young = , 70e9: may have at most 1 value"),
    ("young = 70e9", "young = 0*70e9", "young", "the count of a repeat must be an integer in [1, 10000]"),
    ("young = 70e9", "young = 99999999999*70e9", "young", "the count of a repeat must be an integer in [1, 10000]"),
    ("density = 2700", "density = 1*", "&material", "&material density: is missing"),
    ("upper = 0.1, 0.01", "upper(1) = 0.1", "upper(1)", "subscripts and components are not read here"),
    ("upper = 0.1, 0.01", "upper%x = 0.1", "upper%x", "subscripts and components are not read here"),
    ("upper = 0.1, 0.01", "upper = 0.1,,0.01", "0.1,,", "&body upper = 0.1, , 0.01: may have at most 2 values"),
    ("points_per_cell = 2", "points_per_cell 2", "points_per_cell 2", "&body points_per_cell: '=' is missing"),
    ("name = 'aluminium'", "name = 'aluminium", "name", "the closing ' of 'aluminium is missing on this line"),
    ("density = 2700", "density = 2700\n  colour = 'red'", "colour",
     "&material has no key 'colour'; its keys are name, law, young, poisson, density, volumetric, yield_stress, hardening"),
    ("&damping", "&unheard_of", "&unheard_of", "there is no group &unheard_of; groups are run, grid, material, body, constraint, "),
    ("&damping", "&dampng", "&dampng", "there is no group &dampng; did you mean 'damping'?"),
    ("&damping", "&", "&\n", "the name of a group is missing behind '&'"),
    ("&damping", "damping", "damping", "'damping' stands outside of the groups"),
    ("&method", "&grid cell = 1 cells = 1, 1 /\n&method", "&grid cell", "&grid stands a second time"),
    ("  rate = 1e4\n/\n", "  rate = 1e4\n", "&damping", "&damping: its '/' is missing"),
    ("snapshot_interval = 1e-4\n/\n", "snapshot_interval = 1e-4\n", "&output", "its '/' is missing: the file ends before"),
    ("file = 'beam.h5'", "file = beam/beam.h5", "beam/beam.h5", "file = beam: must be in quotes"),
    ("  file = 'beam.h5'", "  5", "  5", "&output: '5' stands where a key is expected"),
    ("  end_time = 1.5e-3\n", "", "&run", "&run end_time: is missing"),
    ("  fix = 'y'\n", "", "&constraint", "&constraint fix: is missing: components that are held there, or moved; for example fix = 'y'"),
]

CONSISTENCY = [
    ("material = 'aluminium'", "material = 'aluminum'", "material =", "must be the name of a &material; did you mean 'aluminium'?"),
    ("lower = 0.0, 0.0\n  cell", "lower = 1e9, 0.0\n  cell", "lower", "must be within 1e9 cells of the origin"),
    (BODY, BODY.replace("0.1, 0.01", "0.1, 0.0"), "upper = 0.1, 0.0\n", "must be above lower = (0.0, 0.0) in every direction"),
    (BODY, BODY.replace("0.1, 0.01", "0.1, 0.02"), "upper = 0.1, 0.02", "must be within the grid, from (0.0, 0.0) to (0.1, 0.01125)"),
    (BODY, BODY.replace("0.0, 0.0", "-0.1, 0.0"), "lower = -0.1", "&body lower = -0.1, 0.0: must be within the grid"),
    (HELD, HELD.replace("0.1, 0.0", "0.04, 0.0"), "upper = 0.04", "must not be below lower = (0.05, 0.0)"),
    (HELD, HELD.replace("0.05, 0.0", "0.05, -1").replace("0.1, 0.0", "0.1, -1e-4"), "lower = 0.05, -1", "must hold at least one node"),
    (HELD, HELD.replace("0.05", "0.0506").replace("0.1,", "0.0508,"), "lower = 0.0506", "must hold at least one node"),
    (HELD, HELD.replace("0.05", "0.06"), "tip", "the nodes at the tip and one cell ahead must be held in y"),
    (HELD, HELD.replace("'y'", "'x'"), "tip", "must be held in y by a &constraint"),
    (HELD, HELD.replace("0.05", "0.04"), "tip", "the node one cell behind the tip must not be held in y"),
    (TRACTION, TRACTION.replace("0.0, 0.01", "0.01, 0.01"), "upper = 0.01, 0.01", "in exactly one direction: a traction acts on an edge"),
    (TRACTION, TRACTION.replace("0.0, 0.01", "0.0, 0.0"), "upper = 0.0, 0.0", "in exactly one direction: a traction acts on an edge"),
    (TRACTION, TRACTION.replace("0.0, 0.01", "0.0, 0.011"), "lower = 0.0, 0.0\n  upper = 0.0, 0.011", "must lie on one edge of a body"),
    (TRACTION, TRACTION.replace("= 0.0,", "= 0.02,"), "lower = 0.02", "must lie on one edge of a body"),
    (TRACTION, TRACTION.replace("0.0, 0.01", "0.0, -0.01"), "upper = 0.0, -0.01", "must not be below lower"),
    (TRACTION, TRACTION.replace("traction", "pressure"), "kind = 'pressure'", "&load kind = 'pressure' requires pressure"),
    (TRACTION, TRACTION.replace("traction", "gravity"), "kind = 'gravity'", "&load kind = 'gravity' requires acceleration"),
    (TRACTION, TRACTION + "  pressure = 1.0\n", "pressure = 1.0", "&load pressure = 1.0 requires kind = 'pressure'"),
    (TRACTION, TRACTION + "  acceleration = 0.0, 1.0\n", "acceleration =", "requires kind = 'gravity'"),
    (TRACTION, TRACTION + "  on = 'crack'\n", "on =", "&load on = 'crack' requires kind = 'pressure'"),
    (TRACTION, TRACTION + "  crack = 'a'\n", "crack =", "&load crack = 'a' requires kind = 'pressure' and on = 'crack'"),
    (BODY, BODY + "  eigenstrain = 1e-3, 1e-3, 1e-4\n", "eigenstrain =", "with a shear of the eigenstrain is not allowed with &crack kind = 'symmetry'"),
    (TRACTION, TRACTION.replace("traction", "point"), "upper = 0.0, 0.01", "must equal lower = (0.0, 0.0) for a point load"),
    (TRACTION, TRACTION.replace("traction", "body"), "lower = 0.0, 0.0\n  upper = 0.0, 0.01", "must contain material of a body"),
    (
        TRACTION,
        "  kind = 'point'\n  lower = 0.05, 0.0101\n  upper = 0.05, 0.0101\n",
        "lower = 0.05, 0.0101",
        "the point of a load must be in or on a body",
    ),
    ("history = 'step'", "history = 'ramp'", "history", "&load history = 'ramp' requires rise_time > 0"),
    ("history = 'step'", "history = 'smooth_ramp'", "history", "&load history = 'smooth_ramp' requires rise_time > 0"),
    ("history = 'step'", "history = 'sine'", "history", "&load history = 'sine' requires frequency > 0"),
    ("history = 'step'", "history = 'table'", "history", "&load history = 'table' requires times and factors"),
    ("history = 'step'", "history = 'table' times = 0, 1 factors = 1", "factors", "must have as many values as times, 2, not 1"),
    ("history = 'step'", "history = 'table' times = 0, 0 factors = 1, 2", "times", "must increase from value to value"),
    ("fix = 'y'", "fix = 'y' displacement = 1e-6, 0 history = 'ramp' rise_time = 1", "displacement",
     "must be 0 in the direction that fix does not name"),
    ("fix = 'y'", "fix = 'y' displacement = 0, 1e-6", "displacement", "with history = 'step' is not allowed with &method time = 'explicit' and &method start = 'undeformed': prescribed nodes would jump"),
    ("fix = 'y'", "fix = 'y' velocity = 0, 1 history = 'ramp'", "history = 'ramp'", "&constraint history = 'ramp' requires rise_time > 0"),
    ("fix = 'y'", "fix = 'y' name = 'a b'", "name", "must be of letters, digits and _, as names of columns are"),
    ("tip = 0.05, 0.0", "tip = 0.0501, 0.0", "tip", "must be a node of the grid"),
    ("tip = 0.05, 0.0", "tip = 0.0, 0.0", "tip", "one cell behind and one cell ahead must be in the grid"),
    ("tip = 0.05, 0.0", "tip = 0.05, 0.00125", "tip", "must be on an edge of a body"),
    ("direction = 1.0, 0.0", "direction = 1.0, 1.0", "direction", "must be along a grid line"),
    ("direction = 1.0, 0.0", "direction = 2*0.0", "direction", "must be along a grid line"),
    ("force = 0.0, 1.0", "force = 1.0, 0.0", "reference =", "'dcb' needs a &load with a force normal to the crack"),
    ("reference = 'dcb'", "reference = 'value'", "reference =", "&energy_release reference = 'value' requires reference_value > 0"),
    ("'musl'", "'musl'\n  mass = 'partial'", "&method", "consistent_upper = 0.0, 0.0 (default): must give with consistent_lower a box of at least"),
    (
        "'musl'",
        "'musl'\n  mass = 'partial'\n  consistent_region = 'refined'",
        "consistent_region",
        "consistent_region = 'refined' with mass = 'partial' requires &refine indicator = 'gradient' or 'zz' or 'tip'",
    ),
    ("'musl'", "'musl' consistent_region = 'refind'", "consistent_region", "must be 'box' or 'refined'; did you mean 'refined'?"),
    ("history_interval = 1e-6", "history_interval = 1", "history_interval", "must be in [0, end_time = 0.0015] [s]"),
    ("history_interval = 1e-6", "history_interval = 1e-60", "history_interval", "must be at least a 1e-8 part of end_time"),
    ("snapshot_interval = 1e-4", "snapshot_interval = 2e-3", "snapshot", "must be in [0, end_time = 0.0015] [s]"),
    ("file = 'beam.h5'", "file = ''", "file", "must be the name of a file, not empty and without folders"),
    ("file = 'beam.h5'", "file = '../beam.h5'", "file", "must be the name of a file, not empty and without folders"),
]

# The same in a scene whose cells refine.
REFINEMENT = [
    ("'gradient'", "'gradent'", "indicator", "&refine indicator = 'gradent': must be 'none', 'gradient', 'zz' or 'tip'; did you mean"),
    ("'gradient'", "gradient", "indicator", "indicator = gradient: must be in quotes: 'gradient'"),
    ("'energy_density'", "'energy'", "field", "must be 'energy_density', 'stress_norm' or 'speed'"),
    ("r_crit = 0.03", "r_crit = 0", "r_crit", "&refine r_crit = 0: must be in (0, inf)"),
    ("r_crit = 0.03", "rcrit = 0.03", "rcrit", "&refine has no key 'rcrit'; did you mean 'r_crit'?"),
    ("r_coarsen = 0.0", "r_coarsen = -0.01", "r_coarsen", "r_coarsen = -0.01: must be in [0, inf)"),
    ("r_coarsen = 0.0", "r_coarsen = 0.03", "r_coarsen", "r_coarsen = 0.03: must be below r_crit = 0.03"),
    ("r_coarsen = 0.0", "r_coarsen = 1", "r_coarsen", "r_coarsen = 1: must be below r_crit = 0.03"),
    ("tolerance = 0.02", "tolerance = 0", "tolerance", "tolerance = 0: must be in (0, 1)"),
    ("tolerance = 0.02", "tolerance = 1", "tolerance", "tolerance = 1: must be in (0, 1)"),
    ("rings = 4", "rings = 0", "rings", "rings = 0: must be an integer in [1, 1000]"),
    ("rings = 4", "rings = 1001", "rings", "rings = 1001: must be an integer in [1, 1000]"),
    ("rings = 4", "rings = 4.5", "rings", "rings = 4.5: must be an integer in [1, 1000] (it is no integer)"),
    ("max_level = 4", "max_level = -1", "max_level", "max_level = -1: must be an integer in [0, 20]"),
    ("max_level = 4", "max_level = 21", "max_level", "max_level = 21: must be an integer in [0, 20]"),
    ("energy_floor = 1e-3", "energy_floor = -1e-3", "energy_floor", "energy_floor = -1e-3: must be in [0, 1)"),
    ("energy_floor = 1e-3", "energy_floor = 1", "energy_floor", "energy_floor = 1: must be in [0, 1)"),
    ("interval = 10\n", "interval = 0\n", "interval = 0\n", "&refine interval = 0: must be an integer in [1, inf)"),
    ("max_particles = 1000000", "max_particles = 0", "max_particles", "max_particles = 0: must be an integer in [1, 2e9]"),
    ("max_particles = 1000000", "max_particles = 2000000001", "max_particles", "must be an integer in [1, 2e9]"),
    ("max_particles = 1000000", "max_particles = 2559", "max_particles", "initial number of material points, 2560"),
    ("region_lower = 0.04, 0.0", "region_lower = 0.04", "region_lower", "must have 2 values, or none, not 1"),
    ("region_upper = 0.06, 0.01", "region_upper = 3*0.1", "region_upper", "may have at most 2 values; each must be in (-inf, inf) [m]"),
    ("region_upper = 0.06, 0.01", "region_upper = 0.06", "region_upper", "must have 2 values, or none, not 1"),
    ("region_upper = 0.06, 0.01", "region_upper = 0.06, 0.0", "region_upper", "must be above region_lower = (0.04, 0.0) in every"),
    ("region_upper = 0.06, 0.01", "region_upper = 0.03, 0.01", "region_upper", "must be above region_lower = (0.04, 0.0) in every"),
    ("0.04, 0.0\n  region_upper = 0.06, 0.01", "0.1, 0.0", "region_lower", "must contain material of a body"),
    ("region_lower = 0.04, 0.0\n  region_upper = 0.06, 0.01", "region_upper = 0.1, -0.01", "region_upper", "must contain material"),
    ("0.0\n  region_upper = 0.06, 0.01", "-1\n  region_upper = 0.06, -0.5", "region_lower", "must contain material of a body"),
    ("  max_particles = 1000000\n/\n", "  max_particles = 1000000\n", "&refine", "&refine: its '/' is missing"),
    ("&refine", "&refien", "&refien", "there is no group &refien; did you mean 'refine'?"),
    ("1000000\n/", "1000000\n/\n&refine /", "&refine /", "&refine stands a second time"),
]


# The same in a scene whose crack is inside a body.
RADII, TIP = "radii = 4e-3, 6e-3, 8e-3", "tip = 0.05, 0.01"
WITHIN = "must be in [0.0025, 0.01] [m] around the tip (0.05, 0.01): two of the finest cells at least, and nothing within them but material"
CRACK_LINE = [
    ("'line'", "'lines'", "kind = 'lines'", "kind = 'lines': must be 'symmetry', 'line', 'path' or 'plane'; did you mean 'line'?"),
    (TIP, "tip = 0.0501, 0.01", "estimators", "is not allowed with tips at no nodes: virtual crack closure needs a tip at a node"),
    (TIP, "tip = 0.05, 0.0103", "estimators", "is not allowed with tips at no nodes: virtual crack closure needs a tip at a node"),
    (TIP, "tip = 0.05, 0.02", "tip", "must be inside the material, and on no other crack"),
    (TIP, "tip = 0.05, 0.0", "tip", "must be inside the material, and on no other crack"),
    (TIP, "tip = 0.1, 0.01", "tip", "must be inside the material, and on no other crack"),
    (TIP, "tip = 0.09875, 0.01", "radii", "there is no place for a radius around the tip (0.09875, 0.01): only material and the straight end of "
     "this crack are within 0.00125 m of it, and two of the finest cells, 0.0025 m, are the least; use smaller cells"),
    ("direction = 1.0, 0.0", "direction = 1.0, 1.0", "estimators", "is not allowed with tips at no nodes"),
    ("direction = 1.0, 0.0", "direction = 0.0, 0.0", "direction", "must not be 0, 0"),
    ("length = 0.0", "length = -0.01", "length", "&crack length = -0.01: must be in [0, inf) [m]"),
    ("length = 0.0", "length = 0.0101", "estimators", "is not allowed with tips at no nodes"),
    ("length = 0.0", "length = 1.25e-3", "radii", "there is no place for a radius around the tip (0.05, 0.01)"),
    ("length = 0.0", "length = 0.005", "radii", "radii = 4e-3, 6e-3, 8e-3: must be in [0.0025, 0.005] [m]"),
    (TIP, "tip = 0.05, 1.0", "tip", "must be inside the material, and on no other crack"),
    ("contact = 'none'", "contact = 'frictionles'", "contact", "must be 'none', 'frictionless' or 'friction'; did you mean 'frictionless'?"),
    (RADII, "radii = 4e-3, 12e-3", "radii", "radii = 4e-3, 12e-3: " + WITHIN),
    (RADII, "radii = 2e-3, 8e-3", "radii", "radii = 2e-3, 8e-3: " + WITHIN),
    (RADII, "radii = 8e-3, 6e-3", "radii", "radii = 8e-3, 6e-3: must increase from one to the next"),
    (RADII, "radii = 6e-3, 6e-3", "radii", "radii = 6e-3, 6e-3: must increase from one to the next"),
    (RADII, "radii = 0.0, 6e-3", "radii", "value 1 must be in (0, inf) [m]"),
    (RADII, "radii = 11*6e-3", "radii", "may have at most 10 values"),
]


@pytest.mark.parametrize(("old", "new", "fragment", "phrase"), VALUES + SYNTAX + CONSISTENCY)
def test_one_mistake_is_refused_with_its_line(hampm, tmp_path, old, new, fragment, phrase):
    text = changed((old, new))
    (tmp_path / "case.nml").write_text(text)
    line = line_of(text, new if fragment in new else fragment)
    if fragment in new:
        line += new[: new.index(fragment)].count("\n")
    assert_refused(hampm("case.nml"), 2, f"case.nml:{line}: ", phrase)


def test_groups_that_end_as_before_fortran_90_get_a_message_each(hampm, tmp_path):
    text = GOOD.replace("\n/\n", "\n&end\n")
    (tmp_path / "case.nml").write_text(text)
    result = hampm("case.nml")
    assert_refused(result, 2, "&run: a group ends with '/', not with '&end'")
    assert len(result.stderr.splitlines()) == text.count("&end")


def test_positions_are_shown_without_their_rounding(hampm, tmp_path):
    """0.1 + 2*0.1 is 0.30000000000000004 in binary."""
    text = changed(("lower = 0.0, 0.0\n  cell = 1.25e-3\n  cells = 80, 9", "lower = 0.1, 0.1\n  cell = 0.1\n  cells = 2, 2"))
    (tmp_path / "case.nml").write_text(text)
    result = hampm("case.nml")
    assert_refused(result, 2, "must be within the grid, from (0.1, 0.1) to (0.3, 0.3)")
    assert "0000000" not in result.stderr


def test_a_key_that_is_gone_is_to_be_left_out(hampm, tmp_path):
    text = changed(("'musl'", "'musl'\n  time_steps = 'local'"))
    (tmp_path / "case.nml").write_text(text)
    assert_refused(hampm("case.nml"), 2, f"case.nml:{line_of(text, 'time_steps')}: ", "&method has no key 'time_steps'; version 3 has none of it: leave it out")


PLASTIC = "law = 'j2_plastic'\n  yield_stress = 1e8"
VISCOUS = "law = 'viscoelastic'\n  moduli = 1e9\n  relaxation_times = 1.0"
ELASTIC = "law = 'linear_elastic'"
NO_CLOSURE = "estimators = 'vcct', 'stress_closure'", "estimators = 'vcct'"
AT_REST = ("courant = 0.1", "time = 'static'"), ("frame = 'updated'", "frame = 'total'"), NO_CLOSURE


@pytest.mark.parametrize(("law", "edits", "fragment", "phrase"), [
    ("law = 'j2_plastic'", [NO_CLOSURE], "law = 'j2_plastic'", "requires yield_stress > 0"),
    (ELASTIC + "\n  yield_stress = 1e8", [], "yield_stress = 1e8 ", "requires law = 'j2_plastic'"),
    (ELASTIC + "\n  hardening = 1e8", [], "hardening = 1e8 ", "requires law = 'j2_plastic'"),
    (PLASTIC + "\n  hardening = -1", [NO_CLOSURE], "hardening = -1: ", "must be in [0, inf) [Pa]"),
    (ELASTIC + "\n  moduli = 1e8", [], "moduli = 1e8 ", "requires law = 'viscoelastic'"),
    (PLASTIC + "\n  relaxation_times = 1", [NO_CLOSURE], "relaxation_times = 1 ", "requires law = 'viscoelastic'"),
    ("law = 'viscoelastic'", [NO_CLOSURE], "law = 'viscoelastic'", "requires moduli and relaxation_times"),
    (VISCOUS.replace("1e9", "1e9, 2e9"), [NO_CLOSURE], "relaxation_times = 1.0: ", "must be as many as moduli: 2"),
    (VISCOUS.replace("1e9", "3e10"), [NO_CLOSURE], "moduli = 3e10: ", "must have a sum of at most 2.6923076923076923e10 [Pa], the instantaneous shear modulus"),
    (ELASTIC.replace("linear_elastic", "neo_hookean") + "\n  volumetric = 'b_bar'", AT_REST, "volumetric = 'b_bar' ",
     "is not allowed with &method time = 'static' and law = 'neo_hookean'"),
    (PLASTIC, [], "&energy_release estimators", "'stress_closure' is not allowed with &material 'aluminium' law = 'j2_plastic'"),
])
def test_what_laws_that_remember_do_not_go_with(hampm, tmp_path, law, edits, fragment, phrase):
    text = changed((ELASTIC, law), *edits)
    (tmp_path / "case.nml").write_text(text)
    assert_refused(hampm("case.nml"), 2, fragment, phrase)


IMPLICIT = ("courant = 0.1", "time = 'implicit' time_step = 1e-6"), ("frame = 'updated'", "frame = 'total'")


@pytest.mark.parametrize(("old", "new", "fragment", "phrase"), [
    ("frame = 'total'", "frame = 'updated'", "frame", "&method frame = 'updated' is not allowed with time = 'implicit': "),
    ("frame = 'total'", "frame = 'total' mass = 'fmpm'", "mass", "&method mass = 'fmpm' is not allowed with time = 'implicit': fmpm is a series for the inverse"),
    ("frame = 'total'", "frame = 'total' courant = 4", "time_step = ", "&method time_step = 1e-6 is not allowed with time = 'implicit' and courant = 4"),
    ("fix = 'y'", "fix = 'y' displacement = 0, 1e-6", "displacement", "prescribed nodes would jump; use history = 'smooth_ramp', or a velocity"),
    ("time = 'implicit'", "time = 'explicit'", "time_step", "&method time_step = 1e-6 requires time = 'implicit': courant gives"),
    ("time = 'implicit' time_step = 1e-6", "hht_alpha = -0.1", "hht_alpha", "&method hht_alpha = -0.1 requires time = 'implicit'"),
])
def test_what_implicit_steps_do_not_go_with(hampm, tmp_path, old, new, fragment, phrase):
    text = changed((old, new), scene=changed(*IMPLICIT))
    (tmp_path / "case.nml").write_text(text)
    result = hampm("case.nml")
    assert_refused(result, 2, f"case.nml:{line_of(text, fragment)}: ", phrase)
    assert len(result.stderr.splitlines()) == 1


QUADRATIC = ("cells = 80, 9", "cells = 80, 9 order = 2"), ("points_per_cell = 2", "points_per_cell = 3"), *AT_REST[:2], ("'stress_closure'", "'domain_integral'")


@pytest.mark.parametrize(("old", "new", "phrase"), [
    ("order = 2", "order = 3", "&grid order = 3: must be an integer in [1, 2]"),
    ("frame = 'total'", "frame = 'updated' wave_speed = 'shear'", "&method frame = 'updated' is not allowed with &grid order = 2"),
    ("points_per_cell = 3", "points_per_cell = 2", "&body points_per_cell = 2 is not allowed with &grid order = 2: fewer than 3 leave"),
    ("lower = 0.0, 0.0\n  upper = 0.1, 0.01\n  points", "lower = 0.0, 0.0\n  upper = 0.1, 0.011\n  points", "must be nodes of the lattice with &grid order = 2: bodies are to fill their cells"),
    ("direction = 1.0, 0.0", "direction = 1.0, 0.0 contact = 'frictionless' /\n&refine indicator = 'zz'",
     "&crack contact = 'frictionless' requires kind = 'line' or 'path'"),
])
def test_what_quadratic_cells_do_not_go_with(hampm, tmp_path, old, new, phrase):
    text = changed((old, new), scene=changed(*QUADRATIC))
    (tmp_path / "case.nml").write_text(text)
    assert_refused(hampm("case.nml"), 2, phrase)


MEETING = re.sub(r"&(crack|energy_release).*?\n/\n", "", GOOD, flags=re.DOTALL) + "&contact bodies = 'frictionless' /\n"


@pytest.mark.parametrize(("old", "new", "fragment", "phrase"), [
    ("'frictionless'", "'sticky'", "&contact", "&contact bodies = 'sticky': must be 'bonded', 'stick', 'frictionless' or 'friction'; did you mean 'stick'?"),
    ("'frictionless'", "'friction'", "&contact", "&contact bodies = 'friction' requires friction > 0; use &contact bodies = 'frictionless'"),
    ("'frictionless'", "'stick' friction = 0.1", "&contact", "&contact friction = 0.1 requires bodies = 'friction'"),
    ("'frictionless'", "'friction' friction = -0.1", "&contact", "&contact friction = -0.1: must be in [0, inf)"),
    ("'frictionless'", "'stick' distance = 1e-3", "&contact", "&contact distance = 1e-3: must not be above half of a cell: bodies farther"),
    ("'frictionless'", "'bonded' distance = 1e-4", "&contact", "&contact distance = 1e-4 requires bodies = 'stick' or 'frictionless' or 'friction': bonded bodies interact"),
    ("frame = 'updated'", "frame = 'total'", "frame", "&method frame = 'total' is not allowed with &contact bodies = 'frictionless': bodies never come into contact"),
    ("courant = 0.1", "time = 'static'", "'static'", "&method time = 'static' is not allowed with &contact bodies = 'frictionless'"),
    ("courant = 0.1", "time = 'implicit'", "'implicit'", "&method time = 'implicit' is not allowed with &contact bodies = 'frictionless'"),
    ("&damping", "&refine indicator = 'gradient' /\n&damping", "&refine", "&refine indicator = 'gradient' is not allowed with &contact bodies = 'frictionless'"),
    ("'frictionless' /", "'stick' /\n&body material = 'aluminium' lower = 0.0, 0.0105 upper = 0.01, 0.011 /\n"
     "&crack kind = 'path' points = 0.0, 0.0107, 0.004, 0.0107 /", "&crack",
     "&crack points = 0.0, 0.0107, 0.004, 0.0107: must be in the first &body, or in one of its part, with &contact bodies: put the body"),
    ("'frictionless' /", "'bonded' /\n&body material = 'aluminium' lower = 0.0, 0.0105 upper = 0.01, 0.011 contact_group = 'a' /", "contact_group = 'a'",
     "&body(2) contact_group = 'a' requires &contact bodies = 'stick' or 'frictionless' or 'friction'"),
    ("'frictionless' /", "'stick' /\n" + "".join(f"&body material = 'aluminium' lower = {k}e-3, 0.0105 upper = {k + 0.5}e-3, 0.011 /\n"
                                                 for k in range(16)), "&contact", "must be 'bonded' where there are more than 16 bodies"),
])
def test_what_contact_between_bodies_does_not_go_with(hampm, tmp_path, old, new, fragment, phrase):
    assert MEETING.count(old) == 1
    text = MEETING.replace(old, new)
    (tmp_path / "case.nml").write_text(text)
    assert_refused(hampm("case.nml"), 2, f"case.nml:{line_of(text, fragment)}: ", phrase)


@pytest.mark.parametrize(("old", "new", "fragment", "phrase"), REFINEMENT)
def test_one_mistake_of_refinement_is_refused_alone_with_its_line(hampm, tmp_path, old, new, fragment, phrase):
    text = changed((old, new), scene=GOOD + REFINE)
    (tmp_path / "case.nml").write_text(text)
    result = hampm("case.nml")
    assert_refused(result, 2, f"case.nml:{line_of(text, fragment)}: ", phrase)
    assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize(("old", "new", "fragment", "phrase"), CRACK_LINE)
def test_one_mistake_of_a_crack_inside_a_body_is_refused_alone_with_its_line(hampm, tmp_path, old, new, fragment, phrase):
    text = changed((old, new), scene=LINE)
    (tmp_path / "case.nml").write_text(text)
    result = hampm("case.nml")
    assert_refused(result, 2, f"case.nml:{line_of(text, fragment)}: ", phrase)
    assert len(result.stderr.splitlines()) == 1


def test_what_only_a_crack_inside_a_body_has(hampm, tmp_path):
    new = "direction = 1.0, 0.0\n  length = 0.01\n  contact = 'frictionless'"
    (tmp_path / "case.nml").write_text(changed(("direction = 1.0, 0.0", new)))
    result = hampm("case.nml")
    assert_refused(result, 2, "&crack length = 0.01 requires kind = 'line'",
                   "&crack contact = 'frictionless' requires kind = 'line' or 'path' or 'plane': a symmetry plane has one face")
    assert len(result.stderr.splitlines()) == 2


def test_one_material_within_the_domain_integral(hampm, tmp_path):
    steel = "&material name = 'steel' young = 210e9 density = 7800 /\n"
    other = "&body material = 'steel' lower = 0.055, 0.0 upper = 0.1, 0.02 /\n"
    text = changed(("upper = 0.1, 0.02\n", "upper = 0.055, 0.02\n"), scene=LINE) + steel + other
    (tmp_path / "case.nml").write_text(text)
    assert_refused(hampm("case.nml"), 2, f"case.nml:{line_of(text, RADII)}: &energy_release {RADII}: there must be one material "
                   "within them, or layers along the crack, around the tip (0.05, 0.01); body 2 is of another one, or has another eigenstrain")


POINT_LOAD = "&load kind = 'point' lower = {0}, {1} upper = {0}, {1} force = 0.0, 1.0 /\n"
HOLDER = "&constraint lower = {}, 0.0 upper = {}, 0.02 fix = 'x' /\n"
SURROUNDINGS = {"load": (POINT_LOAD.format(0.055, 0.014), 6.403124237e-3), "constraint": (HOLDER.format(0.0563, 0.06), 6.3e-3)}


@pytest.mark.parametrize(("group", "most"), SURROUNDINGS.values(), ids=SURROUNDINGS)
def test_loads_and_constraints_stay_out_of_the_domains(hampm, tmp_path, group, most):
    (tmp_path / "case.nml").write_text(LINE + group)
    result = hampm("case.nml")
    assert_refused(result, 2, f"&energy_release {RADII}: must be in [0.0025, {most}] [m]",
                   "nothing within them but material and the straight end of this crack: no load but on its faces, and no constraint")
    assert len(result.stderr.splitlines()) == 1
    (tmp_path / "case.nml").write_text(changed((RADII, f"radii = 4e-3, {most}"), scene=LINE) + group)
    assert hampm("case.nml", "--check").returncode == 0


def test_a_box_around_nothing_but_the_nodes_of_the_symmetry_plane_may_be_in_the_domains(hampm, tmp_path):
    text = changed(("lower = 0.05, 0.0\n  upper = 0.1, 0.0\n", "lower = 0.0499, -1e-3\n  upper = 0.1, 1e-3\n"),
                   ("'stress_closure'", "'domain_integral'"))
    (tmp_path / "case.nml").write_text(text)
    assert hampm("case.nml", "--check").returncode == 0
    (tmp_path / "case.nml").write_text(changed(("fix = 'y'", "fix = 'xy'"), scene=text))
    assert_refused(hampm("case.nml"), 2, "there is no place for a radius")


def test_a_radius_has_two_of_the_finest_cells(hampm, tmp_path):
    refine = "&refine indicator = 'tip' max_level = 3 /\n"
    (tmp_path / "case.nml").write_text(changed((RADII, "radii = 3e-4, 8e-3"), scene=LINE) + refine)
    assert_refused(hampm("case.nml"), 2, "&energy_release radii = 3e-4, 8e-3: must be in [3.125e-4, 0.01] [m]")


def test_a_single_mistake_gives_a_single_line(hampm, tmp_path):
    (tmp_path / "case.nml").write_text(changed(("young = 70e9", "young = -70e9")))
    result = hampm("case.nml")
    assert result.stderr == "hampm: case.nml:15: &material young = -70e9: must be in (0, inf) [Pa]\n"


def test_all_mistakes_are_reported_at_once(hampm, tmp_path):
    text = changed(
        ("&method", "&methd"),
        ("young = 70e9", "young = -1"),
        ("cell = 1.25e-3", "cel = 1.25e-3"),
        ("  density = 2700\n/", "  density = 2700\n"),
        ("  end_time = 1.5e-3\n", ""),
        ("file = 'beam.h5'", "file = 'a/b'"),
    )
    (tmp_path / "case.nml").write_text(text)
    assert_refused(
        hampm("case.nml", "--set", "damping.rate=-1"),
        2,
        "there is no group &methd",
        "&material young = -1",
        "&grid has no key 'cel'; did you mean 'cell'?",
        "&grid cell: is missing",
        "&material: its '/' is missing",
        "&run end_time: is missing",
        "&output file = 'a/b'",
        "--set damping.rate=-1: &damping rate = -1: must be in [0, inf) [1/s]",
    )


def test_two_materials_of_one_name(hampm, tmp_path):
    material = "&material name = 'aluminium' young = 1 density = 1 /\n"
    (tmp_path / "case.nml").write_text(GOOD + material)
    assert_refused(hampm("case.nml"), 2, f"case.nml:{GOOD.count(chr(10)) + 1}: &material name", "must differ from the name")


def test_overlapping_bodies(hampm, tmp_path):
    body = "&body material = 'aluminium' lower = 0.09, 0.0 upper = 0.1, 0.01 /\n"
    (tmp_path / "case.nml").write_text(GOOD + body)
    assert_refused(hampm("case.nml"), 2, "the body must not overlap body 1", "reference = 'dcb' is not allowed with several bodies")


def test_too_many_particles(hampm, tmp_path):
    text = changed(
        ("cell = 1.25e-3", "cell = 1e-5"), ("cells = 80, 9", "cells = 10000, 1000"), ("points_per_cell = 2", "points_per_cell = 16")
    )
    (tmp_path / "case.nml").write_text(text)
    assert_refused(hampm("case.nml"), 2, "points_per_cell = 16: there would be", "must be in [1, 2e9]")


def test_estimators_and_the_dcb_need_a_crack(hampm, tmp_path):
    start = GOOD.index("&crack")
    (tmp_path / "case.nml").write_text(GOOD[:start] + GOOD[GOOD.index("&energy_release") :])
    assert_refused(hampm("case.nml"), 2, "&energy_release estimators = 'stress_closure' requires &crack", "&energy_release reference = 'dcb' requires &crack")


def test_refinement_by_the_distance_to_the_tip_needs_a_crack(hampm, tmp_path):
    text = GOOD[: GOOD.index("&crack")] + REFINE.replace("gradient", "tip")
    (tmp_path / "case.nml").write_text(text)
    line = line_of(text, "indicator = 'tip'")
    assert_refused(hampm("case.nml"), 2, f"case.nml:{line}: &refine indicator = 'tip' requires &crack")


def test_a_mass_matrix_that_is_full_where_cells_refine_needs_cells_that_do(hampm, tmp_path):
    method = ("'musl'", "'musl'\n  mass = 'partial'\n  consistent_region = 'refined'")
    text = changed(method, ("'gradient'", "'none'"), scene=GOOD + REFINE)
    (tmp_path / "case.nml").write_text(text)
    line = line_of(text, "consistent_region")
    assert_refused(hampm("case.nml"), 2, f"case.nml:{line}: &method consistent_region = 'refined' with mass = 'partial' requires &refine indicator")


def test_mistakes_of_other_groups_do_not_spread_to_refinement(hampm, tmp_path):
    """What the region and the number of points are checked against is unknown here."""
    text = changed(("upper = 0.1, 0.01", "upper = 0.1"), ("points_per_cell = 2", "points_per_cell = 0"), scene=GOOD + REFINE)
    (tmp_path / "case.nml").write_text(text)
    result = hampm("case.nml")
    assert_refused(result, 2, "&body upper = 0.1: must have 2 values", "&body points_per_cell = 0: must be an integer in [1, 16]")
    assert "&refine" not in result.stderr


def test_a_wrong_indicator_is_one_mistake(hampm, tmp_path):
    """A mass matrix that is consistent where cells refine does not count it as no indicator."""
    method = ("'musl'", "'musl' mass = 'partial' consistent_region = 'refined'")
    (tmp_path / "case.nml").write_text(changed(method, ("'gradient'", "'gradent'"), scene=GOOD + REFINE))
    result = hampm("case.nml")
    assert_refused(result, 2, "&refine indicator = 'gradent'")
    assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize("group", ["run", "grid", "material", "body"])
def test_a_required_group_is_missing(hampm, tmp_path, group):
    start = GOOD.index(f"&{group}")
    end = GOOD.index("/\n", start) + 2
    (tmp_path / "case.nml").write_text(GOOD[:start] + GOOD[end:])
    assert_refused(hampm("case.nml"), 2, f"case.nml: the group &{group} is missing")


@pytest.mark.parametrize("content", [b"", b"\n\n\n", b"! nothing\n", b"\xef\xbb\xbf", b"\r\n"])
def test_an_empty_file(hampm, tmp_path, content):
    (tmp_path / "case.nml").write_bytes(content)
    assert_refused(hampm("case.nml"), 2, "&run is missing", "&grid is missing", "&material is missing", "&body is missing")


@pytest.mark.parametrize(
    "content",
    [bytes(range(1, 256)) * 50, b"&" * 5000, b"'" * 5001, b"x" * 3_000_000, b"&run title = " + b"x" * 3_000_000, b"=/,!&" * 1000],
    ids=["all bytes", "ampersands", "quotes", "a huge word", "a huge value", "punctuation"],
)
def test_a_file_that_is_no_namelist(hampm, tmp_path, content):
    (tmp_path / "case.nml").write_bytes(content)
    result = hampm("case.nml")
    assert_refused(result, 2, "case.nml:1: ")
    assert len(result.stderr.splitlines()) <= 51


def test_a_binary_file(hampm, tmp_path):
    (tmp_path / "case.nml").write_bytes(os.urandom(1000) + b"\0" + os.urandom(1000))
    assert_refused(hampm("case.nml"), 2, "case.nml: is no text file")


@pytest.mark.parametrize(("group", "name", "key"), [
    ("material", "E", "young"), ("material", "nu", "poisson"), ("material", "rho", "density"), ("run", "t", "thickness"), ("grid", "dx", "cell"),
    ("method", "dt", "time_step"), ("growth", "G_c", "toughness")])
def test_names_that_others_give_lead_to_the_key(hampm, tmp_path, group, name, key):
    (tmp_path / "case.nml").write_text(f"&{group} {name} = 1.0 /\n")
    assert f"hampm: case.nml:1: &{group} has no key '{name.lower()}'; it is '{key}' here\n" in hampm("case.nml").stderr


@pytest.mark.parametrize("text", [(ROOT / "README.md").read_text(), (ROOT / "src/program.f90").read_text(), "runs:\n  - a: 1\n  - b & c: 2\n",
                                  "time,G\n0.0,1.0\n", "{'run': {'end_time': 1}}"])
def test_a_file_that_is_no_namelist_gets_one_line(hampm, tmp_path, text):
    (tmp_path / "case.nml").write_text(text)
    line = 1 + next(k for k, words in enumerate(text.splitlines()) if words and not words.startswith("!"))
    assert_refused(hampm("case.nml"), 2, f"case.nml:{line}: is no namelist file: it begins with '")
    assert hampm("case.nml").stderr.count("\n") == 1


def test_a_line_before_the_groups_is_one_error_among_others(hampm, tmp_path):
    (tmp_path / "case.nml").write_text("My model\n" + GOOD.replace("young = 70e9", "young = -70e9"))
    said = hampm("case.nml").stderr.splitlines()
    assert len(said) == 2
    assert said[0].startswith("hampm: case.nml:1: 'My model' stands outside of the groups")
    assert "young = -70e9" in said[1]


def test_a_result_in_the_place_of_a_namelist(hampm, tmp_path):
    with h5py.File(tmp_path / "case.h5", "w"):
        pass
    assert_refused(hampm("case.h5"), 2, "case.h5: is a file of HDF5, no namelist: a result keeps its model as the text /input/namelist, ")


def test_a_file_that_is_missing(hampm):
    assert_refused(hampm("nowhere.nml"), 4, "nowhere.nml: cannot be read", "No such file")


def test_a_folder_as_file(hampm, tmp_path):
    (tmp_path / "case.nml").mkdir()
    assert_refused(hampm("case.nml"), 4, "case.nml: cannot be read", "directory")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read every file")
def test_a_file_that_must_not_be_read(hampm, tmp_path):
    (tmp_path / "case.nml").write_text(GOOD)
    (tmp_path / "case.nml").chmod(0)
    assert_refused(hampm("case.nml"), 4, "case.nml: cannot be read")


COMMAND_LINES = [
    ([], "which namelist file?"),
    (["--check"], "which namelist file?"),
    (["--chek", "case.nml"], "there is no option --chek; did you mean '--check'?"),
    (["-x", "case.nml"], "there is no option -x"),
    (["case.nml", "--set"], "--set: its value is missing"),
    (["case.nml", "--set="], "--set: its value is missing"),
    (["--output", "--check", "case.nml"], "--output: its value is missing: --output DIR"),
    (["--check=yes", "case.nml"], "--check takes no value"),
    (["--threads", "1025", "case.nml"], "--threads 1025: must be an integer in [0, 1024]"),
    (["--threads", "-1", "case.nml"], "--threads -1: must be an integer in [0, 1024]"),
    (["--threads=two", "case.nml"], "--threads two: must be an integer in [0, 1024]"),
    (["--threads=99999999999", "case.nml"], "must be an integer in [0, 1024]"),
    (["case.nml", "other.nml"], "one namelist file at a time: 'case.nml' and then 'other.nml'"),
    ([""], "an argument is empty"),
    (["case.nml", "--set", "young=1"], "--set young=1: must have the form group.key=value"),
    (["case.nml", "--set", "material.young"], "--set material.young: must have the form group.key=value"),
    (["case.nml", "--set", "materal.young=1"], "there is no group &materal; did you mean 'material'?"),
    (["case.nml", "--set", "material.yung=1"], "&material has no key 'yung'; did you mean 'young'?"),
    (["case.nml", "--set", "material.young=-1"], "--set material.young=-1: &material young = -1: must be in (0, inf) [Pa]"),
    (["case.nml", "--set", "material.young="], "law = 'linear_elastic' requires young"),
    (["case.nml", "--set", "material.young=1/2"], "'/2' is no value"),
    (["case.nml", "--set", "material.young=1 poisson=2"], "'poisson=2' is no value"),
    (["case.nml", "--set", "material(2).young=1"], "there is no &material(2), the number of &material is 1"),
    (["case.nml", "--set", "material(0).young=1"], "the number of a group must be an integer in [1, inf)"),
    (["case.nml", "--set", "material(x.young=1"], "the number of a group must be an integer in [1, inf)"),
    (["case.nml", "--set", "material().young=1"], "the number of a group must be an integer in [1, inf)"),
    (["case.nml", "--set", "run(2).title=a"], "there is no &run(2)"),
    (["case.nml", "--set", "method.scheme=mulsl"], "did you mean 'musl'?"),
    (["case.nml", "--set", "run.title='a"], "the closing ' of 'a is missing"),
]


@pytest.mark.parametrize(("arguments", "phrase"), COMMAND_LINES)
def test_a_wrong_command_line(hampm, tmp_path, arguments, phrase):
    (tmp_path / "case.nml").write_text(GOOD)
    assert_refused(hampm(*arguments), 2, phrase)


def test_all_mistakes_of_a_command_line_are_reported_at_once(hampm):
    assert_refused(hampm("--chek", "--threads", "0.5", "--output"), 2, "--chek", "--threads 0.5", "--output: its value is missing")


def test_one_of_several_groups_must_be_chosen(hampm, tmp_path):
    (tmp_path / "case.nml").write_text(GOOD + "&constraint lower = 0, 0.01 upper = 0, 0.01 fix = 'x' /\n")
    assert_refused(hampm("case.nml", "--set", "constraint.fix=x"), 2, "there are 2 of &constraint: say which, for example constraint(2)")
