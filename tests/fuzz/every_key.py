"""Every key acts: small scenes over all features, and in each of them every key of the program, one after the other, set to other values than it has.

With each of these the scene is refused, or some byte of the results is another (history, snapshots, the files that are written), or the run and `--check`
say by the key's name that it has no effect there. And each key acts in one scene at least.

    .venv/bin/python tests/fuzz/every_key.py --program build/checked/hampm [--scenes N,N] [--keys GROUP.KEY,...]

A line for each scene and key that is silent; exit code 1 where there is one.
"""

import argparse
import hashlib
import re
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from pathlib import Path

import h5py
import numpy as np
from runs import PROGRAM

LONGEST = 60    # that a run may take, in the checked build on a busy machine [s]
# Limits, which do nothing where they are not reached, and the mass of what is at rest
IDLE = "material.density", "run.stop_when", "run.stop_length", "run.stop_load", "run.stop_rest", "nucleation.strength", "nucleation.increment", "accuracy.must", \
    "accuracy.quantity", "accuracy.error"   # the same mesh may be the best for another error
OPEN = "refused", "acts", "failed", "said", "stands for what it was"
STEPS = 2000   # that a run may take: what is at rest takes many more where it is to move
STEEL = "young = 200e9  poisson = 0.3  density = 8000"
EVERY = "&output file = 'case.h5'  history_interval = {0}  snapshot_interval = {0} /\n"


def plate(law=STEEL, order=1, end="1.0", shape="lower = -10e-3, -10e-3  upper = 10e-3, 10e-3", points=2, run="", more="", cell="2e-3  cells = 10, 12"):
    """A plate of 20 by 20 mm in cells of 2 mm or others, with a free row of cells above and below."""
    return f"""&run end_time = {end}  thickness = 0.01  {run} /
&grid lower = -10e-3, -12e-3  cell = {cell}  order = {order} /
&material name = 'a'  {law} /
&body material = 'a'  {shape}  points_per_cell = {points} {more} /
"""


HELD = "&constraint lower = -10e-3, -10e-3  upper = 10e-3, -10e-3  fix = 'xy'  name = 'foot' /\n"
PULL = "&load kind = 'traction'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  force = 20e3, 100e3  {} /\n"
PRESS = "&load kind = 'pressure'  lower = -10e-3, 10e-3  upper = 10e-3, 10e-3  pressure = 100e6  {} /\n"
PATH = "&crack kind = 'path'  name = 'p'  points = -4.3e-3, -1.1e-3, 4.1e-3, 1.3e-3  {} /\n"
SHORT = "&crack kind = 'path'  name = 'p'  points = -2.1e-3, -0.6e-3, 2.2e-3, 0.5e-3 /\n"
STATIC = "&method time = 'static' {} /\n&output file = 'case.h5'  snapshot_interval = 0.5 /\n"
J = "&energy_release estimators = 'domain_integral' {} /\n"
TWO = """&run end_time = 0.4 /
&grid cell = 0.1  cells = 16, 10 /
&material name = 'm'  law = 'neo_hookean'  young = 1000  poisson = 0.3  density = 1000 /
&material name = 'n'  law = 'linear_elastic'  young = 4000  poisson = 0.2  density = 2000 /
&body material = 'm'  lower = 0.3, 0.3  upper = 0.7, 0.7  velocity = 0.3, 0.0 {} /
&body material = 'n'  lower = 0.8, 0.4  upper = 1.2, 0.9 {} /
&output file = 'case.h5'  history_interval = 0.02  snapshot_interval = 0.1 /
"""
BEAM = """&run end_time = {0}  thickness = 0.01 /
&grid cell = 5e-3  cells = 20, 3 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  lower = 0.0, 0.0  upper = 0.1, 0.01 /
&constraint lower = 0.05, 0.0  upper = 0.1, 0.0  fix = 'y'  name = 'plane' /
&crack tip = 0.05, 0.0 /
"""
END_FORCE = "&load kind = 'traction'  lower = 0.0, 0.0  upper = 0.0, 0.01  force = 0.0, 100.0 {} /\n"
ALL_ENERGIES = "&energy_release estimators = 'vcct', 'stress_closure', 'domain_integral'  energy_balance = .true. {} /\n"
LINE = """&crack kind = 'line'  tip = 2e-3, 0.0  {} /
"""

PROBES = """&probe name = 'a'  quantity = 'displacement', 'stress'  at = 5.1e-3, 4.3e-3 /
&probe name = 'b'  quantity = 'strain'  at = 5.1e-3, 4.3e-3, 7.2e-3, 6.1e-3 /
&probe name = 'c'  quantity = 'opening'  of = 'p'  distance = 2.1e-3  tip = 'last' /
&probe name = 'd'  quantity = 'displacement'  at = -0.1e-3, 0.1e-3  face = 'left' /
&probe name = 'e'  quantity = 'load_line'  of = 'top' /
"""

SCENES = {
    "probes": plate() + HELD + PULL.format("name = 'top'") + PATH.format("") + PROBES + STATIC.format(""),
    "beam in motion": BEAM.format("3e-5") + END_FORCE.format("") + ALL_ENERGIES.format("") + EVERY.format("1e-5"),
    "beam, updated, ramp, consistent mass in a box": BEAM.format("2e-5") + END_FORCE.format("history = 'ramp' rise_time = 1e-5") + ALL_ENERGIES.format("reference = 'dcb'")
    + "&method frame = 'updated' mass = 'partial' consistent_lower = 0.03, 0.0 consistent_upper = 0.06, 0.01 /\n&damping rate = 1e4 /\n" + EVERY.format("1e-5"),
    "beam at rest, refined at the tip": BEAM.format("1.0") + END_FORCE.format("") + J.format("reference = 'value' reference_value = 1.0")
    + "&refine indicator = 'tip' max_level = 2 rings = 3 /\n" + STATIC.format(""),
    "beam, table of a load": BEAM.format("2e-5") + END_FORCE.format("history = 'table' times = 0.0, 1e-5 factors = 0.0, 1.0") + J.format("")
    + "&refine indicator = 'tip' max_level = 2 rings = 3 /\n" + EVERY.format("1e-5"),
    "beam that grows at a speed": BEAM.format("2e-5") + END_FORCE.format("") + J.format("")
    + "&growth law = 'prescribed' direction = 'straight' speed = 800 /\n" + EVERY.format("2e-6"),
    "gradient refinement": plate(end="4e-6") + HELD + PULL.format("") + LINE.format("") + J.format("")
    + "&refine indicator = 'gradient' max_level = 1 r_crit = 0.05 interval = 5 region_lower = -6e-3, -6e-3 region_upper = 6e-3, 6e-3 /\n" + EVERY.format("1e-6"),
    "zz refinement in motion": plate(end="4e-6") + HELD + PULL.format("history = 'sine' frequency = 1e5") + PATH.format("") + J.format("")
    + "&refine indicator = 'zz' max_level = 1 tolerance = 0.1 interval = 5 /\n" + EVERY.format("1e-6"),
    "zz refinement at rest": plate() + HELD + PULL.format("") + PATH.format("contact = 'frictionless'") + J.format("")
    + "&refine indicator = 'zz' max_level = 1 tolerance = 0.1 /\n" + STATIC.format(""),
    "line with contact": plate(end="4e-6") + HELD + PRESS.format("") + LINE.format("contact = 'frictionless'")
    + "&load kind = 'point' lower = -4e-3, 0.0 upper = -4e-3, 0.0 face = 'left' force = 0.0, 1e3 /\n" + J.format("") + EVERY.format("1e-6"),
    "line with two tips at rest": plate() + HELD + PULL.format("") + LINE.format("length = 8e-3") + "&energy_release estimators = 'vcct', 'domain_integral' /\n"
    + STATIC.format(""),
    "friction at rest": plate() + HELD + PRESS.format("history = 'ramp' rise_time = 0.9") + PATH.format("contact = 'friction' friction = 0.05") + J.format("") + STATIC.format("load_steps = 2"),
    "friction in motion": plate(end="4e-6") + HELD + PRESS.format("") + PATH.format("contact = 'friction' friction = 0.05") + J.format("radii = 4e-3, 5e-3")
    + EVERY.format("1e-6"),
    "pressed path": plate() + HELD + "&load kind = 'pressure' on = 'crack' crack = 'p' pressure = 1e6 /\n" + PATH.format("") + J.format("") + STATIC.format("solver = 'direct'"),
    "closure of a path": plate(shape="lower = -10e-3, -10e-3  upper = 10e-3, 10e-3") + HELD + PULL.format("") + PATH.format("")
    + "&energy_release estimators = 'domain_integral', 'material_force' radii = 4e-3 /\n&refine indicator = 'tip' max_level = 1 rings = 4 /\n" + STATIC.format(""),
    "a crack between two materials": plate(cell="1e-3  cells = 20, 24", shape="lower = -10e-3, 0.0  upper = 10e-3, 10e-3")
    + "&material name = 'n' young = 20e9 poisson = 0.3 density = 1200 /\n&body material = 'n' lower = -10e-3, -10e-3 upper = 10e-3, 0.0 points_per_cell = 2 /\n"
    + HELD + PULL.format("") + "&crack kind = 'path' name = 'p' points = -5e-3, 0.0, 5e-3, 0.0 /\n" + J.format("radii = 4e-3 phase_length = 1e-3") + STATIC.format(""),
    "growth at rest": plate(cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT
    + "&load kind = 'point' lower = 10e-3, 0.0 upper = 10e-3, 0.0 force = 10.0, 5.0 held = .true. /\n"
    + "&constraint lower = -10e-3, 4e-3 upper = -10e-3, 6e-3 fix = 'x' displacement = 1e-8, 0.0 held = .true. /\n"
    + J.format("radii = 2e-3") + "&growth crack = 'p' toughness = 100 increment = 2.2e-3 max_length = 25e-3 tips = 'largest' /\n" + STATIC.format("load_steps = 2"),
    "growth by heat": plate(cell="1e-3  cells = 20, 24", more="eigenstrain = 1e-3, 2e-3, 0.0 held = .false.") + HELD + PULL.format("held = .true.") + SHORT + J.format("radii = 2e-3")
    + "&growth crack = 'p' toughness = 1e4 increment = 2.2e-3 direction = 'straight' /\n" + STATIC.format("load_steps = 2"),
    "a crack that appears": plate(cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT
    + "&nucleation crack = 'p' toughness = 1.0 strength = 1e5 increment = 1e-3 /\n" + STATIC.format("load_steps = 2"),
    "growth by heat and a load": plate(cell="1e-3  cells = 20, 24", more="eigenstrain = 1e-5, 2e-5, 0.0 held = .false.") + HELD + PULL.format("") + SHORT + J.format("radii = 2e-3")
    + "&growth crack = 'p' toughness = 1.0 increment = 2.2e-3 direction = 'straight' /\n" + STATIC.format(""),
    "a load by which no crack grows": plate(cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT + J.format("radii = 2e-3")
    + "&growth crack = 'p' toughness = 1e8 increment = 2.2e-3 direction = 'straight' /\n&control quantity = 'load' /\n" + STATIC.format(""),
    "a crack that appears by its strength": plate(cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT
    + "&nucleation crack = 'p' toughness = 1.0 strength = 1e9 increment = 1e-3 /\n" + STATIC.format("load_steps = 2"),
    "growth up to a length": plate(cell="1e-3  cells = 20, 24", run="stop_when = 'crack_length', 'load_dropped' stop_length = 8e-3 stop_load = 0.6") + HELD + PULL.format("") + SHORT
    + J.format("radii = 2e-3") + "&growth crack = 'p' toughness = 1.0 increment = 2.2e-3 direction = 'straight' /\n&control quantity = 'growth' /\n" + STATIC.format("load_steps = 4"),
    "growth until the load drops": plate(cell="1e-3  cells = 20, 24", run="stop_when = 'load_dropped' stop_load = 0.9") + HELD + PULL.format("") + SHORT
    + J.format("radii = 2e-3") + "&growth crack = 'p' toughness = 1.0 increment = 2.2e-3 direction = 'straight' /\n" + STATIC.format("load_steps = 4"),
    "growth until it has arrested": plate(end="8e-6", cell="1e-3  cells = 20, 24", run="stop_when = 'arrested' stop_rest = 2e-6") + HELD + PULL.format("") + SHORT + J.format("")
    + "&growth law = 'prescribed' direction = 'straight' speed = 600 start = 1e-6 end = 2e-6 /\n" + EVERY.format("5e-7"),
    "graded in motion": plate(end="4e-6", more="eigenstrain = 1e-4, 2e-4, 0.0 profile_direction = 0.6, 0.8 profile_at = -5e-3, 6e-3 profile_stiffness = 1.0, 2.0 profile_density = 1.0, 1.5 "
                                               "profile_eigenstrain = 0.5, 1.0") + HELD + PULL.format("") + EVERY.format("1e-6"),
    "growth in a load frame": plate(cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT + J.format("radii = 2e-3")
    + "&growth crack = 'p' toughness = 1.0 increment = 2.2e-3 direction = 'straight' /\n&control quantity = 'displacement' displacement = 1e-6 stiffness = 1e9 "
    + "history = 'ramp' rise_time = 1.0 /\n" + STATIC.format("load_steps = 2"),
    "growth, unloaded": plate(cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT + J.format("radii = 2e-3")
    + "&growth crack = 'p' toughness = 1.0 increment = 2.2e-3 direction = 'straight' /\n&control quantity = 'displacement' displacement = 1e-6 "
    + "history = 'table' times = 0.0, 0.6, 1.0 factors = 0.0, 1.0, 0.5 /\n" + STATIC.format("load_steps = 3"),
    "growth in cycles": plate(cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT + J.format("radii = 2e-3")
    + "&growth crack = 'p' toughness = 1.0 increment = 2.2e-3 direction = 'straight' /\n&control quantity = 'displacement' displacement = 1e-6 "
    + "history = 'sine' frequency = 0.4 /\n" + STATIC.format("load_steps = 3"),
    "growth by fatigue": plate(cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT + J.format("radii = 2e-3")
    + "&growth crack = 'p' law = 'fatigue' rate = 'walker' walker_exponent = 0.6 rate_constant = 2e-28 rate_exponent = 3.0 wheeler_exponent = 1.3 wheeler_stress = 1e9 increment = 2.2e-3 "
    + "direction = 'straight' /\n&cycles blocks = 20, 10, 50 factors = 1.0, 1.3, 0.9 ratios = 0.1, 0.0, 0.3 /\n" + STATIC.format("load_steps = 2"),
    "growth by fatigue to fracture": plate(cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT + J.format("radii = 2e-3")
    + "&growth crack = 'p' law = 'fatigue' rate = 'forman' toughness = 4e4 threshold = 1e4 rate_constant = 1e-20 rate_exponent = 3.0 increment = 2.2e-3 direction = 'straight' /\n"
    + "&cycles ratio = 0.2 /\n" + STATIC.format("load_steps = 2"),
    "growth by toughness": plate(end="8e-6", cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT + J.format("")
    + "&growth crack = 'p' law = 'toughness' toughness = 0.1 limit_speed = 1500 exponent = 2 /\n" + EVERY.format("1e-6"),
    "growth along points": plate(end="8e-6", cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + SHORT + J.format("")
    + "&growth law = 'prescribed' direction = 'path' points = 4e-3, 1e-3, 9e-3, 2e-3 tips = 'last' speed = 600 start = 1e-6 end = 6e-6 /\n" + EVERY.format("1e-6"),
    "cohesion at rest": plate(cell="1e-3  cells = 20, 24") + HELD + PULL.format("") + PATH.format("") + J.format("radii = 2e-3")
    + "&cohesive crack = 'p' from = 3e-3 law = 'bilinear' strength = 400e6 toughness = 5e4 opening = 1e-6 strength_shear = 500e6 toughness_shear = 1e5 mixed_mode = 'power' exponent = 1.5 /\n"
    + STATIC.format("load_steps = 2"),
    "cohesion by a table": plate(end="1e-5") + HELD + PULL.format("") + PATH.format("")
    + "&cohesive crack = 'p' law = 'table' openings = 0.0, 1e-6, 1e-5 tractions = 200e6, 100e6, 0.0 /\n" + EVERY.format("1e-6"),
    "implicit": plate(end="1e-5") + HELD + PULL.format("history = 'ramp' rise_time = 5e-6") + PATH.format("") + J.format("")
    + "&method time = 'implicit' time_step = 5e-7 hht_alpha = -0.1 /\n&damping rate = 1e4 /\n" + EVERY.format("2e-6"),
    "by modes": plate(end="1e-5", more="velocity = 0.1, 0.2") + HELD + PULL.format("history = 'ramp' rise_time = 5e-6") + PATH.format("").replace("contact = 'frictionless'", "") + J.format("")
    + "&method time = 'modal' modes = 30 mass = 'weighted' /\n&damping rate = 1e4 /\n" + EVERY.format("2e-6"),
    "moved by modes": plate(end="1e-5") + HELD + "&constraint lower = -10e-3, 10e-3 upper = 10e-3, 10e-3 fix = 'xy' displacement = 1e-8, 2e-8 velocity = 0.0, 0.1 "
    "history = 'smooth_ramp' rise_time = 5e-6 /\n" + PATH.format("").replace("contact = 'frictionless'", "") + J.format("")
    + "&method time = 'modal' modes = 30 mass = 'consistent' /\n&damping rate = 1e4 /\n" + EVERY.format("2e-6"),
    "yields": plate(law="law = 'j2_plastic' yield_stress = 200e6 hardening = 1e9 volumetric = 'b_bar' " + STEEL, run="plane = 'strain'") + HELD + PULL.format("")
    + STATIC.format("load_steps = 4"),
    "yields in motion": plate(law="law = 'j2_plastic' yield_stress = 200e6 " + STEEL, end="8e-6", run="plane = 'strain'") + HELD + PULL.format("") + PATH.format("") + J.format("")
    + EVERY.format("2e-6"),
    "yields in all ways": plate(law="law = 'j2_plastic' yield_stress = 200e6 saturation = 100e6 saturation_strain = 1e-3 kinematic_hardening = 5e9 " + STEEL) + HELD + PULL.format("")
    + STATIC.format("load_steps = 4"),
    "rubber of two moduli": plate(law="law = 'mooney_rivlin' c01 = 1e10 " + STEEL) + HELD + PULL.format("") + STATIC.format(""),
    "creeps": plate(law="law = 'viscoelastic' moduli = 10e9, 20e9 relaxation_times = 0.1, 1.0 " + STEEL) + HELD + PULL.format("") + STATIC.format("load_steps = 4"),
    "layers of fibres": plate(law="law = 'orthotropic' density = 1600 young_1 = 140e9 young_2 = 10e9 shear_12 = 5e9 poisson_12 = 0.3 angle = 30") + HELD
    + PULL.format("") + PATH.format("") + J.format("") + STATIC.format(""),
    "fibres in plane strain": plate(law="law = 'orthotropic' density = 1600 young_1 = 140e9 young_2 = 10e9 young_3 = 12e9 shear_12 = 5e9 poisson_12 = 0.3 "
                                    "poisson_13 = 0.2 poisson_23 = 0.4", run="plane = 'strain'", end="4e-6") + HELD + PULL.format("") + EVERY.format("1e-6"),
    "around an axis": "&run end_time = 1.0  plane = 'axisymmetric' /\n&grid lower = 0.0, -12e-3  cell = 2e-3  cells = 6, 12 /\n&material name = 'a'  " + STEEL
    + " /\n&body material = 'a'  lower = 0.0, -10e-3  upper = 10e-3, 10e-3  eigenstrain = 1e-3, 0.0, 0.0, 2e-3 /\n&load kind = 'pressure'  lower = 0.0, 10e-3  upper = 10e-3, 10e-3  pressure = 100e6 /\n"
    + "&constraint lower = 0.0, -10e-3  upper = 10e-3, -10e-3  fix = 'y'  name = 'foot' /\n" + "&crack kind = 'path'  points = 0.0, 1.1e-3, 4.1e-3, 1.1e-3  contact = 'frictionless' /\n" + J.format("") + STATIC.format(""),
    "heat": plate(run="plane = 'strain'", more="eigenstrain = 1e-3, 1e-3, 0.0, 1e-3") + HELD + PATH.format("") + J.format("") + STATIC.format(""),
    "quadratic at rest": plate(order=2, points=3, shape="shape = 'circle' center = 0.0, 0.0 radius = 9e-3")
    + "&body hole = .true. shape = 'polygon' points = -2e-3, -2e-3, 3e-3, -2e-3, 0.0, 3e-3 /\n"
    + "&constraint lower = -10e-3, -12e-3 upper = 10e-3, -5e-3 fix = 'xy' /\n&load kind = 'gravity' acceleration = 0.0, 1e4 /\n" + STATIC.format(""),
    "quadratic with a path": plate(order=2, points=3) + HELD + PULL.format("") + PATH.format("") + J.format("") + "&refine indicator = 'tip' max_level = 1 rings = 3 /\n"
    + STATIC.format(""),
    "quadratic in motion": plate(order=2, points=3, end="2e-6") + HELD + PULL.format("") + PATH.format("") + J.format("") + "&method mass = 'consistent' /\n" + EVERY.format("1e-6"),
    "pushes only": plate() + "&constraint lower = -10e-3, -10e-3 upper = 10e-3, -10e-3 fix = 'y' unilateral = .true. name = 'foot' /\n"
    + "&constraint lower = 0.0, -10e-3 upper = 0.0, -10e-3 fix = 'x' /\n" + "&load kind = 'body' lower = 4e-3, 0.0 upper = 10e-3, 10e-3 force = 0.0, -1e4 /\n"
    + STATIC.format(""),
    "on a side": plate(shape="shape = 'polygon' points = -10e-3, -10e-3, 8e-3, -10e-3, 10e-3, 10e-3, -10e-3, 10e-3") + HELD + "&load kind = 'traction' side = 2 force = 1e4, 0.0 /\n" + STATIC.format(""),
    "on pins": plate() + "&constraint lower = -8e-3, -3e-3 upper = -4e-3, 1e-3 fix = 'xy' turns = .true. name = 'pin' /\n"
    + "&constraint lower = 4e-3, -3e-3 upper = 8e-3, 1e-3 fix = 'y' turns = .true. /\n&load kind = 'gravity' acceleration = 0.0, 1e4 /\n" + STATIC.format(""),
    "moved": plate() + HELD + "&constraint lower = -10e-3, 10e-3 upper = 10e-3, 10e-3 fix = 'xy' displacement = 1e-5, 2e-5 velocity = 0.0, 1e-5 "
    "history = 'ramp' rise_time = 0.7 start = 0.1 /\n" + STATIC.format("load_steps = 3"),
    "moved in motion": plate(end="8e-6") + HELD + "&constraint lower = -10e-3, 10e-3 upper = 10e-3, 10e-3 fix = 'y' velocity = 0.0, 1.0 "
    "history = 'sine' frequency = 1.5e5 /\n" + EVERY.format("1e-6"),
    "pulled steadily": plate(end="4e-6") + "&constraint lower = -10e-3, 10e-3 upper = 10e-3, 10e-3 fix = 'y' velocity = 0.0, 1.0 /\n" + HELD + EVERY.format("1e-6"),
    "pulled by a table": plate(end="8e-6") + HELD + "&constraint lower = -10e-3, 10e-3 upper = 10e-3, 10e-3 fix = 'y' velocity = 0.0, 1.0 "
    "history = 'table' times = 0.0, 4e-6 factors = 0.0, 1.0 /\n" + EVERY.format("1e-6"),
    "bodies that meet": TWO.format("spin = 0.3 contact_group = 'y'", "contact_group = 'x'") + "&method frame = 'updated' shape_functions = 'cpdi' courant = 0.07 /\n&contact bodies = 'friction' friction = 0.3 distance = 0.02 /\n",
    "bodies that meet, joined, consistent mass": TWO.format("", "") + "&method frame = 'updated' mass = 'consistent' /\n",
    "bodies that meet, frictionless, zz": TWO.format("", "") + "&method frame = 'updated' mass = 'fmpm' order = 3 /\n&contact bodies = 'frictionless' /\n"
    "&refine indicator = 'zz' max_level = 1 tolerance = 0.1 interval = 5 /\n",
    "two tips weighted": plate(end="4e-6") + HELD + PULL.format("start = 1e-6") + LINE.format("length = 8e-3 direction = 0.0, 1.0")
    + "&energy_release estimators = 'vcct'  energy_balance = .true. /\n&method mass = 'weighted' lumped_fraction = 0.4 scheme = 'usavg' wave_speed = 'dilatational' courant = 0.3 solver = 'direct' /\n"
    + EVERY.format("1e-6"),
    "consistent mass where refined": plate(end="2e-6") + HELD + PULL.format("") + PATH.format("") + J.format("") + "&refine indicator = 'tip' max_level = 1 rings = 2 /\n"
    + "&method mass = 'partial' consistent_region = 'refined' consistent_lower = -6e-3, -6e-3 consistent_upper = 6e-3, 6e-3 /\n" + EVERY.format("1e-6"),
    "an error asked, of shear that fades": "\n".join(line for line in plate(end="1.0").split("\n") if not line.startswith("&grid")) + HELD + PULL.format("")
    + PULL.format("history = 'table' times = 0.0, 0.5, 1.0 factors = 1.0, 1.0, 0.05").replace("20e3, 100e3", "90e3, 0.0") + PATH.format("")
    + STATIC.format("load_steps = 2") + "&accuracy quantity = 'K_II' error = 0.02 /\n",
}

# Other values of keys, for the scenes above, with keys of the same group that they require; those with a choice take each of it, and what is
# not here a number that is a little different.
HISTORIES = ["step", "ramp;rise_time=1e-6", "smooth_ramp;rise_time=1e-6", "sine;frequency=1e4", "table;times=0.0,2e-6;factors=0.0,0.5"]
VALUES = {
    "accuracy.error": ["0.9", "0.05"], "accuracy.must": [".true.;error=1e-9"], "accuracy.quantity": ["G", "K_III"], "accuracy.most_time": ["1e-9"], "accuracy.most_memory": ["1e3"],
    "run.title": ["another"], "run.end_time": ["0.9*"], "grid.lower": ["-10e-3,-14e-3", "-0.1,0.0"], "grid.cell": ["1.1*"], "grid.cells": ["22,4", "10,14", "18,12"],
    "material.name": ["b"], "material.moduli": ["1e10", "15e9,20e9"], "material.relaxation_times": ["0.1", "0.2,2.0"], "material.yield_stress": ["1.1*", "1e8"],
    "material.hardening": ["1.1*", "1e9"], "material.saturation": ["1.1*", "1e8"], "material.saturation_strain": ["1.1*", "2e-3"], "material.kinematic_hardening": ["1.1*", "1e9"],
    "material.c01": ["0.9*", "1e10"], "material.angle": ["20", "1.1*"], "material.young_3": ["1.1*", "11e9"], "material.poisson_13": ["1.1*", "0.25"],
    "material.poisson_23": ["1.1*", "0.35"], "material.young_1": ["1.1*", "130e9"], "material.young_2": ["1.1*", "11e9"], "material.shear_12": ["1.1*", "6e9"],
    "material.poisson_12": ["1.1*", "0.2"],
    "body.material": ["b", "n", "m"], "body.lower": ["-8e-3,-10e-3", "0.2,0.3"], "body.upper": ["10e-3,8e-3", "0.7,0.6"], "body.points": ["0,0,1e-3,0,0,1e-3"],
    "body.center": ["0.0,1e-3"], "body.radius": ["0.9*", "1e-3"], "body.velocity": ["0.1,0.0"], "body.spin": ["0.1"], "body.eigenstrain": ["1e-4,1e-4,0,1e-4", "1e-4,2e-4,0"],
    "body.contact_group": ["x"], "body.points_per_cell": ["4", "3"],
    "constraint.lower": ["-8e-3,-10e-3", "2e-3,-10e-3", "0.06,0.0"], "constraint.upper": ["8e-3,-10e-3"], "constraint.displacement": ["1e-6,0.0", "0.0,1e-6", "1e-6,1e-6"],
    "constraint.velocity": ["1e-2,0.0", "0.0,1e-2"], "constraint.start": ["1e-6", "0.3", "-1e-6"], "constraint.rise_time": ["1e-6", "0.5"],
    "constraint.frequency": ["1e4", "0.9*"], "constraint.times": ["0.0,2e-6", "0.0,0.5"], "constraint.factors": ["0.0,0.5", "1.0,2.0"], "constraint.name": ["bar"],
    "constraint.history": HISTORIES, "load.history": HISTORIES, "control.history": HISTORIES, "control.displacement": ["0.9*"], "control.quantity": ["growth", "displacement;displacement=1e-6"], "run.stop_length": ["0.011"], "run.stop_load": ["0.99", "0.5"], "run.stop_rest": ["4e-6"], "body.profile_direction": ["0.8,0.6"], "body.held": [".true.", ".false."], "control.stiffness": ["0.5*", "1e8"],
    "control.start": ["1e-6", "0.3", "-1e-6"], "control.rise_time": ["0.9", "0.5"], "control.frequency": ["0.3"], "control.times": ["0.0,0.5"], "control.factors": ["0.0,0.5", "1.0,2.0"],
    "probe.name": ["other"], "probe.of": ["q", "bar"], "load.name": ["bar"],
    "load.lower": ["-8e-3,10e-3"], "load.upper": ["8e-3,10e-3"], "load.side": ["3"], "load.force": ["0.9*", "10.0,10.0"], "load.pressure": ["0.9*", "1e5"], "load.crack": ["p", "q"],
    "load.acceleration": ["0.9*", "1.0,1.0"], "load.start": ["1e-6", "0.3", "-1e-6"], "load.rise_time": ["1e-6", "0.5"], "load.frequency": ["1e4", "0.9*"],
    "load.times": ["0.0,2e-6", "0.0,0.5"], "load.factors": ["0.0,0.5", "1.0,2.0"], "damping.rate": ["1e3", "1.0"], "contact.friction": ["0.2"], "contact.distance": ["0.01", "1e-4"],
    "method.time_step": ["1e-7", "0.9*"], "method.modes": ["12", "50"], "method.hht_alpha": ["-0.2"], "method.load_steps": ["3"], "method.courant": ["0.04", "0.5"], "method.order": ["3", "4"],
    "method.lumped_fraction": ["0.5"], "method.consistent_lower": ["0.035,0.0", "-4e-3,-4e-3"], "method.consistent_upper": ["0.055,0.01", "4e-3,4e-3"], "refine.r_crit": ["0.02", "0.2"],
    "refine.r_coarsen": ["0.01", "0.04"], "refine.tolerance": ["0.2", "0.05"], "refine.rings": ["2", "5"], "refine.max_level": ["1", "2", "0"], "refine.energy_floor": ["0.3"],
    "refine.region_lower": ["-4e-3,-4e-3", "0.04,0.0", "0.7,0.5"], "refine.region_upper": ["4e-3,4e-3", "0.06,0.01"], "refine.start": ["1e-6", "0.1"], "refine.interval": ["3", "7"],
    "refine.max_particles": ["600", "480", "170"], "crack.tip": ["0.055,0.0", "4e-3,0.0"], "crack.direction": ["0.0,1.0", "-1.0,0.0"], "crack.length": ["4e-3", "6e-3"],
    "crack.friction": ["0.02", "0.04"], "crack.points": ["-4e-3,-1e-3,4e-3,1e-3"], "crack.name": ["q"], "growth.crack": ["p", "q"], "growth.points": ["4e-3,0.0,9e-3,0.0"],
    "nucleation.crack": ["p", "q"], "nucleation.toughness": ["0.8*"], "nucleation.strength": ["2*", "1e6", "0.7*"], "nucleation.increment": ["2e-3", "0.0"],
    "growth.toughness": ["0.8*", "1.0"], "growth.limit_speed": ["1000"], "growth.exponent": ["3"], "growth.speed": ["0.9*", "500"], "growth.start": ["2e-6", "5e-6"],
    "cohesive.crack": ["p", "q"], "cohesive.from": ["2e-3", "0.0"], "cohesive.strength": ["0.9*", "300e6"], "cohesive.toughness": ["0.9*", "1e3"],
    "cohesive.opening": ["0.9*", "1e-7"], "cohesive.openings": ["0.9*", "0.0,1e-5"], "cohesive.tractions": ["0.9*", "100e6,0.0"], "cohesive.strength_shear": ["0.9*", "350e6"],
    "cohesive.toughness_shear": ["0.9*", "1.5e3"], "cohesive.exponent": ["1.2", "2.0"],
    "body.toughness": ["50.0", "0.05"], "growth.extensions": ["0.0,1e-3;extension_factors=1.2,2.0"], "growth.extension_factors": ["1.2,2.0;extensions=0.0,1e-3"],
    "growth.speeds": ["0.0,900.0;speed_factors=1.2,2.0"], "growth.speed_factors": ["1.2,2.0;speeds=0.0,900.0"], "growth.angles": ["0.0,90.0;angle_factors=1.2,2.0"],
    "growth.angle_factors": ["1.2,2.0;angles=0.0,90.0"], "growth.mixed_mode": ["hutchinson_suo", "benzeggagh_kenane;toughness_shear=200.0"],
    "growth.lambda": ["0.1;mixed_mode=hutchinson_suo"], "growth.toughness_shear": ["200.0;mixed_mode=benzeggagh_kenane"],
    "growth.mixed_mode_exponent": ["2.0;mixed_mode=benzeggagh_kenane;toughness_shear=200.0"],
    "growth.threshold": ["1e9"], "cycles.blocks": ["0.9*"], "cycles.factors": ["0.9*"], "cycles.ratios": ["0.9*"], "cycles.ratio": ["0.9*", "0.5"],
    "growth.end": ["5e-6", "1e-5"], "growth.increment": ["2.5e-3"], "growth.max_length": ["5e-3", "0.055"],
    "energy_release.estimators": ["vcct", "domain_integral", "material_force", "stress_closure"], "energy_release.radii": ["4.5e-3", "2.5e-3", "0.0105"],
    "energy_release.reference_value": ["0.9*", "2.0"], "output.file": ["other.h5"], "output.history_interval": ["0.5*", "0.4"], "output.snapshot_interval": ["0.5*"],
    "output.checkpoint_interval": ["1e-6"], "output.checkpoint_steps": ["3"],
}


class World:
    """Scenes, other values of keys for them, and keys that act in none of them but by being refused, of some groups all."""

    def __init__(self, scenes, values, refused, groups=()):
        self.scenes, self.values, self.refused, self.groups = scenes, values, refused, groups

    def refuses(self, key):
        """Whether a key may act by being refused alone."""
        return key in self.refused or key.partition(".")[0] in self.groups


def key_table(program):
    """The program's own keys: `group.key` -> the row of its reference."""
    text = subprocess.run([program, "--keys"], capture_output=True, text=True, check=True).stdout
    found, group = {}, ""
    for line in text.splitlines():
        if line.startswith("## &"):
            group = line[4:].strip()
        row = re.match(r"\| `(\w+)` \| ([^|]*) \| ([^|]*) \| ([^|]*) \| ([^|]*) \|", line)
        if row:
            found[f"{group}.{row[1]}"] = {"type": row[2], "default": row[4].strip("` "), "allowed": row[5]}
    return found


def instances(text, key):
    """The numbers of the groups of a scene that a key may stand in, each with the value that it has there, '' where it is not given."""
    group, name = key.split(".")
    bodies = re.findall(rf"&{group}\b(.*?) /\n", text, re.DOTALL)
    values = []
    for body in bodies:
        given = re.search(rf"(?<!\w){name} = (.*?)(?=\s+\w+ = |\s*$)", body, re.DOTALL)
        values.append(given[1].strip().strip("'") if given else "")
    return values or [""]


def other_values(key, row, present, values):
    """Values that differ from what a key has: each choice, those of `values`, or a number that is a little different."""
    present = present or row["default"].strip("'")
    if row["type"] == "logical":
        candidates = [".true.", ".false."]
    elif "text" in row["type"] and row["allowed"].startswith("`") and key not in values:
        candidates = re.findall(r"`(\w+)`", row["allowed"])
    else:
        candidates = values.get(key, ["1", "2"] if row["type"] == "integer" else ["0.9*"])
    for value in candidates:
        if value.endswith("*"):
            numbers = [float(part) * float(value[:-1]) for part in present.split(",")] if re.match(r"[-+.\d]", present) else []
            if not any(numbers):
                continue
            value = ",".join(repr(number) for number in numbers)
        if value.split(";")[0] != present:
            yield value


def digest(folder):
    """What a run has written: the names of its files, and all numbers and texts of its result but for the scene and the machine; and the scene as it
    was understood, where words such as 'auto' are what they stand for."""
    found, understood = hashlib.sha256(), b""
    for path in sorted(folder.iterdir()):
        if path.suffix == ".nml":
            continue
        found.update(path.name.encode())
        if path.suffix != ".h5":
            continue

        def take(name, item):
            if name.startswith("input"):
                return
            found.update(name.encode())
            for attribute, value in sorted(item.attrs.items()):
                if attribute != "warnings":
                    found.update(f"{attribute}={value!r}".encode())
            if isinstance(item, h5py.Dataset) and item.dtype.kind not in "OSV":
                found.update(np.ascontiguousarray(item[()]).tobytes())
        with h5py.File(path) as file:
            file.visititems(take)                              # attributes of the file tell date, machine and command
            understood = file["input/namelist"][()]
    return found.hexdigest(), understood


def remarks(said):
    """The notes and warnings among what the program says."""
    return "\n".join(line for line in said.splitlines() if re.match(r"(! )?(note|warning):|hampm: ", line))


def run(program, folder, text, *options):
    """Exit code, digest of what was written, notes and warnings, of a run in a folder of its own."""
    with tempfile.TemporaryDirectory(dir=folder) as place:
        place = Path(place)
        (place / "case.nml").write_text(text)
        if "output.checkpoint" in "".join(options):
            (place / "case.h5.checkpoint").mkdir()      # a run removes its checkpoint at its end: this one cannot write it
        try:
            ended = subprocess.run([program, "case.nml", "--threads", "1", "--force", "--steps", str(STEPS), *options], cwd=place, capture_output=True,
                                   text=True, errors="replace", timeout=LONGEST)
        except subprocess.TimeoutExpired:
            return None, ("", b""), ""
        return ended.returncode, digest(place), remarks(ended.stdout + ended.stderr)


def try_key(program, folder, text, plain, setting):
    """What a setting does in a scene whose result is `plain`: 'refused', 'failed', 'acts', 'said', 'silent', or what is wrong else."""
    key, _, value = setting.partition("=")
    group = key.split(".")[0]
    first, *others = value.split(";")
    words = [word for item in (f"{key}={first}", *(f"{group}.{other}" for other in others)) for word in ("--set", item)]
    code, written, said = run(program, folder, text, *words)
    if code is None or code == 4 and "checkpoint" in setting:
        return "acts"
    name = key.split(".")[1]
    told = re.compile(rf"\b{name}\b")
    if code == 2:
        return "refused"
    if code not in (0, 3, 5):
        return f"ends with {code}: {said[-500:]}"
    if written[0] != plain[0]:
        return "failed" if code == 3 else "acts"
    if not told.search(said):
        return "stands for what it was" if written[1] == plain[1] else "silent"
    code, _, said = run(program, folder, text, "--check", *words)
    return "said" if told.search(said) else "silent in --check"


# Names by which other groups mean a group, and kinds that need other keys: they act by being refused, or ending the run, where nothing fits them
NAMES = ("accuracy.must", "accuracy.most_time", "accuracy.most_memory", "load.name", "probe.quantity", "probe.of", "material.name", "body.shape", "body.hole", "load.kind", "load.on", "load.crack", "crack.kind", "growth.crack", "growth.law", "nucleation.crack", "cohesive.crack", "cohesive.law")
# Keys of solids, which planes refuse
OF_SOLIDS = ("material.shear_13", "material.shear_23", "crack.normal", "crack.front", "crack.center", "crack.radii")
PLANE = World(SCENES, VALUES, NAMES + OF_SOLIDS)


def try_each_once(program, random, extra, keys=None, world=PLANE):
    """A line for each key, or of so many, that acts in no scene (those that give it are tried first), and for each of some more settings, taken at random, that is
    silent."""
    table, findings, plain = key_table(program), [], {}
    with tempfile.TemporaryDirectory() as folder:
        def what(name, key):
            if name not in plain:
                plain[name] = run(program, folder, world.scenes[name])[1]
            present = instances(world.scenes[name], key)
            number = next((k for k, value in enumerate(present) if value), 0)
            group, short = key.split(".")
            place = f"{group}({number + 1}).{short}" if len(present) > 1 else key
            return place, outcome(program, folder, world.scenes[name], plain[name], place, other_values(key, table[key], present[number], world.values))

        for key in random.sample(list(table), keys or len(table)):
            scenes = sorted(world.scenes, key=lambda name: not any(instances(world.scenes[name], key)))
            wanted = {"acts", "refused", "said", "failed"} if world.refuses(key) else {"acts"}
            if not any(what(name, key)[1] in wanted for name in scenes):
                findings.append(f"{key} acts in no scene")
        for _ in range(extra):
            name = random.choice(list(world.scenes))
            key = random.choice(list(table))
            place, found = what(name, key)
            if found not in OPEN and key not in IDLE:
                findings.append(f"{name}: {place}: {found}")
    return findings


def outcome(program, folder, text, plain, place, values):
    """What a key does in a scene, by the first value with which it acts or says that it does not, else by the last that is not refused."""
    found = "refused"
    for value in values:
        what = try_key(program, folder, text, plain, f"{place}={value}")
        if what in ("acts", "said") or what.startswith("ends"):
            return what
        found = found if what == "refused" else what if what in OPEN else f"{what} with {value}"
    return found


def try_keys(program, world, scenes, keys=(), tell=None):
    """Counts of what settings did, the keys that acted, and a line for each that is silent, which `tell` gets at once."""
    table, counts, acted, findings = key_table(program), Counter(), defaultdict(set), []
    with tempfile.TemporaryDirectory() as folder:
        for name in scenes:
            text = world.scenes[name]
            code, plain, said = run(program, folder, text)
            if code != 0:
                findings.append(f"{name}: the scene itself ends with {code}: {said}")
                continue
            for key in keys or table:
                group, short = key.split(".")
                values = instances(text, key)
                for number, present in enumerate(values, 1):
                    place = f"{group}({number}).{short}" if len(values) > 1 else key
                    what = outcome(program, folder, text, plain, place, other_values(key, table[key], present, world.values))
                    counts[what.partition(":")[0]] += 1
                    acted[key].add(what)
                    if what not in OPEN and key not in IDLE:
                        findings.append(f"{name}: {place}: {what}")
                        if tell:
                            tell(findings[-1])
    return counts, {key for key, done in acted.items() if "acts" in done}, findings


def main(world=PLANE, program=PROGRAM):
    parser = argparse.ArgumentParser(description=sys.modules["__main__"].__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=program, metavar="FILE")
    parser.add_argument("--scenes", help="numbers of scenes; all by default")
    parser.add_argument("--keys", help="keys; all by default")
    options = parser.parse_args()
    names = list(world.scenes)
    scenes = [names[int(number)] for number in options.scenes.split(",")] if options.scenes else names
    keys = options.keys.split(",") if options.keys else ()
    program = options.program.resolve()
    counts, acted, findings = try_keys(program, world, scenes, keys, lambda line: print(line, flush=True))
    if options.scenes:
        print("acts:", *sorted(acted))
    missing = [] if options.scenes else [key for key in keys or key_table(program) if key not in acted and not world.refuses(key)]
    for key in missing:
        print(f"{key} acts in no scene")
    print(f"{len(keys or key_table(program))} keys, {sum(counts.values())} settings in {len(scenes)} scenes: "
          + ", ".join(f"{count} {what}" for what, count in sorted(counts.items())))
    sys.exit(bool(findings or missing))


if __name__ == "__main__":
    main()
