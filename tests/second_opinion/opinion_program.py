"""Runs of the program: the last row of the history of a model, also with finer cells."""

import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import f90nml
import h5py

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("HAMPM", ROOT / "build/release/hampm"))
LONGEST = 120          # that a run may take [s]
MANY = "200000"        # particles


@dataclass
class Run:
    """The end of a run."""

    code: int
    said: str
    row: dict


def run(path, *settings, program=PROGRAM):
    """The last row that a model leaves, with `settings` as of --set."""
    with tempfile.TemporaryDirectory() as folder:
        words = [word for one in (*settings, "output.file=case.h5") for word in ("--set", one)]
        try:
            ended = subprocess.run([program, path, "--quiet", "--output", folder, "--threads", "1", *words], capture_output=True, text=True, errors="replace", timeout=LONGEST,
                                   env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"})
        except subprocess.TimeoutExpired:
            return Run(-1, f"has not ended after {LONGEST} s", {})
        row, file = {}, Path(folder) / "case.h5"
        if ended.returncode == 0 and file.exists():
            with h5py.File(file) as data:
                row = {name: float(values[-1]) for name, values in data["history"].items() if len(values)}
        return Run(ended.returncode, ended.stderr.strip(), row)


def finer(path, times):
    """Settings by which a model has cells of 1/times of their size."""
    model = f90nml.read(path)
    grid, cells = model["grid"], model["grid"]["cells"]
    return [f"grid.cell={grid['cell'] / times!r}", f"grid.cells={cells[0] * times},{cells[1] * times}"] + ([f"refine.max_particles={MANY}"] if "refine" in model else [])
