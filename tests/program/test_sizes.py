"""What a model may have many of costs in proportion to how many there are: scenes of bench/sizes.py, by instructions, which do not depend on how busy the machine is."""

import math
import sys

import pytest

from paths import BENCH, PROGRAM

sys.path.insert(0, str(BENCH))

import sizes  # noqa: E402
from instructions import can_count, run_counted  # noqa: E402

COUNTED = {"bodies": (16, 256, 1024), "boxes": (10, 50, 250), "segments": (10, 40, 160), "faces": (50, 150, 450), "table": (10, 400, 1600)}
MOST = 1.3  # of such small sizes: the factor of a stiffness grows by 1.2 to 1.5, and more faces take more iterations


def test_a_model_may_have_thousands_of_groups_and_values(hampm):
    for name, size in (("bodies", 4096), ("segments", 1000), ("table", 10000), ("meeting", 16)):
        (hampm.folder / "run.nml").write_text(getattr(sizes, name)(size))
        result = hampm("run.nml", "--check")
        assert result.returncode == 0, result.stderr


@pytest.mark.verify
@pytest.mark.skipif(not can_count(), reason="valgrind is not installed")
@pytest.mark.parametrize("name", COUNTED)
def test_cost_is_in_proportion_to_the_number(name, tmp_path):
    counts = []
    for size in COUNTED[name]:
        (tmp_path / "run.nml").write_text(getattr(sizes, name)(size))
        counts.append(run_counted(PROGRAM, tmp_path / "run.nml", "--output", tmp_path, "--quiet", "--force", "--threads", "1")[1])
    exponent = math.log((counts[2] - counts[0]) / (counts[1] - counts[0])) / math.log(COUNTED[name][2] / COUNTED[name][1])
    print(f"{name}: {counts} instructions for {COUNTED[name]}, exponent {exponent:.2f}")
    assert exponent <= MOST
