"""The program for solids (`make program dim=3`): bodies in space, at rest and in motion, beside the plane program and closed forms."""

import itertools
import subprocess

import h5py
import numpy as np
import pytest
from paths import PROGRAM, SOLID_PROGRAM

pytestmark = pytest.mark.skipif(not SOLID_PROGRAM.exists(), reason="make program build=quick dim=3 makes it")

PLATE = """
&run end_time = 4e-4  plane = 'strain'{thickness} /
&grid lower = -0.05, -0.05{z0}  cell = 0.05  cells = 8, 4{n} /
&material name = 'a'  young = 200.0e9  poisson = 0.3  density = 7800.0{law} /
&body material = 'a'  lower = 0.0, 0.0{z0}  upper = 0.3, 0.1{z1} /
&constraint lower = 0.0, 0.0{z0}  upper = 0.0, 0.1{z1}  fix = 'xy' /
{rollers}
&load kind = 'traction'  lower = 0.3, 0.0{z0}  upper = 0.3, 0.1{z1}  force = 0.0, 1.0e4{z0}  history = 'ramp'  rise_time = 2e-4 /
&method {method} /
&output file = 'case.h5'  history_interval = 4e-5 /
"""
IN_PLANE = {"thickness": "  thickness = 0.05", "z0": "", "z1": "", "n": "", "rollers": ""}
IN_SPACE = {"thickness": "", "z0": ", 0.0", "z1": ", 0.05", "n": ", 1",
            "rollers": "&constraint lower = 0.0, 0.0, 0.0  upper = 0.3, 0.1, 0.05  fix = 'z' /"}
STEPS = "courant = 0.2"


def run(folder, program, text):
    folder.mkdir()
    (folder / "case.nml").write_text(text)
    result = subprocess.run([program, "case.nml", "--quiet"], cwd=folder, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    return h5py.File(folder / "case.h5")


@pytest.mark.parametrize(("method", "law"), [
    ("time = 'static'", ""), ("time = 'implicit'  time_step = 4e-6", ""), (f"time = 'explicit'  frame = 'total'  {STEPS}", ""),
    (f"time = 'explicit'  frame = 'updated'  {STEPS}", ""), (f"scheme = 'usl'  {STEPS}", ""), (f"mass = 'consistent'  {STEPS}", ""),
    (f"mass = 'fmpm'  {STEPS}", ""), (f"path = 'reference'  frame = 'total'  {STEPS}", ""),
    ("time = 'static'", "  law = 'neo_hookean'"), (f"frame = 'updated'  {STEPS}", "  law = 'neo_hookean'"),
    (f"frame = 'updated'  {STEPS}", "  law = 'j2_plastic'  yield_stress = 5.0e6  hardening = 1.0e9"),
    (f"frame = 'updated'  {STEPS}", "  law = 'viscoelastic'  moduli = 0.3  relaxation_times = 1e-4")])
def test_a_slab_between_rollers_is_plane_strain(tmp_path, method, law):
    """One cell thick, with u_z = 0 on both sides: all energies of the plane program, to rounding."""
    plane = run(tmp_path / "plane", PROGRAM, PLATE.format(method=method, law=law, **IN_PLANE))
    solid = run(tmp_path / "solid", SOLID_PROGRAM, PLATE.format(method=method, law=law, **IN_SPACE))
    scale = np.max(np.abs(plane["history/external_work"]))
    for column in ("strain_energy", "kinetic_energy", "external_work"):
        assert np.max(np.abs(solid[f"history/{column}"][:] - plane[f"history/{column}"][:])) < 1e-11 * scale, column


BLOCK = """
&run end_time = 1.0 /
&grid lower = {grid}  cell = 0.05  cells = {cells} /
&material name = 'a'  law = '{law}'  young = 200.0e9  poisson = 0.3  density = 7800.0 /
&body material = 'a'  lower = 0.0, 0.0, 0.0  upper = {upper} /
{planes}
&load kind = 'traction'  lower = {end}  upper = {upper}  force = {force} /
&refine indicator = 'gradient'  field = 'energy_density'  r_crit = 1e-17  max_level = 2  region_lower = {fine}  region_upper = {coarse} /
&method time = 'static'  frame = 'total' /
&output file = 'case.h5'  snapshot_interval = 1.0 /
"""


def vector(values):
    return ", ".join(str(float(value)) for value in values)


def block(axes, law="linear_elastic", region=((0.1, 0.0, 0.0), (0.15, 0.06, 0.06))):
    """A bar under tension with finer cells in a corner of it, its axes exchanged."""
    exchanged = lambda values: [values[axes.index(d)] for d in range(3)]
    upper = exchanged((0.3, 0.1, 0.15))
    planes = "\n".join(f"&constraint lower = 0.0, 0.0, 0.0  upper = {vector(0 if d == k else upper[d] for d in range(3))}  fix = '{'xyz'[k]}' /"
                       for k in range(3))
    return BLOCK.format(grid=vector([-0.05] * 3), cells=", ".join(str(n) for n in exchanged((8, 4, 5))), upper=vector(upper), planes=planes, law=law,
                        end=vector(exchanged((0.3, 0.0, 0.0))), force=vector(exchanged((1.5e4, 0.0, 0.0))),
                        fine=vector(exchanged(region[0])), coarse=vector(exchanged(region[1])))


@pytest.mark.parametrize("region", [((0.1, 0.0, 0.0), (0.15, 0.06, 0.06)), ((0.0, 0.0, 0.0), (0.3, 0.1, 0.15)), ((0.25, 0.05, 0.05), (0.3, 0.1, 0.1))])
@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 2, 0)])
def test_uniform_stress_on_octrees_is_exact(tmp_path, axes, region):
    """Transition cells with nodes on sides and edges hold every linear field, tractions follow the particles that split, and axes are alike."""
    file = run(tmp_path / "block", SOLID_PROGRAM, block(axes, region=region))
    fields = file["VTKHDF/particles/PointData"]
    last = int(file["VTKHDF/particles/NumberOfPoints"][-1])
    assert last > 1000
    for a, b in itertools.combinations_with_replacement(range(3), 2):
        stress = fields["stress_" + "xyz"[a] + "xyz"[b]][-last:]
        asked = 1.0e6 if a == b == axes[0] else 0.0
        assert np.max(np.abs(stress - asked)) < 1e-3, (a, b)


def test_stress_of_a_finite_strain_law(tmp_path):
    """A neo-Hookean bar is stressed by its force over its area, as in the plane."""
    file = run(tmp_path / "block", SOLID_PROGRAM, block((0, 1, 2), law="neo_hookean"))
    work = file["history/external_work"][-1]
    assert work == pytest.approx(0.5 * 1.5e4 * 0.3 * 1.0e6 / 200.0e9, rel=1e-4)
