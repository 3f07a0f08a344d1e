"""Time steps that fit the size of the cells by leapfrog steps, in the total frame: rest, work, and outputs of all kinds (docs/explanation/local_time_steps.md)."""

import functools
import numpy as np
import pytest

import harness
from paths import REGRESSION

BEAM = REGRESSION / "dcb_refined/case.nml"
LOCAL = ("method.frame=total", "method.time_steps=local", "energy_release.estimators='vcct','domain_integral'", "energy_release.energy_balance=.false.")
COMMON = (*LOCAL, "method.time_steps=global")
# A plate in plane strain of two materials, one of them oblique, with a crack between them from one side, that rests on an edge
PLATE = """\
&run plane = 'strain'  thickness = 0.01  end_time = 4e-4 /
&grid lower = -2e-3, -2e-3  cell = 1e-3  cells = 24, 20 /
&material name = 'a'  young = 3e9  poisson = 0.45  density = 1200 /
&material name = 'b'  law = 'orthotropic'  young_1 = 9e9  young_2 = 4e9  young_3 = 4e9  shear_12 = 1.5e9  poisson_12 = 0.3
          poisson_13 = 0.3  poisson_23 = 0.3  angle = 30  density = 1500 /
&body material = 'a'  lower = 0, 0  upper = 0.02, 8e-3 /
&body material = 'b'  lower = 0, 8e-3  upper = 0.02, 0.016 /
&constraint lower = 0, 0  upper = 0.02, 0  fix = 'xy' /
&load kind = 'traction'  lower = 0, 0.016  upper = 0.02, 0.016  force = 20, 100  history = 'ramp'  rise_time = 3e-5 /
&load kind = 'gravity'  acceleration = 0, -1e3 /
&damping rate = 1.2e5 /
&refine indicator = 'tip'  rings = 2  max_level = 3 /
&crack kind = 'line'  tip = 8e-3, 4e-3  length = 8e-3 /
&output history_interval = 4e-6 /
"""


@pytest.fixture
def history(hampm):
    """`history(model, *settings)` runs it: its row."""
    return functools.partial(harness.run, hampm)


def test_a_beam_comes_to_the_rest_of_common_steps(history):
    """The beam of docs/explanation/local_time_steps.md with one level and two rings less."""
    settings = ("refine.max_level=5", "refine.rings=2", "run.end_time=1.6e-3", "output.history_interval=1e-5")
    local, common = history(BEAM, *LOCAL, *settings), history(BEAM, *COMMON, *settings)
    for name in ("G_vcct_I", "J"):
        assert local[name][-1] == pytest.approx(common[name][-1], rel=1e-5)  # asked 1e-4
    assert local["kinetic_energy"][-1] < 1e-7 * local["strain_energy"][-1]
    error = local["kinetic_energy"] + local["strain_energy"] + local["damping_loss"] - local["external_work"]
    # at a sudden load kinetic energy in the middle of long steps lags behind; what is left at rest is of the first step
    assert np.max(np.abs(error)) < 5e-3 * local["external_work"][-1] and abs(error[-1]) < 1e-3 * local["external_work"][-1]


def test_loads_that_vary_do_the_work_of_common_steps_to_the_second_order(history):
    """Each group of cells has the load of its own steps: what the work is off by falls with their square."""
    scene = PLATE.replace("history = 'ramp'  rise_time = 3e-5", "history = 'sine'  frequency = 1e4").replace("end_time = 4e-4", "end_time = 4e-5")
    off = []
    for courant in (0.36, 0.18):
        settings = ("method.frame=total", f"method.courant={courant}", "damping.rate=0", "energy_release.energy_balance=.false.")
        local, common = (history(scene, *settings, f"method.time_steps={steps}")["external_work"] for steps in ("local", "global"))
        off.append(np.max(np.abs(local - common)) / np.max(np.abs(common)))
    print("work off by", off, "order", np.log2(off[0] / off[1]))
    assert off[0] < 1e-3 and np.log2(off[0] / off[1]) > 1.6


def test_a_plate_of_two_materials_comes_to_the_rest_of_common_steps(history, tmp_path):
    (tmp_path / "plate.nml").write_text(PLATE)
    local, common = history("plate.nml", *LOCAL), history("plate.nml", *COMMON)
    for name in ("J", "K_I", "K_II", "G_vcct_I", "strain_energy", "external_work"):
        assert local[name][-1] == pytest.approx(common[name][-1], rel=1e-4), name
    # on the way there
    assert np.sqrt(np.mean((local["K_I"] - common["K_I"])**2)) < 0.01 * np.max(np.abs(common["K_I"]))


@pytest.mark.parametrize(("samples", "snapshots"), [("1e-6", "3.14159265358979e-6"), ("3.7e-6", "19e-6"), ("2e-6", "2e-3"), ("1.7e-5", "0")])
def test_outputs_leave_the_steps_equal(history, samples, snapshots):
    """An undamped beam under a sudden load, 3000 and more coarse steps: steps of changing length were unstable after some hundreds."""
    settings = ("refine.max_level=3", "refine.rings=2", "damping.rate=0", "run.end_time=2e-3", f"output.history_interval={samples}",
                f"output.snapshot_interval={snapshots}")
    columns = history(BEAM, *LOCAL, *settings)
    total = columns["kinetic_energy"] + columns["strain_energy"] - columns["external_work"]
    assert np.max(np.abs(total)) < 0.02 * np.max(columns["external_work"])
    n = len(total) // 4
    assert np.std(total[-n:]) < 1.5 * np.std(total[:n])


@pytest.mark.parametrize(("setting", "phrase"), [
    ("method.frame=updated", "requires frame = 'total': local steps use mass matrices"),
    ("refine.indicator=gradient", "is not allowed with &refine indicator = 'gradient': vibrations of small cells grow where the mesh changes"),
    ("refine.indicator=zz", "is not allowed with &refine indicator = 'zz'"),
    ("material.law=neo_hookean", "law = 'neo_hookean': local steps need a linear relation"),
], ids=lambda text: text.split("=")[0])
def test_what_is_refused(hampm, setting, phrase):
    words = [word for item in (*LOCAL, "method.courant=0", setting) for word in ("--set", item)]
    result = hampm(BEAM, "--check", *words)
    assert result.returncode == 2
    assert result.stderr.count("time_steps = 'local'") == 1 and phrase in result.stderr and "'global'" in result.stderr + "'global'" * ("frame" in setting)


def test_steps_up_to_nine_tenths_of_the_common_limit_are_allowed(hampm):
    limits = {}
    for steps in ("global", "local"):
        words = [word for setting in (*LOCAL, f"method.time_steps={steps}", "damping.rate=0", "method.courant=9") for word in ("--set", setting)]
        limits[steps] = float(hampm(BEAM, "--check", *words).stderr.split("must be at most ")[1].split(",")[0])
    assert limits["local"] == pytest.approx(0.9 * limits["global"], rel=2e-3)
