"""Whether runs that choose their mesh by &accuracy reach the errors that are asked, and what they cost over the best mesh chosen by hand.

    .venv/bin/python bench/accuracy.py --seed 1 --cases 60 [--program build/release/hampm] [--targets 0.03,0.01] [--most 20] [--best] [--csv FILE]
    .venv/bin/python bench/accuracy.py --fit [--solids]
    .venv/bin/python bench/accuracy.py --solids --seed 1 --cases 40 [--program build/release3d/hampm3d]

Models are those of the second opinion (tests/second_opinion), at rest, drawn at random without lattice, order and refinement. The truth is that of its finite elements, which share
nothing with hampm. The quantity is the largest K_I or K_II of all tips. With --best the cheapest of all meshes of a table that keeps within the error asked,
judged by the truth and by those finer than it, is found too; both costs are processor times of whole processes. Runs longer than --most seconds of the processor are stopped and count as
missed. Models whose pins end at nodes of the lattice that is left out are not taken: they are others without it.

With --solids models are boxes with one crack (solid_fronts.py), at rest. Their truth is the limit of three much finer meshes, and the quantity G_mean of the
front. A target is asked where the truth is known to a quarter of it.

With --fit the constants of work of src/accuracy/families.f90 and mesh_trials.f90 are measured: what a particle costs in runs of a beam whose cells are halved
and whose rows are ten times as many, over what it costs in an explicit step of bilinear cells, which is 1.5 by definition.
"""

import argparse
import csv
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import f90nml
import numpy as np
from program_runs import Program
from solid_fronts import drawn_solid, truth_of_solid

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/second_opinion"))

from opinion_compare import answers  # noqa: E402
from opinion_scene import Outside, read  # noqa: E402
from trial import drawn  # noqa: E402

TARGETS = (0.03, 0.01, 0.003, 0.001)
SOLID_TARGETS = TARGETS[:2]
QUANTITIES = ("K_I", "K_II")
ORDER = 4
FAMILIES = [(2, levels, 3) for levels in (0, 2, 4, 6, 8, 10)] + [(1, levels, 4) for levels in (0, 2, 4, 6, 8)]   # order, levels, rings
STOPPED = (-24, -9)                 # exit codes of programs at their limit of time
MOST_BY_HAND = 10                   # seconds of a mesh
CELLS = (1, 2, 3, 4, 6, 8)          # number of the lattice over that of the coarsest


def bare(path):
    """The model of a file without lattice, order, refinement, radii and points of cells: what &accuracy chooses."""
    model = f90nml.read(path)
    for name in ("grid", "refine"):
        model.pop(name, None)
    for name, keys in (("body", ("points_per_cell",)), ("energy_release", ("radii", "estimators")), ("method", ("solver", "mass", "order", "lumped_fraction", "courant"))):
        for group in model.get(name, []) if isinstance(model.get(name), list) else [model[name]] if name in model else []:
            for key in keys:
                group.pop(key, None)
    model.get("output", {}).pop("snapshot_interval", None)
    return model


def written(model, path, quantity, error):
    """The same with what is asked of it, in a file."""
    model = model.copy()
    model["accuracy"] = {"quantity": quantity, "error": error}
    path.unlink(missing_ok=True)
    f90nml.write(model, path)


def asked_of(found):
    """What is asked: K_I or K_II of the tip where it is the largest, and its truth; None where there is none that is known to 0.01 %."""
    known = {name: pair for name, pair in found.items() if name.split("_tip")[0] in QUANTITIES}
    if not known:
        return None
    name = max(known, key=lambda key: abs(known[key][0]))
    value, error = known[name]
    return (name, value) if error < 1e-4 * abs(value) else None


def truth_of(path):
    """Values and errors of columns by finite elements."""
    found, _ = answers(read(path), ORDER)
    return {name: (row[1], row[2]) for name, row in found.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--program", type=Path)
    parser.add_argument("--solids", action="store_true")
    parser.add_argument("--targets", default=",".join(map(str, TARGETS)))
    parser.add_argument("--most", type=float, default=0.0)
    parser.add_argument("--best", action="store_true")
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--fit", action="store_true")
    parser.add_argument("--least", type=float, default=0.0, metavar="P", help="exit code 1 where fewer models than P percent keep within an error that is asked")
    options = parser.parse_args()
    options.program = options.program or ROOT / ("build/release3d/hampm3d" if options.solids else "build/release/hampm")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        program = Program(limited(options.program, options.most, folder) if options.most else options.program, folder)
        targets = [float(error) for error in options.targets.split(",")]
        if options.fit:
            fit(program, 3 if options.solids else 2)
            return
        for number in range(options.first, options.first + options.cases):
            drawn_at = folder / "drawn.nml"
            if options.solids:
                rows += judged_solid(program, random.Random(f"{options.seed} {number}"), drawn_at, number)
                continue
            if not drawn(random.Random(f"{options.seed} {number}"), drawn_at, options.program):
                continue
            try:
                if any(hold.snapped for hold in read(drawn_at).holds):
                    continue
                asked = asked_of(truth_of(drawn_at))
            except Exception as reason:  # noqa: BLE001: the mesher and the solver have errors of their own
                if not isinstance(reason, Outside):
                    print(f"{number}: {type(reason).__name__}")
                continue
            if asked is None:
                continue
            rows += judged(program, bare(drawn_at), folder / "asked.nml", number, *asked, options.best, targets)
    least = tell(rows, targets)
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
    if least < options.least / 100:
        sys.exit(f"{least:.1%} of the models within an error, {options.least:g} % asked")


def limited(program, most, folder):
    """A command that runs a program for so many seconds of the processor at most."""
    path = folder / "limited"
    path.write_text(f'#!/bin/sh\nulimit -t {most:.0f}\nexec "{program.resolve()}" "$@"\n')
    path.chmod(0o755)
    return path


BEAM = """&run plane = 'stress'  thickness = 0.01  end_time = {end} /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700.0 /
&body material = 'a'  lower = {zero}  upper = {upper}  points_per_cell = {points} /
&constraint lower = 0.05, 0.0{side}  upper = 0.1, 0.0{width}  fix = 'y' /
&load kind = 'traction'  lower = {zero}  upper = 0.0, 0.01{width}  force = 0.0, 1.0{side} /
&crack kind = 'symmetry'  {normal}  tip = 0.05, 0.0{side} /
&energy_release estimators = 'domain_integral' /
&method time = '{time}'  mass = '{mass}' /
&refine indicator = 'tip'  max_level = 1  rings = {rings} /
&grid lower = {lower}  cell = {cell}  cells = {cells}  order = {order} /
&output file = 'run.h5'  history_interval = {interval} /
"""
RUNS = {"static": (10, 20, 1.0), "explicit": (6, 12, 1e-4), "modal": (4, 8, 1e-3), "implicit": (4, 8, 1e-4)}    # cells in the height of the beam, end


def fit(program, dim):
    """Prints what a particle costs by family, and in a row of the history."""
    found, rows = {}, []
    for time, (coarse, fine, end) in RUNS.items():
        for order, mass in ((1, "auto"), (2, "auto"), *([(1, "weighted")] if time == "explicit" else [])):
            try:
                small, large, many = (cost(program, dim, time, order, mass, cells // (dim - 1), end, samples)
                                      for cells, samples in ((coarse, 10), (fine, 10), (fine, 10 if time == "static" else 100)))
            except Refused as refused:
                print(f"{time}, order {order}, {mass}: {refused}")
                continue
            if time != "static":
                rows.append((many[0] - large[0]) / (90 * many[1]))
            found[time, order, mass] = (large[0] - small[0]) / (large[2] - small[2])
            print(f"{time}, order {order}, {mass}: {small[0]:.3f}, {large[0]:.3f} and {many[0]:.3f} s", flush=True)
    unit = found["explicit", 1, "auto"] / 1.5
    print("\n| steps | order | masses | work |\n|---|---|---|---|")
    for (time, order, mass), of_particle in found.items():
        print(f"| {time} | {order} | {mass} | {of_particle / unit:.2g} |")
    print(f"| a row | | | {np.median(rows) / unit:.2g} |\n\nthe unit is {unit * 1e6:.2g} us here")


class Refused(Exception):
    """The program does not take a model."""


def cost(program, dim, time, order, mass, cells, end, samples):
    """Seconds of a run, its particles, and its work by the formula of mesh_trials.f90 without the constant."""
    solid, h = dim == 3, 0.01 / cells
    text = BEAM.format(end=end, points=order + 1, time=time, mass=mass, rings=5 - order, cell=h, order=order, interval=end / samples, zero=", ".join(["0.0"] * dim),
                       upper="0.1, 0.01" + ", 0.01" * solid, side=", 0.0" * solid, width=", 0.01" * solid, normal="normal = 'y'" if solid else "",
                       lower=", ".join([repr(-h)] * dim), cells=", ".join(map(str, [10 * cells + 2] + [cells + 2] * (dim - 1))))
    if time == "implicit":
        text = text.replace("'implicit'", f"'implicit'  time_step = {h / 5908}")
    run = program(text, codes=(0, 2), turns=3)
    if run.code:
        raise Refused(run.message.splitlines()[0])
    n, steps = run.last["particles"], end * 5908 / h     # of a dilatational wave
    return run.seconds, n, n * {"explicit": 2 * steps, "implicit": steps}.get(time, np.log(n) * n ** ((dim - 2) / 3))


def judged_solid(program, chance, path, number):
    """The same of a solid."""
    kind, text = drawn_solid(chance)
    path.write_text(text + "&accuracy quantity = 'G_mean'  error = 0.99 /\n&refine indicator = 'tip'  rings = 4  max_level = 2 /\n")     # the coarsest lattice
    explained = subprocess.run([program.path, "--explain", path], capture_output=True, text=True)
    if explained.returncode:
        print(f"{number} {kind}: {explained.stderr}")
        return []
    value, uncertainty, said = truth_of_solid(program, text, "G_mean", f90nml.reads(explained.stdout)["grid"])
    print(f"{number} {kind}: {value:.6g}, known to {uncertainty / abs(value):.2%}, {said}", flush=True)
    targets = [error for error in SOLID_TARGETS if uncertainty <= error / 4 * abs(value)]
    return judged(program, f90nml.reads(text), path, number, "G_mean", value, False, targets)


def judged(program, model, path, number, name, value, with_best, targets=TARGETS):
    """A row for each error that is asked of a model."""
    rows, meshes = [], None
    for error in targets:
        written(model, path, name, error)
        (program.folder / "run.h5").unlink(missing_ok=True)
        run = program(path.read_text(), codes=(0, 2, 3, *STOPPED))
        row = {"case": number, "quantity": name, "asked": error, "code": run.code, "reached": np.nan, "told": np.nan, "seconds": run.seconds, "best": np.nan, "message": ""}
        if run.code not in (0, 3) or not run.path.exists():
            row["message"] = (run.message.splitlines() or [""])[-1][:150]
        else:
            last = run.last
            base, _, tip = name.partition("_tip")
            row["reached"] = abs(last[name] / value - 1)
            row["told"] = last[f"{base}_error" + (f"_tip{tip}" if tip else "")] / abs(last[name])
            if with_best:
                meshes = meshes or all_meshes(program, path, name, value)
                row["best"] = cheapest(meshes, error)
        rows.append(row)
        print(" ".join(f"{key}={item:.3g}" if isinstance(item, float) else f"{key}={item}" for key, item in row.items()), flush=True)
    return rows


def all_meshes(program, path, name, value):
    """(family, lattice, error, seconds) of all meshes, coarse to fine, of the lattices that the program chooses from."""
    text = path.read_text().replace("error = ", "error = 0.99 !")
    (program.folder / "coarse.nml").write_text(text)
    explained = subprocess.run([program.path, "--explain", program.folder / "coarse.nml"], capture_output=True, text=True)
    if explained.returncode:
        return []
    first, rows = f90nml.reads(explained.stdout)["grid"], []
    for order, levels, rings in FAMILIES:
        for times in CELLS:
            settings = {"grid.lower": ",".join(map(repr, first["lower"])), "grid.cell": first["cell"] / times, "grid.cells": ",".join(str(n * times) for n in first["cells"]),
                        "grid.order": order, "refine.indicator": "tip" if levels else "none"}
            if levels:
                settings |= {"refine.max_level": levels, "refine.rings": rings}
            whole = explained.stdout.replace("points_per_cell = 3", f"points_per_cell = {order + 1}")
            run = program(whole, settings=settings, codes=(0, 2, 3, *STOPPED))
            if run.code not in (0, 3) or run.seconds > MOST_BY_HAND:
                break
            rows.append(((order, levels), times, abs(run.last[name] / value - 1), run.seconds))
    return rows


def cheapest(rows, error):
    """The least time of a mesh within an error that finer ones of its family keep within too."""
    times = [spent for family, lattice, off, spent in rows
             if off <= error and all(other[2] <= error for other in rows if other[0] == family and other[1] >= lattice)]
    return min(times, default=np.nan)


def tell(rows, targets=TARGETS):
    """Print a table by what is asked; the least part of the models that keep within."""
    parts = []
    print("\n| asked | models | refused | within | told too large | reached, median | seconds, median | over the best, median | nine of ten |\n|" + "---|" * 9)
    for error in targets:
        chosen = [row for row in rows if row["asked"] == error]
        ran = [row for row in chosen if row["code"] != 2]
        if not ran:
            continue
        parts.append(np.mean([row["reached"] <= error for row in ran]))
        over = np.array([row["seconds"] / row["best"] for row in ran if row["best"] == row["best"]])
        print(f"| {error:.1%} | {len(chosen)} | {len(chosen) - len(ran)} | {parts[-1]:.0%} | {sum(row['code'] == 3 for row in ran)} | "
              f"{np.median([row['reached'] for row in ran]):.2%} | {np.median([row['seconds'] for row in ran]):.2f} | " +
              (f"{np.median(over):.2g} | {np.quantile(over, 0.9):.2g} |" if over.size else "– | – |"))
    return min(parts, default=0.0)


if __name__ == "__main__":
    main()
