"""Every key of solids acts: small scenes of all that solids do, and in each of them every key set to other values, as `every_key.py` does in planes.

    .venv/bin/python tests/fuzz/solid_keys.py [--program build/checked3d/hampm3d] [--scenes N,N] [--keys GROUP.KEY,...]

A key that acts in no scene is refused there, or says that it does nothing, and is one of `REFUSED`.
"""

import every_key
from solid_scenes import PROGRAM

STEEL = "young = 200e9  poisson = 0.3  density = 8000"
STATIC = "&method time = 'static' {} /\n&output file = 'case.h5'  snapshot_interval = 0.5 /\n"
EVERY = "&output file = 'case.h5'  history_interval = {0}  snapshot_interval = {0} /\n"


def block(law=STEEL, size=(3, 3, 4), end="1.0", shape=None, points=2, more=""):
    """A block of so many cells of 2 mm, with a free cell to each side of it."""
    x, y, z = (2e-3 * n for n in size)
    return f"""&run end_time = {end} /
&grid lower = -2e-3, -2e-3, -2e-3  cell = 2e-3  cells = {size[0] + 2}, {size[1] + 2}, {size[2] + 2} /
&material name = 'a'  {law} /
&body material = 'a'  {shape or f'lower = 0.0, 0.0, 0.0  upper = {x}, {y}, {z}'}  points_per_cell = {points} {more} /
"""


def face(axis, at, size=(3, 3, 4)):
    """The two keys of a side of the block."""
    lower, upper = [0.0, 0.0, 0.0], [2e-3 * n for n in size]
    lower[axis] = upper[axis] = 2e-3 * at
    return f"lower = {lower[0]}, {lower[1]}, {lower[2]}  upper = {upper[0]}, {upper[1]}, {upper[2]}"


FOOT = f"&constraint {face(2, 0)}  fix = 'xyz'  name = 'foot' /\n"
PULL = "&load kind = 'traction'  " + face(2, 4) + "  force = 500.0, 300.0, 4000.0  {} /\n"
PRESS = "&load kind = 'pressure'  " + face(2, 4) + "  pressure = 100e6  {} /\n"
DISC = "&crack kind = 'plane'  name = 'c'  normal = 'z'  front = 'disc'  center = 2e-3, 2e-3, 4e-3  radii = 3.3e-3 {} /\n"
LAYER = "law = 'orthotropic' density = 1600 young_1 = 140e9 young_2 = 10e9 young_3 = 12e9 shear_12 = 5e9 shear_13 = 4e9 shear_23 = 3e9 " \
        "poisson_12 = 0.3 poisson_13 = 0.2 poisson_23 = 0.4 angle = 30.0, 20.0, 10.0"
WIDE = (8, 8, 2)
PROBES = """&probe name = 'a'  quantity = 'displacement', 'stress'  at = 3.1e-3, 2.3e-3, 5.2e-3 /
&probe name = 'b'  quantity = 'strain'  at = 1.1e-3, 2.3e-3, 5.2e-3, 4.1e-3, 3.3e-3, 4.8e-3 /
&probe name = 'c'  quantity = 'load_line'  of = 'top' /
"""

SCENES = {
    "at rest": block() + FOOT + PULL.format("name = 'top' history = 'ramp' rise_time = 0.7") + PROBES + STATIC.format("load_steps = 2 solver = 'direct'"),
    "in motion": block(end="4e-6", more="velocity = 0.1, 0.0, 0.2 spin = 3.0, 5.0, 7.0") + FOOT + PULL.format("history = 'sine' frequency = 1e5")
    + "&load kind = 'point' lower = 6e-3, 6e-3, 8e-3 upper = 6e-3, 6e-3, 8e-3 force = 10.0, 20.0, 30.0 start = 1e-6 /\n&damping rate = 1e4 /\n"
    + "&energy_release energy_balance = .true. /\n&method wave_speed = 'dilatational' scheme = 'usl' courant = 0.3 /\n" + EVERY.format("1e-6"),
    "in the updated frame": block("law = 'neo_hookean' " + STEEL, end="4e-6", more="velocity = 0.1, 0.0, 0.2") + FOOT
    + PULL.format("history = 'table' times = 0.0, 2e-6 factors = 0.3, 1.0") + "&method frame = 'updated' mass = 'fmpm' order = 3 /\n" + EVERY.format("1e-6"),
    "consistent mass in a box": block(end="2e-6") + FOOT + PRESS.format("") + "&refine indicator = 'gradient' field = 'energy_density' max_level = 1 r_crit = 0.05 interval = 3 "
    + "region_lower = 0.0, 0.0, 4e-3 region_upper = 6e-3, 6e-3, 8e-3 max_particles = 4000 /\n"
    + "&method mass = 'partial' consistent_lower = 0.0, 0.0, 0.0 consistent_upper = 6e-3, 6e-3, 4e-3 /\n" + EVERY.format("1e-6"),
    "weighted mass": block(end="2e-6") + FOOT + PRESS.format("") + "&method mass = 'weighted' lumped_fraction = 0.4 /\n" + EVERY.format("1e-6"),
    "zz in motion": block(end="2e-6") + FOOT + PULL.format("") + DISC.format("")
    + "&refine indicator = 'zz' max_level = 1 tolerance = 0.05 interval = 3 start = 5e-7 max_particles = 3000 /\n" + EVERY.format("5e-7"),
    "implicit": block(end="1e-5") + FOOT + PULL.format("history = 'ramp' rise_time = 5e-6 start = -1e-6") + DISC.format("contact = 'frictionless'")
    + "&method time = 'implicit' time_step = 1e-6 hht_alpha = -0.1 /\n&damping rate = 1e4 /\n" + EVERY.format("2e-6"),
    "by modes": block(end="1e-5") + FOOT + PULL.format("history = 'ramp' rise_time = 5e-6") + DISC.format("")
    + "&method time = 'modal' modes = 30 /\n&damping rate = 1e4 /\n" + EVERY.format("2e-6"),
    "moved by modes": block(end="1e-5") + FOOT + f"&constraint {face(2, 4)} fix = 'xz' velocity = 0.5, 0.0, 1.0 history = 'ramp' rise_time = 3e-6 /\n" + DISC.format("")
    + "&method time = 'modal' modes = 20 /\n&damping rate = 1e4 /\n" + EVERY.format("2e-6"),
    "moved": block(LAYER) + FOOT + f"&constraint {face(2, 4)} fix = 'xyz' name = 'top' displacement = 1e-6, 2e-6, 3e-6 history = 'table' times = 0.0, 0.7, 1.0 factors = 0.0, 1.0, 0.2 /\n"
    + STATIC.format("load_steps = 3").replace("&output", "&output history_interval = 0.3 "),
    "moved until the load drops": block().replace("end_time = 1.0", "end_time = 1.0 stop_when = 'load_dropped' stop_load = 0.7") + FOOT
    + f"&constraint {face(2, 4)} fix = 'xyz' name = 'top' displacement = 1e-6, 2e-6, 3e-6 history = 'table' times = 0.0, 0.4, 1.0 factors = 0.0, 1.0, 0.2 /\n"
    + STATIC.format("load_steps = 5"),
    "moved by a sine": block(end="2e-6") + FOOT + f"&constraint {face(2, 4)} fix = 'z' velocity = 0.0, 0.0, 1.0 history = 'sine' frequency = 1e5 start = 1e-7 /\n" + EVERY.format("5e-7"),
    "moved by a ramp": block(end="2e-6") + FOOT + f"&constraint {face(2, 4)} fix = 'z' displacement = 0.0, 0.0, 1e-6 history = 'ramp' rise_time = 1e-6 start = -1e-7 /\n" + EVERY.format("5e-7"),
    "pushes only": block() + f"&constraint {face(2, 0)} fix = 'z' unilateral = .true. name = 'foot' /\n"
    + f"&constraint {face(0, 0)} fix = 'x' /\n&constraint {face(1, 0)} fix = 'y' /\n&load kind = 'gravity' acceleration = 1e3, 2e3, -1e5 /\n&load kind = 'point' lower = 6e-3, 6e-3, 8e-3 upper = 6e-3, 6e-3, 8e-3 force = 0.0, 0.0, 150.0 /\n"
    + "&load kind = 'body' lower = 0.0, 0.0, 4.1e-3 upper = 6e-3, 6e-3, 8e-3 force = 10.0, 20.0, 30.0 /\n" + STATIC.format(""),
    "on pins": block() + "&constraint lower = -0.5e-3, 0.0, -0.5e-3 upper = 2.5e-3, 6e-3, 2.5e-3 fix = 'xz' turns = .true. name = 'pin' /\n"
    + "&constraint lower = -0.5e-3, 0.0, 5e-3 upper = 2.5e-3, 6e-3, 7.2e-3 fix = 'x' turns = .false. /\n" + f"&constraint {face(1, 0)} fix = 'y' /\n"
    + "&load kind = 'gravity' acceleration = 1e4, 0.0, 1e4 /\n" + STATIC.format(""),
    "yields": block("law = 'j2_plastic' yield_stress = 100e6 hardening = 1e9 volumetric = 'b_bar' saturation = 50e6 saturation_strain = 1e-3 kinematic_hardening = 5e9 " + STEEL, size=(2, 2, 2))
    + f"&constraint {face(2, 0, (2, 2, 2))} fix = 'xyz' /\n&load kind = 'pressure' {face(2, 2, (2, 2, 2))} pressure = -150e6 /\n" + STATIC.format("load_steps = 2"),
    "rubber of two moduli": block("law = 'mooney_rivlin' c01 = 1e10 " + STEEL, size=(2, 2, 2)) + f"&constraint {face(2, 0, (2, 2, 2))} fix = 'xyz' /\n"
    + f"&load kind = 'pressure' {face(2, 2, (2, 2, 2))} pressure = -1e9 /\n" + STATIC.format(""),
    "creeps": block("law = 'viscoelastic' moduli = 10e9, 20e9 relaxation_times = 0.1, 1.0 " + STEEL) + FOOT + PULL.format("") + STATIC.format("load_steps = 3"),
    "graded": block(more="eigenstrain = 1e-4, 2e-4, 0.0, 1e-4 profile_direction = 0.0, 0.6, 0.8 profile_at = 1e-3, 6e-3 profile_stiffness = 1.0, 2.0 profile_density = 1.0, 1.5 "
                         "profile_eigenstrain = 0.5, 1.0", end="2e-6") + FOOT + PULL.format("") + "&method start = 'static' /\n" + EVERY.format("1e-6"),
    "cylinder with a cavity": block(shape="shape = 'cylinder' lower = 6e-3, 6e-3, 0.0 upper = 6e-3, 6e-3, 12e-3 radius = 6e-3", size=(6, 6, 6))
    + "&body hole = .true. shape = 'sphere' center = 6e-3, 6e-3, 6e-3 radius = 3.4e-3 /\n" + f"&constraint {face(2, 0, (6, 6, 6))} fix = 'xyz' /\n"
    + "&load kind = 'pressure' lower = 2e-3, 2e-3, 2e-3 upper = 10e-3, 10e-3, 10e-3 pressure = 1e6 /\n" + STATIC.format("solver = 'cg'"),
    "two that are bonded": block(size=(3, 3, 2), end="2e-6").replace("cells = 5, 5, 4", "cells = 5, 5, 6") + "&material name = 'n' young = 70e9 poisson = 0.3 density = 2700 /\n"
    + "&body material = 'n' lower = 0.0, 0.0, 4e-3 upper = 6e-3, 6e-3, 8e-3 /\n" + FOOT + f"&load kind = 'absorbing' {face(2, 4)} /\n" + PULL.format("") + EVERY.format("1e-6"),
    "front of a half plane": block(size=WIDE).replace("cells = 10, 10, 4", "cells = 10, 10, 3") + "&crack kind = 'plane' name = 'c' normal = 'y' tip = 7.5e-3, 8e-3, 1e-3 direction = 1.0, 0.0, 0.0 /\n"
    + f"&constraint {face(1, 0, WIDE)} fix = 'xyz' name = 'foot' /\n&load kind = 'pressure' on = 'crack' crack = 'c' pressure = 1e6 /\n&energy_release estimators = 'domain_integral' "
    + "reference = 'value' reference_value = 3.0 /\n" + STATIC.format(""),
    "polygon on a plane of symmetry, refined": block() + f"&constraint {face(2, 0)} fix = 'z' /\n&constraint {face(0, 0)} fix = 'x' /\n&constraint {face(1, 0)} fix = 'y' /\n" + PULL.format("")
    + "&crack kind = 'symmetry' normal = 'z' front = 'polygon' points = -1e-3, -1e-3, 0.0, 4e-3, -1e-3, 0.0, -1e-3, 4.5e-3, 0.0 /\n&refine indicator = 'tip' max_level = 1 rings = 2 /\n" + STATIC.format(""),
    "an error asked, of tension that comes and goes": "\n".join(line for line in block().split("\n") if not line.startswith("&grid")) + FOOT
    + PULL.format("").replace("500.0, 300.0, 4000.0", "500.0, 0.0, 0.0") + PULL.format("history = 'table' times = 0.0, 0.5, 1.0 factors = 0.0, 1.0, 0.0")
    + "&crack kind = 'plane' name = 'c' normal = 'z' tip = 2.3e-3, 0.0, 4e-3 direction = 1.0, 0.0, 0.0 /\n"
    + STATIC.format("load_steps = 2") + "&accuracy quantity = 'K_II' error = 0.03 /\n",
}

HISTORIES = ["step", "ramp;rise_time=1e-6", "smooth_ramp;rise_time=1e-6", "sine;frequency=1e5", "table;times=0.0,2e-6;factors=0.0,0.5", "ramp;rise_time=0.5"]
VALUES = {
    **{key: values for key, values in every_key.VALUES.items() if key.startswith("accuracy")},
    "accuracy.error": ["0.01"],  # a finer mesh; 0.03 at all times needs one, too
    "run.title": ["another"], "run.plane": ["strain"], "run.thickness": ["2.0"], "grid.lower": ["-3e-3,-2e-3,-2e-3", "-2e-3,-2e-3,-4e-3"], "grid.cell": ["1e-3;cells=10,10,12"], "run.stop_load": ["0.4"], "grid.cells": ["7,7,8", "9,9,9", "12,12,5"],
    "material.name": ["b"], "material.moduli": ["15e9,20e9", "0.9*"], "material.relaxation_times": ["0.2,2.0"], "material.angle": ["10.0,0.0,0.0"], "body.material": ["b", "n"],
    "body.lower": ["0.0,0.0,2e-3", "6e-3,6e-3,2e-3"], "body.upper": ["6e-3,4e-3,8e-3", "0.9*"], "body.center": ["6e-3,6e-3,5e-3"], "body.velocity": ["0.1,0.0,0.3"], "body.spin": ["1.0,0.0,3.0"],
    "body.eigenstrain": ["1e-4,1e-4,1e-4,3e-4", "1e-4,0,0,0"], "body.points_per_cell": ["3", "1"], "body.contact_group": ["x"], "body.profile_direction": ["0.0,0.8,0.6"],
    "constraint.lower": ["2e-3,0.0,0.0", "0.0,0.0,2e-3", "4e-3,0.0,0.0"], "constraint.upper": ["4e-3,6e-3,0.0", "2e-3,4e-3,0.0"], "constraint.displacement": ["1e-7,0.0,1e-6", "0.0,0.0,1e-7"],
    "constraint.velocity": ["0.0,0.0,2.0"], "constraint.history": HISTORIES, "load.history": HISTORIES, "constraint.fix": ["z", "xy", "xyz", "xz", "x"], "constraint.name": ["bar"],
    "constraint.start": ["1e-6", "0.3", "-1e-7"], "load.start": ["1e-6", "0.3", "-1e-6"], "constraint.times": ["0.0,0.5,0.8", "0.0,2e-6"], "load.times": ["0.0,1e-6"],
    "constraint.factors": ["0.0,0.5,0.1"], "load.factors": ["0.0,0.5"], "load.name": ["bar"], "load.lower": ["2e-3,0.0,8e-3", "0.0,0.0,6e-3"], "load.upper": ["4e-3,6e-3,8e-3", "6e-3,6e-3,6e-3"],
    "load.force": ["0.9*", "10.0,10.0,5.0"], "load.acceleration": ["0.9*", "1.0,2.0,3.0"], "load.crack": ["c", "q"], "load.rise_time": ["0.9*", "1e-6"], "load.frequency": ["0.9*"],
    "load.kind": ["traction", "gravity;acceleration=1.0,2.0,3.0", "pressure;pressure=1e5", "absorbing"], "damping.rate": ["0.9*", "1.0"], "contact.friction": ["0.2"],
    "method.time": ["explicit", "implicit", "static", "modal"], "method.modes": ["12"], "method.time_step": ["0.9*", "2e-7"], "method.hht_alpha": ["-0.2"], "method.load_steps": ["4"], "method.courant": ["0.04", "0.2"], "method.order": ["4"],
    "method.consistent_lower": ["0.0,0.0,2e-3"], "method.consistent_upper": ["6e-3,6e-3,2e-3"], "refine.region_lower": ["0.0,0.0,2e-3"], "refine.region_upper": ["6e-3,6e-3,6e-3", "4e-3,4e-3,6e-3"],
    "refine.r_crit": ["0.02", "0.9*"], "refine.r_coarsen": ["0.3", "0.1"], "refine.energy_floor": ["0.3"], "refine.tolerance": ["0.05", "0.1"], "refine.rings": ["1"], "refine.max_level": ["2", "0"], "refine.start": ["1e-6", "0.1"],
    "refine.interval": ["2", "7"], "refine.max_particles": ["400", "200"], "crack.kind": ["symmetry", "plane"], "crack.tip": ["8.4e-3,8e-3,1e-3"], "crack.direction": ["-1.0,0.0,0.0"], "crack.normal": ["x", "z"],
    "crack.front": ["straight", "ellipse;radii=3e-3,4e-3"], "crack.center": ["2.3e-3,1.9e-3,4e-3"], "crack.radii": ["3.0e-3"], "crack.points": ["-1e-3,-1e-3,0.0,4.2e-3,-1e-3,0.0,-1e-3,4.5e-3,0.0"], "crack.name": ["q"],
    "energy_release.reference_value": ["0.9*"], "energy_release.reference": ["value;reference_value=2.0", "none;reference_value=0.0"], "energy_release.estimators": ["domain_integral", "vcct"], "probe.name": ["other"], "probe.of": ["foot"], "probe.at": ["3e-3,2e-3,5e-3"],
    "probe.quantity": ["strain", "velocity"], "output.file": ["other.h5"], "output.history_interval": ["0.5*", "0.4"], "output.snapshot_interval": ["0.5*"], "output.checkpoint_interval": ["1e-6"], "output.checkpoint_steps": ["3"],
}
# Of what solids do not do, of planes, and those that say that they do nothing; and as in planes those that act by being refused where nothing fits them
GROUPS = "growth", "cohesive", "nucleation", "control", "cycles", "contact"
REFUSED = ("run.plane", "run.thickness", "run.stop_rest", "run.stop_length", "grid.order", "body.points", "body.contact_group", "body.held", "body.toughness", "load.held", "load.face", "load.side",
           "constraint.held", "method.shape_functions", "crack.kind", "crack.length", "crack.friction", "energy_release.phase_length", "energy_release.radii",
           "energy_release.t_stress", "probe.face", "probe.tip", "probe.distance")
SOLIDS = every_key.World(SCENES, VALUES, (*every_key.NAMES, *REFUSED), GROUPS)


if __name__ == "__main__":
    every_key.main(SOLIDS, PROGRAM)
