"""The package as a checker of types sees it."""

import subprocess
import sys

import pytest

from paths import ROOT

pytest.importorskip("mypy")
pytestmark = pytest.mark.xdist_group("mypy") # which fill one cache
CACHE = ROOT / "build/mypy"


def test_the_package_is_well_typed():
    """Strictly, by mypy, as python/pyproject.toml says."""
    found = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", CACHE], cwd=ROOT / "python", capture_output=True, text=True)
    assert found.returncode == 0, found.stdout + found.stderr


USER = """import hampm
scene = hampm.Scene("a.nml")
reveal_type(scene.grid.cell)
reveal_type(scene.load[0].force)
reveal_type(hampm.run(scene).value("K_I"))
scene.grid.set(cell="fine")
hampm.run(scene, thread=2)
hampm.Scenes()
"""


def test_users_are_told_what_they_get(tmp_path):
    """Types of keys and values, and mistakes in names, in the script of a user."""
    (tmp_path / "user.py").write_text(USER)
    found = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", CACHE, "--config-file", ROOT / "python/pyproject.toml", "user.py"], cwd=tmp_path,
                           capture_output=True, text=True, env={"MYPYPATH": str(ROOT / "python/src")})
    lines = {int(line.split(":")[1]): line for line in found.stdout.splitlines() if line.startswith("user.py")}
    assert '"builtins.float | None"' in lines[3] and "Sequence[builtins.float]" in lines[4] and '"tuple[builtins.float, builtins.float | None]"' in lines[5], found.stdout
    assert 'Unexpected keyword argument "thread"' in lines[7] and 'Module has no attribute "Scenes"' in lines[8]
