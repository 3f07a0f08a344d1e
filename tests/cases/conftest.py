"""Scenes of this folder, run in the build with all checks and traps."""

from pathlib import Path
from types import SimpleNamespace

import h5py
import pytest

from paths import CHECKED_PROGRAM

CASES = Path(__file__).parent


@pytest.fixture
def case(run_hampm, tmp_path):
    """`case(name, *options, program=..., text=None)` runs a scene: its exit code, what it wrote to `stdout` and `stderr`, the columns `row` of its history where
    there is a result, and the `path` of that. `text` replaces the text of the scene."""
    def run(name, *options, program=CHECKED_PROGRAM, text=None, **keywords):
        scene = tmp_path / f"{name}.nml"
        scene.write_text((CASES / f"{name}.nml").read_text() if text is None else text)
        result = run_hampm(scene.name, "--force", "--output", "out", "--set", f"output.file={name}.h5", *options, cwd=tmp_path, program=program, **keywords)
        path = tmp_path / "out" / f"{name}.h5"
        row = None
        if path.exists():
            with h5py.File(path) as file:
                row = {column: values[:] for column, values in file["history"].items()}
        return SimpleNamespace(code=result.returncode, stdout=result.stdout, stderr=result.stderr, row=row, path=path)
    return run


@pytest.fixture
def text_of():
    """The text of a scene of this folder."""
    return lambda name: (CASES / f"{name}.nml").read_text()
