"""The step in C that the speed of a step is compared with (bench/peers/) computes the same motion as the program."""

import shutil
import subprocess
import sys

import pytest

from paths import BENCH, CHECKED_BENCH

sys.path.insert(0, str(BENCH / "peers"))

from scenes import Body, InC, library_in_c  # noqa: E402

STEPS, CELLS = 60, 32


def energies_of_program():
    """Kinetic and strain energy [J] after the steps."""
    line = subprocess.run([CHECKED_BENCH, "steps", str(STEPS), f"program:total:usf:{CELLS}:1"], capture_output=True,
                          text=True, check=True).stdout
    return [float(word) for word in line.split()[2:]]


@pytest.mark.skipif(not CHECKED_BENCH.exists(), reason="no checked build")
@pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler")
def test_elements_in_c_compute_the_same_motion(tmp_path):
    peer = InC(Body(CELLS), library_in_c(tmp_path))
    peer.steps(STEPS)
    assert peer.energies() == pytest.approx(energies_of_program(), rel=1e-10)
