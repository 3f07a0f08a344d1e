"""docs/how-to/load_frames.md: its models run, end as it says, and go on to another end by its commands."""

import re

import h5py
import pytest

from paths import ROOT

PAGE = (ROOT / "docs/how-to/load_frames.md").read_text()
MODELS = dict(re.findall(r"^```fortran (\w+)\.nml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL))


def history(path):
    with h5py.File(path) as file:
        return {name: column[:] for name, column in file["history"].items()} | {"why": str(file["history"].attrs.get("stopped_when", ""))}


@pytest.mark.parametrize(("model", "length", "end"), [("frame", 48e-3, "12.0"), ("blow", 28e-3, "17e-6")])
def test_models_end_by_the_length_of_the_crack(hampm, model, length, end):
    (hampm.folder / f"{model}.nml").write_text(MODELS[model])
    result = hampm(f"{model}.nml")
    assert result.returncode == 0
    assert model == "blow" or "warning" not in result.stderr
    assert all("to branch" in line for line in result.stderr.splitlines() if "warning" in line), result.stderr
    row = history(hampm.folder / f"{model}.h5")
    assert row["why"].startswith("crack_length") and row["crack_length"][-1] >= length > row["crack_length"][-2]
    assert row["time"][-1] == pytest.approx(float(end), rel=0.02)
    if model == "frame":  # loaded, unloaded and loaded again along a line while the crack stays
        grown = row["crack_length"] - row["crack_length"][0]
        assert grown[3] > 0 and (grown[6:11] == grown[6]).all() and grown[11] > grown[6]
        assert row["load"][6:11] == pytest.approx(row["load_displacement"][6:11] * row["load"][6] / row["load_displacement"][6], rel=1e-9)
        assert row["load"] == pytest.approx(row["load_arms_y"], rel=1e-9) and row["load_displacement"] == pytest.approx(row["load_displacement_arms_y"], rel=1e-9, abs=1e-18)
    else:
        return
    stopped = hampm("frame.nml", "--force", "--steps", 8)
    assert stopped.returncode == 5
    assert hampm("--resume", "frame.h5.checkpoint", "--set", "run.end_time=20.0", "--set", "method.load_steps=20").returncode == 0
    again = history(hampm.folder / "frame.h5")
    assert again["crack_length"].tobytes() == row["crack_length"].tobytes()
