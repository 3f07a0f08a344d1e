"""How often the errors of what growth predicts hold, and how wide they are: specimens drawn by a seed, with truth from closed forms and integrals.

  strip   a long strip between rigid grips: G = E_1 u**2/h at any length (E_1: the modulus of strain across alone); plane and, one cell thick, solid
  centre  a centre crack in a plate, K = s sqrt(pi a) f(r), r = a/W, f by the series of Isida (Int. J. Fract. Mech. 7 (1971) 301), to 1e-4, which counts for the
          estimate; ways, cycles and times by integrals of it
  penny   an eighth of a penny in a cube of half side H, K = 2 s sqrt(a/pi) (1 + 1.079 r**3 - 0.981 r**5), r = a/H, the powers of free sides through finite elements
          of degree 4 with r = 0.25 and 0.4, to 5e-4

Each grows by loads that are scaled to the toughness, in load cycles (Paris) or in time (Charles), in cells of both orders and several sizes, with tips anywhere in their cells.
As many again grow along a toughness that rises: in increments, with load and displacement of the load frame, or to the length at which a given displacement lets them
arrest. A quarter as many move, or turn (`growth_specimens.py`).
Covered: the true error is within the estimate. Prints a table by quantity: covered, and the median of estimate over error.

    .venv/bin/python bench/prediction_coverage.py --seed 1 --number 120 [--csv values.csv]
"""

import argparse
import csv
import os
import random
import tempfile
from pathlib import Path

import numpy as np
from growth_specimens import moving
from program_runs import Program

YOUNG, POISSON = 200e9, 0.3
ACCURACY = {"centre": 1e-4, "penny": 5e-4}                 # of the formulas, of K
SOLID = "slab", "penny"


def draw(seed, k):
    """A specimen as a dictionary."""
    r = random.Random(f"{seed} {k}")
    kind = r.choice(("strip", "strip", "strip", "centre", "centre", "slab"))
    kind = "penny" if k % 8 == 7 else kind
    law = r.choice(("load", "cycles", "time"))
    half = 8e-3                                            # of the height of strips; of the width of plates, and of the side of cubes
    cells = r.choice({"centre": (16, 20, 28), "penny": (8, 12)}.get(kind, (6, 8, 12)))
    s = {"kind": kind, "law": law, "plane": "strain" if kind in SOLID else r.choice(("strain", "stress")), "order": 1 if kind in SOLID else r.choice((1, 1, 2)),
         "cell": half / cells, "exponent": r.choice((2.0, 3.0, 4.0)) if law == "cycles" else r.choice((4.0, 8.0, 16.0)), "ratio": r.choice((0.0, 0.3)), "half": half,
         "levels": {"slab": 0, "penny": 1}.get(kind, r.choice((0, 0, 1))), "steps": r.choice((4, 6, 9))}
    finest = s["cell"] / 2 ** s["levels"]
    s["increment"] = finest * r.choice((2.0, 2.7, 4.0))
    s["tip"] = half * r.uniform(0.25, 0.4) if kind == "centre" else half * r.uniform(0.25, 0.32) if kind == "penny" else r.uniform(-0.5, 0.5) * s["cell"]
    far = {"centre": 0.62 * half - s["tip"], "penny": 0.4 * half - s["tip"]}.get(kind, half)
    if kind == "penny":                                    # cells of the front turn with it, and it has few
        s["increment"] = s["tip"] * r.choice((0.05, 0.1))
    s["steps"] = max(2, min(s["steps"], int(far / s["increment"])))
    return s


def framed(seed, k):
    """The same in a load frame: its toughness rises along the way to `rise` times that of its start."""
    s, r = draw(seed, k), random.Random(f"frame {seed} {k}")
    stays = s["kind"] in ("strip", "slab")                 # G does, at any length
    s |= {"law": "resistance" if s["kind"] != "strip" and r.random() < 0.5 else "arrest", "rise": r.uniform(1.5, 4.0) if stays else r.uniform(3.0, 8.0)}
    s["far"] = s["steps"] * s["increment"]
    places = [displacement(s, x * s["far"]) for x in np.linspace(0.0, 1.2, 7)]
    if s["law"] == "arrest" and np.any(np.diff(places) < 1e-2 * places[-1]):
        s["law"] = "resistance"                            # growth is hardly stable under a given displacement
    return s


def resistance(s, x):
    """Toughness after a way [J/m2]."""
    return 10.0 * (1 + (s["rise"] - 1) * x / s["far"])


def separation(s, a):
    """Displacement of the load frame at a load factor of 1 [m]: of both grips; of both edges of a plate, of the end of an eighth of a cube, whose compliances grow
    with the integral of G over the area."""
    if s["kind"] not in ACCURACY:
        return 2e-6
    x = np.linspace(0.0, a, 2001)
    y = np.r_[0.0, intensity(s, x[1:]) ** 2 / modulus(s)] * (2 if s["kind"] == "centre" else np.pi / 2 * x)
    body = 1e7 * s["half"] * (6 / modulus(s) if s["kind"] == "centre" else 1 / YOUNG)
    return body + (x[1] - x[0]) / 3 * (y[0] + 4 * y[1:-1:2].sum() + 2 * y[2:-1:2].sum() + y[-1]) / whole_load(s)


def whole_load(s):
    """The load at a load factor of 1 [N], or [N/m] of plates."""
    return 1e7 * s["half"] ** (1 if s["kind"] == "centre" else 2)


def displacement(s, x):
    """At which G is the toughness after a way [m]."""
    return separation(s, s["tip"] + x) * np.sqrt(resistance(s, x) * modulus(s)) / float(intensity(s, s["tip"] + x))


def arrested(s, given):
    """The way to where the toughness is G at a displacement, by bisection."""
    low, high = 0.0, 2 * s["far"]
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if displacement(s, middle) < given else (low, middle)
    return low


def modulus(s):
    return YOUNG if s["plane"] == "stress" else YOUNG / (1 - POISSON**2)


def intensity(s, a):
    """K of a load factor of 1 [Pa sqrt(m)]."""
    if s["kind"] not in ACCURACY:
        across = YOUNG / (1 - POISSON**2) if s["plane"] == "stress" else YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
        return np.sqrt(across * 1e-12 / s["half"] * modulus(s)) + 0 * np.asarray(a)
    r = np.asarray(a) / s["half"]
    if s["kind"] == "penny":
        return 2e7 * np.sqrt(a / np.pi) * (1 + 1.079 * r**3 - 0.981 * r**5)
    return 1e7 * np.sqrt(np.pi * a) * (1 - 0.02205 * r**2 + 0.05088 * r**4 + 0.0122 * r**6) / np.sqrt(np.cos(np.pi * r / 2)) # the series, over the root


def rate(s, a):
    """Way in a cycle, or a second, of a law that goes on by some increments in 1000 of them [m]."""
    return s["increment"] / 1e3 * (intensity(s, a) / intensity(s, s["tip"])) ** s["exponent"]


TOUGHNESS = 1e7                                            # where growth by a rate does not end by it [J/m2]


def scene(s):
    """Its namelist."""
    h, half, solid, penny = s["cell"], s["half"], s["kind"] in SOLID, s["kind"] == "penny"
    z = lambda x: f", {x}" * solid
    k = float(intensity(s, s["tip"]))
    rising = f"law = 'quasi_static'  toughness = 10.0  extensions = 0.0, {2 * s.get('far', 1.0)}  extension_factors = 1.0, {2 * s.get('rise', 1.0) - 1}"
    law = {"load": "law = 'quasi_static'  toughness = 10.0", "resistance": rising, "arrest": rising,
           "cycles": f"law = 'fatigue'  rate_constant = {float(rate(s, s['tip'])) / (k * (1 - s['ratio'])) ** s['exponent']}  rate_exponent = {s['exponent']}  toughness = {TOUGHNESS}",
           "time": f"law = 'subcritical'  rate = 'charles'  speed = {float(rate(s, s['tip'])) * (np.sqrt(TOUGHNESS * modulus(s)) / k) ** s['exponent']}  rate_exponent = {s['exponent']}  "
                   f"toughness = {TOUGHNESS}"}[s["law"]]
    if s["kind"] == "centre":
        low, upper, crack = (0.0, -3 * half), (half, 3 * half), f"kind = 'plane'  normal = 'y'  tip = {s['tip']}, 0.0  direction = 1.0, 0.0"
        more = f"&constraint lower = 0.0, {-3 * half}  upper = 0.0, {3 * half}  fix = 'x' /\n&constraint lower = {half}, 0.0  upper = {half}, 0.0  fix = 'y' /"
        more += "".join(f"\n&load kind = 'traction'  lower = 0.0, {y}  upper = {half}, {y}  force = 0.0, {1e7 * half * np.sign(y)} /" for y in (3 * half, -3 * half))
    elif penny:
        low, upper, crack = (0.0, 0.0), (half, half), f"kind = 'symmetry'  normal = 'z'  front = 'disc'  center = 0.0, 0.0, 0.0  radii = {s['tip']}"
        more = "".join(f"&constraint lower = 0.0, 0.0, 0.0  upper = {', '.join(str(0.0 if d == k else half) for k in range(3))}  fix = '{'xyz'[d]}' /\n" for d in range(3))
        more += f"&load kind = 'traction'  lower = 0.0, 0.0, {half}  upper = {half}, {half}, {half}  force = 0.0, 0.0, {whole_load(s)} /"
    else:
        long = 8 * half                                    # of 4 heights at each side: at half of that G is 0.5 % less in plane strain
        low, upper, crack = (-long, -half), (long, half), f"kind = 'plane'  normal = 'y'  tip = {s['tip']}, 0.0{z(h / 2)}  direction = 1.0, 0.0{z(0.0)}"
        more = "\n".join(f"&constraint lower = {-long}, {y}{z(0.0)}  upper = {long}, {y}{z(h)}  fix = 'xy'  displacement = 0.0, {1e-6 * np.sign(y)}{z(0.0)} /" for y in (half, -half))
        if solid:                                          # a slab
            more += "".join(f"\n&constraint lower = {-long}, {-half}, {x}  upper = {long}, {half}, {x}  fix = 'z' /" for x in (0.0, h))
    counts = [round((upper[d] - low[d]) / h) for d in range(2)]
    frame = {"resistance": "&control quantity = 'growth' /", "arrest": f"&control quantity = 'displacement'  displacement = {float(displacement(s, s['far']))}  "
             "history = 'ramp'  rise_time = 1.0 /" if "far" in s else ""}
    end = needed(s, s["tip"] + s["steps"] * s["increment"]) if s["law"] == "time" else 1.0
    return f"""&run end_time = {end} {'' if solid else f"plane = 's{s['plane'][1:]}'"} /
&grid lower = {low[0]}, {low[1]}{z(0.0)}  cell = {h}  cells = {counts[0]}, {counts[1]}{z(counts[0] + 1 if penny else 1)}  {'' if s['order'] == 1 else 'order = 2'} /
&material name = 'a'  young = {YOUNG}  poisson = {POISSON}  density = 7800 /
&body material = 'a'  lower = {low[0]}, {low[1]}{z(0.0)}  upper = {upper[0]}, {upper[1]}{z(half if penny else h)}  {'' if s['order'] == 1 else 'points_per_cell = 3'} /
{more}
&crack {crack} /
&growth {law}  increment = {s['increment']}  direction = 'straight' /
{f"&cycles ratio = {s['ratio']} /" if s['law'] == 'cycles' else frame.get(s['law'], '')}
{f"&refine indicator = 'tip'  max_level = {s['levels']}  rings = 3 /" if s['levels'] else ''}
&method time = 'static'  load_steps = {s['steps'] if s['law'] not in ('time', 'arrest') else 2 * s['steps'] if s['law'] == 'time' else 4} /
&energy_release estimators = 'domain_integral' /
&output file = 'run.h5' /
"""


def needed(s, a):
    """Cycles or seconds from the first tip to a place, by Simpson's rule."""
    x = np.linspace(s["tip"], a, 2001)
    y = 1 / rate(s, x)
    return (x[1] - x[0]) / 3 * (y[0] + 4 * y[1:-1:2].sum() + 2 * y[2:-1:2].sum() + y[-1])


def place_at(s, time):
    """Where the tip is at a time, by bisection."""
    low, high = s["tip"], s["half"] * 0.9 if s["kind"] in ACCURACY else s["tip"] + 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if needed(s, middle) < time else (low, middle)
    return low


def values(s, row):
    """Rows of quantity, true error, estimate and allowance for the formula, at the end; all over the value."""
    solid = s["kind"] in SOLID
    found = []
    if s["kind"] == "penny":
        a = np.sqrt(4 * row["crack_area"][-1] / np.pi)     # as many corners as the front has, it is a disc to 1e-3
        width = np.pi / 2 * a
    elif solid:
        a, width = s["tip"] + (row["crack_area"][-1] - row["crack_area"][0]) / s["cell"], s["cell"]
    else:
        a = row["tip_x"][-1]
    if a > {"centre": 0.66, "penny": 0.45}.get(s["kind"], 9.0) * s["half"]: # it has run through
        return found

    def note(name, value, exact, error, allowance):
        found.append((name, abs(value / exact - 1), error / abs(exact), allowance * formula))
    formula = ACCURACY.get(s["kind"], 0.0)
    k, m = float(intensity(s, a)), s["exponent"]
    if s["law"] == "load":
        note("load_factor", row["load_factor"][-1], np.sqrt(10.0 * modulus(s)) / k, row["load_factor_error"][-1], 1)
        note("onset load", row["load_factor"][0], np.sqrt(10.0 * modulus(s)) / float(intensity(s, s["tip"])), row["load_factor_error"][0], 1)
    elif s["law"] == "resistance":
        right = displacement(s, a - s["tip"])
        if formula:                                        # the ends of a strip are not known
            note("load", row["load"][-1], whole_load(s) * right / separation(s, a), row["load_error"][-1], 1)
        note("load_displacement", row["load_displacement"][-1], right, row["load_displacement_error"][-1], 2)
    elif s["law"] == "arrest":
        given = displacement(s, s["far"])
        way, there = arrested(s, given), arrested(s, (1 + 2 * formula) * given)
        error = row["crack_area_error"][-1] / width if solid else row["crack_length_error"][-1]
        note("arrest length", a - s["tip"], way, error, (there / way - 1) / max(formula, 1e-30))
    elif s["law"] == "cycles":
        note("cycles", row["cycles"][-1], needed(s, a), row["cycles_error"][-1], m)
        if not solid:
            note("delta_K", row["delta_K"][-1], (1 - s["ratio"]) * k, row["delta_K_error"][-1], 1)
            note("growth_rate", row["growth_rate"][-1], rate(s, a), row["growth_rate_error"][-1], m)
    else:
        time = row["time"][-1]
        note("time", time, needed(s, a), row["time_error"][-1], m)
        way = place_at(s, time) - s["tip"]
        note("way", a - s["tip"], way, row["crack_area_error"][-1] / width if solid else row["crack_length_error"][-1], m)
        if not solid:
            note("tip_speed", row["tip_speed"][-1], rate(s, a), row["tip_speed_error"][-1], m)
    return found


def measure(seed, number, program, program3d):
    """Values as they come, each with its specimen."""
    for s in (drawn(seed, k) for drawn in (draw, framed) for k in range(number)):
        with tempfile.TemporaryDirectory() as folder:
            run = Program(program3d if s["kind"] in SOLID else program, folder)(scene(s), codes=(0, 2, 3))
            if run.code != 0:
                print(s["kind"], s["law"], "refused:", run.message.strip()[-200:])
                continue
            row = run.columns
        yield from ((s["kind"], s["law"], s["plane"], s["order"], s["levels"], s["cell"], s["exponent"], *value) for value in values(s, row))
    yield from moving(seed, number // 4, program, program3d)


def table(rows):
    """Lines of the table by quantity, and by kind."""
    lines = ["| quantity | values | covered [%] | median estimate/error | median error [%] |", "|---|---|---|---|---|"]
    groups = [(f"`{name}`", [r for r in rows if r[7] == name]) for name in dict.fromkeys(r[7] for r in rows)]
    groups += [(kind, [r for r in rows if r[0] == kind]) for kind in ("strip", "centre", "slab", "penny")]
    groups += [(f"order {order}", [r for r in rows if r[3] == order]) for order in (1, 2)] + [("all", rows)]
    for name, some in groups:
        if not some:
            continue
        off, bar, more = (np.array([r[i] for r in some]) for i in (8, 9, 10))
        covered = np.mean(off <= bar + more)
        lines.append(f"| {name} | {len(some)} | {100 * covered:.0f} | {np.median((bar + more) / np.maximum(off, 1e-12)):.1f} | {100 * np.median(off):.2f} |")
    return lines


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--number", type=int, default=120)
    options.add_argument("--csv", type=Path)
    chosen = options.parse_args()
    root = Path(__file__).resolve().parent.parent
    program, program3d = (os.environ.get(name, root / place) for name, place in (("HAMPM", "build/release/hampm"), ("HAMPM3D", "build/release3d/hampm3d")))
    rows = []
    with (chosen.csv or Path(os.devnull)).open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow("kind law plane order levels cell exponent quantity error estimate allowance".split())
        for row in measure(chosen.seed, chosen.number, program, program3d):
            rows.append(row)
            out.writerow([f"{x:.4g}" if isinstance(x, float) else x for x in row])
            file.flush()
    print("\n".join(table(rows)))


if __name__ == "__main__":
    main()
