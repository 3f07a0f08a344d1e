"""What the README promises: the scene in eight lines runs, with the changes of it that are named."""

import re

import h5py
import pytest

from paths import ROOT

README = (ROOT / "README.md").read_text()
SCENE = re.search(r"^```fortran\n(.*?)^```", README, flags=re.S | re.M)[1]
GROWTH = re.search(r"`(&growth .*?/)`", README)[1]
STEPS = re.search(r"`(load_steps = \d+)`", README)[1]
MOTION = re.search(r"`(time = 'explicit')` and `(end_time = \S+)`", README)
SNAPSHOTS = re.search(r"`(&output .*?/)`", README)[1]
REST = "time = 'static'"
CHANGES = {
    "as it stands": SCENE,
    "it grows": SCENE.replace(REST, f"{REST}  {STEPS}") + GROWTH + "\n",
    "it moves": SCENE.replace(REST, MOTION[1]).replace("end_time = 1.0", MOTION[2]),  # of which the first steps are run
    "it is pictured": SCENE + SNAPSHOTS + "\n"}


def test_eight_lines():
    assert len(SCENE.splitlines()) == 8


@pytest.mark.parametrize("change", CHANGES)
def test_the_scene_runs(hampm, tmp_path, change):
    (tmp_path / "plate.nml").write_text(CHANGES[change])
    result = hampm("plate.nml", "--output", "results", "--quiet", *["--steps", 20] * (change == "it moves"), cwd=tmp_path)
    assert result.returncode == (5 if change == "it moves" else 0), result.stderr
    with h5py.File(tmp_path / "results/plate.h5") as file:
        assert {"K_I", "K_I_error", "K_II_tip2", "J_error"} <= set(file["history"])
        if change == "as it stands":
            assert all(file[f"history/K_I_error{tip}"][-1] <= 0.01 * file[f"history/K_I{tip}"][-1] for tip in ("", "_tip2"))
        assert ("VTKHDF" in file) == (change == "it is pictured")
        if change == "it grows":
            assert file["history/crack_length"][-1] > file["history/crack_length"][0]


def test_it_is_read_in_five_minutes():
    """At 250 words a minute, without what is typed and the names of files."""
    prose = re.sub(r"```.*?```|`[^`]*`|\]\([^)]*\)", " ", README, flags=re.S)
    assert len(re.findall(r"[A-Za-z]{2,}", prose)) < 5 * 250
