#!/usr/bin/env python3
"""Whether estimated errors hold the true ones, by kind of crack, and how much larger they are: each kind is a function of scenes with values from closed forms or
tests/reference, none of which an estimate was fitted to. Prints kind, quantity, state, number, part that is covered, and the median of estimate over error.

    .venv/bin/python bench/bars_by_kind.py --program build/quick/hampm --solids build/quick3d/hampm3d peel running
"""

import cmath
import random
import sys
import tempfile
from dataclasses import dataclass, field
from math import log, pi, sqrt
from statistics import median

import numpy as np
from program_runs import Program
from tables import ROOT, command_line, write

EDGE = [0.2, 0.3, 0.4, 0.5], [1.3673, 1.6599, 2.1114, 2.8246]    # K/(sigma sqrt(pi a)) of an edge crack by a/W (Tada, Paris & Irwin)
YOUNG, POISSON = 199.992e9, 0.3


@dataclass
class Case:
    """A scene, its state or a function that tells it of each time; of each column the right values of all rows, by the columns; rows that count; how far the right ones may be off."""
    kind: str
    state: object
    scene: str
    right: dict
    counts: object = field(default=lambda row: slice(-1, None))
    doubt: float = 1e-3
    solid: bool = False


def peel():
    """Two films that are peeled apart, neo-Hookean: G = 2 (P l - W t), l and W being stretch and energy of an arm under P, in plane strain."""
    young, poisson, thick = 10e6, 0.3, 1e-3
    mu, lam = young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))

    def right(row):
        found = []
        for force in 40 * row["load_factor"]:
            low, high = 1.0, 4.0
            for _ in range(80):
                across, stretch = 1.0, (low + high) / 2
                for _ in range(60):      # no stress across the arm
                    across -= (mu * (across - 1 / across) + lam * log(stretch * across) / across) / (mu * (1 + 1 / across**2) + lam * (1 - log(stretch * across)) / across**2)
                pull = mu * (stretch - 1 / stretch) + lam * log(stretch * across) / stretch
                low, high = (stretch, high) if pull * thick < force else (low, stretch)
            j = log(stretch * across)
            found.append(2 * (force * stretch - thick * (mu / 2 * (stretch**2 + across**2 - 2 - 2 * j) + lam / 2 * j**2)))
        return np.array(found)
    for cells in (4, 6, 8):
        n, cell = 40 * cells, thick / cells
        scene = f"""&run plane = 'strain'  end_time = 2.0 /
&grid lower = 0, 0  cell = {cell}  cells = {n}, {cells} /
&material name = 'm'  law = 'neo_hookean'  young = {young}  poisson = {poisson}  density = 1000 /
&body material = 'm'  lower = 0, 0  upper = {n * cell}, {thick} /
&constraint lower = {n * cell / 2}, 0  upper = {n * cell}, 0  fix = 'y' /
&constraint lower = {n * cell}, 0  upper = {n * cell}, {thick}  fix = 'x' /
&load kind = 'traction'  lower = 0, 0  upper = 0, {thick}  force = 0, 40 /
&method time = 'static'  load_steps = 2 /
&crack kind = 'symmetry'  tip = {n * cell / 2}, 0 /
&growth law = 'quasi_static'  direction = 'straight'  toughness = 100  increment = 1e-3 /
&energy_release estimators = 'domain_integral' /
"""
        yield Case("peel", f"{cells} cells", scene, {"J": right, "load_factor": lambda row: row["load_factor"] * 100 / right(row)})


def interface():
    """A crack between two half planes: K = (1 + 2 i eps) (2 a/l)**(-i eps) sqrt(pi a) under unit tension (Rice & Sih 1965)."""
    half, e, nu = 20.0, (1e9, 3e9), (0.3, 0.2)
    along = (nu[0] / (1 - nu[0]) - nu[1] / (1 - nu[1]) * (e[0] / (1 - nu[0]**2)) / (e[1] / (1 - nu[1]**2))) * half
    mu, kappa = [m / (2 * (1 + n)) for m, n in zip(e, nu)], [3 - 4 * n for n in nu]
    eps = log((kappa[0] / mu[0] + 1 / mu[1]) / (kappa[1] / mu[1] + 1 / mu[0])) / (2 * pi)
    for level, a, kind in ((2, 1.0, "line"), (3, 1.0, "line"), (4, 1.0, "line"), (2, 1.07, "path"), (3, 0.93, "path"), (3, 1.04, "path"), (3, 1.11, "path"), (4, 0.98, "path")):
        k = (1 + 2j * eps) * cmath.exp(-1j * eps * log(2 * a / 0.5)) * sqrt(pi * a)
        bodies = "".join(f"&material name = 'm{i}'  young = {e[i]}  poisson = {nu[i]}  density = 1000 /\n"
                         f"&body material = 'm{i}'  lower = {-half}, {low}  upper = {half}, {low + half} /\n" for i, low in ((0, 0.0), (1, -half)))
        loads = "".join(f"&load kind = 'traction'  lower = {x0}, {y0}  upper = {x1}, {y1}  force = {fx}, {fy} /\n" for x0, y0, x1, y1, fx, fy in (
            (-half, half, half, half, 0.0, 2 * half), (-half, -half, half, -half, 0.0, -2 * half), (half, 0.0, half, half, along, 0.0), (-half, 0.0, -half, half, -along, 0.0)))
        scene = f"""&run plane = 'strain'  end_time = 1.0 /
&grid lower = {-half - 1}, {-half - 1}  cell = 0.5  cells = {round(4 * half) + 4}, {round(4 * half) + 4} /
{bodies}{loads}&constraint lower = {half}, 0  upper = {half}, 0  fix = 'xy' /
&constraint lower = {-half}, 0  upper = {-half}, 0  fix = 'y' /
&crack {f"kind = 'line'  tip = {a}, 0  length = {2 * a}" if kind == 'line' else f"kind = 'path'  points = {-a}, 0, {a}, 0"} /
&method time = 'static' /
&refine indicator = 'tip'  max_level = {level}  rings = 8 /
&energy_release estimators = 'domain_integral'  phase_length = 0.5 /
"""
        tip = "" if kind == "line" else "_tip2"      # at the right
        yield Case("interface", kind, scene, {f"K_I{tip}": lambda row, k=k: np.array([k.real]), f"K_II{tip}": lambda row, k=k: np.array([k.imag])}, doubt=1.5e-3)


def fatigue():
    """An edge crack that grows from 0.2 to 0.4 of the width by Paris' rate, of which the integral of the handbook's K tells the cycles."""
    form = np.polyfit(EDGE[0], np.log(EDGE[1]), 3)

    def k_at(a):
        return np.exp(np.polyval(form, a / 0.04)) * 80e6 * np.sqrt(pi * a)

    def cycles(row, m):
        a = np.linspace(row["crack_length"][0], row["crack_length"][-1], 4001)
        rate = 1 / (1e-9 * (k_at(a) / 20e6)**m)
        return np.array([np.sum(rate[1:] + rate[:-1]) / 2 * (a[1] - a[0])])
    for order, m, y, start in ((1, 3.0, 1e-4, 8e-3), (2, 3.5, 1e-4, 8e-3), (2, 2.5, 0.0, 8e-3), (1, 3.0, 0.0, 8e-3), (2, 3.0, 7e-5, 8.3e-3), (1, 4.0, 1.6e-4, 7.9e-3)):
        scene = f"""&run plane = 'stress'  thickness = 0.01  end_time = 8.0 /
&grid lower = -0.002, -0.062  cell = 0.002  cells = 23, 62  order = {order} /
&material name = 's'  young = 200e9  poisson = 0.3  density = 7850 /
&body material = 's'  lower = 0, -0.06  upper = 0.04, 0.06  points_per_cell = {order + 1} /
&load kind = 'traction'  lower = 0, 0.06  upper = 0.04, 0.06  force = 0, 32000 /
&load kind = 'traction'  lower = 0, -0.06  upper = 0.04, -0.06  force = 0, -32000 /
&constraint lower = 0.04, -0.06  upper = 0.04, -0.06  fix = 'xy' /
&constraint lower = 0.04, 0.06  upper = 0.04, 0.06  fix = 'x' /
&crack kind = 'path'  points = -0.001, {y}, {start}, {y} /
&growth law = 'fatigue'  direction = 'straight'  increment = 1e-3  rate_constant = {1e-9 / 20e6**m}  rate_exponent = {m} /
&method time = 'static'  load_steps = 8 /
&refine indicator = 'tip'  max_level = 2  rings = 6 /
&energy_release estimators = 'domain_integral' /
"""
        yield Case("fatigue", f"order {order}", scene, {"cycles": lambda row, m=m: cycles(row, m), "K_I": lambda row: k_at(row["crack_length"])[-1:]})


def running():
    """A half plane crack under plane waves of 1 MPa that runs from 1.5 H/c_d on (Freund): K = k(v) K(t, 0), G = A(v) K**2 (1 - nu**2)/E."""
    table = np.array([line.split(",") for line in (ROOT / "tests/reference/growth/c1_universal_nu0.30_strain.csv").read_text().splitlines() if line[0].isdigit()], float)
    density, way = 5000.0, 10e-3
    shear = sqrt(YOUNG / (2 * (1 + POISSON)) / density)
    fast = shear * 1.87082869339

    def k_of(row, speed):
        time = np.maximum(row["time"] - way / fast, 0.0)
        at_rest = 2e6 / (1 - POISSON) * np.sqrt(fast * time * (1 - 2 * POISSON) / pi)
        return np.where(row["time"] >= 1.5 * way / fast, np.interp(speed, table[:, 0], table[:, 3]), 1.0) * at_rest
    for mass, speed, n in (("mass = 'weighted'", 0.0, 25), ("mass = 'weighted'", 0.3, 25), ("mass = 'weighted'", 0.6, 25), ("mass = 'lumped'", 0.3, 25),
                           ("mass = 'lumped'", 0.6, 25), ("mass = 'consistent'", 0.45, 25), ("time = 'implicit'", 0.4, 25), ("mass = 'weighted'", 0.5, 50)):
        h, end = way / n, 2.9 * way / fast
        edge = lambda y, force: f"&load kind = 'traction'  lower = {-way}, {y}  upper = {way}, {y}  force = 0.0, {force} /\n"
        roller = lambda x: f"&constraint lower = {x}, {-way}  upper = {x}, {way}  fix = 'x' /\n"
        scene = f"""&run plane = 'strain'  end_time = {end} /
&grid lower = {-way}, {-way - h}  cell = {h}  cells = {2 * n}, {2 * n + 2} /
&material name = 's'  young = {YOUNG}  poisson = {POISSON}  density = {density} /
&body material = 's'  lower = {-way}, {-way}  upper = {way}, {way} /
{roller(-way)}{roller(way)}{edge(way, 10e3)}{edge(-way, -10e3)}&method {mass} /
&crack kind = 'path'  points = {-way}, 0, {0.0 if speed else 0.3 * h}, 0 /
{f"&growth law = 'prescribed'  speed = {speed * shear * 0.927412709703}  start = {1.5 * way / fast}  direction = 'straight' /" if speed else ""}
&energy_release estimators = 'domain_integral' /
&output history_interval = {end / 250} /
"""
        first = 1.5 * way / fast + 8 * h / shear if speed else way / fast + 4 * h / shear
        share = np.interp(speed, table[:, 0], table[:, 4])
        yield Case("running", mass.split("'")[1] if speed else "under a wave", scene,
                   {"K_I": lambda row, v=speed: k_of(row, v), "G": lambda row, v=speed, a=share: a * k_of(row, v)**2 * (1 - POISSON**2) / YOUNG},
                   lambda row, first=first: row["time"] > first, 0.0)


def meeting():
    """Two bars that meet: the force is v A/(1/(rho_1 c_1) + 1/(rho_2 c_2)) while waves go to their ends and back."""
    length, high, speed = 0.05, 0.006, 10.0
    for state, young, density, contact, cell in (("alike", (200e9, 200e9), (7800, 7800), "'frictionless'", 1e-3), ("softer", (200e9, 70e9), (7800, 2700), "'frictionless'", 1e-3),
                                                 ("friction", (70e9, 200e9), (2700, 7800), "'friction'  friction = 0.3", 1e-3), ("finer", (200e9, 70e9), (7800, 2700), "'frictionless'", 0.5e-3)):
        waves = [sqrt(e / d) for e, d in zip(young, density)]
        force = speed * high / sum(1 / (d * c) for d, c in zip(density, waves))
        n = round(2.1 * length / cell)
        scene = f"""&run plane = 'stress'  end_time = {1.9 * length / max(waves)} /
&grid lower = {-length - 2 * cell}, {-high / 2 - cell}  cell = {cell}  cells = {n}, {round(high / cell) + 2} /
&material name = 'a'  young = {young[0]}  poisson = 0.0  density = {density[0]} /
&material name = 'b'  young = {young[1]}  poisson = 0.0  density = {density[1]} /
&body material = 'a'  lower = {-length}, {-high / 2}  upper = 0, {high / 2}  velocity = {speed}, 0 /
&body material = 'b'  lower = 0, {-high / 2}  upper = {length}, {high / 2} /
&method frame = 'updated' /
&contact bodies = {contact} /
&output history_interval = {0.005 * length / max(waves)} /
"""
        yield Case("meeting", state, scene, {"contact_force_x": lambda row, force=force: np.full(len(row["time"]), force)},
                   lambda row, first=0.4 * length / max(waves): row["time"] > first, 0.0)


def fronts():
    """Means along fronts: a penny and an ellipse in blocks, the double cantilever beam of square arms; finite elements of degree 4 and 5."""
    sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "tests/program"), str(ROOT / "postprocess")]
    from test_fronts import PLATE, UNIT, cracked_beam, penny
    from test_solid import G_REF
    from test_solid_cracks import part
    tip = "&refine indicator = 'tip'  max_level = {}  rings = {} /".format
    ellipse = {"front": "'ellipse'", "center": (0.0, 0.0, 0.0), "radii": [2.0, 1.0]}
    for state, scene, right in (
            *((f"penny, {2 * n:.0f} cells", penny(n), (1.059 * UNIT)**2 * 0.91) for n in (3.2, 4, 6)),
            ("penny, 8 cells", penny(4, side=4), (1.0159 * UNIT)**2 * 0.91),
            ("ellipse", part((6, 4, 5), 4, dict(ellipse), refine=tip(1, 2)), 1.644466 / 0.9988**2), ("ellipse", part((6, 4, 5), 4, dict(ellipse), refine=tip(2, 4)), 1.644466 / 0.9988**2),
            ("beam", cracked_beam(1.25e-3), 1.28321 * G_REF), ("beam", cracked_beam(1.25e-3, tip(1, 3)), 1.28321 * G_REF), ("plate", PLATE, 0.99262 * 0.5293609)):
        text = scene if "&energy_release" in scene else scene + "&energy_release estimators = 'domain_integral', 'vcct' /\n"
        yield Case("front", "mean", text, {"G_mean": lambda row, right=right: np.array([right]), "G_vcct_I": lambda row, right=right: np.array([right])}, doubt=3e-4, solid=True)


def universal(young, poisson, density, plane, mode):
    """Speeds below that of Rayleigh waves, k and A of these (Freund 1990, sections 5.3 and 6.4), speeds of pressure and shear waves, E' and nu' of the plane."""
    ratio = poisson if plane == "strain" else poisson / (1 + poisson)
    shear = sqrt(young / (2 * (1 + poisson)) / density)
    fast = shear * sqrt(2 * (1 - ratio) / (1 - 2 * ratio))
    root = lambda v, c: np.sqrt(1 - (v / c)**2)
    zero = lambda v: 4 * root(v, fast) * root(v, shear) - (1 + root(v, shear)**2)**2
    low, high = 0.5 * shear, (1 - 1e-12) * shear
    for _ in range(60):
        low, high = ((low + high) / 2, high) if zero((low + high) / 2) > 0 else (low, (low + high) / 2)
    speed = np.linspace(1e-4, 0.98, 99) * low
    angle = (np.arange(400) + 0.5) * pi / 800
    a, b = 1 / fast, 1 / shear
    e = a + (b - a) * np.sin(angle)**2
    part = np.arctan2(4 * e**2 * np.sqrt((e**2 - a**2) * (b**2 - e**2)), (b**2 - 2 * e**2)**2) * (b - a) * np.sin(2 * angle) * pi / 800
    k = (1 - speed / low) / np.sqrt(1 - speed / (fast if mode == 1 else shear)) * np.exp(np.sum(part / (1 / speed[:, None] - e), axis=1) / pi)
    share = speed**2 * root(speed, fast if mode == 1 else shear) / ((1 - ratio) * shear**2 * zero(speed))
    return speed, k, share, fast, shear, young / (1 - poisson**2) if plane == "strain" else young, ratio, low


def motion(seeds=range(900, 912)):
    """Drawn cracks under a plane wave of opening or shear: at rest, at a given speed, that stop, and by a constant toughness; in cells, planes, masses, frames and steps of any
    kind. While nothing comes back from sides K = k(v) K(t, 0), G = A(v) K**2/E', and by the toughness g(v) K(t, 0)**2/E' is that."""
    for seed in seeds:
        draw = random.Random(seed)
        plane, poisson, young, density = draw.choice(["strain", "strain", "stress"]), draw.uniform(0.05, 0.4), 10**draw.uniform(9, 11.4), draw.uniform(1000, 8000)
        mode, n, half, law = draw.choice([1, 1, 1, 2]), draw.choice([20, 25, 32]), 10**draw.uniform(-3, 0), draw.choice(["rest", "rest", "given", "given", "stops", "toughness"])
        law = "given" if mode == 2 and law == "toughness" else law
        speeds, k, share, fast, shear, modulus, ratio, wave = universal(young, poisson, density, plane, mode)
        cell, arrival, stress = half / n, half / (fast if mode == 1 else shear), 1e-5 * young
        start, given = arrival + draw.uniform(0.15, 0.5) * half / fast, draw.uniform(0.05, 0.65) * wave
        end = arrival + (1.9 if law == "rest" else 1.5) * half / fast
        stop = start + 0.4 * (end - start) if law == "stops" else end
        at_rest = lambda t, c=half / arrival, a=arrival, s=2 * stress * shear * sqrt(2 / pi / (1 - ratio)): s * np.sqrt(np.maximum(t - a, 0) / c)
        toughness = float(at_rest(np.array(start))**2 / modulus)

        def speed_at(t, law=law, start=start, stop=stop, given=given, toughness=toughness, at_rest=at_rest, modulus=modulus, g=share * k**2, speeds=speeds):
            if law == "toughness":
                return np.where(t > start, np.interp(toughness * modulus / np.maximum(at_rest(t)**2, toughness * modulus), g[::-1], speeds[::-1]), 0.0)
            return np.where((t > start) & (t < stop) & (law != "rest"), given, 0.0)

        def right(row, power, of_speed, speed_at=speed_at, at_rest=at_rest, speeds=speeds, modulus=modulus):
            return np.where(speed_at(row["time"]) > 0, np.interp(speed_at(row["time"]), speeds, of_speed), 1.0) * at_rest(row["time"])**power / (1 if power == 1 else modulus)

        def state(t, law=law, start=start, stop=stop, settle=8 * cell / shear, arrival=arrival, early=4 * cell / shear):
            if t < arrival + early:
                return "as the wave comes"
            if law == "rest" or t < start:
                return "at rest"
            if t < stop:
                return "by toughness" if law == "toughness" else "first cells" if t < start + settle else "runs"
            return "after it stops"
        growth = {"rest": "", "toughness": f"&growth law = 'toughness'  toughness = {toughness}  direction = 'straight' /"}.get(
            law, f"&growth law = 'prescribed'  speed = {given}  start = {start}  end = {2 * end if law == 'given' else stop}  direction = 'straight' /")
        method = draw.choice([f"mass = '{m}'  frame = '{f}'" for m in ("weighted", "lumped", "consistent") for f in ("total", "updated")] + [f"time = 'implicit'  time_step = {0.6 * cell / fast}"])
        tip = draw.choice([0.0, draw.uniform(0.1, 0.9)]) * cell if law == "rest" else 0.0
        force = lambda sign: f"{0.0 if mode == 1 else sign * stress * half}, {sign * stress * half if mode == 1 else 0.0}"
        edges = "".join(f"&load kind = 'traction'  lower = {-half}, {s * half}  upper = {half}, {s * half}  force = {force(s)} /\n" for s in (1, -1))
        sides = "".join(f"&constraint lower = {x}, {-half}  upper = {x}, {half}  fix = '{'xy'[mode - 1]}' /\n" for x in (-half, half))
        scene = f"""&run plane = '{plane}'  end_time = {end} /
&grid lower = {-half}, {-half - cell}  cell = {cell}  cells = {2 * n}, {2 * n + 2} /
&material name = 's'  young = {young}  poisson = {poisson}  density = {density} /
&body material = 's'  lower = {-half}, {-half}  upper = {half}, {half} /
{edges}{sides}&method {method} /
&crack kind = 'path'  points = {-half}, 0, {tip}, 0 /
{growth}
&energy_release estimators = 'domain_integral' /
&output history_interval = {end / 150} /
"""
        yield Case("motion", state, scene, {"K_" + "I" * mode: lambda row, right=right, k=k: right(row, 1, k), "G": lambda row, right=right, g=share * k**2: right(row, 2, g)},
                   lambda row, first=arrival + 2 * cell / shear: row["time"] > first, 0.0)


KINDS = {function.__name__: function for function in (peel, interface, fatigue, running, motion, meeting, fronts)}


def rows_of(case, program):
    """(kind, column, state, covered, estimate over error) of each value, or what a run says that ends."""
    with tempfile.TemporaryDirectory() as folder:
        done = Program(program, folder)(case.scene, codes=range(256))
        if done.code:
            return f"exit {done.code}: {done.message[-300:]}"
        row = done.columns
    rows = []
    for column, right in case.right.items():
        name, _, tip = column.partition("_tip")
        estimate = row.get(f"{name}_error" + (f"_tip{tip}" if tip else ""))
        which = case.counts(row)
        value, known = row[column][which], np.asarray(right(row))
        known = known[which] if len(known) > 1 else known
        off = np.abs(np.abs(value) - np.abs(known))
        size, bars = np.abs(known) * case.doubt, (np.full(len(off), np.nan) if estimate is None else estimate[which])
        states = [case.state] * len(off) if isinstance(case.state, str) else [case.state(t) for t in row["time"][which]]
        rows += [(case.kind, name, state, bool(o <= b + s), float(b / max(o, s, 1e-300))) for o, b, s, state in zip(off, bars, size, states)]
    return rows


def summary(rows):
    """Rows of the table: by kind, quantity and state."""
    groups = {}
    for row in rows:
        groups.setdefault(row[:3], []).append(row)
    return [[*key, len(group), f"{100 * sum(r[3] for r in group) / len(group):.0f}", f"{median(r[4] for r in group):.1f}"] for key, group in groups.items()]


def main():
    arguments = command_line(__doc__, list(KINDS), "results/bars", solids=(ROOT / "build/release3d/hampm3d", "the program for solids"))
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in arguments.part:
        for case in KINDS[name]():
            found = rows_of(case, str((arguments.solids if case.solid else arguments.program).resolve()))
            if isinstance(found, str):
                print(f"{case.kind}, {case.state}: {found}", flush=True)
            else:
                rows += found
    write([["kind", "quantity", "state", "values", "covered [%]", "median estimate/error"], *summary(rows)], "bars_by_kind", arguments.output)


if __name__ == "__main__":
    main()
