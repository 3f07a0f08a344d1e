"""Scenes drawn at random over all features and keys together, held to what needs no reference.

    .venv/bin/python tests/fuzz/combinations.py --cases 1000 --seed 3
    .venv/bin/python tests/fuzz/combinations.py --seed 3 --first 17 --cases 1 --oracle mirror --reduce
    .venv/bin/python tests/fuzz/combinations.py --seed 52 --cases 4000 --parts 60

A scene (`drawn_scenes.py`) that is refused is repaired by the keys that the refusal names. One that runs has to pass its own oracles, which look at its result, and some
of those, drawn at random, that run it a second time as something that is known to give the same (`scene_maps.py`). A fault is printed with seed, case and oracle, with
`--reduce` with the least scene that still shows it. Exit code 1 where there is a fault. Cases are independent of each other: `--first` and `--cases` divide a seed. With `--parts N`
only scenes are run that are drawn with one of `PARTS` of which fewer than N have been accepted, and the table has a row for each of these.

What a second run may differ by is rounding: `ROUNDING` of the largest value of that kind of quantity. Where it differs by more, the scene is run once more
with its moduli, densities and loads changed by `NUDGE`: if that alone changes the result by more than `CHAOTIC` times `NUDGE`, the answer hangs on rounding, as whether two
faces touch does; such cases are counted as `chaotic` and are no faults of symmetry.
"""

import argparse
import os
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from functools import cache
from pathlib import Path

import h5py
import numpy as np
import scene_maps as maps
from drawn_scenes import copy_of, draw, group, groups, mouths, repair, text_of
from runs import ACCIDENTS

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/checked/hampm"
RELEASE = ROOT / "build/release/hampm"
REPAIRS = 15           # how often a scene is drawn anew by what its refusal names
LONGEST = 60           # that a run may take [s of processor time]
ASKED = 3              # oracles with a second run, of those that a scene can be asked
# Rounding of 1e-16 times the condition of a stiffness of some hundred nodes with cells that are cut, 1e5, over some hundred steps; the residual of `cg` is 1e-10 and
# is amplified by as much as the root of that condition
ROUNDING = 1e-7
NUDGE, CHAOTIC = 1e-11, 1e3
# What is asked of the images of scenes with cracks (`--cracked`), and by how much rounding changes what a run is given
EXACT, ROUNDED = 1e-9, 1e-13
# Particles of quadratic cells that are odd in number stand on the edges between quarters of cells, and rounding tells on which side: K and J change by some 1e-7, their
# estimated errors by more
ROUNDING_ON_EDGES = 1e-5
# Part of the largest energy or force that may be missing in a balance; of the energy where cells are cut, as what holds motions that strain no particle, with 1e-10 of
# the stiffness, is no part of it, where bodies meet, which is booked by steps, and at rest where faces or supports open and close within a load step
BALANCED, BALANCED_CUT, BALANCED_MET, BALANCED_TURNED = 1e-8, 1e-6, 1e-4, 4e-3
HARDLY = 1e-4          # of the strain that loads make at their largest: what is far below, as when they have not begun, is rounding
NEARLY_NONE = 1e-3     # of a load that stays, so that domains of J are as large as with it
MANY = 1e5             # particles times steps of a run that may be made again with steps of a twentieth or less
SETTLED_MANY = 2e6     # and of one that may be made again with springs as at rest
GAINED = 0.25          # part of the largest energy that children may have more than their parents
STILL = 1e-12          # part of the strain energy that may be in motion where all forces are in balance at the start
HAIR, HARDLY_ANY = 1e-5, 1e-3   # by what boxes end before and beyond nodes [cells], and what that may change
SLOW = 0.02            # between what a motion has settled at and the answer at rest


class Run:
    """What a run left behind."""

    def __init__(self, code, said, row=None, units=None, warnings="", data=None):
        self.code, self.said, self.row, self.units, self.warnings, self.data = code, said, row, units, warnings, data


class Fault(Exception):
    """Something that must not be."""


class Unasked(Exception):
    """An oracle that has nothing to say about this scene."""


class Chaotic(Exception):
    """A result that hangs on rounding."""


def limit_time():
    """Limits the processor time of a run, which does not hang on what else the machine does."""
    resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))


class Bench:
    """Runs scenes in a folder of its own: those that `drawing` draws, which the oracles `second` run a second time."""

    def __init__(self, program, release=RELEASE, exact=False, drawing=draw, second=None):
        self.program, self.release, self.exact, self.count, self.drawing, self.second = program, release, exact, 0, drawing, second or SECOND

    def command(self, folder, words, program=None, threads=1):
        """The end of one process; a fault where that is no end of the program's own."""
        self.count += 1
        environment = {**os.environ, "OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
        try:
            run = subprocess.run([program or self.program, *words, "--threads", str(threads)], cwd=folder, capture_output=True, text=True, errors="replace",
                                 timeout=20 * LONGEST, env=environment, preexec_fn=limit_time)
        except subprocess.TimeoutExpired:
            raise Fault(f"has not ended after {20 * LONGEST} s") from None
        if run.returncode == -signal.SIGKILL:
            raise Fault(f"has not ended after {LONGEST} s of processor time")
        said = run.stdout + run.stderr
        if run.returncode not in (0, 2, 3, 5) or any(word in said for word in ACCIDENTS):
            where = re.findall(r"at (?:\S*/)?(\w+\.f90:\d+)", said) or re.findall(r"of file (?:\S*/)?(\w+\.f90)", said)
            raise Fault(f"accident, exit code {run.returncode}, {' < '.join(where[:3])}: {' '.join(said.split())[:300]}")
        return run.returncode, run.stderr

    def run(self, scene, *options, program=None, threads=1, keep_data=False):
        """A whole run of a scene."""
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            (folder / "case.nml").write_text(text_of(scene))
            code, said = self.command(folder, ["case.nml", "--quiet", *options], program, threads)
            return self.result(folder, code, said, keep_data)

    def resumed(self, scene, stops, *changes):
        """A run that is stopped after so many steps, each time, and resumed, at last with other values of some keys."""
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            (folder / "case.nml").write_text(text_of(scene))
            words = ["case.nml"]
            for steps in stops:
                code, said = self.command(folder, [*words, "--quiet", "--steps", str(steps)])
                if code != 5:
                    return self.result(folder, code, said, True)
                words = ["--resume", "case.h5.checkpoint"]
            code, said = self.command(folder, [*words, "--quiet", *(word for change in changes for word in ("--set", change))])
            return self.result(folder, code, said, True)

    def result(self, folder, code, said, keep_data):
        """What a run left in its folder."""
        path = folder / "case.h5"
        if code in (2, 4) or not path.exists():
            return Run(code, said)
        data = {}
        with h5py.File(path) as file:
            row = {name: values[:] for name, values in file["history"].items()}
            units = {name: values.attrs["units"] for name, values in file["history"].items()}
            warnings = file["history"].attrs.get("warnings", "")
            of_life = "1" if "cycles" in row else "s"
            for name, unit in (("life", of_life), ("life_error", of_life), ("separated", "s")):
                if name in file["history"].attrs:
                    row[name], units[name] = np.full(len(row["time"]), file["history"].attrs[name]), unit
            if keep_data:
                file.visititems(lambda name, one: data.update({name: one[()]}) if isinstance(one, h5py.Dataset) and not name.startswith("input") else None)
        return Run(code, said, row, units, warnings, data)


def is_ring(scene):
    """Whether material is axisymmetric."""
    return group(scene, "run").get("plane") == "axisymmetric"


def thickness_of(scene):
    """That of the plane; around an axis the circumference in the middle of the lattice; of a solid that of the lattice."""
    grid = group(scene, "grid")
    if maps.dimensions(scene) == 3:
        return grid["cell"] * grid["cells"][2]
    return 2 * np.pi * (grid.get("lower", [0.0])[0] + grid["cell"] * grid["cells"][0] / 2) if is_ring(scene) else group(scene, "run").get("thickness", 1.0)


def natural_scales(scene, run):
    """By unit, the size that values have where stresses are those that store the energies of this run: what is far below is rounding."""
    material = group(scene, "material")
    young = max(keys.get("young", keys.get("young_1", 0.0)) for keys in groups(scene, "material") if keys["name"] != "unused")
    thickness, cell = thickness_of(scene), group(scene, "grid")["cell"]
    density = material["density"]
    energy = max(np.max(np.abs(values), initial=0.0) for name, values in run.row.items() if run.units[name] == "J")
    area = (10 * cell)**2
    free = max((abs(strain) for keys in groups(scene, "body") for strain in keys.get("eigenstrain", ())), default=0.0)
    given = [np.max(np.abs(keys[key])) / size for name, keys in scene for key, size in (
        ("force", young * thickness * 10 * cell), ("pressure", young), ("acceleration", young / (density * 10 * cell)), ("displacement", 10 * cell),
        ("velocity", np.sqrt(young / density))) if key in keys]
    given.append(free)
    energy = max(energy, thickness * area * young * (HARDLY * max(given))**2)
    stress = max(np.sqrt(energy * young / (thickness * area)), young * free)
    return {"J": energy, "J/m2": stress**2 / young * 10 * cell, "Pa m^0.5": stress * np.sqrt(10 * cell), "Pa": stress, "N": stress * thickness * 10 * cell,
            "kg m/s": np.sqrt(2 * energy * density * area * thickness), "kg m2/s": np.sqrt(2 * energy * density * area * thickness) * 10 * cell,
            "m": stress / young * 10 * cell, "m/s": stress / np.sqrt(young * density), "largest_R": 1.0, "Pa": stress, "strain": stress / young,
            "m3": stress / young * (10 * cell)**2 * thickness}


LENGTHS = "finest_cell", "tip_cell", "crack_length", "tip_x", "tip_y"


def scales(scene, run):
    """By column, by what a difference is divided."""
    natural, largest = natural_scales(scene, run), {}

    def kind(name):
        return "place" if maps.family(name) in LENGTHS else "strain" if name.startswith("strain_p") else name if run.units[name] == "1" else run.units[name]

    for name, values in run.row.items():
        if not maps.family(name).endswith("_error") and not np.any(np.isinf(values)):
            largest[kind(name)] = max(largest.get(kind(name), 0.0), np.max(np.abs(values[np.isfinite(values)]), initial=0.0))
    # An error may be many times of what it is the error of
    own = {name: np.max(np.abs(values[np.isfinite(values)]), initial=0.0) for name, values in run.row.items() if maps.family(name).endswith("_error")}
    return {name: max(largest.get(kind(name), 0.0), natural.get(kind(name), 0.0), own.get(name, 0.0), 1e-290) for name in run.row}


def differences(expected, got, scale):
    """The largest difference over its scale, and its column."""
    worst, where = 0.0, ""
    for name, values in expected.items():
        if name not in got:
            return np.inf, f"{name} is missing"
        other = got[name]
        if len(other) != len(values):
            return np.inf, f"{len(other)} in place of {len(values)} rows"
        if maps.family(name) == "mode_mixity":
            continue
        apart = np.abs(other - values)
        if maps.family(name) == "tip_angle":
            apart = np.abs((other - values + 180) % 360 - 180)
        apart[np.isnan(other) & np.isnan(values)] = 0.0  # of tips that have ended
        largest = np.max(apart, initial=0.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            value = 0.0 if largest == 0 else np.nan_to_num(largest / scale[name], nan=np.inf)  # a number in place of none
        if value > worst:
            at = int(np.nanargmax(apart)) if np.any(np.isfinite(apart)) else 0
            worst, where = value, f"{name} {other[at]:.9g} in place of {values[at]:.9g} in row {at}"
    return worst, where


def nudged(scene, chance, part=NUDGE):
    """The scene with its moduli, densities and loads changed by rounding, each its own."""
    scene = copy_of(scene)
    for name, keys in scene:
        for key in {"material": ("young", "density", "young_1", "young_2", "yield_stress", "saturation", "c01", "moduli"), **maps.LOADS}.get(name, ()):
            if key in keys:
                keys[key] = maps.scaled(keys[key], 1 + part * chance.choice([-1, 1]) * chance.uniform(0.5, 1))
    return scene


class Case:
    """A scene that has run to its end, and what its oracles need."""

    def __init__(self, bench, scene, base, chance):
        self.bench, self.scene, self.base, self.chance, self.exact, self.n = bench, scene, base, chance, bench.exact, maps.dimensions(scene)
        self.method = group(scene, "method")
        self.time, self.frame = self.method.get("time", "explicit"), self.method.get("frame", "total")
        used = {keys.get("material") for keys in groups(scene, "body")}
        self.laws = {keys.get("law", "linear_elastic") for keys in groups(scene, "material") if keys["name"] in used}
        self.indicator = group(scene, "refine").get("indicator", "none")
        self.contact = any(keys.get("contact", "none") != "none" for keys in groups(scene, "crack"))
        self.friction = any(keys.get("contact", "none") == "friction" for keys in groups(scene, "crack"))
        self.meets = group(scene, "contact").get("bodies", "bonded") != "bonded"
        self.grows = bool(groups(scene, "growth") + groups(scene, "nucleation"))
        self.push = any(keys.get("unilateral") for keys in groups(scene, "constraint"))
        self.absorbs = any(keys["kind"] == "absorbing" for keys in groups(scene, "load"))
        self.cohesion = bool(groups(scene, "cohesive"))
        self.linear = self.laws <= {"linear_elastic", "orthotropic", "viscoelastic"} and self.frame == "total" and not self.cohesion
        self.is_cut = any(keys.get("kind") == "path" for keys in groups(scene, "crack")) or any(keys.get("shape", "rectangle") != "rectangle" or keys.get("hole")
                                                                                              for keys in groups(scene, "body"))
        self.scale = scales(scene, base)

    def need(self, condition):
        """The oracle has nothing to say but where the condition holds."""
        if not condition:
            raise Unasked

    def again(self, scene, **keywords):
        """The second run, which has to end as the first one."""
        run = self.bench.run(scene, **keywords)
        if run.code != self.base.code:
            self.unless_chaotic(f"ends with {run.code}: {' '.join(run.said.split())[:300]}", 1.0)
        return run

    def same(self, expected, run, scale=None, any_order=False):
        """Holds a second run to what is expected of it."""
        on_edges = group(self.scene, "grid").get("order", 1) == 2 and any(keys.get("points_per_cell", 2) % 2 for keys in groups(self.scene, "body"))
        rounding = EXACT if self.exact else ROUNDING_ON_EDGES if on_edges else ROUNDING
        if on_edges and not self.exact:
            expected = {name: values for name, values in expected.items() if not maps.family(name).endswith("_error")}
        held = groups(self.scene, "constraint")
        if self.time == "static" and not any(keys["fix"] == "xyz"[:self.n] and not (keys.get("turns") and len(held) == 1) for keys in held):
            # Nothing says where a body is that may move as a whole, or turn around its only pin
            expected = {name: values for name, values in expected.items() if not name.startswith(("displacement_", "load_displacement_"))}
        got, scale = run.row, scale or self.scale
        if "orthotropic" in self.laws:             # K has the size of J, a root: where that is near 0 it is rounding and a half
            expected, got, scale = squares_of_k(expected), squares_of_k(got), squares_of_k(scale)
        worst, where = differences(expected, got, scale)
        if any_order and not worst <= rounding:
            worst, where = differences_in_any_order(expected, got, self.all_scales(scale))
        if not worst <= rounding:
            self.unless_chaotic(f"{where}: {worst:.1e} of its scale", worst)

    def all_scales(self, scale):
        """Scales of columns whichever tip they are of: the largest."""
        largest = {}
        for name, value in scale.items():
            largest[maps.family(name)] = max(largest.get(maps.family(name), 0.0), value)

        class ByFamily(dict):
            def __missing__(self, name):
                return largest[maps.family(name)]
        return ByFamily()

    def unless_chaotic(self, message, worst):
        """A fault, but where rounding alone makes as much."""
        for number in range(4 if self.contact or self.meets else 2):
            run = self.bench.run(nudged(self.scene, random.Random(number), ROUNDED if self.exact else NUDGE))
            if run.code != self.base.code:
                raise Chaotic(f"changed by rounding it ends with {run.code}; {message}")
            moved, where = differences(self.base.row, run.row, self.scale)
            if not moved < 0.1 * min(worst, 1.0) if self.exact else not moved <= CHAOTIC * NUDGE and not moved < 1e-3 * min(worst, 1.0):
                raise Chaotic(f"changed by rounding: {where}: {moved:.1e}; {message}")
        raise Fault(message)


def squares_of_k(row):
    """Columns with the squares, of their signs, of stress intensity factors and their errors."""
    return {name: values * abs(values) if name.startswith("K_") else values for name, values in row.items()}


def by_tip(row, families):
    """By the number of a tip its columns by their families, by 0 those of no tip."""
    tips = {0: {}}
    for name, values in row.items():
        base = maps.family(name)
        number = 0 if base not in families else 1 if base == name else int(name.rpartition("_tip")[2])
        tips.setdefault(number, {})[base] = values
    return tips


def differences_in_any_order(expected, got, scale):
    """As `differences`, of that order of the tips in which the largest difference is the least."""
    families = {maps.family(name) for name in (*expected, *got) if maps.family(name) != name}  # a tip may have more domains of J than the others
    tips, others = by_tip(expected, families), by_tip(got, families)
    rest = differences(tips.pop(0), others.pop(0), scale)
    if len(tips) != len(others):
        return np.inf, f"{len(others)} in place of {len(tips)} tips"
    apart = [[differences(tip, other, scale) for other in others.values()] for tip in tips.values()]

    @cache
    def least(first, free):
        """The least largest difference of the tips from the first on and those that are free."""
        if not free:
            return rest
        return min((max(apart[first][other], least(first + 1, free - {other}), key=worst) for other in free), key=worst)

    def worst(pair):
        return pair[0]
    return least(0, frozenset(range(len(others))))


# Oracles that look at the result of the scene itself

def of_tips_that_may_rest(case):
    """The error of load cycles where it is known to be none: from a row on by which the range of K of a tip, less its error, is no more than the threshold in a block."""
    row, keys, cycles = case.base.row, groups(case.scene, "growth"), group(case.scene, "cycles")
    threshold = max((one.get("threshold", 0.0) for one in keys), default=0.0)
    if "cycles_error" not in row or not threshold:
        return []
    ranges = [abs(top) * (1 - max(ratio, 0.0)) for top, ratio in zip(cycles.get("factors", [1.0]), cycles.get("ratios", [0.0] * len(cycles.get("factors", [1.0]))))]
    least = min(ranges) / max(ranges)
    may_rest = np.any([(row[name] - row[name.replace("delta_K", "delta_K_error")]) * least <= threshold for name in row if maps.family(name) == "delta_K"], axis=0)
    unknown = np.isnan(row["cycles_error"])
    return ["cycles_error", "life_error"] if np.all(np.logical_or.accumulate(may_rest)[unknown]) and not np.any(np.diff(unknown.astype(int)) < 0) else []


def finite(case):
    """Every number is one, but for the error of VCCT where cells divide in motion, as without J nothing is known of it, and that of load cycles where tips may rest."""
    unknown = "G_vcct" if case.indicator in ("gradient", "zz") and case.time != "static" and "J" not in case.base.row else None
    there = {name: maps.without_waiting(name, case.base.row) for name in case.base.row}
    bad = [name for name, values in there.items() if not np.all(np.isfinite(values)) and not maps.ends_with_its_tip(name, values, case.base.warnings)
           and not (unknown and name.startswith((unknown, "G_error")) and "_error" in name) and name not in of_tips_that_may_rest(case)]
    if bad:
        raise Fault(f"{bad[0]} is not finite")


def errors(case):
    """No estimated error is below nothing, the load of a frame has that of its factor, a life that of its cycles, or more where it ends after the last row."""
    row = case.base.row
    for name, values in row.items():
        if "_error" in maps.family(name) and np.any(values < 0):
            raise Fault(f"{name} {np.min(values):.6g} is below 0")
    if "load_error" in row and "load_factor_error" in row:
        apart = np.abs(row["load_error"] * row["load_factor"] - np.abs(row["load"]) * row["load_factor_error"] * np.sign(row["load_factor"]))
        if np.max(apart) > ROUNDING * np.max(np.abs(row["load"] * row["load_factor_error"]), initial=0.0):
            raise Fault("the error of the load is another one than that of its factor")
    if "life_error" in row and "cycles_error" in row and (row["life_error"][-1] < row["cycles_error"][-1] or row["life"][-1] == row["cycles"][-1] and not np.array_equal(row["life_error"][-1], row["cycles_error"][-1], equal_nan=True)):
        raise Fault(f"the error of life {row['life_error'][-1]:.6g} is not that of its cycles {row['cycles_error'][-1]:.6g}")


def energies(case):
    """The work of the loads is what is stored, moves and is taken; at rest it is that between load steps, where faces that let go on the way have another one."""
    row, names = case.base.row, ("kinetic_energy", "strain_energy", "damping_loss", "absorbed_energy", "numerical_loss", "plastic_dissipation", "viscous_dissipation", "friction_loss",
                                 "contact_loss", "fracture_energy", "cohesive_energy")
    eigenstrain = any(any(keys.get("eigenstrain", ())) for keys in groups(case.scene, "body"))
    case.need("has an error of" not in case.base.warnings and "energy has grown" not in case.base.warnings)
    booked = case.time == "implicit" and "numerical_loss" in row   # the work on what remembers is of the second order in the step
    case.need(booked or not case.laws & {"j2_plastic", "viscoelastic"})
    case.need(booked or not {"neo_hookean", "mooney_rivlin"} & set(case.laws) or case.time == "explicit")
    if case.time == "static":
        case.need(not (eigenstrain or case.friction or case.grows or np.any(row.get("cohesive_energy", 0.0))) and (case.indicator in ("none", "tip") or "numerical_loss" in row))
    elif case.time == "modal":
        case.need("numerical_loss" in row or not eigenstrain)              # of heat at once, what the modes leave out is lost
    elif case.time == "implicit":
        moved = any("velocity" in keys or "displacement" in keys for keys in groups(case.scene, "constraint"))
        stays = case.indicator in ("none", "tip") and not (case.contact or case.push or case.grows)
        case.need((booked or case.method.get("hht_alpha", 0.0) == 0.0 and stays) and not (moved and case.method.get("mass", "lumped") != "lumped"))
    else:
        case.need("numerical_loss" in row)
    inside = sum(row[name] for name in names if name in row)
    start = 0.0 if case.time == "static" else inside[0] - row["external_work"][0]
    largest = max(np.max(np.abs(row[name])) for name in (*names, "external_work") if name in row)
    young = max(keys.get("young", keys.get("young_1", 0.0)) for keys in groups(case.scene, "material"))
    cell, thickness = group(case.scene, "grid")["cell"], thickness_of(case.scene)
    case.need(largest > 1e-26 * young * thickness * (10 * cell)**2)       # else it is what rounding makes of strains
    missing = np.max(np.abs(row["external_work"] - inside + start)) / max(largest, 1e-300)
    allowed = BALANCED_TURNED if case.time == "static" and (case.contact or case.push) else BALANCED_MET if case.meets else BALANCED_CUT if case.is_cut else BALANCED
    if not missing <= allowed:
        raise Fault(f"{missing:.1e} of the energy is missing")
    if not eigenstrain and np.min(row["strain_energy"]) < -1e-9 * largest:
        raise Fault(f"strain energy {np.min(row['strain_energy']):.3g} J")


def meshes(case):
    """Explicit steps gain no energy where only the mesh changes: children take a quarter more of what the change of strain in a coarse cell stores, and of the motion."""
    row = case.base.row
    case.need(case.time == "explicit" and case.indicator in ("gradient", "zz") and "numerical_loss" in row and np.ptp(row["cells"]) > 0)
    case.need(not (case.grows or case.contact or case.push or case.meets or case.cohesion))
    largest = np.max(row["kinetic_energy"] + row["strain_energy"])
    gained = -np.min(row["numerical_loss"]) / max(largest, 1e-300)
    if gained > GAINED:
        raise Fault(f"{gained:.2g} of the energy comes from changes of the mesh")


def outline_area(keys):
    """The area of a body or hole, of a solid its volume."""
    kind = keys.get("shape", "rectangle")
    if kind == "circle":
        return np.pi * keys["radius"]**2
    if kind == "sphere":
        return 4 / 3 * np.pi * keys["radius"]**3
    if kind == "cylinder":
        return np.pi * keys["radius"]**2 * np.linalg.norm(np.subtract(keys["upper"], keys["lower"]))
    if kind == "polygon":
        x, y = np.reshape(keys["points"], (-1, 2)).T
        return abs(np.dot(x, np.roll(y, -1)) - np.dot(np.roll(x, -1), y)) / 2
    return np.prod(np.subtract(keys["upper"], keys["lower"]))


def factor(keys, time):
    """The factor of a history at times."""
    t = time - keys.get("start", 0.0)
    kind = keys.get("history", "step")
    value = np.ones_like(t)
    if kind in ("ramp", "smooth_ramp"):
        value = np.clip(t / keys["rise_time"], 0.0, 1.0)
        if kind == "smooth_ramp":
            value = value**3 * (10 - 15 * value + 6 * value**2)
    elif kind == "sine":
        value = np.sin(2 * np.pi * keys["frequency"] * t)
    elif kind == "table":
        value = np.interp(t, keys["times"], keys["factors"])
    return np.where(t < 0, 0.0, value)


def resultant(case, time):
    """The sum of all loads at times, by axis, where it is known from the scene alone."""
    scene, thickness = case.scene, thickness_of(case.scene) if case.n == 2 else 1.0
    total = np.zeros((case.n, len(time)))
    solid = [keys for keys in groups(scene, "body") if not keys.get("hole")]
    holes = [keys for keys in groups(scene, "body") if keys.get("hole")]
    density = {keys["name"]: keys["density"] for keys in groups(scene, "material")}
    for keys in groups(scene, "load"):
        if keys["kind"] == "gravity":
            case.need(not holes or len(solid) == 1)
            case.need(all({"lower", "upper"} <= set(solid[0]) and np.all(np.maximum(one["lower"], one["upper"]) <= solid[0]["upper"])
                          and np.all(np.minimum(one["lower"], one["upper"]) >= solid[0]["lower"]) for one in holes if one.get("shape") == "cylinder"))  # what is beyond has no weight
            case.need(not any("profile_density" in one for one in solid))
            area = [outline_area(one) for one in solid]
            area[0] -= sum(outline_area(one) for one in holes)
            force = np.array(keys["acceleration"]) * sum(a * density[one["material"]] for a, one in zip(area, solid)) * thickness
        elif keys["kind"] == "pressure" and (case.frame != "total" or {"neo_hookean", "mooney_rivlin"} & set(case.laws)):
            raise Unasked                                                  # it follows edges that stretch, and faces whose mouth opens
        elif keys["kind"] == "pressure" and keys.get("on") == "crack":
            force = np.zeros(case.n)
        elif keys["kind"] == "pressure" and "side" in keys:
            case.need("lower" not in keys and len(solid) == 1)
            corners = np.reshape(solid[0]["points"], (-1, 2))
            x, y = (np.roll(corners, -1, axis=0) - corners)[keys["side"] - 1]
            turn = np.sign(np.sum(np.cross(corners, np.roll(corners, -1, axis=0))))
            force = turn * keys["pressure"] * np.array([-y, x]) * thickness
        elif keys["kind"] == "pressure":
            case.need(len(solid) == 1 and not holes and solid[0].get("shape", "rectangle") == "rectangle")
            body, low, high = solid[0], np.array(keys["lower"]), np.array(keys["upper"])
            across = int(np.argmin(high - low))
            case.need(high[across] == low[across])
            inward = 1.0 if abs(low[across] - body["lower"][across]) < abs(low[across] - body["upper"][across]) else -1.0
            lengths = np.minimum(high, body["upper"]) - np.maximum(low, body["lower"])
            force = np.zeros(case.n)
            force[across] = inward * keys["pressure"] * np.prod(np.delete(lengths, across)) * thickness
        else:
            force = np.array(keys["force"])
        total += np.outer(force, factor(keys, time) * (1.0 if keys.get("held") else case.base.row.get("load_factor", 1.0)))
    return total


def forces(case):
    """At rest loads and reactions balance each other; in motion without constraints momentum changes by the loads."""
    row, scene = case.base.row, case.scene
    case.need(not case.absorbs)
    case.need(not is_ring(scene))                                          # forces along the radius have no sum
    case.need(not ((case.cohesion or case.n == 3) and any(keys.get("kind") == "symmetry" for keys in groups(scene, "crack")))) # the mirror image holds the plane, too
    time = row["time"]
    if case.time == "static":
        held = groups(scene, "constraint")
        case.need(not (PARTS["growth in time"](scene) and any(keys.get("kind") == "symmetry" for keys in groups(scene, "crack"))))  # bonded points of cut cells hold the plane, too
        case.need(held and all("name" in keys for keys in held))
        total = resultant(case, time)
        sizes = max(np.max(np.abs(total), initial=0.0), case.scale[f"reaction_{held[0]['name']}_x"])
        for d in range(case.n):
            total[d] += sum(row[f"reaction_{keys['name']}_{'xyz'[d]}"] for keys in held)
        missing = np.max(np.abs(total)) / max(sizes, 1e-300)
    else:
        case.need("momentum_x" in row and not groups(scene, "constraint") and not groups(scene, "damping"))
        case.need(all(keys.get("history", "step") == "step" and keys.get("start", 0.0) <= 0 for keys in groups(scene, "load")))
        total = resultant(case, time) * time
        sizes = max(np.max(np.abs(total), initial=0.0), case.scale["momentum_x"])
        missing = max(np.max(np.abs(row[f"momentum_{axis}"] - row[f"momentum_{axis}"][0] - total[d])) for d, axis in enumerate("xyz"[:case.n])) / sizes
    if not missing <= BALANCED:
        raise Fault(f"forces and momentum miss {missing:.1e}")


# Oracles that run the scene a second time

def isometry(q):
    def oracle(case):
        case.need(not is_ring(case.scene) or np.array_equal(q, maps.MIRROR_Y))
        case.need(all(("region_lower" in keys) == ("region_upper" in keys) for keys in groups(case.scene, "refine")))  # half a box has no image
        scene = maps.isometric(case.scene, q)
        run = case.again(scene)
        expected = maps.isometric_columns(case.base.row, q, group(case.scene, "crack").get("normal", "z") if case.n == 3 and groups(case.scene, "crack") else None)
        if case.method.get("scheme", "musl") != "musl" and any(keys["kind"] == "traction" for keys in groups(case.scene, "load")) and case.is_cut:
            # The work of the last step is a guess by the particles nearest to points of outlines, which are one of two or four where these are as near
            expected = {name: values for name, values in expected.items() if name not in ("external_work", "numerical_loss")}
        scale = {name: case.scale.get(name, 1.0) for name in expected}
        for name in scale:
            if maps.family(name) == "tip_angle":
                scale[name] = 180.0
        case.same(expected, run, scale)
    return oracle


def units(case):
    """In other units, powers of two, so that each number is the old one times its factor to the last bit."""
    chance = case.chance
    mass, length, time = 2.0 ** chance.randint(-20, 20), 4.0 ** chance.randint(-10, 10), 2.0 ** chance.randint(-20, 20)
    run = case.again(maps.in_units(case.scene, mass, length, time))
    expected = maps.in_units_columns(case.base.row, case.base.units, mass, length, time)
    scale = maps.in_units_columns({name: np.array(value) for name, value in case.scale.items()}, case.base.units, mass, length, time)
    case.same(expected, run, scale)


def bits(case):
    """In units of powers of four, of times of two, of which roots are exact too: the same bits, as no threshold has a unit. Rates of growth have powers of any exponent."""
    case.need(not any("rate_constant" in keys for _, keys in case.scene))
    for unit in ((4.0**7, 1.0, 1.0), (1.0, 4.0**5, 1.0), (1.0, 1.0, 2.0**-11)):
        run = case.again(maps.in_units(case.scene, *unit))
        expected = maps.in_units_columns(case.base.row, case.base.units, *unit)
        other = [name for name in expected if not np.array_equal(expected[name], run.row.get(name, ()), equal_nan=True)]
        if other:
            size, where = differences(expected, run.row, maps.in_units_columns({name: np.array(value) for name, value in case.scale.items()}, case.base.units, *unit))
            raise Fault(f"in units of {unit} {len(other)} of {len(expected)} columns have other bits, at most by {size:.1e}, {where}")


def thickness(case):
    """Three times as thick, under three times the forces."""
    case.need(not is_ring(case.scene))
    run = case.again(maps.thicker(case.scene, 4.0))
    scale = maps.thicker_columns(case.scale, case.base.units, 4.0)
    case.same(maps.thicker_columns(case.base.row, case.base.units, 4.0), run, scale)


def times_loads(case, factor):
    """All loads, initial velocities and eigenstrains times a factor."""
    case.need(case.linear and not (case.grows and (case.time != "static" or PARTS["growth in time"](case.scene))) and not case.meets and not groups(case.scene, "control"))
    case.need(not any(keys.get("held") for name in ("load", "constraint") for keys in groups(case.scene, name)))
    case.need("load_factor" not in case.base.row or not any(any(keys.get("eigenstrain", ())) and keys.get("held", True) for keys in groups(case.scene, "body")))
    case.need(np.all(case.base.row.get("load_factor", 0.0) != 1.0))      # at rest, where no tip grows the loads are not scaled
    run = case.again(maps.times_loads(case.scene, factor))
    expected = maps.times_loads_columns(case.base.row, case.base.units, factor)
    scale = maps.times_loads_columns({name: np.array(value) for name, value in case.scale.items()}, case.base.units, abs(factor)) if "load_factor" not in case.base.row else case.scale
    if factor < 0:                                                         # parts of some estimators have the sign of their K
        expected, run.row = ({name: abs(values) if re.match("G_.*_I+$", maps.family(name)) else values for name, values in row.items()} for row in (expected, run.row))
    case.same(expected, run, scale)


def halved(case):
    """Half of the loads."""
    times_loads(case, 0.5)


def reversed_loads(case):
    """The loads the other way: where faces may go through each other all that is linear has the other sign."""
    case.need(not (case.grows or case.contact or case.push or case.absorbs) and case.indicator in ("none", "tip"))
    times_loads(case, -1.0)


def released(case):
    """Of one tip under forces: J is what the strain energy gains with the length, by two lengths, within its bar and what such a difference is worth."""
    cracks = [keys for keys in groups(case.scene, "crack") if keys["kind"] == "path"]
    case.need(case.n == 2 and not is_ring(case.scene) and case.time == "static" and case.linear and len(groups(case.scene, "crack")) == len(cracks) == 1)
    case.need(not (case.grows or case.contact or case.push) and case.indicator == "none" and "viscoelastic" not in case.laws)
    case.need(not any("displacement" in keys or "velocity" in keys for keys in groups(case.scene, "constraint")))
    case.need(not any(any(keys.get("eigenstrain", ())) or keys.get("shape", "rectangle") != "rectangle" for keys in groups(case.scene, "body")))
    ends = [name for name in case.base.row if maps.family(name) == "J"]
    case.need(len(ends) == 1 and not any(keys["kind"] == "pressure" for keys in groups(case.scene, "load")))
    cell, length, energy = group(case.scene, "grid")["cell"], 0.5, []
    for way in (-1, 1):
        scene = copy_of(case.scene)
        keys = next(keys for keys in groups(scene, "crack"))
        x = np.array(keys["points"], float).reshape(-1, 2)
        inside = [any(np.all(x[end] > keys["lower"]) and np.all(x[end] < keys["upper"]) for keys in groups(scene, "body")) for end in (0, -1)]
        case.need(sum(inside) == 1)
        at, before = (0, 1) if inside[0] else (-1, -2)
        along = x[at] - x[before]
        case.need(np.hypot(*along) > 2 * cell)
        x[at] += way * length * cell * along / np.hypot(*along)
        keys["points"] = [float(value) for value in x.ravel()]
        run = case.bench.run(scene)
        case.need(run.code == 0)
        energy.append(run.row["strain_energy"][-1])
    j, told = case.base.row[ends[0]][-1], case.base.row[ends[0].replace("J", "J_error")][-1]
    gained = (energy[1] - energy[0]) / (2 * length * cell * thickness_of(case.scene))
    if abs(j - gained) > 3 * told + 0.2 * abs(j) + 1e-3 * energy[0] / (2 * length * cell * thickness_of(case.scene)):
        raise Fault(f"J is {j:.4g} +- {told:.2g}, the strain energy gains {gained:.4g} a length")


def order(case):
    """Groups in another order, and a material that nothing is made of."""
    run = case.again(maps.shuffled(case.scene, case.chance))
    case.same({name: values for name, values in case.base.row.items() if name != "onset_crack"}, run, any_order=True)


def reverse(case):
    """The points of each crack in the opposite order."""
    scene = maps.reversed_cracks(case.scene)
    case.need(scene is not None)
    run = case.again(scene)
    case.same(case.base.row, run, any_order=True)


def split(case):
    """A body in two that are bonded."""
    if case.time != "static" and not {"courant", "time_step"} & set(case.method):
        # By default the step, and the bonds of tips that it allows, are those of the narrowest body
        whole = copy_of(case.scene)
        if not groups(whole, "method"):
            whole.append(["method", {}])
        group(whole, "method")["courant"] = 0.02
        case.need(case.base.row["step"][-1] * np.max(case.base.row["particles"]) < MANY)
        base = case.bench.run(whole)
        case.need(base.code == case.base.code)
        case = Case(case.bench, whole, base, case.chance)      # scales, and what hangs on rounding, are those of this run
    scene = maps.split_bodies(case.scene)
    case.need(scene is not None)
    run = case.bench.run(scene)
    case.need(run.code != 2)                   # an edge of which a half only would be loaded, a crack with no body of its own
    if run.code != case.base.code:
        case.unless_chaotic(f"ends with {run.code}: {' '.join(run.said.split())[:300]}", 1.0)
    case.same(case.base.row, run)


def motion(case):
    """A velocity more of all that is free: what is seen from the body stays."""
    case.need(case.time != "static" and case.frame == "total" and not groups(case.scene, "constraint") and not groups(case.scene, "damping"))
    case.need(group(case.scene, "refine").get("field") != "speed" and not case.absorbs)
    largest = np.sqrt(2 * case.scale["kinetic_energy"] / (group(case.scene, "material")["density"] * 100 * group(case.scene, "grid")["cell"]**2))
    case.need(largest > 1e-50)
    run = case.again(maps.carried(case.scene, [0.0 if is_ring(case.scene) else float(3.0 * largest), float(-2.0 * largest), float(1.5 * largest)][:case.n]))
    keep = [name for name in case.base.row if maps.family(name) not in ("kinetic_energy", "external_work", "numerical_loss")
            and not name.startswith(("displacement_", "velocity_", "load_displacement_"))]
    case.same({name: case.base.row[name] for name in keep}, run)


def superposed(case):
    """Two parts of the loads, each by itself: what is linear adds up."""
    case.need(case.linear and not (case.grows or case.meets or case.contact or case.push) and case.indicator in ("none", "tip"))
    count = len(groups(case.scene, "load"))
    case.need(count > 0)
    chosen = case.chance.randrange(count)

    def first(name, number):
        return name == "load" and number == chosen

    parts = [maps.times_loads(case.scene, NEARLY_NONE, lambda *one: not first(*one)), maps.times_loads(case.scene, NEARLY_NONE, first)]
    runs = [case.bench.run(part) for part in parts]
    case.need(not any("almost unsupported" in one.said for one in runs))  # by a ratio of strains, which loads do not share
    runs = [case.again(part) for part in parts]
    names = [name for name in case.base.row if not maps.family(name).endswith("_error")
             and (case.base.units[name] in ("Pa m^0.5", "N", "kg m/s", "Pa", "m3") or maps.family(name) in maps.OPENINGS or name.startswith(maps.LINEAR))]
    if case.n == 3 or "orthotropic" in case.laws and any(keys["kind"] != "path" for keys in groups(case.scene, "crack")):
        names = [name for name in names if not name.startswith("K_")]  # such K, and those where fronts end on a side, have the size of J, a square
    case.need(names)
    run = Run(0, "", {name: sum(one.row[name] for one in runs) / (1 + NEARLY_NONE) for name in names}, case.base.units)
    scale = {name: max(case.scale[name], *(scales(case.scene, one)[name] for one in runs)) for name in names}
    case.same({name: case.base.row[name] for name in names}, run, scale)


def reciprocal(case):
    """Two constraints, moved one after the other: the force of each by the way of the other."""
    held = [k for k, (name, _) in enumerate(case.scene) if name == "constraint"]
    case.need(case.time == "static" and case.linear and "viscoelastic" not in case.laws and len(held) > 1 and not (case.grows or case.contact or case.push))
    case.need(case.indicator in ("none", "tip") and all("name" in case.scene[k][1] for k in held))
    cell, ways, runs = group(case.scene, "grid")["cell"], [], []
    for which in held[:2]:
        scene = [one for one in copy_of(case.scene) if one[0] not in ("load", "probe")]
        for name, keys in scene:
            if name == "body":
                keys.pop("eigenstrain", None)
            if name == "constraint":
                for key in ("displacement", "velocity", "history", "start", "rise_time", "frequency", "times", "factors"):
                    keys.pop(key, None)
                if keys["name"] == case.scene[which][1]["name"]:
                    keys["displacement"] = [part * 1e-4 * cell * (axis in keys["fix"]) for axis, part in zip("xyz"[:case.n], (1.0, 0.7, 1.3))]
                    ways.append((keys["name"], keys["displacement"]))
        runs.append(case.again(scene))
    (one, way), (other, way_of_other) = ways
    work = [sum(run.row[f"reaction_{name}_{axis}"][-1] * d[k] for k, axis in enumerate("xyz"[:case.n]))
            for run, name, d in ((runs[0], other, way_of_other), (runs[1], one, way))]
    material = group(case.scene, "material")
    size = max(abs(work[0]), abs(work[1]), *(run.row["strain_energy"][-1] for run in runs),
               material.get("young", material.get("young_1", 0.0)) * thickness_of(case.scene) * (1e-4 * cell)**2)  # where nothing is strained
    if not abs(work[0] - work[1]) <= ROUNDING * size:
        raise Fault(f"not reciprocal: {work[0]:.9g} and {work[1]:.9g} J")


def loaded_by(scene, last, history):
    """A scene at rest whose loads and motions, those at time `last`, come by a history instead."""
    scene = copy_of(scene)
    for keys in groups(scene, "load") + [keys for keys in groups(scene, "constraint") if "displacement" in keys or "velocity" in keys]:
        size = float(factor(keys, np.array([last]))[0])
        if "velocity" in keys or size == 0.0:
            raise Unasked
        for key in ("history", "start", "rise_time", "frequency", "times", "factors"):
            keys.pop(key, None)
        for key in ("force", "pressure", "acceleration", "displacement"):
            if key in keys:
                keys[key] = maps.scaled(keys[key], size)
        keys |= history
    return scene


def is_plain_rest(case):
    """Whether a scene is one at rest that motion tends to as well, and that something holds."""
    return (case.time == "static" and case.linear and "viscoelastic" not in case.laws and not (case.grows or case.friction or case.push)
            and case.indicator in ("none", "tip") and case.method.get("mass", "lumped") != "fmpm"
            and not any(any(keys.get("eigenstrain", ())) for keys in groups(case.scene, "body"))
            and any(keys["fix"] == "xyz"[:case.n] and keys["lower"] != keys["upper"] for keys in groups(case.scene, "constraint")))


def tick_of(scene):
    """The longest time that a wave takes through a cell."""
    young = min(keys.get("young", keys.get("shear_12", 0.0)) for keys in groups(scene, "material"))
    return float(group(scene, "grid")["cell"] * np.sqrt(max(keys["density"] for keys in groups(scene, "material")) / young))


def settled(case, end, method, history, damping=None):
    """Holds what is left of a motion at its end to the answer at rest."""
    # What edges cut has other penalties at rest than in explicit steps: a support on next to nothing, which a run warns of, gives way by them
    case.need(is_plain_rest(case) and "how far it gives way" not in case.base.said)
    scene = loaded_by(case.scene, case.base.row["time"][-1], history)
    group(scene, "run")["end_time"] = end
    keys = group(scene, "method")
    keys |= method
    keys.pop("load_steps", None)
    group(scene, "output")["history_interval"] = end
    group(scene, "output").pop("snapshot_interval", None)
    group(scene, "energy_release").pop("energy_balance", None)
    if damping:
        scene.append(["damping", {"rate": damping}])
    run = case.bench.run(scene)
    case.need(run.code != 2)
    if run.code:
        raise Fault(f"ends with {run.code}: {' '.join(run.said.split())[:300]}")
    case.need(run.row["kinetic_energy"][-1] < 1e-6 * run.row["strain_energy"][-1])
    full = re.search(r"Reduce &method courant from (\S+) to (\S+), which leaves them all of it", run.warnings)
    if full and "springs between faces in contact" in run.warnings:
        # Weaker springs between faces are another layer, through which closed tips let J: those of the steps that leave them as at rest are to be held to it
        case.need(run.row["step"][-1] * np.max(run.row["particles"]) * float(full[1]) / float(full[2]) < SETTLED_MANY)
        keys["courant"] = float(full[2])
        run = case.bench.run(scene)
    names = [name for name in case.base.row if name in run.row and (case.base.units[name] in ("Pa m^0.5", "N", "J/m2") and "_error" not in name
                                                                     and "spread" not in name or name == "strain_energy")]
    worst, where = differences({name: case.base.row[name][-1:] for name in names}, {name: run.row[name][-1:] for name in names}, case.scale)
    if not worst <= SLOW:
        raise Fault(f"at rest and settled in motion: {where}, {worst:.1e}")


def slow(case):
    """Implicit steps under a load that comes slowly give the answer at rest."""
    tick = tick_of(case.scene)
    settled(case, 3000 * tick, {"time": "implicit", "time_step": 30 * tick, "hht_alpha": -0.3}, {"history": "ramp", "rise_time": 1500 * tick})


def damped(case):
    """Explicit steps, damped until they rest, give the answer at rest."""
    case.need(case.method.get("mass", "lumped") in ("lumped", "consistent"))
    tick = tick_of(case.scene)
    settled(case, 400 * tick, {"time": "explicit"}, {"history": "ramp", "rise_time": 100 * tick}, 0.1 / tick)


def still(case):
    """From the static equilibrium of what stays as it is nothing ever moves."""
    case.need(case.time != "static" and case.frame == "total" and not (case.meets or case.grows or "viscoelastic" in case.laws))
    case.need(case.indicator in ("none", "tip"))        # finer cells have another equilibrium
    scene = copy_of(case.scene)
    for keys in groups(scene, "load") + groups(scene, "constraint"):
        for key in ("history", "start", "rise_time", "frequency", "times", "factors", "velocity"):
            keys.pop(key, None)
    for keys in groups(scene, "body"):
        keys.pop("velocity", None)
        keys.pop("spin", None)
    if not groups(scene, "method"):
        scene.append(["method", {}])
    group(scene, "method")["start"] = "static"
    run = case.bench.run(scene)
    case.need(run.code == 0 and run.row["strain_energy"][0] > 1e-6 * np.max(case.base.row["strain_energy"]))
    moved = np.max(run.row["kinetic_energy"]) / run.row["strain_energy"][0]
    if not moved <= STILL:
        raise Fault(f"from static equilibrium: {moved:.1e} of the strain energy comes into motion")


def finer(case):
    """Cells of half the size: J, and where cracks grow the load factor and the load cycles at the same lengths, within three times what both say of their errors."""
    case.need(case.time == "static" and "J_error" in case.base.row and case.indicator in ("none", "tip"))
    case.need(not any("contact_group" in keys for keys in groups(case.scene, "body")))
    scene = copy_of(case.scene)
    grid = group(scene, "grid")
    grid |= {"cell": grid["cell"] / 2, "cells": [2 * n for n in grid["cells"]]}
    run = case.bench.run(scene)
    case.need(run.code == 0)
    count = min(len(case.base.row["time"]), len(run.row["time"]))
    row, fine = ({name: values[:count] for name, values in one.items()} for one in (case.base.row, run.row))
    lengths = [name for name in row if maps.family(name) == "crack_length"]
    alike = np.all([np.isclose(row[name], fine.get(name, np.nan), rtol=1e-6) for name in lengths], axis=0) if case.grows and lengths else np.full(count, not case.grows)
    for name, values in row.items():
        told = name.replace(maps.family(name), f"{maps.family(name)}_error")
        if maps.family(name) in (("cycles", "load_factor") if case.grows else ("J",)) and told in row and told in fine and np.any(alike):
            off = np.where(alike, np.abs(fine[name] - values) - 3 * (fine[told] + row[told]), 0.0)
            k = int(np.argmax(off))
            if off[k] > 1e-6 * case.scale[name]:
                raise Fault(f"{name} {values[k]:.6g} +- {row[told][k]:.2g} in row {k}, with cells of half the size {fine[name][k]:.6g} +- {fine[told][k]:.2g}")


def shorter(case):
    """Growth in time by half of the increments and steps: cracks are as long at the end, within three times what both say of their errors."""
    row, keys = case.base.row, groups(case.scene, "growth")
    case.need(any(of.get("law") == "subcritical" for of in keys) and "life" not in row and not case.friction and not case.base.warnings)
    scene = copy_of(case.scene)
    least = 2 * group(scene, "grid")["cell"] / 2**(group(scene, "refine").get("max_level", 0) if case.indicator == "tip" else 0)
    for of in groups(scene, "growth"):
        of["increment"] = max(of["increment"] / 2, least)
    group(scene, "method")["load_steps"] = 2 * group(scene, "method").get("load_steps", 1)
    run = case.bench.run(scene)
    case.need(run.code == 0 and not run.warnings)
    for name in row:
        told = name.replace("crack_length", "crack_length_error")
        if maps.family(name) == "crack_length":
            tips = [tip for tip in row if maps.family(tip) == "crack_length_error"]
            bars = 3 * sum(row[tip][-1] + run.row[tip][-1] for tip in tips) + least
            if not abs(run.row[name][-1] - row[name][-1]) <= bars:
                raise Fault(f"{name} {row[name][-1]:.6g}, by shorter increments {run.row[name][-1]:.6g}, with {told} of {bars:.2g} together")


def ends(case):
    """Boxes of a support or load that end at a node, a hair before and a hair beyond: what nodes they have tells little of what they do."""
    case.need(case.time in ("static", "implicit") and not (case.cohesion or case.grows or case.meets or case.contact or case.push) and case.indicator in ("none", "tip"))
    # What flies against a support in coarse steps is stopped by one that gives way in another way than by a node that is held
    case.need(case.time == "static" or not any(any(keys.get("velocity", ())) or np.any(keys.get("spin", 0.0)) for keys in groups(case.scene, "body")))
    grid, found = group(case.scene, "grid"), []
    for number, (name, keys) in enumerate(case.scene):
        if name not in ("constraint", "load") or "side" in keys or not {"lower", "upper"} <= set(keys) or keys.get("turns") or keys.get("name") == "plane":
            continue
        wide = [d for d in range(case.n) if keys["upper"][d] - keys["lower"][d] > 1.5 * grid["cell"]]
        if name == "constraint" and len(wide) < case.n or keys.get("kind") == "body" or keys.get("kind") in ("traction", "pressure") and len(wide) < case.n:
            found += [(number, d, end) for d in wide for end in ("lower", "upper")]
    case.need(found)
    number, d, end = case.chance.choice(found)
    step, low, high, runs = grid["cell"], case.scene[number][1]["lower"][d], case.scene[number][1]["upper"][d], []
    places = grid["lower"][d] + step * np.arange(np.ceil((low - grid["lower"][d]) / step + 0.9), np.floor((high - grid["lower"][d]) / step - 0.9) + 1)
    bodies = [keys for keys in groups(case.scene, "body") if "lower" in keys]
    places = [float(x) for x in places if any(keys["lower"][d] + step / 2 < x < keys["upper"][d] - step / 2 for keys in bodies)]
    case.need(places)
    place = case.chance.choice(places)
    for hair in (-HAIR, HAIR):
        scene = copy_of(case.scene)
        scene[number][1][end] = [place + hair * grid["cell"] if k == d else x for k, x in enumerate(scene[number][1][end])]
        runs.append(case.bench.run(scene))
        case.need(runs[-1].code == 0)
    size = {name: max(scales(case.scene, one)[name] for one in runs) for name in runs[0].row}
    worst, where = differences({name: values for name, values in runs[0].row.items() if "_error" not in name and name not in ("J_domain_dependence",)}, runs[1].row, size)
    if not worst <= HARDLY_ANY:
        raise Fault(f"&{case.scene[number][0]} with {end}({d + 1}) at {place:.6g} m and a hair beyond: {where}, {worst:.1e}")


def bytes_of(case, run):
    """Holds a run to the bytes of the first one."""
    base = case.bench.run(case.scene, keep_data=True)
    if base.code != run.code:
        raise Fault(f"ends with {run.code} in place of {base.code}: {' '.join(run.said.split())[:300]}")
    for name, values in base.data.items():
        if name not in run.data or np.asarray(values).tobytes() != np.asarray(run.data[name]).tobytes():
            raise Fault(f"{name} has other bytes")


def threads(case):
    """On two threads."""
    bytes_of(case, case.bench.run(case.scene, threads=2, keep_data=True))


def reference(case):
    """By the step that is there to be read, where that can do the scene."""
    case.need(case.time == "explicit" and case.base.row["step"][-1] * np.max(case.base.row["particles"]) < 20 * MANY)
    scene = copy_of(case.scene)
    if not groups(scene, "method"):
        scene.append(["method", {}])
    group(scene, "method")["path"] = "reference"
    group(scene, "energy_release").pop("energy_balance", None)
    run = case.bench.run(scene)
    case.need(run.code != 2)
    if run.code:
        raise Fault(f"ends with {run.code}: {' '.join(run.said.split())[:300]}")
    case.same({name: values for name, values in case.base.row.items() if name in run.row}, run)


def resume(case):
    """Stopped twice and resumed."""
    steps = int(case.base.row["step"][-1])
    case.need(steps > 1)
    first = case.chance.randint(1, steps - 1)
    stops = [first] + ([case.chance.randint(1, steps - first)] if steps - first > 1 else [])
    bytes_of(case, case.bench.resumed(case.scene, stops))


def another_end(case):
    """Begun with a later end, stopped and resumed with that of the scene."""
    steps, end, output = int(case.base.row["step"][-1]), group(case.scene, "run")["end_time"], groups(case.scene, "output")
    case.need(case.base.code == 0 and steps > 1 and output and output[0].get("history_interval"))
    case.need(case.time != "implicit" or case.method.get("time_step"))    # by default it is a part of the end
    scene, changes = copy_of(case.scene), [f"run.end_time={end!r}"]
    group(scene, "run")["end_time"] = 1.5 * end
    if case.time == "static":
        load_steps = case.method.get("load_steps", 1)
        case.need(load_steps % 2 == 0)
        group(scene, "method")["load_steps"] = 3 * load_steps // 2
        changes.append(f"method.load_steps={load_steps}")
    run = case.bench.resumed(scene, [case.chance.randint(1, steps - 1)], *changes)
    if run.code != case.base.code:
        raise Fault(f"ends with {run.code} in place of {case.base.code}: {' '.join(run.said.split())[:300]}")
    case.same(case.base.row, run)


def check(case):
    """`--check` accepts what runs."""
    run = case.bench.run(case.scene, "--check")
    if run.code:
        raise Fault(f"--check ends with {run.code}: {run.said[:300]}")


def builds(case):
    """The release build."""
    case.need(case.bench.release.exists())
    case.same(case.base.row, case.again(case.scene, program=case.bench.release))


OWN = {"finite": finite, "errors": errors, "energies": energies, "meshes": meshes, "forces": forces}
SECOND = {"mirror in x": isometry(maps.MIRROR_X), "mirror in y": isometry(maps.MIRROR_Y), "quarter turn": isometry(maps.TURN), "units": units, "bits": bits, "thickness": thickness,
          "halved": halved, "reversed": reversed_loads, "released": released, "order": order, "reverse": reverse, "split": split, "motion": motion, "superposed": superposed, "reciprocal": reciprocal,
          "slow": slow, "damped": damped, "still": still, "finer": finer, "shorter": shorter, "ends": ends, "reference": reference, "threads": threads, "resume": resume,
          "another end": another_end, "check": check, "builds": builds}
IMAGES = ["mirror in x", "mirror in y", "quarter turn", "order", "reverse"]


def any_of(name, *names):
    """Whether a scene has a group of a name with one of some keys, all of which are none by default."""
    return lambda scene: any(key in keys for keys in groups(scene, name) for key in names)


def chosen(name, key, value):
    """Whether a scene has a group of a name with a value of a key."""
    return lambda scene: any(keys.get(key) == value for keys in groups(scene, name))


def ends_between_nodes(scene, name):
    """Whether a box of a group ends between nodes in a body."""
    grid = group(scene, "grid")
    return any(abs((x - low) / grid["cell"] - round((x - low) / grid["cell"])) > 1e-6 and any(body["lower"][d] < x < body["upper"][d] for body in groups(scene, "body") if "lower" in body)
               for keys in groups(scene, name) if {"lower", "upper"} <= set(keys) for end in ("lower", "upper") for d, (x, low) in enumerate(zip(keys[end], grid["lower"])))


# What is rare in scenes, and whether one has it
PARTS = {"toughness by tables": any_of("growth", "extensions", "angles", "speeds"),
         "toughness by the mix of modes": any_of("growth", "mixed_mode"),
         "`max_energy`": chosen("growth", "direction", "max_energy"),
         "criteria of branching": lambda scene: bool(groups(scene, "growth")) and group(scene, "method").get("time", "explicit") != "static",
         "load cycles": chosen("growth", "law", "fatigue"),
         "growth in time": chosen("growth", "law", "subcritical"),
         "load cycles, toughness that varies": lambda scene: PARTS["load cycles"](scene) and (PARTS["toughness by tables"](scene) or PARTS["toughness by the mix of modes"](scene)),
         "cracks that appear": lambda scene: bool(groups(scene, "nucleation")),
         "T-stress": chosen("energy_release", "t_stress", True),
         "K of interfaces": any_of("energy_release", "phase_length"),
         "graded bodies with J": lambda scene: any_of("body", "profile_at")(scene) and "domain_integral" in group(scene, "energy_release").get("estimators", ()),
         "loads on sides of polygons": any_of("load", "side"),
         "supports that end between nodes": lambda scene: ends_between_nodes(scene, "constraint"),
         "supports that end between nodes of cells that change in motion": lambda scene: (
             ends_between_nodes(scene, "constraint") and group(scene, "refine").get("indicator") in ("gradient", "zz") and group(scene, "method").get("time", "explicit") != "static"),
         "loads that end between nodes": lambda scene: ends_between_nodes(scene, "load"),
         "loads at mouths": lambda scene: any(any(abs(keys["lower"][axis] - place) + abs(keys["upper"][axis] - place) < 1e-9 and keys["lower"][1 - axis] <= mouth <= keys["upper"][1 - axis]
                                                  for keys in groups(scene, "load") if keys["kind"] in ("traction", "pressure") and {"lower", "upper"} <= set(keys))
                                              or any(keys.get("on") == "crack" for keys in groups(scene, "load")) for _, axis, place, _, _, mouth in mouths(scene)),
         "material forces": lambda scene: "material_force" in group(scene, "energy_release").get("estimators", ())}


def parts_of(scene):
    """Which parts a scene has."""
    return [name for name, has in PARTS.items() if has(scene)]


def accept(bench, chance, scene=None, wanted=()):
    """A scene that is not refused, its run, and how often it was drawn anew; None where it is refused to the end, or has lost all parts that are wanted."""
    scene = scene or bench.drawing(chance, bench.exact)
    for attempt in range(REPAIRS):
        try:
            run = bench.run(scene)
        except Fault as fault:
            return scene, fault, attempt
        if run.code != 2:
            return scene, run, attempt
        messages = [line.removeprefix("hampm: ") for line in run.said.splitlines() if line.startswith("hampm: ")]
        scene = repair(scene, messages, chance)
        if wanted and not set(wanted) & set(parts_of(scene)):
            break
    return scene, None, REPAIRS


def ask(bench, scene, base, name, seed):
    """Whether an oracle is content: 'passed', 'unasked', 'chaotic: ...', or what is wrong."""
    try:
        case = Case(bench, scene, base, random.Random(f"{seed} {name}"))
        {**OWN, **bench.second}[name](case)
    except Unasked:
        return "unasked"
    except Chaotic as reason:
        return f"chaotic: {reason}"
    except Fault as fault:
        return str(fault)
    return "passed"


def shows(bench, scene, name, seed):
    """What an oracle finds wrong with a scene, '' where nothing is."""
    try:
        base = bench.run(scene)
    except Fault as fault:
        return str(fault) if name == "run" else ""
    if name == "run" or base.code != 0:
        return ""
    found = ask(bench, scene, base, name, seed)
    return "" if found in ("passed", "unasked") or found.startswith("chaotic") else found


def reduced(bench, scene, name, seed):
    """The least scene that still shows a fault: groups, then keys, are left out one after the other."""
    scene, went = copy_of(scene), True
    while went:
        went = False
        for k in range(len(scene) - 1, -1, -1):
            if scene[k][0] not in ("run", "grid"):
                fewer = scene[:k] + scene[k + 1:]
                if shows(bench, fewer, name, seed):
                    scene, went = fewer, True
        for k, (group_name, keys) in enumerate(scene):
            for key in list(keys):
                fewer = copy_of(scene)
                del fewer[k][1][key]
                if key != "file" and shows(bench, fewer, name, seed):
                    scene, went = fewer, True
    return scene


def try_cases(bench, seed, numbers, oracles, asked=ASKED, tell=print, reduce=False, chaotic=False, fewest=0):
    """Counts by oracle and end, and the faults as (case, oracle, what, scene). `fewest` is how many scenes of each part are wanted, 0 where any will do."""
    counts, ends, faults = Counter(), Counter(), []

    def fault(number, name, what, scene):
        counts[name, "failed"] += 1
        counts.update((part, "failed") for part in parts_of(scene))
        faults.append((number, name, what, scene))
        tell(f"seed {seed} case {number} {name}: {what}")
        if reduce:
            tell(text_of(reduced(bench, scene, name, f"{seed} {number}")))

    for number in numbers:
        chance = random.Random(f"{seed} {number}")
        scene, wanted = bench.drawing(chance, bench.exact), ()
        if fewest:
            wanted = [part for part in parts_of(scene) if counts[part, "accepted"] < fewest]
            if not wanted:
                continue
            counts.update((part, "drawn") for part in parts_of(scene))
        scene, base, attempt = accept(bench, chance, scene, wanted)
        ends["drawn"] += 1
        if base is None:
            ends["refused"] += 1
            continue
        counts["run", "asked"] += 1
        if isinstance(base, Fault):
            fault(number, "run", str(base), scene)
            continue
        ends["accepted"] += 1
        counts.update((part, "accepted") for part in parts_of(scene))
        ends["accepted at once"] += attempt == 0
        if bench.exact and not groups(scene, "crack"):
            ends["without a crack"] += 1
            continue
        if base.code != 0:
            ends["stopped"] += 1
            ends["stopped: " + re.sub(r"[-+]?\d[-+.\de]*", "#", base.said.split("hampm: ")[-1])[:160].strip()] += 1
            continue
        ends["done"] += 1
        second = [name for name in bench.second if name in oracles or not oracles and name != "builds"]
        chance.shuffle(second)
        left = len(second) if oracles else asked
        for name in [name for name in OWN if not oracles or name in oracles] + second:
            if name in bench.second and left == 0:
                break
            found = ask(bench, scene, base, name, f"{seed} {number}")
            left -= name in bench.second and found != "unasked"
            if found == "unasked":
                continue
            counts[name, "asked"] += 1
            if found.startswith("chaotic"):
                counts[name, "chaotic"] += 1
                if chaotic:
                    tell(f"seed {seed} case {number} {name}: {found}")
            elif found != "passed":
                fault(number, name, found, scene)
            for part in parts_of(scene):
                counts[part, "asked"] += 1
                counts[part, "chaotic"] += found.startswith("chaotic")
    ends["runs"] = bench.count
    return counts, ends, faults


def table(counts, ends):
    """The counts as text."""
    lines = ["| oracle | asked | chaotic | failed |", "|---|---|---|---|"]
    for name in dict.fromkeys(("run", *OWN, *(name for name, _ in counts))):
        if counts[name, "asked"]:
            lines.append(f"| {name} | {counts[name, 'asked']} | {counts[name, 'chaotic']} | {counts[name, 'failed']} |")
    if any(counts[name, "drawn"] for name in PARTS):
        lines += ["", "| part | drawn | accepted | oracles asked | chaotic | failed |", "|---|---|---|---|---|---|"]
        lines += [f"| {name} | " + " | ".join(str(counts[name, what]) for what in ("drawn", "accepted", "asked", "chaotic", "failed")) + " |" for name in PARTS]
    return "\n".join([*lines, "", *(f"{name}: {count}" for name, count in ends.most_common())])


def main(bench_of=Bench, program=PROGRAM, release=RELEASE):
    parser = argparse.ArgumentParser(description=sys.modules["__main__"].__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=250, metavar="N")
    parser.add_argument("--first", type=int, default=0, metavar="N", help="number of the first case of the seed")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument("--oracle", action="append", default=[], metavar="NAME", help="ask these only, but all of them")
    parser.add_argument("--cracked", action="store_true", help=f"scenes with cracks only, of which images and other orders are to be the same to {EXACT:.0e}")
    parser.add_argument("--parts", type=int, default=0, metavar="N", help="scenes with parts of which fewer than N are accepted so far")
    parser.add_argument("--asked", type=int, default=ASKED, metavar="N", help="how many oracles with a second run a scene is asked")
    parser.add_argument("--program", type=Path, default=program, metavar="FILE")
    parser.add_argument("--release", type=Path, default=release, metavar="FILE", help="the build that oracle 'builds' compares with")
    parser.add_argument("--reduce", action="store_true", help="print the least scene that shows each fault")
    parser.add_argument("--chaotic", action="store_true", help="print the cases that hang on rounding too")
    parser.add_argument("--show", action="store_true", help="print the scenes and do not ask any oracle")
    options = parser.parse_args()
    bench = bench_of(options.program.resolve(), options.release.resolve(), options.cracked)
    if unknown := set(options.oracle) - {*OWN, *bench.second}:
        parser.error(f"no oracle {', '.join(unknown)}; there are {', '.join((*OWN, *bench.second))}")
    numbers = range(options.first, options.first + options.cases)
    if options.show:
        for number in numbers:
            print(text_of(accept(bench, random.Random(f"{options.seed} {number}"))[0]))
        return
    counts, ends, faults = try_cases(bench, options.seed, numbers, options.oracle or IMAGES * options.cracked, options.asked, lambda text: print(text, flush=True), options.reduce, options.chaotic, options.parts)
    print(table(counts, ends))
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
