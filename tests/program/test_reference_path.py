"""`&method path = 'reference'`, the step that is there to be read: runs with it have the results of those by the fastest path."""

import h5py
import numpy as np
import pytest

LAW = "young = 1e7  poisson = 0.3  density = 1000"
CELL = "&grid lower = -0.004, -0.004  cell = 2e-3  cells = 14, 14 {} /\n"
PLATE = "&body material = 'a'  lower = 0.0, 0.0  upper = 0.02, 0.02  points_per_cell = {}  velocity = 0.3, -0.2  spin = 5.0 /\n"
HELD = "&constraint lower = 0.0, 0.0  upper = 0.02, 0.0  fix = 'y'  name = 'foot' /\n&constraint lower = 0.0, 0.0  upper = 0.0, 0.006  fix = 'x' /\n"
PULL = "&load kind = 'traction'  lower = 0.0, 0.02  upper = 0.01, 0.02  force = 0.1, 0.5  history = 'ramp'  rise_time = 2e-4 /\n" \
       "&load kind = 'point'  lower = 0.02, 0.008  upper = 0.02, 0.008  force = 0.05, 0.0  history = 'sine'  frequency = 1e3 /\n&load kind = 'gravity'  acceleration = 0.0, -9.81 /\n"
LINE = "&crack kind = 'line'  tip = 0.01, 0.01 /\n&energy_release estimators = 'domain_integral', 'vcct' /\n"
TIP = "&refine indicator = 'tip'  max_level = 2  rings = 2 /\n"
THROWN = """&body material = 'a'  lower = 0.001, 0.004  upper = 0.009, 0.012  velocity = 1.0, 0.0 /
&body material = 'b'  shape = 'circle'  center = 0.0152, 0.0091  radius = 0.0041  points_per_cell = 3  velocity = -1.0, 0.3  spin = 100.0 /
&material name = 'b'  law = 'neo_hookean'  young = 3e7  poisson = 0.2  density = 2000 /
&method frame = 'updated' /
"""


def scene(body, *more, law=LAW, grid="", plane="strain", end=1e-3):
    return (f"&run plane = '{plane}'  thickness = 0.01  end_time = {end} /\n&material name = 'a'  {law} /\n{CELL.format(grid)}{body}{''.join(more)}"
            f"&output history_interval = {end / 20}  snapshot_interval = {end} /\n")


REMEMBERS = {"j2_plastic": LAW + "  law = 'j2_plastic'  yield_stress = 4e3  hardening = 1e5",
             "viscoelastic": LAW + "  law = 'viscoelastic'  moduli = 1e6, 5e5  relaxation_times = 1e-4, 1e-3"}
SCENES = {
    "usl, total frame, plane stress": scene(PLATE.format(2), HELD, PULL, "&method scheme = 'usl' /\n", plane="stress"),
    "usf, total frame, damped": scene(PLATE.format(2), HELD, PULL, "&method scheme = 'usf' /\n&damping rate = 500.0 /\n"),
    "musl, updated frame": scene(PLATE.format(2), HELD, PULL, "&method frame = 'updated' /\n"),
    "usavg, updated frame, neo-Hooke": scene(PLATE.format(3), PULL, "&method frame = 'updated'  scheme = 'usavg' /\n", law=LAW + "  law = 'neo_hookean'"),
    "crack and cells of three sizes": scene(PLATE.format(2), HELD, PULL, LINE, TIP),
    "quadratic cells of three sizes": scene(PLATE.format(3), HELD, PULL, LINE, TIP, "&method scheme = 'usf' /\n", grid="order = 2"),
    "cells that refine and coarsen": scene(PLATE.format(2), HELD, PULL, "&refine indicator = 'zz'  max_level = 2  tolerance = 0.1  interval = 20 /\n"),
    "two bodies that meet and change cells": scene(THROWN, law=LAW + "  law = 'neo_hookean'", end=3e-3),
    "cut cells and bonds at the tips of a path": scene(PLATE.format(2).replace("spin = 5.0", ""), PULL, "&crack kind = 'path'  points = 0.0047, 0.0083, 0.0149, 0.0118 /\n"
                                                       "&energy_release estimators = 'domain_integral' /\n"),
    "a disc that is cut, with an eigenstrain": scene("&body material = 'a'  shape = 'circle'  center = 0.0093, 0.0102  radius = 0.0087  points_per_cell = 3  "
                                                     "eigenstrain = 1e-3, 2e-3, 5e-4 /\n", "&load kind = 'gravity'  acceleration = 5.0, -9.81 /\n"),
    "cohesion that fails": scene(PLATE.format(2), HELD, PULL.replace("0.1, 0.5", "0.1, 50.0"), "&crack kind = 'line'  tip = 0.012, 0.01 /\n&cohesive strength = 5e2  toughness = 1e-4 /\n"),
    "cohesion that fails, usf and finer cells": scene(PLATE.format(2), HELD, PULL.replace("0.1, 0.5", "0.1, 50.0"), "&method scheme = 'usf' /\n", TIP,
                                                      "&crack kind = 'path'  points = -0.001, 0.0083, 0.0149, 0.0118 /\n&cohesive strength = 5e2  toughness = 1e-4 /\n"),
    "a pressure that follows edges, updated frame": scene("&body material = 'a'  shape = 'polygon'  points = 0.001, 0.0012, 0.019, 0.0043, 0.0131, 0.0187  points_per_cell = 3 /\n",
                                                          "&load kind = 'pressure'  lower = 0.0, 0.0  upper = 0.011, 0.02  pressure = 3e4 /\n", "&method frame = 'updated' /\n"),
    "plasticity": scene(PLATE.format(2), HELD, PULL, law=REMEMBERS["j2_plastic"]),
    "viscoelasticity in quadratic cells": scene(PLATE.format(3), HELD, PULL, "&method scheme = 'usavg' /\n", law=REMEMBERS["viscoelastic"], grid="order = 2"),
}


def results(hampm, folder, text, path, *options, code=0):
    (folder / f"{path}.nml").write_text(text)
    result = hampm(f"{path}.nml", "--force", "--quiet", "--set", f"method.path={path}", *options)
    assert result.returncode == code, result.stderr
    if code:
        return result.stderr
    with h5py.File(folder / f"{path}.h5") as file:
        history = {name: values[:] for name, values in file["history"].items()}
        last = file["VTKHDF/particles/NumberOfPoints"][-1]
        data = file["VTKHDF/particles/PointData"]
        order = np.argsort(data["id"][-last:])
        particles = {name: data[name][-last:][order] for name in ("displacement", "velocity", "stress_xx", "stress_xy", "stress_yy")}
    return history, particles


@pytest.mark.parametrize("name", SCENES)
def test_results_are_those_of_the_fastest_path(hampm, tmp_path, name):
    (fast, there), (read, here) = (results(hampm, tmp_path, SCENES[name], path) for path in ("fastest", "reference"))
    assert fast["step"][-1] > 30
    assert fast.keys() == read.keys()
    energy = np.max(fast["kinetic_energy"] + fast["strain_energy"])
    for column, values in fast.items():
        # what is nothing but rounding, as the work of no load, is measured by what there is
        size = max(np.max(np.abs(values)), energy*1e-4 if column.endswith(("energy", "work", "loss", "dissipation")) else 0,
                   1e-3*np.max(np.abs(fast.get("K_I", 0.0))) if column.startswith("K_") else 0)
        assert read[column] == pytest.approx(values, rel=0, abs=1e-10*size), column
    for field in there:
        assert here[field] == pytest.approx(there[field], rel=0, abs=1e-10*np.max(np.abs(there[field]))), field


@pytest.mark.parametrize("change, phrase", [
    ("&method mass = 'consistent' /", "mass = 'consistent': the reference step divides by lumped masses"), ("&method time = 'static' /", "the reference step is explicit"),
    ("&constraint lower = 0.0, 0.02  upper = 0.02, 0.02  fix = 'y'  velocity = 0.0, 1e-3 /", "the reference step has no prescribed motion"),
    ("&energy_release energy_balance = .true. /", "the reference step does not record numerical losses")])
def test_what_it_does_not_do_is_refused(hampm, tmp_path, change, phrase):
    assert phrase in results(hampm, tmp_path, scene(PLATE.format(2).replace("velocity = 0.3, -0.2  spin = 5.0", ""), change + "\n"), "reference", code=2)
