"""What the program for solids says of mistakes in models, and what holds a body in space at rest."""

import subprocess

import h5py
import numpy as np
import pytest
from paths import DCB, INPUT, PROGRAM, SOLID_PROGRAM

pytestmark = pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program dim=3 makes it")

BEAM = INPUT / "solid/beam.nml"
AT_REST = ("--set", "method.time=static", "--set", "output.history_interval=0", "--set", "damping.rate=0", "--set", "grid.cell=0.02", "--set", "grid.cells=10,2,2")


def run(folder, program, *words):
    return subprocess.run([program, *map(str, words), "--quiet"], cwd=folder, capture_output=True, text=True)


def test_a_model_of_the_other_program_is_one_error(tmp_path):
    """Which program to run, in place of an error for every place and vector."""
    for program, case, says in ((PROGRAM, BEAM, "has 3 values, as that of a solid: run hampm3d, which `make program dim=3` builds"),
                                (SOLID_PROGRAM, DCB, "has 2 values, as that of a plane: run hampm")):
        done = run(tmp_path, program, case)
        assert done.returncode == 2 and done.stderr.count("\n") == 1 and done.stderr.endswith(f"{says}\n"), done.stderr
    done = run(tmp_path, SOLID_PROGRAM, BEAM, "--set", "grid.cells=20,4")
    assert "must have 3 values, not 2" in done.stderr        # one mistake in a solid


def test_the_model_as_it_is_used_has_no_plane(tmp_path):
    """And reads back as the same."""
    first = run(tmp_path, SOLID_PROGRAM, "--check", BEAM).stdout
    assert " plane =" not in first and " thickness =" not in first
    (tmp_path / "again.nml").write_text(first)
    again = run(tmp_path, SOLID_PROGRAM, "--check", "again.nml").stdout
    assert [line for line in again.splitlines() if line[:1] != "!"] == [line for line in first.splitlines() if line[:1] != "!"]


def test_the_template_is_a_solid_that_runs(tmp_path):
    """A beam with a crack, which the first steps move; the help and the way to go on have the name of the program."""
    (tmp_path / "case.nml").write_text(run(tmp_path, SOLID_PROGRAM, "--template").stdout)
    done = run(tmp_path, SOLID_PROGRAM, "case.nml", "--steps", "10")
    assert done.returncode == 5 and done.stderr.endswith("To go on: hampm3d --resume ./dcb.h5.checkpoint\n") and "warning" not in done.stderr, done.stderr
    with h5py.File(tmp_path / "dcb.h5") as file:
        assert file["history/external_work"][-1] > 0 and "G_mean" in file["history"]
    text = run(tmp_path, SOLID_PROGRAM, "--help").stdout
    assert text.startswith("Usage: hampm3d [options] case.nml\n") and "hampm " not in text


def test_a_mistake_in_a_front_is_told_once(tmp_path):
    """A value that is none is not measured, counted or looked for in the material besides; nor is a front beside the material or above it."""
    for setting in ("crack.radii=-0.01", "crack.front=circle", "crack.center=0.0,0.0", "crack.center=1.0,0.0,0.0", "crack.center=0.0,0.0,1.0", "crack.normal=w"):
        done = run(tmp_path, SOLID_PROGRAM, INPUT / "solid/penny.nml", "--set", setting)
        assert done.returncode == 2 and done.stderr.count("\n") == 1 and f"&crack {setting[6:].split('=')[0]} = " in done.stderr, done.stderr


@pytest.mark.parametrize(("setting", "code", "says"), [
    ("body.upper=0.2,0.04", 2, "&body upper = 0.2, 0.04: must have 3 values, or none, not 2"),
    ("load.lower=0.2,0,0.04", 2, "must equal lower = (0.2, 0.0, 0.04) in exactly one direction: a traction acts on a side"),
    ("load.upper=0.2,0.04,0.06", 2, "the rectangle up to (0.2, 0.04, 0.06) must lie on one side of a body: a traction acts on a side"),
    ("run.plane=axisymmetric", 2, "is not allowed with a solid: a solid has no plane"),
    ("constraint.fix=xy", 3, "the piece of body 1 with the node at (0.0, 0.0, 0.0) m has no equilibrium: it moves along z, as the loads push with 1000.0 N"),
    ("constraint.fix=yz", 3, "has no equilibrium: it turns, as the loads have a moment"),
    ("constraint.upper=0,0.04,0", 3, "has no equilibrium: it turns, as the loads have a moment"),
    ("constraint.upper=0,0,0", 3, "has no equilibrium: it turns, as the loads have a moment and its constraints hold it at one point or along one line only")])
def test_mistakes_are_named(tmp_path, setting, code, says):
    done = run(tmp_path, SOLID_PROGRAM, BEAM, "--force", *AT_REST, "--set", setting)
    assert done.returncode == code and says in done.stderr, done.stderr


ROUND = """
&run end_time = 1.0 /
&grid lower = -1.0, -1.0, -1.0  cell = 1.0  cells = 18, 18, 18 /
&material name = 'a'  young = 70e9  poisson = 0.3  density = 2700 /
&body material = 'a'  shape = 'cylinder'  lower = 8.0, 8.0, 0.0  upper = 8.0, 8.0, 16.0  radius = 8.0 /
&constraint lower = 0.0, 0.0, 0.0  upper = 16.0, 16.0, 0.0  fix = 'xyz' /
&load kind = 'gravity'  acceleration = 0.0, 0.0, 10.0 /
&crack kind = 'plane'  normal = 'z'  {front} /
&energy_release estimators = 'domain_integral' /
&method time = 'static' /
"""


@pytest.mark.parametrize(("front", "refused"), [
    ("front = 'disc'  center = 8.0, 8.0, 8.0  radii = 4.0", False), ("front = 'disc'  center = 8.0, 8.0, 8.0  radii = 5.0", True),
    ("tip = 7.0, 0.0, 8.0  direction = 1.0, 0.0, 0.0", True)])
def test_fronts_are_measured_where_all_of_them_is_in_material(tmp_path, front, refused):
    """A front that ends on a curved side would have nodes outside, and G there."""
    (tmp_path / "round.nml").write_text(ROUND.format(front=front))
    done = run(tmp_path, SOLID_PROGRAM, "round.nml", "--check")
    assert done.returncode == (2 if refused else 0)
    assert ("3.4 of the finest cells" in done.stderr) == refused


@pytest.mark.parametrize(("where", "refused"), [("0.0, 0.0, 12.0", False), ("12.0, 0.0, 0.0", True)])
def test_domain_integrals_need_one_material_in_the_plane_of_the_crack_alone(tmp_path, where, refused):
    """A layer of another material on top of the block is none in that plane, one at its side is."""
    base = "16.0, 16.0, 12.0" if where.endswith("12.0") else "12.0, 16.0, 16.0"
    (tmp_path / "layers.nml").write_text(ROUND.format(front="front = 'disc'  center = 8.0, 8.0, 6.0  radii = 4.0").replace("  shape = 'cylinder'  lower = 8.0, 8.0, 0.0  upper = 8.0, 8.0, 16.0  radius = 8.0",
                                         f"  lower = 0.0, 0.0, 0.0  upper = {base}") + f"&material name = 'b'  young = 7e9  density = 1000 /\n&body material = 'b'  lower = {where}  upper = 16.0, 16.0, 16.0 /\n")
    done = run(tmp_path, SOLID_PROGRAM, "layers.nml", "--check")
    assert done.returncode == (2 if refused else 0) and ("one material in the plane of the crack" in done.stderr) == refused, done.stderr


def test_a_body_under_balanced_loads_needs_nothing_to_hold_it(tmp_path):
    """All six motions as a whole are taken: the strain energy is that of a bar in tension, F²L/(2 E A)."""
    (tmp_path / "bar.nml").write_text("""
&run end_time = 1.0 /
&grid lower = -0.1, -0.1, -0.1  cell = 0.1  cells = 6, 4, 4 /
&material name = 'a'  young = 200e9  poisson = 0.3  density = 7800 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = 0.4, 0.2, 0.2 /
&load kind = 'traction'  lower = 0.4, 0.0, 0.0  upper = 0.4, 0.2, 0.2  force = 1e5, 0.0, 0.0 /
&load kind = 'traction'  lower = 0.0, 0.0, 0.0  upper = 0.0, 0.2, 0.2  force = -1e5, 0.0, 0.0 /
&method time = 'static'  frame = 'total' /
""")
    done = run(tmp_path, SOLID_PROGRAM, "bar.nml")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "bar.h5") as result:
        assert result["history/strain_energy"][-1] == pytest.approx(1e5**2 * 0.4 / (2 * 200e9 * 0.04), rel=1e-9)
        assert np.isfinite(result["history/external_work"][-1])


def test_a_run_ends_with_a_table_of_fronts(tmp_path):
    """As one of tips ends that of a plane: the means of the last row, and the error in percent."""
    done = subprocess.run([SOLID_PROGRAM, INPUT / "solid/plate.nml", "--set", "grid.cell=2.5e-3", "--set", "grid.cells=16,17,2", "--set", "refine.max_level=1"],
                          cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    heading = next(n for n, line in enumerate(lines) if line.split()[:3] == ["front", "mean", "G"])
    with h5py.File(tmp_path / "plate.h5") as result:
        mean, error, largest, k = (result[f"history/{name}"][-1] for name in ("G_mean", "G_mean_error", "G_largest", "K_I"))
    front, *shown = lines[heading + 1].replace(" %", "").split()
    assert front == "1" and list(map(float, shown)) == pytest.approx([mean, 100 * error / mean, largest, k], rel=1e-4, abs=0.05)
