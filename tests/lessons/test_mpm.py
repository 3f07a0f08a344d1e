"""The step in numpy, docs/lessons/mpm.py, against hampm: the models of lessons 1 to 5 and 7, with the schemes and mass matrices that these have."""

import re
import sys

import h5py
import numpy as np
import pytest

from hampm import History
from paths import ROOT

sys.path.append(str(ROOT / "docs/lessons"))

import mpm  # noqa: E402

SHORT = ["run.end_time=10", "output.snapshot_interval=10"]  # the wave has passed 10 cells; all of lesson 4 is more of the same
RUNS = [("1_material_point", []), ("2_mapping", []), ("2_mapping", ["method.mass=fmpm"]), ("2_mapping", ["method.mass=consistent"]),
        *(("3_energy", [f"method.scheme={scheme}"]) for scheme in ("usf", "usl", "musl", "usavg")),
        ("3_energy", ["method.scheme=usl", "method.courant=0.05"]), ("3_energy", ["method.scheme=usl", "method.mass=consistent"]),
        ("4_waves", SHORT), ("4_waves", [*SHORT, "method.mass=consistent"]), ("4_waves", [*SHORT, "method.mass=weighted", "method.lumped_fraction=0.27778"]),
        ("5_time_step", []), ("5_time_step", ["method.scheme=usl", "method.courant=0.74", "output.history_interval=0.74"]),
        ("5_time_step", ["method.mass=consistent", "method.courant=0.40", "output.history_interval=0.40"])]
LAST = {"3_energy": ["output.snapshot_interval=28"], "5_time_step": ["output.snapshot_interval=100"]}
BEAM = ["grid.cell=5e-3", "grid.cells=20,3"]
ROUNDING = 1e-12


@pytest.mark.parametrize("name, settings", RUNS)
def test_every_sample_is_that_of_hampm(hampm, name, settings):
    model = ROOT / f"docs/lessons/{name}.nml"
    words = [word for setting in (*settings, *LAST.get(name, []), "output.file=run.h5") for word in ("--set", setting)]
    result = hampm(model, "--quiet", *words)
    assert result.returncode == 0, result.stderr
    history, (samples, m) = History(hampm.folder / "run.h5"), mpm.run(model, *settings)
    assert samples[:, 0] == pytest.approx(history.times, rel=ROUNDING)
    size = max(np.max(np.abs(history[column])) for column in ("kinetic_energy", "strain_energy"))  # lesson 1 has no strain but rounding
    for k, column in enumerate(("kinetic_energy", "strain_energy", "external_work"), start=1):
        assert samples[:, k] == pytest.approx(history[column], rel=0, abs=ROUNDING * size), column
    with h5py.File(hampm.folder / "run.h5") as file:
        particles = file["VTKHDF/particles"]
        last = particles["NumberOfPoints"][-1]
        order = np.argsort(particles["PointData/id"][-last:])
        for field in "displacement", "velocity":
            asked = particles["PointData"][field][-last:][order][:, :2]
            assert getattr(m.particles, field) == pytest.approx(asked, rel=0, abs=ROUNDING * np.max(np.abs(asked))), field


@pytest.mark.parametrize("settings", [[], ["method.frame=updated"], ["method.scheme=usavg"]])
def test_the_beam_of_lesson_7_has_the_same_g(hampm, settings):
    """Damping, and closure at the tip: as G oscillates, and where the beam has come to rest."""
    model = ROOT / "docs/lessons/7_energy_release_rate.nml"
    words = [word for setting in (*settings, *BEAM, "output.file=run.h5") for word in ("--set", setting)]
    assert hampm(model, "--quiet", *words).returncode == 0
    history, (samples, _) = History(hampm.folder / "run.h5"), mpm.run(model, *settings, *BEAM)
    for k, column in enumerate(("kinetic_energy", "strain_energy", "external_work", "G_vcct_I"), start=1):
        assert samples[:, k] == pytest.approx(history[column], rel=0, abs=1e-9 * np.max(np.abs(history[column]))), column


@pytest.mark.parametrize("name, settings, word", [("3_energy", ["material.law=neo_hookean"], "law = neo_hookean"), ("15_crossing_cells", [], "history = ramp"), ("4_waves", ["load.history=ramp"], "history = ramp"),
                                                  ("3_energy", ["refine.indicator=tip"], "refine indicator = tip")])
def test_what_is_not_read_is_refused(name, settings, word):
    with pytest.raises(ValueError, match=word):
        mpm.run(ROOT / f"docs/lessons/{name}.nml", *settings)


def test_names_and_order_are_those_of_the_readable_step():
    """Each of its procedures that the step in numpy has too is there under the same name, and called in the same order."""
    fortran, python = (ROOT / "src/time/reference_step.f90").read_text(), (ROOT / "docs/lessons/mpm.py").read_text()
    names = ["map_velocity", "strain", "map_force", "strain", "map_velocity", "strain"]

    def called(text, prefix):
        return re.findall(prefix + r"\b(map_velocity|map_force|strain)\(m", text)
    step = fortran[fortran.index("subroutine reference_step"):fortran.index("end subroutine reference_step")]
    mine = python[python.index("def reference_step"):python.index("def functions_at")]
    # usf, and half of usavg, are two calls there
    assert [name for k, name in enumerate(called(step, "call ")) if k != 1] == called(mine, "") == names
