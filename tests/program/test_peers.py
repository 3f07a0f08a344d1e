"""Those that the speed of a step is compared with (bench/peers/) compute the same motion as the program."""

import shutil
import subprocess
import sys
from importlib.util import find_spec

import pytest

from paths import BENCH, CHECKED_BENCH

sys.path.insert(0, str(BENCH / "peers"))

from scenes import Body, InC, library_in_c  # noqa: E402

STEPS, CELLS = 60, 32


def energies_of_program(motion, frame="updated"):
    """Kinetic and strain energy [J] after the steps."""
    line = subprocess.run([CHECKED_BENCH, "steps", str(STEPS), f"program:{frame}:usf:{CELLS}:1:{motion}"], capture_output=True,
                          text=True, check=True).stdout
    return [float(word) for word in line.split()[2:]]


@pytest.mark.skipif(not CHECKED_BENCH.exists(), reason="no checked build")
@pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler")
@pytest.mark.parametrize("motion", ["smooth", "turning"])
def test_c_computes_the_same_motion(motion, tmp_path):
    peer = InC(Body(CELLS, motion), library_in_c(tmp_path))
    peer.steps(STEPS)
    assert peer.energies() == pytest.approx(energies_of_program(motion), rel=1e-10)


@pytest.mark.skipif(not CHECKED_BENCH.exists(), reason="no checked build")
@pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler")
def test_elements_in_c_compute_the_same_motion(tmp_path):
    peer = InC(Body(CELLS, "smooth"), library_in_c(tmp_path, "element_step"))
    peer.steps(STEPS)
    assert peer.energies() == pytest.approx(energies_of_program("smooth", "total"), rel=1e-10)


@pytest.mark.skipif(not CHECKED_BENCH.exists(), reason="no checked build")
@pytest.mark.skipif(not find_spec("numba"), reason="numba is not installed: make -C bench peers does that")
@pytest.mark.parametrize("motion", ["smooth", "turning"])
def test_numba_computes_the_same_motion(motion):
    """In a process of its own: numba looks for modules of names that those of tools/ have too."""
    code = f"from scenes import *; peer = InNumba(Body({CELLS}, '{motion}')); peer.steps({STEPS}); print(*peer.energies())"
    line = subprocess.run([sys.executable, "-c", code], cwd=BENCH / "peers", capture_output=True, text=True, check=True).stdout
    assert [float(word) for word in line.split()] == pytest.approx(energies_of_program(motion), rel=1e-10)
