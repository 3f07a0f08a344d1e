"""Every model of input/ runs to its end, if shortened: one load step, or a fiftieth of its time, and coarser cells where these take long."""

import re

import numpy as np
import pytest
from harness import run
from paths import INPUT

MODELS = sorted(path.relative_to(INPUT).as_posix()[:-4] for path in INPUT.rglob("*.nml"))
COARSER = {
    "chen": ("grid.cell=0.2e-3", "grid.cells=51,101"),
    "compact_tension_growth": ("refine.max_level=1", "run.end_time=4.0"),
    "dcb_cohesive": ("grid.cell=1e-3", "grid.cells=66,8", "method.load_steps=10"),
    "els": ("grid.cell=1e-3", "grid.cells=104,8"),
    "fatigue_centre_crack": ("refine.max_level=1",),
    "fatigue_eccentric_crack": ("refine.max_level=1", "growth.increment=2e-3"),
    "fatigue_hole": ("refine.max_level=1",),
    "freund": ("grid.cell=0.2e-3", "grid.cells=100,51"),
    "hole_growth": ("refine.max_level=1",),
    "in_situ_stress": ("grid.lower=-128e-3,-128e-3", "grid.cell=8e-3", "grid.cells=32,32", "refine.max_level=2"),
    "interface_crack": ("grid.cell=1.0", "grid.cells=42,42", "refine.max_level=1"),
    "laminate_cracks": ("grid.cell=125e-6", "grid.cells=64,14"),
    "laminate_enf": ("grid.cell=0.5e-3", "grid.cells=220,9", "refine.max_level=1"),
    "laminate_mmb_growth": ("grid.cell=0.5e-3", "grid.cells=220,9", "refine.max_level=1"),
    "merging_cracks": ("refine.max_level=1", "growth(1).increment=2e-3", "growth(2).increment=2e-3"),
    "plastic_notch": ("grid.cell=1e-3", "grid.cells=17,33", "run.end_time=0.3"),
    "solid/dcb": ("grid.cell=2.5e-3", "grid.cells=40,5,2"),
    "solid/fatigue_ellipse": ("refine.rings=2",),
    "solid/plate": ("grid.cell=2.5e-3", "grid.cells=16,17,2"),
    "strain_gauge": ("grid.cell=1e-3", "grid.cells=100,51"),
    "two_cracks": ("refine.max_level=1", "growth(1).increment=2e-3", "growth(2).increment=2e-3"),
    "v_notch": ("refine.max_level=7", "nucleation.increment=15.625e-6", "growth.increment=31.25e-6"),
    "wedge_dcb": ("refine.max_level=0",),
    "wing_cracks": ("grid.cell=2e-3", "grid.cells=45,50", "growth.increment=4.4e-3"),
    "zigzag": ("refine.max_level=0",)}


def shorter(model, text):
    """What makes a model shorter: at rest a load step and, where nothing grows, one level of finer cells; in motion less time."""
    text = re.sub("!.*", "", text)
    settings = ["output.snapshot_interval=0"]
    if re.search(r"\btime = 'static'", text):
        settings += ["method.load_steps=1"] * ("load_steps" in text) + ["refine.max_level=1"] * ("max_level" in text and "&growth" not in text)
    else:
        end = float(re.search(r"end_time = (\S+)", text)[1])
        settings.append(f"run.end_time={end / 50!r}")
    return *settings, *COARSER.get(model, ())


FOUND = {"bend_path", "dcb_growth", "dcb_snap_back", "els", "hole_growth", "in_situ_stress", "merging_cracks", "peeling_film", "two_cracks", "v_notch", "wing_cracks"}  # loads by the toughness


@pytest.mark.parametrize("model", MODELS)
def test_a_model_runs_to_its_end(request, hampm, model):
    """Where loads are found at which a crack grows the largest G is the toughness."""
    path = INPUT / f"{model}.nml"
    text = path.read_text()
    row = run(request.getfixturevalue("hampm3d") if model.startswith("solid/") else hampm, path, *shorter(model, text))
    assert np.all(np.diff(row["time"]) >= 0)
    if model in FOUND:
        largest = max(row[name][-1] for name in row if re.fullmatch(r"G(_tip\d+)?", name))
        assert largest == pytest.approx(float(re.search(r"toughness = (\S+)", text)[1]), rel=1e-4)
