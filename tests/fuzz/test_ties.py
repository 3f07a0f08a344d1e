"""Particles exactly on cracks are on no side of them: results do not hang on from which end a crack is written, nor on mirror images, turns, and the order of cracks."""

import combinations
import pytest
from paths import CHECKED_PROGRAM

METHODS = {
    "at rest": {"method": {"time": "static"}},
    "finer cells": {"method": {"time": "static"}, "refine": {"indicator": "tip", "max_level": 1, "rings": 2}},
    "updated frame": {"method": {"frame": "updated"}},
    "implicit, finer": {"method": {"time": "implicit", "time_step": 0.5}, "refine": {"indicator": "zz", "max_level": 1, "interval": 4, "tolerance": 0.05}},
    "quadratic": {"method": {"time": "static"}, "grid": {"order": 2}, "body": {"points_per_cell": 3}},
}
# By where particles are, at odd multiples of a quarter of a cell: points of each crack
TIES = {
    "row": [[2.6, 4.25, 7.3, 4.25]],
    "row, within rounding": [[2.6, 4.25 + 4e-13, 7.3, 4.25 - 3e-13]],
    "column": [[4.75, 2.6, 4.75, 7.3]],
    "diagonal through nodes": [[2.6, 2.6, 7.3, 7.3]],
    "one of several cells": [[2.25, 3.25, 7.25, 6.25]],
    "ends": [[2.75, 4.75, 7.25, 6.75]],
    "ends, along a row": [[2.75, 4.75, 7.25, 4.75]],
    "kink": [[2.25, 4.25, 5.25, 4.25, 7.25, 6.25]],
    "sharp kink": [[2.25, 4.25, 5.25, 5.25, 3.25, 7.25]],
    "mouth": [[-0.5, 4.25, 5.4, 4.25]],
    "crossing": [[2.6, 2.6, 7.4, 7.4], [3.1, 7.4, 7.4, 3.1]],
    "upright crossing": [[2.6, 5.25, 7.4, 5.25], [5.25, 2.4, 5.25, 7.6]],
    "meeting": [[2.6, 4.25, 7.4, 4.25], [5.25, 4.25, 5.25, 7.4]],
}


def scene_of(tie, method):
    """A plate that is held below and pulled aside, with cracks."""
    more = METHODS[method]
    groups = [["run", {"plane": "strain", "end_time": 8.0}], ["grid", {"lower": [-1.0, -1.0], "cell": 1.0, "cells": [12, 12]}],
              ["material", {"name": "m", "young": 1.0, "poisson": 0.3, "density": 1.0}],
              ["body", {"material": "m", "lower": [0.0, 0.0], "upper": [10.0, 10.0], "points_per_cell": 2}],
              *(["crack", {"kind": "path", "name": f"c{k}", "points": points}] for k, points in enumerate(TIES[tie])),
              ["constraint", {"lower": [0.0, 0.0], "upper": [10.0, 0.0], "fix": "xy"}],
              ["load", {"kind": "traction", "lower": [0.0, 10.0], "upper": [10.0, 10.0], "force": [4e-5, 1e-4]}],
              ["method", {}], ["energy_release", {"estimators": ["domain_integral"]}], ["output", {"file": "case.h5"}]]
    if more["method"].get("time") != "static":
        groups[-1][1]["history_interval"] = 2.0
    if "refine" in more:
        groups.append(["refine", {}])
    return [[name, keys | more.get(name, {})] for name, keys in groups]


CHEAP = {("kink", "at rest"), ("crossing", "at rest"), ("meeting", "finer cells"), ("column", "implicit, finer"), ("row, within rounding", "updated frame"),
         ("sharp kink", "finer cells"), ("ends", "at rest"), ("row", "quadratic"), ("one of several cells", "implicit, finer"), ("mouth", "updated frame")}

# Not yet to 1e-9, but to 4e-4: particles on edges between the quarters of quadratic cells
OPEN = {("row, within rounding", "quadratic"), ("kink", "quadratic")}


def marks(case):
    """Which cases are in `make verify` only, and which are not yet as they are to be."""
    return [mark for mark, cases in ((pytest.mark.xfail(strict=True), OPEN), (pytest.mark.verify, {(tie, method) for tie in TIES for method in METHODS} - CHEAP)) if case in cases]


@pytest.mark.parametrize(("tie", "method"), [pytest.param(tie, method, marks=marks((tie, method))) for tie in TIES for method in METHODS])
def test_particles_on_cracks(tie, method):
    bench = combinations.Bench(CHECKED_PROGRAM, exact=True)
    scene = scene_of(tie, method)
    base = bench.run(scene)
    assert base.code == 0, base.said
    for name in combinations.IMAGES:
        if (tie, method) in CHEAP and name == "quarter turn" and method != "at rest":
            continue
        found = combinations.ask(bench, scene, base, name, "ties")
        assert found in ("passed", "unasked"), f"{name}: {found}"
