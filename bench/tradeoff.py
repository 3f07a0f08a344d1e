"""Accuracy against cost: errors of what loads a crack, in a beam and in a plate, and the processor time they take.

    static    G of the beam at rest against the converged value: the largest error in the last tenth of the run, with its sign
    tension   G of a crack in the middle of a plate in tension, at rest, where nothing bends, against integral equations
    dynamic   G(t) of the undamped beam against converged finite elements: rms difference below 50 kHz in the first 0.6 ms, over the peak
    impact    K_I(t) of Chen's plate, which a step of tension hits, against independent finite elements: rms difference of the means
              over 0.2 us in the first 13.95 us, until the wave that closes the crack, over the peak

The matrix is declared in tradeoff_matrix.py. Each run is one process on one thread; its cost is its processor time, user and
system, the median of `repeats` turns. The machine may be busy: before every run the same small run is timed, and what is measured
is multiplied by the median of all those times over the one just taken.

A small error may be luck: where an error changes its sign it is zero. So a setting counts with the largest error of its family on
its own cells and on all finer ones, the *sustained* error, and the finest cells of each family, which nothing confirms, do not
count. A Richardson pair is two runs that are extrapolated from cells c and c/2, taking the error to be proportional to c; a triple, from
c to c/4, takes it to be a sum of terms c and c^2. Its cost is the sum.

Run by `make tradeoff`, which writes docs/evidence/tradeoff.md and its CSV files too; for one study: .venv/bin/python bench/tradeoff.py static --output DIR
"""

import csv
import math
import statistics
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

import program_runs
from tables import ROOT, command_line, rewrite
from tradeoff_matrix import AT_REST, BASE, FAMILIES, IMPLICIT, QUADRATIC, REFINED, Family

sys.path.insert(0, str(ROOT / "postprocess"))
import numpy as np  # noqa: E402

from history import History, lowpass, moving_mean, read_curve  # noqa: E402
from tradeoff_tables import advice, curves, front, groups, written  # noqa: E402

from hampm.extrapolation import limit  # noqa: E402


class Study(NamedTuple):
    """A scene, what its runs are given, and what is read from them."""

    scene: Path
    depth: float       # of what `cells` of a family counts: an arm of the beam, half the width of the plate, an eighth of the crack [m]
    grid: tuple        # root cells in each direction: so many times `cells`, and so many more
    settings: dict     # what every run is given
    estimators: dict   # estimator -> column of the history; of the first one the errors of all families are listed
    accuracies: tuple  # for which the cheapest settings are told [%]
    converged: float = 0  # at rest: G/G_ref, or G where there is no G_ref [J/m2]


def beam(accuracies, damping, end, interval, converged=0):
    """A study of the double cantilever beam: damping rate [1/s], end and time between samples [s]."""
    columns = {"vcct": "G_vcct_I", "domain_integral": "G_domain_I"}
    settings = {"energy_release.estimators": ",".join(columns), "energy_release.energy_balance": ".false.", "output.snapshot_interval": 0.0, "damping.rate": damping,
                "run.end_time": end, "output.history_interval": interval}
    return Study(ROOT / "input/dcb.nml", 0.01, ((10, 0), (1, 1)), settings, columns, accuracies, converged)


CONVERGED = 1.28737  # G/G_ref at rest, tests/reference/dcb_static.csv
IN_TENSION = 176.00073**2 / 70e9  # G of the plate under 1 kPa, by K of tests/reference/cracks/a2_slanted_centre_plate.csv [J/m2]
STUDIES = {
    "static": beam((5, 2, 1, 0.5, 0.3, 0.1), 3.2e4, 1e-3, 1e-5, CONVERGED),  # critical damping of the first mode
    "tension": Study(ROOT / "tests/regression/centre_crack/case.nml", 0.002, ((22, 0), (42, 0)),
                     {"energy_release.estimators": "vcct,domain_integral", "energy_release.energy_balance": ".false.", "energy_release.radii": "4e-3,5e-3,6e-3",
                      "output.snapshot_interval": 0.0},
                     {"vcct": "G_vcct_I", "domain_integral": "G_domain_I"}, (5, 2, 1, 0.5, 0.3, 0.1), IN_TENSION),
    "dynamic": beam((5, 2, 1, 0.5), 0.0, 7e-4, 1e-6),
    "impact": Study(ROOT / "input/chen.nml", 0.01, ((1, 1), (2, 1)),
                    {"energy_release.estimators": "domain_integral", "energy_release.energy_balance": ".false.", "output.history_interval": 4e-8, "method.scheme": "usavg"},
                    {"domain_integral": "K_I"}, (2, 1, 0.5, 0.35))}
EARLY, CUTOFF = 6e-4, 5e4  # what counts of G(t): until [s], below [Hz]
WINDOW, CLOSING = 2e-7, 1.395e-5  # means of K_I(t) over [s], until [s]
REFERENCES = {"dynamic": (ROOT / "tests/reference/dcb_dynamic_undamped.csv", 1),
              "impact": (ROOT / "tests/regression/chen/reference.csv", 2)}  # and the column: of means over the window
CALIBRATION = Family("calibration", "uniform", {}, (8,))
DOCUMENT = ROOT / "docs/evidence/tradeoff.md"
COLUMNS = ["study", "group", "family", "name", "estimator", "cells", "cell", "settings", "runs", "particles", "cpu_seconds",
           "cpu_lowest", "cpu_highest", "error_percent", "sustained_percent", "message"]


class Run(NamedTuple):
    """What one run of the program has given."""

    seconds: float
    particles: float
    curves: dict     # estimator -> G/G_ref, G or K_I: in the last tenth, or at the times of the reference; None where the run failed
    message: str


class Program(program_runs.Program):
    """Runs members of families in a folder."""

    def __call__(self, study, family, k):
        """Run the k-th member of a family once."""
        done = super().__call__(STUDIES[study].scene, settings_of(study, family, k), codes=(0, 2, 3))
        if done.code:  # refused, or stopped with a cause: a result of the study
            return Run(done.seconds, math.nan, None, done.message.strip().splitlines()[0])
        return Run(done.seconds, *read(done.path, study), "")


def settings_of(study, family, k):
    """Every key that the k-th member of a family sets."""
    n, whole = family.cells[k], STUDIES[study]
    cells = ", ".join(str(times * n + more) for times, more in whole.grid)
    settings = {"grid.cell": whole.depth / n, "grid.cells": cells, **BASE, **whole.settings}
    if family.rings:
        settings["refine.rings"] = max(1, round(family.rings * n))
    return settings | family.settings | (family.finer[k] if family.finer else {})


def read(path, study):
    """Number of particles at the end, and the curves of G/G_ref, G or K_I by each estimator."""
    history = History(path)
    particles, columns = float(history.columns["particles"][-1]), STUDIES[study].estimators
    if study == "impact":
        times = reference_curve(study)[0]
        return particles, {name: np.interp(times, history.times, moving_mean(history.times, history.columns[column], WINDOW))
                           for name, column in columns.items()}
    if history.is_static:
        times = history.times[-1:]
    elif STUDIES[study].converged:
        times = history.times[-1] * np.linspace(0.9, 1.0, 21)
    else:
        times = reference_curve(study)[0]
    times = times[times <= history.times[-1]]
    return particles, {name: np.interp(times, history.times, history.columns[column] / history.g_scale()) for name, column in columns.items()}


@cache
def reference_curve(study):
    """Times [s] and G/G_ref, all modes, or K_I of the finite elements."""
    return read_curve(*REFERENCES[study])


def error_of(curve, study):
    """Error of a curve in percent, as the study defines it."""
    if STUDIES[study].converged:
        errors = 100 * (curve / STUDIES[study].converged - 1)
        return float(max(errors, key=abs))
    times, asked = reference_curve(study)
    counts = times <= (CLOSING if study == "impact" else EARLY)
    if study == "dynamic":
        curve, asked = lowpass(times[:curve.size], curve, CUTOFF), lowpass(times, asked, CUTOFF)
    difference = curve[counts[:curve.size]] - asked[counts]
    return 100 * float(np.sqrt(np.mean(difference**2)) / np.max(np.abs(asked[counts])))


def measure(program, study, families, repeats):
    """All members of the families in turns; returns (name of the family, k) -> list of runs with the time of a calm machine."""
    members = [(family, k) for family in families for k in range(len(family.cells))]
    runs, factors = {(family.name, k): [] for family, k in members}, []
    for turn in range(repeats):
        for number, (family, k) in enumerate(members):
            factors.append(program("dynamic", CALIBRATION, 0).seconds)
            runs[family.name, k].append((program(study, family, k), factors[-1]))
            progress(f"{study}: turn {turn + 1} of {repeats}, {number + 1} of {len(members)} runs")
    progress("")
    calm = statistics.median(factors)
    spread = [f / calm for f in sorted(factors)]
    print(f"{study}: the calibrating run took {calm:.3f} s, nine in ten times {spread[len(spread) // 20]:.2f} to "
          f"{spread[-len(spread) // 20]:.2f} of it")
    return {member: [run._replace(seconds=run.seconds * calm / factor) for run, factor in taken] for member, taken in runs.items()}


def progress(text):
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)


class Point(NamedTuple):
    """A point of a curve: one run, or a pair or triple of them that is extrapolated."""

    label: str
    cells: int
    settings: str
    runs: int
    particles: float
    seconds: tuple  # of each turn
    curves: dict    # as those of a run
    message: str


def points(family, study, measured):
    """The points of a family."""
    for k, n in enumerate(family.cells):
        runs = measured[family.name, k]
        own = settings_of(study, family, k)
        given = " ".join(f"{key}={value}" for key, value in own.items() if STUDIES[study].settings.get(key) != value)
        label = ", ".join([f"n = {n}"] + [f"{key}={value}" for key, value in own.items() if family.finer and key in family.finer[k]])
        yield Point(label, n, given, 1, runs[0].particles, tuple(run.seconds for run in runs), runs[0].curves, runs[0].message)


TOGETHER = {2: "pair", 3: "triple"}  # numbers of runs that are extrapolated together, by Richardson


def extrapolated(single, count):
    """Points that are extrapolated from `count` single ones, each with half the cells of the one before."""
    by_cells = {point.cells: point for point in single if point.curves}
    for coarse in by_cells:
        members = [by_cells.get(coarse * 2**i) for i in range(count)]
        if all(members):
            size = min(next(iter(m.curves.values())).size for m in members)
            sizes = [1 / m.cells for m in members]
            yield Point(f"n = {', '.join(str(m.cells) for m in members)}", members[-1].cells, " | ".join(m.settings for m in members),
                        count, sum(m.particles for m in members), tuple(map(sum, zip(*(m.seconds for m in members)))),
                        {name: limit(sizes, [m.curves[name][:size] for m in members]) for name in members[0].curves}, "")


def rows_of(study, families, measured):
    """Rows of the table: each family on its own, and the pairs and triples of those whose root cells become finer."""
    for family in families:
        single = list(points(family, study, measured))
        yield from curve_rows(study, family.group, family.name, single)
        if not family.finer:
            for count, word in TOGETHER.items():
                group = "Richardson, refined" if family.group == REFINED else "Richardson, uniform"
                if family.group in (AT_REST, IMPLICIT, QUADRATIC):
                    group = f"Richardson, {family.group}"
                yield from curve_rows(study, group, f"{family.name}, {word}", list(extrapolated(single, count)))


def curve_rows(study, group, family, curve):
    """Rows of one curve, for each estimator, with the sustained errors."""
    for estimator in STUDIES[study].estimators:
        errors = [error_of(p.curves[estimator], study) if p.curves else math.nan for p in curve]
        for k, (p, error) in enumerate(zip(curve, errors)):
            sustained = max(map(abs, errors[k:])) if k + 1 < len(errors) and not any(map(math.isnan, errors[k:])) else math.nan
            yield dict(zip(COLUMNS, [
                study, group, family, f"{family}, {p.label}", estimator, p.cells, f"{STUDIES[study].depth / p.cells:.6g}", p.settings, p.runs,
                text(p.particles, ".0f"), text(statistics.median(p.seconds), ".4g"), text(min(p.seconds), ".4g"),
                text(max(p.seconds), ".4g"), text(error, ".4f"), text(sustained, ".4f"), p.message]))


def text(value, form):
    return "" if math.isnan(value) else format(value, form)


def save(rows, study, folder):
    with open(folder / f"{study}.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)


def load(study, folder):
    """The rows of a study that has been measured, None if it has not."""
    path = folder / f"{study}.csv"
    if not path.is_file():
        return None
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def document(folder):
    """Write the tables of all studies that have results: CSV files beside the document, and what it has of them."""
    tables = {study: (advice(rows, STUDIES[study].accuracies), front(rows), curves(rows)) for study in STUDIES if (rows := load(study, folder))}
    page = written(tables, DOCUMENT.read_text(), DOCUMENT.parent, lambda name, lines, text: rewrite(name, lines, text, DOCUMENT))
    DOCUMENT.write_text(page)


def main():
    arguments = command_line(__doc__, list(STUDIES), "results/tradeoff", repeats=(3, "turns, of which the median counts"),
                             measure=(1, "0: only write the tables of what has been measured"),
                             document=(0, "1: write docs/evidence/tradeoff_*.csv and the tables of docs/evidence/tradeoff.md"))
    folder = arguments.output.resolve()
    for study in arguments.part:
        if arguments.measure:
            families = FAMILIES[study]
            with tempfile.TemporaryDirectory() as scratch:
                measured = measure(Program(arguments.program.resolve(), Path(scratch)), study, families, arguments.repeats)
            save(rows_of(study, families, measured), study, folder)
        rows = load(study, folder)
        if rows is None:
            sys.exit(f"{folder / study}.csv: not measured yet")
        print(f"\n{folder / study}.csv")
        print("\n".join(groups(advice(rows, STUDIES[study].accuracies))))
    if arguments.document:
        document(folder)


if __name__ == "__main__":
    main()
