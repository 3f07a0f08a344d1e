"""How often the errors of what growth predicts hold, and how wide they are: specimens drawn by a seed, with truth from closed forms and integrals.

  strip   a long strip between rigid grips: G = E_1 u**2/h at any length (E_1: the modulus of strain across alone); plane and, one cell thick, solid
  centre  a centre crack in a plate, K = s sqrt(pi a) (1 - 0.025 r**2 + 0.06 r**4) sqrt(sec(pi r/2)), r = a/W (Tada), to 0.1 %, which counts for the estimate;
          ways, cycles and times by integrals of it

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
TADA = 1e-3                                               # accuracy of the formula, of K


def draw(seed, k):
    """A specimen as a dictionary."""
    r = random.Random(f"{seed} {k}")
    kind = r.choice(("strip", "strip", "strip", "centre", "centre", "slab"))
    law = r.choice(("load", "cycles", "time"))
    half = 8e-3                                            # of the height of strips; of the width of plates
    cells = r.choice((6, 8, 12) if kind != "centre" else (16, 20, 28))
    s = {"kind": kind, "law": law, "plane": "strain" if kind == "slab" else r.choice(("strain", "stress")), "order": 1 if kind == "slab" else r.choice((1, 1, 2)),
         "cell": half / cells, "exponent": r.choice((2.0, 3.0, 4.0)) if law == "cycles" else r.choice((4.0, 8.0, 16.0)), "ratio": r.choice((0.0, 0.3)), "half": half,
         "levels": 0 if kind == "slab" else r.choice((0, 0, 1)), "steps": r.choice((4, 6, 9))}
    finest = s["cell"] / 2 ** s["levels"]
    s["increment"] = finest * r.choice((2.0, 2.7, 4.0))
    s["tip"] = r.uniform(-0.5, 0.5) * s["cell"] if kind != "centre" else half * r.uniform(0.25, 0.4)
    s["steps"] = max(2, min(s["steps"], int(((0.62 * half - s["tip"]) if kind == "centre" else half) / s["increment"])))
    return s


def framed(seed, k):
    """The same in a load frame: its toughness rises along the way to `rise` times that of its start."""
    s, r = draw(seed, k), random.Random(f"frame {seed} {k}")
    s |= {"law": "resistance" if s["kind"] == "centre" and r.random() < 0.5 else "arrest", "rise": r.uniform(1.5, 4.0) if s["kind"] != "centre" else r.uniform(3.0, 8.0)}
    s["far"] = s["steps"] * s["increment"]
    places = [displacement(s, x * s["far"]) for x in np.linspace(0.0, 1.2, 7)]
    if s["law"] == "arrest" and np.any(np.diff(places) < 1e-2 * places[-1]):
        s["law"] = "resistance"                            # growth is hardly stable under a given displacement
    return s


def resistance(s, x):
    """Toughness after a way [J/m2]."""
    return 10.0 * (1 + (s["rise"] - 1) * x / s["far"])


def separation(s, a):
    """Displacement of the load frame at a load factor of 1 [m]: of both grips; of both edges of a plate, whose compliance grows with the integral of G."""
    if s["kind"] != "centre":
        return 2e-6
    x = np.linspace(0.0, a, 2001)
    y = np.r_[0.0, intensity(s, x[1:]) ** 2 / modulus(s)]
    return 1e7 * 6 * s["half"] / modulus(s) + 2 / (1e7 * s["half"]) * (x[1] - x[0]) / 3 * (y[0] + 4 * y[1:-1:2].sum() + 2 * y[2:-1:2].sum() + y[-1])


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
    if s["kind"] != "centre":
        across = YOUNG / (1 - POISSON**2) if s["plane"] == "stress" else YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
        return np.sqrt(across * 1e-12 / s["half"] * modulus(s)) + 0 * np.asarray(a)
    r = np.asarray(a) / s["half"]
    return 1e7 * np.sqrt(np.pi * a) * (1 - 0.025 * r**2 + 0.06 * r**4) / np.sqrt(np.cos(np.pi * r / 2))


def rate(s, a):
    """Way in a cycle, or a second, of a law that goes on by some increments in 1000 of them [m]."""
    return s["increment"] / 1e3 * (intensity(s, a) / intensity(s, s["tip"])) ** s["exponent"]


TOUGHNESS = 1e7                                            # where growth by a rate does not end by it [J/m2]


def scene(s):
    """Its namelist."""
    h, half, solid = s["cell"], s["half"], s["kind"] == "slab"
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
    else:
        long = 8 * half                                    # of 4 heights at each side: at half of that G is 0.5 % less in plane strain
        low, upper, crack = (-long, -half), (long, half), f"kind = 'plane'  normal = 'y'  tip = {s['tip']}, 0.0{z(h / 2)}  direction = 1.0, 0.0{z(0.0)}"
        more = "\n".join(f"&constraint lower = {-long}, {y}{z(0.0)}  upper = {long}, {y}{z(h)}  fix = 'xy'  displacement = 0.0, {1e-6 * np.sign(y)}{z(0.0)} /" for y in (half, -half))
        if solid:
            more += "".join(f"\n&constraint lower = {-long}, {-half}, {x}  upper = {long}, {half}, {x}  fix = 'z' /" for x in (0.0, h))
    counts = [round((upper[d] - low[d]) / h) for d in range(2)]
    frame = {"resistance": "&control quantity = 'growth' /", "arrest": f"&control quantity = 'displacement'  displacement = {float(displacement(s, s['far']))}  "
             "history = 'ramp'  rise_time = 1.0 /" if "far" in s else ""}
    end = needed(s, s["tip"] + s["steps"] * s["increment"]) if s["law"] == "time" else 1.0
    return f"""&run end_time = {end} {'' if solid else f"plane = 's{s['plane'][1:]}'"} /
&grid lower = {low[0]}, {low[1]}{z(0.0)}  cell = {h}  cells = {counts[0]}, {counts[1]}{z(1)}  {'' if s['order'] == 1 else 'order = 2'} /
&material name = 'a'  young = {YOUNG}  poisson = {POISSON}  density = 7800 /
&body material = 'a'  lower = {low[0]}, {low[1]}{z(0.0)}  upper = {upper[0]}, {upper[1]}{z(h)}  {'' if s['order'] == 1 else 'points_per_cell = 3'} /
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
    low, high = s["tip"], s["half"] * 0.9 if s["kind"] == "centre" else s["tip"] + 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if needed(s, middle) < time else (low, middle)
    return low


def values(s, row):
    """Rows of quantity, true error, estimate and allowance for the formula, at the end; all over the value."""
    solid = s["kind"] == "slab"
    a = s["tip"] + (row["crack_area"][-1] - row["crack_area"][0]) / s["cell"] if solid else row["tip_x"][-1]
    found = []
    if s["kind"] == "centre" and a > 0.66 * s["half"]:    # it has run through
        return found

    def note(name, value, exact, error, allowance):
        found.append((name, abs(value / exact - 1), error / abs(exact), allowance if s["kind"] == "centre" else 0.0))
    k, m = float(intensity(s, a)), s["exponent"]
    if s["law"] == "load":
        note("load_factor", row["load_factor"][-1], np.sqrt(10.0 * modulus(s)) / k, row["load_factor_error"][-1], TADA)
        note("onset load", row["load_factor"][0], np.sqrt(10.0 * modulus(s)) / float(intensity(s, s["tip"])), row["load_factor_error"][0], TADA)
    elif s["law"] == "resistance":
        right = displacement(s, a - s["tip"])
        note("load", row["load"][-1], 1e7 * s["half"] * right / separation(s, a), row["load_error"][-1], TADA)
        note("load_displacement", row["load_displacement"][-1], right, row["load_displacement_error"][-1], 2 * TADA)
    elif s["law"] == "arrest":
        given = displacement(s, s["far"])
        way, there = arrested(s, given), arrested(s, (1 + 2 * TADA) * given)
        error = row["crack_area_error"][-1] / s["cell"] if solid else row["crack_length_error"][-1]
        note("arrest length", a - s["tip"], way, error, there / way - 1)
    elif s["law"] == "cycles":
        note("cycles", row["cycles"][-1], needed(s, a), row["cycles_error"][-1], m * TADA)
        if not solid:
            note("delta_K", row["delta_K"][-1], (1 - s["ratio"]) * k, row["delta_K_error"][-1], TADA)
            note("growth_rate", row["growth_rate"][-1], rate(s, a), row["growth_rate_error"][-1], m * TADA)
    else:
        time = row["time"][-1]
        note("time", time, needed(s, a), row["time_error"][-1], m * TADA)
        if not solid:
            way = place_at(s, time) - s["tip"]
            note("way", a - s["tip"], way, row["crack_length_error"][-1], m * TADA)
            note("tip_speed", row["tip_speed"][-1], rate(s, a), row["tip_speed_error"][-1], m * TADA)
    return found


def measure(seed, number, program, program3d):
    """All values, with the specimen of each."""
    rows = []
    for s in (drawn(seed, k) for drawn in (draw, framed) for k in range(number)):
        with tempfile.TemporaryDirectory() as folder:
            run = Program(program3d if s["kind"] == "slab" else program, folder)(scene(s), codes=(0, 2, 3))
            if run.code != 0:
                print(s["kind"], s["law"], "refused:", run.message.strip()[-200:])
                continue
            row = run.columns
        rows += [(len(rows), s["kind"], s["law"], s["plane"], s["order"], s["levels"], s["cell"], s["exponent"], *value) for value in values(s, row)]
    return rows + moving(seed, number // 4, program, program3d)


def table(rows):
    """Lines of the table by quantity, and by kind."""
    lines = ["| quantity | values | covered [%] | median estimate/error | median error [%] |", "|---|---|---|---|---|"]
    groups = [(f"`{name}`", [r for r in rows if r[8] == name]) for name in dict.fromkeys(r[8] for r in rows)]
    groups += [(kind, [r for r in rows if r[1] == kind]) for kind in ("strip", "centre", "slab")]
    groups += [(f"order {order}", [r for r in rows if r[4] == order]) for order in (1, 2)] + [("all", rows)]
    for name, some in groups:
        if not some:
            continue
        off, bar, more = (np.array([r[i] for r in some]) for i in (9, 10, 11))
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
    rows = measure(chosen.seed, chosen.number, program, program3d)
    if chosen.csv:
        with chosen.csv.open("w", newline="") as file:
            out = csv.writer(file)
            out.writerow("specimen kind law plane order levels cell exponent quantity error estimate allowance".split())
            out.writerows([[f"{x:.4g}" if isinstance(x, float) else x for x in r] for r in rows])
    print("\n".join(table(rows)))


if __name__ == "__main__":
    main()
