"""Whether runs that choose their mesh by &accuracy reach the errors that are asked, and what they cost over the best mesh chosen by hand.

    .venv/bin/python bench/accuracy.py --seed 1 --cases 60 [--program build/release/hampm] [--targets 0.03,0.01] [--most 20] [--best] [--csv FILE]
    .venv/bin/python bench/accuracy.py --solids --seed 1 --cases 40 [--program build/release3d/hampm3d]

Models are those of the second opinion (tests/second_opinion), at rest, drawn at random without lattice, order and refinement. The truth is that of its finite elements, which share
nothing with hampm. The quantity is the largest K_I or K_II of all tips. With --best the cheapest of all meshes of a table that keeps within the error asked,
judged by the truth and by those finer than it, is found too; both costs are processor times of whole processes. Runs longer than --most seconds of the processor are stopped and count as
missed. Models whose pins end at nodes of the lattice that is left out are not taken: they are others without it.

With --solids models are boxes with one crack (solid_fronts.py), at rest. Their truth is the limit of three much finer meshes, and the quantity G_mean of the
front. A target is asked where the truth is known to a quarter of it.
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
    options = parser.parse_args()
    options.program = options.program or ROOT / ("build/release3d/hampm3d" if options.solids else "build/release/hampm")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        program = Program(limited(options.program, options.most, folder) if options.most else options.program, folder)
        targets = [float(error) for error in options.targets.split(",")]
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
    tell(rows, targets)
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)


def limited(program, most, folder):
    """A command that runs a program for so many seconds of the processor at most."""
    path = folder / "limited"
    path.write_text(f'#!/bin/sh\nulimit -t {most:.0f}\nexec "{program.resolve()}" "$@"\n')
    path.chmod(0o755)
    return path


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
    """A table by what is asked."""
    print("\n| asked | models | refused | within | told too large | reached, median | seconds, median | over the best, median | nine of ten |\n|" + "---|" * 9)
    for error in targets:
        chosen = [row for row in rows if row["asked"] == error]
        ran = [row for row in chosen if row["code"] != 2]
        if not ran:
            continue
        over = np.array([row["seconds"] / row["best"] for row in ran if row["best"] == row["best"]])
        print(f"| {error:.1%} | {len(chosen)} | {len(chosen) - len(ran)} | {np.mean([row['reached'] <= error for row in ran]):.0%} | {sum(row['code'] == 3 for row in ran)} | "
              f"{np.median([row['reached'] for row in ran]):.2%} | {np.median([row['seconds'] for row in ran]):.2f} | " +
              (f"{np.median(over):.2g} | {np.quantile(over, 0.9):.2g} |" if over.size else "– | – |"))


if __name__ == "__main__":
    main()
